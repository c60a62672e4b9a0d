//! The undrained wave in a column: soil and water move as one, `c_u = sqrt((M + Q)/rho)`, under a load that grows linearly.
//!
//! Assumptions: no drainage at all (k -> 0), small strain, a free top under the load and a rigid base. The total stress at
//! the depth z is the sum of what has run there, down from the top and up from the base, which sends the wave back with its
//! sign and the top against it (d'Alembert): `sum_j (-1)^j [f(t - (2 j H + z)/c_u) + f(t - (2 (j + 1) H - z)/c_u)]`.
//! The water carries the share Q/(M + Q). Source: Graff, *Wave Motion in Elastic Solids*, 1975, section 2.2.

use mpm_core::scene::Scene;

/// A column and its load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UndrainedWave {
    /// Height H, m.
    pub height: f64,
    /// Speed c_u, m/s.
    pub speed: f64,
    /// Load q, Pa.
    pub load: f64,
    /// Time over which it grows, s.
    pub ramp: f64,
    /// Share of a stress that the water carries, Q/(M + Q).
    pub share: f64,
}

impl UndrainedWave {
    /// The column of a scene; `None` if it is dry or bears no load.
    pub fn new(scene: &Scene) -> Option<Self> {
        let load = scene.surcharge?;
        scene.water?;
        let stiffness = scene.oedometer_modulus() + scene.pore_stiffness();
        Some(Self {
            height: scene.height,
            speed: (stiffness / scene.mixture_density()).sqrt(),
            load: load.pressure,
            ramp: load.ramp_time,
            share: scene.undrained_share(),
        })
    }

    fn load_at(&self, time: f64) -> f64 {
        if time <= 0.0 { 0.0 } else { self.load * (time / self.ramp).min(1.0) }
    }

    /// Pore pressure at a height above the base (m) and a time (s), Pa.
    pub fn pressure(&self, height: f64, time: f64) -> f64 {
        let (depth, way) = (self.height - height, self.speed * time);
        let mut stress = 0.0;
        let (mut sign, mut gone) = (1.0, 0.0);
        while gone < way {
            let run = |distance: f64| self.load_at(time - distance / self.speed);
            stress += sign * (run(gone + depth) + run(gone + 2.0 * self.height - depth));
            (sign, gone) = (-sign, gone + 2.0 * self.height);
        }
        self.share * stress
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::oracle::Table;

    #[test]
    fn it_is_the_table() {
        let scene = crate::scenes::built_in("undrained-wave").expect("holds");
        let wave = UndrainedWave::new(&scene).expect("a column");
        let rows = Table::read("04_dynamic_undrained_mid_rhog.csv").rows(["t_s", "ramp_p_Pa"]);
        let off = |wave: &UndrainedWave| {
            rows.iter().map(|row| (wave.pressure(0.5, row[0]) - row[1]).abs()).fold(0.0, f64::max)
        };
        assert!(off(&wave) < 1e-8, "{}", off(&wave));
        assert!(off(&UndrainedWave { speed: 1.001 * wave.speed, ..wave }) > 1.0);
    }
}

//! One-dimensional consolidation under the own weight, which comes at t = 0, with compressible water.
//!
//! Assumptions: small strain, linear elastic skeleton, incompressible grains, Darcy's law, no inertia; drained top, tight
//! base. Of the weight of the mixture the water first carries the share `B_1 = Q/(M + Q)`; what is above the hydrostatic
//! pressure, `e = p - rho_w g z` at the depth z, starts at `A z` with `A = (B_1 rho - rho_w) g` and drains as
//! `e = 2 A H sum sin(m)/m^2 sin(m z/H) exp(-m^2 T)`, m = (j + 1/2) pi, T = c t/H^2, c = (k/gamma_w)/(1/M + 1/Q), so
//! `S = [(rho - rho_w) g H^2/2 - 2 A H^2 sum sin(m)/m^3 exp(-m^2 T)]/M`.
//!
//! Sources: Terzaghi & Fröhlich 1936; Carslaw & Jaeger 1959, section 3.3.

use std::f64::consts::PI;

use mpm_core::scene::Scene;

/// A column that consolidates under its weight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelfWeight {
    /// Height H, m.
    pub height: f64,
    /// Oedometer modulus M, Pa.
    pub modulus: f64,
    /// Coefficient of consolidation c, m2/s.
    pub coefficient: f64,
    /// (rho - rho_w) g, N/m3.
    pub buoyant: f64,
    /// A, Pa/m.
    pub excess: f64,
    /// rho_w g, N/m3.
    pub water: f64,
}

/// Terms that have decayed by more than this exponent no longer count.
const SPENT: f64 = 45.0;

impl SelfWeight {
    /// The column of a scene; `None` if it is dry or without gravity, carries a load, or does not drain at the top alone.
    pub fn new(scene: &Scene) -> Option<Self> {
        let (water, gravity) = (scene.water?, scene.gravity?);
        let drained = scene.stages.iter().all(|stage| stage.drained == [false, false, false, true]);
        if !drained || scene.surcharge.is_some() || !scene.is_plain_column() {
            return None;
        }
        let (modulus, density) = (scene.oedometer_modulus(), scene.mixture_density());
        let storage = 1.0 / modulus + 1.0 / scene.pore_stiffness();
        Some(Self {
            height: scene.height,
            modulus,
            coefficient: water.mobility() / storage,
            buoyant: (density - water.density) * gravity,
            excess: (scene.undrained_share() * density - water.density) * gravity,
            water: water.density * gravity,
        })
    }

    /// T = c t/H^2.
    pub fn time_factor(&self, time: f64) -> f64 {
        self.coefficient * time / (self.height * self.height)
    }

    /// Sum of `term(m, sin m) exp(-m^2 T)`.
    fn sum(&self, time: f64, term: impl Fn(f64, f64) -> f64) -> f64 {
        let t = self.time_factor(time);
        let roots = (0..100_000).map(|j| ((f64::from(j) + 0.5) * PI, if j % 2 == 0 { 1.0 } else { -1.0 }));
        roots.take_while(|(m, _)| m * m * t < SPENT).map(|(m, sin)| term(m, sin) * (-m * m * t).exp()).sum()
    }

    /// Settlement of the surface at a time (s), m, from the unloaded column.
    pub fn settlement(&self, time: f64) -> f64 {
        let left = 2.0 * self.excess * self.sum(time, |m, sin| sin / (m * m * m));
        (0.5 * self.buoyant - left) * self.height * self.height / self.modulus
    }

    /// Settlement once the excess has drained, m.
    pub fn final_settlement(&self) -> f64 {
        0.5 * self.buoyant * self.height * self.height / self.modulus
    }

    /// Pore pressure at a height above the base (m) and a time (s), Pa.
    pub fn pressure(&self, height: f64, time: f64) -> f64 {
        let depth = self.height - height;
        let excess = self.sum(time, |m, sin| sin / (m * m) * (m * depth / self.height).sin());
        self.water * depth + 2.0 * self.excess * self.height * excess
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::oracle::Table;

    /// Largest differences of settlement and base pressure from the table, as shares.
    fn off(porosity: f64) -> [f64; 2] {
        let scene = crate::scenes::built_in("self-weight-consolidation")
            .expect("holds")
            .edited(|scene| scene.porosity = porosity)
            .expect("a sound scene");
        let exact = SelfWeight::new(&scene).expect("the table's column");
        let rows = Table::read("06_selfweight_S_rhog_compressible.csv").rows(["t_s", "S_m", "p_base_Pa"]);
        let late = rows.iter().filter(|row| exact.time_factor(row[0]) > 1e-3);
        let mut worst = [0.0_f64; 2];
        for row in late {
            worst[0] = worst[0].max((exact.settlement(row[0]) / row[1] - 1.0).abs());
            worst[1] = worst[1].max((exact.pressure(0.0, row[0]) / row[2] - 1.0).abs());
        }
        worst
    }

    #[test]
    fn it_is_the_table() {
        let worst = off(0.3);
        assert!(worst.iter().all(|w| *w < 1e-12), "{worst:?}");
        assert!(off(0.31)[0] > 1e-3, "the comparison can fail");
    }
}

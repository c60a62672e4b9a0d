//! Steady flow up through a column that a load has pressed together, where conductivity goes with the pores (Kozeny 1927, Carman 1937).
//!
//! With the stretch J of the soil, `sigma' = -M ln J = q - p` (Cauchy stress) and grains that do not compress, `1 - n = (1 - n_0)/J`:
//!
//! ```text
//! k = k_0 f(J),  f = (J - 1 + n_0)^3/(n_0^3 J),        v = -(k/gamma_w) dp/dy,   dy = -J da
//! dp/da = v gamma_w J/(k_0 f(J) r),   r = exp(p/K_w),   p = 0 at the top, a = 0
//! ```
//!
//! in the depth a of the undeformed column; integrated by the classical Runge-Kutta method. v is that of water under no pressure.
//! Assumptions: no weight, no inertia, linear elastic soil in its logarithmic strain.

use mpm_core::scene::Scene;

/// Steps of the integration over the height.
const STEPS: u32 = 2000;

/// A column through which water rises at a steady rate.
#[derive(Debug, Clone, Copy)]
pub struct PressedPores {
    height: f64,
    /// Load q and modulus M, Pa.
    load: f64,
    modulus: f64,
    porosity: f64,
    /// v gamma_w/k_0, Pa/m.
    slope: f64,
    kozeny_carman: bool,
    /// K_w, Pa.
    stiffness: f64,
}

impl PressedPores {
    /// The column of a scene with one well that puts water in at the base; `None` for all else.
    pub fn of(scene: &Scene) -> Option<Self> {
        let (water, load, [well]) = (scene.water?, scene.surcharge?, &scene.wells[..]) else { return None };
        let drained = scene.stages.iter().all(|stage| stage.drained == [false, false, false, true]);
        let plain =
            !scene.has_several_soils() && scene.is_elastic() && scene.gravity.is_none() && scene.loads.is_empty();
        let slope = -well.rate / (scene.width * water.mobility());
        (drained && plain && scene.is_one_dimensional() && well.at[1] == 0.0).then_some(Self {
            height: scene.height,
            load: load.pressure,
            modulus: scene.oedometer_modulus(),
            porosity: scene.porosity,
            slope,
            kozeny_carman: water.fabric.kozeny_carman,
            stiffness: water.bulk_modulus,
        })
    }

    /// dp/da at a pressure (Pa), Pa/m.
    fn rate(&self, pressure: f64) -> f64 {
        let stretch = ((pressure - self.load) / self.modulus).exp();
        let pores = (stretch - 1.0 + self.porosity) / self.porosity;
        let conductivity = if self.kozeny_carman { pores.powi(3) / stretch } else { 1.0 };
        self.slope * stretch / (conductivity * (pressure / self.stiffness).exp())
    }

    /// Pore pressure at a height of the undeformed column (m), Pa.
    pub fn pressure(&self, height: f64) -> f64 {
        let step = (self.height - height) / f64::from(STEPS);
        (0..STEPS).fold(0.0, |p, _| {
            let a = self.rate(p);
            let b = self.rate(p + 0.5 * step * a);
            let c = self.rate(p + 0.5 * step * b);
            let d = self.rate(p + step * c);
            p + step / 6.0 * (a + 2.0 * (b + c) + d)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::built_in;

    /// With a load that is large beside the pressure the strain is uniform.
    #[test]
    fn little_water_finds_uniform_pores() {
        let scene = built_in("kozeny-carman").expect("a scene");
        let column = PressedPores::of(&scene).expect("a column");
        let little = PressedPores { slope: 1e-6 * column.slope, ..column };
        let stretch = (-column.load / column.modulus).exp();
        let n = 1.0 - (1.0 - 0.4) / stretch;
        let ratio = n.powi(3) / (1.0 - n).powi(2) / (0.4_f64.powi(3) / 0.36);
        let exact = little.slope * stretch / ratio;
        assert!((little.pressure(0.0) / exact - 1.0).abs() < 1e-7);
        assert!(ratio < 0.5);
    }
}

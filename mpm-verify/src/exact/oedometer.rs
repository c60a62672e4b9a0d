//! Mohr-Coulomb soil in an oedometer: compressed along one axis from no stress, held aside.
//!
//! Assumes small strain, a load that only grows, uniform stress and compression beyond `K_0 = nu/(1 - nu)`. With
//! compression positive, p vertical and l lateral, n1 = 1 + sin(phi), n3 = 1 - sin(phi), m1 and m3 the same of psi:
//!
//! - elastic, l = K_0 p and dp = M de, up to `p_y = 2 c cos(phi)/(n3 - K_0 n1)`;
//! - then on the edge s1 = s2, r = dl/dp = n3/n1. The lateral plastic strain undoes the elastic one, and brings
//!   `2 m3/m1` times as much along the axis: `de = dp [1 - 2 nu r + 2 (m3/m1) (r (1 - nu) - nu)]/E`.
//!
//! Derived here from the flow rule on the edge (de Souza Neto, Peric and Owen 2008, section 8.1.2).

use mpm_core::scene::{Elastic, Fields, Strength};

/// The soil.
#[derive(Debug, Clone, Copy)]
pub struct Oedometer {
    elastic: Elastic,
    /// p_y, Pa; infinite where friction holds the elastic path for ever.
    pub yield_pressure: f64,
    /// Modulus beyond it, Pa.
    pub plastic_modulus: f64,
    ratio: f64,
}

impl Oedometer {
    /// The soil of a scene; `None` without strength.
    pub fn new(scene: &Fields) -> Option<Self> {
        scene.strength.map(|strength| Self::of(&scene.elastic, &strength))
    }

    /// The soil of an elasticity and a strength.
    pub fn of(elastic: &Elastic, strength: &Strength) -> Self {
        let (e, nu) = (elastic.youngs_modulus, elastic.poisson_ratio);
        let (sin, cos) = strength.friction_angle.to_radians().sin_cos();
        let dilation = strength.dilation_angle.to_radians().sin();
        let (ratio, flow) = ((1.0 - sin) / (1.0 + sin), (1.0 - dilation) / (1.0 + dilation));
        let over = 1.0 - sin - (1.0 + sin) * nu / (1.0 - nu);
        Self {
            elastic: *elastic,
            yield_pressure: if over > 0.0 { 2.0 * strength.cohesion * cos / over } else { f64::INFINITY },
            plastic_modulus: e / (1.0 - 2.0 * nu * ratio + 2.0 * flow * (ratio * (1.0 - nu) - nu)),
            ratio,
        }
    }

    /// Compressive strain under a vertical pressure (Pa).
    pub fn strain(&self, pressure: f64) -> f64 {
        let elastic = pressure.min(self.yield_pressure);
        elastic / self.elastic.oedometer_modulus() + (pressure - elastic) / self.plastic_modulus
    }

    /// Lateral pressure under a vertical one, Pa.
    pub fn lateral(&self, pressure: f64) -> f64 {
        let elastic = pressure.min(self.yield_pressure);
        let nu = self.elastic.poisson_ratio;
        elastic * nu / (1.0 - nu) + (pressure - elastic) * self.ratio
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mpm_core::constitutive::{Law, MohrCoulomb};

    #[test]
    fn the_law_follows_it_in_one_step_or_many() {
        let elastic = Elastic { youngs_modulus: 2.0e7, poisson_ratio: 0.2 };
        for dilation_angle in [0.0, 10.0, 20.0] {
            let strength = Strength {
                cohesion: 500.0,
                friction_angle: 20.0,
                dilation_angle,
                tension_cutoff: None,
                dilation_fades_over: None,
            };
            let exact = Oedometer::of(&elastic, &strength);
            let law = MohrCoulomb::new(&elastic, &strength);
            for steps in [1, 7] {
                let mut stress = [0.0; 4];
                for _ in 0..steps {
                    law.update(&mut stress, &[0.0, -exact.strain(1.0e4) / f64::from(steps), 0.0, 0.0], &mut [0.0]);
                }
                assert!((stress[1] + 1.0e4).abs() < 1e-8, "{stress:?}");
                assert!((stress[0] + exact.lateral(1.0e4)).abs() < 1e-8, "{stress:?}");
            }
        }
    }
}

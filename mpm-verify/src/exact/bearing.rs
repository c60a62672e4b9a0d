//! Bearing capacity of a strip footing on level Mohr-Coulomb soil without weight, or without friction: Prandtl's limit load.
//!
//! Assumptions: rigid-plastic soil with associated flow, plane strain, a strip on the surface, rough or smooth, and room for the mechanism.
//! `q = N_c c`, N_c = (N_q - 1)/tan(phi), N_q = tan^2(45 + phi/2) exp(pi tan(phi)), 2 + pi for phi = 0: lower and upper bound agree. Without
//! friction the weight of the soil adds nothing.
//!
//! Sources: Prandtl 1921, Z. angew. Math. Mech. 1, 15-20; Chen, *Limit Analysis and Soil Plasticity*, 1975, chapter 6.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use mpm_core::scene::{Dimension, Scene, Side, SolidSide};

/// Limit load over the cohesion N_c, at an angle of friction in degrees.
pub fn n_c(friction_angle: f64) -> f64 {
    let phi = friction_angle.to_radians();
    if phi == 0.0 {
        return 2.0 + PI;
    }
    let n_q = (FRAC_PI_4 + 0.5 * phi).tan().powi(2) * (PI * phi.tan()).exp();
    (n_q - 1.0) / phi.tan()
}

/// Prandtl's mechanism under half of a strip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prandtl {
    /// Limit load, Pa.
    pub load: f64,
    /// Half of the width of the strip, m.
    pub half_width: f64,
}

impl Prandtl {
    /// The right half of a strip on a scene whose left side is the plane of symmetry; `None` for any other scene.
    pub fn of(scene: &Scene) -> Option<Self> {
        let strength = scene.strength.filter(|s| s.dilation_angle == s.friction_angle && s.tension_cutoff.is_none())?;
        let weightless = scene.gravity.is_none() || strength.friction_angle == 0.0;
        let [left, _, bottom, top] = scene.solid_sides;
        let level = scene.dimension == Dimension::PlaneStrain && scene.outline.is_none() && scene.layers.is_empty();
        let plain =
            scene.regions.is_empty() && scene.loads.is_empty() && scene.base.is_none() && scene.cam_clay.is_none();
        // Soil whose pores are full of water that may change the effective stress has another limit load.
        let dry = scene.water.is_none();
        let sides = left == SolidSide::Roller && bottom != SolidSide::Free && top == SolidSide::Free;
        if !(weightless && level && plain && dry && sides) {
            return None;
        }
        let strip = match (&scene.plates[..], scene.surcharge) {
            ([plate], None) if plate.on == Side::Top && plate.displacement > 0.0 => plate.x,
            ([], Some(load)) if load.pressure > 0.0 => load.strip.map(|strip| [strip.from, strip.to]),
            _ => None,
        };
        let half_width = strip.filter(|[from, _]| *from == 0.0)?[1];
        let exact = Self { load: n_c(strength.friction_angle) * strength.cohesion, half_width };
        let [wide, deep] = exact.reach(strength.friction_angle);
        (scene.width >= wide && scene.height >= deep).then_some(exact)
    }

    /// Extent of the mechanism from the plane of symmetry, and its depth, m.
    pub fn reach(&self, friction_angle: f64) -> [f64; 2] {
        let phi = friction_angle.to_radians();
        // The side of the wedge under the strip; a logarithmic spiral leads from it to that of the passive wedge.
        let side = self.half_width / (FRAC_PI_4 + 0.5 * phi).cos();
        let passive = side * (FRAC_PI_2 * phi.tan()).exp();
        let wide = self.half_width + 2.0 * passive * (FRAC_PI_4 - 0.5 * phi).cos();
        [wide, side * ((FRAC_PI_4 + 0.5 * phi) * phi.tan()).exp() * phi.cos()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bearing_capacity_factors_are_those_of_the_tables() {
        for (angle, expected) in [(0.0, 5.14), (20.0, 14.83), (30.0, 30.14)] {
            assert!((n_c(angle) - expected).abs() < 5e-3, "{angle}");
        }
    }

    #[test]
    fn the_mechanism_must_have_room() {
        let exact = Prandtl { load: 0.0, half_width: 1.0 };
        let near = |found: [f64; 2], expected: [f64; 2]| found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.01);
        assert!(near(exact.reach(0.0), [3.0, 2.0_f64.sqrt()]) && near(exact.reach(30.0), [9.58, 3.17]));
        let scene = crate::scenes::load("footing", &Default::default()).expect("a scene");
        assert!((Prandtl::of(&scene).expect("a footing").load - 51.416e3).abs() < 1.0);
        let narrow = scene.edited(|s| (s.width, s.cells) = (2.0, [10, 10])).expect("a scene");
        assert_eq!(Prandtl::of(&narrow), None);
    }
}

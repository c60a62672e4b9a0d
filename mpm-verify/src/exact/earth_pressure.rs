//! Earth pressure on a smooth wall that has moved far enough: Rankine's active and passive states.
//!
//! Assumptions: level dry Mohr-Coulomb soil of one kind, plane strain, a smooth upright wall over its whole height, no surcharge.
//! `P = K gamma H^2/2 -+ 2 c H sqrt(K)` with K = tan^2(45 -+ phi/2), the upper signs active.
//!
//! Source: Rankine 1857, Phil. Trans. R. Soc. 147, 9-27; Terzaghi, *Theoretical Soil Mechanics*, 1943, chapter 3.

use std::f64::consts::FRAC_PI_4;

use mpm_core::scene::{Dimension, Scene, Side};

/// The state of the soil behind a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rankine {
    /// Whether the wall moves away from the soil.
    pub active: bool,
    /// Side that the wall stands on.
    pub side: Side,
    /// Thrust on the wall, N/m.
    pub thrust: f64,
}

impl Rankine {
    /// The wall of a scene; `None` for any other scene.
    pub fn of(scene: &Scene) -> Option<Self> {
        let (strength, gravity) = (scene.strength?, scene.gravity?);
        let [plate] = &scene.plates[..] else { return None };
        let end = scene.observe_times.last().copied().unwrap_or(f64::NAN);
        let upright = matches!(plate.on, Side::Left | Side::Right) && plate.y.is_none() && !plate.rough;
        let level = scene.dimension == Dimension::PlaneStrain && scene.outline.is_none() && scene.layers.is_empty();
        let plain =
            scene.regions.is_empty() && scene.loads.is_empty() && scene.surcharge.is_none() && scene.water.is_none();
        let tilted = scene.slope_angle.is_some() || scene.seismic_coefficient.is_some();
        if !(upright && level && plain) || tilted || plate.at(end) == 0.0 {
            return None;
        }
        let active = plate.at(end) < 0.0;
        let sign = if active { -1.0 } else { 1.0 };
        let root = (FRAC_PI_4 + 0.5 * sign * strength.friction_angle.to_radians()).tan();
        let weight = scene.mixture_density() * gravity;
        let thrust =
            0.5 * (root * scene.height).powi(2) * weight + sign * 2.0 * strength.cohesion * scene.height * root;
        // The wedge behind the wall ends within the soil.
        let wedge = scene.height * root;
        (wedge <= scene.width && thrust > 0.0).then_some(Self { active, side: plate.on, thrust })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_thrust_is_that_of_the_textbook() {
        let scene = crate::scenes::load("retaining-wall", &Default::default()).expect("a scene");
        let exact = Rankine::of(&scene).expect("a wall");
        // K_a = 1/3, gamma = 15.6 kN/m3, 2 c H sqrt(K_a) = 0.23 kN/m.
        let hand = 0.5 / 3.0 * 2650.0 * 0.6 * 9.81 * 4.0 - 2.0 * 100.0 * 2.0 / 3.0_f64.sqrt();
        assert!(exact.active && (exact.thrust / hand - 1.0).abs() < 1e-12);
        let passive =
            Rankine::of(&scene.edited(|s| s.plates[0].displacement = 0.01).expect("a scene")).expect("a wall");
        assert!(!passive.active && passive.thrust > 9.0 * exact.thrust);
        let rough = scene.edited(|s| s.plates[0].rough = true).expect("a scene");
        assert_eq!(Rankine::of(&rough), None);
    }
}

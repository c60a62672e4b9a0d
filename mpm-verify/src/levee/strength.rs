//! Strength of the soil in the units of the paper.

use mpm_core::scene::Scene;

/// Strength of the soil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strength {
    /// Cohesion, kPa.
    pub cohesion_kpa: f64,
    /// Angle of friction, degrees.
    pub friction_deg: f64,
}

impl Strength {
    /// That of a scene, if it has a limit.
    pub fn of(scene: &Scene) -> Option<Self> {
        let strength = scene.strength?;
        Some(Self { cohesion_kpa: 1e-3 * strength.cohesion, friction_deg: strength.friction_angle })
    }

    /// Shear stress t at which soil fails under the mean stress s' in the plane, kPa.
    pub fn limit(&self, s: f64) -> f64 {
        let (sin, cos) = self.friction_deg.to_radians().sin_cos();
        self.cohesion_kpa * cos + s * sin
    }
}

//! Soil on the ground: outlines, slopes, friction on the base.

use serde::Serialize;

use super::Fields;

/// How the particles of an outline are cut.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SeedingChoice {
    /// Every square keeps what lies inside: mass and centre are exact.
    #[default]
    Clipped,
    /// Whole squares whose middle lies inside.
    Whole,
}

impl SeedingChoice {
    pub(super) fn is_default(&self) -> bool {
        *self == Self::Clipped
    }
}

/// Which stress presses soil and base together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NormalStress {
    /// The total stress less the pore pressure on the base.
    Effective,
    /// The total stress.
    Total,
}

/// Coulomb friction on the base: `tau <= adhesion + tan(angle) sigma_n`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Base {
    /// Friction angle before any slip, degrees.
    pub peak_angle: f64,
    /// Friction angle after [`Self::slip_distance`], degrees.
    pub residual_angle: f64,
    /// Slip over which tan(angle) falls linearly, m; `None` if it does not.
    pub slip_distance: Option<f64>,
    /// Shear strength without normal stress, Pa.
    pub adhesion: f64,
    /// Time by which friction lags behind the normal stress, s; 0 for none.
    pub memory: f64,
    /// What the friction is a share of.
    pub normal_stress: NormalStress,
}

impl Fields {
    /// What the soil weighs per mass, m/s2: gravity, and the horizontal acceleration of an earthquake.
    pub fn body_force(&self) -> Option<[f64; 2]> {
        let shaken = self.seismic_coefficient.unwrap_or(0.0) * self.gravity.unwrap_or(0.0);
        self.gravity_vector().map(|[x, y]| [x + shaken, y])
    }

    /// Gravity as a vector, m/s2: x downslope, y normal to the base.
    pub fn gravity_vector(&self) -> Option<[f64; 2]> {
        let gravity = self.gravity?;
        // A level scene has exactly (0, -g).
        Some(self.slope_angle.map_or([0.0, -gravity], |angle| {
            let (sin, cos) = angle.to_radians().sin_cos();
            [gravity * sin, -gravity * cos]
        }))
    }

    /// Corners of the soil, m, anticlockwise: the outline, or the box of a column.
    pub fn outline_or_box(&self) -> Vec<[f64; 2]> {
        let (w, h) = (self.width, self.height);
        self.outline.clone().unwrap_or_else(|| vec![[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]])
    }

    /// Edge of the square that a particle stands for, m.
    pub fn spacing(&self) -> f64 {
        self.cell / self.particles_per_direction() as f64
    }

    /// Whether the soil is a column under vertical loads, with no empty cells beside it, and starts without a velocity.
    pub(super) fn is_level_column(&self) -> bool {
        self.outline.is_none()
            && self.empty_cells_beside == 0
            && self.slope_angle.is_none()
            && self.seismic_coefficient.is_none()
            && self.start_velocity.is_none()
            && !self.periodic
            && self.base.is_none()
    }
}

//! Stability of a slope by slip circles: factor of safety of the method of slices, and the circle where it is least.
//!
//! Assumptions: plane, rigid slide that turns towards +x; Mohr-Coulomb strength on effective stress, divided by the
//! same factor F everywhere on the slip surface; vertical slices without shear forces between them; pore pressure and
//! water surface given; no water stands on the ground, nothing loads it. The ground may rest on a firm base. A circle
//! that would go below it is cut: the slip surface then follows the base, with the strength of the contact.
//!
//! With weight W, base length l, base angle alpha (positive where the base falls towards +x), pore pressure u:
//!
//! - normal force, from vertical balance: `P = [W - (c - u tan phi) l sin(alpha)/F]/m`,
//!   `m = cos(alpha) + sin(alpha) tan(phi)/F`;
//! - moments about the centre of the circle: `F = sum R [c l + (P - u l) tan phi]/(sum W (x_c - x) - sum P f)`, where
//!   R is the distance of the shear force from the centre and f that of the normal force.
//!
//! On the arc R is the radius and f = 0: that is Bishop's simplified method. On the base R = y_c - y and f = x_c - x.
//! Forces between slices are horizontal and cancel in the sum, but the balance of horizontal forces is not met. Where
//! the surface is no circle, F therefore depends on the centre of moments, by up to 12 % (Fredlund, Zhang & Lam 1992,
//! doi:10.1139/t92-050); here it is the centre of the arc, and a search for the least F finds what that makes of it.
//! Spencer's method meets all balances and depends on no centre: it is the one to trust on a cut circle.
//!
//! [`Section::slide`] cuts a circle into slices, [`Slide::bishop`], [`Slide::spencer`] and [`Slide::ordinary`] give
//! its factor, [`Section::critical`] searches the least one. [`water`]: pore pressure of a phreatic line. [`levee`]:
//! the paper's levee.
//!
//! Sources: Bishop 1955, Geotechnique 5(1), doi:10.1680/geot.1955.5.1.7; Fredlund & Krahn 1977, Canadian Geotechnical
//! Journal 14(3), doi:10.1139/t77-045; Fellenius 1936, Trans. 2nd Congress on Large Dams 4.

pub mod factor;
pub mod levee;
pub mod search;
pub mod slices;
pub mod water;

#[cfg(test)]
mod composite_test;
#[cfg(test)]
mod levee_test;
#[cfg(test)]
mod published_test;
#[cfg(test)]
mod truth_test;

use mpm_core::scene::NormalStress;

use super::infinite_slope::Strength;

pub use search::{Critical, Limits};
pub use slices::{Circle, Slice, Slide};

/// A slope: soil, surface, what it stands on, water.
#[derive(Clone, Copy)]
pub struct Section<'a> {
    /// Corners (x, y) of the surface, m; x increases from one to the next.
    pub ground: &'a [[f64; 2]],
    /// What no slip surface goes through; `None` for soil without end.
    pub base: Option<FirmBase>,
    /// Strength of the soil, on effective stress.
    pub strength: Strength,
    /// Unit weight of the soil above the water (dry or moist), N/m3.
    pub dry_weight: f64,
    /// Unit weight of the saturated soil, N/m3.
    pub saturated_weight: f64,
    /// Height y (m) of the water surface at x (m): the soil below it has its saturated weight. Above the ground it
    /// counts as on the ground.
    pub level: &'a dyn Fn(f64) -> f64,
    /// Pore pressure (Pa) at (x, y), m; negative values count as zero.
    pub pressure: &'a dyn Fn(f64, f64) -> f64,
}

/// A level base that carries whatever stands on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirmBase {
    /// Its height y, m.
    pub height: f64,
    /// Strength of the contact: adhesion (Pa) and angle of friction (rad).
    pub strength: Strength,
    /// Stress that the friction is a share of.
    pub normal_stress: NormalStress,
}

/// Why a circle has no factor of safety.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Refused {
    /// It does not cut the ground.
    #[error("the circle does not cut the ground")]
    Outside,
    /// It leaves the ground across the end of the section or overhangs.
    #[error("the circle does not come out of the ground, or overhangs")]
    Open,
    /// Nothing drives the slide towards +x.
    #[error("nothing drives the slide")]
    NotDriven,
    /// A factor would need slices with m below [`factor::LEAST_M`]: normal forces without meaning.
    #[error("a base is too steep against the slide: m is below {}", factor::LEAST_M)]
    TooSteep,
}

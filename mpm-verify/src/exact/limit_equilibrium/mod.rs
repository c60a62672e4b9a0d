//! Limit equilibrium of a slope: the factor of safety of the method of slices, and the slip surface where it is least.
//!
//! Assumptions: plane, rigid slide that turns towards +x; Mohr-Coulomb strength on effective stress, divided by the
//! same factor F everywhere on the slip surface; vertical slices; pore pressure and water surface given. Water may stand on the ground,
//! and an earthquake may push with a share k of the weight. The ground may rest on a firm base. A circle
//! that would go below it is cut: the slip surface then follows the base, with the strength of the contact.
//!
//! With weight W (and that of the water above it), base length l, base angle alpha (positive where the base falls towards +x),
//! pore pressure u, a horizontal push H, forces E and X = lambda f(x) E on the sides of a slice
//! (general limit equilibrium, Fredlund & Krahn 1977):
//!
//! - normal force, from vertical balance: `N = [W + X_left - X_right - (c - u tan phi) l sin(alpha)/F]/m`,
//!   `m = cos(alpha) + sin(alpha) tan(phi)/F`;
//! - horizontal balance: `E_right = E_left + N sin(alpha) - [c l + (N - u l) tan phi] cos(alpha)/F + H`;
//! - moments about the centre of the circle: `F = sum R [c l + (N - u l) tan phi]/(sum W (x_c - x) + sum H (y_c - y) - sum N f)`,
//!   where R is the distance of the shear force from the centre and f that of the normal force.
//!
//! On the arc R is the radius and f = 0. lambda = 0 and the balance of moments: Bishop's simplified method. f = 1 and all
//! balances: Spencer's. f = sin of half a period from entry to exit and all balances: Morgenstern & Price's. Where the surface is no
//! circle, Bishop's F depends on the centre of moments, by up to 12 % (Fredlund, Zhang & Lam 1992,
//! doi:10.1139/t92-050); the other two depend on no centre.
//!
//! [`Section::slide`] cuts a circle into slices, [`Section::along`] any other surface; [`Slide::factor`] and [`Slide::ordinary`] give
//! its factor, [`Section::critical`] searches the circle where it is least, [`Section::critical_line`] goes on to any surface.
//! [`water`]: pore pressure of a phreatic line.
//!
//! Sources: Bishop 1955, Geotechnique 5(1), doi:10.1680/geot.1955.5.1.7; Spencer 1967, Geotechnique 17(1),
//! doi:10.1680/geot.1967.17.1.11; Morgenstern & Price 1965, Geotechnique 15(1), doi:10.1680/geot.1965.15.1.79; Fredlund & Krahn 1977,
//! Canadian Geotechnical Journal 14(3), doi:10.1139/t77-045; Fellenius 1936, Trans. 2nd Congress on Large Dams 4.

pub mod factor;
pub mod line;
pub mod search;
pub mod slices;
pub mod water;

#[cfg(test)]
mod composite_test;
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
    /// What the ground is made of.
    pub soil: &'a dyn Soil,
    /// Height y (m) of the water surface at x (m): the soil below it has its saturated weight. Above the ground it
    /// counts as on the ground.
    pub level: &'a dyn Fn(f64) -> f64,
    /// Pore pressure (Pa) at (x, y), m; negative values count as zero.
    pub pressure: &'a dyn Fn(f64, f64) -> f64,
    /// What acts from outside.
    pub outside: Outside<'a>,
}

/// What the ground is made of.
pub trait Soil {
    /// Strength at (x, y), m, on effective stress.
    fn strength(&self, x: f64, y: f64) -> Strength;
    /// Weight of soil and water at x (m) per area, N/m2, from a height to another (m) that lies above it; below `level` (m) the soil is
    /// saturated.
    fn weight(&self, x: f64, heights: [f64; 2], level: f64) -> f64;
}

/// One soil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uniform {
    /// Its strength.
    pub strength: Strength,
    /// Unit weight above the water (dry or moist), N/m3.
    pub dry_weight: f64,
    /// Saturated unit weight, N/m3.
    pub saturated_weight: f64,
}

impl Soil for Uniform {
    fn strength(&self, _: f64, _: f64) -> Strength {
        self.strength
    }

    fn weight(&self, _: f64, [low, high]: [f64; 2], level: f64) -> f64 {
        let wet = (level.min(high) - low).max(0.0);
        self.dry_weight * (high - low - wet) + self.saturated_weight * wet
    }
}

impl Uniform {
    /// Soil that water does not make heavier.
    pub fn dry(strength: Strength, weight: f64) -> Self {
        Self { strength, dry_weight: weight, saturated_weight: weight }
    }
}

impl<'a> Section<'a> {
    /// A slope without water, base, pond or earthquake.
    pub fn dry(ground: &'a [[f64; 2]], soil: &'a dyn Soil) -> Self {
        let (level, pressure) = (&|_| f64::NEG_INFINITY, &|_, _| 0.0);
        Self { ground, base: None, soil, level, pressure, outside: Outside::NOTHING }
    }
}

/// What acts on the ground from outside.
#[derive(Clone, Copy)]
pub struct Outside<'a> {
    /// What loads the ground at x (m): force towards +x and downwards, per area along x, Pa.
    pub traction: &'a dyn Fn(f64) -> [f64; 2],
    /// Share of the weight of soil and pore water that pushes towards +x.
    pub seismic: f64,
}

impl Outside<'_> {
    /// Nothing.
    pub const NOTHING: Outside<'static> = Outside { traction: &|_| [0.0; 2], seismic: 0.0 };
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

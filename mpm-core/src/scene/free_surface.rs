//! Water that does not fill the soil: what is wet at t = 0, what feeds it, and what a stage couples.

use serde::Serialize;

use super::{Course, Fields};
use crate::seeding;
use crate::water::retention::Retention;

/// What a side of the soil is fed with.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Feed {
    /// Water at rest up to this height above the base, m; without gravity its pressure head, m.
    Head(f64),
    /// A Darcy flux into the soil, m/s, below a height above the base (m).
    Velocity {
        /// The flux, m/s.
        speed: f64,
        /// Where it ends, m above the base.
        height: f64,
    },
}

/// Water with a free surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FreeSurfaceWater {
    /// Share S_0 of the pores that holds water before any front comes; it stays where it is. Of soil with a retention, S_r.
    pub saturation: f64,
    /// Height up to which the soil is full of water at t = 0, m.
    pub level: Option<f64>,
    /// Corners of the soil that is full of water at t = 0, m, anticlockwise.
    pub wet: Option<Vec<[f64; 2]>>,
    /// Suction head at t = 0 of soil that neither a level nor `wet` says anything of, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub suction: Option<f64>,
    /// What unsaturated soil holds; without it fronts are sharp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub retention: Option<Retention>,
    /// Heads (m) along sides where they differ from place to place, by the place in m.
    #[serde(skip_serializing_if = "always")]
    pub heads: [Course; 4],
    /// Sides that are fed: left, right, bottom, top.
    pub feeds: [Option<Feed>; 4],
    /// Courses in time of those with a velocity.
    #[serde(skip_serializing_if = "always")]
    pub courses: [Course; 4],
}

/// Whether all feeds stay as they are.
fn always(courses: &[Course; 4]) -> bool {
    courses.iter().all(|course| *course == Course::Constant)
}

impl FreeSurfaceWater {
    /// What feeds the sides at a time, s.
    pub fn feeds_at(&self, time: f64) -> [Option<Feed>; 4] {
        let at = |side: usize| match (self.feeds[side], self.courses[side].at(time, 0.0)) {
            (Some(Feed::Velocity { .. }), factor) if factor <= 0.0 => None,
            (Some(Feed::Velocity { speed, height }), factor) => Some(Feed::Velocity { speed: speed * factor, height }),
            (feed, _) => feed,
        };
        [0, 1, 2, 3].map(at)
    }
}

/// What a stage moves where water has a free surface.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Coupling {
    /// The water; the soil rests.
    #[default]
    Seepage,
    /// The soil; the water keeps its pressures.
    Soil,
    /// Both, staggered or in the same steps: the soil may fail.
    Full,
}

impl Coupling {
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

impl Fields {
    /// Porosity that mobile water can fill, n (1 - S_0).
    pub fn mobile_porosity(&self) -> f64 {
        self.porosity * (1.0 - self.free_surface.as_ref().map_or(0.0, |f| f.saturation))
    }

    /// How far water stands above a place at t = 0, up to the level or to the upper edge of what is wet, m; infinitely where soil is full of
    /// it, and below zero above a level.
    pub fn water_above(&self, place: &[f64; 2]) -> f64 {
        let Some(free) = &self.free_surface else { return f64::INFINITY };
        let in_wet = free.wet.as_ref().map(|wet| seeding::depth(wet, place)).filter(|depth| *depth > 0.0);
        in_wet.or(free.level.map(|level| level - place[1])).unwrap_or(f64::NEG_INFINITY)
    }

    /// Pressure of the water of unsaturated soil at a place at t = 0, Pa: that of water at rest, or of the suction that is given.
    pub fn first_pressure(&self, place: &[f64; 2]) -> f64 {
        let unit_weight = self.water.map_or(0.0, |water| water.unit_weight);
        match (self.water_above(place), self.free_surface.as_ref().and_then(|free| free.suction)) {
            (above, Some(suction)) if above < 0.0 => -unit_weight * suction,
            (above, _) => -self.water_weight()[1] * above,
        }
    }

    /// What unsaturated soil feels of it, `S_e p`, Pa; `None` without a retention.
    pub fn first_felt(&self, place: &[f64; 2]) -> Option<f64> {
        let (law, pressure) = (self.free_surface.as_ref()?.retention?, self.first_pressure(place));
        Some(law.at(pressure, self.water?.unit_weight).wet * pressure)
    }

    /// How much of the height between two levels above the base (m) mobile water fills in unsaturated soil at a place along x at t = 0, m;
    /// `None` without a retention.
    pub fn soaked(&self, x: f64, [low, high]: [f64; 2]) -> Option<f64> {
        /// Parts of the height.
        const PARTS: u32 = 64;
        let (law, unit_weight) = (self.free_surface.as_ref()?.retention?, self.water?.unit_weight);
        let part = (high - low) / f64::from(PARTS);
        let wet = |i: u32| law.at(self.first_pressure(&[x, low + (f64::from(i) + 0.5) * part]), unit_weight).wet;
        Some((0..PARTS).map(wet).sum::<f64>() * part)
    }

    /// Weight of water per volume along each axis, rho_w g, Pa/m.
    pub fn water_weight(&self) -> [f64; 2] {
        let density = self.water.map_or(0.0, |w| w.density);
        self.gravity_vector().map_or([0.0; 2], |g| g.map(|g| density * g))
    }
}

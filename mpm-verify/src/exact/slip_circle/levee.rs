//! A slope on a level firm base in limit equilibrium, seen so that it falls towards +x; the paper's half levee is one.
//!
//! Any ground that does not overhang. Beyond a toe on the base the base goes on, so that a slide along it comes out
//! there. Walls take no part: no slide starts or ends at one below the ground.
//!
//! Without dilation a soil does not reach its strength on every plane: [`LeveeFactors`] hold those of the strength
//! itself and of Davis' reduced one; a calculation with a non-associated law is expected between them. For psi = 0 the
//! reduction takes cohesion and tan(phi) to cos(phi) of what they were, and F with them where the slide is off the base.

use super::factor::Method;
use super::water::{Equipotentials, Phreatic};
use super::{Critical, FirmBase, Limits, Section};
use crate::exact::infinite_slope::{InfiniteSlope, Seepage, Strength};

/// A slope.
#[derive(Debug, Clone, PartialEq)]
pub struct Levee {
    /// Corners (x, y) of its surface, and of the base beyond a toe on it, m; x increases.
    pub ground: Vec<[f64; 2]>,
    /// Where the soil ends, x in m.
    pub end: f64,
    /// Strength of the soil.
    pub strength: Strength,
    /// Dilation angle psi, rad.
    pub dilation: f64,
    /// Unit weight of the soil above the water, N/m3.
    pub dry_weight: f64,
    /// Unit weight of the saturated soil, N/m3.
    pub saturated_weight: f64,
    /// Unit weight of water, N/m3.
    pub water_weight: f64,
    /// Contact between soil and base.
    pub base: FirmBase,
}

/// Factors of safety for one strength of the soil.
#[derive(Debug, Clone, PartialEq)]
pub struct Factors {
    /// The strength.
    pub strength: Strength,
    /// Of an infinite slope like the levee's, full of water that leaves it horizontally, at the least depth; `None`
    /// where the effective stress is negative. What the soil just above the toe comes to when the water is there.
    pub toe: Option<f64>,
    /// Vertical depth (m) at which that factor is one.
    pub toe_depth: Option<f64>,
    /// The critical slide without water.
    pub dry: Option<Critical>,
    /// The critical slide with water.
    pub wet: Option<Critical>,
}

/// Factors of safety of a levee.
#[derive(Debug, Clone, PartialEq)]
pub struct LeveeFactors {
    /// With the strength of the soil.
    pub full: Factors,
    /// With Davis' reduced strength in the soil; the contact with the base keeps its own.
    pub reduced: Factors,
}

impl Levee {
    /// The paper's: 3 m wide and high, slope 1:2, grains 2700 kg/m3, porosity 0.30, c = 500 Pa, phi = 30 degrees, psi
    /// = 0 (Table 3 and section 4), water 1000 kg/m3, g = 9.81 m/s2, dry above the water.
    pub fn paper(base: FirmBase) -> Self {
        let (gravity, porosity) = (9.81, 0.3);
        let (dry_weight, water_weight) = (2700.0 * (1.0 - porosity) * gravity, 1000.0 * gravity);
        Self {
            ground: vec![[0.0, 3.0], [3.0, 3.0], [9.0, 0.0], [15.0, 0.0]],
            end: 9.0,
            strength: Strength { cohesion: 500.0, friction: 30.0_f64.to_radians() },
            dilation: 0.0,
            dry_weight,
            saturated_weight: dry_weight + porosity * water_weight,
            water_weight,
            base,
        }
    }

    /// Slides of at least a vertical depth (m) that start on the soil, in 120 slices.
    pub fn limits(&self, least_depth: f64, method: Method) -> Limits {
        let [start, last] = [self.ground[0][0], self.ground[self.ground.len() - 1][0]];
        Limits { least_depth, least_area: 0.0, starts: [start, self.end], ends: [start, last], slices: 120, method }
    }

    /// The lowest part of the surface that falls, from its top to its foot (x, y), m.
    pub fn lowest_face(&self) -> Option<[[f64; 2]; 2]> {
        self.ground.windows(2).map(|pair| [pair[0], pair[1]]).rfind(|[top, foot]| foot[1] < top[1])
    }

    /// Factors of safety without water and with the water below a line (x, y), m, x increasing.
    pub fn factors(&self, line: &[[f64; 2]], equipotentials: Equipotentials, limits: &Limits) -> LeveeFactors {
        let with = |strength: Strength| {
            let toe = self.toe(strength);
            Factors {
                strength,
                toe: toe.and_then(|toe| toe.factor(limits.least_depth)),
                toe_depth: toe.and_then(|toe| toe.critical_depth()),
                dry: self.critical(strength, &[], equipotentials, limits),
                wet: self.critical(strength, line, equipotentials, limits),
            }
        };
        LeveeFactors { full: with(self.strength), reduced: with(self.strength.reduced(self.dilation)) }
    }

    /// The critical slide for a strength of the soil, with the water below a line (x, y), m; an empty line is no water.
    pub fn critical(
        &self,
        strength: Strength,
        line: &[[f64; 2]],
        equipotentials: Equipotentials,
        limits: &Limits,
    ) -> Option<Critical> {
        let ground = &self.ground;
        let water = Phreatic { line, ground, water_weight: self.water_weight };
        let section = Section {
            ground,
            base: Some(self.base),
            strength,
            dry_weight: self.dry_weight,
            saturated_weight: self.saturated_weight,
            level: &|x| water.level(x),
            pressure: &|x, y| water.pressure(equipotentials, x, y),
        };
        section.critical(limits)
    }

    /// The slope without end that it is like at its toe, full of water that leaves it horizontally.
    pub fn toe(&self, strength: Strength) -> Option<InfiniteSlope> {
        let [top, foot] = self.lowest_face()?;
        let slope = InfiniteSlope {
            angle: ((top[1] - foot[1]) / (foot[0] - top[0])).atan(),
            dry_weight: self.dry_weight,
            saturated_weight: self.saturated_weight,
            water_weight: self.water_weight,
            strength,
            seepage: Seepage::Parallel { share: 1.0 },
        };
        Some(slope.horizontal())
    }
}

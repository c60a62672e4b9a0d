//! The levee of the paper in limit equilibrium: half of it, between the wall of the tank and the toe.
//!
//! The crest is level, the slope straight, the base level and firm; it goes on beyond the toe, so that a slide along
//! the base comes out there. The wall takes no part: no slide starts at it below the crest. The soil above the water is
//! dry.
//!
//! Without dilation a soil does not reach its strength on every plane: [`LeveeFactors`] hold those of the strength
//! itself and of Davis' reduced one; a calculation with a non-associated law is expected between them. For psi = 0 the
//! reduction takes cohesion and tan(phi) to cos(phi) of what they were, and F with them where the slide is off the base.

use super::factor::Method;
use super::water::{Equipotentials, Phreatic};
use super::{Critical, FirmBase, Limits, Section};
use crate::exact::infinite_slope::{InfiniteSlope, Seepage, Strength};

/// Half a levee.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Levee {
    /// Width of the crest from the wall at x = 0, m.
    pub crest: f64,
    /// Height above the base at y = 0, m.
    pub height: f64,
    /// Run of the slope from crest to toe, m.
    pub run: f64,
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
            crest: 3.0,
            height: 3.0,
            run: 6.0,
            strength: Strength { cohesion: 500.0, friction: 30.0_f64.to_radians() },
            dilation: 0.0,
            dry_weight,
            saturated_weight: dry_weight + porosity * water_weight,
            water_weight,
            base,
        }
    }

    /// Surface (x, y), m, and as much of the base beyond the toe as the slope is long.
    pub fn ground(&self) -> [[f64; 2]; 4] {
        let toe = self.crest + self.run;
        [[0.0, self.height], [self.crest, self.height], [toe, 0.0], [toe + self.run, 0.0]]
    }

    /// Slides of at least a vertical depth (m) that start on crest or slope, in 120 slices.
    pub fn limits(&self, least_depth: f64, method: Method) -> Limits {
        let toe = self.crest + self.run;
        Limits { least_depth, least_area: 0.0, starts: [0.0, toe], ends: [0.0, toe + self.run], slices: 120, method }
    }

    /// Factors of safety without water and with the water below a line (x, y), m, x increasing.
    pub fn factors(&self, line: &[[f64; 2]], equipotentials: Equipotentials, limits: &Limits) -> LeveeFactors {
        let with = |strength: Strength| {
            let toe = self.toe(strength);
            Factors {
                strength,
                toe: toe.factor(limits.least_depth),
                toe_depth: toe.critical_depth(),
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
        let ground = self.ground();
        let water = Phreatic { line, ground: &ground, water_weight: self.water_weight };
        let section = Section {
            ground: &ground,
            base: Some(self.base),
            strength,
            dry_weight: self.dry_weight,
            saturated_weight: self.saturated_weight,
            level: &|x| water.level(x),
            pressure: &|x, y| water.pressure(equipotentials, x, y),
        };
        section.critical(limits)
    }

    /// The slope without end that the levee is like at its toe, full of water that leaves it horizontally.
    pub fn toe(&self, strength: Strength) -> InfiniteSlope {
        let slope = InfiniteSlope {
            angle: (self.height / self.run).atan(),
            dry_weight: self.dry_weight,
            saturated_weight: self.saturated_weight,
            water_weight: self.water_weight,
            strength,
            seepage: Seepage::Parallel { share: 1.0 },
        };
        slope.horizontal()
    }
}

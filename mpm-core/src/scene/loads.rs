//! Loads on the faces of the soil, and their course in time.

use serde::{Deserialize, Serialize};

use super::{Dimension, Fields, Side, SolidSide, Surcharge};
use crate::real::array_of;
use crate::seeding::pieces;

/// A factor at a place along x, m.
pub type AlongX = Box<dyn Fn(f64) -> f64>;

/// Course in time and along the soil: a factor on its size.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Course {
    /// Always the same.
    #[default]
    Constant,
    /// Grows linearly from zero within so long, s.
    Ramp(f64),
    /// Linear between times (s) with their factors, constant before and after; a time that stands there twice is a jump.
    Times(Vec<[f64; 2]>),
    /// `mean + amplitude sin(2 pi t/period + phase)`.
    Sine {
        /// Factor about which it swings.
        mean: f64,
        /// How far.
        amplitude: f64,
        /// Time of one swing, s.
        period: f64,
        /// How far it is ahead at t = 0, degrees.
        phase: f64,
    },
    /// A wave that runs to the right, `cos(2 pi (x/length - t/period))`; to the left if its length is below 0.
    Wave {
        /// Length of the wave, m.
        length: f64,
        /// Time of one swing, s.
        period: f64,
    },
}

impl Course {
    /// The factor at a time (s) and a place along x (m).
    pub fn at(&self, time: f64, x: f64) -> f64 {
        use std::f64::consts::TAU;
        match self {
            Self::Constant => 1.0,
            Self::Ramp(end) => (time / end).min(1.0),
            Self::Times(list) => match list.partition_point(|[t, _]| *t <= time) {
                0 => list[0][1],
                after if after == list.len() => list[after - 1][1],
                after => {
                    let ([t0, f0], [t1, f1]) = (list[after - 1], list[after]);
                    f0 + (time - t0) / (t1 - t0) * (f1 - f0)
                }
            },
            Self::Sine { mean, amplitude, period, phase } => {
                mean + amplitude * (TAU * time / period + phase.to_radians()).sin()
            }
            Self::Wave { length, period } => (TAU * (x / length - time / period)).cos(),
        }
    }

    /// The first time after another (s) at which it bends or jumps; infinite if there is none.
    pub fn bends_after(&self, time: f64) -> f64 {
        match self {
            Self::Times(list) => list.iter().map(|[t, _]| *t).find(|t| *t > time).unwrap_or(f64::INFINITY),
            Self::Ramp(end) if time < *end => *end,
            _ => f64::INFINITY,
        }
    }

    /// The same as courses that do not depend on the place, each with its factor at a place along x (m).
    pub fn parts(&self) -> Vec<(Self, AlongX)> {
        let Self::Wave { length, period } = *self else { return vec![(self.clone(), Box::new(|_| 1.0))] };
        let sine = |phase| Self::Sine { mean: 0.0, amplitude: 1.0, period, phase };
        let number = std::f64::consts::TAU / length;
        // cos(k x - w t)
        vec![(sine(90.0), Box::new(move |x| (number * x).cos())), (sine(0.0), Box::new(move |x| (number * x).sin()))]
    }

    /// Largest size of the factor.
    pub fn most(&self) -> f64 {
        match self {
            Self::Constant | Self::Ramp(_) | Self::Wave { .. } => 1.0,
            Self::Times(list) => list.iter().fold(0.0, |most: f64, [_, factor]| most.max(factor.abs())),
            Self::Sine { mean, amplitude, .. } => mean.abs() + amplitude.abs(),
        }
    }

    /// Times at which it has a corner or jumps, s.
    pub fn corners(&self) -> Vec<f64> {
        match self {
            Self::Ramp(end) => vec![*end],
            Self::Times(list) => list.iter().map(|[time, _]| *time).collect(),
            Self::Constant | Self::Sine { .. } | Self::Wave { .. } => Vec::new(),
        }
    }
}

/// What a load does to the faces that bear it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Bearing {
    /// Presses and drags where its factor is 1.
    Traction {
        /// Normal to the face, into the soil, Pa.
        pressure: f64,
        /// Along the face, clockwise around the soil (to the right on top), Pa.
        shear: f64,
        /// Whether it is water: its pressure is then also that of the pores at the face.
        water: bool,
    },
    /// Water at rest, whose level above the base (m) is the factor: it presses where it stands, and feeds the pores.
    Reservoir,
}

/// A load on outer faces of the soil.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaceLoad {
    /// It acts on faces towards that side; `None` for all free faces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on: Option<Side>,
    /// Only between these places along x, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<[f64; 2]>,
    /// Only between these heights, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<[f64; 2]>,
    /// What it does.
    pub bearing: Bearing,
    /// Its course in time.
    pub course: Course,
}

/// A rigid plate on a side of the soil that is moved as given.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MovedPlate {
    /// Its side.
    pub on: Side,
    /// Only between these places along x, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<[f64; 2]>,
    /// Only between these heights, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<[f64; 2]>,
    /// Whether the soil sticks to it; else it slides along.
    pub rough: bool,
    /// How far it moves into the soil where its factor is 1, m.
    pub displacement: f64,
    /// Its course in time.
    pub course: Course,
    /// Velocity into the soil, on top of it, m/s.
    pub velocity: f64,
}

impl MovedPlate {
    /// How far it has moved into the soil at a time (s), m.
    pub fn at(&self, time: f64) -> f64 {
        self.displacement * self.course.at(time, 0.0) + self.velocity * time
    }
}

/// A line normal to the plane that takes water out of the soil or puts some in; in a column it does so all over a level.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Well {
    /// Its place, m.
    pub at: [f64; 2],
    /// Water that it takes where its factor is 1, m3/s per metre, of a column for all its width; below 0 it puts some in.
    pub rate: f64,
    /// Its course in time.
    pub course: Course,
}

/// A piece of the outline of the soil.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Piece {
    /// Its middle, m.
    pub middle: [f64; 2],
    /// Its outward normal times its length, m.
    pub outward: [f64; 2],
}

impl Piece {
    /// Whether it faces a side.
    pub fn looks_to(&self, side: Side) -> bool {
        let sign = if matches!(side, Side::Left | Side::Bottom) { -1.0 } else { 1.0 };
        let axis = usize::from(matches!(side, Side::Bottom | Side::Top));
        let [x, y] = self.outward;
        sign * self.outward[axis] > 1e-9 * x.hypot(y)
    }
}

impl FaceLoad {
    /// Force on a piece that bears all of it where its factor is 1, N for 1 m; of water at rest that of 1 Pa.
    pub fn force(&self, piece: &Piece) -> [f64; 2] {
        let [x, y] = piece.outward;
        match self.bearing {
            // Clockwise from the outward normal.
            Bearing::Traction { pressure, shear, .. } => [-pressure * x + shear * y, -pressure * y - shear * x],
            Bearing::Reservoir => [-x, -y],
        }
    }

    /// The factor on that force at a place (m) and a time (s), under water of a weight, N/m3.
    pub fn factor(&self, place: &[f64; 2], time: f64, unit_weight: f64) -> f64 {
        let factor = self.course.at(time, place[0]);
        match self.bearing {
            Bearing::Traction { .. } => factor,
            Bearing::Reservoir => unit_weight * (factor - place[1]).max(0.0),
        }
    }

    /// Pressure of the water at a place (m) of its faces and a time (s); `None` where it is no water or does not reach.
    pub fn of_water(&self, place: &[f64; 2], time: f64, unit_weight: f64) -> Option<f64> {
        let factor = self.factor(place, time, unit_weight);
        match self.bearing {
            Bearing::Traction { pressure, water, .. } => water.then_some(pressure * factor),
            Bearing::Reservoir => Some(factor).filter(|pressure| *pressure > 0.0),
        }
    }

    /// Whether it is water.
    pub fn is_water(&self) -> bool {
        matches!(self.bearing, Bearing::Reservoir | Bearing::Traction { water: true, .. })
    }

    /// The part of a piece that bears it, if there is one.
    pub fn part_of(&self, piece: &Piece) -> Option<Piece> {
        if self.on.is_some_and(|side| !piece.looks_to(side)) {
            return None;
        }
        let [nx, ny] = piece.outward;
        // Along the piece, from its first end on: half of it to each side of the middle.
        let along = [-ny, nx];
        let mut span = [-0.5_f64, 0.5];
        for (d, range) in [self.x, self.y].into_iter().enumerate() {
            let Some([low, high]) = range else { continue };
            if along[d] == 0.0 {
                if !(low..=high).contains(&piece.middle[d]) {
                    return None;
                }
                continue;
            }
            let mut ends = [low, high].map(|end| (end - piece.middle[d]) / along[d]);
            ends.sort_by(f64::total_cmp);
            span = [span[0].max(ends[0]), span[1].min(ends[1])];
        }
        let (length, middle) = (span[1] - span[0], 0.5 * (span[0] + span[1]));
        (length > 1e-9).then(|| Piece {
            middle: array_of(|d| piece.middle[d] + middle * along[d]),
            outward: piece.outward.map(|n| length * n),
        })
    }
}

impl Surcharge {
    /// Its force on a piece of the outline of the soil, N for 1 m: vertical, on faces that point upwards.
    pub fn force(&self, piece: &Piece) -> [f64; 2] {
        let share = self.strip.map_or(1.0, |strip| strip.share(piece.middle[0]));
        [0.0, -self.pressure * share * piece.outward[1].max(0.0)]
    }
}

impl Fields {
    /// The largest pressure that all loads together may put on a face, and wells on the pores, Pa.
    pub fn largest_load(&self) -> f64 {
        let weight = self.water.map_or(0.0, |w| w.unit_weight);
        let size = |load: &FaceLoad| match load.bearing {
            Bearing::Traction { pressure, shear, .. } => pressure.hypot(shear) * load.course.most(),
            Bearing::Reservoir => weight * load.course.most(),
        };
        self.surcharge.map_or(0.0, |s| s.pressure.abs())
            + self.loads.iter().map(size).sum::<f64>()
            + self.largest_push()
            + self.largest_given()
            + self.well_pressure()
    }

    /// The size of the pore pressure that the wells make, Pa: that of steady flow from the whole soil, or what they take over the
    /// conductivity of plane strain.
    pub fn well_pressure(&self) -> f64 {
        let Some(water) = self.water else { return 0.0 };
        let extent = if self.dimension == Dimension::Column { self.height / self.width } else { 1.0 };
        let rates = self.wells.iter().map(|well| well.rate.abs() * well.course.most()).sum::<f64>();
        rates * extent / water.mobility()
    }

    /// The largest stress that plates which are moved put on the soil between them and the other side, Pa.
    fn largest_push(&self) -> f64 {
        let duration = self.longest_time();
        let strain = |plate: &MovedPlate| {
            let extent = if matches!(plate.on, Side::Left | Side::Right) { self.width } else { self.height };
            (plate.displacement.abs() * plate.course.most() + plate.velocity.abs() * duration) / extent
        };
        self.oedometer_modulus() * self.plates.iter().map(strain).sum::<f64>()
    }

    /// The largest pressure that they put on the whole top, Pa.
    pub fn load_on_top(&self) -> f64 {
        let on_top = |load: &FaceLoad| match load.bearing {
            Bearing::Traction { pressure, water: false, .. } if load.on == Some(Side::Top) => {
                pressure * load.course.most()
            }
            _ => 0.0,
        };
        self.surcharge.map_or(0.0, |s| s.pressure) + self.loads.iter().map(on_top).sum::<f64>()
    }

    /// Whether water stands against the soil.
    pub fn has_water_outside(&self) -> bool {
        self.loads.iter().any(FaceLoad::is_water)
    }

    /// Pieces of the outline that bear a load.
    pub fn pieces_under(&self, load: &FaceLoad) -> Vec<Piece> {
        let outline = self.outline_or_box();
        let all = pieces(&outline, self.spacing()).filter(|piece| self.bears(load, piece));
        all.filter_map(|piece| load.part_of(&piece)).collect()
    }

    /// Whether a piece of the outline bears a load, all of it or in part.
    pub fn bears(&self, load: &FaceLoad, piece: &Piece) -> bool {
        (load.on.is_some() || !self.holds(piece)) && load.part_of(piece).is_some()
    }

    /// Whether a piece of the outline lies on a side of the mesh that is fixed, or that is no side because it is periodic.
    fn holds(&self, piece: &Piece) -> bool {
        let ends = [0.0, self.width, 0.0, self.height];
        Side::ALL.into_iter().any(|side| {
            let (i, axis) = (side as usize, usize::from(side as usize > 1));
            let held = self.solid_sides[i] != SolidSide::Free || (self.periodic && axis == 0);
            held && piece.outward[1 - axis] == 0.0
                && piece.looks_to(side)
                && (piece.middle[axis] - ends[i]).abs() < 1e-9 * ends[i].max(self.cell)
        })
    }
}

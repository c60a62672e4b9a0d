//! Loads on the faces of the soil, and how they go on in time.

use serde::{Deserialize, Serialize};

use super::{Fields, Side, Surcharge};

/// How something goes on in time and along the soil: a factor on its size.
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
    /// A wave that runs to the right, `cos(2 pi (x/length - t/period))`.
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

    /// The same as courses that do not depend on the place, each with its factor at a place along x (m).
    pub fn parts(&self) -> Vec<(Self, Box<dyn Fn(f64) -> f64>)> {
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

/// A load on outer faces of the soil.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaceLoad {
    /// It acts on faces that look there.
    pub on: Side,
    /// Only between these places along x, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x: Option<[f64; 2]>,
    /// Only between these heights, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y: Option<[f64; 2]>,
    /// Normal to the face, into the soil, Pa.
    pub pressure: f64,
    /// Along the face, clockwise around the soil (to the right on top), Pa.
    pub shear: f64,
    /// How it goes on in time.
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

impl FaceLoad {
    /// Force on a piece that bears all of it where its factor is 1, N for 1 m.
    pub fn force(&self, piece: &Piece) -> [f64; 2] {
        let [x, y] = piece.outward;
        // Clockwise from the outward normal.
        [-self.pressure * x + self.shear * y, -self.pressure * y - self.shear * x]
    }

    /// The part of a piece that bears it, if there is one.
    pub fn part_of(&self, piece: &Piece) -> Option<Piece> {
        let sign = if matches!(self.on, Side::Left | Side::Bottom) { -1.0 } else { 1.0 };
        let axis = usize::from(matches!(self.on, Side::Bottom | Side::Top));
        let [nx, ny] = piece.outward;
        if sign * piece.outward[axis] <= 1e-9 * nx.hypot(ny) {
            return None;
        }
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
            middle: std::array::from_fn(|d| piece.middle[d] + middle * along[d]),
            outward: piece.outward.map(|n| length * n),
        })
    }
}

impl Surcharge {
    /// Its force on a piece of the outline of the soil, N for 1 m: vertical, on what looks up.
    pub fn force(&self, piece: &Piece) -> [f64; 2] {
        let share = self.strip.map_or(1.0, |strip| strip.share(piece.middle[0]));
        [0.0, -self.pressure * share * piece.outward[1].max(0.0)]
    }
}

impl Fields {
    /// The largest pressure that all loads together may put on a face, Pa.
    pub fn largest_load(&self) -> f64 {
        let size = |load: &FaceLoad| load.pressure.hypot(load.shear) * load.course.most();
        self.surcharge.map_or(0.0, |s| s.pressure.abs()) + self.loads.iter().map(size).sum::<f64>()
    }
}

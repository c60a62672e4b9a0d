//! Equilibrium of the soil under given pressures: damped steps until the forces balance, or until it is clear that they
//! never will.
//!
//! No verdict depends on a time limit alone. Soil is stable when it has come to rest. It slides when its rate no longer decays: over the
//! second half of the time it moved nearly as fast as over the quarter before, and in all by more than the elastic displacement.
//! A rate that falls like 1/t halves from one to the other. What does neither within the patience is undecided.

use super::events::{First, Moved, Which};
use super::scales::Scales;
use crate::step::{Failing, Fault, Pace};
use crate::water::Pressures;

/// Balanced: what is left of the forces on the nodes, as a share of them.
const BALANCED: f64 = 3e-4;
/// Steps between two samples.
const STEPS: u64 = 50;
/// A soil is at rest when so many samples in a row find it balanced.
const LOOKS: u32 = 2;
/// Rates are first compared after so many periods, then whenever the time has doubled.
const FIRST_PERIODS: f64 = 16.0;
/// Times that the time doubles before patience ends, and the periods that this makes.
const DOUBLINGS: u32 = 5;
const PERIODS: f64 = 512.0;
/// A rate decays if it falls at least to this share from a quarter of the time to the half after it.
const DECAYS: f64 = 0.75;

/// How the soil is brought to rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patience {
    /// Length of a step, s.
    pub dt: f64,
    /// Scales of the soil as it is now.
    pub scales: Scales,
    /// The soil that is monitored, and how far it has to have moved before it slides, m.
    pub slides: (Which, f64),
    /// Soil of which a particle has moved further is not waited for, m.
    pub most: f64,
}

/// What became of the soil.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// It came to rest.
    Stands,
    /// It slides.
    Slides,
    /// It still slows down when patience ends.
    Undecided,
}

/// How it went.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Equilibrated {
    /// What became of it.
    pub outcome: Outcome,
    /// Steps it took.
    pub steps: u64,
    /// What had moved at the end.
    pub moved: Moved,
}

impl Equilibrated {
    /// Whether the soil came to rest.
    pub fn at_rest(&self) -> bool {
        self.outcome == Outcome::Stands
    }

    /// What it does, in words.
    pub fn said(&self) -> String {
        let [x, y] = self.moved.most_at_m;
        match self.outcome {
            Outcome::Stands => "comes to rest".to_owned(),
            Outcome::Slides => format!("slides without slowing down, most at ({x:.3}, {y:.3}) m"),
            Outcome::Undecided => format!(
                "still moves after {PERIODS} periods of its first swing, though more and more slowly, most at ({x:.3}, {y:.3}) m: \
                 whether it stands is undecided"
            ),
        }
    }
}

/// Lets the soil come to rest.
///
/// # Errors
/// Where and what went wrong in a step.
pub fn equilibrate(model: &mut dyn Failing, first: &First, patience: &Patience) -> Result<Equilibrated, Fault> {
    let Patience { dt, scales, slides: (which, beyond), most } = *patience;
    let (mut steps, mut looks, mut doublings) = (0, 0, 0);
    let start = first.moved(model).most_m;
    let (damping, calm) = (scales.damping(), scales.calm());
    let pace = Pace { dt, steps: STEPS, damping, pressures: Pressures::Held };
    // Places at the start, and at the quarter and the half of the time of the next comparison.
    let places = |model: &dyn Failing| first.places(model);
    let origin = places(model);
    let (mut quarter, mut half) = (Vec::new(), Vec::new());
    let mut until = FIRST_PERIODS * scales.period;
    loop {
        let mut done = 0;
        let outcome = model.move_soil(&pace, &mut done);
        steps += done;
        outcome?;
        let (unbalanced, speed) = (model.unbalanced(), model.grid_speed());
        if speed.is_nan() {
            return Err(Fault { place: "the whole soil".into(), what: "a velocity that is not a number".into() });
        }
        looks = if unbalanced < BALANCED && speed < calm { looks + 1 } else { 0 };
        let time = steps as f64 * dt;
        let mut ended = (looks >= LOOKS).then_some(Outcome::Stands);
        if (steps / STEPS).is_multiple_of(8) && first.moved(model).most_m - start > most {
            ended = ended.or(Some(Outcome::Slides));
        }
        if quarter.is_empty() && time >= 0.25 * until {
            quarter = places(model);
        }
        if half.is_empty() && time >= 0.5 * until {
            half = places(model);
        }
        if time >= until && ended.is_none() {
            let now = places(model);
            let rate = |from: &[[f64; 2]], to: &[[f64; 2]], span: f64| first.way(which, from, to) / span;
            let (before, after) = (rate(&quarter, &half, 0.25 * until), rate(&half, &now, 0.5 * until));
            if after < calm {
                // The surface may keep raveling: the monitored soil has come to rest.
                ended = Some(Outcome::Stands);
            } else if after > DECAYS * before && first.way(which, &origin, &now) > beyond {
                ended = Some(Outcome::Slides);
            } else if doublings == DOUBLINGS {
                ended = Some(Outcome::Undecided);
            }
            (doublings, until) = (doublings + 1, 2.0 * until);
            (quarter, half) = (half, now);
        }
        if let Some(outcome) = ended {
            return Ok(Equilibrated { outcome, steps, moved: first.moved(model) });
        }
    }
}

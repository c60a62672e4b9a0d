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
    /// Periods after which rates are first compared, and how often in each doubling of the time from then on.
    pub compared: (f64, usize),
    /// Mass-proportional damping, 1/s.
    pub damping: f64,
    /// Soil that is slower is at rest, m/s.
    pub slow: f64,
    /// Elastic energy that a steady slide may store, as a share of the work of gravity.
    pub steady: f64,
    /// Periods after which patience ends.
    pub periods: f64,
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
    /// Speed of the monitored soil over the second half of the time, m/s; zero where it came to rest before it was compared.
    pub speed: f64,
    /// Elastic energy stored or released over the same time, as a share of the work of gravity: nothing of it in a steady slide.
    pub stored: f64,
    /// Periods of the first swing that it took.
    pub periods: f64,
}

impl std::fmt::Display for Outcome {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Stands => "stands",
            Self::Slides => "slides",
            Self::Undecided => "is undecided",
        })
    }
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
                "still moves after {:.0} periods of its first swing, though more and more slowly, most at ({x:.3}, {y:.3}) m: \
                 whether it stands is undecided",
                self.periods
            ),
        }
    }
}

/// Lets the soil come to rest.
///
/// # Errors
/// Where and what went wrong in a step.
pub fn equilibrate(model: &mut dyn Failing, first: &First, patience: &Patience) -> Result<Equilibrated, Fault> {
    let Patience { dt, scales, slides: (which, beyond), most, compared, slow, .. } = *patience;
    let (first_compared, each_doubling) = compared;
    let (mut steps, mut looks, mut last, mut stored) = (0, 0, 0.0, 0.0);
    let start = first.moved(model).most_m;
    let (damping, calm) = (patience.damping, scales.calm());
    let pace = Pace { dt, steps: STEPS, damping, pressures: Pressures::Held };
    // Places at times of a geometric sequence, of which the first is a quarter of that of the first comparison.
    let origin = first.places(model);
    let mut marks: Vec<Mark> = Vec::new();
    let longer = 2_f64.powf(1.0 / each_doubling as f64);
    let mut mark = 0.25 * first_compared * scales.period;
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
        if time >= mark * (1.0 - 1e-12) && ended.is_none() {
            let now = Mark::of(model, first, time);
            if let Some(quarter) = marks.len().checked_sub(2 * each_doubling) {
                let (quarter, half) = (&marks[quarter], &marks[quarter + each_doubling]);
                let rate = |from: &Mark, to: &Mark| first.way(which, &from.places, &to.places) / (to.time - from.time);
                last = rate(half, &now);
                stored = ((now.strain_j - half.strain_j) / (now.work_j - half.work_j)).abs();
                if last < slow {
                    // The surface may keep raveling: the monitored soil has come to rest.
                    ended = Some(Outcome::Stands);
                } else if last > DECAYS * rate(quarter, half)
                    && stored < patience.steady
                    && first.way(which, &origin, &now.places) > beyond
                {
                    ended = Some(Outcome::Slides);
                } else if time >= patience.periods * scales.period {
                    ended = Some(Outcome::Undecided);
                }
            }
            marks.push(now);
            mark *= longer;
        }
        if let Some(outcome) = ended {
            let periods = time / scales.period;
            return Ok(Equilibrated { outcome, steps, moved: first.moved(model), speed: last, stored, periods });
        }
    }
}

/// The soil at a time.
struct Mark {
    /// s since it was left to itself.
    time: f64,
    /// Where the particles are, by their numbers, m.
    places: Vec<[f64; 2]>,
    /// Elastic energy and the work of gravity so far, J.
    strain_j: f64,
    work_j: f64,
}

impl Mark {
    fn of(model: &dyn Failing, first: &First, time: f64) -> Self {
        let balance = model.observe().1;
        Self { time, places: first.places(model), strain_j: balance.strain_j, work_j: balance.gravity_work_j }
    }
}

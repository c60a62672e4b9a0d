//! The factor of safety by strength reduction: the strength divided by a factor, until the deep slide starts.
//!
//! Water is frozen, and the soil so stiff that its shape stays as it is ([`Scales::stiffening`]): the limit load of a soil does not
//! depend on its stiffness, and displacements of a small-strain analysis are what failure is read from. Whether a slope stands
//! with a strength is found by damped steps ([`equilibrate`]); the factor between standing and sliding is bracketed, led by the speed of
//! the slide, which is proportional to the strength that it lacks (Matsui & San 1992, doi:10.3208/sandf1972.32.59; Griffiths & Lane 1999, doi:10.1680/geot.1999.49.3.387). A trial
//! that is neither decides nothing: the bracket stays as wide as that.

use super::equilibrate::{Equilibrated, Outcome, Patience, equilibrate};
use super::events::{First, Which};
use super::scales::Scales;
use crate::checkpoint::{restore, save};
use crate::constitutive::Altered;
use crate::observe::SolidState;
use crate::order::sort_by_number;
use crate::scene::Reduction;
use crate::step::{Failing, Fault, Pace};
use crate::water::Pressures;

/// The factor between two others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bracket {
    /// It stands with its strength divided by this; zero if it stands with no factor of the range.
    pub low: f64,
    /// It slides with its strength divided by this; infinite if it slides with no factor of the range. Found from a trial, or from
    /// two whose speeds fall to zero half a width below.
    pub high: f64,
    /// Trials that it took.
    pub trials: u32,
    /// Steps that they took.
    pub steps: u64,
    /// Least and largest factor at which it neither came to rest nor slid within the patience of a trial, if there are such.
    pub undecided: Option<[f64; 2]>,
}

/// A particle of soil that slides at the lowest factor at which it did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sliding {
    /// Where it is, m.
    pub x: [f64; 2],
    /// Its velocity, m/s; only its direction and its ratio to others mean something.
    pub velocity: [f64; 2],
    /// Rate of its deviator strain, 1/s.
    pub shear_rate: f64,
    /// Volume, m3.
    pub volume: f64,
}

/// A trial with a reduced strength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trial {
    /// The strength was divided by this.
    pub factor: f64,
    /// What became of the soil.
    pub outcome: Outcome,
    /// Steps it took.
    pub steps: u64,
    /// Speed of the slide at its end in g over damping: about the share of its strength that the soil lacks, times the sine of the slip surface.
    pub speed: f64,
    /// Elastic energy stored or released over the second half of the time, as a share of the work of gravity.
    pub stored: f64,
}

/// What a search has found.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// The factor.
    pub bracket: Bracket,
    /// The trials in their order.
    pub trials: Vec<Trial>,
    /// How the soil slides at its upper end, by the numbers of the particles; empty if it never did.
    pub mechanism: Vec<Sliding>,
}

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Which flow rule goes with the reduced strength.
    pub by: Reduction,
    /// Width of the bracket.
    pub within: f64,
    /// The first factor to be tried.
    pub guess: f64,
}

impl Default for Search {
    fn default() -> Self {
        Self { by: Reduction::AsGiven, within: 0.01, guess: 1.0 }
    }
}

/// Range of factors.
pub(super) const RANGE: [f64; 2] = [0.2, 10.0];
/// First stride from the guess.
const FIRST_STRIDE: f64 = 0.08;
/// Narrowest bracket.
const NARROW: f64 = 1e-4;
/// A trial compares rates after so many periods first, and twice in each doubling of the time.
const COMPARED: (f64, usize) = (4.0, 2);
/// Soil that lacks this share of its strength at most is taken to stand: it would slide more slowly than one can wait for.
const LACKS: f64 = 2e-3;
/// Damping of a trial over that which is half critical for the first swing: soil that yields is softer, and what is too strongly
/// damped creeps to its place.
const DAMPING: f64 = 0.35;
/// Elastic energy that a steady slide stores at most, over the work of gravity.
const STEADY: f64 = 0.1;
/// Periods of the first swing after which a trial that still slows down is left: its speed says how far it is from standing.
const PERIODS: f64 = 32.0;
/// How many times as far as its speed says.
const CAUTION: f64 = 1.5;
/// Speed of a damped slide that lacks all of its strength, in g/damping: about the sine of a slip surface. It only chooses the next trial.
const GAIN: f64 = 0.4;

/// A soil of which trials are made.
#[derive(Debug, Clone, Copy)]
pub struct Trials<'a> {
    /// Outline of the soil, m.
    pub outline: &'a [[f64; 2]],
    /// Scales of the scene.
    pub scales: Scales,
    /// Length of a step with the stiffness of the scene, s.
    pub dt: f64,
}

/// Brackets the factor of safety of the state of a model. The model is left as it was.
///
/// Each trial starts from the state that the soil has come to rest in at the largest factor so far, and slip does not weaken
/// the base on the way.
///
/// # Errors
/// Where and what went wrong in a step.
pub fn bracket(
    model: &mut dyn Failing,
    trials: &Trials,
    search: &Search,
    progress: &mut dyn FnMut(&Bracket, &Trial),
) -> Result<Found, Fault> {
    let first = save(|archive| model.save_or_restore(archive));
    let mut rests: Option<Vec<u8>> = None;
    let mut mechanism = (f64::INFINITY, Vec::new());
    let speed = 1.0 / Patience::trial(&trials.scales, trials.dt).slide();
    model.freeze_slip(true);
    let (within, guess) = (search.within.max(NARROW), search.guess.clamp(RANGE[0], RANGE[1]));
    // Trials that went wrong leave a wreck, which must not stay either.
    let found = seek(within, guess, progress, &mut |factor| {
        go_back(model, rests.as_ref().unwrap_or(&first))?;
        let settled = trials.with_strength(model, factor, search.by)?;
        match settled.outcome {
            Outcome::Stands => rests = Some(save(|archive| model.save_or_restore(archive))),
            Outcome::Slides if factor < mechanism.0 => mechanism = (factor, trials.sliding(model)?),
            Outcome::Slides | Outcome::Undecided => {}
        }
        let Equilibrated { outcome, steps, stored, .. } = settled;
        Ok(Trial { factor, outcome, steps, speed: settled.speed * speed, stored })
    });
    model.freeze_slip(false);
    model.alter(&Altered::NOTHING);
    go_back(model, &first)?;
    let (bracket, trials) = found?;
    Ok(Found { bracket, trials, mechanism: mechanism.1 })
}

/// What trials have shown so far.
#[derive(Debug, Default)]
struct Shown {
    /// The largest factor at which it stood, or must by the speed at which it still moved.
    stands: Option<f64>,
    /// Factors at which it slides and speeds, the lowest last.
    slides: Vec<[f64; 2]>,
    /// Factors at which neither was seen.
    undecided: Vec<f64>,
    /// All factors that were tried.
    tried: Vec<f64>,
    /// Width of the bracket before the last two trials.
    widths: [f64; 2],
}

impl Shown {
    fn take(&mut self, trial: &Trial) {
        self.tried.push(trial.factor);
        let stands = match trial.outcome {
            Outcome::Stands => trial.factor,
            Outcome::Slides => {
                self.slides.push([trial.factor, trial.speed]);
                return;
            }
            // It slows down: with so little more strength as its speed would need it stands.
            Outcome::Undecided => {
                self.undecided.push(trial.factor);
                trial.factor * (1.0 - CAUTION * trial.speed.max(0.0) / GAIN)
            }
        };
        self.stands = Some(self.stands.map_or(stands, |other| other.max(stands)));
    }

    /// The least factor at which it slid.
    fn lowest(&self) -> f64 {
        self.slides.last().map_or(f64::INFINITY, |slide| slide[0])
    }

    /// The factor at which the speed of the slide would be zero: along the line through the two lowest.
    fn at_no_speed(&self) -> Option<f64> {
        let [factor, speed] = *self.slides.last()?;
        let gain = self.slides.iter().rev().nth(1).map(|above| (above[1] - speed) / (above[0] - factor));
        Some(factor - speed / gain.filter(|gain| *gain > 0.0).unwrap_or(GAIN / factor))
    }

    /// The factor at which it slides: the least at which it did, or half a width above where two speeds near by fall to zero.
    fn high(&self, within: f64) -> f64 {
        let (low, high) = (self.stands.unwrap_or(0.0), self.lowest());
        let near =
            self.at_no_speed().filter(|factor| self.slides.len() > 1 && *factor > low && high < factor + 4.0 * within);
        near.map_or(high, |factor| high.min(factor + 0.5 * within))
    }

    /// The next factor to be tried, with strides (up and down) that grow; `None` once all is known to `within`, or no trial would say more.
    fn next(&mut self, within: f64, guess: f64, stride: &mut f64) -> Option<f64> {
        let mut strode = || {
            *stride *= 2.0;
            0.5 * *stride
        };
        let lowest = self.lowest();
        let next = match (self.stands, self.slides.is_empty()) {
            (None, true) => guess,
            (None, false) => {
                let goal = self.at_no_speed().map_or(f64::INFINITY, |factor| factor - 0.5 * within);
                goal.clamp(lowest - 8.0 * strode(), lowest - within).max(RANGE[0])
            }
            (Some(low), true) => (low + strode()).min(RANGE[1]),
            (Some(low), false) => {
                let high = self.high(within);
                if high - low <= within * (1.0 + 1e-9) {
                    return None;
                }
                // Two trials that do not halve the bracket: its middle.
                let slow = self.widths[0] > 0.0 && high - low > 0.5 * self.widths[0];
                self.widths = [self.widths[1], high - low];
                let middle = 0.5 * (low + lowest);
                let led = |factor: f64| {
                    let below = factor - 0.5 * within;
                    // A slide that is slow, but not so slow that it must be waited for; then soil that stands.
                    if lowest > factor + 4.0 * within {
                        factor + 2.0 * within
                    } else if below > low + 0.1 * within {
                        below
                    } else {
                        middle
                    }
                };
                let goal = self.at_no_speed().filter(|factor| !slow && *factor > low).map_or(middle, led);
                goal.clamp(low + 0.25 * within, lowest - 0.25 * within)
            }
        };
        let known = |goal: f64| self.tried.iter().any(|tried| (tried - goal).abs() < 0.2 * within);
        let middle = self.stands.map(|low| 0.5 * (low + lowest)).filter(|middle| middle.is_finite());
        Some(next).filter(|next| !known(*next)).or(middle.filter(|middle| !known(*middle)))
    }
}

fn seek(
    within: f64,
    guess: f64,
    progress: &mut dyn FnMut(&Bracket, &Trial),
    tried: &mut dyn FnMut(f64) -> Result<Trial, Fault>,
) -> Result<(Bracket, Vec<Trial>), Fault> {
    let mut trials = Vec::new();
    let mut bracket = Bracket { low: RANGE[0], high: RANGE[1], trials: 0, steps: 0, undecided: None };
    let (mut shown, mut stride) = (Shown::default(), FIRST_STRIDE * guess);
    while let Some(factor) = shown.next(within, guess, &mut stride) {
        // Factors that print as they are meant.
        let factor = (1e4 * factor).round() / 1e4;
        let trial = tried(factor)?;
        bracket.steps += trial.steps;
        bracket.trials += 1;
        shown.take(&trial);
        trials.push(trial);
        // No factor beyond the range is tried.
        let last = factor >= RANGE[1] && shown.slides.is_empty() || factor <= RANGE[0] && shown.stands.is_none();
        bracket.low = shown.stands.unwrap_or(if last { 0.0 } else { RANGE[0] });
        bracket.high = match shown.slides.is_empty() {
            false => shown.high(within),
            true if last => f64::INFINITY,
            true => RANGE[1],
        };
        let inside = shown.undecided.iter().filter(|factor| **factor > bracket.low && **factor < bracket.high);
        bracket.undecided = inside.fold(None, |ends, factor| {
            let [low, high] = ends.unwrap_or([*factor; 2]);
            Some([low.min(*factor), high.max(*factor)])
        });
        progress(&bracket, &trial);
        if last {
            break;
        }
    }
    Ok((bracket, trials))
}

/// Restores a state that the model was saved in.
pub(super) fn go_back(model: &mut dyn Failing, state: &[u8]) -> Result<(), Fault> {
    let restored = restore(state, |archive| model.save_or_restore(archive));
    restored.map_err(|e| Fault { place: "a saved state".into(), what: e.to_string() })
}

impl Trials<'_> {
    /// Lets the stiffened soil come to rest with its strength divided by a factor, or slide.
    ///
    /// # Errors
    /// Where and what went wrong in a step.
    pub fn with_strength(&self, model: &mut dyn Failing, factor: f64, by: Reduction) -> Result<Equilibrated, Fault> {
        model.stop();
        model.count_from_here();
        let patience = Patience::trial(&self.scales, self.dt);
        let first = First::of(model, self.outline, &[], &patience.scales);
        model.alter(&Altered { factor, by, stiffness: self.scales.stiffening() });
        equilibrate(model, &first, &patience)
    }

    /// How soil that slides now does so: velocities, and strains over half a period from now.
    fn sliding(&self, model: &mut dyn Failing) -> Result<Vec<Sliding>, Fault> {
        let Patience { dt, scales, damping, .. } = Patience::trial(&self.scales, self.dt);
        let steps = (0.5 * scales.period / dt).ceil();
        let strains = |model: &dyn Failing| {
            let mut strains = Vec::new();
            model.each(&mut |s| strains.push((s.id, s.deviator_strain)));
            sort_by_number(&mut strains, |(id, _)| f64::from(*id));
            strains
        };
        let before = strains(model);
        let pace = Pace { dt, steps: steps as u64, damping, pressures: Pressures::Held };
        model.move_soil(&pace, &mut 0)?;
        let mut sliding = Vec::with_capacity(before.len());
        model.each(&mut |s| sliding.push((s.id, *s)));
        sort_by_number(&mut sliding, |(id, _)| f64::from(*id));
        let rate = |strain: f64| (strain / (steps * dt)).max(0.0);
        let of = |((_, s), (_, strain)): (&(u32, SolidState), &(u32, f64))| Sliding {
            x: s.x,
            velocity: s.velocity,
            shear_rate: rate(s.deviator_strain - strain),
            volume: s.volume,
        };
        Ok(sliding.iter().zip(&before).map(of).collect())
    }
}

impl Patience {
    /// For stiffened soil that stands as long as what is deep does.
    pub fn stiffened(scales: &Scales, dt: f64) -> Self {
        let times = scales.stiffening();
        Self::of(&scales.stiffened(times), dt / times.sqrt())
    }

    /// For soil of these scales that stands as long as what is deep does.
    pub fn of(scales: &Scales, dt: f64) -> Self {
        let slides = (Which::Deep, scales.settlement);
        let (damping, slow) = (scales.damping(), scales.calm());
        let (most, steady) = (f64::INFINITY, f64::INFINITY);
        Self { dt, scales: *scales, slides, most, compared: (16.0, 1), damping, slow, steady, periods: 512.0 }
    }

    /// The same for soil that may yield: it is softer than its first swing says, and what is damped too strongly creeps to its place.
    pub fn lightly_damped(self) -> Self {
        Self { damping: DAMPING * self.damping, compared: COMPARED, ..self }
    }

    /// For a trial with a reduced strength.
    fn trial(scales: &Scales, dt: f64) -> Self {
        let stiffened = Self::stiffened(scales, dt);
        let damped = stiffened.lightly_damped();
        let slow = LACKS * GAIN * damped.slide();
        Self { slow, steady: STEADY, periods: PERIODS, ..damped }
    }

    /// Speed at which soil without any strength would slide down a vertical face, g over damping, m/s.
    fn slide(&self) -> f64 {
        self.scales.gravity / self.damping
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is found of a slope that stands below one factor, slides above another, and creeps more and more slowly between.
    fn found(stands: f64, slides: f64) -> Bracket {
        let mut tried = |factor: f64| {
            let (outcome, speed) = match factor {
                f if f < stands => (Outcome::Stands, 0.0),
                f if f > slides => (Outcome::Slides, 0.35 * (f / slides - 1.0)),
                _ => (Outcome::Undecided, 1e-3),
            };
            Ok(Trial { factor, outcome, steps: 1, speed, stored: 0.0 })
        };
        seek(0.01, 1.0, &mut |_, _| (), &mut tried).expect("a bracket").0
    }

    #[test]
    fn the_factor_is_bracketed_by_few_trials() {
        for factor in [0.35, 0.62, 0.999, 1.0, 1.3777, 3.9, 8.8] {
            let Bracket { low, high, trials, .. } = found(factor, factor);
            assert!(low < factor && high >= factor && high - low <= 0.0101, "{factor}: {low} {high}");
            assert!(trials <= 10, "{factor}: {trials}");
        }
        // Nothing that was seen lies beyond the ends of the range.
        let [weak, strong] = [found(0.1, 0.1), found(19.0, 19.0)];
        assert_eq!([weak.low, weak.high], [0.0, RANGE[0]]);
        assert_eq!([strong.low, strong.high], [RANGE[1], f64::INFINITY]);
    }

    #[test]
    fn soil_that_creeps_bounds_the_factor_from_below() {
        for (stands, slides) in [(1.2, 1.3), (0.9, 1.1), (0.5, 0.53), (1.1, 2.0)] {
            let Bracket { low, high, .. } = found(stands, slides);
            // By its speed it lacks a quarter of a percent of its strength, with caution.
            assert!(
                low > stands - 0.011 && low < slides && high >= slides && high - low < 0.0201,
                "{stands} {slides}: {low} {high}"
            );
        }
    }
}

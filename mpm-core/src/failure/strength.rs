//! The factor of safety by strength reduction: the strength divided by a factor, until the deep slide starts.
//!
//! Water is frozen, and the soil so stiff that its shape stays as it is ([`Scales::stiffening`]): the limit load of a soil does not
//! depend on its stiffness, and displacements of a small-strain analysis are what failure is read from. Whether a slope stands
//! with a strength is found by damped steps from the same state ([`equilibrate`]); the factor between standing and sliding is bracketed
//! by bisection (Matsui & San 1992, doi:10.3208/sandf1972.32.59; Griffiths & Lane 1999, doi:10.1680/geot.1999.49.3.387). A trial
//! that is neither decides nothing: the bracket stays as wide as that.

use super::equilibrate::{Equilibrated, Outcome, Patience, equilibrate};
use super::events::{First, Which};
use super::scales::Scales;
use crate::checkpoint::{restore, save};
use crate::step::{Failing, Fault};

/// The factor between two others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bracket {
    /// It stands with its strength divided by this; zero if it stands with no factor of the range.
    pub low: f64,
    /// It slides with its strength divided by this; infinite if it slides with no factor of the range.
    pub high: f64,
    /// Trials that it took.
    pub trials: u32,
    /// Steps that they took.
    pub steps: u64,
    /// Least and largest factor at which it neither came to rest nor slid within the patience of a trial, if there are such.
    pub undecided: Option<[f64; 2]>,
}

/// Range of factors.
const RANGE: [f64; 2] = [0.3, 4.0];
/// First stride from a factor of 1.
const FIRST_STRIDE: f64 = 0.08;
/// Narrowest bracket.
const NARROW: f64 = 1e-4;

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

/// Brackets the factor of safety of the state of a model to `within`. The model is left as it was.
///
/// # Errors
/// Where and what went wrong in a step.
pub fn bracket(
    model: &mut dyn Failing,
    trials: &Trials,
    within: f64,
    progress: &mut dyn FnMut(&Bracket),
) -> Result<Bracket, Fault> {
    let state = save(|archive| model.save_or_restore(archive));
    // Trials that went wrong leave a wreck, which must not stay either.
    let found = search(within.max(NARROW), progress, &mut |factor| {
        go_back(model, &state)?;
        trials.with_strength(model, factor)
    });
    model.alter(1.0, 1.0);
    go_back(model, &state)?;
    found
}

/// What trials have shown so far.
#[derive(Debug, Default)]
struct Shown {
    stands: Option<f64>,
    slides: Option<f64>,
    /// Least and largest factor between the two at which neither was seen.
    undecided: Option<[f64; 2]>,
}

impl Shown {
    fn take(&mut self, factor: f64, outcome: Outcome) {
        match outcome {
            Outcome::Stands => self.stands = Some(factor),
            Outcome::Slides => self.slides = Some(factor),
            Outcome::Undecided => {
                let [low, high] = self.undecided.unwrap_or([factor; 2]);
                self.undecided = Some([low.min(factor), high.max(factor)]);
            }
        }
        // What lies beyond a factor that was decided later says nothing any more.
        let (stands, slides) = (self.stands.unwrap_or(0.0), self.slides.unwrap_or(f64::INFINITY));
        self.undecided = self.undecided.filter(|[low, high]| *low > stands && *high < slides);
    }

    /// The next factor to be tried, with strides (up and down) that grow; `None` once all is known to `within`.
    fn next(&self, within: f64, stride: &mut f64) -> Option<f64> {
        let wide = |low: f64, high: f64| high - low > within * (1.0 + 1e-9);
        let mut strode = || {
            *stride *= 2.0;
            0.5 * *stride
        };
        match (self.stands, self.slides, self.undecided) {
            (None, None, None) => Some(1.0),
            (None, slides, undecided) => {
                let from = undecided.map(|[low, _]| low).or(slides)?;
                Some((from - strode()).max(RANGE[0]))
            }
            (Some(stands), None, undecided) => {
                Some((undecided.map_or(stands, |[_, high]| high) + strode()).min(RANGE[1]))
            }
            (Some(low), Some(high), None) => wide(low, high).then_some(0.5 * (low + high)),
            (Some(low), Some(_), Some([from, _])) if wide(low, from) => Some(0.5 * (low + from)),
            (Some(_), Some(high), Some([_, to])) => wide(to, high).then_some(0.5 * (to + high)),
        }
    }
}

fn search(
    within: f64,
    progress: &mut dyn FnMut(&Bracket),
    tried: &mut dyn FnMut(f64) -> Result<Equilibrated, Fault>,
) -> Result<Bracket, Fault> {
    let mut bracket = Bracket { low: RANGE[0], high: RANGE[1], trials: 0, steps: 0, undecided: None };
    let (mut shown, mut stride) = (Shown::default(), FIRST_STRIDE);
    while let Some(factor) = shown.next(within, &mut stride) {
        // Sums of strides that print as they are meant.
        let factor = (1e9 * factor).round() / 1e9;
        let settled = tried(factor)?;
        bracket.steps += settled.steps;
        bracket.trials += 1;
        shown.take(factor, settled.outcome);
        // No factor beyond the range is tried.
        let last = factor >= RANGE[1] && shown.slides.is_none() || factor <= RANGE[0] && shown.stands.is_none();
        bracket.low = shown.stands.unwrap_or(if last { 0.0 } else { RANGE[0] });
        bracket.high = shown.slides.unwrap_or(if last { f64::INFINITY } else { RANGE[1] });
        bracket.undecided = shown.undecided;
        progress(&bracket);
        if last {
            break;
        }
    }
    Ok(bracket)
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
    pub fn with_strength(&self, model: &mut dyn Failing, factor: f64) -> Result<Equilibrated, Fault> {
        // Slip stays: a base that has weakened is weak. None is added to speak of.
        model.stop();
        model.count_from_here();
        let patience = Patience::stiffened(&self.scales, self.dt);
        let first = First::of(model, self.outline, &[], &patience.scales);
        model.alter(factor, self.scales.stiffening());
        equilibrate(model, &first, &patience)
    }
}

impl Patience {
    /// For stiffened soil that stands as long as what is deep does.
    pub fn stiffened(scales: &Scales, dt: f64) -> Self {
        let times = scales.stiffening();
        let scales = scales.stiffened(times);
        Self { dt: dt / times.sqrt(), scales, slides: (Which::Deep, scales.settlement), most: f64::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::failure::Moved;

    /// What is found of a slope that stands below one factor, slides above another, and is undecided between.
    fn found(stands: f64, slides: f64) -> Bracket {
        let mut tried = |factor: f64| {
            let outcome = match factor {
                f if f < stands => Outcome::Stands,
                f if f > slides => Outcome::Slides,
                _ => Outcome::Undecided,
            };
            Ok(Equilibrated { outcome, steps: 1, moved: Moved::default() })
        };
        search(0.01, &mut |_| (), &mut tried).expect("a bracket")
    }

    #[test]
    fn what_is_undecided_widens_the_bracket_and_is_told() {
        for factor in [0.35, 0.62, 0.999, 1.0, 1.3777, 3.9] {
            let Bracket { low, high, undecided, .. } = found(factor, factor);
            assert!(
                low < factor && high >= factor && high - low <= 0.0101 || undecided.is_some(),
                "{factor}: {low} {high}"
            );
        }
        for (stands, slides) in [(1.2, 1.3), (0.9, 1.1), (0.5, 0.53), (1.1, 2.0)] {
            let Bracket { low, high, undecided, .. } = found(stands, slides);
            let [from, to] = undecided.expect("trials that decide nothing");
            assert!(low < stands && high > slides, "{low} {high}");
            assert!(from >= stands && to <= slides && from - low <= 0.0101 && high - to <= 0.0101, "{from} {to}");
        }
        // Nothing that was seen lies beyond the ends of the range.
        let [weak, strong] = [found(0.1, 0.1), found(9.0, 9.0)];
        assert_eq!([weak.low, weak.high], [0.0, 0.3]);
        assert_eq!([strong.low, strong.high], [4.0, f64::INFINITY]);
    }
}

//! The factor of safety by strength reduction: the strength divided by a factor, until the deep slide starts.
//!
//! Water is frozen. Whether a slope stands with a strength is found by damped steps from the same state; the factor between
//! standing and sliding is bracketed by bisection (Matsui & San 1992, doi:10.3208/sandf1972.32.59; Griffiths & Lane 1999,
//! doi:10.1680/geot.1999.49.3.387).

use super::settle::{GivesUp, Patience, Settled, settle};
use super::watch::First;
use crate::keep::Keeper;
use crate::step::{Failing, Fault};

/// The factor between two others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bracket {
    /// It stands with its strength divided by this; zero if it slides with any that is looked at.
    pub low: f64,
    /// It slides with its strength divided by this; infinite if it stands with any that is looked at.
    pub high: f64,
    /// Trials that it took.
    pub trials: u32,
    /// Steps that they took.
    pub steps: u64,
}

/// Factors that are looked at.
const RANGE: [f64; 2] = [0.3, 4.0];
/// Narrowest bracket.
const NARROW: f64 = 1e-4;

/// Brackets the factor of safety of the state of a model to `within`. The model is left as it was.
///
/// # Errors
/// Where and what went wrong in a step.
pub fn bracket(
    model: &mut dyn Failing,
    outline: &[[f64; 2]],
    patience: &Patience,
    within: f64,
    progress: &mut dyn FnMut(&Bracket),
) -> Result<Bracket, Fault> {
    let mut keeper = Keeper::writes();
    model.keep(&mut keeper);
    let state = keeper.into_bytes();
    // Trials that went wrong leave a wreck, which must not stay either.
    let found = search(model, &state, outline, patience, within.max(NARROW), progress);
    model.weaken(1.0);
    restore(model, &state)?;
    found
}

fn search(
    model: &mut dyn Failing,
    state: &[u8],
    outline: &[[f64; 2]],
    patience: &Patience,
    within: f64,
    progress: &mut dyn FnMut(&Bracket),
) -> Result<Bracket, Fault> {
    let mut bracket = Bracket { low: RANGE[0], high: RANGE[1], trials: 0, steps: 0 };
    let mut factor: f64 = 1.0;
    let mut stride: f64 = 0.08;
    let (mut has_low, mut has_high) = (false, false);
    while !(has_low && has_high) || bracket.high - bracket.low > within * (1.0 + 1e-9) {
        restore(model, state)?;
        let settled = with_strength(model, outline, patience, factor)?;
        bracket.steps += settled.steps;
        bracket.trials += 1;
        if !settled.moved.events()[1] {
            (bracket.low, has_low) = (factor, true);
        } else {
            (bracket.high, has_high) = (factor, true);
        }
        // Nothing is looked at beyond the ends of the range.
        if !has_high && factor >= RANGE[1] {
            (bracket.high, has_high) = (f64::INFINITY, true);
        } else if !has_low && factor <= RANGE[0] {
            (bracket.low, has_low) = (0.0, true);
        }
        progress(&bracket);
        if bracket.low == 0.0 || bracket.high == f64::INFINITY {
            break;
        }
        factor = match (has_low, has_high) {
            (true, true) => 0.5 * (bracket.low + bracket.high),
            // Looks for the other end in strides that grow.
            (true, false) => (bracket.low + stride).min(bracket.high),
            _ => (bracket.high - stride).max(bracket.low),
        };
        if !(has_low && has_high) {
            stride *= 2.0;
        }
        // Sums of strides that print as they are meant.
        factor = (1e9 * factor).round() / 1e9;
    }
    Ok(bracket)
}

fn restore(model: &mut dyn Failing, state: &[u8]) -> Result<(), Fault> {
    let mut keeper = Keeper::reads(state.to_vec());
    model.keep(&mut keeper);
    keeper.finish().map_err(|e| Fault { place: "a kept state".into(), what: e.to_string() })
}

/// Lets the soil come to rest with its strength divided by a factor, or slide.
///
/// # Errors
/// Where and what went wrong in a step.
pub fn with_strength(
    model: &mut dyn Failing,
    outline: &[[f64; 2]],
    patience: &Patience,
    factor: f64,
) -> Result<Settled, Fault> {
    // Slip stays: a base that has weakened is weak.
    model.count_from_here();
    let first = First::of(model, outline, &[]);
    model.weaken(factor);
    settle(model, &first, &Patience { until: GivesUp::Failed, ..*patience })
}

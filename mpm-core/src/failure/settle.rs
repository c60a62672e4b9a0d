//! Bringing the soil to rest under pressures that are held: damped steps until the forces balance, or until they never will.

use super::watch::{First, Moved};
use crate::step::{Failing, Fault, Pace};
use crate::water::Pressures;

/// Balanced: what is left of the forces on the nodes, as a share of them.
const BALANCED: f64 = 3e-4;
/// At rest: no node faster than this, m/s. Balanced forces alone let a toe pass that creeps and would fail without damping.
const SLOW: f64 = 1e-4;
/// Steps between two looks.
const STEPS: u64 = 50;
/// A soil is at rest when so many looks in a row find it balanced.
const LOOKS: u32 = 2;

/// How long to wait.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patience {
    /// Length of a step, s.
    pub dt: f64,
    /// Damping, 1/s.
    pub damping: f64,
    /// Give up after so many steps.
    pub steps: u64,
    /// Give up once this has happened.
    pub until: GivesUp,
}

/// What tells that a soil will not come to rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GivesUp {
    /// A particle has moved so far, m.
    Moved(f64),
    /// The deep slide: E2.
    Failed,
    /// Nothing but its patience.
    Never,
}

/// How it went.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settled {
    /// Whether the soil came to rest.
    pub at_rest: bool,
    /// Steps it took.
    pub steps: u64,
    /// What had moved at the end.
    pub moved: Moved,
}

/// Lets the soil come to rest.
///
/// # Errors
/// Where and what went wrong in a step.
pub fn settle(model: &mut dyn Failing, first: &First, patience: &Patience) -> Result<Settled, Fault> {
    let mut steps = 0;
    let mut looks = 0;
    let start = first.moved(model).most_m;
    let pace = Pace { dt: patience.dt, steps: STEPS, damping: patience.damping, pressures: Pressures::Held };
    loop {
        let mut done = 0;
        let outcome = model.move_soil(&pace, &mut done);
        steps += done;
        outcome?;
        let (unbalanced, speed) = (model.unbalanced(), model.grid_speed());
        if speed.is_nan() {
            return Err(Fault { place: "the whole soil".into(), what: "a velocity that is not a number".into() });
        }
        let calm = unbalanced < BALANCED && speed < SLOW;
        looks = if calm { looks + 1 } else { 0 };
        let late = steps >= patience.steps;
        if looks >= LOOKS || late || (steps / STEPS).is_multiple_of(8) {
            let moved = first.moved(model);
            let at_rest = looks >= LOOKS;
            let gives_up = match patience.until {
                GivesUp::Moved(most) => moved.most_m - start > most,
                GivesUp::Failed => moved.events()[1],
                GivesUp::Never => false,
            };
            if at_rest || late || gives_up {
                return Ok(Settled { at_rest, steps, moved });
            }
        }
    }
}

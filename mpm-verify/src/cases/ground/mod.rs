//! Ground of several soils, at rest under what engineers meet: seepage along, across and through layers, zones and slopes;
//! consolidation of layers and of columns that end within a cell; a strip of load; rain; slopes of several soils.

mod consolidation;
mod flow;
mod free;
mod slopes;
mod strip;

use super::Program;
use super::setup::{Measured, Setup, case, refined};

/// All of them.
pub const CASES: [Program; 24] = {
    let [a, b, c, d, e, f] = flow::CASES;
    let [g, h, i, j, k, l, x] = consolidation::CASES;
    let [m, n, o, p, q] = free::CASES;
    let [r, s, v, w] = strip::CASES;
    let [t, u] = slopes::CASES;
    [a, b, c, d, e, f, g, h, i, j, k, l, x, m, n, o, p, q, r, s, v, w, t, u]
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::setup::hold_and_find_their_faults;

    #[test]
    fn quick_ones_hold_and_their_mutants_fall_short() {
        hold_and_find_their_faults(CASES.iter().filter(|case| !case.name.starts_with("slope-")));
    }
}

//! How far the headline numbers of a run move with the mesh and with the assumptions, from the tables in its folder.
//!
//! The mesh: all runs of `ensemble.csv`. The assumptions: the variants of `sensitivity.csv` that change an
//! input and collapse; those that do not stand or do not collapse have no run-out to compare, and are counted.

use super::ensemble;
use super::sensitivity;
use super::variants::is_of_mesh;

/// Least and largest value of a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Least.
    pub low: f64,
    /// Largest.
    pub high: f64,
}

impl Range {
    /// That of some values; nothing of fewer than two.
    fn of(values: impl Iterator<Item = f64>) -> Option<Self> {
        let values: Vec<f64> = values.filter(|v| v.is_finite()).collect();
        let (low, high) =
            values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
        (values.len() > 1).then_some(Self { low, high })
    }

    /// `10.5 to 12.2`.
    pub fn said(&self, decimals: usize) -> String {
        format!("{:.decimals$} to {:.decimals$}", self.low, self.high)
    }
}

/// How far one number moves.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Spread {
    /// Over meshes.
    pub meshes: Option<Range>,
    /// Over assumptions.
    pub assumptions: Option<Range>,
}

/// How far the headline numbers move.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Ranges {
    /// When failure starts (E2), h.
    pub failure_h: Spread,
    /// How far the toe moves, m.
    pub runout_m: Spread,
    /// Settlement of the crest, m.
    pub crest_m: Spread,
    /// Largest and smallest cell, m.
    pub cells_m: Option<[f64; 2]>,
    /// Variants of an input, and how many of them collapse.
    pub variants: [usize; 2],
}

impl Ranges {
    /// Those of the tables about a scene; `first_toe_m` is the toe of the run at its start and its side (1 or -1).
    pub fn of(runs: &[ensemble::Line], variants: &[sensitivity::Line], [first_toe_m, side]: [f64; 2]) -> Self {
        let over_meshes = |of: fn(&ensemble::Line) -> Option<f64>| Range::of(runs.iter().filter_map(of));
        let inputs: Vec<&sensitivity::Line> = variants.iter().filter(|line| !is_of_mesh(&line.what)).collect();
        let collapsed: Vec<&sensitivity::Line> =
            inputs.iter().copied().filter(|line| line.rapid_failure_h.is_some()).collect();
        let over_inputs =
            |of: &dyn Fn(&sensitivity::Line) -> Option<f64>| Range::of(collapsed.iter().filter_map(|line| of(line)));
        let cells = runs.iter().map(|line| line.cell_m);
        let (small, large) =
            cells.fold((f64::INFINITY, 0.0_f64), |(small, large), cell| (small.min(cell), large.max(cell)));
        Self {
            failure_h: Spread {
                meshes: over_meshes(|line| line.failure_h),
                assumptions: over_inputs(&|line| line.failure_start_h),
            },
            runout_m: Spread {
                meshes: over_meshes(|line| line.runout_m),
                assumptions: over_inputs(&|line| Some(side * (line.toe_x_m? - first_toe_m))),
            },
            crest_m: Spread {
                meshes: over_meshes(|line| line.crest_m),
                assumptions: over_inputs(&|line| line.crest_settlement_m),
            },
            cells_m: (large > 0.0).then_some([large, small]),
            variants: [inputs.len(), collapsed.len()],
        }
    }

    /// A number with its ranges: `11.7 h (10.5 to 12.2 h over meshes of 0.4 to 0.1 m; 7.7 to 17.4 h over the assumptions)`.
    pub fn beside(&self, value: f64, spread: Spread, (unit, decimals): (&str, usize)) -> String {
        let mesh = match (spread.meshes, self.cells_m) {
            (Some(range), Some([large, small])) => {
                format!("{} {unit} over meshes of {large} to {small} m", range.said(decimals))
            }
            _ => "one mesh".to_owned(),
        };
        let inputs = spread
            .assumptions
            .map_or_else(String::new, |range| format!("; {} {unit} over the assumptions", range.said(decimals)));
        format!("{value:.decimals$} {unit} ({mesh}{inputs})")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_stands_beside_its_ranges() {
        let range = |low, high| Some(Range { low, high });
        let spread = Spread { meshes: range(10.451, 12.193), assumptions: range(7.7146, 17.443) };
        let ranges = Ranges { failure_h: spread, cells_m: Some([0.4, 0.1]), ..Ranges::default() };
        assert_eq!(
            ranges.beside(11.676, spread, ("h", 1)),
            "11.7 h (10.5 to 12.2 h over meshes of 0.4 to 0.1 m; 7.7 to 17.4 h over the assumptions)"
        );
        assert_eq!(Ranges::default().beside(2.04, Spread::default(), ("m", 1)), "2.0 m (one mesh)");
        assert_eq!(Range::of([3.0].into_iter()), None);
    }

    #[test]
    fn variants_of_the_mesh_and_those_that_do_not_collapse_are_no_range_of_the_assumptions() {
        let line = |what: &str, failure: f64, collapses: bool, toe: f64| sensitivity::Line {
            failure_start_h: Some(failure),
            rapid_failure_h: collapses.then_some(failure),
            toe_x_m: Some(toe),
            ..sensitivity::Line::named("", what, "")
        };
        let lines = [
            line("", 11.7, true, 10.7),
            line("conductivity", 7.7, true, 10.9),
            line("base friction, constant", 19.5, false, 8.8),
            line("edge of a cell", 10.5, true, 10.0),
        ];
        let ranges = Ranges::of(&[], &lines, [8.8, 1.0]);
        assert_eq!(ranges.failure_h.assumptions, Some(Range { low: 7.7, high: 11.7 }));
        let runout = ranges.runout_m.assumptions.expect("a range");
        assert!((runout.low - 1.9).abs() < 1e-9 && (runout.high - 2.1).abs() < 1e-9);
        assert_eq!((ranges.variants, ranges.cells_m), ([3, 2], None));
    }
}

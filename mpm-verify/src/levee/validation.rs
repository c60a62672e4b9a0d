//! Validation after ASME V&V 20-2009: the difference E between a simulation and what was reported, beside the uncertainty that
//! numerics, input and data leave it, `u_val = sqrt(u_num^2 + u_input^2 + u_D^2)`. Where |E| is larger, the model or an assumption is
//! wrong; where it is not, more cannot be said. Nothing is fitted to the data.
//!
//! All are standard uncertainties: of the mesh the difference of the medians on the two finest ones (first order: as much again is left),
//! with the scatter of the runs; of the input the scatter of the samples of [`super::probability`]; of the data half of the last
//! figure that was given.

use super::ensemble::{Line, cells, spread};
use super::probability;
use crate::report::content::table::{Cell, Table, table};
use crate::report::numbers::short;

/// Half of the range that four of five normal numbers lie in, in standard deviations.
const EIGHTY: f64 = 1.2816;
/// Shares of the samples that lie within one standard deviation.
const ONE: [f64; 2] = [0.1587, 0.8413];

/// What was reported.
struct Reported {
    what: &'static str,
    by: &'static str,
    unit: &'static str,
    value: f64,
    /// Standard uncertainty: half of the last figure.
    u_d: f64,
    of: fn(&Line) -> Option<f64>,
    /// Whether the scatter of the samples, which is that of the first event, counts.
    sampled: bool,
}

/// The paper: progressive failure at 8.66 h, final shape at 8.68 h, a difference of two times with two decimals, so 36 to 108 s. The
/// experiment: toe at 12 h 30 min, progressive failure from 13 h within 10 minutes, then the rapid one.
const REPORTED: [Reported; 5] = [
    Reported {
        what: "failure starts (E2)",
        by: "paper",
        unit: "h",
        value: 8.66,
        u_d: 0.005,
        of: |l| l.failure_h,
        sampled: true,
    },
    Reported {
        what: "from failure (E2) to rest",
        by: "paper",
        unit: "s",
        value: 72.0,
        u_d: 36.0,
        of: |l| l.fails_s,
        sampled: false,
    },
    Reported {
        what: "the toe fails (E1)",
        by: "experiment",
        unit: "h",
        value: 12.5,
        u_d: 0.25,
        of: |l| l.raveling_h,
        sampled: true,
    },
    Reported {
        what: "failure starts (E2)",
        by: "experiment",
        unit: "h",
        value: 13.0,
        u_d: 0.25,
        of: |l| l.failure_h,
        sampled: true,
    },
    Reported {
        what: "rapid failure (E3)",
        by: "experiment",
        unit: "h",
        value: 13.2,
        u_d: 0.1,
        of: |l| l.collapse_h,
        sampled: true,
    },
];

/// One comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Compared {
    /// Simulated less reported.
    error: f64,
    /// u_num, u_input, u_D.
    parts: [f64; 3],
}

impl Compared {
    fn u_val(&self) -> f64 {
        self.parts.iter().map(|u| u * u).sum::<f64>().sqrt()
    }
}

/// Compares a number of the runs on the finest mesh; nothing where the runs do not have it.
fn compare(reported: &Reported, runs: &[Line], samples: &[probability::Line]) -> Option<(f64, Compared)> {
    let cells = cells(runs);
    let [coarse, fine] = cells[cells.len().checked_sub(2)?..] else { return None };
    let [before, found] = [coarse, fine].map(|cell| spread(runs, cell, reported.of));
    let (before, found) = (before?, found?);
    let scatter = (found.range[1] - found.range[0]) / (2.0 * EIGHTY);
    let input = match reported.sampled {
        true => 0.5 * (probability::quantile(samples, ONE[1])? - probability::quantile(samples, ONE[0])?),
        false => 0.0,
    };
    let parts = [(found.median - before.median).hypot(scatter), input, reported.u_d];
    Some((found.median, Compared { error: found.median - reported.value, parts }))
}

/// A table for the page; none without samples or runs on two meshes.
pub fn shown(runs: &[Line], samples: &[probability::Line]) -> Option<Table> {
    let found = REPORTED.iter().filter_map(|reported| Some((reported, compare(reported, runs, samples)?)));
    let row = |(reported, (simulated, compared)): (&Reported, (f64, Compared))| {
        let number = |v: f64| Cell::new(short(v, 3));
        let within = compared.error.abs() <= compared.u_val();
        let (verdict, mark) = if within { ("within", "good") } else { ("beyond", "bad") };
        let [num, input, data] = compared.parts;
        let input = if reported.sampled { number(input) } else { Cell::new("–") };
        vec![
            Cell::new(reported.what).marked(reported.by, ""),
            Cell::new(reported.unit),
            number(simulated),
            number(reported.value),
            number(compared.error),
            number(num),
            input,
            number(data),
            number(compared.u_val()),
            Cell::badge(verdict, mark),
        ]
    };
    let rows: Vec<_> = found.map(row).collect();
    let head =
        ["", "unit", "simulated S", "reported D", "E = S − D", "u_num", "u_input", "u_D", "u_val", "|E| and u_val"];
    let note = "After ASME V&V 20-2009, with standard uncertainties: of the numerics from meshes and runs that should be equal, of the input from \
                the samples of the probability of failure, of the data half of the last figure given. Beyond: the model, or what it assumes of \
                the levee, is wrong. Nothing is fitted.";
    (!rows.is_empty()).then(|| table("Validation".to_owned(), &head, rows, note))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIRST: Reported =
        Reported { what: "", by: "", unit: "h", value: 10.0, u_d: 0.3, of: |l| l.failure_h, sampled: false };

    fn runs(medians: [f64; 2]) -> Vec<Line> {
        let text = "cell_m,member,cohesion_factor,cell_factor,raveling_h,failure_h,collapse_h,lasts_s,fails_s,runout_m,crest_m,cpu_s,why,scene\n";
        let line = |cell: f64, time: f64| format!("{cell},0,1,1,,{time},,,,,,0,,\n");
        let text = format!("{text}{}{}", line(0.4, medians[0]), line(0.2, medians[1]));
        csv::Reader::from_reader(text.as_bytes()).deserialize().collect::<Result<_, _>>().expect("lines")
    }

    #[test]
    fn an_error_is_within_or_beyond_what_is_not_known() {
        let (simulated, near) = compare(&FIRST, &runs([10.9, 10.5]), &[]).expect("a comparison");
        assert_eq!(simulated, 10.5);
        assert!((near.u_val() - 0.5).abs() < 1e-12 && near.error <= near.u_val(), "{near:?}");
        let (_, far) = compare(&FIRST, &runs([10.9, 10.8]), &[]).expect("a comparison");
        assert!(far.error > far.u_val(), "{far:?}");
        assert_eq!(compare(&FIRST, &runs([10.9, 10.8])[..1], &[]), None);
        // Without samples nothing is said of what they are needed for.
        assert!(shown(&runs([10.9, 10.8]), &[]).is_none());
    }
}

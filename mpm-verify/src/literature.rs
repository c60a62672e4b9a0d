//! Published laws of problems without an exact solution, with how each is known.
//!
//! Collapse of granular columns: a column of height H_0 and length L_0 (from the wall, or from the middle of a symmetric
//! one) is released onto a level base; with a = H_0/L_0 its run-out (L_inf - L_0)/L_0 and its final height H_inf/L_0 follow
//! power laws c a^p. Sources differ by a factor of two and more, so that a computation is compared with their band.

use serde::Deserialize;

/// The laws, in the program so that it runs from any folder.
const COLLAPSE: &str = include_str!("../../reference-data/literature/column_collapse.csv");

/// What surrounds the grains.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Air.
    Dry,
    /// A liquid that also stands above them.
    Immersed,
    /// A liquid in the pores, air above.
    Saturated,
}

/// What a law gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Quantity {
    /// (L_inf - L_0)/L_0.
    RunOut,
    /// H_inf/L_0.
    Height,
}

/// Where a law comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Measured.
    Experiment,
    /// Computed.
    Computation,
}

/// A law c a^p: a row of `column_collapse.csv`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Law {
    /// Authors and year, with the regime where there are several.
    pub source: String,
    /// Its DOI.
    pub doi: String,
    /// What surrounds the grains.
    pub kind: Kind,
    /// Lowest aspect ratio; none if there is no bound.
    pub a_low: Option<f64>,
    /// Highest aspect ratio; none if there is no bound.
    pub a_high: Option<f64>,
    /// c; none where only an exponent or a finding is known.
    pub coefficient: Option<f64>,
    /// p.
    pub exponent: Option<f64>,
    /// What it gives.
    pub quantity: Quantity,
    /// Half width of the coefficient's scatter as a share of it.
    pub scatter: Option<f64>,
    /// How the numbers are known.
    pub how_known: String,
    /// Where they come from.
    pub method: Method,
}

impl Law {
    /// Lowest and highest value at an aspect ratio; `None` outside of its range or without a coefficient.
    pub fn at(&self, a: f64) -> Option<(f64, f64)> {
        let inside = self.a_low.is_none_or(|low| a >= low) && self.a_high.is_none_or(|high| a <= high);
        let value = self.coefficient? * a.powf(self.exponent?);
        let scatter = self.scatter.unwrap_or(0.0) * value;
        inside.then_some((value - scatter, value + scatter))
    }
}

/// All laws of collapsing columns.
///
/// # Panics
/// Never: a test reads the table.
pub fn column_collapse() -> Vec<Law> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(COLLAPSE.as_bytes());
    reader.deserialize().collect::<Result<_, _>>().expect("the table holds")
}

/// Lowest and highest run-out (L_inf - L_0)/L_0 that experiments gave for the aspect ratio a = H_0/L_0; `None` if there is
/// no law for it.
pub fn run_out(kind: Kind, a: f64) -> Option<(f64, f64)> {
    band(&column_collapse(), |law| law.kind == kind && law.quantity == Quantity::RunOut, a)
}

/// Lowest and highest final height H_inf/L_0, as [`run_out`].
pub fn height(kind: Kind, a: f64) -> Option<(f64, f64)> {
    band(&column_collapse(), |law| law.kind == kind && law.quantity == Quantity::Height, a)
}

/// The band of the experiments among some laws.
fn band(laws: &[Law], wanted: impl Fn(&Law) -> bool, a: f64) -> Option<(f64, f64)> {
    let measured = laws.iter().filter(|law| law.method == Method::Experiment && wanted(law));
    measured.filter_map(|law| law.at(a)).reduce(|(low, high), (l, h)| (low.min(l), high.max(h)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_law_says_where_it_comes_from() {
        let laws = column_collapse();
        assert_eq!(laws.len(), 26);
        for law in laws {
            assert!(law.doi.starts_with("10.") && law.how_known.len() > 5, "{law:?}");
            assert!(law.exponent.is_some() || law.coefficient.is_none(), "{law:?}");
            assert!(law.at(3.0).is_none_or(|(low, high)| 0.0 < low && low <= high), "{law:?}");
        }
    }

    #[test]
    fn bands_hold_the_laws_that_they_are_made_of() {
        let close = |found: Option<(f64, f64)>, low: f64, high: f64| {
            let (l, h) = found.expect("a band");
            assert!((l - low).abs() < 1e-12 && (h - high).abs() < 1e-12, "{l} {h}");
        };
        close(run_out(Kind::Dry, 1.0), 1.2, 2.7 * 1.11);
        close(run_out(Kind::Dry, 8.0), 1.9 * 4.0, 3.7 * 8.0_f64.powf(0.64) * 1.08);
        close(run_out(Kind::Immersed, 1.0), 1.5 * 0.93, 2.7 * 1.11);
        close(height(Kind::Dry, 0.5), 0.5, 0.5);
        // Where the regimes of one source change over, both count.
        close(run_out(Kind::Dry, 2.0), 2.4, 3.7 * 2.0_f64.powf(0.64) * 1.08);
        assert_eq!(run_out(Kind::Saturated, 1.0), None);
    }

    #[test]
    fn computed_laws_are_no_part_of_the_band() {
        let (_, high) = run_out(Kind::Dry, 6.0).expect("a band");
        let computed = column_collapse().into_iter().find(|law| law.source == "Lagree et al. 2011").expect("a law");
        assert!(computed.method == Method::Computation && computed.at(6.0).expect("a value").1 > high);
    }
}

//! A number of the night.

use serde::{Deserialize, Serialize};

/// What a number is held against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Label {
    /// The truth: an error or an order against an exact solution or law.
    Verified,
    /// This code itself.
    Regression,
    /// A count of work, or a cost made of counts.
    Count,
    /// A time beside that of the calibration kernel: compared with earlier nights, never accepted.
    Time,
}

/// Which way is better.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Better {
    /// Less, as of an error or a cost.
    Lower,
    /// More, as of an order of convergence.
    Higher,
    /// Neither, as of the time of a failure.
    Neither,
}

impl Better {
    /// How a quantity is judged, by its name.
    pub fn of(quantity: &str) -> Self {
        let ends = |ending| quantity == ending || quantity.ends_with(&format!("_{ending}"));
        if ends("order") || ends("threshold") {
            Self::Higher
        } else if ["h", "m", "high", "low"].into_iter().any(ends) {
            Self::Neither
        } else {
            Self::Lower
        }
    }

    /// Direction of a change from one value to another.
    pub fn direction(self, was: f64, is: f64) -> Direction {
        match (self, is > was) {
            _ if is.is_nan() || was.is_nan() => Direction::Gone,
            (Self::Neither, true) => Direction::Up,
            (Self::Neither, false) => Direction::Down,
            (Self::Lower, true) | (Self::Higher, false) => Direction::Worse,
            (Self::Lower, false) | (Self::Higher, true) => Direction::Better,
        }
    }
}

/// Direction in which a number moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// A larger error or cost, or a smaller order.
    Worse,
    /// A smaller error or cost, or a larger order.
    Better,
    /// Larger, where neither is better.
    Up,
    /// Smaller, where neither is better.
    Down,
    /// Accepted, but not measured.
    Gone,
    /// Measured, but never accepted.
    New,
}

impl Direction {
    /// The direction in a word.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Worse => "worse",
            Self::Better => "better",
            Self::Up => "up",
            Self::Down => "down",
            Self::Gone => "gone",
            Self::New => "new",
        }
    }

    /// Class of its cell in a table.
    pub const fn mark(self) -> &'static str {
        match self {
            Self::Worse | Self::Gone => "bad",
            Self::Better => "good",
            Self::Up | Self::Down | Self::New => "",
        }
    }
}

/// How far a number may move.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Tolerance {
    /// As a share of what was accepted.
    pub relative: f64,
    /// In its own unit: what is round-off, whatever its share.
    pub absolute: f64,
}

impl Tolerance {
    /// A share.
    pub const fn relative(relative: f64) -> Self {
        Self { relative, absolute: 0.0 }
    }

    /// Whether a number is where it was. Two that are no numbers are the same.
    pub fn holds(self, was: f64, is: f64) -> bool {
        if was.is_nan() || is.is_nan() {
            return was.is_nan() && is.is_nan();
        }
        let moved = (is - was).abs();
        is == was || moved <= self.relative * was.abs() || moved <= self.absolute
    }
}

/// A number of the night.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Number {
    /// Subject of the number: a case, a scheme in a stress test, a gate of the work.
    pub case: String,
    /// Which number of it.
    pub quantity: String,
    /// What it is held against.
    pub label: Label,
    /// The number; NaN for one that could not be had.
    #[serde(deserialize_with = "crate::study::or_nan")]
    pub value: f64,
    /// How far it may move.
    #[serde(flatten)]
    pub tolerance: Tolerance,
    /// Page of its case in the folder of a nightly run, with an anchor where the page has one; empty for none.
    #[serde(skip)]
    pub page: String,
}

impl Number {
    /// A number.
    pub fn new(case: &str, quantity: &str, label: Label, value: f64, tolerance: Tolerance) -> Self {
        Self { case: case.to_owned(), quantity: quantity.to_owned(), label, value, tolerance, page: String::new() }
    }

    /// The number with the page of its case.
    pub fn at(self, page: impl Into<String>) -> Self {
        Self { page: page.into(), ..self }
    }

    /// Whether it is of the same thing as another.
    pub fn is_of(&self, case: &str, quantity: &str) -> bool {
        self.case == case && self.quantity == quantity
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tolerance_holds_up_to_itself_and_no_further() {
        let share = Tolerance::relative(0.02);
        assert!(share.holds(1.0, 1.0199) && !share.holds(1.0, 1.021) && share.holds(-1.0, -0.981));
        assert!(!share.holds(0.0, 1e-30) && share.holds(0.0, 0.0));
        let both = Tolerance { relative: 1e-6, absolute: 1e-9 };
        assert!(both.holds(1e-12, 9e-10) && !both.holds(1e-12, 2e-9));
        assert!(!share.holds(1.0, f64::NAN) && !share.holds(f64::NAN, 1.0) && share.holds(f64::NAN, f64::NAN));
        assert!(share.holds(f64::INFINITY, f64::INFINITY) && !share.holds(1.0, f64::INFINITY));
    }

    #[test]
    fn directions_are_those_of_the_quantity() {
        let of = |quantity: &str, was: f64, is: f64| Better::of(quantity).direction(was, is).word();
        assert_eq!(of("max_error_terzaghi", 1.0, 2.0), "worse");
        assert_eq!((of("error", 2.0, 1.0), of("order", 2.0, 1.0)), ("better", "worse"));
        assert_eq!((of("failure_h", 1.0, 2.0), of("crest_m", 2.0, 1.0)), ("up", "down"));
        assert_eq!((of("auto_high", 1.0, 2.0), of("solves", 1.0, 2.0)), ("up", "worse"));
        assert_eq!(of("error", 1.0, f64::NAN), "gone");
    }
}

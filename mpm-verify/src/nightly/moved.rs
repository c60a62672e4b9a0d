//! What is not where it was.

use serde::{Deserialize, Serialize};

use super::compiled::counted;
use super::history::History;
use super::thresholds::compared;
use crate::experiment::accepted::Accepted;
use crate::experiment::number::{Better, Direction, Label, Number, Tolerance};

/// A number that has moved further than it may, or is gone, or is new.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Moved {
    /// Of what.
    pub case: String,
    /// Which number.
    pub quantity: String,
    /// What was accepted; nothing for a number without a baseline.
    pub was: Option<f64>,
    /// What it is; nothing for one that is gone.
    pub is: Option<f64>,
    /// How far it may move, in its own unit.
    pub tolerance: f64,
    /// The entry of the history at which it has been off for the first time: date and commit.
    pub since: String,
    /// What it is held against.
    pub label: Label,
    /// Direction in which the number moved.
    pub direction: Direction,
    /// Page of its case, relative to the page of the night; empty for none.
    #[serde(default)]
    pub page: String,
}

impl Moved {
    /// Change as a share of what was accepted.
    pub fn share(&self) -> Option<f64> {
        self.was.zip(self.is).filter(|(was, _)| *was != 0.0).map(|(was, is)| (is - was) / was.abs())
    }

    /// In one line.
    pub fn line(&self) -> String {
        let number = |value: Option<f64>| value.map_or_else(|| "nothing".to_owned(), |v| format!("{v:.6e}"));
        let share = self.share().map_or_else(String::new, |share| format!(", {:+.3} %", 100.0 * share));
        format!(
            "{} {} {}: was {}, is {}{share} (may move by {:.1e}), since {}",
            self.case,
            self.quantity,
            self.direction.word(),
            number(self.was),
            number(self.is),
            self.tolerance,
            self.since
        )
    }
}

/// Numbers of a night that are not where they were, the largest change first. `now` is the entry of this night.
pub fn moved(accepted: &[Accepted], measures: &[Number], history: &History, now: &str) -> Vec<Moved> {
    let number = |value: f64| Some(value).filter(|v| !v.is_nan());
    let off = measures.iter().filter_map(|m| {
        let row = accepted.iter().find(|row| m.is_of(&row.case, &row.quantity));
        let Some(row) = row else {
            // Neither accepted nor long enough in the history: there is nothing to hold it to.
            if m.label == Label::Time || counted(&m.quantity).is_some() {
                return None;
            }
            return Some(Moved {
                case: m.case.clone(),
                quantity: m.quantity.clone(),
                was: None,
                is: number(m.value),
                tolerance: 0.0,
                since: now.to_owned(),
                label: m.label,
                direction: Direction::New,
                page: m.page.clone(),
            });
        };
        let value = compared(m, history);
        let faster = m.label == Label::Time && value < row.value;
        let holds = faster || row.tolerance().holds(row.value, value);
        (!holds).then(|| Moved { page: m.page.clone(), ..of(row, value, history, now) })
    });
    let gone = accepted.iter().filter(|row| !measures.iter().any(|m| m.is_of(&row.case, &row.quantity)));
    let mut all: Vec<Moved> = off.chain(gone.map(|row| of(row, f64::NAN, history, now))).collect();
    let size = |moved: &Moved| moved.share().map_or(f64::INFINITY, f64::abs);
    all.sort_by(|a, b| size(b).total_cmp(&size(a)));
    all
}

fn of(row: &Accepted, is: f64, history: &History, now: &str) -> Moved {
    let Tolerance { relative, absolute } = row.tolerance();
    let since = history.off_since(&row.case, &row.quantity, &|value| row.tolerance().holds(row.value, value));
    Moved {
        case: row.case.clone(),
        quantity: row.quantity.clone(),
        was: Some(row.value),
        is: Some(is).filter(|v| !v.is_nan()),
        tolerance: (relative * row.value.abs()).max(absolute),
        since: since.unwrap_or_else(|| now.to_owned()),
        label: row.label,
        direction: Better::of(&row.quantity).direction(row.value, is),
        page: String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measure(case: &str, value: f64) -> Number {
        Number::new(case, "error", Label::Verified, value, Tolerance::relative(0.01))
    }

    fn row(case: &str, value: f64) -> Accepted {
        Accepted {
            case: case.to_owned(),
            quantity: "error".to_owned(),
            label: Label::Verified,
            value,
            relative: 0.01,
            absolute: 0.0,
            since: "d c".to_owned(),
            why: "a test".to_owned(),
        }
    }

    #[test]
    fn what_stays_is_not_told_and_all_else_is() {
        let accepted = [row("stays", 1.0), row("worse", 1.0), row("better", 1.0), row("gone", 1.0), row("broken", 1.0)];
        let mut time = measure("slow", 99.0);
        time.label = Label::Time;
        let night = [
            measure("stays", 1.009),
            measure("worse", 1.1),
            measure("better", 0.9),
            measure("new", 5.0),
            measure("broken", f64::NAN),
            time,
            Number::new("not accepted", "allocations (another compiler)", Label::Count, 9.0, Tolerance::relative(0.0)),
        ];
        let mut history = History::default();
        for (entry, value) in [("d1 c1", 1.0), ("d2 c2", 1.2), ("d3 c3", 1.15)] {
            history.note(entry, &[measure("worse", value)]);
        }
        let told = moved(&accepted, &night, &history, "d4 c4");
        let short: Vec<(&str, &str, &str)> =
            told.iter().map(|m| (m.case.as_str(), m.direction.word(), m.since.as_str())).collect();
        let expected = [
            ("new", "new", "d4 c4"),
            ("broken", "gone", "d4 c4"),
            ("gone", "gone", "d4 c4"),
            ("worse", "worse", "d2 c2"),
            ("better", "better", "d4 c4"),
        ];
        assert_eq!(short, expected);
        let line = told[3].line();
        assert!(line.contains("worse error worse: was 1.0") && line.contains("+10.000 %"), "{line}");
    }
}

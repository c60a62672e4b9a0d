//! The errors of cases beside the accepted ones.

use super::{Climb, LADDER};
use crate::baseline::ladder::{Accepted, GROWTH, Kind, LABEL, baselines, floor};

/// Holds a case's error against the accepted one: notes both, and lets the case fail if its error has grown or fallen.
pub(super) fn compare(climb: &mut Climb) {
    compare_with(&baselines(), climb);
}

fn compare_with(accepted: &[Accepted], climb: &mut Climb) {
    let Some(row) = accepted.iter().find(|row| row.rung == climb.step.rung) else { return };
    let error = climb.step.error;
    climb.step.baseline = Some(row.error);
    climb.step.change = Some(if error == row.error { 1.0 } else { error / row.error }).filter(|c| c.is_finite());
    let most = 100.0 * (GROWTH - 1.0);
    if error > GROWTH * row.error && error - row.error > row.floor {
        climb.fall(&format!("it was {:.3e} (baseline) and may grow by {most:.0} %", row.error));
    }
    if GROWTH * error < row.error && row.error - error > row.floor {
        let was = row.error;
        climb.fall(&format!(
            "it was {was:.3e} (baseline) and may fall by {most:.0} %; accept what it is now if you know why"
        ));
    }
}

/// The baselines as they would be with these cases, all others as they are: to be put in place of the old ones once a
/// change is accepted. Cases that fell short of more than their baseline keep their old row.
pub fn accepted(climbs: &[Climb]) -> String {
    let known = baselines();
    let mut text = LABEL.to_owned();
    for rung in LADDER {
        let old = known.iter().find(|row| row.rung == rung.name);
        let new = climbs.iter().find(|climb| climb.step.rung == rung.name && climb.sound).map(|climb| row(climb, old));
        if let Some(row) = new.as_ref().or(old) {
            let kind = if row.kind == Kind::Verified { "verified" } else { "regression" };
            let order = row.order.map_or(String::new(), |order| format!("{order:.3}"));
            text.push_str(&format!("{},{kind},{:?},{order},{:?}\n", row.rung, row.error, row.floor));
        }
    }
    text
}

/// The row of a case. A floor that someone has widened by hand stays.
fn row(climb: &Climb, old: Option<&Accepted>) -> Accepted {
    let step = &climb.step;
    let floor = floor(step.error, step.required_error, step.tolerance).max(old.map_or(0.0, |row| row.floor));
    Accepted { rung: step.rung.clone(), kind: step.baseline_kind, error: step.error, order: step.order, floor }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baseline::ladder::ACCEPTED;

    #[test]
    fn every_baseline_is_that_of_a_case() {
        for row in baselines() {
            assert!(LADDER.iter().any(|rung| rung.name == row.rung), "{} is no case", row.rung);
            assert!(row.error >= 0.0 && row.floor > 0.0, "{row:?}");
        }
    }

    #[test]
    fn an_error_that_has_moved_lets_its_case_fail() {
        let rung = LADDER.iter().find(|rung| rung.name == "hydrostatic").expect("a case");
        let climb = rung.climb().expect("runs that finish");
        assert!(climb.step.held(), "{}", climb.reason);
        let error = climb.step.error;
        let with = |accepted: f64, floor: f64| {
            let mut climb = climb.clone();
            let row =
                Accepted { rung: rung.name.to_owned(), kind: Kind::Verified, error: accepted, order: None, floor };
            compare_with(&[row], &mut climb);
            climb
        };
        assert!(with(error, 0.0).step.held() && with(1.01 * error, 0.0).step.held());
        assert!(with(error / 1.01, 0.0).step.held() && with(error / 2.0, error).step.held());
        assert!(with(1.5 * error, error).step.held());
        let fallen = with(1.03 * error, 0.0);
        assert!(!fallen.step.held() && fallen.reason.contains("(baseline) and may fall by 2 %"), "{}", fallen.reason);
        let grown = with(error / 1.03, 0.0);
        assert!(!grown.step.held() && grown.reason.contains("(baseline) and may grow by 2 %"), "{}", grown.reason);
        assert_eq!(grown.reason, grown.step.reason);
        assert!(grown.step.change.is_some_and(|change| (change - 1.03).abs() < 1e-9));
    }

    #[test]
    fn what_is_accepted_keeps_the_rows_of_cases_that_were_not_run() {
        let text = accepted(&[]);
        assert_eq!(text, ACCEPTED, "put in place what `mpm-verify check` writes as accepted.csv");
    }
}

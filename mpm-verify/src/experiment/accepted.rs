//! The errors of cases beside the accepted ones.

use super::verdict::Judged;
use crate::baseline::suite::{Accepted, GROWTH, Kind, LABEL, baselines, floor};
use crate::cases::suite;

/// Holds a case's error against the accepted one: notes both, and lets the case fail if its error has grown or fallen.
pub(crate) fn compare(judged: &mut Judged) {
    compare_with(&baselines(), judged);
}

fn compare_with(accepted: &[Accepted], judged: &mut Judged) {
    let Some(row) = accepted.iter().find(|row| row.case == judged.row.case) else { return };
    let error = judged.row.error;
    judged.row.baseline = Some(row.error);
    judged.row.change = Some(if error == row.error { 1.0 } else { error / row.error }).filter(|c| c.is_finite());
    let most = 100.0 * (GROWTH - 1.0);
    if error > GROWTH * row.error && error - row.error > row.floor {
        judged.fail(&format!("it was {:.3e} (baseline) and may grow by {most:.0} %", row.error));
    }
    if GROWTH * error < row.error && row.error - error > row.floor {
        let was = row.error;
        judged.fail(&format!(
            "it was {was:.3e} (baseline) and may fall by {most:.0} %; accept what it is now if you know why"
        ));
    }
}

/// The baselines as they would be with these cases, all others as they are: to be put in place of the old ones once a
/// change is accepted. Cases that fail for more than their accepted error keep their old row.
pub fn accepted(judged: &[Judged]) -> String {
    let known = baselines();
    let mut text = LABEL.to_owned();
    for case in suite() {
        let old = known.iter().find(|row| row.case == case.name);
        let new =
            judged.iter().find(|judged| judged.row.case == case.name && judged.sound).map(|judged| row(judged, old));
        if let Some(row) = new.as_ref().or(old) {
            let kind = if row.kind == Kind::Verified { "verified" } else { "regression" };
            let order = row.order.map_or(String::new(), |order| format!("{order:.3}"));
            text.push_str(&format!("{},{kind},{:?},{order},{:?}\n", row.case, row.error, row.floor));
        }
    }
    text
}

/// The row of a case. A floor that someone has widened by hand stays.
fn row(judged: &Judged, old: Option<&Accepted>) -> Accepted {
    let step = &judged.row;
    let floor = floor(step.error, step.required_error, step.tolerance).max(old.map_or(0.0, |row| row.floor));
    Accepted { case: step.case.clone(), kind: step.baseline_kind, error: step.error, order: step.order, floor }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baseline::suite::ACCEPTED;

    #[test]
    fn every_baseline_is_that_of_a_case() {
        for row in baselines() {
            assert!(suite().iter().any(|case| case.name == row.case), "{} is no case", row.case);
            assert!(row.error >= 0.0 && row.floor > 0.0, "{row:?}");
        }
    }

    #[test]
    fn an_error_that_has_moved_lets_its_case_fail() {
        let case = suite().iter().find(|case| case.name == "hydrostatic").expect("a case");
        let judged = case.judged().expect("runs that finish");
        assert!(judged.row.passed(), "{}", judged.reason);
        let error = judged.row.error;
        let with = |accepted: f64, floor: f64| {
            let mut judged = judged.clone();
            let row =
                Accepted { case: case.name.to_owned(), kind: Kind::Verified, error: accepted, order: None, floor };
            compare_with(&[row], &mut judged);
            judged
        };
        assert!(with(error, 0.0).row.passed() && with(1.01 * error, 0.0).row.passed());
        assert!(with(error / 1.01, 0.0).row.passed() && with(error / 2.0, error).row.passed());
        assert!(with(1.5 * error, error).row.passed());
        let fallen = with(1.03 * error, 0.0);
        assert!(!fallen.row.passed() && fallen.reason.contains("(baseline) and may fall by 2 %"), "{}", fallen.reason);
        let grown = with(error / 1.03, 0.0);
        assert!(!grown.row.passed() && grown.reason.contains("(baseline) and may grow by 2 %"), "{}", grown.reason);
        assert_eq!(grown.reason, grown.row.reason);
        assert!(grown.row.change.is_some_and(|change| (change - 1.03).abs() < 1e-9));
    }

    #[test]
    fn what_is_accepted_keeps_the_rows_of_cases_that_were_not_run() {
        let text = accepted(&[]);
        assert_eq!(text, ACCEPTED, "put in place what `mpm-verify check` writes as accepted.csv");
    }
}

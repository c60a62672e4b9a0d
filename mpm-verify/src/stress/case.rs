//! What a stress test is: a parameter that makes it harder and harder, a number that says how well a scheme does, and two
//! bounds that make a verdict of it.

use mpm_core::scene::Dimension;
use serde::{Deserialize, Serialize};

use super::scheme::Scheme;
use crate::error::Error;

/// A stress test.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// Its name on the command line.
    pub name: &'static str,
    /// What is done, and what it is compared with.
    pub about: &'static str,
    /// What decides how a scheme bears it, and what helps.
    pub why: &'static str,
    /// What makes it harder, with its unit.
    pub parameter: &'static str,
    /// The same as a column: `k_m_s`.
    pub column: &'static str,
    /// In one dimension or two.
    pub dimension: Dimension,
    /// What is measured; the smaller the better.
    pub measures: &'static str,
    /// Largest value with which a scheme holds.
    pub holds: f64,
    /// Largest value with which it only degrades.
    pub breaks: f64,
    /// Schemes that can be asked.
    pub schemes: &'static [Scheme],
    /// Runs a scheme, from the easiest parameter to the hardest.
    pub run: fn(&Scheme) -> Vec<Point>,
}

/// What became of a scheme at one parameter.
#[derive(Debug)]
pub struct Point {
    /// The parameter.
    pub at: f64,
    /// What was measured, or why nothing could be.
    pub found: Result<f64, Error>,
}

/// How a scheme bears a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Within the bound at every parameter.
    Passed,
    /// Beyond it, but of use: degrades to the value given.
    Degraded,
    /// The program stops, or does not start, at the parameter given and says why, or a run would need more steps than any
    /// has time for; until there it is of use.
    Stopped,
    /// Of no use from the parameter given on, a value beyond the second bound, and nothing says so.
    Failed,
}

/// A verdict with where it was made.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// The verdict.
    pub verdict: Verdict,
    /// The largest value; where it breaks, the value there. `None` if nothing could be measured there.
    pub value: Option<f64>,
    /// The parameter there.
    pub at: f64,
    /// Why the run stopped, if it did.
    pub reason: String,
}

impl Point {
    /// The points of a run that passes all `parameters` one after the other: those that it noted, and where it stopped.
    pub fn along(parameters: &[f64], run: impl FnOnce(&mut Vec<Self>) -> Result<(), Error>) -> Vec<Self> {
        let mut points = Vec::new();
        if let Err(reason) = run(&mut points) {
            let at = parameters.get(points.len()).or(parameters.last()).copied().unwrap_or(f64::NAN);
            points.push(Self { at, found: Err(reason) });
        }
        points
    }
}

impl Case {
    /// The verdict on a scheme's points.
    pub fn judge(&self, points: &[Point]) -> Judged {
        let useless = |p: &&Point| p.found.as_ref().map_or(true, |value| value.is_nan() || *value > self.breaks);
        if let Some(point) = points.iter().find(useless) {
            let value = point.found.as_ref().ok().copied().filter(|v| v.is_finite());
            let (verdict, reason) = match &point.found {
                Ok(_) => (Verdict::Failed, String::new()),
                Err(reason) => (Verdict::Stopped, reason.to_string()),
            };
            return Judged { verdict, value, at: point.at, reason };
        }
        let values = points.iter().filter_map(|p| Some((p.at, *p.found.as_ref().ok()?)));
        let worst = values.fold(None, |worst: Option<(f64, f64)>, (at, value)| match worst {
            Some((_, largest)) if largest >= value => worst,
            _ => Some((at, value)),
        });
        let Some((at, value)) = worst else {
            let reason = "nothing was measured".to_owned();
            return Judged { verdict: Verdict::Failed, value: None, at: f64::NAN, reason };
        };
        let verdict = if value <= self.holds { Verdict::Passed } else { Verdict::Degraded };
        Judged { verdict, value: Some(value), at, reason: String::new() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CASE: Case = Case {
        name: "",
        about: "",
        why: "",
        parameter: "",
        column: "",
        dimension: Dimension::Column,
        measures: "",
        holds: 0.01,
        breaks: 0.2,
        schemes: &[],
        run: |_| Vec::new(),
    };

    fn points<const N: usize>(values: [Result<f64, Error>; N]) -> Vec<Point> {
        (0..).zip(values).map(|(i, found)| Point { at: f64::from(i), found }).collect()
    }

    #[test]
    fn verdicts_follow_the_worst_point() {
        fn judged<const N: usize>(values: [Result<f64, Error>; N]) -> (Verdict, Option<f64>, f64) {
            let Judged { verdict, value, at, .. } = CASE.judge(&points(values));
            (verdict, value, at)
        }
        assert_eq!(judged([Ok(1e-3), Ok(9e-3), Ok(2e-3)]), (Verdict::Passed, Some(9e-3), 1.0));
        assert_eq!(judged([Ok(1e-3), Ok(0.1), Ok(2e-3)]), (Verdict::Degraded, Some(0.1), 1.0));
        assert_eq!(judged([Ok(0.1), Ok(0.3), Ok(0.5)]), (Verdict::Failed, Some(0.3), 1.0));
        assert_eq!(judged([Ok(0.0), Err(Error::Unfit("stopped")), Ok(0.3)]), (Verdict::Stopped, None, 1.0));
        assert_eq!(judged([Ok(0.3), Err(Error::Unfit("stopped"))]), (Verdict::Failed, Some(0.3), 0.0));
        assert_eq!(judged([Ok(f64::NAN)]), (Verdict::Failed, None, 0.0));
        assert_eq!(judged([]).0, Verdict::Failed);
        assert_eq!(CASE.judge(&points([Err(Error::Unfit("stopped"))])).reason, "stopped");
    }
}

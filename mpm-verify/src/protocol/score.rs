//! The score of a code on a case: errors in the norms of the suite, orders, a verdict, and the mistake that a wrong result resembles.

use serde::{Deserialize, Serialize};

use super::case::Case;
use super::mistakes;
use super::results::{Answer, Cost, Said};
use crate::rates::{Fit, fit};

/// What is said of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Within what a scheme of second order reaches, and converging.
    Passes,
    /// Within what a scheme of first order reaches, and converging as one.
    FirstOrder,
    /// Neither.
    Wrong,
    /// No answer that could be compared.
    NotRun,
}

impl Verdict {
    /// In words.
    pub fn word(self) -> &'static str {
        match self {
            Self::Passes => "passes",
            Self::FirstOrder => "passes at first order",
            Self::Wrong => "wrong",
            Self::NotRun => "not run",
        }
    }
}

/// Order from which on a scheme counts as one of second order, of first order.
const ORDERS: [f64; 2] = [1.5, 0.6];
/// An error so much below what is expected needs no order: what is left may be that of time.
const SMALL: f64 = 0.1;
/// An answer that is off by less than this on every refinement is the exact solution to round-off.
const ROUND_OFF: f64 = 1e-11;

/// An error on a refinement.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Level {
    /// Which.
    pub refinement: f64,
    /// Error in the norm of the case, with its sign.
    pub error: Option<f64>,
    /// CPU time, s.
    pub cpu_s: Option<f64>,
    /// Time on the clock, s.
    pub wall_s: Option<f64>,
    /// Peak memory, MiB.
    pub peak_mib: Option<f64>,
}

/// The score of a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Name of the case.
    pub case: String,
    /// What the parameters were drawn from.
    pub seed: u64,
    /// The verdict.
    pub verdict: Verdict,
    /// Why.
    pub reason: String,
    /// Errors, coarse to fine.
    pub levels: Vec<Level>,
    /// The order of the errors; none for errors without one.
    pub order: Option<f64>,
    /// Half the width of its 95 % interval; none for two refinements.
    pub order_half_width: Option<f64>,
    /// Largest errors of schemes of first and second order on the finest mesh.
    pub expected: [f64; 2],
    /// Difference of what flows in and out over what flows in, where both are asked for.
    pub conservation: Option<f64>,
    /// Names of mistakes that it resembles.
    pub mistakes: Vec<String>,
    /// What is suspicious.
    pub flags: Vec<String>,
    /// What was wrong with the table.
    pub faults: Vec<String>,
}

impl Score {
    /// Error on the finest refinement.
    pub fn finest(&self) -> Option<f64> {
        self.levels.iter().rev().find_map(|level| level.error)
    }

    /// A case without an answer.
    pub fn not_run(case: &Case, reason: impl Into<String>) -> Self {
        Self {
            case: case.name.clone(),
            seed: case.seed,
            verdict: Verdict::NotRun,
            reason: reason.into(),
            levels: Vec::new(),
            order: None,
            order_half_width: None,
            expected: case.expected,
            conservation: None,
            mistakes: Vec::new(),
            flags: Vec::new(),
            faults: Vec::new(),
        }
    }
}

/// Scores an answer; what was measured of its cost counts before what it says.
pub fn score(case: &Case, answer: &Answer, said: &Said, measured: &[Cost]) -> Score {
    let mut score = Score { faults: answer.faults.clone(), ..Score::not_run(case, "") };
    let cost = |costs: &[Cost], refinement: f64| costs.iter().copied().find(|cost| cost.refinement == refinement);
    for refinement in &case.refinements {
        let rows = answer.levels.iter().find(|(own, _)| own == refinement).map(|(_, rows)| rows);
        let compared = rows.map(|rows| case.compared(*refinement, rows));
        let error = match compared {
            Some(Ok(found)) => Some(found.error()).filter(|error| error.is_finite()),
            Some(Err(why)) => {
                score.faults.push(format!("refinement {refinement}: {why}"));
                None
            }
            None => None,
        };
        let cost = cost(measured, *refinement).or_else(|| cost(&said.runs, *refinement)).unwrap_or_default();
        let level =
            Level { refinement: *refinement, error, cpu_s: cost.cpu_s, wall_s: cost.wall_s, peak_mib: cost.peak_mib };
        score.levels.push(level);
    }
    score.conservation = conservation(case, answer);
    let known: Vec<(f64, f64)> =
        score.levels.iter().filter_map(|level| Some((1.0 / level.refinement, level.error?))).collect();
    if known.len() < 2 {
        let why = score.faults.first().map_or_else(String::new, |fault| format!(": {fault}"));
        score.reason =
            format!("{} of {} refinements complete, two at least are needed{why}", known.len(), case.refinements.len());
        if known.is_empty() {
            score.levels.clear();
        }
        return score;
    }
    let fitted = fit(&known);
    (score.order, score.order_half_width) =
        (fitted.as_ref().map(|f| f.order), fitted.as_ref().map(|f| f.half_width).filter(|half| half.is_finite()));
    (score.verdict, score.reason) = verdict(case, &known, fitted.as_ref());
    let compared = answer.levels.iter().filter(|(own, _)| known.iter().any(|(h, _)| *h == 1.0 / own));
    let compared = Answer { levels: compared.cloned().collect(), faults: Vec::new() };
    let seen = mistakes::seen(case, &compared, score.verdict == Verdict::Passes);
    if !seen.is_empty() {
        let words: Vec<&str> = seen.iter().map(|mistake| mistake.words).collect();
        score.reason = format!("{}; resembles {}", score.reason, words.join(", or "));
        score.mistakes = seen.iter().map(|mistake| mistake.name.to_owned()).collect();
        if score.verdict == Verdict::Passes {
            score.verdict = Verdict::FirstOrder;
            score.reason = format!("{}: on finer meshes it would not converge to the exact solution", score.reason);
        }
    }
    if known.len() < case.refinements.len() {
        score.flags.push(format!("{} of {} refinements", known.len(), case.refinements.len()));
    }
    if !case.exact_by_nature && known.iter().all(|(_, error)| error.abs() < ROUND_OFF) {
        score.flags.push("the exact solution to round-off on every refinement: computed, or copied?".to_owned());
    }
    score
}

fn verdict(case: &Case, errors: &[(f64, f64)], fit: Option<&Fit>) -> (Verdict, String) {
    let finest = errors.last().map_or(f64::NAN, |(_, error)| error.abs());
    let largest = crate::norms::largest(errors.iter().map(|(_, error)| *error));
    let order = fit.map_or(f64::NEG_INFINITY, |fit| fit.order);
    let said = match fit {
        Some(fit) => format!("finest error {finest:.1e}, order {}", crate::experiment::refinement::order_words(fit)),
        None => format!("finest error {finest:.1e}, no order"),
    };
    let [first, second] = case.expected;
    for (verdict, most, least) in [(Verdict::Passes, second, ORDERS[0]), (Verdict::FirstOrder, first, ORDERS[1])] {
        if finest <= most && (order >= least || largest <= SMALL * most) {
            return (verdict, said);
        }
    }
    let why = if finest > first {
        format!("above {first:.0e}, which first order reaches")
    } else {
        "it does not converge to the exact solution".to_owned()
    };
    (Verdict::Wrong, format!("{said}: {why}"))
}

/// What enters less what leaves over what enters, at the last time on the finest refinement.
fn conservation(case: &Case, answer: &Answer) -> Option<f64> {
    let of = |name: &str| case.wanted.iter().position(|wanted| wanted.quantity == name);
    let (inflow, outflow) = (of("inflow")?, of("outflow")?);
    let (_, rows) = answer.levels.last()?;
    let last = |quantity: usize| rows.iter().rfind(|row| row.quantity == quantity).map(|row| row.value);
    let [inflow, outflow] = [last(inflow)?, last(outflow)?];
    Some((inflow - outflow) / inflow)
}

//! The score of a code on a case: errors in the norms of the suite, orders, a verdict, and the mistake that a wrong result resembles.

use serde::{Deserialize, Serialize};

use super::case::Case;
use super::mistakes;
use super::results::{Answer, Cost, Said};
use crate::rates::{Convergence, Order, Theory, round_off};

/// What is said of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The error is within what a scheme of second order reaches, and no lower order is established.
    Passes,
    /// Within what a scheme of first order reaches.
    FirstOrder,
    /// Above that, an order that no scheme has, or closer to the solution of a mistake.
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
    /// CPU time of the solution alone, as the code says in `run.json`, s: without the start of the program.
    #[serde(default)]
    pub solve_s: Option<f64>,
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
    /// Whether no order is expected of the errors.
    #[serde(default)]
    pub without_order: bool,
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

    /// Refinements with an error: 1 over the refinement, the signed error.
    fn known(&self) -> Vec<(f64, f64)> {
        self.levels.iter().filter_map(|level| Some((1.0 / level.refinement, level.error?))).collect()
    }

    /// The order of the errors. Which order a scheme should have the code knows: any whole one may be it.
    pub fn convergence(&self) -> Convergence {
        let finest = self.levels.iter().map(|level| level.refinement).fold(1.0, f64::max);
        let theory = if self.without_order { Theory::None } else { Theory::Whole };
        Convergence::new(&self.known(), theory, round_off(finest * finest))
    }

    /// Judges the errors and the mistakes that they resemble, those of a score that was stored as well.
    pub fn judge(&mut self, case: &Case) {
        (self.without_order, self.expected) = (case.exact_by_nature, case.expected);
        if self.known().len() < 2 {
            return;
        }
        let found = self.convergence();
        let fit = found.fit.as_ref().filter(|_| found.order != Order::NotExpected);
        self.order = fit.map(|fit| fit.order);
        self.order_half_width = fit.map(|fit| fit.half_width).filter(|half| half.is_finite());
        let ([first, second], finest) = (self.expected, self.finest().map_or(f64::NAN, f64::abs));
        self.reason = format!("finest error {finest:.1e}, order {}", found.words());
        let theory = fit.filter(|_| found.order == Order::Passed).and_then(|fit| found.theory.nearest(fit.order));
        self.verdict = match (found.order, theory) {
            (Order::Failed, _) => {
                self.reason += ": it does not converge to the exact solution";
                Verdict::Wrong
            }
            _ if finest <= second && theory.is_none_or(|order| order >= 2.0) => Verdict::Passes,
            _ if finest <= first => Verdict::FirstOrder,
            _ => {
                self.reason += &format!(": above {first:.0e}, which first order reaches");
                Verdict::Wrong
            }
        };
        let words = |mistake: &&mistakes::Mistake| self.mistakes.iter().any(|name| name == mistake.name);
        let seen: Vec<&str> = mistakes::MISTAKES.iter().filter(words).map(|mistake| mistake.words).collect();
        if seen.is_empty() {
            return;
        }
        self.reason += &format!("; resembles {}", seen.join(", or "));
        self.verdict = match self.verdict {
            Verdict::Passes => {
                self.reason += ": on finer meshes it would not converge to the exact solution";
                Verdict::FirstOrder
            }
            _ => Verdict::Wrong,
        };
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
            without_order: case.exact_by_nature,
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
        let told = cost(&said.runs, *refinement);
        let solve_s = told.and_then(|cost| cost.cpu_s);
        let cost = cost(measured, *refinement).or(told).unwrap_or_default();
        let level = Level {
            refinement: *refinement,
            error,
            cpu_s: cost.cpu_s,
            wall_s: cost.wall_s,
            peak_mib: cost.peak_mib,
            solve_s,
        };
        score.levels.push(level);
    }
    score.conservation = conservation(case, answer);
    let known = score.known();
    if known.len() < 2 {
        let why = score.faults.first().map_or_else(String::new, |fault| format!(": {fault}"));
        score.reason =
            format!("{} of {} refinements complete, two at least are needed{why}", known.len(), case.refinements.len());
        if known.is_empty() {
            score.levels.clear();
        }
        return score;
    }
    score.judge(case);
    let compared = answer.levels.iter().filter(|(own, _)| known.iter().any(|(h, _)| *h == 1.0 / own));
    let compared = Answer { levels: compared.cloned().collect(), faults: Vec::new() };
    let seen = mistakes::seen(case, &compared, score.verdict == Verdict::Passes);
    score.mistakes = seen.iter().map(|mistake| mistake.name.to_owned()).collect();
    score.judge(case);
    if known.len() < case.refinements.len() {
        score.flags.push(format!("{} of {} refinements", known.len(), case.refinements.len()));
    }
    if score.convergence().order == Order::RoundOff {
        score.flags.push("the exact solution to round-off on every refinement: computed, or copied?".to_owned());
    }
    score
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

//! The sentences that come first: what to use for a wanted error, and what it costs.

use serde::Serialize;

use super::Findings;
use super::words::{setting, share, time, times, wanted};
use crate::baseline;
use crate::cheapest::{WANTED, best, cheapest};
use crate::row::Row;
use crate::setting::command;

/// What to use for a wanted error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answer {
    /// The wanted error: `0.3 %`.
    pub wanted: String,
    /// What to use and what it costs.
    pub answer: String,
    /// The command that runs it; empty where there is none.
    pub command: String,
}

/// An answer for every wanted error.
pub fn answers(findings: &Findings) -> Vec<Answer> {
    WANTED.iter().map(|wanted| answer(findings, *wanted)).collect()
}

fn answer(findings: &Findings, error: f64) -> Answer {
    let rows = &findings.rows;
    let own = |r: &Row| !baseline::is(&r.integrator);
    let Some(row) = cheapest(rows, error, own) else {
        let nearest = best(rows, own).map_or_else(String::new, |(r, error)| {
            format!(", best {} in {} ({})", share(error), time(r.cpu_s), setting(r))
        });
        let answer = format!("no setting of this sweep reaches it{nearest}.");
        return Answer { wanted: wanted(error), answer, command: String::new() };
    };
    let answer = format!(
        "{}: {} of CPU time, {} steps. Its error is {} ({} relative to Terzaghi).",
        setting(row),
        time(row.cpu_s),
        row.steps,
        share(row.max_error_compressible),
        share(row.max_error_terzaghi)
    );
    Answer { wanted: wanted(error), answer, command: command(row).unwrap_or_default() }
}

/// One paragraph above the answers.
pub fn summary(findings: &Findings) -> String {
    let own = findings.rows.iter().filter(|r| !baseline::is(&r.integrator)).count();
    let volumes = findings.rows.len() - own;
    let mut text = format!(
        "What a wanted error costs on the consolidation column of the paper's Table 1: {own} settings of this program \
         (integrator, shape functions, cell edge L, particles per cell, step or tolerance) and {volumes} of a plain \
         finite-volume program measured in the same run. An error is the largest |U/U_exact \u{2212} 1| over nine \
         times from Tv = 0.01 to 1 relative to the exact solution with finite K_w, the physics of the scene; Terzaghi's own solution, with \
         incompressible water, differs from it by 2.7 % at Tv = 0.01. "
    );
    let at = 3e-3;
    let cheap = |name: &str| cheapest(&findings.rows, at, |r| r.integrator == name);
    if let (Some(quasi), Some(explicit)) = (cheap("quasi-static"), cheap("explicit")) {
        let ratio = times(explicit.cpu_s / quasi.cpu_s);
        text += &format!(
            "At {} the cheapest explicit setting takes {ratio} times the CPU time of the cheapest quasi-static one.",
            wanted(at)
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use mpm_verify::manifest::Manifest;

    use super::*;
    use crate::row::tests::row;

    #[test]
    fn every_wanted_error_has_an_answer_with_its_command_or_says_that_none_gets_there() {
        let mut quasi = row("quasi-static", 0.25, 1e-2, 2e-3, 3e-5);
        quasi.method = "krylov".to_owned();
        let rows = vec![quasi, row("explicit", 0.02, 1e-6, 2.5e-3, 0.6)];
        let manifest = Manifest::new(&mpm_verify::scenes::terzaghi(), 1);
        let findings = Findings::new(manifest, rows, Vec::new(), Vec::new(), Vec::new());
        let answers = answers(&findings);
        assert_eq!(answers.len(), WANTED.len());
        let coarse = &answers[1];
        assert!(coarse.answer.contains("30 \u{b5}s") && coarse.command.contains("--tolerance 1e-2"), "{coarse:?}");
        assert!(answers[4].answer.contains("reaches it, best 0.200 %") && answers[4].command.is_empty());
        assert!(summary(&findings).contains("20\u{a0}000 times"));
    }
}

//! The sentences that come first: what to use for a wanted error, what it costs, what else would cost.

use serde::Serialize;

use super::Findings;
use super::words::{setting, share, time, times, wanted};
use crate::baseline::{self, Kind};
use crate::cheapest::{WANTED, best, cheapest};
use crate::peers::{self, Peer};
use crate::row::Row;
use crate::setting::command;

/// What to use for a wanted error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answer {
    /// The wanted error: `0.3 %`.
    pub wanted: String,
    /// What to use and what it costs.
    pub answer: String,
    /// What the alternatives cost.
    pub beside: Vec<String>,
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
        let answer = format!("no setting of this sweep reaches it{}.", nearest(rows, own));
        return Answer { wanted: wanted(error), answer, beside: Vec::new(), command: String::new() };
    };
    let answer = format!(
        "{}: {} of CPU time, {} steps. Its error is {} ({} relative to Terzaghi).",
        setting(row),
        time(row.cpu_s),
        row.steps,
        share(row.max_error_compressible),
        share(row.max_error_terzaghi)
    );
    let over = |other: f64| format!("{} times that", times(other / row.cpu_s));
    let against = |which: &dyn Fn(&Row) -> bool, name: &str| match cheapest(rows, error, which) {
        Some(r) => format!("{name}: {}, {} ({}).", time(r.cpu_s), over(r.cpu_s), setting(r)),
        None => format!("{name}: not reached{}.", nearest(rows, which)),
    };
    let peer = |kind: &str, name: &str| {
        let found = peers::cheapest(&findings.peers, error, |p| p.kind == kind);
        found.map(|p| format!("{name}, measured elsewhere: {}, {}.", peer(p), over(p.cpu_s())))
    };
    let mut beside = vec![
        against(&|r| r.scheme == Kind::Plain.scheme(), "The plain finite-volume baseline"),
        against(&|r| r.scheme == Kind::Graded.scheme(), "The same with graded cells and steps"),
        against(&|r| r.integrator == "semi-implicit", "Semi-implicit"),
        against(&|r| r.integrator == "explicit" && r.scheme == "centre", "The paper's explicit scheme"),
    ];
    beside.extend(peer("finite-volumes", "NumPy/SciPy script"));
    beside.extend(peer("finite-elements", "Finite elements"));
    beside.push(
        peer("material-points", "Material points")
            .unwrap_or_else(|| "Material points, measured elsewhere: no run of another code reached it.".to_owned()),
    );
    Answer { wanted: wanted(error), answer, beside, command: command(row).unwrap_or_default() }
}

/// How near the best of some settings comes.
fn nearest(rows: &[Row], which: impl Fn(&Row) -> bool) -> String {
    best(rows, which)
        .map_or_else(String::new, |(r, error)| format!(", best {} in {} ({})", share(error), time(r.cpu_s), setting(r)))
}

fn peer(peer: &Peer) -> String {
    let version = if peer.version == "not recorded" { String::new() } else { format!(" {}", peer.version) };
    format!(
        "{}{version} {} ({} relative to {}, L = {} m, {} steps)",
        peer.peer,
        time(peer.cpu_s()),
        share(peer.error()),
        peer.against(),
        peer.mesh_m,
        peer.steps
    )
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
        let mut plain = row("baseline", 0.1, 1e-2, 2e-3, 6e-5);
        plain.scheme = Kind::Plain.scheme().to_owned();
        let rows = vec![quasi, row("explicit", 0.02, 1e-6, 2.5e-3, 0.6), plain];
        let manifest = Manifest::new(&mpm_verify::scenes::terzaghi(), 1);
        let peers = peers::peers().expect("peers");
        let findings = Findings::new(manifest, rows, peers, Vec::new(), Vec::new());
        let answers = answers(&findings);
        assert_eq!(answers.len(), WANTED.len());
        let coarse = &answers[1];
        assert!(coarse.answer.contains("30 \u{b5}s") && coarse.command.contains("--tolerance 1e-2"), "{coarse:?}");
        let all = coarse.beside.join(" ");
        assert!(
            all.contains("2.0 times that") && all.contains("20\u{a0}000 times that") && all.contains("cb-geo/mpm"),
            "{all}"
        );
        assert!(answers[4].answer.contains("reaches it, best 0.200 %") && answers[4].command.is_empty());
        assert!(summary(&findings).contains("20\u{a0}000 times"));
    }
}

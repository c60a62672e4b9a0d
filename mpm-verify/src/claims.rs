//! The paper's statements on accuracy (section 3), one by one: evidence and verdict.
//!
//! A verdict follows from numbers by a rule. The words of each claim and of its rule stand in
//! `reference-data/paper/claims.toml`; the functions of this file carry the rules out and nothing else does.

use serde::{Deserialize, Serialize};

use crate::norms::{largest, relative};
use crate::report::numbers::percent;
use crate::study::{CaseResult, Variant, shown_family};

/// What became of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The numbers show what the paper says.
    Reproduced,
    /// They show it, but not for the reason that the paper gives.
    ReproducedForAnotherReason,
    /// They do not show it.
    NotReproduced,
    /// The runs at hand have no numbers for it.
    #[serde(alias = "cannot-be-tested")]
    NotComparable,
}

impl Verdict {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::ReproducedForAnotherReason => "reproduced for another reason",
            Self::NotReproduced => "not reproduced",
            Self::NotComparable => "not comparable",
        }
    }

    /// The verdict of these words, as a table has them.
    pub fn read(words: &str) -> Option<Self> {
        let all = [Self::Reproduced, Self::ReproducedForAnotherReason, Self::NotReproduced, Self::NotComparable];
        all.into_iter().find(|verdict| verdict.words() == words)
    }

    /// The class of its badge.
    pub fn mark(self) -> &'static str {
        match self {
            Self::Reproduced => "good",
            Self::ReproducedForAnotherReason => "warn",
            Self::NotReproduced => "bad",
            Self::NotComparable => "",
        }
    }
}

/// A claim with its evidence.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// Name, as in `claims.toml`.
    pub id: String,
    /// What the paper says, in short.
    pub said: String,
    /// The rule that the verdict follows.
    pub rule: String,
    /// What was computed, with its numbers.
    pub evidence: String,
    /// The verdict.
    pub verdict: Verdict,
    /// File name (without ending) of the plot that shows it.
    pub picture: String,
}

/// The written part of a claim.
#[derive(Debug, Deserialize)]
struct Words {
    id: String,
    said: String,
    rule: String,
}

#[derive(Debug, Deserialize)]
struct Book {
    claim: Vec<Words>,
}

const BOOK: &str = include_str!("../../reference-data/paper/claims.toml");

/// The finest mesh, where the paper saw the opposite trend, m.
const FINEST: f64 = 0.01;
/// The paper's own setting.
const PAPER_MESH: f64 = 0.02;
const PAPER_PPC: usize = 4;

/// Evidence and verdict; `None` if the runs at hand cannot tell.
type Judged = Option<(String, Verdict)>;
/// The function that carries a claim's rule out.
type Rule = fn(&Runs) -> Judged;

/// Claims in the order of the paper: name, picture, rule.
const RULES: [(&str, &str, Rule); 8] = [
    ("profiles-match", "isochrones", profiles_match),
    ("curve-matches", "consolidation", curve_matches),
    ("error-falls-with-time", "error-against-time-particles", error_falls_with_time),
    ("error-falls-with-mesh", "max-error-against-mesh-terzaghi", error_falls_with_mesh),
    ("negligible-after-0.1", "error-against-time-particles", negligible_late),
    ("error-falls-with-particles", "max-error-against-mesh-terzaghi", error_falls_with_particles),
    ("opposite-trend-at-0.01", "crossings", opposite_trend),
    ("crossing-noise-explanation", "crossings", crossing_noise),
];

/// The base cases of one integrator and scheme with the load on the particles, as in the paper.
struct Runs<'a>(Vec<&'a CaseResult>);

impl<'a> Runs<'a> {
    fn get(&self, mesh: f64, ppc: usize) -> Option<&'a CaseResult> {
        self.0.iter().find(|r| (r.mesh_m - mesh).abs() < 1e-9 && r.ppc == ppc).copied()
    }

    /// Meshes, coarse first.
    fn meshes(&self) -> Vec<f64> {
        let mut meshes: Vec<f64> = self.0.iter().map(|r| r.mesh_m).collect();
        meshes.sort_by(|a, b| b.total_cmp(a));
        meshes.dedup();
        meshes
    }

    fn particles(&self) -> Vec<usize> {
        let mut particles: Vec<usize> = self.0.iter().map(|r| r.ppc).collect();
        particles.sort_unstable();
        particles.dedup();
        particles
    }
}

/// The claims as judged on one integrator and scheme.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Judgement {
    /// Integrator and shape functions: `quasi-static-centre`.
    pub family: String,
    /// The claims, in the order of the paper.
    pub claims: Vec<Claim>,
}

/// Judges every claim on the integrator and scheme that the study is about: the paper's, if it was run.
pub fn judge(results: &[CaseResult]) -> Vec<Claim> {
    judge_family(results, &shown_family(results).unwrap_or_default())
}

/// Judges every claim on the other integrators, with values at the cell centre as in the paper.
pub fn judge_others(results: &[CaseResult]) -> Vec<Judgement> {
    let shown = shown_family(results);
    let mut families: Vec<String> = Vec::new();
    for result in results.iter().filter(|r| r.variant == Variant::Base && r.scheme == "centre") {
        let family = result.family();
        if Some(&family) != shown.as_ref() && !families.contains(&family) {
            families.push(family);
        }
    }
    families.into_iter().map(|family| Judgement { claims: judge_family(results, &family), family }).collect()
}

/// Judges every claim on one integrator and scheme.
///
/// # Panics
/// Never: a test reads the book of claims.
fn judge_family(results: &[CaseResult], family: &str) -> Vec<Claim> {
    let book: Book = toml::from_str(BOOK).expect("the book of claims holds");
    let own = |r: &&CaseResult| r.variant == Variant::Base && r.family() == family;
    let whole = |r: &&CaseResult| r.load == "particles" && r.failure.is_none();
    let runs = Runs(results.iter().filter(own).filter(whole).collect());
    RULES
        .iter()
        .filter_map(|(id, picture, rule)| {
            let words = book.claim.iter().find(|words| words.id == *id)?;
            let (evidence, verdict) =
                rule(&runs).unwrap_or(("the study at hand lacks the runs".to_owned(), Verdict::NotComparable));
            let (said, rule) = (words.said.clone(), words.rule.clone());
            Some(Claim { id: (*id).to_owned(), said, rule, evidence, verdict, picture: (*picture).to_owned() })
        })
        .collect()
}

fn holds(condition: bool) -> Verdict {
    if condition { Verdict::Reproduced } else { Verdict::NotReproduced }
}

fn profiles_match(runs: &Runs) -> Judged {
    let run = runs.get(PAPER_MESH, PAPER_PPC)?;
    let error = run.profile_error_terzaghi;
    Some((format!("RMS(p - p_Terzaghi)/p_0 = {:.2} % at Tv = 0.1", 100.0 * error), holds(error <= 0.02)))
}

fn curve_matches(runs: &Runs) -> Judged {
    let run = runs.get(PAPER_MESH, PAPER_PPC)?;
    let difference = largest(run.degrees.iter().map(|d| d.u - d.u_terzaghi));
    Some((format!("largest |U - U_Terzaghi| = {difference:.4}"), holds(difference <= 0.02)))
}

/// |U/U_Terzaghi - 1| at a time factor.
fn error_at(run: &CaseResult, tv: f64) -> Option<f64> {
    let degree = run.degrees.iter().find(|d| (d.tv / tv - 1.0).abs() < 1e-6)?;
    Some(relative(degree.u, degree.u_terzaghi).abs())
}

fn error_falls_with_time(runs: &Runs) -> Judged {
    let mut falls = 0;
    for run in &runs.0 {
        let [early, middle, late] = [0.01, 0.1, 1.0].map(|tv| error_at(run, tv));
        falls += usize::from(early? > middle? && middle? > late?);
    }
    let count = runs.0.len();
    (count > 0).then(|| {
        let evidence = format!("|error| falls from Tv = 0.01 to 0.1 to 1.0 in {falls} of {count} cases");
        (evidence, holds(falls * 10 >= count * 9))
    })
}

fn error_falls_with_mesh(runs: &Runs) -> Judged {
    let meshes = runs.meshes();
    let (mut coarse, mut fine, mut pairs) = (Vec::new(), Vec::new(), 0);
    for ppc in runs.particles() {
        for pair in meshes.windows(2) {
            let (Some(a), Some(b)) = (runs.get(pair[0], ppc), runs.get(pair[1], ppc)) else { continue };
            pairs += 1;
            if b.max_error_terzaghi >= a.max_error_terzaghi {
                let which = format!(
                    "{} to {} m with {ppc} per cell ({} to {} %)",
                    pair[0],
                    pair[1],
                    percent(a.max_error_terzaghi),
                    percent(b.max_error_terzaghi)
                );
                if pair[1] >= PAPER_MESH - 1e-9 { coarse.push(which) } else { fine.push(which) }
            }
        }
    }
    let list = |found: &[String]| if found.is_empty() { "none".to_owned() } else { found.join("; ") };
    let evidence = format!(
        "refinements (of {pairs}) that raise the error, down to 0.02 m: {}; below: {}",
        list(&coarse),
        list(&fine)
    );
    (pairs > 0).then(|| (evidence, holds(coarse.is_empty())))
}

fn negligible_late(runs: &Runs) -> Judged {
    let run = runs.get(PAPER_MESH, PAPER_PPC)?;
    let error = run.late_error_terzaghi;
    Some((format!("largest error from Tv = 0.1 on: {:.2} %", 100.0 * error), holds(error <= 0.01)))
}

fn error_falls_with_particles(runs: &Runs) -> Judged {
    let (mut falls, mut count) = (0, 0);
    for mesh in runs.meshes().into_iter().filter(|mesh| *mesh > FINEST + 1e-9) {
        for pair in runs.particles().windows(2) {
            let (Some(few), Some(many)) = (runs.get(mesh, pair[0]), runs.get(mesh, pair[1])) else { continue };
            count += 1;
            falls += usize::from(many.max_error_terzaghi < few.max_error_terzaghi);
        }
    }
    (count > 0).then(|| {
        (format!("more particles lower the error in {falls} of {count} comparisons"), holds(falls * 5 >= count * 4))
    })
}

/// How errors go as particles are added.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Trend {
    /// Each is larger than the one before.
    Rises,
    /// Each is smaller, or as large.
    Falls,
    /// Both: a V, or its mirror image. That is no trend.
    Neither,
}

impl Trend {
    fn of(errors: &[f64]) -> Self {
        let rises = errors.windows(2).filter(|pair| pair[1] > pair[0]).count();
        match rises {
            0 => Self::Falls,
            all if all + 1 == errors.len() => Self::Rises,
            _ => Self::Neither,
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Rises => "the error rises with every step",
            Self::Falls => "the error falls",
            Self::Neither => "the error falls and rises again, which is no trend",
        }
    }
}

/// Maximum errors at the finest mesh for growing particle counts, and how they go.
fn trend(runs: &Runs, error: fn(&CaseResult) -> f64) -> Option<(String, Trend)> {
    let errors: Option<Vec<f64>> = runs.particles().iter().map(|ppc| runs.get(FINEST, *ppc).map(error)).collect();
    let errors = errors.filter(|e| e.len() >= 2)?;
    let text: Vec<String> = errors.iter().map(|e| percent(*e)).collect();
    Some((format!("{} %", text.join(", ")), Trend::of(&errors)))
}

fn opposite_trend(runs: &Runs) -> Judged {
    let (errors, trend) = trend(runs, |r| r.max_error_terzaghi)?;
    let particles: Vec<String> = runs.particles().iter().map(ToString::to_string).collect();
    let evidence =
        format!("errors relative to Terzaghi with {} per cell: {errors}: {}", particles.join(", "), trend.words());
    Some((evidence, holds(trend == Trend::Rises)))
}

fn crossing_noise(runs: &Runs) -> Judged {
    let (_, there) = trend(runs, |r| r.max_error_terzaghi)?;
    let (errors, still_there) = trend(runs, |r| r.max_error_compressible)?;
    let crossings: u64 =
        runs.particles().iter().filter_map(|ppc| runs.get(FINEST, *ppc)).map(|r| r.cell_crossings).sum();
    let evidence = format!(
        "{crossings} cell crossings in these runs; relative to the exact solution with finite bulk modulus of the pore water the errors \
         are {errors}: the trend {}",
        match (there, still_there) {
            (Trend::Rises, Trend::Rises) => "stays",
            (Trend::Rises, _) => "is gone",
            _ => "is not there in the first place",
        }
    );
    let verdict = match (there, crossings, still_there) {
        (Trend::Falls | Trend::Neither, _, _) => Verdict::NotComparable,
        (Trend::Rises, 0, Trend::Falls | Trend::Neither) => Verdict::ReproducedForAnotherReason,
        (Trend::Rises, 1.., Trend::Rises) => Verdict::Reproduced,
        _ => Verdict::NotReproduced,
    };
    Some((evidence, verdict))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::tests::result;

    /// A run at a mesh with given errors; crossings as given.
    fn run(mesh: f64, ppc: usize, terzaghi: f64, compressible: f64, crossings: u64) -> CaseResult {
        let mut run = result(mesh, ppc, "particles");
        run.max_error_terzaghi = terzaghi;
        run.max_error_compressible = compressible;
        run.cell_crossings = crossings;
        run
    }

    fn verdict(results: &[CaseResult], id: &str) -> Verdict {
        judge(results).into_iter().find(|claim| claim.id == id).expect("a claim").verdict
    }

    #[test]
    fn every_rule_has_its_words() {
        let book: Book = toml::from_str(BOOK).expect("the book of claims holds");
        assert_eq!(book.claim.len(), RULES.len());
        assert_eq!(judge(&[]).len(), RULES.len());
        assert!(judge(&[]).iter().all(|claim| claim.verdict == Verdict::NotComparable));
    }

    #[test]
    fn the_explanation_by_crossings_can_come_out_either_way() {
        let compressibility = [run(0.01, 4, 0.004, 0.022, 0), run(0.01, 9, 0.012, 0.015, 0)];
        assert_eq!(verdict(&compressibility, "opposite-trend-at-0.01"), Verdict::Reproduced);
        assert_eq!(verdict(&compressibility, "crossing-noise-explanation"), Verdict::ReproducedForAnotherReason);
        let noise = [run(0.01, 4, 0.004, 0.015, 90), run(0.01, 9, 0.012, 0.022, 90)];
        assert_eq!(verdict(&noise, "crossing-noise-explanation"), Verdict::Reproduced);
        let neither = [run(0.01, 4, 0.012, 0.022, 0), run(0.01, 9, 0.004, 0.015, 0)];
        assert_eq!(verdict(&neither, "opposite-trend-at-0.01"), Verdict::NotReproduced);
        assert_eq!(verdict(&neither, "crossing-noise-explanation"), Verdict::NotComparable);
    }

    #[test]
    fn a_v_is_no_trend() {
        // The study's own errors with 1, 4 and 9 particles per cell at L = 0.01 m.
        let v = [run(0.01, 1, 0.0170, 0.02, 0), run(0.01, 4, 0.0045, 0.01, 0), run(0.01, 9, 0.0117, 0.015, 0)];
        assert_eq!(verdict(&v, "opposite-trend-at-0.01"), Verdict::NotReproduced);
        assert_eq!(verdict(&v, "crossing-noise-explanation"), Verdict::NotComparable);
        let claim = judge(&v).into_iter().find(|claim| claim.id == "opposite-trend-at-0.01").expect("a claim");
        assert!(claim.evidence.ends_with("falls and rises again, which is no trend"), "{}", claim.evidence);
    }

    #[test]
    fn each_integrator_is_judged_by_its_own_runs() {
        let explicit = [run(0.01, 4, 0.004, 0.022, 0), run(0.01, 9, 0.012, 0.015, 0)];
        let other = [run(0.01, 4, 0.012, 0.022, 0), run(0.01, 9, 0.004, 0.015, 0)];
        let mut results = other.map(|r| CaseResult { integrator: "quasi-static".to_owned(), ..r }).to_vec();
        results.extend(explicit);
        results.push(CaseResult { scheme: "gimp".to_owned(), ..results[0].clone() });
        assert_eq!(verdict(&results, "opposite-trend-at-0.01"), Verdict::Reproduced);
        let others = judge_others(&results);
        assert_eq!(others.len(), 1);
        assert_eq!(others[0].family, "quasi-static-centre");
        let trend = others[0].claims.iter().find(|claim| claim.id == "opposite-trend-at-0.01").expect("a claim");
        assert_eq!(trend.verdict, Verdict::NotReproduced);
    }

    #[test]
    fn the_other_rules_can_fail() {
        let good = [run(0.05, 4, 0.1, 0.1, 0), run(0.02, 4, 0.05, 0.1, 0), run(0.02, 9, 0.02, 0.1, 0)];
        assert_eq!(verdict(&good, "error-falls-with-mesh"), Verdict::Reproduced);
        assert_eq!(verdict(&good, "error-falls-with-particles"), Verdict::Reproduced);
        let bad = [run(0.05, 4, 0.05, 0.1, 0), run(0.02, 4, 0.1, 0.1, 0), run(0.02, 9, 0.2, 0.1, 0)];
        assert_eq!(verdict(&bad, "error-falls-with-mesh"), Verdict::NotReproduced);
        assert_eq!(verdict(&bad, "error-falls-with-particles"), Verdict::NotReproduced);
        for (error, expected) in [(0.001, Verdict::Reproduced), (0.5, Verdict::NotReproduced)] {
            let mut run = run(0.02, 4, error, error, 0);
            (run.late_error_terzaghi, run.profile_error_terzaghi) = (error, error);
            for degree in &mut run.degrees {
                degree.u = degree.u_terzaghi + error * (1.0 - degree.tv * 0.9);
            }
            for id in ["profiles-match", "curve-matches", "negligible-after-0.1"] {
                assert_eq!(verdict(&[run.clone()], id), expected, "{id}");
            }
            assert_eq!(verdict(&[run.clone()], "error-falls-with-time"), Verdict::Reproduced);
            run.degrees[8].u = 9.0;
            assert_eq!(verdict(&[run], "error-falls-with-time"), Verdict::NotReproduced);
        }
    }
}

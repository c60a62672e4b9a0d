//! What the pages say. [`super::html`] and [`super::markdown`] only say how.

pub mod schemes;
pub mod table;
pub mod terms;

use serde::Serialize;

use self::table::Table;
use self::terms::TERMS;
use super::Study;
use super::numbers::percent;
use super::orders::{Group, groups};
use super::plots::figure::Figure;
use super::select::{Cases, LOADS, PAPER, Reference, compressibility, families};
use crate::claims::{Claim, Verdict};
use crate::study::{CaseResult, Variant, shown_family, word};

/// All text and tables of a page.
#[derive(Debug, Clone, Serialize)]
pub struct Content {
    /// Title.
    pub title: String,
    /// One paragraph.
    pub summary: String,
    /// Runs that failed or were forced: to be seen first.
    pub warnings: Vec<String>,
    /// Largest errors, a table per load.
    pub errors: Vec<Table>,
    /// Orders of convergence.
    pub orders: Vec<Table>,
    /// Every integrator and scheme side by side.
    pub schemes: Vec<Table>,
    /// Displaced particles and offsets of the mesh.
    pub places: Vec<Table>,
    /// Errors in time.
    pub time: Vec<Table>,
    /// The paper's statements.
    pub claims: Vec<ClaimText>,
    /// The same with other integrators.
    pub other_claims: Vec<Table>,
    /// Parts of the error.
    pub budgets: Vec<Table>,
    /// Time of the runs.
    pub speed: Vec<Table>,
    /// Every case with all its numbers.
    pub cases: Vec<Table>,
    /// Terms and what they mean.
    pub terms: Vec<(&'static str, &'static str)>,
    /// What pictures lack.
    pub missing: Vec<String>,
    /// Notes of the study.
    pub notes: Vec<String>,
    /// Conditions: name and value.
    pub manifest: Vec<(&'static str, String)>,
    /// Pictures in the order of the page.
    pub pictures: Vec<Picture>,
    /// Whether the page of the suite is beside this one.
    pub suite: bool,
}

/// A claim as the pages show it.
#[derive(Debug, Clone, Serialize)]
pub struct ClaimText {
    /// Name.
    pub id: String,
    /// What the paper says.
    pub said: String,
    /// The rule.
    pub rule: String,
    /// The numbers.
    pub evidence: String,
    /// The verdict in words.
    pub verdict: &'static str,
    /// How its badge looks: `good`, `warn`, `bad` or `plain`.
    pub mark: &'static str,
    /// Name of the picture; empty if there is none of that name.
    pub picture: String,
    /// Its number on the page.
    pub number: usize,
}

/// A picture's words.
#[derive(Debug, Clone, Serialize)]
pub struct Picture {
    /// File name without ending.
    pub name: &'static str,
    /// Number on the page, from 1.
    pub number: usize,
    /// Title.
    pub title: String,
    /// What to see.
    pub caption: String,
}

impl Picture {
    /// The words of some pictures, numbered in their order.
    pub fn all(figures: &[Figure]) -> Vec<Self> {
        let words = |(k, f): (usize, &Figure)| {
            let (title, caption) = (f.title.clone(), f.caption.clone());
            Self { name: f.name, number: k + 1, title, caption }
        };
        figures.iter().enumerate().map(words).collect()
    }
}

impl Content {
    /// Gathers everything that pages say about a study.
    pub fn new(study: &Study, figures: &[Figure]) -> Self {
        let pictures = Picture::all(figures);
        let groups = groups(&study.results);
        Self {
            title: "Accuracy of the two-layer material point method in one-dimensional consolidation".to_owned(),
            summary: summary(study, &groups),
            warnings: warnings(study),
            errors: table::errors(&study.results),
            orders: table::orders(&groups, &shown_family(&study.results).unwrap_or_default()),
            schemes: schemes::schemes(&study.results, &groups),
            places: schemes::places(&study.sweeps),
            time: schemes::time(&study.sweeps),
            other_claims: schemes::other_claims(&study.other_claims),
            claims: claims(study, &pictures),
            budgets: table::budgets(study),
            speed: table::speed(&study.results).into_iter().chain(table::costs(&study.costs)).collect(),
            cases: table::cases(&study.results),
            terms: TERMS.to_vec(),
            missing: missing(study, figures),
            notes: study.notes.clone(),
            manifest: study.manifest.entries().to_vec(),
            pictures,
            suite: false,
        }
    }
}

fn claims(study: &Study, pictures: &[Picture]) -> Vec<ClaimText> {
    let text = |c: &Claim| {
        let picture = pictures.iter().find(|p| p.name == c.picture);
        ClaimText {
            id: c.id.clone(),
            said: c.said.clone(),
            rule: c.rule.clone(),
            evidence: c.evidence.clone(),
            verdict: c.verdict.words(),
            mark: match c.verdict {
                Verdict::Reproduced => "good",
                Verdict::ReproducedForAnotherReason => "warn",
                Verdict::NotReproduced => "bad",
                Verdict::CannotBeTested => "plain",
            },
            picture: picture.map_or_else(String::new, |p| p.name.to_owned()),
            number: picture.map_or(0, |p| p.number),
        }
    };
    study.claims.iter().map(text).collect()
}

/// Failed runs named in warnings; the table of cases has all of them.
const NAMED: usize = 12;

/// A sentence per run that failed, one for all that were forced.
fn warnings(study: &Study) -> Vec<String> {
    let name = |r: &CaseResult| match r.variant {
        Variant::Base => r.case.clone(),
        other => format!("{} ({})", r.case, word(other)),
    };
    let mut failed: Vec<String> =
        study.results.iter().filter_map(|r| Some(format!("Failed: {}: {}", name(r), r.failure.as_ref()?))).collect();
    if failed.len() > NAMED {
        let more = failed.len() - NAMED;
        failed.truncate(NAMED);
        failed.push(format!("Failed: {more} more runs."));
    }
    let forced: Vec<&CaseResult> = study.results.iter().filter(|r| r.forced).collect();
    if let Some(worst) = forced.iter().max_by(|a, b| (a.dt_s / a.limit_s).total_cmp(&(b.dt_s / b.limit_s))) {
        let times = worst.dt_s / worst.limit_s;
        failed.push(format!(
            "Forced: {} of {} runs have a time step above the stability limit, up to {times:.2} times ({}).",
            forced.len(),
            study.results.len(),
            name(worst)
        ));
    }
    failed
}

fn missing(study: &Study, figures: &[Figure]) -> Vec<String> {
    let mut missing: Vec<String> = figures.iter().flat_map(|f| f.missing.clone()).collect();
    let base = study.results.iter().filter(|r| r.variant == Variant::Base);
    let left_out = base.filter(|r| r.failure.is_some()).count();
    if left_out > 0 {
        missing.insert(0, format!("{left_out} failed runs are left out of pictures and orders."));
    }
    let unknown = study.results.iter().filter(|r| r.failure.is_none() && r.max_error_terzaghi.is_nan());
    missing.extend(unknown.map(|r| format!("{}: no largest error, some sample times are not there.", r.case)));
    if let Some(shown) = shown_family(&study.results)
        && families(&study.results).len() > 1
    {
        missing.push(format!("Pictures and tables of one scheme show {shown}."));
    }
    missing
}

fn summary(study: &Study, groups: &[Group]) -> String {
    let cases = Cases::of(&study.results);
    let list = |values: Vec<String>| values.join(", ");
    let mut text = format!(
        "{} cases with cells of {} m and {} particles per cell: the degree of consolidation U is compared with two \
         exact solutions, Terzaghi's with incompressible water and the same with the water's own stiffness. ",
        study.results.iter().filter(|r| r.variant == Variant::Base).count(),
        list(cases.meshes().iter().map(ToString::to_string).collect()),
        list(cases.particles().iter().map(ToString::to_string).collect()),
    );
    let at_paper = LOADS.iter().filter_map(|(load, words)| {
        let [terzaghi, compressible] = {
            let r = cases.get(load, PAPER.0, PAPER.1)?;
            Reference::BOTH.map(|reference| percent(reference.largest(r)))
        };
        Some(format!("{terzaghi} % against Terzaghi and {compressible} % against compressible water with the {words}"))
    });
    let at_paper: Vec<String> = at_paper.collect();
    if !at_paper.is_empty() {
        let (mesh, ppc) = PAPER;
        let errors = at_paper.join(", ");
        text += &format!("At the paper's setting (L = {mesh} m, {ppc} per cell) the largest error is {errors}. ");
    }
    let shown = shown_family(&study.results).unwrap_or_default() + "-";
    let usual = groups.iter().filter(|g| Some(g.ppc) == cases.usual_particles() && g.name.starts_with(&shown));
    let orders = usual.filter_map(|group| {
        let (_, fit) = group.fits.iter().find(|(norm, _)| *norm == "max-compressible")?;
        Some(format!("{} (load on the {}, {} per cell)", table::order_text(fit.as_ref()?), group.load, group.ppc))
    });
    let orders: Vec<String> = orders.collect();
    if !orders.is_empty() {
        text += &format!("Against compressible water it falls with L at order {}. ", orders.join(" and "));
    }
    if let Some(case) = cases.0.first() {
        let floor = percent(compressibility(case));
        text +=
            &format!("Against Terzaghi it does not tend to zero but to {floor} %, where the two solutions differ. ");
    }
    text + &best(study) + &verdicts(study)
}

/// The smallest error on the coarsest mesh, whatever the scheme.
fn best(study: &Study) -> String {
    let base = study.results.iter().filter(|r| r.variant == Variant::Base && r.max_error_compressible.is_finite());
    let coarsest = base.clone().map(|r| r.mesh_m).fold(0.0, f64::max);
    let own = base.filter(|r| r.mesh_m == coarsest);
    let Some(best) = own.min_by(|a, b| a.max_error_compressible.total_cmp(&b.max_error_compressible)) else {
        return String::new();
    };
    format!(
        "On the coarsest mesh, L = {coarsest} m, the smallest error against compressible water is {} %: {}. ",
        percent(best.max_error_compressible),
        best.case
    )
}

/// How many claims ended with which verdict.
fn verdicts(study: &Study) -> String {
    let all =
        [Verdict::Reproduced, Verdict::ReproducedForAnotherReason, Verdict::NotReproduced, Verdict::CannotBeTested];
    let counted = all.map(|v| (study.claims.iter().filter(|c| c.verdict == v).count(), v.words()));
    let parts: Vec<String> = counted.iter().filter(|(n, _)| *n > 0).map(|(n, words)| format!("{n} {words}")).collect();
    if parts.is_empty() {
        return String::new();
    }
    format!("Of the paper's {} statements on accuracy: {}.", study.claims.len(), parts.join(", "))
}

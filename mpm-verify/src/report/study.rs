//! The pages of the accuracy study: the study at a glance, the verdict on the paper's claims and the errors first, then the paper side by
//! side, orders of convergence, curves, and all cases.

use std::path::Path;

use super::content::{missing, paper, schemes, table, terms::TERMS, warnings};
use super::numbers::percent;
use super::orders::groups;
use super::plots::figure::Figure;
use super::plots::{at_a_glance, time_step};
use super::select::{Cases, PAPER, Reference};
use super::{ReportError, Study, save};
use crate::claims::{self, Claim};
use crate::page::site::{Kind, Report};
use crate::page::table::{Cell, Table};
use crate::page::verdict::{Counts, State, Tally, Verdict};
use crate::page::{Block, Link, Page, Section};
use crate::study::{CaseResult, Variant, shown_family};

/// Errors of the paper's scheme.
const MAIN: &str = "max-error-against-mesh-terzaghi";
/// Pages: file and title.
const PAGES: [(&str, &str); 5] = [
    ("index.html", "Accuracy study"),
    ("paper.html", "The paper side by side"),
    ("convergence.html", "Orders of convergence"),
    ("curves.html", "Profiles, curves and parts of the error"),
    ("cases.html", "All cases, cost and terms"),
];

/// Text on the left, picture on the right, where there is room for both.
const BESIDE: &str = "@media (min-width: 1000px) { section:has(> dl) { display: grid; \
    grid-template-columns: minmax(0, 5fr) minmax(0, 7fr); gap: 0 2rem; align-items: start; } \
    section:has(> dl) > h2 { grid-column: 1 / -1; } section:has(> dl) dl > div { grid-template-columns: 1fr; } }\n";

/// Writes the pages and `report.md`, which holds all of them, into a folder where the figures are in `plots`.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(study: &Study, figures: &[Figure], folder: &Path) -> Result<(), ReportError> {
    let of = Of { study, figures };
    let pages = [of.first(), of.paper(folder), of.convergence(), of.curves(), of.cases()];
    for ((file, title), page) in PAGES.into_iter().zip(&pages) {
        let others = PAGES.iter().filter(|(other, _)| *other != file);
        let beside = others.map(|(other, title)| Link::new(*title, *other)).collect();
        let page = page.clone().beside(beside);
        let page = if file == "index.html" {
            page
        } else {
            Page { title: title.to_owned(), ..page.below("Accuracy study", "index.html") }
        };
        page.write(&folder.join(file))?;
    }
    let [mut whole, others @ ..] = pages;
    whole.sections.extend(others.into_iter().flat_map(|page| page.sections));
    let path = folder.join("report.md");
    save(&path, whole.markdown(&path)?)
}

/// Claims, counted.
fn counts(claims: &[Claim]) -> Counts {
    Counts::of_claims(claims.iter().map(|claim| claim.verdict))
}

/// A verdict on a claim as a badge.
pub fn badge(verdict: claims::Verdict) -> Cell {
    Cell::badge(verdict.words(), verdict.mark())
}

struct Of<'a> {
    study: &'a Study,
    figures: &'a [Figure],
}

impl Of<'_> {
    /// A section with some of the figures.
    fn drawn(&self, section: Section, names: &[&str]) -> Section {
        let wanted = names.iter().filter_map(|name| self.figures.iter().find(|f| f.name == *name));
        wanted.fold(section, |section, figure| section.figure(figure))
    }

    fn first(&self) -> Page {
        let study = self.study;
        let groups = groups(&study.results);
        let schemes = schemes::schemes(&study.results, &groups);
        let failed = study.results.iter().filter(|r| r.failure.is_some()).count();
        let runs = Counts::Runs { complete: study.results.len() - failed, stopped: failed };
        let claims = Tally::new("Claims of the paper on accuracy", counts(&study.claims));
        let runs = Tally::new("Runs of the accuracy study", runs);
        let glance = self.figures.iter().find(|f| f.name == at_a_glance::NAME);
        let report = Report::new(Kind::Study)
            .counts([claims, runs])
            .picture(format!("plots/{}.svg", at_a_glance::NAME), glance.map_or("", |figure| &figure.title));
        let files =
            ["errors.csv", "consolidation.csv", "orders.csv", "budget.csv", "claims.csv", "claims_integrators.csv"];
        let mut files = files.to_vec();
        let sweeps = &study.sweeps;
        files.extend(
            (!schemes::places(sweeps).is_empty()).then_some(["displaced.csv", "grid_shift.csv"]).into_iter().flatten(),
        );
        files.extend((!schemes::time(sweeps).is_empty()).then_some("time_error.csv"));
        files.push("study.json");
        let words = |id: &str, title: &str, items: Vec<String>| Section::new(id, title).list(items);
        Page::new("Accuracy study: one-dimensional consolidation")
            .verdict(self.verdict())
            .lead(self.lead())
            .warnings(warnings(study))
            .section(self.drawn(Section::new("picture", "At a glance"), &[at_a_glance::NAME]))
            .section(
                Section::new("claims", "Claims of the paper")
                    .tables([self.claims()])
                    .tables(schemes::other_claims(&study.other_claims)),
            )
            .section(
                self.drawn(Section::new("errors", "Errors"), &[MAIN])
                    .tables(table::errors(&study.results))
                    .files(files),
            )
            .section(
                self.drawn(Section::new("integrators", "Errors per integrator"), &["error-of-all-schemes"])
                    .tables(schemes.into_iter().take(1)),
            )
            .section(words("missing", "What is left out", missing(study, self.figures)).folded())
            .section(words("notes", "Notes", study.notes.clone()).folded())
            .conditions(&study.manifest)
            .report(report)
    }

    fn verdict(&self) -> Verdict {
        let claims = counts(&self.study.claims);
        let failed = self.study.results.iter().filter(|r| r.failure.is_some()).count();
        let sentence = format!("Of the paper's claims on accuracy {}.", claims.words());
        match failed {
            0 => Verdict::new(claims.state(), sentence),
            n => Verdict::new(State::Stopped, format!("{n} of {} runs stopped. {sentence}", self.study.results.len())),
        }
    }

    /// The error at the paper's setting.
    fn lead(&self) -> String {
        let results = &self.study.results;
        let cases = Cases::of(results);
        let count = results.iter().filter(|r| r.variant == Variant::Base).count();
        let Some(paper) = cases.get("particles", PAPER.0, PAPER.1) else {
            return format!("{count} cases. The paper's own setting is not among them.");
        };
        let [terzaghi, compressible] = Reference::BOTH.map(|reference| percent(reference.largest(paper)));
        format!(
            "{count} cases. At the paper's setting (L = {} m, {} particles per cell, traction on boundary particles) the largest \
             error of the degree of consolidation is {terzaghi} % relative to Terzaghi's solution and {compressible} % relative to \
             the exact solution with finite bulk modulus of the pore water.",
            PAPER.0, PAPER.1
        )
    }

    fn claims(&self) -> Table {
        let row = |claim: &Claim| {
            let figure = self.figures.iter().find(|f| f.name == claim.picture);
            let shown = figure.map_or_else(
                || Cell::new("–"),
                |figure| {
                    Cell::new(figure.title.clone()).linked(&format!("{}#fig-{}", page_of(figure.name), figure.name))
                },
            );
            let said = Cell::new(claim.said.clone());
            vec![said, badge(claim.verdict), Cell::new(claim.evidence.clone()).small(claim.rule.clone()), shown]
        };
        let head = ["claim", "verdict", "evidence", "figure"];
        let note = "Small letters: the rule that the verdict follows.";
        Table::new("Claims of the paper on accuracy", &head, self.study.claims.iter().map(row).collect(), note).words()
    }

    fn paper(&self, folder: &Path) -> Page {
        let items = paper::items(&self.study.claims, folder);
        let lead = "Known of the paper is its text, with its tables and the captions of its figures. Where only a figure holds the numbers, \
                    they are \"not available\". Every picture here is of this program.";
        let counts = paper::counts(&items);
        let sentence = format!("Of {} claims of the paper and of the experiment {}.", counts.total(), counts.words());
        let claims = Section::new("items", "Claims of the paper").index(paper::table(&items));
        let page = Page::new("The paper side by side")
            .verdict(Verdict::new(counts.state(), sentence))
            .lead(lead)
            .style(BESIDE)
            .section(claims);
        paper::sections(&items, self.figures).into_iter().fold(page, Page::section)
    }

    fn convergence(&self) -> Page {
        let results = &self.study.results;
        let groups = groups(results);
        let family = shown_family(results).unwrap_or_default();
        let further = schemes::schemes(results, &groups).into_iter().skip(1);
        let mesh = ["max-error-against-mesh-compressible", "profile-error-against-mesh"];
        let steps = ["error-against-steps", "error-against-factorisations"];
        let sweeps = &self.study.sweeps;
        Page::new("")
            .lead("Orders are slopes of the error over the cell edge L, with the half width of their 95 % confidence interval.")
            .section(
                self.drawn(Section::new("orders", "Orders of convergence"), &mesh).tables(table::orders(&groups, &family)),
            )
            .section(
                self.drawn(
                    Section::new("schemes", "Integrators and shape functions"),
                    &["profile-error-of-all-schemes", "isochrones-bspline2"],
                )
                .tables(further),
            )
            .section(
                self.drawn(Section::new("places", "Displaced particles, shifted mesh"), &["displaced", "grid-shift"])
                    .tables(schemes::places(sweeps)),
            )
            .section(self.drawn(Section::new("time", "Errors in time"), &steps).tables(schemes::time(sweeps)))
    }

    fn curves(&self) -> Page {
        let curves = [
            time_step::NAME,
            "mesh",
            "isochrones",
            "consolidation",
            "error-against-time-particles",
            "error-against-time-surface",
            "crossings",
        ];
        Page::new("")
            .section(self.drawn(Section::new("curves", "Profiles and curves"), &curves))
            .section(
                self.drawn(Section::new("budget", "Parts of the error"), &["error-budget", "error-budget-late"])
                    .tables(table::budgets(self.study)),
            )
            .section(self.drawn(Section::new("energy", "Energy"), &["energy"]))
    }

    fn cases(&self) -> Page {
        let results: &[CaseResult] = &self.study.results;
        let cases = Section::new("cases", "All cases").index(table::cases(results));
        let speed = table::speed(results).into_iter().chain(table::costs(&self.study.costs));
        let terms = TERMS.iter().map(|(term, meaning)| ((*term).to_owned(), (*meaning).to_owned())).collect();
        Page::new("")
            .section(cases.files(["errors.csv"]))
            .section(Section::new("cost", "Cost").tables(speed))
            .section(Section::new("terms", "Terms").with(Block::Terms(terms)))
    }
}

/// The page that a figure is on.
pub fn page_of(name: &str) -> &'static str {
    match name {
        at_a_glance::NAME | MAIN | "error-of-all-schemes" => "index.html",
        "max-error-against-mesh-compressible"
        | "profile-error-against-mesh"
        | "profile-error-of-all-schemes"
        | "isochrones-bspline2"
        | "displaced"
        | "grid-shift"
        | "error-against-steps"
        | "error-against-factorisations" => "convergence.html",
        _ => "curves.html",
    }
}

//! What the pages say, section by section. A further section is a function and an entry in [`sections`].

use mpm_verify::report::content::table::Table;
use serde::Serialize;

use super::{Findings, kernel, plots, tables};
use crate::cheapest::costs;

/// A section of the pages.
#[derive(Debug, Clone, Serialize)]
pub struct Section {
    /// Its place in the page.
    pub id: &'static str,
    /// Its title.
    pub title: &'static str,
    /// Paragraphs.
    pub text: Vec<String>,
    /// A list below them.
    pub items: Vec<String>,
    /// Names of pictures.
    pub pictures: Vec<&'static str>,
    /// Tables.
    pub tables: Vec<Table>,
}

/// The section of costs, which the answers follow.
pub const COST: &str = "cost";

/// All sections in the order of the page.
pub fn sections(findings: &Findings) -> Vec<Section> {
    let mut sections = vec![cost(findings), schemes(), growth(findings)];
    sections.extend(findings.kernel.as_ref().map(kernel::section));
    sections.extend([peers(findings), left_out(findings), measured(findings)]);
    sections
}

fn section(id: &'static str, title: &'static str) -> Section {
    Section { id, title, text: Vec::new(), items: Vec::new(), pictures: Vec::new(), tables: Vec::new() }
}

fn cost(findings: &Findings) -> Section {
    Section {
        text: vec![
            "A setting counts only if every run that differs from it by a shorter step or a tighter tolerance alone also reaches \
             the wanted error: errors in space and in time may cancel by chance."
                .to_owned(),
        ],
        tables: vec![tables::cost(&costs(&findings.rows))],
        ..section(COST, "Cost of a wanted error")
    }
}

fn schemes() -> Section {
    Section { pictures: vec![plots::BY_SCHEME], ..section("schemes", "Shape functions") }
}

fn growth(findings: &Findings) -> Section {
    Section {
        pictures: vec![plots::GROWTH],
        tables: vec![tables::growth(findings), tables::dimensions(findings)],
        ..section("growth", "How cost grows on finer meshes")
    }
}

fn peers(findings: &Findings) -> Section {
    Section {
        text: vec![
            "Other codes on the same column, measured on another machine, each with a typical setting: compare orders of magnitude. \
             Where no error relative to the exact solution with finite K_w is known, the one against \
             Terzaghi is given."
                .to_owned(),
        ],
        tables: vec![tables::peers(&findings.peers)],
        ..section("peers", "Other codes, measured elsewhere")
    }
}

fn left_out(findings: &Findings) -> Section {
    let mut items = findings.left_out.clone();
    let failed: Vec<&str> = findings.rows.iter().filter(|r| r.failure.is_some()).map(|r| r.case.as_str()).collect();
    if !failed.is_empty() {
        items.push(format!(
            "{} runs failed and are left out of the figures: {}. `speed_against_error.csv` says why.",
            failed.len(),
            failed.join(", ")
        ));
    }
    Section { items, ..section("left-out", "What was left out, and why") }
}

fn measured(findings: &Findings) -> Section {
    let text = "CPU time of one thread for a whole solve, from the checked scene to U at the nine times, set-up \
                included; no other output is computed. The time is the median over all samples; the CSV has the smallest and \
                the largest beside it. A sample is one run, or the mean of as many runs as fit into half a millisecond. \
                Settings are timed in random order, a new one at each visit, so that other load on the machine affects all \
                alike; a setting that takes longer than 1.5 s is run once. Memory is the largest heap of a solve with its \
                result, counted in a separate run.";
    let baseline = "The baseline is a simple program: finite volumes of the same equation with finite K_w, BDF2 after one step of implicit Euler, a tridiagonal matrix factored once. \
                    Plain: equal cells and a constant step. Graded: cells that grow with the depth and as many steps \
                    from each sample time to the next. Cells and steps of both are varied in the same way.";
    Section {
        text: vec![text.to_owned(), baseline.to_owned()],
        items: findings.notes.clone(),
        ..section("measured", "How it was measured")
    }
}

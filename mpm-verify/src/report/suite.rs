//! The page of the verification suite: every verdict with its reason, every case with its picture.

use std::path::Path;

use super::content::table::{Cell, Table, order_cell, order_rule, table};
use super::numbers::{brief, exact, short};
use super::tables;
use super::{ReportError, save};
use crate::experiment::{Judged, Refinement, RefinementRow, SampleRow};
use crate::manifest::Manifest;
use crate::page::site::{self, Report};
use crate::page::verdict::{Checks, Counts, Tally, Verdict};
use crate::page::{Page, Section};
use crate::study::word;

/// Columns of `notes.csv`.
pub const NOTES: &str = "case,quantity,value,unit";
/// Columns of `samples.csv`.
pub const SAMPLES: &str = "case,quantity,time_s,time_factor,computed,exact,error,unit,counts";
/// Columns of `refinements.csv`.
pub const REFINEMENTS: &str =
    "case,by,parameter,unit,error,order,order_low,order_high,asymptotic,required_order,against,order_verdict";

/// Writes `samples.csv` (the finest run of a case at every sample time), `refinements.csv` (every run of
/// every refinement), `<case>.svg` and `<case>.csv` (refinement parameter, signed error) for every case, `notes.csv` if there are notes, `manifest.json` and `index.html`.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(judged: &[Judged], manifest: &Manifest, folder: &Path) -> Result<(), ReportError> {
    judged.iter().try_for_each(|one| super::case::write(one, judged, folder))?;
    let notes = || judged.iter().flat_map(|judged| judged.notes.iter().map(move |note| (judged, note)));
    if notes().next().is_some() {
        let row = |(judged, (quantity, value, unit)): (&Judged, &(String, f64, String))| {
            vec![judged.case.name.to_owned(), quantity.clone(), exact(*value), unit.clone()]
        };
        tables::table(&folder.join("notes.csv"), NOTES, notes().map(row))?;
    }
    samples(judged, folder)?;
    refinements(judged, folder)?;
    let conditions = folder.join("manifest.json");
    let json = serde_json::to_string_pretty(manifest).map_err(|e| super::unwritable(&conditions, e))?;
    save(&conditions, json)?;
    let failed = judged.iter().filter(|c| !c.row.passed()).map(|c| format!("{}: {}", c.case.name, c.reason));
    let numbers = if notes().next().is_some() { vec![further_numbers(judged)] } else { Vec::new() };
    let mut files = vec!["cases.csv", "samples.csv", "refinements.csv"];
    files.extend((!numbers.is_empty()).then_some("notes.csv"));
    let first = judged.first().map_or("", |judged| judged.case.name);
    let picture = if first.is_empty() { String::new() } else { format!("{first}/convergence.svg") };
    let alt = format!("Error of the case {first} over its mesh");
    // The scenes are those of the cases, not one of them.
    let mut page = Page::new("The verification suite")
        .verdict(verdict(judged))
        .warnings(failed)
        .section(Section::new("cases", "Cases").index(cases(judged)).files(files))
        .section(Section::new("refinements", "Refinements").index(orders(judged)))
        .section(Section::new("notes", "Further numbers").folded().tables(numbers))
        .section(Section::new("mutants", "Mutants").folded().tables([mutants(judged)]))
        .conditions(manifest)
        .report(Report::new(site::Kind::Suite).counts([tally(judged)]).picture(picture, alt));
    page.conditions.retain(|(name, _)| name != "scene hash");
    page.write(&folder.join("index.html"))
}

fn tally(judged: &[Judged]) -> Tally {
    let count = |which: fn(&Judged) -> bool| judged.iter().filter(|c| which(c)).count();
    let (not_established, failed) = (count(|c| c.row.open()), count(|c| !c.row.passed()));
    let passed = judged.len() - not_established - failed;
    let checks = Checks { passed, not_established, failed, ..Checks::default() };
    Tally::new("Verification suite", Counts::Checks(checks))
}

fn verdict(judged: &[Judged]) -> Verdict {
    let counts = tally(judged).counts;
    let time: f64 = judged.iter().map(|c| c.row.cpu_s).sum();
    let cases = if judged.len() == 1 { "1 case".to_owned() } else { format!("{} cases", judged.len()) };
    Verdict::new(counts.state(), format!("Of {cases} {}, in {} s of CPU time.", counts.words(), short(time, 3)))
}

fn samples(judged: &[Judged], folder: &Path) -> Result<(), ReportError> {
    let row = |s: SampleRow| {
        let factor = s.time_factor.map_or(String::new(), exact);
        let numbers = [s.computed, s.exact, s.error].map(exact);
        [vec![s.case, s.quantity, exact(s.time_s), factor], numbers.to_vec(), vec![s.unit, s.counts.to_string()]]
            .concat()
    };
    let rows = judged.iter().flat_map(Judged::sample_rows).map(row);
    tables::table(&folder.join("samples.csv"), SAMPLES, rows)
}

fn refinements(judged: &[Judged], folder: &Path) -> Result<(), ReportError> {
    let or_nothing = |value: Option<f64>| value.map_or(String::new(), exact);
    let row = |r: RefinementRow| {
        let order = [r.order, r.order_low, r.order_high].map(or_nothing);
        let asymptotic = r.asymptotic.map_or(String::new(), |a| a.to_string());
        let head = vec![r.case, r.by, exact(r.parameter), r.unit, exact(r.error)];
        [head, order.to_vec(), vec![asymptotic, r.required_order, r.against, r.order_verdict.word().to_owned()]]
            .concat()
    };
    let rows = judged.iter().flat_map(Judged::refinement_rows).map(row);
    tables::table(&folder.join("refinements.csv"), REFINEMENTS, rows)
}

/// Verdict, numbers and reason of every case.
fn cases(judged: &[Judged]) -> Table {
    let row = |c: &Judged| {
        vec![
            Cell::new(c.case.name).marked(c.case.about, "").linked(&format!("{}/index.html", c.case.name)),
            Cell::state(c.row.verdict),
            Cell::new(short(c.row.error, 3)),
            Cell::new(brief(c.row.required_error, 3)),
            order_cell(&c.convergence),
            Cell::new(c.row.required_order.clone()),
            baseline(c),
            Cell::new(c.row.integrator.clone()).marked(c.row.scheme.clone(), ""),
            Cell::new(short(c.row.cpu_s, 2)),
        ]
    };
    let head = ["case", "verdict", "error", "tolerance", "order", "theory", "baseline", "scheme", "CPU time (s)"];
    let note = format!(
        "Error at the smallest refinement parameter, or the largest of the last two where no order is established. {} Baseline: error \
         over the accepted one, which a case may not exceed by more than 2 %; verified against an exact solution, or a regression value \
         against this code itself or a band of published laws.",
        order_rule()
    );
    table("Verdicts".to_owned(), &head, judged.iter().map(row).collect(), &note)
}

/// Error over the accepted one, and what that is worth.
fn baseline(judged: &Judged) -> Cell {
    let kind = word(judged.row.baseline_kind);
    let grown = judged.sound && !judged.row.passed();
    match (judged.row.baseline, judged.row.change) {
        (None, _) => Cell::new("–").marked("none accepted", "warn"),
        (Some(_), Some(change)) => Cell::new(short(change, 3)).marked(&kind, if grown { "bad" } else { "" }),
        (Some(_), None) => Cell::new("was 0").marked(&kind, if grown { "bad" } else { "" }),
    }
}

/// The order of every refinement, with its verdict.
fn orders(judged: &[Judged]) -> Table {
    let row = |judged: &Judged, refinement: &Refinement| {
        let convergence = refinement.convergence();
        let (_, unit) = refinement.by;
        let ends = [refinement.errors.first(), refinement.errors.last()];
        let [first, last] = ends.map(|end| end.copied().unwrap_or((f64::NAN, f64::NAN)));
        let span = format!("{} to {}", brief(first.0, 3), brief(last.0, 3));
        let unit = if unit == "-" { String::new() } else { format!(" {unit}") };
        vec![
            Cell::new(judged.row.case.clone()).marked(format!("error relative to {}", refinement.against), ""),
            refinement.state().map_or_else(|| Cell::new("–"), Cell::state),
            Cell::new(refinement.by.0).marked(format!("{span}{unit}"), ""),
            Cell::new(refinement.errors.len().to_string()),
            Cell::new(format!("{} to {}", short(first.1, 2), short(last.1, 2))),
            order_cell(&convergence),
            Cell::new(convergence.theory_words()),
        ]
    };
    let of = |judged: &Judged| judged.all_refinements().iter().map(|r| row(judged, r)).collect::<Vec<_>>();
    let head = ["case", "verdict", "refined by", "runs", "error", "order", "theory"];
    let note = format!(
        "Errors from the first parameter to the last, signed. {} The order in particles is that in their spacing.",
        order_rule()
    );
    table("Refinements".to_owned(), &head, judged.iter().flat_map(of).collect(), &note)
}

/// What each check is shown to find.
fn mutants(judged: &[Judged]) -> Table {
    let row = |c: &Judged| vec![Cell::new(c.case.name), Cell::new(c.case.mutant.unwrap_or("–"))];
    let note = "The same check with this fault planted must fail: `mpm-verify check --mutants` runs them.";
    table("Mutants".to_owned(), &["case", "planted fault"], judged.iter().map(row).collect(), note)
}

/// Numbers beside the error.
fn further_numbers(judged: &[Judged]) -> Table {
    let row = |judged: &Judged, (quantity, value, unit): &(String, f64, String)| {
        vec![
            Cell::new(judged.case.name),
            Cell::new(quantity.clone()),
            Cell::new(short(*value, 4)),
            Cell::new(unit.clone()),
        ]
    };
    let rows = judged.iter().flat_map(|judged| judged.notes.iter().map(move |note| row(judged, note)));
    table("Further numbers".to_owned(), &["case", "quantity", "value", "unit"], rows.collect(), "Reported, not judged.")
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::cases::suite;

    /// Writes a small suite into a folder.
    pub fn write_small(folder: &Path) {
        let case = suite().iter().find(|case| case.name == "quasi-static-steps").expect("a case");
        let judged = case.judged().expect("runs that finish");
        std::fs::create_dir_all(folder).expect("a folder");
        write(&[judged], &Manifest::new(&crate::scenes::terzaghi(), 1), folder).expect("a page");
        std::fs::write(folder.join("cases.csv"), "").expect("a file");
    }

    #[test]
    fn every_case_has_its_files_and_its_verdict_on_the_page() {
        let judged = |name: &str| {
            let case = suite().iter().find(|case| case.name == name).expect("a case");
            case.judged().expect("runs that finish")
        };
        let (mut single, mut fallen) = (judged("quasi-static-steps"), judged("quasi-static-centre"));
        single.notes = vec![("stored over geometric water".to_owned(), 0.9995, "-".to_owned())];
        fallen.row.verdict = crate::verdict::State::Failed;
        let folder = tempfile::tempdir().expect("a folder");
        let manifest = Manifest::new(&crate::scenes::terzaghi(), 1);
        write(&[single, fallen], &manifest, folder.path()).expect("a page");
        let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect(name);
        assert!(read("quasi-static-steps/errors.csv").starts_with("mesh_m,error\n0.05,"));
        assert_eq!(read("quasi-static-centre/errors.csv").lines().count(), 6);
        assert!(read("quasi-static-centre/convergence.svg").contains("order 2.02"));
        assert!(read("quasi-static-steps/convergence.svg").contains("of the tolerance"));
        let own = read("quasi-static-centre/index.html");
        for part in [
            "<math",
            "class=\"sketch\"",
            "scene.toml",
            "fig-curves",
            "../index.html",
            "<td>MPa</td>",
            "Assumptions</h3>",
        ] {
            assert!(own.contains(part), "{part}");
        }
        // The problem comes first, then the exact solution, the result with its error, the orders.
        let sections = ["problem", "exact", "result", "convergence", "numbers", "again"];
        let places = sections.map(|id| own.find(&format!("<section id=\"{id}\">")).expect(id));
        assert!(places.is_sorted(), "{places:?}");
        assert_eq!(read("notes.csv"), format!("{NOTES}\nquasi-static-steps,stored over geometric water,0.9995,-\n"));
        let page = read("index.html");
        for part in [
            "Of 2 cases 1 passed, 1 failed",
            "warning\">quasi-static-centre: error 0.0009",
            "0.9995",
            "a thousand times stiffer",
        ] {
            assert!(page.contains(part), "{part}");
        }
        assert!(page.contains("within 0.5 of theory") && page.contains("a hundredth of the smallest tolerance"));
        assert!(read("samples.csv").starts_with(&format!("{SAMPLES}\nquasi-static-steps,U,")));
        let refined = read("refinements.csv");
        for by in ["quasi-static-steps,time step,0.0005,s,", "quasi-static-centre,mesh L,0.0125,m,", ",2,what the case"]
        {
            assert!(refined.contains(by), "{by}: {refined}");
        }
        assert!(!page.contains("scene hash") && page.contains("../index.html"));
    }
}

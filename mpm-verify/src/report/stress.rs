//! The page of the stress tests: a table of schemes and cases to read before choosing a scheme, a picture per case, and the
//! largest stable steps.

use std::path::Path;

use super::content::table::{Cell, Table, table};
use super::numbers::{brief, short};
use super::plots::figure::Figure;
use super::plots::{self, stress_test};
use super::{ReportError, save};
use crate::manifest::Manifest;
use crate::page::site::{Kind, Report};
use crate::page::verdict::{Checks, Counts, Tally};
use crate::page::{Page, Section};
use crate::stability::map::Summary;
use crate::stress::{Case, Found, Verdict};
use crate::study::word;

/// Writes the pictures of the cases into `plots` beside those of the map, `manifest.json` and `index.html`.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(
    (cases, found): (&[Case], &[Found]),
    (map, steps): (&[Figure], &[Summary]),
    manifest: &Manifest,
    folder: &Path,
) -> Result<(), ReportError> {
    let of = |(number, case): (usize, &Case)| {
        stress_test::figure(case, &found.iter().filter(|f| f.case == number).collect::<Vec<_>>())
    };
    let figures: Vec<Figure> = cases.iter().enumerate().map(of).collect();
    let pictures = folder.join("plots");
    for figure in &figures {
        plots::write(figure, &pictures)?;
    }
    let conditions = folder.join("manifest.json");
    let json = serde_json::to_string_pretty(manifest).map_err(|e| super::unwritable(&conditions, e))?;
    save(&conditions, json)?;
    let drawn = |section: Section, figures: &[Figure]| {
        figures.iter().fold(section, |section, figure| section.figure_in(figure, "plots", &["csv", "svg"]))
    };
    let (main, further) = figures.split_at(figures.len().min(1));
    let limits = Section::new("steps", "Largest stable time steps");
    // Single tests measure no steps.
    let measured = ["stability_map.csv", "stability.csv"].into_iter().filter(|_| !steps.is_empty());
    let limits = drawn(limits, map).tables([steps_table(steps)]).files(measured);
    let alt = main.first().map_or("", |figure| &figure.title);
    let picture = main.first().map_or_else(String::new, |figure| format!("plots/{}.svg", figure.name));
    let all = counts(found.iter().map(|f| f.judged.verdict)).words();
    let tally = Tally::new("Stress tests, default schemes", defaults(cases, found));
    Page::new("Stress tests and time-step limits")
        .verdict(verdict(cases, found))
        .lead(format!("All schemes, of which those that are no default are for comparison: {all}."))
        .warnings(broken_defaults(cases, found).into_iter().chain(degraded_defaults(cases, found)))
        .section(drawn(Section::new("first", "The first test"), main))
        .section(
            Section::new("matrix", "Verdicts by scheme")
                .tables(tables(cases, found))
                .files(["matrix.csv", "stress_tests.csv"]),
        )
        .section(limits)
        .section(drawn(Section::new("tests", "All tests").folded(), further))
        .section(Section::new("reasons", "Why runs stopped").folded().tables([stops(cases, found)]))
        .conditions(manifest)
        .report(Report::new(Kind::StressTests).counts([tally]).picture(picture, alt))
        .write(&folder.join("index.html"))
}

/// Schemes in stress tests, counted.
pub fn counts(verdicts: impl IntoIterator<Item = Verdict>) -> Counts {
    let mut counts = Checks::default();
    for verdict in verdicts {
        *match verdict {
            Verdict::Passed => &mut counts.passed,
            Verdict::Degraded => &mut counts.degraded,
            Verdict::Stopped => &mut counts.stopped,
            Verdict::Failed => &mut counts.failed,
        } += 1;
    }
    Counts::Checks(counts)
}

/// The schemes of scenes that name none: these are judged, all others are for comparison.
fn defaults(cases: &[Case], found: &[Found]) -> Counts {
    let own = found.iter().filter(|f| f.scheme.is_default(cases[f.case].dimension));
    counts(own.map(|f| f.judged.verdict))
}

fn verdict(cases: &[Case], found: &[Found]) -> crate::page::verdict::Verdict {
    let (own, tests) = (defaults(cases, found), cases.len());
    let tests = if tests == 1 { "1 stress test".to_owned() } else { format!("{tests} stress tests") };
    let sentence = format!("Default schemes in {tests}: {}.", own.words());
    crate::page::verdict::Verdict::new(own.state(), sentence)
}

/// What a scene gets without a word about its scheme must not break anywhere: one line for each that does.
pub fn broken_defaults(cases: &[Case], found: &[Found]) -> Vec<String> {
    defaults_that(Verdict::Failed, "fails with", cases, found)
}

/// A line for each default scheme that is worse than required within what it must bear.
pub fn degraded_defaults(cases: &[Case], found: &[Found]) -> Vec<String> {
    defaults_that(Verdict::Degraded, "is degraded to", cases, found)
}

fn defaults_that(verdict: Verdict, does: &str, cases: &[Case], found: &[Found]) -> Vec<String> {
    let those = |f: &&Found| f.judged.verdict == verdict && f.scheme.is_default(cases[f.case].dimension);
    let line = |f: &Found| {
        let case = &cases[f.case];
        let (name, integrator, most) = (case.name, word(f.scheme.integrator), brief(case.holds, 2));
        format!(
            "{name}: the default scheme of {integrator} {does} {} at {}; to pass, at most {most}",
            value(f),
            at(case, f)
        )
    };
    found.iter().filter(those).map(line).collect()
}

/// A table for every integrator: cases down, schemes across.
fn tables(cases: &[Case], found: &[Found]) -> Vec<Table> {
    let mut integrators: Vec<String> = Vec::new();
    for f in found {
        let name = word(f.scheme.integrator);
        if !integrators.contains(&name) {
            integrators.push(name);
        }
    }
    let both = integrators.iter().flat_map(|integrator| [false, true].map(|option| (integrator, option)));
    both.map(|(integrator, option)| of_integrator(integrator, option, cases, found))
        .filter(|t| !t.rows.is_empty())
        .collect()
}

/// The schemes of an integrator that carry velocities as usual, or with an option.
fn of_integrator(integrator: &str, option: bool, cases: &[Case], found: &[Found]) -> Table {
    let asked = |f: &&Found| word(f.scheme.integrator) == integrator && f.scheme.has_option() == option;
    let own: Vec<&Found> = found.iter().filter(asked).collect();
    let mut schemes: Vec<String> = Vec::new();
    for f in &own {
        if !schemes.contains(&f.scheme.name()) {
            schemes.push(f.scheme.name());
        }
    }
    let asked = |number: &usize| own.iter().any(|f| f.case == *number);
    let row = |number: usize| {
        let case = &cases[number];
        let cell = |scheme: &String| {
            let found = own.iter().find(|f| f.case == number && f.scheme.name() == *scheme);
            found.map_or_else(|| Cell::new(""), |f| cell_of(case, f))
        };
        let required = format!("{}; to pass up to {}", case.parameter, brief(case.holds, 2));
        std::iter::once(Cell::new(case.name).marked(required, "")).chain(schemes.iter().map(cell)).collect()
    };
    let head: Vec<&str> = std::iter::once("test").chain(schemes.iter().map(String::as_str)).collect();
    let rows = (0..cases.len()).filter(asked).map(row).collect();
    let note = "Small letters: the largest measured value; where a scheme fails or the program stops, the parameter there. \
                Default: the scheme of a scene that names none. Empty: not run.";
    let title = if option { format!("{integrator}, with another velocity update") } else { integrator.to_owned() };
    table(title, &head, rows, note)
}

fn cell_of(case: &Case, found: &Found) -> Cell {
    let default = found.scheme.is_default(case.dimension);
    let (word, small, mark) = match found.judged.verdict {
        Verdict::Passed => ("passed", value(found), "good"),
        Verdict::Degraded => ("degraded", format!("to {}", value(found)), "warn"),
        Verdict::Stopped => ("stopped", format!("at {}", short(found.judged.at, 2)), "warn"),
        Verdict::Failed => ("failed", format!("at {}", short(found.judged.at, 2)), "bad"),
    };
    let small = if default { format!("{small}\ndefault") } else { small };
    Cell::badge(word, mark).small(small)
}

fn value(found: &Found) -> String {
    found.judged.value.map_or_else(|| "–".to_owned(), |v| short(v, 2))
}

/// `300 cells crossed`, `k = 1e-11 m/s`.
fn at(case: &Case, found: &Found) -> String {
    let number = short(found.judged.at, 2);
    match case.parameter.split_once(" (") {
        Some((name, unit)) => {
            let unit = unit.trim_end_matches(')');
            let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
            format!("{name} = {number}{unit}")
        }
        None => format!("{number} ({})", case.parameter),
    }
}

/// What the program said where it stopped.
fn stops(cases: &[Case], found: &[Found]) -> Table {
    let row = |f: &Found| {
        let case = &cases[f.case];
        vec![
            Cell::new(case.name),
            Cell::new(word(f.scheme.integrator)).marked(f.scheme.name(), ""),
            Cell::new(at(case, f)),
            Cell::new(f.judged.reason.clone()),
        ]
    };
    let stopped = found.iter().filter(|f| f.judged.verdict == Verdict::Stopped);
    let head = ["test", "scheme", "stopped at", "reason"];
    table("Reasons of the runs that stopped".to_owned(), &head, stopped.map(row).collect(), "")
}

fn steps_table(steps: &[Summary]) -> Table {
    let row = |s: &Summary| {
        let range = |[low, high]: [f64; 2]| format!("{} to {}", short(low, 3), short(high, 3));
        vec![
            Cell::new(s.scheme.clone()).marked(format!("{}, {}", s.dimension, s.darcy), ""),
            Cell::new(s.rows.to_string()),
            Cell::new(range(s.ratio)),
            Cell::new(range(s.auto)),
        ]
    };
    let note = "Measured: the largest step at which a run does not grow, by bisection. Theory: a plane wave where it applies, \
                elsewhere the spectral radius of the assembled step. Automatic: the step of a scene that gives none.";
    let head = ["scheme", "rows", "measured / theory", "automatic / measured"];
    table("Measured limits".to_owned(), &head, steps.iter().map(row).collect(), note)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::verdict::State;
    use crate::stress::CASES;
    use crate::stress::case::Judged;

    /// What is found of a default scheme in the first test.
    fn found(value: f64, verdict: Verdict) -> Found {
        let case = &CASES[0];
        let scheme = *case.schemes.iter().find(|scheme| scheme.is_default(case.dimension)).expect("a default scheme");
        let judged = Judged { verdict, value: Some(value), at: 0.7, reason: String::new() };
        Found { case: 0, scheme, points: Vec::new(), judged }
    }

    #[test]
    fn a_default_scheme_that_degrades_is_amber_and_named() {
        let cases = &CASES[..1];
        let good = [found(1e-3, Verdict::Passed)];
        let degraded = [found(1e-3, Verdict::Passed), found(0.045, Verdict::Degraded)];
        assert_eq!(verdict(cases, &good).state, State::Passed);
        let amber = verdict(cases, &degraded);
        assert_eq!((amber.state.word().as_ref(), amber.state.mark()), ("degraded", "warn"));
        assert_eq!(amber.sentence, "Default schemes in 1 stress test: 1 passed, 1 degraded.");
        let lines = degraded_defaults(cases, &degraded);
        assert!(lines.len() == 1 && lines[0].contains("is degraded to 0.045 at"), "{lines:?}");
        assert_eq!((degraded_defaults(cases, &good), broken_defaults(cases, &degraded)), (Vec::new(), Vec::new()));
        let broken = [found(0.5, Verdict::Failed), found(0.045, Verdict::Degraded)];
        assert_eq!((verdict(cases, &broken).state, broken_defaults(cases, &broken).len()), (State::Failed, 1));
    }
}

//! Numbers of the published reports in the pages of the repository, so that none is typed: what stands between `<!-- stored: NAME -->`
//! and `<!-- -->` is made by the function of that name from the files of `reports/published`. `publish` writes it, a test compares.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::error::Error;
use crate::levee::{ensemble, probability, safety, validation};
use crate::page::site::{RECORD, Report};
use crate::page::table::Table;
use crate::progress::time;
use crate::provenance::Made;
use crate::report::numbers::{brief, percent};
use crate::stress::{MatrixRow, Verdict};
use crate::study::word;

/// Ahead of the name of a passage.
const OPEN: &str = "<!-- stored: ";
/// At the end of a passage.
const CLOSE: &str = "<!-- -->";
/// Wanted errors of the table of costs.
const WANTED: [(&str, f64); 4] = [("1 %", 0.01), ("0.3 %", 0.003), ("0.1 %", 0.001), ("0.02 %", 0.0002)];

/// A passage from the published files.
type Passage = fn(&Stored) -> Result<String, Error>;

/// All passages by their names. One that ends with a line break stands on lines of its own.
const PASSAGES: [(&str, Passage); 26] = [
    ("times", times),
    ("verdicts", verdicts),
    ("errors", |s| errors(s, &["0.1", "0.05", "0.02", "0.01"])),
    ("costs", |s| costs(s, false)),
    ("costs-beside-finite-volumes", |s| costs(s, true)),
    ("errors-of-the-paper", errors_of_the_paper),
    ("order-surface", |s| order(s, "explicit-centre-surface-ppc4", "max-compressible")),
    ("order-particles", |s| order(s, "explicit-centre-particles-ppc4", "max-compressible")),
    ("speed", speed),
    ("plane-solves", plane_solves),
    ("stress-tests", stress_tests),
    ("levee-events", levee_events),
    ("levee-e1", |s| s.fixed("levee/summary.json", "raveling_h", 1)),
    ("levee-e2", |s| s.fixed("levee/summary.json", "failure_start_h", 1)),
    ("levee-runout", |s| s.fixed("levee/summary.json", "runout_m", 1)),
    ("levee-medians", levee_medians),
    ("levee-samples", levee_samples),
    ("levee-safety", |s| Ok(markdown(&safety::shown(&s.lines("levee/safety_factor.csv")?)))),
    ("levee-ensemble", |s| Ok(markdown(&ensemble::shown(&s.lines("levee/ensemble.csv")?)))),
    ("levee-validation", levee_validation),
    ("levee-whole-samples", levee_whole_samples),
    ("levee-variants", levee_variants),
    ("levee-scene", levee_scene),
    ("levee-cases", |s| cases(s, &["slope-seepage", "mc-", "block-", "rest-", "outline-", "collapse-"])),
    ("slopes", slopes),
    ("water-cases", |s| {
        cases(s, &["front-", "dam-", "rain-grows", "evaporation", "wetted-box", "capillary-", "slope-rain"])
    }),
];

/// Published files, by their folder.
struct Stored(PathBuf);

/// A row of a table, by the names of its columns.
struct Row(HashMap<String, String>);

impl Row {
    fn text(&self, column: &str) -> Result<&str, Error> {
        self.0.get(column).map(String::as_str).ok_or_else(|| Error::Found(format!("no column {column}")))
    }

    fn number(&self, column: &str) -> Result<f64, Error> {
        let text = self.text(column)?;
        text.parse().map_err(|_| Error::Found(format!("{column}: no number: {text}")))
    }

    fn has(&self, wanted: &[(&str, &str)]) -> bool {
        wanted.iter().all(|(column, value)| self.0.get(*column).is_some_and(|text| text == value))
    }
}

impl Stored {
    fn lines<T: DeserializeOwned>(&self, file: &str) -> Result<Vec<T>, Error> {
        let path = self.0.join(file);
        let mut reader = csv::Reader::from_path(&path).map_err(Error::at(&path))?;
        reader.deserialize().collect::<Result<_, _>>().map_err(Error::at(&path))
    }

    fn rows(&self, file: &str) -> Result<Vec<Row>, Error> {
        Ok(self.lines::<HashMap<String, String>>(file)?.into_iter().map(Row).collect())
    }

    /// The only row with these values.
    fn row(&self, file: &str, wanted: &[(&str, &str)]) -> Result<Row, Error> {
        let mut rows = self.rows(file)?;
        rows.retain(|row| row.has(wanted));
        match rows.len() {
            1 => Ok(rows.remove(0)),
            n => Err(Error::Found(format!("{file}: {n} rows with {wanted:?}"))),
        }
    }

    fn json(&self, file: &str) -> Result<Value, Error> {
        let path = self.0.join(file);
        let text = fs::read_to_string(&path).map_err(Error::at(&path))?;
        serde_json::from_str(&text).map_err(Error::at(&path))
    }

    /// A number with so many decimals.
    fn fixed(&self, file: &str, key: &str, decimals: usize) -> Result<String, Error> {
        let number = self.json(file)?[key].as_f64().ok_or_else(|| Error::Found(format!("{file}: no number {key}")))?;
        Ok(format!("{number:.decimals$}"))
    }

    /// Number of verdicts of a report, and its first counts in words.
    fn report(&self, name: &str) -> Result<(usize, String), Error> {
        let path = self.0.join(name).join(RECORD);
        let text = fs::read_to_string(&path).map_err(Error::at(&path))?;
        let report: Report = serde_json::from_str(&text).map_err(Error::at(&path))?;
        let tally = report.counts.first().ok_or_else(|| Error::Found("no counts".to_owned()).of(name))?;
        Ok((tally.counts.total(), tally.counts.words()))
    }
}

/// A page with its passages as the published files have them.
///
/// # Errors
/// A passage that is not known or does not end, a file that is missing, a number that is not in it.
pub fn filled(page: &str, published: &Path) -> Result<String, Error> {
    let stored = Stored(published.to_owned());
    let (mut out, mut rest) = (String::new(), page);
    while let Some((before, after)) = rest.split_once(OPEN) {
        let parts = after.split_once(" -->").and_then(|(name, after)| Some((name, after.split_once(CLOSE)?.1)));
        let (name, after) = parts.ok_or_else(|| Error::Found(format!("no end: {OPEN}{after:.40}")))?;
        let passage = PASSAGES.iter().find(|(known, _)| *known == name);
        let (_, passage) = passage.ok_or_else(|| Error::Found(format!("no such passage: {name}")))?;
        let text = passage(&stored).map_err(|e| e.of(name))?;
        let line = if text.ends_with('\n') { "\n" } else { "" };
        out += &format!("{before}{OPEN}{name} -->{line}{text}{CLOSE}");
        rest = after;
    }
    Ok(out + rest)
}

/// Pages of the repository that have passages, by their paths from its root.
pub fn pages() -> Vec<String> {
    let chapters = super::CHAPTERS.iter().map(|chapter| format!("mpm-verify/docs/{}.md", chapter.name));
    ["README.md", "reference-data/scenes/README.md"].map(str::to_owned).into_iter().chain(chapters).collect()
}

/// Rows of a table in Markdown.
fn table(head: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let line = |cells: &[String]| {
        let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
        format!("| {} |\n", cells.join(" | "))
    };
    let head: Vec<String> = head.iter().map(|cell| (*cell).to_owned()).collect();
    let rows: String = rows.into_iter().map(|row| line(&row)).collect();
    format!("{}|{}\n{rows}", line(&head), "---|".repeat(head.len()))
}

/// A table of a page, in Markdown, with what is in small letters in brackets.
fn markdown(shown: &Table) -> String {
    let head: Vec<&str> = shown.head.iter().map(String::as_str).collect();
    let rows = shown.rows.iter().map(|row| {
        let cell = |cell: &crate::page::table::Cell| match cell.small.as_str() {
            "" => cell.text.clone(),
            small => format!("{} ({small})", cell.text),
        };
        row.iter().map(cell).collect()
    });
    table(&head, rows)
}

/// A CPU time with two digits.
fn cpu(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s < 1e-3 => (1e6 * s, "µs"),
        s if s < 1.0 => (1e3 * s, "ms"),
        s => (s, "s"),
    };
    let rounded: f64 = format!("{value:.1e}").parse().unwrap_or(value);
    format!("{rounded:.*} {unit}", usize::from(rounded < 10.0))
}

fn times(stored: &Stored) -> Result<String, Error> {
    let row = |(command, result): (&str, &str)| {
        let row =
            stored.row("prove/prove.csv", &[("command", &format!("mpm-verify {command}")), ("passed", "true")])?;
        Ok(vec![format!("`cargo run --release -- {command}`"), time(row.number("wall_s")?), result.to_owned()])
    };
    let rows = [
        ("study", "accuracy study on the paper's Table 1: `reports/index.html`"),
        ("levee", "`reports/levee/index.html`"),
    ];
    let rows = rows.map(row).into_iter().collect::<Result<Vec<_>, Error>>()?;
    Ok(table(&["command", "time ([measured](reports/published/prove/prove.csv))", "result"], rows))
}

fn verdicts(stored: &Stored) -> Result<String, Error> {
    let (claims, reproduced) = stored.report("accuracy")?;
    let (cases, judged) = stored.report("suite")?;
    let (_, stress) = stored.report("stability")?;
    let (levee_claims, levee) = stored.report("levee")?;
    let board = stored.rows("leaderboard/leaderboard.csv")?;
    let mut codes: Vec<&str> = board.iter().map(|row| row.text("code")).collect::<Result<_, _>>()?;
    codes.sort_unstable();
    codes.dedup();
    let row = |what: &str, checked: String, result: String, page: &str| {
        vec![what.to_owned(), checked, result, page.to_owned()]
    };
    let verdicts = table(
        &["what", "checked", "result", "page"],
        [
            row(
                "claims of the paper, consolidation",
                format!("{claims} claims by rules"),
                reproduced,
                "[report](reports/published/accuracy/report.md)",
            ),
            row(
                "verification suite",
                format!("{cases} cases against exact solutions and published values"),
                judged,
                "[cases](reports/published/suite/cases.csv)",
            ),
            row(
                "stress tests",
                "every integrator's default scheme".to_owned(),
                stress,
                "[table](mpm-verify/docs/integrators.md#stress-tests)",
            ),
            row(
                "levee, claims of paper and experiment",
                format!("{levee_claims} claims by rules"),
                levee,
                "[chapter](mpm-verify/docs/levee.md)",
            ),
            row(
                "leaderboard",
                format!("{} codes on neutral cases", codes.len()),
                "[scores](reports/published/leaderboard/leaderboard.csv)".to_owned(),
                "[how](mpm-verify/docs/own-code.md)",
            ),
        ],
    );
    Ok(verdicts + &made(stored)?)
}

/// Settings of the table of errors: words, integrator, scheme, particles per cell.
const SETTINGS: [(&str, &str, &str, &str); 4] = [
    ("explicit, `centre`, 4 (the paper)", "explicit", "centre", "4"),
    ("semi-implicit, `centre`, 4", "semi-implicit", "centre", "4"),
    ("quasi-static, `centre`, 9", "quasi-static", "centre", "9"),
    ("quasi-static, `bspline2`, fitted weights, 9", "quasi-static", "bspline2", "9"),
];

/// A case of the study with the traction on the free surface, or on the boundary particles.
fn case(stored: &Stored, of: (&str, &str, &str), load: &str, mesh: &str) -> Result<Row, Error> {
    let (integrator, scheme, ppc) = of;
    let wanted = [("integrator", integrator), ("scheme", scheme), ("load", load), ("ppc", ppc), ("mesh_m", mesh)];
    stored.row("accuracy/errors.csv", &wanted)
}

fn errors(stored: &Stored, meshes: &[&str]) -> Result<String, Error> {
    let row = |(words, integrator, scheme, ppc): (&str, &str, &str, &str)| {
        let error = |mesh: &&str| {
            Ok(format!(
                "{:.1e}",
                case(stored, (integrator, scheme, ppc), "surface", mesh)?.number("max_error_compressible")?
            ))
        };
        let errors = meshes.iter().map(error).collect::<Result<Vec<_>, Error>>()?;
        Ok([vec![words.to_owned()], errors].concat())
    };
    let rows = SETTINGS.map(row).into_iter().collect::<Result<Vec<_>, Error>>()?;
    let names: Vec<String> = meshes.iter().map(|mesh| format!("L = {mesh} m")).collect();
    let head =
        std::iter::once("integrator, shape functions, particles per cell").chain(names.iter().map(String::as_str));
    Ok(table(&head.collect::<Vec<_>>(), rows))
}

/// The cheapest setting of each integrator for the wanted errors.
fn costs(stored: &Stored, finite_volumes: bool) -> Result<String, Error> {
    // The README, which has no finite volumes beside it, leaves one out.
    let wanted: Vec<(&str, f64)> = WANTED.into_iter().filter(|(_, e)| finite_volumes || *e != 0.003).collect();
    let all = stored.rows("speed-against-error/cheapest.csv")?;
    let of = |integrator: &str, wanted: f64| {
        let is = |row: &&Row| {
            row.has(&[("integrator", integrator)]) && row.number("wanted_error").is_ok_and(|e| e == wanted)
        };
        all.iter().find(is)
    };
    let row = |integrator: &str| {
        let cell = |(_, wanted): &(&str, f64)| match of(integrator, *wanted) {
            Some(row) => Ok(format!(
                "{} (`{}`, {} m, {})",
                cpu(row.number("cpu_s")?),
                row.text("scheme")?,
                row.text("mesh_m")?,
                row.text("ppc")?
            )),
            None => Ok("not reached".to_owned()),
        };
        let cells = wanted.iter().map(cell).collect::<Result<Vec<_>, Error>>()?;
        Ok([vec![integrator.to_owned()], cells].concat())
    };
    let mut rows =
        ["explicit", "semi-implicit", "quasi-static"].map(row).into_iter().collect::<Result<Vec<_>, Error>>()?;
    if finite_volumes {
        for (words, column) in [("plain finite volumes", "baseline_cpu_s"), ("graded finite volumes", "graded_cpu_s")] {
            let cell = |(_, wanted): &(&str, f64)| {
                let row = of("quasi-static", *wanted).ok_or(Error::Lacks("row of that error"))?;
                row.number(column).map(|s| if s.is_finite() { cpu(s) } else { "not reached".to_owned() })
            };
            rows.push([vec![words.to_owned()], wanted.iter().map(cell).collect::<Result<Vec<_>, Error>>()?].concat());
        }
    }
    let head: Vec<&str> = std::iter::once("").chain(wanted.iter().map(|(words, _)| *words)).collect();
    Ok(table(&head, rows))
}

fn errors_of_the_paper(stored: &Stored) -> Result<String, Error> {
    let row = |mesh: &str| {
        let cell = |load: &str, particles: &[&str], column: &str| {
            let percent = |ppc: &&str| {
                let error = case(stored, ("explicit", "centre", ppc), load, mesh)?.number(column)?;
                Ok(percent(error))
            };
            particles.iter().map(percent).collect::<Result<Vec<_>, Error>>().map(|cells| cells.join(" / "))
        };
        let all = ["1", "4", "9"];
        Ok(vec![
            mesh.to_owned(),
            cell("particles", &all, "max_error_terzaghi")?,
            cell("particles", &all, "max_error_compressible")?,
            cell("surface", &["4"], "max_error_terzaghi")?,
            cell("surface", &["4"], "max_error_compressible")?,
        ])
    };
    let meshes = ["0.1", "0.05", "0.025", "0.02", "0.0125", "0.01"];
    let head = [
        "L (m)",
        "traction on the boundary particles, Terzaghi",
        "the same, compressible",
        "traction on the free surface, 4 per cell, Terzaghi",
        "the same, compressible",
    ];
    Ok(table(&head, meshes.map(row).into_iter().collect::<Result<Vec<_>, Error>>()?))
}

fn order(stored: &Stored, group: &str, norm: &str) -> Result<String, Error> {
    let row = stored.row("accuracy/orders.csv", &[("group", group), ("norm", norm)])?;
    Ok(format!("{:.2} ± {:.2}", row.number("order")?, row.number("half_width_95")?))
}

fn speed(stored: &Stored) -> Result<String, Error> {
    let limits = "speed-against-error/kernel_limits.csv";
    let at = |points: &str| {
        let row = stored.row(limits, &[("points", points), ("kernel", "with water")])?;
        Ok::<_, Error>(format!(
            "{:.1} ns at {points} points, {:.1} times",
            row.number("measured_ns")?,
            row.number("times_the_limit")?
        ))
    };
    Ok(format!("{} what the machine's arithmetic and memory allow, and {}", at("1000")?, at("1000000")?))
}

fn plane_solves(stored: &Stored) -> Result<String, Error> {
    let rows = stored.rows("speed-against-error/plane_solves.csv")?;
    let [first, .., last] = &rows[..] else { return Err(Error::Lacks("solves in plane strain")) };
    let said = |row: &Row| {
        let side = row.text("cells_per_side")?;
        Ok::<_, Error>(format!(
            "{} on {side} x {side} cells ({} unknowns)",
            cpu(row.number("cpu_s")?),
            row.text("unknowns")?
        ))
    };
    let power = (last.number("cpu_s")? / first.number("cpu_s")?).ln()
        / (last.number("unknowns")? / first.number("unknowns")?).ln();
    Ok(format!("{} and {}; its cost grows with the power {power:.1} of the unknowns", said(first)?, said(last)?))
}

fn stress_tests(stored: &Stored) -> Result<String, Error> {
    let all: Vec<MatrixRow> = stored.lines("stability/matrix.csv")?;
    let mut tests: Vec<&str> = all.iter().map(|row| row.case.as_str()).collect();
    tests.dedup();
    let integrators = ["explicit", "semi-implicit", "quasi-static"];
    let row = |test: &str| {
        let cell = |integrator: &str| {
            let own: Vec<_> = all.iter().filter(|row| row.case == test && row.integrator == integrator).collect();
            let default = own.iter().filter(|row| row.default).map(|row| {
                let value = row.value.map_or_else(String::new, |value| format!(" ({})", brief(value, 2)));
                format!("**{}** {}{value}", row.scheme, word(row.verdict))
            });
            let failed: Vec<&str> =
                own.iter().filter(|row| row.verdict == Verdict::Failed).map(|row| row.scheme.as_str()).collect();
            let others = (!failed.is_empty()).then(|| format!("failed: {}", failed.join(", ")));
            default.chain(others).collect::<Vec<_>>().join("; ")
        };
        std::iter::once(format!("`{test}`")).chain(integrators.map(cell)).collect()
    };
    Ok(table(&[&["test"], &integrators[..]].concat(), tests.into_iter().map(row)))
}

/// The program that made the verdicts: its commit and the hash of its sources, or those of all that did.
fn made(stored: &Stored) -> Result<String, Error> {
    let mut all = Vec::new();
    for file in ["accuracy/manifest.json", "suite/manifest.json", "stability/manifest.json"] {
        all.push(serde_json::from_value::<Made>(stored.json(file)?).map_err(Error::at(stored.0.join(file)))?);
    }
    let levee = "levee/summary.json";
    let own = stored.json(levee)?["manifest"].take();
    all.push(serde_json::from_value(own).map_err(Error::at(stored.0.join(levee)))?);
    let mut said: Vec<String> =
        all.iter().map(|made| format!("`{}` (sources `{}`)", made.commit, made.sources)).collect();
    said.sort_unstable();
    said.dedup();
    Ok(format!("\nOf commit {}.\n", said.join(", ")))
}

fn levee_events(stored: &Stored) -> Result<String, Error> {
    let file = "levee/summary.json";
    let summary = stored.json(file)?;
    let number = |key: &str| summary[key].as_f64().ok_or_else(|| Error::Found(format!("{file}: no number {key}")));
    let rows = [
        ("water leaves the slope", "", "", format!("by {:.1} h", number("first_outflow_h")?)),
        ("E1, the toe ravels", "", "12.5 h", format!("{:.1} h", number("raveling_h")?)),
        ("E2, failure starts", "8.66 h", "13.0 h", format!("{:.1} h", number("failure_start_h")?)),
        ("E3, rapid failure", "", "13.2 h", format!("{:.1} h", number("rapid_failure_h")?)),
        ("at rest", "8.68 h", "30 s after E3", format!("{:.0} s after E3", number("rapid_failure_lasts_s")?)),
        ("run-out of the toe", "", "", format!("{:.1} m", number("runout_m")?)),
        ("settlement of the crest", "", "", format!("{:.2} m", number("crest_settlement_m")?)),
        (
            "balance residuals: dry mass, water, energy",
            "",
            "",
            format!(
                "{:.0e}, {:.0e}, {:.1} %",
                number("solid_mass_error")?,
                number("water_ledger_error")?,
                100.0 * number("energy_error")?
            ),
        ),
    ];
    Ok(table(
        &["", "paper", "experiment", "`levee`"],
        rows.map(|(what, paper, seen, own)| vec![what.to_owned(), paper.to_owned(), seen.to_owned(), own]),
    ))
}

/// Medians of E2 and of the run-out on the meshes of the ensemble.
fn levee_medians(stored: &Stored) -> Result<String, Error> {
    let lines: Vec<ensemble::Line> = stored.lines("levee/ensemble.csv")?;
    let cells = ensemble::cells(&lines);
    let medians = |of: fn(&ensemble::Line) -> Option<f64>| {
        let found = cells.iter().map(|cell| ensemble::spread(&lines, *cell, of).map(|s| format!("{:.1}", s.median)));
        found.collect::<Option<Vec<_>>>().map(|all| all.join(", ")).ok_or(Error::Lacks("medians"))
    };
    let meshes = cells.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    Ok(format!(
        "on {meshes} m medians of equal runs fail at {} h and run out {} m",
        medians(|l| l.failure_h)?,
        medians(|l| l.runout_m)?
    ))
}

/// Times between which nine of ten samples fail.
fn levee_samples(stored: &Stored) -> Result<String, Error> {
    let lines: Vec<probability::Line> = stored.lines("levee/probability.csv")?;
    let at = |share| probability::quantile(&lines, share).ok_or(Error::Lacks("samples that fail"));
    Ok(format!("{:.1} to {:.1} h", at(0.05)?, at(0.95)?))
}

/// Critical factor by the samples that were run whole.
fn levee_whole_samples(stored: &Stored) -> Result<String, Error> {
    let lines: Vec<probability::Line> = stored.lines("levee/probability.csv")?;
    let mut factors: Vec<f64> = lines.iter().filter_map(|line| line.run_factor).collect();
    factors.sort_by(f64::total_cmp);
    let [low, .., high] = factors[..] else { return Err(Error::Lacks("samples that were run whole")) };
    Ok(format!("{low:.3} to {high:.3} in {} of {}", factors.len(), lines.len()))
}

fn levee_variants(stored: &Stored) -> Result<String, Error> {
    let row = |variant: &str| {
        let row = stored.row("levee/sensitivity.csv", &[("variant", variant)])?;
        let fixed = |column: &str, decimals: usize| Ok::<_, Error>(format!("{:.decimals$}", row.number(column)?));
        Ok(vec![format!("`{variant}`"), fixed("raveling_h", 1)?, fixed("crest_settlement_m", 2)?])
    };
    let rows = ["base", "suction", "rain", "drawdown"].map(row).into_iter().collect::<Result<Vec<_>, Error>>()?;
    Ok(table(&["variant", "E1 (h)", "crest (m)"], rows))
}

fn levee_scene(stored: &Stored) -> Result<String, Error> {
    let number = |key: &str| stored.fixed("levee/summary.json", key, 2);
    Ok(format!(
        "water leaves at {} h, E1, E2 and E3 at {}, {} and {} h, run-out to x = {} m",
        number("first_outflow_h")?,
        number("raveling_h")?,
        number("failure_start_h")?,
        number("rapid_failure_h")?,
        number("toe_x_m")?
    ))
}

fn levee_validation(stored: &Stored) -> Result<String, Error> {
    let (runs, samples) = (stored.lines("levee/ensemble.csv")?, stored.lines("levee/probability.csv")?);
    validation::shown(&runs, &samples).map(|shown| markdown(&shown)).ok_or(Error::Lacks("runs on two meshes"))
}

fn slopes(stored: &Stored) -> Result<String, Error> {
    let rows = stored.rows("slopes/slopes.csv")?;
    let missed: Vec<&Row> = rows.iter().filter(|row| row.text("trouble").is_ok_and(|text| !text.is_empty())).collect();
    let said = missed.iter().map(|row| Ok(format!("{}: {}", row.text("name")?, row.text("trouble")?)));
    let said = said.collect::<Result<Vec<_>, Error>>()?;
    let said = if said.is_empty() { String::new() } else { format!(" Not met: {}.", said.join("; ")) };
    Ok(format!("{} of {} meet all of it.{said}", rows.len() - missed.len(), rows.len()))
}

/// Cases of the suite whose name begins with one of some words.
fn cases(stored: &Stored, starts: &[&str]) -> Result<String, Error> {
    let rows = stored.rows("suite/cases.csv")?;
    let own =
        rows.iter().filter(|row| row.text("case").is_ok_and(|case| starts.iter().any(|start| case.starts_with(start))));
    let line = |row: &Row| {
        let order = row.number("order").map_or_else(|_| String::new(), |order| format!("{order:.2}"));
        Ok(vec![
            format!("`{}`", row.text("case")?),
            brief(row.number("error")?, 2),
            brief(row.number("required_error")?, 2),
            order,
            row.text("verdict")?.to_owned(),
        ])
    };
    let lines = own.map(line).collect::<Result<Vec<_>, Error>>()?;
    Ok(table(&["case", "error", "tolerance", "order", "verdict"], lines))
}

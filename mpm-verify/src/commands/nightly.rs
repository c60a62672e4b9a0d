//! `nightly`: everything is run, compared with the accepted baselines and recorded.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use cpu_time::ProcessTime;
use mpm_verify::cases::suite;
use mpm_verify::error::Error;
use mpm_verify::experiment::accepted::{self, Accepted, Renewed};
use mpm_verify::experiment::number::{Label, Number, Tolerance};
use mpm_verify::files::Folder;
use mpm_verify::levee::limits;
use mpm_verify::manifest::Manifest;
use mpm_verify::nightly::compiled::counted;
use mpm_verify::nightly::history::{self, ENTRY, History};
use mpm_verify::nightly::report::{Night, Part, VALUES, stored};
use mpm_verify::nightly::{collect, moved, nights, report, trends, work};
use mpm_verify::progress::Progress;
use mpm_verify::provenance;
use mpm_verify::study::Runner;
use mpm_verify::unpanicked::unpanicked;

use super::{Failure, check, levee, make_folder, metamorphic, stability, study, write_file};
use crate::Common;

/// The parts of a nightly run.
const PARTS: [&str; 6] = ["study", "suite", "stability", "levee", "metamorphic", "work"];
/// Number of random scenes, and their seed.
const SCENES: u64 = 2000;
const SEED: u64 = 1;

/// Options of a nightly run.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Accept the measured numbers as baselines, for this reason
    #[arg(long, value_name = "WHY")]
    accept: Option<String>,
    /// With --accept: the numbers of this nightly run, without running anything
    #[arg(long, value_name = "DIR", requires = "accept")]
    from: Option<PathBuf>,
    /// With --from: only numbers whose case or quantity has this in its name
    #[arg(long, value_name = "TEXT", requires = "from")]
    of: Option<String>,
    /// Folder of the baselines [default: reference-data/baselines]
    #[arg(long, value_name = "DIR", hide = true)]
    baselines: Option<PathBuf>,
    /// Do not count instructions, even where callgrind is installed
    #[arg(long, hide = true)]
    no_instructions: bool,
    /// Also the schemes that are no default in the stress tests
    #[arg(long)]
    all: bool,
    /// Only these parts, without recording them
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',', value_parser = PARTS)]
    only: Vec<String>,
}

/// Runs everything; or renews the baselines from an earlier run.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    let (known, file) = accepted::read(options.baselines.as_deref()).map_err(Failure::bad_input)?;
    accepted::hold_against(&known);
    let earlier = options.from.as_deref().map(earlier).transpose()?;
    let commit = || match &earlier {
        Some((night, _)) => night.commit.as_str(),
        None => provenance::commit(),
    };
    let target = options.accept.as_deref().map(|why| Ok((why, accepted::target(why, commit(), file.as_deref())?)));
    let target = target.transpose().map_err(Failure::bad_input::<Error>)?;
    if let (Some(target), Some((night, measures))) = (target, &earlier) {
        let of = options.of.as_deref();
        let is_meant = |m: &&Number| of.is_none_or(|of| format!("{} {}", m.case, m.quantity).contains(of));
        let measures: Vec<Number> = measures.iter().filter(is_meant).cloned().collect();
        return accept(&known, (&measures, of.is_none(), options.all), night, target, common);
    }
    let (night, measures, folder) = common.publish("nightly", &["index.html", history::NAME], |folder| {
        whole(options, common, (&known, file.as_deref()), folder)
    })?;
    common.json(&night);
    common.say(&night.markdown());
    common.page(&folder.join("index.html"));
    if let Some(target) = target {
        return accept(&known, (&measures, true, options.all), &night, target, common);
    }
    if night.is_green() {
        return Ok(());
    }
    let mut lines = vec![night.headline()];
    lines.extend(night.fell.iter().map(|what| format!("failed: {what}")));
    lines.extend(night.moved.iter().map(moved::Moved::line));
    Err(Failure::CheckFailed(lines.join("\n")))
}

/// An earlier nightly run and its numbers.
fn earlier(folder: &Path) -> Result<(Night, Vec<Number>), Failure> {
    let refused = |e: &dyn Display| Failure::BadInput(format!("{}: {e}", folder.display()));
    let measures = stored(&folder.join(VALUES)).map_err(Failure::bad_input)?;
    let text = fs::read(folder.join("summary.json")).map_err(|e| refused(&e))?;
    Ok((serde_json::from_slice(&text).map_err(|e| refused(&e))?, measures))
}

/// Results of the parts so far.
struct Findings<'a> {
    common: &'a Common,
    folder: &'a Path,
    only: &'a [String],
    all: bool,
    measures: Vec<Number>,
    fell: Vec<String>,
    parts: Vec<Part>,
    notes: Vec<String>,
}

impl Findings<'_> {
    /// Runs a part; an error in it is recorded and stops no other part.
    fn part(&mut self, name: &str, work: impl FnOnce(&mut Self) -> Result<String, Failure>) {
        if !self.only.is_empty() && !self.only.iter().any(|only| only == name) {
            return;
        }
        let (cpu, wall) = (ProcessTime::now(), Instant::now());
        self.common.say(&format!("{name} ..."));
        let done = unpanicked(|| work(self)).map_err(Failure::run_failed).flatten();
        let line = done.unwrap_or_else(|why| {
            self.fell.push(format!("{name}: {why}"));
            "could not be finished".to_owned()
        });
        let (cpu_s, wall_s) = (cpu.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64());
        self.common.say(&format!("{name}: {line}, {wall_s:.0} s"));
        self.parts.push(Part { name: name.to_owned(), line, cpu_s, wall_s });
    }

    fn study(&mut self) -> Result<String, Failure> {
        let progress = Progress::new("accuracy study", true);
        let mut runner = Runner::whole(self.common.jobs(), &progress);
        let study = study::complete(&study::Options::paper(), self.common, &mut runner, &String::new)?;
        let folder = self.folder.join("accuracy");
        make_folder(&folder)?;
        mpm_verify::report::write(&study, &folder).map_err(Failure::run_failed)?;
        self.measures.extend(collect::study(&study.results, &study.sweeps));
        let (limits, fallen) = study.sweeps.limits();
        let failed: Vec<&str> = study.results.iter().filter(|r| r.failure.is_some()).map(|r| r.case.as_str()).collect();
        self.fell.extend(failed.iter().map(|case| format!("study: {case} failed")));
        if fallen > 0 {
            self.fell.push(format!("study: {fallen} of {limits} limits of the sweeps failed"));
        }
        Ok(format!(
            "{} cases, {} failed; {fallen} of {limits} limits of the sweeps failed",
            study.results.len(),
            failed.len()
        ))
    }

    fn suite(&mut self) -> Result<String, Failure> {
        let common = Common { quiet: true, ..self.common.clone() };
        let folder = self.folder.join("suite");
        let ran = check::judged(&suite().iter().collect::<Vec<_>>(), &common, &folder)?;
        self.fell.extend(ran.failed.iter().map(|message| format!("suite: {message}")));
        let fallen: Vec<String> =
            ran.rows.iter().filter(|s| !s.passed()).map(|s| format!("suite: {}: {}", s.case, s.reason)).collect();
        let all = ran.rows.len() + ran.failed.len();
        let line = format!("{} of {all} cases passed", ran.rows.len() - fallen.len());
        self.fell.extend(fallen);
        self.measures.extend(accepted::numbers(&ran.rows));
        Ok(line)
    }

    fn stability(&mut self) -> Result<String, Failure> {
        let common = Common { quiet: true, ..self.common.clone() };
        let options = stability::Options::of_a_night(self.all);
        let found = stability::measure(&options, &common, &self.folder.join("stability"))?;
        if let Err(failure) = stability::verdict(&found) {
            self.fell.push(failure.to_string());
        }
        self.measures.extend(collect::stability(found.matrix(), found.summaries()));
        Ok(format!(
            "{} schemes in stress tests, {} groups of time-step limits",
            found.matrix().len(),
            found.summaries().len()
        ))
    }

    fn levee(&mut self) -> Result<String, Failure> {
        let summary = levee::night(&self.folder.join("levee"))?;
        let kept = limits::of(&summary);
        let fallen: Vec<String> = kept.iter().filter(|l| !l.passed()).map(|l| format!("levee: {}", l.said())).collect();
        let line = format!(
            "{} of {} limits passed, failure at {:.3} h",
            kept.len() - fallen.len(),
            kept.len(),
            summary.failure_start_h.unwrap_or(f64::NAN)
        );
        self.fell.extend(fallen);
        if let Some(how) = limits::unfinished(&summary.ended, summary.trouble.as_deref()) {
            self.fell.push(format!("levee: {how}"));
        }
        self.measures.extend(collect::levee(&summary));
        Ok(line)
    }

    /// The same scenes in every run, so that only a change of the program can make it fail.
    fn metamorphic(&mut self) -> Result<String, Failure> {
        let common = Common { quiet: true, json: false, ..self.common.clone() };
        let indices: Vec<u64> = (0..SCENES).collect();
        let found = metamorphic::measure((SEED, &indices, None), &common, &self.folder.join("metamorphic"))?;
        let failures =
            found.failures.iter().map(|f| format!("metamorphic: {} of seed {SEED}: {}", f.name(), f.found[1]));
        self.fell.extend(failures);
        Ok(format!("{} scenes of seed {SEED}, {} relations failed", found.scenes, found.failures.len()))
    }

    fn work(&mut self, instructions: bool) -> Result<String, Failure> {
        let program = std::env::current_exe().ok().filter(|_| instructions);
        let work::Counted { measures, notes, fell } = work::counts(program.as_deref());
        let all = work::GATES.len();
        let line = format!("{} counts of {} of {all} gates", measures.len(), all - fell.len());
        self.measures.extend(measures);
        self.notes.extend(notes);
        self.fell.extend(fell.iter().map(|what| format!("work: {what}")));
        Ok(line)
    }
}

/// Runs all parts, compares and records them. Returns the folder of this run, too.
fn whole(
    options: &Options,
    common: &Common,
    (known, file): (&[Accepted], Option<&Path>),
    folder: &Folder,
) -> Result<(Night, Vec<Number>, PathBuf), Failure> {
    let (cpu, wall) = (ProcessTime::now(), Instant::now());
    let manifest = Manifest::new(&mpm_verify::scenes::terzaghi(), common.jobs());
    let day = manifest.date.split('T').next().unwrap_or_default().to_owned();
    let name = (1..).map(|n| if n == 1 { day.clone() } else { format!("{day}-{n}") });
    let name = name.into_iter().find(|name| !folder.path().join(name).exists()).unwrap_or(day);
    let own = folder.stage().join(&name);
    make_folder(&own)?;
    let history_path = folder.path().join(history::NAME);
    let mut history = History::read(&history_path).map_err(Failure::bad_input)?;
    let mut found = Findings {
        common,
        folder: &own,
        only: &options.only,
        all: options.all,
        measures: Vec::new(),
        fell: Vec::new(),
        parts: Vec::new(),
        notes: Vec::new(),
    };
    found.part("study", Findings::study);
    found.part("suite", Findings::suite);
    found.part("stability", Findings::stability);
    found.part("levee", Findings::levee);
    found.part("metamorphic", Findings::metamorphic);
    found.part("work", |found| found.work(!options.no_instructions));
    let Findings { mut measures, fell, parts, mut notes, .. } = found;
    let entry = format!("{} {}", manifest.date, manifest.commit);
    let known = comparable(known, &measures, options, &mut notes);
    let moved = moved::moved(&known, &measures, &history, &entry);
    if file.is_none() {
        notes.push("The accepted numbers are those built into the program.".to_owned());
    }
    let is_known = |m: &Number| known.iter().any(|row| m.is_of(&row.case, &row.quantity));
    let judged = measures.iter().filter(|m| m.label != Label::Time && (counted(&m.quantity).is_none() || is_known(m)));
    let mut night = Night {
        verdict: String::new(),
        compared: judged.clone().count(),
        counts: judged.filter(|m| m.label == Label::Count).count(),
        moved,
        fell,
        cpu_s: cpu.elapsed().as_secs_f64(),
        wall_s: wall.elapsed().as_secs_f64(),
        date: manifest.date.clone(),
        commit: manifest.commit.clone(),
        baselines: file.map_or_else(|| "built in".to_owned(), |file| file.display().to_string()),
        parts,
        notes,
        manifest,
    };
    (if night.is_green() { "passed" } else { "failed" }).clone_into(&mut night.verdict);
    report::write(&night, &measures, options.only.is_empty(), &own).map_err(Failure::run_failed)?;
    if options.only.is_empty() {
        let off = night.moved.len() as f64;
        measures.push(Number::new(ENTRY.0, ENTRY.1, Label::Count, off, Tolerance::relative(0.0)));
        history.note(&entry, &measures);
        measures.pop();
        let text = history.text(&history_path).map_err(Failure::run_failed)?;
        let path = folder.stage().join(history::NAME);
        write_file(&path, text)?;
        let pages = folder.stage().join("trends");
        make_folder(&pages)?;
        trends::write(&history, &pages).map_err(Failure::run_failed)?;
        nights::write(folder.path(), (&name, &night), folder.stage()).map_err(Failure::run_failed)?;
    }
    // The folders of earlier runs stay.
    folder.publish_beside("nightly", &|_| true).map_err(Failure::run_failed)?;
    Ok((night, measures, folder.path().join(name)))
}

/// The accepted numbers that this run can be compared with: those of the parts that were run, counts of the same compiler.
fn comparable(known: &[Accepted], measures: &[Number], options: &Options, notes: &mut Vec<String>) -> Vec<Accepted> {
    let measured = |row: &&Accepted| measures.iter().any(|m| m.is_of(&row.case, &row.quantity));
    let mut left_out: BTreeMap<&str, usize> = BTreeMap::new();
    for row in known.iter().filter(|row| counted(&row.quantity).is_some() && !measured(row)) {
        *left_out.entry(&row.quantity).or_default() += 1;
    }
    let unknown =
        |m: &&Number| counted(&m.quantity).is_some() && !known.iter().any(|row| m.is_of(&row.case, &row.quantity));
    let mut not_accepted: BTreeMap<&str, usize> = BTreeMap::new();
    for measure in measures.iter().filter(unknown) {
        *not_accepted.entry(&measure.quantity).or_default() += 1;
    }
    for (quantity, count) in not_accepted {
        notes.push(format!("{count} {quantity} are not compared: none is accepted for this compiler."));
    }
    for (quantity, count) in left_out {
        notes.push(format!("{count} accepted {quantity} are not compared: they were not counted in this run."));
    }
    let left = known.iter().filter(|row| !options.all && is_of_all(row) && !measured(row)).count();
    if left > 0 {
        notes.push(format!(
            "{left} accepted values of stress tests are not compared: --all runs schemes that are no default."
        ));
    }
    let of_part = |row: &&Accepted| counted(&row.quantity).is_none() && (options.all || !is_of_all(row));
    let wanted = |row: &&Accepted| measured(row) || (options.only.is_empty() && of_part(row));
    known.iter().filter(wanted).cloned().collect()
}

/// Whether only `--all` measures the number, if it is not that of a default scheme.
fn is_of_all(row: &Accepted) -> bool {
    row.case.starts_with(collect::STRESS_TESTS)
}

/// Renews the baselines. Failed checks are not numbers, and stay failed.
fn accept(
    known: &[Accepted],
    (measures, whole, all): (&[Number], bool, bool),
    night: &Night,
    (why, file): (&str, &Path),
    common: &Common,
) -> Result<(), Failure> {
    // A missing number is obsolete only if all parts were finished and could have measured it.
    let whole = whole && night.parts.len() == PARTS.len() && night.fell.is_empty();
    let goes = |row: &Accepted| whole && counted(&row.quantity).is_none() && (all || !is_of_all(row));
    let Renewed { rows, new, gone } = accepted::renewed(known, measures, (&night.date, &night.commit), why, goes);
    accepted::write(&rows, file).map_err(Failure::run_failed)?;
    let line = format!("{new} new or changed numbers accepted, {gone} obsolete rows removed, {} in all", rows.len());
    common.say(&line);
    common.say(&format!("baselines: {}", file.display()));
    if night.fell.is_empty() {
        return Ok(());
    }
    Err(Failure::CheckFailed(format!("the numbers are accepted, but checks failed: {}", night.fell.join("; "))))
}

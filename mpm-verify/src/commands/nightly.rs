//! `nightly`: its parts are run, compared with the accepted numbers and recorded.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser as _};
use cpu_time::ProcessTime;
use mpm_verify::cases::suite;
use mpm_verify::error::Error;
use mpm_verify::experiment::accepted::{self, Accepted, Renewed};
use mpm_verify::experiment::number::{Label, Number, Tolerance};
use mpm_verify::files::{self, Folder};
use mpm_verify::levee::limits;
use mpm_verify::manifest::Manifest;
use mpm_verify::nightly::compiled::counted;
use mpm_verify::nightly::history::{self, ENTRY, History};
use mpm_verify::nightly::part::{Finish, Measured, Part, SCENES};
use mpm_verify::nightly::report::{Night, PartRow, Shown, VALUES, stored};
use mpm_verify::nightly::{collect, instructions, moved, nights, report, thresholds, trends, work};
use mpm_verify::progress::Progress;
use mpm_verify::provenance;
use mpm_verify::report::plots::error_against_mesh::over_accepted;
use mpm_verify::report::plots::figure::Figure;
use mpm_verify::report::select::Cases;
use mpm_verify::study::Runner;
use mpm_verify::unpanicked::unpanicked;

use super::{Failure, check, levee, make_folder, metamorphic, stability, study, write_file};
use crate::Common;

/// Seed of the random scenes.
const SEED: u64 = 1;

/// Text of the help, from the list of the parts.
pub fn about() -> String {
    format!("Compare with accepted numbers: {}", Part::list())
}

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
    /// File of all nights, to commit for example [default: history.csv in the folder of the results]
    #[arg(long, value_name = "FILE")]
    history: Option<PathBuf>,
    /// Leave out the part instructions
    #[arg(long, hide = true)]
    no_instructions: bool,
    /// Also the schemes that are no default in the stress tests
    #[arg(long)]
    all: bool,
    /// Only these parts, without recording them
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',', value_parser = parts())]
    only: Vec<Part>,
}

/// The parts by their names.
fn parts() -> impl clap::builder::TypedValueParser<Value = Part> {
    PossibleValuesParser::new(Part::ALL.map(Part::name))
        .try_map(|name| Part::named(&name).ok_or_else(|| format!("no part {name}")))
}

impl Options {
    /// Whether a part is to be run.
    fn wants(&self, part: Part) -> bool {
        let asked = self.only.is_empty() || self.only.contains(&part);
        asked && !(self.no_instructions && part == Part::Instructions)
    }
}

/// Runs the parts; or renews the baselines from an earlier run.
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
    if night.is_unchanged() {
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
    common: Common,
    folder: &'a Path,
    known: &'a [Accepted],
    all: bool,
    measures: Vec<Number>,
    fell: Vec<String>,
    parts: Vec<PartRow>,
    notes: Vec<String>,
    convergence: Option<Figure>,
}

impl Findings<'_> {
    /// Runs a part; an error in it is recorded and stops no other part.
    fn run(&mut self, part: Part, loud: &Common) {
        let (cpu, wall) = (ProcessTime::now(), Instant::now());
        let name = part.name();
        loud.say(&format!("{name} ..."));
        let done = unpanicked(|| self.measured(part)).map_err(Failure::run_failed).flatten();
        let measured = done.as_ref().map_err(|why| self.fell.push(format!("{name}: {why}"))).ok();
        let (finish, line) = measured.map_or_else(
            || (Finish::Failed, "could not be finished".to_owned()),
            |found| (found.finish(), found.line()),
        );
        self.fell.extend(measured.into_iter().flat_map(|found| found.failures(part)));
        let (cpu_s, wall_s) = (cpu.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64());
        loud.say(&format!("{name}: {line}, {wall_s:.0} s"));
        self.parts.push(PartRow { name: part, finish, line, cpu_s, wall_s });
        if let Ok(Measured { numbers, notes, .. }) = done {
            self.measures.extend(numbers);
            self.notes.extend(notes);
        }
    }

    fn measured(&mut self, part: Part) -> Result<Measured, Failure> {
        match part {
            Part::Study => self.study(),
            Part::Suite => self.suite(),
            Part::Stability => self.stability(),
            Part::Levee => self.levee(),
            Part::Metamorphic => self.metamorphic(),
            Part::Work => Ok(work::counts()),
            Part::Instructions => Ok(instructions::counts(&std::env::current_exe().map_err(Failure::run_failed)?)),
        }
    }

    fn study(&mut self) -> Result<Measured, Failure> {
        let progress = Progress::new("accuracy study", true);
        let mut runner = Runner::whole(self.common.jobs(), &progress);
        let study = study::complete(&study::Options::paper(), &self.common, &mut runner, &String::new)?;
        let folder = self.folder.join("accuracy");
        make_folder(&folder)?;
        mpm_verify::report::write(&study, &folder).map_err(Failure::run_failed)?;
        let accepted = |case: &str| self.known.iter().find(|row| row.case == case && row.quantity == collect::ERROR);
        self.convergence = Some(over_accepted(&Cases::of(&study.results), |r| accepted(&r.case).map(|row| row.value)));
        Ok(collect::study(&study.results, &study.sweeps))
    }

    fn suite(&mut self) -> Result<Measured, Failure> {
        let ran = check::judged(&suite().iter().collect::<Vec<_>>(), &self.common, &self.folder.join("suite"))?;
        Ok(collect::suite(&ran.rows, &ran.failed))
    }

    fn stability(&mut self) -> Result<Measured, Failure> {
        let options = stability::Options::of_a_night(self.all);
        let found = stability::measure(&options, &self.common, &self.folder.join("stability"))?;
        let failed = stability::verdict(&found).err().map(|failure| failure.to_string());
        Ok(collect::stability(found.matrix(), found.summaries()).failed(failed))
    }

    fn levee(&mut self) -> Result<Measured, Failure> {
        let summary = levee::night(&self.folder.join("levee"))?;
        let mut found = collect::levee(&limits::of(&summary), collect::of_levee(&summary));
        found.remark = format!("failure at {:.3} h", summary.failure_start_h.unwrap_or(f64::NAN));
        found.failed.extend(limits::unfinished(&summary.ended, summary.trouble.as_deref()));
        Ok(found)
    }

    /// The same scenes in every run, so that only a change of the program can make it fail.
    fn metamorphic(&mut self) -> Result<Measured, Failure> {
        let indices: Vec<u64> = (0..SCENES).collect();
        let found = metamorphic::measure((SEED, &indices, None), &self.common, &self.folder.join("metamorphic"))?;
        let relations = found.laws().iter().map(|law| law.passed + law.failed).sum();
        let failed = found.failures.iter().map(|f| format!("{} of seed {SEED}: {}", f.name(), f.found[1])).collect();
        Ok(collect::metamorphic(found.scenes, relations, failed))
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
    let history_path = options.history.clone().unwrap_or_else(|| folder.path().join(history::NAME));
    let mut history = History::read(&history_path).map_err(Failure::bad_input)?;
    let mut found = Findings {
        common: Common { quiet: true, json: false, ..common.clone() },
        folder: &own,
        known,
        all: options.all,
        measures: Vec::new(),
        fell: Vec::new(),
        parts: Vec::new(),
        notes: Vec::new(),
        convergence: None,
    };
    for part in Part::ALL.into_iter().filter(|part| options.wants(*part)) {
        found.run(part, common);
    }
    let Findings { mut measures, mut fell, parts, mut notes, convergence, .. } = found;
    if parts.iter().all(|part| part.finish == Finish::NotRun) {
        fell.push("no part could be run".to_owned());
    }
    let entry = format!("{} {}", manifest.date, manifest.commit);
    let mut known = comparable(known, &measures, options, &mut notes);
    known.extend(thresholds::baselines(&known, &measures, &history));
    let moved = moved::moved(&known, &measures, &history, &entry);
    if file.is_none() {
        notes.push("The accepted numbers are those built into the program.".to_owned());
    }
    let is_known = |m: &Number| known.iter().any(|row| m.is_of(&row.case, &row.quantity));
    let compared = |m: &&Number| is_known(m) || (m.label != Label::Time && counted(&m.quantity).is_none());
    let judged = measures.iter().filter(compared);
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
    night.verdict = night.state().word().into_owned();
    let recorded = options.only.is_empty();
    if recorded {
        let off = night.moved.len() as f64;
        measures.push(Number::new(ENTRY.0, ENTRY.1, Label::Count, off, Tolerance::relative(0.0)));
        history.note(&entry, &measures);
        measures.pop();
    }
    let shown =
        Shown { measures: &measures, known: &known, history: &history, convergence: convergence.as_ref(), recorded };
    report::write(&night, &shown, &own).map_err(Failure::run_failed)?;
    if recorded {
        let text = history.text(&history_path).map_err(Failure::run_failed)?;
        match &options.history {
            Some(path) => files::write(path, &text).map_err(Failure::unwritable(path))?,
            None => write_file(&folder.stage().join(history::NAME), text)?,
        }
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
        notes
            .push(format!("{count} {quantity} are not compared with accepted ones: there are none for this compiler."));
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
    let whole = whole && night.parts.len() == Part::ALL.len() && night.fell.is_empty();
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

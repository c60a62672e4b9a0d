//! `levee`: seepage through a levee until it fails, with its page.

use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Duration;

use clap::Args;
use mpm_core::hardware::Hardware;
use mpm_core::scene::Flags;
use mpm_verify::checkpoint;
use mpm_verify::error::Error;
use mpm_verify::files::Folder;
use mpm_verify::levee::checkpoint::Checkpoint;
use mpm_verify::levee::limits::{self, Trust};
use mpm_verify::levee::plan::{self, Plan};
use mpm_verify::levee::run::{Ended, Hooks, follow, follow_quietly};
use mpm_verify::levee::summary::Summary;
use mpm_verify::levee::variants::{self, Variant};
use mpm_verify::levee::{convergence, drivers, ensemble, probability, safety, sensitivity, tables, ticker, written};
use mpm_verify::manifest::Manifest;
use mpm_verify::progress::Progress;

use super::{Failure, again_with, interrupts, make_folder, warn_if_long, words};
use crate::Common;

/// Which levee, and which analyses.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Scene (name or file) whose soil may fail
    #[arg(long, value_name = "SCENE", default_value = "levee")]
    scene: String,
    /// The paper's levee with one input changed: mpm-verify list variants
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
    /// Cell size in place of the scene's, m
    #[arg(long, value_name = "L")]
    mesh: Option<f64>,
    /// Particles per cell in place of the scene's: 1, 4, 9, ...
    #[arg(long, value_name = "N")]
    ppc: Option<i64>,
    /// End of the run, h on the clock of the scene
    #[arg(long, value_name = "H")]
    until: Option<f64>,
    /// Continue from the checkpoint of a run that was stopped
    #[arg(long)]
    resume: bool,
    /// Factors of safety at these times, h, by two methods
    #[arg(long, value_name = "H,H", value_delimiter = ',', help_heading = "Further analyses")]
    safety_factor: Vec<f64>,
    /// All variants of the paper's levee: what each input changes
    #[arg(long, help_heading = "Further analyses")]
    sensitivity: bool,
    /// Finer meshes, with 4 and 9 particles per cell: which results converge
    #[arg(long, help_heading = "Further analyses")]
    convergence: bool,
    /// Runs that should be equal, so many [default: 5] on each of two meshes: medians and 80 % ranges
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "5", value_parser = clap::value_parser!(u16).range(2..=99), help_heading = "Further analyses")]
    ensemble: Option<u16>,
    /// Probability of failure over time, from so many samples [default: 1000] of strength, conductivity and moisture
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "1000", value_parser = clap::value_parser!(u32).range(20..=1_000_000), help_heading = "Further analyses")]
    probability: Option<u32>,
    /// All couplings from one state before the failure
    #[arg(long, help_heading = "Further analyses")]
    compare_drivers: bool,
    /// Coupling of soil and water in place of the scene's integrator
    #[arg(long, value_name = "WORD", value_parser = words(&DRIVERS), hide = true)]
    driver: Option<String>,
    /// Start of the coupled or explicit run, h; staggered before
    #[arg(long, value_name = "H", hide = true)]
    from: Option<f64>,
    /// Continue although the levee does not stand under its own weight
    #[arg(long, hide = true)]
    go_on: bool,
    /// A quarter of the cell size as well; half of it in --ensemble
    #[arg(long, hide = true)]
    full: bool,
    /// Only the further analyses: no run, no page
    #[arg(long, hide = true)]
    no_run: bool,
    /// Write no files for ParaView
    #[arg(long, hide = true)]
    no_vtk: bool,
    /// Time between checkpoints, s [default: 60]
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = super::seconds, hide = true)]
    checkpoint_every: f64,
}

/// Words of `--driver`: how soil and water are coupled in time.
pub const DRIVERS: [(&str, ()); 3] = [("staggered", ()), ("coupled", ()), ("explicit", ())];

impl Options {
    /// A scene, with another driver if there is one; whether it continues from a checkpoint, and the time between two, s.
    pub fn of(scene: String, driver: Option<String>, (resume, checkpoint_every): (bool, f64)) -> Self {
        Self {
            scene,
            driver,
            mesh: None,
            ppc: None,
            go_on: false,
            variant: None,
            until: None,
            from: None,
            resume,
            checkpoint_every,
            safety_factor: Vec::new(),
            sensitivity: false,
            compare_drivers: false,
            convergence: false,
            ensemble: None,
            probability: None,
            full: false,
            no_run: false,
            no_vtk: false,
        }
    }

    fn flags(&self) -> Flags {
        Flags {
            driver: self.driver.clone(),
            cell: self.mesh,
            particles_per_cell: self.ppc,
            continue_if_unstable: self.go_on,
            ..Flags::default()
        }
    }

    /// Names of the results.
    fn names(&self) -> Vec<&'static str> {
        let asked = [
            !self.safety_factor.is_empty(),
            self.sensitivity,
            self.convergence,
            self.compare_drivers,
            self.ensemble.is_some(),
            self.probability.is_some(),
        ];
        let mut names: Vec<&str> =
            TABLES.into_iter().zip(asked).filter_map(|(name, asked)| asked.then_some(name)).collect();
        if !self.no_run {
            names.extend(["history.csv", "index.html", "summary.json"]);
        }
        names
    }

    fn variant(&self) -> Result<Option<&'static Variant>, Failure> {
        let Some(name) = &self.variant else { return Ok(None) };
        let names = || variants::VARIANTS.iter().map(|variant| variant.name);
        let unknown = || Error::unknown(("the name of a variant", "variants"), name, names()).of("--variant");
        variants::named(name).map(Some).ok_or_else(|| Failure::bad_input(unknown()))
    }
}

/// Runs a levee and writes everything about it.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    let variant = options.variant()?;
    let scene = plan::scene(&options.scene, &options.flags(), variant).map_err(Failure::bad_input)?;
    common.notices(&scene, &options.flags());
    let plan = Plan::new(scene, options.from, options.until, true).map_err(Failure::bad_input)?;
    // The variants are defined for the paper's levee.
    for (asked, flag) in [(options.sensitivity, "--sensitivity"), (variant.is_some(), "--variant")] {
        if let (true, Some(why)) = (asked, plan.not_papers()) {
            return Err(Failure::BadInput(format!("{flag}: {why}")));
        }
    }
    if options.full && !(options.sensitivity || options.convergence || options.ensemble.is_some()) {
        let expected = "--full: expected --sensitivity, --convergence or --ensemble beside it";
        return Err(Failure::BadInput(expected.to_owned()));
    }
    let names = options.names();
    common.publish("levee", &names, |folder| all(options, common, (&plan, variant), folder))
}

/// All that was asked for.
fn all(
    options: &Options,
    common: &Common,
    (plan, variant): (&Plan, Option<&'static Variant>),
    folder: &Folder,
) -> Result<(), Failure> {
    let published = |result: Result<(), Failure>| {
        result?;
        // The tables of earlier runs of the same levee stay.
        folder.publish_beside(&kind(plan), &|_| true).map_err(Failure::run_failed)
    };
    if !options.safety_factor.is_empty() {
        published(factors(options, common, plan, folder.stage()))?;
    }
    if options.sensitivity {
        published(vary(options, common, folder.stage()))?;
    }
    if options.convergence {
        let progress = Progress::new("meshes", common.quiet);
        let (flags, jobs) = (options.flags(), common.jobs());
        let found =
            convergence::compute((&options.scene, variant), &flags, options.full, jobs, &|text| progress.line(text));
        let found = found.map_err(Failure::bad_input)?;
        published(tables::lines(&found, &folder.stage().join(convergence::NAME)).map_err(Failure::run_failed))?;
    }
    let of = (options.scene.as_str(), variant);
    if let Some(members) = options.ensemble {
        let progress = Progress::new("runs that should be equal", common.quiet);
        let asked = (usize::from(members), options.full);
        let tell = |text: &str| progress.line(text);
        let found = ensemble::compute(of, &options.flags(), asked, common.jobs(), &tell).map_err(Failure::bad_input)?;
        published(tables::lines(&found, &folder.stage().join(ensemble::NAME)).map_err(Failure::run_failed))?;
    }
    if let Some(samples) = options.probability {
        let progress = Progress::new("probability of failure", common.quiet);
        let tell = |text: &str| progress.line(text);
        let found = probability::compute(of, &options.flags(), samples as usize, common.jobs(), &tell);
        let found = found.map_err(Failure::run_failed)?;
        published(tables::lines(&found, &folder.stage().join(probability::NAME)).map_err(Failure::run_failed))?;
    }
    if options.compare_drivers {
        let progress = Progress::new("drivers", common.quiet);
        let lines = drivers::compute(plan, &mut |text| progress.line(text)).map_err(Failure::run_failed)?;
        published(tables::lines(&lines, &folder.stage().join(drivers::NAME)).map_err(Failure::run_failed))?;
    }
    if !options.no_run {
        return one(options, common, plan, folder);
    }
    for table in options.names() {
        common.say(&format!("table: {}", folder.path().join(table).display()));
    }
    Ok(())
}

/// Tables of further analyses, which the page shows.
const TABLES: [&str; 6] =
    [safety::NAME, sensitivity::NAME, convergence::NAME, drivers::NAME, ensemble::NAME, probability::NAME];

/// Results of one scene belong together.
fn kind(plan: &Plan) -> String {
    format!("levee {}", plan.scene_word())
}

/// Factors of safety.
fn factors(options: &Options, common: &Common, plan: &Plan, folder: &Path) -> Result<(), Failure> {
    for time in &options.safety_factor {
        let (start, end) = (plan.starts_h(), plan.ends_h());
        if !(*time >= start && *time <= end) {
            let expected = format!("hours from {start} to {end}");
            return Err(Failure::BadInput(format!("--safety-factor: expected {expected}, found {time}")));
        }
    }
    let progress = Progress::new("factor of safety", common.quiet);
    let told = safety::compute(plan, &options.safety_factor, common.jobs(), &|text| progress.line(text));
    let lines = told.map_err(Failure::run_failed)?;
    tables::lines(&lines, &folder.join(safety::NAME)).map_err(Failure::run_failed)?;
    for line in &lines {
        common.say(&line.said());
    }
    if let Some(text) = safety::implied(&lines) {
        common.say(&text);
    }
    for warning in mpm_verify::slope::warnings(&plan.scene) {
        common.say(&format!("warning: {warning}"));
    }
    if options.no_run {
        safety::picture(&lines, None, "", folder).map_err(Failure::run_failed)?;
    }
    Ok(())
}

/// All variants.
fn vary(options: &Options, common: &Common, folder: &Path) -> Result<(), Failure> {
    let flags = options.flags();
    let base = sensitivity::Base { source: &options.scene, flags: &flags, until_h: options.until, full: options.full };
    let progress = Progress::new("variants", common.quiet);
    let lines = sensitivity::compute(&base, common.jobs(), &|text| progress.line(text));
    tables::lines(&lines, &folder.join(sensitivity::NAME)).map_err(Failure::run_failed)?;
    if options.no_run {
        sensitivity::picture(&lines, folder).map_err(Failure::run_failed)?;
    }
    Ok(())
}

fn one(options: &Options, common: &Common, plan: &Plan, folder: &Folder) -> Result<(), Failure> {
    let resume = match options.resume {
        true => Checkpoint::read(&plan.fingerprint(), folder.path()).map_err(Failure::bad_input)?,
        false => checkpoint::is_own(folder.path()).map(|()| None).map_err(Failure::bad_input)?,
    };
    let other = |word: &str| {
        let flags = Flags { driver: Some(word.to_owned()), ..options.flags() };
        plan::scene(&options.scene, &flags, options.variant().ok().flatten()).ok().map(|scene| vec![scene])
    };
    if resume.is_none() && options.from.is_none() {
        let scene = std::slice::from_ref(&plan.scene);
        warn_if_long(common, (&plan.scene.name, "--driver", 1), scene, &Hardware::default(), &other);
    }
    let mut ticker = ticker::Ticker::new(plan, common.quiet);
    let stopped = interrupts();
    let mut hooks = Hooks {
        progress: &mut |driver| ticker.tick(driver),
        stop: &mut |_| stopped.load(Ordering::Relaxed),
        folder: Some(folder.path().to_owned()),
        every: Duration::from_secs_f64(options.checkpoint_every),
        trouble: &mut |e| eprintln!("a checkpoint could not be written: {e}"),
    };
    let run = follow(plan, &mut hooks, resume).map_err(Failure::bad_input)?;
    ticker.finish();
    if run.ended == Ended::Stopped {
        let at = run.rows.last().map_or(0.0, |row| row.time_h);
        return Err(Failure::RunFailed(format!("stopped at {at:.4} h; to continue: {}", again_with("--resume"))));
    }
    let summary = Summary::of(plan, &run, options.variant.as_deref(), Manifest::new(&plan.scene, 1));
    let written = written::write(plan, &run, &summary, !options.no_vtk, (folder.path(), folder.stage()));
    written.map_err(Failure::run_failed)?;
    // The checkpoint is needed until everything is written.
    let stays = |file: &Path| TABLES.iter().any(|table| file == Path::new(table));
    folder.publish_beside(&kind(plan), &stays).map_err(Failure::run_failed)?;
    checkpoint::remove(folder.path());
    common.json(&summary);
    for line in summary.lines() {
        common.say(&line);
    }
    for limit in limits::of(&summary).iter().filter(|limit| !limit.passed()) {
        common.say(&format!("failed: {}", limit.said()));
    }
    common.page(&folder.path().join("index.html"));
    match &run.ended {
        Ended::DoesNotStand(what) => Err(Failure::RunFailed(format!(
            "{}: {what}, before any water has seeped; to run it nevertheless: --go-on",
            plan.scene.name
        ))),
        Ended::Failed(what) => {
            Err(Failure::RunFailed(format!("{what}; what was computed is in {}", folder.path().display())))
        }
        Ended::Collapsed | Ended::TimeOver | Ended::Stopped => match summary.trust.as_ref().and_then(Trust::trouble) {
            Some(trouble) => {
                Err(Failure::RunFailed(format!("{trouble}; what was computed is in {}", folder.path().display())))
            }
            None => Ok(()),
        },
    }
}

/// The built-in levee with its page, for the nightly run.
pub fn night(folder: &Path) -> Result<Summary, Failure> {
    let scene = plan::scene("levee", &Flags::default(), None).map_err(Failure::run_failed)?;
    let plan = Plan::new(scene, None, None, true).map_err(Failure::run_failed)?;
    make_folder(folder)?;
    let run = follow_quietly(&plan, &mut |_| false).map_err(Failure::run_failed)?;
    let summary = Summary::of(&plan, &run, None, Manifest::new(&plan.scene, 1));
    written::write(&plan, &run, &summary, false, (folder, folder)).map_err(Failure::run_failed)?;
    Ok(summary)
}

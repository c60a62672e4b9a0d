//! `levee`: a levee through which water seeps until it fails, with its page.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Duration;

use clap::Args;
use mpm_core::hardware::Hardware;
use mpm_core::scene::Flags;
use mpm_verify::checkpoint;
use mpm_verify::files::Folder;
use mpm_verify::levee::checkpoint::Checkpoint;
use mpm_verify::levee::limits::{self, Trust};
use mpm_verify::levee::plan::{self, Plan};
use mpm_verify::levee::run::{Ended, Hooks, follow};
use mpm_verify::levee::summary::Summary;
use mpm_verify::levee::variants::{self, Variant};
use mpm_verify::levee::{convergence, drivers, safety, sensitivity, tables, ticker, written};
use mpm_verify::manifest::Manifest;
use mpm_verify::progress::Progress;

use super::{Failure, again_with, inside, interrupts, into_folder, print_json, say, warn_if_long};
use crate::Common;

/// What to follow.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// A scene file, or the name of a built-in scene
    #[arg(long, value_name = "FILE", default_value = "levee")]
    scene: String,
    /// How soil and water are driven, in place of the scene's integrator: staggered, coupled or explicit
    #[arg(long, value_name = "WORD")]
    driver: Option<String>,
    /// In place of the scene's edge of a cell, m
    #[arg(long, value_name = "L")]
    mesh: Option<f64>,
    /// In place of the scene's particles per cell: 1, 4, 9, ...
    #[arg(long, value_name = "N")]
    ppc: Option<i64>,
    /// Go on with a levee that does not stand under its own weight and the first water
    #[arg(long)]
    go_on: bool,
    /// The paper's levee with one input changed: a name of `mpm-verify list`
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
    /// End here, h on the clock of the scene
    #[arg(long, value_name = "H")]
    until: Option<f64>,
    /// Staggered up to here, h on the clock of the scene; then coupled or explicit, as --driver says
    #[arg(long, value_name = "H")]
    from: Option<f64>,
    /// Go on from the checkpoint of a run that was stopped or killed; from the start if there is none
    #[arg(long)]
    resume: bool,
    /// Seconds between checkpoints
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = super::seconds)]
    checkpoint_every: f64,
    /// Factor of safety at these times, h on the clock of the scene: strength reduction and limit equilibrium
    #[arg(long, value_name = "T", value_delimiter = ',')]
    safety_factor: Vec<f64>,
    /// Run every variant of the paper's levee as well: sensitivity.csv, and bars on the page
    #[arg(long)]
    sensitivity: bool,
    /// Compare the drivers as well, from a common state shortly before the failure: what they predict, what they cost
    #[arg(long)]
    compare_drivers: bool,
    /// Run the scene on meshes of whole and half cells as well, with 4 and 9 particles per cell: what converges
    #[arg(long)]
    convergence: bool,
    /// With --sensitivity and --convergence: a quarter of a cell, too, which takes long
    #[arg(long)]
    full: bool,
    /// Only what --safety-factor, --sensitivity, --convergence and --compare-drivers ask for: no run, no page
    #[arg(long)]
    no_run: bool,
    /// Write no files for ParaView
    #[arg(long)]
    no_vtk: bool,
}

impl Options {
    /// A scene as it is, with another driver if there is one; whether it goes on from a checkpoint, and the seconds between two.
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

    /// Results that are written, by name.
    fn names(&self) -> Vec<&'static str> {
        let asked = [!self.safety_factor.is_empty(), self.sensitivity, self.convergence, self.compare_drivers];
        let mut names: Vec<&str> =
            TABLES.into_iter().zip(asked).filter_map(|(name, asked)| asked.then_some(name)).collect();
        if !self.no_run {
            names.extend(["history.csv", "index.html", "summary.json"]);
        }
        names
    }

    fn variant(&self) -> Result<Option<&'static Variant>, Failure> {
        let Some(name) = &self.variant else { return Ok(None) };
        let known = || variants::VARIANTS.map(|v| v.name).join(", ");
        variants::named(name)
            .map(Some)
            .ok_or_else(|| Failure::BadInput(format!("--variant: expected one of {}, found {name}", known())))
    }
}

/// Follows a levee and writes everything about it.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    let variant = options.variant()?;
    let scene = plan::scene(&options.scene, &options.flags(), variant).map_err(Failure::bad_input)?;
    let plan = Plan::new(scene, options.from, options.until, true).map_err(Failure::bad_input)?;
    let path = common.out.clone().unwrap_or_else(|| PathBuf::from("reports/levee"));
    // The variants are other readings of that levee.
    for (asked, flag) in [(options.sensitivity, "--sensitivity"), (variant.is_some(), "--variant")] {
        if let (true, Some(why)) = (asked, plan.not_papers()) {
            return Err(Failure::BadInput(format!("{flag}: {why}")));
        }
    }
    if options.full && !(options.sensitivity || options.convergence) {
        return Err(Failure::BadInput("--full: expected --sensitivity or --convergence beside it".to_owned()));
    }
    let names = options.names();
    into_folder(&path, &names, |folder| all(options, common, (&plan, variant), folder))
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
        // A table more about the same levee.
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
        let (flags, jobs) = (options.flags(), super::jobs(common.jobs));
        let found =
            convergence::compute((&options.scene, variant), &flags, options.full, jobs, &|text| progress.line(text));
        let found = found.map_err(Failure::bad_input)?;
        published(tables::lines(&found, &folder.stage().join(convergence::NAME)).map_err(Failure::run_failed))?;
    }
    if options.compare_drivers {
        let progress = Progress::new("drivers", common.quiet);
        let lines = drivers::compute(plan, &mut |text| progress.line(text)).map_err(Failure::run_failed)?;
        published(tables::lines(&lines, &folder.stage().join(drivers::NAME)).map_err(Failure::run_failed))?;
    }
    if options.no_run { Ok(()) } else { one(options, common, plan, folder) }
}

/// Tables about a levee that its run shows on its page.
const TABLES: [&str; 4] = [safety::NAME, sensitivity::NAME, convergence::NAME, drivers::NAME];

/// What results belong together: those of one scene.
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
    let told = safety::compute(plan, &options.safety_factor, &mut |text| progress.line(text));
    let lines = told.map_err(Failure::run_failed)?;
    tables::lines(&lines, &folder.join(safety::NAME)).map_err(Failure::run_failed)?;
    for line in &lines {
        say(common.quiet || common.json, &line.said());
    }
    if let Some(text) = safety::implied(&lines) {
        say(common.quiet || common.json, &text);
    }
    if options.no_run {
        safety::picture(&lines, None, folder).map_err(Failure::run_failed)?;
    }
    Ok(())
}

/// All variants.
fn vary(options: &Options, common: &Common, folder: &Path) -> Result<(), Failure> {
    let flags = options.flags();
    let base = sensitivity::Base { source: &options.scene, flags: &flags, until_h: options.until, full: options.full };
    let progress = Progress::new("variants", common.quiet);
    let lines = sensitivity::compute(&base, super::jobs(common.jobs), &|text| progress.line(text));
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
        return Err(Failure::RunFailed(format!("stopped at {at:.4} h; to go on: {}", again_with("--resume"))));
    }
    let summary = Summary::of(plan, &run, options.variant.as_deref(), Manifest::new(&plan.scene, 1));
    let written = written::write(plan, &run, &summary, !options.no_vtk, (folder.path(), folder.stage()));
    written.map_err(Failure::run_failed)?;
    // Only once all is written is there nothing to go on from.
    let stays = |file: &Path| TABLES.iter().any(|table| file == Path::new(table));
    folder.publish_beside(&kind(plan), &stays).map_err(Failure::run_failed)?;
    checkpoint::remove(folder.path());
    if common.json {
        print_json(&summary);
    } else {
        for line in summary.lines() {
            say(common.quiet, &line);
        }
        for limit in limits::of(&summary).iter().filter(|limit| !limit.passed()) {
            say(common.quiet, &format!("not held: {}", limit.said()));
        }
        say(common.quiet, &format!("page: {}", folder.path().join("index.html").display()));
    }
    match &run.ended {
        Ended::DoesNotStand(what) => Err(Failure::RunFailed(format!(
            "{}: {what}; no water has seeped yet. To follow what it does all the same: --go-on",
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

/// The built-in levee with its page, for the night.
pub fn night(folder: &Path) -> Result<Summary, Failure> {
    let scene = plan::scene("levee", &Flags::default(), None).map_err(Failure::run_failed)?;
    let plan = Plan::new(scene, None, None, true).map_err(Failure::run_failed)?;
    inside(folder)?;
    let mut hooks =
        Hooks { progress: &mut |_| (), stop: &mut |_| false, folder: None, every: Duration::MAX, trouble: &mut |_| () };
    let run = follow(&plan, &mut hooks, None).map_err(Failure::run_failed)?;
    let summary = Summary::of(&plan, &run, None, Manifest::new(&plan.scene, 1));
    written::write(&plan, &run, &summary, false, (folder, folder)).map_err(Failure::run_failed)?;
    Ok(summary)
}

//! `solve`: one scene, its history and summary.

mod tables;
mod told;

use std::time::{Duration, Instant};

use clap::Args;
use mpm_core::drive::Run;
use mpm_core::hardware::Hardware;
use mpm_core::observe::{Trust, WaterState};
use mpm_core::run::{StartError, outline_parts, run_monitored};
use mpm_core::scene::{Estimate, Flags, INTEGRATORS, Integrator, SHAPES, Scene};
use mpm_core::seeding;
use mpm_core::stability::{choose_step, stable_limit};
use mpm_verify::cases::own::applies::Solution;
use mpm_verify::cases::own::compared::Found;
use mpm_verify::checkpoint;
use mpm_verify::files::Folder;
use mpm_verify::frames::Recorded;
use mpm_verify::keeping::{self, Keeping, Notes};
use mpm_verify::manifest::Manifest;
use mpm_verify::progress::Progress;
use mpm_verify::report::solved::{self, Solved as Shown};
use mpm_verify::report::vtk;
use mpm_verify::run_time::longest;
use serde::Serialize;

use super::{Failure, again_with, interrupts, warn_if_long, words, write_json};
use crate::Common;

/// What to solve.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Scene: a file, or a name of `mpm-verify list scenes`
    scene: String,
    /// In place of the scene's time.integrator
    #[arg(long, value_name = "WORD", value_parser = words(&INTEGRATORS))]
    integrator: Option<String>,
    /// In place of the scene's scheme.shape
    #[arg(long, value_name = "WORD", value_parser = words(&SHAPES))]
    scheme: Option<String>,
    /// In place of the scene's time.tolerance: relative error in time of quasi-static steps
    #[arg(long, value_name = "T")]
    tolerance: Option<f64>,
    /// Threads of one run; by default all cores if the scene is large enough
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,
    /// Continue from the checkpoint of a run that was stopped
    #[arg(long)]
    resume: bool,
    /// Write the folder vtk for ParaView: the start and the times of observe.times
    #[arg(long)]
    vtk: bool,
    /// Allow a time step above the stability limit
    #[arg(long)]
    force: bool,
    /// Write state.csv, from which [initial] of another scene can start
    #[arg(long, hide = true)]
    state: bool,
    /// Time between checkpoints, s [default: 60]
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = super::seconds, hide = true)]
    checkpoint_every: f64,
}

impl Options {
    /// A scene as it is.
    pub fn of(scene: String) -> Self {
        Self {
            scene,
            force: false,
            integrator: None,
            scheme: None,
            tolerance: None,
            threads: None,
            resume: false,
            state: false,
            vtk: false,
            checkpoint_every: 60.0,
        }
    }
}

/// summary.json.
#[derive(Debug, Serialize)]
struct Summary<'a> {
    scene: &'a Scene,
    manifest: Manifest,
    /// Largest step asked for; `None` where the integrator chooses its own.
    dt_s: Option<f64>,
    /// Stability limit of the integrator; `None` where there is none.
    limit_s: Option<f64>,
    forced: bool,
    steps: u64,
    stages: &'a [mpm_core::drive::StageRecord],
    solid_particles: usize,
    bytes_per_particle: usize,
    cpu_s: f64,
    ns_per_point_step: f64,
    settlement_final_m: f64,
    /// Exact settlement with finite bulk modulus of the pore water, where there is one at the end of the run.
    settlement_compressible_m: Option<f64>,
    /// The run beside the exact solution of its scene, where there is one.
    exact: Option<Found>,
    failure: Option<String>,
    integrator: Integrator,
    accepted_steps: u64,
    rejected_steps: u64,
    factorisations: u64,
    solves: u64,
    /// Threads of the run.
    threads: usize,
    /// Wall-clock time, s; `cpu_s` is the sum over all threads.
    wall_s: f64,
    /// The outline and the particles in it.
    #[serde(flatten)]
    seeded: Option<Seeded>,
    /// Energy dissipated by plastic flow, J.
    plastic_dissipation_j: f64,
    /// Largest violation of the yield function relative to 2 c cos(phi); `None` for an elastic law.
    yield_residual_max: Option<f64>,
    /// Whether the balance residuals stay within their bounds, and the largest of them.
    trust: Option<Trust>,
    /// Estimate, before the run, of what load and weight do to level soil.
    estimate: Option<Estimate>,
    /// Consequences of choices in the scene.
    notes: Vec<String>,
    /// Water with a free surface at the end.
    water: Option<WaterState>,
}

/// An outline and the particles in it.
#[derive(Debug, Serialize)]
struct Seeded {
    outline_area_m2: f64,
    seeded_area_m2: f64,
    outline_centroid_m: [f64; 2],
    seeded_centroid_m: [f64; 2],
}

impl Seeded {
    fn of(scene: &Scene) -> Option<Self> {
        let outline = scene.outline.as_ref()?;
        let (seeded_area_m2, seeded_centroid_m) = seeding::total(&outline_parts(scene)?);
        let (outline_area_m2, outline_centroid_m) = (seeding::area(outline), seeding::centroid(outline));
        Some(Self { outline_area_m2, seeded_area_m2, outline_centroid_m, seeded_centroid_m })
    }
}

/// Solves a scene.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    let flags = Flags {
        integrator: options.integrator.clone(),
        scheme: options.scheme.clone(),
        tolerance: options.tolerance,
        ..Flags::default()
    };
    let scene = common.load(&options.scene, &flags)?;
    let scene = if options.force { scene.forced() } else { scene };
    if scene.may_fail() {
        return follow(options, common, &scene);
    }
    let hardware = Hardware::suiting(&scene, options.threads.map(usize::from)).map_err(Failure::bad_input)?;
    let other = |word: &str| {
        let flags = Flags { integrator: Some(word.to_owned()), ..flags.clone() };
        let other = mpm_verify::scenes::load(&options.scene, &flags).ok();
        other.filter(|scene| scene.bears_its_load().is_ok() && choose_step(scene).is_ok()).map(|scene| vec![scene])
    };
    if !options.resume {
        warn_if_long(common, (&scene.name, "--integrator", 1), std::slice::from_ref(&scene), &hardware, &other);
    }
    let solved =
        common.publish(&scene.name, &names(&scene), |folder| solve(options, common, (&scene, &hardware), folder))?;
    match (&solved.failure, solved.stopped) {
        (Some(failure), _) => Err(Failure::RunFailed(format!("{}: {failure}", scene.name))),
        (None, true) => {
            Err(Failure::RunFailed(format!("{}: stopped; to continue: {}", scene.name, again_with("--resume"))))
        }
        (None, false) => Ok(()),
    }
}

/// Runs a scene whose soil may fail as `levee` does.
fn follow(options: &Options, common: &Common, scene: &Scene) -> Result<(), Failure> {
    let unknown = [
        ("--force", options.force),
        ("--scheme", options.scheme.is_some()),
        ("--tolerance", options.tolerance.is_some()),
        ("--threads", options.threads.is_some()),
        ("--state", options.state),
    ];
    if let Some((flag, _)) = unknown.into_iter().find(|(_, given)| *given) {
        let expected = "none for a scene whose soil may fail; it takes --integrator, --resume and --checkpoint-every";
        return Err(Failure::BadInput(format!("{}: {flag}: expected {expected}", options.scene)));
    }
    let levee = super::levee::Options::of(
        options.scene.clone(),
        options.integrator.clone(),
        (options.resume, options.checkpoint_every),
    );
    super::levee::run(&levee, &Common { out: Some(common.folder(&scene.name)), ..common.clone() })
}

/// Names of the results of a scene.
fn names(scene: &Scene) -> Vec<&'static str> {
    let some = [("profiles.csv", scene.profiles), ("water.csv", scene.free_surface.is_some())];
    let some = some.into_iter().filter_map(|(name, there)| there.then_some(name));
    ["history.csv", "summary.json"].into_iter().chain(some).collect()
}

/// How a run ended.
struct Solved {
    stopped: bool,
    failure: Option<String>,
}

/// Runs the scene and writes its results.
fn solve(
    options: &Options,
    common: &Common,
    (scene, hardware): (&Scene, &Hardware),
    folder: &Folder,
) -> Result<Solved, Failure> {
    if !options.resume {
        checkpoint::is_own(folder.path()).map_err(Failure::bad_input)?;
    }
    let kept = keeping::kept(scene, folder.path());
    let kept = match (options.resume, kept) {
        (true, kept) => kept.map_err(Failure::bad_input)?,
        (false, Ok(None)) => None,
        (false, _) => {
            common
                .say(&format!("{}: found the checkpoint of an earlier run, from which --resume continues", scene.name));
            None
        }
    };
    let before = kept.as_ref().map_or(Notes::default(), |kept| kept.notes);
    let progress = Progress::new(&scene.name, common.quiet);
    let (own, all, watch) = (cpu_time::ThreadTime::now(), cpu_time::ProcessTime::now(), Instant::now());
    let used = || {
        // The thread that draws the progress bar is not part of the run.
        let cpu = if hardware.thread_count() == 1 { own.elapsed() } else { all.elapsed() };
        Notes { cpu_s: before.cpu_s + cpu.as_secs_f64(), wall_s: before.wall_s + watch.elapsed().as_secs_f64() }
    };
    let mut whole = Stages::of(scene);
    let mut attend = Keeping {
        scene,
        folder: folder.path().to_owned(),
        every: Duration::from_secs_f64(options.checkpoint_every),
        progress: &mut |share| progress.set((whole.share(share) * 1e6) as u64),
        stop: interrupts(),
        used: &used,
        last: Instant::now(),
        trouble: None,
        end: options.state.then(Vec::new),
        frames: options.vtk.then(|| Recorded::of(scene)),
    };
    let state = kept.map(|kept| kept.state);
    let run = run_monitored(hardware, scene, state.as_deref(), &mut attend).map_err(|e| match e {
        StartError::Checkpoint(e) => {
            Failure::BadInput(format!("{}: {e}", folder.path().join(checkpoint::NAME).display()))
        }
        e => Failure::BadInput(format!("{}: {e}", options.scene)),
    })?;
    let Notes { cpu_s, wall_s } = used();
    progress.finish();
    if let Some(trouble) = &attend.trouble {
        if run.stopped {
            return Err(Failure::RunFailed(format!(
                "{}: stopped, and the checkpoint could not be written: {trouble}",
                scene.name
            )));
        }
        eprintln!("the last checkpoint could not be written: {trouble}");
    }
    if run.stopped {
        return Ok(Solved { stopped: true, failure: None });
    }
    let solution = Solution::of(scene);
    let summary = summary(scene, &run, solution.as_ref(), hardware.thread_count(), [cpu_s, wall_s]);
    tables::write(scene, &run, folder.stage())?;
    let about = mpm_verify::scenes::about(&options.scene);
    let exact = solution.as_ref().zip(summary.exact.as_ref());
    let shown = Shown { scene, run: &run, exact, about: &about, source: &options.scene, cpu_s };
    solved::write(&shown, &summary.manifest, folder.stage()).map_err(Failure::run_failed)?;
    write_json(&folder.stage().join("summary.json"), &summary)?;
    if let Some(end) = &attend.end {
        tables::write_state(scene, end, &folder.stage().join("state.csv"))?;
    }
    if let Some(frames) = &attend.frames {
        vtk::write(&frames.shots, &folder.stage().join("vtk")).map_err(Failure::run_failed)?;
    }
    // The checkpoint is needed until everything is written.
    folder.publish().map_err(Failure::run_failed)?;
    checkpoint::remove(folder.path());
    common.json(&summary);
    for line in told::lines(scene, &run, &summary, solution.as_ref()) {
        common.say(&line);
    }
    common.page(&folder.path().join("index.html"));
    Ok(Solved { stopped: false, failure: run.failure.as_ref().map(ToString::to_string) })
}

/// The share of a run that is done, from that of its stage.
struct Stages {
    /// Simulated time at the end of every stage, s.
    ends: Vec<f64>,
    stage: usize,
    last: f64,
}

impl Stages {
    fn of(scene: &Scene) -> Self {
        let mut end = 0.0;
        let ends = scene.stages.iter().map(|stage| {
            end += longest(stage);
            end
        });
        Self { ends: ends.collect(), stage: 0, last: 0.0 }
    }

    fn share(&mut self, share: f64) -> f64 {
        let last = self.ends.len().saturating_sub(1);
        if share < self.last {
            self.stage = last.min(self.stage + 1);
        }
        self.last = share;
        let begin = self.stage.checked_sub(1).map_or(0.0, |before| self.ends[before]);
        (begin + share * (self.ends[self.stage] - begin)) / self.ends[last]
    }
}

fn summary<'a>(
    scene: &'a Scene,
    run: &'a Run,
    exact: Option<&Solution>,
    threads: usize,
    [cpu_s, wall_s]: [f64; 2],
) -> Summary<'a> {
    let limit = stable_limit(scene);
    let finite = |time: f64| Some(time).filter(|time| time.is_finite());
    let last = run.samples.last();
    Summary {
        scene,
        manifest: Manifest::new(scene, threads),
        dt_s: finite(run.dt),
        limit_s: finite(limit),
        forced: scene.force && run.dt > limit,
        steps: run.steps,
        stages: &run.stages,
        solid_particles: run.solid_particles,
        bytes_per_particle: run.bytes / run.solid_particles,
        cpu_s,
        ns_per_point_step: cpu_s * 1e9 / (run.steps.max(1) as f64 * run.solid_particles as f64),
        settlement_final_m: last.map_or(f64::NAN, |s| s.state.settlement),
        settlement_compressible_m: exact
            .zip(last)
            .and_then(|(exact, s)| exact.settlement(scene, s.stage_time))
            .filter(|settlement| settlement.is_finite()),
        exact: exact.and_then(|exact| Found::of(exact, scene, run)),
        failure: run.failure.as_ref().map(ToString::to_string),
        integrator: scene.integrator,
        accepted_steps: run.work.accepted,
        rejected_steps: run.work.rejected,
        factorisations: run.work.factorisations,
        solves: run.work.solves,
        threads,
        wall_s,
        seeded: Seeded::of(scene),
        plastic_dissipation_j: last.map_or(0.0, |s| s.balance.plastic_dissipation_j),
        yield_residual_max: last.and_then(|s| s.balance.yield_residual_max),
        trust: run.trust,
        estimate: scene.is_one_dimensional().then(|| scene.estimate()),
        notes: scene.notes(),
        water: last.and_then(|s| s.state.water),
    }
}

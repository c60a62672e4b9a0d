//! `solve`: one scene file, its history and summary.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use mpm_core::drive::{Run, Sample};
use mpm_core::hardware::Hardware;
use mpm_core::observe::{SolidState, Trust, WaterState};
use mpm_core::run::{StartError, outline_parts, run_monitored};
use mpm_core::scene::{Dimension, Estimate, Flags, INTEGRATORS, Integrator, SHAPES, Scene};
use mpm_core::seeding;
use mpm_core::stability::{choose_step, stable_limit};
use mpm_core::step::Work;
use mpm_verify::checkpoint;
use mpm_verify::files::Folder;
use mpm_verify::frames::Recorded;
use mpm_verify::keeping::{self, Keeping, Notes};
use mpm_verify::manifest::Manifest;
use mpm_verify::progress::Progress;
use mpm_verify::report::solved::{self, Exact};
use mpm_verify::report::vtk;
use serde::Serialize;

use super::{Failure, again_with, interrupts, into_folder, print_json, say, warn_if_long, write_csv, write_json};
use crate::Common;

/// What to solve.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// The scene
    scene: PathBuf,
    /// Run a step above the stability limit all the same
    #[arg(long)]
    force: bool,
    #[arg(long, value_name = "WORD", help = super::words("time.integrator", &INTEGRATORS))]
    integrator: Option<String>,
    #[arg(long, value_name = "WORD", help = super::words("scheme.shape", &SHAPES))]
    scheme: Option<String>,
    /// In place of the scene's time.tolerance, the largest relative error in time of quasi-static steps
    #[arg(long, value_name = "SHARE")]
    tolerance: Option<f64>,
    /// Threads of an explicit run in plane strain; without it all, if the scene is large enough for them to pay
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,
    /// Go on from the checkpoint of a run that was stopped or killed; from the start if there is none
    #[arg(long)]
    resume: bool,
    /// Write state.csv, the particles of the end, which [initial] of another scene may start from
    #[arg(long)]
    state: bool,
    /// Write the folder vtk for ParaView: the start and the times of observe.times
    #[arg(long)]
    vtk: bool,
    /// Seconds between checkpoints
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = super::seconds)]
    checkpoint_every: f64,
}

impl Options {
    /// A scene as it is.
    pub fn of(scene: PathBuf) -> Self {
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

/// A row of history.csv.
#[derive(Debug, Serialize)]
struct Row {
    time_s: f64,
    stage: usize,
    stage_time_s: f64,
    step: u64,
    settlement_m: f64,
    mean_pressure_pa: f64,
    base_pressure_pa: f64,
    max_speed_m_s: f64,
    checkerboard: f64,
    solid_crossings: u64,
    water_crossings: u64,
    solid_mass_kg: f64,
    solid_residual_kg: f64,
    water_stored_kg: f64,
    water_in_kg: f64,
    water_out_kg: f64,
    water_residual_kg: f64,
    momentum_n_s: f64,
    impulse_n_s: f64,
    momentum_residual_n_s: f64,
    kinetic_j: f64,
    strain_j: f64,
    water_j: f64,
    external_work_j: f64,
    gravity_work_j: f64,
    flow_body_work_j: f64,
    darcy_dissipation_j: f64,
    damping_loss_j: f64,
    energy_residual_j: f64,
    water_particles_removed_kg: f64,
    base_friction_j: f64,
    centre_x_m: f64,
    centre_y_m: f64,
    reach_x_m: f64,
    reach_y_m: f64,
    plastic_dissipation_j: f64,
    yield_residual_max: Option<f64>,
    cut_off_n_s: f64,
    transfer_loss_j: f64,
    momentum_carried_n_s: f64,
    soil_volume_m3: f64,
    /// Force of all plates that are moved on the soil, per metre; of a dynamic run its mean since the row before.
    plates_x_n: Option<f64>,
    plates_y_n: Option<f64>,
}

/// A row of profiles.csv.
#[derive(Debug, Serialize)]
struct ProfileLine {
    time_s: f64,
    stage: usize,
    stage_time_s: f64,
    height_m: f64,
    material_height_m: f64,
    pressure_pa: f64,
    effective_stress_pa: f64,
}

/// A row of field.csv: the pore pressure over the plane, of quasi-static runs in plane strain and staggered runs.
#[derive(Debug, Serialize)]
struct FieldLine {
    time_s: f64,
    stage: usize,
    stage_time_s: f64,
    x_m: f64,
    y_m: f64,
    pressure_pa: f64,
    /// Share of the pores that mobile water fills.
    saturation: f64,
    /// Share of the cell that is soil.
    soil: f64,
}

/// A row of water.csv: water with a free surface.
#[derive(Debug, Serialize)]
struct WaterLine {
    time_s: f64,
    stage: usize,
    stage_time_s: f64,
    mobile_m3: f64,
    particles_m3: f64,
    pending_m3: f64,
    inflow_m3_s: f64,
    outflow_m3_s: f64,
    in_m3: f64,
    out_m3: f64,
    front_x_m: f64,
    front_y_m: f64,
    particles: u64,
    spawned: u64,
    removed: u64,
    packing_mean: f64,
    packing_max: f64,
    unsettled: u64,
    pending_allowed_m3: f64,
    asked_m3: f64,
    ran_off_m3: f64,
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
    /// Against Terzaghi with compressible water, where the scene is a consolidation.
    settlement_compressible_m: Option<f64>,
    failure: Option<String>,
    integrator: Integrator,
    accepted_steps: u64,
    rejected_steps: u64,
    factorisations: u64,
    solves: u64,
    /// Threads of the run.
    threads: usize,
    /// Time by the clock on the wall, s; `cpu_s` adds up that of all threads.
    wall_s: f64,
    /// What the particles of an outline stand for, beside the outline itself.
    #[serde(flatten)]
    seeded: Option<Seeded>,
    /// Energy dissipated by plastic flow, J.
    plastic_dissipation_j: f64,
    /// How far any stress was outside the yield surface at most, as a share of 2 c cos(phi); `None` under an elastic law.
    yield_residual_max: Option<f64>,
    /// Whether the balances closed, and how near to its bound the worst came.
    trust: Option<Trust>,
    /// What load and weight do to level soil at the end, estimated before the run.
    estimate: Option<Estimate>,
    /// What the scene's choices cost that it says nothing about.
    notes: Vec<String>,
    /// Water with a free surface at the end: what the cells hold and what the particles do, and what feeds brought.
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
    let scene = Scene::load_with(&options.scene, &flags).map_err(Failure::bad_input)?;
    for warning in scene.warnings() {
        eprintln!("{warning}");
    }
    let scene = if options.force { scene.forced() } else { scene };
    if scene.may_fail() {
        return follow(options, common, &scene);
    }
    if let (Some(integrator), false) = (&options.integrator, scene.left_out.is_empty()) {
        say(common.quiet || common.json, &format!("--integrator {integrator}: left out {}", scene.left_out.join(", ")));
    }
    let folder = common.out.clone().unwrap_or_else(|| PathBuf::from("reports").join(&scene.name));
    let hardware = Hardware::suiting(&scene, options.threads.map(usize::from)).map_err(Failure::bad_input)?;
    let other = |word: &str| {
        let flags = Flags { integrator: Some(word.to_owned()), ..flags.clone() };
        let other = Scene::load_with(&options.scene, &flags).ok();
        other.filter(|scene| scene.bears_its_load().is_ok() && choose_step(scene).is_ok()).map(|scene| vec![scene])
    };
    if !options.resume {
        warn_if_long(common, (&scene.name, "--integrator", 1), std::slice::from_ref(&scene), &hardware, &other);
    }
    let solved = into_folder(&folder, &names(&scene), |folder| solve(options, common, (&scene, &hardware), folder))?;
    match (&solved.failure, solved.stopped) {
        (Some(failure), _) => Err(Failure::RunFailed(format!("{}: {failure}", scene.name))),
        (None, true) => {
            Err(Failure::RunFailed(format!("{}: stopped; to go on: {}", scene.name, again_with("--resume"))))
        }
        (None, false) => Ok(()),
    }
}

/// Follows soil that may fail, as `levee` does the paper's.
fn follow(options: &Options, common: &Common, scene: &Scene) -> Result<(), Failure> {
    let unknown = [
        ("--force", options.force),
        ("--scheme", options.scheme.is_some()),
        ("--tolerance", options.tolerance.is_some()),
        ("--threads", options.threads.is_some()),
        ("--state", options.state),
    ];
    if let Some((flag, _)) = unknown.into_iter().find(|(_, given)| *given) {
        let path = options.scene.display();
        let expected = "none beside coupling = \"full\", which takes --integrator, --resume and --checkpoint-every";
        return Err(Failure::BadInput(format!("{path}: {flag}: expected {expected}")));
    }
    let out = common.out.clone().unwrap_or_else(|| PathBuf::from("reports").join(&scene.name));
    let levee = super::levee::Options::of(
        options.scene.display().to_string(),
        options.integrator.clone(),
        (options.resume, options.checkpoint_every),
    );
    super::levee::run(&levee, &Common { out: Some(out), ..common.clone() })
}

/// Results that every run of a scene writes, by name.
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

/// Runs the scene, and writes what it came to.
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
            let note = "found the checkpoint of an earlier run; --resume would go on from it";
            say(common.quiet || common.json, &format!("{}: {note}", scene.name));
            None
        }
    };
    let before = kept.as_ref().map_or(Notes::default(), |kept| kept.notes);
    let progress = Progress::new(&scene.name, common.quiet);
    let (own, all, watch) = (cpu_time::ThreadTime::now(), cpu_time::ProcessTime::now(), Instant::now());
    let used = || {
        // The thread that draws the progress bar is no part of the run.
        let cpu = if hardware.thread_count() == 1 { own.elapsed() } else { all.elapsed() };
        Notes { cpu_s: before.cpu_s + cpu.as_secs_f64(), wall_s: before.wall_s + watch.elapsed().as_secs_f64() }
    };
    let mut attend = Keeping {
        scene,
        folder: folder.path().to_owned(),
        every: Duration::from_secs_f64(options.checkpoint_every),
        progress: &mut |share| progress.set((share * 1e6) as u64),
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
        StartError::Step(e) => Failure::BadInput(format!("{}: {e}", options.scene.display())),
        StartError::Load(e) => Failure::BadInput(format!("{}: {e}", options.scene.display())),
        StartError::Place(e) => Failure::BadInput(format!("{}: {e}", options.scene.display())),
        StartError::MayFail => Failure::BadInput(format!("{}: {e}", options.scene.display())),
    })?;
    let Notes { cpu_s, wall_s } = used();
    progress.finish();
    if let Some(trouble) = &attend.trouble {
        if run.stopped {
            return Err(Failure::RunFailed(format!(
                "{}: stopped, and the state could not be kept: {trouble}",
                scene.name
            )));
        }
        eprintln!("the last checkpoint could not be written: {trouble}");
    }
    if run.stopped {
        return Ok(Solved { stopped: true, failure: None });
    }
    let summary = summary(scene, &run, hardware.thread_count(), [cpu_s, wall_s]);
    write((scene, &run, &summary), folder.stage())?;
    if let Some(end) = &attend.end {
        write_state(scene, end, &folder.stage().join("state.csv"))?;
    }
    if let Some(frames) = &attend.frames {
        vtk::write(&frames.shots, &folder.stage().join("vtk")).map_err(Failure::run_failed)?;
    }
    // Only once all is written is there nothing to go on from.
    folder.publish().map_err(Failure::run_failed)?;
    checkpoint::remove(folder.path());
    told(common, (scene, &run, &summary), folder.path());
    Ok(Solved { stopped: false, failure: run.failure.as_ref().map(ToString::to_string) })
}

/// Writes the files of a run.
fn write((scene, run, summary): (&Scene, &Run, &Summary), folder: &Path) -> Result<(), Failure> {
    write_csv(&folder.join("history.csv"), &history(run))?;
    if scene.profiles {
        write_csv(&folder.join("profiles.csv"), &profiles(run))?;
    }
    let field = field(run);
    if !field.is_empty() {
        write_csv(&folder.join("field.csv"), &field)?;
    }
    let water = water(run);
    if !water.is_empty() {
        write_csv(&folder.join("water.csv"), &water)?;
    }
    solved::write((scene, run), (&summary.manifest, summary.cpu_s), folder).map_err(Failure::run_failed)?;
    write_json(&folder.join("summary.json"), summary)
}

/// Writes state.csv, whose columns are those of a table of `[initial]`: without x for a column.
fn write_state(scene: &Scene, end: &[SolidState], path: &Path) -> Result<(), Failure> {
    let mut writer = csv::Writer::from_path(path).map_err(Failure::run_failed)?;
    let names = "x_m,y_m,pressure_pa,stress_xx_pa,stress_yy_pa,stress_zz_pa,stress_xy_pa".split(',');
    let from = usize::from(scene.dimension == Dimension::Column);
    writer.write_record(names.skip(from)).map_err(Failure::run_failed)?;
    for SolidState { x: [x, y], pore_pressure, stress: [xx, yy, zz, xy], .. } in end {
        let row = [x, y, pore_pressure, xx, yy, zz, xy];
        writer.write_record(row.iter().skip(from).map(|number| format!("{number:e}"))).map_err(Failure::run_failed)?;
    }
    writer.flush().map_err(Failure::run_failed)
}

/// Says what a run came to.
fn told(common: &Common, (scene, run, summary): (&Scene, &Run, &Summary), folder: &Path) {
    if common.json {
        print_json(summary);
    } else {
        let work = match run.work {
            Work { solves: 0, .. } => format!("{} steps", run.steps),
            // The Krylov method has no steps: one basis for all times.
            work if run.steps == 0 => format!("{} factorisations, {} solves", work.factorisations, work.solves),
            Work { accepted, rejected, factorisations, solves } => {
                let rejected = if rejected > 0 { format!(" ({rejected} rejected)") } else { String::new() };
                let steps = run.steps.max(accepted);
                format!("{steps} steps{rejected}, {factorisations} factorisations, {solves} solves")
            }
        };
        let end = format!("{work}, settlement {:.6e} m", summary.settlement_final_m);
        say(common.quiet, &format!("{}: {end}, written to {}", scene.name, folder.display()));
        for note in &summary.notes {
            say(common.quiet, &format!("note: {note}"));
        }
        if let Some(Trust { verdict, ledger, gap, allowed, unit, .. }) = &summary.trust {
            let worst =
                format!("nearest to its bound {ledger}, {gap:.2e} {unit} missing of {allowed:.2e} {unit} allowed");
            say(common.quiet, &format!("balances {verdict}: {worst}"));
        }
        if let Some(water) = &summary.water {
            say(common.quiet, &format!("{}: {}", scene.name, balance(water)));
        }
        if let (true, Some(limit)) = (summary.forced, summary.limit_s) {
            say(common.quiet, &format!("forced: step {:.3e} s above the limit {limit:.3e} s", run.dt));
        }
    }
}

/// The balance of water with a free surface in words.
fn balance(water: &WaterState) -> String {
    let WaterState { mobile_m3, particles_m3, pending_m3, pending_allowed_m3, asked_m3, ran_off_m3, .. } = water;
    let held = format!(
        "water {mobile_m3:.6e} m3 in cells, {particles_m3:.6e} m3 in particles, {pending_m3:.1e} m3 pending (at most {pending_allowed_m3:.1e})"
    );
    let fed = format!(", {asked_m3:.6e} m3 to enter at a velocity, of which {ran_off_m3:.6e} m3 ran off");
    if *asked_m3 > 0.0 { held + &fed } else { held }
}

fn summary<'a>(scene: &'a Scene, run: &'a Run, threads: usize, [cpu_s, wall_s]: [f64; 2]) -> Summary<'a> {
    let limit = stable_limit(scene);
    let finite = |time: f64| Some(time).filter(|time| time.is_finite());
    let last = run.samples.last();
    let exact = Exact::of(scene);
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
        settlement_compressible_m: exact.zip(last).map(|(exact, s)| (exact.settlement)(s.stage_time)),
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

fn history(run: &Run) -> Vec<Row> {
    let row = |(number, s): (usize, &Sample)| {
        let (o, l) = (&s.state, &s.balance);
        let plates = plates(s, number.checked_sub(1).map(|before| &run.samples[before]));
        Row {
            time_s: o.time,
            stage: s.stage,
            stage_time_s: s.stage_time,
            step: s.step,
            settlement_m: o.settlement,
            mean_pressure_pa: o.mean_pressure,
            base_pressure_pa: o.base_pressure,
            max_speed_m_s: o.max_speed,
            checkerboard: o.checkerboard,
            solid_crossings: o.solid_crossings,
            water_crossings: o.water_crossings,
            solid_mass_kg: l.solid_mass_kg,
            solid_residual_kg: l.solid_residual_kg,
            water_stored_kg: l.water_stored_kg,
            water_in_kg: l.water_in_kg,
            water_out_kg: l.water_out_kg,
            water_residual_kg: l.water_residual_kg,
            momentum_n_s: l.momentum_n_s,
            impulse_n_s: l.impulse_n_s,
            momentum_residual_n_s: l.momentum_residual_n_s,
            kinetic_j: l.kinetic_j,
            strain_j: l.strain_j,
            water_j: l.water_j,
            external_work_j: l.external_work_j,
            gravity_work_j: l.gravity_work_j,
            flow_body_work_j: l.flow_body_work_j,
            darcy_dissipation_j: l.darcy_dissipation_j,
            damping_loss_j: l.damping_loss_j,
            energy_residual_j: l.energy_residual_j,
            water_particles_removed_kg: l.water_particles_removed_kg,
            base_friction_j: l.base_friction_j,
            centre_x_m: o.centre[0],
            centre_y_m: o.centre[1],
            reach_x_m: o.reach[0],
            reach_y_m: o.reach[1],
            plastic_dissipation_j: l.plastic_dissipation_j,
            yield_residual_max: l.yield_residual_max,
            cut_off_n_s: l.cut_off_n_s,
            transfer_loss_j: l.transfer_loss_j,
            momentum_carried_n_s: l.momentum_carried_n_s,
            soil_volume_m3: o.soil_volume,
            plates_x_n: plates.map(|force| force[0]),
            plates_y_n: plates.map(|force| force[1]),
        }
    };
    run.samples.iter().enumerate().map(row).collect()
}

/// Force of all plates that are moved, N: that now, or the mean since the sample before.
fn plates(now: &Sample, before: Option<&Sample>) -> Option<[f64; 2]> {
    let mut sum = [0.0; 2];
    for (i, push) in now.state.plates.iter().enumerate() {
        let then = before.map_or([0.0; 2], |before| before.state.plates[i].impulse);
        let time = now.state.time - before.map_or(0.0, |before| before.state.time);
        let mean = [0, 1].map(|d| if time > 0.0 { (push.impulse[d] - then[d]) / time } else { 0.0 });
        let force = push.force.unwrap_or(mean);
        (0..2).for_each(|d| sum[d] += force[d]);
    }
    (!now.state.plates.is_empty()).then_some(sum)
}

fn water(run: &Run) -> Vec<WaterLine> {
    let line = |s: &Sample| {
        let w = s.state.water?;
        Some(WaterLine {
            time_s: s.state.time,
            stage: s.stage,
            stage_time_s: s.stage_time,
            mobile_m3: w.mobile_m3,
            particles_m3: w.particles_m3,
            pending_m3: w.pending_m3,
            inflow_m3_s: w.inflow_m3_s,
            outflow_m3_s: w.outflow_m3_s,
            in_m3: w.in_m3,
            out_m3: w.out_m3,
            front_x_m: w.front_x_m,
            front_y_m: w.front_y_m,
            particles: w.particles,
            spawned: w.spawned,
            removed: w.removed,
            packing_mean: w.packing_mean,
            packing_max: w.packing_max,
            unsettled: w.unsettled,
            pending_allowed_m3: w.pending_allowed_m3,
            asked_m3: w.asked_m3,
            ran_off_m3: w.ran_off_m3,
        })
    };
    run.samples.iter().filter_map(line).collect()
}

fn field(run: &Run) -> Vec<FieldLine> {
    let lines = |s: &Sample| {
        let (time_s, stage, stage_time_s) = (s.state.time, s.stage, s.stage_time);
        let line = move |point: &mpm_core::observe::FieldPoint| FieldLine {
            time_s,
            stage,
            stage_time_s,
            x_m: point.x_m,
            y_m: point.y_m,
            pressure_pa: point.pressure_pa,
            saturation: point.saturation,
            soil: point.soil,
        };
        s.state.field.iter().map(line).collect::<Vec<_>>()
    };
    run.samples.iter().filter(|s| s.observed).flat_map(lines).collect()
}

fn profiles(run: &Run) -> Vec<ProfileLine> {
    let lines = |s: &Sample| {
        let (time_s, stage, stage_time_s) = (s.state.time, s.stage, s.stage_time);
        let line = move |row: &mpm_core::observe::ProfileRow| ProfileLine {
            time_s,
            stage,
            stage_time_s,
            height_m: row.height_m,
            material_height_m: row.material_height_m,
            pressure_pa: row.pressure_pa,
            effective_stress_pa: row.effective_stress_pa,
        };
        s.state.profile.iter().map(line).collect::<Vec<_>>()
    };
    run.samples.iter().filter(|s| s.observed).flat_map(lines).collect()
}

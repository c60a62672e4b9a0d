//! The summary of a run on the terminal: the quantities that matter, in convenient units.

use mpm_core::drive::Run;
use mpm_core::observe::{Trust, WaterState};
use mpm_core::scene::{Dimension, Integrator, Scene, Until};
use mpm_core::step::Work;
use mpm_verify::cases::own::applies::{self, Solution};
use mpm_verify::exact::terzaghi::Terzaghi;
use mpm_verify::exact::wetting_front::Way;
use mpm_verify::norms::LATE_TV;
use mpm_verify::report::solved::Exact;

use super::Summary;
use super::tables::plates;
use crate::commands::quantities::{self, flow, force, length, percent, stress};

/// Whether the last stage of an implicit run follows its waves.
fn last_stage_resolves(scene: &Scene) -> bool {
    let end = scene.stages.last().and_then(|stage| if let Until::Time(end) = stage.until { Some(end) } else { None });
    scene.resolves_waves(scene.observe_times.first().copied().or(end).unwrap_or(f64::INFINITY))
}

/// The quantities that matter, each on a line; those that are zero are left out.
pub fn lines(scene: &Scene, run: &Run, summary: &Summary) -> Vec<String> {
    let mut lines = Vec::new();
    let mut add = |what: &str, text: String| lines.push(format!("  {what:<24}{text}"));
    let (first, last) = (run.samples.first(), run.samples.last());
    if let Some(last) = last {
        let state = &last.state;
        consolidation(scene, run, &mut add);
        if state.settlement != 0.0 {
            add("settlement", length(state.settlement));
        }
        let run_out = first.map_or(0.0, |first| state.reach[0] - first.state.reach[0]);
        if scene.gravity.is_some() && run_out > 0.5 * scene.cell {
            add("run-out", format!("{}, to x = {}", length(run_out), length(state.reach[0])));
        }
        if state.base_pressure != 0.0 {
            let mean = stress(state.mean_pressure);
            add("pore pressure", format!("{} at the base, {mean} on average", stress(state.base_pressure)));
        }
        let before = run.samples.len().checked_sub(2).map(|before| &run.samples[before]);
        if let Some([x, y]) = plates(last, before).filter(|force| *force != [0.0; 2]) {
            add("force on the plates", format!("{} along x, {} along y", force(x), force(y)));
        }
        if let Some(water) = &state.water {
            seepage(scene, water, last.stage_time, &mut add);
        }
        if summary.plastic_dissipation_j > 0.0 {
            add("plastic dissipation", format!("{:.3e} J", summary.plastic_dissipation_j));
        }
    }
    if scene.integrator == Integrator::Implicit {
        let water = match (scene.water, scene.relative_acceleration, scene.darcy_inertia) {
            (None, ..) => "of the soil",
            (_, true, _) => "full model, water with an acceleration of its own",
            (_, false, true) => "u-p model, water accelerated with the soil",
            (_, false, false) => "u-p model, none in Darcy's law",
        };
        let waves = if last_stage_resolves(scene) { "resolved" } else { "damped" };
        add("inertia", format!("{water}; waves {waves}"));
    }
    if let Some(trust) = &summary.trust {
        let within = if trust.since_s.is_none() { "within their bounds" } else { "failed" };
        let Trust { balance, gap, allowed, unit, .. } = trust;
        let residual = format!("{:.1e} {unit} of {allowed:.1e} {unit}", gap.abs());
        add("balances", format!("{within}; largest residual: {balance}, {residual}"));
    }
    if let (true, Some(limit)) = (summary.forced, summary.limit_s) {
        add("forced time step", format!("{:.3e} s, above the stability limit of {limit:.3e} s", run.dt));
    }
    lines.extend(summary.notes.iter().map(|note| format!("  note: {note}")));
    let of = format!("{} particles of soil, {}", summary.solid_particles, work(run));
    let end = last.map_or(0.0, |s| s.state.time);
    let times = format!("{} simulated in {} of CPU time", quantities::time(end), quantities::time(summary.cpu_s));
    let verdict = if run.failure.is_some() { "failed" } else { "done" };
    lines.insert(0, format!("{}: {verdict}, {times}; {of}", scene.name));
    lines
}

/// What the solver did, in words.
fn work(run: &Run) -> String {
    let Work { accepted, rejected, factorisations, solves } = run.work;
    let rejected = if rejected > 0 { format!(" ({rejected} rejected)") } else { String::new() };
    let solver = format!("{factorisations} factorisations, {solves} solves");
    match run.steps.max(accepted) {
        steps if solves == 0 => format!("{steps} steps"),
        // The Krylov method has no steps: one basis for all times.
        _ if run.steps == 0 => solver,
        steps => format!("{steps} steps{rejected}, {solver}"),
    }
}

/// The exact settlement of a scene that consolidates: Terzaghi's problem and its like, or Mandel's.
fn exact(scene: &Scene) -> Option<Exact> {
    Exact::of(scene).or_else(|| match applies::solution(scene).ok()? {
        Solution::Block(mandel) => {
            Some(Exact { name: "Mandel", settlement: Box::new(move |time| mandel.settlement(time)), pressure: None })
        }
        _ => None,
    })
}

/// The degree of consolidation and its error, where an exact solution applies.
fn consolidation(scene: &Scene, run: &Run, add: &mut dyn FnMut(&str, String)) {
    let Some((exact, last)) = exact(scene).zip(run.samples.last()) else { return };
    let column = Terzaghi::incompressible(scene);
    let samples = run.samples.iter().filter(|s| s.observed && s.stage == last.stage && s.stage_time > 0.0);
    let pairs: Vec<[f64; 3]> = samples
        .map(|s| {
            let factor = column.map_or(f64::NAN, |column| column.time_factor(s.stage_time));
            [factor, s.state.settlement, (exact.settlement)(s.stage_time)]
        })
        .collect();
    // Under a load that changes in time the settlement passes through zero: its error is relative to the largest.
    let largest = pairs.iter().map(|[.., truth]| truth.abs()).fold(0.0, f64::max);
    let constant = scene.surcharge.is_some();
    let error = |[_, own, truth]: [f64; 3]| (own - truth).abs() / if constant { truth.abs() } else { largest };
    let errors: Vec<(f64, f64)> =
        pairs.iter().map(|pair| (pair[0], error(*pair))).filter(|(_, error)| error.is_finite()).collect();
    let whole = (exact.settlement)(1e30);
    if constant && whole > 0.0 {
        let [own, truth] = [last.state.settlement, (exact.settlement)(last.stage_time)].map(|s| s / whole);
        add("consolidation", format!("U = {own:.4}, exact {truth:.4}"));
    }
    let Some((tv, largest)) = errors.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1)) else { return };
    let at = if tv.is_finite() { format!(" at Tv = {tv:.2}") } else { String::new() };
    let late = errors.iter().filter(|(tv, _)| *tv >= LATE_TV * (1.0 - 1e-9)).map(|(_, error)| *error);
    let late = late.reduce(f64::max).map_or_else(String::new, |e| format!(", {} from Tv = {LATE_TV} on", percent(e)));
    let (what, of) = if constant { ("error of U", "") } else { ("error of settlement", " of the largest") };
    add(what, format!("at most {}{of}{at}{late} ({})", percent(largest), exact.name));
}

/// Discharge, and what else water with a free surface does.
fn seepage(scene: &Scene, water: &WaterState, time: f64, add: &mut dyn FnMut(&str, String)) {
    let against = |own: f64, truth: f64, of: &str| format!(" ({} from {of})", percent(own / truth - 1.0));
    let exact = applies::solution(scene).ok();
    let charny = scene.water.map(|water| water.hydraulic_conductivity).zip(exact.as_ref());
    let charny = charny.and_then(|(conductivity, exact)| match exact {
        Solution::Dam(dam) => Some(dam.discharge(conductivity)),
        _ => None,
    });
    let per = match scene.dimension {
        Dimension::Column => "m2",
        Dimension::PlaneStrain => "m",
        Dimension::Axisymmetric => "radian",
    };
    for (what, value) in [("inflow", water.inflow_m3_s), ("discharge", water.outflow_m3_s)] {
        let truth = charny.map_or_else(String::new, |truth| against(value, truth, "Charny's exact discharge"));
        if value > 0.0 {
            add(what, format!("{} per {per}{truth}", flow(value)));
        }
    }
    if let Some(Solution::Front(front)) = &exact {
        let place = match front.way {
            Way::Horizontal => water.front_x_m,
            Way::Up => water.front_y_m,
            Way::Down => f64::NAN,
        };
        let truth = front.position(time);
        if place.is_finite() {
            add("wetting front", format!("at {}{}", length(place), against(place, truth, "Green and Ampt")));
        }
    }
    add("water in the pores", format!("{:.4} m3 per {per}", water.mobile_m3));
    if water.ran_off_m3 > 0.0 {
        add("run-off", format!("{:.4} m3 of {:.4} m3 supplied", water.ran_off_m3, water.asked_m3));
    }
}

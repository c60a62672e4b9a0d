//! The summary of a run on the terminal: the quantities that matter, in convenient units.

use mpm_core::drive::Run;
use mpm_core::observe::{Trust, WaterState};
use mpm_core::scene::{Dimension, Integrator, Scene, Until};
use mpm_core::step::Work;
use mpm_verify::cases::own::applies::Solution;
use mpm_verify::cases::own::compared::{Beside, plates, share};
use mpm_verify::norms::LATE_TV;
use mpm_verify::report::numbers::short;

use super::Summary;
use crate::commands::quantities::{self, flow, force, length, percent, stress};

/// Whether the last stage of an implicit run follows its waves.
fn last_stage_resolves(scene: &Scene) -> bool {
    let end = scene.stages.last().and_then(|stage| if let Until::Time(end) = stage.until { Some(end) } else { None });
    scene.resolves_waves(scene.observe_times.first().copied().or(end).unwrap_or(f64::INFINITY))
}

/// The quantities that matter, each on a line; those that are zero are left out.
pub fn lines(scene: &Scene, run: &Run, summary: &Summary, exact: Option<&Solution>) -> Vec<String> {
    let mut lines = Vec::new();
    let mut add = |what: &str, text: String| lines.push(format!("  {what:<24}{text}"));
    let (first, last) = (run.samples.first(), run.samples.last());
    if let Some(last) = last {
        let state = &last.state;
        let settles = exact.is_some_and(|exact| exact.settlement(scene, last.stage_time).is_some_and(f64::is_finite));
        if let Some(exact) = exact {
            beside(scene, run, exact, &mut add);
        }
        if state.settlement != 0.0 && !settles {
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
            let steady = exact.is_some_and(|exact| exact.discharge(scene).is_some());
            seepage((scene, steady), water, &mut add);
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

/// The numbers beside the exact solution, where one applies, and the largest error of the settlement.
fn beside(scene: &Scene, run: &Run, exact: &Solution, add: &mut dyn FnMut(&str, String)) {
    for number in exact.numbers(scene, run) {
        let Beside { quantity, unit, computed, exact: truth } = &number;
        let unit = if unit == "–" { String::new() } else { format!(" {unit}") };
        let [computed, truth] = [computed, truth].map(|value| short(*value, 4));
        add(quantity, format!("{computed}{unit}, exact {truth}{unit} ({}; {})", share(number.error()), exact.name()));
    }
    let errors = exact.settlement_errors(scene, run);
    let Some((tv, largest)) = errors.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1)) else { return };
    let at = tv.map_or_else(String::new, |tv| format!(" at Tv = {tv:.2}"));
    let late =
        errors.iter().filter(|(tv, _)| tv.is_some_and(|tv| tv >= LATE_TV * (1.0 - 1e-9))).map(|(_, error)| *error);
    let late = late.reduce(f64::max).map_or_else(String::new, |e| format!(", {} from Tv = {LATE_TV} on", percent(e)));
    let of = if exact.final_settlement(scene).is_some() { "" } else { " of the largest" };
    add("error of settlement", format!("at most {}{of}{at}{late}", percent(largest)));
}

/// Lines on water with a free surface; its outflow stands above where the exact discharge of a steady flow is known.
fn seepage((scene, steady): (&Scene, bool), water: &WaterState, add: &mut dyn FnMut(&str, String)) {
    let per = match scene.dimension {
        Dimension::Column => "m2",
        Dimension::PlaneStrain => "m",
        Dimension::Axisymmetric => "radian",
    };
    for (what, value, is_new) in [("inflow", water.inflow_m3_s, true), ("outflow", water.outflow_m3_s, !steady)] {
        if value > 0.0 && is_new {
            add(what, format!("{} per {per}", flow(value)));
        }
    }
    add("water in the pores", format!("{:.4} m3 per {per}", water.mobile_m3));
    if water.ran_off_m3 > 0.0 {
        add("run-off", format!("{:.4} m3 of {:.4} m3 supplied", water.ran_off_m3, water.asked_m3));
    }
}

//! Soil that lets hardly any water through: the column of Table 1 under a sudden load, k from 1e-2 to 1e-12 m/s.
//!
//! With inertia it is compared with the exact u-p model, without it with Terzaghi's series for compressible water.

use mpm_core::drive::Sample;
use mpm_core::run::run;
use mpm_core::scene::{Dimension, Integrator, Scene, Start, Until, WaterProperties};
use mpm_core::stability::stable_limit;

use super::case::{Case, Point};
use super::scheme::{STANDING, Scheme};
use crate::error::Error::{self, Lacks};
use crate::exact::dynamic::DynamicColumn;
use crate::exact::terzaghi::Terzaghi;
use crate::norms::largest;

/// The case.
pub const CASE: Case = Case {
    name: "low-permeability",
    about: "Table 1's column under a sudden load, k from 1e-2 to 1e-12 m/s, 40 cells: settlement, pressure at the base and \
            checkerboard index beside the exact solution (u-p with inertia, Terzaghi without)",
    why: "At 1e-2 m/s waves hardly decay: what is left is the error of a step of first order in time. Near 1e-8 m/s \
          less than a cell has drained. Displacement and pressure of equal order (quasi-static B-splines) swing near \
          a drained end that is looked at early, by a quarter of p_0 with a tenth of the jump penalty they have. \
          Semi-implicit steps have no limit of stability in clay, but one of round-off: with steps a hundred times \
          longer runs fail.",
    parameter: "k (m/s)",
    column: "k_m_s",
    dimension: Dimension::Column,
    measures: "error, share of final settlement and of p_0",
    holds: 0.01,
    breaks: 0.2,
    schemes: &STANDING,
    run: |scheme| {
        CONDUCTIVITIES
            .iter()
            .map(|k| Point { at: *k, found: column(scheme, *k).and_then(|scene| error(&scene)) })
            .collect()
    },
};

const CONDUCTIVITIES: [f64; 11] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12];
/// Cells over the height.
const ROWS: usize = 40;
/// Steps after which a run with inertia ends: by then waves have passed an undrained column thousands of times.
const MOST_STEPS: f64 = 2e5;
/// Time factors that are looked at, as far as a run comes.
const FACTORS: [f64; 3] = [0.1, 0.3, 1.0];

/// The column with this conductivity (m/s); observed at time factors, or as far as the steps reach.
pub(super) fn column(scheme: &Scheme, conductivity: f64) -> Result<Scene, Error> {
    let scene = crate::scenes::terzaghi().edited(|scene| {
        scene.water = scene.water.map(|w| WaterProperties { hydraulic_conductivity: conductivity, ..w })
    })?;
    observed(scheme, scene, ROWS, MOST_STEPS)
}

/// A column with a scheme on so many cells, observed as far as so many steps reach.
pub(super) fn observed(scheme: &Scheme, scene: Scene, rows: usize, most_steps: f64) -> Result<Scene, Error> {
    let scene = scheme.on(&scene)?.edited(|scene| {
        (scene.cell, scene.cells[1], scene.history) = (scene.height / rows as f64, rows, 0);
        scene.tolerance = 1e-6;
        scene.start = Start::UndrainedEquilibrium;
    })?;
    let per_factor = scene.time_per_factor().unwrap_or(1.0);
    let reach = (most_steps * scene.safety * stable_limit(&scene)).min(per_factor);
    // What a step of first order in time does in its first hundred steps is a matter of the step alone.
    let early = 100.0 * scene.safety * stable_limit(&scene);
    let early = if early.is_finite() { early } else { 0.0 };
    let mut times: Vec<f64> = FACTORS.iter().map(|f| f * per_factor).collect();
    times.retain(|t| (early..0.99 * reach).contains(t));
    times.push(reach);
    if scene.integrator == Integrator::QuasiStatic {
        // A second after the load, too, however little has drained by then.
        times.extend((per_factor > 1.0).then_some(1.0));
        times.sort_by(f64::total_cmp);
        times.dedup();
    }
    Ok(scene.edited(|scene| {
        if let Some(stage) = scene.stages.last_mut() {
            stage.until = Until::Time(reach);
        }
        scene.observe_times = times;
    })?)
}

/// Largest error over the observed times: of the settlement as a share of q H/M, of the pressure at the base as a share
/// of p_0, and the checkerboard index.
///
/// # Errors
/// A run that could not be finished.
pub(super) fn error(scene: &Scene) -> Result<f64, Error> {
    error_beside(scene, scene)
}

/// The same, with the exact solution of another scene.
fn error_beside(scene: &Scene, other: &Scene) -> Result<f64, Error> {
    let quasi_static = scene.integrator == Integrator::QuasiStatic;
    let load = scene.surcharge.ok_or(Lacks("exact solution"))?.pressure;
    let whole = load * scene.height / scene.oedometer_modulus();
    let dynamic = DynamicColumn::new(other).ok_or(Lacks("exact solution"))?;
    let slow = Terzaghi::compressible(other).ok_or(Lacks("exact solution"))?;
    let lowest = if scene.shape.spline_degree().is_some() { 0.0 } else { 0.5 * scene.cell };
    let settled = |t: f64| if quasi_static { slow.settlement(t) } else { dynamic.settlement(t) };
    let pressed = |t: f64| if quasi_static { slow.pressure(lowest, t) } else { dynamic.base_pressure(t) };
    let run = run(scene, &mut |_| {})?.whole()?;
    let off = |s: &Sample| {
        let settlement = (s.state.settlement - settled(s.stage_time)) / whole;
        let pressure = (s.state.base_pressure - pressed(s.stage_time)) / scene.undrained_pressure();
        let profile: Vec<f64> = s.state.profile.iter().map(|r| r.pressure_pa).collect();
        largest([settlement, pressure, zigzag(&profile)].into_iter())
    };
    Ok(largest(run.observed().map(off)))
}

/// Share of a profile that alternates from cell to cell: the mean of `|p_{i-1} - 2 p_i + p_{i+1}|/4` over that of `|p|` where
/// two curvatures in a row have opposite signs; zero for a smooth profile.
fn zigzag(p: &[f64]) -> f64 {
    let bends: Vec<f64> = p.windows(3).map(|w| w[0] - 2.0 * w[1] + w[2]).collect();
    let alternating = |w: &[f64]| if w[0] * w[1] < 0.0 { w[0].abs().min(w[1].abs()) } else { 0.0 };
    let sum: f64 = bends.windows(2).map(alternating).sum();
    0.25 * sum / p.iter().map(|p| p.abs()).sum::<f64>().max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use mpm_core::scene::ShapeChoice;

    #[test]
    fn a_conductivity_five_percent_too_high_is_seen() {
        for (integrator, shape) in
            [(Integrator::QuasiStatic, ShapeChoice::Bspline2), (Integrator::SemiImplicit, ShapeChoice::Centre)]
        {
            let scene = column(&Scheme::new(integrator, shape), 1e-6).expect("a sound scene");
            let faster = |w: WaterProperties| WaterProperties { hydraulic_conductivity: 1.05e-6, ..w };
            let other = scene.edited(|s| s.water = scene.water.map(faster)).expect("a sound scene");
            let (right, wrong) = (error(&scene).expect("a run"), error_beside(&scene, &other).expect("a run"));
            assert!(right <= 0.2 * CASE.holds && wrong > CASE.holds, "{integrator:?}: {right} {wrong}");
        }
    }

    #[test]
    fn zigzags_are_told_from_slopes() {
        assert_eq!(zigzag(&[1.0, 0.9, 0.7, 0.4, 0.1]), 0.0);
        assert!((zigzag(&[1.0, -1.0, 1.0, -1.0, 1.0, -1.0]) - 0.5).abs() < 1e-12);
        assert!(zigzag(&[1.0, 1.1, 0.9, 1.1, 0.9, 1.1]) > 0.02);
    }
}

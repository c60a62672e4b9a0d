//! Two layers that differ by orders of magnitude, in conductivity or in stiffness: what each scheme and integrator makes
//! of them, against the exact solution.
//!
//! The column is `layers.toml` with its interface at half the height. The faster or stiffer half is the soil of Table 1,
//! the other one has its k or E divided by the ratio. Times are shares of that in which pressure passes the whole column,
//! `(sum h sqrt(s/kappa))^2`.

use mpm_core::drive::{Run, Sample};
use mpm_core::observe::ProfileRow;
use mpm_core::run::run;
use mpm_core::scene::{
    Dimension, Integrator, Scene, ShapeChoice, SoilLayer, StepChoice, StrainChoice, Surcharge, Until,
};
use mpm_core::stability::stable_limit;
use serde::{Deserialize, Serialize};

use super::case::{Case, Point};
use super::scheme::Scheme;
use crate::error::Error::{self, Lacks, Unfit};
use crate::exact::layered::Layered;
use crate::norms::{largest, relative};
use crate::study::word;

/// What jumps at the interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// Hydraulic conductivity k.
    Conductivity,
    /// Young's modulus E.
    Stiffness,
}

/// A jump: the value above the interface over the one below.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Contrast {
    /// Of what.
    pub quantity: Quantity,
    /// Above over below.
    pub ratio: f64,
}

/// A jump of k.
pub const fn conductivity(ratio: f64) -> Contrast {
    Contrast { quantity: Quantity::Conductivity, ratio }
}

/// A jump of E.
pub const fn stiffness(ratio: f64) -> Contrast {
    Contrast { quantity: Quantity::Stiffness, ratio }
}

/// Shares of the passage of the pressure at which a run is looked at.
pub const SHARES: [f64; 9] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0];
/// Steps beyond which a run is not tried.
pub const MOST_STEPS: f64 = 4e6;
/// Rows beside an interface that belong to it, in cells.
const BESIDE: f64 = 3.5;
/// Points of the exact solution from which its range in a row and its neighbours is taken.
const POINTS: u32 = 40;

/// What a run made of a contrast: a row of the matrix.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// Time integrator.
    pub integrator: String,
    /// Shape functions.
    pub scheme: String,
    /// What jumps.
    pub contrast: Contrast,
    /// Cell edge L, m.
    pub mesh_m: f64,
    /// Last share of the passage that was looked at.
    pub until: f64,
    /// Largest |S/S_exact - 1| over the times.
    pub settlement_error: f64,
    /// Largest RMS over the rows of p - p_exact, as a share of the largest p_0.
    pub pressure_error: f64,
    /// How far p is outside of the range of the exact one between the rows around, near the interface, at most, as a share
    /// of the largest p_0.
    pub outside: f64,
    /// Time steps, or basis vectors.
    pub steps: u64,
}

impl Found {
    /// The largest of the three errors.
    pub fn worst(&self) -> f64 {
        largest([self.settlement_error, self.pressure_error, self.outside].into_iter())
    }
}

/// k jumps.
pub const CONDUCTIVITY: Case = Case {
    name: "contrast-k",
    about: "two layers whose k differs by up to a million, either on top, 20 cells: settlement, pressures, and pressures near \
            the interface outside of the exact range, beside the exact solution",
    why: "A jump at a face is met by the harmonic mean of both cells. Large errors are of early looks, when the \
          pressure has not passed a cell of the slow layer. Explicit steps follow the fast layer and never reach the \
          end of the slow one.",
    parameter: "k ratio",
    column: "ratio",
    dimension: Dimension::Column,
    measures: "error, share of settlement and of the largest p_0",
    holds: 0.01,
    breaks: 0.2,
    schemes: &LAYERED,
    run: |scheme| points(scheme, Quantity::Conductivity, &[1.0, 10.0, 1e3, 1e6]),
};

/// E jumps.
pub const STIFFNESS: Case = Case {
    name: "contrast-e",
    about: "the same with E that differs by up to ten thousand",
    parameter: "E ratio",
    run: |scheme| points(scheme, Quantity::Stiffness, &[1.0, 10.0, 1e2, 1e4]),
    ..CONDUCTIVITY
};

/// Schemes that know layers.
const LAYERED: [Scheme; 12] = [
    Scheme::new(Integrator::Explicit, ShapeChoice::Centre),
    Scheme::new(Integrator::Explicit, ShapeChoice::Linear),
    Scheme::new(Integrator::Explicit, ShapeChoice::BBar),
    Scheme::new(Integrator::Explicit, ShapeChoice::Gimp),
    Scheme::new(Integrator::Explicit, ShapeChoice::Bspline2),
    Scheme::new(Integrator::SemiImplicit, ShapeChoice::Centre),
    Scheme::new(Integrator::SemiImplicit, ShapeChoice::Linear),
    Scheme::new(Integrator::SemiImplicit, ShapeChoice::BBar),
    Scheme::new(Integrator::SemiImplicit, ShapeChoice::Gimp),
    Scheme::new(Integrator::SemiImplicit, ShapeChoice::Bspline2),
    Scheme::new(Integrator::QuasiStatic, ShapeChoice::Centre),
    Scheme::new(Integrator::QuasiStatic, ShapeChoice::Bspline2),
];

/// Cells over the height.
const ROWS: usize = 20;
/// Steps that a run of the matrix has.
const REACH: f64 = 5e5;

/// The worse of both ways up for every ratio.
fn points(scheme: &Scheme, quantity: Quantity, ratios: &[f64]) -> Vec<Point> {
    let both = |ratio: f64| {
        let one = |ratio: f64| {
            let contrast = Contrast { quantity, ratio };
            let mut scene = scene(scheme.integrator, scheme.shape, contrast, ROWS, 1.0)?;
            // As far as the steps reach.
            let far = REACH * scene.safety * stable_limit(&scene);
            let needed = scene.observe_times.first().map_or(0.0, |first| REACH * first / far);
            let end = scene.observe_times.iter().copied().take_while(|time| *time <= far).last();
            let end = end
                .ok_or_else(|| Error::Found(format!("out of reach: {needed:.0e} steps for a hundredth of the time")))?;
            scene = scene.edited(|scene| {
                scene.observe_times.retain(|time| *time <= end);
                if let Some(stage) = scene.stages.last_mut() {
                    stage.until = Until::Time(end);
                }
            })?;
            let exact = Layered::of(&scene).ok_or(Unfit("not a column of layers"))?;
            measured(&scene, &exact, contrast, 1.0).map(|found| found.worst())
        };
        Ok(largest([one(ratio)?, one(1.0 / ratio)?].into_iter()))
    };
    ratios.iter().map(|ratio| Point { at: *ratio, found: both(*ratio) }).collect()
}

/// The scene of a contrast on a mesh of `rows` cells; observed at shares of the passage up to `until`.
///
/// # Errors
/// The built-in scene does not hold, which its own test excludes.
pub fn scene(
    integrator: Integrator,
    shape: ShapeChoice,
    contrast: Contrast,
    rows: usize,
    until: f64,
) -> Result<Scene, Error> {
    let quasi_static = integrator == Integrator::QuasiStatic;
    let mut scene = crate::scenes::built_in("layers")?.edited(|scene| {
        (scene.integrator, scene.shape, scene.history) = (integrator, shape, 0);
        (scene.cell, scene.cells[1], scene.dimension) = (scene.height / rows as f64, rows, Dimension::Column);
        (scene.tolerance, scene.step) = (1e-8, StepChoice::Auto);
        scene.darcy_inertia = !quasi_static;
        scene.strain = if quasi_static { StrainChoice::Small } else { StrainChoice::Large };
    })?;
    let [below, above] = if contrast.ratio > 1.0 { [1.0 / contrast.ratio, 1.0] } else { [1.0, contrast.ratio] };
    let soil = |share: f64, up_to: f64| {
        let mut layer = SoilLayer { up_to, soil: scene.soil() };
        match contrast.quantity {
            Quantity::Conductivity => layer.hydraulic_conductivity *= share,
            Quantity::Stiffness => layer.elastic.youngs_modulus *= share,
        }
        layer
    };
    scene = scene.edited(|scene| scene.layers = vec![soil(below, 0.5 * scene.height), soil(above, scene.height)])?;
    // A load that the softest layer bears; particles that move compare with a small-strain solution under one that hardly strains it.
    let softest = if contrast.quantity == Quantity::Stiffness { below.min(above) } else { 1.0 };
    let light = if quasi_static { softest } else { 0.01 * softest };
    scene = scene
        .edited(|scene| scene.surcharge = scene.surcharge.map(|s| Surcharge { pressure: light * s.pressure, ..s }))?;
    let passage = Layered::of(&scene).ok_or(Unfit("not a column of layers"))?.passage_time();
    let times: Vec<f64> = SHARES.iter().filter(|share| **share <= until).map(|share| share * passage).collect();
    let end = *times.last().ok_or(Lacks("time to look at"))?;
    Ok(scene.edited(|scene| {
        scene.observe_times = times;
        if let Some(stage) = scene.stages.last_mut() {
            stage.until = Until::Time(end);
        }
    })?)
}

/// Runs a contrast and compares it with the exact solution.
///
/// # Errors
/// More than [`MOST_STEPS`], a run that could not be finished.
pub fn measure(
    integrator: Integrator,
    shape: ShapeChoice,
    contrast: Contrast,
    rows: usize,
    until: f64,
) -> Result<Found, Error> {
    let scene = scene(integrator, shape, contrast, rows, until)?;
    let exact = Layered::of(&scene).ok_or(Unfit("not a column of layers"))?;
    measured(&scene, &exact, contrast, until)
}

/// [`measure`] with what it is compared with.
pub(crate) fn measured(scene: &Scene, exact: &Layered, contrast: Contrast, until: f64) -> Result<Found, Error> {
    Ok(found(&executed(scene)?, scene, exact, contrast, until))
}

/// Runs the scene of a contrast.
pub(crate) fn executed(scene: &Scene) -> Result<Run, Error> {
    let steps = steps(scene);
    if steps > MOST_STEPS {
        return Err(Error::Found(format!("{steps:.1e} steps")));
    }
    Ok(run(scene, &mut |_| {})?.whole()?)
}

/// What a run made of a contrast.
pub(crate) fn found(run: &Run, scene: &Scene, exact: &Layered, contrast: Contrast, until: f64) -> Found {
    let settlement = |s: &Sample| relative(s.state.settlement, exact.settlement(s.stage_time)).abs();
    let profile = |s: &Sample| profile_error(&s.state.profile, exact, s.stage_time);
    let outside = |s: &Sample| outside(&s.state.profile, exact, s.stage_time, scene.cell);
    Found {
        integrator: word(scene.integrator),
        scheme: word(scene.shape),
        contrast,
        mesh_m: scene.cell,
        until,
        settlement_error: largest(run.observed().map(settlement)),
        pressure_error: largest(run.observed().map(profile)),
        outside: largest(run.observed().map(outside)),
        steps: steps_of(run),
    }
}

/// Steps that a scene takes.
fn steps(scene: &Scene) -> f64 {
    scene.observe_times.last().copied().unwrap_or(0.0) / (scene.safety * stable_limit(scene))
}

fn steps_of(run: &Run) -> u64 {
    run.work.accepted.max(run.steps)
}

/// RMS of p - p_exact over the rows, as a share of the largest p_0.
fn profile_error(rows: &[ProfileRow], exact: &Layered, time: f64) -> f64 {
    let squares: f64 = rows.iter().map(|r| (r.pressure_pa - exact.pressure(r.material_height_m, time)).powi(2)).sum();
    (squares / rows.len() as f64).sqrt() / exact.largest_undrained()
}

/// How far the rows near an interface are outside of what the exact pressure is from a row below to a row above.
fn outside(rows: &[ProfileRow], exact: &Layered, time: f64, cell: f64) -> f64 {
    let interfaces = exact.interfaces();
    let near = |row: &&ProfileRow| interfaces.iter().any(|y| (row.material_height_m - y).abs() < BESIDE * cell);
    let of = |row: &ProfileRow| {
        let place = |i: u32| row.material_height_m + cell * (2.0 * f64::from(i) / f64::from(POINTS) - 1.0);
        let around = (0..=POINTS).map(|i| exact.pressure(place(i), time));
        let [low, high] = around.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], p| [l.min(p), h.max(p)]);
        (row.pressure_pa - high).max(low - row.pressure_pa).max(0.0)
    };
    largest(rows.iter().filter(near).map(of)) / exact.largest_undrained()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on_ten_cells(shape: ShapeChoice, contrast: Contrast) -> Found {
        measure(Integrator::QuasiStatic, shape, contrast, 10, 1.0).expect("a run that finishes")
    }

    #[test]
    fn contrasts_are_measured_and_judged() {
        let without = on_ten_cells(ShapeChoice::Bspline2, conductivity(1.0));
        let with = on_ten_cells(ShapeChoice::Bspline2, conductivity(1e6));
        assert!(without.settlement_error < 1e-5 && without.outside < 1e-5, "{without:?}");
        assert!(with.settlement_error < 2e-4 && (1e-3..1e-2).contains(&with.outside), "{with:?}");
        assert!(Found { settlement_error: f64::NAN, ..with.clone() }.worst().is_nan());
        assert_eq!(with.worst(), with.outside.max(with.pressure_error));
        let slow = scene(Integrator::Explicit, ShapeChoice::Centre, conductivity(1e-6), 20, 1.0).expect("a scene");
        let exact = Layered::of(&slow).expect("a column of layers");
        assert!(measured(&slow, &exact, conductivity(1e-6), 1.0).is_err_and(|e| e.to_string().ends_with("steps")));
    }

    #[test]
    fn what_is_outside_of_the_exact_range_is_seen() {
        let scene = scene(Integrator::QuasiStatic, ShapeChoice::Centre, conductivity(1e3), 20, 0.1).expect("a scene");
        let exact = Layered::of(&scene).expect("a column of layers");
        let (time, cell) = (scene.observe_times[2], scene.cell);
        let row = |height: f64, off: f64| ProfileRow {
            height_m: height,
            material_height_m: height,
            pressure_pa: exact.pressure(height, time) + off,
            effective_stress_pa: 0.0,
        };
        let rows: Vec<ProfileRow> = (0..20).map(|i| row((f64::from(i) + 0.5) * cell, 0.0)).collect();
        assert_eq!(outside(&rows, &exact, time, cell), 0.0);
        let mut bent = rows.clone();
        bent[9] = row(9.5 * cell, 0.5 * exact.largest_undrained());
        assert!(outside(&bent, &exact, time, cell) > 0.1);
        bent = rows;
        bent[2] = row(2.5 * cell, 0.5 * exact.largest_undrained());
        assert_eq!(outside(&bent, &exact, time, cell), 0.0, "far from the interface");
    }
}

//! The verification suite: one case per file, each with its scene, its exact solution, its norm, what it must show.

mod accepted;
mod automatic_step;
mod axisymmetric;
mod bar;
mod bits;
mod block;
mod boussinesq;
mod cam_clay;
mod collapse;
mod contrast;
mod coupled_field;
mod dam;
mod damped_column;
mod degree;
mod double_drainage;
mod dry_bar;
mod dynamic_column;
mod dynamic_energy;
mod elsewhere;
mod evidence;
mod fabric;
mod features;
mod footing;
mod ground;
mod hydrostatic;
mod infinite_slope;
mod large_strain;
mod large_strain_moving;
mod limit_equilibrium;
mod looks;
mod mandel;
mod mandel_inertia;
mod mandel_rise;
mod mohr_coulomb;
mod others;
mod outline;
pub mod own;
mod quasi_static;
mod ramp_load;
mod reduced_strength;
mod rest;
mod seepage;
mod self_weight;
mod semi_implicit;
mod setup;
mod slab;
mod spin;
mod stages;
mod strip;
mod terzaghi;
mod undrained;
mod undrained_wave;
mod verdict;
mod vortex;
mod water_ledger;
mod wells;
mod wetting;

use std::cell::Cell;

use cpu_time::ThreadTime;
use mpm_core::boundary::Given;
use mpm_core::drive::{Run, Sample};
use mpm_core::observe::balances;
use mpm_core::run::{StartError, run, run_given};
use mpm_core::scene::{Fields, Integrator, Scene};

pub use self::accepted::accepted;
pub use self::evidence::{Refinement, RefinementRow, SampleRow, Sampled, words};
pub use self::verdict::{CaseRow, Judged};
use self::verdict::{Outcome, judge};
use crate::error::Error::{self, Lacks, Unfit};
use crate::norms::largest;
use crate::study::word;

/// One case of the suite.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it shows, against what.
    pub about: &'static str,
    /// Runs it.
    run: fn() -> Result<Outcome, Error>,
    /// The same check with a fault planted, which it must find.
    pub mutant: Option<Mutant>,
}

/// A case with a fault planted in its input: a check that holds all the same is no check.
#[derive(Debug, Clone, Copy)]
pub struct Mutant {
    /// The fault.
    pub what: &'static str,
    /// Runs the check with it, on the meshes and with the requirements of the case.
    run: fn() -> Result<Outcome, Error>,
}

/// All cases, the simplest first.
pub const SUITE: &[Case] = &[
    hydrostatic::CASE,
    undrained::CASE,
    dry_bar::CASE,
    undrained_wave::ARRIVAL,
    undrained_wave::AMPLITUDE,
    dynamic_column::WITH_INERTIA,
    dynamic_column::WITHOUT_INERTIA,
    dynamic_energy::EXPLICIT,
    dynamic_energy::SEMI_IMPLICIT,
    damped_column::CASE,
    automatic_step::CASE,
    terzaghi::SURFACE,
    terzaghi::LINEAR,
    terzaghi::NODAL,
    terzaghi::GIMP,
    terzaghi::SPLINES,
    semi_implicit::AT_ITS_LIMIT,
    semi_implicit::CENTRE,
    semi_implicit::SPLINES,
    double_drainage::CASE,
    water_ledger::CASE,
    ramp_load::CASE,
    ramp_load::QUASI_STATIC,
    quasi_static::SPLINES,
    quasi_static::COARSE,
    quasi_static::CENTRE,
    quasi_static::PROFILE,
    quasi_static::CUBIC,
    quasi_static::STEPS,
    quasi_static::DISPLACED,
    quasi_static::SHIFTED,
    elsewhere::CASES[0],
    elsewhere::CASES[1],
    elsewhere::CASES[2],
    elsewhere::CASES[3],
    elsewhere::CASES[4],
    elsewhere::CASES[5],
    elsewhere::CASES[6],
    elsewhere::CASES[7],
    elsewhere::CASES[8],
    elsewhere::CASES[9],
    elsewhere::CASES[10],
    elsewhere::CASES[11],
    contrast::CONDUCTIVITY,
    contrast::CONDUCTIVITY_PROFILE,
    contrast::CONDUCTIVITY_CENTRE,
    contrast::CONDUCTIVITY_SEMI,
    contrast::CONDUCTIVITY_EXPLICIT,
    contrast::STIFFNESS,
    contrast::STIFFNESS_PROFILE,
    contrast::STIFFNESS_CENTRE,
    contrast::STIFFNESS_SEMI,
    contrast::STIFFNESS_EXPLICIT,
    large_strain::SPLINES,
    large_strain::LINEAR,
    large_strain::SPLINES_30,
    large_strain_moving::TO_20,
    large_strain_moving::TO_30,
    self_weight::EXPLICIT,
    self_weight::SEMI_IMPLICIT,
    self_weight::QUASI_STATIC,
    self_weight::CENTRE,
    self_weight::SOFT,
    mandel::SPLINES,
    mandel::CENTRE,
    mandel::PROFILE,
    mandel::CUBIC,
    mandel_rise::SPLINES,
    mandel_inertia::SEMI_IMPLICIT,
    mandel_inertia::EXPLICIT,
    mandel_rise::SEMI_IMPLICIT,
    mandel_rise::EXPLICIT,
    strip::CASE,
    strip::SUM,
    strip::CUBIC,
    spin::SPLINES,
    spin::GIMP,
    bar::PERIOD,
    bar::ENERGY,
    bar::PIC,
    vortex::SPLINES,
    vortex::GIMP,
    coupled_field::EXPLICIT,
    coupled_field::LINEAR,
    coupled_field::SEMI_IMPLICIT,
    coupled_field::STEPS,
    mohr_coulomb::ASSOCIATED,
    mohr_coulomb::NOT_ASSOCIATED,
    mohr_coulomb::PLANE_STRAIN,
    mohr_coulomb::TRIAXIAL,
    mohr_coulomb::FROM_K0,
    mohr_coulomb::ISOTROPIC,
    mohr_coulomb::OEDOMETER,
    footing::UNDRAINED,
    footing::PHI_20,
    footing::PHI_30,
    cam_clay::DRAINED,
    cam_clay::UNDRAINED,
    cam_clay::OEDOMETER,
    cam_clay::BY_PARTICLES,
    cam_clay::SOFT_LAYER,
    outline::CASE,
    rest::SPEED,
    rest::ENERGY,
    stages::CASES[0],
    stages::CASES[1],
    stages::CASES[2],
    stages::CASES[3],
    stages::CASES[4],
    stages::CASES[5],
    stages::CASES[6],
    stages::CASES[7],
    features::CASES[0],
    features::CASES[1],
    features::CASES[2],
    features::CASES[3],
    features::CASES[4],
    features::CASES[5],
    features::CASES[6],
    features::CASES[7],
    features::CASES[8],
    axisymmetric::CASES[0],
    axisymmetric::CASES[1],
    axisymmetric::CASES[2],
    axisymmetric::CASES[3],
    axisymmetric::CASES[4],
    ground::CASES[0],
    ground::CASES[1],
    ground::CASES[2],
    ground::CASES[3],
    ground::CASES[4],
    ground::CASES[5],
    ground::CASES[6],
    ground::CASES[7],
    ground::CASES[8],
    ground::CASES[9],
    ground::CASES[10],
    ground::CASES[11],
    ground::CASES[12],
    ground::CASES[13],
    ground::CASES[14],
    ground::CASES[15],
    ground::CASES[16],
    ground::CASES[17],
    ground::CASES[18],
    ground::CASES[19],
    ground::CASES[20],
    ground::CASES[21],
    ground::CASES[22],
    ground::CASES[23],
    wells::CASES[0],
    wells::CASES[1],
    wells::CASES[2],
    wells::CASES[3],
    wells::CASES[4],
    wells::CASES[5],
    wells::CASES[6],
    fabric::CASES[0],
    fabric::CASES[1],
    fabric::CASES[2],
    fabric::CASES[3],
    fabric::CASES[4],
    fabric::CASES[5],
    block::STICKS,
    block::STOPS,
    block::SLIDES,
    block::WEAKENS,
    slab::REMEMBERS,
    slab::SATURATED,
    slab::FREE_SURFACE,
    wetting::HORIZONTAL,
    wetting::DOWN,
    wetting::UP,
    wetting::MOIST,
    wetting::LEDGER,
    boussinesq::CASE,
    dam::DISCHARGE,
    dam::TAIL_WATER,
    dam::EXIT,
    dam::SURFACE,
    dam::STORED,
    seepage::DRAINS,
    seepage::RAIN,
    infinite_slope::ASSOCIATED,
    infinite_slope::WITHOUT_DILATION,
    reduced_strength::CASE,
    limit_equilibrium::CASE,
    collapse::DRY,
    collapse::SATURATED,
    bits::THREADS,
    bits::AGAIN,
    bits::RESUMED,
    bits::LEVEE,
    others::CASE,
];

impl Case {
    /// Runs and judges the case, and holds its error against the accepted one.
    ///
    /// # Errors
    /// A run of it could not be finished.
    pub fn judged(&self) -> Result<Judged, Error> {
        let mut judged = self.judge(self.run)?;
        accepted::compare(&mut judged);
        Ok(judged)
    }

    /// Runs and judges its mutant; `None` if it has none. Its baseline is left out: the check itself must find the fault.
    ///
    /// # Errors
    /// A run of it could not be finished: a fault must be found by the check, not by a run that stops.
    pub fn mutant_judged(&self) -> Option<Result<Judged, Error>> {
        self.mutant.map(|mutant| self.judge(mutant.run))
    }

    fn judge(&self, run: fn() -> Result<Outcome, Error>) -> Result<Judged, Error> {
        let clock = ThreadTime::now();
        MOMENTUM.set(None);
        let mut outcome = run().map_err(|e| e.of(self.name))?;
        let momentum = MOMENTUM.take();
        if let Some(missing) = momentum {
            outcome.notes.push(("momentum that is missing, over what may be".to_owned(), missing, "-".to_owned()));
        }
        let mut judged = judge(*self, outcome, clock.elapsed().as_secs_f64());
        if let Some(missing) = momentum.filter(|missing| missing.is_nan() || *missing > 1.0) {
            judged.sound = false;
            judged.fail(&format!("momentum does not close: {missing:.3e} times what may be missing"));
        }
        Ok(judged)
    }
}

/// Nothing planted: the case itself.
fn sound(_: &mut Fields) {}

/// The fault of most mutants with water: a conductivity 5 % too high.
const FASTER: &str = "conductivity 5 % too high";

/// Plants it.
fn faster(scene: &mut Fields) {
    if let Some(water) = &mut scene.water {
        water.hydraulic_conductivity *= 1.05;
    }
}

/// Lets the water of a scene pass more slowly, by a factor.
fn slower(scene: &mut Fields, factor: f64) {
    if let Some(water) = &mut scene.water {
        water.hydraulic_conductivity /= factor;
    }
}

/// `centre/face` and the like.
fn scheme(scene: &Scene) -> String {
    let shape = word(scene.shape);
    if scene.water.is_some() { format!("{shape}/{}", word(scene.darcy)) } else { shape }
}

/// `explicit` and the like.
fn integrator(scene: &Scene) -> String {
    word(scene.integrator)
}

/// What a quasi-static scene asks of its steps in time, by which its results may move; zero where steps are what they are.
fn asked(scene: &Scene) -> f64 {
    if scene.integrator == Integrator::QuasiStatic { scene.tolerance } else { 0.0 }
}

/// Runs a scene on several meshes: (mesh in m, largest error over the observed samples).
fn refine(base: &Scene, rows: &[usize], error: impl Fn(&Sample) -> f64) -> Result<Vec<(f64, f64)>, Error> {
    let on = |rows: &usize| {
        let scene = base.with_rows(*rows)?;
        Ok((scene.cell, largest(finished(&scene)?.observed().map(&error))))
    };
    rows.iter().map(on).collect()
}

thread_local! {
    /// The largest gap of momentum in the runs of a case, over what may be; nothing before one with inertia.
    static MOMENTUM: Cell<Option<f64>> = const { Cell::new(None) };
}

/// Notes the momentum that is missing in a run. Fields without words in a scene are not known to the bounds.
fn note_momentum(scene: &Scene, run: &Run) {
    if run.trust.is_none() {
        return;
    }
    for sample in &run.samples {
        let all = balances(scene, run.dt, sample.step, &sample.state, &sample.balance);
        for balance in all.iter().filter(|balance| balance.name == "momentum" && balance.gap != 0.0) {
            let missing = balance.gap.abs() / balance.allowed;
            let larger = |known: f64| if missing <= known { known } else { missing };
            MOMENTUM.set(Some(MOMENTUM.get().map_or(missing, larger)));
        }
    }
}

/// Runs a scene to its end.
fn finished(scene: &Scene) -> Result<Run, Error> {
    let run = whole(run(scene, &mut |_| {}))?;
    note_momentum(scene, &run);
    Ok(run)
}

/// The same with fields that scenes have no words for.
fn finished_given(scene: &Scene, given: &Given) -> Result<Run, Error> {
    whole(run_given(scene, given, &mut |_| {}))
}

/// A run that has come to its end.
fn whole(run: Result<Run, StartError>) -> Result<Run, Error> {
    Ok(run?.whole()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique() {
        let mut names: Vec<&str> = SUITE.iter().map(|case| case.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), SUITE.len());
    }

    #[test]
    fn quick_mutants_are_caught() {
        for name in ["hydrostatic", "dry-bar", "quasi-static-coarse", "quasi-static-profile", "ramp-load"] {
            let case = SUITE.iter().find(|case| case.name == name).expect("a case");
            let judged = case.mutant_judged().expect("a mutant").expect("runs that finish");
            assert!(!judged.row.passed(), "{name}: {}", judged.reason);
        }
    }
}

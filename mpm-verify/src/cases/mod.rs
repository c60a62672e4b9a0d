//! The verification suite: one case per file, each with its scene, its exact solution, its norm, what it must show.

mod bar;
mod bits;
mod cam_clay;
mod collapse;
mod coupled_field;
mod footing;
pub(crate) mod infinite_slope;
mod limit_equilibrium;
mod mandel_inertia;
mod mandel_rise;
mod mohr_coulomb;
mod others;
mod outline;
pub mod own;
mod rain_on_slope;
mod reduced_strength;
mod refraction;
mod rest;
mod slopes;
pub(crate) mod spin;
mod strip;
pub mod suite;
mod vortex;
mod wetting;

use mpm_core::scene::Fields;

pub use self::suite::{Case, suite};
use crate::error::Error::{self, Lacks, Unfit};
use crate::experiment::run::{asked, finished, finished_given, integrator, scheme, whole};
use crate::experiment::verdict::Outcome;
#[cfg(test)]
use crate::experiment::verdict::{Judged, Named};

/// A case that a function runs, because its runs are none of a scene alone.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Program {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it shows, against what.
    pub about: &'static str,
    /// Runs it.
    pub run: fn() -> Result<Outcome, Error>,
    /// The same check with a fault planted, which it must find.
    pub mutant: Option<Mutant>,
}

/// A case with a fault planted in its input: a check that passes all the same is no check.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mutant {
    /// The fault.
    pub what: &'static str,
    /// Runs the check with it, on the meshes and with the requirements of the case.
    pub run: fn() -> Result<Outcome, Error>,
}

/// All cases that functions run.
const PROGRAMS: &[Program] = &[
    mandel_rise::SPLINES,
    mandel_inertia::SEMI_IMPLICIT,
    mandel_inertia::EXPLICIT,
    mandel_rise::SEMI_IMPLICIT,
    mandel_rise::EXPLICIT,
    strip::CASE,
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
    mohr_coulomb::FADING,
    footing::UNDRAINED,
    footing::PHI_20,
    footing::PHI_30,
    cam_clay::DRAINED,
    cam_clay::UNDRAINED,
    cam_clay::OEDOMETER,
    outline::CASE,
    rest::SPEED,
    rest::ENERGY,
    refraction::CASE,
    rain_on_slope::CASE,
    slopes::ACADS_1C,
    slopes::FALLING_WATER,
    slopes::DAVIS,
    slopes::SIMILAR,
    wetting::BALANCE,
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

#[cfg(test)]
impl Program {
    fn named(&self) -> Named {
        Named { name: self.name, about: self.about, mutant: self.mutant.map(|mutant| mutant.what) }
    }

    fn judged(&self) -> Result<Judged, Error> {
        suite::judged(self.named(), self.run)
    }

    fn mutant_judged(&self) -> Option<Result<Judged, Error>> {
        self.mutant.map(|mutant| suite::judged(self.named(), mutant.run))
    }
}

/// The explicit step takes stress and pressure of its start: an error of first order in the step.
const FIRST_ORDER: Option<f64> = Some(1.0);
/// Differences between runs of half the step.
const HALVINGS: u32 = 4;
/// Particles per cell in two dimensions; a column has the square root.
const PARTICLE_COUNTS: [usize; 4] = [1, 4, 9, 16];

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

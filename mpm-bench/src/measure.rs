//! One setting: what it finds and how much memory it takes, once; its CPU time, many times.
//!
//! What is timed is a whole solve from checked scene to U at the nine sample times, set-up included. Memory is counted
//! in a run of its own; the timed runs opt out of the counting.

use std::hint::black_box;

use allocation_counter::{measure, opt_out};
use cpu_time::ThreadTime;
use mpm_core::drive::Run;
use mpm_core::run::{StartError, run};
use mpm_core::scene::{Scene, StrainChoice, TimeMethod};
use mpm_verify::error::Error;
use mpm_verify::exact::terzaghi::Terzaghi;
use mpm_verify::norms::{SAMPLE_TV, largest, relative};
use mpm_verify::study::{Case, Variant, word};

use crate::baseline::{self, FiniteVolumes, Soil};
use crate::row::{Found, MOVING};
use crate::setting::{Setting, Solver};

/// A sample of time is the mean over so many runs that it lasts this long, s: the clock itself needs a third of a microsecond.
const SAMPLE: f64 = 1e-3;
/// Samples per visit.
const SAMPLES: usize = 7;
/// CPU time after which a visit takes no further sample, s.
const PATIENCE: f64 = 0.06;
/// A run this long is a sample itself, s: warming up and counting memory are no longer seen.
pub const LONG: f64 = 0.05;

/// Leaves the vector registers as a fresh process has them.
///
/// A run that ends with something in their upper halves makes all scalar arithmetic after it slower, up to 2.4 times as
/// was seen, until code for wide registers clears them on its return. Without this a setting would be charged with what
/// was run before it.
fn clear_registers() {
    let mut numbers = black_box([1.0_f64; 32]);
    pulp::Arch::new().dispatch(|| numbers.iter_mut().for_each(|n| *n = *n * 1.5 + 0.25));
    black_box(numbers);
}

/// Some timed runs of a setting.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Times {
    /// CPU time of a run in each sample, s.
    pub samples: Vec<f64>,
    /// Runs in all samples.
    pub runs: u64,
}

/// What a solver gives back.
#[expect(clippy::large_enum_variant, reason = "there is one at a time, and a box would be timed with it")]
enum Outcome {
    Points(Result<Run, StartError>),
    Volumes(Vec<f64>),
}

impl Setting {
    fn solve(&self) -> Outcome {
        match &self.solver {
            Solver::Points(scene) => Outcome::Points(run(scene, &mut |_| {})),
            Solver::Volumes(volumes, soil) => Outcome::Volumes(volumes.solve(soil)),
        }
    }

    /// Runs the setting, compares it with the exact solutions of `base`, counts its memory and times it.
    ///
    /// # Errors
    /// A setting that cannot be run at all. A run that fails is found to have failed.
    pub fn first_visit(&self, base: &Scene) -> Result<(Found, Times), Error> {
        let mut outcome = None;
        let clock = ThreadTime::now();
        let memory = measure(|| outcome = Some(self.solve()));
        let took = clock.elapsed().as_secs_f64();
        let found = match (&self.solver, outcome) {
            (Solver::Points(scene), Some(Outcome::Points(Ok(run)))) => self.compare(scene, &run)?,
            (Solver::Points(_), Some(Outcome::Points(Err(e)))) => return Err(Error::from(e).of(&self.case)),
            (Solver::Volumes(volumes, soil), Some(Outcome::Volumes(u))) => volumes.compare(soil, base, &u)?,
            _ => return Err(Error::Unfit("nothing was run").of(&self.case)),
        };
        let found = Found { peak_bytes: memory.bytes_max, ..found };
        let times = if took >= LONG { Times { samples: vec![took], runs: 1 } } else { self.times() };
        Ok((found, times))
    }

    /// Times the setting.
    pub fn times(&self) -> Times {
        let mut times = Times::default();
        opt_out(|| {
            let rough = self.time(1);
            if rough >= LONG {
                times = Times { samples: vec![rough], runs: 1 };
                return;
            }
            let batch = (SAMPLE / rough.max(1e-9)).ceil().max(1.0) as u64;
            let mut spent = 0.0;
            while times.samples.len() < SAMPLES && spent < PATIENCE {
                let sample = self.time(batch);
                spent += sample * batch as f64;
                times.samples.push(sample);
                times.runs += batch;
            }
        });
        times
    }

    /// CPU time per run of some runs, s.
    fn time(&self, runs: u64) -> f64 {
        let clock = ThreadTime::now();
        for _ in 0..runs {
            clear_registers();
            black_box(black_box(self).solve());
        }
        clock.elapsed().as_secs_f64() / runs as f64
    }

    fn compare(&self, scene: &Scene, run: &Run) -> Result<Found, Error> {
        let case = Case { name: self.case.clone(), variant: Variant::Base, scene: scene.clone() };
        let result = case.compare(run, f64::NAN)?;
        let chosen = scene.integrator.solves_displacements();
        let moves = chosen && scene.strain == StrainChoice::Large;
        let method = match scene.method {
            _ if !chosen || moves => String::new(),
            // A linear scene.
            TimeMethod::Auto => word(TimeMethod::Krylov),
            given => word(given),
        };
        Ok(Found {
            integrator: if moves { format!("{}{MOVING}", result.integrator) } else { result.integrator },
            scheme: result.scheme,
            mesh_m: result.mesh_m,
            ppc: result.ppc,
            dt_or_tol: if chosen { scene.tolerance } else { result.dt_s },
            max_error_terzaghi: result.max_error_terzaghi,
            max_error_compressible: result.max_error_compressible,
            steps: result.steps,
            solves: result.solves,
            peak_bytes: 0,
            particles: result.particles,
            dimension: result.dimension,
            method,
            failure: result.failure,
        })
    }
}

impl FiniteVolumes {
    fn compare(&self, soil: &Soil, base: &Scene, u: &[f64]) -> Result<Found, Error> {
        let exact = [Terzaghi::incompressible(base), Terzaghi::compressible(base)];
        let [Some(terzaghi), Some(compressible)] = exact else {
            return Err(Error::Unfit("expected a loaded wet column"));
        };
        let error = |exact: &Terzaghi| {
            let at = |(tv, u): (&f64, &f64)| relative(*u, exact.relative_settlement(tv * soil.time_per_factor));
            largest(SAMPLE_TV.iter().zip(u).map(at))
        };
        Ok(Found {
            integrator: baseline::NAME.to_owned(),
            scheme: self.kind.scheme().to_owned(),
            mesh_m: soil.height / self.cells as f64,
            ppc: 0,
            dt_or_tol: self.step(soil),
            max_error_terzaghi: error(&terzaghi),
            max_error_compressible: error(&compressible),
            steps: self.steps as u64,
            solves: self.steps as u64,
            peak_bytes: 0,
            particles: self.cells,
            dimension: "column".to_owned(),
            method: "bdf2".to_owned(),
            failure: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::plan::Plan;

    #[test]
    fn a_visit_finds_errors_memory_and_times() {
        let base = mpm_verify::scenes::terzaghi();
        let plan = Plan::new(&base, true).expect("a plan");
        for case in ["quasi-static-bspline2-L0.1-ppc9-tol1e-4", "baseline-graded-cells30-steps180"] {
            let setting = plan.settings.iter().find(|s| s.case == case).expect("a setting of the plan");
            let (found, times) = setting.first_visit(&base).expect("a run");
            assert!(found.max_error_compressible < 3e-3 && found.max_error_terzaghi > 0.02, "{found:?}");
            assert!(found.peak_bytes > 200 && found.failure.is_none() && !times.samples.is_empty());
            let (again, _) = setting.first_visit(&base).expect("a run");
            assert_eq!(again, found, "all but time is the same again");
        }
    }
}

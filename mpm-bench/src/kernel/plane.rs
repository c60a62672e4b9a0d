//! What a quasi-static solve in plane strain takes as its mesh gets finer: Mandel's problem, all of its times from one
//! factorisation, set-up included.

use cpu_time::ThreadTime;
use mpm_core::run::run;
use mpm_verify::error::Error;
use mpm_verify::exact::mandel::Mandel;
use mpm_verify::rates::fit;
use mpm_verify::report::numbers::exact;
use mpm_verify::scenes::built_in;
use serde::{Deserialize, Serialize};

use super::sizes::{Effort, spread};

/// Cells per side, of a whole measurement and of a look.
const SIDES: [usize; 5] = [8, 16, 32, 64, 128];
/// From so many cells per side on growth is fitted: below, what does not grow weighs too much.
const FITTED_FROM: usize = 16;
/// A solve that takes longer is timed once, s.
const LONG: f64 = 0.5;

/// Columns of `plane_solves.csv`.
pub const COLUMNS: &str = "cells_per_side,unknowns,max_error_settlement,cpu_s,basis_vectors,bytes";

/// One solve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Solve {
    /// Cells per side.
    pub side: usize,
    /// Unknowns.
    pub unknowns: usize,
    /// Largest relative error of the settlement of the plate against the exact solution, at the times of the scene.
    pub error: f64,
    /// Median CPU time, s.
    pub cpu_s: f64,
    /// Vectors of the Krylov basis.
    pub vectors: u64,
    /// Bytes held.
    pub bytes: usize,
}

impl Solve {
    /// The fields of `plane_solves.csv`.
    pub fn fields(&self) -> Vec<String> {
        vec![
            self.side.to_string(),
            self.unknowns.to_string(),
            exact(self.error),
            exact(self.cpu_s),
            self.vectors.to_string(),
            self.bytes.to_string(),
        ]
    }
}

/// Solves on finer and finer meshes; `say` hears of every one.
///
/// # Errors
/// A solve that fails.
pub fn measure(quick: bool, effort: Effort, say: &dyn Fn(&str)) -> Result<Vec<Solve>, Error> {
    let sides = if quick { &SIDES[..3] } else { &SIDES[..] };
    sides.iter().map(|side| solve(*side, effort, say)).collect()
}

fn solve(side: usize, effort: Effort, say: &dyn Fn(&str)) -> Result<Solve, Error> {
    let scene = built_in("mandel")?.edited(|scene| {
        scene.cell = scene.width / side as f64;
        (scene.cells, scene.history) = ([side; 2], 0);
    })?;
    let exact = Mandel::new(&scene).ok_or(Error::Unfit("the scene is not Mandel's problem"))?;
    say(&format!("quasi-static in plane strain: {side} x {side} cells"));
    let mut cpu = Vec::new();
    loop {
        let clock = ThreadTime::now();
        let run = run(&scene, &mut |_| {})?.whole()?;
        cpu.push(clock.elapsed().as_secs_f64());
        if cpu.len() < effort.samples && cpu[0] < LONG {
            continue;
        }
        let off = |s: &mpm_core::drive::Sample| (s.state.settlement / exact.settlement(s.stage_time) - 1.0).abs();
        return Ok(Solve {
            side,
            unknowns: unknowns(side),
            error: run.observed().map(off).fold(0.0, f64::max),
            cpu_s: spread(&cpu)[0],
            vectors: run.work.accepted,
            bytes: run.bytes,
        });
    }
}

/// Two displacements and a pressure per function, without those that rollers and the drained side fix; the plate moves as one.
fn unknowns(side: usize) -> usize {
    let functions = side + 2; // of quadratic splines
    3 * functions * functions - 4 * functions + 1
}

/// Exponent n of CPU time ~ (unknowns)^n; `None` of too few solves.
pub fn exponent(solves: &[Solve]) -> Option<f64> {
    let fitted = solves.iter().filter(|s| s.side >= FITTED_FROM);
    let points: Vec<(f64, f64)> = fitted.map(|s| (s.unknowns as f64, s.cpu_s)).collect();
    fit(&points).map(|fit| fit.order)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_solve_is_as_good_as_its_mesh_and_growth_is_that_of_a_power() {
        let effort = Effort { point_steps: 0, warm_up: 0, samples: 2 };
        let solve = solve(8, effort, &|_| {}).expect("a solve");
        assert!(solve.error < 2e-5 && solve.unknowns == 261 && solve.vectors > 3, "{solve:?}");
        assert_eq!(solve.fields().len(), COLUMNS.split(',').count());
        let power = |side: usize| {
            let unknowns = unknowns(side);
            Solve { side, unknowns, cpu_s: (unknowns as f64).powf(1.5), ..solve.clone() }
        };
        let solves = [8, 16, 32, 64].map(power);
        assert!(exponent(&solves).is_some_and(|n| (n - 1.5).abs() < 1e-9));
        assert_eq!(exponent(&solves[..1]), None);
    }
}

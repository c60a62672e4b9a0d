//! Time per point-step from 1e3 to 1e6 points: the plain kernel, the vectorised one, and that on two threads.
//!
//! All kernels of a size take turns, sample by sample and each time another one first, so that other load on the machine
//! falls on all alike. They take the same number of steps in all, and must end with the same bits.

use std::num::NonZero;
use std::time::Instant;

use cpu_time::ThreadTime;
use mpm_core::hardware::{Hardware, THREADS_PAY_FROM, Width, instructions};
use mpm_core::run::model_on;
use mpm_core::scene::Scene;
use mpm_core::stability::choose_step;
use mpm_core::step::Model;
use serde::{Deserialize, Serialize};

use crate::block;
use mpm_verify::error::Error;

/// The step written plainly, one particle after the other.
pub const PLAIN: &str = "plain";
/// The step over as many lanes as the machine has.
pub const LANES: &str = "lanes";
/// The same over the four lanes of AVX2, on a machine that has more.
pub const FOUR: &str = "four lanes";

/// Cells across and up, 4 points in each: 1e3, 1e4, 1e5 and 1e6 points.
pub const FEW: [[usize; 2]; 4] = [[5, 50], [50, 50], [250, 100], [500, 500]];
/// The same with 2e4, 3e4 and 5e4 points, where a second thread may begin to pay.
pub const ALL: [[usize; 2]; 7] = [[5, 50], [50, 50], [50, 100], [75, 100], [125, 100], [250, 100], [500, 500]];
/// Up to so many points the mesh is one strip, whose sums are those of the plain kernel to the last bit.
const ONE_STRIP: usize = 2000;
/// Largest difference of settlements, as a share, where several strips add up in another order.
const ROUND_OFF: f64 = 1e-9;

/// How much is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Point-steps of a sample.
    pub point_steps: usize,
    /// As much again, so many times, before each sample: a core that had nothing to do takes some hundredths of a second
    /// to be as fast as in the middle of a run.
    pub warm_up: usize,
    /// Samples.
    pub samples: usize,
}

impl Effort {
    /// For figures to be quoted.
    pub const FULL: Self = Self { point_steps: 4_000_000, warm_up: 2, samples: 9 };
    /// For a look.
    pub const QUICK: Self = Self { point_steps: 400_000, warm_up: 2, samples: 5 };
}

/// Columns of `kernel_sizes.csv`.
pub const COLUMNS: &str = "kernel,instructions,threads,points,steps_per_sample,samples,wall_ns,wall_low_ns,\
wall_high_ns,cpu_ns,speed_up,speed_up_low,speed_up_high,default,settlement_bits";

/// What a kernel takes at one size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// [`PLAIN`], [`LANES`] or [`FOUR`].
    pub kernel: String,
    /// Vector instructions.
    pub instructions: String,
    /// Threads.
    pub threads: usize,
    /// Solid particles.
    pub points: usize,
    /// Steps of a sample.
    pub steps: u64,
    /// Samples.
    pub samples: usize,
    /// Time on the clock per point-step, ns: median, least, most.
    pub wall_ns: [f64; 3],
    /// Median CPU time per point-step, ns; of one thread only.
    pub cpu_ns: Option<f64>,
    /// Time on the clock of the same kernel on one thread over that on these, sample by sample: median, least, most.
    pub speed_up: Option<[f64; 3]>,
    /// Whether a run of this size takes it unless told otherwise.
    pub default: bool,
    /// Bits of the settlement after all samples.
    pub settlement_bits: u64,
}

impl Timing {
    /// Whether it is of a kernel on so many threads.
    pub fn is(&self, kernel: &str, threads: usize) -> bool {
        self.kernel == kernel && self.threads == threads
    }

    /// The fields of `kernel_sizes.csv`.
    pub fn fields(&self) -> Vec<String> {
        use mpm_verify::report::numbers::exact;
        let mut fields = vec![
            self.kernel.clone(),
            self.instructions.clone(),
            self.threads.to_string(),
            self.points.to_string(),
            self.steps.to_string(),
            self.samples.to_string(),
        ];
        fields.extend(self.wall_ns.map(exact));
        fields.push(exact(self.cpu_ns.unwrap_or(f64::NAN)));
        fields.extend(self.speed_up.unwrap_or([f64::NAN; 3]).map(exact));
        fields.push(self.default.to_string());
        fields.push(format!("{:016x}", self.settlement_bits));
        fields
    }
}

/// A kernel that is measured, with the samples so far.
struct Contender {
    kernel: &'static str,
    instructions: String,
    threads: usize,
    model: Box<dyn Model>,
    wall: Vec<f64>,
    cpu: Vec<f64>,
}

/// Threads that the machine runs at once.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, NonZero::get)
}

/// Measures a block of so many cells. Also gives back the vectorised model on one thread.
///
/// # Errors
/// A step that fails, or kernels that do not find the same.
pub fn measure(cells: [usize; 2], effort: Effort) -> Result<(Vec<Timing>, Box<dyn Model>), Error> {
    let scene = block(cells)?;
    let dt = choose_step(&scene)?;
    let points = scene.solid_particles();
    let steps = (effort.point_steps / points).max(1) as u64;
    let mut contenders = Vec::new();
    let all = hardware(points).map_err(|e| e.of("threads"))?;
    for (kernel, instructions, hardware) in all {
        let mut model = model_on(&hardware, &scene)?;
        model.enter_stage(&scene.stages[0], &[])?;
        let threads = hardware.thread_count();
        contenders.push(Contender { kernel, instructions, threads, model, wall: Vec::new(), cpu: Vec::new() });
    }
    for sample in 0..effort.samples {
        for turn in 0..contenders.len() {
            let place = (sample + turn) % contenders.len();
            let contender = &mut contenders[place];
            // All contenders do as many steps, so that they end in the same state.
            for _ in 0..effort.warm_up {
                contender.model.advance(dt, steps, &mut 0)?;
            }
            let (wall, cpu) = (Instant::now(), ThreadTime::now());
            contender.model.advance(dt, steps, &mut 0)?;
            let per = 1e9 / (steps as f64 * points as f64);
            contender.cpu.push(cpu.elapsed().as_secs_f64() * per);
            contender.wall.push(wall.elapsed().as_secs_f64() * per);
        }
    }
    let settlements: Vec<(&str, f64)> = contenders.iter().map(|c| (c.kernel, c.model.observe().0.settlement)).collect();
    same(&settlements, points)?;
    let alone = contenders.iter().position(|c| c.kernel == LANES && c.threads == 1);
    let alone = alone.ok_or(Error::Unfit("the vectorised kernel was not measured"))?;
    let one_thread = contenders[alone].wall.clone();
    let by_default = if points >= THREADS_PAY_FROM { cores().min(2) } else { 1 };
    let timings = contenders.iter().zip(&settlements).map(|(c, (_, settlement))| Timing {
        kernel: c.kernel.to_owned(),
        instructions: c.instructions.clone(),
        threads: c.threads,
        points,
        steps,
        samples: effort.samples,
        wall_ns: spread(&c.wall),
        cpu_ns: (c.threads == 1).then(|| spread(&c.cpu)[0]),
        speed_up: (c.threads > 1).then(|| speed_up(&one_thread, &c.wall)),
        default: c.kernel == LANES && c.threads == by_default,
        settlement_bits: settlement.to_bits(),
    });
    Ok((timings.collect(), contenders.swap_remove(alone).model))
}

/// Median CPU time per point-step (ns) of a scene, vectorised on one thread, and the bytes of its data.
///
/// # Errors
/// A step that fails.
pub fn alone(scene: &Scene, effort: Effort) -> Result<(f64, usize), Error> {
    let dt = choose_step(scene)?;
    let mut model = model_on(&Hardware::default(), scene)?;
    model.enter_stage(&scene.stages[0], &[])?;
    let points = model.solid_count();
    let steps = (effort.point_steps / points).max(1) as u64;
    let mut cpu = Vec::with_capacity(effort.samples);
    for _ in 0..effort.samples {
        for _ in 0..effort.warm_up {
            model.advance(dt, steps, &mut 0)?;
        }
        let clock = ThreadTime::now();
        model.advance(dt, steps, &mut 0)?;
        cpu.push(clock.elapsed().as_secs_f64() * 1e9 / (steps as f64 * points as f64));
    }
    Ok((spread(&cpu)[0], model.bytes()))
}

/// What is compared at a size.
fn hardware(points: usize) -> Result<Vec<(&'static str, String, Hardware)>, Error> {
    let widest = instructions().to_owned();
    let mut all =
        vec![(PLAIN, "none".to_owned(), Hardware::plain(Width::One)), (LANES, widest.clone(), Hardware::default())];
    if cores() > 1 {
        all.push((LANES, widest.clone(), Hardware::threads(2)?));
    }
    if points <= ONE_STRIP && widest.contains("AVX-512") {
        all.push((FOUR, "AVX2, 4 lanes".to_owned(), Hardware::plain(Width::Four)));
    }
    Ok(all)
}

/// Checks the settlements (m) of several kernels after the same steps: those that are vectorised must be the same to the last
/// bit whatever their width and threads; the plain one too where there is one strip, and but for round-off elsewhere.
///
/// # Errors
/// Which ones differ, and by how much.
pub fn same(settlements: &[(&str, f64)], points: usize) -> Result<(), Error> {
    let Some((_, over_lanes)) = settlements.iter().find(|(kernel, _)| *kernel == LANES) else { return Ok(()) };
    for (kernel, settlement) in settlements {
        let allowed = if *kernel == PLAIN && points > ONE_STRIP { ROUND_OFF } else { 0.0 };
        let differs = settlement.to_bits() != over_lanes.to_bits();
        let apart = (settlement / over_lanes - 1.0).abs();
        if differs && (apart.is_nan() || apart > allowed || allowed == 0.0) {
            let found =
                format!("the {kernel} kernel settles {settlement:e} m, expected {over_lanes:e} m as vectorised");
            return Err(Error::Found(found).of(format!("{points} points")));
        }
    }
    Ok(())
}

/// Median, least and most.
pub fn spread(samples: &[f64]) -> [f64; 3] {
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => [f64::NAN; 3],
        n => [0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]), sorted[0], sorted[n - 1]],
    }
}

/// How many times faster: of samples that were taken in turn, so that both of a pair saw the same load.
pub fn speed_up(before: &[f64], after: &[f64]) -> [f64; 3] {
    spread(&before.iter().zip(after).map(|(b, a)| b / a).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_speed_ups_are_those_of_the_samples() {
        assert_eq!(spread(&[3.0, 1.0, 2.0]), [2.0, 1.0, 3.0]);
        assert_eq!(spread(&[4.0, 1.0, 2.0, 3.0]), [2.5, 1.0, 4.0]);
        assert!(spread(&[])[0].is_nan());
        // A disturbance that hits both of a pair is none of the speed-up.
        assert_eq!(speed_up(&[8.0, 80.0, 9.0], &[4.0, 40.0, 6.0]), [2.0, 1.5, 2.0]);
    }

    #[test]
    fn kernels_that_differ_in_a_bit_are_noticed() {
        let settled = 1.234e-3_f64;
        let next = f64::from_bits(settled.to_bits() + 1);
        for (kernel, points, passes) in
            [(PLAIN, 1000, false), (PLAIN, 10_000, true), (LANES, 10_000, false), (FOUR, 1000, false)]
        {
            assert_eq!(same(&[(LANES, settled), (kernel, next)], points).is_ok(), passes, "{kernel} {points}");
            assert!(same(&[(LANES, settled), (kernel, settled)], points).is_ok());
        }
        assert!(same(&[(LANES, settled), (PLAIN, 1.0001 * settled)], 10_000).is_err());
        assert!(same(&[(LANES, settled), (PLAIN, f64::NAN)], 10_000).is_err());
    }

    #[test]
    fn every_kernel_is_measured_and_all_find_the_same() {
        let effort = Effort { point_steps: 3000, warm_up: 1, samples: 3 };
        let (timings, mut lanes) = measure(FEW[0], effort).expect("timings");
        assert_eq!(lanes.solid_count(), 1000);
        let found = |kernel: &str, threads| timings.iter().find(|t| t.is(kernel, threads));
        let (plain, one) = (found(PLAIN, 1).expect("plain"), found(LANES, 1).expect("lanes"));
        assert_eq!(plain.settlement_bits, one.settlement_bits);
        assert!(one.default && !plain.default && one.cpu_ns.is_some_and(|ns| ns > 0.0) && one.speed_up.is_none());
        if let Some(two) = found(LANES, 2) {
            assert!(two.cpu_ns.is_none() && two.speed_up.is_some_and(|s| s[1] <= s[0] && s[0] <= s[2]));
        }
        for timing in &timings {
            assert_eq!(timing.fields().len(), COLUMNS.split(',').count());
            assert_eq!((timing.steps, timing.samples), (3, 3));
        }
        // One more step, and the check fails.
        lanes.advance(1e-7, 1, &mut 0).expect("a step");
        let settled = f64::from_bits(plain.settlement_bits);
        assert!(same(&[(LANES, settled), (PLAIN, lanes.observe().0.settlement)], 1000).is_err());
    }
}

//! What times are ratios to: a kernel of sums and products that never changes, timed beside whatever is timed.

use cpu_time::ThreadTime;

/// Numbers in the vectors: they fit into the smallest cache.
const LENGTH: usize = 1024;
/// Passes over them.
const PASSES: usize = 4000;
/// Times it is done; the median counts.
const REPETITIONS: usize = 5;

/// CPU time of the kernel, s.
pub fn time() -> f64 {
    let mut times: Vec<f64> = (0..REPETITIONS)
        .map(|_| {
            let clock = ThreadTime::now();
            std::hint::black_box(kernel(std::hint::black_box(1.0)));
            clock.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[REPETITIONS / 2]
}

/// `y = (x + y)/2` and `x = 1 - y/4`, over and over, and the sum in the end: both tend to 0.8, with no number too small or too
/// large to be quick.
fn kernel(start: f64) -> f64 {
    let (mut x, mut y) = ([start; LENGTH], [0.0; LENGTH]);
    for _ in 0..PASSES {
        for (x, y) in x.iter_mut().zip(&mut y) {
            *y = 0.5 * (*x + *y);
            *x = 1.0 - 0.25 * *y;
        }
    }
    y.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernel_does_its_work() {
        assert!((kernel(1.0) - 0.8 * LENGTH as f64).abs() < 1e-9 && time() > 0.0);
    }
}

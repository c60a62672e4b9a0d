//! What times are ratios to: a kernel of sums and products that never changes, timed beside whatever is timed. Load on the machine only
//! lengthens a time, so the shortest of several is the one that says most.

use cpu_time::ThreadTime;

/// Numbers in the vectors: they fit into the smallest cache.
const LENGTH: usize = 1024;
/// Passes over them.
const PASSES: usize = 4000;
/// Times it is done, and so is what is timed.
const REPETITIONS: usize = 7;

/// Shortest CPU time of some work over the shortest one of the kernel, both timed in turns.
///
/// # Errors
/// The work failed.
pub fn ratio<E>(mut work: impl FnMut() -> Result<(), E>) -> Result<f64, E> {
    let mut shortest = [f64::INFINITY; 2];
    for _ in 0..REPETITIONS {
        let clock = ThreadTime::now();
        std::hint::black_box(kernel(std::hint::black_box(1.0)));
        let between = clock.elapsed();
        work()?;
        let times = [between, clock.elapsed() - between].map(|time| time.as_secs_f64());
        shortest = [shortest[0].min(times[0]), shortest[1].min(times[1])];
    }
    Ok(shortest[1] / shortest[0])
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
        assert!((kernel(1.0) - 0.8 * LENGTH as f64).abs() < 1e-9);
        let ratio = ratio(|| {
            std::hint::black_box(kernel(std::hint::black_box(1.0)));
            Ok::<_, ()>(())
        });
        assert!(ratio.is_ok_and(|ratio| (0.3..3.0).contains(&ratio)));
    }
}

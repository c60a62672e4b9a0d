//! What the machine can do, measured: multiplications with additions, divisions, and bytes in and out.
//!
//! The best of several samples counts: a limit is what was reached once, and other load can only lower it.

use std::hint::black_box;
use std::time::Instant;

use pulp::{Arch, Simd, WithSimd};

use super::sizes::Effort;

/// Chains of each kind that do not wait for each other. With their two constants they fit the 16 registers of AVX2, and
/// they are enough to keep two units with a delay of three cycles busy.
const CHAINS: usize = 6;
/// Operations of each chain in a sample.
const LENGTH: usize = 100_000;
/// Bytes in and out of a sample of bandwidth, unless the array is larger.
const MOVED: usize = 100_000_000;

/// What the machine can do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Machine {
    /// Multiplications and additions, half of each and not fused, 1/ns.
    pub operations_per_ns: f64,
    /// Divisions, 1/ns.
    pub divisions_per_ns: f64,
    /// Bytes read and written, half of each, 1/ns.
    pub bytes_per_ns: f64,
}

impl Machine {
    /// Measures one thread, with `bytes` of data.
    pub fn measure(bytes: usize, effort: Effort) -> Self {
        let arch = Arch::new();
        let (chains, divisions) = (Chains { factor: 1.0, step: 1e-9 }, Divisions { divisor: 1.0 });
        let mut numbers = vec![1.0; bytes / size_of::<f64>()];
        let passes = (MOVED / (2 * bytes).max(1)).max(1);
        let best = |work: f64, sample: &mut dyn FnMut()| {
            let mut most = 0.0_f64;
            for _ in 0..effort.samples {
                let start = Instant::now();
                sample();
                most = most.max(work / start.elapsed().as_nanos() as f64);
            }
            most
        };
        let lanes = arch.dispatch(Count) as f64;
        Self {
            operations_per_ns: best(2.0 * lanes * (CHAINS * LENGTH) as f64, &mut || {
                black_box(arch.dispatch(black_box(chains)));
            }),
            divisions_per_ns: best(lanes * (CHAINS * LENGTH) as f64, &mut || {
                black_box(arch.dispatch(black_box(divisions)));
            }),
            bytes_per_ns: best((2 * size_of::<f64>() * passes * numbers.len()) as f64, &mut || {
                for _ in 0..passes {
                    arch.dispatch(Update { numbers: black_box(&mut numbers), factor: black_box(1.0) });
                }
            }),
        }
    }
}

/// How many lanes there are.
struct Count;

impl WithSimd for Count {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> usize {
        S::F64_LANES
    }
}

/// As many multiplications as additions, in registers alone.
#[derive(Clone, Copy)]
struct Chains {
    factor: f64,
    step: f64,
}

impl WithSimd for Chains {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let (factor, step) = (simd.splat_f64s(self.factor), simd.splat_f64s(self.step));
        let mut products = [simd.splat_f64s(1.0); CHAINS];
        let mut sums = products;
        for _ in 0..LENGTH {
            for chain in 0..CHAINS {
                products[chain] = simd.mul_f64s(products[chain], factor);
                sums[chain] = simd.add_f64s(sums[chain], step);
            }
        }
        let all = products.iter().chain(&sums).copied().reduce(|a, b| simd.add_f64s(a, b));
        all.map_or(f64::NAN, |all| simd.reduce_sum_f64s(all))
    }
}

/// Divisions, in registers alone.
#[derive(Clone, Copy)]
struct Divisions {
    divisor: f64,
}

impl WithSimd for Divisions {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let divisor = simd.splat_f64s(self.divisor);
        let mut quotients = [simd.splat_f64s(1.0); CHAINS];
        for _ in 0..LENGTH {
            for quotient in &mut quotients {
                *quotient = simd.div_f64s(*quotient, divisor);
            }
        }
        let all = quotients.iter().copied().reduce(|a, b| simd.add_f64s(a, b));
        all.map_or(f64::NAN, |all| simd.reduce_sum_f64s(all))
    }
}

/// Every number read, changed and written back.
struct Update<'a> {
    numbers: &'a mut [f64],
    factor: f64,
}

impl WithSimd for Update<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let factor = simd.splat_f64s(self.factor);
        let (vectors, rest) = S::as_mut_simd_f64s(self.numbers);
        for vector in vectors {
            *vector = simd.mul_f64s(*vector, factor);
        }
        rest.iter_mut().for_each(|number| *number *= self.factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_chain_is_faster_than_its_links_one_after_the_other() {
        // An addition takes a cycle and a division four at least, and no processor has 6 GHz yet. Work that the
        // compiler takes out of the loop is faster than that; how fast the rest is depends on processor and profile.
        let fastest = 6.0 * (CHAINS * Arch::new().dispatch(Count)) as f64;
        let machine = Machine::measure(1 << 16, Effort { point_steps: 0, warm_up: 0, samples: 2 });
        let possible = |measured: f64, limit: f64| measured > 1e-3 && measured < limit;
        assert!(possible(machine.operations_per_ns, 2.0 * fastest), "{machine:?}");
        assert!(possible(machine.divisions_per_ns, fastest / 4.0), "{machine:?}");
        assert!(possible(machine.bytes_per_ns, 2.0 * 64.0 * 6.0), "{machine:?}");
    }

    #[test]
    fn chains_really_multiply_and_add() {
        let sum = Arch::new().dispatch(Chains { factor: 1.0, step: 1.0 });
        let lanes = Arch::new().dispatch(Count) as f64;
        assert_eq!(sum, lanes * CHAINS as f64 * (LENGTH as f64 + 2.0));
    }
}

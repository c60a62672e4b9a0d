//! Threads and SIMD width of a run. They change its time and none of its numbers.

use std::num::NonZero;
use std::sync::Arc;

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use crate::scene::Scene;

/// How many numbers are computed at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Width {
    /// As many as the CPU has, detected when the run starts.
    #[default]
    Widest,
    /// One, without special instructions.
    One,
    /// Four, with AVX2 where there is some.
    Four,
    /// Eight, with AVX-512 where there is some.
    Eight,
}

/// Threads and vectors of a run.
#[derive(Debug, Clone, Default)]
pub struct Hardware {
    /// Numbers computed at once.
    pub width: Width,
    /// Threads; the caller's own without a pool.
    pub pool: Option<Arc<ThreadPool>>,
}

impl Hardware {
    /// One thread and vectors of a given width.
    pub fn plain(width: Width) -> Self {
        Self { width, pool: None }
    }

    /// So many threads, and the widest vectors.
    ///
    /// # Errors
    /// The system gives no threads.
    pub fn threads(threads: usize) -> Result<Self, ThreadPoolBuildError> {
        if threads <= 1 {
            return Ok(Self::default());
        }
        let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
        Ok(Self { width: Width::Widest, pool: Some(Arc::new(pool)) })
    }
}

/// Soil points from which on a second thread pays: below, it waits longer for its work than the work takes.
pub const THREADS_PAY_FROM: usize = 10_000;

impl Hardware {
    /// What suits a scene: so many threads, or all if they shorten the run. Steps that solve for
    /// displacements use one alone.
    ///
    /// # Errors
    /// As [`Hardware::threads`].
    pub fn suiting(scene: &Scene, threads: Option<usize>) -> Result<Self, ThreadPoolBuildError> {
        if scene.integrator.solves_displacements() {
            return Ok(Self::default());
        }
        let pays = scene.solid_particles() >= THREADS_PAY_FROM;
        let all = || std::thread::available_parallelism().map_or(1, NonZero::get);
        Self::threads(threads.unwrap_or_else(|| if pays { all() } else { 1 }))
    }

    /// How many threads.
    pub fn thread_count(&self) -> usize {
        self.pool.as_ref().map_or(1, |pool| pool.current_num_threads())
    }
}

/// Instructions that [`Width::Widest`] uses on this CPU.
pub fn instructions() -> &'static str {
    match pulp::Arch::new() {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        pulp::Arch::V4(_) => "AVX-512, 8 lanes",
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        pulp::Arch::V3(_) => "AVX2, 4 lanes",
        #[cfg(target_arch = "aarch64")]
        pulp::Arch::Neon(_) => "NEON, 2 lanes",
        _ => "none, 1 lane",
    }
}

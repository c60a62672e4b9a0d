//! What a step costs: the explicit step in plane strain by size, threads and vectors, where its time goes, and how far
//! it is from what the machine can do; and what a quasi-static solve costs by its unknowns.
//!
//! # Reading order
//! 1. [`sizes`]: time per point-step from 1e3 to 1e6 points, by the plain kernel, vectorised, and on two threads; that
//!    all of them find the same bits.
//! 2. [`stages`]: which stage of a step takes how much of it.
//! 3. [`operations`], [`traffic`]: arithmetic and bytes of a step, counted. [`machine`]: what the machine can do of
//!    both, measured. [`limits`]: how far the step is from either.
//! 4. [`plane`]: quasi-static solves in plane strain as the mesh gets finer.
//! 5. [`kept`]: what was measured by the same build is not measured again.
//!
//! One point-step is one solid particle with its water particle, one step.

pub mod kept;
pub mod limits;
pub mod machine;
pub mod operations;
pub mod plane;
pub mod sizes;
pub mod stages;
pub mod traffic;

use serde::{Deserialize, Serialize};

use limits::Limit;
use mpm_verify::cost;
use mpm_verify::error::Error;
use plane::Solve;
use sizes::{Effort, Timing};
use stages::Share;

/// Everything that was measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Kernel {
    /// Vector instructions of the vectorised kernel.
    pub instructions: String,
    /// Threads that the machine runs at once.
    pub cores: usize,
    /// Edge of the cells, m.
    pub cell_m: f64,
    /// Time by kernel and size.
    pub timings: Vec<Timing>,
    /// Time by stage, vectorised, on one thread.
    pub shares: Vec<Share>,
    /// How far the vectorised kernel is from what the machine can do.
    pub limits: Vec<Limit>,
    /// Quasi-static solves, coarse to fine.
    pub solves: Vec<Solve>,
}

/// Measures; `say` hears of every size.
///
/// # Errors
/// A step that fails, or kernels that do not find the same.
pub fn measure(quick: bool, say: &dyn Fn(&str)) -> Result<Kernel, Error> {
    let effort = if quick { Effort::QUICK } else { Effort::FULL };
    // A debug build may as well not wait for a million points: its times say nothing.
    let sizes: &[[usize; 2]] = match (cfg!(debug_assertions), quick) {
        (true, _) => &sizes::FEW[..2],
        (false, true) => &sizes::FEW,
        (false, false) => &sizes::ALL,
    };
    let (mut timings, mut shares, mut limits) = (Vec::new(), Vec::new(), Vec::new());
    for (place, cells) in sizes.iter().enumerate() {
        let (found, mut lanes) = sizes::measure(*cells, effort)?;
        let points = lanes.solid_count();
        say(&format!("what a step costs: {points} points"));
        if place == 0 || place + 1 == sizes.len() {
            shares.extend(stages::profile(lanes.as_mut(), effort));
            let measured = found.iter().find(|t| t.is(sizes::LANES, 1)).and_then(|t| t.cpu_ns);
            let machine = machine::Machine::measure(lanes.bytes(), effort);
            limits.extend(measured.map(|ns| Limit::new(true, points, ns, &machine)));
            let (dry, bytes) = sizes::alone(&cost::dry(*cells)?, effort)?;
            limits.push(Limit::new(false, points, dry, &machine::Machine::measure(bytes, effort)));
        }
        timings.extend(found);
    }
    Ok(Kernel {
        instructions: mpm_core::hardware::instructions().to_owned(),
        cores: sizes::cores(),
        cell_m: crate::block(sizes::FEW[0])?.cell,
        timings,
        shares,
        limits,
        solves: plane::measure(quick || cfg!(debug_assertions), effort, say)?,
    })
}

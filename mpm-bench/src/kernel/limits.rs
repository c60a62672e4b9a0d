//! How far the vectorised step is from what arithmetic and memory of the machine allow, one thread.
//!
//! Neither limit can be reached: a step also loads what it calculates with, keeps more numbers than there are registers,
//! and chooses. Divisions run beside the rest, so the longer of both counts as arithmetic.

use mpm_verify::report::numbers::exact;
use serde::{Deserialize, Serialize};

use super::machine::Machine;
use super::{operations, traffic};

/// Points of a cell in the blocks that are measured.
const PPC: usize = 4;

/// Soil with water in its pores, and without.
pub const WET: &str = "with water";
/// See [`WET`].
pub const DRY: &str = "dry";

/// Columns of `kernel_limits.csv`.
pub const COLUMNS: &str = "points,operations,divisions,bytes,operations_per_ns,divisions_per_ns,bytes_per_ns,\
arithmetic_ns,memory_ns,measured_ns,nearer_limit,times_the_limit,kernel";

/// A step beside what the machine allows. Times and counts are per point-step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Limit {
    /// What soil it is for: [`WET`] or [`DRY`].
    pub kernel: String,
    /// Solid particles.
    pub points: usize,
    /// Multiplications and additions.
    pub operations: f64,
    /// Divisions.
    pub divisions: f64,
    /// Bytes read and written.
    pub bytes: f64,
    /// What the machine does of each, 1/ns.
    pub per_ns: [f64; 3],
    /// Least time for the arithmetic, ns.
    pub arithmetic_ns: f64,
    /// Least time for the bytes with data of this size, ns.
    pub memory_ns: f64,
    /// CPU time of the step, ns.
    pub measured_ns: f64,
}

impl Limit {
    /// The limits for soil with water or without, and a size, and the measured CPU time per point-step (ns).
    pub fn new(water: bool, points: usize, measured_ns: f64, machine: &Machine) -> Self {
        let [operations, divisions] = operations::per_point(PPC, water);
        let bytes = traffic::per_point(PPC, water).iter().sum::<f64>();
        let kernel = if water { WET } else { DRY }.to_owned();
        let per_ns = [machine.operations_per_ns, machine.divisions_per_ns, machine.bytes_per_ns];
        let arithmetic_ns = (operations / per_ns[0]).max(divisions / per_ns[1]);
        let memory_ns = bytes / per_ns[2];
        Self { kernel, points, operations, divisions, bytes, per_ns, arithmetic_ns, memory_ns, measured_ns }
    }

    /// The limit that is nearer: its name and time (ns).
    pub fn nearer(&self) -> (&'static str, f64) {
        if self.arithmetic_ns > self.memory_ns {
            ("arithmetic", self.arithmetic_ns)
        } else {
            ("memory", self.memory_ns)
        }
    }

    /// How many times the nearer limit the step takes.
    pub fn times(&self) -> f64 {
        self.measured_ns / self.nearer().1
    }

    /// The fields of `kernel_limits.csv`.
    pub fn fields(&self) -> Vec<String> {
        let mut fields = vec![self.points.to_string()];
        let counts = [self.operations, self.divisions, self.bytes].into_iter().chain(self.per_ns);
        fields.extend(counts.chain([self.arithmetic_ns, self.memory_ns, self.measured_ns]).map(exact));
        fields.extend([self.nearer().0.to_owned(), exact(self.times()), self.kernel.clone()]);
        fields
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearer_limit_is_the_longer_time() {
        let machine = Machine { operations_per_ns: 84.0, divisions_per_ns: 1.25, bytes_per_ns: 358.0 };
        let limit = Limit::new(true, 1000, 6.0, &machine);
        assert_eq!((limit.arithmetic_ns, limit.memory_ns), (2.0, 1.0));
        assert_eq!((limit.nearer(), limit.times()), (("arithmetic", 2.0), 3.0));
        let limit = Limit::new(true, 1000, 6.0, &Machine { bytes_per_ns: 89.5, divisions_per_ns: 0.625, ..machine });
        assert_eq!((limit.arithmetic_ns, limit.memory_ns), (2.0, 4.0), "divisions beside the rest");
        assert_eq!((limit.nearer(), limit.times()), (("memory", 4.0), 1.5));
        assert_eq!(limit.fields().len(), COLUMNS.split(',').count());
    }
}

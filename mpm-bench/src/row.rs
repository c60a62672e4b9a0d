//! What is kept of a setting: how it was run, its error, its cost.

use mpm_verify::report::numbers::exact;
use mpm_verify::study::or_nan;
use serde::{Deserialize, Serialize};

/// What follows the name of an integrator whose mesh moves with the soil.
pub const MOVING: &str = " (moving mesh)";

/// What one run of a setting finds; the same at every repetition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// Time integrator, or `baseline`.
    pub integrator: String,
    /// Shape functions, or `finite-volume`.
    pub scheme: String,
    /// Cell edge L, m.
    pub mesh_m: f64,
    /// Particles per cell; 0 for the baseline.
    pub ppc: usize,
    /// Time step (s), or the tolerance of runs that choose their steps.
    pub dt_or_tol: f64,
    /// Largest error against incompressible water; NaN for a failed run.
    #[serde(deserialize_with = "or_nan")]
    pub max_error_terzaghi: f64,
    /// Largest error against compressible water; NaN for a failed run.
    #[serde(deserialize_with = "or_nan")]
    pub max_error_compressible: f64,
    /// Steps; of the Krylov method basis vectors.
    pub steps: u64,
    /// Solves with a factored matrix.
    pub solves: u64,
    /// Most heap memory held at a time by the solve and its result, bytes.
    pub peak_bytes: u64,
    /// Solid particles, or cells of the baseline.
    pub particles: usize,
    /// `column` or `plane-strain`.
    pub dimension: String,
    /// `krylov` or `sdirk`, `bdf2`; empty for given steps.
    pub method: String,
    /// Why the run failed, if it did.
    pub failure: Option<String>,
}

/// A setting with its cost: a line of `speed_against_error.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub struct Row {
    pub case: String,
    pub integrator: String,
    pub scheme: String,
    pub mesh_m: f64,
    pub ppc: usize,
    pub dt_or_tol: f64,
    pub max_error_terzaghi: f64,
    pub max_error_compressible: f64,
    /// Median CPU time of a whole solve, set-up included, s.
    pub cpu_s: f64,
    pub steps: u64,
    pub solves: u64,
    /// CPU time over steps and particles (cells for the baseline), ns.
    pub ns_per_point_step: f64,
    pub peak_bytes: u64,
    pub particles: usize,
    pub dimension: String,
    /// Smallest and largest of the timed samples, s.
    pub cpu_low_s: f64,
    pub cpu_high_s: f64,
    /// Solves timed.
    pub runs: u64,
    pub method: String,
    /// Whether nothing of its kind is both cheaper and as accurate.
    pub pareto: bool,
    pub failure: Option<String>,
}

/// Columns of `speed_against_error.csv`. Others parse them: columns are only ever added at the end.
pub const COLUMNS: &str = "case,integrator,scheme,mesh_m,ppc,dt_or_tol,max_error_terzaghi,max_error_compressible,cpu_s,\
steps,solves,ns_per_point_step,peak_bytes,particles,dimension,cpu_low_s,cpu_high_s,runs,method,pareto,failure";

impl Row {
    /// A row from what was found and the sorted times of its samples, s.
    pub fn new(case: &str, found: &Found, times: &[f64], runs: u64) -> Self {
        let f = found.clone();
        let at = |k: usize| times.get(k).copied().unwrap_or(f64::NAN);
        let cpu_s = at(times.len() / 2);
        Self {
            case: case.to_owned(),
            integrator: f.integrator,
            scheme: f.scheme,
            mesh_m: f.mesh_m,
            ppc: f.ppc,
            dt_or_tol: f.dt_or_tol,
            max_error_terzaghi: f.max_error_terzaghi,
            max_error_compressible: f.max_error_compressible,
            cpu_s,
            steps: f.steps,
            solves: f.solves,
            ns_per_point_step: 1e9 * cpu_s / (f.steps.max(1) as f64 * f.particles as f64),
            peak_bytes: f.peak_bytes,
            particles: f.particles,
            dimension: f.dimension,
            cpu_low_s: at(0),
            cpu_high_s: at(times.len().saturating_sub(1)),
            runs,
            method: f.method,
            pareto: false,
            failure: f.failure,
        }
    }

    /// The row as fields of the CSV.
    pub fn fields(&self) -> Vec<String> {
        vec![
            self.case.clone(),
            self.integrator.clone(),
            self.scheme.clone(),
            exact(self.mesh_m),
            self.ppc.to_string(),
            exact(self.dt_or_tol),
            exact(self.max_error_terzaghi),
            exact(self.max_error_compressible),
            exact(self.cpu_s),
            self.steps.to_string(),
            self.solves.to_string(),
            exact(self.ns_per_point_step),
            self.peak_bytes.to_string(),
            self.particles.to_string(),
            self.dimension.clone(),
            exact(self.cpu_low_s),
            exact(self.cpu_high_s),
            self.runs.to_string(),
            self.method.clone(),
            self.pareto.to_string(),
            self.failure.clone().unwrap_or_default(),
        ]
    }

    /// Runs that differ from this one in nothing but how fine they are in time.
    pub fn same_but_time(&self, other: &Self) -> bool {
        fn key(r: &Row) -> (&str, &str, &str, &str, usize) {
            (&r.integrator, &r.scheme, &r.dimension, &r.method, r.ppc)
        }
        self.mesh_m == other.mesh_m && key(self) == key(other)
    }

    /// Half the range of the samples over the median: how far the time is to be trusted.
    pub fn spread(&self) -> f64 {
        0.5 * (self.cpu_high_s - self.cpu_low_s) / self.cpu_s
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A row of an integrator with a tolerance or step, an error and a time.
    pub(crate) fn row(integrator: &str, mesh_m: f64, dt_or_tol: f64, error: f64, cpu_s: f64) -> Row {
        let found = Found {
            integrator: integrator.to_owned(),
            scheme: "centre".to_owned(),
            mesh_m,
            ppc: 4,
            dt_or_tol,
            max_error_terzaghi: error,
            max_error_compressible: error,
            steps: 10,
            solves: 0,
            peak_bytes: 1000,
            particles: 100,
            dimension: "column".to_owned(),
            method: String::new(),
            failure: None,
        };
        Row::new(&format!("{integrator}-L{mesh_m}-{dt_or_tol}"), &found, &[cpu_s], 1)
    }

    #[test]
    fn the_first_columns_are_the_contract_and_every_field_has_one() {
        let contract = "case,integrator,scheme,mesh_m,ppc,dt_or_tol,max_error_terzaghi,max_error_compressible,cpu_s,\
                        steps,solves,ns_per_point_step,peak_bytes";
        assert!(COLUMNS.starts_with(contract));
        let row = row("explicit", 0.1, 1e-6, 1e-2, 1.0);
        assert_eq!(row.fields().len(), COLUMNS.split(',').count());
        assert_eq!(row.ns_per_point_step, 1e6);
    }

    #[test]
    fn the_time_is_the_median() {
        let found = Found { ..found() };
        let row = Row::new("x", &found, &[1.0, 2.0, 9.0], 3);
        assert_eq!((row.cpu_s, row.cpu_low_s, row.cpu_high_s, row.runs), (2.0, 1.0, 9.0, 3));
        assert_eq!(row.spread(), 2.0);
    }

    fn found() -> Found {
        let json = r#"{"integrator":"explicit","scheme":"centre","mesh_m":0.1,"ppc":4,"dt_or_tol":1e-6,
            "max_error_terzaghi":null,"max_error_compressible":null,"steps":1,"solves":0,"peak_bytes":1,"particles":1,
            "dimension":"column","method":"","failure":"x"}"#;
        serde_json::from_str(json).expect("a failed run reads back with NaN")
    }
}

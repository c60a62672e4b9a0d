//! What a case is reduced to: errors, U at the sample times, profiles, history, work.

use serde::{Deserialize, Serialize};

use super::plan::PAPERS;
use super::{Case, word};
use crate::manifest::scene_hash;
use crate::report::numbers::percent;

/// How a case differs from the study's own setting.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// The case itself.
    Base,
    /// Half the time step.
    HalfStep,
    /// A hundredth of the load: strains a hundred times smaller.
    SmallLoad,
}

/// JSON has no NaN and writes null: reads it back.
///
/// # Errors
/// Neither a number nor null.
pub fn or_nan<'de, D: serde::Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(from)?.unwrap_or(f64::NAN))
}

/// U at one sample time, with what it is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Degree {
    /// Tv = c_v t/H^2.
    pub tv: f64,
    /// Time since drainage began, s.
    pub time_s: f64,
    /// Computed U = S/(q H/M).
    #[serde(deserialize_with = "or_nan")]
    pub u: f64,
    /// Terzaghi's series, incompressible water.
    #[serde(deserialize_with = "or_nan")]
    pub u_terzaghi: f64,
    /// The same with compressible water.
    #[serde(deserialize_with = "or_nan")]
    pub u_compressible: f64,
    /// Compressible water and inertia (u-p model); NaN where no such solution is at hand.
    #[serde(deserialize_with = "or_nan")]
    pub u_dynamic: f64,
    /// Compressible water on the mesh of the case, exact in time; NaN where not at hand.
    #[serde(deserialize_with = "or_nan")]
    pub u_mesh: f64,
}

/// A profile of pore pressure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    /// Time factor.
    pub tv: f64,
    /// Rows from the base up.
    pub rows: Vec<ProfilePoint>,
}

/// A point of a profile.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ProfilePoint {
    /// Height at t = 0, m.
    pub height_m: f64,
    /// Computed pore pressure, Pa.
    #[serde(deserialize_with = "or_nan")]
    pub pressure_pa: f64,
    /// Terzaghi's, Pa.
    pub terzaghi_pa: f64,
    /// Compressible water, Pa.
    pub compressible_pa: f64,
}

/// A point of the history of a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HistoryPoint {
    /// Time since drainage began, s.
    pub time_s: f64,
    /// Time factor.
    pub tv: f64,
    /// U.
    #[serde(deserialize_with = "or_nan")]
    pub u: f64,
    /// Kinetic energy, J.
    #[serde(deserialize_with = "or_nan")]
    pub kinetic_j: f64,
    /// Strain energy, J.
    #[serde(deserialize_with = "or_nan")]
    pub strain_j: f64,
    /// Energy of the compressed water, J.
    #[serde(deserialize_with = "or_nan")]
    pub water_j: f64,
    /// Work of the load, J.
    #[serde(deserialize_with = "or_nan")]
    pub external_work_j: f64,
    /// Energy lost to Darcy flow, J.
    #[serde(deserialize_with = "or_nan")]
    pub darcy_dissipation_j: f64,
    /// Work of rho_w (g - a_s) on the flow, J.
    #[serde(deserialize_with = "or_nan")]
    pub flow_body_work_j: f64,
    /// What is left over, J.
    #[serde(deserialize_with = "or_nan")]
    #[serde(alias = "energy_closing_j")]
    pub energy_residual_j: f64,
    /// Water balance left over, kg.
    #[serde(deserialize_with = "or_nan")]
    #[serde(alias = "water_closing_kg")]
    pub water_residual_kg: f64,
    /// Water that has left, kg.
    #[serde(deserialize_with = "or_nan")]
    pub water_out_kg: f64,
}

/// One case, run and compared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CaseResult {
    /// Name, e.g. `explicit-centre-surface-L0.02-ppc4`.
    pub case: String,
    /// How it differs from the study's own setting.
    pub variant: Variant,
    /// Time integrator.
    pub integrator: String,
    /// Shape scheme.
    pub scheme: String,
    /// What carries the load.
    pub load: String,
    /// Cell edge L, m.
    pub mesh_m: f64,
    /// Particles per cell.
    pub ppc: usize,
    /// Solid particles in the run.
    pub particles: usize,
    /// Time step asked for, s; with steps of its own choice the average one, NaN if it takes none.
    #[serde(deserialize_with = "or_nan")]
    pub dt_s: f64,
    /// Steps done; of the Krylov method basis vectors.
    pub steps: u64,
    /// Largest error against Terzaghi.
    #[serde(deserialize_with = "or_nan")]
    pub max_error_terzaghi: f64,
    /// The same for Tv >= 0.1.
    #[serde(deserialize_with = "or_nan")]
    pub late_error_terzaghi: f64,
    /// Largest error against compressible water.
    #[serde(deserialize_with = "or_nan")]
    pub max_error_compressible: f64,
    /// The same for Tv >= 0.1.
    #[serde(deserialize_with = "or_nan")]
    pub late_error_compressible: f64,
    /// RMS(p - p_exact)/p_0 at Tv = 0.1, compressible water.
    #[serde(deserialize_with = "or_nan")]
    pub profile_error_compressible: f64,
    /// The same against Terzaghi.
    #[serde(deserialize_with = "or_nan")]
    pub profile_error_terzaghi: f64,
    /// Settlement at the end, m.
    #[serde(deserialize_with = "or_nan")]
    pub settlement_final_m: f64,
    /// Times a solid or water particle changed its cell.
    pub cell_crossings: u64,
    /// CPU time of the run, s; not a number if it was left out.
    #[serde(deserialize_with = "or_nan")]
    pub cpu_s: f64,
    /// CPU time per solid particle and step, ns.
    #[serde(deserialize_with = "or_nan")]
    pub ns_per_point_step: f64,
    /// Stability limit, s; NaN where there is none.
    #[serde(deserialize_with = "or_nan")]
    pub limit_s: f64,
    /// Whether a step above the limit was forced.
    pub forced: bool,
    /// Bytes per solid particle.
    pub bytes_per_point: usize,
    /// One dimension or plane strain.
    pub dimension: String,
    /// Hash of the scene.
    pub scene_hash: String,
    /// Why the run ended early, if it did.
    pub failure: Option<String>,
    /// Steps that were kept: all of `steps`.
    pub accepted_steps: u64,
    /// Steps that were repeated with a smaller length.
    pub rejected_steps: u64,
    /// Numeric factorisations of a sparse matrix.
    pub factorisations: u64,
    /// Solves with a factorised matrix.
    pub solves: u64,
    /// Largest error in time that was asked for; none for a scheme with given steps.
    pub tolerance: Option<f64>,
    /// Small or large strain.
    pub strain: String,
    /// U at the sample times.
    pub degrees: Vec<Degree>,
    /// Profiles at the sample times.
    pub profiles: Vec<Profile>,
    /// History of the drainage.
    pub history: Vec<HistoryPoint>,
}

impl CaseResult {
    /// A case that has no result, and why.
    pub(super) fn failed(case: &Case, failure: String) -> Self {
        Self { failure: Some(failure), ..Self::of(case) }
    }

    /// A case of which nothing is known but what its scene says.
    pub(super) fn of(case: &Case) -> Self {
        let scene = &case.scene;
        let none = f64::NAN;
        Self {
            case: case.name.clone(),
            variant: case.variant,
            integrator: word(scene.integrator),
            scheme: word(scene.shape),
            load: word(scene.surcharge.map(|s| s.on)),
            mesh_m: scene.cell,
            ppc: scene.particles_per_cell,
            particles: scene.solid_particles(),
            dt_s: none,
            steps: 0,
            max_error_terzaghi: none,
            late_error_terzaghi: none,
            max_error_compressible: none,
            late_error_compressible: none,
            profile_error_compressible: none,
            profile_error_terzaghi: none,
            settlement_final_m: none,
            cell_crossings: 0,
            cpu_s: 0.0,
            ns_per_point_step: none,
            limit_s: none,
            forced: false,
            bytes_per_point: 0,
            dimension: word(scene.dimension),
            scene_hash: scene_hash(scene),
            failure: None,
            accepted_steps: 0,
            rejected_steps: 0,
            factorisations: 0,
            solves: 0,
            tolerance: None,
            strain: word(scene.strain),
            degrees: Vec::new(),
            profiles: Vec::new(),
            history: Vec::new(),
        }
    }

    /// Integrator and shape functions: `explicit-centre`.
    pub fn family(&self) -> String {
        format!("{}-{}", self.integrator, self.scheme)
    }

    /// One line for the terminal.
    pub(super) fn line(&self) -> String {
        let errors = |terzaghi: &str, compressible: &str| {
            format!(
                "error {} % relative to {terzaghi}, {} % relative to {compressible}",
                percent(self.max_error_terzaghi),
                percent(self.max_error_compressible)
            )
        };
        let base = self.variant == Variant::Base;
        let end = self.failure.as_ref().map_or(String::new(), |why| format!("; failed: {why}"));
        if base && self.case == PAPERS {
            let exact = errors("Terzaghi", "the exact solution with finite bulk modulus of the pore water");
            return format!(
                "The paper's setting (L = 0.02 m, 4 particles per cell, explicit, traction on boundary particles): {exact}{end}"
            );
        }
        let variant = if base { String::new() } else { format!(" ({})", word(self.variant)) };
        let errors = errors("Terzaghi", "compressible");
        format!("{}{variant}: {} steps, {errors}, {:.2} s{end}", self.case, self.steps, self.cpu_s)
    }
}

/// The paper's own integrator and shape functions.
pub const PAPER_FAMILY: &str = "explicit-centre";

/// The family that headlines and pictures of one family are about: the paper's, or else the first in the results.
pub fn shown_family(results: &[CaseResult]) -> Option<String> {
    let mut families = results.iter().filter(|r| r.variant == Variant::Base).map(CaseResult::family);
    let first = families.next()?;
    Some(if first == PAPER_FAMILY || families.any(|f| f == PAPER_FAMILY) { PAPER_FAMILY.to_owned() } else { first })
}

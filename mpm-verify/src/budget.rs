//! The error budget: which part of U - U_Terzaghi comes from what.
//!
//! Each part is obtained by switching one thing, as a share of U_Terzaghi at the same time:
//!
//! | part | how |
//! |---|---|
//! | compressibility | exact solution with compressible water - Terzaghi's |
//! | inertia | exact dynamic column - exact compressible |
//! | space | exact in time on the mesh of the case - exact compressible |
//! | time | 2 (run - run with half the step): the scheme is of first order in the step |
//! | large strain | run - run with a hundredth of the load |
//! | load | run with the load on the particles - run with it on the surface |
//! | remainder | what is left of the total |
//!
//! The remainder is not forced to vanish: it says how far the parts are from adding up.

use serde::{Deserialize, Serialize};

use crate::study::{CaseResult, Degree, Variant, or_nan};

/// The parts of the error of one case at one time factor, signed, relative to Terzaghi's U.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Budget {
    /// Name of the case.
    pub case: String,
    /// What carries the load.
    pub load: String,
    /// Cell edge L, m.
    pub mesh_m: f64,
    /// Particles per cell.
    pub ppc: usize,
    /// Time factor.
    pub tv: f64,
    /// U/U_Terzaghi - 1.
    #[serde(deserialize_with = "or_nan")]
    pub total: f64,
    /// Water that compresses.
    #[serde(deserialize_with = "or_nan")]
    pub compressibility: f64,
    /// Inertia of the mixture.
    #[serde(deserialize_with = "or_nan")]
    pub inertia: f64,
    /// Cells of finite size.
    #[serde(deserialize_with = "or_nan")]
    pub space: f64,
    /// Steps of finite length.
    #[serde(deserialize_with = "or_nan")]
    pub time: f64,
    /// Strains of finite size.
    #[serde(deserialize_with = "or_nan")]
    pub large_strain: f64,
    /// Load on the particles instead of the surface.
    #[serde(deserialize_with = "or_nan")]
    pub load_placement: f64,
    /// total - sum of the parts.
    #[serde(deserialize_with = "or_nan")]
    pub remainder: f64,
}

impl Budget {
    /// Names and values of the parts, in the order of the pictures; the remainder last.
    pub fn parts(&self) -> [(&'static str, f64); 7] {
        [
            ("load placement", self.load_placement),
            ("space", self.space),
            ("time", self.time),
            ("inertia", self.inertia),
            ("water compressibility", self.compressibility),
            ("large strain", self.large_strain),
            ("remainder", self.remainder),
        ]
    }
}

/// Budgets of every base case whose further runs are there, at every sample time.
pub fn budgets(results: &[CaseResult]) -> Vec<Budget> {
    let mut budgets = Vec::new();
    for result in results.iter().filter(|r| r.variant == Variant::Base && r.failure.is_none()) {
        let of = |variant| {
            results.iter().find(|r| {
                let own = (r.mesh_m, r.ppc) == (result.mesh_m, result.ppc) && r.family() == result.family();
                own && r.variant == variant && r.load == "surface"
            })
        };
        let (Some(surface), Some(half), Some(small)) =
            (of(Variant::Base), of(Variant::HalfStep), of(Variant::SmallLoad))
        else {
            continue;
        };
        for degree in &result.degrees {
            let at = |r: &CaseResult| r.degrees.iter().find(|d| (d.tv / degree.tv - 1.0).abs() < 1e-6).copied();
            if let (Some(surface), Some(half), Some(small)) = (at(surface), at(half), at(small)) {
                budgets.push(budget(result, degree, surface.u, half.u, small.u));
            }
        }
    }
    budgets
}

fn budget(result: &CaseResult, degree: &Degree, surface: f64, half: f64, small: f64) -> Budget {
    let share = |difference: f64| difference / degree.u_terzaghi;
    let mut budget = Budget {
        case: result.case.clone(),
        load: result.load.clone(),
        mesh_m: result.mesh_m,
        ppc: result.ppc,
        tv: degree.tv,
        total: share(degree.u - degree.u_terzaghi),
        compressibility: share(degree.u_compressible - degree.u_terzaghi),
        inertia: share(degree.u_dynamic - degree.u_compressible),
        space: share(degree.u_mesh - degree.u_compressible),
        time: share(2.0 * (surface - half)),
        large_strain: share(surface - small),
        load_placement: share(degree.u - surface),
        remainder: 0.0,
    };
    let sum: f64 = budget.parts().iter().map(|(_, part)| part).sum();
    budget.remainder = budget.total - sum;
    budget
}

//! Which cases of a study tables and pictures are about.

use crate::budget::Budget;
use crate::exact::terzaghi::Terzaghi;
use crate::norms::relative;
use crate::report::Study;
use crate::study::{CaseResult, Degree, Variant, shown_family};

/// The loads in the order of panels and tables: the word in the data and how it reads.
pub const LOADS: [(&str, &str); 2] =
    [("particles", "traction on boundary particles"), ("surface", "traction on the free surface")];

/// The paper's own mesh (m) and number of particles per cell.
pub const PAPER: (f64, usize) = (0.02, 4);

/// An exact solution that errors are taken against.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reference {
    /// Terzaghi's series, water that does not compress.
    Terzaghi,
    /// The same with compressible water.
    Compressible,
}

impl Reference {
    /// Both, Terzaghi first.
    pub const BOTH: [Self; 2] = [Self::Terzaghi, Self::Compressible];

    /// How it reads after "against".
    pub fn words(self) -> &'static str {
        match self {
            Self::Terzaghi => "Terzaghi",
            Self::Compressible => "the exact solution with finite K_w",
        }
    }

    /// Largest error of a case, as a share of U; NaN for a run that ended early.
    pub fn largest(self, case: &CaseResult) -> f64 {
        match self {
            Self::Terzaghi => case.max_error_terzaghi,
            Self::Compressible => case.max_error_compressible,
        }
    }

    /// The same for Tv >= 0.1.
    pub fn late(self, case: &CaseResult) -> f64 {
        match self {
            Self::Terzaghi => case.late_error_terzaghi,
            Self::Compressible => case.late_error_compressible,
        }
    }

    /// Signed error U/U_exact - 1 at one time.
    pub fn signed(self, degree: &Degree) -> f64 {
        match self {
            Self::Terzaghi => relative(degree.u, degree.u_terzaghi),
            Self::Compressible => relative(degree.u, degree.u_compressible),
        }
    }

    /// The largest error with its sign: positive where the computed column has settled too far at its worst time.
    pub fn largest_signed(self, case: &CaseResult, from_tv: f64) -> f64 {
        let sizes = case.degrees.iter().filter(|d| d.tv >= from_tv * (1.0 - 1e-6)).map(|d| self.signed(d));
        let worst = sizes.filter(|e| e.is_finite()).max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(1.0);
        let size = if from_tv > 0.0 { self.late(case) } else { self.largest(case) };
        size.copysign(worst)
    }
}

/// The base cases of one integrator and one scheme, which pictures are drawn of.
#[derive(Debug, Clone)]
pub struct Cases<'a>(pub Vec<&'a CaseResult>);

impl<'a> Cases<'a> {
    /// The cases of the integrator and scheme that the study is about, without runs that failed.
    pub fn of(results: &'a [CaseResult]) -> Self {
        Self::of_family(results, &shown_family(results).unwrap_or_default())
    }

    /// The cases of an integrator and scheme (`quasi-static-bspline2`), without runs that failed.
    pub fn of_family(results: &'a [CaseResult], family: &str) -> Self {
        let own = |r: &&CaseResult| r.variant == Variant::Base && r.failure.is_none() && r.family() == family;
        Self(results.iter().filter(own).collect())
    }

    /// A case.
    pub fn get(&self, load: &str, mesh: f64, ppc: usize) -> Option<&'a CaseResult> {
        self.0.iter().copied().find(|r| r.load == load && r.ppc == ppc && (r.mesh_m / mesh - 1.0).abs() < 1e-9)
    }

    /// Meshes in m, coarse first.
    pub fn meshes(&self) -> Vec<f64> {
        meshes(&self.0)
    }

    /// Numbers of particles per cell, few first.
    pub fn particles(&self) -> Vec<usize> {
        particles(&self.0)
    }

    /// The number of particles per cell that pictures of one number show: 4, or the one nearest to it.
    pub fn usual_particles(&self) -> Option<usize> {
        self.particles().into_iter().min_by_key(|n| n.abs_diff(PAPER.1))
    }

    /// Budgets of the cases with one load and the usual number of particles at a time factor, coarse mesh first.
    pub fn budgets<'b>(&self, study: &'b Study, load: &str, tv: f64) -> Vec<&'b Budget> {
        let shown = |b: &&Budget| {
            let own = b.load == load && Some(b.ppc) == self.usual_particles() && same_time(b.tv, tv);
            own && self.0.iter().any(|r| r.case == b.case)
        };
        let mut budgets: Vec<&Budget> = study.budgets.iter().filter(shown).collect();
        budgets.sort_by(|a, b| b.mesh_m.total_cmp(&a.mesh_m));
        budgets
    }

    /// The case at the paper's mesh and particles with a given load, or the one nearest to it.
    pub fn paper(&self, load: &str) -> Option<&'a CaseResult> {
        self.nearest(load, PAPER)
    }

    /// The case with a given load that is nearest to a mesh (m) and a number of particles per cell.
    pub fn nearest(&self, load: &str, (mesh, ppc): (f64, usize)) -> Option<&'a CaseResult> {
        let far = |r: &CaseResult| (r.mesh_m / mesh).ln().abs() + r.ppc.abs_diff(ppc) as f64;
        self.0.iter().copied().filter(|r| r.load == load).min_by(|a, b| far(a).total_cmp(&far(b)))
    }
}

/// Integrators in the order of panels and tables.
pub const INTEGRATORS: [&str; 3] = ["explicit", "semi-implicit", "quasi-static"];

/// Particles per cell by which an integrator is compared with others: 4 as in the paper; 9 for quasi-static runs,
/// because fitted weights of displaced particles need three per direction with quadratic B-splines and the rest does not care.
pub fn compared_particles(integrator: &str) -> usize {
    if integrator == INTEGRATORS[2] { 9 } else { PAPER.1 }
}

/// The cases by which integrators and schemes are compared: traction on the free surface, the number of particles per cell that
/// is there and nearest to [`compared_particles`].
pub fn of_schemes(results: &[CaseResult]) -> Vec<&CaseResult> {
    let own = |r: &&CaseResult| r.variant == Variant::Base && r.failure.is_none() && r.load == "surface";
    let mut cases: Vec<&CaseResult> = results.iter().filter(own).collect();
    for integrator in INTEGRATORS {
        let own: Vec<&CaseResult> = cases.iter().filter(|r| r.integrator == integrator).copied().collect();
        let wanted = compared_particles(integrator);
        let nearest = particles(&own).into_iter().min_by_key(|n| n.abs_diff(wanted));
        cases.retain(|r| r.integrator != integrator || Some(r.ppc) == nearest);
    }
    cases
}

/// Meshes of some cases in m, coarse first.
pub fn meshes(cases: &[&CaseResult]) -> Vec<f64> {
    let mut meshes: Vec<f64> = cases.iter().map(|r| r.mesh_m).collect();
    meshes.sort_by(|a, b| b.total_cmp(a));
    meshes.dedup();
    meshes
}

/// Particles per cell of some cases, few first.
pub fn particles(cases: &[&CaseResult]) -> Vec<usize> {
    let mut particles: Vec<usize> = cases.iter().map(|r| r.ppc).collect();
    particles.sort_unstable();
    particles.dedup();
    particles
}

/// The base cases of a study by integrator and scheme (`explicit-centre`), in the order in which they appear.
pub fn families(results: &[CaseResult]) -> Vec<(String, Vec<&CaseResult>)> {
    let mut families: Vec<(String, Vec<&CaseResult>)> = Vec::new();
    for result in results.iter().filter(|r| r.variant == Variant::Base) {
        let name = result.family();
        match families.iter_mut().find(|(known, _)| *known == name) {
            Some((_, cases)) => cases.push(result),
            None => families.push((name, vec![result])),
        }
    }
    families
}

/// How a case reads that stands in for the paper's: empty if it is the paper's own.
pub fn stands_in(case: &CaseResult) -> String {
    if (case.mesh_m / PAPER.0 - 1.0).abs() < 1e-9 && case.ppc == PAPER.1 {
        return String::new();
    }
    let (mesh, ppc) = PAPER;
    format!(" This study has no run with L = {mesh} m and {ppc} particles per cell; shown is {}.", case.case)
}

/// Largest share of U by which the two exact solutions of a case differ over its sample times.
pub fn compressibility(case: &CaseResult) -> f64 {
    case.degrees.iter().map(|d| relative(d.u_compressible, d.u_terzaghi).abs()).fold(0.0, f64::max)
}

/// Exact solutions at any time, if the column of a case is that of the built-in scene.
#[derive(Debug, Clone, Copy)]
pub struct Exact {
    /// Water that does not compress.
    pub terzaghi: Terzaghi,
    /// Water that does.
    pub compressible: Terzaghi,
}

impl Exact {
    /// `None` if the built-in scene gives other values than the case was compared with.
    pub fn of(case: &CaseResult) -> Option<Self> {
        let scene = crate::scenes::terzaghi();
        let (terzaghi, compressible) = (Terzaghi::incompressible(&scene)?, Terzaghi::compressible(&scene)?);
        let agrees = |d: &Degree| {
            (terzaghi.time_factor(d.time_s) - d.tv).abs() < 1e-9
                && (terzaghi.relative_settlement(d.time_s) - d.u_terzaghi).abs() < 1e-9
                && (compressible.relative_settlement(d.time_s) - d.u_compressible).abs() < 1e-9
        };
        case.degrees.iter().all(agrees).then_some(Self { terzaghi, compressible })
    }
}

/// Whether two time factors are the same sample time.
pub fn same_time(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() < 1e-6
}

//! Orders of convergence of a study, per load and number of particles.

use mpm_core::scene::{Integrator, ShapeChoice};

use crate::norms::LATE_TV;
use crate::rates::{Convergence, Richardson, Theory, richardson, round_off};
use crate::report::select::{Reference, families, particles, same_time};
use crate::study::{CaseResult, word};

/// Orders of one group of cases that differ only in the mesh.
#[derive(Debug, Clone)]
pub struct Group {
    /// Integrator, scheme, load and particles per cell: `explicit-centre-surface-ppc4`.
    pub name: String,
    /// What carries the load.
    pub load: String,
    /// Particles per cell.
    pub ppc: usize,
    /// Meshes in m that the fits rest on, coarse first.
    pub meshes: Vec<f64>,
    /// Norm, and the order of its errors beside that of theory.
    pub fits: Vec<(&'static str, Convergence)>,
    /// What the three finest meshes say about U at Tv = 0.1; `None` if they do not converge monotonically.
    pub richardson: Option<Richardson>,
    /// U at Tv = 0.1 with compressible water, for comparison with the extrapolated value.
    pub exact: f64,
}

/// The norms: name, and the error of a case with its sign where it has one.
type Norm = (&'static str, fn(&CaseResult) -> f64);

/// Norms in the order of tables.
pub const NORMS: [Norm; 6] = [
    ("max-terzaghi", |r| Reference::Terzaghi.largest_signed(r, 0.0)),
    ("late-terzaghi", |r| Reference::Terzaghi.largest_signed(r, LATE_TV)),
    ("max-compressible", |r| Reference::Compressible.largest_signed(r, 0.0)),
    ("late-compressible", |r| Reference::Compressible.largest_signed(r, LATE_TV)),
    ("profile-terzaghi", |r| r.profile_error_terzaghi),
    ("profile-compressible", |r| r.profile_error_compressible),
];

/// Orders of every group of a study. Runs that failed are left out.
pub fn groups(results: &[CaseResult]) -> Vec<Group> {
    let mut groups = Vec::new();
    for (family, cases) in families(results) {
        let mut loads: Vec<&str> = cases.iter().map(|r| r.load.as_str()).collect();
        loads.sort_unstable();
        loads.dedup();
        for load in loads {
            for ppc in particles(&cases) {
                let whole = |r: &&&CaseResult| r.load == load && r.ppc == ppc && r.failure.is_none();
                let mut own: Vec<&CaseResult> = cases.iter().filter(whole).copied().collect();
                own.sort_by(|a, b| b.mesh_m.total_cmp(&a.mesh_m));
                if !own.is_empty() {
                    groups.push(group(format!("{family}-{load}-ppc{ppc}"), &own));
                }
            }
        }
    }
    groups
}

/// The order of theory relative to the exact solution of the compressible water. That relative to Terzaghi's ends at a constant.
///
/// Traction on boundary particles acts half a particle spacing s below the surface. The strip above it lacks the strain q s/M: first
/// order in the settlement. Of the profile it takes the pressure q over s at a distance s from the drained surface, which counts s^2.
/// Linear functions are of second order, quadratic splines of fourth where steps in time have no part. An implicit pressure in steps
/// that go with the cells adds an error of first order in them: their sum has none.
fn theory(norm: &str, case: &CaseResult) -> Theory {
    let is = |integrator: Integrator| case.integrator == word(integrator);
    let splines = is(Integrator::QuasiStatic)
        && [ShapeChoice::Bspline2, ShapeChoice::Bspline3].iter().any(|shape| case.scheme == word(*shape));
    let by_particles = case.load == "particles";
    match norm {
        _ if norm.ends_with("terzaghi") || is(Integrator::SemiImplicit) => Theory::None,
        "profile-compressible" if by_particles => Theory::Order(2.0),
        _ if by_particles => Theory::Order(1.0),
        _ => Theory::Order(if splines { 4.0 } else { 2.0 }),
    }
}

fn convergence(norm: &str, points: &[(f64, f64)], case: &CaseResult) -> Convergence {
    let cells = points.last().map_or(1.0, |(mesh, _)| points[0].0 / mesh);
    Convergence::new(points, theory(norm, case), round_off(cells * cells))
}

/// `own` holds at least one case, coarse first.
fn group(name: String, own: &[&CaseResult]) -> Group {
    let points = |norm: fn(&CaseResult) -> f64| own.iter().map(|r| (r.mesh_m, norm(r))).collect::<Vec<_>>();
    let late = |r: &&CaseResult| r.degrees.iter().find(|d| same_time(d.tv, LATE_TV)).map(|d| (r.mesh_m, *d));
    let values: Vec<_> = own.iter().filter_map(late).collect();
    let extrapolated = match values.as_slice() {
        [.., (h3, coarse), (h2, middle), (h1, fine)] => richardson((*h3, coarse.u), (*h2, middle.u), (*h1, fine.u)),
        _ => None,
    };
    Group {
        name,
        load: own[0].load.clone(),
        ppc: own[0].ppc,
        meshes: own.iter().map(|r| r.mesh_m).collect(),
        fits: NORMS.map(|(norm, error)| (norm, convergence(norm, &points(error), own[0]))).to_vec(),
        richardson: extrapolated,
        exact: values.last().map_or(f64::NAN, |(_, d)| d.u_compressible),
    }
}

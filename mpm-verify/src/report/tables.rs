//! The tables of a study as CSV. Others parse them: columns are only ever added at the end.

use std::path::Path;

use crate::cost::Cost;
use crate::report::numbers::exact;
use crate::report::orders::groups;
use crate::report::{ReportError, Study, unwritable};
use crate::study::{CaseResult, Variant};
use crate::sweeps::Sweeps;

/// Columns of `errors.csv`; the first 18 are a contract.
pub const ERRORS: &str = "case,integrator,scheme,load,mesh_m,ppc,particles,dt_s,steps,max_error_terzaghi,\
late_error_terzaghi,max_error_compressible,late_error_compressible,profile_error_compressible,settlement_final_m,\
cell_crossings,cpu_s,ns_per_point_step,profile_error_terzaghi,limit_s,forced,dimension,scene_hash,failure,\
accepted_steps,rejected_steps,factorisations,solves,tolerance,strain";

/// Columns of `consolidation.csv`.
pub const CONSOLIDATION: &str =
    "case,integrator,scheme,load,mesh_m,ppc,tv,u,u_terzaghi,u_compressible,time_s,u_dynamic,u_mesh";

/// Columns of `orders.csv`. The Richardson columns are about U at Tv = 0.1 and the same for every norm of a group.
pub const ORDERS: &str = "group,norm,order,half_width_95,pairwise_orders,asymptotic,richardson_u_tv0.1,\
richardson_order,richardson_gci,u_compressible_tv0.1,meshes";

/// Columns of `budget.csv`.
pub const BUDGET: &str = "case,load,mesh_m,ppc,tv,total,compressibility,inertia,space,time,large_strain,\
load_placement,remainder";

/// Columns of `claims.csv`.
pub const CLAIMS: &str = "id,verdict,said,rule,evidence,picture";

/// Columns of `claims_integrators.csv`: the claims judged on other integrators.
pub const OTHER_CLAIMS: &str = "family,id,verdict,evidence";

/// Columns of `displaced.csv`.
pub const DISPLACED: &str = "kind,smooth_spacings,jitter_spacings,seed,scheme,quadrature,mesh_m,ppc,\
max_error_compressible,late_error_compressible,profile_error_compressible,required,passed,failure";

/// Columns of `grid_shift.csv`.
pub const GRID_SHIFT: &str = "shift_cells,scheme,quadrature,mesh_m,ppc,max_error_compressible,\
late_error_compressible,profile_error_compressible,required,passed,failure";

/// Columns of `time_error.csv`.
pub const TIME_ERROR: &str = "integrator,scheme,method,mesh_m,ppc,tolerance,step_share,accepted_steps,rejected_steps,\
factorisations,solves,cpu_s,time_error,max_error_compressible,failure";

/// Columns of `cost.csv`.
pub const COST: &str = "path,points,steps,ns_per_point_step,ns_min,ns_max,bytes_per_point,ratio_to_general";

/// Writes all tables of a study into a folder.
///
/// # Errors
/// A file that cannot be written.
pub fn write(study: &Study, folder: &Path) -> Result<(), ReportError> {
    let base = || study.results.iter().filter(|r| r.variant == Variant::Base);
    table(&folder.join("errors.csv"), ERRORS, base().map(error_row))?;
    table(&folder.join("consolidation.csv"), CONSOLIDATION, base().flat_map(consolidation_rows))?;
    table(&folder.join("orders.csv"), ORDERS, order_rows(&study.results))?;
    table(&folder.join("budget.csv"), BUDGET, budget_rows(study))?;
    let claim = |c: &crate::claims::Claim| {
        [&c.id, c.verdict.words(), &c.said, &c.rule, &c.evidence, &c.picture].map(str::to_owned).to_vec()
    };
    table(&folder.join("claims.csv"), CLAIMS, study.claims.iter().map(claim))?;
    let others = study.other_claims.iter().flat_map(|judged| {
        let row = |c: &crate::claims::Claim| [&judged.family, &c.id, c.verdict.words(), &c.evidence].map(str::to_owned);
        judged.claims.iter().map(row).map(|row| row.to_vec()).collect::<Vec<_>>()
    });
    table(&folder.join("claims_integrators.csv"), OTHER_CLAIMS, others)?;
    sweeps(&study.sweeps, folder)?;
    if study.costs.is_empty() {
        return Ok(());
    }
    table(&folder.join("cost.csv"), COST, study.costs.iter().map(cost_row))
}

/// Tables of the sweeps, where they were run.
fn sweeps(sweeps: &Sweeps, folder: &Path) -> Result<(), ReportError> {
    if sweeps.count() == 0 {
        return Ok(());
    }
    let displaced = sweeps.displaced.iter().map(|r| {
        let mut row = vec![r.kind.clone(), exact(r.smooth), exact(r.jitter), r.seed.to_string()];
        row.extend([r.scheme.clone(), r.quadrature.clone(), exact(r.mesh_m), r.ppc.to_string()]);
        row.extend([r.max_error_compressible, r.late_error_compressible, r.profile_error_compressible].map(exact));
        row.extend([maybe(r.required), r.held.map_or_else(String::new, |h| h.to_string())]);
        row.push(r.failure.clone().unwrap_or_default());
        row
    });
    table(&folder.join("displaced.csv"), DISPLACED, displaced)?;
    let shifted = sweeps.shifted.iter().map(|r| {
        let mut row = vec![exact(r.shift), r.scheme.clone(), r.quadrature.clone(), exact(r.mesh_m), r.ppc.to_string()];
        row.extend([r.max_error_compressible, r.late_error_compressible, r.profile_error_compressible].map(exact));
        row.extend([maybe(r.required), r.held.map_or_else(String::new, |h| h.to_string())]);
        row.push(r.failure.clone().unwrap_or_default());
        row
    });
    table(&folder.join("grid_shift.csv"), GRID_SHIFT, shifted)?;
    let time = sweeps.time.iter().map(|r| {
        let mut row = vec![r.integrator.clone(), r.scheme.clone(), r.method.clone()];
        row.extend([exact(r.mesh_m), r.ppc.to_string(), maybe(r.tolerance), maybe(r.step_share)]);
        row.extend([r.accepted_steps, r.rejected_steps, r.factorisations, r.solves].map(|n| n.to_string()));
        row.extend([r.cpu_s, r.time_error, r.max_error_compressible].map(exact));
        row.push(r.failure.clone().unwrap_or_default());
        row
    });
    table(&folder.join("time_error.csv"), TIME_ERROR, time)
}

/// A number, or nothing where there is none by nature.
fn maybe(value: Option<f64>) -> String {
    value.map_or_else(String::new, exact)
}

fn cost_row(cost: &Cost) -> Vec<String> {
    let counts = [cost.points.to_string(), cost.steps.to_string()];
    let times = [cost.ns_per_point_step, cost.spread_ns[0], cost.spread_ns[1]].map(exact);
    let rest = [cost.bytes_per_point.to_string(), exact(cost.ratio)];
    [vec![cost.path.clone()], counts.to_vec(), times.to_vec(), rest.to_vec()].concat()
}

/// Writes one table: a header of names with commas between, then rows.
///
/// # Errors
/// A file that cannot be written.
pub fn table(path: &Path, header: &str, rows: impl IntoIterator<Item = Vec<String>>) -> Result<(), ReportError> {
    let failed = |e: csv::Error| unwritable(path, e);
    let mut writer = csv::Writer::from_path(path).map_err(failed)?;
    writer.write_record(header.split(',')).map_err(failed)?;
    for row in rows {
        writer.write_record(&row).map_err(failed)?;
    }
    writer.flush().map_err(|e| unwritable(path, e))
}

/// What every table says of a case first.
fn identity(r: &CaseResult) -> Vec<String> {
    vec![r.case.clone(), r.integrator.clone(), r.scheme.clone(), r.load.clone(), exact(r.mesh_m), r.ppc.to_string()]
}

fn error_row(r: &CaseResult) -> Vec<String> {
    let mut row = identity(r);
    row.extend([r.particles.to_string(), exact(r.dt_s), r.steps.to_string()]);
    row.extend(
        [
            r.max_error_terzaghi,
            r.late_error_terzaghi,
            r.max_error_compressible,
            r.late_error_compressible,
            r.profile_error_compressible,
            r.settlement_final_m,
        ]
        .map(exact),
    );
    row.push(r.cell_crossings.to_string());
    row.extend([r.cpu_s, r.ns_per_point_step, r.profile_error_terzaghi, r.limit_s].map(exact));
    row.extend([r.forced.to_string(), r.dimension.clone(), r.scene_hash.clone()]);
    row.push(r.failure.clone().unwrap_or_default());
    row.extend([r.accepted_steps, r.rejected_steps, r.factorisations, r.solves].map(|n| n.to_string()));
    row.extend([maybe(r.tolerance), r.strain.clone()]);
    row
}

fn consolidation_rows(r: &CaseResult) -> Vec<Vec<String>> {
    let row = |d: &crate::study::Degree| {
        let mut row = identity(r);
        row.extend([d.tv, d.u, d.u_terzaghi, d.u_compressible, d.time_s, d.u_dynamic, d.u_mesh].map(exact));
        row
    };
    r.degrees.iter().map(row).collect()
}

fn order_rows(results: &[CaseResult]) -> Vec<Vec<String>> {
    let spaced = |values: &[f64]| values.iter().map(|v| exact(*v)).collect::<Vec<_>>().join(" ");
    let mut rows = Vec::new();
    for group in groups(results) {
        let r = group.richardson.as_ref();
        let value = |get: fn(&crate::rates::Richardson) -> f64| exact(r.map_or(f64::NAN, get));
        for (norm, fit) in &group.fits {
            let mut row = vec![group.name.clone(), (*norm).to_owned()];
            row.extend(match &fit.fit {
                Some(f) => [exact(f.order), exact(f.half_width), spaced(&f.pairwise), f.asymptotic.to_string()],
                None => [exact(f64::NAN), exact(f64::NAN), String::new(), "false".to_owned()],
            });
            row.extend([value(|r| r.value), value(|r| r.order), value(|r| r.gci)]);
            row.extend([exact(group.exact), spaced(&group.meshes)]);
            rows.push(row);
        }
    }
    rows
}

fn budget_rows(study: &Study) -> impl Iterator<Item = Vec<String>> {
    study.budgets.iter().map(|b| {
        let mut row = vec![b.case.clone(), b.load.clone(), exact(b.mesh_m), b.ppc.to_string(), exact(b.tv)];
        row.extend([b.total, b.compressibility, b.inertia, b.space, b.time].map(exact));
        row.extend([b.large_strain, b.load_placement, b.remainder].map(exact));
        row
    })
}

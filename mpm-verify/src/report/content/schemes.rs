//! Tables that compare integrators and shape functions, and those of the sweeps.

use super::table::{Cell, Table, order_of_group, table};
use crate::claims::Judgement;
use crate::report::numbers::short;
use crate::report::orders::Group;
use crate::report::select::{meshes, of_schemes};
use crate::study::CaseResult;
use crate::sweeps::time::TimeError;
use crate::sweeps::{MESHES, Sweeps};

/// Error, steps and time of every scheme on every mesh; the orders of its errors.
pub fn schemes(results: &[CaseResult], groups: &[Group]) -> Vec<Table> {
    let cases = of_schemes(results);
    if cases.is_empty() {
        return Vec::new();
    }
    let setting = "traction on the free surface";
    let model = "Explicit and semi-implicit runs carry inertia and large strain, quasi-static ones neither: each is \
                 compared with the solution of small strain without inertia, so that the errors of the first two tend to \
                 these effects. A dash: not run. Particles per cell in brackets.";
    let time = "CPU time on a machine that may have been loaded; a quick run is the median of several.";
    vec![
        by_family(
            &cases,
            format!("Largest error relative to the exact solution with finite K_w, {setting}"),
            model,
            |r| short(r.max_error_compressible, 3),
        ),
        by_family(&cases, format!("Error of the pressure profile at Tv = 0.1, {setting}"), "", |r| {
            short(r.profile_error_compressible, 3)
        }),
        orders(groups, &cases),
        by_family(&cases, format!("Steps, {setting}"), "The Krylov method counts its basis vectors.", |r| {
            r.accepted_steps.to_string()
        }),
        by_family(&cases, format!("CPU time (s), {setting}"), time, |r| short(r.cpu_s, 2)),
    ]
}

/// Rows of integrator and scheme, columns of meshes.
fn by_family(cases: &[&CaseResult], title: String, note: &str, number: fn(&CaseResult) -> String) -> Table {
    let mut families: Vec<String> = Vec::new();
    for family in cases.iter().map(|r| r.family()) {
        if !families.contains(&family) {
            families.push(family);
        }
    }
    let meshes = meshes(cases);
    let mut head = vec!["integrator and scheme".to_owned()];
    head.extend(meshes.iter().map(|mesh| format!("L = {mesh} m")));
    let row = |family: String| {
        let found = |mesh: &f64| cases.iter().find(|r| r.mesh_m == *mesh && r.family() == family);
        let cells = meshes.iter().map(|mesh| Cell::new(found(mesh).map_or_else(|| "–".to_owned(), |r| number(r))));
        let ppc = cases.iter().find(|r| r.family() == family).map_or(0, |r| r.ppc);
        std::iter::once(Cell::new(format!("{family} ({ppc})"))).chain(cells).collect()
    };
    let heads: Vec<&str> = head.iter().map(String::as_str).collect();
    table(title, &heads, families.into_iter().map(row).collect(), note)
}

/// Orders of every scheme relative to the exact solution with finite K_w.
fn orders(groups: &[Group], cases: &[&CaseResult]) -> Table {
    let name = |r: &CaseResult| format!("{}-surface-ppc{}", r.family(), r.ppc);
    let own = groups.iter().filter(|g| cases.iter().any(|r| name(r) == g.name));
    let row = |g: &Group| {
        let mut row = vec![Cell::new(g.name.clone()).marked(format!("{} meshes", g.meshes.len()), "")];
        let fits = ["max-compressible", "late-compressible", "profile-compressible"];
        row.extend(fits.map(|norm| {
            let found = g.fits.iter().find(|(n, _)| *n == norm);
            found.map_or_else(|| Cell::new("–"), |(_, found)| order_of_group(found))
        }));
        row
    };
    let head = ["group", "max error", "late error", "profile"];
    let note = "As in the tables of orders above. A line that ends at an error in time or at what the model carries has no \
                order that is established.";
    table(
        "Orders of every scheme relative to the exact solution with finite K_w".to_owned(),
        &head,
        own.map(row).collect(),
        note,
    )
}

/// Verdicts on the paper's statements with other integrators.
pub fn other_claims(others: &[Judgement]) -> Vec<Table> {
    let Some(first) = others.first() else { return Vec::new() };
    let mut head = vec!["claim"];
    head.extend(others.iter().map(|o| o.family.as_str()));
    let verdict = |o: &Judgement, place: usize| {
        o.claims.get(place).map_or_else(|| Cell::new("–"), |claim| crate::report::study::badge(claim.verdict))
    };
    let row = |(place, claim): (usize, &crate::claims::Claim)| {
        let mut row = vec![Cell::new(claim.said.clone())];
        row.extend(others.iter().map(|o| verdict(o, place)));
        row
    };
    let rows = first.claims.iter().enumerate().map(row).collect();
    let note = "The same rules on runs of other integrators, values at the cell centre, traction on boundary particles. The \
                evidence is in claims_integrators.csv.";
    vec![table("The same claims with other integrators".to_owned(), &head, rows, note)]
}

/// Largest errors of the sweeps over places, with what they must reach.
pub fn places(sweeps: &Sweeps) -> Vec<Table> {
    let mut rows = Vec::new();
    for mesh in MESHES {
        let mut lines: Vec<(String, String)> = Vec::new();
        for row in sweeps.displaced.iter().filter(|r| r.mesh_m == mesh) {
            let line = (row.scheme.clone(), row.quadrature.clone());
            if !lines.contains(&line) {
                lines.push(line);
            }
        }
        for (scheme, quadrature) in lines {
            let own = |r: &&_| {
                matches!(r, crate::sweeps::places::Displacement { scheme: s, quadrature: q, mesh_m, .. }
                    if (s, q, *mesh_m) == (&scheme, &quadrature, mesh))
            };
            let own: Vec<_> = sweeps.displaced.iter().filter(own).collect();
            let worst = |kind: &str| {
                let errors = own.iter().filter(|r| r.kind == kind && r.smooth + r.jitter > 0.0);
                errors.map(|r| r.max_error_compressible).collect::<Vec<_>>()
            };
            let even = own.iter().filter(|r| r.smooth + r.jitter == 0.0).map(|r| r.max_error_compressible);
            let mut row = vec![Cell::new(format!("{scheme}, {quadrature}, L = {mesh} m"))];
            row.push(error_cell(&even.collect::<Vec<_>>()));
            row.extend(["smooth", "jitter", "both"].map(|kind| error_cell(&worst(kind))));
            row.push(verdict(own.first().and_then(|r| r.required), own.iter().map(|r| r.held)));
            rows.push(row);
        }
    }
    let mut tables = Vec::new();
    let head = ["scheme", "even", "smooth, to 0.5", "random, to 0.25", "both", "required"];
    let note = "Largest error of U relative to the exact solution with finite K_w over all amplitudes (in particle spacings) and seeds.";
    if !rows.is_empty() {
        tables.push(table("Displaced particles".to_owned(), &head, rows, note));
    }
    let row = |mesh: f64| {
        let own: Vec<_> = sweeps.shifted.iter().filter(|r| r.mesh_m == mesh).collect();
        let errors = |at: fn(f64) -> bool| {
            own.iter().filter(|r| at(r.shift)).map(|r| r.max_error_compressible).collect::<Vec<_>>()
        };
        let verdict = verdict(own.first().and_then(|r| r.required), own.iter().map(|r| r.held));
        let [aligned, off] = [errors(|s| s == 0.0), errors(|s| s != 0.0)].map(|e| error_cell(&e));
        vec![Cell::new(format!("bspline2, fitted, L = {mesh} m")), aligned, off, verdict]
    };
    if !sweeps.shifted.is_empty() {
        let head = ["scheme", "aligned", "worst offset", "required"];
        let note = "Largest error of U relative to the exact solution with finite K_w over all starts of the mesh below the soil.";
        tables.push(table("Offset of the mesh".to_owned(), &head, MESHES.map(row).to_vec(), note));
    }
    tables
}

/// The largest of some errors; "failed" if one run has none.
fn error_cell(errors: &[f64]) -> Cell {
    if errors.iter().any(|e| e.is_nan()) {
        return Cell::new("failed").marked("", "bad");
    }
    Cell::new(errors.iter().copied().reduce(f64::max).map_or_else(|| "–".to_owned(), |e| short(e, 2)))
}

/// Whether a limit holds in every run.
fn verdict(required: Option<f64>, held: impl Iterator<Item = Option<bool>>) -> Cell {
    let Some(limit) = required else { return Cell::new("–") };
    let all = held.flatten().all(|h| h);
    let (words, mark) = if all { ("passed", "good") } else { ("failed", "bad") };
    Cell::new(format!("at most {}", short(limit, 1))).marked(words, mark)
}

/// Errors in time, steps and solves.
pub fn time(sweeps: &Sweeps) -> Vec<Table> {
    let setting = |r: &TimeError| match (r.tolerance, r.step_share) {
        (Some(tolerance), _) => format!("tolerance {tolerance:e}"),
        (None, Some(share)) => format!("{share:.3} of the limit"),
        (None, None) => String::new(),
    };
    let row = |r: &TimeError| {
        let mark = if r.failure.is_some() { "bad" } else { "" };
        let mut row = vec![
            Cell::new(format!("{}, L = {} m", r.label(), r.mesh_m)).marked(r.failure.clone().unwrap_or_default(), mark),
        ];
        row.push(Cell::new(setting(r)));
        row.extend([r.accepted_steps, r.rejected_steps, r.factorisations, r.solves].map(|n| Cell::new(n.to_string())));
        row.extend([r.cpu_s, r.time_error, r.max_error_compressible].map(|v| Cell::new(short(v, 2))));
        row
    };
    let head =
        ["run", "setting", "steps", "repeated", "factorisations", "solves", "CPU (s)", "error in time", "whole error"];
    let note = "9 particles per cell, traction on the free surface; quasi-static runs with bspline2. Error in time: relative to \
                tolerance 1e-10 on the same mesh, or extrapolated from the two shortest steps. Whole error: against \
                compressible water.";
    let rows: Vec<Vec<Cell>> = sweeps.time.iter().map(row).collect();
    if rows.is_empty() { Vec::new() } else { vec![table("Steps and tolerances".to_owned(), &head, rows, note)] }
}

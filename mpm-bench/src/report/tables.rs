//! The tables of the pages.

use mpm_verify::report::content::table::{Cell, Table, table};
use mpm_verify::report::numbers::{exact, short};

use super::Findings;
use super::words::{in_time, share, time, times, wanted};
use crate::baseline;
use crate::cheapest::{Cost, WANTED};
use crate::growth::Growth;
use crate::peers::Peer;
use crate::row::{MOVING, Row};

/// CPU time of every integrator with every kind of shape functions for every wanted error: of the cheapest setting, or of the best one
/// where the error is not reached.
pub fn cost(costs: &[Cost]) -> Table {
    let mut head = vec!["integrator, shape functions".to_owned()];
    head.extend(WANTED.map(wanted));
    let cell = |cost: &Cost| {
        let r = cost.row;
        let particles = if r.ppc > 0 {
            format!("L = {} m\n{} per cell", r.mesh_m, r.ppc)
        } else {
            format!("{} cells", r.particles)
        };
        let small = format!("{particles}\n{}", briefly(r));
        match cost.is_reached() {
            true => Cell::new(time(r.cpu_s)).marked(small, ""),
            false => Cell::new(format!("{} in {}", share(cost.error), time(r.cpu_s))).marked(small, "warn"),
        }
    };
    let lines = costs.chunk_by(|a, b| (&a.row.integrator, &a.row.scheme) == (&b.row.integrator, &b.row.scheme));
    let line = |own: &[Cost]| {
        let name = own.first().map_or_else(String::new, |c| format!("{}, {}", c.row.integrator, c.row.scheme));
        std::iter::once(Cell::new(name)).chain(own.iter().map(cell)).collect()
    };
    let heads: Vec<&str> = head.iter().map(String::as_str).collect();
    table(
        "CPU time for a wanted error".to_owned(),
        &heads,
        lines.map(line).collect(),
        "CPU time of the cheapest setting of that integrator and these shape functions; below it its cells, particles and steps. Where no \
         setting reaches the error, the smallest error that one reaches and its time. Errors are relative to the exact solution with finite K_w.",
    )
}

/// How fine a setting is in time, in few words.
fn briefly(row: &Row) -> String {
    let own_steps =
        row.integrator.starts_with("quasi-static") || row.integrator.ends_with(MOVING) || baseline::is(&row.integrator);
    if own_steps { in_time(row) } else { format!("step {} s", short(row.dt_or_tol, 2)) }
}

/// Fitted and expected exponents.
pub fn growth(findings: &Findings) -> Table {
    let line = |g: &Growth| {
        let exponent = |f: &mpm_verify::rates::Fit| {
            let width = if f.half_width.is_finite() { format!(" \u{b1} {:.2}", f.half_width) } else { String::new() };
            format!("{:.2}{width}", f.order)
        };
        let ends = [g.times.first(), g.times.last()].map(|t| t.copied().unwrap_or((f64::NAN, f64::NAN)));
        [
            g.integrator.clone(),
            g.scheme.clone(),
            g.ppc.to_string(),
            format!("{} to {}", ends[0].0, ends[1].0),
            format!("{} to {}", time(ends[0].1), time(ends[1].1)),
            exponent(&g.measured),
            exponent(&g.counted),
            g.work.replace(" x ", " \u{d7} "),
            g.limit.to_owned(),
        ]
        .map(Cell::new)
        .to_vec()
    };
    let head = [
        "integrator",
        "shape functions",
        "particles per cell",
        "L (m)",
        "CPU time",
        "measured",
        "expected",
        "from",
        "in the limit",
    ];
    table(
        "Exponent n of CPU time \u{221d} (1/L)\u{207f}".to_owned(),
        &head,
        findings.growths.iter().map(line).collect(),
        "Fitted over all meshes from 0.1 m down, with the half width of the 95 % interval. Expected: the same fit of \
         the work that was counted. Explicit steps pass from the limit of waves (dt \u{221d} L) to that of drainage \
         (dt \u{221d} L\u{b2}) as L falls; semi-implicit ones, which water helps \
         on coarse meshes, end at the limit of waves; quasi-static runs are \
         a few banded solves. Set-up and reading, which hardly grow, make cheap runs grow slower than their work. \
         Automatic steps; quasi-static with tolerance 1e-4.",
    )
}

/// The fields of `growth.csv`.
pub fn growth_fields(g: &Growth) -> Vec<String> {
    let ends = [g.times.first(), g.times.last()].map(|t| t.map_or(f64::NAN, |t| t.0));
    vec![
        g.integrator.clone(),
        g.scheme.clone(),
        g.ppc.to_string(),
        exact(ends[0]),
        exact(ends[1]),
        g.times.len().to_string(),
        exact(g.measured.order),
        exact(g.measured.half_width),
        exact(g.counted.order),
        exact(g.counted.half_width),
        g.work.to_owned(),
        g.limit.to_owned(),
    ]
}

/// What the full width costs beside the column.
pub fn dimensions(findings: &Findings) -> Table {
    let mut lines = Vec::new();
    for wide in findings.rows.iter().filter(|r| r.dimension == "plane-strain") {
        let name = wide.case.trim_end_matches("-plane-strain");
        let Some(column) = findings.rows.iter().find(|r| r.case == name) else { continue };
        let cells = [
            wide.mesh_m.to_string(),
            format!("{} / {}", column.particles, wide.particles),
            format!("{} / {}", column.steps, wide.steps),
            format!("{} / {}", time(column.cpu_s), time(wide.cpu_s)),
            times(wide.cpu_s / column.cpu_s),
            format!("{} / {}", short(column.ns_per_point_step, 2), short(wide.ns_per_point_step, 2)),
            format!("{} / {}", share(column.max_error_compressible), share(wide.max_error_compressible)),
        ];
        lines.push(cells.map(Cell::new).to_vec());
    }
    let head = ["L (m)", "particles", "steps", "CPU time", "ratio", "per point-step (ns)", "error, compressible"];
    table(
        "What the second dimension costs: explicit, `centre`, 4 per cell, column / full width of 0.1 m".to_owned(),
        &head,
        lines,
        "One point-step is one solid particle with its water particle, one step.",
    )
}

/// Other codes.
pub fn peers(peers: &[Peer]) -> Table {
    let line = |p: &Peer| {
        let error = |e: Option<f64>| e.map_or_else(|| "\u{2013}".to_owned(), share);
        let cpu = if p.cpu_low_s < p.cpu_high_s {
            format!("{} to {}", time(p.cpu_low_s), time(p.cpu_high_s))
        } else {
            time(p.cpu_low_s)
        };
        [
            p.peer.clone(),
            p.version.clone(),
            p.setting.clone(),
            p.mesh_m.to_string(),
            p.steps.to_string(),
            error(p.max_error_compressible),
            error(p.max_error_terzaghi),
            cpu,
            p.timed.clone(),
        ]
        .map(Cell::new)
        .to_vec()
    };
    let head = [
        "code",
        "version",
        "setting",
        "L (m)",
        "steps",
        "error, compressible",
        "error, Terzaghi",
        "CPU time",
        "what was timed",
    ];
    table(
        "Measured elsewhere (reference-data/peers/terzaghi.csv)".to_owned(),
        &head,
        peers.iter().map(line).collect(),
        "One thread of a machine with two cores under load; `process` includes start and files.",
    )
}

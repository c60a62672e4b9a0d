//! The tables of the pages.

use mpm_verify::report::content::table::{Cell, Table, table};
use mpm_verify::report::numbers::{exact, short};
use mpm_verify::report::plots::schemes::LOOKS;

use super::Findings;
use super::words::{bytes, in_time, setting, share, time, times, wanted};
use crate::baseline::{self, Kind};
use crate::cheapest::{self, WANTED, best};
use crate::growth::Growth;
use crate::peers::Peer;
use crate::row::{MOVING, Row};

/// A row per wanted error and integrator, the cheapest first; integrators that do not get there last.
pub fn cheapest(findings: &Findings) -> Table {
    let rows = &findings.rows;
    let found = cheapest::table(rows);
    let mut lines = Vec::new();
    for error in WANTED {
        let reached: Vec<_> = found.iter().filter(|c| c.wanted == error).collect();
        let least = reached.first().map_or(f64::NAN, |c| c.row.cpu_s);
        for (place, one) in reached.iter().enumerate() {
            let r = one.row;
            let spread =
                if r.runs > 1 { format!("\u{b1} {} %", short(100.0 * r.spread(), 2)) } else { "one run".to_owned() };
            let cells = [
                wanted(error) + ": " + &r.integrator,
                time(r.cpu_s),
                times(r.cpu_s / least),
                times(one.ratios()[0]),
                times(one.ratios()[1]),
                share(r.max_error_compressible),
                share(r.max_error_terzaghi),
                r.steps.to_string(),
                bytes(r.peak_bytes),
            ];
            let mut cells = cells.map(Cell::new);
            cells[0] = cells[0].clone().marked(setting(r), "");
            cells[1] = cells[1].clone().marked(spread, if place == 0 { "paper" } else { "" });
            lines.push(cells.to_vec());
        }
        for name in baseline::with_integrators().iter().filter(|n| !baseline::is(n)) {
            let Some((nearest, least)) = best(rows, |r| r.integrator == *name) else { continue };
            if !reached.iter().any(|c| c.row.integrator == *name) {
                let text = format!("not reached; best {}: {}", share(least), setting(nearest));
                let dash = || Cell::new("\u{2013}");
                let mut cells = vec![Cell::new(wanted(error) + ": " + name).marked(text, "")];
                cells.extend((0..8).map(|_| dash()));
                lines.push(cells);
            }
        }
        for kind in Kind::ALL {
            let Some(r) = cheapest::cheapest(rows, error, |r| r.scheme == kind.scheme()) else { continue };
            let over = |other: Kind| {
                let other = cheapest::cheapest(rows, error, |r| r.scheme == other.scheme());
                times(r.cpu_s / other.map_or(f64::NAN, |o| o.cpu_s))
            };
            let cells = [
                format!("{}: {} baseline", wanted(error), kind.word()),
                time(r.cpu_s),
                times(r.cpu_s / least),
                over(Kind::Plain),
                over(Kind::Graded),
                share(r.max_error_compressible),
                share(r.max_error_terzaghi),
                r.steps.to_string(),
                bytes(r.peak_bytes),
            ];
            let mut cells = cells.map(Cell::new);
            cells[0] = cells[0].clone().marked(setting(r), "");
            lines.push(cells.to_vec());
        }
    }
    let head = [
        "wanted error and setting",
        "CPU time",
        "over the cheapest",
        "over the plain baseline",
        "over the graded one",
        "error, compressible",
        "error, Terzaghi",
        "steps",
        "memory",
    ];
    table(
        "The cheapest setting of each integrator for a wanted error".to_owned(),
        &head,
        lines,
        "The wanted error is that relative to the exact solution with finite K_w. Small letters: half the range of all timed samples. Steps of the \
         Krylov method are basis vectors.",
    )
}

/// CPU time per integrator and kind of shape functions for every wanted error.
pub fn schemes(findings: &Findings) -> Table {
    let mut head = vec!["integrator", "shape functions"];
    let wanted: Vec<String> = WANTED.iter().map(|e| wanted(*e)).collect();
    head.extend(wanted.iter().map(String::as_str));
    head.push("best error");
    let mut lines = Vec::new();
    for name in baseline::with_integrators() {
        let schemes: Vec<&str> = if baseline::is(&name) {
            Kind::ALL.map(Kind::scheme).to_vec()
        } else {
            LOOKS.iter().map(|(scheme, _)| *scheme).collect()
        };
        for scheme in schemes {
            let own = |r: &Row| r.integrator == name && r.scheme == scheme;
            if !findings.rows.iter().any(own) {
                continue;
            }
            let mut cells = vec![Cell::new(name.clone()), Cell::new(scheme)];
            for error in WANTED {
                let found = cheapest::cheapest(&findings.rows, error, own);
                cells.push(found.map_or_else(
                    || Cell::new("not reached"),
                    |r| {
                        let particles = if r.ppc > 0 { format!("{} per cell\n", r.ppc) } else { String::new() };
                        let small = format!("L = {} m\n{particles}{}", short(r.mesh_m, 2), briefly(r));
                        Cell::new(time(r.cpu_s)).marked(small, "")
                    },
                ));
            }
            let nearest = best(&findings.rows, own);
            cells.push(nearest.map_or_else(|| Cell::new("\u{2013}"), |(_, error)| Cell::new(share(error))));
            lines.push(cells);
        }
    }
    table(
        "CPU time that every integrator and scheme needs for a wanted error".to_owned(),
        &head,
        lines,
        "The best error is the smallest that a setting reaches and keeps as its steps get finer.",
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

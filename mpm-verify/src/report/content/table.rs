//! The tables of the pages. Errors in percent with three significant digits.

use crate::budget::Budget;
use crate::cost::Cost;
use crate::norms::LATE_TV;
pub use crate::page::table::{Cell, Table};
use crate::rates::{Convergence, FARTHEST, LEAST_MESHES, Order, WIDEST};
use crate::report::Study;
use crate::report::numbers::{percent, short};
use crate::report::orders::Group;
use crate::report::select::{Cases, LOADS, PAPER, Reference, families, meshes, particles};
use crate::study::{CaseResult, shown_family};
use crate::verdict::State;

/// A table without names over its columns.
pub fn table(title: String, head: &[&str], rows: Vec<Vec<Cell>>, note: &str) -> Table {
    Table::new(title, head, rows, note)
}

/// A number of a case; says so if the case failed or was forced.
fn of_case(case: &CaseResult, text: String) -> Cell {
    let is_paper = (case.mesh_m / PAPER.0 - 1.0).abs() < 1e-9 && case.ppc == PAPER.1;
    match (&case.failure, case.forced) {
        (Some(_), true) => Cell::new("failed").marked("forced", "bad"),
        (Some(_), false) => Cell::new("failed").marked("", "bad"),
        (None, true) => Cell::new(text).marked("forced", "warn"),
        (None, false) => Cell::new(text).marked("", if is_paper { "paper" } else { "" }),
    }
}

/// The case of a mesh, if it was run.
fn find<'a>(cases: &[&'a CaseResult], load: &str, mesh: f64, ppc: usize) -> Option<&'a CaseResult> {
    cases.iter().copied().find(|r| r.load == load && r.mesh_m == mesh && r.ppc == ppc)
}

/// Loads that some cases have, with how they read.
fn loads(cases: &[&CaseResult]) -> Vec<(&'static str, &'static str)> {
    LOADS.into_iter().filter(|(load, _)| cases.iter().any(|r| r.load == *load)).collect()
}

/// Rows of meshes, columns of particles, for several numbers side by side.
fn by_mesh(cases: &[&CaseResult], load: &str, numbers: &[&dyn Fn(&CaseResult) -> String]) -> Vec<Vec<Cell>> {
    let row = |mesh: f64| {
        let mut row = vec![Cell::new(mesh.to_string())];
        for number in numbers {
            for ppc in particles(cases) {
                let found = find(cases, load, mesh, ppc);
                row.push(found.map_or_else(|| Cell::new("not run"), |r| of_case(r, number(r))));
            }
        }
        row
    };
    meshes(cases).into_iter().map(row).collect()
}

/// Heads of [`by_mesh`].
fn by_mesh_head(cases: &[&CaseResult], names: &[&str]) -> (Vec<(String, usize)>, Vec<String>) {
    let count = particles(cases);
    let mut groups = vec![(String::new(), 1)];
    let mut head = vec!["L (m)".to_owned()];
    for name in names {
        groups.push(((*name).to_owned(), count.len()));
        head.extend(count.iter().map(|ppc| format!("{ppc} per cell")));
    }
    (groups, head)
}

/// The family that the study is about, with all its base cases.
fn shown(results: &[CaseResult]) -> Option<(String, Vec<&CaseResult>)> {
    let name = shown_family(results)?;
    families(results).into_iter().find(|(family, _)| *family == name)
}

/// Largest errors per mesh, traction and particles relative to both exact solutions.
pub fn errors(results: &[CaseResult]) -> Option<Table> {
    let (family, cases) = shown(results)?;
    let [terzaghi, compressible] = Reference::BOTH;
    let numbers: [&dyn Fn(&CaseResult) -> String; 2] =
        [&|r| percent(terzaghi.largest(r)), &|r| percent(compressible.largest(r))];
    let (groups, head) = by_mesh_head(&cases, &["relative to Terzaghi (%)", "relative to finite K_w (%)"]);
    let mut rows = Vec::new();
    for (load, words) in loads(&cases) {
        rows.extend(by_mesh(&cases, load, &numbers).into_iter().map(|mut row| {
            if let Some(first) = row.first_mut() {
                *first = first.clone().small(words);
            }
            row
        }));
    }
    let note = "max |U/U_exact \u{2212} 1| over nine times from Tv = 0.01 to 1. In bold: the paper's mesh and particles. \
                Finite K_w: the exact solution with finite bulk modulus of the pore water.";
    let heads: Vec<&str> = head.iter().map(String::as_str).collect();
    Some(Table { groups, ..table(format!("Largest error of U ({family})"), &heads, rows, note) })
}

/// Orders of one family beside those of theory, a table per exact solution.
pub fn orders(groups: &[Group], family: &str) -> Vec<Table> {
    let groups: Vec<&Group> = groups.iter().filter(|g| g.name.starts_with(&format!("{family}-"))).collect();
    if groups.is_empty() {
        return Vec::new();
    }
    let fits = |group: &Group, reference: &str| {
        let mut row = vec![Cell::new(group.name.clone()).marked(format!("{} meshes", group.meshes.len()), "")];
        let own = group.fits.iter().filter(|(norm, _)| norm.ends_with(reference));
        row.extend(own.map(|(_, found)| order_of_group(found)));
        row
    };
    let compressible = |group: &Group| {
        let mut row = fits(group, "compressible");
        row.push(richardson_cell(group));
        row
    };
    let head = ["group", "max error", "late error", "profile", "U at Tv = 0.1 for L → 0"];
    let explained = format!(
        "{} Small letters: the order of theory, and the pairwise orders from coarse to fine. Last column: Richardson's extrapolation from \
         the three finest meshes.",
        order_rule()
    );
    let little = "Orders relative to Terzaghi mean little: the error tends to the constant that the water's \
                  compressibility makes.";
    let rows = |row: &dyn Fn(&Group) -> Vec<Cell>| groups.iter().copied().map(row).collect();
    vec![
        table(
            "Orders relative to the exact solution with finite K_w".to_owned(),
            &head,
            rows(&compressible),
            &explained,
        ),
        table("Orders relative to Terzaghi".to_owned(), &head[..4], rows(&|g| fits(g, "terzaghi")), little),
    ]
}

fn richardson_cell(group: &Group) -> Cell {
    match &group.richardson {
        Some(r) => Cell::new(format!("{:.5}", r.value))
            .marked(format!("exact {:.5}\norder {}, GCI {} %", group.exact, short(r.order, 3), percent(r.gci)), ""),
        None => Cell::new("–").marked("not monotonic", ""),
    }
}

/// An order with its verdict, in the colour of its state.
pub fn order_cell(found: &Convergence) -> Cell {
    let mark = found.state().map_or("", State::mark);
    match found.order {
        Order::NotEstablished => Cell::new("not established").marked(found.fitted().unwrap_or_default(), mark),
        _ => Cell::new(found.words()).marked("", mark),
    }
}

/// Order of a convergence with that of theory and the pairwise orders.
pub fn order_of_group(found: &Convergence) -> Cell {
    let cell = order_cell(found);
    if found.order == Order::NotExpected {
        return cell;
    }
    let pairs = found.fit.iter().flat_map(|fit| &fit.pairwise).map(|p| short_order(*p)).collect::<Vec<_>>().join(", ");
    let theory = format!("theory {}", found.theory_words());
    let small = [cell.small.clone(), theory, pairs].into_iter().filter(|line| !line.is_empty());
    cell.clone().small(small.collect::<Vec<_>>().join("\n"))
}

/// The one rule for orders, as a note below a table says it.
pub fn order_rule() -> String {
    format!(
        "Order: slope of log |error| with its 95 % interval. It is established by {LEAST_MESHES} runs or more and an interval of at most \
         ± {WIDEST}, and passes within {FARTHEST} of theory, on both sides; round-off: errors within ten times of what the arithmetic \
         allows; elsewhere it is not established, and the error alone decides."
    )
}

/// One decimal, without a sign at zero.
fn short_order(order: f64) -> String {
    format!("{:.1}", (10.0 * order).round() / 10.0 + 0.0).replace('-', "\u{2212}")
}

/// Parts of the error relative to Terzaghi, at the first time and at Tv = 0.1, a table per load.
pub fn budgets(study: &Study) -> Vec<Table> {
    let cases = Cases::of(&study.results);
    let ppc = cases.usual_particles().unwrap_or(0);
    let mut tables = Vec::new();
    for tv in [0.01, LATE_TV] {
        for (load, words) in LOADS {
            let budgets = cases.budgets(study, load, tv);
            let Some(first) = budgets.first() else { continue };
            let mut head = vec!["L (m)"];
            head.extend(first.parts().map(|(name, _)| name));
            head.push("total");
            let row = |b: &&Budget| {
                let mut row = vec![Cell::new(b.mesh_m.to_string())];
                row.extend(b.parts().map(|(_, share)| Cell::new(percent(share))));
                row.push(Cell::new(percent(b.total)).marked("", "paper"));
                row
            };
            let rows = budgets.iter().map(row).collect();
            let title = format!("Parts of the error at Tv = {tv}, {words}, {ppc} particles per cell (%)");
            tables.push(table(title, &head, rows, "Shares of Terzaghi's U at the same time, signed."));
        }
    }
    tables
}

/// Steps and times of the runs with one load.
pub fn speed(results: &[CaseResult]) -> Vec<Table> {
    let mut tables = Vec::new();
    if let Some((family, cases)) = shown(results)
        && let Some((load, words)) = loads(&cases).first().copied()
    {
        let numbers: [&dyn Fn(&CaseResult) -> String; 3] =
            [&|r| r.steps.to_string(), &|r| short(r.cpu_s, 3), &|r| short(r.ns_per_point_step, 3)];
        let (groups, head) = by_mesh_head(&cases, &["steps", "CPU time (s)", "per point-step (ns)"]);
        let rows = by_mesh(&cases, load, &numbers);
        let note = "One point-step is one solid particle with its water particle, one step. The time step is the \
                    stability limit times a safety factor, so that steps grow faster than 1/L. Times are of one machine: \
                    compare ratios.";
        let title = format!("Speed, {words} ({family})");
        let heads: Vec<&str> = head.iter().map(String::as_str).collect();
        tables.push(Table { groups, ..table(title, &heads, rows, note) });
    }
    tables
}

/// What a step costs along several paths; no table where it was not measured.
pub fn costs(costs: &[Cost]) -> Option<Table> {
    let row = |c: &Cost| {
        let spread = format!("{} to {}", short(c.spread_ns[0], 3), short(c.spread_ns[1], 3));
        let (points, bytes) = (c.points.to_string(), c.bytes_per_point.to_string());
        [c.path.clone(), points, short(c.ns_per_point_step, 3), spread, short(c.ratio, 2), bytes]
            .map(Cell::new)
            .to_vec()
    };
    let head =
        ["scene uses", "particles", "per point-step (ns)", "spread (ns)", "ratio to the first", "bytes per particle"];
    let note = "Median and spread of five timings on one thread, 4 particles per cell and layer (2 in a column), one \
                after the other in the same run. A scene is slower only by what it uses.";
    let rows = costs.iter().map(row).collect();
    (!costs.is_empty()).then(|| table("What a step costs".to_owned(), &head, rows, note))
}

/// Names over several columns of the table of all cases, with the number of columns.
const CASE_GROUPS: [(&str, usize); 4] =
    [("", 9), ("relative to Terzaghi (%)", 3), ("relative to finite K_w (%)", 3), ("", 2)];
/// Heads of the table of all cases.
const CASE_HEAD: [&str; 17] = [
    "integrator and scheme",
    "run",
    "L (m)",
    "per cell",
    "traction on",
    "particles",
    "step (s)",
    "step/limit",
    "steps",
    "max",
    "late",
    "profile",
    "max",
    "late",
    "profile",
    "settled (mm)",
    "crossings",
];

/// Every case with its numbers, in one table.
pub fn cases(results: &[CaseResult]) -> Table {
    let row = |r: &&CaseResult| {
        let (word, mark, why) = match (&r.failure, r.forced) {
            (Some(why), _) => ("failed", "bad", why.as_str()),
            (None, true) => ("forced", "warn", "above the stability limit"),
            (None, false) => ("complete", "good", ""),
        };
        let ratio = r.dt_s / r.limit_s;
        let mut row = vec![
            Cell::new(r.family())
                .small(if r.dimension == "column" { "" } else { r.dimension.as_str() })
                .anchored(&r.case),
            Cell::badge(word, mark).small(why),
            Cell::new(r.mesh_m.to_string()),
            Cell::new(r.ppc.to_string()),
            Cell::new(r.load.clone()),
            Cell::new(r.particles.to_string()),
            Cell::new(short(r.dt_s, 3)),
            Cell::new(short(ratio, 2)).marked("", if ratio > 1.0 { "warn" } else { "" }),
            Cell::new(r.steps.to_string()),
        ];
        let errors = [
            r.max_error_terzaghi,
            r.late_error_terzaghi,
            r.profile_error_terzaghi,
            r.max_error_compressible,
            r.late_error_compressible,
            r.profile_error_compressible,
        ];
        row.extend(errors.map(|e| Cell::new(percent(e))));
        row.push(Cell::new(short(1e3 * r.settlement_final_m, 4)));
        row.push(Cell::new(r.cell_crossings.to_string()));
        row
    };
    let families = families(results);
    let rows = families.iter().flat_map(|(_, cases)| cases.iter().map(row)).collect();
    let note = "Errors of U: max over nine times, late for Tv \u{2265} 0.1; profile: of the pore pressure at Tv = 0.1.";
    let groups = CASE_GROUPS.map(|(name, columns)| (name.to_owned(), columns)).to_vec();
    Table { groups, ..table("All cases".to_owned(), &CASE_HEAD, rows, note) }
}

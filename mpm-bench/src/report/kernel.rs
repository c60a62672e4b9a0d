//! The section "What a step costs": sentences, tables and a picture from what was measured.

use std::path::Path;

use mpm_core::hardware::THREADS_PAY_FROM;
use mpm_verify::report::ReportError;
use mpm_verify::report::content::table::{Cell, Table, table as content_table};
use mpm_verify::report::numbers::short;
use mpm_verify::report::plots::axis::Axis;
use mpm_verify::report::plots::figure::{Figure, Mark, Panel, Point, Series};
use mpm_verify::report::plots::look::{BLACK, BLUE, Dash, GREEN, GREY, Look, Marker, ORANGE, RED};
use mpm_verify::report::tables::table;

use super::section::Section;
use crate::kernel::sizes::{self, FOUR, LANES, PLAIN, Timing};
use crate::kernel::{Kernel, limits, plane, stages};

/// Time per point-step over the number of points.
pub const PLOT: &str = "kernel-cost-against-points";
/// What a step may cost, ns per point-step: the line of the picture.
const ASKED_NS: f64 = 10.0;
/// How much dearer a point-step of the largest size may be than one of the smallest.
const ASKED_GROWTH: f64 = 1.8;
/// Exponent of the operations of nested dissection over the unknowns of a plane.
const SOLVES_GROW: f64 = 1.5;
/// A second thread pays from where it makes a run this much faster.
const PAYS: f64 = 1.1;

/// Writes the tables of the section as CSV.
///
/// # Errors
/// A file that cannot be written.
pub fn write(kernel: &Kernel, folder: &Path) -> Result<(), ReportError> {
    table(&folder.join("kernel_sizes.csv"), sizes::COLUMNS, kernel.timings.iter().map(Timing::fields))?;
    table(&folder.join("kernel_stages.csv"), stages::COLUMNS, kernel.shares.iter().map(stages::Share::fields))?;
    table(&folder.join("kernel_limits.csv"), limits::COLUMNS, kernel.limits.iter().map(limits::Limit::fields))?;
    table(&folder.join("plane_solves.csv"), plane::COLUMNS, kernel.solves.iter().map(plane::Solve::fields))
}

/// The section.
pub fn section(kernel: &Kernel) -> Section {
    Section {
        id: "kernel",
        title: "What limits us: a step of the explicit integrator",
        text: [cost(kernel), threads(kernel), spent(kernel), solves(kernel)]
            .into_iter()
            .filter(|t| !t.is_empty())
            .collect(),
        items: Vec::new(),
        pictures: vec![PLOT],
        tables: vec![by_limit(kernel), by_size(kernel), by_stage(kernel), by_unknowns(kernel)],
    }
}

/// Timings of a kernel on so many threads, small sizes first.
fn of<'a>(kernel: &'a Kernel, name: &'a str, threads: usize) -> impl Iterator<Item = &'a Timing> {
    kernel.timings.iter().filter(move |t| t.is(name, threads))
}

/// What is quoted of a timing: CPU time on one thread, the clock on several, ns.
fn quoted(timing: &Timing) -> f64 {
    timing.cpu_ns.unwrap_or(timing.wall_ns[0])
}

/// How much dearer a vectorised point-step is at the largest size than at the smallest.
fn growth(kernel: &Kernel) -> Option<f64> {
    let (small, large) = (of(kernel, LANES, 1).next()?, of(kernel, LANES, 1).last()?);
    Some(quoted(large) / quoted(small))
}

/// A count in groups of three digits.
fn count(n: usize) -> String {
    let digits = n.to_string();
    let groups: Vec<&str> = digits.as_bytes().rchunks(3).rev().map(|g| std::str::from_utf8(g).unwrap_or("")).collect();
    groups.join("\u{a0}")
}

fn ns(value: f64) -> String {
    format!("{} ns", short(value, 2))
}

fn within(holds: bool) -> &'static str {
    if holds { "within" } else { "above" }
}

fn cost(kernel: &Kernel) -> String {
    let (Some(small), Some(large)) = (of(kernel, LANES, 1).next(), of(kernel, LANES, 1).last()) else {
        return String::new();
    };
    let grown = growth(kernel).unwrap_or(f64::NAN);
    let mut text = format!(
        "An explicit step in plane strain (L = {} m, 4 particles per cell and layer) costs {} of CPU time per solid \
         particle with its water particle at {} points on one thread, {} the {} ns required, and {} at {}: {} times as \
         much, {} the {} required. It is vectorised with {}",
        kernel.cell_m,
        ns(quoted(small)),
        count(small.points),
        within(quoted(small) <= ASKED_NS),
        short(ASKED_NS, 2),
        ns(quoted(large)),
        count(large.points),
        short(grown, 3),
        within(grown <= ASKED_GROWTH),
        ASKED_GROWTH,
        kernel.instructions
    );
    if let Some(four) = of(kernel, FOUR, 1).next() {
        text += &format!("; with the four lanes of AVX2 it costs {}", ns(quoted(four)));
    }
    if let Some(plain) = of(kernel, PLAIN, 1).next() {
        let times = short(quoted(plain) / quoted(small), 2);
        text += &format!("; not vectorised it costs {}, {times} times as much", ns(quoted(plain)));
    }
    text + "."
}

fn threads(kernel: &Kernel) -> String {
    let two: Vec<&Timing> = of(kernel, LANES, 2).collect();
    let mut text = String::new();
    if two.is_empty() {
        text += "This machine has one core: no other number of threads was measured. ";
    } else {
        let speed_ups: Vec<String> = two
            .iter()
            .filter_map(|t| Some(format!("{} at {} points", short(t.speed_up?[0], 3), count(t.points))))
            .collect();
        text += &format!("Two threads make it faster by a factor of {}. ", speed_ups.join(", "));
    }
    text += &format!("By default a run uses more than one thread from {} points on", count(THREADS_PAY_FROM));
    text += &pays_from(kernel).map_or_else(
        || ". ".to_owned(),
        |points| format!("; here the second thread saves a tenth or more from {} points on. ", count(points)),
    );
    text + "After the same steps the settlement is identical, bit for bit, for every number of threads and every width of the \
            vectors; otherwise the program ends with an error."
}

/// The size from which on a second thread pays at every measured size.
fn pays_from(kernel: &Kernel) -> Option<usize> {
    let pays = |t: &&Timing| t.speed_up.is_some_and(|s| s[0] >= PAYS);
    let two: Vec<&Timing> = of(kernel, LANES, 2).collect();
    two.into_iter().rev().take_while(pays).last().map(|t| t.points)
}

fn spent(kernel: &Kernel) -> String {
    let mut text = String::new();
    for limit in &kernel.limits {
        if limit.kernel == limits::DRY {
            let (name, least) = limit.nearer();
            text += &format!(
                "Dry soil takes {} there, {} times what {name} allows ({}). ",
                ns(limit.measured_ns),
                short(limit.times(), 2),
                ns(least)
            );
            continue;
        }
        let longest = kernel.shares.iter().filter(|s| s.points == limit.points && s.in_step);
        let Some(longest) = longest.max_by(|a, b| a.share.total_cmp(&b.share)) else { continue };
        let (name, least) = limit.nearer();
        text += &format!(
            "At {} points {} % of a step is its pass over all particles ({}). {} operations would take {} and {} bytes \
             {} if nothing else were to be done: the step takes {} times what {name} allows ({}). ",
            count(limit.points),
            short(100.0 * longest.share, 2),
            longest.stage,
            short(limit.operations, 3),
            ns(limit.arithmetic_ns),
            short(limit.bytes, 3),
            ns(limit.memory_ns),
            short(limit.times(), 2),
            ns(least),
        );
    }
    text.trim_end().to_owned()
}

fn solves(kernel: &Kernel) -> String {
    let (Some(first), Some(last)) = (kernel.solves.first(), kernel.solves.last()) else { return String::new() };
    let time = |solve: &plane::Solve| format!("{} ms of CPU time", short(1e3 * solve.cpu_s, 2));
    let mut text = format!(
        "A quasi-static solve in plane strain (Mandel's problem, quadratic B-splines, every time from one factorisation) takes {} \
         on {} x {} cells, where its settlement is off by {}, and {} on {} x {} cells ({} unknowns, {} MB)",
        time(first),
        first.side,
        first.side,
        short(first.error, 2),
        time(last),
        last.side,
        last.side,
        count(last.unknowns),
        short(1e-6 * last.bytes as f64, 3),
    );
    if let Some(n) = plane::exponent(&kernel.solves) {
        let than = if n <= SOLVES_GROW { "at most as fast as" } else { "faster than" };
        text += &format!("; it grows with the power {} of the unknowns, {than} the power {SOLVES_GROW}", short(n, 3));
    }
    text + "."
}

fn by_unknowns(kernel: &Kernel) -> Table {
    let line = |s: &plane::Solve| {
        let cells = [
            format!("{} x {}", s.side, s.side),
            count(s.unknowns),
            short(s.error, 2),
            short(1e3 * s.cpu_s, 3),
            s.vectors.to_string(),
            short(1e-6 * s.bytes as f64, 3),
        ];
        cells.map(Cell::new).to_vec()
    };
    content_table(
        "Quasi-static solves in plane strain".to_owned(),
        &["cells", "unknowns", "error of the settlement", "CPU time (ms)", "basis vectors", "memory (MB)"],
        kernel.solves.iter().map(line).collect(),
        "Mandel's problem, tolerance 1e-5, set-up included, one thread; the error is the largest relative one at the times of the \
         scene.",
    )
}

fn by_size(kernel: &Kernel) -> Table {
    let line = |t: &Timing| {
        let range = |[_, low, high]: [f64; 3]| format!("{} to {}", short(low, 3), short(high, 3));
        let speed_up = t.speed_up.map_or_else(
            || Cell::new("\u{2013}"),
            |s| Cell::new(short(s[0], 3)).marked(format!("{} to {}", short(s[1], 3), short(s[2], 3)), ""),
        );
        vec![
            Cell::new(count(t.points)),
            Cell::new(t.kernel.clone()).marked(t.instructions.clone(), if t.default { "paper" } else { "" }),
            Cell::new(t.threads.to_string()),
            Cell::new(t.cpu_ns.map_or_else(|| "\u{2013}".to_owned(), |ns| short(ns, 3))),
            Cell::new(short(t.wall_ns[0], 3)).marked(range(t.wall_ns), ""),
            Cell::new(short(1e3 / t.wall_ns[0], 3)),
            speed_up,
        ]
    };
    let head = [
        "points",
        "kernel",
        "threads",
        "CPU time (ns)",
        "on the clock (ns)",
        "point-steps per \u{b5}s",
        "speed-up by threads",
    ];
    content_table(
        "Time per point-step".to_owned(),
        &head,
        kernel.timings.iter().map(line).collect(),
        "Medians; small: least and most. The kernels of a size take turns. In bold: what a run of this size uses unless \
         told otherwise. The speed-up is that of two samples taken one after the other.",
    )
}

fn by_stage(kernel: &Kernel) -> Table {
    let line = |s: &stages::Share| {
        let share = if s.in_step { format!("{} %", short(100.0 * s.share, 3)) } else { "\u{2013}".to_owned() };
        [count(s.points), s.stage.clone(), short(s.ns, 3), share].map(Cell::new).to_vec()
    };
    content_table(
        "Stages of a vectorised step, one thread".to_owned(),
        &["points", "stage", "per point (ns)", "share"],
        kernel.shares.iter().map(line).collect(),
        "The stage without a share follows a change of cells alone.",
    )
}

fn by_limit(kernel: &Kernel) -> Table {
    let line = |l: &limits::Limit| {
        let [operations, divisions, bytes] = l.per_ns.map(|n| short(n, 3));
        vec![
            Cell::new(l.kernel.clone()),
            Cell::new(count(l.points)),
            Cell::new(short(l.operations, 3)).marked(format!("{operations} per ns"), ""),
            Cell::new(short(l.divisions, 3)).marked(format!("{divisions} per ns"), ""),
            Cell::new(short(l.bytes, 3)).marked(format!("{bytes} per ns"), ""),
            Cell::new(short(l.arithmetic_ns, 2)),
            Cell::new(short(l.memory_ns, 2)),
            Cell::new(short(l.measured_ns, 3)),
            Cell::new(short(l.times(), 2)).marked(l.nearer().0, ""),
        ]
    };
    let head = [
        "soil",
        "points",
        "multiplications, additions",
        "divisions",
        "bytes",
        "arithmetic limit (ns)",
        "memory limit (ns)",
        "measured (ns)",
        "times the nearer limit",
    ];
    content_table(
        "A vectorised step beside the limits of the machine, per point-step on one thread".to_owned(),
        &head,
        kernel.limits.iter().map(line).collect(),
        "Operations are counted from the formulas, bytes from the records (`mpm-bench/src/kernel/operations.rs`, \
         `traffic.rs`). Small letters: the highest rate that was measured, multiplications and additions in registers alone \
         without fusing, bytes by changing in place an array as large as the data of the run.",
    )
}

/// The picture.
pub fn figure(kernel: &Kernel) -> Figure {
    let x = Axis::log("soil points", "points");
    let mut panel = Panel::new("", x, Axis::log("time per point-step (ns)", "ns_per_point_step"));
    let lines = [
        (PLAIN, 1, "not vectorised, one thread", Look::new(ORANGE, Marker::Down)),
        (FOUR, 1, "vectorised, AVX2, one thread", Look::new(GREEN, Marker::Diamond)),
        (LANES, 1, "vectorised, one thread", Look::new(BLUE, Marker::Circle)),
        (LANES, 2, "vectorised, two threads", Look::new(RED, Marker::Square).dash(Dash::Dashed)),
    ];
    for (name, threads, label, look) in lines {
        let points = of(kernel, name, threads).map(|t| Point::new(t.points as f64, quoted(t)));
        panel.add(Series::new(label, look, Mark::LinePoints, points));
    }
    let ends = panel.all_x().into_iter().fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
    if ends.0 < ends.1 {
        let asked = [ends.0, ends.1].map(|x| (x, ASKED_NS));
        let look = Look::new(BLACK, Marker::Dot).dash(Dash::Dotted);
        panel.add(Series::line(format!("{ASKED_NS} ns, required on one thread"), look, asked));
        let pay = THREADS_PAY_FROM as f64;
        let times = panel.all_y().into_iter().fold((f64::INFINITY, 0.0_f64), |(a, b), y| (a.min(y), b.max(y)));
        if ends.0 < pay && pay < ends.1 {
            let look = Look::new(GREY, Marker::Dot).dash(Dash::DashDot);
            let line = [times.0, times.1].map(|y| (pay, y));
            panel.add(Series::line("threads are used by default from here on", look, line).guide());
        }
    }
    Figure {
        name: PLOT,
        title: "Time per point-step over the number of soil points".to_owned(),
        caption:
            "Plane strain with water. CPU time on one thread, time on the clock on two. One point-step is one solid \
                  particle with its water particle, one step."
                .to_owned(),
        height: 380.0,
        panels: vec![panel],
        missing: Vec::new(),
    }
}

#[cfg(test)]
pub mod tests {
    //! Tests of the section, and an example that others use.

    use super::*;
    use crate::kernel::limits::Limit;
    use crate::kernel::machine::Machine;
    use crate::kernel::stages::Share;

    fn timing(kernel: &str, threads: usize, points: usize, ns: f64, speed_up: Option<f64>) -> Timing {
        Timing {
            kernel: kernel.to_owned(),
            instructions: "some".to_owned(),
            threads,
            points,
            steps: 10,
            samples: 3,
            wall_ns: [ns, ns, 1.5 * ns],
            cpu_ns: (threads == 1).then_some(ns),
            speed_up: speed_up.map(|s| [s, 0.9 * s, s]),
            default: kernel == LANES && (threads == 2) == (points >= THREADS_PAY_FROM),
            settlement_bits: 0x3f50_0000_0000_0000,
        }
    }

    fn solve(side: usize, cpu_s: f64) -> plane::Solve {
        plane::Solve { side, unknowns: side * side, error: 1e-6, cpu_s, vectors: 10, bytes: 20_000_000 }
    }

    /// Some findings.
    pub fn example() -> Kernel {
        let share = |stage: &str, share| Share { points: 1000, stage: stage.to_owned(), in_step: true, ns: 1.0, share };
        let machine = Machine { operations_per_ns: 84.0, divisions_per_ns: 1.25, bytes_per_ns: 358.0 };
        Kernel {
            instructions: "AVX-512, 8 lanes".to_owned(),
            cores: 2,
            cell_m: 0.02,
            timings: vec![
                timing(PLAIN, 1, 1000, 42.0, None),
                timing(LANES, 1, 1000, 6.0, None),
                timing(LANES, 2, 1000, 12.0, Some(0.5)),
                timing(FOUR, 1, 1000, 9.0, None),
                timing(LANES, 1, 100_000, 7.0, None),
                timing(LANES, 2, 100_000, 4.0, Some(1.75)),
                timing(LANES, 1, 1_000_000, 9.0, None),
                timing(LANES, 2, 1_000_000, 5.0, Some(1.8)),
            ],
            shares: vec![share("loads", 0.1), share("the pass", 0.9)],
            limits: vec![Limit::new(true, 1000, 6.0, &machine), Limit::new(false, 1000, 3.0, &machine)],
            solves: [(8, 4e-3), (16, 16e-3), (32, 64e-3)].map(|(side, cpu_s)| solve(side, cpu_s)).to_vec(),
        }
    }

    #[test]
    fn sentences_are_those_of_the_numbers() {
        let mut kernel = example();
        assert_eq!(growth(&kernel), Some(1.5));
        assert_eq!(pays_from(&kernel), Some(100_000));
        let text = section(&kernel).text.join("\n");
        for words in [
            "6.0 ns of CPU time",
            "within the 10 ns",
            "9.0 ns at 1\u{a0}000\u{a0}000: 1.50 times as much, within the 1.8",
            "AVX-512, 8 lanes; with the four lanes of AVX2 it costs 9.0 ns",
            "42 ns, 7.0 times",
            "0.500 at 1\u{a0}000 points, 1.75 at 100\u{a0}000 points",
            "a tenth or more from 100\u{a0}000 points on",
            "90 % of a step is its pass over all particles (the pass)",
            "3.0 times what arithmetic allows (2.0 ns)",
            "4.0 ms of CPU time on 8 x 8 cells, where its settlement is off by 1.0e\u{2212}6, and 64 ms",
            "with the power 1.00 of the unknowns, at most as fast as the power 1.5",
            "Dry soil takes 3.0 ns there, 2.3 times what arithmetic allows (1.3 ns)",
        ] {
            assert!(text.contains(words), "{words}: {text}");
        }
        for t in &mut kernel.timings {
            t.cpu_ns = t.cpu_ns.map(|ns| ns * if t.points > 1000 { 4.0 } else { 2.0 });
        }
        kernel.timings.retain(|t| t.threads == 1);
        let text = section(&kernel).text.join("\n");
        assert!(text.contains("above the 10 ns") && text.contains("above the 1.8"), "{text}");
        assert!(text.contains("This machine has one core") && pays_from(&kernel).is_none(), "{text}");
    }

    #[test]
    fn the_picture_has_a_line_per_kernel_and_the_one_asked_for() {
        let panel = &figure(&example()).panels[0];
        let points = |label: &str| -> Vec<(f64, f64)> {
            let series = panel.series.iter().find(|s| s.label.starts_with(label)).expect(label);
            series.points.iter().map(|p| (p.x, p.y)).collect()
        };
        assert_eq!(points("vectorised, one"), [(1e3, 6.0), (1e5, 7.0), (1e6, 9.0)]);
        assert_eq!(points("vectorised, two"), [(1e3, 12.0), (1e5, 4.0), (1e6, 5.0)]);
        assert_eq!(points("10 ns"), [(1e3, 10.0), (1e6, 10.0)]);
        assert_eq!(
            (points("not vectorised").len(), points("vectorised, AVX2").len(), points("threads").len()),
            (1, 1, 2)
        );
    }

    #[test]
    fn tables_have_a_cell_for_every_column() {
        let section = section(&example());
        assert_eq!(section.tables.iter().map(|t| t.rows.len()).collect::<Vec<_>>(), [2, 8, 2, 3]);
        for table in &section.tables {
            assert!(table.rows.iter().all(|row| row.len() == table.head.len()), "{}", table.title);
        }
        let folder = tempfile::tempdir().expect("a folder");
        write(&example(), folder.path()).expect("files");
        for (name, columns) in [("sizes", sizes::COLUMNS), ("stages", stages::COLUMNS), ("limits", limits::COLUMNS)] {
            let text = std::fs::read_to_string(folder.path().join(format!("kernel_{name}.csv"))).expect("a file");
            assert_eq!(text.lines().next(), Some(columns));
            assert!(text.lines().count() > 1);
        }
    }
}

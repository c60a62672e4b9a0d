//! The pictures.

use mpm_verify::report::plots::axis::Axis;
use mpm_verify::report::plots::figure::{Figure, Mark, Panel, Point, Series, share_x, share_y};
use mpm_verify::report::plots::look::{BLACK, BLUE, Dash, GREEN, GREY, Look, Marker, ORANGE, PURPLE, RED};
use mpm_verify::report::plots::schemes::LOOKS;

use super::{Findings, kernel};
use crate::baseline;
use crate::pareto::front;
use crate::row::{MOVING, Row};

/// Error against CPU time, both references.
pub const CPU: &str = "error-against-cpu";
/// The same by shape functions.
pub const CPU_SCHEMES: &str = "error-against-cpu-by-scheme";
/// Error against steps.
pub const STEPS: &str = "error-against-steps";
/// Error against particles.
pub const PARTICLES: &str = "error-against-particles";
/// CPU time over the cell edge.
pub const GROWTH: &str = "cpu-against-mesh";

/// All pictures in the order of the page.
pub fn figures(findings: &Findings) -> Vec<Figure> {
    let mut figures = vec![
        against_cpu(findings),
        by_scheme(findings),
        against_steps(findings),
        against_particles(findings),
        growth(findings),
    ];
    figures.extend(findings.kernel.as_ref().map(kernel::figure));
    figures
}

/// Comparison of the integrators, the same in every picture that compares them.
fn look_of(integrator: &str) -> Look {
    match integrator {
        "explicit" => Look::new(ORANGE, Marker::Down),
        "semi-implicit" => Look::new(GREEN, Marker::Up),
        "quasi-static" => Look::new(BLUE, Marker::Circle),
        moving if moving.ends_with(MOVING) => {
            let marker = if moving.starts_with("implicit") { Marker::Diamond } else { Marker::Right };
            Look::new(PURPLE, marker).dash(Dash::Dotted)
        }
        _ => Look::new(RED, Marker::Square).dash(Dash::Dashed),
    }
}

const ERROR: &str = "max |U/U_exact \u{2212} 1|";

fn cpu_axis() -> Axis {
    Axis::log("CPU time of a whole solve (s)", "cpu_s")
}

/// The points of some rows on the front of what is small in both directions, in order.
fn front_of(points: &[(f64, f64)]) -> Vec<Point> {
    let on = front(points);
    let mut kept: Vec<(f64, f64)> = points.iter().zip(on).filter(|(_, on)| *on).map(|(p, _)| *p).collect();
    kept.sort_by(|a, b| a.0.total_cmp(&b.0));
    kept.dedup();
    kept.into_iter().map(|(x, y)| Point::new(x, y)).collect()
}

/// A panel with every run as a dot, and the front of every integrator and of the baseline as a line.
fn panel(rows: &[Row], title: &str, x: Axis, of: impl Fn(&Row) -> f64, error: impl Fn(&Row) -> f64) -> Panel {
    let mut panel = Panel::new(title, x, Axis::log(ERROR, "max_error"));
    let points = |name: &str| -> Vec<(f64, f64)> {
        rows.iter().filter(|r| r.integrator == name && r.failure.is_none()).map(|r| (of(r), error(r))).collect()
    };
    for name in baseline::with_integrators() {
        let look = Look { marker: Marker::Dot, ..look_of(&name) }.radius(1.1);
        let dots = points(&name).into_iter().map(|(x, y)| Point::new(x, y));
        panel.add(Series::new(format!("{name}, every run"), look, Mark::Points, dots).unlisted());
    }
    for name in baseline::with_integrators() {
        let label = if baseline::is(&name) { "finite-volume baselines".to_owned() } else { name.clone() };
        let look = look_of(&name).radius(3.4);
        panel.add(Series::new(label, look, Mark::LinePoints, front_of(&points(&name))));
    }
    panel
}

fn against_cpu(findings: &Findings) -> Figure {
    let mut panels = vec![
        panel(
            &findings.rows,
            "relative to the exact solution with finite K_w",
            cpu_axis(),
            |r| r.cpu_s,
            |r| r.max_error_compressible,
        ),
        panel(&findings.rows, "relative to Terzaghi", cpu_axis(), |r| r.cpu_s, |r| r.max_error_terzaghi),
    ];
    for (panel, which) in panels.iter_mut().zip([0, 1]) {
        let known = findings.peers.iter().filter_map(|p| {
            let error = [p.max_error_compressible, p.max_error_terzaghi][which]?;
            // The first word, or what its users call it.
            let first = p.peer.split([' ', '/']).next().unwrap_or(&p.peer);
            let name = if first == "OpenGeoSys" { "OGS" } else { first };
            Some(Point::new(p.cpu_s(), error).note(name).open(true))
        });
        let look = Look::new(BLACK, Marker::Star).radius(4.5);
        panel.add(Series::new("other codes, measured elsewhere", look, Mark::Points, known));
    }
    share_x(&mut panels);
    // Room for the names of slow codes.
    for panel in &mut panels {
        panel.x.range = panel.x.range.map(|(start, end)| (start, 3.0 * end));
    }
    share_y(&mut panels);
    Figure {
        name: CPU,
        title: "Error against CPU time".to_owned(),
        caption: "Dots: every run. Lines: the Pareto front of an integrator, its settings that no other setting beats in both error and \
                  time. Errors relative to Terzaghi tend to 2.7 %, the difference of the two exact solutions; below it \
                  two errors of opposite sign cancel."
            .to_owned(),
        height: 470.0,
        panels,
        missing: Vec::new(),
    }
}

fn by_scheme(findings: &Findings) -> Figure {
    let mut panels = Vec::new();
    for name in baseline::with_integrators().iter().filter(|n| !baseline::is(n) && !n.ends_with(MOVING)) {
        let mut panel = Panel::new(name, cpu_axis(), Axis::log(ERROR, "max_error"));
        for (place, (scheme, look)) in LOOKS.into_iter().enumerate() {
            let own = |r: &&Row| r.integrator == *name && r.scheme == scheme && r.failure.is_none();
            let points: Vec<(f64, f64)> =
                findings.rows.iter().filter(own).map(|r| (r.cpu_s, r.max_error_compressible)).collect();
            let look = look.radius(5.2 - 0.8 * place as f64).width(2.8 - 0.5 * place as f64);
            panel.add(Series::new(scheme, look, Mark::LinePoints, front_of(&points)));
        }
        panels.push(panel);
    }
    share_x(&mut panels);
    share_y(&mut panels);
    Figure {
        name: CPU_SCHEMES,
        title: "Error against CPU time by shape functions: the front of each".to_owned(),
        caption: "Relative to the exact solution with finite K_w. Explicit and semi-implicit runs carry inertia and large strain, which \
                  the exact solution neglects: their errors tend to these effects."
            .to_owned(),
        height: 390.0,
        panels,
        missing: Vec::new(),
    }
}

fn against_steps(findings: &Findings) -> Figure {
    let axis = Axis::log("steps (Krylov: basis vectors)", "steps");
    Figure {
        name: STEPS,
        title: "Error against steps".to_owned(),
        caption: "Relative to the exact solution with finite K_w. Dots and lines as above. Steps differ in cost: the \
                  baseline and implicit runs solve a system in each, an explicit step visits every particle."
            .to_owned(),
        height: 400.0,
        panels: vec![panel(&findings.rows, "", axis, |r| r.steps as f64, |r| r.max_error_compressible)],
        missing: Vec::new(),
    }
}

fn against_particles(findings: &Findings) -> Figure {
    let column: Vec<Row> = findings.rows.iter().filter(|r| r.dimension == "column").cloned().collect();
    let axis = Axis::log("solid particles in the column (baseline: cells)", "particles");
    Figure {
        name: PARTICLES,
        title: "Error against particles".to_owned(),
        caption: "Relative to the exact solution with finite K_w, runs in one dimension. Dots and lines as above."
            .to_owned(),
        height: 400.0,
        panels: vec![panel(&column, "", axis, |r| r.particles as f64, |r| r.max_error_compressible)],
        missing: Vec::new(),
    }
}

fn growth(findings: &Findings) -> Figure {
    let mut panels = Vec::new();
    for (name, slopes) in [("explicit", [2, 3].as_slice()), ("semi-implicit", &[2]), ("quasi-static", &[1])] {
        let own = || findings.growths.iter().filter(|g| g.integrator == name);
        let ppc = own().next().map_or(4, |g| g.ppc);
        let mut panel = Panel::new(
            &format!("{name}, {ppc} per cell"),
            Axis::log("cell edge L (m)", "mesh_m"),
            Axis { label: "CPU time of a whole solve (s)".to_owned(), ..Axis::log("", "cpu_s") },
        );
        for (place, (scheme, look)) in LOOKS.into_iter().enumerate() {
            let look = look.radius(5.6 - place as f64).width(3.0 - 0.6 * place as f64);
            let line = own().filter(|g| g.scheme == scheme).flat_map(|g| g.times.iter());
            panel.add(Series::new(scheme, look, Mark::LinePoints, line.map(|(mesh, cpu)| Point::new(*mesh, *cpu))));
        }
        let (meshes, times) = (panel.all_x(), panel.all_y());
        let ends = |of: &[f64]| of.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(*v), b.max(*v)));
        let ((fine, coarse), (least, most)) = (ends(&meshes), ends(&times));
        if least < most {
            // Room for the powers below the data.
            panel.y = panel.y.range(0.4 * least, 1.5 * most);
        }
        for &slope in slopes.iter().filter(|_| fine < coarse) {
            let dash = [Dash::Dotted, Dash::DashDot, Dash::Dashed][(slope - 1) as usize];
            let line = [coarse, fine].map(|h| (h, 0.6 * least * (coarse / h).powi(slope)));
            panel.add(
                Series::line(
                    ["1/L", "1/L²", "1/L³"][(slope - 1) as usize],
                    Look::new(GREY, Marker::Dot).dash(dash),
                    line,
                )
                .guide(),
            );
        }
        panels.push(panel);
    }
    share_x(&mut panels);
    Figure {
        name: GROWTH,
        title: "CPU time over the cell edge".to_owned(),
        caption: "Automatic steps; quasi-static with tolerance 1e-4. Grey: powers of 1/L.".to_owned(),
        height: 360.0,
        panels,
        missing: Vec::new(),
    }
}

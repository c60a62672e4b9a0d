//! The pictures.

use mpm_verify::report::plots::axis::Axis;
use mpm_verify::report::plots::figure::{Figure, Mark, Panel, Point, Series, share_x, share_y};
use mpm_verify::report::plots::look::{BLACK, BLUE, Dash, GREEN, GREY, Look, Marker, ORANGE, PURPLE, RED, SKY};
use mpm_verify::report::plots::schemes::LOOKS;

use super::{Findings, kernel};
use crate::baseline;
use crate::cheapest::sure_error;
use crate::pareto::front;
use crate::peers::Peer;
use crate::row::{MOVING, Row};

/// The fronts of error against CPU time, of every integrator and code.
pub const FRONTS: &str = "fronts";
/// The same by shape functions.
pub const BY_SCHEME: &str = "error-against-cpu-by-scheme";
/// CPU time over the cell edge.
pub const GROWTH: &str = "cpu-against-mesh";

/// All pictures in the order of the page.
pub fn figures(findings: &Findings) -> Vec<Figure> {
    let points: Vec<(&Row, (f64, f64))> =
        findings.rows.iter().map(|row| (row, (row.cpu_s, sure_error(row, &findings.rows)))).collect();
    let mut figures = vec![fronts(&points, &findings.peers), by_scheme(&points), growth(findings)];
    figures.extend(findings.kernel.as_ref().map(kernel::figure));
    figures
}

/// Look of an integrator, the same in every picture that compares them.
fn look_of(integrator: &str) -> Look {
    match integrator {
        "explicit" => Look::new(ORANGE, Marker::Down),
        "semi-implicit" => Look::new(GREEN, Marker::Up),
        "quasi-static" => Look::new(BLUE, Marker::Circle),
        moving if moving.ends_with(MOVING) => {
            let (colour, marker) =
                if moving.starts_with("implicit") { (SKY, Marker::Diamond) } else { (PURPLE, Marker::Right) };
            Look::new(colour, marker).dash(Dash::Dotted)
        }
        _ => Look::new(RED, Marker::Square).dash(Dash::Dashed),
    }
}

const ERROR: &str = "max |U/U_exact \u{2212} 1|";

fn cpu_axis() -> Axis {
    Axis::log("CPU time of a whole solve (s)", "cpu_s")
}

/// The points on the front of what is small in both directions, in order.
fn front_of(points: &[(f64, f64)]) -> Vec<Point> {
    let on = front(points);
    let mut kept: Vec<(f64, f64)> =
        points.iter().zip(on).filter(|((_, error), on)| *on && error.is_finite()).map(|(p, _)| *p).collect();
    kept.sort_by(|a, b| a.0.total_cmp(&b.0));
    kept.dedup();
    kept.into_iter().map(|(x, y)| Point::new(x, y)).collect()
}

/// CPU time and error of some rows.
fn of(points: &[(&Row, (f64, f64))], which: impl Fn(&Row) -> bool) -> Vec<(f64, f64)> {
    points.iter().filter(|(row, _)| which(row)).map(|(_, point)| *point).collect()
}

/// The front of every integrator and of the baselines as a line, other codes as points with their names.
fn fronts(points: &[(&Row, (f64, f64))], peers: &[Peer]) -> Figure {
    let mut panel = Panel::new("", cpu_axis(), Axis::log(ERROR, "max_error"));
    for name in baseline::with_integrators() {
        let label = if baseline::is(&name) { "finite-volume baselines".to_owned() } else { name.clone() };
        let own = of(points, |r| r.integrator == name);
        panel.add(Series::new(label, look_of(&name).radius(3.4), Mark::LinePoints, front_of(&own)));
    }
    let mut codes: Vec<&str> = Vec::new();
    for peer in peers {
        if !codes.contains(&peer.peer.as_str()) {
            codes.push(&peer.peer);
        }
    }
    for (number, code) in codes.into_iter().flat_map(|code| [code; 2]).enumerate() {
        // Errors relative to Terzaghi are no part of the other front.
        let open = number % 2 == 1;
        let own = peers.iter().filter(|p| p.peer == code && p.max_error_compressible.is_none() == open);
        let own: Vec<(f64, f64)> =
            own.filter_map(|p| Some((p.cpu_s(), p.max_error_compressible.or(p.max_error_terzaghi)?))).collect();
        let points = front_of(&own).into_iter().enumerate();
        let points = points.map(|(place, point)| point.open(open).note(if place == 0 { code } else { "" }));
        let look = Look::new(BLACK, Marker::Star).radius(4.5).width(0.8).dash(Dash::Dotted);
        panel.add(Series::new("other codes, measured elsewhere", look, Mark::LinePoints, points));
    }
    // Room for the names of slow codes.
    share_x(std::slice::from_mut(&mut panel));
    panel.x.range = panel.x.range.map(|(start, end)| (start, 6.0 * end));
    Figure {
        name: FRONTS,
        title: "Speed against error: the cheapest settings".to_owned(),
        caption: "Each line is the Pareto front of an integrator over all its shape functions, meshes, particles and steps: no other of its \
                  settings has less error in less time. Errors are relative to the exact solution with finite K_w, those of open stars \
                  relative to Terzaghi."
            .to_owned(),
        height: 420.0,
        panels: vec![panel],
        missing: Vec::new(),
    }
}

fn by_scheme(points: &[(&Row, (f64, f64))]) -> Figure {
    let mut panels = Vec::new();
    for name in baseline::with_integrators().iter().filter(|n| !baseline::is(n) && !n.ends_with(MOVING)) {
        let mut panel = Panel::new(name, cpu_axis(), Axis::log(ERROR, "max_error"));
        for (place, (scheme, look)) in LOOKS.into_iter().enumerate() {
            let own = of(points, |r| r.integrator == *name && r.scheme == scheme);
            let look = look.radius(5.2 - 0.8 * place as f64).width(2.8 - 0.5 * place as f64);
            panel.add(Series::new(scheme, look, Mark::LinePoints, front_of(&own)));
        }
        panels.push(panel);
    }
    share_x(&mut panels);
    share_y(&mut panels);
    Figure {
        name: BY_SCHEME,
        title: "Error against CPU time by shape functions: the front of each".to_owned(),
        caption: "Relative to the exact solution with finite K_w. Explicit and semi-implicit runs carry inertia and large strain, which \
                  the exact solution neglects: their errors tend to these effects."
            .to_owned(),
        height: 390.0,
        panels,
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

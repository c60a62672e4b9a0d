//! A sketch of a scene: its soil, supports, loads, drained sides and water, drawn from the scene itself.

use mpm_core::scene::{Bearing, Dimension, Feed, Scene, Side, SolidSide};

/// Size of the drawing, px.
const SIZE: [f64; 2] = [420.0, 300.0];
/// Room around the soil, px.
const ROOM: f64 = 46.0;
/// A column is drawn at least so wide, as a share of its height.
const SLENDER: f64 = 0.3;

/// The place of a point of the scene on the drawing.
struct View {
    /// Lower left corner of the soil, m.
    low: [f64; 2],
    /// px per m along each axis.
    scale: [f64; 2],
    /// Left edge of the soil, px.
    left: f64,
}

impl View {
    fn new(corners: &[[f64; 2]]) -> Self {
        let end = |axis: usize, low: bool| {
            let all = corners.iter().map(|x| x[axis]);
            if low { all.fold(f64::INFINITY, f64::min) } else { all.fold(f64::NEG_INFINITY, f64::max) }
        };
        let low = [end(0, true), end(1, true)];
        let [wide, high] = [end(0, false) - low[0], end(1, false) - low[1]];
        let one = ((SIZE[0] - 2.0 * ROOM) / wide.max(SLENDER * high)).min((SIZE[1] - 2.0 * ROOM) / high);
        let across = one * (SLENDER * high / wide).max(1.0);
        Self { low, scale: [across, one], left: 0.5 * (SIZE[0] - across * wide) }
    }

    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.left + self.scale[0] * (x - self.low[0]), SIZE[1] - ROOM - self.scale[1] * (y - self.low[1])]
    }

    fn points(&self, corners: &[[f64; 2]]) -> String {
        let one = |x: &[f64; 2]| {
            let [x, y] = self.at(*x);
            format!("{x:.1},{y:.1}")
        };
        corners.iter().map(one).collect::<Vec<_>>().join(" ")
    }
}

/// A scene as an SVG element.
pub fn svg(scene: &Scene) -> String {
    let corners = scene.outline_or_box();
    let view = View::new(&corners);
    let outline = view.points(&corners);
    let mut parts = vec![format!("<polygon class=\"soil\" points=\"{outline}\"/>")];
    for region in &scene.regions {
        let points = view.points(&region.polygon);
        parts.push(format!("<polygon class=\"region\" clip-path=\"url(#soil)\" points=\"{points}\"/>"));
    }
    for layer in &scene.layers {
        let line = [[-1e6, layer.up_to], [1e6, layer.up_to]];
        parts.push(format!("<polyline class=\"edge\" clip-path=\"url(#soil)\" points=\"{}\"/>", view.points(&line)));
    }
    if let Some(level) = scene.free_surface.as_ref().and_then(|free| free.level) {
        let line = [[-1e6, level], [1e6, level]];
        parts.push(format!("<polyline class=\"water\" clip-path=\"url(#soil)\" points=\"{}\"/>", view.points(&line)));
    }
    let drained = scene.stages.last().map_or([false; 4], |stage| stage.drained);
    for edge in edges(&corners) {
        let side = edge.side as usize;
        parts.push(support(&view, &edge, scene.solid_sides[side]));
        if drained[side] {
            parts.push(format!("<polyline class=\"drained\" points=\"{}\"/>", view.points(&edge.ends)));
        }
        let feed = scene.free_surface.as_ref().and_then(|free| free.feeds[side]);
        parts.extend(loads(scene, side).into_iter().chain(feed.map(fed)).map(|word| arrows(&view, &edge, &word)));
    }
    for well in &scene.wells {
        let at = if scene.dimension == Dimension::Column { [0.5 * scene.width, well.at[1]] } else { well.at };
        let [x, y] = view.at(at);
        parts.push(format!("<circle class=\"well\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\"/>"));
    }
    parts.push(sizes(scene, &view));
    format!(
        "<svg class=\"sketch\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\"><defs><clipPath id=\"soil\"><polygon points=\"{outline}\"/></clipPath></defs>{}</svg>",
        SIZE[0],
        SIZE[1],
        super::escaped(&words(scene)),
        parts.concat()
    )
}

/// What is seen in the sketch.
pub fn words(scene: &Scene) -> String {
    let dimension = match scene.dimension {
        Dimension::Column => "a column",
        Dimension::PlaneStrain => "a section in plane strain",
        Dimension::Axisymmetric => "a section about an axis",
    };
    let sides = |which: &dyn Fn(usize) -> bool| {
        let names: Vec<&str> = Side::ALL.into_iter().filter(|side| which(*side as usize)).map(Side::word).collect();
        if names.is_empty() { "none".to_owned() } else { names.join(", ") }
    };
    let drained = scene.stages.last().map_or([false; 4], |stage| stage.drained);
    let tilt = scene.slope_angle.map_or_else(String::new, |angle| format!(" Gravity is inclined by {angle}°."));
    format!(
        "Sketch of {dimension}, {} m by {} m. Drained sides: {}. Supports: {} fixed, {} on rollers.{tilt}",
        scene.width,
        scene.height,
        sides(&|side| drained[side]),
        sides(&|side| scene.solid_sides[side] == SolidSide::Fixed),
        sides(&|side| scene.solid_sides[side] == SolidSide::Roller),
    )
}

/// An edge of the outline.
struct Edge {
    ends: [[f64; 2]; 2],
    side: Side,
    /// Outward normal on the drawing, y downwards.
    normal: [f64; 2],
}

/// The edges of an outline, counter-clockwise; inclined ones belong to the side that they face most.
fn edges(corners: &[[f64; 2]]) -> Vec<Edge> {
    let next = |i: usize| corners[(i + 1) % corners.len()];
    let area: f64 = (0..corners.len()).map(|i| corners[i][0] * next(i)[1] - next(i)[0] * corners[i][1]).sum();
    let edge = |i: usize| {
        let ends = [corners[i], next(i)];
        let along = [ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]];
        let length = along[0].hypot(along[1]);
        let out = if area > 0.0 { 1.0 } else { -1.0 };
        let normal = [out * along[1] / length, -out * along[0] / length];
        let side = match normal {
            [x, y] if y.abs() >= x.abs() => {
                if y > 0.0 {
                    Side::Top
                } else {
                    Side::Bottom
                }
            }
            [x, _] => {
                if x > 0.0 {
                    Side::Right
                } else {
                    Side::Left
                }
            }
        };
        Edge { ends, side, normal: [normal[0], -normal[1]] }
    };
    (0..corners.len()).map(edge).collect()
}

/// Places along an edge on the drawing.
fn along(view: &View, edge: &Edge, count: usize) -> Vec<[f64; 2]> {
    let [a, b] = edge.ends.map(|end| view.at(end));
    let share = |k: usize| (k as f64 + 0.5) / count as f64;
    (0..count).map(|k| [a[0] + share(k) * (b[0] - a[0]), a[1] + share(k) * (b[1] - a[1])]).collect()
}

fn support(view: &View, edge: &Edge, support: SolidSide) -> String {
    let [nx, ny] = edge.normal;
    let places = along(view, edge, 5);
    match support {
        SolidSide::Free => String::new(),
        SolidSide::Roller => places
            .iter()
            .map(|[x, y]| {
                format!("<circle class=\"roller\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"4\"/>", x + 5.0 * nx, y + 5.0 * ny)
            })
            .collect(),
        SolidSide::Fixed => places
            .iter()
            .map(|[x, y]| {
                let [x2, y2] = [x + 9.0 * nx - 7.0 * ny, y + 9.0 * ny + 7.0 * nx];
                format!("<line class=\"edge\" x1=\"{x:.1}\" y1=\"{y:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\"/>")
            })
            .collect(),
    }
}

/// What acts on a side, in words.
fn loads(scene: &Scene, side: usize) -> Vec<String> {
    let mut words = Vec::new();
    if let (Some(load), Side::Top) = (&scene.surcharge, Side::ALL[side]) {
        words.push(format!("q = {} kPa", crate::report::numbers::brief(load.pressure / 1e3, 3)));
    }
    for load in scene.loads.iter().filter(|load| load.on.is_none_or(|on| on as usize == side)) {
        words.push(match load.bearing {
            Bearing::Traction { pressure, .. } => format!("{} kPa", crate::report::numbers::brief(pressure / 1e3, 3)),
            Bearing::Reservoir => format!("head {} m", crate::report::numbers::brief(load.course.at(0.0, 0.0), 3)),
        });
    }
    words.truncate(1);
    words
}

fn fed(feed: Feed) -> String {
    match feed {
        Feed::Head(head) => format!("head {} m", crate::report::numbers::brief(head, 3)),
        Feed::Velocity { speed, .. } => format!("{} m/s", crate::report::numbers::brief(speed, 3)),
    }
}

/// Arrows onto an edge, with a word.
fn arrows(view: &View, edge: &Edge, word: &str) -> String {
    let [nx, ny] = edge.normal;
    let arrow = |[x, y]: &[f64; 2]| {
        let [tail, left, right] = [
            [x + 26.0 * nx, y + 26.0 * ny],
            [x + 8.0 * nx - 4.0 * ny, y + 8.0 * ny + 4.0 * nx],
            [x + 8.0 * nx + 4.0 * ny, y + 8.0 * ny - 4.0 * nx],
        ];
        format!(
            "<path class=\"load\" d=\"M{:.1} {:.1}L{x:.1} {y:.1}M{:.1} {:.1}L{x:.1} {y:.1}L{:.1} {:.1}\"/>",
            tail[0], tail[1], left[0], left[1], right[0], right[1]
        )
    };
    let middle = along(view, edge, 1)[0];
    let anchor = if nx > 0.5 {
        "start"
    } else if nx < -0.5 {
        "end"
    } else {
        "middle"
    };
    let [x, y] = [middle[0] + 30.0 * nx, middle[1] + 33.0 * ny + if ny > 0.5 { 10.0 } else { 4.0 * nx.abs() }];
    let places = along(view, edge, 4);
    let text = format!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>", super::escaped(word));
    places.iter().map(arrow).collect::<String>() + &text
}

/// Width and height below and beside the soil.
fn sizes(scene: &Scene, view: &View) -> String {
    let [x, y] = view.at([scene.width, 0.0]);
    let number = |value: f64| crate::report::numbers::brief(value, 4);
    format!(
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{} m</text><text x=\"{:.1}\" y=\"{:.1}\">{} m</text>",
        0.5 * (x + view.left),
        y + 26.0,
        number(scene.width),
        x + 12.0,
        y - 0.5 * view.scale[1] * scene.height + 4.0,
        number(scene.height)
    )
}

//! A sketch of a scene: its soil, supports, loads, drained sides and water, drawn from the scene itself; and a drawing of the end of its run.

use mpm_core::drive::{Run, Sample};
use mpm_core::observe::FieldPoint;
use mpm_core::scene::{
    Bearing, Course, Dimension, FaceLoad, Feed, LoadOn, Piece, Region, Scene, Side, SoilLayer, SolidSide,
};

use crate::report::numbers::print;

/// Looks of the parts, for pages and for drawings in files of their own.
pub const STYLE: &str = include_str!("sketch.css");
/// Light colours of the pages, for drawings in files of their own.
const LIGHT: &str = "svg { --p-ink: #000; --p-back: #fff; --p-blue: #0072b2; --p-red: #d55e00; --p-orange: #e69f00; --p-sand: #ddc89e; --p-pool: #c6e0f3; }";
/// Size of a sketch and of a thumbnail, px.
const SKETCH: [f64; 2] = [420.0, 300.0];
const THUMBNAIL: [f64; 2] = [360.0, 220.0];
/// Room around the soil of both, px.
const ROOM: f64 = 46.0;
const LITTLE_ROOM: f64 = 34.0;
/// A column is drawn at least so wide, as a share of its height.
const SLENDER: f64 = 0.3;
/// Arrows of a load are about so far apart, px.
const APART: f64 = 26.0;

/// The place of a point of the scene on the drawing.
struct View {
    /// Lower left corner of the soil, m.
    low: [f64; 2],
    /// px per m along each axis.
    scale: [f64; 2],
    /// Left and lower edge of the soil, px.
    left: f64,
    foot: f64,
    /// Width and height of the drawing, px.
    size: [f64; 2],
}

impl View {
    /// A view of a size at most, or, `fitted`, no higher than it needs to be.
    fn new(corners: &[[f64; 2]], [wide, high]: [f64; 2], room: f64, fitted: bool) -> Self {
        let end = |axis: usize, low: bool| {
            let all = corners.iter().map(|x| x[axis]);
            if low { all.fold(f64::INFINITY, f64::min) } else { all.fold(f64::NEG_INFINITY, f64::max) }
        };
        let low = [end(0, true), end(1, true)];
        let [across, up] = [end(0, false) - low[0], end(1, false) - low[1]];
        let one = ((wide - 2.0 * room) / across.max(SLENDER * up)).min((high - 2.0 * room) / up);
        let stretched = one * (SLENDER * up / across).max(1.0);
        let high = if fitted { high.min(one * up + 2.0 * room) } else { high };
        let foot = 0.5 * (high + one * up);
        Self { low, scale: [stretched, one], left: 0.5 * (wide - stretched * across), foot, size: [wide, high] }
    }

    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.left + self.scale[0] * (x - self.low[0]), self.foot - self.scale[1] * (y - self.low[1])]
    }

    fn points(&self, corners: &[[f64; 2]]) -> String {
        let one = |x: &[f64; 2]| {
            let [x, y] = self.at(*x);
            format!("{x:.1},{y:.1}")
        };
        corners.iter().map(one).collect::<Vec<_>>().join(" ")
    }
}

/// A scene at its start as an SVG element.
pub fn svg(scene: &Scene) -> String {
    let corners = scene.outline_or_box();
    let view = View::new(&corners, SKETCH, ROOM, true);
    let mut parts = pools(scene, &view, 0.0, true);
    parts.push(format!("<polygon class=\"soil\" points=\"{}\"/>", view.points(&corners)));
    parts.extend(inside(scene, &view));
    if let Some(level) = scene.free_surface.as_ref().and_then(|free| free.level) {
        parts.push(level_line(&view, level));
    }
    parts.extend(boundary(scene, &view, true));
    parts.push(sizes(scene, &view));
    element(&view, &corners, &words(scene), &parts.concat())
}

/// The end of a run as a drawing of its own, for a gallery: the soil where it is, its water, supports and loads, without numbers.
pub fn thumbnail(scene: &Scene, run: &Run) -> String {
    let corners = scene.outline_or_box();
    let places = &run.places;
    let moved: Vec<[f64; 2]> = places.solid.iter().map(|p| [p[0], p[1]]).collect();
    let last = run.samples.last();
    let time = last.map_or(0.0, |s| s.state.time);
    let reach = |s: &Sample| s.state.reach[0].max(s.state.reach[1]);
    // Soil that has moved visibly is drawn particle by particle.
    let flows =
        run.samples.first().zip(last).is_some_and(|(first, last)| (reach(last) - reach(first)).abs() > scene.cell);
    let all: Vec<[f64; 2]> = corners.iter().chain(moved.iter().filter(|_| flows)).copied().collect();
    let view = View::new(&all, THUMBNAIL, LITTLE_ROOM, false);
    let mut parts = pools(scene, &view, time, false);
    let outline = view.points(&corners);
    if flows {
        let squares = squares(&view, moved.iter().copied(), 1.4 * scene.spacing(), None);
        parts.push(format!("<path class=\"sand\" d=\"{squares}\"/><polygon class=\"before\" points=\"{outline}\"/>"));
    } else {
        parts.push(format!("<polygon class=\"soil\" points=\"{outline}\"/>"));
        parts.extend(inside(scene, &view));
    }
    parts.extend(last.map(|last| wet(scene, last, &view)));
    parts.extend(boundary(scene, &view, false));
    let svg = element(&view, &corners, &words(scene), &parts.concat());
    let [wide, high] = THUMBNAIL;
    let head = format!("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{wide}\" height=\"{high}\" ");
    svg.replacen("<svg ", &head, 1).replacen("<defs>", &format!("<style>{LIGHT}{STYLE}</style><defs>"), 1)
}

fn element(view: &View, corners: &[[f64; 2]], words: &str, parts: &str) -> String {
    let [wide, high] = view.size;
    format!(
        "<svg class=\"sketch\" viewBox=\"0 0 {wide} {high}\" role=\"img\" aria-label=\"{}\"><defs><clipPath id=\"soil\"><polygon points=\"{}\"/></clipPath></defs>{parts}</svg>",
        super::escaped(words),
        view.points(corners)
    )
}

/// Squares about places (m) of a size (m), clipped below at a height of its own for each; as a path.
fn squares(view: &View, places: impl Iterator<Item = [f64; 2]>, size: f64, share: Option<f64>) -> String {
    let [wide, high] = [size * view.scale[0], size * view.scale[1] * share.unwrap_or(1.0)];
    let square = |place: [f64; 2]| {
        let [x, y] = view.at([place[0] - 0.5 * size, place[1] - 0.5 * size]);
        format!("M{x:.1} {y:.1}h{wide:.1}v-{high:.1}h-{wide:.1}z")
    };
    places.map(square).collect()
}

/// Water in the pores at a time: cells as full as they are, or of full pores as dark as their pressure is.
fn wet(scene: &Scene, sample: &Sample, view: &View) -> String {
    let field = &sample.state.field;
    let free = scene.free_surface.is_some();
    let most = field.iter().map(|cell| cell.pressure_pa).fold(0.0, f64::max);
    let share = |cell: &FieldPoint| {
        let share = if free { cell.saturation * cell.soil } else { cell.pressure_pa / most };
        (share.clamp(0.0, 1.0) * SHADES).round() as u32
    };
    if scene.water.is_none() || most <= 0.0 {
        return String::new();
    }
    let layer = |level: u32| {
        let own = field.iter().filter(|cell| share(cell) == level && (!free || cell.soil > 0.0));
        let path =
            squares(view, own.map(|cell| [cell.x_m, cell.y_m]), scene.cell, free.then_some(f64::from(level) / SHADES));
        let opacity = if free { 0.55 } else { 0.75 * f64::from(level) / SHADES };
        format!("<path class=\"pores\" clip-path=\"url(#soil)\" fill-opacity=\"{opacity:.2}\" d=\"{path}\"/>")
    };
    (1..=SHADES as u32).map(layer).collect()
}

/// Steps of saturation or pressure that are told apart.
const SHADES: f64 = 8.0;

/// Water that stands outside of the soil at a time (s): reservoirs, and heads that feed the sides.
fn pools(scene: &Scene, view: &View, time: f64, with_words: bool) -> Vec<String> {
    let pool = |[left, right]: [f64; 2], level: f64| {
        let ([_, top], [_, foot]) = (view.at([0.0, level]), view.at([0.0, 0.0]));
        format!(
            "<rect class=\"pool\" x=\"{left:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\"/><line class=\"water\" x1=\"{left:.1}\" y1=\"{top:.1}\" x2=\"{right:.1}\" y2=\"{top:.1}\"/>",
            right - left,
            (foot - top).max(0.0)
        )
    };
    let [[start, _], [end, _]] = [view.at([0.0, 0.0]), view.at([scene.width, 0.0])];
    let reservoirs = scene.loads.iter().filter(|load| load.bearing == Bearing::Reservoir);
    let mut all: Vec<String> = reservoirs.map(|load| pool([start, end], load.course.at(time, 0.0))).collect();
    let feeds = scene.free_surface.as_ref().map(|free| free.feeds).unwrap_or_default();
    for (side, beside) in [
        (Side::Left, [(start - LITTLE_ROOM).max(2.0), start]),
        (Side::Right, [end, (end + LITTLE_ROOM).min(view.size[0] - 2.0)]),
    ] {
        if let Some(Feed::Head(head)) = feeds[side as usize] {
            all.push(pool(beside, head));
            if with_words {
                let [_, y] = view.at([0.0, head]);
                all.push(format!(
                    "<text x=\"{:.1}\" y=\"{:.1}\">{} m</text>",
                    beside[0] - 8.0,
                    y - 6.0,
                    print(head, 3)
                ));
            }
        }
    }
    all
}

/// Regions and layers.
fn inside(scene: &Scene, view: &View) -> Vec<String> {
    let region = |region: &Region| {
        let points = view.points(&region.polygon);
        format!("<polygon class=\"region\" clip-path=\"url(#soil)\" points=\"{points}\"/>")
    };
    let layer = |layer: &SoilLayer| {
        let line = [[-1e6, layer.up_to], [1e6, layer.up_to]];
        format!("<polyline class=\"edge\" clip-path=\"url(#soil)\" points=\"{}\"/>", view.points(&line))
    };
    scene.layers.iter().map(layer).chain(scene.regions.iter().map(region)).collect()
}

fn level_line(view: &View, level: f64) -> String {
    let line = [[-1e6, level], [1e6, level]];
    format!("<polyline class=\"water\" clip-path=\"url(#soil)\" points=\"{}\"/>", view.points(&line))
}

/// Supports, drained sides, loads, plates and wells; with what they are in words if asked for.
fn boundary(scene: &Scene, view: &View, with_words: bool) -> Vec<String> {
    let drained = scene.stages.last().map_or([false; 4], |stage| stage.drained);
    let acting = acting(scene);
    let mut parts = Vec::new();
    for edge in edges(&scene.outline_or_box()) {
        let side = edge.side as usize;
        parts.push(support(view, &edge, scene.solid_sides[side]));
        if drained[side] {
            parts.push(format!("<polyline class=\"drained\" points=\"{}\"/>", view.points(&edge.ends)));
        }
        for one in &acting {
            let Some(part) = edge.part(&one.load) else { continue };
            if one.is_plate {
                parts.push(format!("<polyline class=\"plate\" points=\"{}\"/>", view.points(&part.ends)));
            }
            parts.push(arrows(view, &part, if with_words { &one.words } else { "" }, one.into));
        }
    }
    for well in &scene.wells {
        let at = if scene.dimension == Dimension::Column { [0.5 * scene.width, well.at[1]] } else { well.at };
        let [x, y] = view.at(at);
        parts.push(format!("<circle class=\"well\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\"/>"));
    }
    parts
}

/// What is seen in the sketch.
pub fn words(scene: &Scene) -> String {
    let dimension = match scene.dimension {
        Dimension::Column => "a column",
        Dimension::PlaneStrain => "a section in plane strain",
        Dimension::Axisymmetric => "a section about an axis",
    };
    let drained = scene.stages.last().map_or([false; 4], |stage| stage.drained);
    let sides = |what: &str, which: &dyn Fn(usize) -> bool| {
        let names: Vec<&str> = Side::ALL.into_iter().filter(|side| which(*side as usize)).map(Side::word).collect();
        if names.is_empty() { String::new() } else { format!(" {what}: {}.", names.join(", ")) }
    };
    let supported = |support: SolidSide| move |side: usize| scene.solid_sides[side] == support;
    let tilt = scene.slope_angle.map_or_else(String::new, |angle| format!(" Gravity is inclined by {angle}°."));
    let all = [
        sides("Fixed", &supported(SolidSide::Fixed)),
        sides("On rollers", &supported(SolidSide::Roller)),
        sides("Drained", &|side| drained[side]),
    ];
    format!("Sketch of {dimension}, {} m by {} m.{}{tilt}", scene.width, scene.height, all.concat())
}

/// An edge of the outline.
struct Edge {
    ends: [[f64; 2]; 2],
    side: Side,
    /// Outward normal on the drawing, y downwards.
    normal: [f64; 2],
}

impl Edge {
    /// The part of it on which a load acts, if there is one.
    fn part(&self, load: &FaceLoad) -> Option<Self> {
        let [[x0, y0], [x1, y1]] = self.ends;
        let length = (x1 - x0).hypot(y1 - y0);
        let outward = [self.normal[0] * length, -self.normal[1] * length];
        if load.on.is_some_and(|side| side != self.side) {
            return None;
        }
        let piece = load.part_of(&Piece { middle: [0.5 * (x0 + x1), 0.5 * (y0 + y1)], outward })?;
        let ([mx, my], [nx, ny]) = (piece.middle, piece.outward);
        Some(Self { ends: [[mx + 0.5 * ny, my - 0.5 * nx], [mx - 0.5 * ny, my + 0.5 * nx]], ..*self })
    }
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

/// Something that presses, moves or feeds a part of the outline.
struct Acting {
    /// The load, at 1 Pa.
    load: FaceLoad,
    words: String,
    /// Whether the arrow points into the soil.
    into: bool,
    is_plate: bool,
}

/// Actions on the outline, with words for each; reservoirs and heads beside the soil are drawn as water.
fn acting(scene: &Scene) -> Vec<Acting> {
    let number = |value: f64| print(value, 3);
    let at = |on: Option<Side>, x: Option<[f64; 2]>, y: Option<[f64; 2]>| {
        let bearing = Bearing::Traction { pressure: 1.0, shear: 0.0, water: false };
        FaceLoad { on, x, y, bearing, course: Course::Constant }
    };
    let press = |load: FaceLoad, words: String| Acting { load, words, into: true, is_plate: false };
    let mut all = Vec::new();
    if let Some(load) = &scene.surcharge {
        let strip = load.strip.map(|strip| [strip.from, strip.to]);
        let under_plate = load.on == LoadOn::Plate;
        let words = format!("q = {} kPa", number(load.pressure / 1e3));
        all.push(Acting {
            is_plate: under_plate,
            into: load.pressure >= 0.0,
            ..press(at(Some(Side::Top), strip, None), words)
        });
    }
    for load in &scene.loads {
        if let Bearing::Traction { pressure, .. } = load.bearing {
            let words = format!("{} kPa", number(pressure / 1e3));
            all.push(Acting { into: pressure >= 0.0, ..press(at(load.on, load.x, load.y), words) });
        }
    }
    for plate in &scene.plates {
        let end = scene.observe_times.last().copied().unwrap_or(0.0);
        let moved = plate.at(end);
        let words = format!("u = {} mm", number(1e3 * moved.abs()));
        all.push(Acting { into: moved >= 0.0, is_plate: true, ..press(at(Some(plate.on), plate.x, plate.y), words) });
    }
    let feeds = scene.free_surface.as_ref().map(|free| free.feeds).unwrap_or_default();
    for (side, feed) in Side::ALL.into_iter().zip(feeds) {
        let words = match feed {
            Some(Feed::Velocity { speed, .. }) => format!("{} m/s", number(speed)),
            Some(Feed::Head(head)) if matches!(side, Side::Top | Side::Bottom) => format!("head {} m", number(head)),
            // A head beside the soil is drawn as water.
            Some(Feed::Head(_)) | None => continue,
        };
        all.push(press(at(Some(side), None, None), words));
    }
    all
}

/// Arrows onto a part of the outline, or away from it, with a word.
fn arrows(view: &View, edge: &Edge, word: &str, into: bool) -> String {
    let [nx, ny] = edge.normal;
    let arrow = |[x, y]: &[f64; 2]| {
        // From the tail to the tip, with its two barbs.
        let (tail, tip) = if into { (26.0, 1.0) } else { (3.0, 26.0) };
        let barb = if into { tip + 8.0 } else { tip - 8.0 };
        let at = |out: f64, across: f64| [x + out * nx - across * ny, y + out * ny + across * nx];
        let [tail, tip, left, right] = [at(tail, 0.0), at(tip, 0.0), at(barb, 4.0), at(barb, -4.0)];
        format!(
            "<path class=\"load\" d=\"M{:.1} {:.1}L{:.1} {:.1}M{:.1} {:.1}L{:.1} {:.1}L{:.1} {:.1}\"/>",
            tail[0], tail[1], tip[0], tip[1], left[0], left[1], tip[0], tip[1], right[0], right[1]
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
    let [a, b] = edge.ends.map(|end| view.at(end));
    let count = (((b[0] - a[0]).hypot(b[1] - a[1]) / APART).round() as usize).clamp(2, 9);
    let drawn: String = along(view, edge, count).iter().map(arrow).collect();
    if word.is_empty() {
        return drawn;
    }
    let [x, y] = [middle[0] + 30.0 * nx, middle[1] + 33.0 * ny + if ny > 0.5 { 10.0 } else { 4.0 * nx.abs() }];
    drawn + &format!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>", super::escaped(word))
}

/// Width and height below and beside the soil.
fn sizes(scene: &Scene, view: &View) -> String {
    let [x, y] = view.at([scene.width, 0.0]);
    let number = |value: f64| print(value, 4);
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

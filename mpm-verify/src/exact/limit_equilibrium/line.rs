//! Slip surfaces of any shape: polylines, and the one of the least factor of safety.
//!
//! The search starts from a circle and from lines along the lower edges of weak layers, and moves ends and vertices to and fro as long as the factor
//! falls, by ever smaller steps (a pattern search: Hooke & Jeeves 1961, doi:10.1145/321062.321069). A surface stays convex: soil that slides on another
//! would have to break.

use super::factor::Method;
use super::slices::{Circle, Slide};
use super::{Critical, Limits, Refused, Section};

/// Vertices between entry and exit.
const VERTICES: usize = 9;
/// Entries and exits that are tried along a floor.
const ENDS: usize = 16;
/// Slices while searching.
const SLICES: usize = 50;
/// First and last step of a vertex as shares of the depth of the slide, and of an end as shares of its length.
const STEPS: [f64; 2] = [0.2, 2e-3];
/// Steepest base, rad.
const STEEPEST: f64 = 80.0 * std::f64::consts::PI / 180.0;
/// A share of the depth by which a surface may be concave.
const FLAT: f64 = 1e-6;

/// A surface by its ends x (m) and its vertices, x and heights (m).
#[derive(Debug, Clone, PartialEq)]
struct Line {
    ends: [f64; 2],
    places: [f64; VERTICES],
    heights: [f64; VERTICES],
}

impl Line {
    /// That of a slide.
    fn of(slide: &Slide) -> Self {
        let points = slide.points();
        Self::between([slide.entry[0], slide.exit[0]], |x| super::water::along(&points, x))
    }

    /// One with vertices that divide its length evenly.
    fn between(ends: [f64; 2], height: impl Fn(f64) -> f64) -> Self {
        let share = |place: usize| (place as f64 + 1.0) / (VERTICES as f64 + 1.0);
        let places = std::array::from_fn(|place| ends[0] + share(place) * (ends[1] - ends[0]));
        Self { ends, places, heights: places.map(height) }
    }

    fn points(&self, section: &Section) -> Vec<[f64; 2]> {
        let end = |x: f64| [x, section.surface(x)];
        let inner = (0..VERTICES).map(|place| [self.places[place], self.heights[place]]);
        std::iter::once(end(self.ends[0])).chain(inner).chain([end(self.ends[1])]).collect()
    }

    /// Moves it along one of its coordinates, heights, then places, then ends, by a share of its depth or length (m).
    fn moved(&self, which: usize, share: f64, [length, depth]: [f64; 2]) -> Self {
        let mut line = self.clone();
        match which {
            k if k < VERTICES => line.heights[k] += share * depth,
            k if k < 2 * VERTICES => line.places[k - VERTICES] += 0.5 * share * length,
            k => line.ends[k - 2 * VERTICES] += share * length,
        }
        line
    }

    fn is_ordered(&self) -> bool {
        let all: Vec<f64> = std::iter::once(self.ends[0]).chain(self.places).chain([self.ends[1]]).collect();
        all.windows(2).all(|pair| pair[1] - pair[0] > 1e-3 * (self.ends[1] - self.ends[0]))
    }
}

impl Section<'_> {
    /// What slides on a polyline (m) from its entry on the ground to its exit, x increasing, with moments about a centre (m), in about
    /// `count` slices.
    ///
    /// # Errors
    /// A line that does not stay below the ground.
    pub fn along(&self, points: &[[f64; 2]], centre: [f64; 2], count: usize) -> Result<Slide, Refused> {
        let (entry, exit) = (points[0], points[points.len() - 1]);
        let span = exit[0] - entry[0];
        let mut breaks: Vec<f64> = points.iter().map(|x| x[0]).collect();
        breaks.extend(self.ground.iter().map(|x| x[0]).filter(|x| *x > entry[0] && *x < exit[0]));
        breaks.sort_by(f64::total_cmp);
        let mut slices = Vec::with_capacity(count + breaks.len());
        for pair in breaks.windows(2).filter(|pair| pair[1] - pair[0] > 1e-12 * span) {
            let part = (count as f64 * (pair[1] - pair[0]) / span).round().max(1.0);
            let step = (pair[1] - pair[0]) / part;
            for place in 0..part as usize {
                let x = pair[0] + (place as f64 + 0.5) * step;
                let (y, rise) = (super::water::along(points, x), super::water::slope(points, x));
                let length = rise.hypot(1.0);
                let base = self.base.filter(|base| y <= base.height);
                let (y, slope) = base.map_or((y, [-rise / length, 1.0 / length]), |base| (base.height, [0.0, 1.0]));
                if self.surface(x) <= y {
                    return Err(Refused::Open);
                }
                slices.push(self.slice_on(centre, ([x, y], step), slope, base));
            }
        }
        let area = slices.iter().map(|slice| slice.height * slice.width).sum();
        let depth = slices.iter().map(|slice| slice.height).fold(0.0, f64::max);
        Ok(Slide { circle: Circle { centre, radius: f64::NAN }, entry, exit, area, depth, slices })
    }

    /// The surface of any shape whose factor is least, from the critical circle and from lines along `floors`: heights (m) at x (m) of what
    /// may be slid on. `None` without a circle.
    pub fn critical_line(
        &self,
        limits: &Limits,
        circle: Option<&Critical>,
        floors: &[&dyn Fn(f64) -> f64],
    ) -> Option<Critical> {
        let circle = circle?;
        let method = if limits.method == Method::Bishop { Method::Spencer } else { limits.method };
        let centre = circle.slide.circle.centre;
        let first = Line::of(&circle.slide);
        let along = floors.iter().filter_map(|floor| self.along_floor(limits, method, centre, floor));
        let found = std::iter::once(first).chain(along).filter_map(|line| self.descend(line, limits, method, centre));
        let best = found.min_by(|a, b| a.factor.total_cmp(&b.factor));
        best.into_iter().chain([circle.clone()]).min_by(|a, b| a.factor.total_cmp(&b.factor))
    }

    /// The best of some lines that follow a floor between entries and exits all over the ground.
    fn along_floor(
        &self,
        limits: &Limits,
        method: Method,
        centre: [f64; 2],
        floor: &dyn Fn(f64) -> f64,
    ) -> Option<Line> {
        let place = |[low, high]: [f64; 2], k: usize| low + (high - low) * k as f64 / (ENDS - 1) as f64;
        let pairs = (0..ENDS * ENDS).map(|k| [place(limits.starts, k % ENDS), place(limits.ends, k / ENDS)]);
        let lines = pairs.filter(|ends| ends[1] > ends[0]).map(|ends| {
            let mut line = Line::between(ends, |x| floor(x).min(self.surface(x)));
            convexify(&mut line, self);
            line
        });
        let valued = lines.filter_map(|line| Some((self.value(&line, limits, (method, centre, SLICES))?.factor, line)));
        valued.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, line)| line)
    }

    /// What slides on a line, if it may.
    fn value(
        &self,
        line: &Line,
        limits: &Limits,
        (method, centre, slices): (Method, [f64; 2], usize),
    ) -> Option<Critical> {
        let lowest = self.base.map_or(f64::NEG_INFINITY, |base| base.height);
        let points = line.points(self);
        let rise = |pair: &[[f64; 2]]| (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0]);
        let rises: Vec<f64> = points.windows(2).map(rise).collect();
        let convex = rises.windows(2).all(|pair| pair[0] <= pair[1] + FLAT);
        let steep = rises.iter().any(|rise| rise.abs() > STEEPEST.tan());
        if !convex || steep || line.heights.iter().any(|y| *y < lowest) {
            return None;
        }
        let slide = self.along(&points, centre, slices).ok()?;
        let factor = self.is_enough(&slide, limits).then(|| slide.factor(method).ok()).flatten()?;
        Some(Critical { factor, slide })
    }

    fn descend(&self, mut line: Line, limits: &Limits, method: Method, centre: [f64; 2]) -> Option<Critical> {
        let lowest = self.base.map_or(f64::NEG_INFINITY, |base| base.height);
        convexify(&mut line, self);
        let first = self.value(&line, limits, (method, centre, SLICES))?;
        let (length, depth) = (line.ends[1] - line.ends[0], first.slide.depth);
        let value = |line: &Line| self.value(line, limits, (method, centre, SLICES)).map(|critical| critical.factor);
        let mut best = first.factor;
        let mut step = STEPS[0];
        while step > STEPS[1] {
            let before = best;
            for which in 0..2 * VERTICES + 2 {
                for way in [step, -step] {
                    let mut next = line.moved(which, way, [length, depth]);
                    let inside = next.is_ordered()
                        && next.ends[0] >= limits.starts[0]
                        && next.ends[0] <= limits.starts[1]
                        && next.ends[1] >= limits.ends[0]
                        && next.ends[1] <= limits.ends[1];
                    for y in &mut next.heights {
                        *y = y.max(lowest);
                    }
                    if let Some(found) = inside.then(|| value(&next)).flatten().filter(|found| *found < best) {
                        (line, best) = (next, found);
                    }
                }
            }
            if before - best <= 1e-4 * best {
                step *= 0.5;
            }
        }
        self.value(&line, limits, (method, centre, limits.slices))
    }
}

/// Lowers vertices that stand out upwards: the lower hull of the line.
fn convexify(line: &mut Line, section: &Section) {
    let points = line.points(section);
    let mut hull: Vec<[f64; 2]> = Vec::new();
    for point in points {
        while let [.., a, b] = hull[..]
            && (b[1] - a[1]) * (point[0] - b[0]) >= (point[1] - b[1]) * (b[0] - a[0])
        {
            hull.pop();
        }
        hull.push(point);
    }
    for place in 0..VERTICES {
        line.heights[place] = super::water::along(&hull, line.places[place]);
    }
}

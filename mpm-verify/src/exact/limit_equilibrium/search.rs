//! The circle of the least factor of safety.
//!
//! A circle is given by where its chord starts and ends on the ground and by half the angle of its arc. All starts,
//! ends and angles of a coarse grid are tried, by Bishop's method whatever is asked for; from the best places that lie apart the
//! search goes on by simplices. Slides that come out at a corner of the ground, as at a toe, are looked for apart: the factor has an edge there.
//! Nothing in it is random. The angle is counted from the flattest arc that is deep and large enough, so that the
//! least depth is a face of the space of the search and not a wall inside it. A chord may end where the ground is no
//! higher than the firm base: its circle is cut, and the slide comes out at the toe.

use super::factor::Method;
use super::{Circle, Section, Slice, Slide};
use crate::exact::root::root;
use crate::exact::simplex::minimum;

/// Chords and arcs of the grid: starts, ends, angles.
const GRID: [usize; 3] = [24, 24, 9];
/// Slices of a circle on the grid.
const COARSE_SLICES: usize = 40;
/// Places from which the search goes on.
const STARTS: usize = 6;
/// How far apart they lie in the unit cube.
const APART: f64 = 0.12;
/// The arc starts less steeply than this angle (rad) below the horizontal: 85 degrees.
const STEEPEST: f64 = 85.0 * std::f64::consts::PI / 180.0;
/// Half the angle of the flattest arc, rad.
const FLATTEST: f64 = 1e-6;
/// Share of the least depth and area that a slide may be short of by its number of slices.
const ENOUGH: f64 = 0.99;
/// How close to the start of its chord a slide starts, over the radius.
const AT_START: f64 = 1e-6;
/// Relative spread of the factor at which a simplex ends.
const NARROW: f64 = 1e-7;
/// How often a simplex may start again, and the relative gain that is worth it.
const RESTARTS: usize = 5;
const WORTH: f64 = 1e-5;

/// Which slides are looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Least value of the greatest vertical depth, m.
    pub least_depth: f64,
    /// Least area, m2.
    pub least_area: f64,
    /// Least area that lies deeper than the least depth, normal to the ground, m2.
    pub least_deep: f64,
    /// Range of x (m) on the ground where the chord starts.
    pub starts: [f64; 2],
    /// Range of x (m) on the ground where it ends.
    pub ends: [f64; 2],
    /// Slices of a slide.
    pub slices: usize,
    /// Whose factor is least.
    pub method: Method,
}

/// The least stable slide.
#[derive(Debug, Clone, PartialEq)]
pub struct Critical {
    /// Its factor of safety.
    pub factor: f64,
    /// What slides.
    pub slide: Slide,
}

impl Section<'_> {
    /// The slide within the limits whose factor of safety is least; `None` if none has one.
    pub fn critical(&self, limits: &Limits) -> Option<Critical> {
        let chord = |start: f64, end: f64| {
            let at = |[low, high]: [f64; 2], share: f64| {
                let x = low + share * (high - low);
                [x, self.surface(x)]
            };
            Chord::new(self, limits, at(limits.starts, start), at(limits.ends, end))
        };
        let factor = |slide: &Slide, method: Method| {
            if self.is_enough(slide, limits) { slide.factor(method).ok() } else { None }
        };
        let share = |place: usize, count: usize| place as f64 / (count - 1) as f64;
        let mut tried = Vec::new();
        for start in (0..GRID[0]).map(|place| share(place, GRID[0])) {
            for end in (0..GRID[1]).map(|place| share(place, GRID[1])) {
                let Some(chord) = chord(start, end) else { continue };
                for angle in (0..GRID[2]).map(|place| share(place, GRID[2])) {
                    let found = chord.slide(self, angle, COARSE_SLICES);
                    let found = found.as_ref().and_then(|slide| factor(slide, Method::Bishop));
                    tried.extend(found.map(|factor| ([start, end, angle], factor)));
                }
            }
        }
        tried.sort_by(|a, b| a.1.total_cmp(&b.1));
        let mut starts: Vec<[f64; 3]> = Vec::new();
        for (place, _) in tried {
            let apart = |other: &[f64; 3]| (0..3).any(|axis| (place[axis] - other[axis]).abs() > APART);
            if starts.len() < STARTS && starts.iter().all(apart) {
                starts.push(place);
            }
        }
        let slide = |[start, end, angle]: [f64; 3]| chord(start, end)?.slide(self, angle, limits.slices);
        let value = |place: [f64; 3]| {
            slide(place).as_ref().and_then(|slide| factor(slide, limits.method)).unwrap_or(f64::INFINITY)
        };
        let descend = |place: [f64; 3]| {
            let mut best = (place, value(place));
            // A simplex that has shrunk early starts again.
            for _ in 0..RESTARTS {
                let next = minimum(value, best.0, 1.0 / GRID[0] as f64, NARROW);
                let gain = best.1 - next.1;
                best = next;
                if gain <= WORTH * best.1 {
                    break;
                }
            }
            best
        };
        // Through the corners: the best of them by Bishop's method, then by the one that is asked for.
        let [first, last] = limits.ends;
        let corners = self.ground.iter().map(|corner| (corner[0] - first) / (last - first));
        let coarse = |[start, end, angle]: [f64; 3]| {
            let slide = chord(start, end).and_then(|chord| chord.slide(self, angle, COARSE_SLICES));
            slide.and_then(|slide| factor(&slide, Method::Bishop)).unwrap_or(f64::INFINITY)
        };
        let through = |end: f64| {
            let places = (0..GRID[0] * GRID[2]).map(|k| [share(k % GRID[0], GRID[0]), share(k / GRID[0], GRID[2])]);
            let tried = places.map(|place| (place, coarse([place[0], end, place[1]])));
            let (best, least) = tried.min_by(|a, b| a.1.total_cmp(&b.1))?;
            let found = || minimum(|[start, angle]| coarse([start, end, angle]), best, 1.0 / GRID[0] as f64, NARROW);
            least.is_finite().then(found).map(|([start, angle], least)| ([start, end, angle], least))
        };
        let corners = corners.filter(|end| (0.0..=1.0).contains(end)).filter_map(through);
        let corner = corners.min_by(|a, b| a.1.total_cmp(&b.1)).and_then(|([start, end, angle], _)| {
            let (of, from) = (|[start, angle]: [f64; 2]| value([start, end, angle]), [start, angle]);
            let found = || minimum(of, from, 0.1 / GRID[0] as f64, NARROW);
            of(from).is_finite().then(found).map(|([start, angle], least)| ([start, end, angle], least))
        });
        let least = starts.into_iter().map(descend).chain(corner).min_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(Critical { factor: least.1, slide: slide(least.0)? }).filter(|critical| critical.factor.is_finite())
    }
}

impl Section<'_> {
    /// Whether a slide is as large as it must be.
    pub(super) fn is_enough(&self, slide: &Slide, limits: &Limits) -> bool {
        let deep = |slice: &Slice| {
            let depth = limits.least_depth * super::water::slope(self.ground, slice.base[0]).hypot(1.0);
            slice.width * (slice.height - depth).max(0.0)
        };
        slide.depth >= ENOUGH * limits.least_depth
            && slide.area >= ENOUGH * limits.least_area
            && (limits.least_deep == 0.0 || slide.slices.iter().map(deep).sum::<f64>() >= limits.least_deep)
    }
}

/// A chord and the half angles (rad) of the arcs below it that are deep and large enough and not too steep.
struct Chord {
    ends: [[f64; 2]; 2],
    arcs: [f64; 2],
}

impl Chord {
    /// `None` if there are no such arcs, or if the chord rises towards +x.
    fn new(section: &Section, limits: &Limits, left: [f64; 2], right: [f64; 2]) -> Option<Self> {
        let fall = (left[1] - right[1]).atan2(right[0] - left[0]);
        let deepest = STEEPEST - fall;
        if right[0] <= left[0] || fall < 0.0 || deepest <= FLATTEST {
            return None;
        }
        let mut chord = Self { ends: [left, right], arcs: [FLATTEST, deepest] };
        let excess = |angle: f64| {
            let slide = chord.cut(section, angle, COARSE_SLICES);
            slide.map_or(-1.0, |slide| (slide.depth / limits.least_depth).min(slide.area / limits.least_area) - 1.0)
        };
        if excess(FLATTEST) <= 0.0 {
            chord.arcs[0] = root(excess, FLATTEST, deepest)?;
        }
        Some(chord)
    }

    /// What slides on an arc between the flattest (0) and the deepest (1).
    fn slide(&self, section: &Section, share: f64, slices: usize) -> Option<Slide> {
        let [flattest, deepest] = self.arcs;
        self.cut(section, flattest + share * share * (deepest - flattest), slices)
    }

    /// What slides on the arc of a half angle (rad): the piece that starts where the chord does.
    fn cut(&self, section: &Section, half_angle: f64, slices: usize) -> Option<Slide> {
        let circle = Circle::through(self.ends[0], self.ends[1], half_angle);
        let start = self.ends[0][0];
        let slide = section.piece(circle, slices, |entry, _| -(entry - start).abs()).ok()?;
        ((slide.entry[0] - start).abs() < AT_START * circle.radius).then_some(slide)
    }
}

//! A circle or any other slip surface cut into slices: where it enters and leaves the ground, weights, angles, lever arms.

use mpm_core::scene::NormalStress;

use super::{FirmBase, Outside, Refused, Section};
use crate::exact::infinite_slope::Strength;

/// Lengths below this share of the radius are round-off.
const ROUND_OFF: f64 = 1e-12;
/// How close to the ground an end of the slip surface must lie, over the radius.
const AT_GROUND: f64 = 1e-9;

/// A circle; the slip surface is its lower half.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    /// Centre (x, y), m.
    pub centre: [f64; 2],
    /// Radius, m.
    pub radius: f64,
}

impl Circle {
    /// The circle below the chord from `left` to `right` (m) that sees it from its centre under twice `half_angle`
    /// (rad).
    pub fn through(left: [f64; 2], right: [f64; 2], half_angle: f64) -> Self {
        let [run, fall] = [right[0] - left[0], left[1] - right[1]];
        let rise = 0.5 / half_angle.tan();
        Self {
            centre: [0.5 * (left[0] + right[0]) + fall * rise, 0.5 * (left[1] + right[1]) + run * rise],
            radius: 0.5 * run.hypot(fall) / half_angle.sin(),
        }
    }

    /// Height y (m) of its lower half at x (m); not a number beside it.
    pub fn bottom(&self, x: f64) -> f64 {
        let beside = x - self.centre[0];
        self.centre[1] - ((self.radius - beside) * (self.radius + beside)).sqrt()
    }
}

/// A vertical slice, one metre thick, by what happens in the middle of its base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slice {
    /// Middle of the base (x, y), m.
    pub base: [f64; 2],
    /// Width along x, m.
    pub width: f64,
    /// Height from base to ground, m.
    pub height: f64,
    /// Sine and cosine of the angle of the base, positive where it falls towards +x.
    pub slope: [f64; 2],
    /// Weight of soil and water and what loads them, N/m.
    pub weight: f64,
    /// Horizontal force from outside, towards +x, N/m, and its moment about the centre, N m/m, positive where it drives.
    pub push: [f64; 2],
    /// Pore pressure that the friction does without, Pa.
    pub pore: f64,
    /// Strength on the base, and tan(phi) of it.
    pub strength: Strength,
    /// See `strength`.
    pub tangent: f64,
    /// Distance of shear and normal force from the centre, m: R and f.
    pub arms: [f64; 2],
}

impl Slice {
    /// Length of the base, m.
    pub fn length(&self) -> f64 {
        self.width / self.slope[1]
    }
}

/// What slides on a circle.
#[derive(Debug, Clone, PartialEq)]
pub struct Slide {
    /// The circle; for another surface its centre alone says something: moments are about it.
    pub circle: Circle,
    /// Where the slip surface starts (x, y), m.
    pub entry: [f64; 2],
    /// Where it comes out (x, y), m.
    pub exit: [f64; 2],
    /// Area, m2.
    pub area: f64,
    /// Greatest vertical depth, m.
    pub depth: f64,
    /// Its slices from entry to exit.
    pub slices: Vec<Slice>,
}

impl Slide {
    /// The slip surface from entry to exit (x, y), m.
    pub fn points(&self) -> Vec<[f64; 2]> {
        let inner = self.slices.iter().map(|slice| slice.base);
        std::iter::once(self.entry).chain(inner).chain(std::iter::once(self.exit)).collect()
    }
}

impl Section<'_> {
    /// Height y (m) of the ground at x (m); beyond its ends as at them.
    pub fn surface(&self, x: f64) -> f64 {
        super::water::along(self.ground, x)
    }

    /// Cuts what slides on a circle into about `count` slices. No slice reaches over a corner of the ground or of the
    /// slip surface. A piece also ends where the circle only touches the ground: at the toe of a steep slope it may
    /// come out downwards. Of several pieces the widest slides.
    ///
    /// # Errors
    /// A circle beside the ground, or one that leaves it elsewhere than through its surface.
    pub fn slide(&self, circle: Circle, count: usize) -> Result<Slide, Refused> {
        self.piece(circle, count, |entry, exit| exit - entry)
    }

    /// The same for the piece of the largest `merit`, a function of where it starts and ends, x in m.
    pub(super) fn piece(
        &self,
        circle: Circle,
        count: usize,
        merit: impl Fn(f64, f64) -> f64,
    ) -> Result<Slide, Refused> {
        let slip = |x: f64| self.base.map_or(f64::NEG_INFINITY, |base| base.height).max(circle.bottom(x));
        let clearance = |x: f64| self.surface(x) - slip(x);
        let breaks = self.breaks(circle);
        let moves = |pair: &[f64]| clearance(0.5 * (pair[0] + pair[1])) > ROUND_OFF * circle.radius;
        let pairs: Vec<_> = breaks.windows(2).filter(|pair| pair[1] - pair[0] > ROUND_OFF * circle.radius).collect();
        let of = |run: &[&[f64]]| merit(run[0][0], run[run.len() - 1][1]);
        let run = pairs
            .chunk_by(|a, b| moves(a) == moves(b) && clearance(b[0]) > AT_GROUND * circle.radius)
            .filter(|run| moves(run[0]))
            .max_by(|a, b| of(a).total_cmp(&of(b)))
            .ok_or(Refused::Outside)?;
        let [entry, exit] = [run[0][0], run[run.len() - 1][1]];
        if clearance(entry).max(clearance(exit)) >= AT_GROUND * circle.radius {
            return Err(Refused::Open);
        }
        let mut slices = Vec::with_capacity(count + run.len());
        for pair in run {
            let part = (count as f64 * (pair[1] - pair[0]) / (exit - entry)).round().max(1.0);
            let step = (pair[1] - pair[0]) / part;
            slices.extend(
                (0..part as usize).map(|place| self.slice(circle, pair[0] + (place as f64 + 0.5) * step, step)),
            );
        }
        let area = slices.iter().map(|slice| slice.height * slice.width).sum();
        let depth = slices.iter().map(|slice| slice.height).fold(0.0, f64::max);
        let [entry, exit] = [entry, exit].map(|x| [x, self.surface(x)]);
        Ok(Slide { circle, entry, exit, area, depth, slices })
    }

    /// Corners of ground and slip surface and where they meet, x in m, in order.
    fn breaks(&self, circle: Circle) -> Vec<f64> {
        let [x, y] = circle.centre;
        let ends =
            [self.ground[0][0].max(x - circle.radius), self.ground[self.ground.len() - 1][0].min(x + circle.radius)];
        let mut breaks = ends.to_vec();
        breaks.extend(self.ground.iter().map(|corner| corner[0]));
        for pair in self.ground.windows(2) {
            let [run, rise] = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
            let [dx, dy] = [pair[0][0] - x, pair[0][1] - y];
            let (a, b, c) =
                (run * run + rise * rise, dx * run + dy * rise, dx * dx + dy * dy - circle.radius * circle.radius);
            let turn = (b * b - a * c).sqrt();
            // The form of the root that loses no digits; without a root both are not a number.
            let far = -(b + b.signum() * turn);
            let mut shares = vec![far / a, c / far];
            if let Some(base) = self.base {
                shares.push((base.height - pair[0][1]) / rise);
            }
            let on = shares.into_iter().filter(|share| (-AT_GROUND..=1.0 + AT_GROUND).contains(share));
            breaks.extend(on.map(|share| pair[0][0] + share.clamp(0.0, 1.0) * run));
        }
        if let Some(base) = self.base {
            let above = y - base.height;
            let half = ((circle.radius - above) * (circle.radius + above)).sqrt();
            breaks.extend([x - half, x + half]);
        }
        breaks.retain(|place| (ends[0]..=ends[1]).contains(place));
        breaks.sort_by(f64::total_cmp);
        breaks
    }

    /// The slice of a width (m) around x (m) on a circle or the base that cuts it.
    fn slice(&self, circle: Circle, x: f64, width: f64) -> Slice {
        let arc = circle.bottom(x);
        let on_base = self.base.filter(|base| arc < base.height);
        let beside = x - circle.centre[0];
        match on_base {
            Some(base) => self.slice_on(circle.centre, ([x, base.height], width), [0.0, 1.0], Some(base)),
            None => {
                let slope = [-beside, circle.centre[1] - arc].map(|r| r / circle.radius);
                self.slice_on(circle.centre, ([x, arc], width), slope, None)
            }
        }
    }

    /// The slice around the middle (x, y) of its base and of a width, m; its base has a slope [sin, cos].
    pub(super) fn slice_on(
        &self,
        centre: [f64; 2],
        ([x, y], width): ([f64; 2], f64),
        slope: [f64; 2],
        on_base: Option<FirmBase>,
    ) -> Slice {
        let top = self.surface(x);
        let (beside, below) = (x - centre[0], y - centre[1]);
        let pressed = on_base.is_none_or(|base| base.normal_stress == NormalStress::Effective);
        let own = width * self.soil.weight(x, [y, top], (self.level)(x).min(top));
        let Outside { traction, seismic } = self.outside;
        let [aside, standing] = traction(x).map(|stress| stress * width);
        // An earthquake acts in the middle of the height.
        let (shaken, middle) = (seismic * own, 0.5 * (y + top));
        let moment = aside * (centre[1] - top) + shaken * (centre[1] - middle);
        let strength = on_base.map_or_else(|| self.soil.strength(x, y), |base| base.strength);
        Slice {
            base: [x, y],
            width,
            height: top - y,
            slope,
            weight: own + standing,
            push: [aside + shaken, moment],
            pore: if pressed { (self.pressure)(x, y).max(0.0) } else { 0.0 },
            strength,
            tangent: strength.friction.tan(),
            arms: [-(beside * slope[0] + below * slope[1]), below * slope[0] - beside * slope[1]],
        }
    }
}

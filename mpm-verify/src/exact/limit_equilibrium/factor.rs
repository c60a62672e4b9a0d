//! Factor of safety of one slide: the methods of Bishop, Spencer, Morgenstern & Price, and the ordinary method of slices.

use super::{Refused, Slice, Slide};
use crate::exact::root::root;

/// Least `m = cos(alpha) + sin(alpha) tan(phi)/F` of a slice. Below it the normal force, which goes with 1/m, has no
/// meaning any more (Whitman & Bailey 1967, J. Soil Mech. Found. Div. ASCE 93(SM4)).
pub const LEAST_M: f64 = 0.2;
/// Factors between which one is looked for.
const FACTORS: [f64; 2] = [1e-3, 1e9];
/// Steps of the angle of the forces between slices in which the balance of forces is bracketed.
const ANGLES: usize = 12;
/// An arm below this share of the radius is none.
const ROUND_OFF: f64 = 1e-9;
/// Most steps of Newton's method, the relative step that its derivatives are differences over, and the one after which it ends.
const NEWTON: (usize, f64, f64) = (12, 1e-7, 1e-13);

/// How a factor of safety is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// [`Slide::bishop`].
    Bishop,
    /// [`Slide::spencer`].
    Spencer,
    /// [`Slide::morgenstern_price`].
    MorgensternPrice,
}

/// How the ratio of shear to normal force between slices, over lambda, goes from entry (0) to exit (1).
type Ratio = fn(f64) -> f64;

impl Slide {
    /// Factor of safety by a method.
    ///
    /// # Errors
    /// The method has none.
    pub fn factor(&self, method: Method) -> Result<f64, Refused> {
        match method {
            Method::Bishop => self.bishop(),
            Method::Spencer => self.spencer().map(|[factor, _]| factor),
            Method::MorgensternPrice => self.morgenstern_price().map(|[factor, _]| factor),
        }
    }

    /// Factor of safety by Bishop's simplified method, to round-off: a zero of `F driving - resisting` among the
    /// factors that keep every slice above [`LEAST_M`].
    ///
    /// # Errors
    /// No such factor.
    pub fn bishop(&self) -> Result<f64, Refused> {
        self.balanced_moments(0.0, |_| 0.0)
    }

    /// Factor of safety by Spencer's method, and the angle (rad) of the forces between slices below the horizontal
    /// towards +x: they are parallel to each other, and the balances of horizontal forces, vertical forces and
    /// moments all hold. What Bishop's method lacks where the slip surface is no circle; on a circle both are close.
    ///
    /// # Errors
    /// No factor at an angle up to the steepest base.
    pub fn spencer(&self) -> Result<[f64; 2], Refused> {
        self.balanced(|_| 1.0)
    }

    /// Factor of safety by Morgenstern & Price's method with half a sine, and the largest angle (rad) of the forces between slices.
    ///
    /// # Errors
    /// As [`Self::spencer`].
    pub fn morgenstern_price(&self) -> Result<[f64; 2], Refused> {
        self.balanced(|share| (std::f64::consts::PI * share).sin())
    }

    /// The factor with which all balances hold, and the angle (rad) whose tangent is lambda.
    fn balanced(&self, ratio: Ratio) -> Result<[f64; 2], Refused> {
        // The balance of moments gives a factor for every angle, that of forces the angle.
        let factor = |angle: f64| self.balanced_moments(angle.tan(), ratio);
        let force = |angle: f64| factor(angle).map_or(f64::NAN, |factor| self.sums(factor, angle.tan(), ratio)[2]);
        // Without friction the moments on a circle know nothing of the forces between slices: its normal forces have no arm.
        let on_circle = |slice: &Slice| slice.arms[1].abs() <= ROUND_OFF * self.circle.radius;
        if self.slices.iter().all(|slice| slice.tangent == 0.0 && on_circle(slice)) {
            return Ok([factor(0.0)?, 0.0]);
        }
        let steepest = self.slices.iter().map(|slice| slice.slope[0]).fold(0.0, f64::max).asin();
        if let Some(found) = factor(0.0).ok().and_then(|bishop| self.newton(bishop, steepest.tan(), ratio)) {
            return Ok(found);
        }
        let angles = (0..=ANGLES).map(|place| steepest * place as f64 / ANGLES as f64).collect::<Vec<_>>();
        let forces: Vec<f64> = angles.iter().map(|angle| force(*angle)).collect();
        let mut changes = (0..ANGLES).filter(|k| forces[*k] * forces[k + 1] <= 0.0);
        let angle = changes.find_map(|k| root(force, angles[k], angles[k + 1])).ok_or(Refused::TooSteep)?;
        Ok([factor(angle)?, angle])
    }

    /// Factor and angle as [`Self::balanced`] has them, from Bishop's factor by Newton's method in both balances at once, in a tenth of the
    /// evaluations; `None` where it does not lead to a lambda between zero and the most, and a factor that is allowed with it.
    fn newton(&self, bishop: f64, most: f64, ratio: Ratio) -> Option<[f64; 2]> {
        let (steps, share, close) = NEWTON;
        let left = |factor: f64, lambda: f64| {
            let [resisting, driving, force] = self.sums(factor, lambda, ratio);
            [factor * driving - resisting, force]
        };
        let (mut factor, mut lambda) = (bishop, 0.0);
        for _ in 0..steps {
            let here = left(factor, lambda);
            let (by_factor, by_lambda) = (left(factor * (1.0 + share), lambda), left(factor, lambda + share));
            let [a, b] =
                [0, 1].map(|k| [(by_factor[k] - here[k]) / (share * factor), (by_lambda[k] - here[k]) / share]);
            let determinant = a[0] * b[1] - a[1] * b[0];
            let step = [b[1] * here[0] - a[1] * here[1], a[0] * here[1] - b[0] * here[0]].map(|x| x / determinant);
            (factor, lambda) = (factor - step[0], lambda - step[1]);
            if !(factor > 0.0 && lambda.abs() <= most) {
                return None;
            }
            if step[0].abs() <= close * factor && step[1].abs() <= close {
                let [least, largest] = self.allowed(lambda, ratio)?;
                return (lambda >= 0.0 && (least..=largest).contains(&factor)).then(|| [factor, lambda.atan()]);
            }
        }
        None
    }

    /// The factor with which the balance of moments holds at some lambda.
    fn balanced_moments(&self, lambda: f64, ratio: Ratio) -> Result<f64, Refused> {
        let excess = |factor: f64| {
            let [resisting, driving, _] = self.sums(factor, lambda, ratio);
            factor * driving - resisting
        };
        solved(excess, self.allowed(lambda, ratio).ok_or(Refused::TooSteep)?)
    }

    /// Moments of the whole strength and of what drives, N m/m, and the horizontal force that is left at the exit, N/m.
    fn sums(&self, factor: f64, lambda: f64, ratio: Ratio) -> [f64; 3] {
        let span = self.exit[0] - self.entry[0];
        let at = |x: f64| lambda * ratio(((x - self.entry[0]) / span).clamp(0.0, 1.0));
        let (mut thrust, mut sums) = (0.0, [0.0; 2]);
        for slice in &self.slices {
            let half = 0.5 * slice.width;
            let [left, right] =
                if lambda == 0.0 { [0.0; 2] } else { [slice.base[0] - half, slice.base[0] + half].map(at) };
            let ([sin, cos], tan, length) = (slice.slope, slice.tangent, slice.length());
            let held = (slice.strength.cohesion - slice.pore * tan) * length;
            let m = cos + sin * tan / factor;
            let carried = slice.weight + left * thrust - held * sin / factor;
            let along = (sin - cos * tan / factor) / m;
            let next = (thrust + along * carried - held * cos / factor + slice.push[0]) / (1.0 + along * right);
            let normal = (carried - right * next) / m;
            let [resisting, driving] = self.moments(slice, normal);
            (sums[0], sums[1], thrust) = (sums[0] + resisting, sums[1] + driving, next);
        }
        [sums[0], sums[1], thrust]
    }

    /// Factor of safety by the ordinary method of slices (Fellenius): forces between slices are parallel to the base,
    /// `P = W cos(alpha)`. Below Bishop's, most of all on deep circles with high pore pressure.
    ///
    /// # Errors
    /// Nothing drives the slide.
    pub fn ordinary(&self) -> Result<f64, Refused> {
        let [resisting, driving] = self.slices.iter().fold([0.0; 2], |sum, slice| {
            let moments = self.moments(slice, slice.weight * slice.slope[1] - slice.push[0] * slice.slope[0]);
            [sum[0] + moments[0], sum[1] + moments[1]]
        });
        if driving > 0.0 { Ok(resisting / driving) } else { Err(Refused::NotDriven) }
    }

    /// Effective normal stress (Pa, compression positive) on the base of every slice at a factor of safety of Bishop's
    /// method.
    pub fn effective_stress(&self, factor: f64) -> Vec<f64> {
        self.slices.iter().map(|slice| slice.normal(factor) / slice.length() - slice.pore).collect()
    }

    /// Share of the slip surface, by length, where that stress is tensile.
    pub fn tension(&self, factor: f64) -> f64 {
        let stresses = self.effective_stress(factor).into_iter().zip(&self.slices);
        let [pulled, whole] = stresses.fold([0.0; 2], |[pulled, whole], (stress, slice)| {
            let length = slice.length();
            [pulled + if stress < 0.0 { length } else { 0.0 }, whole + length]
        });
        pulled / whole
    }

    /// Moments of the whole strength of a slice and of what drives it, N m/m, for its normal force (N/m).
    fn moments(&self, slice: &Slice, normal: f64) -> [f64; 2] {
        let ([shear_arm, normal_arm], length) = (slice.arms, slice.length());
        let friction = (normal - slice.pore * length) * slice.tangent;
        let held = shear_arm * (slice.strength.cohesion * length + friction);
        [held, slice.weight * (self.circle.centre[0] - slice.base[0]) + slice.push[1] - normal * normal_arm]
    }

    /// Factors between which `cos(alpha - t) + sin(alpha - t) tan(phi)/F` of no slice is below the least m, with forces
    /// between slices at an angle t; `None` without any.
    fn allowed(&self, lambda: f64, ratio: Ratio) -> Option<[f64; 2]> {
        let span = self.exit[0] - self.entry[0];
        let mut range = FACTORS;
        // Without friction the normal force does not matter.
        for slice in self.slices.iter().filter(|slice| slice.strength.friction != 0.0) {
            let turn = (lambda * ratio((slice.base[0] - self.entry[0]) / span)).atan().sin_cos();
            let ([sin, cos], tan) = (slice.turned(turn.into()), slice.tangent);
            // cos + sin tan/F = least at this factor.
            let limit = sin * tan / (LEAST_M - cos);
            if cos > LEAST_M && sin < 0.0 {
                range[0] = range[0].max(limit);
            } else if cos <= LEAST_M && sin > 0.0 {
                range[1] = range[1].min(limit);
            } else if cos <= LEAST_M {
                return None;
            }
        }
        (range[0] < range[1]).then_some(range)
    }
}

impl Slice {
    /// Normal force of Bishop's method, N/m.
    fn normal(&self, factor: f64) -> f64 {
        let ([sin, cos], tan) = (self.slope, self.tangent);
        let held = (self.strength.cohesion - self.pore * tan) * self.length();
        (self.weight - held * sin / factor) / (cos + sin * tan / factor)
    }

    /// Sine and cosine of the angle of the base less another one.
    fn turned(&self, [sin, cos]: [f64; 2]) -> [f64; 2] {
        [self.slope[0] * cos - self.slope[1] * sin, self.slope[1] * cos + self.slope[0] * sin]
    }
}

/// The factor in a range at which an excess of what drives over what holds turns positive.
fn solved(excess: impl Fn(f64) -> f64, [least, most]: [f64; 2]) -> Result<f64, Refused> {
    if excess(least) > 0.0 {
        return Err(Refused::TooSteep);
    }
    let mut high = (2.0 * least).max(1.0);
    while high < most && excess(high) <= 0.0 {
        high *= 2.0;
    }
    let missing = if most < FACTORS[1] { Refused::TooSteep } else { Refused::NotDriven };
    root(excess, least, high.min(most)).ok_or(missing)
}

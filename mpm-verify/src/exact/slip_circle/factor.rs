//! Factor of safety of one slide: Bishop's simplified method, Spencer's, and the ordinary method of slices.

use super::{Refused, Slice, Slide};
use crate::exact::root::root;

/// Least `m = cos(alpha) + sin(alpha) tan(phi)/F` of a slice. Below it the normal force, which goes with 1/m, has no
/// meaning any more (Whitman & Bailey 1967, J. Soil Mech. Found. Div. ASCE 93(SM4)).
pub const LEAST_M: f64 = 0.2;
/// Factors between which one is looked for.
const FACTORS: [f64; 2] = [1e-3, 1e9];
/// Steps of the angle in which Spencer's balance of forces is bracketed.
const ANGLES: usize = 12;

/// How a factor of safety is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// [`Slide::bishop`].
    Bishop,
    /// [`Slide::spencer`].
    Spencer,
}

impl Slide {
    /// Factor of safety by a method.
    ///
    /// # Errors
    /// The method has none.
    pub fn factor(&self, method: Method) -> Result<f64, Refused> {
        match method {
            Method::Bishop => self.bishop(),
            Method::Spencer => self.spencer().map(|[factor, _]| factor),
        }
    }

    /// Factor of safety by Bishop's simplified method, to round-off: a zero of `F driving - resisting` among the
    /// factors that keep every slice above [`LEAST_M`].
    ///
    /// # Errors
    /// No such factor.
    pub fn bishop(&self) -> Result<f64, Refused> {
        let excess = |factor: f64| {
            let [resisting, driving] = self.moments(|slice| slice.normal(factor));
            factor * driving - resisting
        };
        solved(excess, self.allowed(0.0).ok_or(Refused::TooSteep)?)
    }

    /// Factor of safety by the ordinary method of slices (Fellenius): forces between slices are parallel to the base,
    /// `P = W cos(alpha)`. Below Bishop's, most of all on deep circles with high pore pressure.
    ///
    /// # Errors
    /// Nothing drives the slide.
    pub fn ordinary(&self) -> Result<f64, Refused> {
        let [resisting, driving] = self.moments(|slice| slice.weight * slice.slope[1]);
        if driving > 0.0 { Ok(resisting / driving) } else { Err(Refused::NotDriven) }
    }

    /// Factor of safety by Spencer's method, and the angle (rad) of the forces between slices below the horizontal
    /// towards +x: they are parallel to each other, and the balances of horizontal forces, vertical forces and
    /// moments all hold. What Bishop's method lacks where the slip surface is no circle; on a circle both are close.
    ///
    /// The sum Q of the forces on both sides of a slice goes through the middle of its base. Along and normal to the
    /// base
    /// `Q = [W sin(alpha) - (c l + (W cos(alpha) - u l) tan phi)/F]/[cos(alpha - t) + sin(alpha - t) tan(phi)/F]`;
    /// over all slices the sums of Q and of its moment are zero. Spencer 1967, Geotechnique 17(1),
    /// doi:10.1680/geot.1967.17.1.11.
    ///
    /// # Errors
    /// No factor at an angle up to the steepest base.
    pub fn spencer(&self) -> Result<[f64; 2], Refused> {
        let [centre_x, centre_y] = self.circle.centre;
        let sums = |factor: f64, angle: f64| {
            let turn @ [sin, cos]: [f64; 2] = angle.sin_cos().into();
            self.slices.iter().fold([0.0; 2], |[force, moment], slice| {
                let side = slice.side(factor, turn);
                let arm = (slice.base[0] - centre_x) * sin + (slice.base[1] - centre_y) * cos;
                [force + side, moment + side * arm]
            })
        };
        // The balance of moments gives a factor for every angle, that of forces the angle.
        let factor = |angle: f64| {
            let excess = |factor: f64| -factor * sums(factor, angle)[1];
            solved(excess, self.allowed(angle).ok_or(Refused::TooSteep)?)
        };
        let force = |angle: f64| factor(angle).map_or(f64::NAN, |factor| sums(factor, angle)[0]);
        let steepest = self.slices.iter().map(|slice| slice.slope[0]).fold(0.0, f64::max).asin();
        let angles = (0..=ANGLES).map(|place| steepest * place as f64 / ANGLES as f64).collect::<Vec<_>>();
        let angle = angles.windows(2).find_map(|pair| root(force, pair[0], pair[1])).ok_or(Refused::TooSteep)?;
        Ok([factor(angle)?, angle])
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

    /// Moments of the whole strength and of what drives, N m/m, for the normal forces of the slices (N/m).
    fn moments(&self, normal: impl Fn(&Slice) -> f64) -> [f64; 2] {
        self.slices.iter().fold([0.0; 2], |[resisting, driving], slice| {
            let ([shear_arm, normal_arm], force, length) = (slice.arms, normal(slice), slice.length());
            let friction = (force - slice.pore * length) * slice.strength.friction.tan();
            let held = shear_arm * (slice.strength.cohesion * length + friction);
            let driven = slice.weight * (self.circle.centre[0] - slice.base[0]) - force * normal_arm;
            [resisting + held, driving + driven]
        })
    }

    /// Factors between which `cos(alpha - t) + sin(alpha - t) tan(phi)/F` of no slice is below the least m, with forces
    /// between slices at an angle t (rad); `None` without any.
    fn allowed(&self, angle: f64) -> Option<[f64; 2]> {
        let mut range = FACTORS;
        let turn: [f64; 2] = angle.sin_cos().into();
        // Without friction the normal force does not matter.
        for slice in self.slices.iter().filter(|slice| slice.strength.friction != 0.0) {
            let ([sin, cos], tan) = (slice.turned(turn), slice.strength.friction.tan());
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
        let ([sin, cos], tan) = (self.slope, self.strength.friction.tan());
        let held = (self.strength.cohesion - self.pore * tan) * self.length();
        (self.weight - held * sin / factor) / (cos + sin * tan / factor)
    }

    /// Sum of Spencer's forces on both sides, N/m, at the sine and cosine of their angle; positive up the slope.
    fn side(&self, factor: f64, angle: [f64; 2]) -> f64 {
        let ([sin, cos], tan, length) = (self.slope, self.strength.friction.tan(), self.length());
        let held = self.strength.cohesion * length + (self.weight * cos - self.pore * length) * tan;
        let [turned_sin, turned_cos] = self.turned(angle);
        (self.weight * sin - held / factor) / (turned_cos + turned_sin * tan / factor)
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

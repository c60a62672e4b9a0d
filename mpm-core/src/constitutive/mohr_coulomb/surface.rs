//! The numbers of a surface and its elasticity, worked out once.

use super::fading::{Fading, Planes};
use crate::real::{Real, array};
use crate::scene::{Elastic, Strength};

/// A soil without cohesion has no strength of its own to compare with: there stands the stress of this strain.
const STRAIN_OF_SCALE: f64 = 1e-5;

/// Elasticity and the other constants of a soil that do not change while it flows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Soil {
    /// Stress of the apex, c/tan(phi), Pa.
    pub apex: f64,
    /// sigma_t, Pa; infinite without a cut-off.
    pub cutoff: f64,
    /// lambda, Pa.
    pub lame: f64,
    /// G, Pa.
    pub shear: f64,
    /// E, Pa.
    pub youngs_modulus: f64,
    /// nu.
    pub poisson_ratio: f64,
    /// 1/(2 c cos(phi)), 1/Pa; for c = 0 one over the stress E times 1e-5.
    inverse_scale: f64,
}

/// Yield planes and flow directions in ordered principal stresses, with the stiffness between them.
///
/// The main plane is `n1 s1 - n3 s3 = k` with n1 = 1 + sin(phi), n3 = 1 - sin(phi), k = 2 c cos(phi); `push` is D b, the
/// stress that a unit of flow b = (1 + sin(psi), 0, -(1 - sin(psi))) takes away.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surface<R = f64> {
    /// [n1, n3].
    pub normal: [R; 2],
    /// k, Pa.
    pub strength: R,
    /// b without its zero: [1 + sin(psi), -(1 - sin(psi))].
    pub along: [R; 2],
    /// D b, Pa.
    pub push: [R; 3],
    /// 1/(a D b) of the main plane, 1/Pa.
    pub of_face: R,
    /// 1/(a D b_1 + a D b_2) where s1 = s2 and where s2 = s3, 1/Pa.
    pub of_edge: [R; 2],
    /// s3 where the main plane meets s1 = sigma_t, Pa.
    pub low: R,
    /// What does not change.
    pub soil: Soil,
}

impl Surface {
    /// The surface of a soil that has not flowed yet.
    pub fn new(elastic: &Elastic, strength: &Strength) -> Self {
        let planes = match Fading::of(strength) {
            Some(fading) => fading.planes(0.0),
            None => {
                let (sin, cos) = strength.friction_angle.to_radians().sin_cos();
                Planes {
                    sin,
                    strength: 2.0 * strength.cohesion * cos,
                    dilation: strength.dilation_angle.to_radians().sin(),
                }
            }
        };
        let k = planes.strength;
        let scale = if k > 0.0 { k } else { STRAIN_OF_SCALE * elastic.youngs_modulus };
        let soil = Soil {
            apex: strength.apex(),
            cutoff: strength.tension_cutoff.unwrap_or(f64::INFINITY),
            lame: elastic.lame(),
            shear: elastic.shear_modulus(),
            youngs_modulus: elastic.youngs_modulus,
            poisson_ratio: elastic.poisson_ratio,
            inverse_scale: 1.0 / scale,
        };
        soil.within(&planes)
    }

    /// The elasticity, so many times as stiff.
    pub fn elastic(&self, stiffness: f64) -> Elastic {
        let Soil { youngs_modulus, poisson_ratio, .. } = self.soil;
        Elastic { youngs_modulus: stiffness * youngs_modulus, poisson_ratio }
    }

    /// The same in every lane.
    #[inline(always)]
    pub fn as_wide_as<R: Real>(&self, like: R) -> Surface<R> {
        let wide = |number: f64| like.like(number);
        Surface {
            normal: [wide(self.normal[0]), wide(self.normal[1])],
            strength: wide(self.strength),
            along: [wide(self.along[0]), wide(self.along[1])],
            push: [wide(self.push[0]), wide(self.push[1]), wide(self.push[2])],
            of_face: wide(self.of_face),
            of_edge: [wide(self.of_edge[0]), wide(self.of_edge[1])],
            low: wide(self.low),
            soil: self.soil,
        }
    }

    /// Energy stored per volume at principal stresses (Pa), J/m3: (sum s_i^2 - 2 nu sum s_i s_j)/(2 E).
    pub fn energy(&self, s: &[f64; 3]) -> f64 {
        0.5 * self.soil.work(s, s)
    }
}

impl Soil {
    /// Its surface within some planes.
    #[inline(always)]
    pub fn within<R: Real>(&self, planes: &Planes<R>) -> Surface<R> {
        let Planes { sin, strength: k, dilation } = *planes;
        let one = sin.like(1.0);
        let (normal, along) = ([one + sin, one - sin], [one + dilation, dilation - one]);
        // D b = lambda tr(b) I + 2 G b
        let volumetric = (along[0] + along[1]) * self.lame;
        let twice = 2.0 * self.shear;
        let push = [volumetric + along[0] * twice, volumetric, volumetric + along[1] * twice];
        let face = normal[0] * push[0] - normal[1] * push[2];
        let edge = [normal[0] * push[1] - normal[1] * push[2], normal[0] * push[0] - normal[1] * push[1]];
        Surface {
            normal,
            strength: k,
            along,
            push,
            of_face: one / face,
            of_edge: [one / (face + edge[0]), one / (face + edge[1])],
            low: (normal[0] * self.cutoff - k) / normal[1],
            soil: *self,
        }
    }

    /// The larger of planes that are exceeded by `sheared` (Pa) and of f_t at the largest principal stress (Pa), as a share of
    /// 2 c cos(phi).
    #[inline(always)]
    pub fn exceeded<R: Real>(&self, high: R, sheared: R) -> R {
        sheared.larger(high - high.like(self.cutoff)) * self.inverse_scale
    }

    /// Plastic shear strain from a trial stress to the one it is brought back to (Pa): eps_1 - eps_3 of d eps_p = C (trial - sigma).
    #[inline(always)]
    pub fn slipped<R: Real>(&self, trial: &[R; 3], found: &[R; 3]) -> R {
        (trial[0] - found[0] - trial[2] + found[2]) / trial[0].like(2.0 * self.shear)
    }

    /// Energy dissipated per volume from a trial stress to the one it is brought back to (Pa), J/m3: sigma : d eps_p with
    /// the stress of the end, d eps_p = C (trial - sigma). Never negative where the flow is associated.
    #[inline(always)]
    pub fn dissipation<R: Real>(&self, trial: &[R; 3], found: &[R; 3]) -> R {
        self.work(found, &array!([trial[0]; 3], i => trial[i] - found[i]))
    }

    /// s : C^-1 : t, J/m3.
    #[inline(always)]
    fn work<R: Real>(&self, s: &[R; 3], t: &[R; 3]) -> R {
        let along = s[0] * t[0] + s[1] * t[1] + s[2] * t[2];
        let mean = (s[0] + s[1] + s[2]) * (t[0] + t[1] + t[2]);
        (along * (1.0 + self.poisson_ratio) - mean * self.poisson_ratio) / s[0].like(self.youngs_modulus)
    }
}

impl<R: Real> Surface<R> {
    /// f of the planes through the stresses `high` and `low` (Pa), Pa.
    #[inline(always)]
    pub fn over(&self, high: R, low: R) -> R {
        high * self.normal[0] - low * self.normal[1] - self.strength
    }

    /// The larger of f and f_t at the largest and smallest principal stress (Pa), as a share of 2 c cos(phi).
    #[inline(always)]
    pub fn excess(&self, [high, low]: [R; 2]) -> R {
        self.soil.exceeded(high, self.over(high, low))
    }
}

#[cfg(test)]
impl Surface {
    /// What a stress of 1 Pa adds to the excess at most, 1/Pa: how round-off of a stress shows.
    pub fn excess_per_stress(&self) -> f64 {
        2.0 * (self.normal[0] + self.normal[1]) * self.soil.inverse_scale
    }
}

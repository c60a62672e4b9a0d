//! The numbers of a surface and its elasticity, worked out once.

use super::fading::{Fading, Planes};
use crate::real::Real;
use crate::scene::{Elastic, Strength};

/// A soil without cohesion has no strength of its own to compare with: there stands the stress of this strain.
const STRAIN_OF_SCALE: f64 = 1e-5;

/// Yield planes and flow directions in ordered principal stresses, with the stiffness between them.
///
/// The main plane is `n1 s1 - n3 s3 = k` with n1 = 1 + sin(phi), n3 = 1 - sin(phi), k = 2 c cos(phi); `push` is D b, the
/// stress that a unit of flow b = (1 + sin(psi), 0, -(1 - sin(psi))) takes away.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surface {
    /// [n1, n3].
    pub normal: [f64; 2],
    /// k, Pa.
    pub strength: f64,
    /// b without its zero: [1 + sin(psi), -(1 - sin(psi))].
    pub along: [f64; 2],
    /// D b, Pa.
    pub push: [f64; 3],
    /// 1/(a D b) of the main plane, 1/Pa.
    pub of_face: f64,
    /// 1/(a D b_1 + a D b_2) where s1 = s2 and where s2 = s3, 1/Pa.
    pub of_edge: [f64; 2],
    /// Stress of the apex, c/tan(phi), Pa.
    pub apex: f64,
    /// sigma_t, Pa; infinite without a cut-off.
    pub cutoff: f64,
    /// s3 where the main plane meets s1 = sigma_t, Pa.
    pub low: f64,
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
        let cutoff = strength.tension_cutoff.unwrap_or(f64::INFINITY);
        Self::of(elastic, &planes, [strength.apex(), cutoff], 1.0 / scale)
    }

    /// The same soil with other planes.
    pub fn with(&self, planes: &Planes) -> Self {
        Self::of(&self.elastic(1.0), planes, [self.apex, self.cutoff], self.inverse_scale)
    }

    fn of(elastic: &Elastic, planes: &Planes, [apex, cutoff]: [f64; 2], inverse_scale: f64) -> Self {
        let (lame, shear) = (elastic.lame(), elastic.shear_modulus());
        let Planes { sin, strength: k, dilation } = *planes;
        let (normal, along) = ([1.0 + sin, 1.0 - sin], [1.0 + dilation, dilation - 1.0]);
        // D b = lambda tr(b) I + 2 G b
        let volumetric = lame * (along[0] + along[1]);
        let push = [volumetric + 2.0 * shear * along[0], volumetric, volumetric + 2.0 * shear * along[1]];
        let face = normal[0] * push[0] - normal[1] * push[2];
        let edge = [normal[0] * push[1] - normal[1] * push[2], normal[0] * push[0] - normal[1] * push[1]];
        Self {
            normal,
            strength: k,
            along,
            push,
            of_face: 1.0 / face,
            of_edge: edge.map(|mixed| 1.0 / (face + mixed)),
            apex,
            cutoff,
            low: (normal[0] * cutoff - k) / normal[1],
            lame,
            shear,
            youngs_modulus: elastic.youngs_modulus,
            poisson_ratio: elastic.poisson_ratio,
            inverse_scale,
        }
    }

    /// The elasticity, so many times as stiff.
    pub fn elastic(&self, stiffness: f64) -> Elastic {
        Elastic { youngs_modulus: stiffness * self.youngs_modulus, poisson_ratio: self.poisson_ratio }
    }

    /// f of the planes through the stresses `high` and `low` (Pa), Pa.
    #[inline(always)]
    pub fn over(&self, high: f64, low: f64) -> f64 {
        high * self.normal[0] - low * self.normal[1] - self.strength
    }

    /// The larger of f and f_t at the largest and smallest principal stress (Pa), as a share of 2 c cos(phi).
    #[inline(always)]
    pub fn excess<R: Real>(&self, [high, low]: [R; 2]) -> R {
        let sheared = high * self.normal[0] - low * self.normal[1] - high.like(self.strength);
        self.exceeded([high, low], sheared)
    }

    /// The same of planes that are exceeded by `sheared`, Pa.
    #[inline(always)]
    pub fn exceeded<R: Real>(&self, [high, _]: [R; 2], sheared: R) -> R {
        sheared.larger(high - high.like(self.cutoff)) * self.inverse_scale
    }

    /// Plastic shear strain from a trial stress to the one it is brought back to (Pa): eps_1 - eps_3 of d eps_p = C (trial - sigma).
    pub fn slipped(&self, trial: &[f64; 3], found: &[f64; 3]) -> f64 {
        (trial[0] - found[0] - trial[2] + found[2]) / (2.0 * self.shear)
    }

    /// Energy stored per volume at principal stresses (Pa), J/m3: (sum s_i^2 - 2 nu sum s_i s_j)/(2 E).
    pub fn energy(&self, s: &[f64; 3]) -> f64 {
        0.5 * self.work(s, s)
    }

    /// Energy dissipated per volume from a trial stress to the one it is brought back to (Pa), J/m3: sigma : d eps_p with
    /// the stress of the end, d eps_p = C (trial - sigma). Never negative where the flow is associated.
    pub fn dissipation(&self, trial: &[f64; 3], found: &[f64; 3]) -> f64 {
        self.work(found, &std::array::from_fn(|i| trial[i] - found[i]))
    }

    /// s : C^-1 : t, J/m3.
    #[inline(always)]
    fn work(&self, s: &[f64; 3], t: &[f64; 3]) -> f64 {
        let along = s[0] * t[0] + s[1] * t[1] + s[2] * t[2];
        let mean = (s[0] + s[1] + s[2]) * (t[0] + t[1] + t[2]);
        ((1.0 + self.poisson_ratio) * along - self.poisson_ratio * mean) / self.youngs_modulus
    }
}

#[cfg(test)]
impl Surface {
    /// What a stress of 1 Pa adds to the excess at most, 1/Pa: how round-off of a stress shows.
    pub fn excess_per_stress(&self) -> f64 {
        2.0 * (self.normal[0] + self.normal[1]) * self.inverse_scale
    }
}

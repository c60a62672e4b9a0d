//! Isotropic linear elasticity (Hooke): `dsigma = lambda tr(deps) I + 2 G deps`.
//!
//! Energy per volume `w = 1/2 sigma : C^-1 : sigma`. Source: any text on elasticity, e.g. Sadd, *Elasticity*, ch. 4.

use nalgebra::{SMatrix, SVector};
use pulp::Simd;

use super::{Altered, Flow, Law, State};
use crate::real::{Real, SimdReal};
use crate::scene::Elastic;

/// Linear elasticity, components xx, yy, zz, xy.
#[derive(Debug, Clone, Copy)]
pub struct LinearElastic {
    lame: f64,
    shear: f64,
    compliance: SMatrix<f64, 4, 4>,
}

/// Stiffness for xx, yy, zz, xy with engineering shear strain.
fn plane_stiffness(lame: f64, shear: f64) -> SMatrix<f64, 4, 4> {
    let mut c = SMatrix::<f64, 4, 4>::zeros();
    for i in 0..3 {
        for j in 0..3 {
            c[(i, j)] = lame + if i == j { 2.0 * shear } else { 0.0 };
        }
    }
    c[(3, 3)] = shear;
    c
}

impl LinearElastic {
    /// The law of a soil.
    pub fn new(elastic: &Elastic) -> Self {
        let (lame, shear) = (elastic.lame(), elastic.shear_modulus());
        let Elastic { youngs_modulus, poisson_ratio } = *elastic;
        let mut compliance = SMatrix::from_element(0.0);
        for i in 0..3 {
            for j in 0..3 {
                compliance[(i, j)] = if i == j { 1.0 } else { -poisson_ratio } / youngs_modulus;
            }
        }
        compliance[(3, 3)] = 1.0 / shear;
        Self { lame, shear, compliance }
    }
}

impl LinearElastic {
    /// Adds the stress (Pa) of a strain.
    #[inline(always)]
    pub fn hooke<R: Real>(&self, stress: &mut [R; 4], strain: &[R; 4]) {
        let volumetric = (strain[0] + strain[1] + strain[2]) * self.lame;
        for i in 0..3 {
            stress[i] += volumetric + strain[i] * (2.0 * self.shear);
        }
        stress[3] += strain[3] * self.shear;
    }
}

impl LinearElastic {
    /// Energy per volume (J/m3) at a stress less that at another: `(from - to) : C^-1 : (from + to)/2`.
    #[inline(always)]
    pub(super) fn released<R: Real>(&self, from: &[R; 4], to: &[R; 4]) -> R {
        let mut sum = from[0].like(0.0);
        for i in 0..4 {
            let mut strain = sum.like(0.0);
            for j in 0..4 {
                strain += (from[j] + to[j]) * self.compliance[(i, j)];
            }
            sum += (from[i] - to[i]) * strain * 0.5;
        }
        sum
    }

    /// The same law with so many times its stiffness.
    pub(super) fn stiffened(&self, times: f64) -> Self {
        Self { lame: times * self.lame, shear: times * self.shear, compliance: self.compliance / times }
    }
}

impl Law for LinearElastic {
    #[inline(always)]
    fn update(&self, stress: &mut [f64; 4], strain: &[f64; 4], _: &mut State) -> Flow {
        self.hooke(stress, strain);
        Flow::none(0.0)
    }

    #[inline(always)]
    fn update_lanes<V: Simd>(
        &self,
        stress: &mut [SimdReal<V>; 4],
        strain: &[SimdReal<V>; 4],
        _: &mut State<SimdReal<V>>,
        _: V::m64s,
    ) -> Flow<SimdReal<V>> {
        self.hooke(stress, strain);
        Flow::none(stress[0])
    }

    fn is_linear(&self) -> bool {
        true
    }

    fn tangent(&self, _: &[f64; 4], _: &[f64; 4], _: &State) -> SMatrix<f64, 4, 4> {
        plane_stiffness(self.lame, self.shear)
    }

    fn energy(&self, stress: &[f64; 4]) -> f64 {
        let sigma = SVector::<f64, 4>::from(*stress);
        0.5 * (self.compliance * sigma).dot(&sigma)
    }

    fn dilation(&self, stress: &[f64; 4]) -> f64 {
        dilation(&self.compliance, stress)
    }

    #[inline(always)]
    fn released_lanes<V: Simd>(&self, from: &[SimdReal<V>; 4], to: &[SimdReal<V>; 4]) -> SimdReal<V> {
        self.released(from, to)
    }

    fn altered(&self, by: &Altered) -> Self {
        self.stiffened(by.stiffness)
    }
}

/// Strain of volume at a stress: the sum of the normal strains.
fn dilation(compliance: &SMatrix<f64, 4, 4>, stress: &[f64; 4]) -> f64 {
    let strain = compliance * SVector::<f64, 4>::from(*stress);
    strain[0] + strain[1] + strain[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOIL: Elastic = Elastic { youngs_modulus: 2.0e7, poisson_ratio: 0.3 };

    #[test]
    fn plane_strain_matches_its_tangent_and_energy() {
        check_law!(LinearElastic::new(&SOIL), [-3e-4, 1e-4, 0.0, 5e-4]);
    }

    #[test]
    fn oedometer_compression_has_its_modulus() {
        let mut stress = [0.0; 4];
        LinearElastic::new(&SOIL).hooke(&mut stress, &[0.0, -1e-3, 0.0, 0.0]);
        assert!((stress[0] - stress[2]).abs() < 1e-9 && (stress[1] + 1e-3 * SOIL.oedometer_modulus()).abs() < 1e-9);
    }
}

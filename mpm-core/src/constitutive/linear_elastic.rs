//! Isotropic linear elasticity (Hooke): `dsigma = lambda tr(deps) I + 2 G deps`.
//!
//! Energy per volume `w = 1/2 sigma : C^-1 : sigma`. Source: any text on elasticity, e.g. Sadd, *Elasticity*, ch. 4.

use nalgebra::{SMatrix, SVector};
use pulp::Simd;

use super::Law;
use crate::real::{Lanes, Real};
use crate::scene::Elastic;

/// Linear elasticity with S stress components: 2 in a column (vertical, lateral), 4 in plane strain.
#[derive(Debug, Clone, Copy)]
pub struct LinearElastic<const S: usize> {
    lame: f64,
    shear: f64,
    compliance: SMatrix<f64, S, S>,
}

/// Stiffness of the column: a vertical strain only; the lateral stress stands for both horizontal directions.
fn column_stiffness(lame: f64, shear: f64) -> SMatrix<f64, 2, 2> {
    SMatrix::from([[lame + 2.0 * shear, lame], [lame, lame + 2.0 * shear]])
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

impl LinearElastic<2> {
    /// The law for a column.
    pub fn column(elastic: &Elastic) -> Self {
        let (lame, shear) = (elastic.lame(), elastic.shear_modulus());
        // Under vertical strain alone w = sigma_v^2 / (2 M); the lateral stress does no work.
        let compliance = SMatrix::from([[1.0 / elastic.oedometer_modulus(), 0.0], [0.0, 0.0]]);
        Self { lame, shear, compliance }
    }
}

impl LinearElastic<4> {
    /// The law for plane strain.
    pub fn plane_strain(elastic: &Elastic) -> Self {
        let (lame, shear) = (elastic.lame(), elastic.shear_modulus());
        let stiffness = plane_stiffness(lame, shear);
        // lambda and G of a checked scene (E > 0, -1 < nu < 1/2) make the stiffness positive definite.
        let compliance = stiffness.try_inverse().unwrap_or_else(SMatrix::zeros);
        Self { lame, shear, compliance }
    }
}

impl LinearElastic<2> {
    #[inline(always)]
    fn hooke<R: Real>(&self, stress: &mut [R; 2], strain: &[R; 2]) {
        stress[0] += strain[0] * (self.lame + 2.0 * self.shear);
        stress[1] += strain[0] * self.lame;
    }
}

impl LinearElastic<4> {
    #[inline(always)]
    fn hooke<R: Real>(&self, stress: &mut [R; 4], strain: &[R; 4]) {
        let volumetric = (strain[0] + strain[1] + strain[2]) * self.lame;
        for i in 0..3 {
            stress[i] += volumetric + strain[i] * (2.0 * self.shear);
        }
        stress[3] += strain[3] * self.shear;
    }
}

impl<const S: usize> LinearElastic<S> {
    /// The same law with so many times its stiffness.
    pub(super) fn stiffened(&self, times: f64) -> Self {
        Self { lame: times * self.lame, shear: times * self.shear, compliance: self.compliance / times }
    }
}

impl Law<2> for LinearElastic<2> {
    #[inline(always)]
    fn update(&self, stress: &mut [f64; 2], strain: &[f64; 2]) {
        self.hooke(stress, strain);
    }

    #[inline(always)]
    fn update_lanes<V: Simd>(&self, stress: &mut [Lanes<V>; 2], strain: &[Lanes<V>; 2]) {
        self.hooke(stress, strain);
    }

    const LINEAR: bool = true;

    fn tangent(&self, _: &[f64; 2], _: &[f64; 2]) -> SMatrix<f64, 2, 2> {
        column_stiffness(self.lame, self.shear)
    }

    fn energy(&self, stress: &[f64; 2]) -> f64 {
        energy(&self.compliance, stress)
    }

    fn dilation(&self, stress: &[f64; 2]) -> f64 {
        dilation(&self.compliance, stress)
    }

    fn altered(&self, _factor: f64, stiffness: f64) -> Self {
        self.stiffened(stiffness)
    }
}

impl Law<4> for LinearElastic<4> {
    #[inline(always)]
    fn update(&self, stress: &mut [f64; 4], strain: &[f64; 4]) {
        self.hooke(stress, strain);
    }

    #[inline(always)]
    fn update_lanes<V: Simd>(&self, stress: &mut [Lanes<V>; 4], strain: &[Lanes<V>; 4]) {
        self.hooke(stress, strain);
    }

    const LINEAR: bool = true;

    fn tangent(&self, _: &[f64; 4], _: &[f64; 4]) -> SMatrix<f64, 4, 4> {
        plane_stiffness(self.lame, self.shear)
    }

    fn energy(&self, stress: &[f64; 4]) -> f64 {
        energy(&self.compliance, stress)
    }

    fn dilation(&self, stress: &[f64; 4]) -> f64 {
        dilation(&self.compliance, stress)
    }

    fn altered(&self, _factor: f64, stiffness: f64) -> Self {
        self.stiffened(stiffness)
    }
}

fn energy<const S: usize>(compliance: &SMatrix<f64, S, S>, stress: &[f64; S]) -> f64 {
    let sigma = SVector::<f64, S>::from(*stress);
    0.5 * (compliance * sigma).dot(&sigma)
}

/// Strain of volume at a stress: the sum of the normal strains, one in a column, three in plane strain.
fn dilation<const S: usize>(compliance: &SMatrix<f64, S, S>, stress: &[f64; S]) -> f64 {
    let strain = compliance * SVector::<f64, S>::from(*stress);
    if S == 2 { strain[0] } else { strain[0] + strain[1] + strain[2] }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOIL: Elastic = Elastic { youngs_modulus: 2.0e7, poisson_ratio: 0.3 };

    #[test]
    fn column_matches_its_tangent_and_energy() {
        check_law!(LinearElastic::column(&SOIL), 2, [-3e-4, 0.0]);
    }

    #[test]
    fn plane_strain_matches_its_tangent_and_energy() {
        check_law!(LinearElastic::plane_strain(&SOIL), 4, [-3e-4, 1e-4, 0.0, 5e-4]);
    }

    #[test]
    fn both_dimensions_agree_in_oedometer_compression() {
        let (mut one, mut two) = ([0.0; 2], [0.0; 4]);
        LinearElastic::column(&SOIL).update(&mut one, &[-1e-3, 0.0]);
        LinearElastic::plane_strain(&SOIL).update(&mut two, &[0.0, -1e-3, 0.0, 0.0]);
        assert!((one[0] - two[1]).abs() < 1e-9 && (one[1] - two[0]).abs() < 1e-9 && (one[1] - two[2]).abs() < 1e-9);
        assert!((one[0] + 1e-3 * SOIL.oedometer_modulus()).abs() < 1e-9);
    }
}

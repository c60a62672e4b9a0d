//! Finite strain: the stretch and the rotation of a deformation gradient.
//!
//! The law sees the logarithmic strain `ln U` in the frame before rotation; its stress is the Cauchy stress there,
//! and turns with R. In one dimension that is `sigma' = M ln J`, whatever the size of a step.

use crate::dimension::{Column, Kinematics, PlaneStrain};

/// A deformation gradient taken apart, `F = R U`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch<const D: usize, const S: usize> {
    /// Logarithmic strain ln U, components as the stress with engineering shear.
    pub strain: [f64; S],
    /// R.
    pub rotation: [[f64; D]; D],
    /// det F.
    pub volume: f64,
    /// F^-1.
    pub inverse: [[f64; D]; D],
}

/// What implicit steps need of a dimension.
pub trait Deformation<const D: usize, const S: usize>: Kinematics<D, S> {
    /// Strain of a displacement `direction` times a function with a gradient (1/m).
    fn strain_mode(slope: &[f64; D], direction: &[f64; D]) -> [f64; S];
    /// The stress as a tensor, Pa.
    fn tensor(stress: &[f64; S]) -> [[f64; D]; D];
    /// A stress turned by a rotation, Pa.
    fn turned(stress: &[f64; S], rotation: &[[f64; D]; D]) -> [f64; S];
    /// Takes `I + gradient` apart; `None` if it turns a volume inside out.
    fn stretch(gradient: &[[f64; D]; D]) -> Option<Stretch<D, S>>;
}

impl Deformation<1, 2> for Column {
    fn strain_mode(slope: &[f64; 1], direction: &[f64; 1]) -> [f64; 2] {
        [slope[0] * direction[0], 0.0]
    }

    fn tensor(stress: &[f64; 2]) -> [[f64; 1]; 1] {
        [[stress[0]]]
    }

    fn turned(stress: &[f64; 2], _: &[[f64; 1]; 1]) -> [f64; 2] {
        *stress
    }

    fn stretch(gradient: &[[f64; 1]; 1]) -> Option<Stretch<1, 2>> {
        let volume = 1.0 + gradient[0][0];
        let strain = [gradient[0][0].ln_1p(), 0.0];
        (volume > 0.0).then_some(Stretch { strain, rotation: [[1.0]], volume, inverse: [[1.0 / volume]] })
    }
}

impl Deformation<2, 4> for PlaneStrain {
    fn strain_mode(slope: &[f64; 2], direction: &[f64; 2]) -> [f64; 4] {
        [slope[0] * direction[0], slope[1] * direction[1], 0.0, slope[1] * direction[0] + slope[0] * direction[1]]
    }

    fn tensor(stress: &[f64; 4]) -> [[f64; 2]; 2] {
        [[stress[0], stress[3]], [stress[3], stress[1]]]
    }

    fn turned(stress: &[f64; 4], rotation: &[[f64; 2]; 2]) -> [f64; 4] {
        let [[c, s], _] = *rotation; // R = [[c, s], [-s, c]]
        let [xx, yy, zz, xy] = *stress;
        [
            c * c * xx + 2.0 * c * s * xy + s * s * yy,
            s * s * xx - 2.0 * c * s * xy + c * c * yy,
            zz,
            c * s * (yy - xx) + (c * c - s * s) * xy,
        ]
    }

    fn stretch(gradient: &[[f64; 2]; 2]) -> Option<Stretch<2, 4>> {
        let f = [[1.0 + gradient[0][0], gradient[0][1]], [gradient[1][0], 1.0 + gradient[1][1]]];
        let volume = f[0][0] * f[1][1] - f[0][1] * f[1][0];
        if volume.is_nan() || volume <= 0.0 {
            return None;
        }
        // Polar decomposition in the plane: R is the rotation by atan2(F_01 - F_10, F_00 + F_11).
        let (sum, difference) = (f[0][0] + f[1][1], f[0][1] - f[1][0]);
        let norm = sum.hypot(difference);
        let (c, s) = (sum / norm, difference / norm);
        let rotation = [[c, s], [-s, c]];
        // U = R^T F, symmetric; its logarithm by principal stretches.
        let u = [c * f[0][0] - s * f[1][0], s * f[0][1] + c * f[1][1], c * f[0][1] - s * f[1][1]];
        let (mean, half) = (0.5 * (u[0] + u[1]), 0.5 * (u[0] - u[1]));
        let radius = half.hypot(u[2]);
        // ln(mean +- radius) = centre +- spread; spread/radius stays regular where the stretches are equal.
        let centre = 0.5 * (mean * mean - radius * radius).ln();
        let ratio = radius / mean;
        let slope = if ratio < 1e-4 { (1.0 + ratio * ratio / 3.0) / mean } else { ratio.atanh() / radius };
        let strain = [centre + slope * half, centre - slope * half, 0.0, 2.0 * slope * u[2]];
        let inverse = [[f[1][1] / volume, -f[0][1] / volume], [-f[1][0] / volume, f[0][0] / volume]];
        Some(Stretch { strain, rotation, volume, inverse })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stretches_and_rotations_come_apart() {
        let (angle, a, b) = (0.7_f64, 1.3_f64, 0.8_f64);
        let (c, s) = (angle.cos(), angle.sin());
        // U with principal stretches a and b, turned by 0.3; then R.
        let (k, l) = (0.3_f64.cos(), 0.3_f64.sin());
        let u = [[a * k * k + b * l * l, (a - b) * k * l], [(a - b) * k * l, a * l * l + b * k * k]];
        let f = [
            [c * u[0][0] + s * u[1][0], c * u[0][1] + s * u[1][1]],
            [-s * u[0][0] + c * u[1][0], -s * u[0][1] + c * u[1][1]],
        ];
        let found = PlaneStrain::stretch(&[[f[0][0] - 1.0, f[0][1]], [f[1][0], f[1][1] - 1.0]]).expect("a stretch");
        let expected =
            [a.ln() * k * k + b.ln() * l * l, a.ln() * l * l + b.ln() * k * k, 0.0, 2.0 * (a.ln() - b.ln()) * k * l];
        for i in 0..4 {
            assert!((found.strain[i] - expected[i]).abs() < 1e-14, "{found:?} {expected:?}");
        }
        assert!((found.rotation[0][0] - c).abs() < 1e-14 && (found.rotation[0][1] - s).abs() < 1e-14);
        assert!((found.volume - a * b).abs() < 1e-14);
        assert!(PlaneStrain::stretch(&[[-2.0, 0.0], [0.0, 0.0]]).is_none());
        assert!(Column::stretch(&[[-1.0]]).is_none());
        assert!((Column::stretch(&[[-0.2]]).expect("a stretch").strain[0] - 0.8_f64.ln()).abs() < 1e-15);
        // A turned stress does the same work on a turned strain.
        let stress = [1.0, 2.0, 3.0, 0.5];
        let turned = PlaneStrain::tensor(&PlaneStrain::turned(&stress, &found.rotation));
        let (r, t) = (found.rotation, PlaneStrain::tensor(&stress));
        for i in 0..2 {
            for j in 0..2 {
                let by_hand: f64 =
                    (0..2).flat_map(|k| (0..2).map(move |l| (k, l))).map(|(k, l)| r[i][k] * t[k][l] * r[j][l]).sum();
                assert!((by_hand - turned[i][j]).abs() < 1e-14);
            }
        }
    }
}

//! Finite strain: the stretch and the rotation of a deformation gradient.
//!
//! The law sees the logarithmic strain `ln U` in the frame before rotation; its stress is the Cauchy stress there,
//! and turns with R. In one dimension that is `sigma' = M ln J`, whatever the size of a step.

/// Polar decomposition of a deformation gradient, `F = R U`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch<const D: usize> {
    /// Logarithmic strain ln U, xx, yy, zz, xy with engineering shear.
    pub strain: [f64; 4],
    /// R.
    pub rotation: [[f64; D]; D],
    /// det F.
    pub volume: f64,
    /// F^-1.
    pub inverse: [[f64; D]; D],
}

/// The components of strain that may differ from zero: those of a column, whose axis is y, or in plane strain.
#[inline(always)]
pub fn active<const D: usize>() -> std::ops::Range<usize> {
    if D == 1 { 1..2 } else { 0..4 }
}

/// Strain of a displacement `direction` times a function with a gradient (1/m).
#[inline(always)]
pub fn strain_mode<const D: usize>(slope: &[f64; D], direction: &[f64; D]) -> [f64; 4] {
    let (x, y) = (0, D - 1);
    if D == 1 {
        return [0.0, slope[y] * direction[y], 0.0, 0.0];
    }
    [slope[x] * direction[x], slope[y] * direction[y], 0.0, slope[y] * direction[x] + slope[x] * direction[y]]
}

/// The stress as a tensor, Pa.
#[inline(always)]
pub fn tensor<const D: usize>(stress: &[f64; 4]) -> [[f64; D]; D] {
    let mut tensor = [[stress[3]; D]; D];
    tensor[0][0] = stress[0];
    tensor[D - 1][D - 1] = stress[1];
    tensor
}

/// A stress turned by a rotation, Pa.
pub fn turned<const D: usize>(stress: &[f64; 4], rotation: &[[f64; D]; D]) -> [f64; 4] {
    if D == 1 {
        return *stress;
    }
    let (c, s) = (rotation[0][0], rotation[0][D - 1]); // R = [[c, s], [-s, c]]
    let [xx, yy, zz, xy] = *stress;
    [
        c * c * xx + 2.0 * c * s * xy + s * s * yy,
        s * s * xx - 2.0 * c * s * xy + c * c * yy,
        zz,
        c * s * (yy - xx) + (c * c - s * s) * xy,
    ]
}

/// Decomposes `I + gradient`; `None` if it is inverted, det F <= 0.
pub fn stretch<const D: usize>(gradient: &[[f64; D]; D]) -> Option<Stretch<D>> {
    let (x, y) = (0, D - 1);
    if D == 1 {
        let volume = 1.0 + gradient[y][y];
        let strain = [0.0, gradient[y][y].ln_1p(), 0.0, 0.0];
        let (rotation, inverse) = ([[1.0; D]; D], [[1.0 / volume; D]; D]);
        return (volume > 0.0).then_some(Stretch { strain, rotation, volume, inverse });
    }
    let f = [[1.0 + gradient[x][x], gradient[x][y]], [gradient[y][x], 1.0 + gradient[y][y]]];
    let volume = f[0][0] * f[1][1] - f[0][1] * f[1][0];
    if volume.is_nan() || volume <= 0.0 {
        return None;
    }
    // Polar decomposition in the plane: R is the rotation by atan2(F_01 - F_10, F_00 + F_11).
    let (sum, difference) = (f[0][0] + f[1][1], f[0][1] - f[1][0]);
    let norm = sum.hypot(difference);
    let (c, s) = (sum / norm, difference / norm);
    // U = R^T F, symmetric; its logarithm by principal stretches.
    let u = [c * f[0][0] - s * f[1][0], s * f[0][1] + c * f[1][1], c * f[0][1] - s * f[1][1]];
    let (mean, half) = (0.5 * (u[0] + u[1]), 0.5 * (u[0] - u[1]));
    let radius = half.hypot(u[2]);
    // ln(mean +- radius) = centre +- spread; spread/radius stays regular where the stretches are equal.
    let centre = 0.5 * (mean * mean - radius * radius).ln();
    let ratio = radius / mean;
    let slope = if ratio < 1e-4 { (1.0 + ratio * ratio / 3.0) / mean } else { ratio.atanh() / radius };
    let strain = [centre + slope * half, centre - slope * half, 0.0, 2.0 * slope * u[2]];
    let mut rotation = [[c; D]; D];
    (rotation[x][y], rotation[y][x]) = (s, -s);
    let mut inverse = [[f[1][1] / volume; D]; D];
    (inverse[x][y], inverse[y][x], inverse[y][y]) = (-f[0][1] / volume, -f[1][0] / volume, f[0][0] / volume);
    Some(Stretch { strain, rotation, volume, inverse })
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
        let found = stretch::<2>(&[[f[0][0] - 1.0, f[0][1]], [f[1][0], f[1][1] - 1.0]]).expect("a stretch");
        let expected =
            [a.ln() * k * k + b.ln() * l * l, a.ln() * l * l + b.ln() * k * k, 0.0, 2.0 * (a.ln() - b.ln()) * k * l];
        for i in 0..4 {
            assert!((found.strain[i] - expected[i]).abs() < 1e-14, "{found:?} {expected:?}");
        }
        assert!((found.rotation[0][0] - c).abs() < 1e-14 && (found.rotation[0][1] - s).abs() < 1e-14);
        assert!((found.volume - a * b).abs() < 1e-14);
        assert!(stretch::<2>(&[[-2.0, 0.0], [0.0, 0.0]]).is_none());
        assert!(stretch::<1>(&[[-1.0]]).is_none());
        assert!((stretch::<1>(&[[-0.2]]).expect("a stretch").strain[1] - 0.8_f64.ln()).abs() < 1e-15);
        // A turned stress does the same work on a turned strain.
        let stress = [1.0, 2.0, 3.0, 0.5];
        let turned = tensor::<2>(&turned(&stress, &found.rotation));
        let (r, t) = (found.rotation, tensor::<2>(&stress));
        for i in 0..2 {
            for j in 0..2 {
                let by_hand: f64 =
                    (0..2).flat_map(|k| (0..2).map(move |l| (k, l))).map(|(k, l)| r[i][k] * t[k][l] * r[j][l]).sum();
                assert!((by_hand - turned[i][j]).abs() < 1e-14);
            }
        }
    }
}

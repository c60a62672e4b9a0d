//! The consistent tangent: how the stress of the end follows the strain increment.
//!
//! In principal stresses every return is linear, `T = D - D B (A^t D B)^-1 A^t D` with the normals A and the flow
//! directions B of the active planes; out of the principal directions the stress turns with the trial stress, which gives
//! a shear stiffness `G (s_a - s_b)/(t_a - t_b)` from stresses s and trial stresses t (de Souza Neto, Peric and Owen
//! 2008, appendix A.3 and section 8.2.4).

use nalgebra::{Matrix3, SMatrix, Vector3};

use super::principal::Ordered;
use super::returns::Region;
use super::surface::Surface;

impl Surface {
    /// d s_i / d eps_j of ordered principal values in a region, Pa.
    pub fn tangent(&self, region: Region) -> Matrix3<f64> {
        let elastic = Matrix3::from_fn(|i, j| self.soil.lame + if i == j { 2.0 * self.soil.shear } else { 0.0 });
        let [n1, n3] = self.normal;
        let [b1, b3] = self.along;
        let plane = |high: usize, low: usize| {
            let (mut normal, mut along) = (Vector3::zeros(), Vector3::zeros());
            (normal[high], normal[low]) = (n1, -n3);
            (along[high], along[low]) = (b1, b3);
            (normal, along)
        };
        let pulled = |i: usize| (Vector3::ith(i, 1.0), Vector3::ith(i, 1.0));
        match region {
            Region::Elastic => elastic,
            Region::Face => one_plane(&elastic, plane(0, 2)),
            Region::CompressionEdge => two_planes(&elastic, [plane(0, 2), plane(1, 2)]),
            Region::ExtensionEdge => two_planes(&elastic, [plane(0, 2), plane(0, 1)]),
            Region::Tension => one_plane(&elastic, pulled(0)),
            Region::TensionEdge => two_planes(&elastic, [pulled(0), pulled(1)]),
            Region::Seam => two_planes(&elastic, [plane(0, 2), pulled(0)]),
            Region::Apex | Region::TensionCorner | Region::CompressionEnd | Region::ExtensionEnd => Matrix3::zeros(),
        }
    }
}

type Plane = (Vector3<f64>, Vector3<f64>);

fn one_plane(d: &Matrix3<f64>, (normal, along): Plane) -> Matrix3<f64> {
    let push = d * along;
    d - push * (d * normal).transpose() / normal.dot(&push)
}

fn two_planes(d: &Matrix3<f64>, [first, second]: [Plane; 2]) -> Matrix3<f64> {
    // The return to the second plane of a stiffness that the first has already left its part of.
    let left = one_plane(d, first);
    let push = left * second.1;
    left - push * (second.0.transpose() * left) / second.0.dot(&push)
}

impl Ordered {
    /// In components, from principal values that belong to the stress `found` (Pa) of the end.
    pub fn tangent(&self, found: &[f64; 3], principal: &Matrix3<f64>, shear: f64) -> SMatrix<f64, 4, 4> {
        let ([a, b, z], [cos, sin]) = self.places();
        let apart = self.values[a] - self.values[b];
        let turning = if apart > 1e-9 * (self.values[a].abs() + self.values[b].abs()) {
            shear * (found[a] - found[b]) / apart
        } else {
            // Equal trial stresses: what a difference of the two strains would make of them.
            0.25 * (principal[(a, a)] - principal[(a, b)] - principal[(b, a)] + principal[(b, b)])
        };
        let axes = [a, b, z];
        let mut local = SMatrix::<f64, 4, 4>::zeros();
        for i in 0..3 {
            for j in 0..3 {
                local[(i, j)] = principal[(axes[i], axes[j])];
            }
        }
        local[(3, 3)] = turning;
        // Strain along the principal axes from that along x and y, engineering shear; the stress goes the other way.
        let (cc, ss, cs) = (0.5 * (1.0 + cos), 0.5 * (1.0 - cos), 0.5 * sin);
        let into = SMatrix::<f64, 4, 4>::from_row_slice(&[
            cc, ss, 0.0, cs, //
            ss, cc, 0.0, -cs, //
            0.0, 0.0, 1.0, 0.0, //
            -sin, sin, 0.0, cos,
        ]);
        into.transpose() * local * into
    }
}

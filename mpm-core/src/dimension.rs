//! What one dimension and plane strain differ in: stress components, strain, rotation.
//!
//! Within a cell a field is held by the coefficients of the basis phi = (1, xi, eta, xi eta), with xi and eta in
//! [0, 1]; in one dimension only the first two are used. `T` maps nodal values to coefficients, and its transpose
//! maps the moments `sum_p w_p phi(x_p)` of particles to nodes, because N = T^t phi.

use crate::real::Real;

/// A velocity gradient, `gradient[i][j]` = dv_i/dx_j, 1/s.
pub type Gradient<const D: usize, R = f64> = [[R; D]; D];

/// The stress xx, yy, zz, xy of an isotropic pressure of 1 Pa (compression), for the pore water.
pub const PRESSURE: [f64; 4] = [-1.0, -1.0, -1.0, 0.0];

/// A vector in two dimensions; that of a column is vertical, and its places are at x = 0.
#[inline(always)]
pub fn in_two<const D: usize>(v: &[f64; D]) -> [f64; 2] {
    [if D == 2 { v[0] } else { 0.0 }, v[D - 1]]
}

/// Strain increment xx, yy, zz, xy (engineering shear) of a velocity gradient over a time dt. The axis of a column is y.
#[inline(always)]
pub fn strain_increment<const D: usize, R: Real>(gradient: &Gradient<D, R>, dt: f64) -> [R; 4] {
    let none = gradient[0][0].like(0.0);
    if D == 1 {
        return [none, gradient[0][0] * dt, none, none];
    }
    let [x, y] = [0, D - 1];
    [gradient[x][x] * dt, gradient[y][y] * dt, none, (gradient[x][y] + gradient[y][x]) * dt]
}

/// Turns a stress by the spin of a velocity gradient over dt (Jaumann rate).
#[inline(always)]
pub fn rotate<const D: usize, R: Real>(stress: &mut [R; 4], gradient: &Gradient<D, R>, dt: f64) {
    if D == 1 {
        return;
    }
    // sigma += (w sigma - sigma w) dt with w_xy = (dv_x/dy - dv_y/dx)/2.
    let spin = (gradient[0][D - 1] - gradient[D - 1][0]) * 0.5 * dt;
    let [xx, yy, _, xy] = *stress;
    stress[0] += spin * 2.0 * xy;
    stress[1] -= spin * 2.0 * xy;
    stress[3] += spin * (yy - xx);
}

/// Force coefficients of a cell from its stress: `F_k,i = sum_p V sigma_ij dphi_k/dx_j`, N m / m.
///
/// `mean` is `sum V sigma`, `first[d]` is `sum V sigma xi_d`; `inverse_size` is 1/L.
#[inline(always)]
pub fn internal_force<const D: usize, R: Real>(mean: &[R; 4], first: &[[R; 4]; D], inverse_size: f64) -> [[R; D]; 4] {
    let none = [mean[0].like(0.0); D];
    let mut force = [none; 4];
    if D == 1 {
        force[1][0] = mean[1] * inverse_size;
        return force;
    }
    let (x, y) = (0, D - 1);
    let (xx, yy, xy) = (mean[0] * inverse_size, mean[1] * inverse_size, mean[3] * inverse_size);
    (force[1][x], force[1][y]) = (xx, xy);
    (force[2][x], force[2][y]) = (xy, yy);
    force[3][x] = (first[y][0] + first[x][3]) * inverse_size;
    force[3][y] = (first[y][3] + first[x][1]) * inverse_size;
    force
}

/// Mean of the three normal stresses, Pa.
#[inline(always)]
pub fn mean_stress<R: Real>(stress: &[R; 4]) -> R {
    (stress[0] + stress[1] + stress[2]) * (1.0 / 3.0)
}

/// The basis (1, xi, eta, xi eta) at a point of the cell.
#[inline(always)]
pub fn basis<const D: usize, R: Real>(xi: &[R; D]) -> [R; 4] {
    let (one, none) = (xi[0].like(1.0), xi[0].like(0.0));
    if D == 1 { [one, xi[0], none, none] } else { [one, xi[0], xi[1], xi[0] * xi[1]] }
}

/// Shares N times an amount of the corners, for a point of the cell.
///
/// Mass and momentum are gathered with the same share and not through the moments of the basis: a node with a tiny
/// share of a particle would lose the digits of that share, and so its velocity momentum/mass.
#[inline(always)]
pub fn shares<const D: usize, R: Real>(amount: R, xi: &[R; D]) -> [R; 4] {
    let right = amount * xi[0];
    let left = amount - right;
    if D == 1 {
        let none = amount.like(0.0);
        [left, right, none, none]
    } else {
        let (upper_left, upper_right) = (left * xi[D - 1], right * xi[D - 1]);
        [left - upper_left, right - upper_right, upper_left, upper_right]
    }
}

/// Coefficients of the basis from values at the corners of the cell.
#[inline(always)]
pub fn coefficients<const D: usize, const F: usize, R: Real>(nodal: &[[R; F]; 4]) -> [[R; F]; 4] {
    let [a, b, c, d] = nodal;
    let mut k = [[a[0].like(0.0); F]; 4];
    for f in 0..F {
        k[0][f] = a[f];
        k[1][f] = b[f] - a[f];
        if D == 2 {
            k[2][f] = c[f] - a[f];
            k[3][f] = (d[f] - c[f]) - (b[f] - a[f]);
        }
    }
    k
}

/// Shares of the corners of the cell from moments of the basis: the transpose of [`coefficients`].
#[inline(always)]
pub fn to_corners<const D: usize, const F: usize, R: Real>(moments: &[[R; F]; 4]) -> [[R; F]; 4] {
    let [one, xi, eta, both] = moments;
    let mut nodal = [[one[0].like(0.0); F]; 4];
    for f in 0..F {
        if D == 1 {
            nodal[0][f] = one[f] - xi[f];
            nodal[1][f] = xi[f];
        } else {
            nodal[0][f] = (one[f] - xi[f]) - (eta[f] - both[f]);
            nodal[1][f] = xi[f] - both[f];
            nodal[2][f] = eta[f] - both[f];
            nodal[3][f] = both[f];
        }
    }
    nodal
}

/// Value of a field at a point of the cell from its coefficients and the [`basis`] there.
#[inline(always)]
pub fn value<const D: usize, const F: usize, R: Real>(k: &[[R; F]; 4], phi: &[R; 4]) -> [R; F] {
    let mut v = k[0];
    for f in 0..F {
        v[f] += k[1][f] * phi[1];
        if D == 2 {
            v[f] += k[2][f] * phi[2] + k[3][f] * phi[3];
        }
    }
    v
}

/// Gradient of a vector field at a point of the cell from its coefficients.
#[inline(always)]
pub fn gradient<const D: usize, R: Real>(k: &[[R; D]; 4], xi: &[R; D], inverse_size: f64) -> Gradient<D, R> {
    let none = xi[0].like(0.0);
    let mut g = [[none; D]; D];
    for i in 0..D {
        for (j, gij) in g[i].iter_mut().enumerate() {
            let across = if D == 2 { k[3][i] * xi[D - 1 - j] } else { none };
            *gij = (k[1 + j][i] + across) * inverse_size;
        }
    }
    g
}

/// Trace of a gradient: the rate of volume change, 1/s.
#[inline(always)]
pub fn trace<const D: usize, R: Real>(gradient: &Gradient<D, R>) -> R {
    let mut sum = gradient[0][0];
    for d in 1..D {
        sum += gradient[d][d];
    }
    sum
}

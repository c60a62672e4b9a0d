//! The functions of a tensor-product basis at one point.

use super::{Axis, Local};
use crate::real::array_of;

/// Most functions that do not vanish at a point: four along each of two axes, those of cubic B-splines.
pub const MOST: usize = 16;

/// Functions that do not vanish at a point, with their gradients.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stencil<const D: usize> {
    /// How many.
    pub count: usize,
    /// Their numbers, the first axis fastest.
    pub number: [u32; MOST],
    /// Their values.
    pub value: [f64; MOST],
    /// Their gradients, 1/m.
    pub slope: [[f64; D]; MOST],
}

impl<const D: usize> Stencil<D> {
    /// The functions at a point (m).
    pub fn at(axes: &[Axis; D], x: &[f64; D]) -> Self {
        Self::of(axes, &array_of(|d| axes[d].at(x[d])))
    }

    /// Products of the functions along the axes.
    pub fn of(axes: &[Axis; D], local: &[Local; D]) -> Self {
        let mut stencil = Self { count: 1, number: [0; MOST], value: [0.0; MOST], slope: [[0.0; D]; MOST] };
        stencil.value[0] = 1.0;
        stencil.slope[0] = [1.0; D];
        let mut stride = 1;
        for d in 0..D {
            let (support, functions) = (axes[d].support(), axes[d].functions());
            let old = stencil;
            stencil.count = old.count * support;
            for a in 0..support {
                // A function beyond the last has the value zero; its number only has to exist.
                let number = (local[d].first + a).min(functions - 1) * stride;
                for b in 0..old.count {
                    let at = a * old.count + b;
                    stencil.number[at] = old.number[b] + number as u32;
                    stencil.value[at] = old.value[b] * local[d].value[a];
                    for e in 0..D {
                        let factor = if e == d { local[d].slope[a] } else { local[d].value[a] };
                        stencil.slope[at][e] = old.slope[b][e] * factor;
                    }
                }
            }
            stride *= functions;
        }
        stencil
    }

    /// A single function with the value one: the pressure of a cell.
    pub fn single(number: usize) -> Self {
        let mut stencil = Self { count: 1, number: [0; MOST], value: [0.0; MOST], slope: [[0.0; D]; MOST] };
        stencil.number[0] = number as u32;
        stencil.value[0] = 1.0;
        stencil
    }

    /// Value of a field from its coefficients.
    pub fn scalar(&self, field: &[f64]) -> f64 {
        (0..self.count).map(|a| self.value[a] * field[self.number[a] as usize]).sum()
    }

    /// Value of a vector field.
    pub fn vector(&self, field: &[[f64; D]]) -> [f64; D] {
        let mut v = [0.0; D];
        for a in 0..self.count {
            for d in 0..D {
                v[d] += self.value[a] * field[self.number[a] as usize][d];
            }
        }
        v
    }

    /// Gradient of a scalar field, per m.
    pub fn slope_of(&self, field: &[f64]) -> [f64; D] {
        let mut g = [0.0; D];
        for a in 0..self.count {
            for d in 0..D {
                g[d] += self.slope[a][d] * field[self.number[a] as usize];
            }
        }
        g
    }

    /// Gradient of a vector field, `gradient[i][j]` = du_i/dx_j.
    #[inline]
    pub fn gradient(&self, field: &[[f64; D]]) -> [[f64; D]; D] {
        self.gradient_with(&self.slope, field)
    }

    /// The same with other gradients (1/m) of the functions.
    #[inline]
    pub fn gradient_with(&self, slope: &[[f64; D]; MOST], field: &[[f64; D]]) -> [[f64; D]; D] {
        let mut g = [[0.0; D]; D];
        for (number, slope) in self.number.iter().zip(slope).take(self.count) {
            let u = &field[*number as usize];
            for i in 0..D {
                for j in 0..D {
                    g[i][j] += u[i] * slope[j];
                }
            }
        }
        g
    }
}

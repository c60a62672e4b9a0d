//! Constitutive laws of the skeleton, one per file. A law turns a strain increment into an effective stress.

mod linear_elastic;

pub use linear_elastic::LinearElastic;
use nalgebra::SMatrix;

/// A law with S stress components.
pub trait Law<const S: usize>: Copy + Send + Sync + 'static {
    /// Adds the effect of a strain increment to a stress (Pa, tension positive).
    fn update(&self, stress: &mut [f64; S], strain: &[f64; S]);
    /// Whether the stress is a linear function of the strain: implicit steps then need no iteration.
    const LINEAR: bool;
    /// Tangent stiffness at the end of a strain increment from a stress, Pa.
    fn tangent(&self, stress: &[f64; S], strain: &[f64; S]) -> SMatrix<f64, S, S>;
    /// Elastic energy stored per volume at a stress, J/m3.
    fn energy(&self, stress: &[f64; S]) -> f64;
}

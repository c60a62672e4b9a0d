//! Exact solutions, one per file, each with its assumptions and its own tests against independent tables.
//!
//! Consolidation: [`mod@column`] (all of it in one dimension, to 1e-6), in closed form [`terzaghi`], [`layered`], [`large_strain`], [`mandel`], [`radial`], [`strip`], [`dynamic`], [`damped_column`]; on a mesh: [`semidiscrete`]. Seepage with
//! a free surface: [`wetting_front`], [`dam`], [`boussinesq`]. Stability: [`infinite_slope`], [`limit_equilibrium`], [`bearing`], [`earth_pressure`]; sliding: [`sliding`], [`slab`].
//! Plasticity: [`oedometer`]. What they are computed with: [`root`], [`simplex`], [`quadrature`], [`elliptic`], [`laplace`].

pub mod bar;
pub mod bearing;
pub mod boussinesq;
pub mod cam_clay;
pub mod column;
pub mod coupled_field;
pub mod dam;
pub mod damped_column;
pub mod dynamic;
pub mod earth_pressure;
pub mod elliptic;
pub mod infinite_slope;
pub mod laplace;
pub mod large_strain;
pub mod layered;
pub mod limit_equilibrium;
pub mod mandel;
pub mod oedometer;
pub(crate) mod oracle;
pub mod pressed_pores;
pub mod quadrature;
pub mod radial;
pub mod richards;
pub mod root;
pub mod seabed;
pub mod self_weight;
pub mod semidiscrete;
pub mod settlement;
pub mod simplex;
pub mod slab;
pub mod sliding;
pub mod strip;
pub mod terzaghi;
pub mod undrained_wave;
pub mod vortex;
pub mod wells;
pub mod wetting_front;

#[cfg(test)]
mod undrained_wave_test;

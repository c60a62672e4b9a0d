//! Exact solutions, one per file, each with its assumptions and its own tests against independent tables.

pub mod dynamic;
pub mod large_strain;
pub mod mandel;
pub mod semidiscrete;
pub mod terzaghi;

#[cfg(test)]
mod oracle;
#[cfg(test)]
mod undrained_wave_test;

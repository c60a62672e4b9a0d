//! The equation of motion on the nodes of a strip, so many nodes at once.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use crate::real::{Real, SimdReal};
use crate::step::store::StripSums;
use crate::step::store::nodes::{MIXTURE_MASS, MOMENTUM, SOLID_MASS, force};

/// Mixture momentum on the nodes of one strip: rho a_s = div(sigma') - grad p + rho g; new nodal velocities.
pub struct EquationOfMotion<'a, const D: usize> {
    /// Runs of nodes that have soil, in whole vectors.
    pub runs: &'a [Range<usize>],
    /// Sums of the nodes.
    pub sums: &'a StripSums,
    /// Their velocity at the end of the step, m/s.
    pub velocity: [&'a mut [f64]; 2],
    /// What a particle adds to its velocity, m/s.
    pub change: [&'a mut [f64]; 2],
    /// Their acceleration, m/s2.
    pub acceleration: [&'a mut [f64]; 2],
    /// Gravity, m/s2, where the scene has it.
    pub gravity: Option<[f64; D]>,
    /// FLIP share of the velocity update.
    pub flip: f64,
    /// Time step, s.
    pub dt: f64,
}

impl<const D: usize> WithSimd for EquationOfMotion<'_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<V: Simd>(self, simd: V) {
        let Self { runs, sums, velocity, change, acceleration, gravity, flip, dt } = self;
        let none = SimdReal::splat(simd, 0.0);
        let one = none.like(1.0);
        for run in runs {
            let mut node = run.start;
            while node < run.end {
                let solid = SimdReal::load(simd, &sums.0[SOLID_MASS][node..]);
                let mixture = SimdReal::load(simd, &sums.0[MIXTURE_MASS][node..]);
                let with_mass = none.below(solid);
                let of_solid = (one / solid.or(with_mass, one)).or(with_mass, none);
                let of_mixture = (one / mixture.or(with_mass, one)).or(with_mass, none);
                for d in 0..D {
                    let mut force = SimdReal::load(simd, &sums.0[force(D) + d][node..]);
                    if let Some(gravity) = gravity {
                        force += mixture * gravity[d];
                    }
                    let a = force * of_mixture;
                    let v = SimdReal::load(simd, &sums.0[MOMENTUM + d][node..]) * of_solid + a * dt;
                    v.store(&mut velocity[d][node..]);
                    (a * (flip * dt) + v * (1.0 - flip)).store(&mut change[d][node..]);
                    a.store(&mut acceleration[d][node..]);
                }
                node += V::F64_LANES;
            }
        }
    }
}

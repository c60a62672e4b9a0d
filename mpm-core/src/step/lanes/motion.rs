//! The equation of motion on the nodes of a strip, so many nodes at once.

use pulp::{Simd, WithSimd};

use super::strip::{FORCE, MIXTURE_MASS, MOMENTUM, SOLID_MASS, SUMS, Tail};
use crate::real::{Lanes, Real};

/// Mixture momentum on the nodes of one strip: rho a_s = div(sigma') - grad p + rho g; new nodal velocities.
pub struct EquationOfMotion<'a, V: Simd> {
    /// Leave to use the machine's instructions.
    pub simd: V,
    /// Sums of the nodes, before what the strip below has given.
    pub sums: &'a mut [Vec<f64>; SUMS],
    /// What the strip below has given.
    pub below: Option<&'a Tail>,
    /// Their velocity at the end of the step, m/s.
    pub velocity: [&'a mut [f64]; 2],
    /// What a particle adds to its velocity, m/s.
    pub change: [&'a mut [f64]; 2],
    /// Their acceleration, m/s2.
    pub acceleration: [&'a mut [f64]; 2],
    /// Gravity, m/s2, where the scene has it.
    pub gravity: Option<[f64; 2]>,
    /// FLIP share of the velocity update.
    pub flip: f64,
    /// Time step, s.
    pub dt: f64,
}

impl<V: Simd> WithSimd for EquationOfMotion<'_, V> {
    type Output = ();

    #[inline(always)]
    fn with_simd<T: Simd>(self, _: T) {
        let Self { simd, sums, below, velocity, change, acceleration, gravity, flip, dt } = self;
        for (into, from) in sums.iter_mut().zip(below.into_iter().flatten()) {
            for (sum, more) in into.iter_mut().zip(from) {
                *sum += more;
            }
        }
        let none = Lanes::splat(simd, 0.0);
        let one = none.like(1.0);
        for node in (0..velocity[0].len()).step_by(V::F64_LANES) {
            let sum = |q: usize| Lanes::load(simd, &sums[q][node..]);
            let (solid, mixture) = (sum(SOLID_MASS), sum(MIXTURE_MASS));
            let with_mass = none.below(solid);
            let of_solid = (one / solid.or(with_mass, one)).or(with_mass, none);
            let of_mixture = (one / mixture.or(with_mass, one)).or(with_mass, none);
            for d in 0..2 {
                let mut force = sum(FORCE + d);
                if let Some(gravity) = gravity {
                    force += mixture * gravity[d];
                }
                let a = force * of_mixture;
                let v = sum(MOMENTUM + d) * of_solid + a * dt;
                v.store(&mut velocity[d][node..]);
                (a * (flip * dt) + v * (1.0 - flip)).store(&mut change[d][node..]);
                a.store(&mut acceleration[d][node..]);
            }
        }
    }
}

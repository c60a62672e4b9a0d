//! A rigid slab that slides on a tilted base with adhesion, under a normal stress that grows, with friction that lags behind it.
//!
//! Assumptions: a slab without ends, of a mass m per area; friction `c + tan(phi) s` with the stress `s` that the base remembers,
//! `ds/dt = (sigma - s)/tau`, `s = sigma` at first; the effective normal stress `sigma = sigma_0 + r t` from weight, buoyancy
//! and a load that grows by q per time, of which the soil bears `M/(M + Q)` undrained. It slides all the time. With `g_x` along
//! the base
//!
//! `v = v_0 + (g_x - c/m) t - tan(phi)/m int s`, `int s = sigma_0 t + r (t^2/2 - tau t + tau^2 (1 - exp(-t/tau)))`.

use mpm_core::scene::Scene;

/// A slab and its base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slab {
    /// Gravity along the base, m/s2.
    pub gravity: f64,
    /// Mass per area of the base, kg/m2.
    pub mass: f64,
    /// First velocity, m/s.
    pub velocity: f64,
    /// tan(phi).
    pub friction: f64,
    /// c, Pa.
    pub adhesion: f64,
    /// sigma_0, Pa.
    pub first: f64,
    /// r, Pa/s.
    pub rate: f64,
    /// tau, s; 0 for none.
    pub memory: f64,
}

impl Slab {
    /// The slab of a scene while its load grows; its water reaches its surface. `None` without gravity or a base that keeps its
    /// strength.
    pub fn new(scene: &Scene) -> Option<Self> {
        let ([along, normal], base) = (scene.gravity_vector()?, scene.base?);
        if base.slip_distance.is_some() {
            return None;
        }
        let growing = scene.surcharge.map_or(0.0, |load| load.pressure / load.ramp_time);
        let lifted = scene.water.map_or(0.0, |water| water.density);
        Some(Self {
            gravity: along,
            mass: scene.mixture_density() * scene.height,
            velocity: scene.start_velocity.map_or(0.0, |v| v[0]),
            friction: base.peak_angle.to_radians().tan(),
            adhesion: base.adhesion,
            first: -normal * (scene.mixture_density() - lifted) * scene.height,
            rate: growing * (1.0 - scene.undrained_share()),
            memory: base.memory,
        })
    }

    /// Its velocity at a time (s), m/s.
    pub fn speed(&self, time: f64) -> f64 {
        let tau = self.memory;
        let late = if tau > 0.0 { -tau * time - tau * tau * (-time / tau).exp_m1() } else { 0.0 };
        let remembered = self.first * time + self.rate * (0.5 * time * time + late);
        self.velocity + (self.gravity - self.adhesion / self.mass) * time - self.friction / self.mass * remembered
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_solves_the_equation_of_motion() {
        for memory in [0.0, 0.02, 0.3] {
            let slab = Slab {
                gravity: 3.4,
                mass: 700.0,
                velocity: 1.0,
                friction: 0.3,
                adhesion: 250.0,
                first: 6e3,
                rate: 2e4,
                memory,
            };
            let (steps, end) = (400_000, 0.4);
            let dt = end / f64::from(steps);
            let (mut v, mut s) = (slab.velocity, slab.first);
            for step in 0..steps {
                let sigma = slab.first + slab.rate * dt * (f64::from(step) + 0.5);
                let before = s;
                s = if memory > 0.0 { s + dt / memory * (sigma - s) } else { sigma };
                let middle = if memory > 0.0 { 0.5 * (before + s) } else { sigma };
                v += dt * (slab.gravity - (slab.adhesion + slab.friction * middle) / slab.mass);
            }
            assert!((slab.speed(end) / v - 1.0).abs() < 1e-5, "{memory}: {} {v}", slab.speed(end));
        }
    }
}

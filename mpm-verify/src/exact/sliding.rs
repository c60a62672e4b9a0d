//! A rigid block on an inclined base with Coulomb friction that may weaken with slip.
//!
//! Assumptions: rigid block, no rotation, motion in one direction from x = 0 at t = 0, friction
//! `mu(x) = mu_p - (mu_p - mu_r) min(x/d, 1)` on the normal force m g cos b, so that `x'' = g sin b - mu(x) g cos b`.
//! Over 0 <= x <= d that is `x'' = A + B x` with `A = g (sin b - mu_p cos b)` and `B = g cos b (mu_p - mu_r)/d >= 0`:
//! `x = A/B (cosh(w t) - 1) + v_0/w sinh(w t)`, w = sqrt(B); a parabola where B = 0 and beyond d.

use mpm_core::scene::Scene;

/// A block and its base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sliding {
    /// Gravity along and normal to the base, m/s2.
    pub gravity: [f64; 2],
    /// First velocity, m/s; 0 or more.
    pub velocity: f64,
    /// tan of the friction angle before slip and after [`Self::distance`].
    pub friction: [f64; 2],
    /// Slip over which the friction falls, m; zero if it does not.
    pub distance: f64,
}

impl Sliding {
    /// The block of a scene; `None` without gravity or without friction on the base.
    pub fn new(scene: &Scene) -> Option<Self> {
        let ([along, normal], base) = (scene.gravity_vector()?, scene.base?);
        Some(Self {
            gravity: [along, -normal],
            velocity: scene.start_velocity.map_or(0.0, |v| v[0]),
            friction: [base.peak_angle, base.residual_angle].map(|angle| angle.to_radians().tan()),
            distance: base.slip_distance.unwrap_or(0.0),
        })
    }

    /// How far the block has come after a time (s), m.
    pub fn distance(&self, time: f64) -> f64 {
        let [peak, residual] = self.friction.map(|mu| self.gravity[0] - mu * self.gravity[1]);
        if self.distance == 0.0 || peak == residual {
            return parabola(self.velocity, peak, time);
        }
        let rate = ((residual - peak) / self.distance).sqrt();
        let place = |t: f64| {
            // 2 sinh^2 keeps the digits of cosh - 1.
            let half = (0.5 * rate * t).sinh();
            peak / (rate * rate) * 2.0 * half * half + self.velocity / rate * (rate * t).sinh()
        };
        let speed = |t: f64| peak / rate * (rate * t).sinh() + self.velocity * (rate * t).cosh();
        let stands = peak <= 0.0 && self.velocity == 0.0;
        // A block that starts too slowly to get over the peak comes to rest where its speed is zero.
        let turns = (-self.velocity * rate / peak).atanh() / rate;
        if stands {
            return 0.0;
        }
        if peak < 0.0 && turns.is_finite() && place(turns) <= self.distance {
            return place(time.min(turns));
        }
        let (mut low, mut high) = (0.0, 1.0 / rate);
        while place(high) < self.distance {
            high *= 2.0;
        }
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if place(middle) < self.distance { low = middle } else { high = middle }
        }
        if time <= low { place(time) } else { self.distance + parabola(speed(low), residual, time - low) }
    }
}

/// Distance (m) from a velocity (m/s) under an acceleration (m/s2) after a time (s); a block that has stopped stays.
fn parabola(velocity: f64, acceleration: f64, time: f64) -> f64 {
    let time = if acceleration < 0.0 { time.min(-velocity / acceleration) } else { time };
    time * (velocity + 0.5 * acceleration * time)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The equation of motion by the midpoint rule.
    fn integrated(block: &Sliding, time: f64) -> f64 {
        let steps = 200_000;
        let dt = time / f64::from(steps);
        let force = |x: f64| {
            let weak = if block.distance > 0.0 { (x / block.distance).min(1.0) } else { 0.0 };
            let mu = block.friction[0] - (block.friction[0] - block.friction[1]) * weak;
            block.gravity[0] - mu * block.gravity[1]
        };
        let (mut x, mut v) = (0.0, block.velocity);
        for _ in 0..steps {
            let half = x + 0.5 * dt * v;
            let next = v + dt * force(half);
            if next <= 0.0 {
                break;
            }
            (x, v) = (x + 0.5 * dt * (v + next), next);
        }
        x
    }

    #[test]
    fn it_solves_the_equation_of_motion() {
        let block = |velocity, friction, distance| Sliding { gravity: [4.1, 8.9], velocity, friction, distance };
        for (case, time) in [
            (block(0.0, [0.3, 0.3], 0.0), 0.5),
            (block(1.0, [0.7, 0.7], 0.0), 2.0),
            (block(0.0, [0.36, 0.15], 0.05), 0.1),
            (block(0.0, [0.36, 0.15], 0.05), 0.6),
            (block(0.4, [0.6, 0.15], 0.05), 0.6),
            (block(0.1, [0.6, 0.15], 0.05), 0.6),
            (block(0.0, [0.6, 0.15], 0.05), 0.6),
        ] {
            let (exact, numeric) = (case.distance(time), integrated(&case, time));
            assert!((exact - numeric).abs() <= 2e-5 * exact.abs(), "{case:?}: {exact} {numeric}");
        }
    }
}

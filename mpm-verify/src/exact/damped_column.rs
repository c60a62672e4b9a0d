//! A closed column that settles against a strong damping: its water bears nearly all of the load, and does not drain.
//!
//! Assumptions: small strain, linear elastic skeleton, water that does not move against it, mass-proportional damping c; a load q
//! at t = 0 on a column at rest. `rho (u'' + c u') = (M + Q) d2u/dz2` with the rate of the wave j, `w = (j - 1/2) pi/H
//! sqrt((M + Q)/rho)`, has the modes `exp(a t)`, `exp(b t)` with `a, b = -c/2 (1 -+ sqrt(1 - 4 w^2/c^2))`:
//!
//! `S = q H/(M + Q) (1 - sum 8/((2j - 1)^2 pi^2) Re[(a exp(b t) - b exp(a t))/(a - b)])`.

use std::f64::consts::PI;

use mpm_core::scene::Scene;

/// A closed column with damping.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DampedColumn {
    /// Last settlement q H/(M + Q), m.
    pub whole: f64,
    /// Lowest frequency without damping, 1/s.
    pub frequency: f64,
    /// c, 1/s.
    pub damping: f64,
}

/// Waves that are summed: what is left of their sum is below 1e-9 of the settlement.
const WAVES: i32 = 2000;

impl DampedColumn {
    /// The column of a scene under a sudden load; `None` without one.
    pub fn new(scene: &Scene) -> Option<Self> {
        let load = scene.surcharge?;
        let stiffness = scene.oedometer_modulus() + scene.pore_stiffness();
        let speed = (stiffness / scene.mixture_density()).sqrt();
        Some(Self {
            whole: load.pressure * scene.height / stiffness,
            frequency: 0.5 * PI * speed / scene.height,
            damping: scene.stages.last()?.damping,
        })
    }

    /// Time (s) in which the slowest wave falls to 1/e, nearly.
    pub fn slowness(&self) -> f64 {
        self.damping / (self.frequency * self.frequency)
    }

    /// Settlement at a time (s), m.
    pub fn settlement(&self, time: f64) -> f64 {
        let left = |j: i32| {
            let odd = f64::from(2 * j - 1);
            8.0 / (odd * PI).powi(2) * swing(odd * self.frequency, self.damping, time)
        };
        self.whole * (1.0 - (1..=WAVES).map(left).sum::<f64>())
    }
}

/// What is left at a time (s) of a wave of a frequency w (1/s) with a damping c (1/s) that was let go at 1.
fn swing(frequency: f64, damping: f64, time: f64) -> f64 {
    let half = 0.5 * damping;
    let square = half * half - frequency * frequency;
    if square > 0.0 {
        // a b = w^2: no difference of large numbers.
        let (slow, fast) = (-frequency * frequency / (half + square.sqrt()), -(half + square.sqrt()));
        return (slow * (fast * time).exp() - fast * (slow * time).exp()) / (slow - fast);
    }
    let own = (-square).sqrt();
    let sine = if own > 0.0 { (own * time).sin() / own } else { time };
    (-half * time).exp() * ((own * time).cos() + half * sine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_begins_at_rest_and_ends_under_the_load() {
        let column = DampedColumn { whole: 1.0, frequency: 3.0, damping: 150.0 };
        assert!(
            column.settlement(0.0).abs() < 2e-4 && (column.settlement(30.0 * column.slowness()) - 1.0).abs() < 1e-9
        );
        // Nearly a diffusion: Terzaghi's series at T = 0.1.
        let time = 0.1 * PI * PI / 4.0 * column.slowness();
        let waves = (0..200).map(|j| (f64::from(j) + 0.5) * PI);
        let series: f64 = waves.map(|m| 2.0 / (m * m) * (-m * m * 0.1).exp()).sum();
        assert!(
            (column.settlement(time) - (1.0 - series)).abs() < 2e-3,
            "{} {}",
            column.settlement(time),
            1.0 - series
        );
    }

    #[test]
    fn every_wave_solves_its_equation_of_motion() {
        for (frequency, damping) in [(1.0, 30.0), (2.0, 0.5), (1.0, 2.5), (1.0, 2.0)] {
            assert_eq!(swing(frequency, damping, 0.0), 1.0);
            let h = 1e-4;
            for time in [h, 0.7, 2.0] {
                let [before, here, after] = [time - h, time, time + h].map(|t| swing(frequency, damping, t));
                let (speed, change) = ((after - before) / (2.0 * h), (after - 2.0 * here + before) / (h * h));
                let off = change + damping * speed + frequency * frequency * here;
                assert!(off.abs() < 1e-5 * (1.0 + damping * damping), "{frequency} {damping} {time}: {off}");
            }
        }
    }
}

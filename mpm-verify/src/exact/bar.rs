//! A dry column under a load and its weight, with inertia and damping, from no stress: its modes.
//!
//! Assumptions: linear elastic, small strain, one dimension, a rigid base and a free top, damping in proportion to the mass. The mode
//! of wave number k_j = (2 j - 1) pi/(2 H) swings with w = k_j sqrt(M/rho) about its static share of the settlement, `8/((2 j - 1)^2 pi^2)`
//! of q H/M and `32 sin(k_j H)/((2 j - 1)^3 pi^3)` of rho g H^2/(2 M): from rest `1 + (r_2 e^(r_1 t) - r_1 e^(r_2 t))/(r_1 - r_2)` of it,
//! r = -a/2 +- sqrt(a^2/4 - w^2). A load that grows is the mean of this over its ramp.
//!
//! Source: Graff, *Wave Motion in Elastic Solids*, 1975, section 2.4; damping: Clough & Penzien, *Dynamics of Structures*, chapter 3.

use std::f64::consts::PI;

use mpm_core::scene::{Scene, Start};
use nalgebra::Complex;

/// Modes kept; those left out hold 1e-4 of a step's settlement in its kinks and 1e-8 of its mean.
const MODES: u32 = 2000;

/// A swinging column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bar {
    height: f64,
    /// sqrt(M/rho), m/s.
    pub speed: f64,
    damping: f64,
    ramp: f64,
    /// Static settlement under the load and under the weight, m.
    settled: [f64; 2],
}

impl Bar {
    /// The column of a scene; `None` for one that is wet, in layers, moves in two dimensions or starts with stresses.
    pub fn new(scene: &Scene) -> Option<Self> {
        let [stage] = scene.stages.as_slice() else { return None };
        let plain = scene.water.is_none() && scene.layers.is_empty() && scene.start == Start::Unloaded;
        if !plain || !scene.is_plain_column() {
            return None;
        }
        let (modulus, density, height) = (scene.oedometer_modulus(), scene.mixture_density(), scene.height);
        let load = scene.surcharge.map_or(0.0, |s| s.pressure) * height / modulus;
        let weight = 0.5 * density * scene.gravity.unwrap_or(0.0) * height * height / modulus;
        let ramp = scene.surcharge.map_or(0.0, |s| s.ramp_time);
        Some(Self { height, speed: (modulus / density).sqrt(), damping: stage.damping, ramp, settled: [load, weight] })
    }

    /// How fast the slowest mode dies out, 1/s; zero without damping.
    pub fn decay(&self) -> f64 {
        let wave = 0.5 * PI / self.height * self.speed;
        let rest = 0.25 * self.damping * self.damping - wave * wave;
        0.5 * self.damping - rest.max(0.0).sqrt()
    }

    /// Settlement of the surface at a time (s), m.
    pub fn settlement(&self, time: f64) -> f64 {
        let mode = |j: u32| {
            let number = f64::from(2 * j + 1);
            let wave = 0.5 * number * PI / self.height * self.speed;
            let sign = if j.is_multiple_of(2) { 1.0 } else { -1.0 };
            let [load, weight] = [8.0 / (number * PI).powi(2), sign * 32.0 / (number * PI).powi(3)];
            let grown = match self.ramp > 0.0 {
                true => (self.swung(wave, time, true) - self.swung(wave, time - self.ramp, true)) / self.ramp,
                false => self.swung(wave, time, false),
            };
            load * self.settled[0] * grown + weight * self.settled[1] * self.swung(wave, time, false)
        };
        (0..MODES).rev().map(mode).sum()
    }

    /// A mode's share of its static displacement, or its time integral.
    fn swung(&self, wave: f64, time: f64, integral: bool) -> f64 {
        if time <= 0.0 {
            return 0.0;
        }
        let half = Complex::from(0.5 * self.damping);
        // Critical damping has a double root; a hair beside it differs by nothing.
        let root = Complex::from(0.25 * self.damping * self.damping - wave * wave * (1.0 + 1e-9)).sqrt();
        let (one, two) = (root - half, -root - half);
        let of = |own: Complex<f64>, other: Complex<f64>| match integral {
            true => other / own * ((own * time).exp() - 1.0),
            false => other * (own * time).exp(),
        };
        let still = if integral { time } else { 1.0 };
        still + ((of(one, two) - of(two, one)) / (one - two)).re
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mpm_core::scene::Surcharge;

    fn scene() -> Scene {
        crate::scenes::built_in("dry-bar")
            .expect("the built-in scene")
            .edited(|scene| scene.stages[0].damping = 0.0)
            .expect("a sound scene")
    }

    #[test]
    fn a_step_moves_the_top_as_d_alembert_says() {
        let bar = Bar::new(&scene()).expect("a bar");
        let passage = bar.height / bar.speed;
        for (share, expected) in [(0.5, 0.5), (1.0, 1.0), (1.7, 1.7), (2.6, 1.4), (3.5, 0.5), (4.5, 0.5)] {
            let found = bar.settlement(share * passage) / bar.settled[0];
            assert!((found - expected).abs() < 2e-4, "{share}: {found}");
        }
    }

    #[test]
    fn damped_it_comes_to_rest_under_load_and_weight() {
        let scene = scene()
            .edited(|scene| {
                (scene.stages[0].damping, scene.gravity) = (460.0, Some(9.81));
                scene.surcharge = scene.surcharge.map(|s| Surcharge { ramp_time: 3e-3, ..s });
            })
            .expect("a sound scene");
        let bar = Bar::new(&scene).expect("a bar");
        let still = bar.settled[0] + bar.settled[1];
        let late = 20.0 / bar.decay();
        assert!((bar.settlement(late) / still - 1.0).abs() < 2e-4 && bar.settlement(1e-3) < 0.5 * still);
        assert!(bar.settled[1] > 0.05 * still && Bar { damping: 0.0, ..bar }.decay() == 0.0);
    }
}

//! A strip of load on an undrained block between rollers, on a smooth base: pore pressure as a sum of cosines.
//!
//! Assumptions: plane strain, small strain, linear elastic skeleton, water of stiffness Q = K_w/n that does not flow, no weight.
//! Sides and base are rollers, so that a load `q sum f_j cos(k x)`, k = j pi/W, has an Airy function even in y:
//! `k^2 (C cosh(k y) + D k y sinh(k y)) cos(k x)`. No shear on the top at H gives `C = -D (1 + k H coth(k H))`, the load
//! `D k^2 = -q f_j sinh(k H)/(sinh(k H) cosh(k H) + k H)`. With `sigma_x + sigma_y = 2 (lambda_u + G) div u` and `p = -Q div u`
//!
//! `p = Q/(lambda_u + G) q f_j sinh(k H) cosh(k y)/(sinh(k H) cosh(k H) + k H) cos(k x)`, and `f_0 q Q/(M + Q)` of the mean.

use std::f64::consts::PI;

use mpm_core::scene::{LoadedStrip, Scene};

/// The block under its strip.
#[derive(Debug, Clone, PartialEq)]
pub struct StripLoad {
    width: f64,
    height: f64,
    /// f_j q, Pa.
    load: Vec<f64>,
    /// Q/(M + Q) and Q/(lambda_u + G).
    share: [f64; 2],
}

/// Waves that are summed; they fall with the third power of their number, and exponentially below the top.
const WAVES: usize = 400;
/// Points at which the load is looked at: an even number of intervals between them.
const POINTS: usize = 20_000;

impl StripLoad {
    /// The block of a scene; `None` without water or a strip.
    pub fn new(scene: &Scene) -> Option<Self> {
        let (load, _) = (scene.surcharge?, scene.water?);
        let strip = load.strip?;
        let stiffness = scene.pore_stiffness();
        let (lame, shear) = (scene.elastic.lame() + stiffness, scene.elastic.shear_modulus());
        let wave = |j: usize| load.pressure * coefficient(&strip, scene.width, j);
        Some(Self {
            width: scene.width,
            height: scene.height,
            load: (0..=WAVES).map(wave).collect(),
            share: [scene.undrained_share(), stiffness / (lame + shear)],
        })
    }

    /// The same load on a dry elastic block: mean stress, `(1 + nu)(sigma_x + sigma_y)/3`, in place of the pore pressure.
    /// `sigma_x + sigma_y` is twice the load times the same ratio, whatever the stiffness. `None` with water or without a strip.
    pub fn dry(scene: &Scene) -> Option<Self> {
        let load = scene.surcharge.filter(|_| scene.water.is_none())?;
        let strip = load.strip?;
        let (poisson, lateral) = (scene.elastic.poisson_ratio, scene.elastic.lame() / scene.oedometer_modulus());
        let wave = |j: usize| load.pressure * coefficient(&strip, scene.width, j);
        Some(Self {
            width: scene.width,
            height: scene.height,
            load: (0..=WAVES).map(wave).collect(),
            share: [(1.0 + poisson) / 3.0 * (1.0 + lateral), 2.0 * (1.0 + poisson) / 3.0],
        })
    }

    /// Pore pressure at a place (m), Pa.
    pub fn pressure(&self, x: f64, y: f64) -> f64 {
        let wave = |(j, load): (usize, &f64)| {
            let k = j as f64 * PI / self.width;
            let (top, here) = (k * self.height, k * y);
            // sinh(a) cosh(b)/(sinh(a) cosh(a) + a), divided by exp(2 a).
            let small = (-2.0 * top).exp();
            let below = (here - top).exp() * (1.0 - small) * (1.0 + (-2.0 * here).exp());
            let ratio = below / ((1.0 - small) * (1.0 + small) + 4.0 * top * small);
            self.share[1] * load * ratio * (k * x).cos()
        };
        let waves: f64 = self.load.iter().enumerate().skip(1).map(wave).sum();
        self.share[0] * self.load[0] + waves
    }
}

/// f_j of a strip on a block of a width (m), by Simpson's rule.
fn coefficient(strip: &LoadedStrip, width: f64, j: usize) -> f64 {
    let value = |i: usize| {
        let x = width * i as f64 / POINTS as f64;
        let weight = if i == 0 || i == POINTS { 1.0 } else { 2.0 * (1 + i % 2) as f64 };
        weight * strip.share(x) * (j as f64 * PI * x / width).cos()
    };
    let mean = (0..=POINTS).map(value).sum::<f64>() / (3.0 * POINTS as f64);
    if j == 0 { mean } else { 2.0 * mean }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wide_strip_and_a_deep_block_have_the_pressures_that_they_must() {
        let mut scene = crate::scenes::built_in("strip").expect("it holds");
        let load = scene.surcharge.expect("a load").pressure;
        // All over the top: one dimension.
        scene = scene
            .edited(|scene| {
                if let Some(surcharge) = &mut scene.surcharge {
                    surcharge.strip = Some(LoadedStrip { from: 0.0, to: 1.0, taper: 0.0 });
                }
            })
            .expect("a sound scene");
        let whole = StripLoad::new(&scene).expect("a strip");
        for (x, y) in [(0.1, 0.2), (0.9, 0.7)] {
            assert!((whole.pressure(x, y) / (load * scene.undrained_share()) - 1.0).abs() < 1e-9);
        }
        // Soil without end under a strip from -a to a, incompressible: q/pi times the angle that it is seen under.
        scene = scene.altered_unchecked(|scene| {
            (scene.width, scene.height) = (60.0, 60.0);
            if let Some(surcharge) = &mut scene.surcharge {
                surcharge.strip = Some(LoadedStrip { from: 0.0, to: 1.0, taper: 0.0 });
            }
            if let Some(water) = &mut scene.water {
                water.bulk_modulus = 2.2e13;
            }
        });
        let strip = StripLoad::new(&scene).expect("a strip");
        for (x, depth) in [(0.0, 1.0), (1.0, 2.0), (2.0, 1.0)] {
            let angle = ((x + 1.0_f64) / depth).atan() - ((x - 1.0) / depth).atan();
            let found = strip.pressure(x, scene.height - depth) / load;
            // The rollers far away leave the mean of the load.
            assert!((found - angle / PI).abs() < 1.5 / 60.0, "{x} {depth}: {found} {}", angle / PI);
        }
        // Dry soil without end (Boussinesq, Michell): sigma_x + sigma_y = 2 q/pi times that angle.
        scene = scene.altered_unchecked(|scene| scene.water = None);
        let strip = StripLoad::dry(&scene).expect("a strip");
        let share = 2.0 * (1.0 + scene.elastic.poisson_ratio) / 3.0;
        for (x, depth) in [(0.0, 1.0), (1.0, 2.0), (2.0, 1.0)] {
            let angle = ((x + 1.0_f64) / depth).atan() - ((x - 1.0) / depth).atan();
            let found = strip.pressure(x, scene.height - depth) / load;
            assert!((found - share * angle / PI).abs() < 1.5 / 60.0, "{x} {depth}: {found} {}", share * angle / PI);
        }
    }
}

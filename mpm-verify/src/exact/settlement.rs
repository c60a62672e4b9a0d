//! Settlement of an elastic layer on a smooth base under a flexible strip or a flexible disc of load, between rollers.
//!
//! A load `q_k cos(k x)`, about an axis `q_k J_0(k r)`, on a layer of height H settles it by `c(k)` times itself,
//!
//! ```text
//! c(k) = 2 (1 - nu^2)/(E k) sinh^2(kH)/(sinh(kH) cosh(kH) + kH),    c(0) = H/M
//! ```
//!
//! as shear on the base and on the rollers is zero; without end, c = 2 (1 - nu^2)/(E k), and a disc of radius a settles by
//! `2 (1 - nu^2) q a/E` in its middle, by 2/pi of that at its edge (Boussinesq 1885; Poulos & Davis, *Elastic Solutions for Soil and
//! Rock Mechanics*, 1974, section 3.3.1). Rollers at R choose the k: sin(kR) = 0, or J_1(kR) = 0.
//!
//! Assumptions: plane strain or a section about an axis, small strain, one linear elastic soil, dry or drained, no weight.

use std::f64::consts::PI;

use libm::{j0, j1};
use mpm_core::scene::{Dimension, Scene};

/// Waves that are summed.
const WAVES: usize = 400;
/// Points at which the load is looked at: an even number of intervals between them.
const POINTS: usize = 20_000;

/// The settled layer.
#[derive(Debug, Clone, PartialEq)]
pub struct Settlement {
    width: f64,
    about_axis: bool,
    /// k (1/m), amplitude of the load (Pa), settlement over load (m/Pa) and mean square of each wave.
    waves: Vec<[f64; 4]>,
}

impl Settlement {
    /// The layer of a dry scene; `None` with water, without a strip, or about an axis that it does not reach.
    pub fn of(scene: &Scene) -> Option<Self> {
        let load = scene.surcharge.filter(|_| scene.water.is_none() && scene.inner_radius == 0.0)?;
        let strip = load.strip?;
        let about_axis = scene.dimension == Dimension::Axisymmetric;
        let (width, height, poisson) = (scene.width, scene.height, scene.elastic.poisson_ratio);
        let wave = |j: usize| {
            let k = if about_axis { zero_of_j1(j) } else { j as f64 * PI } / width;
            let mean_square = match (j, about_axis) {
                (0, _) => 1.0,
                (_, true) => j0(k * width).powi(2),
                (_, false) => 0.5,
            };
            let measure = |x: f64| if about_axis { 2.0 * x / width } else { 1.0 };
            let value = |i: usize| {
                let x = width * i as f64 / POINTS as f64;
                let weight = if i == 0 || i == POINTS { 1.0 } else { 2.0 * (1 + i % 2) as f64 };
                weight * strip.share(x) * shape(about_axis, k * x) * measure(x)
            };
            let mean = (0..=POINTS).map(value).sum::<f64>() / (3.0 * POINTS as f64);
            let compliance = if j == 0 {
                height / scene.oedometer_modulus()
            } else {
                // sinh^2 a/(sinh a cosh a + a), divided by exp(2 a).
                let (a, small) = (k * height, (-2.0 * k * height).exp());
                let ratio = (1.0 - small).powi(2) / ((1.0 - small) * (1.0 + small) + 4.0 * a * small);
                2.0 * (1.0 - poisson * poisson) / (scene.elastic.youngs_modulus * k) * ratio
            };
            [k, load.pressure * mean / mean_square, compliance, mean_square]
        };
        Some(Self { width, about_axis, waves: (0..=WAVES).map(wave).collect() })
    }

    /// Settlement of the surface at a place (m), m.
    pub fn at(&self, x: f64) -> f64 {
        self.waves.iter().map(|[k, load, compliance, _]| load * compliance * shape(self.about_axis, k * x)).sum()
    }

    /// What the layer stores (Clapeyron), J for 1 m, about an axis for a radian: half of the load times the settlement under it.
    pub fn energy(&self) -> f64 {
        let area = if self.about_axis { 0.5 * self.width * self.width } else { self.width };
        let of_wave = |[_, load, compliance, square]: &[f64; 4]| load * load * compliance * square;
        0.5 * area * self.waves.iter().map(of_wave).sum::<f64>()
    }
}

fn shape(about_axis: bool, phase: f64) -> f64 {
    if about_axis { j0(phase) } else { phase.cos() }
}

/// The zero of J_1 with a number, 0 the first: Newton's method from its asymptotic place.
fn zero_of_j1(number: usize) -> f64 {
    if number == 0 {
        return 0.0;
    }
    let mut x = (number as f64 + 0.25) * PI;
    for _ in 0..6 {
        x -= j1(x) / (j0(x) - j1(x) / x);
    }
    x
}

#[cfg(test)]
mod tests {
    use mpm_core::scene::LoadedStrip;

    use super::*;

    /// A layer so wide and deep that the load, from 0 to 1 m, does not feel its ends.
    fn without_end(dimension: Dimension, [width, height]: [f64; 2]) -> (Settlement, f64) {
        let scene = crate::scenes::built_in("strip-on-sand").expect("it holds").altered_unchecked(|scene| {
            (scene.width, scene.height, scene.dimension) = (width, height, dimension);
            if let Some(surcharge) = &mut scene.surcharge {
                surcharge.strip = Some(LoadedStrip { from: 0.0, to: 1.0, taper: 0.0 });
            }
        });
        let load = scene.surcharge.expect("a load").pressure;
        let unit = (1.0 - scene.elastic.poisson_ratio.powi(2)) * load / scene.elastic.youngs_modulus;
        (Settlement::of(&scene).expect("a layer"), unit)
    }

    #[test]
    fn a_disc_settles_as_boussinesq_found() {
        let (layer, unit) = without_end(Dimension::Axisymmetric, [25.0, 50.0]);
        // On average under the load by 16/(3 pi): half of q pi a^2/(2 pi) times that is stored.
        let found = [layer.at(0.0), layer.at(1.0), layer.energy() / (0.25 * 1e4)].map(|settled| settled / unit);
        let known = [2.0, 4.0 / PI, 16.0 / (3.0 * PI)];
        // The ends take about a/H of all three alike, so that the differences are nearer; the middle lacks waves.
        let off: Vec<f64> = found.iter().zip(known).map(|(found, known)| found - known).collect();
        assert!(off.iter().all(|off| off.abs() < 0.03), "{found:?} {known:?}");
        assert!((off[2] - off[1]).abs() < 1e-3 && (off[0] - off[1]).abs() < 5e-3, "{found:?} {known:?}");
    }

    #[test]
    fn a_strip_settles_more_in_its_middle() {
        let (layer, unit) = without_end(Dimension::PlaneStrain, [100.0; 2]);
        // -2 (1 - nu^2) q/(pi E) times the integral of ln|x - s| over the strip from -1 to 1.
        let primitive = |x: f64| if x == 0.0 { 0.0 } else { x * x.abs().ln() - x };
        let settled = |x: f64| -2.0 / PI * (primitive(1.0 + x) + primitive(1.0 - x));
        for x in [1.0, 2.0, 3.0] {
            let (found, known) = ((layer.at(0.0) - layer.at(x)) / unit, settled(0.0) - settled(x));
            assert!((found - known).abs() < 0.01 * known, "{x}: {found} {known}");
        }
    }
}

//! Flow in unsaturated soil whose conductivity and content fall exponentially with suction (Gardner's soil): Richards' equation is linear
//! in the relative conductivity `K = exp(-alpha s)`.
//!
//! - A column over a water table, steady (Gardner 1958, doi:10.1097/00010694-195804000-00006): `K = A + (1 - A) exp(-alpha z)`.
//! - The same after a sudden change of the rain (Srivastava & Yeh 1991, doi:10.1029/90WR02772, equation 13).
//! - A box whose top is wet in its middle (Tracy 2006, doi:10.1029/2005WR004638): no flow through its sides.
//!
//! Heads are continuous in pressure; soil at rest, one conductivity, no hysteresis.

use std::f64::consts::{PI, TAU};

use super::root::root;

/// Terms of the series: they fall as exp(-lambda^2 t), and from a sudden change on no sooner.
const TERMS: usize = 400;

/// A column on which rain changes; the suction at its base does not.
#[derive(Debug, Clone)]
pub struct Infiltration {
    /// Sorptive number alpha, 1/m.
    pub alpha: f64,
    /// Height, m.
    pub height: f64,
    /// Hydraulic conductivity k of full soil, m/s.
    pub conductivity: f64,
    /// Pore space that fills, n (1 - S_r).
    pub fillable: f64,
    /// Rain before and after the change, m/s.
    pub rain: [f64; 2],
    /// Relative conductivity at the base: 1 at a water table.
    pub at_base: f64,
    /// Zeros of tan(lambda L) + 2 lambda, with L = alpha height.
    zeros: Vec<f64>,
}

impl Infiltration {
    /// A column over a water table; see the fields for the units.
    pub fn new(alpha: f64, height: f64, conductivity: f64, fillable: f64, rain: [f64; 2]) -> Self {
        let length = alpha * height;
        let zero = |k: usize| {
            // One in each interval in which the tangent is negative.
            let (low, high) = ((k as f64 - 0.5) * PI / length, k as f64 * PI / length);
            root(|x| (x * length).sin() + 2.0 * x * (x * length).cos(), low, high)
        };
        let zeros = (1..=TERMS).filter_map(zero).collect();
        Self { alpha, height, conductivity, fillable, rain, at_base: 1.0, zeros }
    }

    /// The same with a suction head (m) at its base.
    pub fn above_suction(self, suction: f64) -> Self {
        Self { at_base: (-self.alpha * suction).exp(), ..self }
    }

    /// Relative conductivity, and effective saturation, at a height (m) and a time (s) after the change.
    pub fn at(&self, height: f64, time: f64) -> f64 {
        let [before, after] = self.rain.map(|rain| rain / self.conductivity);
        let (length, z) = (self.alpha * self.height, self.alpha * height);
        let t = self.alpha * self.conductivity / self.fillable * time;
        let term = |x: &f64| {
            (x * z).sin() * (x * length).sin() * (-x * x * t).exp() / (1.0 + 0.5 * length + 2.0 * x * x * length)
        };
        let sum: f64 = self.zeros.iter().map(term).sum();
        steady(self.at_base, after, z) - 4.0 * (after - before) * (0.5 * (length - z) - 0.25 * t).exp() * sum
    }
}

/// Steady relative conductivity at alpha z above a base, of a flow q/k downwards.
fn steady(at_base: f64, flow: f64, z: f64) -> f64 {
    flow + (at_base - flow) * (-z).exp()
}

/// Relative conductivity of a steady column at a height (m), of which that at the top is given; the base is at a water table.
pub fn between(alpha: f64, height: f64, at_top: f64, z: f64) -> f64 {
    let down = (-alpha * height).exp();
    steady(1.0, (at_top - down) / (1.0 - down), alpha * z)
}

/// A box of dry soil whose top is wetted from t = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WettedBox {
    /// Sorptive number alpha, 1/m.
    pub alpha: f64,
    /// Width and height, m.
    pub size: [f64; 2],
    /// Hydraulic conductivity k of full soil, m/s.
    pub conductivity: f64,
    /// Pore space that fills, n (1 - S_r).
    pub fillable: f64,
    /// Suction head of the dry soil, m.
    pub suction: f64,
}

impl WettedBox {
    /// Suction head on the top at a place x (m), m: none in its middle, that of the dry soil at its ends.
    pub fn top(&self, x: f64) -> f64 {
        let dry = (-self.alpha * self.suction).exp();
        -(dry + 0.5 * (1.0 - dry) * (1.0 - (TAU * x / self.size[0]).cos())).ln() / self.alpha
    }

    /// Relative conductivity, and effective saturation, at a place (m) and a time (s).
    pub fn at(&self, [x, z]: [f64; 2], time: f64) -> f64 {
        let ([width, height], dry) = (self.size, (-self.alpha * self.suction).exp());
        let storage = self.alpha * self.fillable / self.conductivity;
        let mode = |wave: f64| {
            let square = 0.25 * self.alpha * self.alpha + wave * wave;
            let beta = square.sqrt();
            let term = |k: usize| {
                let lambda = k as f64 * PI / height;
                let rate = (square + lambda * lambda) / storage;
                let sign = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
                sign * lambda / rate * (lambda * z).sin() * (-rate * time).exp()
            };
            let transient: f64 = (1..TERMS).map(term).sum();
            (beta * z).sinh() / (beta * height).sinh() + 2.0 / (height * storage) * transient
        };
        let wave = TAU / width;
        let modes = mode(0.0) - (wave * x).cos() * mode(wave);
        dry + 0.5 * (1.0 - dry) * (0.5 * self.alpha * (height - z)).exp() * modes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column() -> Infiltration {
        Infiltration::new(10.0, 1.0, 1.0 / 3.6e5, 0.34, [0.1 / 3.6e5, 0.9 / 3.6e5])
    }

    /// Richards' equation in K: `alpha n_f/k K_t = K_xx + K_zz + alpha K_z`.
    fn residual(k: impl Fn([f64; 2], f64) -> f64, alpha: f64, storage: f64, [x, z]: [f64; 2], t: f64) -> f64 {
        let (d, dt) = (1e-3, 1e-3 * t);
        let here = k([x, z], t);
        let by_t = (k([x, z], t + dt) - k([x, z], t - dt)) / (2.0 * dt);
        let [left, right, low, high] = [[x - d, z], [x + d, z], [x, z - d], [x, z + d]].map(|place| k(place, t));
        let laplace = (left + right + low + high - 4.0 * here) / (d * d);
        storage * by_t - laplace - alpha * (high - low) / (2.0 * d)
    }

    #[test]
    fn columns_satisfy_their_equation_and_their_ends() {
        let column = column();
        for (z, t) in [(0.3, 1.8e4), (0.7, 3.6e4), (0.9, 7.2e4)] {
            let found = residual(|[_, z], t| column.at(z, t), 10.0, 10.0 * 0.34 * 3.6e5, [0.0, z], t);
            assert!(found.abs() < 1e-3, "{z} {t}: {found}");
        }
        assert!((column.at(0.0, 1e4) - 1.0).abs() < 1e-12);
        // Rain through the top: K + K_z/alpha = q/k.
        let d = 1e-5;
        let flow = column.at(1.0, 3e4) + (column.at(1.0, 3e4) - column.at(1.0 - d, 3e4)) / d / 10.0;
        assert!((flow - 0.9).abs() < 1e-3, "{flow}");
        // From the steady flow before to that after.
        assert!((column.at(0.5, 3e3) - steady(1.0, 0.1, 5.0)).abs() < 1e-3);
        let dry = column.clone().above_suction(0.2);
        assert!((dry.at(0.0, 1e4) - (-2.0_f64).exp()).abs() < 1e-12);
        assert!((column.at(0.5, 1e7) - between(10.0, 1.0, column.at(1.0, 1e7), 0.5)).abs() < 1e-12);
    }

    #[test]
    fn boxes_satisfy_their_equation_and_their_sides() {
        let soil = WettedBox { alpha: 4.0, size: [1.0, 0.8], conductivity: 1e-5, fillable: 0.3, suction: 1.0 };
        for (x, z, t) in [(0.3, 0.4, 5e3), (0.6, 0.2, 2e4), (0.8, 0.7, 4e3)] {
            let found = residual(|place, t| soil.at(place, t), 4.0, 4.0 * 0.3 / 1e-5, [x, z], t);
            assert!(found.abs() < 1e-3, "{x} {z} {t}: {found}");
        }
        let dry = (-4.0_f64).exp();
        for x in [0.0, 0.2, 0.5] {
            let top = (-4.0 * soil.top(x)).exp();
            assert!((soil.at([x, 0.8], 1e3) - top).abs() < 1e-12 && (soil.at([x, 0.0], 1e3) - dry).abs() < 1e-12);
            assert!((soil.at([x, 0.5], 100.0) - dry).abs() < 1e-6, "dry at first");
        }
    }
}

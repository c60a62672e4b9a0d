//! Wells in a confined layer: Theis (1935, *Trans. Am. Geophys. Union* 16), and his solution in one dimension (Carslaw & Jaeger,
//! *Conduction of Heat in Solids*, 1959, sections 2.9 and 10.4).
//!
//! Displacements that have no rotation, `u = grad phi`, feel the constrained modulus: `(lambda + 2G) e = p - C(t)` with the change
//! of volume e and, of soil that nothing holds far away, C = 0. The water balance is then a diffusion,
//!
//! ```text
//! S dp/dt = kappa lap p - q delta,        S = 1/M + n/K_w,  kappa = k/gamma_w,  c = kappa/S
//! line:   p = -q/(2 kappa) [ 2 sqrt(ct/pi) exp(-x^2/4ct) - |x| erfc(|x|/2 sqrt(ct)) ]        q per area
//! point:  p = -q/(4 pi kappa) E_1(r^2/4ct)                                                  q per metre
//! ```
//!
//! Walls with rollers and without flow are mirrors of both fields. Between four of them the volume of the soil stays, so that its water
//! alone stores what is taken on average: the mean pressure falls by `q t K_w/(n V)`, not by `q t/(S V)`, and the difference is C(t).
//! Where soil conducts better along its bedding than across, `r^2/c` becomes `S x^T K^-1 x` and kappa the root of det K/gamma_w^2; such
//! walls mirror no flow, so that they must be out of its reach. They still hold the soil: `M e = p - C(t)` needs no mirror.
//!
//! Assumptions: small strain, linear elastic soil, no inertia, no weight; one well of constant rate; the line, ends out of its reach.

use std::f64::consts::PI;

use libm::erfc;
use mpm_core::scene::{Course, Dimension, Scene, SolidSide};

/// A well in a scene.
#[derive(Debug, Clone, Copy)]
pub struct Confined {
    at: [f64; 2],
    /// What it takes, m3/s per metre; in a column per area, m/s.
    rate: f64,
    /// kappa, m4/(N s), S, 1/Pa, c = kappa/S, m2/s.
    mobility: f64,
    storage: f64,
    diffusivity: f64,
    /// kappa over the mobility along and across the bedding, and its direction; `None` where both are the same.
    bedding: Option<([f64; 2], [f64; 2])>,
    /// n/K_w, 1/Pa.
    of_water: f64,
    /// Width and height of the soil, m; `None` for a column.
    walls: Option<[f64; 2]>,
}

impl Confined {
    /// The one well of a scene, whose soil fills a column or a box between rollers; `None` for all else.
    pub fn of(scene: &Scene) -> Option<Self> {
        let (water, [well]) = (scene.water?, &scene.wells[..]) else { return None };
        let loaded = scene.surcharge.is_some() || !scene.loads.is_empty() || !scene.plates.is_empty();
        let plain =
            !scene.has_several_soils() && scene.is_elastic() && scene.outline.is_none() && !water.fabric.kozeny_carman;
        if loaded || !plain || scene.gravity.is_some() || well.course != Course::Constant {
            return None;
        }
        let closed = scene.solid_sides == [SolidSide::Roller; 4] && scene.empty_cells_above == 0;
        let walls = match scene.dimension {
            Dimension::Column => None,
            Dimension::PlaneStrain if closed => Some([scene.width, scene.height]),
            _ => return None,
        };
        let (along, storage) = (water.anisotropy.sqrt(), scene.storage());
        let mobility = water.mobility() * if walls.is_some() { along } else { 1.0 };
        let (sin, cos) = water.fabric.bedding_angle.to_radians().sin_cos();
        Some(Self {
            at: well.at,
            rate: if walls.is_some() { well.rate } else { well.rate / scene.width },
            mobility,
            storage,
            diffusivity: mobility / storage,
            bedding: (walls.is_some() && along != 1.0).then_some(([1.0 / along, along], [cos, sin])),
            of_water: 1.0 / scene.pore_stiffness(),
            walls,
        })
    }

    /// Pore pressure at a place (m) and a time (s) since the pump was started, Pa.
    pub fn pressure(&self, place: [f64; 2], time: f64) -> f64 {
        let ct = self.diffusivity * time;
        let Some([width, height]) = self.walls else {
            let x = (place[1] - self.at[1]).abs();
            let (root, decay) = (ct.sqrt(), (-x * x / (4.0 * ct)).exp());
            return -self.rate / (2.0 * self.mobility) * (2.0 * root / PI.sqrt() * decay - x * erfc(0.5 * x / root));
        };
        // Images at 2 i W +- x, as far as they reach.
        let images = |length: f64, at: f64| {
            let reach = (0.5 * (ct * 4.0 * 40.0).sqrt() / length).ceil() as i32 + 1;
            (-reach..=reach).flat_map(move |i| [2.0 * f64::from(i) * length + at, 2.0 * f64::from(i) * length - at])
        };
        let mut sum = 0.0;
        if self.bedding.is_some() {
            sum = exponential_integral(self.square([place[0] - self.at[0], place[1] - self.at[1]]) / (4.0 * ct));
        } else {
            for x in images(width, self.at[0]) {
                for y in images(height, self.at[1]) {
                    sum += exponential_integral(self.square([place[0] - x, place[1] - y]) / (4.0 * ct));
                }
            }
        }
        let per_volume = self.rate * time / (width * height);
        per_volume * (1.0 / self.storage - 1.0 / self.of_water) - self.rate / (4.0 * PI * self.mobility) * sum
    }

    /// Square of a distance, m2, in isotropic soil of the same kappa.
    fn square(&self, [x, y]: [f64; 2]) -> f64 {
        let Some(([along, across], [cos, sin])) = self.bedding else { return x * x + y * y };
        along * (cos * x + sin * y).powi(2) + across * (cos * y - sin * x).powi(2)
    }

    /// Its drawdown at a distance (m) and a time (s) if nothing else were there, Pa.
    pub fn drawdown(&self, distance: f64, time: f64) -> f64 {
        let alone = Self { at: [0.0; 2], walls: None, ..*self };
        match self.walls {
            None => -alone.pressure([0.0, distance], time),
            Some(_) => {
                let u = distance * distance / (4.0 * self.diffusivity * time);
                self.rate / (4.0 * PI * self.mobility) * exponential_integral(u)
            }
        }
    }
}

/// E_1(u), u > 0: its series (Abramowitz & Stegun 5.1.11), from 1 on the continued fraction 5.1.22, both to round-off.
pub fn exponential_integral(u: f64) -> f64 {
    const EULER: f64 = 0.577_215_664_901_532_9;
    if u > 700.0 {
        return 0.0;
    }
    if u <= 1.0 {
        let (mut term, mut sum) = (1.0, -EULER - u.ln());
        for n in 1..40 {
            term *= -u / f64::from(n);
            sum -= term / f64::from(n);
        }
        return sum;
    }
    // Lentz, from below: exp(-u)/(u + 1 - 1/(u + 3 - 4/(u + 5 - ...))).
    let fraction = (1..200).rev().fold(0.0, |tail: f64, n| {
        let n = f64::from(n);
        n * n / (u + 2.0 * n + 1.0 - tail)
    });
    (-u).exp() / (u + 1.0 - fraction)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::built_in;

    /// Abramowitz & Stegun, table 5.1.
    #[test]
    fn exponential_integral_is_that_of_the_tables() {
        for (u, exact) in
            [(0.01, 4.037_929_576_5), (0.5, 0.559_773_594_8), (1.0, 0.219_383_934_4), (2.0, 0.048_900_510_7)]
        {
            assert!((exponential_integral(u) / exact - 1.0).abs() < 1e-9, "{u}");
        }
        assert!((exponential_integral(1.0 + 1e-12) / exponential_integral(1.0) - 1.0).abs() < 1e-11);
    }

    #[test]
    fn what_is_stored_is_what_was_taken() {
        let line = Confined::of(&built_in("well-line").expect("a scene")).expect("a well");
        let cells: i32 = 20_000;
        let h = 2.0 / f64::from(cells);
        let sum: f64 = (0..cells).map(|i| line.pressure([0.5, (f64::from(i) + 0.5) * h], 10.0)).sum();
        assert!((-sum * h * line.storage / (line.rate * 10.0) - 1.0).abs() < 1e-6);
        let well = Confined::of(&built_in("well").expect("a scene")).expect("a well");
        let cells: i32 = 100;
        let h = 2.0 / f64::from(cells);
        let middle = |i: i32| (f64::from(i) + 0.5) * h;
        let row = |j: i32| (0..cells).map(|i| well.pressure([middle(i), middle(j)], 2.0)).sum::<f64>();
        let mean = (0..cells).map(row).sum::<f64>() / f64::from(cells * cells);
        assert!((-mean * 4.0 * well.of_water / (well.rate * 2.0) - 1.0).abs() < 1e-3, "{mean}");
    }
}

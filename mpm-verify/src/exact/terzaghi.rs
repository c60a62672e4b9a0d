//! One-dimensional consolidation: Terzaghi's series, for incompressible and for compressible water.
//!
//! Assumptions: small strain, linear elastic skeleton, incompressible grains, Darcy's law, no inertia, no gravity;
//! a load q at t = 0 or growing linearly over a ramp; p = 0 at the drained ends, no flow at the others.
//!
//! With Z the depth from the drained top over the drainage path and T = c t/H_d^2,
//! `p/p_0 = sum 2/m sin(m Z) exp(-m^2 T)`, `U = 1 - sum 2/m^2 exp(-m^2 T)`, m = (2j+1) pi/2. Below T = 0.15 the
//! series of images (error functions) converges faster. Incompressible: c = c_v = k M/gamma_w, p_0 = q.
//! Compressible: c = (k/gamma_w)/(1/M + n/K_w), p_0 = q Q/(M + Q), and (q - p_0) H/M settles at once.
//!
//! Sources: Terzaghi 1943; Carslaw & Jaeger, *Conduction of Heat in Solids*, 1959, section 3.3; ramp: Olson 1977,
//! J. Geotech. Eng. Div. 103(1); Verruijt, *Theory and Problems of Poroelasticity*, 2013, chapter 2.

use std::f64::consts::{FRAC_PI_2, PI};

use libm::erfc;
use mpm_core::scene::{Course, LoadOn, Piece, Scene, Side, Surcharge, WaterProperties};

/// Time factor at which the two forms change over; both are exact to round-off there.
const IMAGES_BELOW: f64 = 0.15;

/// A consolidating column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terzaghi {
    /// Height H, m.
    pub height: f64,
    /// Drainage path H_d, m.
    pub path: f64,
    /// Whether both ends drain.
    pub double: bool,
    /// Coefficient of consolidation c, m2/s.
    pub coefficient: f64,
    /// Oedometer modulus M, Pa.
    pub modulus: f64,
    /// Load q, Pa.
    pub load: f64,
    /// Undrained pore pressure p_0 under the full load, Pa.
    pub undrained: f64,
    /// Time over which the load grows, s; zero for a step.
    pub ramp: f64,
    /// Biot's coefficient: share of the pore pressure in the total stress.
    pub alpha: f64,
}

impl Terzaghi {
    /// Terzaghi's own assumption: water that does not compress. `None` for a scene that is dry, unloaded, in layers
    /// or moves in two dimensions.
    pub fn incompressible(scene: &Scene) -> Option<Self> {
        let (water, load) = one_dimensional(scene)?;
        let modulus = scene.oedometer_modulus();
        let coefficient = water.mobility() * modulus;
        Some(Self::of(scene, coefficient, load.pressure, load.pressure, load.ramp_time))
    }

    /// The same column with the water's own stiffness. `None` as above.
    pub fn compressible(scene: &Scene) -> Option<Self> {
        let (water, load) = one_dimensional(scene)?;
        let (coefficient, alpha) = (water.mobility() / scene.storage(), scene.soil().alpha());
        let column = Self::of(scene, coefficient, load.pressure, scene.undrained_pressure(), load.ramp_time);
        Some(Self { alpha, ..column })
    }

    /// A column under one load on its top, as it is where its factor is 1, and the factors in time. `None` for all else.
    pub fn under_one_load(scene: &Scene) -> Option<(Self, Vec<[f64; 2]>)> {
        let [load] = &scene.loads[..] else { return None };
        let factors = match &load.course {
            Course::Constant => vec![[0.0, 1.0]],
            Course::Ramp(end) => vec![[0.0, 0.0], [*end, 1.0]],
            Course::Times(times) => times.clone(),
            Course::Sine { .. } | Course::Wave { .. } => return None,
        };
        let pressure = -load.force(&Piece { middle: [0.0; 2], outward: [0.0, 1.0] })[1];
        if load.on != Some(Side::Top) || load.is_water() || scene.surcharge.is_some() {
            return None;
        }
        let surcharge = Surcharge { pressure, ramp_time: 0.0, on: LoadOn::Surface, strip: None };
        let plain = scene.edited(|s| (s.surcharge, s.loads) = (Some(surcharge), Vec::new())).ok()?;
        Some((Self::compressible(&plain)?, factors))
    }

    fn of(scene: &Scene, coefficient: f64, load: f64, undrained: f64, ramp: f64) -> Self {
        let drained = scene.stages[scene.stages.len() - 1].drained;
        Self {
            height: scene.height,
            path: scene.drainage_path(),
            double: drained[Side::Bottom as usize] && drained[Side::Top as usize],
            coefficient,
            modulus: scene.oedometer_modulus(),
            load,
            undrained,
            ramp,
            alpha: 1.0,
        }
    }

    /// Time factor c t/H_d^2.
    pub fn time_factor(&self, time: f64) -> f64 {
        self.coefficient * time / (self.path * self.path)
    }

    /// Settlement of the surface from the unloaded state at a time (s), m.
    pub fn settlement(&self, time: f64) -> f64 {
        let whole = self.load * self.height / self.modulus;
        let share = self.alpha * self.undrained / self.load;
        whole * ((1.0 - share) * self.load_share(time) + share * self.degree(time))
    }

    /// Settlement at a time (s) under the load times a factor that is linear between times (s) and constant before and after, from
    /// soil that was in equilibrium: ramps from every corner on, and what jumps there, m.
    pub fn under(&self, factors: &[[f64; 2]], time: f64) -> f64 {
        let whole = self.load * self.height / self.modulus;
        let share = self.alpha * self.undrained / self.load;
        let per_factor = self.path * self.path / self.coefficient;
        let step = |since: f64| {
            if since < 0.0 { 0.0 } else { 1.0 - share + share * degree(self.time_factor(since)) }
        };
        let ramp =
            |since: f64| (1.0 - share) * since.max(0.0) + share * degree_integral(self.time_factor(since)) * per_factor;
        let mut sum = factors.first().map_or(0.0, |[from, factor]| factor * step(time - from));
        for pair in factors.windows(2) {
            let [[from, low], [to, high]] = [pair[0], pair[1]];
            sum += if to > from {
                (high - low) / (to - from) * (ramp(time - from) - ramp(time - to))
            } else {
                (high - low) * step(time - from)
            };
        }
        whole * sum
    }

    /// S/(q H/M): settlement over the final one.
    pub fn relative_settlement(&self, time: f64) -> f64 {
        self.settlement(time) * self.modulus / (self.load * self.height)
    }

    /// Pore pressure at a height above the base (m) and a time (s), Pa.
    pub fn pressure(&self, height: f64, time: f64) -> f64 {
        let depth = (self.height - height) / self.path;
        let depth = if self.double { depth.min(2.0 - depth) } else { depth };
        let t = self.time_factor(time);
        if self.ramp == 0.0 {
            return self.undrained * pressure(depth, t);
        }
        let end = self.time_factor(self.ramp);
        self.undrained * (pressure_integral(depth, t) - pressure_integral(depth, t - end)) / end
    }

    /// Share of the load that acts at a time.
    fn load_share(&self, time: f64) -> f64 {
        if time < self.ramp { time / self.ramp } else { 1.0 }
    }

    /// Pore-pressure part of the degree of consolidation, after Olson for a ramp.
    fn degree(&self, time: f64) -> f64 {
        let t = self.time_factor(time);
        if self.ramp == 0.0 {
            return degree(t);
        }
        let end = self.time_factor(self.ramp);
        (degree_integral(t) - degree_integral(t - end)) / end
    }
}

/// Water and load of a scene that moves in one dimension.
fn one_dimensional(scene: &Scene) -> Option<(WaterProperties, Surcharge)> {
    Some((scene.water?, scene.surcharge?)).filter(|_| scene.is_plain_column() && scene.layers.is_empty())
}

/// Sum of a series over m = (2j+1) pi/2 until its terms no longer count.
fn over_modes(t: f64, term: impl Fn(f64, f64) -> f64) -> f64 {
    let mut sum = 0.0;
    for j in 0..200 {
        let m = f64::from(2 * j + 1) * FRAC_PI_2;
        let decay = (-m * m * t).exp();
        if decay < 1e-18 {
            break;
        }
        sum += term(m, decay);
    }
    sum
}

/// Alternating sum over images until its terms no longer count.
fn over_images(first: i32, term: impl Fn(f64) -> f64) -> f64 {
    (first..40).map(|j| if j % 2 == 0 { term(f64::from(j)) } else { -term(f64::from(j)) }).sum()
}

/// First, second and third repeated integral of erfc (Carslaw & Jaeger, appendix II).
fn repeated_erfc(x: f64) -> [f64; 3] {
    let zero = erfc(x);
    let one = (-x * x).exp() / PI.sqrt() - x * zero;
    let two = 0.25 * (zero - 2.0 * x * one);
    let three = (one - 2.0 * x * two) / 6.0;
    [one, two, three]
}

/// Average degree of consolidation U(T) under a step load.
pub fn degree(t: f64) -> f64 {
    if t <= 0.0 {
        0.0
    } else if t >= IMAGES_BELOW {
        1.0 - over_modes(t, |m, decay| 2.0 / (m * m) * decay)
    } else {
        let root = t.sqrt();
        2.0 * root * (1.0 / PI.sqrt() + 2.0 * over_images(1, |n| repeated_erfc(n / root)[0]))
    }
}

/// p/p_0 at depth Z below the drained end under a step load.
pub fn pressure(depth: f64, t: f64) -> f64 {
    if t <= 0.0 {
        1.0
    } else if t >= IMAGES_BELOW {
        over_modes(t, |m, decay| 2.0 / m * (m * depth).sin() * decay)
    } else {
        let two = 2.0 * t.sqrt();
        1.0 - over_images(0, |j| erfc((2.0 * j + depth) / two) + erfc((2.0 * j + 2.0 - depth) / two))
    }
}

/// Integral of U from 0 to T.
fn degree_integral(t: f64) -> f64 {
    if t <= 0.0 {
        0.0
    } else if t >= IMAGES_BELOW {
        t - 1.0 / 3.0 + over_modes(t, |m, decay| 2.0 / m.powi(4) * decay)
    } else {
        let scale = (4.0 * t).powf(1.5);
        scale * (repeated_erfc(0.0)[2] + 2.0 * over_images(1, |n| repeated_erfc(n / t.sqrt())[2]))
    }
}

/// Integral of p/p_0 from 0 to T.
fn pressure_integral(depth: f64, t: f64) -> f64 {
    if t <= 0.0 {
        0.0
    } else if t >= IMAGES_BELOW {
        depth - 0.5 * depth * depth - over_modes(t, |m, decay| 2.0 / m.powi(3) * (m * depth).sin() * decay)
    } else {
        let two = 2.0 * t.sqrt();
        let second = |x: f64| repeated_erfc(x / two)[1];
        t - 4.0 * t * over_images(0, |j| second(2.0 * j + depth) + second(2.0 * j + 2.0 - depth))
    }
}

#[cfg(test)]
mod tests {
    use super::super::oracle::Table;
    use super::*;

    /// The column of Table 1; `double` drains both ends, `ramp` in s.
    fn column(compressible: bool, double: bool, ramp: f64) -> Terzaghi {
        let (height, load) = (1.0, 1.0e4);
        let modulus = 2.0e7 * 0.7 / (1.3 * 0.4);
        let (mobility, pore) = (5.0e-4 / 9810.0, 2.2e9 / 0.3);
        let (coefficient, undrained) = if compressible {
            (mobility / (1.0 / modulus + 1.0 / pore), load * pore / (modulus + pore))
        } else {
            (mobility * modulus, load)
        };
        let path = if double { 0.5 } else { 1.0 };
        Terzaghi { height, path, double, coefficient, modulus, load, undrained, ramp, alpha: 1.0 }
    }

    fn worst(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn one_ramp_among_corners_is_the_ramp() {
        let (plain, ramp) = (column(true, false, 0.0), column(true, false, 0.2));
        let factors = [[0.0, 0.0], [0.1, 0.5], [0.2, 1.0], [0.9, 1.0]];
        for time in [0.05, 0.15, 0.3, 1.0] {
            assert!((plain.under(&factors, time) / ramp.settlement(time) - 1.0).abs() < 1e-12, "{time} s");
            assert!((plain.under(&[[0.0, 1.0]], time) / plain.settlement(time) - 1.0).abs() < 1e-12, "{time} s");
        }
    }

    #[test]
    fn settlement_matches_the_tables() {
        for (double, part) in [(false, ""), (true, "double_")] {
            for (compressible, name) in [(true, "compressible"), (false, "incompressible")] {
                let table = Table::read(&format!("01_terzaghi_{part}U_{name}.csv"));
                let exact = column(compressible, double, 0.0);
                let rows = table.rows(["Tv", "t_s", "U", "S_over_Sinf"]);
                assert!(rows.len() > 300);
                assert!(worst(rows.iter().map(|r| (degree(r[0]), r[2]))) < 1e-12);
                assert!(worst(rows.iter().map(|r| (exact.relative_settlement(r[1]), r[3]))) < 1e-12);
            }
        }
    }

    #[test]
    fn pressure_matches_the_tables() {
        for (double, part) in [(false, ""), (true, "double_")] {
            for (compressible, name) in [(true, "compressible"), (false, "incompressible")] {
                let table = Table::read(&format!("01_terzaghi_{part}p_{name}.csv"));
                let exact = column(compressible, double, 0.0);
                let rows = table.rows(["t_s", "z_m_from_top", "p_over_p0"]);
                let pairs = rows.iter().map(|r| (exact.pressure(1.0 - r[1], r[0]) / exact.undrained, r[2]));
                assert!(worst(pairs) < 1e-12);
            }
        }
    }

    #[test]
    fn ramp_load_matches_the_tables() {
        for (compressible, name) in [(true, "compressible"), (false, "incompressible")] {
            let table = Table::read(&format!("01_terzaghi_ramp_{name}.csv"));
            let step = column(compressible, false, 0.0);
            let exact = column(compressible, false, 0.2 / step.coefficient);
            let rows = table.rows(["t_s", "S_over_Sinf", "p_base_over_q", "p_mid_over_q"]);
            assert!(worst(rows.iter().map(|r| (exact.relative_settlement(r[0]), r[1]))) < 1e-12);
            assert!(worst(rows.iter().map(|r| (exact.pressure(0.0, r[0]) / exact.load, r[2]))) < 1e-12);
            assert!(worst(rows.iter().map(|r| (exact.pressure(0.5, r[0]) / exact.load, r[3]))) < 1e-12);
        }
    }

    #[test]
    fn both_forms_agree_from_very_early_to_very_late() {
        // The modal series with enough terms, against whichever form is used.
        for t in [1e-6, 1e-4, 1e-2, 0.1, 0.149, 0.151, 1.0, 10.0] {
            let modes: f64 = (0..400_000)
                .rev()
                .map(|j| {
                    let m = f64::from(2 * j + 1) * FRAC_PI_2;
                    2.0 / (m * m) * -(-m * m * t).exp_m1()
                })
                .sum();
            let tail = 2.0 / (PI * PI * 400_000.0); // terms that were left out, all equal to 2/m^2 there
            let tail = if t < 1e-7 { 0.0 } else { tail };
            assert!((degree(t) - modes - tail).abs() < 1e-12, "T = {t}: {} {modes}", degree(t));
        }
    }

    #[test]
    fn the_check_can_fail() {
        let table = Table::read("01_terzaghi_U_compressible.csv");
        let mut wrong = column(true, false, 0.0);
        wrong.coefficient *= 1.0 + 1e-9;
        let rows = table.rows(["t_s", "S_over_Sinf"]);
        assert!(worst(rows.iter().map(|r| (wrong.relative_settlement(r[0]), r[1]))) > 1e-12);
    }
}

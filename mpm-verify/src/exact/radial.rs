//! A ball and a long cylinder of poroelastic soil under a total pressure q on a drained surface: Cryer's sphere (Cryer 1963, *Q. J.
//! Mech. Appl. Math.* 16, 401-412) and De Leeuw's cylinder (De Leeuw 1965; Verruijt 2013, *Theory and Problems of Poroelasticity*,
//! ch. 3). The middle first rises above its undrained pressure: the outside drains and shrinks on it.
//!
//! With d = 1 (cylinder) or 2 (sphere), `e = u' + d u/r` and alpha = 1: `M e = p + f(t)`, so that for Laplace transforms
//!
//! ```text
//! p = f/(M S) [phi(m r)/phi(m R) - 1],   m^2 = S s/kappa,   S = 1/M + n/K_w,   phi(z) = I_0(z) or sinh(z)/z
//! f - 2 d G u(R)/R = -q/s,               u(R)/R = R^-(d+1) int_0^R e r^d dr
//! ```

use nalgebra::Complex;

use super::laplace;
use mpm_core::scene::{Bearing, Course, Scene};

type Number = Complex<f64>;

/// A ball or a cylinder.
#[derive(Debug, Clone, Copy)]
pub struct Radial {
    /// Whether it is a ball.
    pub is_sphere: bool,
    /// R, m.
    pub radius: f64,
    /// M, G, S and kappa: Pa, Pa, 1/Pa, m4/(N s).
    soil: [f64; 4],
    /// q, Pa.
    pub load: f64,
    /// Time that it grows within, s.
    ramp: f64,
}

impl Radial {
    /// That of an axisymmetric scene under one pressure: a block is a cylinder, an outline the quarter of a ball.
    pub fn of(scene: &Scene) -> Option<Self> {
        let (water, [load]) = (scene.water?, &scene.loads[..]) else { return None };
        let Bearing::Traction { pressure, shear: 0.0, water: false } = load.bearing else { return None };
        let ramp = match load.course {
            Course::Constant => 0.0,
            Course::Ramp(time) => time,
            _ => return None,
        };
        if scene.axis() != Some(0.0) || scene.gravity.is_some() {
            return None;
        }
        let soil = [scene.oedometer_modulus(), scene.elastic.shear_modulus(), scene.storage(), water.mobility()];
        let is_sphere = scene.outline.is_some();
        // A polygon is the ball or the cylinder of its volume.
        let radius = if is_sphere { (3.0 * volume(&scene.outline_or_box())).cbrt() } else { scene.width };
        Some(Self { is_sphere, radius, soil, load: pressure, ramp })
    }

    /// Undrained pressure p_0, Pa: the water and the skeleton share the mean stress.
    pub fn undrained(&self) -> f64 {
        let [modulus, shear, storage, _] = self.soil;
        let d = self.dimension();
        // e = -q/(M_u - 2 d G/(d + 1)) with M_u = M + Q, p = -Q e, and S = 1/M + 1/Q
        let pore = 1.0 / (storage - 1.0 / modulus);
        self.load * pore / (modulus + pore - 2.0 * d * shear / (d + 1.0))
    }

    /// `kappa/(S R^2)`, 1/s: T = t times this.
    pub fn rate(&self) -> f64 {
        let [_, _, storage, mobility] = self.soil;
        mobility / (storage * self.radius * self.radius)
    }

    fn dimension(&self) -> f64 {
        if self.is_sphere { 2.0 } else { 1.0 }
    }

    /// Pore pressure at a radius (m) and a time (s), Pa.
    pub fn pressure(&self, radius: f64, time: f64) -> f64 {
        if self.ramp == 0.0 {
            return self.sudden(radius, time)[0];
        }
        let before = if time > self.ramp { self.sudden(radius, time - self.ramp)[1] } else { 0.0 };
        (self.sudden(radius, time)[1] - before) / self.ramp
    }

    /// The same under a load that is all there at once, and its integral over time, Pa s.
    fn sudden(&self, radius: f64, time: f64) -> [f64; 2] {
        let [modulus, shear, storage, mobility] = self.soil;
        let d = self.dimension();
        laplace::at(time, |s| {
            let z = (s * storage / mobility).sqrt() * self.radius;
            let [ratio, mean] = self.shape(z, radius / self.radius);
            let whole = 1.0 / (d + 1.0);
            let strain = (mean - whole) / (modulus * storage) + whole; // M u(R)/(R f)
            let f = -(Number::from(self.load) / s) / (Number::from(1.0) - strain * (2.0 * d * shear / modulus));
            let pressure = f / (modulus * storage) * (ratio - 1.0);
            [pressure, pressure / s]
        })
    }

    /// `phi(z x)/phi(z)` at a share x of the radius, and `int_0^1 phi(z x)/phi(z) x^d dx`.
    fn shape(&self, z: Number, x: f64) -> [Number; 2] {
        if self.is_sphere {
            // sinh and coth by falling exponentials alone
            let (fall, one) = ((-z * 2.0).exp(), Number::from(1.0));
            let coth = (one + fall) / (one - fall);
            let at = if x == 0.0 {
                z * 2.0 * (-z).exp() / (one - fall)
            } else {
                (-z * (1.0 - x)).exp() * (one - (-z * (2.0 * x)).exp()) / (one - fall) / x
            };
            return [at, (z * coth - 1.0) / (z * z)];
        }
        let [i0, i1] = bessel(z);
        [bessel(z * x)[0] / i0 * (z.re * (x - 1.0)).exp(), i1 / (z * i0)]
    }
}

/// Volume of one radian of a section about x = 0 (m), m3.
fn volume(outline: &[[f64; 2]]) -> f64 {
    let of = |([x, y], [next_x, next_y]): (&[f64; 2], &[f64; 2])| (next_y - y) * (x * x + x * next_x + next_x * next_x);
    outline.iter().zip(outline.iter().cycle().skip(1)).map(of).sum::<f64>() / 6.0
}

/// `I_0(z)` and `I_1(z)` times exp(-Re z), Re z >= 0: by their series, or by that of large arguments, where the former would cancel.
fn bessel(z: Number) -> [Number; 2] {
    const LARGE: f64 = 25.0;
    let one = Number::from(1.0);
    if z.norm() > LARGE {
        return [0.0, 1.0].map(|order| {
            let (mut term, mut sum) = (one, one);
            for k in 1..20 {
                let odd = f64::from(2 * k - 1);
                term *= (odd * odd - 4.0 * order * order) / (8.0 * f64::from(k)) / z;
                sum += term;
            }
            sum * Number::new(0.0, z.im).exp() / (z * std::f64::consts::TAU).sqrt()
        });
    }
    let quarter = z * z * 0.25;
    let mut term = Number::from((-z.re).exp());
    let mut sums = [term, term];
    for k in 1..200 {
        let k = f64::from(k);
        term *= quarter / (k * k);
        sums[0] += term;
        sums[1] += term / (k + 1.0);
    }
    [sums[0], sums[1] * z * 0.5]
}

#[cfg(test)]
mod tests {
    use super::super::oracle::Table;
    use super::*;

    #[test]
    fn both_agree_with_independent_tables() {
        for (file, is_sphere, undrained) in [
            ("03_cryer_sphere_compressible.csv", true, 9_977.324_263_038_55),
            ("03_deleeuw_cylinder_compressible.csv", false, 9_973.844_812_554_49),
        ] {
            let (modulus, shear) = (2.0e7 * 0.7 / (1.3 * 0.4), 2.0e7 / 2.6);
            let storage = 1.0 / modulus + 0.3 / 2.2e9;
            let exact = Radial {
                is_sphere,
                radius: 1.0,
                soil: [modulus, shear, storage, 5.0e-4 / 9810.0],
                load: 1e4,
                ramp: 0.0,
            };
            assert!((exact.undrained() / undrained - 1.0).abs() < 1e-12, "{}", exact.undrained());
            for [time, centre, half] in Table::read(file).rows(["t_s", "p_centre_over_p0", "p_halfradius_over_p0"]) {
                for (radius, share) in [(0.0, centre), (0.5, half)] {
                    let off = exact.pressure(radius, time) / undrained - share;
                    assert!(off.abs() < 1e-10, "{file} t = {time} s, r = {radius} m: {off}");
                }
            }
        }
    }
}

//! A disc of elastic soil that turns as a whole while a ring inside it is sheared to and fro: large rotation, large stretch.
//!
//! A generalised vortex (Kamojjala, Brannon, Sadeghirad & Guilkey 2015, Eng. Comput. 31(2), doi:10.1007/s00366-013-0342-x)
//! with the law of this program. A point at the distance R from the middle turns by
//! `alpha(R, t) = A h(R) g(t) + Omega(t)`, h = (1 - s^2)^3 with s = (R - R_0)/w in the ring |s| < 1, else 0,
//! g = (1 - cos(2 pi t/T))/2, Omega = Omega_T (t/T - sin(2 pi t/T)/(2 pi)): all at rest at t = 0 and t = T.
//!
//! Volumes stay. In the frame that turns with the point the motion is simple shear by `gamma = A R h' g`, and under the
//! Jaumann rate of Cauchy stress with the shear modulus G
//! `sigma_rt = G sin gamma, sigma_tt = -sigma_rr = G (1 - cos gamma)`, sigma_zz = 0.
//! (Dienes 1979, Acta Mechanica 32; the stress falls again from gamma = pi/2, so A keeps below that.)
//! What moves the soil so is the body force `b = a - div(sigma)/rho`, with `a_r = -R alpha'^2`, `a_t = R alpha''` and
//! `div_r = d sigma_rr/dR + (sigma_rr - sigma_tt)/R`, `div_t = d sigma_rt/dR + 2 sigma_rt/R`.
//! Outside of the ring there is no stress: the edge of the disc, and how the mesh cuts it, do not matter.

use std::f64::consts::PI;

/// The motion of a disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vortex {
    /// Its middle, m.
    pub middle: [f64; 2],
    /// Middle and half width of the ring, R_0 and w, m.
    pub ring: [f64; 2],
    /// Largest turn of the ring against the rest, A, rad.
    pub shear: f64,
    /// Turn of the whole by the end, Omega_T, rad.
    pub spin: f64,
    /// Duration T, s.
    pub duration: f64,
    /// Shear modulus G, Pa.
    pub modulus: f64,
    /// Density of the dry soil, kg/m3.
    pub density: f64,
}

/// The state of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Place, m.
    pub x: [f64; 2],
    /// Velocity, m/s.
    pub velocity: [f64; 2],
    /// Stress xx, yy, zz, xy, Pa.
    pub stress: [f64; 4],
}

/// A function of time with its first two derivatives.
type Jet = [f64; 3];

impl Vortex {
    /// h and its first two derivatives over R.
    fn bump(&self, radius: f64) -> Jet {
        let [centre, width] = self.ring;
        let s = (radius - centre) / width;
        let inside = 1.0 - s * s;
        if inside <= 0.0 {
            return [0.0; 3];
        }
        let slope = -6.0 * s * inside * inside / width;
        [inside.powi(3), slope, (24.0 * s * s * inside - 6.0 * inside * inside) / (width * width)]
    }

    /// g and Omega over t.
    fn in_time(&self, time: f64) -> [Jet; 2] {
        let w = 2.0 * PI / self.duration;
        let (sin, cos) = (w * time).sin_cos();
        let g = [0.5 * (1.0 - cos), 0.5 * w * sin, 0.5 * w * w * cos];
        let rate = self.spin / self.duration;
        [g, [rate * (time - sin / w), rate * (1.0 - cos), rate * w * sin]]
    }

    /// alpha with its first two derivatives over t; gamma and its derivative over R, 1/m.
    fn turn(&self, radius: f64, time: f64) -> (Jet, [f64; 2]) {
        let ([h, h1, h2], [g, omega]) = (self.bump(radius), self.in_time(time));
        let gamma = [self.shear * g[0] * radius * h1, self.shear * g[0] * (h1 + radius * h2)];
        (std::array::from_fn(|i| self.shear * h * g[i] + omega[i]), gamma)
    }

    /// Largest shear strain gamma over the ring and the time.
    pub fn largest_shear(&self) -> f64 {
        let [centre, width] = self.ring;
        let at = |i: i32| self.turn(centre + width * f64::from(i) / 500.0, 0.5 * self.duration).1[0].abs();
        (-500..=500).map(at).fold(0.0, f64::max)
    }

    /// Distance from the middle (m) and direction of a place.
    fn polar(&self, x: [f64; 2]) -> (f64, [f64; 2]) {
        let from = [x[0] - self.middle[0], x[1] - self.middle[1]];
        let radius = from[0].hypot(from[1]);
        (radius, if radius > 0.0 { from.map(|x| x / radius) } else { [1.0, 0.0] })
    }

    /// Body force per mass at a place now, m/s2.
    pub fn body_force(&self, x: [f64; 2], time: f64) -> [f64; 2] {
        let (radius, [cos, sin]) = self.polar(x);
        let ([_, rate, acceleration], [gamma, along]) = self.turn(radius, time);
        let (g, mut divergence) = (self.modulus, [0.0; 2]);
        if gamma != 0.0 || along != 0.0 {
            let (sin, cos) = gamma.sin_cos();
            divergence = [-g * (sin * along + 2.0 * (1.0 - cos) / radius), g * (cos * along + 2.0 * sin / radius)];
        }
        let radial = -radius * rate * rate - divergence[0] / self.density;
        let tangential = radius * acceleration - divergence[1] / self.density;
        [radial * cos - tangential * sin, radial * sin + tangential * cos]
    }

    /// The point that stood at a place at t = 0.
    pub fn point(&self, first: [f64; 2], time: f64) -> Point {
        let (radius, [cos, sin]) = self.polar(first);
        let ([angle, rate, _], [gamma, _]) = self.turn(radius, time);
        let (turned_sin, turned_cos) = angle.sin_cos();
        let [c, s] = [cos * turned_cos - sin * turned_sin, sin * turned_cos + cos * turned_sin];
        let (shear, normal) = {
            let (sin, cos) = gamma.sin_cos();
            (self.modulus * sin, self.modulus * (1.0 - cos)) // sigma_rt, sigma_tt
        };
        let (xx, xy) =
            (-normal * (c * c - s * s) - 2.0 * shear * s * c, shear * (c * c - s * s) - 2.0 * normal * s * c);
        Point {
            x: [self.middle[0] + radius * c, self.middle[1] + radius * s],
            velocity: [-radius * rate * s, radius * rate * c],
            stress: [xx, -xx, 0.0, xy],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DISC: Vortex = Vortex {
        middle: [1.0, 0.9],
        ring: [0.45, 0.3],
        shear: 0.3,
        spin: PI,
        duration: 0.2,
        modulus: 4e5,
        density: 1000.0,
    };

    /// A velocity gradient (1/s) at a place by central differences of the exact velocities.
    fn gradient(first: [f64; 2], time: f64) -> [[f64; 2]; 2] {
        let h = 1e-5;
        // dv/dX (dx/dX)^-1
        let by = |d: usize, e: f64| {
            let mut at = first;
            at[d] += e;
            DISC.point(at, time)
        };
        let (mut v, mut f) = ([[0.0; 2]; 2], [[0.0; 2]; 2]);
        for d in 0..2 {
            let (low, high) = (by(d, -h), by(d, h));
            for i in 0..2 {
                v[i][d] = (high.velocity[i] - low.velocity[i]) / (2.0 * h);
                f[i][d] = (high.x[i] - low.x[i]) / (2.0 * h);
            }
        }
        let det = f[0][0] * f[1][1] - f[0][1] * f[1][0];
        let inverse = [[f[1][1] / det, -f[0][1] / det], [-f[1][0] / det, f[0][0] / det]];
        std::array::from_fn(|i| std::array::from_fn(|j| v[i][0] * inverse[0][j] + v[i][1] * inverse[1][j]))
    }

    /// The stress follows the rate law, integrated in small steps along the exact motion.
    #[test]
    fn the_stress_is_that_of_the_law() {
        let (first, steps) = ([1.0 + 0.58 * 0.6, 0.9 + 0.58 * 0.8], 20_000);
        let dt = 0.5 * DISC.duration / f64::from(steps);
        let mut stress = [0.0_f64; 4];
        for step in 0..steps {
            let l = gradient(first, (f64::from(step) + 0.5) * dt);
            let (spin, shear) = (0.5 * (l[0][1] - l[1][0]), l[0][1] + l[1][0]);
            assert!((l[0][0] + l[1][1]).abs() < 1e-5 * (1.0 + shear.abs()), "volumes stay");
            let rate = |s: &[f64; 4]| {
                let turned = [2.0 * spin * s[3], -2.0 * spin * s[3], 0.0, spin * (s[1] - s[0])];
                let strained = [2.0 * l[0][0], 2.0 * l[1][1], 0.0, shear].map(|e| DISC.modulus * e);
                std::array::from_fn::<f64, 4, _>(|i| turned[i] + strained[i])
            };
            let half = rate(&stress);
            let middle = std::array::from_fn(|i| stress[i] + 0.5 * dt * half[i]);
            let whole = rate(&middle);
            (0..4).for_each(|i| stress[i] += dt * whole[i]);
        }
        let exact = DISC.point(first, 0.5 * DISC.duration).stress;
        let off = (0..4).map(|i| (stress[i] - exact[i]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-5 * DISC.modulus, "{stress:?} {exact:?}");
        assert!(exact[3].hypot(exact[0]) > 0.5 * DISC.modulus, "{exact:?}");
    }

    /// Force, stress and acceleration are in balance: `rho a = div sigma + rho b` by differences over places and times.
    #[test]
    fn the_force_balances() {
        let (first, time, h) = ([1.0 - 0.5, 0.9 + 0.2], 0.33 * DISC.duration, 1e-5);
        let here = DISC.point(first, time);
        let dt = 1e-6;
        let [before, after] = [time - dt, time + dt].map(|t| DISC.point(first, t).velocity);
        // Stress at places near by: through the points that are there, found by turning back.
        let stress_at = |x: [f64; 2]| {
            let (radius, _) = DISC.polar(x);
            let angle = -DISC.turn(radius, time).0[0];
            let from = [x[0] - DISC.middle[0], x[1] - DISC.middle[1]];
            let (s, c) = angle.sin_cos();
            let first = [DISC.middle[0] + from[0] * c - from[1] * s, DISC.middle[1] + from[0] * s + from[1] * c];
            DISC.point(first, time).stress
        };
        let slope = |d: usize, component: usize| {
            let by = |e: f64| {
                let mut x = here.x;
                x[d] += e;
                stress_at(x)[component]
            };
            (by(h) - by(-h)) / (2.0 * h)
        };
        let divergence = [slope(0, 0) + slope(1, 3), slope(0, 3) + slope(1, 1)];
        let force = DISC.body_force(here.x, time);
        for d in 0..2 {
            let acceleration = (after[d] - before[d]) / (2.0 * dt);
            let expected = acceleration - divergence[d] / DISC.density;
            assert!((force[d] - expected).abs() < 1e-5 * expected.abs().max(100.0), "{d}: {} {expected}", force[d]);
        }
        // At the start and at the end it rests.
        assert!(DISC.point(first, 0.0).velocity.iter().all(|v| v.abs() < 1e-12));
        assert!((DISC.largest_shear() - 1.0).abs() < 0.05, "{}", DISC.largest_shear());
    }
}

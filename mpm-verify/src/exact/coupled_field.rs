//! A made-up wave of soil and pore water in a closed square, u-p model in plane strain: every term of the balances counts.
//!
//! With k = pi/W in a square of side W between rollers that pass no water:
//! `u = a(t) (sin kx cos ky, cos kx sin ky)`, `p = b(t) cos kx cos ky`, a = A sin(w t).
//! The mass of water `p'/Q + div u' + div(n v*) = 0` with Darcy's `n v* = -kappa (grad p + chi rho_w u'')` asks for
//! `b' + lambda b = -2 k Q (a' - kappa chi rho_w a'')`, lambda = 2 k^2 kappa Q, whose periodic solution is taken, so that the
//! water needs no source. What moves the mixture so is a force on the soil per volume
//! `f = (rho a'' + 2 k^2 M a - k b) (sin kx cos ky, cos kx sin ky)`. Small strain; chi = 1 with inertia in Darcy's law.
//!
//! The method: Roache 2002, J. Fluids Eng. 124(1), doi:10.1115/1.1436090.

use std::f64::consts::PI;

use mpm_core::boundary::FirstState;
use mpm_core::scene::Scene;

/// The field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoupledField {
    /// k = pi/W, 1/m.
    pub wave: f64,
    /// A, m.
    pub amplitude: f64,
    /// w, rad/s.
    pub frequency: f64,
    /// Pressure in step with a and with a', Pa: `b = c_0 sin wt + c_1 cos wt`.
    pub pressures: [f64; 2],
    /// Oedometer modulus M and the first Lamé constant, Pa.
    pub moduli: [f64; 2],
    /// Density of the mixture over that of the dry soil.
    pub loading: f64,
    /// Density of the dry soil, kg/m3.
    pub dry: f64,
}

impl CoupledField {
    /// The field of a square of soil; `None` if it is dry or no square.
    pub fn new(scene: &Scene, amplitude: f64, frequency: f64) -> Option<Self> {
        let water = scene.water?;
        if (scene.width / scene.height - 1.0).abs() > 1e-12 {
            return None;
        }
        let (wave, q, kappa, w) = (PI / scene.width, scene.pore_stiffness(), water.mobility(), frequency);
        let inertia = if scene.darcy_inertia { water.density } else { 0.0 };
        let rate = 2.0 * wave * wave * kappa * q;
        // b' + lambda b = s sin wt + c cos wt
        let sin = -2.0 * wave * q * kappa * inertia * amplitude * w * w;
        let cos = -2.0 * wave * q * amplitude * w;
        let size = rate * rate + w * w;
        Some(Self {
            wave,
            amplitude,
            frequency,
            pressures: [(rate * sin + w * cos) / size, (rate * cos - w * sin) / size],
            moduli: [scene.oedometer_modulus(), scene.elastic.lame()],
            loading: scene.mixture_density() / scene.dry_density(),
            dry: scene.dry_density(),
        })
    }

    fn at(&self, time: f64) -> [f64; 2] {
        let (sin, cos) = (self.frequency * time).sin_cos();
        [self.amplitude * sin, self.pressures[0] * sin + self.pressures[1] * cos]
    }

    /// sin kx cos ky, cos kx sin ky, and cos kx cos ky.
    fn shapes(&self, [x, y]: [f64; 2]) -> ([f64; 2], f64) {
        let ((sx, cx), (sy, cy)) = ((self.wave * x).sin_cos(), (self.wave * y).sin_cos());
        ([sx * cy, cx * sy], cx * cy)
    }

    /// Pore pressure at a place (m) and a time (s), Pa.
    pub fn pressure(&self, x: [f64; 2], time: f64) -> f64 {
        self.at(time)[1] * self.shapes(x).1
    }

    /// Largest pore pressure there ever is, Pa.
    pub fn largest_pressure(&self) -> f64 {
        self.pressures[0].hypot(self.pressures[1])
    }

    /// Displacement of the point that stood at a place (m), m.
    pub fn displacement(&self, x: [f64; 2], time: f64) -> [f64; 2] {
        self.shapes(x).0.map(|s| self.at(time)[0] * s)
    }

    /// Force per mass of dry soil, m/s2.
    pub fn body_force(&self, x: [f64; 2], time: f64) -> [f64; 2] {
        let [a, b] = self.at(time);
        let k = self.wave;
        let inertia = -self.loading * self.frequency * self.frequency * a;
        let size = inertia + (2.0 * k * k * self.moduli[0] * a - k * b) / self.dry;
        self.shapes(x).0.map(|s| size * s)
    }

    /// The state at t = 0, with the velocity half a step (s) before: a step takes it to half a step after.
    pub fn start(&self, x: [f64; 2], step: f64) -> FirstState {
        let speed = self.amplitude * self.frequency * (0.5 * self.frequency * step).cos();
        FirstState { velocity: self.shapes(x).0.map(|s| speed * s), stress: [0.0; 4], pressure: self.pressure(x, 0.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(inertia: bool) -> (Scene, CoupledField) {
        let scene = crate::scenes::built_in("mandel")
            .expect("the built-in scene")
            // The file is quasi-static, whose Darcy's law has no inertia; the field has.
            .altered_unchecked(|scene| scene.darcy_inertia = inertia);
        let field = CoupledField::new(&scene, 1e-6, 300.0).expect("a square");
        (scene, field)
    }

    /// Both balances hold, by differences over places and times.
    #[test]
    fn mass_and_momentum_balance() {
        for inertia in [true, false] {
            let (scene, field) = field(inertia);
            let (x, time, h, dt) = ([0.3, 0.2], 1.7e-3, 1e-4, 1e-7);
            let moved = |d: usize, e: f64| std::array::from_fn::<f64, 2, _>(|i| x[i] + if i == d { e } else { 0.0 });
            let water = scene.water.expect("water");
            let acceleration = |x| field.displacement(x, time).map(|u| -u * field.frequency * field.frequency);
            let flux = |x: [f64; 2]| {
                let chi = if inertia { water.density } else { 0.0 };
                std::array::from_fn::<f64, 2, _>(|d| {
                    let by = |e: f64| {
                        let mut at = x;
                        at[d] += e;
                        field.pressure(at, time)
                    };
                    -water.mobility() * ((by(h) - by(-h)) / (2.0 * h) + chi * acceleration(x)[d])
                })
            };
            let divergence = |f: &dyn Fn([f64; 2]) -> [f64; 2]| -> f64 {
                (0..2).map(|d| (f(moved(d, h))[d] - f(moved(d, -h))[d]) / (2.0 * h)).sum()
            };
            let strain = |t: f64| divergence(&|x| field.displacement(x, t));
            let rate = |f: &dyn Fn(f64) -> f64| (f(time + dt) - f(time - dt)) / (2.0 * dt);
            let terms = [rate(&|t| field.pressure(x, t)) / scene.pore_stiffness(), rate(&strain), divergence(&flux)];
            let size = terms.iter().fold(0.0_f64, |m, t| m.max(t.abs()));
            assert!(terms.iter().sum::<f64>().abs() < 1e-5 * size, "{terms:?}");
            // Momentum along x: rho a = d sigma_xx/dx + d sigma_xy/dy - dp/dx + rho_d b.
            let (lame, shear) = (scene.elastic.lame(), scene.elastic.shear_modulus());
            let slope = |f: &dyn Fn([f64; 2]) -> f64, at: [f64; 2], d: usize| {
                let by = |e: f64| {
                    let mut x = at;
                    x[d] += e;
                    f(x)
                };
                (by(h) - by(-h)) / (2.0 * h)
            };
            let u = |i: usize| move |x: [f64; 2]| field.displacement(x, time)[i];
            let xx = |x| lame * (slope(&u(0), x, 0) + slope(&u(1), x, 1)) + 2.0 * shear * slope(&u(0), x, 0);
            let xy = |x| shear * (slope(&u(0), x, 1) + slope(&u(1), x, 0));
            let inner = slope(&xx, x, 0) + slope(&xy, x, 1) - slope(&|x| field.pressure(x, time), x, 0);
            let given = scene.dry_density() * field.body_force(x, time)[0];
            let moving = scene.mixture_density() * acceleration(x)[0];
            assert!((inner + given - moving).abs() < 1e-4 * given.abs(), "{inner} {given} {moving}");
        }
    }
}

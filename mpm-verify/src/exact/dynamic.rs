//! The consolidating column with inertia: the full model (u-w) and the u-p model, exactly.
//!
//! Assumptions as Terzaghi's with compressible water, plus inertia of the mixture and, if asked for, `rho_w a_s` in Darcy's law
//! and the acceleration of the water relative to the soil. With y the height above the impermeable base,
//! `u = sum U_j sin(k_j y)`, `p = sum P_j cos(k_j y)`, k_j = (j - 1/2) pi/H, each mode obeys
//! `rho U'' = -M k^2 U + k P - 2 q s_j/H` and `P'/Q = -k U' - (k_h/gamma_w)(k^2 P - rho_w k U'')`, s_j = sin(k_j H).
//!
//! In the full model the flux `w = sum W_j sin(k_j y)` of the water is a state of its own:
//! `rho U'' + rho_w W' = ...` as above, `rho_w U'' + (rho_w/n) W' = k P - (gamma_w/k_h) W` and `P'/Q = -k (U' + W)`.
//!
//! The characteristic polynomial of a mode is `s^3 + D k^2 (1 - rho_w/rho) s^2 + k^2 (M + Q)/rho s + M D k^4/rho` with
//! D = k_h Q/gamma_w (rho_w = 0 there without inertia in Darcy's law). By Routh's criterion every wave grows if
//! `Q/(M + Q) < rho_w/rho` in the u-p model: with `rho_w a_s` in Darcy's law the model itself is unstable in water so soft that it carries
//! less than that share of a load (p_0/q). [`DynamicColumn::decay`] is negative then.
//!
//! Weight is one more load: in the excess over the hydrostatic pressure the same equations hold, with the buoyant weight
//! (rho - rho_w) g in place of the load, whose modes are 2/(k_j H).
//!
//! Sources: Biot 1956; Zienkiewicz, Chang & Bettess 1980, Geotechnique 30(4); modal form derived here.

use mpm_core::scene::{Fields, LoadOn, Start, Surcharge};
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::PI;

/// Modes kept: enough to meet the tables of the tests to 2e-9 of q H/M.
const MODES: usize = 600;

/// Modes of the full model, whose fast wave hardly damps the shortest of them: pressures to 1e-4 of the load.
const MODES_OF_FULL: usize = 6000;

/// A dynamic column drained at its top.
#[derive(Debug, Clone)]
pub struct DynamicColumn {
    height: f64,
    modulus: f64,
    load: f64,
    ramp: f64,
    /// Buoyant weight and weight of the water, N/m3.
    weights: [f64; 2],
    modes: Vec<Mode>,
}

#[derive(Debug, Clone)]
struct Mode {
    wave: f64,
    sign: f64,
    /// Eigenvalues (1/s), and their shares in U - U_static (m) and P (Pa).
    parts: Vec<[Complex<f64>; 3]>,
}

impl DynamicColumn {
    /// The column of a scene; `None` if it is dry, neither loaded nor heavy, in layers or not drained at the top alone, or if weight
    /// and a load that grows come together.
    pub fn new(scene: &Fields) -> Option<Self> {
        Self::of(scene, true)
    }

    /// Column of a scene without inertia of soil and water: a mode holds `k U + P/Q` when the load comes, and decays at the rate
    /// `(k_h/gamma_w) k^2/(1/M + 1/Q)`.
    pub fn without_inertia(scene: &Fields) -> Option<Self> {
        Self::of(scene, false)
    }

    fn of(scene: &Fields, moves: bool) -> Option<Self> {
        let (water, gravity) = (scene.water?, scene.gravity.unwrap_or(0.0));
        let load =
            scene.surcharge.unwrap_or(Surcharge { pressure: 0.0, on: LoadOn::Surface, ramp_time: 0.0, strip: None });
        let drained = scene.stages[scene.stages.len() - 1].drained;
        if drained != [false, false, false, true] || !scene.layers.is_empty() || (gravity > 0.0 && load.ramp_time > 0.0)
        {
            return None;
        }
        let (m, q, rho, h) = (scene.oedometer_modulus(), scene.pore_stiffness(), scene.mixture_density(), scene.height);
        let diffusivity = water.mobility() * q;
        let inertia = if scene.darcy_inertia { diffusivity * water.density } else { 0.0 };
        let undrained = match scene.start {
            Start::UndrainedEquilibrium => scene.undrained_pressure(),
            _ => 0.0,
        };
        // The load that the skeleton carries at t = 0; an unloaded start carries nothing.
        let carried = if scene.start == Start::UndrainedEquilibrium { load.pressure - undrained } else { 0.0 };
        // Of the weight the water has a share at t = 0 as of the load, and above the hydrostatic pressure A z.
        let held = if scene.start == Start::UndrainedEquilibrium { scene.undrained_share() } else { 0.0 };
        let weights = [(rho - water.density) * gravity, water.density * gravity];
        let geostatic = scene.start == Start::Geostatic;
        let excess = if geostatic { 0.0 } else { held * rho * gravity - weights[1] };
        let missing =
            if geostatic { 0.0 } else { weights[0] - (1.0 - held) * f64::from(u8::from(held > 0.0)) * rho * gravity };
        let count = if scene.relative_acceleration { MODES_OF_FULL } else { MODES };
        let modes = (1..=count)
            .map(|j| {
                let k = (j as f64 - 0.5) * PI / h;
                let sign = if j % 2 == 1 { 1.0 } else { -1.0 };
                let shape = 2.0 * sign / (h * k * k);
                let heavy = 2.0 / (h * k * k);
                // State (U - U_static, U', P, and W in the full model).
                let first = [
                    shape * (load.pressure - carried) / m + heavy * missing / (k * m),
                    0.0,
                    shape * k * undrained + heavy * excess,
                    0.0,
                ];
                if !moves {
                    let storage = 1.0 / m + 1.0 / q;
                    let pressure = (k * first[0] + first[2] / q) / storage;
                    let part = [-water.mobility() * k * k / storage, pressure / (m * k), pressure];
                    return Mode { wave: k, sign, parts: vec![part.map(Complex::from)] };
                }
                let pushed = [-m * k * k, 0.0, k, 0.0];
                if scene.relative_acceleration {
                    // rho U'' + rho_w W' = pushed, rho_w U'' + (rho_w/n) W' = drawn.
                    let (rho_w, own) = (water.density, water.density / scene.porosity);
                    let drawn = [0.0, 0.0, k, -1.0 / water.mobility()];
                    let det = rho * own - rho_w * rho_w;
                    let soil = |i: usize| (own * pushed[i] - rho_w * drawn[i]) / det;
                    let flux = |i: usize| (rho * drawn[i] - rho_w * pushed[i]) / det;
                    let rows = [
                        [0.0, 1.0, 0.0, 0.0],
                        std::array::from_fn(soil),
                        [0.0, -q * k, 0.0, -q * k],
                        std::array::from_fn(flux),
                    ];
                    return Mode::new(k, sign, &DMatrix::from_fn(4, 4, |i, j| rows[i][j]), &first);
                }
                let motion = [pushed[0] / rho, 0.0, pushed[2] / rho];
                let flow = [inertia * k * motion[0], -q * k, -diffusivity * k * k + inertia * k * motion[2]];
                let rows = [[0.0, 1.0, 0.0], motion, flow];
                Mode::new(k, sign, &DMatrix::from_fn(3, 3, |i, j| rows[i][j]), &first[..3])
            })
            .collect();
        Some(Self { height: h, modulus: m, load: load.pressure, ramp: load.ramp_time, weights, modes })
    }

    /// How fast the slowest of its waves decays, 1/s; negative if one grows, infinite if none swings.
    pub fn decay(&self) -> f64 {
        let waves = self
            .modes
            .iter()
            .flat_map(|mode| mode.parts.iter().map(|[rate, ..]| *rate))
            .filter(|rate| rate.im.abs() > rate.re.abs());
        waves.map(|rate| -rate.re).fold(f64::INFINITY, f64::min)
    }

    /// Settlement of the surface from the unloaded state at a time (s), m.
    pub fn settlement(&self, time: f64) -> f64 {
        let late: f64 = self.modes.iter().map(|m| m.sign * self.response(time, |t, i| m.displacement(t, i))).sum();
        let heavy = 0.5 * self.weights[0] * self.height * self.height / self.modulus;
        self.share(time) * self.load * self.height / self.modulus + heavy - late
    }

    /// Pore pressure at a height above the base (m), Pa.
    pub fn pressure(&self, height: f64, time: f64) -> f64 {
        let of = |mode: &Mode| (mode.wave * height).cos() * self.response(time, |t, i| mode.pressure(t, i));
        self.modes.iter().map(of).sum::<f64>() + self.weights[1] * (self.height - height)
    }

    /// Pore pressure at the base, Pa.
    pub fn base_pressure(&self, time: f64) -> f64 {
        self.pressure(0.0, time)
    }

    fn share(&self, time: f64) -> f64 {
        if time < self.ramp { time / self.ramp } else { 1.0 }
    }

    /// Response to the load from that to a step; `part(t, true)` is the integral of `part(t, false)`.
    fn response(&self, time: f64, part: impl Fn(f64, bool) -> f64) -> f64 {
        if self.ramp == 0.0 {
            return part(time, false);
        }
        let before = if time > self.ramp { part(time - self.ramp, true) } else { part(0.0, true) };
        (part(time, true) - before) / self.ramp
    }
}

impl Mode {
    fn new(wave: f64, sign: f64, matrix: &DMatrix<f64>, first: &[f64]) -> Self {
        // The entries span twenty decades; a diagonal similarity makes them comparable without moving eigenvalues.
        let frequency = matrix[(1, 0)].abs().max((matrix[(1, 2)] * matrix[(2, 1)]).abs()).sqrt();
        let scale = DVector::from_fn(first.len(), |i, _| [frequency, 1.0, matrix[(1, 2)].abs() / frequency, 1.0][i]);
        let scaled = DMatrix::from_diagonal(&scale) * matrix * DMatrix::from_diagonal(&scale.map(f64::recip));
        let rates: Vec<Complex<f64>> = scaled.complex_eigenvalues().iter().copied().collect();
        // A component and its first derivatives at t = 0 give its shares (a Vandermonde system, by Lagrange).
        let mut derivatives = vec![DVector::from_column_slice(first)];
        for _ in 1..rates.len() {
            derivatives.push(matrix * &derivatives[derivatives.len() - 1]);
        }
        let share = |i: usize, component: usize| {
            // Coefficients of the product of (x - rate) over the others, the highest first.
            let (mut product, mut below) = (vec![Complex::from(1.0)], Complex::from(1.0));
            for (_, other) in rates.iter().enumerate().filter(|(j, _)| *j != i) {
                let shifted = product.iter().map(|c| -other * c).collect::<Vec<_>>();
                product.push(Complex::from(0.0));
                product.iter_mut().skip(1).zip(shifted).for_each(|(c, s)| *c += s);
                below *= rates[i] - other;
            }
            let of = |(c, x): (&Complex<f64>, &DVector<f64>)| c * Complex::from(x[component]);
            product.iter().zip(derivatives.iter().rev()).map(of).sum::<Complex<f64>>() / below
        };
        let parts = (0..rates.len()).map(|i| [rates[i], share(i, 0), share(i, 2)]).collect();
        Self { wave, sign, parts }
    }

    /// U - U_static, m, or its time integral.
    fn displacement(&self, time: f64, integral: bool) -> f64 {
        self.sum(time, integral, 1)
    }

    /// P, Pa, or its time integral.
    fn pressure(&self, time: f64, integral: bool) -> f64 {
        self.sum(time, integral, 2)
    }

    fn sum(&self, time: f64, integral: bool, component: usize) -> f64 {
        let part = |part: &[Complex<f64>; 3]| {
            let rate = part[0];
            let shape = if integral { Complex::from(1.0) / rate } else { Complex::from(1.0) };
            (part[component] * (rate * time).exp() * shape).re
        };
        self.parts.iter().map(part).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::oracle::Table;
    use super::super::terzaghi::Terzaghi;
    use super::*;
    use mpm_core::scene::{Integrator, Scene, ShapeChoice};

    fn scene(grain: bool, inertia: bool, ramp: f64) -> Scene {
        scene_of(grain, inertia, ramp, Integrator::Explicit)
    }

    /// With the implicit integrator the full model, where there is inertia.
    fn scene_of(grain: bool, inertia: bool, ramp: f64, integrator: Integrator) -> Scene {
        crate::scenes::terzaghi()
            .edited(|scene| {
                (scene.integrator, scene.relative_acceleration) = (integrator, integrator == Integrator::Implicit);
                if integrator == Integrator::Implicit {
                    scene.shape = ShapeChoice::Bspline2;
                }
                scene.grain_density = if grain { 1800.0 } else { 1500.0 / 0.7 };
                scene.darcy_inertia = inertia;
                scene.start = Start::Unloaded;
                scene.surcharge = scene.surcharge.map(|s| Surcharge { ramp_time: ramp, ..s });
            })
            .expect("a sound scene")
    }

    #[test]
    fn long_columns_match_the_tables() {
        for (name, inertia) in [("up", true), ("upq", false), ("full", true)] {
            for (density, grain) in [("rhog", true), ("rhob", false)] {
                let table = Table::read(&format!("04_dynamic_{name}_long_{density}.csv"));
                let integrator = if name == "full" { Integrator::Implicit } else { Integrator::Explicit };
                let exact =
                    DynamicColumn::new(&scene_of(grain, inertia, 5e-4, integrator)).expect("a wet, loaded column");
                for [t, u, p] in table.rows(["t_s", "top_u_over_qH_M", "base_p_Pa"]).into_iter().step_by(3) {
                    let s = exact.settlement(t) * exact.modulus / exact.load;
                    assert!((s - u).abs() < 2e-9, "{name} {density} t = {t}: {s} {u}");
                    let near = if name == "full" { 0.5 } else { 1e-3 };
                    let off = exact.base_pressure(t) - p;
                    assert!(off.abs() < near, "{name} {density} t = {t}: {off}");
                }
            }
        }
    }

    #[test]
    fn weight_without_inertia_is_its_series() {
        let mut light = crate::scenes::built_in("self-weight-consolidation").expect("the scene");
        // Slow water: what inertia does to a consolidation falls with the square of its speed.
        light = light
            .edited(|light| {
                light.water = light.water.map(|w| mpm_core::scene::WaterProperties {
                    hydraulic_conductivity: 1e-3 * w.hydraulic_conductivity,
                    ..w
                });
            })
            .expect("a sound scene");
        let dynamic = DynamicColumn::new(&light).expect("heavy");
        let series = super::super::self_weight::SelfWeight::new(&light).expect("heavy");
        for t in [0.1, 0.3, 1.0] {
            let time = t / series.time_factor(1.0);
            assert!((dynamic.settlement(time) / series.settlement(time) - 1.0).abs() < 1e-5, "{t}");
            for height in [0.0, 0.4, 0.9] {
                let apart = dynamic.pressure(height, time) / series.pressure(height, time) - 1.0;
                assert!(apart.abs() < 1e-5, "{t} {height}: {apart:e}");
            }
        }
    }

    #[test]
    fn waves_grow_in_soft_water_under_a_darcy_law_with_inertia() {
        // rho_w/rho = 1000/1560 = 0.641.
        let decay = |share: f64, inertia: bool| {
            // The checker refuses what grows.
            let scene = scene(true, inertia, 0.0).altered_unchecked(|scene| {
                let bulk_modulus = scene.porosity * scene.oedometer_modulus() * share / (1.0 - share);
                scene.water = scene.water.map(|water| mpm_core::scene::WaterProperties { bulk_modulus, ..water });
            });
            DynamicColumn::new(&scene).expect("wet").decay()
        };
        assert!(decay(0.63, true) < 0.0 && decay(0.65, true) > 0.0);
        assert!(decay(0.5, true) < 0.0 && decay(0.5, false) > 0.0);
    }

    #[test]
    fn without_inertia_it_is_the_compressible_series() {
        // A hundredth of the density, from undrained equilibrium: the inertia effect of 2e-4 falls with it once
        // the waves of the start have died out (at Tv = 0.01 a light column still rings by 8e-5).
        let light = crate::scenes::terzaghi()
            .edited(|light| {
                light.grain_density *= 0.01;
                if let Some(water) = &mut light.water {
                    water.density *= 0.01;
                }
            })
            .expect("a sound scene");
        let (dynamic, quasi) = (DynamicColumn::new(&light).expect("wet"), Terzaghi::compressible(&light).expect("wet"));
        let still = DynamicColumn::without_inertia(&light).expect("wet");
        for tv in [0.05, 0.1, 1.0] {
            let t = tv * light.time_per_factor().expect("wet");
            let [with, without] = [&dynamic, &still].map(|column| column.settlement(t) / quasi.settlement(t) - 1.0);
            assert!(with.abs() < 3e-6 && without.abs() < 1e-8, "{tv}: {with} {without}");
            let apart = still.base_pressure(t) / quasi.pressure(0.0, t) - 1.0;
            assert!(apart.abs() < 1e-8, "{tv}: {apart}");
        }
    }
}

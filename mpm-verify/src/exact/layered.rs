//! One-dimensional consolidation of layers: the eigenfunctions of the column, as many layers as there are.
//!
//! Assumptions: those of [`super::terzaghi`] in every layer; between two of them the pressure and the flux are continuous;
//! a load q at t = 0; p = 0 at the top, at the base no flow or p = 0.
//!
//! `s p_t = (kappa p_z)_z` with kappa = k/gamma_w and the storage s = 1/M + n/K_w of each layer, from its own undrained
//! pressure p_0 = q Q/(M + Q) = q/(M s). Separation gives `p = q sum B/N phi exp(-omega^2 t)` with
//! `(kappa phi')' + omega^2 s phi = 0`, `B = int phi/M`, `N = int s phi^2`, and, because every layer settles by
//! `(q - p)/M`, the settlement `S = q sum h/M - q sum B^2/N exp(-omega^2 t)`.
//!
//! In a layer `phi = r sin(psi)` and `kappa phi' = Z r cos(psi)`, where `psi` grows by `omega h sqrt(s/kappa)` and
//! `Z = omega sqrt(s kappa)`. At an interface phi and kappa phi' stay, so that tan(psi) changes by the ratio of the Z in
//! the same quadrant. The angle at the base grows with omega (Prüfer), which brackets every eigenvalue by itself: none
//! is missed however much k and M jump.
//!
//! Sources: Gray 1945, Proc. ASCE 70, 1327-1344 (two layers); Schiffman & Stein 1970, J. Soil Mech. Found. Div. 96(4),
//! 1499-1504; Lee, Xie & Cheung 1992, Int. J. Numer. Anal. Methods Geomech. 16(11), 815-830 (many layers). Angle: any
//! text on Sturm-Liouville problems, e.g. Coddington & Levinson 1955, chapter 8.

use std::f64::consts::{FRAC_PI_2, PI};

use mpm_core::scene::{Fields, Scene, Side};

use super::root::root;

/// Modes decay by exp(-omega^2 t): beyond this exponent they no longer count.
const DECAYED: f64 = 42.0;

/// A layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layer {
    /// Thickness h, m.
    pub thickness: f64,
    /// Mobility k/gamma_w, m4/(N s).
    pub mobility: f64,
    /// Oedometer modulus M, Pa.
    pub modulus: f64,
    /// Stiffness of the pore water Q = K_w/n, Pa; may be infinite.
    pub pore_stiffness: f64,
}

impl Layer {
    /// s = 1/M + n/K_w, 1/Pa.
    pub fn storage(&self) -> f64 {
        1.0 / self.modulus + 1.0 / self.pore_stiffness
    }

    /// Angle that a mode gains in the layer per omega, s^(1/2).
    fn passage(&self) -> f64 {
        self.thickness * (self.storage() / self.mobility).sqrt()
    }

    /// Z per omega.
    fn impedance(&self) -> f64 {
        (self.storage() * self.mobility).sqrt()
    }
}

/// A column of layers under a load.
#[derive(Debug, Clone, PartialEq)]
pub struct Layered {
    /// From the base up.
    pub layers: Vec<Layer>,
    /// Load q, Pa.
    pub load: f64,
    /// Whether the base drains too.
    pub double: bool,
    modes: Vec<Mode>,
    /// Time from which on the modes suffice, s.
    earliest: f64,
}

/// One eigenfunction.
#[derive(Debug, Clone, PartialEq)]
struct Mode {
    omega: f64,
    /// B/N.
    share: f64,
    /// B^2/N.
    settlement: f64,
    /// Amplitude r and angle at the top of each layer, from the top one down; the angle grows downwards.
    pieces: Vec<[f64; 2]>,
}

impl Layered {
    /// The column of a scene, for times from its first observed one on. `None` for a scene that is dry, unloaded, moves in
    /// two dimensions, drains elsewhere than at the top or at both ends, or is loaded gradually.
    pub fn of(scene: &Scene) -> Option<Self> {
        let (water, load) = (scene.water?, scene.surcharge?);
        let drained = scene.stages.last()?.drained;
        if !scene.is_plain_column() || !drained[Side::Top as usize] || load.ramp_time > 0.0 || scene.stages.len() > 1 {
            return None;
        }
        let layer = |(thickness, soil): &(f64, Fields)| Layer {
            thickness: *thickness,
            mobility: soil.water.map_or(water.mobility(), |w| w.mobility()),
            modulus: soil.oedometer_modulus(),
            pore_stiffness: soil.pore_stiffness(),
        };
        let layers = scene.by_layer().iter().map(layer).collect();
        Some(Self::new(layers, load.pressure, drained[Side::Bottom as usize], *scene.observe_times.first()?))
    }

    /// Layers from the base up, for times from `earliest` (s) on.
    pub fn new(layers: Vec<Layer>, load: f64, double: bool, earliest: f64) -> Self {
        let mut column = Self { layers, load, double, modes: Vec::new(), earliest };
        let highest = (DECAYED / earliest).sqrt();
        let mut number = 0;
        while let Some(omega) = column.eigenvalue(number).filter(|omega| *omega <= highest) {
            column.modes.push(column.mode(omega));
            number += 1;
        }
        column
    }

    /// Layers from the top down.
    fn downwards(&self) -> impl Iterator<Item = &Layer> {
        self.layers.iter().rev()
    }

    /// Angle of the mode at the base, continuous in and growing with omega.
    fn angle(&self, omega: f64) -> f64 {
        let mut above: Option<f64> = None;
        self.downwards().fold(0.0, |psi, layer| {
            let own = layer.impedance();
            let psi = above.map_or(psi, |above| across(psi, own / above));
            above = Some(own);
            psi + omega * layer.passage()
        })
    }

    /// The eigenvalue omega (s^-1/2) with a number, counted from 0.
    fn eigenvalue(&self, number: u32) -> Option<f64> {
        let target = PI * (f64::from(number) + if self.double { 1.0 } else { 0.5 });
        let passage: f64 = self.layers.iter().map(Layer::passage).sum();
        // An interface keeps the quadrant, so that it moves the angle by less than a right one.
        let moved = FRAC_PI_2 * self.layers.len() as f64;
        let (low, high) = (((target - moved) / passage).max(0.0), (target + moved) / passage);
        root(|omega| self.angle(omega) - target, low, high)
    }

    fn mode(&self, omega: f64) -> Mode {
        let (mut r, mut psi, mut above) = (1.0, 0.0, None);
        let (mut force, mut norm) = (0.0, 0.0);
        let mut pieces = Vec::with_capacity(self.layers.len());
        for layer in self.downwards() {
            let own = layer.impedance();
            if let Some(above) = above {
                let ratio: f64 = own / above;
                let (sin, cos) = f64::sin_cos(psi);
                r *= (sin * sin + (cos / ratio).powi(2)).sqrt();
                psi = across(psi, ratio);
            }
            above = Some(own);
            pieces.push([r, psi]);
            let gained = omega * layer.passage();
            let (w, end) = (gained / layer.thickness, psi + gained);
            // cos a - cos b and sin 2b - sin 2a without cancellation.
            let integral = r * 2.0 * (0.5 * (psi + end)).sin() * (0.5 * gained).sin() / w;
            let square = 0.5 * r * r * (layer.thickness - (psi + end).cos() * gained.sin() / w);
            force += integral / layer.modulus;
            norm += layer.storage() * square;
            psi = end;
        }
        Mode { omega, share: force / norm, settlement: force * force / norm, pieces }
    }

    /// Settlement of the surface from the unloaded state at a time (s), m; not a number before the earliest time.
    pub fn settlement(&self, time: f64) -> f64 {
        self.load * (self.softness() - self.sum(time, |mode| mode.settlement))
    }

    /// Time in which pressure passes the whole column, (sum h sqrt(s/kappa))^2, s: H^2/c in one layer.
    pub fn passage_time(&self) -> f64 {
        self.layers.iter().map(Layer::passage).sum::<f64>().powi(2)
    }

    /// Settlement in the end, m.
    pub fn final_settlement(&self) -> f64 {
        self.load * self.softness()
    }

    /// Sum of h/M, m/Pa.
    fn softness(&self) -> f64 {
        self.layers.iter().map(|layer| layer.thickness / layer.modulus).sum()
    }

    /// Pore pressure at a height above the base (m) and a time (s), Pa; not a number before the earliest time.
    pub fn pressure(&self, height: f64, time: f64) -> f64 {
        let whole: f64 = self.layers.iter().map(|layer| layer.thickness).sum();
        let mut depth = (whole - height).max(0.0);
        let mut index = 0;
        for layer in self.downwards() {
            if depth <= layer.thickness || index + 1 == self.layers.len() {
                break;
            }
            depth -= layer.thickness;
            index += 1;
        }
        let layer = &self.layers[self.layers.len() - 1 - index];
        let along = depth * layer.passage() / layer.thickness;
        let value = |mode: &Mode| {
            let [r, psi] = mode.pieces[index];
            mode.share * r * (psi + mode.omega * along).sin()
        };
        self.load * self.sum(time, value)
    }

    /// Undrained pore pressure at a height, q Q/(M + Q), Pa.
    pub fn undrained(&self, height: f64) -> f64 {
        let mut top = 0.0;
        let layer = self.layers.iter().find(|layer| {
            top += layer.thickness;
            height < top
        });
        layer.or(self.layers.last()).map_or(0.0, |layer| self.load / (layer.modulus * layer.storage()))
    }

    /// The largest undrained pore pressure of the layers, Pa.
    pub fn largest_undrained(&self) -> f64 {
        self.layers.iter().map(|layer| self.load / (layer.modulus * layer.storage())).fold(0.0, f64::max)
    }

    /// Interfaces above the base, m.
    pub fn interfaces(&self) -> Vec<f64> {
        let mut top = 0.0;
        let tops = self.layers.iter().map(|layer| {
            top += layer.thickness;
            top
        });
        tops.take(self.layers.len().saturating_sub(1)).collect()
    }

    fn sum(&self, time: f64, term: impl Fn(&Mode) -> f64) -> f64 {
        if time < self.earliest * (1.0 - 1e-9) {
            return f64::NAN;
        }
        let decay = |mode: &Mode| -mode.omega * mode.omega * time;
        let lasting = self.modes.iter().take_while(|mode| decay(mode) > -DECAYED);
        lasting.map(|mode| term(mode) * decay(mode).exp()).sum()
    }
}

/// The angle below an interface where Z changes by a ratio: tan(psi) times it, in the same quadrant.
fn across(psi: f64, ratio: f64) -> f64 {
    let turns = (psi / PI).round();
    let rest = psi - turns * PI;
    // Between -pi/2 and pi/2, both ends of which stay.
    turns * PI + (ratio * rest.sin()).atan2(rest.cos())
}

#[cfg(test)]
mod tests {
    use super::super::terzaghi::Terzaghi;
    use super::*;
    use nalgebra::Complex;

    const MODULUS: f64 = 2.0e7 * 0.7 / (1.3 * 0.4);
    const PORE: f64 = 2.2e9 / 0.3;
    const MOBILITY: f64 = 5.0e-4 / 9810.0;

    fn layer(thickness: f64, faster: f64, stiffer: f64) -> Layer {
        Layer { thickness, mobility: faster * MOBILITY, modulus: stiffer * MODULUS, pore_stiffness: PORE }
    }

    /// Time over which the slowest way out of all layers drains, s.
    fn slow(layers: &[Layer]) -> f64 {
        layers.iter().map(Layer::passage).sum::<f64>().powi(2)
    }

    #[test]
    fn equal_layers_are_terzaghis_column() {
        let water = 1.0 / MODULUS + 1.0 / PORE;
        for double in [false, true] {
            let layers = vec![layer(0.3, 1.0, 1.0), layer(0.2, 1.0, 1.0), layer(0.5, 1.0, 1.0)];
            let exact = Layered::new(layers, 1e4, double, 1e-4);
            let one = Terzaghi {
                height: 1.0,
                path: if double { 0.5 } else { 1.0 },
                double,
                coefficient: MOBILITY / water,
                modulus: MODULUS,
                load: 1e4,
                undrained: 1e4 / (MODULUS * water),
                ramp: 0.0,
                alpha: 1.0,
            };
            for time in [1e-4, 1e-3, 0.01, 0.1, 0.5, 2.0] {
                let (a, b) = (exact.settlement(time), one.settlement(time));
                assert!((a / b - 1.0).abs() < 1e-12, "{double} {time}: {a} {b}");
                for height in [0.0, 0.1, 0.3, 0.45, 0.5, 0.7, 0.95, 1.0] {
                    let off = exact.pressure(height, time) - one.pressure(height, time);
                    assert!(off.abs() < 1e-12 * 1e4, "{double} {time} {height}: {off}");
                }
            }
        }
    }

    /// Mean pressures of the layers and the pressure at a height by numerical inversion of the Laplace transform,
    /// with the transforms of all layers solved as one system. Knows nothing of eigenfunctions.
    fn by_laplace(column: &Layered, time: f64, height: f64) -> [f64; 2] {
        super::super::laplace::at(time, |s| transforms(column, s, height))
    }

    /// Transform of the settlement's missing part, sum of h (mean p)/M, and of the pressure at a height.
    ///
    /// In a layer `p = p_0/s + a exp(-w z) + b exp(-w (h - z))`, z up from its base: nothing overflows.
    fn transforms(column: &Layered, s: Complex<f64>, height: f64) -> [Complex<f64>; 2] {
        let count = column.layers.len();
        let one = Complex::new(1.0, 0.0);
        let mut matrix = nalgebra::DMatrix::from_element(2 * count, 2 * count, Complex::new(0.0, 0.0));
        let mut right = nalgebra::DVector::from_element(2 * count, Complex::new(0.0, 0.0));
        let wave = |l: &Layer| (s * l.storage() / l.mobility).sqrt();
        let fall = |l: &Layer| (-wave(l) * l.thickness).exp();
        let rest = |l: &Layer| Complex::from(column.load / (l.modulus * l.storage())) / s;
        for (i, l) in column.layers.iter().enumerate() {
            let (e, z) = (fall(l), wave(l) * l.mobility);
            if i == 0 {
                // The base: a + b e = -p_0/s, or -a + b e = 0.
                let sign = if column.double { one } else { -one };
                (matrix[(0, 0)], matrix[(0, 1)]) = (sign, e);
                right[0] = if column.double { -rest(l) } else { Complex::new(0.0, 0.0) };
            }
            if i + 1 == count {
                let row = 2 * count - 1;
                (matrix[(row, 2 * i)], matrix[(row, 2 * i + 1)], right[row]) = (e, one, -rest(l));
                continue;
            }
            let next = &column.layers[i + 1];
            let (f, y) = (fall(next), wave(next) * next.mobility);
            let row = 2 * i + 1;
            for (column, value) in [e, one, -one, -f].into_iter().enumerate() {
                matrix[(row, 2 * i + column)] = value;
            }
            right[row] = rest(next) - rest(l);
            for (column, value) in [-z * e, z, y, -y * f].into_iter().enumerate() {
                matrix[(row + 1, 2 * i + column)] = value / z;
            }
        }
        let x = matrix.lu().solve(&right).expect("a regular system");
        let (mut missing, mut pressure, mut base) = (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0), 0.0);
        for (i, l) in column.layers.iter().enumerate() {
            let (a, b, w) = (x[2 * i], x[2 * i + 1], wave(l));
            missing += (rest(l) * l.thickness + (a + b) * (one - fall(l)) / w) / l.modulus;
            let z = height - base;
            if (0.0..=l.thickness).contains(&z) {
                pressure = rest(l) + a * (-w * z).exp() + b * (-w * (l.thickness - z)).exp();
            }
            base += l.thickness;
        }
        [missing, pressure]
    }

    /// Largest difference from the inverted transforms, of the settlement as a share of the final one and of pressures as
    /// shares of the largest undrained one.
    fn off(column: &Layered, faster: f64) -> f64 {
        let whole = slow(&column.layers);
        let mut worst: f64 = 0.0;
        for share in [1e-4, 1e-3, 1e-2, 0.1, 0.3] {
            for height in [0.05, 0.35, 0.55, 0.9] {
                let time = share * whole;
                let [missing, pressure] = by_laplace(column, time * faster, height);
                let settlement = column.final_settlement() - missing;
                let pressures = (column.pressure(height, time) - pressure).abs() / column.largest_undrained();
                let settlements = (column.settlement(time) - settlement).abs() / column.final_settlement();
                worst = worst.max(settlements).max(pressures);
            }
        }
        worst
    }

    #[test]
    fn two_and_four_layers_match_inverted_transforms() {
        for (faster, stiffer) in [(10.0, 1.0), (1e3, 1.0), (1e6, 1.0), (1.0, 10.0), (1.0, 1e4), (1e6, 1e4), (1e6, 1e-4)]
        {
            let contrast = [layer(0.5, faster, stiffer), layer(0.5, 1.0, 1.0)];
            for layers in [contrast.to_vec(), contrast.iter().rev().copied().collect()] {
                for double in [false, true] {
                    let earliest = 1e-4 * slow(&layers);
                    let exact = Layered::new(layers.clone(), 1e4, double, earliest);
                    let error = off(&exact, 1.0);
                    assert!(error < 1e-7, "k x {faster}, M x {stiffer}, {double}: {error}");
                }
            }
        }
        let layers = vec![layer(0.3, 1.0, 1.0), layer(0.2, 50.0, 4.0), layer(0.3, 0.01, 0.2), layer(0.2, 3.0, 30.0)];
        let exact = Layered::new(layers.clone(), 1e4, false, 1e-4 * slow(&layers));
        assert!(off(&exact, 1.0) < 1e-7, "{}", off(&exact, 1.0));
        assert!(off(&exact, 1.001) > 1e-5, "the check cannot fail");
    }

    /// The lowest eigenvalues omega of 200 cells with two-point fluxes, s^-1/2.
    fn on_cells(layers: &[Layer; 2]) -> Vec<f64> {
        const CELLS: usize = 200;
        let of = |cell: usize| &layers[cell * 2 / CELLS];
        let size = 1.0 / CELLS as f64;
        let mut matrix = nalgebra::DMatrix::zeros(CELLS, CELLS);
        for cell in 0..CELLS {
            let half = |cell: usize| 0.5 * size / of(cell).mobility;
            let up = 1.0 / (half(cell) + if cell + 1 < CELLS { half(cell + 1) } else { 0.0 });
            matrix[(cell, cell)] += up;
            if cell + 1 < CELLS {
                matrix[(cell + 1, cell + 1)] += up;
                (matrix[(cell, cell + 1)], matrix[(cell + 1, cell)]) = (-up, -up);
            }
        }
        let root = |cell: usize| (size * of(cell).storage()).sqrt();
        for i in 0..CELLS {
            for j in 0..CELLS {
                matrix[(i, j)] /= root(i) * root(j);
            }
        }
        let values = nalgebra::SymmetricEigen::new(matrix).eigenvalues;
        let mut omegas: Vec<f64> = values.iter().map(|value| value.max(0.0).sqrt()).collect();
        omegas.sort_by(f64::total_cmp);
        omegas
    }

    #[test]
    fn no_mode_is_missed() {
        for (faster, stiffer) in [(100.0, 1.0), (0.01, 1.0), (1e6, 1.0), (1.0, 1e4), (1.0, 1e-4), (100.0, 1e-4)] {
            let layers = [layer(0.5, faster, stiffer), layer(0.5, 1.0, 1.0)];
            let exact = Layered::new(layers.to_vec(), 1.0, false, 1e-3 * slow(&layers));
            let compared = exact.modes.iter().zip(on_cells(&layers)).take(8);
            let error = compared.map(|(mode, omega)| (mode.omega / omega - 1.0).abs()).fold(0.0, f64::max);
            assert!(exact.modes.len() > 8 && error < 1e-2, "k x {faster}, M x {stiffer}: {error}");
            let shifted = exact.modes.iter().skip(1).zip(on_cells(&layers)).take(8);
            assert!(shifted.map(|(mode, omega)| (mode.omega / omega - 1.0).abs()).fold(0.0, f64::max) > 0.1);
        }
    }

    #[test]
    fn pressure_and_flux_are_continuous() {
        let layers = vec![layer(0.4, 1e-3, 5.0), layer(0.6, 1.0, 1.0)];
        let exact = Layered::new(layers.clone(), 1e4, false, 1e-5 * slow(&layers));
        let (time, step) = (0.01 * slow(&layers), 1e-6);
        let p = |height: f64| exact.pressure(height, time);
        assert!((p(0.4 - 1e-12) - p(0.4 + 1e-12)).abs() < 1e-6);
        let below = layers[0].mobility * (p(0.4) - p(0.4 - step)) / step;
        let above = layers[1].mobility * (p(0.4 + step) - p(0.4)) / step;
        assert!((below / above - 1.0).abs() < 1e-4, "{below} {above}");
        assert!(p(1.0).abs() < 1e-9 && exact.pressure(0.5, 1e-9 * slow(&layers)).is_nan());
    }
}

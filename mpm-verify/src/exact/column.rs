//! One-dimensional consolidation in general: layers, weight, large strain of either sign, any drainage, loads that grow.
//!
//! Assumptions: no inertia; Cauchy stress `sigma' = sigma'_0 - M ln J` with the stretch J = dy/da of the soil that was at the height
//! a (small strain: `sigma'_0 - M (J - 1)` on the first geometry), or Mohr-Coulomb's bilinear law of the oedometer; k, M,
//! K_w and gravity constant; the total stress is the load and the weight of the soil and the water above. With the pore space
//! `m = J - 1 + n` and the flow `w = -(k/gamma_w) (p_y + rho_w g)`
//!
//! `m d/dt [ln m + p/K_w] = -dw/da`,   `p = q + int_a^H [(1 - n) rho_s + rho_w m] g da - sigma'`
//!
//! (small strain: `d/dt [J + n p/K_w] = -dw/da`). There is no closed form; finite volumes on a mesh that is fine at all ends
//! and interfaces, SDIRK4(3) with error control, and Richardson's extrapolation from two meshes give it to 1e-6, which
//! [`Column::uncertainty`] measures. Where closed forms exist the tests compare with them: Terzaghi, layers, weight, the tables of large strain.
//! What remains in the end is closed: where only the top drains sigma' is the load and the buoyant weight of the grains above, and
//! `S = int (1 - exp(-sigma'/M)) da`.
//!
//! Sources: Gibson, England & Hussey 1967, Geotechnique 17(3); Gibson, Schiffman & Cargill 1981, Can. Geotech. J. 18(2);
//! time: Hairer & Wanner, *Solving Ordinary Differential Equations II*, table IV.6.5.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex, OnceLock, PoisonError};

use mpm_core::hash::{Digest, sha256};
use mpm_core::scene::{Fields, Side, Start, StrainChoice};

use super::oedometer::Oedometer;

/// Cells of the two meshes per layer.
const CELLS: [usize; 2] = [240, 480];
/// Error of a step in z, whose size is a strain, over the largest strain.
const TOLERANCE: f64 = 1e-8;
/// Cells of the coarser mesh in the zone that has drained at the first time.
const IN_ZONE: f64 = 12.0;

/// A column at its sample times.
#[derive(Debug, Clone)]
pub struct Column {
    /// Height H, m.
    pub height: f64,
    times: Vec<f64>,
    meshes: Vec<Arc<Solved>>,
    /// Largest excess pressure under the whole load before anything drains, Pa; that of still water at the base where there is none.
    pub largest_excess: f64,
}

/// What one mesh gives.
#[derive(Debug, Clone)]
struct Solved {
    /// Settlement at every time, m.
    settlements: Vec<f64>,
    /// First height of the cells' middles with the layer of each.
    places: Vec<(f64, usize)>,
    /// Pressures of the cells at every time, Pa.
    pressures: Vec<Vec<f64>>,
    drained: [bool; 2],
}

impl Column {
    /// The column of a scene at its observed times. `None` for one that is dry, that moves in two dimensions, or where the
    /// soil runs out of pores or the equations find no solution.
    pub fn of(scene: &Fields) -> Option<Self> {
        scene.water?;
        if !scene.is_plain_column() || scene.stages.len() != 1 || scene.observe_times.is_empty() {
            return None;
        }
        let meshes = CELLS.iter().map(|cells| Mesh::new(scene, *cells)?.solved()).collect::<Option<_>>()?;
        let mesh = Mesh::new(scene, CELLS[0])?;
        // Undrained under the whole load, whenever it comes.
        let first = mesh.pressures(&mesh.first(mesh.ramp)?, mesh.ramp);
        let still = |middle: f64| mesh.water_weight * (scene.height - middle);
        let excess = mesh.cells.iter().zip(&first).map(|(cell, p)| (p - still(cell.middle)).abs()).fold(0.0, f64::max);
        // Water at rest has none: what round-off leaves of it is measured in the pressure that stands still.
        let still = still(0.0);
        Some(Self {
            height: scene.height,
            times: scene.observe_times.clone(),
            meshes,
            largest_excess: if excess > 1e-6 * still { excess } else { still },
        })
    }

    /// Number of a sample time.
    fn number(&self, time: f64) -> Option<usize> {
        self.times.iter().position(|own| (own - time).abs() <= 1e-9 * own.abs())
    }

    /// Settlement of the surface from the unloaded state at a sample time (s), m; NaN at another.
    pub fn settlement(&self, time: f64) -> f64 {
        self.number(time).map_or(f64::NAN, |i| extrapolated(|mesh| self.meshes[mesh].settlements[i]))
    }

    /// Pore pressure at a sample time (s) in the soil that was at a height (m) at t = 0, Pa.
    pub fn pressure(&self, height: f64, time: f64) -> f64 {
        self.number(time).map_or(f64::NAN, |i| extrapolated(|mesh| self.meshes[mesh].pressure(height, i, self.height)))
    }

    /// How far the two meshes are apart after the extrapolation, a bound of its error: (settlement, pressure), as shares of the
    /// largest settlement and the largest excess pressure.
    pub fn uncertainty(&self) -> (f64, f64) {
        let [coarse, fine] = [&self.meshes[0], &self.meshes[1]];
        let largest = fine.settlements.iter().fold(f64::MIN_POSITIVE, |a: f64, s| a.max(s.abs()));
        let apart = |a: &f64, b: &f64| (a - b).abs() / largest;
        let settled = coarse.settlements.iter().zip(&fine.settlements).map(|(a, b)| apart(a, b)).fold(0.0, f64::max);
        let mut pressed = 0.0_f64;
        for i in 0..self.times.len() {
            for share in [0.1, 0.3, 0.5, 0.7, 0.9] {
                let at = |mesh: &Solved| mesh.pressure(share * self.height, i, self.height);
                pressed = pressed.max((at(coarse) - at(fine)).abs() / self.largest_excess.max(f64::MIN_POSITIVE));
            }
        }
        // The extrapolation takes the leading third of the difference; a tenth of it is left at most.
        (0.1 * settled, 0.1 * pressed)
    }
}

/// Settlement of a column once everything has drained at the top alone, counted from the unloaded state, m: each piece of soil
/// under `load` (Pa) and the buoyant weight above it, `exp(-sigma'/M)` as long where strains are large. Dry soil carries all its weight.
pub fn final_settlement(scene: &Fields, load: f64) -> f64 {
    let submerged = scene.water.map_or(0.0, |water| (1.0 - scene.porosity) * water.density);
    let buoyant = scene.gravity.unwrap_or(0.0) * (scene.dry_density() - submerged);
    let parts = 4000;
    let (mut top, mut settled) = (scene.height, 0.0);
    for (thickness, soil) in scene.by_layer().iter().rev() {
        let law = Law::of(soil);
        for i in 0..parts {
            let depth = scene.height - top + (i as f64 + 0.5) / parts as f64 * thickness;
            settled += law.shortening(load + buoyant * depth, scene.strain) * thickness / parts as f64;
        }
        top -= thickness;
    }
    settled
}

/// From two meshes of second order, the finer one twice as fine.
fn extrapolated(value: impl Fn(usize) -> f64) -> f64 {
    let (coarse, fine) = (value(0), value(1));
    fine + (fine - coarse) / 3.0
}

impl Solved {
    /// By a cubic through four places of the same layer, or the drained end beside it.
    fn pressure(&self, height: f64, time: usize, whole: f64) -> f64 {
        let layer =
            self.places.iter().min_by(|a, b| (a.0 - height).abs().total_cmp(&(b.0 - height).abs())).map_or(0, |p| p.1);
        let own = self.places.iter().zip(&self.pressures[time]).filter(|((_, of), _)| *of == layer);
        let mut points: Vec<(f64, f64)> = own.map(|((place, _), p)| (*place, *p)).collect();
        let top = self.places.last().map_or(0, |place| place.1);
        if self.drained[1] && layer == top {
            points.push((whole, 0.0));
        }
        if self.drained[0] && layer == 0 {
            points.insert(0, (0.0, 0.0));
        }
        let after = points.partition_point(|(place, _)| *place < height);
        let from = after.saturating_sub(2).min(points.len().saturating_sub(4));
        let four = &points[from..points.len().min(from + 4)];
        let weight = |i: usize| {
            let others = four.iter().enumerate().filter(|(j, _)| *j != i);
            others.map(|(_, (place, _))| (height - place) / (four[i].0 - place)).product::<f64>()
        };
        (0..four.len()).map(|i| weight(i) * four[i].1).sum()
    }
}

/// Effective vertical stress over the strain.
#[derive(Debug, Clone, Copy)]
enum Law {
    Elastic { modulus: f64 },
    Plastic { yields: f64, modulus: f64, beyond: f64 },
}

impl Law {
    fn of(soil: &Fields) -> Self {
        let modulus = soil.oedometer_modulus();
        match Oedometer::new(soil) {
            Some(law) if law.yield_pressure.is_finite() => {
                Self::Plastic { yields: law.yield_pressure, modulus, beyond: law.plastic_modulus }
            }
            _ => Self::Elastic { modulus },
        }
    }

    /// Stress (Pa, compression positive) after a compressive strain from a first stress, and its derivative.
    fn stress(&self, first: f64, strain: f64) -> (f64, f64) {
        match *self {
            Self::Elastic { modulus } => (first + modulus * strain, modulus),
            Self::Plastic { yields, modulus, beyond } => {
                let elastic = first + modulus * strain;
                if elastic <= yields {
                    (elastic, modulus)
                } else {
                    (yields + beyond / modulus * (elastic - yields), beyond)
                }
            }
        }
    }

    /// 1 - J under a stress (Pa) from none.
    fn shortening(&self, stress: f64, strain: StrainChoice) -> f64 {
        let compressed = match *self {
            Self::Plastic { yields, modulus, beyond } if stress > yields => {
                yields / modulus + (stress - yields) / beyond
            }
            Self::Elastic { modulus } | Self::Plastic { modulus, .. } => stress / modulus,
        };
        if strain == StrainChoice::Large { -(-compressed).exp_m1() } else { compressed }
    }
}

/// A cell of soil.
#[derive(Debug, Clone, Copy)]
struct Cell {
    /// First height of its middle, and its first size, m.
    middle: f64,
    size: f64,
    layer: usize,
    law: Law,
    /// k/gamma_w, m4/(N s).
    mobility: f64,
    /// sigma'_0, Pa.
    first: f64,
    /// Pore pressure at the start, Pa.
    pressure: f64,
}

/// What one mesh gives, once it is there; nothing where there is no solution.
type Kept = Arc<OnceLock<Option<Arc<Solved>>>>;

/// Solutions by all that they follow from: refinements of one scene share theirs.
static SOLVED: LazyLock<Mutex<HashMap<Digest, Kept>>> = LazyLock::new(Mutex::default);

/// Cells from the base up, what acts on them, and when they are looked at.
#[derive(Debug)]
struct Mesh {
    cells: Vec<Cell>,
    /// Sample times, s.
    times: Vec<f64>,
    /// Settlement from the unloaded state to the start, m.
    settled: f64,
    /// Strain at the end, where the top drains.
    strain: f64,
    drained: [bool; 2],
    porosity: f64,
    /// 1/K_w, 1/Pa.
    compressibility: f64,
    /// Weight of the grains in a first volume, (1 - n) rho_s g, and of water, rho_w g, N/m3.
    grains: f64,
    water_weight: f64,
    large: bool,
    /// Whether the laws are linear, and z and the flow too.
    elastic: bool,
    linear: bool,
    load: f64,
    ramp: f64,
}

/// Stages of SDIRK4(3).
const GAMMA: f64 = 0.25;
const STAGES: [&[f64]; 5] = [
    &[],
    &[0.5],
    &[17.0 / 50.0, -1.0 / 25.0],
    &[371.0 / 1360.0, -137.0 / 2720.0, 15.0 / 544.0],
    &[25.0 / 24.0, -49.0 / 48.0, 125.0 / 16.0, -85.0 / 12.0],
];
const AT: [f64; 5] = [0.25, 0.75, 0.55, 0.5, 1.0];
/// Weights less those of the embedded formula.
const ERROR: [f64; 5] =
    [25.0 / 24.0 - 59.0 / 48.0, -49.0 / 48.0 + 17.0 / 96.0, 125.0 / 16.0 - 225.0 / 32.0, 0.0, GAMMA];

impl Mesh {
    fn new(scene: &Fields, count: usize) -> Option<Self> {
        let water = scene.water?;
        let drained = scene.stages[0].drained;
        let gravity = scene.gravity.unwrap_or(0.0);
        let earliest = scene.observe_times.iter().copied().find(|t| *t > 0.0).unwrap_or(1.0);
        let (mut cells, mut base) = (Vec::new(), 0.0);
        for (layer, (thickness, soil)) in scene.by_layer().iter().enumerate() {
            let mobility = soil.water.map_or(0.0, |w| w.mobility());
            let zone = (mobility * soil.oedometer_modulus() * earliest).sqrt();
            let stretch = stretch(zone / IN_ZONE / thickness * CELLS[0] as f64);
            let edge = |i: usize| {
                let x = 2.0 * i as f64 / count as f64 - 1.0;
                base + 0.5
                    * thickness
                    * if stretch > 0.0 { 1.0 + (stretch * x).tanh() / stretch.tanh() } else { 1.0 + x }
            };
            for i in 0..count {
                let (below, above) = (edge(i), edge(i + 1));
                let middle = 0.5 * (below + above);
                let (first, pressure) = match scene.start {
                    Start::Unloaded | Start::Given => (0.0, 0.0),
                    Start::UndrainedEquilibrium => {
                        let pressure = scene.undrained_pressure_at(middle);
                        (scene.total_stress_at(middle) - pressure, pressure)
                    }
                    Start::Geostatic => {
                        let (buoyant, depth) = (scene.mixture_density() - water.density, scene.height - middle);
                        (buoyant * gravity * depth, water.density * gravity * depth)
                    }
                };
                cells.push(Cell { middle, size: above - below, layer, law: Law::of(soil), mobility, first, pressure });
            }
            base += thickness;
        }
        let large = scene.strain == StrainChoice::Large;
        let drained = [drained[Side::Bottom as usize], drained[Side::Top as usize]];
        let (load, ramp) = scene.surcharge.map_or((0.0, 0.0), |s| (s.pressure, s.ramp_time));
        // Soil at a drained end carries the whole load as soon as it is there.
        let is_empty = |cell: &Cell| cell.law.shortening(load - cell.first, scene.strain) >= scene.porosity;
        let ends = [cells.first()?, cells.last()?];
        if large && scene.observe_times.iter().any(|t| *t >= ramp) && (0..2).any(|i| drained[i] && is_empty(ends[i])) {
            return None;
        }
        let elastic = cells.iter().all(|cell| matches!(cell.law, Law::Elastic { .. }));
        Some(Self {
            cells,
            times: scene.observe_times.clone(),
            settled: scene.first_settlement(),
            strain: final_settlement(scene, load).abs() / scene.height,
            drained,
            porosity: scene.porosity,
            compressibility: 1.0 / water.bulk_modulus,
            grains: scene.dry_density() * gravity,
            water_weight: water.density * gravity,
            large,
            elastic,
            linear: elastic && !large,
            load,
            ramp,
        })
    }

    /// Compressive strain of a stretch, and its derivative.
    fn strain(&self, j: f64) -> (f64, f64) {
        if self.large { (-j.ln(), -1.0 / j) } else { (1.0 - j, -1.0) }
    }

    /// Pore pressures of stretches at a time, Pa.
    fn pressures(&self, j: &[f64], time: f64) -> Vec<f64> {
        let mut state = State::of(j.len());
        self.find(j, time, &mut state);
        state.pressure
    }

    /// Pore pressures of stretches at a time, and how their stresses follow them.
    fn find(&self, j: &[f64], time: f64, state: &mut State) {
        let mut total = if time < self.ramp { self.load * time / self.ramp } else { self.load };
        for (i, cell) in self.cells.iter().enumerate().rev() {
            let pores = if self.large { j[i] - 1.0 + self.porosity } else { self.porosity };
            let half = 0.5 * cell.size * (self.grains + self.water_weight * pores);
            let (strain, by_stretch) = self.strain(j[i]);
            let (stress, by_strain) = cell.law.stress(cell.first, strain);
            state.pressure[i] = total + half - stress;
            state.turn[i] = -by_strain * by_stretch;
            total += 2.0 * half;
        }
    }

    /// z, whose rate is the flow, at a stretch and a pressure; and its derivatives with respect to both.
    fn content(&self, j: f64, p: f64) -> (f64, f64, f64) {
        if self.large {
            let pores = j - 1.0 + self.porosity;
            (pores.ln() + p * self.compressibility, 1.0 / pores, self.compressibility)
        } else {
            (j + self.porosity * p * self.compressibility, 1.0, self.porosity * self.compressibility)
        }
    }

    /// Rates of z from stretches and the pressures found there, and, with respect to the stretches of the cell below, of itself and of
    /// the one above, their derivatives (pressures follow the stretch of their own cell).
    fn rates(&self, j: &[f64], state: &mut State) {
        let count = j.len();
        let State { pressure, turn, flows, rates, slopes, .. } = state;
        // Pressure, way to the face, resistance of it; what the way and the resistance grow by with the stretch.
        let side = |i: usize| {
            let (cell, grows) = (&self.cells[i], f64::from(u8::from(self.large)));
            let way = 0.5 * cell.size * if self.large { j[i] } else { 1.0 };
            (pressure[i], way, way / cell.mobility, 0.5 * cell.size * grows, turn[i], cell.mobility)
        };
        let none = (0.0, 0.0, 0.0, 0.0, 0.0, 1.0);
        let mut low = none;
        // Flow upwards through the faces with its derivatives by the cell below and the one above.
        for (face, flow) in flows.iter_mut().enumerate() {
            let high = if face < count { side(face) } else { none };
            let closed = (face == 0 && !self.drained[0]) || (face == count && !self.drained[1]);
            *flow = if closed {
                [0.0; 3]
            } else {
                let (drive, resistance) = (low.0 - high.0 - self.water_weight * (low.1 + high.1), low.2 + high.2);
                let (over, value) = (1.0 / resistance, drive / resistance);
                let by = |(_, _, _, reach, turn, mobility): (f64, f64, f64, f64, f64, f64), sign: f64| {
                    (sign * turn - self.water_weight * reach - value * reach / mobility) * over
                };
                [value, by(low, 1.0), by(high, -1.0)]
            };
            low = high;
        }
        for i in 0..count {
            let pores = if self.large { j[i] - 1.0 + self.porosity } else { 1.0 };
            let over = 1.0 / (pores * self.cells[i].size);
            rates[i] = (flows[i][0] - flows[i + 1][0]) * over;
            let own = (flows[i][2] - flows[i + 1][1]) * over - if self.large { rates[i] / pores } else { 0.0 };
            slopes[i] = [flows[i][1] * over, own, -flows[i + 1][2] * over];
        }
    }

    /// Moves stretches to where their z is `known + factor rate`, and finds pressures and rates there; `None` if they are not found.
    fn stretches(&self, j: &mut [f64], known: &[f64], factor: f64, time: f64, state: &mut State) -> Option<()> {
        let mut last = f64::INFINITY;
        for _ in 0..60 {
            self.find(j, time, state);
            self.rates(j, state);
            for i in 0..j.len() {
                let (z, by_j, by_p) = self.content(j[i], state.pressure[i]);
                let [low, own, high] = state.slopes[i].map(|s| -factor * s);
                let off = known[i] + factor * state.rates[i] - z;
                state.rows[i] = [low, by_j + by_p * state.turn[i] + own, high, off];
            }
            tridiagonal(&mut state.rows, &mut state.change)?;
            let change = &state.change;
            let largest = change.iter().fold(0.0_f64, |a, c| if c.is_nan() { f64::NAN } else { a.max(c.abs()) });
            if largest.is_nan() {
                return None;
            }
            // Pores never close in one iteration.
            let shrink = j.iter().zip(change).map(|(j, c)| {
                let room = if self.large { j - 1.0 + self.porosity.min(1.0) } else { f64::INFINITY };
                if *c < 0.0 { 0.8 * room / -c } else { f64::INFINITY }
            });
            let share = shrink.fold(1.0, f64::min);
            j.iter_mut().zip(change).for_each(|(j, c)| *j += share * c);
            // What is left is of the order of the square where nothing has a kink.
            let enough = if self.elastic { 1e-8 } else { 1e-14 };
            if self.linear || largest < enough || (largest < 1e-11 && largest >= last) {
                self.find(j, time, state);
                self.rates(j, state);
                return Some(());
            }
            last = largest;
        }
        None
    }

    /// Stretches at t = 0, after whatever of the load of a time comes suddenly and undrained.
    fn first(&self, time: f64) -> Option<Vec<f64>> {
        let known: Vec<f64> = self.cells.iter().map(|cell| self.content(1.0, cell.pressure).0).collect();
        let (mut j, mut state) = (vec![1.0; self.cells.len()], State::of(self.cells.len()));
        self.stretches(&mut j, &known, 0.0, time, &mut state)?;
        Some(j)
    }

    /// The solution, found once.
    fn solved(&self) -> Option<Arc<Solved>> {
        let mut all = SOLVED.lock().unwrap_or_else(PoisonError::into_inner);
        let own = Arc::clone(all.entry(sha256(format!("{self:?}").as_bytes())).or_default());
        drop(all);
        own.get_or_init(|| self.solve().map(Arc::new)).clone()
    }

    fn solve(&self) -> Option<Solved> {
        let mut j = self.first(0.0)?;
        let zeros = || vec![0.0; j.len()];
        let (state, rates) = (State::of(j.len()), std::array::from_fn(|_| zeros()));
        let mut work = Work { state, end: zeros(), known: zeros(), z: zeros(), rates };
        let end = self.times.iter().copied().fold(0.0, f64::max);
        let allowed = TOLERANCE * self.strain.clamp(1e-12, 1.0);
        let mut stops: Vec<f64> = self.times.iter().copied().chain([self.ramp]).filter(|t| *t <= end).collect();
        stops.sort_by(f64::total_cmp);
        stops.dedup();
        let (mut now, mut dt) = (0.0, 1e-9 * end);
        let (mut settlements, mut pressures) = (Vec::new(), Vec::new());
        for stop in stops {
            while now < stop * (1.0 - 1e-13) {
                let step = if now + dt >= stop { stop - now } else { dt.min(0.5 * (stop - now)) };
                let error = self.step(&j, now, step, &mut work).unwrap_or(f64::INFINITY);
                if error <= allowed {
                    j.copy_from_slice(&work.end);
                    now = if step == stop - now { stop } else { now + step };
                }
                let grow = if error.is_finite() {
                    (0.9 * (allowed / error.max(1e-300)).powf(0.25)).clamp(0.2, 4.0)
                } else {
                    0.2
                };
                dt = if error <= allowed { (grow * step).max(dt.min(4.0 * step)) } else { grow * step };
                if dt < 1e-16 * end {
                    return None;
                }
            }
            if self.times.contains(&stop) {
                let settled: f64 = self.cells.iter().zip(&j).map(|(cell, j)| cell.size * (1.0 - j)).sum();
                settlements.push(self.settled + settled);
                pressures.push(self.pressures(&j, stop));
            }
        }
        let places = self.cells.iter().map(|cell| (cell.middle, cell.layer)).collect();
        (settlements.len() == self.times.len()).then_some(Solved {
            settlements,
            places,
            pressures,
            drained: self.drained,
        })
    }

    /// One step of SDIRK4(3) from some stretches: those at its end into `work`, and the estimated error of z.
    fn step(&self, j: &[f64], now: f64, dt: f64, work: &mut Work) -> Option<f64> {
        let Work { state, end, known, z, rates } = work;
        self.find(j, now, state);
        for i in 0..j.len() {
            z[i] = self.content(j[i], state.pressure[i]).0;
        }
        end.copy_from_slice(j);
        for (stage, (weights, at)) in STAGES.iter().zip(AT).enumerate() {
            known.copy_from_slice(z);
            for (weight, rate) in weights.iter().zip(&*rates) {
                known.iter_mut().zip(rate).for_each(|(known, rate)| *known += dt * weight * rate);
            }
            self.stretches(end, known, dt * GAMMA, now + at * dt, state)?;
            rates[stage].copy_from_slice(&state.rates);
        }
        let error = (0..j.len()).map(|i| {
            let scale = if self.large { j[i] - 1.0 + self.porosity } else { 1.0 };
            (dt * scale * ERROR.iter().zip(&*rates).map(|(weight, rate)| weight * rate[i]).sum::<f64>()).abs()
                * self.cells[i].size
        });
        let height: f64 = self.cells.iter().map(|cell| cell.size).sum();
        Some(error.sum::<f64>() / height)
    }
}

/// What stretches mean, cell by cell, and room for Newton's method.
struct State {
    /// Pa, and its change with the stretch that the stress brings, Pa.
    pressure: Vec<f64>,
    turn: Vec<f64>,
    /// Through the faces, with the derivatives by the stretches below and above.
    flows: Vec<[f64; 3]>,
    /// Of z, 1/s, and the derivatives.
    rates: Vec<f64>,
    slopes: Vec<[f64; 3]>,
    rows: Vec<[f64; 4]>,
    change: Vec<f64>,
}

impl State {
    fn of(count: usize) -> Self {
        let zeros = || vec![0.0; count];
        let (flows, slopes, rows) = (vec![[0.0; 3]; count + 1], vec![[0.0; 3]; count], vec![[0.0; 4]; count]);
        Self { pressure: zeros(), turn: zeros(), flows, rates: zeros(), slopes, rows, change: zeros() }
    }
}

/// Room for a step.
struct Work {
    state: State,
    end: Vec<f64>,
    known: Vec<f64>,
    z: Vec<f64>,
    rates: [Vec<f64>; 5],
}

/// Stretch of a mesh over a layer whose first cell is `size` even ones, by bisection.
fn stretch(size: f64) -> f64 {
    // d/dx of tanh(b x)/tanh(b) at the ends is b/(cosh^2 b tanh b).
    let end = |b: f64| 2.0 * b / (2.0 * b).sinh();
    if size >= 1.0 {
        return 0.0;
    }
    let (mut low, mut high) = (1e-3, 5.0);
    for _ in 0..60 {
        let b = 0.5 * (low + high);
        if 2.0 * end(b) > size { low = b } else { high = b }
    }
    low
}

/// Solves rows of (below, own, above, right side).
fn tridiagonal(rows: &mut [[f64; 4]], found: &mut [f64]) -> Option<()> {
    let count = rows.len();
    for i in 1..count {
        let share = rows[i][0] / rows[i - 1][1];
        rows[i][1] -= share * rows[i - 1][2];
        rows[i][3] -= share * rows[i - 1][3];
    }
    let mut above = 0.0;
    for i in (0..count).rev() {
        above = (rows[i][3] - rows[i][2] * above) / rows[i][1];
        found[i] = above;
    }
    found.iter().all(|x| x.is_finite()).then_some(())
}

#[cfg(test)]
mod tests {
    use mpm_core::scene::Surcharge;

    use super::super::large_strain::LargeStrain;
    use super::super::layered::Layered;
    use super::super::self_weight::SelfWeight;
    use super::super::terzaghi::Terzaghi;
    use super::*;
    use mpm_core::scene::Scene;

    fn scene(name: &str) -> Scene {
        crate::scenes::built_in(name)
            .expect("the built-in scene")
            .edited(|scene| scene.history = 0)
            .expect("a sound scene")
    }

    /// Largest differences of settlement and of pressure at five heights from another solution, as shares.
    fn off(scene: &Scene, settlement: &dyn Fn(f64) -> f64, pressure: &dyn Fn(f64, f64) -> f64) -> [f64; 2] {
        let column = Column::of(scene).expect("a column");
        let mut worst = [0.0_f64; 2];
        for time in &scene.observe_times {
            worst[0] = worst[0].max((column.settlement(*time) / settlement(*time) - 1.0).abs());
            for share in [0.03, 0.21, 0.5, 0.77, 0.96] {
                let height = share * scene.height;
                let apart = column.pressure(height, *time) - pressure(height, *time);
                worst[1] = worst[1].max((apart / column.largest_excess).abs());
            }
        }
        println!("{}: {worst:?}, uncertainty {:?}", scene.name, column.uncertainty());
        worst
    }

    #[test]
    fn scenes_of_one_column_share_its_solution_and_each_other_column_has_its_own() {
        let base = scene("terzaghi-quasi-static");
        let of = |edit: &dyn Fn(&mut Fields)| {
            let mut fields = Fields::clone(&base);
            edit(&mut fields);
            Arc::clone(&Column::of(&fields).expect("a column").meshes[0])
        };
        let first = of(&|_| {});
        assert!(Arc::ptr_eq(&first, &of(&|scene| (scene.cell, scene.particles_per_cell) = (0.5 * scene.cell, 9))));
        let others: [&dyn Fn(&mut Fields); 4] = [
            &|scene| scene.surcharge.as_mut().expect("a load").pressure *= 2.0,
            &|scene| scene.porosity += 0.01,
            &|scene| scene.stages[0].drained[Side::Bottom as usize] ^= true,
            &|scene| scene.observe_times.truncate(1),
        ];
        assert!(others.iter().all(|edit| !Arc::ptr_eq(&first, &of(edit))));
    }

    #[test]
    fn it_is_the_closed_form_where_there_is_one() {
        for (name, double) in [("terzaghi-quasi-static", true), ("terzaghi-ramp", false)] {
            let edit = |scene: &mut Fields| {
                scene.strain = StrainChoice::Small;
                scene.stages[0].drained[Side::Bottom as usize] |= double;
            };
            // Explicit soil of small strain is no scene, but has a solution.
            let scene = scene(name).altered_unchecked(edit);
            let exact = Terzaghi::compressible(&scene).expect("a column");
            let worst = off(&scene, &|t| exact.settlement(t), &|y, t| exact.pressure(y, t));
            assert!(worst[0] < 2e-6 && worst[1] < 5e-6, "{name}: {worst:?}");
        }
        let scene_of_layers = scene("layers").altered_unchecked(|scene| scene.strain = StrainChoice::Small);
        let exact = Layered::of(&scene_of_layers).expect("layers");
        let worst = off(&scene_of_layers, &|t| exact.settlement(t), &|y, t| exact.pressure(y, t));
        assert!(worst[0] < 2e-6 && worst[1] < 1e-5, "layers: {worst:?}");
        let heavy = scene("self-weight-consolidation").altered_unchecked(|heavy| heavy.strain = StrainChoice::Small);
        let exact = SelfWeight::new(&heavy).expect("a heavy column");
        let worst = off(&heavy, &|t| exact.settlement(t), &|y, t| exact.pressure(y, t));
        assert!(worst[0] < 2e-6 && worst[1] < 5e-6, "weight: {worst:?}");
    }

    #[test]
    fn it_is_the_table_of_large_strain() {
        for left in [0.8_f64, 0.7] {
            let mut scene = scene("terzaghi-large-strain");
            let pressure = -scene.oedometer_modulus() * left.ln();
            scene = scene
                .edited(|scene| {
                    scene.surcharge = scene.surcharge.map(|s| Surcharge { pressure, ..s });
                    // Enough pores for 30 %: they are in no term of the equation where water does not compress.
                    scene.porosity = 0.6;
                })
                .expect("a sound scene");
            let exact = LargeStrain::new(&scene).expect("the table's column");
            let column = Column::of(&scene).expect("a column");
            for time in &scene.observe_times {
                let off = (column.settlement(*time) - exact.settlement(*time).expect("a row")) / (1.0 - left);
                assert!(off.abs() < column.uncertainty().0 && off.abs() < 1e-6, "{left}: {off:e} at {time} s");
            }
        }
    }

    /// A soft column that its own weight presses by 3.7 %: exact 0.1333 m.
    fn soft() -> Scene {
        let mut soft = scene("self-weight-consolidation")
            .edited(|soft| {
                (soft.height, soft.porosity, soft.strain) = (3.7, 0.43, StrainChoice::Large);
                (soft.grain_density, soft.gravity) = (2650.0, Some(9.81));
                (soft.elastic.youngs_modulus, soft.elastic.poisson_ratio) = (4.3e5, 0.17);
                soft.water = soft.water.map(|water| mpm_core::scene::WaterProperties {
                    hydraulic_conductivity: 2.3e-3,
                    bulk_modulus: 3.1e7,
                    ..water
                });
            })
            .expect("a sound scene");
        let one = soft.time_per_factor().expect("water");
        soft = soft
            .edited(|soft| {
                soft.observe_times = [0.05, 0.5, 6.0].map(|tv| tv * one).to_vec();
                soft.stages[0].until = mpm_core::scene::Until::Time(6.0 * one);
            })
            .expect("a sound scene");
        soft
    }

    #[test]
    fn what_remains_under_weight_and_large_strain_is_closed() {
        let soft = soft();
        let (weight, modulus) = (0.57 * 1650.0 * 9.81, soft.oedometer_modulus());
        let most = weight * soft.height / modulus;
        let closed = soft.height * (1.0 + (-most).exp_m1() / most);
        assert!(
            (final_settlement(&soft, 0.0) / closed - 1.0).abs() < 1e-6 && (closed - 0.1334).abs() < 1e-4,
            "{closed}"
        );
        let column = Column::of(&soft).expect("a column");
        let last = *soft.observe_times.last().expect("a time");
        // The undrained start counts its own strain as a small one, 0.9 % of its stress over M: K_w is soft.
        let off = column.settlement(last) / closed - 1.0;
        assert!(off.abs() < 1e-3, "{off:e}");
        for height in [0.4, 1.9, 3.3] {
            let still = 9810.0 * (soft.height - height) * 0.96;
            assert!((column.pressure(height, last) / still - 1.0).abs() < 0.04);
        }
        // Suction and unloading: the column swells under a load of the other sign.
        let mut pulled =
            scene("terzaghi-quasi-static").edited(|pulled| pulled.strain = StrainChoice::Large).expect("a sound scene");
        let pressure = -0.1 * pulled.oedometer_modulus();
        pulled = pulled
            .edited(|pulled| {
                pulled.surcharge = pulled.surcharge.map(|s| Surcharge { pressure, ..s });
                let end = 5.0 * pulled.time_per_factor().expect("water");
                pulled.observe_times.push(end);
                pulled.stages[0].until = mpm_core::scene::Until::Time(end);
            })
            .expect("a sound scene");
        let column = Column::of(&pulled).expect("a column");
        let last = column.settlement(*pulled.observe_times.last().expect("a time"));
        assert!((last / (1.0 - 0.1_f64.exp()) - 1.0).abs() < 1e-3, "{last}");
    }
}

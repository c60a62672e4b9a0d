//! What two runs say, number by number: units, sizes, and how far apart they may be.

use mpm_core::drive::{Run, Sample};
use mpm_core::scene::{Dimension, Elastic, Fields, Integrator, Scene, SolidSide};

/// Powers of length, mass and time that a number scales with. A scene is 1 m thick: volumes are areas.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// m.
    Length,
    /// m2.
    Area,
    /// Pa.
    Pressure,
    /// m/s.
    Speed,
    /// kg per metre of thickness.
    Mass,
    /// N s per metre of thickness.
    Impulse,
    /// J per metre of thickness.
    Energy,
    /// s.
    Time,
    /// None.
    Number,
}

impl Unit {
    /// A number of this unit in units `length`, `mass` and `time` times as small.
    pub fn in_units(self, value: f64, [length, mass, time]: [f64; 3]) -> f64 {
        let factor = match self {
            Self::Length => length,
            Self::Area => length * length,
            Self::Pressure => mass / (length * time * time),
            Self::Speed => length / time,
            Self::Mass => mass / length,
            Self::Impulse => mass / time,
            Self::Energy => mass * length / (time * time),
            Self::Time => time,
            Self::Number => 1.0,
        };
        value * factor
    }

    /// Whether it is a sum over the soil, which grows with its width.
    fn is_sum(self) -> bool {
        matches!(self, Self::Mass | Self::Impulse | Self::Energy)
    }
}

/// A number of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: Unit,
    /// Its value.
    pub value: f64,
}

/// All numbers of a sample that depend on the state alone; with `exact` those that are differences or counts, too.
pub fn numbers(sample: &Sample, exact: bool) -> Vec<Number> {
    use Unit::{Area, Energy, Impulse, Length, Mass, Number as Pure, Pressure, Speed, Time};
    let (state, l) = (&sample.state, &sample.balance);
    let mut list: Vec<Number> = Vec::new();
    let mut add = |name, unit, value| list.push(Number { name, unit, value });
    add("settlement", Length, state.settlement);
    add("mean pore pressure", Pressure, state.mean_pressure);
    add("pore pressure at the base", Pressure, state.base_pressure);
    add("largest speed", Speed, state.max_speed);
    add("height of the centre", Length, state.centre[1]);
    add("smallest particle", Area, state.least_volume);
    for row in &state.profile {
        add("height of a row", Length, row.height_m);
        add("pore pressure of a row", Pressure, row.pressure_pa);
        add("effective stress of a row", Pressure, row.effective_stress_pa);
    }
    add("dry mass", Mass, l.solid_mass_kg);
    add("water stored", Mass, l.water_stored_kg);
    add("water in less water out", Mass, l.water_in_kg - l.water_out_kg);
    add("momentum", Impulse, l.momentum_n_s);
    add("impulse", Impulse, l.impulse_n_s);
    add("kinetic energy", Energy, l.kinetic_j);
    add("strain energy", Energy, l.strain_j);
    add("energy of the water", Energy, l.water_j);
    add("work of the load", Energy, l.external_work_j);
    add("work of gravity", Energy, l.gravity_work_j);
    add("work on the flow", Energy, l.flow_body_work_j);
    add("loss to flow", Energy, l.darcy_dissipation_j);
    add("loss to damping", Energy, l.damping_loss_j);
    add("plastic dissipation", Energy, l.plastic_dissipation_j);
    if let Some(water) = &state.water {
        add("mobile water", Area, water.mobile_m3);
        add("water that entered", Area, water.in_m3);
        add("water that left", Area, water.out_m3);
    }
    if exact {
        add("time", Time, state.time);
        add("steps", Pure, sample.step as f64);
        add("crossings of soil", Pure, state.solid_crossings as f64);
        add("crossings of water", Pure, state.water_crossings as f64);
        add("checkerboard", Pure, state.checkerboard);
        add("x of the centre", Length, state.centre[0]);
        add("reach", Length, state.reach[0]);
        add("water balance", Mass, l.water_residual_kg);
        add("momentum balance", Impulse, l.momentum_residual_n_s);
        add("energy balance", Energy, l.energy_residual_j);
        add("loss of transfers", Energy, l.transfer_loss_j);
    }
    list
}

/// A difference between two runs beside what is allowed.
#[derive(Debug, Clone, PartialEq)]
pub struct Apart {
    /// Which number, and when.
    pub what: String,
    /// The difference over what is allowed; infinite where nothing is.
    pub ratio: f64,
    /// Both numbers, and the largest difference allowed.
    pub both: [f64; 2],
    /// What is allowed.
    pub allowed: f64,
}

impl Apart {
    /// Two numbers and what may lie between them.
    pub fn new(what: String, both: [f64; 2], allowed: f64) -> Self {
        let gap = (both[0] - both[1]).abs();
        let same = both[0].to_bits() == both[1].to_bits() || gap == 0.0;
        Self { what, ratio: if same { 0.0 } else { gap / allowed }, both, allowed }
    }

    /// Whether the two are further apart than allowed; what is not a number is.
    pub fn too_far(&self) -> bool {
        self.ratio.is_nan() || self.ratio > 1.0
    }

    /// The larger of two differences.
    pub fn worse(self, other: Self) -> Self {
        if other.ratio > self.ratio || other.ratio.is_nan() { other } else { self }
    }

    /// In words.
    pub fn sentence(&self) -> String {
        let [one, other] = self.both;
        format!("{}: {one:e} and {other:e}, {:.2e} apart, allowed {:.2e}", self.what, one - other, self.allowed)
    }
}

/// How large the numbers of a run are, by unit.
#[derive(Debug, Clone)]
pub struct Sizes {
    length: f64,
    area: f64,
    pressure: f64,
    speed: f64,
    mass: f64,
    impulse: f64,
    energy: f64,
}

impl Sizes {
    /// Of a scene and its runs: what load and weight make of it, and what was seen.
    pub fn of(scene: &Scene, samples: &[&[Sample]]) -> Self {
        let area = scene.height * scene.width;
        let load = scene.surcharge.map_or(0.0, |s| s.pressure.abs());
        let weight = scene.gravity.unwrap_or(0.0) * scene.mixture_density() * scene.height;
        let (stress, modulus, density) = (load + weight, scene.oedometer_modulus(), scene.mixture_density());
        let speed = stress / (modulus * density).sqrt() + scene.start_velocity.map_or(0.0, |[x, y]| x.hypot(y));
        let mass = density * area;
        let time = samples.iter().flat_map(|s| s.last()).map(|s| s.state.time).fold(0.0, f64::max);
        let mut sizes = Self {
            length: scene.height + scene.width,
            area,
            pressure: stress,
            speed,
            mass,
            impulse: mass * speed + stress * scene.width * time,
            energy: stress * stress / modulus * area + mass * speed * speed,
        };
        for number in samples.iter().flat_map(|s| s.iter()).flat_map(|s| numbers(s, false)) {
            if let Some(size) = sizes.size_mut(number.unit) {
                *size = size.max(number.value.abs());
            }
        }
        sizes
    }

    fn size_mut(&mut self, unit: Unit) -> Option<&mut f64> {
        Some(match unit {
            Unit::Length => &mut self.length,
            Unit::Area => &mut self.area,
            Unit::Pressure => &mut self.pressure,
            Unit::Speed => &mut self.speed,
            Unit::Mass => &mut self.mass,
            Unit::Impulse => &mut self.impulse,
            Unit::Energy => &mut self.energy,
            Unit::Time | Unit::Number => return None,
        })
    }

    /// The size of a unit.
    pub fn size(&self, unit: Unit) -> f64 {
        self.clone().size_mut(unit).map_or(1.0, |size| *size)
    }
}

/// Least modulus that a load on the surface meets, Pa: that of soil held on both sides, or `E/(1 - nu^2)` beside a free side.
pub fn least_modulus(scene: &Scene) -> f64 {
    let beside = scene.dimension == Dimension::PlaneStrain && scene.solid_sides[..2].contains(&SolidSide::Free);
    let modulus = |(_, soil): &(f64, Fields)| {
        let Elastic { youngs_modulus, poisson_ratio } = soil.elastic;
        if beside { youngs_modulus / (1.0 - poisson_ratio * poisson_ratio) } else { soil.oedometer_modulus() }
    };
    scene.by_layer().iter().map(modulus).fold(f64::INFINITY, f64::min)
}

/// Relative round-off that so many steps of a scene may gather.
///
/// A step is off by half a unit in the last place of each sum it makes: over the particles around a node, and of places,
/// which are known to a share of the whole mesh where a step looks at them in cells. A step within its stability limit
/// makes no error larger, so that they add up. A semi-implicit step may be longer than the limit of its skeleton: pressures
/// take back what its velocities were too large by, but for the last place, `(M + Q) K dt^2/rho` with `K = 4/L^2`. And where
/// water flows easily between cells, their mean pressure is known by what is left of that flow, `k rho/(gamma_w dt)` times it.
/// Soil that may bulge changes its volume by what is left of strains that are `Q/E'` times as large, with the modulus E' of a block.
/// Quasi-static and implicit steps follow from a tolerance, of which runs are sound to a tenfold, and to what waves add up.
pub fn round_off(scene: &Scene, steps: u64, dt: f64) -> f64 {
    if scene.integrator.solves_displacements() {
        // A step may be off by a tenth of the tolerance, and waves keep it.
        let waves = if scene.integrator == Integrator::Implicit { 0.1 * steps as f64 } else { 0.0 };
        return (10.0 + waves) * scene.tolerance;
    }
    let cells = scene.cells[0] + scene.cells[1] + scene.empty_cells_above + scene.empty_cells_beside;
    let terms = (4 * scene.particles_per_cell + cells) as f64;
    let water = if scene.pore_stiffness().is_finite() { scene.pore_stiffness() } else { 0.0 };
    let bulges = 1.0 + water / least_modulus(scene);
    let bulges = if scene.solid_sides[..2].contains(&SolidSide::Free) { bulges } else { 1.0 };
    let long = if scene.integrator == Integrator::SemiImplicit {
        let soils = scene.by_layer();
        let most = |of: fn(&Fields) -> f64| soils.iter().map(|(_, soil)| of(soil)).fold(0.0, f64::max);
        let rate = (most(Fields::oedometer_modulus) + water) / scene.mixture_density();
        let flow = most(|soil| soil.water.map_or(0.0, |water| water.mobility())) * scene.mixture_density() / dt;
        (1.0 + 4.0 * rate * (dt / scene.cell).powi(2)) * (1.0 + flow)
    } else {
        1.0
    };
    let flow = if scene.free_surface.is_some() { OF_FLOW } else { 0.0 };
    flow + f64::EPSILON * terms * (steps + 1) as f64 * long * bulges
}

/// Which of two cells that fill together is full first, round-off decides: steps end 1e-6 of them behind a front, and change half of
/// the water of a cell at most.
const OF_FLOW: f64 = 0.5e-6;

/// Numbers that the tolerance of a quasi-static run is about, and those that are sums of them.
fn is_controlled(number: &Number) -> bool {
    matches!(number.unit, Unit::Length | Unit::Pressure | Unit::Area)
        || number.name.contains("mass")
        || number.name == "water stored"
}

/// The largest difference of two runs whose samples are of the same times, relative to the sizes of their numbers. Of a column
/// and a `block`, so many times as wide, sums over the soil of the second are divided by that, and particles are others.
pub fn apart(scene: &Scene, one: &[Sample], other: &[Sample], block: Option<f64>, relative: f64) -> Apart {
    let wider = block.unwrap_or(1.0);
    let sizes = Sizes::of(scene, &[one]);
    let implicit = scene.integrator.solves_displacements();
    let mut worst = Apart::new("samples".to_owned(), [one.len() as f64, other.len() as f64], 0.0);
    for (a, b) in one.iter().zip(other) {
        let pairs = numbers(a, false).into_iter().zip(numbers(b, false));
        for (x, y) in pairs {
            let value = if y.unit.is_sum() { y.value / wider } else { y.value };
            let value = if y.name.contains("water") && y.unit == Unit::Area { value / wider } else { value };
            if (x.name == "smallest particle" && block.is_some()) || (implicit && !is_controlled(&x)) {
                continue;
            }
            let what = format!("{} at {:.3e} s", x.name, a.state.time);
            worst = worst.worse(Apart::new(what, [x.value, value], relative * sizes.size(x.unit)));
        }
        let rows = [a.state.profile.len(), b.state.profile.len()].map(|rows| rows as f64);
        worst = worst.worse(Apart::new("rows of the profile".to_owned(), rows, 0.0));
    }
    worst
}

/// All that a run says, as text. What lists have in reserve is no result.
pub fn said(run: &Run) -> String {
    format!("{:?}", Run { bytes: 0, ..run.clone() })
}

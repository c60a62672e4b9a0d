//! Random scenes that make sense: sizes over six decades, stiffness over five, conductivity over ten, loads of both signs,
//! every integrator and shape. A scene is a pure function of a seed and a number.

use mpm_core::random::Random;
use mpm_core::stability::choose_step;

use super::written::{FreeSurface, Layer, Load, Soil, Stage, Water, Written};

/// Random sizes and choices.
#[derive(Debug, Clone)]
pub struct Dice(Random);

impl Dice {
    /// Those of a seed and a number.
    pub fn new(seed: u64, index: u64) -> Self {
        let state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ index.wrapping_mul(0xd1b5_4a32_d192_ed03);
        let mut random = Random(state);
        random.bits();
        Self(random)
    }

    /// 0 <= x < 1.
    pub fn unit(&mut self) -> f64 {
        self.0.unit()
    }

    /// A whole number from `low` to `high`.
    pub fn whole(&mut self, low: usize, high: usize) -> usize {
        low + (self.unit() * (high - low + 1) as f64) as usize
    }

    /// A number from `low` to `high`, with three digits.
    fn even(&mut self, low: f64, high: f64) -> f64 {
        digits(low + (high - low) * self.unit())
    }

    /// The same, evenly over the decades.
    pub fn decades(&mut self, low: f64, high: f64) -> f64 {
        digits(low * (high / low).powf(self.unit()))
    }

    fn chance(&mut self, share: f64) -> bool {
        self.unit() < share
    }

    fn pick<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.whole(0, list.len() - 1)]
    }
}

/// Three digits of a number, as a person would write it.
pub fn digits(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap_or(x)
}

/// Particle steps of a run at most.
const POINT_STEPS: f64 = 20_000.0;
/// Steps of a run at most, and at least.
const STEPS: [f64; 2] = [20.0, 2000.0];
/// Strain under load and weight at most.
const MOST_STRAIN: f64 = 0.08;

/// Scene number `index` of a seed.
pub fn scene(seed: u64, index: u64) -> Written {
    let mut dice = Dice::new(seed, index);
    let dice = &mut dice;
    let what = dice.whole(0, 99);
    let mut w = match what {
        0..=49 => explicit(dice),
        50..=66 => semi_implicit(dice),
        67..=81 => quasi_static(dice),
        82..=88 => implicit(dice),
        89..=94 => outline(dice),
        _ => free_surface(dice),
    };
    times(&mut w, dice);
    w
}

/// What all scenes have: a mesh, soil, perhaps water and gravity, sides.
fn ground(dice: &mut Dice, wet: bool) -> Written {
    let plane = dice.chance(0.5);
    let rows = dice.whole(4, 16);
    let cells = [if plane { dice.whole(2, 6) } else { 1 }, rows];
    let cell = digits(dice.decades(1e-3, 1e3) / rows as f64);
    let soil = Soil {
        youngs_modulus: dice.decades(1e4, 1e9),
        poisson_ratio: dice.even(0.0, 0.48),
        strength: None,
        grain_density: dice.even(1500.0, 3500.0),
        by_bulk_density: false,
        porosity: dice.even(0.1, 0.7),
        small: false,
    };
    let g = if dice.chance(0.7) { 9.81 } else { dice.decades(0.1, 500.0) };
    let water = wet.then(|| {
        let density = dice.even(800.0, 1200.0);
        Water {
            conductivity: dice.decades(1e-12, 1e-2),
            viscosity: None,
            bulk_modulus: dice.decades(1e6, 1e10),
            unit_weight: density * g,
            density,
            free: None,
        }
    });
    let mut sides = ["roller", "roller", dice.pick(&["fixed", "roller"]), "free"];
    if plane && dice.chance(0.35) {
        let any = ["roller", "fixed", "free"];
        (sides[0], sides[1]) = (dice.pick(&any), dice.pick(&any));
    }
    let mut w = Written {
        plane,
        start: "unloaded",
        gravity: None,
        outline: None,
        cell,
        cells,
        column_width: dice.decades(1e-2, 1e2),
        per_direction: dice.whole(1, 3),
        empty_above: if dice.chance(0.4) { dice.whole(1, 3) } else { 0 },
        empty_beside: 0,
        soil,
        layers: Vec::new(),
        water,
        sides,
        load: None,
        shape: None,
        darcy: None,
        darcy_inertia: None,
        flip: None,
        light_nodes: None,
        transfer: None,
        update: None,
        quadrature: None,
        jump_penalty: None,
        integrator: "explicit",
        tolerance: None,
        waves: None,
        method: None,
        step: None,
        stages: Vec::new(),
        observed: Vec::new(),
    };
    if dice.chance(0.45) && weight_strain(&w, g) < MOST_STRAIN {
        w.gravity = Some(g);
    }
    if dice.chance(0.85) || w.gravity.is_none() {
        load(&mut w, dice);
    }
    if dice.chance(0.15) {
        layers(&mut w, dice);
    }
    start(&mut w, dice);
    stages(&mut w, dice);
    w
}

fn oedometer(w: &Written) -> f64 {
    let (e, nu) = (w.soil.youngs_modulus, w.soil.poisson_ratio);
    e * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))
}

fn mixture_density(w: &Written) -> f64 {
    (1.0 - w.soil.porosity) * w.soil.grain_density + w.water.as_ref().map_or(0.0, |a| w.soil.porosity * a.density)
}

fn weight_strain(w: &Written, g: f64) -> f64 {
    mixture_density(w) * g * w.height() / oedometer(w)
}

fn load(w: &mut Written, dice: &mut Dice) {
    let sign = if dice.chance(0.3) { -1.0 } else { 1.0 };
    let pressure = sign * digits(dice.decades(1e-7, MOST_STRAIN) * oedometer(w));
    let on = dice.pick(&["surface", "surface", "surface", "particles", "plate"]);
    // Ends of a strip lie inside cells and between particles, where no round-off decides.
    let strip = (w.plane && on != "plate" && dice.chance(0.4)).then(|| {
        let first = dice.whole(0, w.cells[0] - 1);
        let last = dice.whole(first, w.cells[0] - 1);
        let taper = if dice.chance(0.5) { dice.even(0.1, 1.5) * w.cell } else { 0.0 };
        [(first as f64 + 0.21) * w.cell, (last as f64 + 0.83) * w.cell, taper]
    });
    if on == "plate" {
        w.empty_above = 0;
    }
    w.load = Some(Load { pressure, on, ramp: 0.0, strip });
}

fn layers(w: &mut Written, dice: &mut Dice) {
    let lower = dice.whole(1, w.cells[1] - 1);
    for rows in [lower, w.cells[1] - lower] {
        let (stiffness, conductivity) = (dice.decades(0.3, 30.0), dice.decades(1e-3, 1e3));
        w.layers.push(Layer { rows, stiffness, conductivity });
    }
}

fn start(w: &mut Written, dice: &mut Dice) {
    let whole = w.load.as_ref().is_some_and(|load| load.strip.is_none());
    let free = w.sides[..2].contains(&"free");
    if w.water.is_some() && !free && (whole || (w.load.is_none() && w.gravity.is_some())) && dice.chance(0.35) {
        w.start = "undrained-equilibrium";
    } else if w.gravity.is_some() && !free && dice.chance(0.5) {
        w.start = "geostatic";
    }
}

fn stages(w: &mut Written, dice: &mut Dice) {
    let ways: &[[bool; 4]] = &[
        [false, false, false, true],
        [false, false, false, true],
        [false, false, false, true],
        [false, false, true, true],
        [false, false, true, false],
        [false; 4],
        [true, false, false, false],
        [false, true, false, true],
    ];
    let ways = if w.plane { ways } else { &ways[..6] };
    for _ in 0..if dice.chance(0.3) { 2 } else { 1 } {
        let drained = if w.water.is_some() { dice.pick(ways) } else { [false; 4] };
        w.stages.push(Stage { drained, damping: 0.0, coupling: None, time: 1.0, per_factor: None });
    }
}

/// Damping of all stages, as a share of the frequency of the column.
fn damping(w: &mut Written, dice: &mut Dice) {
    let frequency = (oedometer(w) / mixture_density(w)).sqrt() / w.height();
    for stage in &mut w.stages {
        if dice.chance(0.3) {
            stage.damping = digits(frequency * dice.decades(0.03, 10.0));
        }
    }
}

fn explicit(dice: &mut Dice) -> Written {
    let wet = dice.chance(0.6);
    let mut w = ground(dice, wet);
    if dice.chance(0.15) && w.layers.is_empty() {
        let cohesion = digits(oedometer(&w) * dice.decades(1e-5, 1e-2));
        let friction = dice.even(10.0, 45.0);
        w.soil.strength = Some([cohesion, friction, if dice.chance(0.5) { 0.0 } else { friction / 2.0 }]);
    }
    let shapes = ["centre", "centre", "linear", "b-bar", "gimp", "bspline2", "centroid"];
    w.shape = (!dice.chance(0.2)).then(|| dice.pick(&shapes));
    if w.shape == Some("centroid") {
        w.layers.clear();
    }
    if wet && matches!(w.shape, Some("centre" | "linear")) && w.layers.is_empty() && dice.chance(0.25) {
        w.darcy = Some("nodal");
    }
    w.darcy_inertia = (wet && dice.chance(0.2)).then_some(false);
    w.flip = dice.chance(0.25).then(|| dice.pick(&[0.0, 0.9, 0.99, 0.95]));
    w.transfer = dice.chance(0.1).then_some("affine");
    w.update = dice.chance(0.1).then_some("musl");
    w.quadrature = dice.chance(0.15).then_some("volumes");
    if w.plane && !wet && w.layers.is_empty() && !matches!(w.shape, Some("gimp" | "bspline2")) && dice.chance(0.25) {
        (w.sides[0], w.sides[1]) = ("periodic", "periodic");
        // Room for the load to be moved by one cell.
        if let Some(load) = w.load.as_mut().filter(|load| load.on != "plate") {
            w.cells[0] = w.cells[0].max(3);
            load.strip = Some([0.21 * w.cell, 1.43 * w.cell, 0.3 * w.cell]);
            if w.start == "undrained-equilibrium" {
                w.start = "unloaded";
            }
        }
    }
    damping(&mut w, dice);
    w
}

fn semi_implicit(dice: &mut Dice) -> Written {
    let mut w = ground(dice, true);
    w.integrator = "semi-implicit";
    w.shape = (!dice.chance(0.2)).then(|| dice.pick(&["centre", "centre", "linear", "b-bar", "gimp", "bspline2"]));
    w.darcy_inertia = dice.chance(0.2).then_some(false);
    w.flip = dice.chance(0.25).then(|| dice.pick(&[0.0, 0.9, 0.99]));
    w.quadrature = dice.chance(0.15).then_some("volumes");
    incompressible(&mut w, dice);
    damping(&mut w, dice);
    w
}

fn incompressible(w: &mut Written, dice: &mut Dice) {
    if let (Some(water), true) = (&mut w.water, dice.chance(0.2)) {
        water.bulk_modulus = f64::INFINITY;
    }
}

fn quasi_static(dice: &mut Dice) -> Written {
    let wet = dice.chance(0.85);
    let mut w = ground(dice, wet);
    w.integrator = "quasi-static";
    w.shape = (!dice.chance(0.2)).then(|| dice.pick(&["centre", "centre", "linear", "gimp", "bspline2", "bspline2"]));
    if w.shape == Some("bspline2") {
        w.per_direction = w.per_direction.max(2);
        w.quadrature = dice.chance(0.15).then_some("volumes");
    }
    w.soil.small = !w.layers.is_empty() || dice.chance(0.6);
    w.tolerance = dice.chance(0.7).then(|| dice.pick(&[1e-3, 1e-5, 1e-6, 1e-7]));
    incompressible(&mut w, dice);
    w
}

fn implicit(dice: &mut Dice) -> Written {
    let wet = dice.chance(0.85);
    let mut w = ground(dice, wet);
    w.integrator = "implicit";
    w.shape = dice.chance(0.5).then_some("bspline2");
    w.per_direction = w.per_direction.max(2);
    w.darcy_inertia = (wet && dice.chance(0.2)).then_some(false);
    w.quadrature = dice.chance(0.15).then_some("volumes");
    w.soil.small = !w.layers.is_empty() || dice.chance(0.5);
    w.tolerance = dice.chance(0.7).then(|| dice.pick(&[1e-3, 1e-4, 1e-5]));
    w.waves = dice.pick(&[None, Some("resolved"), Some("damped")]);
    incompressible(&mut w, dice);
    damping(&mut w, dice);
    w
}

/// A dam of dry soil, away from all walls.
fn outline(dice: &mut Dice) -> Written {
    let mut w = ground(dice, false);
    w.plane = true;
    (w.start, w.load, w.gravity) = ("unloaded", None, Some(9.81));
    w.layers.clear();
    w.cells[1] = w.cells[1].min(6);
    let rows = w.cells[1] as f64;
    let left = dice.even(0.1, 0.9);
    let top = [left + dice.even(0.3, 1.0) * rows, dice.even(1.2, 3.0)];
    let toe = top[0] + top[1] + dice.even(0.3, 1.0) * rows;
    let height = rows - dice.even(0.05, 0.6);
    let points = [[left, 0.0], [toe, 0.0], [top[0] + top[1], height], [top[0], height]];
    w.outline = Some(points.map(|x| x.map(|x| x * w.cell)).to_vec());
    w.cells[0] = (toe * (1.0 - 1e-9)).ceil() as usize;
    (w.empty_above, w.empty_beside) = (1, dice.whole(1, 2));
    w.sides = ["free", "free", "fixed", "free"];
    // A load of its own weight must not be more than it bears.
    let most = MOST_STRAIN / weight_strain(&w, 9.81);
    w.soil.youngs_modulus = digits(w.soil.youngs_modulus * (1.0 / most).max(1.0) * 4.0);
    w.shape = Some(dice.pick(&["centre", "centroid", "linear", "b-bar"]));
    if dice.chance(0.5) {
        let cohesion = digits(mixture_density(&w) * 9.81 * w.height() * dice.decades(0.01, 1.0));
        w.soil.strength = Some([cohesion, dice.even(15.0, 40.0), 0.0]);
    }
    w.flip = dice.chance(0.25).then(|| dice.pick(&[0.9, 0.99]));
    damping(&mut w, dice);
    w
}

/// Water that wets soil at rest.
fn free_surface(dice: &mut Dice) -> Written {
    let mut w = ground(dice, true);
    w.layers.clear();
    (w.start, w.load) = ("unloaded", None);
    w.integrator = "staggered";
    w.shape = Some(dice.pick(&["centre", "linear"]));
    w.sides = ["roller", "roller", "fixed", "free"];
    w.stages.truncate(1);
    w.empty_above = 0;
    let (height, plane) = (w.height(), w.plane);
    let Some(water) = &mut w.water else { return w };
    water.conductivity = dice.decades(1e-8, 1e-2);
    let mut heads = [None; 4];
    let side = if plane { dice.pick(&[0, 1, 2]) } else { 2 };
    heads[side] = Some(digits(height * dice.even(0.2, 0.95)));
    let level = dice.chance(0.4).then(|| digits(height * dice.even(0.1, 0.9)));
    water.free = Some(FreeSurface { saturation: dice.pick(&[0.0, 0.1, 0.3]), level, heads });
    let across = if side == 0 { 1 } else { 0 };
    w.stages[0].drained = [false; 4];
    w.stages[0].drained[across] = plane && side != 2 && dice.chance(0.6);
    w
}

/// How long stages last: as many steps as a run may have; times over four decades where a run has no steps of its own.
fn times(w: &mut Written, dice: &mut Dice) {
    w.observed = vec![1.0];
    let step = w.scene().ok().and_then(|scene| choose_step(&scene).ok().map(|step| (step, scene.solid_particles())));
    let time = match (step, &w.water) {
        (Some((step, particles)), _) if step.is_finite() && w.integrator != "staggered" => {
            let most = (POINT_STEPS / particles as f64).clamp(STEPS[0] * 2.0, STEPS[1]);
            dice.decades(STEPS[0], most) * step
        }
        (_, Some(water)) if water.free.is_some() => {
            dice.decades(1e-2, 3.0) * w.soil.porosity * w.height() / water.conductivity
        }
        (_, Some(water)) => {
            let diffusivity = water.conductivity / water.unit_weight * oedometer(w);
            dice.decades(1e-3, 10.0) * w.height() * w.height() / diffusivity
        }
        _ => 1.0,
    };
    let count = w.stages.len() as f64;
    for stage in &mut w.stages {
        stage.time = digits(time / count);
    }
    let last = w.stages.last().map_or(1.0, |stage| stage.time);
    w.observed = vec![digits(0.3 * last), digits(0.7 * last), last];
    let level = w.load.as_ref().is_some_and(|load| load.strip.is_none());
    let Some(load) = &mut w.load else { return };
    if dice.chance(0.4) && !(w.start == "undrained-equilibrium" && level) {
        load.ramp = digits(time * dice.even(0.05, 1.2));
    }
}

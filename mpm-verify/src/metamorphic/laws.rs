//! Metamorphic relations: what must hold between the runs of a scene and of a changed one, whatever the answer is. One function each.

use std::time::Instant;

use mpm_core::drive::{Monitor, Run, Sample, Wish};
use mpm_core::hardware::{Hardware, Width};
use mpm_core::run::run_monitored;
use mpm_core::scene::{Dimension, Feed, Fields, Integrator, Quadrature, Scene, ShapeChoice, StrainChoice};
use mpm_core::stability::stable_limit;

use super::scenes::Dice;
use super::seen::{Apart, Sizes, Unit, apart, least_modulus, numbers, round_off, said};
use super::written::{Layer, Load, Written};
use crate::error::Error;

/// A scene with its run.
pub struct Base<'a> {
    /// As it is written.
    pub written: &'a Written,
    /// As it was read.
    pub scene: &'a Scene,
    /// As it was run.
    pub run: &'a Run,
    /// Planted in the changed scene to see that the relation can fail.
    pub fault: fn(&mut Written),
}

/// What a relation says of a scene.
#[derive(Debug, Clone, PartialEq)]
pub enum Verdict {
    /// It does not concern the scene.
    Apart,
    /// The changed scene was refused or did not come to its end.
    Unfinished(String),
    /// How far apart the runs are.
    Compared(Apart),
}

/// A relation.
#[derive(Debug, Clone, Copy)]
pub struct Law {
    /// Its name.
    pub name: &'static str,
    /// What it says.
    pub about: &'static str,
    /// Holds it against a scene.
    pub check: fn(&Base) -> Verdict,
}

/// All relations.
pub const LAWS: [Law; 12] = [
    Law { name: "mirrored", about: "left for right gives the same run", check: mirrored },
    Law { name: "shifted", about: "moved sideways by a cell gives the same run", check: shifted },
    Law { name: "room", about: "one row of empty cells more changes nothing", check: room },
    Law { name: "units", about: "in other units the same bits", check: units },
    Law { name: "plane", about: "a column and plane strain give the same run", check: plane },
    Law { name: "stages", about: "one stage and two of the same give the same run", check: stages },
    Law { name: "superposed", about: "answers of a linear scene add up", check: superposed },
    Law { name: "sign", about: "small pull is the opposite of small push", check: sign },
    Law { name: "words", about: "the same soil and water said in other words", check: words },
    Law { name: "refined", about: "half the mesh changes less than it did before", check: refined },
    Law { name: "threads", about: "the same bits on any threads and widths", check: threads },
    Law { name: "resumed", about: "the same bits stopped and resumed", check: resumed },
];

/// Runs a changed scene to its end.
fn ran(base: &Base, mut written: Written) -> Result<(Scene, Run), Verdict> {
    (base.fault)(&mut written);
    finished(&written)
}

/// A run that takes longer is stopped, s: scenes are chosen to take some hundredths.
const PATIENCE: f64 = 5.0;

/// Stops a run that takes too long.
struct Patient(Instant);

impl Monitor for Patient {
    fn look(&mut self, _: f64) -> Wish {
        if self.0.elapsed().as_secs_f64() > PATIENCE { Wish::Stop } else { Wish::GoOn }
    }

    fn save(&mut self, _: Vec<u8>) {}
}

/// A run of a scene.
///
/// # Errors
/// It was refused ([`Error::Of`]), or takes too long.
pub fn run_of(hardware: &Hardware, scene: &Scene) -> Result<Run, Error> {
    match run_monitored(hardware, scene, None, &mut Patient(Instant::now())) {
        Ok(run) if run.stopped => Err(Error::Found(format!("stopped after {PATIENCE} s"))),
        Ok(run) => Ok(run),
        Err(e) => Err(Error::from(e).of("refused")),
    }
}

impl From<Error> for Verdict {
    fn from(why: Error) -> Self {
        Self::Unfinished(why.to_string())
    }
}

fn read(written: &Written) -> Result<Scene, Error> {
    written.scene().map_err(|e| Error::from(e).of("refused"))
}

fn finished(written: &Written) -> Result<(Scene, Run), Verdict> {
    let scene = read(written)?;
    let run = run_of(&Hardware::default(), &scene)?;
    Ok((scene, run.whole().map_err(Error::from)?))
}

/// The verdict of a comparison that may not come to its end.
fn verdict(compared: Result<Apart, Verdict>) -> Verdict {
    compared.map_or_else(|other| other, Verdict::Compared)
}

/// A change that the scene must bear: what is refused, or fails, is a difference. Whether a system that is singular but for a few
/// digits is still solved, round-off decides.
fn strictly(verdict: Verdict) -> Verdict {
    match verdict {
        Verdict::Unfinished(why) if why.contains("a singular system") => Verdict::Unfinished(why),
        Verdict::Unfinished(why) => Verdict::Compared(Apart::new(why, [0.0, 1.0], 0.0)),
        other => other,
    }
}

/// What round-off allows to the run of a scene.
fn allowed(base: &Base) -> f64 {
    round_off(base.scene, base.run.steps, base.run.dt)
}

/// The run of a changed scene beside that of the scene itself, to round-off.
fn same(base: &Base, changed: Written) -> Verdict {
    let compared =
        ran(base, changed).map(|(_, run)| apart(base.scene, &base.run.samples, &run.samples, None, allowed(base)));
    verdict(compared)
}

fn mirrored(base: &Base) -> Verdict {
    if !base.written.plane {
        return Verdict::Apart;
    }
    strictly(same(base, base.written.mirrored()))
}

/// An outline with its mesh, or the load of soil that is periodic.
fn shifted(base: &Base) -> Verdict {
    let mut changed = base.written.clone();
    let cell = changed.cell;
    // Sides hold the nodes of their cells, and so soil that is no further away.
    let held = |points: &[[f64; 2]]| changed.sides[0] != "free" && points.iter().any(|x| x[0] < cell);
    if changed.outline.as_deref().is_some_and(held) {
        return Verdict::Apart;
    }
    if let Some(points) = &mut changed.outline {
        points.iter_mut().for_each(|x| x[0] += cell);
        changed.cells[0] += 1;
    } else if changed.sides[0] == "periodic" {
        let width = changed.width();
        match changed.load.as_mut().and_then(|load| load.strip.as_mut()) {
            Some(strip) if strip[1] + strip[2] + cell < width => {
                strip[0] += cell;
                strip[1] += cell;
            }
            _ => return Verdict::Apart,
        }
    } else {
        return Verdict::Apart;
    }
    strictly(same(base, changed))
}

fn room(base: &Base) -> Verdict {
    let mut changed = base.written.clone();
    let plate = changed.load.as_ref().is_some_and(|load| load.on == "plate");
    // B-splines reach as many cells as their degree, and are others at the end of the mesh; uGIMP has another surface with room
    // above.
    let gimp = usize::from(base.scene.shape == ShapeChoice::Gimp);
    let wide = changed.empty_above < base.scene.shape.spline_degree().unwrap_or(gimp);
    // Above water with a free surface there is a side of the mesh, or air.
    let air = base.scene.free_surface.is_some() && changed.empty_above == 0;
    if plate || wide || air || changed.sides[3] != "free" {
        return Verdict::Apart;
    }
    changed.empty_above += 1;
    strictly(same(base, changed))
}

/// Powers of four, whose products and roots are exact.
fn units(base: &Base) -> Verdict {
    let mut dice = Dice::new(base.run.steps, base.scene.cells[1] as u64);
    let factors = [(); 3].map(|()| 4.0_f64.powi(dice.whole(0, 12) as i32 - 6));
    let compared = ran(base, base.written.in_units(factors)).map(|(_, run)| {
        let lengths = [base.run.samples.len() as f64, run.samples.len() as f64];
        let mut worst = Apart::new("samples".to_owned(), lengths, 0.0);
        for (a, b) in base.run.samples.iter().zip(&run.samples) {
            for (x, y) in numbers(a, true).into_iter().zip(numbers(b, true)) {
                let what = format!("{} at {:.3e} s, units {factors:?}", x.name, a.state.time);
                worst = worst.worse(Apart::new(what, [x.unit.in_units(x.value, factors), y.value], 0.0));
            }
        }
        worst
    });
    strictly(verdict(compared))
}

/// Steps of a column in plane strain at most.
const MOST_STEPS: f64 = 2000.0;

/// The same steps in both, within the limit of both.
fn plane(base: &Base) -> Verdict {
    // A share of a full node's mass is another one at a side, where nodes have half of it: there soil is not one-dimensional. Nor
    // where splines at a side are so light that they are lent inertia.
    let lent = base.scene.shape.spline_degree().is_some()
        && !base.scene.integrator.solves_displacements()
        && base.scene.moves_through_cells();
    if base.written.plane || base.written.integrator == "staggered" || base.scene.light_nodes > 0.0 || lent {
        return Verdict::Apart;
    }
    // In two dimensions fewer than nine particles are not weighed as rows of them are, nor the loads that they carry; and
    // volumes as weights are off by as much along x as along y, the load on the surface is not.
    let splines = base.scene.integrator.solves_displacements() && base.scene.shape.spline_degree().is_some();
    let on_particles = base.written.load.as_ref().is_some_and(|load| load.on == "particles");
    let volumes = base.scene.quadrature == Quadrature::Volumes;
    if splines && (base.written.per_direction < 3 || on_particles || volumes) {
        return Verdict::Apart;
    }
    let compared = || {
        let mut column = base.written.clone();
        column.shape = Some(base.scene.shape.word());
        if base.scene.integrator.solves_displacements()
            && base.scene.shape.spline_degree().is_some()
            && column.water.is_some()
        {
            column.jump_penalty = Some(base.scene.usual_jump_penalty());
        }
        let mut block = Written { plane: true, cells: [3, column.cells[1]], ..column.clone() };
        if !base.scene.integrator.solves_displacements() {
            let (one, other) = (read(&column)?, read(&block)?);
            let step = 0.9 * stable_limit(&one).min(stable_limit(&other));
            (column.step, block.step) = (Some(step), Some(step));
            // Shear, which a column does not have, may want steps so short that the run would have no end.
            let whole: f64 = column.stages.iter().map(|stage| stage.time).sum();
            let share = (MOST_STEPS * step / whole).min(1.0);
            [&mut column, &mut block].into_iter().for_each(|w| w.shorten(share));
        }
        let (scene, one) = finished(&column)?;
        let (_, other) = ran(base, block.clone())?;
        let relative = round_off(&scene, one.steps, one.dt);
        Ok(apart(&scene, &one.samples, &other.samples, Some(block.width() / column.width()), relative))
    };
    verdict(compared())
}

/// Samples of the end of a run, and at its first observed time, wherever they stand.
fn at(run: &Run, times: &[f64]) -> Vec<Sample> {
    let near = |time: f64| {
        let off = |s: &&Sample| (s.state.time - time).abs();
        run.samples.iter().min_by(|a, b| off(a).total_cmp(&off(b))).cloned()
    };
    times.iter().filter_map(|time| near(*time)).collect()
}

fn stages(base: &Base) -> Verdict {
    let mut changed = base.written.clone();
    if base.scene.integrator.solves_displacements() && base.scene.shape.spline_degree().is_some() {
        changed.jump_penalty = changed.water.is_some().then(|| base.scene.usual_jump_penalty()); // that of the first time
    }
    // Whether waves are resolved follows from the first time that a stage is asked for; where they are damped the first steps of every
    // stage are not checked.
    if base.scene.integrator == Integrator::Implicit && base.written.waves != Some("resolved") {
        return Verdict::Apart;
    }
    let Some(last) = changed.stages.last_mut() else { return Verdict::Apart };
    let (first, end) = (changed.observed[0], last.time);
    if changed.observed.len() < 2 {
        return Verdict::Apart;
    }
    last.time = first;
    last.per_factor = None;
    let mut second = last.clone();
    second.time = end - first;
    changed.stages.push(second);
    changed.observed = changed.observed[1..].iter().map(|time| time - first).collect();
    let before: f64 = base.written.stages[..base.written.stages.len() - 1].iter().map(|stage| stage.time).sum();
    let times: Vec<f64> = base.written.observed.iter().map(|time| before + time).collect();
    let compared = ran(base, changed).map(|(_, run)| {
        let (one, other) = (at(base.run, &times), at(&run, &times));
        if base.scene.free_surface.is_some() {
            return of_water(base.scene, &one, &other);
        }
        apart(base.scene, &one, &other, None, allowed(base))
    });
    verdict(compared)
}

/// Water with a free surface goes in steps that fill half a cell at most, whatever their end: it may be off by that.
fn of_water(scene: &Scene, one: &[Sample], other: &[Sample]) -> Apart {
    let mut worst = Apart::new("samples".to_owned(), [one.len() as f64, other.len() as f64], 0.0);
    let weight = scene.water.map_or(0.0, |water| water.unit_weight);
    let head =
        scene.free_surface.iter().flat_map(|free| free.feeds.iter().flatten()).fold(scene.height, |most, feed| {
            match feed {
                Feed::Head(head) => most.max(*head),
                Feed::Velocity { .. } => most,
            }
        });
    // Without gravity the pressure falls from the head to the front: half a cell moves it by as much of the wet height.
    let share = |Sample { state, .. }: &Sample| {
        let whole = scene.mobile_porosity() * state.soil_volume;
        state.water.map_or(0.0, |water| water.mobile_m3 / whole)
    };
    let pressure = |sample: &Sample| 0.5 * scene.cell * weight * head / (share(sample) * scene.height).max(scene.cell);
    let pores = 0.5 * scene.cell * scene.cell * scene.porosity * (scene.cells[0] + scene.cells[1]) as f64;
    let wide = if scene.dimension == Dimension::Column { scene.width / scene.cell } else { 1.0 };
    // Once the last cell is full nothing flows, and pressures are others at once: not while one run may be there.
    let full = |sample: &Sample| (1.0 - share(sample)) * scene.porosity * sample.state.soil_volume < pores * wide;
    for (a, b) in one.iter().zip(other) {
        for (x, y) in numbers(a, false).into_iter().zip(numbers(b, false)) {
            let allowed = match x.unit {
                Unit::Pressure if x.name.contains("pore pressure") && !full(a) && !full(b) => pressure(a),
                Unit::Area if x.name.contains("water") => pores * wide,
                _ => continue,
            };
            worst =
                worst.worse(Apart::new(format!("{} at {:.3e} s", x.name, a.state.time), [x.value, y.value], allowed));
        }
    }
    worst
}

/// Tolerance of the runs that are added.
const SUPERPOSED: f64 = 1e-8;

fn superposed(base: &Base) -> Verdict {
    let w = base.written;
    let linear = base.scene.integrator == Integrator::QuasiStatic && base.scene.strain == StrainChoice::Small;
    if !linear || w.start != "unloaded" {
        return Verdict::Apart;
    }
    let tight = Written { tolerance: Some(SUPERPOSED), ..w.clone() };
    let with = |load: Option<Load>, gravity: Option<f64>| Written { load, gravity, ..tight.clone() };
    let mut sums: Vec<([Written; 2], Written)> = Vec::new();
    // Without its load there is no plate, and soil in plane strain then settles otherwise.
    let plate = w.plane && w.load.as_ref().is_some_and(|load| load.on == "plate");
    if let (Some(load), Some(_), false) = (&w.load, w.gravity, plate) {
        sums.push(([with(Some(load.clone()), None), with(None, w.gravity)], tight.clone()));
    }
    if let Some(load) = &w.load {
        let times = |factor: f64| with(Some(Load { pressure: factor * load.pressure, ..load.clone() }), None);
        sums.push(([times(-1.5), times(3.7)], times(2.2)));
        if w.plane && load.on != "plate" {
            let part = |strip| with(Some(Load { strip, ..load.clone() }), None);
            let (middle, width) = ((0.37 + (w.cells[0] / 2) as f64) * w.cell, w.width());
            let halves = [Some([0.0, middle, 0.0]), Some([middle, width, 0.0])].map(part);
            sums.push((halves, part(None)));
        }
    }
    let compared = || {
        let mut worst = Apart::new("nothing".to_owned(), [0.0; 2], 0.0);
        for ([one, other], both) in sums {
            let (scene, one) = finished(&one)?;
            let (_, other) = finished(&other)?;
            let (_, both) = ran(base, both)?;
            worst = worst.worse(sum(&scene, [&one, &other, &both]));
        }
        Ok(worst)
    };
    verdict(compared())
}

/// Numbers that are linear in the load.
const LINEAR: [&str; 4] = ["settlement", "mean pore pressure", "pore pressure of a row", "effective stress of a row"];

fn sum(scene: &Scene, runs: [&Run; 3]) -> Apart {
    let samples = runs.map(|run| run.samples.iter().filter(|s| s.state.time > 0.0).collect::<Vec<_>>());
    let sizes = runs.map(|run| Sizes::of(scene, &[&run.samples]));
    let mut worst = Apart::new("samples".to_owned(), [samples[0].len() as f64, samples[2].len() as f64], 0.0);
    let whole = samples.iter().flatten().map(|s| s.state.settlement.abs()).fold(0.0, f64::max);
    for ((a, b), c) in samples[0].iter().zip(&samples[1]).zip(&samples[2]) {
        let all = numbers(a, false).into_iter().zip(numbers(b, false)).zip(numbers(c, false));
        for ((x, y), z) in all.filter(|((x, _), _)| LINEAR.contains(&x.name)) {
            let size = if x.unit == Unit::Length { 3.0 * whole } else { sizes.iter().map(|s| s.size(x.unit)).sum() };
            let what = format!("sum of the {} at {:.3e} s", x.name, a.state.time);
            // Closed soil full of water does not settle but for round-off.
            let drained = sizes[2].size(Unit::Pressure) / scene.oedometer_modulus() * scene.height;
            let floor = if x.unit == Unit::Length { 1e-12 * drained } else { 0.0 };
            worst = worst.worse(Apart::new(what, [x.value + y.value, z.value], 10.0 * SUPERPOSED * size + floor));
        }
    }
    worst
}

/// Strain up to which soil is taken as linear.
const LINEAR_UP_TO: f64 = 1e-4;

/// Elastic soil that is pulled as gently as it was pushed. What differs is of second order: lengths and stiffnesses differ by
/// the strain e, and with them the frequencies of waves. The waves that move the soil as a whole have gone through a row of
/// cells per step at most, and turn by pi/2 for each passage of the height: `pi e n/rows` after n steps. Where stresses rise
/// within a cell they rise by `e n` cells elsewhere. At the end of a load or of a side that is held the strain is some times as
/// large.
fn sign(base: &Base) -> Verdict {
    let w = base.written;
    let Some(load) = &w.load else { return Verdict::Apart };
    // Drained: where a load stands on particles the soil above them has none.
    let strain = load.pressure.abs() / least_modulus(base.scene);
    let nonlinear = w.soil.strength.is_some() || base.scene.free_surface.is_some();
    if nonlinear || w.gravity.is_some() || strain > LINEAR_UP_TO {
        return Verdict::Apart;
    }
    let mut changed = w.clone();
    changed.load = Some(Load { pressure: -load.pressure, ..load.clone() });
    let compared = ran(base, changed).map(|(_, run)| {
        let mut worst = Apart::new("nothing".to_owned(), [0.0; 2], 0.0);
        let samples = [&base.run.samples, &run.samples].map(|samples| samples.iter().collect::<Vec<_>>());
        let sizes = Sizes::of(base.scene, &[&base.run.samples]);
        // What the load would do drained: closed soil full of water hardly moves, and then by what is of second order.
        let moved = strain * base.scene.height;
        let waves = if base.scene.integrator == Integrator::QuasiStatic { 0 } else { base.run.steps };
        let turned = std::f64::consts::PI * waves as f64 / base.scene.cells[1] as f64;
        for (a, b) in samples[0].iter().zip(&samples[1]) {
            for (x, y) in numbers(a, false).into_iter().zip(numbers(b, false)) {
                if !LINEAR.contains(&x.name) {
                    continue;
                }
                let (size, turned) = if x.unit == Unit::Length {
                    (moved, turned)
                } else {
                    (sizes.size(x.unit), turned.max(waves as f64))
                };
                let relative = 8.0 * strain * (1.0 + turned) + allowed(base);
                let floor = if x.unit == Unit::Length { allowed(base) * base.scene.height } else { 0.0 };
                let what = format!("{} at {:.3e} s, opposite", x.name, a.state.time);
                worst = worst.worse(Apart::new(what, [x.value, -y.value], relative * size + floor));
            }
        }
        worst
    });
    verdict(compared)
}

/// Everything that has two words for it.
fn words(base: &Base) -> Verdict {
    let mut changed = base.written.clone();
    changed.shape = Some(base.scene.shape.word());
    changed.soil.by_bulk_density = true;
    if let Some(water) = &mut changed.water {
        water.viscosity = Some(1.003e-3);
        changed.darcy.get_or_insert("face");
    }
    let known = base.scene.integrator != Integrator::Staggered
        && base.scene.free_surface.is_none()
        && base.scene.outline.is_none()
        && !base.scene.periodic
        && changed.darcy != Some("nodal")
        && changed.shape != Some("centroid")
        && changed.soil.strength.is_none()
        && (!base.scene.integrator.solves_displacements() || changed.soil.small);
    if known && changed.layers.is_empty() {
        let rows = changed.cells[1];
        let layer = |rows| Layer { rows, stiffness: 1.0, conductivity: 1.0 };
        // Quasi-static B-splines are free to bend where layers meet, and are then others.
        let bends = base.scene.integrator.solves_displacements() && changed.shape == Some("bspline2");
        changed.layers = if bends { vec![layer(rows)] } else { vec![layer(rows / 2), layer(rows - rows / 2)] };
    }
    if let Some(seconds) = base.scene.time_per_factor() {
        // The drainage path is that of the last stage; another stage has its own.
        let one = changed.stages.len() == 1;
        changed.stages.iter_mut().filter(|s| one && s.drained.contains(&true)).for_each(|stage| {
            stage.per_factor = Some(seconds);
        });
    }
    // Numbers written otherwise differ in their last places: a step is off by that of each of them, too.
    let compared = ran(base, changed)
        .map(|(_, run)| apart(base.scene, &base.run.samples, &run.samples, None, 16.0 * allowed(base)));
    verdict(compared)
}

/// Work of the finest mesh at most, particles times cells.
const FINEST: usize = 2000;

/// Only where no wave runs: quasi-static, once the pressure has gone through a cell.
fn refined(base: &Base) -> Verdict {
    let w = base.written;
    if base.scene.integrator != Integrator::QuasiStatic || w.load.as_ref().is_some_and(|load| load.strip.is_some()) {
        return Verdict::Apart;
    }
    if base.scene.solid_particles() * if w.plane { 16 } else { 4 } > FINEST {
        return Verdict::Apart;
    }
    let finer = |times: usize| {
        let mut finer = Written { tolerance: Some(1e-7), cell: w.cell / times as f64, ..w.clone() };
        finer.cells = [if w.plane { w.cells[0] * times } else { 1 }, w.cells[1] * times];
        finer.empty_above *= times;
        finer.layers.iter_mut().for_each(|layer| layer.rows *= times);
        finer
    };
    let compared = || {
        let (_, one) = finished(&finer(1))?;
        let (_, two) = finished(&finer(2))?;
        let (_, four) = ran(base, finer(4))?;
        let ends = [&one, &two, &four].map(|run| run.samples.last());
        let [Some(a), Some(b), Some(c)] = ends else { return Err(Verdict::Apart) };
        // In the layer through which it goes least.
        let spread = |(_, soil): &(f64, Fields)| soil.water.map_or(0.0, |water| water.mobility() / soil.storage());
        let slowest = base.scene.by_layer().iter().map(spread).fold(f64::INFINITY, f64::min);
        let gone = (slowest * a.stage_time).sqrt();
        let length = if gone > 0.0 { gone.min(base.scene.height) } else { base.scene.height };
        let of_mesh = (0.5 * w.cell / length).powi(2);
        let sizes = Sizes::of(base.scene, &[&base.run.samples]);
        // What load and weight would do drained: closed soil full of water hardly moves.
        let moved = sizes.size(Unit::Pressure) / least_modulus(base.scene) * base.scene.height;
        let mut worst = Apart::new("nothing".to_owned(), [0.0; 2], 0.0);
        let all = [
            ("settlement", [a, b, c].map(|s| s.state.settlement), moved),
            ("mean pore pressure", [a, b, c].map(|s| s.state.mean_pressure), sizes.size(Unit::Pressure)),
        ];
        for (name, [coarse, middle, fine], size) in all {
            let floor = size * (1e-5 + of_mesh);
            let what = format!("change of the {name} once the mesh is halved again");
            worst = worst.worse(Apart::new(what, [middle, fine], (coarse - middle).abs().max(floor)));
        }
        Ok(worst)
    };
    verdict(compared())
}

fn bits(one: &str, other: &str, what: &str) -> Apart {
    let place = one.bytes().zip(other.bytes()).position(|(a, b)| a != b);
    let different = one.len() != other.len() || place.is_some();
    let from = place.unwrap_or(0).saturating_sub(80);
    let part = |text: &str| text.get(from..(from + 120).min(text.len())).unwrap_or("").to_owned();
    let what = if different { format!("{what}: {} ... and {}", part(one), part(other)) } else { what.to_owned() };
    Apart::new(what, [0.0, f64::from(u8::from(different))], 0.0)
}

fn threads(base: &Base) -> Verdict {
    if !base.written.plane || base.scene.integrator != Integrator::Explicit {
        return Verdict::Apart;
    }
    let compared = || {
        let mut written = base.written.clone();
        (base.fault)(&mut written);
        let scene = read(&written)?;
        let one = said(base.run);
        let run = |hardware: &Hardware| run_of(hardware, &scene);
        let mut worst = Apart::new("nothing".to_owned(), [0.0; 2], 0.0);
        for width in [Width::One, Width::Eight] {
            worst = worst.worse(bits(&one, &said(&run(&Hardware::plain(width))?), &format!("width {width:?}")));
        }
        {
            let threads = 2;
            let hardware = Hardware::threads(threads).map_err(Error::from)?;
            worst = worst.worse(bits(&one, &said(&run(&hardware)?), &format!("{threads} threads")));
        }
        let plain = run(&Hardware::plain(Width::One))?.whole().map_err(Error::from)?;
        Ok(worst.worse(apart(base.scene, &base.run.samples, &plain.samples, None, allowed(base))))
    };
    verdict(compared())
}

/// Stops a run at its next look.
#[derive(Default)]
struct Stop(Option<Vec<u8>>);

impl Monitor for Stop {
    fn look(&mut self, _: f64) -> Wish {
        Wish::Stop
    }

    fn save(&mut self, state: Vec<u8>) {
        self.0 = Some(state);
    }
}

fn resumed(base: &Base) -> Verdict {
    let compared = || {
        let mut written = base.written.clone();
        (base.fault)(&mut written);
        let scene = read(&written)?;
        let mut state = None;
        for _ in 0..1000 {
            let mut stop = Stop::default();
            let run = run_monitored(&Hardware::default(), &scene, state.as_deref(), &mut stop);
            let run = run.map_err(|e| Error::from(e).of("refused"))?;
            if !run.stopped {
                return Ok(bits(&said(base.run), &said(&run), "resumed"));
            }
            state = stop.0;
        }
        Err(Verdict::Unfinished("a run that does not end".to_owned()))
    };
    strictly(verdict(compared()))
}

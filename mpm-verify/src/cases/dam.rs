//! A rectangular dam: discharge, exit point, free surface and stored water once the flow is steady.

use mpm_core::drive::Sample;
use mpm_core::observe::{FieldPoint, WaterState};
use mpm_core::scene::{Feed, Fields, Scene};

use super::{Error, FASTER, Lacks, Mutant, Outcome, Program, Unfit, faster, finished, integrator, sound};
use crate::exact::dam::Dam;
use crate::experiment::comparison::{Compared, Comparison, in_particles};
use crate::norms::largest;

/// What flows through.
pub const DISCHARGE: Program = Program {
    name: "dam-discharge",
    about: "discharge k H1^2/(2 l): within 1 % at 20 cells over the height and 0.3 % at 40",
    run: || discharge(0.0, sound),
    mutant: Some(Mutant { what: FASTER, run: || discharge(0.0, faster) }),
};

/// The same with water on both sides.
pub const TAIL_WATER: Program = Program {
    name: "dam-tail-water",
    about: "discharge k (H1^2 - H2^2)/(2 l) with water 0.2 m high on the other side",
    run: || discharge(0.2, sound),
    mutant: Some(Mutant {
        what: "no water on the other side",
        run: || {
            discharge(0.2, |scene| {
                if let Some(free) = &mut scene.free_surface {
                    free.feeds[1] = None;
                }
            })
        },
    }),
};

/// Where it comes out.
pub const EXIT: Program = Program {
    name: "dam-exit",
    about: "height of the exit point above the base, to half a cell on every mesh",
    run: || heights(EXIT_HEIGHT, Computed::exit, sound),
    mutant: Some(Mutant { what: "a dam 10 % longer", run: || heights(EXIT_HEIGHT, Computed::exit, longer) }),
};

/// Where its surface is.
pub const SURFACE: Program = Program {
    name: "dam-surface",
    about: "the free surface over nine tenths of the length, to half a cell on every mesh",
    run: || heights(LEVEL, Computed::surface, sound),
    mutant: Some(Mutant { what: "a dam 10 % longer", run: || heights(LEVEL, Computed::surface, longer) }),
};

/// What it holds.
pub const STORED: Program = Program {
    name: "dam-stored",
    about: "water in cells and in particles over n times the area under the exact surface, also beside tail water: within 1 %",
    run: || stored(sound),
    mutant: Some(Mutant {
        what: "porosity 2 % too high",
        run: || {
            stored(|scene| {
                scene.porosity *= 1.02;
            })
        },
    }),
};

const EXIT_HEIGHT: &str = "height of the exit point";
const LEVEL: &str = "height of the free surface";

/// Rows of cells over the height.
const ROWS: [usize; 3] = [10, 20, 40];
/// Particles per cell.
const COUNTS: [usize; 3] = [1, 4, 9];

fn longer(scene: &mut Fields) {
    let columns = (1.1 * scene.width / scene.cell).round();
    scene.cells[0] = columns as usize;
    scene.width = columns * scene.cell;
}

fn scene(rows: usize, tail: f64) -> Result<Scene, Error> {
    let dam = crate::scenes::built_in("dam")?;
    let tailed = dam.edited(|scene| {
        if let (Some(free), true) = (&mut scene.free_surface, tail > 0.0) {
            free.feeds[1] = Some(Feed::Head(tail));
        }
    })?;
    Ok(tailed.with_rows(rows)?)
}

/// A dam that was computed, beside the exact one.
struct Computed {
    exact: Dam,
    cell: f64,
    /// Height of the standing water in each column of cells, m.
    levels: Vec<f64>,
    width: f64,
    water: WaterState,
}

impl Computed {
    fn new(scene: &Scene, sample: &Sample) -> Result<Self, Error> {
        let columns = scene.cells[0];
        let mut levels = vec![0.0; columns];
        let standing = |p: &&FieldPoint| p.pressure_pa > 0.0;
        for point in sample.state.field.iter().filter(standing) {
            let column = (point.x_m / scene.cell) as usize;
            let level = point.y_m - 0.5 * scene.cell + point.saturation.min(1.0) * scene.cell;
            levels[column] = f64::max(levels[column], level);
        }
        Ok(Self {
            exact: Dam::new(1.0, 0.0, 1.0).ok_or(Lacks("such dam"))?,
            cell: scene.cell,
            levels,
            width: scene.width,
            water: sample.state.water.ok_or(Lacks("free surface"))?,
        })
    }

    /// Height up to which water stands in the last column of cells and what it should be, m.
    fn exit(&self) -> (Vec<f64>, Vec<f64>) {
        (vec![self.levels[self.levels.len() - 1]], vec![self.exact.exit_height()])
    }

    /// Level and exact surface at the middles of the columns over nine tenths of the length, m.
    fn surface(&self) -> (Vec<f64>, Vec<f64>) {
        let places = (0..self.levels.len()).map(|i| (i as f64 + 0.5) * self.cell);
        let pairs = places.zip(&self.levels).filter(|(x, _)| *x <= 0.9 * self.width);
        pairs.map(|(x, level)| (*level, self.exact.surface(x))).unzip()
    }
}

/// What a dam shows at the times of its scene; the end, when the flow is steady, counts.
fn followed(
    scene: &Scene,
    (quantity, unit): (&str, &'static str),
    shown: impl Fn(&Computed) -> (Vec<f64>, Vec<f64>),
) -> Result<(Comparison, WaterState), Error> {
    let run = finished(scene)?;
    let last = run.samples.last().ok_or(Lacks("sample"))?;
    let mut rows = Vec::new();
    for sample in run.observed().chain([last]) {
        let (computed, exact) = shown(&Computed::new(scene, sample)?);
        let counts = sample.stage_time == last.stage_time;
        rows.push(Compared { time: sample.stage_time, factor: None, computed, exact, counts, places: Vec::new() });
    }
    Ok((Comparison { unit, ..Comparison::worst(quantity, rows) }, last.state.water.ok_or(Lacks("free surface"))?))
}

fn discharge(tail: f64, fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let exact = Dam::new(1.0, tail, 1.0).ok_or(Lacks("such dam"))?;
    let flow = |mut scene: Scene| {
        let sought = exact.discharge(scene.water.ok_or(Unfit("the scene is dry"))?.hydraulic_conductivity);
        scene = scene.edited(fault)?;
        followed(&scene, ("outflow over the discharge of the steady flow", "-"), |dam| {
            (vec![dam.water.outflow_m3_s / sought], vec![1.0])
        })
    };
    let (mut errors, mut steady, mut samples) = (Vec::new(), 0.0, Vec::new());
    for rows in ROWS {
        let scene = scene(rows, tail)?;
        let cell = scene.cell;
        let (looks, water) = flow(scene)?;
        errors.push((cell, looks.error()));
        steady = f64::max(steady, (water.inflow_m3_s / water.outflow_m3_s - 1.0).abs());
        samples = looks.samples();
    }
    let coarse = scene(ROWS[0], tail)?;
    let with = |particles_per_cell| Ok(flow(coarse.edited(|s| s.particles_per_cell = particles_per_cell)?)?.0);
    Ok(Outcome {
        integrator: integrator(&coarse),
        scheme: "free surface".to_owned(),
        errors,
        required_error: 3e-3,
        required_order: None,
        // 1 % at L = 0.05 m.
        required_everywhere: Some(0.2),
        notes: vec![("inflow over outflow - 1, largest".to_owned(), steady, "-".to_owned())],
        samples,
        refinements: vec![in_particles(with, coarse.cell, &COUNTS, 0.2 * coarse.cell)?],
        ..Outcome::default()
    })
}

fn heights(
    quantity: &str,
    shown: fn(&Computed) -> (Vec<f64>, Vec<f64>),
    fault: fn(&mut Fields),
) -> Result<Outcome, Error> {
    let seen = |mut scene: Scene| {
        scene = scene.edited(fault)?;
        Ok::<_, Error>(followed(&scene, (quantity, "m"), shown)?.0)
    };
    let (mut errors, mut samples) = (Vec::new(), Vec::new());
    for rows in ROWS {
        let scene = scene(rows, 0.0)?;
        let cell = scene.cell;
        let looks = seen(scene)?;
        errors.push((cell, looks.error().abs()));
        samples = looks.samples();
    }
    let coarse = scene(ROWS[0], 0.0)?;
    let with = |particles_per_cell| seen(coarse.edited(|s| s.particles_per_cell = particles_per_cell)?);
    Ok(Outcome {
        integrator: integrator(&coarse),
        scheme: "free surface".to_owned(),
        required_error: 0.5 * errors[errors.len() - 1].0,
        errors,
        required_everywhere: Some(0.5),
        samples,
        refinements: vec![in_particles(with, coarse.cell, &COUNTS, 0.5 * coarse.cell)?],
        ..Outcome::default()
    })
}

fn stored(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let (mut errors, mut notes, mut samples) = (Vec::new(), Vec::new(), Vec::new());
    for (rows, tail) in [(20, 0.0), (40, 0.0), (20, 0.3), (20, 0.9)] {
        let exact = Dam::new(1.0, tail, 1.0).ok_or(Lacks("such dam"))?;
        for per_cell in [4, 9] {
            let mut scene = scene(rows, tail)?.edited(|scene| {
                scene.particles_per_cell = per_cell;
                // The crest is open: the free surface lies below it.
                scene.stages[0].drained[3] = tail > 0.0;
            })?;
            let porosity = scene.porosity;
            scene = scene.edited(fault)?;
            let what = ("water in cells and in particles over n times the area under the steady surface", "-");
            let (looks, water) = followed(&scene, what, |dam| {
                let geometric = exact.stored(porosity);
                (vec![dam.water.mobile_m3 / geometric, dam.water.particles_m3 / geometric], vec![1.0; 2])
            })?;
            // Faces that would draw water in leave steps unsettled.
            errors.push((scene.cell / (per_cell as f64).sqrt(), looks.error().abs() + water.unsettled as f64));
            let of = format!("L = {} m, {per_cell} per cell, tail water at {tail} m", scene.cell);
            let [cells, layer] = [0, 1].map(|i| looks.rows.last().map_or(f64::NAN, |row| row.computed[i] - 1.0));
            notes.push((format!("water in cells over geometric - 1, {of}"), cells, "-".to_owned()));
            notes.push((format!("water in particles over geometric - 1, {of}"), layer, "-".to_owned()));
            let packing = water.packing_mean;
            notes.push((format!("particles in a cell off by, root mean square, {of}"), packing, "-".to_owned()));
            samples = looks.samples();
        }
    }
    // The worst of all is judged.
    let worst = largest(errors.iter().map(|(_, error): &(f64, f64)| error.abs()));
    let finest = errors.iter().map(|(h, _)| *h).fold(f64::INFINITY, f64::min);
    Ok(Outcome {
        integrator: integrator(&scene(ROWS[0], 0.0)?),
        scheme: "free surface".to_owned(),
        errors: vec![(finest, worst)],
        required_error: 1e-2,
        refined_by: ("particle spacing", "m"),
        notes,
        samples,
        ..Outcome::default()
    })
}

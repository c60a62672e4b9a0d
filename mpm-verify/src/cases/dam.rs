//! A rectangular dam: discharge, exit point, free surface and stored water once the flow is steady.

use mpm_core::drive::Run;
use mpm_core::observe::{FieldPoint, WaterState};
use mpm_core::scene::{Feed, Scene};

use super::{FASTER, Mutant, Outcome, Rung, faster, finished, integrator, sound};
use crate::exact::dam::Dam;
use crate::norms::largest;

/// What flows through.
pub const DISCHARGE: Rung = Rung {
    name: "dam-discharge",
    about: "discharge k H1^2/(2 l): within 1 % at 20 cells over the height and 0.3 % at 40",
    climb: || discharge(0.0, sound),
    mutant: Some(Mutant { what: FASTER, climb: || discharge(0.0, faster) }),
};

/// The same with water on both sides.
pub const TAIL_WATER: Rung = Rung {
    name: "dam-tail-water",
    about: "discharge k (H1^2 - H2^2)/(2 l) with water 0.2 m high on the other side",
    climb: || discharge(0.2, sound),
    mutant: Some(Mutant {
        what: "no water on the other side",
        climb: || {
            discharge(0.2, |scene| {
                if let Some(free) = &mut scene.free_surface {
                    free.feeds[1] = None;
                }
            })
        },
    }),
};

/// Where it comes out.
pub const EXIT: Rung = Rung {
    name: "dam-exit",
    about: "height of the exit point above the base, to half a cell on every mesh",
    climb: || heights(|water| vec![water.exit() - water.exact.exit_height()], sound),
    mutant: Some(Mutant {
        what: "a dam 10 % longer",
        climb: || heights(|water| vec![water.exit() - water.exact.exit_height()], longer),
    }),
};

/// Where its surface is.
pub const SURFACE: Rung = Rung {
    name: "dam-surface",
    about: "the free surface over nine tenths of the length, to half a cell on every mesh",
    climb: || heights(|water| water.surface_off(), sound),
    mutant: Some(Mutant { what: "a dam 10 % longer", climb: || heights(|water| water.surface_off(), longer) }),
};

/// What it holds.
pub const STORED: Rung = Rung {
    name: "dam-stored",
    about: "water in cells and in particles, at 4 and 9 per cell, over n times the area under the exact surface: within 1 %",
    climb: || stored(sound),
    mutant: Some(Mutant {
        what: "porosity 2 % too high",
        climb: || {
            stored(|scene| {
                scene.porosity *= 1.02;
            })
        },
    }),
};

fn longer(scene: &mut Scene) {
    let columns = (1.1 * scene.width / scene.cell).round();
    scene.cells[0] = columns as usize;
    scene.width = columns * scene.cell;
}

fn scene(rows: usize, tail: f64) -> Scene {
    let mut scene = crate::scenes::built_in("dam").and_then(Result::ok).expect("the built-in scene holds");
    scene.cell = scene.height / rows as f64;
    scene.cells = [(scene.width / scene.cell).round() as usize, rows];
    if let (Some(free), true) = (&mut scene.free_surface, tail > 0.0) {
        free.feeds[1] = Some(Feed::Head(tail));
    }
    scene
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
    fn new(scene: &Scene, run: &Run) -> Result<Self, String> {
        let last = run.samples.last().ok_or("no sample")?;
        let columns = scene.cells[0];
        let mut levels = vec![0.0; columns];
        let standing = |p: &&FieldPoint| p.pressure_pa > 0.0;
        for point in last.state.field.iter().filter(standing) {
            let column = (point.x_m / scene.cell) as usize;
            let level = point.y_m - 0.5 * scene.cell + point.saturation.min(1.0) * scene.cell;
            levels[column] = f64::max(levels[column], level);
        }
        Ok(Self {
            exact: Dam::new(1.0, 0.0, 1.0).ok_or("no such dam")?,
            cell: scene.cell,
            levels,
            width: scene.width,
            water: last.state.water.ok_or("no free surface")?,
        })
    }

    /// Height up to which water stands in the last column of cells, m.
    fn exit(&self) -> f64 {
        self.levels[self.levels.len() - 1]
    }

    /// Level less exact surface at the middles of the columns, m.
    fn surface_off(&self) -> Vec<f64> {
        let places = (0..self.levels.len()).map(|i| (i as f64 + 0.5) * self.cell);
        places
            .zip(&self.levels)
            .filter(|(x, _)| *x <= 0.9 * self.width)
            .map(|(x, level)| level - self.exact.surface(x))
            .collect()
    }
}

fn discharge(tail: f64, fault: fn(&mut Scene)) -> Result<Outcome, String> {
    let exact = Dam::new(1.0, tail, 1.0).ok_or("no such dam")?;
    let (mut errors, mut steady, mut name) = (Vec::new(), 0.0, String::new());
    for rows in [10, 20, 40] {
        let mut scene = scene(rows, tail);
        let sought = exact.discharge(scene.water.ok_or("the scene is dry")?.hydraulic_conductivity);
        fault(&mut scene);
        name = integrator(&scene);
        let run = finished(&scene)?;
        let water = Computed::new(&scene, &run)?.water;
        errors.push((scene.cell, water.outflow_m3_s / sought - 1.0));
        steady = f64::max(steady, (water.inflow_m3_s / water.outflow_m3_s - 1.0).abs());
    }
    Ok(Outcome {
        integrator: name,
        scheme: "free surface".to_owned(),
        errors,
        required_error: 3e-3,
        required_order: None,
        // 1 % at L = 0.05 m.
        required_everywhere: Some(0.2),
        notes: vec![("inflow over outflow - 1, largest".to_owned(), steady, "-".to_owned())],
        ..Outcome::default()
    })
}

fn heights(off: fn(&Computed) -> Vec<f64>, fault: fn(&mut Scene)) -> Result<Outcome, String> {
    let (mut errors, mut name) = (Vec::new(), String::new());
    for rows in [10, 20, 40] {
        let mut scene = scene(rows, 0.0);
        fault(&mut scene);
        name = integrator(&scene);
        let run = finished(&scene)?;
        let worst = largest(off(&Computed::new(&scene, &run)?).into_iter().map(f64::abs));
        errors.push((scene.cell, worst));
    }
    Ok(Outcome {
        integrator: name,
        scheme: "free surface".to_owned(),
        required_error: 0.5 * errors[errors.len() - 1].0,
        errors,
        required_everywhere: Some(0.5),
        ..Outcome::default()
    })
}

fn stored(fault: fn(&mut Scene)) -> Result<Outcome, String> {
    let (mut errors, mut notes, mut name) = (Vec::new(), Vec::new(), String::new());
    for rows in [20, 40] {
        for per_cell in [4, 9] {
            let mut scene = scene(rows, 0.0);
            scene.particles_per_cell = per_cell;
            let porosity = scene.porosity;
            fault(&mut scene);
            name = integrator(&scene);
            let run = finished(&scene)?;
            let computed = Computed::new(&scene, &run)?;
            let geometric = computed.exact.stored(porosity);
            let [cells, layer] =
                [computed.water.mobile_m3, computed.water.particles_m3].map(|stored| stored / geometric - 1.0);
            errors.push((scene.cell / (per_cell as f64).sqrt(), if cells.abs() > layer.abs() { cells } else { layer }));
            let of = format!("L = {} m, {per_cell} per cell", scene.cell);
            notes.push((format!("water in cells over geometric - 1, {of}"), cells, "-".to_owned()));
            notes.push((format!("water in particles over geometric - 1, {of}"), layer, "-".to_owned()));
            let packing = computed.water.packing_mean;
            notes.push((format!("particles in a cell off by, root mean square, {of}"), packing, "-".to_owned()));
        }
    }
    // The worst of all four is judged.
    let worst = largest(errors.iter().map(|(_, error): &(f64, f64)| error.abs()));
    let finest = errors.iter().map(|(h, _)| *h).fold(f64::INFINITY, f64::min);
    Ok(Outcome {
        integrator: name,
        scheme: "free surface".to_owned(),
        errors: vec![(finest, worst)],
        required_error: 1e-2,
        refined_by: ("particle spacing", "m"),
        notes,
        ..Outcome::default()
    })
}

//! What a step costs: CPU time per solid particle and step for scenes that use more or less of the method.
//!
//! Figures of one machine at one moment: compare ratios within a table, never figures of two tables.

use cpu_time::ThreadTime;
use mpm_core::error::SceneError;
use mpm_core::run::model;
use mpm_core::scene::{DarcyChoice, Dimension, Fields, Scene, ShapeChoice, Start, Strength};
use mpm_core::stability::choose_step;
use serde::{Deserialize, Serialize};

/// One row of `cost.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// What the scene uses.
    pub path: String,
    /// Solid particles.
    pub points: usize,
    /// Steps timed, per repetition.
    pub steps: u64,
    /// Median CPU time per solid particle and step, ns.
    pub ns_per_point_step: f64,
    /// Smallest and largest of the repetitions, ns.
    pub spread_ns: [f64; 2],
    /// Bytes held per solid particle.
    pub bytes_per_point: usize,
    /// Cost over that of the general path (plane strain, water, gravity) at 1000 points in the same run.
    pub ratio: f64,
}

/// Repetitions of each timing.
const REPETITIONS: usize = 5;
/// Particle-steps per repetition.
const WORK: usize = 1_000_000;

/// A block of the study's soil, `cells` wide and high, 4 particles per cell.
///
/// # Errors
/// More cells than fit into memory.
pub fn block(cells: [usize; 2]) -> Result<Scene, SceneError> {
    crate::scenes::terzaghi().edited(|scene| {
        (scene.dimension, scene.cells) = (Dimension::PlaneStrain, cells);
        (scene.width, scene.height) = (cells[0] as f64 * scene.cell, cells[1] as f64 * scene.cell);
    })
}

/// A block without water.
///
/// # Errors
/// More cells than fit into memory.
pub fn dry(cells: [usize; 2]) -> Result<Scene, SceneError> {
    block(cells)?.edited(|scene| {
        (scene.water, scene.start) = (None, Start::Unloaded);
        scene.stages[0].drained = [false; 4];
    })
}

/// The paths that are compared, by name. The first is the general one.
///
/// # Errors
/// A scene that the checker refuses.
pub fn paths() -> Result<Vec<(&'static str, Scene)>, SceneError> {
    let change = |change: fn(&mut Fields)| block([5, 50])?.edited(change);
    let dry_plane = dry([5, 50])?;
    let dry_column = dry_plane.edited(|scene| scene.dimension = Dimension::Column)?;
    Ok(vec![
        (
            "plane strain, water, gravity",
            change(|s| (s.gravity, s.start, s.surcharge) = (Some(9.81), Start::Geostatic, None))?,
        ),
        ("plane strain, water", change(|_| {})?),
        ("plane strain, water, nodal Darcy", change(|s| s.darcy = DarcyChoice::Nodal)?),
        ("plane strain, water, linear scheme", change(|s| s.shape = ShapeChoice::Linear)?),
        ("plane strain, water, b-bar", change(|s| s.shape = ShapeChoice::BBar)?),
        (
            "plane strain, water, b-bar, Mohr-Coulomb",
            change(|s| {
                s.shape = ShapeChoice::BBar;
                s.strength = Some(Strength {
                    cohesion: s.surcharge.as_ref().map_or(1.0, |load| load.pressure),
                    friction_angle: 30.0,
                    dilation_angle: 0.0,
                    tension_cutoff: None,
                    dilation_fades_over: None,
                });
            })?,
        ),
        ("plane strain, water, gimp", change(|s| s.shape = ShapeChoice::Gimp)?),
        ("plane strain, water, bspline2", change(|s| s.shape = ShapeChoice::Bspline2)?),
        ("plane strain, dry", dry_plane),
        ("column, water", change(|s| s.dimension = Dimension::Column)?),
        ("column, dry", dry_column),
    ])
}

/// Times every path at 1000 points (100 in a column), and plane strain with water up to 1e6 points.
///
/// # Errors
/// A scene that the checker refuses.
pub fn measure() -> Result<Vec<Cost>, SceneError> {
    let mut scenes: Vec<(String, Scene)> = paths()?.into_iter().map(|(n, s)| (n.to_owned(), s)).collect();
    for cells in [[50, 50], [250, 100], [500, 500]] {
        scenes.push(("plane strain, water".to_owned(), block(cells)?));
    }
    let mut costs: Vec<Cost> = scenes.iter().filter_map(|(name, scene)| time(name, scene)).collect();
    let general = costs.first().map_or(f64::NAN, |c| c.ns_per_point_step);
    for cost in &mut costs {
        cost.ratio = cost.ns_per_point_step / general;
    }
    Ok(costs)
}

fn time(name: &str, scene: &Scene) -> Option<Cost> {
    let dt = choose_step(scene).ok()?;
    let mut model = model(scene).ok()?;
    model.enter_stage(&scene.stages[0], &[]).ok()?;
    let points = model.solid_count();
    let steps = (WORK / points).max(4) as u64;
    let mut done = 0;
    model.advance(dt, (steps / 4).max(2), &mut done).ok()?;
    let mut times = Vec::new();
    for _ in 0..REPETITIONS {
        let clock = ThreadTime::now();
        model.advance(dt, steps, &mut done).ok()?;
        times.push(clock.elapsed().as_secs_f64() * 1e9 / (steps as f64 * points as f64));
    }
    times.sort_by(f64::total_cmp);
    Some(Cost {
        path: name.to_owned(),
        points,
        steps,
        ns_per_point_step: times[REPETITIONS / 2],
        spread_ns: [times[0], times[REPETITIONS - 1]],
        bytes_per_point: model.bytes() / points,
        ratio: f64::NAN,
    })
}

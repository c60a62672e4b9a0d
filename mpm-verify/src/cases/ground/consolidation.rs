//! Consolidation of columns that end within a cell, and of layers that differ in everything; a disc that does not drain.

use mpm_core::scene::{
    Bearing, Course, Dimension, Fields, Integrator, LoadOn, Scene, ShapeChoice, StrainChoice, Surcharge, Until,
};

use super::super::{Error, FASTER, Lacks, Unfit, faster, sound};
use super::*;
use crate::exact::layered::Layered;
use crate::exact::terzaghi::Terzaghi;
use crate::norms::largest;

const CUT: Setup = Setup {
    scene: "cut-column",
    change: sound,
    mesh: two_cells_wide,
    measure: cut_column,
    cells: &[5.37, 10.37, 20.37, 40.37],
    required: 1e-3,
    // Steps at their limit: the error in time shows on fine meshes.
    order: None,
};
const LAYERS: Setup = Setup {
    scene: "three-layers",
    change: sound,
    mesh: refined,
    measure: layered,
    cells: &[10.0, 20.0, 40.0],
    required: 1e-6,
    order: None,
};

const DISC: Setup = Setup {
    scene: "cryer",
    change: sealed_disc,
    mesh: refined,
    measure: undrained,
    cells: &[8.0, 12.0, 16.0, 24.0],
    required: 1e-4,
    order: None,
};

/// Where second order is looked for, and what it may be.
const MESHES: &[f64] = &[10.0, 20.0, 30.0, 40.0, 50.0];
const SECOND: Option<[f64; 2]> = Some([1.7, 2.3]);

/// What is planted in a layer.
const FASTER_LAYER: &str = "conductivity of the middle layer 5 % too high";

/// All of them.
pub const CASES: [Program; 7] = [
    case!("cut-column", "Terzaghi's column with a top 0.37 cells above a row, semi-implicit", FASTER, faster, CUT),
    case!(
        "cut-column-explicit",
        "the same explicit: order 2",
        FASTER,
        faster,
        Setup { change: explicit, cells: &[5.37, 7.37, 10.37, 14.37], required: 1e-3, order: SECOND, ..CUT }
    ),
    case!(
        "three-layers",
        "layers of their own stiffness, porosity and conductivity: settlement, B-splines",
        FASTER_LAYER,
        faster_layer,
        LAYERS
    ),
    case!(
        "three-layers-centre",
        "the same with centre values: order 2",
        FASTER_LAYER,
        faster_layer,
        Setup { change: centre, required: 1e-3, order: SECOND, cells: MESHES, ..LAYERS }
    ),
    case!(
        "three-layers-semi-implicit",
        "the same with an implicit pressure: order 2",
        FASTER_LAYER,
        faster_layer,
        Setup { change: semi_implicit, required: 1e-3, order: SECOND, cells: MESHES, ..LAYERS }
    ),
    case!(
        "three-layers-explicit",
        "the same explicit",
        FASTER_LAYER,
        faster_layer,
        // Waves of the start, which the series does not know, leave 3e-4.
        Setup { change: by_explicit, required: 2e-3, cells: MESHES, ..LAYERS }
    ),
    case!(
        "sealed-disc",
        "a disc in cells that its outline cuts, pressed from all around: one undrained pressure, semi-implicit",
        "load 2 % too large",
        heavier,
        DISC
    ),
];

/// So many cells over the height, two across.
fn two_cells_wide(scene: &Scene, cells: f64) -> Result<Scene, Error> {
    let wide = |scene: &mut Fields| {
        scene.cell = scene.height / cells;
        (scene.width, scene.cells) = (2.0 * scene.cell, [2, cells.ceil() as usize]);
        let [width, height] = [scene.width, scene.height];
        scene.outline = Some(vec![[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]);
    };
    Ok(scene.edited(wide)?)
}

fn explicit(scene: &mut Fields) {
    (scene.integrator, scene.shape) = (Integrator::Explicit, ShapeChoice::Centre);
}

fn centre(scene: &mut Fields) {
    (scene.shape, scene.particles_per_cell) = (ShapeChoice::Centre, 4);
}

fn by_explicit(scene: &mut Fields) {
    centre(scene);
    (scene.integrator, scene.strain, scene.darcy_inertia) = (Integrator::Explicit, StrainChoice::Large, true);
    (scene.tolerance, scene.observe_times) = (1e-4, vec![0.5, 1.0, 2.0]);
    scene.stages[0].until = Until::Time(2.0);
    // Small strain beside the exact solution.
    scene.surcharge = scene.surcharge.map(|load| Surcharge { pressure: 0.01 * load.pressure, ..load });
}

fn semi_implicit(scene: &mut Fields) {
    by_explicit(scene);
    scene.integrator = Integrator::SemiImplicit;
}

fn faster_layer(scene: &mut Fields) {
    scene.layers[1].hydraulic_conductivity *= 1.05;
}

/// Settlement over the exact one, after the load has grown: the outline is a column of its height.
fn cut_column(scene: &Scene) -> Measured {
    let Some(Course::Ramp(ramp)) = scene.loads.first().map(|load| load.course.clone()) else {
        return Err(Unfit("a load that grows"));
    };
    let plain = scene.edited(|scene| {
        scene.outline = None;
        scene.cell = scene.height / 10.0;
        (scene.width, scene.cells) = (scene.cell, [1, 10]);
        let pressure = scene.load_on_top();
        scene.loads.clear();
        scene.surcharge = Some(Surcharge { pressure, ramp_time: ramp, on: LoadOn::Surface, strip: None });
    })?;
    let exact = Terzaghi::compressible(&plain).ok_or(Lacks("plain column"))?;
    Ok(Box::new(move |run| largest(run.observed().map(|s| s.state.settlement / exact.settlement(s.stage_time) - 1.0))))
}

fn sealed_disc(scene: &mut Fields) {
    scene.dimension = Dimension::PlaneStrain;
    scene.observe_times = vec![0.2];
    for stage in &mut scene.stages {
        (stage.drained, stage.until) = ([false; 4], Until::Time(0.2));
    }
}

fn heavier(scene: &mut Fields) {
    for load in &mut scene.loads {
        if let Bearing::Traction { pressure, .. } = &mut load.bearing {
            *pressure *= 1.02;
        }
    }
}

/// Pore pressure in whole cells over the undrained one of plane strain, `q Q/(lambda + G + Q)`.
fn undrained(scene: &Scene) -> Measured {
    let stiffness = scene.pore_stiffness();
    let share = stiffness / (scene.elastic.lame() + scene.elastic.shear_modulus() + stiffness);
    let exact = share * scene.largest_load();
    Ok(Box::new(move |run| {
        let end = run.samples.last().into_iter().flat_map(|end| &end.state.field).filter(|at| at.soil > 0.99);
        largest(end.map(|at| at.pressure_pa / exact - 1.0))
    }))
}

/// Settlement over the exact one of the layers.
fn layered(scene: &Scene) -> Measured {
    let exact = Layered::of(scene).ok_or(Unfit("not a column of layers"))?;
    Ok(Box::new(move |run| largest(run.observed().map(|s| s.state.settlement / exact.settlement(s.stage_time) - 1.0))))
}

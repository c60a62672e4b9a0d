//! Steady seepage in saturated ground: along layers, through an inclined interface, along a slope.

use mpm_core::drive::{Run, Sample};
use mpm_core::observe::FieldPoint;
use mpm_core::scene::{
    Bearing, Course, FaceLoad, Feed, Fields, FreeSurfaceWater, Integrator, Scene, ShapeChoice, Side, StrainChoice,
    Until,
};

use super::super::{Error, Unfit, sound};
use super::*;
use crate::norms::largest;

const LAYERS: Setup = Setup {
    scene: "flow-along-layers",
    change: sound,
    mesh: refined,
    measure: along_layers,
    cells: &[8.0],
    required: 1e-7,
    order: None,
};
const REFRACTION: Setup = Setup {
    scene: "flow-in-series",
    change: sound,
    mesh: refracting,
    measure: refracted,
    // A load on every face at the sides: no more than 64.
    cells: &[6.0, 8.0, 12.0, 16.0],
    required: 2e-3,
    order: Some([0.8, 1.7]),
};
const SLOPE: Setup = Setup {
    scene: "seepage-along-slope",
    change: sound,
    mesh: refined,
    measure: hydrostatic,
    cells: &[8.0],
    required: 1e-9,
    order: None,
};

/// Two layers let through more than they should.
const FASTER_LAYER: &str = "conductivity of two layers 5 % too high";

/// All of them.
pub const CASES: [Case; 6] = [
    case!("flow-along-layers", "heads and discharge of layers side by side", FASTER_LAYER, faster_layer, LAYERS),
    case!(
        "flow-along-layers-explicit",
        "the same explicit",
        FASTER_LAYER,
        faster_layer,
        Setup { change: explicit, ..LAYERS }
    ),
    case!(
        "flow-along-layers-quasi-static",
        "heads of the same without inertia",
        "a level 2 cm higher",
        higher,
        Setup { change: quasi_static, measure: heads_along_layers, ..LAYERS }
    ),
    case!(
        "flow-along-layers-staggered",
        "the same with the water that has a free surface, fed above the soil",
        FASTER_LAYER,
        faster_layer,
        Setup { change: fed, ..LAYERS }
    ),
    case!(
        "refraction",
        "streamlines at an inclined interface, tan(a)/tan(b) = k1/k2 = 4: heads",
        "conductivity of one soil 20 % too high",
        faster_region,
        REFRACTION
    ),
    case!(
        "seepage-along-slope",
        "pore pressures of an infinite slope full of water",
        "a slope 1 degree steeper",
        steeper,
        SLOPE
    ),
];

fn explicit(scene: &mut Fields) {
    scene.integrator = Integrator::Explicit;
    scene.stages[0].damping = 200.0;
}

fn quasi_static(scene: &mut Fields) {
    (scene.integrator, scene.shape, scene.strain) = (Integrator::QuasiStatic, ShapeChoice::Centre, StrainChoice::Small);
    (scene.darcy_inertia, scene.tolerance) = (false, 1e-6);
}

fn fed(scene: &mut Fields) {
    (scene.integrator, scene.shape) = (Integrator::Staggered, ShapeChoice::Centre);
    scene.free_surface = Some(FreeSurfaceWater {
        saturation: 0.0,
        level: Some(scene.height),
        wet: None,
        feeds: [Some(Feed::Head(3.0)), Some(Feed::Head(2.0)), None, None],
        courses: Default::default(),
    });
    scene.loads = Vec::new();
}

fn faster_layer(scene: &mut Fields) {
    scene.layers[1].hydraulic_conductivity *= 1.05;
    scene.layers[2].hydraulic_conductivity *= 1.05;
}

fn higher(scene: &mut Fields) {
    if let Some(Course::Times(levels)) = scene.loads.first_mut().map(|load| &mut load.course) {
        levels[0][1] += 0.02;
    }
}

fn faster_region(scene: &mut Fields) {
    scene.regions.iter_mut().for_each(|region| region.soil.hydraulic_conductivity *= 1.2);
}

fn steeper(scene: &mut Fields) {
    scene.slope_angle = scene.slope_angle.map(|angle| angle + 1.0);
}

fn last_field(run: &Run) -> &[FieldPoint] {
    run.observed().last().map_or(&[], |sample| &sample.state.field)
}

/// Levels of the two reservoirs, m.
const LEVELS: [f64; 2] = [3.0, 2.0];

/// Heads over their difference.
fn heads_along_layers(scene: &Scene) -> Measured {
    let (weight, width) = (scene.water.ok_or(Unfit("the scene is dry"))?.unit_weight, scene.width);
    let [left, right] = LEVELS;
    Ok(Box::new(move |run| {
        let head = |x: f64| left + (right - left) * x / width;
        let off = |at: &FieldPoint| (at.pressure_pa / weight + at.y_m - head(at.x_m)) / (left - right);
        largest(last_field(run).iter().map(off))
    }))
}

/// The same, and the discharge over the exact one: quasi-static runs do not book what enters apart from what leaves.
fn along_layers(scene: &Scene) -> Measured {
    let heads = heads_along_layers(scene)?;
    let density = scene.water.map_or(f64::NAN, |water| water.density);
    let conductance: f64 =
        scene.by_layer().iter().map(|(d, soil)| d * soil.water.map_or(0.0, |w| w.hydraulic_conductivity)).sum();
    let discharge = conductance * (LEVELS[0] - LEVELS[1]) / scene.width;
    Ok(Box::new(move |run| {
        let left = |s: &Sample| (s.state.time, s.balance.water_out_kg / density, s.state.water.map(|w| w.outflow_m3_s));
        let flowed: Vec<(f64, f64, Option<f64>)> = run.observed().map(left).collect();
        let [.., (before, then, _), (time, now, outflow)] = flowed[..] else { return f64::NAN };
        let found = outflow.unwrap_or((now - then) / (time - before));
        largest([heads(run), found / discharge - 1.0].into_iter())
    }))
}

/// Flow across the middle of a block, m, between two soils: k_1 over k_2, and the angle of the normal of their interface to the horizontal.
const MIDDLE: [f64; 2] = [0.5, 0.5];
const RATIO: f64 = 4.0;
const TURNED: f64 = 0.4;
/// Head in the middle, m, and its fall along the level streamlines of the first soil.
const HEAD: f64 = 4.0;
const FALL: f64 = 0.5;

/// The head at a place, m: linear in each soil, with one value and one normal flux at the interface.
fn head([x, y]: [f64; 2]) -> f64 {
    let (normal, along) = ([TURNED.cos(), TURNED.sin()], [-TURNED.sin(), TURNED.cos()]);
    let from = [x - MIDDLE[0], y - MIDDLE[1]];
    let dot = |a: [f64; 2]| a[0] * from[0] + a[1] * from[1];
    let across = if dot(normal) > 0.0 { RATIO } else { 1.0 };
    HEAD - FALL * (across * normal[0] * dot(normal) + along[0] * dot(along))
}

fn refracting(scene: &Scene, cells: f64) -> Result<Scene, Error> {
    Ok(refined(scene, cells)?.edited(|scene| inclined(scene, cells))?)
}

/// The block, its sides under the exact heads, one for each face of a cell.
fn inclined(scene: &mut Fields, cells: f64) {
    (scene.width, scene.cells[0]) = (scene.height, scene.cells[1]);
    scene.observe_times = vec![20.0];
    scene.stages[0].until = Until::Time(20.0);
    let (sin, cos) = TURNED.sin_cos();
    let far = 10.0;
    let corner =
        |along: f64, across: f64| [MIDDLE[0] + across * cos - along * sin, MIDDLE[1] + across * sin + along * cos];
    scene.regions[0].polygon = vec![corner(-far, 0.0), corner(-far, far), corner(far, far), corner(far, 0.0)];
    let first = scene.water.map_or(0.0, |water| water.hydraulic_conductivity);
    scene.regions[0].soil.hydraulic_conductivity = first / RATIO;
    let cell = scene.height / cells;
    let range = |i: usize| [i as f64 * cell, (i + 1) as f64 * cell];
    let middle = |i: usize| (i as f64 + 0.5) * cell;
    let face = |on: Side, i: usize| {
        let upright = matches!(on, Side::Left | Side::Right);
        let place = match on {
            Side::Left => [0.0, middle(i)],
            Side::Right => [scene.width, middle(i)],
            Side::Bottom => [middle(i), 0.0],
            Side::Top => [middle(i), scene.height],
        };
        let (x, y) = if upright { (None, Some(range(i))) } else { (Some(range(i)), None) };
        FaceLoad { on: Some(on), x, y, bearing: Bearing::Reservoir, course: Course::Times(vec![[0.0, head(place)]]) }
    };
    let [columns, rows] = scene.cells;
    let sides = [(Side::Left, rows), (Side::Right, rows), (Side::Bottom, columns), (Side::Top, columns)];
    scene.loads =
        sides.into_iter().flat_map(|(on, count)| (0..count).map(move |i| (on, i))).map(|(on, i)| face(on, i)).collect();
}

/// Heads against those of streamlines that are refracted, over what the head falls by in the block: root of the mean square.
fn refracted(scene: &Scene) -> Measured {
    let weight = scene.water.map_or(f64::NAN, |water| water.unit_weight);
    let span = head([0.0, 0.0]) - head([scene.width, scene.height]);
    Ok(Box::new(move |run| {
        let field = last_field(run);
        let square = |at: &FieldPoint| ((at.pressure_pa / weight + at.y_m - head([at.x_m, at.y_m])) / span).powi(2);
        (field.iter().map(square).sum::<f64>() / field.len() as f64).sqrt()
    }))
}

/// Pore pressures over that at the base, `rho_w g d cos(b)`.
fn hydrostatic(scene: &Scene) -> Measured {
    let weight = -scene.water_weight()[1];
    let height = scene.height;
    Ok(Box::new(move |run| {
        largest(last_field(run).iter().map(|at| (at.pressure_pa - weight * (height - at.y_m)) / (weight * height)))
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streamlines_are_refracted() {
        // Two places on the interface and one beside it on either side: one head, one normal flux, tan(a)/tan(b) = k1/k2.
        let (normal, along) = ([TURNED.cos(), TURNED.sin()], [-TURNED.sin(), TURNED.cos()]);
        let at =
            |n: f64, t: f64| head([MIDDLE[0] + n * normal[0] + t * along[0], MIDDLE[1] + n * normal[1] + t * along[1]]);
        let step = 1e-6;
        for t in [-0.3, 0.2] {
            let slope = |n: f64| {
                [(at(n + step, t) - at(n - step, t)) / (2.0 * step), (at(n, t + step) - at(n, t - step)) / (2.0 * step)]
            };
            let ([n1, t1], [n2, t2]) = (slope(-0.1), slope(0.1));
            assert!((n2 / n1 - RATIO).abs() < 1e-6 && (t2 / t1 - 1.0).abs() < 1e-6);
            // Flux: k_1 n_1 = k_2 n_2; angles to the normal.
            assert!(((t1 / n1) / (t2 / n2) - RATIO).abs() < 1e-6);
        }
        assert!((at(-1e-9, 0.1) - at(1e-9, 0.1)).abs() < 1e-8);
    }
}

//! Soil that starts under its weight with a water table anywhere stays where it is: no node is faster than round-off.
//!
//! Speeds are compared with that of soil that falls freely for as many steps, `g dt N`. What round-off leaves of a balance of
//! stresses over `rows` cells is `eps rows` of the weight of a cell, in every step.

use mpm_core::run::model;
use mpm_core::scene::Scene;
use mpm_core::stability::choose_step;

/// Steps.
const STEPS: u64 = 100;
const GRAVITY: f64 = 9.81;
/// Round-off of one addition, of which a node has some tens in a step.
const ROUND_OFF: f64 = 32.0 * f64::EPSILON;

const GEOMETRIES: [(&str, &str); 5] = [
    ("column", "geometry.column = { height = 2.0, width = 0.5 }"),
    ("block", "dimension = \"plane-strain\"\ngeometry.column = { height = 2.0, width = 1.0 }"),
    ("outline", "dimension = \"plane-strain\"\ngeometry.outline = { points = [[0, 0], [1, 0], [1, 2], [0, 2]] }"),
    (
        "outline whose surface cuts cells",
        "dimension = \"plane-strain\"\ngeometry.outline = { points = [[0, 0], [1, 0], [1, 2.1], [0, 2.1]] }",
    ),
    ("slope", "dimension = \"plane-strain\"\ngeometry.outline = { points = [[0, 0], [4, 0], [4, 1], [2, 2], [0, 2]] }"),
];
const SOILS: [(&str, &str); 4] = [
    ("one soil", ""),
    (
        "layers",
        "[[layers]]\nup_to = 0.75\ngrain_density = 2900\nporosity = 0.3\nstart_k0 = 0.4\n[[layers]]\nup_to = TOP\nporosity = 0.5\nstart_k0 = 0.9\n",
    ),
    (
        "a region between faces of particles",
        "[[regions]]\nlevels = [0.625, 1.375]\ngrain_density = 2900\nporosity = 0.3\nstart_k0 = 0.9\n",
    ),
    (
        "a region that cuts particles",
        "[[regions]]\nlevels = [0.57, 1.31]\ngrain_density = 2900\nporosity = 0.3\nstart_k0 = 0.9\n",
    ),
];
const WATERS: [(&str, &str, &str); 9] = [
    ("dry", "", ""),
    ("full", "WATER", ""),
    ("full under a reservoir", "WATER", "[[reservoirs]]\non = \"top\"\nlevel = 2.6\n"),
    ("table on a face", "WATER\nfree_surface = { level = 1.0 }", ""),
    ("table in a cell", "WATER\nfree_surface = { level = 1.0925 }", ""),
    ("table in a cell under moist soil", "WATER\nfree_surface = { level = 1.0925, saturation = 0.4 }", ""),
    ("table near the base", "WATER\nfree_surface = { level = 0.09, saturation = 0.4 }", ""),
    ("table at the top", "WATER\nfree_surface = { level = TOP }", ""),
    ("table under a reservoir", "WATER\nfree_surface = { level = TOP }", "[[reservoirs]]\non = \"top\"\nlevel = 2.6\n"),
];
const INTEGRATORS: [&str; 4] = ["explicit", "semi-implicit", "quasi-static", "staggered"];

fn text(geometry: &str, soil: &str, (water, outside): (&str, &str), integrator: &str, count: usize) -> String {
    let top = if geometry.contains("2.1") { "2.1" } else { "2.0" };
    let water =
        water.replace("WATER", "[water]\nhydraulic_conductivity = 1e-4\nbulk_modulus = 2e8\nunit_weight = 9810");
    let clock = if integrator == "staggered" { "coupling = \"soil\"\n" } else { "" };
    // What stands outside is felt inside when the pressures have been solved for.
    let waits = integrator == "staggered" && !outside.is_empty();
    let seepage = if waits { "[[stages]]\ndrained = \"none\"\nuntil.time = 1.0\n" } else { "" };
    let drained = if water.is_empty() { "" } else { "drained = [\"top\"]\n" };
    let text = format!(
        "name = \"rest\"\nstart = \"geostatic\"\ngravity = {GRAVITY}\n{geometry}
[mesh]\ncell = 0.25\nparticles_per_cell = {count}
[soil]\ngrain_density = 2650\nporosity = 0.4
law.linear_elastic = {{ youngs_modulus = 1e7, poisson_ratio = 0.3 }}
{soil}{water}\n{outside}
[time]\nintegrator = \"{integrator}\"
{seepage}[[stages]]\n{drained}{clock}until.time = 1.0\n"
    );
    text.replace("TOP", top)
}

/// Largest speed of a node or a particle after some steps over that of free fall; of a quasi-static run the displacement over a
/// second of free fall's.
fn speed(scene: &Scene) -> Result<f64, String> {
    let mut model = model(scene).map_err(|e| e.to_string())?;
    let dt = choose_step(scene).map_err(|e| e.to_string())?;
    let end = if dt.is_finite() { dt * STEPS as f64 } else { 1.0 };
    let mut done = 0;
    if let [seepage, _] = &scene.stages[..] {
        model.enter_stage(seepage, &[1.0]).map_err(|e| e.to_string())?;
        model.advance(1.0, 1, &mut done).map_err(|e| e.to_string())?;
        while model.left() > 0.0 {
            model.advance(model.left(), 1, &mut done).map_err(|e| e.to_string())?;
        }
    }
    model.enter_stage(&scene.stages[scene.stages.len() - 1], &[end]).map_err(|e| e.to_string())?;
    if !dt.is_finite() {
        model.advance(end, 1, &mut done).map_err(|e| e.to_string())?;
        let moved = model.observe().0.settlement.abs();
        return Ok(moved / (0.5 * GRAVITY));
    }
    model.advance(dt, STEPS, &mut done).map_err(|e| e.to_string())?;
    let (fastest, nodes) = (model.observe().0.max_speed, model.grid_speed());
    let fastest = if nodes.is_finite() { fastest.max(nodes) } else { fastest };
    Ok(fastest / (GRAVITY * end))
}

/// What round-off, or what is not exact, may leave; `None` where soil has to come to rest first.
fn allowed(scene: &Scene, [geometry, soil, water, integrator]: [&str; 4]) -> Option<f64> {
    let exact = ROUND_OFF * scene.cells[1] as f64;
    let staggered = integrator == "staggered";
    // Pores that differ inside a cell: its water is one amount, spread over its soil alike. At most a quarter of what is between the
    // two soils pushes, until a wave has passed the cell: one step.
    let pores = 0.25 * 0.1 * 1000.0 / scene.dry_density() / STEPS as f64;
    let cut = geometry.ends_with("cuts cells");
    match (soil.starts_with("a region"), water) {
        _ if geometry == "slope" => None,
        // The water of a cell that the surface cuts weighs in its middle, and so does what presses it from outside.
        (_, "table at the top" | "table under a reservoir") if cut && staggered => None,
        // The seepage is solved to a tolerance.
        (false, "table under a reservoir") => Some(1e-6_f64.max(exact)),
        (true, water) if water != "dry" => Some(pores),
        _ => Some(exact),
    }
}

#[test]
fn soil_at_rest_stays_at_rest() {
    let (mut wrong, mut ran) = (Vec::new(), 0);
    for (geometry, shape) in GEOMETRIES {
        for (soil, layers) in SOILS {
            for (water, pores, outside) in WATERS {
                for integrator in INTEGRATORS {
                    for count in [4, 9] {
                        // Where it passes through their middles, round-off says which soil particles are of.
                        if count == 9 && soil.contains("between faces") {
                            continue;
                        }
                        let text = text(shape, layers, (pores, outside), integrator, count);
                        let name = format!("{geometry}, {soil}, {water}, {integrator}, {count} per cell");
                        let scene = match Scene::parse(&text, "rest.toml") {
                            Ok(scene) => scene,
                            Err(e) => {
                                if std::env::var_os("SHOW_REFUSED").is_some() {
                                    eprintln!("{name}: {e}");
                                }
                                continue;
                            }
                        };
                        let allowed = allowed(&scene, [geometry, soil, water, integrator]);
                        ran += usize::from(allowed.is_some());
                        match (speed(&scene), allowed) {
                            (Ok(speed), Some(allowed)) if speed > allowed => {
                                wrong.push(format!("{speed:.2e} above {allowed:.2e} {name}"));
                            }
                            (Ok(speed), allowed) if std::env::var_os("SHOW_SPEEDS").is_some() => {
                                eprintln!("{speed:.2e} of {allowed:?} {name}");
                            }
                            (Err(e), _) => wrong.push(format!("{name}: {e}")),
                            _ => {}
                        }
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {ran}:\n{}", wrong.len(), wrong.join("\n"));
}

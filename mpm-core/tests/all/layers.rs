//! Soil in layers: the same bits where all layers are alike, ledgers that close where they are not, one dimension and
//! plane strain alike, and the worst layer decides the step.

use crate::common::{apart, completed, edited, scene, terzaghi};
use mpm_core::drive::Run;
use mpm_core::run::run;
use mpm_core::scene::{
    Dimension, Integrator, Scene, ShapeChoice, SoilLayer, StepChoice, StrainChoice, Surcharge, Until,
};
use mpm_core::stability::stable_limit;

const DYNAMIC: [ShapeChoice; 4] = [ShapeChoice::Centre, ShapeChoice::Linear, ShapeChoice::Gimp, ShapeChoice::Bspline2];

/// A short consolidation in cells of 10 cm; the upper and the lower half with so much of E and k.
fn halves(integrator: Integrator, shape: ShapeChoice, shares: [[f64; 2]; 2]) -> Scene {
    let mut scene = scene(&["cell = 0.1", "particles_per_cell = 9", "until.time_factor = 0.2", "-time_factors"])
        .edited(|scene| (scene.integrator, scene.shape) = (integrator, shape))
        .expect("a sound scene");
    if integrator == Integrator::QuasiStatic {
        scene = scene
            .edited(|scene| (scene.strain, scene.darcy_inertia, scene.tolerance) = (StrainChoice::Small, false, 1e-6))
            .expect("a sound scene");
    }
    let water = scene.water.expect("a wet scene");
    let soil = |up_to: f64, [stiffer, faster]: [f64; 2]| {
        let mut soil = scene.soil();
        soil.elastic.youngs_modulus *= stiffer;
        soil.hydraulic_conductivity = faster * water.hydraulic_conductivity;
        SoilLayer { up_to, soil }
    };
    scene =
        scene.edited(|scene| scene.layers = vec![soil(0.5, shares[1]), soil(1.0, shares[0])]).expect("a sound scene");
    scene
}

fn alike(integrator: Integrator, shape: ShapeChoice) -> Scene {
    halves(integrator, shape, [[1.0; 2]; 2])
}

fn without_layers(scene: &Scene) -> Scene {
    scene.edited(|s| s.layers = Vec::new()).expect("a sound scene")
}

/// Settlements and pressures of all samples.
fn figures(run: &Run) -> Vec<f64> {
    let of = |s: &mpm_core::drive::Sample| {
        let pressures: Vec<f64> = s.state.profile.iter().map(|row| row.pressure_pa).collect();
        std::iter::once(s.state.settlement).chain(pressures)
    };
    run.samples.iter().flat_map(of).collect()
}

#[test]
fn layers_that_are_alike_are_one_soil_to_the_bit() {
    let shapes = |integrator| DYNAMIC.map(move |shape| (integrator, shape));
    let explicit = shapes(Integrator::Explicit).into_iter().chain(shapes(Integrator::SemiImplicit));
    let static_ones = [ShapeChoice::Centre, ShapeChoice::Linear, ShapeChoice::Gimp];
    for (integrator, shape) in explicit.chain(static_ones.map(|shape| (Integrator::QuasiStatic, shape))) {
        let layered = alike(integrator, shape);
        let (a, b) = (completed(&layered), completed(&without_layers(&layered)));
        assert_eq!(figures(&a), figures(&b), "{integrator:?} {shape:?}");
        let other = completed(&halves(integrator, shape, [[1.0, 1.0], [1.0, 1.0 - 1e-9]]));
        assert_ne!(figures(&a), figures(&other), "{integrator:?} {shape:?}: the check cannot fail");
    }
}

/// A load that moves the surface through cells leaves pores in which water is stiffer.
#[test]
fn layers_that_are_alike_have_the_limit_of_one_soil_under_large_strain() {
    for integrator in [Integrator::Explicit, Integrator::SemiImplicit] {
        for pressure in [1e4, 5e6, 2e7] {
            let under = |s: &mut mpm_core::scene::Fields| {
                s.surcharge = s.surcharge.map(|load| Surcharge { pressure, ..load });
                s.force = true;
            };
            let layered = alike(integrator, ShapeChoice::Centre).edited(under).expect("a sound scene");
            let limits = [&layered, &without_layers(&layered)].map(|scene| stable_limit(scene));
            assert_eq!(limits[0], limits[1], "{integrator:?} {pressure} Pa");
        }
    }
}

/// A region that ends in the middle of a cell, where one particle of three lies across its boundary.
#[test]
fn a_column_conducts_the_same_however_wide_it_is() {
    let of_width = |width: f64, top: f64| {
        let lines = [("cell = 0.02", "cell = 0.1"), ("width = 0.1", &format!("width = {width}"))];
        let region = format!("[[regions]]\nlevels = [0.0, {top}]\nhydraulic_conductivity = 5e-5\n");
        let scene = Scene::parse(&(edited(&terzaghi(), &lines) + &region), "scene.toml").expect("a sound scene");
        figures(&completed(&scene.edited(|s| s.particles_per_cell = 9).expect("a sound scene")))
    };
    let narrow = of_width(0.25, 0.55);
    assert!(narrow == of_width(4.0, 0.55), "the width matters");
    assert!(narrow != of_width(0.25, 0.6), "the check cannot fail");
}

#[test]
fn b_splines_that_may_bend_are_as_good() {
    let layered = alike(Integrator::QuasiStatic, ShapeChoice::Bspline2);
    let (a, b) = (completed(&layered), completed(&without_layers(&layered)));
    let last = |run: &Run| run.samples.last().expect("samples").state.settlement;
    assert!(apart(last(&a), last(&b)) < 1e-5, "{} {}", last(&a), last(&b));
}

#[test]
fn ledgers_close() {
    let shares = [[1.0, 1.0], [0.2, 0.01]];
    for (integrator, allowed) in [(Integrator::Explicit, 5e-3), (Integrator::SemiImplicit, 5e-2)] {
        for shape in DYNAMIC {
            let run = completed(&halves(integrator, shape, shares));
            let ledger = &run.samples.last().expect("samples").balance;
            let energy = (ledger.energy_residual_j / ledger.external_work_j).abs();
            let water = (ledger.water_residual_kg / ledger.water_out_kg).abs();
            println!("{integrator:?} {shape:?}: energy {energy:.1e}, water {water:.1e}");
            assert!(energy < allowed && water < 1e-4, "{integrator:?} {shape:?}: {energy:e} {water:e}");
            assert!(ledger.darcy_dissipation_j > 10.0 * allowed * ledger.external_work_j, "nothing to miss");
        }
    }
    for shape in DYNAMIC {
        let run = completed(&halves(Integrator::QuasiStatic, shape, shares));
        let ledger = &run.samples.last().expect("samples").balance;
        let water = (ledger.water_residual_kg / ledger.water_out_kg).abs();
        assert!(water < 1e-6, "{shape:?}: {water:e}");
    }
}

#[test]
fn a_column_and_plane_strain_agree() {
    let shares = [[1.0, 1.0], [0.2, 0.01]];
    let cases = [
        (Integrator::Explicit, ShapeChoice::Centre),
        (Integrator::SemiImplicit, ShapeChoice::Linear),
        (Integrator::QuasiStatic, ShapeChoice::Centre),
        (Integrator::QuasiStatic, ShapeChoice::Bspline2),
    ];
    for (integrator, shape) in cases {
        // One factor for both: in plane strain the usual one is larger.
        let penalty = shape.spline_degree().map(|_| 1e-4);
        let column = halves(integrator, shape, shares).edited(|s| s.jump_penalty = penalty).expect("a sound scene");
        let plane = column
            .edited(|plane| {
                (plane.dimension, plane.width, plane.cells[0]) = (Dimension::PlaneStrain, 0.2, 2);
            })
            .expect("a sound scene");
        let step = StepChoice::Fixed(0.5 * stable_limit(&plane).min(stable_limit(&column)).min(1.0));
        let scenes = [column, plane].map(|scene| match integrator {
            Integrator::QuasiStatic => scene,
            _ => scene.edited(|s| s.step = step).expect("a sound scene"),
        });
        let [a, b] = scenes.map(|scene| completed(&scene).samples.last().expect("samples").state.clone());
        assert!(apart(a.settlement, b.settlement) < 1e-7, "{integrator:?} {shape:?}");
        let rows = a.profile.iter().zip(&b.profile);
        let off = rows.map(|(a, b)| (a.pressure_pa - b.pressure_pa).abs()).fold(0.0, f64::max);
        assert!(off < 1e-2, "{integrator:?} {shape:?}: {off} Pa");
    }
}

/// Largest speed of a particle after 4000 steps, m/s; infinite for a run that stopped.
fn speed_after(scene: &Scene, step: f64) -> f64 {
    let end = 4000.0 * step;
    let scene = scene
        .edited(|scene| {
            (scene.step, scene.force) = (StepChoice::Fixed(step), true);
            scene.observe_times = vec![end];
            scene.stages[0].until = Until::Time(end);
        })
        .expect("a sound scene");
    let run = run(&scene, &mut |_| {}).expect("a forced step");
    if run.failure.is_some() { f64::INFINITY } else { run.samples.last().expect("samples").state.max_speed }
}

#[test]
fn the_worst_layer_decides_the_step() {
    let (soil, stiff, soft, fast) = ([1.0, 1.0], [100.0, 1.0], [0.01, 1.0], [1.0, 100.0]);
    let pairs = [[soil, fast], [soil, stiff], [soil, soft], [stiff, fast], [soft, [0.01, 100.0]]];
    for integrator in [Integrator::Explicit, Integrator::SemiImplicit] {
        for pair in pairs.into_iter().flat_map(|[a, b]| [[a, b], [b, a]]) {
            let mut layered = halves(integrator, ShapeChoice::Centre, pair);
            // The limit counts on no inertia in Darcy's law, and the load hardly strains the softest soil.
            layered = layered
                .edited(|layered| {
                    layered.darcy_inertia = false;
                    layered.surcharge = layered.surcharge.map(|s| Surcharge { pressure: 1e-3 * s.pressure, ..s });
                })
                .expect("a sound scene");
            let limit = stable_limit(&layered);
            let alone = layered.by_layer().iter().map(|(_, soil)| stable_limit(soil)).fold(f64::INFINITY, f64::min);
            assert_eq!(limit, alone);
            let [below, above] = [0.99, 1.5].map(|share| speed_after(&layered, share * limit));
            assert!(below < 1e-2 && above > 1.0, "{integrator:?} {pair:?}: {below} and {above} m/s");
        }
    }
}

/// A dry column under a load, with a law, and what may stand behind it.
fn dry_column(integrator: &str, law: &str, layers: &str) -> Scene {
    let text = format!(
        "name = \"laws\"\ngeometry.column = {{ height = 1.0, width = 0.1 }}\nmesh = {{ cell = 0.1, particles_per_cell = 4 }}\n\
         {integrator}\nsurcharge = {{ pressure = 1e4 }}\n{layers}\n\
         [[stages]]\nuntil.time = 1.0\ndamping = 0.0\n[soil]\ngrain_density = 2650\nporosity = 0.4\n{law}"
    );
    // A few passages of the wave, and strains of a percent, are enough for bits.
    let text = if integrator.contains("quasi-static") {
        text.replace("porosity", "strain = \"small\"\nporosity")
    } else {
        text.replace("until.time = 1.0", "until.time = 0.05").replace("pressure = 1e4", "pressure = 3e3")
    };
    Scene::parse(&text, "laws.toml").unwrap_or_else(|error| panic!("{error}"))
}

const CLAY: &str = "law.modified_cam_clay = { lambda = 0.1, kappa = 0.02, bulk_modulus = 1e7, poisson_ratio = 0.3, \
                    critical_slope = 1.0, preconsolidation = 2e3, attraction = 1e3 }";
const SAND: &str =
    "law.mohr_coulomb = { youngs_modulus = 1e7, poisson_ratio = 0.25, cohesion = 500.0, friction_angle = 20.0 }";
const ROCK: &str = "law.linear_elastic = { youngs_modulus = 1e8, poisson_ratio = 0.2 }";
const STATIC: &str = "time = { integrator = \"quasi-static\", tolerance = 1e-8 }";

#[test]
fn layers_of_different_laws_settle_by_the_sum_of_what_each_would_alone() {
    let settled = |scene: &Scene| completed(scene).samples.last().expect("a sample").state.settlement;
    let alone = [CLAY, SAND, ROCK].map(|law| settled(&dry_column(STATIC, law, "")));
    let layers =
        format!("[[layers]]\nup_to = 0.3\n{CLAY}\n[[layers]]\nup_to = 0.7\n{SAND}\n[[layers]]\nup_to = 1.0\n{ROCK}");
    let sum = 0.3 * alone[0] + 0.4 * alone[1] + 0.3 * alone[2];
    for base in [CLAY, SAND, ROCK] {
        let layered = settled(&dry_column(STATIC, base, &layers));
        assert!((layered / sum - 1.0).abs() < 1e-6, "{layered} for {sum}: {alone:?}");
    }
    // Each of them counts: soil and sand yield, rock does not.
    assert!(alone[0] > 3.0 * alone[2] && alone[1] > 3.0 * alone[2], "{alone:?}");
}

#[test]
fn layers_of_one_plastic_law_are_one_soil_to_the_bit() {
    for law in [CLAY, SAND] {
        let layers = ["", "[[layers]]\nup_to = 0.5\n[[layers]]\nup_to = 1.0"];
        let [one, two] = layers.map(|layers| figures(&completed(&dry_column("", law, layers))));
        assert_eq!(one, two, "{law}");
    }
}

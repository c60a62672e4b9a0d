//! Water with a free surface beside soil: what one leaves to the other, and what is booked.

use mpm_core::drive::Run;
use mpm_core::run::run;
use mpm_core::scene::{Coupling, Fabric, FreeSurfaceWater, Integrator, NormalStress, Scene, Until, WaterProperties};

fn scene(name: &str) -> Scene {
    let path = format!("{}/../reference-data/scenes/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    Scene::load(path.as_ref()).unwrap()
}

fn finished(scene: &Scene) -> Run {
    let run = run(scene, &mut |_| {}).unwrap();
    assert_eq!(run.failure, None);
    run
}

/// A dam that has not yet wetted its last column.
fn short_dam() -> Scene {
    scene("dam")
        .edited(|scene| {
            (scene.cell, scene.cells) = (0.1, [10, 10]);
            scene.stages[0].until = Until::Time(200.0);
            (scene.observe_times, scene.history) = (vec![50.0, 200.0], 0);
        })
        .expect("a sound scene")
}

#[test]
fn the_same_scene_gives_the_same_bits() {
    let [a, b] = [0, 1].map(|_| finished(&short_dam()));
    assert_eq!(a.samples, b.samples);
}

#[test]
fn still_water_holds_soil_at_rest_up_to_its_buoyant_weight() {
    let scene = scene("dam")
        .edited(|scene| {
            scene.start = mpm_core::scene::Start::Geostatic;
            let free = scene.free_surface.as_mut().unwrap();
            (free.feeds, free.level) = ([None; 4], Some(0.6));
            let mut stage = scene.stages[0].clone();
            scene.stages[0].drained = [false; 4];
            scene.stages[0].until = Until::Time(100.0);
            stage.coupling = Coupling::Soil;
            stage.until = Until::Time(0.2);
            scene.stages.push(stage);
            (scene.observe_times, scene.history) = (vec![0.2], 0);
            scene.solid_sides = [mpm_core::scene::SolidSide::Roller; 4];
        })
        .expect("a sound scene");
    let run = finished(&scene);
    let last = run.samples.last().unwrap();
    // Falling freely the soil would have 2 m/s.
    assert!(last.state.max_speed < 1e-9, "{}", last.state.max_speed);
    let bottom = last.state.profile[0];
    let depth = 0.6 - bottom.height_m;
    assert!((bottom.pressure_pa - 9810.0 * depth).abs() < 1e-6 * 9810.0);
    let total = 9.81 * (0.7 * 1800.0 * (1.0 - bottom.height_m) + 0.3 * 1000.0 * depth);
    assert!((bottom.effective_stress_pa + total - 9810.0 * depth).abs() < 1e-6 * total);
}

#[test]
fn cells_weigh_what_their_water_does_even_where_round_off_leaves_less_than_none() {
    let scene = scene("infiltration")
        .edited(|scene| {
            scene.particles_per_cell = 9;
            scene.stages[0].until = Until::Time(31.0);
            (scene.observe_times, scene.history) = (vec![10.0, 20.0, 31.0], 0);
        })
        .expect("a sound scene");
    for sample in finished(&scene).samples {
        // Contents below zero were once weighed as none: 5e-9 of what had come in.
        assert!(sample.balance.water_residual_kg.abs() <= 1e-12 * sample.balance.water_in_kg, "{:?}", sample.balance);
    }
}

#[test]
fn soil_that_has_moved_takes_its_water_along_or_books_it() {
    let mut scene = short_dam()
        .edited(|scene| {
            scene.solid_sides[1] = mpm_core::scene::SolidSide::Free;
            scene.empty_cells_beside = 6;
            scene.light_nodes = 0.1;
            scene.strength = Some(mpm_core::scene::Strength {
                cohesion: 0.0,
                friction_angle: 30.0,
                dilation_angle: 0.0,
                tension_cutoff: None,
                dilation_fades_over: None,
            });
        })
        .expect("a sound scene");
    let seepage = scene.stages[0].clone();
    let mut slide = seepage.clone();
    (slide.coupling, slide.until) = (Coupling::Soil, Until::Time(0.3));
    scene = scene.edited(|scene| scene.stages = vec![seepage.clone(), slide, seepage]).expect("a sound scene");
    let run = finished(&scene);
    let last = run.samples.last().unwrap();
    assert!(last.state.reach[0] > 1.1, "{}", last.state.reach[0]);
    let water = last.state.water.unwrap();
    assert!((water.mobile_m3 - water.in_m3 + water.out_m3).abs() < 1e-12 * water.in_m3, "{water:?}");
}

#[test]
fn a_pressure_that_is_held_works_on_soil_that_gains_volume() {
    let scene = scene("slope-seepage")
        .edited(|scene| {
            scene.history = 0;
            scene.stages[1].damping = 0.0;
            scene.stages[1].until = Until::Time(0.02);
            scene.observe_times = vec![0.02];
        })
        .expect("a sound scene");
    let run = finished(&scene);
    let ledger = run.samples.last().unwrap().balance;
    // Dilating soil under p: without that work most of the energy would come from nowhere. What is left is the return of the
    // first stress, which lies far outside the surface: one large step.
    let moved = ledger.gravity_work_j.abs() + ledger.pressure_work_j + ledger.plastic_dissipation_j;
    assert!(ledger.pressure_work_j > 0.5 * moved, "{ledger:?}");
    assert!(ledger.energy_residual_j.abs() < 0.15 * moved, "{ledger:?}");
}

/// The infinite slope of 20 degrees on a base of 30 degrees, full of water, let go for 0.2 s: its acceleration, m/s2, from
/// how far its middle has come.
fn wet_slope(normal_stress: NormalStress) -> f64 {
    let scene = scene("infinite-slope")
        .edited(|scene| {
            scene.integrator = Integrator::Staggered;
            scene.water = Some(WaterProperties {
                hydraulic_conductivity: 1e-4,
                anisotropy: 1.0,
                fabric: Fabric::default(),
                bulk_modulus: f64::INFINITY,
                unit_weight: 9810.0,
                density: 1000.0,
            });
            scene.free_surface = Some(FreeSurfaceWater {
                saturation: 0.0,
                level: Some(scene.height),
                wet: None,
                suction: None,
                retention: None,
                heads: Default::default(),
                feeds: [None; 4],
                courses: Default::default(),
            });
            scene.base.as_mut().unwrap().normal_stress = normal_stress;
            let mut slide = scene.stages[0].clone();
            scene.stages[0].until = Until::Time(1.0);
            (slide.coupling, slide.until) = (Coupling::Soil, Until::Time(0.2));
            scene.stages.push(slide);
            (scene.observe_times, scene.history) = (vec![0.2], 0);
        })
        .expect("a sound scene");
    let run = finished(&scene);
    let middle = |sample: &mpm_core::drive::Sample| sample.state.centre[0];
    2.0 * (middle(run.samples.last().unwrap()) - middle(&run.samples[0])) / 0.2_f64.powi(2)
}

#[test]
fn a_wet_base_holds_by_effective_stress() {
    // tau/sigma = tan 20 is below tan 30, tau/sigma' = tan 20 rho/(rho - rho_w) above it.
    assert!(wet_slope(NormalStress::Total) < 1e-9);
    let (angle, density) = (20_f64.to_radians(), 0.7 * 2700.0 + 300.0);
    let acceleration = 9.81 * (angle.sin() - angle.cos() * 30_f64.to_radians().tan() * (density - 1000.0) / density);
    let found = wet_slope(NormalStress::Effective);
    assert!((found / acceleration - 1.0).abs() < 0.05, "{found} m/s2, expected {acceleration}");
}

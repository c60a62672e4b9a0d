//! States that a scene gives at t = 0: along the height, in a table, from another run.

use std::path::PathBuf;

use mpm_core::drive::{Monitor, Run, Wish};
use mpm_core::hardware::Hardware;
use mpm_core::observe::SolidState;
use mpm_core::run::{model, run_monitored};
use mpm_core::scene::{Integrator, Scene, ShapeChoice, SolidSide, Until};
use mpm_core::step::Model;

/// A column (or a block) of the given integrator with an excess pressure and an unbalanced vertical stress.
fn text(dimension: &str, initial: &str) -> String {
    format!(
        "name = \"given\"\ndimension = \"{dimension}\"\nstart = \"given\"
[initial]
{initial}
[geometry.column]
height = 1.0
width = 0.5
[mesh]
cell = 0.125
particles_per_cell = 4
[soil]
grain_density = 2650
porosity = 0.4
law.linear_elastic = {{ youngs_modulus = 1e7, poisson_ratio = 0.3 }}
[water]
hydraulic_conductivity = 1e-4
bulk_modulus = 2e9
unit_weight = 9810
[[stages]]
drained = [\"top\"]
until.time = 1e-4
"
    )
}

fn file(name: &str, text: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("mpm-initial-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join(name);
    std::fs::write(&path, text).expect("a file");
    path
}

/// Attends to a run for its end.
struct End(Vec<SolidState>);

impl Monitor for End {
    fn look(&mut self, _: f64) -> Wish {
        Wish::GoOn
    }

    fn save(&mut self, _: Vec<u8>) {}

    fn ended(&mut self, model: &dyn Model) {
        self.0 = model.particles();
    }
}

fn ended(scene: &Scene) -> (Run, Vec<SolidState>) {
    let mut end = End(Vec::new());
    let run = run_monitored(&Hardware::default(), scene, None, &mut end).expect("a run");
    assert_eq!(run.failure, None);
    (run, end.0)
}

#[test]
fn a_table_is_exact_at_its_points_and_for_linear_fields() {
    let of = |x: f64, y: f64| [1e3 - 2e3 * x + 7e3 * y, y, x, -3.0, 3.0 * x - y];
    let mut points = Vec::new();
    for (i, j) in (0..9).flat_map(|i| (0..7).map(move |j| (f64::from(i), f64::from(j)))) {
        points.push([i + 0.1 * j, j - 0.2 * (i % 2.0)]);
    }
    let row = |[x, y]: [f64; 2]| {
        let [p, xx, yy, zz, xy] = of(x, y);
        format!("{x:e}, {y:e}, {xx:e}, {p:e}, {yy:e}, {xy:e}, {zz:e}\n")
    };
    let header = "x_m, y_m, stress_xx_pa, pressure_pa, stress_yy_pa, stress_xy_pa, stress_zz_pa\n";
    let rows: String = points.iter().map(|x| row(*x)).collect();
    let path = file("plane.csv", &format!("{header}{rows}"));
    let scene_file = file("plane.toml", &text("plane-strain", "table = \"plane.csv\""));
    let scene = Scene::load(&scene_file).expect("a sound scene");
    let initial = scene.initial.as_ref().expect("a state");
    assert!(points.iter().all(|x| initial.at(x) == of(x[0], x[1])));
    for [x, y] in [[0.33, 1.77], [4.5, 3.01], [9.5, -1.0], [2.0, 8.0]] {
        let off = initial.at(&[x, y]).iter().zip(of(x, y)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-11 * 7e4, "{off:e} at {x}, {y}");
    }
    // What was changed is still read from there.
    let same = scene.edited(|_| {}).expect("a sound scene");
    assert_eq!(same, scene);
    std::fs::write(&path, format!("{header}{}", row([0.0, 0.0]))).expect("a file");
    let one = Scene::load(&scene_file).expect("a sound scene");
    assert_eq!(one.initial.as_ref().map(|initial| initial.at(&[7.0, 7.0])), Some(of(0.0, 0.0)));
    // A line of points says nothing of what is across it.
    std::fs::write(&path, format!("{header}{}", (0..5).map(|j| row([0.5, f64::from(j)])).collect::<String>()))
        .expect("a file");
    let line = Scene::load(&scene_file).expect("a sound scene");
    let off = line.initial.as_ref().map_or(f64::NAN, |initial| initial.at(&[3.0, 2.3])[0] - of(0.5, 2.3)[0]);
    assert!(off.abs() < 1e-11 * 7e4, "{off:e}");
}

#[test]
fn a_profile_goes_on_in_lines_and_may_jump() {
    let scene =
        Scene::parse(&text("column", "pressure = [[0, 1], [1, 3], [1, 5], [2, 5]]"), "given.toml").expect("a scene");
    let initial = scene.initial.as_ref().expect("a state");
    assert_eq!([-1.0, 0.5, 1.0, 1.5, 7.0].map(|y| initial.at(&[0.0, y])[0]), [-1.0, 2.0, 5.0, 5.0, 5.0]);
    let table = file("profile.csv", "y_m,pressure_pa\n1,3\n0,1\n");
    let text = text("column", &format!("table = {:?}", table.display().to_string()));
    let scene = Scene::parse(&text, "given.toml").expect("a scene");
    assert_eq!(scene.initial.as_ref().map(|initial| initial.at(&[0.3, 0.5])), Some([2.0, 0.0, 0.0, 0.0, 0.0]));
}

#[test]
fn what_is_wrong_with_a_table_is_said_with_its_file_and_line() {
    let scene = file("wrong.toml", &text("plane-strain", "table = \"wrong.csv\""));
    let wrong = [
        ("", ":1: ", "found none"),
        ("y_m,pressure_pa\n", ":1: ", "found none"),
        ("y_m,pressure\n0,1\n", ":2: ", "pressure"),
        ("x_m,pressure_pa\n0,1\n", ":2: ", "y_m"),
        ("y_m,pressure_pa\n0,1\n1,two\n", ":3: ", "invalid float"),
        ("y_m,pressure_pa\n0,1\n1,nan\n", ":3: ", "NaN"),
        ("y_m,pressure_pa\n0,1\n1\n", ":3: ", "1 fields"),
    ];
    for (table, line, found) in wrong {
        let path = file("wrong.csv", table);
        let refused = Scene::load(&scene).expect_err("refused").to_string();
        let place = format!("{}{line}", path.display());
        assert!(refused.starts_with(&place) && refused.contains(found), "{table:?}: {refused}");
    }
    let missing = file("missing.toml", &text("plane-strain", "table = \"none.csv\""));
    let refused = Scene::load(&missing).expect_err("refused").to_string();
    assert!(refused.contains("missing.toml:5: initial.table: expected a table"), "{refused}");
}

/// Every integrator starts from the state that is given, whatever its shape.
#[test]
fn a_run_starts_from_what_is_given() {
    let initial =
        "pressure = [[0, 2e3], [1, 1e3]]\nstress_xx = -100\nstress_yy = [[0, 2e3], [1, 1e3]]\nstress_zz = -300";
    for dimension in ["column", "plane-strain"] {
        let base = Scene::parse(&text(dimension, initial), "given.toml").expect("a scene");
        for integrator in [Integrator::Explicit, Integrator::SemiImplicit, Integrator::QuasiStatic] {
            for shape in [ShapeChoice::Centre, ShapeChoice::BBar, ShapeChoice::Bspline2] {
                let edit = |scene: &mut mpm_core::scene::Fields| {
                    (scene.integrator, scene.shape, scene.darcy_inertia) = (integrator, shape, false);
                };
                let scene = base.edited(edit).expect("a scene");
                let mut model = model(&scene).expect("a model");
                model.enter_stage(&scene.stages[0], &[1e-4]).expect("a stage");
                for point in model.particles() {
                    let [_, yy, _, _] = point.stress;
                    let exact = 2e3 - 1e3 * point.x[1];
                    // Quasi-static functions that drain at a side have its pressure there from t = 0 on.
                    let inside = point.x[1] < 0.75;
                    let cell = if shape == ShapeChoice::Bspline2 && integrator == Integrator::QuasiStatic {
                        0.0
                    } else {
                        62.5
                    };
                    assert!(
                        !inside || (point.pore_pressure - exact).abs() < cell + 1e-9 * exact,
                        "{point:?} {integrator:?}"
                    );
                    let moved = integrator == Integrator::QuasiStatic;
                    assert!(moved || (yy - exact).abs() < 1e-9 * exact, "{point:?} {integrator:?}");
                }
            }
        }
    }
}

/// A run that starts from the end of another, on the same mesh, has its state to the last bit of the table.
#[test]
fn a_run_goes_on_from_the_state_of_another() {
    for (integrator, name) in [(Integrator::Explicit, "explicit"), (Integrator::QuasiStatic, "quasi-static")] {
        for dimension in ["column", "plane-strain"] {
            let scene =
                Scene::parse(&text(dimension, "pressure = 1e3\nstress_yy = 1e3"), "given.toml").expect("a scene");
            let edit = |scene: &mut mpm_core::scene::Fields| {
                (scene.integrator, scene.darcy_inertia) = (integrator, false);
            };
            let first = scene.edited(edit).expect("a scene");
            let (_, end) = ended(&first);
            assert!(!end.is_empty());
            let row = |s: &SolidState| {
                let [xx, yy, zz, xy] = s.stress;
                format!("{:e},{:e},{:e},{xx:e},{yy:e},{zz:e},{xy:e}\n", s.x[0], s.x[1], s.pore_pressure)
            };
            let header = "x_m,y_m,pressure_pa,stress_xx_pa,stress_yy_pa,stress_zz_pa,stress_xy_pa\n";
            let table = file(
                &format!("{name}-{dimension}.csv"),
                &format!("{header}{}", end.iter().map(row).collect::<String>()),
            );
            let next = text(dimension, &format!("table = {:?}", table.display().to_string()));
            let next = Scene::parse(&next, "given.toml").expect("a scene").edited(edit).expect("a scene");
            let initial = next.initial.as_ref().expect("a state");
            for point in &end {
                let [pressure, stress @ ..] = initial.at(&point.x);
                assert_eq!((pressure, stress), (point.pore_pressure, point.stress));
            }
            let (run, _) = ended(&next);
            let state = &run.samples[0].state;
            let before =
                end.iter().map(|s| s.volume * s.pore_pressure).sum::<f64>() / end.iter().map(|s| s.volume).sum::<f64>();
            assert!((state.mean_pressure - before).abs() < 1e-4 * before, "{} {before}", state.mean_pressure);
        }
    }
}

/// A wall that is taken away, and set up again, in every integrator: the soil moves in between alone.
#[test]
fn a_stage_holds_sides_of_its_own() {
    for integrator in [Integrator::Explicit, Integrator::SemiImplicit, Integrator::QuasiStatic] {
        let scene = Scene::parse(&text("plane-strain", "stress_xx = -1e4"), "given.toml").expect("a scene");
        let scene = scene.edited(|scene| {
            (scene.integrator, scene.darcy_inertia) = (integrator, false);
            scene.strain = match integrator {
                Integrator::QuasiStatic => mpm_core::scene::StrainChoice::Small,
                _ => mpm_core::scene::StrainChoice::Large,
            };
            scene.solid_sides[2] = SolidSide::Roller;
            let mut stage = scene.stages[0].clone();
            stage.until = Until::Time(1e-3);
            let mut released = stage.clone();
            released.solid_sides = Some([SolidSide::Roller, SolidSide::Free, SolidSide::Roller, SolidSide::Free]);
            (scene.stages, scene.observe_times) = (vec![stage.clone(), released, stage], vec![1e-3]);
        });
        let scene = scene.expect("a scene");
        // What is as in the scene is not said again.
        assert_eq!(scene.stages.iter().filter(|stage| stage.solid_sides.is_some()).count(), 1);
        let mut model = model(&scene).expect("a model");
        // Particles of small strain stay where they are: the block gets as thin as it gets wide.
        let right = |model: &dyn Model| match integrator {
            Integrator::QuasiStatic => model.observe().0.settlement,
            _ => model.particles().iter().map(|s| s.x[0]).fold(0.0, f64::max),
        };
        let mut reached = vec![right(&*model)];
        for stage in &scene.stages {
            model.enter_stage(stage, &[1e-3]).expect("a stage");
            let (steps, dt) = if integrator == Integrator::QuasiStatic { (1, 1e-3) } else { (20, 1e-5) };
            model.advance(dt, steps, &mut 0).expect("steps");
            reached.push(right(&*model));
        }
        let [start, held, released, again] = reached[..] else { panic!("{reached:?}") };
        let still = 1e-12 * scene.height;
        assert!((held - start).abs() < still && released > held + 1e3 * still, "{integrator:?} {reached:?}");
        // Held again it stays, but for what drains.
        assert!(
            integrator != Integrator::QuasiStatic || (again - released).abs() < 0.1 * (released - held),
            "{reached:?}"
        );
    }
}

//! Guards what wells take and put in: it is in the balances, it is shared alike by cells that meet in a well, and a run that is resumed goes on with
//! it. And conductivity that goes with the pores, in soils beside each other.

use mpm_core::drive::{Run, Sample};
use mpm_core::run::run;
use mpm_core::scene::Scene;

const BOX: &str = r#"
name = "box"
dimension = "plane-strain"
geometry.column = { height = 2.0, width = 2.0 }
mesh = { cell = 0.25, particles_per_cell = 4 }
soil = { grain_density = 2700.0, porosity = 0.4, @SMALL law.linear_elastic = { youngs_modulus = 1e7, poisson_ratio = 0.3 } }
water = { hydraulic_conductivity = 1e-4, bulk_modulus = 2e7, unit_weight = 9810.0 }
boundaries = { left = "roller", right = "roller", bottom = "roller", top = "roller" }
scheme.shape = "@SHAPE"
time.integrator = "@INTEGRATOR"
observe.times = [0.25, 0.5]
[[wells]]
at = [1.0, 1.0]
rate = 2e-4
times = [[0.0, 0.0], [0.2, 1.0], [0.3, 1.0], [0.4, 0.5]]
[[wells]]
at = [0.6, 0.9]
rate = -1e-4
[[stages]]
drained = ["left", "right"]
until.time = 0.5
"#;

fn scene(text: &str, integrator: &str, shape: &str) -> Scene {
    let small = if integrator == "quasi-static" { "strain = \"small\"," } else { "" };
    let text = text.replace("@INTEGRATOR", integrator).replace("@SHAPE", shape).replace("@SMALL", small);
    Scene::parse(&text, "box.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn finished(scene: &Scene) -> Run {
    let run = run(scene, &mut |_| {}).expect("a run");
    assert!(run.failure.is_none(), "{:?}", run.failure);
    run
}

fn last(run: &Run) -> &Sample {
    &run.samples[run.samples.len() - 1]
}

const SCHEMES: [[&str; 2]; 7] = [
    ["explicit", "centre"],
    ["explicit", "b-bar"],
    ["explicit", "bspline2"],
    ["semi-implicit", "centre"],
    ["semi-implicit", "gimp"],
    ["quasi-static", "centre"],
    ["quasi-static", "bspline2"],
];

#[test]
fn what_wells_take_and_put_in_is_in_the_balance() {
    // The integral of the polyline: 0.1 + 0.1 + 0.075 + 0.05 s.
    let (taken, put_in) = (2e-4 * 0.325, 1e-4 * 0.5);
    for [integrator, shape] in SCHEMES {
        let closed = BOX.replace("[\"left\", \"right\"]", "\"none\"");
        let scene = scene(&closed, integrator, shape);
        let run = finished(&scene);
        let ledger = &last(&run).balance;
        let density = scene.water.expect("water").density;
        // A step has the rate of its start or its end.
        let off = [ledger.water_out_kg / (density * taken) - 1.0, ledger.water_in_kg / (density * put_in) - 1.0];
        println!("{integrator} {shape}: {off:?}, closing {:.1e} kg", ledger.water_residual_kg);
        assert!(off.iter().all(|off| off.abs() < 5e-3), "{integrator} {shape}: {off:?}");
        assert!(ledger.water_residual_kg.abs() < 1e-3 * density * taken, "{integrator} {shape}");
        let energy = ledger.energy_residual_j / ledger.external_work_j.abs();
        println!("    energy {energy:.1e} of the work");
        assert!(run.trust.is_some_and(|trust| trust.verdict == "closed"), "{:?}", run.trust);
    }
}

/// A well on a corner of cells, and one in the middle of a cell of another mesh.
#[test]
fn wells_on_lines_of_the_mesh_are_even() {
    let alone: String = BOX.split("[[wells]]\nat = [0.6").next().expect("a well").to_owned()
        + "[[stages]]\ndrained = \"none\"\nuntil.time = 0.5\n";
    for [integrator, shape] in SCHEMES {
        let run = finished(&scene(&alone, integrator, shape));
        let field = &last(&run).state.field;
        let at = |x: f64, y: f64| {
            let off = |p: &&mpm_core::observe::FieldPoint| (p.x_m - x).abs() + (p.y_m - y).abs() < 1e-3;
            field.iter().find(off).expect("a cell").pressure_pa
        };
        let most = field.iter().fold(0.0, |most: f64, p| most.max(p.pressure_pa.abs()));
        for point in field {
            let (x, y) = (point.x_m, point.y_m);
            for mirrored in [at(2.0 - x, y), at(x, 2.0 - y), at(y, x)] {
                assert!((point.pressure_pa - mirrored).abs() < 1e-9 * most, "{integrator} {shape}: {x} {y}");
            }
        }
    }
}

/// Two soils of which one conducts as its pores let it: the other is as if it were alone.
#[test]
fn only_soils_that_ask_for_it_conduct_by_their_pores() {
    let column = r#"
name = "two"
geometry.column = { height = 1.0, width = 1.0 }
mesh = { cell = 0.1, particles_per_cell = 4 }
soil = { grain_density = 2700.0, porosity = 0.4, law.linear_elastic = { youngs_modulus = 1e7, poisson_ratio = 0.3 } }
water = { hydraulic_conductivity = 1e-4, bulk_modulus = 2e8, unit_weight = 9810.0 }
surcharge = { pressure = 7e5, ramp_time = 1.0 }
time.integrator = "semi-implicit"
[[layers]]
up_to = 0.5
kozeny_carman = @LOWER
[[layers]]
up_to = 1.0
[[wells]]
at = 0.0
rate = -2e-5
[[stages]]
drained = ["top"]
until.time = 60.0
"#;
    let pressures = |lower: &str| {
        let scene = Scene::parse(&column.replace("@LOWER", lower), "two.toml").expect("a scene");
        let run = finished(&scene);
        let row = |i: usize| last(&run).state.profile[i].pressure_pa;
        [row(1) - row(2), row(7) - row(8)]
    };
    let [[constant, above], [by_pores, still]] = ["false", "true"].map(pressures);
    // A strain of 5.2 %: n from 0.4 to 0.368, which conducts 0.70 times as well.
    assert!((constant / by_pores - 0.70).abs() < 0.02, "{}", constant / by_pores);
    // A particle that crosses a cell stirs the flow by half a percent for a while.
    assert!((still / above - 1.0).abs() < 1e-2, "{}", still / above);
}

//! Guards the implicit integrator where no exact solution does: soil in flight, waves that are damped, what a scene may ask of it.

use crate::common::completed;
use mpm_core::drive::Run;
use mpm_core::scene::{Scene, Waves};

/// A block of saturated soil between two loads that nothing holds.
const BLOCK: &str = "
name = \"flight\"
dimension = \"plane-strain\"
start = \"unloaded\"
start_velocity = [3.0, 4.0]
geometry.column = { height = 1.0, width = 1.0 }
mesh = { cell = 0.25, particles_per_cell = 4 }
boundaries = { left = \"free\", right = \"free\", bottom = \"free\", top = \"free\" }
loads = [{ on = \"top\", pressure = 1e4, ramp_time = 2e-3 }, { on = \"bottom\", pressure = 1e4, ramp_time = 2e-3 }]
[soil]
grain_density = 1800.0
porosity = 0.30
law.linear_elastic = { youngs_modulus = 2e7, poisson_ratio = 0.3 }
[water]
hydraulic_conductivity = 5e-4
bulk_modulus = 2.2e9
unit_weight = 9810.0
[time]
integrator = \"implicit\"
tolerance = 1e-3
[[stages]]
drained = [\"left\", \"right\"]
until.time = 0.02
[observe]
times = [0.01, 0.02]
";

fn scene(edits: &[(&str, &str)]) -> Scene {
    let text = edits.iter().fold(BLOCK.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    });
    Scene::parse(&text, "block.toml").expect("a sound scene")
}

fn last(run: &Run) -> &mpm_core::drive::Sample {
    run.samples.last().expect("samples")
}

#[test]
fn soil_in_flight_is_soil_at_rest() {
    let (flight, rest) = (completed(&scene(&[])), completed(&scene(&[("start_velocity = [3.0, 4.0]", "")])));
    let (a, b) = (last(&flight), last(&rest));
    let apart = (a.state.mean_pressure - b.state.mean_pressure).abs();
    assert!(apart < 1e-3 * 1e4 && b.state.mean_pressure > 1e3, "{apart} Pa");
    let [x, y] = a.state.centre;
    assert!((x - 0.56).abs() < 1e-5 && (y - 0.58).abs() < 1e-5, "{x} {y}");
    let balance = &a.balance;
    // The water that has left took its momentum along.
    let left = balance.water_out_kg / (balance.solid_mass_kg + balance.water_stored_kg);
    let (whole, carried) = (balance.momentum_n_s.abs(), balance.momentum_carried_n_s.abs());
    assert!((carried / whole - left).abs() < 0.1 * left + 1e-6, "{carried} of {whole} N s, {left} of the mass");
    assert!(balance.momentum_residual_n_s.abs() < 1e-8 * whole, "{balance:?}");
}

#[test]
fn waves_are_damped_where_they_are_not_asked_for() {
    let below = ", { on = \"bottom\", pressure = 1e4, ramp_time = 2e-3 }";
    let held = [("start_velocity = [3.0, 4.0]", ""), ("bottom = \"free\"", "bottom = \"fixed\""), (below, "")];
    let slow = [("hydraulic_conductivity = 5e-4", "hydraulic_conductivity = 1e-9"), (", ramp_time = 2e-3", "")];
    let late = [("time = 0.02", "time = 1e4"), ("[0.01, 0.02]", "[1e3, 1e4]")];
    let edits = [&held[..], &slow, &late].concat();
    let damped = scene(&edits);
    assert_eq!(damped.waves, Waves::Auto);
    let still = [("[time]", "[scheme]\nshape = \"bspline2\"\n[time]"), ("\"implicit\"", "\"quasi-static\"")];
    let still = scene(&[&edits[..], &still].concat());
    let (a, b) = (completed(&damped), completed(&still));
    assert!(a.work.accepted < 100, "{} steps", a.work.accepted);
    let (of, other) = (last(&a).state.settlement, last(&b).state.settlement);
    assert!((of / other - 1.0).abs() < 1e-3 && last(&a).state.max_speed < 1e-6, "{of} {other} m");
}

#[test]
fn what_the_integrator_has_no_use_for_is_refused() {
    let refused = |edits: &[(&str, &str)]| {
        let text = edits.iter().fold(BLOCK.to_owned(), |text, (from, to)| text.replace(from, to));
        Scene::parse(&text, "block.toml").expect_err("a refusal").to_string()
    };
    let scheme = |line: &str| refused(&[("[time]", &format!("[scheme]\n{line}\n[time]"))]);
    assert!(scheme("shape = \"centre\"").contains("expected shape = \"bspline2\" or \"bspline3\""));
    assert!(scheme("darcy_inertia = false\nrelative_acceleration = true").contains("water without inertia"));
    assert!(scheme("flip = 0.9").contains("scheme.flip"));
    assert!(refused(&[("tolerance = 1e-3", "tolerance = 1e-3\nmethod = \"sdirk\"")]).contains("time.method"));
    assert!(refused(&[("\"implicit\"\n", "\"quasi-static\"\nwaves = \"damped\"\n")]).contains("time.waves"));
}

//! Guards the quasi-static integrator: time error under control, equilibrium of nonlinear laws, one dimension equal to
//! two, new meshes, balances, and the errors of runs that cannot go on.

use crate::common::{MODULUS, SURCHARGE, apart, completed, scene};
use mpm_core::constitutive::{Flow, Law, LinearElastic, Materials, State};
use mpm_core::drive::{Run, drive};
use mpm_core::particles::SolidPoint;
use mpm_core::run::run;
use mpm_core::scene::{CamClay, Displaced, Scene, StrainChoice, TimeMethod, Until};
use mpm_core::step::quasi_static::{QuasiStatic, Seeding};
use nalgebra::SMatrix;

/// The study's column with B-splines on ten cells, small strain.
fn column(changes: &[&str]) -> Scene {
    let base = [
        "integrator = \"quasi-static\"",
        "shape = \"bspline2\"",
        "cell = 0.1",
        "particles_per_cell = 9",
        "porosity -> porosity = 0.30\nstrain = \"small\"",
        "step -> tolerance = 1e-8",
        "-safety",
        "-flip",
        "-darcy_inertia",
        "history = 0",
    ];
    scene(&[&base, changes].concat())
}

fn settlements(run: &Run) -> Vec<f64> {
    run.observed().map(|s| s.state.settlement).collect()
}

fn largest_difference(a: &Run, b: &Run) -> f64 {
    assert_eq!(a.samples.len(), b.samples.len());
    settlements(a).iter().zip(settlements(b)).map(|(a, b)| apart(*a, b)).fold(0.0, f64::max)
}

#[test]
fn both_time_methods_agree_and_count_their_work() {
    let krylov = completed(&column(&[]));
    let sdirk = completed(&column(&["tolerance -> tolerance = 1e-7\nmethod = \"sdirk\""]));
    assert!(largest_difference(&krylov, &sdirk) < 1e-7, "{}", largest_difference(&krylov, &sdirk));
    // One factorisation for all times of a linear stage, and not many more solves than it has times.
    assert_eq!((krylov.work.factorisations, krylov.work.rejected), (1, 0));
    assert!((8..=25).contains(&krylov.work.solves), "{:?}", krylov.work);
    assert_eq!(sdirk.steps, sdirk.work.accepted);
    // Five stages and an estimate per attempt, where nothing has to be iterated.
    assert_eq!(sdirk.work.solves, 6 * (sdirk.work.accepted + sdirk.work.rejected));
    assert!(sdirk.work.factorisations < sdirk.work.accepted + sdirk.work.rejected + 1, "{:?}", sdirk.work);
}

#[test]
fn a_basis_that_would_grow_too_large_gives_way_to_steps() {
    // A hundred cells watched from a millionth of the time on: one pole does not hold seven decades.
    let wide = ["cell = 0.01", "until.time_factor = 10.0", "time_factors = [1e-6, 1e-3, 0.1, 10.0]"];
    // With so little of the jump penalty as a late look needs.
    let scene = column(&[&wide[..], &["tolerance = 1e-6"]].concat())
        .edited(|s| s.jump_penalty = Some(1e-4))
        .expect("a sound scene");
    let refused =
        run(&scene.edited(|s| s.method = TimeMethod::Krylov).expect("a sound scene"), &mut |_| {}).expect("a start");
    let text = refused.failure.expect("a failure").to_string();
    assert!(text.contains("did not reach the tolerance 1e-6 with 60 basis vectors"), "{text}");
    let steps = completed(&scene);
    assert!(steps.work.factorisations > 1 && steps.steps == steps.work.accepted, "{:?}", steps.work);
}

#[test]
fn the_error_in_time_follows_the_tolerance() {
    let exact = completed(&column(&["tolerance = 1e-10"]));
    for (tolerance, method) in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6].into_iter().flat_map(|t| [(t, "sdirk"), (t, "krylov")]) {
        let line = format!("tolerance -> tolerance = {tolerance:e}\nmethod = \"{method}\"");
        let error = largest_difference(&exact, &completed(&column(&[&line])));
        assert!(error <= tolerance, "{method} {tolerance:e}: {error:.1e}");
    }
}

#[test]
fn fixed_steps_converge_with_order_four() {
    // From Tv = 0.1 on: before, the drained layer is thinner than a cell and the order is lower.
    let error = |steps: u32, exact: &Run| {
        let line = format!("tolerance -> step = {:e}\nmethod = \"sdirk\"", 0.728_743_079_775_280_9 / f64::from(steps));
        let run = completed(&column(&[&line, "time_factors = [0.5, 1.0]"]));
        largest_difference(exact, &run)
    };
    let exact = completed(&column(&["tolerance = 1e-10", "time_factors = [0.5, 1.0]"]));
    let (coarse, fine) = (error(40, &exact), error(80, &exact));
    let order = (coarse / fine).log2();
    assert!((3.5..4.8).contains(&order), "{coarse:.2e} {fine:.2e} {order:.2}");
}

#[test]
fn one_dimension_is_two_with_one_cell_across() {
    for shape in ["centre", "linear", "gimp", "bspline2"] {
        for strain in ["small", "large"] {
            let changes = |dimension: &'static str| {
                let shape = format!("shape = \"{shape}\"");
                let strain = format!("strain = \"{strain}\"");
                let both = column(&[
                    &shape,
                    &strain,
                    "tolerance = 1e-6",
                    "width = 0.2",
                    &format!("dimension = \"{dimension}\""),
                ]);
                // Only B-splines have a penalty.
                if shape.contains("bspline") {
                    return both.edited(|s| s.jump_penalty = Some(1e-3)).expect("a sound scene");
                }
                both
            };
            let (one, two) = (completed(&changes("column")), completed(&changes("plane-strain")));
            let difference = largest_difference(&one, &two);
            assert!(difference < 1e-8, "{shape} {strain}: {difference:.1e}");
            for (a, b) in one.samples.iter().zip(&two.samples) {
                assert!((a.state.mean_pressure - b.state.mean_pressure).abs() < 1e-8 * SURCHARGE, "{shape} {strain}");
            }
        }
    }
}

#[test]
fn places_of_the_particles_and_of_the_mesh_do_not_matter() {
    let even = completed(&column(&[]));
    for seed in 1..4 {
        let displaced = Displaced { smooth: 0.5, jitter: 0.25, seed };
        let moved = completed(&column(&[]).edited(|s| s.displaced = Some(displaced)).expect("a sound scene"));
        assert!(largest_difference(&even, &moved) < 1e-9, "{seed}");
    }
    for shift in [0.01, 0.2, 0.49, 0.51, 0.8, 0.99] {
        let shifted = completed(&column(&[]).edited(|s| s.shift = shift).expect("a sound scene"));
        assert!(largest_difference(&even, &shifted) < 2e-5, "{shift} {:.1e}", largest_difference(&even, &shifted));
    }
    // The particles' own volumes do not do it: the check can fail.
    let displaced = Displaced { smooth: 0.5, jitter: 0.25, seed: 1 };
    let plain = column(&["shape -> shape = \"bspline2\"\nquadrature = \"volumes\""]);
    let moved = completed(&plain.edited(|s| s.displaced = Some(displaced)).expect("a sound scene"));
    assert!(largest_difference(&even, &moved) > 1e-3);
}

#[test]
fn a_column_under_its_weight_stays_at_rest() {
    for shape in ["centre", "linear", "gimp", "bspline2"] {
        for strain in ["small", "large"] {
            let scene = column(&[
                &format!("shape = \"{shape}\""),
                &format!("strain = \"{strain}\""),
                "start = \"geostatic\"",
                "gravity = 9.81",
                "dimension = \"plane-strain\"",
                "width = 0.2",
                "-[surcharge]",
            ]);
            let run = completed(&scene);
            let last = &run.samples[run.samples.len() - 1];
            // Beside the settlement that the weight would cause, rho g H^2/(2 M).
            let whole = 0.5 * scene.mixture_density() * 9.81 / MODULUS;
            assert!(last.state.settlement.abs() < 1e-9 * whole, "{shape} {strain} {}", last.state.settlement);
            // Smooth functions know the pressure at the base, cells that in the middle of their lowest row.
            let depth = if shape == "bspline2" { 1.0 } else { 0.95 };
            assert!((last.state.base_pressure / (9810.0 * depth) - 1.0).abs() < 1e-9, "{shape} {strain}");
        }
    }
}

#[test]
fn load_is_carried_undrained_at_once_and_stages_follow_each_other() {
    let stages = "drained -> drained = \"none\"\nuntil.time = 1e-3\n[[stages]]\ndrained = [\"top\"]";
    let scene = column(&["start = \"unloaded\"", stages]);
    let run = completed(&scene);
    let undrained = run.samples.iter().rev().find(|s| s.stage == 0).expect("the first stage");
    let expected = scene.undrained_pressure();
    assert!((undrained.state.mean_pressure / expected - 1.0).abs() < 1e-9, "{}", undrained.state.mean_pressure);
    // Balances run on from stage to stage.
    let ledger = run.samples[run.samples.len() - 1].balance;
    assert!(ledger.water_out_kg > 0.03 && ledger.water_residual_kg.abs() < 1e-9 * ledger.water_out_kg, "{ledger:?}");
    let direct = completed(&column(&[]));
    for (a, b) in settlements(&run).iter().zip(settlements(&direct)) {
        assert!(apart(*a, b) < 1e-6, "{a} {b}");
    }
}

#[test]
fn a_ramp_and_a_step_end_alike() {
    let late = "until.time_factor = 6.0";
    let ramp = completed(&column(&["start = \"unloaded\"", "on -> ramp_time = 0.01", late]));
    let step = completed(&column(&["start = \"unloaded\"", late]));
    assert!(ramp.work.factorisations > 1, "a ramp is not for one factorisation");
    let last = |run: &Run| settlements(run).last().copied().expect("a sample");
    assert!(apart(last(&ramp), last(&step)) < 1e-6);
    let first = |run: &Run| settlements(run)[0];
    assert!(first(&ramp) < 0.9 * first(&step));
}

#[test]
fn balances_close() {
    for method in ["krylov", "sdirk"] {
        for shape in ["linear", "bspline2"] {
            let line = format!("tolerance -> tolerance = 1e-6\nmethod = \"{method}\"");
            let run = completed(&column(&[&line, &format!("shape = \"{shape}\"")]));
            let ledger = run.samples[run.samples.len() - 1].balance;
            assert!(ledger.water_out_kg > 0.03, "{ledger:?}");
            assert!(ledger.water_residual_kg.abs() < 1e-10 * ledger.water_out_kg, "{method} {shape} {ledger:?}");
            // A B-spline that drops to zero at the drained side at once takes its share of the first energy along.
            let lost = if shape == "linear" { 1e-5 } else { 1e-2 };
            assert!(ledger.energy_residual_j.abs() < lost * ledger.external_work_j, "{method} {shape} {ledger:?}");
        }
    }
}

#[test]
fn a_new_mesh_under_large_strain_keeps_the_soil() {
    // A final strain of 1 - exp(-0.9) = 59 %: new meshes on the way.
    let soft = MODULUS * SURCHARGE / (0.9 * MODULUS) / (MODULUS / 2.0e7);
    let changes = [
        "strain = \"large\"".to_owned(),
        "start = \"unloaded\"".to_owned(),
        format!("youngs_modulus = {soft:e}"),
        // Pores that so much strain leaves.
        "porosity = 0.8".to_owned(),
        "tolerance = 1e-4".to_owned(),
        "until.time_factor = 8.0".to_owned(),
        "time_factors = [0.1, 1.0, 8.0]".to_owned(),
        "history = 20".to_owned(),
    ];
    for (shape, allowed) in [("bspline2", 2e-3), ("linear", 2e-2)] {
        let mut all: Vec<&str> = changes.iter().map(String::as_str).collect();
        let shape_line = format!("shape = \"{shape}\"");
        all.push(&shape_line);
        let run = completed(&column(&all));
        let last = &run.samples[run.samples.len() - 1].state;
        let expected = 1.0 - (-0.9_f64).exp();
        assert!(apart(last.settlement, expected) < allowed, "{shape} {} {expected}", last.settlement);
        assert!(last.solid_crossings > 20);
    }
}

/// A law that gets stiffer with its stress: d sigma/d eps = M (1 - sigma/r), so that sigma = r (1 - exp(-M eps/r)).
/// Tension has a limit r, compression none. With `weak` the limit is in compression instead.
#[derive(Debug, Clone, Copy)]
struct Curved {
    reference: f64,
}

impl Law for Curved {
    fn update(&self, stress: &mut [f64; 4], strain: &[f64; 4], _: &mut State) -> Flow {
        let r = self.reference;
        stress[1] = r - (r - stress[1]) * (-MODULUS * strain[1] / r).exp();
        Flow::none(0.0)
    }

    fn tangent(&self, stress: &[f64; 4], strain: &[f64; 4], state: &State) -> SMatrix<f64, 4, 4> {
        let mut stress = *stress;
        self.update(&mut stress, strain, &mut state.clone());
        SMatrix::from_diagonal(&[1.0, MODULUS * (1.0 - stress[1] / self.reference), 1.0, 1.0].into())
    }

    /// `int sigma d eps` from rest.
    fn energy(&self, stress: &[f64; 4]) -> f64 {
        let share = stress[1] / self.reference;
        -self.reference * self.reference / MODULUS * (share + (-share).ln_1p())
    }
}

/// The column with another law.
fn with_law<L: Law>(scene: &Scene, law: L) -> Run {
    let count = scene.cells[1] * 3;
    let spacing = 1.0 / count as f64;
    let volume = scene.width * spacing;
    let point = |i: usize| SolidPoint {
        x: [(i as f64 + 0.5) * spacing],
        v: [0.0],
        stress: [0.0; 4],
        mass: scene.dry_density() * volume,
        volume,
    };
    let mut model = QuasiStatic::<L, 1>::new(
        scene,
        Seeding {
            points: (0..count).map(point).collect(),
            law: Materials::one(law, 1.0 / scene.grain_density),
            top: vec![count - 1],
            thickness: scene.width,
            first_pressure: |_, _| 0.0,
            first_settlement: 0.0,
        },
    );
    drive(scene, &mut model, f64::INFINITY, &mut |_| {})
}

#[test]
fn nonlinear_laws_reach_equilibrium() {
    let scene = column(&["start = \"unloaded\"", "until.time_factor = 6.0", "tolerance = 1e-6"]);
    // Stiffening: at the end sigma' = -q everywhere.
    let reference = 0.3 * SURCHARGE;
    let run = with_law(&scene, Curved { reference });
    assert_eq!(run.failure, None);
    let expected = reference / MODULUS * (1.0 + SURCHARGE / reference).ln();
    let found = run.samples[run.samples.len() - 1].state.settlement;
    assert!(apart(found, expected) < 1e-5, "{found:e} {expected:e}");
    // The linear law through the nonlinear path.
    let elastic = mpm_core::scene::Elastic { youngs_modulus: 2.0e7, poisson_ratio: 0.3 };
    let linear = with_law(
        &scene.edited(|s| s.method = TimeMethod::Krylov).expect("a sound scene"),
        LinearElastic::new(&elastic),
    );
    let large = scene.edited(|s| s.strain = StrainChoice::Large).expect("a sound scene");
    let finite = with_law(&large, LinearElastic::new(&elastic));
    assert!(largest_difference(&linear, &finite) < 1e-3);
}

/// A dry column whose load grows to `SURCHARGE` over a second.
fn dry(step: &str) -> Scene {
    let scene = column(&[
        "start = \"unloaded\"",
        "-[water]",
        "-darcy",
        "drained -> until.time = 1.0",
        "-until.time_factor",
        "time_factors -> times = [0.25, 0.5, 1.0]",
        "on -> ramp_time = 1.0",
        step,
    ]);
    // The laws below store no energy that the balance could find.
    scene.edited(|s| s.force = true).expect("a sound scene")
}

/// A row of `reference-data/exact/13_cam_clay_oedometer.csv`: logarithmic strain of normally consolidated Cam-Clay from an isotropic
/// state, of slopes a hundred times those below, and the vertical stress over the first one, which is the attraction.
const COMPRESSED: [f64; 2] = [0.12, 3.732_517_389_252_521_4];

/// How far the settlement of a dry column of Cam-Clay is off under its full load, and the steps it took. The load comes within a
/// time (s) that does not matter.
fn along_a_path(ramp: f64, step: &str) -> (f64, u64) {
    let clay = CamClay {
        lambda: 1e-3,
        kappa: 2e-4,
        poisson_ratio: 0.25,
        bulk_modulus: None,
        critical_slope: 1.0,
        preconsolidation: 0.0,
        overconsolidation: 1.0,
        attraction: SURCHARGE / (COMPRESSED[1] - 1.0),
    };
    let scene = dry(step).edited(|s| {
        s.cam_clay = Some(clay);
        s.surcharge = s.surcharge.map(|load| mpm_core::scene::Surcharge { ramp_time: ramp, ..load });
        let end = if ramp > 0.0 { ramp } else { 1.0 };
        s.observe_times = vec![end];
        s.stages[0].until = Until::Time(end);
    });
    let run = completed(&scene.expect("a sound scene"));
    let found = settlements(&run).last().copied().expect("a sample");
    (apart(found, 1e-2 * COMPRESSED[0]), run.steps)
}

#[test]
fn the_error_of_a_law_with_a_path_follows_the_tolerance() {
    for tolerance in [1e-2, 1e-3, 1e-4, 1e-5] {
        let of_ramps = [1.0, 1e-3, 1e6].map(|ramp| along_a_path(ramp, &format!("tolerance = {tolerance:e}")));
        let [(error, steps), ..] = of_ramps;
        // The estimate is of the stress that a step leaves to the next one; what remains is less.
        assert!(error <= 0.1 * tolerance, "{tolerance:e}: {error:.1e}");
        assert!(f64::from(steps as u32) < 1.0 / tolerance.sqrt() + 10.0, "{tolerance:e}: {steps} steps");
        assert!(of_ramps.iter().all(|of| of.1 == steps && apart(of.0, error) < 1e-6), "{of_ramps:?}");
    }
}

#[test]
fn a_sudden_load_follows_the_same_path() {
    let (error, steps) = along_a_path(0.0, "tolerance = 1e-4");
    assert!(error < 1e-5 && steps > 20, "{error:.1e} in {steps} steps");
}

#[test]
fn fixed_steps_along_a_path_are_of_second_order() {
    let [coarse, fine] = [0.02, 0.01].map(|step| along_a_path(1.0, &format!("tolerance -> step = {step}")).0);
    let order = (coarse / fine).log2();
    assert!((1.7..2.3).contains(&order) && coarse < 1e-5, "{coarse:.1e} {fine:.1e}: {order:.2}");
}

#[test]
fn a_load_that_no_stress_can_carry_ends_with_its_residuals() {
    // The strength in compression is 60 % of the load.
    let run = with_law(&dry("tolerance = 1e-4"), Curved { reference: -0.6 * SURCHARGE });
    let failure = run.failure.clone().expect("a failure");
    let text = failure.to_string();
    assert!(text.contains("Newton's iteration did not converge; residuals"), "{text}");
    assert!(text.contains("the load may exceed the bearing capacity of the soil"), "{text}");
    // Dry soil: to 1e-5 of the ramp, and short of it by what residuals may leave.
    assert!((0.599..0.6001).contains(&failure.time), "{text}");
    // What was reached before is kept: half the load, r/M ln(1 - q/r).
    let expected = 0.6 * SURCHARGE / MODULUS * -(1.0 - 0.5 / 0.6_f64).ln();
    let found = run.observed().nth(1).expect("a sample").state.settlement;
    assert!(apart(found, expected) < 1e-6, "{found:e} {expected:e}");
}

/// Beside an attraction of 5 kPa, strains of 4e-11 to 4e-15: what is asked of a step ends at the round-off of the stiffness.
#[test]
fn a_load_near_round_off_costs_no_more_steps() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../reference-data/scenes/soft-layer.toml");
    let scene = Scene::parse(&std::fs::read_to_string(path).expect("a scene"), path).expect("a sound scene");
    let under = |pressure: f64| {
        let load = scene.surcharge.map(|surcharge| mpm_core::scene::Surcharge { pressure, ..surcharge });
        let run = run(&scene.edited(|s| s.surcharge = load).expect("a sound scene"), &mut |_| {}).expect("a run");
        assert!(run.work.accepted + run.work.rejected < 200, "{pressure} Pa: {:?}", run.work);
        let settlement = settlements(&run).last().copied();
        run.failure.map_or_else(|| Ok(settlement.expect("an end") / pressure), |failure| Err(failure.what))
    };
    let of_more = under(1e-3).expect("a run to its end");
    for (pressure, allowed) in [(1e-5, 1e-5), (1e-7, 1e-3)] {
        let off = apart(under(pressure).expect("a run to its end"), of_more);
        println!("{pressure:e} Pa: {off:.1e}");
        assert!(off < allowed, "{pressure:e} Pa: {off:.1e}");
    }
    // Ten times round-off.
    assert!(under(1e-9).expect_err("a balance that does not close").contains("exceeds its bound"));
}

#[test]
fn a_step_that_cannot_be_reduced_further_says_so() {
    // Soil that is pulled beyond its strength of half the load: no step is short enough.
    let scene = dry("tolerance = 1e-4")
        .edited(|scene| {
            scene.surcharge =
                scene.surcharge.map(|s| mpm_core::scene::Surcharge { ramp_time: 0.0, pressure: -SURCHARGE, ..s })
        })
        .expect("a sound scene");
    let run = with_law(&scene, Curved { reference: 0.5 * SURCHARGE });
    let text = run.failure.clone().expect("a failure").to_string();
    assert!(text.contains("the step cannot be reduced further") && text.contains("residuals"), "{text}");
    assert_eq!(run.samples.len(), 1);
}

#[test]
fn a_step_that_was_given_is_not_reduced() {
    let run = with_law(&dry("tolerance -> step = 0.05"), Curved { reference: -0.6 * SURCHARGE });
    let text = run.failure.expect("a failure").to_string();
    assert!(text.contains("Newton's iteration did not converge") && text.contains("step 5.000e-2"), "{text}");
}

#[test]
fn a_closed_block_of_incompressible_water_is_singular() {
    // Equal order without the penalty has pressures that no displacement feels; in a closed block nothing else does.
    let scene = column(&[
        "dimension = \"plane-strain\"",
        "width = 1.0",
        "cell = 0.125",
        "start = \"unloaded\"",
        "bulk_modulus = inf",
        "drained = \"none\"",
        "until.time_factor -> until.time = 1.0",
        "time_factors -> times = [1.0]",
        "hydraulic_conductivity = 1e-30",
        "shape -> shape = \"bspline2\"\njump_penalty = 0.0",
        "on -> strip = { from = 0.0, to = 0.3, taper = 0.2 }",
    ]);
    for method in [TimeMethod::Krylov, TimeMethod::Sdirk] {
        let run = run(&scene.edited(|s| s.method = method).expect("a sound scene"), &mut |_| {}).expect("a start");
        let text = run.failure.expect("a singular system").to_string();
        assert!(text.contains("singular") && text.contains("no side is drained"), "{text}");
        assert_eq!(run.samples.len(), usize::from(method == TimeMethod::Sdirk));
    }
}

#[test]
fn the_same_scene_gives_the_same_bits() {
    let scene = column(&["strain = \"large\"", "tolerance = 1e-5"]);
    assert_eq!(completed(&scene).samples, completed(&scene).samples);
}

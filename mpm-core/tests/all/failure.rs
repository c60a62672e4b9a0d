//! Soil that water makes fail: pressures of soil that moves, the course of a failure, its safety, and what a run keeps.

use crate::common::edited;
use mpm_core::failure::{Bracket, Driver, End, Outcome, Phase, Row, Search};
use mpm_core::run::failing;
use mpm_core::scene::{Reduction, Scene, Strength};
use mpm_core::stability::choose_step;
use mpm_core::step::{Failing, Pace};
use mpm_core::water::Pressures;

/// Height of the box, m, and its cells.
const HEIGHT: f64 = 1.0;
const ROWS: usize = 8;
const CELL: f64 = HEIGHT / ROWS as f64;
/// E of the box with nu = 0.3, and its oedometer modulus, Pa.
const YOUNG: f64 = 4e6;
const MODULUS: f64 = YOUNG * 0.7 / (1.3 * 0.4);
const GAMMA: f64 = 9810.0;
/// Damping of the box, 1/s: waves are gone within half a second, and consolidation is slowed by some thousandths.
const DAMPING: f64 = 20.0;
/// (rho - rho_w) g of grains of 2700 kg/m3 and n = 0.3, N/m3.
const BUOYANT: f64 = (0.7 * 2700.0 + 0.3 * 1000.0 - 1000.0) * 9.81;

/// A box of elastic soil between rollers, full of water at rest, without any stress in the skeleton: gravity comes at once.
fn soil_box(integrator: &str, conductivity: f64, bulk_modulus: f64, above: usize) -> Scene {
    let text = format!(
        "name = \"box\"
dimension = \"plane-strain\"
start = \"unloaded\"
gravity = 9.81
[geometry.column]
height = {HEIGHT}
width = 0.25
[mesh]
cell = {CELL}
particles_per_cell = 4
empty_cells_above = {above}
[soil]
grain_density = 2700.0
porosity = 0.3
[soil.law.linear_elastic]
youngs_modulus = {YOUNG:e}
poisson_ratio = 0.3
[water]
hydraulic_conductivity = {conductivity:e}
bulk_modulus = {bulk_modulus:e}
unit_weight = {GAMMA:?}
[water.free_surface]
level = {HEIGHT}
[boundaries]
left = \"roller\"
right = \"roller\"
bottom = \"roller\"
top = \"free\"
[scheme]
shape = \"centre\"
flip = 0.99
[time]
integrator = \"{integrator}\"
safety = 0.5
[[stages]]
coupling = \"full\"
drained = \"none\"
until.time = 100.0
"
    );
    Scene::parse(&text, "box.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn started(scene: &Scene) -> Box<dyn Failing> {
    let mut model = failing(scene).unwrap();
    model.enter_stage(&scene.stages[0], &[]).unwrap();
    model
}

/// Excess pressures (Pa) of the rows from the bottom up, at times (s).
fn excess(scene: &Scene, pressures: Pressures, damping: f64, times: &[f64]) -> Vec<Vec<f64>> {
    let dt = choose_step(scene).unwrap();
    let mut model = started(scene);
    let (mut time, mut all) = (0.0, Vec::new());
    for until in times {
        let steps = ((until - time) / dt).ceil() as u64;
        let pace = Pace { dt: (until - time) / steps as f64, steps, damping, pressures };
        model.move_soil(&pace, &mut 0).unwrap();
        time = *until;
        let frame = model.frame(time, 0);
        let row = |row: usize| {
            let depth = HEIGHT - (row as f64 + 0.5) * CELL;
            let cells = &frame.cell[row * frame.cells[0]..][..frame.cells[0]];
            // Nothing differs across the box.
            let p = cells[0].pressure;
            assert!(cells.iter().all(|cell| (cell.pressure - p).abs() < 1e-6 * GAMMA), "{cells:?}");
            p - GAMMA * depth
        };
        all.push((0..ROWS).map(row).collect());
    }
    all
}

#[test]
fn undrained_soil_gives_its_weight_to_its_water() {
    // Closed all around and nearly incompressible: the pressure rises by the whole change of the total stress.
    let scene = soil_box("coupled", 1e-10, 2.2e9, 0);
    let found = excess(&scene, Pressures::Implicit, 0.0, &[0.5]);
    for (row, excess) in found[0].iter().enumerate() {
        let weight = BUOYANT * (HEIGHT - (row as f64 + 0.5) * CELL);
        println!("row {row}: {excess:.1} Pa, weight {weight:.1} Pa");
        // What evens out checkerboards takes the slope of the pressure for one in the last row before a tight wall.
        let share = if row == 0 || row + 1 == ROWS { 0.5 } else { 0.1 };
        assert!((excess - weight).abs() < share * BUOYANT * CELL, "row {row}: {excess} Pa, expected {weight}");
    }
}

/// Self-weight consolidation above a tight base: excess pressure at a depth (m) and a time factor, by Terzaghi's series for a first
/// excess pressure of `slope` (Pa/m) times the depth.
fn terzaghi(slope: f64, depth: f64, factor: f64) -> f64 {
    (0..200)
        .map(|m| {
            let root = (f64::from(m) + 0.5) * std::f64::consts::PI;
            let sign = if m % 2 == 0 { 1.0 } else { -1.0 };
            2.0 * slope * HEIGHT * sign / (root * root) * (root * depth / HEIGHT).sin() * (-root * root * factor).exp()
        })
        .sum()
}

const FACTORS: [f64; 4] = [0.05, 0.2, 0.5, 1.0];

#[test]
fn soil_consolidates_under_its_own_weight_as_terzaghi_says() {
    let k = 2e-4;
    for (driver, bulk_modulus, pressures) in [
        ("coupled", 2.2e9, Pressures::Implicit),
        ("coupled", 2e7, Pressures::Implicit),
        ("explicit", 2e7, Pressures::Explicit),
    ] {
        let scene = soil_box(driver, k, bulk_modulus, 1);
        // Water that compresses carries less, and delays.
        let shared = 1.0 / (1.0 + 0.3 * MODULUS / bulk_modulus);
        let consolidation = k * MODULUS / GAMMA * shared;
        let times = FACTORS.map(|factor| factor * HEIGHT * HEIGHT / consolidation);
        let found = excess(&scene, pressures, DAMPING, &times);
        let mut worst: f64 = 0.0;
        for (factor, rows) in FACTORS.iter().zip(&found) {
            for (row, excess) in rows.iter().enumerate() {
                let expected = terzaghi(BUOYANT * shared, HEIGHT - (row as f64 + 0.5) * CELL, *factor);
                worst = worst.max((excess - expected).abs() / (BUOYANT * HEIGHT));
            }
            println!("{driver}, K_w {bulk_modulus:e}, Tv {factor}: base {:.1} Pa, worst so far {worst:.4}", rows[0]);
        }
        assert!(worst < 0.02, "{driver}, K_w = {bulk_modulus:e} Pa: {worst}");
    }
}

#[test]
fn implicit_and_explicit_pressures_agree() {
    let times = [0.5, 1.0, 3.0];
    let [implicit, explicit] = [("coupled", Pressures::Implicit), ("explicit", Pressures::Explicit)]
        .map(|(driver, pressures)| excess(&soil_box(driver, 5e-4, 2e7, 1), pressures, DAMPING, &times));
    for ((a, b), time) in implicit.iter().zip(&explicit).zip(times) {
        for (row, (a, b)) in a.iter().zip(b).enumerate() {
            println!("{time} s, row {row}: {a:.1} {b:.1} Pa");
            assert!((a - b).abs() < 0.01 * BUOYANT * HEIGHT, "{time} s, row {row}: {a} {b} Pa");
        }
    }
}

fn levee_text() -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../reference-data/scenes/levee.toml");
    std::fs::read_to_string(path).unwrap()
}

/// The levee with 4 cells over its height, and water 20 times as fast.
fn coarse(edits: &[(&str, &str)]) -> Scene {
    let text = edited(
        &levee_text(),
        &[
            ("cell = 0.2 #", "cell = 0.75 #"),
            ("empty_cells_beside = 28", "empty_cells_beside = 8"),
            ("hydraulic_conductivity = 4.5e-5", "hydraulic_conductivity = 9.0e-4"),
            ("until.time = 64800.0", "until.time = 6480.0"),
        ],
    );
    let text = edited(&text, edits);
    Scene::parse(&text, "coarse.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

const STRONG: (&str, &str) = ("cohesion = 500.0", "cohesion = 5000.0");

/// Runs to the end.
fn finish(driver: &mut Driver) {
    while driver.end.is_none() {
        driver.advance(f64::INFINITY).unwrap();
    }
}

fn closes(row: &Row) {
    assert_eq!(row.solid_residual_kg, 0.0, "{row:?}");
    let water = row.water_m3.max(row.water_in_m3);
    assert!(row.water_residual_m3.abs() < 1e-12 * water, "{row:?}");
    assert!(row.yield_residual < 1e-9, "{row:?}");
}

#[test]
fn a_levee_ravels_fails_and_collapses_in_this_order() {
    // Fed up to its crest: on so coarse a mesh it stands otherwise, after it has failed and come to rest.
    let scene = coarse(&[
        ("feed.left = { head = 2.3 }", "feed.left = { head = 3.0 }"),
        ("empty_cells_beside = 8", "empty_cells_beside = 16"),
    ]);
    let mut driver = Driver::new(&scene).unwrap();
    finish(&mut driver);
    let events = driver.events;
    println!("{events:?}\n{:?} {:?} {:?}", driver.end, driver.steps, driver.rows.last());
    assert_eq!(driver.end, Some(End::Collapsed));
    let [raveling, failure, collapse] =
        [events.raveling_h, events.failure_h, events.collapse_h].map(|event| event.expect("an event"));
    assert!(raveling <= failure && failure <= collapse && collapse <= driver.hours(), "{events:?}");
    // Water is at the toe and leaves before anything has moved.
    let toe = events.front_at_toe_h.expect("water at the toe");
    assert!(events.first_outflow_h.expect("outflow") < failure && toe < failure, "{events:?}");
    assert!(events.displacement_before_toe_m < 0.01, "{events:?}");
    assert!(driver.rows.windows(2).all(|pair| pair[0].time_h <= pair[1].time_h));
    driver.rows.iter().for_each(closes);
    let worst = driver.rows.iter().map(|row| row.energy_error).fold(0.0, f64::max);
    println!("energy error {worst}");
    let last = driver.rows.last().unwrap();
    assert!(last.energy_error < 0.02, "{last:?}");
    assert_eq!(last.phase, Phase::Ended);
    assert!(last.toe_x_m > 9.5 && last.crest_settlement_m > 0.05, "{last:?}");
    assert!(worst < 0.02, "{worst}");
    // All observed places have a stress at every look.
    assert_eq!(driver.paths.len(), driver.rows.len() * 7);
}

#[test]
fn a_levee_continues_after_its_collapse_where_asked() {
    let scene = coarse(&[
        ("feed.left = { head = 2.3 }", "feed.left = { head = 3.0 }"),
        ("empty_cells_beside = 8", "empty_cells_beside = 16"),
        ("until.time = 6480.0", "until.time = 900.0"),
        ("starts_at = 21600.0 # 6 h", "starts_at = 21600.0\ncontinue_after_collapse = true"),
    ]);
    let mut driver = Driver::new(&scene).unwrap();
    finish(&mut driver);
    println!("{:?} {:?}", driver.events, driver.steps);
    assert_eq!(driver.end, Some(End::TimeOver));
    let collapse = driver.events.collapse_h.expect("a collapse");
    assert!(collapse < driver.hours());
    // Water seeps on through soil that has come to rest again.
    assert!(driver.rows.iter().any(|row| row.time_h > collapse && row.phase == Phase::Seepage));
    driver.rows.iter().for_each(closes);
}

#[test]
fn a_strong_levee_stands() {
    let scene = coarse(&[STRONG]);
    let mut driver = Driver::new(&scene).unwrap();
    finish(&mut driver);
    let last = driver.rows.last().unwrap();
    println!("{:?}\n{:?} {last:?}", driver.events, driver.steps);
    assert_eq!(driver.end, Some(End::TimeOver));
    assert!((driver.time - driver.ends_at()).abs() < 1e-9);
    assert_eq!((driver.events.raveling_h, driver.events.failure_h, driver.events.collapse_h), (None, None, None));
    assert!(driver.events.front_at_toe_h.is_some() && last.water_out_m3 > 0.1, "{:?}", driver.events);
    assert!(last.max_displacement_m < 1e-3, "{last:?}");
    driver.rows.iter().for_each(closes);
    // It is over: nothing happens any more.
    let before = driver.checkpoint();
    driver.advance(f64::INFINITY).unwrap();
    assert_eq!(driver.checkpoint(), before);
}

#[test]
fn a_levee_that_does_not_stand_says_so() {
    let scene = coarse(&[("peak_angle = 30.0", "peak_angle = 8.6")]);
    let mut driver = Driver::new(&scene).unwrap();
    let message = driver.advance(1.0).unwrap_err().to_string();
    assert!(message.contains("is not stable"), "{message}");
    assert_eq!(driver.time, 0.0);
}

/// The state of a run after so many looks.
fn after(driver: &mut Driver, looks: usize) -> Vec<u8> {
    for _ in 0..looks {
        driver.advance(f64::INFINITY).unwrap();
    }
    driver.checkpoint()
}

#[test]
fn a_run_that_is_resumed_goes_on_to_the_same_bits() {
    let scene = coarse(&[]);
    // At the start, while water seeps, as soon as soil moves, and while it slides.
    let mut whole = Driver::new(&scene).unwrap();
    let mut states = vec![(Phase::Gravity, whole.checkpoint())];
    after(&mut whole, 3);
    states.push((whole.phase, whole.checkpoint()));
    while whole.phase != Phase::Failing {
        whole.advance(f64::INFINITY).unwrap();
    }
    states.push((whole.phase, whole.checkpoint()));
    states.push((whole.phase, after(&mut whole, 5)));
    let end = after(&mut whole, 5);
    let looks = whole.rows.len();
    let phases: Vec<Phase> = states.iter().map(|state| state.0).collect();
    assert_eq!(phases, [Phase::Gravity, Phase::Seepage, Phase::Failing, Phase::Failing]);
    for (phase, state) in states {
        let mut other = Driver::new(&scene).unwrap();
        other.restore(&state).unwrap();
        assert!(other.checkpoint() == state, "{phase:?}: what was restored is what was saved");
        while other.rows.len() < looks {
            other.advance(f64::INFINITY).unwrap();
        }
        assert!(other.checkpoint() == end, "{phase:?}: {:?} {:?}", other.rows.last(), whole.rows.last());
    }
    // Determinism: the run once more, from its start and without any stop.
    let mut again = Driver::new(&scene).unwrap();
    while again.rows.len() < looks {
        again.advance(f64::INFINITY).unwrap();
    }
    assert!(again.checkpoint() == end);
}

#[test]
fn soil_and_water_together_are_resumed_to_the_same_bits() {
    for driver in ["coupled", "explicit"] {
        let word = format!("integrator = \"{driver}\"");
        let scene =
            coarse(&[("integrator = \"staggered\"", word.as_str()), ("bulk_modulus = 2.2e9", "bulk_modulus = 2.2e7")]);
        let mut whole = Driver::new(&scene).unwrap();
        let state = after(&mut whole, 4);
        assert_eq!(whole.phase, Phase::Together);
        let end = after(&mut whole, 4);
        let mut other = Driver::new(&scene).unwrap();
        other.restore(&state).unwrap();
        assert!(after(&mut other, 4) == end, "{driver}");
        let row = whole.rows.last().unwrap();
        closes(row);
        assert!(row.max_displacement_m < 1e-3, "{driver}: {row:?}");
    }
}

#[test]
fn a_run_goes_on_with_the_driver_it_was_saved_with() {
    let scene = coarse(&[]);
    let mut driver = Driver::new(&scene).unwrap();
    after(&mut driver, 3);
    driver.drive_by(mpm_core::scene::Integrator::Coupled, driver.dt);
    let state = after(&mut driver, 2);
    let end = after(&mut driver, 2);
    let mut other = Driver::new(&scene).unwrap();
    other.restore(&state).unwrap();
    assert!(after(&mut other, 2) == end);
}

#[test]
fn bytes_that_do_not_fit_are_refused_and_change_nothing() {
    let scene = coarse(&[]);
    let mut driver = Driver::new(&scene).unwrap();
    let state = after(&mut driver, 2);
    let mut other = Driver::new(&scene).unwrap();
    let first = other.checkpoint();
    for cut in (0..state.len()).step_by(997).chain(state.len() - 40..state.len()) {
        assert!(other.restore(&state[..cut]).is_err(), "{cut} bytes");
    }
    for at in (0..state.len()).step_by(1499) {
        let mut bytes = state.clone();
        bytes[at] ^= 0x40;
        assert!(other.restore(&bytes).is_err(), "byte {at}");
    }
    let mut longer = state.clone();
    longer.push(0);
    assert!(other.restore(&longer).is_err());
    // Of another mesh, another soil, another feed.
    for edit in [
        ("cell = 0.75 #", "cell = 0.6 #"),
        ("empty_cells_beside = 8", "empty_cells_beside = 9"),
        STRONG,
        ("feed.left = { head = 2.3 }", "feed.left = { head = 2.2 }"),
    ] {
        let scene = coarse(&[edit]);
        let mut other = Driver::new(&scene).unwrap();
        let first = other.checkpoint();
        assert!(other.restore(&state).is_err(), "{edit:?}");
        assert!(other.checkpoint() == first, "{edit:?}");
    }
    assert!(other.checkpoint() == first, "what was refused changed nothing");
    // The end and the driver may be others.
    let longer = coarse(&[("until.time = 6480.0", "until.time = 9000.0"), ("\"staggered\"", "\"coupled\"")]);
    let mut other = Driver::new(&longer).unwrap();
    other.restore(&state).unwrap();
    assert_eq!((other.phase, other.time), (driver.phase, driver.time));
}

fn search(within: f64) -> Search {
    Search { within, ..Search::default() }
}

/// The factor of safety of the coarse levee without water, with this strength; the run must be left as it was.
fn safety(cohesion: f64, tangent: f64) -> Bracket {
    let angle = tangent.atan().to_degrees();
    let (cohesion, friction) = (format!("cohesion = {cohesion:?}"), format!("friction_angle = {angle:?}"));
    let base = format!("friction_angle = {angle:?}");
    let scene = coarse(&[
        ("wet = [[0.0, 0.0], [8.35, 0.0], [0.0, 2.3]]\nfeed.left = { head = 2.3 } #", "#"),
        ("cohesion = 500.0", &cohesion),
        ("friction_angle = 30.0", &friction),
        ("peak_angle = 30.0\nresidual_angle = 8.5\nslip_distance = 0.02", &base),
    ]);
    let mut driver = Driver::new(&scene).unwrap();
    driver.load().unwrap();
    assert_eq!(driver.phase, Phase::Seepage);
    let before = driver.checkpoint();
    let mut looks = 0;
    let found = driver.safety(&search(0.04), &mut |_, _| looks += 1).unwrap().bracket;
    assert!(driver.checkpoint() == before, "the run was not left as it was");
    println!("c {cohesion}, phi {angle:.1}: {found:?}");
    assert!(looks == found.trials && found.high - found.low <= 0.04 * 1.0001, "{found:?}");
    // The strength is back too: soil that was at rest stays there.
    driver.advance(f64::INFINITY).unwrap();
    assert!(driver.rows.last().unwrap().max_displacement_m < 1e-4);
    found
}

#[test]
fn twice_the_strength_is_twice_as_safe() {
    let tangent = 30_f64.to_radians().tan();
    let once = safety(500.0, tangent);
    let twice = safety(1000.0, 2.0 * tangent);
    assert!(once.low > 1.0, "{once:?}");
    // The brackets of both, on one scale, meet.
    assert!(twice.low <= 2.0 * once.high + 0.04 && 2.0 * once.low <= twice.high + 0.04, "{once:?} {twice:?}");
}

#[test]
fn a_slope_that_stands_with_any_strength_has_no_upper_bound() {
    let scene =
        coarse(&[("cohesion = 500.0", "cohesion = 500000.0"), ("residual_angle = 8.5", "residual_angle = 30.0")]);
    let mut driver = Driver::new(&scene).unwrap();
    driver.load().unwrap();
    let found = driver.safety(&search(0.04), &mut |_, _| ()).unwrap().bracket;
    // 10 is the last factor that is looked at; that it slides there nobody has seen.
    assert_eq!((found.low, found.high), (10.0, f64::INFINITY));
}

/// Example 1 of Griffiths & Lane 1999 (doi:10.1680/geot.1999.49.3.387): a slope 2:1 on a rigid base, phi = 20 degrees,
/// c/(gamma H) = 0.05, published factor 1.4. Of a height (m) and stiffness (Pa), on a mesh of so many rows, as drawn or mirrored.
fn griffiths(height: f64, youngs_modulus: f64, rows: u32, mirrored: bool) -> Scene {
    let (gravity, density) = (9.81, 2000.0);
    let corners = [[0.0, 0.0], [3.2, 0.0], [1.2, 1.0], [0.0, 1.0]];
    // Whatever side the toe is on, there is room in front of it.
    let place = |[x, y]: [f64; 2]| [height * if mirrored { 4.2 - x } else { x }, height * y];
    let [left, right] = if mirrored { ["free", "roller"] } else { ["roller", "free"] };
    let (points, cohesion) = (corners.map(place), 0.05 * density * gravity * height);
    let text = format!(
        "name = \"griffiths\"
dimension = \"plane-strain\"
start = \"geostatic\"
gravity = {gravity}
[geometry.outline]
points = {points:?}
[mesh]
cell = {:?}
particles_per_cell = 4
empty_cells_above = 1
empty_cells_beside = {}
[soil]
grain_density = {:?}
porosity = 0.3
[soil.law.mohr_coulomb]
youngs_modulus = {youngs_modulus:?}
poisson_ratio = 0.3
cohesion = {cohesion:?}
friction_angle = 20.0
dilation_angle = 0.0
[water]
hydraulic_conductivity = 1e-5
bulk_modulus = 2.2e9
unit_weight = 9810.0
[water.free_surface]
saturation = 0.0
[boundaries]
left = \"{left}\"
right = \"{right}\"
bottom = \"fixed\"
top = \"free\"
[scheme]
shape = \"centroid\"
flip = 0.99
[time]
integrator = \"staggered\"
safety = 0.5
[[stages]]
coupling = \"full\"
drained = \"none\"
until.time = 3600.0
",
        height / f64::from(rows),
        if mirrored { 0 } else { rows },
        density / 0.7,
    );
    Scene::parse(&text, "griffiths.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn factor(scene: &Scene, within: f64) -> Bracket {
    let mut driver = Driver::new(scene).unwrap();
    assert_eq!(driver.load().unwrap().outcome, Outcome::Stands);
    let found = driver.safety(&search(within), &mut |_, _| ()).unwrap().bracket;
    println!("E {:e} Pa, H {} m: {found:?}", scene.elastic.youngs_modulus, scene.height);
    found
}

#[test]
fn the_factor_of_a_slope_does_not_depend_on_its_size_or_stiffness() {
    let usual = factor(&griffiths(10.0, 1e8, 5, false), 0.02);
    // The published factor, on a mesh of five rows.
    assert!(usual.low > 1.3 && usual.high < 1.5 && usual.high - usual.low < 0.021, "{usual:?}");
    for (height, youngs_modulus) in [(10.0, 1e6), (10.0, 1e9), (0.1, 1e8), (100.0, 1e8), (100.0, 1e6)] {
        let found = factor(&griffiths(height, youngs_modulus, 5, false), 0.02);
        let same = (found.low - usual.low).abs().max((found.high - usual.high).abs()) < 1e-6;
        assert!(same, "E {youngs_modulus:e} Pa, H {height} m: {found:?} {usual:?}");
    }
}

#[test]
fn a_slope_in_a_mirror_is_as_safe() {
    let [usual, mirrored] = [false, true].map(|mirrored| factor(&griffiths(10.0, 1e8, 5, mirrored), 0.02));
    assert_eq!((usual.low, usual.high), (mirrored.low, mirrored.high));
}

/// The sums that the balance of the water compares round once per cell: what that comes to must not stop a fine mesh, whose soil
/// moves under its own weight before any water has flowed.
#[test]
fn water_on_fine_meshes_is_booked() {
    for (cell, count) in [(0.1, 4), (0.1, 9), (0.05, 4)] {
        let scene = Scene::parse(&levee_text(), "levee.toml").unwrap();
        let changes = [("mesh.cell", cell.into()), ("mesh.particles_per_cell", count.into())];
        let scene = scene.patched(&changes).unwrap();
        let pace = Pace { dt: choose_step(&scene).unwrap(), steps: 1, damping: 0.0, pressures: Pressures::Held };
        started(&scene).move_soil(&pace, &mut 0).unwrap();
    }
}

#[test]
fn slip_does_not_weaken_the_base_during_trials() {
    let factor = |residual: &str| {
        let scene = coarse(&[("residual_angle = 8.5", residual)]);
        let mut driver = Driver::new(&scene).unwrap();
        driver.load_for_safety().unwrap();
        driver.safety(&search(0.02), &mut |_, _| ()).unwrap().bracket
    };
    let (weakens, stays) = (factor("residual_angle = 8.5"), factor("residual_angle = 30.0"));
    assert_eq!((weakens.low, weakens.high), (stays.low, stays.high));
}

#[test]
fn the_strength_of_davis_is_that_of_simple_shear() {
    let strength = |dilation_angle: f64| Strength {
        cohesion: 3e3,
        friction_angle: 30.0,
        dilation_angle,
        tension_cutoff: None,
        dilation_fades_over: None,
    };
    for factor in [0.8, 1.0, 1.7] {
        // c and tan(phi) keep their ratio.
        let reduced = strength(0.0).reduced(factor, Reduction::Davis);
        let tangent = reduced.friction_angle.to_radians().tan();
        assert!((reduced.cohesion / tangent / strength(0.0).apex() - 1.0).abs() < 1e-12);
        assert!((reduced.dilation_angle - reduced.friction_angle).abs() < 1e-12);
        // Without dilation tan(phi*) is the sine of the reduced angle (Davis 1968).
        let sine = (30_f64.to_radians().tan() / factor).atan().sin();
        assert!((tangent / sine - 1.0).abs() < 1e-12, "{tangent} {sine}");
        // With all of it nothing is lost.
        let [whole, associated] =
            [Reduction::Davis, Reduction::Associated].map(|by| strength(30.0).reduced(factor, by));
        assert!((whole.cohesion / associated.cohesion - 1.0).abs() < 1e-12);
        assert!((whole.friction_angle / associated.friction_angle - 1.0).abs() < 1e-12);
    }
}

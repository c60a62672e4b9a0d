//! The undrained wave of `reference-data/scenes/undrained-wave.toml` against the d'Alembert table, at mid height.

use mpm_core::run::run;

use super::oracle::Table;

/// Largest |p - p_exact|/p_0 at mid height over the times of the scene that stand in the table, and their number.
fn worst(stiffer: f64) -> (f64, usize) {
    let scene = crate::scenes::built_in("undrained-wave").expect("a scene that holds").edited(|scene| {
        if let Some(water) = &mut scene.water {
            water.bulk_modulus *= stiffer;
        }
    });
    let scene = scene.expect("a sound scene");
    let table = Table::read("04_dynamic_undrained_mid_rhog.csv").rows(["t_s", "ramp_p_Pa"]);
    let run = run(&scene, &mut |_| {}).expect("a run");
    let (mut worst, mut count) = (0.0_f64, 0);
    for sample in run.observed() {
        let Some(row) = table.iter().find(|row| (row[0] / sample.stage_time - 1.0).abs() < 1e-9) else { continue };
        // An even number of rows: mid height lies between the two in the middle.
        let profile = &sample.state.profile;
        let middle = 0.5 * (profile[profile.len() / 2 - 1].pressure_pa + profile[profile.len() / 2].pressure_pa);
        worst = worst.max((middle - row[1]).abs() / scene.undrained_pressure());
        count += 1;
    }
    (worst, count)
}

#[test]
fn the_wave_runs_at_its_speed() {
    let (error, count) = worst(1.0);
    assert!(count >= 10 && error < 0.015, "{error} at {count} times");
}

#[test]
fn the_wave_check_can_fail() {
    assert!(worst(1.1).0 > 0.015, "{}", worst(1.1).0);
}

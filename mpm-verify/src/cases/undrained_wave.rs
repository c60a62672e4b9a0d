//! The undrained wave in a column: when it arrives at mid height, and how large it is, against d'Alembert's solution.

use mpm_core::drive::{Run, Sample};
use mpm_core::scene::{Scene, Until};

use super::{Mutant, Outcome, Rung, finished, integrator, scheme, sound, with_rows};
use crate::exact::undrained_wave::UndrainedWave;

/// Pressures over five passages.
pub const AMPLITUDE: Rung = Rung {
    name: "undrained-wave",
    about: "the undrained wave at mid height over five passages: RMS of the pressure",
    climb: || climb(amplitude, 3e-3, Some([0.9, 1.2]), sound),
    mutant: Some(Mutant { what: STIFFER, climb: || climb(amplitude, 3e-3, Some([0.9, 1.2]), stiffer) }),
};

/// When the pressure there has half of its undrained value for the first time.
pub const ARRIVAL: Rung = Rung {
    name: "undrained-arrival",
    about: "the same: when half of the undrained pressure is reached first, of H/c_u",
    climb: || climb(arrival, 1e-4, None, sound),
    mutant: Some(Mutant { what: STIFFER, climb: || climb(arrival, 1e-4, None, stiffer) }),
};

const STIFFER: &str = "water 5 % too stiff";
/// Times looked at.
const LOOKS: u32 = 500;

fn stiffer(scene: &mut Scene) {
    if let Some(water) = &mut scene.water {
        water.bulk_modulus *= 1.05;
    }
}

fn climb(
    error: fn(&Run, &UndrainedWave, f64) -> Option<f64>,
    required_error: f64,
    required_order: Option<[f64; 2]>,
    fault: fn(&mut Scene),
) -> Result<Outcome, String> {
    let mut base = crate::scenes::built_in("undrained-wave").ok_or("no such scene")?.map_err(|e| e.to_string())?;
    let exact = UndrainedWave::new(&base).ok_or("not a saturated column under a load")?;
    let end = 5.0 * exact.height / exact.speed;
    base.stages[0].until = Until::Time(end);
    base.observe_times = (1..=LOOKS).map(|i| end * f64::from(i) / f64::from(LOOKS)).collect();
    base.history = 0;
    let undrained = base.undrained_pressure();
    fault(&mut base);
    let on = |rows: &usize| {
        let scene = with_rows(base.clone(), *rows);
        let run = finished(&scene)?;
        Ok((scene.cell, error(&run, &exact, undrained).ok_or("the wave has not arrived")?))
    };
    let errors = [50, 100, 200].iter().map(on).collect::<Result<_, String>>()?;
    let (integrator, scheme) = (integrator(&base), scheme(&base));
    // A front that the mesh rounds off converges at first order in this norm.
    Ok(Outcome { integrator, scheme, errors, required_error, required_order, ..Outcome::default() })
}

/// Pressure at mid height, between the two rows of cells in the middle, Pa.
fn middle(sample: &Sample) -> f64 {
    let profile = &sample.state.profile;
    0.5 * (profile[profile.len() / 2 - 1].pressure_pa + profile[profile.len() / 2].pressure_pa)
}

fn amplitude(run: &Run, exact: &UndrainedWave, undrained: f64) -> Option<f64> {
    let off = |s: &Sample| (middle(s) - exact.pressure(0.5 * exact.height, s.stage_time)) / undrained;
    let squares: Vec<f64> = run.observed().map(|s| off(s).powi(2)).collect();
    Some((squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
}

fn arrival(run: &Run, exact: &UndrainedWave, undrained: f64) -> Option<f64> {
    // The first wave grows with the load: half of it passes mid height H/(2 c_u) after half of the ramp.
    let expected = 0.5 * exact.height / exact.speed + 0.5 * exact.ramp;
    let samples: Vec<&Sample> = run.observed().collect();
    let pair = samples.windows(2).find(|pair| middle(pair[1]) >= 0.5 * undrained)?;
    let [low, high] = [pair[0], pair[1]].map(|s| (s.stage_time, middle(s)));
    let reached = low.0 + (0.5 * undrained - low.1) / (high.1 - low.1) * (high.0 - low.0);
    Some((reached - expected) * exact.speed / exact.height)
}

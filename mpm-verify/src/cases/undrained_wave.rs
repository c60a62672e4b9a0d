//! The undrained wave in a column: when it arrives at mid height, and how large it is, against d'Alembert's solution.

use mpm_core::drive::{Run, Sample};
use mpm_core::scene::{Fields, Scene, StepChoice, Until};
use mpm_core::stability::stable_limit;

use super::{Error, Mutant, Outcome, Program, Unfit, finished, integrator, scheme, sound};
use super::{HALVINGS, PARTICLE_COUNTS};
use crate::exact::undrained_wave::UndrainedWave;
use crate::experiment::comparison::{Compared, Comparison, Norm, in_particles, in_time};
use crate::experiment::refinement::Refinement;

/// Pressures over five passages.
pub const AMPLITUDE: Program = Program {
    name: "undrained-wave",
    about: "the undrained wave at mid height over five passages: RMS of the pressure",
    run: || outcome(&IN_SIZE, sound),
    mutant: Some(Mutant { what: STIFFER, run: || outcome(&IN_SIZE, stiffer) }),
};

/// When the pressure there has half of its undrained value for the first time.
pub const ARRIVAL: Program = Program {
    name: "undrained-arrival",
    about: "the same: when half of the undrained pressure is reached first, of H/c_u",
    run: || outcome(&IN_TIME, sound),
    mutant: Some(Mutant { what: STIFFER, run: || outcome(&IN_TIME, stiffer) }),
};

/// A front that the mesh rounds off converges at first order in this norm.
const IN_SIZE: Asked =
    Asked { looks: amplitude, required_error: 3e-3, required_order: Some([0.9, 1.2]), on_coarse: 1e-2 };
/// The middle of the front is where it should be on every mesh: there is no order left to see.
const IN_TIME: Asked = Asked { looks: arrival, required_error: 1e-4, required_order: None, on_coarse: 1e-4 };

const STIFFER: &str = "water 5 % too stiff";
/// Times looked at.
const LOOKS: u32 = 500;

fn stiffer(scene: &mut Fields) {
    if let Some(water) = &mut scene.water {
        water.bulk_modulus *= 1.05;
    }
}

/// Rows of the mesh on which steps and particles are refined.
const COARSE: usize = 50;

/// What a case looks at, and what it must show.
struct Asked {
    looks: fn(&Run, &UndrainedWave, f64) -> Option<Comparison>,
    required_error: f64,
    required_order: Option<[f64; 2]>,
    /// Largest error on the coarse mesh with any number of particles, and largest change by halving a step.
    on_coarse: f64,
}

fn outcome(asked: &Asked, fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let mut base = crate::scenes::built_in("undrained-wave")?;
    let exact = UndrainedWave::new(&base).ok_or(Unfit("not a saturated column under a load"))?;
    let end = 5.0 * exact.height / exact.speed;
    base = base.edited(|base| {
        base.stages[0].until = Until::Time(end);
        base.observe_times = (1..=LOOKS).map(|i| end * f64::from(i) / f64::from(LOOKS)).collect();
        base.history = 0;
    })?;
    let undrained = base.undrained_pressure();
    base = base.edited(fault)?;
    let looks = |scene: &Scene| {
        let run = finished(scene)?;
        (asked.looks)(&run, &exact, undrained).ok_or(Unfit("the wave has not arrived"))
    };
    let (mut errors, mut samples) = (Vec::new(), Vec::new());
    for rows in [70, 100, 140, 200] {
        let scene = base.with_rows(rows)?;
        let found = looks(&scene)?;
        errors.push((scene.cell, found.error()));
        samples = found.samples();
    }
    let coarse = base.with_rows(COARSE)?;
    let step = |dt| looks(&coarse.edited(|s| s.step = StepChoice::Fixed(dt))?);
    let with = |count| looks(&coarse.edited(|s| s.particles_per_cell = count)?);
    Ok(Outcome {
        integrator: integrator(&base),
        scheme: scheme(&base),
        errors,
        required_error: asked.required_error,
        required_order: asked.required_order,
        samples,
        refinements: vec![
            // What FLIP takes from waves as short as the cells, (1 - S) w^2 dt, is not small in steps near the limit:
            // the front has no order in them. A step must change no more than the mesh leaves.
            Refinement {
                required_error: Some(asked.on_coarse),
                ..in_time(step, coarse.cell, 0.9 * stable_limit(&coarse), HALVINGS, None)?
            },
            in_particles(with, coarse.cell, &PARTICLE_COUNTS, asked.on_coarse)?,
        ],
        ..Outcome::default()
    })
}

/// Pressure at mid height, between the two rows of cells in the middle, Pa.
fn middle(sample: &Sample) -> f64 {
    let profile = &sample.state.profile;
    0.5 * (profile[profile.len() / 2 - 1].pressure_pa + profile[profile.len() / 2].pressure_pa)
}

fn amplitude(run: &Run, exact: &UndrainedWave, undrained: f64) -> Option<Comparison> {
    let look = |s: &Sample| {
        Compared::one(s.stage_time, middle(s) / undrained, exact.pressure(0.5 * exact.height, s.stage_time) / undrained)
    };
    let looks = Comparison::worst("p/p_0 at mid height", run.observed().map(look).collect());
    Some(Comparison { over_times: Norm::Rms, ..looks })
}

fn arrival(run: &Run, exact: &UndrainedWave, undrained: f64) -> Option<Comparison> {
    // The first wave grows with the load: half of it passes mid height H/(2 c_u) after half of the ramp.
    let expected = 0.5 * exact.height / exact.speed + 0.5 * exact.ramp;
    let samples: Vec<&Sample> = run.observed().collect();
    let pair = samples.windows(2).find(|pair| middle(pair[1]) >= 0.5 * undrained)?;
    let [low, high] = [pair[0], pair[1]].map(|s| (s.stage_time, middle(s)));
    let reached = low.0 + (0.5 * undrained - low.1) / (high.1 - low.1) * (high.0 - low.0);
    let passages = exact.speed / exact.height;
    let look = Compared::one(expected, reached * passages, expected * passages);
    Some(Comparison::worst("arrival, H/c_u", vec![look]))
}

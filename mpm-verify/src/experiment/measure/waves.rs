//! Waves of the column, the step that they limit, and the pressure that is left of them.

use mpm_core::drive::Sample;
use mpm_core::scene::Scene;

use super::Compare;
use crate::error::Error::{self, Unfit};
use crate::exact::dynamic::DynamicColumn;
use crate::exact::undrained_wave::UndrainedWave;
use crate::experiment::comparison::{Compared, Comparison, Norm};
use crate::experiment::spec::Measure;

/// Pressures of all cells of a closed column at the end, over the undrained one `q Q/(M + Q)`.
pub fn undrained(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let expected = scene.undrained_pressure();
    Ok(Box::new(move |run| {
        Ok(Comparison::profile("p over the undrained pressure", run.observed().last(), |_, row, _| {
            [row.pressure_pa / expected, 1.0]
        }))
    }))
}

/// Pressure at mid height, between the two rows of cells in the middle, Pa.
fn middle(sample: &Sample) -> f64 {
    let profile = &sample.state.profile;
    let half = 0.5 * (profile[0].material_height_m + profile[profile.len() - 1].material_height_m);
    let above = profile.iter().position(|row| row.material_height_m > half).unwrap_or(profile.len() - 1).max(1);
    let [low, high] = [above - 1, above].map(|i| (profile[i].material_height_m, profile[i].pressure_pa));
    let share = (half - low.0) / (high.0 - low.0);
    if (share - 0.5).abs() < 1e-9 { 0.5 * (low.1 + high.1) } else { low.1 + share * (high.1 - low.1) }
}

/// The undrained wave at mid height over the undrained pressure, beside d'Alembert's: root mean square over the times.
pub fn at_mid_height(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let (exact, undrained) = (wave(scene)?, scene.undrained_pressure());
    Ok(Box::new(move |run| {
        let look = |s: &Sample| {
            let pressure = exact.pressure(0.5 * exact.height, s.stage_time);
            Compared::one(s.stage_time, middle(s) / undrained, pressure / undrained)
        };
        let looks = Comparison::worst("p/p_0 at mid height", run.observed().map(look).collect());
        Ok(Comparison { over_times: Norm::Rms, ..looks })
    }))
}

/// Pressure at the base of a column with inertia over its load; that in the middle of the lowest row, where cells have one pressure.
pub fn at_base(scene: &Scene, measure: &Measure) -> Result<Compare, Error> {
    let exact = DynamicColumn::new(scene).ok_or(Unfit("not a saturated column drained at its top"))?;
    let load = scene.largest_load();
    let over_times = match measure.reference.as_str() {
        "" => Norm::Largest,
        "rms" => Norm::Rms,
        other => return Err(Error::refused("measure.reference", "rms, or none for the largest", other)),
    };
    let smooth = scene.integrator.solves_displacements() && scene.shape.spline_degree().is_some();
    Ok(Box::new(move |run| {
        let look = |s: &Sample| {
            let row = s.state.profile.first().map_or(0.0, |row| row.material_height_m);
            let pressure = exact.pressure(if smooth { 0.0 } else { row }, s.stage_time);
            Compared::one(s.stage_time, s.state.base_pressure / load, pressure / load)
        };
        let looks = Comparison::worst("p/q at the base", run.observed().map(look).collect());
        Ok(Comparison { over_times, ..looks })
    }))
}

/// When the same has half of its undrained value for the first time, of H/c_u.
pub fn arrival(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let (exact, undrained) = (wave(scene)?, scene.undrained_pressure());
    // The first wave grows with the load: half of it passes mid height H/(2 c_u) after half of the ramp.
    let expected = 0.5 * exact.height / exact.speed + 0.5 * exact.ramp;
    Ok(Box::new(move |run| {
        let samples: Vec<&Sample> = run.observed().collect();
        let pair = samples.windows(2).find(|pair| middle(pair[1]) >= 0.5 * undrained);
        let pair = pair.ok_or(Unfit("the wave has not arrived"))?;
        let [low, high] = [pair[0], pair[1]].map(|s| (s.stage_time, middle(s)));
        let reached = low.0 + (0.5 * undrained - low.1) / (high.1 - low.1) * (high.0 - low.0);
        let passages = exact.speed / exact.height;
        let look = Compared::one(expected, reached * passages, expected * passages);
        Ok(Comparison::worst("arrival, H/c_u", vec![look]))
    }))
}

fn wave(scene: &Scene) -> Result<UndrainedWave, Error> {
    UndrainedWave::new(scene).ok_or(Unfit("not a saturated column under a load"))
}

/// The step that a scene takes, over its safety times the limit of the shortest wave where nothing flows,
/// `dt = L sqrt(rho/((2 - S) K))` with K = M in dry soil and M + K_w/n in closed soil: FLIP gives that wave back by the share S of its
/// accelerations, the mean of (1 - 2 xi)^2 over the places xi of the particles along an edge.
pub fn step(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let along = (scene.particles_per_cell as f64).sqrt().round() as u32;
    let square = |i: u32| (1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(along)).powi(2);
    let share = (0..along).map(square).sum::<f64>() / f64::from(along);
    let stiffness = scene.oedometer_modulus() + scene.pore_stiffness();
    let limit = scene.safety * scene.cell * (scene.mixture_density() / ((2.0 - share) * stiffness)).sqrt();
    Ok(Box::new(move |run| Ok(Comparison::single("step over that of the shortest wave", run, run.dt / limit, 1.0))))
}

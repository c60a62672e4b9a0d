//! Settlement of a column that starts from a given pressure and drains in stages, beside sums of modes.

use std::f64::consts::PI;

use mpm_core::scene::{Scene, Side, Until};

use super::Compare;
use crate::error::Error::{self, Unfit};
use crate::experiment::comparison::{Compared, Comparison};
use crate::experiment::spec::Measure;

/// Points over the height, and modes, of a pressure.
const POINTS: u32 = 4000;
const MODES: u32 = 300;

/// Settlement over that of all pressure, at all samples: of a column that starts from a pressure and is under a constant total stress.
/// In every stage the pressure is a sum of the modes of its drained ends.
pub fn stages(scene: &Scene, _: &Measure) -> Result<Compare, Error> {
    let (initial, water) = (scene.initial.clone().ok_or(Unfit("no given state"))?, scene.water.ok_or(Unfit("dry"))?);
    let (height, modulus, stages) = (scene.height, scene.oedometer_modulus(), scene.stages.clone());
    let coefficient = water.mobility() / scene.storage() / (height * height);
    let mean = |p: &[f64]| p.iter().sum::<f64>() / p.len() as f64;
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(POINTS);
    // p after a time, from p before it.
    let after = move |p: &[f64], drained: [bool; 4], time: f64| {
        let mut now = vec![0.0; p.len()];
        for k in 0..MODES {
            let k = f64::from(k);
            let (number, shift) = match (drained[Side::Bottom as usize], drained[Side::Top as usize]) {
                (false, true) => (k + 0.5, 0.0),
                (true, true) => (k + 1.0, 0.5),
                (false, false) => (k, 0.0),
                (true, false) => (k + 0.5, 0.5),
            };
            let mode: Vec<f64> = (0..POINTS).map(|i| (PI * (number * at(i) - shift)).cos()).collect();
            let share = if number == 0.0 { 1.0 } else { 2.0 };
            let amount = share * mode.iter().zip(p).map(|(m, p)| m * p).sum::<f64>() / p.len() as f64;
            let decay = (-coefficient * time * (PI * number).powi(2)).exp();
            now.iter_mut().zip(&mode).for_each(|(now, m)| *now += amount * decay * m);
        }
        now
    };
    Ok(Box::new(move |run| {
        let mut p: Vec<f64> = (0..POINTS).map(|i| initial.at(&[0.0, height * at(i)])[0]).collect();
        let whole = mean(&p);
        let mut rows = Vec::new();
        for (number, stage) in stages.iter().enumerate() {
            for sample in run.samples.iter().filter(|s| s.stage == number && s.stage_time > 0.0) {
                let now = after(&p, stage.drained, sample.stage_time);
                let settled = sample.state.settlement * modulus / (whole * height);
                rows.push(Compared::one(sample.stage_time, settled, 1.0 - mean(&now) / whole));
            }
            // A stage that nobody has looked at has its end all the same.
            let last = run.samples.iter().rev().find(|s| s.stage == number).map(|s| s.stage_time);
            let end = if let Until::Time(end) = stage.until { Some(end) } else { last };
            p = after(&p, stage.drained, end.unwrap_or(0.0));
        }
        Ok(Comparison::worst("U", rows))
    }))
}

//! Scenes of others: published set-ups and everyday ones, each right to a stated figure, refused, or ended with the reason.
//!
//! `reference-data/others/others.csv` says of every scene beside it what must come of it. A run that goes to its end and is off by
//! more than its tolerance would be wrong with exit code 0: the one thing that must not happen.

use std::collections::BTreeMap;

use mpm_core::drive::{Alone, Drive, Run, Sample};
use mpm_core::hardware::Hardware;
use mpm_core::observe::FieldPoint;
use mpm_core::run::{model, run, run_monitored};
use mpm_core::scene::{Fields, Scene};
use mpm_core::stability::choose_step;
use serde::Deserialize;

use super::bits::Stop;
use super::{Error, FASTER, Lacks, Mutant, Outcome, Program, Unfit, faster, sound};
use crate::experiment::refinement::{RUNS, Sampled};

/// The case.
pub const CASE: Program = Program {
    name: "others",
    about: "scenes of others: right to a stated figure, refused, or ended with the reason; the share that is none of these",
    run: || outcome(|_| true, sound),
    mutant: Some(Mutant { what: FASTER, run: || outcome(|_| true, faster) }),
};

/// The table.
const TABLE: &str = include_str!("../../../reference-data/others/others.csv");

/// Names and texts of the scenes of `reference-data/others`.
const SCENES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/others.rs"));

/// A row of `others.csv`.
#[derive(Debug, Clone, Deserialize)]
struct Row {
    /// Name of the scene.
    scene: String,
    /// Where the set-up or the figure is from.
    source: String,
    /// A column of `history.csv` or `water.csv`, or `corner_pressure_pa`; empty where nothing is measured.
    quantity: String,
    /// Time since the start of the last stage, s; the end where there is none.
    at_s: Option<f64>,
    /// A number, or a piece of the message.
    expected: String,
    /// Share of the number, or in its unit where that is zero.
    tolerance: Option<f64>,
    outcome: End,
    how: How,
    /// The formula, or why it must not run.
    why: String,
}

/// How a scene ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum End {
    /// At its end, within the tolerance: exit code 0.
    Right,
    /// Before the first step: exit code 2.
    Refused,
    /// On its way: exit code 3.
    Ended,
}

/// What a scene is run with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
enum How {
    /// As it is.
    #[serde(rename = "")]
    Plain,
    /// Without the estimate and the limit of the step that would refuse it, so that the balances are all that is left.
    #[serde(rename = "past the estimate")]
    PastTheEstimate,
}

/// What became of a scene.
enum Found {
    Refused(String),
    Ended(String),
    Finished(Box<Run>),
}

/// Runs the scene of a row as `solve` does. One that must be refused is not followed if it is not: it may take for ever.
fn found(row: &Row, fault: fn(&mut Fields)) -> Found {
    let (name, how) = (row.scene.as_str(), row.how);
    let text = SCENES.iter().find(|(own, _)| *own == name).map_or("", |(_, text)| text);
    let scene = match Scene::parse(text, &format!("{name}.toml")).and_then(|scene| scene.edited(fault)) {
        Ok(scene) => scene,
        Err(error) => return Found::Refused(error.to_string()),
    };
    let run = match how {
        How::Plain if row.outcome == End::Refused => {
            run_monitored(&Hardware::default(), &scene, None, &mut Stop::default()).map_err(Error::from)
        }
        How::Plain => run(&scene, &mut |_| {}).map_err(Error::from),
        How::PastTheEstimate => past_the_estimate(&scene),
    };
    match run {
        Err(refused) => Found::Refused(refused.to_string()),
        Ok(Run { failure: Some(failure), .. }) => Found::Ended(failure.to_string()),
        Ok(run) => Found::Finished(Box::new(run)),
    }
}

/// A run that nothing refuses, but that its balances still end.
fn past_the_estimate(scene: &Scene) -> Result<Run, Error> {
    let forced = scene.clone().forced();
    let dt = choose_step(&forced)?;
    let mut model = model(scene)?;
    Ok(Drive::new(scene, model.as_mut(), dt).go(&mut Alone(&mut |_| {})))
}

/// A number of a run.
fn measured(run: &Run, row: &Row) -> Option<f64> {
    let at = |s: &&Sample| row.at_s.is_none_or(|at| (s.stage_time - at).abs() <= 1e-9 * at);
    let last = run.samples.last()?.stage;
    let sample = run.samples.iter().rev().filter(|s| s.stage == last).find(at)?;
    let state = &sample.state;
    let corner = |a: &FieldPoint, b: &FieldPoint| (a.x_m + a.y_m).total_cmp(&(b.x_m + b.y_m));
    match row.quantity.as_str() {
        "settlement_m" => Some(state.settlement),
        "mean_pressure_pa" => Some(state.mean_pressure),
        "base_pressure_pa" => Some(state.base_pressure),
        "max_speed_m_s" => Some(state.max_speed),
        "centre_x_m" => Some(state.centre[0]),
        "in_m3" => state.water.map(|water| water.in_m3),
        "outflow_m3_s" => state.water.map(|water| water.outflow_m3_s),
        "corner_pressure_pa" => state.field.iter().min_by(|a, b| corner(a, b)).map(|point| point.pressure_pa),
        _ => None,
    }
}

/// What is said of a row: its error as a share of what it may be, or what came in place of what must.
fn judged(row: &Row, found: &Found) -> Result<Option<Sampled>, Error> {
    match (row.outcome, found) {
        (End::Right, Found::Finished(run)) => right(row, run).map(Some),
        (End::Refused, Found::Refused(said)) | (End::Ended, Found::Ended(said)) if said.contains(&row.expected) => {
            Ok(None)
        }
        (_, Found::Refused(said)) => Err(Error::Found(format!("refused: {said}"))),
        (_, Found::Ended(said)) => Err(Error::Found(format!("ended: {said}"))),
        (End::Refused, Found::Finished(_)) => Err(Unfit("not refused")),
        (_, Found::Finished(_)) => Err(Unfit("went to its end")),
    }
}

fn right(row: &Row, run: &Run) -> Result<Sampled, Error> {
    let expected: f64 = row.expected.parse().map_err(|_| Unfit("expected is no number"))?;
    let tolerance = row.tolerance.ok_or(Lacks("tolerance"))?;
    let computed = measured(run, row).ok_or(Unfit("nothing measured"))?;
    let allowed = if expected == 0.0 { tolerance } else { tolerance * expected.abs() };
    let error = (computed - expected) / allowed;
    if error.is_nan() || error.abs() > 1.0 {
        let off = format!("{computed:.6e}, expected {expected:.6e} +- {allowed:.1e}");
        return Err(Error::Found(format!("wrong: {} {off}", row.quantity)));
    }
    if let Some(trust) = run.trust.filter(|trust| trust.verdict != "closed") {
        return Err(Error::Found(format!("right, but its balance of {} does not close", trust.balance)));
    }
    Ok(Sampled {
        quantity: format!("{}: {}", row.scene, row.quantity),
        unit: "-".to_owned(),
        time: row.at_s.unwrap_or_else(|| run.samples.last().map_or(f64::NAN, |s| s.stage_time)),
        factor: None,
        computed,
        exact: expected,
        error,
        counts: true,
    })
}

/// The rows of the table.
fn rows() -> Result<Vec<Row>, Error> {
    csv::Reader::from_reader(TABLE.as_bytes())
        .deserialize()
        .collect::<Result<Vec<Row>, csv::Error>>()
        .map_err(Error::at("others.csv"))
}

fn outcome(of: fn(&Row) -> bool, fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let rows: Vec<Row> = rows()?.into_iter().filter(of).collect();
    let mut runs = BTreeMap::new();
    let (mut wrong, mut samples, mut counts) = (Vec::new(), Vec::new(), BTreeMap::new());
    for row in &rows {
        let found = runs.entry((row.scene.as_str(), row.how)).or_insert_with(|| found(row, fault));
        match judged(row, found) {
            Ok(sampled) => {
                *counts.entry(format!("{:?}", row.outcome).to_lowercase()).or_insert(0.0) += 1.0;
                samples.extend(sampled);
            }
            Err(said) => wrong.push(format!("{} ({}): {said}; {}", row.scene, row.source, row.why)),
        }
    }
    let share = wrong.len() as f64 / rows.len() as f64;
    let worst = samples.iter().map(|s: &Sampled| s.error.abs()).fold(0.0, f64::max);
    let mut notes = vec![("largest error of a figure over its tolerance".to_owned(), worst, "-".to_owned())];
    notes.extend(counts.into_iter().map(|(word, count)| (format!("rows {word}"), count, "-".to_owned())));
    Ok(Outcome {
        integrator: "all".to_owned(),
        scheme: "all".to_owned(),
        errors: vec![(rows.len() as f64, share)],
        required_error: 0.0,
        refined_by: RUNS,
        notes,
        samples,
        remarks: wrong,
        ..Outcome::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_has_its_row() {
        let rows = rows().expect("a table");
        for (name, _) in SCENES {
            assert!(rows.iter().any(|row| row.scene == *name), "{name} has no row");
        }
        for row in &rows {
            assert!(SCENES.iter().any(|(own, _)| *own == row.scene), "{} has no scene", row.scene);
            let figure = row.expected.parse::<f64>().is_ok() && row.tolerance.is_some_and(|t| t <= 0.02);
            let measured = !row.quantity.is_empty() && figure;
            assert!(if row.outcome == End::Right { measured } else { row.expected.len() > 3 }, "{}", row.scene);
        }
    }

    /// What takes no time: all that is refused, and runs without inertia.
    fn quick(row: &Row) -> bool {
        let text = SCENES.iter().find(|(own, _)| *own == row.scene).map_or("", |(_, text)| text);
        let plain = row.how == How::Plain && !text.contains("free_surface");
        plain && (row.outcome == End::Refused || text.contains("\"quasi-static\""))
    }

    #[test]
    fn quick_rows_hold_and_a_fault_is_found() {
        let all = outcome(quick, sound).expect("a table");
        assert!(all.remarks.is_empty() && all.errors[0].0 > 50.0, "{:?}", all.remarks);
        assert!(outcome(quick, faster).expect("a table").remarks.len() > 5);
    }
}

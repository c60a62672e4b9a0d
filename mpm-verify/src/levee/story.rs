//! What the player shows beside the moving picture: histories, stress paths, factors of safety, events, as plain lists of numbers.

use mpm_core::failure::{PathPoint, Row};
use serde_json::{Value, json};

use super::figures::events;
use super::plan::Plan;
use super::run::{Ended, Followed};
use super::safety;
use super::strength::Strength;

/// Most points of a curve: about one per px.
const MOST: usize = 500;

/// The lists, for JSON. `runout_side` is 1 where the toe looks towards +x, else -1; `why` is said beside the factors of safety.
pub fn of(plan: &Plan, run: &Followed, (factors, why): (&[safety::Line], &str), runout_side: f64) -> Value {
    let rows = thinned(&run.rows);
    let first_toe = run.rows.first().map_or(0.0, |row| row.toe_x_m);
    let column = |of: &dyn Fn(&Row) -> f64| rows.iter().map(|row| number(of(row))).collect::<Vec<_>>();
    let levels = plan.levels().iter().enumerate().map(|(k, x)| {
        json!({"name": format!("level at x = {x} m"), "short": format!("x = {x} m"), "values": column(&|row| row.levels[k])})
    });
    let moved = json!([
        {"name": "run-out of the toe", "values": column(&|row| runout_side * (row.toe_x_m - first_toe))},
        {"name": "settlement of the crest", "values": column(&|row| row.crest_settlement_m)},
    ]);
    let water = json!([
        {"name": "in the pores", "values": column(&|row| row.water_m3)},
        {"name": "flowed out", "values": column(&|row| row.water_out_m3)},
    ]);
    let rest = (run.ended == Ended::Collapsed).then(|| run.rows.last()).flatten();
    let rest = rest.map(|row| json!({"name": "rest", "words": "the soil is at rest", "time": 3600.0 * row.time_h}));
    let events: Vec<Value> = events(&run.events)
        .into_iter()
        .map(|event| json!({"name": event.name, "words": event.words, "time": event.time_s}))
        .chain(rest)
        .collect();
    let factors = factors.iter().filter(|line| line.davis_low.is_finite() && line.davis_high.is_finite()).map(|line| {
        json!({"time": 3600.0 * line.time_h, "low": line.davis_low, "high": line.davis_high, "spencer": line.spencer.map(number),
            "davis": line.spencer_davis.map(number)})
    });
    json!({
        "times": rows.iter().map(|row| tenth_of_milli(3600.0 * row.time_h)).collect::<Vec<_>>(),
        "levels": levels.collect::<Vec<_>>(),
        "moved": moved,
        "water": water,
        "events": events,
        "paths": paths(&run.paths),
        "strength": Strength::of(&plan.scene).map(|s| json!({"c": s.cohesion_kpa, "phi": s.friction_deg})),
        "factors": factors.collect::<Vec<_>>(),
        "why": why,
        "failure": run.events.failure_h.map(|h| 3600.0 * h),
        // Without this from the first slip on, curves of hours would hide the seconds of failure.
        "onset": run.events.unsettled_h.or(run.events.raveling_h).map(|h| 3600.0 * h),
    })
}

fn paths(all: &[PathPoint]) -> Vec<Value> {
    let count = all.iter().map(|p| p.point).max().unwrap_or(0);
    let path = |number_of: u32| {
        let own: Vec<PathPoint> = all.iter().filter(|p| p.point == number_of).copied().collect();
        let own = thinned(&own);
        let column = |of: &dyn Fn(&PathPoint) -> f64| own.iter().map(|p| number(of(p))).collect::<Vec<_>>();
        json!({
            "name": format!("S{number_of}"),
            "times": own.iter().map(|p| tenth_of_milli(3600.0 * p.time_h)).collect::<Vec<_>>(),
            "s": column(&|p| p.mean_pa / 1e3),
            "t": column(&|p| p.shear_pa / 1e3),
            "x": column(&|p| p.x_m),
            "y": column(&|p| p.y_m),
        })
    };
    (1..=count).map(path).collect()
}

/// Few enough to draw, with the first and the last.
fn thinned<T>(all: &[T]) -> Vec<&T> {
    let every = all.len().div_ceil(MOST).max(1);
    let last = all.len().saturating_sub(1);
    all.iter().enumerate().filter(|(k, _)| (last - k).is_multiple_of(every) || *k == 0).map(|(_, one)| one).collect()
}

/// Four digits: more than a curve shows.
fn number(value: f64) -> f64 {
    if value.is_finite() { format!("{value:.3e}").parse().unwrap_or(0.0) } else { 0.0 }
}

fn tenth_of_milli(time_s: f64) -> f64 {
    (time_s * 1e4).round() / 1e4
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lists_are_thinned_and_keep_their_ends() {
        let all: Vec<usize> = (0..1234).collect();
        let kept = thinned(&all);
        assert!(kept.len() <= MOST && *kept[0] == 0 && **kept.last().expect("some") == 1233);
        assert_eq!(thinned(&all[..3]).len(), 3);
        assert_eq!((number(0.123_456), number(f64::NAN)), (0.1235, 0.0));
    }
}

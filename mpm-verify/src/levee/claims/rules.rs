//! The rules, one function each.

use mpm_core::observe::SolidState;

use super::super::run::Ended;
use super::{Evidence, Judged, Rule};
use crate::frames::Shot;
use crate::report::numbers::short;

/// Movement below which a shape is unchanged, m.
const UNCHANGED: f64 = 0.01;
/// Movement above which soil is part of the failing body, m.
const MOVED: f64 = 0.05;
/// A large deviator strain, and the share of the failing body that must have it.
const LARGE: (f64, f64) = (0.05, 0.9);
/// Share of the strength at which a stress path has reached the failure line.
const AT_LINE: f64 = 0.95;
/// Times of the paper agree within this, h; those of the experiment within half an hour.
const CLOSE: f64 = 0.1;
const EXPERIMENT_CLOSE: f64 = 0.5;
/// The toe is that part of the slope, m from its end.
const NEAR_TOE: f64 = 3.0;
/// Pore pressure at the toe is that of the soil so far from it, m.
const AT_TOE: f64 = 0.5;
/// Water reaches the toe when failure starts if that is no longer ago, h.
const JUST: f64 = 0.5;
/// Pore pressure that is more than that of drops, Pa.
const FELT: f64 = 100.0;
/// Same time, h.
const SAME: f64 = 1e-6;

/// All rules, in the order of the paper.
pub const RULES: [Rule; 13] = [
    (
        "stands",
        "the levee stands at the start",
        "the soil is in equilibrium under its own weight and the first water, with no displacement above 1 cm before water seeps",
        stands,
    ),
    (
        "unchanged-until-8.4-h",
        "shape kept as the initial one until 8.4 h",
        "up to 8.4 h the largest displacement, the movement of the toe and the settlement of the crest are below 1 cm",
        unchanged,
    ),
    ("failure-time", "progressive failure at 8.66 h", "failure (E2) starts within 0.1 h of 8.66 h", failure_time),
    (
        "final-shape-time",
        "final shape at 8.68 h",
        "the soil is at rest after the collapse within 0.1 h of 8.68 h",
        final_time,
    ),
    (
        "failure-lasts",
        "0.02 h (72 s) from progressive failure to the final shape",
        "the time from the start of failure (E2) to rest is between half and twice 72 s",
        lasts,
    ),
    (
        "pressure-at-toe",
        "failure when the pore water pressure reaches the toe",
        "failure starts at most 0.5 h after the wetting front, or a pore pressure of 0.1 kPa, first comes within 0.5 m of the toe; there was none at the start, and there is pore pressure at failure",
        at_toe,
    ),
    (
        "starts-at-toe",
        "failure starts at the toe of the slope",
        "the mean x of the soil that defines E2 is at most 3 m from the toe",
        starts_at_toe,
    ),
    (
        "large-strain",
        "large deviator strains throughout the failing body",
        "at the end, 90 % of the soil that has moved more than 5 cm has a deviator strain above 0.05",
        large_strain,
    ),
    (
        "stress-paths",
        "all effective stress paths approach the failure line",
        "every observed point that moves more than 5 cm reaches 0.95 of its strength, t/(c cos phi + s' sin phi), after the start of failure",
        stress_paths,
    ),
    (
        "experiment-toe",
        "experiment: small failure at the toe at 12.5 h",
        "the toe fails (E1) within 0.5 h of 12.5 h",
        experiment_toe,
    ),
    (
        "experiment-failure",
        "experiment: progressive failure from 13 h",
        "failure (E2) starts within 0.5 h of 13 h",
        experiment_failure,
    ),
    (
        "experiment-progressive",
        "experiment: progressive failure within 10 min",
        "the time from failure (E2) to rapid failure (E3) is at most 10 min",
        experiment_progressive,
    ),
    (
        "experiment-rapid",
        "experiment: rapid failure for about 30 s",
        "the time from rapid failure (E3) to rest is between 15 and 60 s",
        experiment_rapid,
    ),
];

/// A time and its distance from another; neither the mesh nor the assumptions carry more than a tenth of an hour.
fn near(time: f64, expected: f64, within: f64) -> (String, bool) {
    let off = format!("{:+.1}", time - expected).replace('-', "\u{2212}");
    (format!("{time:.1} h ({off} h)"), (time - expected).abs() <= within + SAME)
}

fn way(p: &SolidState) -> f64 {
    p.displacement[0].hypot(p.displacement[1])
}

/// When soil rests after the collapse, h.
fn rest(e: &Evidence) -> Option<f64> {
    e.rows.last().filter(|_| *e.ended == Ended::Collapsed).map(|r| r.time_h)
}

fn stands(e: &Evidence) -> Judged {
    if let Ended::DoesNotStand(what) = e.ended {
        return Some((what.clone(), false));
    }
    // A run that goes on all the same begins with soil that moves.
    let first = e.rows.first()?;
    let failing = first.phase == mpm_core::failure::Phase::Failing;
    let most = first.max_displacement_m;
    let text = format!("largest displacement {} m{}", short(most, 2), if failing { ", not at rest" } else { "" });
    Some((text, !failing && most < UNCHANGED))
}

fn unchanged(e: &Evidence) -> Judged {
    const UNTIL: f64 = 8.4;
    let first = e.rows.first()?;
    e.rows.last().filter(|r| r.time_h >= UNTIL - SAME)?;
    let rows = || e.rows.iter().filter(|r| r.time_h <= UNTIL + SAME);
    let most = rows().map(|r| r.max_displacement_m).fold(0.0, f64::max);
    let toe = rows().map(|r| (r.toe_x_m - first.toe_x_m).abs()).fold(0.0, f64::max);
    let crest = rows().map(|r| r.crest_settlement_m.abs()).fold(0.0, f64::max);
    let text = format!("displacement {} m, toe {} m, crest {} m", short(most, 2), short(toe, 2), short(crest, 2));
    Some((text, most < UNCHANGED && toe < UNCHANGED && crest < UNCHANGED))
}

fn failure_time(e: &Evidence) -> Judged {
    Some(near(e.events.failure_h?, 8.66, CLOSE))
}

fn final_time(e: &Evidence) -> Judged {
    Some(near(rest(e)?, 8.68, CLOSE))
}

fn lasts(e: &Evidence) -> Judged {
    let seconds = 3600.0 * (rest(e)? - e.events.failure_h?);
    Some((format!("{} s", short(seconds, 2)), (36.0..=144.0).contains(&seconds)))
}

fn at_toe(e: &Evidence) -> Judged {
    let failure = e.events.failure_h?;
    let near = |p: &&SolidState| p.x[0] - p.displacement[0] > e.toe_m - AT_TOE;
    let pressure = |shot: &Shot| shot.frame.solid.iter().filter(near).map(|p| p.pore_pressure).fold(0.0, f64::max);
    let then = pressure(e.shots.iter().find(|s| (s.hours() - failure).abs() < SAME)?);
    // The front is a matter of one particle: soil that feels water tells the same.
    let felt = e.shots.iter().find(|s| pressure(s) > FELT).map(Shot::hours);
    let first = [felt, e.events.front_at_toe_h].into_iter().flatten().reduce(f64::min);
    let start = e.rows.first()?.time_h;
    let (delay, just) = match first {
        Some(first) if first <= start + SAME => ("pore pressure there from the start".to_owned(), false),
        Some(first) if first <= failure => {
            (format!("failure {:.1} h after that", failure - first), failure - first <= JUST)
        }
        _ => ("failure before that".to_owned(), false),
    };
    Some((format!("{delay}; pore pressure there then {} kPa", short(then / 1e3, 2)), just && then > 0.0))
}

fn starts_at_toe(e: &Evidence) -> Judged {
    let place = e.events.failure_at_m?;
    Some((format!("x = {place:.1} m"), place >= e.toe_m - NEAR_TOE))
}

fn large_strain(e: &Evidence) -> Judged {
    e.events.failure_h?;
    let moved = || e.shots.last().into_iter().flat_map(|s| s.frame.solid.iter().filter(|p| way(p) > MOVED));
    let mass: f64 = moved().map(|p| p.mass).sum();
    let strained: f64 = moved().filter(|p| p.deviator_strain > LARGE.0).map(|p| p.mass).sum();
    let share = (mass > 0.0).then(|| strained / mass)?;
    Some((format!("{} % of the soil that moved", short(100.0 * share, 3)), share >= LARGE.1))
}

fn stress_paths(e: &Evidence) -> Judged {
    let (failure, strength) = (e.events.failure_h?, e.strength?);
    let count = e.paths.iter().map(|p| p.point).max()?;
    let used = (1..=count).filter_map(|number| {
        let path = || e.paths.iter().filter(move |p| p.point == number);
        let (first, last) = (path().next()?, path().next_back()?);
        let moved = (last.x_m - first.x_m).hypot(last.y_m - first.y_m) > MOVED;
        let later = path().filter(|p| p.time_h >= failure - SAME);
        let share = |t: f64, s: f64| {
            let limit = strength.limit(1e-3 * s);
            // Without strength any stress is at the line.
            if limit > 0.0 { 1e-3 * t / limit } else { 1.0 }
        };
        moved.then(|| (number, later.map(|p| share(p.shear_pa, p.mean_pa)).fold(0.0, f64::max)))
    });
    let used: Vec<(u32, f64)> = used.collect();
    let least = used.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let text =
        format!("{} observed points moved; lowest: {} of the strength, at S{}", used.len(), short(least.1, 2), least.0);
    Some((text, least.1 >= AT_LINE))
}

fn experiment_toe(e: &Evidence) -> Judged {
    Some(near(e.events.raveling_h?, 12.5, EXPERIMENT_CLOSE))
}

fn experiment_failure(e: &Evidence) -> Judged {
    Some(near(e.events.failure_h?, 13.0, EXPERIMENT_CLOSE))
}

fn experiment_progressive(e: &Evidence) -> Judged {
    let minutes = 60.0 * (e.events.collapse_h? - e.events.failure_h?);
    Some((format!("{} min", short(minutes, 2)), minutes <= 10.0))
}

fn experiment_rapid(e: &Evidence) -> Judged {
    let seconds = 3600.0 * (rest(e)? - e.events.collapse_h?);
    Some((format!("{} s", short(seconds, 2)), (15.0..=60.0).contains(&seconds)))
}

//! The factor of safety over time: strength reduction on the state of a run, beside limit equilibrium with its water.
//!
//! Water seeps to a time in soil that is held, whether or not it would stand; then the strength is divided by factors until the
//! deep slide starts ([`crate::slope`]); the state is as before afterwards, and water goes on from it to the next time.

use std::path::Path;

use mpm_core::failure::{Bracket as Found, Scales, towards};
use mpm_core::scene::Scene;
use serde::{Deserialize, Serialize};

use super::figures::{Picture, events};
use super::plan::Plan;
use super::tables::OfScene;
use crate::error::Error::{self, Unfit};
use crate::exact::root::root;
use crate::report::ReportError;
use crate::report::content::table::{Cell, Table, table};
use crate::report::numbers::brief;
use crate::report::plots::levee::safety::{self as plot, Bracket, Safety};
use crate::slope::equilibrium::Profile;
use crate::slope::{State, at_rest, guesses};

/// Name of the table in the folder of a run.
pub const NAME: &str = "safety_factor.csv";
/// Width of the bracket.
const WITHIN: f64 = 0.01;

/// The factors at one time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Time on the clock of the run, h.
    pub time_h: f64,
    /// It stands with its strength divided by this, and the dilation of the scene; not a number where none was found.
    pub fs_low: f64,
    /// It slides with its strength divided by this.
    pub fs_high: f64,
    /// Of the infinite slope with water that leaves it horizontally; from when water is at the toe.
    pub infinite_slope: Option<f64>,
    /// The same with Davis' reduced strength.
    pub infinite_slope_davis: Option<f64>,
    /// By Bishop's method.
    pub bishop: Option<f64>,
    /// The same with Davis' reduced strength.
    pub bishop_davis: Option<f64>,
    /// By Spencer's method.
    pub spencer: Option<f64>,
    /// The same with Davis' reduced strength.
    pub spencer_davis: Option<f64>,
    /// Trials.
    pub trials: u32,
    /// Steps of all trials.
    pub steps: u64,
    /// Of which scene: [`Plan::scene_word`].
    pub scene: String,
    /// Least and largest factor between the two at which a trial neither came to rest nor slid.
    #[serde(default)]
    pub undecided_low: Option<f64>,
    /// See `undecided_low`.
    #[serde(default)]
    pub undecided_high: Option<f64>,
    /// Why limit equilibrium has no factors, where it has none.
    #[serde(default)]
    pub no_limit_equilibrium: String,
    /// The same as `fs_low` with Davis' strength (Davis B).
    #[serde(default)]
    pub davis_low: f64,
    /// See `davis_low`.
    #[serde(default)]
    pub davis_high: f64,
    /// The same with associated flow.
    #[serde(default)]
    pub associated_low: f64,
    /// See `associated_low`.
    #[serde(default)]
    pub associated_high: f64,
    /// By Spencer's method, on a surface of any shape.
    #[serde(default)]
    pub spencer_any_shape: Option<f64>,
    /// Levels of the water at the places of the scene, m; not in the table.
    #[serde(skip)]
    pub levels_m: Vec<f64>,
}

impl OfScene for Line {
    fn scene(&self) -> &str {
        &self.scene
    }
}

/// Factors at some times (h), in their order in time, on so many threads.
///
/// # Errors
/// What was expected of a time and found, or what went wrong in a step.
pub fn compute(
    plan: &Plan,
    times_h: &[f64],
    jobs: usize,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Vec<Line>, Error> {
    let mut times = times_h.to_vec();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let mut driver = at_rest(&plan.scene)?;
    let mut lines = Vec::new();
    for time in times {
        driver.seep_only(plan.seconds(time))?;
        let Some(row) = driver.rows.last().cloned() else {
            return Err(Unfit("the slope does not stand before water seeps: it has no factor of safety"));
        };
        let state = State::of(&plan.scene, &mut driver);
        let slices = state.slices();
        let told = |text: &str| progress(&format!("{time} h, {text}"));
        let [davis, associated, given] = state.factors((WITHIN, guesses(&slices)), jobs, &told)?.found;
        // Water that leaves the slope does so from the toe up.
        let (scales, side) = (Scales::of(&plan.scene), towards(&plan.scene.outline_or_box()));
        let toe = plan.scene.outline_or_box().iter().map(|x| side * x[0]).fold(f64::NEG_INFINITY, f64::max);
        let at_toe = side * row.front_x_m >= toe - scales.at_toe() || row.water_out_m3 > scales.drops();
        let infinite = if at_toe { infinite_slope(&plan.scene, side, state.depth) } else { [None; 2] };
        let none = String::new();
        let why = slices.as_ref().err().map_or(none, ToString::to_string);
        let [full, reduced] = slices.map_or([None, None], |[full, davis]| [Some(full), Some(davis)]);
        let all = [&davis, &associated, &given].map(|found| found.bracket);
        lines.push(Line {
            infinite_slope: infinite[0],
            infinite_slope_davis: infinite[1],
            bishop: full.as_ref().and_then(|f| f.bishop),
            bishop_davis: reduced.as_ref().and_then(|f| f.bishop),
            spencer: full.as_ref().and_then(|f| f.spencer),
            spencer_davis: reduced.as_ref().and_then(|f| f.spencer),
            spencer_any_shape: full.as_ref().and_then(|f| f.any_shape),
            scene: plan.scene_word(),
            levels_m: row.levels.clone(),
            no_limit_equilibrium: why,
            ..line(time, &all)
        });
    }
    Ok(lines)
}

/// Factors of the slope without end that the slope is like at its toe, with the strength and with Davis'.
fn infinite_slope(scene: &Scene, side: f64, depth: f64) -> [Option<f64>; 2] {
    let profile = |reduced: f64| Some(Profile::of_scene(scene, side).ok()??.with_davis(scene, reduced));
    let full = Profile::of_scene(scene, side).ok().flatten().and_then(|profile| profile.toe()?.factor(depth));
    // Davis' strength belongs to the factor that it leads to.
    let excess = |reduced: f64| profile(reduced).and_then(|p| p.toe()?.factor(depth)).map_or(f64::NAN, |f| f - 1.0);
    [full, full.and_then(|full| root(excess, LEAST * full, full))]
}

/// Davis' factor is looked for from this share of the full one on.
const LEAST: f64 = 0.1;

/// A line of what trials have found: Davis B, associated, as given.
fn line(time_h: f64, [davis, associated, given]: &[Found; 3]) -> Line {
    Line {
        time_h,
        fs_low: given.low,
        fs_high: given.high,
        infinite_slope: None,
        infinite_slope_davis: None,
        bishop: None,
        bishop_davis: None,
        spencer: None,
        spencer_davis: None,
        trials: davis.trials + associated.trials + given.trials,
        steps: davis.steps + associated.steps + given.steps,
        undecided_low: given.undecided.map(|[low, _]| low),
        undecided_high: given.undecided.map(|[_, high]| high),
        davis_low: davis.low,
        davis_high: davis.high,
        associated_low: associated.low,
        associated_high: associated.high,
        spencer_any_shape: None,
        no_limit_equilibrium: String::new(),
        scene: String::new(),
        levels_m: Vec::new(),
    }
}

impl Line {
    /// In one sentence, with what is missing and why.
    pub fn said(&self) -> String {
        let undecided = self.undecided_low.zip(self.undecided_high).map_or_else(String::new, |(low, high)| {
            format!("; from {low:.3} to {high:.3} trials neither came to rest nor slid: undecided")
        });
        let slices = match self.no_limit_equilibrium.as_str() {
            "" => String::new(),
            why => format!("; no limit equilibrium beside it: {why}"),
        };
        format!(
            "factor of safety at {} h: {:.3} with Davis' strength, {:.3} associated, {:.3} to {:.3} with the dilation of the scene{undecided}{slices}",
            self.time_h,
            self.davis(),
            self.associated(),
            self.fs_low,
            self.fs_high
        )
    }

    /// The factor with Davis' strength.
    pub fn davis(&self) -> f64 {
        0.5 * (self.davis_low + self.davis_high)
    }

    /// The factor with associated flow.
    pub fn associated(&self) -> f64 {
        0.5 * (self.associated_low + self.associated_high)
    }
}

/// When a factor falls below one, h, between the times of two lines.
fn falls(lines: &[Line], factor: impl Fn(&Line) -> f64) -> Option<f64> {
    let points = lines.iter().map(|l| (l.time_h, factor(l))).filter(|p| p.1.is_finite());
    let points: Vec<(f64, f64)> = points.collect();
    let pair = points.windows(2).find(|pair| pair[0].1 >= 1.0 && pair[1].1 < 1.0)?;
    let ((t0, f0), (t1, f1)) = (pair[0], pair[1]);
    Some(t0 + (f0 - 1.0) / (f0 - f1) * (t1 - t0))
}

/// When the slope fails by its factors, h: from Davis' strength to the full one; an end that lies beyond the times is missing.
pub fn fails_between(lines: &[Line]) -> [Option<f64>; 2] {
    [falls(lines, Line::davis), falls(lines, Line::associated)]
}

/// The time of failure that the factors imply, in words.
pub fn implied(lines: &[Line]) -> Option<String> {
    let [from, to] = fails_between(lines);
    if from.is_none() && to.is_none() {
        return None;
    }
    let text = |time: Option<f64>, none: &str| time.map_or_else(|| none.to_owned(), |h| format!("{h:.1} h"));
    Some(format!(
        "The factor is 1 from {} (Davis' strength) to {} (the full strength)",
        text(from, "before the first time"),
        text(to, "after the last time")
    ))
}

/// The variant whose base keeps the friction that it starts with.
const KEEPS_FRICTION: &str = "base-30";

/// Why a levee on a base that weakens with slip fails before its factor of safety is 1, from the numbers of the run, its factors and variants;
/// `None` where it does not.
pub fn why_earlier(
    scene: &Scene,
    lines: &[Line],
    fails_h: Option<f64>,
    variants: &[super::sensitivity::Line],
) -> Option<String> {
    let (from, fails, base) = (fails_between(lines)[0]?, fails_h?, scene.base?);
    let over = base.slip_distance.filter(|_| base.residual_angle < base.peak_angle && fails < from)?;
    let toe_fails = |name: &str| variants.iter().find(|line| line.variant == name)?.raveling_h;
    let kept = toe_fails(KEEPS_FRICTION).zip(toe_fails("base")).map_or_else(String::new, |(kept, weakens)| {
        format!(
            " With a base that keeps {}° the toe fails at {kept:.1} h in place of {weakens:.1} h (both from the variants).",
            brief(base.peak_angle, 3)
        )
    });
    Some(format!(
        "Why the toe fails (E1) at {fails:.1} h although the factor falls to 1 only at {from:.1} h: the factor is that of a base that keeps its friction \
         of {}°, since slip is frozen in its trials. In the run the base weakens to {}° over {} mm of slip, so that the first slip grows by itself.{kept}",
        brief(base.peak_angle, 3),
        brief(base.residual_angle, 3),
        brief(1e3 * over, 3),
    ))
}

/// Draws them, with the events of the run and why these come before the factor is 1.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn picture(
    lines: &[Line],
    happened: Option<&mpm_core::failure::Events>,
    why: &str,
    folder: &Path,
) -> Result<Picture, ReportError> {
    let curve = |of: fn(&Line) -> Option<f64>| lines.iter().filter_map(|l| Some((l.time_h, of(l)?))).collect();
    let brackets = |of: fn(&Line) -> [f64; 2]| {
        let found =
            lines.iter().map(|l| (l.time_h, of(l))).filter(|(_, [low, high])| low.is_finite() || high.is_finite());
        found.map(|(time_h, [low, high])| Bracket { time_h, low, high }).collect()
    };
    let safety = Safety {
        brackets: brackets(|l| [l.davis_low, l.davis_high]),
        associated: brackets(|l| [l.associated_low, l.associated_high]),
        infinite_slope: curve(|l| l.infinite_slope),
        bishop: curve(|l| l.bishop),
        spencer: curve(|l| l.spencer),
        spencer_davis: curve(|l| l.spencer_davis),
        why: why.to_owned(),
    };
    let events = happened.map(events).unwrap_or_default();
    let svg = plot::write(&safety, &events, folder)?;
    Ok(Picture::new(plot::figure(&safety, &events), &svg))
}

/// A table for the page.
pub fn shown(lines: &[Line]) -> Table {
    let head = ["time (h)", "Davis B", "associated", "as given", "infinite slope", "Bishop", "Spencer"];
    let pair = |full: Option<f64>, davis: Option<f64>| {
        let text = |v: Option<f64>| v.map_or_else(|| "–".to_owned(), |v| format!("{v:.2}"));
        Cell::new(text(full)).marked(format!("Davis {}", text(davis)), "")
    };
    let row = |l: &Line| {
        let found = |low: f64, high: f64| match low.is_finite() {
            true => Cell::new(format!("{low:.2} to {high:.2}")),
            false => Cell::new("none found"),
        };
        vec![
            Cell::new(brief(l.time_h, 4)).marked(format!("{} trials, {} steps", l.trials, l.steps), ""),
            found(l.davis_low, l.davis_high),
            found(l.associated_low, l.associated_high),
            found(l.fs_low, l.fs_high),
            pair(l.infinite_slope, l.infinite_slope_davis),
            pair(l.bishop, l.bishop_davis),
            pair(l.spencer, l.spencer_davis),
        ]
    };
    let implied = implied(lines).map_or_else(String::new, |text| format!(" {text}."));
    let note = "Strength reduction with Davis' strength, associated flow and the dilation of the scene. Slides at least a tenth of the height \
                deep; limit equilibrium with the run's level of water, hydrostatic below it; the peak friction of the base. Davis: with \
                his reduced strength for a soil without dilation. The infinite slope is that at the toe, from when water is there.";
    let mut whys: Vec<&str> =
        lines.iter().map(|l| l.no_limit_equilibrium.as_str()).filter(|why| !why.is_empty()).collect();
    whys.dedup();
    let missing: String = whys.iter().map(|why| format!(" No limit equilibrium: {why}.")).collect();
    let undecided = if lines.iter().any(|l| l.undecided_low.is_some()) {
        " Wider brackets: trials between neither came to rest nor slid within their time."
    } else {
        ""
    };
    let note = format!("{note}{undecided}{missing}{implied}");
    table("Factor of safety".to_owned(), &head, lines.iter().map(row).collect(), &note)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factors_imply_a_time_and_how_uncertain_it_is() {
        let at = |time_h: f64, davis: f64| {
            let found = |fs: f64| Found { low: fs - 0.005, high: fs + 0.005, trials: 0, steps: 0, undecided: None };
            line(time_h, &[found(davis), found(davis + 0.1), found(davis + 0.05)])
        };
        let lines = [at(10.0, 1.10), at(14.0, 0.98), at(18.0, 0.88)];
        let text = implied(&lines).expect("a time");
        assert_eq!(text, "The factor is 1 from 13.3 h (Davis' strength) to 17.2 h (the full strength)");
        let late = implied(&lines[..2]).expect("a time");
        assert!(late.ends_with("to after the last time (the full strength)"), "{late}");
        assert_eq!(implied(&lines[..1]), None);
    }

    #[test]
    fn it_is_said_why_a_levee_on_a_base_that_weakens_fails_before_its_factor_is_one() {
        let scene = crate::scenes::built_in("levee").expect("a scene");
        let at = |time_h: f64, davis: f64| {
            let found = Found { low: davis - 0.005, high: davis + 0.005, trials: 0, steps: 0, undecided: None };
            line(time_h, &[found; 3])
        };
        let lines = [at(10.0, 1.03), at(12.0, 0.93)];
        let variant = |name: &str, hours: f64| {
            let line = crate::levee::sensitivity::Line::named(name, "", "");
            crate::levee::sensitivity::Line { raveling_h: Some(hours), ..line }
        };
        let variants = [variant("base", 10.34), variant("base-30", 11.18)];
        let why = why_earlier(&scene, &lines, Some(9.89), &variants).expect("a reason");
        for part in ["at 9.9 h", "only at 10.6 h", "friction of 30°", "8.5° over 20 mm", "11.2 h in place of 10.3 h"]
        {
            assert!(why.contains(part), "{part}: {why}");
        }
        assert_eq!(why_earlier(&scene, &lines, Some(11.0), &variants), None);
        let keeps = scene.edited(|scene| {
            scene.base = scene.base.map(|base| mpm_core::scene::Base { residual_angle: base.peak_angle, ..base })
        });
        assert_eq!(why_earlier(&keeps.expect("a scene"), &lines, Some(9.89), &variants), None);
    }
}

//! The probability that the slope has failed by a time: what is not known of its soil is sampled, and each sample fails when its factor
//! of safety has fallen to that at which whole runs fail.
//!
//! Three things make a thousand samples cheap. Water that seeps through the same soil `s` times as fast is where it was at `s` times
//! the time, with `s = k/(1 - S_0)`: one run of the water, with the soil held, serves all. The factor of a slice method is that by
//! which cohesion and tan(phi) are divided, so that `F(c, tan(phi)) = tan(phi) F(c/tan(phi), 1)`: a few ratios at a few times are
//! tabled. And Davis' strength belongs to the factor that it leads to, `F = beta(F) F_full` ([`mpm_core::scene::Reduction::Davis`]). Left
//! out: what moisture adds to the weight.
//!
//! Whole runs of some of the samples show at which factor soil fails, and how far that scatters.

use mpm_core::failure::Scales;
use mpm_core::random::Random;
use mpm_core::scene::{Fields, Flags, Reduction, Scene, Strength};
use serde::{Deserialize, Serialize};

use super::ensemble::Spread;
use super::figures::Picture;
use super::plan::{self, Plan};
use super::run::follow_quietly;
use super::tables::OfScene;
use super::variants::Variant;
use crate::error::Error::{self, Unfit};
use crate::exact::root::root;
use crate::experiment::pool;
use crate::report::ReportError;
use crate::report::content::table::{Cell, Table, table};
use crate::report::numbers::short;
use crate::report::plots::levee::Event;
use crate::report::plots::levee::probability::{self as plot, Curve};
use crate::slope::{State, at_rest};

/// Name of the table in the folder of a run.
pub const NAME: &str = "probability.csv";
/// Samples that are run whole, on cells of twice the scene's.
const WHOLE: usize = 20;
/// Ratios of cohesion to tan(phi), over that of the scene, and times that are tabled, the last so many times as late as the scene ends.
const RATIOS: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];
const TIMES: usize = 12;
const LATER: f64 = 2.0;
/// Times at which the page tells the probability, between the first and the last percent.
const ROWS: usize = 9;

/// What is taken to be known beforehand, all of it assumed: coefficients of variation of cohesion (log-normal), tan(phi) (normal) and
/// conductivity (log-normal), about the values of the scene; half the range of the saturation at the start (uniform). Phoon & Kulhawy
/// 1999, doi:10.1139/t99-038, give 5 to 15 % for the friction of sand, and Duncan 2000,
/// doi:10.1061/(ASCE)1090-0241(2000)126:4(307), 70 to 90 % for conductivities in the field; this one was measured on what the levee
/// was built of.
const PRIORS: Priors = Priors { cohesion: 0.3, friction: 0.05, conductivity: 0.3, saturation: 0.2 };

struct Priors {
    cohesion: f64,
    friction: f64,
    conductivity: f64,
    saturation: f64,
}

/// One sample.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Its number, from 0.
    pub sample: usize,
    /// Cohesion, Pa.
    pub cohesion_pa: f64,
    /// Angle of friction, degrees.
    pub friction_deg: f64,
    /// Hydraulic conductivity, m/s.
    pub conductivity_m_s: f64,
    /// Saturation at the start.
    pub saturation: f64,
    /// When it fails (E1), by its factor of safety, h; none until the end of the scene.
    pub fails_h: Option<f64>,
    /// The same with the critical factor at the lower, and at the upper end of what runs show.
    pub late_h: Option<f64>,
    /// See `late_h`.
    pub early_h: Option<f64>,
    /// When a whole run of it fails (E1), h.
    pub run_fails_h: Option<f64>,
    /// Its factor of safety then, by the table.
    pub run_factor: Option<f64>,
    /// What went wrong in its run, if something did; `-` if there was none.
    pub run: String,
    /// Of which scene: [`Plan::scene_word`].
    pub scene: String,
}

impl OfScene for Line {
    fn scene(&self) -> &str {
        &self.scene
    }
}

/// The factor of safety of any sample at any time.
struct Surrogate {
    /// Times, s, for the water of the scene.
    times: Vec<f64>,
    /// The full factor at each time for each of [`RATIOS`], at the tan(phi) of the scene.
    factors: Vec<[f64; RATIOS.len()]>,
    strength: Strength,
}

impl Surrogate {
    /// Of a scene, by Spencer's method, on so many threads.
    fn of(scene: &Scene, ends: f64, jobs: usize) -> Result<Self, Error> {
        // The table is one of ratios of cohesion to tan(phi).
        let strength =
            scene.strength.filter(|s| s.cohesion > 0.0 && s.friction_angle > 0.0 && scene.soils().len() == 1);
        let strength =
            strength.ok_or(Unfit("the probability of failure asks for one soil with cohesion and friction"))?;
        let mut driver = at_rest(scene)?;
        let times: Vec<f64> = (1..=TIMES).map(|k| LATER * ends * (k as f64 / TIMES as f64).powi(2)).collect();
        let mut states = Vec::new();
        for time in &times {
            driver.seep_only(*time)?;
            states.push(State::of(scene, &mut driver));
        }
        let one = |_: usize, state: &State| -> Result<[f64; RATIOS.len()], Error> {
            let mut row = [0.0; RATIOS.len()];
            for (factor, ratio) in row.iter_mut().zip(RATIOS) {
                let other = scene.edited(|fields| with(fields, ratio * strength.cohesion))?;
                *factor = state.spencer_of(&other)?;
            }
            Ok(row)
        };
        let found = pool::each(jobs, &states, one, |_, _| ());
        let factors = found.into_iter().map(|row| row.and_then(|row| row)).collect::<Result<_, _>>()?;
        Ok(Self { times, factors, strength })
    }

    /// With Davis' strength, after water has seeped for a time (s) that is scaled by its speed.
    fn factor(&self, sample: &Line, time: f64) -> f64 {
        let tangent = |angle: f64| angle.to_radians().tan();
        let stronger = tangent(sample.friction_deg) / tangent(self.strength.friction_angle);
        let ratio = (sample.cohesion_pa / self.strength.cohesion / stronger).clamp(RATIOS[0], RATIOS[RATIOS.len() - 1]);
        let along = |row: &[f64; RATIOS.len()]| {
            let right = RATIOS.iter().position(|r| ratio <= *r).unwrap_or(RATIOS.len() - 1).max(1);
            let part = (ratio / RATIOS[right - 1]).ln() / (RATIOS[right] / RATIOS[right - 1]).ln();
            row[right - 1] + part * (row[right] - row[right - 1])
        };
        let right = self.times.iter().position(|t| time <= *t).unwrap_or(self.times.len() - 1).max(1);
        let part = ((time - self.times[right - 1]) / (self.times[right] - self.times[right - 1])).min(1.0);
        let [before, after] = [right - 1, right].map(|k| along(&self.factors[k]));
        let full = stronger * (before + part * (after - before));
        let own = Strength {
            cohesion: sample.cohesion_pa,
            friction_angle: sample.friction_deg,
            dilation_angle: self.strength.dilation_angle.min(sample.friction_deg),
            ..self.strength
        };
        let share = |factor: f64| factor * own.reduced(factor, Reduction::Davis).cohesion / own.cohesion;
        root(|factor| share(factor) * full - factor, 0.05 * full, full).unwrap_or(0.0)
    }

    /// When the factor has fallen to a critical one, s, up to a time; `speed` is that of the water over that of the scene.
    fn fails(&self, sample: &Line, (critical, speed): (f64, f64), until: f64) -> Option<f64> {
        let over = |time: f64| self.factor(sample, speed * time) - critical;
        const PARTS: usize = 48;
        let mut before = 0.0;
        for k in 1..=PARTS {
            let time = until * k as f64 / PARTS as f64;
            if over(time) <= 0.0 {
                return root(over, before, time).or(Some(time));
            }
            before = time;
        }
        None
    }
}

/// The scene with another cohesion.
fn with(fields: &mut Fields, cohesion: f64) {
    if let Some(strength) = &mut fields.strength {
        strength.cohesion = cohesion;
    }
}

impl Line {
    /// A sample of the priors about a scene.
    fn sampled(scene: &Scene, sample: usize, random: &mut Random, word: &str) -> Self {
        let mut normal = || {
            // Box & Muller 1958.
            let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
            radius * (2.0 * std::f64::consts::PI * random.unit()).cos()
        };
        let spread = |cov: f64| (1.0 + cov * cov).ln().sqrt();
        let log = |mean: f64, cov: f64, z: f64| mean * (spread(cov) * z - 0.5 * spread(cov).powi(2)).exp();
        let strength = scene.strength.expect("the table has asked for it");
        let water = scene.water.map_or(0.0, |water| water.hydraulic_conductivity);
        let saturation = scene.free_surface.as_ref().map_or(0.0, |free| free.saturation);
        let cohesion_pa = log(strength.cohesion, PRIORS.cohesion, normal());
        let tangent = strength.friction_angle.to_radians().tan() * (1.0 + PRIORS.friction * normal().clamp(-3.0, 3.0));
        let conductivity_m_s = log(water, PRIORS.conductivity, normal());
        let (low, high) = ((saturation - PRIORS.saturation).max(0.0), (saturation + PRIORS.saturation).min(0.9));
        Self {
            sample,
            cohesion_pa,
            friction_deg: tangent.atan().to_degrees(),
            conductivity_m_s,
            saturation: low + (high - low) * random.unit(),
            fails_h: None,
            late_h: None,
            early_h: None,
            run_fails_h: None,
            run_factor: None,
            run: "-".to_owned(),
            scene: word.to_owned(),
        }
    }

    /// How fast its water seeps, over that of the scene.
    fn speed(&self, scene: &Scene) -> f64 {
        let conductivity = scene.water.map_or(1.0, |water| water.hydraulic_conductivity);
        let saturation = scene.free_surface.as_ref().map_or(0.0, |free| free.saturation);
        self.conductivity_m_s / conductivity * (1.0 - saturation) / (1.0 - self.saturation)
    }

    fn edit(&self, fields: &mut Fields) {
        if let Some(strength) = &mut fields.strength {
            (strength.cohesion, strength.friction_angle) = (self.cohesion_pa, self.friction_deg);
        }
        if let Some(water) = &mut fields.water {
            water.hydraulic_conductivity = self.conductivity_m_s;
        }
        if let Some(free) = &mut fields.free_surface {
            free.saturation = self.saturation;
        }
        // The base is as strong as the soil at first.
        if let Some(base) = &mut fields.base {
            base.peak_angle = base.peak_angle.min(self.friction_deg);
        }
    }
}

/// So many samples of a scene, and whole runs of some of them, on so many threads.
///
/// # Errors
/// What was expected of the scene and found, or what went wrong in a step.
pub fn compute(
    (source, variant): (&str, Option<&Variant>),
    flags: &Flags,
    samples: usize,
    jobs: usize,
    tell: &(dyn Fn(&str) + Sync),
) -> Result<Vec<Line>, Error> {
    let base = Plan::new(plan::scene(source, flags, variant)?, None, None, false)?;
    let flags = Flags { cell: Some(plan::COARSER * base.scene.cell), ..flags.clone() };
    let coarse = plan::scene(source, &flags, variant)?;
    let (until, word) = (base.seconds(base.ends_h()), base.scene_word());
    let surrogate = Surrogate::of(&coarse, until, jobs)?;
    tell("the table of factors of safety is complete");
    let mut random = Random(1);
    let mut lines: Vec<Line> = (0..samples).map(|k| Line::sampled(&coarse, k, &mut random, &word)).collect();
    let (whole, mut done) = (WHOLE.min(samples), 0);
    let run = |_: usize, line: &Line| {
        let scene = coarse.edited(|fields| line.edit(fields))?;
        let plan = Plan::new(scene, None, None, false)?;
        follow_quietly(&plan, &mut |driver| driver.events.raveling_h.is_some())
    };
    let told = |number: usize, _: &Result<_, Error>| {
        done += 1;
        tell(&format!("{done}/{whole} whole runs, sample {number}"));
    };
    let found = pool::each(jobs, &lines[..whole], run, told);
    for (line, run) in lines.iter_mut().zip(found) {
        match run.and_then(|run| run) {
            Ok(run) => {
                line.run_fails_h = run.events.raveling_h;
                line.run = run.ended.trouble().unwrap_or_default().to_owned();
            }
            Err(why) => line.run = why.to_string(),
        }
    }
    for line in &mut lines[..whole] {
        let speed = line.speed(&coarse);
        line.run_factor = line.run_fails_h.map(|h| surrogate.factor(line, speed * base.seconds(h)));
    }
    let critical = critical(&lines).ok_or(Unfit("no whole run of a sample fails: there is no critical factor"))?;
    for line in &mut lines {
        let speed = line.speed(&coarse);
        let hours = |factor: f64| surrogate.fails(line, (factor, speed), until).map(|s| base.starts_h() + s / 3600.0);
        let [low, high] = critical.range;
        let all = [hours(critical.median), hours(low), hours(high)];
        [line.fails_h, line.late_h, line.early_h] = all;
    }
    Ok(lines)
}

/// The factor of safety at which whole runs fail.
fn critical(lines: &[Line]) -> Option<Spread> {
    Spread::of(lines.iter().filter_map(|line| line.run_factor))
}

/// The share of samples that have failed by a time (h), by a time of each.
fn share(lines: &[Line], time: f64, of: fn(&Line) -> Option<f64>) -> f64 {
    lines.iter().filter(|line| of(line).is_some_and(|h| h <= time)).count() as f64 / lines.len().max(1) as f64
}

/// When so large a share of all samples has failed, h.
pub fn quantile(lines: &[Line], share: f64) -> Option<f64> {
    let mut times: Vec<f64> = lines.iter().filter_map(|line| line.fails_h).collect();
    times.sort_by(f64::total_cmp);
    times.get((share * lines.len() as f64) as usize).copied()
}

/// Draws the probability over time.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn picture(lines: &[Line], events: &[Event], folder: &std::path::Path) -> Result<Picture, ReportError> {
    let mut times: Vec<f64> = lines.iter().flat_map(|l| [l.fails_h, l.late_h, l.early_h]).flatten().collect();
    times.sort_by(f64::total_cmp);
    let (first, last) = (times.first().copied().unwrap_or(0.0), times.last().copied().unwrap_or(1.0));
    const PARTS: usize = 120;
    let at = |k: usize| first + (last - first) * k as f64 / PARTS as f64;
    let curve = |of: fn(&Line) -> Option<f64>| (0..=PARTS).map(|k| (at(k), share(lines, at(k), of))).collect();
    let whole = lines.iter().filter(|line| line.run != "-").count();
    let mut runs: Vec<f64> = lines.iter().filter_map(|line| line.run_fails_h).collect();
    runs.sort_by(f64::total_cmp);
    let runs = runs.iter().enumerate().map(|(k, h)| (*h, (k as f64 + 0.5) / whole as f64)).collect();
    let curve = Curve {
        middle: curve(|l| l.fails_h),
        low: curve(|l| l.late_h),
        high: curve(|l| l.early_h),
        runs,
        samples: lines.len(),
    };
    let svg = plot::write(&curve, events, folder)?;
    Ok(Picture::new(plot::figure(&curve, events), &svg))
}

/// A table for the page.
pub fn shown(lines: &[Line], scales: &Scales) -> Table {
    let (from, to) = (quantile(lines, 0.01), quantile(lines, 0.98));
    let (from, to) = (from.unwrap_or(0.0), to.or_else(|| quantile(lines, 0.5)).unwrap_or(0.0));
    // Whole quarters of an hour, or what the time of the water makes of them.
    let step = ((to - from) / ROWS as f64).max(1e-3 * scales.crossing / 3600.0);
    let step = if step > 0.25 { (4.0 * step).ceil() / 4.0 } else { step };
    let first = (from / step).floor() * step;
    let row = |k: usize| {
        let time = first + step * k as f64;
        let percent = |of: fn(&Line) -> Option<f64>| format!("{:.0}", 100.0 * share(lines, time, of));
        let [low, high] = [percent(|l| l.late_h), percent(|l| l.early_h)];
        vec![Cell::new(short(time, 4)), Cell::new(percent(|l| l.fails_h)), Cell::new(format!("{low} to {high}"))]
    };
    let whole: Vec<&Line> = lines.iter().filter(|line| line.run != "-").collect();
    let failed = whole.iter().filter(|line| line.run_fails_h.is_some()).count();
    let alike = whole.iter().filter(|line| line.run_fails_h.is_some() == line.fails_h.is_some()).count();
    let off = Spread::of(whole.iter().filter_map(|l| Some((l.run_fails_h? - l.fails_h?).abs())));
    let off = off.map_or_else(String::new, |off| {
        format!(
            " Their times differ from those of the table by {} h (median), {} h (nine of ten).",
            short(off.median, 2),
            short(off.range[1], 2)
        )
    });
    let critical = critical(lines).map_or_else(String::new, |c| {
        let [low, high] = c.range.map(|f| short(f, 3));
        format!(
            " They fail at a factor of {} (four of five: {low} to {high}), with Davis' strength by Spencer's method.",
            short(c.median, 3)
        )
    });
    let note = format!(
        "{} samples: cohesion log-normal with a coefficient of variation of {} %, tan(φ) normal with {} %, conductivity log-normal with {} %, \
         saturation at the start uniform, up to {} from that of the scene. All of that is assumed. A sample fails (E1) when its factor of \
         safety has fallen to the critical one. {} were run whole, on cells of twice the size: {failed} failed, {alike} as the table \
         says.{critical}{off}",
        lines.len(),
        short(100.0 * PRIORS.cohesion, 2),
        short(100.0 * PRIORS.friction, 2),
        short(100.0 * PRIORS.conductivity, 2),
        PRIORS.saturation,
        whole.len(),
    );
    let head = ["time (h)", "has failed (%)", "with the critical factor of four of five runs (%)"];
    table("Probability of failure".to_owned(), &head, (0..=ROWS + 1).map(row).collect(), &note)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(count: usize) -> (Scene, Vec<Line>) {
        let scene = plan::scene("levee", &Flags::default(), None).expect("the levee");
        let mut random = Random(1);
        let lines = (0..count).map(|k| Line::sampled(&scene, k, &mut random, "")).collect();
        (scene, lines)
    }

    #[test]
    fn samples_have_the_means_and_variations_of_the_priors() {
        let (scene, lines) = samples(20_000);
        let count = lines.len() as f64;
        let check = |of: &dyn Fn(&Line) -> f64, mean: f64, cov: f64| {
            let own = lines.iter().map(of).sum::<f64>() / count;
            let spread = (lines.iter().map(|l| (of(l) - own).powi(2)).sum::<f64>() / count).sqrt() / own;
            assert!((own / mean - 1.0).abs() < 4.0 * cov / count.sqrt(), "{own} {mean}");
            assert!((spread / cov - 1.0).abs() < 0.03, "{spread} {cov}");
        };
        let strength = scene.strength.expect("a strength");
        check(&|l| l.cohesion_pa, strength.cohesion, PRIORS.cohesion);
        check(&|l| l.friction_deg.to_radians().tan(), strength.friction_angle.to_radians().tan(), PRIORS.friction);
        check(&|l| l.conductivity_m_s, 4.5e-5, PRIORS.conductivity);
        assert!(lines.iter().all(|l| (0.3..0.7).contains(&l.saturation)));
    }

    /// `F_full = sqrt(F^2 + tan^2 phi)` where psi = 0; water twice as fast fails in half the time.
    #[test]
    fn the_table_scales_with_strength_and_time() {
        let (scene, lines) = samples(1);
        let strength = scene.strength.expect("a strength");
        let row = |time: f64| RATIOS.map(|ratio| 0.8 + 0.5 * ratio.ln() / 4f64.ln() - 1e-5 * time + 0.5);
        let times = vec![1e3, 1e4, 1e5];
        let surrogate = Surrogate { factors: times.iter().map(|t| row(*t)).collect(), times, strength };
        let same = Line { cohesion_pa: strength.cohesion, friction_deg: strength.friction_angle, ..lines[0].clone() };
        let tangent = strength.friction_angle.to_radians().tan();
        let davis = surrogate.factor(&same, 1e4);
        assert!((davis.hypot(tangent) - 1.2).abs() < 1e-9, "{davis}");
        let fails = |speed: f64| surrogate.fails(&same, (0.8, speed), 1e5).expect("a time");
        assert!((fails(2.0) - 0.5 * fails(1.0)).abs() < 1e-6 * fails(1.0));
        assert_eq!(surrogate.fails(&same, (0.0, 1.0), 1e4), None);
        // Stronger soil has a larger factor, by as much as it is stronger.
        let stronger =
            Line { cohesion_pa: 2.0 * strength.cohesion, friction_deg: (2.0 * tangent).atan().to_degrees(), ..same };
        let davis = surrogate.factor(&stronger, 1e4);
        assert!((davis.hypot(2.0 * tangent) - 2.4).abs() < 1e-9, "{davis}");
    }
}

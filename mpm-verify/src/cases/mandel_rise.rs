//! Mandel's problem: how far, and when, the pressure rises above its undrained value beside the middle of the block.
//!
//! The undrained pressure p_0 is the value at t = 0+. As the sides drain they soften, load moves to the middle, and
//! there the pressure goes on to rise: to 1.076 p_0 at T = 0.063 in this block. No theory that leaves the total stress
//! alone shows it. Times between the sample times are those of the parabola through the three highest.

use mpm_core::drive::{Run, Sample};
use mpm_core::scene::{Fields, Scene, Until};

use super::mandel_inertia::{Block, IMPLICIT_PRESSURE, PAPER, Way};
use super::{Error, Mutant, Outcome, Program, Unfit, asked, finished, integrator, scheme, sound};
use crate::exact::mandel::Mandel;
use crate::experiment::comparison::{Compared, Comparison};
use crate::experiment::refinement::{MESH, Refinement, Sampled, TOLERANCE};

/// B-splines without inertia.
pub const SPLINES: Program = Program {
    name: "mandel-rise",
    about: "Mandel's problem, B-splines: the rise of p in the middle above p_0, size and time of its peak",
    run: || quasi_static(sound),
    mutant: Some(Mutant { what: NEARLY_UNDRAINED, run: || quasi_static(leaky) }),
};

/// Implicit pressure.
pub const SEMI_IMPLICIT: Program = Program {
    name: "mandel-rise-semi-implicit",
    about: "the same rise with inertia, implicit pressure",
    run: || with_inertia(&IMPLICIT_PRESSURE, 5e-3, sound),
    mutant: Some(Mutant { what: NEARLY_UNDRAINED, run: || with_inertia(&IMPLICIT_PRESSURE, 5e-3, leaky) }),
};

/// The paper's step.
pub const EXPLICIT: Program = Program {
    name: "mandel-rise-explicit",
    about: "the same rise with the paper's explicit step",
    run: || with_inertia(&PAPER, 1e-2, sound),
    mutant: Some(Mutant { what: NEARLY_UNDRAINED, run: || with_inertia(&PAPER, 1e-2, leaky) }),
};

const NEARLY_UNDRAINED: &str = "Poisson's ratio 0.31 in place of 0.30";

/// Between the drained ratio and the undrained one, 0.4995, there is less to redistribute: the rise is smaller.
fn leaky(scene: &mut Fields) {
    scene.elastic.poisson_ratio += 0.01;
}

/// First and last time of the looks, T = c t/a^2, and how many there are.
const WINDOW: [f64; 2] = [0.03, 0.12];
const LOOKS: u32 = 36;
/// Times between which the exact peak is looked for.
const BRACKET: [f64; 2] = [0.02, 0.3];

fn times() -> Vec<f64> {
    let [first, last] = WINDOW;
    (0..=LOOKS).map(|i| first + (last - first) * f64::from(i) / f64::from(LOOKS)).collect()
}

/// The peak of a curve over time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Peak {
    /// p/p_0 there.
    size: f64,
    /// T = c t/a^2 of it.
    factor: f64,
}

/// The vertex of the parabola through the highest of equally spaced points and its neighbours; `None` if that is an
/// end.
fn vertex(points: &[[f64; 2]]) -> Option<Peak> {
    let top = (0..points.len()).max_by(|a, b| points[*a][1].total_cmp(&points[*b][1]))?;
    let [before, at, after] = [points.get(top.checked_sub(1)?)?, points.get(top)?, points.get(top + 1)?];
    let (spacing, bend) = (at[0] - before[0], before[1] - 2.0 * at[1] + after[1]);
    let aside = 0.5 * (before[1] - after[1]) / bend;
    Some(Peak { size: at[1] - 0.25 * (before[1] - after[1]) * aside, factor: at[0] + aside * spacing })
}

/// The exact peak at a distance x from the middle (m), by golden section: the pressure there rises once.
fn exact_peak(exact: &Mandel, x: f64) -> Peak {
    let one = 1.0 / exact.time_factor(1.0);
    let at = |factor: f64| exact.pressure(x, factor * one) / exact.undrained;
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let [mut low, mut high] = BRACKET;
    while high - low > 1e-9 {
        let [left, right] = [high - golden * (high - low), low + golden * (high - low)];
        if at(left) > at(right) { high = right } else { low = left }
    }
    Peak { size: at(low), factor: low }
}

/// What is found in a run: its peak, the exact one at the same place, and the looks.
struct Rise {
    computed: Peak,
    exact: Peak,
    /// Time of the exact peak since the start of the stage, s.
    exact_time: f64,
    history: Comparison,
}

impl Rise {
    /// In a run that begins at a time `start` (s) of the exact solution.
    fn of(run: &Run, exact: &Mandel, start: f64) -> Option<Self> {
        let beside = |s: &Sample| {
            let far = |i: &usize| s.state.field[*i].x_m + s.state.field[*i].y_m;
            let point = (0..s.state.field.len()).min_by(|a, b| far(a).total_cmp(&far(b)))?;
            let (point, time) = (&s.state.field[point], s.stage_time + start);
            let factor = Some(exact.time_factor(time));
            let [computed, exact] = [point.pressure_pa, exact.pressure(point.x_m, time)].map(|p| p / exact.undrained);
            Some((point.x_m, Compared { factor, ..Compared::one(s.stage_time, computed, exact) }))
        };
        let (places, rows): (Vec<f64>, Vec<Compared>) = run.observed().filter_map(beside).unzip();
        let points: Vec<[f64; 2]> = rows.iter().filter_map(|look| Some([look.factor?, look.computed[0]])).collect();
        let place = places.first().copied()?;
        let history = Comparison::worst(format!("p/p_0 at x = {place:.4} m"), rows);
        let peak = exact_peak(exact, place);
        let exact_time = peak.factor / exact.time_factor(1.0) - start;
        Some(Self { computed: vertex(&points)?, exact: peak, exact_time, history })
    }

    /// Error of the size, as a share of the exact rise.
    fn size(&self) -> f64 {
        (self.computed.size - self.exact.size) / (self.exact.size - 1.0)
    }

    /// Error of the time, as a share of the exact one.
    fn time(&self) -> f64 {
        self.computed.factor / self.exact.factor - 1.0
    }

    /// The curve, and the peak as two samples of it.
    fn samples(&self) -> Vec<Sampled> {
        let mut samples = self.history.samples();
        samples.iter_mut().for_each(|sample| sample.counts = false);
        let peak = |quantity: &str, computed: f64, exact: f64, error: f64| Sampled {
            quantity: quantity.to_owned(),
            unit: "-".to_owned(),
            time: self.exact_time,
            factor: Some(self.exact.factor),
            computed,
            exact,
            error,
            counts: true,
        };
        samples.push(peak("peak of p/p_0, error over its rise", self.computed.size, self.exact.size, self.size()));
        samples.push(peak("T of the peak, relative error", self.computed.factor, self.exact.factor, self.time()));
        samples
    }
}

/// What both kinds of run have in common: size and time of the peak on meshes, and its refinements.
fn judged(
    scenes: &[Scene],
    rise: impl Fn(&Scene) -> Result<Rise, Error>,
    required: [f64; 2],
    order: f64,
) -> Result<Outcome, Error> {
    let (mut errors, mut times, mut samples) = (Vec::new(), Vec::new(), Vec::new());
    for scene in scenes {
        let found = rise(scene)?;
        errors.push((scene.cell, found.size()));
        times.push((scene.cell, found.time()));
        samples = found.samples();
    }
    let [required_error, of_time] = required;
    let when = Refinement::new(MESH, times, "the exact time of the peak");
    Ok(Outcome {
        integrator: integrator(&scenes[0]),
        scheme: scheme(&scenes[0]),
        tolerance: asked(&scenes[0]),
        errors,
        required_error,
        required_order: Some(order),
        samples,
        refinements: vec![Refinement { required_finest: Some(of_time), required_order: Some(order), ..when }],
        scene: scenes.first().cloned(),
        ..Outcome::default()
    })
}

/// No peak among the looks: the fault of a run, not of the check.
fn missing() -> Error {
    Error::Found(format!("the pressure in the middle has no peak from T = {} to {}", WINDOW[0], WINDOW[1]))
}

/// The scene, all but exact in time.
fn without_inertia() -> Result<(Scene, Mandel), Error> {
    let base = crate::scenes::built_in("mandel")?.edited(|base| (base.history, base.tolerance) = (0, 1e-7))?;
    let exact = Mandel::new(&base).ok_or(Unfit("not Mandel's problem"))?;
    Ok((base, exact))
}

fn quasi_static(fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let (mut base, exact) = without_inertia()?;
    let one = 1.0 / exact.time_factor(1.0);
    base = base.edited(|base| {
        base.observe_times = times().iter().map(|t| t * one).collect();
        base.stages[0].until = Until::Time(WINDOW[1] * one);
    })?;
    base = base.edited(fault)?;
    let rise = |scene: &Scene| Rise::of(&finished(scene)?, &exact, 0.0).ok_or_else(missing);
    let scenes = [8, 12, 16, 20].into_iter().map(|side| base.with_rows(side)).collect::<Result<Vec<_>, _>>()?;
    let outcome = judged(&scenes, rise, [1e-4, 2e-4], 4.0)?;
    let under = |tolerance: f64| rise(&base.with_rows(8)?.edited(|s| s.tolerance = tolerance)?);
    let finest = under(1e-9)?;
    let error = |tolerance: f64| Ok((tolerance, under(tolerance)?.history.difference(&finest.history)));
    let errors = [1e-3, 1e-4, 1e-5, 1e-6].into_iter().map(error).collect::<Result<_, Error>>()?;
    let against = "the curve of p/p_0 under a tolerance of 1e-9, L = 0.125 m";
    let tolerance = Refinement { required_share: Some(1.0), ..Refinement::new(TOLERANCE, errors, against) };
    Ok(Outcome { refinements: [outcome.refinements, vec![tolerance]].concat(), ..outcome })
}

fn with_inertia(way: &Way, required_error: f64, fault: fn(&mut Fields)) -> Result<Outcome, Error> {
    let mut block = Block::new(way, &times())?;
    block.scene = block.scene.edited(fault)?;
    let rise = |scene: &Scene| Rise::of(&block.run(scene)?, &block.exact, block.start).ok_or_else(missing);
    let scenes = way.sides.into_iter().map(|side| block.scene.with_rows(side)).collect::<Result<Vec<_>, _>>()?;
    // Steps that fall with L add to the time of the peak what the mesh takes from it: its order is above 2.
    let outcome = judged(&scenes, rise, [required_error; 2], 2.0)?;
    let curve = |run: &Run, block: &Block| Ok(Rise::of(run, &block.exact, block.start).ok_or_else(missing)?.history);
    let steps = way.in_time(&times(), fault, curve)?;
    Ok(Outcome { refinements: [outcome.refinements, vec![steps]].concat(), ..outcome })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::faster;
    use crate::experiment::verdict::judge;

    #[test]
    fn peaks_are_found_between_the_looks() {
        let curve = |t: f64| 1.07 - 15.0 * (t - 0.0643).powi(2);
        let points: Vec<[f64; 2]> = times().iter().map(|t| [*t, curve(*t)]).collect();
        let peak = vertex(&points).expect("a peak");
        assert!((peak.factor - 0.0643).abs() < 1e-12 && (peak.size - 1.07).abs() < 1e-12, "{peak:?}");
        assert_eq!(vertex(&points[..4]), None, "a curve that still rises has none");
        let (_, exact) = without_inertia().expect("a block");
        let peak = exact_peak(&exact, 0.0);
        // Of the table, whose rows are a tenth apart: 1.0759 at T = 0.0678.
        assert!((0.06..0.068).contains(&peak.factor) && (1.0759..1.077).contains(&peak.size), "{peak:?}");
    }

    #[test]
    fn a_peak_at_the_wrong_time_is_found_by_its_time_alone() {
        let judged = judge(SPLINES.named(), quasi_static(faster).expect("runs that finish"), 0.0);
        assert!(judged.row.error < judged.row.required_error, "the size of the peak does not depend on k");
        assert!(!judged.row.passed() && judged.reason.contains("refined by mesh L"), "{}", judged.reason);
    }
}

//! The page of a scene that was solved: its history, profiles, balances and maps, with the exact solution where it has one.

use std::path::Path;

use mpm_core::drive::{Run, Sample};
use mpm_core::observe::{ProfileRow, balances};
use mpm_core::scene::{Dimension, Scene};

use super::content::table::{Cell, Table, table};
use super::numbers::{brief, short};
use super::plots::axis::Axis;
use super::plots::figure::{Figure, Mark, Panel, Point, Series};
use super::plots::look::{self, Dash, GREY, Look, Marker, RED};
use super::plots::{self, field};
use super::{ReportError, maps};
use crate::exact::layered::Layered;
use crate::exact::terzaghi::Terzaghi;
use crate::manifest::Manifest;
use crate::page::site::{Kind, Report};
use crate::page::verdict::{State, Verdict};
use crate::page::{Page, Section};

/// Profiles shown at most.
const PROFILES: usize = 6;
/// Fewer samples than these are marked one by one.
const FEW: usize = 40;
/// Points of an exact curve.
const FINE: u32 = 120;

/// A number at a time since the start of the last stage (s), and at a height above the base (m) and that time.
type InTime = Box<dyn Fn(f64) -> f64>;
type AtHeight = Box<dyn Fn(f64, f64) -> f64>;

/// The exact solution of a scene.
pub struct Exact {
    /// Whose it is.
    pub name: &'static str,
    /// Settlement, m.
    pub settlement: InTime,
    /// Pore pressure, Pa, if that is known too.
    pub pressure: Option<AtHeight>,
}

impl Exact {
    /// That of consolidation, where the scene is one.
    pub fn of(scene: &Scene) -> Option<Self> {
        let drained = scene.stages.last().is_some_and(|stage| stage.drained.contains(&true));
        if !drained || scene.gravity.is_some() {
            return None;
        }
        if let Some(exact) = Terzaghi::compressible(scene).filter(|_| scene.is_elastic()) {
            let (settlement, pressure) = (move |t| exact.settlement(t), move |y, t| exact.pressure(y, t));
            return Some(Self {
                name: "Terzaghi",
                settlement: Box::new(settlement),
                pressure: Some(Box::new(pressure)),
            });
        }
        if let Some((exact, factors)) = Terzaghi::under_one_load(scene).filter(|_| scene.is_elastic()) {
            let settlement = Box::new(move |t| exact.under(&factors, t));
            return Some(Self { name: "Terzaghi, superposed", settlement, pressure: None });
        }
        let exact = Layered::of(scene).filter(|_| !scene.layers.is_empty())?;
        let other = exact.clone();
        Some(Self {
            name: "eigenfunctions of the layers",
            settlement: Box::new(move |t| exact.settlement(t)),
            pressure: Some(Box::new(move |y, t| other.pressure(y, t))),
        })
    }
}

/// Files of numbers that the page links to where they are there.
const FILES: [&str; 5] = ["summary.json", "history.csv", "profiles.csv", "field.csv", "water.csv"];

/// Writes the pictures of a run and `index.html`.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(
    (scene, run): (&Scene, &Run),
    (manifest, cpu_s): (&Manifest, f64),
    folder: &Path,
) -> Result<(), ReportError> {
    let exact = Exact::of(scene);
    let mut figures = vec![history(scene, run, exact.as_ref())];
    figures.extend(profiles(scene, run, exact.as_ref()));
    figures.extend(ledgers(scene, run));
    figures.iter().try_for_each(|figure| plots::write(figure, folder).map(drop))?;
    // What is seen of the soil comes first.
    for (place, map) in maps::all(scene, run).iter().enumerate() {
        field::write(map, folder)?;
        figures.insert(place, field::figure(map));
    }
    let pictures = Section::new("pictures", "Pictures");
    let pictures = figures.iter().fold(pictures, |s, figure| s.figure_in(figure, ".", &["csv", "png", "svg"]));
    let files = FILES.into_iter().filter(|file| folder.join(file).exists() || *file == "summary.json");
    let main = figures.first().map_or("", |figure| figure.name);
    let alt = figures.first().map_or("", |figure| &figure.title);
    Page::new(scene.name.clone())
        .verdict(verdict(run))
        .lead(summary(scene, run, cpu_s))
        .warnings(run.failure.iter().map(ToString::to_string))
        .section(pictures)
        .section(Section::new("numbers", "Numbers").tables([numbers(scene, run, exact.as_ref())]).files(files))
        .conditions(manifest)
        .report(Report::new(Kind::Scene).picture(format!("{main}.png"), alt))
        .write(&folder.join("index.html"))
}

/// Whether the run ended as it should, and how near its balances came to their bounds.
fn verdict(run: &Run) -> Verdict {
    let Some(trust) = run.trust.filter(|_| run.failure.is_none()) else {
        return match run.failure {
            Some(_) => Verdict::new(State::Stopped, "The run stopped before its end."),
            None => Verdict::new(State::Complete, "The run is complete; it has no balances to check."),
        };
    };
    let (gap, allowed) = (short(trust.gap, 2), short(trust.allowed, 2));
    let (name, unit) = (trust.balance, trust.unit);
    let passed = trust.since_s.is_none();
    let how = if passed { "is within its bound" } else { "exceeds its bound" };
    let sentence =
        format!("The run is complete. The residual of the {name} balance, {gap} {unit}, {how} of {allowed} {unit}.");
    // A balance that closes is no proof of the result.
    Verdict::new(if passed { State::Complete } else { State::Failed }, sentence)
}

fn summary(scene: &Scene, run: &Run, cpu_s: f64) -> String {
    let place = match scene.dimension {
        Dimension::Column => "column",
        Dimension::PlaneStrain => "plane strain",
        Dimension::Axisymmetric => "axisymmetric (amounts of one radian)",
    };
    format!(
        "{} particles of soil in cells of {} m, {place}, {}: {} steps in {} s of CPU.",
        run.solid_particles,
        brief(scene.cell, 4),
        crate::study::word(scene.integrator),
        run.steps,
        short(cpu_s, 3)
    )
}

/// The unit in which a run is best read, as a label and a column, and how many seconds it has.
fn unit(run: &Run) -> (&'static str, &'static str, f64) {
    const UNITS: [(&str, &str, f64); 3] =
        [("time (years)", "time_a", 31_557_600.0), ("time (days)", "time_d", 86_400.0), ("time (h)", "time_h", 3600.0)];
    let end = run.samples.last().map_or(0.0, |s| s.state.time);
    UNITS.into_iter().find(|(.., seconds)| end > 3.0 * seconds).unwrap_or(("time (s)", "time_s", 1.0))
}

/// Settlement, pore pressures, and the forces of plates over time.
fn history(scene: &Scene, run: &Run, exact: Option<&Exact>) -> Figure {
    let (label, column, seconds) = unit(run);
    let time = || Axis::linear(label, column);
    let mark = if run.samples.len() < FEW { Mark::LinePoints } else { Mark::Line };
    let line = |label: &str, look: Look, of: &dyn Fn(&Sample) -> f64| {
        let points = run.samples.iter().map(|s| Point::new(s.state.time / seconds, of(s)));
        Series::new(label, look.radius(2.6), mark, points)
    };
    let mut settlement = Panel::new("", time(), Axis::linear("settlement of the top (mm)", "settlement_mm"))
        .with(line("computed", look::nth(0), &|s| 1e3 * s.state.settlement));
    let last = run.samples.last();
    if let (Some(exact), Some(last)) = (exact, last) {
        let (start, long) = (last.state.time - last.stage_time, last.stage_time);
        let points = (1..=FINE).map(|i| f64::from(i) / f64::from(FINE) * long);
        let points = points.map(|t| ((start + t) / seconds, 1e3 * (exact.settlement)(t)));
        settlement.add(Series::line(exact.name, Look::new(RED, Marker::Dot).dash(Dash::Dashed), points));
    }
    let mut panels = vec![settlement];
    if scene.water.is_some() {
        let pressure = Panel::new("", time(), Axis::linear("pore pressure (kPa)", "pore_pressure_kpa"))
            .with(line("lowest row of cells", look::nth(2), &|s| s.state.base_pressure / 1e3))
            .with(line("mean", look::nth(3).dash(Dash::Dashed), &|s| s.state.mean_pressure / 1e3));
        panels.push(pressure);
    }
    if !scene.plates.is_empty() {
        let force = |axis: usize| {
            let of = move |pair: &[Sample]| {
                let sum = |s: &Sample| s.state.plates.iter().map(|push| push.impulse[axis]).sum::<f64>();
                let (before, now) = (&pair[0], &pair[1]);
                let time = now.state.time - before.state.time;
                (time > 0.0).then(|| (now.state.time / seconds, (sum(now) - sum(before)) / time / 1e3))
            };
            run.samples.windows(2).filter_map(of)
        };
        let plates = Panel::new("", time(), Axis::linear("force of plates (kN/m)", "force_kn_m"))
            .with(Series::line("along x", look::nth(4), force(0)))
            .with(Series::line("along y", look::nth(5).dash(Dash::Dashed), force(1)));
        panels.push(plates);
    }
    Figure {
        name: "plot-history",
        title: format!("{}: over time", scene.name),
        caption: "Settlement is that of the top on average, from the unloaded state.".to_owned(),
        height: 250.0,
        panels,
        missing: Vec::new(),
    }
}

/// Pore pressure and vertical effective stress over the height at observed times.
fn profiles(scene: &Scene, run: &Run, exact: Option<&Exact>) -> Option<Figure> {
    let all: Vec<&Sample> = run.samples.iter().filter(|s| s.observed && !s.state.profile.is_empty()).collect();
    let every = all.len().div_ceil(PROFILES).max(1);
    // The last one always; of the others some.
    let mut some: Vec<&Sample> = all.iter().rev().step_by(every).copied().collect();
    some.reverse();
    let height = || Axis::linear("height (m)", "height_m");
    let rows = |label: String, nth: usize, s: &Sample, of: &dyn Fn(&ProfileRow) -> f64| {
        let points = s.state.profile.iter().map(|row| Point::new(of(row) / 1e3, row.height_m).open(true));
        Series::new(label, look::nth(nth).radius(2.6).width(1.2), Mark::Points, points)
    };
    let mut pressure = Panel::new("", Axis::linear("pore pressure (kPa)", "pore_pressure_kpa"), height());
    let mut stress = Panel::new("", Axis::linear("vertical effective stress (kPa)", "effective_stress_kpa"), height());
    let stage = run.samples.last().map_or(0, |s| s.stage);
    let (label, _, seconds) = unit(run);
    let words = label.trim_start_matches("time (").trim_end_matches(')');
    for (nth, s) in some.iter().enumerate() {
        let label = format!("t = {} {}", brief(s.state.time / seconds, 3), words);
        let known = exact.filter(|_| s.stage == stage && s.stage_time > 0.0);
        if let Some((exact, pressure_at)) = known.and_then(|exact| Some((exact, exact.pressure.as_ref()?))) {
            let at = |i: u32| f64::from(i) / f64::from(FINE) * scene.height;
            let points = (0..=FINE).map(|i| (pressure_at(at(i), s.stage_time) / 1e3, at(i)));
            let look = look::nth(nth).dash(Dash::Solid).width(1.2);
            pressure.add(Series::line(format!("{}, {label}", exact.name), look, points).unlisted());
        }
        if scene.water.is_some() {
            pressure.add(rows(label.clone(), nth, s, &|row| row.pressure_pa));
        }
        stress.add(rows(label, nth, s, &|row| row.effective_stress_pa));
    }
    let mut panels: Vec<Panel> = [pressure, stress].into_iter().filter(|panel| !panel.is_empty()).collect();
    plots::figure::share_y(&mut panels);
    let mut caption = "Markers: means of the rows of cells; compression negative.".to_owned();
    if let Some(exact) = exact.filter(|exact| exact.pressure.is_some()) {
        caption.push_str(&format!(" Lines of the same colour: {}.", exact.name));
    }
    (!panels.is_empty()).then(|| Figure {
        name: "plot-profiles",
        title: format!("{}: over the height", scene.name),
        caption,
        height: 330.0,
        panels,
        missing: Vec::new(),
    })
}

/// What every balance misses over what may be missing.
fn ledgers(scene: &Scene, run: &Run) -> Option<Figure> {
    run.trust?;
    let mut names: Vec<&'static str> = Vec::new();
    let (label, column, seconds) = unit(run);
    let mut panel = Panel::new(
        "",
        Axis::linear(label, column),
        Axis::log("missing, of what may be", "share_of_bound").range(1e-9, 10.0),
    );
    let all: Vec<(f64, Vec<_>)> = run
        .samples
        .iter()
        .filter(|s| s.state.time > 0.0)
        .map(|s| (s.state.time / seconds, balances(scene, run.dt, s.step, &s.state, &s.balance)))
        .collect();
    for balance in all.iter().flat_map(|(_, balances)| balances) {
        if !names.contains(&balance.name) {
            names.push(balance.name);
        }
    }
    for (nth, name) in names.iter().enumerate() {
        let of = |(time, balances): &(f64, Vec<mpm_core::observe::Balance>)| {
            let balance = balances.iter().find(|balance| balance.name == *name)?;
            let share = (balance.gap / balance.allowed).abs();
            Some((*time, if balance.gap == 0.0 { 1e-9 } else { share.clamp(1e-9, 10.0) }))
        };
        panel.add(Series::line(*name, look::nth(nth), all.iter().filter_map(of)));
    }
    let ends = all.first().zip(all.last()).map(|(first, last)| [first.0, last.0])?;
    let bound = Look::new(GREY, Marker::Dot).dash(Dash::Dashed).width(1.2);
    panel.add(Series::line("bound", bound, ends.map(|time| (time, 1.0))).guide());
    Some(Figure {
        name: "plot-balances",
        title: format!("{}: what the balances miss", scene.name),
        caption: "Beyond the dashed line a balance does not close, and the run says so.".to_owned(),
        height: 220.0,
        panels: vec![panel],
        missing: Vec::new(),
    })
}

/// The state at the observed times.
fn numbers(scene: &Scene, run: &Run, exact: Option<&Exact>) -> Table {
    let wet = scene.water.is_some();
    let mut head = vec!["t (s)", "settlement (m)"];
    head.extend(exact.map(|_| "error of it"));
    head.extend(if wet { &["mean pore pressure (Pa)", "at the base (Pa)"][..] } else { &[] });
    head.push("largest speed (m/s)");
    let stage = run.samples.last().map_or(0, |s| s.stage);
    let row = |s: &Sample| {
        let state = &s.state;
        let mut row = vec![short(state.time, 4), short(state.settlement, 5)];
        if let Some(exact) = exact {
            let off = state.settlement / (exact.settlement)(s.stage_time) - 1.0;
            row.push(if s.stage == stage { short(off, 2) } else { "–".to_owned() });
        }
        if wet {
            row.extend([short(state.mean_pressure, 5), short(state.base_pressure, 5)]);
        }
        row.push(short(state.max_speed, 3));
        row.into_iter().map(Cell::new).collect()
    };
    let observed = run.samples.iter().filter(|s| s.observed).map(row).collect();
    table("Numbers at the observed times".to_owned(), &head, observed, "")
}

//! The page of a scene that was solved: what it is, its error against the exact solution that applies, figures by what kind of scene it is, maps,
//! profiles, balances.

use std::path::Path;

use mpm_core::drive::{Run, Sample};
use mpm_core::observe::{ProfileRow, balances};
use mpm_core::scene::{Course, Dimension, Integrator, Scene, Side};

use super::numbers::{brief, column, short};
use super::plots::axis::Axis;
use super::plots::figure::{Figure, Mark, Panel, Point, Series};
use super::plots::look::{self, Dash, GREY, Look, Marker, RED};
use super::plots::{self, field};
use super::{ReportError, capital, case, maps, save};
use crate::cases::own::applies::Solution;
use crate::cases::own::compared::{Found, plates, share};
use crate::manifest::Manifest;
use crate::page::site::{Kind, Report};
use crate::page::table::{Cell, Table};
use crate::page::verdict::{State, Verdict};
use crate::page::{Block, Page, Section, sketch};

/// Profiles shown at most.
const PROFILES: usize = 6;
/// Fewer samples than these are marked one by one.
const FEW: usize = 40;
/// Points of an exact curve.
const FINE: u32 = 120;
/// Smaller displacements are none, m.
const NOTHING: f64 = 1e-12;
/// The drawing of a scene for a gallery.
pub const THUMBNAIL: &str = "thumbnail.svg";

/// A scene that was solved.
#[derive(Debug, Clone, Copy)]
pub struct Solved<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Run of the scene.
    pub run: &'a Run,
    /// The exact solution that applies, and the run beside it.
    pub exact: Option<(&'a Solution, &'a Found)>,
    /// Description in the file of the scene.
    pub about: &'a str,
    /// File or name of the scene.
    pub source: &'a str,
    /// CPU time, s.
    pub cpu_s: f64,
}

/// Question that an engineer asks of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Subject {
    /// Load against displacement.
    Bearing,
    /// Discharge and level.
    Seepage,
    /// Settlement over the logarithm of time.
    Consolidation,
    /// Anything over time.
    Motion,
}

impl Subject {
    fn of(scene: &Scene) -> Self {
        let loaded_to_failure = scene.surcharge.is_some_and(|load| load.ramp_time > 0.0) && scene.strength.is_some();
        let drains = scene.stages.last().is_some_and(|stage| stage.drained.contains(&true));
        let stays = scene.loads.iter().all(|load| matches!(load.course, Course::Constant | Course::Ramp(_)));
        let slow = scene.integrator == Integrator::QuasiStatic || Solution::consolidates(scene);
        match () {
            () if scene.free_surface.is_some() => Self::Seepage,
            () if !scene.plates.is_empty() || loaded_to_failure => Self::Bearing,
            () if scene.water.is_some() && drains && stays && slow => Self::Consolidation,
            () => Self::Motion,
        }
    }
}

/// Files of numbers that the page links to where they are there.
const FILES: [&str; 5] = ["summary.json", "history.csv", "profiles.csv", "field.csv", "water.csv"];

/// Writes the pictures of a run, its thumbnail and `index.html`.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(solved: &Solved, manifest: &Manifest, folder: &Path) -> Result<(), ReportError> {
    let Solved { scene, run, exact, about, .. } = *solved;
    let drawn = |section: Section, figures: Vec<Figure>| -> Result<Section, ReportError> {
        figures.iter().try_for_each(|figure| plots::write(figure, folder).map(drop))?;
        Ok(figures.iter().fold(section, |section, figure| section.figure_in(figure, ".", crate::page::ALL_FILES)))
    };
    save(&folder.join(THUMBNAIL), sketch::thumbnail(scene, run))?;
    let mut maps_of = Section::new("maps", "Soil and water at the end");
    for map in maps::all(scene, run) {
        field::write(&map, folder)?;
        maps_of = maps_of.figure_in(&field::figure(&map), ".", crate::page::ALL_FILES);
    }
    let still = run.samples.iter().all(|s| s.state.settlement.abs() < NOTHING);
    let result = drawn(Section::new("result", "Result"), figures(solved))?;
    let result = if still { result.note("The top does not settle (less than 1e-12 m at all times).") } else { result };
    let profiles = drawn(Section::new("profiles", "Over the height"), profiles(solved).into_iter().collect())?;
    let balances = drawn(Section::new("balances", "Balances"), balance_residuals(scene, run).into_iter().collect())?;
    let files = FILES.into_iter().filter(|file| folder.join(file).exists() || *file == "summary.json");
    Page::new(title(&scene.name))
        .verdict(verdict(run, exact.map(|(_, found)| found)))
        .lead(about)
        .warnings(run.failure.iter().map(ToString::to_string))
        .style(case::STYLE)
        .section(case::scene_section(Section::new("scene", "Scene"), scene))
        .section(exact.map_or_else(Section::default, |(_, found)| against(found)))
        .section(result)
        .section(maps_of)
        .section(profiles)
        .section(balances)
        .section(Section::new("numbers", "Numbers").tables([numbers(solved)]).files(files))
        .section(again(solved))
        .conditions(manifest)
        .report(Report::new(Kind::Scene).picture(THUMBNAIL, format!("Soil and water of the scene {}", scene.name)))
        .write(&folder.join("index.html"))
}

/// The name of a scene as words: `levee-with-core` is `Levee with core`.
pub fn title(name: &str) -> String {
    capital(&name.replace('-', " "))
}

/// Whether the run ended as it should, how far it is from the exact solution, and how near its balances came to their tolerances.
fn verdict(run: &Run, exact: Option<&Found>) -> Verdict {
    let Some(trust) = run.trust.filter(|_| run.failure.is_none()) else {
        return match run.failure {
            Some(_) => Verdict::new(State::Stopped, "The run stopped before its end."),
            None => Verdict::new(State::Complete, "The run is complete; it has no balances to check."),
        };
    };
    let passed = trust.since_s.is_none();
    let (gap, allowed, name, unit) = (short(trust.gap, 2), short(trust.allowed, 2), trust.balance, trust.unit);
    let sentence = match (passed, exact) {
        (true, Some(found)) => format!("{}.", capital(&found.headline())),
        (true, None) => "The run is complete, and all balances are within their tolerances.".to_owned(),
        (false, _) => {
            format!("The residual of the {name} balance, {gap} {unit}, exceeds its tolerance of {allowed} {unit}.")
        }
    };
    // A balance that closes is no proof of the result.
    Verdict::new(if passed { State::Complete } else { State::Failed }, sentence)
}

/// The run beside the exact solution.
fn against(found: &Found) -> Section {
    let at_the_end = found.numbers.iter().map(|number| {
        let unit = if number.unit == "–" { String::new() } else { format!(" ({})", number.unit) };
        let name = format!("{} at the end{unit}", number.quantity);
        [name, short(number.computed, 4), short(number.exact, 4), share(number.error())].map(Cell::new).to_vec()
    });
    let largest = found.largest.iter().map(|largest| {
        let error = if largest.unit == "-" {
            share(largest.error)
        } else {
            format!("{} {}", short(largest.error, 2), largest.unit)
        };
        let name = Cell::new(capital(&largest.quantity)).small("largest error over the observed times");
        vec![name, Cell::new("–"), Cell::new("–"), Cell::new(error)]
    });
    let rows = at_the_end.chain(largest).collect();
    Section::new("exact", "Error against the exact solution")
        .text(format!("{}.", capital(&found.solution)))
        .tables([Table::new("", &["quantity", "computed", "exact", "error"], rows, "")])
        .list(found.beside.iter().map(|said| format!("{}.", capital(said))).collect())
}

/// Section with the command of the run, and its cost.
fn again(solved: &Solved) -> Section {
    let Solved { scene, run, source, cpu_s, .. } = *solved;
    let place = match scene.dimension {
        Dimension::Column => "column",
        Dimension::PlaneStrain => "plane strain",
        Dimension::Axisymmetric => "axisymmetric (amounts of one radian)",
    };
    Section::new("again", "Run it again").with(Block::Command(format!("mpm-verify solve {source}"))).note(format!(
        "{} particles of soil in cells of {} m, {place}, {}: {} steps in {} s of CPU time.",
        run.solid_particles,
        brief(scene.cell, 4),
        crate::study::word(scene.integrator),
        run.steps,
        short(cpu_s, 3)
    ))
}

/// The unit in which a run is best read, as a label and a column, and how many seconds it has.
fn unit(run: &Run) -> (&'static str, &'static str, f64) {
    const UNITS: [(&str, &str, f64); 3] =
        [("time (years)", "time_a", 31_557_600.0), ("time (days)", "time_d", 86_400.0), ("time (h)", "time_h", 3600.0)];
    let end = run.samples.last().map_or(0.0, |s| s.state.time);
    UNITS.into_iter().find(|(.., seconds)| end > 3.0 * seconds).unwrap_or(("time (s)", "time_s", 1.0))
}

/// The figures of a scene, by what is asked of it.
fn figures(solved: &Solved) -> Vec<Figure> {
    let own = match Subject::of(solved.scene) {
        Subject::Bearing => vec![bearing(solved)],
        Subject::Seepage => vec![seepage(solved)],
        Subject::Consolidation => vec![consolidation(solved), pressures(solved)],
        Subject::Motion => vec![motion(solved)],
    };
    own.into_iter().filter(|figure| !figure.panels.is_empty()).collect()
}

fn figure(name: &'static str, title: &str, caption: &str, panels: Vec<Panel>) -> Figure {
    let panels = panels.into_iter().filter(|panel| !panel.is_empty()).collect();
    let (title, caption) = (title.to_owned(), caption.to_owned());
    Figure { name, title, caption, height: 270.0, panels, missing: Vec::new() }
}

const EXACT: Look = Look::new(RED, Marker::Dot).dash(Dash::Dashed).width(1.8);

/// Values of a run over time, in the unit of time of the run.
fn over_time(run: &Run, label: &str, look: Look, of: &dyn Fn(&Sample) -> Option<f64>) -> Series {
    let (.., seconds) = unit(run);
    let mark = if run.samples.len() < FEW { Mark::LinePoints } else { Mark::Line };
    let points = run.samples.iter().filter_map(|s| Some(Point::new(s.state.time / seconds, of(s)?)));
    Series::new(label, look.radius(2.6), mark, points)
}

/// Exact values over time, at even times and at those of the samples of the last stage.
fn exact_over_time(solved: &Solved, of: &dyn Fn(&Solution, f64) -> Option<f64>) -> Option<Series> {
    let ((solution, _), last) = (solved.exact?, solved.run.samples.last()?);
    let ((.., seconds), start) = (unit(solved.run), last.state.time - last.stage_time);
    let even = (1..=FINE).map(|i| f64::from(i) / f64::from(FINE) * last.stage_time);
    let sampled =
        solved.run.samples.iter().filter(|s| s.stage == last.stage && s.stage_time > 0.0).map(|s| s.stage_time);
    let mut times: Vec<f64> = even.chain(sampled).collect();
    times.sort_by(f64::total_cmp);
    let points = times.into_iter().filter_map(|t| Some(((start + t) / seconds, of(solution, t)?)));
    let points: Vec<(f64, f64)> = points.filter(|(_, value)| value.is_finite()).collect();
    (!points.is_empty()).then(|| Series::line(solution.name(), EXACT, points))
}

/// Load against displacement, with the limit load where one is known.
fn bearing(solved: &Solved) -> Figure {
    let Solved { scene, run, exact, .. } = *solved;
    let width = scene.plates.first().and_then(|plate| plate.x).map(|[from, to]| to - from);
    let on_top = scene.plates.first().is_none_or(|plate| plate.on == Side::Top);
    let (name, column) = match (scene.plates.is_empty() || on_top && width.is_some(), on_top) {
        (true, _) => ("mean pressure (kPa)", "pressure_kpa"),
        (_, true) => ("force of the plate (kN/m)", "force_kn_m"),
        (_, false) => ("thrust on the wall (kN/m)", "thrust_kn_m"),
    };
    let force = |k: usize| {
        let (now, before) = (&run.samples[k], k.checked_sub(1).map(|before| &run.samples[before]));
        if let Some(load) = scene.surcharge.filter(|_| scene.plates.is_empty()) {
            return Some(1e-3 * load.at(now.state.time));
        }
        // Of a dynamic run the first sample has no force: it is what the soil has got since the one before.
        before.map(|_| ()).or_else(|| now.state.plates.iter().all(|push| push.force.is_some()).then_some(()))?;
        let [x, y] = plates(now, before)?;
        let into = match scene.plates[0].on {
            Side::Top => -y / width.unwrap_or(1.0),
            Side::Bottom => y,
            Side::Left => x,
            Side::Right => -x,
        };
        Some(1e-3 * into)
    };
    let moved = |s: &Sample| match scene.plates.first() {
        Some(plate) => 1e3 * plate.at(s.state.time).abs(),
        None => 1e3 * s.state.settlement,
    };
    let across = if scene.plates.is_empty() { "settlement of the top (mm)" } else { "displacement of the plate (mm)" };
    let points = (0..run.samples.len()).filter_map(|k| Some(Point::new(moved(&run.samples[k]), force(k)?)));
    let mark = if run.samples.len() < FEW { Mark::LinePoints } else { Mark::Line };
    let mut panel = Panel::new("", Axis::linear(across, "displacement_mm"), Axis::linear(name, column))
        .with(Series::new("computed", look::nth(0).radius(2.6), mark, points));
    let end = panel.all_x().into_iter().fold(0.0, f64::max);
    if let Some((solution, limit)) = exact.and_then(|(solution, _)| Some((solution, 1e-3 * solution.limit()?))) {
        let unit = if matches!(solution, Solution::Wall(_)) { "kN/m" } else { "kPa" };
        let label = format!("{}: {} {unit}", solution.name(), short(limit, 3));
        panel.add(Series::line(label, EXACT, [(0.0, limit), (end, limit)]));
    }
    let caption = match exact.and_then(|(solution, _)| solution.limit()) {
        Some(_) => "The dashed line is the exact limit.",
        None => "",
    };
    figure("plot-load", "Load against displacement", caption, vec![panel])
}

/// Discharge, head and front over time.
fn seepage(solved: &Solved) -> Figure {
    const DAY: f64 = 86_400.0;
    let Solved { scene, run, .. } = *solved;
    let (label, column, _) = unit(run);
    let time = || Axis::linear(label, column);
    let per = if scene.dimension == Dimension::Axisymmetric { "radian" } else { "m" };
    let water = |of: fn(&mpm_core::observe::WaterState) -> f64| move |s: &Sample| s.state.water.as_ref().map(of);
    let weight = scene.water.map_or(f64::NAN, |water| water.unit_weight);
    let mut discharge =
        Panel::new("", time(), Axis::linear(&format!("discharge (m³/day per {per})"), "discharge_m3_day"))
            .with(over_time(run, "inflow", look::nth(0), &water(|w| DAY * w.inflow_m3_s)))
            .with(over_time(run, "outflow", look::nth(2), &water(|w| DAY * w.outflow_m3_s)));
    discharge.series.extend(exact_over_time(solved, &|exact, _| exact.discharge(scene).map(|q| DAY * q)));
    // The first inflow into dry soil is without bound.
    let end = run.samples.last().map_or(0.0, |s| s.state.time);
    let late = |s: &&Sample| s.state.time > 0.1 * end;
    let flows = || run.samples.iter().filter(late).filter_map(|s| s.state.water.as_ref());
    let most = flows().map(|w| DAY * w.inflow_m3_s.max(w.outflow_m3_s)).fold(0.0, f64::max);
    let clipped = most > 0.0 && discharge.all_y().iter().any(|q| *q > 1.1 * most);
    if clipped {
        discharge.y.range = Some((0.0, 1.1 * most));
    }
    let head = Panel::new("", time(), Axis::linear("head at the base (m)", "head_m")).with(over_time(
        run,
        "mean over the lowest row of cells",
        look::nth(3),
        &|s| Some(s.state.base_pressure / weight),
    ));
    let mut front = Panel::new("", time(), Axis::linear("front (m)", "front_m"));
    if let Some((solution, _)) = solved.exact {
        front.add(over_time(run, "front", look::nth(4), &|s| solution.front_of(scene, s)));
        front.series.extend(exact_over_time(solved, &|exact, t| exact.front(t)));
    }
    let caption = if clipped { "The first inflow, into dry soil, is above the scale." } else { "" };
    figure("plot-seepage", "Discharge and head over time", caption, vec![discharge, head, front])
}

/// Settlement and degree of consolidation over the logarithm of time.
fn consolidation(solved: &Solved) -> Figure {
    let Solved { scene, run, exact, .. } = *solved;
    let (label, column, _) = unit(run);
    let time = || Axis::log(label, column);
    let after = |of: f64, s: &Sample| (s.state.time > 0.0).then_some(of);
    let mut settlement = Panel::new("", time(), Axis::linear("settlement of the top (mm)", "settlement_mm"))
        .with(over_time(run, "computed", look::nth(0), &|s| after(1e3 * s.state.settlement, s)));
    settlement.series.extend(exact_over_time(solved, &|exact, t| Some(1e3 * exact.settlement(scene, t)?)));
    // Engineers read it downwards.
    let most = settlement.all_y().into_iter().fold(0.0, f64::max);
    settlement.y.range = (most > 0.0).then_some((1.06 * most, -0.06 * most));
    let mut degree = Panel::new("", time(), Axis::linear("degree of consolidation U", "degree").range(1.04, -0.04));
    if let Some(whole) = exact.and_then(|(solution, _)| solution.final_settlement(scene)) {
        degree.add(over_time(run, "from the settlement", look::nth(0), &|s| after(s.state.settlement / whole, s)));
        degree.series.extend(exact_over_time(solved, &|exact, t| Some(exact.settlement(scene, t)? / whole)));
    }
    let mean = |s: &Sample| s.state.mean_pressure;
    let (first, highest) = run
        .samples
        .iter()
        .fold((0.0, 0.0), |(at, most), s| if mean(s) > most { (s.state.time, mean(s)) } else { (at, most) });
    if highest > 0.0 && scene.gravity.is_none() {
        let dissipated =
            |s: &Sample| (s.state.time >= first).then(|| 1.0 - mean(s) / highest).and_then(|u| after(u, s));
        degree.add(over_time(run, "from the mean pore pressure", look::nth(3).dash(Dash::Dotted), &dissipated));
    }
    let caption = "U from the settlement is the share of the final settlement; from the pore pressure, the share of its largest mean that has gone.";
    figure(
        "plot-consolidation",
        "Settlement and degree of consolidation over the logarithm of time",
        caption,
        vec![settlement, degree],
    )
}

/// Pore pressures over time.
fn pressures(solved: &Solved) -> Figure {
    let (label, column, _) = unit(solved.run);
    figure("plot-pressure", "Pore pressure over time", "", vec![pressure(solved.run, Axis::linear(label, column))])
}

fn pressure(run: &Run, time: Axis) -> Panel {
    Panel::new("", time, Axis::linear("pore pressure (kPa)", "pore_pressure_kpa"))
        .with(over_time(run, "lowest row of cells", look::nth(2), &|s| Some(s.state.base_pressure / 1e3)))
        .with(over_time(run, "mean", look::nth(3).dash(Dash::Dashed), &|s| Some(s.state.mean_pressure / 1e3)))
}

/// Settlement, run-out and pore pressure over time.
fn motion(solved: &Solved) -> Figure {
    let Solved { scene, run, .. } = *solved;
    let (label, column, _) = unit(run);
    let time = || Axis::linear(label, column);
    let mut panels = Vec::new();
    if run.samples.iter().any(|s| s.state.settlement.abs() > NOTHING) {
        let mut settlement = Panel::new("", time(), Axis::linear("settlement of the top (mm)", "settlement_mm"))
            .with(over_time(run, "computed", look::nth(0), &|s| Some(1e3 * s.state.settlement)));
        settlement.series.extend(exact_over_time(solved, &|exact, t| Some(1e3 * exact.settlement(scene, t)?)));
        panels.push(settlement);
    }
    let reach = |s: &Sample| s.state.reach[0];
    let first = run.samples.first().map_or(0.0, reach);
    if run.samples.iter().any(|s| (reach(s) - first).abs() > 0.5 * scene.cell) {
        let run_out = over_time(run, "run-out", look::nth(4), &|s| Some(reach(s) - first));
        panels.push(Panel::new("", time(), Axis::linear("run-out (m)", "run_out_m")).with(run_out));
    }
    if scene.water.is_some() {
        panels.push(pressure(run, time()));
    }
    let caption = "The settlement is the mean of the top, from the unloaded state.";
    figure("plot-history", "Over time", caption, panels)
}

/// Pore pressure and vertical effective stress over the height at observed times.
fn profiles(solved: &Solved) -> Option<Figure> {
    let Solved { scene, run, exact, .. } = *solved;
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
        if let Some((exact, _)) = exact.filter(|_| s.stage == stage && s.stage_time > 0.0) {
            let at = |i: u32| f64::from(i) / f64::from(FINE) * scene.height;
            let points = (0..=FINE).filter_map(|i| Some((exact.pressure(at(i), s.stage_time)? / 1e3, at(i))));
            let look = look::nth(nth).dash(Dash::Solid).width(1.2);
            let points: Vec<_> = points.filter(|(pressure, _)| pressure.is_finite()).collect();
            pressure.add(Series::line(format!("{}, {label}", exact.name()), look, points).unlisted());
        }
        if scene.water.is_some() {
            pressure.add(rows(label.clone(), nth, s, &|row| row.pressure_pa));
        }
        stress.add(rows(label, nth, s, &|row| row.effective_stress_pa));
    }
    let mut panels: Vec<Panel> = [pressure, stress].into_iter().filter(|panel| !panel.is_empty()).collect();
    plots::figure::share_y(&mut panels);
    let mut caption = "Markers: means of the rows of cells; compression negative.".to_owned();
    if let Some((exact, _)) = exact.filter(|(exact, _)| exact.pressure(0.0, 1.0).is_some()) {
        caption.push_str(&format!(" Lines of the same colour: {}.", exact.name()));
    }
    (!panels.is_empty()).then(|| Figure {
        name: "plot-profiles",
        title: "Pore pressure and effective stress over the height".to_owned(),
        caption,
        height: 330.0,
        panels,
        missing: Vec::new(),
    })
}

/// Smallest and largest residual over its tolerance that are shown.
const RESIDUALS: (f64, f64) = (1e-9, 10.0);

/// The residual of every balance over its tolerance.
fn balance_residuals(scene: &Scene, run: &Run) -> Option<Figure> {
    run.trust?;
    let mut names: Vec<&'static str> = Vec::new();
    let (label, column, seconds) = unit(run);
    let (least, most) = RESIDUALS;
    let residual = Axis::log("residual / tolerance", "residual_over_tolerance").range(least, most);
    let mut panel = Panel::new("", Axis::linear(label, column), residual);
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
    let mut below = Vec::new();
    for (nth, name) in names.iter().enumerate() {
        let of = |(time, balances): &(f64, Vec<mpm_core::observe::Balance>)| {
            let balance = balances.iter().find(|balance| balance.name == *name)?;
            let share = if balance.gap == 0.0 { 0.0 } else { (balance.gap / balance.allowed).abs() };
            Some((*time, share.clamp(least, most)))
        };
        let points: Vec<(f64, f64)> = all.iter().filter_map(of).collect();
        if points.iter().all(|(_, share)| *share == least) {
            below.push(*name);
        } else {
            panel.add(Series::line(*name, look::nth(nth), points));
        }
    }
    let ends = all.first().zip(all.last()).map(|(first, last)| [first.0, last.0])?;
    let bound = Look::new(GREY, Marker::Dot).dash(Dash::Dashed).width(1.2);
    panel.add(Series::line("tolerance", bound, ends.map(|time| (time, 1.0))).guide());
    let closed =
        if below.is_empty() { String::new() } else { format!(" Below {least:e} throughout: {}.", below.join(", ")) };
    Some(Figure {
        name: "plot-balances",
        title: "Balance residuals over time".to_owned(),
        caption: format!("A balance whose residual is above the dashed line is open; the run then fails.{closed}"),
        height: 220.0,
        panels: vec![panel],
        missing: Vec::new(),
    })
}

/// The state at the observed times.
fn numbers(solved: &Solved) -> Table {
    let Solved { scene, run, exact, .. } = *solved;
    let (label, _, seconds) = unit(run);
    let observed: Vec<&Sample> = run.samples.iter().filter(|s| s.observed).collect();
    let stage = run.samples.last().map_or(0, |s| s.stage);
    let (wet, still) = (scene.water.is_some(), run.samples.iter().all(|s| s.state.settlement.abs() < NOTHING));
    let mut columns: Vec<(&str, Vec<String>)> = Vec::new();
    let mut add = |name, digits, of: &dyn Fn(&Sample) -> f64| {
        columns.push((name, column(&observed.iter().map(|s| of(s)).collect::<Vec<_>>(), digits)));
    };
    add(label, 4, &|s| s.state.time / seconds);
    if !still {
        add("settlement (mm)", 4, &|s| 1e3 * s.state.settlement);
        let error = |s: &Sample| {
            let settlement =
                exact.filter(|_| s.stage == stage).and_then(|(exact, _)| exact.settlement(scene, s.stage_time));
            settlement.map_or(f64::NAN, |exact| 100.0 * (s.state.settlement / exact - 1.0))
        };
        if observed.iter().any(|s| error(s).is_finite()) {
            add("error of the settlement (%)", 2, &error);
        }
    }
    if wet {
        add("mean pore pressure (kPa)", 4, &|s| 1e-3 * s.state.mean_pressure);
        add("pore pressure at the base (kPa)", 4, &|s| 1e-3 * s.state.base_pressure);
    }
    if observed.iter().any(|s| s.state.max_speed > 0.0) {
        add("largest speed (m/s)", 2, &|s| s.state.max_speed);
    }
    let head: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let row = |k: usize| columns.iter().map(|(_, texts)| Cell::new(texts[k].clone())).collect();
    Table::new("At the observed times", &head, (0..observed.len()).map(row).collect(), "")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::{GALLERY, about, load};

    /// The page of a scene of the gallery and what it has beside the exact solution.
    fn page(name: &str) -> (String, Option<Found>, tempfile::TempDir) {
        let scene = load(name, &Default::default()).expect("a scene");
        let run = mpm_core::run::run(&scene, &mut |_| {}).expect("a run");
        let solution = Solution::of(&scene);
        let found = solution.as_ref().and_then(|solution| Found::of(solution, &scene, &run));
        let folder = tempfile::tempdir().expect("a folder");
        let exact = solution.as_ref().zip(found.as_ref());
        let solved = Solved { scene: &scene, run: &run, exact, about: &about(name), source: name, cpu_s: 1.0 };
        write(&solved, &Manifest::new(&scene, 1), folder.path()).expect("a page");
        let html = std::fs::read_to_string(folder.path().join("index.html")).expect("a page");
        (html, found, folder)
    }

    #[test]
    fn every_gallery_scene_with_an_exact_solution_shows_its_error_first() {
        let known =
            GALLERY.iter().filter(|one| Solution::of(&load(one.name, &Default::default()).expect("a scene")).is_some());
        let known: Vec<&str> = known.map(|one| one.name).collect();
        assert_eq!(known, ["footing", "retaining-wall", "cyclic-load"]);
        for name in known {
            let (html, found, folder) = page(name);
            let found = found.expect("numbers beside the exact ones");
            let (number, words) = (&found.numbers[0], found.headline());
            assert!(number.error().abs() < 0.06, "{name}: {words}");
            assert!(html.contains(&capital(&words)) && html.contains(&short(number.exact, 4)), "{name}: {words}");
            let sections = ["scene", "exact", "result", "balances", "numbers", "again", "conditions"];
            let places = sections.map(|id| html.find(&format!("<section id=\"{id}\">")).expect(id));
            assert!(places.is_sorted() && html.contains("class=\"sketch\""), "{name}: {places:?}");
            assert!(!html.contains("10⁻¹⁵"), "{name}");
            let drawing = std::fs::read_to_string(folder.path().join(THUMBNAIL)).expect("a drawing");
            assert!(drawing.starts_with("<svg xmlns=") && drawing.contains("<style>"), "{name}");
        }
    }

    #[test]
    fn the_footing_shows_prandtls_load() {
        let (html, ..) = page("footing");
        for part in [
            "Load against displacement",
            "Prandtl: 51.4",
            "A rough strip footing",
            "exact 51.4 kPa (Prandtl)",
            "<td>φ</td>",
        ] {
            assert!(html.contains(part), "{part}");
        }
    }

    #[test]
    fn what_does_not_settle_has_no_axis_of_round_off() {
        let (html, _, folder) = page("rain");
        assert!(html.contains("does not settle") && html.contains("Discharge and head over time"));
        assert!(!html.contains("settlement of the top") && !html.contains("settlement (mm)"));
        // Its drawing has soil and the water in it.
        let drawing = std::fs::read_to_string(folder.path().join(THUMBNAIL)).expect("a drawing");
        assert!(drawing.contains("class=\"soil\"") && drawing.contains("class=\"pores\""));
    }

    #[test]
    fn a_scene_of_the_suite_is_compared_as_the_suite_measures_it() {
        let solution = |name: &str| Solution::of(&load(name, &Default::default()).expect("a scene")).map(|s| s.name());
        let expected =
            [("mandel", Some("Mandel")), ("dam", Some("Charny")), ("terzaghi", Some("Terzaghi")), ("embankment", None)];
        for (name, whose) in expected {
            assert_eq!(solution(name), whose, "{name}");
        }
        assert_eq!(title("levee-with-core"), "Levee with core");
    }
}

//! The pictures of a run, each with its numbers beside it.

use std::path::Path;

use mpm_core::failure::{Events, PathPoint, Row};
use mpm_core::scene::{Feed, Scene};

use super::moments::{self, EVENTS, times};
use super::operators::{self as both, Compared};
use super::plan::Plan;
use super::run::Followed;
use super::strength::Strength;
use crate::frames::Shot;
use crate::report::ReportError;
use crate::report::numbers::{percent, short};
use crate::report::plots::figure::Figure;
use crate::report::plots::levee::changes::{self, Shown};
use crate::report::plots::levee::failing;
use crate::report::plots::levee::histories::{self, Named, Trace, Track, Zoom};
use crate::report::plots::levee::operators::{self, FullCell, Responses};
use crate::report::plots::levee::paths::{self, StressPath};
use crate::report::plots::levee::{Event, Site, clock, initial, points};
use crate::report::quantity::{PRESSURE, STRAIN};

/// A picture that was written.
#[derive(Debug, Clone)]
pub struct Picture {
    /// What it is made of.
    pub figure: Figure,
    /// Whether a page can hold it as a drawing; of thousands of particles it shows the image instead.
    pub is_light: bool,
}

/// The heaviest drawing that a page holds, bytes of SVG.
const HEAVY: usize = 120_000;

impl Picture {
    /// One that was written as PNG and, with this text, as SVG.
    pub fn new(figure: Figure, svg: &str) -> Self {
        Self { is_light: svg.len() <= HEAVY, figure }
    }
}

/// Seconds shown before the rapid failure, and the most after it.
const ZOOM: (f64, f64) = (15.0, 120.0);

/// What all pictures share.
pub fn site(scene: &Scene) -> Site {
    let feed = scene.free_surface.as_ref().and_then(|water| water.feeds[0]);
    let tank_m = feed.map_or(0.0, |feed| match feed {
        Feed::Head(head) => head,
        Feed::Velocity { height, .. } => height,
    });
    Site { outline: scene.outline_or_box(), tank_m }
}

/// The events that happened, in the order of time.
pub fn events(events: &Events) -> Vec<Event> {
    let all = EVENTS.iter().zip(times(events)).filter_map(|((name, words), time)| {
        Some(Event { name: (*name).to_owned(), words: (*words).to_owned(), time_s: 3600.0 * time? })
    });
    let mut all: Vec<Event> = all.collect();
    all.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    all
}

/// Writes all pictures into a folder.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(plan: &Plan, run: &Followed, folder: &Path) -> Result<Vec<Picture>, ReportError> {
    let site = site(&plan.scene);
    let mut all = Vec::new();
    let Some(first) = run.shots.first() else { return Ok(all) };
    let papers_levee = plan.papers();
    if papers_levee {
        // It draws the tank and the wall of the experiment.
        let svg = initial::write(&site, &first.frame, folder)?;
        all.push(Picture::new(initial::figure(&site, &first.frame), &svg));
    }
    let own = own(&run.shots);
    let failing: Vec<&Shot> = own.iter().copied().filter(|shot| is_of_failure(shot, run.shots.last())).collect();
    if failing.len() > 1 {
        let figure = failing::figure(&site, &failing, plan.scales().events()[1]);
        failing::write(&figure, &failing, folder)?;
        all.push(Picture { figure, is_light: false });
    }
    for (shots, papers) in [(own, false), (at_papers_times(&run.shots), true)] {
        if shots.len() < 2 || papers && !papers_levee {
            continue;
        }
        for shown in [Shown::Shape, Shown::Of(STRAIN), Shown::Of(PRESSURE)] {
            let mut figure = changes::figure(&site, &shots, shown);
            if papers {
                figure.name = papers_name(shown);
                figure.title.push_str(", at the times of the paper's Fig. 7");
            }
            changes::write(&figure, &shots, shown, folder)?;
            all.push(Picture { figure, is_light: false });
        }
    }
    let observed = points::numbered(plan.points());
    if !observed.is_empty() {
        let svg = points::write(&site, &first.frame, &observed, folder)?;
        all.push(Picture::new(points::figure(&site, &first.frame, &observed), &svg));
    }
    if let (Some(strength), false) = (Strength::of(&plan.scene), run.paths.is_empty()) {
        let paths = stress_paths(&run.paths);
        let failure_s = run.events.failure_h.map(|h| 3600.0 * h);
        let drawn = paths::write(&paths, strength, failure_s, folder)?;
        let figures = [paths::figure(&paths, strength, failure_s), paths::each(&paths, strength, failure_s)];
        all.extend(figures.into_iter().zip(drawn).map(|(figure, svg)| Picture::new(figure, &svg)));
    }
    if let Some(compared) = both::of(&plan.scene, run).filter(|_| papers_levee) {
        let shown = responses(&compared);
        let figure = operators::figure(&site, &shown);
        let svg = operators::write(&figure, &shown, folder)?;
        all.push(Picture::new(figure, &svg));
    }
    if run.rows.len() > 1 {
        let (events, zoom) = (events(&run.events), zoom(run));
        for (named, tracks) in [(HAPPENED, happened(&run.rows, plan.levels())), (SOUND, sound(&run.rows))] {
            let svg = histories::write(named, &tracks, &events, zoom, folder)?;
            all.push(Picture::new(histories::figure(named, &tracks, &events, zoom), &svg));
        }
    }
    Ok(all)
}

/// Frames at the start, at events and at the end.
fn own(shots: &[Shot]) -> Vec<&Shot> {
    let happened = |shot: &Shot| EVENTS.iter().any(|(name, _)| shot.phase.split(", ").any(|word| word == *name));
    let last = shots.len().saturating_sub(1);
    shots.iter().enumerate().filter(|(k, shot)| *k == 0 || *k == last || happened(shot)).map(|(_, shot)| shot).collect()
}

/// Whether a frame is of an event of the soil or the last.
fn is_of_failure(shot: &Shot, last: Option<&Shot>) -> bool {
    let is_last = last.is_some_and(|last| std::ptr::eq(last, shot));
    is_last || ["E1", "E2", "E3"].iter().any(|event| shot.phase.split(", ").any(|word| word == *event))
}

fn at_papers_times(shots: &[Shot]) -> Vec<&Shot> {
    let at = |hours: f64| shots.iter().find(|shot| (shot.time_s - 3600.0 * hours).abs() < 0.05);
    moments::PAPER.into_iter().filter_map(at).collect()
}

fn papers_name(shown: Shown) -> &'static str {
    match shown {
        Shown::Shape => "levee-shape-papers-times",
        Shown::Of(quantity) if quantity == STRAIN => "levee-strain-papers-times",
        Shown::Of(_) => "levee-pressure-papers-times",
    }
}

/// Paths by their places. Their pictures show mean and shear stress: any tensor of these will do.
fn stress_paths(all: &[PathPoint]) -> Vec<StressPath> {
    let count = all.iter().map(|p| p.point).max().unwrap_or(0);
    let path = |number: u32| {
        let own = all.iter().filter(|p| p.point == number);
        let stress = |p: &PathPoint| [p.shear_pa - p.mean_pa, -p.shear_pa - p.mean_pa, 0.0, 0.0];
        let points = own.map(|p| (3600.0 * p.time_h, stress(p))).collect();
        StressPath { name: format!("S{number}"), points }
    };
    (1..=count).map(path).collect()
}

/// Both responses to a point source, with what was found.
fn responses(compared: &Compared) -> Responses {
    let Compared { numbers, region, size, response } = compared;
    let cell = |cell: usize| FullCell {
        x: region.middle(cell).map(|x| x * size),
        known: region.known[cell],
        response: [0, 1].map(|k| 1e-3 * response[k][cell]),
    };
    let [alone, with] = [numbers.index_of_response, numbers.index_with_source].map(|pair| pair.map(percent));
    let modes = match (numbers.checkerboard_modes, numbers.least_resistance) {
        (Some(modes), Some(least)) => format!(
            " Of its {} modes the nodal operator resists {modes} by less than {} % of what the face operator does, \
             the weakest by {} %.",
            numbers.unknown_cells,
            percent(both::WEAK),
            percent(least)
        ),
        _ => String::new(),
    };
    let finer: String = numbers
        .finer
        .iter()
        .map(|finer| {
            let [face, nodal] = finer.index_of_response.map(percent);
            format!(" In the same outline with cells of {} m: {face} % and {nodal} %.", short(finer.cell_m, 2))
        })
        .collect();
    let caption = format!(
        "The {} full cells at {}, the last frame before failure; the head is known in those beside the tank and beside cells \
         that are not full, and the base is impermeable. Steady flow with a source that adds {} kPa to its own cell under the face \
         operator. Checkerboard index of what it adds: {} % under the face operator, {} % under the nodal one; of the whole \
         pore pressure: {} % and {} %. The nodal operator ties a cell to its diagonal \
         neighbours alone, and along the base to those beside it.{modes}{finer}",
        numbers.full_cells,
        clock(3600.0 * numbers.time_h),
        1e-3 * both::LIFT,
        alone[0],
        alone[1],
        with[0],
        with[1]
    );
    Responses {
        cells: region.all().map(cell).collect(),
        size: *size,
        source: numbers.source_m,
        index: numbers.index_of_response,
        caption,
    }
}

const HAPPENED: Named = ("levee-histories", "Water, displacements and speed over time");
const SOUND: Named = ("levee-balances", "Energies and checks over time");
/// What the residual of the energy balance, the checkerboard index and the share of motion in hourglass modes should stay below.
const LIMITS: [f64; 3] = [0.02, 0.01, 0.05];

fn trace(rows: &[Row], name: &str, of: &dyn Fn(&Row) -> f64) -> Trace {
    Trace { name: name.to_owned(), points: rows.iter().map(|row| (3600.0 * row.time_h, of(row))).collect() }
}

fn track(label: &str, log: bool, lines: Vec<Trace>) -> Track {
    Track { label: label.to_owned(), log, lines, limit: None }
}

/// Nothing has no place on a logarithmic axis.
fn above(least: f64, of: fn(&Row) -> f64) -> impl Fn(&Row) -> f64 {
    move |row| of(row).max(least)
}

/// Water and soil.
fn happened(rows: &[Row], levels: &[f64]) -> Vec<Track> {
    let trace = |name: &str, of: &dyn Fn(&Row) -> f64| trace(rows, name, of);
    let level = |(k, x): (usize, &f64)| trace(&format!("level at x = {x} m"), &|row| row.levels[k]);
    let mut all = vec![
        track(
            "front, toe (m)",
            false,
            vec![trace("wetting front", &|r| r.front_x_m), trace("toe of the soil", &|r| r.toe_x_m)],
        ),
        track("level (m)", false, levels.iter().enumerate().map(level).collect()),
        track(
            "water (m³)",
            false,
            vec![
                trace("water that flowed in", &|r| r.water_in_m3),
                trace("water that flowed out", &|r| r.water_out_m3),
            ],
        ),
        track("moved (m)", true, vec![trace("largest displacement", &above(1e-5, |r| r.max_displacement_m))]),
        track("crest down (m)", false, vec![trace("settlement of the crest", &|r| r.crest_settlement_m)]),
        track("strain", false, vec![trace("largest deviator strain", &|r| r.deviator_strain)]),
        track("speed (m/s)", true, vec![trace("fastest particle", &above(1e-6, |r| r.speed_m_s))]),
    ];
    all.retain(|track| !track.lines.is_empty());
    all
}

/// Energies, balances and measures of the fields.
fn sound(rows: &[Row]) -> Vec<Track> {
    let trace = |name: &str, of: &dyn Fn(&Row) -> f64| trace(rows, name, of);
    // In percent of what they are measured by.
    let percents = |label: &str, name: &str, of: fn(&Row) -> f64, limit: f64| Track {
        limit: Some(100.0 * limit),
        ..track(label, true, vec![trace(name, &|r| (100.0 * of(r)).max(1e-4))])
    };
    // Below any round-off.
    let least = 1e-18;
    vec![
        track(
            "energy (kJ)",
            false,
            vec![
                trace("work of gravity", &|r| 1e-3 * r.gravity_work_j),
                trace("work of pore pressure", &|r| 1e-3 * r.pressure_work_j),
                trace("plastic dissipation", &|r| 1e-3 * r.plastic_j),
                trace("friction on the base", &|r| 1e-3 * r.friction_j),
                trace("loss in damping and mapping", &|r| 1e-3 * (r.damping_j + r.mapping_j)),
            ],
        ),
        track(
            "energy (J)",
            true,
            vec![
                trace("elastic energy", &above(1e-3, |r| r.strain_j)),
                trace("kinetic energy", &above(1e-3, |r| r.kinetic_j)),
            ],
        ),
        percents("energy (%)", "residual of the energy balance", |r| r.energy_error, LIMITS[0]),
        track(
            "water balance",
            true,
            vec![trace("residual of the water balance", &|r| (r.water_residual_m3 / r.water_m3).abs().max(least))],
        ),
        track(
            "yield function",
            true,
            vec![trace("largest violation of the yield function", &above(least, |r| r.yield_residual))],
        ),
        percents("checkerboard (%)", "checkerboard index", |r| r.checkerboard, LIMITS[1]),
        percents("hourglass (%)", "motion in hourglass modes", |r| r.hourglass, LIMITS[2]),
    ]
}

/// The rapid failure, or the failure where it is not rapid.
fn zoom(run: &Followed) -> Option<Zoom> {
    let start = 3600.0 * run.events.collapse_h.or(run.events.failure_h)?;
    let end = 3600.0 * run.rows.last()?.time_h;
    let first = 3600.0 * run.rows.first()?.time_h;
    let (before_s, after_s) = (ZOOM.0.min(start - first).max(1.0), (end - start).clamp(1.0, ZOOM.1));
    Some(Zoom { start_s: start, before_s, after_s })
}

//! Pore pressure over height at several times (the paper's Fig. 4b).

use super::axis::Axis;
use super::figure::{Figure, Mark, Panel, Point, Series};
use super::look::{self, Dash};
use crate::report::select::{Cases, Exact, LOADS, Reference, same_time, stands_in};
use crate::study::{CaseResult, Profile};

/// Time factors shown.
const TIMES: [f64; 6] = [0.01, 0.05, 0.1, 0.2, 0.5, 1.0];

/// Most points of one profile.
const MOST: usize = 25;

/// Computed points on Terzaghi's lines, one panel per load.
pub fn figure(cases: &Cases) -> Figure {
    let mut figure = Figure {
        name: "isochrones",
        title: "Pore pressure over the height of the column (the paper's Fig. 4b)".to_owned(),
        caption:
            "Points: computed, at most 25 of the cells shown. Lines of the same colour: Terzaghi, incompressible water, \
                  p₀ = q. At early times the pressure near the base oscillates about q: the sudden opening of the drain sends a \
                  wave down the column; the exact solution with inertia shows it too."
                .to_owned(),
        height: 400.0,
        panels: Vec::new(),
        missing: Vec::new(),
    };
    for (load, words) in LOADS {
        let title = cases.paper(load).map_or_else(|| words.to_owned(), |c| format!("{words}, L = {} m", c.mesh_m));
        let x = Axis::linear("pore pressure p/p₀", "p_over_p0").range(0.0, 1.08);
        let mut panel = Panel::new(&title, x, Axis::linear("height (m)", "height_m"));
        match cases.paper(load) {
            Some(case) => {
                figure.caption.push_str(&stands_in(case));
                fill(&mut panel, case, &mut figure.missing);
            }
            None => figure.missing.push(format!("isochrones: no run with the {words}")),
        }
        figure.panels.push(panel);
    }
    super::figure::share_y(&mut figure.panels);
    figure
}

fn fill(panel: &mut Panel, case: &CaseResult, missing: &mut Vec<String>) {
    let load = load(case);
    for (place, tv) in TIMES.into_iter().enumerate() {
        let Some(profile) = case.profiles.iter().find(|p| same_time(p.tv, tv)) else {
            missing.push(format!("isochrones: no profile of {} at Tv = {tv}", case.case));
            continue;
        };
        let look = look::nth(place).radius(2.6).width(1.3);
        let line = exact(profile, case, Reference::Terzaghi);
        panel.add(Series::line(format!("Terzaghi, Tv = {tv}"), look.dash(Dash::Solid), line).unlisted());
        let points = computed(profile, load, MOST).map(|p| p.open(true));
        panel.add(Series::new(format!("Tv = {tv}"), look, Mark::Points, points));
    }
}

/// Pressure over the load at so many of the computed heights at most.
pub(super) fn computed(profile: &Profile, load: f64, most: usize) -> impl Iterator<Item = Point> {
    let every = profile.rows.len().div_ceil(most).max(1);
    profile.rows.iter().step_by(every).map(move |r| Point::new(r.pressure_pa / load, r.height_m))
}

/// Profile of an exact solution, pressure over the load: dense where the column is the built-in one, else through the computed heights.
pub(super) fn exact(profile: &Profile, case: &CaseResult, reference: Reference) -> Vec<(f64, f64)> {
    let (load, of) = (load(case), |terzaghi, compressible| [terzaghi, compressible][reference as usize]);
    let time = case.degrees.iter().find(|d| same_time(d.tv, profile.tv)).map(|d| d.time_s);
    if let (Some(Exact { terzaghi, compressible }), Some(time)) = (Exact::of(case), time) {
        let heights = (0..=100).map(|k| f64::from(k) / 100.0 * terzaghi.height);
        return heights.map(|y| (of(terzaghi.pressure(y, time), compressible.pressure(y, time)) / load, y)).collect();
    }
    profile.rows.iter().map(|r| (of(r.terzaghi_pa, r.compressible_pa) / load, r.height_m)).collect()
}

/// The load, Pa; where it is not known the largest pressure of Terzaghi's solution in all profiles, which is close to it.
pub(super) fn load(case: &CaseResult) -> f64 {
    let largest =
        || case.profiles.iter().flat_map(|p| &p.rows).map(|r| r.terzaghi_pa).fold(f64::MIN_POSITIVE, f64::max);
    Exact::of(case).map_or_else(largest, |exact| exact.terzaghi.load)
}

//! Runs that should be equal: the scene with its cohesion changed by a few thousandths and its cells by a hundredth, which shifts mesh
//! and particles against the slope, on several meshes. Failure multiplies such differences; what it leaves is told by medians and 80 %
//! ranges.

use mpm_core::failure::towards;
use mpm_core::scene::Flags;
use serde::{Deserialize, Serialize};

use super::plan::{self, Plan};
use super::run::{Followed, follow_quietly};
use super::tables::OfScene;
use super::variants::{Change, Variant};
use crate::error::Error;
use crate::experiment::pool;
use crate::report::content::table::{Cell, Table, table};
use crate::report::numbers::short;

/// Name of the table in the folder of a run.
pub const NAME: &str = "ensemble.csv";
/// Largest change of the cohesion, as a share of it.
const COHESION: f64 = 0.004;
/// Largest change of the edge of a cell, as a share of it.
const CELL: f64 = 0.01;
/// Edges of cells as shares of the scene's, the most members on each; the last only where long runs are asked for.
const CELLS: [(f64, usize); 3] = [(2.0, usize::MAX), (1.0, usize::MAX), (0.5, 3)];
/// Ends of the range that four of five runs lie in.
const RANGE: [f64; 2] = [0.1, 0.9];

/// One run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Edge of a cell, m.
    pub cell_m: f64,
    /// Which run on this mesh, from 0: the scene itself.
    pub member: usize,
    /// Cohesion over that of the scene.
    pub cohesion_factor: f64,
    /// Edge of a cell over that of the mesh.
    pub cell_factor: f64,
    /// E1, h.
    pub raveling_h: Option<f64>,
    /// E2, h.
    pub failure_h: Option<f64>,
    /// E3, h.
    pub collapse_h: Option<f64>,
    /// From E1 to rest after a collapse, s.
    pub lasts_s: Option<f64>,
    /// From E2 to the same, s.
    pub fails_s: Option<f64>,
    /// How far the toe has moved after a collapse, m.
    pub runout_m: Option<f64>,
    /// Settlement of the crest after a collapse, m.
    pub crest_m: Option<f64>,
    /// CPU time, s.
    pub cpu_s: f64,
    /// What went wrong, if something did.
    pub why: String,
    /// Of which scene: [`Plan::scene_word`].
    pub scene: String,
}

impl OfScene for Line {
    fn scene(&self) -> &str {
        &self.scene
    }
}

/// What a member changes: the factors of the cohesion and of the edge of a cell, each evenly spread over its range, in different orders.
fn change(member: usize, of: usize) -> [f64; 2] {
    let (Some(number), others) = (member.checked_sub(1), of - 1) else { return [1.0; 2] };
    if others < 2 {
        return [1.0 + COHESION, 1.0 + CELL];
    }
    let shuffled = (2 * number + 1) % (others + usize::from(others.is_multiple_of(2)));
    let place = |number: usize| 2.0 * number as f64 / (others - 1) as f64 - 1.0;
    [1.0 + COHESION * place(number), 1.0 + CELL * place(shuffled)]
}

/// Runs so many members on cells of twice and once (and with `full` of half) the size of the scene's, `jobs` at a time. None takes
/// another down.
///
/// # Errors
/// What was expected of the scene and found.
pub fn compute(
    (source, variant): (&str, Option<&Variant>),
    flags: &Flags,
    (members, full): (usize, bool),
    jobs: usize,
    tell: &(dyn Fn(&str) + Sync),
) -> Result<Vec<Line>, Error> {
    if let Some(variant) = variant.filter(|v| matches!(v.change, Change::Mesh(_))) {
        return Err(Error::refused("--ensemble", "no variant of the mesh beside it", variant.name));
    }
    let base = Plan::new(plan::scene(source, flags, variant)?, None, None, false)?;
    let word = base.scene_word();
    let mut plans: Vec<(Line, Plan)> = Vec::new();
    // The longest first: none of the others waits for it at the end.
    for (share, most) in CELLS.into_iter().take(if full { 3 } else { 2 }).rev() {
        let count = members.min(most);
        for member in 0..count {
            let (cell, factors) = (share * base.scene.cell, change(member, count));
            let flags = Flags { cell: Some(factors[1] * cell), ..flags.clone() };
            let scene = plan::scene(source, &flags, variant)?.edited(|fields| {
                if let Some(strength) = &mut fields.strength {
                    strength.cohesion *= factors[0];
                }
            })?;
            plans.push((line(cell, (member, factors), &word), Plan::new(scene, None, None, false)?));
        }
    }
    let (count, mut done) = (plans.len(), 0);
    let told = |number: usize, found: &Result<Line, Error>| {
        done += 1;
        let cell = plans[number].0.cell_m;
        let failure = found.as_ref().ok().and_then(|line| line.failure_h);
        let failure = failure.map_or_else(|| "no failure".to_owned(), |h| format!("failure at {h:.3} h"));
        tell(&format!("{done}/{count} cells of {cell} m, run {}: {failure}", plans[number].0.member));
    };
    let one = |_: usize, (line, plan): &(Line, Plan)| match follow_quietly(plan, &mut |_| false) {
        Ok(run) => line.clone().with(&run, towards(&plan.scene.outline_or_box())),
        Err(why) => Line { why: why.to_string(), ..line.clone() },
    };
    let found = pool::each(jobs, &plans, one, told).into_iter().zip(&plans);
    let lines =
        found.map(|(found, (line, _))| found.unwrap_or_else(|why| Line { why: why.to_string(), ..line.clone() }));
    let mut lines: Vec<Line> = lines.collect();
    lines.sort_by(|a, b| b.cell_m.total_cmp(&a.cell_m).then(a.member.cmp(&b.member)));
    Ok(lines)
}

fn line(cell_m: f64, (member, [cohesion_factor, cell_factor]): (usize, [f64; 2]), word: &str) -> Line {
    Line {
        cell_m,
        member,
        cohesion_factor,
        cell_factor,
        raveling_h: None,
        failure_h: None,
        collapse_h: None,
        lasts_s: None,
        fails_s: None,
        runout_m: None,
        crest_m: None,
        cpu_s: 0.0,
        why: String::new(),
        scene: word.to_owned(),
    }
}

impl Line {
    fn with(self, run: &Followed, side: f64) -> Self {
        let (events, last) = (&run.events, run.rows.last());
        let ends = run.rows.first().zip(last).filter(|_| events.collapse_h.is_some());
        let since = |event: Option<f64>| Some(3600.0 * (ends?.1.time_h - event?));
        Self {
            raveling_h: events.raveling_h,
            failure_h: events.failure_h,
            collapse_h: events.collapse_h,
            lasts_s: since(events.raveling_h),
            fails_s: since(events.failure_h),
            runout_m: ends.map(|(first, last)| side * (last.toe_x_m - first.toe_x_m)),
            crest_m: ends.map(|(_, last)| last.crest_settlement_m),
            cpu_s: run.cpu_s,
            why: run.ended.trouble().unwrap_or_default().to_owned(),
            ..self
        }
    }
}

/// A number of the runs on one mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Its median.
    pub median: f64,
    /// The range that four of five runs lie in.
    pub range: [f64; 2],
    /// Runs that have it.
    pub runs: usize,
}

impl Spread {
    /// That of some numbers; nothing of none.
    pub fn of(values: impl Iterator<Item = f64>) -> Option<Self> {
        let mut values: Vec<f64> = values.filter(|v| v.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        let last = values.len().checked_sub(1)?;
        let at = |share: f64| {
            let place = share * last as f64;
            let (low, part) = (place.floor() as usize, place.fract());
            values[low] + part * (values[(low + 1).min(last)] - values[low])
        };
        Some(Self { median: at(0.5), range: RANGE.map(at), runs: values.len() })
    }
}

/// A number that is looked at, what may differ between the medians of the two finest meshes, and between the others.
pub struct Quantity {
    /// What it is.
    pub words: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its value in a run.
    pub of: fn(&Line) -> Option<f64>,
    /// Tolerances: finest two, coarsest two; as shares of the finer one where they are relative.
    tolerance: [Option<f64>; 2],
    relative: bool,
}

/// All of them. Tolerances of times are those of a levee that takes hours; there are none for durations.
pub const QUANTITIES: [Quantity; 7] = [
    Quantity {
        words: "E1: the toe fails",
        unit: "h",
        of: |l| l.raveling_h,
        tolerance: [Some(0.25), Some(0.45)],
        relative: false,
    },
    Quantity {
        words: "E2: failure starts",
        unit: "h",
        of: |l| l.failure_h,
        tolerance: [Some(0.25), Some(0.45)],
        relative: false,
    },
    Quantity {
        words: "E3: rapid failure",
        unit: "h",
        of: |l| l.collapse_h,
        tolerance: [Some(0.25), Some(0.45)],
        relative: false,
    },
    Quantity { words: "from E1 to rest", unit: "s", of: |l| l.lasts_s, tolerance: [None; 2], relative: true },
    Quantity { words: "from E2 to rest", unit: "s", of: |l| l.fails_s, tolerance: [None; 2], relative: true },
    Quantity { words: "run-out", unit: "m", of: |l| l.runout_m, tolerance: [Some(0.1), None], relative: true },
    Quantity {
        words: "settlement of the crest",
        unit: "m",
        of: |l| l.crest_m,
        tolerance: [Some(0.03), None],
        relative: false,
    },
];

/// Edges of the cells, the largest first, m.
pub fn cells(lines: &[Line]) -> Vec<f64> {
    let mut cells: Vec<f64> = lines.iter().map(|l| l.cell_m).collect();
    cells.sort_by(|a, b| b.total_cmp(a));
    cells.dedup();
    cells
}

/// A quantity on one mesh.
pub fn spread(lines: &[Line], cell: f64, of: fn(&Line) -> Option<f64>) -> Option<Spread> {
    Spread::of(lines.iter().filter(|l| l.cell_m == cell).filter_map(of))
}

/// A table for the page.
pub fn shown(lines: &[Line]) -> Table {
    let cells = cells(lines);
    let count = |cell: f64| lines.iter().filter(|l| l.cell_m == cell).count();
    let titles: Vec<String> =
        cells.iter().map(|cell| format!("{} m, {} runs", short(*cell, 2), count(*cell))).collect();
    let head: Vec<&str> = ["", "unit"]
        .into_iter()
        .chain(titles.iter().map(String::as_str))
        .chain(["finest two differ by", "tolerance"])
        .collect();
    let row = |quantity: &Quantity| {
        let found: Vec<Option<Spread>> = cells.iter().map(|cell| spread(lines, *cell, quantity.of)).collect();
        let mut row = vec![Cell::new(quantity.words), Cell::new(quantity.unit)];
        row.extend(found.iter().zip(&cells).map(|(found, cell)| match found {
            Some(s) => {
                let [low, high] = s.range.map(|v| short(v, 3));
                let less = if s.runs < count(*cell) { format!(", of {} runs", s.runs) } else { String::new() };
                Cell::new(short(s.median, 3)).marked(format!("{low} to {high}{less}"), "")
            }
            None => Cell::new("–"),
        }));
        let pair = found.len().checked_sub(2).map(|k| (found[k], found[k + 1]));
        // Three meshes: the two finest; two: as wide as the two coarsest may be apart.
        let allowed = quantity.tolerance[usize::from(found.len() < 3)];
        let off = pair
            .and_then(|(a, b)| Some((a?.median, b?.median)))
            .map(|(a, b)| (a - b).abs() / if quantity.relative { b.abs() } else { 1.0 });
        let said = |v: f64| if quantity.relative { format!("{} %", short(100.0 * v, 2)) } else { short(v, 2) };
        let mark = match (off, allowed) {
            (Some(off), Some(allowed)) if off <= allowed => "good",
            (Some(_), Some(_)) => "bad",
            _ => "",
        };
        row.push(Cell::new(off.map_or_else(|| "–".to_owned(), said)).marked("", mark));
        row.push(Cell::new(allowed.map_or_else(|| "none".to_owned(), said)));
        row
    };
    let mut whys: Vec<&str> = lines.iter().map(|l| l.why.as_str()).filter(|why| !why.is_empty()).collect();
    whys.dedup();
    let whys: String = whys.iter().map(|why| format!(" A run stopped: {why}.")).collect();
    let note = format!(
        "Medians and, in small letters, the ranges that four of five runs lie in. The runs of a mesh differ by up to 0.4 % of cohesion and by \
         cells changed by up to 1 %, which shifts them against the slope.{whys}"
    );
    table("Runs that should be equal".to_owned(), &head, QUANTITIES.iter().map(row).collect(), &note)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_ranges_are_those_of_the_numbers() {
        let spread = Spread::of((0..=10).rev().map(f64::from)).expect("numbers");
        assert_eq!((spread.median, spread.range, spread.runs), (5.0, [1.0, 9.0], 11));
        assert_eq!(
            Spread::of([3.0, f64::NAN].into_iter()).map(|s| (s.median, s.range, s.runs)),
            Some((3.0, [3.0; 2], 1))
        );
        assert_eq!(Spread::of(std::iter::empty()), None);
    }

    #[test]
    fn medians_that_are_too_far_apart_are_marked() {
        let at = |cell_m: f64, crest_m: f64| Line { crest_m: Some(crest_m), ..line(cell_m, (0, [1.0; 2]), "") };
        let marks = |lines: &[Line]| shown(lines).rows.iter().map(|row| row[row.len() - 2].mark).collect::<Vec<_>>();
        let last = QUANTITIES.len() - 1;
        assert_eq!(marks(&[at(0.4, 0.0), at(0.2, 0.1), at(0.1, 0.12)])[last], "good");
        assert_eq!(marks(&[at(0.4, 0.1), at(0.2, 0.1), at(0.1, 0.14)])[last], "bad");
        assert_eq!(marks(&[at(0.4, 0.1)])[last], "");
    }

    #[test]
    fn members_differ_and_the_first_is_the_scene() {
        for of in [2, 3, 4, 5, 9] {
            let all: Vec<[f64; 2]> = (0..of).map(|member| change(member, of)).collect();
            assert_eq!(all[0], [1.0; 2]);
            for (k, one) in all.iter().enumerate() {
                assert!(all[..k].iter().skip(1).all(|other| other[0] != one[0] && other[1] != one[1]), "{all:?}");
                assert!((one[0] - 1.0).abs() <= 1.0001 * COHESION && (one[1] - 1.0).abs() <= 1.0001 * CELL, "{all:?}");
            }
        }
    }
}

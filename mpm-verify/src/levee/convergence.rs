//! What of soil that is held converges with the mesh and the particles: levels of water and the factor of safety. The failure itself is a
//! matter of [`super::ensemble`]s.

use mpm_core::scene::Flags;
use serde::{Deserialize, Serialize};

use super::plan::{self, Plan};
use super::safety;
use super::tables::OfScene;
use super::variants::{Change, Variant};
use crate::error::Error;
use crate::experiment::pool;
use crate::report::content::table::{Cell, Table, table};
use crate::report::numbers::{brief, short};

/// Name of the table in the folder of a run.
pub const NAME: &str = "convergence.csv";
/// Times at which states of the paper's levee are compared, h on the clock of the scene; other scenes halfway and at their end.
const HOURS: [f64; 2] = [14.0, 18.0];
/// Edges of cells as shares of the scene's; the last only where long runs are asked for.
const CELLS: [f64; 3] = [2.0, 1.0, 0.5];
const PER_CELL: [i64; 2] = [4, 9];

/// One number of one mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// What it is: `level`, `factor` or `trouble`.
    pub quantity: String,
    /// Time on the clock of the scene, h, where there is one.
    pub time_h: Option<f64>,
    /// Place, m, where there is one.
    pub x_m: Option<f64>,
    /// Edge of a cell, m.
    pub cell_m: f64,
    /// Particles per cell.
    pub particles_per_cell: usize,
    /// In m, or as a factor; none if there is no such number.
    pub value: Option<f64>,
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

/// Looks at the scene, or a variant of it, on meshes of twice and once (and with `full` half) its cells, `jobs` at a time. None takes
/// another down.
///
/// # Errors
/// What was expected of the scene and found.
pub fn compute(
    (source, variant): (&str, Option<&Variant>),
    flags: &Flags,
    full: bool,
    jobs: usize,
    tell: &(dyn Fn(&str) + Sync),
) -> Result<Vec<Line>, Error> {
    if let Some(variant) = variant.filter(|v| matches!(v.change, Change::Mesh(_) | Change::Particles(_))) {
        return Err(Error::refused("--convergence", "no variant of the mesh beside it", variant.name));
    }
    let base = Plan::new(plan::scene(source, flags, variant)?, None, None, false)?;
    let times = if base.papers() { HOURS } else { [0.5 * (base.starts_h() + base.ends_h()), base.ends_h()] };
    if let Some(late) = times.into_iter().find(|hour| !(*hour >= base.starts_h() && *hour <= base.ends_h())) {
        let expected = format!("a scene that includes {late} h on its clock");
        let clock = format!("a scene from {} to {} h", base.starts_h(), base.ends_h());
        return Err(Error::refused("--convergence", expected, clock));
    }
    let word = base.scene_word();
    let cells = if full { &CELLS[..] } else { &CELLS[..2] };
    let mut plans = Vec::new();
    // The longest first: none of the others waits for it at the end.
    for share in cells.iter().rev() {
        for count in PER_CELL.into_iter().rev() {
            let flags = Flags { cell: Some(share * base.scene.cell), particles_per_cell: Some(count), ..flags.clone() };
            plans.push(Plan::new(plan::scene(source, &flags, variant)?, None, None, false)?);
        }
    }
    let (count, mut done) = (plans.len(), 0);
    let told = |number: usize, _: &Result<_, Error>| {
        done += 1;
        let scene = &plans[number].scene;
        tell(&format!("{done}/{count} cells of {} m, {} per cell", scene.cell, scene.particles_per_cell));
    };
    let found = pool::each(jobs, &plans, |_, plan| of(plan, &times, &word), told);
    Ok(found.into_iter().collect::<Result<Vec<_>, Error>>()?.into_iter().rev().flatten().collect())
}

fn of(plan: &Plan, times: &[f64; 2], scene: &str) -> Vec<Line> {
    let line = |quantity: &str, time_h: Option<f64>, x_m: Option<f64>, value: Option<f64>| Line {
        quantity: quantity.to_owned(),
        time_h,
        x_m,
        cell_m: plan.scene.cell,
        particles_per_cell: plan.scene.particles_per_cell,
        value,
        why: String::new(),
        scene: scene.to_owned(),
    };
    let trouble = |why: &dyn ToString| Line { why: why.to_string(), ..line("trouble", None, None, None) };
    let mut lines = Vec::new();
    match safety::compute(plan, times, 1, &|_| ()) {
        Ok(factors) => {
            for found in &factors {
                for (x, level) in plan.levels().iter().zip(&found.levels_m) {
                    lines.push(line("level", Some(found.time_h), Some(*x), Some(*level)));
                }
                lines.push(line("factor", Some(found.time_h), None, Some(found.davis()).filter(|f| f.is_finite())));
            }
        }
        Err(why) => lines.push(trouble(&why)),
    }
    lines
}

/// A rule: quantity, its unit, what may differ and between which meshes.
struct Rule {
    quantity: &'static str,
    words: &'static str,
    unit: &'static str,
    allowed: f64,
    /// Between cells of a half and a quarter alone, with the same particles per cell.
    finest: bool,
}

const RULES: [Rule; 3] = [
    Rule { quantity: "level", words: "water levels", unit: "m", allowed: 0.02, finest: false },
    Rule { quantity: "factor", words: "factor of safety", unit: "–", allowed: 0.05, finest: false },
    Rule { quantity: "factor", words: "factor of safety", unit: "–", allowed: 0.02, finest: true },
];

impl Rule {
    /// Largest difference between two numbers of the same thing; none if there are no two.
    fn differ(&self, lines: &[Line], coarsest: f64) -> Option<f64> {
        let own: Vec<&Line> = lines.iter().filter(|l| l.quantity == self.quantity && l.value.is_some()).collect();
        let mut most = None;
        for (k, a) in own.iter().enumerate() {
            for b in &own[k + 1..] {
                let same = a.time_h == b.time_h && a.x_m == b.x_m;
                let fine = |l: &Line| l.cell_m < 0.75 * coarsest;
                let asked = !self.finest || (a.particles_per_cell == b.particles_per_cell && fine(a) && fine(b));
                if let (true, true, Some(x), Some(y)) = (same, asked, a.value, b.value) {
                    most = Some((x - y).abs().max(most.unwrap_or(0.0)));
                }
            }
        }
        most
    }
}

/// Tables for the page: the numbers, and what of them agrees.
pub fn shown(lines: &[Line]) -> Vec<Table> {
    let mut meshes: Vec<(f64, usize)> = lines.iter().map(|l| (l.cell_m, l.particles_per_cell)).collect();
    meshes.dedup();
    let titles: Vec<String> = meshes.iter().map(|(cell, count)| format!("{} m, {count}", short(*cell, 2))).collect();
    let head: Vec<&str> = std::iter::once("").chain(titles.iter().map(String::as_str)).collect();
    let mut things: Vec<&Line> = Vec::new();
    for line in lines.iter().filter(|l| l.quantity != "trouble") {
        if !things.iter().any(|t| is_same(t, line)) {
            things.push(line);
        }
    }
    let row = |thing: &&Line| {
        let mut cells = vec![Cell::new(named(thing))];
        cells.extend(meshes.iter().map(|mesh| {
            let mut own = lines.iter().filter(|l| is_same(l, thing) && (l.cell_m, l.particles_per_cell) == *mesh);
            Cell::new(own.next().and_then(|l| l.value).map_or_else(|| "–".to_owned(), |v| short(v, 3)))
        }));
        cells
    };
    let troubles: Vec<String> = lines
        .iter()
        .filter(|l| l.quantity == "trouble")
        .map(|l| format!(" Cells of {} m, {} per cell: {}.", l.cell_m, l.particles_per_cell, l.why))
        .collect();
    let note = format!(
        "Columns: cell size and particles per cell. Levels and factors of safety are those of soil held at rest until then.{}",
        troubles.concat()
    );
    let coarsest = lines.iter().map(|l| l.cell_m).fold(0.0, f64::max);
    let verdicts = RULES.iter().map(|rule| {
        let between = if rule.finest { "the two finest of three meshes" } else { "all meshes" };
        let found = rule.differ(lines, coarsest);
        let (verdict, mark) = match found {
            Some(off) if off <= rule.allowed => ("passed", "good"),
            Some(_) => ("failed", "bad"),
            None => ("not run", ""),
        };
        vec![
            Cell::new(rule.words).marked(between, ""),
            Cell::new(found.map_or_else(|| "–".to_owned(), |off| short(off, 3))),
            Cell::new(short(rule.allowed, 2)),
            Cell::new(rule.unit),
            Cell::new(verdict).marked("", mark),
        ]
    });
    let head_of_verdicts = ["between meshes", "largest difference", "tolerance", "unit", "verdict"];
    vec![
        table("Meshes".to_owned(), &head, things.iter().map(row).collect(), &note),
        table("Convergence".to_owned(), &head_of_verdicts, verdicts.collect(), "From the table above."),
    ]
}

fn is_same(a: &Line, b: &Line) -> bool {
    (&a.quantity, a.time_h, a.x_m) == (&b.quantity, b.time_h, b.x_m)
}

fn named(line: &Line) -> String {
    let at = line.time_h.map_or_else(String::new, |h| format!(" at {} h", brief(h, 4)));
    let place = line.x_m.map_or_else(String::new, |x| format!(", x = {} m", brief(x, 3)));
    match line.quantity.as_str() {
        "level" => format!("level (m){at}{place}"),
        _ => format!("factor of safety{at}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(quantity: &str, cell_m: f64, particles_per_cell: usize, value: f64) -> Line {
        Line {
            quantity: quantity.to_owned(),
            time_h: None,
            x_m: None,
            cell_m,
            particles_per_cell,
            value: Some(value),
            why: String::new(),
            scene: String::new(),
        }
    }

    fn verdicts(lines: &[Line]) -> Vec<String> {
        shown(lines)[1].rows.iter().map(|row| row[4].text.clone()).collect()
    }

    #[test]
    fn numbers_that_are_too_far_apart_fail() {
        let agree = vec![line("factor", 0.4, 9, 1.035), line("factor", 0.2, 9, 1.0), line("factor", 0.1, 9, 0.99)];
        // No levels.
        assert_eq!(verdicts(&agree), ["not run", "passed", "passed"]);
        let mut apart = agree.clone();
        apart[2].value = Some(0.975);
        assert_eq!(verdicts(&apart), ["not run", "failed", "failed"]);
        // Other particles are no other mesh.
        apart[2].particles_per_cell = 4;
        assert_eq!(verdicts(&apart)[2], "not run");
    }

    #[test]
    fn a_scene_that_ends_before_the_times_is_refused() {
        let (_, text) = crate::scenes::BUILT_IN.iter().find(|(name, _)| *name == "levee").expect("the levee");
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("short.toml");
        std::fs::write(&path, text.replace("until.time = 64800.0", "until.time = 30000.0")).expect("a scene");
        let source = path.display().to_string();
        let mesh = super::super::variants::named("mesh-0.2");
        let error = compute(("levee", mesh), &Flags::default(), false, 1, &|_| ()).expect_err("refused");
        assert!(error.to_string().ends_with("found mesh-0.2"), "{error}");
        let error = compute((&source, None), &Flags::default(), false, 1, &|_| ()).expect_err("refused");
        assert!(
            error.to_string().starts_with("--convergence: expected a scene that includes 18 h on its clock, found"),
            "{error}"
        );
    }
}

//! The page of a slope: its factors, how it slides, and where limit equilibrium has it slide.

use std::fs;
use std::path::Path;

use mpm_core::scene::Scene;

use super::equilibrium::Factors as Slices;
use super::{Factors, RULES};
use crate::error::Error;
use crate::manifest::Manifest;
use crate::page::site::{Kind, Report};
use crate::page::table::{Cell, Table};
use crate::page::{Block, Page, Section};
use crate::report::numbers::exact;
use crate::report::plots::field::{Field, Line, OUTLINE, SURFACE, figure, write as draw};
use crate::report::plots::look::{BLACK, Dash, GREY, Look, Marker, PURPLE};
use crate::report::{ReportError, tables, unwritable};

/// Its circle by Spencer's method, and the surface of any shape.
const CIRCLE: Look = Look::new(BLACK, Marker::Dot).width(2.0).dash(Dash::Dashed);
const ANY: Look = Look::new(PURPLE, Marker::Dot).width(2.0);
/// Least shear rate that is drawn, over the largest.
const FAINT: f64 = 0.04;
const LAYER: Look = Look::new(GREY, Marker::Dot).width(1.0);

/// All about a slope at one time.
#[derive(Debug)]
pub struct Shown<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Strength reduction.
    pub found: &'a Factors,
    /// Limit equilibrium with the strength and with Davis', or why there is none.
    pub slices: &'a Result<[Slices; 2], Error>,
    /// Water level (x, y), m.
    pub level: &'a [[f64; 2]],
    /// Conditions of the run.
    pub manifest: &'a Manifest,
}

/// A factor of safety in words: `1.02`, or the end that was found.
pub fn said(found: &mpm_core::failure::Bracket) -> String {
    match (found.low, found.high) {
        (low, high) if !high.is_finite() => format!("above {low:.2}"),
        (low, high) if low <= 0.0 => format!("below {high:.2}"),
        (low, high) => format!("{:.2}", 0.5 * (low + high)),
    }
}

impl Shown<'_> {
    /// The result in a sentence.
    pub fn lead(&self) -> String {
        let [davis, associated, given] = self.found.found.each_ref().map(|found| said(&found.bracket));
        let slices = match self.slices {
            Ok([full, davis]) => {
                let text = |f: Option<f64>| f.map_or_else(|| "none".to_owned(), |f| format!("{f:.2}"));
                format!(
                    " Spencer's method: {} on a circle, {} on a surface of any shape; with Davis' strength {} and {}.",
                    text(full.spencer),
                    text(full.any_shape),
                    text(davis.spencer),
                    text(davis.any_shape)
                )
            }
            Err(_) => String::new(),
        };
        format!(
            "Factor of safety {davis} by strength reduction with Davis' strength, {associated} with associated flow; with the dilation of \
             the scene {given}, which depends on the mesh.{slices}"
        )
    }

    /// Methods and factors.
    fn methods(&self) -> Table {
        let reduction = RULES.iter().zip(&self.found.found).map(|((_, name), found)| {
            let b = &found.bracket;
            let undecided =
                b.undecided.map_or_else(String::new, |[low, high]| format!(", undecided from {low:.3} to {high:.3}"));
            let small = format!("{:.3} to {:.3}{undecided}; {} trials, {} steps", b.low, b.high, b.trials, b.steps);
            vec![Cell::new(format!("strength reduction, {name}")), Cell::new(said(b)).marked(small, "")]
        });
        let mut rows: Vec<Vec<Cell>> = reduction.collect();
        if let Ok(all) = self.slices {
            for (factors, strength) in all.iter().zip(["", ", Davis' strength"]) {
                let methods = [
                    ("Bishop", factors.bishop),
                    ("Spencer", factors.spencer),
                    ("Morgenstern-Price", factors.morgenstern_price),
                    ("Spencer, surface of any shape", factors.any_shape),
                ];
                rows.extend(methods.into_iter().filter_map(|(name, factor)| {
                    Some(vec![Cell::new(format!("{name}{strength}")), Cell::new(format!("{:.3}", factor?))])
                }));
            }
        }
        let note = match self.slices {
            Ok(_) => "Slides at least a tenth of the height deep. Slices: circles of the least factor; Morgenstern-Price with half a sine on \
                      Spencer's circle; any shape: ten pieces, from the circle and from the lower edges of the regions."
                .to_owned(),
            Err(why) => format!("Slides at least a tenth of the height deep. No limit equilibrium: {why}."),
        };
        Table::new("Factor of safety", &["method", "factor"], rows, &note)
    }

    /// The trials of the headline.
    fn trials(&self) -> Table {
        let row = |name: &str, trial: &mpm_core::failure::Trial| {
            vec![
                Cell::new(name.to_owned()),
                Cell::new(format!("{:.4}", trial.factor)),
                Cell::new(trial.outcome.to_string()),
                Cell::new(trial.steps.to_string()),
                Cell::new(format!("{:.1e}", trial.speed)),
                Cell::new(format!("{:.1e}", trial.stored)),
            ]
        };
        let all = RULES.iter().zip(&self.found.found);
        let rows = all.flat_map(|((_, name), found)| found.trials.iter().map(move |trial| row(name, trial))).collect();
        let note = "Speed of the slide in g over damping; elastic energy stored in the second half of the time over the work of gravity. A slide \
                    is steady: its speed stays, and nothing is stored.";
        Table::new("Trials", &["flow rule", "factor", "outcome", "steps", "speed", "stored"], rows, note)
    }

    /// How it slides.
    fn map(&self) -> Field {
        let [davis, ..] = &self.found.found;
        let most = davis.mechanism.iter().map(|p| p.shear_rate).fold(0.0, f64::max);
        // What hardly shears is left out: the slide stands out on white.
        let shown = |rate: f64| if rate < FAINT { f64::NAN } else { rate };
        let mut lines: Vec<Line> = Vec::new();
        let closed = |points: &[[f64; 2]]| points.iter().chain(points.first()).map(|x| (x[0], x[1])).collect();
        let line = |label: &str, look: Look, points: Vec<(f64, f64)>| Line { label: label.to_owned(), look, points };
        lines.extend(self.scene.regions.iter().map(|region| line("soils", LAYER, closed(&region.polygon))));
        lines.push(line("ground", OUTLINE, closed(&self.scene.outline_or_box())));
        let wet: Vec<(f64, f64)> = self.level.iter().filter(|x| x[1] > 0.0).map(|x| (x[0], x[1])).collect();
        if !wet.is_empty() {
            lines.push(line("water level", SURFACE, wet));
        }
        if let Ok([full, _]) = self.slices {
            let [circle, any] =
                full.surfaces.each_ref().map(|points| points.iter().map(|x| (x[0], x[1])).collect::<Vec<_>>());
            lines.push(line("Spencer, circle", CIRCLE, circle));
            if !any.is_empty() {
                lines.push(line("Spencer, any shape", ANY, any));
            }
        }
        Field {
            name: "mechanism",
            title: "How the slope slides".to_owned(),
            caption: format!(
                "Rate of the deviator strain over its largest value (above {FAINT}), with Davis' strength divided by {:.3}: where the soil shears. \
                 Lines: slip surfaces of the least factor by limit equilibrium.",
                davis
                    .trials
                    .iter()
                    .filter(|t| t.outcome == mpm_core::failure::Outcome::Slides)
                    .map(|t| t.factor)
                    .fold(f64::NAN, f64::min)
            ),
            quantity: "shear rate (-)".to_owned(),
            column: "relative_shear_rate",
            range: Some((0.0, 1.0)),
            spacing: self.scene.spacing(),
            starts: Vec::new(),
            points: davis.mechanism.iter().map(|p| [p.x[0], p.x[1], shown(p.shear_rate / most)]).collect(),
            lines,
        }
    }

    /// Writes page, picture and tables.
    ///
    /// # Errors
    /// A file that cannot be written or drawn.
    pub fn write(&self, folder: &Path) -> Result<(), ReportError> {
        let plots = folder.join("plots");
        fs::create_dir_all(&plots).map_err(|e| unwritable(&plots, e))?;
        let trials = RULES.iter().zip(&self.found.found).flat_map(|((_, name), found)| {
            found.trials.iter().map(move |t| {
                let numbers =
                    [exact(t.factor), t.outcome.to_string(), t.steps.to_string(), exact(t.speed), exact(t.stored)];
                [vec![(*name).to_owned()], numbers.to_vec()].concat()
            })
        });
        tables::table(&folder.join("trials.csv"), "flow_rule,factor,outcome,steps,speed,stored", trials)?;
        let reduction = RULES.iter().zip(&self.found.found).map(|((_, name), found)| {
            vec![format!("strength reduction, {name}"), exact(found.bracket.low), exact(found.bracket.high)]
        });
        let slices = self.slices.iter().flatten().zip(["", ", Davis"]).flat_map(|(f, strength)| {
            let methods = [
                ("Bishop", f.bishop),
                ("Spencer", f.spencer),
                ("Morgenstern-Price", f.morgenstern_price),
                ("any shape", f.any_shape),
            ];
            methods
                .into_iter()
                .filter_map(move |(name, f)| Some(vec![format!("{name}{strength}"), exact(f?), exact(f?)]))
        });
        tables::table(&folder.join("factors.csv"), "method,fs_low,fs_high", reduction.chain(slices))?;
        let map = self.map();
        let mut page = Page::new(format!("Factor of safety: {}", self.scene.name))
            .lead(self.lead())
            .warnings(super::warnings(self.scene));
        if !map.points.is_empty() {
            draw(&map, &plots)?;
            page = page.section(Section::new("mechanism", "How it slides").figure(&figure(&map)));
        }
        let command = self.manifest.entries().into_iter().find(|(name, _)| *name == "command");
        let again = command.map_or_else(Vec::new, |(_, command)| vec![Block::Command(command)]);
        let again = again.into_iter().fold(Section::new("again", "Run it again"), Section::with);
        page.section(Section::new("factors", "Factors").tables([self.methods()]))
            .section(Section::new("trials", "Trials").folded().tables([self.trials()]))
            .section(again.files(["factors.csv", "trials.csv", "plots/mechanism.csv"]))
            .conditions(self.manifest)
            .report(
                Report::new(Kind::Scene).picture("plots/mechanism.png", "Where the soil shears when the slope slides"),
            )
            .write(&folder.join("index.html"))
    }
}

//! `[failure]`, and a stage with `clock = "both"`: what they need and what they do not go together with.

use toml::Spanned;

use super::super::raw::RawScene;
use super::super::{Clock, Dimension, Failure, Integrator, Scene, SolidSide, Until};
use super::{Checked, Reader, quoted};
use crate::seeding;

/// Fewest cells over the height of soil that may fail, and fewest along the foot of its slope per cell of height.
const LEAST_CELLS: f64 = 4.0;

impl Reader<'_> {
    /// How failure is followed, in a scene with a stage for it.
    pub(super) fn failure(&self, raw: &RawScene, scene: &Scene) -> Checked<Option<Failure>> {
        let stages = raw.stages.get_ref();
        let both = stages.iter().zip(&scene.stages).find(|(_, stage)| stage.clock == Clock::Both);
        let Some((stage, checked)) = both else {
            if let Some(table) = &raw.failure {
                let expected = "a stage with clock = \"both\" beside it";
                return self.refuse(&table.span(), "failure", expected, "none");
            }
            return Ok(None);
        };
        let word = stage.get_ref().clock.as_ref().map_or(stage.span(), Spanned::span);
        if stages.len() != 1 {
            let expected = "one stage with clock = \"both\": gravity and the first water are part of it";
            return self.refuse(&word, "stages.clock", expected, format!("{} stages", stages.len()));
        }
        if !matches!(checked.until, Until::Time(_)) {
            let expected = "a time (s) beside clock = \"both\"";
            return self.refuse(&stage.get_ref().until.span(), "stages.until", expected, "another end");
        }
        if scene.dimension != Dimension::PlaneStrain || scene.gravity.is_none() || scene.slope_angle.is_some() {
            let expected = "dimension = \"plane-strain\" and gravity, with a level base, beside clock = \"both\"";
            return self.refuse(&word, "stages.clock", expected, "another scene");
        }
        if scene.solid_sides[3] != SolidSide::Free {
            let expected = "boundaries.top = \"free\" beside clock = \"both\"";
            return self.refuse(&word, "stages.clock", expected, "a held top");
        }
        let cells = scene.height / scene.cell;
        if cells < LEAST_CELLS {
            let expected = format!(
                "a cell of at most {} m: a slope needs {LEAST_CELLS} cells over its height",
                scene.height / LEAST_CELLS
            );
            return self.refuse(&raw.mesh.get_ref().cell.span(), "mesh.cell", &expected, scene.cell);
        }
        let Some(table) = &raw.failure else { return Ok(Some(Failure::default())) };
        let table = table.get_ref();
        let starts_at = match &table.starts_at {
            Some(value) => self.within(value, "failure.starts_at", "a time of 0 or more (s)", |t| t >= 0.0)?,
            None => 0.0,
        };
        let mut points = Vec::new();
        let soil = scene.outline_or_box();
        for point in table.points.as_ref().map_or(&[][..], |points| points.get_ref()) {
            let [x, y] = *point.get_ref();
            if !seeding::near(&soil, &[x, y], 1e-9 * (scene.width + scene.height)) {
                let expected = "a place in the soil [x, y] (m)";
                return self.refuse(&point.span(), "failure.points", expected, format!("[{x}, {y}]"));
            }
            points.push([x, y]);
        }
        let mut levels = Vec::new();
        for x in table.levels.as_ref().map_or(&[][..], |levels| levels.get_ref()) {
            let expected = format!("0 <= x <= {} m, the width of the soil", scene.width);
            levels.push(self.within(x, "failure.levels", &expected, |x| (0.0..=scene.width).contains(&x))?);
        }
        Ok(Some(Failure { levels, starts_at, goes_on: table.goes_on.unwrap_or(false), points }))
    }

    /// A stage that may fail is the only one in which soil and water run in the same steps.
    pub(super) fn driver(&self, raw: &RawScene, scene: &Scene) -> Checked<()> {
        let word = raw.time.as_ref().and_then(|time| time.get_ref().integrator.as_ref());
        if let (Some(word), Integrator::Coupled, false) = (word, scene.integrator, scene.may_fail()) {
            let expected = "a stage with clock = \"both\" beside it";
            return self.refuse(&word.span(), "time.integrator", expected, quoted(word.get_ref()));
        }
        Ok(())
    }
}

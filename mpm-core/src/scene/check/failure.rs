//! `[failure]`, and a stage with `coupling = "full"`: what they need and what they do not go together with.

use toml::Spanned;

use super::super::raw::RawScene;
use super::super::{Coupling, Failure, Fields, Side, SolidSide};
use super::free_surface::touching;
use super::{Checked, Reader, quoted};
use crate::seeding;

/// Fewest cells over the height of soil that may fail.
const LEAST_CELLS: f64 = 4.0;

impl Reader<'_> {
    /// How failure is followed, in a scene with a stage for it.
    pub(super) fn failure(&self, raw: &RawScene, scene: &Fields) -> Checked<Option<Failure>> {
        let stages = raw.stages.get_ref();
        let both = stages.iter().zip(&scene.stages).find(|(_, stage)| stage.coupling == Coupling::Full);
        let Some((stage, _)) = both else {
            if let Some(table) = &raw.failure {
                let expected = "a stage with coupling = \"full\" with it";
                return self.refuse(&table.span(), "failure", expected, "none");
            }
            return Ok(None);
        };
        let word = stage.get_ref().coupling.as_ref().map_or(stage.span(), Spanned::span);
        if stages.len() != 1 {
            let expected = "one stage with coupling = \"full\": gravity and the first water are part of it";
            return self.refuse(&word, "stages.coupling", expected, format!("{} stages", stages.len()));
        }
        let cells = scene.height / scene.cell;
        if cells < LEAST_CELLS {
            let expected = format!("at least {LEAST_CELLS} cells over the height of a slope");
            let most = scene.height / LEAST_CELLS;
            return self
                .refuse(&raw.mesh.get_ref().cell.span(), "mesh.cell", &expected, format!("{} m", scene.cell))
                .map_err(|fault| fault.with(format!("a cell of at most {most} m")));
        }
        self.dry_crest(raw, scene)?;
        self.base_that_holds(raw, scene)?;
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
            let level = self.within(x, "failure.levels", "0 <= x <= the width of the soil (m)", |x| {
                (0.0..=scene.width).contains(&x)
            });
            levels.push(level.map_err(|fault| fault.with(format!("width {} m", scene.width)))?);
        }
        Ok(Some(Failure {
            levels,
            starts_at,
            continue_if_unstable: table.continue_if_unstable.unwrap_or(false),
            continue_after_collapse: table.continue_after_collapse.unwrap_or(false),
            points,
        }))
    }

    /// Water stays below the crest: what would flow over it, or stand on it, no step knows.
    fn dry_crest(&self, raw: &RawScene, scene: &Fields) -> Checked<()> {
        let feeds = raw.water.as_ref().and_then(|water| water.get_ref().free_surface.as_ref());
        let Some(feeds) = feeds.and_then(|table| table.get_ref().feed.as_ref()).map(Spanned::get_ref) else {
            return Ok(());
        };
        let soil = scene.outline_or_box();
        for (side, feed) in [
            (Side::Left, &feeds.left),
            (Side::Right, &feeds.right),
            (Side::Bottom, &feeds.bottom),
            (Side::Top, &feeds.top),
        ] {
            let Some(feed) = feed else { continue };
            let Some([_, high]) = touching(&soil, side, scene) else { continue };
            let key = format!("water.free_surface.feed.{side}");
            if side != Side::Top && scene.solid_sides[side as usize] == SolidSide::Free {
                let expected = format!(
                    "boundaries.{side} = \"roller\" or \"fixed\" with it: soil that may fail is supported there"
                );
                return self.refuse(&feed.span(), &key, &expected, quoted("free"));
            }
            let given = [("head", &feed.get_ref().head), ("height", &feed.get_ref().height)];
            for (word, value) in given {
                let Some(value) = value else { continue };
                if side == Side::Top && word == "head" {
                    let expected = "a velocity (m/s) with coupling = \"full\": no water may pond on soil that may fail";
                    return self.refuse(&value.span(), &format!("{key}.{word}"), expected, value.get_ref());
                }
                // What presses from below may stand higher.
                if side != Side::Bottom && *value.get_ref() > high * (1.0 + 1e-9) {
                    let expected =
                        "at most the top of the soil at this side (m): more would flow over soil that may fail";
                    return self
                        .refuse(&value.span(), &format!("{key}.{word}"), expected, value.get_ref())
                        .map_err(|fault| fault.with(format!("top {high} m")));
                }
            }
        }
        Ok(())
    }

    /// On a base with no strength at all no slope stands.
    fn base_that_holds(&self, raw: &RawScene, scene: &Fields) -> Checked<()> {
        let (Some(table), Some(base)) = (&raw.base, scene.base) else { return Ok(()) };
        if base.peak_angle > 0.0 || base.adhesion > 0.0 {
            return Ok(());
        }
        let (key, value) = match (&table.get_ref().friction_angle, &table.get_ref().peak_angle) {
            (Some(value), _) => ("base.friction_angle", value),
            (None, Some(value)) => ("base.peak_angle", value),
            (None, None) => return Ok(()),
        };
        let expected =
            "0 < angle < 90 (degrees), or an adhesion, with coupling = \"full\": no slope is stable on a smooth base";
        self.refuse(&value.span(), key, expected, value.get_ref())
    }
}

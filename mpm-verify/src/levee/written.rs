//! Everything that a run leaves in its folder.

use std::fs;
use std::path::Path;

use mpm_core::failure::towards;

use super::claims::{self, Evidence};
use super::page::{self, Parts};
use super::plan::Plan;
use super::ranges::Ranges;
use super::run::Followed;
use super::strength::Strength;
use super::summary::Summary;
use super::{convergence, drivers, ensemble, figures, probability, safety, sensitivity, story, tables, validation};
use crate::frames;
use crate::report::animation::{Player, looping};
use crate::report::{ReportError, save, unwritable, vtk};

/// Writes tables, summary, claims, frames, pictures, moving image and page; files for ParaView if asked for. Factors of
/// safety, variants, meshes and drivers of this scene whose tables are in the folder `known` are shown too.
///
/// # Errors
/// A file that cannot be written or drawn.
pub fn write(
    plan: &Plan,
    run: &Followed,
    summary: &Summary,
    with_vtk: bool,
    (known, folder): (&Path, &Path),
) -> Result<(), ReportError> {
    tables::write(&run.rows, &run.paths, &run.events, plan.levels(), folder)?;
    let path = folder.join("summary.json");
    let text = serde_json::to_string_pretty(summary).map_err(|e| unwritable(&path, e))?;
    save(&path, text + "\n")?;
    let scene = &plan.scene;
    // The paper and the experiment speak of their levee alone.
    let claims = plan.papers().then(|| {
        claims::judge(&Evidence {
            ended: &run.ended,
            rows: &run.rows,
            paths: &run.paths,
            events: &run.events,
            shots: &run.shots,
            strength: Strength::of(scene),
            toe_m: scene.width,
        })
    });
    if let Some(claims) = &claims {
        claims::write(claims, folder)?;
    }
    let path = folder.join("frames.bin");
    frames::write(&run.shots, &path).map_err(|e| unwritable(&path, std::io::Error::other(e)))?;
    let plots = folder.join("plots");
    fs::create_dir_all(&plots).map_err(|e| unwritable(&plots, e))?;
    let mut pictures = figures::write(plan, run, &plots)?;
    let (word, mut others) = (plan.scene_word(), Vec::new());
    let factors: Vec<safety::Line> = tables::stored(&known.join(safety::NAME), &word, &mut others)?;
    let variants: Vec<sensitivity::Line> = tables::stored(&known.join(sensitivity::NAME), &word, &mut others)?;
    let drivers: Vec<drivers::Line> = tables::stored(&known.join(drivers::NAME), &word, &mut others)?;
    let meshes: Vec<convergence::Line> = tables::stored(&known.join(convergence::NAME), &word, &mut others)?;
    let runs: Vec<ensemble::Line> = tables::stored(&known.join(ensemble::NAME), &word, &mut others)?;
    let samples: Vec<probability::Line> = tables::stored(&known.join(probability::NAME), &word, &mut others)?;
    let mut further = Vec::new();
    let why = safety::why_earlier(scene, &factors, run.events.raveling_h, &variants).unwrap_or_default();
    if !factors.is_empty() {
        pictures.push(safety::picture(&factors, Some(&run.events), &why, &plots)?);
        further.push(safety::shown(&factors));
    }
    if !runs.is_empty() {
        further.push(ensemble::shown(&runs));
    }
    if !samples.is_empty() {
        pictures.push(probability::picture(&samples, &figures::events(&run.events), &plots)?);
        further.push(probability::shown(&samples, &plan.scales()));
    }
    if plan.papers() {
        further.extend(validation::shown(&runs, &samples));
    }
    if !variants.is_empty() {
        pictures.push(sensitivity::picture(&variants, &plots)?);
        further.push(sensitivity::shown(&variants, &runs));
    }
    let site = figures::site(scene);
    let subject = if plan.papers() { "Seepage failure of a levee" } else { "Seepage and stability of a slope" };
    let happened = figures::events(&run.events);
    looping::write(subject, &site, &run.shots, &happened, &folder.join("levee.png"))?;
    if with_vtk {
        vtk::write(&run.shots, &folder.join("vtk"))?;
    }
    if !meshes.is_empty() {
        further.extend(convergence::shown(&meshes));
    }
    if !drivers.is_empty() {
        further.push(drivers::shown(&drivers));
    }
    let side = towards(&scene.outline_or_box());
    let first_toe = run.rows.first().map_or(0.0, |row| row.toe_x_m);
    let ranges = Ranges::of(&runs, &variants, [first_toe, side]);
    let player = match run.shots.is_empty() || run.rows.is_empty() {
        true => None,
        false => {
            let beside = story::of(plan, run, (&factors, &why), side);
            Some(Player::new(&site, &run.shots, &beside).map_err(|e| unwritable(&folder.join("index.html"), e))?)
        }
    };
    let claims = claims.as_deref();
    let (pictures, ranges, factors) = (&pictures, &ranges, &factors);
    page::write(
        Parts { plan, run, summary, ranges, factors, player, claims, pictures, further, others },
        (known, folder),
    )
}

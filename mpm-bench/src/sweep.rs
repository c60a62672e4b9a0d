//! All settings in mixed order, visit after visit.
//!
//! Another load on the machine comes and goes. Settings are visited in an order without rhyme, a different one each
//! time, so that it falls on no integrator more than on another, and the median over visits far apart forgets it.

use mpm_core::hash::sha256;
use mpm_core::scene::Scene;
use mpm_verify::error::Error;
use mpm_verify::manifest::{Manifest, short_hash};
use mpm_verify::progress::Progress;
use mpm_verify::study::plan::work;

use crate::kernel::kept::NAME;
use crate::plan::Plan;
use crate::row::Row;
use crate::setting::{Setting, Solver};
use crate::store::Store;

/// A setting that takes longer than this is visited once, s.
const DEAR: f64 = 1.5;
/// Rough time of an explicit point-step, s; for the progress bar alone.
const POINT_STEP: f64 = 8e-9;
/// Rough time of the shortest visit, s.
const VISIT: f64 = 1e-2;

/// Why a sweep ended early.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// A setting that cannot be run.
    #[error(transparent)]
    Setting(#[from] Error),
    /// The store cannot be written.
    #[error("store.jsonl: cannot be written: {0}")]
    Store(#[from] std::io::Error),
    /// What a step costs cannot be kept.
    #[error("{NAME}: cannot be written: {0}")]
    Kernel(#[source] std::io::Error),
}

/// Runs what the store does not have yet. Rows in the order of the plan.
///
/// # Errors
/// A setting that cannot be run, a store that cannot be written.
pub fn sweep(plan: &Plan, base: &Scene, store: &mut Store, progress: &Progress) -> Result<Vec<Row>, SweepError> {
    let total: f64 = plan.visits as f64 * plan.settings.iter().map(Setting::weight).sum::<f64>();
    let (mut done, mut said) = (0.0, 0);
    for visit in 0..plan.visits {
        let mut order: Vec<&Setting> = plan.settings.iter().collect();
        order.sort_by_key(|s| sha256(format!("{visit} {}", s.case).as_bytes()));
        for setting in order {
            setting.visit(visit, base, store)?;
            done += setting.weight();
            progress.set((1e6 * done / total) as u64);
            let tenth = (10.0 * done / total) as u64;
            if tenth > said {
                said = tenth;
                progress.line(&format!("{} % of about {total:.0} s", 10 * said));
            }
        }
    }
    Ok(plan.settings.iter().filter_map(|s| store.row(&s.case)).collect())
}

/// Which program measures: version, hash of the sources of `mpm-verify`, processor, and hash of the program itself.
pub fn build(manifest: &Manifest) -> String {
    let bytes = std::env::current_exe().and_then(std::fs::read).unwrap_or_default();
    format!("{} {} {} {}", manifest.version, manifest.sources, manifest.cpu, short_hash(&bytes))
}

impl Setting {
    fn visit(&self, visit: usize, base: &Scene, store: &mut Store) -> Result<(), SweepError> {
        let input = self.input();
        if store.visits(&self.case, &input) > visit {
            return Ok(());
        }
        if visit == 0 {
            let (found, times) = self.first_visit(base)?;
            return Ok(store.keep(&self.case, &input, Some(found), times)?);
        }
        if store.row(&self.case).is_some_and(|row| row.cpu_s > DEAR) {
            return Ok(());
        }
        Ok(store.keep(&self.case, &input, None, self.times())?)
    }

    /// Hash of all that the setting is made of.
    fn input(&self) -> String {
        short_hash(format!("{:?}", self.solver).as_bytes())
    }

    /// Rough time of a visit, s.
    fn weight(&self) -> f64 {
        match &self.solver {
            Solver::Points(scene) => VISIT + POINT_STEP * work(scene),
            Solver::Volumes(..) => VISIT,
        }
    }
}

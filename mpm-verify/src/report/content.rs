//! Tables and words of the pages of the study.

pub mod paper;
pub mod schemes;
pub mod table;
pub mod terms;

use super::Study;
use super::plots::figure::Figure;
use super::select::families;
use crate::study::{CaseResult, Variant, shown_family, word};

/// Failed runs named in warnings; the table of cases has all of them.
const NAMED: usize = 12;

/// A sentence per run that failed, one for all that were forced.
pub fn warnings(study: &Study) -> Vec<String> {
    let name = |r: &CaseResult| match r.variant {
        Variant::Base => r.case.clone(),
        other => format!("{} ({})", r.case, word(other)),
    };
    let mut failed: Vec<String> =
        study.results.iter().filter_map(|r| Some(format!("Failed: {}: {}", name(r), r.failure.as_ref()?))).collect();
    if failed.len() > NAMED {
        let more = failed.len() - NAMED;
        failed.truncate(NAMED);
        failed.push(format!("Failed: {more} more runs."));
    }
    let forced: Vec<&CaseResult> = study.results.iter().filter(|r| r.forced).collect();
    if let Some(worst) = forced.iter().max_by(|a, b| (a.dt_s / a.limit_s).total_cmp(&(b.dt_s / b.limit_s))) {
        let times = worst.dt_s / worst.limit_s;
        failed.push(format!(
            "Forced: {} of {} runs have a time step above the stability limit, up to {times:.2} times ({}).",
            forced.len(),
            study.results.len(),
            name(worst)
        ));
    }
    failed
}

/// What pictures and tables leave out.
pub fn missing(study: &Study, figures: &[Figure]) -> Vec<String> {
    let mut missing: Vec<String> = figures.iter().flat_map(|f| f.missing.clone()).collect();
    let base = study.results.iter().filter(|r| r.variant == Variant::Base);
    let left_out = base.filter(|r| r.failure.is_some()).count();
    if left_out > 0 {
        missing.insert(0, format!("{left_out} failed runs are left out of pictures and orders."));
    }
    let unknown = study.results.iter().filter(|r| r.failure.is_none() && r.max_error_terzaghi.is_nan());
    missing.extend(unknown.map(|r| format!("{}: no largest error, some sample times are not there.", r.case)));
    if let Some(shown) = shown_family(&study.results)
        && families(&study.results).len() > 1
    {
        missing.push(format!("Pictures and tables of one scheme show {shown}."));
    }
    missing
}

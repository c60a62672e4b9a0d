//! `report`: rebuild the report from a stored study.

use std::fs;
use std::path::Path;

use mpm_verify::report::{self, Study};

use super::{Failure, into_folder, say};
use crate::Common;

/// Reads `study.json` in a folder and writes the report beside it, or into `--out`.
pub fn run(folder: &Path, common: &Common) -> Result<(), Failure> {
    let path = folder.join("study.json");
    let refused = |e: String| Failure::BadInput(format!("{}: expected a stored study, found: {e}", path.display()));
    let text = fs::read_to_string(&path).map_err(|e| refused(e.to_string()))?;
    let study: Study = serde_json::from_str(&text).map_err(|e| refused(e.to_string()))?;
    let out = common.out.as_deref().unwrap_or(folder);
    let wrong = |e: report::ReportError| Failure::RunFailed(e.to_string());
    into_folder(out, |folder| {
        let page = report::write(&study, folder.stage(), out).map_err(wrong)?;
        folder.publish().map_err(|e| Failure::RunFailed(e.to_string()))?;
        page.save(out).map_err(wrong)
    })?;
    say(common.quiet, &format!("report: {}", out.parent().unwrap_or(out).join("index.html").display()));
    Ok(())
}

//! `report`: rebuild the report from a stored study.

use std::path::Path;

use mpm_core::scene::read_text;
use mpm_verify::report::{self, Study};

use super::{Failure, into_folder, say};
use crate::Common;

/// No stored study is larger, bytes.
const LARGEST: u64 = 1 << 30;

/// Reads `study.json` in a folder and writes the report beside it, or into `--out`.
pub fn run(folder: &Path, common: &Common) -> Result<(), Failure> {
    let path = folder.join("study.json");
    let refused = |e: String| Failure::BadInput(format!("{}: expected a stored study, found: {e}", path.display()));
    let text = read_text(&path, LARGEST).map_err(|e| refused(e.to_string()))?;
    let study: Study = serde_json::from_str(&text).map_err(|e| refused(e.to_string()))?;
    let out = common.out.as_deref().unwrap_or(folder);
    super::home_is_free(out)?;
    into_folder(out, &super::study::NAMES, |folder| {
        report::write(&study, folder.stage()).map_err(Failure::run_failed)
    })?;
    say(common.quiet, &format!("report: {}", out.join("index.html").display()));
    Ok(())
}

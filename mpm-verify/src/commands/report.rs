//! `report`: the report of a stored study, written again.

use std::path::Path;

use mpm_core::scene::read_text;
use mpm_verify::report::Study;

use super::{Failure, study};
use crate::Common;

/// Largest stored study, bytes.
const LARGEST: u64 = 1 << 30;

/// Reads `study.json` in a folder, and writes the report beside it or into `--out`.
pub fn run(folder: &Path, common: &Common) -> Result<(), Failure> {
    let path = folder.join("study.json");
    let refused = |e: String| Failure::BadInput(format!("{}: expected a stored study, found: {e}", path.display()));
    let text = read_text(&path, LARGEST).map_err(|e| refused(e.to_string()))?;
    let study: Study = serde_json::from_str(&text).map_err(|e| refused(e.to_string()))?;
    let out = common.out.as_deref().unwrap_or(folder);
    let common = Common { out: Some(out.to_owned()), ..common.clone() };
    super::home_is_free(out)?;
    common.publish("", &study::NAMES, |folder| study::write(&study, folder))?;
    common.json(&study.claims);
    common.say(&format!("{} runs and {} claims reported", study.results.len(), study.claims.len()));
    common.page(&out.join("index.html"));
    Ok(())
}

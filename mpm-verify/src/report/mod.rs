//! The report: tables, plots, and pages to read.
//!
//! # Reading order
//! 1. [`select`]: which cases tables and pictures are about. [`numbers`]: how numbers are written.
//! 2. [`orders`]: orders of convergence per group. [`tables`]: the CSV files. [`quantity`]: of the soil, for maps.
//! 3. [`plots`]: one file per picture; [`plots::figure`] is what a picture is made of.
//! 4. [`content`]: tables and words. [`study`]: the pages of the study; [`crate::page`] renders them.
//! 5. [`suite`]: the page of the verification suite. [`solved`]: the page of one scene. [`parameters`]: what a scene is made of. [`maps`]: its soil and its water. [`vtk`]: frames of a
//!    run for ParaView. [`animation`]: frames as a page that plays them.
//!
//! Every picture has its numbers in a CSV beside it, written from the same [`plots::figure::Figure`].

pub mod animation;
pub mod case;
pub mod content;
pub mod gallery;
pub mod maps;
pub mod numbers;
pub mod orders;
pub mod parameters;
pub mod plots;
pub mod quantity;
pub mod select;
pub mod solved;
pub mod stress;
pub mod study;
pub mod suite;
pub mod tables;
#[cfg(test)]
pub(crate) mod tests;
pub mod vtk;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::budget::Budget;
use crate::claims::{Claim, Judgement};
use crate::cost::Cost;
use crate::manifest::Manifest;
use crate::study::CaseResult;
use crate::sweeps::Sweeps;

/// Everything a report is made of; stored as `study.json`.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Study {
    /// Under which conditions the study was run.
    pub manifest: Manifest,
    /// All runs, with the further ones that the budget needs.
    pub results: Vec<CaseResult>,
    /// Parts of the error, per case and time factor, as shares of U.
    pub budgets: Vec<Budget>,
    /// The paper's statements with their verdicts.
    pub claims: Vec<Claim>,
    /// The same statements judged on other integrators.
    #[serde(default)]
    pub other_claims: Vec<Judgement>,
    /// Displaced particles, offsets of the mesh, errors in time; empty where they were not run.
    #[serde(default)]
    pub sweeps: Sweeps,
    /// What a step costs along several paths; empty where it was not measured.
    #[serde(default)]
    pub costs: Vec<Cost>,
    /// What else a reader should know.
    pub notes: Vec<String>,
}

/// Why a report could not be written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A folder or file cannot be written.
    #[error("{}: cannot be written: {cause}", path.display())]
    Write {
        /// Which.
        path: PathBuf,
        /// Why not.
        #[source]
        cause: io::Error,
    },
    /// A stored table is not what it should be.
    #[error("{}: expected a table that this program wrote, found: {cause}", path.display())]
    Read {
        /// Which.
        path: PathBuf,
        /// What is wrong.
        #[source]
        cause: csv::Error,
    },
    /// A picture cannot be drawn.
    #[error("{}: cannot be drawn: {cause}", path.display())]
    Draw {
        /// Which.
        path: PathBuf,
        /// Why not.
        #[source]
        cause: plots::canvas::DrawError,
    },
    /// The template of the page does not fit its content.
    #[error("{}: the page cannot be made: {cause}", path.display())]
    Page {
        /// Which.
        path: PathBuf,
        /// Why not.
        #[source]
        cause: minijinja::Error,
    },
}

/// A file or folder that cannot be written.
pub(crate) fn unwritable(path: &Path, cause: impl Into<io::Error>) -> ReportError {
    ReportError::Write { path: path.to_owned(), cause: cause.into() }
}

/// A text whose first letter is a capital, unless it begins with a symbol: `p/p_0`.
pub(crate) fn capital(text: &str) -> String {
    let first = text.split_whitespace().next().unwrap_or_default().trim_end_matches([',', ':']);
    if first.len() < 2 && first != "a" || !first.chars().all(|c| c.is_ascii_alphabetic() || c == '\'' || c == '-') {
        return text.to_owned();
    }
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Writes a text file.
pub(crate) fn save(path: &Path, text: impl AsRef<[u8]>) -> Result<(), ReportError> {
    fs::write(path, text).map_err(|e| unwritable(path, e))
}

/// Writes tables, plots, pages, `report.md` and `study.json` into a folder.
///
/// # Errors
/// A file that cannot be written or drawn, with its path.
pub fn write(study: &Study, folder: &Path) -> Result<(), ReportError> {
    let pictures = folder.join("plots");
    fs::create_dir_all(&pictures).map_err(|e| unwritable(&pictures, e))?;
    let stored = folder.join("study.json");
    save(&stored, serde_json::to_string(study).map_err(|e| unwritable(&stored, e))?)?;
    let conditions = folder.join("manifest.json");
    save(&conditions, serde_json::to_string_pretty(&study.manifest).map_err(|e| unwritable(&conditions, e))?)?;
    tables::write(study, folder)?;
    let figures = plots::figures(study);
    figures.iter().try_for_each(|figure| plots::write(figure, &pictures).map(drop))?;
    study::write(study, &figures, folder)
}

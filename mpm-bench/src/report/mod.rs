//! The report: what follows from a sweep, as tables, pictures and pages.
//!
//! # Reading order
//! 1. [`words`]: how settings, times and errors read. [`answers`]: the sentences that come first.
//! 2. [`section`]: what the pages say, one entry per section; a further section is one more entry.
//! 3. [`tables`], [`plots`]: what sections hold; [`kernel`] is a section by itself. 4. [`pages`]: HTML and Markdown.

pub mod answers;
pub mod kernel;
pub mod pages;
pub mod plots;
pub mod section;
pub mod tables;
pub mod words;

use std::fs;
use std::io;
use std::path::Path;

use mpm_verify::manifest::Manifest;
use mpm_verify::report::ReportError;
use mpm_verify::report::plots::write as draw;
use mpm_verify::report::tables::table;

use crate::baseline;
use crate::cheapest;
use crate::growth::{self, Growth, growths};
use crate::kernel::{Kernel, kept};
use crate::pareto::front;
use crate::peers::Peer;
use crate::row::{self, Row};

/// Everything a report is made of.
#[derive(Debug, Clone)]
pub struct Findings {
    /// Under which conditions.
    pub manifest: Manifest,
    /// Every setting that was run.
    pub rows: Vec<Row>,
    /// How cost grows as cells get smaller.
    pub growths: Vec<Growth>,
    /// What a step costs, where it was measured.
    pub kernel: Option<Kernel>,
    /// Other codes.
    pub peers: Vec<Peer>,
    /// What was left out and why.
    pub left_out: Vec<String>,
    /// What else a reader should know.
    pub notes: Vec<String>,
}

impl Findings {
    /// What follows from the rows of a sweep.
    pub fn new(
        manifest: Manifest,
        mut rows: Vec<Row>,
        peers: Vec<Peer>,
        left_out: Vec<String>,
        notes: Vec<String>,
    ) -> Self {
        // One front of this program's settings, one of the baseline.
        for of_baseline in [false, true] {
            let own = |r: &Row| baseline::is(&r.integrator) == of_baseline;
            let points: Vec<(f64, f64)> =
                rows.iter().filter(|r| own(r)).map(|r| (r.cpu_s, r.max_error_compressible)).collect();
            rows.iter_mut().filter(|r| own(r)).zip(front(&points)).for_each(|(row, on)| row.pareto = on);
        }
        let growths = growths(&rows);
        Self { manifest, rows, growths, kernel: None, peers, left_out, notes }
    }

    /// Reads the results of a sweep from its folder.
    ///
    /// # Errors
    /// A file of it cannot be read, or is not what it should be, with its path.
    pub fn read(folder: &Path, peers: Vec<Peer>, left_out: Vec<String>) -> Result<Self, ReportError> {
        let path = folder.join("speed_against_error.csv");
        let rows = csv::Reader::from_path(&path).and_then(|reader| reader.into_deserialize().collect());
        let rows: Vec<Row> = rows.map_err(|cause| ReportError::Read { path, cause })?;
        let path = folder.join("manifest.json");
        let manifest = fs::read(&path).and_then(|text| Ok(serde_json::from_slice(&text)?));
        let manifest = manifest.map_err(|cause| ReportError::Write { path, cause })?;
        let notes = vec![format!("{} settings, as stored; the times are those of the conditions below.", rows.len())];
        Ok(Self { kernel: kept::stored(folder), ..Self::new(manifest, rows, peers, left_out, notes) })
    }

    /// Writes tables, pictures and pages into a folder.
    ///
    /// # Errors
    /// A file that cannot be written or drawn, with its path.
    pub fn write(&self, folder: &Path) -> Result<(), ReportError> {
        let pictures = folder.join("plots");
        fs::create_dir_all(&pictures).map_err(|cause| ReportError::Write { path: pictures.clone(), cause })?;
        table(&folder.join("speed_against_error.csv"), row::COLUMNS, self.rows.iter().map(Row::fields))?;
        let cheapest = cheapest::table(&self.rows);
        table(&folder.join("cheapest.csv"), cheapest::COLUMNS, cheapest.iter().map(cheapest::Cheapest::fields))?;
        let costs = cheapest::costs(&self.rows);
        table(&folder.join("cost.csv"), cheapest::COST_COLUMNS, costs.iter().map(cheapest::Cost::fields))?;
        table(&folder.join("growth.csv"), growth::COLUMNS, self.growths.iter().map(tables::growth_fields))?;
        self.kernel.iter().try_for_each(|kernel| kernel::write(kernel, folder))?;
        let conditions = serde_json::to_string_pretty(&self.manifest).map_err(io::Error::from);
        let path = folder.join("manifest.json");
        conditions
            .and_then(|text| fs::write(&path, text + "\n"))
            .map_err(|cause| ReportError::Write { path: path.clone(), cause })?;
        let figures = plots::figures(self);
        figures.iter().try_for_each(|f| draw(f, &pictures).map(drop))?;
        pages::write(self, &figures, folder)
    }
}

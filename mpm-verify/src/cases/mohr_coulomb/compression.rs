//! An element that is shortened while stresses aside are held, against the rows of a table.

use mpm_core::scene::Strength;

use super::super::Outcome;
use super::{CELL_PRESSURE, at_row, exact_on_paths, law};
use crate::element::Element;
use crate::error::Error::{self, Unfit};
use crate::exact::oracle::Table;
use crate::experiment::refinement::Sampled;

/// A way to compress an element.
pub(super) struct Compression {
    /// Its table, as text.
    pub table: &'static str,
    /// The strain that is free, as long as the stresses that work on it are those of [`Self::held`].
    pub free: [f64; 4],
    /// Stresses that are held, Pa.
    pub held: [f64; 4],
}

impl Compression {
    /// All rows: stresses as shares of the largest stress, strains of the largest strain.
    pub fn outcome(&self, strength: &Strength) -> Result<Outcome, Error> {
        let rows = Table::parse(self.table).rows(["eps_yy", "eps_xx", "sxx_Pa", "syy_Pa", "szz_Pa"]);
        exact_on_paths(rows.len(), |parts| self.path(strength, &rows, parts))
    }

    /// Stresses and the lateral strain at all rows, from row to row in so many steps.
    fn path(&self, strength: &Strength, rows: &[[f64; 5]], parts: u32) -> Result<Vec<Sampled>, Error> {
        let last = rows.last().ok_or(Unfit("an empty table"))?;
        let (most, farthest) = (last[3].abs(), last[0].abs());
        let mut element = Element::new(law(strength), [-CELL_PRESSURE, -CELL_PRESSURE, -CELL_PRESSURE, 0.0]);
        let (mut samples, mut before) = (Vec::new(), 0.0);
        for [along, aside, xx, yy, zz] in rows {
            let driven = [0.0, (along - before) / f64::from(parts), 0.0, 0.0];
            before = *along;
            for _ in 0..parts {
                element.step(&driven, &[self.free], &self.held)?;
            }
            let names = ["sigma_xx over the largest", "sigma_yy over the largest", "sigma_zz over the largest"];
            for ((name, found), expected) in names.iter().zip(element.stress).zip([xx, yy, zz]) {
                samples.push(at_row(name, along / last[0], [found, *expected], most));
            }
            let across = [element.strain[0], *aside];
            samples.push(at_row("lateral strain over the shortening", along / last[0], across, farthest));
        }
        Ok(samples)
    }
}

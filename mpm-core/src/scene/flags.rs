//! Values from the command line that stand above those of the scene file, and pass the same checks.

use std::ops::Range;

use toml::Spanned;

use super::raw::{RawMesh, RawScene, RawScheme, RawTime};

/// Replacements for keys of a scene file; `None` leaves the file's own value.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Flags {
    /// `--integrator`: a word of `time.integrator`.
    pub integrator: Option<String>,
    /// `--scheme`: a word of `scheme.shape`.
    pub scheme: Option<String>,
    /// `--tolerance`: `time.tolerance`, -.
    pub tolerance: Option<f64>,
    /// `--driver`: a word of `time.integrator`, of a scene whose soil may fail.
    pub driver: Option<String>,
    /// `--mesh`: `mesh.cell`, m. Room beside and above the soil stays as large as it is.
    pub cell: Option<f64>,
    /// `--ppc`: `mesh.particles_per_cell`.
    pub particles_per_cell: Option<i64>,
    /// `--go-on`: `failure.goes_on`.
    pub goes_on: bool,
}

const NAMES: [&str; 6] = ["--integrator", "--scheme", "--tolerance", "--driver", "--mesh", "--ppc"];

/// A place that no file has: counted down from the largest number, so that a refusal can name the flag.
fn place(flag: usize) -> Range<usize> {
    usize::MAX - flag..usize::MAX - flag
}

/// The flag that a value came from, if it is not from the file.
pub(super) fn source(span: &Range<usize>) -> Option<&'static str> {
    NAMES.get(usize::MAX - span.start).copied()
}

impl Flags {
    /// Writes the flags over what was read from the file. Returns the keys of the file that were left out, because the
    /// integrator of the flag has no use for them.
    pub(super) fn apply(&self, raw: &mut RawScene) -> Vec<String> {
        let word = |value: &String, flag| Spanned::new(place(flag), value.clone());
        let mut left_out = Vec::new();
        if let Some(value) = &self.integrator {
            let own = raw.time.as_ref().and_then(|t| t.get_ref().integrator.as_ref()).map(|i| i.get_ref().clone());
            if own.as_deref().unwrap_or("explicit") != value {
                left_out = leave_out(raw, value);
            }
            time(raw, 0).integrator = Some(word(value, 0));
        }
        if let Some(value) = &self.scheme {
            let table = raw.scheme.get_or_insert_with(|| Spanned::new(place(1), RawScheme::default()));
            table.get_mut().shape = Some(word(value, 1));
        }
        if let Some(value) = &self.driver {
            time(raw, 3).integrator = Some(word(value, 3));
        }
        if let Some(value) = self.cell {
            refine(raw.mesh.get_mut(), value);
        }
        if let Some(value) = self.particles_per_cell {
            raw.mesh.get_mut().particles_per_cell = Spanned::new(place(5), value);
        }
        if let (Some(failure), true) = (raw.failure.as_mut(), self.goes_on) {
            failure.get_mut().goes_on = Some(true);
        }
        if let Some(value) = self.tolerance {
            time(raw, 2).tolerance = Some(Spanned::new(place(2), value));
        }
        left_out
    }
}

/// Another cell (m); as many cells of empty room as it takes to keep the room.
fn refine(mesh: &mut RawMesh, cell: f64) {
    let ratio = *mesh.cell.get_ref() / cell;
    if ratio.is_finite() && ratio > 0.0 {
        for room in [&mut mesh.headroom_cells, &mut mesh.sideroom_cells].into_iter().flatten() {
            let count = (*room.get_ref() as f64 * ratio - 1e-9).ceil().min(1e9);
            *room.get_mut() = count as i64;
        }
    }
    mesh.cell = Spanned::new(place(4), cell);
}

/// Takes out the keys that say how another integrator computes; what is computed stays.
fn leave_out(raw: &mut RawScene, integrator: &str) -> Vec<String> {
    let mut names = Vec::new();
    let mut drop = |there: bool, name: &str| {
        if there {
            names.push(name.to_owned());
        }
    };
    let quasi_static = integrator == "quasi-static";
    if let Some(scheme) = raw.scheme.as_mut().map(Spanned::get_mut) {
        if quasi_static {
            drop(scheme.flip.take().is_some(), "scheme.flip");
            drop(scheme.darcy_inertia.take().is_some(), "scheme.darcy_inertia");
            drop(scheme.transfer.take().is_some(), "scheme.transfer");
            drop(scheme.update.take().is_some(), "scheme.update");
        } else {
            drop(scheme.jump_penalty.take().is_some(), "scheme.jump_penalty");
        }
    }
    if let Some(time) = raw.time.as_mut().map(Spanned::get_mut) {
        // An automatic step is one of every integrator.
        let given = time.step.as_ref().is_some_and(|step| step.get_ref().as_str() != Some("auto"));
        if given {
            time.step = None;
        }
        drop(given, "time.step");
        if quasi_static {
            drop(time.safety.take().is_some(), "time.safety");
        } else {
            drop(time.tolerance.take().is_some(), "time.tolerance");
            drop(time.method.take().is_some(), "time.method");
        }
    }
    names
}

fn time(raw: &mut RawScene, flag: usize) -> &mut RawTime {
    raw.time.get_or_insert_with(|| Spanned::new(place(flag), RawTime::default())).get_mut()
}

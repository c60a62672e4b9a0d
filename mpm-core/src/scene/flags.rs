//! Values from the command line that stand above those of the scene file, and pass the same checks.

use toml::de::{DeTable, DeValue};

use super::patch::{Change, Edit, value};
use crate::error::SceneError;

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
    /// `--mesh`: `mesh.cell`, m. The empty space beside and above the soil keeps its size.
    pub cell: Option<f64>,
    /// `--ppc`: `mesh.particles_per_cell`.
    pub particles_per_cell: Option<i64>,
    /// `--go-on`: `failure.continue_if_unstable`.
    pub continue_if_unstable: bool,
}

/// Keys of no use without steps of a given length or without inertia, and of none where displacements are not solved for.
const OF_STEPS_OR_MOTION: [&str; 9] = [
    "scheme.flip",
    "scheme.darcy_inertia",
    "scheme.relative_acceleration",
    "scheme.transfer",
    "scheme.null_space_strain",
    "scheme.particle_domain",
    "scheme.update",
    "time.safety",
    "time.waves",
];
const OF_SOLVED: [&str; 5] =
    ["scheme.jump_penalty", "time.tolerance", "time.method", "time.waves", "scheme.relative_acceleration"];

impl Flags {
    /// The keys that the flags change, and those of the file that are left out, because the integrator of the flag has no
    /// use for them.
    pub(super) fn edits(&self, file: &DeTable<'_>) -> Result<(Vec<Edit>, Vec<String>), SceneError> {
        let (mut edits, mut left_out) = (Vec::new(), Vec::new());
        if let Some(word) = &self.integrator {
            let own = value(file, "time.integrator").and_then(DeValue::as_str).unwrap_or("explicit");
            if own != word {
                left_out = useless(file, word);
            }
            for key in &left_out {
                edits.push(Edit::new(Some("--integrator"), key, None::<f64>.into())?);
            }
        }
        let mut set = |flag, key: &str, change: Option<Change>| -> Result<(), SceneError> {
            edits.extend(change.map(|change| Edit::new(Some(flag), key, change)).transpose()?);
            Ok(())
        };
        set("--integrator", "time.integrator", self.integrator.as_ref().map(Change::from))?;
        set("--scheme", "scheme.shape", self.scheme.as_ref().map(Change::from))?;
        set("--driver", "time.integrator", self.driver.as_ref().map(Change::from))?;
        set("--ppc", "mesh.particles_per_cell", self.particles_per_cell.map(Change::from))?;
        set("--tolerance", "time.tolerance", self.tolerance.map(Change::from))?;
        if self.continue_if_unstable && file.contains_key("failure") {
            set("--go-on", "failure.continue_if_unstable", Some(true.into()))?;
        }
        if let Some(cell) = self.cell {
            let own = value(file, "mesh.cell").and_then(number).unwrap_or(f64::NAN);
            let room = |key| value(file, key).and_then(number).map_or(0, |count| count as usize);
            let rooms = [room("mesh.empty_cells_above"), room("mesh.empty_cells_beside")];
            edits.extend(finer(Some("--mesh"), cell, own, rooms)?);
        }
        Ok((edits, left_out))
    }
}

/// Another cell (m); as many empty cells as keep the empty space beside and above.
pub(super) fn finer(
    flag: Option<&'static str>,
    cell: f64,
    own: f64,
    rooms: [usize; 2],
) -> Result<Vec<Edit>, SceneError> {
    let mut edits = vec![Edit::new(flag, "mesh.cell", cell.into())?];
    let ratio = own / cell;
    for (key, room) in ["mesh.empty_cells_above", "mesh.empty_cells_beside"].into_iter().zip(rooms) {
        if room > 0 && ratio.is_finite() && ratio > 0.0 {
            let count = (room as f64 * ratio - 1e-9).ceil().min(1e9);
            edits.push(Edit::new(flag, key, (count as i64).into())?);
        }
    }
    Ok(edits)
}

/// The keys of a file that say how another integrator computes; what is computed stays.
fn useless(file: &DeTable<'_>, integrator: &str) -> Vec<String> {
    let other: &[&str] = match integrator {
        "quasi-static" => &OF_STEPS_OR_MOTION,
        "implicit" => &["scheme.flip", "scheme.transfer", "scheme.update", "time.safety", "time.method"],
        _ => &OF_SOLVED,
    };
    let mut keys: Vec<String> =
        other.iter().filter(|key| value(file, key).is_some()).map(|key| key.to_string()).collect();
    // An automatic step is one of every integrator.
    if value(file, "time.step").is_some_and(|step| step.as_str() != Some("auto")) {
        keys.push("time.step".to_owned());
    }
    keys
}

/// The number that stands at a key.
fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(number) => number.as_str().parse().ok(),
        DeValue::Integer(number) => i64::from_str_radix(number.as_str(), number.radix()).ok().map(|n| n as f64),
        _ => None,
    }
}

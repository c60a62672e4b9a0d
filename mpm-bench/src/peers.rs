//! Figures of other codes on the same column. They were measured elsewhere: compare orders of magnitude.

use serde::{Deserialize, Serialize};

/// The file, as the program carries it.
const FILE: &str = include_str!("../../reference-data/peers/terzaghi.csv");

/// A run of another code: a line of `reference-data/peers/terzaghi.csv`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Peer {
    /// The code.
    pub peer: String,
    /// Its version; `not recorded` where it is not known.
    pub version: String,
    /// `finite-volumes`, `finite-elements` or `material-points`.
    pub kind: String,
    /// How it was run.
    pub setting: String,
    /// Edge of a cell or element, m.
    pub mesh_m: f64,
    /// Time steps.
    pub steps: u64,
    /// Largest error against compressible water, where that was measured.
    pub max_error_compressible: Option<f64>,
    /// Largest error against Terzaghi, where that was measured.
    pub max_error_terzaghi: Option<f64>,
    /// Smallest and largest CPU time, s; the same where one was measured.
    pub cpu_low_s: f64,
    /// See `cpu_low_s`.
    pub cpu_high_s: f64,
    /// What was timed: `solve` or `process`.
    pub timed: String,
}

impl Peer {
    /// CPU time in the middle of its range, s.
    pub fn cpu_s(&self) -> f64 {
        0.5 * (self.cpu_low_s + self.cpu_high_s)
    }
}

/// All of them.
///
/// # Errors
/// A line that is not complete.
pub fn peers() -> Result<Vec<Peer>, csv::Error> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(FILE.as_bytes());
    reader.deserialize().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_complete() {
        let peers = peers().expect("a file that reads");
        assert!(peers.len() >= 9);
        for peer in &peers {
            let words = [&peer.peer, &peer.version, &peer.kind, &peer.setting, &peer.timed];
            assert!(words.iter().all(|w| !w.is_empty()), "{peer:?}");
            let errors = || [peer.max_error_compressible, peer.max_error_terzaghi].into_iter().flatten();
            assert!(errors().count() > 0 && errors().all(|error| error > 0.0 && error < 1.0), "{peer:?}");
            assert!(peer.mesh_m > 0.0 && peer.steps > 0 && peer.cpu_low_s > 0.0 && peer.cpu_high_s >= peer.cpu_low_s);
            assert!(["solve", "process"].contains(&peer.timed.as_str()), "{peer:?}");
            assert!(["finite-volumes", "finite-elements", "material-points"].contains(&peer.kind.as_str()));
        }
    }
}

//! Guards the reference data: what is there is what was checked when it was made.

use std::path::Path;

use mpm_core::hash::{hex, sha256};

use crate::program::ROOT;

#[test]
fn every_exact_table_has_its_checksum() {
    let folder = Path::new(ROOT).join("reference-data");
    let sums = std::fs::read_to_string(folder.join("SHA256SUMS")).expect("checksums");
    for entry in std::fs::read_dir(folder.join("exact")).expect("tables") {
        let name = format!("exact/{}", entry.expect("a table").file_name().to_string_lossy());
        let line = sums.lines().find(|line| line.ends_with(&name)).unwrap_or_else(|| panic!("{name} has no checksum"));
        let bytes = std::fs::read(folder.join(&name)).expect("a table");
        assert_eq!(line.split_whitespace().next(), Some(hex(&sha256(&bytes)).as_str()), "{name}");
    }
}

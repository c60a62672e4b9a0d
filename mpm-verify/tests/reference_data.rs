//! Guards the reference data: what is there is what was checked when it was made.

use std::path::Path;

#[test]
fn every_exact_table_has_its_checksum() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-data");
    let sums = std::fs::read_to_string(folder.join("SHA256SUMS")).expect("checksums");
    for entry in std::fs::read_dir(folder.join("exact")).expect("tables") {
        let name = format!("exact/{}", entry.expect("a table").file_name().to_string_lossy());
        let line = sums.lines().find(|line| line.ends_with(&name)).unwrap_or_else(|| panic!("{name} has no checksum"));
        let bytes = std::fs::read(folder.join(&name)).expect("a table");
        assert_eq!(line.split_whitespace().next(), Some(sha256(&bytes).as_str()), "{name}");
    }
}

/// SHA-256 as hexadecimal digits.
fn sha256(bytes: &[u8]) -> String {
    use sha2::{Digest, Sha256};
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

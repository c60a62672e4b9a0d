//! Every page in a browser: valid HTML, no fault that axe finds, nothing off the screen at 360, 768 and 1400 px, light and dark.
//!
//! Runs where there is a browser (`MPM_BROWSER`, or `chromium` or `google-chrome` on the path), Node, and the modules `puppeteer-core`,
//! `axe-core` and `html-validate` (`NODE_PATH`); otherwise it says why it does not.

use std::collections::BTreeSet;
use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::program::{run, stderr};

/// Small runs whose pages are checked.
const RUNS: [&str; 5] = [
    "study --integrator quasi-static --mesh 0.1,0.05 --no-sweeps --no-cost --quiet",
    "check hydrostatic dry-bar quasi-static-steps --quiet",
    "stability --quick patch --quiet",
    "solve terzaghi-quasi-static --quiet",
    "gallery embankment --quiet",
];

fn on_path(names: &[&str]) -> Option<PathBuf> {
    let folders: Vec<PathBuf> = env::split_paths(&env::var_os("PATH")?).collect();
    names.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name))).find(|path| path.is_file())
}

/// The browser and Node, or what is missing.
fn tools() -> Result<(PathBuf, PathBuf), &'static str> {
    let browser = env::var_os("MPM_BROWSER").map(PathBuf::from).filter(|path| path.is_file());
    let browser = browser.or_else(|| on_path(&["chromium", "chromium-browser", "google-chrome"]));
    let browser = browser.ok_or("no browser: neither MPM_BROWSER nor chromium on the path")?;
    let node = on_path(&["node"]).ok_or("no node on the path")?;
    let modules = ["puppeteer-core", "axe-core", "html-validate"];
    let folders: Vec<PathBuf> =
        env::var_os("NODE_PATH").map_or_else(Vec::new, |path| env::split_paths(&path).collect());
    let known = |name: &&str| folders.iter().any(|folder| folder.join(name).is_dir());
    if modules.iter().all(known) {
        Ok((browser, node))
    } else {
        Err("NODE_PATH lacks puppeteer-core, axe-core or html-validate")
    }
}

fn pages(folder: &Path, found: &mut BTreeSet<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder").flatten() {
        let path = entry.path();
        if path.is_dir() {
            pages(&path, found);
        } else if path.extension().is_some_and(|e| e == "html") {
            found.insert(path);
        }
    }
}

#[test]
fn pages_have_no_fault_in_a_browser() {
    let (browser, node) = match tools() {
        Ok(tools) => tools,
        Err(why) => {
            println!("skipped: {why}");
            return;
        }
    };
    let place = tempfile::tempdir().expect("a folder");
    for line in RUNS {
        let output = run(place.path(), line);
        assert!(output.status.success(), "{line}: {}", stderr(&output));
    }
    let mut all = BTreeSet::new();
    pages(place.path(), &mut all);
    assert!(all.len() > 9, "{all:?}");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/browser/check.cjs");
    let output = Command::new(node).arg(script).arg(browser).args(&all).output().expect("node");
    let faults = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && faults.is_empty(), "{faults}{}", String::from_utf8_lossy(&output.stderr));
}

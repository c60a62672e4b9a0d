//! Every page after every command: each link leads somewhere; in a browser valid HTML, no fault that axe finds, nothing off the screen at
//! 390, 768 and 1440 px, light and dark, and each entry of a legend seen in its picture.
//!
//! The browser runs where there is a browser (`MPM_BROWSER`, or `chromium` or `google-chrome` on the path), Node, and the modules `puppeteer-core`,
//! `axe-core` and `html-validate` (`NODE_PATH`); otherwise the test says that it was skipped, or fails where
//! `MPM_BROWSER_TEST=required`.

use std::env;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use crate::crawl::{Crawl, crawl};
use crate::program::{run, stderr};

/// Small runs of all kinds of pages, each in its turn after those before it.
const RUNS: [&str; 7] = [
    "study --integrator quasi-static --mesh 0.1,0.05 --no-sweeps --no-cost --quiet",
    "check hydrostatic dry-bar quasi-static-steps mandel --quiet",
    "stability --quick patch --quiet",
    "solve terzaghi-quasi-static --quiet",
    "solve mandel --quiet",
    "gallery embankment --quiet",
    "cases export reports/cases --only consolidation,mandel --quiet",
];

/// The pages of all runs, made once.
static PAGES: LazyLock<(tempfile::TempDir, Crawl)> = LazyLock::new(|| {
    let place = tempfile::tempdir().expect("a folder");
    for line in RUNS {
        let output = run(place.path(), line);
        assert!(output.status.success(), "{line}: {}", stderr(&output));
        let crawl = crawl(place.path());
        assert_eq!(crawl.dead, Vec::<String>::new(), "after {line}");
    }
    let crawl = crawl(place.path());
    (place, crawl)
});

#[test]
fn every_link_leads_somewhere() {
    let Crawl { pages, links, images, .. } = &PAGES.1;
    println!("{} pages, {links} links, {images} images, none dead", pages.len());
    assert!(pages.len() > 15 && *links > 300 && *images > 5, "{} pages, {links} links, {images} images", pages.len());
}

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

#[test]
fn pages_have_no_fault_in_a_browser() {
    let (browser, node) = match tools() {
        Ok(tools) => tools,
        Err(why) => {
            assert!(env::var_os("MPM_BROWSER_TEST").is_none_or(|asked| asked != "required"), "{why}");
            // Not caught by the harness: a test that did not run must not look like one that passed.
            writeln!(std::io::stderr(), "pages_have_no_fault_in_a_browser: skipped: {why}").expect("an error stream");
            return;
        }
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/browser/check.cjs");
    let output = Command::new(node).arg(script).arg(browser).args(&PAGES.1.pages).output().expect("node");
    let faults = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && faults.is_empty(), "{faults}{}", String::from_utf8_lossy(&output.stderr));
}

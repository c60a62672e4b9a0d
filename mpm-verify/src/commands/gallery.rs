//! `gallery`: real scenes, each with its picture, its page and the time it takes.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use mpm_verify::report::gallery::{self, Shown};
use mpm_verify::scenes::GALLERY;

use super::{Failure, inside, say, solve};
use crate::Common;

/// Which scenes.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Scenes by name; all without one
    #[arg(value_name = "NAME")]
    names: Vec<String>,
}

/// Solves the scenes into a folder each, and writes a page that shows them.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    let known = GALLERY.map(|scene| scene.name);
    if let Some(name) = options.names.iter().find(|name| !known.contains(&name.as_str())) {
        return Err(Failure::BadInput(format!("gallery: expected one of {}, found {name}", known.join(", "))));
    }
    let folder = common.out.clone().unwrap_or_else(|| PathBuf::from("reports/gallery"));
    inside(&folder)?;
    let (mut shown, mut failed) = (Vec::new(), Vec::new());
    for scene in GALLERY.iter().filter(|s| options.names.is_empty() || options.names.iter().any(|n| n == s.name)) {
        let file = folder.join(format!("{}.toml", scene.name));
        std::fs::write(&file, scene.text).map_err(|e| Failure::RunFailed(format!("{}: {e}", file.display())))?;
        let own = Common { out: Some(folder.join(scene.name)), quiet: true, json: false, ..common.clone() };
        let watch = Instant::now();
        let outcome = solve::run(&solve::Options::of(file), &own);
        let wall_s = watch.elapsed().as_secs_f64();
        let trouble = outcome.err().map(|e| e.to_string());
        let told = trouble.as_deref().unwrap_or("done");
        say(common.quiet || common.json, &format!("{:<20} {wall_s:>6.1} s  {told}", scene.name));
        failed.extend(trouble.iter().map(|_| scene.name));
        shown.push(Shown::new(scene, wall_s, trouble));
    }
    gallery::write(&shown, &folder).map_err(Failure::run_failed)?;
    super::refresh_home(&folder)?;
    say(common.quiet || common.json, &format!("gallery: {}", folder.join("index.html").display()));
    if failed.is_empty() { Ok(()) } else { Err(Failure::RunFailed(format!("gallery: {}", failed.join(", ")))) }
}

//! `gallery`: engineering scenes, each with its picture, its page and its run time.

use std::time::Instant;

use clap::Args;
use mpm_verify::report::gallery::{self, Shown};
use mpm_verify::scenes::GALLERY;

use super::terminal::coloured;
use super::{Failure, chosen, make_folder, refresh_home, solve, write_file};
use crate::Common;

/// Which scenes.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Scenes to run; all without a name
    #[arg(value_name = "SCENE")]
    names: Vec<String>,
}

/// Solves the scenes, each into a folder of its own, and writes a page that shows them.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    let scenes = chosen(("the name of a gallery scene", "gallery"), &options.names, &GALLERY, |scene| scene.name)?;
    let folder = common.folder("gallery");
    make_folder(&folder)?;
    let (mut shown, mut failed) = (Vec::new(), Vec::new());
    for scene in scenes {
        let file = folder.join(format!("{}.toml", scene.name));
        write_file(&file, scene.text)?;
        let own = Common { out: Some(folder.join(scene.name)), quiet: true, json: false, ..common.clone() };
        let clock = Instant::now();
        let outcome = solve::run(&solve::Options::of(file.display().to_string()), &own);
        let wall_s = clock.elapsed().as_secs_f64();
        let trouble = outcome.err().map(|e| e.to_string());
        let end = trouble.as_ref().map_or_else(|| "done".to_owned(), |why| coloured(&format!("failed: {why}")));
        common.say(&format!("{:<20} {wall_s:>6.1} s  {end}", scene.name));
        failed.extend(trouble.iter().map(|_| scene.name));
        shown.push(Shown::new(scene, wall_s, trouble, &folder));
    }
    gallery::write(&shown, &folder).map_err(Failure::run_failed)?;
    refresh_home(&folder)?;
    common.say(&format!("{} scenes run, {} failed", shown.len(), failed.len()));
    common.page(&folder.join("index.html"));
    if failed.is_empty() { Ok(()) } else { Err(Failure::RunFailed(format!("failed: {}", failed.join(", ")))) }
}

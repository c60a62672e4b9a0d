//! `slope`: the factor of safety of any slope, or of the published ones.

use clap::Args;
use mpm_core::scene::{Flags, Scene};
use mpm_verify::manifest::Manifest;
use mpm_verify::progress::Progress;
use mpm_verify::slope::page::{Shown, said};
use mpm_verify::slope::{RULES, State, guesses, ladder, warnings};

use super::{Failure, chosen};
use crate::Common;

/// Which slope, and when.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// Scene of a slope (name or file); without one the published slopes are run
    #[arg(value_name = "SCENE")]
    scene: Option<String>,
    /// Some of the published slopes, by name, in place of all
    #[arg(long, value_name = "NAME,NAME", value_delimiter = ',', conflicts_with = "scene")]
    only: Vec<String>,
    /// Let water seep until then first, h on the clock of the scene
    #[arg(long, value_name = "H", default_value_t = 0.0)]
    after: f64,
    /// Cell size in place of the scene's, m
    #[arg(long, value_name = "L", requires = "scene")]
    mesh: Option<f64>,
    /// Particles per cell in place of the scene's: 1, 4, 9, ...
    #[arg(long, value_name = "N", requires = "scene")]
    ppc: Option<i64>,
    /// Width of the bracket
    #[arg(long, value_name = "W", default_value_t = 0.01)]
    within: f64,
}

/// Finds the factors and writes everything about them.
pub fn run(options: &Options, common: &Common) -> Result<(), Failure> {
    if !(options.within >= 1e-3 && options.within <= 1.0) {
        return Err(Failure::BadInput(format!("--within: expected 0.001 to 1, found {}", options.within)));
    }
    let Some(source) = &options.scene else { return published(options, common) };
    let flags = Flags { cell: options.mesh, particles_per_cell: options.ppc, ..Flags::default() };
    let scene = common.load(source, &flags)?;
    let Some(failure) = &scene.failure else {
        let expected = "a stage with coupling = \"full\", of soil that may fail";
        return Err(Failure::BadInput(format!("{source}: expected {expected}, found none")));
    };
    let after = 3600.0 * options.after - if options.after > 0.0 { failure.starts_at } else { 0.0 };
    if after < 0.0 || after.is_nan() {
        let starts = failure.starts_at / 3600.0;
        return Err(Failure::BadInput(format!("--after: expected hours from {starts} on, found {}", options.after)));
    }
    let name = format!("slope-{}", scene.name);
    common.publish(&name, &["index.html", "factors.csv"], |folder| {
        one(options, common, (&scene, after), folder.stage())
    })?;
    common.page(&common.folder(&name).join("index.html"));
    Ok(())
}

/// One slope.
fn one(
    options: &Options,
    common: &Common,
    (scene, after): (&Scene, f64),
    folder: &std::path::Path,
) -> Result<(), Failure> {
    let progress = Progress::new("factor of safety", common.quiet);
    let state = State::after(scene, after).map_err(Failure::run_failed)?;
    let slices = state.slices();
    let found = state.factors((options.within, guesses(&slices)), common.jobs(), &|text| progress.line(text));
    let found = found.map_err(Failure::run_failed)?;
    let manifest = Manifest::new(scene, common.jobs());
    let shown = Shown { scene, found: &found, slices: &slices, level: &state.level, manifest: &manifest };
    shown.write(folder).map_err(Failure::run_failed)?;
    for ((_, name), found) in RULES.iter().zip(&found.found) {
        let b = &found.bracket;
        let steps = format!("{} trials, {} steps", b.trials, b.steps);
        common.say(&format!("strength reduction, {name:<12} {}  ({:.3} to {:.3}, {steps})", said(b), b.low, b.high));
    }
    common.say(&shown.lead());
    for warning in warnings(scene) {
        common.say(&format!("warning: {warning}"));
    }
    if let Err(why) = &slices {
        common.say(&format!("no limit equilibrium: {why}"));
    }
    Ok(())
}

/// The published slopes.
fn published(options: &Options, common: &Common) -> Result<(), Failure> {
    let all = ladder::published().map_err(Failure::run_failed)?;
    let slopes = chosen(("the name of a published slope", "slopes"), &options.only, &all, |slope| &slope.name)?;
    let lines = common.publish("slopes", &["index.html", ladder::NAME], |folder| {
        let progress = Progress::new("slopes", common.quiet);
        let lines = ladder::run(&slopes, (folder.stage(), common.jobs()), &|text| progress.line(text));
        let lines = lines.map_err(Failure::run_failed)?;
        ladder::write(&slopes, &lines, folder.stage()).map_err(Failure::run_failed)?;
        Ok(lines)
    })?;
    common.json(&lines);
    for line in &lines {
        common.say(&ladder::said(line));
    }
    common.page(&common.folder("slopes").join("index.html"));
    let failed: Vec<&str> =
        lines.iter().filter(|line| !line.trouble.is_empty()).map(|line| line.name.as_str()).collect();
    if failed.is_empty() { Ok(()) } else { Err(Failure::CheckFailed(format!("not met: {}", failed.join(", ")))) }
}

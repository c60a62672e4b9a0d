//! `list`: what there is.

use mpm_verify::cases::LADDER;
use mpm_verify::scenes::BUILT_IN;
use mpm_verify::study::MESHES;

use super::{Failure, print_json, say};
use crate::Common;

/// Prints cases, scenes and schemes.
pub fn run(common: &Common) -> Result<(), Failure> {
    if common.json {
        let names = |list: Vec<&str>| serde_json::Value::from(list);
        print_json(&serde_json::json!({
            "cases": names(LADDER.iter().map(|rung| rung.name).collect()),
            "scenes": names(BUILT_IN.iter().map(|(name, _)| *name).collect()),
            "integrators": names(vec!["explicit"]),
            "schemes": names(vec!["centre", "linear"]),
            "darcy": names(vec!["face", "nodal"]),
            "meshes_m": MESHES,
        }));
        return Ok(());
    }
    say(false, "cases (mpm-verify check [CASE..])");
    for rung in LADDER {
        say(false, &format!("  {:<16} {}", rung.name, rung.about));
    }
    say(false, "scenes (reference-data/scenes, mpm-verify solve SCENE.toml)");
    for (name, text) in BUILT_IN {
        let about = text.lines().next().unwrap_or("").trim_start_matches(['#', ' ']);
        say(false, &format!("  {name:<16} {about}"));
    }
    say(false, "integrators       explicit");
    say(false, "schemes           centre, linear");
    say(false, "darcy operators   face, nodal");
    say(false, &format!("meshes (m)        {}", MESHES.map(|m| m.to_string()).join(", ")));
    Ok(())
}

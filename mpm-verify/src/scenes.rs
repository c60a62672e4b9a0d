//! The scene files that the program carries with it, so that it runs from any folder.

use mpm_core::scene::Scene;

use crate::error::Error::{self, Lacks};

/// Names and texts of the scenes in `reference-data/scenes`.
pub const BUILT_IN: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/scenes.rs"));

/// A scene of the gallery.
#[derive(Debug, Clone, Copy)]
pub struct Exhibit {
    /// Its name.
    pub name: &'static str,
    /// Its picture on the page of all.
    pub picture: &'static str,
    /// Its file.
    pub text: &'static str,
}

/// One with its file, from the folder of the sources.
macro_rules! exhibit {
    ($name:literal, $picture:literal, $file:literal) => {
        Exhibit { name: $name, picture: $picture, text: include_str!($file) }
    };
}

/// The scenes of the gallery, in the order of the page.
pub const GALLERY: [Exhibit; 10] = [
    exhibit!("embankment", "map-water", "../../reference-data/gallery/embankment.toml"),
    exhibit!("footing", "plot-history", "../../reference-data/gallery/footing.toml"),
    exhibit!("levee-with-core", "map-water", "../../reference-data/gallery/levee-with-core.toml"),
    exhibit!("drawdown", "map-water", "../../reference-data/gallery/drawdown.toml"),
    exhibit!("rain", "map-water", "../../reference-data/gallery/rain.toml"),
    exhibit!("retaining-wall", "plot-history", "../../reference-data/gallery/retaining-wall.toml"),
    exhibit!("submerged-slope", "map-soil", "../../reference-data/gallery/submerged-slope.toml"),
    exhibit!("cyclic-load", "plot-history", "../../reference-data/scenes/cyclic-load.toml"),
    exhibit!("vertical-drain", "map-water", "../../reference-data/gallery/vertical-drain.toml"),
    exhibit!("collapse-in-water", "map-soil", "../../reference-data/gallery/collapse-in-water.toml"),
];

/// A built-in scene by name.
///
/// # Errors
/// No scene has this name, or its file does not hold, which its own test excludes.
pub fn built_in(name: &str) -> Result<Scene, Error> {
    let (name, text) = BUILT_IN.iter().find(|(n, _)| *n == name).ok_or(Lacks("such scene"))?;
    Ok(Scene::parse(text, name)?)
}

/// The text of a built-in scene.
pub fn text(name: &str) -> Option<&'static str> {
    BUILT_IN.iter().find(|(own, _)| *own == name).map(|(_, text)| *text)
}

/// The column of the paper's Table 1, started from undrained equilibrium.
///
/// # Panics
/// Never: a test reads every built-in scene.
pub fn terzaghi() -> Scene {
    built_in("terzaghi").expect("the built-in scene holds")
}

/// Dry Mohr-Coulomb soil that is compressed beyond yield.
///
/// # Panics
/// Never: a test reads every built-in scene.
pub fn oedometer() -> Scene {
    built_in("oedometer-plastic").expect("the built-in scene holds")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_of_the_gallery_are_short_and_hold() {
        for Exhibit { name, text, .. } in GALLERY {
            assert!(text.lines().count() <= 40 && text.starts_with("# "), "{name}");
            assert!(Scene::parse(text, name).is_ok_and(|scene| scene.name == name), "{name}");
        }
    }

    #[test]
    fn every_scene_file_can_be_read() {
        for (name, _) in BUILT_IN {
            built_in(name).unwrap_or_else(|e| panic!("{name}: {e}"));
        }
    }
}

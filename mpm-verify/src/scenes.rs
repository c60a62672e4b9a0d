//! Scenes by name or path. The program carries the scene files of the repository, so that it runs from any folder.

use std::fs;
use std::path::Path;

use mpm_core::error::LoadError;
use mpm_core::scene::{Flags, LARGEST_FILE, Scene, read_text};

use crate::error::Error::{self, Lacks};
use crate::suggest::nearest;

/// Names and texts of the scenes in `reference-data/scenes`.
pub const BUILT_IN: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/scenes.rs"));

/// Names and texts of the published slopes in `reference-data/slopes`.
pub const SLOPES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/slopes.rs"));

/// A scene of the gallery.
#[derive(Debug, Clone, Copy)]
pub struct Exhibit {
    /// Its name.
    pub name: &'static str,
    /// Its file.
    pub text: &'static str,
}

/// A scene with the text of its file.
macro_rules! exhibit {
    ($name:literal, $file:literal) => {
        Exhibit { name: $name, text: include_str!($file) }
    };
}

/// The scenes of the gallery, in the order of the page.
pub const GALLERY: [Exhibit; 10] = [
    exhibit!("embankment", "../../reference-data/gallery/embankment.toml"),
    exhibit!("footing", "../../reference-data/gallery/footing.toml"),
    exhibit!("levee-with-core", "../../reference-data/gallery/levee-with-core.toml"),
    exhibit!("drawdown", "../../reference-data/gallery/drawdown.toml"),
    exhibit!("rain", "../../reference-data/gallery/rain.toml"),
    exhibit!("retaining-wall", "../../reference-data/gallery/retaining-wall.toml"),
    exhibit!("submerged-slope", "../../reference-data/gallery/submerged-slope.toml"),
    exhibit!("cyclic-load", "../../reference-data/scenes/cyclic-load.toml"),
    exhibit!("vertical-drain", "../../reference-data/gallery/vertical-drain.toml"),
    exhibit!("collapse-in-water", "../../reference-data/gallery/collapse-in-water.toml"),
];

/// Names of all scenes that the program carries: the built-in ones, those of the gallery, the published slopes.
pub fn names() -> impl Iterator<Item = &'static str> {
    let built_in = BUILT_IN.iter().map(|(name, _)| *name);
    built_in
        .chain(GALLERY.iter().map(|scene| scene.name).filter(|name| BUILT_IN.iter().all(|(other, _)| other != name)))
        .chain(SLOPES.iter().map(|(name, _)| *name))
}

/// Text of a scene: of a file, or of the built-in or gallery scene of that name where there is no such file.
///
/// # Errors
/// Neither exists, or the file cannot be read.
pub fn text(source: &str) -> Result<String, Error> {
    let path = Path::new(source);
    let built_in = BUILT_IN.iter().chain(SLOPES).find(|(name, _)| *name == source).map(|(_, text)| *text);
    let known = built_in.or_else(|| GALLERY.iter().find(|scene| scene.name == source).map(|scene| scene.text));
    if let Some(text) = known.filter(|_| !path.is_file()) {
        return Ok(text.to_owned());
    }
    if !path.exists() {
        return Err(missing(path));
    }
    let unreadable = |source| LoadError::Unreadable { path: path.to_owned(), source };
    Ok(read_text(path, LARGEST_FILE).map_err(unreadable)?)
}

/// Comment at the head of a scene's file, as one paragraph; empty where there is none or no such scene.
pub fn about(source: &str) -> String {
    about_text(&text(source).unwrap_or_default())
}

/// Comment at the head of the text of a scene, as one paragraph.
pub fn about_text(text: &str) -> String {
    let comment = text.lines().map_while(|line| line.strip_prefix('#'));
    comment
        .map(|line| line.trim_start_matches('#').trim())
        .filter(|line| !line.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}

/// Reads and checks a scene, a file or the name of one that the program carries, with flags in place of some of its keys.
///
/// # Errors
/// There is no such scene, its file cannot be read, or is refused with its line.
pub fn load(source: &str, flags: &Flags) -> Result<Scene, Error> {
    Ok(Scene::parse_with(&text(source)?, source, flags)?)
}

/// Neither a file nor a name; the nearest names and scene files of the same folder.
fn missing(path: &Path) -> Error {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let files = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let files = files.filter(|file| file.extension().is_some_and(|e| e == "toml"));
    let files = files.map(|file| file.strip_prefix(".").unwrap_or(&file).display().to_string());
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut found = nearest(&stem, names().map(str::to_owned).chain(files));
    found.dedup();
    let (what, kind) = ("a scene file or the name of a scene", "scenes");
    Error::Unknown { what, kind, found: path.display().to_string(), nearest: found }
}

/// A built-in scene by name.
///
/// # Errors
/// No scene has this name, or its file is refused, which a test excludes.
pub fn built_in(name: &str) -> Result<Scene, Error> {
    let (name, text) = BUILT_IN.iter().find(|(n, _)| *n == name).ok_or(Lacks("such scene"))?;
    Ok(Scene::parse(text, name)?)
}

/// The column of the paper's Table 1, started from undrained equilibrium.
///
/// # Panics
/// Never: a test reads every built-in scene.
pub fn terzaghi() -> Scene {
    built_in("terzaghi").expect("the built-in scene is valid")
}

/// Dry Mohr-Coulomb soil compressed beyond yield.
///
/// # Panics
/// Never: a test reads every built-in scene.
pub fn oedometer() -> Scene {
    built_in("oedometer-plastic").expect("the built-in scene is valid")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_is_found_by_name_or_by_path_or_the_nearest_are_named() {
        let flags = Flags::default();
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../reference-data/scenes/dam.toml");
        for (source, name) in [("terzaghi", "terzaghi"), ("embankment", "embankment"), (file, "dam")] {
            assert_eq!(load(source, &flags).expect("a scene").name, name);
        }
        let said = load("terzagi.toml", &flags).expect_err("no such scene").to_string();
        assert!(
            said.starts_with("expected a scene file or the name of a scene, found terzagi.toml; did you mean terzaghi")
        );
        assert!(said.ends_with("? All names: mpm-verify list scenes"), "{said}");
        let (all, mut once) = (names().count(), names().collect::<Vec<_>>());
        once.sort_unstable();
        once.dedup();
        assert_eq!(once.len(), all);
    }

    #[test]
    fn scenes_of_the_gallery_are_short_and_valid() {
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

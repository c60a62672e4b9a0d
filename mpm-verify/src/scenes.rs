//! The scene files that the program carries with it, so that it runs from any folder.

use mpm_core::error::SceneError;
use mpm_core::scene::Scene;

/// Names and texts of the scenes in `reference-data/scenes`.
pub const BUILT_IN: [(&str, &str); 1] = [("terzaghi", include_str!("../../reference-data/scenes/terzaghi.toml"))];

/// A built-in scene by name.
///
/// # Errors
/// The scene file does not hold, which its own test excludes.
pub fn built_in(name: &str) -> Option<Result<Scene, SceneError>> {
    BUILT_IN.iter().find(|(n, _)| *n == name).map(|(n, text)| Scene::parse(text, n))
}

/// The column of the paper's Table 1, started from undrained equilibrium.
///
/// # Panics
/// Never: a test reads every built-in scene.
pub fn terzaghi() -> Scene {
    built_in("terzaghi").and_then(Result::ok).expect("the built-in scene holds")
}

//! Scenes that must be refused: edits of the default scene, and the message.

use mpm_core::error::SceneError;
use mpm_core::scene::Scene;

/// Parts of a text, each of which must occur once, and what stands in their place.
pub type Edits = &'static [(&'static str, &'static str)];

pub const WATER: &str = "[water]
hydraulic_conductivity = 5.0e-4
bulk_modulus = 2.2e9
unit_weight = 9810.0
";
pub const SURCHARGE: &str = "[surcharge]
pressure = 1.0e4
on = \"surface\"
";
pub const TIME_FACTORS: &str = "time_factors = [0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0]\n";

/// The message for a text, whose line must be one of the text.
pub fn refusal(case: &str, text: &str) -> SceneError {
    let Err(error) = Scene::parse(text, "scene.toml") else { panic!("{case}: accepted\n{text}") };
    let lines = text.lines().count().max(1);
    assert!((1..=lines).contains(&error.line), "{case}: line {} of {lines}: {error}", error.line);
    error
}

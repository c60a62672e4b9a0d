//! Scene texts for the tests (the study's default scene with some of its lines changed), and how close two figures are.
#![allow(dead_code)] // each program uses its own part

use mpm_core::drive::Run;
use mpm_core::run::run;
use mpm_core::scene::Scene;

/// The consolidation column of the paper's Table 1, the scene that all others are derived from.
pub fn terzaghi() -> String {
    scene_text("terzaghi")
}

/// The file of a scene of `reference-data/scenes`.
pub fn scene_text(name: &str) -> String {
    let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../reference-data/scenes")).join(name);
    std::fs::read_to_string(path.with_extension("toml")).expect("a scene file")
}

/// A text with each pattern, which must occur exactly once, replaced.
pub fn edited(text: &str, edits: &[(&str, &str)]) -> String {
    edits.iter().fold(text.to_owned(), |text, (from, to)| {
        assert_eq!(text.matches(from).count(), 1, "`{from}` must occur once in\n{text}");
        text.replacen(from, to, 1)
    })
}

/// The default scene with some lines changed (`cell = 0.1`; a key that is not there comes first), replaced by others
/// (`on -> ramp_time = 1.0`) or dropped (`-on`), and tables dropped (`-[surcharge]`).
pub fn scene(changes: &[&str]) -> Scene {
    let text = changes.iter().fold(terzaghi(), |text, change| changed(&text, change));
    Scene::parse(&text, "scene.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn changed(text: &str, change: &str) -> String {
    let (what, with) = if let Some(dropped) = change.strip_prefix('-') {
        (dropped, None)
    } else if let Some((key, line)) = change.split_once(" -> ") {
        (key, Some(line))
    } else {
        (change.split(" =").next().unwrap_or(change), Some(change))
    };
    let (mut lines, mut found, mut table) = (Vec::new(), 0, "");
    for line in text.lines() {
        table = if line.starts_with('[') { line } else { table };
        if line == what || line.starts_with(&format!("{what} =")) {
            found += 1;
            lines.extend(with);
        } else if table != what {
            lines.push(line);
        }
    }
    let new = found == 0 && with == Some(change);
    assert!(found == 1 || new, "`{change}` fits {found} lines of\n{text}");
    if new {
        lines.insert(0, change);
    }
    lines.join("\n")
}

/// A run that must come to its end.
pub fn completed(scene: &Scene) -> Run {
    let run = run(scene, &mut |_| {}).expect("a step below the limit");
    assert_eq!(run.failure, None);
    run
}

/// |a - b| as a share of the larger of both; zero for equal figures.
pub fn apart(a: f64, b: f64) -> f64 {
    if a == b { 0.0 } else { (a - b).abs() / a.abs().max(b.abs()) }
}

/// Figures for a message.
pub fn figures(values: &[f64]) -> String {
    let list: Vec<String> = values.iter().map(|value| format!("{value:.1e}")).collect();
    list.join(", ")
}

/// The oedometer modulus of Table 1, Pa, from E = 20 MPa and nu = 0.3.
pub const MODULUS: f64 = 2.0e7 * 0.7 / (1.3 * 0.4);
/// Q = K_w/n of Table 1, Pa.
pub const PORE_STIFFNESS: f64 = 2.2e9 / 0.3;
/// The surcharge of the default scene, Pa.
pub const SURCHARGE: f64 = 1.0e4;
/// Hydraulic conductivity of Table 1, m/s.
pub const CONDUCTIVITY: f64 = 5.0e-4;
/// Unit weight of water, N/m3.
pub const UNIT_WEIGHT: f64 = 9810.0;
/// Porosity.
pub const POROSITY: f64 = 0.3;

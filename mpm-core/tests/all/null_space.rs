//! Guards the null-space filter: forces do not know of it, soils are not mixed, what it takes is booked, soil that flows is quiet.

use crate::common::completed;
use mpm_core::drive::{Run, Sample};
use mpm_core::scene::Scene;

/// A dry block that settles under its own weight.
const BLOCK: &str = "
name = \"block\"
dimension = \"plane-strain\"
start = \"given\"
gravity = 9.81
geometry.column = { height = 1.0, width = 0.5 }
mesh = { cell = 0.125, particles_per_cell = 4 }
boundaries = { left = \"roller\", right = \"free\", bottom = \"roller\", top = \"free\" }
initial.stress_xx = [[0.0, -2e3], [1.0, -1e3]]
scheme.shape = \"centre\"
time.integrator = \"explicit\"
[soil]
grain_density = 2650.0
porosity = 0.40
law.linear_elastic = { youngs_modulus = 1e7, poisson_ratio = 0.3 }
[[stages]]
until.time = 0.02
";

fn scene(text: &str, edits: &[(&str, &str)]) -> Scene {
    let text = edits.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    });
    Scene::parse(&text, "block.toml").expect("a sound scene")
}

/// The block with edits, whose differences within a cell last over a strain.
fn filtered(edits: &[(&str, &str)], strain: &str) -> Run {
    let filter = format!("scheme.null_space_strain = {strain}\ntime.integrator");
    completed(&scene(BLOCK, &[edits, &[("time.integrator", filter.as_str())]].concat()))
}

fn last(run: &Run) -> &Sample {
    run.samples.last().expect("samples")
}

/// Largest difference of mean stresses between the particles of a cell of 0.125 m, Pa.
fn scatter(run: &Run) -> f64 {
    let mut cells = std::collections::BTreeMap::new();
    for [x, y, stress] in &run.places.solid {
        let cell = ((x / 0.125) as usize, (y / 0.125) as usize);
        let (low, high) = cells.entry(cell).or_insert((f64::INFINITY, f64::NEG_INFINITY));
        (*low, *high) = (f64::min(*low, *stress), f64::max(*high, *stress));
    }
    cells.values().map(|(low, high)| high - low).fold(0.0, f64::max)
}

#[test]
fn forces_do_not_know_of_it() {
    for shape in ["\"centre\"", "\"b-bar\""] {
        let edits = [("\"centre\"", shape)];
        let plain = completed(&scene(BLOCK, &edits));
        // Strains of this scene are of 1e-4.
        let [fast, slow] = ["1e-7", "1e-2"].map(|strain| filtered(&edits, strain));
        let settled = last(&plain).state.settlement;
        for run in [&fast, &slow] {
            let off = (last(run).state.settlement - settled).abs();
            assert!(settled > 1e-5 && off < 1e-10 * settled, "{shape}: {off} of {settled} m");
        }
        let (before, kept, gone) = (scatter(&plain), scatter(&slow), scatter(&fast));
        assert!(kept > 0.8 * before && gone < 0.03 * before, "{shape}: {before} {kept} {gone} Pa");
    }
}

#[test]
fn what_it_takes_is_booked() {
    let (plain, fast) = (completed(&scene(BLOCK, &[])), filtered(&[], "1e-7"));
    let (a, b) = (&last(&plain).balance, &last(&fast).balance);
    assert_eq!(a.plastic_dissipation_j, 0.0);
    assert!(b.plastic_dissipation_j > 0.0);
    let (strained, lost) = (a.strain_j - b.strain_j, b.plastic_dissipation_j);
    assert!((strained - lost).abs() < 1e-3 * lost, "{strained} {lost} J");
}

#[test]
fn soils_keep_to_themselves() {
    let layer = "law.linear_elastic = { youngs_modulus = 1e7, poisson_ratio = 0.3 }\n";
    let layers = format!("[[layers]]\nup_to = 0.5\n[[layers]]\nup_to = 1.0\n{layer}[[stages]]");
    let (one, two) = (filtered(&[], "1e-5"), filtered(&[("[[stages]]", &layers)], "1e-5"));
    assert_eq!(one.places, two.places);
}

#[test]
fn shapes_with_forces_of_each_particle_have_no_use_for_it() {
    for shape in ["linear", "gimp", "bspline2"] {
        let text = BLOCK.replace("\"centre\"", &format!("\"{shape}\"\nscheme.null_space_strain = 0.01"));
        let message = Scene::parse(&text, "block.toml").expect_err(shape).to_string();
        assert!(message.contains("at one place"), "{message}");
    }
}

//! What was written is read back by the crate that wrote it, and by nothing else here: ParaView is no part of tests.

use std::path::PathBuf;

use vtkio::model::{Attribute, DataSet, IOBuffer, Piece};

use mpm_core::drive::{Monitor, Wish};
use mpm_core::hardware::Hardware;
use mpm_core::observe::ProfileRow;
use mpm_core::run::run_monitored;
use mpm_core::scene::Scene;
use mpm_core::step::Model;

use super::*;
use crate::frames::{Recorded, made_up, mean_stress};
use crate::report::tests::{INTEGRATORS, block};

/// Numbers of an array by its name.
fn numbers(attributes: &[Attribute], name: &str) -> Vec<f64> {
    let own = attributes.iter().find_map(|a| match a {
        Attribute::DataArray(array) if array.name == name => Some(array.data.clone()),
        _ => None,
    });
    plain(own.unwrap_or_else(|| panic!("no array {name}")))
}

fn plain(buffer: IOBuffer) -> Vec<f64> {
    buffer.cast_into::<f64>().expect("numbers")
}

/// Points and their arrays.
fn cloud(path: &Path) -> (Vec<f64>, Vec<Attribute>) {
    let DataSet::PolyData { pieces, .. } = Vtk::import(path).expect("a file").data else { panic!("no points") };
    let Some(Piece::Inline(piece)) = pieces.into_iter().next() else { panic!("no piece") };
    assert_eq!(piece.num_verts(), piece.num_points());
    (plain(piece.points.clone()), piece.data.point)
}

/// Times and files of a collection.
fn entries(path: &Path) -> Vec<(f64, String)> {
    let text = fs::read_to_string(path).expect("a collection");
    let part = |line: &str, name: &str| {
        let start = line.find(&format!("{name}=\"")).expect("an attribute") + name.len() + 2;
        line[start..].split('"').next().expect("its value").to_owned()
    };
    let rows = text.lines().filter(|line| line.contains("<DataSet"));
    rows.map(|line| (part(line, "timestep").parse().expect("a time"), part(line, "file"))).collect()
}

/// Within four-byte rounding.
fn same(found: &[f64], expected: impl Iterator<Item = f64>) {
    let expected: Vec<f64> = expected.collect();
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert_eq!(*a, f64::from(b as f32));
    }
}

#[test]
fn frames_are_read_back_with_their_numbers_and_times() {
    let shots = made_up::shots(2, 2);
    let folder = tempfile::tempdir().expect("a folder");
    let folder = std::env::var_os("MPM_KEEP_PICTURES").map_or(folder.path().to_owned(), Into::into);
    write(&shots, &folder).expect("files");
    for (part, ..) in PARTS {
        let entries = entries(&folder.join(format!("{part}.pvd")));
        assert_eq!(entries.len(), shots.len());
        for ((time, file), shot) in entries.iter().zip(&shots) {
            assert_eq!(*time, shot.time_s);
            assert!(folder.join(file).exists(), "{file}");
        }
    }
    for (number, Shot { frame, .. }) in shots.iter().enumerate() {
        let (points, arrays) = cloud(&folder.join(format!("solid/solid-{number:04}.vtp")));
        same(&points, frame.solid.iter().flat_map(|p| [p.x[0], p.x[1], 0.0]));
        same(&numbers(&arrays, "id"), frame.solid.iter().map(|p| f64::from(p.id)));
        let tensor = |p: &SolidState| {
            let [xx, yy, zz, xy] = p.stress;
            [xx, xy, 0.0, xy, yy, 0.0, 0.0, 0.0, zz]
        };
        same(&numbers(&arrays, layers::STRESS), frame.solid.iter().flat_map(tensor));
        same(&numbers(&arrays, layers::MEAN), frame.solid.iter().map(mean_stress));
        same(&numbers(&arrays, "deviator_strain"), frame.solid.iter().map(|p| p.deviator_strain));
        let displaced = frame.solid.iter().flat_map(|p| [p.displacement[0], p.displacement[1], 0.0]);
        same(&numbers(&arrays, "displacement_m"), displaced);
        let (points, arrays) = cloud(&folder.join(format!("water/water-{number:04}.vtp")));
        same(&points, frame.water.iter().flat_map(|p| [p.x[0], p.x[1], 0.0]));
        same(&numbers(&arrays, layers::PRESSURE), frame.water.iter().map(|p| p.pressure));
        let path = folder.join(format!("cells/cells-{number:04}.vtu"));
        let DataSet::UnstructuredGrid { pieces, .. } = Vtk::import(path).expect("a file").data else {
            panic!("no cells")
        };
        let Some(Piece::Inline(piece)) = pieces.into_iter().next() else { panic!("no piece") };
        same(&numbers(&piece.data.cell, "saturation"), frame.cell.iter().map(|c| c.saturation));
        // The upper right corner of the last cell.
        let end = [0, 1].map(|axis| frame.cells[axis] as f64 * frame.size);
        let points = plain(piece.points.clone());
        same(&points[points.len() - 3..], [end[0], end[1], 0.0].into_iter());
    }
}

#[test]
fn a_dry_frame_has_a_water_file_without_points_and_a_dry_run_has_none() {
    let mut shots = made_up::shots(2, 0);
    shots[0].frame.water.clear();
    let own = tempfile::tempdir().expect("a folder");
    let folder = std::env::var_os("MPM_KEEP_PICTURES").map_or(own.path().to_owned(), PathBuf::from).join("dry");
    write(&shots, &folder).expect("files");
    let path = folder.join("water/water-0000.vtp");
    assert!(cloud(&path).0.is_empty());
    // ParaView asks for the count, and the crate leaves out what is zero.
    assert!(fs::read_to_string(&path).expect("a file").contains("NumberOfPoints=\"0\""));
    shots[1].frame.water.clear();
    let own = tempfile::tempdir().expect("a folder");
    write(&shots, own.path()).expect("files");
    assert!(own.path().join("solid.pvd").exists() && !own.path().join("water.pvd").exists());
}

#[test]
fn paraview_finds_what_to_colour_by_and_a_range() {
    let shots = made_up::shots(1, 2);
    let own = tempfile::tempdir().expect("a folder");
    write(&shots, own.path()).expect("files");
    let text = fs::read_to_string(own.path().join("solid/solid-0001.vtp")).expect("a file");
    let active = format!("Scalars=\"deviator_strain\" Vectors=\"displacement_m\" Tensors=\"{}\"", layers::STRESS);
    assert!(text.contains(&active), "{}", &text[..600.min(text.len())]);
    let script = fs::read_to_string(own.path().join("view.py")).expect("a script");
    assert!(script.contains("\"deviator_strain\": (0.0, ") && !script.contains('@'), "{script}");
}

/// Takes the frames of a run.
struct Taking(Recorded);

impl Monitor for Taking {
    fn look(&mut self, _: f64) -> Wish {
        Wish::GoOn
    }

    fn save(&mut self, _: Vec<u8>) {}

    fn observed(&mut self, model: &dyn Model, time: f64) {
        self.0.take(model, time);
    }
}

/// Every array of the first and of the last frame against what the tables of the run say, whatever the integrator: what it does not
/// compute is in no file, and nothing is zero in place of a value.
#[test]
fn arrays_are_what_history_says() {
    for (integrator, start) in INTEGRATORS.into_iter().flat_map(|i| [(i, "unloaded"), (i, "geostatic")]) {
        let shape = if matches!(integrator, "quasi-static" | "implicit") { "bspline2" } else { "centre" };
        let wet = "[water]\nhydraulic_conductivity = 1e-3\nbulk_modulus = 2e6\nunit_weight = 9810.0\n[[stages]]\ndrained = [\"top\"]";
        let mut text = block(integrator, shape, false).replace("unloaded", start);
        if !text.contains("[water]") {
            text = text.replace("[[stages]]", wet);
        }
        for strain in ["large", "small"] {
            let text = text.replace("porosity", &format!("strain = \"{strain}\"\nporosity"));
            let Ok(scene) = Scene::parse(&text, "block.toml") else { continue };
            let what = format!("{integrator}, {start}, {strain}");
            let mut taking = Taking(Recorded::of(&scene));
            let run = run_monitored(&Hardware::default(), &scene, None, &mut taking).expect(&what);
            assert!(run.failure.is_none(), "{what}: {:?}", run.failure);
            let [first, .., last] = &taking.0.shots[..] else { panic!("{what}: two frames") };
            for (shot, sample) in [(first, run.samples.first()), (last, run.samples.last())] {
                let (all, state) = (&shot.frame.solid, &sample.expect("a sample").state);
                let mean = |weight: fn(&SolidState) -> f64, of: &dyn Fn(&SolidState) -> f64| {
                    all.iter().map(|p| weight(p) * of(p)).sum::<f64>() / all.iter().map(weight).sum::<f64>()
                };
                let near =
                    |name: &str, a: f64, b: f64, by: f64| assert!((a - b).abs() <= by, "{what}: {name} {a} and {b}");
                near(
                    "pressure",
                    mean(|p| p.volume, &|p| p.pore_pressure),
                    state.mean_pressure,
                    0.02 * state.mean_pressure.abs() + 1.0,
                );
                near("centre", mean(|p| p.mass, &|p| p.x[1]), state.centre[1], 1e-9);
                let vertical = |row: &ProfileRow| row.effective_stress_pa;
                let rows = state.profile.iter().map(vertical).sum::<f64>() / state.profile.len() as f64;
                near("stress", mean(|p| p.volume, &|p| p.stress[1]), rows, 0.05 * rows.abs() + 1.0);
                let speed = all.iter().map(|p| p.velocity[0].hypot(p.velocity[1])).fold(f64::NAN, f64::max);
                if integrator == "quasi-static" {
                    assert!(speed.is_nan(), "{what}: a velocity without inertia");
                } else {
                    near("speed", speed, state.max_speed, 1e-9);
                }
                // The surface goes down with the row below it, and by what is drained in between.
                let top = all.iter().filter(|p| p.x[1] > 0.85);
                let (sum, count) = top.fold((0.0, 0.0), |(sum, n), p| (sum - p.displacement[1], n + 1.0));
                let settled = state.settlement - run.samples[0].state.settlement;
                near("settlement", sum / count, settled, 0.5 * settled.abs());
                if strain == "large" {
                    let start = run.samples[0].state.centre[1];
                    near("start", mean(|p| p.mass, &|p| p.x[1] - p.displacement[1]), start, 1e-9);
                }
                assert!(all.iter().all(|p| p.deviator_strain.is_nan()), "{what}: a strain that nobody counted");
            }
            let file = text_of(&last.frame);
            for (name, is_there) in [
                (layers::PRESSURE, true),
                ("displacement_m", true),
                ("velocity_m_per_s", integrator != "quasi-static"),
                (layers::STRAIN, false),
            ] {
                assert_eq!(file.contains(&format!("\"{name}\"")), is_there, "{what}: {name}");
            }
        }
    }
}

fn text_of(frame: &Frame) -> String {
    text(layers::solid(frame)).expect("a file")
}

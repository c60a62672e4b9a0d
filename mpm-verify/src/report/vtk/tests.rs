//! What was written is read back by the crate that wrote it, and by nothing else here: ParaView is no part of tests.

use std::path::PathBuf;

use vtkio::model::{Attribute, DataSet, IOBuffer, Piece};

use super::*;
use crate::frames::{made_up, mean_stress};

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

//! The program as a user runs it, on a handful of settings.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn bench(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mpm-bench")).args(arguments).output().expect("the program starts")
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

#[test]
fn a_sweep_writes_its_tables_pictures_and_pages_and_can_be_resumed() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("sweep");
    let arguments = ["--quick", "--only", "ppc9-tol1e-2", "--out", out.to_str().expect("a path")];
    let first = bench(&arguments);
    assert!(first.status.success(), "{}", String::from_utf8_lossy(&first.stderr));
    let said = String::from_utf8_lossy(&first.stdout);
    // Which mesh is cheapest is a matter of time, and so not for a test.
    assert!(said.contains("0.3 %: quasi-static, "), "{said}");

    let all = text(&out.join("speed_against_error.csv"));
    let columns = "case,integrator,scheme,mesh_m,ppc,dt_or_tol,max_error_terzaghi,max_error_compressible,cpu_s,steps,\
                   solves,ns_per_point_step,peak_bytes";
    assert!(all.starts_with(columns) && all.lines().count() > 20, "{all}");
    let cheapest = text(&out.join("cheapest.csv"));
    assert!(cheapest.starts_with("wanted_error,integrator,scheme,mesh_m,ppc,dt_or_tol,cpu_s,ratio_to_baseline"));
    assert!(cheapest.contains("\n0.003,quasi-static,"), "{cheapest}");
    for page in ["index.html", "report.md"] {
        let page = text(&out.join(page));
        assert!(page.contains("0.3 %") && page.contains(" --ppc 9 ") && page.contains("DOLFINx"));
        assert!(page.contains("does not contain"), "says what was left out");
    }
    for name in ["fronts", "error-against-cpu-by-scheme", "cpu-against-mesh"] {
        for ending in ["svg", "png", "csv"] {
            let path = out.join("plots").join(format!("{name}.{ending}"));
            assert!(fs::metadata(&path).is_ok_and(|m| m.len() > 0), "{}", path.display());
        }
    }
    assert!(text(&out.join("manifest.json")).contains("mpm-bench --quick"));

    let again = bench(&arguments);
    assert!(String::from_utf8_lossy(&again.stdout).contains("taken over from an earlier run"));
    assert_eq!(text(&out.join("speed_against_error.csv")), all, "nothing was measured again");
    let json = bench(&[&arguments[..], &["--json"]].concat());
    assert!(String::from_utf8_lossy(&json.stdout).starts_with("[\n"), "JSON and nothing else");

    // The report of stored results has the same tables and pictures; only what was said of the run is not stored.
    let told = folder.path().join("told");
    let rebuilt = bench(&["--from", out.to_str().expect("a path"), "--out", told.to_str().expect("a path")]);
    assert!(rebuilt.status.success(), "{}", String::from_utf8_lossy(&rebuilt.stderr));
    for name in
        ["speed_against_error.csv", "cost.csv", "cheapest.csv", "manifest.json", "plots/fronts.csv", "plots/fronts.svg"]
    {
        assert_eq!(text(&told.join(name)), text(&out.join(name)), "{name}");
    }

    // Room for the whole legend, in two rows: the drawing is as high as the image, which has two pixels to each of its own.
    let line = all.lines().find(|line| line.contains(",quasi-static,")).expect("a row");
    let others = ["explicit", "semi-implicit", "quasi-static (moving mesh)", "implicit (moving mesh)", "baseline"];
    let others: Vec<String> = others.iter().map(|name| line.replace(",quasi-static,", &format!(",{name},"))).collect();
    fs::write(out.join("speed_against_error.csv"), format!("{all}{}\n", others.join("\n"))).expect("written");
    let rebuilt = bench(&["--from", out.to_str().expect("a path"), "--out", told.to_str().expect("a path")]);
    assert!(rebuilt.status.success(), "{}", String::from_utf8_lossy(&rebuilt.stderr));
    let image = fs::read(told.join("plots/fronts.png")).expect("an image");
    let high = u32::from_be_bytes(image[20..24].try_into().expect("four bytes")) / 2;
    assert!(text(&told.join("plots/fronts.svg")).contains(&format!(" height=\"{high}\"")), "{high}");
}

#[test]
fn bad_input_ends_with_code_2_before_anything_is_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("file");
    fs::write(&file, "").expect("a file");
    let file = file.to_str().expect("a path");
    for (arguments, says) in [
        (vec!["--quik"], "--quik"),
        (vec!["--out", file], "expected a folder that can be written to"),
        (vec!["--from", "nowhere"], "nowhere/speed_against_error.csv"),
        (vec!["--only", "nothing-like-it"], "expected part of the name of a setting"),
    ] {
        let output = bench(&arguments);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {errors}");
        assert!(errors.contains(says), "{arguments:?}: {errors}");
    }
}

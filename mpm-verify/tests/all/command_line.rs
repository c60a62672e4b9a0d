//! Guards the command line: exit codes, messages, stable outputs.

use std::path::{Path, PathBuf};
use std::process::Output;

use crate::program::{changed, run, scene, stderr, stdout, verify};

/// The page that the last line of a command names, which must exist.
fn page(folder: &Path, output: &Output) -> PathBuf {
    let said = stdout(output);
    let page = said.lines().last().and_then(|line| line.strip_prefix("page: ")).unwrap_or_else(|| panic!("{said}"));
    assert!(folder.join(page).is_file(), "{page}");
    page.into()
}

#[test]
fn names_that_do_not_exist_are_answered_with_the_nearest_ones() {
    let folder = tempfile::tempdir().expect("a folder");
    for (line, words) in [
        ("check terzagi", "found terzagi; did you mean terzaghi"),
        ("solve terzagi", "found terzagi; did you mean terzaghi"),
        ("solve embankmnt.toml", "found embankmnt.toml; did you mean embankment? "),
        ("gallery fotting", "found fotting; did you mean footing? "),
        ("stability hourglas", "found hourglas; did you mean hourglass? "),
        ("levee --variant base-9", "--variant: expected the name of a variant, found base-9; did you mean base-"),
        ("mutants no-dracy", "did you mean "),
        ("sovle terzaghi", "similar subcommands exist: 'slope', 'score', 'prove', 'solve'"),
        ("solve terzaghi --scheme gimpp", "a similar value exists: 'gimp'"),
        ("levee --driver couple", "a similar value exists: 'coupled'"),
        ("study --integrator explict", "a similar value exists: 'explicit'"),
    ] {
        let output = run(folder.path(), line);
        assert_eq!(output.status.code(), Some(2), "{line}: {}", stderr(&output));
        assert!(stderr(&output).contains(words), "{line}: {}", stderr(&output));
    }
    let long = stderr(&verify(folder.path(), &["check", "terzagi"]));
    assert!(long.trim_end().ends_with("All names: mpm-verify list cases") && long.lines().count() == 1, "{long}");
}

#[test]
fn every_command_ends_with_a_summary_and_the_page_that_it_wrote() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |line: &str| {
        let output = run(folder.path(), line);
        assert_eq!(output.status.code(), Some(0), "{line}: {}", stderr(&output));
        (page(folder.path(), &output), stdout(&output))
    };
    let (path, said) = run("check dry-bar hydrostatic");
    assert!(
        path.ends_with("reports/suite/index.html") && said.contains("\n2 passed, 0 failed, 0 not established of 2 (")
    );
    let (path, said) = run("stability edge-node patch --quick");
    assert!(path.ends_with("reports/stability/index.html") && !said.contains(".part"), "{said}");
    assert!(said.contains("\n1 passed, 1 degraded of 2 schemes in stress tests\n"), "{said}");
    // A scene by its name; quantities that matter, in units that people use, and none that is zero.
    let (path, said) = run("solve terzaghi-quasi-static");
    assert!(path.ends_with("reports/terzaghi-quasi-static/index.html"), "{said}");
    for words in [
        "degree of consolidation 0.9",
        "; Terzaghi)\n",
        "error of settlement     at most ",
        " kPa at the base",
        " mm, exact ",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let (_, said) = run("solve dam");
    assert!(said.contains("m³/day per m (") && said.contains("; Charny)") && !said.contains("settlement"), "{said}");
    // The gallery is on the home page, and says how far its scenes are from their exact solutions.
    let (path, _) = run("gallery cyclic-load");
    let read = |page: &str| std::fs::read_to_string(folder.path().join(page)).expect(page);
    assert!(path.ends_with("reports/gallery/index.html") && read("reports/index.html").contains("gallery/index.html"));
    let gallery = read("reports/gallery/index.html");
    assert!(gallery.contains("Terzaghi, superposed") && gallery.contains("cyclic-load/thumbnail.svg"), "{gallery}");
    let (path, said) = run("study --mesh 0.1 --ppc 4 --integrator quasi-static --no-cost --no-sweeps");
    assert!(said.contains("runs: ") && !said.contains("stopped") && said.contains("claims: "), "{said}");
    assert_eq!(run("report").0, path);
}

#[test]
fn the_study_prints_the_paper_s_setting_first() {
    let folder = tempfile::tempdir().expect("a folder");
    let line = "study --mesh 0.02,0.05 --ppc 4 --integrator explicit --scheme centre --no-cost --no-sweeps --no-budget --jobs 1";
    let output = run(folder.path(), line);
    assert!(output.status.success(), "{}", stderr(&output));
    let error = stderr(&output);
    let first = error.lines().find(|line| !line.contains(" %, after ")).unwrap_or_default();
    assert!(first.starts_with("The paper's setting (L = 0.02 m, 4 particles per cell, explicit, "), "{error}");
    assert!(first.contains(" % relative to Terzaghi, ") && first.contains("finite bulk modulus of the pore water"));
}

#[test]
fn list_shows_what_there_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = verify(folder.path(), &["list"]);
    assert!(output.status.success());
    // What stands in files needs no second list here: a new case, scene or fault edits no snapshot.
    let (mut kept, mut of_files, mut count) = (String::new(), false, 0);
    for line in String::from_utf8_lossy(&output.stdout).lines() {
        if !line.starts_with(' ') {
            let files = ["test cases", "mutants", "scenes", "gallery", "faults"];
            of_files = files.iter().any(|kind| line.starts_with(kind));
            kept += &format!("{line}\n");
        } else if of_files {
            count += 1;
        } else {
            kept += &format!("{line}\n");
        }
    }
    assert!(count > 500, "{count}");
    insta::with_settings!({ description => "Guards what the program says it can do." }, {
        insta::assert_snapshot!("list", kept);
    });
}

#[test]
fn bad_input_ends_with_two_before_the_first_step() {
    let folder = tempfile::tempdir().expect("a folder");
    let bad = changed(folder.path(), "terzaghi.toml", &[("poisson_ratio = 0.30", "poisson_ratio = 0.6")]);
    let output = verify(folder.path(), &["solve", bad]);
    assert_eq!(output.status.code(), Some(2));
    let message = stderr(&output);
    assert!(
        message.starts_with("scene.toml:21: soil.law.linear_elastic.poisson_ratio: expected -1 < nu < 0.5, found 0.6"),
        "{message}"
    );
    for arguments in [
        vec!["solve", "none.toml"],
        vec!["check", "nonsense"],
        vec!["check", "--mutants", "nonsense"],
        vec!["check", "--scene", "none.toml"],
        vec!["check", "--scene", "scene.toml"],
        vec!["check", "--rows", "10,20,40"],
        vec!["check", "dry-bar", "--scene", "scene.toml"],
        vec!["study", "--mesh", "0.3"],
        vec!["study", "--ppc", "5"],
        vec!["study", "--dt", "fast"],
        vec!["study", "--tolerance", "1"],
        vec!["study", "--integrator", "implicit"],
        vec!["study", "--scheme", "cubic"],
        vec!["study", "--mesh", "0.1", "--dt", "1e-3"],
        vec!["solve", "scene.toml", "--tolerance", "small"],
        vec!["report", "nowhere"],
        vec!["--nonsense"],
    ] {
        let output = verify(folder.path(), &arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", stderr(&output));
        assert!(!stderr(&output).is_empty() && !stderr(&output).contains("panicked"), "{arguments:?}");
    }
}

#[test]
fn flags_of_solve_change_the_scene_and_are_checked_with_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = changed(folder.path(), "terzaghi.toml", &[("cell = 0.02", "cell = 0.1")]);
    let summary = |flags: &[&str]| {
        let output = verify(folder.path(), &[&["solve", scene, "--out", "out", "--json"], flags].concat());
        assert!(output.status.success(), "{flags:?}: {}", stderr(&output));
        serde_json::from_slice::<serde_json::Value>(&output.stdout).expect("JSON on standard output")
    };
    let [plain, same] = [&[][..], &["--integrator", "explicit", "--scheme", "centre"]].map(summary);
    let gimp = summary(&["--scheme", "gimp"]);
    assert_eq!((&plain["scene"], &plain["settlement_final_m"]), (&same["scene"], &same["settlement_final_m"]));
    assert_eq!(gimp["scene"]["shape"], "gimp");
    assert_ne!(gimp["settlement_final_m"], plain["settlement_final_m"]);
    assert_eq!((&plain["integrator"], plain["limit_s"].is_f64()), (&"explicit".into(), true));
    for count in ["accepted_steps", "rejected_steps", "factorisations", "solves"] {
        assert!(plain[count].is_u64(), "{count}: {}", plain[count]);
    }
    let beside = "expected integrator = \"quasi-static\" or \"implicit\" with it, found time.tolerance with";
    for (flags, message) in [
        (vec!["--integrator", "newmark"], "error: invalid value 'newmark' for '--integrator <WORD>'".to_owned()),
        (vec!["--scheme", "cubic"], "error: invalid value 'cubic' for '--scheme <WORD>'".to_owned()),
        (vec!["--tolerance", "1e-4"], format!("--tolerance: {beside} \"explicit\"")),
        (
            vec!["--integrator", "semi-implicit", "--tolerance", "1e-4"],
            format!("--tolerance: {beside} \"semi-implicit\""),
        ),
    ] {
        let output = verify(folder.path(), &[&["solve", scene][..], &flags].concat());
        assert_eq!(output.status.code(), Some(2), "{flags:?}: {}", stderr(&output));
        assert!(stderr(&output).starts_with(&message), "{flags:?}: {}", stderr(&output));
    }
    // Keys of the file that have no meaning with the flag are left out, and named.
    let output = verify(folder.path(), &["solve", scene, "--integrator", "quasi-static", "--out", "out"]);
    let names = "left out scheme.flip, scheme.darcy_inertia, time.safety";
    assert!(output.status.success() && stderr(&output).contains(names), "{}", stderr(&output));
}

#[test]
fn a_folder_that_cannot_be_written_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("file"), "").expect("a file");
    let output = verify(folder.path(), &["solve", &scene("terzaghi.toml"), "--out", "file/below"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("expected a folder that can be written to"), "{}", stderr(&output));
}

#[test]
fn a_step_above_the_limit_is_refused_and_a_forced_one_fails_but_keeps_its_history() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = changed(folder.path(), "terzaghi.toml", &[("step = \"auto\"\nsafety = 0.9", "step = 3.0e-6")]);
    let refused = verify(folder.path(), &["solve", scene]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("expected at most 1.428"), "{}", stderr(&refused));
    let forced = verify(folder.path(), &["solve", scene, "--force", "--out", "forced"]);
    assert_eq!(forced.status.code(), Some(3));
    assert!(stderr(&forced).contains("run failed at step"), "{}", stderr(&forced));
    let summary = std::fs::read_to_string(folder.path().join("forced/summary.json")).expect("a summary");
    assert!(summary.contains("\"forced\": true") && summary.contains("run failed"));
    let history = std::fs::read_to_string(folder.path().join("forced/history.csv")).expect("a history");
    assert!(history.starts_with("time_s,") && history.lines().count() > 1);
}

#[test]
fn solve_writes_its_stable_outputs() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = changed(folder.path(), "terzaghi.toml", &[("cell = 0.02", "cell = 0.1")]);
    let output = verify(folder.path(), &["solve", scene, "--out", "out", "--json"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON on standard output");
    assert!(json["steps"].as_u64() > Some(0));
    for file in ["history.csv", "profiles.csv", "summary.json"] {
        assert!(folder.path().join("out").join(file).exists(), "{file}");
    }
}

#[test]
fn a_run_goes_on_from_the_results_of_another() {
    let folder = tempfile::tempdir().expect("a folder");
    let first = scene("released-side.toml");
    let output = verify(folder.path(), &["solve", &first, "--state", "--out", "first"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let text = std::fs::read_to_string(&first).expect("the scene");
    let (before, rest) = text.split_once("stress_xx").expect("a state");
    let (_, after) = rest.split_once("[soil]").expect("soil");
    let next =
        format!("{before}table = \"first\"\n\n[soil]{after}").replace("[boundaries]", "[boundaries]\nright = \"free\"");
    std::fs::write(folder.path().join("next.toml"), next).expect("a scene");
    let output = verify(folder.path(), &["solve", "next.toml", "--out", "next"]);
    assert!(output.status.success(), "{}", stderr(&output));
    // Nothing is left to be released.
    let settled = |run: &str| {
        let history = std::fs::read_to_string(folder.path().join(run).join("history.csv")).expect("a history");
        history.lines().last().and_then(|line| line.split(',').nth(4)?.parse::<f64>().ok()).expect("a settlement")
    };
    let [first, next] = ["first", "next"].map(settled);
    assert!(first > 0.0 && next.abs() < 1e-6 * first, "{first} {next}");
}

#[test]
fn check_ends_with_zero_when_every_case_passes() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = verify(folder.path(), &["check", "hydrostatic", "undrained", "dry-bar"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let suite = std::fs::read_to_string(folder.path().join("reports/suite/cases.csv")).expect("a suite");
    let header = "case,integrator,scheme,error,required_error,order,order_low,order_high,required_order,verdict,cpu_s,\
                  reason,asymptotic,baseline,baseline_kind,change,tolerance,order_verdict";
    assert_eq!(suite.lines().next(), Some(header));
    assert_eq!(suite.lines().count(), 4);
    for file in [
        "index.html",
        "manifest.json",
        "hydrostatic/convergence.svg",
        "hydrostatic/errors.csv",
        "undrained/index.html",
        "dry-bar/errors.csv",
    ] {
        assert!(folder.path().join("reports/suite").join(file).exists(), "{file}");
    }
    let read = |name: &str| std::fs::read_to_string(folder.path().join("reports/suite").join(name)).expect(name);
    let samples = "case,quantity,time_s,time_factor,computed,exact,error,unit,counts";
    assert_eq!(read("samples.csv").lines().next(), Some(samples));
    let refinements =
        "case,by,parameter,unit,error,order,order_low,order_high,asymptotic,required_order,against,order_verdict";
    assert_eq!(read("refinements.csv").lines().next(), Some(refinements));
    // Every case has a baseline.
    assert!(suite.lines().skip(1).all(|line| line.contains(",verified,")), "{suite}");
    assert!(!String::from_utf8_lossy(&output.stdout).contains("without a baseline"));
    // A study made beside it links to its page, and the other way round.
    let study = "study --mesh 0.1 --ppc 1 --quiet --no-cost --no-sweeps";
    assert!(run(folder.path(), study).status.success());
    let page = std::fs::read_to_string(folder.path().join("reports/index.html")).expect("a page");
    assert!(page.contains("<a href=\"suite/index.html\">"));
    assert!(verify(folder.path(), &["check", "dry-bar", "--quiet"]).status.success());
    let page = std::fs::read_to_string(folder.path().join("reports/suite/index.html")).expect("a page");
    assert!(page.contains("<a href=\"../index.html\">"));
}

#[test]
fn a_scene_of_ones_own_is_checked_or_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = scene("terzaghi-quasi-static.toml");
    let check = |path: &str, more: &[&str]| verify(folder.path(), &[&["check", "--scene", path], more].concat());
    let output = check(&path, &["--rows", "5,8,10", "--out", "own"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    for words in [
        "Terzaghi's series with compressible water, drained at the top",
        "on 5, 8, 10 rows",
        "weight: none",
        "inertia: none",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let read = |name: &str| std::fs::read_to_string(folder.path().join("own").join(name)).expect(name);
    assert!(read("cases.csv").lines().count() == 2 && read("cases.csv").contains("\nterzaghi-quasi-static,"));
    assert!(read("samples.csv").lines().count() == 1 + 2 * 9 && read("index.html").contains("Refinements"));
    // Three meshes, four tolerances and two numbers of particles.
    assert_eq!(read("refinements.csv").lines().count(), 1 + 3 + 4 + 2);
    // Another material from the command line, and the row as JSON.
    let text = std::fs::read_to_string(scene("terzaghi-quasi-static.toml")).expect("the scene");
    let other = text.replace("poisson_ratio = 0.30", "poisson_ratio = 0.45").replace("height = 1.0", "height = 5.0");
    std::fs::write(folder.path().join("other.toml"), other.replace("cell = 0.1", "cell = 0.5")).expect("a scene");
    let output = check("other.toml", &["--json", "--rows", "14,17,20"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let rows: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON on standard output");
    assert!(rows[0]["verdict"] == "passed" && rows[0]["order_verdict"] == "not expected", "{rows}");
    for (path, more, words) in [
        (path.as_str(), &["--rows", "5,10"][..], "--rows: expected three numbers of rows or more"),
        (&scene("strip.toml"), &[], "strip.toml: boundaries: expected a level column"),
        (&scene("terzaghi.toml"), &["--scheme", "cubic"], "'cubic' for '--scheme <WORD>'"),
        (&scene("levee.toml"), &[], "expected"),
        ("missing.toml", &[], "expected a scene file or the name of a scene, found missing.toml; did you mean "),
    ] {
        let output = check(path, more);
        assert_eq!(output.status.code(), Some(2), "{path} {more:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(words), "{path} {more:?}: {}", stderr(&output));
    }
    // Cells that are larger than the zone that has drained are too coarse for the first times, and the check says so.
    let output = check(&path, &["--quiet", "--scheme", "centre", "--rows", "5,6,7,8"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).contains("failed: error"), "{}", stderr(&output));
}

#[test]
fn mutants_are_caught() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = run(folder.path(), "check --mutants hydrostatic quasi-static-steps dry-bar strip --json");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON on standard output");
    assert_eq!((&json[3]["case"], &json[3]["caught"]), (&"strip".into(), &true.into()));
    let rows = std::fs::read_to_string(folder.path().join("reports/suite/mutants.csv")).expect("mutants");
    let mut lines = rows.lines();
    assert_eq!(lines.next(), Some("case,mutant,error,required_error,caught"));
    assert!(rows.lines().count() == 5 && lines.all(|line| line.ends_with(",true")), "{rows}");
    // The suite itself was not run.
    assert!(!folder.path().join("reports/suite/cases.csv").exists());
}

#[test]
fn verdicts_end_with_the_first_case_that_fails() {
    let folder = tempfile::tempdir().expect("a folder");
    let row =
        "case,quantity,label,value,relative,absolute,since,why\nhydrostatic,error,verified,1e9,0,0,a day,a reason\n";
    std::fs::create_dir(folder.path().join("other")).expect("a folder");
    std::fs::write(folder.path().join("other/accepted.csv"), row).expect("accepted values");
    for (more, cases) in
        [(None, &["strip", "hydrostatic", "undrained"][..]), (Some("--until-failed"), &["strip", "hydrostatic"])]
    {
        let asked = ["check", "--verdicts", "verdicts.csv", "--baselines", "other", "--jobs", "1"];
        let named = ["strip", "hydrostatic", "undrained"];
        let output = verify(folder.path(), &[&asked[..], more.as_slice(), &named].concat());
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        let verdicts = std::fs::read_to_string(folder.path().join("verdicts.csv")).expect("verdicts");
        let rows: Vec<Vec<&str>> = verdicts.lines().skip(1).map(|line| line.splitn(3, ',').take(2).collect()).collect();
        let failed = |case: &str| if case == "hydrostatic" { "false" } else { "true" };
        assert_eq!(rows, cases.iter().map(|case| vec![*case, failed(case)]).collect::<Vec<_>>());
    }
    assert!(!folder.path().join("reports").exists());
}

#[test]
fn study_and_report_write_the_same_page() {
    let folder = tempfile::tempdir().expect("a folder");
    let study = "study --mesh 0.1 --ppc 1,4 --integrator explicit,quasi-static \
                 --scheme centre,bspline2 --quiet --no-cost --no-sweeps";
    let output = run(folder.path(), study);
    assert!(output.status.success(), "{}", stderr(&output));
    let errors = std::fs::read_to_string(folder.path().join("reports/accuracy/errors.csv")).expect("errors");
    let contract = "case,integrator,scheme,load,mesh_m,ppc,particles,dt_s,steps,max_error_terzaghi,\
        late_error_terzaghi,max_error_compressible,late_error_compressible,profile_error_compressible,\
        settlement_final_m,cell_crossings,cpu_s,ns_per_point_step";
    assert!(errors.starts_with(contract), "{errors}");
    // Splines are not run with one particle per cell where that is too few, and the page says so.
    assert_eq!(errors.lines().count(), 1 + 8 + 3 + 2);
    let notes = std::fs::read_to_string(folder.path().join("reports/accuracy/report.md")).expect("a report");
    assert!(notes.contains("quasi-static bspline2 is not run with 1 particle per cell"));
    let page = folder.path().join("reports/accuracy/index.html");
    let first = std::fs::read(&page).expect("a page");
    let output = verify(folder.path(), &["report"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(std::fs::read(&page).expect("a page"), first);
    // And the same numbers, to the last digit.
    let again = std::fs::read_to_string(folder.path().join("reports/accuracy/errors.csv")).expect("errors");
    assert_eq!(again, errors);
}

#[test]
fn a_levee_is_followed_to_its_page_and_what_cannot_be_run_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("levee").display().to_string();
    let levee = |more: &[&str]| {
        let output = verify(folder.path(), &[&["levee", "--out", &out], more].concat());
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        (output.status.code().unwrap_or(-1), said, stderr(&output))
    };
    let refusals: [(&[&str], &str); 6] = [
        (&["--scene", "terzaghi"], "coupling = \"full\""),
        (&["--variant", "no-such"], "--variant: expected the name of a variant, found no-such; did you mean "),
        (&["--until", "5"], "--until: expected hours"),
        (&["--from", "8"], "--from: expected --driver coupled or explicit"),
        (&["--safety-factor", "30"], "--safety-factor: expected hours from 6 to 24"),
        (&["--resume"], "checkpoint.bin: expected a checkpoint of a levee, found something else"),
    ];
    std::fs::create_dir_all(&out).expect("a folder");
    std::fs::write(folder.path().join("levee/checkpoint.bin"), "something").expect("a file");
    for (flags, words) in refusals {
        let (code, _, error) = levee(flags);
        assert_eq!(code, 2, "{flags:?}: {error}");
        assert!(error.contains(words), "{flags:?}: {error}");
    }
    // `solve` follows soil that may fail as well, and takes no flag that has no use there.
    let output = verify(folder.path(), &["solve", &scene("levee.toml"), "--threads", "2"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("--threads: expected none for a scene whose soil may fail"),
        "{}",
        stderr(&output)
    );
    // A file of others in the place of a checkpoint stays.
    let (code, _, error) = levee(&["--variant", "base-8.5", "--no-vtk"]);
    assert!(code == 2 && error.contains("left as it is"), "{code}: {error}");
    std::fs::remove_file(folder.path().join("levee/checkpoint.bin")).expect("the file is still there");
    let (code, _, error) = levee(&["--mesh", "0.4", "--variant", "base-8.5", "--no-vtk"]);
    assert_eq!(code, 3, "{error}");
    assert!(error.contains("slides without slowing down") && error.contains("--go-on"), "{error}");
    let (code, said, error) = levee(&["--mesh", "0.4", "--variant", "saturation-0.7"]);
    assert!(code == 0 && said.contains("page: ") && error.contains("seepage"), "{said}{error}");
    let read = |name: &str| std::fs::read_to_string(folder.path().join("levee").join(name)).expect(name);
    assert!(read("history.csv").starts_with("time_h,"));
    assert!(read("claims.csv").starts_with("claim,paper,value,verdict,rule\n"));
    let summary: serde_json::Value = serde_json::from_str(&read("summary.json")).expect("JSON");
    for key in ["failure_start_h", "rapid_failure_h", "toe_x_m", "water_ledger_error", "energy_error", "cpu_s"] {
        assert!(summary[key].is_f64(), "{key}: {}", summary[key]);
    }
    let page = read("index.html");
    for part in ["id=\"play\"", "Run it again", "saturation ahead of the front"] {
        assert!(page.contains(part), "{part}");
    }
    assert!(page.len() < 1_500_000 && page.contains("<noscript>"), "{}", page.len());
    assert!(folder.path().join("levee/levee.png").exists());
    assert!(read("vtk/solid.pvd").contains("timestep=\"21600.0\"") && read("vtk/view.py").contains("deviator_strain"));
    assert!(!folder.path().join("levee/checkpoint.bin").exists());
}

#[test]
fn a_slope_of_one_s_own_is_not_judged_as_the_paper_s_levee() {
    let folder = tempfile::tempdir().expect("a folder");
    // Ten metres high, falling towards the left, on a base that is fixed.
    let text = std::fs::read_to_string(scene("levee.toml")).expect("a scene");
    let base = text.find("# ASSUMED: 8.5 degrees").expect("a base")..text.find("[scheme]").expect("a scheme");
    let mut text = text.replace(&text[base], "");
    for (from, to) in [
        ("name = \"levee\"", "name = \"own\""),
        ("[[0.0, 0.0], [9.0, 0.0], [3.0, 3.0], [0.0, 3.0]]", "[[40.0, 0.0], [40.0, 10.0], [30.0, 10.0], [10.0, 0.0]]"),
        ("cell = 0.2 #", "cell = 2.5 #"),
        ("empty_cells_beside = 28", "empty_cells_beside = 0"),
        ("cohesion = 500.0", "cohesion = 20000.0"),
        ("wet = [[0.0, 0.0], [8.35, 0.0], [0.0, 2.3]]", "wet = [[40.0, 0.0], [40.0, 4.0], [30.0, 0.0]]"),
        ("feed.left = { head = 2.3 }", "feed.right = { head = 4.0 }"),
        ("left = \"roller\"", "left = \"free\""),
        ("right = \"free\"", "right = \"roller\""),
        ("bottom = \"coulomb\"", "bottom = \"fixed\""),
        ("until.time = 64800.0", "until.time = 7200.0"),
        ("levels = [2.0, 4.0, 6.0, 7.0, 8.0]", "levels = [20.0]"),
    ] {
        assert_eq!(text.matches(from).count(), 1, "{from}");
        text = text.replace(from, to);
    }
    let points = text.find("points = [[1.5").expect("points");
    std::fs::write(folder.path().join("own.toml"), &text[..points]).expect("a scene");
    let levee =
        |more: &[&str]| verify(folder.path(), &[&["levee", "--scene", "own.toml", "--out", "own"], more].concat());
    for (flags, said) in [
        (
            &["--sensitivity"][..],
            "--sensitivity: expected the levee of the paper's Table 3, found own, with another outline",
        ),
        (&["--variant", "feed-head"], "--variant: expected the levee of the paper's Table 3, found own"),
    ] {
        let output = levee(flags);
        assert!(output.status.code() == Some(2) && stderr(&output).contains(said), "{}", stderr(&output));
    }
    let output = levee(&["--no-vtk", "--safety-factor", "6"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stdout(&output).contains("factor of safety at 6 h: "), "{}", stdout(&output));
    let read = |name: &str| std::fs::read_to_string(folder.path().join("own").join(name)).expect(name);
    let page = read("index.html");
    assert!(page.contains("levee-safety.png"));
    assert!(
        !page.to_lowercase().contains("the paper") && page.contains("Seepage and stability of a slope: Own"),
        "{page}"
    );
    assert!(!folder.path().join("own/claims.csv").exists());
    // Limit equilibrium knows which way it falls.
    let factors = read("safety_factor.csv");
    assert!(factors.starts_with("time_h,fs_low,fs_high,"), "{factors}");
    let mut lines = factors.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let (head, line) = (lines.next().expect("a head"), lines.next().expect("a line"));
    let value = |name: &str| {
        let place = head.iter().position(|column| *column == name).expect("a column");
        line[place].parse::<f64>().expect("a number")
    };
    assert!((value("spencer") / value("fs_low") - 1.0).abs() < 0.15, "{factors}");
    // Its factors of safety are not those of another slope, and a table that was cut is not one of none.
    let other = text[..points].replace("cohesion = 20000.0", "cohesion = 20001.0");
    std::fs::write(folder.path().join("own.toml"), other).expect("a scene");
    assert!(levee(&["--no-vtk"]).status.success());
    let page = read("index.html");
    assert!(page.contains("safety_factor.csv is of another scene") && !page.contains("levee-safety.png"));
    std::fs::write(folder.path().join("own/safety_factor.csv"), "time_h,fs_low\n7.0,much\n").expect("a file");
    let output = levee(&["--no-vtk"]);
    let expected = "safety_factor.csv: expected a table that this program wrote";
    assert!(output.status.code() == Some(3) && stderr(&output).contains(expected), "{}", stderr(&output));
}

/// Scores of several folders do not overwrite each other, and those of other parameters do not stand beside each other.
#[test]
fn scores_keep_apart_what_is_not_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["one", "two"] {
        std::fs::create_dir(folder.path().join(name)).expect("a folder");
    }
    let run = |line: &str| run(folder.path(), line);
    // Nothing was answered.
    assert_eq!(run("score one two --only consolidation --out scores").status.code(), Some(1));
    for name in ["one", "two"] {
        assert!(folder.path().join(format!("scores/{name}/scores.json")).is_file(), "{name}");
    }
    assert_eq!(run("score one two --name both").status.code(), Some(2));
    assert_eq!(run("score two --only consolidation --seed 3 --out hidden").status.code(), Some(1));
    assert!(run("leaderboard scores/one scores/two --out board").status.success());
    let mixed = run("leaderboard scores/one hidden --out mixed");
    assert!(mixed.status.code() == Some(2) && stderr(&mixed).contains("[0, 3]"), "{}", stderr(&mixed));
}

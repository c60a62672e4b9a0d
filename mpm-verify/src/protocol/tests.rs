//! Neutral cases answered by this code and by made-up ones.

use super::answer::Question;
use super::case::{Case, chosen};
use super::results::{Answer, RESULTS, Row, Said, parse, read, write};
use super::score::{Verdict, score};
use super::{export, units};

/// All neutral cases.
fn all() -> Vec<Case> {
    chosen(&[], 0).expect("cases")
}

/// A neutral case by its name.
fn case(name: &str) -> Case {
    chosen(&[name.to_owned()], 0).expect(name).pop().expect(name)
}

#[test]
fn the_cases_that_were_asked_for_are_there_and_hold_no_answer() {
    let all = all();
    let names: Vec<&str> = all.iter().map(|case| case.name.as_str()).collect();
    let mut unique = names.clone();
    unique.sort_unstable();
    unique.dedup();
    assert_eq!(unique.len(), names.len(), "{names:?}");
    for name in [
        "consolidation-incompressible",
        "consolidation",
        "consolidation-double",
        "consolidation-ramp",
        "two-layers",
        "self-weight",
        "large-strain",
        "mandel",
        "cryer",
        "de-leeuw",
        "undrained-wave",
        "dynamic-column",
        "patch-test",
        "hydrostatic",
        "bar-wave",
        "rotation",
        "collapse",
        "front-down",
        "dam",
        "mc-triaxial",
        "cam-clay-oedometer",
        "infinite-slope-seepage",
        "griffiths-lane-1",
        "acads-1a",
    ] {
        assert!(names.contains(&name), "{name}: {names:?}");
    }
    for case in &all {
        let text = [&case.json()["given"], &case.json()["wanted"]].map(ToString::to_string).concat();
        assert!(!text.contains("exact") && !text.contains("band"), "{}: {text}", case.name);
        for equation in &case.equations {
            let shown = crate::book::formula::mathml(equation, pulldown_latex::config::DisplayMode::Block);
            assert!(shown.is_ok_and(|html| !html.contains("merror")), "{}: {equation}", case.name);
        }
        assert!(case.refinements.len() >= 2 && case.expected[0] >= case.expected[1], "{}", case.name);
        assert!(case.wanted.iter().all(|wanted| !wanted.times.is_empty()), "{}", case.name);
    }
}

/// What of a value is not as a schema says: keys, kinds and constants, all that ours uses.
fn misfits(value: &serde_json::Value, schema: &serde_json::Value, path: &str, found: &mut Vec<String>) {
    let kind = match value {
        serde_json::Value::Object(_) => "object",
        serde_json::Value::Array(_) => "array",
        serde_json::Value::String(_) => "string",
        serde_json::Value::Bool(_) => "boolean",
        serde_json::Value::Null => "null",
        serde_json::Value::Number(number) if number.is_f64() => "number",
        serde_json::Value::Number(_) => "integer",
    };
    let kinds: Vec<&str> = match &schema["type"] {
        serde_json::Value::Array(kinds) => kinds.iter().filter_map(|kind| kind.as_str()).collect(),
        other => other.as_str().into_iter().collect(),
    };
    let fits = kinds.is_empty() || kinds.contains(&kind) || (kind == "integer" && kinds.contains(&"number"));
    let is_one = schema.get("const").is_none_or(|own| own == value)
        && schema["enum"].as_array().is_none_or(|all| all.contains(value));
    if !(fits && is_one) {
        found.push(format!("{path}: {value}"));
    }
    if let (Some(entries), Some(known)) = (value.as_object(), schema["properties"].as_object()) {
        let required = schema["required"].as_array().into_iter().flatten().filter_map(|key| key.as_str());
        found.extend(required.filter(|key| !entries.contains_key(*key)).map(|key| format!("{path}: no {key}")));
        for (key, value) in entries {
            match known.get(key) {
                Some(schema) => misfits(value, schema, &format!("{path}.{key}"), found),
                None => found.push(format!("{path}: {key} is not known")),
            }
        }
    }
    for (number, item) in value.as_array().into_iter().flatten().enumerate().filter(|_| schema["items"].is_object()) {
        misfits(item, &schema["items"], &format!("{path}[{number}]"), found);
    }
}

#[test]
fn every_case_has_the_published_form_and_another_one_is_seen() {
    let schema: serde_json::Value = serde_json::from_str(export::FORM).expect("a schema");
    assert_eq!(schema["title"], super::case::SCHEMA);
    let of = |value: &serde_json::Value| {
        let mut found = Vec::new();
        misfits(value, &schema, "case", &mut found);
        found
    };
    for case in all() {
        assert_eq!(of(&case.json()), Vec::<String>::new(), "{}", case.name);
    }
    let mut other = all()[0].json();
    other["answer"] = 1.into();
    other["physics"]["strain"] = "huge".into();
    other["wanted"][0]["unit"] = serde_json::Value::Null;
    assert_eq!(of(&other).len(), 3, "{:?}", of(&other));
}

/// Every case of the suite that a stranger can answer is one, without a word here.
#[test]
fn a_new_case_of_the_suite_is_a_neutral_case_without_further_code() {
    let text = r#"
        title = "A column that nobody has seen"
        [[case]]
        name = "made-up"
        scene = "terzaghi-quasi-static"
        patch = { "soil.porosity" = 0.41, "water.bulk_modulus" = 3e8 }
        measure = { of = "settlement", reference = "terzaghi", relative = true }
        meshes = [5, 10]
        error = 1e-3
    "#;
    let (problem, specs) = crate::experiment::spec::Problem::parse(text, "made-up.toml").expect("a problem");
    let spec = Box::leak(Box::new(specs.into_iter().next().expect("a case")));
    let case = Case::of_spec(spec, &problem).expect("a scene").expect("a neutral case");
    assert_eq!(
        (case.name.as_str(), case.wanted[0].quantity.as_str(), case.wanted[0].times.len()),
        ("made-up", "settlement", 9)
    );
    assert_eq!(case.given["soil"]["porosity"], 0.41);
}

/// The answer of this code to a case, through files.
fn answered(case: &Case, folder: &std::path::Path) -> Answer {
    export::write(std::slice::from_ref(case), folder).expect("files");
    let question = Question::read(&folder.join(&case.name)).expect("a case");
    question.answer(&folder.join(&case.name), None).unwrap_or_else(|e| panic!("{}: {e}", case.name));
    read(&folder.join(&case.name), case)
}

#[test]
fn our_own_answers_have_the_errors_of_the_suite_to_the_digit() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in [
        "consolidation",
        "consolidation-profile",
        "consolidation-incompressible",
        "two-layers",
        "large-strain",
        "mandel",
        "de-leeuw",
        "seepage-along-slope",
        "given-start",
        "strip-stress",
    ] {
        let mut case = case(name);
        case.refinements.truncate(2);
        let answer = answered(&case, folder.path());
        assert_eq!(answer.faults, Vec::<String>::new(), "{name}");
        let (spec, scene) = (case.spec().expect("of the suite"), case.scene().expect("a scene"));
        for (refinement, rows) in &answer.levels {
            let scene = spec.on(&spec.bases().expect("scenes")[0], *refinement).expect("a mesh");
            let run = crate::experiment::run::finished(&scene).expect("a run");
            let measure = spec.measure.as_ref().expect("a measure");
            let inner = measure.of_scene(&scene).expect("a measure")(&run).expect("numbers").error();
            assert_eq!(case.compared(*refinement, rows).expect("numbers").error(), inner, "{name} on {refinement}");
        }
        assert!(scene.height > 0.0);
    }
}

#[test]
fn elements_and_bodies_are_answered_from_what_is_given() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, seed) in [("mc-triaxial", 0), ("mc-plane-strain", 5), ("cam-clay-oedometer", 3), ("rotation", 0)] {
        let mut case = chosen(&[name.to_owned()], seed).expect(name).pop().expect(name);
        case.refinements.truncate(2);
        let answer = answered(&case, folder.path());
        let score = score(&case, &answer, &Said::default(), &[]);
        // Cam-Clay takes steps of first order.
        let expected = if name.starts_with("cam") { Verdict::FirstOrder } else { Verdict::Passes };
        assert_eq!(score.verdict, expected, "{name}: {score:?}");
    }
}

/// Hidden parameters change what is given and the answer, and no error of ours.
#[test]
fn parameters_of_a_seed_are_other_problems_with_exact_solutions() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["consolidation", "two-layers", "mandel", "consolidation-cam-clay", "seepage-along-slope", "patch-test"]
    {
        let published = case(name);
        let mut hidden = published.drawn(11).expect(name);
        assert_ne!(hidden.given, published.given, "{name}");
        assert_eq!(hidden.given, published.drawn(11).expect(name).given, "{name}: the same seed");
        assert_ne!(hidden.given, published.drawn(12).expect(name).given, "{name}: another seed");
        hidden.refinements.truncate(2);
        let answer = answered(&hidden, folder.path());
        let score = score(&hidden, &answer, &Said::default(), &[]);
        assert_eq!(score.verdict, Verdict::Passes, "{name}: {score:?}");
        // What was right for the published parameters is wrong now.
        let mut copied = published.clone();
        copied.refinements.truncate(2);
        let folder = tempfile::tempdir().expect("a folder");
        let old = answered(&copied, folder.path());
        let times = |rows: &[Row]| {
            let same = |row: &Row| {
                let at = copied.wanted[row.quantity].times.iter().position(|time| *time == row.time);
                Row { time: hidden.wanted[row.quantity].times[at.expect("a time")], ..*row }
            };
            rows.iter().map(same).collect::<Vec<_>>()
        };
        let levels = old.levels.iter().map(|(level, rows)| (*level, times(rows))).collect();
        let copied = super::score::score(&hidden, &Answer { levels, faults: Vec::new() }, &Said::default(), &[]);
        assert_ne!(copied.verdict, Verdict::Passes, "{name}: {copied:?}");
    }
    assert_eq!(units::of_key("height_m"), "m");
}

#[test]
fn tables_may_be_in_any_order_and_what_is_wrong_is_told_with_its_line() {
    let case = case("consolidation");
    let time = case.wanted[0].times[0];
    let line = |level: f64, time: f64, value: &str| format!("{value},settlement,{time},,{level},\n");
    let header = "value,quantity,time_s,x_m,refinement,y_m\n";
    let rows = |except: f64| {
        let each = case
            .refinements
            .iter()
            .rev()
            .flat_map(|level| case.wanted[0].times.iter().rev().map(move |t| (*level, *t)));
        each.filter(|(level, t)| (*level, *t) != (except, time))
            .map(|(level, t)| line(level, t, "1e-3"))
            .collect::<String>()
    };
    let whole = parse(format!("{header}{}", rows(0.0)).as_bytes(), &case);
    assert_eq!((whole.levels.len(), whole.faults), (3, Vec::new()));
    let lacks = parse(format!("{header}{}", rows(20.0)).as_bytes(), &case);
    assert_eq!(lacks.levels.len(), 2);
    assert!(lacks.faults[0].contains("refinement 20: no settlement at"), "{:?}", lacks.faults);
    for (value, said) in
        [("NaN", "expected a finite number"), ("text", "expected a finite number"), ("", "expected a finite number")]
    {
        let spoilt = parse(format!("{header}{}{}", line(20.0, time, value), rows(20.0)).as_bytes(), &case);
        assert_eq!(spoilt.levels.len(), 2, "{value}");
        assert!(
            spoilt.faults[0].starts_with("results.csv:2: ") && spoilt.faults[0].contains(said),
            "{:?}",
            spoilt.faults
        );
    }
    let twice = parse(format!("{header}{}{}", rows(0.0), line(20.0, time, "1e-3")).as_bytes(), &case);
    assert!(twice.faults[0].contains("twice, lines"), "{:?}", twice.faults);
    let units =
        parse(b"refinement,quantity,time_s,x_m,y_m,value,unit\n10,settlement,0.0072874285714285714,,,1,mm\n", &case);
    assert!(units.faults[0].contains(":2: expected settlement in m, found \"mm\""), "{:?}", units.faults);
    for (garbage, said) in [
        (&b"\xff\xfe\x00"[..], "refinement"),
        (b"", "expected the columns"),
        (b"<html>nothing</html>", "expected the columns"),
        (b"refinement,quantity,time_s,x_m,y_m,value\n7,settlement,1,,,1\n", "expected a refinement"),
        (b"refinement,quantity,time_s,x_m,y_m,value\n10,depth,1,,,1\n", "expected settlement"),
    ] {
        let found = parse(garbage, &case);
        assert!(found.levels.is_empty() && found.faults.iter().any(|fault| fault.contains(said)), "{:?}", found.faults);
    }
}

#[test]
fn fields_must_have_a_number_in_every_cell() {
    let case = case("mandel");
    let folder = tempfile::tempdir().expect("a folder");
    let mut coarse = case.clone();
    coarse.refinements.truncate(1);
    let answer = answered(&coarse, folder.path());
    let mut rows = answer.levels[0].1.clone();
    assert_eq!(rows.len(), 16 * case.wanted[0].times.len());
    rows.remove(5);
    let path = folder.path().join(RESULTS);
    write(&path, &coarse, &[(4.0, rows)]).expect("a table");
    let lacks = read(folder.path(), &coarse);
    assert!(lacks.levels.is_empty() && lacks.faults[0].contains("in the cell at x = 0.3750 m"), "{:?}", lacks.faults);
}

/// A command that answers well, and others that do what they should not; each costs no other case its score.
#[cfg(unix)]
#[test]
fn garbage_of_a_solver_is_named_and_costs_no_other_result() {
    use super::code::running;
    use super::command::Limits;
    let folder = tempfile::tempdir().expect("a folder");
    let cases = chosen(&["consolidation".to_owned(), "consolidation-ramp".to_owned(), "two-layers".to_owned()], 0);
    let mut cases = cases.expect("cases");
    cases.iter_mut().for_each(|case| case.refinements.truncate(2));
    for case in &cases {
        std::fs::create_dir_all(folder.path().join("good").join(&case.name)).expect("a folder");
        let answer = answered(case, &folder.path().join("work"));
        write(&folder.path().join("good").join(&case.name).join(RESULTS), case, &answer.levels).expect("a table");
    }
    let good = folder.path().join("good");
    let limits = Limits { time: std::time::Duration::from_secs(3), memory_mib: 60.0, output_mib: 50.0 };
    let copy = format!("name=$(basename $(dirname {{case}})); cp {}/$name/results.csv {{out}}/", good.display());
    for (bad, said) in [
        ("exit 3", "exit status: 3"),
        ("kill -9 $$", "signal: 9"),
        ("sleep 30", "longer than 3 s"),
        ("head -c 80000000 /dev/zero > {out}/results.csv", "wrote more than 50 MiB"),
        ("x=$(yes | head -c 300000000)", "MiB of memory"),
        ("echo text > {out}/results.csv", "expected the columns"),
        ("printf 'refinement,quantity,time_s,x_m,y_m,value\\n10,settlement,1,,,NaN\\n' > {out}/results.csv", "no rows"),
        ("mkdir {out}/results.csv", "is no file"),
        ("true", "no results.csv"),
    ] {
        let command = format!("{copy}; if [ $name = consolidation-ramp ]; then rm -f {{out}}/results.csv; {bad}; fi");
        let out = tempfile::tempdir().expect("a folder");
        let code = running((&command, &limits), "garbage", &cases, out.path(), &|| false, &|_| {}).expect("a shell");
        let of = |name: &str| code.scores.iter().find(|score| score.case == name).expect("a score");
        let spoilt = of("consolidation-ramp");
        let told = format!("{} {}", spoilt.reason, spoilt.faults.join(" "));
        assert!(spoilt.verdict == Verdict::NotRun && told.contains(said), "{bad}: {told}");
        for name in ["consolidation", "two-layers"] {
            assert_eq!(of(name).verdict, Verdict::Passes, "{bad}: {:?}", of(name));
        }
    }
}

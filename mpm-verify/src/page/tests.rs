//! Tests of pages, and a walk over all links of a folder of reports made from small fixtures.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Component, Path, PathBuf};

use super::site::{Kind, RECORD, Report};
use super::table::{Cell, Table};
use super::verdict::{Checks, Counts, State, Tally, Verdict, WORDS};
use super::{Block, Page, Section, prose, site};
use crate::manifest::Manifest;
use crate::report::plots::axis::Axis;
use crate::report::plots::figure::{Figure, Mark, Panel, Point, Series};
use crate::report::plots::look::{BLUE, Look, Marker, nth};

/// Two lines and a cloud.
fn figure() -> Figure {
    let mut panel = Panel::new("", Axis::linear("time (s)", "time_s"), Axis::log("error (-)", "error"));
    panel.add(Series::line("a < b", nth(0), [(0.0, 1e-3), (1.0, 1.234_567e-2)]));
    panel.add(Series::line("other", nth(1), [(0.0, 1e-2), (1.0, 1e-1)]));
    let cloud = (0..100).map(|k| Point::new(f64::from(k) / 100.0, 1e-3));
    panel.add(Series::new("cloud", Look::new(BLUE, Marker::Box), Mark::Points, cloud));
    Figure {
        name: "errors",
        title: "Errors \"over\" time".to_owned(),
        caption: "The error falls at 0.5 s. Further words.".to_owned(),
        height: 200.0,
        panels: vec![panel],
        missing: Vec::new(),
    }
}

fn page() -> Page {
    let rows =
        vec![vec![Cell::new("one").linked("#table"), Cell::badge("passed", "good"), Cell::new("1.0").small("±0.1")]];
    let table = Table::new("Cases", &["case", "verdict", "error"], rows, "A note with `code`.");
    Page::new("A page")
        .verdict(Verdict::new(State::Passed, "All is well."))
        .section(Section::new("picture", "Picture").figure(&figure()))
        .section(Section::new("table", "Table").index(table))
        .section(Section::new("more", "More").folded().with(Block::Command("mpm-verify list".to_owned())))
        .section(Section::new("empty", "Nothing in it"))
        .conditions(&Manifest::new(&crate::scenes::terzaghi(), 1))
}

#[test]
fn a_page_has_verdict_picture_numbers_conditions_in_this_order() {
    let html = page().html(Path::new("reports/x/index.html")).expect("a page");
    let places =
        ["class=\"verdict\"", "id=\"fig-errors\"", "<caption", "id=\"conditions\""].map(|part| html.find(part));
    assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{places:?}");
    assert!(html.contains("<a href=\"../index.html\">All reports</a>") && !html.contains("Nothing in it"));
    for part in ["<th scope=\"row\"><a href=\"#table\">one</a></th>", "<code>code</code>", "<small>±0.1</small>"] {
        assert!(html.contains(part), "{part}");
    }
    let markdown = page().markdown(Path::new("x")).expect("a page");
    for part in ["# A page\n", "**passed**: All is well.", "| case | verdict | error |\n| --- |", "plots/errors.png"] {
        assert!(markdown.contains(part), "{part}: {markdown}");
    }
    assert!(!markdown.contains("\n\n\n"), "{markdown}");
}

#[test]
fn the_series_of_a_drawing_are_groups_that_a_legend_turns_on_and_off() {
    let html = page().html(Path::new("index.html")).expect("a page");
    for part in [
        "aria-label=\"Errors &quot;over&quot; time\"",
        "role=\"img\" aria-label=\"Errors &quot;over&quot; time. The error falls at 0.5 s.\"",
        "<g data-s=\"0\">",
        "<g data-s=\"2\"><path stroke=\"var(--p-blue)\"",
        "aria-label=\"a &lt; b\" data-l=\"0\"",
        "\"n\":\"a < b\"",
        "0.012346",
    ] {
        assert!(html.contains(part), "{part}");
    }
    assert!(!html.contains("@@") && !html.contains("#0072B2"));
    let svg = &html[html.find("<svg").expect("a drawing")..html.find("</svg>").expect("its end")];
    assert_eq!(svg.matches("<g").count(), svg.matches("</g>").count());
    // The drawing on the disk stays plain.
    let plain = crate::report::plots::svg_text(&figure()).expect("a drawing");
    assert!(!plain.contains("@@") && !plain.contains("<g") && plain.contains("#0072B2"));
}

#[test]
fn texts_may_hold_code_and_links_and_nothing_else() {
    let html = |text: &str| prose(text).to_string();
    assert_eq!(html("a <b> `c < d` [e](f.html#g)"), "a &lt;b&gt; <code>c &lt; d</code> <a href=\"f.html#g\">e</a>");
    assert_eq!(html("[0, 1] and ` alone, [x] (y)"), "[0, 1] and ` alone, [x] (y)");
}

#[test]
fn verdicts_are_counted_and_short() {
    let checks = |passed, degraded, not_established, failed| {
        Counts::Checks(Checks { passed, degraded, not_established, failed, ..Checks::default() })
    };
    let counts = checks(3, 0, 0, 1);
    assert_eq!((counts.state(), counts.total(), counts.words()), (State::Failed, 4, "3 passed, 1 failed".to_owned()));
    assert_eq!(checks(0, 0, 2, 0).state(), State::NotEstablished);
    // A default scheme that degrades is never green.
    assert_eq!((checks(30, 1, 0, 0).state(), checks(30, 1, 0, 0).state().mark()), (State::Degraded, "warn"));
    assert_eq!(serde_json::to_string(&State::NotEstablished).expect("JSON"), "\"not established\"");
}

/// A home page made from reports of each kind: runs, checks, claims and nights have counts, words and colours of their own.
#[test]
fn home_says_each_kind_of_verdict_with_its_own_word() {
    let place = tempfile::tempdir().expect("a folder");
    let root = place.path().join("reports");
    let report = |name: &str, kind: Kind, state: State, counts: Option<Counts>| {
        let folder = root.join(name);
        fs::create_dir_all(&folder).expect("a folder");
        let report = Report::new(kind).counts(counts.map(|counts| Tally::new(name, counts)));
        let page = Page::new(name).verdict(Verdict::new(state, "A sentence.")).report(report);
        page.write(&folder.join("index.html")).expect("a page");
    };
    let of = |counts: Counts| (counts.state(), Some(counts));
    let claims = Counts::Claims { reproduced: 11, not_reproduced: 9, not_comparable: 1 };
    let checks = Counts::Checks(Checks { passed: 7, not_established: 3, ..Checks::default() });
    let degraded = Counts::Checks(Checks { passed: 14, degraded: 10, stopped: 8, ..Checks::default() });
    let nights = Counts::Nights { unchanged: 4, moved: 0, worse: 0, in_part: 0 };
    let all = [
        (Kind::Levee, of(claims)),
        (Kind::Suite, of(checks)),
        (Kind::StressTests, of(degraded)),
        (Kind::Nightly, of(nights)),
    ];
    for (number, (kind, (state, counts))) in all.into_iter().enumerate() {
        report(&format!("report-{number}"), kind, state, counts);
    }
    report("a-run", Kind::Scene, State::Complete, None);
    let page = |root: &Path| fs::read_to_string(site::refresh(root).expect("a home page")).expect("a page");
    let html = page(&root);
    let badge = |mark: &str, word: &str| format!("<span class=\"badge {mark}\">{word}</span>");
    for (badge, counts) in [
        (badge("", "complete"), "1 complete"),
        (badge("warn", "degraded"), "21 passed, 10 degraded, 8 stopped with a reason, 3 not established"),
        (badge("warn", "11 of 21 reproduced"), "11 reproduced, 9 not reproduced, 1 not comparable"),
        (badge("good", "unchanged"), "4 unchanged"),
    ] {
        assert!(html.contains(&format!("{badge}</td><td>{counts}</td>")), "{badge} {counts}: {html}");
    }
    // No verdict over all, and nothing is green but what passed or has not moved.
    assert!(!html.contains("<p class=\"verdict\">"), "{html}");
    let green: Vec<&str> = html.split("badge good\">").skip(1).filter_map(|rest| rest.split('<').next()).collect();
    assert!(green.iter().all(|word| ["passed", "unchanged"].contains(word)), "{green:?}");
    report("b-run", Kind::Scene, State::Stopped, None);
    assert!(page(&root).contains(&format!("{}</td><td>1 complete, 1 stopped</td>", badge("bad", "stopped"))));
}

#[test]
fn records_of_earlier_versions_are_read() {
    let claims = r#"{"label": "Claims", "passed": 5, "failed": 2, "not_established": 1, "total": 8, "said": "", "claims": true}"#;
    let tally: Tally = serde_json::from_str(claims).expect("a tally");
    assert_eq!(tally.counts, Counts::Claims { reproduced: 5, not_reproduced: 2, not_comparable: 1 });
    let checks = r#"{"label": "Suite", "passed": 5, "failed": 2, "not_established": 1, "total": 8, "said": ""}"#;
    let tally: Tally = serde_json::from_str(checks).expect("a tally");
    assert_eq!(tally.counts.words(), "5 passed, 1 not established, 2 failed");
    let again: Tally = serde_json::from_str(&serde_json::to_string(&tally).expect("JSON")).expect("a tally");
    assert_eq!(again, tally);
    let verdict = r#"{"state": "not established", "word": "5 of 8 claims reproduced", "sentence": "S."}"#;
    let verdict: Verdict = serde_json::from_str(verdict).expect("a verdict");
    assert_eq!(verdict, Verdict::new(State::NotEstablished, "S."));
}

#[test]
fn home_is_found_from_wherever_a_report_stands() {
    let root = Path::new("/some/where");
    for (report, home) in [
        ("reports/levee", "reports"),
        ("reports/nightly/.mpm-verify.part/2026-01-01/suite", "reports"),
        ("out/levee", "out"),
        ("out/.mpm-verify.part", ""),
    ] {
        assert_eq!(site::home(&root.join(report)), root.join(home), "{report}");
    }
    let link = |page: &str| site::home_link(&root.join(page));
    assert_eq!(link("reports/accuracy/.mpm-verify.part/index.html"), "../index.html");
    assert_eq!(link("reports/nightly/.mpm-verify.part/2026-01-01/suite/index.html"), "../../../index.html");
}

#[test]
fn a_page_of_someone_else_is_never_overwritten() {
    let folder = tempfile::tempdir().expect("a folder");
    let index = folder.path().join("index.html");
    fs::write(&index, "theirs").expect("written");
    assert!(site::refresh(folder.path()).is_err());
    assert_eq!(fs::read_to_string(&index).expect("a file"), "theirs");
    // A page of a report is no home page either.
    page().write(&index).expect("a page");
    assert!(site::refresh(folder.path()).is_err());
    fs::remove_file(&index).expect("removed");
    for _ in 0..2 {
        site::refresh(folder.path()).expect("a home page");
    }
}

/// Targets of all links of a page, and the anchors that it has.
fn links(page: &Path) -> (Vec<String>, BTreeSet<String>) {
    let text = fs::read_to_string(page).expect("a page");
    let of = |name: &str| -> Vec<String> {
        let begin = format!(" {name}=\"");
        let parts = text.split(&begin).skip(1);
        parts.filter_map(|part| Some(part.split_once('"')?.0.to_owned())).collect()
    };
    let targets = [of("href"), of("src")].concat();
    (targets, of("id").into_iter().collect())
}

/// A path without `..`.
fn tidy(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut whole, part| {
        match part {
            Component::ParentDir => drop(whole.pop()),
            Component::CurDir => {}
            other => whole.push(other),
        }
        whole
    })
}

/// Follows all links from a page; returns the pages reached.
pub fn walk(start: &Path) -> BTreeSet<PathBuf> {
    let (mut reached, mut open) = (BTreeSet::new(), vec![tidy(start)]);
    while let Some(page) = open.pop() {
        if !reached.insert(page.clone()) {
            continue;
        }
        for target in links(&page).0 {
            // Sources are named by their DOI; nothing is fetched.
            if target.starts_with("https://doi.org/") {
                continue;
            }
            assert!(!target.contains("://"), "{}: {target} is not in the folder", page.display());
            let (file, anchor) = target.split_once('#').unwrap_or((&target, ""));
            let path = if file.is_empty() { page.clone() } else { tidy(&page.parent().expect("a folder").join(file)) };
            assert!(path.is_file(), "{}: {target} leads nowhere", page.display());
            let is_page = path.extension().is_some_and(|e| e == "html");
            assert!(anchor.is_empty() || !is_page || links(&path).1.contains(anchor), "{}: {target}", page.display());
            if is_page {
                open.push(path);
            }
        }
    }
    reached
}

/// All pages below a folder.
fn pages(folder: &Path, found: &mut BTreeSet<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder").flatten() {
        let path = entry.path();
        if path.is_dir() {
            pages(&path, found);
        } else if path.extension().is_some_and(|e| e == "html") {
            found.insert(path);
        }
    }
}

#[test]
fn home_reaches_every_page_and_every_page_leads_home() {
    let place = tempfile::tempdir().expect("a folder");
    let root = place.path().join("reports");
    let report = |name: &str, kind: Kind, page: Page| {
        let folder = root.join(name);
        fs::create_dir_all(folder.join("plots")).expect("a folder");
        crate::report::plots::write(&figure(), &folder.join("plots")).expect("a picture");
        let counts = Counts::Checks(Checks { passed: 2, not_established: 1, ..Checks::default() });
        let report = Report::new(kind).counts([Tally::new(name, counts)]).picture("plots/errors.svg", "errors");
        page.report(report).write(&folder.join("index.html")).expect("a page");
    };
    report("levee", Kind::Levee, page());
    report("suite", Kind::Suite, page());
    crate::report::tests::write_small(&root.join("accuracy"));
    crate::report::suite::tests::write_small(&root.join("suite"));
    crate::nightly::report::tests::write_small(&root.join("nightly"));
    // What was published of a report has no page, and is not listed.
    fs::create_dir_all(root.join("published/levee")).expect("a folder");
    fs::copy(root.join("levee").join(RECORD), root.join("published/levee").join(RECORD)).expect("copied");
    let home = site::refresh(&root).expect("a home page");
    let mut all = BTreeSet::new();
    pages(&root, &mut all);
    assert!(all.len() >= 12, "{all:?}");
    assert_eq!(walk(&home), all, "pages that home does not reach");
    for page in &all {
        assert!(walk(page).contains(&home), "{} does not lead home", page.display());
        let text = fs::read_to_string(page).expect("a page");
        assert!(text.len() < 1_500_000, "{}: {} bytes", page.display(), text.len());
        for sentence in text.split("<p class=\"verdict\">").skip(1) {
            let sentence = sentence.split("</p>").next().and_then(|s| s.rsplit("<span>").next()).unwrap_or_default();
            assert!(sentence.split_whitespace().count() <= WORDS, "{}: {sentence}", page.display());
        }
    }
    let text = fs::read_to_string(&home).expect("a page");
    assert!(!text.contains("published/levee"), "{text}");
    for part in
        ["Claims of the paper on accuracy", "Verification suite", "Nightly runs", "badge good", "plots/errors.svg"]
    {
        assert!(text.contains(part), "{part}");
    }
    // The levee first, then accuracy, then the list.
    let places = ["levee/plots/errors.svg", "accuracy/plots/at-a-glance.svg", "class=\"reports\""];
    assert!(places.map(|part| text.find(part)).is_sorted(), "{text}");
    let record: Report =
        serde_json::from_slice(&fs::read(root.join("levee").join(RECORD)).expect("a record")).expect("JSON");
    assert_eq!((record.title.as_str(), record.kind), ("A page", Kind::Levee));
    for name in ["levee", "accuracy", "suite", "nightly"] {
        let text = fs::read(root.join(name).join(RECORD)).expect("a record");
        let Report { date, made, .. } = serde_json::from_slice(&text).expect("JSON");
        let known = [&date, &made.commit, &made.sources, &made.profile].map(|text| !text.is_empty());
        assert_eq!(known, [true; 4], "{name}: date, commit, sources, profile");
    }
}

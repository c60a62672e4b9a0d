//! What `reference-data/scenes/README.md` says of a key is what the program does with it.

use mpm_core::scene::capabilities::table;
use mpm_core::scene::{Flags, LoadOn, Scene};

const PAGE: &str = include_str!("../../../reference-data/scenes/README.md");
const COLUMN: &str = include_str!("../../../reference-data/scenes/terzaghi.toml");

/// What stands between two words of the page.
fn between(start: &str, end: &str) -> &'static str {
    let (_, rest) = PAGE.split_once(start).unwrap_or_else(|| panic!("{start}"));
    rest.split_once(end).unwrap_or_else(|| panic!("{end}")).0
}

/// The bounds that the table of a section gives a key.
fn bounds(section: &str, key: &str) -> &'static str {
    let table = between(&format!("## {section}"), "\n## ");
    let row = table.lines().find(|line| line.starts_with(&format!("| `{key}` |"))).unwrap_or_else(|| panic!("{key}"));
    row.split(" | ").nth(3).expect("bounds")
}

#[test]
fn names_are_what_the_page_says() {
    let page = bounds("Top level", "name");
    let (count, rest) = page.split_once(" letters, digits, spaces and ").expect("characters");
    let most: usize = count.strip_prefix("1 to ").expect("a count").parse().expect("a number");
    let (others, ends) = rest.split_once(", with no ").expect("ends");
    assert_eq!(ends, "dot or space at its ends");
    let others: Vec<char> = others.trim_matches('`').chars().filter(|c| *c != ' ').collect();
    let accepted = |name: &str| {
        let text = COLUMN.replace("name = \"terzaghi\"", &format!("name = {}", toml::Value::from(name)));
        assert_ne!(text, COLUMN);
        Scene::parse(&text, "scene.toml").is_ok()
    };
    for c in (' '..='~').chain(['\n', '\u{e9}']) {
        let said = c.is_alphanumeric() || c == ' ' || others.contains(&c);
        assert_eq!(accepted(&format!("a{c}b")), said, "{c:?} within");
        let at_an_end = said && c != ' ' && c != '.';
        assert_eq!((accepted(&format!("{c}b")), accepted(&format!("a{c}"))), (at_an_end, at_an_end), "{c:?} at an end");
    }
    assert_eq!([0, 1, most, most + 1].map(|count| accepted(&"a".repeat(count))), [false, true, true, false]);
}

#[test]
fn a_plate_goes_with_what_the_page_says() {
    let page = bounds("`[surcharge]` (optional)", "on");
    assert!(page.ends_with("; `\"plate\"` but for `\"quasi-static\"` without `empty_cells_above`"), "{page}");
    let plate = COLUMN.replace("on = \"surface\"", "on = \"plate\"");
    let scene = |text: &str, integrator: &str| {
        let flags = Flags { integrator: Some(integrator.to_owned()), ..Flags::default() };
        Scene::parse_with(text, "scene.toml", &flags).map(|scene| scene.surcharge.expect("a load").on)
    };
    let roomy = plate.replace("[mesh]", "[mesh]\nempty_cells_above = 1");
    let plane = plate.replace("dimension = \"column\"", "dimension = \"plane-strain\"");
    let strip = plane.replace("on = \"plate\"", "on = \"plate\"\nstrip = { from = 0.0, to = 0.02 }");
    let strip = strip.replace("\"undrained-equilibrium\"", "\"unloaded\"");
    let fixed = plane.replace("left = \"roller\"", "left = \"fixed\"");
    assert!(roomy != plate && plane != plate && strip != plane && fixed != plane);
    for integrator in ["explicit", "semi-implicit", "quasi-static"] {
        assert_eq!(scene(&plate, integrator).ok(), Some(LoadOn::Plate), "{integrator}");
        let refused = scene(&strip, integrator).expect_err("refused").to_string();
        assert!(refused.contains("surcharge.strip"), "{integrator}: {refused}");
        let refused = scene(&fixed, integrator).expect_err("refused").to_string();
        assert!(refused.contains("surcharge.on"), "{integrator}: {refused}");
        match scene(&roomy, integrator) {
            Ok(on) => assert_eq!((on, integrator), (LoadOn::Plate, "quasi-static")),
            Err(refused) => assert!(refused.to_string().contains("surcharge.on"), "{integrator}: {refused}"),
        }
    }
}

#[test]
fn what_goes_together_is_the_table_of_the_program() {
    const START: &str = "<!-- table of capabilities -->\n";
    const END: &str = "<!-- end of the table -->";
    let table = table();
    if std::env::var_os("UPDATE_PAGES").is_some() {
        let (before, rest) = PAGE.split_once(START).expect("its start");
        let (_, after) = rest.split_once(END).expect("its end");
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../reference-data/scenes/README.md");
        std::fs::write(path, format!("{before}{START}{table}{END}{after}")).expect("a page");
    } else {
        assert_eq!(between(START, END), table, "UPDATE_PAGES=1 writes it anew");
    }
}

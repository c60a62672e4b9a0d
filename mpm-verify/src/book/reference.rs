//! The chapter of scene keys, made by asking the checker.
//!
//! Names and types of keys are what the checker of scenes says when it is given a key or a value that cannot be right; so are
//! the bounds, from a scene that is right but for that value. Units, defaults and meanings are those of the tables in
//! `reference-data/scenes/README.md`, the one place where they are written.

use std::fmt::Write as _;
use std::sync::LazyLock;

use mpm_core::error::SceneError;
use mpm_core::scene::{Initial, Scene, capabilities};
use toml::{Table, Value};

use crate::scenes::BUILT_IN;

const PAGE: &str = include_str!("../../../reference-data/scenes/README.md");
const HEAD: &str = include_str!("reference.md");
/// No scene has such a key.
const UNKNOWN: &str = "zzz";
/// Sections whose keys mean what those of another one mean, where the page has no row of their own.
const ALIKE: &[(&str, &str)] = &[
    ("regions", "layers"),
    ("layers", "soil"),
    ("layers", "water"),
    ("layers", ""),
    ("plates", "loads"),
    ("wells", "loads"),
    ("stages.boundaries", "boundaries"),
    ("geometry.outline", "geometry.column"),
];

/// Keys that a section shares with another one, and does not take.
const ELSEWHERE: [&str; 3] = ["layers[].polygon", "layers[].levels", "regions[].up_to"];

/// A key of a scene file.
#[derive(Debug)]
pub struct Key {
    /// Its dotted name: `[]` after a list of tables, `*` for any side of a feed.
    pub path: String,
    /// What kind of value it takes.
    pub kind: String,
    /// Whether that is a table of keys, or a list of such.
    pub holds: bool,
    /// The bounds that the checker names.
    pub bounds: Option<String>,
    /// Unit, default, bounds and meaning on the page of scene files.
    pub row: Option<[String; 4]>,
}

/// The chapter, Markdown.
pub fn chapter() -> String {
    let (mut tables, mut section) = (String::new(), None);
    for key in keys() {
        let (parent, name) = key.path.rsplit_once('.').unwrap_or(("", &key.path));
        if section.as_deref() != Some(parent) {
            let heading =
                if parent.is_empty() { "Top level".to_owned() } else { format!("`{}`", parent.replace('*', "SIDE")) };
            let head = "| key | type | unit | default | accepted | meaning |\n|---|---|---|---|---|---|";
            let _ = write!(tables, "\n## {heading}\n\n{head}\n");
            section = Some(parent.to_owned());
        }
        let [unit, default, said, meaning] = match key.row {
            None if key.holds => {
                [String::new(), String::new(), String::new(), "A table of keys, see below.".to_owned()]
            }
            row => row.unwrap_or_default(),
        };
        let unit = if unit == "integer" { "-".to_owned() } else { unit };
        let bounds = key.bounds.unwrap_or(said);
        let _ = writeln!(tables, "| `{name}` | {} | {unit} | {default} | {bounds} | {meaning} |", key.kind);
    }
    HEAD.replace("{{ capabilities }}\n", &capabilities::table()).replace("{{ keys }}", &tables)
}

/// The unit of a key by its path, `[]` after a list of tables; none for a key that the page does not know, or one without.
pub fn unit(path: &str) -> Option<String> {
    static ROWS: LazyLock<Vec<Row>> = LazyLock::new(rows);
    let sides = ["left", "right", "bottom", "top"].map(|side| format!("feed.{side}."));
    let path = sides.iter().fold(path.to_owned(), |path, side| path.replace(side, "feed.*."));
    meaning(&path, &ROWS).map(|[unit, ..]| unit).filter(|unit| !unit.is_empty())
}

/// All keys of a scene, table by table.
pub fn keys() -> Vec<Key> {
    let rows = rows();
    let scenes: Vec<Table> = BUILT_IN.iter().filter_map(|(_, text)| text.parse().ok()).collect();
    let mut all = Vec::new();
    walk(&[], &rows, &scenes, &mut all);
    all
}

fn walk(path: &[String], rows: &[Row], scenes: &[Table], all: &mut Vec<Key>) {
    let mut inner: Vec<Vec<String>> = Vec::new();
    for name in names(path) {
        let at = [path, &[name]].concat();
        let list = [path, &[format!("{}[]", at[at.len() - 1])]].concat();
        let tables = [(at.clone(), "a table"), (list, "a list of tables")];
        let holds = tables.into_iter().find(|(path, _)| !names(path).is_empty());
        let dotted = dotted(&at);
        let (kind, bounds) = match &holds {
            Some((_, kind)) => ((*kind).to_owned(), None),
            None => (kind(&at), bounds(&at, scenes)),
        };
        if ELSEWHERE.contains(&dotted.as_str()) {
            continue;
        }
        all.push(Key { row: meaning(&dotted, rows), path: dotted, kind, holds: holds.is_some(), bounds });
        // Laws of layers are those of the soil; the four feeds have the same keys; the row of a retention says its keys.
        let repeated = at.len() == 2 && at[1] == "law" && at[0] != "soil"
            || at.len() == 4 && (at[2] == "feed" && at[3] != "left" || at[2] == "retention");
        inner.extend(holds.filter(|_| !repeated).map(|(path, _)| path));
    }
    for path in inner {
        walk(&path, rows, scenes, all);
    }
}

/// The name of a key in the chapter.
fn dotted(path: &[String]) -> String {
    path.join(".").replace("feed.left.", "feed.*.")
}

/// Keys of the table at a path; none if no table is there.
fn names(path: &[String]) -> Vec<String> {
    // This one is read as a map, whose keys its reader knows.
    if path == ["initial"] {
        return ["table"].iter().chain(&Initial::KEYS).map(|name| (*name).to_owned()).collect();
    }
    let below = [path, &[UNKNOWN.to_owned()]].concat();
    let refused = refusal(&Table::new(), &below, Value::Integer(1)).filter(|error| error.found.contains(UNKNOWN));
    refused.map_or_else(Vec::new, |error| error.expected.split('`').skip(1).step_by(2).map(str::to_owned).collect())
}

/// What kind of value a key takes: what the checker expects in place of truth, or of a number.
fn kind(path: &[String]) -> String {
    let expected = |value: Value| {
        refusal(&Table::new(), path, value)
            .filter(|error| error.found.starts_with("boolean") || error.found.starts_with("floating"))
    };
    let kind = expected(Value::Boolean(true)).or_else(|| expected(Value::Float(0.5))).map(|error| error.expected);
    let kind = kind.unwrap_or_else(|| "number, word or list".to_owned());
    match kind.trim_start_matches("a ") {
        "string" => "word".to_owned(),
        "boolean" => "`true` or `false`".to_owned(),
        "list of length 2" => "two numbers".to_owned(),
        kind => kind.to_owned(),
    }
}

/// The rule that the checker names when a scene is given a value beyond it: the same for every scene that has the key, or could have it.
fn bounds(path: &[String], scenes: &[Table]) -> Option<String> {
    let parent = &path[..path.len() - 1];
    let around = scenes.iter().filter(|scene| parent.is_empty() || find(scene, parent).is_some());
    let (first, then): (Vec<_>, Vec<_>) = around.partition(|scene| find(scene, path).is_some());
    let said = |scenes: &[&Table]| scenes.iter().filter_map(|scene| beyond(scene, path)).collect::<Vec<_>>();
    let mut said = Some(said(&first)).filter(|said| !said.is_empty()).unwrap_or_else(|| said(&then));
    said.dedup();
    <[String; 1]>::try_from(said).ok().map(|[bounds]| bounds)
}

/// What the checker expects of a key in place of a value of the right type; what it says of another key beside it is no bound.
pub(super) fn beyond(scene: &Table, path: &[String]) -> Option<String> {
    let values =
        [Value::Float(-1e300), Value::Integer(-1_000_000_000), Value::String("?".to_owned()), Value::Float(1e300)];
    values.into_iter().filter_map(|value| refusal(scene, path, value)).find_map(|error| {
        let of_type = ["floating", "string", "integer"].iter().any(|start| error.found.starts_with(start));
        let of_key = error.key.replace("[]", "") == path.join(".").replace("[]", "");
        let of_others = error.expected.contains(" = ") || error.expected.contains("beside");
        (of_key && !of_type && !of_others).then_some(error.expected)
    })
}

/// The value at a path of a scene.
pub(super) fn find<'t>(scene: &'t Table, path: &[String]) -> Option<&'t Value> {
    let (first, rest) = path.split_first()?;
    let value = match first.strip_suffix("[]") {
        Some(name) => scene.get(name)?.as_array()?.first()?,
        None => scene.get(first)?,
    };
    if rest.is_empty() { Some(value) } else { find(value.as_table()?, rest) }
}

/// What a scene is refused for with one value in another's place.
fn refusal(scene: &Table, path: &[String], value: Value) -> Option<SceneError> {
    let mut scene = scene.clone();
    set(&mut scene, path, value)?;
    Scene::parse(&toml::to_string(&scene).ok()?, "scene.toml").err()
}

fn set(table: &mut Table, path: &[String], value: Value) -> Option<()> {
    let (first, rest) = path.split_first()?;
    let (name, is_list) = first.strip_suffix("[]").map_or((first.as_str(), false), |name| (name, true));
    if rest.is_empty() {
        table.insert(name.to_owned(), value);
        return Some(());
    }
    let empty = || Value::Table(Table::new());
    let inner = table.entry(name).or_insert_with(|| if is_list { Value::Array(vec![empty()]) } else { empty() });
    let inner = if is_list { inner.as_array_mut()?.first_mut()? } else { inner };
    set(inner.as_table_mut()?, rest, value)
}

/// A row of a table of the page: section, key, and unit, default, bounds, meaning.
type Row = (String, String, [String; 4]);

/// The rows of all tables of keys on the page. A row of several keys is one of each.
fn rows() -> Vec<Row> {
    let (mut rows, mut section, mut head) = (Vec::new(), String::new(), Vec::new());
    for line in PAGE.lines() {
        if let Some(heading) = line.strip_prefix("## ").or_else(|| line.strip_prefix("### ")) {
            let name = heading.split('`').nth(1).unwrap_or_default();
            section = name.trim_matches(['[', ']']).to_owned();
        }
        let line = line.trim();
        let inside = line.strip_prefix('|').and_then(|line| line.strip_suffix('|')).unwrap_or(line);
        let cells: Vec<&str> = inside.split('|').map(str::trim).collect();
        if line.starts_with("|--") {
            continue;
        }
        match line.starts_with("| ") {
            true if cells[0] == "key" => head = cells.iter().map(|cell| (*cell).to_owned()).collect(),
            true if !head.is_empty() && cells[0].contains('`') => {
                let cell = |name: &str| head.iter().position(|h| h == name).and_then(|i| cells.get(i));
                let of = ["unit", "default", "bounds", "meaning"]
                    .map(|name| cell(name).copied().unwrap_or_default().to_owned());
                let keys: Vec<&str> = cells[0].split('`').skip(1).step_by(2).collect();
                let before = keys[0].rsplit_once('.').map_or("", |(before, _)| before);
                for (i, key) in keys.iter().enumerate() {
                    // `feed.left`, `.right`: what stands before the dot is that of the first.
                    let key = key.strip_prefix('.').map_or_else(|| (*key).to_owned(), |key| format!("{before}.{key}"));
                    // As many units or defaults as keys are one for each.
                    let own = |cell: &String| {
                        let parts: Vec<&str> = cell.split(", ").collect();
                        if parts.len() == keys.len() { parts[i].to_owned() } else { cell.clone() }
                    };
                    let [unit, default, bounds, meaning] = &of;
                    rows.push((section.clone(), key, [own(unit), own(default), bounds.clone(), meaning.clone()]));
                }
            }
            true => {}
            false => head.clear(),
        }
    }
    rows
}

/// What the page says of a key: in its section or one around it, else where the same key stands, else of the table that it is in.
fn meaning(path: &str, rows: &[Row]) -> Option<[String; 4]> {
    let plain = path.replace("[]", "");
    let elsewhere = || {
        ALIKE.iter().find_map(|(section, other)| {
            let rest = plain.strip_prefix(section)?.strip_prefix('.')?;
            meaning(format!("{other}.{rest}").trim_start_matches('.'), rows)
        })
    };
    row_of(&plain, rows).or_else(elsewhere).or_else(|| row_of(plain.rsplit_once('.')?.0, rows))
}

fn row_of(path: &str, rows: &[Row]) -> Option<[String; 4]> {
    let parts: Vec<&str> = path.split('.').collect();
    (0..parts.len()).rev().find_map(|i| {
        let (section, key) = (parts[..i].join("."), parts[i..].join("."));
        rows.iter().find(|row| row.0 == section && row.1 == key).map(|row| row.2.clone())
    })
}

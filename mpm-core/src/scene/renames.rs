//! Old names in scene files: read for one version as what they are called now, with a warning. The names stand in
//! `reference-data/renames.csv`, whose third column says what a row renames.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

const TABLE: &str = include_str!("../../../reference-data/renames.csv");
const KEY: &str = "key of scene files";
const VALUE_OF: &str = "value of ";

/// An old name that was found.
pub(super) struct Renamed {
    /// Place of the key or the value.
    pub span: Range<usize>,
    /// Dotted name of the key, as it is now.
    pub key: String,
    /// What stands there, and what it is called now.
    pub names: [&'static str; 2],
}

/// Rows of the table: old name, new name, what they name.
fn rows() -> impl Iterator<Item = [&'static str; 3]> {
    TABLE.lines().skip(1).filter_map(|line| {
        let mut words = line.splitn(3, ',');
        Some([words.next()?, words.next()?, words.next()?])
    })
}

/// The dotted name of a key as it is now; `stages.0.clock` keeps its number.
pub(super) fn current(key: &str) -> String {
    let is_index = |part: &&str| *part != "last" && part.parse::<usize>().is_err();
    let plain: Vec<&str> = key.split('.').filter(is_index).collect();
    let plain = plain.join(".");
    let new = rows().find(|[old, _, of]| *of == KEY && *old == plain).map(|[_, new, _]| new);
    match (new, key.rsplit_once('.')) {
        (Some(new), Some((tables, _))) => format!("{tables}.{}", last(new)),
        (Some(new), None) => new.to_owned(),
        (None, _) => key.to_owned(),
    }
}

/// Gives every old name in a table its new one. A key that is there under both names keeps both, and the checker refuses the
/// old one.
pub(super) fn rename(table: &mut DeTable<'_>) -> Vec<Renamed> {
    let mut found = Vec::new();
    for [old, new, of] in rows() {
        if of == KEY {
            let (tables, name) = old.rsplit_once('.').unwrap_or(("", old));
            in_tables(table, tables, &mut |table| {
                if table.contains_key(last(new)) {
                    return;
                }
                if let Some((key, value)) = table.remove_entry(name) {
                    found.push(Renamed { span: key.span(), key: new.to_owned(), names: [name, last(new)] });
                    table.insert(Spanned::new(key.span(), last(new).into()), value);
                }
            });
        } else if let Some(key) = of.strip_prefix(VALUE_OF) {
            let (tables, name) = key.rsplit_once('.').unwrap_or(("", key));
            in_tables(table, tables, &mut |table| {
                if let Some(value) = table.get_mut(name).filter(|value| value.get_ref().as_str() == Some(old)) {
                    found.push(Renamed { span: value.span(), key: key.to_owned(), names: [old, new] });
                    *value.get_mut() = DeValue::String(new.into());
                }
            });
        }
    }
    found
}

fn last(key: &str) -> &str {
    key.rsplit_once('.').map_or(key, |(_, name)| name)
}

/// Calls something with each table of a dotted name; a list has several.
fn in_tables<'i>(table: &mut DeTable<'i>, path: &str, act: &mut dyn FnMut(&mut DeTable<'i>)) {
    if path.is_empty() {
        return act(table);
    }
    let (first, rest) = path.split_once('.').unwrap_or((path, ""));
    match table.get_mut(first).map(Spanned::get_mut) {
        Some(DeValue::Table(inner)) => in_tables(inner, rest, act),
        Some(DeValue::Array(list)) => {
            for element in list.as_mut() {
                if let DeValue::Table(inner) = element.get_mut() {
                    in_tables(inner, rest, act);
                }
            }
        }
        _ => {}
    }
}

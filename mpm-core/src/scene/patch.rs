//! Changes of a scene: keys of its file set or taken out, then all of it checked again.

use std::ops::Range;
use std::sync::Arc;

use serde::Serialize;
use toml::de::{DeArray, DeTable, DeValue};
use toml::{Spanned, Value};

use super::flags::{Flags, finer};
use super::renames::{self, Renamed};
use super::{Scene, check};
use crate::error::SceneError;

/// What a key of a scene becomes: a number, a word, a list, a table, or nothing.
///
/// Everything that can be written as TOML converts to it, among it the choices of [`crate::scene`]; `None` takes the key out.
/// Numbers keep all their bits.
#[derive(Debug, Clone)]
pub struct Change(Result<Option<Value>, toml::ser::Error>);

impl Change {
    /// The key is taken out, if it is there.
    pub const NONE: Self = Self(Ok(None));

    /// What it becomes.
    pub(super) fn value(self) -> Result<Option<Value>, toml::ser::Error> {
        self.0
    }
}

impl<T: Serialize> From<T> for Change {
    fn from(value: T) -> Self {
        /// TOML has no word for nothing: an entry that is `None` is left out of its table.
        #[derive(Serialize)]
        struct Entry<T> {
            value: T,
        }
        Self(toml::Table::try_from(Entry { value }).map(|mut table| table.remove("value")))
    }
}

/// One changed key.
#[derive(Debug, Clone)]
pub(super) struct Edit {
    /// The flag of the command line that asks for it; else it is that of a patch.
    pub flag: Option<&'static str>,
    /// Its dotted name.
    pub key: String,
    /// What it becomes, as TOML; `None` if it is taken out.
    text: Option<String>,
}

impl Edit {
    pub fn new(flag: Option<&'static str>, key: &str, change: Change) -> Result<Self, SceneError> {
        let mut edit = Self { flag, key: renames::current(key), text: None };
        match change.0 {
            Ok(value) => edit.text = value.map(|value| value.to_string()),
            Err(why) => return Err(edit.refused("a value that TOML can hold", why)),
        }
        Ok(edit)
    }

    /// The name of a key that this edit holds, in a refusal.
    pub fn named(&self, key: &str) -> String {
        self.flag.map_or_else(|| format!("patch: {key}"), str::to_owned)
    }

    fn refused(&self, expected: impl ToString, found: impl ToString) -> SceneError {
        SceneError::new((String::new(), 0), self.named(&self.key), expected.to_string(), found.to_string())
    }
}

/// What a scene was made from: the text of its file, and what was changed since.
#[derive(Debug, Clone)]
pub(super) struct Source {
    pub text: Arc<str>,
    /// `None` for one that was written anew.
    pub file: Option<Arc<str>>,
    pub edits: Vec<Edit>,
}

impl Source {
    /// The edit that a value came from, if it is not from the file.
    pub fn edit(&self, span: &Range<usize>) -> Option<&Edit> {
        self.edits.get(usize::MAX - span.start)
    }

    /// What flags change, and the keys that they leave out.
    pub fn flagged(&self, flags: &Flags) -> Result<(Vec<Edit>, Vec<String>), SceneError> {
        let (table, _) = self.table().map_err(|why| check::unreadable(self, why))?;
        flags.edits(table.get_ref())
    }

    /// The keys of the file under their present names, each with its place, and the edits of them; and the old names. Edits have
    /// places that no file has, counted down from the largest number, so that a refusal can name them.
    pub fn table(&self) -> Result<(Spanned<DeTable<'_>>, Vec<Renamed>), Unreadable> {
        let mut table = DeTable::parse(&self.text).map_err(Unreadable::Text)?;
        let mut renamed = renames::rename(table.get_mut());
        for (i, edit) in self.edits.iter().enumerate() {
            let place = usize::MAX - i..usize::MAX - i;
            let read = |text| DeValue::parse(text).map(|value| placed(value.into_inner(), &place));
            let value = edit.text.as_deref().map(read).transpose();
            let value = value.map_err(|error| Unreadable::Edit(edit.refused("a value that TOML can hold", error)))?;
            let path: Vec<&str> = edit.key.split('.').collect();
            set(table.get_mut(), &path, value, &place)
                .map_err(|[expected, found]| Unreadable::Edit(edit.refused(expected, found)))?;
        }
        renamed.extend(renames::rename(table.get_mut()));
        Ok((table, renamed))
    }
}

/// Why there is no table of keys.
pub(super) enum Unreadable {
    /// The text is no TOML.
    Text(toml::de::Error),
    /// There is no such key to change.
    Edit(SceneError),
}

/// The value of a dotted key, if it is there; an element of a list by its number.
pub(super) fn value<'t, 'i>(table: &'t DeTable<'i>, key: &str) -> Option<&'t DeValue<'i>> {
    let (first, rest) = key.split_once('.').map_or((key, None), |(first, rest)| (first, Some(rest)));
    let below = |value: &'t DeValue<'i>, part: &str| match value {
        DeValue::Table(table) => table.get(part).map(Spanned::get_ref),
        DeValue::Array(list) => list.get(part.parse::<usize>().ok()?).map(Spanned::get_ref),
        _ => None,
    };
    rest.into_iter().flat_map(|rest| rest.split('.')).try_fold(table.get(first)?.get_ref(), below)
}

/// A value and all in it at one place.
fn placed<'i>(value: DeValue<'i>, place: &Range<usize>) -> Spanned<DeValue<'i>> {
    let inner = |value: Spanned<DeValue<'i>>| placed(value.into_inner(), place);
    let value = match value {
        DeValue::Array(list) => DeValue::Array(list.into_iter().map(inner).collect()),
        DeValue::Table(table) => {
            let key = |key: Spanned<_>| Spanned::new(place.clone(), key.into_inner());
            DeValue::Table(table.into_iter().map(|(name, value)| (key(name), inner(value))).collect())
        }
        value => value,
    };
    Spanned::new(place.clone(), value)
}

/// Gives the key at a place, or the one whose value is there, another name, or takes it out. Whether it was found.
pub(super) fn correct(table: &mut DeTable<'_>, span: &Range<usize>, name: Option<&str>) -> bool {
    let here = table.iter().find(|(key, value)| key.span() == *span || value.span() == *span);
    let here = here.map(|(key, _)| key.get_ref().to_string());
    if let Some((key, value)) = here.and_then(|key| table.remove_entry(key.as_str())) {
        if let Some(name) = name.filter(|name| !table.contains_key(*name)) {
            table.insert(Spanned::new(key.span(), name.to_owned().into()), value);
        }
        return true;
    }
    table.iter_mut().any(|(_, value)| correct_in(value.get_mut(), span, name))
}

/// The same below a value.
fn correct_in(value: &mut DeValue<'_>, span: &Range<usize>, name: Option<&str>) -> bool {
    match value {
        DeValue::Table(table) => correct(table, span, name),
        DeValue::Array(list) => list.as_mut().iter_mut().any(|element| correct_in(element.get_mut(), span, name)),
        _ => false,
    }
}

type Set = Result<(), [String; 2]>;

/// Sets or takes out what a path leads to. Tables on the way that are not there are made. What was expected and found, if the
/// path leads nowhere.
fn set<'i>(
    table: &mut DeTable<'i>,
    path: &[&'i str],
    value: Option<Spanned<DeValue<'i>>>,
    place: &Range<usize>,
) -> Set {
    let Some((first, rest)) = path.split_first() else { return Ok(()) };
    let key = || Spanned::new(place.clone(), (*first).into());
    match (rest, value) {
        ([], Some(value)) => {
            table.insert(key(), value);
            Ok(())
        }
        ([], None) => {
            table.remove(*first);
            Ok(())
        }
        (rest, value) => {
            if value.is_none() && !table.contains_key(*first) {
                return Ok(());
            }
            let empty = || Spanned::new(place.clone(), DeValue::Table(DeTable::new()));
            set_in(table.entry(key()).or_insert_with(empty).get_mut(), rest, value, place)
        }
    }
}

/// The same below a table or a list.
fn set_in<'i>(
    inner: &mut DeValue<'i>,
    path: &[&'i str],
    value: Option<Spanned<DeValue<'i>>>,
    place: &Range<usize>,
) -> Set {
    let list = match inner {
        DeValue::Table(table) => return set(table, path, value, place),
        DeValue::Array(list) => list,
        other => return Err(["a table or a list above it".to_owned(), other.type_str().to_owned()]),
    };
    let Some((index, rest)) = path.split_first() else { return Ok(()) };
    let count = list.len();
    let at = if *index == "last" { count.wrapping_sub(1) } else { index.parse().unwrap_or(usize::MAX) };
    match (rest, value) {
        ([], Some(value)) if at == count => list.push(value),
        _ if at >= count => {
            return Err([format!("a number below {count}, the length of the list"), format!("`{index}`")]);
        }
        ([], Some(value)) => list.as_mut()[at] = value,
        ([], None) => {
            let kept = std::mem::replace(list, DeArray::new()).into_iter().enumerate().filter(|(i, _)| *i != at);
            *list = kept.map(|(_, element)| element).collect();
        }
        (rest, value) => return set_in(list.as_mut()[at].get_mut(), rest, value, place),
    }
    Ok(())
}

impl Scene {
    /// The scene with some keys of its file changed, as if they stood there, and all of it checked again: `mesh.cell`,
    /// `stages.0.until.time`, `stages.last.until`. What a file leaves to be found from other keys is found again.
    ///
    /// # Errors
    /// As [`Scene::parse`]; what a patch changed is named in place of file and line.
    pub fn patched<K: AsRef<str>>(&self, changes: &[(K, Change)]) -> Result<Self, SceneError> {
        let edit = |(key, change): &(K, Change)| Edit::new(None, key.as_ref(), change.clone());
        self.with_edits(changes.iter().map(edit).collect::<Result<_, _>>()?)
    }

    /// A number of the scene's file, by its dotted key: `water.hydraulic_conductivity`, `layers.1.porosity`.
    pub fn number(&self, key: &str) -> Option<f64> {
        let (table, _) = self.source.table().ok()?;
        let number = value(table.get_ref(), key)?;
        number
            .as_float()
            .map(|number| number.as_str())
            .or(number.as_integer().map(|number| number.as_str()))?
            .parse()
            .ok()
    }

    /// The scene on cells of another size (m); as many empty cells as keep the empty space beside and above.
    ///
    /// # Errors
    /// As [`Scene::patched`].
    pub fn with_cell(&self, cell: f64) -> Result<Self, SceneError> {
        self.with_edits(finer(None, cell, self.cell, [self.empty_cells_above, self.empty_cells_beside])?)
    }

    /// The scene on a mesh of so many cells over its height, with the same empty space around it.
    ///
    /// # Errors
    /// As [`Scene::patched`].
    pub fn with_rows(&self, rows: usize) -> Result<Self, SceneError> {
        self.with_cell(self.height / rows as f64)
    }

    fn with_edits(&self, edits: Vec<Edit>) -> Result<Self, SceneError> {
        let mut source = Source::clone(&self.source);
        source.edits.extend(edits);
        let mut scene = Scene::checked(&Arc::new(source))?;
        scene.fields.force = self.force;
        scene.fields.left_out.clone_from(&self.left_out);
        Ok(scene)
    }

    /// The scene, to be run with a step above the stability limit too.
    pub fn forced(mut self) -> Self {
        self.fields.force = true;
        self
    }
}

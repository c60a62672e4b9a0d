//! All faults of a file at once, and names that were probably meant.

use super::super::Fields;
use super::Checked;
use crate::error::SceneError;

/// No refusal lists more faults.
pub(super) const MOST_FAULTS: usize = 20;

/// Faults of a scene, in the order in which they were found.
#[derive(Default)]
pub(super) struct Faults(Vec<SceneError>);

impl Faults {
    /// What was checked, or `None` after a note of what is wrong with it.
    pub fn take<T>(&mut self, checked: Checked<T>) -> Option<T> {
        checked.map_err(|fault| self.0.extend(fault.apart())).ok()
    }

    /// Replaces a usual value by the one that is checked, if that is sound.
    pub fn or_keep<T: Copy>(&mut self, value: &mut T, check: impl Fn(T) -> Checked<T>) {
        if let Some(checked) = self.take(check(*value)) {
            *value = checked;
        }
    }

    /// Checks a field of a scene, and sets it if it is sound.
    pub fn set<T>(
        &mut self,
        scene: &mut Fields,
        field: impl Fn(&mut Fields) -> &mut T,
        check: impl Fn(&Fields) -> Checked<T>,
    ) {
        if let Some(value) = self.take(check(scene)) {
            *field(scene) = value;
        }
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The first fault with all others after it: one to each key and line.
    pub fn refusal(self) -> Option<SceneError> {
        let mut list = self.0.into_iter();
        let mut first = list.next()?;
        let mut seen = vec![(first.line, first.key.clone())];
        for fault in list {
            let place = (fault.line, fault.key.clone());
            if seen.len() < MOST_FAULTS && !seen.contains(&place) {
                seen.push(place);
                first.notes_mut().more.push(fault);
            }
        }
        Some(first)
    }

    /// Something that was found, if nothing is wrong.
    pub fn or<T>(self, found: Option<T>) -> Checked<T> {
        match (self.refusal(), found) {
            (Some(refusal), _) => Err(refusal),
            (None, Some(found)) => Ok(found),
            (None, None) => unreachable!("what is not there has a fault"),
        }
    }
}

/// The word of a list that somebody probably meant by another: the only one that contains it, or the one that differs by the fewest letters.
pub(super) fn nearest<'a>(word: &str, words: &[&'a str]) -> Option<&'a str> {
    let plain = |word: &str| word.to_lowercase().replace('-', "_");
    let word = plain(word);
    let mut containing = words.iter().filter(|other| word.len() > 3 && plain(other).contains(&word));
    if let (Some(only), None) = (containing.next(), containing.next()) {
        return Some(only);
    }
    let distance = |other: &str| strsim::damerau_levenshtein(&word, &plain(other));
    let near = words.iter().map(|other| (distance(other), *other)).min_by_key(|(distance, _)| *distance);
    let few = (word.chars().count() / 3).max(1);
    near.filter(|(distance, other)| *distance <= few && *distance < other.len()).map(|(_, other)| other)
}

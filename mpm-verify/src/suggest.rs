//! "Did you mean": the names nearest to one that does not exist.

/// Names that are offered.
const OFFERED: usize = 3;

/// The names nearest to a word: those that contain it first, then by edit distance, each in the order given.
pub fn nearest<T: AsRef<str>>(word: &str, names: impl IntoIterator<Item = T>) -> Vec<T> {
    let word = word.to_lowercase();
    let distance = |name: &str| match name.contains(&word) {
        true if !word.is_empty() => 0,
        _ => strsim::damerau_levenshtein(&word, name),
    };
    let mut names: Vec<T> = names.into_iter().collect();
    names.sort_by_key(|name| distance(name.as_ref()));
    names.truncate(OFFERED);
    names
}

/// Names as a sentence lists them: `a, b or c`.
pub fn listed<T: AsRef<str>>(names: &[T]) -> String {
    let names: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
    match names.as_slice() {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [others @ .., last] => format!("{} or {last}", others.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_names_come_first() {
        let names = ["dry-bar", "mandel", "mandel-profile", "terzaghi", "terzaghi-gimp", "undrained"];
        assert_eq!(nearest("terzagi", names)[0], "terzaghi");
        assert_eq!(nearest("Mandle", names)[0], "mandel");
        assert_eq!(nearest("profile", names)[0], "mandel-profile");
        assert_eq!(nearest("", names).len(), 3);
        assert_eq!(listed(&["a", "b", "c"]), "a, b or c");
        assert_eq!((listed(&["a"]), listed::<&str>(&[])), ("a".to_owned(), String::new()));
    }
}

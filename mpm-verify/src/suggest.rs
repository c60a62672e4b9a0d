//! "Did you mean": the names nearest to one that does not exist.

/// Names that are offered.
const OFFERED: usize = 3;

/// The names nearest to a word: those that contain it first, then by edit distance to the name or to its beginning, each in the order
/// given. Names that have little in common with the word are left out if others have more.
pub fn nearest<T: AsRef<str>>(word: &str, names: impl IntoIterator<Item = T>) -> Vec<T> {
    let word = word.to_lowercase();
    let length = word.chars().count();
    let distance = |name: &str| {
        if !word.is_empty() && name.contains(&word) {
            return 0;
        }
        let begins: String = name.chars().take(length + 1).collect();
        strsim::damerau_levenshtein(&word, name).min(1 + strsim::damerau_levenshtein(&word, &begins))
    };
    let mut names: Vec<(usize, T)> = names.into_iter().map(|name| (distance(name.as_ref()), name)).collect();
    names.sort_by_key(|(distance, _)| *distance);
    let near = names.iter().filter(|(distance, _)| *distance <= length.div_ceil(3).max(2)).count();
    names.truncate(if near > 0 { near.min(OFFERED) } else { OFFERED });
    names.into_iter().map(|(_, name)| name).collect()
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
        assert_eq!(nearest("terzagi", names), ["terzaghi", "terzaghi-gimp"]);
        assert_eq!(nearest("Mandle", names)[0], "mandel");
        assert_eq!(nearest("profile", names)[0], "mandel-profile");
        assert_eq!(nearest("", names).len(), 3);
        assert_eq!(listed(&["a", "b", "c"]), "a, b or c");
        assert_eq!((listed(&["a"]), listed::<&str>(&[])), ("a".to_owned(), String::new()));
    }
}

//! The faults: what a tired programmer, or a careless merge, would leave behind. Each is a patch file with its reason above it.

use std::ops::Range;

use crate::error::Error::{self, Unfit};

/// The files, by their names.
const FILES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/mutants.rs"));

/// A fault: a piece of a source file, and what stands there in its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mutant {
    /// Its name.
    pub name: &'static str,
    /// What is wrong, in words.
    pub what: String,
    /// The file, from the root of the workspace.
    pub file: String,
    /// The lines that are changed, with those around them.
    old: String,
    /// The same with the fault.
    new: String,
}

/// All faults, in the order of their names.
///
/// # Errors
/// A file that is no patch of one place.
pub fn mutants() -> Result<Vec<Mutant>, Error> {
    FILES.iter().map(|(name, text)| Mutant::parse(name, text)).collect()
}

impl Mutant {
    /// Reads a patch: a line of reason, the name of the file, one hunk.
    ///
    /// # Errors
    /// What is missing.
    pub fn parse(name: &'static str, text: &str) -> Result<Self, Error> {
        let what = text.lines().next().unwrap_or_default().trim_end_matches('.').to_owned();
        let file = text.lines().find_map(|line| line.strip_prefix("+++ b/")).ok_or(Unfit("no line +++ b/FILE"));
        let file = file.map_err(|why| why.of(name))?.to_owned();
        let mut hunks = text.split("\n@@ ").skip(1);
        let (Some(hunk), None) = (hunks.next(), hunks.next()) else { return Err(Unfit("expected one hunk").of(name)) };
        let lines = hunk.split_inclusive('\n').skip(1);
        let of = |other: char| lines.clone().filter(|line| !line.starts_with(other)).map(|line| &line[1..]).collect();
        Ok(Self { name, what, file, old: of('+'), new: of('-') })
    }

    /// Where the fault goes in the text of its file, and what stands there with a switch in the words `on`.
    ///
    /// # Errors
    /// A patch that does not fit, or that no expression and no statement holds.
    pub fn switched(&self, text: &str, on: &str) -> Result<(Range<usize>, String), Error> {
        let found: Vec<usize> = text.match_indices(&self.old).map(|(at, _)| at).collect();
        let [at] = found[..] else {
            let found = format!("them {} times", found.len());
            return Err(Error::refused(self.name, format!("the lines of the patch once in {}", self.file), found));
        };
        let (piece, of_new, whole) =
            piece(&self.old, &self.new).ok_or_else(|| Unfit("no expression holds the change").of(self.name))?;
        let (old, new) = (&self.old[piece.clone()], &self.new[of_new]);
        let choice = format!("if {on} {{ {new} }} else {{ {old} }}");
        Ok((at + piece.start..at + piece.end, if whole { choice } else { format!("({choice})") }))
    }
}

/// Words of the language that are one; all else is single characters, names and numbers.
const SIGNS: [&str; 21] = [
    "..=", "<<=", ">>=", "::", "->", "=>", "==", "!=", "<=", ">=", "&&", "||", "+=", "-=", "*=", "/=", "%=", "&=",
    "|=", "^=", "..",
];

/// Where the tokens of a text are; comments are none.
fn tokens(text: &str) -> Vec<Range<usize>> {
    let mut all = Vec::new();
    let mut at = 0;
    while let Some(first) = text[at..].chars().next() {
        let rest = &text[at..];
        let is_name = |c: char| c.is_alphanumeric() || c == '_';
        let long = if first.is_whitespace() {
            at += first.len_utf8();
            continue;
        } else if rest.starts_with("//") {
            at += rest.find('\n').unwrap_or(rest.len());
            continue;
        } else if first == '"' {
            2 + rest[1..].find('"').unwrap_or(rest.len() - 2)
        } else if is_name(first) {
            rest.find(|c| !is_name(c)).unwrap_or(rest.len())
        } else {
            SIGNS.iter().find(|sign| rest.starts_with(**sign)).map_or(first.len_utf8(), |sign| sign.len())
        };
        all.push(at..at + long);
        at += long;
    }
    all
}

/// How much deeper in brackets a text ends, if it never comes out of those that it is in.
fn depth(words: &[&str]) -> Option<usize> {
    words.iter().try_fold(0_usize, |depth, word| match *word {
        "(" | "[" | "{" => Some(depth + 1),
        ")" | "]" | "}" => depth.checked_sub(1),
        _ => Some(depth),
    })
}

/// Whether one of these words stands outside of all brackets.
fn has(words: &[&str], one_of: &[&str]) -> bool {
    (0..words.len()).any(|i| one_of.contains(&words[i]) && depth(&words[..i]) == Some(0))
}

/// The smallest expression or row of statements of two texts that holds all that differs: where it is in both, and whether it is
/// of whole statements.
fn piece(old: &str, new: &str) -> Option<(Range<usize>, Range<usize>, bool)> {
    let places = [tokens(old), tokens(new)];
    let words = [(old, &places[0]), (new, &places[1])]
        .map(|(text, places)| -> Vec<&str> { places.iter().map(|place| &text[place.clone()]).collect() });
    let [a, b] = [&words[0], &words[1]];
    let same = a.iter().zip(b).take_while(|(a, b)| a == b).count();
    let most = a.len().min(b.len()) - same;
    let tail = a.iter().rev().zip(b.iter().rev()).take(most).take_while(|(a, b)| a == b).count();
    for first in (1..=same).rev() {
        let before = a[first - 1];
        let starts = ["{", ";", "}"].contains(&before);
        let opens = ["(", "[", ",", ":", "=", "=>", "+=", "-=", "*=", "/=", "|", "return"].contains(&before);
        let condition = ["if", "while", "match", "in"].contains(&before);
        if !(starts || opens || condition) {
            continue;
        }
        for kept in (1..=tail).rev() {
            let mids = [&a[first..a.len() - kept], &b[first..b.len() - kept]];
            if mids.iter().any(|mid| mid.is_empty() || depth(mid) != Some(0)) {
                continue;
            }
            let after = a[a.len() - kept];
            let ends = [")", "]", "}", ",", ";"].contains(&after) || (condition && after == "{");
            // What a reference borrows must outlive the choice.
            let expression =
                ends && mids.iter().all(|mid| !["let", "&"].contains(&mid[0]) && !has(mid, &[";", ",", "=>"]));
            let statements =
                starts && mids[0][0] != "let" && mids.iter().all(|mid| [";", "}"].contains(&mid[mid.len() - 1]));
            if expression || statements {
                let [of_old, of_new] = [0, 1].map(|i| places[i][first].start..places[i][words[i].len() - kept - 1].end);
                return Some((of_old, of_new, !expression));
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planted(old: &str, new: &str) -> String {
        let mutant = Mutant { name: "a", what: String::new(), file: "b.rs".into(), old: old.into(), new: new.into() };
        let (place, text) = mutant.switched(old, "on").expect("it fits");
        format!("{}{text}{}", &old[..place.start], &old[place.end..])
    }

    #[test]
    fn expressions_and_statements_get_a_switch() {
        assert_eq!(planted("{ x = a + b; }", "{ x = a - b; }"), "{ x = (if on { a - b } else { a + b }); }");
        assert_eq!(planted("; f(a, b[i])", "; f(a, b[j])"), "; f(a, b[(if on { j } else { i })])");
        assert_eq!(planted("{ a.go()?; }", "{ let _ = a; }"), "{ if on { let _ = a; } else { a.go()?; } }");
        assert_eq!(planted("; a += b;\n}", "; a -= b;\n}"), "; (if on { a -= b } else { a += b });\n}");
        assert_eq!(planted("{ if a && b { c }", "{ if a { c }"), "{ if (if on { a } else { a && b }) { c }");
        assert_eq!(planted("; f(&[0]).0\n}", "; f(all).0\n}"), "; (if on { f(all).0 } else { f(&[0]).0 })\n}");
        assert_eq!(planted("(|x| x + 1)", "(|x| x)"), "(|x| (if on { x } else { x + 1 }))");
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let mutant = Mutant::parse("a", "Why.\n\n--- a/b.rs\n+++ b/b.rs\n@@ -1 +1 @@\n-x\n+y\n").expect("a patch");
        assert_eq!((mutant.what.as_str(), mutant.file.as_str(), mutant.old.as_str()), ("Why", "b.rs", "x\n"));
        assert!(mutant.switched("x\nx\n", "on").expect_err("twice").to_string().contains("found them 2 times"));
        assert!(mutant.switched("x\n", "on").expect_err("no statement").to_string().contains("no expression"));
        let arm = Mutant { old: "{ Some(c) => c, }".into(), new: "{ Some(_) => d, }".into(), ..mutant };
        assert!(arm.switched("{ Some(c) => c, }", "on").is_err(), "an arm of a match is no expression");
        assert!(Mutant::parse("a", "Why.").is_err());
    }

    #[test]
    fn every_patch_fits_its_file() {
        let all = mutants().expect("patches");
        for one in &all {
            let root = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
            let text = std::fs::read_to_string(format!("{root}/{}", one.file)).expect("a source file");
            assert!(one.switched(&text, "on").is_ok_and(|(_, text)| text.len() > 10), "{}", one.name);
            assert!(one.what.len() > 10 && one.what.starts_with(char::is_uppercase), "{}", one.name);
        }
        assert!(all.len() >= 85);
    }
}

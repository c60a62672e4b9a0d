//! What is printed: lines, JSON, verdicts in colour.

use std::io::Write;
use std::sync::OnceLock;

use anstyle::AnsiColor;
use serde::Serialize;

use super::Failure;

/// Why standard output did not take all that was printed.
static LOST: OnceLock<std::io::Error> = OnceLock::new();

/// Prints a line to standard output; colours only where it is a terminal.
pub fn say(line: &str) {
    let mut out = anstream::stdout().lock();
    match writeln!(out, "{line}").and_then(|()| out.flush()) {
        // A reader that stops reading wants no more.
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => drop(LOST.set(e)),
        _ => {}
    }
}

/// Prints a value as JSON.
pub fn print_json<T: Serialize>(value: &T) {
    match serde_json::to_string_pretty(value) {
        Ok(text) => say(&text),
        Err(e) => drop(LOST.set(e.into())),
    }
}

/// Whether everything that was printed has arrived.
pub fn all_printed() -> Result<(), Failure> {
    LOST.get().map_or(Ok(()), |e| Err(Failure::RunFailed(format!("standard output: {e}"))))
}

/// Verdicts with their colours.
const VERDICTS: [(&str, AnsiColor); 10] = [
    ("not caught", AnsiColor::Red),
    ("not reproduced", AnsiColor::Red),
    ("failed", AnsiColor::Red),
    ("not established", AnsiColor::Yellow),
    ("not comparable", AnsiColor::Yellow),
    ("degraded", AnsiColor::Yellow),
    ("stopped", AnsiColor::Yellow),
    ("reproduced", AnsiColor::Green),
    ("passed", AnsiColor::Green),
    ("caught", AnsiColor::Green),
];

/// A line with its verdicts in colour, but for those that are counted and are none.
pub fn coloured(line: &str) -> String {
    let (mut text, mut rest) = (String::new(), line);
    let place = |rest: &str, (verdict, colour): (&'static str, AnsiColor)| Some((rest.find(verdict)?, verdict, colour));
    // The earliest verdict; of those that begin there the longest, which stands first in the table.
    while let Some((at, verdict, colour)) =
        VERDICTS.into_iter().filter_map(|one| place(rest, one)).min_by_key(|(at, ..)| *at)
    {
        text.push_str(&rest[..at]);
        let none = text == "0 " || text.ends_with(" 0 ");
        let style = if none { anstyle::Style::new() } else { colour.on_default() };
        text.push_str(&format!("{style}{verdict}{style:#}"));
        rest = &rest[at + verdict.len()..];
    }
    text + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_are_coloured() {
        let plain = |line: &str| anstream::adapter::strip_str(&coloured(line)).to_string();
        let line = "mandel  1e-3  not established";
        assert!(coloured(line).contains("\u{1b}[33mnot established\u{1b}[0m"), "{:?}", coloured(line));
        assert_eq!(plain(line), line);
        assert_eq!(coloured("steps"), "steps");
        assert_eq!(coloured("2 passed, 0 failed"), "2 \u{1b}[32mpassed\u{1b}[0m, 0 failed");
    }
}

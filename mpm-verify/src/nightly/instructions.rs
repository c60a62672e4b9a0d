//! Instructions of a run, counted by callgrind (Weidendorfer, Kowarschik & Trinitis 2004, doi:10.1007/978-3-540-24688-6_58)
//! where it is installed: a count that no load on the machine changes, but compiler and library do.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::compiled::{self, COMPILED, INSTRUCTIONS};
use super::part::Measured;
use super::work;
use crate::error::Error::{self, Unfit};
use crate::experiment::number::{Label, Number, Tolerance};

/// Share by which a count may move: what another library makes of the same compiler's code.
const TOLERANCE: Tolerance = Tolerance::relative(0.01);

/// Counts the instructions of gates.
#[derive(Debug)]
struct Counter {
    program: PathBuf,
    folder: PathBuf,
    /// What counted, and the compiler of what was counted: counts of others are not comparable.
    with: String,
    /// Instructions of a run of nothing.
    nothing: u64,
}

/// Counts the instructions of every gate of a program.
pub fn counts(program: &Path) -> Measured {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        return lacking("only Linux on x86-64 has baselines");
    }
    let version = match Command::new("valgrind").arg("--version").output() {
        Ok(version) => String::from_utf8_lossy(&version.stdout).trim().to_owned(),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return lacking("valgrind is not installed"),
        Err(e) => return found(Vec::new(), vec![format!("valgrind: {e}")], ""),
    };
    match Counter::new(program, &version) {
        Ok(counter) => {
            let (counted, failed) = work::each(|gate| Ok((gate.name, counter.measure(gate.name)?)));
            found(counted, failed, &counter.with)
        }
        Err(why) => found(Vec::new(), vec![why.to_string()], ""),
    }
}

fn lacking(why: &str) -> Measured {
    Measured { lacks: Some(why.to_owned()), ..Measured::default() }
}

/// The instructions of the gates that were run, none of a gate that has one unknown to valgrind; what failed; what counted.
pub fn found(counted: Vec<(&str, Option<Number>)>, failed: Vec<String>, with: &str) -> Measured {
    let unknown = counted.iter().filter(|(_, number)| number.is_none());
    let mut notes: Vec<String> = unknown
        .map(|(gate, _)| format!("Instructions of {gate} were not counted: valgrind does not know all."))
        .collect();
    if !counted.is_empty() {
        notes.push(format!("Instructions: {with}, without those of a run of nothing."));
    }
    let numbers = counted.into_iter().filter_map(|(_, number)| number).collect();
    Measured { notes, ..Measured::of([]).with(numbers).failed(failed) }
}

/// What valgrind says of an instruction that it does not know: compilers may write one that it has in another form only.
const UNKNOWN: &str = "Illegal opcode";

/// Name of the run of nothing.
pub const NOTHING: &str = "nothing";

impl Counter {
    /// A counter of the gates of a program.
    ///
    /// # Errors
    /// A run of nothing that cannot be counted.
    fn new(program: &Path, version: &str) -> Result<Self, Error> {
        let with = format!("{version}, {COMPILED}");
        let mut counter = Self { program: program.to_owned(), folder: std::env::temp_dir(), with, nothing: 0 };
        counter.nothing =
            counter.count(NOTHING)?.ok_or(Unfit("valgrind does not know all instructions of the program"))?;
        Ok(counter)
    }

    /// The instructions of a gate; none if it has one that valgrind does not know. The name of the quantity says what they are of, so
    /// that others are another number.
    ///
    /// # Errors
    /// The gate cannot be run.
    fn measure(&self, gate: &str) -> Result<Option<Number>, Error> {
        let quantity = compiled::quantity(INSTRUCTIONS, &self.with);
        Ok(self.count(gate)?.map(|count| {
            let count = count.saturating_sub(self.nothing) as f64;
            Number::new(gate, &quantity, Label::Count, count, TOLERANCE).at(format!("#{gate}"))
        }))
    }

    fn count(&self, gate: &str) -> Result<Option<u64>, Error> {
        let out = self.folder.join(format!("mpm-verify-{}-{gate}.callgrind", std::process::id()));
        let run = Command::new("valgrind")
            .args(["--tool=callgrind", "--quiet"])
            .arg(format!("--callgrind-out-file={}", out.display()))
            .arg(&self.program)
            .args(["gate", gate])
            .stdout(Stdio::null())
            .output()
            .map_err(Error::at("valgrind"))?;
        let text = fs::read_to_string(&out);
        let _ = fs::remove_file(&out);
        if String::from_utf8_lossy(&run.stderr).contains(UNKNOWN) {
            return Ok(None);
        }
        if !run.status.success() {
            return Err(Error::Found(format!("valgrind of {gate}: {}", run.status)));
        }
        let text = text.map_err(Error::at(&out))?;
        total(&text).ok_or_else(|| Unfit("expected a line of totals").of(out.display())).map(Some)
    }
}

/// The total in a file of callgrind.
fn total(text: &str) -> Option<u64> {
    let of = |start: &str| text.lines().find_map(|line| line.strip_prefix(start)).and_then(|n| n.trim().parse().ok());
    of("totals:").or_else(|| of("summary:"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_total_is_found() {
        assert_eq!(total("version: 1\nsummary: 123\nfn=(0)\n1 2\ntotals: 456\n"), Some(456));
        assert_eq!(total("version: 1\nsummary: 123\n"), Some(123));
        assert_eq!(total("version: 1\n"), None);
    }
}

//! The parts of a nightly run, and what each has found: a part that measured nothing has failed.

use serde::{Deserialize, Serialize};

use crate::experiment::number::Number;

/// Random scenes of a nightly run.
pub const SCENES: u64 = 2000;

/// A part of a nightly run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Part {
    /// Accuracy study.
    Study,
    /// Verification suite.
    Suite,
    /// Time-step limits and stress tests.
    Stability,
    /// Levee.
    Levee,
    /// Random scenes and relations between their runs.
    Metamorphic,
    /// Counts of work and times of single runs.
    Work,
    /// Instructions of the same runs.
    Instructions,
}

impl Part {
    /// All parts in the order in which they are run.
    pub const ALL: [Self; 7] =
        [Self::Study, Self::Suite, Self::Stability, Self::Levee, Self::Metamorphic, Self::Work, Self::Instructions];

    /// Name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Study => "study",
            Self::Suite => "suite",
            Self::Stability => "stability",
            Self::Levee => "levee",
            Self::Metamorphic => "metamorphic",
            Self::Work => "work",
            Self::Instructions => "instructions",
        }
    }

    /// The part of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|part| part.name() == name)
    }

    /// Description of the part.
    pub fn what(self) -> String {
        match self {
            Self::Study => "accuracy study".to_owned(),
            Self::Suite => "verification suite".to_owned(),
            Self::Stability => "stability".to_owned(),
            Self::Levee => "levee".to_owned(),
            Self::Metamorphic => format!("{SCENES} random scenes"),
            Self::Work => "work and times of single runs".to_owned(),
            Self::Instructions => "their instructions".to_owned(),
        }
    }

    /// Description of a nightly run, in a line.
    pub fn list() -> String {
        Self::ALL.map(Self::what).join(", ")
    }
}

/// End of a part.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Finish {
    /// The part was run to its end and measured something.
    #[default]
    Ran,
    /// The machine lacks what the part needs.
    NotRun,
    /// The part was not finished, or measured nothing.
    Failed,
}

impl Finish {
    /// The end in words.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Ran => "ran",
            Self::NotRun => "not run",
            Self::Failed => "failed",
        }
    }

    /// The class of its badge.
    pub const fn mark(self) -> &'static str {
        match self {
            Self::Ran => "good",
            Self::NotRun => "warn",
            Self::Failed => "bad",
        }
    }
}

/// Findings of a part.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Measured {
    /// Counts of measured or checked items, and their kinds. None of them may be zero.
    pub counted: Vec<(usize, &'static str)>,
    /// The numbers.
    pub numbers: Vec<Number>,
    /// Failed checks, in words.
    pub failed: Vec<String>,
    /// Results worth a word in the list of parts.
    pub remark: String,
    /// Remarks for the reader.
    pub notes: Vec<String>,
    /// Why it could not be run on this machine.
    pub lacks: Option<String>,
}

impl Measured {
    /// Counts alone.
    pub fn of(counted: impl IntoIterator<Item = (usize, &'static str)>) -> Self {
        Self { counted: counted.into_iter().collect(), ..Self::default() }
    }

    /// Findings with numbers, of which some must be finite.
    pub fn with(mut self, numbers: Vec<Number>) -> Self {
        self.counted.push((numbers.iter().filter(|number| number.value.is_finite()).count(), "numbers"));
        Self { numbers, ..self }
    }

    /// Findings with failed checks.
    pub fn failed(self, failed: impl IntoIterator<Item = String>) -> Self {
        Self { failed: failed.into_iter().collect(), ..self }
    }

    /// Kinds of items that should have been measured and were not.
    pub fn lacking(&self) -> Vec<&'static str> {
        match self.counted[..] {
            [] => vec!["results"],
            _ => self.counted.iter().filter(|(count, _)| *count == 0).map(|(_, what)| *what).collect(),
        }
    }

    /// End of the part.
    pub fn finish(&self) -> Finish {
        match (&self.lacks, self.lacking().is_empty()) {
            (Some(_), _) => Finish::NotRun,
            (None, true) => Finish::Ran,
            (None, false) => Finish::Failed,
        }
    }

    /// Findings in a line.
    pub fn line(&self) -> String {
        if let Some(why) = &self.lacks {
            return why.clone();
        }
        let counted = self.counted.iter().map(|(count, what)| format!("{count} {what}"));
        let failed = (!self.failed.is_empty()).then(|| format!("{} failed", self.failed.len()));
        let remark = Some(self.remark.clone()).filter(|remark| !remark.is_empty());
        counted.chain(failed).chain(remark).collect::<Vec<_>>().join(", ")
    }

    /// Failures, with the name of the part.
    pub fn failures(&self, part: Part) -> Vec<String> {
        let none = self.lacking().into_iter().map(|what| format!("no {what} were measured"));
        let none = none.filter(|_| self.finish() == Finish::Failed);
        none.chain(self.failed.iter().cloned()).map(|what| format!("{}: {what}", part.name())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::number::{Label, Tolerance};
    use crate::nightly::{collect, instructions, work};
    use crate::sweeps::Sweeps;

    /// Findings of a part that measured nothing.
    fn nothing(part: Part) -> Measured {
        match part {
            Part::Study => collect::study(&[], &Sweeps::default()),
            Part::Suite => collect::suite(&[], &[]),
            Part::Stability => collect::stability(&[], &[]),
            Part::Levee => collect::levee(&[], Vec::new()),
            Part::Metamorphic => collect::metamorphic(0, 0, Vec::new()),
            Part::Work => work::found(Vec::new(), Vec::new()),
            Part::Instructions => instructions::found(Vec::new(), Vec::new(), ""),
        }
    }

    #[test]
    fn a_part_that_measured_nothing_has_failed() {
        for part in Part::ALL {
            let found = nothing(part);
            assert_eq!(found.finish(), Finish::Failed, "{part:?}: {}", found.line());
            let failures = found.failures(part);
            let first = format!("{}: no ", part.name());
            assert!(failures.iter().any(|what| what.starts_with(&first)), "{failures:?}");
        }
        let gone = Number::new("levee", "end_h", Label::Regression, f64::NAN, Tolerance::relative(0.0));
        assert_eq!(collect::levee(&[], vec![gone.clone(), gone]).lacking(), ["limits", "numbers"]);
        assert_eq!(Measured::default().failures(Part::Work), ["work: no results were measured"]);
        // One of two kinds of results does not stand for the other.
        assert_eq!(collect::metamorphic(20, 0, Vec::new()).failures(Part::Metamorphic).len(), 1);
    }

    #[test]
    fn a_part_that_measured_all_has_not() {
        let found = Measured::of([(3, "cases")]).failed(["a: too large".to_owned()]);
        assert_eq!((found.finish(), found.line().as_str()), (Finish::Ran, "3 cases, 1 failed"));
        assert_eq!(found.failures(Part::Suite), ["suite: a: too large"]);
        let lacks = Measured { lacks: Some("no valgrind".to_owned()), ..Measured::of([(0, "gates")]) };
        assert_eq!((lacks.finish(), lacks.line().as_str()), (Finish::NotRun, "no valgrind"));
        assert!(lacks.failures(Part::Instructions).is_empty());
    }

    #[test]
    fn every_part_has_a_name_of_its_own() {
        for (place, part) in Part::ALL.into_iter().enumerate() {
            assert_eq!((Part::named(part.name()), part as usize), (Some(part), place));
            assert!(Part::list().contains(&part.what()));
        }
        assert_eq!(Part::named("nothing"), None);
    }
}

//! How far a run has come: hours and phase. The time that is left is not known: a second of moving soil takes as long as minutes of
//! seeping water, and when the soil fails is what the run is to find.

use mpm_core::failure::{Driver, Phase};

use super::plan::Plan;
use crate::progress::{Pace, Progress};

/// Shows a run as it goes on.
#[derive(Debug)]
pub struct Ticker {
    progress: Progress,
    title: String,
    ends_h: f64,
    starts_h: f64,
    said: Option<Phase>,
    pace: Pace,
}

impl Ticker {
    /// For a plan; silent if quiet.
    pub fn new(plan: &Plan, quiet: bool) -> Self {
        let title = plan.scene.name.clone();
        let progress = Progress::new(&title, quiet);
        progress.note(&format!("{title}: {}", words(Phase::Gravity)));
        Self { progress, title, ends_h: plan.ends_h(), starts_h: plan.starts_h(), said: None, pace: Pace::new() }
    }

    /// After a look at the soil.
    pub fn tick(&mut self, driver: &Driver) {
        let hours = driver.hours();
        let share = (hours - self.starts_h) / (self.ends_h - self.starts_h);
        self.progress.set_bar((1e6 * share.clamp(0.0, 1.0)) as u64);
        let phase = driver.phase;
        let changed = self.said.is_none_or(|last| last != phase && phase != Phase::Relaxing);
        let late = self.pace.due().is_some();
        let text = format!("{}: {hours:.4} of at most {} h, {}", self.title, self.ends_h, words(phase));
        self.progress.note(&text);
        if changed || late {
            self.progress.piped_line(&text);
            self.said = Some(phase);
            self.pace.said();
        }
    }

    /// It is over.
    pub fn finish(&self) {
        self.progress.finish();
    }
}

fn words(phase: Phase) -> &'static str {
    match phase {
        Phase::Gravity => "gravity",
        Phase::Seepage => "seepage",
        Phase::Relaxing => "relaxing",
        Phase::Failing => "failing",
        Phase::Together => "soil and water together",
        Phase::Ended => "the end",
    }
}

//! When frames are taken: at fixed times, at events, and often while soil moves.

use mpm_core::failure::{Driver, Events, Phase};
use mpm_core::observe::Frame;
use serde::{Deserialize, Serialize};

use super::plan::Plan;
use crate::frames::{Shot, rounded};

/// The paper's times of its Fig. 7, h.
pub const PAPER: [f64; 4] = [6.0, 8.4, 8.66, 8.68];
/// The experiment's: toe, progressive and rapid failure, h.
pub const EXPERIMENT: [f64; 3] = [12.5, 13.0, 13.2];
/// First distance of frames while soil moves, s.
const FIRST_EVERY: f64 = 0.25;
/// With so many of them every second goes, and the distance doubles.
const MOST: usize = 200;
/// Shorter than any step, s.
const EPSILON: f64 = 1e-7;

/// Names of the events as `Events` has them, with the words for readers.
pub const EVENTS: [(&str, &str); 5] = [
    ("toe wet", "water reaches the toe"),
    ("outflow", "water leaves the slope"),
    ("E1", "the toe ravels"),
    ("E2", "failure starts"),
    ("E3", "rapid failure"),
];

/// Times (h) of [`EVENTS`].
pub fn times(events: &Events) -> [Option<f64>; 5] {
    [events.front_at_toe_h, events.first_outflow_h, events.raveling_h, events.failure_h, events.collapse_h]
}

/// Fixed times since water began to seep, s, ascending; the last is the end.
pub fn fixed(plan: &Plan) -> Vec<f64> {
    let (start, end) = (plan.starts_h(), plan.ends_h());
    let hours = (0..).map(|k| start.floor() + f64::from(k)).take_while(|h| *h < end);
    let papers = PAPER.into_iter().chain(EXPERIMENT).filter(|_| plan.papers());
    let named = papers.chain(plan.from_h);
    let mut all: Vec<f64> = hours.chain(named).filter(|h| *h > start && *h < end).collect();
    all.push(end);
    all.sort_by(f64::total_cmp);
    all.dedup();
    all.into_iter().map(|h| plan.seconds(h)).collect()
}

/// Frames taken so far.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Album {
    /// The frames.
    pub shots: Vec<Shot>,
    /// How they were taken.
    pub kept: Kept,
}

/// What of an album is not in its frames.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    /// Whether a frame was taken only because soil moved: it may go again.
    passing: Vec<bool>,
    /// Distance of such frames, s; zero before the first.
    every_s: f64,
}

fn words(phase: Phase) -> &'static str {
    match phase {
        Phase::Gravity => "gravity",
        Phase::Seepage | Phase::Relaxing => "seepage",
        Phase::Failing => "failing",
        Phase::Together => "soil and water together",
        Phase::Ended => "the end",
    }
}

impl Album {
    /// Takes a frame if this is a moment for one: `before` are the events before the last step, `at_fixed` tells
    /// whether a fixed time was reached.
    pub fn look(&mut self, driver: &Driver, before: &Events, at_fixed: bool) {
        let happened: Vec<&str> = EVENTS
            .iter()
            .zip(times(before).iter().zip(times(&driver.events)))
            .filter(|(_, (before, now))| before.is_none() && now.is_some())
            .map(|((name, _), _)| *name)
            .collect();
        let first = self.shots.is_empty();
        let ended = driver.end.is_some();
        if first || ended || at_fixed || !happened.is_empty() {
            self.take(driver, &happened, false);
        } else if driver.phase == Phase::Failing || driver.phase == Phase::Together && Self::fails(driver) {
            let every = self.kept.every_s.max(FIRST_EVERY);
            if self.last_s().is_none_or(|last| driver.time - last >= every - EPSILON) {
                self.kept.every_s = every;
                self.take(driver, &[], true);
                self.thin();
            }
        }
    }

    /// Soil and water that run together are only worth many frames once something moves.
    fn fails(driver: &Driver) -> bool {
        driver.events.failure_h.is_some()
    }

    fn last_s(&self) -> Option<f64> {
        self.shots.last().map(|shot| shot.frame.time_s)
    }

    fn take(&mut self, driver: &Driver, happened: &[&str], passing: bool) {
        let clock_s = driver.hours() * 3600.0;
        let phase = [&[words(driver.phase)], happened].concat().join(", ");
        // Frames count from when water begins to seep.
        let frame = Frame { time_s: driver.time, ..rounded(&driver.frame()) };
        self.shots.push(Shot { phase, time_s: clock_s, frame });
        self.kept.passing.push(passing);
    }

    /// Of too many frames of moving soil, every second goes.
    fn thin(&mut self) {
        if self.kept.passing.iter().filter(|p| **p).count() <= MOST {
            return;
        }
        let mut number = 0;
        let keeps = |passing: &bool| {
            number += usize::from(*passing);
            !passing || number % 2 == 1
        };
        let keep: Vec<bool> = self.kept.passing.iter().map(keeps).collect();
        let mut kept = keep.iter();
        self.shots.retain(|_| *kept.next().unwrap_or(&true));
        let mut kept = keep.iter();
        self.kept.passing.retain(|_| *kept.next().unwrap_or(&true));
        self.kept.every_s *= 2.0;
    }
}

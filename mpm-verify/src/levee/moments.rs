//! When frames are taken: at fixed times, at events, every few minutes while water seeps, and often while soil moves.
//!
//! Frames never add a stop of their own: where a run is stopped decides on how its soil comes to rest.

use mpm_core::failure::{Driver, End, Events, Phase};
use mpm_core::observe::Frame;
use serde::{Deserialize, Serialize};

use super::plan::Plan;
use crate::frames::{Shot, rounded};

/// The paper's times of its Fig. 7, h.
pub const PAPER: [f64; 4] = [6.0, 8.4, 8.66, 8.68];
/// The experiment's: toe, progressive and rapid failure, h.
pub const EXPERIMENT: [f64; 3] = [12.5, 13.0, 13.2];
/// First interval of frames while water seeps, and while soil moves, s.
const FIRST_EVERY: [f64; 2] = [300.0, 0.1];
/// With more frames than this of a kind, every second is dropped and the interval doubles.
const MOST: [usize; 2] = [100, 200];
/// Shorter than any step, s.
const EPSILON: f64 = 1e-7;

/// Names of the events as `Events` has them, with the words for readers.
pub const EVENTS: [(&str, &str); 5] = [
    ("toe wet", "water reaches the toe"),
    ("outflow", "water leaves the slope"),
    ("E1", "the toe fails"),
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

/// Why a frame was taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
enum Why {
    /// A fixed time or an event: it stays.
    Fixed,
    /// Water seeps.
    Seeping,
    /// Soil moves.
    Moving,
}

/// What of an album is not in its frames.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    why: Vec<Why>,
    /// Intervals of frames while water seeps, and while soil moves, s; zero before the first.
    every_s: [f64; 2],
}

fn words(driver: &Driver) -> &'static str {
    match (driver.phase, driver.end) {
        (_, Some(End::Collapsed)) => "at rest",
        (_, Some(End::TimeOver)) | (Phase::Ended, None) => "end of the run",
        (Phase::Gravity, None) => "gravity",
        (Phase::Seepage | Phase::Relaxing, None) => "seepage",
        (Phase::Failing, None) => "failing",
        (Phase::Together, None) => "soil and water together",
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
            self.take(driver, &happened, Why::Fixed);
            return;
        }
        let why = match driver.phase {
            Phase::Seepage | Phase::Relaxing => Why::Seeping,
            Phase::Failing => Why::Moving,
            // Soil and water that run together are only worth many frames once something moves.
            Phase::Together if driver.events.failure_h.is_some() => Why::Moving,
            Phase::Together => Why::Seeping,
            Phase::Gravity | Phase::Ended => return,
        };
        let kind = usize::from(why == Why::Moving);
        let every = self.kept.every_s[kind].max(FIRST_EVERY[kind]);
        if self.last_s().is_none_or(|last| driver.time - last >= every - EPSILON) {
            self.kept.every_s[kind] = every;
            self.take(driver, &[], why);
            self.thin(why, kind);
        }
    }

    fn last_s(&self) -> Option<f64> {
        self.shots.last().map(|shot| shot.frame.time_s)
    }

    fn take(&mut self, driver: &Driver, happened: &[&str], why: Why) {
        let clock_s = driver.hours() * 3600.0;
        let phase = [&[words(driver)], happened].concat().join(", ");
        // Frames count from when water begins to seep.
        let frame = Frame { time_s: driver.time, ..rounded(&driver.frame()) };
        self.shots.push(Shot { phase, time_s: clock_s, frame });
        self.kept.why.push(why);
    }

    /// Of too many frames of a kind, every second is dropped.
    fn thin(&mut self, why: Why, kind: usize) {
        if self.kept.why.iter().filter(|w| **w == why).count() <= MOST[kind] {
            return;
        }
        let mut number = 0;
        let keeps = |own: &Why| {
            number += usize::from(*own == why);
            *own != why || number % 2 == 1
        };
        let keep: Vec<bool> = self.kept.why.iter().map(keeps).collect();
        let mut kept = keep.iter();
        self.shots.retain(|_| *kept.next().unwrap_or(&true));
        let mut kept = keep.iter();
        self.kept.why.retain(|_| *kept.next().unwrap_or(&true));
        self.kept.every_s[kind] *= 2.0;
    }
}

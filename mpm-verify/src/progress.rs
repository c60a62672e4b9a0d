//! A progress bar on a terminal, plain lines when piped, nothing when quiet.

use std::io::IsTerminal;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// How far a long job has come, by the work that is done.
#[derive(Debug)]
pub struct Progress {
    bar: Option<ProgressBar>,
    lines: bool,
    title: String,
    pace: Pace,
    work: Mutex<Work>,
}

/// Work of a job, in any unit.
#[derive(Debug, Default)]
struct Work {
    total: f64,
    done: f64,
    /// Whether the total is that of the whole job.
    whole: bool,
    /// Time since the start (s) and share when the first progress was reported: a resumed job does not start at zero.
    first: Option<(f64, f64)>,
}

/// When a line is due where there is no bar: after two seconds, then each time a fifth more time has passed. A job of a minute prints some
/// ten lines, one of a day fifty.
#[derive(Debug)]
pub struct Pace {
    began: Instant,
    /// When the last line was printed, ms after that.
    said: AtomicU64,
}

/// No line is due earlier, and no two are closer.
const FIRST: Duration = Duration::from_secs(2);
/// Share of the time until the last line that passes until the next one.
const MORE: f64 = 0.2;

impl Pace {
    /// Starts now.
    pub fn new() -> Self {
        Self { began: Instant::now(), said: AtomicU64::new(0) }
    }

    /// Whether a line is due; if so, the time since the start.
    pub fn due(&self) -> Option<Duration> {
        self.due_at(self.began.elapsed())
    }

    /// A line has been printed for another reason.
    pub fn said(&self) {
        self.said.store(self.began.elapsed().as_millis() as u64, Ordering::Relaxed);
    }

    fn due_at(&self, now: Duration) -> Option<Duration> {
        let last = self.said.load(Ordering::Relaxed);
        let said = Duration::from_millis(last);
        let due = now >= said + FIRST.max(said.mul_f64(MORE));
        // Several threads may find a line due: one prints it.
        let next = now.as_millis() as u64;
        let mine = due && self.said.compare_exchange(last, next, Ordering::Relaxed, Ordering::Relaxed).is_ok();
        mine.then_some(now)
    }
}

impl Default for Pace {
    fn default() -> Self {
        Self::new()
    }
}

impl Progress {
    /// A bar with a title, unless quiet or piped.
    pub fn new(title: &str, quiet: bool) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let bar = (terminal && !quiet).then(|| {
            let bar = ProgressBar::new(1_000_000);
            if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:40}] {percent:>3} %  {prefix}") {
                bar.set_style(style.progress_chars("=> "));
            }
            bar.set_message(title.to_owned());
            bar
        });
        Self { bar, lines: !quiet, title: title.to_owned(), pace: Pace::new(), work: Mutex::default() }
    }

    /// Sets the work of the whole job, before it is run in parts.
    pub fn expect(&self, work: f64) {
        if let Ok(mut of) = self.work.lock() {
            (of.total, of.whole) = (work, true);
        }
    }

    /// A part of the job begins: all its work, and what of it has to be done.
    pub fn begin(&self, all: f64, needed: f64) {
        if let Ok(mut of) = self.work.lock() {
            of.total += if of.whole { needed - all } else { needed };
        }
    }

    /// Some work has been done.
    pub fn add(&self, work: f64) {
        let share = self.work.lock().ok().map(|mut of| {
            of.done += work;
            of.done / of.total
        });
        share.into_iter().for_each(|share| self.set((1e6 * share.clamp(0.0, 1.0)) as u64));
    }

    /// Sets the millionths of the work that are done. Where there is no bar a line is printed from time to time.
    pub fn set(&self, millionths: u64) {
        if self.bar.is_none() && !self.lines {
            return;
        }
        let (now, share) = (self.pace.began.elapsed().as_secs_f64(), 1e-6 * millionths as f64);
        let first = self.work.lock().ok().map(|mut of| *of.first.get_or_insert((now, share)));
        let left = first.and_then(|first| left((now, share), first)).map_or_else(String::new, |s| time(s) + " left");
        match &self.bar {
            Some(bar) => {
                bar.set_prefix(left);
                bar.set_position(millionths);
            }
            None => {
                if let Some(elapsed) = self.pace.due() {
                    self.line(&format!("{}: {}", self.title, said(millionths, elapsed, &left)));
                }
            }
        }
    }

    /// Sets the bar alone, of a job that prints its own lines and cannot tell its remaining time.
    pub fn set_bar(&self, millionths: u64) {
        if let Some(bar) = &self.bar {
            bar.set_position(millionths);
        }
    }

    /// Prints to standard output without disturbing the bar.
    pub fn print(&self, print: impl FnOnce()) {
        match &self.bar {
            Some(bar) => bar.suspend(print),
            None => print(),
        }
    }

    /// Prints a line to standard error, above the bar if there is one.
    pub fn line(&self, text: &str) {
        match (&self.bar, self.lines) {
            (Some(bar), _) => bar.suspend(|| anstream::eprintln!("{text}")),
            (None, true) => anstream::eprintln!("{text}"),
            (None, false) => {}
        }
    }

    /// Sets the text beside the bar.
    pub fn note(&self, text: &str) {
        if let Some(bar) = &self.bar {
            bar.set_message(text.to_owned());
        }
    }

    /// Prints a line where there is no bar.
    pub fn piped_line(&self, text: &str) {
        if self.bar.is_none() {
            self.line(text);
        }
    }

    /// The job is done.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Time left, s, from the time (s) and the share done now and at the first report; `None` as long as it cannot be told.
fn left((now, share): (f64, f64), (began, first): (f64, f64)) -> Option<f64> {
    let known = share - first > 0.01 && now - began > 1.0 && share < 1.0;
    known.then(|| (now - began) * (1.0 - share) / (share - first))
}

/// Share done, time since the start and time left.
fn said(millionths: u64, elapsed: Duration, left: &str) -> String {
    let done = format!("{:.1} %, after {}", millionths as f64 * 1e-4, time(elapsed.as_secs_f64()));
    if left.is_empty() { done } else { format!("{done}, {left}") }
}

/// A time (s) in a convenient unit, to about two digits.
pub fn time(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s if s < 48.0 * 3600.0 => format!("{:.1} h", s / 3600.0),
        s if s < 1000.0 * 86400.0 => format!("{:.0} days", s / 86400.0),
        s => format!("{:.0} years", s / (365.25 * 86400.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_few_however_long_a_job_lasts() {
        let lines = |seconds: u64| {
            let pace = Pace::new();
            (0..10 * seconds).filter(|tenth| pace.due_at(Duration::from_millis(100 * tenth)).is_some()).count()
        };
        assert_eq!([1, 3, 60, 3600, 86_400].map(lines), [0, 1, 14, 37, 54]);
    }

    #[test]
    fn times_are_in_units_that_people_use() {
        let words = [0.4, 119.0, 600.0, 5400.0, 7200.0, 4e5, 1e10].map(time);
        assert_eq!(words, ["0 s", "119 s", "10 min", "90 min", "2.0 h", "5 days", "317 years"]);
        assert_eq!(said(123_456, Duration::from_secs(600), ""), "12.3 %, after 10 min");
        assert_eq!(said(123_456, Duration::from_secs(600), "71 min left"), "12.3 %, after 10 min, 71 min left");
    }

    #[test]
    fn the_time_left_is_by_work_done_here() {
        assert_eq!(left((10.0, 0.25), (0.0, 0.0)), Some(30.0));
        // A resumed job has done only what it has done since.
        assert_eq!(left((10.0, 0.75), (0.0, 0.5)), Some(10.0));
        assert_eq!((left((0.5, 0.25), (0.0, 0.0)), left((10.0, 0.005), (0.0, 0.0))), (None, None));
    }

    #[test]
    fn work_that_is_already_done_does_not_count() {
        let progress = Progress::new("", true);
        progress.expect(10.0);
        progress.begin(6.0, 2.0);
        progress.add(2.0);
        let work = progress.work.lock().expect("a lock");
        assert_eq!((work.total, work.done), (6.0, 2.0));
    }
}

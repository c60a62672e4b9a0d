//! A progress bar on a terminal, plain lines when piped, nothing when quiet.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// How far a long job has come, in millionths.
#[derive(Debug)]
pub struct Progress {
    bar: Option<ProgressBar>,
    lines: bool,
    title: String,
    pace: Pace,
}

/// When a line is due where there is no bar: after two seconds, then each time a fifth more time has passed. A job of a minute has some ten
/// lines, one of a day fifty.
#[derive(Debug)]
pub struct Pace {
    began: Instant,
    /// When the last line was said, ms after that.
    said: AtomicU64,
}

/// No line is due before, and no two are closer.
const FIRST: Duration = Duration::from_secs(2);
/// Share of the time of the last line that passes until the next one.
const MORE: f64 = 0.2;

impl Pace {
    /// From now on.
    pub fn new() -> Self {
        Self { began: Instant::now(), said: AtomicU64::new(0) }
    }

    /// Whether a line is due; if so, the time since the start.
    pub fn due(&self) -> Option<Duration> {
        self.due_at(self.began.elapsed())
    }

    /// A line is there for another reason.
    pub fn said(&self) {
        self.said.store(self.began.elapsed().as_millis() as u64, Ordering::Relaxed);
    }

    fn due_at(&self, now: Duration) -> Option<Duration> {
        let last = self.said.load(Ordering::Relaxed);
        let said = Duration::from_millis(last);
        let due = now >= said + FIRST.max(said.mul_f64(MORE));
        // Several threads may find a line due: one says it.
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
            if let Ok(style) =
                ProgressStyle::with_template("{msg} [{bar:40}] {percent:>3} %  {elapsed} / about {duration}")
            {
                bar.set_style(style.progress_chars("=> "));
            }
            bar.set_message(title.to_owned());
            bar
        });
        Self { bar, lines: !quiet, title: title.to_owned(), pace: Pace::new() }
    }

    /// Sets the millionths done, of a stage if the job has some. Where there is no bar a line says so from time to time.
    pub fn set(&self, millionths: u64) {
        match &self.bar {
            Some(bar) => bar.set_position(millionths),
            None if self.lines => {
                if let Some(elapsed) = self.pace.due() {
                    self.line(&format!("{}: {}", self.title, said(millionths, elapsed)));
                }
            }
            None => {}
        }
    }

    /// Sets the bar alone, of a job that has lines of its own.
    pub fn set_bar(&self, millionths: u64) {
        if let Some(bar) = &self.bar {
            bar.set_position(millionths);
        }
    }

    /// Something worth a line has been finished.
    pub fn line(&self, text: &str) {
        match (&self.bar, self.lines) {
            (Some(bar), _) => bar.println(text),
            (None, true) => eprintln!("{text}"),
            (None, false) => {}
        }
    }

    /// What is going on, beside the bar.
    pub fn note(&self, text: &str) {
        if let Some(bar) = &self.bar {
            bar.set_message(text.to_owned());
        }
    }

    /// A line where there is no bar to see it from.
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

/// Share done, and time since the start.
fn said(millionths: u64, elapsed: Duration) -> String {
    format!("{:.1} %, after {}", millionths as f64 * 1e-4, time(elapsed.as_secs_f64()))
}

/// A time (s) in words, to two digits or so.
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
        assert_eq!(said(123_456, Duration::from_secs(600)), "12.3 %, after 10 min");
    }
}

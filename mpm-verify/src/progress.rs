//! A progress bar on a terminal, plain lines when piped, nothing when quiet.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressStyle};

/// How far a long job has come, in millionths.
#[derive(Debug)]
pub struct Progress {
    bar: Option<ProgressBar>,
    lines: bool,
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
        Self { bar, lines: !quiet }
    }

    /// Sets the millionths done.
    pub fn set(&self, millionths: u64) {
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

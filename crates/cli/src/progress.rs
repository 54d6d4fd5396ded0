//! Progress on a terminal, and none elsewhere.

use indicatif::{ProgressBar, ProgressStyle};
use trisect_studies::Progress;

/// A bar on standard error. It has no thread of its own: it is drawn between samples, never
/// while one is taken.
pub(crate) struct Bar(ProgressBar);

impl Bar {
    pub(crate) fn new() -> Self {
        let style = ProgressStyle::with_template("{msg:<40!} {wide_bar} {pos}/{len}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        Self(ProgressBar::new(1).with_style(style))
    }
}

impl Bar {
    /// As [`Progress::step`], from any thread.
    pub(crate) fn advance(&self) {
        self.0.inc(1);
    }
}

impl Progress for Bar {
    fn phase(&mut self, name: &str, steps: u64) {
        self.0.set_message(name.to_owned());
        self.0.set_length(steps);
        self.0.set_position(0);
    }

    fn step(&mut self) {
        self.0.inc(1);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

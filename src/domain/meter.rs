//! How far something is that takes long: a bar on a terminal, plain lines in a batch log. What people cannot be told is not
//! told; it never ends a run.

use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// Time between two lines of a batch log, and until the first one of what has no known end.
const LINE_EVERY: Duration = Duration::from_secs(20);
const LINE_FIRST: Duration = Duration::from_secs(2);
/// Parts of a bar.
const PARTS: u64 = 1000;
/// A share of the way that has to be gone before what is left can be told.
const SHARE_LEAST: f64 = 1e-4;

/// A line to people on stderr, which may be closed, full, or piped into something that has ended.
pub fn tell(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// `3:07:05`, or with days before it.
pub fn clock(seconds: f64) -> String {
    let seconds = seconds.round() as u64;
    let (days, hours, minutes) = (seconds / 86_400, seconds / 3600 % 24, seconds / 60 % 60);
    let clock = format!("{hours}:{minutes:02}:{:02}", seconds % 60);
    if days > 0 { format!("{days} d {clock}") } else { clock }
}

/// Shows a share of a way, and what is left of it by the pace so far.
#[derive(Debug)]
pub struct Meter {
    started: Instant,
    /// Share at the start.
    first: Option<f64>,
    next_line: Instant,
    bar: Option<ProgressBar>,
}

impl Meter {
    /// Of a way whose length is known from the start.
    pub fn known() -> Self {
        Self::new(LINE_EVERY)
    }

    /// Of one whose end is only foreseen.
    pub fn foreseen() -> Self {
        Self::new(LINE_FIRST)
    }

    fn new(until_first: Duration) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("{bar:30} {percent:>3} % {msg}")
                .unwrap_or_else(|_| ProgressStyle::default_bar());
            ProgressBar::new(PARTS).with_style(style)
        });
        let started = Instant::now();
        Self { started, first: None, next_line: started + until_first, bar }
    }

    /// Shows that `share` of the way is done; `head` names where that is, `words` say more.
    pub fn show(&mut self, share: f64, head: impl FnOnce() -> String, words: impl FnOnce() -> String) {
        let share = share.clamp(0.0, 1.0);
        let first = *self.first.get_or_insert(share);
        let left = (share - first > SHARE_LEAST)
            .then(|| clock(self.started.elapsed().as_secs_f64() * (1.0 - share) / (share - first)));
        let left = left.map_or(String::new(), |left| format!(", {left} left"));
        match &self.bar {
            Some(bar) => {
                bar.set_position((share * PARTS as f64) as u64);
                bar.set_message(format!("{}{left}: {}", head(), words()));
            }
            None if Instant::now() >= self.next_line => {
                self.next_line = Instant::now() + LINE_EVERY;
                tell(&format!("{}{left}: {}", head(), words()));
            }
            None => {}
        }
    }

    /// Takes a bar away.
    pub fn finish(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

impl Drop for Meter {
    fn drop(&mut self) {
        self.finish();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_told_as_clocks() {
        assert_eq!(clock(0.4), "0:00:00");
        assert_eq!(clock(11_225.0), "3:07:05");
        assert_eq!(clock(2.0 * 86_400.0 + 61.0), "2 d 0:01:01");
    }
}

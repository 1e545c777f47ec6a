//! What a run writes, and when.

use std::time::Duration;

use crate::base::keys::{Form, POSITIVE, TIME, count, flag, number, size};

/// What a run writes, and how often.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Output {
    /// Simulated time between rows of `series.csv`, s.
    pub series_interval: f64,
    /// Simulated time between frames of `frames.vtkhdf`, s.
    pub frame_interval: f64,
    /// Simulated time between checkpoints, s.
    pub checkpoint_interval: f64,
    /// Steps between checkpoints beside those; none where it is 0.
    pub checkpoint_steps: u64,
    /// Wall time between checkpoints at most, s.
    pub checkpoint_wall_interval: f64,
    /// Checkpoints kept.
    pub checkpoints_kept: usize,
    /// Every so many checkpoints one is kept for good; none where it is 0.
    pub checkpoints_for_good: usize,
    /// Whether `contacts.vtkhdf` is written with the frames.
    pub contact_frames: bool,
}

impl Output {
    /// Rows, frames and checkpoints of a run that does not say.
    const ROWS: f64 = 500.0;
    const FRAMES: f64 = 20.0;
    const CHECKPOINTS: f64 = 10.0;

    /// That of a run of so many seconds, in steps of `step` s, where the job does not say.
    pub fn of_run(duration: f64, step: f64) -> Self {
        let interval = |count: f64| (duration / count).max(step);
        Self {
            series_interval: interval(Self::ROWS),
            frame_interval: interval(Self::FRAMES),
            checkpoint_interval: interval(Self::CHECKPOINTS),
            checkpoint_steps: 0,
            checkpoint_wall_interval: 600.0,
            checkpoints_kept: 3,
            checkpoints_for_good: 10,
            contact_frames: false,
        }
    }

    /// The keys of `[output]`.
    pub(super) fn keys(&mut self, form: &mut dyn Form, ledger: &mut bool) {
        let time = |name, about, example| number(name, about, TIME, POSITIVE, example);
        let series = time("series_interval", "time between rows of series.csv", "\"3 ms\"");
        form.number(&mut self.series_interval, series.follows("a 500th of the run"));
        let frames = time("frame_interval", "time between frames", "\"80 ms\"");
        form.number(&mut self.frame_interval, frames.follows("a 20th of the run"));
        let checkpoints = time("checkpoint_interval", "time between checkpoints", "\"0.2 s\"");
        form.number(&mut self.checkpoint_interval, checkpoints.follows("a tenth of the run"));
        let steps = "steps between checkpoints, beside those at intervals, or 0 for none";
        form.count(
            &mut self.checkpoint_steps,
            count("checkpoint_steps", steps, (0, 1_000_000_000_000), "100000").or("0"),
        );
        let wall = "time between checkpoints by the clock on the wall, at most";
        form.number(
            &mut self.checkpoint_wall_interval,
            time("checkpoint_wall_interval", wall, "\"10 min\"").or("\"10 min\""),
        );
        size(
            form,
            &mut self.checkpoints_kept,
            count("checkpoints_kept", "checkpoints kept", (1, 1_000_000), "3").or("3"),
        );
        let good = "checkpoints of which one is kept for good, or 0";
        size(form, &mut self.checkpoints_for_good, count("checkpoints_for_good", good, (0, 1_000_000), "10").or("0"));
        let contacts = "writes contacts as lines into contacts.vtkhdf with every frame";
        form.flag(&mut self.contact_frames, flag("contact_frames", contacts, "true").or("false"));
        let account = "adds columns of work done, energy stored and energy lost to series.csv";
        form.flag(ledger, flag("energy_balance", account, "true").or("false"));
    }

    /// Wall time between states that are saved, of a run and of its packing in the making.
    pub fn save_every(&self) -> Duration {
        Duration::try_from_secs_f64(self.checkpoint_wall_interval).unwrap_or(Duration::MAX)
    }
}

//! A run as it is compared: its curves over strain, and its frames.

use super::press::Press;
use crate::base::error::Error;
use crate::plot::report::figures::with_method;
use crate::plot::report::load::{Body, Snapshot, broken, figure, from_zero};
use crate::plot::report::records::Record;
use crate::plot::report::scenes::{Valued, first_with_grains, strained};
use crate::plot::report::span::Span;

/// Room beside the material in pictures, as a share of its breadth.
const ROOM: f64 = 0.03;
/// The column of what membranes enclose, m3.
const ENCLOSED: &str = "enclosed_volume";

/// A run with what it is compared by.
pub struct Run<'a> {
    pub record: &'a Record,
    pub label: String,
    pub method: String,
    pub seed: Option<i64>,
    pub group: usize,
    /// Rows of the series: times, s, strains, and stresses, Pa.
    pub time: &'a [f64],
    pub strain: Vec<f64>,
    pub stress: Vec<f64>,
    /// Of what membranes enclose, since the first row, positive in dilation.
    pub volume: Option<Vec<f64>>,
    /// The first row of a hybrid with grains, of which there are more before, and the first such frame.
    pub cut: Option<usize>,
    pub enriched: Option<usize>,
    pub span: Span,
    /// Bodies at the end.
    pub bodies: usize,
}

impl<'a> Run<'a> {
    pub fn of(record: &'a Record, group: usize, press: &Press) -> Result<Self, Error> {
        let path = record.directory.join("series.csv");
        let column = |name: &str| {
            let values = record.column(name);
            let whole = !values.is_empty() && values.iter().all(|value| value.is_finite());
            let remedy = "Resume the run; it takes the file up where the checkpoint left it";
            whole.then_some(values).ok_or_else(|| broken(&path, &format!("has no whole column `{name}`"), remedy))
        };
        let [force, displacement] = press.columns();
        let strain: Vec<f64> = column(&displacement)?.iter().map(|&way| press.strain(way)).collect();
        if strain.windows(2).any(|pair| pair[1] < pair[0]) {
            let what = format!("cannot be compared: `{}` turns back on its way", press.name);
            return Err(broken(&path, &what, "Make a report of this run by itself"));
        }
        let volume = (!record.column(ENCLOSED).is_empty()).then(|| column(ENCLOSED)).transpose()?;
        let scenario = &record.scenario;
        let method = record.word("method").unwrap_or_default().to_owned();
        let grains = column("grains")?;
        let is_hybrid = method == "hybrid";
        let snapshot = |frame: usize| Snapshot::read(&record.directory, frame, 0.0);
        let enriched = if is_hybrid { first_with_grains(record.frame_times.len(), snapshot)? } else { None };
        let last = snapshot(record.frame_times.len() - 1)?;
        let scenario_path = record.directory.join("scenario.toml");
        let diameter =
            figure(scenario, "grains.diameter_mean").filter(|diameter| *diameter > 0.0).ok_or_else(|| {
                broken(
                    &scenario_path,
                    "has no positive number `grains.diameter_mean`",
                    "Copy it back from the run's job",
                )
            })?;
        Ok(Self {
            label: with_method(&record.name, &method),
            seed: scenario.get("seed").and_then(toml::Value::as_integer),
            group,
            time: column("time")?,
            stress: column(&force)?.iter().map(|&force| press.stress(force)).collect(),
            volume: volume.map(|volume| volume.iter().map(|now| now / volume[0] - 1.0).collect()),
            cut: (1..grains.len()).find(|&row| is_hybrid && grains[row] > grains[0]),
            enriched,
            span: around(&last.bodies, diameter),
            bodies: last.bodies.len(),
            strain,
            method,
            record,
        })
    }

    pub fn is(&self, method: &str) -> bool {
        self.method == method
    }

    /// Edge of a grid cell, m.
    pub fn cell(&self) -> Option<f64> {
        figure(&self.record.scenario, "grid.cell").filter(|_| !self.is("dem"))
    }

    pub fn strain_end(&self) -> f64 {
        self.strain[self.strain.len() - 1]
    }

    /// Strain at which grains replaced points.
    pub fn enriched_strain(&self) -> Option<f64> {
        let time = self.record.summary.get("enriched_at_time").and_then(serde_json::Value::as_f64);
        let time = time.filter(|_| self.is("hybrid")).or_else(|| self.cut.map(|row| self.time[row]))?;
        Some(from_zero(self.time, &self.strain, time))
    }

    pub fn frames(&self) -> usize {
        self.record.frame_times.len()
    }

    pub fn strain_of(&self, frame: usize) -> f64 {
        from_zero(self.time, &self.strain, self.record.frame_times[frame])
    }

    /// The frame nearest to a strain; of several at that strain the last.
    pub fn frame_at(&self, strain: f64) -> usize {
        let away = |frame: usize| (self.strain_of(frame) - strain).abs();
        (0..self.frames()).reduce(|best, frame| if away(frame) <= away(best) { frame } else { best }).unwrap_or(0)
    }

    pub fn snapshot(&self, frame: usize) -> Result<Snapshot, Error> {
        Snapshot::read(&self.record.directory, frame, 0.0)
    }

    /// Strain of bodies between two frames, or since each began.
    pub fn strained(&self, from: Option<&Snapshot>, to: &Snapshot) -> Vec<Valued> {
        strained(to, from, &self.span)
    }
}

/// As wide as the bodies with a little room.
fn around(bodies: &[Body], diameter: f64) -> Span {
    let ends = |ends: [f64; 2], body: &Body| {
        [ends[0].min(body.position[0] - body.radius), ends[1].max(body.position[0] + body.radius)]
    };
    let [left, right] = bodies.iter().fold([f64::INFINITY, f64::NEG_INFINITY], ends);
    let [left, width] = if right > left { [left, right - left] } else { [0.0, diameter] };
    Span { left: left - ROOM * width, width: (1.0 + 2.0 * ROOM) * width, is_periodic: false, diameter }
}

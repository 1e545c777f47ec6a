//! What a calibration of the law with mobilised friction leaves behind: a file of a material, all data, and a summary in words.

use std::fmt::Write;

use serde_json::{Value, json};

use super::musts::{FITTED_PACKINGS, Must, has_packings, musts};
use super::{BAND, Calibration, Figure, KINDS, Kind, LOOSE, Quality, Shown, Specimen, Tested, Tests, Unloading};
use crate::analysis::calibrate::columns::Columns;
use crate::analysis::calibrate::element::{
    Course, INERTIAL_COMPRESSION, INERTIAL_CYCLES, INERTIAL_SHEAR, Row, STRAIN_REVERSAL, STRAIN_SMALL,
};
use crate::analysis::calibrate::layers::STRETCH;
use crate::job::significant;

const STRING: &str = "a string takes every line";
/// How far back from the peak the reversal is told.
const BACK: [f64; 3] = [0.004, 0.008, 0.018];

impl Figure {
    /// A value in the unit that people use, with so many significant digits.
    pub fn in_unit(&self, value: f64, count: usize) -> String {
        let (factor, unit) = match self.unit {
            "Pa" if self.key == "cohesion" => (1e-3, " kPa"),
            "Pa" => (1e-6, " MPa"),
            "rad" => (1.0, " rad"),
            _ => (1.0, ""),
        };
        format!("{}{unit}", significant(factor * value, count))
    }

    /// The half-width of its interval.
    pub fn interval(&self) -> String {
        self.half_width.map_or("-".to_string(), |half| self.in_unit(half, 2))
    }
}

impl Calibration {
    /// The file of the material; `command` is what made it, `job` the job's name.
    pub fn fragment(&self, job: &str, command: &str) -> String {
        let mut page = String::new();
        let mut line = |text: &str| writeln!(page, "{text}").expect(STRING);
        let seeds: Vec<String> = self.fitted.iter().map(|specimen| specimen.seed.to_string()).collect();
        line(&format!(
            "# The material of a continuum of the grains of {job}, calibrated by simulated element tests of them:"
        ));
        line("#");
        line(&format!("#     {command}"));
        line("#");
        let [stress, half] = [1.0, 0.5].map(|share| significant(1e-3 * share * self.stress, 6));
        line(&format!("# {} grains in each packing, seeds {}.", self.wanted.grains, seeds.join(", ")));
        line(&format!(
            "# K and G_0: isotropic and uniaxial compression under {stress} kPa, inertial number {INERTIAL_COMPRESSION:e}, the first {STRAIN_SMALL:e} of volume strain."
        ));
        line(&format!(
            "# The rest: simple shear of dense and of loose packings under {stress} and {half} kPa to {} %, from the peak back, and in small",
            significant(100.0 * self.wanted.strain, 6)
        ));
        line(&format!(
            "# cycles, inertial numbers {INERTIAL_SHEAR:e} and {INERTIAL_CYCLES:e}; the law follows the means of the packings with the least squares."
        ));
        line("# Behind +-: half of the 95 % confidence interval over the packings.");
        let fractions = [0, LOOSE].map(|kind: usize| significant(self.shown[kind].curve.drive.fraction, 4));
        line(&format!(
            "# Solid volume fraction at the start: dense {}, loose {}; a job gives its own as material.fraction.",
            fractions[0], fractions[1]
        ));
        if let Some(end) = self.bands[0] {
            line(&format!(
                "# Dense packings shear in a band from {} % of strain on, and nothing of theirs is fitted beyond.",
                significant(100.0 * end, 3)
            ));
        }
        if self.fitted[0].axes == 3 {
            line(
                "# Of spheres, sheared in plane strain. K is that of p = tr(tau)/3: a material for jobs with space = \"solid\".",
            );
        }
        line("# A job on a grid takes this file by `file = \"...\"` in its [material].");
        line("");
        line("[material]");
        line("law = \"mobilised_friction\"");
        for figure in &self.figures {
            let interval = figure
                .half_width
                .filter(|half| *half > 0.0)
                .map_or(String::new(), |_| format!(" +- {}", figure.interval()));
            line(&format!("# {}{interval}{}", figure.symbol, self.bound(figure)));
            let value = figure.in_unit(figure.value, 4);
            let quoted = if figure.unit.is_empty() { value } else { format!("\"{value}\"") };
            line(&format!("{} = {quoted}", figure.key));
        }
        page
    }

    fn bound(&self, figure: &Figure) -> &'static str {
        if self.fit.at_bound.contains(&figure.key) { ", at its bound: the tests do not tell it" } else { "" }
    }

    /// Parameters, and how the law follows the tests, for a terminal.
    pub fn told(&self) -> String {
        let mut text = format!("{:<32}{:>16}{:>14}\n", "", "calibrated", "95 %, +-");
        for figure in &self.figures {
            let value = figure.in_unit(figure.value, 4);
            writeln!(text, "{:<32}{value:>16}{:>14}{}", figure.key, figure.interval(), self.bound(figure))
                .expect(STRING);
        }
        for (kind, end) in KINDS.iter().zip(&self.bands) {
            if let Some(end) = end {
                writeln!(
                    text,
                    "{}: a layer takes {BAND} times the mean shear in half of the packings from {} % of strain on; nothing is fitted beyond",
                    kind.words(),
                    significant(100.0 * end, 3)
                )
                .expect(STRING);
            }
        }
        for collapse in self.collapses() {
            writeln!(text, "{}: {}", KINDS[collapse.kind].words(), collapse.words()).expect(STRING);
        }
        let groups = [
            ("fitted", Some(&self.shown)),
            ("packings held back", Some(&self.shown_held).filter(|shown| !shown.is_empty())),
            ("half of the stress, left out of the fit", self.half_left_out.as_ref()),
        ];
        let head = ["0-5 %", "5-20 %", "20 %-", "peak, at", "of the law", "volume", "of the law"];
        for (title, shown) in groups {
            let Some(shown) = shown else { continue };
            write!(text, "{title:<40}").expect(STRING);
            head.iter().for_each(|word| write!(text, "{word:>16}").expect(STRING));
            text.push('\n');
            for shown in shown {
                write!(text, "  {:<38}", shown.kind.words()).expect(STRING);
                shown.cells().iter().for_each(|cell| write!(text, "{cell:>16}").expect(STRING));
                text.push('\n');
            }
            for shown in shown {
                shown.unloaded().iter().for_each(|words| writeln!(text, "  {words}").expect(STRING));
            }
        }
        for (title, musts) in musts(self) {
            let (heading, width) = if has_packings(&musts) { (FITTED_PACKINGS, 18) } else { ("", 0) };
            writeln!(text, "{title:<84}{:>18}{:>14}{heading:>width$}", "must", "found").expect(STRING);
            for Must { test, words, must, found, is_met, of_packings } in musts {
                let mark = if is_met { "" } else { "  missed" };
                let packings = of_packings.unwrap_or_default();
                writeln!(text, "  {:<82}{must:>18}{found:>14}{packings:>width$}{mark}", format!("{test}: {words}"))
                    .expect(STRING);
            }
        }
        text
    }

    /// Everything that was measured and found.
    pub fn to_json(&self, job: &str, command: &str) -> Value {
        let figures = self.figures.iter().map(|figure| {
            let is_at_bound = self.fit.at_bound.contains(&figure.key);
            let value = json!({
                "value": figure.value, "half_width_95": figure.half_width, "unit": figure.unit, "at_bound": is_at_bound,
            });
            (figure.key.to_string(), value)
        });
        json!({
            "program": crate::base::program::identity(),
            "job": job,
            "command": command,
            "law": "mobilised_friction",
            "grains": self.wanted.grains,
            "strain": self.wanted.strain,
            "stress": self.stress,
            "inertial_number_compression": INERTIAL_COMPRESSION,
            "inertial_number_shear": INERTIAL_SHEAR,
            "inertial_number_cycles": INERTIAL_CYCLES,
            "material": figures.collect::<serde_json::Map<_, _>>(),
            "fitted": self.shown.iter().map(Shown::to_json).collect::<Vec<_>>(),
            "held_back": self.shown_held.iter().map(Shown::to_json).collect::<Vec<_>>(),
            "musts": musts(self).iter().map(|(title, musts)| json!({
                "title": title,
                "musts": musts.iter().map(|must| json!({
                    "test": must.test, "what": must.words, "must": must.must, "found": must.found, "met": must.is_met,
                    "mean_of_fitted_packings": must.of_packings,
                })).collect::<Vec<_>>(),
            })).collect::<Vec<_>>(),
            "half_stress_left_out": self.half_left_out.as_ref().map(|shown| shown.iter().map(Shown::to_json).collect::<Vec<_>>()),
            "collapses": self.collapses().iter().map(|one| json!({
                "test": KINDS[one.kind].words(), "seed": one.seed, "with_cohesion": one.coheres, "share_of_stress": one.share, "strain": one.strain,
            })).collect::<Vec<_>>(),
            "strain_of_bands": self.bands,
            "strain_of_layer_profile": STRETCH,
            "packings": of_packings(&self.fitted),
            "packings_held_back": of_packings(&self.held),
        })
    }
}

impl Tests {
    /// What was measured, before anything is fitted to it.
    pub fn to_json(&self, job: &str, command: &str) -> Value {
        json!({
            "program": crate::base::program::identity(),
            "job": job,
            "command": command,
            "grains": self.wanted.grains,
            "strain": self.wanted.strain,
            "packings": of_packings(&self.fitted),
            "packings_held_back": of_packings(&self.held),
        })
    }
}

fn of_packings(packings: &[Specimen]) -> Value {
    packings.iter().map(Specimen::to_json).collect()
}

impl Shown {
    /// Differences of the thirds; peak of the grains and of the law with their strains; volume strains at the end.
    pub fn cells(&self) -> [String; 7] {
        let Quality { ratio_off, peak, volume_end, .. } = &self.quality;
        let off = |part: usize| ratio_off[part].map_or("-".to_string(), |off| significant(off, 2));
        let peak = |of: usize| format!("{}, {} %", significant(peak[of][0], 3), significant(100.0 * peak[of][1], 2));
        let volume = |of: usize| format!("{} %", significant(100.0 * volume_end[of], 3));
        [off(0), off(1), off(2), peak(0), peak(1), volume(0), volume(1)]
    }

    /// How unloading goes, a line for each turn; after the peak also where the stress is further back.
    pub fn unloaded(&self) -> Vec<String> {
        let turn = |turn: &Unloading| {
            let [grains, law] = turn.modulus.map(|modulus| significant(1e-6 * modulus, 3));
            let strain = significant(100.0 * turn.strain, 2);
            format!(
                "{}: back from {strain} % of strain, secant shear modulus {grains} MPa, of the law {law} MPa",
                self.kind.words()
            )
        };
        let mut lines: Vec<String> = self.unloadings.iter().map(turn).collect();
        if self.kind.course == Course::Reversal {
            lines.extend(BACK.iter().filter_map(|back| {
                let index = self.back_by(*back)?;
                let [grains, law] = [&self.curve.rows[index], &self.law[index].0].map(|row| self.curve.ratio(row));
                Some(format!(
                    "{}: back from the peak by {} % of strain, shear stress over normal stress {}, of the law {}",
                    self.kind.words(),
                    significant(100.0 * back, 2),
                    significant(grains, 3),
                    significant(law, 3)
                ))
            }));
        }
        lines
    }

    /// The row where a reversal has gone back from the peak by this strain.
    fn back_by(&self, back: f64) -> Option<usize> {
        let strain = |index: usize| self.curve.rows[index].strain;
        let top = (0..self.curve.rows.len()).max_by(|a, b| strain(*a).total_cmp(&strain(*b)))?;
        (top..self.curve.rows.len()).find(|index| strain(*index) <= STRAIN_REVERSAL - back + 1e-9)
    }

    fn to_json(&self) -> Value {
        let quality = &self.quality;
        let law: Vec<Row> = self.law.iter().map(|(row, _)| *row).collect();
        json!({
            "test": self.kind.words(),
            "ratio_off_rms_thirds": quality.ratio_off,
            "ratio_off_largest_first_third": quality.ratio_largest,
            "ratio_scatter_of_packings_thirds": self.scatter,
            "ratio_off_largest": quality.ratio_largest_all,
            "sine_off_largest_to_3_percent": quality.sine_largest,
            "unloading": self.unloadings.iter().map(|one| json!({
                "strain": one.strain, "secant_modulus": { "grains": one.modulus[0], "law": one.modulus[1] },
            })).collect::<Vec<_>>(),
            "pressure_off_rms": quality.pressure_off,
            "pressure_off_largest": quality.pressure_largest,
            "peak": { "grains": quality.peak[0], "law": quality.peak[1], "plateau_of_grains": quality.plateau },
            "volume_strain_end": { "grains": quality.volume_end[0], "law": quality.volume_end[1] },
            "volume_strain_off_largest": { "first_third": quality.volume_largest[0], "all": quality.volume_largest[1] },
            "mean": Columns::of(&self.curve.rows),
            "law": Columns::of(&law),
            "law_volume": self.law.iter().map(|(_, volume)| *volume).collect::<Vec<f64>>(),
        })
    }
}

impl Specimen {
    fn to_json(&self) -> Value {
        let tests = |tests: &[Tested]| -> Vec<Value> {
            let one = |(kind, tested): (&Kind, &Tested)| {
                json!({
                    "test": kind.words(),
                    "rows": Columns::of(&tested.rows),
                    "layers": tested.profiles.iter().map(|profile| json!([profile.strain, profile.shares])).collect::<Vec<_>>(),
                })
            };
            KINDS.iter().zip(tests).map(one).collect()
        };
        json!({
            "seed": self.seed,
            "isotropic": Columns::of(&self.isotropic),
            "uniaxial": Columns::of(&self.uniaxial),
            "tests": tests(&self.tests),
            "tests_without_cohesion": tests(&self.dry),
        })
    }
}

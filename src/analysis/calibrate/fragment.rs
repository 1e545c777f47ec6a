//! What a calibration leaves behind: a fragment that `[material] file` of a job names, and all data.

use std::fmt::Write;

use serde_json::{Value, json};

use super::columns::Columns;
use super::element::{INERTIAL_COMPRESSION, INERTIAL_SHEAR, STRAIN_SMALL, STRAIN_VOLUME};
use super::fit::{Fit, response};
use super::{Calibration, KEYS, Key};
use crate::job::significant;

const STRING: &str = "a string takes every line";

impl Calibration {
    /// The fragment; `command` is what made it, `job` the job's name.
    pub fn fragment(&self, job: &str, command: &str) -> String {
        let mut page = String::new();
        let mut line = |text: &str| writeln!(page, "{text}").expect(STRING);
        let seeds: Vec<String> = self.specimens.iter().map(|specimen| specimen.seed.to_string()).collect();
        line(&format!(
            "# The material of the continuum of {job}, calibrated by simulated element tests of its own grains:"
        ));
        line("#");
        line(&format!("#     {command}"));
        line("#");
        line(&format!(
            "# {} grains in each packing, seeds {}, made and tested under {} kPa. K and K + G: isotropic and uniaxial compression",
            self.wanted.grains,
            seeds.join(", "),
            significant(1e-3 * self.stress, 6)
        ));
        line(&format!(
            "# at inertial number {INERTIAL_COMPRESSION:e}, the first {STRAIN_SMALL:e} of volume strain. The rest: simple shear to {} % at constant normal",
            significant(100.0 * self.wanted.strain, 6)
        ));
        line(&format!(
            "# stress, inertial number {INERTIAL_SHEAR:e}, followed by the law with the least squares. Behind +-: standard deviation of"
        ));
        line("# the packings by themselves. A job takes this file by `file = \"...\"` in its [material].");
        line("");
        line("[material]");
        line("law = \"critical_drucker_prager\"");
        for key in &KEYS {
            let (value, spread) = self.figure(key);
            let spread = spread.filter(|spread| *spread > 0.0);
            let spread = spread.map_or(String::new(), |spread| format!(" +- {}", in_unit(key, spread, 2)));
            let bound = if self.fit.is_at_bound(key) { ", at its bound: the tests do not tell it" } else { "" };
            line(&format!(
                "# {}{spread}{bound}; Table 2 of Chen et al. (2021): {}",
                key.symbol,
                in_unit(key, key.table_2, 3)
            ));
            let value = in_unit(key, value, 4);
            let quoted = if key.unit.is_empty() { value } else { format!("\"{value}\"") };
            line(&format!("{} = {quoted}", key.name));
        }
        page
    }

    /// Everything that was measured and found.
    pub fn to_json(&self, job: &str, command: &str) -> Value {
        let quality = &self.quality;
        json!({
            "program": crate::base::program::identity(),
            "job": job,
            "command": command,
            "grains": self.wanted.grains,
            "stress": self.stress,
            "inertial_number_compression": INERTIAL_COMPRESSION,
            "inertial_number_shear": INERTIAL_SHEAR,
            "volume_strain_of_moduli": STRAIN_SMALL,
            "volume_strain_end": STRAIN_VOLUME,
            "material": KEYS.iter().map(|key| {
                let (value, spread) = self.figure(key);
                let fits = || self.specimens.iter().map(|specimen| &specimen.fit);
                let singles: Vec<f64> = fits().map(|fit| (key.of)(&fit.law)).collect();
                let singles_at_bound: Vec<bool> = fits().map(|fit| fit.is_at_bound(key)).collect();
                (key.name.to_string(), json!({
                    "value": value, "deviation": spread, "packings": singles, "table_2": key.table_2, "unit": key.unit,
                    "at_bound": self.fit.is_at_bound(key), "packings_at_bound": singles_at_bound,
                }))
            }).collect::<serde_json::Map<_, _>>(),
            "fit": {
                "friction_off_rms": quality.friction_off,
                "fraction_off_rms": quality.fraction_off,
                "peak_of_grains": quality.peak[0],
                "peak_of_law": quality.peak[1],
                "secant_shear_modulus": { "grains": quality.secant[0], "law": quality.secant[1] },
                "volume_strain_end": { "grains": quality.volume_end[0], "law": quality.volume_end[1] },
            },
            "packings": self.specimens.iter().map(|specimen| json!({
                "seed": specimen.seed,
                "isotropic": Columns::of(&specimen.isotropic),
                "uniaxial": Columns::of(&specimen.uniaxial),
                "shear": {
                    "stress": specimen.shear.stress,
                    "grains": Columns::of(&specimen.shear.rows),
                    "law": response(&self.fit.law, &specimen.shear).map(|response| Columns::of(&response.rows)),
                },
                "shear_without_cohesion": specimen.dry.as_ref().map(|dry| Columns::of(&dry.rows)),
            })).collect::<Vec<_>>(),
        })
    }
}

impl Fit {
    /// Whether the fit stopped at a bound of this figure: the tests do not tell it.
    pub fn is_at_bound(&self, key: &Key) -> bool {
        self.at_bound.contains(&key.name)
    }

    /// A figure in its unit, and whether it is at its bound.
    pub fn told(&self, key: &Key) -> String {
        let bound = if self.is_at_bound(key) { ", at its bound" } else { "" };
        format!("{}{bound}", in_unit(key, (key.of)(&self.law), 4))
    }
}

/// A figure with so many significant digits in the unit that people use.
pub fn in_unit(key: &Key, value: f64, count: usize) -> String {
    let (factor, unit) = match key.unit {
        "Pa" if key.name == "cohesion" => (1e-3, " kPa"),
        "Pa" => (1e-6, " MPa"),
        "rad" => (1.0, " rad"),
        _ => (1.0, ""),
    };
    format!("{}{unit}", significant(factor * value, count))
}

//! The resolved job as TOML: SI numbers in their shortest exact form, no default left open.

use std::fmt::Write;
use std::path::Path;

use super::Output;
use crate::law::contact::{Contact, LinearSpringDashpot, Sliding};

mod assembly;
mod mpm;
mod shear;

pub use assembly::assembly;
pub use mpm::mpm;
pub use shear::shear;

struct Page(String);

impl Page {
    fn new() -> Self {
        let mut page = Self(String::new());
        page.line("# Resolved by scree: SI units, angles in rad, every default written out.");
        page
    }

    fn text_of_all(self) -> String {
        self.0
    }

    fn line(&mut self, line: &str) {
        self.0.push_str(line);
        self.0.push('\n');
    }

    fn table(&mut self, name: &str) {
        self.line(&format!("\n[{name}]"));
    }

    fn number(&mut self, key: &str, value: f64) {
        self.line(&format!("{key} = {value:?}"));
    }

    fn count(&mut self, key: &str, value: u64) {
        self.line(&format!("{key} = {value}"));
    }

    fn flag(&mut self, key: &str, value: bool) {
        self.line(&format!("{key} = {value}"));
    }

    fn numbers(&mut self, key: &str, values: &[f64]) {
        self.line(&format!("{key} = {}", list(values)));
    }

    fn space(&mut self, axes: usize) {
        self.text("space", if axes == 2 { "plane" } else { "solid" });
    }

    /// From corner to corner.
    fn corners(&mut self, lower: &[f64], upper: &[f64]) {
        self.numbers("lower", lower);
        self.numbers("upper", upper);
    }

    fn path(&mut self, key: &str, path: &Path) {
        self.text(key, &path.display().to_string());
    }

    fn text(&mut self, key: &str, text: &str) {
        let mut quoted = String::new();
        for c in text.chars() {
            match c {
                '"' => quoted.push_str("\\\""),
                '\\' => quoted.push_str("\\\\"),
                c if c.is_control() => {
                    write!(quoted, "\\u{:04X}", c as u32).expect("a string takes every write");
                }
                c => quoted.push(c),
            }
        }
        self.line(&format!("{key} = \"{quoted}\""));
    }

    fn contact(&mut self, contact: &Contact) {
        self.table("contact");
        self.text("law", contact.law());
        match contact {
            Contact::Linear(law) => self.linear(law),
            Contact::LinearCohesive(law) => {
                self.linear(&law.linear);
                self.number("cohesion_normal", law.cohesion_normal);
                self.number("cohesion_tangential", law.cohesion_tangential);
            }
            Contact::ElasticRolling(law) => {
                self.number("young_modulus", law.young_modulus);
                self.number("stiffness_ratio", law.stiffness_ratio);
                self.number("friction", law.friction);
                self.number("rolling_stiffness", law.rolling_stiffness);
                self.number("rolling_limit", law.rolling_limit);
                self.text(
                    "sliding",
                    match law.sliding {
                        Sliding::Surface => "surface",
                        Sliding::Scaled => "scaled",
                    },
                );
            }
            Contact::HertzMindlin(law) => {
                self.number("shear_modulus", law.shear_modulus);
                self.number("poisson_ratio", law.poisson_ratio);
                self.number("friction", law.friction);
                self.number("damping_normal", law.damping_normal);
                self.number("damping_tangential", law.damping_tangential);
                self.number("damping_ratio", law.damping_ratio);
                self.text("normal_force", law.normal_force.name());
                self.text("tangential_force", law.tangential_force.name());
            }
        }
    }

    fn linear(&mut self, law: &LinearSpringDashpot) {
        self.number("stiffness_normal", law.stiffness_normal);
        self.number("stiffness_tangential", law.stiffness_tangential);
        self.number("damping_normal", law.damping_normal);
        self.number("damping_tangential", law.damping_tangential);
        self.number("friction", law.friction);
        self.text("normal_force", law.normal_force.name());
    }

    fn output(&mut self, output: &Output) {
        self.table("output");
        self.number("series_interval", output.series_interval);
        self.number("frame_interval", output.frame_interval);
        self.number("checkpoint_interval", output.checkpoint_interval);
        self.count("checkpoint_steps", output.checkpoint_steps);
        self.number("checkpoint_wall_interval", output.checkpoint_wall_interval);
        self.count("checkpoints_kept", output.checkpoints_kept as u64);
        self.count("checkpoints_for_good", output.checkpoints_for_good as u64);
    }
}

/// `[0.0, 1.5]`.
fn list(values: &[f64]) -> String {
    let shown: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
    format!("[{}]", shown.join(", "))
}

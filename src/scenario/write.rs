//! The resolved job as TOML: SI numbers in their shortest exact form, no default left open.

use std::fmt::Write;
use std::path::Path;

use super::Scenario;

pub fn toml(scenario: &Scenario) -> String {
    let mut page = Page(String::new());
    page.line("# Resolved by scree: SI units, angles in rad, every default written out.");
    page.text("name", &scenario.name);
    page.text("method", scenario.method.name());
    page.count("seed", scenario.seed);

    page.table("specimen");
    page.number("width", scenario.specimen.width);
    page.number("height", scenario.specimen.height);
    page.number("depth", scenario.specimen.depth);

    let grains = &scenario.grains;
    page.table("grains");
    page.number("diameter_mean", grains.diameter_mean);
    page.number("diameter_deviation", grains.diameter_deviation);
    page.number("density", grains.density);
    if let Some(file) = &grains.file {
        page.path("file", file);
    }

    let contact = &scenario.contact;
    page.table("contact");
    page.number("stiffness_normal", contact.stiffness_normal);
    page.number("stiffness_tangential", contact.stiffness_tangential);
    page.number("damping_normal", contact.damping_normal);
    page.number("damping_tangential", contact.damping_tangential);
    page.number("friction", contact.friction);

    let packing = &scenario.packing;
    page.table("packing");
    page.number("friction", packing.friction);
    page.number("fraction_start", packing.fraction_start);
    page.number("stress", packing.stress);
    page.number("energy_ratio_max", packing.energy_ratio_max);
    page.path("cache", &packing.cache);

    let continuum = &scenario.continuum;
    page.table("continuum");
    page.number("bulk_modulus", continuum.bulk_modulus);
    page.number("shear_modulus", continuum.shear_modulus);
    page.number("friction_angle_critical", continuum.friction_angle_critical);
    page.number("fraction_critical", continuum.fraction_critical);
    page.number("dilation_factor", continuum.dilation_factor);
    page.number("softening_rate", continuum.softening_rate);
    page.number("cohesion", continuum.cohesion);
    if let Some(fraction) = continuum.fraction_start {
        page.number("fraction_start", fraction);
    }
    page.number("cell", continuum.cell);
    page.count("points_per_cell", continuum.points_per_cell as u64);
    page.number("flip", continuum.flip);
    for region in &continuum.weak {
        page.line("\n[[continuum.weak]]");
        page.corner("lower", region.lower);
        page.corner("upper", region.upper);
        page.number("fraction_deficit", region.fraction_deficit);
    }

    let loading = &scenario.loading;
    page.table("loading");
    page.number("stress_normal", loading.stress_normal);
    page.number("speed", loading.speed);
    page.number("speed_ramp", loading.speed_ramp);
    page.number("strain_end", loading.strain_end);
    page.number("plate_mass", loading.plate_mass);
    page.number("plate_damping", loading.plate_damping);

    let oracle = &scenario.oracle;
    page.table("oracle");
    page.number("laplacian", oracle.laplacian);
    page.number("recent_strain", oracle.recent_strain);
    page.number("window", oracle.window);
    page.number("persistence", oracle.persistence);
    page.count("every", oracle.every);

    let enrichment = &scenario.enrichment;
    page.table("enrichment");
    page.number("distance", enrichment.distance);
    page.number("weight", enrichment.weight);
    page.number("training", enrichment.training);
    page.number("training_speed", enrichment.training_speed);
    page.number("training_rest", enrichment.training_rest);

    page.table("time");
    page.number("step", scenario.time.step);

    let decomposition = &scenario.decomposition;
    page.table("decomposition");
    page.count("cells_per_block", decomposition.cells_per_block as u64);
    page.number("skin", decomposition.skin);

    let output = &scenario.output;
    page.table("output");
    page.number("series_interval", output.series_interval);
    page.number("frame_interval", output.frame_interval);
    page.number("checkpoint_interval", output.checkpoint_interval);
    page.count("checkpoints_kept", output.checkpoints_kept as u64);
    page.0
}

struct Page(String);

impl Page {
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

    fn corner(&mut self, key: &str, [x, y]: [f64; 2]) {
        self.line(&format!("{key} = [{x:?}, {y:?}]"));
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
}

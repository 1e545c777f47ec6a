//! A run that was never simulated: displacements and stresses by formulas, written as a run writes them.

use std::fs;
use std::path::Path;

use scree_io::series::Series;
use scree_io::{Column, Drawn, Frame, FrameFile, Values};

use crate::base::math;

pub const WIDTH: f64 = 0.02;
pub const HEIGHT: f64 = 0.04;
pub const SPACING: f64 = 1e-3;
/// Strain at which the made-up run becomes grains between these heights, m.
pub const ENRICHED: f64 = 0.05;
pub const ZONE: [f64; 2] = [0.012, 0.028];
const RIM: f64 = 2e-3;
/// Half of the width of the band that forms with the enrichment, m.
const BAND: f64 = 1.5e-3;
/// Strain of a row of the series.
pub const ROW: f64 = 5e-4;
const STRAIN_END: f64 = 0.1;
/// Strain over which a stress may dip after the enrichment, and of a swing: as many rows as two windows of the average have.
pub const DIPPED: f64 = 10.0 * ROW;
const SWING: f64 = 16.0 * ROW;

/// What a body of a made-up frame is told by.
#[derive(Clone, Copy, Default)]
pub struct Row {
    pub kind: i64,
    pub id: i64,
    pub position: [f64; 2],
    pub displacement: [f64; 2],
    pub weight: f64,
    pub stress: [f64; 3],
    pub deviatoric: f64,
}

/// A frame of bodies that are half of [`SPACING`] in radius.
pub fn frame_of(time: f64, rows: &[Row]) -> Frame {
    let column = |name: &str, width: usize, values: Values| Column { name: name.to_owned(), width, values };
    let whole = |of: fn(&Row) -> i64| Values::I64(rows.iter().map(of).collect());
    let real = |of: fn(&Row) -> f64| Values::F64(rows.iter().map(of).collect());
    Frame {
        time,
        drawn: Drawn::Points,
        positions: rows.iter().map(|row| [row.position[0], row.position[1], 0.0]).collect(),
        whole: Vec::new(),
        fields: vec![
            column("kind", 1, whole(|row| row.kind)),
            column("id", 1, whole(|row| row.id)),
            column("radius", 1, real(|_| 0.5 * SPACING)),
            column("weight", 1, real(|row| row.weight)),
            column(
                "displacement",
                3,
                Values::F64(rows.iter().flat_map(|row| [row.displacement[0], row.displacement[1], 0.0]).collect()),
            ),
            column("stress", 3, Values::F64(rows.iter().flat_map(|row| row.stress).collect())),
            column("deviatoric_strain", 1, real(|row| row.deviatoric)),
        ],
    }
}

/// What a made-up run differs in from others.
#[derive(Clone, Copy, Debug)]
pub struct Made<'a> {
    pub method: &'a str,
    pub seed: i64,
    /// Rows of the series lie so many times [`ROW`] apart.
    pub rows_apart: i32,
    /// Factor of the shear stress on the plate.
    pub stress: f64,
    /// Share of it that is lost from [`ENRICHED`] to the end, by and by.
    pub fall: f64,
    /// Share of it that is missing for [`DIPPED`] of strain after the enrichment.
    pub dip: f64,
    /// Share of it by which it swings, once in [`SWING`] of strain.
    pub swing: f64,
    /// Shear stress of grains at a strain of one, and of all grains of a hybrid, Pa.
    pub stress_grains: f64,
    pub training: f64,
    pub band: f64,
    /// Height of the band's middle, m.
    pub band_at: f64,
    /// Share by which it shears more in the middle of the width, and less at its ends.
    pub bulge: f64,
    /// Last frame, percent of strain.
    pub frames: i32,
    /// s.
    pub wall: f64,
    pub ranks: i32,
    pub grain_steps: i32,
    /// Steps before it was resumed, of 1000.
    pub resumed: i32,
    /// It begins as grains, the first of which turn into points at [`ENRICHED`], after 0.4 of its time.
    pub everywhere: bool,
}

impl<'a> Made<'a> {
    pub fn of(method: &'a str) -> Self {
        Self {
            method,
            seed: 1,
            rows_apart: 1,
            stress: 1.0,
            fall: 0.0,
            dip: 0.0,
            swing: 0.0,
            stress_grains: 2e6,
            training: 1.0,
            band: BAND,
            band_at: 0.5 * HEIGHT,
            bulge: 0.0,
            frames: 10,
            wall: 1.5,
            ranks: 2,
            grain_steps: 1,
            resumed: 0,
            everywhere: false,
        }
    }

    /// Horizontal displacement at a place and a strain: a band that sharpens with the enrichment.
    fn displacement(&self, [x, y]: [f64; 2], strain: f64) -> f64 {
        let bulge = 1.0 - self.bulge * math::cos(2.0 * math::PI * x / WIDTH);
        let band = 0.5 + bulge * math::atan((y - self.band_at) / self.band) / math::PI;
        WIDTH * (strain.min(ENRICHED) * y / HEIGHT + (strain - ENRICHED).max(0.0) * band)
    }

    /// Shear stress on the plate, Pa.
    fn plate_stress(&self, strain: f64) -> f64 {
        let since = strain - ENRICHED;
        let fallen = self.fall * since.max(0.0) / (STRAIN_END - ENRICHED);
        // Half a row, so that rounding does not decide.
        let dip = if (0.5 * ROW..DIPPED + 0.5 * ROW).contains(&since) { self.dip } else { 0.0 };
        let swing = self.swing * math::sin(2.0 * math::PI * strain / SWING);
        self.stress * 150e3 * (1.0 - math::exp(-strain / 0.01)) * (1.0 - fallen) * (1.0 - dip) * (1.0 + swing)
    }

    fn rows(&self, strain: f64) -> Vec<Row> {
        let mut rows = Vec::new();
        let method = self.method;
        let grains = method == "hybrid" && strain > ENRICHED;
        let stress = self.stress_grains * if method == "dem" { strain } else { ENRICHED + ROW };
        for id in 0..((WIDTH / SPACING).round() * (HEIGHT / SPACING).round()) as i64 {
            let columns = (WIDTH / SPACING).round() as i64;
            let [x, y] = [((id % columns) as f64 + 0.5) * SPACING, ((id / columns) as f64 + 0.5) * SPACING];
            let moved = self.displacement([x, y], strain);
            let plate = !(SPACING..HEIGHT - SPACING).contains(&y);
            let inside = (ZONE[0]..ZONE[1]).contains(&y);
            let rim = inside && !(ZONE[0] + RIM..ZONE[1] - RIM).contains(&y);
            let weight = if grains && rim { 0.5 } else { 1.0 };
            let (position, displacement) = ([(x + moved).rem_euclid(WIDTH), y], [moved, 0.0]);
            let point = Row { id, position, displacement, weight, ..Row::default() };
            if plate && method != "mpm" {
                rows.push(Row { kind: 2, weight: 1.0, ..point });
            } else if method == "dem" || (grains && inside) {
                rows.push(Row { kind: 1, stress: [0.0, 0.0, stress], ..point });
            }
            if method != "dem" && (!grains || !inside || rim) {
                rows.push(point);
            }
        }
        rows
    }

    fn frame(&self, strain: f64) -> Frame {
        frame_of(strain, &self.rows(strain))
    }

    /// Writes a run to 10 % strain.
    pub fn write(&self, directory: &Path) {
        let Self { method, seed, training, wall, ranks, grain_steps, .. } = *self;
        fs::create_dir_all(directory).unwrap();
        let scenario = format!(
            "name = \"small <{method}>\"\nmethod = \"{method}\"\nseed = {seed}\n[specimen]\nwidth = {WIDTH}\n\
             [grains]\ndiameter_mean = {SPACING}\n[loading]\nstress_normal = 400e3\nspeed = 0.02\n\
             [scheme]\npoints_per_cell = 2\n[continuum]\ncell = {}\n[enrichment]\ntraining = {training}\n[time]\nstep = 1e-4\n\
             grain_steps = {grain_steps}\n",
            2.0 * SPACING
        );
        let zone = if self.everywhere { "[zone]\nbegins = \"everywhere\"\n" } else { "" };
        fs::write(directory.join("scenario.toml"), scenario + zone).unwrap();
        // A thousand steps to a strain of 0.1 in 0.1 s; half of the hybrid's time is spent before enrichment.
        if self.everywhere {
            let shrank = |step: i32, seconds: f64| {
                format!(
                    "{{\"event\":\"zone_shrank\",\"step\":{step},\"time\":{},\"seconds_of_steps\":{seconds}}}\n",
                    1e-4 * f64::from(step)
                )
            };
            fs::write(directory.join("log.jsonl"), shrank(505, 0.4 * wall) + &shrank(700, 0.6 * wall)).unwrap();
        }
        let enriched = match method {
            "hybrid" if !self.everywhere => format!(
                r#""seconds_of_steps_before_enrichment": {}, "training_seconds": {}, "enriched_at_time": 0.0505,"#,
                0.4 * wall,
                0.1 * wall
            ),
            _ => String::new(),
        };
        let steps = f64::from(1000 - self.resumed);
        let summary = format!(
            r#"{{"outcome": "done", "ranks": {ranks}, "threads": 1, "steps": 1000, "wall_seconds": {wall},
                "microseconds_per_step": {}, "points": 800, "grain_steps_per_second": {}, "point_steps_per_second": {},
                {enriched} "phases":
                {{"output": {{"mean": {}}}, "couple": {{"mean": {}}}, "scatter": {{"mean": {}}}}}}}"#,
            1e6 * wall / steps,
            800.0 * steps / wall,
            800.0 * steps / f64::from(grain_steps) / wall,
            0.1 * wall,
            0.08 * wall,
            0.2 * wall,
        );
        fs::write(directory.join("summary.json"), summary).unwrap();

        let path = directory.join("frames.vtkhdf");
        let mut frames = FrameFile::create(&path, directory, &self.frame(0.0), 0, &[], &[]).unwrap();
        for index in 1..=self.frames {
            frames.append(&self.frame(0.01 * f64::from(index) + 1e-9)).unwrap();
        }
        let header = "step,time,strain,shear_stress,normal_stress,volume_strain,grains,points,\
                      kinetic_grains,elastic_grains,kinetic_points,elastic_points";
        let mut series = Series::create(&directory.join("series.csv"), &header.split(',').collect::<Vec<_>>()).unwrap();
        for row in 1..=200 / self.rows_apart {
            let strain = ROW * f64::from(row * self.rows_apart);
            let grains = self.rows(strain).iter().filter(|row| row.kind > 0).count() as f64;
            let (stress, dilation) = (self.plate_stress(strain), 0.1 * strain);
            let row = [f64::from(row), strain, strain, stress, 400e3, dilation, grains, 500.0, 0.0, 1e-3, 1e-6, 1e-2];
            series.push(&row).unwrap();
        }
    }
}

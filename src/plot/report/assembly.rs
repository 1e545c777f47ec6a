//! The report on grains in a cell: the grains at three moments, and the curves of `series.csv` against time.

use scree_io::{Values, frames};

use super::chart::significant;
use super::load::{Kind, torn_frames, unreadable};
use super::panels::{colour_bar, round_up};
use super::records::{AXES, Line, Plot, Record, draw, time};
use super::svg::{Anchor, Frame, INK, Letters, Stroke, Svg, number};
use super::{WIDTH, colour};
use crate::base::error::Error;

/// Panels side by side, the room between them, and the height that they may have, pixels.
const PANELS: usize = 3;
const GAP: f64 = 22.0;
const PANEL_HEIGHT_MAX: f64 = 420.0;
/// Share of the grains that may lie beyond the end of the colours.
const BEYOND: f64 = 0.01;

/// A run of an assembly.
pub struct Run {
    pub record: Record,
    dimension: usize,
    /// Lower corner of the cell, m.
    corner: Vec<f64>,
    bodies: Vec<String>,
}

/// A grain of a picture.
struct Grain {
    position: [f64; 3],
    radius: f64,
    glued: bool,
    /// Mean stress of its contacts, compression positive, Pa.
    pressure: f64,
}

/// Grains at the time of a frame, s.
struct Scene {
    time: f64,
    grains: Vec<Grain>,
}

impl Run {
    pub fn new(record: Record) -> Self {
        let dimension = record.dimension("cell");
        let mut corner = record.numbers("cell.lower");
        corner.resize(dimension, 0.0);
        Self { dimension, corner, bodies: record.names("body"), record }
    }

    /// What happened, in a few sentences.
    pub fn words(&self) -> String {
        let kind = if self.dimension == 2 { "discs" } else { "spheres" };
        let stresses: Vec<String> = self.axes().iter().map(|axis| self.stress_at_end(axis)).collect();
        format!(
            "{:.0} {kind} in a cell for {}. At the end the packing fraction is {}, a grain has {} contacts, and the \
             normal stresses of the contacts are {} kPa (compression positive) along {}.",
            self.record.last("grains"),
            time(self.record.last("time")),
            significant(self.record.last("fraction"), 4),
            significant(2.0 * self.record.last("contacts") / self.record.last("grains"), 3),
            stresses.join(", "),
            self.axes().join(", "),
        )
    }

    fn stress_at_end(&self, axis: &str) -> String {
        significant(-1e-3 * self.record.last(&format!("stress_{axis}{axis}")), 3)
    }

    fn axes(&self) -> &'static [&'static str] {
        &AXES[..self.dimension]
    }

    /// Edges of the cell in the row nearest to a time, m: as columns.
    fn edges(&self, time: f64) -> Vec<Vec<f64>> {
        let row = self.record.row_at(time);
        let entry = |i: &str, j: &str| self.record.column(&format!("edge_{i}{j}")).get(row).copied();
        let edge = |j: &&str| self.axes().iter().map(|i| entry(i, j).unwrap_or(0.0)).collect();
        self.axes().iter().map(edge).collect()
    }

    fn scene(&self, index: usize) -> Result<Scene, Error> {
        let path = self.record.directory.join("frames.vtkhdf");
        let frame = frames::read_frame(&path, index).map_err(unreadable)?;
        let rows = frame.positions.len();
        let find = |name: &str| frame.fields.iter().find(|column| column.name == name);
        let torn = |name: &str| torn_frames(&path, &format!("frame {index}: field `{name}` is not what it should be"));
        let reals = |name: &str| match find(name).map(|column| (&column.values, column.width)) {
            Some((Values::F64(values), width)) if values.len() == rows * width => Ok((values, width)),
            _ => Err(torn(name)),
        };
        let ((radii, _), (stresses, width)) = (reals("radius")?, reals("stress")?);
        let kinds = match find("kind").map(|column| &column.values) {
            Some(Values::I64(kinds)) if kinds.len() == rows => kinds,
            _ => return Err(torn("kind")),
        };
        let grain = |row: usize| {
            // xx, yy, xy and in space zz.
            let stress = &stresses[width * row..width * (row + 1)];
            let trace = stress[0] + stress[1] + if self.dimension == 3 { stress[3] } else { 0.0 };
            Grain {
                position: frame.positions[row],
                radius: radii[row],
                glued: kinds[row] == Kind::Glued as i64,
                pressure: -trace / self.dimension as f64,
            }
        };
        Ok(Scene { time: frame.time, grains: (0..rows).map(grain).collect() })
    }

    /// The grains at the start, in the middle and at the end.
    pub fn picture(&self) -> Result<String, Error> {
        let last = self.record.frame_times.len() - 1;
        let mut chosen = vec![0, last / 2, last];
        chosen.dedup();
        let scenes = chosen.into_iter().map(|index| self.scene(index)).collect::<Result<Vec<_>, _>>()?;
        let view = View::of(self, &scenes);
        let (room, size) = ((WIDTH - GAP * (PANELS + 1) as f64) / PANELS as f64, view.size());
        let scale = (room / size[0]).min(PANEL_HEIGHT_MAX / size[1]);
        let frame = |column: usize| Frame {
            left: GAP + column as f64 * (room + GAP) + 0.5 * (room - size[0] * scale),
            top: 34.0,
            width: size[0] * scale,
            height: size[1] * scale,
        };
        let upper = colours_end(&scenes);
        let mut svg = Svg::new("grains", WIDTH, 34.0 + size[1] * scale + 76.0);
        for (column, scene) in scenes.iter().enumerate() {
            let panel = Panel { view: &view, scale, frame: frame(column), upper };
            let title = format!("({}) {}", ["a", "b", "c"][column.min(2)], time(scene.time));
            svg.text([panel.frame.left, 22.0], &title, Letters::new(13.0, Anchor::Start).bold());
            panel.draw(&mut svg, scene, &self.edges(scene.time));
        }
        let place = [0.5 * (WIDTH - 230.0), 34.0 + size[1] * scale + 16.0];
        if scenes.iter().flat_map(|scene| &scene.grains).any(|grain| grain.pressure > 0.0) {
            colour_bar(&mut svg, place, 230.0, 1e-3 * upper, "mean stress of a grain's contacts (kPa)");
        } else {
            let letters = Letters::new(12.0, Anchor::Middle);
            svg.text([0.5 * WIDTH, place[1] + 20.0], "no contact is under compression at these times", letters);
        }
        Ok(svg.finish("The grains, coloured by mean stress"))
    }

    /// The curves: stresses, packing fraction, energies, contacts, and forces on bodies.
    pub fn curves(&self) -> Vec<(&'static str, String, &'static str)> {
        let mut figures = vec![
            ("stress", self.stresses(), STRESS_WORDS),
            (
                "energies",
                self.energies(),
                "Energies of the grains against time. What is zero has no place on this scale.",
            ),
        ];
        if !self.bodies.is_empty() {
            figures.push((
                "bodies",
                self.forces(),
                "Force of the grains on every body, magnitude of the mean over a row of series.csv.",
            ));
        }
        figures
    }

    fn stresses(&self) -> String {
        let mut lines: Vec<Line> = Vec::new();
        for axis in self.axes() {
            lines.push((format!("\u{2212}{axis}{axis}"), self.record.curve(&format!("stress_{axis}{axis}"), -1e-3)));
        }
        lines.push(("xy".to_owned(), self.record.curve("stress_xy", 1e-3)));
        let contacts = self.record.column("contacts").iter().zip(self.record.column("grains"));
        let contacts = self
            .record
            .column("time")
            .iter()
            .zip(contacts)
            .map(|(time, (contacts, grains))| [*time, 2.0 * contacts / grains]);
        draw(
            "stress",
            &[
                Plot { label: "stress (kPa)", lines, is_logarithmic: false },
                Plot {
                    label: "packing fraction",
                    lines: vec![(String::new(), self.record.curve("fraction", 1.0))],
                    is_logarithmic: false,
                },
                Plot {
                    label: "contacts of a grain",
                    lines: vec![(String::new(), contacts.collect())],
                    is_logarithmic: false,
                },
            ],
        )
    }

    fn energies(&self) -> String {
        let names = [
            ("elastic", "elastic"),
            ("kinetic_translation", "kinetic, translation"),
            ("kinetic_rotation", "kinetic, rotation"),
        ];
        let lines = names.map(|(column, words)| (words.to_owned(), self.record.curve(column, 1.0)));
        draw("energies", &[Plot { label: "energy (J)", lines: lines.into(), is_logarithmic: true }])
    }

    fn forces(&self) -> String {
        let force = |body: &String| (body.clone(), self.record.length(&format!("{body}_force"), self.axes(), 1.0));
        let lines = self.bodies.iter().take(colour::LINES.len()).map(force).collect();
        draw("bodies", &[Plot { label: "force (N)", lines, is_logarithmic: false }])
    }
}

const STRESS_WORDS: &str = "(a) Mean stress of the contacts over the cell, normal stresses positive in compression; (b) \
     packing fraction of the cell; (c) contacts of a grain in the mean, against time.";

/// The mean stress at which the colours end, Pa.
fn colours_end(scenes: &[Scene]) -> f64 {
    let mut values: Vec<f64> = scenes.iter().flat_map(|scene| &scene.grains).map(|grain| grain.pressure).collect();
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    let beyond = (values.len() as f64 * BEYOND) as usize;
    round_up(values.len().checked_sub(1 + beyond).map_or(0.0, |index| values[index]))
}

/// What a picture shows of space: x to the right, and upwards y of discs, z of spheres, which are seen along y.
struct View {
    up: usize,
    corner: Vec<f64>,
    /// Lower and upper ends, m.
    across: [f64; 2],
    along: [f64; 2],
}

impl View {
    /// Wide enough for the cell and every grain of all scenes.
    fn of(run: &Run, scenes: &[Scene]) -> Self {
        let mut view = Self { up: run.dimension - 1, corner: run.corner.clone(), across: EMPTY, along: EMPTY };
        for scene in scenes {
            for place in view.outline(&run.edges(scene.time)) {
                view.widen(place, 0.0);
            }
            for grain in &scene.grains {
                view.widen(view.seen(&grain.position), grain.radius);
            }
        }
        view
    }

    fn widen(&mut self, [x, y]: [f64; 2], reach: f64) {
        for (ends, value) in [(&mut self.across, x), (&mut self.along, y)] {
            *ends = [ends[0].min(value - reach), ends[1].max(value + reach)];
        }
    }

    fn seen(&self, position: &[f64; 3]) -> [f64; 2] {
        [position[0], position[self.up]]
    }

    /// Corners of the face of the cell that is seen.
    fn outline(&self, edges: &[Vec<f64>]) -> [[f64; 2]; 4] {
        let corner = [self.corner[0], self.corner[self.up]];
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[first, second]| {
            let place = |axis: usize| first * edges[0][axis] + second * edges[self.up][axis];
            [corner[0] + place(0), corner[1] + place(self.up)]
        })
    }

    fn size(&self) -> [f64; 2] {
        [self.across, self.along].map(|[lower, upper]| if upper > lower { upper - lower } else { 1.0 })
    }
}

const EMPTY: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

/// Where a scene is drawn.
struct Panel<'a> {
    view: &'a View,
    /// Pixels per metre.
    scale: f64,
    frame: Frame,
    /// The end of the colours, Pa.
    upper: f64,
}

impl Panel<'_> {
    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            self.frame.left + (x - self.view.across[0]) * self.scale,
            self.frame.bottom() - (y - self.view.along[0]) * self.scale,
        ]
    }

    /// Grains, the farthest first, and the cell over them.
    fn draw(&self, svg: &mut Svg, scene: &Scene, edges: &[Vec<f64>]) {
        let mut order: Vec<&Grain> = scene.grains.iter().collect();
        if self.view.up == 2 {
            order.sort_by(|a, b| b.position[1].total_cmp(&a.position[1]));
        }
        for grain in order {
            let [x, y] = self.place(self.view.seen(&grain.position));
            let fill = match grain.glued {
                true => colour::PLATE.to_owned(),
                false => colour::map(colour::step(grain.pressure / self.upper)),
            };
            svg.raw(&format!(
                "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{fill}\" stroke=\"#444444\" stroke-width=\"0.3\"/>\n",
                number(x),
                number(y),
                number(grain.radius * self.scale)
            ));
        }
        let corners = self.view.outline(edges).map(|corner| self.place(corner));
        for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            svg.line(*from, *to, Stroke::new(INK, 1.0).dash("4 3"));
        }
    }
}

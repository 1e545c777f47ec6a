//! Points that are followed: where they go, and the force chains of their RVEs (Liang & Zhao 2019, figures 11, 18, 23 and 28).

use std::fmt::Write as _;
use std::path::Path;

use scree_io::column::Values;
use scree_io::frames::{self, Frame as FileFrame};

use super::chart::{Axis, Chart, Curve, Entry, draw, pair};
use super::numbers::{significant, time};
use super::pictures::{GAP, MARGIN, TITLES};
use super::svg::{Anchor, Frame, Letters, Stroke, Svg, number};
use super::{Drawn, WIDTH, colour};
use crate::analysis::curve::{mean, range};
use crate::analysis::run::{Run, torn_frames, unreadable};
use crate::base::error::Error;
use crate::base::space::AXES;
use crate::run::folder::{CONTACTS_OF, GRAINS_OF};

const COLUMNS_MAX: usize = 4;
/// Largest height of an RVE, pixels.
const HEIGHT_MAX: f64 = 360.0;
/// Grains of an RVE up to which they are drawn, and all of its contacts.
const SINGLE_MAX: usize = 3_000;
/// Width of the line of a contact whose force is the mean one, and of the strongest, pixels.
const LINE: f64 = 0.9;
const LINE_MAX: f64 = 7.0;
const CHAIN: &str = "#8b1a1a";
const WEAK: &str = "#d9a79c";
const GRAIN: &str = "#e6e2d8";

/// The figures of runs that follow points.
pub fn figures(runs: &[&Run], number: &str) -> Result<Vec<Drawn>, Error> {
    let mut figures: Vec<Drawn> = paths(runs, number).into_iter().chain(loops(runs, number)).collect();
    let mut chains = Vec::new();
    for run in runs {
        for name in names(run, "_void_ratio") {
            chains.extend(Chains::read(run, &name, runs.len() > 1)?);
        }
    }
    if !chains.is_empty() {
        figures.push(chains_of(&chains, number));
    }
    Ok(figures)
}

/// Points that have a column of this ending.
fn names(run: &Run, ending: &str) -> Vec<String> {
    run.columns.iter().filter_map(|column| column.name.strip_suffix(ending)).map(str::to_owned).collect()
}

/// Where points have gone, seen along an axis in space.
fn paths(runs: &[&Run], suffix: &str) -> Option<Drawn> {
    let (mut curves, mut entries) = (Vec::new(), Vec::new());
    for run in runs {
        let up = AXES[run.up()];
        for name in names(run, "_place_x") {
            let of = |axis: &str| run.column(&format!("{name}_place_{axis}"));
            let places: Vec<[f64; 2]> = of("x").iter().zip(of(up)).map(|(x, y)| [*x, *y]).collect();
            let stroke = Stroke::new(colour::line(curves.len()), 1.6).dash(colour::DASHES[curves.len() / 6 % 6]);
            entries
                .push(Entry { words: if runs.len() > 1 { format!("{}: {name}", run.label()) } else { name }, stroke });
            curves.push(Curve { places, stroke });
        }
    }
    let all = || curves.iter().flat_map(|curve: &Curve| &curve.places).copied();
    let has_moved = curves.iter().any(|curve| curve.places.iter().any(|place| *place != curve.places[0]));
    if !has_moved {
        return None;
    }
    let chart = Chart {
        x: Axis::around("x (m)", all().map(|place| place[0])),
        y: Axis::around(&format!("{} (m)", AXES[runs[0].up()]), all().map(|place| place[1])),
        curves,
        ..Chart::default()
    };
    let name = format!("paths{suffix}");
    let drawing = draw(&name, "Paths of points", &entries, &[chart], 1);
    Some(Drawn {
        name,
        drawing,
        caption: "Where points that are followed have gone; the axes have scales of their own.".into(),
    })
}

/// Stress against strain of points that carry grains (Liu et al. 2016, figure 8): of all shear components the one that strains most, and of all normal
/// ones.
fn loops(runs: &[&Run], suffix: &str) -> Option<Drawn> {
    let axes = &AXES[..runs[0].dimension()];
    let is_shear = |component: &str| component[..1] != component[1..];
    let components: Vec<String> =
        axes.iter().enumerate().flat_map(|(row, i)| axes[row..].iter().map(move |j| [*i, *j].concat())).collect();
    let points: Vec<(&Run, String)> =
        runs.iter().flat_map(|run| names(run, "_strain_xx").into_iter().map(|name| (*run, name))).collect();
    let points: Vec<&(&Run, String)> =
        points.iter().filter(|(run, name)| !run.column(&format!("{name}_void_ratio")).is_empty()).collect();
    let reach = |component: &str| {
        let of = |(run, name): &&(&Run, String)| {
            range(run.column(&format!("{name}_strain_{component}")).iter().copied())
                .map_or(0.0, |[low, high]| high - low)
        };
        points.iter().map(of).fold(0.0, f64::max)
    };
    let most = |shear: bool| {
        let of = components.iter().filter(|component| is_shear(component) == shear);
        of.max_by(|a, b| reach(a).total_cmp(&reach(b))).filter(|component| reach(component) > 0.0)
    };
    let (mut charts, mut entries) = (Vec::new(), Vec::new());
    for (component, is_shear) in [(most(true), true), (most(false), false)] {
        let Some(component) = component else { continue };
        // Engineering shear strain; compression positive.
        let [of_strain, of_stress] = if is_shear { [2.0, 1.0] } else { [-1.0, -1.0] };
        let mut curves = Vec::new();
        for (number, (run, name)) in points.iter().enumerate() {
            let of = |what: &str| run.column(&format!("{name}_{what}_{component}"));
            let pair = |(strain, stress): (&f64, &f64)| [100.0 * of_strain * strain, 1e-3 * of_stress * stress];
            let stroke = Stroke::new(colour::line(number), 1.4).dash(colour::DASHES[number / 6 % 6]);
            curves.push(Curve { places: of("strain").iter().zip(of("stress")).map(pair).collect(), stroke });
            if charts.is_empty() {
                let words = if runs.len() > 1 { format!("{}: {name}", run.label()) } else { name.clone() };
                entries.push(Entry { words, stroke });
            }
        }
        let all =
            |at: usize| curves.iter().flat_map(move |curve: &Curve| curve.places.iter().map(move |place| place[at]));
        let [x, y] =
            if is_shear { ["shear strain", "shear stress"] } else { ["compressive strain", "compressive stress"] };
        charts.push(Chart {
            title: format!("({}) {component}", if charts.is_empty() { "a" } else { "b" }),
            x: Axis::around(&format!("{x} {component} (%)"), all(0)),
            y: Axis::around(&format!("{y} {component} (kPa)"), all(1)),
            curves,
            ..Chart::default()
        });
    }
    if charts.is_empty() {
        return None;
    }
    let name = format!("stress_strain{suffix}");
    let drawing = draw(&name, "Stress against strain of followed points", &entries, &charts, charts.len());
    let caption = "Stress against logarithmic strain of the RVEs of points that are followed: the shear and the normal component that strain most; shear strain is the engineering one, compression positive.";
    Some(Drawn { name, drawing, caption: caption.into() })
}

/// The RVE of a point at the last frame.
struct Chains {
    titles: [String; 2],
    /// Corners of the cell then, and at the first frame, from the middle, m.
    cells: [[[f64; 2]; 4]; 2],
    /// Places from the middle of the cell and radii, m.
    grains: Vec<([f64; 2], f64)>,
    /// Ends from the middle of the cell, m, and normal force, N.
    lines: Vec<([[f64; 2]; 2], f64)>,
}

impl Chains {
    /// None where the run has not written it.
    fn read(run: &Run, name: &str, is_labelled: bool) -> Result<Option<Self>, Error> {
        let [grains, contacts] = [GRAINS_OF, CONTACTS_OF].map(|of| run.directory.join(format!("{of}{name}.vtkhdf")));
        if !grains.exists() || !contacts.exists() {
            return Ok(None);
        }
        // What has been killed may have drawn the grains of one frame more.
        let counts = [&grains, &contacts].map(|path| Ok(frames::times(path).map_err(unreadable)?.len()));
        let [of_grains, of_contacts]: [Result<usize, Error>; 2] = counts;
        let Some(last) = of_grains?.min(of_contacts?).checked_sub(1) else { return Ok(None) };
        let up = run.up();
        let [first, now] = [0, last].map(|frame| frames::read_frame(&grains, frame).map_err(unreadable));
        let (first, now) = (first?, now?);
        let lines = frames::read_frame(&contacts, last).map_err(unreadable)?;
        let edges = |frame: &FileFrame| reals(&frame.whole, "cell_edges", 9, &grains);
        let (before, edges) = (edges(&first)?, edges(&now)?);
        // Half of the sum of the edges is the middle.
        let middle = [0, up].map(|axis| 0.5 * (0..3).map(|edge| edges[3 * edge + axis]).sum::<f64>());
        let place = |position: &[f64; 3]| [position[0] - middle[0], position[up] - middle[1]];
        let radii = reals(&now.fields, "radius", now.positions.len(), &grains)?;
        let forces = reals(&lines.fields, "force_normal", lines.positions.len() / 2, &contacts)?;
        let row = run.row_at(now.time);
        let told = |what: &str, unit: f64| {
            let value = run.column(&format!("{name}_{what}")).get(row).copied().unwrap_or(f64::NAN);
            significant(value / unit, 3)
        };
        let head = if is_labelled { format!("{}: {name}", run.label()) } else { name.to_owned() };
        let of = format!("{}, q {} kPa, e {}", time(now.time), told("q", 1e3), told("void_ratio", 1.0));
        Ok(Some(Self {
            titles: [head, of],
            cells: [edges, before].map(|edges| corners(&edges, up)),
            grains: now.positions.iter().map(place).zip(radii).collect(),
            lines: lines.positions.chunks_exact(2).map(|ends| [place(&ends[0]), place(&ends[1])]).zip(forces).collect(),
        }))
    }

    /// How far it reaches from its middle, m.
    fn reach(&self) -> [f64; 2] {
        let corners = self.cells.iter().flatten().copied();
        let grains =
            self.grains.iter().flat_map(|(place, radius)| [1.0, -1.0].map(|side| place.map(|at| at + side * radius)));
        corners.chain(grains).fold([0.0; 2], |far, place| [0, 1].map(|axis| f64::max(far[axis], place[axis].abs())))
    }
}

fn reals(columns: &[scree_io::Column], name: &str, count: usize, path: &Path) -> Result<Vec<f64>, Error> {
    let found = columns.iter().find(|column| column.name == name).map(|column| &column.values);
    match found {
        Some(Values::F64(values)) if values.len() == count => Ok(values.clone()),
        _ => Err(torn_frames(path, &format!("there is no field `{name}` of {count} numbers"))),
    }
}

/// Of the face of a cell that is seen, about its middle.
fn corners(edges: &[f64], up: usize) -> [[f64; 2]; 4] {
    let edge = |which: usize| [edges[3 * which], edges[3 * which + up]];
    let (a, b) = (edge(0), edge(up));
    [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]
        .map(|[of_a, of_b]| [0, 1].map(|axis| of_a * a[axis] + of_b * b[axis]))
}

/// All on one scale.
fn chains_of(chains: &[Chains], suffix: &str) -> Drawn {
    let columns = chains.len().min(COLUMNS_MAX);
    let far = |axis: usize| chains.iter().map(|chains| chains.reach()[axis]).fold(0.0, f64::max);
    let room = (WIDTH - 2.0 * MARGIN - (columns - 1) as f64 * GAP) / columns as f64;
    let scale = (room / (2.0 * far(0))).min(HEIGHT_MAX / (2.0 * far(1)));
    let row = TITLES + 2.0 * far(1) * scale + GAP;
    let name = format!("force_chains{suffix}");
    let mut svg = Svg::new(&name, WIDTH, chains.len().div_ceil(columns) as f64 * row);
    for (index, chains) in chains.iter().enumerate() {
        let (across, down) = (index % columns, index / columns);
        let left = MARGIN + across as f64 * (room + GAP);
        let top = down as f64 * row + TITLES;
        svg.text([left, top - 26.0], &chains.titles[0], Letters::new(13.0, Anchor::Start).bold());
        svg.text([left, top - 10.0], &chains.titles[1], Letters::new(12.0, Anchor::Start));
        let frame = Frame { left, top, width: room, height: row - TITLES - GAP };
        chains.draw(&mut svg, frame, scale);
    }
    let caption = "RVEs of points that are followed, at the last frame: lines are contacts, as wide as their normal force over the \
                   mean of their RVE, dark above it; the cell now, and dashed at the start. Lines that leave the cell lead to images. Of more than 3,000 grains the strong contacts alone."
        .to_owned();
    Drawn { drawing: svg.finish("Force chains of RVEs"), name, caption }
}

impl Chains {
    fn draw(&self, svg: &mut Svg, frame: Frame, scale: f64) {
        let middle = [frame.left + 0.5 * frame.width, frame.top + 0.5 * frame.height];
        let place = |[x, y]: [f64; 2]| [middle[0] + x * scale, middle[1] - y * scale];
        // Of an RVE that has been replicated many times the chains alone.
        let is_drawn_whole = self.grains.len() <= SINGLE_MAX;
        let mut grains = format!("<g fill=\"{GRAIN}\" stroke=\"#b5b0a4\" stroke-width=\"0.4\">");
        for (centre, radius) in self.grains.iter().filter(|_| is_drawn_whole) {
            let [x, y] = place(*centre).map(number);
            let _ = write!(grains, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{}\"/>", number(radius * scale));
        }
        svg.raw(&(grains + "</g>\n"));
        let forces: Vec<f64> = self.lines.iter().map(|(_, force)| force.abs()).collect();
        let mean = if forces.is_empty() { 1.0 } else { mean(&forces) };
        // The weak ones first, so that chains lie over them.
        for is_strong in [false, true].into_iter().filter(|is_strong| *is_strong || is_drawn_whole) {
            let mut lines = format!("<g stroke=\"{}\" stroke-linecap=\"round\">", if is_strong { CHAIN } else { WEAK });
            for (ends, force) in self.lines.iter().filter(|(_, force)| (force.abs() > mean) == is_strong) {
                let [[x1, y1], [x2, y2]] = ends.map(|end| place(end).map(number));
                let width = number((LINE * force.abs() / mean).clamp(0.15, LINE_MAX));
                let _ =
                    write!(lines, "<line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" stroke-width=\"{width}\"/>");
            }
            svg.raw(&(lines + "</g>\n"));
        }
        let dashed = [Stroke::new("#222222", 1.2), Stroke::new("#222222", 1.0).dash("5 4")];
        for (corners, stroke) in self.cells.iter().zip(dashed) {
            let mut path = String::new();
            for (number, corner) in corners.iter().enumerate() {
                let _ = write!(path, "{}{}", if number == 0 { "M" } else { "L" }, pair(place(*corner)));
            }
            svg.path(&(path + "Z"), stroke);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_stands_about_its_middle() {
        let leaning = [2.0, 0.0, 0.0, 1.0, 4.0, 0.0, 0.0, 0.0, 0.0];
        let corners = corners(&leaning, 1);
        assert_eq!(corners, [[-1.5, -2.0], [0.5, -2.0], [1.5, 2.0], [-0.5, 2.0]]);
        let [low, high] = range(corners.iter().map(|corner| corner[0])).unwrap();
        assert_eq!(low, -high);
    }

    /// A shear along y that grows with x is drawn by its engineering strain, and what no point strains by is left out.
    #[test]
    fn stress_is_drawn_against_the_strain_that_is_largest() {
        let column = |name: &str, values: [f64; 2]| crate::analysis::columns::Column {
            name: name.into(),
            values: values.to_vec(),
        };
        let mut run = Run::made("method = \"fem_dem\"\n[mesh]\nspace = \"plane\"");
        let quiet = ["tip_strain_xx", "tip_strain_yy", "tip_stress_xx", "tip_stress_yy"];
        run.columns = quiet.map(|name| column(name, [0.0; 2])).to_vec();
        run.columns.extend([column("tip_strain_xy", [0.0, 0.01]), column("tip_stress_xy", [0.0, 5e4])]);
        assert!(loops(&[&run], "").is_none(), "a point without grains is not drawn");
        run.columns.push(column("tip_void_ratio", [0.5; 2]));
        let drawn = loops(&[&run], "_2").unwrap();
        assert_eq!(drawn.name, "stress_strain_2");
        assert!(drawn.drawing.contains("shear strain xy (%)") && !drawn.drawing.contains("compressive"));
    }

    #[test]
    fn points_that_stay_have_no_path() {
        let mut run = Run::made("method = \"mpm\"");
        let column = |name: &str, values: [f64; 2]| crate::analysis::columns::Column {
            name: name.into(),
            values: values.to_vec(),
        };
        run.columns = vec![column("tip_place_x", [1.0, 1.0]), column("tip_place_y", [2.0, 2.0])];
        assert!(paths(&[&run], "").is_none());
        run.columns[1].values[1] = 3.0;
        assert!(paths(&[&run], "_2").unwrap().drawing.contains(">tip<"));
    }
}

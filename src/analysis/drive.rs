//! What a run is driven by, which its curves stand against: a strain where the job has one (the plate of planar shear, a body that
//! presses on material, a cell that is deformed), else the way of a body that moves, else time.

use toml::{Table, Value};

use super::run::{Run, as_number, broken, numbers};
use crate::base::error::Error;
use crate::base::math;

const AXES: [&str; 3] = ["x", "y", "z"];
/// The paper's intervals of strain for bands, over the ends of its tests: of planar shear, of axial strain.
const OF_SHEAR: [f64; 2] = [0.37 / 0.57, 1.0];
const OF_PRESS: [f64; 2] = [0.055 / 0.1061, 0.085 / 0.1061];
/// Of planar shear the interval ends here however far a run goes.
const SHEAR_END: f64 = 0.57;

/// What the numbers of a drive are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Measure {
    /// Of planar shear, of a cell, or of a body whose way is over a length that is known.
    Strain,
    /// Way of a body, m, where no such length is known.
    Length,
    /// s, where none of these drives the run.
    #[default]
    Time,
}

/// What resists a drive, by words and row by row, Pa.
#[derive(Clone, Debug, PartialEq)]
pub struct Resistance {
    /// For axes and captions.
    pub words: String,
    /// Positive where it acts against the drive.
    pub values: Vec<f64>,
}

/// A drive with its values row by row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drive {
    /// What kind of number the values are.
    pub measure: Measure,
    /// What the values are.
    pub words: String,
    /// Row by row of the series; in m of a length, in s of time.
    pub values: Vec<f64>,
    /// None of a length and of time.
    pub stress: Option<Resistance>,
    /// Whether each value of it is that of one instant, and not the mean since the row before.
    pub is_of_instants: bool,
    /// In `comparison.json`, what stands under its curves.
    pub key: &'static str,
    /// The values fall somewhere: no two of its frames are at strains that follow each other.
    pub turns_back: bool,
    /// The body that moves; and how, for a caption.
    pub body: Option<String>,
    /// How strain and stress are measured, a caption; empty where there is no stress.
    pub how: String,
    /// Length that is a strain of one, m.
    pub metres: Option<f64>,
    /// Of a shear the axis along it, and the one across which it grows.
    pub shear: Option<[usize; 2]>,
    /// Where bands are looked for, as shares of the strain that runs have in common or of the most that counts.
    pub interval: [f64; 2],
    /// The most strain that the shares are taken of; infinite of a body that presses and of a cell.
    pub interval_of_most: f64,
}

impl Drive {
    /// Refuses a series that lacks a column that the job's drive needs, or a number in it.
    pub fn of(run: &Run) -> Result<Self, Error> {
        run.whole("time")?;
        let drive = if run.scenario.contains_key("specimen") {
            Self::of_plates(run)?
        } else if let Some(drive) = Self::of_cell(run)? {
            drive
        } else if let Some(press) = Press::of(run) {
            press.drive(run)?
        } else {
            Self { words: "time".into(), values: run.whole("time")?.to_vec(), ..Self::default() }
        };
        Ok(Self { turns_back: drive.values.windows(2).any(|pair| pair[1] < pair[0]), ..drive })
    }

    /// Whether it is the plate of planar shear; other shears do not count.
    pub fn is_shear(&self) -> bool {
        self.key == "shear_stress"
    }

    fn strain(words: &str, values: Vec<f64>, stress: (&str, Vec<f64>)) -> Self {
        Self {
            measure: Measure::Strain,
            words: words.into(),
            values,
            stress: Some(Resistance { words: stress.0.into(), values: stress.1 }),
            key: "load_curve",
            interval: OF_PRESS,
            interval_of_most: f64::INFINITY,
            ..Self::default()
        }
    }

    /// The upper plate of planar shear.
    fn of_plates(run: &Run) -> Result<Self, Error> {
        let strain = run.whole("strain")?.to_vec();
        let stress = ("shear stress", run.whole("shear_stress")?.to_vec());
        Ok(Self {
            key: "shear_stress",
            how: "tangential force on the upper plate over its area, against its displacement over the specimen\u{2019}s width"
                .into(),
            metres: Some(run.needed("specimen.width")?),
            shear: Some([0, 1]),
            interval: OF_SHEAR,
            interval_of_most: SHEAR_END,
            ..Self::strain("horizontal strain", strain, stress)
        })
    }

    /// The largest component of a cell's velocity gradient: along an axis logarithmic strain, since the start of the run.
    fn of_cell(run: &Run) -> Result<Option<Self>, Error> {
        let Some(rows) = run.value("cell.velocity_gradient").and_then(Value::as_array) else { return Ok(None) };
        let entries = rows
            .iter()
            .enumerate()
            .flat_map(|(i, row)| numbers(Some(row)).into_iter().enumerate().map(move |(j, rate)| ([i, j], rate)));
        let largest = entries.reduce(|best, other| if other.1.abs() > best.1.abs() { other } else { best });
        let Some(([i, j], rate)) = largest.filter(|(_, rate)| *rate != 0.0) else { return Ok(None) };
        let column = |what: &str, [i, j]: [usize; 2]| run.whole(&format!("{what}_{}{}", AXES[i], AXES[j]));
        let (own, along) = (column("edge", [i, j])?, column("edge", [j, j])?);
        let deformed =
            |row: usize| if i == j { math::ln(own[row] / own[0]) } else { own[row] / along[row] - own[0] / along[0] };
        let (sign, first) = (rate.signum(), rate.abs() * run.column("time")[0]);
        let values = (0..own.len()).map(|row| first + sign * deformed(row)).collect();
        let stress = column("stress", [i, j])?.iter().map(|stress| sign * stress).collect();
        let words = if i == j { ["axial strain", "axial stress"] } else { ["shear strain", "shear stress"] };
        let of = [AXES[i], AXES[j]].concat();
        let how =
            format!("component {of} of the mean stress of the contacts, against that of the cell\u{2019}s strain");
        let shear = (i != j).then_some([i, j]);
        Ok(Some(Self { how, shear, is_of_instants: true, ..Self::strain(words[0], values, (words[1], stress)) }))
    }
}

/// A body that moves along a path.
#[derive(Clone, Debug, PartialEq)]
struct Press {
    name: String,
    /// The axis nearest to its way, and which way it goes along that: 1 or -1.
    axis: usize,
    sign: f64,
    /// What bears its force, m2, the length that its way is a strain of, m, and whether that is the material's; nothing where
    /// neither is known.
    bearing: Option<(f64, f64, bool)>,
    /// The axis across it, of a side of a mesh that goes along itself, or of a layer that goes along another.
    shears: Option<usize>,
}

/// Layers of glued grains that face each other, of which the other one rests: the axis across them, how far they are apart, m, and the area between them, m2,
/// where the cell has periods along the other axes.
fn facing(body: &Table, run: &Run) -> Option<(usize, f64, f64)> {
    let axes = run.dimension();
    let is_layer = |body: &Table| body.get("shape").and_then(Value::as_str) == Some("layer");
    let ends = |body: &Table| [numbers(body.get("lower")), numbers(body.get("upper"))];
    let rests = |body: &Table| !["path", "oscillation", "servo"].iter().any(|key| body.contains_key(*key));
    let others =
        run.tables("body").filter(|other| is_layer(other) && other.get("name") != body.get("name") && rests(other));
    let [lower, upper] = ends(body);
    let apart = others.filter(|_| is_layer(body)).map(ends).find_map(|[other_lower, other_upper]| {
        let gap = |axis: usize| f64::max(lower[axis] - other_upper[axis], other_lower[axis] - upper[axis]);
        (0..axes).map(|axis| (axis, gap(axis))).find(|(_, gap)| *gap > 0.0)
    });
    let (normal, gap) = apart?;
    let periodic = run.value("cell.periodic").and_then(Value::as_array);
    let is_periodic = |axis: usize| periodic.and_then(|all| all.get(axis)?.as_bool()).unwrap_or(false);
    let edge =
        |axis: usize| run.column(&format!("edge_{0}{0}", AXES[axis])).first().copied().filter(|_| is_periodic(axis));
    let across: Option<f64> = (0..axes).filter(|axis| *axis != normal).map(edge).product();
    let depth = if axes == 2 { run.number("cell.depth") } else { Some(1.0) };
    Some((normal, gap, across? * depth?))
}

impl Press {
    /// The first body of a job that moves: of boxes and discs, or else of planes, since a wall that moves beside a plate loads the
    /// far field.
    fn of(run: &Run) -> Option<Self> {
        let moving: Vec<Self> = run.tables("body").filter_map(|body| Self::of_body(body, run)).collect();
        let is_own = |body: &&Self| body.bearing.is_some_and(|(.., is_plane)| !is_plane);
        moving.iter().find(is_own).or(moving.first()).cloned()
    }

    fn of_body(body: &Table, run: &Run) -> Option<Self> {
        let axes = run.dimension();
        let path = body.get("path").and_then(Value::as_array)?;
        let velocities = path.iter().map(|point| numbers(point.get("velocity"))).filter(|of| of.len() == axes);
        let speed = |velocity: &[f64]| velocity.iter().map(|component| component * component).sum::<f64>();
        let fastest = velocities.max_by(|a, b| speed(a).total_cmp(&speed(b))).filter(|of| speed(of) > 0.0)?;
        let axis =
            (0..axes).reduce(|best, axis| if fastest[axis].abs() > fastest[best].abs() { axis } else { best })?;
        let (name, sign) = (body.get("name").and_then(Value::as_str)?.to_owned(), fastest[axis].signum());
        let across = |normal: usize| (normal != axis).then_some(normal);
        if let Some((normal, gap, area)) = facing(body, run) {
            return Some(Self { name, axis, sign, bearing: Some((area, gap, true)), shears: across(normal) });
        }
        let list = |key: &str| Some(numbers(body.get(key))).filter(|list| list.len() == axes);
        let extents = |ends: &[[f64; 2]]| ends.iter().map(|[lower, upper]| upper - lower).collect::<Vec<_>>();
        let own = match (list("lower").zip(list("upper")), body.get("radius").and_then(as_number)) {
            (Some((lower, upper)), _) => Some(lower.iter().zip(&upper).map(|(lower, upper)| upper - lower).collect()),
            (None, Some(radius)) if axes == 2 => Some(vec![2.0 * radius; 2]),
            _ => None,
        };
        let whole = material(run).map(|ends| extents(&ends));
        // One that covers all of the material presses on that, not on its own breadth.
        let covers = |own: &Vec<f64>| {
            whole.as_ref().is_some_and(|whole| (0..axes).all(|other| other == axis || own[other] >= whole[other]))
        };
        let own: Option<Vec<f64>> = own.filter(|own| !covers(own));
        let is_plane = own.is_none();
        let sizes = own.or(whole);
        let side = body.get("side").and_then(Value::as_str).unwrap_or_default();
        let normal = AXES.iter().position(|name| side.starts_with(name)).unwrap_or(axis);
        let depth = if axes == 2 { run.number("grid.depth") } else { Some(1.0) };
        let bearing = |(sizes, depth): (Vec<f64>, f64)| {
            let across = (0..axes).filter(|other| *other != normal).map(|other| sizes[other]);
            let area = across.clone().product::<f64>() * depth;
            (area, if is_plane { sizes[normal] } else { across.fold(f64::INFINITY, f64::min) }, is_plane)
        };
        Some(Self { name, axis, sign, bearing: sizes.zip(depth).map(bearing), shears: across(normal) })
    }

    fn column<'r>(&self, run: &'r Run, what: &str) -> Result<&'r [f64], Error> {
        let name = format!("{}_{what}_{}", self.name, AXES[self.axis]);
        run.whole(&name).map_err(|_| {
            let path = run.directory.join("series.csv");
            broken(
                &path,
                &format!("has no whole column `{name}`"),
                "Resume the run; it takes the file up where the checkpoint left it",
            )
        })
    }

    fn drive(&self, run: &Run) -> Result<Drive, Error> {
        let name = &self.name;
        let way = self.column(run, "displacement")?.iter().map(|way| self.sign * way);
        let Some((area, length, is_plane)) = self.bearing else {
            let words = format!("displacement of {name}");
            return Ok(Drive { measure: Measure::Length, words, values: way.collect(), ..Drive::default() });
        };
        let stress = self.column(run, "force")?.iter().map(|force| -self.sign * force / area).collect();
        let words = match (self.shears.is_some(), is_plane) {
            (true, _) => "shear strain",
            (false, true) => "axial strain",
            (false, false) => "displacement over breadth",
        };
        let what = if self.shears.is_some() { "shear stress" } else { "stress" };
        let over = if is_plane {
            ["the breadth of the material at the start", "the height of the material"]
        } else {
            ["its own breadth", "its own breadth"]
        };
        Ok(Drive {
            how: format!("force on {name} over {}, against its way over {}", over[0], over[1]),
            body: Some(name.clone()),
            metres: Some(length),
            shear: self.shears.map(|normal| [self.axis, normal]),
            ..Drive::strain(words, way.map(|way| way / length).collect(), (&format!("{what} on {name}"), stress))
        })
    }
}

/// Lower and upper ends of all regions along every axis, m.
pub fn material(run: &Run) -> Option<Vec<[f64; 2]>> {
    let axes = run.dimension();
    let mut ends = vec![[f64::INFINITY, f64::NEG_INFINITY]; axes];
    for region in run.tables("region") {
        let radius = region.get("radius").and_then(Value::as_float).unwrap_or(0.0);
        let corners = region.get("vertices").and_then(Value::as_array).into_iter().flatten();
        let places = ["lower", "upper", "centre"].map(|key| numbers(region.get(key)));
        for place in places.into_iter().chain(corners.map(|corner| numbers(Some(corner)))) {
            for (ends, at) in ends.iter_mut().zip(place) {
                *ends = [ends[0].min(at - radius), ends[1].max(at + radius)];
            }
        }
    }
    ends.iter().all(|[lower, upper]| upper > lower).then_some(ends)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::columns::Column;

    fn run(scenario: &str, columns: &[(&str, [f64; 2])]) -> Run {
        let column = |(name, values): &(&str, [f64; 2])| Column { name: (*name).to_owned(), values: values.to_vec() };
        Run { columns: columns.iter().map(column).collect(), ..Run::made(scenario) }
    }

    fn press(body: &str) -> Option<Press> {
        let rest = "[grid]\ndepth = 0.01\n[[region]]\nlower = [0.1, 0.0]\nupper = [0.2, 0.3]\n[[region]]\ncentre = [0.2, 0.1]\n\
                    radius = 0.05\n[[body]]\nname = \"base\"\nnormal = [0.0, 1.0]\n";
        Press::of(&run(&format!("{rest}[[body]]\nname = \"plate\"\n{body}"), &[]))
    }

    #[test]
    fn planes_press_on_the_breadth_of_the_material_and_boxes_on_their_own() {
        const PATH: &str = "path = [{time = 0.0, velocity = [0.0, 0.0]}, {time = 1.0, velocity = [0.0, -0.02]}]";
        let plane = press(&format!("normal = [0.0, -1.0]\n{PATH}")).unwrap();
        let (area, length, is_plane) = plane.bearing.unwrap();
        assert_eq!((plane.name.as_str(), plane.axis, plane.sign, length, is_plane), ("plate", 1, -1.0, 0.3, true));
        assert!((area - 0.0015).abs() < 1e-12);
        let own = |shape: &str| press(&format!("{shape}\n{PATH}")).unwrap().bearing.unwrap();
        let (area, length, is_plane) = own("lower = [0.1, 0.3]\nupper = [0.15, 0.4]");
        assert!(!is_plane && (length - 0.05).abs() < 1e-15 && (area - 5e-4).abs() < 1e-12);
        assert!((own("centre = [0.1, 0.3]\nradius = 0.01").1 - 0.02).abs() < 1e-15);
        // A plate that stands out on both sides presses on the material alone.
        let (area, length, is_plane) = own("lower = [0.0, 0.3]\nupper = [0.4, 0.4]");
        assert!(is_plane && length == 0.3 && (area - 0.0015).abs() < 1e-12);
        // To the right: what holds it pushes to the left.
        let sideways = press("path = [{time = 0.0, velocity = [0.5, 0.1]}]").unwrap();
        assert_eq!((sideways.axis, sideways.sign), (0, 1.0));
        assert_eq!(press("path = [{time = 0.0, velocity = [0.0, 0.0]}]"), None);
        assert_eq!(press(""), None);
    }

    #[test]
    fn a_cell_is_driven_by_the_largest_component_of_its_gradient() {
        let columns = [
            ("time", [1.0, 2.0]),
            ("edge_xy", [0.02, 0.04]),
            ("edge_yy", [2.0, 1.0]),
            ("stress_xy", [5.0, 6.0]),
            ("stress_yy", [-50.0, -60.0]),
        ];
        let of =
            |gradient: &str| Drive::of(&run(&format!("[cell]\nvelocity_gradient = {gradient}\n"), &columns)).unwrap();
        let shear = of("[[0.0, 0.01], [0.0, 0.0]]");
        assert!((shear.values[0] - 0.01).abs() < 1e-12 && (shear.values[1] - 0.04).abs() < 1e-12, "{shear:?}");
        assert_eq!((shear.words.as_str(), shear.stress.unwrap().values), ("shear strain", vec![5.0, 6.0]));
        let pressed = of("[[0.0, 0.0], [0.0, -0.5]]");
        assert!((pressed.values[1] - 0.5 - math::ln(2.0)).abs() < 1e-12, "{pressed:?}");
        assert_eq!(pressed.stress.unwrap().values, [50.0, 60.0]);
        assert_eq!(of("[[0.0, 0.0], [0.0, 0.0]]").measure, Measure::Time);
    }

    /// As the sides of a mesh do, whose curves theirs are held against.
    #[test]
    fn layers_that_face_each_other_shear_what_is_between() {
        let layer = |name: &str, from: f64, to: f64, path: &str| {
            format!(
                "[[body]]\nname = \"{name}\"\nshape = \"layer\"\nlower = [0.0, {from}]\nupper = [0.2, {to}]\n{path}\n"
            )
        };
        let of = |velocity: &str| {
            let path = format!("path = [{{time = 0.0, velocity = {velocity}}}]");
            let bodies = layer("low", 0.0, 0.1, "") + &layer("top", 0.5, 0.6, &path);
            let columns = [
                ("time", [1.0, 2.0]),
                ("edge_xx", [0.2, 0.2]),
                ("edge_yy", [0.6, 0.6]),
                ("top_displacement_x", [0.1, 0.2]),
                ("top_force_x", [-30.0, -60.0]),
                ("top_displacement_y", [-0.02, -0.04]),
                ("top_force_y", [3.0, 6.0]),
            ];
            let cell = "[cell]\nspace = \"plane\"\ndepth = 0.01\nperiodic = [true, false]\n";
            // Against a layer that moves too it has a way alone.
            let both = format!("{cell}{}{}", layer("low", 0.0, 0.1, &path), layer("top", 0.5, 0.6, &path));
            assert_eq!(Press::of(&run(&both, &columns)).unwrap().bearing, None);
            Drive::of(&run(&format!("{cell}{bodies}"), &columns)).unwrap()
        };
        let off = |found: &[f64], wanted: [f64; 2]| found.iter().zip(wanted).any(|(a, b)| (a / b - 1.0).abs() > 1e-12);
        let sheared = of("[0.1, 0.0]");
        assert_eq!((sheared.words.as_str(), sheared.metres, sheared.shear), ("shear strain", Some(0.4), Some([0, 1])));
        assert!(!off(&sheared.values, [0.25, 0.5]) && !off(&sheared.stress.unwrap().values, [15e3, 30e3]));
        let pressed = of("[0.0, -0.1]");
        assert_eq!(pressed.words, "axial strain");
        assert!(!off(&pressed.values, [0.05, 0.1]) && !off(&pressed.stress.unwrap().values, [1500.0, 3000.0]));
    }

    #[test]
    fn a_body_in_a_cell_has_a_way_alone() {
        let body = "[cell]\n[[body]]\nname = \"lid\"\npath = [{time = 0.0, velocity = [0.0, -1.0]}]\n";
        let drive = Drive::of(&run(body, &[("time", [1.0, 2.0]), ("lid_displacement_y", [-0.1, -0.2])])).unwrap();
        assert_eq!(
            (drive.measure, drive.words.as_str(), drive.values),
            (Measure::Length, "displacement of lid", vec![0.1, 0.2])
        );
    }
}

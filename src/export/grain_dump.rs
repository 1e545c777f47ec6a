//! Grains of a run's frames as a LAMMPS text dump, which OVITO and others read: one section a frame.
//!
//! ```text
//! ITEM: UNITS               si, once
//! ITEM: TIME                of the frame, s
//! ITEM: TIMESTEP            steps done
//! ITEM: NUMBER OF ATOMS
//! ITEM: BOX BOUNDS ...      the cell; with tilts where it leans, by its edges ("abc origin") where these have turned
//! ITEM: ATOMS id type x y z vx vy vz omegax omegay omegaz radius mass coordination stress_xx ...
//! ```
//!
//! SI units, 17 significant digits, in the order of ids. Atoms count from 1, grains from 0; type 1 moves by itself, type 2
//! is glued to a body. Places are those inside the cell; velocities (m/s, rad/s) are those of half a step before, as in
//! frames; mass is in kg, stress in Pa, tension positive. A plane is a slab as thick as its depth, with the discs in its
//! middle. Borders are p where the cell is periodic, f elsewhere.

use std::fmt::Write;
use std::io::BufWriter;
use std::path::Path;

use scree_io::frames::{self, Frame};
use scree_io::{Column, Values};

use crate::base::error::Error;
use crate::base::space::{Plane, Solid, Space};
use crate::base::units::in_short;
use crate::export::refuse_points_alone;
use crate::job::{Assembly, Job};
use crate::observe::frame::Kind;
use crate::run::results::Aside;
use crate::store::checkpoint::which;

/// Which frames are wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Moment {
    /// The last frame of the run.
    Last,
    /// That of a time, s.
    At(f64),
    /// Every frame, in the order of time.
    All,
}

/// Writes the grains of a run into `file` and says in words what is there.
pub fn write(dir: &Path, file: &Path, moment: Moment) -> Result<String, Error> {
    let job = Job::load(&dir.join("scenario.toml"), &[])?;
    refuse_points_alone(&job, dir)?;
    let path = dir.join("frames.vtkhdf");
    let unreadable = |error: scree_io::Error| Error::User(error.to_string());
    let times = frames::times(&path).map_err(unreadable)?;
    let failed = |error: std::io::Error| Error::Run(format!("{}: {error}", file.display()));
    let chosen = chosen(&times, moment, (dir, job.step()))?;
    let aside = Aside::of(file);
    let mut to = BufWriter::new(std::fs::File::create(aside.partial()).map_err(failed)?);
    let mut written = Vec::new();
    for number in chosen {
        let frame = frames::read_frame(&path, number).map_err(unreadable)?;
        if let Some(text) = section(&frame, &job, written.is_empty())? {
            std::io::Write::write_all(&mut to, text.as_bytes()).map_err(failed)?;
            written.push(frame.time);
        }
    }
    std::io::Write::flush(&mut to).map_err(failed)?;
    if !written.is_empty() {
        aside.name()?;
    }
    match written[..] {
        [] => Err(Error::User(format!(
            "{}: there are no grains in these frames; a hybrid run has them after enrichment only",
            dir.display()
        ))),
        [time] => Ok(format!("The grains at {} s are in {}\n", in_short(time), file.display())),
        [first, .., last] => {
            let [first, last] = [first, last].map(in_short);
            let count = written.len();
            Ok(format!("The grains of {count} frames from {first} s to {last} s are in {}\n", file.display()))
        }
    }
}

/// Numbers of the frames that are wanted; `dt` is the time step, s, to half of which a time must be met.
pub(super) fn chosen(times: &[f64], moment: Moment, (dir, dt): (&Path, f64)) -> Result<Vec<usize>, Error> {
    if times.is_empty() {
        return Err(Error::User(format!("{}: there are no frames yet", dir.display())));
    }
    match moment {
        Moment::All => Ok((0..times.len()).collect()),
        Moment::Last => Ok(vec![times.len() - 1]),
        // At an enrichment there are two of one time; the later one is what the run went on with.
        Moment::At(at) => match times.iter().rposition(|time| (time - at).abs() <= 0.5 * dt) {
            Some(found) => Ok(vec![found]),
            None => Err(Error::User(format!(
                "--at {at} s: {} has no frame of that time. {} `output.frame_interval` of the job says which are written.",
                dir.display(),
                which(times, at)
            ))),
        },
    }
}

/// Columns of a frame by name.
struct Fields<'a>(&'a Frame);

impl<'a> Fields<'a> {
    fn find(&self, columns: &'a [Column], name: &str) -> Result<&'a Column, Error> {
        columns.iter().find(|column| column.name == name).ok_or_else(|| {
            Error::User(format!("frames.vtkhdf has no `{name}`: an older scree has written it, and can export it"))
        })
    }

    fn numbers(&self, columns: &'a [Column], name: &str) -> Result<&'a [f64], Error> {
        match &self.find(columns, name)?.values {
            Values::F64(values) => Ok(values),
            _ => Err(Error::User(format!("frames.vtkhdf: `{name}` is not what it should be"))),
        }
    }

    fn row(&self, name: &str) -> Result<&'a [f64], Error> {
        self.numbers(&self.0.fields, name)
    }

    fn whole<const N: usize>(&self, name: &str) -> Result<[f64; N], Error> {
        let values = self.numbers(&self.0.whole, name)?;
        values.try_into().map_err(|_| Error::User(format!("frames.vtkhdf: `{name}` is not what it should be")))
    }

    fn counts(&self, name: &str) -> Result<&'a [i64], Error> {
        match &self.find(&self.0.fields, name)?.values {
            Values::I64(values) => Ok(values),
            _ => Err(Error::User(format!("frames.vtkhdf: `{name}` is not what it should be"))),
        }
    }
}

const STRESSES: [&str; 6] = ["xx", "yy", "xy", "zz", "yz", "xz"];

/// A frame's section; none where it has no grains.
fn section(frame: &Frame, job: &Job, first: bool) -> Result<Option<String>, Error> {
    let fields = Fields(frame);
    let (kinds, ids, coordination) = (fields.counts("kind")?, fields.counts("id")?, fields.counts("coordination")?);
    let of_grains = [Kind::Grain as i64, Kind::Glued as i64];
    let mut rows: Vec<usize> = (0..frame.rows()).filter(|row| of_grains.contains(&kinds[*row])).collect();
    if rows.is_empty() {
        return Ok(None);
    }
    rows.sort_unstable_by_key(|row| ids[*row]);
    let [velocity, spin, radius, stress] =
        [fields.row("velocity")?, fields.row("spin")?, fields.row("radius")?, fields.row("stress")?];
    let grains = job.grains().expect("a job that moves grains has some");
    let width = stress.len() / frame.rows();
    let names: String = STRESSES[..width].iter().map(|name| format!(" stress_{name}")).collect();
    let mut text = String::new();
    if first {
        text.push_str("ITEM: UNITS\nsi\n");
    }
    let steps = (frame.time / job.step()).round();
    let bounds = bounds(&fields.whole("cell_corner")?, &fields.whole("cell_edges")?, &fields.whole("cell_periodic")?);
    writeln!(
        text,
        "ITEM: TIME\n{}\nITEM: TIMESTEP\n{steps:.0}\nITEM: NUMBER OF ATOMS\n{}\n{bounds}ITEM: ATOMS id type x y z vx vy vz omegax omegay omegaz radius mass coordination{names}",
        frame.time,
        rows.len(),
    )
    .expect("text takes what is written");
    for row in rows {
        let kind = if kinds[row] == Kind::Glued as i64 { 2 } else { 1 };
        write!(text, "{} {kind}", ids[row] + 1).expect("text takes what is written");
        numbers(&mut text, &frame.positions[row]);
        numbers(&mut text, &velocity[3 * row..3 * row + 3]);
        numbers(&mut text, &spin[3 * row..3 * row + 3]);
        numbers(&mut text, &[radius[row], mass(&grains, radius[row])]);
        write!(text, " {}", coordination[row]).expect("text takes what is written");
        numbers(&mut text, &stress[width * row..width * (row + 1)]);
        text.push('\n');
    }
    Ok(Some(text))
}

fn numbers(text: &mut String, numbers: &[f64]) {
    for number in numbers {
        write!(text, " {number:.16e}").expect("text takes what is written");
    }
}

/// kg.
fn mass(grains: &Assembly, radius: f64) -> f64 {
    let volume = match grains.cell.dimension {
        2 => Plane::grain_volume(radius, grains.cell.depth),
        _ => Solid::grain_volume(radius, grains.cell.depth),
    };
    grains.matter.density * volume
}

/// The box. LAMMPS wants the first edge along x and the second in the plane of x and y, and gives the bounds of what leans as
/// those of all its corners; a box with other edges is written by them.
fn bounds(corner: &[f64; 3], edges: &[f64; 9], periodic: &[f64; 3]) -> String {
    let edge = |row: usize, column: usize| edges[3 * column + row];
    let borders: Vec<&str> = periodic.iter().map(|is| if *is != 0.0 { "pp" } else { "ff" }).collect();
    let borders = borders.join(" ");
    let mut text = String::new();
    let mut line = |values: &[f64]| {
        let words: Vec<String> = values.iter().map(|value| format!("{value:.16e}")).collect();
        writeln!(text, "{}", words.join(" ")).expect("text takes what is written");
    };
    if (0..3).any(|row| (0..row).any(|column| edge(row, column) != 0.0)) {
        for (column, origin) in corner.iter().enumerate() {
            line(&[edge(0, column), edge(1, column), edge(2, column), *origin]);
        }
        return format!("ITEM: BOX BOUNDS abc origin {borders}\n{text}");
    }
    let upper: [f64; 3] = std::array::from_fn(|axis| corner[axis] + edge(axis, axis));
    let [xy, xz, yz] = [edge(0, 1), edge(0, 2), edge(1, 2)];
    if [xy, xz, yz] == [0.0; 3] {
        (0..3).for_each(|axis| line(&[corner[axis], upper[axis]]));
        return format!("ITEM: BOX BOUNDS {borders}\n{text}");
    }
    let least = |ways: &[f64]| ways.iter().copied().fold(0.0, f64::min);
    let most = |ways: &[f64]| ways.iter().copied().fold(0.0, f64::max);
    let ways = [xy, xz, xy + xz];
    line(&[corner[0] + least(&ways), upper[0] + most(&ways), xy]);
    line(&[corner[1] + least(&[yz]), upper[1] + most(&[yz]), xz]);
    line(&[corner[2], upper[2], yz]);
    format!("ITEM: BOX BOUNDS xy xz yz {borders}\n{text}")
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNER: [f64; 3] = [1.0, 2.0, -0.5];

    #[test]
    fn bounds_of_a_leaning_box_are_those_of_its_corners() {
        let upright = bounds(&CORNER, &[4.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 1.0], &[1.0, 1.0, 0.0]);
        assert_eq!(
            upright,
            "ITEM: BOX BOUNDS pp pp ff\n1.0000000000000000e0 5.0000000000000000e0\n2.0000000000000000e0 5.0000000000000000e0\n-5.0000000000000000e-1 5.0000000000000000e-1\n"
        );
        let leaning = bounds(&CORNER, &[4.0, 0.0, 0.0, -1.0, 3.0, 0.0, 0.5, 0.25, 1.0], &[1.0; 3]);
        let rows: Vec<Vec<f64>> =
            leaning.lines().skip(1).map(|line| line.split(' ').map(|word| word.parse().unwrap()).collect()).collect();
        assert!(leaning.starts_with("ITEM: BOX BOUNDS xy xz yz pp pp pp\n"), "{leaning}");
        assert_eq!(rows, [[0.0, 5.5, -1.0], [2.0, 5.25, 0.5], [-0.5, 0.5, 0.25]]);
    }

    #[test]
    fn a_box_that_has_turned_is_written_by_its_edges() {
        let turned = bounds(&CORNER, &[4.0, 1.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 1.0], &[0.0; 3]);
        let first = turned.lines().nth(1).unwrap();
        assert!(turned.starts_with("ITEM: BOX BOUNDS abc origin ff ff ff\n"), "{turned}");
        assert_eq!(first, "4.0000000000000000e0 1.0000000000000000e0 0.0000000000000000e0 1.0000000000000000e0");
    }

    #[test]
    fn a_time_without_a_frame_is_refused_with_those_that_there_are() {
        let dir = (Path::new("runs/one"), 1e-3);
        let times = [0.0, 0.1, 0.2, 0.2];
        assert_eq!(chosen(&times, Moment::At(0.1004), dir).unwrap(), [1]);
        assert_eq!(chosen(&times, Moment::At(0.0), dir).unwrap(), [0]);
        assert_eq!(chosen(&times, Moment::At(0.2), dir).unwrap(), [3]);
        assert_eq!(chosen(&times, Moment::All, dir).unwrap(), [0, 1, 2, 3]);
        assert_eq!(chosen(&times, Moment::Last, dir).unwrap(), [3]);
        for at in [-0.06, 0.14, 0.24, 7.0] {
            let words = chosen(&times, Moment::At(at), dir).unwrap_err().to_string();
            assert!(words.contains(&format!("--at {at} s: ")) && words.contains("There are 0, 0.1, 0.2"), "{words}");
        }
    }
}

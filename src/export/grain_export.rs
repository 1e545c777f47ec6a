//! Grains of a state as text for other programs: comma-separated values, or where the name ends in `data` or `lmp` a LAMMPS
//! data file, and contacts with their memories. Numbers carry 17 significant digits and read back to the same bits.
//! Velocities are those of half a step before the time of the positions, as the state has them, or of that time.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use scree_io::column::{State, Table, Values};
use scree_partition::Solo;

use crate::base::error::Error;
use crate::base::ids::GrainId;
use crate::base::math::PI;
use crate::base::record::Cargo;
use crate::base::space::{Linear, Space};
use crate::dem::cell::Cell;
use crate::dem::grains::{GrainRow, body_partner};
use crate::domain::step::full_step::{FullStep, full_step};
use crate::export::refuse_points_alone;
use crate::job::{Job, Method};
use crate::mpm::membrane::Vertex;
use crate::observe::contact_frame;
use crate::prepare::grain_file::csv::{FORCES, TIME, header, header_of_contacts};
use crate::prepare::grain_file::is_lammps;
use crate::run::experiment::Setup;
use crate::run::folder::scenario_file;
use crate::run::results;
use crate::run::start::{ForAnySetup, with_setup_of, world_of};
use crate::store::checkpoint::{progress_of, scenario_of};
use crate::store::tables;

/// What is written of a grain beside its place and its size: by default its velocities as they are in the state, half a
/// step before the positions, with which a run goes on as if it had not been interrupted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// Velocities of the time of the positions.
    pub velocities_now: bool,
    /// Forces and torques of its contacts.
    pub forces: bool,
}

/// Writes the grains of a state in the format that the file's name asks for.
pub fn write(state: &State, dir: &Path, file: &Path, wanted: Wanted) -> Result<(), Error> {
    let is_csv = file.extension().is_some_and(|extension| extension == "csv");
    if !is_csv && !is_lammps(file) {
        return Err(Error::User(format!(
            "{}: the name does not tell the format. End it in .csv for comma-separated values, or in .data or .lmp for a LAMMPS data file.",
            file.display()
        )));
    }
    if wanted.forces && !is_csv {
        return Err(Error::User(format!(
            "{}: LAMMPS data files have no room for forces. Write .csv, or leave --forces out.",
            file.display()
        )));
    }
    let job = job_of(state, dir)?;
    let exchanges_seldom =
        job.as_shear().is_some_and(|shear| shear.method == Method::Hybrid && shear.coupling.interval > 1);
    let is_pushed = exchanges_seldom || (job.continuum().is_some() && job.plates().is_none());
    if is_pushed && wanted != Wanted::default() {
        return Err(Error::User(format!(
            "{}: nodes push grains that share them with points, so that full steps of these are known in the next step only. Leave --velocities now and --forces out; contacts.vtkhdf has forces where output.contact_frames = true.",
            dir.display()
        )));
    }
    let time = progress_of(state)?.step as f64 * job.step();
    save(file, &with_setup_of(&job, Export { state, dir, is_csv, wanted, time })?)
}

/// A state on its way to text.
struct Export<'a> {
    state: &'a State,
    dir: &'a Path,
    is_csv: bool,
    wanted: Wanted,
    /// Of the positions, s.
    time: f64,
}

impl ForAnySetup<String> for Export<'_> {
    fn with<J: Setup>(self, job: &J) -> Result<String, Error> {
        self.text::<J::Space>(cell_of(self.state, job)?, || {
            full_step(world_of(job, Some(self.state.clone()), &Solo)?.0)
        })
    }
}

impl Export<'_> {
    /// `now`: the full step of the state, which is reckoned only where it is wanted.
    fn text<S: Space>(
        &self,
        mut cell: Cell<S>,
        now: impl FnOnce() -> Result<FullStep<S>, Error>,
    ) -> Result<String, Error> {
        let mut grains: Vec<GrainRow<S>> = tables::rows(self.state, "grains", &GrainRow::blank())?;
        if grains.is_empty() {
            return Err(Error::User(format!(
                "{}: this state has no grains; a hybrid run has them after enrichment only",
                self.dir.display()
            )));
        }
        grains.sort_unstable_by_key(|grain| grain.cold.id);
        let now = if self.wanted == Wanted::default() { None } else { Some(now()?) };
        if let (true, Some(now)) = (self.wanted.velocities_now, &now) {
            cell.rate = now.rate;
            for (grain, now) in grains.iter_mut().zip(&now.grains) {
                (grain.hot.velocity, grain.hot.spin) = (now.velocity, now.spin);
            }
        }
        for grain in &mut grains {
            cell.wrap(&mut grain.hot.position, &mut grain.hot.velocity);
        }
        match self.is_csv {
            true => Ok(csv(&grains, now.as_ref().filter(|_| self.wanted.forces), self.time)),
            false => data(&grains, &cell, self.time),
        }
    }
}

/// Writes the contacts of a state: the two grains, the lower id first, or a grain and a body by its name, the forces across and along
/// the contact, the memory of the contact law word by word, and the time.
pub fn write_contacts(state: &State, dir: &Path, file: &Path) -> Result<(), Error> {
    let job = job_of(state, dir)?;
    let time = progress_of(state)?.step as f64 * job.step();
    let law = job.grains().expect("a job that moves grains has some").contact.law();
    let bodies: Vec<String> = job.bodies().into_iter().map(|body| body.name.clone()).collect();
    let missing = || Error::User(format!("{}: this state has no contacts", dir.display()));
    let table = state.tables.iter().find(|table| table.name == "contacts").ok_or_else(missing)?;
    let forces = with_setup_of(&job, ForcesOf { state })?;
    save(file, &contacts(table, (law, &bodies), (&forces, time)).ok_or_else(missing)?)
}

/// Forces of contacts, by their partners; nothing of those that bear none.
type Forces = BTreeMap<[GrainId; 2], [f64; 2]>;

/// Looks at the forces of a state's contacts.
struct ForcesOf<'a> {
    state: &'a State,
}

impl ForAnySetup<Forces> for ForcesOf<'_> {
    fn with<J: Setup>(self, job: &J) -> Result<Forces, Error> {
        let (mut world, _) = world_of(job, Some(self.state.clone()), &Solo)?;
        Ok(contact_frame::forces(&mut world))
    }
}

/// The job of a state that may have grains.
fn job_of(state: &State, dir: &Path) -> Result<Job, Error> {
    let job = Job::parse(&scenario_of(state)?, &scenario_file(dir).display().to_string(), &[])?;
    refuse_points_alone(&job, dir)?;
    Ok(job)
}

fn save(file: &Path, text: &str) -> Result<(), Error> {
    results::replace(file, text.as_bytes())
}

/// The cell as the state left it.
fn cell_of<J: Setup>(state: &State, job: &J) -> Result<Cell<J::Space>, Error> {
    let vertices = match state.tables.iter().any(|table| table.name == "membranes") {
        true => tables::rows(state, "membranes", &Vertex::blank())?,
        false => Vec::new(),
    };
    let mut cell = job.drawn(&progress_of(state)?, vertices)?.cell;
    if let [moved] = &tables::rows(state, "cell", &cell)?[..] {
        cell.take_motion_of(moved);
    }
    Ok(cell)
}

/// What follows where forces are written as well.
fn header_of_forces<S: Space>() -> &'static str {
    match S::DIMENSION {
        2 => ",fx,fy,torque",
        _ => ",fx,fy,fz,tx,ty,tz",
    }
}

/// `forces`: the full step whose forces are written.
fn csv<S: Space>(grains: &[GrainRow<S>], forces: Option<&FullStep<S>>, time: f64) -> String {
    let mut text = String::from(header::<S>());
    text.push_str(forces.map_or("", |_| header_of_forces::<S>()));
    text.push_str(&format!(",{TIME}\n"));
    for (at, grain) in grains.iter().enumerate() {
        let hot = &grain.hot;
        let numbers = components(&hot.position).chain([hot.radius]);
        let numbers = numbers.chain(components(&hot.velocity)).chain(components(&hot.spin));
        let load = forces.map(|now| &now.grains[at]);
        let load = load.into_iter().flat_map(|now| components(&now.force).chain(components(&now.torque)));
        push(&mut text, grain.cold.id.0, ',', numbers.chain(load).chain([time]));
    }
    text
}

fn components<V: Linear>(vector: &V) -> impl Iterator<Item = f64> {
    (0..V::COMPONENTS).map(|axis| vector[axis])
}

/// One line: what names the row, then its numbers.
fn push(text: &mut String, name: impl std::fmt::Display, between: char, numbers: impl Iterator<Item = f64>) {
    write!(text, "{name}").expect("text takes what is written");
    for number in numbers {
        write!(text, "{between}{number:.16e}").expect("text takes what is written");
    }
    text.push('\n');
}

/// Atom style sphere. Atoms count from 1, grains from 0. Type 1 moves by itself, type 2 + n is glued to body n. LAMMPS takes
/// the density of a data file as that of spheres; for discs it is the one that gives their mass.
fn data<S: Space>(grains: &[GrainRow<S>], cell: &Cell<S>, time: f64) -> Result<String, Error> {
    let kind = |grain: &GrainRow<S>| u64::from(grain.cold.mover.code()) + 1;
    let kinds = grains.iter().map(kind).max().unwrap_or(1);
    let mut text = format!(
        "Grains of scree at time {time:?} s, atom style sphere, units si\n\n{} atoms\n{kinds} atom types\n\n{}\nAtoms # sphere\n\n",
        grains.len(),
        bounds(cell)?
    );
    for grain in grains {
        let hot = &grain.hot;
        let density = hot.mass / (4.0 / 3.0 * PI * hot.radius * hot.radius * hot.radius);
        let numbers = [2.0 * hot.radius, density].into_iter().chain(in_space(&hot.position));
        push(&mut text, format!("{} {}", grain.cold.id.0 + 1, kind(grain)), ' ', numbers);
    }
    text.push_str("\nVelocities\n\n");
    for grain in grains {
        let mut spin = [0.0; 3];
        for axis in 0..S::Spin::COMPONENTS {
            spin[3 - S::Spin::COMPONENTS + axis] = grain.hot.spin[axis];
        }
        push(&mut text, grain.cold.id.0 + 1, ' ', in_space(&grain.hot.velocity).into_iter().chain(spin));
    }
    Ok(text)
}

fn in_space<V: Linear>(vector: &V) -> [f64; 3] {
    std::array::from_fn(|axis| if axis < V::COMPONENTS { vector[axis] } else { 0.0 })
}

/// The box, with tilts where it leans. LAMMPS wants the first edge along x and the second in the plane of x and y; discs lie
/// in the middle of a box as thick as their plane wants.
fn bounds<S: Space>(cell: &Cell<S>) -> Result<String, Error> {
    let edge = |row: usize, column: usize| match row.max(column) < S::DIMENSION {
        true => cell.edges[column * S::DIMENSION + row],
        false => 0.0,
    };
    if (0..3).any(|row| (0..row).any(|column| edge(row, column) != 0.0)) {
        return Err(Error::User(
            "the edges of this cell have turned: the first is not along x, or the second not in the plane of x and y, which LAMMPS data files need. Write .csv instead.".into(),
        ));
    }
    let mut text = String::new();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let (lower, upper) = match axis < S::DIMENSION {
            true => (cell.corner[axis], cell.corner[axis] + edge(axis, axis)),
            false => (-0.5, 0.5),
        };
        writeln!(text, "{lower:.16e} {upper:.16e} {name}lo {name}hi").expect("text takes what is written");
    }
    let tilts = [edge(0, 1), edge(0, 2), edge(1, 2)];
    if tilts != [0.0; 3] {
        writeln!(text, "{:.16e} {:.16e} {:.16e} xy xz yz", tilts[0], tilts[1], tilts[2])
            .expect("text takes what is written");
    }
    Ok(text)
}

fn contacts(table: &Table, (law, bodies): (&str, &[String]), (forces, time): (&Forces, f64)) -> Option<String> {
    let column = |name: &str| table.columns.iter().find(|column| column.name == name);
    let (lower, higher, memory) = (column("lower")?, column("higher")?, column("memory")?);
    let (Values::U64(lower), Values::U64(higher), Values::F64(words)) = (&lower.values, &higher.values, &memory.values)
    else {
        return None;
    };
    let names = header_of_contacts(law, memory.width).replacen("higher", &format!("higher,{}", FORCES.join(",")), 1);
    let mut text = format!("{names},{TIME}\n");
    // What touches since the last evaluation bears force and remembers nothing yet.
    let mut rows: BTreeMap<[GrainId; 2], ([f64; 2], Vec<f64>)> =
        forces.iter().map(|(pair, forces)| (*pair, (*forces, vec![0.0; memory.width]))).collect();
    for ((lower, higher), words) in lower.iter().zip(higher).zip(words.chunks_exact(memory.width)) {
        rows.entry([GrainId(*lower), GrainId(*higher)]).or_default().1 = words.to_vec();
    }
    for ([lower, higher], (forces, words)) in rows {
        let body = bodies.iter().enumerate().find(|(at, _)| body_partner(*at as u8) == higher);
        let partner = body.map_or_else(|| higher.0.to_string(), |(_, name)| name.clone());
        push(&mut text, format!("{},{partner}", lower.0), ',', forces.into_iter().chain(words).chain([time]));
    }
    Some(text)
}

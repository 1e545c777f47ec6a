//! Rows as tables: what checkpoints and cached packings are made of.

use std::sync::Arc;

use scree_io::column::{Column, State, Table, Values};
use scree_partition::Transport;

use crate::base::error::Error;
use crate::base::ids::GrainId;
use crate::base::numbers::Numbers;
use crate::base::record::{Cargo, Record, Visitor, from_table, refuse_torn, to_table};
use crate::base::space::Space;
use crate::dem::grains::{ContactRow, GrainRow, PenaltySpring, PenaltySpringRow, is_body};
use crate::domain::transfer;
use crate::law::contact::Memory;
use crate::mpm::points::{MEMORY, PLASTIC_WORK, Point, VOLUMETRIC};
use crate::mpm::stress::MemoryColumns;
use crate::mpm::volumetric::Volumetric;
use crate::rve::rest::Arrangement;
use crate::rve::rows::{packed, parted};
use crate::rve::{Packing, Packings, Resting, RveRow};

/// Whether a contact stands in the table with grain `id`: with the lower of two ids, and a body's is
/// above all grains'.
pub fn stands_with(id: GrainId, partner: GrainId) -> bool {
    partner > id
}

/// What tables of grains and of their contacts are called: those of a world, and those that have turned into points.
pub const GRAINS: [&str; 2] = ["grains", "contacts"];
/// See [`crate::couple::kept`].
pub const KEPT_GRAINS: [&str; 2] = ["kept_grains", "kept_contacts"];

/// Tables `grains` and `contacts` of rows in canonical order, or of a piece of them, under a law with so many words of memory. A
/// contact stands once.
pub fn of_grains<S: Space>(rows: &mut [GrainRow<S>], memory_words: usize) -> [Table; 2] {
    of_grains_named(GRAINS, rows, memory_words)
}

/// The same by other names.
pub fn of_grains_named<S: Space>(
    [grains, touching]: [&str; 2],
    rows: &mut [GrainRow<S>],
    memory_words: usize,
) -> [Table; 2] {
    let mut contacts: Vec<ContactRow> = Vec::new();
    for row in rows.iter() {
        let lower = row.cold.id;
        let ours = row.contacts.iter().filter(|(partner, _)| stands_with(lower, *partner));
        contacts.extend(ours.map(|(higher, memory)| ContactRow { lower, higher: *higher, memory: *memory }));
    }
    let mut blank = blank_contact(memory_words);
    [to_table(grains, rows, &mut GrainRow::blank()), to_table(touching, &mut contacts, &mut blank)]
}

/// Table `ties` of the same rows: penalty springs of those that have some.
pub fn of_penalty_springs<S: Space>(rows: &[GrainRow<S>]) -> Table {
    let tied = rows.iter().filter(|row| row.spring != PenaltySpring::loose());
    let mut springs: Vec<PenaltySpringRow<S>> =
        tied.map(|row| PenaltySpringRow { grain: row.cold.id, spring: row.spring }).collect();
    to_table("ties", &mut springs, &mut blank_tie())
}

fn blank_contact(memory_words: usize) -> ContactRow {
    ContactRow { lower: GrainId(0), higher: GrainId(0), memory: Memory::blank(memory_words) }
}

fn blank_tie<S: Space>() -> PenaltySpringRow<S> {
    PenaltySpringRow { grain: GrainId(0), spring: PenaltySpring::loose() }
}

/// Table `points` of rows in canonical order, or of a piece of them, with what the law remembers in columns of its own. A law that
/// remembers nothing dissipates nothing either.
pub fn of_points<S: Space>(rows: &mut [Point<S>], memory: &[(String, usize)]) -> Table {
    let mut table = to_table("points", rows, &mut Point::blank());
    let at = table.columns.iter().position(|column| column.name == MEMORY).expect("points have a memory");
    let words = table.columns.remove(at);
    let words = numbers_of(&words);
    let mut first = 0;
    for (number, (name, width)) in memory.iter().enumerate() {
        let of_row = |row: &[f64]| row[first..first + width].to_vec();
        let values = words.chunks(S::PointMemory::WIDTH).flat_map(of_row).collect();
        let column = Column { name: name.clone(), width: *width, values: Values::F64(values) };
        table.columns.insert(at + number, column);
        first += width;
    }
    if memory.is_empty() {
        table.columns.retain(|column| column.name != PLASTIC_WORK);
    }
    table
}

/// Rows of the table that [`of_points`] made, and the columns that their law has. Points of states that were written before what they
/// dissipate was counted begin at nothing.
pub fn to_points<S: Space>(state: &mut State) -> Result<(Vec<Point<S>>, MemoryColumns), Error> {
    let Some(table) = state.tables.iter_mut().find(|table| table.name == "points") else {
        return Err(Error::User("there is no table `points`".to_string()));
    };
    refuse_torn(table).map_err(Error::User)?;
    let place = |name: &str| place_of(table, name).filter(|at| table.columns[*at].width > 0);
    // What is missing here is told as of any other table.
    let (first, last) = match (place("affine"), place("window")) {
        (Some(first), Some(last)) if first < last => (first + 1, last),
        _ => return take(state, "points", &Point::blank()).map(|rows| (rows, MemoryColumns::new())),
    };
    let mut own: Vec<Column> = table.columns.drain(first..last).collect();
    let dissipated = own.iter().position(|column| column.name == PLASTIC_WORK).map(|at| own.remove(at));
    let memory: MemoryColumns = own.iter().map(|column| (column.name.clone(), column.width)).collect();
    let width = memory.iter().fold(0, |sum: usize, (_, width)| sum.saturating_add(*width));
    if width > S::PointMemory::WIDTH {
        return Err(Error::User(format!(
            "points of the state remember {width} numbers, and {} are the most that a law does",
            S::PointMemory::WIDTH
        )));
    }
    if let Some(column) = own.iter().find(|column| !matches!(column.values, Values::F64(_))) {
        return Err(Error::User(format!("column `{}` of table `points` has another type", column.name)));
    }
    let mut words = vec![0.0; table.rows * S::PointMemory::WIDTH];
    for (row, words) in words.chunks_mut(S::PointMemory::WIDTH).enumerate() {
        let values = own.iter().flat_map(|column| &numbers_of(column)[row * column.width..(row + 1) * column.width]);
        words.iter_mut().zip(values).for_each(|(word, value)| *word = *value);
    }
    let nothing = || Column { name: PLASTIC_WORK.into(), width: 1, values: Values::F64(vec![0.0; table.rows]) };
    table.columns.push(dissipated.unwrap_or_else(nothing));
    // States that were written before volume strain was averaged begin to average.
    if place_of(table, VOLUMETRIC).is_none() {
        let width = Volumetric::WIDTH;
        table.columns.push(Column {
            name: VOLUMETRIC.into(),
            width,
            values: Values::F64(vec![0.0; table.rows * width]),
        });
    }
    table.columns.push(Column { name: MEMORY.into(), width: S::PointMemory::WIDTH, values: Values::F64(words) });
    take(state, "points", &Point::blank()).map(|rows| (rows, memory))
}

/// A grain of a packing that RVEs begin from.
#[derive(Clone, Debug, Default)]
struct PackedGrain {
    packing: u64,
    radius: f64,
    mass: f64,
    /// As it was laid, m, and the edges of the cell; zeros where a former program kept none.
    place: [f64; 3],
    edges: [f64; 9],
}

impl Record for PackedGrain {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.u64("packing", &mut self.packing);
        visitor.f64s("radius", std::slice::from_mut(&mut self.radius));
        visitor.f64s("mass", std::slice::from_mut(&mut self.mass));
        visitor.later_f64s("place", &mut self.place);
        visitor.later_f64s("cell_edges", &mut self.edges);
    }
}

impl Cargo for PackedGrain {
    fn blank() -> Self {
        Self::default()
    }
}

const RVE_PACKINGS: &str = "rve_packings";

fn rows_of(packings: &[Packing]) -> Vec<PackedGrain> {
    let of = |(number, packing): (u64, &Packing)| {
        let laid = packing.laid.as_deref();
        let row = |(grain, [radius, mass]): (usize, &[f64; 2])| PackedGrain {
            packing: number,
            radius: *radius,
            mass: *mass,
            place: laid.map_or([0.0; 3], |laid| laid.places[grain]),
            edges: laid.map_or([0.0; 9], |laid| laid.edges),
        };
        packing.grains.iter().enumerate().map(row).collect::<Vec<_>>()
    };
    (0..).zip(packings).flat_map(of).collect()
}

fn packings_of(rows: &[PackedGrain]) -> Packings {
    let together = rows.chunk_by(|a, b| a.packing == b.packing);
    let packing = |grains: &[PackedGrain]| {
        let laid = Arrangement { places: grains.iter().map(|grain| grain.place).collect(), edges: grains[0].edges };
        Packing {
            grains: grains.iter().map(|grain| [grain.radius, grain.mass]).collect(),
            laid: (laid.edges != [0.0; 9]).then(|| Arc::new(laid)),
        }
    };
    together.map(packing).collect()
}

/// Table of the grains of the packings that RVEs begin from.
pub fn of_packings(packings: &[Packing]) -> Table {
    to_table(RVE_PACKINGS, &mut rows_of(packings), &mut PackedGrain::default())
}

/// From the table that [`of_packings`] made, which is then no longer in the state; [`Error::User`] where it is missing or torn.
pub fn to_packings(state: &mut State) -> Result<Packings, Error> {
    take(state, RVE_PACKINGS, &PackedGrain::default()).map(|rows| packings_of(&rows))
}

/// Those of rank 0, on every rank.
pub fn everywhere(packings: Packings, transport: &dyn Transport) -> Result<Packings, Error> {
    Ok(packings_of(&transfer::broadcast(transport, rows_of(&packings))?))
}

/// Nodes of a mesh.
pub const NODES: &str = "nodes";

/// RVEs of points, and their grains and contacts, one RVE's after another's.
pub const RVES: &str = "rves";
/// A row for each grain: column `motion`.
pub const RVE_GRAINS: &str = "rve_grains";
/// A row for each contact: columns `pair` and `memory`.
pub const RVE_CONTACTS: &str = "rve_contacts";

/// Tables of RVEs in canonical order, or of a piece of them, under a contact law with so many words of memory.
pub fn of_rves<S: Space>(rows: &mut [RveRow<S>], memory_words: usize) -> [Table; 3] {
    let resting = || rows.iter().map(|row| &row.resting);
    let motions = resting().flat_map(|resting| resting.motions.iter().copied()).collect();
    let pairs = resting().flat_map(|resting| resting.contacts.iter().map(|pair| packed(*pair))).collect();
    let memories = resting().flat_map(|resting| resting.memories.iter().copied()).collect();
    let column = |name: &str, width: usize, values: Values| Column { name: name.into(), width, values };
    // Position, velocity, spin, and where the grain was when lists were made.
    let motion = column("motion", Resting::<S>::MOTION, Values::F64(motions));
    let contacts = vec![column("pair", 1, Values::U64(pairs)), column("memory", memory_words, Values::F64(memories))];
    let of = |name: &str, columns: Vec<Column>| {
        let rows = columns.first().map_or(0, |column| column.values.len() / column.width);
        Table { name: name.into(), rows, columns }
    };
    let tables = [of(RVE_GRAINS, vec![motion]), of(RVE_CONTACTS, contacts)];
    let [grains, contacts] = tables;
    [to_table(RVES, rows, &mut RveRow::blank()), grains, contacts]
}

/// Rows of the tables that [`of_rves`] made.
pub fn to_rves<S: Space>(state: &mut State, memory_words: usize) -> Result<Vec<RveRow<S>>, Error> {
    refuse_torn_rves(state)?;
    let mut rows: Vec<RveRow<S>> = take(state, RVES, &RveRow::blank())?;
    let find = |name: &str| {
        let table = state.tables.iter().find(|table| table.name == name);
        table.ok_or_else(|| Error::User(format!("there is no table `{name}`")))
    };
    let (grains, contacts) = (find(RVE_GRAINS)?, find(RVE_CONTACTS)?);
    let (motion, memory) = (column_of(grains, "motion")?, column_of(contacts, "memory")?);
    let Values::U64(pairs) = &column_of(contacts, "pair")?.values else {
        return Err(Error::User(format!("column `pair` of table `{RVE_CONTACTS}` has another type")));
    };
    let (mut motions, mut pairs, mut memories) = (numbers_of(motion), &pairs[..], numbers_of(memory));
    for row in &mut rows {
        let point = row.point.0;
        let Resting { motions: of_grains, contacts, memories: of_contacts, .. } = &mut row.resting;
        if of_contacts.len() != contacts.len() * memory_words {
            return Err(Error::User(format!(
                "the contacts of the RVE of point {point} remember other than {memory_words} words; they are of another law"
            )));
        }
        let torn = || Error::User(format!("the RVE of point {point} lacks grains or contacts in its tables"));
        let (of, rest) = motions.split_at_checked(of_grains.len()).ok_or_else(torn)?;
        of_grains.copy_from_slice(of);
        motions = rest;
        let (of, rest) = memories.split_at_checked(of_contacts.len()).ok_or_else(torn)?;
        of_contacts.copy_from_slice(of);
        memories = rest;
        let (of, rest) = pairs.split_at_checked(contacts.len()).ok_or_else(torn)?;
        contacts.iter_mut().zip(of).for_each(|(pair, word)| *pair = parted(*word));
        pairs = rest;
    }
    state.tables.retain(|table| ![RVE_GRAINS, RVE_CONTACTS].contains(&table.name.as_str()));
    Ok(rows)
}

/// Rows tell how much of the other tables is theirs: what is not there is found out before room is made for it.
fn refuse_torn_rves(state: &State) -> Result<(), Error> {
    let of = |name: &str| state.tables.iter().find(|table| table.name == name);
    let Some(rows) = of(RVES) else { return Err(Error::User(format!("there is no table `{RVES}`"))) };
    let tables = [
        ("grain_words", RVE_GRAINS, "motion"),
        ("contacts", RVE_CONTACTS, "pair"),
        ("contact_words", RVE_CONTACTS, "memory"),
    ];
    for (count, name, column) in tables {
        let Values::U64(counts) = &column_of(rows, count)?.values else {
            return Err(Error::User(format!("column `{count}` of table `{RVES}` has another type")));
        };
        let wanted = counts.iter().fold(0u64, |sum, count| sum.saturating_add(*count));
        let table = of(name).ok_or_else(|| Error::User(format!("there is no table `{name}`")))?;
        let there = column_of(table, column)?.values.len() as u64;
        if wanted != there {
            return Err(Error::User(format!(
                "table `{RVES}` has {wanted} of column `{column}` of table `{name}`, which has {there}"
            )));
        }
    }
    Ok(())
}

fn column_of<'t>(table: &'t Table, name: &str) -> Result<&'t Column, Error> {
    let at = place_of(table, name);
    at.map(|at| &table.columns[at]).ok_or_else(|| Error::User(format!("table `{}` has no column `{name}`", table.name)))
}

fn place_of(table: &Table, name: &str) -> Option<usize> {
    table.columns.iter().position(|column| column.name == name)
}

/// The numbers of a column of numbers, none of another.
fn numbers_of(column: &Column) -> &[f64] {
    match &column.values {
        Values::F64(values) => values,
        _ => &[],
    }
}

/// Rows of the tables that [`of_grains`] and, where something is tied, [`of_penalty_springs`] made, in their order.
pub fn to_grains<S: Space>(state: &mut State, memory_words: usize) -> Result<Vec<GrainRow<S>>, Error> {
    let mut rows: Vec<GrainRow<S>> = to_grains_named(GRAINS, state, memory_words)?;
    if state.tables.iter().any(|table| table.name == "ties") {
        let order = Order::of(&rows);
        for PenaltySpringRow { grain, spring } in take(state, "ties", &blank_tie::<S>())? {
            rows[order.find(grain, "ties", GRAINS[0])?].spring = spring;
        }
    }
    Ok(rows)
}

/// Rows of the tables that [`of_grains_named`] made, in their order.
pub fn to_grains_named<S: Space>(
    [grains, touching]: [&str; 2],
    state: &mut State,
    memory_words: usize,
) -> Result<Vec<GrainRow<S>>, Error> {
    let mut rows: Vec<GrainRow<S>> = take(state, grains, &GrainRow::blank())?;
    let contacts: Vec<ContactRow> = take(state, touching, &blank_contact(memory_words))?;
    let order = Order::of(&rows);
    let find = |id: GrainId| order.find(id, touching, grains);
    for contact in contacts {
        rows[find(contact.lower)?].contacts.push((contact.higher, contact.memory));
        // A body is in no table of grains and keeps nothing itself.
        if !is_body(contact.higher) {
            rows[find(contact.higher)?].contacts.push((contact.lower, contact.memory));
        }
    }
    for row in &mut rows {
        row.contacts.sort_unstable_by_key(|(partner, _)| *partner);
    }
    Ok(rows)
}

/// Where grains stand among rows, by their ids.
struct Order(Vec<(GrainId, usize)>);

impl Order {
    fn of<S: Space>(rows: &[GrainRow<S>]) -> Self {
        let mut order: Vec<(GrainId, usize)> = rows.iter().enumerate().map(|(at, row)| (row.cold.id, at)).collect();
        order.sort_unstable();
        Self(order)
    }

    /// The row of a grain that `table` names.
    fn find(&self, id: GrainId, table: &str, grains: &str) -> Result<usize, Error> {
        let at = self.0.binary_search_by_key(&id, |(id, _)| *id);
        at.map(|at| self.0[at].1)
            .map_err(|_| Error::User(format!("table `{table}` names grain {}, which table `{grains}` lacks", id.0)))
    }
}

/// Rows of a table by name.
pub fn rows<R: crate::base::record::Record + Clone>(state: &State, name: &str, blank: &R) -> Result<Vec<R>, Error> {
    let table = state
        .tables
        .iter()
        .find(|table| table.name == name)
        .ok_or_else(|| Error::User(format!("there is no table `{name}`; the file is not of this kind")))?;
    from_table(table, blank).map_err(Error::User)
}

/// The same of a table that is then no longer in the state.
pub fn take<R: crate::base::record::Record + Clone>(state: &mut State, name: &str, blank: &R) -> Result<Vec<R>, Error> {
    let taken = rows(state, name, blank)?;
    state.tables.retain(|table| table.name != name);
    Ok(taken)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::space::{Linear, Plane};
    use crate::dem::grains::{Mover, body_partner};

    #[test]
    fn contacts_with_grains_and_with_bodies_come_back() {
        let grain = |id: u64| GrainRow::<Plane>::resting(GrainId(id), Linear::zero(), 1e-3, 1e-5, Mover::Free);
        let mut rows = [grain(3), grain(8)];
        let memory = |number: f64| Memory::of_words(&[number]);
        rows[0].contacts = vec![(GrainId(8), memory(1.0)), (body_partner(0), memory(2.0))];
        rows[1].contacts = vec![(GrainId(3), memory(1.0))];
        let mut state = State { attributes: Default::default(), tables: of_grains(&mut rows, 1).into() };
        let read: Vec<GrainRow<Plane>> = to_grains(&mut state, 1).unwrap();
        for (read, row) in read.iter().zip(&rows) {
            assert_eq!(format!("{:?}", read.contacts), format!("{:?}", row.contacts));
        }
    }
}

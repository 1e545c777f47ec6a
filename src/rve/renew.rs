//! A cell that has become too thin for its contacts is replicated: the same assembly twice as long along that axis, with every contact and
//! its memory. Nothing jumps; the two halves are alike until rounding tells them apart.

use crate::base::error::Error;
use crate::base::ids::GrainId;
use crate::base::space::Space;
use crate::dem::grains::{Cold, GrainRow};
use crate::dem::memories::Memories;
use crate::dem::sample::Sample;

/// Half of a cell's height is kept above what contacts reach by this share.
const SPARE: f64 = 1.1;

/// Grains of an assembly at most: partners of contacts are kept in 16 bits.
const GRAINS_MAX: usize = 1 << 16;

/// The axis along which the cell is about to be too thin.
pub fn thin_axis<S: Space>(sample: &Sample<S>) -> Option<usize> {
    let (assembly, reach) = (&sample.assembly, 2.0 * sample.assembly.radius_max + sample.constants.margin());
    let mut cell = assembly.cell;
    // What leans is thinner than it need be.
    cell.shorten();
    (0..S::DIMENSION).find(|axis| 0.5 * cell.height(*axis) < SPARE * reach)
}

/// Refuses more grains than an assembly may have.
pub fn refuse_many(grains: usize) -> Result<(), Error> {
    match grains > GRAINS_MAX {
        true => Err(Error::Run(format!(
            "a grain assembly has {grains} grains, and {GRAINS_MAX} are the most: it has been drawn out many times its length, or begins with too many"
        ))),
        false => Ok(()),
    }
}

/// Replicates the assembly along an axis of its cell, whose lattice may get another basis.
pub fn double<S: Space>(sample: &mut Sample<S>, axis: usize) -> Result<(), Error> {
    refuse_many(2 * sample.assembly.grains.owned)?;
    let assembly = &mut sample.assembly;
    assembly.restore_cold();
    assembly.go_home();
    let cell = assembly.cell;
    let mut one = [0; 3];
    one[axis] = 1;
    let (edge, rate) = (cell.shift(one), cell.shift_rate(one));
    let rows: Vec<GrainRow<S>> = (0..assembly.grains.owned).map(|row| assembly.whole_row(row)).collect();
    let mut twice = Vec::with_capacity(2 * rows.len());
    for row in &rows {
        for copy in 0..2 {
            let shift = f64::from(copy);
            let mut hot = row.hot;
            hot.position += edge * shift;
            hot.velocity += rate * shift;
            // Ids keep their order, and with it the sense of what contacts remember.
            let cold = Cold {
                id: GrainId(2 * row.cold.id.0 + copy as u64),
                origin: hot.position,
                home: hot.position,
                image: [0; 3],
                ..row.cold
            };
            let contacts = row.contacts.iter().map(|(partner, memory)| {
                let place = rows[partner.0 as usize].hot.position;
                let periods = cell.image_towards(&row.hot.position, &place)[axis];
                let of_partner = (copy - periods).rem_euclid(2);
                (GrainId(2 * partner.0 + of_partner as u64), *memory)
            });
            twice.push(GrainRow { hot, cold, spring: row.spring, contacts: contacts.collect() });
        }
    }
    let cell = &mut assembly.cell;
    let (mut edges, mut rates) = (cell.edges, cell.rate);
    for component in 0..S::DIMENSION {
        edges[axis * S::DIMENSION + component] *= 2.0;
        rates[axis * S::DIMENSION + component] *= 2.0;
    }
    cell.arrive(edges);
    cell.set_rate(rates);
    assembly.cell_home = assembly.cell;
    let mut memories = Memories::new(sample.constants.law().memory_words());
    twice.iter().for_each(|row| memories.push(row.contacts.iter().copied()));
    sample.arrange(&memories, |row| (twice[row].hot, twice[row].cold, twice[row].spring), twice.len())
}

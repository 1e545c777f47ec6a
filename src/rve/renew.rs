//! A cell that has become too thin for its contacts is replicated: the same assembly twice as long along that axis, with every contact and
//! its memory. Nothing jumps; the two halves are alike until rounding tells them apart.
//!
//! One that has been drawn out to so many copies is renewed: its packing, as it was made, is brought to the same stress by a servo and stands in
//! its place. Its stress jumps by what the servo leaves, and grains have forgotten what made them lie as they did but for that stress.

use crate::base::error::Error;
use crate::base::ids::GrainId;
use crate::base::space::{Linear, Space};
use crate::base::symmetric::Symmetric;
use crate::dem::grains::{Cold, GrainRow, Mover};
use crate::dem::memories::Memories;
use crate::dem::sample::Sample;
use crate::rve::drive::{Drive, Pace};
use crate::rve::levels::Compression;
use crate::rve::step::Scratch;
use crate::rve::volume_element::Rve;

/// Half of a cell's height is kept above what contacts reach by this share.
const SPARE: f64 = 1.1;

/// Copies of a packing that an assembly may be of.
const COPIES_MAX: usize = 16;
/// How near a renewed assembly comes to the stress that it is to have, and in how many increments at most: what is beyond its strength it does
/// not reach.
const TOLERANCE: f64 = 0.01;
const INCREMENTS_MAX: u64 = 6000;
/// The inertial number of its training.
const INERTIAL_NUMBER: f64 = 5e-4;

/// Grains of an assembly at most: partners of contacts are kept in 16 bits.
const GRAINS_MAX: usize = 1 << 16;

/// Whether an assembly is of more copies of its packing than it may be. A loose one has no stress to train another to, and waits until it has.
pub fn is_drawn_out<S: Space>(rve: &Rve<S>) -> bool {
    !rve.is_loose() && rve.grains() > COPIES_MAX * rve.template().packing.grains.len()
}

/// The packing of an assembly under the stress that this bears, where its F is, and by how much its stress is another, as a share of that.
/// None where it is not known how the packing lay.
pub fn renewed<S: Space>(
    old: &Rve<S>,
    drive: &Drive,
    scratch: &mut Scratch<S>,
) -> Result<Option<(Rve<S>, f64)>, Error> {
    let template = old.template();
    let Some(laid) = &template.packing.laid else { return Ok(None) };
    let cell = laid.cell::<S>();
    let rows: Vec<GrainRow<S>> = (0..)
        .zip(template.packing.grains.iter().zip(&laid.places))
        .map(|(id, ([radius, mass], place))| {
            let mut position = S::Vector::zero();
            (0..S::DIMENSION).for_each(|axis| position[axis] = place[axis]);
            let mut row = GrainRow::resting(GrainId(id), position, *radius, *mass, Mover::Free);
            row.cold.home = position;
            row
        })
        .collect();
    let sample = Sample::in_order([cell; 2], &rows, template.constants.clone())?;
    let wanted = old.observe(scratch).kirchhoff.tensor() * (-1.0 / S::determinant(old.deformation()));
    let pace = Pace::QuasiStatic { inertial_number: INERTIAL_NUMBER };
    let drive = Drive { pace, relaxation: None, ..*drive };
    let mut training = Compression::of(Rve::laid(sample, template.clone()), &drive, scratch)?;
    training.come_to(&wanted, TOLERANCE, INCREMENTS_MAX)?;
    let jump = (training.stress - wanted).norm() / wanted.norm();
    let mut rve = training.rve;
    rve.stand_in_for(old);
    Ok(Some((rve, jump)))
}

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

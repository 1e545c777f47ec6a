//! Frames of contacts: those of the whole world that bear force as lines, force chains for a picture, on rank 0.
//!
//! A line goes from the centre of the grain with the lower id, inside the cell, to the centre of its partner, or of the
//! partner's image where the two touch across a periodic border; of a contact with a body, to where the body is touched.
//! Forces are those of the positions and velocities of now ([`crate::dem::bearing`]), and over the lines of a frame
//!
//! ```text
//! sigma_ij = 1/V sum w f_i (x_end - x_begin)_j
//! ```
//!
//! is the mean stress of the contacts in the volume V, tension positive; f is the force on the grain where the line begins,
//! w the contact's weight, which is one but where grains and points share a place.

use std::collections::BTreeMap;

use scree_io::column::{Column, Values};
use scree_io::frames::{Drawn, Frame};

use crate::base::error::Error;
use crate::base::ids::GrainId;
use crate::base::record::{Cargo, Record, Visitor};
use crate::base::space::{Linear, Space};
use crate::dem::bearing::Bearing;
use crate::dem::grains::body_of_partner;
use crate::domain::transfer;
use crate::domain::world::World;
use crate::observe::frame::spread;

/// What a line leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i64)]
pub enum Partner {
    /// Another grain.
    Grain = 0,
    /// A body that the grain touches.
    Body = 1,
}

/// One contact as a picture needs it; SI units, third components zero in the plane.
#[derive(Clone, Debug, Default)]
struct Line {
    begin: [f64; 3],
    end: [f64; 3],
    lower: i64,
    /// Id of the other grain, or number of the body.
    higher: i64,
    partner: i64,
    /// Whether it ends outside of the cell, at an image.
    across: i64,
    force: [f64; 3],
    /// Of the force: across the contact, positive where the two push each other, and along it, N.
    parts: [f64; 2],
    weight: f64,
}

impl Record for Line {
    fn visit(&mut self, visitor: &mut dyn Visitor) {
        visitor.f64s("begin", &mut self.begin);
        visitor.f64s("end", &mut self.end);
        visitor.i64("lower", &mut self.lower);
        visitor.i64("higher", &mut self.higher);
        visitor.i64("partner", &mut self.partner);
        visitor.i64("across", &mut self.across);
        visitor.f64s("force", &mut self.force);
        visitor.f64s("parts", &mut self.parts);
        visitor.f64s("weight", std::slice::from_mut(&mut self.weight));
    }
}

impl Cargo for Line {
    fn blank() -> Self {
        Self::default()
    }
}

/// Bytes of a line in a file before they are compressed: two places, their numbers, an offset, and the fields.
pub const BYTES_PER_LINE: usize = 8 * (6 + 2 + 1 + 4 + 3 + 2 + 1);

/// The contacts as they are; a world without any gives a frame without lines. Copies of other ranks' grains must be of now.
pub fn contact_frame<S: Space>(world: &mut World<S>) -> Result<Option<Frame>, Error> {
    world.refresh_ghosts();
    let Some(lines) = transfer::gather(world.transport, lines(world))? else { return Ok(None) };
    let whole = |name: &str, get: &dyn Fn(&Line) -> i64| Column {
        name: name.to_string(),
        width: 1,
        values: Values::I64(lines.iter().map(get).collect()),
    };
    let numbers = |width: usize, name: &str, get: &dyn Fn(&Line) -> Vec<f64>| Column {
        name: name.to_string(),
        width,
        values: Values::F64(lines.iter().flat_map(get).collect()),
    };
    let fields = vec![
        whole("lower", &|line| line.lower),
        whole("higher", &|line| line.higher),
        whole("partner", &|line| line.partner),
        whole("across", &|line| line.across),
        numbers(1, "force_normal", &|line| vec![line.parts[0]]),
        numbers(1, "force_tangential", &|line| vec![line.parts[1]]),
        numbers(3, "force", &|line| line.force.to_vec()),
        numbers(1, "weight", &|line| vec![line.weight]),
    ];
    let positions = lines.iter().flat_map(|line| [line.begin, line.end]).collect();
    Ok(Some(Frame { time: world.time(), drawn: Drawn::Lines, positions, fields, whole: Vec::new() }))
}

fn lines<S: Space>(world: &World<S>) -> Vec<Line> {
    bearings(world).iter().map(|bearing| line(world, bearing)).collect()
}

/// Forces of the contacts of a world on one rank across and along each (N, as in a frame), by the lower id and the partner.
pub fn forces<S: Space>(world: &mut World<S>) -> BTreeMap<[GrainId; 2], [f64; 2]> {
    world.refresh_ghosts();
    let id = |bearing: &Bearing<S>| world.assembly.grains.cold[bearing.row as usize].id;
    bearings(world).iter().map(|bearing| ([id(bearing), bearing.partner], bearing.parts())).collect()
}

/// Contacts of owned rows in their order: with grains of higher ids in the order of these, then with bodies.
fn bearings<S: Space>(world: &World<S>) -> Vec<Bearing<S>> {
    let (grains, law, times) = (&world.assembly.grains, world.law(), world.contact_times());
    let mut on_bodies =
        world.assembly.walls.bearings(law, grains, (&world.bodies, &world.assembly.cell), times).peekable();
    let mut found = Vec::new();
    for row in 0..grains.owned {
        let id = grains.cold[row].id;
        let ours = world.assembly.contacts.bearings(law, grains, row, times).filter(|bearing| id < bearing.partner);
        found.extend(ours);
        while let Some(bearing) = on_bodies.next_if(|bearing| bearing.row as usize == row) {
            found.push(bearing);
        }
    }
    found
}

fn line<S: Space>(world: &World<S>, bearing: &Bearing<S>) -> Line {
    let row = bearing.row as usize;
    let nothing = S::Vector::zero();
    let mut begin = world.assembly.grains.hot[row].position;
    world.assembly.cell.wrap(&mut begin, &mut nothing.clone());
    let end = begin + bearing.branch;
    let body = body_of_partner(bearing.partner);
    let image = world.assembly.cell.wrap(&mut end.clone(), &mut nothing.clone());
    Line {
        begin: spread(&begin),
        end: spread(&end),
        lower: world.assembly.grains.cold[row].id.0 as i64,
        higher: body.map_or(bearing.partner.0 as i64, |body| body as i64),
        partner: if body.is_some() { Partner::Body } else { Partner::Grain } as i64,
        across: i64::from(body.is_none() && image != [0; 3]),
        force: spread(&bearing.force),
        parts: bearing.parts(),
        weight: bearing.weight,
    }
}

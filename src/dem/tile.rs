//! A periodic packing repeated along its edges: a large packing from a small one, in the same balance of forces.
//!
//! Copy t of grain i is grain i T + t of T copies: among copies of two grains the order of ids is that of the two, which
//! the memory of their contact is oriented by.

use crate::base::ids::GrainId;
use crate::base::space::{Linear, Space};
use crate::dem::grains::{GrainRow, is_body};

/// Repeats the grains of a cell `counts` times along its edges (columns, m), along which it must be periodic where the
/// count is not one. A contact across a face between copies joins neighbours; at the ends of all copies those that the whole is `periodic` between, and is
/// gone where it is not. The rows come in the order of their ids.
pub fn tile<S: Space>(
    mut rows: Vec<GrainRow<S>>,
    edges: &S::Tensor,
    counts: [usize; 3],
    periodic: [bool; 3],
) -> Vec<GrainRow<S>> {
    let counts: [usize; 3] = std::array::from_fn(|axis| if axis < S::DIMENSION { counts[axis].max(1) } else { 1 });
    let copies = counts.iter().product::<usize>();
    let inverse = S::inverse(edges).expect("the edges of a cell span it");
    rows.sort_unstable_by_key(|row| row.cold.id);
    let find = |id: GrainId| {
        let at = rows.binary_search_by_key(&id, |row| row.cold.id);
        &rows[at.expect("a packing holds the partners of its grains")]
    };
    let mut tiled = Vec::with_capacity(copies * rows.len());
    for row in &rows {
        // How many edges each partner's nearest image lies away from the partner itself.
        let apart = row.contacts.iter().map(|(partner, _)| match is_body(*partner) {
            true => [0; 3],
            false => periods::<S>(&(inverse * (row.hot.position - find(*partner).hot.position))),
        });
        let apart: Vec<[i64; 3]> = apart.collect();
        for copy in 0..copies {
            let at = [copy % counts[0], copy / counts[0] % counts[1], copy / counts[0] / counts[1]];
            let mut made = row.clone();
            made.cold.id = named(row.cold.id, copies, copy);
            let shift = *edges * vector::<S>(&at);
            made.hot.position += shift;
            made.cold.home += shift;
            made.cold.origin += shift;
            made.contacts.clear();
            for ((partner, memory), apart) in row.contacts.iter().zip(&apart) {
                let mut named_partner = *partner;
                if !is_body(*partner) {
                    let place: [i64; 3] = std::array::from_fn(|axis| at[axis] as i64 + apart[axis]);
                    let is_beyond = |axis: usize| !(0..counts[axis] as i64).contains(&place[axis]);
                    if (0..S::DIMENSION).any(|axis| !periodic[axis] && is_beyond(axis)) {
                        continue;
                    }
                    let beside: [usize; 3] =
                        std::array::from_fn(|axis| place[axis].rem_euclid(counts[axis] as i64) as usize);
                    named_partner =
                        named(*partner, copies, (beside[2] * counts[1] + beside[1]) * counts[0] + beside[0]);
                }
                made.contacts.push((named_partner, *memory));
            }
            tiled.push(made);
        }
    }
    tiled
}

fn named(id: GrainId, copies: usize, copy: usize) -> GrainId {
    GrainId(id.0 * copies as u64 + copy as u64)
}

/// The whole periods nearest to shares of the edges.
fn periods<S: Space>(shares: &S::Vector) -> [i64; 3] {
    let mut periods = [0; 3];
    for axis in 0..S::DIMENSION {
        periods[axis] = shares[axis].round() as i64;
    }
    periods
}

fn vector<S: Space>(counts: &[usize; 3]) -> S::Vector {
    let mut vector = S::Vector::zero();
    for axis in 0..S::DIMENSION {
        vector[axis] = counts[axis] as f64;
    }
    vector
}

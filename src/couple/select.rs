//! Which grains of the packing replace the points of a zone, so that no mass is made or lost.

use crate::couple::zone::{Label, Zone};

/// A grain of the packing that could enter: where the continuum's motion has carried it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Row in the packing.
    pub row: usize,
    /// Of the grain: settles which of two at one distance enters first.
    pub id: u64,
    /// kg, without its weight.
    pub mass: f64,
    /// Place now, m.
    pub place: [f64; 2],
}

/// What enters, and what the points keep.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Rows of the packing and whether they belong to the rim, by id.
    pub chosen: Vec<(usize, bool)>,
    /// Weighted mass of all that entered, kg.
    pub mass: f64,
    /// Weight that every point of the rim keeps: 1 - w, and the remainder of less than one grain.
    pub point_weight: f64,
}

/// Chooses grains so that weighted masses match: all grains of the core enter, then grains from the inner edge of the rim
/// outwards until the mass that points give up is met to less than half a weighted grain. What is left over is carried
/// by the weights of the rim's points, so the sum is exact.
///
/// `core` and `rim` are the masses of points in the core and in the rim, kg; `weight` is w.
pub fn select(zone: &Zone, candidates: &[Candidate], core: f64, rim: f64, weight: f64) -> Selection {
    let given_up = core + weight * rim;
    let mut chosen = Vec::new();
    let mut mass = 0.0;
    let mut edge = Vec::new();
    for candidate in candidates {
        match zone.at(candidate.place[0], candidate.place[1]) {
            Label::Grains => {
                chosen.push((candidate.id, candidate.row, false));
                mass += candidate.mass;
            }
            _ => edge.push((zone.distance(candidate.place), candidate)),
        }
    }
    edge.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.id.cmp(&b.1.id)));
    for (_, candidate) in edge {
        if mass + 0.5 * weight * candidate.mass > given_up {
            break;
        }
        chosen.push((candidate.id, candidate.row, true));
        mass += weight * candidate.mass;
    }
    chosen.sort_unstable();
    let chosen = chosen.into_iter().map(|(_, row, in_rim)| (row, in_rim)).collect();
    Selection { chosen, mass, point_weight: (core + rim - mass) / rim }
}

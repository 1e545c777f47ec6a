//! What the fields of frames are, as their files and docs/output.md tell it.

use scree_io::frames::Meaning;

/// Every field of every kind of frame, by its name, which means the same wherever it stands. SI units, "1" of pure numbers.
pub const MEANINGS: &[Meaning] = &[
    of("Points", "m", "place"),
    of("Values", "s", "time"),
    of("kind", "1", "0 of a point, 1 of a grain, 2 of a grain glued to a plate or body, 3 of a vertex of a membrane"),
    of("id", "1", "number of the grain, point, element or vertex, for good"),
    of(
        "radius",
        "m",
        "radius of a grain or of a disc or sphere of the volume of a point; a quarter of a membrane segment",
    ),
    of("weight", "1", "share of the material of its place, or of a contact; below 1 where grains and points overlap"),
    of("mass", "kg", "mass; 0 of vertices"),
    of("displacement", "m", "displacement since the start, across periods"),
    of("velocity", "m/s", "velocity; of grains half a step before"),
    of("spin", "rad/s", "angular velocity"),
    of("stress", "Pa", "Cauchy stress, tension positive: xx, yy, xy and in space zz, yz, xz"),
    of("stress_averaged", "Pa", "mean of the stress over the nodes around a point; of a grain its own"),
    of("coordination", "1", "contacts that bear force; of RVEs their mean over grains"),
    of("p", "Pa", "mean stress, tension positive"),
    of("q", "Pa", "deviatoric stress, the root of J2"),
    of("out_of_plane_stress", "Pa", "stress across the plane; 0 in space"),
    of("volumetric_strain", "1", "logarithmic volume strain since the start"),
    of("deviatoric_strain", "1", "logarithmic shear strain since the start"),
    of("rotation", "rad", "angle of rotation since the start"),
    of("fraction", "1", "solid volume fraction; 0 of grains"),
    of("plastic_strain", "1", "accumulated plastic shear strain; 0 of grains"),
    of("void_ratio", "1", "void ratio of the RVE"),
    of("mechanical_coordination", "1", "contacts of a grain, without grains that have none or one"),
    of("fabric_anisotropy", "1", "fabric anisotropy of the RVE"),
    of("fabric_direction", "rad", "in the plane the angle of most contacts from x"),
    of("grain_rotation", "rad", "angle by which the grains of the RVE have turned in the mean"),
    of("unbalanced", "1", "I_uf, what is out of balance over the contact forces of the RVE"),
    of("grains", "1", "grains of the RVE"),
    of("grain_steps", "1", "steps that the grains of the RVE have taken"),
    of("lower", "1", "the lower id of the two grains, or the grain's"),
    of("higher", "1", "the higher id of the two grains, or the number of the body"),
    of("partner", "1", "0 where two grains touch, 1 where a grain touches a body"),
    of("across", "1", "1 of a contact with an image across a period"),
    of("flagged", "1", "1 where the nearest node is flagged by the oracle"),
    of("force", "N", "force on the grain `lower`"),
    of("force_normal", "N", "normal force, positive where the two push"),
    of("force_tangential", "N", "tangential force"),
    of("cell_corner", "m", "corner of the cell"),
    of("cell_edges", "m", "edges of the cell, one after the other"),
    of("cell_periodic", "1", "1 along edges in which the cell is periodic"),
];

const fn of(field: &'static str, unit: &'static str, what: &'static str) -> Meaning {
    Meaning { field, unit, what }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observe::point::{OBSERVED, OBSERVED_OF_RVES};

    #[test]
    fn every_field_of_points_is_told_once() {
        let names: Vec<&str> = MEANINGS.iter().map(|meaning| meaning.field).collect();
        assert!(OBSERVED.iter().chain(&OBSERVED_OF_RVES).all(|name| names.contains(name)));
        assert!(names.iter().enumerate().all(|(at, name)| !names[..at].contains(name)));
        // What HDF5 keeps as an attribute.
        assert!(MEANINGS.iter().all(|meaning| meaning.unit.len() <= 8 && meaning.what.len() < 128));
    }

    #[test]
    fn the_handbook_has_every_field_with_its_unit() {
        let page = include_str!("../../docs/output.md");
        for Meaning { field, unit, what } in
            MEANINGS.iter().filter(|meaning| !["Points", "Values"].contains(&meaning.field))
        {
            let row = format!("| `{field}` | {unit} | {what} |");
            assert!(page.lines().any(|line| line == row), "docs/output.md lacks: {row}");
        }
    }
}

//! A frame of a run, row by row: what is measured and drawn of grains and points.

use std::path::Path;

use scree_io::column::{Column, Values};
use scree_io::frames;

use super::run::{torn_frames, unreadable};
use crate::base::error::Error;
use crate::base::math;

/// What a row of a frame is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A material point, or the point of an element.
    #[default]
    Point,
    /// A grain that is free.
    Grain,
    /// A grain glued to a plate.
    Glued,
}

impl Kind {
    /// Grains share their ids, glued or not.
    pub fn is_grain(self) -> bool {
        self != Self::Point
    }
}

/// A point or a grain at the time of a frame. In space it is seen along y: places are x and z.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Body {
    /// What it is.
    pub kind: Kind,
    /// Unique among points, or among grains.
    pub id: i64,
    /// m; x in [0, period) where there is one.
    pub position: [f64; 2],
    /// How far behind the others it is, m.
    pub depth: f64,
    /// m, not wrapped, since the body's origin.
    pub displacement: [f64; 2],
    /// How far that is, with what is not seen, m.
    pub moved: f64,
    /// m; of a point: of the disc or sphere of equal size.
    pub radius: f64,
    /// Below one in the rim.
    pub weight: f64,
    /// Cauchy stress xy, of a grain the mean of its contacts over its share of space, Pa.
    pub shear_stress: f64,
    /// Mean stress, in the plane the mean in the plane, compression positive, Pa.
    pub pressure: f64,
    /// Plastic and deviatoric strain since it began, as the frame has them; zero where it has none, or where a grain has lost its
    /// neighbours.
    pub plastic: f64,
    /// Deviatoric strain since it began; zero where the frame has none, or where a grain has lost its neighbours.
    pub deviatoric: f64,
    /// Rotation of F = R U, rad, and void ratio of the RVE; zero where the frame has none.
    pub rotation: f64,
    /// Of its RVE; zero where the frame has none.
    pub void_ratio: f64,
}

impl Body {
    /// Where it began, m; x in no particular period.
    pub fn origin(&self) -> [f64; 2] {
        [self.position[0] - self.displacement[0], self.position[1] - self.displacement[1]]
    }

    /// Area that it stands for in the plane, m2.
    pub fn area(&self) -> f64 {
        self.weight * math::PI * self.radius * self.radius
    }

    /// By which rows are found.
    pub fn key(&self) -> (bool, i64) {
        (self.kind.is_grain(), self.id)
    }

    /// A grain outside of the rim.
    pub fn is_inner(&self) -> bool {
        self.kind == Kind::Grain && self.weight >= 1.0
    }

    /// Edge of the square or cube that is as large.
    pub fn edge(&self, dimension: usize) -> f64 {
        self.radius * if dimension == 3 { math::cbrt(4.0 / 3.0 * math::PI) } else { math::PI.sqrt() }
    }

    /// In the plane, of a grain its diameter, of a point the edge of its square, m.
    pub fn extent(&self) -> f64 {
        if self.kind.is_grain() { 2.0 * self.radius } else { self.edge(2) }
    }
}

/// A frame, its bodies in ascending order of (point or grain, id), and vertices of membranes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// s.
    pub time: f64,
    /// Ascending by [`Body::key`].
    pub bodies: Vec<Body>,
    /// m, as they are seen.
    pub vertices: Vec<[f64; 2]>,
    /// Lower corner of the cell, m; none where the frame has none.
    pub corner: Option<[f64; 2]>,
}

impl Snapshot {
    /// Reads one frame; where the `period` (m) is positive, x is brought into it. Of the axes `up` is drawn upright.
    pub fn read(path: &Path, index: usize, (dimension, up): (usize, usize), period: f64) -> Result<Self, Error> {
        let torn = |what: &str| torn_frames(path, &format!("frame {index}: {what}"));
        let frame = frames::read_frame(path, index).map_err(unreadable)?;
        let rows = frame.positions.len();
        let tensor = if dimension == 3 { 6 } else { 3 };
        let named = |name: &str| frame.fields.iter().find(|column| column.name == name);
        let find = |name: &str, width: usize| -> Result<&Column, Error> {
            let column = named(name).ok_or_else(|| torn(&format!("there is no field `{name}`")))?;
            if column.width != width || column.values.len() != rows * width {
                return Err(torn(&format!("field `{name}` does not hold {width} numbers a row")));
            }
            Ok(column)
        };
        let integers = |name: &str| match &find(name, 1)?.values {
            Values::I64(values) => Ok(values),
            _ => Err(torn(&format!("field `{name}` does not hold integers"))),
        };
        let reals = |name: &str, width: usize| match &find(name, width)?.values {
            Values::F64(values) if values.iter().all(|value| value.is_finite()) => Ok(values),
            Values::F64(_) => Err(torn(&format!("field `{name}` holds what is not a number"))),
            _ => Err(torn(&format!("field `{name}` does not hold reals"))),
        };
        let strain = |name: &str, row: usize| match named(name).map(|column| &column.values) {
            Some(Values::F64(values)) => values.get(row).copied().filter(|value| value.is_finite()).unwrap_or(0.0),
            _ => 0.0,
        };
        let (kinds, ids) = (integers("kind")?, integers("id")?);
        let (radii, weights, displacements) = (reals("radius", 1)?, reals("weight", 1)?, reals("displacement", 3)?);
        let stresses = reals("stress", tensor)?;
        let corner =
            frame.whole.iter().find(|column| column.name == "cell_corner").and_then(|column| match &column.values {
                Values::F64(values) => Some([*values.first()?, *values.get(up)?]),
                _ => None,
            });
        let mut snapshot = Self { time: frame.time, bodies: Vec::with_capacity(rows), vertices: Vec::new(), corner };
        for (row, place) in frame.positions.iter().enumerate() {
            let kind = match kinds[row] {
                0 => Kind::Point,
                1 => Kind::Grain,
                2 => Kind::Glued,
                3 => {
                    snapshot.vertices.push([place[0], place[up]]);
                    continue;
                }
                other => return Err(torn(&format!("row {row} is of kind {other}; known are 0 to 3"))),
            };
            if !place.iter().all(|at| at.is_finite()) {
                return Err(torn(&format!("row {row} has no place")));
            }
            // xx, yy, xy and in space zz.
            let stress = &stresses[tensor * row..tensor * (row + 1)];
            let trace = stress[0] + stress[1] + if dimension == 3 { stress[3] } else { 0.0 };
            snapshot.bodies.push(Body {
                kind,
                id: ids[row],
                position: [if period > 0.0 { place[0].rem_euclid(period) } else { place[0] }, place[up]],
                depth: if dimension == 3 { place[3 - up] } else { 0.0 },
                displacement: [displacements[3 * row], displacements[3 * row + up]],
                moved: displacements[3 * row..3 * (row + 1)].iter().map(|along| along * along).sum::<f64>().sqrt(),
                radius: radii[row],
                weight: weights[row],
                shear_stress: stress[2],
                pressure: -trace / dimension as f64,
                plastic: strain("plastic_strain", row),
                deviatoric: strain("deviatoric_strain", row),
                rotation: strain("rotation", row),
                void_ratio: strain("void_ratio", row),
            });
        }
        snapshot.bodies.sort_by_key(Body::key);
        if let Some(twins) = snapshot.bodies.windows(2).find(|pair| pair[0].key() == pair[1].key()) {
            let noun = if twins[0].kind.is_grain() { "grain" } else { "point" };
            return Err(torn(&format!("{noun} {} is there twice", twins[0].id)));
        }
        Ok(snapshot)
    }

    /// The row of a body that was met in another frame.
    pub fn row_of(&self, body: &Body) -> Option<usize> {
        self.bodies.binary_search_by_key(&body.key(), Body::key).ok()
    }
}

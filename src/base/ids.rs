//! Ids, rows and places are different things and different types.

/// Names a grain for the whole run, on every rank and across restarts. Grains glued to plates share this space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct GrainId(pub u64);

/// Names a material point for the whole run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct PointId(pub u64);

/// Names a node of a mesh for the whole run: the vertex of the mesh that it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct NodeId(pub u64);

/// Where a grain or point stands in the arrays of this rank until the next rebuild.
pub type Row = u32;

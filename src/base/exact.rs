//! Sums that come out the same in any order, as the physics has them: it adds, and whoever knows ranks adds those of all.

pub use scree_partition::{ExactSum, SumError};

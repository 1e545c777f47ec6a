//! Grains for points while a run goes on: what tells where a band is, and the enrichment.

mod cells;
pub mod enrichment;
pub mod flow;
pub mod shear;
pub mod watch;

//! Grains for points while a run goes on: what tells where a band is, and the enrichment.

pub mod enrichment;
pub mod watch;

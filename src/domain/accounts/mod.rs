//! What must be kept: mass, momentum and energy.

pub mod conservation;
pub mod energy;
pub mod ledger;

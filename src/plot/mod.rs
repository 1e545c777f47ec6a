//! Pages and drawings of what runs have left.

pub mod report;

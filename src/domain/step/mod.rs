//! The parts of a step that are more than a call.

pub mod askew;
pub mod cycle;
pub mod elements;
pub mod faces;
pub mod full_step;
pub mod grid;
pub mod loads;
pub mod membranes;
pub mod nonlocal;
pub mod rves;

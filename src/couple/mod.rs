//! Grains where the continuum shears itself into a band: where ([`oracle`], [`zone`]), from what ([`motion`], [`select`]).
//! Coupling itself happens on the nodes: [`crate::mpm::nodes::step`].

pub mod kept;
pub mod motion;
pub mod oracle;
pub mod patch;
pub mod rest;
pub mod select;
pub mod zone;

//! Rigid bodies, and what holds the nodes that they meet.

pub mod body;
pub mod boundary;

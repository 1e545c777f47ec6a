//! Laws of matter, one file each, named after what they are: between two grains ([`contact`]) and inside a continuum
//! ([`material`]). A law is a type behind a trait, chosen once per run; the step never branches on it.

pub mod contact;
pub mod invariants;
pub mod material;

//! The world in blocks: who holds what, the step, the accounts and the guards. It alone calls the partition.

pub mod accounts;
pub mod elements;
pub mod grid;
pub mod guards;
pub mod instant;
pub mod layout;
pub mod load_balance;
pub mod means;
pub mod meter;
pub mod nonlocal;
pub mod parts;
pub mod phases;
pub mod plan;
pub mod reaction;
pub mod rebuild;
pub mod rves;
pub mod step;
pub mod stop;
pub mod stress;
pub mod subdomain;
pub mod transfer;
pub mod world;

//! The ground: errors, numbers, spaces, vectors of registers, records.

pub mod compiled;
pub mod digits;
pub mod error;
pub mod exact;
pub mod ids;
pub mod keys;
pub mod lane;
pub mod math;
pub mod numbers;
pub mod parallel;
pub mod program;
pub mod record;
pub mod rows;
pub mod space;
pub mod symmetric;
pub mod units;
pub mod zeroed;

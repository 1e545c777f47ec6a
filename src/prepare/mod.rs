//! What is made ahead of a run: packings and specimens. They are kept in a cache that runs share, made once, and while they
//! are made they are saved, told of and stopped like runs.

pub mod cache;
pub mod making;

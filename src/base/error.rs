//! What can go wrong, by who can mend it. Messages speak to the operator: one short paragraph with the remedy.

/// An error and the exit code it ends the program with.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operator's mistake: a bad job, an existing run, a bad checkpoint. Exit code 2.
    #[error("{0}")]
    User(String),
    /// The run stopped itself: unstable, a lost grain, a full disk. Exit code 3.
    #[error("{0}")]
    Run(String),
    /// All ranks were asked to stop before a run had begun, after that many steps of a packing or a test. Exit code 4.
    #[error("Stopped on request, after {0} steps.")]
    Stopped(u64),
}

impl Error {
    /// 2 to 4, as told at the variants.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::User(_) => 2,
            Error::Run(_) => 3,
            Error::Stopped(_) => 4,
        }
    }
}

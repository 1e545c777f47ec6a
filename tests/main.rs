//! The index of what is claimed about the program, one line a claim. One binary, so that linking is paid once.

/// Wrong jobs are refused before any work, with file, line, value and remedy; exit code 2.
mod bad_jobs;
/// Every job in `jobs/` is read, and its resolved form means the same.
mod jobs;
/// The style that no compiler holds: one door to inexact mathematics, no ranks in physics, short files.
mod tidy;

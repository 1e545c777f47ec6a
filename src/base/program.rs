//! Who the program is: what it writes of itself into everything that it leaves, so that a curve can be told to a source.

use std::fs;
use std::sync::LazyLock;

use jiff::Timestamp;
use scree_io::schema::SCHEMA_VERSION;

/// Of the package, as Cargo.toml has it: `0.2.0`.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
/// The commit it was built from; `+changes` where the source differed from it, `unknown` without a repository.
pub const COMMIT: &str = env!("SCREE_COMMIT");
/// 16 hex digits that stand for the source: two programs with the same compute the same.
pub const SOURCE: &str = env!("SCREE_SOURCE");
/// Profile, features, target and compiler.
pub const BUILD: &str = env!("SCREE_BUILD");

/// `scree 0.2.0 (003785f123)`.
pub fn name() -> &'static str {
    concat!("scree ", env!("CARGO_PKG_VERSION"), " (", env!("SCREE_COMMIT"), ")")
}

/// One line with all of it, as files carry it.
pub fn identity() -> &'static str {
    static IDENTITY: LazyLock<String> =
        LazyLock::new(|| format!("{}, source {SOURCE}, schema {SCHEMA_VERSION}, {BUILD}", name()));
    &IDENTITY
}

/// What `-V` prints after the program's name.
pub fn short_version() -> &'static str {
    concat!(env!("CARGO_PKG_VERSION"), " (", env!("SCREE_COMMIT"), ")")
}

/// What `--version` prints after the program's name.
pub fn version() -> &'static str {
    static TEXT: LazyLock<String> = LazyLock::new(|| {
        format!("{VERSION} ({COMMIT})\nsource {SOURCE}\nschema {SCHEMA_VERSION} of checkpoints\n{BUILD}")
    });
    &TEXT
}

/// Whether a file's line is that of this program: of the same source, however it was built.
pub fn is_this(identity: &str) -> bool {
    identity.contains(&format!("source {SOURCE}"))
}

/// The name in such a line, for a person.
pub fn name_in(identity: &str) -> &str {
    identity.split(',').next().unwrap_or(identity)
}

/// The name of this machine.
pub fn host() -> String {
    fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default().trim().to_string()
}

/// Now, in UTC to the second.
pub fn now() -> String {
    let now = Timestamp::now();
    Timestamp::from_second(now.as_second()).unwrap_or(now).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_tell_which_program_wrote_them() {
        assert!(is_this(identity()) && !is_this("scree 0.1.0"));
        assert_eq!(name_in(identity()), name());
        assert!(SOURCE.len() == 16 && SOURCE.bytes().all(|digit| digit.is_ascii_hexdigit()));
    }
}

//! The names inside a checkpoint file. Whoever changes one raises [`SCHEMA_VERSION`].
//!
//! ```text
//! /                           attributes: schema_version (u64), digest, seal, and the state's short attributes (text)
//! /text/<attribute>           the state's long attributes, UTF-8 bytes
//! /tables/<table>             attribute: rows (u64)
//! /tables/<table>/<column>    rows x width values; tables and columns keep the order they were written in
//! ```

/// The layout that [`store`](crate::store) writes, with the tables and columns that the program has in it: whoever changes these
/// raises it as well.
pub const SCHEMA_VERSION: u64 = 4;

/// The oldest layout that is still read. Tables and columns that came after it are the reader's to make up.
pub const SCHEMA_OLDEST: u64 = 2;

pub(crate) const VERSION_ATTRIBUTE: &str = "schema_version";
/// Stands for the state, as [`digest`](crate::digest::digest) defines it.
pub(crate) const DIGEST_ATTRIBUTE: &str = "digest";
/// Stands for the digest and for all attributes, so that damage to those outside the state is found too.
pub(crate) const SEAL_ATTRIBUTE: &str = "seal";
pub(crate) const RESERVED_ATTRIBUTES: [&str; 3] = [VERSION_ATTRIBUTE, DIGEST_ATTRIBUTE, SEAL_ATTRIBUTE];
pub(crate) const ROWS_ATTRIBUTE: &str = "rows";
pub(crate) const TABLES_GROUP: &str = "tables";
pub(crate) const TEXT_GROUP: &str = "text";

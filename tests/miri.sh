#!/usr/bin/env bash
# The unsafe code of src/base under Miri: records as numbers, rows of zero pages, and lanes, portable and with AVX2. What calls MPI or
# HDF5 is out of its reach, and AVX-512 as well, since a dependency does not compile for it there.
#
#     bash tests/miri.sh
set -euo pipefail
cd "$(dirname "$0")/.."
rustup toolchain install nightly --profile minimal --component miri
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-target}/miri MIRIFLAGS=-Zmiri-disable-isolation
for features in "" "-C target-feature=+avx2"; do
    RUSTFLAGS=$features cargo +nightly miri test -p scree --lib --no-default-features -- base::
done

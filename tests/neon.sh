#!/usr/bin/env bash
# The lanes that every processor has, compiled for 64-bit ARM and tested under emulation: the same numbers as single ones.
#
#     bash tests/neon.sh          wants qemu-user, gcc-aarch64-linux-gnu and libc6-dev-arm64-cross, and takes a minute
set -euo pipefail
cd "$(dirname "$0")/.."
target=aarch64-unknown-linux-gnu
for tool in qemu-aarch64 aarch64-linux-gnu-gcc; do
    command -v "$tool" >/dev/null || { echo "$tool is missing; on Debian: apt-get install qemu-user gcc-aarch64-linux-gnu libc6-dev-arm64-cross" >&2; exit 2; }
done
rustup target add "$target" >/dev/null

# The rest of the program wants HDF5 for that processor; lanes want nothing.
crate=$(mktemp -d)
trap 'rm -rf "$crate"' EXIT
mkdir "$crate/src"
cp -r src/base/lane "$crate/src/"
echo "pub mod lane;" >"$crate/src/lib.rs"
wide=$(grep '^wide = ' Cargo.toml)
printf '[package]\nname = "lanes"\nversion = "0.0.0"\nedition = "2024"\n[lib]\ndoctest = false\n[dependencies]\n%s\n' "$wide" >"$crate/Cargo.toml"
cd "$crate"
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER="qemu-aarch64 -L /usr/aarch64-linux-gnu"
cargo test --release --target "$target"

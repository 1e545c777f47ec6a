#!/usr/bin/env bash
# All tests: format, lints, and every test of the workspace, those of MPI under real mpirun. Sets up what is missing.
#
#     bash tests/run.sh           everything
#     bash tests/run.sh quick     for work in between: format, lints, golden digests, and physics that takes seconds
set -euo pipefail
cd "$(dirname "$0")/.."
tier=${1:-all}
case $tier in
    all | quick) ;;
    *)
        echo "usage: bash tests/run.sh [all|quick]" >&2
        exit 2
        ;;
esac
# shellcheck source=tests/setup
. tests/setup

started=$SECONDS
log=$(mktemp)
pages=$(mktemp -d)
trap 'rm -rf "$log" "$pages"' EXIT

fail() {
    echo "FAILED: $1, after $((SECONDS - started)) s." >&2
    exit 1
}

echo "== Format"
cargo fmt --all --check || fail "the format; run cargo fmt --all"

# Tests that read runs with VTK, or by the Python package, skip themselves where what they need is missing, unless they are told which interpreter has it.
if [ -z "${SCREE_PYTHON:-}" ]; then
    echo "== Python with VTK, pandas, h5py and PyVista"
    needed='import sys, vtk, numpy, pandas, h5py, pyvista
if sys.version_info < (3, 11): import tomli'
    if python3 -c "$needed" 2>/dev/null; then
        SCREE_PYTHON=python3
    else
        SCREE_PYTHON=$PWD/$target/python/bin/python
        case $target in /*) SCREE_PYTHON=$target/python/bin/python ;; esac
        "$SCREE_PYTHON" -c "$needed" 2>/dev/null ||
            { python3 -m venv "$target/python" && "$SCREE_PYTHON" -m pip install -q vtk numpy pandas h5py pyvista 'tomli; python_version < "3.11"'; } ||
            fail "installing the Python packages vtk, numpy, pandas, h5py and pyvista; have python3 and python3-venv, or name an interpreter that has them in SCREE_PYTHON"
    fi
fi
export SCREE_PYTHON

# Release throughout, so that build scripts and macros are compiled once.
echo "== Lints, with MPI"
cargo clippy --release --workspace --all-targets -- -D warnings || fail "a lint"

if [ "$tier" = quick ]; then
    # A profile of its own, built piece by piece: what has not changed is not compiled again.
    echo "== Golden digests and quick physics"
    cargo test --profile quick --test main -- gate tidy bad_ bodies cells clusters collisions continua contact_files coupling frames \
        grazing inclines invariance laws material membranes oracle patches pieces pulses rowe two_grains vortex || fail "a test"
    echo "Good so far: format, lints, golden digests and quick physics, in $((SECONDS - started)) s."
    exit 0
fi

echo "== Lints, without MPI"
cargo clippy --release --workspace --all-targets --no-default-features -- -D warnings || fail "a lint without MPI"

# Licences, sources and versions are held by a test as well; what is known of bad ones is not.
if command -v cargo-deny >/dev/null 2>&1; then
    echo "== Dependencies"
    cargo deny --log-level error check --hide-inclusion-graph || fail "cargo deny"
fi

# The handbook as a book: every page of its contents, by the tool that makes it. Links are held by a test.
echo "== The handbook"
book=$target/tools/bin/mdbook
if command -v mdbook >/dev/null 2>&1; then
    book=mdbook
elif ! "$book" --version >/dev/null 2>&1; then
    cargo install mdbook --version 0.4.52 --locked --no-default-features --root "$target/tools" || book=
fi
if [ -n "$book" ]; then
    "$book" build docs --dest-dir "$pages/book" || fail "the handbook"
else
    echo "skipped: there is no mdbook, and it could not be installed" >&2
fi

# Where the nightly toolchain has it; bash tests/miri.sh installs it.
if cargo +nightly miri --version >/dev/null 2>&1; then
    echo "== Unsafe code, under Miri"
    bash tests/miri.sh || fail "Miri"
fi

echo "== Tests"
cargo test --release --workspace 2>&1 | tee "$log" || fail "a test"

passed=$(awk '/^test result: ok/ { sum += $4 } END { print sum + 0 }' "$log")
[ "$passed" -gt 0 ] || fail "the tests; none was run"
echo "All good: format and lints are clean, $passed tests passed, in $((SECONDS - started)) s."

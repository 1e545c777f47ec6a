#!/usr/bin/env bash
# Runs of four kinds under torture for so many hours, a quarter each: the quickstart, a triaxial test with zones that live, a
# continuum, and an assembly of spheres. They are killed at any moment, in their packings and frames too, with nobody to read what
# they say, and their files are cut and bytes flipped between their lives. Tells lives, kills, damages, refusals and ends.
#
#     bash tests/torture.sh HOURS [SEED]
set -euo pipefail
cd "$(dirname "$0")/.."
# shellcheck source=tests/setup
. tests/setup
hours=${1:?usage: bash tests/torture.sh HOURS [SEED]}
seconds=$(awk -v hours="$hours" 'BEGIN { printf "%d", 3600 * hours }')
SCREE_TORTURE_SECONDS=$seconds SCREE_TORTURE_SEED=${2:-$(date +%s)} \
    cargo test --release --test main torture -- --nocapture

#!/usr/bin/env bash
# A hybrid run under torture for so many hours: killed at any moment, its files cut and bytes flipped between its lives. Tells
# lives, kills, damages, refusals and ends.
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

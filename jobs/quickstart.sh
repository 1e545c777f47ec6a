#!/usr/bin/env bash
# From nothing to a picture: set-up, build, a hybrid shear test on two MPI ranks, and its report.
#
#     bash jobs/quickstart.sh
set -euo pipefail
cd "$(dirname "$0")/.."
# shellcheck source=tests/setup
. tests/setup

run=runs/quickstart
if [ -e "$run" ]; then
    number=1
    while [ -e "$run.$number" ]; do
        number=$((number + 1))
    done
    mv "$run" "$run.$number"
    echo "There was a run in $run already; it is now $run.$number."
fi

echo "== Build"
cargo build --release
scree=$target/release/scree

echo "== Run: mpirun -n 2 scree run jobs/quickstart.toml"
started=$SECONDS
code=0
mpirun -n 2 "$scree" run jobs/quickstart.toml || code=$?
if [ "$code" -eq 4 ]; then
    echo "The run was stopped and has left a checkpoint. It goes on by: mpirun -n 2 $scree resume $run" >&2
    exit 4
elif [ "$code" -ne 0 ]; then
    echo "The run ended with code $code; its message is above." >&2
    exit "$code"
fi

echo "== Report"
"$scree" report "$run"
echo "Done: the run took $((SECONDS - started)) s on two ranks. Its figures are in $run/report.html (open it in a browser)," \
    "its curves in $run/series.csv, its frames for ParaView in $run/frames.vtkhdf."

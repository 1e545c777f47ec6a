#!/usr/bin/env bash
# A wheel that carries the program: threads, no MPI, HDF5 inside. Builds it, and tries it in a fresh virtual environment.
#
#     bash io/wheel.sh            a quarter of an hour on two cores the first time
#
# Needs a Rust toolchain, a C compiler and python3 with venv; maturin and cmake are fetched into the build folder. The wheel is for
# Linux with a glibc as new as that of this machine or newer: its name says which.
set -euo pipefail
cd "$(dirname "$0")"
root=$(cd .. && pwd)
work=${CARGO_TARGET_DIR:-target}/wheel
case $work in /*) ;; *) work=$root/$work ;; esac
mkdir -p "$work"
work=$(cd "$work" && pwd)

tools=$work/tools
if ! "$tools/bin/maturin" --version >/dev/null 2>&1 || ! "$tools/bin/cmake" --version >/dev/null 2>&1; then
    python3 -m venv "$tools"
    "$tools/bin/python" -m pip install -q 'maturin>=1.7,<2' 'cmake>=3.20,<4'
fi
rm -f "$work"/*.whl
PATH=$tools/bin:$PATH maturin build --out "$work" --target-dir "$work/build"
wheel=$(ls "$work"/*.whl)
size=$(stat -c %s "$wheel")

# In a new environment, from the wheel alone; mpirun, HDF5 and Rust are not in its PATH.
fresh=$(mktemp -d)
trap 'rm -rf "$fresh"' EXIT
python3 -m venv "$fresh/venv"
started=$SECONDS
"$fresh/venv/bin/python" -m pip install -q "$wheel"
cd "$fresh"
export PATH=$fresh/venv/bin:/usr/bin:/bin
scree new element >element.toml
scree run element.toml --set grains.count=200 --set 'cell.upper=["1.8 cm", "1.8 cm"]' --out run >/dev/null
took=$((SECONDS - started))
python - <<'END'
import scree
run = scree.Run("run")
assert run.summary["outcome"] == "done" and run.series["time"].iloc[-1] > 0.0999, run.summary
assert len(run.frames[-1].grains["velocity"]) == 200
print(scree.run("element.toml", {"time.end": "1 ms"}, out="second").summary["program"])
END
scree report run
echo "$wheel: $((size / 1000000)) MB; installed and a first run done in $took s."
[ "$size" -lt 25000000 ] || { echo "The wheel is larger than 25 MB." >&2; exit 1; }

#!/usr/bin/env python3
"""What `scree check` says that jobs take, against what they take on one core of this machine.

    tests/forecasts.py SECONDS JOB...    a table of docs/validation/forecasts.md

Each job is run for so many seconds at most. The time of its steps is what those that were done took, times all over those that were done;
of a hybrid only a run that came to its end says anything, since grains enter on the way. Packings in the cache are used, so that making
them is not part of it; the first run of a job makes its own. Neither side counts the time for which it waited for a core that others had. SCREE is the program, target/release/scree by default.
"""

import json
import os
import re
import subprocess
import sys
import tempfile

SCREE = os.environ.get("SCREE", "target/release/scree")
FACTOR = 1.5


def row(page, label):
    """The number of a row of the page, whose value is either one number or hours (seconds s)."""
    found = re.search(rf"^  {re.escape(label)} +(?:[\d.,e-]+ (?:h|min) \()?([\d.,e-]+)", page, re.MULTILINE)
    return float(found.group(1).replace(",", "")) if found else None


def measured(job, seconds, folder):
    limit = f"0:{seconds // 60}:{seconds % 60:02d}"
    command = [SCREE, "run", job, "--threads", "1", "--out", folder, "--time-limit", limit]
    with tempfile.TemporaryFile("w+") as said:
        run = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=said, text=True)
        # Once it has ended, and before it is gone.
        os.waitid(os.P_PID, run.pid, os.WEXITED | os.WNOWAIT)
        waited = waited_of(run.pid)
        code = run.wait()
        said.seek(0)
        words = said.read().strip().splitlines()
    if code not in (0, 4):
        return None, words[-1]
    if not os.path.exists(f"{folder}/summary.json"):
        return None, "stopped while its packing was made"
    with open(f"{folder}/summary.json") as file:
        summary = json.load(file)
    summary["wall_seconds"] -= waited
    return summary, "whole" if code == 0 else "part"


def waited_of(process):
    """Seconds for which the first thread of a process has waited for a core; zero where the system does not tell."""
    try:
        with open(f"/proc/{process}/schedstat") as file:
            return 1e-9 * float(file.read().split()[1])
    except (OSError, IndexError):
        return 0.0


def main():
    seconds, jobs = int(sys.argv[1]), sys.argv[2:]
    print("| job | forecast | measured | ratio | |\n|---|---|---|---|---|")
    beyond = 0
    for job in jobs:
        page = subprocess.run([SCREE, "check", job, "--quick", "--threads", "1"], capture_output=True, text=True, check=True).stdout
        forecast, steps = row(page, "time to run"), row(page, "steps")
        with tempfile.TemporaryDirectory() as folder:
            summary, words = measured(job, seconds, f"{folder}/run")
        if summary is None or summary["steps"] == 0 or forecast is None:
            print(f"| `{job}` | {forecast} s | | | {words} |", flush=True)
            continue
        took = summary["wall_seconds"] * steps / summary["steps"]
        ratio = forecast / took
        beyond += not 1 / FACTOR <= ratio <= FACTOR
        print(f"| `{job}` | {forecast:.4g} s | {took:.4g} s | {ratio:.2f} | {words} |", flush=True)
    sys.exit(f"{beyond} beyond a factor of {FACTOR}" if beyond else 0)


if __name__ == "__main__":
    main()

"""Runs started from Python, by the program."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from scree.runs import Run


class Failed(RuntimeError):
    """The program refused a job or stopped; its message is what it said."""


def _toml(value: Any) -> str:
    if isinstance(value, (np.generic, np.ndarray)):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (str, Path)):
        # Strings of JSON are strings of TOML.
        return json.dumps(str(value), ensure_ascii=False)
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key} = {_toml(part)}" for key, part in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, (int, float)):
        return repr(value)
    raise TypeError(f"{value!r} is nothing that a job has: write a number, a truth value, a string, a list or a table")


def run(
    job: str | Path,
    overrides: Mapping[str, Any] | None = None,
    *,
    out: str | Path,
    program: str | Path = "scree",
    threads: int | None = None,
    mpirun: list[str] | None = None,
) -> Run:
    """Runs a job and returns it. `overrides` are keys by their paths, {"loading.speed": "5 cm/s", "seed": 2}, as of `scree run --set`; `mpirun` is what stands before the program, for example
    ["mpirun", "-n", "4"]. Raises :class:`Failed` with what the program said where it refused the job or stopped."""
    command = [*(mpirun or []), str(program), "run", str(job), "--out", str(out)]
    if threads is not None:
        command += ["--threads", str(threads)]
    for key, value in (overrides or {}).items():
        command += ["--set", f"{key}={_toml(value)}"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise Failed((done.stderr or done.stdout).strip())
    return Run(out)

"""The folder of a run."""

from __future__ import annotations

import json
import re
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from scree.checkpoints import Checkpoint
from scree.frames import Frames
from scree.units import unit_of

try:
    import tomllib
except ModuleNotFoundError:  # before Python 3.11
    import tomli as tomllib  # type: ignore[no-redef]


class Run:
    """A run by its folder. It may still be going: what is read is what is there when it is first asked for."""

    def __init__(self, folder: str | Path):
        self.folder = Path(folder)
        if not (self.folder / "scenario.toml").is_file():
            raise FileNotFoundError(f"{self.folder} is no folder of a run: it has no scenario.toml")

    def __repr__(self) -> str:
        return f"Run({str(self.folder)!r})"

    @cached_property
    def job(self) -> dict[str, Any]:
        """The job with every default, in SI units."""
        return tomllib.loads((self.folder / "scenario.toml").read_text())

    @cached_property
    def series(self) -> pd.DataFrame:
        """`series.csv`, a column for each of its columns and a row for each of its rows."""
        path = self.folder / "series.csv"
        with open(path) as file:
            names = file.readline().strip().split(",")
            # Numbers as they were written, to the bit. A run that is going may have written half of its last row.
            rows = [line.split(",") for line in file if line.endswith("\n")]
        return pd.DataFrame(np.array(rows, dtype=float).reshape(-1, len(names)), columns=names)

    @property
    def units(self) -> dict[str, str]:
        """The unit of each column of the series; "" of one that is not known."""
        return {name: unit_of(name) or "" for name in self.series.columns}

    @cached_property
    def summary(self) -> dict[str, Any]:
        """`summary.json`: how the run ended, what it conserved, where the time went."""
        return json.loads((self.folder / "summary.json").read_text())

    @cached_property
    def log(self) -> list[dict[str, Any]]:
        """The events of `log.jsonl`, in their order."""
        lines = (self.folder / "log.jsonl").read_text().split("\n")
        # What is behind the last end of a line a run that is going has not written to its end.
        return [json.loads(line) for line in lines[:-1]]

    def events(self, name: str) -> list[dict[str, Any]]:
        """Those of one name, for example "enriched"."""
        return [event for event in self.log if event["event"] == name]

    @cached_property
    def frames(self) -> Frames:
        """Grains and points over time."""
        return Frames(self.folder / "frames.vtkhdf")

    @cached_property
    def contacts(self) -> Frames:
        """Contacts that bear force over time, of a job with `[output] contact_frames = true`."""
        return Frames(self.folder / "contacts.vtkhdf")

    @cached_property
    def elements(self) -> Frames:
        """Elements over time, of a job with `[mesh]`."""
        return Frames(self.folder / "elements.vtkhdf")

    def rve_grains(self, point: str) -> Frames:
        """The grains of the RVE of a followed point over time."""
        return Frames(self.folder / f"grains_of_{point}.vtkhdf")

    def rve_contacts(self, point: str) -> Frames:
        """Their contacts that bear force."""
        return Frames(self.folder / f"contacts_of_{point}.vtkhdf")

    @property
    def checkpoints(self) -> list[Checkpoint]:
        """All that are kept, by step; those that are kept for good among them."""
        files = {re.sub(r"\D", "", path.name[:-3]): path for path in sorted(self.folder.glob("checkpoints/**/step-*.h5"))}
        return [Checkpoint(files[step]) for step in sorted(files)]

    @property
    def comparison(self) -> dict[str, Any]:
        """What `scree report` of several runs measured, where its page stands in this folder."""
        return json.loads((self.folder / "comparison.json").read_text())

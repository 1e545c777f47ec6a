"""Checkpoints: the whole state of a run at a step, as tables."""

from __future__ import annotations

import re
from pathlib import Path

import h5py
import numpy as np
import pandas as pd


class Checkpoint:
    """The tables of a checkpoint: `grains`, `points`, `contacts`, `bodies` and so on. Numbers are SI; vectors and tensors have their components
    in columns of their own, name_0, name_1 and so on, a tensor's column by column."""

    def __init__(self, path: str | Path):
        self.path = Path(path)
        self.step = int(re.sub(r"\D", "", self.path.name[:-3]))
        with h5py.File(self.path, "r") as file:
            #: Names of the tables.
            self.tables = sorted(file["tables"])
            #: The job that it is of.
            # Short texts are attributes.
            text = file.attrs.get("scenario")
            self.job = bytes(file["text/scenario"][:].ravel() if text is None else text).decode()

    def __repr__(self) -> str:
        return f"Checkpoint({str(self.path)!r})"

    def columns(self, table: str) -> dict[str, np.ndarray]:
        """The columns of a table (rows, components)."""
        with h5py.File(self.path, "r") as file:
            return {name: file[f"tables/{table}/{name}"][:] for name in sorted(file[f"tables/{table}"])}

    def table(self, name: str) -> pd.DataFrame:
        """A table with a column for each component."""
        parts = {}
        for column, values in self.columns(name).items():
            single = values.ndim == 1 or values.shape[1] == 1
            for component in range(1 if single else values.shape[1]):
                parts[column if single else f"{column}_{component}"] = values.reshape(len(values), -1)[:, component]
        return pd.DataFrame(parts)

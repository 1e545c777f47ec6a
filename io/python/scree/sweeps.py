"""The runs of a sweep."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from scree.ensembles import Ensemble
from scree.runs import Run


def _is(cell: object, value: object) -> bool:
    try:
        return float(cell) == float(value)
    except (TypeError, ValueError):
        return str(cell).lower() == str(value).lower() if isinstance(cell, bool) or isinstance(value, bool) else str(cell) == str(value)


class Sweep:
    """What `scree sweep` has left in a folder.

    >>> sweep = scree.Sweep("runs/planar_shear_sweep")
    >>> sweep.table[["seed", "contact.friction", "peak_pa"]]
    >>> sweep.ensemble({"contact.friction": 0.5}).curve("strain", "shear_stress", at)      # over all seeds
    """

    def __init__(self, folder: str | Path):
        self.folder = Path(folder)
        path = self.folder / "sweep.csv"
        if not path.is_file():
            raise FileNotFoundError(f"{self.folder} is no folder of a sweep: there is no {path}")
        #: `sweep.csv`: a line for each run with the keys that vary, its state and cause, and what came out (SI units).
        self.table: pd.DataFrame = pd.read_csv(path, index_col="row", keep_default_na=True)

    def __len__(self) -> int:
        return len(self.table)

    def rows(self, values: dict[str, object] | None = None, state: str = "done") -> pd.DataFrame:
        """Lines of the table of that state, with these values of keys; numbers are compared as numbers, all else as it was typed."""
        rows = self.table[self.table["state"] == state]
        for key, value in (values or {}).items():
            if key not in self.table.columns:
                raise KeyError(f"{key} does not vary in {self.folder}; these do: {', '.join(self.keys)}")
            rows = rows[[_is(cell, value) for cell in rows[key]]]
        return rows

    @property
    def keys(self) -> list[str]:
        """The keys that vary."""
        columns = list(self.table.columns)
        return columns[columns.index("run") + 1 : columns.index("state")]

    def runs(self, values: dict[str, object] | None = None) -> list[Run]:
        """The runs that are done, with these values of keys."""
        return [Run(self.folder / name) for name in self.rows(values)["run"]]

    def ensemble(self, values: dict[str, object] | None = None) -> Ensemble:
        """The same, to take means of."""
        return Ensemble(self.runs(values))

"""Several runs together."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pandas as pd

from scree.runs import Run


def mean_curve(curves: Iterable[tuple[np.ndarray, np.ndarray]], at: np.ndarray, width: float = 0.0) -> pd.DataFrame:
    """Curves (x, y) at the same places `at`: their mean, the standard deviation of single ones and the standard error of the mean. With `width` each is a moving average over that
    much of x first, else it is interpolated. Where not all have come so far there is no number."""
    rows = []
    for x, y in curves:
        x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        if width > 0:
            averaged = [y[np.abs(x - place) < 0.5 * width] for place in at]
            row = np.array([values.mean() if len(values) else np.nan for values in averaged])
        else:
            row = np.interp(at, x, y)
        row[(at < x[0]) | (at > x[-1])] = np.nan
        rows.append(row)
    if not rows:
        raise ValueError("there is no curve")
    table = np.array(rows)
    spread = table.std(axis=0, ddof=1) if len(table) > 1 else np.full(len(at), np.nan)
    return pd.DataFrame({"mean": table.mean(axis=0), "deviation": spread, "error": spread / np.sqrt(len(table))}, index=pd.Index(at, name="x"))


class Ensemble:
    """Runs of one kind, for example the packings of a specimen."""

    def __init__(self, runs: Iterable[Run | str | Path]):
        self.runs = [run if isinstance(run, Run) else Run(run) for run in runs]
        if not self.runs:
            raise ValueError("an ensemble has one run at least")

    def __len__(self) -> int:
        return len(self.runs)

    def curve(self, x: str, y: str, at: np.ndarray, width: float = 0.0) -> pd.DataFrame:
        """Mean, deviation and standard error of a column of the series over another; see :func:`mean_curve`."""
        return mean_curve(((run.series[x].to_numpy(), run.series[y].to_numpy()) for run in self.runs), at, width)

    def summary(self, *path: str) -> pd.Series:
        """A number of `summary.json` of each run, by its folder; `path` leads to it, for example "conservation", "mass", "error"."""
        values = []
        for run in self.runs:
            value = run.summary
            for key in path:
                value = value[key]
            values.append(value)
        return pd.Series(values, index=[str(run.folder) for run in self.runs])

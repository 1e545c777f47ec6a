#!/usr/bin/env python3
"""A column of the series over another, of several runs with their mean: figure 10 of Chen et al. (2021) from runs of jobs/planar_shear.toml, for example.

    curves.py strain shear_stress curves.png GROUP=RUN... [GROUP=RUN...]

Runs of one GROUP are drawn thin, in one colour, and the mean of several of them thick."""

import sys
from collections import defaultdict

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import scree


def main(x: str, y: str, out: str, *named: str) -> None:
    groups = defaultdict(list)
    for name in named:
        group, run = name.split("=", 1)
        groups[group].append(scree.Run(run))
    figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
    for number, (group, runs) in enumerate(groups.items()):
        colour = f"C{number}"
        for run in runs:
            axes.plot(run.series[x], run.series[y], color=colour, linewidth=0.6, alpha=0.5)
        at = np.linspace(0, min(run.series[x].iloc[-1] for run in runs), 200)
        mean = scree.Ensemble(runs).curve(x, y, at, width=at[-1] / 40)
        axes.plot(at, mean["mean"], color=colour, linewidth=2, label=f"{group} ({len(runs)})")
    unit = {name: scree.unit_of(name) for name in (x, y)}
    axes.set_xlabel(f"{x} ({unit[x]})")
    axes.set_ylabel(f"{y} ({unit[y]})")
    axes.set_xlim(left=0)
    axes.legend(frameon=False)
    figure.savefig(out, dpi=150)


if __name__ == "__main__":
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    main(*sys.argv[1:])

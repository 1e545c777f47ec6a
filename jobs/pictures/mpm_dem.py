#!/usr/bin/env python3
"""Draws jobs/pictures/mpm_dem.png: where a specimen of RVEs has sheared, and the force chains of two of its points.

    scree export RUN --rve NAME --rve-frame NAME.vtkhdf      for both points
    jobs/pictures/mpm_dem.py RUN NAME.vtkhdf NAME.vtkhdf

Python with h5py, numpy and matplotlib."""

import sys

import h5py
import matplotlib
import numpy

matplotlib.use("Agg")
import matplotlib.pyplot as plot
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.patches import Circle


def frame(path, last=True):
    with h5py.File(path) as file:
        group = file["VTKHDF"]
        step = -1 if last else 0
        start, rows = group["Steps/PointOffsets"][step], group["NumberOfPoints"][step]
        points = group["Points"][start : start + rows]
        data = {name: values[:] for name, values in group["PointData"].items()} if "PointData" in group else {}
        lines = {name: values[:] for name, values in group["CellData"].items()} if "CellData" in group else {}
        return points, {name: values[start : start + rows] for name, values in data.items()}, lines


def main(run, *elements):
    figure, axes = plot.subplots(1, 1 + len(elements), figsize=(4 + 4 * len(elements), 5.2), layout="constrained")
    points, data, _ = frame(f"{run}/frames.vtkhdf")
    strain = data["plastic_strain"]
    drawn = axes[0].scatter(
        points[:, 0], points[:, 1], c=strain, s=14, cmap="magma", vmax=numpy.percentile(strain, 99)
    )
    figure.colorbar(drawn, ax=axes[0], label="accumulated deviatoric strain", shrink=0.8)
    axes[0].set(aspect="equal", xlabel="x, m", ylabel="y, m", title="a grain assembly at every point")
    for axis, path in zip(axes[1:], elements):
        places, grains, _ = frame(path)
        discs = [Circle(place[:2], radius) for place, radius in zip(places, grains["radius"])]
        axis.add_collection(PatchCollection(discs, facecolor="0.92", edgecolor="0.8", linewidth=0.3))
        ends, _, lines = frame(path.replace(".vtkhdf", ".contacts.vtkhdf"))
        force = lines["force_normal"]
        width = 5 * force / numpy.percentile(force, 99)
        chains = LineCollection(ends.reshape(-1, 2, 3)[:, :, :2], linewidths=width, colors="tab:red", alpha=0.8)
        axis.add_collection(chains)
        axis.autoscale()
        axis.set(aspect="equal", xticks=[], yticks=[], title=path.split('/')[-1].split('.')[0])
    figure.savefig("jobs/pictures/mpm_dem.png", dpi=110)


main(*sys.argv[1:])

#!/usr/bin/env python3
"""Draws jobs/pictures/mpm_dem.png: where material of RVEs has sheared, and the force chains of points that are followed.

    jobs/pictures/mpm_dem.py RUN NAME NAME

Python with h5py, numpy and matplotlib."""

import sys

import h5py
import matplotlib
import numpy

matplotlib.use("Agg")
import matplotlib.pyplot as plot
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.patches import Circle


def last(path):
    """Places of the last frame, and what it has of them; of lines the ends, and what there is of each."""
    with h5py.File(path) as file:
        group = file["VTKHDF"]
        start, count = group["Steps/PointOffsets"][-1], group["NumberOfPoints"][-1]
        of_points = group.get("PointData", {})
        data = {name: values[start : start + count] for name, values in of_points.items()}
        of_lines = group.get("CellData", {})
        lines = {name: values[start // 2 : (start + count) // 2] for name, values in of_lines.items()}
        whole = {name: values[-1] for name, values in group.get("FieldData", {}).items()}
        return group["Points"][start : start + count], {**data, **lines}, whole, group["Steps/Values"][-1]


def main(run, *names):
    places, points, _, time = last(f"{run}/frames.vtkhdf")
    # As wide as it is high against the RVEs, which are square.
    share = numpy.ptp(places[:, 0]) / numpy.ptp(places[:, 1])
    figure, axes = plot.subplots(
        1, 1 + len(names), figsize=(3.6 * (share + len(names)), 4.4), width_ratios=[share] + [1] * len(names), layout="constrained"
    )
    strain = points["deviatoric_strain"]
    size = (260 * numpy.sqrt(numpy.ptp(places[:, 0]) * numpy.ptp(places[:, 1]) / len(places)) / numpy.ptp(places[:, 1])) ** 2
    drawn = axes[0].scatter(
        places[:, 0], places[:, 1], c=strain, s=1.1 * size, marker="s", linewidths=0, cmap="magma", vmin=0, vmax=numpy.percentile(strain, 99)
    )
    figure.colorbar(drawn, ax=axes[0], label="deviatoric strain", shrink=0.8)
    axes[0].set(aspect="equal", xlabel="x, m", ylabel="y, m", title=f"a grain assembly at every point, {time:.1f} s")
    for axis, name in zip(axes[1:], names):
        places, grains, whole, _ = last(f"{run}/grains_of_{name}.vtkhdf")
        discs = [Circle(place[:2], radius) for place, radius in zip(places, grains["radius"])]
        axis.add_collection(PatchCollection(discs, facecolor="0.92", edgecolor="0.8", linewidth=0.3))
        ends, lines, _, _ = last(f"{run}/contacts_of_{name}.vtkhdf")
        force = lines["force_normal"]
        chains = ends.reshape(-1, 2, 3)[:, :, :2]
        axis.add_collection(LineCollection(chains, linewidths=numpy.minimum(1.1 * force / force.mean(), 8), colors="tab:red", alpha=0.8))
        a, b = whole["cell_edges"].reshape(3, 3)[:2, :2]
        corners = numpy.array([0 * a, a, a + b, b, 0 * a])
        axis.plot(*corners.T, color="0.2", linewidth=1)
        axis.autoscale()
        axis.set(aspect="equal", xticks=[], yticks=[], title=name)
    figure.savefig("jobs/pictures/mpm_dem.png", dpi=100)


main(*sys.argv[1:])

#!/usr/bin/env python3
"""Draws jobs/pictures/fem_dem.png: elements of a run as they are at the last frame, by deviatoric strain and by void ratio.

    jobs/pictures/fem_dem.py RUN

Python with h5py, numpy and matplotlib."""

import sys

import h5py
import matplotlib
import numpy

matplotlib.use("Agg")
import matplotlib.pyplot as plot
from matplotlib.collections import PolyCollection


def main(run):
    with h5py.File(f"{run}/elements.vtkhdf") as file:
        group = file["VTKHDF"]
        start, count = group["Steps/PointOffsets"][-1], group["NumberOfPoints"][-1]
        corners = group["Points"][start : start + count].reshape(-1, 4, 3)
        data = {name: values[start // 4 : (start + count) // 4] for name, values in group["CellData"].items()}
        time = group["Steps/Values"][-1]
    # Sides that are seen along z.
    low = corners[:, :, 2].min()
    seen = (corners[:, :, 2] < low + 1e-3 * numpy.ptp(corners[:, :, 2])).all(axis=1)
    figure, axes = plot.subplots(1, 2, figsize=(6.4, 5.2), layout="constrained")
    for panel, (name, words) in zip(axes, [("deviatoric_strain", "deviatoric strain"), ("void_ratio", "void ratio")]):
        drawn = PolyCollection(1e3 * corners[seen][:, :, :2], array=data[name][seen], edgecolor="k", linewidth=0.4)
        panel.add_collection(drawn)
        panel.set_aspect("equal")
        panel.autoscale_view()
        panel.set_xlabel("x (mm)")
        figure.colorbar(drawn, ax=panel, label=words)
    axes[0].set_ylabel("y (mm)")
    figure.suptitle(f"{1e3 * time:.0f} ms", fontsize=10)
    figure.savefig("jobs/pictures/fem_dem.png", dpi=130)


main(*sys.argv[1:])

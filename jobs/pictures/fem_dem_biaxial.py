#!/usr/bin/env python3
"""Draws jobs/pictures/fem_dem_biaxial.png: runs of jobs/fem_dem/biaxial.toml on several meshes, their elements by deviatoric strain at one time, and their curves.

    jobs/pictures/fem_dem_biaxial.py TIME RUN=NAME...

Python with h5py, numpy and matplotlib."""

import csv
import sys

import h5py
import matplotlib
import numpy

matplotlib.use("Agg")
import matplotlib.pyplot as plot
from matplotlib.collections import PolyCollection

WIDTH, DEPTH, HEIGHT, PRESSURE = 0.04, 0.005, 0.08, 416e3


def elements(run, time):
    with h5py.File(f"{run}/elements.vtkhdf") as file:
        group = file["VTKHDF"]
        frame = int(numpy.argmin(abs(group["Steps/Values"][:] - time)))
        start, count = group["Steps/PointOffsets"][frame], group["NumberOfPoints"][frame]
        corners = group["Points"][start : start + count].reshape(-1, 4, 3)
        strain = group["CellData/deviatoric_strain"][start // 4 : (start + count) // 4]
    # Sides that look along -z, by the product of their diagonals.
    area = numpy.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    seen = area[:, 2] < -0.9 * numpy.linalg.norm(area, axis=1)
    return corners[seen][:, :, :2], strain[seen]


def curve(run):
    with open(f"{run}/series.csv", newline="") as file:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    strain = [-100 * row["top_displacement_y"] / HEIGHT for row in rows]
    return strain, [row["top_force_y"] / (WIDTH * DEPTH * PRESSURE) for row in rows]


def main(time, *runs):
    runs = [run.split("=", 1) for run in runs]
    figure, axes = plot.subplots(1, len(runs) + 1, figsize=(2.1 * len(runs) + 3.6, 3.6), layout="constrained", width_ratios=[1] * len(runs) + [2])
    for panel, (run, name) in zip(axes, runs):
        corners, strain = elements(run, float(time))
        drawn = PolyCollection(1e3 * corners, array=strain, edgecolor="k", linewidth=0.3, clim=(0, 0.35))
        panel.add_collection(drawn)
        panel.set_aspect("equal")
        panel.autoscale_view()
        panel.set_title(name, fontsize=9)
        panel.set_xlabel("x (mm)")
        axes[-1].plot(*curve(run), linewidth=0.9, label=name)
    axes[0].set_ylabel("y (mm)")
    figure.colorbar(drawn, ax=axes[:-1], label="deviatoric strain", shrink=0.8)
    axes[-1].set(xlabel="axial strain (%)", ylabel="axial over lateral stress", xlim=(0, 5), ylim=(1, 4))
    axes[-1].legend(fontsize=8)
    figure.savefig("jobs/pictures/fem_dem_biaxial.png", dpi=110)


main(*sys.argv[1:])

#!/usr/bin/env python3
"""Draws jobs/pictures/five_methods.png: one specimen in biaxial compression by five methods, by deviatoric strain at one time, and the stress on its plate.

    jobs/pictures/five_methods.py TIME RUN=NAME...

Python with h5py, numpy and matplotlib."""

import csv
import sys

import h5py
import matplotlib
import numpy

matplotlib.use("Agg")
import matplotlib.pyplot as plot
from matplotlib.collections import CircleCollection

WIDTH, DEPTH, HEIGHT = 1.0, 0.1, 2.0
GRAIN = 1


def rows(run, time):
    """Places, radii (none of points) and deviatoric strains of points and grains in the frame nearest to a time."""
    with h5py.File(f"{run}/frames.vtkhdf") as file:
        group = file["VTKHDF"]
        frame = int(numpy.argmin(abs(group["Steps/Values"][:] - time)))
        start, count = group["Steps/PointOffsets"][frame], group["NumberOfPoints"][frame]
        part = slice(start, start + count)
        kind = group["PointData/kind"][part]
        wanted = kind <= GRAIN
        radius = numpy.where(kind == GRAIN, group["PointData/radius"][part], 0.0)[wanted]
        return group["Points"][part][wanted][:, :2], radius, group["PointData/deviatoric_strain"][part][wanted]


def curve(run):
    with open(f"{run}/series.csv", newline="") as file:
        table = [{name: float(row[name]) for name in ("plate_displacement_y", "plate_force_y")} for row in csv.DictReader(file)]
    return [-100 * row["plate_displacement_y"] / HEIGHT for row in table], [1e-3 * row["plate_force_y"] / (WIDTH * DEPTH) for row in table]


def main(time, *runs):
    runs = [run.split("=", 1) for run in runs]
    figure, axes = plot.subplots(1, len(runs) + 1, figsize=(1.55 * len(runs) + 4.2, 3.9), layout="constrained", width_ratios=[1] * len(runs) + [2.6])
    for panel, (run, name) in zip(axes, runs):
        place, radius, strain = rows(run, float(time))
        points = radius == 0
        if points.any():
            # They share what grains leave of the specimen.
            radius[points] = 0.55 * numpy.sqrt((WIDTH * HEIGHT - 3.7 * (radius**2).sum()) / points.sum())
        panel.set(xlim=(-0.1, 1.1), ylim=(0, 2))
        panel.set_aspect("equal")
        # Areas of circles are in points of print.
        inch = panel.get_window_extent().width / figure.dpi / 1.2
        drawn = CircleCollection(numpy.pi * (72 * inch * radius) ** 2, offsets=place, offset_transform=panel.transData, array=strain, clim=(0, 0.5), linewidth=0)
        panel.add_collection(drawn)
        panel.set_title(name, fontsize=8)
        panel.tick_params(labelsize=7)
        axes[-1].plot(*curve(run), linewidth=0.9, label=name.replace("\n", " "))
    for panel in axes[1:-1]:
        panel.set_yticklabels([])
    figure.colorbar(drawn, ax=axes[:-1], label="deviatoric strain", shrink=0.7, location="left")
    axes[-1].set(xlabel="axial strain (%)", ylabel="stress on the plate (kPa)", xlim=(0, 5), ylim=(90, 300))
    axes[-1].legend(fontsize=7)
    figure.savefig("jobs/pictures/five_methods.png", dpi=110)


main(*sys.argv[1:])

#!/usr/bin/env python3
"""Draws jobs/pictures/fem_dem_simple_shear.png: simple shear of elements with a grain assembly each against the same grains alone (Liu et al. 2016, figures 10
and 14): deviatoric strain at one strain, the displacement over the height there, and the shear stress.

    jobs/pictures/fem_dem_simple_shear.py STRAIN ELEMENTS GRAINS

Folders of runs of jobs/fem_dem/simple_shear.toml and dns_simple_shear.toml. Python with h5py, numpy and matplotlib."""

import csv
import sys

import h5py
import matplotlib
import numpy

matplotlib.use("Agg")
import matplotlib.pyplot as plot
from matplotlib.collections import PatchCollection, PolyCollection
from matplotlib.patches import Circle

HEIGHT, PRESSURE, LAYER = 0.118, 416e3, 0.00475


def series(run):
    with open(f"{run}/series.csv", newline="") as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


def frame_at(group, times, strains, wanted):
    reached = numpy.interp(group["Steps/Values"][:], times, strains)
    frame = int(numpy.argmin(abs(reached - wanted)))
    return frame, reached[frame]


def main(wanted, elements, grains):
    wanted = float(wanted)
    figure, axes = plot.subplots(1, 4, figsize=(11, 4.2), layout="constrained", width_ratios=[1, 1, 1, 2])

    rows = series(elements)
    strains = [row["top_displacement_x"] / HEIGHT for row in rows]
    stress = [abs(row["y_lower_force_x"]) / (0.0506 * 0.0127 * PRESSURE) for row in rows]
    axes[3].plot(100 * numpy.array(strains), stress, linewidth=1, label="60 elements")
    with h5py.File(f"{elements}/elements.vtkhdf") as file:
        group = file["VTKHDF"]
        frame, reached = frame_at(group, [row["time"] for row in rows], strains, wanted)
        start, count = group["Steps/PointOffsets"][frame], group["NumberOfPoints"][frame]
        corners = group["Points"][start : start + count].reshape(-1, 4, 3)
        first = group["Points"][:count].reshape(-1, 4, 3)
        offset = group["Steps/CellDataOffsets/deviatoric_strain"][frame]
        strain = group["CellData/deviatoric_strain"][offset : offset + count // 4]
    area = numpy.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    seen = area[:, 2] < -0.9 * numpy.linalg.norm(area, axis=1)
    axes[0].add_collection(PolyCollection(1e3 * corners[seen][:, :, :2], array=strain[seen], edgecolor="k", linewidth=0.3, clim=(0, 0.3)))
    axes[0].set_title(f"elements, {100 * reached:.2f} %", fontsize=9)
    height, way = first[..., 1].ravel(), (corners - first)[..., 0].ravel()
    levels = numpy.unique(height.round(6))
    axes[2].plot([1e3 * way[abs(height - level) < 1e-5].mean() for level in levels], 1e3 * levels, "o-", markersize=3, linewidth=1, label="elements")

    rows = series(grains)
    strains = [row["upper_displacement_x"] / HEIGHT for row in rows]
    area = rows[0]["edge_xx"] * rows[0]["edge_zz"]
    stress = numpy.array([abs(row["lower_force_x"]) / (area * PRESSURE) for row in rows])
    axes[3].plot(100 * numpy.array(strains), stress, linewidth=1, label="163,840 spheres")
    with h5py.File(f"{grains}/frames.vtkhdf") as file:
        group = file["VTKHDF"]
        frame, reached = frame_at(group, [row["time"] for row in rows], strains, wanted)
        rows_of = slice(*(group["Steps/PointOffsets"][frame] + numpy.array([0, group["NumberOfPoints"][frame]])))
        place, radius = group["Points"][rows_of], group["PointData/radius"][rows_of]
        strain, way = group["PointData/deviatoric_strain"][rows_of], group["PointData/displacement"][rows_of]
    front = numpy.flatnonzero(place[:, 2] > 0.8 * place[:, 2].max())
    circles = [Circle((1e3 * place[row, 0], 1e3 * (place[row, 1] - LAYER)), 1e3 * radius[row]) for row in front]
    drawn = PatchCollection(circles, linewidth=0)
    drawn.set_array(strain[front])
    drawn.set_clim(0, 0.3)
    axes[1].add_collection(drawn)
    axes[1].set_title(f"grains alone, {100 * reached:.2f} %", fontsize=9)
    height = place[:, 1] - way[:, 1] - LAYER
    bins = numpy.linspace(0, HEIGHT, 49)
    inside = [(height >= a) & (height < b) for a, b in zip(bins, bins[1:])]
    axes[2].plot([1e3 * way[some, 0].mean() for some in inside], 1e3 * (bins[1:] + bins[:-1]) / 2, linewidth=1, label="grains")

    for panel in axes[:2]:
        panel.set_aspect("equal")
        panel.autoscale_view()
        panel.set_xlabel("x (mm)")
    axes[0].set_ylabel("height (mm)")
    axes[2].set(xlabel="displacement (mm)", ylim=axes[0].get_ylim())
    axes[2].legend(fontsize=8)
    figure.colorbar(drawn, ax=axes[:2], label="deviatoric strain", shrink=0.8)
    axes[3].set(xlabel="shear strain (%)", ylabel="shear stress over 416 kPa", xlim=(0, None), ylim=(0, None))
    axes[3].legend(fontsize=8)
    figure.savefig("jobs/pictures/fem_dem_simple_shear.png", dpi=110)


main(*sys.argv[1:])

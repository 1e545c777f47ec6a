#!/usr/bin/env python3
"""Contacts that bear force, as wide as they bear, over the grains of a run in the plane; of a job with `[output] contact_frames = true`.

    force_chains.py RUN force_chains.png [TIME in s; default: the last frame]"""

import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection, LineCollection

import scree


def main(folder: str, out: str, time: str = "inf") -> None:
    run = scree.Run(folder)
    time = min(float(time), run.frames.times[-1])
    grains, contacts = run.frames.at(time).grains, run.contacts.at(time)
    figure, axes = plt.subplots(figsize=(6, 6), layout="constrained")
    diameters = 2 * grains["radius"]
    axes.add_collection(
        EllipseCollection(diameters, diameters, np.zeros(len(grains)), units="xy", offsets=grains.positions[:, :2], offset_transform=axes.transData, facecolors="0.92", edgecolors="0.75", linewidths=0.3)
    )
    force = np.linalg.norm(contacts["force"], axis=1)
    chains = contacts.places[:, :, :2]
    axes.add_collection(LineCollection(chains, linewidths=1.5 * force / force.mean(), colors="firebrick", capstyle="round"))
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    axes.set_title(f"{run.job['name']}, {grains.time:.4g} s; mean force {force.mean():.3g} N")
    figure.savefig(out, dpi=150)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])

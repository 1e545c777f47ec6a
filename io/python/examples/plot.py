#!/usr/bin/env python3
"""Figures from the folders of runs, those of the papers among them: docs/python.md has the line of each.

    plot.py curves OUT X Y GROUP=RUN...      Y over X, formulas of the columns of series.csv; "Y1; Y2" draws both. Runs of one GROUP have one colour, several of them their mean
    plot.py map OUT FIELD RUN...             grains, points or elements coloured by a field of the frames: a row for each run, a column for each of --times
    plot.py chains OUT RUN [POINT...]        contacts, as wide as the force they bear, over the grains: of the run, or of the RVEs of followed points
    plot.py paths OUT RUN POINT...           displacement of followed points over time, and their paths
    plot.py profile OUT FIELD RUN...         mean of a field over the height, by volume; of elements each counts as one
    plot.py mohr OUT RUN...                  Mohr's circles of biaxial tests of a cell at their largest q/p, and the line that touches them: friction angle and cohesion

--times T1,T2   s; or 25%,100% of the run. The last frame by default.
--since T       of map and profile: the growth of the field since then
--smooth N      of curves: moving average over N rows
--labels X,Y    of the axes of curves, in place of the formulas
"""

import argparse
import itertools
from collections import defaultdict
from collections.abc import Callable

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import Collection, EllipseCollection, LineCollection, PolyCollection

import scree

#: Of a frame, beside the fields that it has.
DERIVED: dict[str, Callable[[scree.Frame], np.ndarray]] = {
    "displacement": lambda frame: np.linalg.norm(frame["displacement"], axis=1),
    "velocity": lambda frame: np.linalg.norm(frame["velocity"], axis=1),
    "porosity": lambda frame: frame["void_ratio"] / (1 + frame["void_ratio"]) if "void_ratio" in frame.fields else np.where(frame["fraction"] > 0, 1 - frame["fraction"], np.nan),
    "shear_stress": lambda frame: frame["stress"][:, 2],
    "spin": lambda frame: np.linalg.norm(frame["spin"], axis=1),
}


def field(frame: scree.Frame, name: str) -> np.ndarray:
    """A number for each row."""
    single = sorted(key for key, column in frame.fields.items() if column.ndim == 1)
    if name not in DERIVED and name not in single:
        raise SystemExit(f"there is no field {name} of one number; there are {', '.join(single)}, and of {', '.join(sorted(DERIVED))} what the frame has the fields for")
    try:
        return DERIVED[name](frame) if name in DERIVED else frame[name]
    except KeyError as missing:
        raise SystemExit(f"{name} is reckoned from {missing}, which these frames lack") from None


def frames_of(run: scree.Run) -> scree.Frames:
    return run.elements if (run.folder / "elements.vtkhdf").exists() else run.frames


def moments(run: scree.Run, times: str | None) -> list[scree.Frame]:
    frames = frames_of(run)
    last = frames.times[-1]
    chosen = [last] if times is None else [last * float(time[:-1]) / 100 if time.endswith("%") else float(time) for time in times.split(",")]
    return [frames.at(time) for time in chosen]


def material(frame: scree.Frame) -> scree.Frame:
    """Without vertices of membranes."""
    return frame.where(frame["kind"] != scree.frames.VERTEX) if "kind" in frame.fields else frame


def growth(run: scree.Run, frame: scree.Frame, name: str, since: str | None) -> tuple[scree.Frame, np.ndarray]:
    """Rows that are there at both times, and the field less what it was; of velocities and displacements the difference of their magnitudes."""
    frame = material(frame)
    if since is None:
        return frame, field(frame, name)
    before = material(moments(run, since)[0])
    keys = lambda frame: zip(frame.fields.get("kind", np.zeros(len(frame))), frame["id"])
    rows = {key: row for row, key in enumerate(keys(before))}
    found = np.array([rows.get(key, -1) for key in keys(frame)], dtype=int)
    frame, found = frame.where(found >= 0), found[found >= 0]
    if not len(frame):
        raise SystemExit(f"{run.folder}: no grain, point or element is there at {before.time:.4g} s and later")
    return frame, field(frame, name) - field(before, name)[found]


def shapes(axes: Axes, frame: scree.Frame, values: np.ndarray | None, **style) -> Collection:
    """Discs of grains and points, quadrilaterals of elements, on the x-y plane."""
    if frame.places.shape[1] == 4:
        drawn = PolyCollection(frame.places[:, :, :2], array=values, **style)
    else:
        diameters = 2 * frame["radius"]
        offsets = frame.positions[:, :2]
        drawn = EllipseCollection(diameters, diameters, np.zeros(len(frame)), units="xy", offsets=offsets, offset_transform=axes.transData, array=values, **style)
    axes.add_collection(drawn)
    corners = frame.places[:, :, :2]
    reach = frame["radius"][:, None, None] if "radius" in frame.fields else 0.0
    axes.update_datalim([(corners - reach).min(axis=(0, 1)), (corners + reach).max(axis=(0, 1))])
    axes.set_aspect("equal")
    axes.autoscale_view()
    return drawn


def smoothed(run: scree.Run, formulas: tuple[str, str], rows: int) -> list[np.ndarray]:
    """Formulas of the columns, as moving averages over so many rows."""
    table = pd.DataFrame({name: run.series.eval(formula) + np.zeros(len(run.series)) for name, formula in zip("xy", formulas)})
    table = table.replace([np.inf, -np.inf], np.nan).rolling(rows, center=True).mean().dropna()
    return [table[name].to_numpy() for name in "xy"]


def labelled(formula: str, run: scree.Run) -> str:
    """A column with its unit, another formula as it is."""
    column = formula.removeprefix("0-")
    return f"{formula} ({scree.unit_of(column)})" if column in run.series and scree.unit_of(column) not in (None, "1") else formula


def curves(options: argparse.Namespace) -> plt.Figure:
    x, several, *named = options.arguments
    groups = defaultdict(list)
    for name in named:
        group, equals, run = name.partition("=")
        run = scree.Run(run if equals else name)
        groups[group if equals else run.folder.name].append(run)
    figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
    formulas = [formula.strip() for formula in several.split(";")]
    for style, y in zip(itertools.cycle(("-", "--", ":", "-.")), formulas):
        for number, (group, runs) in enumerate(groups.items()):
            drawn = [smoothed(run, (x, y), options.smooth) for run in runs]
            label, colour = (f"{group}, {y}" if len(formulas) > 1 else group), f"C{number}"
            if len(runs) == 1:
                axes.plot(*drawn[0], style, color=colour, label=label)
                continue
            for curve in drawn:
                axes.plot(*curve, style, color=colour, linewidth=0.6, alpha=0.5)
            at = np.linspace(max(curve[0].min() for curve in drawn), min(curve[0].max() for curve in drawn), 200)
            axes.plot(at, scree.mean_curve(drawn, at)["mean"], style, color=colour, linewidth=2, label=f"{label} (mean of {len(runs)})")
    first = next(iter(groups.values()))[0]
    left, _, right = (options.labels or "").partition(",")
    axes.set(xlabel=left or labelled(x, first), ylabel=right or labelled(several, first))
    axes.legend(frameon=False)
    return figure


def map_of(options: argparse.Namespace) -> plt.Figure:
    name, *folders = options.arguments
    rows = [[(run, *growth(run, frame, name, options.since)) for frame in moments(run, options.times)] for run in map(scree.Run, folders)]
    values = np.concatenate([of for row in rows for *_, of in row])
    # Single rows do not set the scale.
    least, most = np.percentile(values, [1, 99]) if len(values) else (0, 1)
    figure, axes = plt.subplots(len(rows), len(rows[0]), figsize=(3.2 * len(rows[0]) + 1, 3.6 * len(rows)), squeeze=False, layout="constrained")
    for line, row in zip(axes, rows):
        for place, (run, frame, of) in zip(line, row):
            drawn = shapes(place, frame, of, cmap="viridis", clim=(least, most))
            place.set_title(f"{run.folder.name}, {frame.time:.4g} s", fontsize=9)
    unit = frames_of(rows[0][0][0]).units.get(name, "")
    figure.colorbar(drawn, ax=axes, shrink=0.7, label=f"{name} ({unit})" if unit not in ("", "1") else name)
    return figure


def chains(options: argparse.Namespace) -> plt.Figure:
    folder, *points = options.arguments
    run = scree.Run(folder)
    sets = [(point, run.rve_grains(point), run.rve_contacts(point)) for point in points] or [(run.folder.name, run.frames, run.contacts)]
    figure, axes = plt.subplots(1, len(sets), figsize=(5 * len(sets), 5), squeeze=False, layout="constrained")
    for place, (name, frames, contacts) in zip(axes[0], sets):
        time = moments(run, options.times)[-1].time
        grains, lines = frames.at(time).grains, contacts.at(time)
        shapes(place, grains, None, facecolors="0.92", edgecolors="0.75", linewidths=0.3)
        force = np.linalg.norm(lines["force"], axis=1)
        mean = force.mean() if len(force) else 1.0
        place.add_collection(LineCollection(lines.places[:, :, :2], linewidths=1.5 * force / mean, colors="firebrick", capstyle="round"))
        place.set_title(f"{name}, {grains.time:.4g} s; mean force {mean:.3g} N", fontsize=9)
    return figure


def paths(options: argparse.Namespace) -> plt.Figure:
    folder, *points = options.arguments
    series = scree.Run(folder).series
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
    for number, point in enumerate(points):
        axes = [axis for axis in "xyz" if f"{point}_displacement_{axis}" in series]
        if not axes:
            raise SystemExit(f"{folder} follows no point {point}")
        for axis, style in zip(axes, ("-", "--", ":")):
            left.plot(series["time"], series[f"{point}_displacement_{axis}"], style, color=f"C{number}", label=f"{point}, {axis}")
        right.plot(*(series[f"{point}_displacement_{axis}"] for axis in axes[:2]), color=f"C{number}", label=point)
    left.set(xlabel="time (s)", ylabel="displacement (m)")
    right.set(xlabel="displacement along x (m)", ylabel="along y (m)", aspect="equal")
    left.legend(frameon=False)
    right.legend(frameon=False)
    return figure


def profile(options: argparse.Namespace) -> plt.Figure:
    name, *folders = options.arguments
    figure, axes = plt.subplots(figsize=(4.5, 5.5), layout="constrained")
    for run in map(scree.Run, folders):
        for frame in moments(run, options.times):
            frame, values = growth(run, frame, name, options.since)
            height = frame.positions[:, 1]
            # Elements have a row of their own for each height.
            rows = len(np.unique(height.round(9))) if frame.places.shape[1] == 4 else 40
            edges = np.linspace(height.min(), height.max() * (1 + 1e-12), min(rows, 40) + 1)
            inside = np.clip(np.digitize(height, edges) - 1, 0, len(edges) - 2)
            weight = frame["weight"] * frame["radius"] ** (2 if np.ptp(frame.positions[:, 2]) == 0 else 3) if "radius" in frame.fields else np.ones(len(frame))
            mean = np.bincount(inside, weight * values, len(edges) - 1) / np.maximum(np.bincount(inside, weight, len(edges) - 1), 1e-300)
            there = np.bincount(inside, minlength=len(edges) - 1) > 0
            axes.plot(mean[there], (0.5 * (edges[1:] + edges[:-1]))[there], label=f"{run.folder.name}, {frame.time:.4g} s")
    unit = frames_of(run).units.get(name, "")
    axes.set(xlabel=f"{name} ({unit})" if unit not in ("", "1") else name, ylabel="height (m)")
    axes.legend(frameon=False, fontsize=8)
    return figure


def envelope(circles: np.ndarray) -> tuple[float, float]:
    """Friction angle, rad, and cohesion, Pa, of circles (major, minor stress), compression positive: least squares of radius = middle sin(phi) + c cos(phi)."""
    middle, radius = circles.mean(axis=1), 0.5 * (circles[:, 0] - circles[:, 1])
    # Of one circle, or several about one middle, the line from the origin.
    if np.ptp(middle) <= 1e-3 * middle.max():
        return float(np.arcsin(radius.mean() / middle.mean())), 0.0
    slope, offset = np.polyfit(middle, radius, 1)
    angle = np.arcsin(slope)
    return float(angle), float(offset / np.cos(angle))


def mohr(options: argparse.Namespace) -> plt.Figure:
    circles = []
    for run in map(scree.Run, options.arguments):
        principal = np.linalg.eigvalsh(np.stack([[-run.series["stress_xx"], -run.series["stress_xy"]], [-run.series["stress_xy"], -run.series["stress_yy"]]]).T)
        ratio = (principal[:, 1] - principal[:, 0]) / principal.sum(axis=1)
        circles.append(principal[np.nanargmax(ratio[1:]) + 1, ::-1])
    circles = np.array(circles)
    angle, cohesion = envelope(circles)
    figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
    turn = np.linspace(0, np.pi, 200)
    for most, least in circles / 1e3:
        axes.plot(0.5 * (most + least) + 0.5 * (most - least) * np.cos(turn), 0.5 * (most - least) * np.sin(turn), color="C0")
    normal = np.array([0, circles.max() / 1e3])
    axes.plot(normal, cohesion / 1e3 + normal * np.tan(angle), color="C3", label=f"friction angle {np.degrees(angle):.1f} degrees, cohesion {cohesion / 1e3:.2g} kPa")
    axes.set(xlabel="normal stress (kPa)", ylabel="shear stress (kPa)", aspect="equal", ylim=(0, None))
    axes.legend(frameon=False)
    return figure


KINDS = {"curves": (curves, 3), "map": (map_of, 2), "chains": (chains, 1), "paths": (paths, 2), "profile": (profile, 2), "mohr": (mohr, 1)}


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, usage=argparse.SUPPRESS)
    parser.add_argument("kind", choices=KINDS)
    parser.add_argument("out")
    parser.add_argument("arguments", nargs="+")
    parser.add_argument("--times")
    parser.add_argument("--since")
    parser.add_argument("--smooth", type=int, default=1)
    parser.add_argument("--labels")
    options, unknown = parser.parse_known_args(arguments)
    if unknown:
        parser.error(f"there is no option {unknown[0]}; write a formula that begins with a minus as 0{unknown[0]}")
    draw, wanted = KINDS[options.kind]
    if len(options.arguments) < wanted:
        parser.error(f"{options.kind} wants more; see --help")
    draw(options).savefig(options.out, dpi=150)


if __name__ == "__main__":
    main()

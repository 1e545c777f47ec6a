#!/usr/bin/env python3
"""Figures of VALIDATION.md that are reckoned from series.csv; nothing but Python 3 is needed.

    tests/figures.py biaxial DIR...     peak of sigma_yy/sigma_xx, its strain, the late mean and the void ratio at the end
    tests/figures.py slope DIR...       slope of the mean stress, or of stress_yy, against strain: first tenth, and all

DIR is the folder of a run: of jobs/element/rve_biaxial.toml or rve_ensemble.toml, or of jobs/element/bulk.toml. Strains
are logarithmic, from the edges of the cell; of a biaxial test from time zero, of a slope from the first row.
"""

import csv
import math
import sys


def series(folder):
    with open(f"{folder}/series.csv", newline="") as file:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    if not rows:
        sys.exit(f"{folder}/series.csv has no rows")
    return rows


def mean(values):
    values = list(values)
    return sum(values) / len(values) if values else float("nan")


def biaxial(folder):
    """Compression along y at a rate, from time zero on; the first row is one interval later."""
    rows = series(folder)
    first, second = rows[0], rows[1]
    rate = math.log(second["edge_yy"] / first["edge_yy"]) / (second["time"] - first["time"])
    height = first["edge_yy"] / math.exp(rate * first["time"])
    points = [(math.log(height / row["edge_yy"]), row["stress_yy"] / row["stress_xx"]) for row in rows]
    strain, peak = max(points, key=lambda point: point[1])
    late = mean(ratio for along, ratio in points if 0.10 <= along <= 0.15)
    void = 1 / rows[-1]["fraction"] - 1
    print(f"{folder}: peak {peak:.3f} at {100 * strain:.2f} %, mean from 10 to 15 % {late:.3f}, void ratio {void:.4f}")


def fit(points):
    """Slope of the line of least squares."""
    x, y = mean(point[0] for point in points), mean(point[1] for point in points)
    below = sum((point[0] - x) ** 2 for point in points)
    return sum((point[0] - x) * (point[1] - y) for point in points) / below if below > 0 else float("nan")


def slope(folder):
    """K where both edges shrink, M where y alone does."""
    rows = series(folder)
    shrinks = [abs(rows[-1][f"edge_{i}{i}"] / rows[0][f"edge_{i}{i}"] - 1) > 1e-9 for i in "xy"]
    if shrinks == [True, True]:
        name = "K"
        stress = lambda row: -(row["stress_xx"] + row["stress_yy"]) / 2
        strain = lambda row: -math.log(row["edge_xx"] * row["edge_yy"])
    else:
        name, axis = ("M", "yy") if shrinks[1] else ("M", "xx")
        stress = lambda row: -row[f"stress_{axis}"]
        strain = lambda row: -math.log(row[f"edge_{axis}"])
    start = strain(rows[0])
    points = [(strain(row) - start, stress(row)) for row in rows]
    whole = points[-1][0]
    first = [point for point in points if point[0] <= 0.1 * whole]
    print(f"{folder}: {name} {1e-6 * fit(first):.1f} ({1e-6 * fit(points):.1f}) MPa over {100 * whole:.3f} %")


if __name__ == "__main__":
    commands = {"biaxial": biaxial, "slope": slope}
    if len(sys.argv) < 3 or sys.argv[1] not in commands:
        sys.exit(__doc__)
    for folder in sys.argv[2:]:
        commands[sys.argv[1]](folder)

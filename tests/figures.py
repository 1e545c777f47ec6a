#!/usr/bin/env python3
"""Figures of docs/validation that are reckoned from series.csv and frames.vtkhdf. Python 3.11 is needed, and for band,
collapse, outside, rest, planar, coupling and sheared h5py, which brings numpy.

    tests/figures.py biaxial DIR...     peak of sigma_yy/sigma_xx, its strain, the late mean and the void ratio at the end
    tests/figures.py held DIR...        how closely sigma_xx is held from 0.05 % of strain on, and the void ratio from 10 to 15 %
    tests/figures.py slope DIR...       slope of the mean stress, of stress_yy or of stress_xy against strain: first tenth, and all
    tests/figures.py footing DIR...     load on a strip footing over Prandtl's, mean of the second half of the settlement
    tests/figures.py bearing DIR...     load on a footing over the surcharge at settlements over its half width, and its first maximum
    tests/figures.py band DIR...        width of the shear band, in cells and in sections of a cell by its normal
    tests/figures.py elements DIR...    width of the shear band of elements in plane strain compression, and the curve
    tests/figures.py bins DIR...        the same of a specimen of grains, points or elements, by one measure for all of them
    tests/figures.py layers DIR...      simple shear between a bottom and a top: stresses over the pressure, where it shears, and the void ratio over the height
    tests/figures.py collapse DIR...    run-out of a column, and its energies over the potential energy at the start
    tests/figures.py outside DIR...     how far grains lie outside of membranes at the end, along the normals of these
    tests/figures.py rest DIR...        pressures of points at rest over the weight above them, and how far the material has come
    tests/figures.py planar DEM=DIR...  shear stress of a hybrid in planar shear off that of the same packing's grains alone
    tests/figures.py packings DIR...    the same of many packings in one folder, with intervals, places of bands and null models
    tests/figures.py everywhere DIR...  the same of hybrids whose zone begins everywhere (tests/everywhere.py)
    tests/figures.py coupling DIR...    normal stress of layers of cells in planar shear by a hybrid, and the stretch of its penalty springs
    tests/figures.py sheared DIR...     area that has sheared at 0.24 s on either side of the plate of an indentation

DIR is the folder of a run: of jobs/element/rve_biaxial.toml or rve_ensemble.toml (of held also a record FILE.csv=STRESS by YADE), of jobs/element/bulk.toml or bulk_spheres.toml, of the job in
jobs/continuum, of jobs/triaxial.toml, of jobs/indentation.toml and far_field.toml, of the footings in jobs/mpm_dem, or of jobs/fem_dem/simple_shear.toml and dns_simple_shear.toml. Strains are logarithmic, from the edges
of the cell; of a biaxial test from time zero, of a slope from the first row.
"""

import csv
import math
import sys
import tomllib


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


def held(folder):
    """Root mean square and worst of (sigma_xx + p0)/p0; p0 is the job's, or stands behind a record of YADE."""
    if "=" in folder:
        file, stress = folder.split("=")
        with open(file, newline="") as lines:
            rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(lines)]
        points = [(-row["eps_yy"], row["sxx_Pa"], row["void_ratio"]) for row in rows]
        target = -float(stress)
    else:
        rows, job = series(folder), scenario(folder)
        target, rate = job["cell"]["stress"][0], job["cell"]["velocity_gradient"][1][1]
        height = rows[0]["edge_yy"] * math.exp(-rate * rows[0]["time"])
        points = [(math.log(height / row["edge_yy"]), row["stress_xx"], 1 / row["fraction"] - 1) for row in rows]
    errors = [stress / target - 1 for along, stress, _ in points if along > 5e-4]
    void = mean(void for along, _, void in points if 0.10 <= along <= 0.15)
    print(
        f"{folder}: off by {100 * math.sqrt(mean(error * error for error in errors)):.3f} %, at worst"
        f" {100 * max(map(abs, errors)):.2f} %, void ratio from 10 to 15 % {void:.4f}"
    )


def fit(points):
    """Slope of the line of least squares."""
    x, y = mean(point[0] for point in points), mean(point[1] for point in points)
    below = sum((point[0] - x) ** 2 for point in points)
    return sum((point[0] - x) * (point[1] - y) for point in points) / below if below > 0 else float("nan")


def slope(folder):
    """K where all edges shrink, M where one alone does, G where none does and the cell is sheared."""
    rows = series(folder)
    axes = [i for i in "xyz" if f"edge_{i}{i}" in rows[0]]
    shrinks = [i for i in axes if abs(rows[-1][f"edge_{i}{i}"] / rows[0][f"edge_{i}{i}"] - 1) > 1e-9]
    if len(shrinks) == len(axes):
        name = "K"
        stress = lambda row: -sum(row[f"stress_{i}{i}"] for i in axes) / len(axes)
        strain = lambda row: -sum(math.log(row[f"edge_{i}{i}"]) for i in axes)
    elif shrinks:
        name, axis = "M", shrinks[0] * 2
        stress = lambda row: -row[f"stress_{axis}"]
        strain = lambda row: -math.log(row[f"edge_{axis}"])
    else:
        name = "G"
        stress = lambda row: row["stress_xy"]
        strain = lambda row: row["edge_xy"] / row["edge_yy"]
    start = strain(rows[0])
    points = [(strain(row) - start, stress(row)) for row in rows]
    whole = points[-1][0]
    first = [point for point in points if point[0] <= 0.1 * whole]
    print(f"{folder}: {name} {1e-6 * fit(first):.1f} ({1e-6 * fit(points):.1f}) MPa over {100 * whole:.3f} %")


def scenario(folder):
    with open(f"{folder}/scenario.toml", "rb") as file:
        return tomllib.load(file)


def footing(folder):
    """The half of a footing on one weightless material that is in the grid: p_u = c N_c + q N_q."""
    job = scenario(folder)
    material, half = job["material"], job["body"][0]["upper"][0] - job["grid"]["lower"][0]
    phi, load = material["friction_angle_critical"], job.get("load", [{"pressure": 0}])[0]["pressure"]
    n_q = math.tan(math.pi / 4 + phi / 2) ** 2 * math.exp(math.pi * math.tan(phi))
    n_c = (n_q - 1) / math.tan(phi) if phi > 0 else 2 + math.pi
    exact = (material["cohesion"] * n_c + load * n_q) * half * job["grid"]["depth"]
    points = [(-row["footing_displacement_y"], row["footing_force_y"] / exact) for row in series(folder)]
    last = points[-1][0]
    print(
        f"{folder}: {mean(load for settled, load in points if settled >= last / 2):.3f}"
        f" ({mean(load for settled, load in points if settled >= 0.9 * last):.3f} in the last tenth)"
        f" of {exact:.0f} N, settlement {1e3 * last:.1f} mm"
    )


def bearing(folder):
    """Of jobs/mpm_dem/footing_*.toml: N = F/(q B depth), means over a tenth of a second, which is 1 cm of settlement; the slope is that of
    lines of least squares through a tenth of B."""
    job = scenario(folder)
    body, load = job["body"][0], job["load"][0]["pressure"]
    half = body["upper"][0] - job["grid"]["lower"][0]
    over = load * half * job["grid"]["depth"]
    rows = series(folder)
    points = [(-row["footing_displacement_y"] / half, row["footing_force_y"] / over) for row in rows]
    near = lambda at, width: [point for point in points if abs(point[0] - at) <= width / 2]
    last = points[-1][0]
    places = [at for at in (0.05, 0.1, 0.2, 0.3, 0.5, 0.75, 1, 1.25, 1.5) if at <= last + 0.01]
    told = [f"{at:g}: {mean(n for _, n in near(min(at, last), 0.01)):.2f}" for at in places]
    slopes = [(at / 100, fit(near(at / 100, 0.1))) for at in range(10, int(100 * last) - 5, 2)]
    flat = next((at for at, slope in slopes if slope <= 0), None)
    peak = max((mean(n for _, n in near(at / 100, 0.05)), at / 100) for at in range(5, int(100 * last)))
    ultimate = f"flat from d/B {flat:.2f} at {mean(n for _, n in near(flat, 0.05)):.2f}" if flat else "rising to the end"
    print(f"{folder}: N at d/B {', '.join(told)}; {ultimate}; most {peak[0]:.2f} at {peak[1]:.2f}")


class Frames:
    """Columns of the points of a frame, or of another kind of rows, in the order of ids."""

    def __init__(self, folder):
        import h5py

        self.root = h5py.File(f"{folder}/frames.vtkhdf")["VTKHDF"]
        self.times = self.root["Steps/Values"][:]

    def column(self, frame, name, kind=0):
        import numpy

        first, count = self.root["Steps/PointOffsets"][frame], self.root["NumberOfPoints"][frame]
        rows = slice(first, first + count)
        column = self.root["Points" if name == "place" else f"PointData/{name}"]
        wanted = self.root["PointData/kind"][rows] == kind
        return column[rows][wanted][numpy.argsort(self.root["PointData/id"][rows][wanted], kind="stable")]


def line_of_band(place, gain, strip, steps, least, length=lambda angle: 1.0):
    """Angle of the line, and distances from it: of all strips of that width and at least so many degrees the one that holds most, over its length."""
    import numpy

    held, found = 0.0, None
    for degrees in (*range(least, 71), *range(-70, 1 - least)):
        angle = math.radians(degrees)
        trial = place @ numpy.array([-math.sin(angle), math.cos(angle)])
        for offset in numpy.arange(trial.min(), trial.max(), strip / steps):
            inside = gain[abs(trial - offset) < strip / 2].sum() / length(angle)
            if inside > held:
                held, found = inside, (angle, trial - offset)
    return found


def band(folder):
    """Of the last fifth of the run, in the middle half of the specimen; of the stronger band where two cross."""
    import numpy

    frames, job = Frames(folder), scenario(folder)
    cell, depth, points_per_cell = job["grid"]["cell"], job["grid"]["depth"], job["scheme"]["points_per_cell"]
    last = len(frames.times) - 1
    first = int(numpy.searchsorted(frames.times, 0.8 * frames.times[last]))
    start, place = frames.column(0, "place")[:, 0], frames.column(last, "place")[:, :2]
    gain = frames.column(last, "plastic_strain") - frames.column(first, "plastic_strain")
    left, right = start.min(), start.max()
    middle = abs(start - (left + right) / 2) < (right - left) / 4
    place, gain = place[middle], gain[middle]
    angle, across = line_of_band(place, gain, cell, 8, 20)
    along = (math.cos(angle), math.sin(angle))
    near = abs(across) < 3 * cell
    even = (cell / points_per_cell) ** 2 * gain[near].sum() ** 2 / (gain[near] ** 2).sum()
    # Of a triangular and of a Gaussian profile the width at half of the height is two thirds of that of even strain.
    width = 2 / 3 * even / ((right - left) / 2 / along[0]) / cell
    of_cell = abs(along[0]) + abs(along[1])
    rows = series(folder)
    stress = [row["plate_force_y"] / (depth * (right - left + cell / points_per_cell)) for row in rows]
    print(
        f"{folder}: width {1e3 * cell * width:.2f} mm = {width:.2f} cells = {width / of_cell:.2f} of a cell's section,"
        f" slope {abs(along[1] / along[0]):.2f}, axial stress {1e-3 * max(stress):.0f} and {1e-3 * stress[-1]:.0f} kPa"
        f" at its peak and at {-1e3 * rows[-1]['plate_displacement_y']:.2f} mm"
    )


def sheared_elements(folder, strain=0.042):
    """Of elements or points in plane strain compression: width of the band in which deviatoric strain grows over the last fifth of the way to a strain, in
    metres, by one measure for all meshes: two thirds of the even strain with the same sum and sum of squares, within one strip and a half of its line, strips
    being a fifth of the specimen wide."""
    import numpy

    frames, job, rows = Frames(folder), scenario(folder), series(folder)
    start = frames.column(0, "place")[:, :2]
    if "mesh" in job:
        upper = [end - begin for begin, end in zip(job["mesh"].get("lower", [0, 0, 0]), job["mesh"]["upper"])]
        depth = job["mesh"]["depth"] if job["mesh"]["space"] == "plane" else upper[2]
        sheared = "deviatoric_strain"
    else:
        spacing = job["grid"]["cell"] / job["scheme"]["points_per_cell"]
        upper, depth, sheared = start.max(axis=0) - start.min(axis=0) + spacing, job["grid"]["depth"], "deviatoric_strain"
    body = next(body["name"] for body in job["body"] if "path" in body)
    strip = upper[0] / 5
    reached = {row["time"]: -row[f"{body}_displacement_y"] / upper[1] for row in rows}
    at = lambda wanted: min(range(len(frames.times)), key=lambda frame: abs(numpy.interp(frames.times[frame], list(reached), list(reached.values())) - wanted))
    first, last = at(0.8 * strain), at(strain)
    gain = frames.column(last, sheared) - frames.column(first, sheared)
    place = frames.column(last, "place")[:, :2]
    area = upper[0] * upper[1] / len(start)
    # Strips that leave through the ends are shorter.
    angle, across = line_of_band(place, gain, strip, 16, 35, lambda angle: upper[0] / math.cos(angle))
    near = abs(across) < 1.5 * strip
    even = area * gain[near].sum() ** 2 / (gain[near] ** 2).sum()
    width = 2 / 3 * even / (upper[0] / math.cos(angle))
    stress = [row[f"{body}_force_y"] / (upper[0] * depth) for row in rows]
    strains = list(reached.values())
    level = lambda wanted: 1e-3 * float(numpy.mean([s for s, e in zip(stress, strains) if abs(e - wanted) < 0.0025]))
    print(
        f"{folder}: width {1e3 * width:.1f} mm at {math.degrees(angle):.0f} degrees between strains of {100 * strain * 0.8:.1f} and {100 * strain:.1f} %; peak {1e-3 * max(stress):.0f} kPa at {100 * strains[stress.index(max(stress))]:.2f} %, "
        + ", ".join(f"{level(e):.0f} at {100 * e:.0f} %" for e in (0.01, 0.02, 0.03, 0.04) if e <= strains[-1] + 0.001)
    )


def sheared_bins(folder, strain=0.042, edge=0.05):
    """Of a specimen of any method in plane strain compression: the same width of its band, of deviatoric strain averaged in square bins, grains and points by
    the area that they stand for, so that a method of thousands of grains is measured as one of hundreds of elements; in metres."""
    import numpy

    frames, job, rows = Frames(folder), scenario(folder), series(folder)
    body = next(body["name"] for body in job["body"] if "path" in body)
    height = next(body["point"][1] if "point" in body else body["lower"][1] for body in job["body"] if "path" in body)
    reached = {row["time"]: -row[f"{body}_displacement_y"] / height for row in rows}
    at = lambda wanted: min(range(len(frames.times)), key=lambda frame: abs(numpy.interp(frames.times[frame], list(reached), list(reached.values())) - wanted))
    first, last = at(0.8 * strain), at(strain)

    def shears(frame):
        columns = [numpy.concatenate([frames.column(frame, name, kind) for kind in (0, 1)]) for name in ("id", "deviatoric_strain", "radius")]
        places = numpy.concatenate([frames.column(frame, "place", kind)[:, :2] for kind in (0, 1)])
        kinds = numpy.concatenate([numpy.full(len(frames.column(frame, "id", kind)), kind) for kind in (0, 1)])
        return kinds, *columns, places

    kinds, ids, after, radius, place = shears(last)
    kinds_before, ids_before, before, _, _ = shears(first)
    known = {(kind, number): value for kind, number, value in zip(kinds_before, ids_before, before)}
    kept = numpy.array([(kind, number) in known for kind, number in zip(kinds, ids)])
    gain = after[kept] - numpy.array([known[key] for key in zip(kinds[kept], ids[kept])])
    place, kinds, radius = place[kept], kinds[kept], radius[kept]
    # Points share what grains leave of the specimen.
    area = numpy.where(kinds == 1, math.pi * radius**2 / 0.84, 0.0)
    width = numpy.percentile(place[:, 0], 99.5) - numpy.percentile(place[:, 0], 0.5)
    points = (kinds == 0).sum()
    area[kinds == 0] = max(width * (place[:, 1].max() - place[:, 1].min()) - area.sum(), 0.0) / max(points, 1)
    counts = numpy.ceil(place.max(axis=0) / edge).astype(int) + 1
    where = numpy.floor(place / edge).astype(int).clip(0) @ (1, counts[0])
    held = numpy.bincount(where, area, counts.prod())
    mean = numpy.bincount(where, area * gain, counts.prod()) / held.clip(1e-30)
    centre = (numpy.array([(x, y) for y in range(counts[1]) for x in range(counts[0])]) + 0.5) * edge
    # A bin that no row is in has the strain of the nearest one, where that reaches so far.
    for number in numpy.flatnonzero(held == 0):
        way = ((place - centre[number]) ** 2).sum(axis=1)
        nearest = way.argmin()
        if way[nearest] < 0.55 * area[nearest]:
            held[number], mean[number] = edge**2, gain[nearest]
    full = held > 0.2 * numpy.median(held[held > 0])
    centre, mean = centre[full], mean[full]
    angle, across = line_of_band(centre, mean, width / 5, 16, 35, lambda angle: width / math.cos(angle))
    near = abs(across) < 0.3 * width
    even = edge**2 * mean[near].sum() ** 2 / (mean[near] ** 2).sum()
    print(
        f"{folder}: {1e3 * 2 / 3 * even / (width / math.cos(angle)):.0f} mm at {abs(math.degrees(angle)):.0f} degrees, with {100 * mean[near].sum() / mean.sum():.0f} % of all"
        f" deviatoric strain between axial strains of {100 * 0.8 * strain:.1f} and {100 * strain:.1f} %"
    )


def layers(folder, rows_of_height=12, between=(0.8, 1.0), last=0.12):
    """Simple shear of elements, or of grains between two glued layers. Stresses are those on the bottom over the pressure; the shear band is the even layer whose
    shear has the same sum and sum of squares, over the last fifth of the way to the end or to 12 % of strain, in metres: of rows as high as the elements
    of jobs/fem_dem/simple_shear.toml, and of grains in layers a fourth of that, too. Void ratios are of such rows at that strain."""
    import numpy

    job, rows = scenario(folder), series(folder)
    top = next(body for body in job["body"] if "path" in body)
    if "mesh" in job:
        import h5py

        low, high = job["mesh"].get("lower", [0, 0, 0])[1], job["mesh"]["upper"][1]
        area = job["mesh"]["upper"][0] * job["mesh"]["upper"][2]
        base, pressure, finer = "y_lower", job["stress"]["pressure"], [1]
        root = h5py.File(f"{folder}/elements.vtkhdf")["VTKHDF"]
        times = root["Steps/Values"][:]

        def frame(which):
            first, count = root["Steps/PointOffsets"][which], root["NumberOfPoints"][which]
            return root["Points"][first : first + count]

        start = frame(0)
        moved = lambda which: (start[:, 1], frame(which)[:, 0] - start[:, 0])
        cells = lambda which: slice(*(root["Steps/CellDataOffsets/void_ratio"][which] + numpy.array([0, len(start) // 4])))
        middle = start.reshape(-1, 4, 3).mean(axis=1)[:, 1]
        voids = lambda which, edges: [root["CellData/void_ratio"][cells(which)][(middle > a) & (middle < b)].mean() for a, b in zip(edges, edges[1:])]
    else:
        base = next(body["name"] for body in job["body"] if body is not top)
        low, high = next(body["upper"][1] for body in job["body"] if body is not top), top["lower"][1]
        area, pressure, finer = rows[0]["edge_xx"] * rows[0]["edge_zz"], job["packing"]["stress"], [1, 4]
        frames = Frames(folder)
        times = frames.times
        of = lambda which, name: numpy.concatenate([frames.column(which, name, kind) for kind in numpy.unique(frames.root["PointData/kind"][:1000000])])
        heights = of(0, "place")[:, 1]
        moved = lambda which: (heights, of(which, "displacement")[:, 0])

        def voids(which, edges):
            # As high as the grains that were between two heights have come to be.
            radius, now = of(which, "radius"), of(which, "place")[:, 1]
            risen = numpy.interp(edges, *zip(*[(heights[near].mean(), now[near].mean()) for near in (abs(heights - edge) < 1e-3 for edge in edges)]))
            solid = [(4 / 3 * math.pi * radius[(now >= a) & (now < b)] ** 3).sum() for a, b in zip(risen, risen[1:])]
            return [area * (b - a) / inside - 1 for a, b, inside in zip(risen, risen[1:], solid)]

    height = high - low
    strains = [row[f"{top['name']}_displacement_x"] / height for row in rows]
    at = numpy.interp(times, [row["time"] for row in rows], strains)
    shear = [abs(row[f"{base}_force_x"]) / area / pressure for row in rows]
    level = lambda wanted: float(numpy.mean([s for s, e in zip(shear, strains) if abs(e - wanted) < 0.001 + 0.05 * wanted]))
    wanted = [e for e in (0.005, 0.01, 0.015, 0.02, 0.03, 0.04, 0.05, 0.06, 0.08, 0.1, 0.12, 0.15, 0.2) if e <= strains[-1]]
    # Of rows of the series ten at a time.
    calm = [float(numpy.mean(shear[max(0, number - 4) : number + 6])) for number in range(len(shear))]
    peak = max(range(len(calm)), key=lambda number: calm[number])
    print(f"{folder}: shear stress over {pressure / 1e3:.0f} kPa, {calm[peak]:.3f} at most at {100 * strains[peak]:.2f} %; " + ", ".join(f"{level(e):.3f} at {100 * e:g} %" for e in wanted))
    end = min(last, at[-1])
    first, final = [int(abs(at - share * end).argmin()) for share in between]
    if final == first:
        return print("  too few frames for a profile")
    for parts in finer:
        count = rows_of_height * parts
        edges = numpy.linspace(low, high, count + 1)
        gain = numpy.subtract(moved(final)[1], moved(first)[1])
        ys = moved(0)[0]
        around = height / rows_of_height / 8
        profile = numpy.array([gain[abs(ys - edge) < around].mean() for edge in edges])
        sheared = numpy.diff(profile) * count / height
        even = height / count * sheared.sum() ** 2 / (sheared**2).sum()
        most = int(sheared.argmax())
        print(
            f"  from {100 * at[first]:.2f} to {100 * at[final]:.2f} % in {count} rows of {1e3 * height / count:.1f} mm: band of {1e3 * even:.1f} mm, most in row {most + 1}"
            f" ({1e3 * (edges[most] - low):.0f} to {1e3 * (edges[most + 1] - low):.0f} mm), shares of rows " + " ".join(f"{share:.2f}" for share in sheared / sheared.sum())
        )
    edges = numpy.linspace(low, high, rows_of_height + 1)
    print(f"  void ratio at {100 * at[final]:.2f} %: " + " ".join(f"{void:.3f}" for void in voids(final, edges)))


def deposit(place, link):
    """Indices of the largest set of points that hang together, each within `link` of another."""
    cells, waiting, largest = {}, set(range(len(place))), []
    for index, (x, y) in enumerate(place):
        cells.setdefault((int(x // link), int(y // link)), []).append(index)
    while waiting:
        found = [waiting.pop()]
        for index in found:
            x, y = place[index]
            column, row = int(x // link), int(y // link)
            for beside in ((column + i, row + j) for i in (-1, 0, 1) for j in (-1, 0, 1)):
                for other in cells.get(beside, ()):
                    if other in waiting and math.dist(place[index], place[other]) <= link:
                        waiting.remove(other)
                        found.append(other)
        largest = max(largest, found, key=len)
    return largest


def collapse(folder):
    """The front is the farthest point, after removing scatter points which are not in contact with the main deposit (Liang &
    Zhao 2019, eq. 48). Points are in contact where they are a cell or less apart: twice what they are at the start."""
    frames, job = Frames(folder), scenario(folder)
    width = job["region"][0]["upper"][0]
    place = frames.column(len(frames.times) - 1, "place")[:, :2].tolist()
    ahead = lambda x: (x - width) / width
    x = sorted(x for x, _ in place)
    main = deposit(place, job["grid"]["cell"])
    rows = series(folder)
    start = rows[0]["potential"]
    fastest = max(rows, key=lambda row: row["kinetic"])
    print(
        f"{folder}: front {ahead(max(place[index][0] for index in main)):.2f} without scatter of"
        f" {100 * (1 - len(main) / len(place)):.2f} % of the mass, 99 % of the mass {ahead(x[int(0.99 * len(x))]):.2f},"
        f" farthest point {ahead(x[-1]):.2f}; kinetic at most {fastest['kinetic'] / start:.3f}"
        f" at {fastest['time']:.2f} s, potential lost {1 - rows[-1]['potential'] / start:.3f}"
    )
    for at in range(0, len(rows), len(rows) // 8):
        row = rows[at]
        shares = (f"{name} {row[name] / start:.3f}" for name in ("kinetic", "elastic", "potential", "dissipated"))
        print(f"  {row['time']:.2f} s: {', '.join(shares)}")


def rest(folder):
    """Of the last frame, of a job with [gravity] in the plane. p is that of the plane, positive in compression; the surface over
    a point is the top of its column of cells, and the height that of the material at the start. What bears nothing bears less
    than a pascal. Noise is the root mean square of p less its mean over the nodes around, over the weight above. The material
    whose way is told began above the ground, the lowest surface of the start."""
    import numpy

    frames, job = Frames(folder), scenario(folder)
    cell, points = job["grid"]["cell"], job["scheme"]["points_per_cell"]
    weight = job["material"]["density"] * -job["gravity"]["acceleration"][1]
    last = len(frames.times) - 1
    place, moved, stress, averaged, velocity = (
        frames.column(last, name) for name in ("place", "displacement", "stress", "stress_averaged", "velocity")
    )
    pressure, around = (-0.5 * (s[:, 0] + s[:, 1]) for s in (stress, averaged))
    lower, upper = job["grid"]["lower"], job["grid"]["upper"]

    def surface(place):
        columns = ((place[:, 0] - lower[0]) / cell).astype(int)
        top = numpy.full(round((upper[0] - lower[0]) / cell), lower[1])
        numpy.maximum.at(top, columns, place[:, 1] + 0.5 * cell / points)
        return top, top[columns]

    start = place - moved
    tops, _ = surface(start)
    height = tops.max() - lower[1]
    depth = surface(place)[1] - place[:, 1]
    deep = (depth > 1) & (depth < 3)
    share = pressure[deep] / (weight * depth[deep])
    noise = math.sqrt(numpy.mean(((pressure - around)[deep] / (weight * depth[deep])) ** 2))
    above = start[:, 1] > (tops.min() if tops.max() - tops.min() > cell else lower[1])
    before, after = (numpy.quantile(xs[above], 0.99) for xs in (start[:, 0], place[:, 0]))
    print(
        f"{folder}, {frames.times[last]:.1f} s: largest p {pressure.max() / (weight * height):.2f} of rho g H,"
        f" {100 * numpy.mean(pressure < 1):.1f} % bear nothing ({100 * numpy.mean((pressure < 1) & (depth > cell)):.2f} % deeper than a cell),"
        f" 1 to 3 m deep {share.mean():.2f} +- {share.std():.2f}, noise {noise:.2f}; 99 % within {after:.2f} m, {before:.2f} m at the start;"
        f" moved by {numpy.linalg.norm(moved, axis=1).max():.3f} m at most, at {1e3 * math.sqrt(numpy.mean(velocity**2) * velocity.shape[1]):.2g} mm/s now"
    )


def chains(vertices):
    """Of all membranes one after the other: where the next vertex is farther than twice a segment another chain begins."""
    import numpy

    lengths = numpy.linalg.norm(numpy.diff(vertices, axis=0), axis=1)
    segment = numpy.median(lengths)
    for chain in numpy.split(vertices, 1 + numpy.flatnonzero(lengths > 2 * segment)):
        is_closed = len(chain) > 2 and numpy.linalg.norm(chain[0] - chain[-1]) < 2 * segment
        yield numpy.vstack([chain, chain[:1]]) if is_closed else chain


def outside(folder):
    """Centres to the right of the nearest segment, by their distance to it. Where a band leaves the specimen a membrane folds:
    how far grains lie beyond it along x says nothing there."""
    import numpy

    frames, job = Frames(folder), scenario(folder)
    last, diameter = len(frames.times) - 1, job["grains"]["diameter_mean"]
    place, radius = (frames.column(last, name, kind=1) for name in ("place", "radius"))
    place = place[:, :2]
    nearest, side = numpy.full(len(place), numpy.inf), numpy.zeros(len(place))
    for chain in chains(frames.column(last, "place", kind=3)[:, :2]):
        for one, other in zip(chain, chain[1:]):
            way = other - one
            share = numpy.clip((place - one) @ way / (way @ way), 0, 1)
            apart = place - one - share[:, None] * way
            distance = numpy.linalg.norm(apart, axis=1)
            closer = distance < nearest
            nearest = numpy.where(closer, distance, nearest)
            side = numpy.where(closer, way[1] * apart[:, 0] - way[0] * apart[:, 1], side)
    out = numpy.where(side > 0, nearest, -nearest)
    print(
        f"{folder}: of {len(out)} grains {(out > radius).sum()} lie outside of a membrane altogether, {(out > diameter).sum()} by more"
        f" than a diameter; the farthest centre is {1e3 * out.max():.2f} mm outside"
    )


def sheared(folder):
    """Within 20 cm of the plate's middle, where deviatoric strain is over 0.15. Points have their area at the start, grains
    theirs over a solid volume fraction of 0.84."""
    import numpy

    frames, job = Frames(folder), scenario(folder)
    frame, plate = int(numpy.argmin(abs(frames.times - 0.24))), job["body"][-1]
    middle, ground = (plate["lower"][0] + plate["upper"][0]) / 2, plate["lower"][1]
    of_points = (job["grid"]["cell"] / job["scheme"]["points_per_cell"]) ** 2
    columns = []
    for kind in (0, 1):
        place, strain, weight, radius = (
            frames.column(frame, name, kind) for name in ("place", "deviatoric_strain", "weight", "radius")
        )
        area = weight * (of_points if kind == 0 else math.pi * radius**2 / 0.84)
        columns.append((place[:, 0] - middle, place[:, 1], strain, area))
    x, y, strain, area = (numpy.concatenate(column) for column in zip(*columns))
    for name, side in (("left", -x), ("right", x)):
        has = (side > 0) & (side < 0.2) & (strain > 0.15)
        reaches = side[has & (y > ground - 5e-3)]
        print(
            f"{folder}, {frames.times[frame]:.3f} s, {name}: {1e4 * area[has].sum():.1f} cm2, shear times area"
            f" {1e4 * (area * strain)[has].sum():.1f} cm2, comes to the ground {1e3 * reaches.max(initial=0):.0f} mm away"
        )


def planar(pair, strains=(0.01, 0.1)):
    """Of a hybrid in planar shear against grains alone: moving averages of the shear stress over half a percent of strain, how far they are off in the mean and in
    root mean square between strains, and the peak of each."""
    import numpy

    grains, hybrid = pair.split("=")

    def averages(folder, at):
        rows = series(folder)
        strain, stress = (numpy.array([row[name] for row in rows]) for name in ("strain", "shear_stress"))
        return numpy.array([stress[abs(strain - middle) < 0.0025].mean() for middle in at])

    end = min(series(folder)[-1]["strain"] for folder in (grains, hybrid)) - 0.003
    at = numpy.arange(0.004, end, 0.001)
    wanted, found = averages(grains, at), averages(hybrid, at)
    inside = (at > strains[0]) & (at < strains[1])
    mean = wanted[inside].mean()
    peaks = ", ".join(f"{1e-3 * stress.max():.0f} kPa at {100 * at[stress.argmax()]:.1f} %" for stress in (wanted, found))
    print(
        f"{hybrid}: {100 * (found[inside].mean() / mean - 1):+.1f} % off {grains} in the mean of strains from {100 * strains[0]:g} to {100 * min(strains[1], end):.3g} %,"
        f" {100 * ((found - wanted)[inside] ** 2).mean() ** 0.5 / mean:.1f} % in root mean square; peaks {peaks}"
    )


def packings(folder, strains=(0.01, 0.1), cell=7.5e-3):
    """Packings of planar shear that nothing was chosen on: FOLDER has of each packing N the runs dem_N (grains alone), and of those that are to be held against it
    hybrid_N, points_N (the continuum alone), low_N (grains alone in a specimen as high as a zone), again_N (the same packing's grains alone at another speed by 5e-5), and
    N/comparison.json of `scree report --between`. Moving averages of the shear stress over half a percent of strain. Means have their 95 % intervals by Student's t over packings,
    differences of strain at the peak and of the peak their p by the same; places of bands are held against those of grains alone of all other packings by exchanging them."""
    import glob
    import json
    import os
    import re

    import numpy
    from scipy import stats

    seeds = sorted(int(re.search(r"dem_(\d+)$", path).group(1)) for path in glob.glob(f"{folder}/dem_*") if os.path.isdir(path))

    def curve(kind, seed):
        path = f"{folder}/{kind}_{seed}"
        if not os.path.exists(f"{path}/series.csv"):
            return None
        rows = series(path)
        strain, stress = (numpy.array([row[name] for row in rows]) for name in ("strain", "shear_stress"))
        # Of the same shear strain as the whole specimen, not of the same way of the plate.
        strain = strain * scenario(f"{folder}/dem_{seed}")["specimen"]["height"] / scenario(path)["specimen"]["height"]
        at = numpy.arange(0.004, 0.1165, 0.001)
        if strain[-1] < at[-1]:
            return None
        return at, numpy.array([stress[abs(strain - middle) < 0.0025].mean() for middle in at])

    def bands(seed):
        """Middle (m above the lowest point), thickness (D50) and share of shear inside zones by the name of the run."""
        path = f"{folder}/{seed}/comparison.json"
        if not os.path.exists(path):
            return {}
        runs = json.load(open(path))["bands"]["runs"]
        return {run["run"].split()[0]: [run[key] for key in ("height_m", "thickness_d50", "shear_inside_zone")] for run in runs}

    def interval(values):
        values = numpy.array(values)
        half = stats.t.ppf(0.975, len(values) - 1) * values.std(ddof=1) / len(values) ** 0.5 if len(values) > 1 else float("nan")
        return f"{values.mean():+.2f} +- {half:.2f} (each {values.std(ddof=1) if len(values) > 1 else float('nan'):.2f})"

    off = {}
    for kind in ("hybrid", "points", "low", "again"):
        found = {"mean": [], "rms": [], "strain": [], "peak": [], "place": [], "alone": [], "thickness": [], "seeds": []}
        for seed in seeds:
            alone, other = curve("dem", seed), curve(kind, seed)
            if alone is None or other is None:
                continue
            at, wanted = alone
            inside = (at > strains[0]) & (at < strains[1])
            mean, difference = wanted[inside].mean(), other[1] - wanted
            found["seeds"].append(seed)
            found["mean"].append(100 * difference[inside].mean() / mean)
            found["rms"].append(100 * (difference[inside] ** 2).mean() ** 0.5 / mean)
            found["strain"].append(100 * (at[other[1].argmax()] - at[wanted.argmax()]))
            found["peak"].append(100 * (other[1].max() / wanted.max() - 1))
            band = bands(seed)
            ours, theirs = band.get(f"{kind}_{seed}"), band.get(f"dem_{seed}")
            told = ""
            if ours and theirs and ours[0] is not None and theirs[0] is not None:
                found["place"].append(ours[0])
                found["alone"].append(theirs[0])
                told = f"; band at {1e3 * ours[0]:.0f} mm for {1e3 * theirs[0]:.0f}"
                if ours[1] is not None and theirs[1] is not None:
                    found["thickness"].append(ours[1] - theirs[1])
                    told += f", {ours[1]:.1f} D50 for {theirs[1]:.1f}"
                if ours[2] is not None:
                    told += f", {100 * ours[2]:.0f} % of shear in zones"
            print(f"{kind} {seed}: mean {found['mean'][-1]:+.1f} %, rms {found['rms'][-1]:.1f} %, strain at the peak {found['strain'][-1]:+.1f} %, peak {found['peak'][-1]:+.1f} %{told}")
        if not found["seeds"]:
            continue
        off[kind] = found
        count = len(found["seeds"])
        print(f"{kind}, {count} packings: mean {interval(found['mean'])} %, rms {numpy.mean(found['rms']):.1f} %")
        for name, what in (("strain", "strain at the peak"), ("peak", "peak")):
            p = stats.ttest_1samp(found[name], 0).pvalue if count > 1 else float("nan")
            print(f"  {what}: {interval(found[name])} %, p {p:.3f}")
        if found["thickness"]:
            print(f"  thickness: {interval(found['thickness'])} D50")
        if len(found["place"]) > 2:
            ours, alone = numpy.array(found["place"]), numpy.array(found["alone"])
            apart = abs(ours[:, None] - alone[None, :])
            near = int((numpy.diag(apart) <= cell).sum())
            draws, random = 100_000, numpy.random.default_rng(1)
            by_chance = [(apart[numpy.arange(len(ours)), random.permutation(len(ours))] <= cell).sum() for _ in range(draws)]
            farther = [apart[numpy.arange(len(ours)), random.permutation(len(ours))].mean() <= numpy.diag(apart).mean() for _ in range(draws)]
            print(
                f"  place: {near} of {len(ours)} within {1e3 * cell:g} mm, {numpy.mean(by_chance):.1f} by chance, p {numpy.mean(numpy.array(by_chance) >= near):.3f};"
                f" {1e3 * numpy.diag(apart).mean():.0f} mm apart, {1e3 * apart.mean():.0f} by chance, p {numpy.mean(farther):.3f}"
            )
    if "hybrid" in off:
        for kind in ("points", "low"):
            if kind not in off:
                continue
            both = [seed for seed in off["hybrid"]["seeds"] if seed in off[kind]["seeds"]]
            pick = lambda found, name: numpy.abs([found[name][found["seeds"].index(seed)] for seed in both])
            for name in ("mean", "rms", "strain", "peak"):
                worse = pick(off[kind], name) - pick(off["hybrid"], name)
                p = stats.ttest_1samp(worse, 0, alternative="greater").pvalue if len(both) > 1 else float("nan")
                print(f"{kind} worse than the hybrid by |{name}|: {interval(worse)}, p {p:.3f}")


def everywhere(folder):
    """Hybrids whose zone begins everywhere: tests/everywhere.py, which wants numpy and scipy."""
    from everywhere import everywhere as held

    held(folder)


def coupling(folder, begin=0.06, strains=(0.012, 0.06)):
    """A hybrid of planar shear: mean of sigma_yy by weights and space over each layer of cells without those beside plates, of frames from `begin` (s) on;
    the springs' stretch at the last checkpoint, which is the slip times the continuum's share; mean shear stress between two strains."""
    import glob

    import h5py
    import numpy

    job, frames, fraction = scenario(folder), Frames(folder), 0.844
    cell, top = job["continuum"]["cell"], int(job["specimen"]["height"] / job["continuum"]["cell"]) - 2
    stress = []
    for frame in numpy.flatnonzero(frames.times >= begin):
        both = lambda name: numpy.concatenate([frames.column(frame, name, kind) for kind in (0, 1)])
        points = len(frames.column(frame, "radius"))
        share = both("weight") * both("radius") ** 2 / numpy.where(numpy.arange(len(both("radius"))) < points, 1, fraction)
        layer, normal = (both("place")[:, 1] / cell).astype(int), -both("stress")[:, 1]
        stress.append([(share * normal)[layer == row].sum() / share[layer == row].sum() for row in range(1, top)])
    stress = numpy.array(stress) / 1e3
    with h5py.File(sorted(glob.glob(f"{folder}/checkpoints/step-*.h5"))[-1]) as state:
        grains, ties = state["tables/grains"], state["tables/ties"]
        masses = dict(zip(grains["id"][:].ravel(), grains["mass"][:].ravel()))
        mass = numpy.array([masses[grain] for grain in ties["grain"][:].ravel()])
        spring = job["coupling"]["stiffness"] * job["contact"]["stiffness_normal"] * job["time"]["step"]
        stretch = 1e6 * numpy.linalg.norm(ties["spring"][:], axis=1) * mass / spring
    shear = mean(row["shear_stress"] for row in series(folder) if strains[0] < row["strain"] < strains[1])
    over = stress.mean(axis=0)
    print(
        f"{folder}: layers {over.min():.0f} to {over.max():.0f} kPa in the mean, {stress.min():.0f} to {stress.max():.0f} in single frames; "
        f"stretch {numpy.sqrt((stretch**2).mean()):.2f} um rms, {stretch.max():.1f} at most; shear stress {shear / 1e3:.1f} kPa"
    )


if __name__ == "__main__":
    commands = {
        "biaxial": biaxial,
        "held": held,
        "slope": slope,
        "footing": footing,
        "bearing": bearing,
        "band": band,
        "elements": sheared_elements,
        "bins": sheared_bins,
        "layers": layers,
        "collapse": collapse,
        "outside": outside,
        "rest": rest,
        "planar": planar,
        "packings": packings,
        "everywhere": everywhere,
        "coupling": coupling,
        "sheared": sheared,
    }
    if len(sys.argv) < 3 or sys.argv[1] not in commands:
        sys.exit(__doc__)
    for folder in sys.argv[2:]:
        commands[sys.argv[1]](folder)

"""Continuous fields of grains, contacts and material points, by one definition (coarse graining; Goldhirsch 2010, Granular Matter 12, 239).

With a kernel phi of integral one, sums over rows i of share w_i, mass m_i, velocity v_i, place x_i, and over contacts c with the force f on the grain
where the branch b begins,

    density        rho(x)     = sum_i w_i m_i phi(x - x_i)
    velocity       V(x)       = sum_i w_i m_i v_i phi(x - x_i) / rho(x)
    stress         sigma_c(x) = sum_c w_c (f b + b f)/2  int_0^1 phi(x - x_c - s b) ds,  of points sum_i w_i V_i sigma_i phi(x - x_i)
    kinetic stress sigma_k(x) = -sum_i w_i m_i v' v' phi(x - x_i),  v' = v_i - V(x)
    temperature    T(x)       = -tr(sigma_k)/(d rho)
    fraction       Phi(x)     = sum_i w_i V_i Phi_i phi(x - x_i),  Phi_i = 1 of grains
    fabric         F(x)       = sum_c n n int phi / sum_c int phi

Tension is positive. Where V changes within a kernel, v' has its share of that. phi is a product of cubic B-splines of a width c along the edges of the cell (it reaches 2 c to either side; its standard deviation is c/sqrt(3)), sampled every
c/samples. On such a lattice B-splines add up to one, so that mass, momentum and the mean stress of a field are those of its rows to round-off.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import h5py
import numpy as np

from scree.frames import Frame

#: Where a contact's line is sampled, as shares of it, and their weights (Gauss & Legendre).
_LINE = (0.5 + 0.5 * np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)]), np.array([5.0, 8.0, 5.0]) / 18.0)
#: Components of a symmetric tensor, in the order of the files.
_PAIRS = {2: [(0, 0), (1, 1), (0, 1)], 3: [(0, 0), (1, 1), (0, 1), (2, 2), (1, 2), (0, 2)]}


class Lattice:
    """Samples along the edges of a cell, around it along axes without a period."""

    def __init__(self, cell: dict[str, np.ndarray], places: np.ndarray, axes: int, width: float, samples: int):
        self.axes, self.samples = axes, samples
        self.corner = np.asarray(cell["cell_corner"], dtype=float)
        self.edges = np.asarray(cell["cell_edges"], dtype=float).reshape(3, 3)
        self.periodic = np.asarray(cell["cell_periodic"]).astype(bool)
        lengths = np.linalg.norm(self.edges, axis=1)
        wanted = width / samples
        #: Samples in the length of an edge; whole along a period, where the width is fitted to it.
        self.per_edge = np.array([max(round(length / wanted), 1) if periodic else length / wanted for length, periodic in zip(lengths, self.periodic)])[:axes]
        reduced = self.reduced(places)
        self.first, self.shape = np.zeros(axes, dtype=int), np.empty(axes, dtype=int)
        for axis in range(axes):
            if self.periodic[axis]:
                self.shape[axis] = int(self.per_edge[axis])
                continue
            least, most = (reduced[:, axis].min(), reduced[:, axis].max()) if len(reduced) else (0.0, self.per_edge[axis])
            self.first[axis] = int(np.floor(least)) - 2 * samples
            self.shape[axis] = int(np.ceil(most)) + 2 * samples - self.first[axis] + 1
        #: m; along each edge.
        self.spacing = lengths[:axes] / self.per_edge
        #: Volume that a sample stands for, m3; the cell of the plane is as thick as the job says.
        self.volume = abs(np.linalg.det(self.edges)) / self.per_edge.prod()
        if axes == 2:
            self.volume = abs(np.linalg.det(self.edges[:2, :2])) * lengths[2] / self.per_edge.prod()

    def reduced(self, places: np.ndarray) -> np.ndarray:
        """Places in samples from the corner along each edge."""
        edges = self.edges[: self.axes, : self.axes]
        return np.linalg.solve(edges.T, (places[:, : self.axes] - self.corner[: self.axes]).T).T * self.per_edge

    @property
    def points(self) -> np.ndarray:
        """Places of the samples (nx, ny[, nz], axes), m."""
        index = np.stack(np.meshgrid(*(self.first[axis] + np.arange(self.shape[axis]) for axis in range(self.axes)), indexing="ij"), axis=-1)
        return self.corner[: self.axes] + (index / self.per_edge) @ self.edges[: self.axes, : self.axes]

    def spread(self, places: np.ndarray, values: np.ndarray, derivative: int | None = None) -> np.ndarray:
        """sum_i values_i phi(x - x_i) at every sample, (values.shape[1], nx, ny[, nz]); with `derivative` the one of phi along that edge, by 1/m."""
        at = self.reduced(places)
        base = np.floor(at).astype(int)
        reach = 2 * self.samples
        total = np.zeros((values.shape[1], int(self.shape.prod())))
        steps = np.arange(1 - reach, reach + 1)
        weights, index = [], []
        for axis in range(self.axes):
            away = (base[:, axis, None] + steps - at[:, axis, None]) / self.samples
            if derivative == axis:
                weights.append(_spline_slope(away) / self.samples / (self.samples * self.spacing[axis]))
            else:
                weights.append(_spline(away) / self.samples)
            sample = base[:, axis, None] + steps - self.first[axis]
            index.append(sample % self.shape[axis] if self.periodic[axis] else sample)
        for step in np.ndindex(*(len(steps),) * self.axes):
            weight = np.prod([weights[axis][:, step[axis]] for axis in range(self.axes)], axis=0) / self.volume
            flat = np.ravel_multi_index([index[axis][:, step[axis]] for axis in range(self.axes)], self.shape)
            for row, column in enumerate(values.T):
                total[row] += np.bincount(flat, weights=weight * column, minlength=total.shape[1])
        return total.reshape(-1, *self.shape)


def _spline(x: np.ndarray) -> np.ndarray:
    """The cubic B-spline, of integral one."""
    x = np.abs(x)
    return np.where(x < 1, 2 / 3 - x**2 + 0.5 * x**3, np.where(x < 2, (2 - x) ** 3 / 6, 0.0))


def _spline_slope(x: np.ndarray) -> np.ndarray:
    far = np.abs(x)
    return np.sign(x) * np.where(far < 1, -2 * far + 1.5 * far**2, np.where(far < 2, -0.5 * (2 - far) ** 2, 0.0))


class Fields:
    """Fields at one time, each (nx, ny[, nz]) with its components behind; SI units, not a number where there is nothing."""

    def __init__(self, time: float, lattice: Lattice, values: dict[str, np.ndarray]):
        #: s.
        self.time = time
        self.lattice = lattice
        #: By their names: `density`, `velocity`, `velocity_gradient` (row by row), `strain_rate`, `kinetic_stress`, `temperature`, `fraction`, `stress`, `fabric`.
        self.values = values

    def __getitem__(self, name: str) -> np.ndarray:
        return self.values[name]

    @property
    def strain_rate(self) -> np.ndarray:
        """The symmetric part of the velocity gradient, 1/s."""
        return self["strain_rate"]

    def total(self, name: str) -> np.ndarray:
        """The integral of a field over all samples; where there is nothing it is zero."""
        return np.nansum(self[name], axis=tuple(range(self.lattice.axes))) * self.lattice.volume


def coarse_grain(frame: Frame, width: float, *, contacts: Frame | None = None, velocity_gradient: np.ndarray | None = None, samples: int = 2) -> Fields:
    """The fields of a frame, of grains, points or both, with a kernel of this width (m; two to three mean diameters show a shear band). `contacts`, the frame of
    `contacts.vtkhdf` of the same time, tell the stress of grains and their fabric; without them frames with grains have no `stress`. The width is fitted to whole samples along periods. `velocity_gradient` (1/s) is that of a periodic cell which deforms: rows beyond a period move with it, and
    v' is what they have beside it (`run.job["cell"]["velocity_gradient"]`; where a stress is held, of the edges of two frames). Vertices of membranes are left out."""
    kind = frame.fields.get("kind", np.ones(len(frame), dtype=int))
    rows = frame.where(kind != 3)
    if "mass" not in rows.fields:
        raise ValueError("these frames have no field `mass`; they were written by a version before 0.2")
    axes = 2 if frame["stress"].shape[1] == 3 else 3
    places, velocity = rows.positions, rows["velocity"][:, :axes]
    ends = contacts.places.reshape(-1, 3) if contacts is not None and len(contacts) else np.empty((0, 3))
    lattice = Lattice(frame.cell, np.concatenate([places, ends]), axes, width, samples)
    depth = np.linalg.norm(lattice.edges[2])
    radius, share = rows["radius"], rows["weight"]
    affine = np.zeros((axes, axes)) if velocity_gradient is None else np.asarray(velocity_gradient, dtype=float)[:axes, :axes]
    velocity = velocity - (places[:, :axes] - lattice.corner[:axes]) @ affine.T
    volume = share * (np.pi * radius**2 * depth if axes == 2 else 4 / 3 * np.pi * radius**3)
    mass = share * rows["mass"]
    pairs = _PAIRS[axes]
    is_point = kind[kind != 3] == 0
    solid = np.where(is_point, rows.fields.get("fraction", np.ones(len(rows))), 1.0)
    motion = np.column_stack([mass, mass[:, None] * velocity, *(mass * velocity[:, i] * velocity[:, j] for i, j in pairs), volume * solid])
    spread = lattice.spread(places, motion)
    density, momentum, fluxes, fraction = spread[0], spread[1 : 1 + axes], spread[1 + axes : -1], spread[-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        there = np.where(density > 0, density, np.nan)
        mean = momentum / there
        kinetic = np.stack([mean[i] * mean[j] * density - flux for (i, j), flux in zip(pairs, fluxes)])
        slopes = np.stack([lattice.spread(places, motion[:, : 1 + axes], derivative=edge) for edge in range(axes)])
        along = (slopes[:, 1:] - mean * slopes[:, :1]) / there
    # Slopes along edges, to those along axes.
    directions = lattice.edges[:axes, :axes] / np.linalg.norm(lattice.edges[:axes, :axes], axis=1, keepdims=True)
    gradient = np.einsum("je,ei...->ij...", np.linalg.inv(directions), along)
    last = lambda field: np.moveaxis(field, 0, -1)
    trace = sum(kinetic[number] for number, (i, j) in enumerate(pairs) if i == j)
    values = {
        "density": density,
        "velocity": last(mean) + (lattice.points - lattice.corner[:axes]) @ affine.T,
        "velocity_gradient": last(gradient.reshape(axes * axes, *lattice.shape)) + affine.ravel(),
        "strain_rate": last(np.stack([0.5 * (gradient[i, j] + gradient[j, i] + affine[i, j] + affine[j, i]) for i, j in pairs])),
        "kinetic_stress": last(kinetic),
        "temperature": -trace / (axes * there),
        "fraction": fraction,
    }
    stress = lattice.spread(places[is_point], (volume[:, None] * rows["stress"])[is_point])
    if contacts is not None:
        begin, branch = contacts.places[:, 0], contacts.places[:, 1] - contacts.places[:, 0]
        force, held = contacts["force"] * contacts["weight"][:, None], contacts["weight"]
        normal = branch / np.linalg.norm(branch, axis=1, keepdims=True)
        moment = np.column_stack([0.5 * (force[:, i] * branch[:, j] + force[:, j] * branch[:, i]) for i, j in pairs])
        ties = np.column_stack([held, *(held * normal[:, i] * normal[:, j] for i, j in pairs)])
        told = sum(part * lattice.spread(begin + at * branch, np.column_stack([moment, ties])) for at, part in zip(*_LINE))
        stress = stress + told[: len(pairs)]
        with np.errstate(divide="ignore", invalid="ignore"):
            values["fabric"] = last(told[len(pairs) + 1 :] / np.where(told[len(pairs)] > 0, told[len(pairs)], np.nan))
    # That of grains is told by their contacts alone.
    if contacts is not None or is_point.all():
        values["stress"] = last(stress)
    return Fields(frame.time, lattice, values)


def write_images(path: str | Path, fields: Iterable[Fields]) -> None:
    """Fields over time as one image for ParaView 5.13 or later (VTKHDF `ImageData`). Their cell must be upright and stay as it is; frames may have grown beyond it, so
    that the image is around all of them. Tensors of space are xx, yy, zz, xy, yz, xz there, as VTK has them."""
    fields = list(fields)
    if not fields:
        raise ValueError("there are no fields")
    one = fields[0].lattice
    axes = one.axes
    upright = np.count_nonzero(one.edges - np.diag(np.diag(one.edges))) == 0
    if not upright or any(not np.array_equal(other.lattice.edges, one.edges) or other.lattice.samples != one.samples for other in fields):
        raise ValueError("an image has upright edges that do not change, and these cells deform; use the arrays")
    first = np.min([other.lattice.first for other in fields], axis=0)
    shape = np.max([other.lattice.first + other.lattice.shape for other in fields], axis=0) - first
    whole = np.ones(3, dtype=int)
    whole[:axes] = shape
    spacing = np.append(one.spacing, [1.0] * (3 - axes))
    origin = np.zeros(3)
    origin[:axes] = one.corner[:axes] + first * one.spacing
    with h5py.File(path, "w") as file:
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = np.array([2, 0], dtype="i8")
        root.attrs.create("Type", b"ImageData", dtype=h5py.string_dtype("ascii", len("ImageData")))
        root.attrs["WholeExtent"] = np.ravel([[0, count - 1] for count in whole]).astype("i8")
        root.attrs["Origin"], root.attrs["Spacing"] = origin, spacing
        root.attrs["Direction"] = np.eye(3).ravel()
        steps = root.create_group("Steps")
        steps.attrs["NSteps"] = len(fields)
        steps["Values"] = [other.time for other in fields]
        data, offsets = root.create_group("PointData"), steps.create_group("PointDataOffsets")
        for name in fields[0].values:
            parts = []
            for other in fields:
                lattice, value = other.lattice, other[name]
                # Around smaller ones there is nothing.
                padded = np.full((*shape, *value.shape[axes:]), 0.0 if name in ("density", "fraction", "stress") else np.nan)
                start = lattice.first - first
                padded[tuple(slice(begin, begin + count) for begin, count in zip(start, lattice.shape))] = value
                # x is the fastest in an image; VTK wants one of a plane without its third axis, and tensors as xx, yy, zz, xy, yz, xz.
                padded = padded.transpose(*reversed(range(axes)), *range(axes, padded.ndim))
                if axes == 3 and padded.shape[-1] == 6 and padded.ndim == 4:
                    padded = padded[..., [0, 1, 3, 2, 4, 5]]
                if name == "velocity" and axes == 2:
                    padded = np.concatenate([padded, np.zeros_like(padded[..., :1])], axis=-1)
                parts.append(padded)
            data.create_dataset(name, data=np.stack(parts), compression="gzip", compression_opts=1)
            offsets[name] = np.arange(len(fields), dtype="i8")

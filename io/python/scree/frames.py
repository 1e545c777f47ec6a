"""Frames of a run: `frames.vtkhdf`, `elements.vtkhdf`, `contacts.vtkhdf` and those of RVEs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

#: `kind` of a row of `frames.vtkhdf`.
POINT, GRAIN, GLUED_GRAIN, VERTEX = range(4)


class Frame:
    """What there is at one time: a row for each point or grain (1 corner), contact (2: its ends) or element (4, around it)."""

    def __init__(self, time: float, places: np.ndarray, fields: dict[str, np.ndarray], cell: dict[str, np.ndarray]):
        #: s.
        self.time = time
        #: Corners of each row (rows, corners, 3), m.
        self.places = places
        #: Fields by their names, a row for each.
        self.fields = fields
        #: The cell: `cell_corner` (3), m, `cell_edges` (9: one edge after the other), m, and `cell_periodic` (3); empty of contacts.
        self.cell = cell

    def __len__(self) -> int:
        return len(self.places)

    def __getitem__(self, name: str) -> np.ndarray:
        return self.fields[name]

    @property
    def positions(self) -> np.ndarray:
        """Places of points and grains, middles of contacts and elements (rows, 3), m."""
        return self.places.mean(axis=1)

    def where(self, mask: np.ndarray) -> Frame:
        """The rows for which `mask` is true."""
        return Frame(self.time, self.places[mask], {name: field[mask] for name, field in self.fields.items()}, self.cell)

    def _of_kinds(self, *kinds: int) -> Frame:
        # Those of RVEs are all grains, and do not say so.
        kind = self.fields.get("kind", np.full(len(self), GRAIN))
        return self.where(np.isin(kind, kinds))

    @property
    def grains(self) -> Frame:
        """Grains, those that are glued to bodies among them."""
        return self._of_kinds(GRAIN, GLUED_GRAIN)

    @property
    def points(self) -> Frame:
        """Material points."""
        return self._of_kinds(POINT)

    @property
    def vertices(self) -> Frame:
        """Vertices of membranes."""
        return self._of_kinds(VERTEX)

    def to_pyvista(self) -> Any:
        """The same as a PyVista mesh of vertices, lines or quadrilaterals, with the fields of its cells."""
        import pyvista

        rows, corners = self.places.shape[:2]
        cells = np.column_stack([np.full(rows, corners), np.arange(rows * corners).reshape(rows, corners)]).ravel()
        kind = {1: "verts", 2: "lines", 4: "faces"}[corners]
        mesh = pyvista.PolyData(self.places.reshape(-1, 3), **{kind: cells})
        for name, field in self.fields.items():
            mesh.cell_data[name] = field
        return mesh


def _text(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)


class _Part:
    """One file of frames. A run that has written much has several: frames.vtkhdf, frames.2.vtkhdf and so on."""

    def __init__(self, path: Path):
        self.path = path
        with h5py.File(path, "r") as file:
            root = file["VTKHDF"]
            if "Steps" not in root:
                raise ValueError(f"{path} has no steps; it is no file of frames by scree")
            self.times: np.ndarray = root["Steps/Values"][:]
            # Fields of points are theirs, of what has several corners those of the cell.
            self.group = "PointData" if len(root.get("PointData", ())) else "CellData"
            self.corners = int(root["Steps"].attrs.get("Corners", 1 if self.group == "PointData" else 2))
            self.names = sorted(root.get(self.group, ()))
            # Files of before fields told it have none.
            told = {name: root[f"{self.group}/{name}"].attrs for name in self.names}
            self.units = {name: _text(attributes["units"]) for name, attributes in told.items() if "units" in attributes}
            self.meanings = {name: _text(attributes["long_name"]) for name, attributes in told.items() if "long_name" in attributes}
            self.provenance = {name: _text(value) for name, value in file.attrs.items()}

    def frame(self, at: int) -> Frame:
        with h5py.File(self.path, "r") as file:
            root = file["VTKHDF"]
            steps = root["Steps"]
            first, count = int(steps["PointOffsets"][at]), int(root["NumberOfPoints"][at])
            places = root["Points"][first : first + count].reshape(-1, self.corners, 3)
            fields = {}
            for name in self.names:
                begin = int(steps[f"{self.group}Offsets/{name}"][at])
                fields[name] = root[f"{self.group}/{name}"][begin : begin + len(places)]
            cell = {}
            for name in root.get("FieldData", ()):
                cell[name] = root[f"FieldData/{name}"][int(steps[f"FieldDataOffsets/{name}"][at])]
            return Frame(float(self.times[at]), places, fields, cell)


class Frames(Sequence):
    """All frames of a run, read one at a time."""

    def __init__(self, path: str | Path):
        self.path = Path(path)
        self._parts = [_Part(self.path)]
        while (beside := self.path.with_name(f"{self.path.stem}.{len(self._parts) + 1}{self.path.suffix}")).exists():
            self._parts.append(_Part(beside))
        #: Their times, s. At an enrichment there are two of one time; the later one is what the run went on with.
        self.times = np.concatenate([part.times for part in self._parts])

    @property
    def names(self) -> list[str]:
        """Names of their fields."""
        return self._parts[0].names

    @property
    def units(self) -> dict[str, str]:
        """Units of their fields, "1" of pure numbers; empty of files by a version before 0.2."""
        return self._parts[-1].units

    @property
    def meanings(self) -> dict[str, str]:
        """What their fields are, in words."""
        return self._parts[-1].meanings

    @property
    def provenance(self) -> dict[str, str]:
        """Which `program` wrote them, of which `run`, from which `job` (its digest)."""
        return self._parts[0].provenance

    def __len__(self) -> int:
        return len(self.times)

    def __iter__(self) -> Iterator[Frame]:
        return (self[index] for index in range(len(self)))

    def __getitem__(self, index: int | slice) -> Any:
        if isinstance(index, slice):
            return [self[at] for at in range(*index.indices(len(self)))]
        at = range(len(self))[index]
        for part in self._parts:
            if at < len(part.times):
                return part.frame(at)
            at -= len(part.times)
        raise AssertionError("a frame is in one of the parts")

    def at(self, time: float) -> Frame:
        """The frame nearest to a time, s; of two that are as near the later one."""
        away = np.abs(self.times - time)
        return self[int(np.flatnonzero(away == away.min())[-1])]

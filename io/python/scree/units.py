"""Units of the columns of `series.csv`, as docs/columns.md has them; the package carries a copy of that page."""

from __future__ import annotations

import re
from functools import lru_cache
from importlib.resources import files


@lru_cache(maxsize=1)
def _table() -> list[tuple[re.Pattern[str], str]]:
    text = files("scree").joinpath("columns.md").read_text()
    rules = []
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split(" | ")]
        if not line.startswith("| `") or len(cells) < 2:
            continue
        names, units = re.findall(r"`([^`]+)`", cells[0]), [unit.strip() for unit in cells[1].split(",")]
        for number, name in enumerate(names):
            rules.append((_pattern(name), units[min(number, len(units) - 1)]))
    # A name that stands there as it is goes before one with a part that varies.
    return sorted(rules, key=lambda rule: rule[0].pattern.count(".+") + rule[0].pattern.count("["))


def _pattern(name: str) -> re.Pattern[str]:
    escaped = re.escape(name).replace("NAME", ".+")
    escaped = re.sub(r"_ij$", "_[xyz]{2}", escaped)
    escaped = re.sub(r"_i$", "_[xyz]", escaped)
    return re.compile(escaped + "$")


def unit_of(column: str) -> str | None:
    """The unit of a column, "1" of a pure number; none of one that is not known."""
    for pattern, unit in _table():
        if pattern.match(column):
            return unit
    return None

"""Suites of tests: a folder of scenarios with one table, `suite.toml`, whose rows expand into cells.

A group of the table has one scenario, one criterion and one source. Each of its rows is a product of lists of values. A
key of several params, such as `"SPEED TARGET_SPEED"`, lists their values together.
"""

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

from engine.errors import ArgumentError, nearest
from engine.gates.ratings import Rule

TABLE = "suite.toml"
SUITES = Path(__file__).parents[1] / "suites"
"""Folder of the suites of the package."""
Number = int | float | str
IMPACTS = {"relative": -1.0, "ego": 0.0, "oncoming": 1.0}
"""Impact speed of a target in the direction of the ego, across it, and against it: share of the target's speed that is
added to that of the ego.
"""
VERIFIED, UNVERIFIED = "verified", "unverified"


class SuiteError(ArgumentError):
    """A suite that does not exist, or whose table cannot be used."""


@dataclass(frozen=True)
class Cell:
    """A test of a suite."""

    id: str
    group: str
    number: int
    """Place in the whole table, from 0; random numbers follow from it."""
    range: str
    """Range of its points: standard or extended; "" if the suite has none."""
    params: Mapping[str, Number]
    """Values of params, in the units of the scenario; a text is a label that only its id has."""
    search: Mapping[str, tuple[float, float]]
    """Ranges of params in which a contact is searched."""
    rule: Rule
    limit: float
    """Largest impact speed of `Rule.LIMIT` [km/h]."""
    source: str
    status: str
    """`verified` or `unverified`: whether its values were read in the document."""
    reason: str = ""
    """Reason why it cannot be run; "" if it can."""


@dataclass(frozen=True)
class Group:
    """Cells of one scenario."""

    name: str
    file: Path | None
    """None if it cannot be run."""
    impact: str
    """Impact speed, a key of `IMPACTS`."""
    points: Mapping[str, float]
    """Points by range; {} if some of its cells are missing."""
    cells: tuple[Cell, ...]

    def only(self, patterns: Sequence[str]) -> "Group":
        """Return the group with the cells that match a pattern; it has points only with all of its cells."""
        kept = tuple(cell for cell in self.cells if any(_matches(cell, each) for each in patterns))
        return replace(self, cells=kept, points=self.points if len(kept) == len(self.cells) else {})


@dataclass(frozen=True)
class Suite:
    """A folder of tests."""

    name: str
    folder: Path
    title: str
    edition: str
    document: str
    notes: tuple[str, ...]
    entry: tuple[str, ...]
    """Patterns of cells that must be green; otherwise there are no points."""
    groups: tuple[Group, ...]

    @cached_property
    def cells(self) -> tuple[Cell, ...]:
        return tuple(cell for group in self.groups for cell in group.cells)

    def only(self, patterns: Sequence[str]) -> "Suite":
        """Return the suite with the cells that match a pattern: `CCR*`, `CCRs/40/*`.

        Raises:
            SuiteError: a pattern matches none.
        """
        for pattern in patterns:
            if not any(_matches(cell, pattern) for cell in self.cells):
                near = nearest(pattern.split("/")[0], [group.name for group in self.groups])
                meant = f"did you mean `{near}`? " if near else ""
                names = ", ".join(group.name for group in self.groups)
                raise SuiteError(f"--only `{pattern}` matches no cell of {self.name}", f"{meant}there are {names}")
        groups = (group.only(patterns) for group in self.groups)
        return replace(self, groups=tuple(group for group in groups if group.cells))


def _matches(cell: Cell, pattern: str) -> bool:
    return fnmatchcase(cell.id, pattern) or fnmatchcase(cell.group, pattern)


# -- the shipped ones --------------------------------------------------------------------------------------------------


def suite_names() -> tuple[str, ...]:
    """Return the names of the suites of the package."""
    return tuple(sorted(path.parent.name for path in SUITES.glob(f"*/{TABLE}")))


def suite_of(name: str) -> Suite:
    """Return a suite of the package, or that of a folder with a `suite.toml`.

    Raises:
        SuiteError: there is none, or its table cannot be used.
    """
    names = suite_names()
    folder = SUITES / name if name in names else Path(name)
    if not (folder / TABLE).is_file():
        near = nearest(name, names)
        meant = f"did you mean `{near}`? " if near else ""
        cure = f"{meant}there are {', '.join(names)}, or name a folder with a {TABLE}"
        raise SuiteError(f"there is no suite `{name}`", cure)
    return read_suite(folder)


# -- the table ---------------------------------------------------------------------------------------------------------


def read_suite(folder: Path) -> Suite:
    """Return the suite of a folder.

    Raises:
        SuiteError: its table cannot be read; the message names the group and the key.
    """
    path = folder / TABLE
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise SuiteError(f"cannot read {path}: {error}", "name a folder with a table") from None
    except tomllib.TOMLDecodeError as error:
        raise SuiteError(f"{path} is no TOML: {error}", "correct that line") from None
    _Keys(path, "", table).check(_SUITE)
    groups, number = list[Group](), 0
    for row in table["groups"]:
        group = _group(path, folder, row, number)
        number += len(group.cells)
        groups.append(group)
    _check_unique(path, groups)
    return Suite(
        name=folder.resolve().name,
        folder=folder,
        title=table["title"],
        edition=table["edition"],
        document=table["document"],
        notes=tuple(table.get("notes", ())),
        entry=tuple(table.get("entry", ())),
        groups=tuple(groups),
    )


_SUITE = {"title": str, "edition": str, "document": str, "groups": list}
_GROUP = {"name": str, "source": str, "status": str, "id": list, "cells": list}
_OPTIONAL = {
    "file": str, "rule": str, "impact": str, "points": dict, "hold": dict, "limit": (int, float), "reason": str,
    "search": dict, "range": str, "notes": list, "entry": list,
}  # fmt: skip
_OF_ROW = ("range", "rule", "hold", "limit", "reason", "search", "status", "source")
"""Keys of a row that are no params; those of its group have effect where the row has none."""


@dataclass(frozen=True)
class _Keys:
    """Keys of a part of the table, with what to call it in a message."""

    path: Path
    place: str
    row: Mapping[str, Any]

    def check(self, needed: Mapping[str, Any], params: bool = False) -> None:
        for key, kind in needed.items():
            if key not in self.row:
                raise self.mistake(f"has no `{key}`")
            self._check_kind(key, kind)
        for key in self.row.keys() - needed.keys():
            if key in _OPTIONAL:
                self._check_kind(key, _OPTIONAL[key])
            elif key in _GROUP:
                self._check_kind(key, _GROUP[key])
            elif not params:
                near = nearest(key, [*needed, *_OPTIONAL])
                raise self.mistake(f"has an unknown key `{key}`" + (f"; did you mean `{near}`?" if near else ""))

    def _check_kind(self, key: str, kind: Any) -> None:
        if not isinstance(self.row[key], kind):
            raise self.mistake(f"has a `{key}` of another kind: {self.row[key]!r}")

    def mistake(self, what: str) -> SuiteError:
        return SuiteError(f"{self.path}{self.place} {what}", "see `cortexc suite NAME --copy FOLDER` for an example")


def _group(path: Path, folder: Path, row: Mapping[str, Any], first: int) -> Group:
    keys = _Keys(path, f", group `{row.get('name', '?')}`,", row)
    keys.check(_GROUP)
    if ("file" in row) == ("reason" in row):
        raise keys.mistake("needs either a `file` or a `reason` why it cannot be run")
    file = folder / row["file"] if "file" in row else None
    if file is not None and not file.is_file():
        raise keys.mistake(f"names `{row['file']}`, which is not there")
    if (impact := row.get("impact", "relative")) not in IMPACTS:
        raise keys.mistake(f"has the impact `{impact}`; there are {', '.join(IMPACTS)}")
    cells = list[Cell]()
    for part in row["cells"]:
        _Keys(path, keys.place, part).check({}, params=True)
        cells += _cells(keys, row, part, first + len(cells))
    return Group(row["name"], file, impact, row.get("points", {}), tuple(cells))


def _cells(keys: _Keys, group: Mapping[str, Any], part: Mapping[str, Any], first: int) -> Iterator[Cell]:
    """Yield the cells of one row of a group."""
    lists = {tuple(key.split()): values for key, values in part.items() if key not in _OF_ROW}
    given = {key: part.get(key, group.get(key)) for key in _OF_ROW if key != "hold"}
    hold = {**group.get("hold", {}), **part.get("hold", {})}
    try:
        rule = Rule(given["rule"] or Rule.LIMIT)
    except ValueError:
        raise keys.mistake(f"has the rule `{given['rule']}`; there are {', '.join(Rule)}") from None
    if given["status"] not in (VERIFIED, UNVERIFIED):
        raise keys.mistake(f"has the status `{given['status']}`; there are {VERIFIED} and {UNVERIFIED}")
    search = {name: (float(low), float(high)) for name, (low, high) in (given["search"] or {}).items()}
    for number, values in enumerate(product(*lists.values()), start=first):
        params: dict[str, Number] = dict(hold)
        for names, value in zip(lists, values, strict=True):
            several = value if isinstance(value, list) else [value]
            if len(several) != len(names):
                raise keys.mistake(f"has {len(several)} values for {' '.join(names)}")
            params.update(zip(names, several, strict=True))
        missing = [name for name in group["id"] if name not in params]
        if missing:
            raise keys.mistake(f"has cells without `{missing[0]}`, which their id needs")
        limit = params.pop("LIMIT", given["limit"] or 0.0)
        yield Cell(
            id="/".join([group["name"], *(f"{params[name]}" for name in group["id"])]),
            group=group["name"],
            number=number,
            range=given["range"] or "",
            params=params,
            search=search,
            rule=rule,
            limit=float(limit),
            source=given["source"],
            status=given["status"],
            reason=given["reason"] or "",
        )


def _check_unique(path: Path, groups: Sequence[Group]) -> None:
    seen = set[str]()
    for cell in (cell for group in groups for cell in group.cells):
        if cell.id in seen:
            raise SuiteError(f"{path}: two cells are called `{cell.id}`", "name another param in `id`")
        seen.add(cell.id)

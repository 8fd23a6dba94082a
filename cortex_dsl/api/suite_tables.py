"""Suites of tests: a folder of scenarios with one table, `suite.toml`, whose rows expand into cells.

A group of the table has one scenario, one criterion and one source. Each of its rows is a product of lists of values. A
key of several params, such as `"SPEED TARGET_SPEED"`, lists their values together.
"""

import math
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine.errors import ArgumentError, nearest
from engine.gates.ratings import EXTENDED, FASTEST, MITIGATION_OR_AVOIDANCE, STANDARD, UNVERIFIED, VERIFIED, Rule

if TYPE_CHECKING:
    from cortex_dsl.report.findings.suite_report import CellResult

TABLE = "suite.toml"
SUITES = Path(__file__).parents[1] / "suites"
"""Folder of the suites of the package."""
Number = int | float | str
IMPACTS = {"relative": -1.0, "ego": 0.0, "oncoming": 1.0}
"""Impact speed of a target in the direction of the ego, across it, and against it: share of the target's speed that is
added to that of the ego.
"""


WARNING, LIGHT = "warning", "light"
NEEDS = {WARNING: "a driver that warns", LIGHT: "a driver that states how its sensor depends on light"}
"""What cells may need of a driver, in words."""


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
    """Ranges of params in which a failure is searched."""
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
    needs: str = ""
    """What the driver must have, of `NEEDS`; "": nothing."""

    def only(self, patterns: Sequence[str]) -> "Group":
        """Return the group with the cells that match a pattern; it has points only with all of its cells."""
        kept = tuple(cell for cell in self.cells if any(matches(cell, each) for each in patterns))
        return replace(self, cells=kept, points=self.points if len(kept) == len(self.cells) else {})


@dataclass(frozen=True)
class Suite:
    """A folder of tests."""

    name: str
    folder: Path
    title: str
    edition: str
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
            if not any(matches(cell, pattern) for cell in self.cells):
                near = nearest(pattern.split("/")[0], [group.name for group in self.groups])
                meant = f"did you mean `{near}`? " if near else ""
                names = ", ".join(group.name for group in self.groups)
                raise SuiteError(f"--only `{pattern}` matches no cell of {self.name}", f"{meant}there are {names}")
        groups = (group.only(patterns) for group in self.groups)
        return replace(self, groups=tuple(group for group in groups if group.cells))


def matches(cell: "Cell | CellResult", pattern: str) -> bool:
    """Return True if the id or the group of a cell matches."""
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
        raise SuiteError(f"{path} is not valid TOML: {error}", "correct that line") from None
    _Keys(path, "", table).check(_SUITE)
    groups, number = list[Group](), 0
    for row in table["groups"]:
        group = _group(path, folder, row, number)
        number += len(group.cells)
        groups.append(group)
    _check_unique(path, groups)
    suite = Suite(
        name=folder.resolve().name,
        folder=folder,
        title=table["title"],
        edition=table["edition"],
        notes=tuple(table.get("notes", ())),
        entry=tuple(table.get("entry", ())),
        groups=tuple(groups),
    )
    for pattern in suite.entry:
        if not any(matches(cell, pattern) for cell in suite.cells):
            raise SuiteError(f"{path}: the pattern `{pattern}` of `entry` matches no cell", "correct the pattern")
    return suite


@dataclass(frozen=True)
class _Kind:
    """Kind of the value of a key."""

    text: str
    holds: Callable[[Any], bool]


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _is_text(value: object) -> bool:
    return isinstance(value, str)


def _is_value(value: object) -> bool:
    return _is_number(value) or _is_text(value)


def _list_of(holds: Callable[[Any], bool], fewest: int = 0) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, list) and len(value) >= fewest and all(map(holds, value))


def _table_of(holds: Callable[[Any], bool], keys: Sequence[str] = ()) -> Callable[[Any], bool]:
    return lambda value: (
        isinstance(value, dict) and all(map(holds, value.values())) and (not keys or value.keys() <= set(keys))
    )


def _choice(names: Sequence[str]) -> _Kind:
    return _Kind(" or ".join(filter(None, [", ".join(names[:-1]), names[-1]])), lambda value: value in (*names,))


def _is_limit(value: object) -> bool:
    return _is_number(value) and float(value) >= 0.0  # type: ignore[arg-type]


_TEXT, _LIMIT = _Kind("a text", _is_text), _Kind("a number from 0 on", _is_limit)
_TEXTS = _Kind("a list of texts", _list_of(_is_text))
_TABLES = _Kind("a list of at least one table", _list_of(lambda value: isinstance(value, dict), 1))
_VALUES = _Kind(
    "a list of at least one number or text, or of lists of them",
    _list_of(lambda value: _is_value(value) or _list_of(_is_value, 1)(value), 1),
)
_STATUS = _choice((VERIFIED, UNVERIFIED))
_SUITE = {"title": _TEXT, "edition": _TEXT, "groups": _TABLES, "notes": _TEXTS, "entry": _TEXTS}
_ROW = {
    "range": _choice((STANDARD, EXTENDED)),
    "rule": _choice(tuple(Rule)),
    "hold": _Kind("a table of numbers and texts", _table_of(_is_value)),
    "limit": _LIMIT,
    "search": _Kind(
        "a table of ranges, as in `{ SPEED = [10, 80] }`",
        _table_of(lambda value: _list_of(_is_number, 2)(value) and len(value) == 2),
    ),
    "status": _STATUS,
    "source": _TEXT,
}
"""Keys of a row that are no params; those of its group have effect where the row has none."""
_GROUP = {
    "name": _TEXT,
    "id": _TEXTS,
    "cells": _TABLES,
    "file": _TEXT,
    "reason": _TEXT,
    "impact": _choice(tuple(IMPACTS)),
    "needs": _choice(tuple(NEEDS)),
    "points": _Kind(
        f"a table of numbers with the keys {STANDARD} and {EXTENDED}", _table_of(_is_number, (STANDARD, EXTENDED))
    ),
    **_ROW,
}
_NEEDED = ("title", "edition", "groups", "name", "source", "status", "id", "cells")
"""Keys without which the table or a group cannot be used."""


@dataclass(frozen=True)
class _Keys:
    """Keys of a part of the table, with what to call it in a message."""

    path: Path
    place: str
    row: Mapping[str, Any]

    def check(self, kinds: Mapping[str, _Kind]) -> None:
        for key in kinds:
            if key in _NEEDED and key not in self.row:
                raise self.mistake(f"has no `{key}`")
        for key in self.row:
            if key not in kinds:
                near = nearest(key, list(kinds))
                raise self.mistake(f"has an unknown key `{key}`" + (f"; did you mean `{near}`?" if near else ""))
            self._check_kind(key, kinds[key])

    def check_row(self) -> None:
        """Check a row of a group, whose other keys are params."""
        for key in self.row:
            if key not in _ROW and (key in _GROUP or key in _SUITE):
                raise self.mistake(f"has the key `{key}` in a row, where it has no effect")
            self._check_kind(key, _ROW.get(key, _VALUES))

    def _check_kind(self, key: str, kind: _Kind) -> None:
        if not kind.holds(self.row[key]):
            raise self.mistake(f": `{key}` is {self.row[key]!r}; expected {kind.text}")

    def mistake(self, what: str) -> SuiteError:
        head = f"{self.path}{self.place}"
        text = f"{head}{what}" if what.startswith(":") else f"{head} {what}"
        return SuiteError(text, "see `cortexc suite NAME --copy FOLDER` for an example")


def _group(path: Path, folder: Path, row: Mapping[str, Any], first: int) -> Group:
    keys = _Keys(path, f", group `{row.get('name', '?')}`", row)
    keys.check(_GROUP)
    if ("file" in row) == ("reason" in row):
        raise keys.mistake("needs either a `file` or a `reason` why it cannot be run")
    file = folder / row["file"] if "file" in row else None
    if file is not None and not file.is_file():
        raise keys.mistake(f"names `{row['file']}`, which is not there")
    cells = list[Cell]()
    for part in row["cells"]:
        _Keys(path, keys.place, part).check_row()
        cells += _cells(keys, row, part, first + len(cells))
    return Group(
        row["name"], file, row.get("impact", "relative"), row.get("points", {}), tuple(cells), row.get("needs", "")
    )


def _cells(keys: _Keys, group: Mapping[str, Any], part: Mapping[str, Any], first: int) -> Iterator[Cell]:
    """Yield the cells of one row of a group."""
    lists = {tuple(key.split()): values for key, values in part.items() if key not in _ROW}
    given = {key: part.get(key, group.get(key)) for key in _ROW if key != "hold"}
    hold = {**group.get("hold", {}), **part.get("hold", {})}
    rule = Rule(given["rule"] or Rule.LIMIT)
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
        if not _LIMIT.holds(limit):
            raise keys.mistake(f": `LIMIT` is {limit!r}; expected {_LIMIT.text}")
        _check_speed(keys, rule, params, search)
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
            reason=group.get("reason", ""),
        )


def _check_speed(keys: _Keys, rule: Rule, params: Mapping[str, Number], search: Mapping[str, object]) -> None:
    """Check that a cell has the speed of the ego that its rule needs.

    Raises:
        SuiteError: it has none, or one without bands.
    """
    has_bands = rule is Rule.MITIGATION_OR_AVOIDANCE
    if not has_bands and (rule is not Rule.MITIGATION or "SPEED" in search):
        return
    speed = None if "SPEED" in search else params.get("SPEED")
    if not isinstance(speed, int | float):
        raise keys.mistake(f"has cells without a number for `SPEED`, which the rule `{rule}` needs")
    if has_bands and min(speed, FASTEST) not in MITIGATION_OR_AVOIDANCE:
        some = ", ".join(f"{each:g}" for each in MITIGATION_OR_AVOIDANCE)
        raise keys.mistake(f": `SPEED` is {speed:g}; the rule `{rule}` has bands for {some} km/h and above")


def _check_unique(path: Path, groups: Sequence[Group]) -> None:
    seen = set[str]()
    for cell in (cell for group in groups for cell in group.cells):
        if cell.id in seen:
            raise SuiteError(f"{path}: two cells are called `{cell.id}`", "name another param in `id`")
        seen.add(cell.id)

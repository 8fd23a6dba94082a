"""Tables of suites: each key has one place and one kind, and what a cell needs is checked before a run."""

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl.api.suite_tables import Suite, SuiteError, matches, read_suite, suite_of


def toml(value: Any) -> str:
    """Return a value as TOML."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {toml(each)}" for key, each in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value)


def written(folder: Path, top: dict[str, Any], group: dict[str, Any], row: dict[str, Any]) -> Suite:
    """Write a table with one group of one row, and read it."""
    (folder / "a.scn").write_text("")
    row = {"SPEED": [10, 20], "hold": {"TARGET_SPEED": 0}, "range": "standard", **row}
    group = {
        "name": "a", "file": "a.scn", "source": "s", "status": "verified", "id": ["SPEED"], "cells": [row], **group
    }  # fmt: skip
    table = {"title": "t", "edition": "e", "groups": [group], **top}
    (folder / "suite.toml").write_text("".join(f"{json.dumps(key)} = {toml(each)}\n" for key, each in table.items()))
    return read_suite(folder)


@pytest.mark.parametrize(
    ("place", "key", "value", "message"),
    [
        ("row", "SPEED", 5, "`SPEED` is 5; expected a list"),
        ("row", "SPEED", [], "`SPEED` is []; expected a list of at least one"),
        ("row", "LIMIT", ["x"], "`LIMIT` is 'x'; expected a number"),
        ("row", "search", {"X": 5}, "`search` is {'X': 5}; expected a table of ranges"),
        ("row", "search", {"X": [1, 2, 3]}, "expected a table of ranges"),
        ("row", "impact", "ego", "has the key `impact` in a row"),
        ("row", "entry", ["a"], "has the key `entry` in a row"),
        ("row", "reason", "no", "has the key `reason` in a row"),
        ("row", "range", "standart", "expected standard or extended"),
        ("group", "entry", ["a"], "has an unknown key `entry`"),
        ("group", "notes", ["a"], "has an unknown key `notes`"),
        ("group", "points", {"standart": 1}, "`points` is {'standart': 1}; expected"),
        ("group", "cells", [], "expected a list of at least one table"),
        ("group", "limit", True, "`limit` is True; expected a number"),
        ("top", "hold", {"SPEED": 5}, "has an unknown key `hold`"),
        ("top", "title", 5, "`title` is 5; expected a text"),
        ("top", "groups", [5], "expected a list of at least one table"),
        ("top", "entry", ["b/*"], "the pattern `b/*` of `entry` matches no cell"),
    ],
)
def test_a_key_has_one_place_and_one_kind(tmp_path: Path, place: str, key: str, value: object, message: str) -> None:
    """The message has the place, the value and what was expected."""
    parts = {"top": {}, "group": {}, "row": {}, place: {key: value}}
    with pytest.raises(SuiteError) as found:
        written(tmp_path, **parts)
    assert message in found.value.message
    assert ("group `a`" in found.value.message) == (place != "top")


KEYS = (
    "title", "edition", "groups", "notes", "entry", "name", "id", "cells", "file", "reason", "impact", "points",
    "range", "rule", "hold", "limit", "search", "status", "source", "SPEED", "LIMIT", "SPEED LIMIT",
)  # fmt: skip
VALUES = st.recursive(
    st.none().map(lambda _: 5) | st.booleans() | st.text("aE/*", max_size=2) | st.floats(-1e3, 1e3),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(KEYS), inner, max_size=2),
    max_leaves=5,
)


@given(place=st.sampled_from(["top", "group", "row"]), key=st.sampled_from(KEYS), value=VALUES)
def test_a_table_is_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, place: str, key: str, value: object
) -> None:
    """No value of any key ends in another error."""
    parts = {"top": {}, "group": {}, "row": {}, place: {key: value}}
    with suppress(SuiteError):
        assert written(tmp_path_factory.mktemp("suite"), **parts).cells


@pytest.mark.parametrize(
    ("rule", "row", "message"),
    [
        ("mitigation or avoidance", {"SPEED": [45]}, "`SPEED` is 45; the rule"),
        ("mitigation or avoidance", {"SPEED": [10, 5]}, "`SPEED` is 5; the rule"),
        ("mitigation or avoidance", {"search": {"SPEED": [10, 20]}}, "without a number for `SPEED`"),
        ("mitigation or avoidance", {"SPEED": ["fast"]}, "without a number for `SPEED`"),
        ("mitigation", {"hold": {"SPEED": "fast"}, "SPEED": ["fast"]}, "without a number for `SPEED`"),
    ],
)
def test_a_rule_with_bands_needs_a_speed_with_bands(
    tmp_path: Path, rule: str, row: dict[str, object], message: str
) -> None:
    """Without bands each contact would be red."""
    with pytest.raises(SuiteError) as found:
        written(tmp_path, {}, {"rule": rule}, row)
    assert message in found.value.message
    assert written(tmp_path, {}, {"rule": rule}, {"SPEED": [10, 40, 50, 65.5]}).cells


def test_the_entry_conditions_of_euro_ncap_are_standard_cells() -> None:
    """CCRs up to 20 km/h at all standard locations, and CPNA at 75 % from 10 km/h."""
    suite = suite_of("euroncap-2026")
    found = {cell.id for cell in suite.cells if any(matches(cell, each) for each in suite.entry)}
    rear = {cell.id for cell in suite.cells if cell.group == "CCRs" and cell.range == "standard"}
    slow = {name for name in rear if int(name.split("/")[1]) <= 20}
    assert found == slow | {"CPNA day/10/75", "CPNA night/10/75"}

"""A journal whose manifest somebody has edited: every command that opens the run says what is wrong, and the cure."""

import contextlib
import io
import json
import shutil
import sqlite3
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cortex_dsl.cli import main
from engine.search.manifest import Manifest
from tests.journals import unchain
from tests.laws import examples

pytestmark = pytest.mark.usefixtures("small_design")
JOURNAL = "journal.sqlite"
COMMANDS: dict[str, tuple[object, ...]] = {
    "resume": (),
    "report": ("--cases", 1),
    "analyse": ("--budget", 0),
    "replay": ("--to", "case.html"),
    "export": ("--to", "csv", "--force"),
    "probability": ("--samples", 5),
}
FIELDS = tuple(field.name for field in fields(Manifest))
Change = Callable[[str], str | None]
"""From the JSON of a field to what stands there afterwards; None: the row is gone."""


@pytest.fixture(scope="module")
def small_run(left_turn: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run that is good enough for every command."""
    run = tmp_path_factory.mktemp("runs") / "run"
    words = ["--ga", "--generations", "2", "--population", "6", "--jobs", "1", "--out", str(run)]
    with contextlib.redirect_stdout(io.StringIO()):
        assert main([str(left_turn), *words]) == 0
    return run


@contextlib.contextmanager
def doctored(run: Path, field: str, change: Change, sealed: bool = False) -> Iterator[Path]:
    """A copy of a run, one row of whose manifest says something else; the journal is one from before there were chains,
    unless it is to be `sealed`.
    """
    with tempfile.TemporaryDirectory(dir=run.parent) as folder:
        shutil.copy(run / JOURNAL, folder)
        if not sealed:
            unchain(Path(folder) / JOURNAL)
        with contextlib.closing(sqlite3.connect(Path(folder) / JOURNAL)) as connection, connection:
            query = "SELECT value FROM manifest WHERE field = ?"
            row = connection.execute(query, (field,)).fetchone() or ("null",)  # `number` stands in some runs alone
            value = change(row[0])
            connection.execute("DELETE FROM manifest WHERE field = ?", (field,))
            if value is not None:
                connection.execute("INSERT INTO manifest VALUES (?, ?)", (field, value))
        yield Path(folder)


def said(command: str, run: Path) -> tuple[int, str]:
    """Exit code and stderr of a command on a run; what it writes lies in the run's folder."""
    out, err = io.StringIO(), io.StringIO()
    options = [str(run / "case.html") if each == "case.html" else str(each) for each in COMMANDS[command]]
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main([command, str(run), *options])
    return code, err.getvalue()


def edited(*path: str | int, value: Any) -> Change:
    """The same JSON, but for one place in it."""

    def change(text: str) -> str:
        document: Any = {"": json.loads(text)}
        inner = document
        for step in ("", *path)[:-1]:
            inner = inner[step]
        inner[("", *path)[-1]] = value
        return json.dumps(document[""])

    return change


@pytest.mark.parametrize(
    ("field", "change", "message"),
    [
        ("settings", lambda _: None, "its manifest has no `settings`"),
        ("settings", lambda _: "{", "`settings` of its manifest must be JSON"),
        ("origin", lambda _: "[" * 100_000, "`origin` of its manifest must be JSON"),
        ("file", edited(value=5), "`file` of its manifest must be a text"),
        ("versions", edited(value=[]), "`versions` of its manifest must be a table"),
        ("command_line", edited(value="cortexc"), "`command_line` of its manifest must be a list"),
        ("parameters", edited(0, "low", value=None), "`parameters[0].low` of its manifest must be a number"),
        ("parameters", edited(0, "kind", value=99), "`parameters` of its manifest are not those of its scenario"),
        ("profile", edited(value="none"), "`profile` of its manifest must be one of paper, paper-mm, literature"),
        ("objective", edited(value=[]), "`objective` of its manifest must name objectives"),
        ("objective", lambda _: '["avoidable", "avoidable"]', "`objective` of its manifest must name objectives"),
        ("objective", lambda _: '["avoidable"]', "does not fit together"),
        ("seed", edited(value=5), "`seed` and `run` of its manifest must be those of `settings.search`"),
        ("seed", edited(value=2**70), "`seed` of its manifest must be a whole number"),
        ("settings", edited("search", value={}), "its manifest has no `settings.search.generations`"),
        ("settings", edited("search", "colour", value=1), "has `settings.search.colour`, which there is not"),
        ("settings", edited("search", "population", value=10**9), "`settings.search.population` of its manifest must"),
        ("settings", edited("search", "jobs", value=True), "`settings.search.jobs` of its manifest must be a whole"),
        (
            "settings",
            edited("simulation", "time_step", value="soon"),
            "`settings.simulation.time_step` of its",
        ),
        ("settings", edited("simulation", "time_step", value=1e-5), "`settings.simulation` of its manifest has more"),
        ("settings", edited("contact", "substep", value=1e-300), "`settings.contact.substep` of its manifest must be"),
    ],
)
def test_every_command_says_what_is_wrong(small_run: Path, field: str, change: Change, message: str) -> None:
    """Wrong JSON, wrong types, missing fields, huge numbers: exit code 2, the place, and a cure."""
    with doctored(small_run, field, change) as run:
        for command in COMMANDS:
            code, err = said(command, run)
            assert code == 2, err
            assert "is damaged" in err
            assert message in err
            assert "help: restore it from a copy, or repeat the run" in err


@pytest.mark.parametrize(
    ("field", "change"),
    [
        ("objective", lambda _: '["avoidable"]'),
        ("objective", lambda _: '["risk"]'),
        ("file", edited(value="other.scn")),
        ("settings", edited("simulation", "max_attempts", value=1999)),
        ("settings", edited("search", "probes", value=7)),
        ("command_line", edited(value=[])),
        ("versions", edited("numpy", value="1.0.0")),
        ("platform", lambda _: None),
    ],
)
def test_the_seal_tells_what_looks_right(small_run: Path, field: str, change: Change) -> None:
    """A manifest that a search might have written, and did not: every command refuses it."""
    with doctored(small_run, field, change, sealed=True) as run:
        for command in COMMANDS:
            code, err = said(command, run)
            assert code == 2, err
            assert "is damaged" in err
            assert "help: restore it from a copy, or repeat the run" in err


def test_settings_that_lead_elsewhere(small_run: Path) -> None:
    """A case whose scene cannot be drawn any more is no bug of ours."""
    with doctored(small_run, "settings", edited("simulation", "max_attempts", value=1)) as run:
        for command in ("report", "replay", "export"):
            code, err = said(command, run)
            assert code == 2, err
            assert "by its settings there is no scene of case" in err


VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.sampled_from([-1, 0, 1, 2, 3, 2**31, 2**63, 10**30, 0.5, -0.0, 1e-300, 1e300, float("nan"), float("inf")])
    | st.text(st.characters(exclude_categories=["Cs"]), max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text("ab", max_size=2), inner, max_size=3),
    max_leaves=5,
)


@st.composite
def changes(draw: st.DrawFn) -> tuple[str, Change]:
    """A field, and what is done to it: text that may be no JSON, nothing at all, or another value somewhere inside."""
    field = draw(st.sampled_from(FIELDS))
    kind = draw(st.sampled_from(["inside", "inside", "inside", "text", "gone"]))
    if kind == "gone":
        return field, lambda _: None
    if kind == "text":
        text = draw(st.text(st.characters(exclude_categories=["Cs"]), max_size=10))
        return field, lambda _: text
    steps = draw(st.lists(st.integers(0, 30), max_size=3))
    value, leave_out = draw(VALUES), draw(st.booleans())

    def change(before: str) -> str:
        document: Any = {"": json.loads(before)}
        inner: Any = document
        place: Any = ""
        for step in steps:
            there = inner[place]
            if not isinstance(there, dict | list) or not there:
                break
            keys: Any = list(there) if isinstance(there, dict) else range(len(there))
            inner, place = there, keys[step % len(there)]
        if leave_out and place != "":
            del inner[place]
        else:
            inner[place] = value
        return json.dumps(document.get("", value))

    return field, change


@given(changes(), st.sampled_from(list(COMMANDS)), st.booleans())
@settings(examples(60), suppress_health_check=[HealthCheck.too_slow])
def test_no_doctored_manifest_is_a_bug_of_ours(
    small_run: Path, what: tuple[str, Change], command: str, sealed: bool
) -> None:
    """Whatever stands there: it is refused with a cure, or does no harm."""
    with doctored(small_run, *what, sealed) as run:
        code, err = said(command, run)
    assert code in (0, 2) or (command, code) == ("probability", 3), err
    assert code != 2 or "\n  help: " in err

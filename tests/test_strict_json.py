"""Every file `.json` and `.jsonl`, and every document under `--json`, is strict JSON: no infinity and no NaN."""

import ast
import json
import shutil
from contextlib import redirect_stdout
from dataclasses import dataclass
from enum import Enum
from io import StringIO
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl.cli import main
from engine.strict_json import json_lines, json_text, plain
from engine.vocabulary import OBJECTIVES
from tests.laws import share
from tests.runs import LEFT_TURN

ROOT = Path(__file__).parents[1]
SMALL = ("--generations", "2", "--population", "20", "--seed", "5", "--jobs", "1")
OF_THEIR_OWN = {
    "engine/strict_json.py",
    "engine/program.py",  # the header of an archive and input of digests, which keep infinities
    "engine/study/run_records.py",  # the same of a block
    "engine/road/opendrive/contents.py",  # the same of an entry of the cache
    "engine/feasibility/explanation.py",  # an entry of the cache
    "engine/kernels/packaged.py",  # kernels import nothing of ours; texts alone
    "engine/interchange/esmini/__init__.py",  # a pipe to a script that is run without our packages
    "engine/interchange/esmini/child.py",
}
"""Sources that may call `json.dumps`: what they write is a part of a binary format that they alone read."""


def strict(text: str) -> Any:
    """Parse as RFC 8259 has it: Python alone also takes `NaN` and `Infinity`."""

    def refuse(word: str) -> None:
        raise ValueError(f"`{word}` is not JSON")

    return json.loads(text, parse_constant=refuse)


class Color(Enum):
    """An enumeration."""

    RED = 1


@dataclass(frozen=True)
class Pair:
    """A dataclass that may hold anything."""

    first: object
    second: object


LEAVES = st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.just(Color.RED)
VALUES = st.recursive(
    LEAVES,
    lambda inner: (
        st.lists(inner) | st.dictionaries(st.text(), inner) | st.tuples(inner, inner) | st.builds(Pair, inner, inner)
    ),
)


@given(VALUES)
def test_any_value_is_written_strictly_and_read_back(value: object) -> None:
    """A finite number comes back to the bit; whatever no JSON can hold is null."""
    assert strict(json_text(value)) == plain(value) == strict(json_text(value, indent=2, ascii_only=True))


@given(st.lists(st.tuples(st.floats(), st.text(), st.none() | st.integers())))
def test_a_table_is_one_object_a_line(rows: list[tuple[float, str, int | None]]) -> None:
    """Each of them strict, with the names of the columns in their order, whatever marks these hold."""
    names = ('a "quoted" %s name', "b", "c")
    columns = {name: [row[place] for row in rows] for place, name in enumerate(names)}
    lines = list(json_lines(columns))
    assert [strict(line) for line in lines] == [dict(zip(names, plain(row), strict=True)) for row in rows]
    assert not any("\n" in line for line in lines)


def test_no_source_writes_json_past_the_strict_writer() -> None:
    """Calls of `json.dump` and `json.dumps` are where a binary format is made, and nowhere else."""
    found = set[str]()
    for folder in ("cortex_dsl", "engine"):
        for path in (ROOT / folder).rglob("*.py"):
            names = (node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Attribute))
            if any(node.attr in ("dump", "dumps") and ast.unparse(node.value) == "json" for node in names):
                found.add(str(path.relative_to(ROOT)))
    assert found == OF_THEIR_OWN


def documents(folder: Path, run: Path) -> None:
    """Parse what every command says of a run under `--json`, and each file of JSON that they leave."""
    lines = (
        ("analyse", run, "--json"),
        ("verify", run, "--sample", 5, "--json"),
        ("verify", run, "--model", "dynamic", "--worst", 2, "--json"),
        ("resume", run, "--json"),
        ("export", run, "--out", folder / "exports", "--to", "xosc,scn,csv", "--json"),
        (run / "worst" / "01.scn", "--json"),
    )
    for line in lines:
        assert strict(said(*line))
    files = [path for path in folder.rglob("*") if path.suffix in (".json", ".jsonl")]
    assert {"summary.json", "evaluations.jsonl", "verification.json"} <= {path.name for path in files}
    for path in files:
        text = path.read_text(encoding="utf-8")
        for part in text.splitlines() if path.suffix == ".jsonl" else [text]:
            try:
                strict(part)
            except ValueError as error:
                pytest.fail(f"{path.name}: {error}")


def said(*words: object) -> str:
    """Return what a command that succeeds writes to standard output."""
    out = StringIO()
    with redirect_stdout(out):
        assert main([*map(str, words)]) == 0
    return out.getvalue()


@pytest.mark.parametrize("objective", [each for each in OBJECTIVES if each != "controller"][: max(2, share(6))])
def test_every_document_of_a_search_is_strict(objective: str, tmp_path: Path) -> None:
    """Under each objective: its summary, its tables, and what every command says of it."""
    run = tmp_path / "run"
    assert strict(said(LEFT_TURN, "--ga", *SMALL, "--objective", objective, "--out", run, "--json"))
    documents(tmp_path, run)


@pytest.mark.parametrize(
    "line",
    [
        ("--check",),
        (),
        ("--engine", "world"),
        ("--sample", "50"),
        ("--random", *SMALL),
        ("probability", "--samples", "200", "--seed", "1"),
        ("export", "--to", "xosc,scn,csv"),
    ],
    ids=lambda line: " ".join(line[:2]) or "run",
)
def test_every_document_of_a_file_is_strict(
    line: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What each command says of a scenario."""
    monkeypatch.chdir(tmp_path)
    file = shutil.copy(LEFT_TURN, tmp_path)
    command = line[:1] if line and not line[0].startswith("-") else ()
    assert strict(said(*command, file, *line[len(command) :], "--json"))


@pytest.mark.parametrize("line", [("examples",), ("explain", "SCN203"), ("paper-check",), ("export", "--to", "list")])
def test_every_document_without_a_file_is_strict(line: tuple[str, ...]) -> None:
    """Nor is there any number that is none in what needs no scenario."""
    assert strict(said(*line, "--json"))

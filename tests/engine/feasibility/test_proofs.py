"""Proofs that are kept: the same as fresh ones, of the same program only, and never in the way."""

import ast
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from cortex_dsl import compile_text
from engine.feasibility import Feasibility, explain, remembered
from engine.feasibility.explanation import CODE
from engine.program import Program
from engine.user_cache import ENVIRONMENT_VARIABLE

ROOT = Path(__file__).parents[3]
DATA = {"atomic", "frozen", "program", "scenes", "tables", "user_cache", "vocabulary"}
"""Modules of `engine` that define the parts of a program, whose digest is in the key, or that store the proof."""
HEAD = "map intersection(ways=4, lanes=1, approach=50 m)\n"
CUT = HEAD + "param X = Range(0, 10)\nego = new Car on road\nrequire X < 4\n"
IMPOSSIBLE = HEAD + "param X = Range(0, 10)\nego = new Car on road\nrequire X > 6\nrequire X < 5\n"


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(ENVIRONMENT_VARIABLE, str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def no_proofs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever proves anything now fails."""

    def refuse(_program: Program) -> Feasibility:
        raise AssertionError

    monkeypatch.setattr("engine.feasibility.explanation.explain", refuse)


def same(one: Feasibility, other: Feasibility) -> bool:
    pairs = zip(asdict(one).values(), asdict(other).values(), strict=True)
    return all(np.array_equal(a, b) if isinstance(a, np.ndarray) else a == b for a, b in pairs)


@pytest.mark.parametrize("text", [CUT, IMPOSSIBLE], ids=["cut", "impossible"])
def test_what_is_kept_is_what_was_proved(cache: Path, text: str) -> None:
    """Every field, number for number, the second time from the file."""
    program = compile_text(text).program
    first = remembered(program)
    assert first.infeasible == (text == IMPOSSIBLE)
    assert len(list(cache.glob("proof-*.json"))) == 1
    assert same(first, explain(program))
    assert same(remembered(program), first)


def test_the_second_time_nothing_is_proved(cache: Path, request: pytest.FixtureRequest) -> None:
    """Comments do not matter; another program does."""
    first = remembered(compile_text(CUT).program)
    request.getfixturevalue("no_proofs")
    assert same(remembered(compile_text(f"# a comment\n{CUT}").program), first)
    with pytest.raises(AssertionError):
        remembered(compile_text(CUT.replace("X < 4", "X < 5")).program)


@pytest.mark.parametrize("content", ["", "{}", "[1]", '{"looked_at": 1, "infeasible": 0}', "\udcff"])
def test_what_cannot_be_read_is_proved_again(cache: Path, content: str) -> None:
    """And put right."""
    program = compile_text(CUT).program
    first = remembered(program)
    (entry,) = cache.glob("proof-*.json")
    entry.write_bytes(content.encode("utf-8", "surrogateescape"))
    assert same(remembered(program), first)
    assert entry.read_text(encoding="utf-8").startswith('{"looked_at"')


def test_without_a_cache_it_is_proved_each_time(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing can be kept in the place of a file."""
    cache.write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache / "below"))
    monkeypatch.setenv("HOME", str(cache / "home"))
    program = compile_text(CUT).program
    assert same(remembered(program), explain(program))


def imported(file: Path) -> Iterator[Path]:
    """Yield the files of `engine` from which a module imports."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module is not None and node.module.startswith("engine"):
            package = ROOT.joinpath(*node.module.split("."))
            modules = (package / f"{each.name}.py" for each in node.names)
            yield from [each for each in modules if each.exists()] or [package.with_suffix(".py")]


def test_the_key_contains_all_code_that_determines_a_proof() -> None:
    """Otherwise a proof of an earlier version would answer for this one."""
    files = [file for folder in CODE[:2] for file in folder.glob("*.py")]
    assert {folder.name for folder in CODE[:2]} == {"feasibility", "operators"}
    needed = {each for file in files for each in imported(file) if each.exists() and each.stem not in DATA}
    assert {each.relative_to(ROOT).as_posix() for each in needed if not {each, each.parent} & {*CODE}} == set()

"""What docstrings show runs: each `>>>` line, in a folder with the examples and a run, and with a scenario at hand.

Where a docstring shows what is printed, that is compared; where it shows none, anything may be.
"""

import doctest
import shutil
from contextlib import redirect_stdout
from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import Any

import pytest

from cortex_dsl.api.scenario import load
from cortex_dsl.cli import main
from engine.search.store import new_directory

ROOT = Path(__file__).parents[1]
EXAMPLE = "examples/left_turn.scn"
RUN = "runs/left_turn-ga-001"
"""Where docstrings find a run."""
SHOWN = sorted(
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
    for package in ("cortex_dsl", "engine")
    for path in (ROOT / package).rglob("*.py")
    if ">>> " in path.read_text(encoding="utf-8")
)


class WhereShown(doctest.OutputChecker):
    """Compares an output with what is shown for it, if anything is."""

    def check_output(self, want: str, got: str, optionflags: int) -> bool:
        return not want or super().check_output(want, got, optionflags)


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a small search."""
    folder = tmp_path_factory.mktemp("found") / "run"
    words = ["--ga", "--generations", "2", "--population", "10", "--out", str(folder), "--json"]
    with redirect_stdout(StringIO()):
        assert main([str(ROOT / EXAMPLE), *words]) == 0
    return folder


@pytest.fixture
def space(found: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """A folder to stand in, and the names that docstrings take as known."""
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    shutil.copytree(found, tmp_path / RUN)
    monkeypatch.chdir(tmp_path)
    scenario = load(EXAMPLE)
    worst = scenario.search("ga", generations=2, population=10).worst[0]
    return {
        "scenario": scenario,
        "genome": worst.genome,
        "key": worst.key,
        "Path": Path,
        "new_directory": new_directory,
    }


@pytest.mark.parametrize("name", SHOWN)
def test_what_a_docstring_shows_runs(name: str, space: dict[str, Any]) -> None:
    """Without an exception, and with the output that is shown."""
    module = import_module(name)
    runner = doctest.DocTestRunner(checker=WhereShown(), optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    found = doctest.DocTestFinder(exclude_empty=True).find(module, name, extraglobs=space)
    said: list[str] = []
    for test in found:
        runner.run(test, out=said.append)
    if said:
        pytest.fail("".join(said), pytrace=False)


def test_docstrings_show_something() -> None:
    """There is something to run."""
    assert SHOWN

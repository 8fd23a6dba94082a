"""The short pages can be followed: their commands run in a shell as written; the landing page's scenario compiles."""

import os
import re
import shlex
import shutil
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from cortex_dsl.cli import main
from cortex_dsl.pipeline import compile_source
from cortex_dsl.source import Source
from engine.kernels.egocentric import AHEAD, EACH, NEAREST, OWN, WIDTH

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
OF_A_SHELL = re.compile(r"[$>|;&*]")


def blocks(page: Path, kind: str) -> list[str]:
    """Text of each block of a kind."""
    return re.findall(rf"^```{kind}\n(.*?)^```$", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


def test_the_landing_page_shows_the_scenario_of_the_readme() -> None:
    """The same one, which compiles without a word."""
    (scenario,) = blocks(DOCS / "index.md", "scn whole")
    assert not compile_source(Source("index.md", scenario)).diagnostics
    assert scenario in blocks(ROOT / "README.md", "")


BUDGET = ["--generations", "4", "--population", "20"]
"""Of a search whose page leaves it at the default."""


@pytest.fixture(scope="module")
def shell(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """An environment in which `cortexc` is this checkout's."""
    command = tmp_path_factory.mktemp("bin") / "cortexc"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m cortex_dsl "$@"\n', encoding="utf-8")
    command.chmod(0o755)
    path = os.pathsep.join([str(command.parent), str(Path(sys.executable).parent), os.environ["PATH"]])
    return os.environ | {"PATH": path, "PYTHONPATH": str(ROOT), "NO_COLOR": "1"}


def fewer(word: str) -> str:
    """Return 1,000 for a larger count of draws or simulations, which every command takes."""
    return str(min(int(word), 1000)) if word.isdecimal() else word


Follow = Callable[[list[str], Path], None]


@pytest.fixture
def follow(
    shell: dict[str, str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], small_design: None
) -> Iterator[Follow]:
    """Run lines as in a shell that stands in a folder; every command ends well. A plain `cortexc` runs in this process,
    a study too, by one worker.
    """

    def run(lines: list[str], home: Path) -> None:
        monkeypatch.chdir(home)
        monkeypatch.syspath_prepend(home)
        monkeypatch.setenv("PATH", shell["PATH"])
        for line in lines:
            if OF_A_SHELL.search(line) or not line.startswith("cortexc "):
                in_shell(line, home, shell)
            else:
                words = [fewer(word) for word in shlex.split(line)[1:]]
                searches = words[0] not in ("probability", "coverage") and {"--ga", "--method"} & {*words}
                if searches and "--generations" not in words:
                    words += BUDGET
                words += ["--jobs", "1"] if words[0] == "study" else []
                code = main(words)
                assert code == 0, f"{line}\n{capfd.readouterr()}"

    monkeypatch.delitem(sys.modules, "planner", raising=False)
    yield run
    sys.modules.pop("planner", None)


def in_shell(text: str, home: Path, shell: dict[str, str]) -> None:
    done = subprocess.run(["sh", "-ec", text], cwd=home, env=shell, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{text}\n{done.stdout}\n{done.stderr}"


def lines_of(page: Path) -> list[str]:
    return [line for block in blocks(page, "sh") for line in block.splitlines()]


def test_a_driver_of_ones_own(tmp_path: Path, shell: dict[str, str], follow: Follow) -> None:
    """The page from top to bottom in one folder: its commands as in a shell, its Python as one script."""
    shutil.copytree(ROOT / "examples", tmp_path / "home" / "examples")
    page = DOCS / "how-to" / "test-your-own-driver.md"
    assert len(lines_of(page)) > 5
    follow(lines_of(page), tmp_path / "home")
    with warnings.catch_warnings(action="ignore", category=ResourceWarning):  # of files that a script leaves open
        exec(compile("".join(blocks(page, "python")), str(page), "exec"), {"__name__": "__main__"})


def test_the_page_names_the_columns_that_are_observed() -> None:
    """Each of its own by its number, and where the groups begin and end."""
    page = (DOCS / "how-to" / "test-your-own-driver.md").read_text(encoding="utf-8")
    for number, (name, _) in enumerate(OWN):
        assert f"{number} `{name}`" in page
    first, others = len(OWN), len(OWN) + 2 * len(AHEAD)
    assert f"| {first} to {others - 1} `path N m ahead: x`, `y` | six points of the path, 5 to 40 m" in page
    assert (len(AHEAD), min(AHEAD), max(AHEAD)) == (6, 5.0, 40.0)
    assert f"| {others} to {others + len(EACH) - 1} `nearest 1: …` |" in page
    assert f"| {others + len(EACH)} to {WIDTH - 1} `nearest 2` to `{NEAREST}` |" in page
    assert all(f"`{name}`" in page for name, _ in EACH)


@pytest.mark.parametrize(
    "name", ["search.md", "continuous-integration.md", "rating-and-regulation-tests.md", "audit.md"]
)
def test_a_page_can_be_followed(name: str, tmp_path: Path, follow: Follow) -> None:
    """From top to bottom in a folder with the examples and the scenario that it has; all others compile in other tests.

    A workflow of the page runs at the end, without the steps of other tools.
    """
    page, examples = DOCS / "how-to" / name, tmp_path / "home" / "examples"
    examples.mkdir(parents=True)
    for path in (ROOT / "examples").glob("*.scn"):
        if path.name in page.read_text(encoding="utf-8"):
            shutil.copy(path, examples)
    if scenario := re.search(r"Take\s`(\S+)`", page.read_text(encoding="utf-8")):
        (tmp_path / "home" / scenario[1]).parent.mkdir()
        (tmp_path / "home" / scenario[1]).write_text(*blocks(page, "scn whole"), encoding="utf-8")
    lines = lines_of(page)
    steps = [line for workflow in blocks(page, "yaml") for line in re.findall(r"- run: (cortexc .*)", workflow)]
    assert len(lines) >= 3
    assert len(steps) == (2 if scenario else 0)
    follow([*lines, *steps], tmp_path / "home")


def test_the_readme_can_be_followed(tmp_path: Path, follow: Follow) -> None:
    """Its commands, from top to bottom, in an empty folder but for the examples."""
    home = tmp_path / "home"
    home.mkdir()
    (home / "examples").symlink_to(ROOT / "examples")
    lines = lines_of(ROOT / "README.md")
    assert any("--ego" in line for line in lines)
    follow(lines, home)
    assert (home / "runs" / "mine" / "report.html").exists()

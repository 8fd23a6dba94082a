"""The short pages can be followed: their commands run in a shell as written; the landing page's scenario compiles."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from cortex_dsl.pipeline import compile_source
from cortex_dsl.source import Source
from tests.fork_server import ForkServer

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


STARTED = """
import contextlib, io, sys
from cortex_dsl.cli import main

with contextlib.redirect_stdout(io.StringIO()):
    main({search})
"""
"""What a command needs has been read when it starts."""


@pytest.fixture(scope="module")
def started(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ForkServer]:
    folder = tmp_path_factory.mktemp("started")
    search = [str(ROOT / "examples" / "left_turn.scn"), "--ga", "--generations", "1", "--out", str(folder / "run")]
    environment = os.environ | {"PYTHONPATH": str(ROOT), "NO_COLOR": "1"}
    with ForkServer(STARTED.format(search=search), folder, environment=environment) as server:
        yield server


@pytest.fixture
def shell(tmp_path: Path) -> dict[str, str]:
    """An environment in which `cortexc` is this checkout's."""
    command = tmp_path / "bin" / "cortexc"
    command.parent.mkdir()
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m cortex_dsl "$@"\n', encoding="utf-8")
    command.chmod(0o755)
    path = f"{command.parent}{os.pathsep}{os.environ['PATH']}"
    return os.environ | {"PATH": path, "PYTHONPATH": str(ROOT), "NO_COLOR": "1"}


def test_a_driver_of_ones_own(tmp_path: Path, shell: dict[str, str]) -> None:
    """The page from top to bottom in one folder: its commands in a shell, its Python as one script."""
    shutil.copytree(ROOT / "examples", tmp_path / "home" / "examples")
    page = DOCS / "how-to" / "test-your-own-driver.md"
    shell = shell | {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{shell['PATH']}"}
    steps = [*blocks(page, "sh"), f"{sys.executable} - <<'PYTHON'\n{''.join(blocks(page, 'python'))}\nPYTHON"]
    assert len(steps) > 5
    for step in steps:
        done = subprocess.run(
            ["sh", "-ec", step], cwd=tmp_path / "home", env=shell, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, f"{step}\n{done.stdout}\n{done.stderr}"


@pytest.mark.parametrize("name", ["search.md", "continuous-integration.md"])
def test_a_page_can_be_followed(name: str, tmp_path: Path, shell: dict[str, str], started: ForkServer) -> None:
    """From top to bottom in a folder with the examples; every command ends well. A plain one needs no shell."""
    home = tmp_path / "home"
    shutil.copytree(ROOT / "examples", home / "examples")
    steps = blocks(DOCS / "how-to" / name, "sh")
    assert len(steps) >= 3
    for step in steps:
        if OF_A_SHELL.search(step):
            done = subprocess.run(["sh", "-ec", step], cwd=home, env=shell, capture_output=True, text=True, check=False)
            assert done.returncode == 0, f"{step}\n{done.stdout}\n{done.stderr}"
            continue
        for line in step.splitlines():
            command, *words = shlex.split(line)
            ended = started.run("sys.exit(main(sys.argv[1:]))", *words, at=home)
            assert (command, ended.status) == ("cortexc", 0), f"{line}\n{ended.out}\n{ended.err}"

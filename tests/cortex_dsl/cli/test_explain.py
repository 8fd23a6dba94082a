"""`cortexc explain`: the page of a code, the list of all, and what the unknown is answered with."""

import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cortex_dsl import codes
from cortex_dsl.report.terminal.kernel_progress import COMPILED
from tests.cortex_dsl.once import judging_once
from tests.golden import matches

Command = Callable[..., Any]
RUN = [
    entry for entry in codes.entries() if entry.page.wrong and entry.page.shown not in ("", "while the file is read")
]
"""Codes that no compilation raises, but a check or a run of `wrong.scn`."""


def test_a_page(cortexc: Command) -> None:
    """Why, the example, what the compiler says about it, and the example corrected, in this order."""
    result = cortexc("explain", "scn203")
    assert result.code == 0
    parts = ["SCN203 (error): unknown attribute", "ego.sped < 3 m/s", "error[SCN203]", "did you mean `speed`?"]
    places = [result.out.index(part) for part in parts]
    assert places == sorted(places)
    assert "    require ego.speed < 3 m/s" in result.out.split("Corrected")[1]


@pytest.mark.parametrize("entry", codes.entries(), ids=lambda entry: entry.code)
def test_every_page_can_be_shown(entry: codes.Entry, cortexc: Command) -> None:
    """Within the width, with the diagnostic wherever compiling shows it, and without a character that acts."""
    with judging_once():
        result = cortexc("explain", entry.code)
    assert result.code == 0
    assert entry.title in result.out
    assert f"[{entry.code}]" in result.out or entry.page.shown
    assert all(character == "\n" or character.isprintable() for character in result.out)


def test_the_list(cortexc: Command) -> None:
    """All codes, by family."""
    out = cortexc("explain").out
    assert all(f"{entry.code}  {entry.title}" in out for entry in codes.entries())
    assert "SCN3xx  units and types" in out


def test_documents(cortexc: Command) -> None:
    """The same as data."""
    page = cortexc("explain", "302", "--json").document
    assert (page["schema"], page["code"], page["severity"]) == ("cortexc/code", "SCN302", "error")
    assert page["says"][0]["code"] == "SCN302"
    listed = cortexc("explain", "--json").document["codes"]
    assert [each["code"] for each in listed] == [entry.code for entry in codes.entries()]


def test_an_unknown_code(cortexc: Command) -> None:
    """A slip of the user, with the nearest codes."""
    result = cortexc("explain", "SCN299")
    assert result.code == 2
    assert "there is no code `SCN299`" in result.said
    assert "SCN301" in result.said


def test_help_names_the_command(cortexc: Command) -> None:
    """In the help of `cortexc` and in its own."""
    assert "cortexc explain [CODE]" in cortexc("--help").out
    assert "such as SCN203" in cortexc("explain", "--help").out


@pytest.mark.parametrize("entry", RUN, ids=lambda entry: entry.code)
def test_what_only_a_command_shows(
    entry: codes.Entry, cortexc: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The examples of these pages are run or checked: one is reported as its folder says, the other ends well."""
    home = Path(codes.__file__).parent / entry.code
    for name in ("wrong.scn", "right.scn"):
        shutil.copy(home / name, tmp_path / name)
    monkeypatch.chdir(tmp_path)
    options = ["--check"] if "`--check`" in entry.page.shown else []
    said = cortexc("wrong.scn", *options)
    matches(COMPILED.sub("", said.err), home / "said.txt")
    assert re.findall(r"error\[(\w+)\]", said.err) == [entry.code]
    right = cortexc("right.scn", *options)
    assert (right.code, f"[{entry.code}]" in right.err) == (0, False)


def test_nothing_slow_is_loaded() -> None:
    """A page answers at once."""
    program = "import sys; from cortex_dsl.cli import main; main(['explain', '203']); "
    program += "sys.exit(str({'numba', 'scipy', 'pymunk'} & set(sys.modules) or 0))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=300, check=False)
    assert done.stderr.strip() in ("", "0"), done.stderr

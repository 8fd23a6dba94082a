"""A command that is interrupted at any instant says so, and what the next command leaves is what an undisturbed one
leaves, in every file.
"""

import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from tests.folders import content
from tests.fork_server import ForkServer
from tests.laws import share

SMALL = """
import signal
signal.signal(signal.SIGINT, signal.SIG_DFL)
from tests.runs import small_designs
with small_designs():
    signal.signal(signal.SIGINT, signal.default_int_handler)
    sys.exit(process())
"""
"""The command with small designs in its pages; until it listens, a signal ends the process at once."""
SEARCH = ("--ga", "--population", 30, "--seed", 2, "--jobs", 1)
STUDY = ("--runs", 2, "--generations", 3, "--population", 12)


@dataclass(frozen=True)
class Row:
    """A command that writes into a folder F, which may be a copy of one of the session, of a FILE."""

    words: tuple[object, ...]
    again: tuple[object, ...]
    """The command that continues or repeats it; (): it writes nothing."""
    begins_with: str = ""
    """The folder that is copied to F before the command: `long`, `short` or `study`."""
    spoilt: tuple[str, ...] = ()
    """Files of the copy that are removed, so that the command writes them."""
    content: Callable[[Path], Mapping[str, Any]] = content


def every_byte(folder: Path) -> Mapping[str, bytes]:
    """Return the contents of all files but locks and databases, whose pages are not a function of their rows."""
    paths = (path for path in folder.rglob("*") if path.is_file() and path.suffix not in (".lock", ".sqlite"))
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths if path.name != ".lock"}


def repeated(*words: object, begins_with: str = "", spoilt: tuple[str, ...] = ()) -> Row:
    """Return a command that is repeated after an interruption, and of whose files every byte counts."""
    return Row(words, words, begins_with, spoilt, every_byte)


def reading(*words: object, begins_with: str = "") -> Row:
    """Return a command that prints a document and changes no file."""
    return Row((*words, "--json"), (), begins_with, (), every_byte)


LONGER = ("resume", "F", "--generations", 4, "--jobs", 1)
RESUMED = ("resume", "F", "--jobs", 1)
COMMANDS: dict[str, Row] = {
    "check": reading("FILE", "--check"),
    "run": reading("FILE"),
    "sample": reading("FILE", "--sample", 300, "--jobs", 1),
    "analyse": reading("analyse", "F", "--budget", 300, "--jobs", 1, begins_with="long"),
    "verify": reading("verify", "F", "--sample", 20, "--jobs", 1, begins_with="long"),
    "probability of a file": reading("probability", "FILE", "--samples", 300, "--jobs", 1),
    "search": Row(("FILE", *SEARCH, "--generations", 4, "--out", "F"), RESUMED),
    "resume": Row(LONGER, LONGER, "short"),
    "report": repeated(
        *("report", "F", "--cases", 2),
        begins_with="long",
        spoilt=("summary.json", "worst/01.scn", "evaluations.csv"),
    ),
    "export": repeated("export", "long", "--to", "scn,xosc,csv,parquet", "--top", 2, "--out", "F"),
    "probability": repeated("probability", "F", "--samples", 300, "--jobs", 1, begins_with="long"),
    "import": repeated("import", "CASE", "--to", "xosc,csv,scn", "--out", "F"),
    "film": repeated("replay", "FILE", "--to", "F/case.html", begins_with="long"),
    "opinion": repeated("verify", "F", "--model", "dynamic", "--worst", 3, "--jobs", 1, begins_with="long"),
    "study": Row(("study", "FILE", *STUDY, "--jobs", 1, "--out", "F"), RESUMED),
    "study of processes": Row(("study", "FILE", *STUDY, "--jobs", 2, "--out", "F"), RESUMED),
    "report of a study": repeated("report", "F", begins_with="study", spoilt=("runs.csv", "summary.json")),
}
UNFINISHED = re.compile(r"\.cortexc-part$|\.new")
"""Names of files that a process has begun and not completed."""
MANY, FEW = 40, 8
"""Instants at which a search or a study, and any other command, is interrupted, as dear laws count their examples."""
SIGNALS = (signal.SIGINT, signal.SIGTERM)


@pytest.fixture(scope="module")
def made(command_server: ForkServer, left_turn: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a search, a shorter one and a study that nothing interrupts."""
    home = tmp_path_factory.mktemp("made")
    for name, words in {
        "long": (left_turn, *SEARCH, "--generations", 4),
        "short": (left_turn, *SEARCH, "--generations", 2),
        "study": ("study", left_turn, *STUDY, "--jobs", 1),
    }.items():
        assert command_server.run(SMALL, *words, "--out", home / name).status == 0
    case = ("export", home / "long", "--to", "xosc", "--out", home)
    assert command_server.run(SMALL, *case).status == 0
    next(home.glob("*.xosc")).rename(home / "case.xosc")
    return home


@pytest.mark.parametrize("name", COMMANDS)
def test_interrupted_at_any_instant(
    name: str, command_server: ForkServer, left_turn: Path, made: Path, tmp_path: Path
) -> None:
    """A signal is never lost: the exit code is that of the signal, or the work is finished. No half of a file is left
    that the next command does not replace.
    """
    row = COMMANDS[name]

    def prepared(run: Path, words: tuple[object, ...]) -> list[object]:
        names = {"F": run, "FILE": left_turn, "long": made / "long", "CASE": made / "case.xosc"}
        return [str(word).replace("F/", f"{run}/") if word not in names else names[str(word)] for word in words]

    def begin(run: Path) -> None:
        if row.begins_with:
            shutil.copytree(made / row.begins_with, run)
        for file in row.spoilt:
            (run / file).unlink()

    timed = tmp_path / "run"
    begin(timed)
    start = time.perf_counter()
    whole = command_server.run(SMALL, *prepared(timed, row.words))
    assert whole.status == 0, whole
    long, chance, expected = time.perf_counter() - start, random.Random(name), row.content(timed)
    shutil.rmtree(timed, ignore_errors=True)
    for count in range(share(MANY if name in ("search", "study") else FEW, dear=True)):
        run, number = tmp_path / "run", SIGNALS[count % 2]
        begin(run)
        process = command_server.start(SMALL, *prepared(run, row.words))
        wait = chance.uniform(0.0, 1.1 * long)
        time.sleep(wait)
        with suppress(ProcessLookupError):  # it has ended already
            os.kill(process.pid, number)
        sent = time.perf_counter()
        ended = process.end()
        at = f"{number.name} after {wait:.3f} of {long:.3f} s"
        assert time.perf_counter() - sent < 5.0 + long, (at, ended)
        assert ended.status in (0, 128 + number, -number), (at, ended)
        assert not any(word in ended.err for word in ("Traceback", "ignored")), (at, ended)
        assert not [path for path in run.rglob("*") if UNFINISHED.search(path.name)], (at, ended)
        assert "--json" not in row.words or not ended.out or json.loads(ended.out), (at, ended)
        begun = any((run / database).exists() for database in ("journal.sqlite", "study.sqlite"))
        if words := row.words if "resume" in row.again and not begun else row.again:
            again = command_server.run(SMALL, *prepared(run, words))
            assert again.status == 0, (at, ended, again)
        assert row.content(run) == expected, at
        shutil.rmtree(run, ignore_errors=True)


INTERRUPTING = """
import atexit, os, signal, sys
from cortex_dsl.__main__ import process
name, number = sys.argv[1], int(sys.argv[2])
del sys.argv[1:3]
pending = [number]
def hear(event, arguments):
    if event == "import" and arguments[0] == name and pending:
        os.kill(os.getpid(), pending.pop())
sys.addaudithook(hear)
if name == "atexit":
    atexit.register(lambda: os.kill(os.getpid(), number))
sys.exit(process())
"""
"""The command in a process that sends itself a signal at the import of one module, or while Python closes down."""
STARTING = ("cortex_dsl.cli", "cortex_dsl.installation", "cortex_dsl.cli.entry", "engine.errors", "cortex_dsl.lowering")


@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize("name", [*STARTING, "atexit"])
def test_interrupted_while_it_starts_and_ends(name: str, number: signal.Signals, left_turn: Path) -> None:
    """A signal during imports is reported in one line; after the work it ends the process without a word."""
    command = [sys.executable, "-c", INTERRUPTING, name, str(int(number)), str(left_turn), "--check"]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=120)
    if name == "atexit":
        assert (ended.returncode, ended.stderr) == (-number, "")
    else:
        assert (ended.returncode, ended.stdout, ended.stderr) == (128 + number, "", "cortexc: interrupted\n")

"""The command as a process: signals, pipes, and the folder it is started in."""

import os
import shlex
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import pytest

from tests.children import hear_interrupts
from tests.fork_server import RUN, ForkServer

ROOT = Path(__file__).parents[3]
CORTEXC = [sys.executable, "-m", "cortex_dsl"]


def start(*arguments: object, **options: object) -> "subprocess.Popen[str]":
    environment = {**os.environ, "PYTHONUNBUFFERED": "1", "PYTHONPATH": str(ROOT)}
    return subprocess.Popen(
        [*CORTEXC, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
        **{"preexec_fn": hear_interrupts if os.name == "posix" else None, **options},  # type: ignore[arg-type]
    )


def generations(journal: Path) -> int:
    """How many generations a journal holds so far."""
    if not journal.exists():
        return 0
    try:
        with closing(sqlite3.connect(f"file:{journal}?mode=ro", uri=True)) as connection:
            return connection.execute("SELECT count(*) FROM generation").fetchone()[0]
    except sqlite3.Error:
        return 0


def test_ctrl_c_keeps_what_there_is(command_server: ForkServer, left_turn: Path, tmp_path: Path) -> None:
    """SIGINT in the middle of a search: 130, a report of what was found, and a complete run directory."""
    run = tmp_path / "run"
    process = command_server.start(
        RUN, left_turn, "--ga", "--generations", 60000, "--population", 50, "--tables", "--out", run
    )
    deadline = time.monotonic() + 300
    while generations(run / "journal.sqlite") < 3:
        assert time.monotonic() < deadline
        time.sleep(0.05)
    os.kill(process.pid, signal.SIGINT)
    ended = process.end()
    assert ended.status == 130, ended.err
    assert "interrupted" in ended.out
    assert "Traceback" not in ended.err
    assert {path.name for path in run.iterdir()} >= {"journal.sqlite", "evaluations.csv", "summary.json"}


ASKED = """
import os, signal, sys
import numpy as np
from cortex_dsl.signals import install_handlers

class Asked(type):
    heard = False
    def __getattr__(cls, name):
        if not cls.heard:
            cls.heard = True
            os.kill(os.getpid(), int(sys.argv[1]))
        raise AttributeError(name)

class Operand(metaclass=Asked):
    pass

install_handlers([])
try:
    for _ in range(100_000):
        np.arange(3) == Operand()
except KeyboardInterrupt:
    sys.exit(0)
sys.exit(1)
"""
"""numpy looks at the type of an operand, which is interrupted in that moment."""


IMPORTED = """
import os, signal, sys
from importlib.machinery import ExtensionFileLoader
from cortex_dsl.signals import install_handlers

def interrupt(frame, event, _argument):
    if event != "call" or "importlib" in frame.f_code.co_filename:
        return
    while frame is not None:
        if frame.f_code in (ExtensionFileLoader.create_module.__code__, ExtensionFileLoader.exec_module.__code__):
            sys.setprofile(None)
            os.kill(os.getpid(), int(sys.argv[1]))
        frame = frame.f_back

install_handlers([])
sys.setprofile(interrupt)
try:
    import numpy
except KeyboardInterrupt:
    sys.exit(0)
sys.exit(1)
"""
"""An extension module of numpy imports a module in Python, which is interrupted."""


SIMULATED = """
import os, random, signal, sys, time
from threading import Timer
import cortex_dsl as cx
from cortex_dsl.signals import install_handlers

scenario = cx.load("examples/left_turn.scn")
scene = scenario.scene_of_seed(4)
scenario.watch(scene)
install_handlers([])
instants, heard = random.Random(1), 0
for _ in range(80):
    timer = Timer(instants.uniform(0.0, 0.04), os.kill, (os.getpid(), int(sys.argv[1])))
    try:
        timer.start()
        while True:
            scenario.watch(scene)
    except KeyboardInterrupt:
        heard += 1
    timer.join()
sys.exit(heard != 80)
"""
"""Records are passed to kernels, and pymunk calls back, at eighty instants of simulations in the world host."""


FREED = """
import os, signal, sys, time, weakref
from cortex_dsl.signals import install_handlers
import llvmlite.binding

class Freed:
    def __del__(self):
        pass

class Plain:
    pass

def imported():
    import colorsys

def freed():
    Freed()

def in_set():
    weakref.WeakSet([Plain()])

def in_dictionary():
    weakref.WeakValueDictionary(a=Plain())

def by_key():
    weakref.WeakKeyDictionary({Plain(): 1})

def finalized():
    weakref.finalize(Plain(), int)

def half_made():
    list(llvmlite.binding.parse_assembly("declare void @f()").functions)

def interrupt(frame, event, _argument):
    if event == "call" and frame.f_code.co_name == name:
        sys.setprofile(None)
        os.kill(os.getpid(), int(sys.argv[1]))

install_handlers([])
pairs = ((imported, "cb"), (freed, "__del__"), (in_set, "_remove"), (in_dictionary, "remove"), (by_key, "remove"),
         (finalized, "__call__"), (half_made, "__init__"))
heard = []
for act, name in pairs:
    sys.setprofile(interrupt)
    try:
        act()
        time.sleep(5.0)
    except KeyboardInterrupt:
        heard.append(act)
sys.exit(len(heard) != len(pairs))
"""
"""Objects go, and what Python calls for that is interrupted."""


STARTED = """
import multiprocessing, os, signal, sys, time
from cortex_dsl.signals import install_handlers

def interrupt(frame, event, _argument):
    caller = frame.f_back
    if event == "return" and frame.f_code.co_name == "spawnv_passfds" and caller.f_code.co_name == "_launch":
        sys.setprofile(None)
        os.kill(os.getpid(), int(sys.argv[1]))

install_handlers([])
process = multiprocessing.get_context("spawn").Process(target=time.sleep, args=(0.0,))
sys.setprofile(interrupt)
try:
    process.start()
    time.sleep(5.0)
except KeyboardInterrupt:
    sys.exit(0)
sys.exit(1)
"""
"""A process is started, and its parent is interrupted before it has written what the process reads first."""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(
    "program",
    [ASKED, IMPORTED, SIMULATED, FREED, STARTED],
    ids=["operand", "import", "simulation", "freed", "process"],
)
def test_a_signal_is_heard_also_where_exceptions_are_dropped(program: str, number: int) -> None:
    """Where the exception would be dropped or replaced, it is raised a moment later."""
    words = [sys.executable, "-c", program, str(int(number))]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, preexec_fn=hear_interrupts, timeout=300)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("options", [("--emit", "program"), ("--metrics",)], ids=["text", "view"])
def test_a_reader_that_leaves(left_turn: Path, options: tuple[str, ...]) -> None:
    """`cortexc ... | head`: no traceback, no complaint, for a text and for a view."""
    with start(left_turn, *options) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.readline()
        process.stdout.close()
        assert process.stderr.read() == ""
        assert process.wait(timeout=300) == 0


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_a_terminal_of_another_encoding(left_turn: Path, encoding: str) -> None:
    """What cannot be shown is written in other characters; nothing fails."""
    done = subprocess.run(
        [*CORTEXC, str(left_turn)],
        capture_output=True,
        env={**os.environ, "PYTHONIOENCODING": encoding},
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert b"risk" in done.stdout
    assert b"?" not in done.stdout


@pytest.mark.skipif(os.name != "posix", reason="needs modes of folders")
def test_a_folder_that_cannot_be_written(command_server: ForkServer, left_turn: Path, tmp_path: Path) -> None:
    """Without a place for results nothing is started."""
    tmp_path.chmod(0o500)
    ended = command_server.run(f"obey_modes(); {RUN}", left_turn, "--ga", at=tmp_path)
    assert ended.status == 2
    assert "cannot write" in ended.err


def test_standard_output_is_plain_in_a_pipe(command_server: ForkServer, left_turn: Path) -> None:
    """Nobody wants escape codes in a file, FORCE_COLOR or not, when --no-colour is given."""
    ended = command_server.run(RUN, left_turn, "--no-colour", FORCE_COLOR="1")
    assert ended.status == 0
    assert "\x1b" not in ended.out


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
@pytest.mark.parametrize("option", ["--check", "--json"])
def test_a_full_disk(command_server: ForkServer, left_turn: Path, tmp_path: Path, option: str) -> None:
    """Results that cannot be written end with 2 and a word, not as a bug of ours."""
    said = tmp_path / "said"
    said.touch()
    ended = command_server.run(RUN, left_turn, option, files=[os.devnull, "/dev/full", str(said)])
    assert ended.status == 2
    assert "the disk is full" in said.read_text(encoding="utf-8")
    assert "Traceback" not in said.read_text(encoding="utf-8")


@pytest.mark.skipif(os.name != "posix", reason="needs a shell")
def test_closed_streams(left_turn: Path) -> None:
    """`>&-` and `2>&-` change no exit code."""
    for arguments, code in ((f"{left_turn} --check", 0), ("--no-such-option", 2)):
        command = f"{shlex.join(CORTEXC)} {arguments} >&- 2>&-"
        assert subprocess.run(command, shell=True, check=False).returncode == code


@pytest.mark.skipif(os.name != "posix", reason="needs a group of processes")
@pytest.mark.parametrize("study", [False, True])
def test_ctrl_c_on_a_cluster_of_our_own(left_turn: Path, tmp_path: Path, study: bool) -> None:
    """A terminal sends it to every process: nobody but this one answers, and not with a traceback."""
    pytest.importorskip("distributed")
    small = ("--generations", 2, "--population", 20)
    what = ("study", left_turn, "--runs", 6000, *small) if study else (left_turn, "--ga", "--generations", 6000)
    process = start(*what, "--jobs", 2, "--dask", "local", "--out", tmp_path / "run", start_new_session=True)
    deadline = time.monotonic() + 300
    while not begun(tmp_path / "run"):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGINT)
    _, err = process.communicate(timeout=300)
    assert process.returncode == 130, err
    lines = [line for line in err.splitlines() if not line.startswith(("study ", "about "))]
    assert len(lines) == 1, err
    assert "continue with" in lines[0] or "to go on" in lines[0]


def begun(run: Path) -> bool:
    """Whether something of a search or of a study is finished."""
    if generations(run / "journal.sqlite"):
        return True
    try:
        with closing(sqlite3.connect(f"file:{run / 'study.sqlite'}?mode=ro", uri=True)) as connection:
            return connection.execute("SELECT count(*) FROM run").fetchone()[0] > 0
    except sqlite3.Error:
        return False

"""Compiled kernels are cached, and never outlive an edit. Each case runs in processes of its own."""

import contextlib
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import engine
from tests.fork_server import ForkServer

SOURCES = Path(engine.__file__).parent

INNER = """
from engine.kernels.jit import inlined, shared

@inlined
def added(x):
    return x + {number}

@shared
def inner(x: float) -> float:
    return added(x)
"""
OUTER = """
from engine.kernels.inner import inner
from engine.kernels.jit import kernel
from engine.vocabulary import Command

@kernel
def outer(x):
    return inner(x) * Command.SPEED.value
"""
MAKING = """
import numpy as np
from engine.kernels.jit import allocating, inlined, kernel

@allocating
def made(count):
    return np.full(count, 2.0).sum()

@inlined
def between(count):
    return made(count)

@kernel
def outer(x):
    return between(int(x)) * 100.0
"""
PRELUDE = """
import numba
numba.njit(lambda x: x + 1.0)(1.0)
"""
"""What every process needs, whatever it compiles."""
MAIN = """
import os, sys, warnings
sys.path.insert(0, os.getcwd())
warnings.simplefilter("error")
import numba
numba.__version__ = os.environ.get("PRETENDED_NUMBA", numba.__version__)
from engine.kernels.jit import cache_folder, packaged
from engine.kernels.outer import outer
cached = packaged() is not None or any(cache_folder().rglob("*.nbc"))
if "COMPILE_BEFORE" in os.environ:
    from engine.kernels.jit import kernel
    for _ in range(5):
        kernel(lambda x: x)(1.0)
value = outer(1.0)
made = getattr(outer, "finished", outer)
hits = sum(made.stats.cache_hits.values()) if hasattr(made, "stats") else -1
print(cached, value, hits, cache_folder())
"""


DAMAGES: tuple[Callable[[bytes], bytes], ...] = (
    lambda content: content[:40],
    lambda content: b"",
    lambda content: content[:-1] + bytes([content[-1] ^ 1]),
    lambda content: content[:2000] + b"?" + content[2001:],
)
"""Truncated, emptied, a bit turned over at the end, a byte in the middle."""


Printed = tuple[bool, float, int, Path]
UNKEPT = ("-B",)
"""No .pyc: Python takes a file that is edited within a second, to the same length, for the one that it compiled."""


class Installation:
    """A copy of the engine's cache machinery with two small kernels in two files."""

    def __init__(self, folder: Path, cache: Path, server: ForkServer) -> None:
        self.folder, self.server = folder, server
        self.environment = {"CORTEXC_CACHE": str(cache)}
        self.package = folder / "engine"
        (self.package / "kernels").mkdir(parents=True)
        (self.package / "operators").mkdir()
        names = (
            "__init__.py",
            "opcodes.py",
            "operators/__init__.py",
            "vocabulary.py",
            "outcomes.py",
            "tables.py",
            "user_cache.py",
            "kernels/__init__.py",
            "handles.py",
            "judged.py",
            "kernels/handle_types.py",
            "kernels/jit.py",
            "kernels/numba_internals.py",
            "kernels/packaged.py",
            "kernels/shared.py",
        )
        for name in names:
            shutil.copy(SOURCES / name, self.package / name)
        (self.package / "kernels" / "outer.py").write_text(OUTER)
        self.write_inner(1)

    def write_inner(self, number: int) -> None:
        (self.package / "kernels" / "inner.py").write_text(INNER.format(number=number))

    def start(self, **environment: str) -> subprocess.Popen[str]:
        """A process that is new from the ground up."""
        return subprocess.Popen(
            [sys.executable, *UNKEPT, "-c", MAIN],
            env={**without_numba(), **self.environment, **environment},
            cwd=self.folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def run(self, **environment: str) -> Printed:
        """A process that has numba already."""
        done = self.server.run(MAIN, at=self.folder, **self.environment, **environment)
        assert done.status == 0, done.err
        return printed(done.out)


def printed(output: str) -> Printed:
    """(cached before, value, cache hits, cache folder) as a process printed them."""
    cached, value, hits, folder = output.split(maxsplit=3)
    return cached == "True", float(value), int(hits), Path(folder.strip())


def result(process: subprocess.Popen[str]) -> Printed:
    output, errors = process.communicate()
    assert process.returncode == 0, errors
    return printed(output)


def without_numba() -> dict[str, str]:
    """The environment without settings of numba."""
    return {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ForkServer]:
    with ForkServer(PRELUDE, tmp_path_factory.mktemp("server"), *UNKEPT, environment=without_numba()) as server:
        yield server


@pytest.fixture
def installation(tmp_path: Path, server: ForkServer) -> Installation:
    return Installation(tmp_path, tmp_path / "cache", server)


def test_second_process_finds_what_the_first_compiled_until_a_callee_changes(installation: Installation) -> None:
    """The caller's file is untouched by the edit, which is the case that numba alone gets wrong."""
    assert installation.run()[:3] == (False, 6.0, 0)
    assert installation.run()[:3] == (True, 6.0, 1)
    installation.write_inner(2)
    assert installation.run()[:3] == (False, 9.0, 0)


def test_an_edit_of_words_compiles_nothing(installation: Installation) -> None:
    """Comments, docstrings, layout and lines are no part of a key; a number in the same line is."""
    ours = installation.run()[3]
    outer, inner = (installation.package / "kernels" / f"{name}.py" for name in ("outer", "inner"))
    inner.write_text("# first\n\n" + inner.read_text().replace("def inner(x):", 'def inner(x):\n    """Second."""'))
    outer.write_text('"""Third."""\n' + outer.read_text().replace("inner(x) *", "(inner(x)  # fourth\n    ) *"))
    assert installation.run() == (True, 6.0, 1, ours)
    inner.write_text(inner.read_text().replace("x + 1", "x + 2"))
    assert installation.run()[:3] == (False, 9.0, 0)


def test_changed_enum_value_is_compiled_anew(installation: Installation) -> None:
    """An enum value is a constant of the machine code, and vocabulary.py is not a kernel file."""
    assert installation.run()[1] == 6.0
    vocabulary = installation.package / "vocabulary.py"
    above, command, below = vocabulary.read_text().partition("class Command(")
    vocabulary.write_text(above + command + below.replace("    SPEED = 3\n", "    SPEED = 5\n", 1))
    assert installation.run()[:3] == (False, 10.0, 0)


def test_two_processes_compile_at_the_same_time(installation: Installation) -> None:
    """Neither fails, and what they leave behind is whole."""
    first, second = installation.start(), installation.start()
    assert result(first)[1] == result(second)[1] == 6.0
    assert installation.run()[1:3] == (6.0, 1)


def test_a_second_clone_compiles_nothing(installation: Installation, tmp_path: Path) -> None:
    """The place and the time of the files do not matter, their contents do."""
    installation.run()
    elsewhere = tmp_path / "another clone"
    elsewhere.mkdir()
    second = Installation(elsewhere, tmp_path / "cache", installation.server)
    assert second.run()[:3] == (True, 6.0, 1)
    second.write_inner(2)
    assert second.run()[:3] == (False, 9.0, 0)
    assert installation.run()[:3] == (True, 6.0, 1)


def test_other_versions_of_the_compiler_have_other_folders(installation: Installation) -> None:
    """And one that is not known compiles and caches by numba's own means."""
    ours = installation.run()[3]
    _, value, hits, folder = installation.run(PRETENDED_NUMBA="0.99.0")
    assert (value, hits) == (6.0, 0)
    assert folder != ours
    assert installation.run(PRETENDED_NUMBA="0.99.0")[1:] == (6.0, 1, folder)
    installation.write_inner(2)
    assert installation.run(PRETENDED_NUMBA="0.99.0")[1:3] == (9.0, 0)


@pytest.mark.parametrize("seconds", [0.3, 0.9, 1.5])
def test_a_killed_process_leaves_nothing_wrong(installation: Installation, seconds: float) -> None:
    """Whenever it is killed, the next one has the right result and leaves a whole cache."""
    process = installation.start()
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(seconds)
    process.kill()
    process.communicate()
    assert installation.run()[1] == 6.0
    assert installation.run()[1:3] == (6.0, 1)


def test_unwritable_folder_falls_back(installation: Installation) -> None:
    """A file stands where each cache folder should be: permissions would not stop root."""
    blocked = installation.folder / "blocked"
    blocked.write_text("")
    temporary = installation.folder / "temporary"
    temporary.mkdir()
    places = {name: str(blocked) for name in ("CORTEXC_CACHE", "XDG_CACHE_HOME", "HOME")}
    _, value, _, folder = result(installation.start(**places, TMPDIR=str(temporary)))
    assert value == 6.0
    assert folder.is_relative_to(temporary)


def test_broken_cache_files_are_a_miss(installation: Installation) -> None:
    """Damaged files cost a compilation and are then replaced."""
    folder = installation.run()[3]
    files = sorted(folder.glob("*/*.nbc"))
    assert files
    for damage in DAMAGES:
        for path in files:
            path.write_bytes(damage(path.read_bytes()))
        assert installation.run()[1:3] == (6.0, 0)
        assert installation.run()[1:3] == (6.0, 1)


def test_the_code_of_another_kernel_is_a_miss(installation: Installation) -> None:
    """A file says what it is for."""
    folder = installation.run()[3]
    (outer,) = folder.glob("outer/*.nbc")
    (inner,) = folder.glob("inner/*.nbc")
    shutil.copy(inner, outer)
    assert installation.run()[1:3] == (6.0, 0)
    assert installation.run()[1:3] == (6.0, 1)


def test_a_caller_works_with_shared_code_that_is_compiled_again(installation: Installation) -> None:
    """It calls that code through a cell, which has the same name in every process: only what is missing is compiled."""
    folder = installation.run()[3]
    (inner,) = folder.glob("inner/*.nbc")
    inner.unlink()
    assert installation.run(COMPILE_BEFORE="1")[1:3] == (6.0, 1)
    (again,) = folder.glob("inner/*.nbc")
    assert again == inner
    assert installation.run()[1:3] == (6.0, 1)


def test_folders_long_unused_are_removed(installation: Installation) -> None:
    """Only the most recent ones of other versions stay."""
    cache = installation.folder / "cache"
    for age in range(12):
        old = cache / f"numba-{age:016x}"
        old.mkdir(parents=True)
        os.utime(old, (1e9 - age, 1e9 - age))
    current = installation.run()[3]
    assert sorted(cache.iterdir()) == sorted([current, *(cache / f"numba-{age:016x}" for age in range(8))])


def test_what_makes_arrays_does_so_whoever_calls_it_first(installation: Installation) -> None:
    """Also where that is an inlined function, which counts no references."""
    (installation.package / "kernels" / "outer.py").write_text(MAKING)
    assert installation.run()[1] == 200.0


def test_a_kernel_counts_no_references_where_another_contains_it(installation: Installation) -> None:
    """So it is slow for nobody, and one that makes arrays is refused by whom contains it first."""
    making = MAKING.replace("allocating\ndef", "kernel\ndef")
    (installation.package / "kernels" / "outer.py").write_text(making)
    assert "TypingError" in installation.start().communicate()[1]


def test_runs_without_compiler(installation: Installation) -> None:
    """NUMBA_DISABLE_JIT leaves plain functions, for debuggers and coverage."""
    assert result(installation.start(NUMBA_DISABLE_JIT="1"))[1:3] == (6.0, -1)

"""Whoever waits for kernels sees how many there are, and for how long."""

import io
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from rich.console import Console

from cortex_dsl.api.scenario import load
from cortex_dsl.console.kernels import SEARCH, MissingKernels
from cortex_dsl.report.terminal.kernel_progress import COMPILED, COMPILING, KernelProgress
from engine.compiling_apart import PARTS, KernelDemand, missing_kernels, stored_name

EXAMPLE = Path(__file__).parents[3] / "examples" / "left_turn.scn"
COUNTING = """
import sys
from cortex_dsl.cli import main
from engine.kernels import numba_internals

used, key = set(), numba_internals._KernelCache._index_key

def noted(self, signature, codegen):
    used.add((self._function, str(signature)))
    return key(self, signature, codegen)

numba_internals._KernelCache._index_key = noted
main([sys.argv[1], "--ga", "--generations", "3", "--population", "20", "--out", sys.argv[2]])
print(*{name for name, _ in used}, file=sys.stderr)
"""


def shown(terminal: bool) -> str:
    """What is said while two of three kernels appear, one after the other, with a pulse in which none does."""
    console = Console(file=io.StringIO(), force_terminal=terminal, width=60)
    with KernelProgress(console, 3, iter((2, 2, 1, 1)).__next__) as progress:
        for _ in range(3):
            progress.tell()
            if terminal and progress._live is not None:
                progress._live.refresh()
    assert progress.kernels == 2
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


def test_without_a_terminal_each_kernel_is_a_line() -> None:
    """A log tells that work goes on, and tests can leave these lines out."""
    said = shown(terminal=False)
    assert said.splitlines() == [f"kernels: {number} of 3, 0 s" for number in (1, 2)]
    assert not COMPILED.sub("", f"{COMPILING}\n{said}")


def test_on_a_terminal_one_line_is_redrawn() -> None:
    """It is gone when all are there."""
    said = shown(terminal=True)
    assert "kernels: 1 of 3, 0 s" in said
    assert said.count("\n") == 1


def test_only_announced_kernels_are_counted(tmp_path: Path) -> None:
    """So the total is that of the beginning, though kernels that others call are stored beside them, some twice."""
    demand = KernelDemand(tuple(PARTS[name] for name in SEARCH), load(EXAMPLE).program)
    missing = MissingKernels(demand, (tmp_path,), missing_kernels(demand, (tmp_path,)))
    console = Console(file=io.StringIO(), width=60)
    files = [stored_name(kernel, "1") for kernel in demand.kernels()]
    files += ["sight/sight.look.1.nbc", "sight/sight.look.2.nbc"]
    with KernelProgress(console, missing.count, missing.still_missing) as progress:
        for file in (tmp_path / each for each in sorted(files)):
            file.parent.mkdir(exist_ok=True)
            file.write_text("")
            progress.tell()
    assert isinstance(console.file, io.StringIO)
    said = [line.rpartition(",")[0] for line in console.file.getvalue().splitlines()]
    assert said == [f"kernels: {number + 1} of {missing.count}" for number in range(missing.count)]


def test_the_kernels_that_are_announced_are_those_that_the_example_needs(tmp_path: Path) -> None:
    """Other commands draw genomes, too; `look` is not announced, as other kernels call it."""
    command = [sys.executable, "-c", COUNTING, str(EXAMPLE), str(tmp_path / "run")]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    demand = KernelDemand(tuple(PARTS[name] for name in SEARCH), load(EXAMPLE).program)
    announced = {f"{module}.{module}.{name}" for module, name in map(_place, demand.kernels())}
    assert announced - {"random_numbers.random_numbers.fill_uniform"} == set(done.stderr.splitlines()[-1].split()) - {
        "sight.sight.look"
    }


def _place(kernel: Callable[..., object]) -> tuple[str, str]:
    return kernel.__module__.rpartition(".")[2], kernel.__name__

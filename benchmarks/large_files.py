"""How long does a large file take to compile? `python -m benchmarks.large_files [--json]`

Files of many params, objects, requirements and so on, of 128 KiB and of 256 KiB, which is as large as a file may be,
and two of which only the compiler's answer counts: 30 misspelt names among 5,000, and 1,000 params. Seconds of
computing, the least of `--times`, as whatever else the machine does only adds to them; exit code 1 where a file takes
longer than it may, or twice the text more than 2.2 times as long.
"""

import argparse
import gc
import json
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress

from cortex_dsl.__main__ import NEW_BEFORE_A_LOOK
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.pipeline import compile_source
from cortex_dsl.source import Source
from cortex_dsl.syntax.errors import MAX_BYTES

LIMIT = 8.0
"""For the largest file [s]."""
SMALL_LIMIT = 1.0
"""For 1,000 params, and for 30 misspelt names [s]."""
RATIO = 2.2
EGO = "ego = new Car at (0, 0)\n"

LARGE: Mapping[str, Callable[[int], str]] = {
    "params, each required": lambda i: f"param p{i} = Range(1, {i + 2})\nrequire p{i} > 1.1\n",
    "objects": lambda i: f"car{i} = new Car at ({i % 50 * 20}, {i // 50 * 20}), with regionContainedIn None\n",
    "draws": lambda i: f"d{i} = Normal({i}, 1)\n",
    "values": lambda i: f"x{i} = {i} + 3 * (2 - {i}) if {i} > 4 else sqrt({i})\n",
    "functions": lambda i: f"def f{i}(x):\n    y = x + {i}\n    return y * 2\nz{i} = f{i}({i})\n",
    "behaviors": lambda i: f"behavior B{i}(v):\n    do FollowLaneBehavior(v) for 2 s\n    take SetBrakeAction(1)\n",
    "requirements": lambda i: f"require (distance from ego to (9, {i})) > {i / 1000} m\n",
    "requirements on the run": lambda i: f"require always ego.speed < {i + 40} m/s\n",
    "ends": lambda i: f"terminate when (distance from ego to (20, 10)) < {i / 1000} m\n",
    "texts": lambda i: f'x{i} = f"{{{i}}} cars of {{{i} m:.1f}}"\n',
    "records": lambda i: f"record ego.speed + {i} as r{i}\n",
}
"""One part of a file, which is made of many of them behind its ego."""


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--times", type=int, default=3, help="how often each file is compiled (3)")
    gc.set_threshold(NEW_BEFORE_A_LOOK)  # as the command has it
    options = parser.parse_args(arguments)
    seconds_of(EGO)  # whatever is loaded once

    def least(text: str) -> float:
        return min(seconds_of(text) for _ in range(options.times))

    sizes = (MAX_BYTES // 2, MAX_BYTES)
    found = {name: [least(of_size(part, size)) for size in sizes] for name, part in LARGE.items()}
    params = of_parts(LARGE["params, each required"], 1_000)
    small = {"1,000 params, each required": least(params)}
    small["30 misspelt names among 5,000"] = least(misspelt(5_000, 30))
    if options.json:
        print(json.dumps({"large": found, "small": small}))
    else:
        _print(found, small)
    late = any(whole > LIMIT or whole > RATIO * half for half, whole in found.values())
    return 1 if late or max(small.values()) > SMALL_LIMIT else 0


def of_parts(part: Callable[[int], str], count: int) -> str:
    return EGO + "".join(map(part, range(count)))


def of_size(part: Callable[[int], str], size: int) -> str:
    """As many parts as fit."""
    text, number = [EGO], 0
    room = size - len(EGO)
    while (room := room - len(part(number))) >= 0:
        text.append(part(number))
        number += 1
    return "".join(text)


def misspelt(names: int, mistakes: int) -> str:
    wrong = "".join(f"require nome{7 * i} > 1\n" for i in range(mistakes))
    return "".join(f"name{i} = {i}\n" for i in range(names)) + EGO + wrong


def seconds_of(text: str) -> float:
    """What it takes to compile a text, which may have errors."""
    start = time.process_time()
    with suppress(CompileError):
        compile_source(Source("large.scn", text))
    return time.process_time() - start


def _print(found: Mapping[str, Sequence[float]], small: Mapping[str, float]) -> None:
    print("| file of | 128 KiB [s] | 256 KiB [s] | ratio |\n|---|---|---|---|")
    for name, (half, whole) in found.items():
        print(f"| {name} | {half:.2f} | {whole:.2f} | {whole / half:.2f} |")
    for name, seconds in small.items():
        print(f"| {name} | | {seconds:.2f} | |")


if __name__ == "__main__":
    sys.exit(main())

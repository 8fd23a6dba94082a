"""Is there a text that breaks the compiler? Mutated bytes, tokens, meanings and numbers, and sentences of the grammar.

    python -m benchmarks.fuzz texts --inputs 100000 [--seed 0] [--jobs 2] [--keep FOLDER] [--json]

Every input is compiled as `cortexc FILE --check` compiles it. It must end within the time limit in a program or in
diagnostics with places inside the text: no other exception, no hang, no memory blow-up. Exit code 1 if one does not;
`--keep` writes those texts down, and the slowest.
"""

import argparse
import json
import random
import re
import resource
import signal
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import TypeVar

from benchmarks.sentences import Sentences
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.pipeline import compile_source
from cortex_dsl.syntax.reading import decode

ROOT = Path(__file__).parents[2]
TIME_LIMIT = 20
"""For one text [s]."""
MEMORY_LIMIT = 4 << 30
"""Address space of a process [bytes]."""
CHUNK = 250
SEEDS = 1_000_003
"""How far apart the streams of two seeds begin."""
SIGNS = ("\n", "\t", "    ", " ", "\\", "\x00", "\x0c", "é", "😀", "#", "'", '"', "'''", '"""', *"()[]{},:=<+-*/%@.")
WORDS = """
== <= ** 0 1 -1 1e999 5 m km/h deg 90 0.5 None True xyz Range Uniform Normal speed Car ego self intersection
require param behavior do until for take wait try interrupt when abort terminate after new at in on with facing ahead of
by offset along distance from to if elif else while lambda not and or is monitor scenario setup compose class import as
record mutate always eventually choose shuffle override signals map precondition invariant
"""
TOKENS = (*SIGNS, *WORDS.split())

_NUMBER = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)(?![\w.])")

Found = TypeVar("Found")


class TooLong(Exception):  # noqa: N818 - what happened
    """A text has taken longer than it may."""


@dataclass(frozen=True)
class Broken:
    """A text that must not be."""

    kind: str
    text: bytes
    trace: str


@dataclass(frozen=True)
class Fuzzed:
    """What became of all texts."""

    inputs: int
    outcomes: dict[str, int]
    """How many compiled, how many were answered with diagnostics, and how many broke something, by kind of input."""
    broken: int
    slowest: float
    """[s]"""
    memory: float
    """Greatest resident set of a process [MiB]."""
    seconds: float


# -- texts ------------------------------------------------------------------------------------------------------------


def corpus() -> list[str]:
    """Programs to mutate: the examples, every block of the reference, and the programs of diagnostics and tests."""
    texts = [path.read_text(encoding="utf-8") for path in sorted((ROOT / "examples").glob("*.scn"))]
    for page in sorted((ROOT / "docs").rglob("*.md")):
        texts += [block.split("```")[0] for block in page.read_text(encoding="utf-8").split("```scn\n")[1:]]
    programs = (path for folder in ("cortex_dsl/codes", "tests") for path in sorted((ROOT / folder).rglob("*.scn")))
    return texts + [path.read_text(encoding="utf-8", errors="replace") for path in programs]


def mutated_bytes(rng: random.Random, texts: list[str]) -> bytes:
    """A program with some bytes changed, inserted, removed or repeated."""
    data = bytearray(_piece(rng, texts).encode())
    for _ in range(rng.choice((1, 1, 2, 5, 20))):
        at = rng.randrange(len(data) + 1)
        change = rng.randrange(4)
        if change == 0:
            data[at:at] = bytes(rng.randrange(256) for _ in range(rng.randrange(1, 4)))
        elif change == 1:
            del data[at : at + rng.randrange(1, 9)]
        elif change == 2:
            data[at:at] = data[at : at + rng.randrange(1, 40)] * rng.randrange(1, 4)
        elif at < len(data):
            data[at] ^= 1 << rng.randrange(8)
    return bytes(data)


def mutated_tokens(rng: random.Random, texts: list[str]) -> bytes:
    """A program with some words changed for others, moved, doubled or left out."""
    words = _words(_piece(rng, texts))
    for _ in range(rng.choice((1, 1, 2, 4, 10))):
        at = rng.randrange(len(words) + 1)
        change = rng.randrange(5)
        if change == 0:
            words.insert(at, rng.choice(TOKENS))
        elif change == 1:
            del words[at : at + rng.randrange(1, 4)]
        elif change == 2 and at < len(words):
            words[at] = rng.choice(TOKENS)
        elif change == 3:
            words[at:at] = _words(_piece(rng, texts))[:12]
        elif words:
            other = rng.randrange(len(words))
            words[at:at] = words[other : other + rng.randrange(1, 8)]
    return "".join(words).encode()


def mutated_sense(rng: random.Random, texts: list[str]) -> bytes:
    """A program whose grammar is mostly kept: numbers become other numbers, names other names of the same program."""
    words = _words(rng.choice([text for text in texts if "ego = new" in text]))
    names = [word for word in words if word.isidentifier()]
    numbers = [word for word in words if word.isdigit()] + ["0", "1", "999999999", "360"]
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        pool = names if names and rng.random() < 0.7 else numbers
        places = [i for i, word in enumerate(words) if (word.isidentifier() if pool is names else word.isdigit())]
        if places:
            words[rng.choice(places)] = rng.choice(pool)
    return "".join(words).encode()


def mutated_numbers(rng: random.Random) -> bytes:
    """A scenario that compiles, with some numbers made larger or smaller: mostly it still does, and runs otherwise."""
    parts = _NUMBER.split(rng.choice(sound()))
    for _ in range(rng.choice((1, 1, 2, 4)) if len(parts) > 1 else 0):
        at = rng.randrange(1, len(parts), 2)
        parts[at] = f"{float(parts[at]) * rng.choice((0.0, rng.uniform(0.3, 3.0), rng.uniform(0.8, 1.25))):.6g}"
    return "".join(parts).encode()


@cache
def sound() -> list[str]:
    """Scenarios of this repository that compile: the examples, those of the hosts' agreement and of the suite."""
    folders = ("examples", "tests/agreement", "benchmarks/suite")
    return [path.read_text(encoding="utf-8") for folder in folders for path in sorted((ROOT / folder).glob("*.scn"))]


def _piece(rng: random.Random, texts: list[str]) -> str:
    text = rng.choice(texts)
    lines = text.splitlines(keepends=True)
    if len(lines) > 30 and rng.random() < 0.5:
        start = rng.randrange(len(lines) - 10)
        return "".join(lines[start : start + rng.randrange(3, 30)])
    return text


def _words(text: str) -> list[str]:
    """Runs of letters, of spaces, and single signs."""
    words: list[str] = []
    for letter in text:
        kind = (letter.isalnum() or letter == "_", letter == " ")
        if words and any(kind) and kind == (words[-1][-1].isalnum() or words[-1][-1] == "_", words[-1][-1] == " "):
            words[-1] += letter
        else:
            words.append(letter)
    return words


def sources(rng: random.Random, texts: list[str]) -> Iterator[tuple[str, bytes]]:
    """Texts for ever: (kind, text)."""
    sentences = Sentences(rng)
    kinds: dict[str, Callable[[], bytes]] = {
        "bytes": lambda: mutated_bytes(rng, texts),
        "tokens": lambda: mutated_tokens(rng, texts),
        "sense": lambda: mutated_sense(rng, texts),
        "grammar": lambda: sentences.program().encode(),
        "numbers": lambda: mutated_numbers(rng),
    }
    while True:
        for kind, make in kinds.items():
            yield kind, make()


# -- judgement --------------------------------------------------------------------------------------------------------


def judge(text: bytes) -> str:
    """`compiled` or `diagnostics`; raises whatever must not be."""
    try:
        compile_source(decode("fuzzed.scn", text))
    except CompileError as error:
        if not error.diagnostics:
            raise AssertionError("an error without a diagnostic") from error
        length = len(error.source.text)
        for diagnostic in error.diagnostics:
            if not 0 <= diagnostic.label.span.start <= diagnostic.label.span.end <= length:
                raise AssertionError(f"{diagnostic.code} lies outside the text") from error
        return "diagnostics"
    return "compiled"


@contextmanager
def limited(seconds: int) -> Iterator[None]:
    def stop(*_: object) -> None:
        raise TooLong

    signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)  # of processor time: others may use the machine
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


@dataclass(frozen=True)
class Part:
    """What one chunk of texts gave."""

    outcomes: Counter[str]
    broken: list[Broken]
    slowest: float
    slowest_text: bytes
    memory: float


def run_chunk(seed: int, count: int) -> Part:
    """`count` texts of one stream of random numbers."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_LIMIT, MEMORY_LIMIT))
    rng, outcomes, broken = random.Random(seed), Counter[str](), list[Broken]()
    slowest, slowest_text = 0.0, b""
    stream = sources(rng, corpus())
    for _ in range(count):
        kind, text = next(stream)
        start = time.perf_counter()
        try:
            with limited(TIME_LIMIT):
                outcome = judge(text)
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            outcome = "broken"
            broken.append(Broken(type(error).__name__, text, traceback.format_exc()))
        slowest, slowest_text = max((slowest, slowest_text), (time.perf_counter() - start, text))
        outcomes[f"{kind} {outcome}"] += 1
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return Part(outcomes, broken, slowest, slowest_text, memory)


def spread(
    work: Callable[..., Found], inputs: int, chunk: int, seed: int, jobs: int, *more: Sequence[int]
) -> list[Found]:
    """`work(seed, count, …)` for chunks of so many inputs, in so many processes; `more`: a number for each chunk."""
    sizes = chunks(inputs, chunk)
    seeds = [seed + number for number in range(len(sizes))]
    if jobs == 1:
        return list(map(work, seeds, sizes, *more))
    with ProcessPoolExecutor(jobs) as pool:
        return list(pool.map(work, seeds, sizes, *more))


def chunks(inputs: int, chunk: int) -> list[int]:
    """How many inputs each chunk has."""
    return [min(chunk, inputs - first) for first in range(0, inputs, chunk)]


def write_down(broken: Sequence[Broken], keep: Path) -> None:
    """Each text in a file, and its trace beside it."""
    keep.mkdir(parents=True, exist_ok=True)
    for number, each in enumerate(broken):
        (keep / f"{number:04d}-{each.kind}.scn").write_bytes(each.text)
        (keep / f"{number:04d}-{each.kind}.txt").write_text(each.trace, encoding="utf-8")


def fuzz(inputs: int, seed: int = 0, jobs: int = 1, keep: Path | None = None) -> Fuzzed:
    """Judge that many texts; those that break something are written to `keep`."""
    start = time.perf_counter()
    parts = spread(run_chunk, inputs, CHUNK, seed * SEEDS, jobs)
    broken = [each for part in parts for each in part.broken]
    if keep is not None:
        write_down(broken, keep)
        (keep / "slowest.scn").write_bytes(max((part.slowest, part.slowest_text) for part in parts)[1])
    return Fuzzed(
        inputs=inputs,
        outcomes=dict(sorted(sum((part.outcomes for part in parts), Counter[str]()).items())),
        broken=len(broken),
        slowest=max(part.slowest for part in parts),
        memory=max(part.memory for part in parts),
        seconds=time.perf_counter() - start,
    )


def main(arguments: Sequence[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--inputs", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    found = fuzz(options.inputs, options.seed, options.jobs, options.keep)
    if options.json:
        print(json.dumps(asdict(found), indent=2))
    else:
        for name, count in found.outcomes.items():
            print(f"{name:22}{count:>9,}")
        print(f"broken {found.broken}, slowest {found.slowest:.2f} s, {found.memory:.0f} MiB, {found.seconds:.0f} s")
    return 1 if found.broken else 0

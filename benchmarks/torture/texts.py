"""Texts of the fuzzer, of which those that compile run to the end: in both hosts, and as their concrete scenario."""

import random
import resource
import traceback
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from itertools import count as numbers
from pathlib import Path

import cortex_dsl as cx
from benchmarks import agreement
from benchmarks.fuzz import texts as fuzz
from benchmarks.torture.ledger import Ledger
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.syntax.reading import decode
from engine import batch

CHUNK = 100
"""Texts that a process takes at a time."""
TIME_LIMIT = 120
"""For one run in both hosts, of processor time [s]."""
FIRST = 500_000
"""Of the seeds of chunks: those of the fuzzer come before."""
SAME = ("verdict", "collided", "end_reason", "steps", "min_distance", "closing_speed", "end_time", "contact_actors")
"""What a concrete scenario comes to, bit for bit."""


@dataclass(frozen=True)
class Chunk:
    """So many texts of one stream of random numbers."""

    seed: int
    texts: int
    runs: int
    """At most so many of them run to the end."""

    @property
    def name(self) -> str:
        return f"{self.seed}-{self.texts}-{self.runs}"


@dataclass(frozen=True)
class Part:
    """What became of the texts of one chunk."""

    outcomes: Counter[str]
    broken: list[fuzz.Broken]


def run_to_the_end(text: bytes) -> str:
    """What a text that compiles comes to; raises whatever must not be."""
    scenario = cx.compile_text(decode("fuzzed.scn", text).text)
    contact = replace(scenario.config.contact, aftermath=0.0)
    scenario = replace(scenario, config=replace(scenario.config, contact=contact))
    if scenario.program.controls:
        return "nobody drives"
    try:
        scenes = scenario.scene_of_seed(0)
    except CompileError:  # said with its place, as it turns out once something is drawn: what can never hold
        return "no scene"
    if not scenes.valid[0]:
        return "no scene"
    found = agreement.held(scenario, scenes)
    if found.flags_differ or found.states_differ > agreement.TOLERANCE:
        raise AssertionError(f"the hosts differ: {found}")
    again = cx.compile_text(scenario.concrete(scenes))
    again = replace(again, config=scenario.config)
    one, other = (
        batch.simulate(each.program, drawn, each.config.simulation, contact=each.config.contact)
        for each, drawn in ((scenario, scenes), (again, again.scene_of_seed()))
    )
    for name in SAME:
        if getattr(one, name).tobytes() != getattr(other, name).tobytes():
            raise AssertionError(f"the concrete scenario differs in {name}")
    return "run to the end"


def run_chunk(chunk: Chunk) -> Part:
    """Judge the texts of a chunk, in a process that may not take more memory than the fuzzer's."""
    resource.setrlimit(resource.RLIMIT_AS, (fuzz.MEMORY_LIMIT, fuzz.MEMORY_LIMIT))
    stream, outcomes, broken = fuzz.sources(random.Random(chunk.seed), fuzz.corpus()), Counter[str](), []
    for _ in range(chunk.texts):
        kind, text = next(stream)
        try:
            with fuzz.limited(fuzz.TIME_LIMIT):
                outcome = fuzz.judge(text)
            outcomes[outcome] += 1
            if outcome == "compiled" and outcomes["run to the end"] < chunk.runs:
                with fuzz.limited(TIME_LIMIT):
                    outcomes[run_to_the_end(text)] += 1
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            outcomes["broken"] += 1
            broken.append(fuzz.Broken(f"{kind}-{type(error).__name__}", text, traceback.format_exc()))
    return Part(outcomes, broken)


def chunks(texts: int, runs: int, seed: int) -> list[Chunk]:
    """So many texts in chunks, each with its share of the runs."""
    sizes = fuzz.chunks(texts, CHUNK)
    return [Chunk(seed * fuzz.SEEDS + FIRST + n, size, -(-runs * size // texts)) for n, size in zip(numbers(), sizes)]


def judged(texts: int, runs: int, seed: int, jobs: int, ledger: Ledger, keep: Path | None) -> Counter[str]:
    """What became of so many texts; those that break something are written down at once."""
    asked = chunks(texts, runs, seed)
    for chunk, part in _spread([each for each in asked if each.name not in ledger.done], jobs):
        if keep is not None and part.broken:
            fuzz.write_down(part.broken, keep / f"broken-{chunk.name}")
        ledger.add(chunk.name, part.outcomes)
    return sum((Counter(ledger.done[chunk.name]) for chunk in asked), Counter[str]())


def _spread(asked: list[Chunk], jobs: int) -> Iterator[tuple[Chunk, Part]]:
    """Each chunk and what became of it, whichever is done first."""
    with ProcessPoolExecutor(jobs) as pool:
        running = {pool.submit(run_chunk, chunk): chunk for chunk in asked}
        try:
            for done in as_completed(running):
                yield running[done], done.result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)

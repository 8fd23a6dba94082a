"""How often each scenario fails, and how: plain draws from its own distributions, kept and added to.

Draws are numbered, so that pieces add up to one campaign: the next piece begins where the last one ended.
"""

import json
from collections import Counter
from dataclasses import asdict, dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np

from benchmarks.suite.scenarios import HALVES, HERE, Runs, scenario
from cortex_dsl import Scenario
from engine.batch import simulate
from engine.sampling import draw_genomes, sample
from engine.search.statistics import clopper_pearson
from engine.streams import key_rows
from engine.vocabulary import Method, Verdict

KEPT = HERE / "truth.json"
SEED = 20_000
"""Of no search."""
BLOCK = 20_000
LEAST = 0.01
"""Share of failures from which a mechanism counts as known."""


@dataclass(frozen=True)
class Truth:
    """What plain draws of one scenario came to."""

    digest: str
    """Of the program: draws of another one are no part of it."""
    draws: int = 0
    valid: int = 0
    failures: int = 0
    mechanisms: dict[str, int] = field(default_factory=dict)

    @property
    def rate(self) -> float:
        return self.failures / self.valid if self.valid else float("nan")

    @property
    def known(self) -> tuple[str, ...]:
        """Mechanisms that are no curiosities, the most frequent first."""
        often = Counter(self.mechanisms).most_common()
        return tuple(name for name, count in often if count >= max(2.0, LEAST * self.failures))


def kept(path: Path = KEPT) -> dict[str, Truth]:
    """By scenario."""
    return {name: Truth(**row) for name, row in json.loads(path.read_text()).items()} if path.exists() else {}


def add(names: list[str], count: int, jobs: int, path: Path = KEPT) -> None:
    """Make so many further draws of each, and keep them after each block: an interrupted call loses one block."""
    for name in names:
        made = scenario(name)
        known = kept(path).get(name, Truth(made.program.digest))
        known = known if known.digest == made.program.digest else Truth(made.program.digest)
        ends = [*range(known.draws, known.draws + count, BLOCK), known.draws + count]
        for first, last in pairwise(ends):
            known = _added(known, made, *_drawn(made, first, last, jobs))
            everything = kept(path) | {name: known}
            rows = {each: asdict(everything[each]) for each in HALVES if each in everything}
            path.write_text(json.dumps(rows, indent=1) + "\n")


def _drawn(made: Scenario, first: int, last: int, jobs: int) -> tuple[int, int, Runs]:
    """How many were drawn, how many are valid, and the runs."""
    program, config = made.program, made.config.simulation
    keys = key_rows(SEED, Method.SAMPLE, 0, 0, np.arange(first, last))
    outcomes = simulate(program, sample(program, draw_genomes(program.space, keys), keys, config, jobs), config, jobs)
    pair, rows = np.maximum(outcomes.contact_actors[:, 1] - 1, 0), np.arange(last - first)
    columns = {name: getattr(outcomes, name)[rows, pair] for name in ("fault", "side", "ego_speed", "other_speed")}
    valid = outcomes.verdict == Verdict.VALID
    return last - first, int(valid.sum()), Runs(outcomes.collided & valid, pair=pair, **columns)


def _added(known: Truth, made: Scenario, draws: int, valid: int, runs: Runs) -> Truth:
    counts = Counter(known.mechanisms) + Counter(runs.mechanisms(made.program.actors))
    return Truth(
        known.digest,
        known.draws + draws,
        known.valid + valid,
        known.failures + int(runs.failed.sum()),
        dict(sorted(counts.items())),
    )


def table(truths: dict[str, Truth]) -> str:
    """As Markdown."""
    lines = [
        "| scenario | for | genes | plain draws | failures | rate | 95 % interval | mechanisms, and their shares |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, truth in truths.items():
        low, high = clopper_pearson(truth.failures, max(1, truth.valid))
        shares = ", ".join(f"{each} {truth.mechanisms[each] / truth.failures:.0%}" for each in truth.known)
        genes = len(scenario(name).program.space)
        lines.append(
            f"| {name} | {HALVES[name]} | {genes} | {truth.valid:,} | {truth.failures:,} | {truth.rate:.1e} "
            f"| {low:.1e} .. {high:.1e} | {shares} |"
        )
    return "\n".join(lines)

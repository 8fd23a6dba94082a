"""How often each scenario fails, and how: plain draws from its own distributions, kept and added to.

Draws are numbered, so that pieces add up to one campaign: the next piece begins where the last one ended.
"""

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from itertools import pairwise, product
from pathlib import Path

import numpy as np
from numpy.random import default_rng

from benchmarks.suite.planting import EDGES, FAMILIES, Defect, planted, undisturbed
from benchmarks.suite.scenarios import HALVES, HERE, HIDDEN, Runs, mechanism_of, planted_in, scenario
from cortex_dsl import Scenario, compile_text
from engine.batch import simulate
from engine.sampling import draw_genomes, sample
from engine.search.statistics import clopper_pearson
from engine.streams import key_rows
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Method, Verdict

KEPT = HERE / "truth.json"
SEED = 20_000
"""Of no search."""
BLOCK = 20_000
STRATA = 3 * (len(EDGES) - 1)
"""Shells around the three defects of a file."""
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
    rates: dict[str, float] = field(default_factory=dict)
    """By mechanism: the rate by strata around a planted defect, and …"""
    error: float = 0.0
    """… the standard error of their sum; `draws`, `valid` and `failures` are then those of all strata."""

    @property
    def rate(self) -> float:
        return sum(self.rates.values()) if self.rates else self.failures / max(1, self.valid)

    @property
    def interval(self) -> tuple[float, float]:
        """Bounds of the rate that hold with 95 %."""
        if self.rates:
            return self.rate - 1.96 * self.error, self.rate + 1.96 * self.error
        low, high = clopper_pearson(self.failures, max(1, self.valid))
        return low, high

    @property
    def known(self) -> tuple[str, ...]:
        """Mechanisms that are no curiosities, the most frequent first."""
        if self.rates:
            return tuple(sorted((name for name in self.rates if self.rates[name]), key=lambda name: -self.rates[name]))
        often = Counter(self.mechanisms).most_common()
        return tuple(name for name, count in often if count >= max(2.0, LEAST * self.failures))


def kept(path: Path = KEPT) -> dict[str, Truth]:
    """By scenario."""
    return {name: Truth(**row) for name, row in json.loads(path.read_text()).items()} if path.exists() else {}


def add(names: list[str], count: int, jobs: int, path: Path = KEPT) -> None:
    """Make so many further draws of each, and keep them after each block: an interrupted call loses one block."""
    for name in names:
        made = scenario(name)
        if defects := planted_in(name):
            _store(name, by_strata(made, defects, max(1, count // STRATA), jobs), path)
            continue
        known = kept(path).get(name, Truth(made.program.digest))
        known = known if known.digest == made.program.digest else Truth(made.program.digest)
        ends = [*range(known.draws, known.draws + count, BLOCK), known.draws + count]
        for first, last in pairwise(ends):
            known = _added(known, made, *_drawn(made, first, last, jobs))
            _store(name, known, path)


def _store(name: str, known: Truth, path: Path) -> None:
    everything = kept(path) | {name: known}
    rows = {each: asdict(everything[each]) for each in HALVES if each in everything}
    path.write_text(json.dumps(rows, indent=1) + "\n")


def _drawn(made: Scenario, first: int, last: int, jobs: int) -> tuple[int, int, Runs]:
    """How many were drawn, how many are valid, and the runs."""
    keys = key_rows(SEED, Method.SAMPLE, 0, 0, np.arange(first, last))
    valid, runs = _run(made, draw_genomes(made.program.space, keys), keys, jobs)
    return last - first, int(valid.sum()), runs


def _run(made: Scenario, genomes: Floats, keys: Ints, jobs: int) -> tuple[Bools, Runs]:
    """Which genomes have a scene, and their runs."""
    program, config = made.program, made.config.simulation
    outcomes = simulate(program, sample(program, genomes, keys, config, jobs), config, jobs)
    pair, rows = np.maximum(outcomes.contact_actors[:, 1] - 1, 0), np.arange(len(genomes))
    columns = {name: getattr(outcomes, name)[rows, pair] for name in ("fault", "side", "ego_speed", "other_speed")}
    valid = outcomes.verdict == Verdict.VALID
    return valid, Runs(outcomes.collided & valid, pair=pair, genomes=genomes, **columns)


def plant(seed: str, folder: Path, count: int, jobs: int) -> None:
    """Write the planted files of a seed, and the defects that they hide; `count` runs decide how steep those are."""
    for family in FAMILIES:
        if least_clearance(family, count, jobs) <= 0.0:
            raise SystemExit(
                f"{family}: the ego fails without a defect, so that rates around defects are not those of the file"
            )
    folder.mkdir(parents=True, exist_ok=True)
    hidden = {}
    for each in planted(seed):
        first = by_strata(compile_text(each.text, each.name), each.defects, max(1, count // STRATA), jobs)
        rates = [first.rates[mechanism_of(number)] for number in range(len(each.defects))]
        if not all(rates):
            raise SystemExit(f"{each.name}: no failure near a defect in --count {count:,} runs; take more")
        made = each.adjusted(rates)
        (folder / f"{made.name}.scn").write_text(made.text)
        hidden[made.name] = [asdict(defect) for defect in made.defects]
        (folder / HIDDEN.name).write_text(json.dumps(hidden, indent=1) + "\n")


def least_clearance(family: str, count: int, jobs: int = 1) -> float:
    """The least distance of an ego without a defect [m], at the corners of the space and in `count` draws."""
    made = compile_text(undisturbed(family), family)
    space, config = made.program.space, made.config.simulation
    corners = np.array(list(product(*zip(space.low, space.high, strict=True))))
    keys = key_rows(SEED, Method.SAMPLE, 0, 0, np.arange(len(corners) + count))
    genomes = np.concatenate([corners, draw_genomes(space, keys[len(corners) :])])
    outcomes = simulate(made.program, sample(made.program, genomes, keys, config, jobs), config, jobs)
    return float(np.nanmin(outcomes.min_distance))


def by_strata(made: Scenario, defects: Sequence[Defect], count: int, jobs: int) -> Truth:
    """Rates of failures near each of the defects, by `count` draws of each shell; genes that a defect does not name are
    drawn from the file. A failure near two defects counts for the one that delays the brake more.
    """
    space = made.program.space
    low, width = space.low, space.high - space.low
    stream, failures, rates, variance = default_rng(SEED), Counter[str](), {}, 0.0
    draws, all_valid = 0, 0
    for number, defect in enumerate(defects):
        own = [space.names.index(gene) for gene in defect.genes]
        name, rate = mechanism_of(number), 0.0
        for volume, points in defect.shells(count, stream):
            keys = key_rows(SEED, Method.SAMPLE, number + 1, 0, np.arange(draws, draws + count))
            genomes = draw_genomes(space, keys)
            genomes[:, own] = low[own] + points * width[own]
            valid, runs = _run(made, genomes, keys, jobs)
            hits = sum(each == name for each in runs.mechanisms(made.program, defects))
            share = hits / count
            rate += volume * share
            variance += volume**2 * share * (1.0 - share) / count
            failures[name] += hits
            draws += count
            all_valid += int(valid.sum())
        rates[name] = rate
    return Truth(
        made.program.digest, draws, all_valid, failures.total(), dict(sorted(failures.items())), rates, variance**0.5
    )


def _added(known: Truth, made: Scenario, draws: int, valid: int, runs: Runs) -> Truth:
    counts = Counter(known.mechanisms) + Counter(runs.mechanisms(made.program))
    return Truth(
        known.digest,
        known.draws + draws,
        known.valid + valid,
        known.failures + int(runs.failed.sum()),
        dict(sorted(counts.items())),
    )


def beside_plain_draws(names: Sequence[str], count: int, jobs: int) -> str:
    """Rates that are kept, and the exact 95 % intervals of `count` plain draws of each file, as Markdown."""
    lines = ["| scenario | rate | plain draws | failures | 95 % interval | |", "|---|---|---|---|---|---|"]
    for name in names:
        made = scenario(name)
        _, valid, runs = _drawn(made, 0, count, jobs)
        failures = int(runs.failed.sum())
        low, high = clopper_pearson(failures, valid)
        rate = kept()[name].rate
        answer = "holds" if low <= rate <= high else "**outside**"
        lines.append(f"| {name} | {rate:.2e} | {valid:,} | {failures} | {low:.2e} .. {high:.2e} | {answer} |")
    return "\n".join(lines)


def table(truths: dict[str, Truth]) -> str:
    """As Markdown."""
    lines = [
        "| scenario | for | genes | draws | failures | rate | 95 % interval | mechanisms, and their shares |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, truth in truths.items():
        low, high = truth.interval
        weights = truth.rates or truth.mechanisms
        shares = ", ".join(f"{each} {weights[each] / sum(weights.values()):.0%}" for each in truth.known)
        genes = len(scenario(name).program.space)
        lines.append(
            f"| {name} | {HALVES[name]} | {genes} | {truth.valid:,} | {truth.failures:,} | {truth.rate:.1e} "
            f"| {low:.1e} .. {high:.1e} | {shares} |"
        )
    return "\n".join(lines)

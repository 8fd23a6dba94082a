"""Probability of a collision under the file's own distributions, given a valid run.

There are two conditions:

- `params`: params are drawn once, then up to `max_attempts` scenes are drawn until one meets the requirements. Params
  that allow a scene count in full, even if such scenes are rare.
- `joint`: params are drawn again with every attempt. This is P(collision | the requirements hold), as they are written:
  params count by how often they allow a scene.

Both leave out runs that a requirement on the run makes invalid: every figure is a probability *given* a valid run. A
run in which a driver of one's own failed is one of which nothing is known: it widens the interval.

Three estimators: `monte_carlo`, independent draws, the share of collisions with the exact interval of Clopper and
Pearson (1934), "The use of confidence or fiducial limits illustrated in the case of the binomial"; and, for what is
rare, `subset_simulation` and `importance_sampling`, which a score leads to failures. All also estimate how probable an
*avoidable* collision is: a reference driver drives those that were found again (`engine.avoidability`).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from engine.assessment import Evaluate, take
from engine.config import Config
from engine.errors import ArgumentError
from engine.outcomes import Assessment
from engine.program import ParamSpace, Program
from engine.search.insight.kinds import codes_of_draws
from engine.search.probability.confidence_sequence import sequence_interval
from engine.search.probability.estimates import (
    CONDITIONS,
    JOINT,
    MOST_DRIVEN,
    NOT_KNOWN,
    PARAMS,
    Count,
    Judge,
    Probability,
    Withheld,
)
from engine.search.probability.importance import LEAST as LEAST_IMPORTANCE
from engine.search.probability.importance import importance_sampling
from engine.search.probability.levels import DISTANCE, Score
from engine.search.probability.subset_simulation import LEAST as LEAST_SUBSET
from engine.search.probability.subset_simulation import subset_simulation
from engine.search.probability.unseen import NOTHING_DRAWN, Unseen, labels, unseen_kinds
from engine.search.statistics import clopper_pearson
from engine.streams import key_rows
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Blame, Method, Side, Verdict

if TYPE_CHECKING:
    from engine.search.objectives import Objective, Runs

__all__ = [
    "CONDITIONS",
    "JOINT",
    "METHODS",
    "PARAMS",
    "Estimator",
    "Probability",
    "estimate",
    "importance_sampling",
    "monte_carlo",
    "subset_simulation",
]


BLOCK = 4096
"""Draws that are simulated together."""
LOOK = 500
"""Draws between two looks at the confidence sequence."""
DRAWS_A_RUN = 200
"""Maximum number of draws per requested run under `joint`; the estimate then uses the runs so far."""


@dataclass(frozen=True)
class Estimator:
    """A method for rare events, which a score leads to the failures."""

    least: int
    """Samples that it needs."""
    function: Callable[..., Probability]
    """(space, evaluate, samples, seed, judge=, score=)"""


RARE = {
    "subset": Estimator(LEAST_SUBSET, subset_simulation),
    "importance": Estimator(LEAST_IMPORTANCE, importance_sampling),
}
METHODS = ("mc", *RARE)


def estimate(
    program: Program,
    config: Config,
    method: str,
    samples: int,
    seed: int = 0,
    condition: str = PARAMS,
    score: Score = DISTANCE,
    of: str = "",
    until_width: float = 0.0,
) -> Probability:
    """Return the probability for a program, by one of `METHODS`, on the host that the config names.

    The event is a collision, or with `of` the violation of that expectation of the file. With `until_width`, `mc` stops
    as soon as the confidence sequence is at most as wide; `samples` is the largest number then.

    Raises:
        UnknownObjectiveError: the file has no expectation of that name.
        ValueError: a method other than `mc` under `joint`; if every attempt at a scene has params of its own,
            neighbourhoods of params carry no information.
    """
    from engine.risk import PAPER
    from engine.search.evaluator import make_evaluator
    from engine.search.objectives import expectation

    if condition == JOINT:
        if method != "mc":
            raise ArgumentError("the joint condition needs method mc", "take method mc, or another condition")
        config = replace(config, simulation=replace(config.simulation, max_attempts=1))
    if until_width and (method != "mc" or not 0.0 < until_width < 1.0):
        raise ArgumentError(f"until_width is {until_width} with method {method}", "take method mc, and 0 < width < 1")
    config, *others = _recorded(config)
    aims, targets = _partners(program) if method == "importance" and not of and score is DISTANCE else ((), {})
    evaluate, judge = make_evaluator(program, config, PAPER, aims, stored=0), make_judge(program, *others, config)
    if of:
        evaluate = _of_event(make_evaluator(program, config, PAPER, (expectation(program, of),), stored=0))
        judge = None
        score = Score(of, "how far it is from being broken", "", lambda runs: runs.sought[:, 0], DISTANCE.failed)
    if method in RARE:
        function = RARE[method].function
        found = _all_known(function(program.space, evaluate, samples, seed, judge=judge, score=score, **targets))
    else:
        most = samples * DRAWS_A_RUN if condition == JOINT else samples
        found = monte_carlo(program.space, evaluate, most, seed, judge=judge, enough=samples, until_width=until_width)
    return replace(found, condition=condition, max_attempts=config.simulation.max_attempts, of=of)


def _partners(program: Program) -> "tuple[tuple[Objective, ...], dict[str, Any]]":
    """Return objectives that measure the distance and the side of each partner, and the targets that read them: each
    partner, and each on each side of the ego, where it is at its closest approach.
    """
    from engine.search.objectives import NO_MEASURES, Objective

    aims: list[Objective] = []
    targets: list[Score] = []
    for pair in range(len(program.actors) - 1):
        distance = len(aims)
        aims += [
            Objective(
                "distance",
                "minus its least distance",
                _column("min_distance", pair, -1.0),
                _collided,
                -1.0,
                "m",
                NO_MEASURES,
            ),
            Objective("side", "the side on which it is then", _column("side", pair), _collided, reads=NO_MEASURES),
        ]
        targets += [_target(distance, side) for side in (None, *Side)]
    return tuple(aims), {"targets": targets}


def _column(name: str, pair: int, sign: float = 1.0) -> "Callable[[Runs], Floats]":
    return lambda runs: sign * getattr(runs.outcomes, name)[:, pair]


def _collided(runs: "Runs", _values: Floats) -> Bools:
    return np.asarray(runs.outcomes.collided, dtype=bool)


def _target(distance: int, side: Side | None) -> Score:
    """Return the score of collisions with one partner, on one side of the ego or on any."""

    def nearness(runs: Assessment) -> Floats:
        return np.where(is_there(runs), runs.sought[:, distance], -np.inf)

    def failed(runs: Assessment) -> Bools:
        return is_there(runs) & runs.collided & (runs.sought[:, distance] >= 0.0)

    def is_there(runs: Assessment) -> Bools:
        return np.ones(len(runs), dtype=bool) if side is None else runs.sought[:, distance + 1] == side

    return replace(DISTANCE, nearness=nearness, failed=failed)


def _recorded(config: Config) -> tuple[Config, ...]:
    """Return the settings that evaluate runs, and first those that assess their collisions.

    A driver that decides differently the second time is assessed by its recorded decisions, if they are stored.
    """
    if config.driver is None or not config.driver.can_drive_new_scenes:
        return (config,)
    from engine.driving.decisions import Recorder
    from engine.search.past import recorded_driver

    recorder = Recorder(config.driver)
    return replace(config, driver=recorder), replace(config, driver=recorded_driver(recorder, recorder.recorded))


def _all_known(found: Probability) -> Probability:
    """Return the estimate, without a value if a driver failed: such outcomes are unknown and no chain visits them."""
    if not found.lost or found.withheld == Withheld.INVALID:
        return found
    none = replace(found, value=math.nan, avoidable=math.nan, withheld=Withheld.LOST)
    return replace(none, interval=NOT_KNOWN, avoidable_interval=NOT_KNOWN)


def _of_event(evaluate: Evaluate) -> Evaluate:
    """Return an evaluator that reports a find as a collision."""

    def of_event(genomes: Floats, keys: Ints) -> Assessment:
        runs = evaluate(genomes, keys)
        return replace(runs, collided=runs.found)

    return of_event


def make_judge(program: Program, *configs: Config) -> Judge:
    """Return a function that tells whether all reference drivers of the config avoid the collisions of scenes of this
    program; a scene is driven by the first of the settings whose driver can drive it.
    """
    from engine.avoidability import refuse_missing
    from engine.driving.blocks import can_be_driven, redriven
    from engine.sampling import sample
    from engine.verdicts import blame

    def judge(genomes: Floats, keys: Ints) -> Bools:
        avoidable, left = np.zeros(len(keys), dtype=bool), np.arange(len(keys))
        for config in configs:
            there = can_be_driven(config.driver, keys[left], genomes[left])
            rows, left = left[there], left[~there]
            avoidable[rows] = judged(config, genomes[rows], keys[rows])
        return avoidable

    def judged(config: Config, genomes: Floats, keys: Ints) -> Bools:
        scenes = redriven(program, sample(program, genomes, keys, config.simulation), config)
        references, jobs = config.search.references, config.search.jobs
        said = blame(program, scenes, config.simulation, config.contact, jobs, references)
        if config.driver is None:
            refuse_missing(np.ones(len(said), dtype=bool), said != Blame.NONE)
        return said == Blame.AVOIDABLE

    return judge


def monte_carlo(
    space: ParamSpace,
    evaluate: Evaluate,
    samples: int,
    seed: int = 0,
    level: float = 0.95,
    judge: Judge | None = None,
    enough: int | None = None,
    until_width: float = 0.0,
) -> Probability:
    """Estimate by plain Monte Carlo with at most `samples` draws, or until `enough` draws gave valid runs, or until the
    confidence sequence is at most `until_width` wide; then it is the interval.
    """
    from engine.sampling import draw_genomes

    count, driven, block = Count(), _Driven(), LOOK if until_width else BLOCK
    kinds: list[Ints] = []
    for start in range(0, samples, block):
        keys = key_rows(seed, int(Method.SAMPLE), 0, 0, range(start, min(samples, start + block)))
        genomes = draw_genomes(space, keys)
        runs = evaluate(genomes, keys)
        valid = np.flatnonzero(runs.verdict == Verdict.VALID)
        left = len(valid) if enough is None else enough - count.valid
        if 0 < left < len(valid):
            keep = int(valid[left])
            genomes, keys, runs = genomes[:keep], keys[:keep], take(runs, slice(0, keep))
        count = count.more(runs)
        driven = driven.more(genomes, keys, runs, judge)
        kinds.append(codes_of_draws(runs, runs.collided))
        sequence = sequence_interval(count.collisions, count.valid, level, count.lost)
        if count.valid == enough or sequence.high - sequence.low <= until_width:
            break
    interval = sequence_interval if until_width else clopper_pearson
    return Probability(
        method="mc",
        value=count.collisions / count.valid if count.valid else math.nan,
        interval=interval(count.collisions, count.valid, level, count.lost),
        sequence=sequence_interval(count.collisions, count.valid, level, count.lost),
        unseen=_unseen(kinds, level, count.lost, bounded=not until_width),
        until_width=until_width,
        level=level,
        simulations=count.simulations,
        valid=count.valid,
        collisions=count.collisions,
        valid_share=(count.valid + count.lost) / count.simulations,
        aborted=count.aborted,
        errors=count.errors,
        lost=count.lost,
        avoidable=driven.avoidable / driven.valid if driven.valid else math.nan,
        avoidable_interval=interval(driven.avoidable, driven.valid, level, driven.lost),
        driven=driven.collisions,
        by_partner=count.by_partner,
        without_ego=count.without_ego,
    )


def _unseen(kinds: Sequence[Ints], level: float, lost: int, *, bounded: bool) -> Unseen:
    found = unseen_kinds(labels(np.concatenate(kinds)), level, lost) if kinds else NOTHING_DRAWN
    return found if bounded else replace(found, bound=math.nan)


class _Driven(NamedTuple):
    """Counts of the first blocks of independent runs: valid, lost, with a collision, and avoidable."""

    valid: int = 0
    lost: int = 0
    collisions: int = 0
    avoidable: int = 0
    full: bool = False
    """True if enough collisions were driven again."""

    def more(self, genomes: Floats, keys: Ints, runs: Assessment, judge: Judge | None) -> "_Driven":
        rows = np.flatnonzero(runs.collided)
        if judge is None or self.full or self.collisions + len(rows) > MOST_DRIVEN:
            return self._replace(full=True)
        avoidable = int(judge(genomes[rows], keys[rows]).sum()) if len(rows) else 0
        valid, lost = (int((runs.verdict == verdict).sum()) for verdict in (Verdict.VALID, Verdict.CONTROLLER))
        return _Driven(self.valid + valid, self.lost + lost, self.collisions + len(rows), self.avoidable + avoidable)

"""Do conditions of failures hold what they claim? `python -m benchmarks.conditions [--runs 5]`

Searches on each example; for every condition that is told, the share of further fresh draws under it that fail, held
against the 95 % interval that was told. At least nine of ten must hold it. Exit code 1 if they do not.
"""

import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace

from benchmarks.campaigns import parser, plan_of
from engine.risk import PROFILES
from engine.search.evaluator import make_evaluator
from engine.search.insight.clusters import Cluster, FreshDraws, clusters, rate
from engine.search.run import search
from engine.study.plan import Plan, Subject

METHODS = ("ga", "random", "niching")
JUDGES, FURTHER = 10_000, 7
"""Draws that stand for the truth, and their part of the stream."""
ASKED_FOR = 0.9


def main(arguments: Sequence[str] | None = None) -> int:
    options = parser(__doc__, runs=5, keeps=False).parse_args(arguments)
    plan = plan_of(options, ("random",))
    told = held = 0
    print("| scenario | conditions told | of groups | held by their interval | lift, least to greatest |")
    print("|---|---|---|---|---|")
    for subject in plan.subjects:
        rows = list(_judged(plan, subject))
        kept = [(cluster, truth) for cluster, truth in rows if cluster.conditions]
        good = sum(cluster.fresh.interval.low <= truth <= cluster.fresh.interval.high for cluster, truth in kept)
        lifts = sorted(cluster.lift for cluster, _ in kept)
        span = f"{lifts[0]:.1f} to {lifts[-1]:.1f}" if lifts else ""
        print(f"| {subject.name} | {len(kept)} | {len(rows)} | {good} | {span} |", flush=True)
        told, held = told + len(kept), held + good
    print(f"\n{held} of {told} intervals hold the share of {JUDGES:,} further draws")
    return 0 if held >= ASKED_FOR * told else 1


def _judged(plan: Plan, subject: Subject) -> Iterator[tuple[Cluster, float]]:
    """Every group of failures of every search, with the share of further draws under its condition that fail."""
    program = subject.program
    for method in METHODS:
        for run in range(plan.runs):
            config = replace(subject.config, search=replace(subject.config.search, run=run, probes=0))
            evaluate = make_evaluator(program, config, PROFILES[plan.profile])
            found = search(program, method, config).evaluations
            for cluster in clusters(found, program.space, evaluate, config.search.seed + run):
                fresh = FreshDraws(program.space, evaluate, config.search.seed + run)
                yield cluster, rate(fresh.draws(FURTHER, JUDGES, cluster.conditions)[1]).share


if __name__ == "__main__":
    sys.exit(main())

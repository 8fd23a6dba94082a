"""The cases of a run by number: those of its folder `worst` first, then all others, worst first."""

from dataclasses import replace

from engine.search.journal_reader import Record
from engine.search.protocol import Box
from engine.search.ranking import Case, order_of_risk, worst_cases
from engine.vocabulary import GeneKind

WORST = 10
"""Cases of which the run's folder has a scenario each; no two of them are nearly the same."""


def every_case(record: Record) -> tuple[Case, ...]:
    """Every genome with a valid simulation. Number 7 is `worst/07.scn`; from 11 on it is what is left."""
    evaluations = record.evaluations
    first = worst_cases(evaluations, WORST, box_of(record))
    taken = {case.row for case in first}
    rest = [c for c in worst_cases(evaluations, len(order_of_risk(evaluations))) if c.row not in taken]
    return (*first, *(replace(case, rank=rank) for rank, case in enumerate(rest, start=len(first) + 1)))


def first_cases(record: Record, count: int) -> tuple[Case, ...]:
    """The first `count` of them."""
    return every_case(record)[:count]


def box_of(record: Record) -> Box:
    """The space that a run searched."""
    rows = record.manifest.parameters
    return Box(
        tuple(p.name for p in rows),
        tuple(p.low for p in rows),
        tuple(p.high for p in rows),
        tuple(GeneKind(p.kind) for p in rows),
    )

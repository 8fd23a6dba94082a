"""Cases to look at: the worst of a run, each unlike all that come before it."""

from collections.abc import Sequence

import numpy as np

from engine.search.journal_reader import Record
from engine.search.manifest import Parameter
from engine.search.ranking import Case, order_of_risk, worst_cases
from engine.tables import Floats
from engine.vocabulary import GeneKind

SHARE = 0.1
"""Of a param's range: values nearer than this are alike."""
PART = 3
"""One in so many params must differ."""


def unlike_cases(record: Record, count: int) -> tuple[Case, ...]:
    """Up to `count` cases, worst first, that differ from one another in at least a third of their params. Their ranks
    are those among all cases of the run.
    """
    every = every_case(record)
    genomes = np.array([case.genome for case in every]).reshape(len(every), -1)
    chosen: list[int] = []
    for row in range(len(every)):
        if len(chosen) == count:
            break
        if not chosen or _unlike(record.manifest.parameters, genomes[row], genomes[chosen]):
            chosen.append(row)
    return tuple(every[row] for row in chosen)


def every_case(record: Record) -> tuple[Case, ...]:
    """All different genomes that are valid, worst first: rank 1 is the worst."""
    return worst_cases(record.evaluations, len(order_of_risk(record.evaluations)))


def _unlike(parameters: Sequence[Parameter], genome: Floats, others: Floats) -> bool:
    if not parameters:
        return False
    width = np.array([p.high - p.low for p in parameters])
    apart = np.abs(others - genome)
    index = np.array([p.kind == GeneKind.INDEX for p in parameters])
    differs = np.where(index, apart > 0.0, apart > SHARE * np.where(width > 0.0, width, np.inf))
    return bool((differs.sum(axis=1) >= -(-len(parameters) // PART)).all())

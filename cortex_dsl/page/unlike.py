"""Cases to look at: the worst of a run, each unlike all that come before it."""

import numpy as np

from engine.search.diversity import first_apart
from engine.search.journal_reader import Record
from engine.search.protocol import Box
from engine.search.ranking import Case, order_of_risk, worst_cases
from engine.vocabulary import GeneKind


def unlike_cases(record: Record, count: int) -> tuple[Case, ...]:
    """Up to `count` cases, worst first, that differ from one another by the rule of `engine.search.diversity`. Their
    ranks are those among all cases of the run.
    """
    every = every_case(record)
    genomes = np.array([case.genome for case in every], dtype=np.float64).reshape(len(every), -1)
    return tuple(every[row] for row in first_apart(genomes, box_of(record), most=count).tolist())


def every_case(record: Record) -> tuple[Case, ...]:
    """All different genomes that are valid, worst first: rank 1 is the worst."""
    return worst_cases(record.evaluations, len(order_of_risk(record.evaluations)))


def box_of(record: Record) -> Box:
    """The space that a run searched."""
    rows = record.manifest.parameters
    return Box(
        tuple(p.name for p in rows),
        tuple(p.low for p in rows),
        tuple(p.high for p in rows),
        tuple(GeneKind(p.kind) for p in rows),
    )

"""Every finding of this stage, declared once: a module for each family, each of its rows a name."""

from cortex_dsl.semantics.errors import (
    behaviours,
    chance,
    compile_time,
    names,
    objectives,
    objects,
    quantities,
    roads,
    scenarios,
    statements,
    values,
)
from cortex_dsl.semantics.errors.problems import Problem

FAMILIES = (
    names,
    values,
    quantities,
    statements,
    objects,
    roads,
    chance,
    compile_time,
    behaviours,
    scenarios,
    objectives,
)


def declared() -> dict[str, Problem]:
    """All problems by the name of their row."""
    return {name: row for family in FAMILIES for name, row in vars(family).items() if isinstance(row, Problem)}

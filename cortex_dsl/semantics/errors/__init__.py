"""Every diagnostic of this stage, declared once as a row; `cortex_dsl/codes` holds the page of its code."""

from cortex_dsl.semantics.errors import names, runs, scene, values
from cortex_dsl.semantics.errors.problems import Problem

FAMILIES = (names, values, scene, runs)


def declared() -> dict[str, Problem]:
    """Return all problems by the name of their row."""
    return {name: row for family in FAMILIES for name, row in vars(family).items() if isinstance(row, Problem)}

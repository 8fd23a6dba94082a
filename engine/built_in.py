"""Restriction of a program's built-in requirements to some of its actors."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from engine.program import Program
from engine.tables import Ints


def checking(program: Program, road: Sequence[int], overlap: Sequence[int]) -> Program:
    """Return the program with built-in requirements for these actors only: on the road, and not overlapping."""
    code = program.code._replace(
        road_check=_only(program.code.road_check, road), overlap_check=_only(program.code.overlap_check, overlap)
    )
    return replace(program, code=code)


def _only(flags: Ints, kept: Sequence[int]) -> Ints:
    limited = np.zeros_like(flags)
    limited[list(kept)] = flags[list(kept)]
    return limited

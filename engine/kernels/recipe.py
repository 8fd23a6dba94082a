"""What sampling reads and what it writes; made by `engine.sampling`.

The registers of an attempt: literals | variant values | genes (SI) | uniform draws | temporaries. Literals are written
once a thread, genes once a scene, the rest every attempt.
"""

from typing import NamedTuple

import numpy as np

from engine.kernels.philox import Stream
from engine.tables import CodeTables, Floats, Ints, RoadTables


class Layout(NamedTuple):
    """Where things lie in a register file, and counts that kernels need."""

    variant_values: int
    genes: int
    draws: int
    draw_count: int
    blocks: int
    """Blocks of random numbers that one attempt owns."""
    requirements: int
    """The file's own requirements; rejections and the two built-in ones follow."""
    reasons: int
    """The file's own and the variant rejections: index of the first built-in."""


class Recipe(NamedTuple):
    """Everything about a program that an attempt reads."""

    code: CodeTables
    road: RoadTables
    draws_needed: Ints
    """(templates, requirements): how many draws must be made before a requirement is tested."""
    by_genes: Ints
    """(requirements,): 1 where the genome alone decides: what fails once fails in every attempt."""
    layout: Layout


class Confinement(NamedTuple):
    """Where a row's attempts may pass at all (see `engine.feasibility.pruning`). Without rows: anywhere."""

    mass: Floats
    """(n,) probability that an attempt falls there."""
    cumulative: Floats
    """(n, options) of the variants of the row's group."""
    low: Floats
    """(n, options, draws)"""
    span: Floats
    """(n, options, draws)"""
    culprit: Ints
    """(n,) the requirement that fails in every attempt of a row without mass."""


class Request(NamedTuple):
    """What to sample, row by row."""

    genes: Floats
    """(n, d) SI"""
    group: Ints
    """(n,): group of variants that the discrete genes pick."""
    keys: Ints
    """(n, 6) int64 `StreamKey` rows."""
    max_attempts: int
    confinement: Confinement


class Ledger(NamedTuple):
    """Where results go; the arrays of `engine.scenes.Scenes` under their names there."""

    verdict: Ints
    variant: Ints
    values: Floats
    draws: Floats
    attempts: Ints
    tested: Ints
    failed: Ints


class Draws(NamedTuple):
    """The random numbers of one attempt."""

    stream: Stream
    block: np.uint64
    """The attempt's first block."""
    first: float
    """Draw 0, which came with the number that picked the variant."""


class Scratch(NamedTuple):
    """Working memory of one thread."""

    registers: Floats
    enforced: Ints
    """(requirements,): 0 where the coin of a soft requirement spares this scene."""

"""The scene of a single run: genomes of a seed, one after the other, until one of them allows a scene."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from engine.config import SimulationConfig
from engine.program import Program
from engine.vocabulary import Method, Verdict

if TYPE_CHECKING:
    from engine.scenes import Scenes
    from engine.tables import Ints

DRAWS = 100
"""How many genomes a single run draws until one allows a scene; Scenic, too, draws its params anew at every attempt."""


def attempts(program: Program, config: SimulationConfig, seed: int | None) -> "Iterator[Scenes]":
    """One scene after another, each of a genome of its own; the last one is the scene of the seed, if it is valid.

    Without a seed: of the stream that a concrete file names, or else of seed 0.
    """
    from engine.sampling import draw_genomes, sample

    for key in _keys(program, seed):
        scenes = sample(program, draw_genomes(program.space, key), key, config)
        yield scenes
        if scenes.verdict[0] not in (Verdict.EXHAUSTED, Verdict.INFEASIBLE):
            return


def _keys(program: Program, seed: int | None) -> "Iterator[Ints]":
    """The streams to try; a concrete file has just its own."""
    from engine.streams import key_rows, parse_key

    pinned = program.settings.stream
    if pinned is not None and seed is None:
        yield np.array([parse_key(pinned)], dtype=np.int64)
        return
    for index in range(DRAWS if len(program.space) else 1):
        yield key_rows(seed or 0, Method.SINGLE, 0, 0, [index])

"""Concrete copies: what elaboration records is enough to write a file that gives the same scene, bit for bit."""

from pathlib import Path

import numpy as np
import pytest

from cortex_dsl.api.concrete import Original, concrete_files
from cortex_dsl.pipeline import compile_source
from cortex_dsl.source import Source
from engine.config import SimulationConfig
from engine.sampling import draw_genomes, sample
from engine.streams import key_rows
from engine.vocabulary import Column, Method

GOOD = sorted((Path(__file__).parent / "golden" / "good").glob("*.scn"))
SCENES = 6


@pytest.mark.parametrize("path", GOOD, ids=lambda path: path.stem)
def test_copy_gives_the_same_actors(path: Path) -> None:
    """Every valid scene, written out and compiled again, has one variant, no genes and equal columns."""
    compiled = compile_source(Source(path.name, path.read_text()))
    program = compiled.program
    keys = key_rows(7, Method.SAMPLE, 0, 0, np.arange(SCENES), 0)
    scenes = sample(program, draw_genomes(program.space, keys), keys, SimulationConfig())
    columns = len(Column) * len(program.actors)
    original = Original(program, compiled.module, SimulationConfig())
    assert scenes.valid.any()
    for row in np.flatnonzero(scenes.valid):
        (text,) = concrete_files(original, scenes, int(row)).values()
        copy = compile_source(Source("copy.scn", text)).program
        again = sample(copy, np.zeros((1, 0)), keys[row : row + 1], SimulationConfig())
        assert (len(copy.variants), len(copy.space)) == (1, 0)
        np.testing.assert_array_equal(again.values[0, :columns], scenes.values[row, :columns])

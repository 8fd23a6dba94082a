"""Descriptor grids, QD score, and spread."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from engine.assessment import map_arrays
from engine.outcomes import Assessment
from engine.search.evaluations import Evaluations
from engine.search.insight.diversity import (
    SECTORS,
    grids,
    sector,
    spread,
)
from engine.search.protocol import Box
from engine.tables import Floats, Ints
from engine.vocabulary import GeneKind, Side
from tests.engine.search.conftest import evaluated

UNIT_BOX = Box(("A", "B", "C"), (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), (GeneKind.CONTINUOUS,) * 3)
Table = Callable[..., Evaluations]


@pytest.fixture
def searched(rows: Callable[[Ints, Floats], Assessment]) -> Table:
    """Valid individuals with these genomes and least distances (below 1 m: a collision), and changes to their runs."""

    def make(genomes: Floats, distance: Floats | None = None, **changes: object) -> Evaluations:
        count = len(genomes)
        flat = rows(np.zeros(count, dtype=np.int32), np.full(count, 0.5) if distance is None else distance)
        return evaluated(genomes, map_arrays(replace(flat, **changes), lambda array: array[:, np.newaxis]))

    return make


def test_sectors_are_centred_on_directions() -> None:
    """Head-on is one sector, whichever sign rounding gave it; a mirror exchanges left and right."""
    names = [SECTORS[i] for i in sector(np.array([0.1, -0.1, math.pi, -math.pi, math.pi / 2, -math.pi / 4]))]
    assert names == ["same way", "same way", "head-on", "head-on", "90° left", "45° right"]
    angles = np.linspace(-3.0, 3.0, 61) + 0.001
    swapped = [0, 7, 6, 5, 4, 3, 2, 1]
    assert sector(-angles).tolist() == [swapped[i] for i in sector(angles).tolist()]


def test_grids_count_cells_and_quality(searched: Table) -> None:
    """Four runs: two in one cell, one elsewhere, and one that met nobody and is in no cell."""
    found = searched(
        np.arange(4.0)[:, np.newaxis],
        np.array([0.5, 3.0, 0.25, 4.0]),
        ego_speed=np.array([10.0, 10.5, 0.0, np.nan]),
        other_speed=np.array([1.0, 0.5, 40.0, np.nan]),
        closing_speed=np.array([-1.0, 8.0, 100.0, np.nan]),
        approach_angle=np.array([0.0, math.pi, -math.pi, np.nan]),
        side=np.array([Side.LEFT, Side.LEFT, Side.REAR, -1]),
        variant=np.array([0, 1, 2, 0]),
    )
    speeds, angles, sides = grids(found, ["north", "south", "north"])
    assert speeds.runs[3, 0] == 2
    assert speeds.failures[3, 0] == 1
    assert speeds.runs[0, 9] == speeds.failures[0, 9] == 1
    assert (speeds.covered, speeds.failing, speeds.cells) == (2, 2, 100)
    risk = found.rollouts.continuous[:, 0]
    assert speeds.qd_score == pytest.approx(max(risk[0], risk[1]) + risk[2])
    assert angles.second[0] == "< 0"
    assert angles.runs[0, 0] == angles.runs[4, 2] == angles.runs[4, 8] == 1
    assert sides.second == ("north", "south")
    assert sides.runs.tolist() == [[0, 0], [1, 1], [1, 0], [0, 0]]


def test_qd_score_grows_with_what_is_found(searched: Table) -> None:
    """A further simulation never lowers it, a copy never raises it."""
    found = searched(np.zeros((6, 1)), np.linspace(0.1, 4.0, 6), ego_speed=np.linspace(0, 20, 6))
    scores = [grids(searched_part(found, count))[0].qd_score for count in range(1, 7)]
    assert scores == sorted(scores)
    assert grids(searched_part(found, [0, 0, 1]))[0].qd_score == grids(searched_part(found, 2))[0].qd_score


def searched_part(found: Evaluations, rows: int | list[int]) -> Evaluations:
    from engine.assessment import take

    return take(found, np.arange(rows) if isinstance(rows, int) else np.array(rows))


def test_spread_of_corners(searched: Table) -> None:
    """Two opposite corners and the middle between: 1, 0.5 and 0.5 apart."""
    found = searched(np.array([[0.0] * 3, [1.0] * 3, [0.5] * 3, [0.5] * 3]))
    assert spread(found, UNIT_BOX).nearest == pytest.approx(0.5)
    assert spread(found, UNIT_BOX).pairwise == pytest.approx(2.0 / 3.0)
    assert math.isnan(spread(searched(np.zeros((3, 3))), UNIT_BOX).nearest)


def test_spread_is_of_all_failures(searched: Table) -> None:
    """Word by word, with an option among the genes; and of more than are convenient to put in a table."""
    box = Box(("A", "B", "C"), (0.0, -5.0, 0.0), (2.0, 5.0, 3.0), (*(GeneKind.CONTINUOUS,) * 2, GeneKind.INDEX))
    stream = np.random.default_rng(4)
    columns = stream.random(1500) * 2.0, stream.random(1500) * 10.0 - 5.0, stream.integers(0, 4, 1500)
    genomes = np.stack(columns, axis=1).astype(float)
    units = genomes[:, :2] / [2.0, 10.0]
    table = np.abs(units[:, None] - units[None]).sum(axis=2) + (genomes[:, None, 2] != genomes[None, :, 2])
    np.fill_diagonal(table, np.nan)
    found = spread(searched(genomes), box)
    assert found.count == 1500
    assert found.nearest == pytest.approx(np.nanmin(table, axis=1).mean() / 3.0)
    assert found.pairwise == pytest.approx(np.nanmean(table) / 3.0)


def test_the_nearest_falls_with_the_count_alone(searched: Table) -> None:
    """Of the same law, more failures lie nearer: it compares searches at equal counts only."""
    genomes = np.random.default_rng(5).random((1200, 3))
    few, many = (spread(searched(genomes[:count]), UNIT_BOX) for count in (300, 1200))
    assert many.nearest < 0.8 * few.nearest
    assert many.pairwise == pytest.approx(few.pairwise, rel=0.05)

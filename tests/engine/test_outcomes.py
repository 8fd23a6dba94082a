"""The table of results: its rows are whole, and what is made from it has them all."""

import pickle
from dataclasses import fields

import numpy as np

from engine.assessment import SCALARS
from engine.kernels.pair import NOT_OF_MOTION, PLACES, PairMetrics
from engine.kernels.rows import Results
from engine.outcomes import MEASURED, OUTCOMES, PAIRS, RESULTS, Outcomes, Per, blank_outcomes


def test_rows_name_what_there_is() -> None:
    """Names are unique; rows that others refer to exist; a row that has a unit names it."""
    names = [row.name for row in (*RESULTS, *OUTCOMES)]
    assert {row.name for row in MEASURED} <= {row.name for row in OUTCOMES} & {row.name for row in RESULTS}
    assert len({row.name for row in OUTCOMES}) == len(OUTCOMES)
    assert len({row.name for row in RESULTS}) == len(RESULTS)
    for row in (*RESULTS, *OUTCOMES):
        assert not row.when or row.when in names
        assert not row.part_of or row.part_of in names
        assert not row.unit or not row.sentence or f"[{row.unit}]" in row.sentence
        assert bool(row.symbol) == bool(row.meaning)


NOT_ROWS = ("sought", "broken", "gaps")
"""Arrays without a row: the objectives of a file, and conflict gaps where they are requested."""


def test_kernels_outcomes_and_columns_follow_it() -> None:
    """No list beside the table."""
    names = [row.name for row in PAIRS]
    assert tuple(names[place] for place in PLACES) == PairMetrics._fields
    assert {*PairMetrics._fields, *NOT_OF_MOTION} == set(names)
    assert {*Results._fields, *names} == {*(row.name for row in OUTCOMES), "pairs", *NOT_ROWS}
    assert [field.name for field in fields(Outcomes)] == [*(row.name for row in OUTCOMES), *NOT_ROWS]
    assert sorted(SCALARS) == sorted(name for row in RESULTS for name in row.columns)


def test_blank_outcomes_are_those_of_invalid_scenes() -> None:
    """NaN, -1 and False, in the shapes of the table; what is known is there."""
    outcomes = blank_outcomes(2, 3, end_time=np.array([1.0, 2.0]))
    assert outcomes.end_time.tolist() == [1.0, 2.0]
    assert outcomes.min_distance.shape == outcomes.side.shape == (2, 2)
    assert outcomes.left_road_time.shape == (2, 3)
    assert np.isnan(outcomes.min_distance).all()
    assert (outcomes.side == -1).all()
    assert not outcomes.collided.any()
    for row in OUTCOMES:
        assert getattr(outcomes, row.name).dtype == np.dtype(row.dtype) or row.name == "end_time"


def test_enumerations_have_words() -> None:
    """Of numbers there are none; of nothing the empty one."""
    words = {row.name: row.words for row in OUTCOMES if row.words is not None}
    assert sorted(words) == ["end_reason", "fault", "side", "verdict"]
    assert words["side"] == {-1: "", 0: "front", 1: "left", 2: "rear", 3: "right"}


def test_outcomes_travel_between_processes() -> None:
    """By pickle, as all that workers give back."""
    outcomes = blank_outcomes(1, 2)
    again = pickle.loads(pickle.dumps(outcomes))
    assert all(np.array_equal(getattr(again, row.name), getattr(outcomes, row.name), equal_nan=True) for row in PAIRS)
    assert sum(row.per is Per.PAIR for row in OUTCOMES) == len(PAIRS)

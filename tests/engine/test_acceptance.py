"""Who is to blame: counts over attempts of which every requirement is tested."""

import time

import numpy as np
import pytest

from cortex_dsl import compile_text, load
from engine.acceptance import account, blames, measure_acceptance, relaxations, smallest_conflict
from engine.config import SimulationConfig
from engine.program import Program
from engine.sampling import sample
from engine.streams import key_rows
from engine.vocabulary import Method

TEXT = """
map intersection(ways=4, lanes=1)
param A = Range(0, 10) m
param B = Range(0, 10) m
param S = Range(0, 9) m/s
ego = new Car on road
"""


def program(*requirements: str) -> Program:
    return compile_text(TEXT + "".join(f"require {text}\n" for text in requirements)).program


def test_an_attempt_is_judged_as_the_sampler_judges_it() -> None:
    """Accepted and first failure are those of single attempts under the same keys."""
    for compiled in (load("examples/left_turn.scn").program, program("A > 3 m", "A < B", "ego in intersection")):
        weighing = measure_acceptance(compiled, 3000, seed=4)
        keys = key_rows(4, Method.SAMPLE, 0, 0, range(3000))
        scenes = sample(compiled, weighing.genomes, keys, SimulationConfig(max_attempts=1))
        np.testing.assert_array_equal(weighing.accepted, scenes.valid)
        found = blames(weighing)
        np.testing.assert_array_equal([b.tested for b in found], scenes.tested.sum(axis=0))
        np.testing.assert_array_equal([b.failed for b in found], scenes.failed.sum(axis=0))


@pytest.mark.parametrize(
    "condition",
    [
        "A < B",
        "A >= B",
        "abs(A - B) <= 2 m",
        "A < 3 m or B < 3 m",
        "2 m < A <= B",
        "not (A > 4 m and B > 4 m)",
        "A != B",
    ],
)
def test_a_margin_is_positive_exactly_where_the_requirement_holds(condition: str) -> None:
    """Whatever it is made of."""
    weighing = measure_acceptance(program(condition), 2000)
    margin, holds = weighing.margins[:, 0], weighing.holds[:, 0]
    assert (margin[holds] >= 0).all()
    assert (margin[~holds] <= 0).all()
    assert weighing.program.requirements[0].unit == "m"


@pytest.mark.parametrize("condition", ["ego in road", "A < 3 m and S < 3 m/s", "ego can see (A, B)"])
def test_no_margin_where_there_is_none(condition: str) -> None:
    """A bare truth, and metres joined with metres a second."""
    assert np.isnan(measure_acceptance(program(condition), 50).margins[:, 0]).all()


def test_shares() -> None:
    """Alone, given the earlier ones, and without it."""
    weighing = measure_acceptance(program("A < 5 m", "A < 2.5 m"), 20_000)
    one, other, *_ = blames(weighing)
    assert one.alone == pytest.approx(0.5, abs=0.02)
    assert other.alone == pytest.approx(0.25, abs=0.02)
    assert other.given_earlier == pytest.approx(0.5, abs=0.02)
    assert one.without == weighing.acceptance < other.without
    assert one.only == 0


def test_the_nearest_miss_is_the_attempt_that_lacked_least() -> None:
    """Among those in which the fewest others fail, the one with the best margin."""
    weighing = measure_acceptance(program("A > 9.999999 m", "B > 5 m"), 2000)
    blame = blames(weighing)[0]
    fewest = (~weighing.holds).sum(axis=1) == 1
    assert blame.others == 0
    assert weighing.genomes[blame.nearest, 0] == weighing.genomes[fewest, 0].max()


def test_relaxing_by_the_amount_reaches_the_target() -> None:
    """Put into the file, the amount gives the acceptance that was promised."""
    weighing = measure_acceptance(program("A < 1 m", "B < 8 m"), 20_000)
    (found, *rest) = relaxations(weighing, 0.4)
    assert found.requirement == 0
    assert [r for r in rest if r.requirement == 1] == []
    mended = measure_acceptance(program(f"A < {1 + found.amount} m", "B < 8 m"), 20_000)
    assert mended.acceptance == pytest.approx(0.4, abs=0.005)
    assert found.acceptance == pytest.approx(mended.acceptance, abs=1e-4)
    assert relaxations(weighing, 0.05) == ()


def test_a_smallest_conflict_is_found_and_proved() -> None:
    """Two of four cannot hold together, and intervals prove it."""
    conflict = smallest_conflict(measure_acceptance(program("B < 9 m", "A > 7 m", "B > 1 m", "A * 2 < 10 m"), 2000))
    assert conflict is not None
    assert conflict.requirements == (1, 3)
    assert conflict.proved


def test_a_conflict_that_intervals_cannot_prove_is_only_seen() -> None:
    """Rare is not never."""
    conflict = smallest_conflict(measure_acceptance(program("A > 9.9999999 m", "B > 5 m"), 500))
    assert conflict is not None
    assert conflict.requirements == (0,)
    assert not conflict.proved


def test_no_conflict_where_something_passes() -> None:
    """And nothing to relax where half pass."""
    found = account(measure_acceptance(program("A < 8 m"), 1000))
    assert found.conflict is None
    assert found.target is None


def test_a_soft_requirement_spares_some() -> None:
    """Its coin is tossed as for a scene."""
    (soft, *_) = blames(measure_acceptance(compile_text(TEXT + "require[0.5] A > 20 m\n").program, 20_000))
    assert soft.alone == pytest.approx(0.5, abs=0.02)


def test_ten_thousand_attempts_take_no_time() -> None:
    """Well under 0.3 s, once the kernels are loaded."""
    compiled = load("examples/left_turn.scn").program
    measure_acceptance(compiled, 10)
    start = time.process_time()
    account(measure_acceptance(compiled))
    assert time.process_time() - start < 0.3


def test_who_leaves_the_road_is_counted_for_each_object() -> None:
    """On a straight road of known width: shares are those of outlines that reach beyond its edge."""
    text = (
        "map road(lanes=2, length=400 m, lane_width=3.5 m)\nspot = new OrientedPoint in network.lanes[0].centerline\n"
        "ego = new Car at spot, with regionContainedIn None\nnew Bus right of spot by Range(-6, 2) m\n"
        "new Car left of spot by Range(0, 1) m\n"
    )
    compiled = compile_text(text).program
    weighing = measure_acceptance(compiled, 2000)
    off, road = {each.actor: each.share for each in weighing.off_road}, compiled.first_built_in
    assert 0 not in off  # it may stand anywhere
    rejected = ~weighing.holds.all(axis=1)
    left = float((~weighing.holds[rejected, road]).mean())
    assert max(off.values()) <= left <= sum(off.values()) + 1e-9
    everywhere = text.replace("new Bus right of spot by Range(-6, 2) m", "new Bus right of spot by 2 m")
    first = measure_acceptance(compile_text(everywhere).program, 500).off_road[0]
    assert (first.actor, first.share) == (1, 1.0)

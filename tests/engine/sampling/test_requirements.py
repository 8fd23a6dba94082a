"""What is tested, in which order, and what is counted."""

import numpy as np
import pytest
from scipy import stats

from cortex_dsl import compile_text
from engine.config import SimulationConfig
from engine.opcodes import Op
from engine.sampling import sample
from engine.streams import key_rows
from engine.vocabulary import Method, Verdict

HERE = [("L0", "L0", "L0")]
"""One car in the middle of the junction."""
MIDDLE = {"literals": (0.0, 0.5)}
BELOW_HALF = ([(Op.LT, "T0", "D0", "L1")], "T0")
ALSO_SECOND = ([(Op.LT, "T1", "D1", "L1")], "T1")


def run(program, scenes=400, attempts=200, genomes=None, jobs=1, seed=1):
    rows = np.empty((scenes, 0)) if genomes is None else np.asarray(genomes, dtype=float)
    keys = key_rows(seed, Method.SAMPLE, 0, 0, range(len(rows)))
    return sample(program, rows, keys, SimulationConfig(max_attempts=attempts), jobs)


def test_counts_are_conditional(assemble):
    """Each requirement is tested where all earlier ones held; every attempt but the last of a valid row fails once."""
    scenes = run(assemble(poses=HERE, draws=2, checks=[BELOW_HALF, ALSO_SECOND], **MIDDLE))
    assert np.array_equal(scenes.tested[:, 0], scenes.attempts)
    assert np.array_equal(scenes.tested[:, 1:], (scenes.tested - scenes.failed)[:, :-1])
    assert np.array_equal(scenes.attempts, scenes.failed.sum(axis=1) + scenes.valid)
    assert scenes.failed[:, 0].sum() / scenes.tested[:, 0].sum() == pytest.approx(0.5, abs=0.05)


def test_a_scene_holds_what_was_required(assemble):
    """Draws of accepted attempts satisfy every requirement."""
    scenes = run(assemble(poses=HERE, draws=2, checks=[BELOW_HALF, ALSO_SECOND], **MIDDLE))
    assert scenes.valid.all()
    assert np.all(scenes.draws < 0.5)


@pytest.mark.parametrize("probability", [0.0, 0.3, 1.0])
def test_coins_are_tossed_once_per_scene(assemble, probability):
    """`require[p]` counts in every attempt of a scene or in none, in a share p of all scenes."""
    program = assemble(poses=HERE, draws=1, checks=[(*BELOW_HALF, probability)], **MIDDLE)
    scenes = run(program, scenes=2000)
    enforced = scenes.tested[:, 0] > 0
    assert np.array_equal(scenes.tested[enforced, 0], scenes.attempts[enforced])
    assert np.all(scenes.attempts[~enforced] == 1)
    assert np.all(scenes.draws[enforced] < 0.5)
    assert stats.binomtest(int(enforced.sum()), 2000, probability).pvalue > 0.001


def test_coins_of_two_requirements_are_independent(assemble):
    """Each soft requirement has a coin of its own."""
    checks = [([], "L1", 0.5), ([], "L1", 0.5)]
    scenes = run(assemble(poses=HERE, checks=checks, **MIDDLE), scenes=2000)
    table = np.histogram2d(scenes.tested[:, 0], scenes.tested[:, 1], bins=2)[0]
    assert stats.chisquare(table.ravel()).pvalue > 0.001


def test_impossible_variants_are_counted_under_their_reasons(assemble):
    """A variant that cannot be fails its pseudo requirement, before any other is tested."""
    program = assemble(
        poses=HERE,
        variants=[(0.0,)] * 4,
        weights=(1, 2, 3, 4),
        impossible={1: 0, 3: 1},
        draws=1,
        checks=[BELOW_HALF],
        **MIDDLE,
    )
    scenes = run(program, scenes=1000)
    assert set(scenes.variant) == {0, 2}
    assert np.array_equal(scenes.tested[:, 1], scenes.attempts)
    assert np.array_equal(scenes.tested[:, 2], scenes.attempts - scenes.failed[:, 1])
    assert np.array_equal(scenes.tested[:, 0], scenes.tested[:, 2] - scenes.failed[:, 2])
    assert np.array_equal(scenes.attempts, scenes.failed.sum(axis=1) + scenes.valid)
    attempts = int(scenes.attempts.sum())
    for reason, share in ((1, 0.2), (2, 0.4)):
        assert stats.binomtest(int(scenes.failed[:, reason].sum()), attempts, share).pvalue > 0.001


def test_outlines_outside_the_road_are_rejected(assemble):
    """The first built-in requirement holds for actors that ask for it."""
    away = {"poses": [("L1", "L1", "L0")], "literals": (0.0, 1000.0)}
    scenes = run(assemble(**away), scenes=3, attempts=20)
    assert np.all(scenes.verdict == Verdict.EXHAUSTED)
    assert np.all(scenes.failed[:, 0] == 20)
    assert np.all(scenes.tested[:, 1] == 0)
    assert run(assemble(**away, road_check=False), scenes=3).valid.all()


def test_overlapping_outlines_are_rejected(assemble):
    """The second built-in requirement holds for pairs that ask for it; cars side by side pass."""
    touching = {"poses": [("L0", "L0", "L0"), ("L0", "L1", "L0")], "literals": (0.0, 1.7)}
    scenes = run(assemble(**touching), scenes=3, attempts=20)
    assert np.all(scenes.verdict == Verdict.EXHAUSTED)
    assert np.all(scenes.failed == [0, 20])
    assert run(assemble(**touching, overlap_check=False), scenes=3).valid.all()
    assert run(assemble(**{**touching, "literals": (0.0, 1.9)}), scenes=3).valid.all()


def test_nan_is_an_error_and_never_a_scene(assemble):
    """A scene value that is NaN ends the row as an error, not as a failed built-in requirement."""
    program = assemble(poses=[("T0", "L0", "L0")], output=[(Op.DIV, "T0", "L0", "L0")], literals=(0.0,))
    scenes = run(program, scenes=3)
    assert np.all(scenes.verdict == Verdict.ERROR)
    assert np.all(scenes.attempts == 1)
    assert scenes.failed.sum() == 0


def test_a_requirement_that_is_nan_is_an_error(assemble):
    """A requirement that is NaN neither holds nor fails."""
    scenes = run(assemble(poses=HERE, checks=[([(Op.DIV, "T0", "L0", "L0")], "T0")], literals=(0.0,)), 2, 10)
    assert np.all(scenes.verdict == Verdict.ERROR)


def test_discrete_genes_pick_the_group(assemble):
    """Each combination of options has its own variants, the first gene most significant; a range may start at 2."""
    program = assemble(
        poses=HERE,
        variants=[(0.0,)] * 9,
        weights=(1, 1, 1, 1, 1, 1, 1, 3, 1),
        genes=[(0, 9, 1.0), (0, 1, 1.0, 2), (2, 4, 1.0, 1)],
        group_genes=(1, 2),
        group_start=(0, 1, 2, 3, 5, 7, 9),
        **MIDDLE,
    )
    options = [(a, b) for a in (0, 1) for b in (2, 3, 4)]
    expected = [{0}, {1}, {2}, {3, 4}, {5, 6}, {7, 8}]
    drawn = [run(program, genomes=[(4.5, first, second)] * 400).variant for first, second in options]
    assert [set(variants) for variants in drawn] == expected
    assert stats.binomtest(int((drawn[-1] == 7).sum()), 400, 0.75).pvalue > 0.001


@pytest.mark.parametrize("count", [1, 2, 16, 17, 40, 257])
def test_variants_come_with_their_probabilities(assemble, count):
    """Few variants and many: shares follow the weights, and a weightless variant never comes."""
    weights = np.arange(count) % 5 + (count < 3)
    program = assemble(poses=HERE, variants=[(0.0,)] * count, weights=tuple(weights), **MIDDLE)
    counts = np.bincount(run(program, scenes=20_000).variant, minlength=count)
    assert counts[weights == 0].sum() == 0
    if count > 1:
        expected = 20_000 * weights[weights > 0] / weights.sum()
        assert stats.chisquare(counts[weights > 0], expected).pvalue > 0.001


def test_variant_values_reach_the_code(assemble):
    """Registers of variant values hold those of the variant drawn."""
    program = assemble(poses=[("V1", "L0", "L0")], variants=[(0.0, 1.0), (0.0, -2.0)], weights=(1, 1), road_check=False)
    scenes = run(program)
    assert np.array_equal(scenes.values[:, 0], np.where(scenes.variant == 0, 1.0, -2.0))


def test_genes_reach_the_code_in_si(assemble):
    """A gene's register holds file value times scale."""
    program = assemble(poses=[("G0", "L0", "L0")], genes=[(0, 90, 1 / 3.6)], road_check=False)
    scenes = run(program, genomes=[[36.0], [72.0]])
    np.testing.assert_allclose(scenes.values[:, 0], [10.0, 20.0], rtol=1e-15)


@pytest.mark.parametrize(
    ("genome", "complaint"),
    [
        ([np.nan, 0.0], "genome 0: GENE_0 is nan; it must be a finite number"),
        ([0.5, 0.5], "genome 0: GENE_1 is 0.5; it must be a whole number in 0 .. 2"),
        ([0.5, 3.0], "GENE_1 is 3.0"),
        ([0.5], r"expected one row of 2 genes a key \(1, 2\), got \(1, 1\)"),
    ],
)
def test_bad_genomes_are_refused(assemble, genome, complaint):
    """The message names the gene, its value and what is allowed."""
    program = assemble(poses=HERE, genes=[(0, 1), (0, 2, 1.0, 1)], **MIDDLE)
    with pytest.raises(ValueError, match=complaint):
        run(program, genomes=[genome])


def test_attempts_beyond_the_address_space_are_refused(assemble):
    """More attempts than a stream has blocks would repeat numbers."""
    program = assemble(poses=HERE, draws=2, **MIDDLE)
    for attempts in (0, (1 << 31) + 1):
        with pytest.raises(ValueError, match=r"this scenario allows 1 \.\. 2147483648"):
            run(program, attempts=attempts)


def test_no_rows_give_no_scenes(assemble):
    """Sampling nothing is no error."""
    assert len(run(assemble(poses=HERE, **MIDDLE), scenes=0)) == 0


def test_what_genes_alone_forbid_is_infeasible_at_once() -> None:
    """A hard requirement that reads no draw fails in every attempt when it fails in one: nothing is tried again."""
    text = """
map intersection()
param SPEED = Range(0, 10) m/s
ego = new Car in intersection.incomingLanes[0].centerline, with speed SPEED
require (distance from ego to intersection) < 49 m
require SPEED > 5 m/s
"""
    program = compile_text(text).program
    keys = key_rows(1, Method.SAMPLE, 0, 0, range(60))
    scenes = sample(program, np.linspace(0.0, 10.0, 60)[:, np.newaxis], keys)
    slow = scenes.genomes[:, 0] <= 5.0
    assert (scenes.verdict[slow] == Verdict.INFEASIBLE).all()
    assert (scenes.failed[slow, 1] == 1).all()
    assert (scenes.variant[slow] == -1).all()
    assert np.isnan(scenes.values[slow]).all()
    assert (scenes.verdict[~slow] == Verdict.VALID).all()


def test_a_requirement_that_a_draw_or_a_choice_may_save_is_never_called_infeasible() -> None:
    """Draws, choices and coins leave the verdict to the attempts."""
    text = """
map intersection()
param SPEED = Range(0, 10) m/s
lane = Uniform(*intersection.incomingLanes)
slip = Normal(0, 1) m/s
limit = Uniform(1, 20) m/s
ego = new Car in lane.centerline, with speed SPEED
require SPEED + slip > 5 m/s
require SPEED < limit
require[0.5] SPEED > 9 m/s
"""
    program = compile_text(text).program
    keys = key_rows(1, Method.SAMPLE, 0, 0, range(60))
    scenes = sample(program, np.linspace(0.0, 10.0, 60)[:, np.newaxis], keys)
    assert (scenes.verdict != Verdict.INFEASIBLE).all()
    assert (scenes.verdict == Verdict.VALID).any()

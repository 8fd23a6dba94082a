"""The law of feasibility: nothing that is proved is ever wrong, and pruning changes no distribution."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl import compile_text, load
from engine.config import SimulationConfig
from engine.feasibility import Feasibility, explain
from engine.feasibility.pruning import infeasible, pruner
from engine.program import Program
from engine.sampling import (
    FREE_ATTEMPTS,
    draw_genomes,
    groups_of,
    sample,
    uniform_genomes,
)
from engine.scenes import Scenes
from engine.streams import key_rows
from engine.vocabulary import Column, Method, Verdict
from tests.laws import examples

EXAMPLES = sorted((Path(__file__).parent.parent / "examples").glob("*.scn"))
SINGLE = SimulationConfig(max_attempts=1)
PRUNED = SimulationConfig(prune=True)


def attempts_at(program: Program, count: int, seed: int = 0, *, uniform: bool = False) -> Scenes:
    """Single attempts; those that pass are whatever can pass."""
    keys = key_rows(seed, Method.SAMPLE, 0, 0, range(count))
    return sample(program, (uniform_genomes if uniform else draw_genomes)(program.space, keys), keys, SINGLE)


def assert_never_wrong(program: Program, scenes: Scenes, found: Feasibility) -> None:
    """Every accepted attempt lies in all that was said to be possible."""
    valid = scenes.valid
    genomes, variants = scenes.genomes[valid], scenes.variant[valid]
    assert not (found.infeasible and valid.any())
    assert (found.impossible[variants] == -1).all()
    assert (genomes >= found.low).all()
    assert (genomes <= found.high).all()
    assert not infeasible(program, genomes)[0].any()
    groups = groups_of(program, genomes)
    bounds = pruner(program).bounds(genomes, groups)
    rows, options = np.arange(len(genomes)), variants - program.code.group_start[groups]
    low, span = bounds.low[rows, options], bounds.span[rows, options]
    assert (scenes.draws[valid] >= low).all()
    assert (scenes.draws[valid] <= low + span).all()
    before = np.where(options > 0, bounds.cumulative[rows, np.maximum(options - 1, 0)], 0.0)
    assert (bounds.cumulative[rows, options] > before).all()


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples(path: Path) -> None:
    """On every example, over its box and its own distributions."""
    program = load(path).program
    found = explain(program)
    assert found.looked_at
    for uniform in (False, True):
        scenes = attempts_at(program, 60_000, seed=3, uniform=uniform)
        assert scenes.valid.sum() > 100
        assert_never_wrong(program, scenes, found)


HEAD = """
param A = Range(-3, 5) m
param B = Range(1, 40) m
param S = Range(5, 80) km/h
param K = DiscreteRange(0, 3)
param N = TruncatedNormal(10, 4, 2, 20) m
lane = Uniform(*intersection.incomingLanes)
x = Range(-2, 9) m
y = Normal(0, 3) m
n = DiscreteRange(1, 4)
spot = new OrientedPoint in lane.centerline
ego = new Car at spot, with speed S
other = new Car on road
"""
ATOMS = (
    "A", "B", "N", "x", "y", "K * 1 m", "n * 1 m", "2 m", "-1 m", "12 m", "S * 1 s",
    "(distance from ego to intersection)",
    "(distance from ego to other)", "(distance from other to lane.centerline)", "(minimum distance from ego to other)",
    "(distance from ego to (A, B))",
)  # fmt: skip
TRUTHS = ("ego can see other", "other in intersection", "ego in road", "(other in lane) == (A > 0 m)")


def lengths(depth: int) -> st.SearchStrategy[str]:
    if depth == 0:
        return st.sampled_from(ATOMS)
    inner = lengths(depth - 1)
    return st.one_of(
        inner,
        st.builds("({} {} {})".format, inner, st.sampled_from("+-"), inner),
        st.builds("({} * {:.2f})".format, inner, st.floats(-3, 3)),
        st.builds("({} * {} / ({}))".format, inner, inner, st.sampled_from(("3 m", "B", "A", "x"))),
        st.builds("{}({}, {})".format, st.sampled_from(("min", "max", "hypot")), inner, inner),
        st.builds("abs({})".format, inner),
        st.builds("({} % {})".format, inner, st.sampled_from(("3 m", "B"))),
        st.builds("(sqrt({} / (1 m)) * 1 m)".format, inner),
        st.builds("(sin({} / (1 m) * 1 rad) * 4 m)".format, inner),
        st.builds("({} if {} > {} else {})".format, inner, inner, inner, inner),
    )


def conditions(depth: int) -> st.SearchStrategy[str]:
    compared = st.builds("{} {} {}".format, lengths(2), st.sampled_from(("<", "<=", ">", ">=")), lengths(1))
    near = st.builds("abs({} - {}) <= {:.2f} m".format, lengths(1), lengths(1), st.floats(0.1, 4))
    plain = st.one_of(compared, near, st.sampled_from(TRUTHS))
    if depth == 0:
        return plain
    inner = conditions(depth - 1)
    return st.one_of(
        plain,
        st.builds("({} and {})".format, inner, inner),
        st.builds("({} or {})".format, inner, inner),
        st.builds("not ({})".format, inner),
    )


@examples(60)
@given(st.lists(conditions(1), min_size=1, max_size=3), st.integers(0, 2**20))
def test_generated_programs(requirements: list[str], seed: int) -> None:
    """On programs of random requirements over genes, draws, lanes and distances."""
    text = HEAD + "".join(f"require {condition}\n" for condition in requirements)
    try:
        program = compile_text(text).program
    except Exception as error:
        if type(error).__name__ != "CompileError":
            raise
        return
    scenes = attempts_at(program, 1500, seed)
    assert_never_wrong(program, scenes, explain(program))


def test_a_soft_requirement_proves_nothing() -> None:
    """What holds only sometimes is never the reason for a cut."""
    program = compile_text("param A = Range(0, 9) m\nego = new Car on road\nrequire[0.5] A > 20 m\n").program
    found = explain(program)
    assert not found.infeasible
    assert not found.cuts


def test_nan_counts_for_nothing_sure() -> None:
    """A root that may not exist cuts nothing where its comparison is negated: its scenes are errors, not rejected."""
    program = compile_text("param A = Range(-9, 9)\nego = new Car on road\nrequire not (sqrt(A) < 100)\n").program
    assert not explain(program).infeasible
    scenes = attempts_at(program, 500)
    assert (scenes.verdict == Verdict.ERROR).sum() > 100
    assert not scenes.valid.any()
    assert_never_wrong(program, scenes, explain(program))


def test_what_is_cut_and_why() -> None:
    """The hull of a gene is as narrow as the requirement says, and the requirement is named, alone."""
    text = (
        "param A = Range(0, 10) m\nparam B = Range(0, 10) m\nego = new Car on road\n"
        "require A + B <= 4 m\nrequire B > 1 m\n"
    )
    program = compile_text(text).program
    cuts = {(program.space.names[c.gene], c.above): c for c in explain(program).cuts}
    assert cuts["A", True].value == pytest.approx(3.0)
    assert [program.requirements[r].line for r in cuts["A", True].requirements] == [4, 5]
    assert cuts["B", True].value == pytest.approx(4.0)
    assert [program.requirements[r].line for r in cuts["B", True].requirements] == [4]
    assert cuts["B", False].value == pytest.approx(1.0)


def test_an_infeasible_file_names_the_smallest_proof() -> None:
    """Requirements that do not take part in the contradiction are not named."""
    text = (
        "param A = Range(0, 10) m\nparam B = Range(0, 10) m\nego = new Car on road\n"
        "require B <= 9 m\nrequire A >= 7 m\nrequire A * 2 <= B\nrequire B <= 12 m\n"
    )
    program = compile_text(text).program
    found = explain(program)
    assert found.infeasible
    assert [program.requirements[r].line for r in found.conflict] == [5, 6]


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_pruning_keeps_the_distribution(path: Path) -> None:
    """With and without pruning scenes have the same law; so has being valid, even with few attempts allowed.

    Two-sample Kolmogorov-Smirnov tests of every scene value and gene, chi-square of variants, both at a level that one
    of them fails by chance once in a thousand runs.
    """
    stats = pytest.importorskip("scipy.stats")
    program = load(path).program
    for limit in (30, 2000):
        plain, pruned = (_drawn(program, limit, prune) for prune in (False, True))
        share = plain.valid.mean(), pruned.valid.mean()
        assert abs(share[0] - share[1]) < 4.0 * np.sqrt(share[0] * (1 - share[0]) * 2 / len(plain))
        one, other = (np.hstack([s.values, s.genomes, s.draws])[s.valid] for s in (plain, pruned))
        moving = np.flatnonzero(np.ptp(one, axis=0) > 0)
        least = min(stats.ks_2samp(one[:, i], other[:, i]).pvalue for i in moving)
        assert least > 1e-3 / 40
        counts = [np.bincount(s.variant[s.valid], minlength=len(program.variants)) for s in (plain, pruned)]
        if len(program.variants) > 1:
            assert stats.chi2_contingency(counts).pvalue > 1e-3 / 40
    beyond = [np.maximum(scenes.attempts - FREE_ATTEMPTS, 0).sum() for scenes in (plain, pruned)]
    assert beyond[1] < 0.05 * beyond[0]


def _drawn(program: Program, limit: int, prune: bool) -> Scenes:
    keys = key_rows(int(prune), Method.SAMPLE, 0, 0, range(6000))
    config = SimulationConfig(max_attempts=limit, prune=prune)
    return sample(program, draw_genomes(program.space, keys), keys, config)


UNEVEN = """
wide = Uniform(0, 1)
x = Range(0, 10)
ego = new Car at (0, -30), with speed 3 m/s
other = new Car at (0, -10 - x), with speed x
require x > 8 if wide == 0 else x < 6
"""


def test_variants_keep_their_weights() -> None:
    """A variant of which less can hold is drawn less often: 2 to 6, not evenly."""
    program = compile_text("map intersection(ways=4, lanes=1)\n" + UNEVEN).program
    pruned = _drawn(program, 2000, prune=True)
    plain = _drawn(program, 2000, prune=False)
    for scenes in (plain, pruned):
        speed = scenes.values[scenes.valid][:, len(Column) + Column.SPEED]
        assert (speed > 8).mean() == pytest.approx(2 / 8, abs=0.03)


@pytest.mark.parametrize("jobs", [2, 3])
def test_pruned_scenes_do_not_depend_on_jobs(jobs: int) -> None:
    """Nor on what is drawn beside them."""
    program = load(EXAMPLES[0]).program
    keys = key_rows(5, Method.SAMPLE, 0, 0, range(500))
    genomes = draw_genomes(program.space, keys)
    one = sample(program, genomes, keys, PRUNED)
    many = sample(program, genomes, keys, PRUNED, jobs=jobs)
    alone = sample(program, genomes[70:71], keys[70:71], PRUNED)
    np.testing.assert_array_equal(one.values, many.values)
    np.testing.assert_array_equal(one.values[70:71], alone.values)
    np.testing.assert_array_equal(one.attempts, many.attempts)


def test_a_genome_that_cannot_be_is_infeasible() -> None:
    """It gets that verdict, with the requirement that rules it out; one attempt stands for all that are not made."""
    program = load(next(path for path in EXAMPLES if path.stem == "left_turn")).program
    keys = key_rows(0, Method.SAMPLE, 0, 0, [0])
    genome = draw_genomes(program.space, keys)
    genome[0, 0] = 57.0
    scenes = sample(program, genome, keys, PRUNED)
    assert scenes.verdict[0] == Verdict.INFEASIBLE
    assert program.requirements[int(np.flatnonzero(scenes.failed[0])[0])].name == "ego starts where it should"
    assert scenes.attempts[0] == scenes.failed[0].sum() == FREE_ATTEMPTS + 1
    assert sample(program, genome, keys, replace(PRUNED, prune=False)).verdict[0] == Verdict.EXHAUSTED


def test_a_genome_outside_its_box_is_not_pruned() -> None:
    """What is proved holds for the declared ranges only."""
    program = compile_text(
        "param A = Range(0, 5) m\nx = Range(0, 9) m\nego = new Car at (0, -30)\nrequire x > A\n"
    ).program
    bounds = pruner(program).bounds(np.array([[-3.0], [4.5]]), np.zeros(2, dtype=np.int64))
    assert bounds.mass[0] == 1.0
    assert bounds.mass[1] == pytest.approx(0.5, abs=0.02)


def test_scenes_of_few_attempts_are_those_without_pruning() -> None:
    """Only genomes to which the first attempts give no scene are bounded, whatever is drawn beside them."""
    for path in EXAMPLES:
        program = load(path).program
        keys = key_rows(3, Method.SAMPLE, 0, 0, range(400))
        genomes = draw_genomes(program.space, keys)
        plain, chosen = (sample(program, genomes, keys, replace(PRUNED, prune=prune)) for prune in (False, True))
        early = plain.attempts <= FREE_ATTEMPTS
        assert early.any()
        assert not early.all()
        for name in ("verdict", "values", "attempts", "tested", "failed"):
            np.testing.assert_array_equal(getattr(plain, name)[early], getattr(chosen, name)[early])
        assert (chosen.attempts[~early] >= FREE_ATTEMPTS).all()

"""What holds of every way to search, in a toy world with invalid regions and failing engines."""

import math
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.assessment import Assessment, Evaluate
from engine.config import Config, SearchConfig
from engine.extras import MissingExtraError
from engine.kernels.elimination import eliminate
from engine.kernels.jit import cache_folder
from engine.program import ParamSpace
from engine.search.campaign import Campaign
from engine.search.methods import failure_kinds
from engine.search.methods.best_first import BestFirst, rarity
from engine.search.methods.cube import Cube, QuasiRandom, RandomSearch, reflected
from engine.search.methods.external import CovarianceAdaptation, Illumination, NonDominatedSorting, objectives
from engine.search.methods.failure_kinds import FailureKinds, order
from engine.search.methods.ga import GeneticAlgorithm
from engine.search.methods.gaussian_process import likelihood, predicted
from engine.search.methods.niching import NichingSearch, gene_weights
from engine.search.methods.optimizers import CrossEntropy, DifferentialEvolution, truncated_normal
from engine.search.methods.table import REMOVED, SEARCHERS
from engine.search.methods.trust_regions import TrustRegions, fitted, normal_scores
from engine.search.protocol import DEFAULT_OBJECTIVES, MEASURES, Box, Operator, Result, Searcher, Status, StreamAt
from engine.search.run import Task, run_campaign
from engine.search.searchers import UnknownMethodError, build_searcher, canonical
from engine.streams import operator_generator
from engine.vocabulary import GeneKind, Method, Verdict
from tests.laws import examples

CONFIG = SearchConfig(generations=8, population=20, seed=3, probes=0)
Build = Callable[[Box, int, StreamAt], Searcher]

METHODS: dict[str, Build] = {
    "random": RandomSearch,
    "ga": GeneticAlgorithm,
    "sobol": partial(QuasiRandom, sequence="sobol"),
    "halton": partial(QuasiRandom, sequence="halton"),
    "lhs": partial(QuasiRandom, sequence="lhs"),
    "cross_entropy": CrossEntropy,
    "differential_evolution": DifferentialEvolution,
    "niching": NichingSearch,
    "best_first": BestFirst,
    "failure_kinds": FailureKinds,
    "trust_regions": TrustRegions,
    "cmaes": CovarianceAdaptation,
    "nsga2": NonDominatedSorting,
    "map_elites": partial(Illumination, method="map_elites"),
    "cma_me": partial(Illumination, method="cma_me"),
}
LEARNING = (
    "ga",
    "cross_entropy",
    "differential_evolution",
    "niching",
    "best_first",
    "failure_kinds",
    "trust_regions",
    "cmaes",
)


def search(
    method: str,
    space: ParamSpace,
    evaluate: Evaluate,
    config: SearchConfig = CONFIG,
    seed: int = CONFIG.seed,
    objective: tuple[str, ...] = DEFAULT_OBJECTIVES,
) -> Campaign:
    streams = partial(operator_generator, seed, int(Method.GA), 0)
    searcher = METHODS[method](Box.of(space), config.population, streams)
    return run_campaign(Task(space, evaluate, config, "ga", objective=objective), searcher)


@pytest.mark.parametrize("method", METHODS)
def test_never_leaves_its_box(space: ParamSpace, evaluators: Callable[..., Evaluate], method: str) -> None:
    """Every genome lies in the box, discrete genes on whole numbers, whatever results it got, invalid ones too."""
    box = Box.of(space)
    found = search(method, space, evaluators(space, error_above=0.9))
    assert len(found.evaluations) == CONFIG.generations * CONFIG.population
    assert all(box.holds(tuple(genome)) for genome in found.evaluations.genomes.tolist())


def test_code_that_a_package_compiles_is_stored(space: ParamSpace, evaluators: Callable[..., Evaluate]) -> None:
    """A second process finds what `ribs` compiles with numba: 4 s of the first search."""
    strategy = pytest.importorskip("ribs.emitters.opt").CMAEvolutionStrategy
    search("cma_me", space, evaluators(space))
    folder = Path(strategy._calc_cov_update.stats.cache_path)
    assert folder.is_relative_to(cache_folder())
    assert list(folder.glob("_cma_es.*_calc_cov_update*.nbc"))


@pytest.mark.parametrize("method", [method for method in METHODS if method != "cmaes"])
def test_first_generation_covers_its_box(space: ParamSpace, evaluators: Callable[..., Evaluate], method: str) -> None:
    """Before anything is known, every gene comes near both ends of its range, and discrete genes take every value.

    CMA-ES alone begins at one place, around which it draws.
    """
    config = SearchConfig(generations=1, population=60, probes=0)
    genomes = search(method, space, evaluators(space), config).evaluations.genomes
    unit = (genomes - space.low) / (space.high - space.low)
    assert (unit.min(axis=0) < 0.1).all()
    assert (unit.max(axis=0) > 0.9).all()
    for gene in np.flatnonzero(space.kinds != GeneKind.CONTINUOUS):
        assert set(genomes[:, gene]) == set(np.arange(space.low[gene], space.high[gene] + 1.0))


@pytest.mark.parametrize("method", METHODS)
def test_a_search_without_a_hint_covers_its_box(
    space: ParamSpace, rows: Callable[..., Assessment], method: str
) -> None:
    """Where risk is chance alone, nothing keeps a method from the ends of any gene's range."""
    chance = np.random.default_rng(0)

    def flat(genomes: np.ndarray, keys: np.ndarray) -> Assessment:
        return rows(np.zeros(len(keys), dtype=np.int32), chance.uniform(2.0, 22.0, len(keys)))

    genomes = search(method, space, flat, SearchConfig(generations=12, population=40, probes=0)).evaluations.genomes
    unit = (genomes - space.low) / (space.high - space.low)
    assert (unit.min(axis=0) < 0.1).all()
    assert (unit.max(axis=0) > 0.9).all()


@pytest.mark.parametrize("method", METHODS)
def test_same_seed_same_search(space: ParamSpace, evaluators: Callable[..., Evaluate], method: str) -> None:
    """A search is a function of its seed and of the results it gets."""
    first, second = (search(method, space, evaluators(space)) for _ in range(2))
    other = search(method, space, evaluators(space), seed=4)
    np.testing.assert_array_equal(first.evaluations.genomes, second.evaluations.genomes)
    assert not np.array_equal(first.evaluations.genomes, other.evaluations.genomes)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("ranges", [([], []), ([2.0], [2.0]), ([0.0], [1.0]), ([0.0, 5.0], [1.0, 5.0])])
def test_small_boxes(
    spaces: Callable[..., ParamSpace],
    evaluators: Callable[..., Evaluate],
    method: str,
    ranges: tuple[list[float], list[float]],
) -> None:
    """No gene, a gene of one value, one gene, one of two that matters: a search ends as any other."""
    space = spaces(*ranges)
    found = search(method, space, evaluators(space))
    assert len(found.generations) == CONFIG.generations


@pytest.mark.parametrize("method", METHODS)
def test_nothing_valid(
    space: ParamSpace, evaluators: Callable[..., Evaluate], rows: Callable[..., object], method: str
) -> None:
    """A world without a valid genome is searched to the end of the budget."""

    def hopeless(genomes: np.ndarray, keys: np.ndarray) -> object:
        return rows(np.full(len(keys), 2, dtype=np.int32), np.ones(len(keys)))

    found = search(method, space, hopeless)  # type: ignore[arg-type]
    assert found.by_individual.nis == CONFIG.generations * CONFIG.population


@pytest.mark.parametrize("method", LEARNING)
def test_learning_beats_chance(space: ParamSpace, evaluators: Callable[..., Evaluate], method: str) -> None:
    """A method that learns finds more risk than random search, and meets fewer invalid individuals."""
    config = SearchConfig(generations=15, population=40, probes=0)
    chance, learnt = (search(name, space, evaluators(space), config).by_individual for name in ("random", method))
    assert learnt.rl > 1.15 * chance.rl
    assert learnt.nc >= chance.nc
    assert learnt.nis < chance.nis


def test_niching_finds_more_kinds_than_the_genetic_algorithm(
    space: ParamSpace, evaluators: Callable[..., Evaluate]
) -> None:
    """Its failures lie further apart than those of the paper's algorithm."""
    config = SearchConfig(generations=15, population=40, probes=0)
    spread = []
    for method in ("ga", "niching"):
        found = search(method, space, evaluators(space), config).evaluations
        cube = Cube(Box.of(space))
        failures = np.unique(found.genomes[found.collided], axis=0)
        points = np.array([cube.point(genome) for genome in failures.tolist()])
        spread.append(points.std(axis=0).mean())
    assert spread[1] > spread[0]


# -- parts --------------------------------------------------------------------------------------------------------


@given(st.lists(st.floats(-5.0, 5.0), min_size=1, max_size=6))
def test_reflection_stays_inside(values: list[float]) -> None:
    """Mirrors bring every point into the cube and leave those inside where they are."""
    point = np.array(values)
    inside = reflected(point)
    assert ((inside >= 0.0) & (inside <= 1.0)).all()
    within = (point >= 0.0) & (point <= 1.0)
    np.testing.assert_allclose(inside[within], point[within], atol=1e-12)


@given(st.lists(st.floats(0.0, 1.0), min_size=7, max_size=7))
@examples(50)
def test_cube_round_trip(point: list[float]) -> None:
    """A genome's point leads back to the genome."""
    kinds = (GeneKind.CONTINUOUS,) * 5 + (GeneKind.INTEGER, GeneKind.INDEX)
    box = Box(tuple("abcdefg"), (5.0, 5.0, 0.0, 5.0, -1.0, 2.0, 0.0), (58.0, 80.0, 1.0, 58.0, 1.0, 9.0, 3.0), kinds)
    cube = Cube(box)
    (genome,) = cube.genomes(np.array([point]))
    assert box.holds(genome)
    np.testing.assert_allclose(cube.genomes(cube.point(genome)[np.newaxis])[0], genome, rtol=1e-12, atol=1e-12)


def test_truncated_normal_has_its_moments() -> None:
    """Well inside the interval it is the normal distribution; at the border nothing falls outside."""
    stream = np.random.default_rng(0)
    points = truncated_normal(stream, np.array([0.5, 0.0]), np.array([0.05, 0.3]), 20_000)
    assert abs(points[:, 0].mean() - 0.5) < 0.002
    assert abs(points[:, 0].std() - 0.05) < 0.002
    assert points[:, 1].min() >= 0.0
    assert abs(points[:, 1].mean() - 0.3 * np.sqrt(2.0 / np.pi)) < 0.01


def test_gene_weights_show_what_matters() -> None:
    """A gene that decides has weight 1, one without influence next to 0."""
    stream = np.random.default_rng(1)
    points = stream.random((800, 3))
    weights = gene_weights(points, points[:, 1] > 0.5)
    assert weights[1] == 1.0
    assert max(weights[0], weights[2]) < 0.3


# -- the table --------------------------------------------------------------------------------------------------------


def test_every_method_of_the_vocabulary_has_a_row() -> None:
    """The numbers without a row are those of single runs and samples, of other packages, and of removed methods."""
    numbered = {entry.number: name for name, entry in SEARCHERS.items() if entry.number in set(Method)}
    assert all(Method(number).name.lower() == name for number, name in numbered.items())
    assert set(Method) - set(numbered) == {Method.SINGLE, Method.SAMPLE, Method.CUSTOM, Method.ANNEALING}
    assert Method.ANNEALING.name.lower() in REMOVED
    assert all(name == entry.name for name, entry in SEARCHERS.items())


def test_no_two_methods_share_numbers_or_names() -> None:
    """Nor the alias of one the name of another."""
    words = [word for entry in SEARCHERS.values() for word in (entry.name, entry.alias) if word]
    assert len(set(words)) == len(words)
    assert len({entry.number for entry in SEARCHERS.values()}) == len(SEARCHERS)


@pytest.mark.parametrize("name", [name for name, entry in SEARCHERS.items() if entry.package])
def test_a_missing_package_is_named_with_its_extra(
    space: ParamSpace, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the line that installs it."""
    package = SEARCHERS[name].package
    for module in [package, *(each for each in sys.modules if each.startswith(f"{package}."))]:
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(MissingExtraError, match=rf"`{name}` needs the package `{package}`.*\[search\]"):
        build_searcher(name, Box.of(space), Config(search=CONFIG))


def test_names_are_forgiving() -> None:
    """Aliases, capitals and hyphens lead to the one name."""
    for word in ("ce", "Cross-Entropy", " cross_entropy "):
        assert canonical(word) == "cross_entropy"
    with pytest.raises(UnknownMethodError, match="is none of"):
        canonical("nichng")


def test_objectives_keep_what_is_invalid_out() -> None:
    """Nearer and faster is better; what has no distance is worse than anything that has."""
    near = Result(Status.VALID, 9.0, Verdict.VALID, 9.0, measures=(0.5, 12.0, 1.0, 2.0, 0.0))
    invalid = Result(Status.INVALID, float("nan"), Verdict.EXHAUSTED)
    table = objectives([near, invalid])
    np.testing.assert_array_equal(table[0], [0.5, -12.0])
    assert (table[1] > 1e6).all()


# -- best-first search -------------------------------------------------------------------------------------------------


@given(st.lists(st.sampled_from([-3.0, -1.5, 0.0, 0.25, 7.0]), min_size=1, max_size=30))
def test_what_is_rarer_promises_more(values: list[float]) -> None:
    """The promise is the logarithm of how rare a value is: larger values have more of it, equal ones the same."""
    promise = rarity(np.array(values))
    for one, other in product(range(len(values)), repeat=2):
        assert (promise[one] > promise[other]) == (values[one] > values[other])
    better = [sum(v > w for v in values) + 0.5 * values.count(w) for w in values]
    np.testing.assert_allclose(promise, -np.log(np.array(better) / len(values)))


def test_best_first_search_leaves_a_slope_that_ends(
    spaces: Callable[..., ParamSpace], rows: Callable[..., Assessment]
) -> None:
    """A broad slope ends below a failure, a narrow one leads to it: its top is reached, as random draws never do."""
    space, wrong, right = spaces([0.0] * 5, [1.0] * 5), np.full(5, 0.7), np.array([0.3, 0.2, 0.45, 0.6, 0.2])

    def two_slopes(genomes: np.ndarray, keys: np.ndarray) -> Assessment:
        broad = 10.0 + 8.0 * np.linalg.norm(genomes - wrong, axis=1)
        return rows(
            np.zeros(len(keys), dtype=np.int32), np.minimum(broad, 40.0 * np.linalg.norm(genomes - right, axis=1))
        )

    config = SearchConfig(generations=20, population=100, probes=0)
    away = {
        method: np.linalg.norm(search(method, space, two_slopes, config).evaluations.genomes - right, axis=1).min()
        for method in ("best_first", "random")
    }
    assert away["best_first"] < 0.02 < 0.08 < away["random"]


# -- failures by kind --------------------------------------------------------------------------------------------------


@given(st.lists(st.tuples(st.booleans(), st.booleans(), st.sampled_from([-2.0, 0.0, 0.5, 3.0])), min_size=1))
def test_failures_come_before_contacts_and_contacts_before_what_passed(runs: list[tuple[bool, bool, float]]) -> None:
    """Among these the objective decides; equal ones have one place."""
    fails, touched, value = (np.array(column) for column in zip(*runs, strict=True))
    places = order(fails, touched, value).tolist()
    for one, other in product(range(len(runs)), repeat=2):
        assert (places[one] < places[other]) == (runs[one] < runs[other])


def test_what_a_model_foresees_is_run(spaces: Callable[..., ParamSpace], rows: Callable[..., Assessment]) -> None:
    """Half of all contacts say how nearly they failed, and a scene blurs it: where they come to it most of what is bred
    fails in the end, and of contacts at random a hundredth.
    """
    space, place = spaces([0.0] * 4, [1.0] * 4), np.array([0.25, 0.7, 0.4, 0.6])

    def nearly(genomes: np.ndarray, keys: np.ndarray) -> Assessment:
        blurred = genomes + [np.random.default_rng(key.tolist()).normal(0.0, 0.02, 4) for key in keys]
        away = np.linalg.norm(blurred - place, axis=1)
        table = rows(np.zeros(len(keys), dtype=np.int32), np.where(genomes[:, 0] < 0.5, 0.0, 9.0))
        return replace(table, sought=-away[:, np.newaxis], found=away < 0.15)

    config = SearchConfig(generations=12, population=60, probes=0)
    shares = {}
    for method in ("failure_kinds", "random"):
        runs = search(method, space, nearly, config, objective=("nearly",)).evaluations
        late = runs.places[:, 0] >= 8
        shares[method] = float(runs.rollouts.found[late].mean())
    assert shares["failure_kinds"] > 0.3 > 0.01 > shares["random"]


def test_no_candidate_is_run_twice(spaces: Callable[..., ParamSpace], rows: Callable[..., Assessment]) -> None:
    """Not even where few candidates are of the kind of failures that has the fewest runs."""
    space = spaces([0.0] * 3, [1.0] * 3)

    def sliver(genomes: np.ndarray, keys: np.ndarray) -> Assessment:
        table = rows(np.zeros(len(keys), dtype=np.int32), np.where(genomes[:, 0] < 0.4, 0.0, 9.0))
        return replace(table, ego_speed=np.where(genomes[:, 1] < 0.01, 20.0, 5.0))

    runs = search("failure_kinds", space, sliver, SearchConfig(generations=10, population=80, probes=0)).evaluations
    assert len(np.unique(runs.genomes, axis=0)) == len(runs)


def test_failures_that_chance_decides_are_bred_from(
    spaces: Callable[..., ParamSpace], rows: Callable[..., Assessment]
) -> None:
    """In a small place every fifth run fails, without a slope that leads there: ten times random's are found."""
    space, place = spaces([0.0] * 3, [1.0] * 3), np.array([0.3, 0.7, 0.4])

    def chance(genomes: np.ndarray, keys: np.ndarray) -> Assessment:
        again = np.array([np.random.default_rng(key.tolist()).random() for key in keys])
        failed = (np.linalg.norm(genomes - place, axis=1) < 0.15) & (again < 0.2)
        return rows(np.zeros(len(keys), dtype=np.int32), np.where(failed, 0.0, 9.0))

    config = SearchConfig(generations=15, population=100, probes=0)
    found = {
        method: int(search(method, space, chance, config).evaluations.rollouts.collided.sum())
        for method in ("failure_kinds", "random")
    }
    assert found["failure_kinds"] > 10 * (found["random"] + 1)


def test_failures_of_other_kinds_are_found_on_lines(
    spaces: Callable[..., ParamSpace], rows: Callable[..., Assessment], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Who starts farther away fails if it is as much faster; speeds part kinds. Steps of single genes lead nowhere."""
    space = spaces([0.0] * 4, [1.0] * 4)

    def ridge(genomes: np.ndarray, keys: np.ndarray) -> Assessment:
        aside = np.abs(genomes[:, 1:3] - genomes[:, :1]).max(axis=1)
        distances = np.where(aside < 0.03, 0.0, 9.0)
        return replace(rows(np.zeros(len(keys), dtype=np.int32), distances), ego_speed=25.0 * genomes[:, 0])

    def places() -> float:
        config, found = SearchConfig(generations=16, population=60, probes=0), list[int]()
        for seed in range(16):
            runs = search("failure_kinds", space, ridge, config, seed).evaluations
            found.append(len(np.unique((100 * runs.genomes[runs.rollouts.collided[:, 0], 0]).astype(int))))
        return float(np.mean(found))

    on_lines = places()
    monkeypatch.setattr(failure_kinds, "LINES", 0.0)
    assert on_lines > 1.25 * places()


def test_who_lies_on_a_line_has_two_parents(spaces: Callable[..., ParamSpace], rows: Callable[..., Assessment]) -> None:
    """They are those whose line it is, but for a little aside; a single parent has a mutant."""
    space = spaces([0.0] * 4, [1.0] * 4)

    def half(genomes: np.ndarray, keys: np.ndarray) -> Assessment:
        return rows(np.zeros(len(keys), dtype=np.int32), np.where(genomes[:, 0] < 0.3, 0.0, 9.0))

    runs = search("failure_kinds", space, half, SearchConfig(generations=8, population=60, probes=0), 1).evaluations
    crossed = runs.operator == Operator.CROSSOVER
    assert crossed.sum() > 20
    assert (runs.parents[crossed] >= 0).all()
    assert (runs.parents[runs.operator == Operator.MUTATION, 1] == -1).all()
    births = {tuple(birth): genome for birth, genome in zip(runs.births.tolist(), runs.genomes, strict=True)}
    aside = []
    for genome, parents in zip(runs.genomes[crossed], runs.parents[crossed].tolist(), strict=True):
        first, second = (births[tuple(parent)] for parent in parents)
        way = (second - first) / np.linalg.norm(second - first)
        away = genome - first
        if (genome > 0.0).all() and (genome < 1.0).all():
            aside.append(np.linalg.norm(away - (away @ way) * way))
    assert np.median(aside) < 4.0 * failure_kinds.ASIDE


def test_failure_kinds_one_at_a_time() -> None:
    """A generation of one is all at random or all bred."""
    box = Box(("a", "b"), (0.0, 0.0), (1.0, 1.0), (GeneKind.CONTINUOUS,) * 2)
    searcher = FailureKinds(box, 1, lambda *address: np.random.default_rng(address))
    touched = Result(Status.VALID, 1.0, Verdict.VALID, 1.0, False, (0.0,) * len(MEASURES))
    for _ in range(4):
        assert len(searcher.ask()) == 1
        searcher.tell([touched])


# -- trust regions -----------------------------------------------------------------------------------------------------


@given(st.integers(1, 30), st.integers(0, 3), st.integers(0, 2**32))
def test_elimination_factors_a_matrix_one_rounding_after_another(size: int, columns: int, seed: int) -> None:
    """The bits are those of plain Python, which rounds each product and each difference on its own."""
    stream = np.random.default_rng(seed)
    root = stream.standard_normal((size, size))
    rows = np.column_stack([root @ root.T + np.eye(size), stream.standard_normal((size, columns))])
    plain = rows.tolist()
    for i in range(size):
        for k in range(i):
            plain[i][i:] = [a - plain[k][i] * b for a, b in zip(plain[i][i:], plain[k][i:], strict=True)]
        root_of = math.sqrt(plain[i][i])
        plain[i][i:] = [a / root_of for a in plain[i][i:]]
    found = rows.copy()
    eliminate(found)
    assert np.array_equal(found, np.array(plain))
    upper = np.triu(found[:, :size])
    assert np.allclose(upper.T @ upper, rows[:, :size], rtol=1e-9, atol=1e-9)
    assert np.allclose(upper.T @ found[:, size:], rows[:, size:], rtol=1e-6, atol=1e-6)


def test_a_model_knows_what_it_was_told_and_doubts_the_rest() -> None:
    """Near a known point its value, within what noise allows; far from all of them nothing."""
    stream = np.random.default_rng(5)
    points = stream.random((60, 2)) * 0.5
    values = normal_scores(points[:, 0] + 0.3 * np.sin(6.0 * points[:, 1]))
    lengths = np.full(2, 0.3)
    mean, deviation = predicted(points, values, lengths, 0.05, points)
    assert np.abs(mean - values).max() < 0.5
    far, doubt = predicted(points, values, lengths, 0.05, np.array([[5.0, 5.0]]))
    assert abs(float(far[0])) < 1e-3
    assert float(doubt[0]) > 0.99 > deviation.max()


def test_lengths_tell_genes_that_do_not_matter() -> None:
    """They only ever explain the values better, and grow where a gene decides nothing."""
    stream = np.random.default_rng(6)
    points = stream.random((80, 3))
    values = normal_scores(np.sin(5.0 * points[:, 1]))
    lengths = np.full(3, 0.5)
    for _ in range(12):
        after = fitted(points, values, lengths, stream)
        assert likelihood(points, values, after, 0.05) >= likelihood(points, values, lengths, 0.05)
        lengths = after
    assert lengths[1] < min(lengths[0], lengths[2])


def test_trust_regions_find_what_lies_in_a_narrow_place(
    spaces: Callable[..., ParamSpace], rows: Callable[..., Assessment]
) -> None:
    """A valley that leads to a narrow place: found within 2,000 runs, where random ones do not come near it."""
    space, place = spaces([0.0] * 5, [1.0] * 5), np.array([0.3, 0.8, 0.45, 0.6, 0.2])

    def valley(genomes: np.ndarray, keys: np.ndarray) -> Assessment:
        return rows(np.zeros(len(keys), dtype=np.int32), 20.0 * np.abs(genomes - place).max(axis=1))

    config = SearchConfig(generations=20, population=100, probes=0)
    away = {
        method: np.abs(search(method, space, valley, config).evaluations.genomes - place).max(axis=1).min()
        for method in ("trust_regions", "random")
    }
    assert away["trust_regions"] < 0.04 < away["random"]


@pytest.mark.parametrize("count", [0, 2, 10])
@pytest.mark.parametrize("method", [BestFirst, FailureKinds])
def test_a_search_that_begins_with_genomes(space: ParamSpace, count: int, method: type[BestFirst]) -> None:
    """The first generation holds them, as many as it has places; the others are those of the search without them."""
    box, streams = Box.of(space), partial(operator_generator, 1, 0, 0)
    plain, warm = method(box, 6, streams), method(box, 6, streams)
    genomes = np.array([proposal.genome for proposal in method(box, 12, partial(operator_generator, 2, 0, 0)).ask()])
    warm.begin_with(genomes[:count])
    first, others = [proposal.genome for proposal in warm.ask()], [proposal.genome for proposal in plain.ask()]
    taken = min(count, 6)
    assert first[:taken] == [pytest.approx(tuple(genome)) for genome in genomes[:taken].tolist()]
    assert first[taken:] == others[taken:]

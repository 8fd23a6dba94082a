"""Gene values: their distributions, their bounds, their independence from one another's rows."""

import numpy as np
import pytest
from scipy import stats

from engine.program import ParamSpace
from engine.sampling import draw_genomes, uniform_genomes
from engine.streams import key_rows
from engine.vocabulary import Distribution, GeneKind, Method

ROWS = 20_000
FAR = (30.0, 31.0, 0.0, 1.0)


@pytest.fixture(scope="module")
def space() -> ParamSpace:
    """A range, two truncated normals (one far in the tail), an integer, a choice and a weighted choice."""
    none, choice = (), ("a", "b", "c")
    return ParamSpace(
        names=("range", "normal", "far", "whole", "choice", "weighted"),
        units=("km/h", "m", "m", "", "", ""),
        kinds=np.array([GeneKind.CONTINUOUS] * 3 + [GeneKind.INTEGER] + [GeneKind.INDEX] * 2, dtype=np.int32),
        low=np.array([5.0, -1.0, FAR[0], -2.0, 0.0, 0.0]),
        high=np.array([80.0, 2.0, FAR[1], 4.0, 2.0, 2.0]),
        distribution=np.array(
            [
                Distribution.UNIFORM,
                Distribution.TRUNCATED_NORMAL,
                Distribution.TRUNCATED_NORMAL,
                Distribution.UNIFORM,
                Distribution.UNIFORM,
                Distribution.DISCRETE,
            ],
            dtype=np.int32,
        ),
        shape=np.array([[0, 0], [0.5, 1.5], [FAR[2], FAR[3]], [0, 0], [0, 0], [0, 0]], dtype=np.float64),
        scale=np.ones(6),
        options=(none, none, none, none, choice, choice),
        weights=(none, none, none, none, none, (0.5, 0.0, 1.5)),
    )


@pytest.fixture(scope="module")
def keys() -> np.ndarray:
    return key_rows(3, Method.SAMPLE, 0, 0, range(ROWS))


def test_continuous_genes_follow_their_distributions(space, keys):
    """Ranges and truncated normals pass Kolmogorov-Smirnov tests against scipy's."""
    genomes = draw_genomes(space, keys)
    laws = [
        stats.uniform(5.0, 75.0),
        stats.truncnorm(-1.0, 1.0, 0.5, 1.5),
        stats.truncnorm(FAR[0], FAR[1], FAR[2], FAR[3]),
    ]
    for gene, law in enumerate(laws):
        share = law.cdf(genomes[:, gene])
        assert stats.kstest(share, "uniform").pvalue > 0.001


def test_discrete_genes_follow_their_weights(space, keys):
    """Whole numbers and options come with their shares, and an option without weight never."""
    genomes = draw_genomes(space, keys)
    shares = [np.full(7, 1 / 7), np.full(3, 1 / 3), np.array([0.25, 0.0, 0.75])]
    for gene, share in zip((3, 4, 5), shares, strict=True):
        counts = np.bincount((genomes[:, gene] - space.low[gene]).astype(int), minlength=len(share))
        assert counts[share == 0.0].sum() == 0
        assert stats.chisquare(counts[share > 0], ROWS * share[share > 0]).pvalue > 0.001


def test_search_box_is_covered_uniformly(space, keys):
    """For a search every gene is uniform over its bounds, whatever its distribution."""
    genomes = uniform_genomes(space, keys)
    for gene in range(3):
        law = stats.uniform(space.low[gene], space.high[gene] - space.low[gene])
        share = law.cdf(genomes[:, gene])
        assert stats.kstest(share, "uniform").pvalue > 0.001
    counts = np.bincount(genomes[:, 5].astype(int))
    assert stats.chisquare(counts).pvalue > 0.001


@pytest.mark.parametrize("draw", [draw_genomes, uniform_genomes])
def test_genomes_stay_in_the_box(space, keys, draw):
    """No gene leaves its bounds, and discrete ones are whole."""
    genomes = draw(space, keys)
    assert np.all(genomes >= space.low)
    assert np.all(genomes <= space.high)
    assert np.all(genomes[:, 3:] == np.round(genomes[:, 3:]))


def test_a_row_depends_on_its_key_alone(space, keys):
    """Drawing some rows, in another order, gives the same rows."""
    chosen = np.array([17, 3, 11])
    assert np.array_equal(draw_genomes(space, keys[chosen]), draw_genomes(space, keys)[chosen])


def test_genes_do_not_depend_on_one_another(space, keys):
    """Genes of one genome are uncorrelated."""
    correlation = np.corrcoef(uniform_genomes(space, keys), rowvar=False)
    assert np.max(np.abs(correlation - np.eye(6))) < 0.03

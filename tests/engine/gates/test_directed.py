"""Genomes of a part of the space lie in it, and its share is that of independent genomes."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import cortex_dsl as cx
from engine.gates.directed import genomes_between, quantiles_of
from engine.sampling import draw_genomes
from engine.streams import key_rows
from engine.vocabulary import GeneKind, Method
from tests.laws import examples

SPACE = cx.compile_text("""\
param A = Range(5, 15) m/s
param B = Normal(3 m, 2 m)
param C = TruncatedNormal(10, 4, 2, 30)
param D = Discrete({1: 1, 2: 3, 5: 2})
param E = DiscreteRange(2, 9)
param F = Uniform("calm", "quick", "odd")
ego = new Car on road, with speed A
""").program.space
KEYS = key_rows(11, Method.SAMPLE, 0, 0, range(4000))
DRAWN = draw_genomes(SPACE, KEYS)
TOLERANCE = 1e-6


@examples(40)
@given(st.data())
def test_genomes_of_a_part_lie_in_it_and_its_share_is_known(data: st.DataObject) -> None:
    """Ends are values of two independent genomes, so that parts are wide where many genomes lie."""
    one, other = (DRAWN[data.draw(st.integers(0, 3999))] for _ in range(2))
    low, high = np.minimum(one, other)[np.newaxis], np.maximum(one, other)[np.newaxis]
    below, above = quantiles_of(SPACE, low, high)
    found = genomes_between(SPACE, KEYS[:200], below, above)
    width = TOLERANCE * (1.0 + np.abs(high - low))
    assert ((found >= low - width) & (found <= high + width)).all()
    inside = (low <= DRAWN) & (high >= DRAWN)
    for gene in range(len(SPACE)):
        share, seen = float(above[0, gene] - below[0, gene]), float(inside[:, gene].mean())
        assert abs(share - seen) < 0.05
    discrete = SPACE.kinds != GeneKind.CONTINUOUS
    assert (found[:, discrete] == np.floor(found[:, discrete])).all()

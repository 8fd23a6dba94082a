"""Formulas for laws, and a reader of written expressions that shares nothing with their writer."""

import math
import re
from collections.abc import Mapping

from hypothesis import strategies as st

from engine.interchange.openscenario.maneuvers import formula
from engine.interchange.openscenario.maneuvers.formula import Formula

NAMES = ("SPEED", "DIST", "ego_shift")
EXPRESSION = re.compile(r"\$\{[ A-Za-z0-9_+\-*/%$().]*\}|\$[A-Za-z_][A-Za-z0-9_]*|-?[0-9]+(\.[0-9]+)?")
"""What the schemas of OpenSCENARIO 1.1 to 1.3 take for a number; that of 1.1.0 has no comma."""
numbers = st.floats(-100, 100).map(lambda value: round(value, 3))
leaves = st.one_of(numbers.map(formula.number), st.sampled_from(NAMES).map(formula.parameter))


def _grown(inner: st.SearchStrategy[Formula]) -> st.SearchStrategy[Formula]:
    two = [formula.add, formula.subtract, formula.multiply, formula.least, formula.most]
    one = [formula.positive, formula.square]
    pairs = st.tuples(st.sampled_from(two), inner, inner).map(lambda made: made[0](made[1], made[2]))
    return pairs | st.tuples(st.sampled_from(one), inner).map(lambda made: made[0](made[1]))


formulas = st.recursive(leaves, _grown, max_leaves=6)
parameters = st.fixed_dictionaries(dict.fromkeys(NAMES, numbers))


def evaluated(text: str, values: Mapping[str, float]) -> float:
    """An attribute as a reader of OpenSCENARIO understands it."""
    assert EXPRESSION.fullmatch(text), text
    inner = text[2:-1] if text.startswith("${") else text
    python = re.sub(r"\$([A-Za-z_][A-Za-z0-9_]*)", lambda found: f"({values[found[1]]!r})", inner)
    words = {"sqrt": math.sqrt, "floor": math.floor, "ceil": math.ceil, "round": round}
    return float(eval(python, {"__builtins__": {}}, words))

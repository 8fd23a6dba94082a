"""A condition on a number that does not exist neither holds nor fails: the scene or the run is an error.

Conditions are drawn as trees and evaluated by Python, with None for what has no value, in the logic of three values.
The compiler, the kernels of scenes and of runs, and the intervals that prove and prune must say the same.
"""

import math
from collections.abc import Callable
from functools import reduce
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cortex_dsl as cx
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.semantics.quantities.bounds import closed_value
from engine.feasibility.pruning import infeasible
from engine.kernels.evaluate import geometry_kernels, run_segment
from engine.kernels.jit import need
from engine.maps import RoadSpec
from engine.opcodes import Op
from engine.road import build_network, road_tables
from engine.sampling import sample
from engine.scenes import Scenes
from engine.streams import key_rows
from engine.vocabulary import EndReason, Method, Verdict
from tests.laws import examples

VALUES = (-2.0, -1.0, -0.25, 0.0, 0.5, 1.0, 3.0)
"""Of the param A, whose range they span."""
Tree = tuple[Any, ...]
FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sqrt": math.sqrt,
    "log": math.log,
    "asin": math.asin,
    "acos": math.acos,
    "abs": abs,
    "max": max,
    "min": min,
    "/": lambda a, b: a / b,
    "%": lambda a, b: a % b,
    "**": math.pow,
    "+": lambda a, b: a + b,
    "<": lambda a, b: a < b,
    ">=": lambda a, b: a >= b,
    "==": lambda a, b: a == b,
    "!=": lambda a, b: a != b,
}


def _trees(depth: int) -> tuple[st.SearchStrategy[Tree], st.SearchStrategy[Tree]]:
    """Numbers and conditions of so many levels."""
    numbers: st.SearchStrategy[Tree] = st.sampled_from([("A",), (0.5,), (1.5,)])
    conditions: st.SearchStrategy[Tree] = st.tuples(st.sampled_from(["<", ">=", "==", "!="]), numbers, numbers)
    for _ in range(depth):
        numbers, conditions = (
            st.tuples(st.sampled_from(["sqrt", "log", "asin", "acos", "abs"]), numbers)
            | st.tuples(st.sampled_from(["max", "min", "/", "%", "+", "**"]), numbers, numbers)
            | st.tuples(st.just("if"), conditions, numbers, numbers)
            | numbers,
            st.tuples(st.sampled_from(["<", ">=", "==", "!="]), numbers, numbers)
            | st.tuples(st.just("not"), conditions)
            | st.tuples(st.sampled_from(["and", "or"]), conditions, conditions),
        )
    return numbers, conditions


CONDITIONS = _trees(3)[1]


def text(tree: Tree) -> str:
    name, *parts = tree
    words = [text(part) for part in parts if isinstance(part, tuple)]
    match name:
        case "if":
            return f"({words[1]} if {words[0]} else {words[2]})"
        case "not":
            return f"(not {words[0]})"
        case str() if name in ("asin", "acos"):
            return f"({name}({words[0]}) / (1 rad))"
        case str() if len(words) == 2 and name not in ("max", "min"):
            return f"({words[0]} {name} {words[1]})"
    return f"{name}({', '.join(words)})" if words else f"({name})"


def worth(tree: Tree, a: float) -> float | None:
    """What Python makes of a tree; None where it has no value, or one that is infinite."""
    name, *parts = tree
    if not parts:
        return a if name == "A" else float(str(name))
    known = [worth(part, a) for part in parts if isinstance(part, tuple)]
    match name, known:
        case "if", [condition, then, otherwise]:
            return None if condition is None else then if condition else otherwise
        case "not", [one]:
            return None if one is None else not one
        case "and" | "or", _:
            decisive = name == "or"
            return decisive if decisive in known else None if None in known else not decisive
    if None in known:
        return None
    try:
        result = FUNCTIONS[str(name)](*known)
    except (ValueError, ZeroDivisionError, OverflowError):
        return None
    return result if math.isfinite(result) else None


def is_sharp(tree: Tree, a: float) -> bool:
    """Whether no comparison is decided by rounding, and nothing is divided by zero, which may be infinite."""
    name, *parts = tree
    inside = [part for part in parts if isinstance(part, tuple)]
    known = [worth(part, a) for part in inside]
    if name in ("<", ">=", "==", "!=", "%") and None not in known:
        one, other = (float(each) for each in known if each is not None)
        if abs(one - other) < 1e-9 or (name == "%" and abs(math.remainder(one, other or 1.0)) < 1e-9):
            return False
    if name in ("/", "%", "**", "log") and 0.0 in known:
        return False
    return reduce(bool.__and__, (is_sharp(part, a) for part in inside), True)


def compiled(tree: Tree, lines: str) -> cx.Scenario | None:
    """The file with a condition; None where it is refused, which nothing that may hold is."""
    try:
        return cx.compile_text(f"param A = Range({VALUES[0]}, {VALUES[-1]})\n{lines}\n")
    except CompileError as error:
        code = error.message[:6]
    assert code in ("SCN401", "SCN423", "SCN434"), code
    assert code == "SCN401" or not any(worth(tree, a) for a in VALUES if is_sharp(tree, a)), code
    return None


def drawn(scenario: cx.Scenario) -> tuple[np.ndarray, Scenes]:
    """A scene for each value of A."""
    genomes = np.array([[a] for a in VALUES])
    keys = key_rows(1, Method.SAMPLE, 0, 0, range(len(VALUES)))
    return genomes, sample(scenario.program, genomes, keys, scenario.config.simulation)


@given(CONDITIONS)
@examples(300)
def test_a_requirement_without_a_value_is_an_error(tree: Tree) -> None:
    """Of the scene; where it has one, the scene is valid or not, and pruning rules out none but those that fail."""
    scenario = compiled(tree, f"ego = new Car at (1.75, -30), facing 90 deg\nrequire {text(tree)}")
    if scenario is None:
        return
    known = {None: Verdict.ERROR, True: Verdict.VALID, False: Verdict.INFEASIBLE}
    (variant,) = scenario.compiled.scenario.variants
    genomes, scenes = drawn(scenario)
    ruled_out, _ = infeasible(scenario.program, genomes)
    for row, a in enumerate(VALUES):
        if not is_sharp(tree, a):
            continue
        expected = worth(tree, a)
        assert Verdict(int(scenes.verdict[row])) == known[expected], (text(tree), a)
        assert not (ruled_out[row] and expected is not False), (text(tree), a)
        condition = variant.requirements[0].condition
        found = closed_value(condition, genes={0: a})
        assert found is not None
        assert (None if math.isnan(found) else bool(found)) == expected, (text(tree), a)


PLACES = {
    "rule": "terminate when {}",
    "temporal": "require eventually {}",
    "branch": "",
}


@pytest.mark.parametrize("place", PLACES)
@given(CONDITIONS)
@examples(40)
def test_a_run_that_asks_it_is_an_error(place: str, tree: Tree) -> None:
    """Whether it is a rule, an atom of a formula or a branch of a behavior; A is read through a local of the run."""
    condition = text(tree).replace("(A)", "(ego.mine + ego.speed / (1 m/s))")
    branch = f"if {condition}:\n            wait\n        else:\n            wait\n"
    behavior = f"behavior B():\n    while True:\n        {branch}"
    lines = PLACES[place].format(condition)
    driven = "with behavior B(), " if place == "branch" else ""
    scenario = compiled(
        tree,
        f"class Own(Car):\n    mine: A\n{behavior if driven else ''}"
        f"ego = new Own at (1.75, -30), facing 90 deg, {driven}with speed 0 m/s\n{lines}\nterminate after 0.2 s",
    )
    if scenario is None:
        return
    _, scenes = drawn(scenario)
    outcomes = scenario.simulate(scenes)
    for row, a in enumerate(VALUES):
        if is_sharp(tree, a) and scenes.valid[row]:
            broken = int(outcomes.end_reason[row]) == EndReason.BROKEN
            assert broken == (worth(tree, a) is None), (text(tree), a)
        elif is_sharp(tree, a) and place == "temporal":
            assert (worth(tree, a) is None) == (scenes.verdict[row] == Verdict.ERROR), (text(tree), a)


BOX = (1.0, 2.0, 0.3, 4.0, 2.0)
GEOMETRY: dict[Op, tuple[tuple[float, ...], tuple[int, ...], tuple[int, ...], int]] = {
    Op.PATH_POSE: ((3.0, 5.0), (0, 1, 0), (1,), 3),
    Op.PATH_DISTANCE: ((3.0, 1.0, 2.0), (0, 1, 2), (1, 2), 1),
    Op.PATH_PROJECT: ((3.0, 1.0, 2.0), (0, 1, 2), (1, 2), 1),
    Op.REGION_SAMPLE: ((0.0, 0.3, 0.4), (0, 1, 2), (1, 2), 2),
    Op.REGION_DISTANCE: ((0.0, 99.0, 99.0), (0, 1, 2), (1, 2), 1),
    Op.REGION_CONTAINS: ((0.0, 1.0, 2.0), (0, 1, 2), (1, 2), 1),
    Op.REGION_DEPTH: ((0.0, 1.0, 2.0), (0, 1, 2), (1, 2), 1),
    Op.REGION_CONTAINS_BOX: ((0.0, *BOX), (0, 1, 0), (1, 2, 3, 4, 5), 1),
    Op.REGION_BOX_DISTANCE: ((0.0, *BOX), (0, 1, 0), (1, 2, 3, 4, 5), 1),
    Op.REGION_BOX_DEPTH: ((0.0, *BOX), (0, 1, 0), (1, 2, 3, 4, 5), 1),
    Op.BOX_DISTANCE: ((*BOX, *BOX), (0, 5, 0), tuple(range(10)), 1),
    Op.CAN_SEE: ((0.0, 0.0, 0.0, 3.0, 50.0, -1.0, *BOX, 0.0), (0, 6, 11), (0, 1, 2, 3, 4, 6, 7, 8, 9, 10), 1),
    Op.ROAD_HEADING: ((1.0, -30.0), (0, 1, 0), (0, 1), 1),
    Op.ROAD_FOLLOW: ((1.0, -30.0, 3.0), (0, 1, 2), (0, 1, 2), 3),
}
"""Registers of an instruction, its operands, the registers that may be NaN, and how many results it has."""


def test_geometry_of_a_place_that_does_not_exist_is_nan() -> None:
    """Distances are not infinite, and nothing lies outside a region or out of view, because its place is NaN."""
    road = road_tables(build_network(RoadSpec()))
    unlisted = {op for op in Op if Op.PATH_POSE <= op < Op.STATE} - GEOMETRY.keys()
    assert unlisted == {Op.PATH_LENGTH, Op.LANE_ROUTE, Op.LANE_NEAREST}, "these give the number of a path or a lane"
    for op, (values, operands, places, results) in GEOMETRY.items():
        code = np.array([[op, 20, *operands, 0], [Op.END, 0, 0, 0, 0, 0]], dtype=np.int32)
        need(*geometry_kernels(code))
        for place in places:
            registers = np.zeros(24)
            registers[: len(values)] = values
            registers[place] = math.nan
            run_segment(code.ravel(), 0, 2, registers, np.zeros(1), road)
            assert np.isnan(registers[20 : 20 + results]).all(), (op.name, place)


@pytest.mark.parametrize(
    "number", ["sqrt(A)", "log(A)", "asin(A - 2) / (1 rad)", "acos(A - 2) / (1 rad)", "log(A + 1)"]
)
@pytest.mark.parametrize("place", ["require not ({} > 0.5)", "other = new Car at (0, 30), with speed {} * 1 m/s"])
def test_what_bounds_prove_is_an_error_of_the_file(place: str, number: str) -> None:
    """Wherever A may lie, in a condition or a property."""
    with pytest.raises(CompileError, match="SCN401"):
        cx.compile_text(f"param A = Range(-2, -1)\nego = new Car at (0, 0)\n{place.format(number)}\n")

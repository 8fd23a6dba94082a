"""What is drawn lies in its legal range, and the concrete copy of every scene is that scene.

A copy holds each drawn value as a constant, and a constant outside its range is an error. So a value whose bounds leave
the range is an error too, one without bounds is drawn again, and a scene whose copy does not compile does not exist.
"""

import ast
import math
from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cortex_dsl as cx
from cortex_dsl.diagnostics import CompileError, Severity
from cortex_dsl.semantics.evaluation.maps import DIMENSIONS, MAP_ARGUMENTS, PLACES, TRUTHS, WHOLE
from cortex_dsl.semantics.names.builtins import BUILTINS
from cortex_dsl.semantics.names.properties import ENVIRONMENT, MEASURED, PROPERTIES, Domain
from cortex_dsl.semantics.quantities.units import ANGLE, LENGTH, PURE, TIME, si_word
from engine.outcomes import OUTCOMES
from engine.vocabulary import ManeuverType
from tests.laws import examples, share
from tests.test_symmetry import ON_FOOT, STREET, View, call, way

ROOT = Path(__file__).parent.parent
LANES = way(View(), 0, ManeuverType.STRAIGHT, 1)
FILE = """
{model}
map intersection(approach=80 m, lanes=2{street})
{line}
{signals}
environment({environment})
class Own(Car):
    {class_property}
behavior Acting(given):
    do IdleBehavior() for 0.05 s
    take {action}
behavior Asking(given):
    wait
    if {function}:
        wait
behavior Setting(given):
    wait
    {statement}
{wrapping}
ego = new Car before intersection by 30 m along {lanes}, {properties},
    with regionContainedIn None, with allowCollisions True
other = new Car before intersection by 60 m along {lanes}, with behavior {behavior}
third = new Own at (300, 0), facing 0 deg, with regionContainedIn None, with behavior Acting({given})
fourth = new Car at (500, 0), facing 0 deg, with regionContainedIn None, with behavior Asking({given})
fifth = new Car at (700, 0), facing 0 deg, with regionContainedIn None, with behavior Setting({given})
sixth = new Pedestrian at (800, 0), facing 0 deg, with regionContainedIn None{walk}
{end}
terminate after 0.2 s
"""
USUAL = {
    "environment": "light=1",
    "class_property": "width: 2 m",
    "action": "SetBrakeAction(0)",
    "function": "self.speed > 100 m/s",
    "statement": "wait",
    "properties": "with speed 3 m/s",
    "walk": "",
    "street": "",
    "signals": "signals(green=10 s)",
    "model": "",
    "end": "",
    "given": "0",
    "wrapping": "",
}
GIVEN = {"vehicle": "self", "car": "self", "color": '"red"', "side": '"left"'}
"""Arguments of functions that have neither a default nor a dimension."""
PLACED = "facing 0 deg, with regionContainedIn None, with allowCollisions True"
FIELD = "VectorField('F', lambda p: 1 rad)"
SEGMENTS = ("Arc", "Clothoid")
"""Functions whose numbers must be constants."""
OTHERS: Mapping[str, tuple[Domain, str, str]] = {
    "signals(green)": (Domain("`green` of the lights", TIME, 0.0, 1e5, above=True), "signals", "signals(green=@)"),
    "signals(yellow)": (Domain("`yellow` of the lights", TIME, 0.0, 1e5), "signals", "signals(yellow=@)"),
    "signals(all_red)": (Domain("`all_red` of the lights", TIME, 0.0, 1e5), "signals", "signals(all_red=@)"),
    "signals(offset)": (Domain("`offset` of the lights", TIME, -1e5, 1e5), "signals", "signals(offset=@)"),
    "share of steering": (Domain("`steer`", PURE, -1.0, 1.0), "action", "SetSteerAction(@)"),
    "speed of an object that appears": (PROPERTIES["speed"], "statement", "new Car at (0, 3 km), with speed @"),
    "do for": (Domain("the duration after `for`", TIME), "statement", "do IdleBehavior() for @"),
    "wait for": (Domain("the duration after `for`", TIME), "statement", "wait for @"),
    "do for steps": (Domain("the number of steps after `for`", PURE), "statement", "do IdleBehavior() for (@) steps"),
    "choose": (Domain("a weight", PURE), "statement", "do choose {IdleBehavior(): @, BrakeBehavior(): 1}"),
    "shuffle": (Domain("a weight", PURE), "statement", "do shuffle {IdleBehavior(): @, BrakeBehavior(): 1}"),
    "Normal": (Domain("the standard deviation", LENGTH, above=True), "end", "require Normal(0 m, @) < 1 km"),
    "TruncatedNormal": (
        Domain("the standard deviation", PURE, above=True),
        "end",
        "require TruncatedNormal(0, @, -1, 1) < 2",
    ),
    "circle": (
        Domain("`radius`", LENGTH, 0.0, 1e9, above=True),
        "end",
        f"new Car in CircularRegion((900, 0), @), {PLACED}",
    ),
    "radius of a sector": (
        Domain("`radius`", LENGTH, 0.0, 1e9, above=True),
        "end",
        f"new Car in SectorRegion((900, 0), @, 0 deg, 1 rad), {PLACED}",
    ),
    "angle of a sector": (
        Domain("`angle`", ANGLE, 0.0, math.tau, above=True),
        "end",
        f"new Car in SectorRegion((900, 0), 5 m, 0 deg, @), {PLACED}",
    ),
    "width of a rectangle": (
        Domain("`width`", LENGTH, 0.0, 1e9, above=True),
        "end",
        f"new Car in RectangularRegion((900, 0), 0 deg, @, 5 m), {PLACED}",
    ),
    "length of a rectangle": (
        Domain("`length`", LENGTH, 0.0, 1e9, above=True),
        "end",
        f"new Car in RectangularRegion((900, 0), 0 deg, 5 m, @), {PLACED}",
    ),
    "following a field": (
        Domain("the distance along a field", LENGTH, 0.0, 500.0),
        "end",
        f"new Car following {FIELD} from (900, 0) for @, {PLACED}",
    ),
    "before": (
        Domain("the distance before the intersection", LENGTH),
        "end",
        f"new Car before intersection by @ along {LANES}, with allowCollisions True",
    ),
    "meeting": (
        Domain("the time after `after`", TIME),
        "end",
        f"new Car meeting other at 0.5 after @, with speed 5 m/s, {PLACED}",
    ),
    "mutate": (Domain("the scale of `mutate`", PURE), "end", "mutate third by @"),
    "age": (MEASURED["age"], "walk", ", with age @"),
    "doorLength": (MEASURED["doorLength"], "end", f"new Car at (900, 0), {PLACED}, with doorLength @"),
    "visibleDistance of a place": (
        PROPERTIES["visibleDistance"],
        "end",
        f"new Car at (900, 0), {PLACED}\nspot = new Point at (899, 0), with visibleDistance @",
    ),
    "viewAngle of a place": (
        PROPERTIES["viewAngle"],
        "end",
        f"new Car at (900, 0), {PLACED}\nspot = new OrientedPoint at (899, 0), with viewAngle @",
    ),
}
"""Numbers that are no row of a table: their legal range, and the part of `FILE` in which `@` stands for the number."""


class End(NamedTuple):
    """A finite end of the legal range of a number, and the place where a file states the number."""

    place: str
    name: str
    domain: Domain
    is_upper: bool

    @property
    def value(self) -> float:
        return self.domain.high if self.is_upper else self.domain.low

    @property
    def is_open(self) -> bool:
        return self.domain.above and not self.is_upper

    def __str__(self) -> str:
        return f"{'upper' if self.is_upper else 'lower'} end of {self.domain.name} ({self.place} of {self.name})"


def _rows() -> Iterator[tuple[str, str, Domain]]:
    """Numbers with a dimension in the tables of properties, of the environment and of builtin names, and others."""
    for name, row in PROPERTIES.items():
        if not row.truth:
            yield "property", name, row
            yield "class", name, row
    for name, row in ENVIRONMENT.items():
        yield "environment", name, row
    for row in BUILTINS.values():
        for p in row.parameters:
            if p.dimension is not None and row.name not in SEGMENTS:
                yield row.kind.value, row.name, Domain(p.name, p.dimension, p.low, p.high)
    for name, (domain, part, _) in OTHERS.items():
        yield part, name, domain


ENDS = [end for row in _rows() for end in (End(*row, False), End(*row, True)) if np.isfinite(end.value)]
BOUNDED = {
    "constant": "{bad} * 1 {unit}",
    "Range": "Range({low}, {high}) * 1 {unit}",
    "DiscreteRange": "DiscreteRange({first}, {last}) * 1 {unit}",
    "Uniform": "Uniform({bad}, {good}) * 1 {unit}",
    "Discrete": "Discrete({{{bad}: 1, {good}: 2}}) * 1 {unit}",
    "TruncatedNormal": "TruncatedNormal({good}, 1, {low}, {high}) * 1 {unit}",
    "conditional": "({bad} * 1 {unit} if Range(0, 1) < 0.5 else {good} * 1 {unit})",
    "extremum": "{extremum}({bad}, Range({low} - 1, {high} + 1)) * 1 {unit}",
    "rounded": "{rounded}(Range({first}, {last})) * 1 {unit}",
    "param": "P * 1 {unit}",
    "whole param": "W * 1 {unit}",
    "param of options": "O * 1 {unit}",
    "argument": "given",
}
"""Forms whose bounds leave the range at one end: `bad` is outside, `good` inside, both between `low` and `high`."""
PARAMS = {
    "param": "param P = Range({low}, {high})",
    "whole param": "param W = VerifaiDiscreteRange({first}, {last})",
    "param of options": "param O = VerifaiOptions({bad}, {good})",
}
UNBOUNDED = {
    "Normal": "Normal({end}, 1) * 1 {unit}",
    "exponential": "({end} + {sign} * (1 - exp(Normal(0, 1)))) * 1 {unit}",
    "within rounding": "(Range({third_low}, {third_high}) + {sign} * 0.1 * 3) * 1 {unit}",
}
GIVEN_OUTSIDE = "Range({low}, {high}) * 1 {unit}"
"""Argument of a behavior that states the number as its parameter."""
IN_BEHAVIORS = ("behavior", "action", "function", "statement")
INSIDE = {
    "constant": "{inside} * 1 {unit}",
    "Range": "Range({inside_low}, {inside_high}) * 1 {unit}",
    "Uniform": "Uniform({inside}, {good}) * 1 {unit}",
    "param": "P * 1 {unit}",
    "param of options": "O * 1 {unit}",
}
"""Forms that reach the end of the range, or come near an end that is left out."""
PARAMS_INSIDE = {
    "param": "param P = Range({inside_low}, {inside_high})",
    "param of options": "param O = VerifaiOptions({inside}, {good})",
}

REFUSED = ("SCN433", "SCN506", "SCN634")
"""Codes of drawn numbers that are refused for another reason: constants are needed, or code becomes too long."""
OF_ONE_PLACE = ("SCN485", "SCN503")
"""Codes of constants outside the range of one number: the distance before an intersection, the deviation."""


def file(end: End, form: str, line: str = "", given: str = "0") -> str:
    """A scenario with a number in its place; `given` is what behaviors get as their argument of that name."""
    place, name, domain, _ = end
    arguments = {domain.name: form} if place == "behavior" else {}
    behavior = call(name if place == "behavior" else "FollowLaneBehavior", View(), LANES, "ego", "5 m/s", arguments)
    texts = {**USUAL, "line": line, "lanes": LANES, "behavior": behavior, "given": given}
    if form == "given" and place == "behavior":
        texts |= {"wrapping": f"behavior Wrapping(given):\n    do {behavior}", "behavior": f"Wrapping({given})"}
    if place == "behavior" and name in ON_FOOT:
        walk = f", with behavior {texts['behavior']}"
        texts |= {"behavior": "IdleBehavior()", "walk": walk, "street": f", {STREET}"}
    if place == "property":
        # The speed at the start, 0 here, is at most the top speed.
        texts["properties"] = f"with {name} {form}, " + ("with topSpeed 200 m/s" if name == "speed" else "with speed 0")
    elif place == "class":
        texts["class_property"] = f"{name}: {form}" + ("\n    topSpeed: 200 m/s" if name == "speed" else "")
    elif place == "distribution":
        texts["end"] = f"require {name}({form}) < 10 m/s"
    elif place == "environment":
        texts["environment"] = f"{name}={form}"
    elif name in OTHERS:
        texts[place] = OTHERS[name][2].replace("@", form)
        if name == "share of steering":
            texts["model"] = "model scenic.domains.driving.model"
    elif name.startswith("SetWalking"):
        texts["line"] += f"\nbehavior Walking(given):\n    take {name}({form})"
        texts["walk"] = f", with behavior Walking({given})"
    elif place == "action":
        others = [p.name for p in BUILTINS[name].parameters if p.default is None and p.name != domain.name]
        texts["action"] = (
            f"{name}({', '.join([f'{domain.name}={form}', *(f'{each}={GIVEN.get(each, 0)}' for each in others)])})"
        )
    elif place == "function":
        needed = [p.name for p in BUILTINS[name].parameters if p.default is None and p.name != domain.name]
        known = ", ".join(f"{each}={GIVEN[each]}" for each in needed)
        asked = f"{name}({known}, {domain.name}={form})"
        texts["statement" if name.startswith("set") else "function"] = asked
        if "Status" in name and not name.startswith("set"):
            texts["function"] += ' == "red"'
    return FILE.format(**texts)


def numbers(end: End) -> dict[str, object]:
    """What the forms are filled with."""
    domain, value, sign = end.domain, end.value, 1.0 if end.is_upper else -1.0
    bad = value if end.is_open else value + sign * max(1.0, 1e-6 * abs(value))
    good = value - sign * min(1.0, 0.5 * (domain.high - domain.low))
    whole = float(np.ceil(bad) if end.is_upper else np.floor(bad))
    inside = value - sign * 1e-6 if end.is_open else value
    inner, outer, whole_ends = sorted((inside, good)), sorted((bad, good)), sorted((int(whole), int(whole - 2 * sign)))
    third = sorted((value - sign, value - sign * 0.3))
    return {
        "bad": repr(bad), "good": repr(good), "end": repr(value), "inside": repr(inside), "sign": sign,
        "low": repr(outer[0]), "high": repr(outer[1]), "inside_low": repr(inner[0]), "inside_high": repr(inner[1]),
        "first": whole_ends[0], "last": whole_ends[1], "unit": si_word(domain.dimension) or "* 1",
        "third_low": repr(third[0]), "third_high": repr(third[1]),
        "extremum": "min" if end.is_upper else "max", "rounded": "ceil" if end.is_upper else "floor",
    }  # fmt: skip


def check_copies(text: str, scenes: int) -> int:
    """Compare every valid scene with its copy, bit for bit; return how many there are."""
    scenario = cx.compile_text(text)
    if "ExternalBehavior" in text:
        scenario = scenario.driven_by("python:examples.own_driver.planner:drive")
    drawn = scenario.sample(scenes, seed=3)
    outcomes = scenario.simulate(drawn)
    for row in np.flatnonzero(drawn.valid).tolist():
        copied = cx.compile_text(scenario.concrete(drawn, row))
        if scenario.config.driver is not None:
            copied = copied.driven_by("python:examples.own_driver.planner:drive")
        again = copied.scene_of_seed()  # of the stream that the copy names
        assert again.valid.all()
        of_copy = copied.simulate(again)
        for result in OUTCOMES:
            expected, found = getattr(outcomes, result.name)[row], getattr(of_copy, result.name)[0]
            np.testing.assert_array_equal(found, expected, err_msg=f"{result.name} of\n{text}")
    return int(drawn.valid.sum())


def code_of(text: str) -> str:
    """The code of the error in a file; the empty text without one."""
    try:
        cx.compile_text(text)
    except CompileError as error:
        return error.message[:6]
    return ""


OUTSIDE = [(end, form) for end, form in product(ENDS, BOUNDED) if form != "argument" or end.place in IN_BEHAVIORS]


@given(st.sampled_from(OUTSIDE))
@examples(160)
def test_a_value_whose_bounds_leave_its_range_is_an_error(case: tuple[End, str]) -> None:
    """At both ends, in every form; the message names the place, the range and a cure. An open end is outside."""
    end, form = case
    filled = numbers(end)
    given = GIVEN_OUTSIDE.format(**filled) if form == "argument" else "0"
    text = file(end, BOUNDED[form].format(**filled), PARAMS.get(form, "").format(**filled), given)
    with pytest.raises(CompileError) as raised:
        cx.compile_text(text)
    errors = [each for each in raised.value.diagnostics if each.severity is Severity.ERROR]
    assert {each.code for each in errors} <= {"SCN402", "SCN403", *OF_ONE_PLACE}, f"{form} as {end}\n{raised.value}"
    for each in errors:
        assert end.domain.name in each.message or each.code in OF_ONE_PLACE
        assert each.cure
        assert each.label.span.end > each.label.span.start > 0


@given(st.sampled_from(list(product(ENDS, INSIDE))))
@examples(80)
def test_a_value_up_to_the_end_of_its_range_compiles_and_runs(case: tuple[End, str]) -> None:
    """A closed end is a legal value, and a number next to an open end is, too."""
    end, form = case
    filled = numbers(end)
    text = file(end, INSIDE[form].format(**filled), PARAMS_INSIDE.get(form, "").format(**filled))
    if code_of(text) not in REFUSED:
        assert check_copies(text, 2) > 0, f"{form} as {end}"


@given(st.sampled_from(list(product(ENDS, UNBOUNDED))))
@examples(60)
def test_the_copy_of_a_scene_is_that_scene(case: tuple[End, str]) -> None:
    """Values without bounds are drawn again where they are outside, so that each copy compiles and runs alike."""
    end, form = case
    text = file(end, UNBOUNDED[form].format(**numbers(end)))
    # Rounding may meet an end that is left out.
    if code_of(text) not in ("SCN403", *REFUSED):
        assert check_copies(text, 3) > 0, f"{form} as {end}"


CHECKS = ("in_range", "known_number")
"""Functions that check the range of a number; numbers in the tables of properties are checked by `within`."""
CHECKED = {
    "acting.acts._duration": "do for",
    "acting.acts._weight": "choose",
    "acting.statements._count": "max_attempts",
    "acting.statements._setting": "time_step",
    "acting.statements._take_timestep": "timestep",
    "acting.statements.known_limit": "terminate after",
    "acting.statements.known_number": "terminate after steps",
    "evaluation.arguments.number_for": "SetThrottleAction",
    "evaluation.alignments._line_or": "line of a path",
    "evaluation.random_values.deviation_of": "Normal",
    "evaluation.calls.scenic_steering": "share of steering",
    "evaluation.making._measured": "age",
    "evaluation.objects.make": "speed of an object that appears",
    "evaluation.mutation._scale": "mutate",
    "evaluation.objects._own_view": "visibleDistance of a place",
    "evaluation.regions._length": "circle",
    "evaluation.regions._sector": "angle of a sector",
    "evaluation.relations._followed": "following a field",
    "evaluation.signals.time": "signals(green)",
    "evaluation.specifiers._along": "before",
    "evaluation.specifiers._meeting": "meeting",
}
"""Functions of `cortex_dsl.semantics` that check the range of a number, each with a number of these laws."""


def checking_functions() -> Iterator[str]:
    """Return the names of all functions with a call of a function that checks a range."""
    folder = ROOT / "cortex_dsl/semantics"
    for path in sorted(folder.rglob("*.py")):
        module = ".".join(path.relative_to(folder).with_suffix("").parts)
        for function in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(function, ast.FunctionDef):
                continue
            nested = {each for inner in function.body for each in ast.walk(inner) if isinstance(each, ast.FunctionDef)}
            hidden = {call for inner in nested for call in ast.walk(inner)}
            calls = (each for each in ast.walk(function) if isinstance(each, ast.Call) and each not in hidden)
            if any(isinstance(each.func, ast.Name) and each.func.id in CHECKS for each in calls):
                yield f"{module}.{function.name}"


def test_every_range_that_is_checked_is_in_a_law() -> None:
    """A new check fails here until one of the tables of this file has its number."""
    assert set(checking_functions()) == set(CHECKED)
    assert set(CHECKED.values()) <= {end.name for end in ENDS} | set(CONSTANTS)


ONE = "ego = new Car at (0, 0)\n"
PATH = "require Path(network.lanes[0].centerline.start, [{}]).length > 0 m"
COMPOSED = """scenario Main():
    setup:
        ego = new Car at (0, 0)
    compose:
        do Part()
scenario Part():
    setup:
        terminate after {}
"""
CONSTANTS: Mapping[str, tuple[str, str, str]] = {
    "weight of Discrete": (ONE + "require Discrete({{1: {}, 2: 1}}) < 3", "-1", "Range(1, 2)"),
    "weight of a param": ("param A = Discrete({{1: {}, 2: 1}})\n" + ONE, "-1", "Range(1, 2)"),
    "terminate after": (ONE + "terminate after {}", "0 s", "Range(1, 2) s"),
    "terminate after steps": (ONE + "terminate after {} steps", "0", "DiscreteRange(1, 2)"),
    "terminate after of a scenario": (
        COMPOSED,
        "0 s",
        "Range(1, 2) s",
    ),
    "terminate after steps of a scenario": (
        COMPOSED,
        "-1 steps",
        "Range(1, 2) steps",
    ),
    "time_step": ("simulation(time_step={})\n" + ONE, "2 s", "Range(0.1, 0.2) s"),
    "timestep": ("model scenic.domains.driving.model\nparam timestep = {}\n" + ONE, "2", "Range(0.1, 0.2)"),
    "line of a path": (ONE + PATH.format("{}"), "0 m", "Range(1, 2) m"),
    "radius of an arc": (ONE + PATH.format("Arc({}, angle=1 rad)"), "2e9 m", "Range(1, 2) m"),
    "angle of an arc": (ONE + PATH.format("Arc(9 m, angle={})"), "7 rad", "Range(1, 2) rad"),
    "length of an arc": (ONE + PATH.format("Arc(9 m, length={})"), "-1 m", "Range(1, 2) m"),
    "radius of a clothoid": (ONE + PATH.format("Clothoid({}, none, length=1 m)"), "-2e9 m", "Range(1, 2) m"),
    "max_attempts": ("simulation(max_attempts={})\n" + ONE, "0", "DiscreteRange(1, 2)"),
    "late": ("simulation(late={})\n" + ONE, "33", "DiscreteRange(1, 2)"),
    "probability": (ONE + "require[{}] ego.x < 1", "1.5", "Range(0.1, 0.2)"),
    "bound of a DiscreteRange": (ONE + "require DiscreteRange({}, 3) < 4", "4", "Range(1, 2)"),
    **{
        f"{name} of map {kind}": (
            f"map {kind}({stated})\n{ONE}",
            f"-1{unit}",
            f"DiscreteRange(3, 4){unit}",
        )
        for kind, names in MAP_ARGUMENTS.items()
        for name in names
        if kind not in ("opendrive", "lanelet2") and name not in TRUTHS
        for stated in [f"sidewalk=2 m, {name}=[{{}}]" if name == PLACES else f"{name}={{}}"]
        for unit in [" * 1 " + si_word(DIMENSIONS.get(name, LENGTH)) if name not in WHOLE else ""]
    },
}
"""Numbers that must be constants: a file with a place for one, a value outside its range, and a drawn value."""


@pytest.mark.parametrize("name", CONSTANTS)
def test_a_number_that_must_be_constant_has_its_range(name: str) -> None:
    """It is an error outside; a drawn value is an error even inside."""
    text, outside, drawn = CONSTANTS[name]
    assert code_of(text.format(outside)) in ("SCN402", "SCN411", "SCN422", "SCN501", "SCN509")
    assert code_of(text.format(drawn)) in ("SCN415", "SCN506")


SETTINGS_BY_CHOICE = (
    "{ONE}terminate after ({first} s if x == 'a' else {second} s)",
    "{ONE}terminate after ({first}0 if x == 'a' else {second}0) steps",
    "simulation(time_step=0.0{first} s if x == 'a' else 0.0{second} s)\n{ONE}",
    "simulation(max_attempts={first} if x == 'a' else {second})\n{ONE}",
    "simulation(max_time={first} s if x == 'a' else {second} s)\n{ONE}",
    "model scenic.domains.driving.model\nparam timestep = (0.0{first} if x == 'a' else 0.0{second})\n{ONE}",
    "map intersection(lanes={first} if x == 'a' else {second})\n{ONE}",
)


@pytest.mark.parametrize("text", SETTINGS_BY_CHOICE)
def test_a_choice_changes_neither_map_nor_settings(text: str) -> None:
    """All variants share them, so different ones are an error; equal ones are none."""
    differ, agree = (
        code_of("x = Uniform('a', 'b')\n" + text.format(ONE=ONE, first=first, second=2)) for first in (1, 2)
    )
    assert (differ, agree) == ("SCN415", "")


@pytest.mark.parametrize("distribution", ["Range({}, {}) * 1 m", "TruncatedNormal(0, 1, {}, {}) * 1 m"])
def test_drawn_bounds_of_a_distribution_are_in_order(distribution: str) -> None:
    """Bounds that are always reversed are an error, as constants are; others are drawn again."""
    text = "X = {}\nego = new Car at (0, 0)\nother = new Car at (X, 30 m)"
    assert code_of(text.format(distribution.format("Range(2, 3)", "Range(0, 1)"))) == "SCN501"
    kept = cx.compile_text(text.format(distribution.format("Range(0, 1)", "Range(1, 2)"))).program.requirements
    assert not [each.name for each in kept if "order" in each.name]
    low, high = "Normal(0, 1)", "Range(-1, 1)"
    scenario = cx.compile_text(f"low = {low}\nhigh = {high}\n" + text.format(distribution.format("low", "high")))
    scenes = scenario.sample(50, seed=1)
    assert scenes.valid.all()
    assert scenes.failed.sum() > 10
    x = np.asarray(scenario.table(scenes)["other.x [m]"], dtype=float)
    assert x.max() <= 1.0


@pytest.mark.parametrize("example", sorted((ROOT / "examples").glob("*.scn")), ids=lambda path: path.stem)
def test_the_copies_of_examples_are_their_scenes(example: Path) -> None:
    """Of every example of the first folder."""
    assert check_copies(example.read_text(encoding="utf-8"), share(4)) >= 2


@pytest.mark.parametrize("code", ["SCN402", "SCN403"])
def test_arguments_are_checked_where_nothing_depends_on_them(code: str) -> None:
    """An emergency brake that is alone never asks how late it is."""
    delay = {"SCN402": "-1 s", "SCN403": "Range(-1, 1) s"}[code]
    brake = f"EmergencyBrakeBehavior(IdleBehavior(), delay={delay})"
    assert code_of(f"ego = new Car at (0, 0), with behavior {brake}") == code


@pytest.mark.parametrize(
    "width",
    ["DiscreteRange(1, 20) * 1 m", "Range(0.5, 20) * 1 m", "Uniform(1, 20) * 1 m", "Normal(1, 1) * 1 m"],
)
def test_a_value_that_stays_in_its_range_is_none(width: str) -> None:
    """Up to its very end."""
    assert cx.compile_text(f"ego = new Car at (0, 0), with width {width}").program


def test_a_number_that_is_drawn_outside_is_drawn_again() -> None:
    """The requirement is named by the argument, and counted."""
    text = "ego = new Car at (0, 0), with behavior ConstantSpeedBehavior(Normal(0, 5) m/s)"
    scenes = (scenario := cx.compile_text(text)).sample(50, seed=1)
    assert scenario.program.requirements[0].name == "speed within its domain"
    assert scenes.valid.all()
    assert scenes.failed[:, 0].sum() > 10

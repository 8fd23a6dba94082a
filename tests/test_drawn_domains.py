"""What is drawn lies in its legal range, and the concrete copy of every scene is that scene.

A copy holds each drawn value as a constant, and a constant outside its range is an error. So a value whose bounds leave
the range is an error too, one without bounds is drawn again, and a scene whose copy does not compile does not exist.
"""

from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cortex_dsl as cx
from cortex_dsl.diagnostics import CompileError, Severity
from cortex_dsl.semantics.names.builtins import BUILTINS
from cortex_dsl.semantics.names.properties import ENVIRONMENT, PROPERTIES, Domain
from cortex_dsl.semantics.quantities.units import si_word
from engine.outcomes import OUTCOMES
from engine.vocabulary import ManeuverType
from tests.laws import examples, share
from tests.test_symmetry import View, call, way

ROOT = Path(__file__).parent.parent
LANES = way(View(), 0, ManeuverType.STRAIGHT, 1)
FILE = """
map intersection(approach=80 m, lanes=2)
signals(green=10 s)
{line}
environment({environment})
class Own(Car):
    {class_property}
behavior Acting():
    do IdleBehavior() for 0.05 s
    take {action}
behavior Asking():
    wait
    if {function}:
        wait
behavior Setting():
    wait
    {setter}
ego = new Car before intersection by 30 m along {lanes}, {properties},
    with regionContainedIn None, with allowCollisions True
other = new Car before intersection by 60 m along {lanes}, with behavior {behavior}
third = new Own at (300, 0), facing 0 deg, with regionContainedIn None, with behavior Acting()
fourth = new Car at (500, 0), facing 0 deg, with regionContainedIn None, with behavior Asking()
fifth = new Car at (700, 0), facing 0 deg, with regionContainedIn None, with behavior Setting()
sixth = new Pedestrian at (800, 0), facing 0 deg, with regionContainedIn None{walk}
terminate after 0.2 s
"""
USUAL = {
    "environment": "light=1",
    "class_property": "width: 2 m",
    "action": "SetBrakeAction(0)",
    "function": "self.speed > 100 m/s",
    "setter": "wait",
    "properties": "with speed 3 m/s",
    "walk": "",
}
GIVEN = {"vehicle": "self", "car": "self", "color": '"red"'}
"""Arguments of functions that have neither a default nor a dimension."""


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
    """Every number with a dimension in the tables of properties, of the environment and of builtin names."""
    for name, row in PROPERTIES.items():
        if not row.truth:
            yield "property", name, row
            yield "class", name, row
    for name, row in ENVIRONMENT.items():
        yield "environment", name, row
    for row in BUILTINS.values():
        for p in row.parameters:
            if p.dimension is not None:
                yield row.kind.value, row.name, Domain(p.name, p.dimension, p.low, p.high)


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

CONSTANTS = ("SCN506", "SCN634")
"""Codes of drawn numbers where only constants are allowed: the times of a controller."""


def file(end: End, form: str, line: str = "") -> str:
    """A scenario with a number in its place."""
    place, name, domain, _ = end
    arguments = {domain.name: form} if place == "behavior" else {}
    behavior = call(name if place == "behavior" else "FollowLaneBehavior", View(), LANES, "ego", "5 m/s", arguments)
    texts = {**USUAL, "line": line, "lanes": LANES, "behavior": behavior}
    if place == "property":
        # The speed at the start, 0 here, is at most the top speed.
        texts["properties"] = f"with {name} {form}, " + ("with topSpeed 200 m/s" if name == "speed" else "with speed 0")
    elif place == "class":
        texts["class_property"] = f"{name}: {form}" + ("\n    topSpeed: 200 m/s" if name == "speed" else "")
    elif place == "environment":
        texts["environment"] = f"{name}={form}"
    elif name.startswith("SetWalking"):
        texts["line"] += f"\nbehavior Walking():\n    take {name}({form})"
        texts["walk"] = ", with behavior Walking()"
    elif place == "action":
        texts["action"] = f"{name}({form})"
    elif place == "function":
        needed = [p.name for p in BUILTINS[name].parameters if p.default is None and p.name != domain.name]
        known = ", ".join(f"{each}={GIVEN[each]}" for each in needed)
        asked = f"{name}({known}, {domain.name}={form})"
        texts["setter" if name.startswith("set") else "function"] = asked
        if "Status" in name and not name.startswith("set"):
            texts["function"] += ' == "red"'
    return FILE.format(**texts)


def numbers(end: End) -> dict[str, object]:
    """What the forms are filled with."""
    domain, value, sign = end.domain, end.value, 1.0 if end.is_upper else -1.0
    bad = value if end.is_open else value + sign
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


@given(st.sampled_from(list(product(ENDS, BOUNDED))))
@examples(160)
def test_a_value_whose_bounds_leave_its_range_is_an_error(case: tuple[End, str]) -> None:
    """At both ends, in every form; the message names the place, the range and a cure. An open end is outside."""
    end, form = case
    filled = numbers(end)
    text = file(end, BOUNDED[form].format(**filled), PARAMS.get(form, "").format(**filled))
    with pytest.raises(CompileError) as raised:
        cx.compile_text(text)
    errors = [each for each in raised.value.diagnostics if each.severity is Severity.ERROR]
    assert {each.code for each in errors} <= {"SCN402", "SCN403"}, f"{form} as {end}\n{raised.value}"
    for each in errors:
        assert end.domain.name in each.message
        assert each.cure
        assert each.label.span.end > each.label.span.start > 0


@given(st.sampled_from(list(product(ENDS, INSIDE))))
@examples(120)
def test_a_value_up_to_the_end_of_its_range_compiles_and_runs(case: tuple[End, str]) -> None:
    """A closed end is a legal value, and a number next to an open end is, too."""
    end, form = case
    filled = numbers(end)
    text = file(end, INSIDE[form].format(**filled), PARAMS_INSIDE.get(form, "").format(**filled))
    if code_of(text) not in CONSTANTS:
        assert check_copies(text, 2) > 0, f"{form} as {end}"


@given(st.sampled_from(list(product(ENDS, UNBOUNDED))))
@examples(60)
def test_the_copy_of_a_scene_is_that_scene(case: tuple[End, str]) -> None:
    """Values without bounds are drawn again where they are outside, so that each copy compiles and runs alike."""
    end, form = case
    text = file(end, UNBOUNDED[form].format(**numbers(end)))
    # Rounding may meet an end that is left out.
    if code_of(text) not in ("SCN403", *CONSTANTS):
        assert check_copies(text, 3) > 0, f"{form} as {end}"


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

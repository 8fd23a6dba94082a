"""What is drawn lies in its legal range, and the concrete copy of every scene is that scene.

A copy holds each drawn value as a constant, and a constant outside its range is an error. So a value whose bounds leave
the range is an error too, one without bounds is drawn again, and a scene whose copy does not compile does not exist.
"""

from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cortex_dsl as cx
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.semantics.names.builtins import BUILTINS, Kind
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
{line}
environment({environment})
ego = new Car before intersection by 30 m along {lanes}, {properties}
other = new Car before intersection by 60 m along {lanes}, with behavior {behavior}
terminate after 0.2 s
"""

Row = tuple[str, str, Domain]
"""Where a number stands, of what, and its legal range."""


def _rows() -> list[Row]:
    properties = [("property", name, row) for name, row in PROPERTIES.items() if not row.truth]
    environment = [("environment", name, row) for name, row in ENVIRONMENT.items()]
    arguments = [
        ("argument", row.name, Domain(p.name, p.dimension, p.low, p.high))
        for row in BUILTINS.values()
        if row.kind is Kind.BEHAVIOUR
        for p in row.parameters
        if p.dimension is not None
    ]
    return [*properties, *environment, *arguments]


ROWS = _rows()
BOUNDED = {
    "constant": "{bad} * 1 {unit}",
    "Range": "Range({bad}, {good}) * 1 {unit}",
    "DiscreteRange": "DiscreteRange({whole}, {more}) * 1 {unit}",
    "Uniform": "Uniform({bad}, {good}) * 1 {unit}",
    "Discrete": "Discrete({{{bad}: 1, {good}: 2}}) * 1 {unit}",
    "TruncatedNormal": "TruncatedNormal({good}, 1, {bad}, {good} + 1) * 1 {unit}",
    "conditional": "({bad} * 1 {unit} if Range(0, 1) < 0.5 else {good} * 1 {unit})",
    "maximum": "max({bad}, Range({bad} - 1, {good})) * 1 {unit}",
    "rounded down": "floor(Range({whole}, {more})) * 1 {unit}",
    "param": "P * 1 {unit}",
    "whole param": "W * 1 {unit}",
    "param of options": "O * 1 {unit}",
}
"""Forms whose bounds leave the range, by its lower end: `bad` is outside, `good` inside."""
PARAMS = {
    "param": "param P = Range({bad}, {good})",
    "whole param": "param W = VerifaiDiscreteRange({whole}, {more})",
    "param of options": "param O = VerifaiOptions({bad}, {good})",
}
UNBOUNDED = {
    "Normal": "Normal({low}, 1) * 1 {unit}",
    "exponential": "(exp(Normal(0, 1)) - 1 + {low}) * 1 {unit}",
    "within rounding": "(Range({low} + 0.3, {low} + 1) - 0.1 * 3) * 1 {unit}",
}


def file(row: Row, form: str, line: str = "") -> str:
    """A scenario with a number in its place."""
    place, name, domain = row
    properties = f"with {name} {form}" if place == "property" else "with speed 0 m/s"
    given = {domain.name: form} if place == "argument" else {}
    behavior = call(name if place == "argument" else "FollowLaneBehavior", View(), LANES, "ego", "5 m/s", given)
    environment = f"{name}={form}" if place == "environment" else "light=1"
    return FILE.format(line=line, environment=environment, lanes=LANES, properties=properties, behavior=behavior)


def numbers(domain: Domain) -> dict[str, object]:
    """What the forms are filled with."""
    bad = domain.low if domain.above else domain.low - 1.0
    good = min(domain.low + 1.0, domain.high)
    unit = si_word(domain.dimension) or "* 1"
    whole = int(np.floor(bad))
    return {"bad": bad, "good": good, "low": domain.low, "unit": unit, "whole": whole, "more": whole + 2}


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
        again = copied.sample(1, seed=0)
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


def described(row: Row, form: str) -> str:
    place, name, domain = row
    return f"{form} as {domain.name} ({place} of {name})"


@given(st.sampled_from(list(product(ROWS, BOUNDED))))
@examples(160)
def test_a_value_whose_bounds_leave_its_range_is_an_error(case: tuple[Row, str]) -> None:
    """In every form; an end that is left out counts as outside."""
    row, form = case
    filled = numbers(row[2])
    if not np.isfinite(row[2].low):
        return
    text = file(row, BOUNDED[form].format(**filled), PARAMS.get(form, "").format(**filled))
    assert code_of(text) in ("SCN402", "SCN403"), described(row, form)


@given(st.sampled_from(list(product(ROWS, UNBOUNDED))))
@examples(60)
def test_the_copy_of_a_scene_is_that_scene(case: tuple[Row, str]) -> None:
    """Values without bounds are drawn again where they are outside, so that each copy compiles and runs alike."""
    row, form = case
    if not np.isfinite(row[2].low):
        return
    text = file(row, UNBOUNDED[form].format(**numbers(row[2])))
    # The times of a controller are constants, and rounding may meet an end that is left out.
    if code_of(text) not in ("SCN403", "SCN506"):
        assert check_copies(text, 3) > 0, described(row, form)


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

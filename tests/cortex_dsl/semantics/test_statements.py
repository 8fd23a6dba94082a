"""Statements of the top level: what a mistake leaves behind, and the limits of what is set."""

from collections.abc import Callable

import pytest

from cortex_dsl import ir
from cortex_dsl.semantics.acting.statements import IDLE_PARAMS, MAP_PARAMS

Said = Callable[..., list[str]]


def errors_of(codes: list[str]) -> list[str]:
    """Without hints about names that nothing reads."""
    return [code for code in codes if code not in ("SCN223", "SCN211")]


@pytest.mark.parametrize(
    "text",
    [
        "x = ego.nothing\ny = x + 1 m\nrequire y > 2 m\n",
        "a, b = ego.nothing\nrequire a > b\n",
        "x = 1\nx += ego.nothing\nrequire x > 2\n",
    ],
)
def test_a_mistake_is_reported_once(said: Said, text: str) -> None:
    """The names of a statement that failed are poisoned, so that their uses say nothing more."""
    assert len(errors_of(said(text))) == 1


@pytest.mark.parametrize(
    ("setting", "legal"),
    [
        ("time_step=0.0001 s", True),
        ("time_step=0.00009 s", False),
        ("time_step=1 s", True),
        ("time_step=1.01 s", False),
        ("max_time=0.0001 s", True),
        ("max_time=100000 s", True),
        ("max_time=100001 s", False),
        ("max_attempts=1", True),
        ("max_attempts=0", False),
        ("max_attempts=1000000000", True),
        ("max_attempts=1000000001", False),
    ],
)
def test_settings_have_limits(said: Said, setting: str, legal: bool) -> None:
    """The ends themselves are legal, what lies beyond is not."""
    assert errors_of(said(f"simulation({setting})\n")) == ([] if legal else ["SCN402"])


@pytest.mark.parametrize(
    ("amount", "legal"),
    [("1 steps", True), ("0 steps", False), ("1000000000 steps", True), ("0.0001 s", True), ("100001 s", False)],
)
def test_a_run_ends_within_limits(said: Said, amount: str, legal: bool) -> None:
    """`terminate after` takes as little and as much as a setting does."""
    assert errors_of(said(f"terminate after {amount}\n")) == ([] if legal else ["SCN402"])


def test_steps_become_a_time(compiled: Callable[..., ir.Scenario]) -> None:
    """Of the step that the file sets, wherever it sets it."""
    assert compiled("terminate after 30 steps\nsimulation(time_step=0.1 s)\n").settings.max_time == pytest.approx(3.0)


@pytest.mark.parametrize(("probability", "code"), [("0", "SCN422"), ("1.5", "SCN422"), ("1", None), ("0.001", None)])
def test_the_probability_of_a_requirement(said: Said, probability: str, code: str | None) -> None:
    """Above 0, and 1 at most."""
    found = errors_of(said(f"param A = Range(0, 1)\nrequire[{probability}] A > 0.5\n"))
    assert found == ([] if code is None else [code])


@pytest.mark.parametrize("name", sorted(IDLE_PARAMS | (MAP_PARAMS - {"map"})))
def test_params_of_other_simulators_are_named(said: Said, name: str) -> None:
    """A Scenic script may set them; nothing here reads them."""
    assert "SCN444" in said(f"param {name} = 3\n")


@pytest.mark.parametrize(
    ("text", "codes"),
    [
        ('"a text"\n', []),
        ("new Car on road\n", []),
        ("ego.speed\n", ["SCN440"]),
        ("3 > 2\n", ["SCN440"]),
        ("ego = 3\n", ["SCN405"]),
        ("ego = new Car on road\n", ["SCN212"]),
        ("terminate when 2 > 1\n", ["SCN446"]),
        ("terminate when 1 > 2\n", []),
        ("simulation(scenario=3)\n", ["SCN428"]),
        ("simulation(timestep=0.1 s)\n", ["SCN205"]),
    ],
)
def test_what_is_said_of_a_statement(said: Said, text: str, codes: list[str]) -> None:
    """One answer each."""
    assert errors_of(said(text)) == codes

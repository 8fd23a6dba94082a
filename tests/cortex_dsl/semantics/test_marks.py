"""What variants have in common is run once, and nobody can tell."""

from collections.abc import Callable

import pytest

from cortex_dsl import ir
from cortex_dsl.semantics.acting import statements
from cortex_dsl.semantics.model.marks import Marks
from cortex_dsl.semantics.printing import expressions_of, format_ir
from cortex_dsl.semantics.quantities.bounds import parts
from cortex_dsl.source import Span

Compiled = Callable[..., ir.Scenario]

CHOICES = """\
map intersection(ways=4)
param SPEED = Range(5, 10) m/s
behavior Drive(v):
    do FollowLaneBehavior(target_speed=v)
kept = [1]
start = Uniform(*intersection.incomingLanes)
kept.append(2)
gap = Range(0, 5) m
turn = Uniform(*start.maneuvers)
if turn.type is ManeuverType.STRAIGHT:
    word = Uniform('a', 'b')
    kept.append(3)
gap = gap + len(kept) * 1 m
place = new OrientedPoint in start.centerline
ego = new Car at place, with behavior Drive(SPEED)
require (distance from ego to intersection) > gap
"""

FUNCTIONS = """\
map intersection(ways=4)
def collector():
    items = [0]
    return [lambda item: items.append(item), lambda: len(items)]
add, size = collector()
add(1)
which = Uniform('a', 'b', 'c')
add(2)
lane = Uniform(*intersection.incomingLanes)
ego = new Car in lane.centerline
require size() * 1 m < (distance from ego to intersection)
"""


def places(scenario: ir.Scenario) -> list[tuple[str, Span]]:
    """Where each expression of each variant stands."""
    roots = (root for variant in scenario.variants for root in expressions_of(tuple(vars(variant).values())))
    return [(type(each).__name__, each.span) for root in roots for each in parts(root)]


def unmarked(run: Compiled, text: str, monkeypatch: pytest.MonkeyPatch) -> ir.Scenario:
    with monkeypatch.context() as patch:
        patch.setattr(Marks, "put", lambda *_: None)
        return run(text)


@pytest.mark.parametrize("text", [CHOICES, FUNCTIONS], ids=["choices", "a list that outlives its call"])
def test_variants_are_as_if_each_was_run_from_the_beginning(
    text: str, alone: Compiled, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Expressions, numbers of draws, choices and places alike; variables and lists are those of their own variant."""
    marked, plain = alone(text), unmarked(alone, text, monkeypatch)
    assert len(marked.variants) >= 12
    assert format_ir(marked) == format_ir(plain)
    assert places(marked) == places(plain)


def test_what_stands_above_a_choice_is_run_once(alone: Compiled, monkeypatch: pytest.MonkeyPatch) -> None:
    """Params are read once, whatever the number of variants."""
    met: list[str] = []
    read = statements.param_value
    monkeypatch.setattr(statements, "param_value", lambda ev, entry: (met.append(entry.name), read(ev, entry))[1])
    alone(CHOICES)
    assert met == ["SPEED"]
    met.clear()
    unmarked(alone, CHOICES, monkeypatch)
    assert len(met) >= 12

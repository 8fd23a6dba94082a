"""Guards of behaviours, and choices among behaviours that look at them."""

from collections.abc import Callable

import pytest

from cortex_dsl import ir
from cortex_dsl.semantics.acting.yielding import everything
from engine.opcodes import Op
from engine.vocabulary import RuleKind

Compiled = Callable[..., ir.Scenario]
Said = Callable[..., list[str]]

GUARDED = """\
behavior Calm(limit):
    precondition: self.speed < 20 m/s
    invariant: self.speed < limit
    do BrakeBehavior()
    wait
"""


@pytest.fixture
def acts(compiled: Compiled) -> Callable[..., tuple[ir.Block, ir.Variant]]:
    """The acts of the behaviour of a second car, and its variant."""

    def block(text: str, call: str = "B()") -> tuple[ir.Block, ir.Variant]:
        variant = compiled(f"{text}\nother = new Car behind ego by 5 m, with behavior {call}\n").variants[0]
        behaviour = variant.actors[1].behaviour
        assert behaviour is not None
        return behaviour, variant

    return block


Acts = Callable[..., tuple[ir.Block, ir.Variant]]


def test_preconditions_are_tested_before_the_behaviour(acts: Acts) -> None:
    """A demand, then the scope with its invariants."""
    (demand, scope), variant = acts(GUARDED, "Calm(9 m/s)")
    assert isinstance(demand, ir.Demand)
    assert isinstance(scope, ir.Scope)
    ((holds, rule),) = scope.invariants
    assert isinstance(holds, ir.Apply)
    names = [variant.rules[number].name for number in (demand.rule, rule)]
    assert names == ["precondition of Calm: self.speed < 20 m/s", "invariant of Calm: self.speed < limit"]
    assert [variant.rules[number].line for number in (demand.rule, rule)] == [5, 6]
    assert {variant.rules[number].kind for number in (demand.rule, rule)} == {RuleKind.ABORT}


def test_what_a_guarded_behaviour_does_is_a_scope(acts: Acts) -> None:
    """Library behaviours too: the invariants rest while they run."""
    (_, scope), _ = acts(GUARDED, "Calm(9 m/s)")
    assert isinstance(scope, ir.Scope)
    inner, last = scope.body
    assert isinstance(inner, ir.Scope)
    assert (inner.name, inner.invariants) == ("BrakeBehavior", ())
    assert isinstance(last, ir.Wait)


def test_guards_see_what_the_behaviour_is_given(acts: Acts) -> None:
    """A parameter that changes during the run is read from its local, which is set before the tests."""
    text = (
        GUARDED + "behavior B():\n    n = 1\n    while True:\n        n = n + 1\n        do Calm(n * 3 m/s) for 1 s\n"
    )
    block, _ = acts(text)
    (attempt,) = [act for act in everything(block) if isinstance(act, ir.TryInterrupt)]
    first, demand, scope = attempt.body
    assert isinstance(first, ir.SetLocal)
    assert isinstance(demand, ir.Demand)
    assert isinstance(scope, ir.Scope)
    limit = scope.invariants[0][0]
    assert isinstance(limit, ir.Apply)
    assert any(isinstance(part, ir.Local) and part.index == first.index for part in limit.arguments)


def test_handlers_begin_with_the_invariants(acts: Acts) -> None:
    """Where a handler starts or an `until` comes true, the behaviour itself goes on."""
    text = "behavior B():\n    invariant: self.speed < 9 m/s\n    do IdleBehavior() until self.speed < 3 m/s\n"
    text += "    try:\n        wait\n    interrupt when self.speed < 1 m/s:\n        take SetBrakeAction(1)\n"
    block, _ = acts(text)
    attempts = [act for act in everything(block) if isinstance(act, ir.TryInterrupt)]
    handlers = [[type(act).__name__ for act in handler] for attempt in attempts for _, handler in attempt.handlers]
    assert handlers == [["Demand", "Abort"], ["Demand", "Take"]]


# -- do choose, do shuffle --------------------------------------------------------------------------------------------


def pick_of(block: ir.Block) -> ir.Pick:
    (found,) = [act for act in everything(block) if isinstance(act, ir.Pick)]
    return found


def test_choose_weighs_its_options(acts: Acts) -> None:
    """Weights as written; without a dictionary all are alike."""
    block, variant = acts("behavior B():\n    do choose {IdleBehavior(): 1, BrakeBehavior(0.3): 2.5}\n")
    pick = pick_of(block)
    assert [option.weight.value for option in pick.options if isinstance(option.weight, ir.Literal)] == [1.0, 2.5]
    assert not pick.shuffle
    assert variant.rules[pick.rule].name == "do choose in B: no option may start"
    assert variant.rules[pick.rule].kind == RuleKind.ABORT
    block, _ = acts("behavior B():\n    do shuffle IdleBehavior(), BrakeBehavior(0.3)\n")
    assert pick_of(block).shuffle
    assert {option.weight for option in pick_of(block).options} == {pick_of(block).options[0].weight}


def test_a_weight_may_be_searched(acts: Acts) -> None:
    """A gene may say how likely an option is."""
    text = "param P = Range(0, 1)\nbehavior B():\n    do choose {IdleBehavior(): P, BrakeBehavior(): 1 - P}\n"
    first, second = pick_of(acts(text)[0]).options
    assert isinstance(first.weight, ir.Gene)
    assert isinstance(second.weight, ir.Apply)


def test_only_allowed_options_take_part(acts: Acts) -> None:
    """An option is allowed while all its guards hold; they are not tested twice at its start."""
    text = GUARDED + "behavior B():\n    do choose Calm(9 m/s), IdleBehavior()\n"
    calm, idle = pick_of(acts(text)[0]).options
    assert isinstance(calm.allowed, ir.Apply)
    assert calm.allowed.op == Op.AND
    assert not any(isinstance(act, ir.Demand) for act in everything(calm.body))
    assert isinstance(idle.allowed, ir.Literal)
    assert idle.allowed.value == 1.0


def test_arguments_are_worked_out_first(acts: Acts) -> None:
    """Every option's, before any is taken: its guards need them."""
    text = GUARDED + "behavior B():\n    do shuffle Calm(self.speed), Calm(2 * self.speed)\n"
    ((scope),), _ = acts(text)
    assert isinstance(scope, ir.Scope)
    assert [type(act).__name__ for act in scope.body] == ["SetLocal", "SetLocal", "Pick"]


def test_until_holds_for_the_whole(acts: Acts) -> None:
    """`do choose … until c` ends whatever was chosen."""
    text = "behavior B():\n    do shuffle IdleBehavior(), BrakeBehavior() until self.speed < 1 m/s\n"
    ((scope),), _ = acts(text)
    assert isinstance(scope, ir.Scope)
    (attempt,) = scope.body
    assert isinstance(attempt, ir.TryInterrupt)
    assert isinstance(attempt.body[-1], ir.Pick)


@pytest.mark.parametrize(
    ("options", "codes"),
    [
        ("IdleBehavior(), BrakeBehavior()", []),
        ("{IdleBehavior(): 0, BrakeBehavior(): 1}", []),
        ("{IdleBehavior(): -1, BrakeBehavior(): 2}", ["SCN402"]),
        ("{IdleBehavior(): 0, BrakeBehavior(): 0}", ["SCN627"]),
        ("{IdleBehavior(): 1 m, BrakeBehavior(): 2}", ["SCN301"]),
        ("IdleBehavior()", ["SCN626"]),
        ("IdleBehavior(), 3", ["SCN604"]),
    ],
)
def test_options(said: Said, options: str, codes: list[str]) -> None:
    """What is wrong with options is said, each mistake once."""
    text = f"behavior B():\n    do choose {options} for 3 s\n"
    assert said(text + "other = new Car behind ego by 5 m, with behavior B()\n") == codes


def test_a_choice_in_a_loop_acts(said: Said) -> None:
    """Whatever is chosen ends the turn, so the loop goes on in time."""
    text = "behavior B():\n    while True:\n        do choose IdleBehavior(), BrakeBehavior() for 1 s\n"
    assert said(text + "other = new Car behind ego by 5 m, with behavior B()\n") == []

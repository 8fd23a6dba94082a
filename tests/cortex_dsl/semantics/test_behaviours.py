"""Behaviours as acts: inlining, interrupts, locals, and what is evaluated when."""

from collections.abc import Callable

import pytest

from cortex_dsl import ir
from cortex_dsl.semantics.acting.yielding import everything
from engine.opcodes import Op
from engine.vocabulary import Command, State

Compiled = Callable[..., ir.Scenario]
Said = Callable[..., list[str]]


@pytest.fixture
def acts(compiled: Compiled) -> Callable[..., ir.Block]:
    """Acts of the behaviour `B` of a second car."""

    def block(text: str, call: str = "B()") -> ir.Block:
        scenario = compiled(f"{text}\nother = new Car behind ego by 5 m, with behavior {call}\n")
        behaviour = scenario.variants[0].actors[1].behaviour
        assert behaviour is not None
        return behaviour

    return block


def body(block: ir.Block) -> ir.Block:
    """What is inside the scope of an inlined behaviour."""
    (scope,) = block
    assert isinstance(scope, ir.Scope)
    return scope.body


def kinds(block: ir.Block) -> list[str]:
    return [type(act).__name__ for act in block]


Acts = Callable[..., ir.Block]


def test_do_until_is_a_try_that_aborts(acts: Acts) -> None:
    """`do B until C` = try: do B, interrupt when C: abort."""
    (attempt,) = body(acts("behavior B():\n    do IdleBehavior() until self.speed < 1\n"))
    assert isinstance(attempt, ir.TryInterrupt)
    assert kinds(attempt.body) == ["Loop"]
    ((_, handler),) = attempt.handlers
    assert kinds(handler) == ["Abort"]


def test_do_for_starts_a_clock(acts: Acts) -> None:
    """`do B for T` notes the time, then runs until T has passed."""
    clock, attempt = body(acts("behavior B():\n    do IdleBehavior() for 2 s\n"))
    assert isinstance(clock, ir.SetLocal)
    assert isinstance(clock.value, ir.Apply)
    assert clock.value.op == Op.TIME
    assert isinstance(attempt, ir.TryInterrupt)
    assert isinstance(attempt.handlers[0][0], ir.Apply)
    assert attempt.handlers[0][0].op == Op.LE


def test_handlers_keep_the_order_of_the_file(acts: Acts) -> None:
    """Which one wins is for the lowering."""
    text = "behavior B():\n    try:\n        wait\n    interrupt when self.speed > 1:\n        take SetBrakeAction(1)\n"
    text += "    interrupt when self.speed > 2:\n        abort\n"
    (attempt,) = body(acts(text))
    assert isinstance(attempt, ir.TryInterrupt)
    assert [kinds(handler) for _, handler in attempt.handlers] == [["Take"], ["Abort"]]


def test_conditions_read_the_running_simulation(acts: Acts) -> None:
    """`self` is the actor, and its speed the current one."""
    (loop,) = body(acts("behavior B():\n    while self.speed > 3:\n        wait\n"))
    assert isinstance(loop, ir.Loop)
    assert isinstance(loop.condition, ir.Apply)
    state = loop.condition.arguments[1]
    assert isinstance(state, ir.Apply)
    assert (state.op, state.immediates) == (Op.STATE, (1, int(State.SPEED)))


def test_numbers_that_change_are_locals(acts: Acts) -> None:
    """A counter is set and read back; what is assigned once and never changes needs no local."""
    text = "behavior B():\n    n = 0\n    limit = 3\n    while n < limit:\n        n += 1\n        wait\n"
    block = body(acts(text))
    assert kinds(block) == ["SetLocal", "Loop"]
    assert kinds(block[1].body) == ["SetLocal", "Wait"]  # type: ignore[attr-defined]


def test_positions_are_remembered(acts: Acts) -> None:
    """`start = self.position` keeps where it was, not where it is."""
    text = "behavior B():\n    start = self.position\n    do IdleBehavior() until (distance from self to start) > 5 m\n"
    block = body(acts(text))
    assert kinds(block) == ["SetLocal", "SetLocal", "TryInterrupt"]


def test_arguments_are_evaluated_at_the_do(acts: Acts) -> None:
    """A speed passed on is the speed at that moment."""
    text = "behavior A(v):\n    do ConstantSpeedBehavior(v)\nbehavior B():\n    wait\n    do A(self.speed / 2)\n"
    _, argument, scope = body(acts(text))
    assert isinstance(argument, ir.SetLocal)
    assert isinstance(scope, ir.Scope)
    assert kinds(scope.body) == ["SetLocal", "HoldSpeed"]


def test_static_arguments_stay_expressions(acts: Acts) -> None:
    """What is settled with the scene needs no local."""
    assert kinds(body(acts("behavior B(v, w=2 m/s):\n    do ConstantSpeedBehavior(v + w)\n", "B(3 m/s)"))) == [
        "HoldSpeed"
    ]


def test_known_branches_disappear(acts: Acts) -> None:
    """`if` over compile-time values leaves one side; over the run it branches."""
    text = "behavior B(m):\n    if m.type is ManeuverType.STRAIGHT:\n        wait\n"
    text += "    else:\n        take SetBrakeAction(1)\n"
    assert kinds(body(acts(text, "B(lane.maneuvers[0])"))) == ["Wait"]
    assert kinds(body(acts(text, "B(lane.maneuvers[1])"))) == ["Take"]
    (branch,) = body(
        acts("behavior B():\n    if self.speed > 1:\n        wait\n    elif self.speed > 2:\n        pass\n")
    )
    assert isinstance(branch, ir.Branch)
    assert kinds(branch.otherwise) == ["Branch"]


def test_return_leaves_its_own_scope(acts: Acts) -> None:
    """Each inlined behaviour is a scope of its own."""
    text = "behavior A():\n    wait\n    return\nbehavior B():\n    do A()\n    do A()\n    return\n"
    outer = acts(text)
    scopes = [act.scope for act in everything(outer) if isinstance(act, ir.Scope)]
    leaves = [act.scope for act in everything(outer) if isinstance(act, ir.Leave)]
    assert len(set(scopes)) == 3
    assert leaves == [scopes[1], scopes[2], scopes[0]]


def test_take_sets_commands(acts: Acts) -> None:
    """Several actions in one turn."""
    (take,) = body(acts("behavior B():\n    take SetThrottleAction(0.5), SetSteerAction(3 deg)\n"))
    assert isinstance(take, ir.Take)
    assert [command for command, _ in take.commands] == [Command.THROTTLE, Command.STEER]


def test_random_numbers_of_behaviours_are_their_own(acts: Acts) -> None:
    """Every evaluation takes the next number of the behaviour stream; none is shared."""
    text = "behavior B():\n    take SetThrottleAction(Range(0, 1))\n    take SetThrottleAction(Range(0, 1))\n"
    first, second = body(acts(text))
    assert isinstance(first, ir.Take)
    assert isinstance(second, ir.Take)
    assert first.commands[0][1] is not second.commands[0][1]


def test_follow_lane_knows_its_lane_where_it_can(compiled: Compiled) -> None:
    """From a lane's centre line the route is known; from a point it is found when the run starts."""
    scenario = compiled(
        "a = new Car in lane.centerline, with behavior FollowLaneBehavior()\n"
        "b = new Car at (0, 0), with behavior FollowLaneBehavior()\n"
        "c = new Car at (0, 0), with behavior FollowLaneBehavior(laneToFollow=lane)\n"
    )
    _, a, b, c = scenario.variants[0].actors
    assert a.route == c.route == scenario.network.lanes[0].default_route
    assert b.route == -1
    assert b.behaviour is not None
    assert kinds(b.behaviour) == ["SetLocal", "Follow"]


def test_terminate_is_a_rule(compiled: Compiled) -> None:
    """Every `terminate` of a behaviour is a rule of its own, the same number in every variant."""
    scenario = compiled(
        "chosen = Uniform('a', 'b')\nbehavior B():\n    if chosen == 'b':\n        terminate\n    wait\n    terminate\n"
        "other = new Car behind ego, with behavior B\nterminate when ego.speed > 5\n"
    )
    assert [[rule.line for rule in v.rules] for v in scenario.variants] == [[11, 9, 7]] * 2
    used = [
        [act.rule for act in everything(v.actors[1].behaviour or ()) if isinstance(act, ir.Terminate)]
        for v in scenario.variants
    ]
    assert used == [[1], [2, 1]]


def test_later_names_are_seen(said: Said) -> None:
    """A behaviour runs after the file, so it may speak of what is defined below it."""
    text = "behavior B():\n    do IdleBehavior() until (distance from self to friend) < 5 m\n"
    assert said(text + "other = new Car behind ego, with behavior B\nfriend = new Car at (0, 0)\n") == []


def test_mutual_recursion_is_shown_as_a_cycle(said: Said) -> None:
    """And is no crash."""
    text = (
        "behavior A():\n    do B()\nbehavior B():\n    wait\n    do A()\nother = new Car behind ego, with behavior B\n"
    )
    assert said(text) == ["SCN601"]


def test_mistakes_in_one_behaviour_are_all_said(said: Said) -> None:
    """Each statement is looked at, and nothing follows from a mistake."""
    text = "behavior B():\n    x = 1 m + 1 s\n    y = x\n    while True:\n        take SetBrakeAction(3)\n    take 5\n"
    assert said(text + "other = new Car behind ego, with behavior B\n") == ["SCN302", "SCN402", "SCN605"]

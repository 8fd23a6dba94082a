"""One library behaviour that is to be run: its arguments as expressions, and the acts that many of them share."""

import math
from collections.abc import Callable

from cortex_dsl import ir
from cortex_dsl.semantics.errors.runs import NOT_A_DRIVER, OVER_THE_EDGE
from cortex_dsl.semantics.errors.values import TARGET_ABOVE_TOP, WRONG_KIND
from cortex_dsl.semantics.evaluation import signals
from cortex_dsl.semantics.evaluation.arguments import Given, number_for
from cortex_dsl.semantics.evaluation.functions import known_truth
from cortex_dsl.semantics.evaluation.geometry import current_pose, size_of, state
from cortex_dsl.semantics.evaluation.lanes import index_of, lane_at, limit_on
from cortex_dsl.semantics.evaluation.roads import network_of
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import Actor, Alignment, BehaviourCall, BuiltinValue, Quantity, Value
from cortex_dsl.semantics.model.wording import kind_name, shown
from cortex_dsl.semantics.names.builtins import BUILTINS, Parameter
from cortex_dsl.semantics.quantities.algebra import Term, maximum, minimum, sqrt, where
from cortex_dsl.semantics.quantities.bounds import closed_value
from cortex_dsl.semantics.quantities.units import LENGTH, PURE, SPEED
from cortex_dsl.source import Span
from engine.frozen import frozen
from engine.road.network import Lane
from engine.vocabulary import ActorKind, Command, RuleKind, State

DEFAULT_SPEED = 10.0
"""Target speed of the library's drivers, as in Scenic [m/s]."""
DEFAULT_LATERAL = 3.0
"""Lateral acceleration that they accept in turns: brisk [m/s^2]."""
SPEED_GAIN = 4.0
"""Gain of the engine's speed controller: acceleration = `SPEED_GAIN * (target - speed)` [1/s]; a test compares them."""
STOPPING = 3.0
"""Deceleration of planned stops [m/s^2]: the comfortable value of ITE, as for bends in the engine."""
STOP_PREVIEW = 0.5
"""How far ahead that plan is read, for the controller lags behind a falling target [s]; as for bends in the engine."""
STOP_MARGIN = 0.5
"""How far before a stop line drivers come to rest [m]."""

LANE_ROUNDING = 1e-6
"""Excess over the width of a lane that is a rounding error [m]."""

Inline = Callable[[BehaviourCall], ir.Block]


def speed_to_stop(room: Term) -> Term:
    """Return the target speed [m/s] of a planned stop within `room` [m]; 0 where there is no room.

    v = sqrt(2 b d), the speed from which a deceleration of b comes to rest within d, but at most `SPEED_GAIN` d. The
    slope of the root, b / v, has no bound: read `STOP_PREVIEW` ahead by a controller that acts once a step, it would
    make the controller overshoot below 0.5 m/s, so that a car would jerk to its stop, and rounding would grow tenfold
    with each step.
    """
    left = maximum(room, 0.0)
    return minimum(sqrt(2.0 * STOPPING * left), SPEED_GAIN * left)


@frozen
class Job:
    """One library behaviour to be run: its call, the actor, and the evaluator of the moment."""

    ev: Evaluator
    call: BehaviourCall
    actor: Actor
    at_start: bool
    """Whether it begins with the run, so that the actor still is where the scene put it."""
    inline: Inline
    """Acts of a behaviour that this one runs."""

    # -- arguments ---------------------------------------------------------------------------------------------------

    def given(self, name: str) -> Value:
        """An argument; None without it."""
        return self.call.arguments.get(name)

    def number(self, name: str, default: float | None = None) -> Term:
        if self.given(name) is None and default is not None:
            return self.ev.algebra.literal(default)
        return number_for(self.ev, self._parameter(name), Given(self.call.arguments[name], self.call.spans[name]))

    def check_numbers(self) -> None:
        """Refuse numbers outside their range, even if the behaviour does not depend on them here."""
        for name in self.call.arguments:
            if self._parameter(name).dimension is not None and self.given(name) is not None:
                value = closed_value(self.number(name))
                if value is not None and name in ("target_speed", "speed"):
                    self._compare_with_top(value, self.call.spans[name])
                if name == "offset":
                    self._compare_with_lane(self.call.spans[name])

    def _compare_with_top(self, target: float, span: Span) -> None:
        """Note a constant speed that the actor cannot reach."""
        top = closed_value(size_of(self.actor, "topSpeed"))
        if top is not None and target > top:
            name = self.actor.kind.name.capitalize()
            wanted, highest, enough = (shown(speed, SPEED) for speed in (target, top, math.ceil(target)))
            self.ev.report(TARGET_ABOVE_TOP.at(span, name=name, target=wanted, top=highest, enough=enough))

    def _compare_with_lane(self, span: Span) -> None:
        """Warn of an offset, or the largest of its range, at which the outline leaves the lane."""
        if isinstance(self.given("trajectory"), Alignment):
            return  # the width of such a path is unknown
        reach = max(map(abs, self.ev.interval(self.number("offset"))))
        given = self.given("laneToFollow")
        lane = (
            given.width
            if isinstance(given, Lane)
            else max((each.width for each in network_of(self.ev).lanes), default=0)
        )
        width = self.ev.interval(size_of(self.actor, "width"))[0]
        if lane and reach < math.inf and reach + 0.5 * width > 0.5 * lane + LANE_ROUNDING:
            numbers = (reach, width, lane, max(0.0, 0.5 * (lane - width)))
            offset, wide, room, most = (shown(value, LENGTH) for value in numbers)
            which = "its lane is" if isinstance(given, Lane) else "the widest lane is"
            name = self.actor.kind.name.capitalize()
            finding = OVER_THE_EDGE.at(span, name=name, offset=offset, width=wide, lanes=which, lane=room, most=most)
            self.ev.report(finding)

    def _parameter(self, name: str) -> Parameter:
        assert isinstance(self.call.behaviour, BuiltinValue)
        return BUILTINS[self.call.behaviour.name].parameter(name)

    def flag(self, name: str, *, default: bool = False) -> bool:
        """A switch that must be known at compile time."""
        if name not in self.call.arguments:
            return default
        value, span = self.call.arguments[name], self.call.spans[name]
        if isinstance(value, Quantity) and value.dimension not in (None, PURE):
            raise WRONG_KIND.mistake(
                span, what=f"`{name}`", expected="`True` or `False`", actual=kind_name(value), cure=self._by_name(value)
            )
        return known_truth(self.ev, value, span, f"`{name}`")

    def _by_name(self, value: Quantity) -> str:
        """How to give an amount that was given in the wrong place."""
        assert isinstance(self.call.behaviour, BuiltinValue)
        row = BUILTINS[self.call.behaviour.name]
        fitting = (p for p in row.parameters if p.dimension == value.dimension and p.name not in self.call.arguments)
        meant = next((f"name the argument that it is: `{p.name}=...`; " for p in fitting), "")
        return f"{meant}the order is `{row.signature}`"

    def max_lateral(self) -> Term:
        """`none` switches the planning of speed off."""
        if "max_lateral" in self.call.arguments and self.call.arguments["max_lateral"] is None:
            return self.ev.algebra.literal(math.inf)
        return self.number("max_lateral", DEFAULT_LATERAL)

    def target_speed(self, default: float = DEFAULT_SPEED) -> Term:
        """Return the target speed [m/s], reduced to the speed limit at the actor if the call asks for it."""
        speed = self.number("target_speed", default)
        if not self.flag("respect_speed_limit"):
            return speed
        lane = self.lane()
        return speed if lane is None else minimum(speed, limit_on(self.ev, lane))

    def must_steer(self) -> None:
        """Refuse actors without wheels."""
        if self.actor.kind in (ActorKind.PEDESTRIAN, ActorKind.OBSTACLE):
            actual = kind_name(self.actor)
            raise NOT_A_DRIVER.mistake(self.call.span, behaviour=self.call.name, actual=actual)

    # -- the actor now -----------------------------------------------------------------------------------------------

    def lane(self) -> Term | None:
        """The index of the lane that the actor is in; None on roads without lanes."""
        return index_of(self.ev, lane_at(self.ev, current_pose(self.ev, self.actor)))

    def speed(self) -> Term:
        return state(self.ev, self.actor, State.SPEED)

    def kept(self, value: Term) -> tuple[ir.Act, Term]:
        """Return an act that stores a value of the present moment, and the stored value."""
        local = self.ev.run.new_local()
        return ir.SetLocal(self.call.span, local, value), self.ev.algebra.local(local)

    # -- acts --------------------------------------------------------------------------------------------------------

    def follow(self, path: Term, speed: Term, offset: Term | None = None) -> ir.Act:
        """Follow a path to its end, so far to its left; for the lights too, if the call says so."""
        if self.flag("obey_signals"):
            stop, room = signals.must_stop(self.ev, self.actor, self.call.spans["obey_signals"])
            speed = self.stopping(speed, stop, room)
        local = self.ev.run.new_local()
        return ir.Follow(self.call.span, path, speed, self.max_lateral(), local, offset, self.aside())

    def aside(self) -> Term | None:
        """Return the offset to the left of the path that the call asks for [m]; None without one."""
        return self.number("offset") if self.given("offset") is not None else None

    def stopping(self, speed: Term, stop: Term, room: Term) -> Term:
        """The target speed, lowered while `stop` holds so that the front halts `room` metres from here."""
        allowed = speed_to_stop(room - (STOP_PREVIEW * self.speed() + STOP_MARGIN))
        return where(stop, minimum(speed, allowed), speed)

    def forever(self, act: ir.Act) -> ir.Act:
        return ir.Loop(self.call.span, self.ev.algebra.truth(True), (act,))

    def until(self, body: ir.Block, condition: Term) -> ir.Act:
        """Run acts until a condition holds."""
        return ir.TryInterrupt(self.call.span, body, ((condition, (ir.Abort(self.call.span),)),))

    def pedals(self, acceleration: Term) -> tuple[tuple[Command, Term], ...]:
        """Throttle and brake that give an acceleration; the vehicle's own limits hold."""

        def pedal(wanted: Term, most: str) -> Term:
            return minimum(1.0, maximum(0.0, wanted / size_of(self.actor, most)))

        return (
            (Command.THROTTLE, pedal(acceleration, "maxAcceleration")),
            (Command.BRAKE, pedal(-acceleration, "maxBraking")),
            (Command.REVERSE, self.ev.algebra.truth(False)),
        )

    def braking(self, pedal: Term) -> ir.Take:
        """Brake for one step; where pedals keep their position, the pedal is released afterwards."""
        command = Command.STOP if self.ev.file.settings.given.pedals_stay else Command.BRAKE
        return ir.Take(self.call.span, ((command, pedal),))

    def abort_unless(self, condition: Term, name: str) -> ir.Block:
        """Make the run invalid where a condition fails; nothing to do where it is known to hold."""
        if isinstance(condition, ir.Literal) and condition.value:
            return ()
        return (ir.Demand(self.call.span, condition, self.ev.file.run.rule(self.call.span, name, RuleKind.ABORT)),)

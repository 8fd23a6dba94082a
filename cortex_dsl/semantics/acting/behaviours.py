"""Behaviours, inlined: each actor's behaviour with everything that it `do`es becomes one block of acts. So do monitors,
which are behaviours without an actor and watch the run from its start.

Arguments are evaluated where the behaviour starts. Numbers that a body assigns live in locals; lanes, objects and
other things are bound at compile time and cannot change during the run.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

from cortex_dsl import ir
from cortex_dsl.semantics.acting import (
    braking,
    caution,
    choosing_lanes,
    cycling,
    external,
    following,
    giving_way,
    profiles,
    replaying,
    safety_models,
    walking,
    warning_signals,
)
from cortex_dsl.semantics.acting.acts import ACTS
from cortex_dsl.semantics.acting.bodies import Body, Invocation, snapshot
from cortex_dsl.semantics.acting.job import Job
from cortex_dsl.semantics.acting.yielding import ever_acts, everything
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.runs import (
    DO_SEVERAL,
    IDLE_BEHAVIOUR,
    LOOKS_ONCE,
    NOT_A_BEHAVIOUR,
    NOT_A_DRIVER,
    RECURSIVE,
)
from cortex_dsl.semantics.evaluation import doors
from cortex_dsl.semantics.evaluation.calls import as_behaviour
from cortex_dsl.semantics.model.context import Evaluator, Moment
from cortex_dsl.semantics.model.values import (
    Actor,
    BehaviourCall,
    BehaviourValue,
    Instance,
    MonitorCall,
    MonitorValue,
    Value,
)
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.builtins import Kind, names_of
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes
from engine.vocabulary import Turns

# -- the library -------------------------------------------------------------------------------------------------------


LIBRARY: dict[str, Callable[[Job], ir.Block]] = {
    "FollowTrajectoryBehavior": following.follow_trajectory,
    "FollowLaneBehavior": following.follow_lane,
    "TurnBehavior": following.turn,
    "CarFollowingBehavior": following.follow_car,
    "GapAcceptanceBehavior": caution.accept_gap,
    "GivingWayBehavior": giving_way.give_way,
    "AutopilotBehavior": giving_way.give_way,
    "LaneChangeBehavior": following.change_lane,
    "LaneChoosingBehavior": choosing_lanes.choose_lane,
    "EmergencyBrakeBehavior": braking.emergency_brake,
    "ManualBrakeBehavior": warning_signals.brake_after_warning,
    "RSSBehavior": safety_models.responsibility,
    "CarefulDriverBehavior": safety_models.careful_driver,
    "FuzzySafetyBehavior": safety_models.fuzzy_safety,
    "DriveAvoidingCollisions": caution.drive_avoiding,
    "CrossingBehavior": caution.cross,
    "CyclingBehavior": cycling.ride,
    "WalkForwardBehavior": caution.walk_forward,
    "WalkAlongBehavior": walking.walk_along,
    "UseCrossingBehavior": walking.use_crossing,
    "ConstantSpeedBehavior": following.constant_speed,
    "ConstantThrottleBehavior": following.constant_throttle,
    "BrakeBehavior": following.brake,
    "AccelerateThenKeepBehavior": profiles.accelerate_then_keep,
    "BrakeToBehavior": profiles.brake_to,
    "ExternalBehavior": external.drive_from_outside,
    "ReplayBehavior": replaying.replay,
    "IdleBehavior": following.idle,
}

# -- objects -----------------------------------------------------------------------------------------------------------


def actor_behaviour(ev: Evaluator, actor: Actor) -> ir.Block | None:
    """Return all acts of an actor, including those that running scenarios assign; None without behaviour."""
    if actor.door_of is not None:
        return doors.motion(ev.at_moment(Moment(running=True, actor=actor)), actor)
    call = actor.properties.get("behavior")
    inliner = Inliner(ev.at_moment(Moment(running=True, actor=actor)), actor)
    block = inliner.started(call) if isinstance(call, BehaviourCall) else None
    return _overridden(inliner, block or (), actor) if actor.overrides else block


def _overridden(inliner: "Inliner", block: ir.Block, actor: Actor) -> ir.Block:
    """The behaviour of an object, interrupted for as long as a scenario overrides it, and then gone on with."""
    ev, span = inliner.ev, actor.span
    forever = ir.Loop(span, ev.algebra.truth(True), (ir.Wait(span),))
    handlers = []
    for monitor, call in actor.overrides:
        acts = inliner.invoke(call, replace(inliner.ev.moment, repeated=True)).block(call.span) if call else ()
        running = ev.algebra.running(monitor)
        over = ~running
        handlers.append((running, (ir.TryInterrupt(span, (*acts, forever), ((over, (ir.Abort(span),)),)),)))
    return (ir.TryInterrupt(span, (*block, forever), tuple(handlers)),)


def stop(instances: Iterable[Instance | None], span: Span) -> ir.Stop:
    """Stop scenarios with everything that they started, and the behaviours of their objects."""
    family = [each for instance in instances if instance is not None for each in instance.family]
    monitors = tuple(number for each in family for number in (each.monitor, *each.watchers))
    return ir.Stop(span, monitors, tuple(actor.index for each in family for actor in each.actors))


@dataclass(frozen=True)
class Inliner:
    """Inlines calls as acts; `stack` holds the calls that are being inlined. Without an actor, `self` has no value."""

    ev: Evaluator
    actor: Actor | None
    stack: tuple[BehaviourValue | MonitorValue, ...] = ()

    @property
    def owner(self) -> str:
        """Return the name of the body that is being inlined."""
        return self.stack[-1].node.name

    @property
    def lets_appear(self) -> bool:
        """Return whether it is a behavior of an actor, and no monitor."""
        return self.actor is not None

    def started(self, call: BehaviourCall) -> ir.Block:
        """The actor's own behaviour, which begins with the run."""
        return self.invoke(call, self.ev.moment, at_start=True).block(call.span)

    def monitor(self, call: MonitorCall) -> ir.Block:
        """Return the acts of a monitor."""
        inner = self._in(call.monitor)
        body = Body(inner, self.ev.moment)
        return body.inlined(call, call.monitor.node).block(call.span)

    def _in(self, definition: BehaviourValue | MonitorValue) -> "Inliner":
        """Inside a definition, which sees the names of the file or scenario that has it."""
        ev = self.ev.at_home(definition.home).within(definition.scopes)
        return replace(self, ev=ev, stack=(*self.stack, definition))

    def act(self, body: Body, statement: nodes.Statement) -> ir.Block:
        """Return the acts of one statement of a body."""
        return ACTS[type(statement)](body, statement)

    def invocation(self, value: Value, node: nodes.Expression, moment: Moment) -> Invocation:
        """Return the invocation of `do node`.

        Raises:
            Mistake: the value is not a behaviour.
        """
        if self.actor is None:
            raise Mistake  # reported already: there is no actor
        call = as_behaviour(value, node.span)
        if call is None:
            cure = did_you_mean(node.id, names_of(Kind.BEHAVIOUR)) if isinstance(node, nodes.Name) else ""
            raise NOT_A_BEHAVIOUR.mistake(node.span, actual=kind_name(value), cure=cure)
        return self.invoke(call, moment)

    def invoke(self, call: BehaviourCall, moment: Moment, *, at_start: bool = False) -> Invocation:
        if not isinstance(call.behaviour, BehaviourValue):
            return self._library(call, self.ev.at_moment(moment), at_start)
        self._check_cycle(call.behaviour, call.span)
        inner = self._in(call.behaviour)
        return Body(inner, moment).inlined(call, call.behaviour.node)

    def mark(self) -> int:
        """How many scenarios have been started so far; behaviours start none."""
        return 0

    def stopped(self, mark: int, span: Span) -> ir.Block:
        """Acts that stop the scenarios started since."""
        del mark, span
        return ()

    def together(self, body: "Body", invocations: Sequence[nodes.Expression]) -> ir.Block:
        """Refuse `do a, b` in a behaviour."""
        del body
        raise DO_SEVERAL.mistake(invocations[1].span)

    def over(self, body: "Body", node: nodes.Terminate) -> ir.Block:
        """Return the acts of `terminate`."""
        if self.actor is not None and self.actor.scenario not in (None, body.ev.run.root) and not node.simulation:
            ends = stop((self.actor.scenario,), node.span)
            return (ends, ir.Loop(node.span, body.ev.algebra.truth(True), (ir.Wait(node.span),)))
        words = "terminate simulation" if node.simulation else "terminate"
        return (ir.Terminate(node.span, body.ev.file.run.rule(node.span, f"`{words}` in {self.owner}")),)

    def _library(self, call: BehaviourCall, ev: Evaluator, at_start: bool) -> Invocation:
        assert self.actor is not None
        if self.actor.plain and call.name != "IdleBehavior":
            raise NOT_A_DRIVER.mistake(call.span, behaviour=call.name, actual=kind_name(self.actor))
        prologue, fixed = _settled(ev, call)
        job = Job(ev, fixed, self.actor, at_start, partial(self._inner, ev.moment, at_start))
        acts = LIBRARY[call.name](job)
        job.check_numbers()
        if any(isinstance(each, BehaviourValue) and each.node.invariants for each in self.stack):
            # Its turns are not those of the behaviour around it, whose invariants rest meanwhile.
            acts = (ir.Scope(call.span, call.name, ev.run.new_scope(call.span), acts),)
        return Invocation(prologue, acts)

    def _inner(self, moment: Moment, at_start: bool, call: BehaviourCall) -> ir.Block:
        """Inline a behaviour that a library behaviour runs."""
        return self.invoke(call, moment, at_start=at_start).block(call.span)

    def _check_cycle(self, behaviour: BehaviourValue, span: Span) -> None:
        if any(behaviour.node is running.node for running in self.stack):
            names = [running.node.name for running in (*self.stack, behaviour)]
            first = names.index(behaviour.node.name)
            raise RECURSIVE.mistake(span, name=behaviour.node.name, cycle=" -> ".join(names[first:]))


def _settled(ev: Evaluator, call: BehaviourCall) -> tuple[ir.Block, BehaviourCall]:
    """Return a call with arguments fixed at their values at its start."""
    acts: list[ir.Act] = []
    arguments = {name: snapshot(ev, value, call.spans[name], acts) for name, value in call.arguments.items()}
    return tuple(acts), replace(call, arguments=arguments)


def warn_if_idle(ev: Evaluator, actor: Actor, block: ir.Block) -> None:
    """A behaviour that does nothing at all is hardly meant."""
    call = actor.properties.get("behavior")
    if isinstance(call, BehaviourCall) and isinstance(call.behaviour, BehaviourValue) and not ever_acts(block):
        ev.report(IDLE_BEHAVIOUR.at(call.span, name=call.name))


# -- monitors ----------------------------------------------------------------------------------------------------------


def monitor_body(ev: Evaluator, call: MonitorCall, moment: Moment) -> ir.Block:
    """Return the acts of a monitor; warn if it looks at the first sample only."""
    block = Inliner(ev.at_moment(moment), None).monitor(call)
    if not any(isinstance(act, ir.Wait | ir.Loop) for act in everything(block)):
        ev.report(LOOKS_ONCE.at(call.monitor.node.name_span, name=call.name))
    return block


def started_monitors(ev: Evaluator) -> Iterator[ir.Monitor]:
    """The monitors that the file requires, in its order."""
    for name, call, span in ev.run.built.required_monitors:
        try:
            block = monitor_body(ev, call, Moment(running=True))
        except Mistake as mistake:
            ev.report(mistake)
        else:
            yield ir.Monitor(name or call.name, block, Turns.FROM_START, span)

"""Doors of parked vehicles: `OpenDoorAction(side, angle, time)`.

A door is an actor of its own, a thin outline at the side of its vehicle. It is absent until it opens; then it turns
about its hinge at a constant rate and stays open. So contact, distance, sight and pictures treat it as any other actor.
Only an object whose `behavior` opens a door has one.
"""

import math
from collections.abc import Callable

from cortex_dsl import ir
from cortex_dsl.semantics.errors.names import NOT_SUPPORTED
from cortex_dsl.semantics.errors.runs import ONLY_WHILE_RUNNING
from cortex_dsl.semantics.errors.values import WRONG_KIND
from cortex_dsl.semantics.evaluation.arguments import Given, number_for
from cortex_dsl.semantics.evaluation.geometry import current_pose, moved, size_of, state
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import (
    Actor,
    BehaviourCall,
    BehaviourValue,
    Door,
    DoorCall,
    Pose,
    Quantity,
    Value,
    Vector,
)
from cortex_dsl.semantics.model.wording import kind_name
from cortex_dsl.semantics.names.builtins import BUILTINS
from cortex_dsl.semantics.names.properties import MODEL_FIELDS
from cortex_dsl.semantics.names.tree import OPENS_DOOR
from cortex_dsl.semantics.quantities.algebra import Term
from cortex_dsl.semantics.quantities.units import LENGTH
from cortex_dsl.source import Span
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind, RuleKind, State

SIDES = ("left", "right")
WITH_DOORS = (ActorKind.CAR, ActorKind.TRUCK, ActorKind.BUS)
DOOR_LENGTH = 1.0
"""Length of a door unless the property `doorLength` gives another [m]; not verified."""
THICKNESS = 0.1
"""[m]; *ours*"""
APART = 0.01
"""Distance of a closed door from the side of its vehicle [m]; *ours*: outlines do not touch."""
HINGE = 0.2
"""Place of the hinge before the middle of the vehicle, as a share of the vehicle's length; *ours*: a front door."""
ANGLE, TIME = math.radians(70.0), 1.0
"""Usual angle [rad] and time [s] of an opening; *ours*."""
FASTEST = 0.5 * math.pi
"""Turn of the track of a door [rad], in 1 s."""
ROWS = 46
"""Samples of that track: between them motion is linear."""
STANDING = 0.1
"""Speed below which a vehicle stands [m/s]."""


def opens_door(ev: Evaluator, call: Value) -> bool:
    """Return whether a behavior, or one that it is given, opens a door."""
    if not isinstance(call, BehaviourCall):
        return False
    own = isinstance(call.behaviour, BehaviourValue) and call.behaviour.node.name in ev.facts.door_openers
    return own or any(opens_door(ev, each) for each in call.arguments.values())


def add_doors(ev: Evaluator, actor: Actor, unique: Callable[[Evaluator, str], str]) -> None:
    """Make the doors of an object whose behavior opens one; `unique` gives names that no object has."""
    if (
        actor.kind not in WITH_DOORS
        or not ev.facts.door_openers
        or not opens_door(ev, actor.properties.get("behavior"))
    ):
        return
    for side in (side for side in SIDES if side in ev.facts.door_sides):
        door = _door(ev, actor, side)
        door.name = unique(ev, f"{actor.name}_{side}_door")
        actor.doors[side] = Door(door, *(ev.run.new_local() for _ in range(3)))
        ev.run.built.zeroed |= {actor.doors[side].opened}
        ev.run.built.actors.append(door)


def _door(ev: Evaluator, actor: Actor, side: str) -> Actor:
    literal, model = ev.algebra.literal, MODELS[ActorKind.OBSTACLE]
    properties: dict[str, Value] = {name: literal(float(getattr(model, of))) for name, of in MODEL_FIELDS.items()}
    given = actor.properties.get("doorLength")
    length = given.expr if isinstance(given, Quantity) else literal(DOOR_LENGTH)
    properties |= {"speed": literal(0.0), "length": length, "width": literal(THICKNESS), "fixed": literal(1.0)}
    properties |= {"occluding": literal(1.0), "allowCollisions": True, "regionContainedIn": None}
    pose = _closed(actor, side, length, actor.pose)
    return Actor(-1, "", ActorKind.OBSTACLE, actor.span, pose, properties, actor.scenario, late=True, door_of=actor)


def _closed(actor: Actor, side: str, length: Term, pose: Pose) -> Pose:
    """Return the pose of a closed door of a vehicle that has this pose."""
    out = size_of(actor, "width") * 0.5 + (0.5 * THICKNESS + APART)
    ahead = size_of(actor, "length") * HINGE - length * 0.5
    place = moved(Vector(pose.x, pose.y), pose.heading, -out if side == "left" else out, ahead)
    return Pose(place.x, place.y, pose.heading)


def open_door(ev: Evaluator, bound: dict[str, Given], span: Span) -> DoorCall:
    """Return the acts that open a door of the acting object; nothing where it is open."""
    actor = ev.moment.actor
    if actor is None:
        raise ONLY_WHILE_RUNNING.mistake(span, what="the vehicle")
    side = bound["side"].value
    if side not in SIDES:
        actual = f'"{side}"' if isinstance(side, str) else kind_name(side)
        expected = '"left" or "right"'
        raise WRONG_KIND.mistake(bound["side"].span, what="`side`", expected=expected, actual=actual, cure="")
    if side not in actor.doors:
        what = f"`{actor.name}` has no door"
        reason = "a car, truck or bus has doors if the `behavior` that it is made with opens one"
        raise NOT_SUPPORTED.mistake(span, what=what, reason=reason, cure="write `new Car …, with behavior B()`")
    door, usual = actor.doors[str(side)], {"angle": ANGLE, "time": TIME}
    angle, time = (_number(ev, bound, name, usual[name]) for name in ("angle", "time"))
    name = f"{actor.name} stands when a door opens"
    stands = ir.Demand(span, state(ev, actor, State.SPEED) < STANDING, ev.file.run.rule(span, name, RuleKind.ABORT))
    place = _closed(actor, str(side), size_of(door.actor, "length"), current_pose(ev, actor))
    acts = (
        stands,
        ir.SetLocal(span, door.opened, ev.algebra.literal(1.0)),
        ir.SetLocal(span, door.pace, angle / FASTEST / time),
        ir.SetLocal(span, door.until, ev.algebra.time() + time),
        ir.Enter(span, door.actor.index, (place.x, place.y, place.heading, ev.algebra.literal(0.0))),
    )
    return DoorCall((ir.Branch(span, ev.algebra.local(door.opened) < 0.5, acts, ()),))


def _number(ev: Evaluator, bound: dict[str, Given], name: str, usual: float) -> Term:
    if name not in bound:
        return ev.algebra.literal(usual)
    return number_for(ev, BUILTINS[OPENS_DOOR].parameter(name), bound[name])


def motion(ev: Evaluator, actor: Actor) -> ir.Block:
    """Return the acts of a door: turn until the time is over, and stay."""
    owner, span = actor.door_of, actor.span
    assert owner is not None
    side, door = next((side, door) for side, door in owner.doors.items() if door.actor is actor)
    length = ev.constant(Quantity(size_of(actor, "length"), LENGTH), span, "`doorLength`")
    rows = _track(length, -1.0 if side == "left" else 1.0)
    track = ev.file.pool.offset((float(ROWS), *rows))
    turning = ir.Replay(span, track, ev.algebra.local(door.pace), ev.run.new_local())
    over = ev.algebra.local(door.until) <= ev.algebra.time() + 1e-9
    rest = ir.Loop(span, ev.algebra.truth(True), (ir.Wait(span),))
    return (ir.TryInterrupt(span, (turning,), ((over, (ir.Abort(span),)),)), rest)


def _track(length: float, sign: float) -> list[float]:
    """Return rows of time, x, y, heading and speed of a door that turns about its front end, from heading 0."""
    rows: list[float] = []
    for number in range(ROWS):
        share = number / (ROWS - 1)
        turn = sign * FASTEST * share
        x, y = -0.5 * length * math.cos(turn), -0.5 * length * math.sin(turn)
        rows += [share, x, y, turn, 0.0]
    return rows

"""How bodies go through a step in which somebody touches: each actor along its leg, and buildings not at all.

Bodies are numbered: the actors, then the buildings of the road, which are walls.
"""

import math
from enum import IntEnum

from engine.kernels.approach import TOUCH, circles_apart
from engine.kernels.contact import Body, is_fixed
from engine.kernels.geometry import Box, building, half_diagonal, shortest_turn
from engine.kernels.jit import inlined
from engine.kernels.pair import Rate, swung
from engine.kernels.run_state import HOSTED, Plan, Run, Slot, column_of
from engine.tables import SLIDING, Floats
from engine.vocabulary import ActorKind, Column, State


class Leg(IntEnum):
    """Columns of `Run.legs`: a straight way through the rest of a step, of loose bodies and of all where some touch."""

    BEGIN = 0
    """Part of the step at which the leg begins; it ends at 1."""
    X0 = 1
    """Centre [m] and heading [rad] at its beginning (0) and its end (1)."""
    Y0 = 2
    HEADING0 = 3
    X1 = 4
    Y1 = 5
    HEADING1 = 6
    VX0 = 7
    """Velocity of the centre [m/s] and spin [rad/s], likewise."""
    VY0 = 8
    SPIN0 = 9
    VX1 = 10
    VY1 = 11
    SPIN1 = 12
    ROLLING = 13
    """1 once the wheels of a loose body grip again: it rolls out where they point."""
    STRUCK = 14
    """1 for a body that an impact has changed in this step."""
    NEAR_WALL = 15
    """1 where the leg may lead into a building."""


@inlined
def bodies_of(plan: Plan) -> int:
    """How many bodies there are."""
    return len(plan.kinds) + len(plan.road.buildings)


@inlined
def lay_leg(plan: Plan, run: Run, sample: int, actor: int) -> None:
    """The leg of a driven body: its step, with the velocity of its centre at both ends."""
    leg = run.legs[actor]
    leg[Leg.BEGIN] = leg[Leg.STRUCK] = leg[Leg.ROLLING] = 0.0
    states, step = run.states, plan.layout.time_step
    turn = shortest_turn(states[sample, actor, State.HEADING], states[sample + 1, actor, State.HEADING]) / step
    if plan.kinds[actor] == ActorKind.PEDESTRIAN:
        turn = 0.0  # it turns at once, which is no spin that it goes on with
    swing = turn * column_of(plan, run, actor, Column.REAR_TO_CENTER)
    for end in range(2):
        row = states[sample + end, actor]
        leg[Leg.X0 + 3 * end], leg[Leg.Y0 + 3 * end] = row[State.X], row[State.Y]
        leg[Leg.HEADING0 + 3 * end] = row[State.HEADING]
        leg[Leg.VX0 + 3 * end], leg[Leg.VY0 + 3 * end] = swung(row[State.HEADING], row[State.SPEED], swing)
        leg[Leg.SPIN0 + 3 * end] = turn


@inlined
def velocity_of(run: Run, sample: int, actor: int) -> Rate:
    """Of the rear axle along its heading; of a body that slides, of its centre, at the end of its leg."""
    row = run.states[sample, actor]
    if row[State.PRESENT] == SLIDING:
        return Rate(run.legs[actor, Leg.VX1], run.legs[actor, Leg.VY1])
    return Rate(row[State.SPEED] * math.cos(row[State.HEADING]), row[State.SPEED] * math.sin(row[State.HEADING]))


@inlined
def spin_of(plan: Plan, run: Run, sample: int, actor: int) -> float:
    """Anticlockwise; who walks turns at once, which is no spin."""
    if run.states[sample, actor, State.PRESENT] == SLIDING:
        return run.legs[actor, Leg.SPIN1]
    before = max(sample - 1, 0)
    if plan.kinds[actor] == ActorKind.PEDESTRIAN or run.states[before, actor, State.PRESENT] == 0.0:
        return 0.0
    turn = shortest_turn(run.states[before, actor, State.HEADING], run.states[sample, actor, State.HEADING])
    return turn / plan.layout.time_step


@inlined
def along_leg(run: Run, actor: int, part: float) -> float:
    """How far along its leg an actor is at a part of the step."""
    begin = run.legs[actor, Leg.BEGIN]
    return (part - begin) / (1.0 - begin) if begin < 1.0 else 1.0


@inlined
def on_leg(run: Run, actor: int, column: int, along: float) -> float:
    """One of X0 to SPIN0 along the way to its value at the end of the leg."""
    start = run.legs[actor, column]
    return start + along * (run.legs[actor, column + 3] - start)


@inlined
def outline_on_leg(plan: Plan, run: Run, actor: int, part: float) -> Box:
    """The outline of a body at a part of the step."""
    if actor >= len(plan.kinds):
        return building(plan.road.buildings, actor - len(plan.kinds))
    along = along_leg(run, actor, part)
    return Box(
        on_leg(run, actor, Leg.X0, along),
        on_leg(run, actor, Leg.Y0, along),
        on_leg(run, actor, Leg.HEADING0, along),
        column_of(plan, run, actor, Column.LENGTH),
        column_of(plan, run, actor, Column.WIDTH),
    )


@inlined
def embody(plan: Plan, run: Run, actor: int, part: float, bodies: Floats) -> None:
    """Write a body as it is at a part of the step."""
    bodies[actor] = 0.0
    if actor >= len(plan.kinds):
        wall = building(plan.road.buildings, actor - len(plan.kinds))
        bodies[actor, Body.X], bodies[actor, Body.Y] = wall.x, wall.y
        return
    along = along_leg(run, actor, part)
    bodies[actor, Body.X] = on_leg(run, actor, Leg.X0, along)
    bodies[actor, Body.Y] = on_leg(run, actor, Leg.Y0, along)
    for column in range(3):
        bodies[actor, Body.VX + column] = on_leg(run, actor, Leg.VX0 + column, along)
    mass = column_of(plan, run, actor, Column.MASS)
    if not is_fixed(column_of(plan, run, actor, Column.FIXED), mass):
        length, width = column_of(plan, run, actor, Column.LENGTH), column_of(plan, run, actor, Column.WIDTH)
        bodies[actor, Body.LIGHTNESS] = 1.0 / mass
        bodies[actor, Body.EASE] = 1.0 / (plan.gyration[actor] * mass * (length * length + width * width))


@inlined
def takes_part(run: Run, sample: int, actor: int) -> bool:
    """Whether impacts are settled for a body: one that is there and that no host moves."""
    if actor >= len(run.actors):
        return True
    return run.states[sample + 1, actor, State.PRESENT] != 0.0 and run.actors[actor, Slot.FREE] != HOSTED


@inlined
def note_walls(plan: Plan, run: Run, actor: int) -> None:
    """Note whether an actor's leg may lead into a building: of most legs no building need be asked again."""
    begin = run.legs[actor, Leg.BEGIN]
    before, after = outline_on_leg(plan, run, actor, begin), outline_on_leg(plan, run, actor, 1.0)
    run.legs[actor, Leg.NEAR_WALL] = 0.0
    for wall in range(len(plan.road.buildings)):
        if not beside(building(plan.road.buildings, wall), before, after):
            run.legs[actor, Leg.NEAR_WALL] = 1.0


@inlined
def met_up_to(plan: Plan, run: Run, actor: int) -> int:
    """Up to which body, exclusive, there are some that an actor may meet on its leg."""
    return bodies_of(plan) if run.legs[actor, Leg.NEAR_WALL] != 0.0 else len(plan.kinds)


@inlined
def stays_off(plan: Plan, run: Run, before: Box, after: Box, other: int, part: float, until: float) -> bool:
    """Whether an actor that goes from one place to another between two parts of the step cannot come near a body: the
    cheap test that nearly always answers.
    """
    if other >= len(plan.kinds):
        return beside(building(plan.road.buildings, other - len(plan.kinds)), before, after)
    start, end = outline_on_leg(plan, run, other, part), outline_on_leg(plan, run, other, until)
    return circles_apart(before, after, start, end)


@inlined
def beside(wall: Box, before: Box, after: Box) -> bool:
    """Whether a body's circumscribed circle stays beyond one side of a wall all through its step, and does not touch.

    A circle about a wall, which is as long as a street, would nearly always reach who drives along it.
    """
    cos, sin = 1.0, 0.0
    if wall.heading != 0.0:  # asked of every wall in every step, and those of a grid all lie along its axes
        cos, sin = math.cos(wall.heading), math.sin(wall.heading)
    x0, y0, x1, y1 = before.x - wall.x, before.y - wall.y, after.x - wall.x, after.y - wall.y
    ahead0, ahead1 = cos * x0 + sin * y0, cos * x1 + sin * y1
    aside0, aside1 = cos * y0 - sin * x0, cos * y1 - sin * x1
    radius = half_diagonal(before) + 2.0 * TOUCH
    length, width = 0.5 * wall.length + radius, 0.5 * wall.width + radius
    return (
        min(ahead0, ahead1) > length
        or max(ahead0, ahead1) < -length
        or min(aside0, aside1) > width
        or max(aside0, aside1) < -width
    )

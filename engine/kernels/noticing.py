"""Visibility between actors in a run: the view of an actor at a sample, past all other present actors and all
buildings.

An actor sees another in the sector of its view (`viewAngle`, `visibleDistance`) if nothing hides it. A driver of the
library turns its head: it *notices* every actor that nothing hides, as far as the weather permits. An absent actor
neither sees, nor is seen, nor hides another.
"""

import math

from engine.kernels.conflict import Snapshot, time_to_collision
from engine.kernels.geometry import Box, View
from engine.kernels.jit import inlined
from engine.kernels.levels import has_levels
from engine.kernels.pair import ROWS, center_velocity
from engine.kernels.run_state import Plan, Run, Status, column_of, on_one_level, outline_of
from engine.kernels.sight import HIDDEN, OUTSIDE, SEEN, Shades, in_reach, look, may_be_hidden
from engine.tables import SHADE, Floats
from engine.vocabulary import Column, State


@inlined
def visibility(plan: Plan, run: Run, sample: int, viewer: int, target: int) -> int:
    """Return the visibility of an actor from another at a recorded sample: `sight.OUTSIDE`, `HIDDEN` or `SEEN`."""
    if not _both_present(run, sample, viewer, target):
        return OUTSIDE
    box = outline_of(plan, run, sample, target)
    return visibility_past(plan, run, sample, view_of(plan, run, sample, viewer), box, viewer, target)


@inlined
def can_see(plan: Plan, run: Run, sample: int, viewer: int, target: int) -> bool:
    """Return True if one actor sees another at a recorded sample."""
    return bool(visibility(plan, run, sample, viewer, target) == SEEN)


@inlined
def notices(plan: Plan, run: Run, sample: int, viewer: int, target: int, reach: float) -> bool:
    """Return True if nothing hides one actor from another at a recorded sample, in any direction within `reach` [m]."""
    if not _both_present(run, sample, viewer, target):
        return False
    x, y = run.states[sample, viewer, State.X], run.states[sample, viewer, State.Y]
    around = View(x, y, 0.0, 2.0 * math.pi, reach)
    box = outline_of(plan, run, sample, target)
    return bool(visibility_past(plan, run, sample, around, box, viewer, target) == SEEN)


@inlined
def _both_present(run: Run, sample: int, viewer: int, target: int) -> bool:
    """Return True if two actors are present, on one level."""
    present = run.states[sample, viewer, State.PRESENT] != 0.0 and run.states[sample, target, State.PRESENT] != 0.0
    return bool(present and on_one_level(run, viewer, target))


@inlined
def view_of(plan: Plan, run: Run, sample: int, viewer: int) -> View:
    """Return an actor's field of view at a recorded sample."""
    return View(
        run.states[sample, viewer, State.X],
        run.states[sample, viewer, State.Y],
        run.states[sample, viewer, State.HEADING],
        column_of(plan, run, viewer, Column.VIEW_ANGLE),
        column_of(plan, run, viewer, Column.VIEW_DISTANCE),
    )


@inlined
def visibility_past(plan: Plan, run: Run, sample: int, view: View, target: Box, viewer: int, looked_at: int) -> int:
    """Return the visibility of an outline past all actors except `viewer` and `looked_at` (-1: no such actor)."""
    if not in_reach(view, target):
        return OUTSIDE
    count = len(plan.kinds)
    if not others_hide(plan, run, viewer, looked_at):
        if len(plan.road.buildings) == 0 and _is_around(view, target.x, target.y):
            return SEEN  # nearly always on a road: nothing could hide the target
        count = 0
    elif run.status[Status.SHADED] != sample or has_levels(plan):
        _cast_shades(plan, run, sample, viewer)
    return look(view, target, Shades(run.shades, 0, count, viewer, looked_at), plan.road.buildings)


@inlined
def hides(plan: Plan, run: Run, actor: int) -> bool:
    """Return True if an actor hides others while it is present."""
    return column_of(plan, run, actor, Column.OCCLUDING) != 0.0


@inlined
def others_hide(plan: Plan, run: Run, viewer: int, looked_at: int) -> bool:
    """Return True if an actor except `viewer` and `looked_at` (-1: no such actor) hides others."""
    number = 0
    for actor in range(len(plan.kinds)):
        number += 1 if actor != viewer and actor != looked_at and hides(plan, run, actor) else 0
    return number > 0


@inlined
def _is_around(view: View, x: float, y: float) -> bool:
    """Return True if a point is within the distance of a view that covers all directions."""
    dx, dy = x - view.x, y - view.y
    return view.angle >= 2.0 * math.pi and view.distance >= 0.0 and dx * dx + dy * dy <= view.distance * view.distance


@inlined
def _cast_shades(plan: Plan, run: Run, sample: int, viewer: int) -> None:
    """Note the outlines that hide at a sample: once for all looks, on a road with levels once for each viewer."""
    for actor in range(len(plan.kinds)):
        box, at = outline_of(plan, run, sample, actor), actor * SHADE
        run.shades[at], run.shades[at + 1], run.shades[at + 2] = box.x, box.y, box.heading
        run.shades[at + 3], run.shades[at + 4] = box.length, box.width
        is_present = run.states[sample, actor, State.PRESENT] != 0.0
        if viewer >= 0 and not on_one_level(run, viewer, actor):
            is_present = False
        run.shades[at + 5] = column_of(plan, run, actor, Column.OCCLUDING) if is_present else 0.0
    run.status[Status.SHADED] = sample


@inlined
def sees_within(plan: Plan, run: Run, sample: int, me: int, distance: float) -> bool:
    """Return True if `me` sees a present actor whose centre is nearer than `distance` [m]."""
    states = run.states
    x, y = states[sample, me, State.X], states[sample, me, State.Y]
    for other in range(states.shape[1]):
        if other == me or states[sample, other, State.PRESENT] == 0.0:
            continue
        dx, dy = states[sample, other, State.X] - x, states[sample, other, State.Y] - y
        if distance > 0.0 and dx * dx + dy * dy < distance * distance and can_see(plan, run, sample, me, other):
            return True
    return False


# -- sightings by the ego ----------------------------------------------------------------------------------------------

FIRST_SEEN, TTC_THEN, HIDDEN_TIME = (ROWS.index(name) for name in ("first_seen", "ttc_at_first_sight", "hidden_time"))


@inlined
def note_sightings(plan: Plan, run: Run, samples: int, ending: float, outlines: Floats, pairs: Floats) -> None:
    """Write `first_seen`, `ttc_at_first_sight` and `hidden_time` into the row of each pair, from the first `samples`
    samples of a run and the part `ending` of the step after them; `outlines` as in `pair.measure_pair`.

    Visibility at a sample holds for the step after it. If no other actor and no building can hide it, an actor that was
    seen once needs no further test.
    """
    walls, hiding = len(plan.road.buildings) > 0, 0
    for pair in range(len(pairs)):
        hiding += 1 if hides(plan, run, pair + 1) else 0
        pairs[pair, FIRST_SEEN] = pairs[pair, TTC_THEN] = math.nan
        pairs[pair, HIDDEN_TIME] = 0.0
    for sample in range(samples):
        for other in range(1, len(plan.kinds)):
            pair = other - 1
            unseen = math.isnan(pairs[pair, FIRST_SEEN])
            hideable = walls or hiding > (1 if hides(plan, run, other) else 0)
            looks = unseen or (hideable and _may_be_hidden(plan, run, sample, 0, other))
            verdict = visibility(plan, run, sample, 0, other) if looks else OUTSIDE
            if verdict == HIDDEN:
                pairs[pair, HIDDEN_TIME] += 1.0 if sample + 1 < samples else ending
            if verdict == SEEN and unseen:
                pairs[pair, FIRST_SEEN] = sample * plan.layout.time_step
                pairs[pair, TTC_THEN] = time_to_collision(_pair(plan, run, sample, samples, other, outlines))
    for pair in range(len(pairs)):
        pairs[pair, HIDDEN_TIME] *= plan.layout.time_step


@inlined
def _may_be_hidden(plan: Plan, run: Run, sample: int, viewer: int, target: int) -> bool:
    """Return False if an actor is certainly not hidden from another at a recorded sample."""
    if not _both_present(run, sample, viewer, target):
        return False
    if run.status[Status.SHADED] != sample or has_levels(plan):
        _cast_shades(plan, run, sample, viewer)
    shades = Shades(run.shades, 0, len(plan.kinds), viewer, target)
    box = outline_of(plan, run, sample, target)
    return may_be_hidden(view_of(plan, run, sample, viewer), box, shades, plan.road.buildings)


@inlined
def _pair(plan: Plan, run: Run, sample: int, samples: int, other: int, outlines: Floats) -> Snapshot:
    step = plan.layout.time_step
    return Snapshot(
        outline_of(plan, run, sample, 0),
        outline_of(plan, run, sample, other),
        center_velocity(run.states, samples, sample, step, 0, outlines[0, 2]),
        center_velocity(run.states, samples, sample, step, other, outlines[other, 2]),
    )

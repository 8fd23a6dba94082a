"""Results of a run that `maximize` and `minimize` may name.

With several actors they are those of the actor nearest to the ego. `engine.kernels.judging` computes them; a new result
is a row here and a case there.
"""

from engine.frozen import frozen


@frozen
class NamedResult:
    """One result."""

    name: str
    unit: str
    """SI unit word, "" for pure numbers."""
    sentence: str
    of_pair: bool = True
    """True if it requires a second actor."""


NAMED_RESULTS: tuple[NamedResult, ...] = (
    NamedResult("min_distance", "m", "Least distance of the outlines; 0 on contact."),
    NamedResult("max_closing_speed", "m/s", "Fastest closing speed of the centres."),
    NamedResult("distance_at_ms", "m", "Distance at the instant of the largest closing speed."),
    NamedResult("ttc_at_ms", "s", "That distance divided by that closing speed."),
    NamedResult("closing_speed", "m/s", "Closing speed of the centres at the closest approach, or at contact."),
    NamedResult("ego_speed", "m/s", "Speed of the ego at the closest approach, or at contact."),
    NamedResult("other_speed", "m/s", "Speed of the other at the closest approach, or at contact."),
    NamedResult("hidden_time", "s", "How long the other was hidden inside the ego's field of view."),
    NamedResult(
        "delta_v", "m/s", "Change of the ego's velocity in a collision with the velocities at the closest approach."
    ),
    NamedResult("post_encroachment_time", "s", "Least time between both being at the same place; 0 on contact."),
    NamedResult("end_time", "s", "When the run ends.", of_pair=False),
)
"""A program stores the name of a result, never its place in this table."""

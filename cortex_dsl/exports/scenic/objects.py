"""`new` in Scenic: every object that stood somewhere is put there by numbers, whatever placed it."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

from cortex_dsl.exports.scenic.expressions import Expressions, heading_from_north
from cortex_dsl.exports.scenic.sheet import NOWHERE, Unsaid, verbatim
from cortex_dsl.exports.scenic.words import NO_LONGER
from cortex_dsl.semantics.model.values import Actor, Pose, Value
from cortex_dsl.semantics.quantities.algebra import closed_value
from cortex_dsl.syntax import nodes
from engine.interchange.recording import Recording
from engine.vocabulary import State

SIZES = ("width", "length")


@dataclass(frozen=True)
class Stand:
    """Where something stood: metres, and the heading from the east [rad]."""

    x: float
    y: float
    heading: float

    def specifiers(self) -> list[nodes.Specifier]:
        """Scenic's headings are measured from the north."""
        place, heading = f"({self.x!r}, {self.y!r})", repr(self.heading - math.pi / 2.0)
        return [nodes.At(verbatim(place), span=NOWHERE), nodes.Facing(verbatim(heading), span=NOWHERE)]


def made(to: Expressions, node: nodes.New) -> nodes.New:
    """The same `new` for Scenic."""
    to.declare(node.class_name)
    value = to.value(node)
    stand = _stand(value, to.recording)
    given = [each for each in node.specifiers if isinstance(each, nodes.With)]
    kept = (each for with_ in given for each in _property(to, with_))
    placed = stand.specifiers() if stand else list(map(partial(_placing, to), _placings(node)))
    added = _sizes(value, to.recording, given) if isinstance(value, Actor) else []
    free = [] if node.class_name in ("Point", "OrientedPoint") else [_with("regionContainedIn", "everywhere")]
    return replace(node, specifiers=(*placed, *kept, *added, *free))


def _stand(value: Value, recording: Recording) -> Stand | None:
    """Where an object was when it came in, or where a place is; None where that is not one place."""
    if isinstance(value, Actor):
        return _first_seen(value.index, recording)
    if isinstance(value, Pose):
        x, y, heading = map(closed_value, (value.x, value.y, value.heading))
        if x is not None and y is not None and heading is not None:
            return Stand(x, y, heading)
    return None


def _first_seen(actor: int, recording: Recording) -> Stand | None:
    for first, _ in recording.stretches(actor):
        state = recording.states[first, actor]
        return Stand(float(state[State.X]), float(state[State.Y]), float(state[State.HEADING]))
    return None


def _placings(node: nodes.New) -> Iterator[nodes.Specifier]:
    return (each for each in node.specifiers if not isinstance(each, nodes.With))


def _placing(to: Expressions, specifier: nodes.Specifier) -> nodes.Specifier:
    """Where an object goes that has no one place."""
    if isinstance(specifier, nodes.Before):
        raise Unsaid(f"`{'after' if isinstance(specifier, nodes.After) else 'before'} … by`", specifier.span)
    if isinstance(specifier, nodes.Facing) and not specifier.mode:
        return replace(specifier, heading=heading_from_north(to, specifier.heading))
    return to.parts(specifier)


def _property(to: Expressions, specifier: nodes.With) -> Iterator[nodes.Specifier]:
    """A property, unless every object gets it, or its value cannot be said."""
    if specifier.property in NO_LONGER:
        return
    try:
        yield to.parts(specifier)
    except Unsaid as unsaid:
        told = f"Scenic has no {unsaid.what}: `with {specifier.property}` is left out"
        to.sheet.remark(told, unsaid.span)


def _sizes(actor: Actor, recording: Recording, given: Sequence[nodes.With]) -> list[nodes.Specifier]:
    """Length and width, unless the author gives them."""
    recorded = recording.actors[actor.index]
    said = {specifier.property for specifier in given}
    return [_with(name, repr(float(getattr(recorded, name)))) for name in SIZES if name not in said]


def _with(name: str, value: str) -> nodes.Specifier:
    return nodes.With(name, verbatim(value), span=NOWHERE, property_span=NOWHERE)

"""What an expression of the language may be worth while a file is elaborated.

A number or truth is always an `ir.Expr` (a `Literal` when it is known). Everything else is concrete: text is a `str`,
`none` is None, lists and tuples are Python tuples, enum members are the engine's, and lanes, maneuvers, intersections
and the network are the objects of `engine.road`. Objects of the scene, and what a file defines, stand in
`definitions`; how values are told to people, in `wording`.
"""

from collections.abc import Callable

from cortex_dsl import ir
from cortex_dsl.source import Span
from engine.frozen import frozen, frozen_identity
from engine.road.network import Intersection, Lane
from engine.vocabulary import Command

Value = object


@frozen
class Quantity:
    """A number, SI. Dimension None: written without a unit, so it adopts that of its place."""

    expr: ir.Expr
    dimension: ir.Dimension | None


@frozen
class Truth:
    expr: ir.Expr


@frozen
class Vector:
    """A point of the plane [m]."""

    x: ir.Expr
    y: ir.Expr


@frozen
class Pose:
    """An oriented point [m, rad]."""

    x: ir.Expr
    y: ir.Expr
    heading: ir.Expr
    lane: Lane | None = None
    """The lane along which it surely lies and points, where that is known."""


@frozen
class Region:
    """An area of the network; `id` is that of `network.regions`."""

    id: int
    name: str


@frozen
class Centerline:
    lane: Lane


@frozen
class LaneNow:
    """A lane, or its section, that only the place of an object tells."""

    id: ir.Expr
    """Index in `network.lanes`; -1 where there is no such lane."""
    section: bool


@frozen
class Signal:
    """The traffic light of one arm of an intersection."""

    intersection: Intersection
    arm: int
    """Index in `intersection.legs`."""

    @property
    def name(self) -> str:
        return f"light {self.intersection.legs[self.arm].name} of {self.intersection.name}"


@frozen
class Colour:
    """What a traffic light shows at a moment."""

    index: ir.Expr
    """Index in `signals.COLOURS`."""


@frozen
class Effect:
    """What calling a function changes during the run."""

    acts: ir.Block


@frozen
class DirectionField:
    """`roadDirection`: at every point the direction of the lane there."""


@frozen_identity
class Closure:
    """A lambda."""

    parameters: tuple[str, ...]
    apply: Callable[..., Value]


@frozen
class BuiltinValue:
    """A function, distribution, class, action or library behaviour of the builtins table."""

    name: str


@frozen_identity
class Unfinished:
    """`self` in the default of a property: the object while it is made."""

    attribute: Callable[[str, Span], Value]


@frozen_identity
class ActionCall:
    command: Command
    value: ir.Expr
    name: str


@frozen
class Weights:
    """`{option: weight}` as `Discrete` takes it."""

    entries: tuple[tuple[Value, Value], ...]
    spans: tuple[Span, ...]


@frozen
class EnumValue:
    """The enumeration `ManeuverType` itself."""


@frozen
class GlobalParameters:
    pass


class Poison:
    """The value of what could not be evaluated; using it says nothing more."""


POISON = Poison()


def is_constant(value: Value) -> bool:
    return isinstance(value, Quantity | Truth) and isinstance(value.expr, ir.Literal)

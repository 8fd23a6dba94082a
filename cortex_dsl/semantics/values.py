"""What an expression of the language may be worth while a file is elaborated.

A number or truth is always an `ir.Expr` (a `Literal` when it is known). Everything else is concrete: text is a `str`,
`none` is None, lists and tuples are Python tuples, enum members are the engine's, and lanes, maneuvers, intersections
and the network are the objects of `engine.road`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from cortex_dsl import ir
from cortex_dsl.semantics.quantities.units import dimension_name, si_word
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.road.network import Intersection, Lane, Maneuver, Network
from engine.road.sections import LaneGroup, LaneSection, Road
from engine.vocabulary import ActorKind, Command, ManeuverType

Value = object


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number, SI. Dimension None: written without a unit, so it adopts that of its place."""

    expr: ir.Expr
    dimension: ir.Dimension | None


@dataclass(frozen=True, slots=True)
class Truth:
    expr: ir.Expr


@dataclass(frozen=True, slots=True)
class Vector:
    """A point of the plane [m]."""

    x: ir.Expr
    y: ir.Expr


@dataclass(frozen=True, slots=True)
class Pose:
    """An oriented point [m, rad]."""

    x: ir.Expr
    y: ir.Expr
    heading: ir.Expr
    lane: Lane | None = None
    """The lane along which it surely lies and points, where that is known."""


@dataclass(frozen=True, slots=True)
class Region:
    """An area of the network; `id` is that of `network.regions`."""

    id: int
    name: str


@dataclass(frozen=True, slots=True)
class Centerline:
    lane: Lane


@dataclass(frozen=True, slots=True)
class LaneNow:
    """A lane, or its section, that only the place of an object tells."""

    id: ir.Expr
    """Index in `network.lanes`; -1 where there is no such lane."""
    section: bool


@dataclass(frozen=True, slots=True)
class Signal:
    """The traffic light of one arm of an intersection."""

    intersection: Intersection
    arm: int
    """Index in `intersection.legs`."""

    @property
    def name(self) -> str:
        return f"light {self.intersection.legs[self.arm].name} of {self.intersection.name}"


@dataclass(frozen=True, slots=True)
class Colour:
    """What a traffic light shows at a moment."""

    index: ir.Expr
    """Index in `signals.COLOURS`."""


@dataclass(frozen=True, slots=True)
class Effect:
    """What calling a function changes during the run."""

    acts: ir.Block


@dataclass(frozen=True, slots=True)
class DirectionField:
    """`roadDirection`: at every point the direction of the lane there."""


@dataclass(eq=False)
class Actor:
    """An object of the scene. `properties` hold scene-level values by property name."""

    index: int
    name: str
    kind: ActorKind
    span: Span
    pose: Pose
    properties: dict[str, Value] = field(default_factory=dict)
    scenario: "Instance | None" = None
    """What made it: a scenario that another one starts; None for the top level and the scenario that the run is."""
    overrides: "list[tuple[int, BehaviourCall | None]]" = field(default_factory=list)
    """(monitor, behaviour): what it does while that scenario runs; of several the last one decides."""


@dataclass(frozen=True, eq=False)
class Closure:
    """A lambda."""

    parameters: tuple[str, ...]
    apply: Callable[..., Value]


@dataclass(frozen=True)
class BuiltinValue:
    """A function, distribution, class, action or library behaviour of the builtins table."""

    name: str


@dataclass(frozen=True, eq=False)
class BehaviourValue:
    """A behaviour that the file defines."""

    node: nodes.BehaviorDefinition
    home: dict[str, Value] | None = None
    """Variables of the imported file that defines it; None: the main file."""


@dataclass(frozen=True, eq=False)
class BehaviourCall:
    """A behaviour with its arguments, ready to run."""

    behaviour: BehaviourValue | BuiltinValue
    arguments: Mapping[str, Value]
    spans: Mapping[str, Span]
    span: Span

    @property
    def name(self) -> str:
        return self.behaviour.node.name if isinstance(self.behaviour, BehaviourValue) else self.behaviour.name


@dataclass(frozen=True, eq=False)
class MonitorValue:
    """A monitor that the file defines."""

    node: nodes.MonitorDefinition
    home: dict[str, Value] | None = None


@dataclass(frozen=True, eq=False)
class MonitorCall:
    """A monitor with its arguments, ready to be required."""

    monitor: MonitorValue
    arguments: Mapping[str, Value]
    spans: Mapping[str, Span]
    span: Span

    @property
    def name(self) -> str:
        return self.monitor.node.name


@dataclass(frozen=True, eq=False)
class ClassValue:
    """A class that a file defines, ready to be made objects of."""

    node: nodes.ClassDefinition
    kind: ActorKind
    bases: "tuple[ClassValue, ...]"
    """The classes that it is made of, nearest first."""
    scopes: tuple[Mapping[str, Value], ...] = ()
    home: dict[str, Value] | None = None
    """Where its defaults look names up."""


@dataclass(frozen=True, eq=False)
class Unfinished:
    """`self` in the default of a property: the object while it is made."""

    attribute: Callable[[str, Span], Value]


@dataclass(frozen=True, eq=False)
class Namespace:
    """An imported file."""

    file: str
    names: Mapping[str, Value]


@dataclass(frozen=True, eq=False)
class ScenarioValue:
    """A scenario that a file defines."""

    node: nodes.ScenarioDefinition
    home: dict[str, Value] | None = None


@dataclass(eq=False)
class Instance:
    """A scenario that is to run: its variables, what it made, and the monitor that runs it."""

    name: str = ""
    names: dict[str, Value] = field(default_factory=dict)
    actors: list[Actor] = field(default_factory=list)
    monitor: int = -1
    watchers: list[int] = field(default_factory=list)
    """The monitors that it requires."""
    children: "list[Instance]" = field(default_factory=list)
    """What its `compose` starts, in the order of the file."""
    parent: "Instance | None" = None
    span: Span | None = None
    """Where it is started."""
    present: bool = True
    """Whether it surely starts with the run, its objects with it."""
    rules: list[nodes.Statement] = field(default_factory=list)
    """Statements of its setup that speak of the run."""

    @property
    def ego(self) -> Actor | None:
        ego = self.names.get("ego")
        return ego if isinstance(ego, Actor) else None

    @property
    def family(self) -> "tuple[Instance, ...]":
        """Itself and all that it starts, directly or not."""
        return (self, *(each for child in self.children for each in child.family))


@dataclass(eq=False)
class ScenarioCall:
    """A scenario with its arguments, ready to be started; `instance` once it has been."""

    scenario: ScenarioValue
    arguments: Mapping[str, Value]
    spans: Mapping[str, Span]
    span: Span
    instance: Instance | None = None

    @property
    def name(self) -> str:
        return self.scenario.node.name


@dataclass(frozen=True, eq=False)
class ActionCall:
    command: Command
    value: ir.Expr
    name: str


@dataclass(frozen=True)
class Weights:
    """`{option: weight}` as `Discrete` takes it."""

    entries: tuple[tuple[Value, Value], ...]
    spans: tuple[Span, ...]


@dataclass(frozen=True)
class EnumValue:
    """The enumeration `ManeuverType` itself."""


@dataclass(frozen=True)
class GlobalParameters:
    pass


class Poison:
    """The value of what could not be evaluated; using it says nothing more."""


POISON = Poison()


def is_constant(value: Value) -> bool:
    return isinstance(value, Quantity | Truth) and isinstance(value.expr, ir.Literal)


_KINDS: tuple[tuple[type | tuple[type, ...], str], ...] = (
    (Truth, "a truth value"),
    (Vector, "a point"),
    (Pose, "an oriented point"),
    (Region, "a region"),
    (Centerline, "a centre line"),
    (LaneNow, "a lane"),
    (LaneSection, "a lane section"),
    (LaneGroup, "a lane group"),
    (Road, "a road"),
    (Signal, "a traffic light"),
    (Colour, "the colour of a traffic light"),
    (Effect, "nothing"),
    (DirectionField, "a direction field"),
    (Closure, "a lambda"),
    (BehaviourValue, "a behavior"),
    (BehaviourCall, "a behavior"),
    (ClassValue, "a class"),
    (Namespace, "an imported file"),
    (ScenarioValue, "a scenario"),
    (ScenarioCall, "a scenario"),
    (MonitorValue, "a monitor"),
    (MonitorCall, "a monitor"),
    (ActionCall, "an action"),
    (Weights, "a dictionary"),
    (EnumValue, "an enumeration"),
    (ManeuverType, "a maneuver type"),
    (GlobalParameters, "`globalParameters`"),
    (Lane, "a lane"),
    (Maneuver, "a maneuver"),
    (Intersection, "an intersection"),
    (Network, "the network"),
    (str, "text"),
    (tuple, "a list"),
)


def kind_name(value: Value) -> str:
    """What a value is, for messages: `a length`, `a lane`."""
    if value is None:
        return "none"
    if isinstance(value, Quantity):
        return dimension_name(value.dimension)
    if isinstance(value, Actor):
        return f"an object ({value.kind.name.capitalize()})"
    if isinstance(value, BuiltinValue):
        return f"`{value.name}`"
    return next((name for kind, name in _KINDS if isinstance(value, kind)), "something else")


def option_name(value: Value) -> str:
    """How one option of a choice is shown to people."""
    if isinstance(value, Lane | Maneuver | Intersection | Actor | Region | LaneSection | LaneGroup | Road | Signal):
        return value.name
    if isinstance(value, ManeuverType):
        return value.name
    if isinstance(value, str):
        return value
    if isinstance(value, Quantity | Truth) and isinstance(value.expr, ir.Literal):
        return source_text(value) or kind_name(value)
    if isinstance(value, tuple):
        return "[" + ", ".join(option_name(item) for item in value) + "]"
    return kind_name(value)


def number_text(number: float) -> str:
    """Digits that bring back the same number; whole ones without a point."""
    return str(int(number)) if number.is_integer() and abs(number) < 1e15 else repr(number)


def source_text(value: Value) -> str | None:
    """Text that names a value again in the language; None where there is none."""
    match value:
        case None:
            return "None"
        case Lane() | Maneuver() | Intersection() | LaneSection() | Road():
            return value.source
        case ManeuverType():
            return f"ManeuverType.{value.name}"
        case str():
            return '"' + value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'
        case Truth(ir.Literal(value=number)):
            return "True" if number else "False"
        case Quantity(ir.Literal(value=number), dimension):
            unit = si_word(dimension)
            return f"{number_text(number)} {unit}".rstrip()
        case tuple():
            items = [source_text(item) for item in value]
            return None if None in items else "[" + ", ".join(filter(None, items)) + "]"
    return None

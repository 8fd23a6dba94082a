"""Values of expressions during elaboration, and definitions of a file.

A number or truth is always a `Term` (a `Literal` when it is known). Everything else is concrete: text is a `str`,
`none` is None, lists and tuples are Python tuples, enum members are the engine's, and lanes, maneuvers, intersections
and the network are the objects of `engine.road`. `wording` shows values to users. The `home` of a definition holds the
variables of the imported file that contains it; None is the main file.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Self

from cortex_dsl import ir
from cortex_dsl.semantics.quantities.algebra import Term
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.frozen import frozen, frozen_identity
from engine.road.network import Intersection, Lane, Surface
from engine.vocabulary import ActorKind, Command

# -- field of view -----------------------------------------------------------------------------------------------------


@frozen
class View:
    """How far [m], and within which opening angle about its heading [rad]."""

    reach: Term
    opening: Term


Value = object


@frozen
class Quantity:
    """A number, SI. Dimension None: written without a unit, so it adopts that of its place."""

    expr: Term
    dimension: ir.Dimension | None


@frozen
class Truth:
    expr: Term


@frozen
class Vector:
    """A point of the plane [m]."""

    x: Term
    y: Term
    view: View | None = field(default=None, kw_only=True)  # of its own, if it was made with one


@frozen
class Pose:
    """An oriented point [m, rad]."""

    x: Term
    y: Term
    heading: Term
    lane: "Lane | LaneNow | None" = None
    """The lane along which it surely lies and points, where that is known, or drawn with the scene."""
    view: View | None = field(default=None, kw_only=True)


@frozen
class Region:
    """An area of the network; `id` is that of `network.regions`."""

    id: int
    name: str


@frozen
class Centerline:
    lane: "Lane | LaneNow | Surface"


@frozen
class Alignment:
    """A path of lines, arcs and clothoids; a condition of the scene may choose it among several."""

    path: Term
    """Id in the paths of the network."""
    sharpest: Term
    """Largest magnitude of its curvature [1/m]."""


@frozen
class LaneNow:
    """A lane, or its section, that the run knows from the place of an object, or that is drawn with the scene."""

    id: Term
    """Index in `network.lanes`; -1 where there is no such lane."""
    section: bool
    drawn: frozenset[Span] = frozenset()
    """Places at which it was drawn with the scene; such a lane exists."""


@frozen
class GroupNow:
    """The lane group of a lane that only the scene or the run knows, or the opposite group of its road."""

    lane: LaneNow
    opposite: bool


@frozen
class SurfaceNow:
    """A surface that only the scene or the run knows, or that is drawn with the scene."""

    options: "tuple[Surface | None, ...]"
    """Surfaces that it may be; None where there is none."""
    index: Term
    """Index in `options`."""
    drawn: frozenset[Span] = frozenset()
    """Places at which it was drawn with the scene."""


@frozen
class Signal:
    """The traffic light of one arm of an intersection; `arm` is an index in its `legs`."""

    intersection: Intersection
    arm: int

    @property
    def name(self) -> str:
        return f"light {self.intersection.legs[self.arm].name} of {self.intersection.name}"


@frozen
class Colour:
    """Colour of a traffic light at a moment."""

    index: Term  # in `signals.COLOURS`


@frozen
class Effect:
    """Effect of a function call during the run."""

    acts: ir.Block


@frozen_identity
class DirectionField:
    """A heading at every point. `roadDirection` has no `at`: the direction of the lane there."""

    at: Callable[[Vector], Term] | None = None
    steps: tuple[int, float] = (4, 5.0)  # of following it: least number, usual length [m]


@frozen
class Sighted:
    """The part of a region that is in the view of an object (`seen`), or out of it."""

    region: Value
    viewer: "Actor | Pose | Vector"
    seen: bool


@frozen_identity
class Closure:
    """A lambda; `body` is the text after its colon, unless a variable hides `ManeuverType` there."""

    parameters: tuple[str, ...]
    apply: Callable[..., Value]
    body: nodes.Expression | None = None
    optional: int = 0
    """Number of the last parameters that may be left out."""


@frozen_identity
class Function:
    """A function that the file defines; `apply` takes the moment of the call and its arguments by name."""

    name: str
    parameters: tuple[nodes.Parameter, ...]
    apply: Callable[..., Value]


@frozen
class SimulationNow:
    """`simulation()`: the running simulation."""


@frozen
class BuiltinValue:
    """A function, distribution, class, action or library behaviour of the builtins table."""

    name: str


@frozen_identity
class Unfinished:
    """`self` in the default of a property: the object while it is made."""

    attribute: Callable[[str, Span], Value]


@frozen
class DoorCall:
    """The acts of an action that opens a door."""

    acts: ir.Block


@frozen_identity
class ActionCall:
    command: Command
    value: Term
    name: str
    fits: Term | None = None
    """Condition without which the run is aborted."""


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
    """Value of an expression with an error; using it reports no further error."""


POISON = Poison()


def is_constant(value: Value) -> bool:
    return isinstance(value, Quantity | Truth) and isinstance(value.expr, ir.Literal)


# -- results and definitions of a file ---------------------------------------------------------------------------------


@frozen
class Cell:
    """A property that the run may change: locals for whether it has been assigned, and for its value."""

    assigned: int
    value: int


@dataclass(eq=False)
class Actor:
    """An object of the scene. `properties` hold scene-level values by property name."""

    index: int
    name: str
    kind: ActorKind
    span: Span
    pose: Pose
    properties: dict[str, Value] = field(default_factory=dict)
    scenario: "Instance | None" = None  # maker, if another scenario starts it
    overrides: "list[tuple[int, BehaviourCall | None]]" = field(default_factory=list)
    """(monitor, behaviour): behaviour while that scenario runs; the last running one applies."""
    overridden: "dict[str, list[tuple[int, Quantity | Truth]]]" = field(default_factory=dict)  # likewise, of its own
    plain: bool = False  # an `Object`: nothing is known of it but its place and outline, and it may do things
    cells: "dict[str, Cell]" = field(default_factory=dict)  # its own properties that the run may change
    builtin: str = ""  # the class of the language that it is of
    classes: "tuple[ClassValue, ...]" = ()  # those of the file that it is of, nearest first
    late: bool = False  # it is absent until an act of a behavior or of `compose` lets it enter
    doors: "dict[str, Door]" = field(default_factory=dict)
    """Doors that its behavior opens, by side."""
    door_of: "Actor | None" = None
    """Vehicle whose door it is."""

    @property
    def present(self) -> bool:
        """Return whether it is there from the start."""
        return not self.late and (self.scenario is None or self.scenario.present)


@frozen_identity
class Door:
    """A door of a vehicle: its actor, and locals for whether it is opened, how fast, and until when."""

    actor: Actor
    opened: int
    pace: int
    until: int


@frozen_identity
class BehaviourValue:
    """A behaviour that the file defines."""

    node: nodes.BehaviorDefinition
    home: dict[str, Value] | None = None
    scopes: tuple[Mapping[str, Value], ...] = ()  # variables of the scenario that defines it


@frozen_identity
class BehaviourCall:
    """A behaviour with its arguments, ready to run."""

    behaviour: BehaviourValue | BuiltinValue
    arguments: Mapping[str, Value]
    spans: Mapping[str, Span]
    span: Span

    @property
    def name(self) -> str:
        return self.behaviour.node.name if isinstance(self.behaviour, BehaviourValue) else self.behaviour.name


@frozen_identity
class MonitorValue:
    """A monitor that the file defines."""

    node: nodes.MonitorDefinition
    home: dict[str, Value] | None = None
    scopes: tuple[Mapping[str, Value], ...] = ()


@frozen_identity
class MonitorCall:
    """A monitor with its arguments, ready to be required."""

    monitor: MonitorValue
    arguments: Mapping[str, Value]
    spans: Mapping[str, Span]
    span: Span

    @property
    def name(self) -> str:
        return self.monitor.node.name


@frozen_identity
class ClassValue:
    """A class that a file defines, ready to be made objects of."""

    node: nodes.ClassDefinition
    kind: ActorKind
    bases: "tuple[ClassValue, ...]"
    """The classes that it is made of, nearest first."""
    scopes: tuple[Mapping[str, Value], ...] = ()
    home: dict[str, Value] | None = None  # where its defaults look names up


@frozen_identity
class Namespace:
    """An imported file."""

    file: str
    names: Mapping[str, Value]


@frozen_identity
class ScenarioValue:
    """A scenario that a file defines."""

    node: nodes.ScenarioDefinition
    home: dict[str, Value] | None = None


@dataclass(eq=False)
class Instance:
    """A scenario to run: its variables, its objects, and its monitor."""

    name: str = ""
    names: dict[str, Value] = field(default_factory=dict)
    actors: list[Actor] = field(default_factory=list)
    monitor: int = -1
    watchers: list[int] = field(default_factory=list)  # the monitors that it requires
    children: "list[Instance]" = field(default_factory=list)
    """Scenarios that its `compose` starts, in the order of the file."""
    parent: "Instance | None" = None
    span: Span | None = None  # where it is started
    present: bool = True
    """Whether it surely starts with the run, its objects with it."""
    rules: list[nodes.Statement] = field(default_factory=list)
    """Statements of its setup that speak of the run."""
    entering: list[ir.Act] = field(default_factory=list)
    """Acts of its objects whose places are worked out when it starts."""

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


# -- lists with their origin -------------------------------------------------------------------------------------------


class Filtered(tuple[Value, ...]):
    """Items that a condition selected of `among`; `among` is empty for a list without a condition."""

    among: tuple[Value, ...] = ()

    def of(self, among: tuple[Value, ...]) -> Self:
        self.among = among
        return self


class Items(Filtered):
    """A list of the file. Unlike tuples, lists with equal items are distinct, so that `append` finds its list."""

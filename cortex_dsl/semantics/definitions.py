"""What a file makes and defines: objects, behaviours, monitors, classes, scenarios, and calls of them.

The `home` of a definition holds the variables of the imported file that has it; None stands for the main file.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from cortex_dsl.semantics.values import BuiltinValue, Pose, Value
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.frozen import frozen_identity
from engine.vocabulary import ActorKind


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


@frozen_identity
class BehaviourValue:
    """A behaviour that the file defines."""

    node: nodes.BehaviorDefinition
    home: dict[str, Value] | None = None
    """Variables of the imported file that defines it; None: the main file."""


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
    home: dict[str, Value] | None = None
    """Where its defaults look names up."""


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

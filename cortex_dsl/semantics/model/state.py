"""State of elaboration: of the file as a whole and of one variant, with the fixed-time plan of its traffic lights."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import islice

from cortex_dsl import ir
from cortex_dsl.semantics.errors.problems import Findings, Mistake
from cortex_dsl.semantics.errors.runs import TOO_MANY_BODIES
from cortex_dsl.semantics.model.choices import Decisions, Pool
from cortex_dsl.semantics.model.limits import Budget, Depth
from cortex_dsl.semantics.model.values import Actor, Instance, MonitorCall, Value
from cortex_dsl.semantics.names.linking import ImportedFile
from cortex_dsl.semantics.quantities.algebra import Algebra, Term
from cortex_dsl.semantics.quantities.bounds import Interval, Weight
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import nodes
from engine.control import Control
from engine.frozen import frozen
from engine.maps import MapFile, MapSpec, RoadSpec
from engine.program import Settings
from engine.road.network import Network
from engine.vocabulary import GeneKind, RuleKind

# -- the plan of the traffic lights ------------------------------------------------------------------------------------

COLOURS = ("None", "green", "yellow", "red", "off", "unknown")
"""Colours of a light, by number; `None` without a light. CARLA's names, as in Scenic's scripts."""
NONE, GREEN, YELLOW, RED, OFF, UNKNOWN = range(len(COLOURS))

DEFAULT_GREEN = 10.0
DEFAULT_YELLOW = 3.0
DEFAULT_ALL_RED = 2.0
"""Red clearance of CARLA's lights [s], as the other two durations. The Manual on Uniform Traffic Control Devices
(2009), section 4D.26, and practice ask for yellow of 3 to 6 s and red clearance of 1 to 2 s."""

PHASES = 2
"""Number of phases: opposite arms are green together, first north and south, then east and west."""


@frozen
class SignalPlan:
    """Times in seconds, as expressions over genes and constants."""

    green: Term
    yellow: Term
    all_red: Term
    offset: Term
    """Offset of the start of the run in the plan."""
    controls: "Controls | None" = None

    def as_ir(self) -> ir.Lights:
        return ir.Lights(self.green, self.yellow, self.all_red, self.offset, controlled=self.controls is not None)


@frozen
class Controls:
    """Locals by which behaviours and monitors change the lights; only where a file does so."""

    frozen: int
    """1 while the lights are stopped."""
    frozen_at: int
    """Clock of the lights while they are stopped [s]."""
    lost: int
    """Total duration of earlier stops [s]."""
    colours: tuple[int, ...]
    """Colour that each light was set to; 0: none."""
    changes: tuple[int, ...]
    """Number of colour changes of the plan when each light was set; the next change cancels the setting."""


# -- the file, and a variant of it -------------------------------------------------------------------------------------

BODY_LIMIT = 2_000
"""Maximum number of behaviours and scenarios that are inlined in a variant."""
BODY_COST = 40
"""Cost of inlining one behaviour or scenario, in evaluations."""

RuleKey = tuple[Span, RuleKind]
Scope = Instance | str
"""Owner of variables: a scenario, or a file by its name; the main file has an empty name."""


MapFinder = Callable[[str], str | None]
"""Function from the name of a map to its file; None without a file."""


def no_maps(_: str) -> str | None:
    """Return None: a text without a file has no map files next to it."""
    return None


@dataclass
class FileContext:
    """State that all variants of a file share."""

    source: Source
    overrides: Mapping[str, nodes.Expression]
    """`-p` values by param name; their spans are those of the params that they replace."""
    imports: Mapping[Span, ImportedFile] = field(default_factory=dict)
    """File of each import statement."""
    default_road: RoadSpec = field(default_factory=RoadSpec)
    """Road of a file without `map`."""
    expanded: frozenset[Span] = frozenset()
    """Sites of numeric choices that are enumerated, because their values are needed concretely."""
    draws_lanes: bool = False
    """Whether lanes that are chosen at random are drawn with the scene, where no variant has to know them."""
    findings: Findings = field(default_factory=Findings)
    pool: Pool = field(default_factory=Pool)
    genes: dict[str, ir.GeneInfo] = field(default_factory=dict)
    _gene_numbers: dict[str, int] = field(default_factory=dict)
    _bounds: dict[int, Interval] = field(default_factory=dict)
    """Bounds of the first `_bounded` genes."""
    _bounded: int = 0
    gene_dimensions: dict[int, set[ir.Dimension]] = field(default_factory=dict)
    """Dimensions of the places that use a gene without a unit, by the number of the gene."""
    find_map: MapFinder = no_maps
    has_map: bool = False
    """Whether the file has a `map` statement; a `param map` is ignored then."""
    map_files: dict[str, MapFile] = field(default_factory=dict)
    """Map files that were found, by their names in this file."""
    networks: dict[MapSpec, Network] = field(default_factory=dict)
    filtered: dict[tuple[Span, tuple[Value, ...]], tuple[Value, ...]] = field(default_factory=dict)
    """Elements of the road that satisfy a condition, by the place of the condition and the items."""
    uses_road: dict[Span, bool] = field(default_factory=dict)
    """Whether a condition is about elements of the road, by its place."""
    settings: Settings = field(default_factory=Settings)
    entry: nodes.ScenarioDefinition | None = None
    """Scenario to run; None: only the top level."""
    budget: Budget = field(default_factory=Budget)
    max_steps: int | None = None
    """Number of steps in `terminate after N steps`."""
    has_plan: bool = False
    """Whether the file has a `signals` statement."""
    default_signals: Span | None = None
    """Line of a Scenic script that names a map with traffic lights."""
    from_scenic: bool = False
    """Whether the file has Scenic's `model` line: absolute headings then count from north, as there."""
    attributes_read: frozenset[str] = frozenset()
    """Every name after a dot; a property that is read and is not built in belongs to the file."""
    attributes_set: frozenset[str] = frozenset()
    """Every attribute that the run may change."""
    weights: dict[Span, Weight] = field(default_factory=dict)
    """Weight of each `require`, by the place of its condition."""
    places: dict[Span, bool] = field(default_factory=dict)
    """Whether a region in which something is placed can hold a place, by the place of the region."""
    temporals: dict[Span, nodes.Require] = field(default_factory=dict)
    """The temporal requirements, in the order of the file."""
    records: dict[str, tuple[Span, ir.Record]] = field(default_factory=dict)
    """Recorded values and their places, by name."""
    objectives: dict[Span, tuple[nodes.Expect | nodes.Optimize, ir.Objective]] = field(default_factory=dict)
    """Expectations and optimization objectives, by their place; their formulas are added later."""
    readings: list[ir.Reading] = field(default_factory=list)
    """Results of a finished run that the objectives read; all variants number them alike."""
    rules: dict[RuleKey, str] = field(default_factory=dict)
    """Name of every rule, by its place and kind, in the order met; all variants number them alike."""
    _rule_numbers: dict[RuleKey, int] = field(default_factory=dict)
    controls: dict[str, Control] = field(default_factory=dict)
    """Actors with an external controller, by the name of the controller; all variants number them alike."""

    def gene_index(self, name: str) -> int:
        """Number of a gene, in the order of the file."""
        if name not in self._gene_numbers:
            for known, _ in self._genes_since(len(self._gene_numbers)):
                self._gene_numbers[known] = len(self._gene_numbers)
        return self._gene_numbers[name]

    def _genes_since(self, count: int) -> list[tuple[str, ir.GeneInfo]]:
        """Return the genes after the first `count`, in order, without visiting earlier ones."""
        return list(islice(reversed(self.genes.items()), len(self.genes) - count))[::-1]

    def gene_bounds(self) -> dict[int, Interval]:
        """SI bounds of every gene that stands for its own value."""
        if self._bounded == len(self.genes):
            return self._bounds
        for i, (_, g) in enumerate(self._genes_since(self._bounded), self._bounded):
            if g.kind != GeneKind.INDEX:
                self._bounds[i] = g.low * g.scale, g.high * g.scale
        self._bounded = len(self.genes)
        return self._bounds

    def rule(self, span: Span, name: str, kind: RuleKind = RuleKind.TERMINATE) -> int:
        """Number of the rule of this kind written at `span`."""
        self.rules.setdefault((span, kind), name)
        return self._rule_numbers.setdefault((span, kind), len(self._rule_numbers))

    def reading(self, reading: ir.Reading) -> int:
        """Number of a reading."""
        if reading not in self.readings:
            self.readings.append(reading)
        return self.readings.index(reading)

    def line(self, span: Span) -> int:
        """Counted through all files."""
        return self.source.row(span.start)


@frozen
class Environment:
    """Arguments of `environment` in SI units, and its place."""

    values: Mapping[str, Term]
    span: Span


@dataclass
class Built:
    """Results of a variant so far: objects, coroutines, requirements, and their road."""

    actors: list[Actor] = field(default_factory=list)
    actor_names: set[str] = field(default_factory=set)
    numbered: int = 1
    """Next number of an object; 0 is the ego's."""
    first_ego: Actor | None = None
    """Ego of the first scenario that is started, if the scenario that starts it has none."""
    mutations: dict[Scope, list[nodes.Mutate]] = field(default_factory=dict)
    """The `mutate` statements of every scope."""
    mutated: set[tuple[Scope, str]] = field(default_factory=set)
    """Scopes and names of objects with noise."""
    has_set_up: bool = False
    """Whether a scenario with a setup was set up."""
    network: Network | None = None
    signals: SignalPlan | None = None
    environment: Environment | None = None
    requirements: list[ir.Requirement] = field(default_factory=list)
    rule_conditions: dict[RuleKey, Term] = field(default_factory=dict)
    objectives: dict[Span, Term] = field(default_factory=dict)
    """Terms of `maximize` and `minimize`, evaluated after the run, by their place."""
    monitors: list[ir.Monitor | None] = field(default_factory=list)
    """Coroutines without an actor, by number; None while the body is compiled."""
    required_monitors: list[tuple[str | None, MonitorCall, Span]] = field(default_factory=list)
    """Name (None without one), call and place of each required monitor."""
    zeroed: set[int] = field(default_factory=set)
    """Locals that nothing but an assignment to an object's own property sets."""
    local_count: int = 0
    scope_count: int = 0


@dataclass
class VariantState:
    """One combination of all finite choices during its elaboration."""

    file: FileContext
    decisions: Decisions
    algebra: Algebra = field(default_factory=Algebra)
    built: Built = field(default_factory=Built)
    depth: Depth = field(default_factory=Depth)
    names: dict[str, Value] = field(default_factory=dict)
    """The module's variables."""
    imported: dict[str, dict[str, Value]] = field(default_factory=dict)
    """Variables of the imported files, by file name."""
    params: dict[str, Value] = field(default_factory=dict)
    root: Instance = field(default_factory=Instance)
    """Scenario to run, with the top level of the file."""
    compared: dict[Term, ir.Dimension | None] = field(default_factory=dict)
    """Dimension of the operands of each comparison."""
    redrawn: dict[Term, Callable[..., Value]] = field(default_factory=dict)
    """Function that draws another sample of a random number, by the number."""
    assigning: str = ""
    """Name of the present assignment; it names objects and choices."""
    outlived: bool = False
    """Whether a list of a function has grown, which may be visible after its call."""

    def close(self) -> None:
        """Remove the references that form cycles with the variant once it is finished.

        Terms refer to their algebra, functions to the names in their scope. Reference counts then free everything
        without Python's collector.
        """
        self.algebra.known.clear()
        for names in (self.names, *self.imported.values()):
            names.clear()

    def new_draw(self) -> Term:
        self.decisions.draw_count += 1
        return self.algebra.draw(self.decisions.draw_count - 1)

    def new_local(self) -> int:
        self.built.local_count += 1
        return self.built.local_count - 1

    def new_scope(self, span: Span) -> int:
        """Return the number of an inlined body.

        Raises:
            Mistake: there are too many.
        """
        self.file.budget.spend(span, BODY_COST)
        self.built.scope_count += 1
        if self.built.scope_count == BODY_LIMIT:
            raise TOO_MANY_BODIES.mistake(span, limit=BODY_LIMIT)
        if self.built.scope_count > BODY_LIMIT:
            raise Mistake
        return self.built.scope_count - 1

    @property
    def ego(self) -> Actor | None:
        """Return the ego: of the top level, of the running scenario, or of the first scenario that it starts."""
        ego = self.names.get("ego")
        return ego if isinstance(ego, Actor) else self.root.ego or self.built.first_ego

"""What elaboration gathers: of the file as a whole, and of the variant that is being worked out, with the fixed-time
plan of its traffic lights.
"""

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
"""What a light may show, by number; `None` where there is no light. CARLA's names, as Scenic's scripts have them."""
NONE, GREEN, YELLOW, RED, OFF, UNKNOWN = range(len(COLOURS))

DEFAULT_GREEN = 10.0
DEFAULT_YELLOW = 3.0
DEFAULT_ALL_RED = 2.0
"""[s]. Those of CARLA's lights; yellow of 3 to 6 s and red clearance of 1 to 2 s are what the Manual on Uniform Traffic
Control Devices (2009), section 4D.26, and practice ask for."""

PHASES = 2
"""Arms that face each other are green together: first those of the north and south, then those of the east and west."""


@frozen
class SignalPlan:
    """Times in seconds, as expressions over genes and constants."""

    green: Term
    yellow: Term
    all_red: Term
    offset: Term
    """How far into the plan the run starts."""
    controls: "Controls | None" = None

    def as_ir(self) -> ir.Lights:
        return ir.Lights(self.green, self.yellow, self.all_red, self.offset, controlled=self.controls is not None)


@frozen
class Controls:
    """Locals by which behaviours and monitors change the lights; only where a file does so."""

    frozen: int
    """1 while the lights stand still."""
    frozen_at: int
    """Clock of the lights while they do [s]."""
    lost: int
    """How long they have stood still before [s]."""
    colours: tuple[int, ...]
    """Per light, the colour it was set to; 0: none."""
    changes: tuple[int, ...]
    """Per light, how often the plan had changed its colour when it was set: the next change takes over again."""


# -- the file, and a variant of it -------------------------------------------------------------------------------------

BODY_LIMIT = 2_000
"""How many behaviours and scenarios may be written out in a variant."""
BODY_COST = 40
"""What writing one out costs, in evaluations."""

RuleKey = tuple[Span, RuleKind]
Scope = Instance | str
"""Whose variables are meant: those of a scenario, or of a file by its name; no name is the main file's."""


MapFinder = Callable[[str], str | None]
"""Where the file of a map is; None where there is none."""


def no_maps(_: str) -> str | None:
    """A text that came from no file has no files beside it."""
    return None


@dataclass
class FileContext:
    """What all variants of a file share."""

    source: Source
    overrides: Mapping[str, nodes.Expression]
    """`-p` values by param name; their spans are those of the params that they replace."""
    imports: Mapping[Span, ImportedFile] = field(default_factory=dict)
    """The file behind each import statement."""
    default_road: RoadSpec = field(default_factory=RoadSpec)
    """The road where the file has no `map`."""
    expanded: frozenset[Span] = frozenset()
    """Sites of numeric choices that are enumerated, because their values are needed concretely."""
    draws_lanes: bool = False
    """Whether lanes that are chosen at random are drawn with the scene, where no variant has to know them."""
    findings: Findings = field(default_factory=Findings)
    pool: Pool = field(default_factory=Pool)
    genes: dict[str, ir.GeneInfo] = field(default_factory=dict)
    _gene_numbers: dict[str, int] = field(default_factory=dict)
    _bounds: dict[int, Interval] = field(default_factory=dict)
    """Of the first `_bounded` genes."""
    _bounded: int = 0
    gene_dimensions: dict[int, set[ir.Dimension]] = field(default_factory=dict)
    """What the places of genes without a unit measure, by the number of the gene."""
    find_map: MapFinder = no_maps
    has_map: bool = False
    """Whether the file says by `map` what road there is; a `param map` then says nothing."""
    map_files: dict[str, MapFile] = field(default_factory=dict)
    """What was found of files of maps, by the names that they have here."""
    networks: dict[MapSpec, Network] = field(default_factory=dict)
    filtered: dict[tuple[Span, tuple[Value, ...]], tuple[Value, ...]] = field(default_factory=dict)
    """What conditions on elements of the road keep of them, by where it is written and the items."""
    uses_road: dict[Span, bool] = field(default_factory=dict)
    """Which conditions are such ones."""
    settings: Settings = field(default_factory=Settings)
    entry: nodes.ScenarioDefinition | None = None
    """The scenario that the run is; None: the top level is all."""
    budget: Budget = field(default_factory=Budget)
    max_steps: int | None = None
    """From `terminate after N steps`."""
    has_plan: bool = False
    """Whether `signals` is written."""
    default_signals: Span | None = None
    """The line of a Scenic script that names a map with traffic lights."""
    from_scenic: bool = False
    """Whether the file has Scenic's `model` line: absolute headings then count from north, as there."""
    attributes_read: frozenset[str] = frozenset()
    """Every name behind a dot: a property that is none of ours and is read is the file's own."""
    attributes_set: frozenset[str] = frozenset()
    """Every attribute that the run may change."""
    weights: dict[Span, Weight] = field(default_factory=dict)
    """What is certain of each `require`, by the place of its condition."""
    places: dict[Span, bool] = field(default_factory=dict)
    """Of each region in which something is placed, whether a place may lie in it."""
    temporals: dict[Span, nodes.Require] = field(default_factory=dict)
    """The temporal requirements, in the order of the file."""
    records: dict[str, tuple[Span, ir.Record]] = field(default_factory=dict)
    """What is recorded, and where that is said, by name."""
    objectives: dict[Span, tuple[nodes.Expect | nodes.Optimize, ir.Objective]] = field(default_factory=dict)
    """What is expected and what may be made large or small, by its place; formulas are still to come."""
    readings: list[ir.Reading] = field(default_factory=list)
    """What these need of a run that is over; all variants number them alike."""
    rules: dict[RuleKey, str] = field(default_factory=dict)
    """Name of every rule, by its place and kind, in the order met; all variants number them alike."""
    _rule_numbers: dict[RuleKey, int] = field(default_factory=dict)
    controls: dict[str, Control] = field(default_factory=dict)
    """The actors that are driven from outside, by the name of their controllers; all variants number them alike."""

    def gene_index(self, name: str) -> int:
        """Number of a gene, in the order of the file."""
        if name not in self._gene_numbers:
            for known, _ in self._genes_since(len(self._gene_numbers)):
                self._gene_numbers[known] = len(self._gene_numbers)
        return self._gene_numbers[name]

    def _genes_since(self, count: int) -> list[tuple[str, ir.GeneInfo]]:
        """Those that came after the first `count`, in their order; it takes no look at these."""
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
    """The arguments of `environment`, SI, and where it stands."""

    values: Mapping[str, Term]
    span: Span


@dataclass
class Built:
    """What a variant has made so far: objects, coroutines, requirements, and the road that they share."""

    actors: list[Actor] = field(default_factory=list)
    actor_names: set[str] = field(default_factory=set)
    numbered: int = 1
    """The next number of an object; 0 is the ego's."""
    first_ego: Actor | None = None
    """The ego of the first scenario started, where the one that starts it has none."""
    mutations: dict[Scope, list[nodes.Mutate]] = field(default_factory=dict)
    """The `mutate` statements of every scope."""
    mutated: set[tuple[Scope, str]] = field(default_factory=set)
    """Scopes and names of what carries noise."""
    has_set_up: bool = False
    """Whether a scenario with a setup was set up."""
    network: Network | None = None
    signals: SignalPlan | None = None
    environment: Environment | None = None
    requirements: list[ir.Requirement] = field(default_factory=list)
    rule_conditions: dict[RuleKey, Term] = field(default_factory=dict)
    objectives: dict[Span, Term] = field(default_factory=dict)
    """Of `maximize` and `minimize`, by their place: what is worked out when the run is over."""
    monitors: list[ir.Monitor | None] = field(default_factory=list)
    """Coroutines without an actor, by number; None while the body of one is being worked out."""
    required_monitors: list[tuple[str | None, MonitorCall, Span]] = field(default_factory=list)
    """Their names, where they have one, and where they are required."""
    zeroed: set[int] = field(default_factory=set)
    """Locals that nothing but an assignment to an object's own property sets."""
    local_count: int = 0
    scope_count: int = 0


@dataclass
class VariantState:
    """One way of making all finite choices, while it is being elaborated."""

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
    """The scenario that the run is, with the top level of the file."""
    compared: dict[Term, ir.Dimension | None] = field(default_factory=dict)
    """Dimension of what each comparison compares."""
    redrawn: dict[Term, Callable[..., Value]] = field(default_factory=dict)
    """Of each number that was drawn, what draws another like it."""
    assigning: str = ""
    """The name that is about to be assigned; it names objects and choices."""
    outlived: bool = False
    """Whether a list of a function has grown, which may be seen where its call is over."""

    def close(self) -> None:
        """Forget what holds on to the variant in a circle, once it is done: terms their algebra, functions the names
        that they know. Reference counts then free all of it, without a look of Python's collector.
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
        """The number of a body that is written out.

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
        """The vehicle under test: of the top level, of the scenario that runs, or of the first that it starts."""
        ego = self.names.get("ego")
        return ego if isinstance(ego, Actor) else self.root.ego or self.built.first_ego

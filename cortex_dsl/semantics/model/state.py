"""State of elaboration: of the file as a whole, with its limits, and of one variant, with the plan of its lights."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

from cortex_dsl import ir
from cortex_dsl.semantics.errors.problems import Findings, Mistake
from cortex_dsl.semantics.errors.runs import DEEP_BY_BRANCHES, DEEP_BY_RUNNING, TOO_DEEP_BODIES, TOO_MANY_BODIES
from cortex_dsl.semantics.errors.scene import RUNS_DIFFER
from cortex_dsl.semantics.errors.values import ENDLESS_LAMBDA, TOO_MUCH_WORK
from cortex_dsl.semantics.model.choices import Decisions, Pool
from cortex_dsl.semantics.model.values import Actor, Instance, MonitorCall, Value
from cortex_dsl.semantics.names.linking import ImportedFile
from cortex_dsl.semantics.quantities.algebra import Algebra, Term
from cortex_dsl.semantics.quantities.bounds import Interval, Weight
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import nodes
from engine.config import SimulationConfig
from engine.control import Control
from engine.frozen import frozen
from engine.maps import MapFile, MapSpec, RoadSpec
from engine.program import Settings
from engine.road.network import Network
from engine.vocabulary import GeneKind, RuleKind

# -- limits of every file ----------------------------------------------------------------------------------------------


# -- how much ----------------------------------------------------------------------------------------------------------

EVALUATION_LIMIT = 1_000_000
"""How many expressions a file may evaluate, all variants together."""
REPETITION_LIMIT = 100_000
"""How many of them in the loops, lists and calls of one variant, where a short text may demand any number: a second at
most, since editors compile a file at every key. The largest file of the tests takes 11,000, in all of its variants.
"""
COPIES = 64
"""Number of copied items or characters that costs as much as one evaluation of an expression."""
MUCH = 20
"""Inverse share of all work below which a place is not the cause of an excess."""


@dataclass
class Budget:
    """Cost of a file so far, and the place with the largest cost.

    It is counted in expressions and never in seconds, so that a file compiles everywhere or nowhere.
    """

    evaluations: int = 0
    repetitions: int = 0
    """Evaluations in loops, lists and calls of this variant, without copies of items, which are fast."""
    _reported: bool = False
    """Whether the excess has been reported."""
    _under_way: dict[Span, int] = field(default_factory=dict)
    """Present repetitions, from the outside in, with the count at their start."""
    _most: dict[Span, int] = field(default_factory=dict)
    """Largest cost of one execution of each such place."""

    def begin_variant(self) -> None:
        """Count the loops, lists and calls of the next variant."""
        self.repetitions = 0

    def spend(self, span: Span, evaluations: int = 1) -> None:
        """Count work. More than one evaluation at once is the work of a loop.

        Raises:
            Mistake: the limit is exceeded, which is reported once.
        """
        self.repetitions += evaluations if self._under_way or evaluations > 1 else 0
        self._count(span, evaluations)

    def copy(self, span: Span, count: int) -> None:
        """`spend` for so many items or characters that are copied, before they are."""
        self._count(span, count // COPIES)

    def _count(self, span: Span, evaluations: int) -> None:
        self.evaluations += evaluations
        if self._reported:
            raise Mistake
        if (limit := self._exceeded) is not None:
            self._reported = True
            raise TOO_MUCH_WORK.mistake(self._heaviest(span), limit=f"{limit:,}")

    @property
    def _exceeded(self) -> int | None:
        if self.repetitions >= REPETITION_LIMIT:
            return REPETITION_LIMIT
        return EVALUATION_LIMIT if self.evaluations >= EVALUATION_LIMIT else None

    @contextmanager
    def repeating(self, span: Span) -> Iterator[None]:
        """Count the work of a loop, a list or a call at this place."""
        if span in self._under_way:  # a function that calls itself
            yield
            return
        before = self._under_way[span] = self.evaluations
        try:
            yield
        finally:
            del self._under_way[span]
            self._most[span] = max(self.evaluations - before, self._most.get(span, 0))

    def _heaviest(self, span: Span) -> Span:
        """Return the place with the largest cost of one execution; the given place if no cost is large.

        Among the places with at least half the largest cost, it is the cheapest: the others only repeat it a few times.
        """
        took = self._most | {place: self.evaluations - before for place, before in self._under_way.items()}
        most = max(took.values(), default=0)
        if most * MUCH < self.evaluations:
            return span
        heavy = (place for place, work in took.items() if 2 * work >= most)
        return min(heavy, key=lambda place: (took[place], place.end - place.start))


# -- how deep ----------------------------------------------------------------------------------------------------------

CALL_LIMIT = 30
"""Maximum nesting depth of function calls."""
NESTING_LIMIT = 60
"""Maximum nesting depth of blocks, including those of the behaviours that they run."""


@dataclass
class Depth:
    """Nesting depth of the present place: in calls of functions, and in blocks of behaviours."""

    calls: int = 0
    """Number of nested function calls."""
    given_up: bool = False
    """Whether a call exceeded the limit; the surrounding calls then stop, since each would repeat the error."""
    blocks: int = 0
    """Number of nested blocks of behaviours."""
    branches: int = 0
    """Number of these blocks that are the `elif` remainder of a branch."""

    @contextmanager
    def call(self, span: Span) -> Iterator[None]:
        """Count one level of function calls.

        Raises:
            Mistake: the limit is exceeded, which is reported once.
        """
        if self.given_up:
            raise Mistake
        if self.calls == CALL_LIMIT:
            raise self._given_up(span)
        self.calls += 1
        try:
            yield
        except RecursionError:
            raise self._given_up(span) from None
        finally:
            self.calls -= 1
            self.given_up = self.given_up and self.calls > 0

    def _given_up(self, span: Span) -> Mistake:
        self.given_up = True
        return ENDLESS_LAMBDA.mistake(span)

    @contextmanager
    def nested(self, span: Span, *, otherwise: bool = False) -> Iterator[None]:
        """Count one level of blocks; `otherwise`: the branches after a branch.

        Raises:
            Mistake: the limit is exceeded.
        """
        if self.blocks == NESTING_LIMIT:
            raise self._too_deep(span)
        self.blocks += 1
        self.branches += otherwise
        try:
            yield
        finally:
            self.blocks -= 1
            self.branches -= otherwise

    def _too_deep(self, span: Span) -> Mistake:
        mostly_branches = 2 * self.branches > NESTING_LIMIT
        counted, reason, cure = DEEP_BY_BRANCHES if mostly_branches else DEEP_BY_RUNNING
        return TOO_DEEP_BODIES.mistake(span, limit=NESTING_LIMIT, counted=counted, reason=reason, cure=cure)


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


@frozen
class WarningCells:
    """Locals of the warnings of one actor; 0 before the first one."""

    now: int
    """1 while it warns."""
    begun: int
    """Time of its first warning [s], plus 1."""
    ttc: int
    """Time to collision at the first warning [s]."""


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


@frozen
class FileFacts:
    """Facts about the file and the command, known before the first variant."""

    source: Source
    overrides: Mapping[str, nodes.Expression]
    """`-p` values by param name; their spans are those of the params that they replace."""
    imports: Mapping[Span, ImportedFile]
    """File of each import statement."""
    default_road: RoadSpec
    """Road of a file without `map`."""
    entry: nodes.ScenarioDefinition | None
    """Scenario to run; None: only the top level."""
    find_map: MapFinder
    has_map: bool
    """Whether the file has a `map` statement; a `param map` is ignored then."""
    has_plan: bool
    """Whether the file has a `signals` statement."""
    default_signals: Span | None
    """Line of a Scenic script that names a map with traffic lights."""
    from_scenic: bool
    """Whether the file has Scenic's `model` line: absolute headings then count from north, as there."""
    attributes_read: frozenset[str]
    """Every name after a dot; a property that is read and is not built in belongs to the file."""
    reads_warnings: bool
    """Whether it reads warnings of a driver; then controllers are asked for them."""
    attributes_set: frozenset[str]
    """Every attribute that the run may change."""
    lets_appear: bool
    """Whether a behavior may let an object appear."""
    domains: ir.DomainUse | None = None
    """Effect of `domain` lines; None: they have none."""
    door_openers: frozenset[str] = frozenset()
    """Behaviors of the file that open a door, directly or by behaviors that they do."""
    door_sides: frozenset[str] = frozenset()
    """Sides of the doors that the file opens."""

    def line(self, span: Span) -> int:
        """Return the line number of a place, counted through all files."""
        return self.source.row(span.start)


@frozen
class ChoicePlan:
    """Treatment of finite choices that need not become variants."""

    expanded: frozenset[Span] = frozenset()
    """Sites of numeric choices that are enumerated, because their values are needed concretely."""
    draws_lanes: bool = False
    """Whether lanes that are chosen at random are drawn with the scene, where no variant has to know them."""


@dataclass
class RunSettings:
    """Settings of the simulation, collected from the statements of the file."""

    given: Settings
    max_steps: int | None = None
    """Number of steps in `terminate after N steps`."""
    late: int = 4
    """Number of objects of one `new` in a loop."""

    stated: dict[tuple[str, Span], float | int | str] = field(default_factory=dict)
    """Settings by their words for messages and their places in the file."""

    def put(self, span: Span, what: str, **values: float | int | str) -> None:
        """Replace settings by name.

        Raises:
            Mistake: another variant gives another value at this place.
        """
        for value in values.values():
            self.check(span, what, value)
        self.given = replace(self.given, **values)

    def check(self, span: Span, what: str, value: float | int | str) -> None:
        """Check that no other variant gives another value at a place.

        Raises:
            Mistake: one does.
        """
        if self.stated.setdefault((what, span), value) != value:
            raise RUNS_DIFFER.mistake(span, what=what)

    @property
    def time_step(self) -> float:
        """Time step [s] of the file, else of the simulator."""
        return self.given.time_step or SimulationConfig().time_step

    def resolved(self) -> Settings:
        """Return the settings with a limit in steps as a time."""
        return self.given if self.max_steps is None else replace(self.given, max_time=self.max_steps * self.time_step)


@dataclass
class Genes:
    """Genes in the order of the file; all variants number them alike."""

    infos: list[ir.GeneInfo] = field(default_factory=list)
    bounds: dict[int, Interval] = field(default_factory=dict)
    """SI bounds of every gene that stands for its own value."""
    dimensions: dict[int, set[ir.Dimension]] = field(default_factory=dict)
    """Dimensions of the places that use a gene without a unit, by the number of the gene."""
    _numbers: dict[str, int] = field(default_factory=dict)

    def number(self, gene: ir.GeneInfo) -> int | None:
        """Return the number of a gene, which is added if its name is new; None if another gene has the name."""
        index = self._numbers.setdefault(gene.name, len(self.infos))
        if index == len(self.infos):
            self.infos.append(gene)
            if gene.kind != GeneKind.INDEX:
                self.bounds[index] = gene.low * gene.scale, gene.high * gene.scale
        return index if self.infos[index] == gene else None


@dataclass
class RoadResults:
    """Maps that were read, and results about their elements that no variant changes."""

    map_files: dict[str, MapFile] = field(default_factory=dict)
    """Map files that were found, by their names in this file."""
    networks: dict[MapSpec, Network] = field(default_factory=dict)
    filtered: dict[tuple[Span, tuple[Value, ...]], tuple[Value, ...]] = field(default_factory=dict)
    """Elements of the road that satisfy a condition, by the place of the condition and the items."""
    is_about_road: dict[Span, bool] = field(default_factory=dict)
    """Whether a condition is about elements of the road, by its place."""


@dataclass
class SceneConditions:
    """Conditions on the scene, joined over all variants."""

    weights: dict[Span, Weight] = field(default_factory=dict)
    """Weight of each `require`, by the place of its condition."""
    places: dict[Span, bool] = field(default_factory=dict)
    """Whether a region in which something is placed can hold a place, by the place of the region."""


@dataclass
class RunStatements:
    """Statements about the run, and the numbers of their parts, which are those of all variants."""

    temporals: dict[Span, nodes.Require] = field(default_factory=dict)
    """The temporal requirements, in the order of the file."""
    records: dict[str, tuple[Span, ir.Record]] = field(default_factory=dict)
    """Recorded values and their places, by name."""
    domains: dict[Span, ir.Domain] = field(default_factory=dict)
    """Domains by their place."""
    objectives: dict[Span, tuple[nodes.Expect | nodes.Optimize | nodes.Domain, ir.Objective]] = field(
        default_factory=dict
    )
    """Expectations and optimization objectives, by their place; their formulas are added later."""
    readings: list[ir.Reading] = field(default_factory=list)
    """Results of a finished run that the objectives read."""
    rules: dict[RuleKey, str] = field(default_factory=dict)
    """Name of every rule, by its place and kind, in the order of their numbers."""
    _rule_numbers: dict[RuleKey, int] = field(default_factory=dict)
    controls: dict[str, Control] = field(default_factory=dict)
    """Actors with an external controller, by the name of the controller."""

    def rule(self, span: Span, name: str, kind: RuleKind = RuleKind.TERMINATE) -> int:
        """Return the number of the rule of this kind at a place, which is added if it is new."""
        self.rules.setdefault((span, kind), name)
        return self._rule_numbers.setdefault((span, kind), len(self._rule_numbers))

    def reading(self, reading: ir.Reading) -> int:
        """Return the number of a reading, which is added if it is new."""
        if reading not in self.readings:
            self.readings.append(reading)
        return self.readings.index(reading)


@frozen
class FileContext:
    """Everything that the variants of a file share: the facts, and a collector for each kind of result."""

    facts: FileFacts
    choice_plan: ChoicePlan
    findings: Findings
    settings: RunSettings
    genes: Genes = field(default_factory=Genes)
    pool: Pool = field(default_factory=Pool)
    roads: RoadResults = field(default_factory=RoadResults)
    scene: SceneConditions = field(default_factory=SceneConditions)
    run: RunStatements = field(default_factory=RunStatements)
    budget: Budget = field(default_factory=Budget)

    @property
    def is_pinned(self) -> bool:
        """Whether values are fixed by `-p` or by a concrete copy; they are no mistake of the file."""
        return bool(self.facts.overrides) or self.settings.given.stream is not None


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
    warnings: dict[int, WarningCells] = field(default_factory=dict)
    """Locals of the warnings of actors, by number."""
    local_count: int = 0
    scope_count: int = 0
    appearing: list[ir.Act] | None = None
    """Acts of the objects that the present statement lets appear; None where no object can appear."""
    may_appear: bool = False
    """Whether an object of a scenario that starts later may wait for its place until then (`NeedsRun`)."""
    late: list[Actor] = field(default_factory=list)
    """Objects that appear during the run, in the order in which their `new` is met."""
    late_met: int = 0
    """Number of those that were met since behaviours were last written anew."""
    late_rules: dict[tuple[Span, str], int] = field(default_factory=dict)
    """Number of each condition of objects that appear, among those of its place."""

    @contextmanager
    def collecting(self, acts: list[ir.Act]) -> Iterator[None]:
        """Let objects appear, and add their acts to a list."""
        self.appearing = acts
        try:
            yield
        finally:
            self.appearing = None


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
        self.algebra.close()
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

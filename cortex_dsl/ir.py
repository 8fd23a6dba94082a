"""The checked scenario: every name bound, every number SI with a known dimension, every random choice expanded.

Elaboration runs the file once for each *variant* (one combination of all its finite choices). Unknown values remain
expressions over genes, nuisance draws and, in behaviours, the running simulation. Expressions are interned: equal
expressions of one variant are the same object, so passes may key on identity.
"""

import math

from cortex_dsl.source import Source, Span
from engine.control import Control
from engine.frozen import frozen, frozen_identity
from engine.maps import MapSpec
from engine.opcodes import Op
from engine.program import Settings
from engine.road.network import Network
from engine.vocabulary import ActorKind, Command, Distribution, GeneKind, Reducer, RuleKind, Sense, TemporalOp, Turns

# -- expressions ----------------------------------------------------------------------------------------------------


@frozen
class Dimension:
    """Exponents of length, time, mass and angle. `PURE` has none."""

    length: int = 0
    time: int = 0
    mass: int = 0
    angle: int = 0


PURE = Dimension()


@frozen_identity
class Expr:
    """A number known only later (or a bundle of `width` numbers). Operands come first, then numbers that are part
    of the operation itself.
    """

    span: Span


@frozen_identity
class Literal(Expr):
    """A constant, SI. Path and region ids are literals too."""

    value: float


@frozen_identity
class Gene(Expr):
    """The SI value of gene `index`."""

    index: int


@frozen_identity
class Draw(Expr):
    """Uniform number `index` of the attempt, in [0, 1)."""

    index: int


@frozen_identity
class Local(Expr):
    """A behaviour's local variable."""

    index: int


@frozen_identity
class Running(Expr):
    """Whether monitor `monitor` has been started and has not ended."""

    monitor: int


@frozen_identity
class Apply(Expr):
    """`op(arguments)`. For ops that take packed operands (BOX_DISTANCE, CAN_SEE, …) an argument is a `Pack`."""

    op: Op
    arguments: tuple[Expr, ...]
    immediates: tuple[int, ...] = ()
    """Integer operands of STATE (actor, column), WITHIN (actor), TABLE (offset into the pool)."""
    width: int = 1
    """3 for PATH_POSE and ROAD_FOLLOW, 2 for REGION_SAMPLE."""


@frozen_identity
class Pack(Expr):
    """Several numbers side by side, for operations that read consecutive registers."""

    items: tuple[Expr, ...]


@frozen_identity
class Item(Expr):
    """Number `index` of a wide expression."""

    bundle: Expr
    index: int


# -- behaviours -----------------------------------------------------------------------------------------------------


@frozen
class Act:
    span: Span


@frozen
class SetLocal(Act):
    index: int
    value: Expr


@frozen
class Take(Act):
    """Set commands, then end the turn."""

    commands: tuple[tuple[Command, Expr], ...]


@frozen
class Wait(Act):
    """End the turn without an action."""


@frozen
class Follow(Act):
    """Follow a path until its end, `offset` [m] to the left of it, or of the curve to the offset `aside` [m].

    `progress` is a local of its own.
    """

    path: Expr
    target_speed: Expr
    max_lateral: Expr
    """Literal infinity switches speed planning off."""
    progress: int
    offset: Expr | None = None
    aside: Expr | None = None


@frozen
class HoldSpeed(Act):
    """ConstantSpeedBehavior: it never ends."""

    target_speed: Expr


@frozen
class Replay(Act):
    """Move as recorded to the end of a track. `track`: its place in the pool; `clock`: a local of its own."""

    track: int
    pace: Expr
    clock: int


@frozen
class Branch(Act):
    condition: Expr
    then: "Block"
    otherwise: "Block"


@frozen
class Loop(Act):
    condition: Expr
    body: "Block"


@frozen
class Leave(Act):
    """`break`, `continue`, or `return` of an inlined behaviour (`levels` inlined scopes are numbered by `scope`)."""

    kind: str
    scope: int


@frozen
class Scope(Act):
    """An inlined behaviour; a `return` inside leads to its end."""

    name: str
    scope: int
    body: "Block"
    invariants: tuple[tuple[Expr, int], ...] = ()
    """Conditions, each with the rule that aborts the run if it is false: tested at the start, whenever the body itself
    continues in a later turn, and after each scope inside it has ended."""


@frozen
class Demand(Act):
    """Abort the run by `rule` unless the condition holds: a `require` in a behaviour, a precondition."""

    condition: Expr
    rule: int


@frozen
class Option:
    """An option of `Pick`."""

    weight: Expr
    allowed: Expr
    """Its preconditions and invariants."""
    body: "Block"


@frozen
class Pick(Act):
    """`do choose`: one allowed option, as likely as its weight says. `do shuffle`: all, in random order, each drawn
    among those that are left and allowed. Where none is allowed, `rule` aborts the run.
    """

    options: tuple[Option, ...]
    shuffle: bool
    rule: int


@frozen
class Start(Act):
    """Start a monitor. Its first turn is at this sample if its number is higher, or at an `Advance` if it is called."""

    monitor: int


@frozen
class Advance(Act):
    """Give a coroutine that is `Turns.CALLED` its turn here, if it is running; one act, or one block, advances it."""

    monitor: int


@frozen
class Stop(Act):
    """Stop monitors, and the behaviours of actors, which coast from then on."""

    monitors: tuple[int, ...]
    actors: tuple[int, ...]


@frozen
class Spawn(Act):
    """Let absent actors take part from this sample on, at the poses of their scene."""

    actors: tuple[int, ...]


@frozen
class Enter(Act):
    """Let an absent actor take part from this sample on, at a place that is worked out now."""

    actor: int
    start: tuple[Expr, Expr, Expr, Expr]
    """x, y [m], heading [rad], speed [m/s]"""


@frozen
class TryInterrupt(Act):
    """Handlers in the order of the file.

    Later handlers take precedence, may interrupt earlier ones, and those then resume.
    """

    body: "Block"
    handlers: tuple[tuple[Expr, "Block"], ...]


@frozen
class Abort(Act):
    """Leave the innermost try."""


@frozen
class Terminate(Act):
    """End the run; `rule` indexes `Variant.rules`."""

    rule: int


Block = tuple[Act, ...]

# -- the scenario ---------------------------------------------------------------------------------------------------


@frozen
class GeneInfo:
    """One `param` that a search may choose. Numbers in the file's own unit."""

    name: str
    unit: str
    scale: float
    kind: GeneKind
    low: float
    high: float
    distribution: Distribution
    mean: float
    deviation: float
    options: tuple[str, ...]
    weights: tuple[float, ...]
    span: Span
    bare: bool = False
    """Whether the unit is not the file's, but that of the places of the gene."""


@frozen
class Actor:
    name: str
    kind: ActorKind
    columns: tuple[Expr, ...]
    """One expression per `vocabulary.Column`, scene-level."""
    behaviour: Block | None
    route: int
    """Path id known at compile time, -1 if none."""
    inside_road: bool
    """Whether the built-in `inside the road` holds."""
    overlap_group: int
    """Group whose outlines do not overlap at the start; 0: the outline may overlap any other. Actors that appear later
    are in a group with those that appear with them, since the places of other actors then depend on the run."""
    span: Span
    present: bool = True
    """Whether it takes part from the start; else a `Spawn` brings it in."""
    level: tuple[int, ...] = ()
    """Lanes on whose level it begins; () where its heading decides."""


@frozen
class Requirement:
    condition: Expr
    probability: float
    name: str
    line: int
    margin: Expr | None = None
    """Margin by which it holds: positive if it holds, negative if not; None for a bare truth."""
    dimension: Dimension = PURE
    """Dimension of the margin."""
    unit: str = ""
    """Unit word of that dimension in which the file speaks; "" where it names none."""


@frozen
class Rule:
    """A condition evaluated in every sample of the running simulation.

    A rule that an act triggers (`terminate` in a behaviour, a guard) has no condition. WATCH: the value is stored
    (records, atoms of temporal formulas). TERMINATE: true ends the run. ABORT: true makes the run invalid (`require
    always c` is a rule `not c`).
    """

    condition: Expr | None
    name: str
    line: int
    kind: RuleKind = RuleKind.TERMINATE


@frozen
class Formula:
    """Linear temporal logic over the samples of a finite run, up to the last before contact, or to the end."""

    op: TemporalOp
    operands: tuple["Formula", ...] = ()
    watch: int = -1
    """Rule (kind WATCH) that holds the value of an ATOM."""
    margin: int = -1
    """Rule that holds the robustness of an ATOM of an objective."""


@frozen
class Temporal:
    """A temporal requirement that is judged when the run is over; `rule` (kind ABORT) names it."""

    formula: Formula
    rule: int


@frozen
class Reading:
    """A number that a finished run leaves behind: of a rule, or a result by name (`engine.judged`)."""

    kind: Reducer
    rule: int = -1
    result: str = ""


@frozen
class Objective:
    """A possible objective of a search: an `expect` and its formula, or a number of the run (`Variant.objectives`)."""

    sense: Sense
    name: str
    line: int
    dimension: Dimension = PURE
    formula: Formula | None = None


@frozen
class Monitor:
    """A coroutine without an actor: a monitor, or a scenario. Those that it advances have higher numbers."""

    name: str
    body: Block
    turns: Turns
    span: Span


@frozen
class Record:
    """`record`: a value over time, or at one end of it."""

    name: str
    when: str
    """`series`, `initial` or `final`."""
    watch: int
    """Rule (kind WATCH) whose value is stored."""
    dimension: Dimension
    line: int
    during: int = -1
    """Rule (kind WATCH) that is true in the samples that count; -1: all do."""


@frozen
class Cell:
    """A part of a domain's values, SI."""

    low: float
    high: float
    closed: bool
    """True if the upper end belongs to the cell."""
    text: str
    item: str = ""
    """Source text of an item that is no number."""


@frozen
class Domain:
    """`domain`: cells of a value at one instant. It is no part of a compiled program."""

    name: str
    when: str
    """`start`, `first sight`, `contact` or `end`."""
    line: int
    text: str
    """The value as the file writes it."""
    unit: str
    """Unit in which values are shown."""
    scale: float
    """SI value = shown value * scale."""
    cells: tuple[Cell, ...]
    least: float = math.nan
    """Least possible value by interval arithmetic, SI; NaN unless the instant is the start."""
    greatest: float = math.nan


@frozen
class DomainUse:
    """Effect of `domain` lines on a compilation for coverage."""

    cells: frozenset[tuple[int, int]] | None = None
    """(domain, cell) each required of the scene; None: the values become objectives instead."""


@frozen
class Choice:
    """One finite choice as made in a variant."""

    name: str
    option: str
    option_source: str
    """Source text that names the option again, for a concrete copy: `network.lanes[3]`."""
    span: Span


@frozen
class DrawSite:
    """Origin of draws: the source text that a concrete copy of a case replaces by its samples."""

    span: Span
    kind: str
    """`number` (the distribution call with its unit), `lane` (the call, replaced by the lane), `sidewalks` or another
    tuple of the network (the call, replaced by its element), `pose` (a specifier, replaced by `at (x, y), facing h`),
    `point` (a specifier, replaced by `at (x, y)`), `heading` (a specifier, replaced by `facing h`); `pose added` and
    `point added` are put behind a class name."""
    unit: str
    """SI unit word of a number ("m", "m/s", "rad", ""); values are written in SI, which avoids rounding. For a `lane`,
    the name of the choice."""
    values: tuple[Expr, ...]
    """Values of the site; written out with 17 digits."""


@frozen
class Lights:
    """The fixed-time plan of all traffic lights, in seconds: see `cortex_dsl.semantics.model.state`."""

    green: Expr
    yellow: Expr
    all_red: Expr
    offset: Expr
    controlled: bool
    """Whether behaviours or monitors may change the lights."""


@frozen
class Variant:
    probability: float
    choices: tuple[Choice, ...]
    gene_options: tuple[tuple[int, int], ...]
    """(gene, option) pairs for finite choices that a gene makes."""
    rejection: str | None
    """Why this variant cannot be (an empty choice), or None; then everything below is there."""
    rejection_line: int = 0
    actors: tuple[Actor, ...] = ()
    requirements: tuple[Requirement, ...] = ()
    rules: tuple[Rule, ...] = ()
    draw_count: int = 0
    local_count: int = 0
    draw_sites: tuple[DrawSite, ...] = ()
    monitors: tuple[Monitor, ...] = ()
    lights: Lights | None = None
    """Lights; not lowered, since the acts and rules contain all that a program needs of them."""
    objectives: tuple[Expr | None, ...] = ()
    """Value of each objective of the scenario after the run; None for an `expect`. Its locals are the readings."""
    environment: tuple[tuple[str, Expr], ...] = ()
    """Arguments of `environment`, SI. Only `sight` is lowered: columns of actors contain the effect of the others."""


@frozen
class Scenario:
    source: Source
    name: str
    description: str
    road: MapSpec
    genes: tuple[GeneInfo, ...]
    settings: Settings
    variants: tuple[Variant, ...]
    network: Network
    """The road as built; literal path and region ids refer to its books, joined trajectories among them."""
    pool: tuple[float, ...]
    """Numeric options of discrete choices, for Op.TABLE."""
    system: tuple[str, ...] = ()
    """Names of the params that belong to the system under test, genes or fixed."""
    temporals: tuple[Temporal, ...] = ()
    """The same in all variants; the conditions of their atoms are rules of each."""
    records: tuple[Record, ...] = ()
    objectives: tuple[Objective, ...] = ()
    readings: tuple[Reading, ...] = ()
    controls: tuple[Control, ...] = ()
    domains: tuple[Domain, ...] = ()
    """Not lowered."""

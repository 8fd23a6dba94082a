"""The checked scenario: every name bound, every number SI with a known dimension, every random choice expanded.

Elaboration runs the file once for each *variant* (one way of making all its finite choices) and leaves what is still
unknown as expressions over genes, nuisance draws and, in behaviours, the running simulation. Expressions are interned:
equal expressions of one variant are the same object, so passes may key on identity.
"""

from dataclasses import dataclass

from cortex_dsl.source import Source, Span
from engine.program import RoadSpec, Settings
from engine.road.network import Network
from engine.vocabulary import ActorKind, Command, Distribution, GeneKind, Op

# -- expressions ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Dimension:
    """Exponents of length, time, mass and angle. `PURE` has none."""

    length: int = 0
    time: int = 0
    mass: int = 0
    angle: int = 0


PURE = Dimension()


@dataclass(frozen=True, eq=False)
class Expr:
    """A number known only later (or a bundle of `width` numbers). Operands come first, then numbers that are part
    of the operation itself.
    """

    span: Span


@dataclass(frozen=True, eq=False)
class Literal(Expr):
    """A constant, SI. Path and region ids are literals too."""

    value: float


@dataclass(frozen=True, eq=False)
class Gene(Expr):
    """The SI value of gene `index`."""

    index: int


@dataclass(frozen=True, eq=False)
class Draw(Expr):
    """Uniform number `index` of the attempt, in [0, 1)."""

    index: int


@dataclass(frozen=True, eq=False)
class Local(Expr):
    """A behaviour's local variable."""

    index: int


@dataclass(frozen=True, eq=False)
class Apply(Expr):
    """`op(arguments)`. For ops that take packed operands (BOX_DISTANCE, CAN_SEE, …) an argument is a `Pack`."""

    op: Op
    arguments: tuple[Expr, ...]
    immediates: tuple[int, ...] = ()
    """Integer operands of STATE (actor, column), WITHIN (actor), TABLE (offset into the pool)."""
    width: int = 1
    """3 for PATH_POSE and ROAD_FOLLOW, 2 for REGION_SAMPLE."""


@dataclass(frozen=True, eq=False)
class Pack(Expr):
    """Several numbers side by side, for operations that read consecutive registers."""

    items: tuple[Expr, ...]


@dataclass(frozen=True, eq=False)
class Item(Expr):
    """Number `index` of a wide expression."""

    bundle: Expr
    index: int


# -- behaviours -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Act:
    span: Span


@dataclass(frozen=True)
class SetLocal(Act):
    index: int
    value: Expr


@dataclass(frozen=True)
class Take(Act):
    """Set commands, then end the turn."""

    commands: tuple[tuple[Command, Expr], ...]


@dataclass(frozen=True)
class Wait(Act):
    """End the turn without an action."""


@dataclass(frozen=True)
class Follow(Act):
    """FollowTrajectoryBehavior and its kin: follow a path until its end. `progress` is a local of its own."""

    path: Expr
    target_speed: Expr
    max_lateral: Expr
    """Literal infinity switches speed planning off."""
    progress: int


@dataclass(frozen=True)
class HoldSpeed(Act):
    """ConstantSpeedBehavior: for ever."""

    target_speed: Expr


@dataclass(frozen=True)
class Branch(Act):
    condition: Expr
    then: "Block"
    otherwise: "Block"


@dataclass(frozen=True)
class Loop(Act):
    condition: Expr
    body: "Block"


@dataclass(frozen=True)
class Leave(Act):
    """`break`, `continue`, or `return` of an inlined behaviour (`levels` inlined scopes are numbered by `scope`)."""

    kind: str
    scope: int


@dataclass(frozen=True)
class Scope(Act):
    """An inlined behaviour; a `return` inside leads to its end."""

    name: str
    scope: int
    body: "Block"


@dataclass(frozen=True)
class TryInterrupt(Act):
    """Handlers in the order of the file; later ones win, may interrupt earlier ones, and those then resume."""

    body: "Block"
    handlers: tuple[tuple[Expr, "Block"], ...]


@dataclass(frozen=True)
class Abort(Act):
    """Leave the innermost try."""


@dataclass(frozen=True)
class Terminate(Act):
    """End the run; `rule` indexes `Variant.rules`."""

    rule: int


Block = tuple[Act, ...]

# -- the scenario ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
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


@dataclass(frozen=True)
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
    no_overlap: bool
    span: Span


@dataclass(frozen=True)
class Requirement:
    condition: Expr
    probability: float
    name: str
    line: int


@dataclass(frozen=True)
class Rule:
    """A `terminate when` (condition over the running simulation), or a behaviour's `terminate` (condition None)."""

    condition: Expr | None
    name: str
    line: int


@dataclass(frozen=True)
class Choice:
    """One finite choice as made in a variant."""

    name: str
    option: str
    option_source: str
    """Source text that names the option again, for a concrete copy: `network.lanes[3]`."""
    span: Span


@dataclass(frozen=True)
class DrawSite:
    """Where draws come from: the source text that a concrete copy of a case replaces by what was drawn."""

    span: Span
    kind: str
    """`number` (the distribution call with its unit), `pose` (a specifier, replaced by `at (x, y), facing h`),
    `point` (a specifier, replaced by `at (x, y)`)."""
    unit: str
    """SI unit word of a number ("m", "m/s", "rad", ""); written values are SI, so no rounding on the way back."""
    values: tuple[Expr, ...]
    """What the site evaluated to; written out with 17 digits."""


@dataclass(frozen=True)
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


@dataclass(frozen=True)
class Scenario:
    source: Source
    name: str
    description: str
    road: RoadSpec
    genes: tuple[GeneInfo, ...]
    settings: Settings
    variants: tuple[Variant, ...]
    network: Network
    """The road as built; literal path and region ids refer to its books, joined trajectories among them."""
    pool: tuple[float, ...]
    """Numeric options of discrete choices, for Op.TABLE."""

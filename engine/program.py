"""`Program`: a compiled scenario as data. The one type between the language and the engine.

A program holds arrays, tables and names, and nothing that needs the language again: it can be saved, hashed, sent to
another machine, sampled, simulated by either host and searched.
"""

from engine.frozen import frozen
from engine.tables import CodeTables, Floats, Ints, RoadTables
from engine.vocabulary import RuleKind


@frozen
class ParamSpace:
    """The genes, in the order of the file. A genome is one row of values in the file's own units."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    """Unit as written in the file, or where it writes none that of the places in which the gene stands (SI); "" for
    pure numbers and option indices."""
    kinds: Ints
    """(d,) `GeneKind`."""
    low: Floats
    """(d,) inclusive, file units. Bounds of the search box."""
    high: Floats
    distribution: Ints
    """(d,) `Distribution`: how a plain run draws the gene."""
    shape: Floats
    """(d, 2): mean and standard deviation (file units) of a truncated normal; else unused."""
    scale: Floats
    """(d,): SI value = file value * scale."""
    options: tuple[tuple[str, ...], ...]
    """Printable options of an INDEX gene; () otherwise."""
    weights: tuple[tuple[float, ...], ...]
    """Probabilities of a DISCRETE gene's options; () otherwise."""
    system: tuple[str, ...] = ()
    """Names of the params that belong to the system under test; one that is held fixed is no gene."""
    bare: tuple[str, ...] = ()
    """Names of the genes whose unit the file does not write."""

    def __len__(self) -> int:
        return len(self.names)


@frozen
class Requirement:
    """One `require`, or a built-in or variant rejection, as a person knows it."""

    name: str
    """What the author called it (`as "..."`), or its source text; shown in every count."""
    line: int
    """Line in the source; 0 for a built-in."""
    probability: float = 1.0
    unit: str = ""
    """SI unit of its margin."""
    told_unit: str = ""
    """Unit in which people are told amounts of it: the one that its source uses; "" where that is the SI unit."""
    told_scale: float = 1.0
    """SI amount = told amount * scale."""


@frozen
class Rule:
    """One thing that is looked at in every sample, or that code triggers: see `vocabulary.RuleKind`."""

    name: str
    line: int
    kind: RuleKind = RuleKind.TERMINATE


@frozen
class Record:
    """A value that the file asks to be kept: over time (`series`), or at one end (`initial`, `final`)."""

    name: str
    when: str
    rule: int
    """The rule of kind WATCH."""
    unit: str
    line: int


@frozen
class ChoiceLabel:
    """A finite choice as a variant made it. `start`, `end`: its place in the source, for a concrete copy."""

    name: str
    option: str
    option_source: str
    start: int
    end: int


@frozen
class DrawSite:
    """A nuisance draw in the source: its place, and the scene values that hold what was drawn (see ir.DrawSite)."""

    kind: str
    unit: str
    start: int
    end: int
    values: tuple[int, ...]
    """Indices of scene values."""


@frozen
class VariantLabel:
    """One way of making all finite choices, for people and for concrete copies."""

    probability: float
    choices: tuple[ChoiceLabel, ...]
    sites: tuple[DrawSite, ...]


@frozen
class Settings:
    """What the file itself says about its simulation; None where it is silent and the config decides."""

    time_step: float | None = None
    max_time: float | None = None
    """From `terminate after` [s]."""
    max_attempts: int | None = None
    stream: str | None = None
    """Stream key pinned by a concrete file, so that a found case replays exactly."""


@frozen
class RoadSpec:
    """A grid of intersections, as `map intersection(...)` says it. SI units."""

    ways: int = 4
    lanes: int = 1
    """Lanes a direction."""
    lane_width: float = 3.5
    corner_radius: float = 6.0
    approach: float = 50.0
    """Length of every arm from its stop line to the end of the road [m]."""
    rows: int = 1
    cols: int = 1
    block: float = 100.0
    """Distance between the centres of neighbouring intersections [m]."""
    left_hand: bool = False


@frozen
class ImportedText:
    """A file that the main file imports, as it was when it was compiled."""

    name: str
    start: int
    """Offset of its first character in the space of all texts."""
    first_line: int
    """Number of its first line, counted through all texts."""
    text: str


@frozen
class Program:
    """A compiled scenario. See `engine.tables` for the arrays; nothing in here refers back to text."""

    name: str
    description: str
    digest: str
    """Hash of everything that decides a result; names and text are left out."""
    source_text: str
    """The file as written; kept for reports and concrete copies, not used to run."""
    space: ParamSpace
    actors: tuple[str, ...]
    """Actor names; actor 0 is the ego."""
    requirements: tuple[Requirement, ...]
    """In testing order: the file's own, then `variant` rejections, then the built-in ones
    (`outlines inside the road`, `no overlap at the start`)."""
    rules: tuple[Rule, ...]
    variants: tuple[VariantLabel, ...]
    settings: Settings
    code: CodeTables
    road: RoadTables
    road_spec: RoadSpec
    step_lines: Ints
    """(rows of step_code,): source line of each instruction, for messages about running behaviours."""
    routes: Ints
    """(variants, actors): path each actor is known to follow, or -1; for drawing and for conflict metrics."""
    records: tuple[Record, ...] = ()
    monitors: tuple[str, ...] = ()
    """Names of the coroutines without an actor."""
    imported: tuple[ImportedText, ...] = ()

    def place(self, line: int) -> str:
        """A line as people know it: its number, and the name of its file if that is not the main one."""
        for file in reversed(self.imported):
            if line >= file.first_line:
                return f"{file.name}:{line - file.first_line + 1}"
        return str(line)

"""The syntax tree: the text in its structure as the author sees it. Frozen; spans never take part in equality."""

from dataclasses import field

from cortex_dsl.source import Span
from engine.frozen import frozen


@frozen
class Node:
    span: Span = field(compare=False, repr=False, kw_only=True)


class Expression(Node):
    pass


class Statement(Node):
    pass


# -- expressions ----------------------------------------------------------------------------------------------------


@frozen
class Number(Expression):
    value: float
    unit: str | None = None
    """`km/h` in `50 km/h`."""


@frozen
class WithUnit(Expression):
    """A unit after a call: `Range(5, 80) km/h`."""

    value: Expression
    unit: str


@frozen
class String(Expression):
    value: str


@frozen
class Placeholder(Node):
    """`{value:layout}` in a text."""

    value: Expression
    layout: str  # as Python's `format` takes it; empty where there is none


@frozen
class Formatted(Expression):
    """`f"{n} cars"`: texts, and values that are written out."""

    parts: tuple[str | Placeholder, ...]


@frozen
class Constant(Expression):
    """`True`, `False`, `None`."""

    value: bool | None


@frozen
class InitialScenario(Expression):
    """`initial scenario`: whether no scenario was set up before the present one."""


@frozen
class Name(Expression):
    id: str


@frozen
class Attribute(Expression):
    value: Expression
    name: str
    name_span: Span = field(compare=False, repr=False, kw_only=True)


@frozen
class Index(Expression):
    value: Expression
    index: Expression


@frozen
class Argument(Node):
    value: Expression
    name: str | None = None


@frozen
class Call(Expression):
    function: Expression
    arguments: tuple[Argument, ...]


@frozen
class Starred(Expression):
    """`*xs` inside a call or a list."""

    value: Expression


@frozen
class ListDisplay(Expression):
    items: tuple[Expression, ...]


@frozen
class TupleDisplay(Expression):
    items: tuple[Expression, ...]


@frozen
class DictDisplay(Expression):
    """`{a: 1, b: 2}`: weights of `Discrete`."""

    entries: tuple[tuple[Expression, Expression], ...]


@frozen
class Comprehension(Expression):
    """`[element for targets in iterable if c1 if c2]`, one or more `for` clauses; also a bare generator."""

    element: Expression
    clauses: "tuple[ForClause, ...]"


@frozen
class ForClause(Node):
    targets: tuple[str, ...]
    iterable: Expression
    conditions: tuple[Expression, ...]


@frozen
class Lambda(Expression):
    parameters: tuple[str, ...]
    body: Expression


@frozen
class Unary(Expression):
    """`-x`, `+x`, `not x`."""

    operator: str
    operand: Expression


@frozen
class Binary(Expression):
    """`+ - * / // % **` and `@` (a vector from two numbers)."""

    operator: str
    left: Expression
    right: Expression


@frozen
class BoolOp(Expression):
    """`a and b and c`, `a or b`."""

    operator: str
    operands: tuple[Expression, ...]


@frozen
class Compare(Expression):
    """`a < b <= c`; operators: `< <= > >= == != in`, `not in`, `is`, `is not`."""

    first: Expression
    rest: tuple[tuple[str, Expression], ...]


@frozen
class Conditional(Expression):
    condition: Expression
    then: Expression
    otherwise: Expression


@frozen
class Distance(Expression):
    """`distance [from a] to b`; with `minimum` in front: between outlines. `origin` None means the ego."""

    origin: Expression | None
    target: Expression
    between_outlines: bool = False


@frozen
class RelativeHeading(Expression):
    """`relative heading of a [from b]`."""

    of: Expression
    origin: Expression | None


@frozen
class SeenFrom(Expression):
    """`apparent heading of a [from b]`, `relative position of …`, `distance past a [of b]`."""

    operator: str
    of: Expression
    origin: Expression | None


@frozen
class Angle(Expression):
    """`angle [from a] to b`: the heading of the way. `None` means the ego."""

    origin: Expression | None
    target: Expression | None


@frozen
class Follow(Expression):
    """`follow field [from place] for distance`."""

    direction: Expression
    origin: Expression | None
    distance: Expression


@frozen
class SideOf(Expression):
    """`front of a`, `back left of a`: a point on its outline; side is the words before `of`."""

    side: str
    of: Expression


@frozen
class VisiblePart(Expression):
    """`[not] visible region`, `region [not] visible from x`: the part of it that the ego or x sees, or does not see."""

    region: Expression
    seen: bool
    viewer: Expression | None = None


@frozen
class RelativeTo(Expression):
    """`a relative to b`."""

    value: Expression
    base: Expression


@frozen
class FieldAt(Expression):
    """`(field at place)`: only in brackets, since elsewhere `at` gives the place of an object."""

    field: Expression
    place: Expression


@frozen
class Slice(Expression):
    """`start:stop:step` between square brackets."""

    start: Expression | None
    stop: Expression | None
    step: Expression | None = None


@frozen
class CanSee(Expression):
    viewer: Expression
    target: Expression


@frozen
class Intersects(Expression):
    left: Expression
    right: Expression


@frozen
class Degrees(Expression):
    """`x deg`: Scenic's operator on any expression (a literal with the unit is a `Number`)."""

    value: Expression


@frozen
class OffsetBy(Expression):
    """`a offset by b`."""

    base: Expression
    offset: Expression


@frozen
class OffsetAlong(Expression):
    """`a offset along d by b`."""

    base: Expression
    direction: Expression
    offset: Expression


@frozen
class Temporal(Expression):
    """`always a`, `eventually a`, `next a`, `a until b`, `a implies b`: in the condition of a `require` only."""

    operator: str
    operands: tuple[Expression, ...]


# -- specifiers and `new` -------------------------------------------------------------------------------------------


class Specifier(Node):
    pass


@frozen
class At(Specifier):
    position: Expression


@frozen
class InRegion(Specifier):
    """`in region` / `on region`."""

    keyword: str
    region: Expression


@frozen
class OffsetBySpecifier(Specifier):
    """`offset by v`: relative to the ego."""

    offset: Expression


@frozen
class OffsetAlongSpecifier(Specifier):
    direction: Expression
    offset: Expression


@frozen
class Beside(Specifier):
    """`ahead of | behind | left of | right of x [by d]`; side is `ahead`, `behind`, `left` or `right`."""

    side: str
    reference: Expression
    distance: Expression | None


@frozen
class Following(Specifier):
    """`following field [from x] for d`."""

    direction: Expression
    origin: Expression | None
    distance: Expression


@frozen
class Before(Specifier):
    """`before intersection by d [along trajectory]`: the place on the trajectory d ahead of the junction."""

    region: Expression
    distance: Expression
    trajectory: Expression | None


@frozen
class After(Before):
    """`after intersection by d along trajectory`: the place on the trajectory d beyond the junction."""


@frozen
class Beyond(Specifier):
    """`beyond place by offset [from viewer]`: on the line of sight."""

    place: Expression
    offset: Expression
    viewer: Expression | None


@frozen
class Meeting(Specifier):
    """`meeting x at p after t [by d]`: the place from which it reaches x at time t, after a way of d."""

    other: Expression
    place: Expression
    time: Expression
    way: Expression | None


@frozen
class InSight(Specifier):
    """`visible [from x]`, `not visible [from x]`."""

    viewer: Expression | None
    seen: bool


@frozen
class ContainedIn(Specifier):
    """`contained in region`: anywhere in it, the whole outline inside."""

    region: Expression


@frozen
class Facing(Specifier):
    """`facing heading`, `facing toward point`, `facing away from point`, `apparently facing heading [from point]`; mode
    `""`, `toward`, `away`, `apparent`.
    """

    heading: Expression
    mode: str = ""
    viewer: Expression | None = None


@frozen
class With(Specifier):
    property: str
    value: Expression
    property_span: Span = field(compare=False, repr=False, kw_only=True)


@frozen
class New(Expression):
    class_name: str
    specifiers: tuple[Specifier, ...]
    class_span: Span = field(compare=False, repr=False, kw_only=True)


# -- statements -----------------------------------------------------------------------------------------------------


@frozen
class Map(Statement):
    """`map intersection(ways=4, ...)`; kind is the word after `map`."""

    kind: str
    arguments: tuple[Argument, ...]


@frozen
class Simulation(Statement):
    """`simulation(time_step=0.05 s, max_attempts=2000)`: settings of the file for its runs."""

    arguments: tuple[Argument, ...]


@frozen
class Model(Statement):
    """`model scenic.simulators.carla.model`: accepted for Scenic's sake, answered with a note."""

    name: str


@frozen
class ParamEntry(Node):
    name: str
    value: Expression
    name_span: Span = field(compare=False, repr=False, kw_only=True)


@frozen
class Param(Statement):
    """`param A = x, B = y`."""

    entries: tuple[ParamEntry, ...]


@frozen
class Assign(Statement):
    """`a = value`, `a, b = value`; targets are plain names."""

    targets: tuple[str, ...]
    value: Expression


@frozen
class SetAttribute(Statement):
    """`x.name = value`, `x.name += value`; operator is the binary one (`+`), or nothing."""

    target: Attribute
    operator: str
    value: Expression


@frozen
class AugmentedAssign(Statement):
    """`a += value`; operator is the binary one (`+`)."""

    target: str
    operator: str
    value: Expression


@frozen
class ExpressionStatement(Statement):
    value: Expression


@frozen
class Require(Statement):
    """`require[p] condition as "name"`."""

    condition: Expression
    probability: Expression | None = None
    name: str | None = None


@frozen
class RequireMonitor(Statement):
    """`require monitor M(arguments) as "name"`: the monitor runs in parallel to the scenario."""

    monitor: Expression
    name: str | None = None


@frozen
class TerminateWhen(Statement):
    """`terminate when condition as "name"`; `simulation` for `terminate simulation when`."""

    condition: Expression
    name: str | None = None
    simulation: bool = False


@frozen
class Expect(Statement):
    """`expect condition as "name"`: an expectation on the system under test in every run."""

    condition: Expression
    name: str | None = None


@frozen
class Optimize(Statement):
    """`maximize value as "name"`, `minimize value as "name"`; sense is the word."""

    sense: str
    value: Expression
    name: str | None = None


@frozen
class Record(Statement):
    """`record value as name`; when is `""` (a series over time), `initial` or `final`."""

    value: Expression
    when: str = ""
    name: str | None = None


@frozen
class Domain(Statement):
    """`domain "name" value at start in cells`; when is `start`, `contact` or `end`.

    With low and high, `cells` is the width of a step from low to high; else a list of values, or of pairs of ends.
    """

    name: str
    value: Expression
    when: str
    cells: Expression
    low: Expression | None = None
    high: Expression | None = None


@frozen
class Mutate(Statement):
    """`mutate a, b by 2`: noise on the pose of these objects; of all, where none is named."""

    targets: tuple[str, ...]
    amount: Expression | None = None


@frozen
class Signals(Statement):
    """`signals(green=20 s, yellow=3 s, all_red=2 s, offset=PHASE)`: the intersections have traffic lights."""

    arguments: tuple[Argument, ...]


@frozen
class Environment(Statement):
    """`environment(friction=0.4, sight=60 m, light=0.5)`: the weather of the whole run."""

    arguments: tuple[Argument, ...]


@frozen
class Import(Statement):
    """`import cars`, `import lib.cars as c`, `import "lib/cars.scn" as c`; `path` is as written, without quotes."""

    path: str
    alias: str | None = None
    quoted: bool = False
    path_span: Span = field(compare=False, repr=False, kw_only=True)


@frozen
class ImportedName(Node):
    name: str
    alias: str | None = None


@frozen
class ImportFrom(Statement):
    """`from cars import Taxi, slow as crawl`; `names` is empty for `*`."""

    path: str
    names: tuple[ImportedName, ...]
    quoted: bool = False
    path_span: Span = field(compare=False, repr=False, kw_only=True)


@frozen
class PropertyDefault(Node):
    """`speed: Range(3, 9) m/s` in a class."""

    name: str
    value: Expression
    name_span: Span = field(compare=False, repr=False, kw_only=True)


@frozen
class ClassDefinition(Statement):
    """`class Taxi(Car):` with property defaults, each evaluated again for every object."""

    name: str
    base: str | None
    properties: tuple[PropertyDefault, ...]
    docstring: str | None = None
    name_span: Span = field(compare=False, repr=False, kw_only=True)
    base_span: Span | None = field(compare=False, repr=False, kw_only=True, default=None)


@frozen
class TerminateAfter(Statement):
    """`terminate after 20 s`, `terminate after 400 steps`; `in_steps` for the latter (`seconds` also accepted)."""

    amount: Expression
    in_steps: bool = False


@frozen
class Parameter(Node):
    name: str
    default: Expression | None = None
    rest: bool = False
    """`*name`: takes all further arguments."""


@frozen
class Guard(Node):
    """`precondition: condition` or `invariant: condition`."""

    condition: Expression


@frozen
class BehaviorDefinition(Statement):
    name: str
    parameters: tuple[Parameter, ...]
    body: tuple[Statement, ...]
    docstring: str | None = None
    preconditions: tuple[Guard, ...] = ()
    invariants: tuple[Guard, ...] = ()
    name_span: Span = field(compare=False, repr=False, kw_only=True)


@frozen
class MonitorDefinition(Statement):
    """`monitor M(parameters):` a behaviour without an actor: it waits, requires and terminates."""

    name: str
    parameters: tuple[Parameter, ...]
    body: tuple[Statement, ...]
    docstring: str | None = None
    name_span: Span = field(compare=False, repr=False, kw_only=True)


@frozen
class ScenarioDefinition(Statement):
    """`scenario S(parameters):` with `setup:` and `compose:`; a body without either is its setup."""

    name: str
    parameters: tuple[Parameter, ...]
    setup: tuple[Statement, ...]
    compose: tuple[Statement, ...]
    docstring: str | None = None
    preconditions: tuple[Guard, ...] = ()
    invariants: tuple[Guard, ...] = ()
    name_span: Span = field(compare=False, repr=False, kw_only=True)


@frozen
class Override(Statement):
    """`override ego with behavior B()`: in the setup of a scenario, for as long as it runs."""

    target: Expression
    specifiers: tuple[Specifier, ...]


@frozen
class Do(Statement):
    """`do b`, `do b until c`, `do b for d`; at most one of `until` and `duration` is there."""

    invocations: tuple[Expression, ...]
    """One behaviour; several scenarios at once in a `compose`; the options of `choose` and `shuffle`, which may be one
    dictionary of weights."""
    until: Expression | None = None
    duration: Expression | None = None
    in_steps: bool = False
    """`do b for 20 steps`."""
    mode: str = ""
    """Mode: `choose`, one of them at random; `shuffle`, all, one after the other, in random order."""


@frozen
class Take(Statement):
    actions: tuple[Expression, ...]


@frozen
class Wait(Statement):
    """`wait`, `wait until c`, `wait for d`; at most one of `until` and `duration` is there."""

    until: Expression | None = None
    duration: Expression | None = None
    in_steps: bool = False


@frozen
class Assert(Statement):
    """`assert condition, message`."""

    condition: Expression
    message: Expression | None = None

    @property
    def name(self) -> str:
        """Return the message; values in a formatted message appear as `…`."""
        if isinstance(self.message, Formatted):
            return "".join(part if isinstance(part, str) else "…" for part in self.message.parts)
        return self.message.value if isinstance(self.message, String) else ""


@frozen
class Handler(Node):
    """`interrupt when condition: body`."""

    condition: Expression
    body: tuple[Statement, ...]


@frozen
class Try(Statement):
    body: tuple[Statement, ...]
    handlers: tuple[Handler, ...]


@frozen
class Abort(Statement):
    pass


@frozen
class Terminate(Statement):
    """`terminate` inside a behaviour: ends the scenario that made its object; `simulation` ends the whole run."""

    simulation: bool = False


@frozen
class If(Statement):
    """`if / elif / else`: branches of (condition, body), then the else body."""

    branches: tuple[tuple[Expression, tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...] = ()


@frozen
class While(Statement):
    condition: Expression
    body: tuple[Statement, ...]


@frozen
class For(Statement):
    """`for targets in iterable:`."""

    targets: tuple[str, ...]
    iterable: Expression
    body: tuple[Statement, ...]


@frozen
class FunctionDefinition(Statement):
    """`def f(parameters):` a function that the compiler calls."""

    name: str
    parameters: tuple[Parameter, ...]
    body: tuple[Statement, ...]
    docstring: str | None = None
    name_span: Span = field(compare=False, repr=False, kw_only=True)


@frozen
class Break(Statement):
    pass


@frozen
class Continue(Statement):
    pass


@frozen
class Return(Statement):
    """`return`: the behaviour is over; `return value` in a function."""

    value: Expression | None = None


@frozen
class Pass(Statement):
    pass


@frozen
class Module(Node):
    """A whole file."""

    statements: tuple[Statement, ...]
    docstring: str | None = None

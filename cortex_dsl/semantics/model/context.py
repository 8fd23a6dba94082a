"""Place of an expression, its evaluator, and the values that observers receive.

The evaluator dispatches on the node's type through a table that it is given, so that each family of expressions has its
own module and is independent of the others. An observer receives the value of every expression, even if the compiler
finds mistakes: the editor and the interactive session describe a text by them.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

from cortex_dsl import ir
from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.semantics.errors.names import UNKNOWN_NAME
from cortex_dsl.semantics.errors.problems import Mistake, NeedsExpansion
from cortex_dsl.semantics.errors.scene import RUNS_DIFFER
from cortex_dsl.semantics.errors.values import NOT_CONSTANT
from cortex_dsl.semantics.model.state import FileContext, FileFacts, Scope, VariantState
from cortex_dsl.semantics.model.values import POISON, Actor, Instance, Poison, Quantity, Value
from cortex_dsl.semantics.names.builtins import BUILTINS
from cortex_dsl.semantics.quantities.algebra import Algebra
from cortex_dsl.semantics.quantities.bounds import (
    CLOSED,
    Interval,
    closed_value,
    folded,
    leaves,
    may_be_undefined,
    part_interval,
    truth_of,
)
from cortex_dsl.semantics.quantities.units import dimension_name
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes
from engine.errors import Signal
from engine.frozen import frozen
from engine.opcodes import Op
from engine.vocabulary import GeneKind


@frozen
class Moment:
    """When an expression is evaluated: with the scene, or again and again during the run."""

    running: bool = False
    actor: Actor | None = None
    """Actor with this behaviour (`self`)."""
    repeated: bool = False
    """Inside a loop or handler, which may be entered again."""
    scenario: Instance | None = None
    """Scenario with this setup or compose; None for the top level."""
    later: bool = False
    """Known with the scene, but used when objects may have moved."""
    looping: bool = False
    """Inside a loop, which may be entered any number of times."""
    judged: bool = False
    """Looked at up to the instant of the ego's contact, that included: in `expect`, `maximize` and `minimize`."""
    over: bool = False
    """Worked out once, when the run is over."""


SCENE = Moment()
Handler = Callable[["Evaluator", nodes.Expression], Value]
Observer = Callable[["Evaluator", nodes.Expression, Value], None]


@frozen
class Evaluator:
    """Evaluates expressions at one place: `scopes` are searched from the innermost to the module's names."""

    run: VariantState
    handlers: Mapping[type, Handler]
    scopes: tuple[Mapping[str, Value], ...] = ()
    moment: Moment = SCENE
    home: dict[str, Value] | None = None
    """Variables of the imported file in which the place lies; None in the main file."""
    frame: dict[str, Value] | None = None
    """Variables of the function that is being called."""
    observe: Observer | None = None
    """Called with every value as it is worked out; an editor collects them."""

    @property
    def algebra(self) -> Algebra:
        return self.run.algebra

    @property
    def file(self) -> FileContext:
        return self.run.file

    @property
    def facts(self) -> FileFacts:
        return self.run.file.facts

    @property
    def names(self) -> dict[str, Value]:
        """Variables of the file's top level."""
        return self.run.names if self.home is None else self.home

    @property
    def ego(self) -> Actor | None:
        """The ego as this place sees it: a scenario may have its own."""
        scenario = self.moment.scenario or (self.moment.actor.scenario if self.moment.actor else None)
        while scenario is not None and scenario.ego is None:
            scenario = scenario.parent
        return self.run.ego if scenario is None else scenario.ego

    @property
    def scope(self) -> dict[str, Value]:
        """Return the variables that an assignment at this place changes; functions and scenarios have their own."""
        if self.frame is not None:
            return self.frame
        return self.names if self.moment.scenario is None else self.moment.scenario.names

    @property
    def scope_name(self) -> Scope:
        """Return the owner of the variables of `scope`."""
        if self.moment.scenario is not None:
            return self.moment.scenario
        return next((name for name, names in self.run.imported.items() if names is self.home), "")

    def within(self, scopes: tuple[Mapping[str, Value], ...]) -> "Evaluator":
        """Return the evaluator with these scopes alone."""
        return self._changed(scopes, self.moment)

    def find(self, name: str) -> Value:
        """The value of a variable; None where there is none."""
        return next((scope[name] for scope in (*self.scopes, self.names) if name in scope), None)

    def at_home(self, home: dict[str, Value] | None) -> "Evaluator":
        """A place at the top level of a file."""
        return replace(self, home=home, scopes=(), frame=None)

    def framed(self, frame: dict[str, Value]) -> "Evaluator":
        """A place in a function with these variables."""
        return replace(self.inside(frame), frame=frame)

    def inside(self, names: Mapping[str, Value]) -> "Evaluator":
        """Return the evaluator with more names."""
        return self._changed((names, *self.scopes), self.moment)

    def at_moment(self, moment: Moment) -> "Evaluator":
        return self._changed(self.scopes, moment)

    def _changed(self, scopes: tuple[Mapping[str, Value], ...], moment: Moment) -> "Evaluator":
        """Return a copy with other scopes and moment.

        A file makes ten thousands of them, and `replace` takes more than twice as long.
        """
        return Evaluator(self.run, self.handlers, scopes, moment, self.home, self.frame, self.observe)

    def evaluate(self, node: nodes.Expression) -> Value:
        """The value of an expression.

        Raises:
            Mistake: when it has none.
        """
        run, span = self.run, node.span
        algebra, before = run.algebra, run.algebra.span
        algebra.span = span
        run.file.budget.spend(span)
        try:
            value = self.handlers[type(node)](self, node)
        finally:
            algebra.span = before
        if self.observe is not None:
            self.observe(self, node, value)
        return value

    def evaluate_all(self, expressions: Iterable[nodes.Expression]) -> list[Value]:
        """Values of several expressions; reports every mistake in them before giving up."""
        values = [self.tolerate(lambda node=node: self.evaluate(node)) for node in expressions]
        if any(value is POISON for value in values):
            raise Mistake
        return values

    def tolerate(self, compute: Callable[[], Value]) -> Value:
        """Return the result of `compute`, or poison after reporting its mistake."""
        try:
            return compute()
        except Mistake as mistake:
            self.report(mistake)
            return POISON

    def report(self, finding: Mistake | Diagnostic) -> None:
        diagnostic = finding.diagnostic if isinstance(finding, Mistake) else finding
        if diagnostic is not None:
            self.file.findings.add(diagnostic)

    def lookup(self, name: str, span: Span) -> Value:
        """The value of a variable."""
        for scope in (*self.scopes, self.names):
            if name in scope:
                return self.usable(scope[name])
        if name == "ego" and self.ego is not None:
            return self.ego
        if self.file.findings.is_settled(span):
            raise Mistake
        raise UNKNOWN_NAME.mistake(span, name=name, suggestion=did_you_mean(name, self.known_names()))

    def usable(self, value: Value) -> Value:
        """Return the value unless it is poison.

        Raises:
            Mistake: a mistake left it behind.
        """
        if isinstance(value, Poison):
            raise Mistake
        return value

    def has(self, name: str) -> bool:
        return name in self.names or any(name in scope for scope in self.scopes)

    def known_names(self) -> set[str]:
        return {name for scope in (*self.scopes, self.names, BUILTINS) for name in scope}

    # -- concrete values ---------------------------------------------------------------------------------------------

    def constant(self, quantity: Quantity, span: Span, purpose: str, *, may_vary: bool = True) -> float:
        """The number itself, where it must be known; asks for the enumeration of finite choices behind it.

        `may_vary`: variants may differ in it.

        Raises:
            NeedsExpansion: when it depends on finite choices only.
            Mistake: when it depends on anything else.
        """
        value = closed_value(quantity.expr, self._operations())
        if value is not None:
            return value
        if not may_vary:
            raise RUNS_DIFFER.mistake(span, what=purpose)
        sites = self._finite_sites(quantity.expr)
        if not sites:
            raise NOT_CONSTANT.mistake(span, purpose=purpose, what=dimension_name(quantity.dimension))
        raise NeedsExpansion(sites)

    def _operations(self) -> Mapping[Op, Callable[..., float]]:
        """Return the operations that can be evaluated at compile time, including geometry of the network."""
        if (network := self.run.built.network) is None:
            return CLOSED
        return {
            **CLOSED,
            Op.PATH_LENGTH: lambda path: network.paths.length(int(path)),
            Op.PATH_DISTANCE: lambda path, x, y: network.paths.distance(int(path), x, y),
            Op.REGION_DISTANCE: lambda region, x, y: network.regions.distance(int(region), x, y),
            Op.REGION_CONTAINS: lambda region, x, y: float(network.regions.contains(int(region), x, y)),
        }

    def _finite_sites(self, expression: ir.Expr) -> frozenset[Span] | None:
        """Return the places of the finite choices in an expression; None if it also depends on anything else."""
        sites = set()
        genes = self.file.genes.infos
        for leaf in leaves(expression):
            match leaf:
                case ir.Literal():
                    continue
                case ir.Draw(index=index) if index in self.run.decisions.finite_draws:
                    sites.add(self.run.decisions.finite_draws[index])
                case ir.Gene(index=index) if genes[index].kind != GeneKind.CONTINUOUS:
                    sites.add(genes[index].span)
                case _:
                    return None
        return frozenset(sites)

    def interval(self, expression: ir.Expr) -> Interval:
        """Numbers between which the value of an expression surely lies."""
        if isinstance(expression, ir.Literal):
            return (expression.value, expression.value)
        genes, pool = self.file.genes.bounds, self.file.pool

        def bounds(part: ir.Expr, within: list[Interval]) -> Interval:
            if isinstance(part, ir.Apply) and part.op is Op.TABLE:
                return pool.bounds(part.immediates[0])
            return part_interval(part, within, genes)

        return folded(expression, bounds, self.algebra.intervals)

    def may_be_undefined(self, expression: ir.Expr) -> bool:
        """Return whether a part of an expression may have no value, such as a root."""
        return may_be_undefined(expression, self.interval, self.algebra.undefined)

    def truth_of(self, condition: ir.Expr) -> Interval:
        """Return the interval of the truth of a condition, (0, 1) if it may have no value."""
        return truth_of(condition, self.interval)

    @contextmanager
    def naming(self, name: str) -> Iterator[None]:
        """Objects and choices made inside are called `name`."""
        before = self.run.assigning
        self.run.assigning = name
        try:
            yield
        finally:
            self.run.assigning = before


# -- observers ---------------------------------------------------------------------------------------------------------

MOST_VALUES = 24
"""Maximum number of stored values of one expression, which has one per combination of the file's choices."""


class Cancelled(Signal):
    """Stops a compilation that is no longer needed."""


@dataclass(frozen=True)
class ObservedValue:
    """One value that an expression had, and where it had it."""

    evaluator: Evaluator
    value: Value


ObservedValues = Sequence[ObservedValue]


@dataclass
class ValueRecorder:
    """Collects values during a compilation; `superseded` is called at each value."""

    superseded: Callable[[], bool] = lambda: False
    seen: dict[Span, list[ObservedValue]] = field(default_factory=dict)

    def __call__(self, evaluator: Evaluator, node: nodes.Expression, value: Value) -> None:
        if self.superseded():
            raise Cancelled
        seen_values = self.seen.setdefault(node.span, [])
        if len(seen_values) < MOST_VALUES:
            seen_values.append(ObservedValue(evaluator, value))

"""Names before values: every name of the file is looked up once, behaviours that nothing runs included.

The top level is read in order, so a name must be assigned above its use. Behaviours and `terminate when` see all names
of the file, because they run after it. In a behaviour, a name that is assigned anywhere in it is its own.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cache

from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.builtins import BUILTINS, SPECIAL_NAMES, Kind, names_of
from cortex_dsl.semantics.findings import Findings
from cortex_dsl.semantics.overrides import param_entries
from cortex_dsl.semantics.placement import check_placement
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes

UNASSIGNABLE: Mapping[str, str] = {
    "self": "it is the object that a behavior drives",
    "none": "it stands for no value",
    "globalParameters": "it holds the params",
}
SEARCHED = ("Range", "TruncatedNormal", "DiscreteRange", "VerifaiRange", "VerifaiDiscreteRange", "VerifaiOptions")
"""Distributions that make a param a gene whatever their arguments are."""


def check_names(module: nodes.Module, findings: Findings) -> None:
    """Report unknown, early, doubled and unused names, and statements in the wrong place."""
    check_placement(module, findings)
    resolver = _Resolver(module, findings)
    resolver.resolve()
    resolver.report_unused()


@cache
def _field_names(kind: type) -> tuple[str, ...]:
    return tuple(f.name for f in fields(kind))


def parts(node: nodes.Node) -> Iterator[nodes.Node]:
    """The nodes directly inside a node, in the order of the text."""
    for name in _field_names(type(node)):
        yield from _nodes_in(getattr(node, name))


def everything_in(node: nodes.Node) -> Iterator[nodes.Node]:
    """All nodes below a node."""
    for part in parts(node):
        yield part
        yield from everything_in(part)


def _nodes_in(value: object) -> Iterator[nodes.Node]:
    if isinstance(value, nodes.Node):
        yield value
    elif isinstance(value, tuple):
        for item in value:
            yield from _nodes_in(item)


@dataclass
class _Resolver:
    module: nodes.Module
    findings: Findings
    used: set[str] = field(default_factory=set)
    known: set[str] = field(default_factory=set)
    """Names of the top level that have a value by now."""

    def __post_init__(self) -> None:
        self.behaviours = [s for s in self.module.statements if isinstance(s, nodes.BehaviorDefinition)]
        self.params = param_entries(self.module)
        self.all_names = {name for s in self.module.statements for name in _bound(s)}
        self.known = {b.name for b in self.behaviours}

    # -- the top level -----------------------------------------------------------------------------------------------

    def resolve(self) -> None:
        self._report_doubles()
        for statement in self.module.statements:
            self._statement(statement)
            self.known.update(_bound(statement))
        late = _Names(self, self.all_names, frozenset())
        for statement in self.module.statements:
            if isinstance(statement, nodes.TerminateWhen):
                late.visit(statement.condition)
        for behaviour in self.behaviours:
            _BehaviourNames(self, behaviour).check()

    def _statement(self, statement: nodes.Statement) -> None:
        if isinstance(statement, nodes.BehaviorDefinition | nodes.TerminateWhen):
            return
        names = _Names(self, self.known, frozenset())
        if isinstance(statement, nodes.AugmentedAssign):
            names.use(statement.target, statement.span)
        for part in parts(statement):
            names.visit(part)
        for name in _bound(statement):
            self.check_assignable(name, statement.span)

    def check_assignable(self, name: str, span: Span) -> None:
        if name in UNASSIGNABLE:
            self.findings.add(errors.CANNOT_ASSIGN.at(span, name=name, reason=UNASSIGNABLE[name]))

    def _report_doubles(self) -> None:
        maps = [s for s in self.module.statements if isinstance(s, nodes.Map)]
        for second in maps[1:]:
            self.findings.add(errors.MAP_TWICE.at(second.span, secondary=(Label(maps[0].span, "first here"),)))
        seen: dict[tuple[str, str], Span] = {}
        entries = [e for s in self.module.statements if isinstance(s, nodes.Param) for e in s.entries]
        named = [("the param", e.name, e.name_span) for e in entries]
        named += [("the behavior", b.name, b.name_span) for b in self.behaviours]
        for what, name, span in named:
            if (what, name) in seen:
                self.findings.add(duplicate(what, name, span, seen[what, name]))
            seen.setdefault((what, name), span)

    # -- afterwards --------------------------------------------------------------------------------------------------

    def report_unused(self) -> None:
        for behaviour in self.behaviours:
            if behaviour.name not in self.used:
                self.findings.add(errors.UNUSED_BEHAVIOUR.at(behaviour.name_span, name=behaviour.name))
        for entry in self.params.values():
            if entry.name not in self.used and _is_searched(entry.value):
                self.findings.add(errors.UNUSED_GENE.at(entry.name_span, name=entry.name))


def duplicate(what: str, name: str, span: Span, first: Span) -> Diagnostic:
    return errors.DUPLICATE.at(span, what=what, name=name, secondary=(Label(first, "first here"),))


def _bound(statement: nodes.Statement) -> tuple[str, ...]:
    """Names that a top-level statement gives a value to."""
    match statement:
        case nodes.Assign(targets=targets):
            return targets
        case nodes.AugmentedAssign(target=target):
            return (target,)
        case nodes.Param(entries=entries):
            return tuple(entry.name for entry in entries if entry.name != "map")
        case nodes.BehaviorDefinition(name=name):
            return (name,)
    return ()


def _is_searched(value: nodes.Expression) -> bool:
    if isinstance(value, nodes.WithUnit | nodes.Degrees):
        value = value.value
    return isinstance(value, nodes.Call) and isinstance(value.function, nodes.Name) and value.function.id in SEARCHED


@dataclass(frozen=True)
class _Names:
    """Looks up the names of one expression."""

    resolver: _Resolver
    visible: set[str]
    inner: frozenset[str]
    """Names of lambdas, comprehensions and the behaviour around the expression."""
    early: frozenset[str] = frozenset()
    """Names of the behaviour that have no value yet."""
    in_behaviour: bool = False

    def visit(self, node: nodes.Node) -> None:
        match node:
            case nodes.Name(id=name):
                self.use(name, node.span)
            case nodes.Lambda(parameters=parameters, body=body):
                # It is called later, when more names have a value.
                replace(self._with(parameters), visible=self.resolver.all_names).visit(body)
            case nodes.Comprehension():
                self._comprehension(node)
            case nodes.Attribute(value=nodes.Name(id="globalParameters"), name=name):
                self._param(name, node.name_span)
            case _:
                for part in parts(node):
                    self.visit(part)

    def _with(self, names: tuple[str, ...]) -> "_Names":
        inner = self.inner | frozenset(names)
        return _Names(self.resolver, self.visible, inner, self.early - frozenset(names), self.in_behaviour)

    def _comprehension(self, node: nodes.Comprehension) -> None:
        names = self
        for clause in node.clauses:
            names.visit(clause.iterable)
            names = names._with(clause.targets)
            for condition in clause.conditions:
                names.visit(condition)
        names.visit(node.element)

    def _param(self, name: str, span: Span) -> None:
        self.resolver.used.add(name)
        if name not in self.resolver.params:
            suggestion = did_you_mean(name, self.resolver.params) or "this file has no params"
            self.resolver.findings.add(errors.UNKNOWN_PARAM.at(span, name=name, suggestion=suggestion))

    def use(self, name: str, span: Span) -> None:
        self.resolver.used.add(name)
        if name in self.early:
            self.resolver.findings.add(errors.USED_BEFORE.at(span, name=name))
        elif name == "self" and not self.in_behaviour:
            self.resolver.findings.add(errors.SELF_OUTSIDE.at(span))
        elif not self._is_known(name):
            self._report(name, span)

    def _is_known(self, name: str) -> bool:
        if name in self.inner or name in self.visible or name in BUILTINS:
            return True
        return name in SPECIAL_NAMES and name not in self.resolver.all_names

    def _report(self, name: str, span: Span) -> None:
        if name in self.resolver.all_names:
            self.resolver.findings.add(errors.USED_BEFORE.at(span, name=name))
            return
        candidates = {*self.inner, *self.visible, *BUILTINS, *SPECIAL_NAMES} - ({"self"} - {*self.inner})
        suggestion = did_you_mean(name, candidates)
        if not suggestion and name.endswith("Behavior"):
            suggestion = "library behaviors: " + ", ".join(f"`{n}`" for n in names_of(Kind.BEHAVIOUR))
        self.resolver.findings.add(errors.UNKNOWN_NAME.at(span, name=name, suggestion=suggestion))


@dataclass
class _BehaviourNames:
    """Looks up the names of one behaviour, statement by statement."""

    resolver: _Resolver
    behaviour: nodes.BehaviorDefinition

    def __post_init__(self) -> None:
        self.parameters = frozenset(p.name for p in self.behaviour.parameters)
        self.locals = frozenset(_assigned(self.behaviour.body)) - self.parameters
        self.early = set(self.locals)

    def check(self) -> None:
        seen: dict[str, Span] = {}
        outside = _Names(self.resolver, self.resolver.all_names, frozenset(), in_behaviour=True)
        for parameter in self.behaviour.parameters:
            if parameter.name in seen:
                first = seen[parameter.name]
                self.resolver.findings.add(duplicate("the argument", parameter.name, parameter.span, first))
            seen[parameter.name] = parameter.span
            if parameter.default is not None:
                outside.visit(parameter.default)
        self._block(self.behaviour.body)

    def _block(self, statements: tuple[nodes.Statement, ...]) -> None:
        for statement in statements:
            self._statement(statement)

    def _statement(self, statement: nodes.Statement) -> None:
        names = _Names(
            self.resolver,
            self.resolver.all_names,
            self.parameters | self.locals,
            frozenset(self.early),
            in_behaviour=True,
        )
        for part in parts(statement):
            if isinstance(part, nodes.Statement):
                self._statement(part)
            elif isinstance(part, nodes.Handler):
                names.visit(part.condition)
                self._block(part.body)
            else:
                names.visit(part)
        if isinstance(statement, nodes.AugmentedAssign):
            names.use(statement.target, statement.span)
        for name in _bound(statement):
            self.resolver.check_assignable(name, statement.span)
            self.early.discard(name)


def _assigned(statements: tuple[nodes.Statement, ...]) -> Iterator[str]:
    """Names that a body assigns, nested blocks included."""
    for statement in statements:
        yield from _bound(statement) if not isinstance(statement, nodes.BehaviorDefinition) else ()
        for part in parts(statement):
            if isinstance(part, nodes.Statement):
                yield from _assigned((part,))
            elif isinstance(part, nodes.Handler):
                yield from _assigned(part.body)

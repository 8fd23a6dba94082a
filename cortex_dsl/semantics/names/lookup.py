"""The names of one expression: each is known at its place, or reported with the nearest known name."""

from collections.abc import Iterable, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import field, replace

from cortex_dsl.semantics.errors.names import TEMPORAL_PLACE, UNKNOWN_NAME, UNKNOWN_PARAM, USED_BEFORE
from cortex_dsl.semantics.errors.problems import Findings
from cortex_dsl.semantics.errors.scene import SELF_OUTSIDE
from cortex_dsl.semantics.errors.values import CANNOT_ASSIGN
from cortex_dsl.semantics.names.builtins import BUILTINS, SPECIAL_NAMES, UNASSIGNABLE, Kind, names_of
from cortex_dsl.semantics.names.tree import TIMED, parts
from cortex_dsl.source import Span
from cortex_dsl.spelling import class_called, did_you_mean, likely_range, nearest
from cortex_dsl.syntax import nodes
from engine.frozen import frozen


@frozen
class NameTable:
    """Names of one file, and records of their use."""

    findings: Findings
    params: Mapping[str, nodes.ParamEntry]
    """Params of all files."""
    all_names: frozenset[str]
    """All that the top level gives a value to."""
    from_scenic: bool = False
    """Whether a file has a `model` line, so that the command line may define params."""
    used: set[str] = field(default_factory=set)

    def check_assignable(self, name: str, span: Span) -> None:
        if name in UNASSIGNABLE:
            self.findings.add(CANNOT_ASSIGN.at(span, name=name, reason=UNASSIGNABLE[name]))


@frozen
class Names:
    """Looks up the names of one expression."""

    table: NameTable
    visible: AbstractSet[str]
    inner: frozenset[str]
    """Names of lambdas, comprehensions and the behaviour around the expression."""
    early: frozenset[str] = frozenset()
    """Names of the behaviour that have no value yet."""
    in_behaviour: bool = False
    running: bool = False
    """Whether the expression is in a behaviour or a monitor."""

    def visit(self, node: nodes.Node) -> None:
        match node:
            case nodes.Name(id=name):
                self.use(name, node.span)
            case nodes.New(class_name=name):
                self.table.used.add(name)
                for part in parts(node):
                    self.visit(part)
            case nodes.Lambda(parameters=parameters, body=body):
                # It is called later, when more names have a value.
                replace(self._with(parameters), visible=self.table.all_names).visit(body)
            case nodes.Comprehension():
                self._comprehension(node)
            case nodes.Attribute(value=nodes.Name(id="globalParameters"), name=name):
                self._param(name, node.name_span)
            case nodes.Temporal(operator=operator) if operator in TIMED:
                cure = "write a plain `require`: it looks at each moment at which it runs" if self.running else ""
                cure = cure or "join it only by `and`, `or` and `not`, in a `require`"
                self.table.findings.add(TEMPORAL_PLACE.at(node.span, operator=operator, cure=cure))
            case _:
                for part in parts(node):
                    self.visit(part)

    def _with(self, names: Iterable[str]) -> "Names":
        inner = frozenset(names)
        return replace(self, inner=self.inner | inner, early=self.early - inner)

    def _comprehension(self, node: nodes.Comprehension) -> None:
        names = self
        for clause in node.clauses:
            names.visit(clause.iterable)
            names = names._with(clause.targets)
            for condition in clause.conditions:
                names.visit(condition)
        names.visit(node.element)

    def _param(self, name: str, span: Span) -> None:
        self.table.used.add(name)
        if name not in self.table.params:
            declared = f"declare it: `param {name} = {likely_range(name)}`"
            given = f"give it on the command line, as in `-p {name}=5`, or " if self.table.from_scenic else ""
            suggestion = given + declared
            if nearest(name, self.table.params) is not None:
                suggestion = did_you_mean(name, self.table.params) + (f" Or {suggestion}" if given else "")
            self.table.findings.add(UNKNOWN_PARAM.at(span, name=name, suggestion=suggestion))

    def use(self, name: str, span: Span) -> None:
        self.table.used.add(name)
        if name in self.early:
            self.table.findings.add(USED_BEFORE.at(span, name=name))
        elif name == "self" and not self.in_behaviour and name not in self.inner:
            self.table.findings.add(SELF_OUTSIDE.at(span))
        elif not self._is_known(name):
            self._report(name, span)

    def _is_known(self, name: str) -> bool:
        if name in self.inner or name in self.visible or name in BUILTINS:
            return True
        return name in SPECIAL_NAMES and name not in self.table.all_names

    def _kind_of_thing(self, name: str, candidates: AbstractSet[str]) -> str:
        """Return the cure for `truck` if no object has that name: the class `Truck` exists."""
        meant = class_called(name, names_of(Kind.CLASS)) if name[0].islower() else None
        if meant is None or nearest(name, candidates - BUILTINS.keys()) is not None:
            return ""
        return f"make it first: `{name} = new {meant} …`"

    def _report(self, name: str, span: Span) -> None:
        if name in self.table.all_names:
            self.table.findings.add(USED_BEFORE.at(span, name=name))
            return
        candidates = {*self.inner, *self.visible, *BUILTINS, *SPECIAL_NAMES} - ({"self"} - {*self.inner})
        suggestion = self._kind_of_thing(name, candidates) or did_you_mean(name, candidates)
        self.table.used.add(nearest(name, candidates) or name)  # the suggested name counts as used
        if not suggestion and name.endswith("Behavior"):
            suggestion = "library behaviors: " + ", ".join(f"`{n}`" for n in names_of(Kind.BEHAVIOUR))
        elif not suggestion and name.isupper():
            suggestion = f"declare it: `param {name} = {likely_range(name)}`"
        self.table.findings.add(UNKNOWN_NAME.at(span, name=name, suggestion=suggestion))

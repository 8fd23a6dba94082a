"""Looking up the names of definitions, statement by statement.

They run after the top level, so they see all names of the file. A name that a body assigns anywhere is its own.
"""

from dataclasses import dataclass, replace

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.names.binding import Definition, assigned, body_of, bound_by, duplicate, looked_at
from cortex_dsl.semantics.names.looking_up import Names, NameTable
from cortex_dsl.semantics.running.rules import speaks_of_run
from cortex_dsl.semantics.tree import parts
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes


@dataclass
class BodyNames:
    """Looks up the names of one behaviour or monitor, statement by statement."""

    table: NameTable
    definition: Definition

    def __post_init__(self) -> None:
        self.parameters = frozenset(p.name for p in self.definition.parameters)
        self.body = body_of(self.definition)
        self.locals = frozenset(assigned(self.body)) - self.parameters
        if isinstance(self.definition, nodes.ScenarioDefinition):
            self.locals -= {"ego"}
        self.early = set(self.locals)
        self.in_behaviour = isinstance(self.definition, nodes.BehaviorDefinition)

    def check(self) -> None:
        seen: dict[str, Span] = {}
        outside = Names(self.table, self.table.all_names, frozenset(), in_behaviour=self.in_behaviour)
        for parameter in self.definition.parameters:
            if parameter.name in seen:
                first = seen[parameter.name]
                self.table.findings.add(duplicate("the argument", parameter.name, parameter.span, first))
            seen[parameter.name] = parameter.span
            if parameter.name == "self":
                self.table.findings.add(self._self_named(parameter.span))
            if parameter.default is not None:
                outside.visit(parameter.default)
        if not isinstance(self.definition, nodes.MonitorDefinition):
            # What a scenario sets up has its values when its guards are tested, what a behaviour assigns has not.
            scenario = isinstance(self.definition, nodes.ScenarioDefinition)
            names = replace(self._names(), early=frozenset()) if scenario else self._names()
            for guard in (*self.definition.preconditions, *self.definition.invariants):
                names.visit(guard.condition)
        self._block(self.body)

    def _self_named(self, span: Span) -> Diagnostic:
        kinds = {nodes.BehaviorDefinition: "behavior", nodes.MonitorDefinition: "monitor"}
        reason = "it is there anyway" if self.in_behaviour else "it drives no object"
        return errors.SELF_AS_PARAMETER.at(span, kind=kinds.get(type(self.definition), "scenario"), reason=reason)

    def _names(self) -> Names:
        inner, early = self.parameters | self.locals, frozenset(self.early)
        return Names(self.table, self.table.all_names, inner, early, self.in_behaviour, running=True)

    def _waits_for_run(self, statement: nodes.Statement) -> bool:
        """Whether a statement of a setup is evaluated when everything has been set up."""
        setup = self.definition.setup if isinstance(self.definition, nodes.ScenarioDefinition) else ()
        return speaks_of_run(statement) and any(statement is each for each in setup)

    def _block(self, statements: tuple[nodes.Statement, ...]) -> None:
        for statement in statements:
            self._statement(statement)

    def _statement(self, statement: nodes.Statement) -> None:
        names = self._names()
        if isinstance(statement, nodes.ClassDefinition):
            names = replace(names, in_behaviour=True)
        if self._waits_for_run(statement):
            for condition in looked_at(statement):
                replace(names, early=frozenset()).visit(condition)
            return
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
        for name in bound_by(statement):
            self.table.check_assignable(name, statement.span)
            self.early.discard(name)

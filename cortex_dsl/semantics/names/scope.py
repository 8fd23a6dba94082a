"""Names before values: every name of the file is looked up once, behaviours that nothing runs included.

The top level is read in order, so a name must be assigned above its use. Definitions and `terminate when` see all names
of the file, because they run after it. In a definition, a name that is assigned anywhere in it is its own.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.semantics.errors.names import (
    SELF_AS_PARAMETER,
    UNUSED_BEHAVIOUR,
    UNUSED_GENE,
)
from cortex_dsl.semantics.errors.problems import Findings
from cortex_dsl.semantics.errors.runs import UNUSED_MONITOR
from cortex_dsl.semantics.errors.scene import MAP_TWICE
from cortex_dsl.semantics.names.linking import NO_FILES, ImportedFile, nameless
from cortex_dsl.semantics.names.lookup import Names, NameTable
from cortex_dsl.semantics.names.placement import check_placement
from cortex_dsl.semantics.names.tree import (
    Definition,
    all_params,
    assigned,
    body_of,
    bound_by,
    bound_name,
    duplicate,
    is_class,
    is_searched,
    lists_names,
    looked_at,
    names_in,
    param_entries,
    parts,
    scenic_model,
    speaks_of_run,
)
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes

# -- one definition ----------------------------------------------------------------------------------------------------


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
        self.early = set(self.locals) - {each.name for each in self.body if isinstance(each, Definition)}
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
        if not isinstance(self.definition, nodes.MonitorDefinition | nodes.FunctionDefinition):
            # Variables of a setup have values when guards are tested, variables of a behaviour have none yet.
            scenario = isinstance(self.definition, nodes.ScenarioDefinition)
            names = replace(self._names(), early=frozenset()) if scenario else self._names()
            for guard in (*self.definition.preconditions, *self.definition.invariants):
                names.visit(guard.condition)
        self._block(self.body)

    def _self_named(self, span: Span) -> Diagnostic:
        kinds = {nodes.BehaviorDefinition: "behavior", nodes.MonitorDefinition: "monitor"}
        reason = "it is there anyway" if self.in_behaviour else "it drives no object"
        return SELF_AS_PARAMETER.at(span, kind=kinds.get(type(self.definition), "scenario"), reason=reason)

    def _names(self) -> Names:
        inner, early = self.parameters | self.locals, frozenset(self.early)
        return Names(self.table, self.table.all_names, inner, early, self.in_behaviour, running=True)

    def _waits_for_run(self, statement: nodes.Statement) -> bool:
        """Return whether a statement of a setup is evaluated after all setups."""
        setup = self.definition.setup if isinstance(self.definition, nodes.ScenarioDefinition) else ()
        return speaks_of_run(statement) and any(statement is each for each in setup)

    def _block(self, statements: tuple[nodes.Statement, ...]) -> None:
        for statement in statements:
            self._statement(statement)

    def _statement(self, statement: nodes.Statement) -> None:
        if isinstance(statement, Definition):
            around = self.table.all_names | self.parameters | self.locals
            BodyNames(replace(self.table, all_names=around), statement).check()
            return
        names = self._names()
        if isinstance(statement, nodes.ClassDefinition):
            names = replace(names, in_behaviour=True)
        if self._waits_for_run(statement):
            for condition in looked_at(statement):
                replace(names, early=frozenset())._with(names_in(statement)).visit(condition)
            return
        if isinstance(statement, nodes.For):
            names.visit(statement.iterable)
            self.early -= {*statement.targets}
            self._block(statement.body)
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


# -- one file ----------------------------------------------------------------------------------------------------------

Imports = Mapping[Span, ImportedFile]


def check_names(module: nodes.Module, findings: Findings, imports: Imports = NO_FILES) -> None:
    """Report unknown, early, doubled and unused names, and statements in the wrong place, imported files included."""
    modules = dict.fromkeys(file.module for file in imports.values())
    params = {name: entry for each in (*modules, module) for name, entry in param_entries(each).items()}
    from_scenic = any(scenic_model(each) is not None for each in (*modules, module))
    main, *others = (_Resolver(each, findings, imports, params, from_scenic) for each in (module, *modules))
    for resolver in (*others, main):
        check_placement(resolver.module, findings)
        resolver.resolve()
        main.table.used.update(resolver.table.used & params.keys())
    main.report_unused()


@dataclass
class _Resolver:
    """The names of one file's top level, statement by statement."""

    module: nodes.Module
    findings: Findings
    imports: Imports
    params: Mapping[str, nodes.ParamEntry]
    """Params of all files."""
    from_scenic: bool = False
    known: set[str] = field(default_factory=set)
    """Names of the top level that have a value by now."""

    def __post_init__(self) -> None:
        self.behaviours = [s for s in self.module.statements if isinstance(s, nodes.BehaviorDefinition)]
        self.monitors = [s for s in self.module.statements if isinstance(s, nodes.MonitorDefinition)]
        self.scenarios = [s for s in self.module.statements if isinstance(s, nodes.ScenarioDefinition)]
        self.functions = [s for s in self.module.statements if isinstance(s, nodes.FunctionDefinition)]
        names = frozenset(name for s in self.module.statements for name in self.bound(s))
        self.table = NameTable(self.findings, self.params, names, self.from_scenic)
        self.known = {b.name for b in (*self.behaviours, *self.monitors, *self.scenarios, *self.functions)}

    def bound(self, statement: nodes.Statement) -> tuple[str, ...]:
        """Names that a statement gives a value to; `from x import *` those of the file x."""
        if isinstance(statement, nodes.For | nodes.If | nodes.While):
            return tuple(assigned((statement,)))
        if not isinstance(statement, nodes.ImportFrom) or statement.names or statement.span not in self.imports:
            return bound_by(statement)
        others = self.imports[statement.span].module.statements
        return tuple(name for each in others for name in self.bound(each))

    # -- the top level -----------------------------------------------------------------------------------------------

    def resolve(self) -> None:
        self._report_doubles()
        for statement in self.module.statements:
            self._statement(statement)
            self.known.update(self.bound(statement))
        late = Names(self.table, self.table.all_names, frozenset())
        for statement in self.module.statements:
            if speaks_of_run(statement):
                for part in looked_at(statement):
                    late._with(names_in(statement)).visit(part)
        for definition in (*self.behaviours, *self.monitors, *self.scenarios, *self.functions):
            BodyNames(self.table, definition).check()

    def _statement(self, statement: nodes.Statement) -> None:
        if isinstance(statement, Definition) or speaks_of_run(statement):
            return
        names = Names(self.table, self.known, frozenset(), in_behaviour=isinstance(statement, nodes.ClassDefinition))
        if isinstance(statement, nodes.Import) and bound_name(statement) is None:
            self.findings.add(nameless(statement))
        if isinstance(statement, nodes.AugmentedAssign):
            names.use(statement.target, statement.span)
        for part in parts(statement):
            if isinstance(part, nodes.Statement):
                self._statement(part)
            elif not lists_names(statement, part):
                names.visit(part)
            if isinstance(statement, nodes.For):
                self.known.update(statement.targets)
        self.known.update(bound_by(statement))
        for name in bound_by(statement):
            self.table.check_assignable(name, statement.span)
            self._check_scenario(name, statement)

    def _check_scenario(self, name: str, statement: nodes.Statement) -> None:
        """The scenario that the run is, is found by its name: nothing else may be called so."""
        first = next((each.name_span for each in self.scenarios if each.name == name), None)
        if first is not None and not is_class(statement):
            self.findings.add(duplicate("the name", name, statement.span, first))

    def _report_doubles(self) -> None:
        maps = [s for s in self.module.statements if isinstance(s, nodes.Map)]
        for second in maps[1:]:
            self.findings.add(MAP_TWICE.at(second.span, secondary=(Label(maps[0].span, "first here"),)))
        seen: dict[tuple[str, str], Span] = {}
        named = [("the param", e.name, e.name_span) for e in all_params(self.module)]
        named += [("the behavior", b.name, b.name_span) for b in self.behaviours]
        named += [("the monitor", b.name, b.name_span) for b in self.monitors]
        named += [("the scenario", b.name, b.name_span) for b in self.scenarios]
        named += [("the class", s.name, s.name_span) for s in self.module.statements if is_class(s)]
        for what, name, span in named:
            key = (what if what == "the param" else "a definition", name)
            if key in seen:
                self.findings.add(duplicate(what, name, span, seen[key]))
            seen.setdefault(key, span)

    # -- afterwards --------------------------------------------------------------------------------------------------

    def report_unused(self) -> None:
        for behaviour in self.behaviours:
            if behaviour.name not in self.table.used:
                self.findings.add(UNUSED_BEHAVIOUR.at(behaviour.name_span, name=behaviour.name))
        for monitor in self.monitors:
            if monitor.name not in self.table.used:
                self.findings.add(UNUSED_MONITOR.at(monitor.name_span, name=monitor.name))
        for entry in param_entries(self.module).values():
            if entry.name not in self.table.used and is_searched(entry.value):
                self.findings.add(UNUSED_GENE.at(entry.name_span, name=entry.name))

"""Names before values: every name of the file is looked up once, behaviours that nothing runs included.

The top level is read in order, so a name must be assigned above its use. Definitions and `terminate when` see all names
of the file, because they run after it. In a definition, a name that is assigned anywhere in it is its own.
"""

from collections.abc import Iterable, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, replace

from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.semantics.errors.names import (
    SELF_AS_PARAMETER,
    TEMPORAL_PLACE,
    UNKNOWN_NAME,
    UNKNOWN_PARAM,
    UNUSED_BEHAVIOUR,
    UNUSED_GENE,
    USED_BEFORE,
)
from cortex_dsl.semantics.errors.problems import Findings
from cortex_dsl.semantics.errors.runs import UNUSED_MONITOR
from cortex_dsl.semantics.errors.scene import MAP_TWICE, SELF_OUTSIDE
from cortex_dsl.semantics.errors.values import CANNOT_ASSIGN
from cortex_dsl.semantics.names.builtins import BUILTINS, SPECIAL_NAMES, UNASSIGNABLE, Kind, names_of
from cortex_dsl.semantics.names.linking import NO_FILES, ImportedFile, nameless
from cortex_dsl.semantics.names.placement import check_placement
from cortex_dsl.semantics.names.tree import (
    TIMED,
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
from cortex_dsl.spelling import class_called, did_you_mean, likely_range, nearest
from cortex_dsl.syntax import nodes
from engine.frozen import frozen

# -- names of one expression -------------------------------------------------------------------------------------------


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

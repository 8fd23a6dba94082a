"""Names before values: every name of the file is looked up once, behaviours that nothing runs included.

The top level is read in order, so a name must be assigned above its use. Behaviours and `terminate when` see all names
of the file, because they run after it. In a behaviour, a name that is assigned anywhere in it is its own.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import PurePath

from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.semantics import errors
from cortex_dsl.semantics.composition.imports import NO_FILES, ImportedFile, bound_name
from cortex_dsl.semantics.findings import Findings
from cortex_dsl.semantics.names.binding import Definition, bound_by, duplicate, is_class, looked_at
from cortex_dsl.semantics.names.bodies import BodyNames
from cortex_dsl.semantics.names.looking_up import Names, NameTable
from cortex_dsl.semantics.names.overrides import param_entries
from cortex_dsl.semantics.names.placement import check_placement
from cortex_dsl.semantics.names.system import lists_names
from cortex_dsl.semantics.running.rules import speaks_of_run
from cortex_dsl.semantics.tree import parts
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes

Imports = Mapping[Span, ImportedFile]
SEARCHED = ("Range", "TruncatedNormal", "DiscreteRange", "VerifaiRange", "VerifaiDiscreteRange", "VerifaiOptions")
"""Distributions that make a param a gene whatever their arguments are."""


def check_names(module: nodes.Module, findings: Findings, imports: Imports = NO_FILES) -> None:
    """Report unknown, early, doubled and unused names, and statements in the wrong place, imported files included."""
    modules = dict.fromkeys(file.module for file in imports.values())
    params = {name: entry for each in (*modules, module) for name, entry in param_entries(each).items()}
    main, *others = (_Resolver(each, findings, imports, params) for each in (module, *modules))
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
    """Of all files."""
    known: set[str] = field(default_factory=set)
    """Names of the top level that have a value by now."""

    def __post_init__(self) -> None:
        self.behaviours = [s for s in self.module.statements if isinstance(s, nodes.BehaviorDefinition)]
        self.monitors = [s for s in self.module.statements if isinstance(s, nodes.MonitorDefinition)]
        self.scenarios = [s for s in self.module.statements if isinstance(s, nodes.ScenarioDefinition)]
        names = frozenset(name for s in self.module.statements for name in self.bound(s))
        self.table = NameTable(self.findings, self.params, names)
        self.known = {b.name for b in (*self.behaviours, *self.monitors, *self.scenarios)}

    def bound(self, statement: nodes.Statement) -> tuple[str, ...]:
        """Names that a statement gives a value to; `from x import *` those of the file x."""
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
                    late.visit(part)
        for definition in (*self.behaviours, *self.monitors, *self.scenarios):
            BodyNames(self.table, definition).check()

    def _statement(self, statement: nodes.Statement) -> None:
        if isinstance(statement, Definition) or speaks_of_run(statement):
            return
        names = Names(self.table, self.known, frozenset(), in_behaviour=isinstance(statement, nodes.ClassDefinition))
        if isinstance(statement, nodes.Import) and bound_name(statement) is None:
            self.findings.add(_nameless(statement))
        if isinstance(statement, nodes.AugmentedAssign):
            names.use(statement.target, statement.span)
        for part in parts(statement):
            if not lists_names(statement, part):
                names.visit(part)
        for name in self.bound(statement):
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
            self.findings.add(errors.MAP_TWICE.at(second.span, secondary=(Label(maps[0].span, "first here"),)))
        seen: dict[tuple[str, str], Span] = {}
        entries = [e for s in self.module.statements if isinstance(s, nodes.Param) for e in s.entries]
        named = [("the param", e.name, e.name_span) for e in entries]
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
                self.findings.add(errors.UNUSED_BEHAVIOUR.at(behaviour.name_span, name=behaviour.name))
        for monitor in self.monitors:
            if monitor.name not in self.table.used:
                self.findings.add(errors.UNUSED_MONITOR.at(monitor.name_span, name=monitor.name))
        for entry in param_entries(self.module).values():
            if entry.name not in self.table.used and _is_searched(entry.value):
                self.findings.add(errors.UNUSED_GENE.at(entry.name_span, name=entry.name))


def _nameless(node: nodes.Import) -> Diagnostic:
    path = f'"{node.path}"' if node.quoted else node.path
    name = re.sub(r"\W", "_", PurePath(node.path).stem) if node.quoted else node.path.rpartition(".")[2]
    return errors.NAMELESS_IMPORT.at(node.path_span, path=node.path, statement=f"import {path}", name=name)


def _is_searched(value: nodes.Expression) -> bool:
    if isinstance(value, nodes.WithUnit | nodes.Degrees):
        value = value.value
    return isinstance(value, nodes.Call) and isinstance(value.function, nodes.Name) and value.function.id in SEARCHED

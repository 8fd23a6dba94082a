"""Facts of the syntax tree alone: parts, bound names, moments of a condition, params of the system under test."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from functools import cache
from pathlib import PurePath
from typing import TypeGuard
from weakref import finalize

from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.semantics.errors.names import DUPLICATE, NO_SYSTEM_PARAM
from cortex_dsl.semantics.errors.problems import Findings
from cortex_dsl.semantics.names.builtins import OVER_RUN
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes


def parts(node: nodes.Node) -> list[nodes.Node]:
    """The nodes directly inside a node, in the order of the text."""
    found: list[nodes.Node] = []
    own = vars(node)
    for name in _fields_with_nodes(node.__class__):
        value = own[name]
        if isinstance(value, nodes.Node):
            found.append(value)
        elif isinstance(value, tuple) and value:
            found.extend(_nodes_among(value))
    return found


_LEAVES = (Span, Span | None, str, str | None, tuple[str, ...], bool, bool | None, float)
"""Types of fields that hold no nodes."""


@cache
def _fields_with_nodes(kind: type[nodes.Node]) -> tuple[str, ...]:
    """Return the names of the fields of a class that may hold nodes."""
    return tuple(each.name for each in fields(kind) if each.type not in _LEAVES)  # type: ignore[arg-type]


def everything_in(node: nodes.Node) -> Iterator[nodes.Node]:
    """All nodes below a node. Those of a file, which many look through, are found once."""
    if not isinstance(node, nodes.Module):
        return _below(node)
    if (known := _OF_FILES.get(id(node))) is None:
        known = _OF_FILES[id(node)] = tuple(_below(node))
        finalize(node, _OF_FILES.pop, id(node), None)
    return iter(known)


_OF_FILES: dict[int, tuple[nodes.Node, ...]] = {}
"""Nodes of each file by its identity, since trees are equal by contents; an entry is removed with its file, before the
identity can be reused."""


def _below(node: nodes.Node) -> Iterator[nodes.Node]:
    waiting = parts(node)[::-1]
    while waiting:
        part = waiting.pop()
        yield part
        if inner := parts(part):
            waiting.extend(inner[::-1])


def _nodes_among(values: tuple[object, ...]) -> Iterator[nodes.Node]:
    for value in values:
        if isinstance(value, nodes.Node):
            yield value
        elif isinstance(value, tuple):
            yield from _nodes_among(value)


def attributes_read(module: nodes.Module) -> frozenset[str]:
    """Every name behind a dot."""
    return frozenset(node.name for node in everything_in(module) if isinstance(node, nodes.Attribute))


WARNINGS = ("isWarning", "timeSinceWarning", "warningTTC")
"""Attributes of an object that say what its driver warns of."""
BRAKES_AFTER_WARNING = "ManualBrakeBehavior"


def reads_warnings(module: nodes.Module) -> bool:
    """Return True if a file reads warnings of a driver, or has somebody who brakes after one."""
    return any(
        (isinstance(node, nodes.Attribute) and node.name in WARNINGS)
        or (isinstance(node, nodes.Name) and node.id == BRAKES_AFTER_WARNING)
        for node in everything_in(module)
    )


def attributes_set(module: nodes.Module) -> frozenset[str]:
    """Every attribute that a behaviour or a monitor assigns."""
    return frozenset(node.target.name for node in everything_in(module) if isinstance(node, nodes.SetAttribute))


def _behaviours(module: nodes.Module) -> Iterator[nodes.BehaviorDefinition]:
    return (node for node in everything_in(module) if isinstance(node, nodes.BehaviorDefinition))


def lets_appear(module: nodes.Module) -> bool:
    """Return True if a behaviour makes an object or a place."""
    return any(isinstance(node, nodes.New) for each in _behaviours(module) for node in everything_in(each))


OPENS_DOOR = "OpenDoorAction"


def door_openers(module: nodes.Module) -> frozenset[str]:
    """Return every behaviour that opens a door, or names a behaviour that does."""
    if not any(isinstance(node, nodes.Name) and node.id == OPENS_DOOR for node in everything_in(module)):
        return frozenset()
    named = {
        each.name: {node.id for node in everything_in(each) if isinstance(node, nodes.Name)}
        for each in _behaviours(module)
    }
    found: set[str] = set()
    while more := {name for name, ids in named.items() if ids & {OPENS_DOOR, *found}} - found:
        found |= more
    return frozenset(found)


def door_sides(module: nodes.Module) -> frozenset[str]:
    """Return the sides of the doors that a file opens; both where a side is no text."""
    calls = (node for node in everything_in(module) if isinstance(node, nodes.Call))
    found: set[str] = set()
    for call in calls:
        if isinstance(call.function, nodes.Name) and call.function.id == OPENS_DOOR:
            side = next((each.value for each in call.arguments if each.name in (None, "side")), None)
            found |= {side.value} if isinstance(side, nodes.String) else {"left", "right"}
    return frozenset(found)


# -- the shape of conditions -------------------------------------------------------------------------------------------

TIMED = ("always", "eventually", "next", "until")
"""Operators that speak of more than one moment."""


def subformulas(node: nodes.Expression) -> tuple[nodes.Expression, ...]:
    """Return the operands of a logical operator; () for any other expression."""
    match node:
        case nodes.Temporal(operands=operands) | nodes.BoolOp(operands=operands):
            return operands
        case nodes.Unary(operator="not", operand=operand):
            return (operand,)
    return ()


def is_timed(node: nodes.Expression) -> bool:
    """Return whether a condition concerns more than one moment."""
    return (isinstance(node, nodes.Temporal) and node.operator in TIMED) or any(map(is_timed, subformulas(node)))


def atoms(node: nodes.Expression) -> Iterator[nodes.Expression]:
    """The largest parts of a condition that speak of one moment."""
    if is_timed(node):
        for part in subformulas(node):
            yield from atoms(part)
    else:
        yield node


def always_condition(node: nodes.Expression) -> nodes.Expression | None:
    """The condition of an `always`, where it speaks of one moment."""
    match node:
        case nodes.Temporal(operator="always", operands=(condition,)) if not is_timed(condition):
            return condition
    return None


# -- parts of one node -------------------------------------------------------------------------------------------------


def bound_name(node: nodes.Import) -> str | None:
    """The name that an import gives a value to; None where its path has none to offer."""
    name = node.alias or (PurePath(node.path).stem if node.quoted else node.path)
    return name if name.isidentifier() else None


def all_params(module: nodes.Module) -> Iterator[nodes.ParamEntry]:
    """The params of a file, those of its scenarios included."""
    for statement in module.statements:
        setup = statement.setup if isinstance(statement, nodes.ScenarioDefinition) else ()
        for each in (statement, *setup):
            yield from each.entries if isinstance(each, nodes.Param) else ()


def param_entries(module: nodes.Module) -> dict[str, nodes.ParamEntry]:
    """All params of a file by name."""
    return {entry.name: entry for entry in all_params(module)}


def scenic_model(module: nodes.Module) -> nodes.Model | None:
    """The line by which a file says that it is a script of Scenic."""
    return next((statement for statement in module.statements if isinstance(statement, nodes.Model)), None)


def unit_word(node: nodes.Expression) -> str | None:
    """The unit in which a param is written."""
    match node:
        case nodes.WithUnit(unit=word) | nodes.Number(unit=word):
            return word
        case nodes.Degrees():
            return "deg"
        case nodes.Unary(operand=operand):
            return unit_word(operand)
        case nodes.Call(arguments=(first, *_)):
            return unit_word(first.value)
    return None


SEARCHED = ("Range", "TruncatedNormal", "DiscreteRange", "VerifaiRange", "VerifaiDiscreteRange", "VerifaiOptions")
"""Distributions that make a param a gene whatever their arguments are."""


def is_searched(value: nodes.Expression) -> bool:
    """Return whether the value of a param makes it a gene."""
    if isinstance(value, nodes.WithUnit | nodes.Degrees):
        value = value.value
    return isinstance(value, nodes.Call) and isinstance(value.function, nodes.Name) and value.function.id in SEARCHED


# -- bindings of statements, and parts of definitions ------------------------------------------------------------------

Definition = nodes.BehaviorDefinition | nodes.MonitorDefinition | nodes.ScenarioDefinition | nodes.FunctionDefinition


def bound_by(statement: nodes.Statement) -> tuple[str, ...]:
    """Names that a top-level statement gives a value to."""
    match statement:
        case nodes.Assign(targets=targets):
            return targets
        case nodes.AugmentedAssign(target=target):
            return (target,)
        case nodes.Param(entries=entries):
            return tuple(entry.name for entry in entries if entry.name != "map")
        case nodes.BehaviorDefinition(name=name) | nodes.MonitorDefinition(name=name):
            return (name,)
        case nodes.ScenarioDefinition(name=name) | nodes.ClassDefinition(name=name):
            return (name,)
        case nodes.FunctionDefinition(name=name):
            return (name,)
        case nodes.For(targets=targets):
            return targets
        case nodes.Import() if (alias := bound_name(statement)) is not None:
            return (alias,)
        case nodes.ImportFrom(names=names):
            return tuple(each.alias or each.name for each in names)
    return ()


def assigned(statements: tuple[nodes.Statement, ...]) -> Iterator[str]:
    """Yield the names that a body assigns, including nested blocks but not nested definitions."""
    for statement in statements:
        yield from bound_by(statement)
        for part in () if isinstance(statement, Definition) else parts(statement):
            if isinstance(part, nodes.Statement):
                yield from assigned((part,))
            elif isinstance(part, nodes.Handler):
                yield from assigned(part.body)


def assigned_names(statements: Sequence[nodes.Statement], *, repeated: bool) -> Iterator[str]:
    """Every assignment's names; twice where it may run again."""
    for statement in statements:
        match statement:
            case nodes.Assign(targets=targets):
                yield from targets * (2 if repeated else 1)
            case nodes.AugmentedAssign(target=target):
                yield from (target, target)
            case nodes.If(branches=branches, otherwise=otherwise):
                for _, body in branches:
                    yield from assigned_names(body, repeated=True)
                yield from assigned_names(otherwise, repeated=True)
            case nodes.While(body=body):
                yield from assigned_names(body, repeated=True)
            case nodes.For(targets=targets, body=body):
                yield from targets * 2
                yield from assigned_names(body, repeated=True)
            case nodes.Try(body=body, handlers=handlers):
                yield from assigned_names(body, repeated=True)
                for handler in handlers:
                    yield from assigned_names(handler.body, repeated=True)


def body_of(definition: Definition) -> tuple[nodes.Statement, ...]:
    """The statements of a definition; those of a setup come before those of its `compose`."""
    if isinstance(definition, nodes.ScenarioDefinition):
        return (*definition.setup, *definition.compose)
    return definition.body


def looked_at(statement: nodes.Statement) -> Iterator[nodes.Expression]:
    """Yield the expressions of a statement that are evaluated in every sample."""
    match statement:
        case nodes.Require(condition=condition) | nodes.Expect(condition=condition):
            yield from atoms(condition)
        case nodes.TerminateWhen(condition=condition):
            yield condition
        case nodes.Record(value=value) | nodes.Optimize(value=value) | nodes.Domain(value=value):
            yield value


def names_in(statement: nodes.Statement) -> tuple[str, ...]:
    """Names that mean something in a statement alone: where runs are judged, `self` is the ego."""
    match statement:
        case nodes.Expect():
            return ("self",)
        case nodes.Optimize():
            return ("self", *OVER_RUN)
    return ()


def speaks_of_run(statement: nodes.Statement) -> bool:
    """Return whether a statement concerns the running simulation, so that it is evaluated after all objects exist."""
    if isinstance(statement, nodes.Require):
        return is_timed(statement.condition)
    return isinstance(statement, nodes.TerminateWhen | nodes.Record | nodes.Expect | nodes.Optimize | nodes.Domain)


def is_class(statement: nodes.Statement) -> TypeGuard[nodes.ClassDefinition]:
    return isinstance(statement, nodes.ClassDefinition)


def duplicate(what: str, name: str, span: Span, first: Span) -> Diagnostic:
    return DUPLICATE.at(span, what=what, name=name, secondary=(Label(first, "first here"),))


# -- `simulation(system=[EGO_BRAKE, SAFETY_DIST])`: the params of the system under test --------------------------------
# A search that may choose them can win by switching the brakes off; `--freeze` holds them fixed. The list holds names
# and nothing else, wherever in the file their params stand, so it is read from the tree and never evaluated.

SYSTEM = "system"


def system_params(module: nodes.Module, params: Mapping[str, nodes.ParamEntry], findings: Findings) -> tuple[str, ...]:
    """Return the names that the file lists, each once, in the order of the list; report names that are no params."""
    names: list[str] = []
    for node in _listed(module):
        if not isinstance(node, nodes.Name) or node.id not in params:
            actual = node.id if isinstance(node, nodes.Name) else "this"
            suggestion = did_you_mean(actual, params) or "list names of params, as in `system=[EGO_BRAKE]`"
            findings.add(NO_SYSTEM_PARAM.at(node.span, actual=actual, suggestion=suggestion))
        elif node.id not in names:
            names.append(node.id)
    return tuple(names)


def lists_names(statement: nodes.Statement, part: nodes.Node) -> bool:
    """Return whether a part of a statement is the list of params of the system under test."""
    return isinstance(statement, nodes.Simulation) and isinstance(part, nodes.Argument) and part.name == SYSTEM


def _listed(module: nodes.Module) -> Iterator[nodes.Expression]:
    """Yield the items of the lists of names."""
    for statement in module.statements:
        if isinstance(statement, nodes.Simulation):
            for argument in statement.arguments:
                if lists_names(statement, argument):
                    value = argument.value
                    listed = isinstance(value, nodes.ListDisplay | nodes.TupleDisplay)
                    yield from value.items if listed else (value,)

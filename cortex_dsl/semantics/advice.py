"""Advice on a file that compiles, given after all variants are known.

It covers params, requirements, names and definitions without effect, names that hide built-in names, and
numbers, windows and conditions that have a better form.

A comment `# allow SCN481` anywhere in a file suppresses every warning, note and hint of that code.

A gene is alive if an object's property, a requirement, a rule, a monitor or a reachable act depends on it, or on a
choice that it makes; a search varies all other genes without effect. An operation whose interval is a single number
depends on nothing.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from itertools import pairwise
from types import MappingProxyType

from cortex_dsl import ir
from cortex_dsl.diagnostics import Diagnostic, Label, Severity
from cortex_dsl.semantics.errors.names import (
    ALWAYS_TRUE,
    CONTACT_UNSEEN,
    DEAD_GENE,
    SHADOWS,
    UNREAD_PROPERTY,
    UNUSED_CLASS,
    UNUSED_NAME,
    UNUSED_SCENARIO,
    WINDOW,
)
from cortex_dsl.semantics.errors.values import BARE_BESIDE_UNIT
from cortex_dsl.semantics.model.state import FileContext
from cortex_dsl.semantics.names.builtins import BUILTINS
from cortex_dsl.semantics.names.properties import IGNORED
from cortex_dsl.semantics.names.tree import everything_in, param_entries
from cortex_dsl.semantics.quantities.bounds import Interval, folded, part_interval
from cortex_dsl.semantics.quantities.units import UNITS, Unit, si_word
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import nodes
from engine.config import SimulationConfig
from engine.frozen import frozen
from engine.opcodes import Op

# -- params that influence anything ------------------------------------------------------------------------------------

NOTHING: frozenset[ir.Expr] = frozenset()
ENDLESS = (ir.Terminate, ir.Leave, ir.Abort, ir.HoldSpeed)
"""Acts after which the next of their block is never reached."""


def live_genes(scenario: ir.Scenario, bounds: Mapping[int, Interval]) -> set[int]:
    """Indices of the genes that matter; `bounds` are their SI bounds."""
    live: set[int] = set()
    for variant in scenario.variants:
        live.update(gene for gene, _ in variant.gene_options)
        if variant.rejection is None and len(live) < len(scenario.genes):
            live |= _Walk(bounds).over(variant)
    return live


@dataclass
class _Walk:
    """Collects the reachable parts of one variant."""

    bounds: Mapping[int, Interval]
    genes: set[int] = field(default_factory=set)
    locals: set[int] = field(default_factory=set)
    assigned: dict[int, list[ir.Expr]] = field(default_factory=dict)
    """Values of locals that nothing is known to read yet."""
    seen: set[ir.Expr] = field(default_factory=set)

    def over(self, variant: ir.Variant) -> set[int]:
        for root in (
            variant.actors,
            [r.condition for r in variant.requirements],
            variant.rules,
            variant.objectives,
            variant.monitors,
        ):
            self.visit(root)
        return self.genes

    def visit(self, node: object) -> None:
        """Visit all nodes below a node of the IR."""
        match node:
            case ir.Expr():
                self._expression(node)
            case ir.SetLocal(index=index, value=value):
                self._assignment(index, value)
            case ir.Branch(condition=condition, then=then, otherwise=otherwise):
                self.visit(condition)
                for block in self._taken(condition, then, otherwise):
                    self._block(block)
            case ir.Loop(condition=condition, body=body):
                self.visit(condition)
                for block in self._taken(condition, body, ()):
                    self._block(block)
            case ir.TryInterrupt(body=body, handlers=handlers):
                self._block(body)
                for condition, block in handlers:
                    self.visit(ir.Branch(node.span, condition, block, ()))
            case tuple() | list():
                self._block(node)
            case _ if is_dataclass(node) and not isinstance(node, type):
                for part in fields(node):
                    self.visit(getattr(node, part.name))

    def _block(self, acts: Iterable[object]) -> None:
        for act in acts:
            self.visit(act)
            if isinstance(act, ENDLESS) or (isinstance(act, ir.Loop) and self._never_left(act)):
                return

    def _taken(self, condition: ir.Expr, then: ir.Block, otherwise: ir.Block) -> Iterator[ir.Block]:
        low, high = self._worth(condition)[0]
        if (low, high) != (0.0, 0.0):
            yield then
        if not (low > 0.0 or high < 0.0):
            yield otherwise

    def _never_left(self, loop: ir.Loop) -> bool:
        return self._worth(loop.condition)[0][0] > 0.0 and not _breaks(loop.body)

    # -- expressions -------------------------------------------------------------------------------------------------

    def _expression(self, expression: ir.Expr) -> None:
        if expression in self.seen:
            return
        self.seen.add(expression)
        for leaf in self._worth(expression)[1]:
            if isinstance(leaf, ir.Gene):
                self.genes.add(leaf.index)
            elif isinstance(leaf, ir.Local) and leaf.index not in self.locals:
                self.locals.add(leaf.index)
                for value in self.assigned.pop(leaf.index, []):
                    self._expression(value)

    def _assignment(self, index: int, value: ir.Expr) -> None:
        if index in self.locals:
            self._expression(value)
        else:
            self.assigned.setdefault(index, []).append(value)

    def _worth(self, expression: ir.Expr) -> tuple[Interval, frozenset[ir.Expr]]:
        """Return the interval of a value, and the genes and locals that it depends on."""
        return folded(expression, self._part)

    def _part(
        self, part: ir.Expr, known: list[tuple[Interval, frozenset[ir.Expr]]]
    ) -> tuple[Interval, frozenset[ir.Expr]]:
        if isinstance(part, ir.Gene | ir.Local):
            return part_interval(part, (), self.bounds), frozenset({part})
        within = part_interval(part, [each for each, _ in known], self.bounds)
        if within[0] == within[1]:
            return within, NOTHING
        if isinstance(part, ir.Apply) and part.op == Op.SELECT and known[0][0] in ((0.0, 0.0), (1.0, 1.0)):
            return known[1] if known[0][0] == (1.0, 1.0) else known[2]
        return within, frozenset().union(*(leaves for _, leaves in known))


def _breaks(node: object) -> bool:
    """Return whether a block leaves its loop; a `break` of an inner loop counts too, to be on the safe side."""
    if isinstance(node, ir.Leave):
        return node.kind == "break"
    if isinstance(node, tuple):
        return any(map(_breaks, node))
    return isinstance(node, ir.Act) and any(_breaks(getattr(node, part.name)) for part in fields(node))


# -- names and definitions that nothing reads --------------------------------------------------------------------------

MEANT = frozenset({"intersection", "road", "network"})
"""Built-in names that a message asks a file to assign: `intersection = Uniform(*network.intersections)`."""
Binding = tuple[str, str, Span]
"""Kind of the binding, its name, its place."""


SETTLING = ("ego", "workspace")
"""Names that mean something as they are."""


def unused_names(module: nodes.Module) -> Iterator[Diagnostic]:
    """A hint for each name that is never read; objects exist without being named again."""
    read = _names_read(module)
    yield from _unread(_single_names(module.statements), read)
    for behaviour in module.statements:
        if isinstance(behaviour, nodes.BehaviorDefinition):
            yield from _unread(
                (*_arguments(behaviour), *_single_names(everything_in(behaviour))), _names_read(behaviour)
            )


def unused_definitions(module: nodes.Module, entry: nodes.ScenarioDefinition | None) -> Iterator[Diagnostic]:
    """Yield diagnostics for classes without objects, and for scenarios that the entry scenario does not start."""
    read = _names_read(module) | {node.class_name for node in everything_in(module) if isinstance(node, nodes.New)}
    bases = {s.base for s in module.statements if isinstance(s, nodes.ClassDefinition)}
    for statement in module.statements:
        match statement:
            case nodes.ClassDefinition(name=name) if name not in read | bases:
                yield UNUSED_CLASS.at(statement.name_span, name=name)
            case nodes.ScenarioDefinition(name=name) if entry is not None and name not in read | {entry.name}:
                yield UNUSED_SCENARIO.at(statement.name_span, name=name, entry=entry.name)


def _unread(bindings: Iterable[Binding], read: set[str]) -> Iterator[Diagnostic]:
    for what, name, span in bindings:
        if name not in read and name not in SETTLING and not name.startswith("_"):
            yield UNUSED_NAME.at(span, what=what, name=name)


def _names_read(tree: nodes.Node) -> set[str]:
    return {node.id for node in everything_in(tree) if isinstance(node, nodes.Name)}


def _single_names(statements: Iterable[nodes.Node]) -> Iterator[Binding]:
    """Single names: of several at once, some are there for their places."""
    for statement in statements:
        if isinstance(statement, nodes.Assign) and len(statement.targets) == 1 and not _makes_objects(statement.value):
            yield "name", statement.targets[0], _name_span(statement)


def _makes_objects(value: nodes.Expression) -> bool:
    return any(isinstance(node, nodes.New) for node in (value, *everything_in(value)))


def _arguments(behaviour: nodes.BehaviorDefinition) -> Iterator[Binding]:
    for parameter in behaviour.parameters:
        yield "argument", parameter.name, parameter.span


def _name_span(statement: nodes.Assign) -> Span:
    return Span(statement.span.start, statement.span.start + len(statement.targets[0]))


def shadowing_names(module: nodes.Module) -> Iterator[Diagnostic]:
    """A hint for each name of something built in that the file gives another meaning."""
    for name, span in _top_level(module):
        if name in BUILTINS and name not in MEANT:
            yield SHADOWS.at(span, name=name, kind=BUILTINS[name].kind.value)


def _top_level(module: nodes.Module) -> Iterator[tuple[str, Span]]:
    for statement in module.statements:
        match statement:
            case nodes.Assign(targets=(name,)):
                yield name, _name_span(statement)
            case nodes.BehaviorDefinition(name=name) | nodes.ClassDefinition(name=name):
                yield name, statement.name_span
            case nodes.Param(entries=entries):
                yield from ((entry.name, entry.name_span) for entry in entries if entry.name != "map")


def unread_properties(module: nodes.Module) -> Iterator[Diagnostic]:
    """Yield one note for all properties without effect, at the first of them."""
    places: dict[str, list[Span]] = {}
    for node in everything_in(module):
        match node:
            case nodes.With(property=name, property_span=span) | nodes.PropertyDefault(name=name, name_span=span):
                places.setdefault(name, []).append(span)
    if found := [name for name in IGNORED if name in places]:
        first = {min(places[name], key=lambda span: span.start): f"`{name}` has no effect" for name in found}
        labels = [Label(span, first[span]) for span in sorted(first, key=lambda span: span.start)]
        yield UNREAD_PROPERTY.at(
            labels[0].span,
            names=", ".join(f"`{name}` ({len(places[name])})" for name in found),
            reason="; ".join(dict.fromkeys(IGNORED[name] for name in found)),
            secondary=tuple(labels[1:]),
        )


# -- the advice --------------------------------------------------------------------------------------------------------

_ALLOWED = re.compile(r"#[ \t]*allow[ \t]+(SCN\d+(?:[ \t,]+SCN\d+)*)")
MOST_USES = 3
"""Places of use that a dead param shows."""


def with_advice(
    module: nodes.Module, file: FileContext, scenario: ir.Scenario
) -> tuple[ir.Scenario, tuple[Diagnostic, ...]]:
    """Return the scenario with all advice about it."""
    for diagnostic in () if file.is_pinned else _advice(module, file, scenario):
        file.findings.add(diagnostic)
    allowed = {code for match in _ALLOWED.finditer(file.facts.source.text) for code in re.findall(r"SCN\d+", match[1])}
    return scenario, tuple(d for d in file.findings if d.severity is Severity.ERROR or d.code not in allowed)


def _advice(module: nodes.Module, file: FileContext, scenario: ir.Scenario) -> Iterator[Diagnostic]:
    yield from _dead(module, file, scenario)
    yield from _certain(file)
    yield from bare_numbers(module, file.genes.infos)
    yield from windows(module, file.facts.source)
    yield from contacts(module, file.settings.given.time_step)
    yield from unread_properties(module)
    yield from unused_names(module)
    yield from unused_definitions(module, file.facts.entry)
    yield from shadowing_names(module)


def _dead(module: nodes.Module, file: FileContext, scenario: ir.Scenario) -> Iterator[Diagnostic]:
    """Params that are used, but in no place that matters; a `require` that always holds is reported anyway."""
    live = live_genes(scenario, file.genes.bounds)
    decided = [span for span, weight in file.scene.weights.items() if weight.certain]
    dead = [gene for index, gene in enumerate(scenario.genes) if index not in live]
    used = _uses(module) if dead else {}
    for gene in dead:
        uses = used.get(gene.name, [])
        if any(not any(span.start <= use.start < span.end for span in decided) for use in uses):
            labels = tuple(Label(use, "used here, without effect") for use in uses[:MOST_USES])
            entry = param_entries(module).get(gene.name)
            place = gene.span if entry is None else entry.name_span
            yield DEAD_GENE.at(place, name=gene.name, secondary=labels)


def _uses(module: nodes.Module) -> dict[str, list[Span]]:
    """Return the places of each name, including params after `globalParameters`."""
    found: dict[str, list[Span]] = {}
    for node in everything_in(module):
        if isinstance(node, nodes.Name):
            found.setdefault(node.id, []).append(node.span)
        elif isinstance(node, nodes.Attribute) and _is_params(node.value):
            found.setdefault(node.name, []).append(node.span)
    return found


def _is_params(node: nodes.Expression) -> bool:
    return isinstance(node, nodes.Name) and node.id == "globalParameters"


def _certain(file: FileContext) -> Iterator[Diagnostic]:
    for span, weight in file.scene.weights.items():
        if weight.certain:
            yield ALWAYS_TRUE.at(span, secondary=weight.labels(file.genes.infos))


# -- numbers, windows and contacts that look unintended ----------------------------------------------------------------


SUMS = ("+", "-")
THROUGH = ("abs", "min", "max")
"""Functions with a result in the unit of their arguments."""


def bare_numbers(module: nodes.Module, genes: Iterable[ir.GeneInfo]) -> Iterator[Diagnostic]:
    params = {gene.name: gene for gene in genes}
    for node in everything_in(module):
        for one, other in _pairs(node):
            for bare, partner in ((one, other), (other, one)):
                number = _bare(bare)
                written = next(_units(partner, params), None)
                if number and written is not None:
                    yield _in_other_unit(bare.span, number, *written)


def _pairs(node: nodes.Node) -> Iterator[tuple[nodes.Expression, nodes.Expression]]:
    """Yield the pairs of operands of a sum or comparison."""
    if isinstance(node, nodes.Binary) and node.operator in SUMS:
        yield node.left, node.right
    if isinstance(node, nodes.Compare):
        sides = [node.first, *(side for _, side in node.rest)]
        yield from pairwise(sides)


def _bare(node: nodes.Expression) -> float | None:
    """The number, where nothing but one without a unit is written; 0 is 0 in every unit."""
    if isinstance(node, nodes.Unary) and node.operator in SUMS:
        number = _bare(node.operand)
        return None if number is None else -number if node.operator == "-" else number
    return node.value if isinstance(node, nodes.Number) and node.unit is None else None


def _units(node: nodes.Expression, genes: Mapping[str, ir.GeneInfo]) -> Iterator[tuple[Unit, Span]]:
    """Yield the units other than SI in the operands of an expression, each with its place."""
    match node:
        case nodes.Number(unit=str(word)) | nodes.WithUnit(unit=word):
            unit = UNITS.get(word)
        case nodes.Name(id=name) | nodes.Attribute(name=name) if name in genes:
            unit = UNITS.get(genes[name].unit)
        case _:
            unit = None
            for part in _summands(node):
                yield from _units(part, genes)
    if unit is not None and unit.factor != 1.0:
        yield unit, node.span


def _summands(node: nodes.Expression) -> Iterator[nodes.Expression]:
    match node:
        case nodes.Binary(operator=operator, left=left, right=right) if operator in SUMS:
            yield from (left, right)
        case nodes.Unary(operand=operand):
            yield operand
        case nodes.Call(function=nodes.Name(id=name), arguments=arguments) if name in THROUGH:
            yield from (argument.value for argument in arguments)


def _in_other_unit(span: Span, value: float, unit: Unit, place: Span) -> Diagnostic:
    return BARE_BESIDE_UNIT.at(
        span,
        secondary=(Label(place, f"in {unit.word}"),),
        value=value,
        si=si_word(unit.dimension),
        unit=unit.word,
        converted=value / unit.factor,
    )


# -- distances of two that can touch -----------------------------------------------------------------------------------

FASTEST = 60.0
"""Nothing here closes faster [m/s]."""
LONGEST = 5.0
"""Centres of two cars that touch are no further apart [m]."""
_SEEN_FROM: Mapping[str, str] = MappingProxyType({">": "left", ">=": "left", "<": "right", "<=": "right"})
"""Side of each comparison sign at which a distance is kept large."""


def contacts(module: nodes.Module, time_step: float | None) -> Iterator[Diagnostic]:
    """A warning for each such distance that contact can pass by."""
    step = time_step or SimulationConfig().time_step
    things = _objects(module)
    required = (
        node for owner in everything_in(module) if isinstance(owner, nodes.Require) for node in everything_in(owner)
    )
    for node in required:
        if isinstance(node, nodes.Temporal) and node.operator == "always":
            for part in everything_in(node):
                if isinstance(part, nodes.Compare) and (found := _kept_apart(part)) is not None:
                    yield from _unseen_contact(part, *found, things, step)


def _objects(module: nodes.Module) -> frozenset[str]:
    """Return the names of objects that can be struck."""
    return frozenset(
        name
        for node in everything_in(module)
        if isinstance(node, nodes.Assign) and isinstance(node.value, nodes.New)
        if node.value.class_name not in ("Point", "OrientedPoint")
        for name in node.targets
    )


def _kept_apart(node: nodes.Compare) -> tuple[nodes.Distance, float] | None:
    """The distance, and the length that it must exceed [m]."""
    if len(node.rest) != 1:
        return None
    operator, other = node.rest[0]
    distance, limit = (node.first, other) if _SEEN_FROM.get(operator) == "left" else (other, node.first)
    if operator not in _SEEN_FROM or not isinstance(distance, nodes.Distance) or not isinstance(limit, nodes.Number):
        return None
    unit = UNITS.get(limit.unit or "m")
    return None if unit is None else (distance, limit.value * unit.factor)


def _unseen_contact(
    node: nodes.Compare, distance: nodes.Distance, limit: float, things: frozenset[str], step: float
) -> Iterator[Diagnostic]:
    origin, target = distance.origin or nodes.Name("ego", span=distance.span), distance.target
    if not (isinstance(origin, nodes.Name) and isinstance(target, nodes.Name) and {origin.id, target.id} <= things):
        return
    outlines = distance.between_outlines
    if limit >= (FASTEST * step if outlines else LONGEST):
        return
    speed = f"{limit / step * 3.6:.3g} km/h"
    yield CONTACT_UNSEEN.at(
        node.span,
        one=origin.id,
        other=target.id,
        reason=f"they close by {limit:g} m within one step at {speed}, and contact between two samples ends the run"
        if outlines
        else "it is the distance of centres, and outlines touch while those are further apart",
        cure=f"minimum distance from {origin.id} to {target.id}) > 0.1 m + {2 * step:.3g} s * "
        f"({origin.id}.speed + {target.id}.speed",
    )


# -- windows that are drawn and then required --------------------------------------------------------------------------


@frozen
class _Window:
    """`low <= distance from NAME to REGION <= high`."""

    name: str
    region: nodes.Expression
    distance: str
    """Distance to write after `by`."""


def windows(module: nodes.Module, source: Source) -> Iterator[Diagnostic]:
    """A hint for each such `require`."""
    made = {
        statement.targets[0]: statement.value
        for statement in module.statements
        if isinstance(statement, nodes.Assign) and len(statement.targets) == 1
        if isinstance(statement.value, nodes.New)
    }
    for statement in module.statements:
        if isinstance(statement, nodes.Require) and (window := _window(statement.condition, source)) is not None:
            specifier = _drawn_on_a_lane(window.name, made)
            if specifier is not None and isinstance(specifier.region, nodes.Attribute):
                lane = source.slice(specifier.region.value.span)
                region = source.slice(window.region.span)
                yield WINDOW.at(
                    statement.condition.span,
                    secondary=(Label(specifier.span, "drawn anywhere on the lane"),),
                    name=window.name,
                    kind=made[window.name].class_name,
                    place=f"before {region} by {window.distance} along [{lane}]",
                )


def _drawn_on_a_lane(name: str, made: Mapping[str, nodes.New]) -> nodes.InRegion | None:
    """Return the `in lane.centerline` that places an object, itself or through the point at which it is placed."""
    for specifier in made[name].specifiers if name in made else ():
        match specifier:
            case nodes.InRegion(region=nodes.Attribute(name="centerline")):
                return specifier
            case nodes.At(position=nodes.Name(id=point)) if point != name:
                return _drawn_on_a_lane(point, made)
    return None


def _window(condition: nodes.Expression, source: Source) -> _Window | None:
    match condition:
        case nodes.Compare(
            first=nodes.Call(function=nodes.Name(id="abs"), arguments=(argument,)), rest=((sign, width),)
        ):
            return _around(argument.value, width, source) if sign in ("<", "<=") else None
        case nodes.Compare(first=low, rest=((first, nodes.Distance() as distance), (second, high))):
            if {first, second} <= {"<", "<="}:
                return _from_to(distance, f"Range({source.slice(low.span)}, {source.slice(high.span)})")
    return None


def _around(difference: nodes.Expression, width: nodes.Expression, source: Source) -> _Window | None:
    """Return the window of `abs(distance - middle) <= width`; None for another form."""
    if not isinstance(difference, nodes.Binary) or difference.operator != "-":
        return None
    sides = (difference.left, difference.right)
    for distance, middle in (sides, sides[::-1]):
        if isinstance(distance, nodes.Distance):
            centre, half = source.slice(middle.span), source.slice(width.span)
            return _from_to(distance, f"{centre} + Range(-{half}, {half})")
    return None


def _from_to(distance: nodes.Distance, drawn: str) -> _Window | None:
    if distance.between_outlines or not isinstance(distance.target, nodes.Name):
        return None
    if distance.origin is None:
        return _Window("ego", distance.target, drawn)
    return _Window(distance.origin.id, distance.target, drawn) if isinstance(distance.origin, nodes.Name) else None

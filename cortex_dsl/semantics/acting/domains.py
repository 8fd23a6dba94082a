"""`domain`: cells of a value at the start, at first sight, at contact or at the end of a run, for coverage.

A domain changes no scene and no run. Compiled for coverage, its value becomes an objective, a reading at the instant;
or chosen cells become requirements on the scene, so that intervals can prove that no scene lies in them.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from cortex_dsl import ir
from cortex_dsl.diagnostics import Label
from cortex_dsl.semantics.errors.names import DUPLICATE
from cortex_dsl.semantics.errors.runs import (
    CELLS_OVERLAP,
    CELLS_UNKNOWN,
    DOMAIN_DRAWS,
    NO_CELLS,
    NOBODY_ELSE,
    NOT_ONE_LINE,
    SHORT_CELL,
)
from cortex_dsl.semantics.evaluation import numbers
from cortex_dsl.semantics.evaluation.over_run import judged
from cortex_dsl.semantics.model.context import Evaluator, Moment
from cortex_dsl.semantics.model.values import Quantity, Truth, Value
from cortex_dsl.semantics.model.wording import source_text, spoken_unit
from cortex_dsl.semantics.quantities.algebra import Term, equal, where
from cortex_dsl.semantics.quantities.bounds import closed_value
from cortex_dsl.semantics.quantities.units import PURE, UNITS, si_word
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.vocabulary import Reducer, RuleKind, Sense

SIGHT = "first sight"
"""Instant at which the ego first sees another actor; its value is read from the states over time."""
REDUCERS = {
    "start": Reducer.INITIAL,
    SIGHT: Reducer.FINAL,
    "contact": Reducer.CONTACT,
    "end": Reducer.FINAL,
}
"""Reading of each instant."""
OBJECTIVE = "domain "
"""Beginning of the name of the objective that a domain becomes, which is followed by its number."""
MOST_CELLS = 100_000
"""Maximum number of cells of one domain."""
DIGITS = 12
"""Significant digits of the ends of steps, so that a value at an end is in the cell that begins there."""


def domain(ev: Evaluator, node: nodes.Domain) -> None:
    """Check a domain, and give it the effect that the compilation asks for."""
    use = ev.facts.domains
    if use is None:
        return
    if not node.name.isprintable() or not node.name.strip():
        raise NOT_ONE_LINE.mistake(node.span, what="a domain", name=ascii(node.name)[1:-1])
    if node.when in ("contact", SIGHT) and len(ev.run.built.actors) < 2:
        raise NOBODY_ELSE.mistake(node.span, name=f"at {node.when}")
    decisions = ev.run.decisions
    drawn = decisions.draw_count, len(decisions.choices)
    scene = ev.at_moment(Moment(scenario=ev.moment.scenario))
    seen = scene if node.when == "start" else judged(ev)
    value, dimension, made = _Cells(seen, node).of(seen.evaluate(node.value))
    if node.when == "start":
        least, greatest = ev.interval(value)
        made = replace(made, least=least, greatest=greatest)
    if drawn != (decisions.draw_count, len(decisions.choices)):
        raise DOMAIN_DRAWS.mistake(node.value.span)
    number = _declare(ev, node, made)
    if use.cells is None:
        watched = value if node.when != "start" else _Cells(judged(ev), node).of(judged(ev).evaluate(node.value))[0]
        _measure(ev, node, number, watched, dimension)
    elif node.when == "start":
        for place, cell in enumerate(made.cells):
            if (number, place) in use.cells:
                name = requirement_name(number, place)
                ev.run.built.requirements.append(ir.Requirement(_inside(value, cell), 1.0, name, made.line))


def requirement_name(domain: int, cell: int) -> str:
    """Return the name of the requirement that a cell becomes; no requirement of a file can have it."""
    return f"\0{domain}\0{cell}"


def _declare(ev: Evaluator, node: nodes.Domain, made: ir.Domain) -> int:
    """Declare the domain, which has the same cells in all variants, and return its number.

    Raises:
        Mistake: another domain has its name, or its cells vary.
    """
    domains = ev.file.run.domains
    first = next((span for span, known in domains.items() if known.name == made.name), node.span)
    if first != node.span:
        raise DUPLICATE.mistake(node.span, secondary=(Label(first, "first here"),), what="the domain", name=made.name)
    known = domains.setdefault(node.span, made)
    if known.cells != made.cells:
        raise CELLS_UNKNOWN.mistake(node.cells.span, reason="they are others with other choices")
    least, greatest = min(known.least, made.least), max(known.greatest, made.greatest)
    domains[node.span] = replace(known, least=least, greatest=greatest)
    return list(domains).index(node.span)


def _measure(ev: Evaluator, node: nodes.Domain, number: int, value: Term, dimension: ir.Dimension) -> None:
    """Make the value at the instant an objective."""
    run, key = ev.file.run, (node.value.span, RuleKind.WATCH)
    rule = run.rule(node.value.span, f"{OBJECTIVE}{number}", RuleKind.WATCH)
    ev.run.built.rule_conditions[key] = value
    made = ir.Objective(Sense.MAXIMIZE, f"{OBJECTIVE}{number}", ev.facts.line(node.span), dimension)
    run.objectives.setdefault(node.span, (node, made))
    ev.run.built.objectives[node.span] = ev.algebra.local(run.reading(ir.Reading(REDUCERS[node.when], rule)))


def _inside(value: Term, cell: ir.Cell) -> Term:
    """Return the condition that a value lies in a cell."""
    if cell.low == cell.high:
        return equal(value, cell.low)
    return ~(value < cell.low) & (value <= cell.high if cell.closed else value < cell.high)


class _Cells:
    """Value and cells of one domain."""

    def __init__(self, ev: Evaluator, node: nodes.Domain) -> None:
        self.ev, self.node = ev, node

    def of(self, value: Value) -> tuple[Term, ir.Dimension, ir.Domain]:
        """Return the value as a number, its dimension, and the domain.

        Raises:
            Mistake: the value is no number, or the cells are not known, are empty or overlap.
        """
        node, span = self.node, self.node.value.span
        items = None if node.low is not None else self._items()
        if items is not None and not all(_is_numeric(item) for item in items):
            return self._by_equality(node.cells.items if isinstance(node.cells, nodes.ListDisplay) else (), items)
        value = Quantity(value.expr, PURE) if isinstance(value, Truth) else value
        number = numbers.quantity(value, span, "the value of a domain")
        ends = self._steps(number) if items is None else self._listed(items, number)
        dimension = number.dimension or next((d for _, _, d in ends if d is not None), None) or PURE
        unit = spoken_unit(node.cells, number.expr, dimension, self.ev.file.genes.infos) or si_word(dimension)
        unit = unit or spoken_unit(node.value, number.expr, dimension, self.ev.file.genes.infos)
        scale = UNITS[unit].factor if unit in UNITS else 1.0
        if items is None:
            cells = self._step_cells(ends, unit, scale)
        else:
            cells = self._checked([_cell(low, high, unit, scale) for low, high, _ in ends])
            cells = [_spelled(cell, item) for cell, item in zip(cells, items, strict=True)]
        return number.expr, dimension, self._domain(cells, unit, scale)

    def _domain(self, cells: Sequence[ir.Cell], unit: str, scale: float) -> ir.Domain:
        facts, node = self.ev.facts, self.node
        text = facts.source.words(node.value.span)
        return ir.Domain(node.name, node.when, facts.line(node.span), text, unit, scale, tuple(cells))

    def _items(self) -> tuple[Value, ...]:
        """Return the items of the list.

        Raises:
            Mistake: it is no list, or an empty one.
        """
        items = self.ev.evaluate(self.node.cells)
        if not isinstance(items, tuple) or not items:
            reason = "an empty list has none" if isinstance(items, tuple) else "this is no list"
            raise NO_CELLS.mistake(self.node.cells.span, reason=reason)
        if len(items) > MOST_CELLS:
            raise NO_CELLS.mistake(self.node.cells.span, reason=f"there are more than {MOST_CELLS:,}")
        return items

    def _by_equality(
        self, written: Sequence[nodes.Expression], items: Sequence[Value]
    ) -> tuple[Term, ir.Dimension, ir.Domain]:
        """Return the number of the item that the value equals, -1 for none; items that are no numbers."""
        span = self.node.value.span
        if len(written) != len(items):
            raise CELLS_UNKNOWN.mistake(self.node.cells.span, reason="items that are no numbers are written one by one")
        result: Term = self.ev.algebra.literal(-1.0)
        for number, item in reversed(list(enumerate(written))):
            compared = nodes.Compare(self.node.value, (("==", item),), span=span)
            condition = numbers.truth(self.ev, self.ev.evaluate(compared), span)
            result = where(condition, float(number), result)
        words = [
            source_text(item) or self.ev.facts.source.words(w.span) for item, w in zip(items, written, strict=True)
        ]
        if len(set(words)) < len(words):
            twice = next(word for word in words if words.count(word) > 1)
            raise CELLS_OVERLAP.mistake(self.node.cells.span, one=twice, other=twice)
        cells = [ir.Cell(float(number), float(number), True, word, word) for number, word in enumerate(words)]
        return result, PURE, self._domain(cells, "", 1.0)

    def _steps(self, value: Quantity) -> list["_Ends"]:
        """Return (width, width), (low, low) and (high, high) of the steps."""
        ends = []
        for node in (self.node.cells, self.node.low, self.node.high):
            assert node is not None
            ends.append(self._end(self.ev.evaluate(node), value, node.span))
        return [(number, number, dimension) for number, dimension in ends]

    def _step_cells(self, ends: Sequence["_Ends"], unit: str, scale: float) -> list[ir.Cell]:
        width, low, high = (number / scale for number, _, _ in ends)
        span = self.node.cells.span
        if not (width > 0.0 and high > low):
            reason = "the step is not above 0" if width <= 0.0 else "the upper end is not above the lower end"
            raise NO_CELLS.mistake(span, reason=reason)
        count = (high - low) / width
        if count > MOST_CELLS:
            raise NO_CELLS.mistake(span, reason=f"there are {count:,.0f}, more than {MOST_CELLS:,}")
        whole = math.ceil(count - numbers.ROUNDING * max(1.0, count))
        if abs(count - round(count)) > numbers.ROUNDING * max(1.0, count):
            rest = f"{high - low - (whole - 1) * width:.4g} {unit}".rstrip()
            self.ev.report(SHORT_CELL.at(span, step=f"{width:.6g} {unit}".rstrip(), rest=rest))
        edges = [_rounded(low + place * width) * scale for place in range(whole)]
        return self._checked([_cell(a, b, unit, scale) for a, b in pairwise((*edges, ends[2][0]))])

    def _listed(self, items: Sequence[Value], value: Quantity) -> list["_Ends"]:
        return [self._pair(item, value) for item in items]

    def _pair(self, item: Value, value: Quantity) -> "_Ends":
        """Return the ends of one item: a number, or a pair of them."""
        span = self.node.cells.span
        if not isinstance(item, tuple):
            number, dimension = self._end(item, value, span)
            return number, number, dimension
        (low, dimension), (high, other) = (self._end(each, value, span) for each in item)
        if not low < high:
            raise NO_CELLS.mistake(span, reason="the upper end of an interval is not above its lower end")
        return low, high, dimension or other

    def _end(self, item: Value, value: Quantity, span: Span) -> tuple[float, ir.Dimension | None]:
        """Return one end, SI, and its dimension.

        Raises:
            Mistake: it is not known, is no number, or has another dimension than the value.
        """
        item = Quantity(item.expr, PURE) if isinstance(item, Truth) else item
        number = numbers.quantity(item, span, "an end of a cell")
        dimension = numbers.common(value.dimension, number.dimension, span, "compared")
        known = closed_value(number.expr)
        if known is None:
            raise CELLS_UNKNOWN.mistake(span, reason="they depend on a param or on the run")
        if not math.isfinite(known):
            raise CELLS_UNKNOWN.mistake(span, reason="an end is not a finite number")
        return known, dimension

    def _checked(self, cells: Sequence[ir.Cell]) -> list[ir.Cell]:
        """Return the cells with the ends that belong to them: an upper end at which no other cell begins.

        Raises:
            Mistake: two cells overlap.
        """
        ordered = sorted(cells, key=lambda cell: (cell.low, cell.high))
        for one, other in pairwise(ordered):
            if other.low < one.high or other.low == one.low:
                raise CELLS_OVERLAP.mistake(self.node.cells.span, one=one.text, other=other.text)
        begins = {cell.low for cell in cells}
        return [replace(cell, closed=cell.low == cell.high or cell.high not in begins) for cell in cells]


_Ends = tuple[float, float, ir.Dimension | None]
"""Lower and upper end, SI, and their dimension."""


def _is_numeric(item: Value) -> bool:
    pair = isinstance(item, tuple) and len(item) == 2 and all(isinstance(each, Quantity) for each in item)
    return pair or isinstance(item, Quantity | Truth)


def _rounded(number: float) -> float:
    return float(f"{number:.{DIGITS}g}")


def _cell(low: float, high: float, unit: str, scale: float) -> ir.Cell:
    shown = " to ".join(f"{_rounded(end / scale):.6g}" for end in dict.fromkeys((low, high)))
    return ir.Cell(low, high, True, f"{shown} {unit}".rstrip())


def _spelled(cell: ir.Cell, item: Value) -> ir.Cell:
    """Return the cell of a truth with its word."""
    word = "True" if cell.low else "False"
    return replace(cell, text=word, item=word) if isinstance(item, Truth) else cell

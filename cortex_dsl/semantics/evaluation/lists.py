"""Lists: displays, comprehensions, items and slices, and `append`, which the compiler executes at once."""

from collections import Counter
from collections.abc import Sequence

from cortex_dsl.semantics.errors.names import UNKNOWN_ATTRIBUTE
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.values import (
    BAD_INDEX,
    BAD_UNPACKING,
    DEEP_LIST,
    LIST_TOO_LONG,
    OUT_OF_RANGE,
    WRONG_KIND,
)
from cortex_dsl.semantics.evaluation import geometry, lanes
from cortex_dsl.semantics.evaluation.arguments import items_of
from cortex_dsl.semantics.evaluation.functions import RANGE_LIMIT, known_truth, whole_number
from cortex_dsl.semantics.model.areas import Elements
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import (
    POISON,
    Centerline,
    Closure,
    DirectionField,
    Effect,
    Filtered,
    Items,
    Quantity,
    Value,
    Vector,
    Weights,
)
from cortex_dsl.semantics.model.wording import NAMED, kind_name
from cortex_dsl.semantics.quantities.units import ANGLE, LENGTH
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes
from engine.road.network import Maneuver

DEEPEST = 50
"""Maximum nesting depth of lists."""
PASSES = 4
"""Number of passes over the items of a list that is unpacked in another list."""


def display(ev: Evaluator, node: nodes.ListDisplay | nodes.TupleDisplay) -> Value:
    values: list[Value] = []
    for item in node.items:
        if isinstance(item, nodes.Starred):
            items = items_of(ev.evaluate(item.value), item.span)
            ev.file.budget.copy(item.span, PASSES * len(items))
            values += items
        else:
            values.append(ev.tolerate(lambda item=item: ev.evaluate(item)))
    if any(value is POISON for value in values):
        raise Mistake
    return _shallow(ev, Items(values) if isinstance(node, nodes.ListDisplay) else tuple(values), node.span)


def _shallow(ev: Evaluator, values: tuple[Value, ...], span: Span) -> Value:
    """A list in which lists lie at most `DEEPEST` deep, which whatever goes through them may count on."""
    level: dict[int, tuple[Value, ...]] = {0: values}
    for _ in range(DEEPEST):
        level = {id(item): item for each in level.values() for item in each if isinstance(item, tuple)}
        if not level:
            return values
        ev.file.budget.copy(span, sum(map(len, level.values())))
    raise DEEP_LIST.mistake(span, limit=DEEPEST)


def dictionary(ev: Evaluator, node: nodes.DictDisplay) -> Value:
    entries = tuple((ev.evaluate(key), ev.evaluate(value)) for key, value in node.entries)
    return Weights(entries, tuple(key.span for key, _ in node.entries))


def comprehension(ev: Evaluator, node: nodes.Comprehension) -> Value:
    seen: list[Value] = []
    generated = Items(_generated(ev, node, node.clauses, seen))
    return _shallow(ev, generated.of(tuple(seen)), node.span)


def _generated(
    ev: Evaluator, node: nodes.Comprehension, clauses: Sequence[nodes.ForClause], seen: list[Value]
) -> list[Value]:
    """Return the items of a comprehension; `seen` receives the items that its last conditions are evaluated for."""
    if not clauses:
        return [ev.evaluate(node.element)]
    clause, rest = clauses[0], clauses[1:]
    results: list[Value] = []
    with ev.file.budget.repeating(clause.iterable.span):
        for item in items_of(ev.evaluate(clause.iterable), clause.iterable.span, "what `for` runs over"):
            inner = ev.inside(unpack(clause.targets, item, clause.span))
            if clause.conditions and not rest:
                seen.append(item)
            if all(known_truth(inner, inner.evaluate(c), c.span, "the condition of a list") for c in clause.conditions):
                results += _generated(inner, node, rest, seen)
    return results


def unpack(targets: Sequence[str], value: Value, span: Span) -> dict[str, Value]:
    """Names for a value, or for the items of a list."""
    if len(targets) == 1:
        return {targets[0]: value}
    items = items_of(value, span, "what is unpacked")
    if len(items) != len(targets):
        raise BAD_UNPACKING.mistake(span, names=len(targets), count=len(items))
    return dict(zip(targets, items, strict=True))


def index(ev: Evaluator, node: nodes.Index) -> Value:
    if isinstance(node.index, nodes.Slice):
        return _slice(ev, node, node.index)
    value, at = ev.evaluate_all((node.value, node.index))
    if isinstance(value, Elements):
        return _element(value, at, node.index.span)
    if isinstance(value, Centerline):
        value = tuple(Vector(end.x, end.y) for end in lanes.ends(ev, value))
    if isinstance(value, DirectionField):
        point = geometry.position(ev, at, node.index.span)
        return Quantity(geometry.as_written(ev, geometry.direction_at(value, point)), ANGLE)
    if isinstance(value, Vector):
        value = (Quantity(value.x, LENGTH), Quantity(value.y, LENGTH))
    items = items_of(value, node.value.span, "what is indexed")
    position = whole_number(ev, at, node.index.span, "an index")
    if not -len(items) <= position < len(items):
        reason, cure = _what_there_is(items)
        raise BAD_INDEX.mistake(node.index.span, index=position, count=len(items), reason=reason, cure=cure)
    return items[position]


def _element(elements: Elements, name: Value, span: Span) -> Value:
    if not isinstance(name, str):
        cure = 'as in `network.elements["road5"]`'
        raise WRONG_KIND.mistake(
            span, what="the name of an element", expected="text", actual=kind_name(name), cure=cure
        )
    if (found := elements.by_name().get(name)) is None:
        raise UNKNOWN_ATTRIBUTE.mistake(
            span, kind="this map", name=name, suggestion=did_you_mean(name, elements.by_name())
        )
    return found


def _slice(ev: Evaluator, node: nodes.Index, part: nodes.Slice) -> Value:
    items = items_of(ev.evaluate(node.value), node.value.span, "what is sliced")
    bounds = (part.start, part.stop, part.step)
    at = [None if each is None else whole_number(ev, ev.evaluate(each), each.span, "a slice") for each in bounds]
    if part.step is not None and at[2] == 0:
        what, cure = "the step of a slice", "write -1 to go backwards"
        raise OUT_OF_RANGE.mistake(
            part.step.span, what=what, actual=0, expected="a whole number other than 0", cure=cure
        )
    ev.file.budget.copy(node.span, len(items))
    return Items(items[slice(*at)])


def _what_there_is(items: tuple[Value, ...]) -> tuple[str, str]:
    """Return why a list is empty if a condition filtered its items, and the available items."""
    if items:
        return "", f"items count from 0: `[0]` to `[{len(items) - 1}]`; `[-1]` is the last"
    among = items.among if isinstance(items, Filtered) else ()
    if not among:
        return "", "the list is empty"
    kinds = {kind_name(item).split(" ", 1)[-1] if isinstance(item, NAMED) else "item" for item in among}
    noun = kinds.pop() if len(kinds) == 1 else "item"
    left_out = f"the condition left out {len(among)} {noun}{'s' if len(among) > 1 else ''}"
    types = Counter(item.type.name for item in among if isinstance(item, Maneuver))
    if not types:
        return left_out, "change the condition, or the list"
    shown = ", ".join(f"{count} {name}" for name, count in types.items())
    there = " or ".join(f"`ManeuverType.{name}`" for name in types)
    cure = f"ask for {there}, or begin with another maneuver or lane"
    return (f"{left_out}, all {next(iter(types))}" if len(types) == 1 else f"{left_out}: {shown}"), cure


def append(ev: Evaluator, items: Items) -> Closure:
    """`items.append(x)`: whatever is called so is the longer list from now on."""

    def apply(item: Value) -> Value:
        if len(items) >= RANGE_LIMIT:
            raise LIST_TOO_LONG.mistake(ev.algebra.span, limit=RANGE_LIMIT)
        ev.file.budget.copy(ev.algebra.span, len(items))
        longer = Items((*items, item))
        for scope in (*ev.scopes, ev.names):
            for name in [name for name, value in scope.items() if value is items]:
                scope[name] = longer  # type: ignore[index]
                ev.run.outlived |= scope is not ev.names
        return Effect(())

    return Closure(("item",), apply)

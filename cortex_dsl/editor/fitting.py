"""Kinds of values that a place takes, and the completions of that kind.

A place without a kind retains every candidate. With a kind, impossible candidates are left out, and direct ones precede
those that need more: a speed precedes the car that has one.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from enum import Enum

from cortex_dsl.editor.analysis import View
from cortex_dsl.editor.place import Place
from cortex_dsl.editor.symbols import Symbol, SymbolKind
from cortex_dsl.ir import Dimension
from cortex_dsl.semantics.model.context import ObservedValues
from cortex_dsl.semantics.model.values import BehaviourValue, BuiltinValue, ClassValue, MonitorValue, Quantity, Truth
from cortex_dsl.semantics.names.builtins import BUILTINS, REDUCERS, Kind
from cortex_dsl.semantics.names.properties import FLAGS, PROPERTIES
from cortex_dsl.semantics.quantities.units import ANGLE, LENGTH
from cortex_dsl.syntax.words import TEMPORAL_PREFIXES


@dataclass(frozen=True)
class Candidate:
    """Something that can be written; `kind` is a word that the server translates."""

    label: str
    kind: str
    detail: str = ""
    doc: str = ""
    rank: int = 5
    """Smaller ones come first."""


class Sort(Enum):
    """Kind of value that a place takes."""

    TRUTH = "a condition, or what one begins with"
    NUMBER = "a number"
    RUN = "a number of the whole run"
    THING = "an object or a place"


@dataclass(frozen=True)
class Expected:
    """Value that a place takes; for a number its dimension, if it is known."""

    sort: Sort
    dimension: Dimension | None = None
    alone: bool = False
    """Whether a constant will do."""


CONDITIONS = frozenset(
    {"require", "expect", "terminate when", "terminate simulation when", "interrupt when", "if", "elif", "while"}
)
OVER_RUN = ("maximize", "minimize")
TEMPORAL = ("require", "expect")
COMPARED = frozenset({"<", "<=", ">", ">=", "==", "!="})
BEFORE_THINGS = frozenset(
    {"distance from", "distance to", "minimum distance from", "minimum distance to", "can see", "intersects"}
)
"""Operators that an object or a place follows; `to` and `from` go on with some of them."""
MEASURES: Mapping[str, Dimension] = {
    **dict.fromkeys(("distance from", "distance to", "minimum distance from", "minimum distance to"), LENGTH),
    "relative heading of": ANGLE,
}
"""Dimension of the results of operators at the beginning of an expression."""


def expected_at(view: View, place: Place) -> Expected | None:
    """Return the kind of value that a place takes; None if that is open."""
    if not place.left:
        return None
    first, previous = _words(place.left[0].text), place.previous
    if previous in BEFORE_THINGS or (previous in ("to", "from") and _measured(place)):
        return Expected(Sort.THING)
    if previous in COMPARED:
        return _like(view, place.left[-2].text if len(place.left) > 1 else "")
    if len(place.left) > 1 and place.left[-2].text == "with":
        return _of_property(previous)
    if place.callee >= 0 and (of_argument := _of_argument(place)) is not None:
        return of_argument
    if first in OVER_RUN:
        return Expected(Sort.NUMBER if _reduced(place) else Sort.RUN)
    return Expected(Sort.TRUTH) if first in CONDITIONS else None


def _words(text: str) -> str:
    return " ".join(text.split())


def _measured(place: Place) -> bool:
    return any(_words(token.text) in BEFORE_THINGS for token in place.left)


def _like(view: View, name: str) -> Expected:
    """Return a number of the dimension of the other side."""
    symbol = view.known(len(view.text)).get(name)
    return Expected(Sort.NUMBER, None if symbol is None else _dimension(view.values_of(symbol)))


def _of_property(name: str) -> Expected | None:
    if name in FLAGS or (name in PROPERTIES and PROPERTIES[name].truth):
        return Expected(Sort.TRUTH, alone=True)
    return Expected(Sort.NUMBER, PROPERTIES[name].dimension) if name in PROPERTIES else None


def _of_argument(place: Place) -> Expected | None:
    """Return the kind of value of an argument of a built-in function, by the name or position of the argument."""
    builtin = BUILTINS.get(place.left[place.callee].text)
    if builtin is None or not builtin.parameters or builtin.variadic:
        return None
    inside = place.left[place.open[-1] + 1 :]
    named = inside[-2].text if len(inside) > 1 and inside[-1].text == "=" else None
    places = {p.name: p for p in builtin.parameters}
    if named is None and place.previous in ("(", ",") and place.argument < len(builtin.parameters):
        parameter = builtin.parameters[place.argument]
    elif named in places:
        parameter = places[named]
    else:
        return None
    return None if parameter.dimension is None else Expected(Sort.NUMBER, parameter.dimension)


def _reduced(place: Place) -> bool:
    """Return whether the place is inside the brackets of a reducer, where values still change."""
    return any(index and place.left[index - 1].text in REDUCERS for index in place.open)


# -- fitting candidates ------------------------------------------------------------------------------------------------

NO_VALUES = frozenset({Kind.CLASS.value, Kind.ACTION.value, Kind.BEHAVIOUR.value})
"""Kinds of built-in names that are no values by themselves."""
NO_VALUE_SYMBOLS = frozenset({SymbolKind.BEHAVIOR, SymbolKind.MONITOR, SymbolKind.SCENARIO, SymbolKind.CLASS})
FIRST, NEXT, LATER = 1, 2, 4
"""Ranks: of the kind itself, on the way to it, and the rest."""


def fitting(view: View, place: Place, candidates: Iterable[Candidate]) -> Iterator[Candidate]:
    """Yield the candidates that fit a place, with ranks by quality."""
    expected = expected_at(view, place)
    if expected is None:
        yield from candidates
        return
    symbols, first = view.known(place.offset), _words(place.left[0].text)
    for candidate in candidates:
        symbol = symbols.get(candidate.label)
        if symbol is not None:
            rank = None if _is_hidden(symbol, place) else _rank_of_values(expected, view.values_of(symbol))
        elif candidate.kind == "keyword":
            rank = _rank_of_word(expected, candidate, timed=first in TEMPORAL)
        else:
            rank = None if _is_astray(candidate, place, first) else _rank_of_builtin(expected, candidate)
        if rank is not None:
            yield replace(candidate, rank=rank)


def _is_hidden(symbol: Symbol, place: Place) -> bool:
    """Return whether a name has no value here: a definition, or a name of another block."""
    elsewhere = symbol.kind in (SymbolKind.LOCAL, SymbolKind.ARGUMENT) and symbol.scope.end < place.start
    return symbol.kind in NO_VALUE_SYMBOLS or (elsewhere and not place.indent)


def _is_astray(candidate: Candidate, place: Place, first: str) -> bool:
    """Return whether a built-in name has no meaning in such a statement."""
    if candidate.label == "self":
        return not place.indent and first not in ("expect", *OVER_RUN)
    return candidate.kind == Kind.DISTRIBUTION.value and first in (*CONDITIONS, *OVER_RUN)


def _rank_of_values(expected: Expected, values: ObservedValues) -> int | None:
    value = values[0].value if values else None
    if isinstance(value, BehaviourValue | MonitorValue | ClassValue | BuiltinValue):
        return None
    return NEXT if not values else _RANKS[expected.sort](expected, value)


def _for_truth(_expected: Expected, value: object) -> int | None:
    return FIRST if isinstance(value, Truth) else NEXT if isinstance(value, Quantity) else 3


def _for_number(expected: Expected, value: object) -> int | None:
    """Return the rank of a value as a number.

    Numbers of the dimension fit, and those without a unit, which adopt one; objects have numbers.
    """
    if isinstance(value, Truth):
        return None
    if not isinstance(value, Quantity):
        return 3
    if expected.dimension is None or value.dimension == expected.dimension:
        return FIRST
    return NEXT if value.dimension is None else None


def _for_run(expected: Expected, value: object) -> int | None:
    """Return the rank of a quantity as the operand of a reducer; None for other values."""
    return _for_number(expected, value) if isinstance(value, Quantity) else None


def _for_thing(_expected: Expected, value: object) -> int | None:
    return None if isinstance(value, Truth | Quantity) else FIRST


_RANKS: Mapping[Sort, Callable[[Expected, object], int | None]] = {
    Sort.TRUTH: _for_truth,
    Sort.NUMBER: _for_number,
    Sort.RUN: _for_run,
    Sort.THING: _for_thing,
}


def _rank_of_word(expected: Expected, candidate: Candidate, *, timed: bool) -> int | None:
    """Words that begin an expression."""
    word = candidate.label
    if word in TEMPORAL_PREFIXES:
        return NEXT if timed and expected.sort is Sort.TRUTH else None
    if word in ("True", "False", "not"):
        return (FIRST - 1 if expected.alone and word != "not" else LATER) if expected.sort is Sort.TRUTH else None
    if expected.sort is Sort.THING or word in ("new", "lambda", "None"):
        return None
    if word in MEASURES and expected.sort is Sort.RUN:
        return None
    if word in MEASURES:
        return LATER if expected.dimension in (None, MEASURES[word]) else None
    return candidate.rank


def _rank_of_builtin(expected: Expected, candidate: Candidate) -> int | None:
    if candidate.kind in NO_VALUES or candidate.label in ("none", "ManeuverType"):
        return None
    if expected.sort is Sort.THING and candidate.kind in (Kind.DISTRIBUTION.value, Kind.FUNCTION.value):
        return None
    if candidate.label in ("ego", "self"):
        return {Sort.THING: FIRST, Sort.RUN: None}.get(expected.sort, NEXT)
    return candidate.rank


def _dimension(values: ObservedValues) -> Dimension | None:
    value = values[0].value if values else None
    return value.dimension if isinstance(value, Quantity) else None

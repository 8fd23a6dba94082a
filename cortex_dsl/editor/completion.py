"""Completions at a place, with their descriptions: names, values, and the members after a dot."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from cortex_dsl.editor.analysis import ObservedValue, ObservedValues, View, analyse, described, ending_at
from cortex_dsl.editor.fitting import TEMPORAL, Candidate, Sort, expected_at, fitting
from cortex_dsl.editor.hover import (
    argument_text,
    attribute_doc,
    builtin_text,
    keyword_text,
    property_text,
    symbol_text,
    unit_text,
)
from cortex_dsl.editor.place import CLOSERS, Place, place_of
from cortex_dsl.editor.symbols import Symbol, SymbolKind
from cortex_dsl.semantics.acting.statements import SETTINGS
from cortex_dsl.semantics.errors.problems import Mistake, NeedsExpansion, Rejection
from cortex_dsl.semantics.evaluation import attributes, signals
from cortex_dsl.semantics.evaluation.maps import MAP_ARGUMENTS
from cortex_dsl.semantics.model.context import Moment
from cortex_dsl.semantics.model.values import EnumValue, GlobalParameters, Namespace, Value
from cortex_dsl.semantics.names.attribute_docs import ATTRIBUTE_DOCS
from cortex_dsl.semantics.names.builtins import BUILTINS, REDUCERS, SPECIAL_NAMES, Kind
from cortex_dsl.semantics.names.properties import ENVIRONMENT, FLAGS, PROPERTIES
from cortex_dsl.semantics.quantities.units import UNITS, dimension_name
from cortex_dsl.syntax.words import KEYWORDS, TEMPORAL_PREFIXES, Keyword, Role
from engine.judged import NAMED_RESULTS
from engine.vocabulary import ManeuverType

# -- what may follow a dot: found by asking the value that stands before it --------------------------------------------
#
# While `lane.` is being written the text is broken. It is repaired by leaving the dot out, compiled, and the value that
# stood there is asked for every known attribute.


@dataclass(frozen=True)
class Member:
    name: str
    value_text: str = ""
    """Its value, in one line."""


def members(view: View, place: Place) -> list[Member]:
    """Return everything that may follow the dot before a place; all that can follow any dot if the value is unknown."""
    for values in _values_before_dot(view, place):
        found = [member for name in _names_before_dot(values[0]) if (member := _member_of(values[0], name)) is not None]
        if found:
            return found
    return [Member(name) for name in sorted({*ATTRIBUTE_DOCS, *PROPERTIES})]


def _values_before_dot(view: View, place: Place) -> Iterator[ObservedValues]:
    """Yield the value before the dot: from the repaired text, or from the last text without errors."""
    if len(place.left) < 2:
        return
    base, dot = place.left[-2], place.left[-1].start
    seen = ending_at(analyse(view.name, mended(view, place, dot), files=view.files).seen, base.span)
    if seen:
        yield seen
    if base.text == "self":
        yield from ([_while_running(found[0])] for found in list(view.analysis.seen.values())[:1])
    symbol = view.known(dot).get(base.text)
    if symbol is not None and (known := view.values_of(symbol)):
        yield known


def _while_running(observed: ObservedValue) -> ObservedValue:
    """Any object of the scene, at a moment of the run."""
    actor = next(iter(observed.evaluator.run.built.actors), None)
    return ObservedValue(observed.evaluator.at_moment(Moment(running=True, actor=actor)), actor)


def mended(view: View, place: Place, dot: int) -> str:
    """Return the text without the dot and the rest of its line, with its brackets closed."""
    line = view.text.rfind("\n", 0, dot) + 1
    end = view.text.find("\n", place.offset)
    end = len(view.text) if end < 0 else end
    opened = [place.left[index] for index in reversed(place.open)]
    closers = "".join(CLOSERS[token.text] for token in opened if token.start >= line)
    rest = view.text[place.offset : end].rstrip()
    return view.text[:dot] + closers + (rest[-1:] if rest[-1:] in (",", ":") else "") + view.text[end:]


def _names_before_dot(observed: ObservedValue) -> list[str]:
    """Return the names that such a value may have."""
    match observed.value:
        case EnumValue():
            return [member.name for member in ManeuverType]
        case GlobalParameters():
            return list(observed.evaluator.run.params)
        case Namespace(names=names):
            return list(names)
    return sorted({*attributes.attribute_names(), *PROPERTIES, *FLAGS})


def _member_of(observed: ObservedValue, name: str) -> Member | None:
    """The attribute of a value, if it has it."""
    evaluator = observed.evaluator
    try:
        value: Value = attributes.get(evaluator, observed.value, name, evaluator.algebra.span)
    except (Rejection, NeedsExpansion):
        return Member(name)
    except Mistake:
        return None
    return Member(name, described([ObservedValue(evaluator, value)]))


# -- Candidates at a place ---------------------------------------------------------------------------------------------

_SETTINGS = {"simulation": SETTINGS, "signals": signals.ARGUMENTS, "environment": tuple(ENVIRONMENT)}
"""Arguments of statements that are written like calls."""
INSIDE_ROLES = (Role.ACT, Role.CLAUSE)
ANYWHERE = ("if", "while", "require", "pass", "else", "elif")
"""Statements of the file and of behaviors alike."""


def complete(view: View, offset: int, *, decided: bool = False) -> list[Candidate]:
    """Return all completions at an offset; the client selects those that fit the typed part.

    `decided`: nothing, unless the word before determines the next one.
    """
    place = place_of(view, offset)
    if place is None or (decided and not (place.previous in _AFTER or place.after_number or place.phrase)):
        return []
    found: dict[str, Candidate] = {}
    for candidate in _candidates(view, place):
        found.setdefault(candidate.label, candidate)
    return list(found.values())


def _candidates(view: View, place: Place) -> Iterable[Candidate]:
    if place.previous == ".":
        return map(_member, members(view, place))
    if place.after_number:
        return (*_units(), *_joining(place))
    if rest := list(_rest_of_phrase(place)):
        return rest
    if not place.left:
        return (*_statements(view, place), *_names(view, place))
    if len(place.left) > 1 and place.left[-2].text == "with":
        return _behaviors(view, place) if place.previous == "behavior" else fitting(view, place, _values(view, place))
    return _AFTER[place.previous](view, place) if place.previous in _AFTER else _inside(view, place)


def _inside(view: View, place: Place) -> Iterator[Candidate]:
    """Within a statement, where no single word decides."""
    if place.previous == ":" and not place.open:
        yield from _statements(view, place)
    if place.after_value and not _goes_on(place):
        if place.previous == ")" and _is_distribution(place.closed_call):
            yield from _units()
        yield from _joining(place)
        return
    if place.previous == "," and place.in_new:
        yield from _keywords(Role.SPECIFIER)
        return
    yield from _arguments(view, place)
    yield from fitting(view, place, (*_over_run(view, place), *_values(view, place)))


def _goes_on(place: Place) -> bool:
    """Return whether the word before is an operator here, though it could be a name."""
    return place.previous in TEMPORAL_PREFIXES and place.left[0].text in TEMPORAL


# -- completions that one word before determines -----------------------------------------------------------------------


def _classes(view: View, place: Place) -> Iterator[Candidate]:
    yield from (_symbol(view, s) for s in view.known(place.offset).values() if s.kind is SymbolKind.CLASS)
    yield from _builtins(Kind.CLASS)


def _properties(view: View, place: Place) -> Iterator[Candidate]:
    """Properties, those of one's own classes first, those already given left out."""
    given = {b.text for a, b in zip(place.left, place.left[1:], strict=False) if a.text == "with"}
    for symbol in view.analysis.symbols:
        if symbol.kind is SymbolKind.PROPERTY and symbol.name not in given:
            yield Candidate(symbol.name, "property", "of a class", symbol_text(view, symbol), 2)
    for name in (*FLAGS, *PROPERTIES):
        if name not in given:
            number = name in PROPERTIES and not PROPERTIES[name].truth
            dimension = dimension_name(PROPERTIES[name].dimension) if number else ""
            yield Candidate(name, "property", dimension, property_text(name), 3)


def _behaviors(view: View, place: Place) -> Iterator[Candidate]:
    kinds = (SymbolKind.BEHAVIOR, SymbolKind.SCENARIO)
    yield from (_symbol(view, s) for s in view.known(place.offset).values() if s.kind in kinds)
    yield from _builtins(Kind.BEHAVIOUR)


def _monitors(view: View, place: Place) -> Iterator[Candidate]:
    yield from (_symbol(view, s) for s in view.known(place.offset).values() if s.kind is SymbolKind.MONITOR)


def _actions(_view: View, _place: Place) -> Iterator[Candidate]:
    yield from _builtins(Kind.ACTION)


def _nothing(_view: View, _place: Place) -> Iterator[Candidate]:
    """A new name has to be found by its author."""
    return iter(())


def _maps(_view: View, _place: Place) -> Iterator[Candidate]:
    yield Candidate("intersection", "function", "", "A grid of one or more intersections.")
    yield Candidate("road", "function", "", "A road without intersections, straight or curved.")


_AFTER = {
    "new": _classes,
    "with": _properties,
    "do": _behaviors,
    "do choose": _behaviors,
    "do shuffle": _behaviors,
    "take": _actions,
    "require monitor": _monitors,
    "map": _maps,
    **dict.fromkeys(("behavior", "monitor", "scenario", "class", "param", "as", "lambda", "import", "model"), _nothing),
}


# -- kinds of candidates ----------------------------------------------------------------------------------------------


def _statements(view: View, place: Place) -> Iterator[Candidate]:
    """First words: those of the file at its left edge, those of behaviors where it is indented."""
    for keyword in KEYWORDS:
        inside = keyword.role in INSIDE_ROLES
        if keyword.role in (Role.STATEMENT, *INSIDE_ROLES) and (
            inside == bool(place.indent) or keyword.phrase in ANYWHERE or _in_scenario(view, place)
        ):
            yield _keyword(keyword, 1)


def _in_scenario(view: View, place: Place) -> bool:
    around = (s for s in view.analysis.symbols if s.kind is SymbolKind.SCENARIO)
    return bool(place.indent) and any(s.whole.start < place.start <= s.whole.end + 1 for s in around)


def _rest_of_phrase(place: Place) -> Iterator[Candidate]:
    """Yield `by` and `along` after `offset`; only if the words so far mean nothing by themselves."""
    for count in range(len(place.phrase), 0, -1):
        said = place.phrase[-count:]
        if any(keyword.words == said for keyword in KEYWORDS) and said != ("terminate",):
            continue
        for keyword in KEYWORDS:
            if len(keyword.words) > count and keyword.words[:count] == said:
                yield Candidate(" ".join(keyword.words[count:]), "keyword", keyword.form, keyword_text(keyword), 1)


def _keywords(*roles: Role, rank: int = 4) -> Iterator[Candidate]:
    yield from (_keyword(keyword, rank) for keyword in KEYWORDS if keyword.role in roles)


def _joining(place: Place) -> Iterator[Candidate]:
    """Words that can follow a value."""
    for keyword in KEYWORDS:
        infix = keyword.role is Role.OPERATOR and not keyword.form.startswith(keyword.phrase)
        specifier = keyword.role is Role.SPECIFIER and (place.in_new or keyword.phrase in ("in", "on"))
        if infix or specifier or keyword.role is Role.LINK:
            yield _keyword(keyword, 3 if specifier else 4)


def _over_run(view: View, place: Place) -> Iterator[Candidate]:
    """Yield reducers and named results of a run, at a place that takes such a number."""
    expected = expected_at(view, place)
    if expected is not None and expected.sort is Sort.RUN:
        yield from (Candidate(name, "function", f"{name}(x)", doc, 0) for name, doc in REDUCERS.items())
        for result in NAMED_RESULTS:
            yield Candidate(result.name, "constant", result.unit, result.sentence, 2)


def _values(view: View, place: Place) -> Iterator[Candidate]:
    """Yield all names with a value, and words that make one."""
    yield from _names(view, place)
    yield from (_keyword(k, 6) for k in KEYWORDS if k.role is Role.OPERATOR and k.form.startswith(k.phrase))
    yield from (Candidate(word, "keyword", rank=7) for word in ("True", "False", "None"))


def _names(view: View, place: Place) -> Iterator[Candidate]:
    yield from (_symbol(view, symbol) for symbol in view.known(place.offset).values())
    yield from (Candidate(name, "variable", "", doc, 3) for name, doc in SPECIAL_NAMES.items())
    yield from _builtins(*Kind)


def _arguments(view: View, place: Place) -> Iterator[Candidate]:
    """Yield `name=` for the arguments of the callee."""
    if place.callee < 0:
        return
    name, at = place.left[place.callee].text, place.callee
    said = place.left[at - 1].text if at else ""
    if words := MAP_ARGUMENTS.get(name) if said == "map" else _SETTINGS.get(name):
        yield from (Candidate(f"{word}=", "argument", rank=1) for word in words)
        return
    symbol = view.known(place.offset).get(name)
    if symbol is not None:
        yield from (Candidate(f"{p.name}=", "argument", symbol.form, rank=1) for p in symbol.parameters)
    elif name in BUILTINS and not BUILTINS[name].variadic:
        for p in BUILTINS[name].parameters:
            yield Candidate(f"{p.name}=", "argument", argument_text(p), BUILTINS[name].doc, 1)


def _units() -> Iterator[Candidate]:
    for unit in UNITS.values():
        yield Candidate(unit.word, "unit", dimension_name(unit.dimension), unit_text(unit.word), 2)


def _builtins(*kinds: Kind) -> Iterator[Candidate]:
    for builtin in BUILTINS.values():
        if builtin.kind in kinds:
            yield Candidate(builtin.name, builtin.kind.value, builtin.signature, builtin_text(builtin), 5)


def _is_distribution(name: str) -> bool:
    return name in BUILTINS and BUILTINS[name].kind is Kind.DISTRIBUTION


def _symbol(view: View, symbol: Symbol) -> Candidate:
    return Candidate(symbol.name, symbol.kind.value, symbol.form, symbol_text(view, symbol), 2)


def _keyword(keyword: Keyword, rank: int) -> Candidate:
    return Candidate(keyword.phrase, "keyword", keyword.form, keyword_text(keyword), rank)


def _member(member: Member) -> Candidate:
    return Candidate(member.name, "attribute", member.value_text, attribute_doc(member.name), 2)

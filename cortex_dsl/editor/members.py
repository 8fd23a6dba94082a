"""What may follow a dot: found by asking the value that stands before it.

While `lane.` is being written the text is broken. It is mended by leaving the dot out, compiled, and whatever value
stood there is asked for every attribute there is.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from cortex_dsl.editor.analysis import View, analyse
from cortex_dsl.editor.facts import described, ending_at
from cortex_dsl.editor.place import CLOSERS, Place
from cortex_dsl.semantics.errors.problems import Mistake, NeedsExpansion, Rejection
from cortex_dsl.semantics.evaluation import attributes
from cortex_dsl.semantics.evaluation.attributes import ATTRIBUTE_DOCS
from cortex_dsl.semantics.model.context import Moment, ObservedValue, ObservedValues
from cortex_dsl.semantics.model.values import EnumValue, GlobalParameters, Namespace, Value
from cortex_dsl.semantics.names.builtins import FLAGS, PROPERTIES
from engine.vocabulary import ManeuverType


@dataclass(frozen=True)
class Member:
    name: str
    worth: str = ""
    """What its value is, in one line."""


def members(view: View, place: Place) -> list[Member]:
    """Everything that may follow the dot before a place; where there is no telling, all that follows any dot."""
    for sightings in _values(view, place):
        found = [member for name in _names(sightings[0]) if (member := _asked(sightings[0], name)) is not None]
        if found:
            return found
    return [Member(name) for name in sorted({*ATTRIBUTE_DOCS, *PROPERTIES})]


def _values(view: View, place: Place) -> Iterator[ObservedValues]:
    """What stands before the dot: as the mended text has it, or as it was when the text was whole."""
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


def _while_running(sighting: ObservedValue) -> ObservedValue:
    """Any object of the scene, at a moment of the run."""
    actor = next(iter(sighting.evaluator.run.actors), None)
    return ObservedValue(sighting.evaluator.at_moment(Moment(running=True, actor=actor)), actor)


def mended(view: View, place: Place, dot: int) -> str:
    """The text without the dot and what follows it on its line, its brackets closed."""
    line = view.text.rfind("\n", 0, dot) + 1
    end = view.text.find("\n", place.offset)
    end = len(view.text) if end < 0 else end
    opened = [place.left[index] for index in reversed(place.open)]
    closers = "".join(CLOSERS[token.text] for token in opened if token.start >= line)
    rest = view.text[place.offset : end].rstrip()
    return view.text[:dot] + closers + (rest[-1:] if rest[-1:] in (",", ":") else "") + view.text[end:]


def _names(sighting: ObservedValue) -> list[str]:
    """Names worth asking for."""
    match sighting.value:
        case EnumValue():
            return [member.name for member in ManeuverType]
        case GlobalParameters():
            return list(sighting.evaluator.run.params)
        case Namespace(names=names):
            return list(names)
    return sorted({*attributes.attribute_names(), *PROPERTIES, *FLAGS})


def _asked(sighting: ObservedValue, name: str) -> Member | None:
    """The attribute of a value, if it has it."""
    evaluator = sighting.evaluator
    try:
        value: Value = attributes.get(evaluator, sighting.value, name, evaluator.algebra.span)
    except (Rejection, NeedsExpansion):
        return Member(name)
    except Mistake:
        return None
    return Member(name, described([ObservedValue(evaluator, value)]))

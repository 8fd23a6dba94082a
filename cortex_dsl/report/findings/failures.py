"""Results of a search in words; failures of the ego come first: avoidable collisions, and kinds."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from cortex_dsl.report.findings.readable import counted, percent, significant, whole
from engine.search.insight.diversity import SECTORS
from engine.search.insight.kinds import PACES, Failures, FoundKind, Kind
from engine.search.protocol import DEFAULT_OBJECTIVES
from engine.vocabulary import Blame

BLAMES = {
    Blame.AVOIDABLE: ("avoidable", "bad"),
    Blame.DISPUTED: ("disputed", "bad"),
    Blame.UNAVOIDABLE: ("not avoidable", "warn"),
    Blame.NO_MODEL: ("no model applies", "quiet"),
    Blame.STRUCK: ("ego struck", "quiet"),
    Blame.NONE: ("not judged", "quiet"),
}
"""Word and style."""
MEANING = (
    "avoidable: all reference drivers whose range covers it stop or pass in time; disputed: some of them do; ego "
    "struck: not the ego's failure"
)
ORDER_OF_RISK = "worst first, avoidable and disputed ones before others of the same risk"
ORDER_OF_OBJECTIVE = "avoidable and disputed collisions first, then other collisions, then near misses"
APART = "each partner and kind is among them before any stands there twice"
LOST = "the driver failed"
"""How a scene over which it did ended."""


def lead_text(came: Failures) -> str:
    """Return `6 avoidable collisions of 5 kinds (9 in all)`, or the most important statement instead."""
    if not came.collisions:
        return "no collision"
    if not came.judged:
        return collisions_text(came)
    lead = "no avoidable collision"
    if came.avoidable:
        lead = f"{counted(came.avoidable, 'avoidable collision')} of {counted(came.avoidable_kinds, 'kind')}"
    return lead if came.collisions == came.avoidable else f"{lead} ({came.collisions:,} in all)"


def collisions_text(came: Failures) -> str:
    """`2,170 collisions of 48 kinds`; without kinds if no collision was judged."""
    return counted(came.collisions, "collision") + _kinds_text(came)


def _kinds_text(came: Failures) -> str:
    return f" of {counted(came.kinds, 'kind')}" if came.judged else ""


def order_text(objective: Sequence[str]) -> str:
    """Return the order of the worst cases, as in `engine.search.ranking`."""
    return f"{ORDER_OF_OBJECTIVE if tuple(objective) != DEFAULT_OBJECTIVES else ORDER_OF_RISK}; {APART}"


def driver_text(came: Failures, objective: Sequence[str]) -> str:
    """`61 failures of the driver`, where the search is for these; empty where it is not, or found none."""
    return f"{counted(came.lost, 'failure')} of the driver" if came.lost and _seeks_failures(objective) else ""


def driver_failed_text(came: Failures) -> str:
    """`the driver failed in 61 simulations`, of which nothing more is known; empty where it never did."""
    return f"{LOST} in {counted(came.lost, 'simulation')}" if came.lost else ""


def rate_texts(came: Failures, seconds: float) -> Iterator[str]:
    """Yield texts on the failures per valid simulation and per time."""
    if not came.collisions:
        return
    if came.judged:
        if came.avoidable:
            share = percent(came.avoidable / came.valid, 2)
            yield f"avoidable: {share} of valid simulations{_pace(came.avoidable, seconds)}"
        else:
            yield f"avoidable: none among {came.valid:,} valid simulations"
        yield f"other verdicts: {other_verdicts_text(came)}"
    share = percent(came.collisions / came.valid)
    every = f"{came.collisions:,}{_kinds_text(came)}"
    yield f"collisions: {every}, {share} of valid simulations{_pace(came.collisions, seconds)}"


def verdicts_text(came: Failures) -> str:
    """Return `3 avoidable, 12 disputed, 56 unavoidable; 4 in which the ego was struck`."""
    struck = f"; {came.struck:,} in which the ego was struck" if came.struck else ""
    return f"{came.avoidable:,} avoidable, {other_verdicts_text(came)}{struck}"


def other_verdicts_text(came: Failures) -> str:
    """Return `12 disputed, 56 unavoidable`, and how many collisions no reference driver covers."""
    no_model = f", {came.no_model:,} that no model covers" if came.no_model else ""
    return f"{came.disputed:,} disputed, {came.unavoidable:,} unavoidable{no_model}"


def _pace(count: int, seconds: float) -> str:
    if not (seconds > 0.0 and math.isfinite(seconds)):
        return ""
    return f", {pace_text(count / seconds)} a second"


def pace_text(rate: float) -> str:
    """Return a small rate with two digits, a large rate as a whole number."""
    return whole(rate) if rate >= 10.0 else significant(rate, 2)


def others_text(came: Failures, ego: str) -> str:
    """Return the collisions without a part of the ego; empty without any."""
    parts: list[str] = []
    if came.struck:
        parts.append(f"{counted(came.struck, 'collision')}, struck from behind or while standing")
    if came.without_ego:
        parts.append(f"others touched in {counted(came.without_ego, 'run')}")
    return f"without {ego}'s part: {'; '.join(parts)}" if parts else ""


def kind_text(actors: Sequence[str], kind: Kind) -> str:
    """Return a kind as text: `van on the left, 90 deg right; ego 30 .. 50 km/h, van stands`."""
    ego, other = actors[0], actors[kind.pair + 1]
    where = f"{other} at the {kind.side.name.lower()}, {SECTORS[kind.sector]}"
    return f"{where}; {_pace_text(ego, kind.ego_speed)}, {_pace_text(other, kind.other_speed)}"


def _pace_text(name: str, pace: int) -> str:
    return f"{name} {PACES[pace]}{' km/h' if pace else ''}"


def rest_text(found: Sequence[FoundKind], shown: int) -> str:
    """`and 38 kinds more, 412 collisions`; empty where all are shown."""
    rest = found[shown:]
    more = sum(each.count for each in rest)
    return f"and {counted(len(rest), 'kind')} more, {counted(more, 'collision')}" if rest else ""


@dataclass(frozen=True)
class Finds:
    """Objective of a search, in words for its charts."""

    many: str
    verb: str
    goal: str
    """Quantity that the search maximizes."""
    one: str
    """A find, in a few words."""
    among: str = "valid"
    """Scenes that are counted."""
    among_one: str = "valid"
    """Singular of that noun."""


def finds_of(objective: Sequence[str]) -> Finds:
    """Return the words for collisions, or for the results of another objective."""
    if tuple(objective) == DEFAULT_OBJECTIVES:
        return Finds("collisions", "collide", "risk", "collision")
    if _seeks_failures(objective):
        many = "failures of the driver"
        return Finds(many, f"are {many}", objective[0], LOST, "valid and failed", "valid or failed")
    many = f"results of the objective {objective[0]}"
    return Finds(many, f"are {many}", objective[0], f"a result of the objective {objective[0]}")


def _seeks_failures(objective: Sequence[str]) -> bool:
    return tuple(objective[:1]) == ("controller",)

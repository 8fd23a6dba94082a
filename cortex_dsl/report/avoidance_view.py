"""What the reference driver makes of a search's failures, for people: which speak against the ego, and how surely."""

import math
from collections.abc import Iterator, Sequence

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.layout import columns, left, right
from cortex_dsl.report.numbers import ABSENT, counted, fixed, percent, ratio, whole
from engine.avoidability import Avoidability, Avoidance
from engine.search.insight.analysis import Analysis, Avoided

AVOIDANCES = {
    Avoidance.AVOIDABLE: ("avoidable", "good", "the reference driver would have stopped or passed in time"),
    Avoidance.UNAVOIDABLE: ("unavoidable", "bad", "the reference driver would have braked too late"),
    Avoidance.BRAKED_AS_HARD: ("braked as hard", "warn", "too late, and the ego had braked as hard itself, or stood"),
    Avoidance.UNSEEN: ("unseen", "warn", "in sight for too short a time before contact"),
}
DRIVER = (
    "UN R157: 0.4 s to perceive, 0.75 s to react, 0.774 g after 0.6 s more; it brakes along the ego's own path, no "
    "less than the ego had begun to and never harder than 0.774 g, and never steers. The regulation means cut-ins on "
    "motorways; that a conflict is in sight 4 s ahead is cortexc's choice"
)


def avoidance_view(analysis: Analysis) -> RenderableType:
    avoided = analysis.avoided
    told = {*avoided.by, *(answer.avoidance for answer in analysis.avoidability if answer is not None)}
    shares = [
        (
            Text(whole(avoided.by.get(kind, 0))),
            Text(percent(ratio(avoided.by.get(kind, 0), avoided.driven), 0)),
            Text(AVOIDANCES[kind][0], AVOIDANCES[kind][1]),
            Text(AVOIDANCES[kind][2], "quiet"),
        )
        for kind in sorted(told)
    ]
    head = f"of {counted(avoided.driven, 'different collision')} that this search kept; shares of these, no rates:"
    table = columns(right(), right(), left(), left(wrap=True), rows=shares)
    said = [Text(line, "warn") for line in system_lines(avoided)]
    return Group(Text(head), table, *_lost(avoided), *said, Text(), *_worst(analysis), Text(DRIVER, "quiet"))


def _lost(avoided: Avoided) -> Iterator[Text]:
    """How many say more about what the file draws than about the ego."""
    if lost_text(avoided):
        yield Text(lost_text(avoided), "warn")


def lost_text(avoided: Avoided) -> str:
    """`3 of them no braking avoids …`; empty where there are none."""
    if not avoided.lost:
        return ""
    return (
        f"{avoided.lost:,} of them no braking avoids, neither the driver's from any moment on nor full braking from "
        "the start: they speak of the scene drawn"
    )


def system_lines(avoided: Avoided) -> list[str]:
    """How the avoidable ones depend on params of the system that the search chose; nothing where there are none."""
    if not (avoided.by_system and avoided.avoidable):
        return []
    parts = [f"{share.name} {', '.join(f'{n:,}' for n in share.thirds)}" for share in avoided.by_system]
    where = f"of the {avoided.avoidable:,} avoidable, in the lower, middle and upper third of the range"
    return [
        f"the search chose the system's own params; {where}: {'; '.join(parts)}",
        "what is avoidable speaks against the ego with these settings; --freeze holds them",
    ]


def _worst(analysis: Analysis) -> list[RenderableType]:
    """What is said of each of the worst cases."""
    rows = [
        (Text(str(case.rank), "quiet"), Text(str(case.score)), Text(closing_text(case.closing_speed)), *_answer(answer))
        for case, answer in zip(analysis.worst, analysis.avoidability, strict=True)
        if answer is not None
    ]
    if not rows:
        return []
    head = right("#"), right("risk"), right("closing"), left("of the worst"), right("perceived"), right("contact")
    return [columns(*head, left("", wrap=True), rows=rows, header=True), Text(fastest_text(analysis), "quiet"), Text()]


def closing_text(speed: float) -> str:
    """`45 km/h`"""
    return f"{fixed(3.6 * speed, 0)} km/h" if math.isfinite(speed) else ABSENT


def fastest_text(analysis: Analysis) -> str:
    """What an order by risk may hide; empty without a contact."""
    if not math.isfinite(analysis.fastest):
        return ""
    fastest = closing_text(analysis.fastest)
    return f"risk has a top and tells no severity beyond; the fastest contact of the search closed at {fastest}"


def _answer(answer: Avoidability) -> Sequence[Text]:
    name, style, _ = AVOIDANCES[answer.avoidance]
    return (
        Text(name, style),
        Text(_seconds(answer.perceived)),
        Text(_seconds(answer.contact)),
        Text(margin_text(answer), "quiet"),
    )


def margin_text(answer: Avoidability) -> str:
    """By how much braking was early enough, or too late."""
    if math.isnan(answer.margin):
        return ""
    if math.isinf(answer.margin):
        return "braking never helps"
    if answer.avoidable:
        return f"{fixed(answer.margin, 2)} s to spare"
    if answer.margin > 0.0:
        return f"{fixed(answer.margin, 2)} s too early: who brakes later passes first"
    return f"{fixed(-answer.margin, 2)} s too late"


def _seconds(time: float) -> str:
    return f"{fixed(time, 2)} s" if math.isfinite(time) else ABSENT

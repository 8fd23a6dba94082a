"""What the reference driver makes of a search's failures, for people: which speak against the ego, and how surely."""

import math
from collections.abc import Iterator, Sequence

from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.failures import (
    AVOIDANCES,
    DRIVER,
    closing_text,
    fastest_text,
    lost_text,
    margin_text,
    system_lines,
)
from cortex_dsl.report.layout import columns, left, right
from cortex_dsl.report.numbers import ABSENT, counted, fixed, percent, ratio, whole
from engine.avoidability import Avoidability
from engine.search.analysis import Analysis, Avoided


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


def _answer(answer: Avoidability) -> Sequence[Text]:
    name, style, _ = AVOIDANCES[answer.avoidance]
    return (
        Text(name, style),
        Text(_seconds(answer.perceived)),
        Text(_seconds(answer.contact)),
        Text(margin_text(answer), "quiet"),
    )


def _seconds(time: float) -> str:
    return f"{fixed(time, 2)} s" if math.isfinite(time) else ABSENT

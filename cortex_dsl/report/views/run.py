"""One run on one screen: the closest conflict, the picture, the events, the pairs, and how to repeat it."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from cortex_dsl.report.blocks import (
    Block,
    Code,
    Column,
    Drawing,
    Note,
    Panel,
    Picture,
    Spark,
    Table,
    Title,
    Value,
    Words,
    actor_style,
    height_of,
)
from cortex_dsl.report.findings.choices import made_choices
from cortex_dsl.report.findings.objectives import ObjectiveResult, broken_words
from cortex_dsl.report.findings.readable import (
    ABSENT,
    counted,
    first_line,
    fixed,
    format_gene,
    name_of,
    short_names,
    shortened,
    significant,
)
from cortex_dsl.report.findings.run_report import HIGHEST, Conflict, RunReport, conflicts
from cortex_dsl.report.findings.story import ORDER, Moment, end_of, moment_of
from engine.metrics import Recorded
from engine.program import Program
from engine.vocabulary import Sense

LINES = 45
"""Most lines of a screen, 80 columns wide."""
PICTURE, LEAST_PICTURE = 20, 9
"""Most and fewest lines of the picture."""
EVENTS, PAIRS, RESULTS = 8, 3, 3
"""Most rows of events, of pairs, and of objectives and records each."""
NAME = 20
"""Characters of the name of an actor."""
PARAMS = 210
"""Characters of the params."""
MORE = "--metrics shows"
KIND_STYLES = {"contact": "bad", "impact": "bad", "closest": "warn", "left_road": "warn", "end": "title"}
IMPORTANCE = ("contact", "impact", "end", "closest", "left_road", "brake", "rest", "start", "fastest")
"""Kinds of events in the order in which a short list keeps them."""


def run_screen(report: RunReport) -> Title:
    """Return the view of `cortexc FILE`: at most 45 lines of 80 columns."""
    found = conflicts(report)
    below = [block for block in _below(report, found) if block is not None]
    drawing = drawing_of(report, found[0].pair if found else 0)
    rows = max(LEAST_PICTURE, min(PICTURE, LINES - 7 - sum(map(height_of, below))))
    picture = Title("Scene", [Picture([Panel(drawing)], rows)], _attempts(report))
    return title_of(report.program, [headline(report, found), picture, *below])


def with_short_names(report: RunReport) -> RunReport:
    """Return a report in which long names of actors lose their middle."""
    names = tuple(short_names(report.program.actors, NAME))
    return replace(report, program=replace(report.program, actors=names))


def title_of(program: Program, blocks: Sequence[Block]) -> Title:
    """Return a view under the name of its scenario and the first line of its docstring."""
    name = name_of(program)
    return Title(name, blocks, shortened(first_line(program.description), max(20, 150 - len(name))))


def headline(report: RunReport, found: Sequence[Conflict]) -> Note:
    """Return the closest conflict and the end of the run in one sentence."""
    end = end_of(report.program, report.outcomes, 0)
    style = "bad" if end.kind == "contact" else "good" if report.valid else "warn"
    words: list[str | Value] = []
    if report.valid and end.kind != "contact" and found and math.isfinite(found[0].distance):
        words += [*_closest(report, found[0]), "; "]
    words += [Value(end.text, style), Value("  after ", "quiet"), Value(f"{end.time:.2f} s", "quiet", end.time)]
    if report.valid and found:
        words += ["  ", Value(f"risk {report.score} of {HIGHEST}", "title", report.score, "risk.score")]
        if found[0].pair != report.pair:
            words.append(Value(f" ({report.program.actors[report.pair + 1]})", "quiet"))
    if broken := broken_words(report.objective_results):
        words.append(Value(f"  {broken}", "bad"))
    return Note(words)


def _closest(report: RunReport, closest: Conflict) -> Iterator[str | Value]:
    """Yield the words on the closest conflict: partner, distance, time, and the times that measure it."""
    yield Value(f"closest: {report.program.actors[closest.pair + 1]}, ", "warn")
    yield Value(f"{fixed(closest.distance, 2)} m", "warn", closest.distance)
    yield Value(" apart", "warn")
    if math.isfinite(closest.time):
        yield " at "
        yield Value(f"{fixed(closest.time, 2)} s", "", closest.time)
    for name, value in (("TTC", closest.ttc), ("PET", closest.pet)):
        if math.isfinite(value):
            yield f", {name} "
            yield Value(f"{fixed(value, 2)} s", "", value)


def _attempts(report: RunReport) -> Words:
    attempts = int(report.scenes.attempts[0])
    return "found after ", Value(counted(attempts, "attempt"), "", attempts, "attempts")


def _below(report: RunReport, found: Sequence[Conflict]) -> Iterator[Block | None]:
    yield _events(report, found)
    yield _pairs(report, found) if report.valid else None
    yield _objectives(report)
    yield _records(report.records)
    yield _params(report)
    alike = ", if its driver decides alike" if report.program.controls else ""
    yield Code(report.reproduce, "again", apart=True)
    yield Note(f"the same run, bit for bit{alike}; {MORE} every measure and param", "quiet")


# -- events ------------------------------------------------------------------------------------------------------------


def _events(report: RunReport, found: Sequence[Conflict]) -> Title:
    """Return the most important events in order of time."""
    story = report.story
    shown = _important(story, found[0].pair + 1 if found else 0)
    rest = len(story) - len(shown)
    more = f"; {counted(rest, 'event')} more: --metrics" if rest else ""
    note = f"simulated by the {report.engine} engine{more}"
    return Title("What happened", [timeline(shown, report.program.actors)], note)


def _important(story: Sequence[Moment], partner: int) -> list[Moment]:
    """Return up to `EVENTS` moments: those of the ego and of the closest actor first, then by kind."""

    def rank(place: int) -> tuple[bool, int, int]:
        moment = story[place]
        return moment.actor not in (-1, 0, partner), IMPORTANCE.index(moment.kind), place

    return [story[k] for k in sorted(sorted(range(len(story)), key=rank)[:EVENTS])]


def timeline(moments: Sequence[Moment], actors: Sequence[str]) -> Table:
    """Return one line per moment: time, actor, event."""
    rows = [
        (
            Value(f"{moment.time:.2f} s", "quiet", moment.time),
            Value(actors[moment.actor], actor_style(moment.actor)) if moment.actor >= 0 else "",
            Value(moment.text, KIND_STYLES.get(moment.kind, "")),
        )
        for moment in moments
    ]
    return Table((Column(numbers=True), Column(), Column(wrap=True)), rows, header=False, name="moments")


assert set(IMPORTANCE) == set(ORDER)


# -- pairs, results of the file, params --------------------------------------------------------------------------------


def _pairs(report: RunReport, found: Sequence[Conflict]) -> Block | None:
    """Return the conflicts with further actors, the closest first; None with a single other actor."""
    if len(found) < 2:
        return None
    rows = [_pair(report.program, each) for each in found[:PAIRS]]
    rest = len(found) - len(rows)
    columns = (
        Column(),
        Column("least distance", numbers=True),
        Column("at", numbers=True, rank=2),
        Column("TTC", numbers=True),
        Column("PET", numbers=True, rank=1),
    )
    note = f"the closest conflict first; {rest:,} more: --metrics" if rest else "the closest conflict first"
    return Title(f"{report.program.actors[0]} and …", [Table(columns, rows, name="pairs")], note)


def _pair(program: Program, each: Conflict) -> tuple[Words, ...]:
    name = Value(program.actors[each.pair + 1], actor_style(each.pair + 1))
    if not math.isfinite(each.distance):
        return name, Value("never met", "quiet"), "", "", ""
    apart = Value("contact", "bad") if each.contact else Value(f"{fixed(each.distance, 2)} m", "", each.distance)
    times = [_seconds(value) for value in (each.time, each.ttc, each.pet)]
    return name, apart, *times


def _seconds(value: float) -> Value:
    return Value(f"{fixed(value, 2)} s", "", value) if math.isfinite(value) else Value(ABSENT, "quiet")


def _objectives(report: RunReport) -> Block | None:
    found = report.objective_results
    if not found:
        return None
    first = sorted(found, key=lambda each: not each.broken)[:RESULTS]
    rest = f"; {len(found) - len(first):,} more: --metrics" if len(found) > len(first) else ""
    return Title("Objectives", [objectives_table(first)], f"above 0 an expectation is kept{rest}")


def objectives_table(found: Sequence[ObjectiveResult]) -> Table:
    """Return name, verdict and margin of each expectation; the value of a number."""
    rows: list[tuple[Words, ...]] = []
    for each in found:
        value = Value(f"{significant(each.value)} {each.unit}".strip(), "", each.value)
        if each.sense is Sense.EXPECT:
            verdict = Value("broken", "bad") if each.broken else Value("kept", "good")
            rows.append((Value(each.name, "title"), verdict, ("robustness ", value)))
        else:
            rows.append((Value(each.name, "title"), Value(each.sense.name.lower(), "quiet"), value))
    return Table((Column(wrap=True), Column(), Column(numbers=True)), rows, header=False, name="objectives")


WHEN = {"initial": "at the start", "final": "at the end"}


def _records(records: Sequence[Recorded]) -> Block | None:
    if not records:
        return None
    rest = f"; {len(records) - RESULTS:,} more: --metrics" if len(records) > RESULTS else ""
    return Title("Records", [records_table(records[:RESULTS])], f"up to contact or the end{rest}")


def records_table(records: Sequence[Recorded], *, drawn: bool = False) -> Table:
    """Return name, moment, and the value or the range of each record; `drawn`: with the course over time."""
    rows = [
        (Value(each.name, "title"), _course(each) if drawn else WHEN.get(each.when, "over time"), _extent(each))
        for each in records
    ]
    return Table((Column(wrap=True), Column(style="quiet"), Column(numbers=True)), rows, header=False, name="records")


def _course(record: Recorded) -> Words:
    return WHEN.get(record.when) or Spark(style="bar", values=record.values.tolist())


def _extent(record: Recorded) -> Words:
    """Return the value, or the range of the values that are numbers."""
    known = record.values[~np.isnan(record.values)]
    if not len(known):
        return ABSENT
    ends = dict.fromkeys((float(known.min()), float(known.max())))
    texts = [Value(significant(end), "", end) for end in ends]
    unit = Value(f" {record.unit}" if record.unit else "", "unit")
    return (texts[0], unit) if len(texts) == 1 or texts[0].text == texts[1].text else (texts[0], " .. ", texts[1], unit)


def _params(report: RunReport) -> Block | None:
    """Return the params, those held fixed, and the choices in one paragraph."""
    space, genome = report.program.space, report.scenes.genomes[0]
    parts: list[tuple[str | Value, ...]] = [
        (
            f"{name} ",
            Value(format_gene(space, gene, float(genome[gene])), "title", float(genome[gene])),
            Value(f" {space.units[gene]}".rstrip(), "unit"),
        )
        for gene, name in enumerate(space.names)
    ]
    parts += [(f"{one.name} ", Value(f"{one.text} {one.unit}".strip()), " held") for one in report.held]
    parts += [(f"{name} ", Value(option)) for name, option in made_choices(report.program, report.scenes)]
    if not parts:
        return None
    words: list[str | Value] = []
    shown = length = 0
    for part in parts:
        length += sum(len(each if isinstance(each, str) else each.text) for each in part) + 2
        if length > PARAMS and shown:
            break
        words += [", "] * bool(words) + list(part)
        shown += 1
    rest = len(parts) - shown
    return Title("Params", [Note(words)], f"{rest:,} more: --metrics" if rest else "")


# -- the picture -------------------------------------------------------------------------------------------------------


def drawing_of(report: RunReport, pair: int) -> Drawing:
    """Return the run from above at contact, else at the closest approach of a pair."""
    moment = moment_of(report.outcomes, report.trajectory, pair)
    return Drawing(report.road, report.program.actors, report.trajectory, moment, pair, report.program.code.actor_kind)

"""Sections of a run's page: results in words, where it failed, probability of a collision, endings, repetition."""

from collections.abc import Iterator, Sequence
from shlex import quote
from typing import Any, NamedTuple

import numpy as np

from cortex_dsl.report.blocks import Code, Facts, Note, Title
from cortex_dsl.report.findings.analysis_report import HeatMap, heat_maps
from cortex_dsl.report.findings.case_replay import StoredRun
from cortex_dsl.report.findings.failures import (
    LOST,
    Finds,
    driver_failed_text,
    driver_text,
    finds_of,
    other_verdicts_text,
    others_text,
    rate_texts,
)
from cortex_dsl.report.findings.probability_report import (
    SAMPLE_TIME,
    avoidable_interval_text,
    avoidable_text,
    counts_text,
    exposure_text,
    how_drawn,
    how_text,
    interval_text,
    probability_text,
    unknown_text,
)
from cortex_dsl.report.findings.readable import counted, duration, fixed, percent, ratio
from cortex_dsl.report.findings.search_report import (
    End,
    ends_of,
    first_collision,
    limits,
    method_name,
    objective_words,
    whole_run,
    why_invalid,
    worst_words,
)
from cortex_dsl.report.page import markup, run_charts
from cortex_dsl.report.page.markup import Element, Node, element, figure, folded, part, prose, table
from cortex_dsl.report.page.render import nodes
from engine.driving.names import as_options
from engine.search.evaluations import Evaluations, distinct_collisions
from engine.search.insight.kinds import Failures
from engine.search.journal_reader import Record
from engine.search.probability.estimates import Probability, read_estimates
from engine.search.result_files import collisions_by_partner
from engine.search.store import without_folders
from engine.tables import Ints
from engine.vocabulary import EndReason, Verdict

# -- in plain words: the object and effort of the search, its results, and their limits --------------------------------


def paragraphs(record: Record, came: Failures, system: Sequence[str] = ()) -> Iterator[Node]:
    """Yield the results in a few sentences, then the object, the effort, the counts and the limits on demand."""
    yield element("p", list(_found(record, came)), class_="lead-text")
    yield folded("What was searched, and how much", _searched(record), _how_much(record))
    yield folded("All counts", _counts(record, came))
    listed = element("ul", [element("li", prose(text)) for text in limits(record, system)])
    yield folded("What this does not show", listed)


def _searched(record: Record) -> Node:
    manifest = record.manifest
    genes = [f"{p.name} ({_range(p)})" for p in manifest.parameters]
    others = ", ".join(manifest.actors[1:]) or "no other actor"
    return element(
        "p",
        f"The scenario {manifest.name}, in which {manifest.actors[0]} drives with {others}. "
        f"The search could choose {counted(len(genes), 'param')}: {', '.join(genes)}. "
        f"Everything else that the file leaves open was drawn at random for each scene.",
    )


def _range(parameter: Any) -> str:
    if parameter.options:
        return ", ".join(parameter.options)
    return f"{parameter.low:g} to {parameter.high:g} {parameter.unit}".strip()


def _how_much(record: Record) -> Node:
    manifest, search = record.manifest, record.manifest.settings["search"]
    everyone, simulated = whole_run(record)
    preset, name = f" (preset {manifest.preset})" if manifest.preset else "", method_name(manifest.method)
    planned = search["generations"]
    cut = "" if len(record.generations) == planned else f" of {planned:,} planned"
    took = f" It took {duration(record.seconds)}." if record.seconds == record.seconds else ""
    return element(
        "p",
        f"{name[:1].upper()}{name[1:]}{preset}, seed {manifest.seed}: ",
        f"{counted(len(record.generations), 'generation')}{cut} of {search['population']:,}, ",
        figure("by_individual.individuals", everyone.individuals, counted(everyone.individuals, "individual")),
        ". ",
        figure("by_simulation.runs", simulated.runs, counted(simulated.runs, "simulation")),
        " were distinct",
        "; the others repeat the best of the previous generation." if record.evaluations.reused.any() else ".",
        took,
    )


def _found(record: Record, came: Failures) -> Iterator[Node]:
    """Yield the results in sentences: collisions, those that a competent driver avoids, partners, objectives."""
    _, simulated = whole_run(record)
    hit, valid = simulated.colliding_runs, simulated.valid_runs
    if not valid and not came.lost:
        yield f"No simulation was valid, so nothing is known{why_invalid(record)}."
        return
    yield "The ego collided in "
    yield figure("by_simulation.colliding_runs", hit, f"{hit:,}")
    yield " of "
    yield figure("by_simulation.valid_runs", valid, counted(valid, "valid simulation"))
    yield f" ({percent(ratio(hit, valid))}). " if valid else ". "
    if came.judged and hit:
        yield "All reference drivers avoid "
        yield figure("failures.avoidable", came.avoidable, f"{came.avoidable:,}")
        yield " of these collisions"
        if came.avoidable:
            yield ", which are of "
            yield figure("failures.avoidable_kinds", came.avoidable_kinds, counted(came.avoidable_kinds, "kind"))
        yield f"; {other_verdicts_text(came)}. "
    if failed := driver_text(came, record.manifest.objective) or driver_failed_text(came):
        yield f"{failed[0].upper()}{failed[1:]}. "
    yield from _partners(record)
    yield objective_words(record)


def _counts(record: Record, came: Failures) -> Node:
    _, simulated = whole_run(record)
    distinct, first = distinct_collisions(record.evaluations), first_collision(record)
    finds = finds_of(record.manifest.objective)
    more = (*rate_texts(came, record.seconds), others_text(came, record.manifest.actors[0]))
    return element(
        "p",
        figure("distinct_collisions", distinct, counted(distinct, "set")),
        f" of params {'collides' if distinct == 1 else 'collide'}. ",
        [f"{text[0].upper()}{text[1:]}. " for text in more if text],
        f"The first collision came with simulation {first:,}. " if first else "",
        figure("by_simulation.nis", simulated.nis, counted(simulated.nis, "individual")),
        f" ({percent(ratio(simulated.nis, simulated.individuals))})",
        f" {'was' if simulated.nis == 1 else 'were'} invalid{why_invalid(record)}. ",
        worst_words(record),
        f" The mean {finds.goal} of a {finds.among_one} simulation is ",
        figure("by_simulation.rl", simulated.rl, fixed(simulated.rl, 2)),
        ".",
    )


def _partners(record: Record) -> Iterator[Node]:
    """Yield the collisions by partner if there are several possible partners: a search may have missed one."""
    actors = record.manifest.actors
    if len(actors) < 3:
        return
    counts = collisions_by_partner(record.evaluations, actors)
    yield "By partner: "
    for number, (name, count) in enumerate(counts["collisions_with"].items()):
        yield f"{', ' if number else ''}{name} "
        yield figure(f"collisions_with.{name}", count, f"{count:,}")
    if count := counts["collisions_without_ego"]:
        yield "; without the ego "
        yield figure("collisions_without_ego", count, f"{count:,}")
    yield ". "


# -- probability of a collision: estimates next to the journal, or the command for one ---------------------------------

NOTE = (
    "Given a valid run, when every param is drawn from its distribution in the file. "
    "The results of a search say nothing about this: it samples where it has found danger. Also, "
)
HEAD = ("a collision", "one a competent driver avoids", "how it is drawn", "from", "valid draws")


def likely(run: StoredRun) -> Element:
    """Return the section on the probability of a collision.

    Raises:
        StoreError: the estimates cannot be read.
    """
    found = read_estimates(run.folder, run.scenario.program.digest)
    note = f"{NOTE}{'; '.join(filter(None, (exposure_text(run.scenario.program), SAMPLE_TIME)))}."
    if found:
        rows = table(HEAD, [_row(each) for each in found], "likely")
        return part("probability", "How probable is it?", None, rows, folded("How this is determined", note))
    driver = run.record.manifest.driver
    words = ["cortexc probability", quote(without_folders(str(run.folder))), as_options(driver.name) if driver else ""]
    command = element("pre", " ".join(filter(None, words)), class_="command")
    missing = element("p", "Not estimated yet. This command estimates it, and the next report shows it:", class_="note")
    return part("probability", "How probable is it?", None, missing, command, folded("How this is determined", note))


def _row(found: Probability) -> Element:
    level = percent(found.level, 0)
    return element(
        "tr",
        _number("th", probability_text(found), f"{level}: {interval_text(found)}"),
        _number("td", avoidable_text(found), f"{level}: {avoidable_interval_text(found)}"),
        element("td", how_drawn(found), element("br"), element("small", how_text(found), class_="quiet")),
        element("td", counts_text(found), *((element("br"), unknown_text(found)) if found.lost else ())),
        element("td", percent(found.valid_share), class_="number quiet"),
    )


def _number(tag: str, value: str, interval: str) -> Element:
    return element(tag, value, element("br"), element("small", interval, class_="quiet"), class_="number")


# -- how the runs ended, and how to repeat all of it -------------------------------------------------------------------

STREAMS = (
    "seed.method.run.generation.index.rollout: each scene draws from its own stream, so results depend neither on "
    "threads nor on order"
)


def ends(run: StoredRun) -> Element:
    rows, whole = how_runs_ended(run)
    note = "Every distinct simulation, by how it ended."
    return part("ends", "How runs ended", note, run_charts.bars(rows, whole))


def how_runs_ended(run: StoredRun) -> tuple[list[tuple[str, int, str]], int]:
    """Return (words, count, style) of each ending, most frequent first, and their number."""
    rows = [(*_words(end), end.count) for end in ends_of(run.scenario.program, run.record.evaluations)]
    return [(text, count, style) for text, style, count in rows], sum(count for _, _, count in rows)


def _words(end: End) -> tuple[str, str]:
    if end.verdict == Verdict.CONTROLLER:
        return end.text, "hit"
    if end.reason is None:
        return run_charts.VERDICTS[end.verdict], "invalid"
    crash = end.reason in (EndReason.COLLISION, EndReason.BUILDING)
    style = "hit" if crash else "" if end.verdict == Verdict.VALID else "invalid"
    return end.text, style


def again(run: StoredRun) -> Element:
    manifest, folder = run.record.manifest, without_folders(str(run.folder))
    command = markup.command_again(manifest.command_line) if manifest.command_line else ""
    facts = [
        ("file", manifest.file),
        ("digest of the text", manifest.file_digest),
        ("digest of the program", manifest.program_digest),
        ("seed, run", f"{manifest.seed}, {manifest.run}"),
        ("risk profile", manifest.profile),
        ("versions", ", ".join(f"{name} {version}" for name, version in manifest.versions.items())),
        ("platform", manifest.platform),
        ("stream keys", STREAMS),
    ]
    settings = [
        (f"{group}.{name}", str(value)) for group, table in manifest.settings.items() for name, value in table.items()
    ]
    changed = " has changed since this run was started; the text below is that of the run."
    blocks = [
        *map(Code, filter(None, (command, f"cortexc report {quote(str(folder))}"))),
        *(Note(f"{name}{changed}") for name in run.edited),
        Facts(facts),
        Title("Every setting", [Facts(settings)], folded=True),
    ]
    text = element("details", element("summary", "The scenario"), element("pre", manifest.file_text, class_="source"))
    note = "The same command gives the same journal, row by row."
    return part("again", "Reproduce it", note, [nodes(block) for block in blocks], text)


DOTS = 12_000
"""Individuals that the map of all simulations shows at most."""
INVALID, VALID, LOSS, FIND = range(4)
"""Kinds of dots, in the order in which they are drawn."""


class Dot(NamedTuple):
    """A kind of dot."""

    colour: str
    """Colour variable of the stylesheet."""
    key: str
    """Name in the plural."""
    words: str
    """Name in the singular, before the risk."""


def _dots_of(finds: Finds) -> tuple[Dot, ...]:
    return (
        Dot("--invalid", "invalid", "invalid"),
        Dot("--safe-dot", "other valid ones", ""),
        Dot("--warn", LOST, LOST),
        Dot("--hot", finds.many, finds.one),
    )


def dots(record: Record) -> dict[str, Any]:
    """Return all distinct simulations for the map, or a subset that fits.

    A subset holds finds, at most half of it, and every n-th of the remaining simulations.
    """
    evaluations = record.evaluations
    rows = _shown(evaluations)
    values = evaluations.genomes[rows]
    return {
        "genes": [
            {"name": p.name, "unit": p.unit, "low": p.low, "high": p.high, "options": list(p.options)}
            for p in record.manifest.parameters
        ],
        "values": [[float(f"{value:.4g}") for value in column] for column in values.T.tolist()],
        "kinds": [dot._asdict() for dot in _dots_of(finds_of(record.manifest.objective))],
        "kind": _kinds(evaluations)[rows].tolist(),
        "score": evaluations.score[rows].tolist(),
        "place": evaluations.places[rows].tolist(),
    }


def _kinds(evaluations: Evaluations) -> Ints:
    """Return the kind (n,) of each individual."""
    lost = evaluations.verdict == Verdict.CONTROLLER
    return np.select([evaluations.found, lost, evaluations.valid], [FIND, LOSS, VALID], INVALID)


def _shown(evaluations: Evaluations) -> np.ndarray:
    rows = np.flatnonzero(evaluations.simulated)
    if len(rows) <= DOTS:
        return rows
    hit = rows[evaluations.found[rows]][-DOTS // 2 :]
    others = np.setdiff1d(rows, hit)
    return np.sort(np.concatenate([hit, others[:: -(-len(others) // (DOTS - len(hit)))]]))


def where_it_fails(record: Record) -> Iterator[Node]:
    """Yield the section of a run's page on the places of failures; nothing if no pair of params can be shown."""
    parameters = record.manifest.parameters
    maps, finds = heat_maps(parameters, record.evaluations), finds_of(record.manifest.objective)
    if maps:
        key = element(
            "p",
            element("span", element("i", class_="none"), f"none of those tried {finds.verb}"),
            element("span", "few ", element("i", class_="ramp"), f"all {finds.verb}"),
            element("span", element("i", class_="blank"), "never tried"),
            class_="key",
        )
        note = (
            f"Pairs of params, the most informative about which simulations {finds.verb} first (mutual information, "
            f"with Miller's correction). The shade is the share of the {finds.among} simulations in a cell that "
            f"{finds.verb}."
        )
        charts = [
            element(
                "figure",
                element(
                    "figcaption",
                    element("b", f"{chart.across.name} × {chart.up.name}"),
                    element("span", f"{fixed(chart.information, 2)} bit", class_="total"),
                ),
                run_charts.heat_chart(chart, finds.verb),
                class_="panel",
            )
            for chart in maps
        ]
        panels = element("div", charts, class_="panels")
        yield part("space", "Where it fails", note, key, panels, _explorer(record, maps[0], finds))


def _explorer(record: Record, best: HeatMap, finds: Finds) -> Element:
    names = [p.name for p in record.manifest.parameters]

    def select(chosen: str, label: str) -> Element:
        options = [element("option", name, value=k, selected=name == chosen) for k, name in enumerate(names)]
        return element("label", f"{label} ", element("select", options))

    shown, every = len(_shown(record.evaluations)), int(record.evaluations.simulated.sum())
    title = "Every simulation" if shown == every else f"{shown:,} of {every:,} simulations"
    idle = "Point at a dot to read it."
    there = set(_kinds(record.evaluations).tolist()) | {FIND, VALID, INVALID}
    keys = [dot for kind, dot in enumerate(_dots_of(finds)) if kind in there]
    return element(
        "div",
        element(
            "div",
            element("b", title),
            select(best.across.name, "across"),
            select(best.up.name, "up"),
            [
                element("span", element("i", style=f"background:var({dot.colour})"), dot.key, class_="dot-key")
                for dot in reversed(keys)
            ],
            class_="choose",
        ),
        element("canvas", role="img", aria_label="a dot for each simulation, by two params"),
        element("p", idle, class_="tip", data_idle=idle),
        class_="explorer panel",
    )

"""What a notebook shows: scenes, runs and searches as SVG and HTML, by the same drawings as the pages.

    >>> scenario.show(scenario.sample(1))           # where everybody starts
    >>> scenario.replay(scenario.sample(1))         # the run of it, which plays
    >>> campaign = scenario.search("ga")
    >>> scenario.show(campaign)                     # what a search found
    >>> scenario.show(campaign.worst[0])            # one of its cases, which plays

What comes back is displayed by notebooks, and its `save` writes it to a file.

`scenes_html`, `outcomes_html`, `world_run_html`, `campaign_html`, `columns_html`, `opened_run_html` and
`diagnostics_html` make the display of what Python is handed (see `cortex_dsl.api.displays`); they are plain functions
from a value to HTML that needs no style sheet of its own.
"""

from base64 import b64encode
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from cortex_dsl.api.arguments import row_of
from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.report.findings.case_replay import Runnable
from cortex_dsl.report.findings.readable import (
    ABSENT,
    counted,
    fixed,
    format_gene,
    percent,
    ratio,
    significant,
    speed_unit,
)
from cortex_dsl.report.findings.search_report import headline, method_name
from cortex_dsl.report.findings.snippet import draw, errors_first
from cortex_dsl.report.findings.story import aftermath, end_of, in_order, story_of
from cortex_dsl.report.page.markup import Element, Node, element, picture, render
from cortex_dsl.report.page.scene_svg import scene_drawing
from cortex_dsl.source import Source
from engine.outcomes import Outcomes
from engine.program import ParamSpace, Program
from engine.scenes import Scenes
from engine.search.journal_reader import Record
from engine.search.protocol import Box
from engine.search.ranking import Case, worst_cases
from engine.search.run import Campaign
from engine.tables import Floats
from engine.vocabulary import EndReason, Verdict

if TYPE_CHECKING:
    from engine.world import WorldRun

HEIGHT = 640
"""Of a page inside a notebook [px]."""


class OpenedRun(Protocol):
    """A run on disk, as far as its display needs it: see `cortex_dsl.api.runs.OpenedRun`."""

    @property
    def folder(self) -> Path: ...
    @property
    def record(self) -> Record: ...
    @property
    def scenario(self) -> Runnable: ...


@dataclass(frozen=True)
class Shown:
    """Something to look at: markup for a notebook, and the text of a file."""

    html: str
    text: str

    def _repr_html_(self) -> str:
        return self.html

    def save(self, path: str | Path) -> Path:
        """Write it as a file of its own."""
        Path(path).write_text(self.text, encoding="utf-8")
        return Path(path)


@dataclass(frozen=True)
class Picture:
    """A drawing: notebooks show it as SVG."""

    svg: str

    def _repr_svg_(self) -> str:
        return self.svg

    def save(self, path: str | Path) -> Path:
        """Write it as a file of its own."""
        Path(path).write_text(self.svg, encoding="utf-8")
        return Path(path)


def show(scenario: Runnable, thing: Any, row: int = 0) -> Picture | Shown:
    """One of some scenes as a picture, a case as a page that plays, a campaign as a table of what it found.

    Raises:
        TypeError: it is nothing of these.
    """
    if isinstance(thing, Scenes):
        return Picture(picture(scene_drawing(scenario.program, thing, row_of(thing, row))))
    if isinstance(thing, Case):
        from cortex_dsl.report.findings.case_replay import replay_case
        from cortex_dsl.report.page.case_page import case_page

        return _framed(case_page(replay_case(scenario, scenario.scene(thing)), thing))
    if isinstance(thing, Campaign):
        html = render(campaign_table(thing))
        return Shown(html, html)
    raise TypeError(f"expected scenes, a case or a campaign, got {type(thing).__name__}")


def replay(scenario: Runnable, scenes: Scenes, row: int = 0) -> Shown:
    """One valid scene run in the world host, as a page that plays."""
    from cortex_dsl.report.findings.case_replay import replay_case
    from cortex_dsl.report.page.case_page import case_page
    from engine.search.assessment import take

    return _framed(case_page(replay_case(scenario, take(scenes, slice(row, row + 1)))))


def _framed(page: str) -> Shown:
    """A page inside a notebook, apart from its styles and scripts."""
    frame = f'<iframe srcdoc="{escape(page)}" style="width:100%;height:{HEIGHT}px;border:0" loading="lazy"></iframe>'
    return Shown(frame, page)


def campaign_table(campaign: Campaign) -> Element:
    """What a search found, in a few rows."""
<<<<<<< HEAD
    return element("table", element("tbody", [_row(*row) for row in (*_facts(campaign), *_first_cases(campaign))]))
=======
    return element("table", element("tbody", [_row(*row) for row in campaign.facts()]))
>>>>>>> main


def _row(name: str, value: str) -> Element:
    return element("tr", element("th", name, style="text-align:left"), element("td", value))


<<<<<<< HEAD
def _facts(campaign: Campaign) -> Iterator[tuple[str, str]]:
    found, simulated = campaign.by_individual, campaign.by_simulation
    yield "method", f"{campaign.method} {campaign.preset}".strip()
    yield "individuals, distinct simulations", f"{found.individuals:,}, {simulated.runs:,}"
    yield "different collisions", f"{campaign.distinct_collisions:,}"
    yield "mean risk, mean least distance", f"{found.rl:.2f}, {found.mdg:.2f} m"
    yield "invalid", f"{found.nis:,}"


def _first_cases(campaign: Campaign) -> Iterator[tuple[str, str]]:
    for case in campaign.worst[:3]:
        genome = zip(campaign.space.names, case.genome, strict=True)
        yield f"worst case {case.rank}", f"risk {case.score}: " + ", ".join(f"{n} {v:.4g}" for n, v in genome)


# -- the display of a value --------------------------------------------------------------------------------------------

MOST_ROWS = 10
"""Rows of a table that are shown."""
STYLES = {
    "error": "color:#b3261e;font-weight:bold",
    "warning": "color:#8a5a00;font-weight:bold",
    "note": "color:#0b6bb0;font-weight:bold",
    "hint": "color:#0b6bb0;font-weight:bold",
    "message": "font-weight:bold",
    "gutter": "color:#8b9198",
    "secondary": "color:#0b6bb0",
    "help": "color:#2f7d4f;font-weight:bold",
}
"""Of the pieces of a drawn diagnostic, on light and on dark ground."""


def scenes_html(program: Program, scenes: Scenes) -> str:
    """How many scenes are valid, the first of them with their params, and the first valid one from above."""
    head = ("", "verdict", *(_titled(*pair) for pair in zip(program.space.names, program.space.units, strict=True)))
    rows = [
        (str(row), _verdict(scenes.verdict[row]), *_genes(program.space, scenes.genomes[row]))
        for row in range(min(MOST_ROWS, len(scenes)))
    ]
    valid = np.flatnonzero(scenes.valid)
    drawing = scene_drawing(program, scenes, int(valid[0])) if len(valid) else None
    title = f"{counted(len(scenes), 'scene')} of {program.name}, {_of_all(len(valid), len(scenes))} valid"
    return _shown(title, _rows(head, rows, len(scenes)), _figure(drawing, f"scene {valid[0]}" if len(valid) else ""))


def outcomes_html(program: Program, outcomes: Outcomes) -> str:
    """How many runs collided, how they ended, and the first of them with the metrics of the nearest pair."""
    ends = [EndReason(reason).name.lower().replace("_", " ") if reason >= 0 else "" for reason in outcomes.end_reason]
    pairs = bool(outcomes.min_distance.shape[1])
    head = ("", "verdict", "end", "time [s]", *(("nearest", "MD [m]") if pairs else ()))
    rows = [
        (
            str(row),
            _verdict(outcomes.verdict[row]),
            ends[row],
            fixed(float(outcomes.end_time[row]), 2),
            *(_nearest(program, outcomes.min_distance[row]) if pairs else ()),
        )
        for row in range(min(MOST_ROWS, len(outcomes)))
    ]
    valid = outcomes.verdict == Verdict.VALID
    collided = int((valid & outcomes.collided).sum())
    title = f"{counted(len(outcomes), 'run')} of {program.name}: {int(valid.sum()):,} valid, "
    title += f"{counted(collided, 'collision')}, {percent(ratio(collided, int(valid.sum())))} of the valid"
    return _shown(title, _rows(head, rows, len(outcomes)))


def world_run_html(program: Program, run: "WorldRun") -> str:
    """What happened in one run, moment by moment, and how its metrics came out."""
    pair = int(np.argmin(run.outcomes.min_distance[0])) if run.outcomes.min_distance.shape[1] else 0
    driven = story_of(program, run.outcomes, run.trajectory, 0, pair, speed_unit(program))
    moments = in_order([*driven, *aftermath(program, run.impacts, run.trajectory)])
    rows = [
        (f"{moment.time:.2f} s", program.actors[moment.actor] if moment.actor >= 0 else "", moment.text)
        for moment in moments
    ]
    end = end_of(program, run.outcomes, 0)
    title = f"{end.text} after {fixed(end.time, 2)} s"
    return _shown(title, _rows(("time", "who", "what"), rows, len(rows)))


def campaign_html(program: Program, campaign: Campaign) -> str:
    """What a search found."""
    found = campaign.by_simulation
    share = f", {percent(found.collision_rate)}" if found.colliding_runs else ""
    method = method_name(campaign.method)
    title = f"{program.name}, {method}: {counted(found.colliding_runs, 'collision')} in "
    title += f"{counted(found.valid_runs, 'valid simulation')}{share}"
    facts = element("table", element("tbody", [_row(*row) for row in _facts(campaign)]))
    return _shown(title, facts, _worst_cases(campaign.space, campaign.worst))


def opened_run_html(run: OpenedRun) -> str:
    """What a search on disk found, and where it lies."""
    manifest, record = run.record.manifest, run.record
    rows = [
        ("folder", str(run.folder)),
        ("method", f"{method_name(manifest.method)} {manifest.preset}".strip()),
        ("generations", f"{len(record.generations):,} of {manifest.config.search.generations:,}, {record.status}"),
        ("seed", str(manifest.seed)),
    ]
    facts = element("table", element("tbody", [_row(*row) for row in rows]))
    cases = worst_cases(record.evaluations, MOST_ROWS, Box.of(run.scenario.program.space))
    return _shown(headline(record), facts, _worst_cases(run.scenario.program.space, cases))


def columns_html(columns: Mapping[str, np.ndarray]) -> str:
    """A table of columns by name: its first rows."""
    length = len(next(iter(columns.values()))) if columns else 0
    rows = [tuple(_cell(column[row]) for column in columns.values()) for row in range(min(MOST_ROWS, length))]
    title = f"{counted(length, 'row')} of {counted(len(columns), 'column')}"
    return _shown(title, _rows(tuple(columns), rows, length))


def diagnostics_html(source: Source, diagnostics: Sequence[Diagnostic], width: int = 100) -> str:
    """Diagnostics with their source lines and carets in colour, errors first."""
    blocks = [_drawn(source, diagnostic, width) for diagnostic in errors_first(diagnostics)]
    return render([element("pre", block, style="white-space:pre-wrap;line-height:1.35") for block in blocks])


def _drawn(source: Source, diagnostic: Diagnostic, width: int) -> Iterator[Node]:
    grave = {"primary": diagnostic.severity.value, "severity": diagnostic.severity.value}
    for line in draw(source, diagnostic, width):
        for text, style in line:
            css = STYLES.get(grave.get(style, style))
            yield element("span", text, style=css) if css else text
        yield "\n"


def _shown(title: str, *parts: Node) -> str:
    return render(element("div", element("p", element("b", title)), *parts))


def _rows(head: Sequence[str], rows: Sequence[Sequence[str]], total: int) -> Node:
    """A table, and how many rows more there are."""
    top = element("tr", [element("th", text) for text in head])
    body = [element("tr", [element("td", text) for text in row]) for row in rows]
    more = f"and {total - len(rows):,} more" if total > len(rows) else ""
    table = element("table", element("thead", top), element("tbody", body))
    return [table, element("p", element("small", more)) if more else None]


def _figure(drawing: Element | None, caption: str) -> Node:
    if drawing is None:
        return None
    image = b64encode(picture(drawing).encode()).decode()
    source = f"data:image/svg+xml;base64,{image}"
    return element("img", src=source, alt=f"{caption} from above", style="max-width:420px;width:100%", title=caption)


def _worst_cases(space: ParamSpace, cases: Sequence[Case]) -> Node:
    if not cases:
        return None
    head = ("case", "risk", "least distance [m]", *map(_titled, space.names, space.units))
    rows = [
        (str(case.rank), str(case.score), fixed(case.min_distance, 2), *_genes(space, np.array(case.genome)))
        for case in cases
    ]
    return _rows(head, rows, len(rows))


def _titled(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _verdict(verdict: int) -> str:
    return Verdict(int(verdict)).name.lower()


def _genes(space: ParamSpace, genome: Floats) -> Iterator[str]:
    return (format_gene(space, gene, float(value)) for gene, value in enumerate(genome))


def _nearest(program: Program, distances: Floats) -> tuple[str, str]:
    """To whom the ego came nearest, and how near."""
    if not np.isfinite(distances).any():
        return "", ABSENT
    pair = int(np.nanargmin(distances))
    return program.actors[pair + 1], fixed(float(distances[pair]), 2)


def _of_all(count: int, total: int) -> str:
    return "all" if count == total and total else "none" if not count else f"{count:,}"


def _cell(value: Any) -> str:
    return significant(float(value)) if isinstance(value, float | np.floating) else str(value)


=======
>>>>>>> main
def scenario_table(scenario: Runnable) -> Element:
    """A scenario's name, its actors and its params, with one of its scenes."""
    space = scenario.program.space
    rows = [
        _row(name, ", ".join(options) if options else f"{low:g} to {high:g} {unit}")
        for name, unit, low, high, options in zip(
            space.names, space.units, space.low.tolist(), space.high.tolist(), space.options, strict=True
        )
    ]
    return element(
        "div",
        element("b", scenario.program.name),
        element("p", ", ".join(scenario.program.actors)),
        element("table", element("tbody", rows)),
    )

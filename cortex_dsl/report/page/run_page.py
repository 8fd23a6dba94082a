"""The report of one search: a page for decision makers and for the responsible engineer."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from cortex_dsl.report.findings.analysis_report import analysis_content, heat_map_content, heat_maps
from cortex_dsl.report.findings.case_replay import CaseReplay, StoredRun, case_content, outline_corners, replay_of_case
from cortex_dsl.report.findings.cases_found import kinds_of_cases
from cortex_dsl.report.findings.failures import finds_of, order_text
from cortex_dsl.report.findings.framing import CARD, Frame, alike
from cortex_dsl.report.findings.judgement import judged_content
from cortex_dsl.report.findings.readable import counted, first_line
from cortex_dsl.report.findings.search_report import headline, method_name, search_content, unfinished, whole_run
from cortex_dsl.report.page import analysis_sections, case_page, run_charts, run_sections, scene_svg
from cortex_dsl.report.page.markup import Element, Node, element, figure, page, part, top_bar
from cortex_dsl.report.page.player import SCRIPTS, player_data
from cortex_dsl.report.page.render import words_of
from cortex_dsl.report.views.search import kind_lines
from engine.risk import HIGHEST_RISK
from engine.search.insight.analysis import BUDGET, Analysis, analyse
from engine.search.journal_reader import Record
from engine.search.probability.estimates import read_estimates
from engine.search.ranking import WORST, Case, worst_cases
from engine.search.result_files import failures_content
from engine.search.store import without_folders
from engine.streams import format_key
from engine.strict_json import plain
from engine.vocabulary import State

Answered = TypeVar("Answered")
CASES = 10
"""Cases that a page replays."""
LINKS = (
    ("#summary", "Summary"),
    ("#kinds", "Kinds"),
    ("#cases", "Worst cases"),
    ("#course", "Course"),
    ("#space", "Where it fails"),
    ("#probability", "Probability"),
    ("#params", "Params"),
    ("#again", "Reproduce it"),
)


@dataclass(frozen=True)
class RunPage:
    """Everything that the page shows."""

    run: StoredRun
    worst: tuple[Case, ...]
    replays: tuple[CaseReplay, ...]
    analysis: Analysis

    @property
    def record(self) -> Record:
        return self.run.record


def run_page(run: StoredRun, cases: int = CASES, budget: int = BUDGET) -> str:
    """The page of a run, as text; `budget` simulations find out which params matter (0: none)."""
    chosen = run.first_cases(cases)
    replays = tuple(replay_of_case(run, case) for case in chosen)
    record, scenario = run.record, run.scenario
    profile = record.manifest.profile
    analysis = analyse(scenario.program, record.evaluations, scenario.config, profile, budget, WORST, run.blame)
    return render_page(RunPage(run, chosen, replays, analysis))


def render_page(found: RunPage) -> str:
    """The page as text."""
    record, manifest = found.record, found.record.manifest
    parts = [part for part in _parts(found) if isinstance(part, Element)]
    names = {part.attributes["id"] for part in parts}
    body = [
        top_bar([(place, name) for place, name in LINKS if place[1:] in names]),
        element("main", _hero(found), parts, _footer(found)),
    ]
    data = {
        "run": plain(content(found)),
        "replays": [player_data(replay) for replay in found.replays],
        "evaluations": plain(run_sections.dots(found.record)),
    }
    return page(f"{manifest.name}: {method_name(manifest.method)}", body, data, ("page.js", *SCRIPTS), record.link)


def content(found: RunPage) -> dict[str, Any]:
    """Every number of the page, for programs that read it."""
    record, program = found.record, found.run.scenario.program
    return {
        **search_content(program, record),
        **failures_content(found.analysis.came, found.analysis.kinds, program.actors, record.seconds),
        "cases": [
            {
                **case_content(replay, case),
                "avoidability": _of_case(found, case, found.analysis.avoidability),
                **judged_content(_of_case(found, case, found.analysis.judged)),
                "opinion": _opinion(found, case) or None,
            }
            for case, replay in zip(found.worst, found.replays, strict=True)
        ],
        "analysis": analysis_content(program.space, found.analysis),
        "heat_maps": [heat_map_content(each) for each in heat_maps(record.manifest.parameters, record.evaluations)],
        "probability": read_estimates(found.run.folder, program.digest),
    }


def _hero(found: RunPage) -> Element:
    record, manifest = found.record, found.record.manifest
    description = first_line(found.run.scenario.program.description)
    kicker = f"Search for corner cases · {method_name(manifest.method)}"
    return element(
        "header",
        element("p", f"{manifest.name} · {kicker}" if description else kicker, class_="kicker"),
        element("h1", description or manifest.name),
        _unfinished(record),
        element("p", headline(record, found.analysis.came), class_="headline"),
        element("div", list(_tiles(found)), class_="tiles"),
        class_="hero",
    )


def _unfinished(record: Record) -> Node:
    words = unfinished(record)
    said = f"This search {words}: the page shows what its journal holds so far."
    return element("p", said, class_="note") if words else None


def _tiles(found: RunPage) -> Iterator[Element]:
    """Yield four figures: failures of the ego, all collisions, their kinds (or the highest risk), and the effort."""
    record = found.record
    _, simulated = whole_run(record)
    came = found.analysis.came
    style, hot = ("hot" if count else "" for count in (came.collisions, came.avoidable))
    if came.lost:
        yield _tile("failures.lost", came.lost, f"{came.lost:,}", "simulations in which the driver failed", "hot")
    elif came.judged:
        yield _tile("failures.avoidable", came.avoidable, f"{came.avoidable:,}", "avoidable collisions", hot)
    else:
        yield _tile("by_simulation.nis", simulated.nis, f"{simulated.nis:,}", "invalid individuals")
    yield _tile("failures.collisions", came.collisions, f"{came.collisions:,}", "simulations that collided", style)
    if came.judged and came.collisions:
        yield _tile("failures.kinds", came.kinds, f"{came.kinds:,}", "kinds of collisions", style)
    else:
        score = int(record.evaluations.score.max())
        yield _tile("worst.score", score, f"{score}", f"highest risk, of {HIGHEST_RISK}", style)
    yield _tile("by_simulation.runs", simulated.runs, f"{simulated.runs:,}", "distinct simulations")


def _tile(name: str, value: float, text: str, meaning: str, style: str = "") -> Element:
    number = element("b", figure(name, value, text))
    return element("div", number, element("span", meaning), class_=f"tile {style}".strip())


def _parts(found: RunPage) -> Iterator[Node]:
    yield element(
        "section",
        element("h2", "What was found"),
        list(run_sections.paragraphs(found.record, found.analysis.came, found.analysis.system)),
        id="summary",
        class_="part",
    )
    space, analysis = found.run.scenario.program.space, found.analysis
    yield analysis_sections.kinds(found.record.manifest.actors, analysis, _pictures(found))
    yield _cases(found)
    yield _course(found)
    yield from run_sections.where_it_fails(found.record)
    yield analysis_sections.places(space, analysis)
    yield analysis_sections.avoided(analysis)
    yield analysis_sections.grids(analysis)
    yield run_sections.likely(found.run)
    goal = finds_of(found.record.manifest.objective).goal
    yield analysis_sections.params(space, analysis, found.record.evaluations, goal)
    yield run_sections.ends(found.run)
    yield run_sections.again(found.run)


def _pictures(found: RunPage) -> Node:
    """Return one picture per kind of collision among the replayed cases, with its count; all have one scale."""
    record, actors = found.record, found.record.manifest.actors
    if not found.replays:
        return None
    drawings = dict(zip(found.worst, thumbnails(found.replays), strict=True))
    kinds = kinds_of_cases(record.evaluations, found.run.blame, found.analysis.kinds, found.worst)
    figures = [
        element(
            "figure",
            element("a", drawings[case], href=f"#case-{case.rank}", class_="case-link"),
            element("figcaption", [element("span", words_of(line)) for line in kind_lines(actors, kind, case)]),
            class_="panel kind",
        )
        for kind, case in kinds
    ]
    return [shared_road(found.replays[0]), element("div", figures, class_="panels")] if figures else None


def _cases(found: RunPage) -> Node:
    if not found.replays:
        return None
    note = (
        f"{_lost_words(found)}{order_text(found.record.manifest.objective).capitalize()}. {_numbers_words(found)} "
        "Every replay is the simulation itself, run again. "
        "Space plays and pauses, the arrows step, plus and minus change the speed, c follows the ego, v shows "
        "what it sees and what is hidden from it."
    )
    tabs = [
        element(
            "li",
            element(
                "a",
                element("span", f"Case {case.rank} ", element("small", _case_words(found, case))),
                href=f"#case-{case.rank}",
                class_="case-tab",
                data_case=case.rank,
            ),
        )
        for case in found.worst
    ]
    cards = [
        case_page.card(replay, _place(found, case), number)
        for number, (case, replay) in enumerate(zip(found.worst, found.replays, strict=True))
    ]
    return part("cases", "The worst cases", note, element("ol", tabs, class_="tabs"), cards)


def _lost_words(found: RunPage) -> str:
    """Return the worst cases without a replay, since the driver failed; empty without any."""
    lost = [case.rank for case in worst_cases(found.record.evaluations, WORST, found.run.blame) if case.lost]
    if not lost:
        return ""
    ranks = f"case {lost[0]}" if len(lost) == 1 else f"cases {lost[0]} to {lost[-1]}"
    return (
        f"Over {ranks} the driver failed, so that there is no replay: `controller.log` says how, and the files in "
        "`worst` run them again. These are the worst others. "
    )


def _numbers_words(found: RunPage) -> str:
    """Return a note on the numbers of the cases; scenes with a failed driver may have the first numbers."""
    if found.worst[-1].rank <= WORST:
        return "Their numbers are those of the files in the run's folder `worst`."
    return "Their numbers are their ranks; the files in the run's folder `worst` are the first ones."


def _case_words(found: RunPage, case: Case) -> str:
    """Return a case's words, as in `risk 22, truck`; the partner is named if there are several."""
    actors, pair = found.record.manifest.actors, int(found.record.evaluations.rollouts.pair[case.row, case.rollout])
    if len(actors) > 2 and pair >= 0:
        return f"risk {case.score}, {'' if case.collided else 'near '}{actors[pair + 1]}"
    return f"risk {case.score}{', collision' if case.collided else ''}"


def _place(found: RunPage, case: Case) -> case_page.Place:
    analysis = found.analysis
    careful, judged = _of_case(found, case, analysis.avoidability), _of_case(found, case, analysis.judged)
    return case_page.Place(case, found.run.folder, careful, judged, _opinion(found, case))


def _of_case(found: RunPage, case: Case, answers: Sequence[Answered | None]) -> Answered | None:
    """Return the answer to a case; None if no reference driver drove it."""
    rows = zip(found.analysis.worst, answers, strict=True)
    return next((answer for other, answer in rows if other.row == case.row), None)


def _opinion(found: RunPage, case: Case) -> str:
    """Return the result of `cortexc verify --model dynamic` for a case; "" without one."""
    return found.run.opinions.get(format_key(case.key), "")


def _course(found: RunPage) -> Element:
    key = element(
        "p",
        element("span", element("i", class_="line"), "all individuals, as in the paper"),
        element("span", element("i", class_="dashes"), "new simulations only"),
        element("span", element("i", class_="patch"), "middle half of the individuals"),
        class_="key",
    )
    note = "The five metrics of the CORTEX-AVD paper, generation by generation; the number is that of the whole run."
    return part(
        "course",
        "The course of the search",
        note,
        element(
            "details",
            element("summary", "Show the curves"),
            key,
            element("div", list(run_charts.metric_charts(found.record)), class_="panels"),
        ),
    )


def _footer(found: RunPage) -> Element:
    manifest = found.record.manifest
    version = manifest.versions.get("cortexc", "")
    return element(
        "footer",
        f"Written by cortexc from the journal in {without_folders(str(found.run.folder))} "
        f"({counted(len(found.record.evaluations), 'individual')}; "
        f"searched with version {version}). This file needs no network and contains all its data.",
    )


ROAD = "road"
"""Name of the road that all pictures of a page share."""
POINTS = 40
"""Maximum number of points of a way in a small picture."""


def shared_road(replay: CaseReplay) -> Element:
    """Return the road, drawn once for all pictures of its page."""
    road = scene_svg.road_layer(replay.road)
    return element("svg", element("defs", element("g", road, id=ROAD)), class_="shared", aria_hidden="true")


def thumbnails(replays: Sequence[CaseReplay]) -> list[Element]:
    """Return one picture per case: the ego, its nearest actor, and the ways of all actors."""
    frames = alike([_close(replay) for replay in replays])
    return [_thumbnail(replay, frame) for replay, frame in zip(replays, frames, strict=True)]


def _close(replay: CaseReplay) -> Frame:
    """Return the frame around the deciding pair at the key moment."""
    points = [corner for actor in {0, replay.pair + 1} for corner in _corners(replay, actor)]
    return Frame.around(np.array(points or [(0.0, 0.0)]), replay.heading, CARD)


def _corners(replay: CaseReplay, actor: int) -> Iterator[tuple[float, float]]:
    if actor < len(replay.shapes):
        state, shape = replay.trajectory.states[replay.key_sample, actor], replay.shapes[actor]
        x, y, heading = (float(value) for value in state[[State.X, State.Y, State.HEADING]])
        if state[State.PRESENT] > 0.5 and np.isfinite(x + y + heading):
            yield from outline_corners(x, y, heading, shape.length, shape.width)


def _thumbnail(replay: CaseReplay, frame: Frame) -> Element:
    ways = [way[:: max(1, -(-len(way) // POINTS))] for way in replay.ways]
    layers: list[Node] = [
        element("use", href=f"#{ROAD}"),
        scene_svg.way_layer(ways),
        scene_svg.actor_layer(replay.shapes, replay.trajectory.states[replay.key_sample]),
        scene_svg.contact_mark(*replay.contact_point) if replay.contact_point else None,
    ]
    return scene_svg.scene(frame, f"{replay.program.name} at its key moment", *layers, compass=False)

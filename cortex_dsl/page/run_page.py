"""The report of one search: a page for whoever decides, and for the engineer who has to answer for it."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from shlex import join, quote
from typing import Any

import numpy as np

from cortex_dsl.page import case_card, run_charts, summary, understanding
from cortex_dsl.page.case import ToldCase, tell_case
from cortex_dsl.page.document import page
from cortex_dsl.page.element import Element, Node, element
from cortex_dsl.page.heat import HeatMap, heat_maps
from cortex_dsl.page.cases import WORST, first_cases
from cortex_dsl.page.understanding import part
from cortex_dsl.report.numbers import counted, fixed
from cortex_dsl.report.sample_view import first_line
from cortex_dsl.report.story import end_text
from cortex_dsl.runs import OpenedRun
from engine.avoidability import Avoidability
from engine.risk import HIGHEST_RISK
from engine.search.analysis import BUDGET, Analysis, analyse
from engine.search.evaluations import Evaluations
from engine.search.figures import distinct_collisions
from engine.search.journal import finite
from engine.search.journal_reader import Record
from engine.search.ranking import Case
from engine.vocabulary import EndReason, Verdict

CASES = 10
"""Cases that a page replays."""
DOTS = 12_000
"""Individuals that the map of all simulations shows at most."""
SCRIPTS = ("page.js", "replay.js")


@dataclass(frozen=True)
class RunPage:
    """Everything that the page shows."""

    run: OpenedRun
    worst: tuple[Case, ...]
    told: tuple[ToldCase, ...]
    analysis: Analysis

    @property
    def record(self) -> Record:
        return self.run.record


def run_page(run: OpenedRun, cases: int = CASES, budget: int = BUDGET) -> str:
    """The page of a run, as text; `budget` simulations find out which params matter (0: none)."""
    chosen = first_cases(run.record, cases)
    told = tuple(told_case(run, case) for case in chosen)
    record, scenario = run.record, run.scenario
    analysis = analyse(scenario.program, record.evaluations, scenario.config, record.manifest.profile, budget, WORST)
    return render_page(RunPage(run, chosen, told, analysis))


def told_case(run: OpenedRun, case: Case) -> ToldCase:
    """One case of a run, run again."""
    manifest = run.record.manifest
    remark = f"case {case.rank} of a search in {manifest.file}: risk {case.score}"
    scenes = run.scenario.scene(case)
    return tell_case(run.scenario, scenes, manifest.profile, remark, f"{case.rank:02d}.scn")


def render_page(found: RunPage) -> str:
    """The page as text."""
    manifest = found.record.manifest
    body = [
        _bar(found),
        element("main", _hero(found), list(_parts(found)), _footer(found)),
    ]
    data = {
        "run": finite(numbers(found.record, found.worst)),
        "replays": [case_card.player_data(told) for told in found.told],
        "evaluations": finite(dots(found.record)),
    }
    return page(f"{manifest.name}: {summary.method_name(manifest.method)}", body, data, SCRIPTS)


def numbers(record: Record, worst: Sequence[Case]) -> dict[str, Any]:
    """Every number of the run by its name in the journal, for programs that read the page."""
    manifest = record.manifest
    everyone, simulated = summary.whole_run(record)
    return {
        "name": manifest.name,
        "method": manifest.method,
        "preset": manifest.preset,
        "seed": manifest.seed,
        "program_digest": manifest.program_digest,
        "status": record.status,
        "seconds": record.seconds,
        "distinct_collisions": distinct_collisions(record.evaluations),
        "by_individual": asdict(everyone),
        "by_simulation": asdict(simulated),
        "generations": [asdict(row) for row in record.generations],
        "cases": [{**asdict(case), "key": list(case.key)} for case in worst],
    }


def dots(record: Record) -> dict[str, Any]:
    """All distinct simulations for the map, or as many as it takes: every collision, and every n-th of the others."""
    evaluations = record.evaluations
    rows = _shown(evaluations)
    kind = np.where(evaluations.collided, 2, np.where(evaluations.valid, 1, 0))[rows]
    values = evaluations.genomes[rows]
    return {
        "genes": [
            {"name": p.name, "unit": p.unit, "low": p.low, "high": p.high, "options": list(p.options)}
            for p in record.manifest.parameters
        ],
        "values": [[_short(value) for value in column] for column in values.T.tolist()],
        "kind": kind.tolist(),
        "score": evaluations.score[rows].tolist(),
        "place": evaluations.places[rows].tolist(),
    }


def _short(value: float) -> float:
    """To be drawn: four digits."""
    return float(f"{value:.4g}")


def _shown(evaluations: Evaluations) -> np.ndarray:
    rows = np.flatnonzero(evaluations.simulated)
    if len(rows) <= DOTS:
        return rows
    hit = rows[evaluations.collided[rows]][-DOTS // 2 :]
    others = np.setdiff1d(rows, hit)
    return np.sort(np.concatenate([hit, others[:: -(-len(others) // (DOTS - len(hit)))]]))


def _bar(found: RunPage) -> Element:
    links = [
        ("#summary", "Summary"),
        ("#cases", "Worst cases"),
        ("#course", "Course"),
        ("#space", "Where it fails"),
        ("#again", "Do it again"),
    ]
    return element(
        "nav",
        element(
            "div",
            element("span", "cortexc", class_="brand"),
            [element("a", name, href=place) for place, name in links],
            element("button", "dark", type="button", class_="theme", title="light or dark"),
            class_="top",
        ),
        class_="bar-top",
    )


def _hero(found: RunPage) -> Element:
    record, manifest = found.record, found.record.manifest
    everyone, simulated = summary.whole_run(record)
    description = first_line(found.run.scenario.program.description)
    return element(
        "header",
        element("p", f"Search for corner cases · {summary.method_name(manifest.method)}", class_="kicker"),
        element("h1", manifest.name),
        element("p", description, class_="description") if description else None,
        _unfinished(record),
        element("p", summary.headline(record), class_="headline"),
        element("div", list(_tiles(found)), class_="tiles"),
        class_="hero",
    )


def _unfinished(record: Record) -> Node:
    if record.status == "finished":
        return None
    words = "was stopped before its last generation" if record.status == "stopped" else "is not finished"
    return element("p", f"This search {words}: the page shows what its journal holds so far.", class_="note")


def _tiles(found: RunPage) -> Iterator[Element]:
    record = found.record
    _, simulated = summary.whole_run(record)
    distinct = distinct_collisions(record.evaluations)
    different = len(found.analysis.distinct)
    yield _tile("distinct_collisions", distinct, f"{distinct:,}", "sets of params that led to a collision", "hot")
    yield _tile("distinct_failures", different, f"{different:,}", "clearly different failures among them", "hot")
    if simulated.valid:
        score = int(record.evaluations.score.max())
        yield _tile("worst.score", score, f"{score}", f"highest risk, of {HIGHEST_RISK}", "hot")
    yield _tile("by_simulation.rl", simulated.rl, fixed(simulated.rl, 2), "mean risk of a valid simulation")
    yield _tile("by_simulation.nis", simulated.nis, f"{simulated.nis:,}", "invalid, could not be run")
    yield _tile("by_simulation.runs", simulated.runs, f"{simulated.runs:,}", "distinct simulations")


def _tile(name: str, value: float, text: str, meaning: str, style: str = "") -> Element:
    number = element("b", summary.figure(name, value, text))
    return element("div", number, element("span", meaning), class_=f"tile {style}".strip())


def _parts(found: RunPage) -> Iterator[Node]:
    yield element(
        "section",
        element("h2", "In plain words"),
        element("div", list(summary.paragraphs(found.record, len(found.analysis.distinct), found.analysis.system)), class_="answers"),
        id="summary",
        class_="part",
    )
    yield _cases(found)
    yield _course(found)
    yield from _space(found)
    space, analysis = found.run.scenario.program.space, found.analysis
    yield understanding.kinds(space, analysis)
    yield understanding.avoided(analysis)
    yield understanding.grids(analysis)
    yield understanding.params(space, analysis, found.record.evaluations)
    yield _ends(found)
    yield _again(found)


def _cases(found: RunPage) -> Node:
    if not found.told:
        return None
    note = (
        "Worst first, no two of them nearly the same; their numbers are those of the files in the run's folder `worst`. "
        "Every replay is the simulation itself, run again. "
        "Space plays and pauses, the arrows step, + and − change the speed, c comes closer."
    )
    tabs = [
        element(
            "li",
            element(
                "a",
                f"Case {case.rank} ",
                element("small", f"risk {case.score}{', collision' if case.collided else ''}"),
                href=f"#case-{case.rank}",
                class_="case-tab",
                data_case=case.rank,
            ),
        )
        for case in found.worst
    ]
    cards = [
        case_card.card(told, case_card.Place(case, found.run.folder, _answer(found, case)), number)
        for number, (case, told) in enumerate(zip(found.worst, found.told, strict=True))
    ]
    return part("cases", "The worst cases", note, element("ol", tabs, class_="tabs"), cards)


def _answer(found: RunPage, case: Case) -> Avoidability | None:
    """What the reference driver says of a case, if it was asked."""
    answers = zip(found.analysis.worst, found.analysis.avoidability, strict=True)
    return next((answer for other, answer in answers if other.row == case.row), None)


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
        key,
        element("div", list(run_charts.metric_charts(found.record)), class_="panels"),
    )


def _space(found: RunPage) -> Iterator[Node]:
    record = found.record
    parameters = record.manifest.parameters
    maps = heat_maps(parameters, record.evaluations)
    if maps:
        key = element(
            "p",
            element("span", "none collide ", element("i", class_="ramp"), "all collide"),
            element("span", "blank: never tried"),
            class_="key",
        )
        note = (
            "Pairs of params, those first that tell the most about whether the ego collides (mutual information, with "
            "Miller's correction). The shade is the share of valid simulations in a cell that collided."
        )
        charts = [
            element(
                "figure",
                element(
                    "figcaption",
                    element("b", f"{chart.across.name} × {chart.up.name}"),
                    element("span", f"{fixed(chart.information, 2)} bit", class_="total"),
                ),
                run_charts.heat_chart(chart),
                class_="panel",
            )
            for chart in maps
        ]
        panels = element("div", charts, class_="panels")
        yield part("space", "Where it fails", note, key, panels, _explorer(found, maps[0]))


def _explorer(found: RunPage, best: HeatMap) -> Element:
    names = [p.name for p in found.record.manifest.parameters]

    def select(chosen: str, label: str) -> Element:
        options = [element("option", name, value=k, selected=name == chosen) for k, name in enumerate(names)]
        return element("label", f"{label} ", element("select", options))

    idle = "Point at a dot to read it."
    keys = (("--hot", "collision"), ("--safe-dot", "valid, no collision"), ("--invalid", "invalid"))
    return element(
        "div",
        element(
            "div",
            element("b", "Every simulation"),
            select(best.across.name, "across"),
            select(best.up.name, "up"),
            [
                element("span", element("i", style=f"background:var({colour})"), text, class_="dot-key")
                for colour, text in keys
            ],
            class_="choose",
        ),
        element("canvas", role="img", aria_label="a dot for each simulation, by two params"),
        element("p", idle, class_="tip", data_idle=idle),
        class_="explorer panel",
    )


def _ends(found: RunPage) -> Element:
    rows, whole = how_runs_ended(found.run)
    note = "Every distinct simulation, by what became of it."
    return part("ends", "How runs ended", note, run_charts.bars(rows, whole))


def how_runs_ended(run: OpenedRun) -> tuple[list[tuple[str, int, str]], int]:
    """(words, count, style) of each end, most frequent first, and how many there are."""
    evaluations = run.record.evaluations
    runs = evaluations.rollouts
    new = np.repeat(evaluations.simulated[:, np.newaxis], runs.verdict.shape[1], axis=1)
    verdict, reason, rule = runs.verdict[new], runs.end_reason[new], runs.end_rule[new]
    ends, counts = np.unique(np.stack([verdict, reason, rule]), axis=1, return_counts=True)
    rows = [(*_end(run, *end), int(count)) for end, count in zip(ends.T.tolist(), counts.tolist(), strict=True)]
    return [(text, count, style) for text, style, count in sorted(rows, key=lambda row: -row[2])], len(verdict)


def _end(run: OpenedRun, verdict: int, reason: int, rule: int) -> tuple[str, str]:
    program = run.scenario.program
    if verdict == Verdict.VALID or reason >= 0:
        style = "hit" if reason == EndReason.COLLISION else "" if verdict == Verdict.VALID else "invalid"
        return end_text(program, EndReason(reason), rule), style
    return run_charts.VERDICTS[Verdict(verdict)], "invalid"


def _again(found: RunPage) -> Element:
    manifest, folder = found.record.manifest, found.run.folder
    command = join(("cortexc", *manifest.command_line)) if manifest.command_line else ""
    facts = [
        ("file", manifest.file),
        ("digest of the text", manifest.file_digest),
        ("digest of the program", manifest.program_digest),
        ("seed, run", f"{manifest.seed}, {manifest.run}"),
        ("risk profile", manifest.profile),
        ("versions", ", ".join(f"{name} {version}" for name, version in manifest.versions.items())),
        ("platform", manifest.platform),
        (
            "stream keys",
            "seed.method.run.generation.index.rollout: each scene draws from a stream of its own, so results depend neither on threads nor on order",
        ),
    ]
    settings = [
        element("tr", element("th", f"{group}.{name}", scope="row"), element("td", str(value)))
        for group, table in manifest.settings.items()
        for name, value in table.items()
    ]
    rows = [element("tr", element("th", name, scope="row"), element("td", value)) for name, value in facts]
    edited = [
        element(
            "p",
            f"{name} says something else today than when this run was started; the text below is that of the run.",
            class_="note",
        )
        for name in found.run.edited
    ]
    return part(
        "again",
        "Do it again",
        "The same command gives the same journal, row by row.",
        element("pre", command, class_="command") if command else None,
        element("pre", f"cortexc report {quote(str(folder))}", class_="command"),
        edited,
        element("div", element("table", element("tbody", rows), class_="facts"), class_="wide"),
        element(
            "details", element("summary", "Every setting"), element("table", element("tbody", settings), class_="facts")
        ),
        element("details", element("summary", "The scenario"), element("pre", manifest.file_text, class_="source")),
    )


def _footer(found: RunPage) -> Element:
    manifest = found.record.manifest
    version = manifest.versions.get("cortexc", "")
    return element(
        "footer",
        f"Written by cortexc from the journal in {found.run.folder} ({counted(len(found.record.evaluations), 'individual')}; "
        f"searched with version {version}). This file needs no network and holds all its data.",
    )

"""The report of one search: a page for whoever decides, and for the engineer who has to answer for it."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from shlex import join, quote
from typing import Any

import numpy as np

from cortex_dsl.page import case_card, run_charts, summary
from cortex_dsl.page.case import ToldCase, tell_case
from cortex_dsl.page.document import page
from cortex_dsl.page.element import Element, Node, element
from cortex_dsl.page.heat import heat_maps
from cortex_dsl.page.unlike import box_of, unlike_cases
from cortex_dsl.report.numbers import counted, fixed, significant
from cortex_dsl.report.sample_view import first_line
from cortex_dsl.report.story import end_text
from cortex_dsl.runs import OpenedRun
from engine.risk import HIGHEST_RISK
from engine.search.evaluations import Evaluations
from engine.search.figures import distinct_collisions
from engine.search.genes import GeneEffect, gene_effects
from engine.search.journal import finite
from engine.search.journal_reader import Record
from engine.search.ranking import Case
from engine.vocabulary import EndReason, Verdict

CASES = 8
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

    @property
    def record(self) -> Record:
        return self.run.record


def run_page(run: OpenedRun, cases: int = CASES) -> str:
    """The page of a run, as text."""
    chosen = unlike_cases(run.record, cases)
    told = tuple(told_case(run, case) for case in chosen)
    return render_page(RunPage(run, chosen, told))


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
    links = [("#summary", "Summary"), ("#cases", "Worst cases"), ("#course", "Course"), ("#space", "Where it fails"), ("#again", "Do it again")]
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
    yield _tile("distinct_collisions", distinct, f"{distinct:,}", "different collisions of the ego", "hot")
    if simulated.valid:
        score = int(record.evaluations.score.max())
        yield _tile("worst.score", score, f"{score}", f"highest risk, of {HIGHEST_RISK}", "hot")
    yield _tile("by_simulation.rl", simulated.rl, fixed(simulated.rl, 2), "mean risk of a valid simulation")
    yield _tile("by_simulation.mdg", simulated.mdg, f"{fixed(simulated.mdg, 2)} m", "mean least distance")
    yield _tile("by_simulation.nis", simulated.nis, f"{simulated.nis:,}", "invalid, could not be run")
    yield _tile("by_simulation.runs", simulated.runs, f"{simulated.runs:,}", "distinct simulations")


def _tile(name: str, value: float, text: str, meaning: str, style: str = "") -> Element:
    number = element("b", summary.figure(name, value, text))
    return element("div", number, element("span", meaning), class_=f"tile {style}".strip())


def _part(name: str, title: str, note: Node, *content: Node) -> Element:
    return element("section", element("h2", title), element("p", note, class_="note"), content, id=name, class_="part")


def _parts(found: RunPage) -> Iterator[Node]:
    yield element(
        "section",
        element("h2", "In plain words"),
        element("div", list(summary.paragraphs(found.record)), class_="answers"),
        id="summary",
        class_="part",
    )
    yield _cases(found)
    yield _course(found)
    yield from _space(found)
    yield _ends(found)
    yield _again(found)


def _cases(found: RunPage) -> Node:
    if not found.told:
        return None
    note = (
        "Each is the worst that differs from all before it in at least a third of the params by a tenth of their range. "
        "Numbers count all cases of the run, worst first. Every replay is the simulation itself, run again. "
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
        case_card.card(told, case_card.Place(case, found.run.folder), number)
        for number, (case, told) in enumerate(zip(found.worst, found.told, strict=True))
    ]
    return _part("cases", "The worst cases", note, element("ol", tabs, class_="tabs"), cards)


def _course(found: RunPage) -> Element:
    key = element(
        "p",
        element("span", element("i", class_="line"), "all individuals, as in the paper"),
        element("span", element("i", class_="dashes"), "new simulations only"),
        element("span", element("i", class_="patch"), "middle half of the individuals"),
        class_="key",
    )
    note = "The five metrics of the CORTEX-AVD paper, generation by generation; the number is that of the whole run."
    return _part("course", "The course of the search", note, key, element("div", list(run_charts.metric_charts(found.record)), class_="panels"))


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
        yield _part("space", "Where it fails", note, key, panels, _explorer(found))
    if parameters:
        yield _genes(found)


def _explorer(found: RunPage) -> Element:
    names = [p.name for p in found.record.manifest.parameters]
    best = heat_maps(found.record.manifest.parameters, found.record.evaluations, 1)[0]

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


def _genes(found: RunPage) -> Element:
    record = found.record
    evaluations = record.evaluations
    effects = gene_effects(box_of(record), evaluations)
    hit = evaluations.simulated & evaluations.collided
    rows = [
        element(
            "tr",
            element("th", effect.name, scope="row"),
            element("td", _signed(effect.correlation), class_="number"),
            element("td", _within(found, gene, effect)),
            element(
                "td",
                run_charts.strip(
                    evaluations.genomes[hit, gene], record.manifest.parameters[gene].low, record.manifest.parameters[gene].high
                ),
            ),
        )
        for gene, effect in enumerate(effects)
    ]
    note = (
        "Trend: Spearman's rank correlation with the risk among valid simulations, −1 to +1. It also shows what the "
        "search bred for, and is no proof of cause."
    )
    head = [element("th", text, scope="col") for text in ("param", "trend", "the worst tenth lies within", "where collisions lie in its range")]
    table = element("table", element("thead", element("tr", head)), element("tbody", rows), class_="genes")
    return _part("params", "What each param did", note, element("div", table, class_="wide"))


def _signed(value: float) -> str:
    return "–" if value != value else f"{value:+.2f}".replace("-", "−")


def _within(found: RunPage, gene: int, effect: GeneEffect) -> str:
    parameter = found.record.manifest.parameters[gene]
    low, high = effect.worst
    if low != low:
        return "–"
    if parameter.options:
        return ", ".join(dict.fromkeys(parameter.options[int(value)] for value in (low, high)))
    return f"{significant(low, 3)} to {significant(high, 3)} {parameter.unit}".strip()


def _ends(found: RunPage) -> Element:
    rows, whole = how_runs_ended(found)
    note = "Every distinct simulation, by what became of it."
    return _part("ends", "How runs ended", note, run_charts.bars(rows, whole))


def how_runs_ended(found: RunPage) -> tuple[list[tuple[str, int, str]], int]:
    """(words, count, style) of each end, most frequent first, and how many there are."""
    evaluations = found.record.evaluations
    runs = evaluations.rollouts
    new = np.repeat(evaluations.simulated[:, np.newaxis], runs.verdict.shape[1], axis=1)
    verdict, reason, rule = runs.verdict[new], runs.end_reason[new], runs.end_rule[new]
    ends, counts = np.unique(np.stack([verdict, reason, rule]), axis=1, return_counts=True)
    rows = [(*_end(found, *end), int(count)) for end, count in zip(ends.T.tolist(), counts.tolist(), strict=True)]
    return [(text, count, style) for text, style, count in sorted(rows, key=lambda row: -row[2])], len(verdict)


def _end(found: RunPage, verdict: int, reason: int, rule: int) -> tuple[str, str]:
    program = found.run.scenario.program
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
        ("stream keys", "seed.method.run.generation.index.rollout: each scene draws from a stream of its own, so results depend neither on threads nor on order"),
    ]
    settings = [
        element("tr", element("th", f"{group}.{name}", scope="row"), element("td", str(value)))
        for group, table in manifest.settings.items()
        for name, value in table.items()
    ]
    rows = [element("tr", element("th", name, scope="row"), element("td", value)) for name, value in facts]
    edited = [
        element("p", f"{name} says something else today than when this run was started; the text below is that of the run.", class_="note")
        for name in found.run.edited
    ]
    return _part(
        "again",
        "Do it again",
        "The same command gives the same journal, row by row.",
        element("pre", command, class_="command") if command else None,
        element("pre", f"cortexc report {quote(str(folder))}", class_="command"),
        edited,
        element("div", element("table", element("tbody", rows), class_="facts"), class_="wide"),
        element("details", element("summary", "Every setting"), element("table", element("tbody", settings), class_="facts")),
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

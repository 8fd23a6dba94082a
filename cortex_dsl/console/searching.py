"""Progress and results of a search, shared by the command line and the session."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import nan
from typing import TYPE_CHECKING

from cortex_dsl.console.request import CompileRequest
from cortex_dsl.console.terminal import Terminal
from cortex_dsl.report.findings.readable import significant
from cortex_dsl.report.findings.search_report import RANDOM
from cortex_dsl.report.terminal.progress import SearchProgress
from engine.program import Program
from engine.search.campaign import Campaign, OnGeneration, Progress
from engine.search.insight.independent import DrawsSoFar
from engine.search.journal_reader import Record
from engine.search.protocol import DEFAULT_OBJECTIVES

if TYPE_CHECKING:
    from cortex_dsl.report.findings.cases_found import CaseFound, KindShown, Searched
    from cortex_dsl.report.findings.search_report import SearchReport

SHOWN_KINDS = 3
"""Kinds of collisions with a picture on the screen of a search."""


@contextmanager
def watched(terminal: Terminal, method: str, total: int, record: Record | None = None) -> Iterator[OnGeneration]:
    """Show the progress of a search; `record` holds its earlier part."""
    before = [each.by_individual for each in record.generations] if record else []
    with SearchProgress(terminal.err, method, total, before, spent=record.spent if record else 0.0) as progress:
        draws = DrawsSoFar(method if method == RANDOM else "")
        if record is not None:
            draws.add(record.evaluations)

        def on_generation(done: Progress) -> None:
            progress.rate = draws.add(done.evaluations)
            best = nan
            if done.best is not None:
                best = done.best.score if done.objective == DEFAULT_OBJECTIVES else done.best.continuous
            progress.generation_done(done.figures.by_individual, done.simulations, best)
            if done.generation == 0 and is_constant(done):
                terminal.note(constant_line(done), "warn")

        yield on_generation


def cases_and_kinds(
    scenario: "Searched | None", campaign: Campaign
) -> "tuple[Sequence[CaseFound], Sequence[KindShown]]":
    """Return the worst cases and the kinds of collisions, driven again where the scenario is known."""
    from cortex_dsl.report.findings.cases_found import cases_found, kinds_shown

    if scenario is None:
        return (), ()
    return cases_found(scenario, campaign), kinds_shown(scenario, campaign, SHOWN_KINDS)


def show_reports(
    program: Program, reports: "Sequence[SearchReport]", settings: str, request: CompileRequest, terminal: Terminal
) -> None:
    """Show the screen of a search by one method or several, and the requested details."""
    from cortex_dsl.report.terminal.render import parts, rendered
    from cortex_dsl.report.terminal.theme import heading
    from cortex_dsl.report.views.search import comparison_screen, search_screen
    from cortex_dsl.report.views.search_details import paper_details, search_details

    console, ascii_only = terminal.out, terminal.out.options.ascii_only
    several = len(reports) > 1
    screen = comparison_screen(program, reports, settings) if several else search_screen(program, reports[0], settings)
    console.print(rendered(screen, console.width, ascii_only=ascii_only))
    if request.paper:
        console.print(parts([paper_details(reports, settings)], console.width, ascii_only=ascii_only))
    for report in reports:
        if several and request.metrics:
            console.print(heading(f"\n{report.method}"))
        if request.metrics:
            console.print(parts(search_details(program, report), console.width, ascii_only=ascii_only))


def is_constant(done: Progress) -> bool:
    """Return whether an objective other than the risk is the same in every valid run of a generation."""
    values = done.evaluations.fitness[done.evaluations.valid]
    return done.objective != DEFAULT_OBJECTIVES and len(values) > 1 and bool((values == values[0]).all())


def constant_line(done: Progress) -> str:
    """Return a warning about an objective with the same value in every draw."""
    value = significant(done.best.continuous) if done.best else ""
    what = f"{done.objective[0]} is {value} in every valid run of the first generation"
    return f"{what}: there is nothing to climb, and the search is a random one until it changes"

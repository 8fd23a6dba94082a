"""Progress of a running search, shared by the command line and the session."""

from collections.abc import Iterator
from contextlib import contextmanager
from math import nan

from cortex_dsl.console.terminal import Terminal
from cortex_dsl.report.findings.readable import significant
from cortex_dsl.report.terminal.progress import SearchProgress
from engine.search.campaign import OnGeneration, Progress
from engine.search.journal_reader import Record
from engine.search.protocol import DEFAULT_OBJECTIVES


@contextmanager
def watched(terminal: Terminal, method: str, total: int, record: Record | None = None) -> Iterator[OnGeneration]:
    """Show the progress of a search; `record` holds its earlier part."""
    before = [each.by_individual for each in record.generations] if record else []
    with SearchProgress(terminal.err, method, total, before, spent=record.spent if record else 0.0) as progress:

        def on_generation(done: Progress) -> None:
            best = nan
            if done.best is not None:
                best = done.best.score if done.objective == DEFAULT_OBJECTIVES else done.best.continuous
            progress.generation_done(done.figures.by_individual, done.simulations, best)
            if done.generation == 0 and is_constant(done):
                terminal.note(constant_line(done), "warn")

        yield on_generation


def is_constant(done: Progress) -> bool:
    """Return whether an objective other than the risk is the same in every valid run of a generation."""
    values = done.evaluations.fitness[done.evaluations.valid]
    return done.objective != DEFAULT_OBJECTIVES and len(values) > 1 and bool((values == values[0]).all())


def constant_line(done: Progress) -> str:
    """Return a warning about an objective with the same value in every draw."""
    value = significant(done.best.continuous) if done.best else ""
    what = f"{done.objective[0]} is {value} in every valid run of the first generation"
    return f"{what}: there is nothing to climb, and the search is a random one until it changes"

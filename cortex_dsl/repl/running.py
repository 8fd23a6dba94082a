"""Commands that run scenes: one, or a search through many."""

from pathlib import Path

from cortex_dsl.cli.arguments import SEED_LIMIT
from cortex_dsl.cli.exits import Exit, UsageError
from cortex_dsl.cli.failed_runs import mistake_of
from cortex_dsl.cli.request import Mode, Request
from cortex_dsl.repl.commands import whole_number
from cortex_dsl.repl.desk import Desk
from cortex_dsl.repl.entering import refuse
from cortex_dsl.session import Scenario
from engine.search.campaign import Campaign, Progress

GENERATIONS = 10
MOST_GENERATIONS = 10_000


def seed_of(text: str, default: int) -> int:
    """A seed as typed.

    Raises:
        UsageError: it is none.
    """
    if not text:
        return default
    if not text.isascii() or not text.isdigit() or int(text[:20]) > SEED_LIMIT:
        raise UsageError(f"a seed is a whole number from 0 on, not `{text}`")
    return int(text)


def do_run(desk: Desk, argument: str) -> None:
    from cortex_dsl.cli.run import perform

    seed = seed_of(argument, desk.seed)
    scenario = desk.scenario()
    request = Request(Path(desk.name), Mode.RUN, seed=seed, overrides=desk.overrides)
    code = perform(request, scenario, desk.terminal, reproduce=f":run {seed}")
    desk.no_scene = code == Exit.NO_SCENE
    desk.mistakes += code == Exit.DIAGNOSTICS


def do_ga(desk: Desk, argument: str) -> None:
    _search(desk, "ga", argument)


def do_random(desk: Desk, argument: str) -> None:
    _search(desk, "random", argument)


def _search(desk: Desk, method: str, argument: str) -> None:
    generations = whole_number(argument, GENERATIONS, "the number of generations", MOST_GENERATIONS)
    scenario = desk.scenario()
    if not len(scenario.program.space):
        raise UsageError("there is no param to search", "give it one: `param SPEED = Range(5, 80) km/h`")
    campaign = _campaign(desk, scenario, method, generations)
    mistake = mistake_of(scenario, campaign)
    if mistake is not None:
        refuse(desk, scenario.compiled.source, [mistake])
        return
    desk.no_scene = not campaign.by_individual.valid
    from cortex_dsl.report.findings.search_report import SearchReport
    from cortex_dsl.report.terminal.search_view import search_view

    console, population = desk.terminal.out, scenario.config.search.population
    settings = f"{generations} x {population}, seed {desk.seed}"
    console.print(search_view(scenario.program, SearchReport(campaign, None), settings, console.width))


def _campaign(desk: Desk, scenario: Scenario, method: str, generations: int) -> Campaign:
    """The search; Ctrl-C ends it, and what was found until then stays."""
    from cortex_dsl.report.terminal.progress import SearchProgress

    with SearchProgress(desk.terminal.err, method, generations) as progress:

        def on_generation(done: Progress) -> None:
            best = done.best.score if done.best else float("nan")
            progress.generation_done(done.figures.by_individual, done.simulations, best)

        return scenario.search(method, generations=generations, seed=desk.seed, on_generation=on_generation)

"""Commands on scenes: sample and count them, show one, suggest a relaxation; run one, or search many."""

import shlex
import time
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cortex_dsl.console.kernels import RUN, SAMPLE, SEARCH
from cortex_dsl.console.request import SEED_LIMIT, CompileRequest, RunRequest, share
from cortex_dsl.console.terminal import Exit, UsageError
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.repl.instant import INSTANT, draw, is_undefined
from cortex_dsl.repl.state import LastSearch, State, refuse, whole_number
from cortex_dsl.report.findings.tally import Tally
from engine.errors import ArgumentError

if TYPE_CHECKING:
    from cortex_dsl.api.scenario import Scenario
    from engine.scenes import Scenes
    from engine.search.campaign import Campaign


SCENES = 10_000
MOST_SCENES = 10_000_000
CHUNK = 5_000
"""Scenes drawn at once; Ctrl-C is answered in between."""
TRIES = 200
"""Genomes that are tried for one scene."""


def do_sample(state: State, argument: str) -> None:
    count = whole_number(argument, SCENES, "the number of scenes", MOST_SCENES)
    scenario = state.scenario(SAMPLE)
    start, tally, interrupted = time.perf_counter(), Tally(), False
    try:
        for first in range(0, count, CHUNK):
            scenes = draw(scenario, state.seed, np.arange(first, min(first + CHUNK, count)))
            if is_undefined(state, scenario, scenes):
                return
            tally = tally.plus(scenes)
    except KeyboardInterrupt:
        interrupted = True
    state.no_scene = bool(tally.scenes) and not tally.valid
    if tally.scenes:
        _show_tally(state, scenario, tally, time.perf_counter() - start, count if interrupted else 0)


def _show_tally(state: State, scenario: "Scenario", tally: Tally, seconds: float, interrupted_before: int) -> None:
    from cortex_dsl.report.terminal.render import rendered
    from cortex_dsl.report.views.samples import sample_view
    from engine.acceptance import account

    blame = None if tally.always else account(state.weighing(scenario.program))
    note = f"seed {state.seed}"
    if interrupted_before:
        note += f", interrupted before {interrupted_before:,}"
    console, view = state.terminal.out, sample_view(scenario.program, tally, seconds, note, blame)
    console.print(rendered(view, console.width, ascii_only=console.options.ascii_only))


def do_scene(state: State, _argument: str) -> None:
    scenario = state.scenario(INSTANT)
    scenes = _next_scene(state, scenario)
    if scenes is None:
        return
    from cortex_dsl.lowering.given_out import light_colours
    from cortex_dsl.report.terminal.still_view import still_view
    from engine import batch
    from engine.road import build_network
    from engine.road.outline import outline

    console = state.terminal.out
    shown = light_colours(scenario.compiled.scenario, scenes, 0, scenario.config.simulation)
    road = outline(build_network(scenario.program.road_spec), shown)
    ways = batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation, scenario.config.contact)
    state.scenes_shown += 1
    note = f"scene {state.scenes_shown} of seed {state.seed}"
    if state.scenes_tried > state.scenes_shown:
        note += f", of {state.scenes_tried} draws"
    view = still_view(scenario.program, scenes, road, ways, note, console.width, ascii_only=console.options.ascii_only)
    console.print(view)


def _next_scene(state: State, scenario: "Scenario") -> "Scenes | None":
    """Return the next accepted scene of the seed; where there is none, show why and return None."""
    tally = Tally()
    for _ in range(TRIES):
        scenes = draw(scenario, state.seed, np.array([state.scenes_tried]))
        state.scenes_tried += 1
        if is_undefined(state, scenario, scenes):
            return None
        tally = tally.plus(scenes)
        if scenes.valid[0]:
            state.no_scene = False
            return scenes
    state.no_scene = True
    _show_tally(state, scenario, tally, 0.0, 0)
    return None


def do_relax(state: State, argument: str) -> None:
    from argparse import ArgumentTypeError

    program = state.checked.weighable
    if program is None:
        raise state.not_ready()
    try:
        target = share(argument) if argument else None
    except ArgumentTypeError as error:
        raise UsageError(f"the share {error}", "as in `:relax 50%`") from None
    state.kernels.wait(state.terminal, ("weigh",), program)
    from cortex_dsl.report.terminal.render import rendered
    from cortex_dsl.report.views.requirements import blame_view
    from engine.acceptance import account

    blame = account(state.weighing(program), target)
    state.terminal.out.print(rendered(blame_view(blame), state.terminal.out.width, depth=1))
    if target is not None and blame.weighing.acceptance >= target:
        state.terminal.out.print("  nothing needs to be relaxed for that", style="good")


# -- running scenes: one, or a search through many ---------------------------------------------------------------------

GENERATIONS = 10
MOST_GENERATIONS = 10_000
AIM, METRICS, PAPER = "--objective", "--metrics", "--paper"
NEXT = "  `:worst` lists their kinds, `:watch N` plays one, `:export N FILE` keeps it"


def seed_of(text: str, default: int) -> int:
    """A seed as typed.

    Raises:
        UsageError: the text is no seed.
    """
    if not text:
        return default
    if not text.isascii() or not text.isdigit() or int(text[:20]) > SEED_LIMIT:
        raise UsageError(f"a seed is a whole number from 0 on, not `{text}`")
    return int(text)


def do_run(state: State, argument: str) -> None:
    from cortex_dsl.console.simulating import perform_run

    words = argument.split()
    seed = seed_of(" ".join(word for word in words if word != METRICS), state.seed)
    scenario = state.scenario(RUN)
    request = CompileRequest(Path(state.name), overrides=state.overrides, metrics=METRICS in words)
    code = perform_run(request, RunRequest(seed=seed), scenario, state.terminal, reproduce=f":run {seed}")
    state.no_scene = code == Exit.NO_SCENE
    state.mistakes += code == Exit.DIAGNOSTICS


def do_ga(state: State, argument: str) -> None:
    _search(state, "ga", argument)


def do_random(state: State, argument: str) -> None:
    _search(state, "random", argument)


def _search(state: State, method: str, argument: str) -> None:
    """Search, show the results, and store them for the commands on cases."""
    from cortex_dsl.console.simulating import blame_of_search, mistake_of

    generations, aims, shown = _parse_argument(method, argument)
    scenario = state.scenario(SEARCH)
    if not len(scenario.program.space):
        raise UsageError("there is no param to search", "give it one: `param SPEED = Range(5, 80) km/h`")
    campaign = _campaign(state, scenario, method, generations, aims)
    mistake = mistake_of(scenario, campaign)
    if mistake is not None:
        refuse(state, scenario.compiled.source, [mistake])
        return
    state.no_scene = not campaign.by_individual.valid
    from cortex_dsl.console.searching import cases_and_kinds, show_reports
    from cortex_dsl.report.findings.search_report import SearchReport

    console, population = state.terminal.out, scenario.config.search.population
    settings = ", ".join([f"{generations} x {population}", f"seed {state.seed}", *(f"objective {aim}" for aim in aims)])
    blame = blame_of_search(scenario.program, campaign, state.seed)
    cases, kinds = cases_and_kinds(scenario, campaign)
    report = SearchReport(campaign, None, blame=blame, cases=cases, kinds=kinds)
    request = CompileRequest(Path(state.name), metrics=METRICS in shown, paper=PAPER in shown)
    show_reports(scenario.program, [report], settings, request, state.terminal)
    state.found = LastSearch(scenario, campaign, state.draft, f":{method}, {settings}", tuple(cases))
    if campaign.worst:
        console.print()
        console.print(NEXT, style="quiet")


def _parse_argument(method: str, argument: str) -> tuple[int, tuple[str, ...], set[str]]:
    """Return the number of generations, the objectives (the risk by default), and the requested details.

    Raises:
        UsageError: the words are invalid.
    """
    try:
        words = shlex.split(argument)
    except ValueError:
        raise UsageError("a quotation mark is not closed") from None
    shown = {word for word in words if word in (METRICS, PAPER)}
    words = [word for word in words if word not in shown]
    count = words.pop(0) if words and not words[0].startswith("-") else ""
    flags, aims = words[::2], words[1::2]
    if len(flags) != len(aims) or any(flag != AIM for flag in flags):
        raise UsageError(f"`{argument}` is not a search method", f"as in `:{method} 20 {AIM} avoidable`")
    return whole_number(count, GENERATIONS, "the number of generations", MOST_GENERATIONS), tuple(aims), shown


def _campaign(state: State, scenario: "Scenario", method: str, generations: int, aims: tuple[str, ...]) -> "Campaign":
    """Return the campaign; Ctrl-C ends the search, and the results up to then remain."""
    from cortex_dsl.console.searching import watched

    try:
        with watched(state.terminal, method, generations) as on_generation:
            return scenario.search(
                method,
                generations=generations,
                seed=state.seed,
                on_generation=on_generation,
                objective=aims or "risk",
            )
    except ArgumentError as error:
        raise UsageError(error.message, error.cure) from None
    except CompileError as error:
        (proof,) = error.diagnostics
        raise UsageError(f"{proof.message}: {proof.reason}", proof.cure) from None

"""`:plot`: values of a param, a finite choice or any expression in accepted scenes, or in instant runs."""

from collections.abc import Sequence
from dataclasses import replace
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from cortex_dsl.console.terminal import UsageError
from cortex_dsl.repl.chunks import parted
from cortex_dsl.repl.expressions import Over, Probe, probed
from cortex_dsl.repl.instant import INSTANT, Instant, instant_runs
from cortex_dsl.repl.state import State
from cortex_dsl.report.findings.choices import choice_names, options_made
from cortex_dsl.report.findings.plotted import Plotted, Shown
from cortex_dsl.report.findings.readable import M_S, SpeedUnit, speed_unit
from engine.vocabulary import Verdict

if TYPE_CHECKING:
    from cortex_dsl.api.scenario import Scenario
    from engine.acceptance import AcceptanceStatistics
    from engine.program import Program
    from engine.tables import Bools

ENOUGH = 4_000
"""Accepted draws that make a good histogram of a param."""
MOST_DRAWS = 400_000
TRUTH = ("does not hold", "holds")


def do_plot(state: State, argument: str) -> None:
    if not argument:
        cure = "a param, or any number or truth, as in `:plot ego.speed`; two with a comma between"
        raise UsageError("plot what?", cure)
    program = state.checked.weighable
    if program is None:
        raise state.not_ready()
    if argument in program.space.names:
        _plot_param(state, program, program.space.names.index(argument))
        return
    expressions = parted(argument)
    if len(expressions) > 2 or not all(expressions):
        raise UsageError("`:plot` shows one thing, or two against each other", "as in `:plot ego.speed, delta_v`")
    _plot(state, program, expressions)


def _plot_param(state: State, program: "Program", gene: int) -> None:
    """The accepted values against those that were drawn, of very many draws: nothing is run for them."""
    state.kernels.wait(state.terminal, ("weigh",), program)
    from cortex_dsl.report.terminal.plot_view import distribution_view

    weighing = _plenty(state, state.weighing(program))
    console = state.terminal.out
    console.print(distribution_view(weighing, gene, console.width, ascii_only=console.options.ascii_only))


def _plenty(state: State, weighing: "AcceptanceStatistics") -> "AcceptanceStatistics":
    """More draws where few of them are accepted."""
    accepted = int(weighing.accepted.sum())
    if accepted >= ENOUGH:
        return weighing
    from engine.acceptance import measure_acceptance

    wanted = len(weighing) * ENOUGH // max(accepted, 1)
    return measure_acceptance(weighing.program, min(MOST_DRAWS, wanted), state.seed)


# -- expressions -------------------------------------------------------------------------------------------------------


def _plot(state: State, program: "Program", expressions: Sequence[str]) -> None:
    """Draw the view of one thing, or of two."""
    choices = choice_names(program)
    found = probed(state, [each for each in expressions if each not in choices])
    if found is None:
        return
    scenario = state.scenario_of(found.compiled, INSTANT)
    instant = instant_runs(state, scenario)
    if instant is None:
        return
    over_run = any(probe.over is not Over.SCENE for probe in found.probes)
    rows = _rows(instant, over_run=over_run)
    made = iter(found.probes)
    things: list[Plotted] = []
    for each in expressions:
        if each in choices:
            things.append(_choice(found.compiled.program, each, instant, rows))
        else:
            things += _values(scenario, next(made), instant, rows)
    if len(things) > 2:
        raise UsageError("a place is two numbers already", "plot it alone, or one of its coordinates: `.x`, `.y`")
    collided = instant.outcomes.collided[rows] & (instant.outcomes.verdict[rows] == Verdict.VALID)
    _show(state, Shown(things, collided, found.whole and len(program.actors) > 1, over_run, state.seed))


def _show(state: State, shown: Shown) -> None:
    from cortex_dsl.report.terminal.plot_view import scatter_view, values_view

    console = state.terminal.out
    draw = values_view if len(shown.things) == 1 else scatter_view
    console.print(draw(shown, console.width, ascii_only=console.options.ascii_only))


def _rows(instant: Instant, *, over_run: bool) -> "Bools":
    """Return which scenes are shown: all, or those with valid runs."""
    every = np.ones(len(instant.outcomes), dtype=bool)
    return instant.outcomes.verdict == Verdict.VALID if over_run else every


def _choice(program: "Program", name: str, instant: Instant, rows: "Bools") -> Plotted:
    options, made = options_made(program, instant.scenes, name)
    return Plotted(name, "", np.array(made, dtype=np.float64)[rows], options)


def _values(scenario: "Scenario", probe: Probe, instant: Instant, rows: "Bools") -> list[Plotted]:
    """One thing, or the coordinates of a place."""
    unit = speed_unit(scenario.program)
    judged = scenario.program.judged
    if probe.over is Over.SCENE:
        return [_readable(each, unit) for each in _at_start(scenario, probe, instant, rows)]
    number = judged.names.index(probe.name)
    values, broken = instant.outcomes.sought[rows, number], instant.outcomes.broken[rows, number]
    if probe.over is Over.FORMULA:
        return [Plotted(f"robustness of {probe.text}", "", values, kept=broken == 0.0)]
    return [_readable(Plotted(probe.text, judged.objectives[number].unit, values), unit)]


def _at_start(scenario: "Scenario", probe: Probe, instant: Instant, rows: "Bools") -> list[Plotted]:
    """Return the values of a record at the first sample, for runs that have no second sample."""
    from engine import batch

    config = scenario.config
    short = replace(config.simulation, max_time=config.simulation.time_step)
    watched = [
        batch.trajectory(scenario.program, instant.scenes, row, short, config.contact).watched[0]
        for row in np.flatnonzero(rows).tolist()
    ]
    table = np.array(watched).reshape(len(watched), len(scenario.program.rules))
    records = [record for record in scenario.program.records if record.name.startswith(probe.name)]
    options = TRUTH if probe.is_truth else ()
    names = [probe.text + record.name.removeprefix(probe.name) for record in records]
    found = [
        Plotted(name, record.unit, table[:, record.rule], options) for name, record in zip(names, records, strict=True)
    ]
    return found[:2]  # of a place without its heading


def _readable(thing: Plotted, speed: SpeedUnit) -> Plotted:
    """Speeds in the unit of the file, angles in degrees, a param of a file in its own unit."""
    if thing.unit == M_S.name:
        return replace(thing, unit=speed.name, values=thing.values * speed.per_si)
    if thing.unit == "rad":
        return replace(thing, unit="deg", values=thing.values * (180.0 / pi))
    return thing

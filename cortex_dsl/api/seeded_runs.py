"""Runs of a scenario by successive seeds, for commands that judge a file.

Run i of seed S is that of `cortexc FILE --seed N` with N = S * SEEDS + i - 1, so that this command repeats it. A file
that leaves nothing to chance has one run.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from cortex_dsl.api.limits import MOST_RUNS
from cortex_dsl.api.scenario import NO_SCENE, Scenario
from cortex_dsl.api.scenario_mistakes import failure_of
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.report.findings.gate_report import Measured
from cortex_dsl.report.findings.story import end_of
from engine.driving.blocks import Driven, Driver
from engine.errors import ArgumentError
from engine.outcomes import Outcomes
from engine.program import Program
from engine.scenes import Scenes
from engine.streams import single_keys
from engine.tables import Bools, Ints
from engine.vocabulary import EndReason, Verdict

BLOCK = 256
"""Runs between two looks at a probability, and scenes in one query to a driver by default."""
SEEDS = MOST_RUNS
"""Number of seeds that belong to one seed of a command."""
SEED_LIMIT = (2**63 - 1) // SEEDS - 1
"""Largest seed of a command."""
KMH = 3.6
NO_CONTACT = "no contact of the ego"
"""Name of the condition of a file without an `expect`."""

OnRuns = Callable[[int, int], None]
"""Callback with the finished runs and the budget of the file that is running in this process."""
Prepare = Callable[[Scenario], None]
"""Callback with each scenario that this process runs, before its first run."""


def check_seed(seed: int) -> None:
    """Check the seed of a command.

    Raises:
        ArgumentError: it is negative or too large.
    """
    if not 0 <= seed <= SEED_LIMIT:
        raise ArgumentError(f"--seed is {seed}", f"give a number from 0 to {SEED_LIMIT:,}")


def fitting_driver(program: Program, driver: Driver | None) -> Driver | None:
    """Return a driver with an empty history; None if the file has no controller.

    Raises:
        ControllerError: it does not fit the controllers of the file.
    """
    if driver is None or not program.controls:
        return None
    from engine.driving.controllers import controllers_of

    controllers_of(program, driver.given)
    return driver.without_history()


def drive(scenario: Scenario, driver: Driver | None, scenes: Scenes, jobs: int) -> Driven:
    """Run scenes, by the driver if there is one.

    Raises:
        ControllerError: the driver fails everywhere, or is missing.
    """
    if driver is None:
        return Driven(scenes, scenario.simulate(scenes, jobs=jobs))
    return driver.drive(scenario.program, scenes, scenario.config.simulation, scenario.config.contact, jobs)


def check_mistake(scenario: Scenario, done: Driven, what: str) -> None:
    """Check that no run met a mistake of the file; `what` names the runs in the message of a bug.

    Raises:
        CompileError: a run did.
    """
    for row in np.flatnonzero(done.outcomes.verdict == Verdict.ERROR)[:1].tolist():
        compiled, simulation = scenario.compiled, scenario.config.simulation
        diagnostic = failure_of(compiled, simulation, done.scenes, done.outcomes, row)
        if diagnostic is None:
            raise RuntimeError(f"a run of {what} failed")
        raise CompileError(compiled.source, [diagnostic])


def touched(outcomes: Outcomes) -> Bools:
    """Return (n,) True for runs in which the ego touches an actor or a building."""
    return outcomes.collided | (outcomes.end_reason == EndReason.BUILDING)


def end_numbers(program: Program, outcomes: Outcomes, row: int) -> tuple[str, tuple[Measured, ...]]:
    """Return the end of a run in words, and its numbers: the speeds at a contact, else the least distance."""
    event = f"{float(outcomes.end_time[row]):.2f} s: {end_of(program, outcomes, row).text}"
    numbers: tuple[Measured, ...] = ()
    if outcomes.collided[row]:
        pair = int(outcomes.contact_actors[row, 1]) - 1
        speeds = zip((0, pair + 1), (outcomes.ego_speed, outcomes.other_speed), strict=True)
        numbers = tuple(
            Measured(program.actors[actor], float(speed[row, pair]) * KMH, "km/h") for actor, speed in speeds
        )
    elif len(program.actors) > 1:
        pair = int(np.argmin(outcomes.min_distance[row]))
        distance = float(outcomes.min_distance[row, pair])
        numbers = (Measured(f"distance to {program.actors[pair + 1]}", distance, "m"),)
    return event, numbers


def no_run_text(program: Program, last: Verdict) -> str:
    """Return the reason why no run counts, from the verdict of the last one."""
    from engine.feasibility import remembered

    return NO_RUN.get(Verdict.INFEASIBLE if remembered(program).infeasible else last, "no valid scene was found")


NO_RUN = {
    Verdict.INFEASIBLE: "no scene is possible: requirements exclude each other",
    Verdict.ABORTED: "no run counts: each broke a requirement on the run",
}
"""Reasons by the verdict of the last run."""


# -- scenes by their seeds ---------------------------------------------------------------------------------------------


def seeds_of(seed: int, numbers: Ints) -> Ints:
    """Return (n,) the seeds of `cortexc FILE --seed N` for runs with these numbers, from 1, of a command's seed."""
    return seed * SEEDS + numbers - 1


def only_scene(scenario: Scenario) -> Scenes:
    """Return the scene of a file that leaves nothing to chance."""
    stream = scenario.program.settings.stream
    return replace(scenario, config=replace(scenario.config, driver=None)).scene_of_seed(None if stream else 0)


def draw_scenes(scenario: Scenario, seeds: Ints, jobs: int = 1, *, hopeful: bool = False) -> Scenes:
    """Return the scene of `cortexc FILE --seed N` for each of the seeds (n,); it is not valid if no genome allows one.

    If no first genome allows a scene, only the first seed tries further ones, unless `hopeful`: some scene is known to
    exist.
    """
    from engine.feasibility import remembered
    from engine.sampling import draw_genomes, sample

    program, config = scenario.program, scenario.config.simulation
    scenes: Scenes | None = None
    waiting, doubtful = np.arange(len(seeds)), False
    for key in single_keys(program, 0):
        keys = np.repeat(key, len(waiting), axis=0)
        keys[:, 0] = seeds[waiting]
        drawn = sample(program, draw_genomes(program.space, keys), keys, config, jobs)
        failed = np.isin(drawn.verdict, NO_SCENE)
        if scenes is None:
            scenes, doubtful = drawn, bool(failed.all()) and not hopeful
            failed[1:] &= not doubtful
        else:
            _overwrite(scenes, drawn, waiting)
        waiting = waiting[failed]
        if not len(waiting) or (doubtful and remembered(program).infeasible):
            break
    assert scenes is not None
    if doubtful and scenes.verdict[0] not in NO_SCENE and len(seeds) > 1:
        return draw_scenes(scenario, seeds, jobs, hopeful=True)
    return scenes


def _overwrite(scenes: Scenes, drawn: Scenes, rows: Ints) -> None:
    """Write drawn scenes into some rows."""
    for name in Scenes.__dataclass_fields__:
        if name != "actions":
            getattr(scenes, name)[rows] = getattr(drawn, name)

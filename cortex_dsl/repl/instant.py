"""Some hundred scenes of the draft, sampled and run at once: the basis of an entry's effect or a plot."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from cortex_dsl.repl.state import State, refuse
from engine.vocabulary import Verdict

if TYPE_CHECKING:
    from cortex_dsl.api.scenario import Scenario
    from engine.outcomes import Outcomes
    from engine.scenes import Scenes
    from engine.tables import Ints

INSTANT = ("sample", "simulate")
"""Parts of `engine.compiling_apart.PARTS` that instant runs call."""
RUNS = 400
"""Enough to tell a tenth from a fifth; a run takes less than a millisecond."""
MOST_ATTEMPTS = 2_000_000
"""Attempts after which fewer scenes will have to do."""


@dataclass(frozen=True)
class Instant:
    """Accepted scenes alone, and the result of each."""

    scenes: "Scenes"
    outcomes: "Outcomes"


def instant_runs(state: State, scenario: "Scenario") -> Instant | None:
    """Scenes as the file draws them by the seed of the session; None where one fails, which is then shown."""
    from engine.assessment import concatenate, take

    drawn: list[Scenes] = []
    valid = attempts = 0
    while valid < RUNS and attempts < MOST_ATTEMPTS:
        first = RUNS * len(drawn)
        drawn.append(draw(scenario, state.seed, np.arange(first, first + RUNS)))
        if is_undefined(state, scenario, drawn[-1]):
            return None
        valid, attempts = valid + int(drawn[-1].valid.sum()), attempts + int(drawn[-1].attempts.sum())
        if not drawn[0].valid.any():
            break
    scenes = concatenate(drawn)
    scenes = take(scenes, np.flatnonzero(scenes.valid)[:RUNS])
    outcomes = scenario.simulate(scenes)
    return None if _fails(state, scenario, scenes, outcomes) else Instant(scenes, outcomes)


def draw(scenario: "Scenario", seed: int, indices: "Ints") -> "Scenes":
    """Scenes by their numbers, each with params of its own."""
    from engine.sampling import draw_genomes, sample
    from engine.streams import key_rows
    from engine.vocabulary import Method

    keys = key_rows(seed, Method.SAMPLE, 0, 0, indices)
    return sample(scenario.program, draw_genomes(scenario.program.space, keys), keys, scenario.config.simulation)


def is_undefined(state: State, scenario: "Scenario", scenes: "Scenes") -> bool:
    """Return whether some scene contains an undefined number; show it if so."""
    errors = np.flatnonzero(scenes.verdict == Verdict.ERROR)
    if not len(errors):
        return False
    from cortex_dsl.api.scenario_mistakes import undefined_value

    diagnostic = undefined_value(scenario.compiled, scenes, int(errors[0]))
    if diagnostic is None:
        raise RuntimeError("a scene held a value that is not a number")
    refuse(state, scenario.compiled.source, [diagnostic])
    return True


def _fails(state: State, scenario: "Scenario", scenes: "Scenes", outcomes: "Outcomes") -> bool:
    """Return whether some run cannot be finished; show the reason if so."""
    errors = np.flatnonzero(outcomes.verdict == Verdict.ERROR)
    if not len(errors):
        return False
    row = int(errors[0])
    from cortex_dsl.api.scenario_mistakes import failure_of

    diagnostic = failure_of(scenario.compiled, scenario.config.simulation, scenes, outcomes, row)
    if diagnostic is None:
        raise RuntimeError(f"the simulation failed after {outcomes.end_time[row]:.2f} s")
    refuse(state, scenario.compiled.source, [diagnostic])
    return True

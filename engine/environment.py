"""Environments: parallel runs of a program that a user's code drives step by step.

The scene of a slot depends only on the seed, the slot and the number of the episode; a slot with its own seed gets the
scenes of slot 0 of that seed. After the end of a run the next step begins a new episode: it ignores the action, and its
reward is 0 unless the new run ends at once. The scenes of all slots that need one are sampled in one call, because many
cost little more than a few.

The reward of a step is the difference of `record … as "reward"` if the file has one. Otherwise it is 0 until the run
ends, and then the value of the objective of a search: negative for the ego, which avoids it, positive for all others.
"""

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import NamedTuple, cast

import numpy as np

from engine.assessment import take
from engine.config import ActorDriver, Config
from engine.control import Action, Control
from engine.display import counted
from engine.driving.controllers import ControllerSlot, checked, meant, seats_of
from engine.driving.named import driver_of
from engine.driving.observations import observed
from engine.driving.stepping import ParallelRuns
from engine.errors import ArgumentError, CortexError, nearest, whole
from engine.outcomes import Outcomes
from engine.program import Program
from engine.risk import PROFILES, assess, scores
from engine.sampling import draw_genomes, sample
from engine.scenes import Scenes
from engine.search.objectives import Objective, Runs, objectives
from engine.search.protocol import ObjectiveSpec
from engine.streams import StreamKey, key_rows
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import RECORDS, EndReason, Method, Verdict

# -- drivers of the controllers that are no agents ---------------------------------------------------------------------


def number_of(program: Program, name: str) -> int:
    """Return the number of the control with this controller.

    Raises:
        ArgumentError: no control has it; the hint names the nearest name.
    """
    names = [control.controller for control in program.controls]
    if name not in names:
        near = nearest(name, names)
        raise ArgumentError(
            f"{program.name} has no controller `{name}`",
            f"did you mean `{near}`?" if near else f"name one of {', '.join(names)}",
        )
    return names.index(name)


def others_of(program: Program, driver: ActorDriver | None, agent: str, observe: str) -> Mapping[str, object]:
    """Return the drivers of a scenario's controllers except the agent's, by controller name.

    Raises:
        ArgumentError: they observe something else than the environment.
    """
    if driver is None:
        return {}
    given: object = getattr(driver, "given", None)
    every = cast("Mapping[str, object]", given) if isinstance(given, Mapping) else {meant(program): given}
    others = {name: each for name, each in every.items() if name != (agent or meant(program)) and each is not None}
    if others and driver.observe != observe:
        raise ArgumentError(
            f"{', '.join(others)} observe {driver.observe}, and this environment {observe}",
            f'add `observe="{driver.observe}"`, or name `others` that observe {observe}',
        )
    return others


def seats_beside(
    program: Program, agents: Sequence[str], others: Mapping[str, object]
) -> list[tuple[ControllerSlot, int]]:
    """Return the slot and control number of each controller that is no agent.

    Raises:
        ArgumentError: a controller has no driver, or is both an agent and in `others`.
    """
    if both := [name for name in agents if name in others]:
        raise ArgumentError(
            f"`{both[0]}` decides step by step, and has a driver in `others`", "leave it out of `others`"
        )
    missing = [c.controller for c in program.controls if c.controller not in (*agents, *others)]
    if missing:
        raise ArgumentError(
            f"nobody drives for the controller `{missing[0]}`",
            "give it a driver: `others={" + f'"{missing[0]}": …' + "}`, or make it an agent",
        )
    rest = replace(program, controls=tuple(c for c in program.controls if c.controller not in agents))
    given = driver_of(others)
    seats = seats_of(rest, given.given) if rest.controls and given is not None else ()
    return [(seat, number_of(program, seat.control.controller)) for seat in seats]


TRIES = 100
"""Maximum number of consecutive episodes of a slot without a valid scene."""
SCENE_ARRAYS = tuple(each.name for each in fields(Scenes) if each.name != "actions")
"""Arrays of a scene that a slot stores; the runs store the actions."""


class Episodes:
    """`n` slots in which one or several controllers are agents, which decide step by step."""

    def __init__(
        self,
        program: Program,
        n: int,
        config: Config,
        agents: Sequence[str] = (),
        others: Mapping[str, object] | None = None,
        reward: ObjectiveSpec = "risk",
        observe: str = RECORDS,
    ) -> None:
        self.program, self.config = program, config
        self.runs = _parallel_runs(program, n, config, observe == RECORDS)
        self.agents = tuple(agents) or (meant(program),)
        self._numbers = [number_of(program, name) for name in self.agents]
        self._others = seats_beside(program, self.agents, others or {})
        self._objective: Objective | None = next(iter(objectives(program, (reward,))), None)
        self._profile = PROFILES["paper"]
        self.observations = observed(program, observe == RECORDS)
        self._seen = [np.zeros((n, len(self.observations))) for _ in program.controls]
        self._everywhere = np.ones(n, dtype=bool)
        for seat, _ in self._others:
            seat.initialize(n, self.observations, config.simulation.time_step)
        self._scenes: Scenes | None = None
        self._coming: Scenes | None = None
        self._drawn = np.zeros(n, dtype=bool)
        self._episode = np.zeros(n, dtype=np.int64)
        self._streams = np.zeros((n, 2), dtype=np.int64)
        """(n, 2) seed and number of each slot, by which its scenes are drawn."""
        self._ended = np.zeros(n, dtype=bool)
        self._reward_before: Floats | None = None

    def __len__(self) -> int:
        return len(self.runs)

    def control(self, agent: str = "") -> Control:
        """Return the control of an agent, by default the first."""
        return self.program.controls[self._numbers[self.agents.index(agent) if agent else 0]]

    @property
    def nbytes(self) -> int:
        """Return the memory of all slots [bytes]."""
        scenes = (each for each in (self._scenes, self._coming) if each is not None)
        arrays = (getattr(each, name) for each in scenes for name in SCENE_ARRAYS)
        return self.runs.nbytes + sum(array.nbytes for array in (*self._seen, *arrays))

    @property
    def outcomes(self) -> Outcomes:
        """Return the outcome of each slot's run; the rows of runs that go on hold no result yet."""
        return self.runs.outcomes(np.arange(len(self)))

    @property
    def scenes(self) -> Scenes:
        """Return a copy of each slot's scene with its actions so far; every host repeats the run from it."""
        assert self._scenes is not None, "`reset` draws the first scenes"
        every = np.arange(len(self))
        return replace(take(self._scenes, every), actions=self.runs.decided(every))

    # -- episodes ----------------------------------------------------------------------------------------------------

    def reset(self, seed: int | Sequence[int] = 0) -> list[Floats]:
        """Begin the first episodes of a seed, or of one seed per slot; return the observations of each agent."""
        if isinstance(seed, Sequence):
            if len(seed) != len(self):
                raise ArgumentError(f"seed: {len(seed)} seeds for {len(self)} slots", "give one, or one for each slot")
            self._streams[:] = [(whole("seed", each, 0), 0) for each in seed]
        else:
            self._streams[:, 0], self._streams[:, 1] = whole("seed", seed, 0), np.arange(len(self))
        self._episode[:] = -1
        self._scenes = self._coming = None
        self._drawn[:] = self._ended[:] = False
        self._begin(np.arange(len(self)))
        self.runs.step()
        self._look()
        self._reward_before = self.runs.rewarded
        return self._views()

    def _begin(self, chosen: Ints) -> None:
        """Begin the next episode of some slots."""
        if not self._drawn[chosen].all():
            self._draw(np.flatnonzero(~self._drawn))
        without = chosen[~self._drawn[chosen]]
        if len(without):
            raise ArgumentError(
                f"slot {without[0]} has no valid scene in {TRIES} episodes",
                "see what `cortexc FILE --sample 1000` says of the requirements",
            )
        assert self._coming is not None
        self._drawn[chosen] = False
        self._scenes = _with_rows(self._scenes, chosen, self._coming, chosen)
        self.runs.place(chosen, self._scenes)
        for seat, _ in self._others:
            seat.reset(chosen, self._scenes.keys[chosen])

    def _draw(self, slots: Ints) -> None:
        """Draw the scenes of the next episodes of some slots; skip up to `TRIES` episodes without a valid scene."""
        left = slots
        for _ in range(TRIES):
            episodes = self._episode[left] + 1
            keys = self._keys(left, episodes)
            genomes = draw_genomes(self.program.space, keys)
            drawn = sample(self.program, genomes, keys, self.config.simulation, self.config.search.jobs)
            self._coming = _with_rows(self._coming, left, drawn, np.arange(len(left)))
            self._episode[left], self._drawn[left] = episodes, drawn.valid
            left = left[~drawn.valid]
            if not len(left):
                return

    def _keys(self, slots: Ints, episodes: Ints) -> Ints:
        keys = key_rows(0, Method.SAMPLE, 0, 0, self._streams[slots, 1])
        keys[:, StreamKey._fields.index("seed")] = self._streams[slots, 0]
        keys[:, StreamKey._fields.index("generation")] = episodes  # `draw_genomes` checks it
        return keys

    # -- steps -------------------------------------------------------------------------------------------------------

    def step(self, actions: Sequence[object]) -> tuple[list[Floats], list[Floats], Bools, Bools]:
        """Apply the actions (n, a) of each agent and run all slots to the next question. Return observations and
        rewards of each agent, and (n,) True for runs that came to an end, or to the time limit.

        Raises:
            ControllerError: the actions have another shape, are NaN or out of range.
        """
        if self._scenes is None:
            raise ArgumentError("nothing has begun yet", "call `reset` first")
        fresh = np.flatnonzero(self._ended)
        times = self.runs.times
        for number, given in zip(self._numbers, actions, strict=True):
            queried = self.runs.asked(number)
            self.runs.decide(number, queried, checked(self.program.controls[number], given, queried, times))
        for seat, number in self._others:
            queried = self.runs.asked(number)
            if queried.any():
                self.runs.decide(number, queried, seat.act(self._seen[number].copy(), queried, times))
        if len(fresh):
            self._begin(fresh)
        self.runs.step()
        self._look()
        self._ended = ~self.runs.running
        return self._views(), self._rewards(fresh), *self._ends(self.runs.reasons)

    def _ends(self, reason: Ints) -> tuple[Bools, Bools]:
        truncated = reason == EndReason.TIMEOUT
        return self._ended & ~truncated, truncated

    def _look(self) -> None:
        """Observe all slots for every controller."""
        self._seen = [self.runs.observe(number, self._everywhere) for number in range(len(self._seen))]

    def _views(self) -> list[Floats]:
        return [self._seen[number] for number in self._numbers]  # nothing writes to them after this step

    # -- rewards -----------------------------------------------------------------------------------------------------

    def _rewards(self, fresh: Ints) -> list[Floats]:
        """Return the reward (n,) of each agent for the step."""
        before, self._reward_before = self._reward_before, self.runs.rewarded
        if before is not None and self._reward_before is not None:
            gained = self._reward_before - before
            gained[fresh] = 0.0
            return [gained.copy() for _ in self._numbers]
        found = self._found()
        return [0.0 - found if self.program.controls[number].actor == 0 else found.copy() for number in self._numbers]

    def _found(self) -> Floats:
        """Return the value of the search's objective of the runs that have just ended; 0 for invalid and unfinished
        runs.
        """
        found, rows = np.zeros(len(self)), np.flatnonzero(self._ended)
        if len(rows):
            assert self._scenes is not None
            ended = self.runs.outcomes(rows)
            if self._objective is None:
                value = scores(ended, self._profile)
            else:
                scenes = replace(take(self._scenes, rows), actions=self.runs.decided(rows))
                risk = assess(ended, self._profile)
                value = self._objective.value(Runs(self.program, self.config, scenes, ended, risk))
            found[rows] = np.where((ended.verdict == Verdict.VALID) & np.isfinite(value), value, 0.0)
        return found


def _parallel_runs(program: Program, n: int, config: Config, records: bool) -> ParallelRuns:
    """Return `n` parallel runs.

    Raises:
        ArgumentError: the memory is too small for them.
    """

    def allocate(count: int) -> ParallelRuns:
        return ParallelRuns(program, count, config.simulation, config.contact, records, config.search.jobs)

    try:
        return allocate(n)
    except CortexError:
        raise
    except (MemoryError, ValueError):  # numpy's, where arrays have more bytes than can be had, or addressed
        needed = n * allocate(1).nbytes
        raise ArgumentError(
            f"n: {n:,} scenes side by side need {needed:,} bytes and more, which cannot be had",
            "take fewer: episodes follow one another in each, and some thousands keep a processor busy",
        ) from None


def _with_rows(scenes: Scenes | None, chosen: Ints, others: Scenes, rows: Ints) -> Scenes:
    """Return scenes with the rows `chosen` replaced by `rows` of others; a copy of `rows` if none exist yet."""
    if scenes is None:
        return take(others, rows)
    for name in SCENE_ARRAYS:
        getattr(scenes, name)[chosen] = getattr(others, name)[rows]
    return scenes


# -- one agent ---------------------------------------------------------------------------------------------------------


class Step(NamedTuple):
    """Result of a step, slot by slot."""

    observations: Floats
    """Observations (n, d); for an ended run those of its last sample."""
    rewards: Floats
    """Reward (n,) of the step."""
    terminated: Bools
    """(n,) True if the run has come to an end."""
    truncated: Bools
    """(n,) True if the run has reached its time limit."""


class Environment:
    """`n` slots in which one controller is driven from outside."""

    def __init__(self, episodes: Episodes) -> None:
        self.episodes, self._control = episodes, episodes.control()

    def __len__(self) -> int:
        return len(self.episodes)

    def __repr__(self) -> str:
        """Return one line, for notebooks."""
        wide = f"{counted(len(self.observations), 'observation')}, {counted(len(self.actions), 'action')}"
        slots = counted(len(self), "slot")
        return f"Environment({self.episodes.program.name}: {slots}, {wide}, {self.nbytes / 1e6:.1f} MB)"

    @property
    def observations(self) -> tuple[tuple[str, str], ...]:
        """Name and unit of each number that is observed."""
        return self.episodes.observations

    @property
    def actions(self) -> tuple[Action, ...]:
        """Name, unit and range of each number that is decided."""
        return self._control.actions

    @property
    def nbytes(self) -> int:
        """Return the memory of all slots [bytes]."""
        return self.episodes.nbytes

    @property
    def outcomes(self) -> Outcomes:
        """Return the outcome of each slot's run, if it has ended."""
        return self.episodes.outcomes

    @property
    def scenes(self) -> Scenes:
        """Return the scene of each slot with its actions so far; either host repeats the run from it."""
        return self.episodes.scenes

    @property
    def states(self) -> Floats:
        """Return the current states (n, actors, len(State))."""
        return self.episodes.runs.states

    def reset(self, seed: int | Sequence[int] = 0) -> Floats:
        """Begin the first episodes of a seed, or of one seed per slot; return the observations (n, d)."""
        return self.episodes.reset(seed)[0]

    def step(self, actions: object) -> Step:
        """Do `actions` (n, a) in all slots, and run on to the next decision.

        Raises:
            ControllerError: actions of another shape, NaN or out of range.
        """
        seen, rewards, terminated, truncated = self.episodes.step([actions])
        return Step(seen[0], rewards[0], terminated, truncated)

"""Scenes side by side, stepped from one question to a controller to the next.

A stepped run is the run of the batch host: the same kernel, which pauses at a sample between the rules and the turns.
There the lanes are observed, controllers decide, and the next call goes on. Rows of `Run.actions` hold what was decided
turn by turn; with them the finished run is run again by any host, without the controller.
"""

import math
from collections.abc import Sequence
from functools import cached_property
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from engine.config import ContactConfig, SimulationConfig
from engine.control import Control, columns, numbers_decided, turns
from engine.errors import ArgumentError
from engine.host import CHUNK, empty_results, in_parts, lanes, memory, plan
from engine.kernels.egocentric import AHEAD, EACH, NEAREST, OWN, WIDTH, look_around
from engine.kernels.lanes import EMPTY
from engine.kernels.rows import Requested, begin_lanes, judge_rows, simulate_rows
from engine.kernels.stage import RUNNING, Run, Status
from engine.program import Program
from engine.scenes import Scenes, actor_columns, weather_sight
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Column, Verdict

CONTACT = ContactConfig()

# -- what is observed --------------------------------------------------------------------------------------------------

Named = tuple[tuple[str, str], ...]
"""Names and their SI unit words."""


def observed(program: Program, records: bool = True) -> Named:
    """What a controller of this program observes: what the file records over time, or the egocentric vector where it
    records nothing, or `records` is False.
    """
    kept = tuple((record.name, record.unit) for record in program.records if record.when == "series")
    return kept if kept and records else EGOCENTRIC


def _egocentric() -> Named:
    ahead = ((f"path {away:g} m ahead: {axis}", "m") for away in AHEAD for axis in "xy")
    others = ((f"nearest {number + 1}: {name}", unit) for number in range(NEAREST) for name, unit in EACH)
    return (*OWN, *ahead, *others)


EGOCENTRIC = _egocentric()
assert len(EGOCENTRIC) == WIDTH

# -- lanes -------------------------------------------------------------------------------------------------------------


class Lanes:
    """So many scenes of a program side by side. A lane without a scene, or whose run has ended, rests."""

    def __init__(
        self,
        program: Program,
        count: int,
        config: SimulationConfig,
        contact: ContactConfig = CONTACT,
        records: bool = True,
        jobs: int = 1,
    ) -> None:
        if not program.controls:
            raise ArgumentError(
                f"nobody in {program.name} is driven from outside",
                "give an object a controller: `with behavior ExternalBehavior()`",
            )
        self.program, self.controls, self._jobs = program, program.controls, jobs
        self._every = [max(1, turns(each.every, config.time_step)) for each in self.controls]
        self._delay = [turns(each.delay, config.time_step) for each in self.controls]
        self.plan = plan(program, config, contact, pause=math.gcd(*self._every))
        self._run = lanes(program, self.plan.layout.last_sample + 1, count)
        self._status = self._run.lane_live[:, -len(Status) :]
        self._parts: dict[tuple[int, int], Run] = {}
        self._scenes = _no_scenes(program, count)
        self.results = empty_results(program, self._scenes)
        self._columns = columns(self.controls)
        self._paths = np.full((count, len(program.actors)), -1, dtype=np.int32)
        self._reach = np.full(count, np.inf)
        kept = [record.rule for record in program.records if record.when == "series"]
        self._rules = kept if records else []

    def __len__(self) -> int:
        return len(self._reach)

    @cached_property
    def nbytes(self) -> int:
        """Memory of all lanes."""
        groups = (self._run, self._scenes, self.results)
        return sum(each.nbytes for group in groups for each in _arrays(group))

    def copied(self) -> tuple[NDArray[Any], ...]:
        """The results as they are now."""
        return tuple(each.copy() for each in _arrays(self.results))

    @property
    def turns(self) -> int:
        """Rows of what is decided in a lane …"""
        return int(self._run.lane_actions.shape[1])

    @property
    def numbers(self) -> int:
        """… and numbers in a row."""
        return int(self._run.lane_actions.shape[2])

    # -- scenes and their ends ---------------------------------------------------------------------------------------

    def place(self, chosen: Ints, scenes: Scenes) -> None:
        """Put scenes into the chosen lanes; their runs begin with the next step."""
        for array, name in ((self._scenes.verdict, "verdict"), (self._scenes.variant, "variant")):
            array[chosen] = getattr(scenes, name)
        self._scenes.values[chosen], self._scenes.keys[chosen] = scenes.values, scenes.keys
        blank = empty_results(self.program, self._scenes._replace(verdict=self._scenes.verdict[chosen]))
        for array, fresh in zip(_arrays(self.results), _arrays(blank), strict=True):
            array[chosen] = fresh
        begin_lanes(self.plan, self._scenes, chosen.astype(np.int32), self._run)
        self._paths[chosen] = self.program.routes[np.maximum(scenes.variant, 0)]
        self._reach[chosen] = weather_sight(self.program, scenes)
        self._neutral(chosen, scenes)

    def _neutral(self, chosen: Ints, scenes: Scenes) -> None:
        """Until the first decision comes into effect everybody rolls on, or keeps its speed."""
        self._run.lane_actions[chosen] = 0.0
        for control, column in zip(self.controls, self._columns, strict=True):
            if control.names[0] == "target_speed":
                start = [actor_columns(self.program, row)[control.actor, Column.SPEED] for row in scenes.values]
                self._run.lane_actions[chosen, :, column.start] = np.array(start)[:, np.newaxis]

    @property
    def running(self) -> Bools:
        """(lanes,) where a run has not ended."""
        return (self._scenes.verdict == Verdict.VALID) & (self.results.end_reason == RUNNING)

    @property
    def samples(self) -> Ints:
        """(lanes,) the current one of each."""
        return self._status[:, Status.SAMPLE]

    @property
    def times(self) -> Floats:
        """(lanes,) of the current samples [s]."""
        return np.asarray(self.samples * self.plan.layout.time_step, dtype=np.float64)

    # -- stepping ----------------------------------------------------------------------------------------------------

    def step(self) -> None:
        """Run all lanes on: to the next sample at which somebody is asked, or to the end."""
        rows = judge_rows if len(self.program.judged) else simulate_rows

        def run(first: int, last: int) -> None:
            outlines = np.zeros((len(self.program.actors), 3))
            rows(self.plan, self._scenes, first, last, self._part(first, last), outlines, self.results)

        if len(self) > CHUNK and self._jobs > 1:
            in_parts(len(self), self._jobs, run)
        else:
            run(0, len(self))  # a thread starts no faster than these step

    def _part(self, first: int, last: int) -> Run:
        """Some lanes, with a memory of their own to work in."""
        if last - first == len(self):
            return self._run
        if (first, last) not in self._parts:
            arrays = self._run._asdict()
            parts = {name: array[first:last] for name, array in arrays.items() if name.startswith("lane_")}
            self._parts[first, last] = memory(self.program, self.plan.layout.last_sample + 1)._replace(**parts)
        return self._parts[first, last]

    def lose(self, chosen: Bools) -> None:
        """Let the chosen lanes rest: what their controller decides cannot be driven."""
        self.results.verdict[chosen] = self._scenes.verdict[chosen] = Verdict.CONTROLLER
        self._status[chosen, Status.END] = EMPTY

    def asked(self, number: int) -> Bools:
        """(lanes,) where the control of this number is asked at the current sample."""
        paused = self._status[:, Status.PAUSED] == 1
        return self.running & paused & (self.samples % self._every[number] == 0)

    def observe(self, number: int, chosen: Bools, out: Floats) -> None:
        """Write what the control of this number observes into the rows of `out` (lanes, d) of the chosen lanes."""
        lane = np.flatnonzero(chosen)
        if self._rules:
            touched = self._status[lane, Status.CONTACT_ONE] >= 0
            sample = self.samples[lane] - touched
            out[lane] = self._run.lane_watched[lane[:, np.newaxis], sample[:, np.newaxis], np.array(self._rules)]
            return
        actor = self.controls[number].actor
        path = np.ascontiguousarray(self._paths[:, actor])
        look_around(self.plan, self._run, actor, path, self._reach, lane.astype(np.int32), out)

    def decide(self, number: int, chosen: Bools, actions: Floats) -> None:
        """Let the chosen lanes do `actions` (lanes, a) from now, or from the delay on, until the next ones."""
        lane = np.flatnonzero(chosen)
        first = self.samples[lane] + self._delay[number]
        last = len(self._run.lane_actions[0]) - 1
        for later in range(self._every[number]):
            self._run.lane_actions[lane, np.minimum(first + later, last), self._columns[number]] = actions[lane]

    def decided(self, chosen: Ints) -> Floats:
        """(chosen, turns, numbers): what was decided in the chosen lanes; after its end a run's last turn goes on."""
        decided, last = self._run.lane_actions[chosen], self.samples[chosen]
        later = np.arange(self.turns) > last[:, np.newaxis]
        np.copyto(decided, decided[np.arange(len(last)), last][:, np.newaxis], where=later[:, :, np.newaxis])
        return decided


def _arrays(group: object) -> tuple[NDArray[Any], ...]:
    """A named tuple as the arrays that it holds."""
    return cast("tuple[NDArray[Any], ...]", group)


def _no_scenes(program: Program, count: int) -> Requested:
    """Room for scenes, none of which is valid."""
    width = len(program.code.output_register[0])
    return Requested(
        verdict=np.full(count, int(Verdict.EXHAUSTED), dtype=np.int32),
        variant=np.zeros(count, dtype=np.int64),
        values=np.zeros((count, width)),
        keys=np.zeros((count, 6), dtype=np.int64),
        actions=np.zeros((count, 0, numbers_decided(program.controls))),
    )


def names_of(controls: Sequence[Control]) -> tuple[str, ...]:
    """The controllers by name."""
    return tuple(control.controller for control in controls)

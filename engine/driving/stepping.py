"""Parallel runs that are stepped from one query of a controller to the next.

A stepped run is the run of the batch host: the same kernel, which pauses at a sample between the rules and the turns.
During a pause the slots are observed and controllers decide; the next call continues. A slot stores the state of its
run and the decisions in it (`DecisionPages`). With these decisions any host repeats a finished run
without the controller. The batch host assesses it that way, and the memory of a scene does not depend on the measures
that are requested. If no formula or objective reads the run, its record is measured without a repetition
(`engine.kernels.review`): of an ego and one other actor the commands are stored, of more actors the states.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from engine.config import ContactConfig, SimulationConfig
from engine.control import Control, columns, numbers_decided, turns
from engine.driving.observations import REWARD, series
from engine.errors import ArgumentError
from engine.host import (
    CHUNK,
    empty_results,
    in_parts,
    looking_back,
    memory,
    others_touch,
    outcomes,
    parallel_memory,
    plan,
    ring,
    with_slots,
)
from engine.kernels.decision_pages import (
    TOO_NARROW,
    ControlTiming,
    mark_queried,
    mark_running,
    read_decisions,
    store_decisions,
    take_pages,
)
from engine.kernels.egocentric import WIDTH, write_observation
from engine.kernels.review import review_slots
from engine.kernels.rollout import advance
from engine.kernels.rows import Requested, Results, Window, simulate_rows, start_slots
from engine.kernels.run_state import Run, Status
from engine.kernels.slots import COMMAND_COLUMNS, EMPTY, PAGE
from engine.outcomes import Outcomes
from engine.program import Program
from engine.scenes import Scenes, actor_columns, weather_sight
from engine.tables import PLAIN, Bools, Floats, Ints
from engine.vocabulary import STORED, Column, State, Verdict

# -- pages of decisions ------------------------------------------------------------------------------------------------

ROOM = 256
"""Turns per slot for which pages exist from the start; the system provides their memory at the first write."""
SHARE = 32
"""Growth of the page pool when it is exhausted: 1 / SHARE of its size."""


class DecisionPages:
    """Decisions of `controls` in `count` slots for at most `turns_at_most` turns.

    They are stored in pages. A slot takes a page whenever its last one is full, and returns all pages when its next run
    begins, so that memory grows with the length of the runs that happen. The commands or states of the actors are
    stored in pages of the same numbers, if at all.

    `commands`: numbers per turn that store the commands or states of all actors; 0 stores none.
    """

    def __init__(
        self,
        controls: Sequence[Control],
        count: int,
        time_step: float,
        pause: int,
        turns_at_most: int,
        commands: int = 0,
    ) -> None:
        self.timings = [
            ControlTiming(
                its.start, its.stop, turns(each.delay, time_step), max(1, turns(each.every, time_step)), pause
            )
            for each, its in zip(controls, columns(controls), strict=True)
        ]
        self._pause = pause
        self.coming = ring(max(timing.every + timing.delay for timing in self.timings))
        """Rows of the ring of turns whose decisions are known."""
        width = numbers_decided(controls)
        self._neutral = np.zeros((count, width))
        room = count * -(-min(turns_at_most, ROOM) // (pause * PAGE))
        self._stored, self.commands = np.empty((room, PAGE, width)), np.empty((room, PAGE, pause, commands))
        self.pages = np.full((count, 1), -1, dtype=np.int32)
        """(slots, n) Numbers of the pages of each slot, in the order of time; -1 where there is none."""
        self.moves = 0
        """Number of times that an array of pages, or of their numbers, was replaced or moved."""
        self._free, self._left, self._most = _from_first(0, room), np.array([room]), 0

    @property
    def nbytes(self) -> int:
        """Return the largest memory that decisions and commands have used [bytes], without `pages`."""
        page = sum(each.itemsize * math.prod(each.shape[1:]) for each in (self._stored, self.commands))
        return self._most * page + self._free.nbytes + self._neutral.nbytes

    def begin(self, chosen: Ints, neutral: Floats, coming: Floats) -> None:
        """Prepare the chosen slots for runs that begin with the next step.

        `neutral` (chosen, numbers) holds until the first decision. The runs read `coming` (slots, turns, numbers).
        """
        had = self.pages[chosen]
        back, left = had[had >= 0], int(self._left[0])
        self._free[left : left + len(back)] = back
        self._left[0] = left + len(back)
        self.pages[chosen] = -1
        self._neutral[chosen] = neutral
        coming[chosen] = neutral[:, np.newaxis]

    def reserve(self, chosen: Bools, samples: Ints) -> None:
        """Provide a row for the decisions and commands of the chosen slots, which are at `samples` (slots,)."""
        missing = take_pages(chosen, samples, self._pause, self.pages, self._free, self._left)
        if missing == TOO_NARROW:
            self.pages = np.pad(self.pages, ((0, 0), (0, 1)), constant_values=-1)
            self.moves += 1
        elif missing > 0:
            self._make_room(missing)
        else:
            self._most = max(self._most, len(self._stored) - int(self._left[0]))
            return
        self.reserve(chosen, samples)

    def _make_room(self, needed: int) -> None:
        """Add at least `needed` pages to the empty pool."""
        self.moves += 1
        there = len(self._stored)
        more = max(needed, there // SHARE)
        for each in (self._stored, self.commands):
            each.resize((there + more, *each.shape[1:]), refcheck=False)  # in place, or moved without a copy
        self._free = np.concatenate([_from_first(there, more), np.zeros(there, dtype=np.int32)])
        self._left[0] = more

    def decide(self, number: int, chosen: Bools, samples: Ints, actions: Floats, coming: Floats) -> None:
        """Store `actions` (slots, a) of a control in the chosen slots; they hold after its delay."""
        self.reserve(chosen, samples)
        given = np.require(actions, np.float64, PLAIN)
        store_decisions(chosen, samples, given, self.timings[number], self.pages, self._stored, coming)

    def decided(self, chosen: Ints, samples: Ints, out: Floats) -> None:
        """Write the decisions for every turn of the chosen slots, which are at `samples` (chosen,), into `out`.

        `out`: (chosen, turns, numbers). The last decision holds until the end.
        """
        for timing in self.timings:
            read_decisions(chosen, samples, timing, self.pages, self._stored, self._neutral, out)


def _from_first(first: int, count: int) -> Ints:
    """Return `count` page numbers so that the pool, which is taken from its end, touches low pages first."""
    return np.arange(first + count - 1, first - 1, -1, dtype=np.int32)


def command_columns(program: Program) -> Ints:
    """Return (actors,) the columns of the actors' commands, as `kernels.run_state.Run` defines them; none if others
    touch each other, so that commands alone do not determine their motion.

    An actor whose pedals are controlled from outside has no columns of its own: its decision is its command.
    """
    given = {
        control.actor: its.start
        for control, its in zip(program.controls, columns(program.controls), strict=True)
        if control.names[:3] == ("throttle", "brake", "steer")
    }
    if others_touch(program):
        return np.zeros(0, dtype=np.int32)
    others = [actor for actor in range(len(program.actors)) if actor not in given]
    at = [
        COMMAND_COLUMNS * others.index(actor) if actor in others else -1 - given[actor]
        for actor in range(len(program.actors))
    ]
    return np.array(at, dtype=np.int32)


CONTACT = ContactConfig()
AT_ONCE = 64
"""Number of runs that are judged by one call, small enough that their decisions stay in the cache."""


# -- slots -------------------------------------------------------------------------------------------------------------


class ParallelRuns:
    """Runs of `count` scenes of a program. A slot is idle if it has no scene or its run has ended."""

    def __init__(
        self,
        program: Program,
        count: int,
        config: SimulationConfig,
        contact: ContactConfig = CONTACT,
        records: bool = True,
        jobs: int = 1,
        measures: int = STORED,
    ) -> None:
        if not program.controls:
            raise ArgumentError(
                f"nobody in {program.name} is driven from outside",
                "give an object a controller: `with behavior ExternalBehavior()`",
            )
        self.program, self.controls, self._jobs, self.measures = program, program.controls, jobs, measures
        pause = math.gcd(*(max(1, turns(each.every, config.time_step)) for each in self.controls))
        self.plan = plan(program, config, contact, pause=pause, measures=measures)
        self._at_once = self.plan._replace(layout=self.plan.layout._replace(pause=0))
        self._late = len(self.plan.temporal_root) + len(self.plan.objective_root) > 0
        places, width = command_columns(program), len(program.actors) * len(State)
        if len(places):
            width = max(COMMAND_COLUMNS, int(places.max()) + COMMAND_COLUMNS)
        width += len(self.plan.rule_kinds) if self._late else 0
        self._decisions = DecisionPages(self.controls, count, config.time_step, pause, self.turns, width)
        back = min(looking_back(program, config.time_step), self.plan.layout.last_sample)
        run = parallel_memory(program, self.turns, count, back, self._decisions.coming, measures)
        self._run = with_slots(
            run._replace(
                command_columns=places, command_pages=self._decisions.commands, slot_pages=self._decisions.pages
            )
        )
        self._status = self._run.slot_status
        self._moves = 0
        self._scratch: dict[tuple[int, int], Run] = {}
        self._parts: dict[tuple[int, int], Run] = {}
        """The memory in which a thread works, with the slots that it advances; made anew when pages move."""
        self._scenes = _no_scenes(program, count)
        self._results = empty_results(program, self._scenes, measures)
        self._blank = tuple(each[:1].copy() for each in _arrays(self._results))
        self._open = np.zeros(count, dtype=bool)
        self._alone: Run | None = None
        self._paths = np.full((len(program.actors), count), -1, dtype=np.int32)
        self._reach = np.full(count, np.inf)
        rules = {record.name: record.rule for record in series(program)}
        self._reward = rules.pop(REWARD, None)
        self._rules = list(rules.values()) if records else []

    def __len__(self) -> int:
        return len(self._reach)

    @property
    def nbytes(self) -> int:
        """Return the memory of all slots [bytes]; it grows when runs get longer than all before."""
        run = self._run._replace(command_pages=self._decisions.commands[:0])
        groups = (run, run.swept, self._scenes, self._results)
        arrays = (each for group in groups for each in _arrays(group))
        # Slots and handles within handles are no arrays: the memory that they refer to is counted elsewhere.
        return self._decisions.nbytes + sum(each.nbytes for each in arrays if hasattr(each, "nbytes"))

    def copied(self) -> tuple[NDArray[Any], ...]:
        """Return a copy of the current results."""
        return tuple(each.copy() for each in _arrays(self.results))

    @property
    def turns(self) -> int:
        """Return the number of turns of the longest possible run."""
        return int(self.plan.layout.last_sample) + 1

    @property
    def numbers(self) -> int:
        """Return the number of numbers that are decided in a turn."""
        return numbers_decided(self.controls)

    # -- scenes and their ends ---------------------------------------------------------------------------------------

    def place(self, chosen: Ints, scenes: Scenes) -> None:
        """Put scenes into the chosen slots, of those for all slots; their runs begin with the next step."""
        verdict, variant, values = scenes.verdict[chosen], scenes.variant[chosen], scenes.values[chosen]
        self._scenes.verdict[chosen], self._scenes.variant[chosen] = verdict, variant
        for array, blank in zip(_arrays(self._results), self._blank, strict=True):
            array[chosen] = blank
        self._results.verdict[chosen], self._open[chosen] = verdict, verdict == Verdict.VALID
        self._status[chosen, Status.SAMPLE] = 0
        asked = self._scenes._replace(values=scenes.values, keys=scenes.keys)
        start_slots(self.plan, asked, chosen.astype(np.int32), self._run)
        self._paths[:, chosen] = self.program.routes[np.maximum(variant, 0)].T
        self._reach[chosen] = weather_sight(self.program, variant, values)
        self._decisions.begin(chosen, _neutral(self.program, values), self._run.slot_actions)

    @property
    def running(self) -> Bools:
        """Return (slots,) True if the run has not ended."""
        running = np.empty(len(self), dtype=bool)
        mark_running(self._status, self._scenes.verdict, running)
        return running

    @property
    def results(self) -> Results:
        """Judge the runs that have just ended; return the results of all slots, blank for running ones."""
        ended = np.flatnonzero(self._open & ~self.running)
        if len(ended):
            self._open[ended] = False
            self._judge(ended)
        return self._results

    def _judge(self, ended: Ints) -> None:
        """Measure the runs that have ended: on their record, or on a repetition of the run."""
        again = self._status[ended, Status.UNTOLD] == 1
        self._renew_pages()
        self._in_parts(ended[~again], self._review)
        self._in_parts(ended[again], self._run_again)

    def _new_memory(self) -> Run:
        return memory(self.program, self.turns, self.measures)

    def _in_parts(self, ended: Ints, judge: Callable[[Ints], None]) -> None:
        def run(window: Window) -> None:
            for each in range(window.first, window.last, AT_ONCE):
                judge(ended[each : min(each + AT_ONCE, window.last)])

        if len(ended) > AT_ONCE:
            in_parts(len(ended), self._jobs, run)
        else:
            run(Window(0, len(ended)))

    def _review(self, ended: Ints) -> None:
        run = self._with_lanes(self._new_memory()) if self._jobs > 1 else self._run
        actions = self._decided(ended)
        review_slots(self.plan, run, ended, actions, np.zeros((len(self.program.actors), 3)), self._results)

    def _decided(self, ended: Ints) -> Floats:
        """Return the decisions (ended, turns, numbers), with as many turns as the longest run has."""
        samples = self.samples[ended]
        actions = np.empty((len(ended), int(samples.max()) + 1, self.numbers))
        self._decisions.decided(ended, samples, actions)
        return actions

    def _run_again(self, ended: Ints) -> None:
        scenes, first, width = self._scenes, self.plan.layout.scene_values, self._scenes.values.shape[1]
        asked = Requested(
            verdict=scenes.verdict[ended],
            variant=scenes.variant[ended],
            values=self._run.slot_registers[ended, first : first + width],
            keys=self._run.slot_key[ended],
            actions=self._decided(ended),
        )
        found = Results(*(np.repeat(each, len(ended), axis=0) for each in self._blank))
        found.verdict[:] = asked.verdict
        scratch = self._new_memory() if self._alone is None else self._alone
        simulate_rows(
            self._at_once, asked, Window(0, len(ended)), scratch, np.zeros((len(self.program.actors), 3)), found
        )
        if self._jobs == 1:
            self._alone = scratch
        for array, new in zip(_arrays(self._results), _arrays(found), strict=True):
            array[ended] = new

    def outcomes(self, chosen: Ints) -> Outcomes:
        """Return the outcomes of the runs of the chosen slots."""
        return outcomes(Results(*(each[chosen] for each in _arrays(self.results))))

    @property
    def reasons(self) -> Ints:
        """Return (slots,) the reason for each run's end, `RUNNING`, or `EMPTY` of a lost run; if formulas or objectives
        end runs, the reason is known only after judging.
        """
        return self.results.end_reason if self._late else self._status[:, Status.END]

    @property
    def samples(self) -> Ints:
        """Return (slots,) the current sample of each run."""
        return self._status[:, Status.SAMPLE]

    @property
    def states(self) -> Floats:
        """Return (slots, actors, len(State)) the states at the current samples."""
        states = self._run.slot_states
        return np.asarray(states[np.arange(len(self)), self.samples % states.shape[1]])

    @property
    def times(self) -> Floats:
        """Return (slots,) the times of the current samples [s]."""
        return np.asarray(self.samples * self.plan.layout.time_step, dtype=np.float64)

    # -- stepping ----------------------------------------------------------------------------------------------------

    def step(self) -> None:
        """Run all slots to the next sample at which a controller is asked, or to the end."""
        self._decisions.reserve(self.running, self.samples)
        self._renew_pages()

        def run(window: Window) -> None:
            advance(self.plan, self._part(*window), self.turns, True)

        if len(self) > CHUNK and self._jobs > 1:
            in_parts(len(self), self._jobs, run)
        else:
            run(Window(0, len(self)))  # starting threads takes longer than these steps

    def _renew_pages(self) -> None:
        """Take the pages as they are now: where more are needed, they may move in memory."""
        if self._moves != self._decisions.moves:
            self._moves = self._decisions.moves
            self._run = self._run._replace(slot_pages=self._decisions.pages, command_pages=self._decisions.commands)
            self._parts.clear()

    def _part(self, first: int, last: int) -> Run:
        """Return the slots from `first` to before `last`, with their own working memory."""
        if last - first == len(self):
            return self._run
        if (first, last) not in self._parts:
            if (first, last) not in self._scratch:
                self._scratch[first, last] = self._new_memory()
            self._parts[first, last] = self._with_lanes(self._scratch[first, last], first, last)
        return self._parts[first, last]

    def _with_lanes(self, scratch: Run, first: int = 0, last: int | None = None) -> Run:
        """Return working memory combined with some slots."""
        arrays = self._run._asdict()
        slots = {name: array[first:last] for name, array in arrays.items() if name.startswith("slot_")}
        shared = {name: arrays[name] for name in ("command_pages", "command_columns")}
        return with_slots(scratch._replace(**shared, **slots))

    def lose(self, chosen: Bools) -> None:
        """End the runs of the chosen slots with the verdict CONTROLLER: their actions cannot be driven."""
        self._results.verdict[chosen] = self._scenes.verdict[chosen] = Verdict.CONTROLLER
        self._open[chosen] = False
        self._status[chosen, Status.END] = EMPTY

    def asked(self, number: int) -> Bools:
        """Return (slots,) True if the control of this number is asked at the current sample."""
        asked = np.empty(len(self), dtype=bool)
        mark_queried(self._status, self._scenes.verdict, self._decisions.timings[number].every, asked)
        return asked

    def observe(self, number: int, chosen: Bools) -> Floats:
        """Return (slots, d) the observations of the control of this number in the chosen slots, and zeros in all
        others.
        """
        if self._rules:
            return np.where(chosen[:, np.newaxis], self._run.slot_watched[:, self._rules], 0.0)
        actor, seen = self.controls[number].actor, np.empty((len(self), WIDTH))
        write_observation(self.plan, self._run, actor, self._paths[actor], self._reach, chosen, seen)
        return seen

    @property
    def rewarded(self) -> Floats | None:
        """Return (slots,) a copy of the record `reward` at the current samples; None if the file has no such record."""
        return None if self._reward is None else self._run.slot_watched[:, self._reward].copy()

    def decide(self, number: int, chosen: Bools, actions: Floats) -> None:
        """Apply `actions` (slots, a) in the chosen slots from now, or from the delay on, until the next decision."""
        self._decisions.decide(number, chosen, self.samples, actions, self._run.slot_actions)
        self._renew_pages()

    def decided(self, chosen: Ints, out: Floats | None = None) -> Floats:
        """Return (chosen, turns, numbers) the decisions in the chosen slots; after the end the last decision is
        repeated.
        """
        if out is None:
            out = np.empty((len(chosen), self.turns, self.numbers))
        self._decisions.decided(chosen, self.samples[chosen], out)
        return out


def _arrays(group: object) -> tuple[NDArray[Any], ...]:
    """Return a named tuple as its arrays."""
    return cast("tuple[NDArray[Any], ...]", group)


def _neutral(program: Program, values: Floats) -> Floats:
    """Return (n, numbers) the decisions before the first one takes effect in scenes with these values: zeros, or the
    initial speed.
    """
    neutral = np.zeros((len(values), numbers_decided(program.controls)))
    for control, its in zip(program.controls, columns(program.controls), strict=True):
        if control.names[0] == "target_speed":
            neutral[:, its.start] = [actor_columns(program, row)[control.actor, Column.SPEED] for row in values]
    return neutral


def _no_scenes(program: Program, count: int) -> Requested:
    """Return `count` scenes, none of which is valid."""
    width = len(program.code.output_register[0])
    return Requested(
        verdict=np.full(count, int(Verdict.EXHAUSTED), dtype=np.int32),
        variant=np.zeros(count, dtype=np.int64),
        values=np.zeros((0, width)),
        keys=np.zeros((0, 6), dtype=np.int64),
        actions=np.zeros((count, 0, numbers_decided(program.controls))),
    )


def names_of(controls: Sequence[Control]) -> tuple[str, ...]:
    """Return the names of the controllers."""
    return tuple(control.controller for control in controls)

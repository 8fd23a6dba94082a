"""How much more scenes cost that are driven from outside, and how much memory they take.

    python -m benchmarks.environment [LANES] [FILE]

Each figure is the least of nine, taken in turns with what it is compared to. The controller is a constant, so that what
is measured is the stepping, default observation included:

- scenes stepped side by side, against the same scenes in the batch host: CPU time on one thread; they come to the same
  bits, which is asserted. Its parts, each the least of nine, too: what one question to the controller costs
- an environment whose episodes go on for ever, against drawing and running as many scenes in the batch host
- a controller in a process of its own, which shares memory or is sent all, against the same one here, at 1,024 scenes:
  time on the clock
- the most memory that environments of the examples A to F take on their way, asked every 0.1 s and in each step
"""

import re
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np

import cortex_dsl as cx
from benchmarks.drivers import EXAMPLES, ROOT
from engine import batch
from engine.driving.blocks import Driven, Driver
from engine.driving.controllers import seats_of
from engine.driving.named import named_driver
from engine.driving.stepping import ParallelRuns
from engine.environment import Environment
from engine.outcomes import Outcomes
from engine.scenes import Scenes
from engine.tables import Floats

FILE = "examples/own_driver/crossing.scn"
DECIDED = (0.3, 0.0, 0.0)
TURNS = 9
PARTS = ("beginning", "running on", "observing", "asking and deciding", "judging", "telling what was decided")
STEPS = 150
"""Of an environment, after as many that are not counted."""
BESIDE = 1024
CLIENT = """
import json, mmap, os
import numpy as np
read = os.fdopen(int(os.environ["CORTEXC_READ"]), "rb")
write = os.fdopen(int(os.environ["CORTEXC_WRITE"]), "wb", buffering=0)
header = json.loads(read.readline())
n, wide, memory = header["lanes"], len(header["observations"]), header.get("memory") if SHARES else None
if memory:
    room = mmap.mmap(int(os.environ["CORTEXC_MEMORY"]), memory["size"])
    np.ndarray((n, len(header["actions"])), "<f8", room, memory["actions"])[:] = DECIDED
    answer, size = b"!", 8
else:
    answer, size = np.tile(DECIDED, (n, 1)).astype("<f8").tobytes(), 8 + 8 * n + 48 * n + 2 * n + 8 * n * wide
write.write(b'{"version": 1, "memory": true}\\n' if memory else b'{"version": 1}\\n')
while len(read.read(size)) == size:
    write.write(answer)
"""
Made = TypeVar("Made")


def constant(seen: Floats) -> Floats:
    """A controller that costs nothing."""
    return np.broadcast_to(DECIDED, (len(seen), len(DECIDED)))


def main(lanes: int = 4096, file: str = FILE) -> None:
    scenario = cx.load(file)
    print(f"{file}, {lanes:,} scenes")
    stepping(scenario, lanes)
    episodes(scenario, lanes)
    processes(scenario, BESIDE)
    memories()


def stepping(scenario: cx.Scenario, lanes: int) -> None:
    """Scenes side by side, and one after the other."""
    program, config, scenes = scenario.program, scenario.config.simulation, scenario.sample(lanes, seed=1)
    driven = Driver(constant, block=lanes).drive(program, scenes, config)
    outcomes = batch.simulate(program, driven.scenes, config)
    assert_same_ends(scenario, scenes, outcomes)
    for field in fields(outcomes):
        ours, theirs = getattr(driven.outcomes, field.name), getattr(outcomes, field.name)
        assert np.array_equal(ours, theirs, equal_nan=ours.dtype.kind == "f"), field.name
    stepped, at_once = in_turns(
        lambda: Driver(constant, block=lanes).drive(program, scenes, config),
        lambda: batch.simulate(program, driven.scenes, config),
        time.process_time,
    )
    steps = int(outcomes.steps[driven.scenes.valid].sum())
    print(
        f"  stepped {steps / stepped:,.0f} steps a second, batch {steps / at_once:,.0f}: {stepped / at_once:.2f} times"
    )
    each = np.min([_parts(scenario, scenes) for _ in range(TURNS)], axis=0)
    for name, seconds in zip(PARTS, each, strict=True):
        print(f"    {name}: {seconds / steps * 1e9:.0f} ns a step, {seconds / at_once:.2f} of the batch host's")


def _parts(scenario: cx.Scenario, scenes: Scenes) -> list[float]:
    """How long each of `PARTS` takes [s]."""
    program, config, spent, since = (
        scenario.program,
        scenario.config.simulation,
        [0.0] * len(PARTS),
        time.process_time(),
    )

    def lap(part: int) -> None:
        nonlocal since
        before, since = since, time.process_time()
        spent[part] += since - before

    (seat,) = seats_of(program, constant)
    runs, every = ParallelRuns(program, len(scenes), config), np.arange(len(scenes))
    runs.place(every, scenes)
    lap(0)
    runs.step()
    lap(1)
    while runs.running.any():
        asked = runs.asked(0)
        seen = runs.observe(0, asked)
        lap(2)
        runs.decide(0, asked, seat.act(seen, asked, runs.times))
        lap(3)
        runs.step()
        lap(1)
    runs.copied()
    lap(4)
    runs.decided(every)
    lap(5)
    return spent


def assert_same_ends(scenario: cx.Scenario, scenes: Scenes, outcomes: Outcomes) -> None:
    """Before they are judged, stepped runs have come to the same ends, everybody in the same place, bit for bit."""
    program, config = scenario.program, scenario.config.simulation
    runs, every = ParallelRuns(program, len(scenes), config), np.arange(len(scenes))
    runs.place(every, scenes)
    runs.step()
    while runs.running.any():
        runs.decide(0, runs.asked(0), constant(np.empty((len(scenes), 0))))
        runs.step()
    valid = scenes.valid
    assert np.array_equal(runs.samples[valid], outcomes.steps[valid])
    assert np.array_equal(runs.reasons[valid], outcomes.end_reason[valid])
    decided, states = replace(scenes, actions=runs.decided(every)), runs.states
    for row in np.flatnonzero(valid & ~outcomes.collided):
        assert np.array_equal(states[row], batch.trajectory(program, decided, int(row), config).states[-1])


def episodes(scenario: cx.Scenario, lanes: int) -> None:
    """An environment in its stride, and the batch host on as many steps of scenes that are drawn for it."""
    program, config = scenario.program, scenario.config.simulation
    environment = scenario.environment(lanes)
    environment.reset(seed=1)
    actions = np.tile(DECIDED, (lanes, 1))
    for _ in range(STEPS):
        environment.step(actions)
    count = 0

    def step() -> None:
        nonlocal count
        for _ in range(STEPS):
            count += steps_of(environment, actions)

    driven = Driver(constant, block=lanes).drive(program, scenario.sample(lanes, seed=1), config).scenes

    def run() -> None:
        scenario.sample(lanes, seed=1)
        batch.simulate(program, driven, config)

    steps = int(batch.simulate(program, driven, config).steps[driven.valid].sum())
    stepped, at_once = in_turns(step, run, time.process_time)
    mine, theirs = count / TURNS / stepped, steps / at_once
    print(f"  environment {mine:,.0f} steps a second, drawn and run at once {theirs:,.0f}: {theirs / mine:.2f} times")
    print(f"  {environment.nbytes / lanes / 1000:.1f} kB a scene")


def steps_of(environment: Environment, actions: Floats) -> int:
    """Return the steps that all slots simulate up to the next question; a new episode counts from its beginning."""
    runs = environment.episodes.runs
    before = runs.samples.copy()
    environment.step(actions)
    return int(np.where(runs.samples >= before, runs.samples - before, runs.samples).sum())


def processes(scenario: cx.Scenario, lanes: int) -> None:
    """The same controller there and here."""
    program, config, scenes = scenario.program, scenario.config.simulation, scenario.sample(lanes, seed=1)

    def here() -> Driven:
        return Driver(constant, block=lanes).drive(program, scenes, config)

    for shares, how in ((True, "shares memory"), (False, "is sent all")):
        with tempfile.TemporaryDirectory() as folder:
            client = Path(folder) / "client.py"
            client.write_text(CLIENT.replace("DECIDED", str(DECIDED)).replace("SHARES", str(shares)), encoding="utf-8")
            driver = named_driver(f"process:{sys.executable} {client}", lanes)
            there = partial(driver.drive, program, scenes, config)
            assert np.array_equal(there().scenes.actions, here().scenes.actions)
            one, other = in_turns(there, here, time.perf_counter)
        times = f"in {one:.3f} s, here in {other:.3f} s: {one / other:.2f} times"
        print(f"  {lanes:,} scenes driven by a process that {how} {times}")


def memories() -> None:
    """What a scene of each example takes at the most, while episodes follow one another."""
    for name, file in EXAMPLES.items():
        text = (ROOT / "examples" / f"{file}.scn").read_text()
        text = re.sub(r"behavior EgoBehavior.*?\n\n", "", text, count=1, flags=re.DOTALL)
        most = [_most(re.sub(r"simulation\(.*\)", "", text), every) / 1000 for every in ("0.1 s", "0.05 s")]
        print(f"  {name}: {most[0]:.1f} kB a scene asked every 0.1 s, {most[1]:.1f} kB in each step")


def _most(text: str, every: str) -> float:
    external = f"ExternalBehavior(trajectory=egoTrajectory, every={every})"
    environment = cx.compile_text(text.replace("EgoBehavior(egoTrajectory)", external)).environment(BESIDE)
    environment.reset(seed=1)
    actions, most = np.tile(DECIDED, (BESIDE, 1)), 0
    for _ in range(450):  # more than the 400 steps of the longest run
        environment.step(actions)
        most = max(most, environment.nbytes)
    return most / BESIDE


def in_turns(one: Callable[[], Made], other: Callable[[], Made], clock: Callable[[], float]) -> tuple[float, float]:
    """The least time of each [s]."""
    times = np.array([[_timed(each, clock) for each in (one, other)] for _ in range(TURNS)])
    return tuple(times.min(axis=0).tolist())


def _timed(work: Callable[[], Made], clock: Callable[[], float]) -> float:
    begun = clock()
    work()
    return clock() - begun


if __name__ == "__main__":
    main(*(int(word) if word.isdigit() else word for word in sys.argv[1:]))  # type: ignore[arg-type]

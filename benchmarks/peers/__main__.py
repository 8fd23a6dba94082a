"""How fast are we beside other tools, with blind drivers and with drivers that react? `python -m benchmarks.peers`

Rates per second of processor time on one thread; rounds in which each tool has its turn, and medians of the ratios
within a round. The other tools are installed once, each in an environment of its own (`.validate`).

- Scenic 3.1.1 with its Newtonian simulator reads the same file, `left_turn.scenic`, on the same OpenDRIVE road: the
  blind ego follows its trajectory, the one that reacts brakes while anything is within 10 m
- a pymunk loop is what one writes by hand for this one scenario: no road, no requirements, no metrics but the distance
- highway-env has no such crossing: two cars on its highway, one of them an IDM vehicle with MOBIL; its
  environment, with the default observation, is compared to ours on `examples/own_driver/crossing.scn`
- `competent` is our library driver that gives way and brakes in an emergency (`careful_left_against_crossing.scn`); no
  other tool has one

Scenes per second are drawn by rejection. Vehicle-seconds count simulated time only up to the end of each run, which for
us and pymunk is the first contact; Scenic's simulator has no contact.
"""

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

import cortex_dsl as cx
from benchmarks.environment import steps_of
from benchmarks.validation.environments import python_of, set_up
from engine.interchange import Provenance
from engine.interchange.opendrive import write_opendrive
from engine.maps import RoadSpec

HERE = Path(__file__).parent
TOOLS = {"scenic": "Scenic", "highway": "highway-env", "pymunk": "pymunk loop"}
COMPETENT = HERE.parent / "careful_left_against_crossing.scn"
ENVIRONMENT = HERE.parents[1] / "examples" / "own_driver" / "crossing.scn"
STEP = 0.05
"""[s], in all tools."""
EVERY = 0.1
"""From one action of an environment to the next, as `ENVIRONMENT` states it [s]."""
REACTING = "EgoBehavior(egoTrajectory)"
BLIND = "FollowTrajectoryBehavior(target_speed=EGO_SPEED, trajectory=egoTrajectory)"
SCENES, LANES = 2_000, 4_096

Rates = dict[str, float]
"""Of one tool, by row."""


def main() -> None:
    """Measure in rounds and print a table, or with --json one document."""
    parser = argparse.ArgumentParser(description="Compare with Scenic, highway-env and a pymunk loop.")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=4.0, help="processor time of each measurement")
    arguments = parser.parse_args()
    set_up(TOOLS, sys.executable, lambda line: print(line, file=sys.stderr))
    with tempfile.TemporaryDirectory() as folder:
        files = prepared(Path(folder))
        ours = Ours(files, arguments.seconds)
        rounds = [
            {"cortexc": ours.measured(), **dict(theirs(files, arguments.seconds))} for _ in range(arguments.rounds)
        ]
    report = summary(rounds)
    if arguments.json:
        print(json.dumps(report, indent=2))
    else:
        show(report)


def prepared(folder: Path) -> dict[str, Path]:
    """Write the road and the file with both egos; return the files by kind of driver."""
    spec = RoadSpec(approach=50.0)
    road = write_opendrive(spec, None, "crossing", Provenance(title="crossing"))
    (folder / "crossing.xodr").write_text(road, encoding="utf-8")
    text = (HERE / "left_turn.scenic").read_text(encoding="utf-8")
    files = {"blind": folder / "blind.scenic", "reacting": folder / "reacting.scenic"}
    files["blind"].write_text(text.replace(f"with behavior {REACTING}", f"with behavior {BLIND}"), encoding="utf-8")
    files["reacting"].write_text(text, encoding="utf-8")
    return files


class Ours:
    """Rates of this package; the kernels are compiled before the first round."""

    def __init__(self, files: dict[str, Path], seconds: float) -> None:
        self._seconds = seconds
        self._scenarios = {kind: cx.load(file) for kind, file in files.items()} | {"competent": cx.load(COMPETENT)}
        self._environment = cx.load(ENVIRONMENT).environment(LANES)
        self._environment.reset(seed=1)
        self._actions = np.tile([0.3, 0.0, 0.0], (LANES, 1))
        for scenario in self._scenarios.values():
            scenario.simulate(scenario.sample(1))

    def measured(self) -> Rates:
        rates: Rates = {}
        for kind, scenario in self._scenarios.items():
            drawing, driving, valid, driven, seed = 0.0, 0.0, 0, 0.0, 0
            while drawing + driving < self._seconds:
                begun = time.process_time()
                scenes = scenario.sample(SCENES, seed=seed)
                drawn = time.process_time()
                outcomes = scenario.simulate(scenes)
                drawing, driving = drawing + drawn - begun, driving + time.process_time() - drawn
                valid, seed = valid + int(scenes.valid.sum()), seed + 1
                driven += 2 * STEP * int(outcomes.steps[scenes.valid].sum())
            rates |= {f"vehicle-seconds, {kind}": driven / driving, f"runs, {kind}": valid / (drawing + driving)}
            if kind == "reacting":
                rates["scenes drawn"] = valid / drawing
        return rates | {"environment": self._stepped()}

    def _stepped(self) -> float:
        steps, begun = 0, time.process_time()
        while (spent := time.process_time() - begun) < self._seconds:
            steps += steps_of(self._environment, self._actions)
        return 2 * STEP * steps / spent


def theirs(files: dict[str, Path], seconds: float) -> Iterator[tuple[str, Rates]]:
    """Each tool with its rates by row."""
    scenic: Rates = {}
    loop: Rates = {}
    for kind, file in files.items():
        found = ask("scenic", str(file), STEP, seconds)
        scenic |= {f"vehicle-seconds, {kind}": found["driven"], f"runs, {kind}": found["runs"]}
        scenic["scenes drawn"] = found["scenes"]
        found = ask("pymunk", int(kind == "reacting"), STEP, seconds)
        loop |= {f"vehicle-seconds, {kind}": found["driven"], f"runs, {kind}": found["runs"]}
    found = ask("highway", STEP, EVERY, seconds)
    highway = {"vehicle-seconds, reacting": found["driven"], "environment": found["asked"]}
    yield from (("scenic", scenic), ("highway", highway), ("pymunk", loop))


def ask(tool: str, *arguments: object) -> Rates:
    """The rates that the tool's script prints."""
    command = [str(python_of(tool)), str(HERE / f"drive_{tool}.py"), *map(str, arguments)]
    output = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    return json.loads(output.splitlines()[-1])


def summary(rounds: list[dict[str, Rates]]) -> dict[str, dict[str, float | None]]:
    """By row: our median rate, and the median ratio to each tool that has the row."""
    return {
        row: {"cortexc": statistics.median(each["cortexc"][row] for each in rounds)}
        | {tool: _ratio(rounds, row, tool) for tool in TOOLS}
        for row in rounds[0]["cortexc"]
    }


def _ratio(rounds: list[dict[str, Rates]], row: str, tool: str) -> float | None:
    found = [each["cortexc"][row] / each[tool][row] for each in rounds if row in each[tool]]
    return statistics.median(found) if found else None


def show(report: dict[str, dict[str, float | None]]) -> None:
    table = Table(title="per second of processor time; how many times as fast as", title_justify="left")
    for name in ("", "cortexc", *TOOLS.values()):
        table.add_column(name, justify="right" if name else "left")
    for row, found in report.items():
        ratios = ("" if found[tool] is None else f"{found[tool]:,.0f} x" for tool in TOOLS)
        table.add_row(row, f"{found['cortexc']:,.0f}", *ratios)
    Console().print(table)


if __name__ == "__main__":
    main()

"""All who run scenes pass numbers of the same types to the kernels, so nothing that takes seconds is compiled twice."""

import subprocess
import sys
from pathlib import Path

EXAMPLES = Path(__file__).parent.parent / "examples"
SCRIPT = """
import sys
from cortex_dsl import load
from engine import batch
from engine.avoidability import avoidability
from engine.driving.blocks import Driver
from engine.fairness import fair_starts
from engine.host import requested
from engine.kernels.rollout import advance, begin
from engine.kernels.rows import measure_run
from engine.verdicts import blame

scenario = load(sys.argv[1])
scenes = scenario.sample(20, seed=1)
outcomes = scenario.simulate(scenes)
scenario.simulate(scenes, engine="world")
assert outcomes.collided.any()
for row in scenes.valid.nonzero()[0].tolist():
    scenario.watch(scenes, row)
    batch.trajectory(scenario.program, scenes, row)
blame(scenario.program, scenes)
avoidability(scenario.program, scenes)
fair_starts(scenario.program, requested(scenario.program, scenes), scenario.config.simulation)
outside = load(sys.argv[2])
Driver(lambda seen: seen[:, :3] * 0.0).drive(outside.program, outside.sample(20, seed=1))
for kernel in (begin, advance, measure_run):
    assert len(getattr(kernel, "overloads", [None])) == 1, kernel.signatures
"""


def test_hosts_share_one_compiled_step() -> None:
    """In a process of its own: what else a test has called does not count."""
    files = (str(EXAMPLES / "left_turn.scn"), str(EXAMPLES / "own_driver" / "crossing.scn"))
    done = subprocess.run([sys.executable, "-c", SCRIPT, *files], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr

"""Each host passes numbers of the same types to the kernels, so nothing that takes seconds is compiled twice."""

import subprocess
import sys
from pathlib import Path

EXAMPLE = Path(__file__).parent.parent / "examples" / "left_turn.scn"
SCRIPT = """
import sys
from cortex_dsl import load
from engine import batch
from engine.kernels.rollout import advance, begin
from engine.kernels.rows import measure_run

scenario = load(sys.argv[1])
scenes = scenario.sample(20, seed=1)
outcomes = scenario.simulate(scenes)
scenario.simulate(scenes, engine="world")
assert outcomes.collided.any()
for row in scenes.valid.nonzero()[0].tolist():
    scenario.watch(scenes, row)
    batch.trajectory(scenario.program, scenes, row)
for kernel in (begin, advance, measure_run):
    assert len(getattr(kernel, "overloads", [None])) == 1, kernel.signatures
"""


def test_hosts_share_one_compiled_step() -> None:
    """In a process of its own: what else a test has called does not count."""
    done = subprocess.run([sys.executable, "-c", SCRIPT, str(EXAMPLE)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr

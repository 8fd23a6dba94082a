"""Does an adversary that is trained by PPO beat chance? `python -m benchmarks.adversary [STEPS] [SEED ...]`

Runs `examples/own_driver/train_adversary.py`, Stable-Baselines3's own checker first, in an environment of its own with
the CPU wheels of torch, which is installed once. It ends with 1 where in any of the seeds what an episode brings, while
learning or afterwards, is no more than at random in as many steps.
"""

import os
import re
import subprocess
import sys
import sysconfig
import time
from pathlib import Path

from benchmarks.validation.environments import ROOT, SetupError, python_of, set_up

NAME = "adversary"
EXAMPLE = ROOT / "examples" / "own_driver" / "train_adversary.py"
TOLD = re.compile(r"brings (\S+) while learning, (\S+) afterwards, (\S+) at random")


def main(arguments: list[str]) -> int:
    try:
        set_up([NAME], sys.executable, print)
    except SetupError as error:
        print(error, file=sys.stderr)
        return 2
    # Ours and what it needs lie in this environment; torch and Stable-Baselines3 in the other one.
    paths = os.pathsep.join((str(ROOT), sysconfig.get_path("purelib")))
    environment = {**os.environ, "PYTHONPATH": paths, "OMP_NUM_THREADS": "1"}
    begun = time.perf_counter()
    command = [str(python_of(NAME)), str(EXAMPLE), *arguments]
    done = subprocess.run(command, check=False, env=environment, cwd=Path.cwd(), stdout=subprocess.PIPE, text=True)
    print(f"{done.stdout}{time.perf_counter() - begun:.0f} s on one thread")
    return done.returncode or int(not beats(done.stdout))


def beats(told: str) -> bool:
    """Whether in each seed it brought more than chance, while it learnt and afterwards."""
    lines = [tuple(map(float, numbers)) for numbers in TOLD.findall(told)]
    return bool(lines) and all(min(learning, afterwards) > random for learning, afterwards, random in lines)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""Compile the kernels that a search of a scenario needs: `python -m wheels.prepare FILE.scn`, a step of `make demo`."""

import sys

from cortex_dsl.api.scenario import load
from cortex_dsl.console.kernels import SEARCH, compile_kernels
from cortex_dsl.console.terminal import Terminal

if __name__ == "__main__":
    try:
        scenario = load(sys.argv[1])
        compile_kernels(Terminal(), SEARCH, scenario.program, scenario.config)
    except KeyboardInterrupt:
        sys.exit(130)

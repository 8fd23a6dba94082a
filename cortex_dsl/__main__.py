"""`python -m cortex_dsl` is `cortexc`."""

import sys

from cortex_dsl.cli import main

if __name__ == "__main__":
    sys.exit(main())

"""Is anything lost, or different? `python -m benchmarks.torture [--texts 100000] [--runs 5000] [--kills 500]`

Texts of `benchmarks.fuzz` are compiled; of those that compile, so many run to the end: in both hosts,
which must agree (`benchmarks.agreement`), and as the concrete scenario of their scene, which must run to the same bits.
Then processes are killed at random moments: searches, their workers, those of a Dask cluster, studies, exports, the
formatter and a driver's stack. What is left must be whole, and what goes on must end as if nobody had disturbed it.
Exit code 1 if anything is lost, differs or is answered with a traceback.

With `--keep FOLDER` each piece of work is written down once it is done, so that the same command goes on where it was
stopped, and so is every text that breaks something.
"""

import argparse
import json
import sys
import time
from pathlib import Path

from benchmarks.torture.kills import KINDS, killed
from benchmarks.torture.ledger import Ledger
from benchmarks.torture.texts import judged


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--texts", type=int, default=100_000)
    parser.add_argument("--runs", type=int, default=5_000, help="of the texts that compile, these run to the end")
    parser.add_argument("--kills", type=int, default=500)
    parser.add_argument("--kinds", default=",".join(KINDS), help="of kills")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2, help="processes that judge texts")
    parser.add_argument("--keep", type=Path, help="a folder for what was done, and for texts that break something")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    began, keep = time.monotonic(), options.keep
    texts, kills = (Ledger.of(keep and keep / f"{name}.jsonl") for name in ("texts", "kills"))
    found = judged(options.texts, options.runs, options.seed, options.jobs, texts, keep)
    done, wrong = killed(options.kills, options.seed, tuple(options.kinds.split(",")), kills)
    seconds = time.monotonic() - began
    if options.json:
        print(json.dumps({"texts": found, "kills": done, "wrong": wrong, "seconds": seconds}, indent=2))
    else:
        print(f"{options.texts:,} texts: " + ", ".join(f"{count:,} {name}" for name, count in sorted(found.items())))
        print(f"{sum(done.values()):,} kills: " + ", ".join(f"{count:,} {kind}" for kind, count in done.items()))
        print("\n".join(wrong) or ("a text broke something" if found["broken"] else "nothing lost, nothing different"))
        print(f"{seconds:.0f} s")
    return 1 if found["broken"] or wrong else 0


if __name__ == "__main__":
    sys.exit(main())

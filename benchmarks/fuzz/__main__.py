"""Is there an input that breaks a command? `python -m benchmarks.fuzz KIND [options]`: a row for each kind."""

import sys
from collections.abc import Callable, Mapping, Sequence

from benchmarks.fuzz import exports, maps, recordings, texts

KINDS: Mapping[str, Callable[[Sequence[str]], int]] = {
    "texts": texts.main,
    "maps": maps.main,
    "recordings": recordings.main,
    "exports": exports.main,
}


def main() -> int:
    kind, *options = sys.argv[1:] or [""]
    if kind not in KINDS:
        print(f"{__doc__}\nKinds: {', '.join(KINDS)}", file=sys.stderr)
        return 2
    return KINDS[kind](options)


if __name__ == "__main__":
    sys.exit(main())

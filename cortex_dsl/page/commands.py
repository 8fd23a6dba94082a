"""The command line that a page tells its reader to type again."""

from collections.abc import Sequence
from itertools import pairwise
from shlex import join


def again(words: Sequence[str]) -> str:
    """The same words without the folder of results: that one is there by now, and would be refused."""
    after_out = {k for k, pair in enumerate(pairwise(words), start=1) if pair[0] == "--out"}
    kept = [word for k, word in enumerate(words) if k not in after_out and word.partition("=")[0] != "--out"]
    return join(("cortexc", *kept))

"""Switch Python's garbage collector off during a compilation.

Objects of the compiler live until it is done. The collector goes through all of them again and again and finds nothing:
a pass over the tree of a file of 256 KiB takes a tenth of its time, and whether a compilation contains one pass or two
changes how its time grows with the text. Reference counts free unused objects as usual.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

_lock = Lock()
_within: list[bool] = []
"""Whether the collector was on at the start, for each running compilation of any thread."""


@contextmanager
def no_garbage_collected() -> Iterator[None]:
    """Switch the collector off until the last of those within has left, and then on if it was on before."""
    with _lock:
        _within.append(gc.isenabled())
        gc.disable()
    try:
        yield
    finally:
        with _lock:
            was_on = _within.pop()
            if was_on and not _within:
                gc.enable()

"""The elementary functions of this machine, and a name for how they round.

Kernels and roads call sin, exp and others of the mathematical library (libm). These are accurate to about one unit in
the last place, and their last bit depends on the system, on the version of the library, and with glibc on the
processor: it has code of its own for those with fused multiply-add, which differs at one argument in 2,000. A run is
the same, bit for bit, wherever all functions round alike.
"""

import math
import platform
from collections.abc import Iterator
from functools import lru_cache
from hashlib import blake2b
from struct import pack

ARGUMENTS = 1_000
"""Number of arguments at which each function is computed."""
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
"""Its multiples modulo 1 are spread evenly, and are rounded alike on every machine."""


@lru_cache(maxsize=1)
def library() -> str:
    """Return the mathematical library with a digest of how it rounds, such as `glibc 2.36 1b0c5f3a`."""
    values = tuple(_values())
    digest = blake2b(pack(f"<{len(values)}d", *values), digest_size=4).hexdigest()
    return " ".join(part for part in (*platform.libc_ver(), digest) if part)


def _values() -> Iterator[float]:
    """Yield each function at arguments of both signs, as roads, motion and random numbers use them."""
    for k in range(1, ARGUMENTS + 1):
        share = k * GOLDEN % 1.0
        x = 40.0 * (2.0 * share - 1.0)
        yield from (math.sin(x), math.cos(x), math.tan(x), math.atan(x), math.tanh(x))
        yield from (math.asin(x / 40.0), math.acos(x / 40.0), math.atan2(x, share + 0.5), math.hypot(x, share))
        yield from (math.exp(x / 4.0), math.expm1(x / 40.0), math.log(share), math.log1p(share), math.pow(share, x))

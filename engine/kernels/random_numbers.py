"""Random numbers as a pure function of an address, and the normal law that transforms uniform numbers.

Philox4x32-10, Salmon, Moraes, Dror and Shaw (2011), "Parallel random numbers: as easy as 1, 2, 3", SC'11: ten rounds of
multiply and exclusive-or turn a 128-bit counter under a 64-bit key into 128 random bits. There is no state: equal
addresses give equal numbers, whatever was drawn before or concurrently. `engine.streams` defines the layout of
addresses. The module also has the quantile and cumulative functions of the normal distribution, and gene values from
them.
"""

import math
from typing import NamedTuple

import numpy as np

from engine.kernels import scalars
from engine.kernels.jit import inlined, kernel
from engine.tables import Floats, Ints

# numba converts a mixture of uint64 and int64 to float, so every integer in this module is a uint64.
MULTIPLIER_0 = np.uint64(0xD2511F53)
MULTIPLIER_1 = np.uint64(0xCD9E8D57)
WEYL_0 = np.uint64(0x9E3779B9)
WEYL_1 = np.uint64(0xBB67AE85)
WORD = np.uint64(0xFFFFFFFF)
WORD_BITS = np.uint64(32)
HALF_WORD_BITS = np.uint64(16)
EXCESS_BITS = np.uint64(11)
LABEL_BITS = np.uint64(4)
NIBBLE = np.uint64(0xF)
BYTE_BITS = np.uint64(8)
ONE = np.uint64(1)
DOUBLE_STEP = 2.0**-53

ATTEMPT_CHANNEL = 0
"""Channel of variants and nuisance draws of a scene's attempts; also the only channel of the other purposes. A channel
has four bits.
"""
COIN_CHANNEL = 1
"""Channel of the coins of `require[p]`, one number per requirement."""
GENE_CHANNEL = 2
"""Channel of gene values, one number per gene."""
JUMP_CHANNEL = 3
"""Channel of the attempts that a pruned scene skips, one number per attempt."""


class Stream(NamedTuple):
    """All parts of an address except the block number; 32-bit words stored as uint64."""

    key_0: np.uint64
    key_1: np.uint64
    counter_1: np.uint64
    counter_2: np.uint64
    counter_3: np.uint64


@inlined
def philox4x32(
    key_0: np.uint64, key_1: np.uint64, a: np.uint64, b: np.uint64, c: np.uint64, d: np.uint64
) -> tuple[np.uint64, np.uint64, np.uint64, np.uint64]:
    """Return four random 32-bit words from the counter (a, b, c, d) under the key."""
    for _ in range(10):
        product_0 = MULTIPLIER_0 * a
        product_1 = MULTIPLIER_1 * c
        a, c = (product_1 >> WORD_BITS) ^ b ^ key_0, (product_0 >> WORD_BITS) ^ d ^ key_1
        b, d = product_1 & WORD, product_0 & WORD
        key_0, key_1 = (key_0 + WEYL_0) & WORD, (key_1 + WEYL_1) & WORD
    return a, b, c, d


@kernel
def open_stream(key: Ints, purpose: int, channel: int) -> Stream:
    """Return the stream of a `StreamKey` row (6,) for a purpose; the row's fields must fit (see `engine.streams`)."""
    seed = np.uint64(key[0])
    method, run, generation = np.uint64(key[1]), np.uint64(key[2]), np.uint64(key[3])
    place = (method >> LABEL_BITS & NIBBLE) << LABEL_BITS | np.uint64(channel)
    label = (place << LABEL_BITS | np.uint64(purpose)) << LABEL_BITS | method & NIBBLE
    return Stream(
        seed & WORD,
        seed >> WORD_BITS ^ method >> BYTE_BITS,
        np.uint64(key[4]),
        run << HALF_WORD_BITS | generation,
        np.uint64(key[5]) << HALF_WORD_BITS | label,
    )


@inlined
def uniform_pair(stream: Stream, block: np.uint64) -> tuple[float, float]:
    """Return numbers 2 * block and 2 * block + 1 of a stream: uniform multiples of 2^-53 in [0, 1)."""
    a, b, c, d = philox4x32(stream.key_0, stream.key_1, block, stream.counter_1, stream.counter_2, stream.counter_3)
    first = float((a << WORD_BITS | b) >> EXCESS_BITS) * DOUBLE_STEP
    return first, float((c << WORD_BITS | d) >> EXCESS_BITS) * DOUBLE_STEP


@kernel
def uniform(stream: Stream, number: int) -> float:
    """Return number `number` of a stream, in [0, 1)."""
    position = np.uint64(number)
    first, second = uniform_pair(stream, position >> ONE)
    return second if position & ONE else first


@kernel
def fill_uniform(keys: Ints, purpose: int, channel: int, out: Floats) -> None:
    """Fill `out` (n, k) with the first k numbers of the stream of each of `keys` (n, 6)."""
    for row in range(out.shape[0]):
        stream = open_stream(keys[row], purpose, channel)
        for column in range(out.shape[1]):
            out[row, column] = uniform(stream, column)


# -- the normal law ----------------------------------------------------------------------------------------------------

SPLIT_CENTRE = 0.425
SPLIT_TAIL = 5.0


normal_cdf = kernel(scalars.normal_cdf)


@kernel
def normal_quantile(p: float) -> float:
    """Return the x below which a standard normal variable is with probability p; -inf at 0, inf at 1, NaN outside.

    Rational approximations with a relative error of about 1e-16: Wichura, M. J. (1988), "Algorithm AS 241: The
    percentage points of the normal distribution", Applied Statistics 37(3), 477-484, routine PPND16.
    """
    q = p - 0.5
    if abs(q) <= SPLIT_CENTRE:
        return q * _centre(SPLIT_CENTRE * SPLIT_CENTRE - q * q)
    tail = p if q < 0.0 else 1.0 - p
    if not tail > 0.0:
        return math.copysign(math.inf, q) if tail == 0.0 else math.nan
    r = math.sqrt(-math.log(tail))
    size = _near_tail(r - 1.6) if r <= SPLIT_TAIL else _far_tail(r - SPLIT_TAIL)
    return math.copysign(size, q)


@kernel
def _centre(r: float) -> float:
    """Return quantile / q with q = p - 1/2 for |q| <= 0.425, as a function of 0.425^2 - q^2."""
    numerator = 2.5090809287301226727e3
    numerator = numerator * r + 3.3430575583588128105e4
    numerator = numerator * r + 6.7265770927008700853e4
    numerator = numerator * r + 4.5921953931549871457e4
    numerator = numerator * r + 1.3731693765509461125e4
    numerator = numerator * r + 1.9715909503065514427e3
    numerator = numerator * r + 1.3314166789178437745e2
    numerator = numerator * r + 3.3871328727963666080e0
    denominator = 5.2264952788528545610e3
    denominator = denominator * r + 2.8729085735721942674e4
    denominator = denominator * r + 3.9307895800092710610e4
    denominator = denominator * r + 2.1213794301586595867e4
    denominator = denominator * r + 5.3941960214247511077e3
    denominator = denominator * r + 6.8718700749205790830e2
    denominator = denominator * r + 4.2313330701600911252e1
    return numerator / (denominator * r + 1.0)


@kernel
def _near_tail(r: float) -> float:
    """Return the size of the quantile for tail probabilities down to exp(-25); r = sqrt(-log(tail)) - 1.6."""
    numerator = 7.74545014278341407640e-4
    numerator = numerator * r + 2.27238449892691845833e-2
    numerator = numerator * r + 2.41780725177450611770e-1
    numerator = numerator * r + 1.27045825245236838258e0
    numerator = numerator * r + 3.64784832476320460504e0
    numerator = numerator * r + 5.76949722146069140550e0
    numerator = numerator * r + 4.63033784615654529590e0
    numerator = numerator * r + 1.42343711074968357734e0
    denominator = 1.05075007164441684324e-9
    denominator = denominator * r + 5.47593808499534494600e-4
    denominator = denominator * r + 1.51986665636164571966e-2
    denominator = denominator * r + 1.48103976427480074590e-1
    denominator = denominator * r + 6.89767334985100004550e-1
    denominator = denominator * r + 1.67638483018380384940e0
    denominator = denominator * r + 2.05319162663775882187e0
    return numerator / (denominator * r + 1.0)


@kernel
def _far_tail(r: float) -> float:
    """Return the size of the quantile for tail probabilities below exp(-25); r = sqrt(-log(tail)) - 5."""
    numerator = 2.01033439929228813265e-7
    numerator = numerator * r + 2.71155556874348757815e-5
    numerator = numerator * r + 1.24266094738807843860e-3
    numerator = numerator * r + 2.65321895265761230930e-2
    numerator = numerator * r + 2.96560571828504891230e-1
    numerator = numerator * r + 1.78482653991729133580e0
    numerator = numerator * r + 5.46378491116411436990e0
    numerator = numerator * r + 6.65790464350110377720e0
    denominator = 2.04426310338993978564e-15
    denominator = denominator * r + 1.42151175831644588870e-7
    denominator = denominator * r + 1.84631831751005468180e-5
    denominator = denominator * r + 7.86869131145613259100e-4
    denominator = denominator * r + 1.48753612908506148525e-2
    denominator = denominator * r + 1.36929880922735805310e-1
    denominator = denominator * r + 5.99832206555887937690e-1
    return numerator / (denominator * r + 1.0)


# -- gene values -------------------------------------------------------------------------------------------------------


@kernel
def truncated_normal(u: float, low: float, high: float, mean: float, deviation: float) -> float:
    """Return the value below which a normal variable confined to [low, high] is with probability u."""
    lower, upper = (low - mean) / deviation, (high - mean) / deviation
    # The lower tail is used, because probabilities near 0 have all their digits.
    if lower > 0.0:
        return _within(mean - deviation * _between(1.0 - u, -upper, -lower), low, high)
    return _within(mean + deviation * _between(u, lower, upper), low, high)


@kernel
def _between(u: float, lower: float, upper: float) -> float:
    start = normal_cdf(lower)
    return normal_quantile(start + u * (normal_cdf(upper) - start))


@kernel
def _within(value: float, low: float, high: float) -> float:
    return math.nan if math.isnan(value) else min(max(value, low), high)


@kernel
def truncated_normals(uniforms: Floats, low: float, high: float, mean: float, deviation: float, out: Floats) -> None:
    """Write `truncated_normal` for each of `uniforms` (n,) into `out` (n,)."""
    for row in range(len(uniforms)):
        out[row] = truncated_normal(uniforms[row], low, high, mean, deviation)

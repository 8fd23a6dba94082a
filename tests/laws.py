"""How many random examples a law of the tests draws: fewer for a push, ten times as many in a night.

A law whose examples take long, such as one that starts two processes for each, is dear: it draws fewer for a push than
its share, and all of them in a night.
"""

from hypothesis import settings

USUAL = 100
"""Examples that a law draws by default, to which the numbers of others are relative."""
FEW = 10
"""Examples of the usual law to which those of a dear law are relative where the usual law draws fewer than `USUAL`."""


def share(number: int, *, dear: bool = False) -> int:
    """Return the number of examples in this profile of a law that draws `number` where the usual law draws 100."""
    usual = settings().max_examples
    return max(2, number * (min(usual, FEW) if dear and usual < USUAL else usual) // USUAL)


def examples(number: int, *, dear: bool = False) -> settings:
    """Return settings for a law that draws `number` examples where the usual law draws 100."""
    return settings(max_examples=share(number, dear=dear))

"""How many random examples a law of the tests draws: fewer for a push, ten times as many in a night."""

from hypothesis import settings

USUAL = 100
"""Examples that a law draws by default, to which the numbers of others are relative."""


def share(number: int) -> int:
    """Return the number of examples in this profile of a law that draws `number` where the usual law draws 100."""
    return max(2, number * settings().max_examples // USUAL)


def examples(number: int) -> settings:
    """Return settings for a law that draws `number` examples where the usual law draws 100."""
    return settings(max_examples=share(number))

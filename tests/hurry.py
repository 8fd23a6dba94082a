"""Laws that are dear to try, as each example builds a road: `make quick` tries fewer."""

from hypothesis import settings


def at_most(examples: int) -> settings:
    """So many examples of a law, or as many as the profile asks for where these are fewer."""
    return settings(max_examples=min(examples, settings().max_examples))

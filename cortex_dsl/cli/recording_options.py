"""The values of options that say how a recording is read; `argparse` reports what is wrong with them."""

import argparse


def rate_of(text: str) -> float:
    """Samples a second."""
    try:
        value = float(text.removesuffix("Hz"))
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be samples a second, not `{text}`") from None
    if not 0.001 <= value <= 100_000.0:
        raise argparse.ArgumentTypeError(f"must lie between 0.001 and 100,000 a second, not {text}")
    return value


def columns_of(text: str) -> tuple[tuple[str, str], ...]:
    """Pairs of what a column is, with its unit if one is said, and what the table calls it."""
    pairs = tuple(
        (name.strip(), column.strip()) for name, _, column in (each.partition("=") for each in text.split(","))
    )
    if not all(name and column for name, column in pairs):
        raise argparse.ArgumentTypeError(f"must be names and columns, as in time=zeit,actor=objekt, not `{text}`")
    for place in (0, 1):
        named = [pair[place] for pair in pairs]
        if twice := next((name for name in named if named.count(name) > 1), None):
            raise argparse.ArgumentTypeError(f"names `{twice}` twice")
    return pairs


def window_of(text: str) -> tuple[float, float]:
    """Begin and end [s]."""
    try:
        begin, end = (float(part.removesuffix("s")) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be two times, as in 12.4,18, not `{text}`") from None
    if not 0.0 <= begin < end < float("inf"):
        raise argparse.ArgumentTypeError(f"must be a time from 0 on and a later one, not `{text}`")
    return begin, end

"""Observations of a controller: the records of the file, or the egocentric vector if it has none."""

from engine.kernels.egocentric import AHEAD, EACH, NEAREST, OWN, WIDTH
from engine.program import Program, Record

REWARD = "reward"
"""Name of the record whose difference is the reward of a step; no controller observes it."""
Named = tuple[tuple[str, str], ...]
"""Names and their SI unit words."""


def observed(program: Program, records: bool = True) -> Named:
    """Return the observations of this program's controllers: the file's records over time without the reward, or the
    egocentric vector if there are no others, or if `records` is False.
    """
    recorded = tuple((record.name, record.unit) for record in series(program) if record.name != REWARD)
    return recorded if recorded and records else EGOCENTRIC


def series(program: Program) -> list[Record]:
    """Return the records over the whole run; those of scenarios that others start have values for a part of it."""
    return [record for record in program.records if record.when == "series" and record.during < 0]


def _egocentric() -> Named:
    ahead = ((f"path {away:g} m ahead: {axis}", "m") for away in AHEAD for axis in "xy")
    others = ((f"nearest {number + 1}: {name}", unit) for number in range(NEAREST) for name, unit in EACH)
    return (*OWN, *ahead, *others)


EGOCENTRIC = _egocentric()
assert len(EGOCENTRIC) == WIDTH

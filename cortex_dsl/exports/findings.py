"""What a check of written files says."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong: where, why, and what to do."""

    place: str
    """File, and element or line: `case.xosc, Private of ego`."""
    reason: str
    cure: str = ""

"""Estimates of the probability of a collision, by any method, and the file next to a run's journal that stores them:
one per method, condition and event.
"""

import json
import math
from collections.abc import Callable
from dataclasses import MISSING, asdict, dataclass, fields
from enum import StrEnum
from itertools import zip_longest
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np

from engine.atomic import write_one
from engine.checksums import is_unchanged, stamp, with_checksum
from engine.errors import ArgumentError
from engine.outcomes import Assessment
from engine.search.probability.unseen import NOTHING_DRAWN, Unseen
from engine.search.statistics import Interval
from engine.search.store import StoreError, store_errors
from engine.strict_json import json_text
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Verdict

NOT_KNOWN = Interval(math.nan, math.nan)
PARAMS, JOINT = CONDITIONS = ("params", "joint")
"""Conditions: a new attempt at a scene samples the scene alone (`params`), or the params too (`joint`)."""
REPETITIONS = 10
"""Independent estimates of subset simulation."""
MOST_DRIVEN = 5_000
"""Collisions of an estimate that the reference driver drives again."""


class Withheld(StrEnum):
    """Why an estimate has no interval."""

    NOTHING = ""
    INVALID = "invalid"
    """Valid runs are too rare to begin with."""
    PLATEAU = "plateau"
    """Too many runs are equally near to a failure."""
    UNREACHED = "unreached"
    """No chain came to a failure."""
    PARTLY = "partly"
    """Some repetitions did not come to a failure."""
    SCATTERED = "scattered"
    """Repetitions differ by more than their mean."""
    FEW = "few"
    """The effective sample size is small."""
    LOST = "lost"
    """The driver failed in some runs."""
    MODES = "modes"
    """The estimate depends on one climb."""
    APART = "apart"
    """The estimates from the chains and from the weighted runs contradict each other."""


Judge = Callable[[Floats, Ints], Bools]
"""(genomes, stream keys) of collisions -> whether a reference driver avoids each."""


@dataclass(frozen=True)
class Probability:
    """An estimate of P(collision | valid run)."""

    method: str
    """A row of `METHODS`."""
    value: float
    """NaN if no estimate is possible; `withheld` has the reason."""
    interval: Interval
    """Confidence interval at `level`; NaN where none can be given."""
    level: float
    simulations: int
    """Simulations of the estimate, invalid ones included."""
    valid: int
    """Valid simulations."""
    collisions: int
    """Valid simulations with a collision; under `subset` these are not independent."""
    valid_share: float
    """Estimated probability that a draw gives a valid run."""
    aborted: int = 0
    """Simulations that a requirement on the run made invalid after they ran."""
    errors: int = 0
    """Simulations that failed, for example because a value did not exist; they count as neither valid nor invalid."""
    lost: int = 0
    """Simulations in which the driver failed, so that their outcome is unknown. The lower end of an interval takes them
    for runs without collision, the upper end for collisions. `valid` does not contain them; under `mc`, `valid_share`
    does.
    """
    levels: tuple[float, ...] = ()
    """Thresholds of the first repetition: least distances of its levels [m]; 0 stands for contact."""
    condition: str = PARAMS
    """`params` or `joint`."""
    max_attempts: int = 0
    """Attempts at a scene for one draw of the params; 0: unknown."""
    avoidable: float = math.nan
    """P(collision that the reference driver avoids | valid run); NaN where none was driven again."""
    avoidable_interval: Interval = NOT_KNOWN
    driven: int = 0
    """Collisions that were driven again for it."""
    by_partner: tuple[int, ...] = ()
    """Collisions with actor 1, actor 2, …; those that are left out at the end were not met. Under `mc` alone."""
    without_ego: int = 0
    """Runs in which two actors other than the ego touched. Under `mc` alone."""
    score: str = "distance"
    """Row of `SCORES` that measures the distance of a run to a failure. Unused under `mc`."""
    withheld: Withheld = Withheld.NOTHING
    """Why there is no interval."""
    tied: float = 0.0
    """Share of a level's runs that lay on a plateau."""
    reached: int = 0
    """Climbs to all failures that came to one; `subset` calls them repetitions."""
    repetitions: int = REPETITIONS
    """Number of these climbs."""
    effective: float = math.nan
    """Effective sample size of the failures. Under `importance` alone."""
    sequence: Interval = NOT_KNOWN
    """Interval that holds the probability at every look, whenever the draws stop, at `level`. Under `mc` alone."""
    unseen: Unseen = NOTHING_DRAWN
    """Kinds of collisions that no draw showed. Under `mc` alone; no bound with `until_width`."""
    until_width: float = 0.0
    """Width of `sequence` at which the draws were to stop; `interval` then is `sequence`. 0: a number of draws."""
    of: str = ""
    """Name of the expectation that is the event instead of a collision; "" for collisions."""


def around(value: float, half: float) -> Interval:
    """Return the interval whose ends are `half` away from the value's logarithm, so never 0, cut off at 1."""
    factor = math.exp(half)
    return Interval(value / factor, min(1.0, value * factor))


def checked_samples(method: str, samples: int, least: int) -> None:
    """Raise ArgumentError unless there are enough."""
    if samples < least:
        raise ArgumentError(f"samples is {samples}; {method} needs at least {least}", "take more")


MOST_FACTOR = 1.5
"""Largest factor between estimates that each leave out one climb, and the estimate from all."""


def disagree(values: Floats) -> bool:
    """Return True unless all values are above 0 and at most a factor of `MOST_FACTOR` apart."""
    return not 0.0 < float(values.max()) <= MOST_FACTOR * float(values.min())


class Count(NamedTuple):
    """Outcome counts of runs."""

    simulations: int = 0
    valid: int = 0
    collisions: int = 0
    aborted: int = 0
    by_partner: tuple[int, ...] = ()
    """Collisions with actor 1, actor 2, … up to the last one that was met."""
    without_ego: int = 0
    errors: int = 0
    lost: int = 0

    def plus(self, other: "Count") -> "Count":
        """Return the sum of both."""
        met = tuple(map(sum, zip_longest(self.by_partner, other.by_partner, fillvalue=0)))
        return Count(
            self.simulations + other.simulations,
            self.valid + other.valid,
            self.collisions + other.collisions,
            self.aborted + other.aborted,
            met,
            self.without_ego + other.without_ego,
            self.errors + other.errors,
            self.lost + other.lost,
        )

    def more(self, runs: Assessment) -> "Count":
        return self.plus(
            Count(
                len(runs),
                int((runs.verdict == Verdict.VALID).sum()),
                int(runs.collided.sum()),
                int((runs.verdict == Verdict.ABORTED).sum()),
                tuple(np.bincount(runs.pair[runs.collided]).tolist()),
                int(np.isfinite(runs.others_contact_time).sum()),
                int((runs.verdict == Verdict.ERROR).sum()),
                int((runs.verdict == Verdict.CONTROLLER).sum()),
            )
        )


# -- estimates with a journal ------------------------------------------------------------------------------------------

FILE_NAME = "probability.json"


_UNSAID = {
    "of": "",
    "errors": 0,
    "lost": 0,
    "repetitions": REPETITIONS,
    "until_width": 0.0,
    "unseen": asdict(NOTHING_DRAWN),
}


def keep(folder: Path, found: Probability, program_digest: str, seed: int) -> Path:
    """Store an estimate for the program with this digest, in place of an earlier one of its kind, and return the file.

    The file is replaced as a whole.

    Raises:
        StoreError: the file cannot be written.
    """
    path = folder / FILE_NAME
    rows = {_place(row): row for row in _rows(path) if row.get("program_digest") == program_digest}
    intervals = {name: list(getattr(found, name)) for name in _INTERVALS}
    named = {"withheld": found.withheld.value, "seed": seed, "program_digest": program_digest}
    row = {**content(found), **intervals, **named}
    rows[_place(row)] = row
    with store_errors(path):
        text = json_text({**stamp(), "estimates": list(rows.values())}, indent=2)
        write_one(path, with_checksum(f"{text}\n"))
    return path


def content(found: Probability) -> dict[str, Any]:
    """Return the fields as documents contain them; some only if they differ from those of an earlier version."""
    return {name: value for name, value in asdict(found).items() if value != _UNSAID.get(name)}


def read_estimates(folder: Path, program_digest: str) -> tuple[Probability, ...]:
    """Return a folder's estimates for the program with this digest, by method and condition.

    Raises:
        StoreError: the file cannot be read as a file of estimates.
    """
    rows = [row for row in _rows(folder / FILE_NAME) if row.get("program_digest") == program_digest]
    try:
        return tuple(sorted(map(_probability, rows), key=lambda found: (found.of, found.method, found.condition)))
    except (KeyError, TypeError, ValueError) as error:
        raise _damaged(folder / FILE_NAME) from error


def _rows(path: Path) -> list[dict[str, Any]]:
    if not path.exists():
        return []
    try:
        file = path.read_bytes()
        content: object = json.loads(file)
    except (OSError, ValueError) as error:
        raise _damaged(path) from error
    if isinstance(content, dict) and is_unchanged(file):
        return cast("dict[str, list[dict[str, Any]]]", content)["estimates"]
    if isinstance(content, list) and all(isinstance(row, dict) for row in cast("list[object]", content)):
        return cast("list[dict[str, Any]]", content)  # of an earlier version, which wrote no checksum
    raise _damaged(path)


def _damaged(path: Path) -> StoreError:
    return StoreError(
        f"`{path}` is not what `cortexc probability` wrote", "remove it, and estimate again by that command"
    )


def _place(row: dict[str, Any]) -> tuple[Any, Any, Any]:
    return row.get("method"), row.get("condition", PARAMS), row.get("of", "")


def _probability(row: dict[str, Any]) -> Probability:
    """Return the estimate of a row; fields that an earlier version did not write are unknown."""
    return Probability(
        **{
            field.name: _value(field.name, row[field.name])
            for field in fields(Probability)
            if field.default is MISSING or field.name in row
        }
    )


_TEXTS = ("method", "condition", "score", "of")
_TUPLES = ("levels", "by_partner")
_INTERVALS = ("interval", "avoidable_interval", "sequence")


def _value(name: str, value: Any) -> Any:
    if name in _TEXTS:
        return str(value)
    if name == "withheld":
        return Withheld(value)
    if name == "unseen":
        return Unseen(**{each: _number(of_each) for each, of_each in value.items()})
    if name in _INTERVALS:
        return Interval(*map(_number, value))
    return tuple(map(_number, value)) if name in _TUPLES else _number(value)


def _number(value: Any) -> Any:
    if value is None:
        return math.nan
    if not isinstance(value, int | float):
        raise TypeError
    return value

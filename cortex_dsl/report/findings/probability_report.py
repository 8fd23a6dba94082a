"""How probable a failure is, in words: the estimate with its interval or the reason for none, and how it was made."""

import math

from cortex_dsl.report.findings.readable import ABSENT, counted, percent, significant, whole
from cortex_dsl.source import Source
from engine.program import Program
from engine.search.probability.estimates import JOINT, Probability, Withheld
from engine.search.probability.levels import SCORES
from engine.search.probability.unseen import Unseen
from engine.search.statistics import Interval

HOW = {
    "mc": "plain Monte Carlo; exact interval of Clopper and Pearson",
    "subset": "subset simulation (Au and Beck 2001); Student's interval over ten independent repetitions",
    "importance": (
        "importance sampling by cross-entropy (Rubinstein and Kroese 2004), a tenth of the draws as the file says; "
        "interval of a mean of independent weights"
    ),
}
"""Estimator and interval of each method."""
STOPPED = "plain Monte Carlo, until the interval is narrow enough; confidence sequence of a beta mixture (Robbins 1970)"
"""Estimator and interval under `--until-width`."""
PLAIN = "`--method mc` needs no distance to failure, and gives an upper bound"
BOUNDS = "`--method mc` gives bounds"
MORE = "take more samples, or `--method mc`"
OTHER = "take more samples, or `--method subset`"
WITHHELD = {
    Withheld.INVALID: ("too few runs are valid to begin with", "`--method mc` uses the valid runs that it finds"),
    Withheld.PLATEAU: ("{tied} of the runs of a level are different and equally near to a failure", PLAIN),
    Withheld.UNREACHED: ("no chain reached a failure", PLAIN),
    Withheld.PARTLY: ("only {reached} of {repetitions} climbs reached a failure", MORE),
    Withheld.SCATTERED: ("the repetitions differ by more than their mean", MORE),
    Withheld.FEW: (
        "the effective sample size of the failures, {effective}, is below 100, or below 4 for each dimension",
        OTHER,
    ),
    Withheld.LOST: ("the driver failed in some runs, and what would have become of them is not known", BOUNDS),
    Withheld.MODES: ("without one climb, the estimate would differ by more than a factor of 1.5", MORE),
    Withheld.APART: ("the chains and the weighted runs are more than a factor of five apart", OTHER),
}
"""Reason of a missing interval, and its cure."""


def withheld_text(found: Probability) -> str:
    """Return reason and cure, as in `no chain reached a failure; …`.

    An estimate of an earlier version has the first reason.
    """
    reason, cure = WITHHELD[found.withheld or Withheld.UNREACHED]
    effective = whole(round(found.effective)) if math.isfinite(found.effective) else ABSENT
    counts = {"reached": found.reached, "repetitions": found.repetitions}
    return f"{reason.format(tied=percent(found.tied, 0), effective=effective, **counts)}; {cure}"


EXPOSURE = "ranges are drawn uniformly, which is not a model of how often such values occur in traffic"
"""Limit of the meaning of such a probability, for a file with a range."""
SAMPLE_TIME = (
    "drivers look and act once in every step of the simulation: in the examples, steps of 0.05 s show 2 to 5 % more "
    "collisions than steps of 0.0025 s"
)
"""Measured by `benchmarks/step_bias.py`; nearly all of it is the drivers' sample time, not the motion."""


RANGES = {"Range", "DiscreteRange", "VerifaiRange", "VerifaiDiscreteRange"}


def exposure_text(program: Program) -> str:
    """Return `EXPOSURE` if the file, or one that it imports, contains a range; else nothing."""
    from cortex_dsl.syntax.parser import read_tokens

    texts = (program.source_text, *(file.text for file in program.imported))
    words = {str(token) for text in texts for token in read_tokens(Source("", text))}
    return EXPOSURE if words & RANGES else ""


def how_drawn(found: Probability) -> str:
    """Return the kind of probability: both differ if some params allow a scene more often than other params."""
    if found.condition == JOINT:
        return "params and scene are drawn again together in every attempt, until the requirements hold"
    often = f" in up to {counted(found.max_attempts, 'attempt')}" if found.max_attempts else ""
    return f"params are drawn once, then a scene for them is drawn{often}"


def probability_text(found: Probability) -> str:
    """The estimate: in percent where that reads well."""
    return _text(found.value)


def interval_text(found: Probability) -> str:
    """`1.20 % .. 1.90 %`."""
    if not math.isfinite(found.interval.low):
        return f"none, as {withheld_text(found)}" if found.valid else "none"
    return _range(found.interval)


def sequence_text(found: Probability) -> str:
    """Return the interval that holds at every look; empty where there is none, or where it is the interval."""
    if found.until_width or not math.isfinite(found.sequence.low):
        return ""
    return f"however often one looks while draws are added: {_range(found.sequence)}"


def unseen_text(unseen: Unseen, failure: str) -> str:
    """Return the probability of kinds of this failure that no draw showed; empty if it is not known."""
    if not math.isfinite(unseen.estimate):
        return ""
    most = f", at most {_text(unseen.bound)}" if math.isfinite(unseen.bound) else ""
    seen = f"{unseen.once} of {counted(unseen.kinds, f'kind of {failure}', f'kinds of {failure}')} seen once"
    return f"{seen} (verdicts aside); all other kinds together: {_text(unseen.estimate)}{most}"


def how_text(found: Probability) -> str:
    """Return estimator and interval."""
    return STOPPED if found.until_width else HOW[found.method]


def avoidable_text(found: Probability) -> str:
    """Return the estimate for a collision that a competent driver avoids."""
    return _text(found.avoidable)


def avoidable_interval_text(found: Probability) -> str:
    if not math.isfinite(found.avoidable_interval.low):
        few = "none" if found.avoidable == 0.0 else "too few"
        return f"none, as {few} of those driven again was one" if found.driven else "not known"
    return _range(found.avoidable_interval)


def _text(value: float) -> str:
    if math.isnan(value):
        return "not known"
    if value >= 0.001:
        return percent(value, 2)
    return "none seen" if value == 0.0 else f"{significant(100.0 * value, 3)} %"


def _range(interval: Interval) -> str:
    """Return both ends in percent, with three digits if the higher one is small."""
    low, high = (percent(end, 2) if interval.high >= 0.001 else f"{significant(100.0 * end, 3)} %" for end in interval)
    return f"{low} .. {high}"


def unknown_text(found: Probability) -> str:
    """Return how often the driver failed, and its meaning; empty without failures."""
    if not found.lost:
        return ""
    driven = found.valid + found.lost
    failed = f"the driver failed in {whole(found.lost)} of {counted(driven, 'run')} ({percent(found.lost / driven)})"
    ends = "" if found.withheld else "; the lower end of the interval counts these as safe, the upper end as failures"
    return f"{failed}: what would have become of them is not known{ends}"


NO_SHARE = {
    "subset": "runs of a chain depend on one another",
    "importance": "more runs are drawn where failures are",
}
"""Why the counted share is not an estimate."""


def levels_text(found: Probability) -> str:
    """`levels of the first repetition: 3.10 m, 0.84 m, failure`; empty where there are none."""
    unit = SCORES[found.score].unit if found.score in SCORES else ""
    steps = ", ".join(f"{level:.2f} {unit}".rstrip() if level else "failure" for level in found.levels)
    of = " of the first repetition" if found.method == "subset" else ""
    return f"levels{of}: {steps}" if steps else ""


def effective_text(found: Probability) -> str:
    """Return the effective sample size of weighted failures; empty if no failures are weighted."""
    if not found.effective > 0.0:
        return ""
    return f"effective sample size of the failures: {whole(round(found.effective))}"


def counts_text(found: Probability) -> str:
    """Return the counts behind the estimate, with a remark if their quotient is not the estimate."""
    tried = "draw" if found.condition == JOINT else "simulation"
    runs = f"{whole(found.valid)} valid of {counted(found.simulations, tried)}"
    if found.method in NO_SHARE:
        return f"{runs}; {NO_SHARE[found.method]}, so the share of failures is not an estimate"
    return f"{counted(found.collisions, 'violation' if found.of else 'collision')} among {runs}"

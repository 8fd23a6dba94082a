"""The reference drivers that judge a collision, in one table, and the verdicts that follow from their answers.

Parameters of all but the first are those of JRC-FSM (commit 01b05c2, `utility/vehicle.py` and `utility/models.py`), the
code of the Joint Research Centre for UN R157; `engine.kernels.references` has the formulas. A model that judges a
situation as its source does has a range: vehicles in one or two lanes of one direction, on a road where it can brake
fully. Outside of it there is a reason instead of an answer.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from engine.errors import ArgumentError, nearest
from engine.tables import Floats, Ints, ReferenceModel
from engine.vocabulary import Answer, Blame, ReferenceKind

SKILLED_BRAKING = 0.774 * 9.81
"""Full braking of the skilled driver of UN R157 [m/s^2]."""
JERK = 12.65
"""Rate at which braking builds up in JRC-FSM [m/s^3]."""
BLANK = ReferenceModel(0, *[0.0] * (len(ReferenceModel._fields) - 1))


@dataclass(frozen=True)
class Reference:
    """One reference driver."""

    name: str
    sentence: str
    source: str
    model: ReferenceModel


REFERENCES = (
    Reference(
        "careful",
        "the careful driver of UN R157, extended to conflicts of any kind: perceives for 0.4 s, brakes 0.75 s later, "
        "by 0.774 g after 0.6 s",
        "UN R157, Annex 4, Appendix 3",
        BLANK._replace(kind=ReferenceKind.CAREFUL, reaction=0.75, braking=SKILLED_BRAKING),
    ),
    Reference(
        "reg157",
        "the requirement on cut-ins: reacts for 0.35 s, brakes by 6 m/s^2; lateral margin 0.5 m",
        "UN R157, 5.2.5.2; JRC-FSM",
        BLANK._replace(
            kind=ReferenceKind.REGULATION, reaction=0.35, braking=6.0, jerk=math.inf, margin=0.5, own=6.0, spare=0.1
        ),
    ),
    Reference(
        "rss",
        "responsibility-sensitive safety: reacts for 0.75 s; safe distances with 6 m/s^2 of braking, 3 m/s^2 of "
        "speeding up, 1 m/s^2 and 0.3 m across",
        "Shalev-Shwartz et al. (2017), arXiv 1708.06374; JRC-FSM",
        BLANK._replace(
            kind=ReferenceKind.RESPONSIBILITY,
            reaction=0.75,
            braking=SKILLED_BRAKING,
            jerk=JERK,
            margin=0.3,
            own=6.0,
            theirs=6.0,
            speeding_up=3.0,
            lateral=1.0,
        ),
    ),
    Reference(
        "fsm",
        "the fuzzy safety model: reacts for 0.75 s, brakes by 4 m/s^2 in comfort and 6 m/s^2 at most, the leader by "
        "7 m/s^2; margins 2 m and 2 m",
        "Mattas et al. (2020), Accident Analysis and Prevention 148, 105794; JRC-FSM",
        BLANK._replace(
            kind=ReferenceKind.FUZZY,
            reaction=0.75,
            braking=6.0,
            jerk=JERK,
            own=6.0,
            theirs=7.0,
            comfortable=4.0,
            room=2.0,
            spare=0.1,
        ),
    ),
    Reference(
        "cc",
        "the careful driver of UN R157 as JRC wrote it: slows down by 0.4 m/s^2 for 0.75 s, then brakes by up to "
        "0.774 g; critical TTC 2 s",
        "UN R157, Annex 4, Appendix 3; JRC-FSM",
        BLANK._replace(
            kind=ReferenceKind.SKILLED,
            reaction=0.75,
            braking=SKILLED_BRAKING,
            jerk=JERK,
            release=0.4,
            critical=2.0,
            alarming=5.0,
        ),
    ),
)
NAMES = tuple(each.name for each in REFERENCES)
OUT_OF_RANGE = {
    Answer.NO_VEHICLE: "a pedestrian or a bicycle took part",
    Answer.CROSSING: "crossing or oncoming traffic",
    Answer.GRIP: "brakes or road too weak for it",
    Answer.REVERSING: "the ego reversed",
}
"""Reason of each answer outside of a model's range."""


def references(names: Sequence[str]) -> tuple[Reference, ...]:
    """Return the reference drivers of these names, in the order of the table.

    Raises:
        ArgumentError: there is no such driver, or no name is given.
    """
    known = ", ".join(NAMES)
    for name in names:
        if name not in NAMES:
            near = nearest(name, NAMES)
            meant = f"did you mean `{near}`? " if near else ""
            raise ArgumentError(f"there is no reference driver `{name}`", f"{meant}there are {known}")
    if not names:
        raise ArgumentError("no reference driver is named", f"name at least one of {known}")
    return tuple(each for each in REFERENCES if each.name in names)


def rows_of(names: Sequence[str]) -> Floats:
    """Return (m, len(ReferenceModel)) the parameters of reference drivers."""
    return np.array([each.model for each in references(names)], dtype=np.float64)


def verdicts(answers: Ints) -> Ints:
    """Return (n,) the `Blame` that follows from the answers (n, drivers) of reference drivers."""
    avoid, collide = (answers == Answer.AVOIDS).any(axis=1), (answers == Answer.COLLIDES).any(axis=1)
    said = np.full(len(answers), int(Blame.NO_MODEL), dtype=np.int32)
    said[avoid & ~collide] = Blame.AVOIDABLE
    said[collide & ~avoid] = Blame.UNAVOIDABLE
    said[avoid & collide] = Blame.DISPUTED
    said[(answers == Answer.STRUCK).all(axis=1)] = Blame.STRUCK
    said[(answers == Answer.NONE).all(axis=1)] = Blame.NONE
    return said


def shares(answers: Ints) -> Floats:
    """Return (n,) the share of the drivers that avoid a collision, among those whose range covers it; else NaN."""
    avoid, collide = (answers == Answer.AVOIDS).sum(axis=1), (answers == Answer.COLLIDES).sum(axis=1)
    with np.errstate(invalid="ignore"):
        return avoid / (avoid + collide)


def answer_counts(names: Sequence[str], answers: Ints) -> dict[str, dict[Answer, int]]:
    """Return how often each of these drivers gave each answer (n, drivers), for the collisions among n scenes."""
    counts = [Counter[int](column[column != Answer.NONE].tolist()) for column in answers.T]
    return {
        name: {Answer(answer): count for answer, count in sorted(found.items())}
        for name, found in zip(names, counts, strict=True)
    }


def joint_verdict(counts: Mapping[str, Mapping[Answer, int]]) -> Blame:
    """Return the verdict on several collisions together, from the answers of each driver to all of them.

    They are avoidable if no answer is a collision, and disputed if answers differ, be it those of one driver.
    """
    said = [answer for each in counts.values() for answer, count in each.items() if count]
    return Blame(int(verdicts(np.array([said]))[0]))

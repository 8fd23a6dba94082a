"""`ReplayBehavior`: an actor that repeats a recorded motion from its start.

Its track is a text in the file, so that the file alone is the case: a line of names, then a row for each sample. The
motion is computed in `engine.kernels.replay`. `cortexc measure --to scn` writes such files.
"""

import math

import numpy as np

from cortex_dsl import ir
from cortex_dsl.semantics.acting.job import Job
from cortex_dsl.semantics.errors.values import BAD_TRACK, WRONG_KIND
from cortex_dsl.semantics.model.wording import kind_name
from engine.tables import Floats

NAMES = ("time", "x", "y", "heading", "speed")
HEAD = ",".join(NAMES)
FARTHEST = 1e7
"""A number beyond this is a slip [m, m/s, rad, s]."""


def replay(job: Job) -> ir.Block:
    """A track to its end, at which the actor leaves."""
    text = job.given("track")
    if not isinstance(text, str):
        raise WRONG_KIND.mistake(
            job.call.spans["track"],
            what="`track`",
            expected="a text",
            actual=kind_name(text),
            cure=f'begin it with """{HEAD}',
        )
    rows = _rows(job, text)
    track = job.ev.file.pool.offset((float(len(rows)), *rows.ravel().tolist()))
    return (ir.Replay(job.call.span, track, job.number("pace", 1.0), job.ev.run.new_local()),)


def _rows(job: Job, text: str) -> Floats:
    """Return the rows (samples, 5): times from 0 on, headings not wrapped.

    Raises:
        Mistake: they are no track.
    """
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    span = job.call.spans["track"]
    if not lines or lines[0].replace(" ", "") != HEAD:
        raise BAD_TRACK.mistake(span, reason=f"its first line is not `{HEAD}`", cure="name these columns, in SI units")
    rows = np.array([_numbers(job, number, line) for number, line in enumerate(lines[1:], 1)]).reshape(-1, len(NAMES))
    if len(rows) < 2:
        raise BAD_TRACK.mistake(span, reason="it has fewer than two rows", cure="write a row for each sample")
    if len(back := np.flatnonzero(np.diff(rows[:, 0]) <= 0.0)):
        reason = f"row {int(back[0]) + 2} is not later than the one before it"
        raise BAD_TRACK.mistake(span, reason=reason, cure="put rows in the order of time, each time once")
    rows[:, 0] -= rows[0, 0]
    rows[:, 3] = np.unwrap(rows[:, 3])
    return rows


def _numbers(job: Job, number: int, line: str) -> list[float]:
    """Return the numbers of a row.

    Raises:
        Mistake: the row is not five finite numbers.
    """
    try:
        found = [float(cell) for cell in line.split(",")]
    except ValueError:
        found = []
    if len(found) != len(NAMES) or not all(math.isfinite(value) and abs(value) <= FARTHEST for value in found):
        reason = f"row {number} does not contain five finite numbers"
        raise BAD_TRACK.mistake(job.call.spans["track"], reason=reason, cure="write only numbers, separated by commas")
    return found

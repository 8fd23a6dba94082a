"""What a file asks to be recorded: the values of each `record` over time, or at one end of it."""

from dataclasses import dataclass

from engine.program import Program
from engine.scenes import Trajectory
from engine.tables import Floats


@dataclass(frozen=True)
class Recorded:
    """The values of one `record` in one run. SI units."""

    name: str
    when: str
    """`series`, or `initial` or `final`: then there is one value."""
    unit: str
    """SI unit word, "" for pure numbers and truths."""
    line: int
    time: Floats
    """(n,) [s]"""
    values: Floats
    """(n,) truths as 1 and 0."""


def recorded(program: Program, trajectory: Trajectory) -> tuple[Recorded, ...]:
    """All records of a program, in the order of the file, from the first sample to the end of the scored run."""
    parts = {"series": slice(None), "initial": slice(None, 1), "final": slice(-1, None)}
    time = trajectory.time[: len(trajectory.watched)]
    return tuple(
        Recorded(
            record.name,
            record.when,
            record.unit,
            record.line,
            time[parts[record.when]],
            trajectory.watched[parts[record.when], record.rule],
        )
        for record in program.records
    )

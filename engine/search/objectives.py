"""The objectives of a search: one table, and the values that each row assigns to simulated scenes.

A row is a function from results to one number per scene; a search maximizes it. To the rows of every file are added one
for each `expect`, `maximize` and `minimize` of the file, and one for each Python function. The paper's risk alone needs
no row: such a search stores and compares the risk only.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from engine.assessment import map_arrays, take
from engine.batch import simulate, trajectory
from engine.config import Config
from engine.errors import ArgumentError, CortexError, nearest
from engine.frozen import frozen
from engine.kernels.conflict import relative_speed
from engine.kernels.references import MOST_MARGIN
from engine.outcomes import Outcomes
from engine.program import Program
from engine.references import shares, verdicts
from engine.risk import Risk
from engine.scenes import Scenes
from engine.search.protocol import DEFAULT_OBJECTIVES, ObjectiveSpec, function_name
from engine.tables import Bools, Floats, Ints
from engine.verdicts import KnownVerdicts, answers_and_margins
from engine.vocabulary import OBJECTIVES, STORED, Blame, Measure, Sense, Verdict

if TYPE_CHECKING:
    from engine.metrics.encounters import Encounter

RENAME = "give it a name of its own, as `def my_objective(outcomes):`"
NO_MEASURES = 0
"""`Objective.reads` of an objective that reads no `Measure`."""
FARTHEST = 60.0
"""Longest conflict gap [s]."""


@frozen
class Runs:
    """Simulated scenes: the argument of an objective."""

    program: Program
    config: Config
    scenes: Scenes
    outcomes: Outcomes
    risk: Risk
    verdicts: KnownVerdicts | None = None
    """Verdicts to which an objective that asks the reference drivers adds."""

    @property
    def valid(self) -> Bools:
        return self.outcomes.verdict == 0

    def only(self, rows: Bools) -> "Runs":
        """Return the chosen rows."""
        parts = {"scenes": self.scenes, "outcomes": self.outcomes, "risk": self.risk}
        return replace(self, **{name: take(part, rows) for name, part in parts.items()})

    @property
    def gaps(self) -> Floats:
        """Return (n, pairs) PET by area [s]; scenes whose host did not record it are simulated again."""
        if self.outcomes.gaps.shape[1] == len(self.program.actors) - 1:
            return self.outcomes.gaps
        jobs, config = self.config.search.jobs, self.config
        return simulate(self.program, self.scenes, config.simulation, jobs, config.contact, measures=Measure.GAPS).gaps

    def encounters(self, row: int) -> "list[Encounter]":
        """Return the pairs of the ego and each actor that it meets, for one valid scene, which is simulated again."""
        from engine.metrics import bodies_of
        from engine.metrics.encounters import Encounter, on_levels

        driven = trajectory(self.program, self.scenes, row, self.config.simulation, self.config.contact)
        driven = on_levels(driven, self.outcomes, row)
        bodies = bodies_of(self.program, self.scenes.values[row])
        pairs = (Encounter(driven, self.outcomes, row, bodies, other) for other in range(1, len(bodies)))
        return [pair for pair in pairs if pair.span[1] > 0]


@frozen
class Objective:
    """One objective. Its function returns (n,) numbers, which are meaningless for invalid scenes."""

    name: str
    sentence: str
    value: Callable[[Runs], Floats]
    finds: Callable[[Runs, Floats], Bools]
    """(runs, values) -> (n,) True for scenes that are finds of such a search."""
    sign: float = 1.0
    """Factor from the maximized number to the displayed number."""
    unit: str = ""
    reads: int = STORED
    """`Measure`s of a run that it reads, which a host computes while it simulates."""
    failures: bool = False
    """True if scenes in which a controller failed count; for all other objectives they are invalid."""

    def counts(self, runs: Runs) -> Bools:
        """Return (n,) True for scenes with a meaningful value."""
        return runs.valid | (self.failures & (runs.outcomes.verdict == Verdict.CONTROLLER))


class ObjectiveError(CortexError):
    """An objective of the user's own cannot be worked out."""


# -- the rows that every file has --------------------------------------------------------------------------------------


def _collisions(runs: Runs, _values: Floats) -> Bools:
    return np.asarray(runs.outcomes.collided, dtype=bool)


def avoidable(runs: Runs) -> Floats:
    """Return (n,) the avoidability of each run by the reference drivers of the config.

    2 + min(margin, 4 s) / 4 s for a collision that all of them avoid, by the latest start of braking of the careful
    driver; 1 + the share that avoids it where they disagree; 1 / (1 + seconds by which the careful driver is late)
    where none does, 0 if it avoids contact at no moment, or if no driver covers the collision; without a collision that
    the ego caused 1 / (1 + |conflict gap| / 1 s), below 1.
    """
    values, caused = np.zeros(len(runs.outcomes)), np.zeros(len(runs.outcomes), dtype=bool)
    collided = np.flatnonzero(runs.outcomes.collided & runs.valid)
    config, scenes = runs.config, take(runs.scenes, collided)
    answers, margins = answers_and_margins(
        runs.program, scenes, config.simulation, config.contact, config.search.jobs, config.search.references
    )
    said = verdicts(answers)
    if runs.verdicts is not None:
        runs.verdicts.keep(scenes, said)
    share = np.nan_to_num(shares(answers))
    late = np.where(np.isfinite(margins), 1.0 / (1.0 + np.abs(margins)), 0.0)
    spare = np.clip(np.nan_to_num(margins, neginf=0.0), 0.0, MOST_MARGIN) / MOST_MARGIN
    values[collided] = np.select([said == Blame.AVOIDABLE, said == Blame.DISPUTED], [2.0 + spare, 1.0 + share], late)
    caused[collided] = ~np.isin(said, (Blame.STRUCK, Blame.NONE))
    others = runs.valid & ~caused
    values[others] = np.minimum(1.0 / (1.0 + _least_gaps(runs.only(others))), np.nextafter(1.0, 0.0))
    return values


def conflict(runs: Runs) -> Floats:
    """Return minus the magnitude of the conflict gap [s]; 0 on contact."""
    return np.where(runs.outcomes.collided, 0.0, -_least_gaps(runs))


def _least_gaps(runs: Runs) -> Floats:
    """Return (n,) the least conflict gap [s] between the ego and an actor that it does not touch.

    The gap is the time from the exit of one actor out of the overlap of their swept paths to the entry of the other.
    Without such an overlap, or if both are in it at once, it is MD divided by the closing speed at that time.
    """
    gaps = np.abs(runs.gaps)
    closing = runs.outcomes.closing_speed
    with np.errstate(divide="ignore", invalid="ignore"):
        otherwise = np.where(closing > 0.0, runs.outcomes.min_distance / closing, FARTHEST)
    gaps = np.where(np.isfinite(gaps), gaps, otherwise)
    others: Ints = np.arange(1, gaps.shape[1] + 1, dtype=np.int64)
    touched: Bools = runs.outcomes.collided[:, np.newaxis] & (runs.outcomes.contact_actors[:, 1:] == others)
    return np.where(touched | np.isnan(gaps), FARTHEST, gaps).min(axis=1, initial=FARTHEST)


def severity(runs: Runs) -> Floats:
    """Return the larger delta-V [m/s] of the two actors, for a central impact without rebound.

    At contact; without a collision at the closest approach, mapped to -1 .. 0. It is not a risk of injury (`injury`).
    """
    return _by_pairs(runs, _larger_change)


def injury(runs: Runs) -> Floats:
    """Return the risk that a collision injures a person seriously (AIS 3 or more) or kills one, for the likelier
    person.

    0 without a curve for the person; curves: `engine.metrics.values.SERIOUS`. Without a collision, -1 to 0 as
    `severity`.
    """
    from engine.metrics.values import worst_injury

    return _by_pairs(runs, lambda pair: worst_injury(pair) or 0.0)


def _by_pairs(runs: Runs, of_contact: "Callable[[Encounter], float]") -> Floats:
    """Return (n,) the largest value among touched actors; without contact -1 to 0, by delta-V at closest approach."""
    values = np.full(len(runs.outcomes), -1.0)
    for row in np.flatnonzero(runs.valid).tolist():
        if runs.outcomes.collided[row]:
            values[row] = max((of_contact(pair) for pair in runs.encounters(row) if pair.touched), default=0.0)
        else:
            change = max((_larger_change(pair) for pair in runs.encounters(row)), default=0.0)
            values[row] = change / (1.0 + change) - 1.0
    return values


def _larger_change(pair: "Encounter") -> float:
    light, heavy = sorted((pair.ego.mass, pair.other.mass))
    return relative_speed(pair.nearest) / (1.0 + (light / heavy if math.isfinite(heavy) else 0.0))


def failing(runs: Runs) -> Floats:
    """Return 1 where a controller failed, elsewhere risk / (risk + 1) with the continuous risk from 0 to 22."""
    risk = np.maximum(np.nan_to_num(runs.risk.continuous), 0.0)
    return np.where(runs.outcomes.verdict == Verdict.CONTROLLER, 1.0, risk / (1.0 + risk))


BUILT_IN: tuple[Objective, ...] = (
    Objective(
        "risk", "the risk of the paper, 0 to 22", lambda runs: runs.risk.continuous, _collisions, reads=NO_MEASURES
    ),
    Objective(
        "avoidable",
        "2 to 3 for a collision that all reference drivers avoid, 1 to 2 where some do; at most 1 for all other runs",
        avoidable,
        lambda _, values: values >= 2.0,
        reads=Measure.GAPS,
    ),
    Objective(
        "conflict",
        "the conflict gap: the least time between two at one place, 0 on contact",
        conflict,
        _collisions,
        -1.0,
        "s",
        reads=Measure.GAPS,
    ),
    Objective(
        "severity", "the larger delta-V of the two; it is not a risk of injury", severity, _collisions, 1.0, "m/s"
    ),
    Objective(
        "injury",
        "risk of serious injury of who meets a car's front on foot, on a bicycle or in a car; 0 in other collisions",
        injury,
        lambda _, values: values > 0.0,
    ),
    Objective(
        "controller",
        "1 for a scene in which the driver under test fails; below 1, from the risk, for all others",
        failing,
        lambda _, values: values == 1.0,
        failures=True,
    ),
)
assert tuple(row.name for row in BUILT_IN) == OBJECTIVES


# -- those of the file, and of Python ----------------------------------------------------------------------------------


def of_file(program: Program) -> Iterator[Objective]:
    """Yield a row for each `expect`, `maximize` and `minimize`."""
    for number, each in enumerate(program.judged.objectives):
        sign = 1.0 if each.sense is Sense.MAXIMIZE else -1.0
        kind = {Sense.EXPECT: "how far it is broken", Sense.MAXIMIZE: "made large", Sense.MINIMIZE: "made small"}
        finds = _breaks(number) if each.sense is Sense.EXPECT else _collisions
        sentence = f"{kind[each.sense]} (line {each.line})"
        yield Objective(each.name, sentence, _number(number, sign), finds, sign, each.unit, NO_MEASURES)


def _number(number: int, sign: float) -> Callable[[Runs], Floats]:
    return lambda runs: sign * runs.outcomes.sought[:, number]


def _breaks(number: int) -> Callable[[Runs, Floats], Bools]:
    return lambda runs, _: runs.outcomes.broken[:, number] == 1.0


def of_function(function: Callable[[Outcomes], Any]) -> Objective:
    """Return the row of a function."""
    name = function_name(function)

    def value(runs: Runs) -> Floats:
        try:
            given = np.asarray(function(map_arrays(runs.outcomes, _read_only)))
        except Exception as error:
            what = f"the objective `{name}` failed: {type(error).__name__}: {error}"
            raise ObjectiveError(what, "earlier results are kept; correct it, and search again") from error
        if given.shape != (len(runs.outcomes),):
            what = f"the objective `{name}` gave an array of shape {given.shape} for {len(runs.outcomes)} scenes"
            raise ObjectiveError(what, "give one number for each scene: an array of shape (n,)")
        if given.dtype.kind not in "biuf":
            what = f"the objective `{name}` gave values of type {given.dtype}"
            raise ObjectiveError(what, "give one number for each scene")
        values = given.astype(np.float64)
        if np.isnan(values[runs.valid]).any():
            what = f"the objective `{name}` gave NaN for a valid scene"
            raise ObjectiveError(what, "give a number for each; those of scenes that are not valid do not matter")
        return values

    return Objective(name, "a function from Python", value, _collisions)


def _read_only(array: np.ndarray) -> np.ndarray:
    """Return a read-only view of the array, as the run stores the array that the function reads."""
    view = array.view()
    view.flags.writeable = False
    return view


class ObjectiveNameError(ArgumentError):
    """A name that matches no objective, or more than one."""


class UnknownObjectiveError(ObjectiveNameError):
    """No objective has this name; the message gives the nearest name, and all names."""

    def __init__(self, name: str, known: Sequence[str]) -> None:
        near = nearest(name, known)
        meant = f"did you mean `{near}`? " if near else ""
        there = f"there are {', '.join(known)}" if known else "the file has no `expect`"
        super().__init__(f"there is no objective `{name}`", meant + there)
        self.name, self.known = name, tuple(known)


def known_objectives(program: Program) -> dict[str, Objective]:
    """Return all rows that a search of this program can name."""
    return {row.name: row for row in (*BUILT_IN, *of_file(program))}


def objectives(program: Program, named: Sequence[ObjectiveSpec] = DEFAULT_OBJECTIVES) -> tuple[Objective, ...]:
    """Return the objectives of a search, in their order; () for the paper's risk alone.

    Raises:
        UnknownObjectiveError: no objective has such a name.
        ObjectiveNameError: two have the same name.
    """
    if tuple(named) == DEFAULT_OBJECTIVES:
        return ()
    known, names = known_objectives(program), names_of(named)
    for number, (each, name) in enumerate(zip(named, names, strict=True)):
        if isinstance(each, str) and each not in known:
            raise UnknownObjectiveError(each, tuple(known))
        if not isinstance(each, str) and name in known:
            raise ObjectiveNameError(f"objective: a function is called `{name}`, as an objective that there is", RENAME)
        if name in names[:number]:
            raise ObjectiveNameError(f"objective: `{name}` is named twice", f"name each once; of a function, {RENAME}")
    return tuple(known[each] if isinstance(each, str) else of_function(each) for each in named)


def expectation(program: Program, name: str) -> Objective:
    """Return the row of an `expect` of the file; raise UnknownObjectiveError if none has this name."""
    expected = [each.name for each in program.judged.objectives if each.sense is Sense.EXPECT]
    if name not in expected:
        raise UnknownObjectiveError(name, expected)
    return known_objectives(program)[name]


def names_of(named: Sequence[ObjectiveSpec]) -> tuple[str, ...]:
    """Return the names of objectives as manifests store them."""
    return tuple(each if isinstance(each, str) else function_name(each) for each in named)

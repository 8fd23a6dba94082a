"""A single run: its findings, the title of its scenario, and all of it as a document."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from cortex_dsl.report.findings.choices import made_choices
from cortex_dsl.report.findings.objectives import ObjectiveResult, objective_results, objectives_content
from cortex_dsl.report.findings.readable import SpeedUnit, gene_value, speed_unit
from cortex_dsl.report.findings.story import REST, RULE_TEXTS, Moment, aftermath, in_order, story_of
from cortex_dsl.report.findings.tally import Tally, first_culprit
from cortex_dsl.semantics.names.linking import FixedParam
from engine.outcomes import PAIRS, Outcomes, Result
from engine.program import ParamSpace, Program
from engine.road.outline import Outline
from engine.scenes import Scenes, Trajectory
from engine.streams import StreamKey, format_key
from engine.vocabulary import EndReason, State, Verdict

if TYPE_CHECKING:
    from engine.metrics import Metric, Recorded
    from engine.scenes import Impact

PARTS: Sequence[tuple[str, int, str]] = (
    ("C", 10, ""),
    ("MD", 4, "m"),
    ("D_MS", 4, "m"),
    ("TTC_MS", 4, "s"),
)
"""Parts of the score in their order: name, most points, unit of its bands."""
HIGHEST = sum(most for _, most, _ in PARTS)


@dataclass(frozen=True)
class RunReport:
    """Everything there is to say about row 0 of a single run."""

    program: Program
    scenes: Scenes
    outcomes: Outcomes
    trajectory: Trajectory
    impacts: "Sequence[Impact]"
    """Impacts in the world host; () in the batch host, which ends at contact."""
    metrics: "Sequence[Metric]"
    """Metrics of a valid run; empty otherwise."""
    records: "Sequence[Recorded]"
    score: int
    parts: Sequence[float]
    pair: int
    profile: str
    engine: str
    road: Outline
    reproduce: str
    """The command that shows this run again."""
    held: Sequence[FixedParam] = ()
    """Params that the command line holds fixed."""

    @property
    def unit(self) -> SpeedUnit:
        """Return the unit in which speeds are shown."""
        return speed_unit(self.program)

    @property
    def story(self) -> list[Moment]:
        """Return the events of the run in order of time."""
        driven = story_of(self.program, self.outcomes, self.trajectory, pair=self.pair, unit=self.unit)
        after = aftermath(self.program, self.impacts, self.trajectory) if self.engine == "world" else ()
        return in_order([*driven, *after])

    @property
    def objective_results(self) -> tuple[ObjectiveResult, ...]:
        """Return the results of the objectives of the file."""
        return objective_results(self.program, self.outcomes)

    @property
    def valid(self) -> bool:
        """Return whether the run counts; a run that broke a requirement has no metrics and no risk."""
        return int(self.outcomes.verdict[0]) == Verdict.VALID


@dataclass(frozen=True)
class Conflict:
    """How the ego and one other actor met in a run."""

    pair: int
    """The ego and actor `pair` + 1."""
    contact: bool
    moves: bool
    """Whether the other actor moves before the end of the scored run."""
    distance: float
    """Least distance between the outlines [m]; NaN or infinite if the two were never there together."""
    time: float
    """Time of the least distance [s]."""
    ttc: float
    """Least time to collision [s]; NaN if it was not measured."""
    pet: float
    """Post-encroachment time [s]; NaN if it was not measured."""

    @property
    def urgency(self) -> tuple[bool, bool, float, float]:
        """Return the key of the order on screens: contact; actors that move; least of |PET| and TTC; least distance."""
        least = min((abs(value) for value in (self.pet, self.ttc) if not math.isnan(value)), default=math.inf)
        return (
            not self.contact,
            not (self.contact or self.moves),
            least,
            float(np.nan_to_num(self.distance, nan=np.inf)),
        )


def conflicts(report: RunReport) -> list[Conflict]:
    """Return the conflicts of the ego with every other actor, the closest first; the risk may name another pair."""
    outcomes, states = report.outcomes, report.trajectory.states
    measured = {(each.name, each.actors): each.value for each in report.metrics}
    first, other = (int(actor) for actor in outcomes.contact_actors[0])
    scored = report.trajectory.time <= float(outcomes.end_time[0]) + 1e-9
    there = states[..., State.PRESENT] > 0.5
    driving = there & (np.abs(states[..., State.SPEED]) > REST)
    moving: list[bool] = np.any(driving[scored], axis=0).tolist()
    found = [
        Conflict(
            pair,
            first == 0 and other == pair + 1,
            pair + 1 < len(moving) and moving[pair + 1],
            float(outcomes.min_distance[0, pair]),
            float(outcomes.min_distance_time[0, pair]),
            measured.get(("TTC", (0, pair + 1)), math.nan),
            measured.get(("PET", (0, pair + 1)), math.nan),
        )
        for pair in range(outcomes.min_distance.shape[1])
    ]
    return sorted(found, key=lambda each: each.urgency)


def run_content(report: RunReport, file: str) -> dict[str, Any]:
    """Return the contents of the view without the drawing. SI units, except params: the file's own."""
    program, outcomes, scenes = report.program, report.outcomes, report.scenes
    reason = EndReason(int(outcomes.end_reason[0]))
    rule = int(outcomes.end_rule[0])
    return {
        "file": file,
        "program": program.digest,
        "key": format_key(StreamKey(*scenes.keys[0].tolist())),
        "engine": report.engine,
        "verdict": Verdict(int(outcomes.verdict[0])),
        "attempts": scenes.attempts[0],
        "params": params_content(program.space, scenes.genomes[0]),
        "held": {one.name: {"value": one.value, "unit": one.unit} for one in report.held},
        "choices": dict(made_choices(program, scenes)),
        "actors": program.actors,
        "end": {
            "reason": reason,
            **_rule(program, reason, rule),
            "time": outcomes.end_time[0],
        },
        "collided": outcomes.collided[0],
        "pairs": pairs_content(program.actors, outcomes),
        "left_road": dict(zip(program.actors, outcomes.left_road_time[0].tolist(), strict=True)),
        "risk": {
            "profile": report.profile,
            "score": report.score,
            "parts": dict(zip((name for name, _, _ in PARTS), report.parts, strict=True)),
        },
        "events": events_content(program.actors, report.story),
        "metrics": metrics_content(program.actors, report.metrics),
        "records": report.records,
        **({"objectives": objectives_content(report.objective_results)} if len(program.judged) else {}),
        "reproduce": report.reproduce,
    }


def _rule(program: Program, reason: EndReason, rule: int) -> dict[str, Any]:
    """The rule that ended the run, or that it broke, with its place."""
    if reason not in RULE_TEXTS or rule < 0:
        return {"rule": None}
    return {"rule": program.rules[rule].name, **_place(program, program.rules[rule].line)}


def no_scene_content(program: Program, tally: Tally, verdict: Verdict, file: str) -> dict[str, Any]:
    """Return why there is no scene to run."""
    culprit = first_culprit(program, tally)
    return {
        "file": file,
        "program": program.digest,
        "verdict": verdict,
        "attempts": tally.attempts,
        "requirements": requirements_content(program, tally),
        "first_culprit": None if culprit is None else program.requirements[culprit].name,
    }


def events_content(actors: Sequence[str], moments: Iterable[Moment]) -> list[dict[str, Any]]:
    """Return the events as entries of a document."""
    return [
        {
            "time": moment.time,
            "actor": actors[moment.actor] if moment.actor >= 0 else None,
            "kind": moment.kind,
            "text": moment.text,
        }
        for moment in moments
    ]


def params_content(space: ParamSpace, genome: np.ndarray) -> dict[str, Any]:
    """Each param with its value in the file's own unit; options by their text."""
    return {
        name: {"value": gene_value(space, gene, genome[gene]), "unit": space.units[gene]}
        for gene, name in enumerate(space.names)
    }


def requirements_content(program: Program, tally: Tally) -> list[dict[str, Any]]:
    """Each requirement with its counts."""
    return [
        {
            "name": requirement.name,
            **_place(program, requirement.line),
            "tested": tally.tested[index] if tally.scenes else 0,
            "failed": tally.failed[index] if tally.scenes else 0,
            "pass_rate": tally.pass_rate(index) if tally.scenes else None,
        }
        for index, requirement in enumerate(program.requirements)
    ]


def _place(program: Program, line: int) -> dict[str, Any]:
    """Return the line, and its file unless it is the main one."""
    file, _, number = program.place(line).rpartition(":")
    return {"line": int(number) or None, **({"file": file} if file else {})}


def pairs_content(actors: Sequence[str], outcomes: Outcomes) -> list[dict[str, Any]]:
    """Return the metrics of each pair (ego, other actor) that decide the risk."""
    return [
        {
            "actors": [actors[0], other],
            **{row.name: _value(row, getattr(outcomes, row.name)[0, pair]) for row in PAIRS if row.in_document},
        }
        for pair, other in enumerate(actors[1:])
    ]


def _value(row: Result, value: float) -> float | str | None:
    """A number, or the word of an enumeration; None where there is none."""
    return value if row.words is None else row.words[int(value)] or None


def metrics_content(actors: Sequence[str], metrics: "Sequence[Metric]") -> list[dict[str, Any]]:
    """Every metric by name, with the names of those it is about. SI units."""
    return [{**vars(metric), "actors": [actors[actor] for actor in metric.actors]} for metric in metrics]

"""A search: its campaign, the places of its results, its metrics and methods by name, and the endings of its runs.

Partners of collisions, a summary in plain words, and the whole as a document complete it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cortex_dsl.report.findings.failures import LOST, driver_text, lead_text
from cortex_dsl.report.findings.probability_report import unseen_text
from cortex_dsl.report.findings.readable import counted, fixed, percent, ratio
from cortex_dsl.report.findings.run_report import PARTS
from cortex_dsl.report.findings.story import END_TEXTS, end_text
from engine.outcomes import MODEL_RANGE
from engine.program import Program
from engine.risk import HIGHEST_RISK
from engine.search.campaign import FINISHED, INTERRUPTED, STOPPED, Campaign
from engine.search.evaluations import (
    NOBODY,
    Evaluations,
    Figures,
    Partners,
    distinct_collisions,
    distinct_finds,
    figures,
    partner_of,
    partners,
)
from engine.search.insight.independent import COLLISION, IndependentDraws, independent_draws
from engine.search.insight.kinds import Failures, numbered
from engine.search.journal_reader import Record
from engine.search.methods.table import PLUGIN_STYLE, SEARCHERS
from engine.search.protocol import DEFAULT_OBJECTIVES
from engine.search.ranking import worst_cases
from engine.search.result_files import broken_by, collisions_by_partner
from engine.vocabulary import EndReason, Verdict

if TYPE_CHECKING:
    from cortex_dsl.report.findings.cases_found import CaseFound, KindShown
    from engine.acceptance import Account


@dataclass(frozen=True)
class SearchReport:
    """One campaign and its traces on disk."""

    campaign: Campaign
    folder: Path | None
    worst_files: Sequence[Path] = ()
    """Concrete scenarios of the worst cases, in their order; fewer where some could not be written."""

    name: str = ""
    """Name of a method that is not built in; "" otherwise."""
    driver: str = ""
    """Options that name the driver for the controllers of the file; "" without a driver."""
    blame: "Account | None" = None
    """Causes of rejected attempts, if no scene was valid."""
    cases: "Sequence[CaseFound]" = ()
    """The worst cases, with the answers of the reference driver."""
    kinds: "Sequence[KindShown]" = ()
    """Kinds of collisions, each with a drawing."""

    @property
    def method(self) -> str:
        return self.name or self.campaign.method


def method_name(method: str) -> str:
    """A method as a person calls it."""
    return (SEARCHERS[method].title if method in SEARCHERS else "") or method


def method_style(method: str) -> str:
    """Return the colour of a method in a terminal, from its row; methods of other packages share one colour."""
    return SEARCHERS[method].style if method in SEARCHERS else PLUGIN_STYLE


# -- endings of the runs of a search, and partners of collisions; a repeated elite counts once -------------------------


@dataclass(frozen=True)
class End:
    """One way in which distinct simulations ended."""

    verdict: Verdict
    reason: EndReason | None
    """None where nothing was simulated, or not to an end."""
    text: str
    count: int


def ends_of(program: Program, evaluations: Evaluations) -> list[End]:
    """Return every ending, the most frequent first; last the actors that the ego could have touched and never did."""
    runs, new = evaluations.rollouts, evaluations.simulated
    columns = (runs.verdict, runs.end_reason, runs.end_rule, partner_of(evaluations))
    every = np.stack([column[new].ravel() for column in columns], axis=1)
    _, first, counts = np.unique(numbered(every), return_index=True, return_counts=True)
    ends = [_end(program, end, count) for end, count in zip(every[first].tolist(), counts.tolist(), strict=True)]
    return [*sorted(ends, key=lambda end: -end.count), *_never(program, evaluations)]


def _end(program: Program, end: Sequence[int], count: int) -> End:
    verdict, reason, rule, partner = end
    if reason < 0:
        return End(Verdict(verdict), None, LOST if verdict == Verdict.CONTROLLER else "", count)
    why = EndReason(reason)
    if why == EndReason.COLLISION and partner != NOBODY and len(program.actors) > 2:
        return End(Verdict(verdict), why, f"{END_TEXTS[why]} with {program.actors[partner + 1]}", count)
    return End(Verdict(verdict), why, end_text(program, why, rule), count)


def _others(actors: Sequence[str]) -> str:
    """Return the names of the other actors if there are exactly two; else `others`."""
    return f"{actors[1]} and {actors[2]}" if len(actors) == 3 else "others"


def _never(program: Program, evaluations: Evaluations) -> Iterator[End]:
    """The search has not found a collision with these."""
    with_ego = partners(evaluations, len(program.actors)).with_ego
    missed = [name for name, count in zip(program.actors[1:], with_ego, strict=True) if not count]
    if len(program.actors) > 2 and missed and np.any(evaluations.rollouts.verdict == Verdict.VALID):
        yield End(Verdict.VALID, EndReason.COLLISION, f"{END_TEXTS[EndReason.COLLISION]} with {_or(missed)}", 0)


def _or(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} or {names[-1]}"


def partners_text(actors: Sequence[str], found: Partners) -> str:
    """`with truck 1,422, walker 0; 276 of truck and walker, without the ego`; empty where only one could be met."""
    if len(actors) < 3:
        return ""
    met = ", ".join(f"{name} {count:,}" for name, count in zip(actors[1:], found.with_ego, strict=True))
    alone = f"; {found.without_ego:,} of {_others(actors)}, without {actors[0]}" if found.without_ego else ""
    return f"with {met}{alone}"


# -- a search in plain words -------------------------------------------------------------------------------------------

RANDOM = "random"
"""The only method whose simulations are all mutually independent."""


def whole_run(record: Record) -> tuple[Figures, Figures]:
    """Return the figures of the whole run, by individual and by distinct simulation."""
    evaluations = record.evaluations
    return figures(evaluations, evaluations.reused | True), figures(evaluations, evaluations.simulated)


def headline(record: Record, came: Failures) -> str:
    """The result in one sentence."""
    _, simulated = whole_run(record)
    tried, worst = counted(simulated.runs, "simulation"), worst_cases(record.evaluations, 1)
    if failed := driver_text(came, record.manifest.objective):
        return f"{failed} in {tried}."
    if came.collisions:
        lead = lead_text(came)
        return f"{lead[0].upper()}{lead[1:]}, among {tried}."
    if worst and not isfinite(worst[0].min_distance):
        return f"Nothing to come near to in {tried}: the ego was alone in the scene."
    if worst:
        near = fixed(worst[0].min_distance, 2)
        of = tried if simulated.valid_runs == simulated.runs else f"{simulated.valid_runs:,} valid of {tried}"
        return f"No collision of the ego among {of}. The worst case comes as near as {near} m."
    return f"Not one of {tried} was valid{why_invalid(record)}."


def unfinished(record: Record) -> str:
    """Return `was stopped`, or `is not finished` for a search that runs or was killed; "" for a finished one."""
    if record.status == FINISHED:
        return ""
    return "was stopped" if record.status in (STOPPED, INTERRUPTED) else "is not finished"


INVALID = {
    Verdict.INFEASIBLE: "no scene with its params can meet the file's requirements",
    Verdict.EXHAUSTED: "no scene met the requirements of the file, in as many attempts as are allowed",
    Verdict.ABORTED: "a requirement on the run broke, and what came after that was not simulated",
    Verdict.CONTROLLER: "the driver failed over it, each time",
}
"""Why a simulation counts as invalid."""


def invalid_counts(record: Record) -> dict[str, int]:
    """Return the number of invalid simulations by reason, most frequent first."""
    verdicts = record.evaluations.rollouts.verdict[record.evaluations.simulated]
    counts = {why: int((verdicts == verdict).sum()) for verdict, why in INVALID.items()}
    return {why: counts[why] for why in sorted(counts, key=lambda why: -counts[why]) if counts[why]}


def why_invalid(record: Record) -> str:
    """`: 12 times …`, most frequent first; empty where all were valid."""
    reasons = "; ".join(f"{counted(count, 'time')} {why}" for why, count in invalid_counts(record).items())
    return f": {reasons}" if reasons else ""


def worst_score(record: Record) -> tuple[int, int]:
    """The highest risk of a valid simulation and how often it came up; (-1, 0) where nothing was valid."""
    scores = record.evaluations.score[record.evaluations.simulated & record.evaluations.valid]
    return (int(scores.max()), int((scores == scores.max()).sum())) if len(scores) else (-1, 0)


def worst_words(record: Record) -> str:
    """Return the risk of the worst case, and its frequency; empty without valid runs."""
    score, times = worst_score(record)
    return f"The highest risk found, {score} of {HIGHEST_RISK}, came up {counted(times, 'time')}." if times else ""


def objective_words(record: Record) -> str:
    """Return the objective, if it is not the risk, and the broken expectations; empty without both."""
    manifest, evaluations = record.manifest, record.evaluations
    texts: list[str] = []
    if manifest.objective != DEFAULT_OBJECTIVES:
        times = counted(int(evaluations.found[evaluations.simulated].sum()), "time")
        texts.append(f"The objective of the search, {' and '.join(manifest.objective)}, was reached {times}.")
    for name, count in broken_by(evaluations, manifest.objectives).items():
        texts.append(f'"{name}" is broken in {counted(count, "simulation")}.')
    return " ".join(texts)


def first_collision(record: Record) -> int:
    """Number of the first distinct simulation, from 1, in which the ego collided; 0 for none."""
    collided = record.evaluations.collided[record.evaluations.simulated]
    return int(collided.argmax()) + 1 if collided.any() else 0


def draws_of(record: Record) -> IndependentDraws | None:
    """Return the rates of the independent draws of a run."""
    manifest = record.manifest
    return independent_draws(record.evaluations, manifest.method, manifest.objectives)


def draws_texts(draws: IndependentDraws | None) -> Iterator[str]:
    """`of 2,165 uniform draws that are valid, 15.0 % to 19.1 % collide, …`, and the kinds that none of them showed."""
    if draws is None:
        return
    rates = "; ".join(
        f"{'collision' if each.name == COLLISION else _quoted(each.name)} {percent(each.interval.low)} to "
        f"{percent(each.interval.high)}"
        for each in draws.events
    )
    yield f"{counted(draws.valid, 'valid uniform draw')}, 95 % whenever one looks: {rates}"
    yield unseen_text(draws.unseen, "collision")


def _quoted(name: str) -> str:
    return f'"{name}" broken'


def limits(record: Record, system: Sequence[str] = ()) -> Iterator[str]:
    """Yield conclusions that these numbers do not support."""
    if record.manifest.method != RANDOM:
        yield (
            "How likely a collision is. This search goes where it has found danger, so the share of collisions says "
            "how well it looked, not how dangerous the scenario is."
        )
    if texts := list(draws_texts(draws_of(record))):
        yield (
            f"How likely a collision is on a road: traffic does not spread its params evenly. Where they are spread "
            f"evenly over their ranges: {'; '.join(texts)}."
        )
    yield "That what was not found does not exist. A finite search leaves most of the space of params unseen."
    yield "That one method is better than another: this is one run with one seed. A study of many runs can show that."
    if system:
        yield (
            f"That the ego as built would fail: the search also chose {', '.join(system)}, which belong to the system "
            f"under test. `--freeze` holds them fixed."
        )
    yield (
        f"How a real car behaves. Vehicles follow a kinematic model on a flat road and see without error"
        f"{beyond(record)}; a finding is a scene to look at again with the real system."
    )
    yield (
        "What happens after the ego's contact. Scoring ends there; the motion that is drawn lighter afterwards is "
        "rigid-body physics, for illustration."
    )


def beyond(record: Record) -> str:
    """`, and in 31 % of the valid simulations …`: how often the ego goes beyond the range of the model; else empty."""
    share = _beyond(record)
    if not share > 0.0:
        return ""
    return (
        f", and in {percent(share)} of the valid simulations the ego uses more than half of its grip, where that model "
        f"is not accurate (`cortexc verify --model dynamic` drives the worst cases again with slipping tyres)"
    )


def _beyond(record: Record) -> float:
    """Share of the valid simulations in which the ego uses more grip than the vehicle model is good for."""
    used = record.evaluations.rollouts.combined_grip[record.evaluations.simulated]
    used = used[~np.isnan(used)]
    return ratio(int((used > MODEL_RANGE).sum()), len(used))


# -- the same for a document -------------------------------------------------------------------------------------------


def search_content(program: Program, record: Record) -> dict[str, Any]:
    """Return every number of a run by its name in the journal, with derived values."""
    manifest, (everyone, simulated) = record.manifest, whole_run(record)
    score, times = worst_score(record)
    ends = ends_of(program, record.evaluations)
    total = sum(end.count for end in ends)
    draws = draws_of(record)
    return {
        "name": manifest.name,
        "method": manifest.method,
        "preset": manifest.preset,
        "seed": manifest.seed,
        "program_digest": manifest.program_digest,
        "status": record.status,
        "seconds": record.seconds,
        "distinct_collisions": distinct_collisions(record.evaluations),
        "distinct_finds": distinct_finds(record.evaluations),
        **collisions_by_partner(record.evaluations, manifest.actors),
        "by_individual": asdict(everyone),
        "by_simulation": asdict(simulated),
        "generations": [asdict(row) for row in record.generations],
        "run": manifest.run,
        "profile": manifest.profile,
        "versions": manifest.versions,
        "platform": manifest.platform,
        "file_digest": manifest.file_digest,
        "settings": manifest.settings,
        "params": [{"name": p.name, "unit": p.unit, "low": p.low, "high": p.high} for p in manifest.parameters],
        "risk": {"highest": HIGHEST_RISK, "parts": {name: most for name, most, _ in PARTS}},
        "worst": {"score": score, "times": times},
        "first_collision": first_collision(record),
        "shares": {
            "collision": ratio(simulated.colliding_runs, simulated.valid_runs),
            "invalid": ratio(simulated.nis, simulated.individuals),
        },
        "beyond_model": _beyond(record),
        "independent_draws": None if draws is None else asdict(draws),
        "invalid": invalid_counts(record),
        "ends": [{"text": end.text, "count": end.count, "share": ratio(end.count, total)} for end in ends],
    }

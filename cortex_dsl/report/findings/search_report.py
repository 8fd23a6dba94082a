"""What the views of a search are given: the campaign and where its results lie, its metrics and methods by name, how
its runs ended, and with whom the ego collided.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cortex_dsl.report.findings.story import END_TEXTS, end_text
from engine.program import Program
from engine.search.evaluations import NOBODY, Evaluations, Partners, partner_of, partners
from engine.search.methods.table import PLUGIN_STYLE, SEARCHERS
from engine.search.run import Campaign
from engine.vocabulary import EndReason, Verdict


@dataclass(frozen=True)
class SearchReport:
    """One campaign and its traces on disk."""

    campaign: Campaign
    folder: Path | None
    worst_files: Sequence[Path] = ()
    """Concrete scenarios of the worst cases, in their order; fewer where some could not be written."""

    name: str = ""
    """Of the method, where it is not one of ours."""

    @property
    def method(self) -> str:
        return self.name or self.campaign.method


METRICS: Sequence[tuple[str, str, str, int, str]] = (
    ("RL", "mean risk, valid runs", "rl", 2, ""),
    ("NC", "collisions", "nc", 0, ""),
    ("MDG", "mean least distance", "mdg", 2, "m"),
    ("MDEC", "same, no collisions", "mdec", 2, "m"),
    ("NIS", "invalid runs", "nis", 0, ""),
)
"""Name, meaning, field of `Figures`, decimals, unit."""


def method_name(method: str) -> str:
    """A method as a person calls it."""
    return (SEARCHERS[method].title if method in SEARCHERS else "") or method


def method_style(method: str) -> str:
    """The colour of a method in a terminal, from its row; those of other packages share one."""
    return SEARCHERS[method].style if method in SEARCHERS else PLUGIN_STYLE


# -- how the runs of a search ended, and with whom the ego collided; a repeated elite counts once ----------------------


@dataclass(frozen=True)
class End:
    """One way in which distinct simulations ended."""

    verdict: Verdict
    reason: EndReason | None
    """None where nothing was simulated."""
    text: str
    count: int


def ends_of(program: Program, evaluations: Evaluations) -> list[End]:
    """Every end, the most frequent first; at the end those whom the ego could have touched and never did."""
    runs, new = evaluations.rollouts, evaluations.simulated
    columns = (runs.verdict, runs.end_reason, runs.end_rule, partner_of(evaluations))
    found, counts = np.unique(np.stack([column[new].ravel() for column in columns]), axis=1, return_counts=True)
    ends = [_end(program, end, count) for end, count in zip(found.T.tolist(), counts.tolist(), strict=True)]
    return [*sorted(ends, key=lambda end: -end.count), *_never(program, evaluations)]


def _end(program: Program, end: Sequence[int], count: int) -> End:
    verdict, reason, rule, partner = end
    if reason < 0:
        return End(Verdict(verdict), None, "", count)
    why = EndReason(reason)
    if why == EndReason.COLLISION and partner != NOBODY and len(program.actors) > 2:
        return End(Verdict(verdict), why, f"{END_TEXTS[why]} with {program.actors[partner + 1]}", count)
    if why == EndReason.OTHER_COLLISION and len(program.actors) == 3:
        return End(Verdict(verdict), why, f"{END_TEXTS[why]}: {_others(program.actors)}", count)
    return End(Verdict(verdict), why, end_text(program, why, rule), count)


def _others(actors: Sequence[str]) -> str:
    """Whose collision it was, where there are only two but the ego."""
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

"""Properties of the worst cases of a search: the partner, the kind, and whether a competent driver avoids them."""

from dataclasses import dataclass
from typing import Protocol

from engine.avoidability import Avoidability
from engine.config import Config
from engine.program import Program
from engine.search.campaign import Campaign
from engine.search.insight.analysis import driven_again
from engine.search.insight.diversity import SECTORS, sector
from engine.search.ranking import Case
from engine.vocabulary import Side


class Searched(Protocol):
    """A compiled scenario with its settings: the interface of a `Scenario` that this module uses."""

    @property
    def program(self) -> Program: ...
    @property
    def config(self) -> Config: ...


@dataclass(frozen=True)
class CaseFound:
    """One case."""

    case: Case
    partner: str
    """Actor that the ego hit or came near to; "" without another actor."""
    side: str
    """Side of the ego on which the other actor was at contact or closest approach; "" without an approach."""
    heading: str
    """Heading of the other actor at that time, seen from the ego."""
    speeds: tuple[float, float]
    """Speeds of the ego and the other actor at that time [m/s]."""
    answer: Avoidability | None
    """Avoidability of a collision; None for other cases."""


def cases_found(scenario: Searched, campaign: Campaign) -> tuple[CaseFound, ...]:
    """Each of the worst cases; those that collided are driven again by the reference driver."""
    rows = [case.row for case in campaign.worst]
    answers = driven_again(scenario.program, campaign.evaluations, rows, scenario.config)
    return tuple(
        _found(scenario.program, campaign, case, answer) for case, answer in zip(campaign.worst, answers, strict=True)
    )


def _found(program: Program, campaign: Campaign, case: Case, answer: Avoidability | None) -> CaseFound:
    runs, place = campaign.evaluations.rollouts, (case.row, case.rollout)
    pair, side = int(runs.pair[place]), int(runs.side[place])
    met = side >= 0
    return CaseFound(
        case,
        program.actors[pair + 1] if pair >= 0 else "",
        Side(side).name.lower() if met else "",
        SECTORS[int(sector(runs.approach_angle[place]))] if met else "",
        (float(runs.ego_speed[place]), float(runs.other_speed[place])),
        answer,
    )

"""What the worst cases of a search are: with whom, of what kind, and whether a competent driver avoids them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from engine.avoidability import Avoidability, avoidability
from engine.config import Config
from engine.driving import driven
from engine.program import Program
from engine.sampling import sample
from engine.search.campaign import Campaign
from engine.search.insight.diversity import SECTORS, sector
from engine.search.ranking import Case
from engine.vocabulary import Side


class Searched(Protocol):
    """A compiled scenario with its settings: what this asks of a `Scenario`."""

    @property
    def program(self) -> Program: ...
    @property
    def config(self) -> Config: ...


@dataclass(frozen=True)
class CaseFound:
    """One case."""

    case: Case
    partner: str
    """Whom the ego hit or came near to; "" where there is nobody else."""
    side: str
    """Of the ego, on which the other was at contact or at the closest approach; "" where they never met."""
    heading: str
    """How the other headed then, seen from the ego."""
    speeds: tuple[float, float]
    """Of the ego and the other then [m/s]."""
    answer: Avoidability | None
    """Of a collision."""


def cases_found(scenario: Searched, campaign: Campaign) -> tuple[CaseFound, ...]:
    """Each of the worst cases; those that collided are driven again by the reference driver."""
    answers = _answers(scenario, campaign.worst)
    return tuple(
        _found(scenario.program, campaign, case, answer) for case, answer in zip(campaign.worst, answers, strict=True)
    )


def _answers(scenario: Searched, worst: Sequence[Case]) -> tuple[Avoidability | None, ...]:
    if not worst:
        return ()
    config, genomes = scenario.config, np.array([case.genome for case in worst])
    keys = np.array([case.key for case in worst], dtype=np.int64)
    scenes = driven(scenario.program, sample(scenario.program, genomes, keys, config.simulation), config)
    return avoidability(scenario.program, scenes, config.simulation, contact=config.contact)


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
        answer if case.collided else None,
    )

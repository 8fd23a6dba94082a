"""Properties of the worst cases of a search: the partner, the kind, and whether a competent driver avoids them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from cortex_dsl import ir
from cortex_dsl.lowering.given_out import light_colours
from cortex_dsl.report.blocks import Drawing, KeyMoment
from cortex_dsl.report.findings.judgement import judged_content
from cortex_dsl.report.findings.story import contact_moment
from engine.avoidability import Avoidability
from engine.config import Config
from engine.driving.blocks import can_be_driven
from engine.outcomes import MODEL_RANGE
from engine.program import Program
from engine.road import build_network
from engine.road.outline import outline
from engine.search.campaign import Campaign
from engine.search.evaluations import Evaluations
from engine.search.insight.analysis import driven_again, judged_again
from engine.search.insight.diversity import SECTORS, sector
from engine.search.insight.kinds import FoundKind, blame_order, codes, kind_of
from engine.search.ranking import Case
from engine.tables import Ints
from engine.verdicts import JudgedCollision
from engine.vocabulary import Blame, Side, State

if TYPE_CHECKING:
    from engine.scenes import Scenes


class IsElaborated(Protocol):
    """A compilation, for the colours of its lights."""

    @property
    def scenario(self) -> ir.Scenario: ...


class Drawable(Protocol):
    """A compiled scenario with its settings."""

    @property
    def program(self) -> Program: ...
    @property
    def config(self) -> Config: ...
    @property
    def compiled(self) -> IsElaborated: ...


class Searched(Drawable, Protocol):
    """The interface of a `Scenario` that this module uses."""

    def scene(self, case: Case) -> "Scenes": ...


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
    blame: Blame
    answer: Avoidability | None
    """Avoidability of a collision by the careful driver; None for other cases, and without a drive of it."""
    judged: JudgedCollision | None = None
    """Answers of all reference drivers, and counterfactuals; None as above."""
    end: float = 0.0
    """End of the run [s], at which the driver failed if it did."""
    grip: float = math.nan
    """Largest use of grip by the ego, as a share of mu g; NaN without tyres."""

    @property
    def is_beyond_model(self) -> bool:
        """Return whether the ego used more grip than the kinematic bicycle covers."""
        return self.grip > MODEL_RANGE


@dataclass(frozen=True)
class KindShown:
    """One kind of collision with the worst of its cases."""

    found: FoundKind
    case: Case
    drawing: Drawing | None
    """Contact of the case, seen from above; None if it cannot be simulated again."""


def cases_found(scenario: Searched, campaign: Campaign) -> tuple[CaseFound, ...]:
    """Return the worst cases; the reference drivers drive those that collided."""
    rows = [case.row for case in campaign.worst]
    run = scenario.program, campaign.evaluations, rows, replace(scenario.config, search=campaign.config)
    return known_cases(scenario.program, campaign, driven_again(*run), judged_again(*run))


def known_cases(
    program: Program,
    campaign: Campaign,
    answers: Sequence[Avoidability | None] = (),
    judged: Sequence[JudgedCollision | None] = (),
) -> tuple[CaseFound, ...]:
    """Return the worst cases with the answers of the reference drivers, if there are any."""
    none = [None] * len(campaign.worst)
    rows = zip(campaign.worst, answers or none, judged or none, strict=True)
    return tuple(_found(program, campaign, *row) for row in rows)


def _found(
    program: Program, campaign: Campaign, case: Case, answer: Avoidability | None, judged: JudgedCollision | None
) -> CaseFound:
    runs, place = campaign.evaluations.rollouts, (case.row, case.rollout)
    pair, side = int(runs.pair[place]), int(runs.side[place])
    met = side >= 0
    return CaseFound(
        case,
        program.actors[pair + 1] if 0 <= pair < len(program.actors) - 1 else "",
        Side(side).name.lower() if met else "",
        SECTORS[int(sector(runs.approach_angle[place]))] if met else "",
        (float(runs.ego_speed[place]), float(runs.other_speed[place])),
        Blame(int(campaign.blame[place])),
        answer,
        judged,
        float(runs.end_time[place]),
        float(runs.combined_grip[place]),
    )


def kinds_shown(scenario: Searched, campaign: Campaign, count: int) -> tuple[KindShown, ...]:
    """Return up to `count` kinds of collisions among the worst cases, in the order of `kinds_of_cases`."""
    kinds = kinds_of_cases(campaign.evaluations, campaign.blame, campaign.kinds, campaign.worst)
    return tuple(
        KindShown(found, case, drawing_of_contact(scenario, case, found.kind.pair)) for found, case in kinds[:count]
    )


def kinds_of_cases(
    evaluations: Evaluations, blame: Ints, kinds: Sequence[FoundKind], cases: Sequence[Case]
) -> list[tuple[FoundKind, Case]]:
    """Return each kind of collision among the cases with the first of its cases, avoidable and disputed kinds first."""
    unseen = {each.kind: each for each in kinds}
    shown = []
    hit = [case for case in cases if case.collided]
    rows, rollouts = (np.array([getattr(case, name) for case in hit], dtype=np.int64) for name in ("row", "rollout"))
    for case, code in zip(hit, codes(evaluations.rollouts, blame, (rows, rollouts)).tolist(), strict=True):
        found = unseen.pop(kind_of(*code), None)
        if found is not None:
            shown.append((found, case))
    return sorted(shown, key=lambda each: int(blame_order(each[0].kind.blame)))


def drawing_of_contact(scenario: Searched, case: Case, pair: int) -> Drawing | None:
    """Return a case at its contact; None if it cannot be simulated again."""
    genome, key = np.array([case.genome]), np.array([case.key], dtype=np.int64)
    if not can_be_driven(scenario.config.driver, key, genome).all():
        return None
    scenes = scenario.scene(case)
    return drawing_of_scene(scenario, scenes, pair) if scenes.valid[0] else None


def drawing_of_scene(scenario: Drawable, scenes: "Scenes", pair: int, closest: float = math.nan) -> Drawing:
    """Return the first of some scenes at its contact; without one at the time `closest` [s], if that is no NaN."""
    from engine import batch

    program, config = scenario.program, scenario.config
    trajectory = batch.trajectory(program, scenes, 0, config.simulation, config.contact)
    shown = light_colours(scenario.compiled.scenario, scenes, 0, config.simulation)
    road = outline(build_network(program.road_spec), shown)
    moment = contact_moment(trajectory, pair)
    if moment is None and not math.isnan(closest):
        sample = int(np.abs(trajectory.time - closest).argmin())
        x, y = trajectory.states[sample, 0, [State.X, State.Y]].tolist()
        moment = KeyMoment(sample, False, (x, y))
    return Drawing(road, program.actors, trajectory, moment, pair, program.code.actor_kind)


def cases_content(found: Sequence[CaseFound]) -> list[dict[str, Any]]:
    """Return the cases as entries of a document. SI units."""
    return [
        {
            "rank": each.case.rank,
            "partner": each.partner or None,
            "side": each.side or None,
            "heading": each.heading or None,
            "collided": each.case.collided,
            "min_distance": each.case.min_distance,
            "ego_speed": each.speeds[0],
            "other_speed": each.speeds[1],
            "end_time": each.end,
            "combined_grip": each.grip,
            "blame": each.blame.name.lower(),
            "avoidability": each.answer and {**vars(each.answer), "avoidance": each.answer.avoidance.name.lower()},
            **judged_content(each.judged),
        }
        for each in found
    ]

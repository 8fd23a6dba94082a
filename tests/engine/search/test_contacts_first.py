"""Whatever a search looks for, its collisions are listed before its near misses."""

import numpy as np
import pytest

import cortex_dsl as cx
from engine.search.insight.kinds import blamed
from engine.search.ranking import order_of_risk, worst_cases
from engine.vocabulary import OBJECTIVES, Blame
from tests.runs import LEFT_TURN


@pytest.mark.parametrize("objective", [each for each in OBJECTIVES if each not in ("risk", "controller")])
@pytest.mark.parametrize("generations", [1, 5])
def test_contacts_first(objective: str, generations: int) -> None:
    """Avoidable collisions, then other collisions, then near misses; each by what is sought."""
    found = cx.search(LEFT_TURN, "ga", generations=generations, population=40, seed=5, objective=objective)
    evaluations, blame = found.evaluations, found.blame
    rows = order_of_risk(evaluations, blame)
    place = rows, evaluations.worst_rollout[rows]
    contact = evaluations.rollouts.collided[place]
    groups = np.where(contact, np.where(blame[place] == Blame.AVOIDABLE, 0, 1), 2)
    assert {1, 2} <= set(groups.tolist()) or {0, 2} <= set(groups.tolist())
    assert groups.tolist() == sorted(groups.tolist())
    for group in range(3):
        sought = evaluations.continuous[rows[groups == group]]
        assert (np.diff(sought) <= 0.0).all()
    collisions = len({tuple(evaluations.genomes[row]) for row in rows[contact]})
    for cases in (found.worst, worst_cases(evaluations, 10)):
        hit = [case.collided for case in cases]
        assert hit == [True] * min(10, collisions) + [False] * (len(cases) - min(10, collisions))
    assert blamed(evaluations, None).shape == blame.shape

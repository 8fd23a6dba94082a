"""The story of a run: its moments and their order."""

from dataclasses import replace

import numpy as np

from cortex_dsl.report.findings.story import Moment, story_of
from engine.outcomes import Outcomes
from engine.program import Program
from engine.scenes import Trajectory
from engine.vocabulary import EndReason, State


def kinds(moments: list[Moment]) -> list[str]:
    return [moment.kind for moment in moments]


def test_moments_stand_in_the_order_of_time(program: Program, outcomes: Outcomes, trajectory: Trajectory) -> None:
    """Start, fastest closing, braking, closest approach, standstill, off the road, end."""
    moments = story_of(program, outcomes, trajectory)
    assert [moment.time for moment in moments] == sorted(moment.time for moment in moments)
    assert kinds(moments) == ["start", "start", "fastest", "brake", "closest", "rest", "left_road", "end"]


def test_at_one_time_causes_stand_before_effects(program: Program, outcomes: Outcomes, trajectory: Trajectory) -> None:
    """Whoever starts off the road starts there, and what is known at once comes before who brakes at once."""
    states = trajectory.states.copy()
    states[1:, 0, State.BRAKE] = 0.5
    at_once = replace(outcomes, max_closing_time=np.zeros((1, 1)), left_road_time=np.array([[np.nan, 0.0]]))
    moments = story_of(program, at_once, replace(trajectory, states=states))
    assert kinds(moments)[:5] == ["start", "start", "left_road", "fastest", "brake"]
    assert moments[2].text == "starts off the road"


def test_an_object_that_appears_off_the_road_never_leaves_it(
    program: Program, outcomes: Outcomes, trajectory: Trajectory
) -> None:
    """An object leaves the road only if it was present before."""
    for absent, text in ((0, "leaves the road"), (30, "leaves the road"), (40, "comes in off the road")):
        states = trajectory.states.copy()
        states[:absent, 1, State.PRESENT] = 0.0
        left = replace(outcomes, left_road_time=np.array([[np.nan, trajectory.time[40]]]))
        story = story_of(program, left, replace(trajectory, states=states))
        assert [moment.text for moment in story if moment.kind == "left_road"] == [text]


def test_speeds_of_a_story_are_in_one_unit(program: Program, outcomes: Outcomes, trajectory: Trajectory) -> None:
    """Closing speeds can be compared with the speeds above them: 19.84 m/s is 71.4 km/h."""
    text = " ".join(moment.text for moment in story_of(program, outcomes, trajectory))
    assert "71.4 km/h" in text
    assert "m/s" not in text


def test_contact_replaces_the_closest_approach(program: Program, collision: Outcomes, trajectory: Trajectory) -> None:
    """Distance zero is called contact, once."""
    shown = kinds(story_of(program, collision, trajectory))
    assert shown.count("contact") == 1
    assert "closest" not in shown
    assert "end" not in shown


def test_short_pauses_in_braking_are_not_reported(program: Program, outcomes: Outcomes, trajectory: Trajectory) -> None:
    """A pedal that flutters is one braking; one after a real pause is another."""
    states = trajectory.states.copy()
    states[:, 0, State.BRAKE] = 0.0
    states[10:20:2, 0, State.BRAKE] = 0.5
    states[50:55, 0, State.BRAKE] = 0.5
    story = story_of(program, outcomes, replace(trajectory, states=states))
    assert [moment.time for moment in story if moment.kind == "brake"] == [0.45, 2.45]


def test_a_rule_is_named_with_its_line(program: Program, outcomes: Outcomes, trajectory: Trajectory) -> None:
    """Whoever reads the end finds the line that caused it."""
    assert "(line 43)" in story_of(program, outcomes, trajectory)[-1].text


def test_every_reason_of_an_end_has_words(program: Program, outcomes: Outcomes, trajectory: Trajectory) -> None:
    """No reason is left without a sentence."""
    for reason in set(EndReason) - {EndReason.OTHER_COLLISION}:
        ended = replace(
            outcomes,
            end_reason=np.array([reason], dtype=np.int32),
            end_rule=np.array([-1], dtype=np.int32),
            contact_actors=np.array([[0, 1]], dtype=np.int32),
        )
        assert story_of(program, ended, trajectory)[-1].text

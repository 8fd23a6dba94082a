"""A recording judged: the numbers of the run that it came from, and the same ones seen from elsewhere."""

from collections.abc import Iterator, Sequence
from dataclasses import fields, replace
from functools import cache
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl import Scenario, load
from engine.host import MAX_SAMPLES
from engine.interchange import Contact, InterchangeError, RecordedActor, Recording
from engine.interchange.measuring import Measured, measure
from engine.interchange.recording import recorded_run
from engine.kernels.geometry import Box, box_distance
from engine.metrics import Body, bodies_of, measure_trajectory
from engine.metrics.table import OF_ACTORS
from engine.outcomes import Outcomes
from engine.tables import A_BUILDING
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind, EndReason, Side, State, Verdict
from engine.world import WorldRun, run
from tests.laws import examples, share

ROOT = Path(__file__).parents[3]
EXAMPLES = [*sorted((ROOT / "examples").glob("*.scn")), *sorted((ROOT / "tests" / "agreement").glob("*.scn"))]
TOLERANCE = 2e-9
"""Who comes in where it touches is recorded 1e-9 of a step later, less than 1e-9 m."""
ENDS = ("end_reason", "end_rule", "steps", "others_contact_time", "others_contact_actors")
"""A recording knows no rules; whoever touches from the first instant has made no step; of a step in which others touch
it has both ends, and not the instant between.
"""


def recordings(
    scenario: Scenario, count: int, seed: int = 11
) -> Iterator[tuple[WorldRun, Recording, tuple[Body, ...]]]:
    """Random valid runs of a scenario."""
    step = scenario.config.simulation.time_step
    scenes = scenario.sample(count, seed=seed)
    for row in np.flatnonzero(scenes.valid).tolist():
        ran = run(scenario.program, scenes, row, scenario.config)
        if ran.outcomes.verdict[0] == Verdict.VALID:
            bodies = bodies_of(scenario.program, scenes.values[row])
            yield ran, recorded_run(scenario.program, scenes, ran, row=row, step=step), bodies


UNTOLD = ("first_seen", "ttc_at_first_sight", "hidden_time", "lateral_grip", "combined_grip", "sought", "broken")
"""What no recording tells: who looks where, how slippery the road is, and what the file expects."""
SLIDING = ("column", "modular", "pile", "walking", "walls")
"""Where others strike one another: who slides moves otherwise than it heads, and a recording keeps its speed alone."""


def differences(one: Outcomes, other: Outcomes, sliding: bool) -> dict[str, float]:
    """By how much each column differs, where it does."""
    found = {}
    left_out = (*ENDS, *UNTOLD, *(("closing_speed",) if sliding else ()))
    for name in (field.name for field in fields(Outcomes) if field.name not in left_out):
        a, b = (np.asarray(getattr(each, name), dtype=np.float64) for each in (one, other))
        assert a.shape == b.shape, name
        same = (a == b) | (np.isnan(a) & np.isnan(b))
        with np.errstate(invalid="ignore"):
            found[name] = float(np.max(np.where(same, 0.0, np.abs(a - b)), initial=0.0))
    return {name: value for name, value in found.items() if not value <= TOLERANCE}


LEAST = 5
RUNS = max(LEAST, share(10))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_measuring_a_recorded_run_gives_its_outcomes_again(path: Path) -> None:
    """Every column, the risk and every metric, with contact and without."""
    scenario, seen = load(path), 0
    for ran, recording, bodies in islice(recordings(scenario, 100), RUNS):
        measured = measure(recording)
        sliding = path.stem in SLIDING
        assert differences(ran.outcomes, measured.outcomes, sliding) == {}
        assert measured.risk.score[0] == scenario.assess(ran.outcomes).score[0]
        every = measure_trajectory(ran.trajectory, ran.outcomes, bodies)
        expected = [m for m in every if m.name not in ("lateral grip", "combined grip")]
        assert [m.name for m in measured.metrics] == [m.name for m in expected]
        values = pytest.approx([m.value for m in expected], nan_ok=True, rel=1e-8)
        assert sliding or [m.value for m in measured.metrics] == values
        assert measured.trajectory.contact_sample == ran.trajectory.contact_sample or "modular" in path.name
        assert set(np.unique(recording.states[:, :, State.PRESENT]).tolist()) <= {0.0, 1.0, 2.0}
        seen += 1
    assert seen >= LEAST


def test_contacts_are_among_the_recorded_runs() -> None:
    """So the law above speaks of them, with both kinds of end."""
    ends = {int(measure(recording).outcomes.end_reason[0]) for _, recording, _ in recordings(load(EXAMPLES[0]), 30)}
    assert EndReason.COLLISION in ends
    assert len(ends) > 1


# -- scenes by hand ---------------------------------------------------------------------------------------------------


def car(name: str, kind: ActorKind = ActorKind.CAR, **changes: float) -> RecordedActor:
    model = MODELS[kind]
    names = [
        "length",
        "width",
        "rear_to_center",
        "wheelbase",
        "mass",
        "max_acceleration",
        "max_braking",
        "max_steer",
    ]
    numbers = {each: getattr(model, each) for each in names} | {"max_speed": model.top_speed}
    return RecordedActor(name=name, kind=kind, **(numbers | changes))


def by_hand(
    ways: Sequence[Sequence[tuple[float, float, float, float]]], time: Sequence[float] | np.ndarray, step: float
) -> Recording:
    """Actors by their (x, y, heading, speed) at each time; None where one is absent."""
    states = np.zeros((len(time), len(ways), len(State)))
    for actor, way in enumerate(ways):
        for sample, place in enumerate(way):
            if place is not None:
                states[sample, actor, :4] = place
                states[sample, actor, State.PRESENT] = 1.0
    actors = tuple(car("ego" if number == 0 else f"car{number}") for number in range(len(ways)))
    return Recording("by-hand", actors, np.array(time), states, step)


def head_on(time: Sequence[float] | np.ndarray, gap: float = 40.0) -> Recording:
    """Two that drive towards each other at 10 m/s each."""
    ego = [(10.0 * t, 0.0, 0.0, 10.0) for t in time]
    other = [(gap - 10.0 * t, 0.0, np.pi, 10.0) for t in time]
    return by_hand([ego, other], time, 0.1)


def test_contact_of_two_head_on_is_where_arithmetic_has_it() -> None:
    """The gap between the outlines over the closing speed."""
    measured = measure(head_on(np.arange(30) * 0.1))
    gap = 40.0 - MODELS[ActorKind.CAR].length
    assert measured.outcomes.collided[0]
    assert measured.outcomes.end_time[0] == pytest.approx(gap / 20.0, abs=1e-5)
    assert measured.outcomes.max_closing_speed[0, 0] == pytest.approx(20.0)
    assert measured.outcomes.distance_at_ms[0, 0] == pytest.approx(gap)
    assert measured.outcomes.side[0, 0] == Side.FRONT
    assert measured.risk.parts[0, 0] == 10


def test_uneven_times_give_the_same_as_even_ones() -> None:
    """Motion between samples is linear, so any samples of steady motion give the same result."""
    even = measure(head_on(np.arange(30) * 0.1)).outcomes
    uneven = measure(head_on([0.0, 0.07, 0.31, 0.32, 0.9, 1.4, 1.77, 2.5])).outcomes
    assert uneven.end_time[0] == pytest.approx(even.end_time[0], abs=1e-5)
    for name in ("max_closing_speed", "distance_at_ms", "ttc_at_ms", "ego_speed", "closing_speed"):
        assert getattr(uneven, name)[0, 0] == pytest.approx(getattr(even, name)[0, 0], rel=1e-6)


def test_times_count_from_the_first_sample() -> None:
    """A recording of another clock has the same outcome."""
    recording = head_on(np.arange(30) * 0.1)
    later = replace(recording, time=recording.time + 1000.0)
    assert measure(later).outcomes.end_time[0] == pytest.approx(measure(recording).outcomes.end_time[0], abs=1e-9)


def test_who_overlaps_from_the_start_is_refused() -> None:
    """In a single sample too: nothing led to it that could be judged."""
    for time in ([0.0], [0.0, 0.1, 0.2]):
        with pytest.raises(InterchangeError, match="overlap in the first sample"):
            measure(head_on(time, gap=2.0))


def test_a_contact_at_the_last_sample_counts() -> None:
    """A recording may end where two touch, and no next sample shows it."""
    touching = (40.0 - MODELS[ActorKind.CAR].length) / 20.0
    outcomes = measure(head_on([0.0, 0.5, 1.0, touching])).outcomes
    assert outcomes.collided[0]
    assert outcomes.end_time[0] == pytest.approx(touching, abs=1e-5)


def test_who_comes_in_where_another_stands_touches_then() -> None:
    """The pair is judged, though it was never together before, and the result says so."""
    still = [(0.0, 0.0, 0.0, 0.0)] * 4
    late = [None, None, (2.0, 0.0, 0.0, 0.0), (2.0, 0.0, 0.0, 0.0)]
    measured = measure(by_hand([still, late], [0.0, 0.1, 0.2, 0.3], 0.1))
    assert measured.outcomes.end_time[0] == pytest.approx(0.2)
    assert measured.outcomes.min_distance[0, 0] == 0.0
    assert measured.sudden
    assert not measure(head_on(np.arange(30) * 0.1)).sudden
    assert not measure(head_on([0.0, 0.1])).sudden


def test_who_is_gone_touches_nobody() -> None:
    """Absent actors are left out, wherever they were last."""
    still = [(0.0, 0.0, 0.0, 0.0)] * 3
    gone = [(20.0, 0.0, 0.0, 0.0), None, None]
    outcomes = measure(by_hand([still, gone], [0.0, 0.1, 0.2], 0.1)).outcomes
    assert not outcomes.collided[0]
    assert outcomes.end_reason[0] == EndReason.ALL_DONE


def test_contact_of_two_others_ends_nobody_elses_judgement() -> None:
    """It is noted, and the ego is judged to its own end: here its contact with one of the two."""
    time = np.arange(30) * 0.1
    ego = [(0.0, 30.0 - 5.0 * t, -np.pi / 2, 5.0) for t in time]
    one = [(10.0 * t, 0.0, 0.0, 10.0) for t in time]
    other = [(40.0 - 10.0 * t, 0.0, np.pi, 10.0) for t in time]
    outcomes = measure(by_hand([ego, one, other], time, 0.1)).outcomes
    assert outcomes.end_reason[0] == EndReason.TIMEOUT
    assert outcomes.others_contact_actors[0].tolist() == [1, 2]
    assert outcomes.others_contact_time[0] == pytest.approx(1.8, abs=0.2)
    assert outcomes.contact_actors[0].tolist() == [-1, -1]
    assert not outcomes.collided[0]
    assert outcomes.end_time[0] == pytest.approx(2.9)


def test_an_overlap_in_the_first_sample_is_no_run() -> None:
    """The ego inside another from the start is refused, by name; two others there are nobody's business."""
    still, inside, apart = ([(x, 0.0, 0.0, 0.0)] * 3 for x in (0.0, 1.0, 50.0))
    with pytest.raises(InterchangeError, match="overlap in the first sample"):
        measure(by_hand([still, inside], [0.0, 0.1, 0.2], 0.1))
    assert measure(by_hand([apart, still, inside], [0.0, 0.1, 0.2], 0.1)).outcomes.others_contact_time[0] == 0.0


BLOCK = [30.0, 0.0, 0.3, 8.0, 6.0]
FAR = [3000.0, 0.0, 0.0, 8.0, 6.0]


@pytest.mark.parametrize("buildings", [[BLOCK], [FAR, BLOCK, [40.0, 0.0, 0.0, 2.0, 2.0]]])
def test_the_ego_runs_into_a_building_that_the_recording_knows(buildings: list[list[float]]) -> None:
    """Where the distance of the outlines is 0, as the end of a run of ours: no pair collides, and what others do later
    counts no more. Others go through: a recording says what happened, and only the ego is judged.
    """
    time = np.arange(60) * 0.1
    ego = [(10.0 * t, 1.0, 0.0, 10.0) for t in time]
    other = [(0.0, 5.0, 0.0, 0.0) for t in time]
    recording = by_hand([ego, other], time, 0.1)
    assert measure(recording).outcomes.end_reason[0] == EndReason.TIMEOUT
    outcomes = measure(replace(recording, buildings=np.array(buildings))).outcomes
    length, width = MODELS[ActorKind.CAR].length, MODELS[ActorKind.CAR].width
    at = 10.0 * outcomes.end_time[0]
    assert outcomes.end_reason[0] == EndReason.BUILDING
    assert outcomes.contact_actors[0].tolist() == [0, A_BUILDING]
    assert not outcomes.collided[0]
    assert box_distance(Box(at, 1.0, 0.0, length, width), Box(*BLOCK)) < 2e-4
    assert box_distance(Box(at - 0.1, 1.0, 0.0, length, width), Box(*BLOCK)) > 0.0
    assert outcomes.min_distance[0, 0] > 0.0


def test_what_no_recording_says_is_said() -> None:
    """Without buildings that are known none is met, and with some nobody knows whom they hide."""
    recording = head_on([0.0, 0.1])
    (unknown,) = measure(recording).not_judged
    assert "no buildings are known" in unknown
    assert measure(replace(recording, buildings=np.zeros((0, 5)))).not_judged == ()
    (hidden,) = measure(replace(recording, buildings=np.array([FAR]))).not_judged
    assert "what buildings hide is not judged" in hidden


def test_whoever_is_met_first_ends_it() -> None:
    """A building behind the other is not reached; one before it is."""
    recording = head_on(np.arange(30) * 0.1)
    for place, reason in ((25.0, EndReason.COLLISION), (12.0, EndReason.BUILDING)):
        outcomes = measure(replace(recording, buildings=np.array([[place, 0.0, 0.0, 1.0, 1.0]]))).outcomes
        assert outcomes.end_reason[0] == reason


def test_an_ego_that_begins_in_a_building_is_refused() -> None:
    recording = replace(head_on([0.0, 0.1]), buildings=np.array([[0.0, 0.0, 0.0, 9.0, 9.0]]))
    with pytest.raises(InterchangeError, match="ego and a building overlap in the first sample"):
        measure(recording)


def test_one_alone_has_no_risk() -> None:
    """No pair, no points; the recording's end is the end."""
    measured = measure(by_hand([[(0.0, 0.0, 0.0, 1.0)] * 3], [0.0, 0.1, 0.25], 0.1))
    assert measured.outcomes.min_distance.shape == (1, 0)
    assert measured.outcomes.end_time[0] == 0.25
    assert measured.risk.score[0] == 0
    assert measured.risk.pair[0] == -1


def test_the_part_of_a_step_at_the_end_counts() -> None:
    """Two that come nearer up to an end between two steps are nearest there."""
    time = [0.0, 0.1, 0.2, 0.25]
    measured = measure(head_on(time))
    expected = 40.0 - 20.0 * 0.25 - MODELS[ActorKind.CAR].length
    assert measured.outcomes.min_distance[0, 0] == pytest.approx(expected, abs=1e-9)
    assert measured.outcomes.min_distance_time[0, 0] == pytest.approx(0.25)


def test_metrics_of_commands_need_commands() -> None:
    """Where wheel and pedals were not recorded, nothing is said of them."""
    recording = head_on(np.arange(30) * 0.1)
    commands = {row.symbol for row in OF_ACTORS if row.of_commands}
    assert {metric.name for metric in measure(recording).metrics} >= commands
    assert not {metric.name for metric in measure(replace(recording, commands=False)).metrics} & commands


# -- laws -------------------------------------------------------------------------------------------------------------


def seen(recording: Recording, angle: float, shift: tuple[float, float], mirror: bool) -> Recording:
    """The recording in other axes."""
    states = recording.states.copy()
    x, y, heading = (states[:, :, column].copy() for column in (State.X, State.Y, State.HEADING))
    if mirror:
        y, heading = -y, -heading
    states[:, :, State.X] = np.cos(angle) * x - np.sin(angle) * y + shift[0]
    states[:, :, State.Y] = np.sin(angle) * x + np.cos(angle) * y + shift[1]
    states[:, :, State.HEADING] = heading + angle
    return replace(recording, states=states, road=None)


@cache
def played() -> list[tuple[Recording, Measured]]:
    found = [replace(recording, road=None) for _, recording, _ in recordings(load(EXAMPLES[2]), 16)]
    return [(recording, measure(recording)) for recording in found]


@examples(40)
@given(
    number=st.integers(0, 7),
    angle=st.floats(-4.0, 4.0),
    shift=st.tuples(st.floats(-200.0, 200.0), st.floats(-200.0, 200.0)),
    mirror=st.booleans(),
)
def test_nothing_depends_on_the_axes(number: int, angle: float, shift: tuple[float, float], mirror: bool) -> None:
    """Rotated, moved and mirrored recordings have the same metrics; in a mirror left and right change places."""
    recording, measured = played()[number]
    other, own = measure(seen(recording, angle, shift, mirror)).outcomes, measured.outcomes
    assert other.collided[0] == own.collided[0]
    for name in ("end_time", "max_closing_speed", "distance_at_ms", "ttc_at_ms"):
        assert getattr(other, name) == pytest.approx(getattr(own, name), rel=1e-7, abs=1e-7), name
    assert other.min_distance == pytest.approx(own.min_distance, abs=2e-5)
    if own.collided[0]:
        sides = {Side.LEFT: Side.RIGHT, Side.RIGHT: Side.LEFT} if mirror else {}
        assert other.side[0, 0] == sides.get(Side(int(own.side[0, 0])), own.side[0, 0])
        assert other.ego_speed == pytest.approx(own.ego_speed, abs=1e-7)
        assert other.closing_speed == pytest.approx(own.closing_speed, abs=1e-6)


# -- what cannot be measured ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"time": np.array([0.0, 0.2, 0.1])}, "ascend"),
        ({"time": np.array([0.0, 0.1, np.nan])}, "ascend"),
        ({"step": 0.0}, "time step"),
        ({"step": float("nan")}, "time step"),
        ({"step": 1e-9}, "too many"),
        ({"states": np.zeros((3, 2, len(State)))}, "no actor"),
        ({"states": np.full((3, 2, len(State)), np.inf)}, "no finite state"),
    ],
)
def test_what_is_no_motion_is_refused(change: dict, words: str) -> None:
    """With a reason and a cure, before any array of its size is made."""
    with pytest.raises(InterchangeError, match=words) as caught:
        measure(replace(head_on([0.0, 0.1, 0.2]), **change))
    assert caught.value.cure


def test_a_recording_of_millions_of_samples_is_refused() -> None:
    """The limit is that of our own runs."""
    count = 3 * MAX_SAMPLES
    recording = head_on([0.0, 0.1, 0.2])
    states = np.broadcast_to(recording.states[:1], (count, *recording.states.shape[1:]))
    with pytest.raises(InterchangeError, match="too many"):
        measure(replace(recording, time=np.arange(count) * 0.1, states=states))


def test_an_unknown_profile_is_refused() -> None:
    """And the known ones are named."""
    with pytest.raises(InterchangeError, match="paper-mm"):
        measure(head_on([0.0, 0.1]), "papre")


def test_what_the_recording_says_of_contact_is_not_believed() -> None:
    """It is searched anew, so a wrong note changes nothing."""
    recording = head_on(np.arange(30) * 0.1)
    assert measure(replace(recording, contact=Contact(0.3, (0, 1)))).outcomes.end_time[0] > 1.0


def test_no_metric_is_a_negative_zero() -> None:
    """Who stands beside the other closes in at 0 m/s, whichever way it looks."""
    for heading in (0.0, np.pi):
        standing = np.zeros((3, 2, len(State)))
        standing[:, :, State.PRESENT], standing[:, :, State.HEADING] = 1.0, heading
        standing[:, 1, State.X] = 20.0
        outcomes = measure(replace(head_on(np.arange(3) * 0.1), states=standing)).outcomes
        for column in ("max_closing_speed", "min_distance", "closing_speed", "ego_speed"):
            assert not np.signbit(getattr(outcomes, column)).any(), column

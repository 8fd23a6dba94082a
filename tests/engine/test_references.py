"""The set of reference drivers: each against a model in NumPy, their ranges, and the verdicts that follow."""

from collections import Counter
from itertools import product
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl import Scenario, compile_text, load
from engine import verdicts as module
from engine.avoidability import avoidability
from engine.batch import trajectory
from engine.config import DEFAULT_REFERENCES
from engine.errors import ArgumentError
from engine.references import NAMES, REFERENCES, answer_counts, joint_verdict, references, shares, verdicts
from engine.sampling import sample
from engine.scenes import Scenes, actor_columns
from engine.streams import key_rows
from engine.verdicts import KnownVerdicts, answers_and_margins, blame
from engine.vocabulary import Answer, Blame, Column, Method, State
from tests.engine.drivers_by_hand import DRIVERS, Encounter
from tests.laws import share

EXAMPLES = Path(__file__).parents[2] / "examples"
PLACES = """
map road(length=1 km, lanes=3, one_way=True)
param V = Range(8, 36) m/s, W = Range(0, 1), X = Range(-3, 55) m, Y = Range(-5, 5) m, A = Range(0, 10) deg
param LATER = Range(0, 4) s, BRAKE = Range(0, 1), OWN = Range(0, 0.7), SIDE = Range(0, 600) m
behavior Brakes(after, pedal):
    do ConstantSpeedBehavior(self.speed) for after
    while True:
        take SetBrakeAction(pedal)
ego = new Car at (-450, SIDE), facing 0 deg, with speed V, with regionContainedIn None,
    with behavior Brakes(LATER, OWN)
other = new {kind} at ({x}, {y}), facing {turn}, with speed {speed}, with topSpeed 60 m/s,
    with regionContainedIn None{behavior}
terminate after 24 s
"""
SITUATIONS = {
    "leader": {
        "x": "-444 + X",
        "y": "0.2 * Y",
        "turn": "0 deg",
        "speed": "V * W",
        "behavior": ", with behavior Brakes(LATER, BRAKE)",
    },
    "from the left": {
        "x": "-447 + X",
        "y": "3.5 + 0.3 * Y",
        "turn": "-0.7 * A",
        "speed": "V * (0.3 + 0.6 * W)",
        "behavior": "",
    },
    "from the right": {
        "x": "-447 + X",
        "y": "-3.5 + 0.3 * Y",
        "turn": "0.7 * A",
        "speed": "V * (0.3 + 0.6 * W)",
        "behavior": "",
    },
    "stands": {"x": "-425 + X", "y": "0.4 * Y", "turn": "A", "speed": "0 m/s", "behavior": ""},
}
CASES = (*product(SITUATIONS, ("Car", "Truck", "Motorcycle")), ("stands", "Obstacle"))
"""Situation and kind of the other."""


def drawn(situation: str, kind: str, count: int, seed: int) -> tuple[Scenario, Scenes, Scenes]:
    """Scenes in which the ego collides, and the same with the ego far aside, in which the other drives alone."""
    text = PLACES.format(kind=kind, **SITUATIONS[situation])
    scenario = compile_text(text)
    space, rng = scenario.program.space, np.random.default_rng(seed)
    genomes = space.low + rng.random((count, len(space))) * (space.high - space.low)
    side = space.names.index("SIDE")
    keys = key_rows(seed, Method.SAMPLE, 0, 0, np.arange(count))
    genomes[:, side] = 0.0
    near = sample(scenario.program, genomes, keys, scenario.config.simulation)
    genomes[:, side] = 600.0
    return scenario, near, sample(scenario.program, genomes, keys, scenario.config.simulation)


def encounter(scenario: Scenario, near: Scenes, far: Scenes, row: int) -> Encounter:
    """What a scene gives to the drivers by hand: motion of both without contact, sizes, and brakes."""
    program = scenario.program
    run = trajectory(program, far, row, scenario.config.simulation).states
    ego, other = actor_columns(program, near.values[row])
    columns = [int(each) for each in (State.X, State.Y, State.HEADING, State.SPEED, State.ACCELERATION)]
    return Encounter(
        scenario.config.simulation.time_step,
        run[:, 0, State.X],
        run[:, 0, State.SPEED],
        run[:, 1][:, columns],
        (float(ego[Column.LENGTH]), float(ego[Column.WIDTH])),
        (float(other[Column.LENGTH]), float(other[Column.WIDTH])),
        float(other[Column.REAR_TO_CENTER]),
        min(float(ego[Column.MAX_BRAKING]), 9.81 * float(ego[Column.FRICTION])),
        float(ego[Column.PEDAL_TIME]),
    )


def compared(count: int, seed: int) -> list[tuple[str, dict[str, bool], dict[str, Answer]]]:
    """Random collisions: place and row, whether each driver by hand avoids it, and what the project says."""
    found = []
    for number, (situation, kind) in enumerate(CASES):
        scenario, near, far = drawn(situation, kind, 4 * count // len(CASES) + 1, seed + number)
        answers, _ = answers_and_margins(scenario.program, near, scenario.config.simulation, measured=False)
        for row in np.flatnonzero((answers[:, 0] >= 0) & (answers[:, 0] != Answer.STRUCK) & far.valid).tolist():
            case = encounter(scenario, near, far, row)
            hand = {name: driver(case) for name, driver in DRIVERS.items()}
            said = dict(zip(NAMES, map(Answer, answers[row].tolist()), strict=True))
            found.append((f"{situation}, {kind}, seed {seed + number}, row {row}", hand, said))
    return found[:count]


IN_RANGE = (Answer.AVOIDS, Answer.COLLIDES)


def test_each_driver_says_what_its_model_by_hand_says() -> None:
    """In collisions with vehicles that brake, cut in or stand; all of them in a night."""
    found = compared(max(20, share(50)), 100)
    seen = Counter[tuple[str, Answer]]()
    for place, hand, said in found:
        for name in NAMES:
            assert said[name] in IN_RANGE, (place, name)
            assert hand[name] == (said[name] is Answer.AVOIDS), (place, name)
            seen[name, said[name]] += 1
    assert all(seen[name, answer] for name in NAMES for answer in IN_RANGE)


def answers_to(text: str) -> dict[str, Answer]:
    """What each driver says of the only scene of a file."""
    scenario = compile_text(text)
    answers, _ = answers_and_margins(scenario.program, scenario.sample(1), scenario.config.simulation)
    return dict(zip(NAMES, map(Answer, answers[0].tolist()), strict=True))


RANGES = {
    Answer.NO_VEHICLE: "other = new Pedestrian at (-300, -1.75), facing 90 deg, with speed 0 m/s",
    Answer.CROSSING: "other = new Car at (-300, -31.75), facing 90 deg, with speed 10 m/s",
    Answer.GRIP: "environment(friction=0.5)\nother = new Car at (-300, -1.75), facing 0 deg, with speed 0 m/s",
}


@pytest.mark.parametrize("reason", RANGES)
def test_a_model_out_of_its_range_gives_a_reason(reason: Answer) -> None:
    """A pedestrian, crossing traffic, a road on which the model cannot brake fully; the careful driver covers all."""
    ego = "ego = new Car at (-330, -1.75), facing 0 deg, with speed 10 m/s"
    text = f"map road(length=800 m)\n{RANGES[reason]}, with regionContainedIn None\n{ego}\nterminate after 9 s\n"
    said = answers_to(text)
    assert said.pop("careful") in IN_RANGE
    assert set(said.values()) == {reason}


def test_who_reverses_is_no_driver_of_a_lane() -> None:
    said = answers_to("""
map road(length=800 m)
behavior Back():
    while True:
        take SetReverseAction(True), SetThrottleAction(0.5)
ego = new Car at (-300, -1.75), facing 0 deg, with behavior Back()
other = new Car at (-312, -1.75), facing 0 deg
terminate after 9 s
""")
    assert set(said.values()) <= {Answer.REVERSING, *IN_RANGE}
    assert said["rss"] is Answer.REVERSING


VERDICT_ROWS = {
    Blame.AVOIDABLE: [Answer.AVOIDS, Answer.CROSSING, Answer.AVOIDS],
    Blame.DISPUTED: [Answer.AVOIDS, Answer.GRIP, Answer.COLLIDES],
    Blame.UNAVOIDABLE: [Answer.COLLIDES, Answer.CROSSING, Answer.CROSSING],
    Blame.NO_MODEL: [Answer.CROSSING, Answer.NO_VEHICLE, Answer.REVERSING],
    Blame.STRUCK: [Answer.STRUCK] * 3,
    Blame.NONE: [Answer.NONE] * 3,
}


def test_a_verdict_counts_the_drivers_that_cover_the_collision() -> None:
    answers = np.array([*VERDICT_ROWS.values()])
    assert verdicts(answers).tolist() == [*VERDICT_ROWS]
    np.testing.assert_array_equal(shares(answers), [1.0, 0.5, 0.0, np.nan, np.nan, np.nan])


@pytest.mark.parametrize("file", ["left_turn", "roads/motorway_cut_in", "roads/platoon", "roads/walkers"])
def test_the_careful_driver_says_the_same_alone_and_among_others(file: str) -> None:
    """Its answer and its margin are those of `avoidability`, up to 4 s, whoever else is asked."""
    scenario = load(EXAMPLES / f"{file}.scn")
    scenes, config = scenario.sample(200, seed=7), scenario.config.simulation
    complete = avoidability(scenario.program, scenes, config)
    for names in (NAMES, ("careful",)):
        answers, margins = answers_and_margins(scenario.program, scenes, config, references=names)
        for answer, said, margin in zip(complete, answers[:, 0].tolist(), margins.tolist(), strict=True):
            expected = Answer.NONE if answer is None else Answer.STRUCK if answer.struck else None
            if answer is not None and expected is None:
                expected = Answer.AVOIDS if answer.avoidable else Answer.COLLIDES
                if np.isfinite(margin):
                    assert margin == pytest.approx(min(answer.margin, 4.0))
            assert said == expected
    alone = blame(scenario.program, scenes, config, references=("careful",))
    np.testing.assert_array_equal(alone == Blame.AVOIDABLE, [each is not None and each.avoidable for each in complete])


OF_THE_EGO = st.lists(
    st.sampled_from([each for each in Answer if each not in (Answer.NONE, Answer.STRUCK)]), min_size=3, max_size=3
)
OF_ONE_SCENE = st.one_of(st.just([Answer.NONE] * 3), st.just([Answer.STRUCK] * 3), OF_THE_EGO)


@given(st.lists(OF_ONE_SCENE, min_size=1, max_size=6), st.randoms())
def test_the_verdict_on_collisions_together_is_that_on_each_of_them(rows: list[list[Answer]], random: Random) -> None:
    """One alone has its own verdict; several are struck if each is, covered if one is, and disputed if they differ."""
    answers = np.array(rows)
    each = [Blame(code) for code in verdicts(answers).tolist()]
    assert [joint_verdict(answer_counts("abc", answers[row : row + 1])) for row in range(len(rows))] == each
    together, said = joint_verdict(answer_counts("abc", answers)), set(each) - {Blame.NONE}
    covered = said - {Blame.STRUCK, Blame.NO_MODEL}
    if len(said) <= 1:
        assert together == (said or {Blame.NONE}).pop()
    elif covered:
        assert together == (Blame.DISPUTED if len(covered) > 1 else covered.pop())
    else:
        assert together == Blame.NO_MODEL
    random.shuffle(rows)
    assert joint_verdict(answer_counts("abc", np.array(rows))) == together


def test_no_scene_is_driven_twice_for_one_verdict(monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = load(EXAMPLES / "left_turn.scn")
    scenes, config = scenario.sample(100, seed=7), scenario.config.simulation
    known = KnownVerdicts()
    said = blame(scenario.program, scenes, config)
    known.keep(scenes, said)
    monkeypatch.setattr(module, "answers_and_margins", None)
    np.testing.assert_array_equal(blame(scenario.program, scenes, config, known=known), said)


def test_the_table_has_a_source_for_each_driver() -> None:
    assert len({each.name for each in REFERENCES}) == len(REFERENCES) == 5
    assert all(each.source and each.sentence for each in REFERENCES)
    assert DEFAULT_REFERENCES == NAMES


@pytest.mark.parametrize(("names", "message"), [(("carefull",), "no reference driver `carefull`"), ((), "named")])
def test_an_unknown_driver_is_refused_with_all_names(names: tuple[str, ...], message: str) -> None:
    with pytest.raises(ArgumentError, match=message) as caught:
        references(names)
    assert "careful, reg157, rss, fsm, cc" in caught.value.cure

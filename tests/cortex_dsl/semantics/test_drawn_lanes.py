"""Where choices of lanes would make too many variants, the scene draws the lanes: from the same law, as data."""

import numpy as np
import pytest
from scipy import stats

from cortex_dsl import CompileError, Scenario, compile_text
from cortex_dsl.report.findings.choices import made_choices
from cortex_dsl.semantics import elaboration
from engine.program import numbered
from engine.road import build_network
from engine.scenes import actor_columns
from engine.vocabulary import Column

SIX = """
map intersection(ways=4, lanes=2)
lanes = [Uniform(*intersection.incomingLanes) for i in range(5)]
ego = new Car in lanes[0].centerline, with speed 5, with behavior FollowLaneBehavior(5)
new Car in lanes[1], with speed 4, with behavior CarFollowingBehavior(6)
new Car on lanes[2].sections[0], with speed 3
new Truck in lanes[3].centerline, with behavior FollowLaneBehavior(3, laneToFollow=lanes[3])
new Car following roadDirection from lanes[4].centerline[0] for Range(5, 20) m
walker = new Pedestrian in Discrete({network.lanes[0]: 1, network.lanes[3]: 2}).centerline
require (distance from ego to lanes[0].centerline) < 0.01
require lanes[1].width == 3.5 and lanes[1].length > 10
terminate after 2 s
"""
PAIR = """
map intersection(ways=4, lanes=2)
mine = Uniform(*intersection.incomingLanes)
other = Discrete({network.lanes[0]: 1, network.lanes[1]: 2, network.lanes[4]: 3})
ego = new Car in mine.centerline
new Car in other
require mine is not other
require mine.isForward
"""
SCENES = 4000
COLUMNS = 6 * len(Column)
"""What scenes hold of six actors."""
LEVEL = 0.01 / 8
"""Of each of the eight comparisons of `test_the_law_is_that_of_variants`, 0.01 in all (Bonferroni)."""


@pytest.fixture
def drawing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every lane is drawn that can be."""
    monkeypatch.setattr(elaboration, "CHOSEN_LANES_LIMIT", 1)


def test_lanes_of_many_actors_are_drawn() -> None:
    """8 to the power of 5 lanes are one variant."""
    scenario = compile_text(SIX)
    assert len(scenario.program.variants) == 1
    assert [site.kind for site in scenario.program.variants[0].sites].count("lane") == 6


def test_cases_of_drawn_lanes_come_back_bit_for_bit() -> None:
    """A copy names the lanes that were drawn."""
    scenario = compile_text(SIX)
    scenes = scenario.sample(40, seed=3)
    outcomes = scenario.simulate(scenes)
    rows = np.flatnonzero(scenes.valid)[:6]
    assert len(rows) == 6
    for row in rows.tolist():
        copy = compile_text(scenario.concrete(scenes, row))
        again = copy.sample(1)
        np.testing.assert_array_equal(again.values[0, :COLUMNS], scenes.values[row, :COLUMNS])
        np.testing.assert_array_equal(copy.simulate(again).min_distance[0], outcomes.min_distance[row])


def _places(scenario: Scenario) -> np.ndarray:
    scenes = scenario.sample(SCENES, seed=11)
    return scenes.values[scenes.valid][:, [0, 1, len(Column), len(Column) + 1]]


def test_the_law_is_that_of_variants(monkeypatch: pytest.MonkeyPatch) -> None:
    """Places of both cars have the same distribution, by Kolmogorov and Smirnov, and so have the lanes of both."""
    chosen = compile_text(PAIR)
    monkeypatch.setattr(elaboration, "CHOSEN_LANES_LIMIT", 1)
    drawn = compile_text(PAIR)
    assert (len(chosen.program.variants), len(drawn.program.variants)) == (24, 1)
    one, other = _places(chosen), _places(drawn)
    assert min(len(one), len(other)) > 0.8 * SCENES
    for column in range(4):
        assert stats.ks_2samp(one[:, column], other[:, column]).pvalue > LEVEL
    for column in (0, 2):
        arms = [np.histogram2d(each[:, column], each[:, column + 1], (3, 3))[0].ravel() for each in (one, other)]
        table = np.array(arms)[:, np.sum(arms, axis=0) > 0]
        assert stats.chi2_contingency(table).pvalue > LEVEL


@pytest.mark.usefixtures("drawing")
def test_lanes_that_must_be_known_are_chosen() -> None:
    """A maneuver asks for its lane, which makes a variant each; the other lane is still drawn."""
    text = """
map intersection(ways=4, lanes=1)
mine = Uniform(*intersection.incomingLanes)
way = Uniform(*mine.maneuvers)
ego = new Car before intersection by 10 m along [way.startLane, way.connectingLane, way.endLane]
new Car in Uniform(*intersection.incomingLanes).centerline
"""
    program = compile_text(text).program
    assert len(program.variants) == 12
    assert {site.kind for site in program.variants[0].sites} >= {"lane"}


@pytest.mark.usefixtures("drawing")
@pytest.mark.parametrize(
    "asked",
    [
        "require mine.maneuvers[0].type is ManeuverType.STRAIGHT",
        "require ego.lane.road is not None",
        "require ego in mine",
        "x = [1, 2][1 if mine.isForward else 0]",
        "require (distance from ego to mine.sections[0].lane) < 3",
        "require mine.speedLimit is None",
        "require network.roadAt(ego).name != 'x'",
        "require (distance from ego to mine.routeTo(network.lanes[1])[1].centerline) > 0",
    ],
)
def test_whatever_is_asked_of_a_lane_is_answered(asked: str) -> None:
    """What a drawn lane does not know is found by knowing it."""
    text = f"map intersection(ways=4, lanes=1)\nmine = Uniform(*intersection.incomingLanes)\n{asked}\n"
    text = text.replace("\nrequire", "\nego = new Car in mine.centerline\nrequire")
    if "ego =" not in text:
        text += "ego = new Car in mine.centerline, with speed x\n"
    scenario = compile_text(text)
    assert len(scenario.program.variants) == 4
    assert scenario.sample(20).valid.any()


def test_too_many_lanes_that_must_be_known_are_still_refused() -> None:
    """Drawing does not help where each lane has to be known."""
    many = "\n".join(f"a{i} = Uniform(*network.lanes).maneuvers" for i in range(5))
    with pytest.raises(CompileError) as error:
        compile_text(f"map intersection(lanes=4)\n{many}\nego = new Car on road\n")
    assert [each.code for each in error.value.diagnostics] == ["SCN505"]


def test_what_is_wrong_in_every_variant_is_told_before_that_there_are_too_many() -> None:
    """Mended, there may be fewer."""
    cars = "for _ in range(9):\n    lane = Uniform(*network.lanes)\n    new Car on lane.centerline\n"
    with pytest.raises(CompileError) as error:
        compile_text(f"map intersection(lanes=2)\nego = new Car on road\n{cars}require network.sidewalks\n")
    assert [each.code for each in error.value.diagnostics] == ["SCN450"]


def test_choices_of_one_name_are_numbered(drawing: None) -> None:
    """In documents names are keys: each choice has its own."""
    cars = "\n".join(
        f"{'ego' if i == 0 else f'c{i}'} = new Car in (Uniform(*network.lanes)).centerline" for i in range(3)
    )
    scenario = compile_text(f"map intersection(ways=4, lanes=2)\n{cars}\n")
    scenes = scenario.sample(5, seed=1)
    choices = made_choices(scenario.program, scenes, int(np.flatnonzero(scenes.valid)[0]))
    assert len(choices) == len(dict(choices)) == 3
    assert numbered(["a", "b", "a", "a 2", "a"]) == ["a", "b", "a 2", "a 2 2", "a 3"]


def test_drawn_lanes_are_called_as_chosen_ones(drawing: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """In tables, documents and on pages: the same names, and the lanes on which the objects stand."""
    drawn = compile_text(PAIR)
    scenes = drawn.sample(20, seed=2)
    made = [made_choices(drawn.program, scenes, row) for row in np.flatnonzero(scenes.valid).tolist()]
    network = build_network(drawn.program.road_spec)
    for row, choices in zip(np.flatnonzero(scenes.valid).tolist(), made, strict=True):
        for actor, (_, lane) in enumerate(choices):
            x, y = actor_columns(drawn.program, scenes.values[row])[actor, [Column.X, Column.Y]]
            (named,) = (each for each in network.lanes if each.name == lane)
            assert network.paths.distance(named.path, float(x), float(y)) < 0.5 * named.width
    monkeypatch.setattr(elaboration, "CHOSEN_LANES_LIMIT", 1024)
    chosen = compile_text(PAIR)
    assert not any(site.kind == "lane" for site in chosen.program.variants[0].sites)
    others = made_choices(chosen.program, chosen.sample(1, seed=2))
    assert {tuple(name for name, _ in choices) for choices in made} == {tuple(name for name, _ in others)}
    assert len(set(made)) > 5

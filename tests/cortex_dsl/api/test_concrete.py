"""A concrete copy of a scene compiles to the same scene and runs to the same outcome, bit for bit."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from cortex_dsl import Scenario, compile_text, load
from cortex_dsl.source import Source
from cortex_dsl.syntax.formatting import format_source
from engine.outcomes import Outcomes
from engine.sampling import sample

EXAMPLES = sorted((Path(__file__).parents[3] / "examples").glob("*.scn"))

EVERYTHING_RANDOM = """
map intersection(lanes=2)
param SPEED = Range(5, 80) km/h
param LANES = DiscreteRange(0, 2)
param MANNER = Uniform('calm', 'hasty')
slip = Normal(0, 2) deg
lanes = [Uniform(*intersection.incomingLanes) for i in range(2)]
weights = [Range(1, 2) t for i in range(3)]

behavior Wobble():
    while True:
        take SetSteerAction(Range(-1, 1) deg), SetThrottleAction(0.2)

ego = new Car in lanes[0].centerline, with speed SPEED, with mass weights[0], with behavior Wobble()
truck = new Truck in lanes[1].centerline, facing slip, with mass 2 * weights[2], with behavior Wobble()
walker = new Pedestrian on road, with behavior ConstantSpeedBehavior(1.4 m/s if MANNER == 'calm' else 3 m/s)
require[0.5] (distance from ego to truck) > 20 m
require LANES >= 1
terminate after 4 s
"""


def _outcome(scenario: Scenario, genomes: np.ndarray, keys: np.ndarray) -> Outcomes:
    return scenario.simulate(sample(scenario.program, genomes, keys, scenario.config.simulation))


def _assert_copies_agree(scenario: Scenario, count: int) -> None:
    scenes = scenario.sample(count, seed=5)
    outcomes = scenario.simulate(scenes)
    rows = np.flatnonzero(scenes.valid)
    assert len(rows) > count // 4
    for row in rows:
        copy = compile_text(scenario.concrete(scenes, int(row), remark="a case\nof two lines"))
        again = _outcome(copy, np.zeros((1, 0)), scenes.keys[row : row + 1])
        for field in fields(Outcomes):
            np.testing.assert_array_equal(
                getattr(outcomes, field.name)[row : row + 1], getattr(again, field.name), err_msg=field.name
            )


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_are_reproduced_bit_for_bit(path: Path) -> None:
    """Lanes, maneuvers, places and genes of a drawn scene all come back."""
    _assert_copies_agree(load(path), 12)


def test_every_kind_of_randomness_is_reproduced() -> None:
    """Discrete genes, repeated sites, soft requirements and random numbers inside behaviours."""
    _assert_copies_agree(compile_text(EVERYTHING_RANDOM), 12)


def test_constants_of_the_command_line_stay_in_the_copy() -> None:
    """`-p` values are written into the copy."""
    scenario = load(EXAMPLES[0], EGO_SPEED="33 km/h")
    text = scenario.concrete(scenario.sample(20, seed=1), int(np.flatnonzero(scenario.sample(20, seed=1).valid)[0]))
    assert "param EGO_SPEED     = 33 km/h" in text


def test_a_road_that_nobody_wrote_is_written() -> None:
    """It follows from the words of the file: a copy does not ask for the neighbouring lane any more."""
    scenario = compile_text(
        '"""Side by side."""\n'
        "lane = intersection.incomingLanes[0]  # the first\n"
        "ego = new Car in lane.centerline\n"
        "new Car in lane.adjacentLanes[0].centerline\n"
    )
    text = scenario.concrete(scenario.scene_of_seed(0))
    assert text.startswith('"""Side by side."""\nmap intersection(ways=4, lanes=2)\nlane = ')
    _assert_copies_agree(scenario, 8)


def test_comments_of_the_author_stay() -> None:
    """Only random values are replaced."""
    scenario = compile_text("map intersection()\n# mind this\nego = new Car in road  # here\n")
    scenes = scenario.sample(50)
    text = scenario.concrete(scenes, int(np.flatnonzero(scenes.valid)[0]))
    assert "# mind this" in text
    assert "# here" in text


LIBRARY = {
    "cars.scn": """
from lib.gaps import GAP
param LIMIT = Range(5, 30) km/h

class Taxi(Car):
    width: Range(1.6, 1.9) m
    speed: LIMIT
""",
    "lib/gaps.scn": "GAP = Range(12, 18) m\n",
}
WITH_IMPORTS = """
map intersection(lanes=2, approach=80 m)
from cars import Taxi, GAP
import "lib/gaps.scn" as more
import cars

way = Uniform(*intersection.incomingLanes)
ego = new Taxi in way.centerline, with behavior FollowLaneBehavior(target_speed=cars.LIMIT)
other = new Taxi ahead of ego by more.GAP
mutate other by 0.2
post = new Obstacle at (60 m, 60 m), facing Range(0, 90) deg, with regionContainedIn None
mutate post, ego by 0.1

scenario Crossing(gap):
    setup:
        walker = new Pedestrian on road, with behavior ConstantSpeedBehavior(gap / 10 s)

scenario Main():
    setup:
        override ego with behavior FollowLaneBehavior(target_speed=Range(3, 9) m/s)
    compose:
        do Crossing(Range(9, 12) m) for 1 s
        do choose Crossing(GAP), Crossing(GAP)
"""


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_copies_of_examples_have_the_layout_of_the_formatter(path: Path) -> None:
    """Though only the first copy of a shape is parsed: every copy is what the formatter makes of its text."""
    scenario = load(path)
    scenes = scenario.sample(40, seed=3)
    rows = np.flatnonzero(scenes.valid)
    assert len(rows) > 8
    for row in rows:
        remark = f"case {row}"
        plain = scenario.concrete_files(scenes, int(row), remark=remark, name="case.scn", laid_out=False)
        wanted = {name: format_source(Source(name, text)) for name, text in plain.items()}
        assert scenario.concrete_files(scenes, int(row), remark=remark, name="case.scn") == wanted


def test_imports_mutations_and_scenarios_are_reproduced_bit_for_bit(tmp_path: Path) -> None:
    """What imported files drew is pinned in copies of them, which lie beside the copy and which it reads."""
    for name, text in LIBRARY.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    scenario = compile_text(WITH_IMPORTS, folder=tmp_path)
    scenes = scenario.sample(12, seed=5)
    outcomes = scenario.simulate(scenes)
    for row in np.flatnonzero(scenes.valid):
        files = scenario.concrete_files(scenes, int(row), name="case.scn")
        assert list(files) == ["case.scn", "case.cars.scn", "case.gaps.scn"]
        assert not any(word in text for text in files.values() for word in ("Range(", "Uniform("))
        for name, text in files.items():
            (tmp_path / "copies").mkdir(exist_ok=True)
            (tmp_path / "copies" / name).write_text(text)
        again = _outcome(load(tmp_path / "copies" / "case.scn"), np.zeros((1, 0)), scenes.keys[row : row + 1])
        for field in fields(Outcomes):
            np.testing.assert_array_equal(
                getattr(outcomes, field.name)[row : row + 1], getattr(again, field.name), err_msg=field.name
            )


def test_copy_runs_the_scenario_that_was_asked_for() -> None:
    """A name given with `--scenario` is written into the copy."""
    text = "map intersection()\nego = new Car on road\n"
    text += "".join(f"scenario {name}():\n    setup:\n        D = {i} m\n" for i, name in enumerate(("Main", "Other")))
    scenario = compile_text(text, scenario="Other")
    copy = scenario.concrete(scenario.sample(1))
    assert 'scenario="Other"' in copy
    assert 'scenario="Other"' in compile_text(copy).concrete(compile_text(copy).sample(1))


def test_copies_are_in_the_one_layout() -> None:
    """`cortexc fmt` has nothing to do to a copy, whatever the original looks like; its lines can be kept, too."""
    text = "map intersection()\nlane = Uniform(*intersection.incomingLanes)\nego=new Car in lane.centerline\n"
    scenario = compile_text(text)
    scenes = scenario.sample(50)
    row = int(np.flatnonzero(scenes.valid)[0])
    copy = scenario.concrete(scenes, row, remark="a case")
    assert format_source(Source("copy.scn", copy)) == copy
    (kept,) = scenario.concrete_files(scenes, row, laid_out=False).values()
    assert "ego=new Car at" in kept
    assert len(kept.splitlines()) == len(text.splitlines()) + 2


def test_a_bare_param_stays_bare() -> None:
    """A param without a unit is displayed in that of its places, and written without it: it may stand in products."""
    text = "map intersection()\nparam V = Range(5, 9)\nego = new Car on road, with speed V\nrequire V * V < 70\n"
    scenario = compile_text(text)
    assert scenario.program.space.units == ("m/s",)
    assert scenario.program.space.bare == ("V",)
    scenes = scenario.sample(50)
    copy = scenario.concrete(scenes, int(np.flatnonzero(scenes.valid)[0]))
    assert "m/s" not in copy
    assert compile_text(copy)


def test_places_that_disagree_give_no_unit() -> None:
    """A bare param that is a speed here and a length there has no unit."""
    text = "map intersection()\nparam V = Range(2, 9)\nego = new Car on road, with speed V, with length V\n"
    assert compile_text(text).program.space.units == ("",)


VILLAGE = EXAMPLES[0].parent / "roads" / "village.xodr"


@pytest.mark.parametrize(
    ("line", "written"),
    [
        ('map opendrive(f"{FOLDER}/village.xodr")', 'map opendrive("village.xodr")'),
        ("map opendrive(file=FILE)", 'map opendrive(file="village.xodr")'),
        ("param map = localPath(FILE)", 'param map = localPath("village.xodr")'),
        ('param map = FILE, note = f"{3}"', 'param map = "village.xodr", note = f"{3}"'),
    ],
)
def test_a_copy_names_the_file_of_its_map(line: str, written: str) -> None:
    """Whatever expression named it, and it alone; the file lies beside the copy."""
    names = f'FOLDER = "{VILLAGE.parent}"\nFILE = f"{{FOLDER}}/village.xodr"\n'
    model = "model scenic.domains.driving.model\n" if line.startswith("param") else ""
    scenario = compile_text(f"{names}{line}\n{model}ego = new Car on road\nterminate after 1 s\n")
    scenes = scenario.sample(20, seed=1)
    copy = scenario.concrete(scenes, int(np.flatnonzero(scenes.valid)[0]))
    assert written in copy

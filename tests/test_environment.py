"""`environment(...)`: grip and sight of everybody, in the language, in both hosts and in exports."""

import re

import numpy as np
import pytest

from cortex_dsl import CompileError, compile_text
from cortex_dsl.api.scenario import Scenario
from cortex_dsl.diagnostics import Severity
from cortex_dsl.interchange.cases import surroundings_of
from cortex_dsl.semantics.names.properties import PROPERTIES
from cortex_dsl.source import Source
from cortex_dsl.syntax import parse
from cortex_dsl.syntax.unparse import unparse
from engine import batch, world
from engine.interchange.contract import ExportOptions
from engine.interchange.openscenario import write_trajectories
from engine.interchange.recording import Surroundings, recorded_run
from engine.metrics.measures import recorded
from engine.scenes import actor_columns
from engine.vocabulary import Column
from tests.schemas import findings

BRAKING = """
map intersection(approach=200 m)
{environment}
lane = intersection.incomingLanes[0]
ego = new Car before intersection by 150 m along [lane], with speed 20 m/s, with friction 0.9,
    with behavior BrakeBehavior()
other = new Car before intersection by 20 m along [lane]
terminate after 20 s
"""


def compiled(environment: str = "", text: str = BRAKING) -> Scenario:
    return compile_text(text.format(environment=environment))


def columns(scenario: Scenario, seed: int = 1) -> np.ndarray:
    scenes = scenario.sample(1, seed=seed)
    return actor_columns(scenario.program, scenes.values[0])


@pytest.mark.parametrize("friction", [0.1, 0.3, 0.7])
def test_friction_lengthens_the_way_to_a_stop(friction: float) -> None:
    """v^2 / (2 mu g) with mu the product of the car's and the road's, in both hosts."""
    scenario = compiled(f"environment(friction={friction})")
    scenes = scenario.sample(1, seed=1)
    fast = batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation)
    slow = world.run(scenario.program, scenes, 0, scenario.config).trajectory
    way = np.hypot(*(fast.states[-1, 0, :2] - fast.states[0, 0, :2]))
    held = min(20.0 / (2 * 0.9 * friction * 9.81) * 20.0, 130.0)
    if held < 120.0:
        assert way == pytest.approx(held, abs=1e-6)
    np.testing.assert_allclose(slow.states[: len(fast.states), 0], fast.states[:, 0], rtol=0.0, atol=1e-9)


def test_without_it_nothing_changes() -> None:
    """The same columns as with friction 1, light 1 and a sight beyond everybody's view."""
    plain, clear = columns(compiled()), columns(compiled("environment(friction=1, sight=1 km, light=1)"))
    np.testing.assert_array_equal(plain, clear)


@pytest.mark.parametrize(
    ("environment", "view"),
    [("sight=30 m", 30.0), ("light=0.5", 25.0), ("sight=30 m, light=0.5", 25.0), ("sight=20 m, light=0.5", 20.0)],
)
def test_view_is_dimmed_and_then_capped(environment: str, view: float) -> None:
    """min(sight, light x visibleDistance); what the car has stays what it is."""
    scenario = compiled(f"environment({environment})")
    assert columns(scenario)[0, Column.VIEW_DISTANCE] == view
    text = BRAKING + "require ego.visibleDistance == 50 m\nrequire ego.friction == 0.9\n"
    assert compiled(f"environment({environment})", text).sample(1, seed=1).valid[0]


@pytest.mark.parametrize(("sight", "seen"), [(100, False), (140, True)])
def test_scenes_look_through_it_too(sight: float, seen: bool) -> None:
    """`can see` in a `require` and in a run knows the sight."""
    text = BRAKING + "require not (ego can see other)\n"
    text = text.replace("with friction 0.9", "with visibleDistance 1 km")
    assert compiled(f"environment(sight={sight} m)", text).sample(1, seed=1).valid[0] is np.bool_(not seen)
    watched = compiled(f"environment(sight={sight} m)", text.replace("require not", "terminate when"))
    ended = batch.simulate(watched.program, watched.sample(1, seed=1), watched.config.simulation)
    assert (ended.end_time[0] == 0.0) == seen


def test_a_search_may_choose_it() -> None:
    """Each argument may be a param, or drawn in every scene."""
    scenario = compiled("param WET = Range(0.2, 1)\nenvironment(friction=WET, sight=Range(20, 40) m)")
    assert scenario.program.space.names == ("WET",)
    scenes = scenario.sample(20, seed=3)
    found = np.array([actor_columns(scenario.program, values)[0] for values in scenes.values])
    np.testing.assert_allclose(found[:, Column.FRICTION], 0.9 * scenes.genomes[:, 0], rtol=1e-12)
    assert len(set(found[:, Column.VIEW_DISTANCE].tolist())) == 20
    assert found[:, Column.VIEW_DISTANCE].min() >= 20.0


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("environment(friction=0)", "SCN402"),
        ("environment(friction=3)", "SCN402"),
        ("environment(sight=0 m)", "SCN402"),
        ("environment(sight=-20 m)", "SCN402"),
        ("environment(light=0)", "SCN402"),
        ("environment(light=2)", "SCN402"),
        ("environment(friction=Range(-1, 1))", "SCN403"),
        ("environment(fog=20 m)", "SCN205"),
        ("environment(0.4)", "SCN427"),
        ("environment(friction=0.4, friction=0.4)", "SCN210"),
        ("environment(sight=20 s)", "SCN301"),
        ("environment(friction=ice)", "SCN201"),
        ("environment(friction=0.4)\nenvironment(friction=0.4)", "SCN455"),
    ],
)
def test_bad_arguments_are_told(line: str, code: str) -> None:
    """Place, reason and cure, never a traceback."""
    with pytest.raises(CompileError) as error:
        compiled(line)
    assert [found.code for found in error.value.diagnostics if found.severity is Severity.ERROR] == [code]


def test_it_stands_above_all_objects() -> None:
    """What stands below an object came too late for it."""
    with pytest.raises(CompileError) as error:
        compile_text("ego = new Car on road\nenvironment(friction=0.4)\n")
    assert "SCN456" in {found.code for found in error.value.diagnostics}


def test_an_argument_without_bounds_is_a_requirement() -> None:
    """`Normal` draws below 0 are drawn anew, counted, and named."""
    scenario = compiled("environment(friction=Normal(0.3, 0.3))")
    names = [each.name for each in scenario.program.requirements]
    assert names[0] == "friction of the environment within its domain"
    scenes = scenario.sample(200, seed=1)
    assert scenes.failed[:, 0].sum() > 20
    frictions = [actor_columns(scenario.program, values)[0, Column.FRICTION] for values in scenes.values]
    assert min(frictions) > 0.0
    assert max(frictions) <= 1.8


def test_it_prints_back() -> None:
    """Its tree gives its text."""
    text = "environment(friction=0.4, sight=60 m, light=0.5)\n"
    assert unparse(parse(Source("one.scn", text))) == text


# -- exports ----------------------------------------------------------------------------------------------------------


def test_a_case_knows_its_weather() -> None:
    """Numbers of the very scene; None where the file says nothing."""
    scenario = compiled("param WET = Range(0.2, 1)\nenvironment(friction=WET, sight=Range(20, 40) m)")
    scenes = scenario.sample(3, seed=3)
    for row in range(3):
        weather = surroundings_of(scenario, scenes, row)
        assert weather is not None
        assert weather.friction == scenes.genomes[row, 0]
        view = actor_columns(scenario.program, scenes.values[row])[0, Column.VIEW_DISTANCE]
        assert (weather.sight, weather.light) == (view, None)
    assert surroundings_of(compiled(), compiled().sample(1, seed=1)) is None


@pytest.mark.parametrize("version", ["1.0", "1.1", "1.2", "1.3"])
@pytest.mark.parametrize(
    "weather", [Surroundings(0.4, 60.0, 0.5), Surroundings(friction=0.4), Surroundings(sight=60.0)]
)
def test_openscenario_says_it(version: str, weather: Surroundings) -> None:
    """Grip as `frictionScaleFactor`, sight as the range of fog, by the schema; light is remarked upon."""
    scenario = compiled()
    scenes = scenario.sample(1, seed=1)
    run = world.run(scenario.program, scenes, 0, scenario.config)
    recording = recorded_run(scenario.program, scenes, run, step=0.05, surroundings=weather)
    export = write_trajectories(recording, "case", ExportOptions(osc=version), None)
    text = export.files["case.xosc"]
    assert isinstance(text, str)
    assert findings("openscenario", version, text) == []
    assert ('frictionScaleFactor="0.4"' in text) == (weather.friction is not None)
    assert ('visualRange="60"' in text) == (weather.sight is not None)
    assert any("light" in remark for remark in export.remarks) == (weather.light is not None)


@pytest.mark.parametrize("environment", ["", "environment(friction=0.5, light=0.5, sight=20 m)"])
def test_a_name_means_one_quantity(environment: str) -> None:
    """`record ego.P` is the column `ego.P` of the table at time 0, for every property that has one.

    What tyres and road come to together is `grip`, and how far somebody sees in this weather is `view_distance`.
    """
    records = "".join(f'record initial ego.{name} as "{name}"\n' for name in PROPERTIES)
    scenario = compiled(environment, BRAKING + records)
    scenes = scenario.sample(1, seed=1)
    run = batch.trajectory(scenario.program, scenes, 0, scenario.config.simulation)
    table = {name.split(" ")[0]: column[0] for name, column in scenario.table(scenes).items()}
    known = {each.name: each.values[0] for each in recorded(scenario.program, run)}
    named = {name: re.sub("[A-Z]", lambda found: f"_{found[0].lower()}", name) for name in PROPERTIES}
    equal = {name for name in PROPERTIES if f"ego.{named[name]}" in table}
    assert set(PROPERTIES) - equal == {"friction", "visibleDistance"}
    for name in equal:
        assert known[name] == table[f"ego.{named[name]}"], name
    factor = 0.5 if environment else 1.0
    assert table["ego.grip"] == known["friction"] * factor
    assert table["ego.view_distance"] == (20.0 if environment else known["visibleDistance"])

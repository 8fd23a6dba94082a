"""A replay for CARLA: the controller beside the file moves stubs of actors as they were recorded."""

import math
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given

from engine.errors import InterchangeError
from engine.interchange.contract import ExportOptions
from engine.interchange.openscenario.carla import BLUEPRINTS, MODULE, blueprint_of, controller_text, write_for_carla
from engine.interchange.openscenario.document import entity_names
from engine.interchange.openscenario.read import read_openscenario
from engine.interchange.recording import Recording, states_at
from engine.vocabulary import ActorKind, State
from tests.engine.interchange.commonroad.recordings import actor
from tests.engine.interchange.openscenario.conftest import ROAD, Xml, recordings, small, starts
from tests.laws import examples
from tests.schemas import findings

FOR_CARLA = ExportOptions("1.0", player="carla")


def written(of: Recording, stem: str = "case") -> dict[str, str]:
    return {name: str(text) for name, text in write_for_carla(of, stem, FOR_CARLA, ROAD).files.items()}


class Actor:
    """As CARLA has it, whose bounding box lies a little off its origin; y points to the right."""

    def __init__(self) -> None:
        self.is_alive, self.physics = True, True
        self.bounding_box = SimpleNamespace(
            location=SimpleNamespace(x=0.2, y=0.1, z=0.7), extent=SimpleNamespace(x=2.0, y=1.0, z=0.75)
        )
        self.transform = transform(0.0, 0.0, 0.0, 0.0)

    def set_simulate_physics(self, on: bool) -> None:
        self.physics = on

    def get_transform(self) -> SimpleNamespace:
        return self.transform

    def set_transform(self, given: SimpleNamespace) -> None:
        self.transform = given

    def middle(self) -> tuple[float, float, float]:
        """Of the outline, and its heading, as we have them."""
        place, yaw, box = self.transform.location, math.radians(self.transform.rotation.yaw), self.bounding_box.location
        x = place.x + box.x * math.cos(yaw) - box.y * math.sin(yaw)
        y = place.y + box.x * math.sin(yaw) + box.y * math.cos(yaw)
        return x, -y, -yaw


def transform(x: float, y: float, z: float, yaw: float) -> SimpleNamespace:
    return SimpleNamespace(
        location=SimpleNamespace(x=x, y=y, z=z), rotation=SimpleNamespace(yaw=yaw, pitch=1.0, roll=1.0)
    )


def transform_of(element: Xml) -> SimpleNamespace:
    """As ScenarioRunner turns a position into one of CARLA."""
    at = {name: float(value) for name, value in element.find(".//WorldPosition").attrib.items()}
    return transform(at["x"], -at["y"], at.get("z", 0.0), -math.degrees(at["h"]))


@pytest.fixture(autouse=True)
def clock() -> Iterator[SimpleNamespace]:
    """ScenarioRunner's, which does not begin at 0."""
    told = SimpleNamespace(time=7.0)
    modules = {
        name: ModuleType(name) for name in ("srunner", "srunner.scenariomanager", "srunner.scenariomanager.timer")
    }
    modules["srunner.scenariomanager.timer"].GameTime = SimpleNamespace(get_time=lambda: told.time)  # type: ignore[attr-defined]
    with pytest.MonkeyPatch.context() as patch:
        for name, module in modules.items():
            patch.setitem(sys.modules, name, module)
        yield told


def played(text: str, names: tuple[str, ...], times: list[float], clock: SimpleNamespace) -> Iterator[list[Actor]]:
    """The actors after each tick, as ScenarioRunner's behaviour tree has them: events first, then all controllers."""
    root: Any = ElementTree.fromstring(text)
    space: dict[str, Any] = {}
    exec(compile(controller_text(), MODULE, "exec"), space)
    actors, controllers, waiting = [], [], []
    for name in names:
        private = root.find(f".//Private[@entityRef='{name}']")
        said = {each.get("name"): each.get("value") for each in private.iter("Property")}
        made = getattr(SimpleNamespace(**space), said["module"].removesuffix(".py").title().replace("_", ""))
        actors.append(Actor())
        actors[-1].set_transform(transform_of(private))
        controllers.append(made(actors[-1], said))
        waiting.append(root.findall(f".//Maneuver[@name='{name}_maneuver']/Event"))
    for time in times:
        clock.time = 7.0 + time
        for controller, events in zip(controllers, waiting, strict=True):
            while events and starts(events[0]) <= time + 1e-9:
                vertices = list(events.pop(0).iter("Vertex"))
                controller.update_waypoints(list(map(transform_of, vertices)), [float(v.get("time")) for v in vertices])
        for controller in controllers:
            controller.run_step()
        yield actors
    end = float(root.findall(f".//Maneuver[@name='{names[0]}_maneuver']//Vertex")[-1].get("time"))
    assert controllers[0].check_reached_waypoint_goal() == (not waiting[0] and end <= times[-1] + 1e-9)
    assert not any(actor.physics for actor in actors)


def assert_replayed(of: Recording, clock: SimpleNamespace) -> None:
    """Everybody is where it was at each sample, and under the road while it is not in the case."""
    shown = of.taking_part().from_zero()
    steps = zip(
        shown.states, played(written(of)["case.xosc"], entity_names(shown), shown.time.tolist(), clock), strict=True
    )
    for states, actors in steps:
        for state, one in zip(states, actors, strict=True):
            assert (one.transform.location.z < -40.0) == (state[State.PRESENT] == 0.0)
            if state[State.PRESENT]:
                assert one.middle() == pytest.approx(state[: State.SPEED], abs=1e-9)
                assert one.transform.rotation.pitch == one.transform.rotation.roll == 0.0
                assert one.transform.location.z == pytest.approx(0.05)  # the bottom of the box lies on the road


def test_a_replay_is_the_recording(clock: SimpleNamespace) -> None:
    assert_replayed(small(), clock)


@examples(15)
@given(recordings())
def test_any_recording_is_replayed(of: Recording) -> None:
    """Actors that come, go, come back and stand; by whichever clock."""
    modules = sys.modules["srunner.scenariomanager.timer"]
    told = SimpleNamespace(time=7.0)
    modules.GameTime = SimpleNamespace(get_time=lambda: told.time)  # type: ignore[attr-defined]
    assert_replayed(of, told)


def test_between_vertices_motion_is_linear(clock: SimpleNamespace) -> None:
    """A player may tick at other instants than ours."""
    made = replace(small(), contact=None)
    times = np.linspace(0.0, 0.15, 31)
    expected = states_at(made, times)[:, 0]
    names = entity_names(made)
    for state, actors in zip(expected, played(written(made)["case.xosc"], names, times.tolist(), clock), strict=True):
        assert actors[0].middle() == pytest.approx(state[: State.SPEED], abs=2e-2)  # the rear axle moves straight


def test_it_is_valid_and_scenario_runner_can_name_it() -> None:
    """By the schema that ScenarioRunner insists on; its description becomes a file's name there."""
    files = written(small(), "a case/of mine")
    assert list(files) == ["a case/of mine.xosc", MODULE]
    root: Any = ElementTree.fromstring(files["a case/of mine.xosc"])
    assert findings("openscenario", "1.0", files["a case/of mine.xosc"]) == []
    assert root.find("FileHeader").get("description") == "a_case_of_mine"
    assert root.find(".//Vehicle").get("name") == "vehicle.mercedes.coupe_2020"
    assert root.find(".//Pedestrian").get("model").startswith("walker.pedestrian")
    assert root.find(".//AddEntityAction") is root.find(".//DeleteEntityAction") is None


def test_it_reads_back(tmp_path: Path) -> None:
    """Who is kept under the road is not there."""
    made = replace(small(), road=None)
    for name, text in written(made).items():
        (tmp_path / name).write_text(text.replace(f'<LogicFile filepath="{ROAD}" />', ""), encoding="utf-8")
    read = read_openscenario(tmp_path / "case.xosc").recording
    assert [each.name for each in read.actors] == [each.name for each in made.actors]
    again = states_at(read, made.time)
    assert (again[:, :, State.PRESENT] == made.states[:, :, State.PRESENT]).all()
    there = made.there
    assert again[there][:, : State.SPEED] == pytest.approx(made.states[there][:, : State.SPEED], abs=1e-6)


@pytest.mark.parametrize("kind", ActorKind)
def test_blueprints_are_the_nearest_of_their_kind(kind: ActorKind) -> None:
    for each in BLUEPRINTS[kind]:
        assert blueprint_of(replace(actor("a", kind), length=each.length + 0.02, width=each.width)) == each


def test_a_body_of_another_size_is_told() -> None:
    made = small()
    long = replace(made, actors=(replace(made.actors[0], length=12.0), *made.actors[1:]))
    assert any(
        "in CARLA" in remark and "12 m" in remark for remark in write_for_carla(long, "a", FOR_CARLA, ROAD).remarks
    )


@pytest.mark.parametrize("how", [{"osc": "1.2"}, {"osc": "1.0", "mode": "maneuver"}])
def test_what_scenario_runner_cannot_play_is_refused(how: dict[str, str]) -> None:
    with pytest.raises(InterchangeError, match="ScenarioRunner"):
        ExportOptions(**how, player="carla")  # type: ignore[arg-type]

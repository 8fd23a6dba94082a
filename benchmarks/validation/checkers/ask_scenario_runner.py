"""CARLA's ScenarioRunner: its own parser and behaviour tree play a file tick by tick, with CARLA's own map parser.

There is no simulator: the world and its actors are stubs that keep the transforms they are given. Where they stand
after each tick is held against the recording. The folder of a ScenarioRunner is named by SCENARIO_RUNNER_ROOT.
"""

import math
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import carla
import numpy as np
import py_trees
from answering import answer

sys.path.insert(0, os.environ["SCENARIO_RUNNER_ROOT"])


def _navigation() -> None:
    """ScenarioRunner imports CARLA's agents, which its wheel may lack; a replay asks them nothing."""
    for name in (
        "agents",
        "agents.navigation",
        "agents.navigation.basic_agent",
        "agents.navigation.constant_velocity_agent",
        "agents.navigation.global_route_planner",
        "agents.navigation.local_planner",
        "agents.tools",
        "agents.tools.misc",
        "cv2",
    ):
        module = ModuleType(name)
        module.__getattr__ = lambda _: type("Unused", (), {"__init__": lambda *_: None})  # type: ignore[method-assign]
        sys.modules[name] = module


_navigation()

from srunner.scenarioconfigs.openscenario_configuration import OpenScenarioConfiguration  # noqa: E402
from srunner.scenariomanager.carla_data_provider import CarlaDataProvider  # noqa: E402
from srunner.scenariomanager.timer import GameTime  # noqa: E402
from srunner.scenarios.open_scenario import OpenScenario  # noqa: E402
from srunner.tools.openscenario_parser import OpenScenarioParser  # noqa: E402

NEAR = 1e-5
"""Of positions [m]. CARLA keeps them as 32-bit numbers, twice on the way: further than 128 m from the origin, two steps
of these. Of headings [degrees] a thousand times as much.
"""
AWAY = -10.0
"""Who is lower than this [m] is not in the case."""


class Blueprint:
    """What CARLA would make an actor of."""

    def __init__(self, name: str) -> None:
        self.id = name
        self.attributes: dict[str, str] = {}

    def has_attribute(self, name: str) -> bool:
        return name == "role_name"

    def set_attribute(self, name: str, value: str) -> None:
        self.attributes[name] = value

    def has_tag(self, tag: str) -> bool:
        return tag in self.id


class Actor:
    """Keeps the transform that it is given; its bounding box lies a little ahead of its origin."""

    def __init__(self, number: int, blueprint: Blueprint, transform: Any) -> None:
        self.id, self.attributes, self.is_alive = number, dict(blueprint.attributes), True
        self.type_id = blueprint.id
        self.physics = True
        self._transform = transform
        height = 0.0 if blueprint.has_tag("walker") else 0.75
        self.bounding_box = carla.BoundingBox(carla.Location(0.03, 0.0, height), carla.Vector3D(2.3, 0.9, 0.75))

    def get_transform(self) -> Any:
        return carla.Transform(self._transform.location, self._transform.rotation)

    def set_transform(self, transform: Any) -> None:
        self._transform = carla.Transform(transform.location, transform.rotation)

    def get_location(self) -> Any:
        return self._transform.location

    def get_velocity(self) -> Any:
        return carla.Vector3D()

    def set_simulate_physics(self, on: bool) -> None:
        self.physics = on

    def destroy(self) -> bool:
        self.is_alive = False
        return True

    def middle(self) -> tuple[float, float]:
        """Of the bounding box."""
        yaw, box = math.radians(self._transform.rotation.yaw), self.bounding_box.location
        x, y = self._transform.location.x, self._transform.location.y
        return x + box.x * math.cos(yaw) - box.y * math.sin(yaw), y + box.x * math.sin(yaw) + box.y * math.cos(yaw)


class Library:
    def filter(self, pattern: str) -> list[Blueprint]:
        return [Blueprint(pattern)]

    def find(self, name: str) -> Blueprint:
        return Blueprint(name)


class World:
    """An OpenDRIVE road, as CARLA itself reads it."""

    def __init__(self, road: str) -> None:
        self.map = carla.Map("OpenDriveMap", road)
        self.actors: dict[int, Actor] = {}

    def get_settings(self) -> Any:
        return SimpleNamespace(synchronous_mode=True)

    def get_map(self) -> Any:
        return self.map

    def get_blueprint_library(self) -> Library:
        return Library()

    def get_actors(self, numbers: Any = None) -> Any:
        kept = [actor for actor in self.actors.values() if numbers is None or actor.id in numbers]
        return kept if numbers is not None else Everybody(kept)

    def try_spawn_actor(self, blueprint: Blueprint, transform: Any) -> Actor:
        actor = Actor(len(self.actors) + 1, blueprint, transform)
        self.actors[actor.id] = actor
        return actor

    def spawn_actor(self, blueprint: Blueprint, transform: Any) -> Actor:
        return self.try_spawn_actor(blueprint, transform)

    def tick(self) -> int:
        return 0

    def set_weather(self, _: Any) -> None:
        pass

    def get_weather(self) -> Any:
        return carla.WeatherParameters()


class Everybody(list):
    def filter(self, _: str) -> list[Actor]:
        return []


class Client:
    def __init__(self, road: str) -> None:
        self.world = World(road)

    def get_world(self) -> World:
        return self.world

    def generate_opendrive_world(self, road: str, _: Any) -> World:
        self.world = World(road)
        return self.world

    def apply_batch_sync(self, batch: list[Any], _: bool) -> list[Any]:
        actors = [self.world.try_spawn_actor(*spawned) for spawned in batch]
        return [SimpleNamespace(actor_id=actor.id, error=None) for actor in actors]


class Spawn(tuple):
    """In place of CARLA's command, which takes CARLA's own blueprints alone."""

    def __new__(cls, blueprint: Blueprint, transform: Any) -> "Spawn":
        return super().__new__(cls, (blueprint, transform))

    def then(self, _: Any) -> "Spawn":
        return self


for _command in ("SetAutopilot", "SetSimulatePhysics", "ApplyTransform", "SetVehicleLightState"):
    setattr(carla.command, _command, lambda *_: None)
carla.command.SpawnActor = Spawn


def check(job: dict) -> list[str]:
    """Play a file, and say where an actor was elsewhere than recorded."""
    _fresh()
    file = Path(job["file"])
    client = Client((file.parent / job["road"]).read_text(encoding="utf-8"))
    CarlaDataProvider.set_client(client)
    configuration = OpenScenarioConfiguration(str(file), client, {})
    if any(sign in configuration.name for sign in "/\\\n") or len(configuration.name) > 100:
        return [f"a name that is no folder: {configuration.name!r}"]
    egos = [
        CarlaDataProvider.request_new_actor(each.model, each.transform, each.rolename, actor_category=each.category)
        for each in configuration.ego_vehicles
    ]
    scenario = OpenScenario(client.world, egos, configuration, str(file), timeout=100000)
    played = {actor.attributes["role_name"]: actor for actor in client.world.actors.values()}
    missing = [name for name in job["names"] if name not in played]
    if missing:
        return [f"{', '.join(missing)} is not spawned"]
    return list(_deviations(scenario, [played[name] for name in job["names"]], job["ticks"], job["tick"]))


def _deviations(scenario: Any, actors: list[Actor], ticks: list[list[Any]], step: float) -> Iterator[str]:
    worst, turned, where = 0.0, 0.0, ""
    for number, poses in enumerate(ticks):
        GameTime.on_carla_tick(
            SimpleNamespace(frame=number + 1, delta_seconds=step, elapsed_seconds=(number + 1) * step)
        )
        CarlaDataProvider.on_carla_tick()
        scenario.scenario_tree.tick_once()
        for actor, pose in zip(actors, poses, strict=True):
            below = actor.get_location().z < AWAY
            if (pose is None) != below:
                yield f"{actor.attributes['role_name']} is {'away' if below else 'there'} at {number * step:.3f} s"
                return
            if pose is None:
                continue
            x, y = actor.middle()
            off = math.hypot(x - pose[0], -y - pose[1])
            angle = abs((-actor.get_transform().rotation.yaw - math.degrees(pose[2]) + 180.0) % 360.0 - 180.0)
            turned = max(turned, angle)
            if off > worst:
                worst, where = off, f"{actor.attributes['role_name']} at {number * step:.3f} s"
    print(f"{worst:.2e} m, {turned:.2e} degrees, {where}", file=sys.stderr)
    furthest = max((abs(value) for poses in ticks for pose in poses if pose for value in pose[:2]), default=0.0)
    if worst > max(NEAR, 2.0 * float(np.spacing(np.float32(furthest)))):
        yield f"{where} is {worst:.2e} m off"
    if turned > 1000 * NEAR:
        yield f"headings are {turned:.2e} degrees off"
    if any(actor.physics for actor in actors):
        yield "physics are on"


def _fresh() -> None:
    """Nothing is left of the file before."""
    CarlaDataProvider._actor_velocity_map.clear()
    CarlaDataProvider._actor_location_map.clear()
    CarlaDataProvider._actor_transform_map.clear()
    CarlaDataProvider._carla_actor_pool.clear()
    board = py_trees.blackboard.Blackboard()
    board.__dict__.clear()
    GameTime.restart()
    OpenScenarioParser.osc_filepath = None


if __name__ == "__main__":
    answer(check)

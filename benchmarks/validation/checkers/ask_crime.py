"""CommonRoad-CriMe: what its measures say of two cars on a straight road, against ours where both define the same."""

import json
import math
from pathlib import Path

import commonroad_crime.measure as measures
import numpy as np
from answering import answer
from commonroad.geometry.shape import Rectangle
from commonroad.prediction.prediction import TrajectoryPrediction
from commonroad.scenario.lanelet import Lanelet, LaneletNetwork
from commonroad.scenario.obstacle import DynamicObstacle, ObstacleType
from commonroad.scenario.scenario import Scenario, ScenarioID
from commonroad.scenario.state import CustomState, InitialState
from commonroad.scenario.trajectory import Trajectory
from commonroad_crime.data_structure.configuration import CriMeConfiguration

SLOPE = 1e-3
"""Of the road [rad]."""
UNLIMITED = 1e9
"""Jerk [m/s^3]: our brakes take hold at once."""
SHARE = 0.03
"""Deviation that rounding to two decimals, and the slope, may make."""


def check(job: dict) -> list[str]:
    """Every measure that is expected."""
    told = json.loads(Path(job["file"]).read_text(encoding="utf-8"))
    config = CriMeConfiguration()
    config.vehicle.ego_id = 1
    config.update(sce=scenario(told))
    config.debug.draw_visualization = False
    config.acceleration.acceleration_mode = 1
    config.vehicle.cartesian.j_x_min, config.vehicle.cartesian.j_x_max = -UNLIMITED, UNLIMITED
    found = []
    for name, ours in told["expected"].items():
        measure, other = getattr(measures, name)(config), None if name == "TTB" else 2
        theirs = float(measure.compute(vehicle_id=other, time_step=0, verbose=False))
        if not agrees(name, theirs, ours, told["step"]):
            found.append(f"{name} is {theirs:.4g} to CriMe, {ours:.4g} to us")
    return found


def agrees(name: str, theirs: float, ours: float, step: float) -> bool:
    """Whether two values are the same but for rounding; what CriMe finds by steps in time is up to two of them off."""
    if math.isinf(theirs) or math.isinf(ours):
        return theirs == ours
    steps = {"THW": 1.0, "TTB": 2.0, "TET": 1.0, "WTTC": 0.0}.get(name, 0.0)
    return abs(theirs - ours) <= 0.0101 + SHARE * abs(ours) + steps * step


def scenario(told: dict) -> Scenario:
    """Both cars at steady speeds in one lane."""
    scene, step, samples = told["scene"], told["step"], told["samples"]
    along = np.linspace(-50.0, 900.0, 476)
    lines = [np.column_stack([along, side + SLOPE * along]) for side in (1.75, 0.0, -1.75)]
    made = Scenario(step, ScenarioID.from_benchmark_id("ZAM_Pair-1_1_T-1", "2020a"))
    made.add_objects(LaneletNetwork.create_from_lanelet_list([Lanelet(*lines, 100)]))
    shape = Rectangle(scene["length"], scene["width"])
    made.add_objects(
        [
            car(1, 0.0, scene["ego"], shape, step, samples),
            car(2, scene["gap"] + scene["length"], scene["other"], shape, step, samples),
        ]
    )
    made.assign_obstacles_to_lanelets()
    return made


def car(number: int, x: float, speed: float, shape: Rectangle, step: float, samples: int) -> DynamicObstacle:
    """A car on its way."""

    def place(k: int) -> np.ndarray:
        way = x + speed * step * k
        return np.array([way * math.cos(SLOPE), way * math.sin(SLOPE)])

    start = InitialState(
        position=place(0),
        velocity=speed,
        acceleration=0.0,
        orientation=SLOPE,
        yaw_rate=0.0,
        slip_angle=0.0,
        time_step=0,
    )
    states = [
        CustomState(
            position=place(k),
            velocity=speed,
            velocity_y=0.0,
            acceleration=0.0,
            acceleration_y=0.0,
            orientation=SLOPE,
            time_step=k,
        )
        for k in range(1, samples)
    ]
    return DynamicObstacle(number, ObstacleType.CAR, shape, start, TrajectoryPrediction(Trajectory(1, states), shape))


answer(check)

"""Scenario A by hand: the rollout that a specialist would write for `examples/left_turn.scn` and nothing else.

Two cars, one path each, one set of interrupts, no registers, no interpreter, no other actor kinds. Physics, controller,
contact search and metrics are the functions of `engine.kernels`, so that its outcomes equal those of the batch host bit
for bit and the difference in time is the price of generality alone.
"""

import math
from typing import NamedTuple

import numpy as np

from engine.config import SimulationConfig
from engine.host import samples_of
from engine.kernels.approach import circles_apart, first_contact
from engine.kernels.bicycle import GRAVITY, Demand, Motion, Vehicle, drive
from engine.kernels.geometry import Box, View
from engine.kernels.jit import inlined, kernel
from engine.kernels.pair import measure_pair
from engine.kernels.path import path_pose, path_project, path_project_near
from engine.kernels.region import region_contains
from engine.kernels.sight import SEEN, Shades, look
from engine.kernels.steering import pedals_towards, planned_speed, steer_along
from engine.program import Program
from engine.scenes import Scenes
from engine.tables import ROAD_REGION, Floats, Ints, RoadTables
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind, Column, State

TERM_DIST = 70.0
MAX_LATERAL = 3.0


class Inputs(NamedTuple):
    """What scenario A leaves open, one row a scene. SI."""

    start: Floats
    """(n, 2, len(Column))"""
    path: Ints
    """(n, 2)"""
    target: Floats
    """(n, 2) [m/s]"""
    brake: Floats
    safety: Floats
    crash: Floats


class Results(NamedTuple):
    """Outcomes, one row a scene."""

    collided: np.ndarray
    end_time: Floats
    steps: Ints
    metrics: Floats
    """(n, 4) MD, MS, D_MS, TTC_MS"""
    left_road: Floats
    """(n, 2)"""


def inputs(program: Program, scenes: Scenes) -> Inputs:
    """The numbers of scenario A in the valid rows of `scenes`."""
    rows = np.flatnonzero(scenes.valid)
    genes = dict(zip(program.space.names, (scenes.genomes[rows] * program.space.scale).T, strict=True))
    columns = len(Column)
    return Inputs(
        start=scenes.values[rows, : 2 * columns].reshape(-1, 2, columns).copy(),
        path=program.routes[scenes.variant[rows]].copy(),
        target=np.stack([genes["EGO_SPEED"], genes["ADV_SPEED"]], axis=1),
        brake=genes["EGO_BRAKE"].copy(),
        safety=genes["SAFETY_DIST"].copy(),
        crash=genes["CRASH_DIST"].copy(),
    )


def simulate(program: Program, given: Inputs, config: SimulationConfig) -> Results:
    """Run all scenes on one thread."""
    count, samples = len(given.brake), samples_of(config)
    results = Results(
        np.zeros(count, dtype=np.bool_),
        np.zeros(count),
        np.zeros(count, dtype=np.int32),
        np.zeros((count, 4)),
        np.full((count, 2), np.nan),
    )
    model = MODELS[ActorKind.CAR]
    states = np.zeros((samples + 2, 2, len(State)))
    _simulate(program.road, given, config.time_step, samples, model.steer_rate, model.top_speed, states, results)
    return results


class Car(NamedTuple):
    """What a car is and wants."""

    vehicle: Vehicle
    to_center: float
    path: int
    path_length: float
    target: float
    length: float
    width: float
    reach: float
    """At most so far does the outline reach ahead of its centre [m]."""


class Choice(NamedTuple):
    """What its driver does in this step."""

    demand: Demand
    s: float
    arrived: bool


@inlined
def _car(road: RoadTables, start: Floats, path: int, target: float, steer_rate: float, max_speed: float) -> Car:
    vehicle = Vehicle(
        start[Column.WHEELBASE],
        start[Column.MAX_STEER],
        steer_rate,
        start[Column.MAX_ACCELERATION],
        start[Column.MAX_BRAKING],
        GRAVITY * start[Column.FRICTION],
        max_speed,
    )
    length, width = start[Column.LENGTH], start[Column.WIDTH]
    behind, reach = start[Column.REAR_TO_CENTER], 0.5 * (length + width)
    return Car(vehicle, behind, path, road.path_length[path], target, length, width, reach)


@inlined
def _rear_axle(start: Floats) -> Motion:
    heading, back = start[Column.HEADING], start[Column.REAR_TO_CENTER]
    cos, sin = math.cos(heading), math.sin(heading)
    return Motion(
        start[Column.X] - back * cos, start[Column.Y] - back * sin, heading, cos, sin, start[Column.SPEED], 0.0
    )


@inlined
def _outline(start: Floats) -> Box:
    return Box(start[Column.X], start[Column.Y], start[Column.HEADING], start[Column.LENGTH], start[Column.WIDTH])


@kernel
def _passes_end(road: RoadTables, car: Car, motion: Motion, left: float) -> bool:
    """Whether the outline reaches beyond the end of the path, which is the end of the road."""
    end = path_pose(road, car.path, car.path_length)
    turn_cos = math.cos(motion.heading - end.heading)
    turn_sin = math.sin(motion.heading - end.heading)
    return car.to_center + 0.5 * (car.length * abs(turn_cos) + car.width * abs(turn_sin)) > left


@inlined
def _follow(road: RoadTables, car: Car, motion: Motion, s: float, steer: float, time_step: float) -> Choice:
    """FollowTrajectoryBehavior; at the path's end nothing is commanded but the wheels stay as they are."""
    point = path_project_near(road, car.path, motion.x, motion.y, s)
    vehicle, left = car.vehicle, car.path_length - point.s
    way = (motion.speed + 0.5 * vehicle.max_acceleration * time_step) * time_step
    if left <= car.to_center:
        return Choice(Demand(0.0, steer), point.s, True)
    if left <= car.to_center + car.reach + way and _passes_end(road, car, motion, left - way):
        return Choice(Demand(0.0, steer), point.s, True)
    steer = steer_along(road, car.path, point, motion.heading, motion.speed, vehicle.wheelbase, time_step)
    wanted = planned_speed(road, car.path, point.s, motion.speed, car.target, MAX_LATERAL)
    pedals = pedals_towards(wanted, motion.speed, vehicle.max_acceleration, vehicle.max_braking)
    if pedals.brake != 0.0:
        return Choice(Demand(-pedals.brake * vehicle.max_braking, steer), point.s, False)
    return Choice(Demand(pedals.throttle * vehicle.max_acceleration, steer), point.s, False)


@inlined
def _moved(motion: Motion, to_center: float, box: Box) -> Box:
    return Box(
        motion.x + to_center * motion.cos, motion.y + to_center * motion.sin, motion.heading, box.length, box.width
    )


@inlined
def _record(states: Floats, sample: int, actor: int, box: Box, speed: float) -> None:
    states[sample, actor, State.X] = box.x
    states[sample, actor, State.Y] = box.y
    states[sample, actor, State.HEADING] = box.heading
    states[sample, actor, State.SPEED] = speed
    states[sample, actor, State.PRESENT] = 1.0


@inlined
def _watch_road(road: RoadTables, box: Box, time: float, left: Floats, actor: int) -> None:
    if math.isnan(left[actor]) and not region_contains(road, ROAD_REGION, box.x, box.y):
        left[actor] = time


@kernel
def _simulate(
    road: RoadTables,
    given: Inputs,
    time_step: float,
    last_sample: int,
    steer_rate: float,
    max_speed: float,
    states: Floats,
    results: Results,
) -> None:
    outlines = np.zeros((2, 3))
    for row in range(len(given.brake)):
        start, left_road = given.start[row], results.left_road[row]
        ego_car = _car(road, start[0], given.path[row, 0], given.target[row, 0], steer_rate, max_speed)
        other_car = _car(road, start[1], given.path[row, 1], given.target[row, 1], steer_rate, max_speed)
        ego, other = _rear_axle(start[0]), _rear_axle(start[1])
        ego_box, other_box = _outline(start[0]), _outline(start[1])
        ego_s = path_project(road, ego_car.path, ego.x, ego.y)
        other_s = path_project(road, other_car.path, other.x, other.y)
        angle, radius = start[0, Column.VIEW_ANGLE], start[0, Column.VIEW_DISTANCE]
        safety, crash, brake = given.safety[row], given.crash[row], given.brake[row]
        nearest = max(safety, crash)
        ego_steer, other_steer = 0.0, 0.0
        sample, contact = 0, -1.0
        _record(states, 0, 0, ego_box, ego.speed)
        _record(states, 0, 1, other_box, other.speed)
        while contact < 0.0:
            if math.hypot(ego_box.x - start[0, Column.X], ego_box.y - start[0, Column.Y]) > TERM_DIST:
                break
            if sample >= last_sample:
                break
            dx, dy = other_box.x - ego_box.x, other_box.y - ego_box.y
            apart = dx * dx + dy * dy
            view = View(ego_box.x, ego_box.y, ego_box.heading, angle, radius)
            nobody = Shades(start[0], 0, 0, -1, -1)  # two alone: nothing hides
            seen = apart < nearest * nearest and look(view, other_box, nobody, road.buildings) == SEEN
            if seen and apart < crash * crash:
                break
            if seen and apart < safety * safety:
                choice = Choice(Demand(-brake * ego_car.vehicle.max_braking, ego_steer), ego_s, False)
            else:
                choice = _follow(road, ego_car, ego, ego_s, ego_steer, time_step)
            other_choice = _follow(road, other_car, other, other_s, other_steer, time_step)
            if choice.arrived or other_choice.arrived:  # fewer than two are left
                break
            ego_s, ego_steer = choice.s, choice.demand.steer
            other_s, other_steer = other_choice.s, other_choice.demand.steer
            _watch_road(road, ego_box, sample * time_step, left_road, 0)
            _watch_road(road, other_box, sample * time_step, left_road, 1)
            ego = drive(ego, choice.demand, ego_car.vehicle, time_step)
            other = drive(other, other_choice.demand, other_car.vehicle, time_step)
            ego_next, other_next = (
                _moved(ego, ego_car.to_center, ego_box),
                _moved(other, other_car.to_center, other_box),
            )
            _record(states, sample + 1, 0, ego_next, ego.speed)
            _record(states, sample + 1, 1, other_next, other.speed)
            if not circles_apart(ego_box, ego_next, other_box, other_next):
                contact = first_contact(ego_box, ego_next, other_box, other_next)
            ego_box, other_box = ego_next, other_next
            sample += 1
        hit = contact >= 0.0
        results.collided[row] = hit
        results.steps[row] = sample
        results.end_time[row] = (sample - 1 + contact) * time_step if hit else sample * time_step
        outlines[0, 0], outlines[0, 1], outlines[0, 2] = ego_box.length, ego_box.width, ego_car.to_center
        outlines[1, 0], outlines[1, 1], outlines[1, 2] = other_box.length, other_box.width, other_car.to_center
        samples, ending = (sample, contact) if hit else (sample + 1, 0.0)
        metrics = measure_pair(states, samples, time_step, 1, outlines, hit, ending)
        results.metrics[row, 0] = metrics.min_distance
        results.metrics[row, 1] = metrics.max_closing_speed
        results.metrics[row, 2] = metrics.distance_at_ms
        results.metrics[row, 3] = metrics.ttc_at_ms

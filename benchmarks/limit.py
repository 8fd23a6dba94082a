"""Scenario A by hand: the rollout that a specialist would write for `examples/left_turn.scn` and nothing else.

Two cars, one path each, one set of interrupts, no registers, no interpreter, no other actor kinds. Physics, controller,
contact search and metrics are the functions of `engine.kernels`, so that its outcomes equal those of the batch host bit
for bit and the difference in time is the price of generality alone.
"""

import math
from typing import NamedTuple

import numpy as np

from engine.config import SimulationConfig
from engine.kernels.bicycle import GRAVITY, Demand, Motion, Vehicle, drive
from engine.kernels.geometry import Box, circles_apart, first_contact
from engine.kernels.inline import inlined
from engine.kernels.jit import kernel
from engine.kernels.measure import measure_pair
from engine.kernels.path import path_project, path_project_near
from engine.kernels.region import region_contains
from engine.kernels.steering import pedals_towards, planned_speed, steer_along
from engine.kernels.view import View, sees
from engine.program import Program
from engine.runs import samples_of
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
    _simulate(program.road, given, config.time_step, samples, model.steer_rate, model.max_speed, states, results)
    return results


@inlined
def _vehicle(start: Floats, steer_rate: float, max_speed: float) -> Vehicle:
    return Vehicle(
        start[Column.WHEELBASE],
        start[Column.MAX_STEER],
        steer_rate,
        start[Column.MAX_ACCELERATION],
        start[Column.MAX_BRAKING],
        GRAVITY * start[Column.FRICTION],
        max_speed,
    )


@inlined
def _rear_axle(start: Floats) -> Motion:
    heading, back = start[Column.HEADING], start[Column.REAR_TO_CENTER]
    x, y = start[Column.X] - back * math.cos(heading), start[Column.Y] - back * math.sin(heading)
    return Motion(x, y, heading, start[Column.SPEED], 0.0)


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
    outlines = np.zeros((2, 2))
    for row in range(len(given.brake)):
        start = given.start[row]
        vehicle = _vehicle(start[0], steer_rate, max_speed)
        other_vehicle = _vehicle(start[1], steer_rate, max_speed)
        ego, other = _rear_axle(start[0]), _rear_axle(start[1])
        ego_ahead, other_ahead = start[0, Column.REAR_TO_CENTER], start[1, Column.REAR_TO_CENTER]
        ego_box = Box(
            start[0, Column.X], start[0, Column.Y], ego.heading, start[0, Column.LENGTH], start[0, Column.WIDTH]
        )
        other_box = Box(
            start[1, Column.X], start[1, Column.Y], other.heading, start[1, Column.LENGTH], start[1, Column.WIDTH]
        )
        ego_path, other_path = given.path[row, 0], given.path[row, 1]
        ego_s = path_project(road, ego_path, ego.x, ego.y)
        other_s = path_project(road, other_path, other.x, other.y)
        ego_length, other_length = road.path_length[ego_path], road.path_length[other_path]
        angle, radius = start[0, Column.VIEW_ANGLE], start[0, Column.VIEW_DISTANCE]
        safety, crash = given.safety[row], given.crash[row]
        ego_steer, other_steer = 0.0, 0.0
        contact = -1.0
        sample = 0
        _record(states, 0, 0, ego_box, ego.speed, 1.0)
        _record(states, 0, 1, other_box, other.speed, 1.0)
        while True:
            # rules
            if math.hypot(ego_box.x - start[0, Column.X], ego_box.y - start[0, Column.Y]) > TERM_DIST:
                break
            if sample >= last_sample:
                break
            # behaviours
            dx, dy = other_box.x - ego_box.x, other_box.y - ego_box.y
            apart = dx * dx + dy * dy
            nearest = max(safety, crash)
            seen = apart < nearest * nearest and sees(
                View(ego_box.x, ego_box.y, ego_box.heading, angle, radius), other_box
            )
            if seen and apart < crash * crash:
                break
            ego_acceleration = 0.0
            leaving = False
            if seen and apart < safety * safety:
                ego_acceleration = -given.brake[row] * vehicle.max_braking
            else:
                point = path_project_near(road, ego_path, ego.x, ego.y, ego_s)
                ego_s = point.s
                if ego_s + ego_ahead >= ego_length:
                    leaving = True
                else:
                    ego_steer = steer_along(road, ego_path, point, ego.heading, ego.speed, vehicle.wheelbase)
                    wanted = planned_speed(road, ego_path, ego_s, ego.speed, given.target[row, 0], MAX_LATERAL)
                    pedals = pedals_towards(wanted, ego.speed, vehicle.max_acceleration, vehicle.max_braking)
                    ego_acceleration = (
                        -pedals.brake * vehicle.max_braking
                        if pedals.brake != 0.0
                        else pedals.throttle * vehicle.max_acceleration
                    )
            other_acceleration = 0.0
            point = path_project_near(road, other_path, other.x, other.y, other_s)
            other_s = point.s
            if other_s + other_ahead >= other_length:
                leaving = True
            else:
                other_steer = steer_along(road, other_path, point, other.heading, other.speed, other_vehicle.wheelbase)
                wanted = planned_speed(road, other_path, other_s, other.speed, given.target[row, 1], MAX_LATERAL)
                pedals = pedals_towards(wanted, other.speed, other_vehicle.max_acceleration, other_vehicle.max_braking)
                other_acceleration = (
                    -pedals.brake * other_vehicle.max_braking
                    if pedals.brake != 0.0
                    else pedals.throttle * other_vehicle.max_acceleration
                )
            if leaving:  # fewer than two are left
                break
            # motion
            if math.isnan(results.left_road[row, 0]) and not region_contains(road, ROAD_REGION, ego_box.x, ego_box.y):
                results.left_road[row, 0] = sample * time_step
            if math.isnan(results.left_road[row, 1]) and not region_contains(
                road, ROAD_REGION, other_box.x, other_box.y
            ):
                results.left_road[row, 1] = sample * time_step
            ego = drive(ego, Demand(ego_acceleration, ego_steer), vehicle, time_step)
            other = drive(other, Demand(other_acceleration, other_steer), other_vehicle, time_step)
            ego_next = _box_of(ego, ego_ahead, ego_box)
            other_next = _box_of(other, other_ahead, other_box)
            _record(states, sample + 1, 0, ego_next, ego.speed, 1.0)
            _record(states, sample + 1, 1, other_next, other.speed, 1.0)
            # contact
            if not circles_apart(ego_box, ego_next, other_box, other_next):
                contact = first_contact(ego_box, ego_next, other_box, other_next)
            ego_box, other_box = ego_next, other_next
            sample += 1
            if contact >= 0.0:
                break
        hit = contact >= 0.0
        results.collided[row] = hit
        results.steps[row] = sample
        results.end_time[row] = (sample - 1 + contact) * time_step if hit else sample * time_step
        outlines[0, 0], outlines[0, 1] = ego_box.length, ego_box.width
        outlines[1, 0], outlines[1, 1] = other_box.length, other_box.width
        metrics = measure_pair(states, sample if hit else sample + 1, time_step, 1, outlines, hit)
        results.metrics[row, 0] = metrics.min_distance
        results.metrics[row, 1] = metrics.max_closing_speed
        results.metrics[row, 2] = metrics.distance_at_ms
        results.metrics[row, 3] = metrics.ttc_at_ms


@inlined
def _box_of(motion: Motion, ahead: float, box: Box) -> Box:
    x, y = motion.x + ahead * math.cos(motion.heading), motion.y + ahead * math.sin(motion.heading)
    return Box(x, y, motion.heading, box.length, box.width)


@inlined
def _record(states: Floats, sample: int, actor: int, box: Box, speed: float, present: float) -> None:
    states[sample, actor, State.X] = box.x
    states[sample, actor, State.Y] = box.y
    states[sample, actor, State.HEADING] = box.heading
    states[sample, actor, State.SPEED] = speed
    states[sample, actor, State.PRESENT] = present

"""Rates of a pymunk loop as one writes it for a single scenario: `python drive_pymunk.py REACTS STEP SECONDS`.

Two cars on a crossing, one straight on and one turning left across its path: each a box that follows points by pure
pursuit, with the bicycle model. `REACTS` is 1 where the first car brakes when the other is within 10 m. A run ends at
contact, at the end of the first car's way, or after 20 s. Prints one JSON object of rates per second of processor time.
Runs in an environment of its own and imports nothing of ours.
"""

import json
import math
import random
import sys
import time

import pymunk

WHEELBASE = 2.7
MASS, INERTIA = 1500.0, 3000.0
LENGTH, WIDTH = 4.5, 2.0
LOOK_AHEAD = 5.0
NEAR = 10.0
BRAKING = 8.0
LONGEST = 20.0
RADIUS = 11.0


class Car:
    """A box on its way: points 1 m apart, the index of the nearest, speed [m/s]."""

    def __init__(self, space: pymunk.Space, way: list[tuple[float, float]], at: int, speed: float) -> None:
        self.way, self.at, self.speed = way, at, speed
        self.body = pymunk.Body(MASS, INERTIA)
        self.body.position = way[at]
        self.body.angle = math.atan2(way[at + 1][1] - way[at][1], way[at + 1][0] - way[at][0])
        self.shape = pymunk.Poly.create_box(self.body, (LENGTH, WIDTH))
        self.shape.sensor = True
        space.add(self.body, self.shape)

    def act(self, step: float, brake: bool) -> None:
        """Steer towards the point ahead and set the velocities of the next step."""
        x, y = self.body.position
        while self.at + 2 < len(self.way) and _apart(self.way[self.at + 1], (x, y)) < _apart(self.way[self.at], (x, y)):
            self.at += 1
        goal = self.way[min(self.at + round(LOOK_AHEAD), len(self.way) - 1)]
        off = math.atan2(goal[1] - y, goal[0] - x) - self.body.angle
        curvature = 2.0 * math.sin(off) / LOOK_AHEAD
        steer = max(-0.6, min(0.6, math.atan(WHEELBASE * curvature)))
        self.speed = max(0.0, self.speed - BRAKING * step) if brake else self.speed
        heading = self.body.angle
        self.body.velocity = (self.speed * math.cos(heading), self.speed * math.sin(heading))
        self.body.angular_velocity = self.speed * math.tan(steer) / WHEELBASE


def _apart(one: tuple[float, float], other: tuple[float, float]) -> float:
    return math.hypot(one[0] - other[0], one[1] - other[1])


def straight() -> list[tuple[float, float]]:
    return [(1.75, -60.0 + i) for i in range(131)]


def left_turn() -> list[tuple[float, float]]:
    arc = [(i / RADIUS) for i in range(round(RADIUS * math.pi / 2))]
    into = [(-1.75, 60.0 - i) for i in range(51)]
    turn = [(-1.75 + RADIUS * (1 - math.cos(a)), 9.0 - RADIUS * math.sin(a)) for a in arc]
    return into + turn + [(10.0 + i, -1.75) for i in range(60)]


def run(reacts: bool, step: float) -> float:
    """Simulate one scene; return its vehicle-seconds."""
    space = pymunk.Space()
    ego = Car(space, straight(), random.randint(10, 40), random.uniform(5.0, 15.0))
    other = Car(space, left_turn(), random.randint(10, 40), random.uniform(5.0, 15.0))
    touched: list[object] = []
    space.on_collision(begin=lambda *contact: touched.append(contact))
    least, spent = math.inf, 0.0
    for _ in range(round(LONGEST / step)):
        apart = _apart(ego.body.position, other.body.position)
        least = min(least, apart)
        ego.act(step, reacts and apart < NEAR)
        other.act(step, False)
        space.step(step)
        spent += 2 * step
        if touched or ego.at > 120 or other.at + 2 >= len(other.way):
            break
    return spent


def main(reacts: str, step: str, seconds: str) -> None:
    """Run scenes for so long [s], at steps of `step` [s]."""
    random.seed(1)
    runs, driven, begun = 0, 0.0, time.process_time()
    while (spent := time.process_time() - begun) < float(seconds):
        driven += run(reacts == "1", float(step))
        runs += 1
    print(json.dumps({"driven": driven / spent, "runs": runs / spent}))


if __name__ == "__main__":
    main(*sys.argv[1:])

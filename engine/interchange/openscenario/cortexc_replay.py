"""Replays a recorded case in CARLA's ScenarioRunner: keep this file beside the .xosc that names it.

ScenarioRunner loads it as the controller of every actor, by the property `module` of <Controller>, and hands it the
timed polylines. At each tick it puts the actor where it was then, straight between two vertices: nothing steers, and
the physics of the actor are off, so that nothing pushes. Its properties:

module    cortexc_replay.py
ahead     how far ahead of the reference point, the rear axle, the middle of the outline lies [m]
physics   on or off; off where it is left out
"""

from __future__ import annotations  # ScenarioRunner runs on Python 3.7, too

import math
from bisect import bisect_right
from importlib import import_module
from typing import Any


def game_time() -> float:
    """Seconds of ScenarioRunner's clock, one for all actors of a tick."""
    return import_module("srunner.scenariomanager.timer").GameTime.get_time()


class CortexcReplay:
    """What ScenarioRunner asks of a controller; of speeds, offsets and goals that it is told, a replay needs none."""

    def __init__(self, actor: Any, args: dict[str, str] | None = None) -> None:
        properties = args or {}
        self._actor: Any = actor
        self._ahead = float(properties.get("ahead", 0.0))
        self._physics = properties.get("physics", "off") == "on"
        self._begun: float | None = None
        self._times: list[float] = []
        self._poses: list[tuple[float, float, float, float]] = []
        self._done = False

    def update_waypoints(
        self, waypoints: list[Any], times: list[float] | None = None, start_time: float | None = None
    ) -> None:
        """Take over a polyline: transforms of the reference point, and when each is reached [s]."""
        del start_time  # the times are those of the scenario
        self._poses = [(p.location.x, p.location.y, p.location.z, p.rotation.yaw) for p in waypoints]
        self._times = list(times or ())
        self._done = False

    def update_target_speed(self, speed: float) -> None:
        """Pass over a speed: it follows from the polyline."""

    def update_offset(self, offset: float, start_time: float | None = None) -> None:
        """Pass over an offset."""

    def set_init_speed(self) -> None:
        """Pass over a speed at the start."""

    def check_reached_waypoint_goal(self) -> bool:
        """Whether the last vertex lies behind."""
        return self._done

    def reset(self) -> None:
        """Let go of the actor."""
        self._actor = None

    def run_step(self) -> None:
        """Put the actor where it is now."""
        if self._begun is None:  # in the first tick, for all
            self._begun = game_time()
            if self._actor is not None and not self._physics:
                self._actor.set_simulate_physics(False)
        if self._actor is None or not self._actor.is_alive or not self._times:
            return
        time = game_time() - self._begun
        self._put(*self._pose(time))
        self._done = time >= self._times[-1] - 1e-9

    def _pose(self, time: float) -> tuple[float, float, float, float]:
        """x, y, z and yaw [degrees] of the reference point."""
        after = bisect_right(self._times, time)
        if after == 0 or after == len(self._times):
            return self._poses[min(after, len(self._times) - 1)]
        before = after - 1
        part = (time - self._times[before]) / (self._times[after] - self._times[before])
        (x, y, z, yaw), (to_x, to_y, to_z, to_yaw) = self._poses[before], self._poses[after]
        return x + part * (to_x - x), y + part * (to_y - y), z + part * (to_z - z), yaw + part * (to_yaw - yaw)

    def _put(self, x: float, y: float, z: float, yaw: float) -> None:
        """Lay the middle of CARLA's bounding box upon that of the outline, and its bottom upon the road."""
        box = self._actor.bounding_box
        along, across = self._ahead - box.location.x, -box.location.y
        cos, sin = math.cos(math.radians(yaw)), math.sin(math.radians(yaw))
        transform = self._actor.get_transform()
        transform.location.x = x + along * cos - across * sin
        transform.location.y = y + along * sin + across * cos
        transform.location.z = z + box.extent.z - box.location.z
        transform.rotation.yaw = yaw
        transform.rotation.pitch = transform.rotation.roll = 0.0
        self._actor.set_transform(transform)

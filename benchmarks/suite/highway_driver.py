"""A driver from outside: the `IDMVehicle` of highway-env decides on acceleration, lane and steering of the ego.

    python -m pip install -e '.[bench]'                               # highway-env is one of the packages of this extra
    cortexc benchmarks/suite/highway/outside_cut_in.scn --ego python:benchmarks.suite.highway_driver:IdmMobil --seed 1

The package (E. Leurent 2018, https://github.com/Farama-Foundation/HighwayEnv, MIT) is unchanged, with its own
parameters; results name its version. `IDMVehicle.act` decides, with `acceleration` and `desired_gap` (IDM, at most
6 m/s^2), `change_lane_policy` and `mobil` (MOBIL, once a second), `steering_control`, and `Road.neighbour_vehicles` on
lanes of type `StraightLane`. This module adds:

- perception: place, heading and speed of each actor, as the file records them; no actor is hidden
- other actors as `IDMVehicle`s whose target speed and target lane are their present ones, because nobody observes
  intentions; they decide nothing
- `target speed` and `phase` of the file: the desired speed of the ego, and the age of its last lane decision at its
  start
- a decision every 0.2 s, as in `highway-fast-v0` of the package

The ego of a file has the body of the package's vehicle: 5 m by 2 m, axles at both ends, wheels that turn at once and do
not slip, 6 m/s^2 at full throttle and at full brake. `tests/test_suite_driver.py` compares both motions.

The frame of the package has x along the road and y to the right; lanes count from the left. The road is one of `map
road(lanes=3, one_way=True)`.
"""

from types import SimpleNamespace
from typing import Any

import numpy as np

from engine.extras import needed
from engine.tables import Bools, Floats, Ints

EXTRA, PACKAGE, MODULE = "bench", "highway-env", "highway_env"
LANES, WIDTH = 3, 3.5
"""Lanes of the road, and the width of each [m]."""
FAR = 1e5
"""Distance of the ends of a lane from the middle of the road [m]; longer than every road."""
PLACE = ("{}.x", "{}.y", "{} heading", "{} speed")
"""Columns of an actor: x, y [m], heading [rad], speed [m/s]."""
EGO = "ego"


def lanes_of(right: Floats) -> Ints:
    """Return the lane with the nearest centre line, counted from the left; `right`: distance from the left edge [m]."""
    return np.clip(np.floor(right / WIDTH), 0, LANES - 1).astype(np.int64)


def pedals(acceleration: float, steering: float, strongest: float) -> tuple[float, float, float]:
    """Return throttle, brake, and steering angle [rad, positive to the left] for a decision of the package.

    `acceleration` [m/s^2]; `steering` [rad, positive to the right]; `strongest`: acceleration at a full pedal [m/s^2].
    """
    share = acceleration / strongest
    return max(share, 0.0), max(-share, 0.0), -steering


class IdmMobil:
    """A controller with pedals that has one `IDMVehicle` for each slot.

    Raises:
        MissingExtraError: highway-env is not installed.
    """

    def __init__(self) -> None:
        names = {"behavior": "vehicle.behavior", "road": "road.road", "lane": "road.lane"}
        modules = {
            key: needed(f"highway_env.{name}", "this driver needs", EXTRA, PACKAGE) for key, name in names.items()
        }
        self._package = SimpleNamespace(**modules)
        network = self._package.road.RoadNetwork()
        for number in range(LANES):
            middle = (number + 0.5) * WIDTH
            lane = self._package.lane.StraightLane((-FAR, middle), (FAR, middle), WIDTH, speed_limit=None)
            network.add_lane("back", "front", lane)
        self._network = network
        self._indices = [("back", "front", number) for number in range(LANES)]
        self._lanes = [network.get_lane(index) for index in self._indices]
        self._egos: dict[int, Any] = {}
        self._columns, self._every = np.zeros((0, len(PLACE)), dtype=np.int64), 0.0
        self._wish = self._phase = 0
        self._road: Any = None
        self._others: list[Any] = []

    def meet(self, header: dict[str, Any]) -> None:
        """Find the columns of the actors, and make one vehicle for each actor but the ego; all slots share these."""
        names = [each["name"] for each in header["observations"]]
        others = [name.removesuffix(" heading") for name in names if name.endswith(" heading")]
        others.remove(EGO)
        self._columns = np.array([[names.index(each.format(actor)) for each in PLACE] for actor in (EGO, *others)])
        self._wish, self._phase, self._every = names.index("target speed"), names.index("phase"), header["every"]
        self._road = self._package.road.Road(self._network, [])
        self._others = [self._car() for _ in others]

    def reset(self, lanes: Ints, keys: Ints) -> None:
        """Forget the scenes of these slots."""
        del keys
        for slot in lanes.tolist():
            self._egos.pop(slot, None)

    def act(self, observations: Floats, active: Bools) -> Floats:
        """Return throttle, brake and steering angle (n, 3) of the rows that are `active`."""
        actions = np.zeros((len(observations), 3))
        seen = observations[:, self._columns]
        places = seen[:, :, :2] * (1.0, -1.0)
        lanes, speeds, headings = lanes_of(places[:, :, 1]).tolist(), seen[:, :, 3].tolist(), (-seen[:, :, 2]).tolist()
        for row in np.flatnonzero(active).tolist():
            ego = self._egos.get(row)
            if ego is None:
                ego = self._egos[row] = self._car()
                ego.timer, ego.target_lane_index = observations[row, self._phase], self._indices[lanes[row][0]]
            cars = [ego, *self._others]
            for car, place, heading, speed, lane in zip(
                cars, places[row], headings[row], speeds[row], lanes[row], strict=True
            ):
                car.position, car.heading, car.speed = place, heading, speed
                car.lane_index, car.lane = self._indices[lane], self._lanes[lane]
                if car is not ego:
                    car.target_lane_index, car.target_speed = car.lane_index, speed
            ego.target_speed = observations[row, self._wish]
            self._road.vehicles = cars
            ego.act()
            ego.timer += self._every
            actions[row] = pedals(ego.action["acceleration"], ego.action["steering"], ego.ACC_MAX)
        return actions

    def _car(self) -> Any:
        return self._package.behavior.IDMVehicle(self._road, (0.0, 0.0))

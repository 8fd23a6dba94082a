"""Lanes during the run, library behaviors and traffic lights."""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.errors.problems import Problem, note, warning

NOT_ON_GRID = Problem(
    "SCN450",
    "a gridded road has no `{name}`",
    "it is made of lanes and intersections only",
    "place people with `right of ego by 3` or `at (x, y)`, and `with regionContainedIn None`",
    page=Page(
        "not part of a gridded road",
        "Scenic's maps know sidewalks, kerbs, shoulders and crossings; the grid has lanes and intersections.",
        "ego = new Car on road\nnew Pedestrian on network.sidewalks[0]\n",
        "ego = new Car on road\nnew Pedestrian right of ego by 2, with regionContainedIn None\n",
    ),
)
NO_SIGNALS = Problem(
    "SCN451",
    "{what} needs traffic lights, and there are none",
    cure="add a line like `signals(green=10 s, yellow=3 s)` after the map",
    page=Page(
        "no traffic lights",
        "Intersections have lights only where the file says `signals(...)`.",
        "ego = new Car on road, with behavior FollowLaneBehavior(obey_signals=True)\n",
        "signals()\nego = new Car on road, with behavior FollowLaneBehavior(obey_signals=True)\n",
    ),
)
UNKNOWN_COLOUR = Problem(
    "SCN452",
    "no traffic light shows {actual}",
    cure="{suggestion}",
    page=Page(
        "unknown colour of a light",
        "Lights are `green`, `yellow`, `red`, `off` or `unknown`; where there is none, their status is `None`.",
        'signals()\nego = new Car on road\nterminate when getClosestTrafficLightStatus(ego) == "amber"\n',
        'signals()\nego = new Car on road\nterminate when getClosestTrafficLightStatus(ego) == "yellow"\n',
    ),
)
SIGNALS_UNUSED = warning(
    "SCN453",
    "nobody looks at the traffic lights",
    "they change nothing by themselves",
    "drive with `obey_signals=True`, or ask `withinDistanceToRedYellowTrafficLight(self, 15)`",
    page=Page(
        "traffic lights without effect",
        "Lights act through those who look at them: a library behavior with `obey_signals`, or a condition.",
        "signals()\nego = new Car on road, with behavior FollowLaneBehavior()\n",
        "signals()\nego = new Car on road, with behavior FollowLaneBehavior(obey_signals=True)\n",
    ),
)
SIGNALS_TWICE = Problem(
    "SCN454",
    "the traffic lights are given twice",
    "all intersections share one plan",
    "remove one",
    page=Page(
        "two plans of the lights",
        "All intersections share one plan.",
        "signals()\nsignals(green=5 s)\nego = new Car on road, with behavior FollowLaneBehavior(obey_signals=True)\n",
        "signals(green=5 s)\nego = new Car on road, with behavior FollowLaneBehavior(obey_signals=True)\n",
    ),
)
SCENIC_SIGNALS = note(
    "SCN447",
    "the map's traffic lights are answered by a fixed plan: green 10 s, yellow 3 s, all red 2 s",
    cure="add a line like `signals(green=10 s, offset=5 s)` to choose its times",
    page=Page(
        "lights of Scenic's maps",
        "CARLA's maps have traffic lights. A script that names such a map and asks for lights gets a fixed plan here.",
        "param map = localPath('Town05.xodr')\n"
        "ego = new Car on road, with behavior FollowLaneBehavior(obey_signals=True)\n",
        "signals()\nego = new Car on road, with behavior FollowLaneBehavior(obey_signals=True)\n",
    ),
)
LANE_OF_THE_RUN = Problem(
    "SCN630",
    "a lane that only the run knows has no `{name}`",
    "where an object is, is a matter of the moment; the compiler cannot list what hangs on it",
    "{suggestion}",
    page=Page(
        "attribute of a lane of the run",
        "`self.lane` is where the object is now. Its neighbours, its length and its section can be asked for; lists "
        "such as its maneuvers only of lanes that the compiler knows.",
        "behavior Turn():\n    do FollowTrajectoryBehavior(10, self.lane.maneuvers[0])\n"
        "ego = new Car on road, with behavior Turn()\n",
        "lane = network.lanes[0]\nbehavior Turn():\n    do FollowTrajectoryBehavior(10, lane.maneuvers[0])\n"
        "ego = new Car in lane.centerline, with behavior Turn()\n",
    ),
)
NOT_A_DRIVER = Problem(
    "SCN631",
    "`{behaviour}` is for vehicles, and this is {actual}",
    cure="give it to a Car or another vehicle",
    page=Page(
        "behavior for vehicles",
        "Some behaviors steer wheels; people and obstacles have none.",
        "ego = new Car on road\nnew Pedestrian on road, with behavior LaneChangeBehavior(network.lanes[0])\n",
        "ego = new Car on road, with behavior LaneChangeBehavior(network.lanes[0])\n",
    ),
)
NO_INTERSECTION = Problem(
    "SCN632",
    "this trajectory crosses no intersection",
    "there is nobody to give way to on it",
    "as in `[maneuver.startLane, maneuver.connectingLane, maneuver.endLane]`",
    page=Page(
        "trajectory without an intersection",
        "Gap acceptance waits at the entry of an intersection, so the trajectory must lead through one.",
        "lane = network.lanes[0]\nego = new Car in lane.centerline, with behavior GapAcceptanceBehavior(10, [lane])\n",
        "m = network.maneuvers[0]\n"
        "ego = new Car in m.startLane.centerline, with behavior GapAcceptanceBehavior(10, m)\n",
    ),
)
WALKS_IN_LANE = warning(
    "SCN633",
    "this Pedestrian walks in the middle of the lane, as a car drives",
    "`{behaviour}` follows lanes",
    "to cross the road write `CrossingBehavior(ego)`, to walk straight on `WalkForwardBehavior()`, and turn the walker "
    "with `facing`",
    page=Page(
        "pedestrian who follows a lane",
        "Lanes and trajectories are ways of vehicles. A pedestrian may be sent along them, but is seldom meant to be.",
        "ego = new Car on road\nnew Pedestrian on road, with behavior FollowLaneBehavior(1 m/s)\n",
        "ego = new Car on road\nnew Pedestrian on road, with behavior CrossingBehavior(ego)\n",
    ),
)

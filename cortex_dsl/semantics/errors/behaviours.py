"""SCN6xx: behaviors."""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.errors.problems import Problem, warning

RECURSIVE = Problem(
    "SCN601",
    "the behavior `{name}` runs itself: {cycle}",
    cure="use `while True:` to repeat",
    page=Page(
        "behavior that runs itself",
        "A behavior is expanded when the file is compiled; one that runs itself would never end.",
        "behavior Drive():\n"
        "    do FollowLaneBehavior() for 1 s\n"
        "    do Drive()\n"
        "\n"
        "ego = new Car on road, with behavior Drive()\n",
        "behavior Drive():\n"
        "    while True:\n"
        "        do FollowLaneBehavior() for 1 s\n"
        "\n"
        "ego = new Car on road, with behavior Drive()\n",
    ),
)
NEVER_ACTS = Problem(
    "SCN602",
    "this {what} never acts",
    "it would loop forever within one step",
    "add {words} to it",
    page=Page(
        "loop that never acts",
        "Time advances only when a behavior acts or waits. A loop or handler that does neither would run forever "
        "within one step.",
        "behavior Count():\n"
        "    n = 0\n"
        "    while True:\n"
        "        n = n + 1\n"
        "\n"
        "ego = new Car on road, with behavior Count()\n",
        "behavior Count():\n"
        "    n = 0\n"
        "    while n < 9:\n"
        "        n = n + 1\n"
        "        wait\n"
        "\n"
        "ego = new Car on road, with behavior Count()\n",
    ),
)
IDLE_BEHAVIOUR = warning(
    "SCN603",
    "the behavior `{name}` never acts",
    "the object just coasts",
    "add `take` or `do`",
    page=Page(
        "behavior that does nothing",
        "An object whose behavior neither acts nor waits coasts, like one without a behavior.",
        "behavior Rest():\n    pass\n\nego = new Car on road, with behavior Rest()\n",
        "behavior Rest():\n    take SetBrakeAction(1)\n\nego = new Car on road, with behavior Rest()\n",
    ),
)
NOT_A_BEHAVIOUR = Problem(
    "SCN604",
    "`do` needs a behavior, but this is {actual}",
    cure="{cure}",
    page=Page(
        "`do` without a behavior",
        "`do` hands the object over to a behavior; an action is taken with `take`.",
        "behavior Stop():\n    do SetBrakeAction(1)\n\nego = new Car on road, with behavior Stop()\n",
        "behavior Stop():\n    take SetBrakeAction(1)\n\nego = new Car on road, with behavior Stop()\n",
    ),
)
LEAVES_WRITTEN_OUT = Problem(
    "SCN615",
    "`break` and `continue` need a loop over numbers",
    "a loop over anything else is unrolled when the file is compiled",
    "loop over numbers, as in `for i in range(3)`, or write `while`",
    page=Page(
        "`break` in a loop over objects",
        "In a behavior, a loop over lanes or objects is unrolled when the file is compiled; `break` and `continue` "
        "need a loop over numbers, which the run iterates.",
        "ego = new Car on road, with behavior B()\nbehavior B():\n    for lane in network.lanes:\n        wait\n"
        "        if self.speed > 3 m/s:\n            break\n",
        "ego = new Car on road, with behavior B()\nbehavior B():\n    for i in range(8):\n        wait\n"
        "        if self.speed > 3 m/s:\n            break\n",
    ),
)
NOT_AN_ACTION = Problem(
    "SCN605",
    "`take` needs an action, but this is {actual}",
    cure="{suggestion}",
    page=Page(
        "`take` without an action",
        "`take` sets pedals, steering or speed for one step; a behavior is run with `do`.",
        "behavior Stop():\n    take BrakeBehavior()\n\nego = new Car on road, with behavior Stop()\n",
        "behavior Stop():\n    do BrakeBehavior()\n\nego = new Car on road, with behavior Stop()\n",
    ),
)
SAME_ACTION = Problem(
    "SCN606",
    "`take` sets the {command} twice",
    cure="keep one of the two",
    page=Page(
        "the same action twice",
        "All actions of one `take` apply in the same step, so each may appear only once.",
        "behavior Stop():\n"
        "    take SetBrakeAction(1), SetBrakeAction(0.5)\n"
        "\n"
        "ego = new Car on road, with behavior Stop()\n",
        "behavior Stop():\n"
        "    take SetBrakeAction(1), SetThrottleAction(0)\n"
        "\n"
        "ego = new Car on road, with behavior Stop()\n",
    ),
)
OBJECT_CHANGES = Problem(
    "SCN607",
    "`{name}` cannot become another {kind} during the run",
    "only numbers and truth values can change while a behavior runs",
    "use two variables",
    page=Page(
        "object that changes during the run",
        "Lanes and objects are fixed with the scene. Only numbers and truth values can change while a behavior runs.",
        "behavior Drive():\n"
        "    lane = network.lanes[0]\n"
        "    while True:\n"
        "        lane = network.lanes[1]\n"
        "        do FollowLaneBehavior(laneToFollow=lane) for 1 s\n"
        "\n"
        "ego = new Car on road, with behavior Drive()\n",
        "behavior Drive():\n"
        "    while True:\n"
        "        other = network.lanes[1]\n"
        "        do FollowLaneBehavior(laneToFollow=other) for 1 s\n"
        "\n"
        "ego = new Car on road, with behavior Drive()\n",
    ),
)
CANNOT_SET = Problem(
    "SCN617",
    "`{name}` cannot be set",
    "{reason}",
    "properties of your own, as in `with laps 0`, can be set while a behavior runs",
    page=Page(
        "property that cannot be set",
        "A behavior can set properties that the file itself has given to an object. What the simulation computes "
        "follows from what the object does, and all other properties are fixed with the scene.",
        "behavior Jump():\n    self.position = (3, 4)\n    wait\n\nego = new Car on road, with behavior Jump()\n",
        "behavior Count():\n    while True:\n        self.steps += 1\n        wait\n\n"
        "ego = new Car on road, with steps 0, with behavior Count()\n",
    ),
)
DIMENSION_CHANGES = Problem(
    "SCN608",
    "`{name}` was {before} and cannot become {after}",
    cure="use another name",
    page=Page(
        "variable that changes its dimension",
        "A variable keeps one dimension throughout, so that every use of it can be checked.",
        "behavior Drive():\n"
        "    x = 1 m\n"
        "    wait\n"
        "    x = self.speed\n"
        "    wait\n"
        "\n"
        "ego = new Car on road, with behavior Drive()\n",
        "behavior Drive():\n"
        "    x = 1 m\n"
        "    wait\n"
        "    v = self.speed\n"
        "    wait\n"
        "\n"
        "ego = new Car on road, with behavior Drive()\n",
    ),
)
ONLY_WHILE_RUNNING = Problem(
    "SCN609",
    "{what} is only known during the run",
    cure="use it in a behavior",
    page=Page(
        "only known during the run",
        "`require` is tested before anything moves; pedals and sight exist only during the run.",
        "ego = new Car on road\nrequire withinDistanceToAnyObjs(ego, 3 m)\n",
        "ego = new Car on road\nterminate when withinDistanceToAnyObjs(ego, 3 m)\n",
    ),
)
OBSTACLE_BEHAVIOUR = Problem(
    "SCN610",
    "an Obstacle cannot have a behavior",
    cure="use a Car or a Pedestrian",
    page=Page(
        "obstacle with a behavior",
        "An Obstacle never moves by itself.",
        "ego = new Car on road\nbox = new Obstacle ahead of ego by 5 m, with behavior IdleBehavior()\n",
        "ego = new Car on road\nbox = new Obstacle ahead of ego by 5 m\n",
    ),
)
CALLED_BEHAVIOUR = Problem(
    "SCN611",
    "a behavior does nothing when it is only called",
    cure="write `do {name}(...)`",
    page=Page(
        "behavior that is only called",
        "A behavior runs when an object has it or a `do` names it; a call alone does nothing.",
        "behavior Stop():\n    BrakeBehavior()\n\nego = new Car on road, with behavior Stop()\n",
        "behavior Stop():\n    do BrakeBehavior()\n\nego = new Car on road, with behavior Stop()\n",
    ),
)
MAY_NOT_ACT = warning(
    "SCN612",
    "this loop may repeat without acting",
    "if none of its branches acts, time stands still, nothing can change, and the run fails",
    "add a `wait` in an `else:`, or at the end of the loop",
    page=Page(
        "loop that may not act",
        "Time advances only when a behavior acts or waits. This loop has a path that does neither and changes "
        "nothing, so once that path is taken the loop runs forever within one step.",
        "behavior Creep():\n    while True:\n"
        "        if self.speed < 2 m/s:\n            take SetThrottleAction(0.3)\n\n"
        "ego = new Car on road, with behavior Creep()\n",
        "behavior Creep():\n    while True:\n"
        "        if self.speed < 2 m/s:\n            take SetThrottleAction(0.3)\n"
        "        else:\n            wait\n\n"
        "ego = new Car on road, with behavior Creep()\n",
    ),
)
TOO_MANY_BODIES = Problem(
    "SCN613",
    "behaviors and scenarios are expanded more than {limit} times",
    "each `do` is replaced by what it runs, and here they multiply",
    "let each run fewer of the others: a `while` repeats one without expanding it again",
    page=Page(
        "behaviors that multiply",
        "Each `do` is replaced by what it runs when the file is compiled. Twelve behaviors that each run the next one "
        "twice are expanded 4,096 times.",
        "behavior B0():\n    wait\n"
        + "".join(map("behavior B{0}():\n    do B{1}()\n    do B{1}()\n".format, range(1, 12), range(11)))
        + "\nego = new Car on road, with behavior B11()\n",
        "behavior B0():\n    wait\n\nbehavior B1():\n    while True:\n        do B0()\n\n"
        "ego = new Car on road, with behavior B1()\n",
    ),
)
DEEP_BY_RUNNING = (
    ", counting those of the behaviors and scenarios that run it",
    "each `do` is replaced by what it runs",
    "let one behavior `do` several after one another, instead of each the next",
)
DEEP_BY_BRANCHES = (
    ": there are too many `elif`",
    "each `elif` is nested in the `else` of the one before it",
    "split the cases first, `if x < 30: … else: …`, and put the finer `if` inside each; or compute the result directly",
)
"""What is counted, the reason and the cure."""
TOO_DEEP_BODIES = Problem(
    "SCN614",
    "this block is nested more than {limit} blocks deep{counted}",
    "{reason}",
    "{cure}",
    page=Page(
        "blocks nested too deeply",
        "Each `do` is replaced by what it runs when the file is compiled, so a chain of behaviors that each run the "
        "next one becomes blocks within blocks, as if all of it were written in one place. A chain of `elif` is also "
        "one `if` inside the `else` of another.",
        "behavior B0():\n    wait\n"
        + "".join(map("behavior B{}():\n    do B{}()\n".format, range(1, 70), range(69)))
        + "\nego = new Car on road, with behavior B69()\n",
        "behavior B0():\n    wait\n\nbehavior B1():\n    do B0()\n\nego = new Car on road, with behavior B1()\n",
    ),
)


LANE_OF_THE_RUN = Problem(
    "SCN630",
    "a lane that is known only during the run has no `{name}`",
    "an object may change lanes during the run, so the compiler cannot list what depends on its lane",
    "{suggestion}",
    page=Page(
        "attribute of a lane that is known only during the run",
        "`self.lane` is the lane that the object is in now. Its neighbours, length and section can be used; lists "
        "such as its maneuvers exist only for lanes that the compiler knows.",
        "behavior Turn():\n    do FollowTrajectoryBehavior(10, self.lane.maneuvers[0])\n"
        "ego = new Car on road, with behavior Turn()\n",
        "lane = network.lanes[0]\nbehavior Turn():\n    do FollowTrajectoryBehavior(10, lane.maneuvers[0])\n"
        "ego = new Car in lane.centerline, with behavior Turn()\n",
    ),
)


NOT_A_DRIVER = Problem(
    "SCN631",
    "`{behaviour}` is for vehicles, but this is {actual}",
    cure="give it to a Car or another vehicle",
    page=Page(
        "behavior for vehicles",
        "Some behaviors steer wheels, and `SetReverseAction` engages a gear; people and obstacles have neither.",
        "ego = new Car on road\nnew Pedestrian on road, with behavior LaneChangeBehavior(network.lanes[0])\n",
        "ego = new Car on road, with behavior LaneChangeBehavior(network.lanes[0])\n",
    ),
)

NO_INTERSECTION = Problem(
    "SCN632",
    "this trajectory crosses no intersection",
    "no other traffic crosses or joins it",
    "lead it through one, as in `[maneuver.startLane, maneuver.connectingLane, maneuver.endLane]`",
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
    "this Pedestrian walks in the middle of the lane, like a car",
    "`{behaviour}` follows lanes",
    "to cross the road write `CrossingBehavior(ego)`, to walk straight on `WalkForwardBehavior()`, and turn the walker "
    "with `facing`",
    page=Page(
        "pedestrian who follows a lane",
        "Lanes and trajectories are for vehicles. A pedestrian may follow them, but that is seldom intended.",
        "ego = new Car on road\nnew Pedestrian on road, with behavior FollowLaneBehavior(1 m/s)\n",
        "ego = new Car on road\nnew Pedestrian on road, with behavior CrossingBehavior(ego)\n",
    ),
)

CONTROLLED_TWICE = Problem(
    "SCN634",
    "the controller `{name}` already drives something else",
    "a controller drives one object, in one way",
    'name another one, as in `ExternalBehavior(controller="other")`',
    page=Page(
        "one controller for two objects",
        "A controller drives one object, always with the same actions and at the same interval. Where it is named in "
        "several places of a behavior, its arguments must be the same in all of them.",
        'ego = new Car on road, with behavior ExternalBehavior(controller="mine")\n'
        'new Car on road, with behavior ExternalBehavior(controller="mine")\n',
        'ego = new Car on road, with behavior ExternalBehavior(controller="mine")\n'
        'new Car on road, with behavior ExternalBehavior(controller="theirs")\n',
    ),
)

"""SCN62x: monitors, guards, and choices among behaviors."""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.errors.problems import Problem, warning

_CAR = "ego = new Car on road, with speed 5 m/s, with behavior FollowLaneBehavior()\n"
_SLOW = "monitor Slow():\n    while True:\n        require ego.speed < 9 m/s\n        wait\n\n"

NOT_A_MONITOR = Problem(
    "SCN620",
    "`require monitor` needs a monitor, but this is {actual}",
    cure="{cure}",
    page=Page(
        "not a monitor",
        "`require monitor` starts something that `monitor` defined. A behavior belongs to an object.",
        f"behavior Slow():\n    wait\n\n{_CAR}require monitor Slow()\n",
        f"{_SLOW}{_CAR}require monitor Slow()\n",
    ),
)
MONITOR_ACTS = Problem(
    "SCN621",
    "a monitor cannot `{statement}`",
    "it watches the run and drives no object",
    "what an object does belongs in a behavior; a monitor has `require`, `wait`, `terminate` and variables",
    page=Page(
        "monitor that acts",
        "A monitor runs beside the scenario and belongs to no object, so there is nothing that could act.",
        f"monitor Slow():\n    take SetBrakeAction(1)\n\n{_CAR}require monitor Slow()\n",
        f"{_SLOW}{_CAR}require monitor Slow()\n",
    ),
)
MONITOR_USED = Problem(
    "SCN622",
    "the monitor `{name}` is used like a behavior",
    "it runs beside the scenario and drives no object",
    "write `require monitor {name}(...)` at the top level",
    page=Page(
        "monitor used like a behavior",
        "A monitor is started by `require monitor`, not by `do` or `with behavior`.",
        f"{_SLOW}ego = new Car on road, with behavior Slow()\n",
        f"{_SLOW}{_CAR}require monitor Slow()\n",
    ),
)
UNUSED_MONITOR = warning(
    "SCN623",
    "the monitor `{name}` is never required",
    cure="write `require monitor {name}(...)`, or remove it",
    page=Page(
        "unused monitor",
        "A monitor watches only where `require monitor` starts it.",
        f"{_SLOW}{_CAR}",
        f"{_SLOW}{_CAR}require monitor Slow()\n",
    ),
)
LOOKS_ONCE = warning(
    "SCN624",
    "the monitor `{name}` never waits",
    "it looks at the first sample and is over",
    "put its body into `while True:`, and `wait` at the end of that",
    page=Page(
        "monitor that looks once",
        "A monitor runs until its body ends. To look at every sample it must go round a loop, with a `wait` in it.",
        f"monitor Slow():\n    require ego.speed < 9 m/s\n\n{_CAR}require monitor Slow()\n",
        f"{_SLOW}{_CAR}require monitor Slow()\n",
    ),
)
DO_SEVERAL = Problem(
    "SCN625",
    "`do` runs one behavior at a time",
    "an object does one thing at once",
    "write one `do` after the other, `do choose` for one of them, or `do shuffle` for all in random order",
    page=Page(
        "`do` with several behaviors",
        "Only the scenarios of a `compose` can run side by side.",
        "behavior B():\n    do IdleBehavior(), BrakeBehavior()\n\nego = new Car on road, with behavior B()\n",
        "behavior B():\n    do choose IdleBehavior(), BrakeBehavior()\n\nego = new Car on road, with behavior B()\n",
    ),
)
ONE_OPTION = warning(
    "SCN626",
    "`do {mode}` has one option only",
    "nothing is left to chance",
    "write `do` alone, or add options",
    page=Page(
        "one option",
        "A choice among one thing is that thing.",
        "behavior B():\n    do choose BrakeBehavior()\n\nego = new Car on road, with behavior B()\n",
        "behavior B():\n    do BrakeBehavior()\n\nego = new Car on road, with behavior B()\n",
    ),
)
NO_WEIGHT = Problem(
    "SCN627",
    "{what}",
    "then no option can be taken",
    "as in `do {mode} {{A(): 1, B(): 2}}`",
    page=Page(
        "options without weight",
        "An option is as likely as its weight says: its weight over the sum of all that are allowed.",
        "behavior B():\n    do choose {IdleBehavior(): 0, BrakeBehavior(): 0}\n\n"
        "ego = new Car on road, with behavior B()\n",
        "behavior B():\n    do choose {IdleBehavior(): 1, BrakeBehavior(): 3}\n\n"
        "ego = new Car on road, with behavior B()\n",
    ),
)
GUARD_NEVER = warning(
    "SCN628",
    "this {guard} can never hold",
    "every run that starts `{name}` here is aborted",
    "change the {guard}, or what the behavior is given",
    page=Page(
        "guard that never holds",
        "A guard that is false when its behavior starts aborts the run. This one is false whatever happens.",
        "behavior B(gap):\n    precondition: gap > 5 m\n    do IdleBehavior()\n\n"
        "ego = new Car on road, with behavior B(3 m)\n",
        "behavior B(gap):\n    precondition: gap > 5 m\n    do IdleBehavior()\n\n"
        "ego = new Car on road, with behavior B(9 m)\n",
    ),
)

"""SCN241 to SCN243, SCN65x: scenarios made of scenarios. SCN62x: monitors, guards, and choices among behaviors."""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.errors.problems import Problem, warning

_EGO = "ego = new Car on road, with speed 5 m/s\n"
UNKNOWN_SCENARIO = Problem(
    "SCN241",
    "this file has no scenario `{name}`",
    cure="{suggestion}",
    page=Page(
        "unknown scenario",
        "`--scenario NAME` picks one of the scenarios that the file defines.",
        shown="when `--scenario` names no scenario of the file",
    ),
)
WHICH_SCENARIO = Problem(
    "SCN242",
    "which of these scenarios should run: {names}?",
    "none is called `Main`",
    "name one with `--scenario NAME`, or call one `Main`",
    page=Page(
        "no scenario to run",
        "A file runs its scenario `Main`, or the only one that needs no arguments and that no other starts.",
        f"{_EGO}scenario A():\n    setup:\n        D = 3 m\n\nscenario B():\n    setup:\n        D = 4 m\n",
        f"{_EGO}scenario A():\n    setup:\n        D = 3 m\n\nscenario Main():\n    compose:\n        do A() for 1 s\n",
    ),
)
NEEDS_ARGUMENTS = Problem(
    "SCN243",
    "the scenario `{name}` cannot run by itself",
    "its parameter `{parameter}` has no default",
    "give it a default, or start the scenario from another one",
    page=Page(
        "scenario that needs arguments",
        "The scenario that is run is started without arguments.",
        f"{_EGO}scenario Main(gap):\n    setup:\n        box = new Obstacle ahead of ego by gap\n",
        f"{_EGO}scenario Main(gap=9 m):\n    setup:\n        box = new Obstacle ahead of ego by gap\n",
    ),
)
_CUT = "scenario Cut(gap):\n    setup:\n        box = new Obstacle ahead of ego by gap\n\n"
_PARK = "scenario Park():\n    setup:\n        box = new Obstacle on road\n\n"
_MAIN = "scenario Main():\n    setup:\n        ego = new Car on road, with speed 5 m/s\n    compose:\n"
NOT_A_SCENARIO = Problem(
    "SCN650",
    "`do` in a `compose` needs a scenario, but this is {actual}",
    cure="{cure}",
    page=Page(
        "`do` without a scenario",
        "A `compose` block runs scenarios. Behaviors belong to objects.",
        f"{_CUT}{_MAIN}        do FollowLaneBehavior()\n",
        f"{_CUT}{_MAIN}        do Cut(9 m)\n",
    ),
)
NOT_STARTED = Problem(
    "SCN651",
    "the scenario `{name}` has not been started yet",
    "its variables exist once its setup has run",
    "use them below the `do` that starts it",
    page=Page(
        "variable of a scenario that was not started",
        "`do s` runs the setup of the scenario `s`; from then on `s.box` is the object that it calls `box`.",
        f"{_CUT}{_MAIN}        s = Cut(9 m)\n        if s.box.x > 3 m:\n            do s\n",
        f"{_CUT}{_MAIN}        s = Cut(9 m)\n        do s until s.box.x > 3 m\n",
    ),
)
STARTED_TWICE = Problem(
    "SCN652",
    "this scenario is started twice",
    "its objects were made the first time",
    "call it again, as in `do {name}(...)`, for objects of its own",
    page=Page(
        "scenario started twice",
        "`s = Park()` makes one set of objects, which takes part once. Each `do Park()` makes new ones.",
        f"{_PARK}{_MAIN}        s = Park()\n        do s for 1 s\n        do s for 1 s\n",
        f"{_PARK}{_MAIN}        do Park() for 1 s\n        do Park() for 1 s\n",
    ),
)
MADE_AGAIN = Problem(
    "SCN653",
    "the scenario `{name}` makes objects, but may be started more than once here",
    "all objects of a run are known before it begins",
    "start it outside the loop, or make its objects in the scenario that starts it and pass them as arguments",
    page=Page(
        "objects made again and again",
        "The objects of a run are fixed with the scene. A scenario in a loop or a handler may start any number of "
        "times and would need new ones each time.",
        f"{_PARK}{_MAIN}        while True:\n            do Park() for 1 s\n",
        f"{_PARK}{_MAIN}        do Park() for 1 s\n        do Park() for 1 s\n",
    ),
)
LATER_PLACE = Problem(
    "SCN654",
    "where `{name}` will be when this scenario starts is not known",
    "objects are placed before the run, and this scenario may start later",
    "place the object by the road, or start the scenario first in `compose`",
    page=Page(
        "place relative to an object that moves",
        "A scenario that starts with the run can place its objects relative to others. One that starts later cannot: "
        "the others have moved by then.",
        f"{_CUT}{_MAIN}        wait\n        do Cut(9 m)\n",
        f"{_CUT}{_MAIN}        do Cut(9 m)\n",
    ),
)
SCENARIO_CYCLE = Problem(
    "SCN655",
    "the scenario `{name}` starts itself: {cycle}",
    cure="use `while True:` to repeat",
    page=Page(
        "scenario that starts itself",
        "A scenario is expanded when the file is compiled; one that starts itself would never end.",
        f"{_MAIN}        do Main()\n",
        f"{_CUT}{_MAIN}        do Cut(9 m)\n",
    ),
)
CANNOT_OVERRIDE = Problem(
    "SCN656",
    "`{name}` cannot be overridden {here}",
    "{reason}",
    "{cure}",
    page=Page(
        "property that cannot be overridden",
        "A scenario may replace the behavior of an object while it runs. The other properties are fixed with the "
        "scene: only a scenario that runs from the first sample to the last can override them, and none can override "
        "a place or a speed.",
        f"{_MAIN}        do Slow(ego)\n\nscenario Slow(car):\n    setup:\n        override car with width 1 m\n",
        f"{_MAIN}        do Slow(ego)\n\n"
        "scenario Slow(car):\n    setup:\n        override car with behavior BrakeBehavior()\n",
    ),
)
LATER_TEMPORAL = Problem(
    "SCN657",
    "`{statement}` cannot be used in a scenario that another one starts",
    "{reason}",
    "{cure}",
    page=Page(
        "requirement over time in a scenario that starts later",
        "Only `require always` and monitors can watch a part of a run. What must happen eventually is judged over the "
        "whole run, at the top level or in the scenario that is run.",
        f"{_CUT}scenario Watch():\n    setup:\n        require eventually ego.speed < 1 m/s\n\n"
        f"{_MAIN}        do Watch()\n",
        f"{_CUT}scenario Watch():\n    setup:\n        require always ego.speed < 99 m/s\n\n"
        f"{_MAIN}        do Watch()\n",
    ),
)
SCENARIO_USED = Problem(
    "SCN658",
    "the scenario `{name}` is used like a behavior",
    "it sets up objects and runs beside them",
    "write `do {name}(...)` in the `compose` of another scenario",
    page=Page(
        "scenario used like a behavior",
        "Scenarios are started in `compose` blocks; objects have behaviors.",
        f"{_CUT}{_MAIN}        do Cut(9 m)\n\n"
        "behavior Drive():\n    do Cut(5 m)\n\nscenario Other():\n    setup:\n"
        "        car = new Car on road, with behavior Drive()\n",
        f"{_CUT}{_MAIN}        do Cut(9 m)\n",
        shown="when a behavior starts a scenario",
    ),
)
SETTLED_ARGUMENT = Problem(
    "SCN660",
    "the argument `{name}` of a scenario cannot depend on the run",
    "objects are set up before the run begins",
    "use a value that is fixed with the scene: a number, a param, a draw, an object",
    page=Page(
        "scenario argument that changes during the run",
        "The setup of a scenario is evaluated with the scene, and so are its arguments.",
        f"{_CUT}{_MAIN}        gap = ego.speed * 2 s\n        do Cut(gap)\n",
        f"{_CUT}{_MAIN}        do Cut(Range(5, 9) m)\n",
    ),
)
SETTING_IN_SCENARIO = Problem(
    "SCN659",
    "`{statement}` cannot be used in a scenario",
    "{reason}",
    "move it to the top level",
    page=Page(
        "top-level statement in a scenario",
        "The road, the params and the settings of the run belong to the whole file.",
        "scenario Main():\n    setup:\n        map intersection()\n        ego = new Car on road\n",
        "map intersection()\n\nscenario Main():\n    setup:\n        ego = new Car on road\n",
    ),
)

# -- SCN62x: monitors, guards, and choices among behaviors -------------------------------------------------------------

_CAR = "ego = new Car on road, with speed 5 m/s, with behavior FollowLaneBehavior()\n"
_SLOW = "monitor Slow():\n    while True:\n        require ego.speed < 9 m/s\n        wait\n\n"

NOT_A_MONITOR = Problem(
    "SCN620",
    "`require monitor` needs a monitor, but this is {actual}",
    cure="{cure}",
    page=Page(
        "not a monitor",
        "`require monitor` starts a monitor, which `monitor` defines. A behavior belongs to an object.",
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
    "it checks the first sample and then ends",
    "put its body in `while True:`, with a `wait` at the end",
    page=Page(
        "monitor that checks once",
        "A monitor runs until its body ends. To check every sample it needs a loop with a `wait` in it.",
        f"monitor Slow():\n    require ego.speed < 9 m/s\n\n{_CAR}require monitor Slow()\n",
        f"{_SLOW}{_CAR}require monitor Slow()\n",
    ),
)
DO_SEVERAL = Problem(
    "SCN625",
    "`do` runs one behavior at a time",
    "an object does one thing at a time",
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
    "`do {mode}` has only one option",
    "nothing is left to chance",
    "write `do` alone, or add options",
    page=Page(
        "one option",
        "A choice with one option always takes that option.",
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
        "The probability of an option is its weight divided by the sum of the weights of all options that are allowed.",
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
    "change the {guard}, or the arguments of the behavior",
    page=Page(
        "guard that never holds",
        "A guard that is false when its behavior starts aborts the run. This one is false whatever happens.",
        "behavior B(gap):\n    precondition: gap > 5 m\n    do IdleBehavior()\n\n"
        "ego = new Car on road, with behavior B(3 m)\n",
        "behavior B(gap):\n    precondition: gap > 5 m\n    do IdleBehavior()\n\n"
        "ego = new Car on road, with behavior B(9 m)\n",
    ),
)

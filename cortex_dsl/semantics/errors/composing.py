"""SCN241 to SCN243, SCN65x: scenarios made of scenarios."""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.errors.problems import Problem

_EGO = "ego = new Car on road, with speed 5 m/s\n"
UNKNOWN_SCENARIO = Problem(
    "SCN241",
    "this file has no scenario `{name}`",
    cure="{suggestion}",
    page=Page(
        "unknown scenario",
        "`--scenario NAME` picks one of the scenarios that the file defines.",
        shown="when `--scenario` names none",
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
    "give it one, or start it from another scenario",
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
        "The objects of a run are settled with the scene. A scenario in a loop or a handler may start any number of "
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
        "What a scenario starts is written out when the file is compiled, which would never end.",
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
        "A scenario may replace the behavior of an object for as long as it runs. The other properties are settled "
        "with the scene: only what runs from the first sample to the last can set them, and nothing can set a place "
        "or a speed.",
        f"{_MAIN}        do Slow(ego)\n\nscenario Slow(car):\n    setup:\n        override car with width 1 m\n",
        f"{_MAIN}        do Slow(ego)\n\n"
        "scenario Slow(car):\n    setup:\n        override car with behavior BrakeBehavior()\n",
    ),
)
LATER_TEMPORAL = Problem(
    "SCN657",
    "`{statement}` cannot stand in a scenario that another one starts",
    "{reason}",
    "{cure}",
    page=Page(
        "requirement over time in a scenario that starts later",
        "Only `require always` and monitors can watch a part of a run. What must happen eventually is judged over the "
        "whole run, at the top level or in the scenario that the run is.",
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
    "use what is known with the scene: a number, a param, a draw, an object",
    page=Page(
        "scenario argument that changes during the run",
        "The setup of a scenario is worked out with the scene, its arguments with it.",
        f"{_CUT}{_MAIN}        gap = ego.speed * 2 s\n        do Cut(gap)\n",
        f"{_CUT}{_MAIN}        do Cut(Range(5, 9) m)\n",
    ),
)
SETTING_IN_SCENARIO = Problem(
    "SCN659",
    "`{statement}` cannot stand in a scenario",
    "{reason}",
    "move it to the top level",
    page=Page(
        "top-level statement in a scenario",
        "The road, the params and the settings of the run are those of the whole file.",
        "scenario Main():\n    setup:\n        map intersection()\n        ego = new Car on road\n",
        "map intersection()\n\nscenario Main():\n    setup:\n        ego = new Car on road\n",
    ),
)

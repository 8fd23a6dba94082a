"""SCN55x: words of Scenic that the compiler works out: fields at places, overrides of a file's own properties."""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.errors.problems import Problem

NO_FIELD_AT = Problem(
    "SCN550",
    "what stands before `at` must be a field of directions, but this is {actual}",
    "`(FIELD at PLACE)` is the heading that a field has there",
    "write `roadDirection`, or a `VectorField`, before `at`",
    page=Page(
        "`at` after what is no field",
        "`(roadDirection at p)` is the heading of the road at p. Only fields of directions have one at every place.",
        "ego = new Car on road\nh = (ego at (1.75, -30))\nrequire h > 0 deg\n",
        "ego = new Car on road\nh = (roadDirection at (1.75, -30))\nrequire h > 0 deg\n",
    ),
)
OVERRIDDEN_AND_SET = Problem(
    "SCN551",
    "`{name}` is overridden here and set by a behavior or a monitor",
    "what it is when the scenario ends would be what both say",
    "use two properties, or let the behavior set it alone",
    page=Page(
        "property that is both overridden and set",
        "A scenario overrides a property for as long as it runs; afterwards it is what it was. A behavior sets one for "
        "good.",
        "behavior Count():\n    while True:\n        self.laps += 1\n        wait\n\n"
        "ego = new Car on road, with laps 0, with behavior Count()\n\n"
        "scenario Sub():\n    setup:\n        override ego with laps 9\n        terminate after 1 s\n\n"
        "scenario Main():\n    compose:\n        do Sub()\n",
        "behavior Count():\n    while True:\n        self.laps += 1\n        wait\n\n"
        "ego = new Car on road, with laps 0, with more 0, with behavior Count()\n\n"
        "scenario Sub():\n    setup:\n        override ego with more 9\n        terminate after 1 s\n\n"
        "scenario Main():\n    compose:\n        do Sub()\n"
        "record ego.laps + ego.more as laps\n",
    ),
)

"""SCN69x: what only shows while a scene is drawn or runs."""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.errors.problems import Problem

STUCK = Problem(
    "SCN690",
    "this behavior never acts",
    "a behavior's turn ends with an action; until then the simulated time stands still",
    "`take` an action or `wait` in every loop",
    page=Page(
        "behavior that got stuck",
        "A loop went round and round within one step. Where that is certain the compiler says SCN602; here it depended "
        "on the run.",
        "behavior Count():\n    n = 0\n    while True:\n        n = n + 1\n        if n < 0:\n            wait\n\n"
        "ego = new Car on road, with behavior Count()\n",
        "behavior Count():\n    n = 0\n    while True:\n        n = n + 1\n        wait\n\n"
        "ego = new Car on road, with behavior Count()\n",
        shown="while the scene runs",
    ),
)
UNDEFINED = Problem(
    "SCN691",
    "{what} is not a finite number in this scene",
    "{reason}",
    "narrow the ranges, or keep it legal with `max`, `min` or `... if ... else ...`",
    page=Page(
        "value that is not a number",
        "A root, quotient or logarithm has no finite value for some of the numbers that can be drawn, and one of them "
        "was drawn.",
        "x = Range(-9, -1)\nego = new Car at (sqrt(x), -30)\n",
        "x = Range(1, 9)\nego = new Car at (sqrt(x), -30)\n",
        shown="while the scene is drawn",
    ),
)

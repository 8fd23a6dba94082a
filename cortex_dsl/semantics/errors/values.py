"""SCN4xx: values, and the limits of what is worked out."""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.errors.problems import Problem, warning

NOT_FINITE = Problem(
    "SCN401",
    "this is not a finite number",
    "{reason}",
    "check the numbers in it",
    page=Page(
        "not a finite number",
        "Numbers are finite here: nothing is divided by zero, and roots and logarithms are taken of what has one.",
        "ego = new Car on road, with speed 1 / 0\n",
        "ego = new Car on road, with speed 1 / 2\n",
    ),
)
OUT_OF_RANGE = Problem(
    "SCN402",
    "{what} is {actual}, but must be {expected}",
    cure="{cure}",
    page=Page(
        "out of range",
        "Where only some numbers make sense, such as a width above 0, others are refused.",
        "ego = new Car on road, with width -2 m\n",
        "ego = new Car on road, with width 2 m\n",
    ),
)
MAY_LEAVE_RANGE = Problem(
    "SCN403",
    "{what} may become {actual}, but must be {expected}",
    "it is random or searched",
    "narrow its range",
    page=Page(
        "may leave its range",
        "Some value that can be drawn or searched would be refused here; so the range itself must be narrower.",
        "param W = Range(-1, 2) m\nego = new Car on road, with width W\n",
        "param W = Range(1, 2) m\nego = new Car on road, with width W\n",
    ),
)
BAD_INDEX = Problem(
    "SCN424",
    "there is no item {index}: the list has {count}",
    cure="{cure}",
    page=Page(
        "no such item",
        "Items count from 0; -1 is the last.",
        "lane = network.lanes[99]\nego = new Car in lane.centerline\n",
        "lane = network.lanes[0]\nego = new Car in lane.centerline\n",
    ),
)
BAD_UNPACKING = Problem(
    "SCN425",
    "{names} names on the left, but {count} values on the right",
    cure="write one name for each value",
    page=Page(
        "names and values do not match",
        "Several names on the left take a list of as many values.",
        "x, y = (1, 2, 3)\nego = new Car at (x, y)\n",
        "x, y = (1, 2)\nego = new Car at (x, y)\n",
    ),
)
BAD_SETTING = Problem(
    "SCN428",
    "`{name}` must be {expected}, but this is {actual}",
    "{reason}",
    'a search writes it, as in `stream="7.ga.0.3.12.0"`; leave it out to draw anew',
    page=Page(
        "wrong setting",
        "`simulation(...)` pins settings of the run; each takes a certain kind of value.",
        "ego = new Car on road\nsimulation(stream=5)\n",
        "ego = new Car on road\nsimulation(time_step=0.05 s)\n",
    ),
)
NO_SYSTEM_PARAM = Problem(
    "SCN483",
    "`system` lists params of this file, and `{actual}` is none",
    "they are the params of the system under test, which `--freeze` holds fixed",
    "{suggestion}",
    page=Page(
        "no param of the system",
        "`simulation(system=[...])` names the params that belong to the system under test.",
        "param BRAKE = Range(0, 1)\nego = new Car on road, with speed BRAKE * 9 m/s\nsimulation(system=[BRAKES])\n",
        "param BRAKE = Range(0, 1)\nego = new Car on road, with speed BRAKE * 9 m/s\nsimulation(system=[BRAKE])\n",
    ),
)
CANNOT_ASSIGN = Problem(
    "SCN430",
    "`{name}` cannot be assigned",
    "{reason}",
    "choose another name",
    page=Page(
        "name that cannot be assigned",
        "These names have a meaning that a file cannot change.",
        "none = 4\nego = new Car on road, with speed none\n",
        "speed = 4 m/s\nego = new Car on road, with speed speed\n",
    ),
)
TOO_DEEP = Problem(
    "SCN433",
    "this value is the result of more than {limit} operations in a row",
    "the program would become too large",
    "compute it in fewer steps",
    page=Page(
        "too many operations in a row",
        "Each is done on the result of the one before; later stages walk along this chain, so its length is limited.",
        "param P = Range(1, 2)\nx = sum([P * i for i in range(200)])\nego = new Car on road, with speed x / 9999\n",
        "param P = Range(1, 2)\nx = P * sum(range(200))\nego = new Car on road, with speed x / 9999\n",
    ),
)
TOO_MUCH_WORK = Problem(
    "SCN434",
    "this file takes too long to work out",
    "lists, lambdas and behaviors multiply to more than {limit} evaluations",
    "use shorter lists and ranges",
    page=Page(
        "too much to work out",
        "Lists, lambdas and behaviors are worked out when the file is compiled; the limit ends what would take for "
        "ever.",
        "big = range(5000)\nx = len([a for a in big for b in big])\nego = new Car on road, with speed x / 1e9\n",
        "big = range(50)\nx = len([a for a in big for b in big])\nego = new Car on road, with speed x / 1e9\n",
    ),
)
ENDLESS_LAMBDA = Problem(
    "SCN435",
    "this lambda calls itself without end",
    cure="use a list instead of recursion",
    page=Page(
        "lambda without end",
        "A lambda that calls itself is worked out at once, whatever its condition says about values that are drawn.",
        "f = lambda n: f(n + 1)\nego = new Car on road, with speed f(1)\n",
        "f = lambda n: n + 1\nego = new Car on road, with speed f(1)\n",
    ),
)
LIST_TOO_LONG = Problem(
    "SCN436",
    "this list has more than {limit} items",
    cure="use a shorter one",
    page=Page(
        "list too long",
        "Every item of a list is worked out when the file is compiled, so its length is limited.",
        "x = list(range(9000)) + list(range(9000))\nego = new Car on road, with speed len(x) / 1e4\n",
        "x = list(range(900)) + list(range(900))\nego = new Car on road, with speed len(x) / 1e4\n",
    ),
)
BARE_EXPRESSION = warning(
    "SCN440",
    "this value is not used",
    cure="{cure}",
    page=Page(
        "value that is not used",
        "A line that only works out a value changes nothing. Perhaps `require` is missing in front of it.",
        "ego = new Car on road\nego.speed < 3 m/s\n",
        "ego = new Car on road\nrequire ego.speed < 3 m/s\n",
    ),
)

"""SCN3xx: units and types. SCN4xx: values, and the limits of evaluation."""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.errors.problems import Problem, warning

DIMENSION_MISMATCH = Problem(
    "SCN301",
    "{what} must be {expected}, but this is {actual}",
    "a number with a unit has the dimension of the unit; a number without one takes the SI unit",
    "{cure}",
    page=Page(
        "wrong dimension",
        "Every argument and property has a dimension: a speed, a length, an angle. A number with a unit must have that "
        "dimension; a bare number takes its SI unit.",
        "ego = new Car on road, with speed 5 m\n",
        "ego = new Car on road, with speed 5 m/s\n",
    ),
)
UNLIKE_OPERANDS = Problem(
    "SCN302",
    "{left} and {right} cannot be {joined}",
    "both sides must have the same dimension",
    "{cure}",
    page=Page(
        "operands of different dimensions",
        "Values that are added or compared must have the same dimension; metres and seconds do not.",
        "ego = new Car on road\nrequire ego.speed < 3 m\n",
        "ego = new Car on road\nrequire ego.speed < 3 m/s\n",
    ),
)
WRONG_KIND = Problem(
    "SCN303",
    "{what} must be {expected}, but this is {actual}",
    cure="{cure}",
    page=Page(
        "wrong kind of value",
        "Lanes, objects, numbers, truth values and lists are different kinds of value; here another kind is needed.",
        "ego = new Car on road\nrequire distance from ego to intersection\n",
        "ego = new Car on road\nrequire (distance from ego to intersection) < 20 m\n",
    ),
)
NO_OPERATOR = Problem(
    "SCN304",
    "`{operator}` does not work on {left} and {right}",
    "arithmetic and comparisons of size need numbers",
    "{cure}",
    page=Page(
        "operator that does not fit",
        "Arithmetic works on numbers; other values, such as lanes, can only be compared with `==`, `is` and `in`.",
        "ego = new Car on road\nrequire ego + 1 == 2\n",
        "ego = new Car on road\nrequire ego.speed + 1 < 2\n",
    ),
)
UNKNOWN_UNIT = Problem(
    "SCN305",
    "there is no unit `{unit}`",
    cure="{suggestion}",
    page=Page(
        "unknown unit",
        "The units are mm, cm, m, km, ft; ms, s, min; m/s, km/h, mph; m/s^2, g; deg, rad; deg/s, rad/s; kg, t; Hz.",
        shown="when a program is made without its text; in a file the parser says SCN111",
    ),
)
TWO_UNITS = Problem(
    "SCN306",
    "this value has a unit twice",
    "the values inside are already {kind}",
    "write the unit in one place",
    page=Page(
        "unit given twice",
        "A unit is given once: after each bound, or after the whole distribution.",
        "x = Range(1 m, 2 m) km\nego = new Car at (x, 0 m)\n",
        "x = Range(1, 2) km\nego = new Car at (x, 0 m)\n",
    ),
)
NOT_CALLABLE = Problem(
    "SCN307",
    "{kind} cannot be called",
    cure="remove the brackets; an item of a list is taken with `[0]`",
    page=Page(
        "not a function",
        "Only functions, distributions, actions, behaviors and lambdas are called with `( )`.",
        "lane = network.lanes[0]\nego = new Car in lane(1).centerline\n",
        "lane = network.lanes[0]\nego = new Car in lane.centerline\n",
    ),
)
TOO_FEW_ARGUMENTS = Problem(
    "SCN308",
    "`{function}` needs {missing}",
    cure="as in `{signature}`",
    page=Page(
        "missing argument",
        "Arguments without a default value must be given.",
        "ego = new Car on road, with speed Range(5) m/s\n",
        "ego = new Car on road, with speed Range(5, 9) m/s\n",
    ),
)
TOO_MANY_ARGUMENTS = Problem(
    "SCN309",
    "`{function}` takes {count}, but got {given}",
    cure="as in `{signature}`",
    page=Page(
        "too many arguments",
        "More arguments are given than the function has parameters.",
        "ego = new Car on road, with speed Range(1, 5, 9) m/s\n",
        "ego = new Car on road, with speed Range(1, 9) m/s\n",
    ),
)
POWER_NOT_CONSTANT = Problem(
    "SCN310",
    "the exponent of {what} must be a known whole number",
    "otherwise the dimension of the result would be unknown",
    "write it as a number: `** 2`",
    page=Page(
        "power of unknown dimension",
        "A square metre is not a cubic metre: the exponent of a number with a unit decides its dimension, so it must "
        "be known.",
        "ego = new Car on road\nrequire ego.length ** Range(1, 2) > 16 m\n",
        "ego = new Car on road\nrequire ego.length ** 2 > 16 m * 1 m\n",
    ),
)
NEVER_EQUAL = warning(
    "SCN312",
    "{left} and {right} are never equal",
    "a text is equal only to another text",
    "{cure}",
    page=Page(
        "comparison that never holds",
        "Lanes, maneuvers, their types and numbers are not texts, and no text is equal to them.",
        "m = Uniform(*[m for m in network.maneuvers if m.type != 'LEFT_TURN'])\n"
        "ego = new Car in m.startLane.centerline\n",
        "m = Uniform(*[m for m in network.maneuvers if m.type != ManeuverType.LEFT_TURN])\n"
        "ego = new Car in m.startLane.centerline\n",
    ),
)
SUSPICIOUS_ANGLE = warning(
    "SCN320",
    "a bare {value:g} here is {value:g} rad, which is {turns:.1f} full turns",
    "angles without a unit are radians",
    "write `{value:g} deg` if degrees are meant",
    page=Page(
        "angle that looks like degrees",
        "Angles without a unit are radians, as in Scenic, and more than a full turn is rarely intended.",
        "ego = new Car at (0, -30), facing 90\n",
        "ego = new Car at (0, -30), facing 90 deg\n",
    ),
)
SUSPICIOUS_SPEED = warning(
    "SCN321",
    "a bare {value:g} here is {value:g} m/s, which is {kmh:.4g} km/h",
    "speeds without a unit are metres per second",
    "write `km/h` after the number if that is meant",
    page=Page(
        "speed that looks like km/h",
        "Speeds without a unit are metres per second, as in Scenic, and more than 40 m/s (144 km/h) is rarely "
        "intended.",
        "ego = new Car on road, with speed 50\n",
        "ego = new Car on road, with speed 50 km/h\n",
    ),
)
SUSPICIOUS_LENGTH = warning(
    "SCN322",
    "a bare {value:g} here is {value:g} m, which is {kilometres:.4g} km",
    "lengths without a unit are metres, and most roads here are shorter",
    "write `{value:g} cm`, `{value:g} ft` or `{value:g} m`",
    page=Page(
        "length that looks like centimetres",
        "Lengths without a unit are metres, as in Scenic, and more than 500 m leaves the map.",
        "ego = new Car on road\ncar = new Car ahead of ego by 800\n",
        "ego = new Car on road\ncar = new Car ahead of ego by 800 cm\n",
    ),
)
SUSPICIOUS_TIME = warning(
    "SCN323",
    "a bare {value:g} here is {value:g} s, which is {minutes:.4g} minutes",
    "times without a unit are seconds",
    "write `{value:g} ms` if milliseconds are meant",
    page=Page(
        "time that looks like milliseconds",
        "Times without a unit are seconds, as in Scenic, and a scene lasts well below ten minutes.",
        "behavior Drive():\n    do FollowLaneBehavior() for 2000\n\nego = new Car on road, with behavior Drive()\n",
        "behavior Drive():\n    do FollowLaneBehavior() for 2000 ms\n\nego = new Car on road, with behavior Drive()\n",
    ),
)
SUSPICIOUS_ACCELERATION = warning(
    "SCN324",
    "a bare {value:g} here is {value:g} m/s^2, which is {gravities:.3g} g",
    "accelerations without a unit are metres per second squared; tyres on a dry road give 10",
    "write a unit after the number: `m/s^2` or `g`",
    page=Page(
        "acceleration beyond tyres",
        "Accelerations without a unit are m/s^2, and no car reaches more than 20 m/s^2.",
        "ego = new Car in network.lanes[0].centerline,\n    with behavior FollowLaneBehavior(max_lateral=300)\n",
        "ego = new Car in network.lanes[0].centerline,\n    with behavior FollowLaneBehavior(max_lateral=0.3 g)\n",
    ),
)
BARE_BESIDE_UNIT = warning(
    "SCN325",
    "a bare {value:g} beside a number in {unit} is {value:g} {si}, which is {converted:.4g} {unit}",
    "a number without a unit is in SI units, whatever unit its neighbour is written in",
    "write `{value:g} {unit}`, or `{value:g} {si}` if that is meant",
    page=Page(
        "bare number beside another unit",
        "A number without a unit is in SI units: added to a param in km/h, or compared with it, it is in metres per "
        "second.",
        "param V = Range(20, 80) km/h\nego = new Car in network.lanes[0].centerline, with speed V\nrequire V > 10\n",
        "param V = Range(20, 80) km/h\nego = new Car in network.lanes[0].centerline, with speed V\n"
        "require V > 30 km/h\n",
    ),
)

# -- SCN4xx: values, and the limits of evaluation ----------------------------------------------------------------------

NOT_FINITE = Problem(
    "SCN401",
    "this is not a finite number",
    "{reason}",
    "check the numbers in it",
    page=Page(
        "not a finite number",
        "All numbers must be finite: nothing may be divided by zero, and a root or logarithm needs a number that has "
        "one.",
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
        "A value that can be drawn or searched would be refused here, so the range itself must be narrower.",
        "param W = Range(-1, 2) m\nego = new Car on road, with width W\n",
        "param W = Range(1, 2) m\nego = new Car on road, with width W\n",
    ),
)
BAD_INDEX = Problem(
    "SCN424",
    "there is no item {index}: the list has {count}",
    "{reason}",
    "{cure}",
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
        "Several names on the left need as many values on the right.",
        "x, y = (1, 2, 3)\nego = new Car at (x, y)\n",
        "x, y = (1, 2)\nego = new Car at (x, y)\n",
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
        "Each operation uses the result of the one before; later stages follow this chain, so its length is limited.",
        "param P = Range(1, 2)\nx = sum([P * i for i in range(200)])\nego = new Car on road, with speed x / 9999\n",
        "param P = Range(1, 2)\nx = P * sum(range(200))\nego = new Car on road, with speed x / 9999\n",
    ),
)
TOO_MUCH_WORK = Problem(
    "SCN434",
    "this file takes too long to evaluate",
    "loops, lists, functions and behaviors need more than {limit} evaluations",
    "end loops sooner, and use shorter lists and ranges",
    page=Page(
        "too much to evaluate",
        "Loops, lists, functions and behaviors are evaluated when the file is compiled; the limit stops what would "
        "take forever.",
        "big = range(5000)\nx = len([a for a in big for b in big])\nego = new Car on road, with speed x / 1e9\n",
        "big = range(50)\nx = len([a for a in big for b in big])\nego = new Car on road, with speed x / 1e9\n",
    ),
)
ENDLESS_LAMBDA = Problem(
    "SCN435",
    "this function calls itself too deeply, or without end",
    cure="use a list instead of recursion",
    page=Page(
        "endless recursion",
        "A function that calls itself is evaluated when the file is compiled, whatever its condition says about drawn "
        "values. Thirty nested calls are the limit, fewer where each contains many loops and lists.",
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
        "Every item of a list is evaluated when the file is compiled, so its length is limited.",
        "x = list(range(9000)) + list(range(9000))\nego = new Car on road, with speed len(x) / 1e4\n",
        "x = list(range(900)) + list(range(900))\nego = new Car on road, with speed len(x) / 1e4\n",
    ),
)
BAD_TRACK = Problem(
    "SCN457",
    "this track cannot be replayed: {reason}",
    cure="{cure}",
    page=Page(
        "track that cannot be replayed",
        "A track is a text: the line `time,x,y,heading,speed`, then a row of five numbers for each sample, in SI units "
        "and radians, in order of time.",
        'TRACK = """\ntime,x,y,heading,speed\n0,0,0,0,10\n"""\n'
        "ego = new Car on road, with behavior ReplayBehavior(TRACK)\n",
        'TRACK = """\ntime,x,y,heading,speed\n0,0,0,0,10\n1,10,0,0,10\n"""\n'
        "ego = new Car on road, with behavior ReplayBehavior(TRACK)\n",
    ),
)

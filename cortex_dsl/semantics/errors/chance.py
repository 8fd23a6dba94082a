"""SCN5xx: random values and choices. SCN53x: what is proved of a file before anything is drawn. SCN69x: what only shows
while a scene is drawn or runs.
"""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.errors.problems import Problem, note

TURNED_RANGE = note(
    "SCN515",
    "this range is reversed: it is read from {low} to {high}",
    "Scenic draws from a reversed range as if its bounds were in order",
    page=Page(
        "reversed range in a Scenic file",
        "In a file with Scenic's `model` line a reversed range means the same as one in order; elsewhere it is an "
        "error.",
        "model scenic.domains.driving.model\nego = new Car on road, with speed Range(9, 3)\n",
        "model scenic.domains.driving.model\nego = new Car on road, with speed Range(3, 9)\n",
    ),
)
REVERSED_RANGE = Problem(
    "SCN501",
    "this range is reversed: {low} is above {high}",
    cure="write the lower bound first: {high}, {low}",
    page=Page(
        "reversed range",
        "The lower bound comes first. Scenic accepts a reversed range without a message.",
        "ego = new Car on road, with speed Range(9, 5) m/s\n",
        "ego = new Car on road, with speed Range(5, 9) m/s\n",
    ),
)
EMPTY_RANGE = Problem(
    "SCN502",
    "this range contains a single value: {low}",
    "nothing is random in it",
    "write the value itself, or widen it",
    page=Page(
        "range of one value",
        "A range with equal ends always gives the same value.",
        "ego = new Car on road, with speed Range(5, 5) m/s\n",
        "ego = new Car on road, with speed 5 m/s\n",
    ),
)
NOTHING_TO_RESAMPLE = Problem(
    "SCN516",
    "`resample` needs a number that was drawn, but this is {actual}",
    "a constant, a sum or a param of the search is not drawn from one distribution",
    "write the distribution itself again",
    page=Page(
        "`resample` of a value that was not drawn",
        "`resample(x)` draws once more from the distribution that x was drawn from; a constant has none.",
        "x = 5\nego = new Car at (x, resample(x))\n",
        "x = Range(4, 6)\nego = new Car at (x, resample(x))\n",
    ),
)
BAD_DEVIATION = Problem(
    "SCN503",
    "the standard deviation must be above 0, but is {actual}",
    cure="write the mean first, then the deviation: `Normal(0, 0.2)`",
    page=Page(
        "standard deviation not above 0",
        "The second argument of a normal distribution is its spread.",
        "ego = new Car on road, with speed 5 m/s + Normal(1, 0) m/s\n",
        "ego = new Car on road, with speed 5 m/s + TruncatedNormal(0, 1, -3, 3) m/s\n",
    ),
)
NO_OPTIONS = Problem(
    "SCN504",
    "there is nothing to choose from in any variant",
    "{reason}",
    "{cure}",
    page=Page(
        "nothing to choose from",
        "The list to choose from is empty, whatever was chosen before.",
        "m = Uniform(*filter(lambda m: m.type is ManeuverType.U_TURN, network.lanes[0].maneuvers))\n"
        "ego = new Car in m.startLane.centerline\n",
        "m = Uniform(*filter(lambda m: m.type is ManeuverType.STRAIGHT, network.lanes[0].maneuvers))\n"
        "ego = new Car in m.startLane.centerline\n",
    ),
)
LIST_AS_OPTION = Problem(
    "SCN514",
    "`Uniform` chooses among its arguments, but there is only one: a list",
    "it would always choose the whole list",
    "write a `*` in front of it: `Uniform(*{text})`",
    page=Page(
        "list instead of its items",
        "`Uniform(a, b)` chooses between a and b. A list is unpacked into its items with `*`.",
        "lane = Uniform(network.lanes)\nego = new Car in lane.centerline\n",
        "lane = Uniform(*network.lanes)\nego = new Car in lane.centerline\n",
    ),
)
TOO_MANY_VARIANTS = Problem(
    "SCN505",
    "the finite choices of this file multiply to more than {limit} variants",
    "{sizes}",
    "choose from shorter lists, or fix some choices",
    page=Page(
        "too many combinations",
        "Each combination of finite choices is compiled separately; there may be at most 4,096. Lanes on which only "
        "places depend do not count: above 1,024 combinations they are drawn with the scene.",
        "map intersection(lanes=4, rows=3, cols=3)\n"
        "a = Uniform(*network.maneuvers)\n"
        "b = Uniform(*network.maneuvers)\n"
        "ego = new Car in a.startLane.centerline\n"
        "car = new Car in b.startLane.centerline\n",
        "map intersection(lanes=1, rows=1, cols=1)\n"
        "a = Uniform(*network.maneuvers)\n"
        "b = Uniform(*network.maneuvers)\n"
        "ego = new Car in a.startLane.centerline\n"
        "car = new Car in b.startLane.centerline\n",
    ),
)
NOT_CONSTANT = Problem(
    "SCN506",
    "{purpose} must be known at compile time, but this depends on a draw, a param or the run",
    cure="use a constant, or a finite choice such as `DiscreteRange`",
    page=Page(
        "value that must be known at compile time",
        "Some values decide the structure of the scene, so they must be known when the file is compiled.",
        "ego = new Car in network.lanes[Range(0, 3)].centerline\n",
        "ego = new Car in network.lanes[DiscreteRange(0, 3)].centerline\n",
    ),
)
GENE_BOUNDS = Problem(
    "SCN507",
    "the bounds of the param `{name}` are not constant",
    "a search needs a fixed box",
    "use numbers, or drop `param` to draw it again for every scene",
    page=Page(
        "bounds that are not constant",
        "A search explores a box, so the bounds of each param that it chooses are constant.",
        "param A = Range(1, 2) m/s\nparam B = Range(0, A)\nego = new Car on road, with speed B\n",
        "param A = Range(1, 2) m/s\nparam B = Range(0, 1)\nego = new Car on road, with speed A * B\n",
    ),
)
GENE_VARIES = Problem(
    "SCN508",
    "the param `{name}` depends on a random choice",
    "a search needs a fixed box",
    "use numbers",
    page=Page(
        "param that differs from scene to scene",
        "A search explores one box, the same for every scene.",
        "n = len(Uniform([1], [1, 2]))\nparam V = Range(0, n) m/s\nego = new Car on road, with speed V\n",
        "param V = Range(0, 2) m/s\nego = new Car on road, with speed V\n",
    ),
)
BAD_WEIGHTS = Problem(
    "SCN509",
    "{message}",
    cure="write `Discrete({{a: 1, b: 2}})` with weights above 0",
    page=Page(
        "wrong weights",
        "`Discrete` takes a dictionary that gives each option its weight; only their proportions count.",
        "ego = new Car on road, with speed Discrete({5: -1, 9: 2}) m/s\n",
        "ego = new Car on road, with speed Discrete({5: 1, 9: 2}) m/s\n",
    ),
)
NOT_WHOLE = Problem(
    "SCN510",
    "{what} must be a whole number, but is {actual}",
    cure="round it",
    page=Page(
        "not a whole number",
        "Lanes, steps and items are counted in whole numbers.",
        "ego = new Car in network.lanes[0.5].centerline\n",
        "ego = new Car in network.lanes[0].centerline\n",
    ),
)
MIXED_OPTIONS = Problem(
    "SCN511",
    "the options do not match: {left} and {right}",
    cure="give them all the same dimension",
    page=Page(
        "options that do not match",
        "Whichever option is drawn is used in the same place, so all of them must have the same dimension.",
        "ego = new Car on road, with speed Uniform(5 m/s, 9 m)\n",
        "ego = new Car on road, with speed Uniform(5 m/s, 9 m/s)\n",
    ),
)
FIXED_EXHAUSTED = Problem(
    "SCN512",
    "`Fixed` was evaluated {count} times, but has {given} values",
    cure="give it a value for each time, or draw with `Uniform(...)`",
    page=Page(
        "`Fixed` with no values left",
        "`Fixed(a, b)` gives its values one after another; there is no third.",
        "ego = new Car on road\ncars = [new Car at (Fixed(9, 18), 0) for i in range(3)]\n",
        "ego = new Car on road\ncars = [new Car at (Fixed(9, 18, 27), 0) for i in range(3)]\n",
    ),
)
RANDOM_WHILE_RUNNING = Problem(
    "SCN513",
    "objects cannot be chosen again during the run",
    "lanes and other objects are fixed with the scene",
    "choose outside the behavior and pass the choice as an argument",
    page=Page(
        "object chosen during the run",
        "Lanes and objects are fixed with the scene; only numbers can be drawn while a behavior runs.",
        "behavior Wander():\n"
        "    while True:\n"
        "        do FollowLaneBehavior(laneToFollow=Uniform(*network.lanes)) for 1 s\n"
        "\n"
        "ego = new Car on road, with behavior Wander()\n",
        "behavior Wander(lane):\n"
        "    while True:\n"
        "        do FollowLaneBehavior(laneToFollow=lane) for 1 s\n"
        "\n"
        "ego = new Car on road, with behavior Wander(Uniform(*network.lanes))\n",
    ),
)
NUISANCE_PARAM = note(
    "SCN520",
    "the param `{name}` is not searched",
    "{reason}",
    "use `Range` or `TruncatedNormal` to make it a gene",
    page=Page(
        "param that is not searched",
        "A search needs bounds. A param without them is drawn again for every scene, like any other random value.",
        "param V = Normal(9, 1)\nego = new Car on road\nrequire ego.speed < V\n",
        "param V = TruncatedNormal(9, 1, 5, 12)\nego = new Car on road\nrequire ego.speed < V\n",
    ),
)

# -- SCN53x: what is proved of a file before anything is drawn ---------------------------------------------------------

INFEASIBLE = Problem(
    "SCN530",
    "no scene can meet every requirement",
    "{reason}",
    "{cure}",
    page=Page(
        "file without a valid scene",
        "Interval arithmetic over the ranges of all params and draws proves that no attempt can pass: every one of "
        "them would be rejected. The requirements named are a smallest set for which this is proved.",
        "param D = Range(5, 20) m\nego = new Car on road\nrequire D >= 15 m\nrequire D * 2 <= 25 m\n",
        "param D = Range(5, 20) m\nego = new Car on road\nrequire D >= 10 m\nrequire D * 2 <= 25 m\n",
        shown="by `--check`",
    ),
)
OFF_THE_ROAD = Problem(
    "SCN531",
    "`{name}` is not on the road",
    "at the start its whole outline must lie on the road, so every scene would be rejected",
    "put it in a lane, as in `in lane.centerline`, or turn it, as in `facing roadDirection`; to place it beside the "
    "road write `with regionContainedIn None`, and after `at` also `facing 90 deg`",
    page=Page(
        "object off the road",
        "Vehicles start on the road, with their whole outline. x points east and y north, in metres from the centre "
        "of the map.",
        "ego = new Car on road\nnew Truck at (20, -30)\n",
        "ego = new Car on road\nnew Truck at (20, -30), facing 90 deg, with regionContainedIn None\n",
        shown="by `--check`, and where no scene was found",
    ),
)
ON_TOP = Problem(
    "SCN532",
    "`{name}` overlaps `{other}`",
    "at the start no two outlines may overlap, so every scene would be rejected",
    "move one of them, as in `ahead of {other} by 5 m`; or write `with allowCollisions True` if this is intended",
    page=Page(
        "object that overlaps another",
        "A scene starts without contact: no two outlines overlap.",
        "ego = new Car at (1.75, -30), facing 90 deg\nnew Car at (1.75, -29), facing 90 deg\n",
        "ego = new Car at (1.75, -30), facing 90 deg\nnew Car at (1.75, -20), facing 90 deg\n",
        shown="by `--check`, and where no scene was found",
    ),
)

# -- SCN69x: what only shows while a scene is drawn or runs ------------------------------------------------------------

STUCK = Problem(
    "SCN690",
    "this behavior never acts",
    "a behavior's turn ends with an action; until then the simulated time stands still",
    "`take` an action or `wait` in every loop",
    page=Page(
        "behavior that got stuck",
        "A loop never ended within one step. Where that is certain the compiler reports SCN602; here it depended on "
        "the run.",
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
    "narrow the ranges, or keep it finite, as in `sqrt(max(x, 0))` or `1 / x if x != 0 else 0`",
    page=Page(
        "value that is not a number",
        "A root, quotient or logarithm has no finite value for some of the numbers that can be drawn, and one of them "
        "was drawn. A condition on such a number neither holds nor fails.",
        "x = Range(-9, 1)\nego = new Car at (sqrt(x), -30)\n",
        "x = Range(1, 9)\nego = new Car at (sqrt(x), -30)\n",
        shown="while the scene is drawn",
    ),
)

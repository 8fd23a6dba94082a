"""SCN55x, SCN681 to SCN683: what the compiler evaluates: fields at places, overrides of a file's own properties, texts
made of values, and how large regions and lists may become.
"""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.errors.problems import Problem

NO_FIELD_AT = Problem(
    "SCN550",
    "the left side of `at` must be a field of directions, but this is {actual}",
    "`(FIELD at PLACE)` is the heading of the field at that place",
    "write `roadDirection`, or a `VectorField`, before `at`",
    page=Page(
        "`at` after something that is not a field",
        "`(roadDirection at p)` is the heading of the road at p. Only fields of directions have one at every place.",
        "ego = new Car on road\nh = (ego at (1.75, -30))\nrequire h > 0 deg\n",
        "ego = new Car on road\nh = (roadDirection at (1.75, -30))\nrequire h > 0 deg\n",
    ),
)
OVERRIDDEN_AND_SET = Problem(
    "SCN551",
    "`{name}` is overridden here and set by a behavior or a monitor",
    "its value after the scenario would be ambiguous",
    "use two properties, or set it only in the behavior",
    page=Page(
        "property that is both overridden and set",
        "A scenario overrides a property while it runs, and restores it afterwards. A behavior sets one permanently.",
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
LAYOUT = Problem(
    "SCN552",
    "`{layout}` is not a format for {kind}",
    "the part after the colon is read as in Python; widths have up to three digits",
    "as in `{{x:.2f}}` for a number, `{{n:03d}}` for a whole number, `{{name:>8}}` for a text",
    page=Page(
        "format that does not fit the value",
        "The part after the colon in an f-string says how the value is formatted. `d` is for whole numbers, `f` and "
        "`e` are for all numbers, and a text takes only a width.",
        'laps = 2.5\nego = new Car on road, with name f"car {laps:d}"\n',
        'laps = 2.5\nego = new Car on road, with name f"car {laps:.1f}"\n',
    ),
)
LONG_TEXT = Problem(
    "SCN553",
    "this text has more than {limit} characters",
    "texts are built when the file is compiled, so their length is limited",
    "shorten it",
    page=Page(
        "text too long",
        "A text that is built from others may double with each iteration of a loop, so its length is limited.",
        'x = "ab"\nfor i in range(20):\n    x = x + x\nego = new Car on road, with name x\n',
        'x = "ab"\nfor i in range(2):\n    x = x + x\nego = new Car on road, with name x\n',
    ),
)
NO_NUMBER_IN_TEXT = Problem(
    "SCN554",
    "{text} is not a {kind}",
    "the text is converted as in Python",
    'write only a number in it, as in `int("3")` or `float("2.5")`',
    page=Page(
        "text is not a number",
        "`int` and `float` convert a text that contains only a number; a unit goes after the call.",
        'ego = new Car on road, with speed float("ten")\n',
        'ego = new Car on road, with speed float("10")\n',
    ),
)
NO_CLASS = Problem(
    "SCN555",
    "`isinstance` needs a class, but this is {actual}",
    "the classes are those that `new` accepts, and `int`, `float`, `str`, `list` and `tuple`",
    "write one of them, or several in brackets: `(Car, Truck)`",
    page=Page(
        "not a class",
        "`isinstance(x, Car)` is true for a `Car` and for objects of every class derived from it.",
        'ego = new Car on road\nrequire isinstance(ego, "Car")\n',
        "ego = new Car on road\nrequire isinstance(ego, Car)\n",
    ),
)
LAST_ACTIONS = Problem(
    "SCN556",
    "the actions of the last step are not kept as a list",
    "actions are commands to the simulation, not values",
    "read their effect, `{name}.throttle`, `{name}.brake` or `{name}.steer`, or keep track of them yourself: "
    "`with braked 0`, and `self.braked = 1` beside the `take`",
    page=Page(
        "`lastActions`",
        "Scenic keeps the actions that each object took in the last step. Here they are commands that the simulation "
        "carries out; pedals and steering are numbers that can be read, and a behavior may count what it does.",
        "ego = new Car on road, with behavior BrakeBehavior()\nrecord ego.lastActions as actions\n"
        "terminate after 2 s\n",
        "ego = new Car on road, with behavior BrakeBehavior()\nrecord ego.brake as brake\nterminate after 2 s\n",
    ),
)
MANY_REGIONS = Problem(
    "SCN681",
    "this region combines more than {limit} others",
    "each part is tested whenever the region is tested, as often as it occurs in it",
    "combine fewer, or write one `PolygonalRegion` around them",
    page=Page(
        "region made of too many others",
        "`union`, `intersect` and `difference` combine two regions; a region that is combined with itself again and "
        "again would double each time.",
        "r = CircularRegion((0, 0), 10)\nfor i in range(20):\n    r = r.union(r)\nego = new Object in r\n",
        "r = CircularRegion((0, 0), 10)\nfor i in range(2):\n    r = r.union(r)\nego = new Object in r\n",
    ),
)
EMPTY_REGION = Problem(
    "SCN682",
    "`{text}` contains no place",
    "it is empty, whatever is drawn",
    "move its parts so that they overlap, or name another region",
    page=Page(
        "empty region",
        "Two regions that do not overlap have an empty intersection, and a region inside another has an empty "
        "difference from it.",
        "r = CircularRegion((0, 0), 3).intersect(CircularRegion((100, 0), 3))\nego = new Object in r\n",
        "r = CircularRegion((0, 0), 3).intersect(CircularRegion((4, 0), 3))\nego = new Object in r\n",
    ),
)
DEEP_LIST = Problem(
    "SCN683",
    "lists are nested more than {limit} deep",
    "lists are compared and printed from the inside out, so their depth is limited",
    "append the items instead: `xs + [x]`",
    page=Page(
        "list nested too deeply",
        "A loop that puts a list into a list in each iteration makes one that is as deep as the loop is long.",
        "x = [1]\nfor i in range(200):\n    x = [x]\nego = new Car on road, with speed len(x)\n",
        "x = [1]\nfor i in range(20):\n    x = [x]\nego = new Car on road, with speed len(x)\n",
    ),
)

"""SCN55x, SCN681 to SCN683: words of Scenic that the compiler works out: fields at places, overrides of a file's own
properties, texts made of values, and what regions and lists are made of.
"""

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
LAYOUT = Problem(
    "SCN552",
    "`{layout}` does not lay out {kind}",
    "it is read as Python reads what stands behind the colon; widths have up to three digits",
    "as in `{{x:.2f}}` for a number, `{{n:03d}}` for a whole one, `{{name:>8}}` for a text",
    page=Page(
        "layout that does not fit the value",
        "What stands behind the colon in a text with values says how one value is laid out. `d` is for whole numbers, "
        "`f` and `e` are for all, and a text has a width alone.",
        'laps = 2.5\nego = new Car on road, with name f"car {laps:d}"\n',
        'laps = 2.5\nego = new Car on road, with name f"car {laps:.1f}"\n',
    ),
)
LONG_TEXT = Problem(
    "SCN553",
    "this text has more than {limit} characters",
    "texts are put together when the file is compiled, so their length is limited",
    "put less into it",
    page=Page(
        "text too long",
        "A text that is put together from others may double with each step of a loop, so its length is limited.",
        'x = "ab"\nfor i in range(20):\n    x = x + x\nego = new Car on road, with name x\n',
        'x = "ab"\nfor i in range(2):\n    x = x + x\nego = new Car on road, with name x\n',
    ),
)
NO_NUMBER_IN_TEXT = Problem(
    "SCN554",
    "{text} is no {kind}",
    "a text is read as Python reads it",
    'write digits alone in it, such as `int("3")` or `float("2.5")`',
    page=Page(
        "text that is no number",
        "`int` and `float` read a text that has nothing but a number in it; a unit stands behind the call.",
        'ego = new Car on road, with speed float("ten")\n',
        'ego = new Car on road, with speed float("10")\n',
    ),
)
NO_CLASS = Problem(
    "SCN555",
    "`isinstance` asks for a class, but this is {actual}",
    "classes are those that `new` makes objects of, and `int`, `float`, `str`, `list` and `tuple`",
    "write one of them, or several in brackets: `(Car, Truck)`",
    page=Page(
        "what is no class",
        "`isinstance(x, Car)` is true of a `Car` and of everything of a class that is made from it.",
        'ego = new Car on road\nrequire isinstance(ego, "Car")\n',
        "ego = new Car on road\nrequire isinstance(ego, Car)\n",
    ),
)
LAST_ACTIONS = Problem(
    "SCN556",
    "what an object took in the last step is not kept as a list",
    "actions are orders to the simulation and no values",
    "ask for what they do, `{name}.throttle`, `{name}.brake` or `{name}.steer`, or note it yourself: "
    "`with braked 0`, and `self.braked = 1` beside the `take`",
    page=Page(
        "`lastActions`",
        "Scenic keeps the actions that each object took in the last step. Here they are orders that the simulation "
        "carries out; pedals and steering are numbers that can be asked for, and a behavior may count what it does.",
        "ego = new Car on road, with behavior BrakeBehavior()\nrecord ego.lastActions as actions\n"
        "terminate after 2 s\n",
        "ego = new Car on road, with behavior BrakeBehavior()\nrecord ego.brake as brake\nterminate after 2 s\n",
    ),
)
MANY_REGIONS = Problem(
    "SCN681",
    "this region is made of more than {limit} others",
    "each is asked about wherever the region is asked about, one within another as often as it stands there",
    "join fewer, or write one `PolygonalRegion` around them",
    page=Page(
        "region made of too many",
        "`union`, `intersect` and `difference` make a region of two; one that is joined with itself again and again "
        "would double each time.",
        "r = CircularRegion((0, 0), 10)\nfor i in range(20):\n    r = r.union(r)\nego = new Object in r\n",
        "r = CircularRegion((0, 0), 10)\nfor i in range(2):\n    r = r.union(r)\nego = new Object in r\n",
    ),
)
EMPTY_REGION = Problem(
    "SCN682",
    "no place lies in `{text}`",
    "it is empty, whatever is drawn",
    "move its parts so that they overlap, or name another region",
    page=Page(
        "empty region",
        "Two regions that do not meet have an empty intersection, and a region that lies within another an empty "
        "difference from it.",
        "r = CircularRegion((0, 0), 3).intersect(CircularRegion((100, 0), 3))\nego = new Object in r\n",
        "r = CircularRegion((0, 0), 3).intersect(CircularRegion((4, 0), 3))\nego = new Object in r\n",
    ),
)
DEEP_LIST = Problem(
    "SCN683",
    "lists lie more than {limit} deep in one another",
    "lists are compared and printed from the inside out, so their depth is limited",
    "put items beside one another: `xs + [x]`",
    page=Page(
        "list too deep",
        "A loop that puts a list into a list each time makes one that is as deep as the loop is long.",
        "x = [1]\nfor i in range(200):\n    x = [x]\nego = new Car on road, with speed len(x)\n",
        "x = [1]\nfor i in range(20):\n    x = [x]\nego = new Car on road, with speed len(x)\n",
    ),
)

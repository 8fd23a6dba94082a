"""SCN4xx: requirements and other statements."""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.errors.problems import Problem, hint, note, warning

PROBABILITY_RANGE = Problem(
    "SCN422",
    "the probability of a `require` is {actual}",
    "it must be above 0 and at most 1",
    "as in `require[0.8] x > 3 m`",
    page=Page(
        "probability out of range",
        "`require[p]` is tested with probability p, once in each scene.",
        "ego = new Car on road\nrequire[1.5] ego.speed < 1 m/s\n",
        "ego = new Car on road\nrequire[0.5] ego.speed < 1 m/s\n",
    ),
)
ALWAYS_FALSE = Problem(
    "SCN423",
    "this `require` can never hold",
    "it is false whatever is drawn",
    "change or remove it",
    page=Page(
        "requirement that never holds",
        "Every scene that could be drawn would be rejected: no value of the params makes it true.",
        "param V = Range(1, 9) m/s\nego = new Car on road, with speed V\nrequire V > 10 m/s\n",
        "param V = Range(1, 9) m/s\nego = new Car on road, with speed V\nrequire V > 5 m/s\n",
    ),
)
DIFFERENT_OBJECTS = Problem(
    "SCN426",
    "the objects of the scene depend on a random choice",
    "here they are {here}; with other choices {there}",
    "make the same objects whatever is chosen",
    page=Page(
        "scene with changing objects",
        "A search compares scenes with the same objects in the same order, whatever is chosen at random.",
        "lane = Uniform(network.lanes[0], network.lanes[1])\n"
        "ego = new Car on road\n"
        "cars = [new Car in m.endLane.centerline for m in lane.maneuvers]\n",
        "lane = Uniform(network.lanes[0], network.lanes[1])\n"
        "ego = new Car on road\n"
        "cars = [new Car in lane.centerline for i in range(3)]\n",
    ),
)
NOT_SUPPORTED = Problem(
    "SCN427",
    "{what}",
    "{reason}",
    "{cure}",
    page=Page(
        "not possible",
        "The language has the construct, but not for these things; the message says for which.",
        "spot = new Point at (0, 0), facing 90 deg\nego = new Car at spot\n",
        "spot = new OrientedPoint at (0, 0), facing 90 deg\nego = new Car at spot\n",
    ),
)
EMPTY_FILE = Problem(
    "SCN429",
    "this file is empty",
    cure="start with `map intersection()` and `ego = new Car ...`",
    page=Page(
        "nothing but comments",
        "A scenario needs at least an ego.",
        '"""A scenario to be written."""\n',
        '"""A scenario."""\nego = new Car on road\n',
    ),
)
STATEMENT_PLACE = Problem(
    "SCN431",
    "`{statement}` stands {here}, but belongs {there}",
    cure="{cure}",
    page=Page(
        "statement in the wrong place",
        "What an object does stands in a behavior; what the scene is stands at the top level.",
        "ego = new Car on road\nwait\n",
        "behavior Rest():\n    wait\n\nego = new Car on road, with behavior Rest()\n",
    ),
)
NO_EFFECT = note(
    "SCN444",
    "`{name}` has no effect here",
    "{reason}",
    page=Page(
        "line without effect",
        "Files of Scenic set things that are not simulated here; the line is read and left alone.",
        "param weather = 'ClearNoon'\nego = new Car on road\n",
        "ego = new Car on road\n",
    ),
)
NEVER_RUNS = warning(
    "SCN446",
    "this `terminate when` always holds",
    "the run ends at its first sample",
    "change or remove it",
    page=Page(
        "run that ends at once",
        "The condition holds from the first sample on, so nothing is ever simulated.",
        "ego = new Car on road\nterminate when 1 < 2\n",
        "ego = new Car on road\nterminate when ego.speed < 1 m/s\n",
    ),
)
ALWAYS_TRUE = warning(
    "SCN480",
    "this `require` always holds",
    "it removes nothing, whatever is drawn or searched",
    "change or remove it",
    page=Page(
        "requirement that removes nothing",
        "The ranges of its params alone make it true. Perhaps a sign, a unit or a limit is wrong.",
        "param V = Range(1, 9) m/s\nego = new Car on road, with speed V\nrequire V < 30 m/s\n",
        "param V = Range(1, 9) m/s\nego = new Car on road, with speed V\nrequire V < 5 m/s\n",
    ),
)
WINDOW = hint(
    "SCN481",
    "`{name}` is drawn anywhere on its lane, and this keeps a window of it",
    "all other scenes are drawn in vain, and count as invalid in a search",
    "write `{name} = new {kind} {place}` and remove this `require`; or `# allow SCN481` if the window is meant",
    page=Page(
        "window on a uniform placement",
        "`before … by …` puts the object where the `require` wants it, so that no scene is rejected. The paper's "
        "set-up rejects on purpose: its searches learn to avoid invalid cases.",
        "lane = intersection.incomingLanes[0]\nego = new Car in lane.centerline\n"
        "require 10 m <= (distance from ego to intersection) <= 20 m\n",
        "lane = intersection.incomingLanes[0]\nego = new Car before intersection by Range(10, 20) m along [lane]\n",
    ),
)
OVERRIDE_OUTSIDE = warning(
    "SCN482",
    "`-p {name}={value}` is outside the range of the param",
    "the file draws it between {low} and {high}",
    "choose a value in the range, or widen the range if the file means more",
    page=Page(
        "`-p` outside the range",
        "The run is one that no search of this file could find.",
        "param V = Range(1, 9) m/s\nego = new Car on road, with speed V\n",
        "param V = Range(1, 9) m/s\nego = new Car on road, with speed V\n",
        options=("V=20", "V=5"),
    ),
)

"""SCN4xx: requirements and other statements. SCN46x, SCN47x: requirements on the whole run, and records of it."""

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
ASSERTION = Problem(
    "SCN476",
    "this assertion is false",
    "{reason}",
    "correct the values in it; write `require` for what random values must satisfy",
    page=Page(
        "assertion that is false",
        "An `assert` states what its author takes for granted. On known values it is checked when the file is "
        "compiled, on random ones it is a requirement on the scene, and in a behavior a run that breaks it is aborted.",
        "ego = new Car on road\nassert len(network.lanes) > 1000\n",
        "ego = new Car on road\nassert len(network.lanes) > 1\n",
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
        "The language has the construct, but not in this combination; the message says which.",
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
    "`{statement}` is {here}, but belongs {there}",
    cure="{cure}",
    page=Page(
        "statement in the wrong place",
        "What an object does belongs in a behavior; what the scene consists of belongs at the top level.",
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
        "Scenic files may set things that are not simulated here; the line is read and ignored.",
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
    "it rejects nothing, whatever is drawn or searched",
    "change or remove it",
    page=Page(
        "requirement that rejects nothing",
        "The ranges of its params alone make it true. Perhaps a sign, a unit or a limit is wrong.",
        "param V = Range(1, 9) m/s\nego = new Car on road, with speed V\nrequire V < 30 m/s\n",
        "param V = Range(1, 9) m/s\nego = new Car on road, with speed V\nrequire V < 5 m/s\n",
    ),
)
WINDOW = hint(
    "SCN481",
    "`{name}` is drawn anywhere on its lane, and this keeps only a window of it",
    "all other scenes are drawn in vain, and count as invalid in a search",
    "write `{name} = new {kind} {place}` and remove this `require`; or `# allow SCN481` if the window is intended",
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
    "choose a value in the range, or widen the range in the file",
    page=Page(
        "`-p` outside the range",
        "No search of this file could find such a run.",
        "param V = Range(1, 9) m/s\nego = new Car on road, with speed V\n",
        "param V = Range(1, 9) m/s\nego = new Car on road, with speed V\n",
        options=("V=20", "V=5"),
    ),
)


BAD_SETTING = Problem(
    "SCN428",
    "`{name}` must be {expected}, but this is {actual}",
    "{reason}",
    'a search writes it, as in `stream="7.ga.0.3.12.0"`; leave it out to draw again',
    page=Page(
        "wrong setting",
        "`simulation(...)` fixes settings of the run; each takes a certain kind of value.",
        "ego = new Car on road\nsimulation(stream=5)\n",
        "ego = new Car on road\nsimulation(time_step=0.05 s)\n",
    ),
)


NO_SYSTEM_PARAM = Problem(
    "SCN483",
    "`system` lists params of this file, but `{actual}` is not one",
    "they are the params of the system under test, which `--freeze` holds fixed",
    "{suggestion}",
    page=Page(
        "not a param of the system",
        "`simulation(system=[...])` names the params that belong to the system under test.",
        "param BRAKE = Range(0, 1)\nego = new Car on road, with speed BRAKE * 9 m/s\nsimulation(system=[BRAKES])\n",
        "param BRAKE = Range(0, 1)\nego = new Car on road, with speed BRAKE * 9 m/s\nsimulation(system=[BRAKE])\n",
    ),
)


BARE_EXPRESSION = warning(
    "SCN440",
    "this value is not used",
    cure="{cure}",
    page=Page(
        "value that is not used",
        "A line that only computes a value changes nothing. Perhaps `require` is missing in front of it.",
        "ego = new Car on road\nego.speed < 3 m/s\n",
        "ego = new Car on road\nrequire ego.speed < 3 m/s\n",
    ),
)

# -- SCN46x, SCN47x: requirements on the whole run, and what is recorded of it -----------------------------------------

TEMPORAL_PLACE = Problem(
    "SCN460",
    "`{operator}` cannot be used here",
    "it applies to a whole run, so only the condition of a `require` at the top level may contain it",
    "{cure}",
    page=Page(
        "temporal operator in the wrong place",
        "`always`, `eventually`, `next` and `until` are judged over all samples of a run. They are operands of `and`, "
        "`or`, `not` and of each other in a `require` at the top level; a behavior or a monitor sees one moment only.",
        "behavior B():\n    require always self.speed > 3 m/s\n    do FollowLaneBehavior()\n\n"
        "ego = new Car on road, with speed 5 m/s, with behavior B()\n",
        "behavior B():\n    do FollowLaneBehavior()\n\n"
        "ego = new Car on road, with speed 5 m/s, with behavior B()\nrequire always ego.speed > 3 m/s\n",
    ),
)
SOFT_TEMPORAL = Problem(
    "SCN461",
    "a temporal requirement cannot be soft",
    "`require[p]` is decided by chance for each scene, but this is about the run",
    "remove `[...]`",
    page=Page(
        "soft temporal requirement",
        "`require[p]` applies a condition to a share of the scenes that are drawn. A temporal requirement is judged "
        "when the run is over, too late to draw another scene.",
        "ego = new Car on road, with speed 5 m/s\nrequire[0.5] always ego.speed > 3 m/s\n",
        "ego = new Car on road, with speed 5 m/s\nrequire always ego.speed > 3 m/s\n",
    ),
)
TEMPORAL_HOLDS = warning(
    "SCN462",
    "this `require` holds in every run",
    "its condition is known to be true",
    "remove it, or change its condition",
    page=Page(
        "temporal requirement that always holds",
        "A condition that cannot be false requires nothing.",
        "limit = 3 m\nego = new Car on road, with speed 5 m/s\nrequire always limit < 4 m\n",
        "limit = 3 m\nego = new Car on road, with speed 5 m/s\nrequire always (distance to intersection) < limit\n",
    ),
)
NEVER_CHANGES = warning(
    "SCN463",
    "nothing in this condition changes during the run",
    "it is the same in all samples, so it is a condition on the scene alone",
    "write `require` without temporal operators: scenes in which it fails are then drawn again",
    page=Page(
        "temporal requirement about something that never changes",
        "A run that breaks a temporal requirement is aborted and counts as invalid. A condition that is fixed with the "
        "scene is better required of the scene: then another scene is drawn instead.",
        "gap = Range(3, 9) m\nego = new Car on road, with speed 5 m/s\nrequire always gap > 5 m\n",
        "gap = Range(3, 9) m\nego = new Car on road, with speed 5 m/s\nrequire gap > 5 m\n",
    ),
)
NO_END = hint(
    "SCN464",
    "this must come true within {limit:g} s",
    "a run of a file without `terminate after` lasts that long at most",
    "write `terminate after {limit:g} s`, or another time, to make the limit explicit",
    page=Page(
        "`eventually` without a time",
        "What must happen at some time must happen before the run ends. Without `terminate after` that is the default "
        "length of a run.",
        "ego = new Car on road, with speed 5 m/s\nrequire eventually (distance to intersection) < 3 m\n",
        "ego = new Car on road, with speed 5 m/s\nrequire eventually (distance to intersection) < 3 m\n"
        "terminate after 20 s\n",
    ),
)
CONTACT_UNSEEN = warning(
    "SCN465",
    "`{one}` and `{other}` can touch without breaking this",
    "{reason}",
    "to reject such runs write `({cure})`, which is as far as both move in two steps",
    page=Page(
        "`always` on a distance that contact can skip",
        "Requirements on the run are checked at samples, up to the last before contact; contact itself ends the run "
        "as a collision. A fast actor covers a fixed distance within one step. A distance that grows with the speeds "
        "is never skipped: all runs in which these two collide are aborted, and a search finds other collisions.",
        "ego = new Car on road, with speed 5 m/s\ntruck = new Truck ahead of ego by 20 m\n"
        "require always (minimum distance from ego to truck) > 0.5 m\n",
        "ego = new Car on road, with speed 5 m/s\ntruck = new Truck ahead of ego by 20 m\n"
        "require always (minimum distance from ego to truck) > 0.1 m + 0.1 s * (ego.speed + truck.speed)\n",
    ),
)
UNRECORDABLE = Problem(
    "SCN470",
    "{actual} cannot be recorded",
    "a record is a number, a truth value or a place",
    "{cure}",
    page=Page(
        "value that cannot be recorded",
        "A record is a series of numbers. Numbers and truth values are kept as they are, places as their coordinates.",
        "ego = new Car on road\nrecord ego\n",
        "ego = new Car on road\nrecord ego.position\n",
    ),
)
RECORD_VARIES = Problem(
    "SCN471",
    "this record is {here} with some choices and {there} with others",
    "one column cannot hold both",
    "record them under two names",
    page=Page(
        "record of two dimensions",
        "A record has one dimension, whatever the finite choices of the file are.",
        "lane = Uniform(*network.lanes)\nego = new Car on road\n"
        "record (ego.speed if lane is network.lanes[0] else ego.heading) as x\n",
        "ego = new Car on road\nrecord ego.speed\nrecord ego.heading\n",
    ),
)
NOT_ON_FOOT = Problem(
    "SCN680",
    "`{behaviour}` is for people on foot, but this is {actual}",
    "a vehicle moves where its wheels point",
    "write `SetSpeedAction` and `SetSteerAction`, or give it to a Pedestrian",
    page=Page(
        "action for people on foot",
        "A pedestrian turns at once and walks on in that direction; a vehicle has to steer.",
        "behavior B():\n    take SetWalkingSpeedAction(2 m/s)\nego = new Car on road, with behavior B()\n",
        "behavior B():\n    take SetWalkingSpeedAction(2 m/s)\nego = new Car on road\n"
        "new Pedestrian on road, with behavior B()\n",
    ),
)

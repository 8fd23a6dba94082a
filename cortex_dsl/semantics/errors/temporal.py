"""SCN46x, SCN47x: requirements on the whole run, and what is recorded of it."""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.errors.problems import Problem, hint, warning

TEMPORAL_PLACE = Problem(
    "SCN460",
    "`{operator}` cannot stand here",
    "it speaks of a whole run, so only the condition of a `require` at the top level may hold it",
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
    "the coin of `require[p]` is tossed for a scene, and this is about the run",
    "remove `[...]`",
    page=Page(
        "soft temporal requirement",
        "`require[p]` holds a condition against a share of the scenes that are drawn. A temporal requirement is judged "
        "when the run is over, too late for drawing another scene.",
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
        "What cannot be false requires nothing.",
        "limit = 3 m\nego = new Car on road, with speed 5 m/s\nrequire always limit < 4 m\n",
        "limit = 3 m\nego = new Car on road, with speed 5 m/s\nrequire always (distance to intersection) < limit\n",
    ),
)
NEVER_CHANGES = warning(
    "SCN463",
    "nothing in this condition changes during the run",
    "it is the same in all samples, so it decides about the scene alone",
    "write `require` without temporal operators: scenes in which it fails are then drawn anew",
    page=Page(
        "temporal requirement about what never changes",
        "A run that breaks a temporal requirement is aborted and counts as invalid. A condition that is settled with "
        "the scene is better said of the scene: then another scene is drawn instead.",
        "gap = Range(3, 9) m\nego = new Car on road, with speed 5 m/s\nrequire always gap > 5 m\n",
        "gap = Range(3, 9) m\nego = new Car on road, with speed 5 m/s\nrequire gap > 5 m\n",
    ),
)
NO_END = hint(
    "SCN464",
    "this must come true within {limit:g} s",
    "a run of a file without `terminate after` lasts that long at most",
    "write `terminate after {limit:g} s`, or another time, to say how long there is",
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
    "to throw such runs away write `({cure})`, which is as far as both come in two steps",
    page=Page(
        "`always` on a distance that contact passes by",
        "Requirements on the run are looked at in samples, up to the last before contact; contact itself ends the run "
        "as a collision. Who is fast enough passes a fixed distance within one step. A distance that grows with the "
        "speeds is not passed: all runs in which these two collide are aborted, and a search finds other collisions.",
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
        "record of something else",
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

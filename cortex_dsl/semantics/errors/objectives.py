"""SCN49x: what a file expects of the system under test, and what it lets a search make large or small."""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.errors.problems import Problem, warning

NEVER_BROKEN = warning(
    "SCN490",
    "this `expect` can never be broken",
    "its condition is known to be true in every run",
    "remove it, or change its condition",
    page=Page(
        "expectation that nothing can break",
        "A search has nothing to look for: whatever is drawn, the condition holds.",
        "limit = 3 m\nego = new Car on road, with speed 5 m/s\nexpect always limit < 4 m\n",
        "limit = 3 m\nego = new Car on road, with speed 5 m/s\nexpect always (distance to intersection) > limit\n",
    ),
)
ALWAYS_BROKEN = warning(
    "SCN491",
    "this `expect` is broken in every run",
    "its condition is known to be false",
    "change its condition",
    page=Page(
        "expectation that every run breaks",
        "Every run is a finding, so none of them says anything.",
        "limit = 3 m\nego = new Car on road, with speed 5 m/s\nexpect always limit > 4 m\n",
        "limit = 3 m\nego = new Car on road, with speed 5 m/s\nexpect always (distance to intersection) > limit\n",
    ),
)
AT_THE_START = warning(
    "SCN497",
    "this `expect` is asked of the start alone",
    "without `always` or `eventually` a condition is looked at once, before anybody has moved",
    "write `expect always {condition}`",
    page=Page(
        "expectation of the start alone",
        "A formula without a temporal operator speaks of the first instant, so that a run that ends in a collision "
        "keeps `expect not self.collided`. What the system owes in the whole run begins with `always`, what it must "
        "come to with `eventually`.",
        'ego = new Car on road, with speed 5 m/s\nexpect not self.collided as "no contact"\n',
        'ego = new Car on road, with speed 5 m/s\nexpect always not self.collided as "no contact"\n',
    ),
)
TAKEN_NAME = Problem(
    "SCN492",
    "`{name}` is the name of an objective that every file has",
    "by this name alone nobody could tell which of the two is meant",
    "choose another name",
    page=Page(
        "objective with a name that is taken",
        "`risk`, `avoidable`, `conflict` and `severity` are names that each file has for what a run comes to; an "
        "`expect`, `maximize` or `minimize` of the file needs another.",
        'ego = new Car on road, with speed 5 m/s\nexpect always ego.speed < 9 m/s as "risk"\n',
        'ego = new Car on road, with speed 5 m/s\nexpect always ego.speed < 9 m/s as "speed"\n',
    ),
)
NOT_ONE_LINE = Problem(
    "SCN498",
    "the name of an objective is one line of text",
    "tables, `--objective` and the journal write it as it is, and `{name}` has characters that are not shown",
    "leave out line breaks and control characters",
    page=Page(
        "objective whose name cannot be shown",
        "The name stands in tables, in the manifest of a run and on the command line. A line break or a control "
        "character would tear these, or command the terminal.",
        'ego = new Car on road, with speed 5 m/s\nexpect always ego.speed < 9 m/s as "top\\nspeed"\n',
        'ego = new Car on road, with speed 5 m/s\nexpect always ego.speed < 9 m/s as "top speed"\n',
    ),
)
NOT_ONE_NUMBER = Problem(
    "SCN493",
    "this changes during the run, and `{sense}` needs one number of it",
    "a run leaves many values of it behind",
    "say which is meant: `largest(...)`, `least(...)`, `final(...)`, `mean(...)` or `total(...)`",
    page=Page(
        "objective that is no single number",
        "`maximize` and `minimize` compare runs, and for that each run must have one number. A reducer makes one of "
        "all samples; results such as `delta_v` are one number already.",
        "ego = new Car on road, with speed 5 m/s\nmaximize ego.speed\n",
        "ego = new Car on road, with speed 5 m/s\nmaximize largest(ego.speed)\n",
    ),
)
NOT_JUDGED = Problem(
    "SCN494",
    "`collided` is asked of the ego, in `expect`, `maximize` and `minimize`",
    "the ego's first contact ends the run: nothing that goes on sees it",
    "write `expect always not self.collided`",
    page=Page(
        "contact asked for where nothing sees it",
        "A run ends at the ego's first contact, and what is judged reads that instant too. Requirements, behaviors and "
        "monitors see samples before it only, and of others `X intersects Y` tells whether they touch.",
        "ego = new Car on road, with speed 5 m/s\nterminate when ego.collided\n",
        "ego = new Car on road, with speed 5 m/s\nexpect always not ego.collided\n",
    ),
)
NO_NUMBER = Problem(
    "SCN496",
    "`{name}` is not a number in this run",
    "{reason}",
    "keep it legal with `max`, `min` or `... if ... else ...`",
    page=Page(
        "objective that is not a number",
        "The root or logarithm of a negative number and 0 / 0 have no value. Such a run is an error: it counts neither "
        "as kept nor as broken. Anything else over 0, and the logarithm of 0, are infinite, and count.",
        "ego = new Car on road, with speed 5 m/s\nmaximize largest(sqrt(ego.speed - 20 m/s))\n",
        "ego = new Car on road, with speed 5 m/s\nmaximize largest(sqrt(max(ego.speed - 20 m/s, 0 m/s)))\n",
        shown="while the scene runs",
    ),
)
NOBODY_ELSE = Problem(
    "SCN495",
    "`{name}` is a result of the ego and another, and the ego is alone",
    cure="add another object, or write what is meant of the ego: `largest(ego.speed)`",
    page=Page(
        "result of a pair without a pair",
        "Distances and speeds of approach are of the ego and whom it comes nearest to.",
        "ego = new Car on road, with speed 5 m/s\nminimize min_distance\n",
        "ego = new Car on road, with speed 5 m/s\nother = new Car ahead of ego by 9 m\nminimize min_distance\n",
    ),
)

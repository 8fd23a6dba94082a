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
        "Every run is a finding, so none of them is informative.",
        "limit = 3 m\nego = new Car on road, with speed 5 m/s\nexpect always limit > 4 m\n",
        "limit = 3 m\nego = new Car on road, with speed 5 m/s\nexpect always (distance to intersection) > limit\n",
    ),
)
AT_THE_START = warning(
    "SCN497",
    "this `expect` is checked only at the start",
    "without `always` or `eventually` a condition is checked once, before anything has moved",
    "write `expect always {condition}`",
    page=Page(
        "expectation that is checked only at the start",
        "A formula without a temporal operator applies to the first instant, so a run that ends in a collision keeps "
        "`expect not self.collided`. Write `always` for what must hold throughout the run, and `eventually` for what "
        "must hold at some time.",
        'ego = new Car on road, with speed 5 m/s\nexpect not self.collided as "no contact"\n',
        'ego = new Car on road, with speed 5 m/s\nexpect always not self.collided as "no contact"\n',
    ),
)
TAKEN_NAME = Problem(
    "SCN492",
    "`{name}` is the name of a built-in objective",
    "the name would be ambiguous",
    "choose another name",
    page=Page(
        "objective with a name that is taken",
        "`risk`, `avoidable`, `conflict`, `severity`, `injury` and `controller` are objectives that every file has; an "
        "`expect`, `maximize` or `minimize` of the file needs another name.",
        'ego = new Car on road, with speed 5 m/s\nexpect always ego.speed < 9 m/s as "risk"\n',
        'ego = new Car on road, with speed 5 m/s\nexpect always ego.speed < 9 m/s as "speed"\n',
    ),
)
NOT_ONE_LINE = Problem(
    "SCN498",
    "the name of an objective must be one line of text",
    "tables, `--objective` and the journal show it as it is, and `{name}` contains characters that are not printable",
    "leave out line breaks and control characters",
    page=Page(
        "objective whose name cannot be shown",
        "The name appears in tables, in the manifest of a run and on the command line. A line break or a control "
        "character would break these, or control the terminal.",
        'ego = new Car on road, with speed 5 m/s\nexpect always ego.speed < 9 m/s as "top\\nspeed"\n',
        'ego = new Car on road, with speed 5 m/s\nexpect always ego.speed < 9 m/s as "top speed"\n',
    ),
)
NOT_ONE_NUMBER = Problem(
    "SCN493",
    "this changes during the run, but `{sense}` needs a single number",
    "a run has many values of it, one for each sample",
    "reduce them to one: `largest(...)`, `least(...)`, `final(...)`, `mean(...)` or `total(...)`",
    page=Page(
        "objective that is not a single number",
        "`maximize` and `minimize` compare runs, so each run must have one number. A reducer computes it from all "
        "samples; results such as `delta_v` are already a single number.",
        "ego = new Car on road, with speed 5 m/s\nmaximize ego.speed\n",
        "ego = new Car on road, with speed 5 m/s\nmaximize largest(ego.speed)\n",
    ),
)
NOT_JUDGED = Problem(
    "SCN494",
    "`collided` is available only for the ego, in `expect`, `maximize` and `minimize`",
    "the ego's first contact ends the run, so nothing in the run can see it",
    "write `expect always not self.collided`",
    page=Page(
        "contact tested where nothing can see it",
        "A run ends at the ego's first contact, and objectives include that instant. Requirements, behaviors and "
        "monitors see only the samples before it; for other actors, `X intersects Y` tells whether they touch.",
        "ego = new Car on road, with speed 5 m/s\nterminate when ego.collided\n",
        "ego = new Car on road, with speed 5 m/s\nexpect always not ego.collided\n",
    ),
)
NO_NUMBER = Problem(
    "SCN496",
    "`{name}` is not a number in this run",
    "{reason}",
    "keep it defined with `max`, `min` or `... if ... else ...`",
    page=Page(
        "objective that is not a number",
        "The root or logarithm of a negative number and 0 / 0 have no value. Such a run is an error: it counts neither "
        "as kept nor as broken. Anything else divided by 0, and the logarithm of 0, are infinite, and count.",
        "ego = new Car on road, with speed 5 m/s\nmaximize largest(sqrt(ego.speed - 20 m/s))\n",
        "ego = new Car on road, with speed 5 m/s\nmaximize largest(sqrt(max(ego.speed - 20 m/s, 0 m/s)))\n",
        shown="while the scene runs",
    ),
)
NOBODY_ELSE = Problem(
    "SCN495",
    "`{name}` is a result of the ego and another object, but the ego is alone",
    cure="add another object, or use a value of the ego alone, as in `largest(ego.speed)`",
    page=Page(
        "result of a pair without a pair",
        "Distances and speeds of approach are those of the ego and the object that it comes nearest to.",
        "ego = new Car on road, with speed 5 m/s\nminimize min_distance\n",
        "ego = new Car on road, with speed 5 m/s\nother = new Car ahead of ego by 9 m\nminimize min_distance\n",
    ),
)

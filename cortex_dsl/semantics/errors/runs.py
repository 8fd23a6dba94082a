"""Rows of SCN6xx, SCN49x and SCN241 to SCN243: behaviors, monitors, scenarios that start scenarios, and objectives."""

from cortex_dsl.semantics.errors.problems import Problem, note, warning

# -- SCN6xx: behaviors -------------------------------------------------------------------------------------------------

RECURSIVE = Problem(
    "SCN601",
    "the behavior `{name}` runs itself: {cycle}",
    cure="use `while True:` to repeat",
)
NEVER_ACTS = Problem(
    "SCN602",
    "this {what} never acts",
    "it would loop forever within one step",
    "add {words} to it",
)
IDLE_BEHAVIOUR = warning(
    "SCN603",
    "the behavior `{name}` never acts",
    "the object just coasts",
    "add `take` or `do`",
)
NOT_A_BEHAVIOUR = Problem(
    "SCN604",
    "`do` needs a behavior, but this is {actual}",
    cure="{cure}",
)
LEAVES_WRITTEN_OUT = Problem(
    "SCN615",
    "`break` and `continue` need a loop over numbers",
    "a loop over anything else is unrolled when the file is compiled",
    "loop over numbers, as in `for i in range(3)`, or write `while`",
)
NOT_AN_ACTION = Problem(
    "SCN605",
    "`take` needs an action, but this is {actual}",
    cure="{suggestion}",
)
SAME_ACTION = Problem(
    "SCN606",
    "`take` sets the {command} twice",
    cure="keep one of the two",
)
OBJECT_CHANGES = Problem(
    "SCN607",
    "`{name}` cannot become another {kind} during the run",
    "only numbers and truth values can change while a behavior runs",
    "use two variables",
)
CANNOT_SET = Problem(
    "SCN617",
    "`{name}` cannot be set",
    "{reason}",
    "properties of your own, as in `with laps 0`, can be set while a behavior runs",
)
DIMENSION_CHANGES = Problem(
    "SCN608",
    "`{name}` was {before} and cannot become {after}",
    cure="use another name",
)
ONLY_WHILE_RUNNING = Problem(
    "SCN609",
    "{what} is only known during the run",
    cure="use it in a behavior",
)
OBSTACLE_BEHAVIOUR = Problem(
    "SCN610",
    "an Obstacle cannot have a behavior",
    cure="use a Car or a Pedestrian",
)
CALLED_BEHAVIOUR = Problem(
    "SCN611",
    "a behavior does nothing when it is only called",
    cure="write `do {name}(...)`",
)
MAY_NOT_ACT = warning(
    "SCN612",
    "this loop may repeat without acting",
    "if none of its branches acts, time stands still, nothing can change, and the run fails",
    "add a `wait` in an `else:`, or at the end of the loop",
)
TOO_MANY_BODIES = Problem(
    "SCN613",
    "behaviors and scenarios are expanded more than {limit} times",
    "each `do` is replaced by what it runs, and here they multiply",
    "let each run fewer of the others: a `while` repeats one without expanding it again",
)
DEEP_BY_RUNNING = (
    ", counting those of the behaviors and scenarios that run it",
    "each `do` is replaced by what it runs",
    "let one behavior `do` several after one another, instead of each the next",
)
DEEP_BY_BRANCHES = (
    ": there are too many `elif`",
    "each `elif` is nested in the `else` of the one before it",
    "split the cases first, `if x < 30: … else: …`, and put the finer `if` inside each; or compute the result directly",
)
"""Addition to the message, reason and cure."""
TOO_DEEP_BODIES = Problem(
    "SCN614",
    "this block is nested more than {limit} blocks deep{counted}",
    "{reason}",
    "{cure}",
)


LANE_OF_THE_RUN = Problem(
    "SCN630",
    "a lane that is known only during the run has no `{name}`",
    "an object may change lanes during the run, so the compiler cannot list what depends on its lane",
    "{suggestion}",
)


NOT_A_DRIVER = Problem(
    "SCN631",
    "`{behaviour}` is for vehicles, but this is {actual}",
    cure="give it to a Car or another vehicle",
)

NO_INTERSECTION = Problem(
    "SCN632",
    "this trajectory crosses no intersection",
    "no other traffic crosses or joins it",
    "lead it through one, as in `[maneuver.startLane, maneuver.connectingLane, maneuver.endLane]`",
)


WALKS_IN_LANE = warning(
    "SCN633",
    "this Pedestrian walks in the middle of the lane, like a car",
    "`{behaviour}` follows lanes",
    "to cross the road write `CrossingBehavior(ego)`, to walk straight on `WalkForwardBehavior()`, and turn the walker "
    "with `facing`",
)

CONTROLLED_TWICE = Problem(
    "SCN634",
    "the controller `{name}` already drives something else",
    "a controller drives one object, in one way",
    'name another one, as in `ExternalBehavior(controller="other")`',
)

OVER_THE_EDGE = warning(
    "SCN635",
    "at an offset of {offset} this {name} extends over the edge of its lane",
    "it is {width} wide, and {lanes} {lane} wide",
    "an offset of at most {most} keeps all of it inside the lane",
)

# -- SCN241 to SCN243, SCN65x: scenarios made of scenarios -------------------------------------------------------------

UNKNOWN_SCENARIO = Problem(
    "SCN241",
    "this file has no scenario `{name}`",
    cure="{suggestion}",
)
WHICH_SCENARIO = Problem(
    "SCN242",
    "which of these scenarios should run: {names}?",
    "none is called `Main`",
    "name one with `--scenario NAME`, or call one `Main`",
)
NEEDS_ARGUMENTS = Problem(
    "SCN243",
    "the scenario `{name}` cannot run by itself",
    "its parameter `{parameter}` has no default",
    "give it a default, or start the scenario from another one",
)
NOT_A_SCENARIO = Problem(
    "SCN650",
    "`do` in a `compose` needs a scenario, but this is {actual}",
    cure="{cure}",
)
NOT_STARTED = Problem(
    "SCN651",
    "the scenario `{name}` has not been started yet",
    "its variables exist once its setup has run",
    "use them below the `do` that starts it",
)
STARTED_TWICE = Problem(
    "SCN652",
    "this scenario is started twice",
    "its objects were made the first time",
    "call it again, as in `do {name}(...)`, for objects of its own",
)
MADE_AGAIN = Problem(
    "SCN653",
    "the scenario `{name}` makes objects, but may be started more than once here",
    "all objects of a run are known before it begins",
    "start it outside the loop, or make its objects in the scenario that starts it and pass them as arguments",
)
TOO_MANY_APPEAR = Problem(
    "SCN661",
    "more than {limit} appear during the run",
    "each has a behavior of its own in the program; a behavior may make an object that makes another one",
    "let fewer objects appear, or a smaller `late` of `simulation`",
)
LATER_PLACE = Problem(
    "SCN654",
    "where `{name}` will be when this scenario starts is not known",
    "objects are placed before the run, and this scenario may start later",
    "place the object itself so, as in `new Car ahead of {name} by 9 m`, or start the scenario first in `compose`",
)
SCENARIO_CYCLE = Problem(
    "SCN655",
    "the scenario `{name}` starts itself: {cycle}",
    cure="use `while True:` to repeat",
)
CANNOT_OVERRIDE = Problem(
    "SCN656",
    "`{name}` cannot be overridden {here}",
    "{reason}",
    "{cure}",
)
LATER_TEMPORAL = Problem(
    "SCN657",
    "`{statement}` cannot be used in a scenario that another one starts",
    "{reason}",
    "{cure}",
)
SCENARIO_USED = Problem(
    "SCN658",
    "the scenario `{name}` is used like a behavior",
    "it sets up objects and runs beside them",
    "write `do {name}(...)` in the `compose` of another scenario",
)
SETTLED_ARGUMENT = Problem(
    "SCN660",
    "the argument `{name}` of a scenario cannot depend on the run",
    "objects are set up before the run begins",
    "use a value that is fixed with the scene: a number, a param, a draw, an object",
)
SETTING_IN_SCENARIO = Problem(
    "SCN659",
    "`{statement}` cannot be used in a scenario",
    "{reason}",
    "move it to the top level",
)

# -- SCN62x: monitors, guards, and choices among behaviors -------------------------------------------------------------


NOT_A_MONITOR = Problem(
    "SCN620",
    "`require monitor` needs a monitor, but this is {actual}",
    cure="{cure}",
)
MONITOR_ACTS = Problem(
    "SCN621",
    "a monitor cannot `{statement}`",
    "it watches the run and drives no object",
    "what an object does belongs in a behavior; a monitor has `require`, `wait`, `terminate` and variables",
)
MONITOR_USED = Problem(
    "SCN622",
    "the monitor `{name}` is used like a behavior",
    "it runs beside the scenario and drives no object",
    "write `require monitor {name}(...)` at the top level",
)
UNUSED_MONITOR = warning(
    "SCN623",
    "the monitor `{name}` is never required",
    cure="write `require monitor {name}(...)`, or remove it",
)
LOOKS_ONCE = warning(
    "SCN624",
    "the monitor `{name}` never waits",
    "it checks the first sample and then ends",
    "put its body in `while True:`, with a `wait` at the end",
)
DO_SEVERAL = Problem(
    "SCN625",
    "`do` runs one behavior at a time",
    "an object does one thing at a time",
    "write one `do` after the other, `do choose` for one of them, or `do shuffle` for all in random order",
)
ONE_OPTION = warning(
    "SCN626",
    "`do {mode}` has only one option",
    "nothing is left to chance",
    "write `do` alone, or add options",
)
NO_WEIGHT = Problem(
    "SCN627",
    "{what}",
    "then no option can be taken",
    "as in `do {mode} {{A(): 1, B(): 2}}`",
)
GUARD_NEVER = warning(
    "SCN628",
    "this {guard} can never hold",
    "every run that starts `{name}` here is aborted",
    "change the {guard}, or the arguments of the behavior",
)

# -- SCN49x: what a file expects, maximizes and minimizes --------------------------------------------------------------

NEVER_BROKEN = warning(
    "SCN490",
    "this `expect` can never be broken",
    "its condition is known to be true in every run",
    "remove it, or change its condition",
)
ALWAYS_BROKEN = warning(
    "SCN491",
    "this `expect` is broken in every run",
    "its condition is known to be false",
    "change its condition",
)
AT_THE_START = warning(
    "SCN497",
    "this `expect` is checked only at the start",
    "without `always` or `eventually` a condition is checked once, before anything has moved",
    "write `expect always {condition}`",
)
TAKEN_NAME = Problem(
    "SCN492",
    "`{name}` is the name of a built-in objective",
    "the name would be ambiguous",
    "choose another name",
)
NOT_ONE_LINE = Problem(
    "SCN498",
    "the name of {what} must be one line of text",
    "tables, `--objective` and the journal show it as it is, and `{name}` contains characters that are not printable",
    "leave out line breaks and control characters",
)
NOT_ONE_NUMBER = Problem(
    "SCN493",
    "this changes during the run, but `{sense}` needs a single number",
    "a run has many values of it, one for each sample",
    "reduce them to one: `largest(...)`, `least(...)`, `final(...)`, `mean(...)` or `total(...)`",
)
NOT_JUDGED = Problem(
    "SCN494",
    "`collided` is available only for the ego, in `expect`, `maximize` and `minimize`",
    "the ego's first contact ends the run, so nothing in the run can see it",
    "write `expect always not self.collided`",
)
NO_NUMBER = Problem(
    "SCN496",
    "`{name}` is not a number in this run",
    "{reason}",
    "keep it defined with `max`, `min` or `... if ... else ...`",
)
NOBODY_ELSE = Problem(
    "SCN495",
    "`{name}` is a result of the ego and another object, but the ego is alone",
    cure="add another object, or use a value of the ego alone, as in `largest(ego.speed)`",
)

# -- SCN486 to SCN489, SCN499: domains ---------------------------------------------------------------------------------

CELLS_UNKNOWN = Problem(
    "SCN486",
    "the cells of a domain must be known before the run",
    "{reason}",
    "write them as constants, as in `5 m steps from 0 m to 50 m`, `[0, 1]` or `[(0 m, 2 m), (2 m, 9 m)]`",
)
CELLS_OVERLAP = Problem(
    "SCN487",
    "two cells of this domain overlap: `{one}` and `{other}`",
    "a value in both would be counted twice",
    "let each cell begin where another one ends",
)
NO_CELLS = Problem(
    "SCN488",
    "this domain has no cells that can be used",
    "{reason}",
    "write steps as in `5 m steps from 0 m to 50 m`, values as in `[0, 1]`, or intervals as in `[(0 m, 2 m)]`",
)
SHORT_CELL = note(
    "SCN489",
    "the steps do not divide the range, so the last cell is shorter",
    "the steps are {step} wide, the last cell {rest}",
    "change the step or the range if all cells should have one width",
)
DOMAIN_DRAWS = Problem(
    "SCN499",
    "a domain cannot draw random values",
    "it changes neither scenes nor runs, so it looks at values that the file has",
    "give the random value a name, and write that name in the domain",
)

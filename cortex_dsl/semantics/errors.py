"""Every finding of this stage, declared once. SCN2xx names, 3xx units and types, 4xx values and meaning, 5xx random
structure, 6xx behaviours.
"""

from cortex_dsl.semantics.problems import Problem, note, warning

# -- names ------------------------------------------------------------------------------------------------------------
UNKNOWN_NAME = Problem("SCN201", "nothing is called `{name}` here", cure="{suggestion}")
USED_BEFORE = Problem(
    "SCN202", "`{name}` is used before it has a value", "it is assigned further down", "move the assignment up"
)
UNKNOWN_ATTRIBUTE = Problem("SCN203", "{kind} has no `{name}`", cure="{suggestion}")
UNKNOWN_PROPERTY = Problem("SCN204", "{kind} has no property `{name}`", cure="{suggestion}")
UNKNOWN_ARGUMENT = Problem("SCN205", "`{function}` takes no argument `{name}`", cure="{suggestion}")
UNKNOWN_PARAM = Problem("SCN206", "no param is called `{name}`", cure="{suggestion}")
UNKNOWN_CLASS = Problem("SCN207", "there is no class `{name}`", cure="{suggestion}")
UNKNOWN_OVERRIDE = Problem("SCN208", "`-p` names a param that this file does not have: `{name}`", cure="{suggestion}")
DUPLICATE = Problem("SCN210", "{what} `{name}` is defined twice", "only one can be meant", "rename one")
UNUSED_BEHAVIOUR = note("SCN220", "the behavior `{name}` is never used", cure="remove it, or give it to an object")
UNUSED_GENE = warning(
    "SCN221",
    "the param `{name}` is never used",
    "a search would vary it without any effect",
    "use it, or remove it",
)

# -- units and types --------------------------------------------------------------------------------------------------
DIMENSION_MISMATCH = Problem("SCN301", "{what} must be {expected}, but this is {actual}", cure="{cure}")
UNLIKE_OPERANDS = Problem(
    "SCN302",
    "{left} and {right} cannot be {joined}",
    "both sides must have the same dimension",
    "{cure}",
)
WRONG_KIND = Problem("SCN303", "{what} must be {expected}, but this is {actual}", cure="{cure}")
NO_OPERATOR = Problem("SCN304", "`{operator}` does not work on {left} and {right}")
UNKNOWN_UNIT = Problem("SCN305", "there is no unit `{unit}`", cure="{suggestion}")
TWO_UNITS = Problem(
    "SCN306", "this value has a unit twice", "the values inside already are {kind}", "write the unit in one place"
)
NOT_CALLABLE = Problem("SCN307", "{kind} cannot be called")
TOO_FEW_ARGUMENTS = Problem("SCN308", "`{function}` needs {missing}", cure="as in `{signature}`")
TOO_MANY_ARGUMENTS = Problem("SCN309", "`{function}` takes {count}, but got {given}", cure="as in `{signature}`")
POWER_NOT_CONSTANT = Problem(
    "SCN310",
    "the exponent of {what} must be a known whole number",
    "else the dimension of the result would be unknown",
)
SUSPICIOUS_ANGLE = warning(
    "SCN320",
    "a bare {value:g} here is {value:g} rad, which is {turns:.1f} full turns",
    "angles without a unit are radians",
    "write `{value:g} deg` if degrees are meant",
)
SUSPICIOUS_SPEED = warning(
    "SCN321",
    "a bare {value:g} here is {value:g} m/s, which is {kmh:.4g} km/h",
    "speeds without a unit are metres a second",
    "write `km/h` behind the number if that is meant",
)

# -- values -----------------------------------------------------------------------------------------------------------
NOT_FINITE = Problem("SCN401", "this is not a finite number", "{reason}", "check the numbers in it")
OUT_OF_RANGE = Problem("SCN402", "{what} is {actual}, but must be {expected}", cure="{cure}")
MAY_LEAVE_RANGE = Problem(
    "SCN403", "{what} may become {actual}, but must be {expected}", "it is random or searched", "narrow its range"
)
NO_EGO = Problem(
    "SCN404",
    "no object is the ego",
    "every metric looks from the vehicle under test",
    "write `ego = new Car at ...`",
)
SELF_OUTSIDE = Problem(
    "SCN432", "`self` is only known in a behavior", "it is the object that the behavior drives", "name the object"
)
EGO_NOT_OBJECT = Problem("SCN405", "`ego` must be an object, but this is {actual}", cure="write `ego = new Car at ...`")
EGO_NEEDED = Problem(
    "SCN406", "{what} is measured from the ego, but there is none yet", cure="define `ego` above this line"
)
NO_PLACE = Problem(
    "SCN407",
    "this {name} has no place",
    cure="say where: `at (x, y)`, `in lane.centerline`, `on road`, `ahead of x by d`",
)
TWO_PLACES = Problem("SCN408", "this {name} is placed twice", "an object has one position", "remove one specifier")
TWO_HEADINGS = Problem("SCN409", "this {name} is turned twice", "an object has one heading", "remove one specifier")
PROPERTY_TWICE = Problem("SCN410", "the property `{name}` is given twice", cure="remove one")
BAD_MAP = Problem("SCN411", "this road cannot be built: {message}", cure="{cure}")
UNKNOWN_MAP = Problem("SCN412", "there is no map `{kind}`", cure="write `map intersection(ways=4, lanes=1)`")
MAP_TWICE = Problem("SCN413", "the map is given twice", "all objects share one road network", "remove one")
MAP_TOO_LATE = Problem(
    "SCN414", "the map comes after the road was used", cure="move the `map` line to the top of the file"
)
MAP_VARIES = Problem("SCN415", "the map depends on a random choice", cure="use constants in `map`")
NO_SINGLE_INTERSECTION = Problem(
    "SCN416",
    "`intersection` is ambiguous: this map has {count}",
    cure="choose one: `intersection = Uniform(*network.intersections)`",
)
NOT_CONNECTED = Problem(
    "SCN417",
    "lane {number} of the trajectory does not start where the one before it ends",
    "`{before}` leads to {follows}, not to `{after}`",
    "take the lanes of one maneuver: `[m.startLane, m.connectingLane, m.endLane]`",
)
EMPTY_TRAJECTORY = Problem("SCN418", "this trajectory has no lanes", cure="as in `[lane, maneuver.connectingLane]`")
NOT_ON_TRAJECTORY = Problem("SCN419", "the trajectory does not lead into {region}")
NO_TRAJECTORY = Problem(
    "SCN420", "`before` needs to know the way", cure="write `before intersection by 20 m along trajectory`"
)
TOO_FAR_BEFORE = Problem(
    "SCN421",
    "{actual} before {region} is not on the trajectory",
    "it starts {available} before",
    "use a longer `approach` in `map`, or a shorter distance",
)
PROBABILITY_RANGE = Problem(
    "SCN422",
    "the probability of a `require` is {actual}",
    "it must be above 0 and at most 1",
    "as in `require[0.8] x > 3 m`",
)
ALWAYS_FALSE = Problem(
    "SCN423", "this `require` can never hold", "it is false whatever is drawn", "change or remove it"
)
BAD_INDEX = Problem("SCN424", "there is no item {index}: the list has {count}", cure="count from 0")
BAD_UNPACKING = Problem("SCN425", "{names} names on the left, but {count} values on the right")
DIFFERENT_OBJECTS = Problem(
    "SCN426",
    "the objects of the scene depend on a random choice",
    "here they are {here}; with other choices {there}",
    "make the same objects whatever is chosen",
)
NOT_SUPPORTED = Problem("SCN427", "{what}", "{reason}", "{cure}")
BAD_SETTING = Problem(
    "SCN428",
    "`{name}` must be {expected}, but this is {actual}",
    "{reason}",
    'a search writes it, as in `stream="7.ga.0.3.12.0"`; leave it out to draw anew',
)
EMPTY_FILE = Problem("SCN429", "this file is empty", cure="start with `map intersection()` and `ego = new Car ...`")
CANNOT_ASSIGN = Problem("SCN430", "`{name}` cannot be assigned", "{reason}", "choose another name")
STATEMENT_PLACE = Problem("SCN431", "`{statement}` stands {here}, but belongs {there}")
BARE_EXPRESSION = warning("SCN440", "this value is not used", cure="assign it, or remove the line")
DEFAULT_MAP = note(
    "SCN441",
    "no `map`: an intersection of {ways} roads with one lane a direction is used",
    cure="write `map intersection(ways={ways}, lanes=1)` to say so",
)
SCENIC_MAP = note(
    "SCN442",
    "map files are not read: a gridded intersection is used instead",
    cure="add a line like `map intersection(ways={ways}, lanes=1)` to choose its shape",
)
SCENIC_MODEL = note(
    "SCN443",
    "`model` is not needed: the road and the vehicles are built in",
    "one meaning differs: absolute headings count anticlockwise from east here, in Scenic from north",
)
NO_EFFECT = note("SCN444", "`{name}` has no effect here", "{reason}")
EVERYTHING_TOO_FAR = warning(
    "SCN445",
    "some distances that this can take are not on the trajectory, which starts {available} before {region}",
    "up to {actual} can be drawn; such scenes are rejected",
    "narrow the range, or use a longer `approach` in `map`",
)

# -- random structure -------------------------------------------------------------------------------------------------
REVERSED_RANGE = Problem(
    "SCN501", "this range is reversed: {low} is above {high}", cure="write the lower bound first: {high}, {low}"
)
EMPTY_RANGE = Problem(
    "SCN502", "this range holds a single value: {low}", "nothing is random in it", "write the value itself, or widen it"
)
BAD_DEVIATION = Problem(
    "SCN503",
    "the standard deviation must be above 0, but is {actual}",
    cure="write the mean first, then the deviation: `Normal(0, 0.2)`",
)
NO_OPTIONS = Problem(
    "SCN504",
    "there is nothing to choose from in any variant",
    "{reason}",
    "widen the filter, or choose another map",
)
TOO_MANY_VARIANTS = Problem(
    "SCN505",
    "the finite choices of this file multiply to more than {limit} variants",
    "{sizes}",
    "choose from shorter lists, or fix some choices",
)
NOT_CONSTANT = Problem(
    "SCN506",
    "{purpose} must be known at compile time, but this depends on a draw, a param or the run",
    cure="use a constant, or a finite choice such as `DiscreteRange`",
)
GENE_BOUNDS = Problem(
    "SCN507",
    "the bounds of the param `{name}` are not constant",
    "a search needs a fixed box",
    "use numbers, or drop `param` to draw it anew for every scene",
)
GENE_VARIES = Problem(
    "SCN508", "the param `{name}` depends on a random choice", "a search needs a fixed box", "use numbers"
)
BAD_WEIGHTS = Problem("SCN509", "{message}", cure="write `Discrete({{a: 1, b: 2}})` with weights above 0")
NOT_WHOLE = Problem("SCN510", "{what} must be a whole number, but is {actual}", cure="round it")
MIXED_OPTIONS = Problem("SCN511", "the options are unlike: {left} and {right}", cure="give them all the same dimension")
FIXED_EXHAUSTED = Problem("SCN512", "`Fixed` was evaluated {count} times, but has {given} values")
RANDOM_WHILE_RUNNING = Problem(
    "SCN513",
    "objects cannot be chosen anew during the run",
    "lanes and other objects are settled with the scene",
    "choose outside the behavior and pass the choice as an argument",
)
NUISANCE_PARAM = note(
    "SCN520", "the param `{name}` is not searched", "{reason}", "use `Range` or `TruncatedNormal` to make it a gene"
)

# -- behaviours -------------------------------------------------------------------------------------------------------
RECURSIVE = Problem("SCN601", "the behavior `{name}` runs itself: {cycle}", cure="use `while True:` to repeat")
NEVER_ACTS = Problem(
    "SCN602",
    "this {what} never acts",
    "it would run round and round within one step",
    "add `take`, `wait` or `do` to it",
)
IDLE_BEHAVIOUR = warning("SCN603", "the behavior `{name}` never acts", "the object just rolls on", "add `take` or `do`")
NOT_A_BEHAVIOUR = Problem("SCN604", "`do` needs a behavior, but this is {actual}", cure="{cure}")
NOT_AN_ACTION = Problem("SCN605", "`take` needs an action, but this is {actual}", cure="{suggestion}")
SAME_ACTION = Problem("SCN606", "`take` sets the {command} twice", cure="keep one of the two")
OBJECT_CHANGES = Problem(
    "SCN607",
    "`{name}` cannot become another {kind} during the run",
    "only numbers and truth values can change while a behavior runs",
    "use two variables",
)
DIMENSION_CHANGES = Problem("SCN608", "`{name}` was {before} and cannot become {after}", cure="use another name")
ONLY_WHILE_RUNNING = Problem("SCN609", "{what} is only known during the run", cure="use it in a behavior")
OBSTACLE_BEHAVIOUR = Problem("SCN610", "an Obstacle cannot have a behavior", cure="use a Car or a Pedestrian")
CALLED_BEHAVIOUR = Problem("SCN611", "a behavior does nothing when it is only called", cure="write `do {name}(...)`")
NEVER_RUNS = warning(
    "SCN446", "this `terminate when` always holds", "the run ends at its first sample", "change or remove it"
)
BAD_OVERRIDE = Problem("SCN209", "`-p {name}=...` needs one value", cure='as in `-p {name}=50`, `-p "{name}=50 km/h"`')

TOO_DEEP = Problem(
    "SCN433",
    "this value is the result of more than {limit} operations in a row",
    "the program would become too large",
    "compute it in fewer steps",
)
TOO_MUCH_WORK = Problem(
    "SCN434",
    "this file takes too long to work out",
    "lists, lambdas and behaviors multiply to more than {limit} evaluations",
    "use shorter lists and ranges",
)
ENDLESS_LAMBDA = Problem("SCN435", "this lambda calls itself without end", cure="use a list instead of recursion")
LIST_TOO_LONG = Problem("SCN436", "this list has more than {limit} items", cure="use a shorter one")

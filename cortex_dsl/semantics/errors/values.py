"""Rows of SCN3xx, SCN5xx and parts of SCN4xx, SCN6xx: units, types, numbers, texts, lists, random values."""

from cortex_dsl.semantics.errors.problems import Problem, note, warning

# -- SCN3xx: units and types -------------------------------------------------------------------------------------------

DIMENSION_MISMATCH = Problem(
    "SCN301",
    "{what} must be {expected}, but this is {actual}",
    "a number with a unit has the dimension of the unit; a number without one takes the SI unit",
    "{cure}",
)
UNLIKE_OPERANDS = Problem(
    "SCN302",
    "{left} and {right} cannot be {joined}",
    "both sides must have the same dimension",
    "{cure}",
)
WRONG_KIND = Problem(
    "SCN303",
    "{what} must be {expected}, but this is {actual}",
    cure="{cure}",
)
NO_OPERATOR = Problem(
    "SCN304",
    "`{operator}` does not work on {left} and {right}",
    "arithmetic and comparisons of size need numbers",
    "{cure}",
)
UNKNOWN_UNIT = Problem(
    "SCN305",
    "there is no unit `{unit}`",
    cure="{suggestion}",
)
TWO_UNITS = Problem(
    "SCN306",
    "this value has a unit twice",
    "the values inside are already {kind}",
    "write the unit in one place",
)
NOT_CALLABLE = Problem(
    "SCN307",
    "{kind} cannot be called",
    cure="remove the brackets; an item of a list is taken with `[0]`",
)
TOO_FEW_ARGUMENTS = Problem(
    "SCN308",
    "`{function}` needs {missing}",
    cure="as in `{signature}`",
)
TOO_MANY_ARGUMENTS = Problem(
    "SCN309",
    "`{function}` takes {count}, but got {given}",
    cure="as in `{signature}`",
)
POWER_NOT_CONSTANT = Problem(
    "SCN310",
    "the exponent of {what} must be a known whole number",
    "otherwise the dimension of the result would be unknown",
    "write it as a number: `** 2`",
)
NEVER_EQUAL = warning(
    "SCN312",
    "{left} and {right} are never equal",
    "a text is equal only to another text",
    "{cure}",
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
    "speeds without a unit are metres per second",
    "write `km/h` after the number if that is meant",
)
SUSPICIOUS_LENGTH = warning(
    "SCN322",
    "a bare {value:g} here is {value:g} m, which is {kilometres:.4g} km",
    "lengths without a unit are metres, and most roads here are shorter",
    "write `{value:g} cm`, `{value:g} ft` or `{value:g} m`",
)
SUSPICIOUS_TIME = warning(
    "SCN323",
    "a bare {value:g} here is {value:g} s, which is {minutes:.4g} minutes",
    "times without a unit are seconds",
    "write `{value:g} ms` if milliseconds are meant",
)
SUSPICIOUS_ACCELERATION = warning(
    "SCN324",
    "a bare {value:g} here is {value:g} m/s^2, which is {gravities:.3g} g",
    "accelerations without a unit are metres per second squared; tyres on a dry road give 10",
    "write a unit after the number: `m/s^2` or `g`",
)
BARE_BESIDE_UNIT = warning(
    "SCN325",
    "a bare {value:g} beside a number in {unit} is {value:g} {si}, which is {converted:.4g} {unit}",
    "a number without a unit is in SI units, whatever unit its neighbour is written in",
    "write `{value:g} {unit}`, or `{value:g} {si}` if that is meant",
)

# -- SCN4xx: values, and the limits of evaluation ----------------------------------------------------------------------

NOT_FINITE = Problem(
    "SCN401",
    "this is not a finite number",
    "{reason}",
    "check the numbers in it",
)
OUT_OF_RANGE = Problem(
    "SCN402",
    "{what} is {actual}, but must be {expected}",
    cure="{cure}",
)
MAY_LEAVE_RANGE = Problem(
    "SCN403",
    "{what} may become {actual}, but must be {expected}",
    "it is random or searched",
    "narrow its range",
)
BAD_INDEX = Problem(
    "SCN424",
    "there is no item {index}: the list has {count}",
    "{reason}",
    "{cure}",
)
BAD_UNPACKING = Problem(
    "SCN425",
    "{names} names on the left, but {count} values on the right",
    cure="write one name for each value",
)


CANNOT_ASSIGN = Problem(
    "SCN430",
    "`{name}` cannot be assigned",
    "{reason}",
    "choose another name",
)
TOO_DEEP = Problem(
    "SCN433",
    "this value is the result of more than {limit} operations in a row",
    "the program would become too large",
    "compute it in fewer steps",
)
TOO_MUCH_WORK = Problem(
    "SCN434",
    "this file takes too long to evaluate",
    "loops, lists, functions and behaviors need more than {limit} evaluations",
    "end loops sooner, and use shorter lists and ranges",
)
ENDLESS_LAMBDA = Problem(
    "SCN435",
    "this function calls itself too deeply, or without end",
    cure="use a list instead of recursion",
)
LIST_TOO_LONG = Problem(
    "SCN436",
    "this list has more than {limit} items",
    cure="use a shorter one",
)
BAD_TRACK = Problem(
    "SCN457",
    "this track cannot be replayed: {reason}",
    cure="{cure}",
)

# -- SCN478, SCN479: quantities that are correct as numbers and probably not intended ----------------------------------

CONVERTED_TWICE = warning(
    "SCN478",
    "{kind} is converted from {start} to {end} by hand",
    "a quantity keeps its unit in arithmetic, so this changes its size and does not convert it",
    "leave the factor out; a bare number gets its unit where it is written, as in `50 km/h` or `30 deg`",
)
TARGET_ABOVE_TOP = note(
    "SCN479",
    "the target speed of {target} is above the top speed of this {name}, {top}",
    "no throttle takes it beyond that",
    "lower the target, or raise the top speed, as in `with topSpeed {enough}`",
)

# -- SCN55x, SCN681 to SCN683: fields, overrides, texts, and the size of regions and lists -----------------------------

NO_FIELD_AT = Problem(
    "SCN550",
    "the left side of `at` must be a field of directions, but this is {actual}",
    "`(FIELD at PLACE)` is the heading of the field at that place",
    "write `roadDirection`, or a `VectorField`, before `at`",
)
OVERRIDDEN_AND_SET = Problem(
    "SCN551",
    "`{name}` is overridden here and set by a behavior or a monitor",
    "its value after the scenario would be ambiguous",
    "use two properties, or set it only in the behavior",
)
LAYOUT = Problem(
    "SCN552",
    "`{layout}` is not a format for {kind}",
    "the part after the colon is read as in Python; widths have up to three digits",
    "as in `{{x:.2f}}` for a number, `{{n:03d}}` for a whole number, `{{name:>8}}` for a text",
)
LONG_TEXT = Problem(
    "SCN553",
    "this text has more than {limit} characters",
    "texts are built when the file is compiled, so their length is limited",
    "shorten it",
)
NO_NUMBER_IN_TEXT = Problem(
    "SCN554",
    "{text} is not a {kind}",
    "the text is converted as in Python",
    'write only a number in it, as in `int("3")` or `float("2.5")`',
)
NO_CLASS = Problem(
    "SCN555",
    "`isinstance` needs a class, but this is {actual}",
    "the classes are those that `new` accepts, and `int`, `float`, `str`, `list` and `tuple`",
    "write one of them, or several in brackets: `(Car, Truck)`",
)
LAST_ACTIONS = Problem(
    "SCN556",
    "the actions of the last step are not kept as a list",
    "actions are commands to the simulation, not values",
    "read their effect, `{name}.throttle`, `{name}.brake` or `{name}.steer`, or keep track of them yourself: "
    "`with braked 0`, and `self.braked = 1` beside the `take`",
)
MANY_REGIONS = Problem(
    "SCN681",
    "this region combines more than {limit} others",
    "each part is tested whenever the region is tested, as often as it occurs in it",
    "combine fewer, or write one `PolygonalRegion` around them",
)
EMPTY_REGION = Problem(
    "SCN682",
    "`{text}` contains no place",
    "it is empty, whatever is drawn",
    "move its parts so that they overlap, or name another region",
)
DEEP_LIST = Problem(
    "SCN683",
    "lists are nested more than {limit} deep",
    "lists are compared and printed from the inside out, so their depth is limited",
    "append the items instead: `xs + [x]`",
)

# -- SCN5xx: random values and choices ---------------------------------------------------------------------------------

TURNED_RANGE = note(
    "SCN515",
    "this range is reversed: it is read from {low} to {high}",
    "Scenic draws from a reversed range as if its bounds were in order",
)
REVERSED_RANGE = Problem(
    "SCN501",
    "this range is reversed: {low} is above {high}",
    cure="write the lower bound first: {high}, {low}",
)
EMPTY_RANGE = Problem(
    "SCN502",
    "this range contains a single value: {low}",
    "nothing is random in it",
    "write the value itself, or widen it",
)
NOTHING_TO_RESAMPLE = Problem(
    "SCN516",
    "`resample` needs a number that was drawn, but this is {actual}",
    "a constant, a sum or a param of the search is not drawn from one distribution",
    "write the distribution itself again",
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
    "{cure}",
)
LIST_AS_OPTION = Problem(
    "SCN514",
    "`Uniform` chooses among its arguments, but there is only one: a list",
    "it would always choose the whole list",
    "write a `*` in front of it: `Uniform(*{text})`",
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
    "use numbers, or drop `param` to draw it again for every scene",
)
GENE_VARIES = Problem(
    "SCN508",
    "the param `{name}` depends on a random choice",
    "a search needs a fixed box",
    "use numbers",
)
BAD_WEIGHTS = Problem(
    "SCN509",
    "{message}",
    cure="write `Discrete({{a: 1, b: 2}})` with weights above 0",
)
NOT_WHOLE = Problem(
    "SCN510",
    "{what} must be a whole number, but is {actual}",
    cure="round it",
)
MIXED_OPTIONS = Problem(
    "SCN511",
    "the options do not match: {left} and {right}",
    cure="give them all the same dimension",
)
FIXED_EXHAUSTED = Problem(
    "SCN512",
    "`Fixed` was evaluated {count} times, but has {given} values",
    cure="give it a value for each time, or draw with `Uniform(...)`",
)
RANDOM_WHILE_RUNNING = Problem(
    "SCN513",
    "objects cannot be chosen again during the run",
    "lanes and other objects are fixed with the scene",
    "choose outside the behavior and pass the choice as an argument",
)
NUISANCE_PARAM = note(
    "SCN520",
    "the param `{name}` is not searched",
    "{reason}",
    "use `Range` or `TruncatedNormal` to make it a gene",
)

# -- SCN53x: what is proved of a file before anything is drawn ---------------------------------------------------------

INFEASIBLE = Problem(
    "SCN530",
    "no scene can meet every requirement",
    "{reason}",
    "{cure}",
)
OFF_THE_ROAD = Problem(
    "SCN531",
    "`{name}` is not on the road",
    "at the start its whole outline must lie on the road, so every scene would be rejected",
    "put it in a lane, as in `in lane.centerline`, or turn it, as in `facing roadDirection`; to place it beside the "
    "road write `with regionContainedIn None`, and after `at` also `facing 90 deg`",
)
BESIDE_THE_ROAD = warning(
    "SCN533",
    "`{name}` cannot lie on the road at a place on `{word}`",
    "at the start its whole outline must lie on the road, up to the kerbs, so every scene would be rejected",
    "place it beside the kerb, as in `left of (new OrientedPoint on curb) by 0.2 m`, or let it stand there: `with "
    "regionContainedIn None`",
)
ON_TOP = Problem(
    "SCN532",
    "`{name}` overlaps `{other}`",
    "at the start no two outlines may overlap, so every scene would be rejected",
    "move one of them, as in `ahead of {other} by 5 m`; or write `with allowCollisions True` if this is intended",
)

# -- SCN69x: what only shows while a scene is drawn or runs ------------------------------------------------------------

STUCK = Problem(
    "SCN690",
    "this behavior never acts",
    "a behavior's turn ends with an action; until then the simulated time stands still",
    "`take` an action or `wait` in every loop",
)
UNDEFINED = Problem(
    "SCN691",
    "{what} is not a finite number in this scene",
    "{reason}",
    "narrow the ranges, or keep it finite, as in `sqrt(max(x, 0))` or `1 / x if x != 0 else 0`",
)

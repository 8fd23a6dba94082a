"""Rows of SCN4xx and SCN237 to SCN240: the map, its lights and lanes; objects, their places and classes."""

from cortex_dsl.semantics.errors.problems import Problem, note, warning

# -- SCN4xx: the ego, the places of objects and their trajectories -----------------------------------------------------

NO_EGO = Problem(
    "SCN404",
    "no object is the ego",
    "every metric is measured from the vehicle under test",
    "write `ego = new Car at ...`",
)
EGO_NOT_OBJECT = Problem(
    "SCN405",
    "`ego` must be an object, but this is {actual}",
    cure="write `ego = new Car at ...`",
)
EGO_NEEDED = Problem(
    "SCN406",
    "{what} is measured from the ego, but there is none yet",
    cure="define `ego` above this line",
)
NO_HEADING_YET = Problem(
    "SCN475",
    "beside a plain point, this {name} needs a heading of its own",
    "its sides follow from its heading, and its heading follows from its place",
    "give it a heading, as in `facing 90 deg`, or place it beside an oriented point",
)
NO_RELATION = Problem(
    "SCN472",
    "`relative to` cannot combine {left} with {right}",
    "one heading turns another, and a place lies in the frame of a single point or object",
    "take the heading of one of them: `x.heading relative to y`",
)
BAD_REGION = Problem(
    "SCN477",
    "{what} is not a valid region",
    "{reason}",
    "list its corners in order around it, or give it a size",
)
NOT_A_FIELD = Problem(
    "SCN473",
    "only a field of directions can be followed, but this is {actual}",
    "a path follows the lanes of the road, or a `VectorField`",
    "write `following roadDirection from x for 10 m`",
)
NOWHERE_UNSEEN = Problem(
    "SCN474",
    "`not visible` needs a region here",
    "the world is unbounded, so no place in it can be drawn",
    "name a region: `on not visible road`",
)
FASTER_THAN_TOP = Problem(
    "SCN437",
    "`speed` {may} {actual}, but the top speed of this {name} is {top}",
    "{reason}",
    "slow it down, or raise its top speed, as in `with topSpeed {cure}`",
)
NO_PLACE = Problem(
    "SCN407",
    "this {name} has no place",
    "only in files with a `model` line are people on sidewalks and crossings by default",
    "say where: `on sidewalk`, `at (x, y)`, `right of x by d`",
)
TWO_PLACES = Problem(
    "SCN408",
    "this {name} is placed twice",
    "an object has one position",
    "remove one specifier",
)
TWO_HEADINGS = Problem(
    "SCN409",
    "this {name} is given two headings",
    "an object has one heading",
    "remove one specifier",
)
PROPERTY_TWICE = Problem(
    "SCN410",
    "the property `{name}` is given twice",
    cure="remove one",
)
NOT_CONNECTED = Problem(
    "SCN417",
    "lane {number} of the trajectory does not start where the one before it ends",
    "{gap}",
    "{cure}",
)
EMPTY_TRAJECTORY = Problem(
    "SCN418",
    "this trajectory has no lanes",
    cure="as in `[lane, maneuver.connectingLane]`",
)
NOT_ON_TRAJECTORY = Problem(
    "SCN419",
    "the trajectory does not lead into {region}",
    cure="begin it with the lane that leads there, as in `[m.startLane, m.connectingLane]`",
)
NO_TRAJECTORY = Problem(
    "SCN420",
    "`{word}` needs a trajectory",
    cure="write `{word} intersection by 20 m along trajectory`",
)
TOO_FAR = Problem(
    "SCN421",
    "{actual} {word} {region} is not on the trajectory",
    "it {bounds} {available} {word}",
    "use {remedy}, or a shorter distance",
)
SELF_OUTSIDE = Problem(
    "SCN432",
    "`self` is only known in a behavior",
    "it is the object that the behavior drives",
    "name the object, such as `ego`",
)
EVERYTHING_TOO_FAR = warning(
    "SCN445",
    "some distances that this can take are not on the trajectory, which {bounds} {available} {word} {region}",
    "up to {actual} can be drawn; such scenes are rejected",
    "narrow the range, or use {remedy}",
)
NEVER_LEAVES = Problem(
    "SCN484",
    "the trajectory does not go through {region}",
    "`after` measures from where it leaves",
    "add the lane that leads through, and the one after it: `[m.startLane, m.connectingLane, m.endLane]`",
)
BAD_SEGMENT = Problem(
    "SCN517",
    "this is no valid `{word}`",
    "{reason}",
    "{cure}",
)
TOO_SHARP = Problem(
    "SCN469",
    "this path has a radius of {radius}, but the {name} turns no tighter than {least}",
    "`wheelbase` and `maxSteer` limit the radius of its rear axle",
    "give the path larger radii, or the object a larger `maxSteer`",
)
OTHER_SIDE = Problem(
    "SCN485",
    "a distance {word} {region} cannot be negative",
    "the other side of {region} has its own keyword",
    "write `{other} {region} by {distance} along …`",
)

# -- SCN237 to SCN240: classes and mutations ---------------------------------------------------------------------------


NEARLY_A_PROPERTY = warning(
    "SCN237",
    "`{name}` is not a built-in property",
    "only the file itself reads it",
    "did you mean `{match}`?",
)
PROPERTY_CYCLE = Problem(
    "SCN238",
    "the default of `{name}` depends on itself: {cycle}",
    cure="give one of them a value of its own",
)
CANNOT_MUTATE = Problem(
    "SCN239",
    "`mutate` needs an object, but `{name}` is {actual}",
    cure="{cure}",
)
MUTATED_ALIAS = Problem(
    "SCN240",
    "`{name}` is not the name under which the object was made",
    "`mutate` takes the name to which `new` was assigned",
    "use the name under which the object was made",
)

# -- SCN4xx: the map, and its traffic lights ---------------------------------------------------------------------------

BAD_MAP = Problem(
    "SCN411",
    "this road cannot be built: {message}",
    cure="{cure}",
)
UNKNOWN_MAP = Problem(
    "SCN412",
    "there is no map `{kind}`",
    cure="{suggestion}",
)
MAP_TWICE = Problem(
    "SCN413",
    "the map is given twice",
    "all objects share one road network",
    "remove one",
)
MAP_TOO_LATE = Problem(
    "SCN414",
    "the map comes after the road was used",
    cure="move the `map` line to the top of the file",
)
RUNS_DIFFER = Problem(
    "SCN415",
    "{what} depends on a draw, a param or a random choice",
    "all runs of a file have one map and the same settings",
    "use a constant",
)
NO_SINGLE_INTERSECTION = Problem(
    "SCN416",
    "`intersection` is ambiguous: this map has {count}",
    cure="choose one: `intersection = Uniform(*network.intersections)`",
)
NO_MAP_FILE = Problem(
    "SCN438",
    "there is no file `{file}` beside this one",
    "`map {kind}` reads the roads of {format} file",
    "put the file there, or give its path relative to this file",
)
BAD_MAP_FILE = Problem(
    "SCN439",
    "the roads of `{file}` cannot be read: {message}",
    cure="{cure}",
)
BAD_ORIGIN = Problem(
    "SCN468",
    "`origin` is latitude and longitude in degrees, but this is {actual}",
    "(0, 0) of the scenario lies there; a map has coordinates up to 80 degrees north and south",
    'as in `map lanelet2("town.osm", origin=(49.0, 8.4))`',
)
MAP_REMARK = note(
    "SCN449",
    "roads of `{file}`: {message}",
    cure="correct the file, or use only roads that this does not affect",
)
MAP_LEVELS = note(
    "SCN459",
    "map `{file}`: {message}",
    "actors whose roads are {level:g} m or more apart in height neither see, obstruct nor strike one another; slopes "
    "have no effect, and a bridge hides nothing",
    "where roads overlap, say on which one an object begins, as in `with level network.roads[0]`, or give a vehicle "
    "the heading of its road",
)
LOWER_LEVEL = note(
    "SCN467",
    "`{name}` begins on `{lower}`, {height:.1f} m below `{upper}`",
    "of several roads over one point the lowest is taken",
    'name the other one, as in `with level "{upper}"`',
)
MAP_UNREAD = note(
    "SCN466",
    "map `{file}`: {message}",
    cure="rely on nothing that these parts of the file state",
)
MAP_SIGNS = note(
    "SCN458",
    "map `{file}`: {what}",
    cure="{cure}",
)
MAP_WITHOUT_INTERSECTION = Problem(
    "SCN448",
    "this map has no intersection",
    cure="write `map intersection(ways=4, lanes=1)`, or place objects with `network.lanes`",
)
DEFAULT_MAP = note(
    "SCN441",
    "no `map`: an intersection of {ways} roads with {lanes} per direction is used",
    "{reason}",
    "write `{road}` to make it explicit",
)
SCENIC_MAP = note(
    "SCN442",
    "the map file is missing: a gridded intersection is used instead",
    "{reason}",
    "add a line like `{road}` to choose its shape",
)
SCENIC_MODEL = note(
    "SCN443",
    "`model` is not needed: the road and the vehicles are built in",
    "this file keeps Scenic's headings, which count from north; in files without `model` they count from east",
)

# -- Lanes during the run, library behaviors and traffic lights --------------------------------------------------------

NOT_ON_MAP = Problem(
    "SCN450",
    "this map has no `{name}`",
    "{reason}",
    "{cure}",
)
NO_SIGNALS = Problem(
    "SCN451",
    "{what} needs traffic lights, but nothing says what they show",
    cure="add a line like `signals(green=10 s, yellow=3 s)` after the map",
)
UNKNOWN_COLOUR = Problem(
    "SCN452",
    "no traffic light shows {actual}",
    cure="{suggestion}",
)
SIGNALS_UNUSED = warning(
    "SCN453",
    "no actor looks at the traffic lights",
    "they change nothing by themselves",
    "drive with `obey_signals=True`, or use `withinDistanceToRedYellowTrafficLight(self, 15)`",
)
SIGNALS_TWICE = Problem(
    "SCN454",
    "the traffic lights are given twice",
    "all intersections share one plan",
    "remove one",
)
ENVIRONMENT_TWICE = Problem(
    "SCN455",
    "the environment is given twice",
    "all objects share one weather",
    "write its arguments in one statement, as in `environment(friction=0.4, sight=60 m)`",
)
ENVIRONMENT_LATE = Problem(
    "SCN456",
    "the environment is set below `{name}`",
    "it decides how far objects see, and statements run in order",
    "move it above all objects",
)
SCENIC_SIGNALS = note(
    "SCN447",
    "the map's traffic lights follow a fixed plan: green 10 s, yellow 3 s, all red 2 s",
    cure="add a line like `signals(green=10 s, offset=5 s)` to choose its times",
)

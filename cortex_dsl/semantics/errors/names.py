"""SCN2xx: names."""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.errors.problems import Problem, hint, note, warning

UNKNOWN_NAME = Problem(
    "SCN201",
    "nothing is called `{name}` here",
    "a name is built in or defined above; upper and lower case differ",
    "{suggestion}",
    page=Page(
        "unknown name",
        "A name must be built in, or defined above this line. Upper and lower case differ.",
        "ego = new Car on road\nrequire eog.speed < 3 m/s\n",
        "ego = new Car on road\nrequire ego.speed < 3 m/s\n",
    ),
)
USED_BEFORE = Problem(
    "SCN202",
    "`{name}` is used before it has a value",
    "it is assigned further down",
    "move the assignment up",
    page=Page(
        "name used before it has a value",
        "A file is read from top to bottom. Only behaviors and `terminate when` see the names below them, because "
        "they run later.",
        "ego = new Car in lane.centerline\nlane = network.lanes[0]\n",
        "lane = network.lanes[0]\nego = new Car in lane.centerline\n",
    ),
)
UNKNOWN_ATTRIBUTE = Problem(
    "SCN203",
    "{kind} has no `{name}`",
    cure="{suggestion}",
    page=Page(
        "unknown attribute",
        "Lanes, maneuvers, objects and the road each have a fixed set of attributes.",
        "ego = new Car on road\nrequire ego.sped < 3 m/s\n",
        "ego = new Car on road\nrequire ego.speed < 3 m/s\n",
    ),
)
UNKNOWN_PROPERTY = Problem(
    "SCN204",
    "{kind} has no property `{name}`",
    "`with` sets a property of the class; another name would have no effect",
    "{suggestion}",
    page=Page(
        "unknown property",
        "`with` sets one of the properties that the class has. A misspelt one would otherwise change nothing.",
        "ego = new Car on road, with sped 5 m/s\n",
        "ego = new Car on road, with speed 5 m/s\n",
    ),
)
UNKNOWN_ARGUMENT = Problem(
    "SCN205",
    "`{function}` takes no argument `{name}`",
    cure="{suggestion}",
    page=Page(
        "unknown argument",
        "An argument given by name must have the name of a parameter of the function.",
        "ego = new Car on road, with behavior FollowLaneBehavior(target_sped=5 m/s)\n",
        "ego = new Car on road, with behavior FollowLaneBehavior(target_speed=5 m/s)\n",
    ),
)
UNKNOWN_PARAM = Problem(
    "SCN206",
    "no param is called `{name}`",
    cure="{suggestion}",
    page=Page(
        "unknown param",
        "`globalParameters` contains the params of this file and nothing else.",
        "param V = Range(1, 9) m/s\nego = new Car on road, with speed globalParameters.W\n",
        "param V = Range(1, 9) m/s\nego = new Car on road, with speed globalParameters.V\n",
    ),
)
UNKNOWN_CLASS = Problem(
    "SCN207",
    "there is no class `{name}`",
    cure="{suggestion}",
    page=Page(
        "unknown class",
        "`new` takes a class: a built-in one, or one that the file defines.",
        "ego = new Cra on road\n",
        "ego = new Car on road\n",
    ),
)
CLASS_ABOVE = "define it above this class, with `class NAME:`"
UNKNOWN_OVERRIDE = Problem(
    "SCN208",
    "`-p` names a param that this file does not have: `{name}`",
    cure="{suggestion}",
    page=Page(
        "`-p` names no param",
        "`-p NAME=VALUE` fixes the value of a param of the file. A misspelt name would otherwise change nothing.",
        "param V = Range(1, 9) m/s\nego = new Car on road, with speed V\n",
        "param V = Range(1, 9) m/s\nego = new Car on road, with speed V\n",
        options=("SPEED=5", "V=5"),
    ),
)
BAD_OVERRIDE = Problem(
    "SCN209",
    "`-p {name}=...` needs one value",
    cure='as in `-p {name}=50`, `-p "{name}=50 km/h"`',
    page=Page(
        "more or less than one value after `-p`",
        "The value of `-p NAME=VALUE` is one expression of the language.",
        "param V = Range(1, 9) m/s\nego = new Car on road, with speed V\n",
        "param V = Range(1, 9) m/s\nego = new Car on road, with speed V\n",
        options=("V=5 m/s; W=3", "V=5 m/s"),
    ),
)
DUPLICATE = Problem(
    "SCN210",
    "{what} `{name}` is defined twice",
    "the name would be ambiguous",
    "rename one",
    page=Page(
        "defined twice",
        "If two params, behaviors or arguments share a name, a use of the name is ambiguous.",
        "param V = Range(1, 9) m/s\nparam V = 5 m/s\nego = new Car on road, with speed V\n",
        "param V = Range(1, 9) m/s\nparam W = 5 m/s\nego = new Car on road, with speed max(V, W)\n",
    ),
)
UNUSED_BEHAVIOUR = warning(
    "SCN220",
    "the behavior `{name}` is never used",
    cure="remove it, or give it to an object",
    page=Page(
        "behavior never used",
        "A behavior runs only when an object has it, or when another behavior runs it with `do`.",
        "behavior Rest():\n    wait\n\nego = new Car on road\n",
        "behavior Rest():\n    wait\n\nego = new Car on road, with behavior Rest()\n",
    ),
)
UNUSED_GENE = warning(
    "SCN221",
    "the param `{name}` is never used",
    "a search would vary it without any effect",
    "use it, or remove it",
    page=Page(
        "param never used",
        "A search chooses a value for every param with a range. One that nothing reads adds a dimension without any "
        "effect.",
        "param V = Range(1, 9) m/s\nego = new Car on road\n",
        "param V = Range(1, 9) m/s\nego = new Car on road, with speed V\n",
    ),
)
SECOND_EGO = warning(
    "SCN212",
    "this is a second ego",
    "the vehicle under test is this one from here on; the first becomes one of the others",
    "give one of them another name, or `new` without a name",
    page=Page(
        "second ego",
        "A scenario has one vehicle under test. `ego` may be assigned to another object further down, as in Scenic, "
        "but usually a second car is meant.",
        "lane = network.lanes[0]\nego = new Car in lane.centerline\nego = new Car ahead of ego by 9 m\n",
        "lane = network.lanes[0]\nego = new Car in lane.centerline\nlead = new Car ahead of ego by 9 m\n",
    ),
)
SELF_AS_PARAMETER = Problem(
    "SCN213",
    "`self` is not a parameter of a {kind}",
    "{reason}",
    "leave it out of the brackets",
    page=Page(
        "`self` among the parameters",
        "In a behavior, `self` is the object that it drives; unlike in Python, it is not listed in the brackets, and a "
        "call gives only the other arguments. Monitors and scenarios drive no object.",
        "behavior Go(self, v):\n    do FollowLaneBehavior(v)\n\nego = new Car on road, with behavior Go(5 m/s)\n",
        "behavior Go(v):\n    do FollowLaneBehavior(v)\n\nego = new Car on road, with behavior Go(5 m/s)\n",
    ),
)
SHADOWS = hint(
    "SCN211",
    "`{name}` hides the built-in {kind} of that name",
    "the name has another meaning in this file than in all others",
    "choose another name",
    page=Page(
        "name of something built in",
        "A file may redefine the name, but a reader will take it for the built-in one.",
        "max = 9 m/s\nego = new Car on road, with speed max\n",
        "fastest = 9 m/s\nego = new Car on road, with speed fastest\n",
    ),
)
DEAD_GENE = warning(
    "SCN222",
    "the param `{name}` changes nothing",
    "it is used, but no object, requirement or behavior that runs depends on it, so a search would vary it in vain",
    "use it where it matters, or give it a constant value",
    page=Page(
        "dead param",
        "All uses of the param are in places that are never reached or that make no difference: a behavior "
        "that no object has, a product with 0, a branch that is already decided.",
        "param V = Range(1, 9) m/s\n\nbehavior Drive():\n    do FollowLaneBehavior(target_speed=V)\n\n"
        "ego = new Car on road\n",
        "param V = Range(1, 9) m/s\n\nbehavior Drive():\n    do FollowLaneBehavior(target_speed=V)\n\n"
        "ego = new Car on road, with behavior Drive()\n",
    ),
)
UNREAD_PROPERTY = note(
    "SCN226",
    "not read: {names}",
    "{reason}",
    "remove them, or keep them for Scenic: `# allow SCN226` ends this note",
    page=Page(
        "property that is not read",
        "Some properties of Scenic's objects have no effect on a run. They are accepted, so that scripts need no "
        "change, and are named here with the number of places.",
        "ego = new Car on road, with render False\n",
        "ego = new Car on road\n",
    ),
)
UNUSED_NAME = hint(
    "SCN223",
    "the {what} `{name}` is never read",
    cure="remove it, or start its name with `_` if this is intended",
    page=Page(
        "name that is never read",
        "A value that is computed and never used is often a mistake: another name was meant further down.",
        "gap = 9 m\nego = new Car on road\ncar = new Car ahead of ego by 5 m\n",
        "gap = 9 m\nego = new Car on road\ncar = new Car ahead of ego by gap\n",
    ),
)
UNUSED_CLASS = warning(
    "SCN224",
    "the class `{name}` has no objects",
    cure="write `new {name} ...`, or remove it",
    page=Page(
        "class never used",
        "A class describes its objects; without any it has no effect.",
        "class Taxi(Car):\n    width: 2 m\n\nego = new Car on road\n",
        "class Taxi(Car):\n    width: 2 m\n\nego = new Taxi on road\n",
    ),
)
UNUSED_SCENARIO = hint(
    "SCN225",
    "the scenario `{name}` is not part of this run",
    "`{entry}` runs and does not start it",
    "start it in a `compose:` with `do {name}()`, or run it alone with `--scenario {name}`",
    page=Page(
        "scenario that is not started",
        "When a file has several scenarios, one of them runs, with those that it starts.",
        "scenario Main():\n    setup:\n        ego = new Car on road\n\nscenario Traffic():\n    setup:\n"
        "        new Car on road\n",
        "scenario Main():\n    setup:\n        ego = new Car on road\n    compose:\n        do Traffic()\n\n"
        "scenario Traffic():\n    setup:\n        new Car on road\n",
    ),
)


# -- SCN230 to SCN236: imports -----------------------------------------------------------------------------------------

MISSING_IMPORT = Problem(
    "SCN230",
    "there is no file {path}",
    "imports are searched for beside the file that imports them",
    "{suggestion}",
    page=Page(
        "import of a missing file",
        "`import cars` reads `cars.scn` in the folder of the importing file, `import lib.cars` reads `lib/cars.scn`.",
        shown="while the imports of a file are read",
    ),
)


IMPORT_CYCLE = Problem(
    "SCN231",
    "this file imports itself: {cycle}",
    cure="move what both need into a file of its own",
    page=Page(
        "files that import each other",
        "An imported file is read to its end before the importing one continues, so two files cannot import each "
        "other.",
        shown="while the imports of a file are read",
    ),
)


TOO_MANY_IMPORTS = Problem(
    "SCN232",
    "more than {limit} files are imported",
    cure="join small files",
    page=Page(
        "too many imports",
        "There is a limit on the number of imported files, so that a mistake cannot keep the compiler reading.",
        shown="while the imports of a file are read",
    ),
)


UNREADABLE_IMPORT = Problem(
    "SCN233",
    "cannot read `{name}`: {reason}",
    cure="check the file and its permissions",
    page=Page(
        "import that cannot be read",
        "The file exists, but the system does not allow it to be read.",
        shown="while the imports of a file are read",
    ),
)


NAMELESS_IMPORT = Problem(
    "SCN234",
    "`{path}` is not a single name",
    "an import gives its file a single name",
    "write `{statement} as {name}`",
    page=Page(
        "import without a name",
        "The definitions of a file are reached through a single name. A path with dots or slashes needs `as`.",
        shown="when a path with dots is imported without `as`",
    ),
)


NOT_IN_FILE = Problem(
    "SCN235",
    "`{file}` defines no `{name}`",
    cure="{suggestion}",
    page=Page(
        "import of a missing name",
        "`from FILE import NAME` imports a name that the file defines at its top level.",
        shown="when an imported file does not define the name",
    ),
)


NOT_IN_IMPORT = Problem(
    "SCN236",
    "an imported file cannot have `{statement}`",
    "{reason}",
    "move it into the file that is run",
    page=Page(
        "statement in an imported file",
        "An imported file provides definitions, params, objects and requirements. The road, the ego and the end of "
        "the run are decided by the file that is run.",
        shown="when an imported file has such a statement",
    ),
)

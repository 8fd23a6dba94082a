"""Rows of SCN2xx and part of SCN4xx: names, imports, and where a statement may stand and what it needs."""

from cortex_dsl.semantics.errors.problems import Problem, hint, note, warning

# -- SCN2xx: names -----------------------------------------------------------------------------------------------------

UNKNOWN_NAME = Problem(
    "SCN201",
    "nothing is called `{name}` here",
    "a name is built in or defined above; upper and lower case differ",
    "{suggestion}",
)
USED_BEFORE = Problem(
    "SCN202",
    "`{name}` is used before it has a value",
    "it is assigned further down",
    "move the assignment up",
)
UNKNOWN_ATTRIBUTE = Problem(
    "SCN203",
    "{kind} has no `{name}`",
    cure="{suggestion}",
)
UNKNOWN_PROPERTY = Problem(
    "SCN204",
    "{kind} has no property `{name}`",
    "`with` sets a property of the class; another name would have no effect",
    "{suggestion}",
)
UNKNOWN_ARGUMENT = Problem(
    "SCN205",
    "`{function}` takes no argument `{name}`",
    cure="{suggestion}",
)
UNKNOWN_PARAM = Problem(
    "SCN206",
    "no param is called `{name}`",
    cure="{suggestion}",
)
UNKNOWN_CLASS = Problem(
    "SCN207",
    "there is no class `{name}`",
    cure="{suggestion}",
)
CLASS_ABOVE = "define it above this class, with `class NAME:`"
UNKNOWN_OVERRIDE = Problem(
    "SCN208",
    "`-p` names a param that this file does not have: `{name}`",
    cure="{suggestion}",
)
BAD_OVERRIDE = Problem(
    "SCN209",
    "`-p {name}=...` needs one value",
    cure='as in `-p {name}=50`, `-p "{name}=50 km/h"`',
)
DUPLICATE = Problem(
    "SCN210",
    "{what} `{name}` is defined twice",
    "the name would be ambiguous",
    "rename one",
)
UNUSED_BEHAVIOUR = warning(
    "SCN220",
    "the behavior `{name}` is never used",
    cure="remove it, or give it to an object",
)
UNUSED_GENE = warning(
    "SCN221",
    "the param `{name}` is never used",
    "a search would vary it without any effect",
    "use it, or remove it",
)
SECOND_EGO = warning(
    "SCN212",
    "this is a second ego",
    "the vehicle under test is this one from here on; the first becomes one of the others",
    "give one of them another name, or `new` without a name",
)
SELF_AS_PARAMETER = Problem(
    "SCN213",
    "`self` is not a parameter of a {kind}",
    "{reason}",
    "leave it out of the brackets",
)
SHADOWS = hint(
    "SCN211",
    "`{name}` hides the built-in {kind} of that name",
    "the name has another meaning in this file than in all others",
    "choose another name",
)
DEAD_GENE = warning(
    "SCN222",
    "the param `{name}` changes nothing",
    "it is used, but no object, requirement or behavior that runs depends on it, so a search would vary it in vain",
    "use it where it matters, or give it a constant value",
)
UNREAD_PROPERTY = note(
    "SCN226",
    "not read: {names}",
    "{reason}",
    "remove them, or keep them for Scenic: `# allow SCN226` ends this note",
)
UNUSED_NAME = hint(
    "SCN223",
    "the {what} `{name}` is never read",
    cure="remove it, or start its name with `_` if this is intended",
)
UNUSED_CLASS = warning(
    "SCN224",
    "the class `{name}` has no objects",
    cure="write `new {name} ...`, or remove it",
)
UNUSED_SCENARIO = hint(
    "SCN225",
    "the scenario `{name}` is not part of this run",
    "`{entry}` runs and does not start it",
    "start it in a `compose:` with `do {name}()`, or run it alone with `--scenario {name}`",
)


# -- SCN230 to SCN236: imports -----------------------------------------------------------------------------------------

MISSING_IMPORT = Problem(
    "SCN230",
    "there is no file {path}",
    "imports are searched for beside the file that imports them",
    "{suggestion}",
)


IMPORT_CYCLE = Problem(
    "SCN231",
    "this file imports itself: {cycle}",
    cure="move what both need into a file of its own",
)


TOO_MANY_IMPORTS = Problem(
    "SCN232",
    "more than {limit} files are imported",
    cure="join small files",
)


UNREADABLE_IMPORT = Problem(
    "SCN233",
    "cannot read `{name}`: {reason}",
    cure="check the file and its permissions",
)


NAMELESS_IMPORT = Problem(
    "SCN234",
    "`{path}` is not a single name",
    "an import gives its file a single name",
    "write `{statement} as {name}`",
)


NOT_IN_FILE = Problem(
    "SCN235",
    "`{file}` defines no `{name}`",
    cure="{suggestion}",
)


NOT_IN_IMPORT = Problem(
    "SCN236",
    "an imported file cannot have `{statement}`",
    "{reason}",
    "move it into the file that is run",
)

# -- SCN4xx: requirements and other statements -------------------------------------------------------------------------

PROBABILITY_RANGE = Problem(
    "SCN422",
    "the probability of a `require` is {actual}",
    "it must be above 0 and at most 1",
    "as in `require[0.8] x > 3 m`",
)
ASSERTION = Problem(
    "SCN476",
    "this assertion is false",
    "{reason}",
    "correct the values in it; write `require` for what random values must satisfy",
)
ALWAYS_FALSE = Problem(
    "SCN423",
    "this `require` can never hold",
    "it is false whatever is drawn",
    "change or remove it",
)
DIFFERENT_OBJECTS = Problem(
    "SCN426",
    "the objects of the scene depend on a random choice",
    "here they are {here}; with other choices {there}",
    "make the same objects whatever is chosen",
)
NOT_SUPPORTED = Problem(
    "SCN427",
    "{what}",
    "{reason}",
    "{cure}",
)
EMPTY_FILE = Problem(
    "SCN429",
    "this file is empty",
    cure="start with `map intersection()` and `ego = new Car ...`",
)
STATEMENT_PLACE = Problem(
    "SCN431",
    "`{statement}` is {here}, but belongs {there}",
    cure="{cure}",
)
NO_EFFECT = note(
    "SCN444",
    "`{name}` has no effect here",
    "{reason}",
)
NEVER_RUNS = warning(
    "SCN446",
    "this `terminate when` always holds",
    "the run ends at its first sample",
    "change or remove it",
)
ALWAYS_TRUE = warning(
    "SCN480",
    "this `require` always holds",
    "it rejects nothing, whatever is drawn or searched",
    "change or remove it",
)
WINDOW = hint(
    "SCN481",
    "`{name}` is drawn anywhere on its lane, and this keeps only a window of it",
    "all other scenes are drawn in vain, and count as invalid in a search",
    "write `{name} = new {kind} {place}` and remove this `require`; or `# allow SCN481` if the window is intended",
)
OVERRIDE_OUTSIDE = warning(
    "SCN482",
    "`-p {name}={value}` is outside the range of the param",
    "the file draws it between {low} and {high}",
    "choose a value in the range, or widen the range in the file",
)


BAD_SETTING = Problem(
    "SCN428",
    "`{name}` must be {expected}, but this is {actual}",
    "{reason}",
    'a search writes it, as in `stream="7.ga.0.3.12.0"`; leave it out to draw again',
)


NO_SYSTEM_PARAM = Problem(
    "SCN483",
    "`system` lists params of this file, but `{actual}` is not one",
    "they are the params of the system under test, which `--freeze` holds fixed",
    "{suggestion}",
)


BARE_EXPRESSION = warning(
    "SCN440",
    "this value is not used",
    cure="{cure}",
)

# -- SCN46x, SCN47x: requirements on the whole run, and what is recorded of it -----------------------------------------

TEMPORAL_PLACE = Problem(
    "SCN460",
    "`{operator}` cannot be used here",
    "it applies to a whole run, so only the condition of a `require` at the top level may contain it",
    "{cure}",
)
SOFT_TEMPORAL = Problem(
    "SCN461",
    "a temporal requirement cannot be soft",
    "`require[p]` is decided by chance for each scene, but this is about the run",
    "remove `[...]`",
)
TEMPORAL_HOLDS = warning(
    "SCN462",
    "this `require` holds in every run",
    "its condition is known to be true",
    "remove it, or change its condition",
)
NEVER_CHANGES = warning(
    "SCN463",
    "nothing in this condition changes during the run",
    "it is the same in all samples, so it is a condition on the scene alone",
    "write `require` without temporal operators: scenes in which it fails are then drawn again",
)
NO_END = hint(
    "SCN464",
    "this must come true within {limit:g} s",
    "a run of a file without `terminate after` lasts that long at most",
    "write `terminate after {limit:g} s`, or another time, to make the limit explicit",
)
CONTACT_UNSEEN = warning(
    "SCN465",
    "`{one}` and `{other}` can touch without breaking this",
    "{reason}",
    "to reject such runs write `({cure})`, which is as far as both move in two steps",
)
UNRECORDABLE = Problem(
    "SCN470",
    "{actual} cannot be recorded",
    "a record is a number, a truth value or a place",
    "{cure}",
)
RECORD_VARIES = Problem(
    "SCN471",
    "this record is {here} with some choices and {there} with others",
    "one column cannot hold both",
    "record them under two names",
)
NOT_ON_FOOT = Problem(
    "SCN680",
    "`{behaviour}` is for people on foot, but this is {actual}",
    "a vehicle moves where its wheels point",
    "write `SetSpeedAction` and `SetSteerAction`, or give it to a Pedestrian",
)

"""SCN23x, SCN240: imports, classes and mutations."""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.errors.problems import Problem, warning

_EGO = "ego = new Car on road, with speed 5 m/s\n"

# -- imports ----------------------------------------------------------------------------------------------------------

MISSING_IMPORT = Problem(
    "SCN230",
    "there is no file {path}",
    "imports are looked for beside the file that imports them",
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
        "An imported file is read to its end before the importing one goes on, which two files cannot do for each "
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
        "There is a limit on the number of imported files, so that a slip cannot keep the compiler reading.",
        shown="while the imports of a file are read",
    ),
)
UNREADABLE_IMPORT = Problem(
    "SCN233",
    "cannot read `{name}`: {reason}",
    cure="check the file and its permissions",
    page=Page(
        "import that cannot be read",
        "The file is there, but the system does not let it be read.",
        shown="while the imports of a file are read",
    ),
)
NAMELESS_IMPORT = Problem(
    "SCN234",
    "`{path}` is not one name",
    "an import gives its file one name",
    "write `{statement} as {name}`",
    page=Page(
        "import without a name",
        "What a file defines is reached through one name. A path with dots or slashes needs `as`.",
        shown="when a path with dots is imported without `as`",
    ),
)
NOT_IN_FILE = Problem(
    "SCN235",
    "`{file}` defines no `{name}`",
    cure="{suggestion}",
    page=Page(
        "import of a missing name",
        "`from FILE import NAME` takes a name that the file gives a value to at its top level.",
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
        "An imported file gives definitions, params, objects and requirements. The road, the ego and the end of the "
        "run are decided by the file that is run.",
        shown="when an imported file has such a statement",
    ),
)

# -- classes and mutations --------------------------------------------------------------------------------------------

NEARLY_A_PROPERTY = warning(
    "SCN237",
    "`{name}` is a property of the class alone",
    "nothing reads it but the file itself",
    "did you mean `{match}`?",
    page=Page(
        "property that may be misspelt",
        "A class may have properties of its own. One that is spelled almost like a built-in one is probably meant to "
        "be that.",
        f"class Taxi(Car):\n    widht: 1.7 m\n\n{_EGO}cab = new Taxi ahead of ego by 9 m\n",
        f"class Taxi(Car):\n    width: 1.7 m\n\n{_EGO}cab = new Taxi ahead of ego by 9 m\n",
    ),
)
PROPERTY_CYCLE = Problem(
    "SCN238",
    "the default of `{name}` needs itself: {cycle}",
    cure="give one of them a value of its own",
    page=Page(
        "property defaults in a circle",
        "A default may use other properties through `self`, as long as one of them comes first.",
        f"class Box:\n    width: self.length\n    length: self.width\n\n{_EGO}box = new Box ahead of ego by 9 m\n",
        f"class Box:\n    width: self.length\n    length: 2 m\n\n{_EGO}box = new Box ahead of ego by 9 m\n",
    ),
)
CANNOT_MUTATE = Problem(
    "SCN239",
    "`mutate` needs an object, but `{name}` is {actual}",
    cure="{cure}",
    page=Page(
        "mutation of no object",
        "`mutate` puts noise on the place and heading of objects.",
        f"D = 5 m\n{_EGO}mutate D\n",
        f"{_EGO}mutate ego\n",
    ),
)
MUTATED_ALIAS = Problem(
    "SCN240",
    "`{name}` was not made under this name",
    "`mutate` is told the name to which `new` was assigned",
    "name the object as where it was made",
    page=Page(
        "mutation by another name",
        "What is placed relative to a mutated object sees its mutated place, so the name must be that under which it "
        "is made.",
        f"{_EGO}other = ego\nmutate other\n",
        f"{_EGO}mutate ego\n",
    ),
)

"""SCN4xx: the map, and its traffic lights."""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.errors.problems import Problem, note, warning

BAD_MAP = Problem(
    "SCN411",
    "this road cannot be built: {message}",
    cure="{cure}",
    page=Page(
        "road that cannot be built",
        "Lanes, ways, radii and lengths must fit together; the message says which do not.",
        "map intersection(ways=5)\nego = new Car on road\n",
        "map intersection(ways=4)\nego = new Car on road\n",
    ),
)
UNKNOWN_MAP = Problem(
    "SCN412",
    "there is no map `{kind}`",
    cure="{suggestion}",
    page=Page(
        "unknown map",
        "A map is a grid of intersections, a road without any, a roundabout, or an OpenDRIVE file.",
        "map motorway()\nego = new Car on road\n",
        "map intersection(ways=4, lanes=1)\nego = new Car on road\n",
    ),
)
MAP_TWICE = Problem(
    "SCN413",
    "the map is given twice",
    "all objects share one road network",
    "remove one",
    page=Page(
        "two maps",
        "All objects share one road network.",
        "map intersection(ways=4)\nmap intersection(ways=3)\nego = new Car on road\n",
        "map intersection(ways=4)\nego = new Car on road\n",
    ),
)
MAP_TOO_LATE = Problem(
    "SCN414",
    "the map comes after the road was used",
    cure="move the `map` line to the top of the file",
    page=Page(
        "map after its use",
        "Lanes are looked up when they are named, so the map must be known by then.",
        "ego = new Car on road\nmap intersection(ways=3)\n",
        "map intersection(ways=3)\nego = new Car on road\n",
    ),
)
MAP_VARIES = Problem(
    "SCN415",
    "the map depends on a random choice",
    cure="use constants in `map`",
    page=Page(
        "map that is random",
        "A search compares scenes on one road network.",
        "map intersection(lanes=Discrete({1: 1, 2: 1}))\nego = new Car on road\n",
        "map intersection(lanes=2)\nego = new Car on road\n",
    ),
)
NO_SINGLE_INTERSECTION = Problem(
    "SCN416",
    "`intersection` is ambiguous: this map has {count}",
    cure="choose one: `intersection = Uniform(*network.intersections)`",
    page=Page(
        "ambiguous intersection",
        "`intersection` names the only intersection of a map; it is ambiguous where there are several.",
        "map intersection(cols=2)\nego = new Car on road\nrequire (distance from ego to intersection) < 5 m\n",
        "map intersection(cols=2)\n"
        "intersection = Uniform(*network.intersections)\n"
        "ego = new Car on road\n"
        "require (distance from ego to intersection) < 5 m\n",
    ),
)
NO_MAP_FILE = Problem(
    "SCN438",
    "there is no file `{file}` beside this one",
    "`map opendrive` reads the roads of an OpenDRIVE file",
    "put the file there, or give its path relative to this file",
    page=Page(
        "missing map file",
        "The path of the file is relative to the folder of the scenario.",
        'map opendrive("nowhere.xodr")\nego = new Car on road\n',
        "map road(length=500 m)\nego = new Car on road\n",
    ),
)
BAD_MAP_FILE = Problem(
    "SCN439",
    "the roads of `{file}` cannot be read: {message}",
    cure="{cure}",
    page=Page(
        "map file that cannot be read",
        "The file exists, but it is broken, too large, or has no lane that can be driven on.",
        shown="while the map is read",
    ),
)
MAP_REMARK = note(
    "SCN449",
    "roads of `{file}`: {message}",
    cure="correct the file, or use only roads that this does not affect",
    page=Page(
        "roads of a file, as they were read",
        "A file may contradict itself: links that lead nowhere, ends that do not meet, lanes that jump sideways. It is "
        "read as far as possible; what was corrected or left out is reported.",
        shown="while the map is read",
    ),
)
MAP_LEVELS = warning(
    "SCN459",
    "map `{file}`: {message}; lanes at different heights are treated as one plane",
    "heights are not simulated: actors on both roads see, obstruct and strike one another where the roads cross",
    "place actors on one of these roads only, or remove the other from the file",
    page=Page(
        "roads that pass over one another",
        "Lanes, outlines and views lie in one plane. Where a road of a file passes over another one, actors of both "
        "roads see, obstruct and strike each other, which is not true of a bridge.",
        shown="while the map is read",
    ),
)
MAP_UNREAD = note(
    "SCN466",
    "map `{file}`: {message}",
    cure="rely on nothing that these parts of the file state",
    page=Page(
        "parts of a map file that are not read",
        "A road file states more than a simulation uses: slopes, surfaces, objects. Each kind of element, and of "
        "attributes of one element, that is not read is listed with its count and its first line in the file. "
        "Names, dates, road marks and data of other programs change no result and are not listed.",
        shown="while the map is read",
    ),
)
MAP_SIGNS = note(
    "SCN458",
    "map `{file}`: {what}",
    cure="{cure}",
    page=Page(
        "traffic lights and signs of a file",
        "A road file says where traffic lights and signs stand, not what the lights show. A scenario can use them; "
        "drivers obey lights only where `signals(...)` says what they show, and never signs.",
        shown="while the map is read",
    ),
)
MAP_WITHOUT_INTERSECTION = Problem(
    "SCN448",
    "this map has no intersection",
    cure="write `map intersection(ways=4, lanes=1)`, or place objects with `network.lanes`",
    page=Page(
        "no intersection",
        "`intersection` names the only intersection of the map. A lone road has none.",
        "map road(length=500 m)\nego = new Car on road\nrequire (distance from ego to intersection) < 5 m\n",
        "map intersection(approach=50 m)\nego = new Car on road\nrequire (distance from ego to intersection) < 5 m\n",
    ),
)
DEFAULT_MAP = note(
    "SCN441",
    "no `map`: an intersection of {ways} roads with {lanes} per direction is used",
    "{reason}",
    "write `{road}` to make it explicit",
    page=Page(
        "map not given",
        "A file that names no map runs on one intersection; naming it makes the file complete.",
        "ego = new Car on road\n",
        "map intersection(ways=4, lanes=1)\nego = new Car on road\n",
    ),
)
SCENIC_MAP = note(
    "SCN442",
    "the map file is missing: a gridded intersection is used instead",
    "{reason}",
    "add a line like `{road}` to choose its shape",
    page=Page(
        "missing map file of a Scenic file",
        "Scenic files name a map of CARLA or OpenDRIVE. Where that file is not beside them, the road is a grid of "
        "intersections.",
        "param map = localPath('Town05.xodr')\nego = new Car on road\n",
        "map intersection(ways=4, lanes=1)\nego = new Car on road\n",
    ),
)
SCENIC_MODEL = note(
    "SCN443",
    "`model` is not needed: the road and the vehicles are built in",
    "this file keeps Scenic's headings, which count from north; in files without `model` they count from east",
    page=Page(
        "`model` line",
        "Scenic files name the simulator whose classes they use. Here these classes are built in.",
        "model scenic.simulators.carla.model\nego = new Car on road\n",
        "ego = new Car on road\n",
    ),
)

# -- Lanes during the run, library behaviors and traffic lights --------------------------------------------------------

NOT_ON_GRID = Problem(
    "SCN450",
    "roads here have no `{name}`",
    "they consist of lanes and intersections only, also in a map file",
    "place people with `right of ego by 3` or `at (x, y)`, and `with regionContainedIn None`",
    page=Page(
        "not part of a road",
        "Scenic's maps know sidewalks, kerbs, shoulders and crossings; roads here have lanes and intersections.",
        "ego = new Car on road\nnew Pedestrian on network.sidewalks[0]\n",
        "ego = new Car on road\nnew Pedestrian right of ego by 2, with regionContainedIn None\n",
    ),
)
NO_SIGNALS = Problem(
    "SCN451",
    "{what} needs traffic lights, but nothing says what they show",
    cure="add a line like `signals(green=10 s, yellow=3 s)` after the map",
    page=Page(
        "no traffic lights",
        "Traffic lights show something only where the scenario has `signals(...)`; a map file may say where they "
        "stand.",
        "ego = new Car on road, with behavior FollowLaneBehavior(obey_signals=True)\n",
        "signals()\nego = new Car on road, with behavior FollowLaneBehavior(obey_signals=True)\n",
    ),
)
UNKNOWN_COLOUR = Problem(
    "SCN452",
    "no traffic light shows {actual}",
    cure="{suggestion}",
    page=Page(
        "unknown colour of a light",
        "Lights are `green`, `yellow`, `red`, `off` or `unknown`; where there is none, their status is `None`.",
        'signals()\nego = new Car on road\nterminate when getClosestTrafficLightStatus(ego) == "amber"\n',
        'signals()\nego = new Car on road\nterminate when getClosestTrafficLightStatus(ego) == "yellow"\n',
    ),
)
SIGNALS_UNUSED = warning(
    "SCN453",
    "no actor looks at the traffic lights",
    "they change nothing by themselves",
    "drive with `obey_signals=True`, or use `withinDistanceToRedYellowTrafficLight(self, 15)`",
    page=Page(
        "traffic lights without effect",
        "Lights have an effect only where something reads them: a library behavior with `obey_signals`, or a "
        "condition.",
        "signals()\nego = new Car on road, with behavior FollowLaneBehavior()\n",
        "signals()\nego = new Car on road, with behavior FollowLaneBehavior(obey_signals=True)\n",
    ),
)
SIGNALS_TWICE = Problem(
    "SCN454",
    "the traffic lights are given twice",
    "all intersections share one plan",
    "remove one",
    page=Page(
        "two signal plans",
        "All intersections share one plan.",
        "signals()\nsignals(green=5 s)\nego = new Car on road, with behavior FollowLaneBehavior(obey_signals=True)\n",
        "signals(green=5 s)\nego = new Car on road, with behavior FollowLaneBehavior(obey_signals=True)\n",
    ),
)
ENVIRONMENT_TWICE = Problem(
    "SCN455",
    "the environment is given twice",
    "all objects share one weather",
    "write its arguments in one statement, as in `environment(friction=0.4, sight=60 m)`",
    page=Page(
        "two environments",
        "All objects share one weather, which one statement describes.",
        "environment(friction=0.4)\nenvironment(sight=60 m)\nego = new Car on road\n",
        "environment(friction=0.4, sight=60 m)\nego = new Car on road\n",
    ),
)
ENVIRONMENT_LATE = Problem(
    "SCN456",
    "the environment is set below `{name}`",
    "it decides how far objects see, and statements run in order",
    "move it above all objects",
    page=Page(
        "environment below an object",
        "The environment decides how far an object sees, and a `require` between the two could not know it.",
        "ego = new Car on road\nenvironment(sight=60 m)\n",
        "environment(sight=60 m)\nego = new Car on road\n",
    ),
)
SCENIC_SIGNALS = note(
    "SCN447",
    "the map's traffic lights follow a fixed plan: green 10 s, yellow 3 s, all red 2 s",
    cure="add a line like `signals(green=10 s, offset=5 s)` to choose its times",
    page=Page(
        "lights of Scenic's maps",
        "CARLA's maps have traffic lights. A script that names such a map and asks for lights gets a fixed plan here.",
        "param map = localPath('Town05.xodr')\n"
        "ego = new Car on road, with behavior FollowLaneBehavior(obey_signals=True)\n",
        "signals()\nego = new Car on road, with behavior FollowLaneBehavior(obey_signals=True)\n",
    ),
)

"""SCN4xx: the ego, the places of objects and their trajectories. SCN237 to SCN240: classes and mutations."""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.errors.problems import Problem, warning

NO_EGO = Problem(
    "SCN404",
    "no object is the ego",
    "every metric is measured from the vehicle under test",
    "write `ego = new Car at ...`",
    page=Page(
        "no ego",
        "Every metric is measured from the vehicle under test, which is the object called `ego`.",
        "car = new Car on road\n",
        "ego = new Car on road\n",
    ),
)
EGO_NOT_OBJECT = Problem(
    "SCN405",
    "`ego` must be an object, but this is {actual}",
    cure="write `ego = new Car at ...`",
    page=Page(
        "ego that is not an object",
        "`ego` is the vehicle under test, so it can only be an object.",
        "ego = 5\n",
        "ego = new Car on road\n",
    ),
)
EGO_NEEDED = Problem(
    "SCN406",
    "{what} is measured from the ego, but there is none yet",
    cure="define `ego` above this line",
    page=Page(
        "measured from an ego that is not defined yet",
        "Without `from`, a distance is measured from the ego, which must be defined above.",
        "x = distance to intersection\nego = new Car on road, with speed x / 10 s\n",
        "ego = new Car on road\nrequire (distance to intersection) < 20 m\n",
    ),
)
NO_HEADING_YET = Problem(
    "SCN475",
    "beside a plain point, this {name} needs a heading of its own",
    "its sides follow from its heading, and its heading follows from its place",
    "give it a heading, as in `facing 90 deg`, or place it beside an oriented point",
    page=Page(
        "beside a point without a heading",
        "Left, right, ahead and behind of a plain point are measured in the frame of the object itself. An object "
        "whose heading follows from its place, as a car's follows from the road, has none until it is placed.",
        "ego = new Car right of (20, 0) by 2 m\n",
        "ego = new Car right of (20, 0) by 2 m, facing 180 deg\n",
    ),
)
NO_RELATION = Problem(
    "SCN472",
    "`relative to` cannot combine {left} with {right}",
    "one heading turns another, and a place lies in the frame of a single point or object",
    "take the heading of one of them: `x.heading relative to y`",
    page=Page(
        "`relative to` between two things with headings",
        "With two objects or oriented points it is unclear which is the offset and which is the frame.",
        "ego = new Car on road\nother = new Car on road\nrequire abs(ego relative to other) < 5 deg\n",
        "ego = new Car on road\nother = new Car on road\nrequire abs(ego.heading relative to other) < 5 deg\n",
    ),
)
BAD_REGION = Problem(
    "SCN477",
    "{what} is not a valid region",
    "{reason}",
    "list its corners in order around it, or give it a size",
    page=Page(
        "region without size",
        "A region needs an area: a polygon has three or more corners, not all on one line, and edges that do not "
        "cross.",
        "area = PolygonalRegion([(0, 0), (20, 20), (20, 0), (0, 20)])\nego = new Car in area\n",
        "area = PolygonalRegion([(0, 0), (20, 0), (20, 20), (0, 20)])\nego = new Object in area\n",
    ),
)
NOT_A_FIELD = Problem(
    "SCN473",
    "only a field of directions can be followed, but this is {actual}",
    "a path follows the lanes of the road, or a `VectorField`",
    "write `following roadDirection from x for 10 m`",
    page=Page(
        "following something that is not a field",
        "`roadDirection` is followed along the lanes, any other field in short steps, each in the direction of the "
        "field there.",
        "ego = new Car on road\nb = new Car following 30 deg from ego for 10 m\n",
        "ego = new Car on road\nb = new Car following roadDirection from ego for 10 m\n",
    ),
)
NOWHERE_UNSEEN = Problem(
    "SCN474",
    "`not visible` needs a region here",
    "the world is unbounded, so no place in it can be drawn",
    "name a region: `on not visible road`",
    page=Page(
        "out of view, without a region",
        "`not visible` draws from the region that an object must lie in; an object that may lie anywhere has none.",
        "ego = new Car on road\nnew Obstacle not visible\n",
        "ego = new Car on road\nnew Obstacle on not visible road\n",
    ),
)
FASTER_THAN_TOP = Problem(
    "SCN437",
    "`speed` {may} {actual}, but the top speed of this {name} is {top}",
    "{reason}",
    "slow it down, or raise its top speed, as in `with topSpeed {cure}`",
    page=Page(
        "faster than its top speed",
        "No object starts faster than its top speed. The reference lists that of each class; `with topSpeed` sets "
        "another.",
        "ego = new Bicycle on road, with speed 80 km/h\n",
        "ego = new Bicycle on road, with speed 20 km/h\n",
    ),
)
NO_PLACE = Problem(
    "SCN407",
    "this {name} has no place",
    "people stand on sidewalks and crossings, which this road does not have",
    "say where: `at (x, y)`, `right of x by d`, `on road`",
    page=Page(
        "object without a place",
        "A vehicle without a place is anywhere on the road; a person would be on a sidewalk, and there are none.",
        "ego = new Car on road\nnew Pedestrian\n",
        "ego = new Car on road, with speed 3 m/s\n",
    ),
)
TWO_PLACES = Problem(
    "SCN408",
    "this {name} is placed twice",
    "an object has one position",
    "remove one specifier",
    page=Page(
        "object placed twice",
        "An object has one position; two specifiers would contradict each other.",
        "ego = new Car on road, at (0, 0)\n",
        "ego = new Car on road\n",
    ),
)
TWO_HEADINGS = Problem(
    "SCN409",
    "this {name} is given two headings",
    "an object has one heading",
    "remove one specifier",
    page=Page(
        "object with two headings",
        "An object has one heading; two specifiers would contradict each other.",
        "ego = new Car at (0, 0), facing 1 rad, facing 2 rad\n",
        "ego = new Car at (0, 0), facing 1 rad\n",
    ),
)
PROPERTY_TWICE = Problem(
    "SCN410",
    "the property `{name}` is given twice",
    cure="remove one",
    page=Page(
        "property given twice",
        "Only one of the two values could be meant.",
        "ego = new Car on road, with speed 1 m/s, with speed 2 m/s\n",
        "ego = new Car on road, with speed 2 m/s\n",
    ),
)
NOT_CONNECTED = Problem(
    "SCN417",
    "lane {number} of the trajectory does not start where the one before it ends",
    "{gap}",
    "{cure}",
    page=Page(
        "trajectory with a gap",
        "Each lane of a trajectory starts where the one before it ends.",
        "lane = intersection.incomingLanes[0]\n"
        "m = lane.maneuvers[0]\n"
        "ego = new Car before intersection by 20 m along [lane, m.endLane]\n",
        "lane = intersection.incomingLanes[0]\n"
        "m = lane.maneuvers[0]\n"
        "ego = new Car before intersection by 20 m along [lane, m.connectingLane, m.endLane]\n",
    ),
)
EMPTY_TRAJECTORY = Problem(
    "SCN418",
    "this trajectory has no lanes",
    cure="as in `[lane, maneuver.connectingLane]`",
    page=Page(
        "empty trajectory",
        "A trajectory is a list of connected lanes; an empty one leads nowhere.",
        "ego = new Car on road, with behavior FollowTrajectoryBehavior(5 m/s, [])\n",
        "lane = network.lanes[0]\n"
        "ego = new Car in lane.centerline, with behavior FollowTrajectoryBehavior(5 m/s, [lane])\n",
    ),
)
NOT_ON_TRAJECTORY = Problem(
    "SCN419",
    "the trajectory does not lead into {region}",
    cure="begin it with the lane that leads there, as in `[m.startLane, m.connectingLane]`",
    page=Page(
        "trajectory that does not lead there",
        "`before REGION by D along TRAJECTORY` counts back from the point where the trajectory enters the region.",
        "m = intersection.incomingLanes[0].maneuvers[0]\nego = new Car before intersection by 5 m along [m.endLane]\n",
        "m = intersection.incomingLanes[0].maneuvers[0]\n"
        "ego = new Car before intersection by 5 m along [m.startLane]\n",
    ),
)
NO_TRAJECTORY = Problem(
    "SCN420",
    "`{word}` needs a trajectory",
    cure="write `{word} intersection by 20 m along trajectory`",
    page=Page(
        "`before` or `after` without a trajectory",
        "Many routes lead to and from an intersection; the distance is measured along one of them.",
        "ego = new Car before intersection by 20 m\n",
        "lane = intersection.incomingLanes[0]\nego = new Car before intersection by 20 m along [lane]\n",
    ),
)
TOO_FAR = Problem(
    "SCN421",
    "{actual} {word} {region} is not on the trajectory",
    "it {bounds} {available} {word}",
    "use {remedy}, or a shorter distance",
    page=Page(
        "further away than the trajectory reaches",
        "The roads of the map are as long as its `approach`, which is 50 m by default.",
        "lane = intersection.incomingLanes[0]\nego = new Car before intersection by 80 m along [lane]\n",
        "map intersection(approach=100 m)\n"
        "lane = intersection.incomingLanes[0]\n"
        "ego = new Car before intersection by 80 m along [lane]\n",
    ),
)
SELF_OUTSIDE = Problem(
    "SCN432",
    "`self` is only known in a behavior",
    "it is the object that the behavior drives",
    "name the object, such as `ego`",
    page=Page(
        "`self` outside a behavior",
        "`self` is the object that a behavior drives; elsewhere there is none.",
        "ego = new Car on road\nrequire self.speed < 3 m/s\n",
        "ego = new Car on road\nrequire ego.speed < 3 m/s\n",
    ),
)
EVERYTHING_TOO_FAR = warning(
    "SCN445",
    "some distances that this can take are not on the trajectory, which {bounds} {available} {word} {region}",
    "up to {actual} can be drawn; such scenes are rejected",
    "narrow the range, or use {remedy}",
    page=Page(
        "sometimes further away than the trajectory reaches",
        "Scenes in which the object would stand beyond either end of its trajectory are rejected.",
        "param D = Range(5, 80) m\n"
        "lane = intersection.incomingLanes[0]\n"
        "ego = new Car before intersection by D along [lane]\n",
        "param D = Range(5, 45) m\n"
        "lane = intersection.incomingLanes[0]\n"
        "ego = new Car before intersection by D along [lane]\n",
    ),
)
NEVER_LEAVES = Problem(
    "SCN484",
    "the trajectory does not go through {region}",
    "`after` measures from where it leaves",
    "add the lane that leads through, and the one after it: `[m.startLane, m.connectingLane, m.endLane]`",
    page=Page(
        "trajectory that does not go through",
        "`after REGION by D along TRAJECTORY` counts on from the point where the trajectory leaves the region.",
        "m = intersection.incomingLanes[0].maneuvers[0]\nego = new Car after intersection by 5 m along [m.startLane]\n",
        "m = intersection.incomingLanes[0].maneuvers[0]\n"
        "ego = new Car after intersection by 5 m along [m.startLane, m.connectingLane, m.endLane]\n",
    ),
)
OTHER_SIDE = Problem(
    "SCN485",
    "a distance {word} {region} cannot be negative",
    "the other side of {region} has its own keyword",
    "write `{other} {region} by {distance} along …`",
    page=Page(
        "on the other side of the intersection",
        "`before` counts back from where a trajectory enters the intersection, `after` on from where it leaves.",
        "m = intersection.incomingLanes[0].maneuvers[0]\nego = new Car before intersection by -5 m along m\n",
        "m = intersection.incomingLanes[0].maneuvers[0]\nego = new Car after intersection by 5 m along m\n",
    ),
)

# -- SCN237 to SCN240: classes and mutations ---------------------------------------------------------------------------

_EGO = "ego = new Car on road, with speed 5 m/s\n"

NEARLY_A_PROPERTY = warning(
    "SCN237",
    "`{name}` is not a built-in property",
    "only the file itself reads it",
    "did you mean `{match}`?",
    page=Page(
        "property that may be misspelt",
        "A class may have properties of its own. One that is spelled almost like a built-in one is probably a "
        "misspelling of it.",
        f"class Taxi(Car):\n    widht: 1.7 m\n\n{_EGO}cab = new Taxi ahead of ego by 9 m\n",
        f"class Taxi(Car):\n    width: 1.7 m\n\n{_EGO}cab = new Taxi ahead of ego by 9 m\n",
    ),
)
PROPERTY_CYCLE = Problem(
    "SCN238",
    "the default of `{name}` depends on itself: {cycle}",
    cure="give one of them a value of its own",
    page=Page(
        "circular property defaults",
        "A default may use other properties through `self`, as long as they do not depend on one another in a circle.",
        f"class Box:\n    width: self.length\n    length: self.width\n\n{_EGO}box = new Box ahead of ego by 9 m\n",
        f"class Box:\n    width: self.length\n    length: 2 m\n\n{_EGO}box = new Box ahead of ego by 9 m\n",
    ),
)
CANNOT_MUTATE = Problem(
    "SCN239",
    "`mutate` needs an object, but `{name}` is {actual}",
    cure="{cure}",
    page=Page(
        "mutation of something that is not an object",
        "`mutate` adds noise to the place and heading of objects.",
        f"D = 5 m\n{_EGO}mutate D\n",
        f"{_EGO}mutate ego\n",
    ),
)
MUTATED_ALIAS = Problem(
    "SCN240",
    "`{name}` is not the name under which the object was made",
    "`mutate` takes the name to which `new` was assigned",
    "use the name under which the object was made",
    page=Page(
        "mutation by another name",
        "An object that is placed relative to a mutated one sees its mutated place, so the name must be the one under "
        "which it is made.",
        f"{_EGO}other = ego\nmutate other\n",
        f"{_EGO}mutate ego\n",
    ),
)

"""SCN53x: what is proved of a file before anything is drawn."""

from cortex_dsl.diagnostics import Page
from cortex_dsl.semantics.errors.problems import Problem

INFEASIBLE = Problem(
    "SCN530",
    "no scene can meet every requirement",
    "{reason}",
    "{cure}",
    page=Page(
        "file without a valid scene",
        "Interval reasoning over the ranges of all params and draws proves that no attempt can pass: every one of them "
        "would be thrown away. The requirements named are a smallest set for which this is proved.",
        "param D = Range(5, 20) m\nego = new Car on road\nrequire D >= 15 m\nrequire D * 2 <= 25 m\n",
        "param D = Range(5, 20) m\nego = new Car on road\nrequire D >= 10 m\nrequire D * 2 <= 25 m\n",
        shown="by `--check`",
    ),
)
OFF_THE_ROAD = Problem(
    "SCN531",
    "`{name}` does not stand on the road",
    "at the start all of its outline must lie on the road, so every scene would be thrown away",
    "put it into a lane, as in `in lane.centerline`, or turn it, as in `facing roadDirection`; if it is to stand "
    "beside the road write `with regionContainedIn None`, and after `at` also `facing 90 deg`",
    page=Page(
        "object off the road",
        "Vehicles begin on the road, with all of their outline. x counts to the east and y to the north, in metres "
        "from the centre of the map.",
        "ego = new Car on road\nnew Truck at (20, -30)\n",
        "ego = new Car on road\nnew Truck at (20, -30), facing 90 deg, with regionContainedIn None\n",
        shown="by `--check`, and where no scene was found",
    ),
)
ON_TOP = Problem(
    "SCN532",
    "`{name}` stands on top of `{other}`",
    "at the start no two outlines may overlap, so every scene would be thrown away",
    "move one of them, as in `ahead of {other} by 5 m`; or say `with allowCollisions True` if it is meant",
    page=Page(
        "object on top of another",
        "A scene begins without contact: the outlines of no two objects overlap.",
        "ego = new Car at (1.75, -30), facing 90 deg\nnew Car at (1.75, -29), facing 90 deg\n",
        "ego = new Car at (1.75, -30), facing 90 deg\nnew Car at (1.75, -20), facing 90 deg\n",
        shown="by `--check`, and where no scene was found",
    ),
)

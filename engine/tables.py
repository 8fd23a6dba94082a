"""The arrays that kernels read, grouped under names.

This module imports neither numba nor the rest of the engine, so the compiler may build tables without them.
"""

from collections.abc import Mapping
from enum import IntEnum
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.handles import handle
from engine.vocabulary import HeightColumn

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.integer]
PLAIN: tuple[Literal["C", "A", "W"], ...] = ("C", "A", "W")
"""Contiguous, aligned, writable: the only layout of arrays for which kernels are compiled."""

ROAD_INDEX = frozenset({"cell_edges", "cell_start", "cell_points", "cell_frame"})
"""Fields of `RoadTables` that follow from the other fields and do not affect results."""


@handle
class RoadTables(NamedTuple):
    """All geometry of a program. Offsets are CSR: rows of item i are `start[i]:start[i + 1]`."""

    primitives: Floats
    """(n, 8): arc length at start, x, y, heading, curvature (0 = line), length, cos and sin of the heading. Centre
    lines of all paths."""
    path_start: Ints
    """(paths + 1,): offsets into `primitives`."""
    path_length: Floats
    """(paths,) [m]"""
    lane_path: Ints
    """(lanes,): path id of each lane's centre line."""
    lane_route: Ints
    """(lanes,): path id of the default route that starts with this lane."""
    lane_width: Floats
    """(lanes,) [m]"""
    edges: Floats
    """(n, 4): x1, y1, x2, y2 of region boundaries (outer rings and holes; inside by the even-odd rule)."""
    region_start: Ints
    """(regions + 1,): offsets into `edges`."""
    hull: Floats
    """(n, 8): x1, y1, x2, y2 of convex hull edges, with the region on their left; 1.0 if the edge is a region edge, too
    (these first); unit direction x, y; length.
    """
    hull_start: Ints
    """(regions + 1,)"""
    triangles: Floats
    """(n, 7): cumulative share of the region's area, then x1, y1, x2, y2, x3, y3."""
    triangle_start: Ints
    """(regions + 1,)"""
    cores: Floats
    """(n, 4): least x, least y, greatest x, greatest y of rectangles inside the region, for a quick positive test."""
    core_start: Ints
    """(regions + 1,)"""
    buildings: Floats
    """(n, 5): x, y, heading, length, width of walls near the road, which hide actors behind them."""
    cell_edges: Floats = np.zeros((0, 4))
    """(n, 4): the edges of the whole road, as in `edges`, once for each cell that they intersect. Only a road with many
    edges has cells, which are an index without further information.
    """
    cell_start: Ints = np.zeros(1, dtype=np.int32)
    """(cells + 1,): offsets into `cell_edges`; row by row from the south, each from west to east."""
    cell_points: Floats = np.zeros((0, 3))
    """(cells, 3): x, y of a point of the cell that is on no edge, and 1 if it is in the road, else 0."""
    cell_frame: Floats = np.zeros(0)
    """(5,): least x and least y of all cells, side of a cell [m], columns, rows. There is no road outside the cells."""
    heights: Floats = np.zeros((0, len(HeightColumn)))
    """(n, len(HeightColumn)): points along the centres of all lanes, cell by cell. Only a road that passes over
    another one has heights.
    """
    height_start: Ints = np.zeros(1, dtype=np.int32)
    """(cells + 1,): offsets into `heights`; row by row from the south, each from west to east."""
    height_frame: Floats = np.zeros(0)
    """(5,), as `cell_frame`, for the cells of `heights`."""
    first_lanes: Ints = np.zeros((0, 2), dtype=np.int32)
    """(n, 2): an actor, and a lane of the road on whose level it begins. Only scenarios that name levels have rows."""


LEVELS = frozenset({"heights", "height_start", "height_frame"})
"""Fields of `RoadTables` that only a road with several levels has."""


def is_left_out(road: RoadTables, name: str) -> bool:
    """Return True for fields that are neither stored nor part of a digest, because this road has none of them."""
    return (name in LEVELS and not len(road.heights)) or (name == "first_lanes" and not len(road.first_lanes))


def kept_road(arrays: Mapping[str, np.ndarray]) -> RoadTables:
    """Return tables from stored arrays; without their index if that is another version's."""
    index = {} if ROAD_INDEX - arrays.keys() else {name: arrays[name] for name in ROAD_INDEX}
    levels = {} if LEVELS - arrays.keys() else {name: arrays[name] for name in LEVELS}
    first = {name: arrays[name] for name in ("first_lanes",) if name in arrays}
    rest = {name: arrays[name] for name in RoadTables._fields if name not in ROAD_INDEX | LEVELS | {"first_lanes"}}
    return RoadTables(**rest, **index, **levels, **first)


def no_road() -> RoadTables:
    """Return the tables of a place without a road: no path, no lane, no region, no building."""
    wide = {"primitives": 8, "edges": 4, "hull": 8, "triangles": 7, "cores": 4, "buildings": 5}
    whole = ("lane_path", "lane_route")

    def table(name: str) -> np.ndarray:
        if name in wide:
            return np.zeros((0, wide[name]))
        if name in whole or name.endswith("_start"):
            return np.zeros(0 if name in whole else 1, dtype=np.int32)
        return np.zeros(0)

    return RoadTables(*(table(name) for name in RoadTables._fields if name not in RoadTables._field_defaults))


SHADE = 6
"""Columns of an outline in a table of outlines: x, y, heading, length, width, and 1 if it hides, else 0."""

SLIDING = 2.0
"""Value of `State.PRESENT` for a sliding body after an impact; its motion is that of its centres, not along its
heading.
"""
A_BUILDING = -1
"""Index of a building in the place of a touched actor."""
ROAD_REGION = 0
"""Region 0 is always the whole drivable road."""


class Segment(IntEnum):
    """Columns of a segment of code: rows `START` to `END` (exclusive), and the register of its result."""

    START = 0
    END = 1
    RESULT = 2


class Size(IntEnum):
    """Entries of `CodeTables.sizes`."""

    SCENE_REGISTERS = 0
    DRAWS = 1
    """Uniform draws of an attempt."""
    SCENE_VALUES = 2
    STEP_REGISTERS = 3
    LOCALS = 4
    """The first local's step register."""
    BLOCKS = 5


@handle
class CodeTables(NamedTuple):
    """All instructions and the constants they use.

    Scene registers:     literals | variant values | genes (SI) | uniform draws | temporaries
    Behaviour registers: literals | variant values | scene values | locals      | temporaries
    """

    scene_code: Ints
    """(n, 6) rows `(op, dst, a, b, c, d)`."""
    step_code: Ints
    """(n, 6) code run during simulation: behaviours and termination rules."""
    literals: Floats
    """(n_literals,)"""
    pool: Floats
    """Numeric options of discrete choices, for `Op.TABLE`."""

    variant_values: Floats
    """(variants, n_variant_values)"""
    variant_template: Ints
    """(variants,): which template's code a variant runs; -1: this variant is impossible (always rejected)."""
    variant_rejection: Ints
    """(variants,): index of the rejection reason (a pseudo requirement) of an impossible variant, else -1."""
    variant_cumulative: Floats
    """(variants,): cumulative probability within the variant's group."""
    group_start: Ints
    """(groups + 1,): offsets of the variants of a group; a group is one combination of the discrete genes that pick
    variants.
    """
    group_gene: Ints
    """(k,): genes that pick the group, most significant first."""
    group_size: Ints
    """(k,): number of options of each such gene."""

    gene_scale: Floats
    """(genes,): SI value = file value * scale."""
    requirement_segment: Ints
    """(templates, requirements, len(Segment)) in scene_code."""
    requirement_probability: Floats
    """(requirements,): 1 for a hard requirement; below 1, the probability that it applies to a scene, drawn once."""
    output_segment: Ints
    """(templates, 2) `Segment.START` and `END` of the scene code that runs after a scene is accepted."""
    output_register: Ints
    """(templates, n_values): register of each scene value."""
    road_check: Ints
    """(actors,): 1 if the built-in requirement `inside the road` applies to this actor."""
    overlap_check: Ints
    """(actors,): the built-in requirement `no overlap at the start` applies between actors with equal numbers, and to
    buildings; not to those with number 0.
    """
    actor_kind: Ints
    """(actors,) `ActorKind`."""
    behaviour_entry: Ints
    """(templates, actors): first row in step_code, or -1 without behaviour."""
    main_block: Ints
    """(templates, actors): block number of the actor's behaviour."""
    rule_segment: Ints
    """(templates, rules, len(Segment)) in step_code: code that is evaluated in every sample; rows are -1 for rules that
    code triggers (`terminate` inside a behaviour), and for those that are evaluated after the end of the run.
    """
    rule_kind: Ints
    """(rules,) `RuleKind`. All rules are evaluated in every sample; the first that is true ends the run."""
    formula: Ints
    """(n, 3): rows `(TemporalOp, a, b)` of all temporal formulas, operands above their operators; a of an ATOM is the
    rule of kind WATCH with its truth, b the rule with its robustness (-1: not needed).
    """
    temporal_root: Ints
    """(temporals,): formula row that must be true at sample 0."""
    temporal_rule: Ints
    """(temporals,): rule that makes the run invalid if the formula is not true."""
    monitor_entry: Ints
    """(templates, monitors): first row in step_code of each coroutine without an actor."""
    monitor_block: Ints
    """(templates, monitors): its block number."""
    monitor_started: Ints
    """(monitors,): `Turns`."""
    actor_present: Ints
    """(actors,): 1 for those that take part from the start."""
    margin_segment: Ints
    """(templates, requirements, len(Segment)) in scene_code: margin by which each requirement holds (positive if it
    does); rows are -1 if there is no such number. It may read results of the requirement's own code and of the code of
    all requirements before it.
    """
    sizes: Ints
    """(len(Size),)"""


class ObjectiveTables(NamedTuple):
    """Formulas and code that are evaluated for a finished run."""

    root: Ints
    """(objectives,): row of `CodeTables.formula` that must be true at sample 0; -1 for a number."""
    segment: Ints
    """(templates, objectives, len(Segment)) in step_code, which computes that number: its first locals are the readings
    of the run (`Program.readings`).
    """


class ReferenceModel(NamedTuple):
    """Parameters of a reference driver; 0 where a kind of driver has no such parameter."""

    kind: int
    """`ReferenceKind`"""
    reaction: float
    """Time of unsafe samples before braking [s]."""
    braking: float
    """Full braking [m/s^2]."""
    jerk: float
    """Rate at which braking builds up [m/s^3]; infinite: at once."""
    release: float
    """Deceleration during the reaction [m/s^2]."""
    margin: float
    """Lateral distance that counts as none [m]."""
    own: float
    """Braking of the ego in the condition of safety [m/s^2]."""
    theirs: float
    """Braking of the other in that condition [m/s^2]."""
    speeding_up: float
    """Acceleration of the ego during the reaction, in that condition [m/s^2]."""
    lateral: float
    """Lateral acceleration of the other, in that condition [m/s^2]."""
    comfortable: float
    """Comfortable braking [m/s^2]."""
    room: float
    """Gap at rest [m]."""
    spare: float
    """Further gap below which the other is no longer surely safe [m], or time added to the reaction [s]."""
    critical: float
    """TTC and headway of a risk [s]."""
    alarming: float
    """Braking of a leader that is a risk [m/s^2]."""

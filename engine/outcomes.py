"""The table of results: every number of a simulation with name, symbol, unit, kind and meaning.

A row is an attribute of one of the classes below, with its `Result` in `Annotated`. From the rows come the results of
the kernels, the arrays of `Outcomes` and `Assessment`, the columns of journals, CSV and JSON, the guide in a run's
folder, and the metrics of reports, pages and the API. A new metric of a pair is its kernel in `engine.kernels.pair`, a
row of `_Measured`, and a test.

Arrays are row-aligned and in SI units. For an invalid scene, floats are NaN, integers -1 and truths False. Pair j is
the ego and actor j + 1.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import fields, replace
from enum import Enum, IntEnum
from inspect import get_annotations
from typing import Annotated, Any, get_origin

import numpy as np
from numpy.typing import NDArray

from engine.display import counted, facts_table
from engine.frozen import frozen
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import EndReason, Fault, Side, Verdict

# -- rows of the table -------------------------------------------------------------------------------------------------


class Per(Enum):
    """Reference of a result, which determines the shape of its array in `Outcomes`."""

    SCENE = "scene"
    """(n,)"""
    PAIR = "pair"
    """(n, pairs) One for each pair of the ego and another actor."""
    ACTOR = "actor"
    """(n, actors)"""
    CONTACT = "contact"
    """(n, 2) The two actors in contact."""


class Retention(Enum):
    """Choice of the value that a scene stores in `Assessment`."""

    OWN = "own"
    """The only value."""
    NEAREST = "nearest"
    """Value of the pair that comes nearest."""
    DECIDING = "deciding"
    """Value of the pair that decides the risk."""
    LEAST = "least"
    EGO = "ego"


Kind = type[float] | type[int] | type[bool] | type[IntEnum]


@frozen
class Result:
    """One row of the table."""

    sentence: str = ""
    """Description of its columns in the guide; "" for a row that is described with the row before."""
    unit: str = ""
    """SI unit word, "" for pure numbers."""
    symbol: str = ""
    """Symbol of a metric, such as MD, under which reports list it; "" without one."""
    meaning: str = ""
    """Text of a report next to the symbol."""
    per: Per = Per.SCENE
    kind: Kind = float
    retention: Retention = Retention.OWN
    parts: tuple[str, ...] = ()
    """Names of the k columns of an array (n, k)."""
    part_of: str = ""
    """Name of the row to which they belong."""
    when: str = ""
    """Name of the row with its instant, for a metric that has one."""
    of_risk: bool = False
    """True for the metrics of which the score consists, which reports show together with it."""
    in_document: bool = True
    """True if the JSON of a single run contains this metric of a pair."""
    formula: str = ""
    """Definition of a metric with a symbol."""
    source: str = ""
    """Source of the definition."""
    name: str = ""
    """The attribute; filled in from the class."""

    @property
    def columns(self) -> tuple[str, ...]:
        """Return its columns in a journal and in CSV."""
        return self.parts or (self.name,)

    @property
    def fill(self) -> float | int | bool:
        """Return the value of an invalid scene."""
        return math.nan if self.kind is float else self.kind is not bool and -1

    @property
    def dtype(self) -> Any:
        return {float: np.float64, bool: np.bool_}.get(self.kind, np.int32)

    @property
    def words(self) -> Mapping[int, str] | None:
        """Return the words of an enumeration by their codes; None for numbers."""
        if not issubclass(self.kind, IntEnum):
            return None
        return {-1: "", **{int(member): member.name.lower() for member in self.kind}}

    def blank(self, rows: int, actors: int) -> NDArray[Any]:
        """Return an array of `Outcomes` in which every scene is invalid."""
        shape = {Per.PAIR: (rows, actors - 1), Per.ACTOR: (rows, actors), Per.CONTACT: (rows, 2)}.get(self.per, (rows,))
        return np.full(shape, self.fill, self.dtype)


# -- the table ---------------------------------------------------------------------------------------------------------

MODEL_RANGE = 0.5
"""Use of grip up to which a kinematic bicycle moves like a car: Polack, Altche, d'Andrea-Novel, de La Fortelle, "The
kinematic bicycle model: a consistent model for planning feasible trajectories …", IV 2017.
"""


@frozen
class _Decided:
    verdict: Annotated[
        Ints,
        Result(
            "`valid`; `exhausted`, `infeasible`, `aborted`: no valid scene; `error`: the engine failed; "
            "`controller`: the driver failed",
            kind=Verdict,
        ),
    ]


@frozen
class _Sampled:
    """Results of sampling for a scene."""

    variant: Annotated[Ints, Result("number of the combination of lanes and other finite choices, -1: none", kind=int)]
    attempts: Annotated[Ints, Result("attempts to draw the scene", kind=int)]
    tested: Ints
    """(n, requirements) Number of tests of each requirement."""
    failed: Ints
    """(n, requirements) Number of failures of each requirement, conditional on the earlier requirements."""


@frozen
class _Judged:
    """The risk of a scene."""

    score: Annotated[Ints, Result("risk, 0 to 22, -1 if invalid", kind=int)]
    continuous: Annotated[Floats, Result("the risk without steps")]
    parts: Annotated[
        Ints,
        Result("parts of the risk", kind=int, parts=("risk_c", "risk_md", "risk_d_ms", "risk_ttc_ms"), part_of="score"),
    ]
    """(n, 4) Contributions of C, MD, D_MS and TTC_MS to the score."""
    pair: Annotated[
        Ints, Result("the pair that decides the score: the ego and actor `pair` + 1 (the ego is actor 0)", kind=int)
    ]


@frozen
class _Measured:
    """Results of simulation for a scene."""

    collided: Annotated[Bools, Result("1: the ego touched another actor", kind=bool)]
    """Contact before the end of the run."""
    end_reason: Annotated[
        Ints,
        Result(
            "`collision` (of the ego), `building` (it ran into one), `rule`, `timeout`, `all_done`, `stuck`, `broken`",
            kind=EndReason,
        ),
    ]
    end_rule: Annotated[Ints, Result("for `rule`: number of the rule in `summary.json`, else -1", kind=int)]
    """Index into `Program.rules` if the reason is RULE or ABORTED, else -1. For STUCK: row of step_code."""
    end_time: Annotated[Floats, Result("end of the run [s]", "s")]
    """First contact or end of the run."""
    min_distance: Annotated[
        Floats,
        Result(
            "MD, least distance of the ego's outline to another [m], and when [s]",
            "m",
            "MD",
            "least distance between the outlines",
            Per.PAIR,
            retention=Retention.NEAREST,
            when="min_distance_time",
            of_risk=True,
            formula="least distance between the outlines over continuous time; 0 on contact",
            source="CORTEX-AVD, Table 1",
        ),
    ]
    """Infinite for two that are never in the scene together."""
    min_distance_time: Annotated[Floats, Result("", "s", per=Per.PAIR, retention=Retention.NEAREST)]
    max_closing_speed: Annotated[
        Floats,
        Result(
            "MS, fastest closing speed of that pair [m/s], and when [s]",
            "m/s",
            "MS",
            "largest closing speed of the centres",
            Per.PAIR,
            retention=Retention.DECIDING,
            when="max_closing_time",
            of_risk=True,
            formula="max of c = -(p . v) / |p| over samples, p and v: relative position and velocity of the centres",
            source="CORTEX-AVD, Table 1",
        ),
    ]
    max_closing_time: Annotated[Floats, Result("", "s", per=Per.PAIR, retention=Retention.DECIDING)]
    distance_at_ms: Annotated[
        Floats,
        Result(
            "D_MS, their distance at MS [m]",
            "m",
            "D_MS",
            "distance at the instant of MS",
            Per.PAIR,
            retention=Retention.DECIDING,
            when="max_closing_time",
            of_risk=True,
            formula="distance at the first sample with c >= MS - 0.01 m/s; infinite if they never approach",
            source="CORTEX-AVD, Table 1",
        ),
    ]
    ttc_at_ms: Annotated[
        Floats,
        Result(
            "TTC_MS = D_MS / MS [s]",
            "s",
            "TTC_MS",
            "D_MS / MS",
            Per.PAIR,
            retention=Retention.DECIDING,
            when="max_closing_time",
            of_risk=True,
            formula="D_MS / MS; infinite if they never approach",
            source="CORTEX-AVD, Table 1",
        ),
    ]
    ego_speed: Annotated[
        Floats,
        Result(
            "speeds of that pair at its closest approach, or at contact [m/s]",
            "m/s",
            per=Per.PAIR,
            retention=Retention.DECIDING,
            in_document=False,
        ),
    ]
    """Speed of the rear axle, along its heading, at the instant of MD, or of contact; the next four are at that
    instant, too. NaN and -1 for two that never meet.
    """
    other_speed: Annotated[Floats, Result("", "m/s", per=Per.PAIR, retention=Retention.DECIDING, in_document=False)]
    approach_angle: Annotated[
        Floats,
        Result(
            "heading of the other then, relative to the ego [rad]: 0 same direction, +-3.14 head-on, positive left",
            "rad",
            per=Per.PAIR,
            retention=Retention.DECIDING,
            in_document=False,
        ),
    ]
    """-pi .. pi, positive to the left."""
    closing_speed: Annotated[
        Floats,
        Result(
            "closing speed of their centres then [m/s]",
            "m/s",
            per=Per.PAIR,
            retention=Retention.DECIDING,
            in_document=False,
        ),
    ]
    side: Annotated[
        Ints,
        Result(
            "side of the ego on which the other is then: `front`, `left`, `rear`, `right`",
            per=Per.PAIR,
            kind=Side,
            retention=Retention.DECIDING,
            in_document=False,
        ),
    ]
    first_seen: Annotated[
        Floats,
        Result(
            "when the ego first saw the other [s], their time to collision then [s], and how long it was hidden "
            "inside the ego's field of view [s]",
            "s",
            per=Per.PAIR,
            retention=Retention.DECIDING,
        ),
    ]
    """NaN if it never did, as the next two results. For recordings, which contain no views, all three are NaN."""
    ttc_at_first_sight: Annotated[Floats, Result("", "s", per=Per.PAIR, retention=Retention.DECIDING)]
    """Exact for the outlines at constant velocities; infinite if they were not on a collision course."""
    hidden_time: Annotated[Floats, Result("", "s", per=Per.PAIR, retention=Retention.DECIDING)]
    """Time of the samples at which the other actor was in the sector and radius of the ego's view, but covered."""
    left_road_time: Annotated[
        Floats, Result("when the first actor left the road [s]", "s", per=Per.ACTOR, retention=Retention.LEAST)
    ]
    """Time at which an actor's centre first left the road, NaN if never."""
    fault: Annotated[
        Ints,
        Result(
            "of a collision: `ego`; or `struck_from_behind`, `struck_standing`: no failure of the ego",
            per=Per.PAIR,
            kind=Fault,
            retention=Retention.DECIDING,
        ),
    ]
    """-1 for pairs that do not touch."""
    lateral_grip: Annotated[
        Floats,
        Result("largest lateral use of grip by the ego, as a share of mu g", per=Per.ACTOR, retention=Retention.EGO),
    ]
    """NaN for an actor without tyres; so is the next."""
    combined_grip: Annotated[
        Floats,
        Result(
            "the same for acceleration and turning together; above 0.5, the vehicle model is not valid",
            per=Per.ACTOR,
            retention=Retention.EGO,
        ),
    ]
    others_contact_time: Annotated[
        Floats, Result("when two other actors first touched; empty: never, or after the end [s]", "s")
    ]
    """NaN if never. They collide, and the run continues, as only the ego ends it."""


@frozen
class Outcomes(_Measured, _Decided):
    """Results of each scene, by the arrays of the table; a result per pair or actor has one number for each."""

    steps: Annotated[Ints, Result("steps simulated", kind=int)]
    contact_actors: Annotated[
        Ints, Result("the ego and the actor that it touched, -1: none", per=Per.CONTACT, kind=int)
    ]
    others_contact_actors: Annotated[
        Ints, Result("the first two other actors that touched, -1: none", per=Per.CONTACT, kind=int)
    ]
    sought: Floats
    """(n, objectives) Value of each objective of the file (`Program.judged`); the robustness of an `expect`."""
    broken: Floats
    """(n, objectives) 1 if an `expect` is broken, 0 if it holds; NaN for all other objectives."""
    gaps: Floats
    """(n, pairs) PET by area [s] (`engine.kernels.encroachment`), NaN without one; (n, 0) if it was not requested."""

    def __len__(self) -> int:
        return len(self.verdict)

    def __repr__(self) -> str:
        """Return one line, for notebooks."""
        valid = int((self.verdict == 0).sum())
        return f"Outcomes({len(self)}: {valid} valid, {counted(int(self.collided.sum()), 'collision')})"

    def _repr_html_(self) -> str:
        counts = ((reason.name.lower(), int((self.end_reason == reason).sum())) for reason in EndReason)
        facts = [("runs", f"{len(self):,}"), ("valid", f"{int((self.verdict == 0).sum()):,}")]
        return facts_table([*facts, *((f"ended by {name}", f"{count:,}") for name, count in counts if count)])


@frozen
class Assessment(_Measured, _Judged, _Sampled, _Decided):
    """Assessed simulations as a search stores them: verdict, counts, risk and metrics, (n,) each.

    Every array may have more leading axes (a campaign has (individuals, rollouts)). With several pairs, MD is that of
    the nearest pair, MS and related metrics are those of the pair that decides the risk (`Retention`).
    """

    sought: Floats
    """(n, objectives) Values of the search's objectives, larger is better (`engine.search.objectives`); empty for the
    paper's risk alone.
    """
    broken: Floats
    """(n, objectives of the file) 1 if an `expect` is broken, 0 if it holds; NaN for all other objectives."""
    found: Bools
    """True for a find of the search; for the paper's risk, a collision."""

    def __len__(self) -> int:
        return len(self.verdict)


# -- its rows ----------------------------------------------------------------------------------------------------------


def _rows(table: type) -> Iterator[Result]:
    """Yield the rows of a class in the order of its fields; fields without a `Result` are skipped."""
    annotations: dict[str, Any] = {}
    for base in reversed(table.__mro__):
        annotations |= get_annotations(base)
    for field in fields(table):
        if get_origin(annotations[field.name]) is Annotated:
            yield replace(annotations[field.name].__metadata__[0], name=field.name)


OUTCOMES: tuple[Result, ...] = tuple(_rows(Outcomes))
"""Results of the simulators."""
PAIRS: tuple[Result, ...] = tuple(row for row in OUTCOMES if row.per is Per.PAIR)
"""Results for each pair of the ego and another actor."""
MEASURED: tuple[Result, ...] = tuple(_rows(_Measured))
"""Results that a scene stores."""
RESULTS: tuple[Result, ...] = tuple(_rows(Assessment))
"""Results that a search stores for each simulation."""


def blank_outcomes(rows: int, actors: int, **known: NDArray[Any]) -> Outcomes:
    """Return outcomes of invalid scenes, except for the arrays in `known`."""
    nothing: dict[str, NDArray[Any]] = {name: np.zeros((rows, 0)) for name in ("sought", "broken", "gaps")}
    return Outcomes(**{row.name: row.blank(rows, actors) for row in OUTCOMES} | nothing | known)

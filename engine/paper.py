"""The printed numbers of the CORTEX-AVD paper, and the agreement of each claim with the paper's own numbers.

Source: "CORTEX-AVD: A Framework for CORner Case Testing and EXploration in Autonomous Vehicle Development", sections
"Results" and "Discussion". One run of each method in each scenario: 30 generations of 100.

Printed numbers are rounded. A claim holds when some values that round to the printed inputs give a result that rounds
to the printed one. Claims of the paper are separate from inferences: rows that follow from its numbers by an additional
assumption, such as that MDG counts a collision as 0 m. If an assumption is wrong, all of its rows fail together.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from statistics import fmean

# -- the printed values, in the order of the scenarios A to F ----------------------------------------------------------

SCENARIOS = ("A", "B", "C", "D", "E", "F")
FILES = (
    "left_turn",
    "left_against_crossing",
    "crossing_left_turn",
    "right_and_oncoming_left",
    "right_into_crossing",
    "three_way_left",
)
"""Files of the same scenarios among the examples; those under `examples/paper` have the letters as names."""
GENES: frozenset[str] = frozenset(
    ("EGO_INIT_DIST", "EGO_SPEED", "EGO_BRAKE", "ADV_INIT_DIST", "ADV_SPEED", "SAFETY_DIST", "CRASH_DIST")
)
"""Params of each scenario."""
GENERATIONS, POPULATION = 30, 100
INDIVIDUALS = GENERATIONS * POPULATION
"""Number of individuals of one method in one scenario."""
SECONDS_PER_SIMULATION = 13.5
HOURS = 135.0


@dataclass(frozen=True)
class Printed:
    """The figures of one method; each tuple has one number per scenario."""

    rl: tuple[float, ...]
    """Mean risk."""
    nc: tuple[int, ...]
    """Collisions."""
    nc_last: tuple[int, ...]
    """Collisions in generations 21 to 30."""
    mdg_last: tuple[float, ...]
    """Mean minimum distance in generations 21 to 30 [cm]."""
    mdec_last: tuple[float, ...]
    """Mean minimum distance without the collisions [cm]."""
    nis: tuple[int, ...]
    """Invalid individuals."""
    nis_last: tuple[int, ...]
    """Invalid individuals in generations 21 to 30."""
    mean_rl: float
    """Mean risk as printed for all six scenarios."""
    mdg: float
    """Mean minimum distance as printed for all six scenarios [cm]."""
    mdec: float

    @property
    def valid(self) -> tuple[int, ...]:
        return tuple(INDIVIDUALS - invalid for invalid in self.nis)


GA = Printed(
    rl=(13.3, 7.5, 8.8, 9.8, 7.7, 10.1),
    nc=(673, 577, 544, 386, 377, 692),
    nc_last=(220, 249, 273, 158, 195, 312),
    mdg_last=(69.4, 121.5, 101.4, 144.6, 143.9, 166.8),
    mdec_last=(77.9, 141.8, 122.6, 160.9, 154.7, 191.5),
    nis=(468, 665, 725, 604, 1047, 922),
    nis_last=(20, 50, 36, 77, 159, 187),
    mean_rl=9.54,
    mdg=133.2,
    mdec=149.6,
)
RANDOM = Printed(
    rl=(9.7, 6.1, 7.6, 7.5, 6.0, 9.7),
    nc=(651, 355, 327, 322, 284, 543),
    nc_last=(204, 133, 101, 109, 82, 174),
    mdg_last=(138.9, 187.5, 162.5, 180.8, 213.6, 200.7),
    mdec_last=(161.2, 217.6, 178.2, 195.7, 224.6, 236.1),
    nis=(771, 885, 778, 924, 798, 1059),
    nis_last=(267, 312, 249, 325, 286, 371),
    mean_rl=7.75,
    mdg=180.6,
    mdec=202.2,
)
METHODS = {"GA": GA, "random": RANDOM}


@dataclass(frozen=True)
class Study:
    """One row of the paper's comparison of studies, as printed."""

    name: str
    cases: str
    seconds: str
    """Seconds per simulation."""
    collisions: str
    valid: str
    metrics: str


STUDIES = (
    Study("Klück et al. 2019 (performance)", "9,135", "not stated", "other meaning", "not collected", "TTC"),
    Study("Tian et al. 2022 (MOSAT)", "50,000 (estimated)", "24-55", "1.1-2.85 %", "other meaning", "METTC, DFP, ..."),
    Study("Gambi et al. 2019", "a budget of hours", "41.1-152.6", "not stated", "34-39 %", "distance"),
    Study("Langford et al. 2019", "4,989", "other meaning", "not stated", "not stated", "distance"),
    Study("Tang et al. 2021", "10,240", "60", "not stated", "other meaning", "distance"),
    Study("Ebadi et al. 2021", "200", "10 (a limit)", "GA 15 (7.5 %), random 8 (4 %)", "not collected", "distance"),
    Study("Klück et al. 2019 (genetic)", "2,342", "not stated", "72 (3.1 %)", "GA 878, random 468", "TTC"),
    Study("Kaufmann et al. 2021", "1,800", "10 (a limit)", "233 (12.9 %)", "other meaning", "distance"),
    Study("Zhou et al. 2023", "40,000", "56", "GA 2,666 (13.3 %), random 747 (3.7 %)", "not collected", "not stated"),
    Study("Klück et al. 2023", "83,726", "not stated", "GA 5,946 (30.7 %)", "not collected", "TTC"),
    Study(
        "CORTEX-AVD",
        "36,000",
        "13.5",
        "GA 3,249 (18.1 %), random 2,482 (13.8 %)",
        "GA 75.4 %, random 71 %",
        "RL, NC, MD",
    ),
)


def place_of(name: str, params: Iterable[str]) -> int | None:
    """Return the place of a scenario among A to F by the name of its file and its params; None if it is none of them.

    The params are compared as well, since a file of a user may have the same name.
    """
    found = [names.index(name) for names in (FILES, SCENARIOS) if name in names]
    return found[0] if found and frozenset(params) == GENES else None


# -- what its arithmetic says ------------------------------------------------------------------------------------------

LEAST_COLLISION, GREATEST_COLLISION = 14, 22
"""A collision has MD = 0, so MD adds 4 to the 10 of the collision itself; all parts together are 22."""
GREATEST_HARMLESS = 12
NIS_IMPROVED, NIS_UNFAVOURABLE = ("A", "B", "D"), ("C", "E", "F")
"""Scenarios with fewer invalid runs of the GA according to the paper, and those it calls "less favorable"."""


@dataclass(frozen=True)
class Claim:
    """A claim of the paper, or an inference from its claims."""

    topic: str
    says: str
    printed: str
    found: str
    holds: bool
    remark: str = ""
    assumption: str = ""
    """Additional assumption of the row; "" for a claim of the paper."""

    @property
    def inferred(self) -> bool:
        return bool(self.assumption)


def said(checked: Sequence[Claim]) -> list[Claim]:
    """Return the claims of the paper itself."""
    return [claim for claim in checked if not claim.inferred]


def by_assumption(checked: Sequence[Claim]) -> dict[str, list[Claim]]:
    """Return the inferences by their assumptions."""
    inferred = [claim for claim in checked if claim.inferred]
    names = dict.fromkeys(claim.assumption for claim in inferred)
    return {name: [claim for claim in inferred if claim.assumption == name] for name in names}


def _infer(assumption: str, rows: Iterator[Claim]) -> Iterator[Claim]:
    return (replace(row, assumption=assumption) for row in rows)


def claims() -> list[Claim]:
    """Return all checked claims, by topic."""
    return [*_risk(), *_collisions(), *_invalid(), *_distances(), *_score(), *_costs()]


def _share(topic: str, says: str, printed: float, found: float, remark: str = "", slack: float = 0.5) -> Claim:
    """Return a claim of a percentage, printed to whole points unless `slack` differs."""
    return Claim(topic, says, f"{printed:g} %", f"{found:.1f} %", abs(found - printed) <= slack, remark)


def _number(topic: str, says: str, printed: float, found: float, slack: float, remark: str = "") -> Claim:
    return Claim(topic, says, f"{printed:g}", f"{found:.4g}", abs(found - printed) <= slack, remark)


def _gain(new: float, old: float) -> float:
    """Return the relative change [%]."""
    return 100.0 * (new - old) / old


# -- risk level -------------------------------------------------------------------------------------------------------


def _risk() -> Iterator[Claim]:
    for name, method in METHODS.items():
        slack = 0.05 + 0.005  # of the six means, and of the printed one
        yield _number("RL", f"mean RL of {name} over the six scenarios", method.mean_rl, fmean(method.rl), slack)
    remark = "the printed value is the difference divided by the RL of the GA, not by that of random sampling"
    yield _share("RL", "RL rises from 7.75 to 9.54", 18.7, _gain(GA.mean_rl, RANDOM.mean_rl), remark, 0.2)
    gains = {s: _gain(new, old) for s, new, old in zip(SCENARIOS, GA.rl, RANDOM.rl, strict=True)}
    yield _share("RL", "smallest increase of RL (scenario F)", 4, min(gains.values()))
    yield _share("RL", "largest increase of RL (scenario A)", 37, max(gains.values()))
    yield _share("RL", "mean of the six increases of RL", 23, fmean(gains.values()))
    for name, method in METHODS.items():
        yield from _infer("an invalid run counts as -1 in RL", _bounds(name, method))


def _bounds(name: str, method: Printed) -> Iterator[Claim]:
    """Yield bounds of a mean risk: the largest if an invalid run counts -1, and the least of a valid run."""
    for scenario, rl, nc, nis, valid in zip(SCENARIOS, method.rl, method.nc, method.nis, method.valid, strict=True):
        greatest = (GREATEST_COLLISION * nc + GREATEST_HARMLESS * (valid - nc) - nis) / INDIVIDUALS
        if rl - 0.05 > greatest:
            says = f"RL of {name} in {scenario} if an invalid run counts as -1"
            remark = "the means must be over valid runs only"
            yield Claim("RL", says, f"{rl:g}", f"at most {greatest:.2f}", holds=False, remark=remark)


# -- collisions -------------------------------------------------------------------------------------------------------


def _collisions() -> Iterator[Claim]:
    for name, method, printed, rate in (("GA", GA, 3249, 18.1), ("random", RANDOM, 2482, 13.8)):
        total = sum(method.nc)
        yield _number("NC", f"total collisions of {name}", printed, total, 0.0)
        yield _share("NC", f"share of {name}'s runs that collide", rate, 100.0 * total / (6 * INDIVIDUALS), slack=0.051)
    yield _share("NC", "increase of the collisions by the GA", 31, _gain(sum(GA.nc), sum(RANDOM.nc)))
    yield from _infer("more collisions means a higher share of valid runs", _of_valid())
    for scenario, total, last in zip(SCENARIOS, RANDOM.nc, RANDOM.nc_last, strict=True):
        yield _steady(
            "NC", f"collisions of random sampling in {scenario} are spread evenly over the generations", total, last
        )


def _of_valid() -> Iterator[Claim]:
    for scenario, *row in zip(SCENARIOS, GA.nc, RANDOM.nc, GA.valid, RANDOM.valid, strict=True):
        found, chance, valid, chance_valid = row
        ours, theirs = 100.0 * found / valid, 100.0 * chance / chance_valid
        says = f"the GA has the higher share of collisions among valid runs in {scenario}"
        yield Claim("NC", says, "more", f"{ours:.1f} % against {theirs:.1f} %", ours > theirs)


def _steady(topic: str, says: str, total: int, last: int) -> Claim:
    """Return the claim that ten of thirty generations contain a third: within three deviations of a binomial count."""
    expected, deviation = total / 3.0, (total * 2.0 / 9.0) ** 0.5
    found = f"{last} of {total} in the last ten"
    return Claim(topic, says, f"about {expected:.0f}", found, abs(last - expected) <= 3.0 * deviation)


# -- invalid scenarios ------------------------------------------------------------------------------------------------


def _invalid() -> Iterator[Claim]:
    for name, method, valid, rate, slack in (("GA", GA, 13569, 75.4, 0.051), ("random", RANDOM, 12785, 71, 0.51)):
        yield _number("NIS", f"total valid runs of {name}", valid, sum(method.valid), 0.0)
        yield _share(
            "NIS", f"share of {name}'s runs that are valid", rate, 100.0 * valid / (6 * INDIVIDUALS), slack=slack
        )
    change = -_gain(sum(GA.nis), sum(RANDOM.nis))
    yield _share("NIS", "decrease of invalid runs by the GA (discussion)", 15, change)
    says = "decrease of invalid runs by the GA (abstract, conclusion)"
    yield _share("NIS", says, 25, change, "the discussion has 15 %")
    yield from _fewer(NIS_IMPROVED)
    yield from _infer("fewer invalid runs holds in every scenario", _fewer(NIS_UNFAVOURABLE))
    for scenario in NIS_UNFAVOURABLE:
        place = SCENARIOS.index(scenario)
        ours, theirs = GA.nis[place], RANDOM.nis[place]
        found = f"{ours} against {theirs}"
        yield Claim("NIS", f"the GA has more invalid runs in {scenario}", "more", found, ours > theirs)
    cuts = [-_gain(new, old) for new, old in zip(GA.nis_last, RANDOM.nis_last, strict=True)]
    yield _share("NIS", "smallest decrease of invalid runs in the last ten generations (scenario E)", 44, min(cuts))
    yield _share("NIS", "largest decrease of invalid runs in the last ten generations (scenario A)", 93, max(cuts))
    for scenario, total, last in zip(SCENARIOS, RANDOM.nis, RANDOM.nis_last, strict=True):
        yield _steady(
            "NIS", f"invalid runs of random sampling in {scenario} are spread evenly over the generations", total, last
        )


def _fewer(scenarios: Sequence[str]) -> Iterator[Claim]:
    for scenario in scenarios:
        place = SCENARIOS.index(scenario)
        ours, theirs = GA.nis[place], RANDOM.nis[place]
        found = f"{ours} against {theirs}"
        yield Claim("NIS", f"the GA has fewer invalid runs in {scenario}", "fewer", found, ours < theirs)


# -- distances --------------------------------------------------------------------------------------------------------


def _distances() -> Iterator[Claim]:
    yield _share("MD", "decrease of MDG", 26, -_gain(GA.mdg, RANDOM.mdg))
    yield _share("MD", "decrease of MDEC", 26, -_gain(GA.mdec, RANDOM.mdec))
    yield from _infer("each printed mean is over the last ten generations", _last_ten())
    for name, method in METHODS.items():
        yield from _infer("MDG counts a collision as 0 m", _collision_free(name, method))


def _last_ten() -> Iterator[Claim]:
    for name, method in METHODS.items():
        remark = "the printed means of random sampling are over the last ten generations, those of the GA are not"
        for metric, printed, last in (("MDG", method.mdg, method.mdg_last), ("MDEC", method.mdec, method.mdec_last)):
            says = f"{metric} of {name} is the mean of its last ten generations"
            yield _number("MD", says, printed, fmean(last), 0.1, "" if name == "random" else remark)


def _collision_free(name: str, method: Printed) -> Iterator[Claim]:
    """Yield the check of MDG = MDEC x (1 - collisions / valid runs) in the last ten, with collisions as 0 in MDG."""
    rows = zip(SCENARIOS, method.mdg_last, method.mdec_last, method.nc_last, method.nis_last, strict=True)
    for scenario, mdg, mdec, collisions, invalid in rows:
        expected = mdec * (1.0 - collisions / (INDIVIDUALS / 3 - invalid))
        says = f"MDG of {name} in {scenario} (last ten generations) follows from MDEC and the number of collisions"
        yield _number("MD", says, mdg, expected, 0.5, "a collision has distance 0")


# -- the score --------------------------------------------------------------------------------------------------------


def _score() -> Iterator[Claim]:
    yield _share("risk", "share of a collision in the greatest risk (10 of 22 points)", 45, 1000.0 / 22.0)
    yield Claim(
        "risk", "a score of 14 implies a collision", "always", f"at most {GREATEST_HARMLESS} without one", holds=True
    )
    says = "a score of 12 may consist of a collision (10) and 2 other points"
    yield Claim("risk", says, "possible", f"a collision scores at least {LEAST_COLLISION}", holds=False)
    remark = "the widths of the bands (240, 235, 235) give 4020"
    yield Claim(
        "risk", "the bands of D_MS do not overlap", "[3780, 4255[", "and [4020, 4255[", holds=False, remark=remark
    )


# -- costs ------------------------------------------------------------------------------------------------------------


def _costs() -> Iterator[Claim]:
    simulations = 2 * len(FILES) * INDIVIDUALS
    yield _number("cost", "total simulations", 36000, simulations, 0.0)
    yield _number(
        "cost", "total hours at 13.5 s per simulation", HOURS, simulations * SECONDS_PER_SIMULATION / 3600.0, 0.5
    )
    yield _share("cost", "collision rate of 18.1 % relative to the 13.3 % of Zhou et al. 2023", 36, _gain(18.1, 13.3))
    yield _next_best()
    found = 75.4 / 39.0
    yield Claim("cost", "twice the valid share of the second best (39 %)", "2", f"{found:.2f}", round(found) == 2)
    found = SECONDS_PER_SIMULATION / 24.0
    says = "nearly half the time of the fastest framework (24 s)"
    yield Claim("cost", says, "0.5", f"{found:.2f}", abs(found - 0.5) <= 0.05)


def _next_best() -> Claim:
    """Return the claim on the next best rate: the paper excludes a higher rate because of its one kind of collision,
    although its own collisions are of one kind.
    """
    remark = "the paper excludes that study, whose collisions are with front vehicles and pedestrians"
    says = "no other study has a collision rate above 13.3 %"
    return Claim("cost", says, "13.3 %", "30.7 % in its own table (Klück et al. 2023)", holds=False, remark=remark)

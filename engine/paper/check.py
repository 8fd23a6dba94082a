"""The paper's arithmetic, done again: each claim, what was printed, what its own numbers give, and whether they agree.

Printed numbers are rounded. A claim holds when some values that round to the printed inputs give a result that rounds
to the printed one.

What the paper says is told apart from what we infer: rows that follow from its numbers by an assumption of ours, such
as that MDG counts a collision as 0 m. Where an assumption fails, all of its rows fail together, for one cause.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from statistics import fmean

from engine.paper.numbers import (
    FILES,
    GA,
    HOURS,
    METHODS,
    RANDOM,
    RUNS,
    SCENARIOS,
    SECONDS_PER_SIMULATION,
    Printed,
)

LEAST_COLLISION, GREATEST_COLLISION = 14, 22
"""A collision has MD = 0, so MD adds 4 to the 10 of the collision itself; all parts together are 22."""
GREATEST_HARMLESS = 12
NIS_IMPROVED, NIS_UNFAVOURABLE = ("A", "B", "D"), ("C", "E", "F")
"""Scenarios in which the paper says that the GA's invalid runs are fewer, and those where "less favorable"."""


@dataclass(frozen=True)
class Claim:
    """One thing that the paper says, or that must follow from what it says."""

    topic: str
    says: str
    printed: str
    found: str
    holds: bool
    remark: str = ""
    assumption: str = ""
    """Ours, on which the row rests; empty where the paper says it itself."""

    @property
    def inferred(self) -> bool:
        return bool(self.assumption)


def said(checked: Sequence[Claim]) -> list[Claim]:
    """What the paper says itself."""
    return [claim for claim in checked if not claim.inferred]


def by_assumption(checked: Sequence[Claim]) -> dict[str, list[Claim]]:
    """What rests on each assumption of ours."""
    inferred = [claim for claim in checked if claim.inferred]
    names = dict.fromkeys(claim.assumption for claim in inferred)
    return {name: [claim for claim in inferred if claim.assumption == name] for name in names}


def _infer(assumption: str, rows: Iterator[Claim]) -> Iterator[Claim]:
    return (replace(row, assumption=assumption) for row in rows)


def claims() -> list[Claim]:
    """All that is checked, by topic."""
    return [*_risk(), *_collisions(), *_invalid(), *_distances(), *_score(), *_costs()]


def _share(topic: str, says: str, printed: float, found: float, remark: str = "", slack: float = 0.5) -> Claim:
    """A percentage, printed to whole points unless `slack` says otherwise."""
    return Claim(topic, says, f"{printed:g} %", f"{found:.1f} %", abs(found - printed) <= slack, remark)


def _number(topic: str, says: str, printed: float, found: float, slack: float, remark: str = "") -> Claim:
    return Claim(topic, says, f"{printed:g}", f"{found:.4g}", abs(found - printed) <= slack, remark)


def _gain(new: float, old: float) -> float:
    """Relative change [%]."""
    return 100.0 * (new - old) / old


# -- risk level -------------------------------------------------------------------------------------------------------


def _risk() -> Iterator[Claim]:
    for name, method in METHODS.items():
        slack = 0.05 + 0.005  # of the six means, and of the printed one
        yield _number("RL", f"mean RL of {name} over the six", method.mean_rl, fmean(method.rl), slack)
    remark = "18.8 % of the GA's own value: divided by the wrong one"
    yield _share("RL", "RL rises from 7.75 to 9.54", 18.7, _gain(GA.mean_rl, RANDOM.mean_rl), remark, 0.2)
    gains = {s: _gain(new, old) for s, new, old in zip(SCENARIOS, GA.rl, RANDOM.rl, strict=True)}
    yield _share("RL", "the least gain, in F", 4, min(gains.values()))
    yield _share("RL", "the greatest gain, in A", 37, max(gains.values()))
    yield _share("RL", "the mean of the six gains", 23, fmean(gains.values()))
    for name, method in METHODS.items():
        yield from _infer("an invalid run counts as -1 in RL", _bounds(name, method))


def _bounds(name: str, method: Printed) -> Iterator[Claim]:
    """What a mean risk can be at most when an invalid run counts -1, and at least in a valid one."""
    for scenario, rl, nc, nis, valid in zip(SCENARIOS, method.rl, method.nc, method.nis, method.valid, strict=True):
        greatest = (GREATEST_COLLISION * nc + GREATEST_HARMLESS * (valid - nc) - nis) / RUNS
        if rl - 0.05 > greatest:
            says = f"RL of {name} in {scenario}, had invalid runs been counted as -1"
            remark = "so the means must be over valid runs only"
            yield Claim("RL", says, f"{rl:g}", f"at most {greatest:.2f}", holds=False, remark=remark)


# -- collisions -------------------------------------------------------------------------------------------------------


def _collisions() -> Iterator[Claim]:
    for name, method, printed, rate in (("GA", GA, 3249, 18.1), ("random", RANDOM, 2482, 13.8)):
        total = sum(method.nc)
        yield _number("NC", f"collisions of {name} in all", printed, total, 0.0)
        yield _share("NC", f"share of {name}'s runs that collide", rate, 100.0 * total / (6 * RUNS), slack=0.051)
    yield _share("NC", "the GA finds more collisions", 31, _gain(sum(GA.nc), sum(RANDOM.nc)))
    yield from _infer("more collisions means more for each valid run", _of_valid())
    for scenario, total, last in zip(SCENARIOS, RANDOM.nc, RANDOM.nc_last, strict=True):
        yield _steady("NC", f"random collisions in {scenario} spread evenly over the generations", total, last)


def _of_valid() -> Iterator[Claim]:
    for scenario, *row in zip(SCENARIOS, GA.nc, RANDOM.nc, GA.valid, RANDOM.valid, strict=True):
        found, chance, valid, chance_valid = row
        ours, theirs = 100.0 * found / valid, 100.0 * chance / chance_valid
        says = f"the GA is better in {scenario}, of the runs that are valid"
        yield Claim("NC", says, "more", f"{ours:.1f} % against {theirs:.1f} %", ours > theirs)


def _steady(topic: str, says: str, total: int, last: int) -> Claim:
    """Ten of thirty generations should hold a third: within three standard deviations of a binomial count."""
    expected, deviation = total / 3.0, (total * 2.0 / 9.0) ** 0.5
    found = f"{last} of {total} in the last ten"
    return Claim(topic, says, f"about {expected:.0f}", found, abs(last - expected) <= 3.0 * deviation)


# -- invalid scenarios ------------------------------------------------------------------------------------------------


def _invalid() -> Iterator[Claim]:
    for name, method, valid, rate, slack in (("GA", GA, 13569, 75.4, 0.051), ("random", RANDOM, 12785, 71, 0.51)):
        yield _number("NIS", f"valid runs of {name} in all", valid, sum(method.valid), 0.0)
        yield _share("NIS", f"share of {name}'s runs that are valid", rate, 100.0 * valid / (6 * RUNS), slack=slack)
    change = -_gain(sum(GA.nis), sum(RANDOM.nis))
    yield _share("NIS", "the GA meets fewer invalid runs (discussion)", 15, change)
    yield _share("NIS", "the GA meets fewer invalid runs (abstract, conclusion)", 25, change, "15 % in the discussion")
    yield from _fewer(NIS_IMPROVED)
    yield from _infer("fewer invalid runs means in every scenario", _fewer(NIS_UNFAVOURABLE))
    for scenario in NIS_UNFAVOURABLE:
        place = SCENARIOS.index(scenario)
        ours, theirs = GA.nis[place], RANDOM.nis[place]
        found = f"{ours} against {theirs}"
        yield Claim("NIS", f"the GA's invalid runs in {scenario} are the less favourable", "more", found, ours > theirs)
    cuts = [-_gain(new, old) for new, old in zip(GA.nis_last, RANDOM.nis_last, strict=True)]
    yield _share("NIS", "the least improvement of the last ten generations, in E", 44, min(cuts))
    yield _share("NIS", "the greatest improvement of the last ten generations, in A", 93, max(cuts))
    for scenario, total, last in zip(SCENARIOS, RANDOM.nis, RANDOM.nis_last, strict=True):
        yield _steady("NIS", f"random's invalid runs in {scenario} spread evenly over the generations", total, last)


def _fewer(scenarios: Sequence[str]) -> Iterator[Claim]:
    for scenario in scenarios:
        place = SCENARIOS.index(scenario)
        ours, theirs = GA.nis[place], RANDOM.nis[place]
        found = f"{ours} against {theirs}"
        yield Claim("NIS", f"the GA meets fewer invalid runs in {scenario}", "fewer", found, ours < theirs)


# -- distances --------------------------------------------------------------------------------------------------------


def _distances() -> Iterator[Claim]:
    yield _share("MD", "MDG falls", 26, -_gain(GA.mdg, RANDOM.mdg))
    yield _share("MD", "MDEC falls", 26, -_gain(GA.mdec, RANDOM.mdec))
    yield from _infer("a printed mean is of the last ten generations", _last_ten())
    for name, method in METHODS.items():
        yield from _infer("MDG counts a collision as 0 m", _collision_free(name, method))


def _last_ten() -> Iterator[Claim]:
    for name, method in METHODS.items():
        remark = "random's printed means are those of the last ten generations, the GA's are not"
        for metric, printed, last in (("MDG", method.mdg, method.mdg_last), ("MDEC", method.mdec, method.mdec_last)):
            says = f"{metric} of {name} is the mean of its last ten generations"
            yield _number("MD", says, printed, fmean(last), 0.1, "" if name == "random" else remark)


def _collision_free(name: str, method: Printed) -> Iterator[Claim]:
    """MDG counts each collision as 0, so MDG = MDEC x (1 - collisions / valid runs), all in the last ten."""
    rows = zip(SCENARIOS, method.mdg_last, method.mdec_last, method.nc_last, method.nis_last, strict=True)
    for scenario, mdg, mdec, collisions, invalid in rows:
        expected = mdec * (1.0 - collisions / (RUNS / 3 - invalid))
        says = f"MDG of {name} in {scenario}, last ten, follows from MDEC and the collisions"
        yield _number("MD", says, mdg, expected, 0.5, "a collision has distance 0")


# -- the score --------------------------------------------------------------------------------------------------------


def _score() -> Iterator[Claim]:
    yield _share("risk", "a collision is 10 of 22 points", 45, 1000.0 / 22.0)
    yield Claim("risk", "a score of 14 is a collision", "always", f"others reach {GREATEST_HARMLESS}", holds=True)
    says = "a score of 12 can be a collision (10) and 2 more"
    yield Claim("risk", says, "possible", f"a collision scores {LEAST_COLLISION} at least", holds=False)
    remark = "the widths of the bands, 240, 235 and 235, say 4020"
    yield Claim(
        "risk", "the bands of D_MS do not overlap", "[3780, 4255[", "and [4020, 4255[", holds=False, remark=remark
    )


# -- costs ------------------------------------------------------------------------------------------------------------


def _costs() -> Iterator[Claim]:
    simulations = 2 * len(FILES) * RUNS
    yield _number("cost", "simulations in all", 36000, simulations, 0.0)
    yield _number("cost", "hours at 13.5 s each", HOURS, simulations * SECONDS_PER_SIMULATION / 3600.0, 0.5)
    yield _share("cost", "collision rate of 18.1 % above 13.3 % of Zhou et al. 2023", 36, _gain(18.1, 13.3))
    yield _next_best()
    found = 75.4 / 39.0
    yield Claim("cost", "twice the valid share of the second best (39 %)", "2", f"{found:.2f}", round(found) == 2)
    found = SECONDS_PER_SIMULATION / 24.0
    says = "nearly half the time of the fastest framework (24 s)"
    yield Claim("cost", says, "0.5", f"{found:.2f}", abs(found - 0.5) <= 0.05)


def _next_best() -> Claim:
    """The paper sets the higher rate aside for the kinds of its collisions; its own are of one kind, too."""
    remark = "set aside as of front vehicles and pedestrians; 5,946 are 30.7 % of the GA's own share of 83,726 cases"
    says = "no other study's collision rate lies above 13.3 % (next best)"
    return Claim("cost", says, "13.3 %", "30.7 % in its own table (Klück et al. 2023)", holds=False, remark=remark)

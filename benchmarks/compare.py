"""What does `cortexc compare` find? `python -m benchmarks.compare [--only NAME] [--jobs N]`

    mutants     30 library drivers, each beside a copy with one planted fault: found at 3,000 simulations? The list has
                no fault that showed in none of 20,000 plain pairs
    identical   30 drivers beside themselves: how many are reported?
    regression  a planted failure of probability 1e-3 beside failures of 5 %: found with a tenth of the runs that an
                unpaired test needs?
    coverage    does the 95 % interval of the difference hold the true difference in 95 % of 1,000 comparisons?

`--truth N` adds the share of plain pairs in which one of both drivers breaks a condition: of as many pairs as show 100
of them, at most N.
"""

import argparse
import json
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from benchmarks.drivers import text_of
from cortex_dsl.api.comparing import ComparisonPlan, compared_files, run_comparison
from cortex_dsl.api.contenders import contender, side_of
from cortex_dsl.api.limits import budget_of
from cortex_dsl.api.pairs import Collected, Pairing
from cortex_dsl.api.seeded_runs import draw_scenes, seeds_of
from cortex_dsl.report.findings.comparison_report import Change, FileComparison

FOLLOW = "FollowTrajectoryBehavior({speed}, {way})"
BRAKE = f"EmergencyBrakeBehavior({FOLLOW})"
STRAIGHT = f"EmergencyBrakeBehavior({FOLLOW}, foresees=False)"
IDM = "CarFollowingBehavior({speed}, {way})"
NEAR_IDM = """EmergencyBrakeBehavior(CarFollowingBehavior({speed}, time_headway=0.8 s, max_acceleration=3 m/s^2,
    comfortable_deceleration=4 m/s^2), brake=0.6, foresees=False)"""
GAPS = "GapAcceptanceBehavior({speed}, {way})"
CAREFUL = f"CarefulDriverBehavior({FOLLOW})"
FUZZY = f"FuzzySafetyBehavior({FOLLOW})"
RSS = f"RSSBehavior({FOLLOW})"

LOOKS = """\
behavior LooksBehavior(speed, way):
    try:
        do FollowTrajectoryBehavior(speed, way)
    interrupt when {when}:
        take SetBrakeAction(1)

"""
LANE = LOOKS.replace("FollowTrajectoryBehavior(speed, way)", "FollowLaneBehavior(speed)").replace(
    "(speed, way)", "(speed)"
)
ORDERED = """\
behavior OrderedBehavior(speed, way):
    try:
        do FollowTrajectoryBehavior(speed, way)
    interrupt when {first}
    interrupt when {second}

"""
CREEP = "timeToCollision(self) < 3 s:\n        do FollowTrajectoryBehavior(3 m/s, way) for 0.5 seconds"
STOP = "timeToCollision(self) < 1.5 s:\n        take SetBrakeAction(1)"
LOOKER, LANE_LOOKER, IN_ORDER = (
    "LooksBehavior({speed}, {way})",
    "LooksBehavior({speed})",
    "OrderedBehavior({speed}, {way})",
)


@dataclass(frozen=True)
class Mutant:
    """A driver and its copy with one planted fault."""

    fault: str
    file: str
    driver: str
    mutant: str
    prelude: str = ""
    """Text in front of the ego of the driver's file."""
    mutant_prelude: str = ""

    def texts(self) -> tuple[str, str]:
        """Return the files of both."""
        parts = (self.driver, self.prelude), (self.mutant, self.mutant_prelude)
        one, other = (
            text_of(self.file, driver).replace("ego = new Car", f"{prelude}ego = new Car", 1)
            for driver, prelude in parts
        )
        return one, other


def _looks(fault: str, file: str, when: str, mutated: str, looks: str = LOOKS) -> Mutant:
    call = LANE_LOOKER if looks is LANE else LOOKER
    return Mutant(fault, file, call, call, looks.format(when=when), looks.format(when=mutated))


def _ordered(file: str) -> Mutant:
    texts = (ORDERED.format(first=CREEP, second=STOP), ORDERED.format(first=STOP, second=CREEP))
    return Mutant("order", file, IN_ORDER, IN_ORDER, *texts)


def _wrapped(file: str, outer: str, inner: str) -> Mutant:
    """Return a driver whose two wrappers change places."""
    return Mutant("order", file, f"{outer}({inner}({FOLLOW}))", f"{inner}({outer}({FOLLOW}))")


NEAR, SOON = "timeToCollision(self) < 1.5 s", "timeToCollision(self) < 2.5 s"
PARTNERS = {name: f"timeToCollision(self, {name}) < 1.5 s" for name in ("oncoming", "crossing", "walker")}


def _slower(driver: str) -> str:
    return driver.replace("{speed}", "{speed} - 1 m/s")


def _faster(driver: str) -> str:
    return driver.replace("{speed}", "{speed} + 1 m/s")


def _signed(file: str, driver: str) -> Mutant:
    return Mutant("sign", file, _slower(driver), _faster(driver))


def _without(*partners: str) -> Mutant:
    """Return a driver that brakes for everyone, and one that brakes for these only."""
    return _looks("missing actor", "three_partners", NEAR, " or ".join(map(PARTNERS.__getitem__, partners)))


MUTANTS = (
    Mutant("constant", "A", STRAIGHT, f"EmergencyBrakeBehavior({FOLLOW}, foresees=False, brake=0.8)"),
    Mutant("constant", "B", BRAKE, f"EmergencyBrakeBehavior({FOLLOW}, delay=1 s)"),
    Mutant("constant", "C", CAREFUL, f"CarefulDriverBehavior({FOLLOW}, delay=1 s)"),
    Mutant("constant", "D", GAPS, "GapAcceptanceBehavior({speed}, {way}, critical_gap=3.5 s)"),
    Mutant("constant", "leader_brakes", NEAR_IDM, NEAR_IDM.replace("brake=0.6", "brake=0.4")),
    Mutant("constant", "E", RSS, f"RSSBehavior({FOLLOW}, response=0.3 s)"),
    _signed("A", STRAIGHT),
    _signed("B", CAREFUL),
    _signed("F", GAPS),
    _signed("cut_in", IDM),
    _looks("sign", "D", f"{NEAR} - self.speed / (50 m/s^2)", f"{NEAR} + self.speed / (50 m/s^2)"),
    _looks("sign", "walker_hesitates", f"{SOON} - self.speed / (50 m/s^2)", f"{SOON} + self.speed / (50 m/s^2)", LANE),
    Mutant("condition", "A", BRAKE, STRAIGHT),
    Mutant("condition", "B", BRAKE, f"EmergencyBrakeBehavior({FOLLOW}, min_speed=45 km/h)"),
    Mutant("condition", "C", BRAKE, f"EmergencyBrakeBehavior({FOLLOW}, max_speed=45 km/h)"),
    Mutant("condition", "D", BRAKE, f"EmergencyBrakeBehavior({FOLLOW}, field_of_view=60 deg)"),
    _looks("condition", "E", NEAR, f"{NEAR} and self.speed > 5 m/s"),
    _looks("condition", "walker_hesitates", SOON, f"{SOON} and self.speed > 4 m/s", LANE),
    _ordered("A"),
    _ordered("B"),
    _ordered("C"),
    _wrapped("D", "RSSBehavior", "FuzzySafetyBehavior"),
    _wrapped("F", "CarefulDriverBehavior", "FuzzySafetyBehavior"),
    _wrapped("cut_in", "CarefulDriverBehavior", "FuzzySafetyBehavior"),
    _looks("missing actor", "walker_hesitates", SOON, "False", LANE),
    _without("oncoming", "walker"),
    _without("crossing", "walker"),
    _looks("missing actor", "two_walkers", SOON, "timeToCollision(self, near) < 2.5 s", LANE),
    _looks("missing actor", "two_walkers", SOON, "timeToCollision(self, far) < 2.5 s", LANE),
    _looks("missing actor", "blind_corner", NEAR, "False"),
)
PAIRS, SEARCHED = 1000, 500
"""Pairs, and scenes of the search: 3,000 simulations in all."""
ENOUGH, BLOCK = 100, 1000


@dataclass(frozen=True)
class MutantResult:
    """What was found of a mutant."""

    fault: str
    file: str
    driver: str
    mutant: str
    rate: float
    """Share of plain pairs in which one of both breaks a condition."""
    pairs: int
    """Plain pairs behind it."""
    drawn: int
    """Pairs that differ among those of the comparison."""
    searched: int
    """Scenes that differ among those of its search."""

    @property
    def found(self) -> bool:
        return bool(self.drawn + self.searched)


def mutants(jobs: int, seed: int, most: int = 0) -> list[MutantResult]:
    """Compare each driver with its mutant, and count how often they differ."""
    results = []
    for mutant in MUTANTS:
        started = perf_counter()
        with tempfile.TemporaryDirectory() as home:
            names = _written(Path(home), *mutant.texts())
            (file,) = _compared(names, seed, jobs, PAIRS, SEARCHED)
            rate, pairs = _truth(names, jobs, most)
        differ = (Change.NEW, Change.CURED)
        searched = 0 if file.searched is None else sum(map(file.searched.count, differ))
        drawn = sum(map(file.count, differ))
        parts = mutant.fault, mutant.file, mutant.driver, mutant.mutant
        results.append(found := MutantResult(*parts, rate, pairs, drawn, searched))
        print(
            f"{json.dumps(asdict(found))} {perf_counter() - started:.0f} s {file.trouble}", file=sys.stderr, flush=True
        )
    return results


def _written(home: Path, *texts: str) -> tuple[str, ...]:
    """Write files and return their paths."""
    for label, text in zip("ab", texts, strict=True):
        (home / f"{label}.scn").write_text(text)
    return tuple(str(home / f"{label}.scn") for label in "ab")


def _compared(names: Sequence[str], seed: int, jobs: int, pairs: int, search: int = 0) -> tuple[FileComparison, ...]:
    a, b = map(side_of, names)
    plan = ComparisonPlan(a, b, budget_of(pairs), seed, search, jobs=jobs)
    return run_comparison(compared_files(plan, ()), plan).files


def _truth(names: Sequence[str], jobs: int, most: int) -> tuple[float, int]:
    """Return the share of plain pairs that differ, and their number."""
    sides = [contender(side_of(name), Path(name)) for name in names]
    pairing, differ, pairs = Pairing(sides[0], sides[1], jobs), 0, 0
    while differ < ENOUGH and pairs < most:
        numbers = np.arange(pairs + 1, pairs + BLOCK + 1)
        seeds = seeds_of(1_000_000, numbers)
        found = Collected(pairing)
        found.take(pairing.run(numbers, seeds, draw_scenes(sides[0].scenario, seeds, jobs, hopeful=True)))
        differ += sum(each.count for each in found.changes if each.change in (Change.NEW, Change.CURED))
        pairs += BLOCK
    return differ / (pairs or np.nan), pairs


def identical(jobs: int, seed: int) -> int:
    """Return how many of 30 drivers are reported as different from themselves."""
    alarms = 0
    for mutant in MUTANTS:
        with tempfile.TemporaryDirectory() as home:
            text, _ = mutant.texts()
            (file,) = _compared(_written(Path(home), text, text), seed, jobs, PAIRS, SEARCHED)
        differ = any(row.table.discordant for row in file.conditions) or any(
            map(file.count, (Change.NEW, Change.CURED, Change.MOVED))
        )
        alarms += bool(differ or (file.searched is not None and file.searched.changes))
    return alarms


# -- planted rates -----------------------------------------------------------------------------------------------------

PLANTED = """\
map intersection()
param U = Range(0, 1)
way = intersection.incomingLanes[0].maneuvers[0]
ego = new Car before intersection by 40 m along way, with speed (5 + 5 * ({inside})) * 1 m/s,
    with behavior FollowTrajectoryBehavior((5 + 5 * ({inside})) * 1 m/s, way)
expect always ego.speed < 7 m/s as "slow"
terminate after 0.1 s
"""


def planted(low: float, high: float) -> str:
    """Return a file whose `expect` breaks exactly where U lies between two numbers."""
    return PLANTED.format(inside=f"(1 if U >= {low} else 0) * (1 if U < {high} else 0)")


BASE, REGRESSION = 0.05, 1e-3
TIMES = 10
"""Runs of an unpaired test, in those of the comparison."""


@dataclass(frozen=True)
class Regression:
    """How often a planted regression is found."""

    pairs: int
    repetitions: int
    paired: float
    """Share of comparisons whose Holm-corrected p is below 0.05."""
    unpaired: float
    """Share of unpaired tests (Fisher) with `TIMES` as many runs that find it."""


def regression(jobs: int, repetitions: int = 100, pairs: int = 10_600) -> Regression:
    """Compare a driver that fails in 5 % of its scenes with one that fails in 1e-3 more."""
    from engine.search.statistics import fisher

    found = 0
    with tempfile.TemporaryDirectory() as home:
        names = _written(Path(home), planted(0.0, BASE), planted(0.0, BASE + REGRESSION))
        for seed in range(repetitions):
            (file,) = _compared(names, seed, jobs, pairs)
            found += file.conditions[0].verdict == "worse"
    stream, runs, unpaired, tries = np.random.default_rng(1), TIMES * pairs, 0, 2000
    for _ in range(tries):
        a, b = (int(stream.binomial(runs, rate)) for rate in (BASE, BASE + REGRESSION))
        unpaired += b > a and fisher((a, b), (runs, runs)).p < 0.05
    return Regression(pairs, repetitions, found / repetitions, unpaired / tries)


def coverage(jobs: int, repetitions: int = 1000, pairs: int = 400) -> float:
    """Return the share of comparisons whose interval holds the true difference: new failures 4 %, cured ones 2 %."""
    held = 0
    with tempfile.TemporaryDirectory() as home:
        names = _written(Path(home), planted(0.10, 0.20), planted(0.12, 0.24))
        for seed in range(repetitions):
            (file,) = _compared(names, seed, jobs, pairs)
            low, high = file.conditions[0].table.interval
            held += low <= 0.02 <= high
    return held / repetitions


ALL: dict[str, Callable[..., Any]] = {
    "identical": lambda options: identical(options.jobs, options.seed),
    "coverage": lambda options: coverage(options.jobs),
    "regression": lambda options: regression(options.jobs),
    "mutants": lambda options: mutants(options.jobs, options.seed, options.truth),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=ALL, action="append", help="one of the questions; may be repeated")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--truth", type=int, default=0, help="plain pairs of each mutant (100000)")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    answers = {name: ALL[name](options) for name in options.only or ALL}
    if options.json:
        plain = {name: _plain(answer) for name, answer in answers.items()}
        print(json.dumps(plain, indent=2))
        return
    for name, answer in answers.items():
        print(f"{name}: {_sentence(name, answer)}")


def _plain(answer: Any) -> Any:
    if isinstance(answer, list):
        return [asdict(each) for each in answer]
    return asdict(answer) if isinstance(answer, Regression) else answer


def _sentence(name: str, answer: Any) -> str:
    match name:
        case "identical":
            return f"{answer} of {len(MUTANTS)} reported"
        case "coverage":
            return f"{100.0 * answer:.1f} % of the intervals hold the difference"
        case "regression":
            paired = (
                f"{100.0 * answer.paired:.0f} % of {answer.repetitions} comparisons of {answer.pairs:,} pairs find it"
            )
            return f"{paired}, {100.0 * answer.unpaired:.0f} % of unpaired tests of {TIMES} times as many runs"
    found = sum(each.found for each in answer)
    drawn = sum(bool(each.drawn) for each in answer)
    head = f"{found} of {len(answer)} found, {drawn} by pairs alone; share of plain pairs, pairs, scenes that differ:"
    return "\n".join((head, *map(_line, answer)))


def _line(each: MutantResult) -> str:
    word = "found" if each.found else "MISSED"
    return f"  {word:7}{each.fault:15}{each.file:18}{each.rate:8.5f}{each.drawn:5}{each.searched:5}"


if __name__ == "__main__":
    main()

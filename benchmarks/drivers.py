"""Where does a driver stand? `python -m benchmarks.drivers [--scenes 2000] [--files A,B,cut_in] [--drivers NAMES]`

`--ego python:package.module:function` or `--ego process:COMMAND` adds a driver of one's own, who drives by pedals every
0.1 s; a scene over which it fails is no collision, nor is it through, and stderr tells of it.

`--list` names the scenes behind `avoidable` and `stood`: `driven(text_of(FILE, DRIVER), NUMBER, NUMBER + 1, 1)` is one.

Each driver of the library drives the same fair scenes of the examples A to F, of `benchmarks.suite`, and of
`crossing`, where somebody uses a crossing of a street (`benchmarks/crossing.scn`); there it is through 15 m behind
the crossing. The ego of a file is replaced by the driver, who follows the same lanes. In A to F it wants to go as
fast as it starts, but at least 30 km/h, so that it can be through within the 20 s of a run; a run ends when the ego
is 3 m behind the intersection. What is fair is asked of the blind driver, who follows its lanes and looks at nobody.

    collisions  share of the scenes in which the ego touches somebody
    avoidable   … that the reference driver of UN R157 avoids, from where this driver has brought itself
    struck      … in which it is struck from behind, or while it stands where one may stand
    stood       … in which it touches somebody, slower than 0.1 m/s, anywhere else
    through     share of the scenes in which it is through within the time, where the blind driver touches nobody
                and comes nobody nearer than 5 m; nothing where the blind driver is never through,
                as on a road without a crossing
    lost        how much longer than the blind driver it takes, on average, where both are through [s]; nothing likewise
"""

import argparse
import json
import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

import cortex_dsl as cx
from engine.assessment import take
from engine.batch import simulate
from engine.driving import blocks
from engine.fairness import fair_starts
from engine.host import requested
from engine.outcomes import Outcomes
from engine.sampling import draw_genomes, sample
from engine.scenes import Scenes
from engine.streams import key_rows
from engine.tables import Bools, Ints
from engine.verdicts import blame
from engine.vocabulary import Blame, EndReason, Fault, Method

ROOT = Path(__file__).parents[1]
EXAMPLES = {
    "A": "left_turn",
    "B": "left_against_crossing",
    "C": "crossing_left_turn",
    "D": "right_and_oncoming_left",
    "E": "right_into_crossing",
    "F": "three_way_left",
}
CROSSING = "crossing"
"""The file of a street with a crossing, beside this one."""
BEHIND_CROSSING = "ego.position.x > 15 m"
DRIVERS = {
    "blind": "FollowTrajectoryBehavior({speed}, {way})",
    "straight brake": "EmergencyBrakeBehavior(FollowTrajectoryBehavior({speed}, {way}), foresees=False)",
    "emergency brake": "EmergencyBrakeBehavior(FollowTrajectoryBehavior({speed}, {way}))",
    "gap acceptance": "GapAcceptanceBehavior({speed}, {way})",
    "gap acceptance + brake": "EmergencyBrakeBehavior(GapAcceptanceBehavior({speed}, {way}))",
    "IDM": "CarFollowingBehavior({speed}, {way})",
    "IDM + brake": "EmergencyBrakeBehavior(CarFollowingBehavior({speed}, {way}))",
    "RSS": "RSSBehavior(FollowTrajectoryBehavior({speed}, {way}))",
    "careful driver": "CarefulDriverBehavior(FollowTrajectoryBehavior({speed}, {way}))",
    "fuzzy safety": "FuzzySafetyBehavior(FollowTrajectoryBehavior({speed}, {way}))",
    "IDM + MOBIL": "LaneChoosingBehavior({speed})",
    "gives way": "GivingWayBehavior({speed}, {way})",
}
"""What each is in the language; `straight brake`: of constant velocities, as it was before 0.3."""
NEAR = 5.0
"""The blind driver met somebody [m]."""
STANDING = 0.1
"""[m/s]"""
SEED = 4_000
BLOCK = 20_000
BEHIND = "(distance from ego to intersection) > 3 m"
THROUGH = f"ego in egoManeuver.endLane and {BEHIND}"
PASSED = f"{BEHIND} and ego.position.y * cos(ego.heading) > ego.position.x * sin(ego.heading)"
"""In files whose ego follows its lane: it drives away from the middle of the intersection."""


@dataclass(frozen=True)
class Row:
    """How one driver does in one file; shares of `scenes`."""

    file: str
    driver: str
    scenes: int
    collisions: float
    avoidable: float
    struck: float
    stood: float
    through: float
    lost: float
    avoided: tuple[int, ...] = ()
    """The numbers of the scenes that count as avoidable …"""
    stood_in: tuple[int, ...] = ()
    """… and of those that count as stood."""


def goes_there(file: str, driver: str) -> bool:
    """Whether a driver can be told the way of the ego; who chooses lanes follows none."""
    if file == CROSSING:
        return "GapAcceptance" not in DRIVERS.get(driver, "")
    return driver not in DRIVERS or "{way}" in DRIVERS[driver] or (file not in EXAMPLES and _of_suite(file)[3] is None)


def text_of(file: str, driver: str) -> str:
    """Return the file with a driver for its ego: a row of `DRIVERS`, a template like these, or one from outside."""
    if file in EXAMPLES:
        return _example(file, driver)
    if file == CROSSING:
        text = (ROOT / "benchmarks" / f"{file}.scn").read_text()
        return _ended(
            text.replace("FollowLaneBehavior(EGO_SPEED)", _driver(driver, "EGO_SPEED", None)), BEHIND_CROSSING
        )
    text, start, end, way = _of_suite(file)
    passed = PASSED if way is None else f"ego in {way}.endLane and {BEHIND}"
    return _ended(text[:start] + _driver(driver, "EGO_SPEED", way) + text[end:], passed)


def _of_suite(file: str) -> tuple[str, int, int, str | None]:
    """The text of a file of the suite, where the behavior of its ego begins and ends, and the ego's way."""
    text = (ROOT / "benchmarks" / "suite" / f"{file}.scn").read_text()
    start = text.index("with behavior ", text.index("ego = new Car")) + len("with behavior ")
    end = _end_of_call(text, start)
    return text, start, end, next((way for way in ("ahead", "turn") if f"EGO_SPEED, {way}" in text[start:end]), None)


def _example(file: str, driver: str) -> str:
    text = (ROOT / "examples" / f"{EXAMPLES[file]}.scn").read_text()
    text = re.sub(r"behavior EgoBehavior.*?\n\n", "", text, count=1, flags=re.DOTALL)
    speed = "max(EGO_SPEED, 30 km/h)"
    text = text.replace("EgoBehavior(egoTrajectory)", _driver(driver, speed, "egoTrajectory"))
    return _ended(re.sub(r"terminate when .* TERM_DIST\n", "", text), THROUGH)


def _driver(driver: str, speed: str, way: str | None) -> str:
    if driver not in DRIVERS and "Behavior(" not in driver:
        return f"ExternalBehavior({'' if way is None else f'trajectory={way}, '}every=0.1 s)"
    if way is None and driver.endswith("blind"):
        return f"FollowLaneBehavior({speed})"
    call = DRIVERS.get(driver, driver).format(speed=speed, way=way or "")
    if way is None:
        call = call.replace("FollowTrajectoryBehavior", "FollowLaneBehavior")
        call = call.replace("GapAcceptanceBehavior", "FollowLaneBehavior")
    return call.replace(", )", ")")


def _end_of_call(text: str, start: int) -> int:
    """Behind the bracket that closes a call."""
    depth = 0
    for at in range(text.index("(", start), len(text)):
        depth += (text[at] == "(") - (text[at] == ")")
        if depth == 0:
            return at + 1
    raise ValueError(text[start:])


def _ended(text: str, through: str) -> str:
    """With runs that go on until the ego is through, or the time is over; every start counts."""
    text = re.sub(r"simulation\(.*\)", "", text)
    return f'{text}\nterminate when {through}\nexpect eventually ({through}) as "it is through"\n'


# -- driving -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class DrivenBlock:
    """A block of scenes, driven by one driver: arrays (n,)."""

    scenes: Scenes
    """As they were drawn."""
    fair: Bools
    outcomes: Outcomes
    blamed: np.ndarray


def driven(text: str, first: int, last: int, jobs: int, fair: bool = False, ego: str = "") -> DrivenBlock:
    """The scenes of these numbers; `fair`: whether to ask for fair starts; `ego`: who drives, if no behavior does."""
    scenario = cx.compile_text(text).driven_by(ego) if ego else cx.compile_text(text)
    program, config = scenario.program, scenario.config.simulation
    keys = key_rows(SEED, Method.SAMPLE, 0, 0, np.arange(first, last))
    scenes = sample(program, draw_genomes(program.space, keys), keys, config, jobs)
    starts = fair_starts(program, requested(program, scenes), config, jobs) if fair else scenes.valid
    if scenario.config.driver is None:
        decided, outcomes = scenes, simulate(program, scenes, config, jobs)
    else:
        done = blocks.driven(scenario.config.driver, program, scenes, scenario.config, jobs)
        decided, outcomes = done.scenes, done.outcomes
    blamed, struck = np.full(len(scenes), int(Blame.NONE), dtype=np.int32), np.flatnonzero(outcomes.collided)
    blamed[struck] = blame(program, take(decided, struck), config, jobs=jobs)  # it runs all that it is given again
    return DrivenBlock(scenes, starts & scenes.valid, outcomes, blamed)


def rows(file: str, drivers: Sequence[str], scenes: int, jobs: int) -> list[Row]:
    """One row a driver, of at least so many fair scenes."""
    counted, named = {name: np.zeros(9) for name in drivers}, {name: [] for name in drivers}
    first, done, passes = 0, 0, False
    while done < scenes and first < 50 * scenes:
        last = first + min(BLOCK, max(500, 2 * (scenes - done)))
        blind = driven(text_of(file, "blind"), first, last, jobs, fair=True)
        for name in drivers:
            ego = "" if name in DRIVERS else name
            one = blind if name == "blind" else driven(text_of(file, name), first, last, jobs, ego=ego)
            assert np.array_equal(one.scenes.valid, blind.scenes.valid), f"{file}: other scenes with {name}"
            counts, blots = _counts(one, blind)
            counted[name] += counts
            named[name].append([first + np.flatnonzero(each) for each in blots])
        passes |= bool((blind.outcomes.end_reason == EndReason.RULE).any())
        done, first = done + int(blind.fair.sum()), last
    return [
        _row(file, name, counted[name], passes, *map(np.concatenate, zip(*named[name], strict=True)))
        for name in drivers
    ]


def _counts(one: DrivenBlock, blind: DrivenBlock) -> tuple[np.ndarray, tuple[Bools, Bools]]:
    """Scenes, collisions, avoidable, struck, stood, of how many it should get through, gets through, …; and which
    collisions are avoidable, and in which it stood.
    """
    outcomes, fair = one.outcomes, blind.fair
    every = np.arange(len(fair))
    pair = np.maximum(outcomes.contact_actors[:, 1] - 1, 0)
    hits = fair & outcomes.collided
    may_stand = outcomes.fault[every, pair] != Fault.EGO
    avoidable = hits & (one.blamed == Blame.AVOIDABLE)
    stood = hits & (np.abs(outcomes.ego_speed[every, pair]) < STANDING) & ~may_stand
    free = fair & ~blind.outcomes.collided & (blind.outcomes.min_distance.min(axis=1) > NEAR)
    through, blinds = (each.outcomes.end_reason == EndReason.RULE for each in (one, blind))
    both = fair & through & blinds
    lost = (outcomes.end_time - blind.outcomes.end_time)[both]
    shares = [
        fair,
        hits,
        avoidable,
        hits & (one.blamed == Blame.STRUCK),
        stood,
        free,
        free & through,
        both,
    ]
    return np.array([*(float(each.sum()) for each in shares), float(lost.sum())]), (avoidable, stood)


def _row(file: str, driver: str, counts: np.ndarray, passes: bool, avoided: Ints, stood_in: Ints) -> Row:
    scenes, hits, avoidable, struck, stood, free, through, both, lost = (float(number) for number in counts)
    hits, avoidable, struck, stood = (each / max(scenes, 1.0) for each in (hits, avoidable, struck, stood))
    through = through / free if passes and free else float("nan")
    lost = lost / both if passes and both else float("nan")
    which = tuple(avoided.tolist()), tuple(stood_in.tolist())
    return Row(file, driver, int(scenes), hits, avoidable, struck, stood, through, lost, *which)


# -- the table ---------------------------------------------------------------------------------------------------------


def table(made: Sequence[Row]) -> str:
    """As Markdown."""
    return "\n".join(_lines(made))


def _plain(row: Row) -> dict[str, object]:
    """As JSON has it, which knows no NaN."""
    return {name: None if value != value else value for name, value in asdict(row).items()}


def across(made: Sequence[Row]) -> str:
    """Files in rows and drivers in columns: collisions, and how many of them are avoidable, in per cent."""
    drivers = list(dict.fromkeys(row.driver for row in made))
    cells = {(row.file, row.driver): f"{100 * row.collisions:.2f} ({100 * row.avoidable:.2f})" for row in made}
    files = dict.fromkeys(row.file for row in made)
    lines = (f"| {file} | {' | '.join(cells.get((file, driver), '') for driver in drivers)} |" for file in files)
    return "\n".join([f"| file | {' | '.join(drivers)} |", "|---" * (1 + len(drivers)) + "|", *lines])


def blots(made: Sequence[Row]) -> str:
    """The scenes behind two of its columns, by number."""
    lines = [(row, what, ids) for row in made for what, ids in (("avoidable", row.avoided), ("stood", row.stood_in))]
    return "\n".join(f"{row.file}, {row.driver}, {what}: {', '.join(map(str, ids))}" for row, what, ids in lines if ids)


def _lines(made: Sequence[Row]) -> Iterator[str]:
    yield "| file | driver | collisions | avoidable | struck | stood | through | lost |"
    yield "|---|---|---|---|---|---|---|---|"
    for row in made:
        shares = " | ".join(f"{100 * each:.2f} %" for each in (row.collisions, row.avoidable, row.struck, row.stood))
        through = "" if row.through != row.through else f"{100 * row.through:.1f} %"
        lost = "" if row.lost != row.lost else f"{row.lost:+.1f} s"
        yield f"| {row.file} | {row.driver} | {shares} | {through} | {lost} |"


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.drivers", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--scenes", type=int, default=2000, help="fair ones of each file")
    parser.add_argument(
        "--files", default=",".join(EXAMPLES), help="A to F, `crossing`, and names of the suite, or `suite`, or `all`"
    )
    parser.add_argument("--drivers", default=",".join(DRIVERS), help="names with commas between them")
    parser.add_argument("--ego", metavar="NAME", help="one more: python:package.module:function or process:COMMAND")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--list", action="store_true", help="the numbers of the scenes that are avoidable, or stood in")
    parser.add_argument("--across", action="store_true", help="drivers in columns: collisions (of them avoidable)")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    suite = sorted(file.stem for file in (ROOT / "benchmarks" / "suite").glob("*.scn"))
    groups = {"suite": suite, "all": [*EXAMPLES, *suite, CROSSING]}
    files = groups.get(options.files) or options.files.split(",")
    for name in [each for each in files if each not in groups["all"]]:
        parser.error(f"there is no file `{name}`; there are {', '.join(groups['all'])}")
    for name in [each for each in options.drivers.split(",") if each not in DRIVERS]:
        parser.error(f"there is no driver `{name}`; there are {', '.join(DRIVERS)}, and --ego names one of your own")
    every = [*options.drivers.split(","), *([options.ego] if options.ego else [])]
    drivers = {file: [each for each in every if goes_there(file, each)] for file in files}
    made = [row for file in files for row in rows(file, drivers[file], options.scenes, options.jobs)]
    print(json.dumps([_plain(row) for row in made]) if options.json else (across if options.across else table)(made))
    if options.list and not options.json:
        print(blots(made))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

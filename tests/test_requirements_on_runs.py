"""Temporal requirements, monitors, guards, choices and records in both hosts, on runs that can be worked out by hand.

The ego drives east at 10 m/s from x = -40 m; a step is 0.05 s, so it is at x = -40 + 0.5 k at sample k, and beyond the
line x = -25.2 m from sample 30 on, which is at 1.5 s.
"""

import numpy as np
import pytest
from scipy.stats import chisquare

from cortex_dsl import Scenario, compile_text
from engine.outcomes import Outcomes
from engine.vocabulary import EndReason, Verdict

HEAD = "map intersection(approach=60 m)\nsimulation(time_step=0.05 s, max_time=4 s)\n"
EGO = "ego = new Car at (-40, -1.75), facing 0 deg, with speed 10 m/s, with behavior {}\n"
STRAIGHT = EGO.format("ConstantSpeedBehavior(10 m/s)")
BEYOND, BEFORE = "ego.x > -25.2 m", "ego.x < -25.2 m"
LINE = 1.5
"""When the ego is beyond the line [s]."""

ENGINES = pytest.mark.parametrize("engine", ["batch", "world"])


def run(text: str, engine: str = "batch", count: int = 1) -> tuple[Scenario, Outcomes]:
    scenario = compile_text(HEAD + text)
    return scenario, scenario.simulate(scenario.sample(count), engine)


def verdict(text: str, engine: str) -> tuple[Verdict, EndReason, str, float]:
    """Of one run: verdict, reason, the name of the rule that ended it, and when [s]."""
    scenario, outcome = run(text, engine)
    rule = int(outcome.end_rule[0])
    name = scenario.program.rules[rule].name if rule >= 0 else ""
    time = round(float(outcome.end_time[0]), 9)
    return Verdict(outcome.verdict[0]), EndReason(outcome.end_reason[0]), name, time


def aborted(name: str, time: float) -> tuple[Verdict, EndReason, str, float]:
    return Verdict.ABORTED, EndReason.ABORTED, name, time


TIMEOUT = (Verdict.VALID, EndReason.TIMEOUT, "", 4.0)

# -- temporal requirements --------------------------------------------------------------------------------------------


LEAVES = "other = new Car at (-60, 1.75), facing 180 deg, with speed 10 m/s, with behavior FollowLaneBehavior(10 m/s)\n"


@ENGINES
@pytest.mark.parametrize(
    ("declared", "end"),
    [
        ("", EndReason.ALL_DONE),
        (f"require {BEFORE}", EndReason.ALL_DONE),
        (f"terminate when {BEYOND}", EndReason.ALL_DONE),
        (f"require always {BEFORE}", EndReason.ABORTED),
        (f"require not eventually {BEYOND}", EndReason.ABORTED),
        (f"require always ego in road\nterminate when {BEYOND}", EndReason.RULE),
        (f"record final ego.speed\nterminate when {BEYOND}", EndReason.RULE),
        (f"expect always {BEYOND} as X\nterminate when {BEYOND}", EndReason.RULE),
    ],
)
def test_what_looks_at_the_whole_run_keeps_it_alive(declared: str, end: EndReason, engine: str) -> None:
    """The other leaves at once, and the ego goes on alone: who looks sees what it does then."""
    _, outcome = run(STRAIGHT + LEAVES + declared + "\n", engine)
    assert outcome.end_reason[0] == end
    alone = end == EndReason.ALL_DONE
    assert (outcome.end_time[0] < 1.0) == alone


@ENGINES
@pytest.mark.parametrize(
    ("condition", "time"),
    [
        (f"always {BEFORE}", LINE),
        (f"always ({BEYOND} implies ego.speed > 11 m/s)", LINE),
        (f"always ({BEFORE} or ego.speed > 11 m/s)", LINE),
        (f"(always {BEFORE}) and (eventually {BEYOND})", 4.0),
        ("eventually ego.x > 0.1 m", 4.0),
        ("next ego.x > -39.4 m", 4.0),
        (f"{BEFORE} until ego.speed > 11 m/s", 4.0),
        (f"not eventually {BEYOND}", 4.0),
        (f"always next {BEFORE}", LINE - 0.05),
        (f"always eventually {BEFORE}", LINE),
    ],
)
def test_broken(condition: str, time: float, engine: str) -> None:
    """The run is aborted when it is decided: at the first sample that breaks an `always`, else at its end."""
    assert verdict(STRAIGHT + f"require {condition}\n", engine) == aborted(condition, time)


@ENGINES
@pytest.mark.parametrize(
    "condition",
    [
        "always ego.x < 0.1 m",
        f"eventually {BEYOND}",
        "eventually ego.x > -0.1 m",
        "next ego.x > -39.6 m",
        "next next ego.x > -39.1 m",
        f"{BEFORE} until {BEYOND}",
        f"(always {BEFORE}) implies ego.speed > 11 m/s",
        f"eventually always {BEYOND}",
        f"always ({BEFORE} implies eventually {BEYOND})",
        f"not always {BEFORE}",
    ],
)
def test_kept(condition: str, engine: str) -> None:
    """A requirement that holds leaves no trace."""
    assert verdict(STRAIGHT + f"require {condition}\n", engine) == TIMEOUT


@ENGINES
def test_a_requirement_at_the_end_beats_the_end(engine: str) -> None:
    """Both look at the same sample: the run is invalid, whatever the order in the file."""
    text = STRAIGHT + f"terminate when {BEYOND}\nrequire always {BEFORE}\n"
    assert verdict(text, engine) == aborted(f"always {BEFORE}", LINE)


IN_RUN = f"scenario Main():\n    setup:\n        require always {BEFORE}\n"
IN_PART = (
    "scenario Main():\n    compose:\n        do Part()\n        wait\n"
    f"scenario Part():\n    setup:\n        require always {BEFORE}\n        terminate when {BEYOND}\n"
)


@ENGINES
@pytest.mark.parametrize("text", [f"terminate when {BEYOND}\n{IN_RUN}", IN_PART], ids=["run", "part"])
def test_a_requirement_of_a_scenario_beats_its_end(text: str, engine: str) -> None:
    """What a setup requires holds at the sample too at which the run, or the scenario itself, is ended."""
    assert verdict(STRAIGHT + text, engine) == aborted(f"always {BEFORE}", LINE)


@ENGINES
def test_contact_stays_contact(engine: str) -> None:
    """What would break after contact is not looked at."""
    text = STRAIGHT + "rock = new Obstacle at (-25, -1.75), with width 2 m, with length 2 m\n"
    _, outcome = run(text + f"require always {BEFORE}\n", engine)
    assert (outcome.verdict[0], outcome.end_reason[0]) == (Verdict.VALID, EndReason.COLLISION)


@ENGINES
def test_an_aborted_run_is_invalid(engine: str) -> None:
    """It scores -1 and has no metrics."""
    scenario, outcome = run(STRAIGHT + f"other = new Car at (40, 1.75)\nrequire always {BEFORE}\n", engine)
    assert np.isnan(outcome.min_distance[0]).all()
    assert scenario.assess(outcome).score[0] == -1


# -- monitors ---------------------------------------------------------------------------------------------------------

SOON = """\
monitor Soon(car, line, limit):
    steps = 0
    while car.x < line:
        require steps < limit
        steps = steps + 1
        wait
    terminate simulation
"""


@ENGINES
def test_a_monitor_counts(engine: str) -> None:
    """It keeps state from sample to sample, ends the run, or breaks it."""
    done = verdict(SOON + STRAIGHT + "require monitor Soon(ego, -25.2 m, 30)\n", engine)
    assert done == (Verdict.VALID, EndReason.RULE, "`terminate simulation` in Soon", LINE)
    late = verdict(SOON + STRAIGHT + "require monitor Soon(ego, -25.2 m, 20)\n", engine)
    assert late == aborted("require in Soon: steps < limit", 1.0)


@ENGINES
def test_two_instances_of_a_monitor(engine: str) -> None:
    """Each has its own arguments and variables."""
    text = SOON + STRAIGHT + "require monitor Soon(ego, -25.2 m, 90)\nrequire monitor Soon(ego, -30.2 m, 90)\n"
    assert verdict(text, engine)[3] == 1.0


@ENGINES
def test_soft_require_in_a_monitor(engine: str) -> None:
    """It is enforced with its probability, by a coin for each execution."""
    text = "monitor M():\n    require[0.3] ego.speed > 11 m/s\n    wait\n" + STRAIGHT + "require monitor M()\n"
    count = 600 if engine == "batch" else 60
    _, outcome = run(text, engine, count)
    broken = int((outcome.verdict == Verdict.ABORTED).sum())
    assert chisquare([broken, count - broken], [0.3 * count, 0.7 * count]).pvalue > 1e-3


# -- guards -----------------------------------------------------------------------------------------------------------


HANDLER = "    try:\n        do IdleBehavior()\n    interrupt when self.x > -20.2 m:\n        wait\n"


@ENGINES
@pytest.mark.parametrize(
    ("body", "name", "time"),
    [
        ("    precondition: self.speed > 11 m/s\n    wait\n", "precondition of B: self.speed > 11 m/s", 0.0),
        ("    invariant: self.speed > 11 m/s\n    wait\n", "invariant of B: self.speed > 11 m/s", 0.0),
        ("    invariant: self.x < -25.2 m\n    while True:\n        wait\n", "invariant of B: self.x < -25.2 m", LINE),
        (
            "    invariant: self.x < -25.2 m\n    do IdleBehavior() for 2 s\n    wait\n",
            "invariant of B: self.x < -25.2 m",
            2.0,
        ),
        (
            "    invariant: self.x < -25.2 m\n    do Steps() \n    wait\n",
            "invariant of B: self.x < -25.2 m",
            1.75,
        ),
        (f"    invariant: self.x < -25.2 m\n{HANDLER}", "invariant of B: self.x < -25.2 m", 2.0),
        ("    do IdleBehavior() for 1 s\n    require self.x > 0 m\n", "require in B: self.x > 0 m", 1.0),
    ],
    ids=["precondition", "at start", "own turn", "for", "sub-behavior", "handler", "require"],
)
def test_guards(body: str, name: str, time: float, engine: str) -> None:
    """Invariants are tested while the behaviour itself runs, rest while another does, and are tested at its return."""
    steps = "behavior Steps():\n    n = 0\n    while n < 35:\n        n = n + 1\n        wait\n"
    assert verdict(f"{steps}behavior B():\n{body}" + EGO.format("B()"), engine) == aborted(name, time)


@ENGINES
def test_an_invariant_may_be_broken_inside_what_it_does(engine: str) -> None:
    """If it holds again before control returns, nothing is said."""
    guard = "    invariant: self.x < -25.2 m or self.x > -15.2 m\n"
    text = f"behavior B():\n{guard}    do IdleBehavior() for 3 s\n    wait\n"
    assert verdict(text + EGO.format("B()"), engine) == TIMEOUT


# -- choices ----------------------------------------------------------------------------------------------------------

STEPS = "behavior Steps(count):\n    n = 0\n    while n < count:\n        n = n + 1\n        wait\n"
LAST = "behavior Last(count):\n    do Steps(count)\n    terminate\n"


def ends(text: str, count: int, engine: str = "batch") -> np.ndarray:
    """At which sample each of many runs ends."""
    _, outcome = run(STEPS + LAST + text + EGO.format("B()"), engine, count)
    assert (outcome.end_reason == EndReason.RULE).all()
    return np.rint(outcome.end_time / 0.05).astype(int)


@ENGINES
def test_choose_by_weight(engine: str) -> None:
    """Each option is as likely as its weight over their sum."""
    count = 3000 if engine == "batch" else 90
    found = ends("behavior B():\n    do choose {Last(1): 1, Last(2): 2, Last(3): 3}\n", count, engine)
    observed = np.bincount(found, minlength=4)[1:]
    assert chisquare(observed, np.array([1, 2, 3]) / 6 * count).pvalue > 1e-3


def test_hosts_choose_alike() -> None:
    """The same stream, the same choice."""
    text = "behavior B():\n    do choose {Last(1): 1, Last(2): 2, Last(3): 3}\n"
    assert (ends(text, 40) == ends(text, 40, "world")).all()


def test_a_gene_may_weigh() -> None:
    """A weight of 0 is never taken."""
    text = "param P = Range(0, 1)\nbehavior B():\n    do choose {Last(1): P, Last(2): 1 - P}\n" + EGO.format("B()")
    scenario = compile_text(HEAD + STEPS + LAST + text)
    for share in (0.0, 1.0):
        outcome = scenario.simulate(scenario.sample(50, genome=np.array([share])))
        assert set(np.rint(outcome.end_time / 0.05)) == {2.0 - share}


def test_shuffle_is_uniform() -> None:
    """Who comes before the one that ends the run: nobody, either or both, as in a shuffled deck."""
    count = 3000
    found = ends("behavior B():\n    do shuffle Last(1), Steps(2), Steps(4)\n", count)
    observed = [(found == end).sum() for end in (1, 3, 5, 7)]
    assert sum(observed) == count
    assert chisquare(observed, np.array([2, 1, 1, 2]) / 6 * count).pvalue > 1e-3


def test_shuffle_by_weight() -> None:
    """The next is drawn by weight among those that are left."""
    count = 3000
    found = ends("behavior B():\n    do shuffle {Last(1): 1, Steps(2): 2, Steps(4): 3}\n", count)
    observed = [(found == end).sum() for end in (1, 3, 5, 7)]
    first, two, three = 1 / 6, 2 / 6 * 1 / 4, 3 / 6 * 1 / 3
    assert chisquare(observed, np.array([first, two, three, 1 - first - two - three]) * count).pvalue > 1e-3


GUARDED = "behavior Fast(count):\n    precondition: self.speed > 11 m/s\n    do Last(count)\n"


@ENGINES
def test_options_that_may_not_start_are_left_out(engine: str) -> None:
    """By a precondition or an invariant."""
    text = GUARDED + "behavior Near():\n    invariant: self.x > 0 m\n    wait\n"
    found = ends(text + "behavior B():\n    do choose {Fast(1): 1000, Near(): 1000, Last(2): 0.001}\n", 20, engine)
    assert set(found) == {2}


@ENGINES
def test_nothing_left_to_choose(engine: str) -> None:
    """The run is aborted where the statement stands, and in a shuffle as soon as only such options are left."""
    choose = GUARDED + "behavior B():\n    do IdleBehavior() for 1 s\n    do choose Fast(1), Fast(2)\n"
    name = "do {} in B: no option may start"
    assert verdict(STEPS + LAST + choose + EGO.format("B()"), engine) == aborted(name.format("choose"), 1.0)
    shuffle = GUARDED + "behavior B():\n    do shuffle Fast(1), Steps(10), Steps(6)\n"
    assert verdict(STEPS + LAST + shuffle + EGO.format("B()"), engine) == aborted(name.format("shuffle"), 0.8)


@ENGINES
def test_until_ends_the_whole_choice(engine: str) -> None:
    """`do shuffle … until c` leaves whatever runs."""
    text = f"behavior B():\n    do shuffle IdleBehavior(), BrakeBehavior(0) until self{BEYOND[3:]}\n    terminate\n"
    assert set(ends(text, 5, engine)) == {30}


# -- records ----------------------------------------------------------------------------------------------------------


def test_records_hold_what_was_seen() -> None:
    """Series, first and last value, and truths, in SI units."""
    text = STRAIGHT + "record ego.position as p\nrecord initial ego.x as first\nrecord final ego.x as last\n"
    scenario = compile_text(HEAD + text + f"record {BEYOND} as beyond\nterminate after 2 s\n")
    kept = {record.name: record.values for record in scenario.watch(scenario.sample()).records}
    assert set(kept) == {"p.x", "p.y", "first", "last", "beyond"}
    assert kept["p.x"] == pytest.approx(-40 + 0.5 * np.arange(41))
    assert kept["p.y"] == pytest.approx(np.full(41, -1.75))
    assert kept["first"] == pytest.approx([-40.0])
    assert kept["last"] == pytest.approx([-20.0])
    assert kept["beyond"].tolist() == [0.0] * 30 + [1.0] * 11

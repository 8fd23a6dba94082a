"""Modular scenarios: which one runs, what its sub-scenarios set up, when they start and end, in both hosts."""

from collections.abc import Callable

import numpy as np
import pytest

from cortex_dsl import Scenario, compile_text, ir
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.semantics.acting.yielding import everything
from engine.driving.observations import series
from engine.outcomes import Outcomes
from engine.vocabulary import EndReason, State

MAP = "map intersection(ways=4, lanes=1, approach=80 m)\nlane = network.intersections[0].incomingLanes[0]\n"
PARTS = """
behavior Hold(v):
    do ConstantSpeedBehavior(v)

scenario Box(y):
    setup:
        box = new Obstacle at (30 m, y), with regionContainedIn None

scenario Slow(car, v=2 m/s):
    setup:
        override car with behavior Hold(v)

scenario Other():
    setup:
        other = new Car at (60 m, 60 m), with speed 3 m/s, with behavior Hold(3 m/s), with regionContainedIn None
"""
MAIN = """
scenario Main():
    setup:
        ego = new Car at (-60 m, 60 m), facing 0 deg, with speed 8 m/s, with behavior Hold(8 m/s), \
            with regionContainedIn None
    compose:
"""


def composed(*lines: str, before: str = "") -> Scenario:
    return compile_text(MAP + PARTS + before + MAIN + "".join(f"        {line}\n" for line in lines))


def refusal(*lines: str, before: str = "") -> set[str]:
    with pytest.raises(CompileError) as caught:
        composed(*lines, before=before)
    return {d.code for d in caught.value.diagnostics}


def outcome(scenario: Scenario) -> tuple[Outcomes, Outcomes]:
    scenes = scenario.sample(1)
    assert scenes.valid.all()
    return scenario.simulate(scenes), scenario.simulate(scenes, engine="world")


def end_time(scenario: Scenario) -> float:
    """When the run ends; the same in both hosts."""
    batch, world = outcome(scenario)
    assert batch.end_time[0] == pytest.approx(world.end_time[0], abs=1e-9)
    assert batch.end_reason[0] == world.end_reason[0]
    return float(batch.end_time[0])


def speeds(scenario: Scenario, actor: int) -> np.ndarray:
    """(samples,) speed of an object over time."""
    return scenario.watch(scenario.sample(1)).trajectory.states[:, actor, State.SPEED]


# -- which one runs ---------------------------------------------------------------------------------------------------

TWO = "scenario A():\n    setup:\n        D = 3 m\n\nscenario B(gap=5 m):\n    setup:\n        D = gap\n"


def test_named_scenario_runs() -> None:
    """`Main` by default; another by name; the file's top level belongs to both."""
    text = MAP + PARTS + MAIN + "        do Box(9 m) for 1 s\n"
    text += "\nscenario Alone():\n    setup:\n        ego = new Car in lane.centerline\n        terminate after 2 s\n"
    assert compile_text(text).program.actors == ("ego", "box")
    chosen = compile_text(text, scenario="Alone")
    assert (chosen.program.actors, chosen.program.settings.max_time) == (("ego",), 2.0)


def test_only_scenario_that_none_starts_runs() -> None:
    text = "scenario A():\n    setup:\n        ego = new Car in lane.centerline\n"
    text += "scenario B():\n    compose:\n        do A() for 2 s\n"
    assert end_time(compile_text(MAP + text)) == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("text", "chosen", "code"),
    [
        (TWO, None, "SCN242"),
        (TWO, "C", "SCN241"),
        ("scenario Main(gap):\n    setup:\n        D = gap\n", None, "SCN243"),
    ],
)
def test_unclear_choice_is_refused(text: str, chosen: str | None, code: str) -> None:
    with pytest.raises(CompileError) as caught:
        compile_text(MAP + "ego = new Car in lane.centerline\n" + text, scenario=chosen)
    assert code in {d.code for d in caught.value.diagnostics}


# -- when things start and end ----------------------------------------------------------------------------------------


FOR = "scenario For(t):\n    setup:\n        terminate after t\n\n"
NESTED = "scenario Twice(t):\n    compose:\n        do For(t)\n        do For(t)\n\n"


@pytest.mark.parametrize(
    ("lines", "seconds"),
    [
        (("do Box(9 m) for 1 s", "do Box(20 m) for 1.5 s"), 2.5),
        (("do For(1 s)", "do For(0.5 s)"), 1.5),
        (("do For(1 s), For(2 s)", "do For(0.5 s)"), 2.5),
        (("do Twice(1 s), For(1.5 s)", "do Twice(0.2 s)"), 2.4),
        (("for i in range(3):", "    do Twice(0.1 s)"), 0.6),
        (("do shuffle For(1 s), Twice(0.5 s)",), 2.0),
    ],
)
def test_a_compose_takes_as_long_as_its_parts(lines: tuple[str, ...], seconds: float) -> None:
    """To the sample: what one ends, the next begins, side by side the last counts, however deep."""
    assert end_time(composed(*lines, before=FOR + NESTED)) == pytest.approx(seconds, abs=1e-9)


def test_what_is_interrupted_waits() -> None:
    """As in Scenic: a scenario has no turns while a handler of its caller runs, and then goes on where it was."""
    before = FOR + "scenario Steps():\n    compose:\n        do For(0.5 s)\n        for i in range(10):\n"
    before += "            wait\n\n"
    lines = "done = False", "try:", "    do Steps()", "interrupt when ego.x > -54 m and not done:"
    handler = "    do For(1 s)", "    done = True"
    assert end_time(composed(*lines, *handler, before=before)) == pytest.approx(2.0, abs=1e-9)


WISH = "other = new Object at (60 m, 60 m), with wish 5\nscenario Wish(v):\n    setup:\n"
WISH += "        override other with wish v\n"


def test_a_record_sees_what_is_overridden_in_the_same_sample() -> None:
    """As in Scenic, which composes, then records: while it holds, and not once it has ended."""
    before = WISH + "record other.wish as wish\n"
    scenario = composed("do Wish(7) for 0.2 s", "wait for 0.1 s", "do Wish(9) for 0.1 s", before=before)
    (record,) = scenario.watch(scenario.sample(1)).records
    assert record.values.tolist() == [7, 7, 7, 7, 5, 5, 9, 9, 5]


def test_terminate_when_is_asked_for_once_the_compose_has_acted() -> None:
    """As in Scenic: what is started in a sample counts in it, so that a scenario may end in its first."""
    before = WISH + "scenario Never():\n    setup:\n        terminate when other.wish > 6\n"
    before += (
        "    compose:\n        do Wish(7)\n\nscenario Late():\n    setup:\n        terminate when other.wish > 6\n"
    )
    before += "    compose:\n        wait for 0.2 s\n        do Wish(7)\n\n"
    assert end_time(composed("wait for 0.1 s", "do Never()", before=before)) == pytest.approx(0.1, abs=1e-9)
    assert end_time(composed("do Late()", "wait for 0.1 s", before=before)) == pytest.approx(0.3, abs=1e-9)


def test_until_sees_the_objects_of_the_scenario() -> None:
    scenario = composed("s = Box(90 m)", "do s until ego.x > s.box.x")
    assert end_time(scenario) == pytest.approx(90.0 / 8.0, abs=0.11)


def test_objects_come_when_their_scenario_starts() -> None:
    """Those that surely start with the run are there; others are absent and come in by a `Spawn`."""
    (variant,) = composed("do Box(9 m) for 1 s", "do Other() for 1 s").compiled.scenario.variants
    assert [(actor.name, actor.present) for actor in variant.actors] == [("ego", True), ("box", True), ("other", False)]
    spawned = [act.actors for monitor in variant.monitors for act in everything(monitor.body) if type(act) is ir.Spawn]
    assert spawned == [(2,)]


def test_behaviours_of_a_stopped_scenario_stop() -> None:
    """`Other` drives at 3 m/s while its scenario runs; afterwards nobody holds its speed, and nobody brakes."""
    before = "scenario Braking():\n    setup:\n"
    before += "        other = new Car at (60 m, 60 m), with speed 9 m/s, with regionContainedIn None,\n"
    before += "            with behavior BrakeBehavior(0.3)\n"
    speed = speeds(composed("do Braking() for 0.5 s", "do Box(9 m) for 1 s", before=before), 1)
    assert speed[0] == 9.0
    assert np.ptp(speed[15:]) == 0.0
    assert 3.0 < speed[15] < 9.0


def test_override_lasts_as_long_as_its_scenario() -> None:
    """The ego is slowed down while `Slow` runs, and then takes up its own behaviour again."""
    speed = speeds(composed("do Box(9 m) for 1 s", "do Slow(ego) for 4 s", "do Box(20 m) for 5 s"), 0)
    assert speed[19] == pytest.approx(8.0, abs=0.05)
    assert speed[95] == pytest.approx(2.0, abs=0.05)
    assert speed[-1] == pytest.approx(8.0, abs=0.05)


HEEDFUL = """
behavior Heed():
    while True:
        take SetSpeedAction(self.wish)

scenario Wish(car, v):
    setup:
        override car with wish v

"""


def test_override_of_a_property_lasts_as_long_as_its_scenario() -> None:
    """Of the file's own: who reads it sees the value of the scenario that runs, the later one where two do."""
    before = HEEDFUL + "other = new Car at (60 m, 60 m), with wish 5 m/s, with behavior Heed(), "
    before += "with regionContainedIn None\n"
    lines = (
        "wait for 1 s", "do Wish(other, 7 m/s) for 1 s", "wait for 1 s",
        "do Wish(other, 7 m/s), Wish(other, 9 m/s) for 1 s",
    )  # fmt: skip
    scenario = composed(*lines, before=before)
    speed = speeds(scenario, 1)
    assert [speed[step] for step in (10, 30, 50, 70)] == [5.0, 7.0, 5.0, 9.0]
    assert end_time(scenario) == pytest.approx(4.0, abs=0.21)


def test_a_property_is_overridden_or_set() -> None:
    before = "behavior Count():\n    while True:\n        self.laps += 1\n        wait\n\n"
    before += "other = new Car at (60 m, 60 m), with laps 0, with behavior Count(), with regionContainedIn None\n"
    before += "scenario Late():\n    setup:\n        override other with laps 9\n\n"
    assert "SCN551" in refusal("do Late()", before=before)


OWN = """
K = 2 m/s
scenario Own(shift):
    setup:
        param FAST = Range(3, 4) m/s
        behavior Drive(v):
            top = v + shift
            while True:
                take SetSpeedAction(top)
        monitor Slow():
            while True:
                require other.speed < 90 m/s
                wait
        def doubled(v):
            return v * 2 + K
        other = new Car at (60 m, 60 m), with behavior Drive(doubled(FAST)), with regionContainedIn None
        require monitor Slow()
"""


def test_scenarios_have_params_and_definitions_of_their_own() -> None:
    """A behaviour, a monitor and a function see the names of the scenario; its param is a gene that `-p` sets."""
    scenario = composed("do Own(1 m/s) for 1 s", before=OWN)
    assert scenario.program.space.names == ("FAST",)
    text = MAP + PARTS + OWN + MAIN + "        do Own(1 m/s) for 1 s\n"
    fixed = compile_text(text, FAST="3 m/s")
    assert speeds(fixed, 1)[10] == 9.0
    assert end_time(fixed) == pytest.approx(1.0, abs=0.11)


def test_a_copy_holds_the_params_of_scenarios() -> None:
    """What was drawn stands in the copy, which has no gene left."""
    text = MAP + PARTS + OWN + MAIN + "        do Own(1 m/s) for 1 s\n"
    scenario = compile_text(text)
    copy = compile_text(scenario.concrete(scenario.sample(1), 0))
    assert copy.program.space.names == ()
    assert speeds(copy, 1)[10] == speeds(scenario, 1)[10]


def test_definitions_of_a_scenario_are_its_own() -> None:
    """Elsewhere the name means nothing."""
    before = OWN + "late = new Car at (9, 9), with behavior Drive(3 m/s)\n"
    assert "SCN201" in refusal("do Own(1 m/s) for 1 s", before=before)


def test_interrupts_switch_scenarios() -> None:
    scenario = composed(
        "try:", "    do Box(9 m)", "interrupt when ego.x > -50 m:", "    do Other() for 1 s", "    abort"
    )
    assert end_time(scenario) == pytest.approx(10.0 / 8.0 + 1.0, abs=0.16)


@pytest.mark.parametrize("mode", ["choose", "shuffle"])
def test_scenarios_can_be_drawn(mode: str) -> None:
    """One of two that take one second, or both."""
    before = "scenario For(t):\n    setup:\n        terminate after t\n"
    expected = 1.0 if mode == "choose" else 2.0
    assert end_time(composed(f"do {mode} For(1 s), For(1 s)", before=before)) == pytest.approx(expected, abs=0.16)


def test_nested_scenarios_end_with_their_parent() -> None:
    """What a stopped scenario had started stops too, its monitors included."""
    before = "monitor Fast():\n    while True:\n        require ego.x < -40 m\n        wait\n\n"
    before += "scenario Inner():\n    setup:\n        require monitor Fast()\n\n"
    before += "scenario Outer():\n    compose:\n        do Inner()\n\n"
    batch, world = outcome(composed("do Outer() for 1 s", "do Box(9 m) for 9 s", before=before))
    assert batch.end_reason[0] == world.end_reason[0] == EndReason.RULE
    batch, world = outcome(composed("do Outer() for 9 s", before=before))
    assert batch.end_reason[0] == world.end_reason[0] == EndReason.ABORTED


@pytest.mark.parametrize("guard", ["invariant: ego.x < -40 m", "precondition: ego.x > 0 m"])
def test_guards_abort_the_run(guard: str) -> None:
    before = f"scenario Guarded():\n    {guard}\n    setup:\n        D = 3 m\n"
    batch, world = outcome(composed("do Guarded() for 9 s", before=before))
    assert batch.end_reason[0] == world.end_reason[0] == EndReason.ABORTED


def test_always_holds_while_the_scenario_runs() -> None:
    """`require always` of a scenario that is over asks for nothing any more."""
    before = "scenario Watch():\n    setup:\n        require always ego.x < -40 m\n"
    early = composed("do Watch() for 1 s", "do Box(9 m) for 9 s", before=before)
    late = composed("do Watch() for 9 s", before=before)
    assert [outcome(each)[0].end_reason[0] for each in (early, late)] == [EndReason.RULE, EndReason.ABORTED]


def test_terminate_ends_the_scenario_or_the_run() -> None:
    """In the behaviour of an object of a sub-scenario `terminate` ends that scenario, `terminate simulation` all."""
    before = "behavior Leave():\n    do ConstantSpeedBehavior(3 m/s) for 1 s\n    terminate{}\n\n"
    before += "scenario Short():\n    setup:\n        other = new Car at (60 m, 60 m), with speed 3 m/s,\n"
    before += "            with behavior Leave(), with regionContainedIn None\n"
    lines = "do Short()", "do Box(9 m) for 1 s"
    assert end_time(composed(*lines, before=before.format(""))) == pytest.approx(2.0, abs=0.16)
    assert end_time(composed(*lines, before=before.format(" simulation"))) == pytest.approx(1.0, abs=0.11)


def test_a_handler_cannot_make_its_objects_twice() -> None:
    """The second time the run is aborted, by a rule that says so."""
    lines = "try:", "    do Box(9 m)", "interrupt when ego.x > -50 m:", "    do Other() for 1 s"
    scenario = composed(*lines)
    batch, _ = outcome(scenario)
    assert batch.end_reason[0] == EndReason.ABORTED
    assert scenario.program.rules[int(batch.end_rule[0])].name == "Other starts a second time"


def test_two_calls_make_two_sets_of_objects() -> None:
    assert composed("do Box(9 m), Box(20 m) for 1 s").program.actors == ("ego", "box", "box2")


def test_ego_may_come_with_the_first_scenario() -> None:
    """A scenario without an ego takes that of what it starts."""
    text = "scenario A():\n    setup:\n        box = new Obstacle at (9 m, 30 m), with regionContainedIn None\n"
    text += "        ego = new Car in lane.centerline, with speed 3 m/s\n\n"
    text += "scenario Main():\n    compose:\n        do A() until ego.speed > 1 m/s\n"
    assert compile_text(MAP + text).program.actors == ("ego", "box")


@pytest.mark.parametrize(
    ("lines", "code"),
    [
        (("take SetBrakeAction(1)",), "SCN431"),
        (("do Box(9 m) for 1 s", "new Car on road"), "SCN427"),
        (("do Box()",), "SCN308"),
        (("do Slow(ego, ego.speed)",), "SCN654"),
        (("do Hold(3 m/s)",), "SCN650"),
        (("wait", "s = Box(9 m)", "require s.bix.x > 3 m"), "SCN651"),
        (("s = Box(9 m)", "do s for 1 s", "require s.bix.x > 3 m"), "SCN203"),
    ],
)
def test_mistakes_in_compose_are_reported(lines: tuple[str, ...], code: str) -> None:
    assert code in refusal(*lines)


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("override lane with behavior None", "SCN303"),
        ("override car with speed 3 m/s", "SCN656"),
        ("override car with sped 3 m/s", "SCN204"),
        ("override car at (3 m, 3 m)", "SCN656"),
        ("param map = 3", "SCN659"),
        ("import cars", "SCN659"),
        ("take SetBrakeAction(1)", "SCN431"),
    ],
)
def test_mistakes_in_setup_are_reported(line: str, code: str) -> None:
    assert code in refusal("do Bad(ego)", before=f"scenario Bad(car):\n    setup:\n        {line}\n")


def test_scenarios_do_not_belong_in_behaviours(said: Callable[[str], list[str]]) -> None:
    text = "scenario A(x):\n    setup:\n        D = x\n\nbehavior B():\n    do A(3)\n\n"
    text += "b = new Car at (9, 2), with behavior B()\n"
    assert "SCN658" in said(text)


# -- records of scenarios that others start ----------------------------------------------------------------------------

WATCH = """
scenario Watch(after):
    setup:
        record ego.x as x
        record initial ego.x as first
        record final ego.x as last
        record ego.position as place
    compose:
        wait for after

scenario Never():
    setup:
        record ego.speed as unseen
    compose:
        wait
"""


@pytest.mark.parametrize(
    ("lines", "spans"),
    [
        (["do Watch(1 s)"], [(0.0, 0.95)]),
        (["wait for 0.5 s", "do Watch(1 s)"], [(0.5, 1.45)]),
        (["do Watch(0.5 s)", "wait for 0.5 s", "do Watch(1 s)"], [(0.0, 0.45), (1.0, 1.95)]),
        (
            ["while True:", "    do Watch(0.2 s)", "    wait for 0.3 s"],
            [(at, at + 0.15) for at in (0.0, 0.5, 1.0, 1.5)],
        ),
    ],
)
def test_records_of_started_scenarios_have_their_time(lines: list[str], spans: list[tuple[float, float]]) -> None:
    """The values of each time in which a scenario runs, of the whole run's values; none if it never runs."""
    ends = "terminate after 1.5 s\n" if lines[0].startswith("while") else ""
    lines = [*lines, "if False:", "    do Never()"]
    scenario = composed(*lines, before=WATCH + ends + "record simulation().currentTime as clock\n")
    run = scenario.watch(scenario.sample(1))
    kept = {record.name: record for record in run.records}
    time = run.trajectory.time
    expected = [any(begin - 1e-9 <= at <= end + 1e-9 for begin, end in spans) for at in time[: len(kept["clock"].time)]]
    counts = np.flatnonzero(expected)
    np.testing.assert_array_equal(kept["x"].time, time[counts])
    np.testing.assert_array_equal(kept["x"].values, run.trajectory.states[counts, 0, State.X])
    np.testing.assert_array_equal(kept["place.x"].values, kept["x"].values)
    assert kept["first"].values.tolist() == kept["x"].values[:1].tolist()
    assert kept["last"].values.tolist() == kept["x"].values[-1:].tolist()


def test_drivers_do_not_observe_records_of_a_part_of_the_run() -> None:
    """An observation has a value in each turn, and these records have none before their scenario runs."""
    scenario = composed("wait for 1 s", "do Watch(1 s)", before=WATCH + "record ego.speed as v\n")
    assert [record.name for record in series(scenario.program)] == ["v"]

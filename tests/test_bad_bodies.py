"""What nobody should write, tried as a user would: a diagnostic, or a result that is right; never NaN, never a hang."""

import numpy as np
import pytest

from cortex_dsl import CompileError, compile_text
from engine import batch, world
from engine.outcomes import Outcomes
from engine.tables import A_BUILDING
from engine.vocabulary import EndReason, State

FIELD = """
map intersection(approach=60 m{road})
{before}
ego = new Car at (1.75 m, -50 m), facing 90 deg, with speed 10 m/s{ego}
{others}
terminate after 3 s
"""
STRUCK = """
a = new Car at (1.75 m, -20 m), facing 90 deg{a}
b = new Car at (1.75 m, -30 m), facing 90 deg, with speed 20 m/s{b}
"""
IN_ONE_POINT = "\n".join(
    f"{name} = new Car at (1.75 m, 0 m), facing {turn} deg, with speed 5 m/s, with allowCollisions True"
    for name, turn in (("a", 0), ("b", 120), ("c", 240))
)


def text(others: str = "", *, road: str = "", before: str = "", ego: str = "") -> str:
    return FIELD.format(others=others, road=road, before=before, ego=ego)


def struck(**given: str) -> str:
    return text(STRUCK.format(**{"a": "", "b": ""} | {name: f", with {what}" for name, what in given.items()}))


@pytest.mark.parametrize(
    ("written", "code"),
    [
        (struck(a="mass -5"), "SCN402"),
        (struck(a="mass 0 kg"), "SCN402"),
        (struck(a="mass 1e300"), "SCN402"),
        (struck(a="mass 1e400"), "SCN121"),
        (struck(a="friction 0"), "SCN402"),
        (text(before="environment(friction=0)"), "SCN402"),
        (text(before="environment(friction=3)"), "SCN402"),
        (text(before="environment(sight=0 m)"), "SCN402"),
        (text(ego=", with visibleDistance -1 m"), "SCN402"),
        (text(road=", buildings=0 m"), "SCN411"),
        (text(road=", buildings=-3 m"), "SCN411"),
        (text(road=", buildings=1e9 m"), "SCN411"),
    ],
)
def test_what_no_body_can_have_is_refused(written: str, code: str) -> None:
    """With place, reason and cure."""
    with pytest.raises(CompileError) as caught:
        compile_text(written)
    (error,) = [each for each in caught.value.diagnostics if each.severity.value == "error"]
    assert error.code == code
    assert error.cure or error.reason


def both(written: str) -> tuple[Outcomes, world.WorldRun]:
    """The first scene in both hosts, which agree on all that is scored; every number of it is finite."""
    scenario = compile_text(written)
    scenes, config = scenario.sample(1, seed=1), scenario.config
    assert scenes.valid[0]
    fast = batch.simulate(scenario.program, scenes, config.simulation)
    slow = world.run(scenario.program, scenes, 0, config)
    scored = batch.trajectory(scenario.program, scenes, 0, config.simulation).states
    np.testing.assert_allclose(slow.trajectory.states[: len(scored)], scored, rtol=0.0, atol=1e-9)
    for name in ("end_reason", "end_time", "contact_actors", "others_contact_time"):
        np.testing.assert_array_equal(getattr(fast, name), getattr(slow.outcomes, name))
    assert np.isfinite(slow.trajectory.states).all()
    assert all(np.isfinite(impact.delta_v).all() for impact in slow.impacts)
    return fast, slow


@pytest.mark.parametrize(
    "given",
    [{"a": "mass 1e-300 kg"}, {"b": "mass 1e6 kg"}, {"b": "friction 1e-9"}, {"a": "friction 3"}, {"a": "fixed True"}],
)
def test_extreme_bodies_crash_by_the_laws(given: dict[str, str]) -> None:
    """Whoever is struck is no faster than a rebound off a wall."""
    fast, slow = both(struck(**given))
    assert np.isfinite(fast.others_contact_time[0])
    assert np.abs(slow.trajectory.states[..., State.SPEED]).max() <= 20.0 * 1.15 + 1e-6


def test_masses_that_are_drawn_below_zero_are_rejected() -> None:
    scenario = compile_text(struck(a="mass Normal(0 kg, 500 kg)"))
    scenes = scenario.sample(40, seed=1)
    (named,) = [k for k, each in enumerate(scenario.program.requirements) if "mass" in each.name]
    assert scenes.valid.any()
    assert scenes.failed[:, named].sum() > 0
    assert np.isfinite(scenario.simulate(scenes).end_time[scenes.valid]).all()


def test_bodies_that_overlap_from_the_start() -> None:
    """Three in one point are left with no more energy than they had; an ego among them has crashed at once."""
    fast, slow = both(text(IN_ONE_POINT))
    assert fast.others_contact_time[0] <= 1e-6
    speeds = np.hypot(*np.diff(slow.trajectory.states[:, 1:, :2], axis=0).transpose(2, 0, 1)) / 0.05
    assert np.all((speeds**2).sum(axis=1) <= 3 * 5.0**2 + 1e-6)
    fast, _ = both(
        text(IN_ONE_POINT)
        .replace("at (1.75 m, -50 m)", "at (1.75 m, 0 m)")
        .replace("10 m/s", "10 m/s, with allowCollisions True")
    )
    assert fast.end_reason[0] == EndReason.COLLISION
    assert fast.end_time[0] <= 1e-6


def test_an_ego_that_starts_in_a_building_has_crashed_into_it() -> None:
    inside = text(road=", buildings=6 m", ego=", with allowCollisions True, with regionContainedIn None")
    fast, _ = both(inside.replace("at (1.75 m, -50 m)", "at (40 m, 40 m)"))
    assert fast.end_reason[0] == EndReason.BUILDING
    assert fast.contact_actors[0].tolist() == [0, A_BUILDING]
    assert fast.end_time[0] <= 1e-6


def test_who_stands_in_what_hides_sees_nothing_else() -> None:
    """An ego inside of a truck never sees the walker; outlines that overlap hide what is behind both alone."""
    truck = "t = new Truck at (1.75 m, {y} m), facing 90 deg, with allowCollisions True, with speed 10 m/s\n"
    walker = "w = new Pedestrian at (1.75 m, -20 m), with allowCollisions True\nrequire ego can see w"
    inside = text(truck.format(y=-50) + walker, ego=", with allowCollisions True")
    assert not compile_text(inside).sample(1).valid[0]
    assert compile_text(text(truck.format(y=-20) + walker)).sample(1).valid[0]


def test_a_hundred_that_hide() -> None:
    """A hundred posts in a row hide a walker behind them, and are looked at in no time."""
    post = "new Obstacle at (-1.75 m, -55 m + 0.8 m * i), with length 1 m, with width 1 m, with allowCollisions True"
    walker = "w = new Pedestrian at (-6 m, 10 m), with regionContainedIn None\nterminate when ego can see w"
    fast, _ = both(text(f"posts = [{post}, with occluding True for i in range(100)]\n{walker}"))
    assert fast.end_reason[0] == EndReason.TIMEOUT


INSIDE = """
a = new Car at (1.75 m, -20 m), facing 90 deg, with speed {a} m/s, with drag 0, with allowCollisions True
b = new Car at ({x} m, {y} m), facing 90 deg, with speed {b} m/s, with drag 0, with allowCollisions True
"""


@pytest.mark.parametrize(("x", "y"), [(1.75, -21.0), (1.9, -20.4), (1.75, -23.5), (2.1, -20.9), (1.75, -20.05)])
@pytest.mark.parametrize(("a", "b"), [(0.0, 10.0), (8.0, 10.0)])
def test_who_starts_inside_another_does_not_pass_through_it(x: float, y: float, a: float, b: float) -> None:
    """They are in contact from time 0: the one behind gives of its speed, and stays behind."""
    fast, slow = both(text(INSIDE.format(x=x, y=y, a=a, b=b)))
    assert fast.others_contact_time[0] <= 1e-6
    (impact, *_) = slow.impacts
    assert impact.time <= 1e-6
    assert impact.actors == (1, 2)
    ahead = slow.trajectory.states[:, 1, State.Y] - slow.trajectory.states[:, 2, State.Y]
    assert ahead.min() >= 0.0
    speeds = np.diff(slow.trajectory.states[:20, 1:, State.Y], axis=0) / 0.05
    assert np.all((speeds**2).sum(axis=1) <= a * a + b * b + 1e-6)


def test_who_starts_inside_another_may_leave_it() -> None:
    """Two that part are in contact, and do nothing to one another; two that stand are left alone."""
    for a, b in ((10.0, 5.0), (0.0, 0.0)):
        fast, slow = both(text(INSIDE.format(x=1.75, y=-21.0, a=a, b=b)).replace("after 3 s", "after 2 s"))
        assert not slow.impacts
        assert (fast.others_contact_time[0] <= 1e-6) == (a > 0.0)
        way = slow.trajectory.states[-1, 1:, State.Y] - slow.trajectory.states[0, 1:, State.Y]
        assert way == pytest.approx([2.0 * a, 2.0 * b])


LATER = """
map intersection(approach=60 m)
scenario Main():
    setup:
        ego = new Car at (-1.75 m, 50 m), facing 270 deg, with speed 1 m/s
        b = new Car at (1.75 m, -51.2 m), facing 90 deg, with speed 10 m/s, with drag 0, with allowCollisions True
    compose:
        do Nothing() for 2 s
        do Late()
scenario Nothing():
    compose:
        while True:
            wait
scenario Late():
    setup:
        a = new Car at (1.75 m, -30 m), facing 90 deg, with allowCollisions True
        terminate after 2 s
"""


def test_who_comes_in_inside_another_is_in_contact_from_then_on() -> None:
    fast, slow = both(LATER)
    assert fast.others_contact_time[0] == pytest.approx(2.0, abs=1e-6)
    assert slow.impacts
    assert slow.impacts[0].time == pytest.approx(2.0, abs=1e-6)
    late, early = slow.trajectory.states[41:, 2], slow.trajectory.states[41:, 1]
    assert late[0, State.PRESENT] != 0.0
    assert np.all(late[:, State.Y] > early[:, State.Y])

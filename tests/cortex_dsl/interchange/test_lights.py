"""The plan of the lights comes out of a compiled file with the numbers of the scene."""

from typing import Any

import pytest

from cortex_dsl import Scenario, compile_text
from cortex_dsl.interchange.cases import signal_times
from engine.interchange import SignalTimes
from engine.program import Program

REST = """
ego = new Car at (1.75 m, -40 m), facing 90 deg, with behavior FollowLaneBehavior(10 m/s, obey_signals=True)
terminate after 1 s
"""


def scenario(text: str, **params: Any) -> Scenario:
    return compile_text(f"map intersection()\n{text}{REST}", **params)


def test_defaults_of_the_language() -> None:
    """Those of `signals()`."""
    crossing = scenario("signals()\n")
    assert signal_times(crossing, crossing.sample()) == SignalTimes(10.0, 3.0, 2.0, 0.0)


def test_no_lights_no_plan() -> None:
    """A file without the statement."""
    crossing = compile_text("ego = new Car at (0, 0)\nterminate after 1 s\n")
    assert signal_times(crossing, crossing.sample()) is None


def test_times_follow_the_params_of_the_scene() -> None:
    """Each row has its own; units are seconds."""
    text = "param PHASE = Range(0, 10) s\nparam GREEN = Range(100, 200) ms\nsignals(green=2 * GREEN, offset=PHASE)\n"
    crossing = scenario(text)
    scenes = crossing.sample(5, seed=3)
    for row, (phase, green) in enumerate(scenes.genomes.tolist()):
        times = signal_times(crossing, scenes, row)
        assert times is not None
        assert times.offset == pytest.approx(phase, rel=1e-15)
        assert times.green == pytest.approx(0.002 * green, rel=1e-15)


def test_times_that_are_drawn_are_those_of_the_scene() -> None:
    """Draws of every kind: the scene drawn again is the same one, so its other draws agree, too."""
    text = "GREEN = Normal(10, 1) s\nOFFSET = Uniform(1, 2, 5) s\nsignals(green=GREEN, offset=OFFSET)\n"
    text += "require GREEN > 10.5 s\n"
    crossing = scenario(text)
    scenes = crossing.sample(4, seed=1)
    found = [signal_times(crossing, scenes, row) for row in range(4)]
    assert all(times is not None and times.green > 10.5 and times.offset in (1.0, 2.0, 5.0) for times in found)
    assert len({times.green for times in found if times is not None}) == 4
    drawn = [
        value
        for row in range(4)
        for site in sites(crossing.program, scenes.variant[row])
        for value in scenes.values[row, list(site)]
    ]
    assert {times.green for times in found if times is not None} <= set(drawn)


def sites(program: Program, variant: int) -> list[tuple[int, ...]]:
    return [site.values for site in program.variants[variant].sites]


def test_a_choice_that_a_gene_makes_counts() -> None:
    """The variant is chosen as the simulators do."""
    text = "param SIDE = Uniform(1, -1)\nparam GREEN = DiscreteRange(4, 9)\n"
    text += "signals(green=GREEN * 1 s, offset=SIDE * 2 s)\n"
    crossing = scenario(f"{text}LEG = Uniform(*network.intersections[0].incomingLanes)\nother = new Car on LEG\n")
    scenes = crossing.sample(8, seed=2)
    found = [signal_times(crossing, scenes, row) for row in range(8)]
    params = [dict(zip(crossing.program.space.names, genome, strict=True)) for genome in scenes.genomes.tolist()]
    assert [times and times.green for times in found] == [genome["GREEN"] for genome in params]
    assert [times and times.offset for times in found] == [(2.0, -2.0)[int(genome["SIDE"])] for genome in params]


def test_fixed_params_count() -> None:
    """As `-p` gives them."""
    crossing = scenario("param GREEN = Range(1, 2) s\nsignals(green=GREEN)\n", GREEN="1.5 s")
    times = signal_times(crossing, crossing.sample())
    assert times is not None
    assert times.green == 1.5


def test_lights_that_a_behaviour_changes_are_reported() -> None:
    """Then the plan is not all."""
    text = """signals()
behavior Meddler():
    setClosestTrafficLightStatus(self, "red")
    do FollowLaneBehavior(10 m/s)
other = new Car at (-1.75 m, 40 m), facing -90 deg, with behavior Meddler()
"""
    crossing = scenario(text)
    times = signal_times(crossing, crossing.sample())
    assert times is not None
    assert times.controlled


def test_no_scene_no_plan() -> None:
    """A row whose requirements never held."""
    crossing = scenario("signals()\nX = Range(0, 1)\nrequire X > 0.9999999\n")
    assert signal_times(crossing, crossing.sample()) is None


def test_the_listing_shows_the_plan() -> None:
    """`--emit ir` prints what the stage holds."""
    from cortex_dsl.semantics.printing import format_ir

    listing = format_ir(scenario("signals(green=4 s)\n").compiled.scenario)
    assert "lights green 4.0, yellow 3.0, all_red 2.0, offset 0.0" in listing

"""Numbers of a scene that programs do not keep: the scene is drawn once more by a program that gives them out.

They come as if they were draws. Requirements and random numbers are the same, and so is the scene.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from cortex_dsl import ir
from cortex_dsl.lowering.code_tables import group_variants
from cortex_dsl.lowering.program import lower
from cortex_dsl.source import Span
from engine.config import SimulationConfig
from engine.interchange.recording import SignalTimes
from engine.road.outline import Shown
from engine.sampling import sample
from engine.scenes import Scenes

HERE = Span(0, 0)


def given_out(
    whole: ir.Scenario,
    scenes: Scenes,
    row: int,
    config: SimulationConfig,
    also: Callable[[ir.Variant], ir.Variant],
) -> list[float]:
    """Return the values, in one scene, of the draws that `also` appends last to its variant."""
    program = lower(replace(whole, variants=tuple(map(also, whole.variants))))
    rows = slice(row, row + 1)
    again = sample(program, scenes.genomes[rows], scenes.keys[rows], config)
    site = program.variants[int(scenes.variant[row])].sites[-1]
    return again.values[0, list(site.values)].tolist()


def light_times(whole: ir.Scenario, scenes: Scenes, row: int, config: SimulationConfig) -> SignalTimes | None:
    """The plan of the traffic lights in scene `row`; None without lights, and where there is no scene."""
    number = int(scenes.variant[row])
    lights = None if number < 0 else group_variants(whole).variants[number].lights
    if lights is None:
        return None
    green, yellow, all_red, offset = given_out(whole, scenes, row, config, _with_light_times)
    return SignalTimes(green, yellow, all_red, offset, lights.controlled)


def light_colours(whole: ir.Scenario, scenes: Scenes, row: int, config: SimulationConfig) -> Shown | None:
    """Return the colours of the lights in scene `row`, for drawings; None under the conditions of `light_times`."""
    times = light_times(whole, scenes, row, config)
    return None if times is None else partial(colour_of, times)


def colour_of(times: SignalTimes, phase: int, time: float) -> str:
    """The colour of the lights of a phase; empty where the file lets others change them."""
    if times.controlled:
        return ""
    since = (time - times.begins(phase)) % times.cycle
    return "green" if since < times.green else "yellow" if since < times.green + times.yellow else "red"


def _with_light_times(variant: ir.Variant) -> ir.Variant:
    """Return the variant with the times of its lights among its draws."""
    if (lights := variant.lights) is None:
        return variant
    times = (lights.green, lights.yellow, lights.all_red, lights.offset)
    return replace(variant, draw_sites=(*variant.draw_sites, ir.DrawSite(HERE, "number", "s", times)))

"""The plan of the traffic lights in one scene, as numbers."""

from dataclasses import replace

from cortex_dsl import ir
from cortex_dsl.api.scenario import Scenario
from cortex_dsl.lowering import lower
from cortex_dsl.lowering.code_tables import group_variants
from cortex_dsl.source import Span
from engine.interchange.recording import SignalTimes
from engine.sampling import sample
from engine.scenes import Scenes

HERE = Span(0, 0)


def signal_times(scenario: Scenario, scenes: Scenes, row: int = 0) -> SignalTimes | None:
    """The plan in scene `row`; None without lights, and where there is no scene.

    Programs do not keep these times. So the scene is drawn once more, by a program that gives them out as if they were
    draws: requirements and random numbers are the same, thus the scene is.
    """
    whole = scenario.compiled.scenario
    number = int(scenes.variant[row])
    lights = None if number < 0 else group_variants(whole).variants[number].lights
    if lights is None:
        return None
    program = lower(replace(whole, variants=tuple(map(_telling, whole.variants))))
    rows = slice(row, row + 1)
    again = sample(program, scenes.genomes[rows], scenes.keys[rows], scenario.config.simulation)
    site = program.variants[number].sites[-1]
    green, yellow, all_red, offset = again.values[0, list(site.values)].tolist()
    return SignalTimes(green, yellow, all_red, offset, lights.controlled)


def _telling(variant: ir.Variant) -> ir.Variant:
    """The variant with the times of its lights among what it draws."""
    if (lights := variant.lights) is None:
        return variant
    times = (lights.green, lights.yellow, lights.all_red, lights.offset)
    return replace(variant, draw_sites=(*variant.draw_sites, ir.DrawSite(HERE, "number", "s", times)))

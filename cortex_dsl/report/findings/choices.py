"""What chance chose among finitely many, for one scene: e.g. lanes and maneuvers."""

import math
from collections.abc import Iterator

from engine.program import DrawSite, Program
from engine.road import build_network
from engine.scenes import Scenes


def made_choices(program: Program, scenes: Scenes, row: int = 0) -> tuple[tuple[str, str], ...]:
    """Names and options: those of the variant, then the lanes that the scene drew."""
    variant = int(scenes.variant[row])
    if not 0 <= variant < len(program.variants):
        return ()
    label = program.variants[variant]
    chosen = ((choice.name, choice.option) for choice in label.choices)
    lanes = [site for site in label.sites if site.kind == "lane"]
    return (*chosen, *(_drawn(program, scenes, row, lanes) if lanes else ()))


def _drawn(program: Program, scenes: Scenes, row: int, lanes: list[DrawSite]) -> Iterator[tuple[str, str]]:
    network = build_network(program.road_spec)
    for site in lanes:
        number = float(scenes.values[row][site.values[0]])
        if math.isfinite(number):
            yield site.unit or "lane", network.lanes[int(number)].name

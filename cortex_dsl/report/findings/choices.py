"""What chance chose among finitely many, for one scene: e.g. lanes and maneuvers."""

import math
from collections.abc import Iterator, Sequence
from itertools import chain, count

from engine.program import DrawSite, Program
from engine.road import build_network
from engine.scenes import Scenes


def made_choices(program: Program, scenes: Scenes, row: int = 0) -> tuple[tuple[str, str], ...]:
    """Names and options: those of the variant, then the lanes that the scene drew. Equal names are numbered."""
    variant = int(scenes.variant[row])
    if not 0 <= variant < len(program.variants):
        return ()
    label = program.variants[variant]
    lanes = [site for site in label.sites if site.kind == "lane"]
    names = numbered([*(choice.name for choice in label.choices), *(site.unit or "lane" for site in lanes)])
    options = [*(choice.option for choice in label.choices), *(_drawn(program, scenes, row, lanes) if lanes else ())]
    return tuple((name, option) for name, option in zip(names, options, strict=True) if option is not None)


def numbered(names: Sequence[str]) -> list[str]:
    """Names of which no two are equal: the second `a` is `a 2`."""
    taken = dict[str, None]()
    for name in names:
        further = (f"{name} {number}" for number in count(2))
        taken[next(each for each in chain([name], further) if each not in taken)] = None
    return list(taken)


def _drawn(program: Program, scenes: Scenes, row: int, lanes: Sequence[DrawSite]) -> Iterator[str | None]:
    """The lane of each; None where the scene drew none."""
    network = build_network(program.road_spec)
    for site in lanes:
        number = float(scenes.values[row][site.values[0]])
        yield network.lanes[int(number)].name if math.isfinite(number) else None

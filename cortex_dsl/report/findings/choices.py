"""Random finite choices in scenes, e.g. lanes and maneuvers."""

import math
from collections.abc import Sequence

from engine.program import Program, VariantLabel, drawn_lanes
from engine.program import choice_names as names_of
from engine.road import build_network
from engine.scenes import Scenes
from engine.tables import Floats

NOT_MADE = "–"


def made_choices(program: Program, scenes: Scenes, row: int = 0) -> tuple[tuple[str, str], ...]:
    """Names and options of one scene: those of the variant, then the lanes that it drew. Equal names are numbered."""
    variant = int(scenes.variant[row])
    if not 0 <= variant < len(program.variants):
        return ()
    label = program.variants[variant]
    lanes = _lane_names(program) if drawn_lanes(label) else ()
    options = ((name, _option(label, lanes, scenes.values[row], name)) for name in names_of(label))
    return tuple((name, option) for name, option in options if option is not None)


def choice_names(program: Program) -> tuple[str, ...]:
    """Return the names of all choices of any variant."""
    return tuple(dict.fromkeys(name for label in program.variants for name in names_of(label)))


def options_made(program: Program, scenes: Scenes, name: str) -> tuple[tuple[str, ...], list[int]]:
    """The options of one choice, and the number of that of each scene: options of variants in the order of the file,
    then lanes that were drawn in the order of the map, then `NOT_MADE`.
    """
    lanes, labels = _lane_names(program), program.variants
    rows = zip(scenes.variant.tolist(), scenes.values, strict=True)
    made = [_option(labels[variant], lanes, values, name) or NOT_MADE for variant, values in rows]
    chosen = (pair for each in labels for pair in zip(names_of(each), each.choices, strict=False))
    written, seen = [choice.option for own, choice in chosen if own == name], set(made)
    options = tuple(dict.fromkeys([*written, *(each for each in (*lanes, NOT_MADE) if each in seen)]))
    number = {option: index for index, option in enumerate(options)}
    return options, [number[option] for option in made]


def _lane_names(program: Program) -> Sequence[str]:
    return [lane.name for lane in build_network(program.road_spec).lanes]


def _option(label: VariantLabel, lanes: Sequence[str], values: Floats, name: str) -> str | None:
    """Return the option that a scene with these values has for a choice; None if the choice was not made."""
    names = names_of(label)
    if name not in names:
        return None
    place = names.index(name)
    if place < len(label.choices):
        return label.choices[place].option
    number = float(values[drawn_lanes(label)[place - len(label.choices)].values[0]])
    return lanes[int(number)] if math.isfinite(number) else None

"""Which lanes the scenes of a search drew, where the file leaves a lane to chance without a variant for each.

Journals keep no draws: scenes are drawn once more from their keys, which costs a small part of running them.
"""

import numpy as np

from engine.choices import choice_names, drawn_lanes
from engine.config import Config
from engine.program import Program, VariantLabel
from engine.road import build_network
from engine.sampling import sample
from engine.search.evaluations import Evaluations
from engine.search.insight.diversity import Grid, counted, worst_valid
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Side

MOST = 20
"""Lanes that are told apart, those with the most collisions; all others are one row."""


def lane_grids(program: Program, evaluations: Evaluations, config: Config) -> tuple[Grid, ...]:
    """Per choice of a lane that scenes draw, the valid simulations by lane and by the side that was nearest."""
    names = tuple(dict.fromkeys(name for label in program.variants for name in _drawn_by(label)))
    if not names:
        return ()
    runs, chosen = evaluations.rollouts, worst_valid(evaluations)
    met = runs.side[chosen] >= 0
    rows, rollouts = (each[met] for each in chosen)
    scenes = sample(program, evaluations.genomes[rows], evaluations.keys[rows, rollouts], config.simulation)
    lanes = [lane.name for lane in build_network(program.road_spec).lanes]
    at = rows, rollouts
    found: list[Grid] = []
    for name in names:
        number = _lane_of(program, name, scenes.variant, scenes.values)
        labels, row = _rows(lanes, number, runs.collided[at])
        sides = tuple(side.name.lower() for side in Side)
        found.append(
            counted(f"{name} x side", labels, sides, row, runs.side[at], runs.continuous[at], runs.collided[at])
        )
    return tuple(found)


def _drawn_by(label: VariantLabel) -> dict[str, int]:
    """The scene value that holds each lane that is drawn, by the name of the choice."""
    lanes = drawn_lanes(label)
    return dict(zip(choice_names(label)[len(label.choices) :], (site.values[0] for site in lanes), strict=True))


def _lane_of(program: Program, name: str, variants: Ints, values: Floats) -> Ints:
    """(n,) the lane of each scene; -1 where it drew none."""
    places = np.array([_drawn_by(label).get(name, -1) for label in program.variants])[variants]
    numbers = values[np.arange(len(values)), np.maximum(places, 0)]
    return np.where((places >= 0) & np.isfinite(numbers), np.nan_to_num(numbers), -1.0).astype(np.int64)


def _rows(lanes: list[str], number: Ints, collided: Bools) -> tuple[tuple[str, ...], Ints]:
    """The names of rows, and the row of each scene."""
    seen, row = np.unique(number, return_inverse=True)
    failures = np.bincount(row, weights=collided, minlength=len(seen))
    kept = np.sort(np.argsort(-failures, kind="stable")[:MOST])
    place = np.full(len(seen), len(kept))
    place[kept] = np.arange(len(kept))
    chosen: list[int] = seen[kept].tolist()
    names = [lanes[lane] if lane >= 0 else "none" for lane in chosen]
    others = len(seen) - len(kept)
    return (*names, *([f"{others} others"] if others else [])), place[row]

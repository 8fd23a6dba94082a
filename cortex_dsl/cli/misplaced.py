"""Objects that cannot stand where the file puts them: which they are, where the proof only says that some are."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations, islice

import numpy as np

from cortex_dsl import ir
from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.pipeline import Compiled
from cortex_dsl.semantics.errors.chance import OFF_THE_ROAD, ON_TOP
from engine.feasibility import conflicts
from engine.feasibility.distances import boundary_distance, region_edges
from engine.program import Program
from engine.tables import ROAD_REGION, Ints
from engine.vocabulary import Column

MOST_PAIRS = 50
"""Pairs of objects that are looked at."""


def misplaced(compiled: Compiled, conflict: Sequence[int]) -> list[Diagnostic]:
    """Objects off the road and pairs that overlap, wherever chance puts them.

    `conflict` are requirements of which it is proved that they cannot hold together; objects without a known place are
    looked at only if all of them are built in.
    """
    found = list(_at_known_places(compiled))
    requirements = compiled.program.requirements
    if not found and conflict and all(requirements[r].line == 0 for r in conflict):
        found = [*_off_the_road(compiled), *_overlapping(compiled)]
    return found


def _actors(compiled: Compiled) -> tuple[ir.Actor, ...]:
    """Of the first variant that can be; the others have the same."""
    return next((v.actors for v in compiled.scenario.variants if v.rejection is None), ())


def _at_known_places(compiled: Compiled) -> Iterator[Diagnostic]:
    """Objects at two numbers that are no place of the road, whose heading the road does not say."""
    edges = region_edges(compiled.program.road, ROAD_REGION)
    possible = [variant.actors for variant in compiled.scenario.variants if variant.rejection is None]
    for number, actor in enumerate(_actors(compiled)):
        place = _known_place([actors[number] for actors in possible])
        if place is None or not (actor.inside_road and actor.present):
            continue
        with np.errstate(divide="ignore", invalid="ignore"):
            (distance,), (inside,) = boundary_distance(edges, np.array(place[:1]), np.array(place[1:]))
        if not inside:
            label = f"({place[0]:g}, {place[1]:g}) is {distance:.1f} m off the road"
            yield OFF_THE_ROAD.at(actor.span, name=actor.name, label=label)


def _known_place(versions: Sequence[ir.Actor]) -> tuple[float, float] | None:
    """X and y of an object, if they are the same two numbers in every variant."""
    numbers = [version.columns[column] for version in versions for column in (Column.X, Column.Y)]
    known = [number.value for number in numbers if isinstance(number, ir.Literal)]
    if len(known) == len(numbers) and len(places := set(zip(known[::2], known[1::2], strict=True))) == 1:
        return places.pop()
    return None


def _off_the_road(compiled: Compiled) -> Iterator[Diagnostic]:
    for number, actor in enumerate(_actors(compiled)):
        program = _checking(compiled.program, road=[number], overlap=[])
        if actor.inside_road and conflicts(program, [len(program.requirements) - 2]):
            yield OFF_THE_ROAD.at(actor.span, name=actor.name, label="part of its outline is off the road")


def _overlapping(compiled: Compiled) -> Iterator[Diagnostic]:
    for (i, one), (j, other) in islice(combinations(enumerate(_actors(compiled)), 2), MOST_PAIRS):
        program = _checking(compiled.program, road=[], overlap=[i, j])
        if one.no_overlap and other.no_overlap and conflicts(program, [len(program.requirements) - 1]):
            secondary = (Label(one.span, f"`{one.name}`"),)
            yield ON_TOP.at(other.span, name=other.name, other=one.name, secondary=secondary)


def _checking(program: Program, road: list[int], overlap: list[int]) -> Program:
    """The same program, whose built-in requirements look at these actors alone."""
    code = program.code._replace(
        road_check=_only(program.code.road_check, road), overlap_check=_only(program.code.overlap_check, overlap)
    )
    return replace(program, code=code)


def _only(flags: Ints, kept: list[int]) -> Ints:
    limited = np.zeros_like(flags)
    limited[kept] = flags[kept]
    return limited

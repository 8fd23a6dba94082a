"""Objects that cannot stand where the file puts them: which they are, where the proof only says that some are."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np

from cortex_dsl import ir
from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.pipeline import Compiled
from cortex_dsl.semantics import errors
from engine.feasibility import conflicts
from engine.feasibility.distances import boundary_distance, region_edges
from engine.program import Program
from engine.tables import ROAD_REGION, Ints
from engine.vocabulary import Column


def misplaced(compiled: Compiled, *, infeasible: bool) -> list[Diagnostic]:
    """Objects off the road and pairs that overlap, wherever chance puts them; `infeasible` is what was proved of the
    file as a whole.
    """
    found = list(_at_known_places(compiled))
    if infeasible and not found:
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
        places = {(actors[number].columns[Column.X], actors[number].columns[Column.Y]) for actors in possible}
        x, y = next(iter(places))
        if len(places) > 1 or not actor.inside_road or not isinstance(x, ir.Literal) or not isinstance(y, ir.Literal):
            continue
        with np.errstate(divide="ignore", invalid="ignore"):
            (distance,), (inside,) = boundary_distance(edges, np.array([x.value]), np.array([y.value]))
        if not inside:
            label = f"({x.value:g}, {y.value:g}) is {distance:.1f} m off the road"
            yield errors.OFF_THE_ROAD.at(actor.span, name=actor.name, label=label)


def _off_the_road(compiled: Compiled) -> Iterator[Diagnostic]:
    for number, actor in enumerate(_actors(compiled)):
        program = _checking(compiled.program, road=[number], overlap=[])
        if actor.inside_road and conflicts(program, [len(program.requirements) - 2]):
            yield errors.OFF_THE_ROAD.at(actor.span, name=actor.name, label="part of its outline is off the road")


def _overlapping(compiled: Compiled) -> Iterator[Diagnostic]:
    for (i, one), (j, other) in combinations(enumerate(_actors(compiled)), 2):
        program = _checking(compiled.program, road=[], overlap=[i, j])
        if one.no_overlap and other.no_overlap and conflicts(program, [len(program.requirements) - 1]):
            secondary = (Label(one.span, f"`{one.name}`"),)
            yield errors.ON_TOP.at(other.span, name=other.name, other=one.name, secondary=secondary)


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

"""Searchers by name: those of cortexc (`engine.search.methods.table`), and those of other packages.

A searcher of another package is an entry point of the group `cortexc.searchers`; its proposals are checked.

    # pyproject.toml of the package
    [project.entry-points."cortexc.searchers"]
    my_search = "my_package:make"

    # my_package.py
    def make(box: Box, config: Config, streams: StreamAt) -> Searcher: ...

`make` is called once for each run, with the box of the genes, every setting (`config.search.population` individuals a
generation, `config.search.generations` of them) and the streams of random numbers. The searcher is asked for
`population` proposals (`engine.search.protocol.Proposal`) per generation, each in the box and born at its own place.
`tell` then passes one `Result` for each: valid, invalid, error (the simulator failed) or reused. To make runs
repeatable and resumable, proposals must depend only on the streams and on these results.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.metadata import EntryPoint, entry_points
from typing import Any, TypeVar, cast

from engine.config import Config
from engine.errors import ArgumentError, CortexError
from engine.search.methods.table import ELSEWHERE, REMOVED, SEARCHERS, SearcherEntry
from engine.search.protocol import Birth, Box, Proposal, Result, Searcher, StreamAt
from engine.streams import FIELD_BITS, operator_generator

__all__ = [
    "SEARCHERS",
    "UnknownMethodError",
    "build_searcher",
    "canonical",
    "find_searcher",
    "known_searchers",
    "seek",
]

# -- searchers of other packages ---------------------------------------------------------------------------------------

GROUP = "cortexc.searchers"

Value = TypeVar("Value")


class PluginError(CortexError):
    """A searcher of another package cannot be used; the message names the package and the problem."""

    def __init__(self, name: str, problem: str) -> None:
        super().__init__(f"the searcher `{name}` {problem}", "repair or remove the package that offers it")
        self.name = name


def plugins() -> dict[str, SearcherEntry]:
    """Return the searchers of other packages by name, without importing them. A name of cortexc takes precedence."""
    found = entry_points(group=GROUP)
    return {point.name: _entry(point) for point in found if point.name not in SEARCHERS}


def distribution_of(name: str) -> tuple[str, str] | None:
    """Return name and version of the package of a searcher; None for searchers of cortexc."""
    if name in SEARCHERS:
        return None
    points = (point for point in entry_points(group=GROUP, name=name) if point.dist is not None)
    return next(((point.dist.name, point.dist.version) for point in points if point.dist is not None), None)


def _entry(point: EntryPoint) -> SearcherEntry:
    package = point.dist.name if point.dist is not None else point.module

    def build(box: Box, config: Config, streams: StreamAt) -> Searcher:
        make = _called(point.name, "cannot be loaded", point.load)
        searcher = _called(point.name, "cannot be made", lambda: make(box, config, streams))
        return Watched(point.name, searcher, box, config.search.population)

    return SearcherEntry(point.name, f"of the package {package}", build)


@dataclass
class Watched:
    """Searcher with checks of its proposals before a simulation; its errors are reported as its package's."""

    name: str
    searcher: Any
    box: Box
    population: int
    generation: int = -1

    def ask(self) -> list[Proposal]:
        self.generation += 1
        proposals = _called(self.name, "failed in `ask`", lambda: list(self.searcher.ask()))
        if (problem := self._problem(proposals)) is not None:
            raise PluginError(self.name, problem)
        return proposals

    def tell(self, results: Sequence[Result]) -> None:
        _called(self.name, "failed in `tell`", lambda: self.searcher.tell(results))

    def _problem(self, proposals: Sequence[Any]) -> str | None:
        if len(proposals) != self.population:
            return f"must propose {self.population} individuals in each generation, not {len(proposals)}"
        for place, proposal in enumerate(proposals):
            if not isinstance(proposal, Proposal):
                return f"must propose `engine.search.protocol.Proposal`, not `{type(proposal).__name__}`"
            if not isinstance(cast("object", proposal.genome), tuple) or not self.box.holds(proposal.genome):
                return f"proposes {proposal.genome!r} for place {place}, which is not a genome of the box"
            born = Birth(self.generation, place)
            if proposal.reused is None and proposal.birth != born:
                return f"proposes an individual for {born}, but calls it born at {proposal.birth}"
            if proposal.reused is not None and not (0, 0) <= proposal.birth < (self.generation, 0):
                return f"reuses an individual of {proposal.birth}, which is not of an earlier generation"
        return None


def _called(name: str, problem: str, action: Callable[[], Value]) -> Value:
    try:
        return action()
    except Exception as error:
        raise PluginError(name, f"{problem}: {type(error).__name__}: {error}") from error


# -- all searchers by name ---------------------------------------------------------------------------------------------


class UnknownMethodError(CortexError, ValueError):
    """No searcher has this name."""

    def __init__(self, name: str) -> None:
        self.name, self.replacement = name.strip(), REMOVED.get(_word(name))
        if self.replacement is not None:
            super().__init__(f"method: `{self.name}` was removed", f"use `{self.replacement}`")
        elif (command := ELSEWHERE.get(_word(name))) is not None:
            super().__init__(f"method: `{self.name}` fills cells and seeks no failures", f"use `{command}`")
        else:
            super().__init__(f"method: `{name}` is none of {', '.join(known_searchers())}", "name one of these")


def known_searchers() -> dict[str, SearcherEntry]:
    """Return the searchers of cortexc, then those of other packages."""
    return {**SEARCHERS, **plugins()}


def canonical(name: str) -> str:
    """Return the name of a method, from an alias or from a spelling with hyphens or capitals.

    Raises:
        UnknownMethodError: there is no such method.
    """
    word = _word(name)
    if word in SEARCHERS:
        return word
    for method, entry in SEARCHERS.items():
        if word and entry.alias == word:
            return method
    if name.strip() in plugins():
        return name.strip()
    raise UnknownMethodError(name)


def _word(name: str) -> str:
    return name.strip().lower().replace("-", "_")


def find_searcher(name: str) -> SearcherEntry:
    """Return the row of a method.

    Raises:
        UnknownMethodError: there is no such method.
    """
    return known_searchers()[canonical(name)]


def build_searcher(name: str, box: Box, config: Config, number: int | None = None) -> Searcher:
    """Return the searcher of a row, with the streams of this seed, method and run for its operators. `number` is the
    method's number in a run's manifest, if it differs from the current one (None).

    Raises:
        UnknownMethodError: there is no method of this name. MissingExtraError: its package is not installed.
        PluginError: it belongs to another package and is broken.
    """
    entry = find_searcher(name)
    search = config.search
    if search.generations < 1 or search.population < 1 or search.rollouts < 1:
        raise ArgumentError("generations, population and rollouts must be at least 1", "take larger ones")
    if search.generations > 1 << FIELD_BITS.generation:
        limit = 1 << FIELD_BITS.generation
        raise ArgumentError(
            f"generations is {search.generations}; the random streams of a run distinguish {limit}", "take fewer"
        )
    method = entry.number if number is None else number
    return entry.build(box, config, partial(operator_generator, search.seed, method, search.run))


class SeveralObjectivesError(ArgumentError):
    """Several objectives are named for a method that maximizes one number."""


def seek(searcher: Searcher, method: str, aims: int) -> None:
    """Set the number of objectives of a searcher.

    Raises:
        SeveralObjectivesError: its method maximizes one number.
    """
    several = getattr(searcher, "seek", None)
    if aims > 1 and several is None:
        raise SeveralObjectivesError(
            f"`{method}` seeks one objective, and {aims} are named", "name one, or search by `nsga2` or `map_elites`"
        )
    if several is not None:
        several(aims)

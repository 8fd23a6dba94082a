"""Searchers by name: our own (`engine.search.methods.table`), and those that other packages offer.

A searcher of another package is an entry point of the group `cortexc.searchers`; what it proposes is watched.

    # pyproject.toml of the package
    [project.entry-points."cortexc.searchers"]
    my_search = "my_package:make"

    # my_package.py
    def make(box: Box, config: Config, streams: StreamAt) -> Searcher: ...

`make` is called once for each run, with the box of the genes, every setting (`config.search.population` individuals a
generation, `config.search.generations` of them) and the streams of random numbers. What it returns is asked for
`population` proposals (`engine.search.protocol.Proposal`) a generation, each in the box and born at its own place, and
then gets one `Result` for each by `tell`: valid, invalid, error (the simulator failed) or reused. For a run to repeat
itself and to be resumed, proposals must depend on the streams and on these results, and on nothing else.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.metadata import EntryPoint, entry_points
from typing import Any, TypeVar, cast

from engine.config import Config
from engine.errors import ArgumentError, CortexError
from engine.search.methods.table import REMOVED, SEARCHERS, SearcherEntry
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
    """A searcher of another package cannot be used: whose it is, and what is wrong with it."""

    def __init__(self, name: str, problem: str) -> None:
        super().__init__(f"the searcher `{name}` {problem}", "repair or remove the package that offers it")
        self.name = name


def plugins() -> dict[str, SearcherEntry]:
    """Every searcher that other packages offer, by name. A name of ours stays ours; nothing is imported here."""
    found = entry_points(group=GROUP)
    return {point.name: _entry(point) for point in found if point.name not in SEARCHERS}


def distribution_of(name: str) -> tuple[str, str] | None:
    """Name and version of the package behind a searcher; None for our own."""
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
    """A searcher whose proposals are checked before anything is simulated; what it raises is its own."""

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
        else:
            super().__init__(f"method: `{name}` is none of {', '.join(known_searchers())}", "name one of these")


def known_searchers() -> dict[str, SearcherEntry]:
    """Our own searchers, then those of other packages."""
    return {**SEARCHERS, **plugins()}


def canonical(name: str) -> str:
    """The one name of a method, from an alias or from a spelling with hyphens or capitals.

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
    """The row of a method.

    Raises:
        UnknownMethodError: there is no such method.
    """
    return known_searchers()[canonical(name)]


def build_searcher(name: str, box: Box, config: Config, number: int | None = None) -> Searcher:
    """The searcher of a row, its operators drawing from the streams of this seed, method and run. `number` is that of
    the method in a run's manifest, where it is not its own (None) any more.

    Raises:
        UnknownMethodError: there is no method of this name.
        MissingExtraError: its package is not installed.
        PluginError: it is of another package, which is broken.
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
    """A method that makes one number large is given several."""


def seek(searcher: Searcher, method: str, aims: int) -> None:
    """Tell a searcher how many objectives there are.

    Raises:
        SeveralObjectivesError: its method makes one number large.
    """
    several = getattr(searcher, "seek", None)
    if aims > 1 and several is None:
        raise SeveralObjectivesError(
            f"`{method}` seeks one objective, and {aims} are named", "name one, or search by `nsga2` or `map_elites`"
        )
    if several is not None:
        several(aims)

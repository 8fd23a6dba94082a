"""Searchers by name: our own (`engine.search.methods.table`), and those that other packages offer."""

from functools import partial

from engine.config import Config
from engine.errors import CortexError
from engine.search.methods.table import SEARCHERS, SearcherEntry
from engine.search.plugins import plugins
from engine.search.protocol import Box, Searcher
from engine.streams import FIELD_BITS, operator_generator
from engine.vocabulary import Method

__all__ = [
    "SEARCHERS",
    "UnknownMethodError",
    "build_searcher",
    "canonical",
    "find_searcher",
    "known_searchers",
    "method_of",
]


class UnknownMethodError(CortexError, ValueError):
    """No searcher has this name."""

    def __init__(self, name: str) -> None:
        super().__init__(f"method: `{name}` is none of {', '.join(known_searchers())}", "name one of these")
        self.name = name


def known_searchers() -> dict[str, SearcherEntry]:
    """Our own searchers, then those of other packages."""
    return {**SEARCHERS, **plugins()}


def canonical(name: str) -> str:
    """The one name of a method, from an alias or from a spelling with hyphens or capitals.

    Raises:
        UnknownMethodError: there is none.
    """
    word = name.strip().lower().replace("-", "_")
    if word in SEARCHERS:
        return word
    for method, entry in SEARCHERS.items():
        if word and entry.alias == word:
            return method
    if name.strip() in plugins():
        return name.strip()
    raise UnknownMethodError(name)


def find_searcher(name: str) -> SearcherEntry:
    """The row of a method.

    Raises:
        UnknownMethodError: there is none.
    """
    return known_searchers()[canonical(name)]


def method_of(name: str) -> Method:
    """The part of every stream key that a method's name stands for, be its package installed or not."""
    entry = SEARCHERS.get(name)
    return Method.CUSTOM if entry is None else entry.method


def build_searcher(name: str, box: Box, config: Config) -> Searcher:
    """The searcher of a row, its operators drawing from the streams of this seed, method and run.

    Raises:
        UnknownMethodError: there is none of this name.
        MissingExtraError: its package is not installed.
        PluginError: it is of another package, which is broken.
    """
    entry = find_searcher(name)
    search = config.search
    if search.generations < 1 or search.population < 1 or search.rollouts < 1:
        raise ValueError("generations, population and rollouts must be at least 1")
    if search.generations > 1 << FIELD_BITS.generation:
        limit = 1 << FIELD_BITS.generation
        raise ValueError(f"generations is {search.generations}; the random streams of a run tell {limit} apart")
    return entry.build(box, config, partial(operator_generator, search.seed, int(entry.method), search.run))

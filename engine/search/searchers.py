"""The table of searchers. A new one is a class with `ask` and `tell`, a `Method`, and a row here."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from engine.config import Config
from engine.search.methods.ga import GeneticAlgorithm
from engine.search.methods.random_search import RandomSearch
from engine.search.protocol import Box, Searcher, StreamAt
from engine.streams import FIELD_BITS, operator_generator
from engine.vocabulary import Method


@dataclass(frozen=True)
class SearcherEntry:
    """One way to search."""

    method: Method
    """Part of every stream key, so that no two methods share numbers."""
    build: Callable[[Box, Config, StreamAt], Searcher]
    preset: Callable[[Config], str]
    """What a report must name beside the method; "" when there is nothing to name."""


def _build_ga(box: Box, config: Config, streams: StreamAt) -> Searcher:
    return GeneticAlgorithm(box, config.search.population, streams, config.ga)


def _build_random(box: Box, config: Config, streams: StreamAt) -> Searcher:
    return RandomSearch(box, config.search.population, streams)


SEARCHERS: dict[str, SearcherEntry] = {
    "ga": SearcherEntry(Method.GA, _build_ga, lambda config: config.ga.preset),
    "random": SearcherEntry(Method.RANDOM, _build_random, lambda _: ""),
}


def build_searcher(name: str, box: Box, config: Config) -> Searcher:
    """The searcher of a row, its operators drawing from the streams of this seed, method and run."""
    entry = SEARCHERS.get(name)
    if entry is None:
        raise ValueError(f"method: `{name}` is none of {', '.join(SEARCHERS)}")
    search = config.search
    if search.generations < 1 or search.population < 1 or search.rollouts < 1:
        raise ValueError("generations, population and rollouts must be at least 1")
    if search.generations > 1 << FIELD_BITS.generation:
        limit = 1 << FIELD_BITS.generation
        raise ValueError(f"generations is {search.generations}; the random streams of a run tell {limit} apart")
    return entry.build(box, config, partial(operator_generator, search.seed, int(entry.method), search.run))

"""The table of searchers. A new one is a class with `ask` and `tell`, and a row here: all that is said of it elsewhere,
from `--method list` to the colours of a report, is read from the row.
"""

from collections.abc import Callable
from dataclasses import dataclass

from engine.config import Config
from engine.search.methods.external import CovarianceAdaptation, Illumination, NonDominatedSorting
from engine.search.methods.ga import GeneticAlgorithm
from engine.search.methods.niching import NichingSearch
from engine.search.methods.optimizers import Annealing, CrossEntropy, DifferentialEvolution
from engine.search.methods.space_filling import QuasiRandom, RandomSearch
from engine.search.protocol import Box, Searcher, StreamAt
from engine.streams import method_number

PLUGIN_STYLE = "bright_blue"
"""Colour of every searcher of another package."""

Build = Callable[[Box, Config, StreamAt], Searcher]
"""(box, every setting, streams of the operators) -> a searcher that proposes `config.search.population` at a time."""


def _no_preset(_: Config) -> str:
    return ""


@dataclass(frozen=True)
class SearcherEntry:
    """One way to search."""

    name: str
    """What it is called, everywhere."""
    summary: str
    """One line for lists."""
    build: Build
    style: str = PLUGIN_STYLE
    """Colour of reports in a terminal, one of its own sixteen."""
    alias: str = ""
    """A shorter name."""
    preset: Callable[[Config], str] = _no_preset
    """What a report must name beside the method; "" when there is nothing to name."""
    package: str = ""
    """What must be installed beside cortexc."""
    paced: bool = False
    """Whether each step depends on how many are to come, so that a finished run cannot be made longer."""

    @property
    def number(self) -> int:
        """Part of every stream key, so that no two methods share numbers (see `engine.streams`)."""
        return method_number(self.name)


def _plain(make: Callable[[Box, int, StreamAt], Searcher]) -> Build:
    """Of a class that asks for no setting but the population."""
    return lambda box, config, streams: make(box, config.search.population, streams)


def _quasi(sequence: str) -> Build:
    return lambda box, config, streams: QuasiRandom(box, config.search.population, streams, sequence)


def _grid(method: str) -> Build:
    return lambda box, config, streams: Illumination(box, config.search.population, streams, method)


def _ga(box: Box, config: Config, streams: StreamAt) -> Searcher:
    return GeneticAlgorithm(box, config.search.population, streams, config.ga)


def _annealing(box: Box, config: Config, streams: StreamAt) -> Searcher:
    return Annealing(box, config.search.population, config.search.generations, streams)


SEARCHERS: dict[str, SearcherEntry] = {
    row.name: row
    for row in (
        SearcherEntry(
            "ga",
            "the paper's genetic algorithm: most risk, few kinds",
            _ga,
            "cyan",
            preset=lambda config: config.ga.preset,
        ),
        SearcherEntry("random", "independent uniform draws: the baseline", _plain(RandomSearch), "yellow"),
        SearcherEntry("niching", "our genetic algorithm: failures that differ", _plain(NichingSearch), "green"),
        SearcherEntry("sobol", "scrambled Sobol points: an even cover of the box", _quasi("sobol"), "bright_yellow"),
        SearcherEntry(
            "halton", "randomized Halton points: an even cover of the box", _quasi("halton"), "bright_yellow"
        ),
        SearcherEntry("lhs", "a Latin hypercube in each generation", _quasi("lhs"), "bright_yellow"),
        SearcherEntry(
            "cross_entropy",
            "a distribution that moves to the riskiest tenth",
            _plain(CrossEntropy),
            "magenta",
            alias="ce",
        ),
        SearcherEntry("annealing", "walkers that cool down together", _annealing, "red", alias="sa", paced=True),
        SearcherEntry(
            "differential_evolution",
            "differences of members, DE/rand/1/bin",
            _plain(DifferentialEvolution),
            "bright_cyan",
            alias="de",
        ),
        SearcherEntry(
            "cmaes",
            "a normal distribution that learns the risk's shape",
            _plain(CovarianceAdaptation),
            "bright_magenta",
            package="cma",
        ),
        SearcherEntry(
            "nsga2",
            "NSGA-II: close and fast at once, a Pareto front",
            _plain(NonDominatedSorting),
            "blue",
            package="pymoo",
        ),
        SearcherEntry(
            "map_elites",
            "the riskiest run for every pair of speeds",
            _grid("map_elites"),
            "bright_green",
            package="ribs",
        ),
        SearcherEntry(
            "cma_me",
            "the same, by strategies that seek what is new",
            _grid("cma_me"),
            "bright_green",
            package="ribs",
        ),
    )
}
"""Our own methods by name, in the order of lists."""

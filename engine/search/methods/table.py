"""The table of searchers. A new one is a class with `ask` and `tell`, a `Method`, and a row here."""

from collections.abc import Callable
from dataclasses import dataclass

from engine.config import Config
from engine.search.methods.external import CovarianceAdaptation, Illumination, NonDominatedSorting
from engine.search.methods.ga import GeneticAlgorithm
from engine.search.methods.niching import NichingSearch
from engine.search.methods.optimizers import Annealing, CrossEntropy, DifferentialEvolution
from engine.search.methods.space_filling import QuasiRandom, RandomSearch
from engine.search.protocol import Box, Searcher, StreamAt
from engine.vocabulary import Method

Build = Callable[[Box, Config, StreamAt], Searcher]
"""(box, every setting, streams of the operators) -> a searcher that proposes `config.search.population` at a time."""


def _no_preset(_: Config) -> str:
    return ""


@dataclass(frozen=True)
class SearcherEntry:
    """One way to search."""

    method: Method
    """Part of every stream key, so that no two methods share numbers."""
    summary: str
    """One line for lists."""
    build: Build
    alias: str = ""
    """A shorter name."""
    preset: Callable[[Config], str] = _no_preset
    """What a report must name beside the method; "" when there is nothing to name."""
    package: str = ""
    """What must be installed beside cortexc."""
    paced: bool = False
    """Whether each step depends on how many are to come, so that a finished run cannot be made longer."""


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
    "ga": SearcherEntry(
        Method.GA, "the paper's genetic algorithm: most risk, few kinds", _ga, preset=lambda c: c.ga.preset
    ),
    "random": SearcherEntry(Method.RANDOM, "independent uniform draws: the baseline", _plain(RandomSearch)),
    "niching": SearcherEntry(Method.NICHING, "our genetic algorithm: failures that differ", _plain(NichingSearch)),
    "sobol": SearcherEntry(Method.SOBOL, "scrambled Sobol points: an even cover of the box", _quasi("sobol")),
    "halton": SearcherEntry(Method.HALTON, "randomized Halton points: an even cover of the box", _quasi("halton")),
    "lhs": SearcherEntry(Method.LHS, "a Latin hypercube in each generation", _quasi("lhs")),
    "cross_entropy": SearcherEntry(
        Method.CROSS_ENTROPY, "a distribution that moves to the riskiest tenth", _plain(CrossEntropy), alias="ce"
    ),
    "annealing": SearcherEntry(Method.ANNEALING, "walkers that cool down together", _annealing, alias="sa", paced=True),
    "differential_evolution": SearcherEntry(
        Method.DIFFERENTIAL_EVOLUTION, "differences of members, DE/rand/1/bin", _plain(DifferentialEvolution), "de"
    ),
    "cmaes": SearcherEntry(
        Method.CMAES, "a normal distribution that learns the risk's shape", _plain(CovarianceAdaptation), package="cma"
    ),
    "nsga2": SearcherEntry(
        Method.NSGA2, "NSGA-II: close and fast at once, a Pareto front", _plain(NonDominatedSorting), package="pymoo"
    ),
    "map_elites": SearcherEntry(
        Method.MAP_ELITES, "the riskiest run for every pair of speeds", _grid("map_elites"), package="ribs"
    ),
    "cma_me": SearcherEntry(
        Method.CMA_ME, "the same, by strategies that seek what is new", _grid("cma_me"), package="ribs"
    ),
}

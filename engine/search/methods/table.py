"""The table of searchers. A new searcher is a class with `ask` and `tell`, and a row here; everything else, from
`--method list` to the colours of a report, is read from the row.
"""

from collections.abc import Callable
from dataclasses import dataclass

from engine.config import Config
from engine.search.methods.best_first import BestFirst
from engine.search.methods.cube import QuasiRandom, RandomSearch
from engine.search.methods.external import CovarianceAdaptation, Illumination, NonDominatedSorting
from engine.search.methods.failure_kinds import FailureKinds
from engine.search.methods.ga import GeneticAlgorithm
from engine.search.methods.niching import NichingSearch
from engine.search.methods.optimizers import CrossEntropy, DifferentialEvolution
from engine.search.methods.trust_regions import TrustRegions
from engine.search.protocol import Box, Searcher, StreamAt
from engine.streams import method_number

PLUGIN_STYLE = "bright_blue"
"""Colour of every searcher from another package."""

Build = Callable[[Box, Config, StreamAt], Searcher]
"""(box, every setting, streams of the operators) -> a searcher that proposes `config.search.population` at a time."""


def _no_preset(_: Config) -> str:
    return ""


@dataclass(frozen=True)
class SearcherEntry:
    """One search method."""

    name: str
    """Name of the method in commands and files."""
    summary: str
    """One-line description for lists."""
    build: Build
    title: str = ""
    """Name in reports; "" if it equals `name`."""
    style: str = PLUGIN_STYLE
    """Colour in terminal reports, one of the terminal's own sixteen."""
    alias: str = ""
    """A shorter name."""
    preset: Callable[[Config], str] = _no_preset
    """Preset that a report names after the method; "" if there is none."""
    draws_independently: bool = False
    """Whether the individuals of `Operator.RANDOM` are uniform draws, whatever the earlier results were."""
    package: str = ""
    """Package that must be installed in addition to cortexc."""

    @property
    def number(self) -> int:
        """Return the number in every stream key, so that no two methods share random numbers (`engine.streams`)."""
        return method_number(self.name)


def _plain(make: Callable[[Box, int, StreamAt], Searcher]) -> Build:
    """Return the builder of a class that needs no setting except the population."""
    return lambda box, config, streams: make(box, config.search.population, streams)


def _quasi(sequence: str) -> Build:
    return lambda box, config, streams: QuasiRandom(box, config.search.population, streams, sequence)


def _grid(method: str) -> Build:
    return lambda box, config, streams: Illumination(box, config.search.population, streams, method)


def _ga(box: Box, config: Config, streams: StreamAt) -> Searcher:
    return GeneticAlgorithm(box, config.search.population, streams, config.ga)


def _preset(config: Config) -> str:
    return config.ga.preset


SEARCHERS: dict[str, SearcherEntry] = {
    row.name: row
    for row in (
        SearcherEntry(
            name="ga",
            summary="the paper's genetic algorithm: high risk, few kinds",
            build=_ga,
            title="genetic algorithm",
            style="cyan",
            preset=_preset,
            draws_independently=True,
        ),
        SearcherEntry(
            name="random",
            summary="independent uniform draws: the baseline",
            build=_plain(RandomSearch),
            style="yellow",
            draws_independently=True,
        ),
        SearcherEntry(
            name="niching",
            summary="our genetic algorithm: failures of different kinds",
            build=_plain(NichingSearch),
            title="niching genetic algorithm",
            style="green",
            draws_independently=True,
        ),
        SearcherEntry(
            name="best_first",
            summary="climbs from many good runs: for rare failures",
            build=_plain(BestFirst),
            title="best-first search",
            style="green",
            alias="bf",
            draws_independently=True,
        ),
        SearcherEntry(
            name="failure_kinds",
            summary="a model foresees failures: many kinds",
            build=_plain(FailureKinds),
            title="failures by kind",
            style="green",
            alias="fk",
        ),
        SearcherEntry(
            name="trust_regions",
            summary="local models, restarted by kind: for rare failures",
            build=_plain(TrustRegions),
            title="trust regions",
            style="green",
            alias="tr",
        ),
        SearcherEntry(
            name="sobol",
            summary="scrambled Sobol points: even cover of all ranges",
            build=_quasi("sobol"),
            title="Sobol points",
            style="bright_yellow",
        ),
        SearcherEntry(
            name="halton",
            summary="randomized Halton points: even cover of all ranges",
            build=_quasi("halton"),
            title="Halton points",
            style="bright_yellow",
        ),
        SearcherEntry(
            name="lhs",
            summary="Latin hypercube sampling in each generation",
            build=_quasi("lhs"),
            title="Latin hypercubes",
            style="bright_yellow",
        ),
        SearcherEntry(
            name="cross_entropy",
            summary="a distribution, fitted to the riskiest tenth",
            build=_plain(CrossEntropy),
            title="cross-entropy method",
            style="magenta",
            alias="ce",
        ),
        SearcherEntry(
            name="differential_evolution",
            summary="mutation by differences of members, DE/rand/1/bin",
            build=_plain(DifferentialEvolution),
            title="differential evolution",
            style="bright_cyan",
            alias="de",
        ),
        SearcherEntry(
            name="cmaes",
            summary="a normal distribution that adapts to the risk",
            build=_plain(CovarianceAdaptation),
            title="CMA-ES",
            style="bright_magenta",
            package="cma",
        ),
        SearcherEntry(
            name="nsga2",
            summary="NSGA-II: Pareto front, both close and fast",
            build=_plain(NonDominatedSorting),
            title="NSGA-II",
            style="blue",
            package="pymoo",
        ),
        SearcherEntry(
            name="map_elites",
            summary="the riskiest run for every pair of speeds",
            build=_grid("map_elites"),
            title="MAP-Elites",
            style="bright_green",
            package="ribs",
        ),
        SearcherEntry(
            name="cma_me",
            summary="MAP-Elites with strategies that seek new cells",
            build=_grid("cma_me"),
            title="CMA-ME",
            style="bright_green",
            package="ribs",
        ),
    )
}
"""The methods of cortexc by name, in the order of lists."""
ELSEWHERE = {"tway": "cortexc coverage FILE --method tway"}
"""Names of methods that are no searchers, with the command that has them."""
REMOVED = {"annealing": "ga", "sa": "ga"}
"""Names of methods that were removed, with the method that takes their place."""

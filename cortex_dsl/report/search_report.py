"""What the views of a search are given: the campaign, and where its results lie."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from engine.search.campaign import Campaign


@dataclass(frozen=True)
class SearchReport:
    """One campaign and its traces on disk."""

    campaign: Campaign
    folder: Path | None
    worst_files: Sequence[Path] = ()
    """Concrete scenarios of the worst cases, in their order; fewer where some could not be written."""

    name: str = ""
    """Of the method, where it is not one of ours."""

    @property
    def method(self) -> str:
        return self.name or self.campaign.method.name.lower()


METRICS: Sequence[tuple[str, str, str, int, str]] = (
    ("RL", "mean risk, valid runs", "rl", 2, ""),
    ("NC", "collisions", "nc", 0, ""),
    ("MDG", "mean least distance", "mdg", 2, "m"),
    ("MDEC", "same, no collisions", "mdec", 2, "m"),
    ("NIS", "invalid runs", "nis", 0, ""),
)
"""Name, meaning, field of `Figures`, decimals, unit."""


METHOD_NAMES = {
    "ga": "genetic algorithm",
    "niching": "niching genetic algorithm",
    "sobol": "Sobol points",
    "halton": "Halton points",
    "lhs": "Latin hypercubes",
    "cross_entropy": "cross-entropy method",
    "annealing": "simulated annealing",
    "differential_evolution": "differential evolution",
    "cmaes": "CMA-ES",
    "nsga2": "NSGA-II",
    "map_elites": "MAP-Elites",
    "cma_me": "CMA-ME",
}


def method_name(method: str) -> str:
    """A method as a person calls it."""
    return METHOD_NAMES.get(method, method)

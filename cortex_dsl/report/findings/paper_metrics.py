"""The five metrics of the paper by name, and their meaning for a search with an objective other than the risk."""

from collections.abc import Sequence
from dataclasses import dataclass

from cortex_dsl.report.findings.failures import finds_of
from cortex_dsl.report.findings.readable import fixed
from engine.search.protocol import DEFAULT_OBJECTIVES


@dataclass(frozen=True)
class PaperMetric:
    """One of the five metrics of the paper."""

    name: str
    meaning: str
    brief: str
    """The same in a few words, for a terminal."""
    field: str
    """Field of `engine.search.evaluations.Figures`."""
    decimals: int
    unit: str = ""

    def text(self, value: float) -> str:
        """A value with its unit."""
        return f"{fixed(value, self.decimals)} {self.unit}".strip()


METRICS = (
    PaperMetric("RL", "mean risk of valid scenes", "mean risk, valid runs", "rl", 2),
    PaperMetric("NC", "scenes with a collision", "collisions", "nc", 0),
    PaperMetric("MDG", "mean least distance", "mean least distance", "mdg", 2, "m"),
    PaperMetric("MDEC", "the same, without collisions", "same, no collisions", "mdec", 2, "m"),
    PaperMetric("NIS", "invalid scenes", "invalid runs", "nis", 0),
)


def meaning_of(metric: PaperMetric, objective: Sequence[str]) -> str:
    """Return the meaning of a metric for a search with this objective."""
    if not _is_aimed(metric, objective):
        return metric.meaning
    return f"mean of {objective[0]} of {finds_of(objective).among} scenes"


def brief_of(metric: PaperMetric, objective: Sequence[str]) -> str:
    """Return the meaning in a few words."""
    if not _is_aimed(metric, objective):
        return metric.brief
    return f"mean of {objective[0]}, {finds_of(objective).among} runs"


def _is_aimed(metric: PaperMetric, objective: Sequence[str]) -> bool:
    return tuple(objective) != DEFAULT_OBJECTIVES and metric.field == "rl"

"""Metrics of one run in addition to its risk: the table of metrics, their values by name, and `record`s."""

from engine.metrics.bodies import Body, bodies_of, outlines_of
from engine.metrics.encounters import (
    apart_in_height,
    never_on_one_level,
    scored_samples,
    span_together,
    time_step,
)
from engine.metrics.measures import Metric, Recorded, measure_impacts, measure_trajectory, recorded

__all__ = [
    "Body",
    "Metric",
    "Recorded",
    "apart_in_height",
    "bodies_of",
    "measure_impacts",
    "measure_trajectory",
    "never_on_one_level",
    "outlines_of",
    "recorded",
    "scored_samples",
    "span_together",
    "time_step",
]

"""Whether the counts of a document of `cortexc suite` follow from its cells. Prints nothing."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from cortex_dsl.report.findings.suite_report import Outcome, answer_texts
from engine.gates.ratings import Colour
from engine.search.statistics import clopper_pearson
from engine.vocabulary import Answer

Json = Mapping[str, Any]
CLOSE = 1e-9
"""Relative difference of two computations of one number."""


def answers_of(cell: Json) -> dict[str, dict[Answer, int]]:
    """Return how often each reference driver gave each answer."""
    return {
        name: {Answer[answer.upper()]: count for answer, count in counts.items()}
        for name, counts in cell["answers"].items()
    }


def contradictions(content: Json) -> Iterator[str]:
    """Yield each contradiction, its place first."""
    cells = [cell for group in content["groups"] for cell in group["cells"]]
    for outcome in Outcome:
        name = outcome.name.lower()
        count = sum(cell["outcome"] == name for cell in cells)
        if content["counts"][name] != count:
            yield f"`counts` has {content['counts'][name]} for `{name}`, and {count} cells have this outcome"
    scores = [score for group in content["groups"] for score in group["points"].values() if score]
    total = 0.0 if content["broken_entry_conditions"] else sum(scores)
    if content["points"] is not None and not math.isclose(content["points"], total, rel_tol=CLOSE, abs_tol=CLOSE):
        yield f"`points` is {content['points']:g}, and those of its groups are {total:g}"
    for group in content["groups"]:
        simulations = sum(cell["simulations"] for cell in group["cells"])
        if group["runs"] != simulations:
            yield f"group `{group['name']}`: `runs` is {group['runs']}, and those of its cells are {simulations}"
        for cell in group["cells"]:
            yield from (f"cell `{cell['id']}`: {what}" for what in _in_cell(cell))


def _in_cell(cell: Json) -> Iterator[str]:
    if (cell["outcome"] == "fail") != (cell["colour"] == Colour.RED):
        yield f"its outcome is `{cell['outcome']}`, and its colour is {cell['colour'] or 'none'}"
    drawn, searched = cell["probability"], cell["search"]
    runs, failures = drawn["runs"], drawn["failures"]
    interval = clopper_pearson(failures, runs)
    expected = {"rate": failures / runs if runs else math.nan, "low": interval.low, "high": interval.high}
    for name, value in expected.items():
        given = math.nan if drawn[name] is None else drawn[name]
        if not (math.isclose(given, value, rel_tol=CLOSE) or (math.isnan(given) and math.isnan(value))):
            yield f"`{name}` is {given:g}, and {failures} failures in {runs} runs give {value:g}"
    if searched is not None and (searched["failures"] > 0) > (cell["outcome"] == "fail"):
        yield f"its outcome is `{cell['outcome']}`, and {searched['failures']} runs of its search fail"
    answers = answers_of(cell)
    if len({sum(counts.values()) for counts in answers.values()}) > 1:
        yield "its reference drivers answer to different numbers of collisions"
    if cell["references"] != answer_texts(answers):
        yield "`references` differs from `answers`"

"""Why no scene of a search was valid, and the runs that the engine could not finish."""

from collections import Counter

import numpy as np
from rich.console import Group, RenderableType
from rich.text import Text

from cortex_dsl.report.findings.driven_runs import DRIVEN
from cortex_dsl.report.findings.readable import counted
from cortex_dsl.report.findings.search_report import SearchReport
from cortex_dsl.report.findings.story import end_text
from cortex_dsl.report.findings.tally import Tally, blame_note
from cortex_dsl.report.terminal.requirements_view import blame_view, requirements_view
from cortex_dsl.report.terminal.theme import section
from engine.program import Program
from engine.vocabulary import EndReason, Verdict


def rejections(program: Program, report: SearchReport) -> RenderableType | None:
    """Return why no scene of a search was valid; None if one was driven."""
    evaluations = report.campaign.evaluations
    tally = Tally.of_search(evaluations)
    if np.isin(evaluations.rollouts.verdict, DRIVEN).any() or not tally.attempts:
        return None
    note = "no scene was valid; tested only if the earlier ones held"
    parts = [section("Requirements", requirements_view(program, tally), note)]
    if report.blame is not None:
        parts.append(section("Which requirement is to blame", blame_view(report.blame), blame_note(report.blame)))
    return Group(*parts)


def failures_line(program: Program, report: SearchReport) -> Text | None:
    """Return a line on runs that the engine could not finish; None without any."""
    campaign = report.campaign
    runs = campaign.evaluations.rollouts
    failed = (runs.verdict == Verdict.ERROR) & (runs.end_reason != EndReason.STUCK)
    if not failed.any():
        return None
    reasons = Counter(zip(runs.end_reason[failed].tolist(), runs.end_rule[failed].tolist(), strict=True))
    (reason, rule), _ = reasons.most_common(1)[0]
    what = end_text(program, EndReason(reason), rule) if reason >= 0 else "a scene could not be drawn"
    return Text.assemble(
        (f"{counted(int(failed.sum()), 'run')} failed and are not counted", "bad"), f": {what}; please report it"
    )

"""What a search tells of runs that failed over the file itself, whichever command searched."""

import numpy as np

from cortex_dsl.api.scenario import Scenario
from cortex_dsl.cli.stuck import never_acts
from cortex_dsl.cli.undefined import undefined_value
from cortex_dsl.diagnostics import Diagnostic
from engine.search.campaign import Campaign
from engine.vocabulary import EndReason, Verdict


def mistake_of(scenario: Scenario, campaign: Campaign) -> Diagnostic | None:
    """A behaviour that never acts, or a number that does not exist; None where no run failed over either."""
    evaluations = campaign.evaluations
    rollouts = evaluations.rollouts
    stuck = np.argwhere(rollouts.end_reason == EndReason.STUCK)
    if len(stuck):
        first = tuple(stuck[0])
        return never_acts(scenario, int(rollouts.end_rule[first]), float(rollouts.end_time[first]))
    failed = np.argwhere(rollouts.verdict == Verdict.ERROR)
    if not len(failed):
        return None
    row, rollout = failed[0]
    return undefined_value(scenario, scenario.scene_of(evaluations.genomes[row], evaluations.keys[row, rollout]))

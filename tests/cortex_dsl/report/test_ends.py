"""How the runs of a search ended, and with whom the ego collided."""

from dataclasses import replace

import numpy as np
import pytest

from cortex_dsl.report.blocks import lines_of, plain
from cortex_dsl.report.findings.search_report import SearchReport, ends_of, partners_text
from cortex_dsl.report.views.search import headline
from cortex_dsl.report.views.search_details import paper_lines
from engine.program import Program
from engine.search.evaluations import Partners
from engine.vocabulary import Blame


@pytest.fixture
def three(program: Program) -> Program:
    return replace(program, actors=("ego", "truck", "walker"))


def test_every_partner_is_reported_also_the_missed_one(three: Program, report: SearchReport) -> None:
    """The truck in every collision, the walker in none."""
    found = ends_of(three, report.campaign.evaluations)
    ends = {end.text: end.count for end in found}
    assert ends["collision with truck"] == report.campaign.by_simulation.colliding_runs
    assert ends["collision with walker"] == 0
    assert sum(end.count for end in found) == int(report.campaign.evaluations.simulated.sum())


def test_two_alone_need_no_names(program: Program, report: SearchReport) -> None:
    """A collision is a collision."""
    texts = [end.text for end in ends_of(program, report.campaign.evaluations)]
    assert "collision" in texts
    assert partners_text(program.actors, Partners((3,), 0)) == ""


def test_nothing_valid_misses_nobody(three: Program, nothing_valid: SearchReport) -> None:
    """Without a run there is nobody to collide with."""
    assert not any("walker" in end.text for end in ends_of(three, nothing_valid.campaign.evaluations))


def test_the_headline_counts_simulations_first(three: Program, report: SearchReport) -> None:
    """What speaks against the ego, shares of valid simulations and rates, by partner; the paper's count is apart."""
    hit = report.campaign.evaluations.rollouts.collided & report.campaign.evaluations.simulated[:, np.newaxis]
    blame = np.where(hit, int(Blame.UNAVOIDABLE), int(Blame.NONE))
    blame[np.flatnonzero(hit)[:2]] = int(Blame.AVOIDABLE)
    report = replace(report, campaign=replace(report.campaign, blame=blame))
    first, avoidable, others, every, by = map(plain, lines_of(headline(three, report)))
    (last,) = paper_lines(report)
    found, everyone = report.campaign.by_simulation, report.campaign.by_individual
    assert first.startswith("genetic algorithm: 2 avoidable collisions of ")
    assert first.endswith(f" in {found.valid_runs} valid simulations")
    share = 100 * 2 / found.valid_runs
    left = report.campaign.failures.unavoidable
    assert left > 0
    assert avoidable == f"  avoidable: {share:.2f} % of valid simulations, 1.4 a second"
    assert others == f"  other verdicts: 0 disputed, {left} unavoidable"
    assert f"{100 * found.colliding_runs / found.valid_runs:.1f} % of valid simulations" in every
    assert by == f"  with truck {found.colliding_runs}, walker 0"
    assert last == (
        f"genetic algorithm, as the paper counts, with repeated elites: {everyone.nc} collisions "
        f"among {everyone.individuals} individuals; {report.campaign.distinct_collisions} colliding sets of params"
    )


def test_others_are_named_where_they_are_known() -> None:
    """Beside the ego and two more, a journal does not say which two met."""
    assert partners_text(("ego", "a", "b"), Partners((2, 0), 1_276)).endswith("; 1,276 of a and b, without ego")
    assert (
        partners_text(("ego", "a", "b", "c"), Partners((2, 0, 1), 4)) == "with a 2, b 0, c 1; 4 of others, without ego"
    )

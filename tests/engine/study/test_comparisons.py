"""What a study claims: tests run by run, corrected by families, and words that say no more than they show."""

import csv
import json
import math
from collections.abc import Sequence
from dataclasses import replace
from io import StringIO

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from engine.paper import FILES, GA, GENES, RANDOM, place_of
from engine.study.comparisons import MEASURES, PRIMARY, compare_all, measures_of, ranked, sample, spread
from engine.study.database import Study, read_evaluations
from engine.study.plan import Address, Plan
from engine.study.run_records import FIELDS, RunRecord, curve_of, smoothed
from engine.study.study_files import GENERATIONS, RUNS, SUMMARY, TESTS, study_files
from engine.study.verdict import (
    Beside,
    beside_paper,
    findings,
    log_error,
    own_row,
    random_rates,
    studies,
    verdict,
)

RATIOS = st.floats(1e-3, 1e3)
FIRST_COLLISION = next(measure for measure in MEASURES if measure.name == "first collision")


def pretend(study: Study, collisions: dict[str, Sequence[int]]) -> tuple[Plan, list[RunRecord]]:
    """A study of many runs whose distinct collisions are these, by method, on every scenario."""
    first = study.records[0]
    runs = len(next(iter(collisions.values())))
    plan = replace(study.plan, methods=tuple(collisions), runs=runs)
    records = [
        replace(
            first,
            address=address,
            figures=replace(first.figures, distinct_collisions=collisions[address.method][address.run]),
        )
        for address in plan.addresses()
    ]
    return plan, records


def claimed(plan: Plan, records: list[RunRecord]) -> Sequence[str]:
    return verdict(plan, compare_all(plan, records))


def test_a_spread_is_numpys() -> None:
    values = np.array([3.0, 9.0, 1.0, 7.0, 7.5])
    found = spread(values)
    assert found.runs == 5
    assert found.median == np.median(values)
    assert tuple(found.quartiles) == tuple(np.percentile(values, [25, 75]))
    assert found.mean == values.mean()
    assert found.deviation == values.std(ddof=1)
    assert np.isnan(spread(values[:0]).median)


def test_p_is_of_runs_and_corrected_over_scenarios_and_contenders(study: Study) -> None:
    generator = np.random.default_rng(1)
    collisions = {name: generator.integers(0, 60, 12).tolist() for name in ("random", "ga", "niching")}
    plan, records = pretend(study, collisions)
    rows = [row for row in compare_all(plan, records) if row.measure is PRIMARY]
    assert len(rows) == 4
    expected = stats.mannwhitneyu(collisions["ga"], collisions["random"], method="asymptotic").pvalue
    assert rows[0].p == pytest.approx(expected, rel=1e-12)
    least = min(row.p for row in rows)
    assert min(row.p_holm for row in rows) == pytest.approx(min(1.0, 4 * least))


def test_the_families_are_those_of_the_plan_of_analysis() -> None:
    families = [measure.family for measure in MEASURES]
    assert [m.name for m in MEASURES if m.family == "primary"] == [
        "avoidable",
        "avoidable kinds",
        "colliding genomes",
        "kinds",
    ]
    assert {m.family for m in MEASURES if not m.exploratory} == {"primary", "secondary"}
    assert [m.name for m in MEASURES if m.family == "secondary"] == ["RL", "MDG", "MDEC", "NIS"]
    assert families.count("last ten generations") == families.count("by simulation") == 5


@pytest.mark.parametrize(
    ("ga", "beats", "loses"),
    [(range(100, 130), True, False), (range(30), False, False), (range(-100, -70), False, True)],
)
def test_beats_needs_median_p_and_effect(study: Study, ga: range, beats: bool, loses: bool) -> None:
    plan, records = pretend(study, {"random": list(range(30)), "ga": list(ga)})
    rows = compare_all(plan, records, (PRIMARY,))
    assert {row.beats for row in rows} == {beats}
    assert {row.loses for row in rows} == {loses}
    assert all(row.stars == ("" if not (beats or loses) else "***") for row in rows)


@pytest.mark.parametrize("runs", [5, 29])
def test_fewer_than_thirty_runs_decide_nothing(study: Study, runs: int) -> None:
    """However clear it looks, and whatever the stars say."""
    plan, records = pretend(study, {"random": list(range(runs)), "ga": list(range(100, 100 + runs))})
    (row, _) = compare_all(plan, records, (PRIMARY,))
    assert row.marks.startswith("▲*")
    assert not row.beats
    assert row.words == f"undecided at {runs} runs"
    assert "undecided in 2 scenarios" in verdict(plan, (row, row, *compare_all(plan, records)))[0]


def test_marks_say_which_way(study: Study) -> None:
    plan, records = pretend(study, {"random": list(range(30)), "ga": list(range(-100, -70))})
    row = compare_all(plan, records, (PRIMARY,))[0]
    assert (row.marks, row.words) == ("▼***", "worse")


def with_first_collisions(study: Study, first: dict[str, Sequence[float]]) -> tuple[Plan, list[RunRecord]]:
    """A study of many runs whose first collisions are these; NaN: it never collided."""
    plan, records = pretend(study, {name: [0] * len(values) for name, values in first.items()})
    changed = [
        replace(r, figures=replace(r.figures, first_collision=float(first[r.address.method][r.address.run])))
        for r in records
    ]
    return plan, changed


def test_runs_that_never_collide_are_no_reward(study: Study) -> None:
    """Eight runs of thirty collide soon and the others never, where the baseline always does: that is worse."""
    stream = np.random.default_rng(0)
    baseline = stream.integers(1500, 2900, 30).tolist()
    contender = [*stream.integers(200, 900, 8).tolist(), *[float("nan")] * 22]
    plan, records = with_first_collisions(study, {"random": baseline, "ga": contender})
    row = compare_all(plan, records, (FIRST_COLLISION,))[0]
    assert row.a12 == pytest.approx(8 / 30)
    assert row.loses
    assert (row.spread.runs, row.spread.missing) == (30, 22)
    assert row.spread.median == np.inf
    assert np.isnan(row.spread.mean)
    assert row.missing == "ga: 22 of 30 never collided"
    known = sample(records, 0, "ga", FIRST_COLLISION)
    assert len(known) == 8
    assert row.p == pytest.approx(stats.mannwhitneyu([*known, *[3001] * 22], baseline, method="asymptotic").pvalue)


def test_a_missing_number_is_the_worst_whichever_way_is_better(study: Study) -> None:
    """No valid run: no mean risk, which ranks below all others; no first collision ranks behind all others."""
    assert spread(np.array([1.0, -np.inf, -np.inf])).median == -np.inf
    assert spread(np.array([1.0, 2.0, np.inf])).median == 2.0
    assert spread(np.array([1.0, 2.0, 4.0, np.inf])).quartiles.low == 1.75
    assert spread(np.array([1.0, np.inf])).median == np.inf
    (rl,) = (measure for measure in MEASURES if measure.name == "RL")
    record = study.records[0]
    individuals = replace(record.figures.individuals, rl=float("nan"))
    nothing = replace(record, figures=replace(record.figures, individuals=individuals))
    assert ranked([nothing], 0, record.address.method, rl).tolist() == [-np.inf]
    assert sample([nothing], 0, record.address.method, rl).tolist() == []


def test_one_simulation_a_genome_makes_one_measure_superfluous(study: Study) -> None:
    """It would be tested twice, under two names."""
    for record in study.records:
        assert record.figures.simulations.nc == record.figures.distinct_collisions
    assert "NC, by simulation" not in {row.measure.name for row in compare_all(study.plan, study.records)}
    assert "NC, by simulation" in {measure.name for measure in measures_of(2)}


def test_scenarios_do_not_share_their_random_numbers(study: Study) -> None:
    """Each has its own seed, and reads its keys back with it."""
    assert len(set(study.plan.seeds)) == 2
    assert not study.plan.shares_draws
    found = [read_evaluations(study, Address(scenario, "random", 0)) for scenario in (0, 1)]
    assert not np.array_equal(found[0].genomes, found[1].genomes)
    assert [int(each.keys[0, 0, 0]) for each in found] == list(study.plan.seeds)
    same = replace(study.plan, subjects=(study.plan.subjects[0], replace(study.plan.subjects[0], name="again")))
    assert same.shares_draws
    assert any("share their random numbers" in text for text in verdict(same, compare_all(study.plan, study.records)))


def test_a_sure_but_small_effect_does_not_beat(study: Study) -> None:
    """With very many runs p is small whatever the size; A12 below 0.64 is not enough."""
    random = np.arange(1500) % 100
    plan, records = pretend(study, {"random": random.tolist(), "ga": (random + 10).tolist()})
    row = compare_all(plan, records, (PRIMARY,))[0]
    assert row.p_holm < 0.001
    assert 0.5 < row.a12 < 0.64
    assert not row.beats


def test_smaller_is_better_for_distances(study: Study) -> None:
    mdg = next(measure for measure in MEASURES if measure.name == "MDG")
    rows = compare_all(study.plan, study.records, (mdg,))
    for number, row in enumerate(rows):
        ours, theirs = (sample(study.records, number, method, mdg) for method in ("ga", "random"))
        assert (row.a12 > 0.5) == (np.mean(ours[:, None] < theirs) > 0.5)


def test_words_do_not_claim_what_few_runs_cannot_show(study: Study) -> None:
    few = claimed(*pretend(study, {"random": [0, 1], "ga": [9, 8]}))
    assert "undecided in 2 scenarios" in few[0]
    assert "2 runs" in few[-1]
    assert "hint" in few[-1]
    many = claimed(*pretend(study, {"random": [0] * 30, "ga": [9] * 30}))
    assert "; colliding genomes more in 2 of 2 scenarios; kinds no clear difference in 2 scenarios" in many[0]
    assert len(many) == 1


def test_one_method_alone_is_compared_with_nothing(study: Study) -> None:
    plan, records = pretend(study, {"ga": [1, 2]})
    found = findings(plan, records)
    assert found.comparisons == ()
    assert "nothing to compare" in found.verdict[0]


def test_rates_are_of_random_sampling_alone(study: Study) -> None:
    rates = random_rates(study.plan, study.records)
    runs = [r.figures.individuals for r in study.records if r.address[:2] == (0, "random")]
    assert rates[0].individuals == 3 * 48
    assert rates[0].collisions == sum(figures.nc for figures in runs)
    exact = stats.binomtest(rates[0].valid, rates[0].individuals).proportion_ci(method="exact")
    assert rates[0].valid_rate == pytest.approx((exact.low, exact.high))
    letter = FILES.index("left_turn")
    table = [
        [rates[0].collisions, rates[0].valid - rates[0].collisions],
        [RANDOM.nc[letter], RANDOM.valid[letter] - RANDOM.nc[letter]],
    ]
    assert rates[0].against_paper.p == pytest.approx(stats.fisher_exact(np.array(table)).pvalue)
    assert random_rates(replace(study.plan, methods=("ga",)), study.records) == ()


def test_the_paper_stands_beside_its_own_budget_alone(study: Study) -> None:
    assert beside_paper(study.plan, study.records) == ()
    subjects = tuple(
        replace(s, config=replace(s.config, search=replace(s.config.search, generations=30, population=100)))
        for s in study.plan.subjects
    )
    rows = beside_paper(replace(study.plan, subjects=subjects), study.records)
    assert len(rows) == 2 * 7
    assert (rows[0].letter, rows[0].measure.name, rows[0].paper_ga, rows[0].paper_random) == ("A", "RL", 13.3, 9.7)
    distance = next(row for row in rows if row.measure.name == "MDG, last 10")
    assert distance.paper_ga == pytest.approx(GA.mdg_last[0] / 100)


def test_a_file_of_another_is_not_the_papers(study: Study) -> None:
    """A scenario is the paper's by its name and by its params."""
    assert [place_of(name, GENES) for name in ("left_turn", "A", "F", "mine")] == [0, 0, 5, None]
    assert place_of("A", {*GENES, "RAIN"}) is None
    assert place_of("A", ["SPEED"]) is None


@given(st.lists(st.tuples(RATIOS, RATIOS), min_size=1, max_size=6))
def test_the_error_of_a_metric_is_that_of_its_ratios(pairs: list[tuple[float, float]]) -> None:
    """It has no unit, is 0 for equal ratios alone, and is the same where both are turned around."""
    rows = [Beside("A", "left_turn", PRIMARY, ours, 1.0, paper, 1.0) for ours, paper in pairs]
    assert log_error(rows) == pytest.approx(np.mean([abs(math.log(ours / paper)) for ours, paper in pairs]))
    turned = [replace(row, ga=row.random, random=row.ga, paper_ga=1.0, paper_random=row.paper_ga) for row in rows]
    assert log_error(turned) == pytest.approx(log_error(rows))
    larger = [replace(row, ga=100 * row.ga, random=100 * row.random) for row in rows]
    assert log_error(larger) == pytest.approx(log_error(rows))


def test_a_metric_that_is_zero_is_not_reproduced() -> None:
    row = Beside("A", "left_turn", PRIMARY, 0.0, 3.0, 1.0, 2.0)
    assert log_error([row, replace(row, ga=1.5)]) == math.inf
    assert log_error([replace(row, random=0.0)]) == math.inf


def test_our_row_among_the_studies_counts_simulations(study: Study) -> None:
    row = own_row(study.plan, study.records)
    assert int(row.cases) == sum(record.figures.simulations.runs for record in study.records)
    assert studies(study.plan, study.records)[-1] == row
    assert "random" in row.collisions
    assert "GA" in row.collisions


def test_curves_are_the_generations_of_every_run(study: Study) -> None:
    curve = curve_of(study.plan, study.records, 1, "ga", "nis")
    assert curve.values.shape == (3, 4)
    totals = [r.figures.individuals.nis for r in study.records if r.address[:2] == (1, "ga")]
    assert curve.values.sum(axis=1).tolist() == totals
    low, high = curve.band()
    assert (low <= curve.median).all()
    assert (curve.median <= high).all()
    with pytest.raises(ValueError, match="none of"):
        curve_of(study.plan, study.records, 0, "ga", "speed")


def test_smoothing_keeps_a_parabola_and_short_courses() -> None:
    parabola = np.arange(20.0) ** 2
    assert smoothed(parabola) == pytest.approx(parabola)
    noisy = parabola + np.random.default_rng(0).normal(size=20)
    assert np.abs(np.diff(smoothed(noisy), 3)).sum() < np.abs(np.diff(noisy, 3)).sum()
    assert smoothed(parabola[:4]) is not None
    gap = np.where(np.arange(20) == 3, np.nan, parabola)
    assert np.array_equal(smoothed(gap), gap, equal_nan=True)


def test_exports_say_what_the_records_say(study: Study) -> None:
    files = study_files(study, findings(study.plan, study.records))
    with StringIO(files[RUNS].decode()) as file:
        runs = list(csv.DictReader(file))
    assert len(runs) == len(study.records)
    assert float(runs[-1]["rl"]) == study.records[-1].figures.individuals.rl
    assert int(runs[-1]["distinct_collisions"]) == study.records[-1].figures.distinct_collisions
    with StringIO(files[GENERATIONS].decode()) as file:
        generations = list(csv.DictReader(file))
    assert len(generations) == 4 * len(study.records)
    last = study.records[-1].course[:, FIELDS.index("nis"), -1]
    assert [float(generations[-1][name]) for name in ("nis", "simulated_nis")] == last.tolist()
    with StringIO(files[TESTS].decode()) as file:
        assert len(list(csv.DictReader(file))) == 2 * len(measures_of(rollouts=1))
    document = json.loads(files[SUMMARY])
    assert document["complete"]
    assert document["presets"] == {"ga": "cortex"}
    assert document["tests"][0]["measure"] == "avoidable"
    own = document["this_study"]
    assert own["simulations"] == sum(record.figures.simulations.runs for record in study.records)
    assert own["seconds_per_simulation"] > 0.0
    assert [row["method"] for row in own["methods"]] == ["ga", "random"]
    assert all(0 < row["collisions"] < row["valid"] <= row["individuals"] for row in own["methods"])


def test_addresses_fill_all_cells_evenly(study: Study) -> None:
    first = list(study.plan.addresses())[:4]
    assert first == [Address(s, m, 0) for s in (0, 1) for m in ("random", "ga")]


def test_a_study_without_a_single_run_can_be_shown(study: Study) -> None:
    """Ctrl-C may come first."""
    found = findings(study.plan, [])
    assert "0 runs" in found.verdict[-1]
    assert not any(row.beats or row.loses for row in found.comparisons)
    assert set(study_files(replace(study, records=()), found)) == {RUNS, GENERATIONS, TESTS, SUMMARY}


def test_the_last_ten_of_ten_or_fewer_are_all() -> None:
    """The name says so, and the table over how many generations a measure counts."""
    measure = next(each for each in MEASURES if each.name == "NIS, last 10")
    assert [measure.title_for(generations) for generations in (4, 10, 11)] == [
        "NIS, all 4",
        "NIS, all 10",
        "NIS, last 10",
    ]
    assert [measure.counted(generations) for generations in (4, 30)] == [4, 10]
    assert PRIMARY.title_for(4) == PRIMARY.name
    assert PRIMARY.counted(30) == 30

"""Every view at every width: it renders, fits, and says what it must."""

import io
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from threading import Event

import numpy as np
import pytest
from rich.console import Console, Group, RenderableType

from cortex_dsl.report.findings.readable import KM_H, name_of
from cortex_dsl.report.findings.run_report import RunReport, run_content
from cortex_dsl.report.findings.search_report import SearchReport
from cortex_dsl.report.findings.story import end_of
from cortex_dsl.report.findings.tally import Tally
from cortex_dsl.report.terminal.progress import SearchProgress, progress_line, progress_view
from cortex_dsl.report.terminal.render import parts, rendered
from cortex_dsl.report.terminal.theme import THEME, title_of
from cortex_dsl.report.views.measures import further_pairs, measures_blocks, run_details
from cortex_dsl.report.views.requirements import no_scene_view
from cortex_dsl.report.views.run import run_screen
from cortex_dsl.report.views.samples import sample_view
from cortex_dsl.report.views.search import comparison_screen, search_screen
from cortex_dsl.report.views.search_details import paper_details, search_details
from cortex_dsl.semantics.names.linking import FixedParam
from engine.maps import RoadSpec
from engine.metrics import Metric, Recorded
from engine.outcomes import Outcomes
from engine.program import Program, Rule
from engine.road import build_network
from engine.road.outline import outline
from engine.scenes import Scenes, Trajectory
from engine.vocabulary import EndReason, Fault, RuleKind, State, Verdict

WIDTHS = (60, 80, 100, 120)
ROAD = outline(build_network(RoadSpec()))


METRICS = (
    Metric("MD", (0, 1), 2.31, "m", "least distance between the outlines"),
    Metric("DRAC", (0, 1), 3.4567, "m/s^2", "largest deceleration needed"),
    Metric("THW", (0, 1), np.inf, "s", "least headway behind a leader"),
    Metric("pedal oscillation", (0,), 0.25, "1/s", "switches between throttle and brake"),
    Metric("pedal oscillation", (1,), np.nan, "1/s", "switches between throttle and brake"),
)
TICKS = np.arange(5, dtype=np.float64) * 0.05
RECORDS = (
    Recorded("gap", "series", "m", 51, TICKS, np.array([5.0, 4.0, np.nan, 2.5, 2.31])),
    Recorded("entry speed", "initial", "m/s", 52, TICKS[:1], np.array([12.0])),
    Recorded("never a number", "final", "", 53, TICKS[-1:], np.array([np.nan])),
)


def render(view: RenderableType, width: int, *, encoding: str = "utf-8", colour: bool = False) -> str:
    """What the view prints on a terminal of this width; the encoding must be able to hold it."""
    stream = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    console = Console(file=stream, theme=THEME, width=width, highlight=False, force_terminal=colour, markup=False)
    console.print(view)
    stream.flush()
    assert isinstance(stream.buffer, io.BytesIO)
    return stream.buffer.getvalue().decode(encoding)


def run_view(report: RunReport, width: int, *, ascii_only: bool = False) -> RenderableType:
    """The screen of a run, and what --metrics adds."""
    screen = rendered(run_screen(report), width, ascii_only=ascii_only)
    return Group(screen, parts(run_details(report), width, ascii_only=ascii_only))


def search_view(program: Program, report: SearchReport, settings: str, width: int) -> RenderableType:
    """The screen of a search, and what --paper and --metrics add."""
    screen = (
        rendered(search_screen(program, report, settings), width),
        parts([paper_details([report], settings)], width),
    )
    return Group(*screen, parts(search_details(program, report), width))


def comparison_view(program: Program, reports: Sequence[SearchReport], settings: str, width: int) -> RenderableType:
    """The screen of a search by several methods, and what --paper and --metrics add."""
    screen = rendered(comparison_screen(program, reports, settings), width)
    details = (parts(search_details(program, report), width) for report in reports)
    return Group(screen, parts([paper_details(reports, settings)], width), *details)


def assert_fits(text: str, width: int) -> None:
    assert max(map(len, text.splitlines())) <= width


@pytest.fixture
def run(program: Program, scenes: Scenes, outcomes: Outcomes, trajectory: Trajectory) -> RunReport:
    return RunReport(
        program=program,
        scenes=scenes,
        outcomes=outcomes,
        trajectory=trajectory,
        impacts=(),
        score=11,
        parts=(0.0, 4.0, 3.0, 4.0),
        pair=0,
        profile="paper",
        engine="world",
        road=ROAD,
        metrics=METRICS,
        records=RECORDS,
        reproduce="cortexc examples/left_turn.scn --seed 0",
    )


@pytest.mark.parametrize("width", WIDTHS)
def test_run(run: RunReport, width: int) -> None:
    """A run shows its drawing, story, metrics with units, risk, params, choices and how to see it again."""
    text = render(run_view(run, width), width)
    assert_fits(text, width)
    for word in ("closest", "2.31 m", "71.42 km/h", "risk 11 of 22", "EGO_SPEED", "43.17", "km/h", "wet", "north.in.1"):
        assert word in " ".join(text.split())
    assert "cortexc examples/left_turn.scn --seed 0" in " ".join(text.split())
    assert any(0x2800 < ord(character) < 0x2900 for character in text)


@pytest.mark.parametrize("width", WIDTHS)
def test_run_shows_records_and_other_measures(run: RunReport, width: int) -> None:
    """A record over time as its range, one at an end with its moment; measures of the pair and of its actors."""
    text = render(run_view(run, width), width)
    assert_fits(text, width)
    words = " ".join(text.split())
    for phrase in ("2.31 .. 5 m", "at the start 12 m/s", "never a number at the end –", "DRAC 3.46 m/s^2", "THW ∞ s"):
        assert phrase in words
    assert "pedal oscillation ego 0.25, adversary – 1/s" in words
    assert "least distance between the outlines" not in words.split("Other measures")[1]


def test_an_aborted_run_says_what_it_broke_and_has_no_risk(run: RunReport, program: Program) -> None:
    """The rule, its line and the time stand in the headline; nothing is measured."""
    rules = (Rule("always distance from ego to adversary > 3 m", 17, RuleKind.ABORT),)
    unknown = np.full((1, 1), np.nan)
    broken = replace(
        run.outcomes,
        verdict=np.array([Verdict.ABORTED], dtype=np.int32),
        end_reason=np.array([EndReason.ABORTED], dtype=np.int32),
        min_distance=unknown,
        min_distance_time=unknown,
        max_closing_speed=unknown,
        max_closing_time=unknown,
    )
    report = replace(run, program=replace(program, rules=rules), outcomes=broken, score=-1, metrics=())
    text = render(run_view(report, 100), 100)
    assert text.splitlines()[1] == (
        "invalid, for it broke `always distance from ego to adversary > 3 m` (line 17)  after 4.45 s"
    )
    assert not any(title in text for title in ("Metrics", "Risk", "Other measures", "closest"))
    content = run_content(report, "f.scn")
    assert content["verdict"] == Verdict.ABORTED
    assert (content["end"]["rule"], content["end"]["line"]) == (rules[0].name, 17)


def test_who_comes_in_later_is_reported_then(run: RunReport, trajectory: Trajectory) -> None:
    """Not at the start."""
    states = trajectory.states.copy()
    states[:20, 1, State.PRESENT] = 0.0
    text = render(run_view(replace(run, trajectory=replace(trajectory, states=states)), 80), 80)
    assert "1.00 s adversary comes in at 28.8 km/h" in " ".join(text.split())


def test_run_with_contact(run: RunReport, collision: Outcomes) -> None:
    """Contact is the headline, and marked in the drawing."""
    text = render(run_view(replace(run, outcomes=collision), 96), 96)
    assert text.splitlines()[1].startswith("contact: ego and adversary")
    assert "✕" in text
    assert "closest to" not in text


def test_risk_names_the_band_of_each_part(run: RunReport, collision: Outcomes) -> None:
    """Points are explained by the limits that gave them; without any, by the limit that was not undercut."""
    text = " ".join(render(run_view(run, 80), 80).split())
    for phrase in ("no contact", "below 8.2 m", "37.8 to 40.2 m", "below 3.59 s"):
        assert phrase in text
    nothing = replace(run, outcomes=collision, parts=(10.0, 4.0, 0.0, 0.0))
    assert "not below 44.9 m" in " ".join(render(run_view(nothing, 80), 80).split())


def test_run_in_plain_ascii(run: RunReport) -> None:
    """A terminal without braille gets a drawing of plain characters."""
    drawing = render(run_view(run, 80, ascii_only=True), 80).split("What happened")[0]
    assert "E" in drawing
    assert drawing.isascii()


def test_run_of_a_lonely_actor(run: RunReport, program: Program, outcomes: Outcomes, trajectory: Trajectory) -> None:
    """Without another actor there is no pair: no metrics, no risk, no failure."""
    none = np.zeros((1, 0))
    alone = replace(
        outcomes,
        min_distance=none,
        min_distance_time=none,
        max_closing_speed=none,
        max_closing_time=none,
        distance_at_ms=none,
        ttc_at_ms=none,
        left_road_time=np.array([[np.nan]]),
    )
    single = replace(trajectory, states=trajectory.states[:, :1], outlines=trajectory.outlines[:1])
    alone_program = replace(program, actors=("ego",))
    lonely = replace(run, program=alone_program, outcomes=alone, trajectory=single, metrics=METRICS[3:4])
    text = render(run_view(lonely, 80), 80)
    assert "Risk" not in text
    assert "pedal oscillation ego 0.25 1/s" in " ".join(text.split())
    assert "ended by" in text


@pytest.mark.parametrize("width", WIDTHS)
def test_sample(program: Program, scenes: Scenes, width: int) -> None:
    """A sample shows its verdicts, its acceptance, and every requirement with its line and counts."""
    many = Tally().plus(scenes).plus(replace(scenes, verdict=np.array([Verdict.EXHAUSTED], dtype=np.int32)))
    text = render(rendered(sample_view(program, many, 0.1, "seed 0"), width), width)
    assert_fits(text, width)
    words = " ".join(text.split())
    for phrase in ("2 scenes", "valid 1 50.0 %", "exhausted 1 50.0 %", "6 attempts, 16.7 % of them accepted"):
        assert phrase in words
    assert "first culprit: adversary starts where it should (line 42) held in 50.0 % of its tests" in words


@pytest.mark.parametrize("width", WIDTHS)
def test_exhausted(program: Program, scenes: Scenes, width: int) -> None:
    """Without a scene: the table, the culprit that never held, the params that were tried, and a cure."""
    never = replace(scenes, failed=np.array([[1, 2, 0, 0]], dtype=np.int64))
    view = no_scene_view(program, Tally().plus(never), Verdict.EXHAUSTED, scenes.genomes[0])
    text = render(parts(view, width), width)
    assert_fits(text, width)
    words = " ".join(text.split())
    assert words.startswith("no valid scene in 3 attempts")
    assert "adversary starts where it should (line 42) never held" in words
    assert "43.17" in words
    assert "help:" in words


@pytest.mark.parametrize("width", WIDTHS)
def test_search(program: Program, report: SearchReport, width: int) -> None:
    """A search shows its figures, the worst with params and parts, the genes, the ends, and where results lie."""
    text = render(search_view(program, report, "30 x 100", width), width)
    assert_fits(text, width)
    words = " ".join(text.split())
    for phrase in (
        "RL mean risk",
        "The 10 worst cases",
        "How runs ended",
        "runs/left_turn-0/",
        "10+2+2+2",
        "WEATHER none",
    ):
        assert phrase in words
    assert "of TERM_DIST" not in words


def test_search_names_what_each_gene_did(program: Program, report: SearchReport) -> None:
    """The brake decides and has a falling trend; the weather is said to change nothing."""
    text = render(search_view(program, report, "", 100), 100)
    lines = [line.split() for line in text.split("What each gene did")[1].splitlines()]
    genes = {words[0]: words[1:] for words in lines if len(words) > 4 and words[1] != "changes"}
    assert genes["EGO_BRAKE"][0] == "5.5"
    assert genes["EGO_BRAKE"][2] == "30"
    assert genes["EGO_BRAKE"][3].startswith("-0.")
    assert genes["WEATHER"][0] == "none"
    assert "WEATHER changes nothing" in text
    assert "trend: rank correlation with risk" in text


def test_the_trend_is_that_of_what_is_sought(program: Program, report: SearchReport) -> None:
    """A search for avoidable collisions correlates genes with what it makes large."""
    aimed = replace(report, campaign=replace(report.campaign, objective=("avoidable",)))
    assert "trend: rank correlation with avoidable" in render(search_view(program, aimed, "", 100), 100)


@pytest.mark.parametrize("width", WIDTHS)
def test_comparison(program: Program, report: SearchReport, width: int) -> None:
    """Two methods stand side by side, each with its own details below."""
    text = render(
        comparison_view(
            program, [report, replace(report, campaign=replace(report.campaign, method="random"))], "", width
        ),
        width,
    )
    assert_fits(text, width)
    assert text.count("The 4 worst cases of ") == 2


def test_courses_side_by_side_share_a_scale(program: Program, report: SearchReport) -> None:
    """A method with a tenth of the collisions has a course near the ground, however it wavers."""
    few = [
        replace(g, by_individual=replace(g.by_individual, nc=g.by_individual.nc // 10))
        for g in report.campaign.generations
    ]
    other = replace(report, campaign=replace(report.campaign, method="random", generations=tuple(few)))
    text = render(comparison_view(program, [report, other], "", 80), 80)
    first, second = next(line for line in text.splitlines() if line.strip().startswith("NC")).split()[2:][1::2]
    assert "█" in first
    assert set(second) == {"▁"}


def test_worst_cases_that_share_a_param_are_called_alike(program: Program, report: SearchReport) -> None:
    """Ten cases with one speed are said to have it; the params in which they differ are not named."""
    worst = tuple(replace(c, genome=(50.0 + 0.1 * c.rank, c.rank / 10, 1.0)) for c in report.campaign.worst)
    text = render(search_view(program, replace(report, campaign=replace(report.campaign, worst=worst)), "", 80), 80)
    assert "  alike: EGO_SPEED 50.10 .. 51.00 km/h, WEATHER wet" in map(str.rstrip, text.splitlines())


def test_results_are_named_where_they_lie(program: Program, report: SearchReport, tmp_path: Path) -> None:
    """Every file of the run directory is explained, and none that is not there."""
    (tmp_path / "summary.json").touch()
    text = render(search_view(program, replace(report, folder=tmp_path), "", 80), 80)
    assert "summary.json  the figures of this page, for programs" in text
    assert "journal.sqlite" not in text


def test_a_search_with_one_actor_says_that_it_finds_nothing(program: Program, report: SearchReport) -> None:
    """Risk is between two: alone, whatever the params are, it is 0, and that is no success."""
    alone = replace(program, actors=("ego",))
    assert "the ego is the only actor" in render(search_view(alone, report, "", 80), 80)
    assert "no actor but" not in render(search_view(program, report, "", 80), 80)


def test_aborted_runs_are_reported_with_what_they_broke(program: Program, report: SearchReport) -> None:
    """Among the ends, also where no run was valid."""
    rules = (*program.rules, Rule("keeps clear", 17, RuleKind.ABORT))
    evaluations = report.campaign.evaluations
    runs = evaluations.rollouts
    aborted = runs.verdict != Verdict.VALID
    broken = replace(
        runs,
        verdict=np.where(aborted, int(Verdict.ABORTED), runs.verdict),
        end_reason=np.where(aborted, int(EndReason.ABORTED), runs.end_reason),
        end_rule=np.where(aborted, 1, runs.end_rule),
    )
    campaign = replace(report.campaign, evaluations=replace(evaluations, rollouts=broken))
    view = search_view(replace(program, rules=rules), replace(report, campaign=campaign), "", 100)
    text = render(view, 100)
    assert aborted.any()
    assert "invalid, for it broke `keeps clear` (line 17)" in " ".join(text.split())


def test_search_without_a_single_valid_run(program: Program, nothing_valid: SearchReport) -> None:
    """Nothing valid is said, not divided by."""
    text = " ".join(render(search_view(program, nothing_valid, "", 80), 80).split())
    assert "0 collisions among 400 individuals" in text


@pytest.mark.parametrize("width", WIDTHS)
def test_progress(report: SearchReport, width: int) -> None:
    """Progress names the generation, the five metrics, the best, the speed and the time left."""
    text = render(progress_view("ga", [g.by_individual for g in report.campaign.generations], 30, 2000, 1.1, 16), width)
    assert_fits(text, width)
    for word in ("generation 8 of 30", "1,818 sim/s", "3.0 s left", "RL", "NC", "MDG", "MDEC", "NIS", "best"):
        assert word in " ".join(text.split())


class _Log(io.StringIO):
    """A file that is no terminal, and an event once `lines` lines are in it."""

    def __init__(self, lines: int) -> None:
        super().__init__()
        self.lines, self.full = lines, Event()

    def write(self, text: str) -> int:
        written = super().write(text)
        if self.getvalue().count("\n") >= self.lines:
            self.full.set()
        return written


def test_a_short_search_writes_nothing_into_a_log(report: SearchReport) -> None:
    """A log file gets no redrawn lines, and no line in the first half minute."""
    stream = io.StringIO()
    with SearchProgress(Console(file=stream, theme=THEME), "ga", 30) as progress:
        progress.generation_done(report.campaign.generations[0].by_individual, 100, 16)
    assert stream.getvalue() == ""


def test_a_long_search_writes_lines_into_a_log(report: SearchReport) -> None:
    """Each interval a line of plain text: generations, runs and the time left; none once the search is over."""
    stream = _Log(3)
    console = Console(file=stream, theme=THEME, width=20)
    with SearchProgress(console, "ga", 30, interval=0.01) as progress:
        progress.generation_done(report.campaign.generations[0].by_individual, 1234, 16)
        assert stream.full.wait(60)
    progress.ticker.thread.join(60)
    assert not progress.ticker.thread.is_alive()
    lines = stream.getvalue().splitlines()
    assert any(re.fullmatch(r"ga: 1 of 30 generations, 1,234 runs, \d+\.\d s left", line) for line in lines)
    assert "\x1b" not in stream.getvalue()


@pytest.mark.parametrize(
    ("done", "simulations", "text"),
    [
        (0, 0, "ga: generation 1 of 30, 45 s so far, at least 22 min 30 s in all"),
        (15, 0, "ga: 15 of 30 generations, 45 s left"),
        (10, 12_345, "ga: 10 of 30 generations, 12,345 runs, 1 min 30 s left"),
    ],
)
def test_a_line_about_a_search(done: int, simulations: int, text: str) -> None:
    """Before the first generation nothing is known of the time left; a search that goes on has no runs of its own."""
    assert progress_line("ga", done, 30, simulations, 45.0).plain == text


def test_colour_is_only_the_terminals_own(run: RunReport) -> None:
    """Sixteen colours: the terminal's theme decides how they look."""
    text = render(run_view(run, 80), 80, colour=True)
    assert "\x1b[1;36m" in text
    assert "38;2;" not in text
    assert "38;5;" not in text


@pytest.mark.parametrize("width", WIDTHS)
def test_whom_the_ego_hit(program: Program, report: SearchReport, width: int) -> None:
    """Each of the worst names the other actor where there is more than one; of two actors nothing need be said."""
    third = replace(program, actors=("ego", "adversary", "delivery van"))
    rollouts = report.campaign.evaluations.rollouts
    case = report.campaign.worst[1]
    pair = rollouts.pair.copy()
    pair[case.row, case.rollout] = 1
    evaluations = replace(report.campaign.evaluations, rollouts=replace(rollouts, pair=pair))
    failed = replace(report, campaign=replace(report.campaign, evaluations=evaluations))
    text = render(search_view(third, failed, "", width), width)
    assert_fits(text, width)
    for title, place in (("The 10 worst cases", 1), ("Params of the worst cases", 4)):
        rows = [line.split() for line in text.split(title)[1].splitlines() if line.strip()[:2].strip().isdigit()]
        assert rows[0][place] == "adversary"
        assert rows[1][place : place + 2] == ["delivery", "van"]
    assert "hit or" not in render(search_view(program, report, "", width), width)


def test_the_title_of_a_case(program: Program) -> None:
    """A case that a search wrote is called by the searched file; what merely has a number for a name keeps it."""
    text = "# case 3 of a search in some/left_turn.scn: risk 22\nego = new Car on road\n"
    assert title_of(replace(program, name="03", source_text=text)).plain.startswith("left_turn, case 3  ")
    assert name_of(replace(program, name="mine", source_text=text)) == "mine"
    assert name_of(replace(program, name="03", source_text="ego = new Car on road\n")) == "03"


PAIR_FIELDS = (
    "min_distance",
    "min_distance_time",
    "max_closing_speed",
    "max_closing_time",
    "distance_at_ms",
    "ttc_at_ms",
)


@pytest.mark.parametrize("width", WIDTHS)
def test_further_pairs_have_a_line_each(outcomes: Outcomes, width: int) -> None:
    """The deciding pair has the metrics; the other pairs are listed, the nearest first."""
    one = {name: getattr(outcomes, name) for name in PAIR_FIELDS}
    fields = {name: np.hstack([value, np.full((1, 1), np.inf), value + 1.0]) for name, value in one.items()}
    actors = ("ego", "adversary", "ghost", "walker")
    view = parts(further_pairs(replace(outcomes, **fields), actors, 0, KM_H), width)
    text = render(view, width)
    assert_fits(text, width)
    words = " ".join(text.split())
    assert words.startswith("Further pairs ego and … MD MS D_MS TTC_MS")
    assert words.endswith("walker 3.31 m at 4.10 s 75.0 km/h 39.20 m 2.92 s ghost never met")
    assert further_pairs(outcomes, actors[:2], 0, KM_H) == []


def test_a_contact_that_is_no_failure_of_the_ego_says_so(program: Program, collision: Outcomes) -> None:
    """A story that blames nobody wrongly."""
    assert end_of(program, collision, 0).text == "contact: ego and adversary"
    struck = replace(collision, fault=np.array([[Fault.STRUCK_FROM_BEHIND]], dtype=np.int32))
    assert end_of(program, struck, 0).text.endswith("; ego was struck from behind, which is not its failure")


def test_held_params_stay_in_the_table(run: RunReport) -> None:
    """With their unit, and marked."""
    held = (FixedParam("TRUCK_SPEED", 200.0, "km/h"), FixedParam("LANE", "network.lanes[0]"))
    words = " ".join(render(run_view(replace(run, held=held), 80), 80).split())
    assert "TRUCK_SPEED 200 km/h held" in words
    assert "LANE network.lanes[0] held" in words
    assert run_content(replace(run, held=held), "f.scn")["held"]["TRUCK_SPEED"] == {"value": 200.0, "unit": "km/h"}


def test_signs_that_are_no_numbers_are_explained() -> None:
    """Under the measures, those that are there: without end is harmless of a time, and hopeless of what is needed."""

    def shown(*values: tuple[str, float, str]) -> str:
        metrics = [Metric(name, (0, 1), value, unit, "a meaning") for name, value, unit in values]
        return " ".join(render(parts(measures_blocks(metrics, ("ego", "other"), 0), 120), 120).split())

    assert shown(("THW", np.inf, "s")).endswith("∞: no such conflict")
    needs = shown(("a_req", np.inf, "m/s^2"), ("BTN", np.inf, ""), ("TTB", -np.inf, "s"), ("PET", np.nan, "s"))
    assert "no such conflict" not in needs
    assert "∞ of a_req, BTN: no value is enough; -∞: too late for it; –: does not apply here" in needs
    assert "∞" not in shown(("TTC", 1.0, "s"))

"""`cortexc study`: a plan from a command line, its tables, and going on after whatever happened."""

import csv
import json
import os
import shutil
import signal
import sqlite3
import subprocess
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from cortex_dsl import load
from cortex_dsl.console.terminal import Exit
from engine.paper import INDIVIDUALS, RANDOM, SCENARIOS
from engine.study.database import read_study
from tests.fork_server import Ended, ForkServer, Running
from tests.journals import reseal
from tests.runs import STUDY, said_of

ROOT = Path(__file__).parents[3]
TINY = tuple(map(str, STUDY))


def contents(folder: Path) -> list[tuple]:
    """Every row that a plan decides."""
    with sqlite3.connect(folder / "study.sqlite") as connection:
        return [
            row
            for table in ("run", "evaluations")
            for row in connection.execute(f"SELECT * FROM {table} ORDER BY 1, 2, 3")
        ]


def test_a_study_is_shown_and_kept(small_study: Path) -> None:
    """Both methods, all eight measures, the verdict with its caution, and the files."""
    out = said_of(small_study)
    assert "ga against random: avoidable undecided" in out
    assert "with 2 runs of each this is at most a hint" in out
    for measure in ("avoidable kinds", "colliding genomes", "kinds", "RL", "NC", "MDG", "MDEC", "NIS"):
        assert f"\n  {measure}" in out
    names = {path.name for path in small_study.iterdir()}
    assert {"study.sqlite", "programs", "runs.csv", "generations.csv", "tests.csv", "summary.json"} <= names
    assert all(len(line) <= 100 for line in out.splitlines())


def test_a_number_that_does_not_exist_is_a_mistake_of_the_file(cortexc: Callable[..., Any], tmp_path: Path) -> None:
    """An expectation that is NaN in some runs fails them: that is no bug of ours, and is told with where to look."""
    file = tmp_path / "root.scn"
    file.write_text(
        "map intersection()\nparam V = Range(5, 15) m/s\n"
        "ego = new Car in network.lanes[0].centerline, with speed V\n"
        'expect always sqrt((ego.speed - 10 m/s) / (1 m/s)) < 9 as "root"\nterminate after 1 s\n'
    )
    result = cortexc("study", file, "--methods", "random", *TINY, "--objective", "root", "--out", tmp_path / "s")
    assert result.code == Exit.DIAGNOSTICS
    assert "has a mistake" in result.said
    assert "--random` shows it" in result.said
    unknown = cortexc("study", file, *TINY, "--objective", "rood", "--out", tmp_path / "t")
    assert "did you mean `root`?" in unknown.said


def test_what_the_last_ten_of_three_are(small_study: Path) -> None:
    """All of them, and it says so; the table has over how many generations each measure counts."""
    assert "NIS, all 3" in said_of(small_study)
    assert "NIS, last 10" not in said_of(small_study)
    rows = list(csv.DictReader((small_study / "tests.csv").read_text().splitlines()))
    assert {row["generations"] for row in rows} == {"3"}
    assert all(float(row["a12_high"]) - float(row["a12_low"]) > 0.2 for row in rows if row["a12_low"])


def test_a_folder_is_its_scenarios(cortexc: Callable[..., Any], left_turn: Path, tmp_path: Path) -> None:
    """In order of name, other files left out; an empty one is refused."""
    (tmp_path / "files").mkdir()
    for name in ("b.scn", "a.scn", "c.txt"):
        (tmp_path / "files" / name).write_text(left_turn.read_text())
    small = ("--runs", 1, "--generations", 1, "--population", 4, "--jobs", 1)
    document = cortexc("study", tmp_path / "files", *small, "--out", tmp_path / "s", "--json").document
    assert [row["name"] for row in document["scenarios"]] == ["a", "b"]
    (tmp_path / "none").mkdir()
    result = cortexc("study", tmp_path / "none")
    assert result.code == Exit.USAGE
    assert "no scenario" in result.said


def test_runs_on_a_cluster_are_the_same(
    cortexc: Callable[..., Any], left_turn: Path, small_study: Path, tmp_path: Path
) -> None:
    """Bit for bit, begun and gone on with."""
    pytest.importorskip("distributed")
    assert (
        cortexc("study", left_turn, *TINY[:-2], "--jobs", 2, "--dask", "local", "--out", tmp_path / "there").code == 0
    )
    assert contents(tmp_path / "there") == contents(small_study)
    with closing(sqlite3.connect(tmp_path / "there" / "study.sqlite")) as connection, connection:
        for table in ("run", "evaluations", "pace"):
            connection.execute(f"DELETE FROM {table} WHERE run = 1")
        reseal(connection)
    assert cortexc("resume", tmp_path / "there", "--jobs", 1, "--dask", "local").code == 0
    assert contents(tmp_path / "there") == contents(small_study)


def test_a_scheduler_that_is_not_there(cortexc: Callable[..., Any], left_turn: Path, tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    result = cortexc("study", left_turn, *TINY, "--dask", "nowhere", "--out", tmp_path / "s")
    assert result.code == Exit.USAGE
    assert "no Dask scheduler at `nowhere`" in result.said


def test_json_is_one_document(cortexc: Callable[..., Any], left_turn: Path, tmp_path: Path) -> None:
    """With every test of the study, and nothing else on stdout."""
    result = cortexc("study", left_turn, *TINY, "--out", tmp_path / "s", "--json")
    document = result.document
    assert document["schema"] == "cortexc/study"
    assert document["runs_finished"] == 4
    assert document["complete"] is True
    assert {row["measure"] for row in document["tests"]} >= {"colliding genomes", "RL"}


def test_three_methods_stand_under_one_another(cortexc: Callable[..., Any], left_turn: Path, tmp_path: Path) -> None:
    """The baseline first, whatever the order of the list."""
    result = cortexc("study", left_turn, *TINY, "--methods", "ga,niching,random", "--out", tmp_path / "s")
    assert result.code == Exit.FINE
    block = result.out.split("How this is decided")[0].split("colliding genomes")[-1]
    assert [word for word in block.split() if word in ("random", "ga", "niching")][:3] == ["random", "ga", "niching"]


def test_without_files_the_six_are_named(cortexc: Callable[..., Any], tmp_path: Path) -> None:
    """And stand beside the paper only with its budget."""
    result = cortexc("study", "--runs", 1, "--generations", 1, "--population", 4, "--jobs", 1, "--out", tmp_path / "s")
    assert "no FILES: the paper's six scenarios" in result.said
    assert "three_way_left" in result.out
    assert "Compared with the paper" not in result.out


def test_as_paper_sets_what_is_not_given(cortexc: Callable[..., Any], tmp_path: Path) -> None:
    """The paper's preset, one run and the files under `paper`; what is given holds."""
    small = ("--generations", 1, "--population", 4, "--jobs", 1, "--json")
    first = json.loads(cortexc("study", "--as-paper", *small, "--out", tmp_path / "a").out)
    assert first["runs"] == 1
    assert [Path(each["file"]).parent.name for each in first["scenarios"]] == ["paper"] * 6
    plan = read_study(tmp_path / "a").plan
    assert [subject.name for subject in plan.subjects] == list(SCENARIOS)
    assert {subject.config.ga.preset for subject in plan.subjects} == {"cortex-literal"}
    words = (
        "study",
        ROOT / "examples" / "left_turn.scn",
        "--as-paper",
        "--runs",
        2,
        "--preset",
        "cortex",
        *small,
        "--out",
        tmp_path / "b",
    )
    assert json.loads(cortexc(*words).out)["runs"] == 2
    plan = read_study(tmp_path / "b").plan
    assert [(subject.name, subject.config.ga.preset) for subject in plan.subjects] == [("left_turn", "cortex")]


@pytest.mark.parametrize("letter", SCENARIOS)
def test_random_search_has_as_many_invalid_runs_as_in_the_paper(letter: str) -> None:
    """Of the files whose validity couples params: within 2 percent of all individuals."""
    scenario = load(ROOT / "examples" / "paper" / f"{letter}.scn")
    found = scenario.search("random", generations=2, population=INDIVIDUALS)
    printed = RANDOM.nis[SCENARIOS.index(letter)] / INDIVIDUALS
    assert found.by_individual.nis / (2 * INDIVIDUALS) == pytest.approx(printed, abs=0.02)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--methods", "gaa"), "did you mean `ga`"),
        (("--runs", "0"), "at least 1"),
        (("--resume", "nowhere"), "no study"),
        (("--resume", "x", "--runs", "3"), "--runs has no effect with --resume"),
        (("--rnus", "3"), "did you mean `--runs`"),
        (("--runs", "60000", "--population", "100000"), "more than 1,000,000,000"),
    ],
)
def test_slips_are_answered(
    cortexc: Callable[..., Any], left_turn: Path, arguments: tuple[str, ...], said: str
) -> None:
    """Each with what is wrong."""
    files = () if "--resume" in arguments else (left_turn,)
    result = cortexc("study", *files, *arguments)
    assert result.code == Exit.USAGE
    assert said in result.said


def test_a_file_with_errors_ends_it_before_anything_is_written(
    cortexc: Callable[..., Any], scenario: Callable[..., Path], tmp_path: Path
) -> None:
    """With the compiler's own words."""
    result = cortexc("study", scenario("EGO_BRAKE", "EGO_BRAK€"), *TINY, "--out", tmp_path / "s")
    assert result.code == Exit.DIAGNOSTICS
    assert not (tmp_path / "s").exists()


def test_a_folder_that_is_taken_is_refused(
    cortexc: Callable[..., Any], left_turn: Path, small_study: Path, tmp_path: Path
) -> None:
    """A study is never overwritten."""
    shutil.copytree(small_study, tmp_path / "s")
    again = cortexc("study", left_turn, *TINY, "--out", tmp_path / "s")
    assert again.code == Exit.USAGE
    assert "not empty" in again.said or "already" in again.said


def test_a_complete_study_is_shown_again(cortexc: Callable[..., Any], left_turn: Path, tmp_path: Path) -> None:
    """By --resume, without running anything."""
    first = cortexc("study", left_turn, *TINY, "--out", tmp_path / "s")
    before = contents(tmp_path / "s")
    again = cortexc("study", "--resume", tmp_path / "s")
    assert again.out == first.out
    assert contents(tmp_path / "s") == before


def test_resume_knows_a_study_when_it_sees_one(cortexc: Callable[..., Any], left_turn: Path, tmp_path: Path) -> None:
    """One command goes on with whatever a folder holds."""
    first = cortexc("study", left_turn, *TINY, "--out", tmp_path / "s")
    assert cortexc("resume", tmp_path / "s").out == first.out
    assert "no effect on a study" in cortexc("resume", tmp_path / "s", "--generations", 9).err


def test_an_edited_file_is_said_and_passed_over(
    cortexc: Callable[..., Any], scenario: Callable[..., Path], tmp_path: Path
) -> None:
    """The study goes on with the program that it keeps."""
    file = scenario()
    first = cortexc("study", file, *TINY, "--out", tmp_path / "s")
    file.write_text("ego = nothing that compiles")
    again = cortexc("study", "--resume", tmp_path / "s")
    assert "was edited since" in again.said
    assert again.out == first.out


@pytest.mark.parametrize("width", [60, 80, 120])
def test_tables_fit_the_terminal(
    cortexc: Callable[..., Any], small_study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, width: int
) -> None:
    """Nothing is cut off where there is less room: columns go, and words wrap."""
    shutil.copytree(small_study, tmp_path / "s")
    monkeypatch.setenv("COLUMNS", str(width))
    result = cortexc("study", "--resume", tmp_path / "s")
    assert result.code == Exit.FINE
    assert all(len(line) <= min(width, 100) for line in result.out.splitlines())
    assert "…" not in result.out


def test_a_folder_that_cannot_be_written_is_reported(
    cortexc: Callable[..., Any], left_turn: Path, tmp_path: Path
) -> None:
    """A file where a folder should be."""
    (tmp_path / "file").write_text("")
    result = cortexc("study", left_turn, *TINY, "--out", tmp_path / "file" / "s")
    assert result.code == Exit.USAGE
    assert "help:" in result.said


def test_another_engine_may_not_go_on(cortexc: Callable[..., Any], small_study: Path, tmp_path: Path) -> None:
    """Its runs would be compared as if they were of one."""
    shutil.copytree(small_study, tmp_path / "s")
    with sqlite3.connect(tmp_path / "s" / "study.sqlite") as connection:
        connection.execute("UPDATE manifest SET value = '\"older\"' WHERE field = 'engine'")
        for table in ("run", "evaluations", "pace"):
            connection.execute(f"DELETE FROM {table} WHERE run = 1")
        reseal(connection)
    result = cortexc("study", "--resume", tmp_path / "s")
    assert result.code == Exit.USAGE
    assert "another version of the engine" in result.said


HALTING = """
from engine.study.database import StudyStore

number, left = int(sys.argv[1]), int(sys.argv[2])
write = StudyStore.write

def halting(store, finished):
    global left
    write(store, finished)
    left -= 1
    if left == 0:
        os.kill(os.getpid(), number)

StudyStore.write = halting
sys.argv[1:] = sys.argv[3:]
sys.exit(process())
"""
"""A command that sends itself a signal once the n-th run of its study is written."""
PATIENCE = 300
"""Seconds that a process may take to end, however busy the machine is."""


def start(server: ForkServer, folder: Path, left_turn: Path, jobs: int, *, number: int = 0, after: int = 0) -> Running:
    """A study in a session of its own, which sends itself a signal when `after` of its runs are written."""
    words = ["study", left_turn, "--runs", 6, "--generations", 6, "--population", 20, "--jobs", jobs, "--out", folder]
    return server.start(HALTING, number, after, *words, alone=True)


def over(process: Running) -> Ended:
    """What a study left, once all of its processes have ended by themselves."""
    deadline = time.monotonic() + PATIENCE
    while children(process.pid):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    return process.end()


def finished_runs(folder: Path) -> int:
    try:
        with closing(sqlite3.connect(f"file:{folder / 'study.sqlite'}?mode=ro", uri=True)) as connection:
            return connection.execute("SELECT count(*) FROM run").fetchone()[0]
    except sqlite3.Error:
        return 0


@pytest.fixture(scope="module")
def undisturbed(command_server: ForkServer, left_turn: Path, tmp_path_factory: pytest.TempPathFactory) -> list[tuple]:
    folder = tmp_path_factory.mktemp("undisturbed") / "s"
    assert start(command_server, folder, left_turn, 1).end().status == Exit.FINE
    return contents(folder)


def children(group: int) -> list[int]:
    """Processes of a group that live."""
    found = subprocess.run(["pgrep", "-g", str(group)], capture_output=True, text=True, check=False)
    return [int(word) for word in found.stdout.split()]


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="signals of POSIX")
@pytest.mark.parametrize(("jobs", "after"), [(1, 1), (1, 4), (2, 2), (2, 5)])
def test_a_killed_study_goes_on_to_the_same_rows(
    cortexc: Callable[..., Any],
    command_server: ForkServer,
    undisturbed: list[tuple],
    left_turn: Path,
    tmp_path: Path,
    jobs: int,
    after: int,
) -> None:
    """SIGKILL of the command alone: what was finished is there, its workers end by themselves."""
    folder = tmp_path / "s"
    process = start(command_server, folder, left_turn, jobs, number=signal.SIGKILL, after=after)
    assert process.end().status == -signal.SIGKILL
    assert finished_runs(folder) == after
    result = cortexc("study", "--resume", folder, "--jobs", 1)
    assert result.code == Exit.FINE
    assert contents(folder) == undisturbed
    deadline = time.monotonic() + PATIENCE
    while children(process.pid):
        assert time.monotonic() < deadline
        time.sleep(0.05)


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="signals of POSIX")
@pytest.mark.parametrize(
    ("jobs", "how", "code"), [(1, signal.SIGINT, 130), (2, signal.SIGINT, 130), (2, signal.SIGTERM, 143)]
)
def test_a_study_that_is_stopped_keeps_what_is_finished_and_says_how_to_go_on(
    cortexc: Callable[..., Any],
    command_server: ForkServer,
    undisturbed: list[tuple],
    left_turn: Path,
    tmp_path: Path,
    jobs: int,
    how: signal.Signals,
    code: int,
) -> None:
    """Ctrl-C goes to the whole group, as from a terminal, SIGTERM to the command; nobody complains with a traceback."""
    folder = tmp_path / "s"
    process = start(command_server, folder, left_turn, jobs, number=signal.SIGSTOP, after=2)
    process.wait_until_stopped()
    (os.killpg if how == signal.SIGINT else os.kill)(process.pid, how)
    os.killpg(process.pid, signal.SIGCONT)
    ended = over(process)
    assert ended.status == code
    assert "continue with: cortexc study --resume" in ended.err
    assert "Traceback" not in ended.err
    assert "leaked" not in ended.err
    assert 2 <= finished_runs(folder) < 12
    assert cortexc("report", folder).code == Exit.FINE
    resumed = cortexc("study", "--resume", folder, "--jobs", 1)
    assert resumed.code == Exit.FINE
    assert f"earlier state of the journal; `cortexc report {folder}` writes the page again" in resumed.said
    assert contents(folder) == undisturbed


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="signals of POSIX")
def test_one_process_at_a_time(
    cortexc: Callable[..., Any], command_server: ForkServer, left_turn: Path, tmp_path: Path
) -> None:
    """A study that is being written is left alone."""
    folder = tmp_path / "s"
    process = start(command_server, folder, left_turn, 1, number=signal.SIGSTOP, after=1)
    process.wait_until_stopped()
    result = cortexc("study", "--resume", folder, "--jobs", 1)
    os.kill(process.pid, signal.SIGKILL)
    process.end()
    assert result.code == Exit.USAGE
    assert "another process" in result.said

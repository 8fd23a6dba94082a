"""`--method`: every way to search by its name, several side by side, and what is said of a wrong name."""

from collections.abc import Callable
from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import pytest

from cortex_dsl import load, open_run
from cortex_dsl.report.findings.search_report import method_name, method_style
from engine.extras import installing
from engine.search.methods.table import SEARCHERS
from engine.streams import method_number
from engine.study.database import read_evaluations, read_study
from engine.study.plan import Address

Command = Callable[..., Any]
pytestmark = pytest.mark.usefixtures("small_design")
SMALL = ("--generations", 3, "--population", 12, "--jobs", 1)


def test_the_list(cortexc: Command) -> None:
    """One line each, without a file."""
    result = cortexc("--method", "list")
    assert result.code == 0
    assert len(result.out.splitlines()) == len(SEARCHERS)
    assert all(name in result.out for name in SEARCHERS)


SHORT = ("--generations", 2, "--population", 6, "--json")


def test_search_is_the_sum_of_its_parts(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """Method, objective and held params; a value of `-p` stays."""
    words = "--method", "failure_kinds", "--objective", "avoidable", "--freeze"
    one = cortexc(left_turn, "--search", "-p", "EGO_BRAKE=1", *SHORT, "--out", tmp_path / "a")
    other = cortexc(left_turn, *words, "-p", "EGO_BRAKE=1", *SHORT, "--out", tmp_path / "b")
    assert one.code == other.code == 0
    assert "held: EGO_BRAKE=1, SAFETY_DIST=10 m, CRASH_DIST=2.5 m; `-p` sets others" in one.said
    tables = [(tmp_path / name / "evaluations.csv").read_bytes() for name in "ab"]
    assert tables[0] == tables[1]


def test_parts_of_search_that_are_given_hold(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    chosen = cortexc(
        left_turn, "--search", "--ga", "--objective", "conflict", *SHORT, "--out", tmp_path / "run"
    ).document
    assert [each["method"] for each in chosen["searches"]] == ["ga", "failure_kinds"]
    aims = [open_run(tmp_path / "run" / method).record.manifest.objective for method in ("ga", "failure_kinds")]
    assert aims == [("conflict",)] * 2


def test_search_of_a_file_that_names_no_system(cortexc: Command, scenario: Command, tmp_path: Path) -> None:
    """It holds nothing; `--freeze` by itself would have nothing to do there."""
    file = scenario("simulation(system=[EGO_BRAKE, SAFETY_DIST, CRASH_DIST])", "")
    found = cortexc(file, "--search", *SHORT, "--out", tmp_path / "run")
    assert found.code == 0
    assert "held" not in found.said
    assert cortexc(file, "--ga", "--freeze", *SHORT).code == 2


def test_a_row_is_all_that_a_method_needs(
    cortexc: Command, left_turn: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A new one of ours is listed, searches under numbers of its own, is replayed, studied and coloured by its row."""
    row = replace(
        SEARCHERS["cross_entropy"],
        name="strolls",
        title="Sunday strolls",
        summary="walks",
        alias="st",
        style="bright_red",
    )
    monkeypatch.setitem(SEARCHERS, "strolls", row)
    assert "strolls (st)" in cortexc("--method", "list").out
    assert (method_style("strolls"), method_name("strolls")) == ("bright_red", "Sunday strolls")
    assert cortexc(left_turn, "--method", "st", *SMALL, "--out", tmp_path / "run").code == 0
    run = open_run(tmp_path / "run")
    assert set(run.record.evaluations.keys[..., 1].flat) == {method_number("strolls")}
    worst = run.record.evaluations.score.max()
    assert cortexc(tmp_path / "run" / "worst" / "01.scn", "--json").document["risk"]["score"] == worst
    assert cortexc("report", tmp_path / "run", "--out", tmp_path / "page.html").code == 0
    few = ("--methods", "strolls,random", "--runs", 2, *SMALL, "--out", tmp_path / "study")
    study = cortexc("study", left_turn, *few)
    assert study.code == 0
    assert "strolls" in study.out
    assert "Sunday strolls" in (tmp_path / "page.html").read_text(encoding="utf-8")
    read = read_study(tmp_path / "study")
    keys = read_evaluations(read, Address(0, "strolls", 1)).keys
    assert set(keys[..., 1].flat) == {method_number("strolls")}


@pytest.mark.parametrize("name", ["annealing", "Annealing", "sa"])
def test_a_removed_method_names_another(cortexc: Command, left_turn: Path, name: str) -> None:
    """The refusal of a method that was removed names the method to use."""
    refused = cortexc(left_turn, "--method", name)
    assert refused.code == 2
    assert f"method: `{name}` was removed" in refused.said
    assert "use `ga`" in refused.said


def test_several_side_by_side(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """One table for all; each in a directory of its own, each once."""
    result = cortexc(left_turn, "--ga", "--method", "ce,lhs,ga", *SMALL, "--out", tmp_path / "all")
    assert result.code == 0
    assert "Side by side" in result.out
    assert sorted(path.name for path in (tmp_path / "all").iterdir()) == ["cross_entropy", "ga", "lhs"]
    document = cortexc(left_turn, "--method", "sobol", *SMALL, "--out", tmp_path / "one", "--json").document
    assert [search["method"] for search in document["searches"]] == ["sobol"]


@pytest.mark.parametrize("name", [name for name in SEARCHERS if name not in ("ga", "random")])
def test_every_method_runs_to_its_report(cortexc: Command, left_turn: Path, tmp_path: Path, name: str) -> None:
    """And its journal opens again."""
    result = cortexc(left_turn, "--method", name, *SMALL, "--out", tmp_path / "run")
    assert result.code == 0
    assert "36 runs in" in result.out
    run = open_run(tmp_path / "run")
    assert (run.record.manifest.method, run.record.status, run.edited) == (name, "finished", ())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--method", "nichng"], "did you mean `niching`?"),
        (["--method", "niching,xyzzy"], "`cortexc --method list` lists them all"),
        (["--method", "niching", "--check"], "--method and --check ask for different things"),
        (["--method", "niching", "--preset", "cortex"], "--preset has no effect without the genetic algorithm"),
        (["--dask", "local"], "--dask has no effect on a single run"),
        (["--method", "lhs", "--dask", "nowhere"], "there is no Dask scheduler at `nowhere`"),
    ],
)
def test_slips(cortexc: Command, left_turn: Path, tmp_path: Path, arguments: list[str], message: str) -> None:
    """Said with a cure, and 2."""
    out = ("--out", tmp_path / "run") if "--dask" in arguments and "--method" in arguments else ()
    result = cortexc(left_turn, *arguments, *out)
    assert result.code == 2
    assert message in result.said


def test_a_package_that_is_missing(cortexc: Command, left_turn: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The line that installs it, before anything is made."""
    monkeypatch.setitem(__import__("sys").modules, "cma", None)
    result = cortexc(left_turn, "--method", "cmaes", "--out", "never")
    assert result.code == 2
    assert installing("search") in result.said
    assert not Path("never").exists()


def test_a_broken_searcher_of_another_package(
    cortexc: Command, left_turn: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its fault is reported as its own, not as a bug of ours."""
    point = EntryPoint("shaky", "nowhere.at.all:make", "cortexc.searchers")
    monkeypatch.setattr("engine.search.searchers.entry_points", lambda **_: [point])
    result = cortexc(left_turn, "--method", "shaky", "--out", "never")
    assert result.code == 2
    assert "the searcher `shaky` cannot be loaded" in result.said


def test_from_python(tmp_path: Path, left_turn: Path) -> None:
    """`search(out=…)` keeps what it finds; `resume` goes on with it; both are what a longer search gives."""
    from cortex_dsl import resume

    scenario = load(left_turn, EGO_SPEED="50 km/h")
    short = scenario.search("de", generations=2, population=10, seed=3, out=tmp_path / "run")
    found = resume(tmp_path / "run", generations=4)
    whole = scenario.search("de", generations=4, population=10, seed=3)
    assert len(short.generations) == 2
    assert found.campaign.evaluations.genomes.tobytes() == whole.evaluations.genomes.tobytes()
    assert open_run(tmp_path / "run" / "journal.sqlite").scenario.overrides == {"EGO_SPEED": "50 km/h"}
    assert all(path.exists() for path in found.worst_files)

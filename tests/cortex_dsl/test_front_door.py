"""`import cortex_dsl as cx`: what there is, that it costs nothing until it is used, and that each of it works."""

import ast
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from inspect import Parameter, signature
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cortex_dsl as cx
from cortex_dsl import Scenario
from cortex_dsl.api.arguments import SearchSettings, StudySettings, WritingSettings
from cortex_dsl.api.runs import OpenedRun
from cortex_dsl.api.studies import Studied, resume_study, study
from cortex_dsl.version import VERSION
from engine.config import ContactConfig, GAConfig, SearchConfig, SimulationConfig
from engine.study.execution import perform_all
from engine.study.run_records import Finished

EXAMPLES = Path(__file__).parents[2] / "examples"
EXAMPLE = EXAMPLES / "left_turn.scn"
HEAVY = {"numpy", "numba", "scipy", "lark", "rich", "pymunk", "cortex_dsl.api", "engine.kernels"}
SMALL: dict[str, Any] = {"generations": 2, "population": 10}


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return cx.load(EXAMPLE)


@pytest.fixture(scope="module")
def run(scenario: Scenario, tmp_path_factory: pytest.TempPathFactory) -> OpenedRun:
    """A small search that was kept."""
    folder = tmp_path_factory.mktemp("front") / "run"
    cx.search(scenario, "random", generations=2, population=20, out=folder)
    return cx.open_run(folder)


# -- what there is ----------------------------------------------------------------------------------------------------


def test_names_are_listed_and_there() -> None:
    """For `dir`, for completion and for a star."""
    assert set(cx.__all__) <= set(dir(cx))
    assert all(hasattr(cx, name) for name in cx.__all__)
    assert cx.__version__ == VERSION
    with pytest.raises(AttributeError, match="has no attribute 'lod'"):
        cx.lod  # type: ignore[attr-defined]  # noqa: B018 - looked up for what it raises


def test_type_checkers_see_what_there_is() -> None:
    """The imports that only they read name the same homes as the table."""
    tree = ast.parse(Path(cx.__file__).read_text(encoding="utf-8"))
    seen = {
        name.name: node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) for name in node.names
    }
    assert {name: seen[name] for name in cx._HOMES} == cx._HOMES
    assert set(cx.__all__) == {*cx._HOMES, "CortexError", "__version__"}
    assert (Path(cx.__file__).parent / "py.typed").is_file()
    assert (Path(cx.__file__).parents[1] / "engine" / "py.typed").is_file()


def test_nothing_heavy_before_it_is_used() -> None:
    """The import alone, the version and the exceptions cost next to nothing."""
    code = "import sys, cortex_dsl as cx; cx.__version__; cx.CortexError; dir(cx); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=300)
    assert not HEAVY & set(done.stdout.split())


# -- that it works ----------------------------------------------------------------------------------------------------


def test_a_search_is_that_of_the_scenario(scenario: Scenario) -> None:
    """From a path or from what was loaded."""
    first, second = cx.search(EXAMPLE, "random", **SMALL), scenario.search("random", **SMALL)
    np.testing.assert_array_equal(first.evaluations.fitness, second.evaluations.fitness)


KEYWORDS: dict[str, tuple[Callable[..., Any], type, Callable[..., Any]]] = {
    "search": (cx.search, SearchSettings, lambda s, **more: cx.search(s, "random", **more)),
    "Scenario.search": (Scenario.search, SearchSettings, lambda s, **more: s.search("random", **more)),
    "study": (cx.study, StudySettings, lambda s, **more: cx.study(s, "random", 1, **more)),
    "export": (cx.export, WritingSettings, lambda s, **more: cx.export(s, "csv", "none", **more)),
}


@pytest.mark.parametrize("name", KEYWORDS)
def test_every_keyword_is_shown_and_a_slip_is_answered_with_it(name: str, scenario: Scenario) -> None:
    """`help` and completions list the keywords that a function passes on; a keyword with a slip names the right one."""
    function, settings, call = KEYWORDS[name]
    shown = signature(function).parameters
    for keyword in settings.__annotations__:
        assert shown[keyword].kind is Parameter.KEYWORD_ONLY
        assert name == "search" or f"{keyword}:" in str(function.__doc__) or f"{keyword}," in str(function.__doc__)
        with pytest.raises(TypeError, match=f"no setting `{keyword}_`.*did you mean `{keyword}`"):
            call(scenario, **{f"{keyword}_": None})


def test_defaults_shown_are_those_in_force(scenario: Scenario) -> None:
    """A search with all keywords at the defaults of the signature is the search without them."""
    plain = {
        keyword: parameter.default
        for keyword, parameter in signature(cx.search).parameters.items()
        if keyword in SearchSettings.__annotations__
    }
    first, second = cx.search(EXAMPLE, "ga", **SMALL), cx.search(EXAMPLE, "ga", **plain | SMALL)
    assert (first.config, first.preset) == (second.config, second.preset)
    np.testing.assert_array_equal(first.evaluations.fitness, second.evaluations.fitness)


def test_a_run_is_gone_on_with(run: OpenedRun) -> None:
    """To as many generations as are asked for."""
    found = cx.resume(run.folder, generations=3)
    assert len(found.campaign.evaluations) == 60
    assert cx.open_run(run.folder).record.status == "finished"


def test_cases_are_exported_and_measured(run: OpenedRun, tmp_path: Path) -> None:
    """The paths of all files; what is read back has the outcome that the run had."""
    paths = cx.export(run, ["csv", "xosc"], tmp_path / "out")
    assert sorted(path.name for path in paths) == [
        "left_turn-case01.csv",
        "left_turn-case01.xosc",
        "left_turn.xodr",
    ]
    assert all(path.is_file() for path in paths)
    for name in ("left_turn-case01.csv", "left_turn-case01.xosc"):
        measured = cx.measure(tmp_path / "out" / name)
        assert measured.risk.score[0] == np.nanmax(run.record.evaluations.fitness)
    assert cx.export(run, "csv", tmp_path / "out") == [tmp_path / "out" / "left_turn-case01.csv"]
    assert len(cx.export(run, "scn", tmp_path / "top", top=2)) == 2


def test_a_scene_is_exported(scenario: Scenario, tmp_path: Path) -> None:
    """That of a seed, as the command writes it."""
    (path,) = cx.export(scenario, "scn", tmp_path, seed=3)
    assert path.name == "left_turn-seed3.scn"
    again = cx.load(path)
    np.testing.assert_array_equal(again.scene_of_seed().keys, scenario.scene_of_seed(3).keys)
    path.write_text("ego = new Car\n")
    with pytest.raises(cx.CortexError, match="holds something else") as caught:
        cx.export(scenario, "scn", tmp_path, seed=3)
    assert "force" in caught.value.cure
    assert cx.export(scenario, "scn", tmp_path, seed=3, force=True) == [path]


def test_a_study_in_memory(scenario: Scenario) -> None:
    """Every run is passed to `on_run`, and compared."""
    heard: list[Finished] = []
    done = cx.study([scenario], ["random", "ga"], 2, on_run=heard.append, **SMALL)
    assert done.complete
    assert len(heard) == len(done.records) == 4
    assert {row.method for row in done.findings.comparisons} == {"ga"}
    assert done.folder is None
    assert repr(done) == "Studied(1 scenario x random, ga x 2 runs; 4 finished)"


def test_a_study_that_is_kept_and_gone_on_with(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A study that was stopped by Ctrl-C ends as if nothing had happened; two files of one name get different names."""
    whole = cx.study(EXAMPLES / "left_turn.scn", "random", 3, out=tmp_path / "whole", **SMALL)
    assert (tmp_path / "whole" / "runs.csv").is_file()

    def stop(_: Finished) -> None:
        raise KeyboardInterrupt

    half = study(EXAMPLES / "left_turn.scn", "random", 3, out=tmp_path / "half", on_run=stop, **SMALL)
    assert not half.complete
    assert len(half.records) == 1
    monkeypatch.setattr("cortex_dsl.api.studies.perform_all", perform_all)
    rest = resume_study(tmp_path / "half")
    assert isinstance(rest, Studied)
    assert [record.figures.simulations for record in rest.records] == [r.figures.simulations for r in whole.records]
    assert resume_study(tmp_path / "half").complete


def test_notebooks_have_something_to_show(scenario: Scenario, run: OpenedRun) -> None:
    """Whatever a cell may end with: a small table, without markup of the scenario's own."""
    scenes = scenario.sample(20, seed=2)
    outcomes, campaign = scenario.simulate(scenes), cx.search(scenario, "random", **SMALL)
    shown = [scenario, scenes, outcomes, campaign, scenario.table(scenes), scenario.table(outcomes), run]
    for thing in shown:
        text = thing._repr_html_()
        assert text.count("<table") == text.count("</table>") == 1
        assert len(text) < 20_000
    assert f"<td>{scenes.valid.sum()}</td>" in scenes._repr_html_()
    assert "20 rows" in scenario.table(scenes)._repr_html_()
    assert "<th>ego.speed [m/s]</th>" in scenario.table(scenes)._repr_html_()


def test_a_compile_error_shows_where() -> None:
    """The line of the source with its caret, errors before notes; a notebook has the same as markup."""
    with pytest.raises(cx.CompileError) as caught:
        cx.compile_text("ego = new Car at (0, 0), with sped 5\n", "mine.scn")
    shown = str(caught.value)
    assert "mine.scn:1:31: error[SCN204]: a Car has no property `sped`\n" in shown
    assert "1 | ego = new Car at (0, 0), with sped 5\n  |                               ^^^^\n" in shown
    assert shown.index("error[") < shown.index("note[")
    assert "\x1b" not in shown
    assert caught.value._repr_html_().startswith("<pre>")
    assert caught.value._render_traceback_() == shown.strip("\n").splitlines()
    assert (caught.value.message, caught.value.cure) == (
        "SCN204: a Car has no property `sped`",
        "did you mean `speed`?",
    )


def _with(scenario: Scenario, **parts: Any) -> Scenario:
    return replace(scenario, config=replace(scenario.config, **parts))


SLIPS: dict[str, tuple[Callable[[Scenario, OpenedRun], object], type[Exception], str]] = {
    "no file": (lambda s, r: cx.load("no.scn"), OSError, "cannot read `no.scn`: no such file"),
    "no path": (lambda s, r: cx.load(3), TypeError, "path: expected str or Path, got int"),  # type: ignore[arg-type]
    "no text": (lambda s, r: cx.compile_text(3), TypeError, "text: expected str, got int"),  # type: ignore[arg-type]
    "search what": (lambda s, r: cx.search(3), TypeError, "scenario: expected str or Path or Scenario"),  # type: ignore[arg-type]
    "method": (lambda s, r: cx.search(s, "gaa"), ValueError, "method: `gaa` is none of ga, random"),
    "preset": (lambda s, r: cx.search(s, preset="x"), ValueError, "preset: `x` is none of cortex"),
    "engine": (lambda s, r: cx.search(s, engine="x"), ValueError, "engine: expected batch or world, got `x`"),
    "aggregate": (lambda s, r: cx.search(s, aggregate="x"), ValueError, "aggregate: expected mean"),
    "profile": (lambda s, r: cx.search(s, profile="x"), ValueError, "profile: `x` is none of paper"),
    "nothing to study": (lambda s, r: cx.study([], "ga"), ValueError, "needs a scenario and a method"),
    "study what": (lambda s, r: cx.study(3), TypeError, "files: expected one name, or several in a list, got int"),  # type: ignore[arg-type]
    "runs": (lambda s, r: cx.study(s, "ga", 0), ValueError, "runs: expected 1 or more, got 0"),
    "study profile": (lambda s, r: cx.study(s, "ga", profile="x"), ValueError, "profile: expected one of paper"),
    "empty folder": (lambda s, r: cx.study(EXAMPLES.parent / ".ci"), ValueError, "there is no scenario"),
    "no run": (lambda s, r: cx.open_run("nothing"), Exception, "there is no folder `nothing`"),
    "format": (
        lambda s, r: cx.export(s, "xosk", "x"),
        ValueError,
        "expected one of xosc, xodr, .* got `xosk` .did you",
    ),
    "formats": (lambda s, r: cx.export(s, [], "x"), ValueError, "formats: expected one or more"),
    "export what": (lambda s, r: cx.export(3, "csv", "x"), TypeError, "what: expected OpenedRun or Scenario"),  # type: ignore[arg-type]
    "case": (lambda s, r: cx.export(r, "csv", "x", case=999), ValueError, "case: expected 1 to"),
    "seed of a run": (lambda s, r: cx.export(r, "csv", "x", seed=3), ValueError, "seed: it has no effect for a run"),
    "case of a scenario": (lambda s, r: cx.export(s, "csv", "x", case=1), ValueError, "case: it has no effect"),
    "top of a scenario": (lambda s, r: cx.export(s, "csv", "x", top=1), ValueError, "top: it has no effect"),
    "case and top": (lambda s, r: cx.export(r, "csv", "x", case=1, top=1), ValueError, "top: .* beside `case`"),
    "osc of a table": (lambda s, r: cx.export(s, "csv", "x", osc="1.0"), ValueError, "osc: .* without the format xosc"),
    "config": (lambda s, r: replace(s, config=3), TypeError, "config: expected Config, got int"),  # type: ignore[arg-type]
    "part of a config": (lambda s, r: _with(s, simulation=3), TypeError, "config.simulation: expected Simulation"),
    "count": (lambda s, r: _with(s, search=SearchConfig(jobs=1.5)), TypeError, "search.jobs: expected a whole number"),  # type: ignore[arg-type]
    "number": (
        lambda s, r: _with(s, simulation=SimulationConfig(time_step="x")),  # type: ignore[arg-type]
        TypeError,
        "config.simulation.time_step: expected a number, got 'x'",
    ),
    "no number": (lambda s, r: _with(s, contact=ContactConfig(friction=nan)), ValueError, "expected a finite number"),
    "word": (lambda s, r: _with(s, ga=GAConfig(preset=3)), TypeError, "config.ga.preset: expected str"),  # type: ignore[arg-type]
    "measure what": (lambda s, r: cx.measure("x.foo"), ValueError, "file: expected one that ends in .csv"),
    "measure nothing": (lambda s, r: cx.measure("x.csv"), Exception, "there is no such file"),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_slips_are_answered(scenario: Scenario, run: OpenedRun, slip: str) -> None:
    """By the name of what was given, what was expected and what was got; each is a CortexError with its cure."""
    ask, error, message = SLIPS[slip]
    with pytest.raises(error, match=message) as caught:
        ask(scenario, run)
    assert isinstance(caught.value, cx.CortexError)
    assert caught.value.cure

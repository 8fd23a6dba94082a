"""`cortexc report --audit`: each number is that of the tables, each missing one has a reason; bad input."""

import ast
import csv
import json
import re
import shutil
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cortex_dsl as cx
from cortex_dsl.api.audit_documents import audit_of_document, document_in, without_folders_of
from cortex_dsl.report.findings.audit_report import STEP_BIAS, Topic
from cortex_dsl.report.findings.suite_report import Outcome, answer_texts
from engine.errors import ArgumentError
from engine.gates.exposure import CellCount, exposed_rate, upper_bound
from engine.references import NAMES, verdicts
from engine.search.campaign import Progress
from engine.vocabulary import Answer, Blame
from tests import audit_again
from tests.audited import FOLLOWING, KINDS, audit
from tests.runs import LEFT_TURN

Run = Callable[..., Any]
ROOT = Path(__file__).parents[3]
EXAMPLES = sorted([*ROOT.glob("examples/**/*.scn"), *ROOT.glob("benchmarks/suite/*.scn")])


@pytest.fixture(scope="module")
def copy_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Return a copy of the results of a kind, with its sheet."""
    made: dict[str, Path] = {}

    def copy(kind: str) -> Path:
        if kind not in made:
            made[kind] = tmp_path_factory.mktemp("audit") / kind
            shutil.copytree(KINDS[kind](tmp_path_factory), made[kind])
            assert audit(made[kind]) == 0
        return made[kind]

    return copy


def document(folder: Path) -> Any:
    return json.loads((folder / "audit.json").read_text(encoding="utf-8"))


def documented() -> tuple[float, float]:
    """Return the bias of the time step as the table of the benchmarks has it."""
    text = (ROOT / "benchmarks" / "README.md").read_text(encoding="utf-8")
    found = re.search(r"\| `step_bias` .*?\+([\d.]+) to \+([\d.]+) %", text)
    assert found is not None
    return float(found[1]) / 100.0, float(found[2]) / 100.0


# -- numbers -----------------------------------------------------------------------------------------------------------


def test_the_script_that_computes_again_knows_nothing_of_the_project() -> None:
    """It imports the standard library and scipy only."""
    tree = ast.parse(Path(audit_again.__file__).read_text(encoding="utf-8"))
    names = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    names |= {str(node.module) for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert {name.partition(".")[0] for name in names} <= {*sys.stdlib_module_names, "scipy"}


@pytest.mark.parametrize("kind", KINDS)
def test_each_number_of_the_page_is_that_of_the_tables(copy_of: Callable[[str], Path], kind: str) -> None:
    """An independent script finds no difference, and every digest of the evidence is that of its file."""
    folder = copy_of(kind)
    assert audit_again.differences(folder, documented()) == []
    evidence = document(folder)["evidence"]
    assert evidence
    assert evidence == {name: audit_again.digest(folder / name) for name in evidence}


def test_a_changed_table_shows(copy_of: Callable[[str], Path], tmp_path: Path) -> None:
    """The script can fail: one failure more in a table is a difference."""
    folder = shutil.copytree(copy_of("suite"), tmp_path / "suite")
    table = folder / "cells.csv"
    rows = list(csv.DictReader(table.read_text(encoding="utf-8").splitlines()))
    row = next(each for each in rows if each["cell"] == document(folder)["numbers"]["failures"]["cells"][0]["name"])
    row["failures"] = str((int(row["failures"]) + 1) % 30)
    with table.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    assert audit_again.differences(folder, documented())


def test_the_bias_of_the_time_step_is_that_of_the_benchmarks() -> None:
    assert documented() == STEP_BIAS


@pytest.mark.parametrize("kind", KINDS)
def test_every_number_is_there_or_has_a_reason(copy_of: Callable[[str], Path], kind: str) -> None:
    """Each number has its source: command, digest, seed, version and tables; a missing one says why."""
    content = document(copy_of(kind))
    assert list(content["numbers"]) == [topic.value for topic in Topic]
    missing = {each["what"] for each in content["not_run"]}
    for name, number in content["numbers"].items():
        assert number["available"] == (number["reason"] is None) == (number["source"] is not None)
        assert number["available"] or name in missing
        if number["available"] and name != "time_step":
            source = number["source"]
            assert source["command"].startswith("cortexc ")
            assert source["command"].endswith(content["command"])
            assert all(source[field] not in (None, "", []) for field in ("file", "digest", "seed", "version", "tables"))
    assert all(content["case"].values())


def test_the_same_command_gives_the_same_sheet(copy_of: Callable[[str], Path], tmp_path: Path) -> None:
    """The sheet of a search and of a suite does not depend on when, or how often, it is made."""
    for kind in ("domains", "suite"):
        folder = shutil.copytree(copy_of(kind), tmp_path / "again" / kind)
        (folder / "audit.json").unlink()
        assert audit(folder) == 0
        for name in ("audit.json", "audit.html"):
            assert (folder / name).read_bytes() == (copy_of(kind) / name).read_bytes()


def test_verify_sees_a_changed_sheet(copy_of: Callable[[str], Path], tmp_path: Path, cortexc: Run) -> None:
    """A changed digit of the page is damage."""
    folder = shutil.copytree(copy_of("search"), tmp_path / "run")
    assert cortexc("verify", folder, "--sample", 0).code == 0
    page = folder / "audit.html"
    page.write_text(page.read_text(encoding="utf-8").replace("independent draws", "independent drawn", 1), "utf-8")
    found = cortexc("verify", folder, "--sample", 0)
    assert found.code == 2
    assert "report" in found.said
    assert "--audit" in found.said


def test_the_method_of_a_search_decides_which_numbers_there_are(copy_of: Callable[[str], Path]) -> None:
    assert document(copy_of("search"))["cautions"] == []
    assert document(copy_of("genetic"))["numbers"]["probability"]["available"]
    numbers = document(copy_of("sequence"))["numbers"]
    assert "no independent draws" in numbers["failures"]["reason"]
    assert numbers["dynamic"]["available"]


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_the_sheet_is_complete_for_every_example(
    path: Path, tmp_path: Path, cortexc: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each example has a sheet without a blank, and all its numbers are those of its tables.

    The sheet of a search with a driver from outside does not need that driver.
    """
    words = ["--random", "--generations", 2, "--population", 40, "--seed", 7, "--out", tmp_path / "run"]
    monkeypatch.syspath_prepend(str(ROOT / "examples" / "own_driver"))
    named = re.search(r"python:(acc|planner):drive", path.read_text(encoding="utf-8"))
    driver = ["--ego", named[0] if named else "python:planner:drive"] if "own_driver" in path.parts else []
    shutil.copytree(path.parent, tmp_path / "files")  # with its maps, as a run names files beside its folder
    assert cortexc(tmp_path / "files" / path.name, *words, *driver).code == 0
    assert cortexc("report", tmp_path / "run", "--audit").code == 0
    assert audit_again.differences(tmp_path / "run", documented()) == []
    text = re.sub(
        r"<(script|style)[^>]*>.*?</\1>", "", (tmp_path / "run" / "audit.html").read_text("utf-8"), flags=re.S
    )
    assert not re.search(r"\bnan\b|\bNone\b|\binf\b|>\s*–\s*<", text)
    content = document(tmp_path / "run")
    assert all(number["available"] or number["reason"] for number in content["numbers"].values())


@given(st.data())
def test_the_verdicts_on_the_cells_of_a_suite_are_those_of_the_engine(
    copy_of: Callable[[str], Path], data: st.DataObject
) -> None:
    """Whatever the drivers said, reasons why a collision is out of their range among it."""
    found = document_in(copy_of("suite"))
    assert found is not None
    content = json.loads(json.dumps(found.content))
    judged = [cell for group in content["groups"] for cell in group["cells"] if cell["answers"]]
    of_the_ego = [each for each in Answer if each not in (Answer.NONE, Answer.STRUCK)]
    row = st.one_of(st.just([Answer.STRUCK] * 5), st.lists(st.sampled_from(of_the_ego), min_size=5, max_size=5))
    rows = [data.draw(row) for _ in judged]
    for cell, said in zip(judged, rows, strict=True):
        counts = {name: {answer: 1} for name, answer in zip(NAMES, said, strict=True)}
        cell["answers"] = {name: {answer.name.lower(): 1 for answer in each} for name, each in counts.items()}
        cell["references"] = answer_texts(counts)
    report = audit_of_document(replace(found, content=content))
    (values,) = (each.values for each in report.findings if each.topic is Topic.VERDICTS)
    codes = verdicts(np.array(rows)).tolist()
    names = [blame.name.lower() for blame in Blame if blame is not Blame.NONE]
    expected = {name: sum(Blame(code).name.lower() == name for code in codes) for name in names}
    assert {name: values.get(name, 0) for name in names} == expected


@given(st.data())
def test_a_changed_count_or_outcome_of_a_suite_is_refused_with_its_place(
    copy_of: Callable[[str], Path], data: st.DataObject
) -> None:
    """Any one of them, by any amount; the place names the cell, the group or the count."""
    found = document_in(copy_of("suite"))
    assert found is not None
    content = json.loads(json.dumps(found.content))
    audit_of_document(replace(found, content=content))
    group = data.draw(st.sampled_from(content["groups"]))
    cell = data.draw(st.sampled_from(group["cells"]))
    here = f"cell `{cell['id']}`"
    places = [
        (content["counts"], data.draw(st.sampled_from([*content["counts"]])), "`counts`"),
        (group, "runs", f"group `{group['name']}`"),
        (cell, "simulations", f"group `{group['name']}`"),
        (cell, "outcome", "`counts`"),
        (cell["probability"], "runs", here),
        (cell["probability"], "failures", here),
        *((counts, answer, here) for counts in cell["answers"].values() for answer in counts),
    ]
    where, name, place = data.draw(st.sampled_from(places))
    names = st.sampled_from([each.name.lower() for each in Outcome])
    new = (names if name == "outcome" else st.integers(0, 10_000)).filter(lambda value: value != where[name])
    where[name] = data.draw(new)
    with pytest.raises(ArgumentError, match=re.escape(f"suite.json`, {place}")) as caught:
        audit_of_document(replace(found, content=content))
    assert "run `cortexc suite` again" in caught.value.cure


# -- tests as a document -----------------------------------------------------------------------------------------------


def test_a_kept_test_result_has_a_sheet(tmp_path: Path, cortexc: Run) -> None:
    """The document of `cortexc test --json`, in a file."""
    for name in ("one", "two"):
        (tmp_path / f"{name}.scn").write_text(FOLLOWING.format(speed="SPEED"), encoding="utf-8")
    found = cortexc("test", tmp_path / "one.scn", tmp_path / "two.scn", "--budget", 60, "--json")
    (tmp_path / "test.json").write_text(found.out, encoding="utf-8")
    assert audit(tmp_path / "test.json") == 0
    assert audit_again.differences(tmp_path, documented()) == []
    numbers = document(tmp_path)["numbers"]
    assert len(numbers["failures"]["cells"]) == 4
    assert "cortexc test" in numbers["failures"]["source"]["command"]


# -- exposure ----------------------------------------------------------------------------------------------------------


def weights(folder: Path, head: str, rows: list[str]) -> Path:
    path = folder / "exposure.csv"
    path.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    return path


SPEEDS = [f"{low} to {low + 10} km/h" for low in (20, 30, 40, 50)]


@pytest.mark.parametrize("kind", ["domains", "suite", "comparison", "coverage"])
def test_numbers_under_an_exposure_are_those_of_the_tables(
    copy_of: Callable[[str], Path], tmp_path: Path, kind: str
) -> None:
    """The weights of a file for the cells of each kind of results."""
    folder = shutil.copytree(copy_of(kind), tmp_path / kind)
    if kind == "suite":
        cells = [each["name"] for each in document(folder)["numbers"]["failures"]["cells"]]
        path = weights(folder, "cell,weight", [f"{name},{number}" for number, name in enumerate(cells)])
    elif kind == "comparison":
        path = weights(folder, "file,weight", ["first.scn,3"])
    else:
        gaps = ["10 to 20 m", "20 to 30 m", "30 to 40 m"]
        rows = [f"{speed},{gap},{1 + number}" for number, speed in enumerate(SPEEDS) for gap in gaps]
        path = weights(folder, "speed,gap,weight", rows)
    assert audit(folder, "--exposure", path) == 0
    assert audit_again.differences(folder, documented()) == []
    assert document(folder)["numbers"]["exposure"]["rate"] is not None


def test_a_cell_without_draws_counts_in_the_bound_only(copy_of: Callable[[str], Path], tmp_path: Path) -> None:
    """Its weight is named, there is no estimate, and the bound takes it for failing always."""
    folder = shutil.copytree(copy_of("domains"), tmp_path / "domains")
    gaps = ["10 to 20 m,1", "20 to 30 m,1", "30 to 40 m,1", "40 to 50 m,1"]
    assert audit(folder, "--exposure", weights(folder, "gap,weight", gaps)) == 0
    number = document(folder)["numbers"]["exposure"]
    assert number["rate"] is None
    assert number["weight_without_draws"] == 0.25
    assert number["high"] > 0.25
    assert audit_again.differences(folder, documented()) == []


@pytest.mark.parametrize("kind", ["suite", "comparison"])
def test_a_part_without_runs_keeps_its_weight(copy_of: Callable[[str], Path], tmp_path: Path, kind: str) -> None:
    """A cell of a suite and a file of a comparison that have no run count as failing always in the bound."""
    folder = shutil.copytree(copy_of(kind), tmp_path / kind)
    cells = [each["name"] for each in document(folder)["numbers"]["failures"]["cells"]]
    path = folder / {"suite": "suite.json", "comparison": "compare.json"}[kind]
    content = json.loads(path.read_text(encoding="utf-8"))
    if kind == "suite":
        name, head = cells.pop(), "cell,weight"
        idle = next(cell for group in content["groups"] for cell in group["cells"] if cell["id"] == name)
        idle["probability"] = {"runs": 0, "failures": 0, "rate": None, "low": None, "high": None}
    else:
        name, head = "idle.scn", "file,weight"
        content["files"].append({**content["files"][0], "path": name, "valid": 0, "changes": [], "conditions": []})
    path.write_text(json.dumps(content), encoding="utf-8")
    rows = [f"{each},1" for each in cells]
    assert audit(folder, "--exposure", weights(folder, head, [*rows, f"{name},{len(cells)}"])) == 0
    number = document(folder)["numbers"]["exposure"]
    assert number["rate"] is None
    assert number["weight_without_draws"] == 0.5
    assert number["high"] > 0.5


@pytest.mark.parametrize(
    ("head", "rows", "said"),
    [
        ("speed,weight", ["20 to 30 km/h,-1"], "line 2: the weight is `-1`"),
        ("speed,weight", ["20 to 30 km/h,nan"], "line 2: the weight is `nan`"),
        ("speed,weight", ["20 to 30 km/h,inf"], "line 2: the weight is `inf`"),
        ("speed,weight", ["20 to 30 km/h,much"], "line 2: the weight is `much`"),
        ("speed,weight", ["20 to 31 km/h,1"], "did you mean `20 to 30 km/h`"),
        ("speed,weight", ["20 to 30 km/h,1"], "has no weight for the cell `30 to 40 km/h`"),
        ("speed,weight", [f"{speed},0" for speed in SPEEDS], "every weight is 0"),
        ("speed,weight", ["20 to 30 km/h,1", "20 to 30 km/h,2"], "has a weight in line 2"),
        ("speed,weight", ["20 to 30 km/h"], "line 2: expected 2 values, found 1"),
        ("speed,weight", [], "has no cell"),
        ("sped,weight", ["20 to 30 km/h,1"], "there is no domain `sped`"),
        ("speed", ["20 to 30 km/h"], "expected the names of coordinates and `weight`"),
        ("speed,speed,weight", ["1,2,3"], "expected the names of coordinates"),
    ],
)
def test_a_wrong_exposure_is_refused(
    copy_of: Callable[[str], Path], tmp_path: Path, cortexc: Run, head: str, rows: list[str], said: str
) -> None:
    """Each mistake has exit code 2, its line and a cure, and leaves the sheet as it was."""
    folder = copy_of("domains")
    before = (folder / "audit.json").read_bytes()
    found = cortexc("report", folder, "--audit", "--exposure", weights(tmp_path, head, rows))
    assert found.code == 2
    assert said in found.said
    assert "help:" in found.said
    assert (folder / "audit.json").read_bytes() == before


@pytest.mark.parametrize(
    ("kind", "head", "said"),
    [
        ("search", "speed,weight", "has no `domain` lines"),
        ("sequence", "speed,weight", "weights independent draws"),
        ("suite", "speed,weight", "expected `cell,weight`"),
        ("comparison", "cell,weight", "expected `file,weight`"),
        ("coverage", "speed,weight", "which is no product of this coverage"),
    ],
)
def test_an_exposure_of_other_cells_is_refused(
    copy_of: Callable[[str], Path], tmp_path: Path, cortexc: Run, kind: str, head: str, said: str
) -> None:
    found = cortexc("report", copy_of(kind), "--audit", "--exposure", weights(tmp_path, head, ["20 to 30 km/h,1"]))
    assert found.code == 2
    assert said in found.said


COUNTS = st.lists(st.tuples(st.integers(1, 500), st.integers(0, 500), st.floats(0.01, 100.0)), min_size=1, max_size=8)


@given(COUNTS, st.floats(1e-6, 1e6))
def test_laws_of_a_weighted_rate(drawn: list[tuple[int, int, float]], factor: float) -> None:
    """The scale of weights is nothing; weights like the draws give the pooled rate with all draws effective."""
    cells = [CellCount(n, min(k, n)) for n, k, _ in drawn]
    own = [weight for *_, weight in drawn]
    found, scaled = exposed_rate(cells, own), exposed_rate(cells, [factor * weight for weight in own])
    assert scaled.rate == pytest.approx(found.rate, rel=1e-9)
    assert scaled.high == pytest.approx(found.high, rel=1e-9)
    total = sum(cell.draws for cell in cells)
    assert found.effective <= total * (1.0 + 1e-9)
    assert found.rate <= found.high + 1e-12
    pooled = exposed_rate(cells, [float(cell.draws) for cell in cells])
    assert pooled.rate == pytest.approx(sum(cell.failures for cell in cells) / total)
    assert pooled.effective == pytest.approx(total)


def test_bounds_hold_in_95_of_100_repetitions() -> None:
    """The bounds of a cell and of a weighted sum lie below planted rates in at most 5 % of 2,000 repetitions."""
    random = np.random.default_rng(7)
    rates, share, draws = np.array([0.002, 0.05, 0.3]), np.array([0.7, 0.2, 0.1]), np.array([300, 80, 20])
    missed = weighted = 0
    for _ in range(2000):
        failures = random.binomial(draws, rates)
        cells = [CellCount(int(n), int(k)) for n, k in zip(draws, failures, strict=True)]
        weighted += exposed_rate(cells, share.tolist()).high < float(share @ rates)
        missed += upper_bound(int(failures[1]), int(draws[1])) < rates[1]
    assert missed <= 0.05 * 2000 + 3 * np.sqrt(2000 * 0.05 * 0.95)
    assert weighted <= 0.05 * 2000


# -- bad input ---------------------------------------------------------------------------------------------------------


def test_folders_and_files_that_are_no_results(tmp_path: Path, cortexc: Run, left_turn: Path) -> None:
    """Nothing there, an empty folder of a killed command, a folder with other files, a scenario, other JSON."""
    (tmp_path / "empty").mkdir()
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "notes.txt").write_text("x")
    (tmp_path / "data.json").write_text('{"schema": "cortexc/sample"}')
    (tmp_path / "list.json").write_text("[]")
    for path, said in (
        (tmp_path / "nothing", "there is no folder"),
        (tmp_path / "empty", "killed"),
        (tmp_path / "other", "holds no search"),
        (left_turn, "is no JSON"),
        (tmp_path / "data.json", "is no document of a suite"),
        (tmp_path / "list.json", "is no document of cortexc"),
    ):
        found = cortexc("report", path, "--audit")
        assert found.code == 2, path
        assert said in found.said
        assert "help:" in found.said


def test_documents_of_another_version_or_with_damage(
    copy_of: Callable[[str], Path], tmp_path: Path, cortexc: Run
) -> None:
    """Another schema and a cut or changed document are refused; another version of cortexc is a caution."""
    folder = shutil.copytree(copy_of("suite"), tmp_path / "suite")
    path = folder / "suite.json"
    text = path.read_text(encoding="utf-8")
    content = json.loads(text)
    lacking = {**content, "groups": [{"name": "CCRs"}]}
    for changed, said in (
        (json.dumps({**content, "schema_version": 2}), "has version 2 of its schema"),
        (text[: len(text) // 2], "is no JSON"),
        (json.dumps(lacking), "is no whole document"),
        (json.dumps({**content, "groups": 3}), "is no whole document"),
    ):
        path.write_text(changed, encoding="utf-8")
        found = cortexc("report", folder, "--audit")
        assert found.code == 2
        assert said in found.said
    path.write_text(json.dumps({**content, "cortexc": "0.1.0", "not_done": 2}), encoding="utf-8")
    assert cortexc("report", folder, "--audit").code == 0
    cautions = " ".join(document(folder)["cautions"])
    assert "cortexc 0.1.0" in cautions
    assert "interrupted" in cautions


def test_a_coverage_without_a_run_in_a_cell_says_so(
    copy_of: Callable[[str], Path], tmp_path: Path, cortexc: Run
) -> None:
    """Independent draws in no cell are no covering array; a state without its cell is damage."""
    folder = shutil.copytree(copy_of("coverage"), tmp_path / "coverage")
    path = folder / "coverage.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    cells = [{**each, "state": "untried", "reason": "no run reached it"} for each in content["cells"]]
    counts = {**dict.fromkeys(content["counts"], 0), "untried": len(cells)}
    for method, reason in (("independent", "no run lies in a cell"), ("tway", "covering array")):
        path.write_text(json.dumps({**content, "method": method, "cells": cells, "counts": counts}), encoding="utf-8")
        assert audit(folder) == 0
        assert reason in document(folder)["numbers"]["failures"]["reason"]
    path.write_text(json.dumps({**content, "counts": {**content["counts"], "rare": 1}}), encoding="utf-8")
    found = cortexc("report", folder, "--audit")
    assert found.code == 2
    assert "is no whole document" in found.said


FAILING = """
import planner

def drive(seen):
    pedals = planner.drive(seen)
    pedals[seen[:, 0] > 13.0] = float("nan")
    return pedals
"""


@pytest.fixture
def driven_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a file with domains for a driver from outside, `planner`, and `failing`, which fails in some scenes."""
    own = ROOT / "examples" / "own_driver"
    lines = ('domain "first" ego.speed at start in 5 m/s steps from 0 m/s to 20 m/s', DOMAIN_AT_END)
    path = tmp_path / "crossing.scn"
    path.write_text("\n".join([(own / "crossing.scn").read_text(encoding="utf-8"), *lines, ""]), encoding="utf-8")
    shutil.copy(own / "planner.py", tmp_path / "planner.py")
    (tmp_path / "failing.py").write_text(FAILING, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    return path


DOMAIN_AT_END = 'domain "last" ego.speed at end in 10 m/s steps from 0 m/s to 20 m/s'


def test_runs_that_the_driver_lost_count_in_every_bound(driven_file: Path, tmp_path: Path, cortexc: Run) -> None:
    """Those of a coverage for each cell, those of a comparison for both sides."""
    words = (driven_file, "--budget", 60, "--out")
    drivers = ("python:planner:drive", "python:failing:drive")
    cortexc("coverage", *words, tmp_path / "coverage", "--ego", drivers[1])
    cortexc("compare", *drivers, *words, tmp_path / "comparison")
    kept = json.loads((tmp_path / "coverage" / "coverage.json").read_text(encoding="utf-8"))
    assert 0 < kept["lost_by_driver"] <= kept["lost"]
    for kind in ("coverage", "comparison"):
        assert audit(tmp_path / kind) == 0
        assert audit_again.differences(tmp_path / kind, documented()) == []
    numbers = document(tmp_path / "coverage")["numbers"]
    assert {cell["lost"] for cell in numbers["failures"]["cells"]} == {kept["lost_by_driver"]}
    events = document(tmp_path / "comparison")["numbers"]["probability"]["events"]
    assert all(event["lost"] > 0 for event in events)


def test_an_exposure_of_domains_without_the_driver_asks_for_it(driven_file: Path, tmp_path: Path, cortexc: Run) -> None:
    """Values after the start need the driver: the cure is not to write domains that the file has."""
    driver = ("--ego", "python:planner:drive")
    search = ("--random", "--generations", 1, "--population", 30, "--out", tmp_path / "run")
    assert cortexc(driven_file, *search, *driver).code == 0
    path = weights(tmp_path, "last,weight", ["0 to 10 m/s,1", "10 to 20 m/s,1"])
    found = cortexc("report", tmp_path / "run", "--audit", "--exposure", path)
    assert found.code == 2
    assert "no values of last" in found.said
    assert "give the driver: --ego" in found.said
    assert cortexc("report", tmp_path / "run", "--audit", "--exposure", path, *driver).code == 0


@pytest.mark.parametrize(
    ("error", "said"),
    [(KeyboardInterrupt, "was stopped"), (RuntimeError, "is not finished")],
    ids=["stopped", "killed"],
)
def test_a_search_that_is_not_finished_names_what_is_missing(
    error: type[BaseException], said: str, tmp_path: Path
) -> None:
    """Its numbers are those of its two generations; an error leaves the same journal as a kill."""

    def end(progress: Progress) -> None:
        if progress.generation == 1:
            raise error

    with suppress(RuntimeError):
        cx.search(LEFT_TURN, "random", generations=5, population=30, out=tmp_path / "run", on_generation=end)
    assert audit(tmp_path / "run") == 0
    content = document(tmp_path / "run")
    assert any(f"The search {said}" in each for each in content["cautions"])
    left = [each for each in content["not_run"] if each["what"] == "generations"]
    assert left == [{"what": "generations", "reason": f"the search {said}", "count": 3}]
    assert content["numbers"]["effort"]["simulations"] == 60


def test_options_that_do_not_go_together(copy_of: Callable[[str], Path], small_study: Path, cortexc: Run) -> None:
    folder = copy_of("search")
    for words, said in (
        ((folder, "--exposure", "x.csv"), "has no effect without --audit"),
        ((folder, "--audit", "--cases", 3), "--cases has no effect with --audit"),
        ((folder, "--audit", "--exposure", folder / "none.csv"), "none.csv"),
        ((copy_of("suite"), "--audit", "--ego", "python:a:b"), "--ego has no effect"),
        ((small_study, "--audit"), "is a study"),
    ):
        found = cortexc("report", *words)
        assert found.code == 2
        assert said in found.said


def test_the_page_and_its_document_go_to_another_place(
    copy_of: Callable[[str], Path], tmp_path: Path, cortexc: Run
) -> None:
    assert cortexc("report", copy_of("domains"), "--audit", "--out", tmp_path / "sheet.html").code == 0
    names = {path.name for path in tmp_path.iterdir()}
    tables = {f"sheet-audit-{name}.csv" for name in ("draws", "collisions", "cases")}
    assert names == {"sheet.html", "sheet-audit.json"} | tables
    content = json.loads((tmp_path / "sheet-audit.json").read_text(encoding="utf-8"))
    assert content["evidence"] == {name: audit_again.digest(tmp_path / name) for name in tables}
    assert content["numbers"]["failures"]["source"]["tables"] == ["sheet-audit-draws.csv"]
    assert content["command"].endswith("--audit --out sheet.html")
    page = (tmp_path / "sheet.html").read_text(encoding="utf-8")
    assert "<code>sheet-audit.json</code>" in page


def test_a_sheet_never_replaces_its_evidence(copy_of: Callable[[str], Path], tmp_path: Path, cortexc: Run) -> None:
    """Whatever `--out` is, the files from which the numbers come stay as they are."""
    folder = shutil.copytree(copy_of("suite"), tmp_path / "suite")
    before = {path: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    assert cortexc("report", folder, "--audit", "--out", folder / "suite.html").code == 0
    for name in ("suite.json", "cells.csv", "effort.json", "audit.json"):
        assert (folder / name).read_bytes() == before[folder / name]
    page = (folder / "suite.html").read_bytes()
    for name in ("audit.json", "x-audit.json"):
        shutil.copy(folder / "suite.json", tmp_path / name)
    for words, said in (
        ((folder, "--out", folder / "suite.json"), "is no page"),
        ((folder, "--out", folder / "cells.csv"), "is no page"),
        ((tmp_path / "audit.json",), "would replace"),
        ((tmp_path / "x-audit.json", "--out", tmp_path / "x.html"), "would replace"),
    ):
        found = cortexc("report", words[0], "--audit", *words[1:])
        assert found.code == 2
        assert said in found.said
        assert "help:" in found.said
    assert (folder / "suite.html").read_bytes() == page
    assert (folder / "suite.json").read_bytes() == (tmp_path / "x-audit.json").read_bytes()
    assert not (tmp_path / "x.html").exists()


def test_a_command_is_without_folders() -> None:
    """Also a path that is quoted for its spaces."""
    assert (
        without_folders_of("cortexc test '/home/a user/my file.scn' --seed 3") == "cortexc test 'my file.scn' --seed 3"
    )

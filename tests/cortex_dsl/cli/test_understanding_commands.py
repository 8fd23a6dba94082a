"""`cortexc analyse`, `cortexc probability` and `--freeze`, as a user meets them."""

import contextlib
import io
import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cortex_dsl.cli import main

Command = Callable[..., Any]
pytestmark = pytest.mark.usefixtures("small_design")
SYSTEM = "simulation(system=[EGO_BRAKE, SAFETY_DIST, CRASH_DIST])\n"


@pytest.fixture(scope="module")
def declared(left_turn: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example, with the params of its system under test named above all of them."""
    path = tmp_path_factory.mktemp("declared") / "declared.scn"
    text = left_turn.read_text(encoding="utf-8").replace(SYSTEM, "")
    path.write_text(text.replace("map intersection", SYSTEM + "map intersection", 1), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def finished(declared: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A search that all have in common."""
    folder = tmp_path_factory.mktemp("finished") / "run"
    words = ["--ga", "--generations", "6", "--population", "60", "--out", str(folder), "--json"]
    with contextlib.redirect_stdout(io.StringIO()):
        assert main([str(declared), *words]) == 0
    return folder


@pytest.fixture
def run(finished: Path, tmp_path: Path) -> Path:
    """A copy of it, to do with as one likes."""
    return shutil.copytree(finished, tmp_path / "run")


def test_a_run_is_understood(cortexc: Command, run: Path) -> None:
    """Every part has its title; the page fits its terminal and says what the search should not have chosen."""
    result = cortexc("analyse", run, "--budget", "700")
    assert result.code == 0
    titles = ("Kinds of failures", "ego speed x other speed", "approach angle", "Which params matter", "UN R157")
    for title in titles:
        assert title in result.out
    assert "EGO_BRAKE, SAFETY_DIST, CRASH_DIST" in result.out
    assert max(map(len, result.out.splitlines())) <= 100
    assert "\x1b" not in result.out


def test_the_document_says_the_same(cortexc: Command, run: Path) -> None:
    """One document; its counts fit one another, and 0 simulations leave the design out."""
    found = cortexc("analyse", run, "--budget", "0", "--json").document
    assert found["schema"] == "cortexc/analysis"
    assert found["sensitivity"] is None
    assert len(found["conditions"]) == len(found["clusters"])
    assert sum(kind["count"] for kind in found["kinds"]) == found["came"]["collisions"] == found["failures"]
    assert sum(len(cluster["rows"]) for cluster in found["clusters"]) == found["failures"]
    assert sum(found["avoided"]["by"].values()) == found["avoided"]["driven"] <= found["failures"]
    assert found["system"] == ["EGO_BRAKE", "SAFETY_DIST", "CRASH_DIST"]


def test_analyse_needs_a_run(cortexc: Command, tmp_path: Path) -> None:
    """Without one, and without a journal in it, a cure is shown."""
    for arguments in (("analyse",), ("analyse", tmp_path)):
        result = cortexc(*arguments)
        assert result.code == 2
        assert "help:" in result.said


def test_probability_has_its_interval(cortexc: Command, left_turn: Path) -> None:
    """All estimators give a value inside its interval, and roughly the same one."""
    values = []
    for method in ("mc", "subset", "importance"):
        found = cortexc("probability", left_turn, "--method", method, "--samples", "2000", "--json").document
        assert found["interval"]["low"] < found["value"] < found["interval"]["high"]
        assert 0.6 < found["valid_share"] < 0.8
        values.append(found["value"])
    assert values == pytest.approx([values[0]] * 3, abs=0.05)
    text = cortexc("probability", left_turn, "--samples", "500").out
    assert "given a valid scene" in text
    assert "Clopper and Pearson" in text
    assert "params are drawn once, then a scene for them is drawn in up to 2,000 attempts" in text
    assert "of a collision that each reference driver avoids" in text
    assert max(map(len, text.splitlines())) <= 100


def test_probability_under_the_joint_condition(cortexc: Command, left_turn: Path) -> None:
    """As many valid runs as asked for, among far more draws; of chains it is not to be had."""
    found = cortexc("probability", left_turn, "--condition", "joint", "--samples", "1000", "--json").document
    assert (found["condition"], found["max_attempts"], found["valid"]) == ("joint", 1, 1000)
    assert found["avoidable_interval"]["low"] <= found["avoidable"] <= found["avoidable_interval"]["high"]
    assert found["valid_share"] < 0.05
    text = cortexc("probability", left_turn, "--condition", "joint", "--samples", "300").out
    assert "params and scene are drawn again together" in text
    assert "valid of" in text
    assert "draws" in text
    wrong = cortexc("probability", left_turn, "--condition", "joint", "--method", "subset")
    assert wrong.code == 2
    assert "--method mc" in wrong.said


def test_probability_gives_a_reason_instead_of_an_interval(cortexc: Command, tmp_path: Path) -> None:
    """All runs but those that crash are equally near: neither chains nor weights lead anywhere, plain draws do."""
    path = tmp_path / "still.scn"
    path.write_text(STILL)
    for method in ("subset", "importance"):
        result = cortexc("probability", path, "--method", method, "--samples", "1000")
        assert result.code == 0
        assert "not known" in result.out
        assert "of the runs of a level are different and equally near to a failure" in " ".join(result.out.split())
        found = cortexc("probability", path, "--method", method, "--samples", "1000", "--json").document
        assert (found["withheld"], found["value"]) == ("plateau", None)
        wrong = cortexc("probability", path, "--method", method, "--condition", "joint")
        assert wrong.code == 2
    assert cortexc("probability", path, "--samples", "1000", "--json").document["withheld"] == "nothing"


STILL = """\
map intersection(ways=4, lanes=1, approach=50 m)
param PLACE = Range(0, 1)
ego = new Car at (1.75, -40), facing 90 deg, with speed 0 m/s
other = new Car at (1.75, -20), facing 90 deg, with speed 0 m/s
terminate after 1 s
"""


def test_probability_says_what_is_wrong(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """No file, a file that is not there, too few samples for chains."""
    assert cortexc("probability").code == 2
    assert cortexc("probability", tmp_path / "none.scn").code == 2
    assert cortexc("probability", left_turn, "--method", "subset", "--samples", "50").code == 2


def test_frozen_params_are_no_genes(cortexc: Command, declared: Path) -> None:
    """What the file calls the system's stands at the middle of its range, or at what -p says."""
    program = cortexc(declared, "--freeze", "-p", "CRASH_DIST=1", "--emit", "program").out
    assert [line.split()[2].rstrip(":") for line in program.splitlines() if line.startswith("gene ")] == [
        "EGO_INIT_DIST",
        "EGO_SPEED",
        "ADV_INIT_DIST",
        "ADV_SPEED",
    ]
    assert cortexc(declared, "--freeze", "--json").document["params"].keys().isdisjoint({"EGO_BRAKE", "CRASH_DIST"})


def test_params_to_freeze_can_be_named(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """By name in any file; one that is not there is refused, as is a file that names none."""
    assert "6 params" in cortexc(left_turn, "--freeze", "EGO_BRAKE", "--check").out
    wrong = cortexc(left_turn, "--freeze", "EGO_BRAK", "--check")
    assert wrong.code == 2
    assert "did you mean `EGO_BRAKE`?" in wrong.said
    file = tmp_path / "silent.scn"
    file.write_text(left_turn.read_text(encoding="utf-8").replace(SYSTEM, ""), encoding="utf-8")
    silent = cortexc(file, "--freeze", "--check")
    assert silent.code == 2
    assert "simulation(system=" in silent.said


def test_the_manifest_knows_whose_the_params_are(run: Path) -> None:
    """So that a run can be judged without its file."""
    manifest = json.loads((run / "summary.json").read_text(encoding="utf-8"))["manifest"]
    system = [parameter["name"] for parameter in manifest["parameters"] if parameter["system"]]
    assert system == ["EGO_BRAKE", "SAFETY_DIST", "CRASH_DIST"]


@pytest.fixture
def strict(left_turn: Path, tmp_path: Path) -> Path:
    """The example, with a requirement on the run that no collision keeps."""
    path = tmp_path / "strict.scn"
    text = left_turn.read_text(encoding="utf-8")
    path.write_text(f"{text}\nrequire always (distance from ego to adversary) > 9 m\n", encoding="utf-8")
    return path


def test_what_a_broken_run_hides_is_said(cortexc: Command, strict: Path, tmp_path: Path) -> None:
    """A requirement on the run that ends runs before contact leaves no collision; nobody may take that for safety."""
    out = cortexc("probability", strict, "--samples", "300").out
    assert "given a valid run" in out
    assert "broke a requirement on the run" in out
    assert "allow a valid scene" not in out
    folder = tmp_path / "run"
    assert cortexc(strict, "--random", "--generations", "2", "--population", "40", "--out", folder).code == 0
    assert re.search(r"no collision in \d+ valid of 80 simulations", cortexc("analyse", folder, "--budget", "0").out)
    assert cortexc("report", folder).code == 0
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert re.search(r"No collision of the ego among \d+ valid of 80 simulations", page)
    assert "a requirement on the run broke" in page


def test_counts_of_chains_are_no_estimate(cortexc: Command, left_turn: Path) -> None:
    """Beyond the first level runs depend on one another; their share must not be read beside the estimate."""
    params = ("-p", "EGO_SPEED=6", "-p", "ADV_SPEED=20")
    slow = cortexc("probability", left_turn, *params, "--method", "subset", "--samples", 1000).out
    assert "depend on one another" in slow
    assert "collisions among" not in slow


def test_the_reference_driver_is_reported_with_its_limits(cortexc: Command, run: Path) -> None:
    """What the regulation means and what is ours, which collisions no braking avoids, and whose settings are judged."""
    result = cortexc("analyse", run, "--budget", "0")
    assert "motorways" in result.out
    assert "never steers" in result.out
    found = cortexc("analyse", run, "--budget", "0", "--json").document["avoided"]
    assert 0 < found["lost"] <= found["driven"]
    assert f"{found['lost']} of them are lost from the start" in result.out
    shares = {each["name"]: each["thirds"] for each in found["by_system"]}
    assert set(shares) == {"EGO_BRAKE", "SAFETY_DIST", "CRASH_DIST"}
    assert {sum(thirds) for thirds in shares.values()} == {found["by"].get("AVOIDABLE", found["by"].get("0", 0))}
    assert "the search also chose params of the system under test" in result.out


def test_each_command_names_its_own_help(cortexc: Command, run: Path) -> None:
    """A slip is answered with the page that lists the options of that very command."""
    for name in ("analyse", "probability", "report", "replay", "study", "paper-check"):
        assert f"`cortexc {name} --help`" in cortexc(name, "--bar").err


def test_replay_of_a_run_takes_no_seed(cortexc: Command, run: Path) -> None:
    """It would have no effect."""
    result = cortexc("replay", run, "--seed", "3")
    assert result.code == 2
    assert "--case" in result.said


@pytest.mark.parametrize("words", [("replay",), ("export", "--to", "csv")])
def test_a_folder_is_a_run_whatever_its_name(cortexc: Command, tmp_path: Path, words: tuple[str, ...]) -> None:
    """Also one that is named like a scenario."""
    (folder := tmp_path / "left_turn.scn").mkdir()
    result = cortexc(*words, folder)
    assert result.code == 2
    assert f"there is no journal in `{folder}`" in result.said


def test_a_study_is_no_run(cortexc: Command, small_study: Path) -> None:
    """The command for it is shown."""
    for name in ("analyse", "replay"):
        result = cortexc(name, small_study)
        assert result.code == 2
        assert "`cortexc report" in result.said


def test_conditions_are_said_to_be_judged_on_fresh_draws(cortexc: Command, run: Path) -> None:
    """With how often they fail there, and how many times as often as of all."""
    result = cortexc("analyse", run, "--budget", "0")
    assert "failure rate: that of new runs that meet the condition" in " ".join(result.out.split())
    assert "lift" in result.out


def test_the_probability_of_a_run_is_kept_for_its_page(cortexc: Command, run: Path) -> None:
    """One row for each method, a later one in place of an earlier; the page shows it, or how to come by it."""
    assert cortexc("report", run, "--cases", 0).code == 0
    page = (run / "report.html").read_text()
    assert f"cortexc probability {run.name}" in page
    assert cortexc("probability", run, "--samples", 1000).code == 0
    result = cortexc("probability", run, "--samples", 2000, "--json")
    assert "kept in" in result.said
    assert cortexc("probability", run, "--method", "subset", "--samples", 1000).code == 0
    rows = json.loads((run / "probability.json").read_text())["estimates"]
    assert [row["method"] for row in rows] == ["mc", "subset"]
    assert rows[0]["simulations"] == result.document["simulations"] == 2000
    assert cortexc("report", run, "--cases", 0).code == 0
    page = (run / "report.html").read_text()
    assert f"{100 * rows[0]['value']:.2f} %" in page
    assert f"{rows[0]['collisions']:,} collisions among {rows[0]['valid']:,} valid of 2,000 simulations" in page
    assert "not a model of how often" in page
    assert "cortexc probability" not in page


def test_an_estimate_of_an_earlier_version_is_shown(cortexc: Command, run: Path) -> None:
    """It knows neither the condition nor what could have been avoided."""
    assert cortexc("probability", run, "--samples", 500).code == 0
    path = run / "probability.json"
    (row,) = json.loads(path.read_text())["estimates"]
    for name in ("condition", "max_attempts", "avoidable", "avoidable_interval", "driven"):
        del row[name]
    path.write_text(json.dumps([row]))
    assert cortexc("report", run, "--cases", 0).code == 0
    assert f"{100 * row['value']:.2f} %" in (run / "report.html").read_text()


@pytest.mark.parametrize("content", ["", "{}", "[3]", '[{"method": "mc"}]', "\x00"])
def test_a_damaged_probability_is_reported(cortexc: Command, run: Path, content: str) -> None:
    (run / "probability.json").write_text(content)
    result = cortexc("report", run, "--cases", 0)
    assert result.code == (0 if content.startswith('[{"method') else 2)  # of another program: passed over
    assert "Traceback" not in result.said


def test_the_probability_of_a_run_takes_no_other_scenario(cortexc: Command, run: Path, tmp_path: Path) -> None:
    for words in (("-p", "EGO_SPEED=50 km/h"), ("--scenario", "Main")):
        result = cortexc("probability", run, *words)
        assert result.code == 2
        assert "no effect on a run" in result.said
    assert cortexc("probability", tmp_path / "run" / "worst").code == 2

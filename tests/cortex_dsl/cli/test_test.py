"""`cortexc test`: verdicts and exit codes of planted files, equal results in every format, and bad input."""

import json
import shlex
import tomllib
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import cortex_dsl as cx
from cortex_dsl.api import testing
from cortex_dsl.console.terminal import Exit, gravest
from cortex_dsl.report.findings.gate_report import Check, FailedRun, FileResult, GateReport, Kind, Status
from cortex_dsl.report.gates.junit import junit_text
from cortex_dsl.report.gates.markdown import markdown_text

Run = Callable[..., Any]

SCENE = """\
map intersection()
way = intersection.incomingLanes[0].maneuvers[0]
ego = new Car before intersection by 40 m along way, with speed {speed},
    with behavior FollowTrajectoryBehavior({speed}, way)
truck = new Truck ahead of ego by {gap} m
{more}
terminate after {time} s
"""


def scene(speed: str = "10 m/s", gap: str = "25", time: float = 1.0, more: str = "") -> str:
    """Return a file: the ego drives towards a truck that stands `gap` ahead."""
    return SCENE.format(speed=speed, gap=gap, time=time, more=more)


def drawn(threshold: float) -> str:
    """Return a file whose `expect` breaks with the probability (15 - threshold) / 10."""
    text = scene("SPEED", more=f'expect always ego.speed < {threshold} m/s as "slow"')
    return text.replace("ego = ", "param SPEED = Range(5, 15) m/s\nego = ", 1)


KEPT = 'expect always (minimum distance from ego to truck) > 5 m as "room"'
BROKEN = 'expect always (minimum distance from ego to truck) > 16 m as "room"'
GROUPS: dict[str, tuple[list[str], int, dict[str, tuple[str, str]]]] = {
    "plain": (
        [],
        Exit.DIAGNOSTICS,
        {
            **{f"pass_{gap}": ("pass", scene(gap=str(gap), more=KEPT)) for gap in range(24, 29)},
            **{f"break_{gap}": ("fail", scene(gap=str(gap), more=BROKEN)) for gap in range(20, 25)},
            **{f"far_{gap}": ("pass", scene(gap=str(gap))) for gap in range(24, 27)},
            **{f"contact_{gap}": ("fail", scene(gap=str(gap), time=3.0)) for gap in range(20, 23)},
            "two_expects": ("fail", scene(more=f"{KEPT}\n{BROKEN.replace('room', 'more room')}")),
            "error_name": ("error", scene(more="expect always nobody.speed > 1 m/s")),
            "error_syntax": ("error", "ego = new Car on on road\n"),
            "error_empty": ("error", "# nothing\n"),
            "none_possible": ("error", scene(more="require ego.speed > 20 m/s")),
            "some_slow": ("fail", drawn(10.0)),
            "all_slow": ("pass", drawn(16.0)),
        },
    ),
    "bounds": (
        ["--bound", "min_distance >= 10 m", "--bound", "end_time <= 1 s", "--allow-collisions"],
        Exit.BROKEN_LIMIT,
        {
            "kept_25": ("pass", scene(gap="25")),
            "kept_22": ("pass", scene(gap="22")),
            "near_15": ("fail", scene(gap="15")),
            "near_18": ("fail", scene(gap="18")),
            "long": ("fail", scene(gap="45", time=1.5)),
            "hit": ("fail", scene(gap="20", time=3.0)),
        },
    ),
    "probability": (
        ["--max-probability", "0.1", "--of", "slow", "--budget", "600"],
        Exit.BROKEN_LIMIT,
        {
            "rare_14.99": ("pass", drawn(14.99)),
            "never": ("pass", drawn(15.5)),
            "often_8": ("fail", drawn(8.0)),
            "often_10": ("fail", drawn(10.0)),
            "open_13.9": ("undecided", drawn(13.9)),
            "open_14.05": ("undecided", drawn(14.05)),
            "one_kept": ("pass", scene(more='expect always ego.speed < 13 m/s as "slow"')),
            "one_broken": ("fail", scene(more='expect always ego.speed < 3 m/s as "slow"')),
            "other": ("pass", scene(more=KEPT)),
        },
    ),
}


@pytest.fixture(scope="module")
def planted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folders of planted files, one for each group."""
    home = tmp_path_factory.mktemp("planted")
    for group, (_, _, files) in GROUPS.items():
        (home / group).mkdir()
        for name, (_, text) in files.items():
            (home / group / f"{name}.scn").write_text(text)
    return home


def statuses(document: Any) -> dict[str, str]:
    return {Path(file["path"]).stem: file["status"] for file in document["files"]}


def without_times(thing: Any) -> Any:
    """Return a document without its fields `seconds`."""
    if isinstance(thing, dict):
        return {name: without_times(value) for name, value in thing.items() if name != "seconds"}
    return [without_times(each) for each in thing] if isinstance(thing, list) else thing


@pytest.mark.parametrize("group", GROUPS)
def test_planted_verdicts_and_exit_codes(group: str, planted: Path, cortexc: Run) -> None:
    """All planted files have the right verdict, alone and together, and the right exit codes."""
    options, code, files = GROUPS[group]
    found = cortexc("test", planted / group, *options, "--json", "--jobs", 1)
    assert statuses(found.document) == {name: status for name, (status, _) in files.items()}
    assert found.code == code
    codes = {"pass": Exit.FINE, "fail": Exit.BROKEN_LIMIT, "undecided": Exit.BROKEN_LIMIT, "error": Exit.DIAGNOSTICS}
    for name in [*files][:: max(1, len(files) // 6)]:
        alone = cortexc("test", planted / group / f"{name}.scn", *options, "--json")
        expected = Exit.NO_SCENE if name == "none_possible" else codes[files[name][0]]
        if "--of" not in options or name not in ("other",):
            assert alone.code == expected, name
            (mine,) = (file for file in found.document["files"] if Path(file["path"]).stem == name)
            assert without_times(alone.document["files"][0]) == without_times(mine)


def test_forty_files_are_planted() -> None:
    assert sum(len(files) for _, _, files in GROUPS.values()) + len(KNOWN) >= 40


KNOWN = {
    "known_1": ("known", scene(gap="20", more=BROKEN)),
    "known_2": ("known", scene(gap="21", time=3.0)),
    "cured_1": ("pass", scene(gap="22", more=BROKEN)),
    "cured_2": ("pass", scene(gap="23", time=3.0)),
    "new": ("fail", scene(gap="24", more=KEPT)),
}


def test_a_baseline_knows_failures(tmp_path: Path, cortexc: Run) -> None:
    """Known failures do not fail, new ones do, and cured ones are named; files that did not run keep their entries."""
    folder, baseline = tmp_path / "cases", tmp_path / "known.toml"
    folder.mkdir()
    for name, (_, text) in KNOWN.items():
        (folder / f"{name}.scn").write_text(text)
    words = "test", folder, "--baseline", baseline
    assert cortexc(*words).code == Exit.USAGE
    assert cortexc(*words, "--update-baseline").code == Exit.FINE
    entries = tomllib.loads(baseline.read_text())["failure"]
    assert [Path(entry["file"]).stem for entry in entries] == ["cured_1", "cured_2", "known_1", "known_2"]
    assert all(entry["file"].startswith("cases/") and len(entry["digest"]) == 32 for entry in entries)
    before = cortexc(*words, "--json")
    assert before.code == Exit.FINE
    assert [*statuses(before.document).values()] == ["known"] * 4 + ["pass"]
    (folder / "cured_1.scn").write_text(scene(gap="22", more=BROKEN.replace("16", "6")))
    (folder / "cured_2.scn").write_text(scene(gap="23", time=1.0))
    cured = cortexc(*words, "--json")
    assert cured.code == Exit.FINE
    assert (cured.document["cured"], statuses(cured.document)["cured_1"]) == (2, "pass")
    assert sum("has changed since" in remark for remark in cured.document["remarks"]) == 2
    assert cortexc(*words, "--strict-baseline").code == Exit.BROKEN_LIMIT
    (folder / "new.scn").write_text(scene(gap="24", more=BROKEN.replace("16", "24")))
    found = cortexc(*words, "--json")
    assert found.code == Exit.BROKEN_LIMIT
    assert statuses(found.document) == {name: status for name, (status, _) in KNOWN.items()}
    assert cortexc("test", folder / "new.scn", "--baseline", baseline, "--update-baseline").code == Exit.FINE
    entries = tomllib.loads(baseline.read_text())["failure"]
    assert {Path(entry["file"]).stem for entry in entries} == {"cured_1", "cured_2", "known_1", "known_2", "new"}
    assert cortexc(*words, "--update-baseline", "--strict-baseline").code == Exit.FINE
    entries = tomllib.loads(baseline.read_text())["failure"]
    assert {Path(entry["file"]).stem for entry in entries} == {"known_1", "known_2", "new"}


def test_a_baseline_with_mistakes(tmp_path: Path, cortexc: Run) -> None:
    """An unknown key and an `expect` that is gone are remarks; text that is no baseline is refused."""
    file, baseline = tmp_path / "a.scn", tmp_path / "known.toml"
    file.write_text(scene(more=KEPT))
    entry = '[[failure]]\nfile = "a.scn"\nexpect = "gone"\nkind = "expect"\ncolour = "red"\n'
    baseline.write_text(f"version = 1\nnonsense = 3\n{entry}")
    found = cortexc("test", file, "--baseline", baseline, "--json")
    assert found.code == Exit.FINE
    remarks = " ".join(found.document["remarks"])
    assert all(word in remarks for word in ("`nonsense`", "`colour`", '"gone" any more'))
    wrong = (
        "[[",
        "version = 2",
        'version = 1\n[[failure]]\nfile = "a.scn"',
        entry.replace('"gone"', "3"),
        "failure = 1",
    )
    for text in wrong:
        baseline.write_text(text)
        refused = cortexc("test", file, "--baseline", baseline)
        assert refused.code == Exit.USAGE
        assert "known.toml" in refused.said
    baseline.write_bytes(b"\xff\xfe")
    assert cortexc("test", file, "--baseline", baseline).code == Exit.USAGE


def test_formats_name_the_same_failures(planted: Path, tmp_path: Path, cortexc: Run) -> None:
    """JSON, JUnit, text, annotations and summary agree, and the XML has the structure that Jenkins reads."""
    out, summary = tmp_path / "out.xml", tmp_path / "out.md"
    words = "test", planted / "plain", "--jobs", 1, "--junit", out
    document = cortexc(*words, "--json").document
    told = {
        (file["path"], check["name"]): check["first_failure"]["replay"]
        for file in document["files"]
        for check in file["checks"]
        if check["status"] == "fail"
    }
    assert len(told) >= 10
    root = ET.fromstring(out.read_text())
    check_junit(root)
    failed = {
        (suite.get("name"), case.get("name")): (case.findtext("failure") or "").split("replay: ")[-1]
        for suite in root
        for case in suite.iter("testcase")
        if case.find("failure") is not None
    }
    assert failed == told
    text = cortexc(*words, "--format", "github", "--summary", summary).out
    lines = [line for line in text.splitlines() if line.startswith("::error ")]
    for (path, name), replay in told.items():
        assert text.count(replay) >= 2
        assert any(f"file={path}" in line and f"title={name}" in line for line in lines)
    assert summary.read_text().count("```sh") == len(told)
    expects = [line for line in lines if "break_20" in line]
    assert "line=6," in expects[0]


JUNIT = {
    "testsuites": ({"name", "time", "tests", "failures", "errors"}, {"testsuite"}),
    "testsuite": (
        {"name", "tests", "failures", "errors", "skipped", "time"},
        {"properties", "testcase", "system-out", "system-err"},
    ),
    "properties": (set[str](), {"property"}),
    "property": ({"name", "value"}, set[str]()),
    "testcase": ({"name", "classname", "time"}, {"skipped", "error", "failure", "system-out", "system-err"}),
    "failure": ({"type", "message"}, set[str]()),
    "error": ({"type", "message"}, set[str]()),
    "skipped": ({"type", "message"}, set[str]()),
}
"""Attributes and children of each element, from junit-10.xsd of the xUnit plugin of Jenkins."""


def check_junit(element: ET.Element) -> None:
    """Check the structure of a document, and that its counts are those of its cases."""
    attributes, children = JUNIT[element.tag]
    assert {*element.attrib} <= attributes
    assert {child.tag for child in element} <= children
    if element.tag in ("testsuite", "testcase", "property"):
        assert element.get("name")
    if element.tag == "testsuite":
        cases = element.findall("testcase")
        counts = {"failures": "failure", "errors": "error", "skipped": "skipped"}
        assert int(element.get("tests", "")) == len(cases)
        for name, tag in counts.items():
            assert int(element.get(name, "")) == sum(case.find(tag) is not None for case in cases)
    for child in element:
        check_junit(child)


@pytest.mark.parametrize("strange", ["]]>", "a\x00b\x1f", "\ufffe\ud800", "<&\"'>", "é 🚗 \u2028"])
def test_strange_names_leave_the_formats_whole(strange: str) -> None:
    """XML stays well-formed, and Markdown keeps its table, whatever a name has in it."""
    first = FailedRun(1, 3, event=strange)
    check = Check(strange, Kind.EXPECT, Status.FAIL, 5, 1, line=3, first=first, replay=f"cortexc {strange}")
    files = (FileResult(f"{strange}.scn", checks=(check,)), FileResult("b.scn", no_scene=strange))
    report = GateReport(files, budget="200")
    root = ET.fromstring(junit_text(report).encode("utf-8", "strict"))
    check_junit(root)
    text = markdown_text(report)
    assert [line.count("|") - line.count(r"\|") for line in text.splitlines() if line.startswith("|")] == [5] * 4


def test_a_summary_has_at_most_a_mebibyte() -> None:
    """Longest failures are left out first, and counted; a file that is nearly full gets nothing more."""
    checks = [
        Check(f"c{n}", Kind.EXPECT, Status.FAIL, 5, 1, first=FailedRun(1, n, event="x" * n), replay="r")
        for n in range(2000)
    ]
    report = GateReport((FileResult("a.scn", checks=tuple(checks)),))
    text = markdown_text(report, 1 << 19)
    assert len(text.encode()) <= 1 << 19
    assert "further failure" in text
    assert "**c0**" in text
    assert "**c1999**" not in text
    assert len(markdown_text(report, 100).encode()) <= 400


def test_results_do_not_depend_on_workers(planted: Path, cortexc: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """`--jobs 1` and `--jobs 2` give the same bytes but for times, and so does another order of the paths."""
    monkeypatch.setattr("cortex_dsl.api.testing.ALONE", 0.0)
    paths = sorted((planted / "plain").glob("*.scn"))[:8]
    one = cortexc("test", *paths, "--json", "--jobs", 1, "--budget", 30)
    two = cortexc("test", *reversed(paths), "--json", "--jobs", 2, "--budget", 30)
    assert json.dumps(without_times(one.document)) == json.dumps(without_times(two.document))
    assert one.code == two.code


@pytest.mark.parametrize("seed", [0, 3])
def test_a_replay_command_repeats_the_failure(seed: int, planted: Path, cortexc: Run) -> None:
    """The printed command shows a run that breaks the `expect`, with the robustness that the test gave."""
    names = ("some_slow", "break_20", "contact_20")
    paths = [planted / "plain" / f"{name}.scn" for name in names]
    document = cortexc("test", *paths, "--seed", seed, "--json").document
    checks = [check for file in document["files"] for check in file["checks"]]
    assert len(checks) == 3
    for check in checks:
        first = check["first_failure"]
        words = shlex.split(first["replay"])
        run = cortexc(*words[1:], "--json").document
        if check["kind"] == "contact":
            assert run["collided"]
            continue
        (objective,) = run["objectives"]
        assert objective["broken"]
        assert objective["robustness"] == pytest.approx(first["numbers"][0]["value"], abs=1e-9)
    assert checks[-1]["first_failure"]["seed"] // 10**9 == seed


def test_a_driver_that_fails_is_a_failed_check(tmp_path: Path, cortexc: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """A driver that raises fails the check `controller`; a file without a controller ignores the driver."""
    folder = Path(__file__).parents[3] / "examples" / "own_driver"
    (tmp_path / "failing_driver.py").write_text("def drive(observations):\n    raise ValueError('no plan')\n")
    (tmp_path / "alone.scn").write_text(scene(more=KEPT))
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.chdir(tmp_path)
    words = "test", folder / "crossing.scn", tmp_path / "alone.scn", "--budget", 5, "--json", "--jobs", 1
    found = cortexc(*words, "--ego", "python:failing_driver:drive")
    assert found.code == Exit.BROKEN_LIMIT
    alone, crossing = sorted(found.document["files"], key=lambda file: Path(file["path"]).name)
    assert [(check["kind"], check["status"]) for check in crossing["checks"]] == [("controller", "fail")]
    assert "no plan" in crossing["checks"][0]["first_failure"]["event"]
    assert "--ego python:failing_driver:drive" in crossing["checks"][0]["first_failure"]["replay"]
    assert alone["status"] == "pass"
    assert "--ego has no effect" in alone["remarks"][0]
    assert cortexc(*words).code == Exit.USAGE
    assert cortexc(*words, "--ego", "python:nowhere:drive").code == Exit.USAGE


def test_undecided_may_pass(planted: Path, cortexc: Run) -> None:
    words = "test", planted / "probability" / "open_13.9.scn", "--max-probability", "0.1", "--of", "slow"
    assert cortexc(*words).code == Exit.BROKEN_LIMIT
    assert cortexc(*words, "--undecided", "pass").code == Exit.FINE


def test_contacts_may_be_limited_by_a_probability(planted: Path, cortexc: Run) -> None:
    """Without --of, the probability is that of a contact of the ego, in files with an `expect`, too."""
    found = cortexc("test", planted / "plain" / "some_slow.scn", "--max-probability", "50%", "--json").document
    kinds = {check["kind"]: check["status"] for check in found["files"][0]["checks"]}
    assert kinds == {"expect": "fail", "probability": "pass"}


def test_paths(tmp_path: Path, cortexc: Run) -> None:
    """A file named twice runs once, in the order of paths; patterns leave files out; libraries are no tests."""
    folder = tmp_path / "a" / "b"
    folder.mkdir(parents=True)
    (folder / "two.scn").write_text(scene(more=KEPT))
    (tmp_path / "a" / "one.scn").write_text("from shared import *\n" + scene(more=KEPT))
    (tmp_path / "a" / "shared.scn").write_text("GAP = 3\n")
    (tmp_path / "a" / ".hidden.scn").write_text("nonsense")
    found = cortexc("test", folder / "two.scn", tmp_path / "a", folder / ".." / "b" / "two.scn", "--json")
    assert [Path(file["path"]).name for file in found.document["files"]] == ["two.scn", "one.scn"]
    assert found.code == Exit.FINE
    assert cortexc("test", tmp_path / "a" / "shared.scn").code == Exit.DIAGNOSTICS
    left = cortexc("test", tmp_path / "a", "--exclude", "b/*", "--exclude", "one*", "--exclude", "sha*")
    assert left.code == Exit.USAGE
    assert "--exclude" in left.said


@pytest.mark.parametrize("done", [0, 1])
def test_an_interrupted_test_keeps_the_files_that_are_done(
    done: int, tmp_path: Path, cortexc: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Exit code 130; report and XML have them, and say how many files are missing."""
    for name in ("one", "three", "two"):
        (tmp_path / f"{name}.scn").write_text(scene(more=KEPT))
    whole, seen = testing.check_file, list[object]()

    def interrupted(*arguments: Any) -> FileResult:
        if len(seen) == done:
            raise KeyboardInterrupt
        seen.append(arguments)
        return whole(*arguments)

    monkeypatch.setattr(testing, "check_file", interrupted)
    found = cortexc("test", tmp_path, "--json", "--junit", tmp_path / "out.xml")
    assert found.code == Exit.INTERRUPTED
    assert found.document["not_run"] == 3 - done
    assert not found.document["passed"]
    assert [Path(file["path"]).name for file in found.document["files"]] == ["one.scn", "three.scn"][:done]
    assert len(ET.parse(tmp_path / "out.xml").findall(".//testsuite")) == done
    seen.clear()
    assert f"interrupted, {3 - done} files not run" in " ".join(cortexc("test", tmp_path).out.split())


def test_a_time_budget_says_so(planted: Path, cortexc: Run) -> None:
    found = cortexc("test", planted / "plain" / "some_slow.scn", "--budget", "0.2s")
    assert "depends on the machine" in found.out
    assert cortexc("test", planted / "plain" / "all_slow.scn", "--budget", "0.2s", "--json").document["runs"] >= 256


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["nowhere"], "`nowhere`"),
        ([], "no paths"),
        (["{folder}"], "no scenario below"),
        (["{file}", "--max-probability", "0"], "--max-probability"),
        (["{file}", "--max-probability", "1.5"], "--max-probability"),
        (["{file}", "--budget", "0"], "--budget"),
        (["{file}", "--bound", "speed <= 3 m/s"], "there are approach_angle"),
        (["{file}", "--of", "room"], "--max-probability"),
        (["{file}", "--max-probability", "0.1", "--of", "nothing"], "there are room"),
        (["{file}", "--junit", "{folder}"], "folder"),
        (["{file}", "--junit", "nowhere/out.xml"], "there is no folder"),
        (["{file}", "--summary", "{file}/out.md"], "there is no folder"),
        (["{file}", "--strict-baseline"], "--baseline"),
        (["{file}", "--update-baseline"], "--baseline"),
        (["{file}", "--baseline", "{folder}"], "cannot read"),
        (["{file}", "--undecided", "pass"], "--max-probability"),
        (["{file}", "--seed", "9000000001"], "--seed"),
        (["{file}", "--exclude", "*"], "--exclude"),
        (["{map}"], "not a scenario"),
    ],
)
def test_bad_input(words: list[str], told: str, tmp_path: Path, cortexc: Run) -> None:
    """Each mistake names its place and its cure, with exit code 2 and before anything runs."""
    places = {"folder": tmp_path / "empty", "file": tmp_path / "a.scn", "map": tmp_path / "a.xodr"}
    places["folder"].mkdir()
    places["map"].write_text("")
    places["file"].write_text(scene(more=KEPT))
    found = cortexc("test", *(word.format(**places) for word in words))
    assert found.code == Exit.USAGE
    assert told in found.said
    assert "Traceback" not in found.err


def test_the_gravest_exit_code_is_given() -> None:
    every = [Exit.NO_SCENE, Exit.BROKEN_LIMIT, Exit.DIAGNOSTICS, Exit.USAGE, Exit.BUG]
    for count in range(1, len(every) + 1):
        assert gravest(every[:count]) is every[count - 1]
    assert gravest([]) is Exit.FINE


def test_from_python(planted: Path) -> None:
    """`run_tests` gives the report that the command shows."""
    report = cx.run_tests(planted / "bounds", bounds=["min_distance >= 10 m"], allow_collisions=True)
    assert not report.passed
    assert report.counts[Status.FAIL] == 3
    assert {file.status for file in report.files} == {Status.PASS, Status.FAIL}


@pytest.mark.parametrize("width", [60, 80, 120])
def test_lines_fit_the_terminal(width: int, planted: Path, cortexc: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """No line is wider than the terminal, except for commands, which stay whole."""
    monkeypatch.setenv("COLUMNS", str(width))
    out = cortexc("test", planted / "plain" / "break_20.scn", planted / "plain" / "pass_24.scn").out
    assert all(len(line.rstrip()) <= width for line in out.splitlines() if "cortexc " not in line)
    assert f"cortexc {planted / 'plain' / 'break_20.scn'}" in out

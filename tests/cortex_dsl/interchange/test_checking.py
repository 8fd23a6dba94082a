"""`--check` finds what was spoiled, and says where."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cortex_dsl import compile_text, load
from cortex_dsl.interchange.cases import ExportCase, case_of_scene
from cortex_dsl.interchange.formats import FORMATS, missing_extra
from engine.interchange.contract import ExportOptions, Finding
from engine.interchange.mcap.write import write_mcap
from engine.interchange.recording import Recording
from engine.vocabulary import EndReason, State

STEM = "left_turn-case01"


def spoiled(case: ExportCase, name: str, folder: Path, file: str, pattern: str, new: str) -> list[Finding]:
    """What the check says once the first match of a pattern in one of the files is replaced."""
    export = FORMATS[name].writer(case, STEM, ExportOptions())
    for each, content in export.files.items():
        data = content if isinstance(content, bytes) else content.encode()
        if each == file:
            text, count = re.subn(pattern, new, data.decode(), count=1)
            assert count == 1
            data = text.encode()
        (folder / each).write_bytes(data)
    return list(FORMATS[name].load_checker()(case, folder, list(export.files), ExportOptions()))


SPOILED = {
    "entity": ("xosc", ".xosc", r'entityRef="adversary"', 'entityRef="advresary"', "there is no entity `advresary`"),
    "name": ("xosc", ".xosc", r'<ScenarioObject name="adversary"', '<ScenarioObject name="ego"', "are called `ego`"),
    "road file": (
        "xosc",
        ".xosc",
        r'filepath="left_turn.xodr"',
        'filepath="gone.xodr"',
        "no file `gone.xodr`",
    ),
    "end": ("xosc", ".xosc", r"(?s)<StopTrigger>.*?</StopTrigger>", "<StopTrigger />", "it never ends"),
    "row": ("csv", ".csv", r"(\n\d+,0,)[-0-9.]+", r"\g<1>0.5", "the place at "),
    "road link": ("xodr", ".xodr", r'elementId="\d+"', 'elementId="777"', "777, which is not there"),
    "lane": ("xodr", ".xodr", r'(<width [^>]*a=")3.5', r"\g<1>3.6", "m off"),
    "reference": ("commonroad", ".cr.xml", r' ref="\d+"', ' ref="987654"', "it refers to 987654"),
    "problem": ("commonroad", ".cr.xml", r"(?s)<planningProblem .*</planningProblem>", "", "no planningProblem"),
    "place": ("scenic", ".scenic", r"new Car at \(", "new Car at (0", "does not stand where the run began"),
    "scenario": ("scn", ".scn", r"EGO_SPEED +=", "EGO_SPEED = 1.5 *", "does not run to the same outcome"),
}


def test_values_of_nobody_are_found(worst: ExportCase, tmp_path: Path) -> None:
    """A file of known cases without one, which the schema refuses, too."""
    options = ExportOptions(mode="maneuver")
    export = FORMATS["xosc"].writer(worst, STEM, options)
    for each, content in export.files.items():
        (tmp_path / each).write_bytes(content if isinstance(content, bytes) else content.encode())
    assert list(FORMATS["xosc"].load_checker()(worst, tmp_path, list(export.files), options)) == []
    champions = tmp_path / f"{STEM}.champions.xosc"
    tag = "ValueSetDistribution"
    text, count = re.subn(rf"(?s)<{tag}>.*</{tag}>", f"<{tag} />", champions.read_text())
    champions.write_text(text)
    (found,) = FORMATS["xosc"].load_checker()(worst, tmp_path, list(export.files), options)
    assert count == 1
    assert found.place.startswith(champions.name)
    assert found.reason == "<ValueSetDistribution> holds no values"


@pytest.mark.parametrize("what", SPOILED)
def test_it_is_found(worst: ExportCase, what: str, tmp_path: Path) -> None:
    """Each finding names its file, and what is wrong."""
    name, suffix, pattern, new, reason = SPOILED[what]
    file = "left_turn.xodr" if suffix == ".xodr" else f"{STEM}{suffix}"
    findings = spoiled(worst, name, tmp_path, file, pattern, new)
    assert any(reason in finding.reason for finding in findings), findings
    assert all(file in finding.place for finding in findings)
    assert all(finding.cure for finding in findings)


BRAKING = """
behavior Stop():
    while True:
        take SetBrakeAction(0.5)

ego = new Car at (1.75 m, -40 m), facing 90 deg, with speed 10 m/s, with behavior Stop()
terminate after 1 s
"""


def scene_case(text: str, name: str) -> ExportCase:
    """The scene of a scenario of one's own."""
    scenario = compile_text(f"map intersection()\n{text}", name=f"{name}.scn")
    return case_of_scene(scenario, scenario.sample(), Path(f"{name}.scn"), 0, "")


def test_another_brake_is_found(tmp_path: Path) -> None:
    """A copy that ends when the run did, but drove otherwise."""
    case = scene_case(BRAKING, "braking")
    stem = case.recording.name
    (text,) = FORMATS["scn"].writer(case, stem, ExportOptions()).files.values()
    for spoilt, said in ((str(text), []), (str(text).replace("(0.5)", "(0.1)"), ["it does not run the same way"])):
        (tmp_path / f"{stem}.scn").write_text(spoilt)
        findings = list(FORMATS["scn"].load_checker()(case, tmp_path, [f"{stem}.scn"], ExportOptions()))
        assert [finding.reason for finding in findings][:1] == said


@pytest.mark.parametrize("seed", [1, 4])
@pytest.mark.parametrize("name", ["xosc", "csv", "commonroad"])
def test_a_run_that_ends_at_a_building_is_read_back(name: str, seed: int, tmp_path: Path) -> None:
    """An OpenSCENARIO file brings the buildings in its road; a table has none, and is judged with those of the run; in
    CommonRoad files they are counted. The speed of who slides, or is stopped by a wall, has no one meaning.
    """
    scenario = load(Path(__file__).parents[2] / "agreement" / "walls.scn")
    case = case_of_scene(scenario, scenario.scene_of_seed(seed), Path("walls.scn"), seed, "")
    assert case.outcomes.end_reason[0] == EndReason.BUILDING
    assert spoiled(case, name, tmp_path, "", "", "") == []
    if name == "commonroad":
        (found,) = spoiled(
            case, name, tmp_path, f"{STEM}.cr.xml", r"(?s) <environmentObstacle .*</environmentObstacle>\n", ""
        )
        assert found.reason == "0 buildings of 4 are there"


NEVER = """
scenario Main():
    setup:
        ego = new Car at (1.75 m, -50 m), facing 90 deg, with speed 10 m/s
        other = new Car at (-1.75 m, 40 m), facing 270 deg, with speed 5 m/s
    compose:
        try:
            do Calm() for 1 s
        interrupt when ego.speed > 100 m/s:
            do CutIn()
        terminate

scenario Calm():
    compose:
        while True:
            wait

scenario CutIn():
    setup:
        box = new Obstacle at (-1.75 m, 30 m)
"""


@pytest.mark.parametrize("name", [name for name in FORMATS if not missing_extra(name) and name not in ("xodr", "scn")])
def test_who_never_comes_in_is_left_out_and_reported(name: str, tmp_path: Path) -> None:
    """The way back is the run of those who took part."""
    case = scene_case(NEVER, "never")
    assert case.recording.never_there == (2,)
    export = FORMATS[name].writer(case, case.recording.name, ExportOptions())
    for file, content in export.files.items():
        (tmp_path / file).write_bytes(content if isinstance(content, bytes) else content.encode())
    assert list(FORMATS[name].load_checker()(case, tmp_path, list(export.files), ExportOptions())) == []
    if name != "scenic":  # where it stands in the source, in a scenario that nobody starts
        assert export.remarks[0] == "`box` never comes in, and is left out"
        assert not any(b"box" in (tmp_path / file).read_bytes() for file in export.files)


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda r: replace(r, states=r.states + 0.002 * np.eye(len(State))[State.X]), "the box of ego is 0.002 off"),
        (lambda r: replace(r, time=r.time[:-1], states=r.states[:-1]), " messages for "),
        (
            lambda r: replace(r, actors=(r.actors[0], replace(r.actors[1], name="x"))),
            "2 are in the message",
        ),
    ],
)
def test_a_film_of_another_run_is_found(
    worst: ExportCase, spoil: Callable[[Recording], Recording], said: str, tmp_path: Path
) -> None:
    """A box two millimetres off, a sample that is missing, somebody else."""
    (data,) = write_mcap(spoil(worst.recording), STEM).files.values()
    assert isinstance(data, bytes)
    (tmp_path / f"{STEM}.mcap").write_bytes(data)
    findings = list(FORMATS["mcap"].load_checker()(worst, tmp_path, [f"{STEM}.mcap"], ExportOptions()))
    assert any(said in finding.reason for finding in findings), findings[:3]
    assert all(finding.place.startswith(f"{STEM}.mcap") for finding in findings)


def test_a_broken_film_is_reported(worst: ExportCase, tmp_path: Path) -> None:
    """Without a traceback."""
    (data,) = write_mcap(worst.recording, STEM).files.values()
    assert isinstance(data, bytes)
    for spoilt in (b"", data[:200], data[:5000] + b"?" + data[5001:]):
        (tmp_path / f"{STEM}.mcap").write_bytes(spoilt)
        assert list(FORMATS["mcap"].load_checker()(worst, tmp_path, [f"{STEM}.mcap"], ExportOptions()))


def test_two_millimetres_are_found(worst: ExportCase, tmp_path: Path) -> None:
    """In the middle of the replay of one actor."""
    pattern = r'(?s)((?:.*?<WorldPosition x=")(?:.*?<WorldPosition x="){6})(-?[0-9.]+)'
    export = FORMATS["xosc"].writer(worst, STEM, ExportOptions())
    text = str(export.files[f"{STEM}.xosc"])
    found = re.match(pattern, text)
    assert found is not None
    findings = spoiled(worst, "xosc", tmp_path, f"{STEM}.xosc", pattern, rf"\g<1>{float(found[2]) + 0.002!r}")
    assert any(re.search(r"the place at [0-9.]+ s is 0.002 off", finding.reason) for finding in findings)

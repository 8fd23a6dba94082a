"""`--check` finds what was spoiled, and says where."""

import re
from pathlib import Path

import pytest

from cortex_dsl.exports.cases import ExportCase
from cortex_dsl.exports.findings import Finding
from cortex_dsl.exports.formats import checker_of, writer_of
from engine.interchange.export import ExportOptions

STEM = "left_turn-case01"


def spoiled(case: ExportCase, name: str, folder: Path, file: str, pattern: str, new: str) -> list[Finding]:
    """What the check says once the first match of a pattern in one of the files is replaced."""
    export = writer_of(name)(case, STEM, ExportOptions())
    for each, content in export.files.items():
        data = content if isinstance(content, bytes) else content.encode()
        if each == file:
            text, count = re.subn(pattern, new, data.decode(), count=1)
            assert count == 1
            data = text.encode()
        (folder / each).write_bytes(data)
    check = checker_of(name)
    assert check is not None
    return list(check(case, folder, list(export.files), ExportOptions()))


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
    "row": ("csv", ".csv", r"(\n[^\n]*,)[0-9.]+(,[^\n]*\n)", r"\g<1>0.5\g<2>", ""),
    "road link": ("xodr", ".xodr", r'elementId="\d+"', 'elementId="777"', "777, which is not there"),
    "lane": ("xodr", ".xodr", r'(<width [^>]*a=")3.5', r"\g<1>3.6", "m off"),
    "reference": ("commonroad", ".cr.xml", r' ref="\d+"', ' ref="987654"', "it refers to 987654"),
    "problem": ("commonroad", ".cr.xml", r"(?s)<planningProblem .*</planningProblem>", "", "no planningProblem"),
    "place": ("scenic", ".scenic", r"new Car at \(", "new Car at (0", "does not stand where the run began"),
    "scenario": ("scn", ".scn", r"EGO_SPEED +=", "EGO_SPEED = 1.5 *", "does not run to the same outcome"),
}


@pytest.mark.parametrize("what", SPOILED)
def test_it_is_found(worst: ExportCase, what: str, tmp_path: Path) -> None:
    """Each finding names its file, and what is wrong."""
    name, suffix, pattern, new, reason = SPOILED[what]
    file = "left_turn.xodr" if suffix == ".xodr" else f"{STEM}{suffix}"
    findings = spoiled(worst, name, tmp_path, file, pattern, new)
    assert any(reason in finding.reason for finding in findings), findings
    assert all(file in finding.place or finding.cure for finding in findings)


def test_two_millimetres_are_found(worst: ExportCase, tmp_path: Path) -> None:
    """In the middle of the replay of one actor."""
    pattern = r'(?s)((?:.*?<WorldPosition x=")(?:.*?<WorldPosition x="){6})(-?[0-9.]+)'
    export = writer_of("xosc")(worst, STEM, ExportOptions())
    text = str(export.files[f"{STEM}.xosc"])
    found = re.match(pattern, text)
    assert found is not None
    findings = spoiled(worst, "xosc", tmp_path, f"{STEM}.xosc", pattern, rf"\g<1>{float(found[2]) + 0.002!r}")
    assert any(re.search(r"the place at [0-9.]+ s is 0.002 off", finding.reason) for finding in findings)

"""`cortexc verify`, as a user meets it."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import cortex_dsl as cx
from cortex_dsl.report.findings.verification_report import ANSWERS
from engine.errors import CortexError

Command = Callable[..., Any]
pytestmark = pytest.mark.usefixtures("small_design")
NAMES = [name for name, _, _ in ANSWERS.values()]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("verify") / "run"
    scenario = Path(__file__).parents[3] / "examples" / "left_turn.scn"
    cx.search(scenario, "ga", generations=4, population=30, seed=1, out=folder)
    return folder


def test_every_case_has_an_answer_on_screens_of_any_width(cortexc: Command, run: Path) -> None:
    result = cortexc("verify", run, "--worst", 4)
    assert result.code == 0
    assert "4 cases driven again" in result.out
    assert any(name in result.out for name in NAMES)
    assert max(map(len, result.out.splitlines())) <= 100
    assert "\x1b" not in result.out


def test_the_document_and_the_interface_say_the_same(cortexc: Command, run: Path) -> None:
    found = cortexc("verify", run, "--worst", 3, "--json").document
    assert found["schema"] == "cortexc/verification"
    assert sum(found["answers"].values()) == len(found["cases"]) == 3
    again = cx.verify(run, 3)
    assert [ANSWERS[one.answer][0] for one in again.answers] == [case["answer"] for case in found["cases"]]
    assert repr(again).startswith("Verification(3 cases: ")
    for case in found["cases"]:
        assert case["sliding"] == ["ego", "adversary"]
        assert case["run"]["collided"] is True
        assert 0.0 <= case["run"]["combined_grip"] <= 1.0 + 1e-9


def test_the_page_shows_what_was_answered_or_that_it_might_be_asked(cortexc: Command, run: Path) -> None:
    (run / "verification.json").unlink(missing_ok=True)
    assert cortexc("report", run, "--cases", 2).code == 0
    page = (run / "report.html").read_text(encoding="utf-8")
    assert '"opinion": null' in page or '"opinion":null' in page
    assert cortexc("verify", run, "--worst", 2).code == 0
    kept = json.loads((run / "verification.json").read_text(encoding="utf-8"))
    assert cortexc("report", run, "--cases", 2).code == 0
    page = (run / "report.html").read_text(encoding="utf-8")
    for case in kept["cases"]:
        assert f">{case['answer']}</span>" in page


def test_answers_on_another_program_or_a_broken_file_are_passed_over(cortexc: Command, run: Path) -> None:
    for text in ("", "[]", '{"program": "other", "cases": []}', '{"program": 1}'):
        (run / "verification.json").write_text(text, encoding="utf-8")
        assert cortexc("report", run, "--cases", 1).code == 0
    (run / "verification.json").unlink()


def test_slips_have_a_cure(cortexc: Command, run: Path, tmp_path: Path) -> None:
    for words in (("verify",), ("verify", tmp_path), ("verify", run, "--worst", 0), ("verify", run, "--model", "x")):
        result = cortexc(*words)
        assert result.code == 2
        assert "help:" in result.err
    with pytest.raises(CortexError):
        cx.verify(run, 0)
    with pytest.raises(CortexError):
        cx.verify(run, model="static")

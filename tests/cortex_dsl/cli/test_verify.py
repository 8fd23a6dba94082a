"""`cortexc verify`, as a user meets it."""

import json
import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

import cortex_dsl as cx
from cortex_dsl.report.findings.verification_report import ANSWERS
from engine.errors import CortexError
from engine.search import chain
from engine.search.insight.kinds import collisions_of
from engine.search.store import JOURNAL
from tests.journals import unchain

Command = Callable[..., Any]
pytestmark = pytest.mark.usefixtures("small_design")
NAMES = [name for name, _, _ in ANSWERS.values()]


@pytest.fixture(scope="module")
def run(ga_run: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return shutil.copytree(ga_run, tmp_path_factory.mktemp("verify") / "run")


def copied(run: Path, to: Path, *statements: str, chained: bool = True) -> Path:
    """A copy of a run whose journal somebody changed; `chained`: with the digests of today."""
    folder = to / f"{run.name}-{len(list(to.iterdir()))}"
    folder.mkdir()
    shutil.copy(run / JOURNAL, folder)
    if not chained:
        unchain(folder / JOURNAL)
    with closing(sqlite3.connect(folder / JOURNAL)) as connection, connection:
        for statement in statements:
            assert connection.execute(statement).rowcount > 0
    return folder


def test_a_journal_proves_itself(cortexc: Command, run: Path) -> None:
    """Digests and a sample that is run again, in words, as a document, and from Python; nothing is written."""
    before = {path: path.stat().st_mtime_ns for path in run.rglob("*")}
    result = cortexc("verify", run, "--sample", 30)
    assert result.code == 0
    assert "the chain holds: 4 generations, " in result.out
    assert "30 of 30 simulations that were run again are the same, bit for bit" in result.out
    document = cortexc("verify", run, "--sample", 10**9, "--json").document
    found = cx.prove(run, 10**9)
    assert document["schema"] == "cortexc/proof"
    assert (document["proved"], document["again"], document["differ"]) == (True, found.simulations, [])
    assert (found.again, found.generations) == (found.simulations, 4)
    assert repr(found).startswith("Proof(proved: ")
    assert {path: path.stat().st_mtime_ns for path in run.rglob("*")} == before


def test_an_old_journal_is_unproved_and_its_simulations_tell(cortexc: Command, run: Path, tmp_path: Path) -> None:
    """Without digests a changed number passes every reader, and is found by running it again."""
    old = copied(run, tmp_path, chained=False)
    result = cortexc("verify", old)
    assert result.code == 0
    assert ", unproved" in result.out
    assert "unproved: an earlier version wrote this journal" in result.said
    assert "unproved" in repr(cx.prove(old, 5))
    worst = "UPDATE simulation SET lateral_grip = lateral_grip + 1e-9 WHERE score >= 10"
    result = cortexc("verify", copied(run, tmp_path, worst, chained=False), "--sample", 10**9)
    assert result.code == 2
    assert "gives another result when it is repeated" in result.said
    assert "help: restore it from a copy" in result.said
    version = "UPDATE manifest SET value = json_set(value, '$.numba', '9.0') WHERE field = 'versions'"
    result = cortexc("verify", copied(run, tmp_path, worst, version, chained=False), "--sample", 10**9)
    assert result.code == 0
    assert "as the run was made with numba 9.0" in result.out


def test_a_changed_journal_is_no_journal(cortexc: Command, run: Path, tmp_path: Path) -> None:
    """The generation that was changed is named."""
    result = cortexc("verify", copied(run, tmp_path, "UPDATE simulation SET end_time = 1.0 WHERE place = 3"))
    assert result.code == 2
    assert "is damaged: generation 0 is not what was written" in result.said


def test_every_case_has_an_answer_on_screens_of_any_width(cortexc: Command, run: Path) -> None:
    result = cortexc("verify", run, "--model", "dynamic", "--worst", 4)
    assert result.code == 0
    assert "4 cases driven again" in result.out
    assert any(name in result.out for name in NAMES)
    assert max(map(len, result.out.splitlines())) <= 100
    assert "\x1b" not in result.out


def test_the_document_and_the_interface_say_the_same(cortexc: Command, run: Path) -> None:
    found = cortexc("verify", run, "--model", "dynamic", "--worst", 3, "--json").document
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
    assert cortexc("verify", run, "--model", "dynamic", "--worst", 2).code == 0
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
    for words in (
        ("verify",),
        ("verify", tmp_path),
        ("verify", run, "--model", "dynamic", "--worst", 0),
        ("verify", run, "--model", "dynamic", "--sample", 5),
        ("verify", run, "--worst", 3),
        ("verify", run, "--model", "x"),
    ):
        result = cortexc(*words)
        assert result.code == 2
        assert "help:" in result.said
    with pytest.raises(CortexError):
        cx.verify(run, 0)
    with pytest.raises(CortexError):
        cx.prove(run, -1)
    with pytest.raises(CortexError):
        cx.verify(run, model="static")


def test_verdicts_on_collisions_are_those_of_the_reference_driver(cortexc: Command, run: Path, tmp_path: Path) -> None:
    """The journal has them, so that nobody drives again to show a run; `verify` does."""
    there = cx.open_run(run)
    stored, again = there.record.blame, there.blame_again
    assert stored is not None
    assert (stored.dtype, stored.tolist()) == (again.dtype, again.tolist())
    hit = collisions_of(there.record.evaluations)
    assert hit.any()
    bare = copied(run, tmp_path, "DELETE FROM blame")
    with closing(sqlite3.connect(bare / JOURNAL)) as connection, connection:
        connection.execute("DROP TABLE blame")
    assert cx.open_run(bare).record.blame is None
    assert cx.open_run(bare).blame.tolist() == stored.tolist()

    forged = copied(run, tmp_path)
    with closing(sqlite3.connect(forged / JOURNAL)) as connection, connection:
        row = chain.blame_row(bytes.fromhex(there.record.link), (stored[hit] + 1) % 3)
        connection.execute("UPDATE blame SET link = ?, verdicts = ?, digest = ?", row)
    result = cortexc("verify", forged, "--sample", 1)
    assert result.code == 2
    assert "the reference driver answers otherwise" in result.said

"""The files beside a journal are what follows from it, whatever was done to them, whenever the search was stopped."""

import errno
import json
import os
import random
import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

import engine.search.run
from cortex_dsl.api.derived_files import differing
from cortex_dsl.api.restoring import outdated, restore
from cortex_dsl.api.runs import open_run
from engine.search.chain import last_link
from engine.search.journal_reader import read_journal
from engine.search.store import StoreError
from engine.tables import Ints
from tests.folders import content, files
from tests.runs import SEARCH

Command = Callable[..., Any]
pytestmark = pytest.mark.usefixtures("small_design")


@pytest.fixture(scope="module")
def whole(ga_run: Path) -> Path:
    """A search that nothing stopped."""
    return ga_run


def test_files_carry_the_last_link_of_the_journal(whole: Path) -> None:
    """The summary and each case name the state of the journal from which they were made."""
    with closing(sqlite3.connect(whole / "journal.sqlite")) as connection:
        link = last_link(connection).hex()
    assert json.loads((whole / "summary.json").read_text())["journal"] == link
    for path in (whole / "worst").glob("*.scn"):
        assert f"# journal {link}\n" in path.read_text()


def flipped(content: bytes, chance: random.Random) -> bytes:
    place = chance.randrange(len(content))
    return bytes([*content[:place], content[place] ^ 1, *content[place + 1 :]])


@pytest.mark.parametrize("then", ["restore", "resume"])
def test_one_changed_byte_in_any_file_is_found(then: str, whole: Path, cortexc: Command, tmp_path: Path) -> None:
    """`verify` exits with 2 and names every changed file; `report` and `resume` write it again."""
    run, chance = shutil.copytree(whole, tmp_path / "run"), random.Random(then)
    right = files(run)
    assert len(right) > 10
    for name, before in right.items():
        changed = flipped(before, chance)
        (run / name).write_bytes(changed)
        others = {each: changed if each == name else content for each, content in right.items()}
        assert list(differing(whole, others)) == [name]
    found = cortexc("verify", run, "--sample", 0)
    assert found.code == 2
    assert all(f"`{run / name}`" in found.said for name in right)
    again(then, run, cortexc)
    assert files(run) == right
    assert cortexc("verify", run, "--sample", 0).code == 0


def again(then: str, run: Path, cortexc: Command) -> None:
    """Write the files of a run again: as `resume` does, or as `report` does beside its page."""
    if then == "resume":
        assert cortexc("resume", run).code == 0
    else:
        restore(open_run(run))


def test_missing_and_stale_files(whole: Path, cortexc: Command, tmp_path: Path) -> None:
    """A file that was removed, and a case that the search does not have, are differences too."""
    run = shutil.copytree(whole, tmp_path / "run")
    (run / "worst" / "02.scn").rename(run / "worst" / "77.scn")
    found = cortexc("verify", run, "--sample", 0)
    assert found.code == 2
    assert "worst/02.scn" in found.said
    assert "worst/77.scn" in found.said
    said = cortexc("report", run, "--cases", 0).said
    assert "written again from the journal: worst/02.scn, worst/77.scn" in said
    assert files(run) == files(whole)


def test_files_with_a_checksum(whole: Path, cortexc: Command, tmp_path: Path) -> None:
    """A page, an estimate and a second opinion: a changed byte is found, and so is a file of another run. One of an
    earlier state of the run is no damage.
    """
    run = shutil.copytree(whole, tmp_path / "run")
    for words in (("report", run, "--cases", 1), ("probability", run, "--samples", 100)):
        assert cortexc(*words).code == 0
    assert cortexc("verify", run, "--model", "dynamic", "--worst", 1).code == 0
    assert cortexc("verify", run, "--sample", 0, "--json").document["notes"] == []
    chance = random.Random(5)
    for name in ("report.html", "probability.json", "verification.json"):
        right = (run / name).read_bytes()
        (run / name).write_bytes(flipped(right, chance))
        found = cortexc("verify", run, "--sample", 0)
        assert found.code == 2, name
        assert f"`{run / name}` is changed" in found.said
        (run / name).write_bytes(right)
    assert "earlier state" not in cortexc("resume", run).said
    said = cortexc("resume", run, "--generations", 5).said
    notes = cortexc("verify", run, "--sample", 0, "--json").document["notes"]
    cures = (
        f"`cortexc report {run}` writes the page again",
        f"`cortexc verify {run} --model dynamic` asks for the second opinion again",
    )
    made = "was made from an earlier state of the journal"
    assert notes == [f"`{name}` {made}; {cure}" for name, cure in zip(OF_JOURNAL, cures, strict=True)]
    assert all(note in said for note in notes)
    other = shutil.copytree(whole, tmp_path / "other")
    for name in OF_JOURNAL:
        shutil.copy(run / name, other)
    assert cortexc("resume", run, "--generations", 6).code == 0
    assert cortexc("report", run).code == 0
    shutil.copy(run / "report.html", other)
    found = cortexc("verify", other, "--sample", 0)
    assert found.code == 2
    assert f"`{other / 'report.html'}` was made from another journal" in found.said


def test_a_page_without_a_place_is_refused_before_it_is_computed(
    whole: Path, cortexc: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The page of a run takes minutes: a folder that may not be written is named at once."""
    run = shutil.copytree(whole, tmp_path / "run")
    monkeypatch.setattr("cortex_dsl.report.page.run_page.run_page", None)
    monkeypatch.setattr("cortex_dsl.console.user_files.os.access", lambda place, _: Path(place) != run)
    refused = cortexc("report", run)
    assert refused.code == 2
    assert f"cannot write `{run / 'report.html'}`: `{run}` is not writable" in refused.said
    assert "--out FILE.html" in refused.said


OF_JOURNAL = ("report.html", "verification.json")


def test_files_of_a_study(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """`verify` finds a changed byte in each table, and `report` and `resume` write it again; a page of an earlier state
    is no damage.
    """
    study, chance = tmp_path / "study", random.Random(6)
    size = ("--runs", 2, "--generations", 2, "--population", 6, "--jobs", 1)
    assert cortexc("study", left_turn, *size, "--out", study).code == 0
    right = files(study)
    assert len(right) == 4
    for again in ("report", "resume"):
        for name, before in right.items():
            (study / name).write_bytes(flipped(before, chance))
        found = cortexc("verify", study)
        assert found.code == 2
        assert all(f"`{study / name}` is changed" in found.said for name in right)
        assert cortexc(again, study).code == 0
        assert files(study) == right
    page = (study / "report.html").read_bytes()
    assert "earlier state" not in cortexc("resume", study).said
    assert "5 files beside the study follow from it" in cortexc("verify", study).out
    (study / "report.html").write_bytes(flipped(page, chance))
    assert cortexc("verify", study).code == 2


@pytest.fixture(params=["blamed", "probe_genes"])
def interrupting(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """Ctrl-C while collisions are judged, or while genes are probed."""
    real = getattr(engine.search.run, request.param)

    def interrupted(*given: Any) -> Ints:
        if given[-1] is None:  # nobody is asked: no analysis
            return real(*given)
        raise KeyboardInterrupt

    monkeypatch.setattr(engine.search.run, request.param, interrupted)
    return monkeypatch


@pytest.mark.parametrize("then", ["resume", "restore"])
def test_an_interrupted_analysis(
    then: str, interrupting: pytest.MonkeyPatch, cortexc: Command, left_turn: Path, whole: Path, tmp_path: Path
) -> None:
    """The command says so and exits with 130; what was not computed is null; `resume` and `report` compute it.

    The folder lies beside the whole one, so that both name the scenario by the same way.
    """
    run = whole.parent / f"{tmp_path.parent.name}-{tmp_path.name}"
    stopped = cortexc(left_turn, *SEARCH, "--out", run)
    assert stopped.code == 130
    assert "interrupted" in stopped.out
    assert "avoidable" not in stopped.out.split("\n\n")[0]
    assert read_journal(run / "journal.sqlite").status == "interrupted"
    summary = json.loads((run / "summary.json").read_text())
    failures = summary["failures"]
    assert failures["collisions"] == failures["unknown"] > 0
    for name in ("avoidable", "struck", "kinds", "avoidable_kinds", "avoidable_share"):
        assert failures[name] is None
    assert summary["kinds"] is failures["per_second"]["avoidable"] is None
    assert [(gene["dead"], gene["changed"], gene["effect"]) for gene in summary["genes"]] == [(None,) * 3] * 7
    interrupting.undo()
    assert cortexc("verify", run, "--sample", 0).code == 0
    again(then, run, cortexc)
    assert content(run) == content(whole)


@pytest.mark.parametrize("words", [("verify", "--sample", 0), ("report",), ("resume",)], ids=lambda words: words[0])
def test_an_interrupted_repetition_of_the_analysis(
    words: tuple[object, ...], whole: Path, interrupting: pytest.MonkeyPatch, cortexc: Command, tmp_path: Path
) -> None:
    """Ctrl-C while a finished run is analysed again ends the command: it is no damage, and no file is replaced."""
    assert interrupting is not None
    run = shutil.copytree(whole, tmp_path / "run")
    (run / "summary.json").write_bytes(flipped((run / "summary.json").read_bytes(), random.Random(7)))
    before = files(run)
    command, *options = words
    assert cortexc(command, run, *options).code == 130
    assert files(run) == before


def test_a_file_is_replaced_as_a_whole(whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A full disk leaves every file as it was, and nothing beside it."""

    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    run = shutil.copytree(whole, tmp_path / "run")
    for name, right in files(run).items():
        (run / name).write_bytes(flipped(right, random.Random(name)))
    before = files(run)
    names = {path.name for path in run.rglob("*")}
    monkeypatch.setattr("engine.atomic.os.fsync", full)
    with pytest.raises(StoreError):
        restore(open_run(run))
    assert files(run) == before
    assert {path.name for path in run.rglob("*")} - {".lock"} == names - {".lock"}


def test_links_that_are_known_are_not_read_again(tmp_path: Path) -> None:
    """A command that has read the journal gives its links; nothing but the page is read then."""
    (tmp_path / "report.html").write_text("a page without a checksum")
    assert outdated(tmp_path, ("00",)) == []
    with pytest.raises(StoreError):
        outdated(tmp_path)

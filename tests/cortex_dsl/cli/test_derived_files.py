"""The files beside a journal are what follows from it, whatever was done to them, whenever the search was stopped."""

import json
import os
import random
import shutil
import signal
import sqlite3
import time
from collections.abc import Callable, Mapping
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import pytest

import engine.search.run
from cortex_dsl.api.derived_files import differing
from cortex_dsl.api.restoring import restore
from cortex_dsl.api.runs import open_run
from engine.search.chain import last_link
from engine.search.journal_reader import read_journal
from engine.tables import Ints
from tests.fork_server import RUN, ForkServer
from tests.laws import share

Command = Callable[..., Any]
SEARCH = ("--ga", "--generations", 4, "--population", 30, "--seed", 2, "--jobs", 1)
MADE_BY_SEARCH = (".csv", ".jsonl", ".json", ".md", ".scn")
OF_TIME = ("seconds", "per_second", "elapsed")


def files(run: Path) -> Mapping[str, bytes]:
    """Every file that follows from the journal, and what it holds."""
    return {str(path.relative_to(run)): path.read_bytes() for path in run.rglob("*") if path.suffix in MADE_BY_SEARCH}


def content(run: Path) -> Mapping[str, Any]:
    """Every file of a run without the time that it took; of the journal, all tables but those of time."""
    found: dict[str, Any] = dict(files(run))
    found["summary.json"] = timeless(json.loads(found["summary.json"]))
    with closing(sqlite3.connect(run / "journal.sqlite")) as connection:
        for table in ("manifest", "generation", "individual", "simulation"):
            found[table] = connection.execute(f"SELECT * FROM {table}").fetchall()
    found["manifest"] = [row for row in found["manifest"] if row[0] not in ("command_line", "started")]
    found["status"] = read_journal(run / "journal.sqlite").status
    return found


def timeless(value: Any) -> Any:
    """A document without times and without the command line."""
    if isinstance(value, dict):
        left_out = (*OF_TIME, "command_line", "started")
        return {name: timeless(each) for name, each in value.items() if name not in left_out}
    return [timeless(each) for each in value] if isinstance(value, list) else value


@pytest.fixture(scope="module")
def whole(command_server: ForkServer, left_turn: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A search that nothing stopped."""
    run = tmp_path_factory.mktemp("whole") / "run"
    assert command_server.run(RUN, left_turn, *SEARCH, "--out", run).status == 0
    return run


def test_files_carry_the_last_link_of_the_journal(whole: Path) -> None:
    """The summary and each case name the state of the journal from which they were made."""
    with closing(sqlite3.connect(whole / "journal.sqlite")) as connection:
        link = last_link(connection).hex()
    assert json.loads((whole / "summary.json").read_text())["journal"] == link
    for path in (whole / "worst").glob("*.scn"):
        assert f"# journal {link}\n" in path.read_text()


@pytest.mark.parametrize("then", ["restore", "resume"])
def test_one_changed_byte_in_any_file_is_found(then: str, whole: Path, cortexc: Command, tmp_path: Path) -> None:
    """`verify` exits with 2 and names every changed file; `report` and `resume` write it again."""
    run, chance = shutil.copytree(whole, tmp_path / "run"), random.Random(then)
    right = files(run)
    assert len(right) > 10
    for name, before in right.items():
        place = chance.randrange(len(before))
        changed = bytes([*before[:place], before[place] ^ 1, *before[place + 1 :]])
        (run / name).write_bytes(changed)
        others = {each: changed if each == name else content for each, content in right.items()}
        assert differing(whole, others) == [name]
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
    """The command says so and exits with 130; what was not computed is null; `resume` and `report` compute it."""
    run = tmp_path / "run"
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


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_stopped_at_any_instant(
    number: signal.Signals, command_server: ForkServer, left_turn: Path, whole: Path, tmp_path: Path
) -> None:
    """A signal is never lost: the command exits with its code, and what `resume` leaves is what an unstopped search
    leaves, in every file.
    """
    begin = time.perf_counter()
    assert command_server.run(RUN, left_turn, *SEARCH, "--out", tmp_path / "timed").status == 0
    long, chance, expected = time.perf_counter() - begin, random.Random(int(number)), content(whole)
    for count in range(share(20)):
        run = tmp_path / str(count)
        process = command_server.start(RUN, left_turn, *SEARCH, "--out", run)
        time.sleep(chance.uniform(0.0, 1.1 * long))
        with suppress(ProcessLookupError):  # it has ended already
            os.kill(process.pid, number)
        ended = process.end()
        came_late = ended.status == 0
        assert ended.status in (0, 128 + number, -number), ended
        assert not came_late or read_journal(run / "journal.sqlite").status == "finished"
        assert "Traceback" not in ended.err
        assert "ignored" not in ended.err
        if not (run / "journal.sqlite").exists():  # it had not begun
            continue
        resumed = command_server.run(RUN, "resume", run)
        assert resumed.status == 0, resumed
        assert content(run) == expected
        shutil.rmtree(run)

"""A run that was cut off goes on to the journal that an undisturbed one would have written."""

import sqlite3
import subprocess
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from engine.assessment import Evaluate
from engine.config import Config, SearchConfig
from engine.program import ParamSpace
from engine.search.campaign import Campaign, Progress
from engine.search.evaluations import Evaluations
from engine.search.journal import Journal
from engine.search.journal_reader import read_journal
from engine.search.manifest import Manifest
from engine.search.past import ForeignPastError
from engine.search.protocol import Box
from engine.search.run import Past, Task, run_campaign
from engine.search.searchers import SEARCHERS, build_searcher
from engine.search.store import JOURNAL, StoreError, hold
from tests.journals import unchain

CONFIG = SearchConfig(generations=6, population=20, seed=11, rollouts=2, aggregate="q90")
RESULTS = ("generation", "individual", "simulation")
HOLDER = """
import sys
from pathlib import Path
from engine.search.store import hold
with hold(Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.read()
"""


class Cut(Exception):  # noqa: N818 - what happens, not an error
    """Stands for whatever ends a process between two generations."""


def search(
    space: ParamSpace, evaluate: Evaluate, journal: Journal, method: str, stop_after: int, past: list[Evaluations]
) -> Campaign:
    def write(progress: Progress) -> None:
        if progress.generation == stop_after:
            raise Cut
        journal.write(progress)

    searcher = build_searcher(method, Box.of(space), Config(search=CONFIG))
    return run_campaign(Task(space, evaluate, CONFIG, method, "cortex"), searcher, write, past=Past(past))


def results_of(path: Path) -> list[list[Any]]:
    with closing(sqlite3.connect(path)) as connection:
        return [connection.execute(f"SELECT * FROM {table}").fetchall() for table in RESULTS]


@pytest.fixture
def evaluate(space: ParamSpace, evaluators: Callable[..., Evaluate]) -> Evaluate:
    return evaluators(space, error_above=0.95)


@pytest.mark.parametrize("method", list(SEARCHERS))
@pytest.mark.parametrize("written", [0, 1, 4, 6])
def test_resumed_journal_equals_the_undisturbed_one(
    tmp_path: Path,
    space: ParamSpace,
    evaluate: Evaluate,
    manifests: Callable[..., Manifest],
    method: str,
    written: int,
) -> None:
    """Wherever a run is cut, its three tables of results end up equal, row by row."""
    manifest = manifests(space, CONFIG, method)
    whole = Journal.create(tmp_path / "whole.sqlite", manifest)
    found = search(space, evaluate, whole, method, -1, [])
    whole.finish(found)

    first = Journal.create(tmp_path / "cut.sqlite", manifest)
    if written < CONFIG.generations:
        with pytest.raises(Cut):
            search(space, evaluate, first, method, written, [])
    else:
        search(space, evaluate, first, method, -1, [])
    first.close()
    past = read_journal(tmp_path / "cut.sqlite").past()
    assert len(past) == written
    again = Journal.reopen(tmp_path / "cut.sqlite")
    again.finish(search(space, evaluate, again, method, -1, past))

    assert results_of(tmp_path / "cut.sqlite") == results_of(tmp_path / "whole.sqlite")
    assert read_journal(tmp_path / "cut.sqlite").status == "finished"


def test_only_new_generations_are_simulated(
    tmp_path: Path, space: ParamSpace, evaluate: Evaluate, manifests: Callable[..., Manifest]
) -> None:
    """What the journal holds is passed to the searcher, not run again."""
    journal = Journal.create(tmp_path / JOURNAL, manifests(space, CONFIG, "random"))
    with pytest.raises(Cut):
        search(space, evaluate, journal, "random", 4, [])
    simulated: list[int] = []

    def counted(genomes: Any, keys: Any) -> Any:
        simulated.append(int(keys[0, 3]))
        return evaluate(genomes, keys)

    past = read_journal(tmp_path / JOURNAL).past()
    search(space, counted, journal, "random", -1, past)
    assert simulated[:2] == [4, 5]


def test_past_of_another_seed_is_refused(
    tmp_path: Path, space: ParamSpace, evaluate: Evaluate, manifests: Callable[..., Manifest]
) -> None:
    """A journal that its searcher would not have written is never continued."""
    journal = Journal.create(tmp_path / JOURNAL, manifests(space, CONFIG, "ga"))
    search(space, evaluate, journal, "ga", -1, [])
    past = read_journal(tmp_path / JOURNAL).past()
    other = build_searcher("ga", Box.of(space), Config(search=SearchConfig(seed=12, population=20)))
    with pytest.raises(ForeignPastError):
        run_campaign(Task(space, evaluate, CONFIG, "ga"), other, past=Past(past))


def test_one_process_at_a_time(tmp_path: Path) -> None:
    """A run that another process writes cannot be written; once that process is killed, it can."""
    command = [sys.executable, "-c", HOLDER, str(tmp_path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "held\n"
        with pytest.raises(StoreError, match="another process"), hold(tmp_path):
            pass
        other.kill()
    with hold(tmp_path):
        pass


@pytest.mark.parametrize(
    "damage",
    [
        "UPDATE individual SET genome = x'00'",
        "UPDATE simulation SET counts = x'0011'",
        "DELETE FROM simulation WHERE place = 3",
        "DELETE FROM manifest WHERE field = 'seed'",
        "UPDATE manifest SET value = '{' WHERE field = 'settings'",
        "DELETE FROM status",
        "UPDATE generation SET figures = '[]'",
        "UPDATE status SET status = x'ff'",
        "UPDATE status SET seconds = 'long'",
        "DROP TABLE pace",
    ],
)
@pytest.mark.parametrize("chained", [True, False])
def test_damaged_contents_are_a_clear_error(
    tmp_path: Path,
    space: ParamSpace,
    evaluate: Evaluate,
    manifests: Callable[..., Manifest],
    damage: str,
    chained: bool,
) -> None:
    """A journal of ours whose contents do not fit together is refused with a reason, or still reads in full."""
    journal = Journal.create(tmp_path / JOURNAL, manifests(space, CONFIG, "ga"))
    journal.finish(search(space, evaluate, journal, "ga", -1, []))
    if not chained:
        unchain(tmp_path / JOURNAL)
    with closing(sqlite3.connect(tmp_path / JOURNAL)) as connection:
        connection.execute(damage)
        connection.commit()
    if damage == "DROP TABLE pace" and not chained:
        assert len(read_journal(tmp_path / JOURNAL).generations) == CONFIG.generations
        return
    with pytest.raises(StoreError) as caught:
        read_journal(tmp_path / JOURNAL)
    assert "journal" in caught.value.message
    assert "restore it from a copy" in caught.value.cure

"""A journal tells whether it is what was written."""

import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks import corruptions
from engine.assessment import Evaluate
from engine.config import SearchConfig
from engine.program import ParamSpace
from engine.search.campaign import Progress
from engine.search.chain import last_link
from engine.search.journal import Journal
from engine.search.journal_reader import read_journal
from engine.search.manifest import Manifest
from engine.search.store import JOURNAL, StoreError
from tests.engine.search.test_store import CONFIG, run
from tests.journals import unchain

OLD = Path(__file__).parent / "journals" / "version_2.sqlite"
"""Kept from before there were chains: three generations of six, two rollouts each, of an example."""
GENOME = "eaa0c5f49c544a408f9d3e14945a424098a7865dfeeece3f"
"""The beginning of its first, in hexadecimal digits."""
SUMS = (187, 7)
"""Of risks and of collisions in it."""

Manifests = Callable[..., Manifest]


@pytest.fixture
def journal(tmp_path: Path, space: ParamSpace, evaluators: Callable[..., Evaluate], manifests: Manifests) -> Path:
    """A small finished search, with two actions of a controller."""
    path = tmp_path / JOURNAL
    written = Journal.create(path, manifests(space, CONFIG))
    found = run(space, evaluators(space), on_generation=written.write)
    written.keep({b"one": np.ones((2, 3)), b"two": np.zeros((1, 3))})
    written.keep({b"two": np.full((1, 3), -1.5)})
    written.finish(found)
    return path


def execute(path: Path, statement: str) -> None:
    with closing(sqlite3.connect(path)) as connection, connection:
        assert connection.execute(statement).rowcount != 0, statement


@pytest.mark.parametrize(
    ("change", "place"),
    [
        ("UPDATE individual SET fitness = fitness + 1e-12 WHERE generation = 2 AND place = 3", "generation 2"),
        ("UPDATE individual SET operator = 5 WHERE generation = 0 AND place = 1", "generation 0"),
        ("UPDATE simulation SET end_time = 1.25 WHERE generation = 3 AND place = 19", "generation 3"),
        ("UPDATE simulation SET min_distance = 0.5 WHERE generation = 1", "generation 1"),
        ("UPDATE simulation SET score = 0.5 WHERE generation = 1", "fit together"),
        ("UPDATE generation SET figures = replace(figures, '1', '2') WHERE generation = 4", "generation 4"),
        ("UPDATE generation SET link = zeroblob(32) WHERE generation = 1", "generation 1"),
        ("UPDATE generation SET generation = 7 WHERE generation = 4", "its generations"),
        ("UPDATE pace SET seconds = seconds + 1 WHERE generation = 0", "`pace`"),
        ("DELETE FROM pace WHERE generation = 4", "`pace`"),
        ("UPDATE status SET status = 'stopped'", "`status`"),
        ("UPDATE status SET seconds = NULL", "`status`"),
        ("UPDATE status SET seal = zeroblob(64)", "`manifest` and `status` and `pace`"),
        ("UPDATE status SET seal = 'soon'", "`status`"),
        ("UPDATE manifest SET value = '\"other.scn\"' WHERE field = 'file'", "`manifest`"),
        ("INSERT INTO manifest VALUES ('objective', '[\"risk\"]')", "`manifest`"),
        ("DELETE FROM action WHERE key = CAST('one' AS BLOB)", "`action`"),
        ("UPDATE action SET turns = 3, numbers = 2 WHERE key = CAST('one' AS BLOB)", "`action`"),
        ("PRAGMA user_version = 2", "its version"),
    ],
)
def test_every_change_has_its_place(journal: Path, change: str, place: str) -> None:
    """What is read is what was written, or is refused with the place that was changed."""
    assert read_journal(journal).proved
    execute(journal, change)
    with pytest.raises(StoreError, match=place) as caught:
        read_journal(journal)
    assert "is damaged" in caught.value.message


def test_no_corruption_passes_in_silence(journal: Path) -> None:
    """A small run of `benchmarks.corruptions`: what is read is what was written, or nothing is."""
    found = corruptions.corrupted([journal], 140, 5)
    outcomes = {outcome: sum(found[kind, outcome] for kind in corruptions.KINDS) for outcome in corruptions.OUTCOMES}
    assert (outcomes["silent"], outcomes["broken"]) == (0, 0)
    assert outcomes["refused"] > 90


def test_the_last_generation_is_not_taken_away_unseen(journal: Path) -> None:
    """A journal that ends earlier, with all of its tables in accord, is another one."""
    for table in ("generation", "individual", "simulation", "pace"):
        execute(journal, f"DELETE FROM {table} WHERE generation = 4")
    with pytest.raises(StoreError, match="`status` and `pace`"):
        read_journal(journal)


def test_equal_searches_end_in_equal_links(
    tmp_path: Path, space: ParamSpace, evaluators: Callable[..., Evaluate], manifests: Manifests
) -> None:
    """A link is of what was found alone: neither of the time it took nor of how the search was asked for."""
    links: list[bytes] = []
    for name, words in (("a", "cortexc"), ("b", "python")):
        manifest = replace(manifests(space, CONFIG), command_line=(words,))
        written = Journal.create(tmp_path / name, manifest)
        written.finish(run(space, evaluators(space), on_generation=written.write))
        with closing(sqlite3.connect(tmp_path / name)) as connection:
            links.append(last_link(connection))
    assert links[0] == links[1] != b""


def test_a_longer_run_is_sealed_again(
    tmp_path: Path, space: ParamSpace, evaluators: Callable[..., Evaluate], manifests: Manifests
) -> None:
    """Going on with a journal, also with another manifest, leaves one that is proved; an old one stays unproved."""
    for chained in (True, False):
        path = tmp_path / f"{chained}.sqlite"
        short = replace(CONFIG, generations=2)
        written = Journal.create(path, manifests(space, short))
        written.finish(run(space, evaluators(space), short, written.write))
        if not chained:
            unchain(path)
        again = Journal.reopen(path, manifests(space, CONFIG))
        assert read_journal(path).proved is chained

        def write(done: Progress, to: Journal = again) -> None:
            if done.generation > 1:
                to.write(done)

        longer = run(space, evaluators(space), CONFIG, write)
        again.finish(longer)
        record = read_journal(path)
        assert (record.proved, len(record.generations), record.status) == (chained, 5, "finished")


def test_numbers_that_sqlite_keeps_otherwise(
    tmp_path: Path, space: ParamSpace, manifests: Manifests, rows: Callable[..., object]
) -> None:
    """-0.0 comes back as 0.0, and NaN without its sign: the chain takes them as the same."""
    config = SearchConfig(generations=1, population=6, probes=0)
    values = np.array([-0.0, 0.0, -np.nan, 1e300, -5e-324, 2.0])

    def evaluate(_: object, keys: object) -> object:
        return rows(np.zeros(len(keys), dtype=np.int32), np.resize(values, len(keys)))  # type: ignore[arg-type]

    written = Journal.create(tmp_path / JOURNAL, manifests(space, config))
    written.finish(run(space, evaluate, config, written.write))  # type: ignore[arg-type]
    assert read_journal(tmp_path / JOURNAL).proved


def test_a_kept_journal_of_version_2(tmp_path: Path) -> None:
    """It reads as it did, as one that nothing is proved of."""
    record = read_journal(Path(shutil.copy(OLD, tmp_path)))
    assert (record.proved, record.status, record.manifest.method) == (False, "finished", "ga")
    evaluations = record.evaluations
    assert (len(evaluations), evaluations.rollouts.verdict.shape, len(record.generations)) == (18, (18, 2), 3)
    assert evaluations.genomes[0].tobytes().hex().startswith(GENOME)
    assert (int(evaluations.rollouts.score.sum()), int(evaluations.rollouts.collided.sum())) == SUMS


def test_a_file_of_version_2_with_links_is_none(tmp_path: Path) -> None:
    """One byte is enough to take a journal for an old one: then its tables tell."""
    path = Path(shutil.copy(OLD, tmp_path))
    execute(path, "PRAGMA user_version = 3")
    with pytest.raises(StoreError, match="its version is not that of its tables"):
        read_journal(path)

"""A search survives whatever ends its process: what `cortexc resume` leaves is what an undisturbed search leaves."""

import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import cortex_dsl.api.run_folder
import engine.search.run
from cortex_dsl import load
from cortex_dsl.api.run_folder import SearchOptions, search_and_keep
from engine.search import chain, journal_reader
from engine.search.campaign import Progress
from engine.search.insight.kinds import collisions_of
from engine.search.journal import WITHOUT_CHAIN
from engine.search.journal_reader import read_journal
from engine.search.store import RemovedError
from tests.fork_server import RUN, Ended, ForkServer
from tests.journals import unchain

pytestmark = pytest.mark.usefixtures("small_design")
RESULTS = ("generation", "individual", "simulation")
GENERATIONS = 24
SEARCH = ("--ga", "--generations", GENERATIONS, "--population", 40, "--seed", 3, "--jobs", 1)
SMALL = ("--generations", 4, "--population", 10, "--jobs", 1)
KILLS = (
    ("COMMIT", 1, 0),  # while the journal is taken up again
    ("INSERT INTO individual", 17, 0),
    ("COMMIT", 3, 1),
    ("INSERT INTO simulation", 5, 1),
    ("BEGIN IMMEDIATE", 5, 4),
    ("INSERT INTO generation", 4, 7),
    ("INSERT INTO pace", 3, 9),
    ("COMMIT", 6, 13),
    ("INSERT INTO individual", 100, 15),
    ("INSERT INTO generation", 5, 19),
    ("evaluations.csv", 1, GENERATIONS),
    ("generations.csv", 1, GENERATIONS),
    ("worst/02.scn", 1, GENERATIONS),
    ("UPDATE status", 2, GENERATIONS),  # the first one says `running`, this one `finished`
)
"""Statement, or file that is moved to its place, before which `resume` is killed, the how many-th, and the generations
that are written by then.
"""
IN_NAMESPACE = ["unshare", "--user", "--map-root-user", "--mount", "sh", "-ec"]

Command = Callable[..., Any]


def tables(run: Path) -> dict[str, list[Any]]:
    """The three tables of results, row by row."""
    with closing(sqlite3.connect(run / "journal.sqlite")) as connection:
        return {table: connection.execute(f"SELECT * FROM {table}").fetchall() for table in RESULTS}


def written(run: Path) -> int:
    """Generations that the journal holds; -1 while there is no journal."""
    try:
        with closing(sqlite3.connect(f"file:{run / 'journal.sqlite'}?mode=ro", uri=True)) as connection:
            return connection.execute("SELECT count(*) FROM generation").fetchone()[0]
    except sqlite3.Error:
        return -1


@contextmanager
def begun(
    server: ForkServer, *arguments: object, begins: Callable[[], bool], number: int = signal.SIGKILL
) -> Iterator[list[Ended]]:
    """A command that would go on for hours, once something is so; it ends by a signal, and what it left is listed."""
    process, left = server.start(RUN, *arguments), list[Ended]()
    try:
        while not begins():
            assert process.is_running(), server.said[1].read_text(encoding="utf-8")
            time.sleep(0.005)
        yield left
    finally:
        with suppress(ProcessLookupError):
            os.kill(process.pid, number)
        left.append(process.end())


DYING = """
import os, signal, sqlite3, sys

moment, left = sys.argv[1], int(sys.argv[2])

def reached(it_is):
    global left
    left -= it_is
    if it_is and left == 0:
        os.kill(os.getpid(), signal.SIGKILL)

def connect(*arguments, connect=sqlite3.connect, **options):
    connection = connect(*arguments, **options)
    connection.set_trace_callback(lambda statement: reached(left > 0 and statement.startswith(moment)))
    return connection

sqlite3.connect = connect
sys.addaudithook(
    lambda event, values: reached(left > 0 and event == "os.rename" and str(values[1]).endswith(moment))
)
sys.exit(main(sys.argv[3:]))
"""
"""A command that is killed before its n-th statement of a kind, or before it moves a file to its place."""
Kill = Callable[..., None]


@pytest.fixture(scope="module")
def kill(command_server: ForkServer) -> Kill:
    """Run a command to a moment that the journal or the folder of its run knows, and no further."""

    def run(moment: str, count: int, *arguments: object) -> None:
        done = command_server.run(DYING, moment, count, *arguments)
        assert done.status == -signal.SIGKILL, (moment, count, done.err)

    return run


def in_namespace(script: str, *arguments: object) -> "subprocess.CompletedProcess[str]":
    """Run a script that may mount things which nobody else sees; skip where the system does not allow that."""
    if shutil.which("unshare") is None or subprocess.run([*IN_NAMESPACE, "true"], check=False).returncode:
        pytest.skip("needs a user namespace of its own")
    command = [*IN_NAMESPACE, script, "sh", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


@pytest.fixture(scope="module")
def cut_off(kill: Kill, left_turn: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that was killed after some generations."""
    run = tmp_path_factory.mktemp("cut_off") / "run"
    kill("INSERT INTO generation", 4, left_turn, *SEARCH, "--out", run)
    return run


@pytest.fixture
def killed(cut_off: Path, tmp_path: Path) -> Path:
    """A copy of it, to do with as one likes."""
    return shutil.copytree(cut_off, tmp_path / "killed")


def test_killed_at_many_moments(cortexc: Command, kill: Kill, left_turn: Path, tmp_path: Path) -> None:
    """Fifteen times SIGKILL: before and in the first generation, all along, while tables and worst cases are written.
    Journal, tables and worst cases end up as those of a search that nobody disturbed.
    """
    assert cortexc(left_turn, *SEARCH, "--out", tmp_path / "whole").code == 0
    run = tmp_path / "killed"
    kill("COMMIT", 2, left_turn, *SEARCH, "--out", run)
    assert written(run) == 0
    for moment, count, generations in KILLS:
        kill(moment, count, "resume", run)
        assert written(run) == generations, moment
        assert read_journal(run / "journal.sqlite").status == "running"

    assert cortexc("resume", run).code == 0
    assert tables(run) == tables(tmp_path / "whole")
    assert read_journal(run / "journal.sqlite").status == "finished"
    for path in (tmp_path / "whole").rglob("*"):
        if path.suffix in (".csv", ".jsonl", ".scn", ".md"):
            assert (run / path.relative_to(tmp_path / "whole")).read_bytes() == path.read_bytes(), path.name


def test_killed_before_there_is_a_journal(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """What is left of a search that was ended at once is said to be no run, and does not stand in the way of one."""
    run = tmp_path / "run"
    run.mkdir()
    (run / "journal.sqlite.new").write_bytes(b"half a journal")
    (run / "journal.sqlite.new-journal").write_bytes(b"and how to take it back")
    (run / ".lock").touch()
    (run / ".write-test").touch()
    result = cortexc("resume", run)
    assert result.code == 2
    assert "there is no journal" in result.said
    assert "start that search again" in result.said
    assert cortexc(left_turn, "--random", *SMALL, "--out", run).code == 0
    assert not [*run.glob("*.new*"), *run.glob(".write-test")]


def test_a_stopped_run_goes_on(left_turn: Path, cortexc: Command, command_server: ForkServer, tmp_path: Path) -> None:
    """Ctrl-C, then `resume`: the same journal as without."""
    run, size = tmp_path / "stopped", ("--ga", "--population", 40, "--seed", 3, "--jobs", 1)
    words = (left_turn, *size, "--generations", 60000, "--out", run)
    with begun(command_server, *words, begins=lambda: written(run) >= 2, number=signal.SIGINT) as left:
        pass
    assert left[0].status == 130
    assert read_journal(run / "journal.sqlite").status == "stopped"
    longer = ("--generations", written(run) + 3)
    result = cortexc("resume", run, "--jobs", 2, *longer)
    assert result.code == 0
    assert "going on after generation" in result.said
    cortexc(left_turn, *size, *longer, "--out", tmp_path / "whole")
    assert tables(run) == tables(tmp_path / "whole")


def test_a_finished_run_shows_its_report_again(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """Nothing is written, and the report and the document are those of the search."""
    run = tmp_path / "run"
    first = cortexc(left_turn, "--ga", *SMALL, "--out", run)
    before = {path: path.stat().st_mtime_ns for path in run.rglob("*")}
    again = cortexc("resume", run)
    assert again.code == 0
    assert again.out == first.out
    assert "finished already" in again.said
    assert {path: path.stat().st_mtime_ns for path in run.rglob("*")} == before
    (search,) = cortexc("resume", run, "--json").document["searches"]
    assert (search["method"], search["generations"], search["stopped"]) == ("ga", 4, False)


@pytest.mark.parametrize("method", ["ga", "sobol", "niching", "cmaes", "nsga2", "cma_me"])
def test_a_finished_run_can_become_longer(cortexc: Command, left_turn: Path, tmp_path: Path, method: str) -> None:
    """A run of more generations begins with the shorter one: made longer, they are equal."""
    size = ("--population", 10, "--jobs", 1)
    cortexc(left_turn, "--method", method, *size, "--generations", 3, "--out", tmp_path / "short")
    result = cortexc("resume", tmp_path / "short", "--generations", 6)
    assert result.code == 0
    cortexc(left_turn, "--method", method, *size, "--generations", 6, "--out", tmp_path / "long")
    assert tables(tmp_path / "short") == tables(tmp_path / "long")
    settings = read_journal(tmp_path / "short" / "journal.sqlite").manifest.settings
    assert settings["search"]["generations"] == 6


def test_a_run_cannot_become_shorter(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """`resume` refuses fewer generations than the run has."""
    cortexc(left_turn, "--random", *SMALL, "--out", tmp_path / "random")
    refused = cortexc("resume", tmp_path / "random", "--generations", 3)
    assert refused.code == 2
    assert "has 4 generations already" in refused.said


def test_an_edited_scenario(cortexc: Command, scenario: Callable[..., Path], tmp_path: Path) -> None:
    """The run goes on with the text it was started with, and says so; imports and `-p` are those of then, too."""
    path = scenario("terminate after 20 s", "from beside import LIMIT\nterminate after LIMIT")
    (path.parent / "beside.scn").write_text("LIMIT = 3 s\n")
    arguments = ("--random", "--population", 10, "--jobs", 1, "-p", "EGO_SPEED=50 km/h")
    run = tmp_path / "run"
    assert cortexc(path, *arguments, "--generations", 2, "--out", run).code == 0
    assert cortexc(path, *arguments, "--generations", 4, "--out", tmp_path / "whole").code == 0
    path.write_text("ego = new Car\n")
    (path.parent / "beside.scn").unlink()
    result = cortexc("resume", run, "--generations", 4)
    assert result.code == 0
    assert "was edited since" in result.said
    assert tables(run) == tables(tmp_path / "whole")


def test_a_full_disk(left_turn: Path, tmp_path: Path) -> None:
    """A disk that fills up ends the search with 2 and a word; with more space the run goes on to its end."""
    script = f"""
        mkdir "$1/disk"; mount -t tmpfs -o size=30m none "$1/disk"; head -c 30408704 /dev/zero > "$1/disk/filler"
        code=0; "$2" -m cortex_dsl "$3" {" ".join(map(str, SEARCH))} --out "$1/disk/run" 2> "$1/first" || code=$?
        echo $code; rm "$1/disk/filler"
        "$2" -m cortex_dsl resume "$1/disk/run" > "$1/second" 2>&1; echo $?; cp "$1/disk/run/journal.sqlite" "$1"
    """
    done = in_namespace(script, tmp_path, sys.executable, left_turn)
    assert done.stdout.split() == ["2", "0"], done.stderr
    complaint = (tmp_path / "first").read_text()
    assert "no space left" in complaint
    assert "cortexc resume" in complaint
    assert "Traceback" not in complaint
    assert read_journal(tmp_path / "journal.sqlite").status == "finished"
    assert "going on after generation" in (tmp_path / "second").read_text()


def test_a_folder_that_can_only_be_read(killed: Path, cortexc: Command) -> None:
    """A run that is not finished is refused with 2, a finished one shows its report."""
    script = """
        mount --bind "$1" "$1"; mount -o remount,ro,bind "$1"
        code=0; "$2" -m cortex_dsl resume "$1" || code=$?; echo "code $code"
    """
    refused = in_namespace(script, killed, sys.executable)
    assert "code 2" in refused.stdout
    assert "cortexc: cannot" in refused.stderr
    assert "Traceback" not in refused.stderr
    assert cortexc("resume", killed).code == 0
    shown = in_namespace(script, killed, sys.executable)
    assert "code 0" in shown.stdout
    assert "finished already" in shown.stderr


def test_two_processes_on_one_run(
    killed: Path, cortexc: Command, command_server: ForkServer, left_turn: Path, tmp_path: Path
) -> None:
    """While a search writes its run, or a resume does, nobody else may."""
    busy, before = tmp_path / "busy", written(killed)
    words = (left_turn, "--ga", "--generations", 60000, "--out", busy)
    with begun(command_server, *words, begins=lambda: written(busy) >= 1):
        refused = cortexc("resume", busy)
    assert refused.code == 2
    assert "being written by another process" in refused.said
    assert "going on" not in refused.said
    words = ("resume", killed, "--generations", 60000)
    with begun(command_server, *words, begins=lambda: written(killed) > before):
        assert cortexc("resume", killed).code == 2


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        ("PRAGMA application_id = 7", "of another program"),
        (f"PRAGMA user_version = {WITHOUT_CHAIN - 1}", f"has version {WITHOUT_CHAIN - 1} of the journal"),
        ("UPDATE individual SET genome = x'00'", "is damaged"),
        ("UPDATE manifest SET value = '\"0\"' WHERE field = 'program_digest'", "compiles the scenario"),
        ("UPDATE manifest SET value = '\"ego = \"' WHERE field = 'file_text'", "does not compile the scenario"),
        ("UPDATE manifest SET value = '99' WHERE field = 'seed'", "is not the one that follows here"),
    ],
)
def test_journals_that_are_none_of_ours(killed: Path, cortexc: Command, damage: str, message: str) -> None:
    """Foreign, older, damaged, of another compiler, or not what its searcher would do: a reason, a cure, and 2."""
    unchain(killed / "journal.sqlite")
    with closing(sqlite3.connect(killed / "journal.sqlite")) as connection:
        connection.execute(damage)
        if "'seed'" in damage:
            connection.execute(
                "UPDATE manifest SET value = json_set(value, '$.search.seed', 99) WHERE field = 'settings'"
            )
        connection.commit()
    before = tables(killed)
    result = cortexc("resume", killed)
    assert result.code == 2
    assert message in result.said
    assert "help:" in result.said
    assert tables(killed) == before


def test_files_that_are_no_journal(cortexc: Command, killed: Path, tmp_path: Path) -> None:
    """Torn off, overwritten, a folder of runs, a name misspelt, a file, nothing: each has its own message."""
    (killed / "journal.sqlite-wal").unlink(missing_ok=True)
    (killed / "journal.sqlite").write_bytes(os.urandom(5000))
    assert "is not a readable journal" in cortexc("resume", killed).err
    (killed / "journal.sqlite").write_bytes(b"")
    assert "has 0 bytes" in cortexc("resume", killed).err
    (killed / "journal.sqlite").unlink()
    with closing(sqlite3.connect(killed / "journal.sqlite")) as other:
        other.execute("CREATE TABLE others (name)")
    assert "of another program" in cortexc("resume", killed).err
    assert "holds 1 run" in cortexc("resume", tmp_path).err
    assert f"did you mean `{killed}`?" in cortexc("resume", killed.with_name("kiled")).err
    assert "is not a folder" in cortexc("resume", __file__).err
    result = cortexc("resume")
    assert (result.code, "no run given" in result.said) == (2, True)
    assert cortexc("resume", killed, "--json").document["exit_code"] == 2


def test_a_folder_that_is_removed_is_reported_at_once(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """With the next generation; the search goes on in memory, shows what it found, and ends with 2."""
    run, heard = tmp_path / "run", []
    scenario = load(left_turn)
    search = replace(scenario.config.search, generations=5, population=10, probes=0)
    scenario = replace(scenario, config=replace(scenario.config, search=search))

    def on_generation(progress: Progress) -> None:
        if progress.generation == 1:
            shutil.rmtree(run)
        heard.append(progress.generation)

    run.mkdir()
    found = search_and_keep(scenario, "ga", run, SearchOptions(on_generation=on_generation, on_removed=heard.append))
    assert [each if isinstance(each, int) else "removed" for each in heard] == [0, 1, "removed", 2, 3, 4]
    assert isinstance(found.failure, RemovedError)
    assert len(found.campaign.generations) == 5
    assert not run.exists()


def test_a_process_whose_folder_is_removed(command_server: ForkServer, left_turn: Path, tmp_path: Path) -> None:
    run = tmp_path / "run"
    words = (left_turn, "--ga", "--generations", 60000, "--population", 20, "--jobs", 1, "--out", run)
    with begun(command_server, *words, begins=lambda: written(run) >= 2, number=signal.SIGINT) as left:
        (run / "journal.sqlite").rename(tmp_path / "elsewhere")
        deadline = time.monotonic() + 300.0
        while "was removed" not in command_server.said[1].read_text(encoding="utf-8"):
            assert time.monotonic() < deadline
            time.sleep(0.01)
    assert left[0].status == 2
    assert "interrupted" in left[0].out
    assert "was removed" in left[0].err
    assert "Traceback" not in left[0].err


@pytest.mark.parametrize(
    "change",
    [
        "UPDATE individual SET parent_1_place = parent_1_place + 1 WHERE generation = 2 AND parent_1_place >= 0",
        "UPDATE individual SET operator = 3 WHERE generation = 3 AND operator = 2",
        "UPDATE individual SET genome = zeroblob(length(genome)) WHERE generation = 1 AND place = 4",
    ],
)
@pytest.mark.parametrize("command", [("report",), ("analyse", "--budget", 0), ("resume",)])
def test_a_journal_that_was_changed_by_hand(
    cortexc: Command, ga_run: Path, tmp_path: Path, command: tuple[object, ...], change: str
) -> None:
    """Individuals that the search would not have proposed are reported, by commands that show a run and by `resume`."""
    for chained, message in ((True, "is not what was written"), (False, "in the journal")):
        run = shutil.copytree(ga_run, tmp_path / f"run-{chained}")
        if not chained:
            unchain(run / "journal.sqlite")
        with closing(sqlite3.connect(run / "journal.sqlite")) as connection, connection:
            assert connection.execute(change).rowcount > 0
        result = cortexc(command[0], run, *command[1:])
        assert result.code == 2
        assert message in result.said


def test_a_journal_of_another_version_is_reported_with_a_warning(
    cortexc: Command, ga_run: Path, tmp_path: Path
) -> None:
    """What another version searched otherwise may be right: it is reported, and said."""
    run = shutil.copytree(ga_run, tmp_path / "run")
    unchain(run / "journal.sqlite")
    with closing(sqlite3.connect(run / "journal.sqlite")) as connection, connection:
        connection.execute("UPDATE individual SET operator = 3 WHERE generation = 3 AND operator = 2")
        versions = connection.execute("SELECT value FROM manifest WHERE field = 'versions'").fetchone()[0]
        other = json.dumps({**json.loads(versions), "numpy": "1.0.0"})
        connection.execute("UPDATE manifest SET value = ? WHERE field = 'versions'", (other,))
    result = cortexc("analyse", run, "--budget", 0)
    assert result.code == 0
    assert "numpy" in result.said


WITHOUT_SPACE = """
import resource, sys

size = int(sys.argv[1])
resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
sys.exit(main(sys.argv[2:]))
"""
"""A command that may write files of so many bytes."""


def test_a_file_that_may_not_grow(
    cortexc: Command, command_server: ForkServer, left_turn: Path, tmp_path: Path
) -> None:
    """The search ends with 2 and a word wherever the space ends; `resume` leaves what an undisturbed search leaves."""
    assert cortexc(left_turn, *SEARCH, "--out", tmp_path / "whole").code == 0
    for size in (120_000, 200_000):
        run = tmp_path / f"run-{size}"
        done = command_server.run(WITHOUT_SPACE, size, left_turn, *SEARCH, "--out", run)
        assert done.status == 2, done.err
        assert "cortexc resume" in done.err
        assert "Traceback" not in done.err
        assert 0 < written(run) < GENERATIONS
        assert cortexc("resume", run).code == 0
        assert tables(run) == tables(tmp_path / "whole")


@pytest.mark.parametrize("when", ["a generation", "the analysis", "the files"])
def test_memory_that_is_used_up(
    when: str, cortexc: Command, left_turn: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The search ends with 2 and a word; `resume` leaves what an undisturbed search leaves."""
    assert cortexc(left_turn, *SEARCH, "--out", tmp_path / "whole").code == 0
    run, calls = tmp_path / "run", iter(range(1000))
    module, name, last = {
        "a generation": (engine.search.run, "_simulate", 5),
        "the analysis": (engine.search.run, "blamed", 0),
        "the files": (cortex_dsl.api.run_folder, "derived_files", 0),
    }[when]
    function = getattr(module, name)

    def hungry(*arguments: Any, **options: Any) -> Any:
        if next(calls) == last:
            raise MemoryError
        return function(*arguments, **options)

    with monkeypatch.context() as patch:
        patch.setattr(module, name, hungry)
        result = cortexc(left_turn, *SEARCH, "--out", run)
    assert result.code == 2
    assert "more memory than there is" in result.said
    assert "cortexc resume" in result.said
    assert read_journal(run / "journal.sqlite").status == "running"
    assert written(run) == (5 if when == "a generation" else GENERATIONS)
    assert cortexc("resume", run).code == 0
    assert tables(run) == tables(tmp_path / "whole")


def rechained(journal: Path, change: str) -> None:
    """Change a journal, and write its links, its seal and the digest of its verdicts anew."""
    record = read_journal(journal)
    with closing(sqlite3.connect(journal)) as connection, connection:
        assert connection.execute(change).rowcount > 0
        individuals, simulations = (
            read(connection, record.manifest).columns()
            for read in (journal_reader._individuals, journal_reader._simulations)
        )
        before = chain.BEGINNING
        for generation, figures in connection.execute("SELECT generation, figures FROM generation").fetchall():
            own = [
                [column[order == generation] for column in table]
                for order, table in ((individuals[0][:, 0], individuals), (simulations[0], simulations))
            ]
            before = chain.link(before, figures, *own)
            connection.execute("UPDATE generation SET link = ? WHERE generation = ?", (before, generation))
        chain.seal(connection)
        connection.execute("DELETE FROM blame")
        verdicts = record.blame
        assert verdicts is not None
        row = chain.blame_row(before, verdicts[collisions_of(record.evaluations)])
        connection.execute("INSERT INTO blame VALUES (?, ?, ?)", row)


def test_a_journal_that_another_searcher_wrote(cortexc: Command, ga_run: Path, tmp_path: Path) -> None:
    """A chain proves what was written, and commands that show a run ask for no more. `verify` and `resume` promise that
    the method of the run proposed it, and let it propose again.
    """
    run = shutil.copytree(ga_run, tmp_path / "run")
    rechained(run / "journal.sqlite", "UPDATE individual SET operator = 3 WHERE generation = 3 AND operator = 2")
    for words in (("report", run), ("analyse", run, "--budget", 0)):
        assert cortexc(*words).code == 0
    for words, message in ((("verify", run), "not what ga proposes"), (("resume", run), "is not the one that follows")):
        result = cortexc(*words)
        assert result.code == 2
        assert message in " ".join(result.said.split())

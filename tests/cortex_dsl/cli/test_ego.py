"""`--ego`: who drives is named on the command line, kept with the run, and never started by a file."""

import json
import re
import sqlite3
import sys
from pathlib import Path

import pytest

import cortex_dsl as cx
from cortex_dsl.cli.entry import main
from engine.errors import ControllerError
from engine.search.store import StoreError
from tests.journals import unchain

TEXT = """
map intersection(ways=4, lanes=1)
param GAP = Range(6, 20) m
lane = network.lanes[0]
ego = new Car in lane.centerline, with speed 15 m/s, with behavior ExternalBehavior(every=0.1 s)
other = new Car ahead of ego by GAP, with speed 0
terminate after 2 s
"""
PLANNER = """
import numpy as np
print("loads weights")
SPEED = 5

def drive(seen):
    return np.tile([0.5, 0.0, 0.0], (len(seen), 1))

class Driver:
    def reset(self, lanes, keys):
        self.asked = 0

    def act(self, seen, active):
        self.asked += 1
        return drive(seen)
"""


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a scenario and a planner, in which commands run."""
    (tmp_path / "mine.scn").write_text(TEXT, encoding="utf-8")
    (tmp_path / "planner_of_mine.py").write_text(PLANNER, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "planner_of_mine", raising=False)
    return tmp_path


OWN_DRIVER = Path(__file__).parents[3] / "examples" / "own_driver"
EGO = ("--ego", "python:planner_of_mine:drive")
SMALL = ("--random", "--generations", "2", "--population", "4", "--jobs", "1")


@pytest.mark.parametrize("what", ["drive", "Driver"])
def test_a_run_is_driven(home: Path, capsys: pytest.CaptureFixture[str], what: str) -> None:
    """And how to have it again names who drove."""
    assert main(["mine.scn", "--seed", "1", "--engine", "batch", "--ego", f"python:planner_of_mine:{what}"]) == 0
    assert f"--ego python:planner_of_mine:{what}" in capsys.readouterr().out.replace("\n", " ").replace("  ", " ")


def test_nobody_is_named(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["mine.scn"]) == 2
    assert "mine is driven from outside, and nobody drives: `ego` of ego" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("python:planner_of_mine:driv", "the module `planner_of_mine` has no `driv`"),
        ("python:planner_of_mine.x:drive", "there is no module `planner_of_mine.x` here"),
        ("python:./planner_of_mine.py:drive", "is a file and no module help: write `python:planner_of_mine:function`"),
        ("python:nowhere:drive", "there is no module `nowhere` here"),
        ("planner_of_mine", "`planner_of_mine` names no driver"),
        ("process:./nowhere", "`./nowhere` cannot be started"),
        ("python:planner_of_mine:SPEED", "the controller `ego` is not a function and lacks `reset` or `act`"),
    ],
)
def test_a_name_that_is_none(home: Path, capsys: pytest.CaptureFixture[str], name: str, message: str) -> None:
    assert main(["mine.scn", "--ego", name]) == 2
    assert message in " ".join(capsys.readouterr().err.split())


def test_what_a_planner_prints_is_no_output(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Who reads the JSON of a command reads JSON alone."""
    (home / "planner_of_mine.py").write_text(PLANNER.replace("    return np", "    print('here')\n    return np"))
    assert main(["mine.scn", "--seed", "1", "--engine", "batch", "--json", *EGO]) == 0
    said = capsys.readouterr()
    assert json.loads(said.out)["schema"] == "cortexc/run"
    assert said.err.startswith("loads weights\nhere\n")


def test_what_nobody_needs_is_refused(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["mine.scn", "--ego-batch", "4"]) == 2
    assert "--ego-batch has no effect" in capsys.readouterr().err
    (home / "plain.scn").write_text("ego = new Car on road\n", encoding="utf-8")
    assert main(["plain.scn", *EGO]) == 2
    assert "nobody in plain is driven from outside" in capsys.readouterr().err


def test_a_search_is_kept_with_who_drove(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its collisions replay and report without the driver; what is new wants it again, as it was."""
    assert main(["mine.scn", *SMALL, *EGO, "--out", "run"]) == 0
    (again,) = re.findall(r"again: cortexc (\S+) .*(--ego \S+)", capsys.readouterr().out)
    assert main([again[0], *again[1].split()]) == 0
    run = cx.open_run("run")
    driven = run.record.manifest.driver
    assert driven is not None
    assert (driven.name, driven.block, driven.reproducible) == ("python:planner_of_mine:drive", 256, True)
    collided = int(run.record.evaluations.collided.sum())
    assert 0 < collided <= len(run.record.actions)
    assert main(["replay", "run", "--case", "1", "--to", "worst.svg"]) == 0
    assert main(["report", "run", "--cases", "1"]) == 0
    assert main(["verify", "run", "--model", "dynamic", "--worst", "1"]) == 0
    capsys.readouterr()
    assert main(["resume", "run", "--generations", "3"]) == 2
    assert "decided in this scene is not kept" in capsys.readouterr().err.replace("\n", " ")
    assert main(["resume", "run", "--generations", "3", *EGO]) == 0
    whole = rows("run")
    assert main(["mine.scn", "--random", "--generations", "3", "--population", "4", *EGO, "--out", "whole"]) == 0
    assert whole == rows("whole")
    with (home / "planner_of_mine.py").open("a", encoding="utf-8") as file:
        file.write("# another\n")
    with pytest.raises(StoreError, match="drove in `run`, and not `python:planner_of_mine:drive` as it is now"):
        cx.open_run("run", ego="python:planner_of_mine:drive")


FUZZ = """
import planner

def drive(seen):
    pedals = planner.drive(seen)
    pedals[seen[:, 0] > 15.0] = float("nan")
    return pedals
"""


@pytest.mark.parametrize(
    ("driver", "more"), [("planner", ()), ("fuzz", ("--objective", "controller"))], ids=["collisions", "failures"]
)
def test_what_is_kept_of_a_search_is_what_it_was(home: Path, driver: str, more: tuple[str, ...]) -> None:
    """Decisions belong to one scene, not to others that were tried with the same random numbers, and a search that
    seeks failures of its controller follows from its journal.
    """
    for file in ("crossing.scn", "planner.py"):
        (home / file).write_bytes((OWN_DRIVER / file).read_bytes())
    (home / "fuzz.py").write_text(FUZZ, encoding="utf-8")
    search = ("crossing.scn", "--ga", "--generations", "3", "--population", "20", "--seed", "2")
    assert main([*search, *more, "--ego", f"python:{driver}:drive", "--out", "run"]) == 0
    assert main(["verify", "run"]) == 0
    assert main(["report", "run"]) == 0


def rows(folder: str) -> list[tuple[object, ...]]:
    with sqlite3.connect(Path(folder) / "journal.sqlite") as connection:
        found = connection.execute("SELECT * FROM simulation ORDER BY generation, place, rollout").fetchall()
    connection.close()
    return found


def test_blocks_of_one_are_blocks(home: Path) -> None:
    """A driver of single scenes has the same runs."""
    assert main(["mine.scn", *SMALL, *EGO, "--out", "many"]) == 0
    assert main(["mine.scn", *SMALL, *EGO, "--ego-batch", "1", "--out", "one"]) == 0
    assert rows("many") == rows("one")


def test_files_start_nothing(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Neither a scenario that names a controller like a driver, nor a journal that names one, loads anything."""
    (home / "trap.py").write_text("raise SystemExit('started')\n", encoding="utf-8")
    (home / "trap.scn").write_text(TEXT.replace("(every", '("python:trap:drive", every'), encoding="utf-8")
    assert main(["trap.scn"]) == 2
    assert "nobody drives: `python:trap:drive`" in capsys.readouterr().err.replace("\n", " ")
    assert main(["mine.scn", *SMALL, *EGO, "--out", "run"]) == 0
    unchain(Path("run/journal.sqlite"))
    with sqlite3.connect("run/journal.sqlite") as connection:
        connection.execute(
            "UPDATE manifest SET value = replace(value, 'planner_of_mine', 'trap') WHERE field = 'driver'"
        )
    connection.close()
    run = cx.open_run("run")
    assert run.record.manifest.driver is not None
    assert run.record.manifest.driver.name == "python:trap:drive"
    for command in (["report", "run"], ["replay", "run", "--to", "x.svg"], ["resume", "run", "--generations", "3"]):
        main(command)
    assert "trap" not in sys.modules
    with pytest.raises(ControllerError):
        run.scenario.sample(50, seed=9)


def test_a_study_is_driven(home: Path) -> None:
    """In one process or in several, with the same runs."""
    words = ["study", "mine.scn", "--runs", "2", "--generations", "1", "--population", "4", "--methods", "random", *EGO]
    assert main([*words, "--jobs", "1", "--out", "study"]) == 0
    assert cx.study("mine.scn", "random", 2, generations=1, population=4, ego=EGO[1]).complete


def test_a_probability_is_driven(home: Path) -> None:
    assert main(["probability", "mine.scn", "--samples", "8", "--jobs", "1", *EGO]) == 0

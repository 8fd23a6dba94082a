"""`--ego`: who drives is named on the command line, kept with the run, and never started by a file."""

import json
import pickle
import re
import sqlite3
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cortex_dsl as cx
from cortex_dsl.cli import draw_modes
from cortex_dsl.cli.entry import main
from engine.driving import decisions
from engine.driving.named import named_driver
from engine.errors import ControllerError
from engine.search.probability import levels
from engine.search.store import StoreError
from engine.vocabulary import Verdict
from tests.fork_server import RUN, ForkServer
from tests.journals import unchain

pytestmark = pytest.mark.usefixtures("small_design")
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
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder with a scenario and a planner, in which commands run; its modules are forgotten with it."""
    (tmp_path / "mine.scn").write_text(TEXT, encoding="utf-8")
    (tmp_path / "planner_of_mine.py").write_text(PLANNER, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    before = {*sys.modules}
    yield tmp_path
    for name in {*sys.modules} - before:
        if Path(getattr(sys.modules[name], "__file__", None) or "/").is_relative_to(tmp_path):
            del sys.modules[name]


OWN_DRIVER = Path(__file__).parents[3] / "examples" / "own_driver"
PLANS = "planner_of_mine"
EGO = ("--ego", "python:planner_of_mine:drive")
SMALL = ("--random", "--generations", "2", "--population", "4", "--jobs", "1")


def test_a_sample_counts_broken_expectations(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As many as runs of the same scenes break them."""
    (home / "expects.scn").write_text(f'{TEXT}expect always ego.speed < 16.2 m/s as "slow"\n', encoding="utf-8")
    assert main(["expects.scn", "--sample", "30", *EGO, "--json"]) == 0
    driven = json.loads(capsys.readouterr().out)["driven"]
    scenario = cx.load("expects.scn").driven_by(EGO[1])
    broken = int((scenario.simulate(scenario.sample(30)).broken == 1.0).sum())
    assert driven["broken"] == {"slow": broken}
    assert 0 < broken < 30


@pytest.mark.parametrize("what", ["drive", "Driver"])
def test_a_run_is_driven(home: Path, capsys: pytest.CaptureFixture[str], what: str) -> None:
    """And how to have it again names who drove."""
    assert main(["mine.scn", "--seed", "1", "--engine", "batch", "--ego", f"python:planner_of_mine:{what}"]) == 0
    assert f"--ego python:planner_of_mine:{what}" in capsys.readouterr().out.replace("\n", " ").replace("  ", " ")


def test_nobody_is_named(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["mine.scn"]) == 2
    assert "mine needs a driver for the controller `ego` of ego" in capsys.readouterr().err


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
    assert main(["resume", "run", "--metrics"]) == 0
    assert "effect" in capsys.readouterr().out
    assert main(["resume", "run", "--generations", "3"]) == 2
    said = capsys.readouterr().err
    assert said.startswith("cortexc: `python:planner_of_mine:drive` drove in `run`, and drives on in it\n")
    assert "going on" not in said
    assert main(["resume", "run", "--generations", "3", *EGO]) == 0
    whole = rows("run")
    assert main(["mine.scn", "--random", "--generations", "3", "--population", "4", *EGO, "--out", "whole"]) == 0
    assert whole == rows("whole")
    with (home / "planner_of_mine.py").open("a", encoding="utf-8") as file:
        file.write("# another\n")
    with pytest.raises(StoreError, match="the file of `python:planner_of_mine:drive` is not what it was when it drove"):
        cx.open_run("run", ego="python:planner_of_mine:drive")
    with pytest.raises(
        StoreError, match="`python:planner_of_mine:drive` drove in `run`, not `python:planner_of_mine:Dr"
    ):
        cx.open_run("run", ego="python:planner_of_mine:Driver")


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


@pytest.mark.parametrize("goal", [(), ("--objective", "controller")], ids=["risk", "failures"])
def test_scenes_over_which_a_driver_fails_are_kept(
    home: Path, capsys: pytest.CaptureFixture[str], goal: tuple[str, ...]
) -> None:
    """As scenarios that fail again, named in words by generation and place; a search for them has them first."""
    for file in ("crossing.scn", "planner.py"):
        (home / file).write_bytes((OWN_DRIVER / file).read_bytes())
    (home / "fuzz.py").write_text(FUZZ.replace("15.0", "13.0"), encoding="utf-8")
    drives = ("--ego", "python:fuzz:drive")
    search = ("crossing.scn", "--ga", "--generations", "3", "--population", "20", "--seed", "2", *drives)
    assert main([*search, *goal, "--metrics", "--out", "run"]) == 0
    out = capsys.readouterr().out
    run = cx.open_run("run")
    evaluations = run.record.evaluations
    lost = evaluations.rollouts.verdict[evaluations.simulated, 0] == Verdict.CONTROLLER
    failed = f"{lost.sum()} failures of the driver" if goal else f"the driver failed in {lost.sum()} simulations"
    assert failed in out
    assert re.search(rf" {lost.sum()} +\d.*the driver failed", out[out.index("How runs ended") :])
    log = Path("run/controller.log").read_text(encoding="utf-8").splitlines()
    assert len(log) == lost.sum() > 5
    generation, place = evaluations.places[evaluations.simulated][lost][0].tolist()
    assert log[0].startswith(f"the controller `ego` gave throttle = nan, in generation {generation}, place {place} at ")
    assert len(list(Path("run/failures").iterdir())) == min(10, lost.sum())
    assert main(["run/failures/01.scn", *drives]) == 2
    assert log[0] in " ".join(capsys.readouterr().err.split())
    first = next(case for case in run.every_case() if case.lost) if goal else None
    assert (first is None) == (not goal)
    if first is not None:
        assert first.rank == 1
        assert main(["run/worst/01.scn", *drives]) == 2
        for command in (["replay", "run", "--to", "x.svg"], ["export", "run", "--to", "csv", "--out", "x"]):
            assert main(command) == 2
            assert "the driver failed over case 1" in capsys.readouterr().err
    assert main(["export", "run", "--top", "3", "--to", "csv", "--out", "some"]) == 0
    assert main(["report", "run"]) == 0
    page = Path("run/report.html").read_text("utf-8")
    assert ("Over cases 1 to 10 the driver failed" in page) == bool(goal)
    assert ("mean of controller of valid and failed scenes" in page) == bool(goal)
    run_of, dots = (
        json.loads(re.findall(rf'<script[^>]* id="{name}"[^>]*>(.*?)</script>', page)[0])
        for name in ("run", "evaluations")
    )
    kinds = [dots["kinds"][kind]["words"] for kind in dots["kind"]]
    assert kinds.count("the driver failed") == lost.sum() == dots["kind"].count(3 if goal else 2)
    valid = evaluations.simulated & evaluations.valid
    counted = lost.sum() + valid.sum() if goal else valid.sum()
    assert np.sum(run_of["heat_maps"][0]["tried"]) == counted


WHIMS = """
import numpy as np
import planner

class Late:
    \"\"\"Fails from some question on.\"\"\"

    def __init__(self):
        self.left = 700

    def reset(self, lanes, keys):
        pass

    def act(self, seen, active):
        self.left -= 1
        if self.left < 0:
            raise RuntimeError("out of memory\\nsays \\x1b[31mthe GPU")
        return planner.drive(seen)

class Counter(Late):
    \"\"\"Never drives alike.\"\"\"

    def act(self, seen, active):
        self.left += 1
        pedals = planner.drive(seen)
        pedals *= 0.3 + 0.7 * (self.left * 0.618 % 1.0)
        pedals[:, 2] += 0.02 * (self.left * 0.618 % 1.0)
        return pedals

class Norm(Late):
    \"\"\"Drives as the others of its block go.\"\"\"

    def act(self, seen, active):
        pedals = planner.drive(seen)
        pedals[:, 0] *= np.clip(seen[:, 0].sum() / 400, 0.2, 1)
        return pedals
"""


def test_a_finished_search_is_kept_whole_though_its_driver_fails_afterwards(home: Path) -> None:
    """What is left to drive costs itself alone; each failure is one line of plain text."""
    for file in ("crossing.scn", "planner.py"):
        (home / file).write_bytes((OWN_DRIVER / file).read_bytes())
    (home / "whims.py").write_text(WHIMS, encoding="utf-8")
    search = ("crossing.scn", "--random", "--generations", "6", "--population", "20", "--seed", "1")
    assert main([*search, "--ego", "python:whims:Late", "--out", "run"]) == 0
    run = cx.open_run("run")
    assert run.record.status == "finished"
    verdict = run.record.evaluations.rollouts.verdict
    assert (verdict == Verdict.VALID).any()
    lost = int((verdict == Verdict.CONTROLLER).sum())
    assert lost > 0
    assert Path("run/evaluations.csv").exists()
    log = Path("run/controller.log").read_text(encoding="utf-8")
    assert len(log.splitlines()) >= lost
    assert "out of memory says" in log
    assert "\x1b" not in log


@pytest.mark.parametrize("driver", ["Counter", "Norm"])
def test_a_driver_that_is_not_the_same_again_is_no_damage(
    home: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, driver: str
) -> None:
    """What was decided is kept of the very runs that are judged; who decides otherwise now is told so."""
    for file in ("crossing.scn", "planner.py"):
        (home / file).write_bytes((OWN_DRIVER / file).read_bytes())
    (home / "whims.py").write_text(WHIMS, encoding="utf-8")
    search = ("crossing.scn", "--random", "--generations", "3", "--population", "20", "--seed", "2")
    assert main([*search, "--ego", f"python:whims:{driver}", "--out", "run"]) == 0
    worst = cx.open_run("run")
    assert len(worst.record.actions) >= 10
    assert main(["verify", "run"]) == 0
    capsys.readouterr()
    assert main(["verify", "run", "--ego", f"python:whims:{driver}"]) == 0
    said = capsys.readouterr()
    told = " ".join((said.out + said.err).split())
    assert "damaged" not in told
    assert "may decide otherwise than when it drove" in told or "does not repeat itself" in told
    if driver == "Counter":
        assert main(["report", "run", "--ego", f"python:whims:{driver}"]) == 0
        for most in (decisions.MOST_KEPT, 2):
            monkeypatch.setattr(decisions, "MOST_KEPT", most)
            assert main(["probability", "crossing.scn", "--samples", "300", "--ego", f"python:whims:{driver}"]) == 0


def test_of_many_collisions_a_report_judges_those_that_are_kept(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(decisions, "MOST_KEPT", 3)
    assert main(["mine.scn", "--random", "--generations", "3", "--population", "20", *EGO, "--out", "run"]) == 0
    run = cx.open_run("run")
    assert run.record.evaluations.collided.sum() > len(run.record.actions)
    assert main(["report", "run", "--cases", "1"]) == 0
    assert main(["verify", "run"]) == 0


def test_a_finished_case_is_kept_as_it_was_judged_or_not_at_all(home: Path) -> None:
    """A driver that decides otherwise when it is asked once more about a case is noted, and nothing is kept of it."""
    for file in ("crossing.scn", "planner.py"):
        (home / file).write_bytes((OWN_DRIVER / file).read_bytes())
    (home / "whims.py").write_text(WHIMS, encoding="utf-8")
    scenario = cx.load("crossing.scn").driven_by("python:whims:Counter")
    found = scenario.search("random", generations=1, population=20, seed=1)
    assert scenario.config.driver is not None
    recorder = decisions.Recorder(scenario.config.driver)
    recorder.record_missing(scenario.program, scenario.config, found.evaluations.rollouts, found.worst)
    assert not recorder.recorded
    assert len(recorder.failures) == len(found.worst)
    steady = cx.load("crossing.scn").driven_by("python:planner:drive")
    found = steady.search("random", generations=1, population=20, seed=1)
    assert steady.config.driver is not None
    recorder = decisions.Recorder(steady.config.driver)
    recorder.record_missing(steady.program, steady.config, found.evaluations.rollouts, found.worst)
    assert len(recorder.recorded) == len(found.worst)


DUEL = TEXT.replace("with speed 0", 'with speed 0, with behavior ExternalBehavior("lead", actions="speed")')
SLOW = """
import numpy as np

def creep(seen):
    return np.tile([2.0, 0.0], (len(seen), 1))
"""


def test_each_controller_has_its_driver(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Several are named one after the other, in a search, in processes of a study, and to go on."""
    (home / "duel.scn").write_text(DUEL, encoding="utf-8")
    (home / "slow_of_mine.py").write_text(SLOW, encoding="utf-8")
    both = ("--ego", "ego=python:planner_of_mine:drive", "--ego", "lead=python:slow_of_mine:creep")
    assert main(["duel.scn", *both]) == 0
    assert main(["duel.scn", *SMALL, *both, "--out", "run"]) == 0
    assert f"--ego {both[1]} --ego {both[3]}" in " ".join(capsys.readouterr().out.split())
    assert main(["resume", "run", "--generations", "3", *both[2:], *both[:2]]) == 0
    study = ("study", "duel.scn", "--runs", "2", "--generations", "1", "--population", "4", "--methods", "random")
    assert main([*study, *both, "--jobs", "2", "--out", "study"]) == 0
    capsys.readouterr()
    for words, said in (
        (EGO, "nobody drives for the controller `lead`"),
        ((*both, *both[:2]), "`ego` has a driver already, `python:planner_of_mine:drive`"),
        (
            (*EGO, *EGO),
            "`python:planner_of_mine:drive` is for no controller by name; of several write --ego CONTROLLER=",
        ),
        ((*EGO, *both[2:]), "`python:planner_of_mine:drive` is for no controller by name"),
        ((*both[:2], "--ego", "leed=python:slow_of_mine:creep"), "has no controller `leed`"),
    ):
        assert main(["duel.scn", *words]) == 2
        assert said in " ".join(capsys.readouterr().err.split())
    duel = cx.load("duel.scn")
    with pytest.raises(ControllerError, match="has no controller `leed`"):
        duel.driven_by({"leed": "python:slow_of_mine:creep"})
    arena = duel.environment(2, others={"lead": "python:slow_of_mine:creep"})
    assert arena.reset(seed=1).shape == (2, len(arena.observations))


def test_a_driver_has_one_name_however_it_is_given(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """So that a run made in Python goes on from the command line, where the driver has a name there."""
    import planner_of_mine  # pyright: ignore[reportMissingImports]

    scenario, small = cx.load("mine.scn"), dict[str, Any](generations=2, population=4, seed=0)
    for number, given in enumerate((planner_of_mine.drive, {"ego": planner_of_mine.drive}, f"python:{PLANS}:drive")):
        scenario.search("random", ego=given, out=f"run{number}", **small)
        assert main(["resume", f"run{number}", "--generations", "3", "--ego", f"ego=python:{PLANS}:drive"]) == 0
    assert rows("run0") == rows("run1") == rows("run2")
    scenario.search("random", ego=planner_of_mine.Driver, out="class", **small)
    assert main(["resume", "class", "--generations", "3", "--ego", f"python:{PLANS}:Driver"]) == 0
    scenario.search("random", ego=lambda seen: planner_of_mine.drive(seen), out="lambda", **small)
    capsys.readouterr()
    assert main(["resume", "lambda", "--generations", "3"]) == 2
    assert "name it again in Python, as `ego`" in " ".join(capsys.readouterr().err.split())
    with pytest.raises(StoreError, match="with --ego-batch 256, not 1"):
        cx.open_run("run0", ego=named_driver(f"python:{PLANS}:drive", block=1))


def test_any_name_of_a_controller_can_be_given_a_driver(home: Path) -> None:
    """And drivers by name go to another process."""
    (home / "duel.scn").write_text(DUEL.replace('"lead"', '"lead-car"'), encoding="utf-8")
    (home / "slow_of_mine.py").write_text(SLOW, encoding="utf-8")
    both = {"ego": EGO[1], "lead-car": "python:slow_of_mine:creep"}
    assert main(["duel.scn", "--ego", f"ego={both['ego']}", "--ego", f"lead-car={both['lead-car']}"]) == 0
    driver = cx.load("duel.scn").driven_by(both).config.driver
    again = pickle.loads(pickle.dumps(driver))
    assert (again.name, again.digest) == (driver.name, driver.digest)  # pyright: ignore[reportOptionalMemberAccess]


def test_digests_are_of_what_decides(home: Path) -> None:
    """The file that defines a function, wherever it is imported; all files that a command names."""
    (home / "package").mkdir()
    (home / "package" / "__init__.py").write_text(f"from {PLANS} import drive\n", encoding="utf-8")
    assert named_driver("python:package:drive").digest == named_driver(f"python:{PLANS}:drive").digest != ""
    import planner_of_mine  # pyright: ignore[reportMissingImports]

    scenario = cx.load("mine.scn")
    for given in (partial(planner_of_mine.drive), planner_of_mine.Driver()):
        driver = scenario.driven_by(given).config.driver
        assert driver is not None
        assert driver.digest == named_driver(f"python:{PLANS}:drive").digest
    (home / "settings.yaml").write_text("fast", encoding="utf-8")
    command = f"process:{sys.executable} {PLANS}.py --settings settings.yaml"
    before = named_driver(command).digest
    (home / "settings.yaml").write_text("slow", encoding="utf-8")
    assert before != named_driver(command).digest != ""


def test_what_a_class_prints_is_no_output(home: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Nor what code prints that is not Python."""
    noise = "    def __init__(self):\n        import os; print('made'); os.write(1, b'raw')\n"
    (home / "planner_of_mine.py").write_text(PLANNER.replace("class Driver:\n", f"class Driver:\n{noise}"))
    assert main(["mine.scn", "--seed", "1", "--engine", "batch", "--json", "--ego", f"python:{PLANS}:Driver"]) == 0
    said = capfd.readouterr()
    assert json.loads(said.out)["schema"] == "cortexc/run"
    assert "made" in said.err
    assert "raw" in said.err


def test_what_a_driver_observes_is_kept(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """And how to have a run again names it."""
    (home / "mine.scn").write_text(f'{TEXT}record ego.speed as "speed"\n', encoding="utf-8")
    assert main(["mine.scn", *SMALL, *EGO, "--ego-observes", "egocentric", "--out", "run"]) == 0
    assert "--ego-observes egocentric" in " ".join(capsys.readouterr().out.split())
    driven = cx.open_run("run", ego=EGO[1]).scenario.config.driver
    assert driven is not None
    assert driven.observe == "egocentric"
    assert main(["probability", "mine.scn", "--samples", "8", *EGO, "--ego-observes", "egocentric"]) == 0
    assert main(["probability", "run", "--samples", "8", *EGO, "--ego-observes", "egocentric"]) == 2
    assert "--ego-observes has no effect on a run" in capsys.readouterr().err
    assert main(["mine.scn", "--ego-observes", "egocentric"]) == 2
    assert "--ego-observes has no effect without --ego" in capsys.readouterr().err


def test_a_scenario_is_replayed_and_exported_as_it_is_driven(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A run needs no driver for that."""
    assert main(["replay", "mine.scn", "--seed", "1", *EGO, "--to", "x.svg"]) == 0
    assert main(["export", "mine.scn", "--seed", "1", *EGO, "--to", "csv", "--out", "x"]) == 0
    assert main(["mine.scn", *SMALL, *EGO, "--out", "run"]) == 0
    capsys.readouterr()
    for words in (["replay", "run"], ["export", "run", "--to", "csv"]):
        assert main([*words, *EGO]) == 2
        assert (
            "--ego has no effect on a run, whose cases have scenes and decisions of their own"
            in capsys.readouterr().err
        )


def test_where_a_driver_raised_is_shown(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Frames of the driver, and none of ours; what is said is one line."""
    deep = "def gap(seen):\n    raise ValueError('no\\ngap')\n\ndef drive(seen):\n    return gap(seen)\n"
    (home / "planner_of_mine.py").write_text(deep, encoding="utf-8")
    assert main(["mine.scn", "--seed", "1", *EGO]) == 2
    said = capsys.readouterr().err
    assert "line 5, in drive" in said
    assert "line 2, in gap" in said
    assert "engine" not in said
    assert "raised ValueError in `act`: no gap (" in said
    for name, what in (("exits", "raise GeneratorExit"), ("mute", "raise Mute")):
        mute = "class Mute(Exception):\n    def __str__(self):\n        raise ValueError\n"
        (home / f"{name}_of_mine.py").write_text(f"{mute}\ndef drive(seen):\n    {what}\n", encoding="utf-8")
        assert main(["mine.scn", "--seed", "1", "--ego", f"python:{name}_of_mine:drive"]) == 2
        assert "the controller `ego` raised " in capsys.readouterr().err


def test_a_study_tries_its_driver_before_it_begins(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (home / "planner_of_mine.py").write_text(PLANNER.replace("0.5, 0.0, 0.0", "0.5, 0.0"), encoding="utf-8")
    assert main(["study", "mine.scn", "--runs", "2", *EGO, "--out", "study"]) == 2
    assert "gave actions of shape (256, 2); expected (256, 3)" in " ".join(capsys.readouterr().err.split())
    assert not Path("study").exists()


@pytest.mark.parametrize("seed", range(4))
def test_the_example_has_collisions_that_a_competent_driver_avoids(home: Path, seed: int) -> None:
    """The first search of a newcomer finds many; they are most of its collisions."""
    for file in ("crossing.scn", "planner.py"):
        (home / file).write_bytes((OWN_DRIVER / file).read_bytes())
    found = cx.load("crossing.scn").search(
        "ga", objective="avoidable", ego="python:planner:drive", generations=10, seed=seed
    )
    assert found.failures.avoidable > 50
    assert found.failures.avoidable > 0.8 * found.failures.collisions


@pytest.mark.parametrize(
    "words", [("--ga",), ("--ga", "--out", "new/run"), ("--method", "ga,random", "--out", "runs")], ids=" ".join
)
def test_a_search_whose_driver_cannot_drive_leaves_no_folder(home: Path, words: tuple[str, ...]) -> None:
    """Neither by a command nor in Python; a folder that was there stays."""
    (home / "planner_of_mine.py").write_text("def drive(seen):\n    raise ValueError\n", encoding="utf-8")
    (home / "mine").mkdir()
    assert main(["mine.scn", *words, *EGO]) == 2
    for out in ("mine", "other/run"):
        with pytest.raises(ControllerError, match="raised ValueError"):
            cx.load("mine.scn").search("ga", ego=EGO[1], generations=1, population=4, out=out)
    assert [path.name for path in home.iterdir() if path.is_dir() and path.name != "__pycache__"] == ["mine"]


def rows(folder: str) -> list[tuple[object, ...]]:
    with sqlite3.connect(Path(folder) / "journal.sqlite") as connection:
        found = connection.execute("SELECT * FROM simulation ORDER BY generation, place, rollout").fetchall()
    connection.close()
    return found


LEAVING = """
import os
import numpy as np

left = int(os.environ["LEAVES_AFTER"])

def drive(seen):
    global left
    left -= 1
    if left == 0:
        os._exit(0)
    return np.tile([0.5, 0.0, 0.0], (len(seen), 1))
"""


@pytest.mark.parametrize("calls", [30, 75])
def test_a_driver_that_ends_the_process_loses_no_generation(home: Path, command_server: ForkServer, calls: int) -> None:
    """The journal holds what was done by then; continued, it is the one of a search without that end."""
    (home / "leaving.py").write_text(LEAVING, encoding="utf-8")
    ego = ("--ego", "python:leaving:drive")
    search = ("mine.scn", "--random", "--generations", "6", "--population", "4", "--jobs", "1", *ego)
    whole = command_server.run(RUN, *search, "--out", "whole", at=home, LEAVES_AFTER="0")
    assert whole.status == 0, whole.err
    cut = command_server.run(RUN, *search, "--out", "cut", at=home, LEAVES_AFTER=str(calls))
    assert (cut.status, cut.out) == (0, "")
    assert len(rows("cut")) < len(rows("whole"))
    assert rows("whole")[: len(rows("cut"))] == rows("cut")
    done = command_server.run(RUN, "resume", "cut", *ego, at=home, LEAVES_AFTER="0")
    assert done.status == 0, done.err
    assert rows("cut") == rows("whole")


def test_blocks_of_one_are_blocks(home: Path) -> None:
    """A driver of single scenes has the same runs."""
    assert main(["mine.scn", *SMALL, *EGO, "--out", "many"]) == 0
    assert main(["mine.scn", *SMALL, *EGO, "--ego-batch", "1", "--out", "one"]) == 0
    assert rows("many") == rows("one")


def test_files_start_nothing(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Neither a scenario that names a controller like a driver, nor a journal that names one, loads anything."""
    (home / "trap.py").write_text("open('started', 'w')\ndrive = len\n", encoding="utf-8")
    (home / "trap.scn").write_text(TEXT.replace("(every", '("python:trap:drive", every'), encoding="utf-8")
    assert main(["trap.scn"]) == 2
    assert "needs a driver for the controller `python:trap:drive`" in capsys.readouterr().err.replace("\n", " ")
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
    for command, code in (
        (["report", "run"], 0),
        (["replay", "run", "--to", "x.svg"], 0),
        (["verify", "run"], 0),
        (["analyse", "run", "--budget", "8"], 0),
        (["export", "run", "--to", "csv", "--out", "x"], 0),
        (["probability", "run", "--samples", "8"], 2),
        (["resume", "run", "--generations", "3"], 2),
    ):
        assert (command[0], main(command)) == (command[0], code)
    assert not Path("started").exists()
    with pytest.raises(ControllerError, match="is not kept"):
        run.scenario.sample(50, seed=9)


def test_a_study_is_driven(home: Path) -> None:
    """In one process or in several, with the same runs."""
    words = ["study", "mine.scn", "--runs", "2", "--generations", "1", "--population", "4", "--methods", "random", *EGO]
    assert main([*words, "--jobs", "1", "--out", "study"]) == 0
    assert cx.study("mine.scn", "random", 2, generations=1, population=4, ego=EGO[1]).complete


def test_drawn_scenes_are_driven(
    home: Path,
    capsys: pytest.CaptureFixture[str],
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """And counted by how they end, some at a time, as Python would count them."""
    for file in ("crossing.scn", "planner.py"):
        (home / file).write_bytes((OWN_DRIVER / file).read_bytes())
    (home / "fuzz.py").write_text(FUZZ.replace("15.0", "13.0"), encoding="utf-8")
    monkeypatch.setattr(draw_modes, "DRIVEN", 64)
    drawn = ("crossing.scn", "--sample", "200", "--seed", "3", "--ego-batch", "32", "--ego", "python:fuzz:drive")
    assert main(drawn) == 0
    out = capsys.readouterr().out
    assert caplog.messages[0].startswith("the controller `ego` gave throttle = nan, in scene ")
    scenario = cx.load("crossing.scn").driven_by("python:fuzz:drive", block=32)
    outcomes = scenario.simulate(scenario.sample(200, seed=3))
    lost, collided = int((outcomes.verdict == Verdict.CONTROLLER).sum()), int(outcomes.collided.sum())
    assert lost > 0 < collided
    rate = f"collisions in {100 * collided / (200 - lost):.2f} % of {200 - lost} runs; 95 % interval"
    assert rate in out
    assert "200 scenes driven  by python:fuzz:drive" in out
    assert main([*drawn, "--json", "--jobs", "1"]) == 0
    found = json.loads(capsys.readouterr().out)["driven"]
    assert found["endings"]["controller"] == lost
    assert found["endings"]["no_collision"] == 200 - lost - collided
    assert (found["scenes"], found["collisions"], found["driver"]) == (200, collided, "python:fuzz:drive")
    assert found["collision_rate"]["interval"]["low"] < collided / (200 - lost)
    assert main(["crossing.scn", "--sample", "5", "--json"]) == 0
    assert "driven" not in json.loads(capsys.readouterr().out)
    assert main(["crossing.scn", "--sample", "5", "--ego", "python:planner_of_mine:Driver", "--engine", "world"]) == 2


def test_a_probability_is_driven(home: Path) -> None:
    assert main(["probability", "mine.scn", "--samples", "8", "--jobs", "1", *EGO]) == 0


CRASHES = """
import numpy as np
import planner

def drive(seen):
    near = (seen[:, planner.NEAREST] > 0) & (np.hypot(seen[:, planner.NEAREST + 1], seen[:, planner.NEAREST + 2]) < 7)
    return np.where(near[:, np.newaxis], np.nan, planner.drive(seen))
"""


def test_who_fails_before_it_collides_is_not_called_safe(
    home: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The interval reaches as far as if every such run were a collision; what is rare has no estimate."""
    for file in ("crossing.scn", "planner.py"):
        (home / file).write_bytes((OWN_DRIVER / file).read_bytes())
    (home / "crashes.py").write_text(CRASHES, encoding="utf-8")
    probability = ("probability", "crossing.scn", "--samples", "400", "--ego")
    rare = ("probability", "crossing.scn", "--method", "subset", "--samples", "1000", "--ego")
    assert main([*probability, "python:planner:drive", "--json"]) == 0
    true = json.loads(capsys.readouterr().out)
    assert main([*probability, "python:crashes:drive", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (true["collisions"] > 0) & (found["collisions"] == 0)
    assert found["valid"] + found["lost"] == 400
    assert found["valid_share"] == 1.0
    assert found["interval"]["high"] > found["lost"] / 400 >= true["value"]
    assert main([*probability, "python:crashes:drive"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert f"the driver failed in {found['lost']} of 400 runs" in said
    assert "100.0 % of all draws of the params allow a valid scene" in said
    monkeypatch.setattr(levels, "MOST_LEVELS", 0)  # the driver fails among the first draws
    assert main([*rare, "python:crashes:drive"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "none, as the driver failed in some runs" in said
    assert "not known" in said
    assert main(["crossing.scn", "--sample", "400", "--json", "--ego", "python:crashes:drive"]) == 0
    drawn = json.loads(capsys.readouterr().out)["driven"]
    assert drawn["collision_rate"]["interval"]["high"] > drawn["endings"]["controller"] / 400

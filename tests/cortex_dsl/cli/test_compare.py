"""`cortexc compare`: planted differences, equal results for any number of jobs, the search, cases, and bad input."""

import csv
import json
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cortex_dsl as cx
from cortex_dsl.api import pairs, testing
from cortex_dsl.api.comparing import compare
from cortex_dsl.console.terminal import Exit
from engine.search.statistics import holm, mcnemar, residual_bound, tango_interval

Run = Callable[..., Any]

VERSION = """\
map intersection(approach=100 m)
param SPEED = Range(5, 15) m/s, GAP = Range(25, 45) m
way = intersection.incomingLanes[0].maneuvers[0]
ego = new Car before intersection by 60 m along way, with speed SPEED,
    with behavior {driver}
truck = new Truck ahead of ego by GAP
{more}
terminate after {time} s
"""
OUTSIDE = "ExternalBehavior(trajectory=way)"


def version(more: str = "", driver: str = "FollowTrajectoryBehavior(SPEED, way)", time: float = 1.0) -> str:
    """Return a file: the ego drives at SPEED towards a truck that stands GAP ahead."""
    return VERSION.format(more=more, driver=driver, time=time)


def slow(limit: float, name: str = "slow") -> str:
    return f'expect always ego.speed < {limit} m/s as "{name}"'


DRIVERS = """\
import numpy as np

rng = np.random.default_rng()

def along(observations, pedal, brake=0.0):
    steer = np.clip(observations[:, 4] - 0.1 * np.clip(observations[:, 3], -1, 1), -0.5, 0.5)
    return np.stack([np.full(len(observations), pedal), np.zeros(len(observations)) + brake, steer], axis=1)

def coasts(observations):
    return along(observations, 0.0)

def brakes(observations):
    return along(observations, 0.0, 1.0)

def hurries(observations):
    return along(observations, 0.3)

def stops_when_slow(observations):
    return along(observations, 0.0, np.where(observations[:, 0] < 10, 1.0, 0.0))

def wavers(observations):
    return along(observations, rng.random(), 0.0)

def dies_when_fast(observations):
    if (observations[:, 0] > 12).any():
        raise ValueError("too fast for me")
    return coasts(observations)

def dies(observations):
    raise ValueError("never")
"""


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with drivers and a file that they drive, in which the command runs."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "compared_drivers.py").write_text(DRIVERS)
    (tmp_path / "out.scn").write_text(version(driver=OUTSIDE, time=3.0))
    return tmp_path


def written(folder: Path, **texts: str) -> list[Path]:
    """Write files and return their paths."""
    for name, text in texts.items():
        (folder / f"{name}.scn").write_text(text)
    return [folder / f"{name}.scn" for name in texts]


def conditions(document: Any, file: int = 0) -> dict[str, Any]:
    return {each["name"]: each for each in document["files"][file]["conditions"]}


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def driver(name: str) -> str:
    return f"python:compared_drivers:{name}"


# -- planted differences -----------------------------------------------------------------------------------------------

PLANTED = {
    "same": (slow(10), slow(10), (), ("kept",), Exit.FINE),
    "none": (slow(16), slow(16), (), (), Exit.FINE),
    "new": (slow(12), slow(10), ("new",), ("kept",), Exit.BROKEN_LIMIT),
    "cured": (slow(10), slow(12), ("cured",), ("kept",), Exit.FINE),
    "one of each": (
        f"{slow(10, 'a')}\n{slow(12, 'b')}",
        f"{slow(12, 'a')}\n{slow(10, 'b')}",
        ("new",),
        ("kept",),
        Exit.BROKEN_LIMIT,
    ),
    "moved": (
        f"{slow(12, 'a')}\n{slow(9, 'b')}",
        f"{slow(16, 'a')}\n{slow(9, 'b')}",
        ("moved",),
        ("kept",),
        Exit.FINE,
    ),
}


@pytest.mark.parametrize("name", PLANTED)
def test_planted_changes(name: str, tmp_path: Path, cortexc: Run) -> None:
    """Each planted change is found in exactly the scenes in which it is planted, with the right exit code."""
    one, other, changes, kept, code = PLANTED[name]
    a, b = written(tmp_path, a=version(one), b=version(other))
    found = cortexc("compare", a, b, "--budget", 300, "--jobs", 1, "--json", "--out", tmp_path / "results")
    assert found.code == code
    document = found.document
    (file,) = document["files"]
    assert (file["pairs"], file["valid"], document["pairs"]) == (300, 300, 300)
    assert {change for change, count in document["changes"].items() if count} == {*changes, *kept}
    rows = rows_of(tmp_path / "results" / "pairs.csv")
    speeds = np.array([float(row["param_SPEED"]) for row in rows])
    tested = conditions(document)
    expects = [name for name in tested if name not in (pairs.CONTACT, pairs.AVOIDABLE)]
    limits = [
        {line.split('"')[1]: float(line.split("< ")[1].split()[0]) for line in text.split("\n")}
        for text in (one, other)
    ]
    for each in expects:
        broken_a, broken_b = (speeds >= limit[each] for limit in limits)
        table = tested[each]["table"]
        assert table["kept_broken"] == (~broken_a & broken_b).sum()
        assert table["broken_kept"] == (broken_a & ~broken_b).sum()
        assert table["broken_broken"] == (broken_a & broken_b).sum()
        assert [row[f"broken_{each}_b"] == "1.0" for row in rows] == broken_b.tolist()
        new, cured = table["kept_broken"], table["broken_kept"]
        assert tested[each]["p"] == mcnemar(new, cured)
        assert tested[each]["interval"] == list(tango_interval(new, cured, 300))
        assert tested[each]["difference"] == (new - cured) / 300
    assert [tested[each]["p_holm"] for each in expects] == list(holm([tested[each]["p"] for each in expects]))
    assert file["residual_bound"] == (None if "new" in changes else residual_bound(300))


def test_contacts_avoidable_contacts_and_moved_failures(home: Path, cortexc: Run) -> None:
    """Drivers that strike the truck at other speeds move failures; one that brakes cures them."""
    words = "--budget", 100, "--json", "--jobs", 1
    moved = cortexc("compare", driver("coasts"), driver("hurries"), "out.scn", *words).document
    assert moved["changes"]["moved"] > 0
    assert all("->" in each["kind"] for each in moved["files"][0]["changes"] if each["change"] == "moved")
    found = cortexc("compare", driver("hurries"), driver("brakes"), "out.scn", *words)
    assert found.code == Exit.FINE
    assert found.document["changes"]["new"] == 0
    assert found.document["changes"]["cured"] > 0
    tested = conditions(found.document)
    assert tested[pairs.CONTACT]["verdict"] == "better"
    avoidable, contact = (tested[name]["table"] for name in (pairs.AVOIDABLE, pairs.CONTACT))
    assert avoidable["broken_kept"] + avoidable["broken_broken"] <= contact["broken_kept"] + contact["broken_broken"]
    back = cortexc("compare", driver("brakes"), driver("hurries"), "out.scn", *words)
    assert back.code == Exit.BROKEN_LIMIT
    mine = conditions(back.document)
    for name, row in tested.items():
        table, mirrored = row["table"], mine[name]["table"]
        assert (table["kept_broken"], table["broken_kept"]) == (mirrored["broken_kept"], mirrored["kept_broken"])
        assert mine[name]["difference"] == -row["difference"]
        assert mine[name]["p"] == row["p"]


@pytest.mark.parametrize(
    "side", [driver("coasts"), "CarFollowingBehavior", "EmergencyBrakeBehavior", "CarFollowingBehavior(SPEED, way)"]
)
def test_a_driver_beside_itself(side: str, home: Path, cortexc: Run) -> None:
    """The same driver twice gives no pair in which only one of both breaks anything, and no moved failure."""
    found = cortexc("compare", side, side, "out.scn", "--budget", 60, "--search", 40, "--json", "--jobs", 1)
    assert found.code == Exit.FINE
    (file,) = found.document["files"]
    assert all(
        row["table"]["kept_broken"] + row["table"]["broken_kept"] == 0 and row["p"] == 1.0 for row in file["conditions"]
    )
    assert [found.document["changes"][change] for change in ("new", "cured", "moved")] == [0, 0, 0]
    assert file["search"]["changes"] == []
    assert file["residual_bound"] == residual_bound(60)


def test_a_behavior_beside_a_driver_from_outside(home: Path, cortexc: Run) -> None:
    """Both drive the same scenes: those of the plain command with the same seeds."""
    found = cortexc(
        "compare", driver("coasts"), "CarFollowingBehavior", "out.scn", "--budget", 20, "--out", "o", "--jobs", 1
    )
    assert found.code in (Exit.FINE, Exit.BROKEN_LIMIT)
    rows = rows_of(home / "o" / "pairs.csv")
    scenario = cx.load(home / "out.scn").driven_by(driver("coasts"))
    for row in rows[:5]:
        scenes = scenario.scene_of_seed(int(row["seed"]))
        assert [float(row[f"param_{name}"]) for name in scenario.program.space.names] == scenes.genomes[0].tolist()
        assert float(row["contact_a"]) == float(scenario.simulate(scenes).collided[0])


def test_commands_repeat_the_runs_of_a_change(home: Path, cortexc: Run) -> None:
    """The command of each side repeats its run, and `--scene` repeats the pair."""
    found = cortexc("compare", "BrakeBehavior()", driver("hurries"), "out.scn", "--budget", 30, "--json", "--jobs", 1)
    assert found.code == Exit.BROKEN_LIMIT
    change = next(each for each in found.document["files"][0]["changes"] if each["change"] == "new")
    run = cortexc(*shlex.split(change["b"]["replay"])[1:], "--json").document
    assert run["outcome"]["collided"] if "outcome" in run else "contact" in json.dumps(run)
    words = shlex.split(change["a"]["replay"])[1:]
    assert words[-2:] == ["--scene", str(change["seed"])]
    again = cortexc(*words, "--json")
    assert again.code == Exit.BROKEN_LIMIT
    assert again.document["pairs"] == 1
    (same,) = again.document["files"][0]["changes"]
    assert {**same, "count": change["count"], "pair": change["pair"]} == change
    whole = cortexc(*shlex.split(found.document["command"])[1:], "--json", "--jobs", 1)
    assert whole.document == found.document


def test_kept_cases_fail_and_pass_as_their_names_say(tmp_path: Path, cortexc: Run) -> None:
    """A kept case of a new failure passes as A and fails as B, alone."""
    a, b = written(tmp_path, a=version(slow(12)), b=version(slow(10)))
    out = tmp_path / "o"
    assert cortexc("compare", a, b, "--budget", 100, "--out", out, "--jobs", 1).code == Exit.BROKEN_LIMIT
    document = json.loads((out / "compare.json").read_text())
    cases = [case for each in document["files"][0]["changes"] for case in each["cases"]]
    assert sorted(cases) == ["new/a-01.a.scn", "new/a-01.b.scn"]
    results = cortexc("test", out / "new", "--json").document["files"]
    assert {Path(file["path"]).name: (file["status"], file["runs"]) for file in results} == {
        "a-01.a.scn": ("pass", 1),
        "a-01.b.scn": ("fail", 1),
    }
    alone = cortexc("compare", out / "new" / "a-01.a.scn", out / "new" / "a-01.b.scn", "--json")
    assert (alone.code, alone.document["pairs"], alone.document["changes"]["new"]) == (Exit.BROKEN_LIMIT, 1, 1)
    page = (out / "compare.html").read_text()
    assert all(word in page for word in ("New failures", "a-01.b.scn", "<svg"))
    assert "http://" not in page.replace("http://www.w3.org", "")
    assert str(tmp_path) not in page.split("<style>")[0]


def test_the_search_finds_what_pairs_do_not(tmp_path: Path, cortexc: Run) -> None:
    """A new failure of probability 1e-5 is found by the search, fails the command, and enters no test."""
    rare = 'expect always ego.speed + (GAP - 25 m) / (8 s) < 17.48 m/s as "both"'
    a, b = written(tmp_path, a=version('expect always ego.speed > -1 m/s as "both"'), b=version(rare))
    words = "compare", a, b, "--budget", 100, "--json", "--jobs", 1
    plain = cortexc(*words)
    assert plain.code == Exit.FINE
    found = cortexc(*words, "--search", 600)
    assert found.code == Exit.BROKEN_LIMIT
    (alone,), (both,) = plain.document["files"], found.document["files"]
    assert alone.pop("search") is None
    search = both.pop("search")
    assert both == alone
    assert search["scenes"] == 600
    assert any(each["change"] == "new" for each in search["changes"])
    assert found.document["changes"] == plain.document["changes"]


def test_a_limit_on_new_failures(tmp_path: Path, cortexc: Run) -> None:
    """The pairs stop when the limit is decided, and no test is given for their number."""
    a, b = written(tmp_path, a=version(slow(16)), b=version(slow(14)))
    words = "compare", a, b, "--budget", 2000, "--json", "--jobs", 1, "--max-new"
    for limit, answer, code in (("2%", "broken", 4), ("30%", "kept", 0), ("0.1", "open", 0)):
        found = cortexc(*words, limit)
        (file,) = found.document["files"]
        assert (file["max_new"]["answer"], found.code) == (answer, code)
        assert (file["pairs"] == 2000) == (answer == "open")
        assert file["no_test"]
        assert all(row["p"] is None for row in file["conditions"])


# -- searches ----------------------------------------------------------------------------------------------------------


def test_failures_of_two_searches_run_again_with_the_other_driver(tmp_path: Path, cortexc: Run) -> None:
    """Each scene in which one of them failed is one pair, even if both have it, and there is no test: it is no draw."""
    a, b = written(tmp_path, a=version(slow(13)), b=version(slow(11)))
    for path in (a, b):
        words = "--random", "--generations", 2, "--population", 30, "--objective", "slow", "--jobs", 1
        assert cortexc(path, *words, "--out", tmp_path / path.stem).code == Exit.FINE
    found = cortexc("compare", tmp_path / "a", tmp_path / "b", "--json", "--out", tmp_path / "o", "--jobs", 1)
    assert found.code == Exit.BROKEN_LIMIT
    (file,) = found.document["files"]
    runs = [cx.open_run(tmp_path / name).record.evaluations for name in "ab"]
    failed = [run.genomes[(run.rollouts.broken == 1.0).any(axis=(1, 2))] for run in runs]
    assert file["pairs"] == len(np.unique(np.concatenate(failed), axis=0)) < sum(map(len, failed))
    assert not file["independent"]
    assert file["residual_bound"] is None
    rows = rows_of(tmp_path / "o" / "pairs.csv")
    assert all((row["change"] == "new") == (11 <= float(row["param_SPEED"]) < 13) for row in rows)
    nothing = cortexc("compare", tmp_path / "a", tmp_path, "--json")
    assert nothing.code == Exit.USAGE


def test_searches_without_a_failure(tmp_path: Path, cortexc: Run) -> None:
    """Two searches that found nothing have no pairs, and fail nothing."""
    (a,) = written(tmp_path, a=version(slow(16)))
    assert (
        cortexc(a, "--random", "--generations", 1, "--population", 10, "--jobs", 1, "--out", tmp_path / "r").code == 0
    )
    found = cortexc("compare", tmp_path / "r", tmp_path / "r", "--json")
    assert (found.code, found.document["pairs"]) == (Exit.FINE, 0)


# -- drivers that misbehave --------------------------------------------------------------------------------------------


def test_a_driver_that_does_not_repeat_itself(home: Path, cortexc: Run) -> None:
    """The report says so first, and gives no paired test."""
    words = "compare", driver("coasts"), driver("wavers"), "out.scn", "--budget", 40, "--jobs", 1
    found = cortexc(*words, "--json")
    assert found.document["deterministic"] is False
    (file,) = found.document["files"]
    assert file["deterministic"] == {"a": True, "b": False}
    assert file["residual_bound"] is None
    assert all(row["interval"] is None for row in file["conditions"])
    shown = cortexc(*words).out
    assert shown.splitlines()[1].startswith("B is not deterministic")
    assert "no paired test" in shown


def test_a_driver_that_dies_in_some_scenes(home: Path, cortexc: Run) -> None:
    """These scenes are not run, with their number and reason; the command fails if A drove them."""
    words = "--budget", 60, "--json", "--jobs", 1, "--ego-batch", 1
    found = cortexc("compare", driver("coasts"), driver("dies_when_fast"), "out.scn", *words)
    assert found.code == Exit.BROKEN_LIMIT
    (file,) = found.document["files"]
    (lost,) = file["not_run"]
    assert lost["side"] == "B"
    assert "too fast for me" in lost["reason"]
    assert lost["count"] == file["lost_by_b"] == file["pairs"] - file["valid"] > 0
    assert sum(conditions(found.document)[pairs.CONTACT]["table"].values()) == file["valid"]
    other = cortexc("compare", driver("dies_when_fast"), driver("coasts"), "out.scn", *words)
    assert (other.code, other.document["files"][0]["lost_by_b"]) == (Exit.FINE, 0)


def test_a_driver_that_never_drives(home: Path, cortexc: Run) -> None:
    found = cortexc("compare", driver("coasts"), driver("dies"), "out.scn", "--budget", 40, "--json", "--jobs", 1)
    assert found.code in (Exit.USAGE, Exit.BROKEN_LIMIT)
    assert found.document["files"][0]["valid"] == 0


def test_what_a_driver_does_not_observe(home: Path, cortexc: Run) -> None:
    """A driver that observes the four nearest is told of the others, for each side."""
    more = "".join(f"car{k} = new Car ahead of truck by {10 * k + 10} m\n" for k in range(5))
    (home / "many.scn").write_text(version(more, driver=OUTSIDE, time=0.2).replace("(25, 45)", "(5, 6)"))
    words = "compare", driver("coasts"), "CarFollowingBehavior", "many.scn", "--budget", 3, "--json", "--jobs", 1
    remarks = cortexc(*words).document["files"][0]["remarks"]
    assert remarks == ["the driver of A does not observe 2 of 6 other actors: the 4 nearest are observed"]


# -- budgets and interruptions -----------------------------------------------------------------------------------------


def test_a_budget_that_ends_in_the_middle(tmp_path: Path, cortexc: Run) -> None:
    """A budget that is no multiple of a block, and one of time, give the pairs that they allow."""
    a, b = written(tmp_path, a=version(slow(12)), b=version(slow(11)))
    words = "compare", a, b, "--json", "--jobs", 1, "--budget"
    some, more = (cortexc(*words, budget).document for budget in (257, 300))
    assert (some["pairs"], more["pairs"]) == (257, 300)
    timed = cortexc(*words, "0.001s").document
    assert timed["pairs"] == 256
    assert timed["pairs_depend_on_time"]


def test_an_interrupt_keeps_what_is_done(tmp_path: Path, cortexc: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C during the second block ends with 130 and writes the first."""
    a, b = written(tmp_path, a=version(slow(12)), b=version(slow(11)))
    run, calls = pairs.Pairing.run, []

    def interrupted(self: pairs.Pairing, *arguments: Any) -> pairs.PairBlock:
        calls.append(1)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return run(self, *arguments)

    monkeypatch.setattr(pairs.Pairing, "run", interrupted)
    found = cortexc("compare", a, b, "--budget", 600, "--jobs", 1, "--out", tmp_path / "o")
    assert found.code == Exit.INTERRUPTED
    document = json.loads((tmp_path / "o" / "compare.json").read_text())
    assert (document["pairs"], document["interrupted"], document["passed"]) == (256, True, False)


@pytest.mark.parametrize("files", [1, 3])
def test_jobs_change_nothing(files: int, home: Path, cortexc: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """One thread and two give the same bytes in every file but that of the computing time, and so do processes."""
    monkeypatch.setattr(testing, "ALONE", 0.0)
    for number in range(1, files):
        (home / f"out{number}.scn").write_text(version(slow(10 + number), driver=OUTSIDE, time=1.0))
    names = [f"out{number or ''}.scn" for number in range(files)]
    words = "compare", driver("coasts"), driver("hurries"), *names, "--budget", 40, "--search", 20
    for jobs in (1, 2):
        cortexc(*words, "--jobs", jobs, "--out", f"o{jobs}")
    one, two = (
        {
            path.relative_to(home / name): path.read_bytes()
            for path in (home / name).rglob("*")
            if path.is_file() and path.name != "effort.json"
        }
        for name in ("o1", "o2")
    )
    assert one == two
    assert len([path for path in one if path.name.startswith("pairs")]) == files


def test_pairs_as_parquet(tmp_path: Path, cortexc: Run) -> None:
    """The table is the same as that in CSV."""
    parquet = pytest.importorskip("pyarrow.parquet")
    a, b = written(tmp_path, a=version(slow(12)), b=version(slow(11)))
    for kind in ("csv", "parquet"):
        cortexc("compare", a, b, "--budget", 20, "--jobs", 1, "--out", tmp_path / kind, "--table", kind)
    rows = rows_of(tmp_path / "csv" / "pairs.csv")
    table = parquet.read_table(tmp_path / "parquet" / "pairs.parquet").to_pydict()
    assert list(table) == list(rows[0])
    assert [repr(value) for value in table["param_SPEED"]] == [row["param_SPEED"] for row in rows]
    assert table["change"] == [row["change"] for row in rows]


# -- bad input ---------------------------------------------------------------------------------------------------------


def test_versions_with_other_params(tmp_path: Path, cortexc: Run) -> None:
    """The message names every difference."""
    a, b = written(tmp_path, a=version(), b=version().replace("(5, 15) m/s", "(5, 16) m/s").replace("GAP", "ROOM"))
    found = cortexc("compare", a, b)
    assert found.code == Exit.USAGE
    assert "`SPEED` is 5 to 15 m/s in A, 5 to 16 m/s in B" in " ".join(found.out.split())
    assert "`GAP` is in A only" in " ".join(found.out.split())
    assert "`ROOM` is in B only" in " ".join(found.out.split())


def test_an_expect_of_one_version_is_named(tmp_path: Path, cortexc: Run) -> None:
    a, b = written(tmp_path, a=version(slow(12)), b=version(slow(12, "other")))
    document = cortexc("compare", a, b, "--budget", 10, "--json", "--jobs", 1).document
    remarks = " ".join(document["files"][0]["remarks"])
    assert "slow is in A only" in remarks
    assert "other is in B only" in remarks


BAD = {
    "nothing": ((), "A and B are missing"),
    "one": (("out.scn",), "A and B are missing"),
    "no files": ((driver("coasts"), driver("brakes")), "no files given"),
    "mixed": ((driver("coasts"), "out.scn"), "is a driver, and `out.scn` is a file"),
    "files for versions": (("out.scn", "out.scn", "out.scn"), "needs no further files"),
    "no such driver": ((driver("coasts"), driver("coast"), "out.scn"), "did you mean `coasts`?"),
    "no such behavior": (("GivingWayBehaviour", driver("coasts"), "out.scn"), "did you mean `GivingWayBehavior`?"),
    "no such word": (("v1", "v2", "out.scn"), "`v1` names no driver"),
    "no such file": ((driver("coasts"), driver("brakes"), "outt.scn"), "did you mean `out.scn`?"),
    "no such version": (("out.scn", "outt.scn"), "there is no file or folder `outt.scn`"),
    "empty folder": ((driver("coasts"), driver("brakes"), "empty"), "there is no scenario below `empty`"),
    "no run": (("empty", "empty"), "there is no journal in `empty`"),
    "not driven from outside": ((driver("coasts"), driver("brakes"), "own.scn"), "has `ExternalBehavior`"),
    "two controllers": (
        ("CarFollowingBehavior", driver("coasts"), "two.scn"),
        "`truck` in two.scn would have no driver",
    ),
    "does not compile": (("FollowTrajectoryBehavior(3 kg, way)", driver("coasts"), "out.scn"), "cannot drive in"),
    "nobody drives": (("out.scn", "out.scn"), "nobody drives for `ego`"),
    "budget": ((driver("coasts"), driver("brakes"), "out.scn", "--budget", "0"), "--budget is `0`"),
    "limit": ((driver("coasts"), driver("brakes"), "out.scn", "--max-new", "2"), "--max-new is `2`"),
    "folder in use": ((driver("coasts"), driver("brakes"), "out.scn", "--out", "full"), "`full` is not empty"),
    "file as folder": ((driver("coasts"), driver("brakes"), "out.scn", "--out", "out.scn"), "out.scn"),
    "driver for a driver": (
        (driver("coasts"), driver("brakes"), "out.scn", "--ego-a", driver("dies")),
        "no further driver",
    ),
    "scene and budget": (
        (driver("coasts"), driver("brakes"), "out.scn", "--scene", "3", "--budget", "5"),
        "--budget has no effect with --scene",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input(name: str, home: Path, cortexc: Run) -> None:
    """Exit code 2, with the place, the reason and the cure, before anything is written."""
    words, message = BAD[name]
    (home / "empty").mkdir()
    (home / "full").mkdir()
    (home / "full" / "a.txt").write_text("mine")
    (home / "own.scn").write_text(version())
    two = "truck = new Truck ahead of ego by GAP"
    (home / "two.scn").write_text(version(driver=OUTSIDE).replace(two, f"{two}, with behavior ExternalBehavior()"))
    found = cortexc("compare", *words)
    assert found.code == Exit.USAGE
    assert message in f"{found.said} {' '.join(found.out.split())}"
    assert [path.name for path in (home / "full").iterdir()] == ["a.txt"]


def test_a_file_with_errors_and_one_without_a_scene(home: Path, cortexc: Run) -> None:
    """The other files still run; the exit code is the gravest."""
    (home / "wrong.scn").write_text("ego = new Car on on road\n")
    (home / "never.scn").write_text(version("require (distance from ego to truck) > 100 m", driver=OUTSIDE))
    words, options = ("compare", driver("coasts"), driver("coasts")), ("--budget", 10, "--json", "--jobs", 1)
    none = cortexc(*words, "never.scn", *options)
    assert none.code == Exit.NO_SCENE
    found = cortexc(*words, "never.scn", "out.scn", "wrong.scn", *options)
    assert found.code == Exit.DIAGNOSTICS
    assert [bool(file["trouble"]) for file in found.document["files"]] == [True, False, True]


def test_versions_with_drivers_of_their_own(home: Path, cortexc: Run) -> None:
    """Two versions whose ego is driven from outside take a driver each."""
    found = cortexc(
        "compare",
        "out.scn",
        "out.scn",
        "--ego-a",
        driver("brakes"),
        "--ego-b",
        driver("hurries"),
        "--budget",
        30,
        "--json",
        "--jobs",
        1,
    )
    assert found.code == Exit.BROKEN_LIMIT
    change = found.document["files"][0]["changes"][0]
    assert change["b"]["replay"].endswith(f"--ego {driver('hurries')}")


def test_from_python(home: Path) -> None:
    """The function gives the report of the command."""
    report = compare(driver("hurries"), driver("brakes"), "out.scn", budget=50)
    assert report.passed
    assert report.headline.startswith("no new failure")
    assert report.files[0].conditions[0].table.pairs == 50


def test_help_fits_a_screen(cortexc: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    lines = cortexc("compare", "--help").out.splitlines()
    assert max(map(len, lines)) <= 80
    assert len(lines) <= 42


@pytest.mark.parametrize("width", [50, 60, 80])
def test_commands_can_be_copied(width: int, tmp_path: Path, cortexc: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each command of the terminal is one line, and both sides keep their columns beside a long name."""
    name = "a rather long name of an expectation of the file"
    written(tmp_path, a=version(slow(14, name)), b=version(slow(10, name)))
    monkeypatch.chdir(tmp_path)
    words = "compare", "a.scn", "b.scn", "--budget", 40, "--jobs", 1, "--search", 50
    document = cortexc(*words, "--json").document
    monkeypatch.setenv("COLUMNS", str(width))
    lines = [line.strip() for line in cortexc(*words).out.splitlines()]
    replays = {each[side]["replay"] for each in document["files"][0]["changes"][:1] for side in "ab"}
    assert replays
    assert replays <= set(lines)
    assert any(line.split()[-2:] == ["A", "B"] for line in lines if line.startswith("pair "))
    assert any(line.startswith("--out DIR keeps these scenes") for line in lines)


@pytest.mark.parametrize("width", [60, 80, 120])
def test_the_view_fits_the_terminal(width: int, tmp_path: Path, cortexc: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """No line is too long, nothing is cut off, and the numbers are those of the document."""
    written(tmp_path, a=version(slow(12)), b=version(slow(10)))
    monkeypatch.chdir(tmp_path)
    words = "compare", "a.scn", "b.scn", "--budget", 40, "--jobs", 1
    (row, *_) = cortexc(*words, "--json").document["files"][0]["conditions"]
    monkeypatch.setenv("COLUMNS", str(width))
    lines = cortexc(*words).out.splitlines()
    assert max(len(line) for line in lines if "cortexc" not in line) <= min(width, 100)
    shown = " ".join(" ".join(lines).split())
    assert "…" not in shown
    assert all(str(count) in shown for count in row["table"].values())
    assert f"{100 * row['difference']:.3g}".rstrip("0").rstrip(".") in shown
    assert row["verdict"] in shown

"""`cortexc coverage`: planted cells have their planted state, exit codes, documents, and bad input."""

import csv
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cortex_dsl.console.terminal import Exit
from engine.search.statistics import clopper_pearson

Run = Callable[..., Any]

SCENE = """\
map intersection()
way = intersection.incomingLanes[0].maneuvers[0]
param SPEED = Range(5, 15) m/s
param GAP = Range(20, 40) m
ego = new Car before intersection by 45 m along way, with speed SPEED,
    with behavior FollowTrajectoryBehavior(SPEED, way)
truck = new Truck ahead of ego by GAP
require SPEED <= 12 m/s as "limit"
require SPEED < 8 m/s or GAP < 30 m as "apart"
{lines}
terminate after {time} s
"""
SPEEDS = [
    ("0 to 5 m/s", "(0 m/s, 5 m/s)"),
    ("5 to 8 m/s", "(5 m/s, 8 m/s)"),
    ("8 to 12 m/s", "(8 m/s, 12 m/s)"),
    *((f"{a:g} to {a + 0.1:g} m/s", f"({a:g} m/s, {a + 0.1:g} m/s)") for a in (12.5 + 0.1 * i for i in range(20))),
    *((f"{a} to {a + 1} m/s", f"({a} m/s, {a + 1} m/s)") for a in range(20, 40)),
]
"""Cells: impossible, twice covered, 20 excluded, 20 impossible."""
STATES = ["impossible", "covered", "covered", *["excluded"] * 20, *["impossible"] * 20]
SPEED = f'domain "speed" ego.speed in [{", ".join(text for _, text in SPEEDS)}]'
GAP = 'domain "gap" GAP in 10 m steps from 20 m to 40 m'
IMPACT = 'domain "impact" ego.speed at contact in 0.5 m/s steps from 5 m/s to 15 m/s'


@pytest.fixture
def planted(tmp_path: Path) -> Callable[..., Path]:
    """Write a file with some lines."""

    def write(*lines: str, time: float = 1.0) -> Path:
        path = tmp_path / "planted.scn"
        path.write_text(SCENE.format(lines="\n".join(lines), time=time))
        return path

    return write


def states(document: Any) -> dict[str, str]:
    return {cell["name"]: cell["state"] for cell in document["cells"]}


def test_planted_cells_at_the_start(planted: Callable[..., Path], cortexc: Run) -> None:
    """All planted impossible and excluded cells have their reason, and no other cell has one."""
    found = cortexc("coverage", planted(SPEED), "--budget", 400, "--json")
    assert found.code == Exit.FINE
    expected = {f"speed {name}": state for (name, _), state in zip(SPEEDS, STATES, strict=True)}
    assert states(found.document) == expected
    for cell in found.document["cells"]:
        if cell["state"] == "excluded":
            assert [each["name"] for each in cell["requirements"]] == ["limit"]
            assert "line 8" in cell["reason"]
        if cell["state"] == "impossible":
            assert cell["reason"] == "`ego.speed` is 5 to 15 m/s, never in this cell"
            assert cell["culprits"] == [0]
    assert found.document["possible"] == 2


def test_planted_cells_of_pairs(planted: Callable[..., Path], cortexc: Run) -> None:
    """A pair is excluded by the requirement on both, and inherits what is proved for one of its cells."""
    twice = 'domain "twice" 2 * SPEED in [(10 m/s, 14 m/s), (18 m/s, 22 m/s)]'
    found = cortexc("coverage", planted(SPEED, GAP, twice), "--budget", 400, "--json").document
    assert found["ways"] == 2
    by_name = {cell["name"]: cell for cell in found["cells"]}
    assert len(by_name) == len(SPEEDS) * 4 + 4
    pair = by_name["speed 8 to 12 m/s, gap 30 to 40 m"]
    assert (pair["state"], [each["name"] for each in pair["requirements"]]) == ("excluded", ["apart"])
    assert by_name["speed 8 to 12 m/s, gap 20 to 30 m"]["state"] == "covered"
    both = by_name["speed 8 to 12 m/s, twice 10 to 14 m/s"]
    assert (both["state"], both["culprits"]) == ("impossible", [0, 2])
    for (name, _), state in zip(SPEEDS, STATES, strict=True):
        if state in ("impossible", "excluded"):
            assert by_name[f"speed {name}, gap 20 to 30 m"]["state"] == state


def test_planted_blocked_and_untried_cells(planted: Callable[..., Path], cortexc: Run) -> None:
    """Without time for a contact each cell at contact is blocked; with time, cells that no speed has are untried."""
    blocked = cortexc("coverage", planted(IMPACT), "--budget", 200, "--json").document
    assert set(states(blocked).values()) == {"blocked"}
    assert len(blocked["cells"]) == 20
    for cell in blocked["cells"]:
        assert cell["events"] == [{"event": "time is up", "runs": 200}]
        assert cell["probability_at_most"] == pytest.approx(3 / 200)
    found = states(cortexc("coverage", planted(IMPACT, time=4.0), "--budget", 300, "--json").document)
    assert "blocked" not in found.values()
    assert {found[f"impact {a:g} to {a + 0.5:g} m/s"] for a in (12.0, 12.5, 13.0, 14.0)} == {"untried"}
    assert found["impact 9 to 9.5 m/s"] == "covered"
    pairs = cortexc("coverage", planted(SPEED, IMPACT, time=2.0), "--budget", 300, "--json").document
    slow = {name: state for name, state in states(pairs).items() if name.startswith("speed 5 to 8 m/s")}
    assert set(slow.values()) == {"blocked"}


def test_a_covered_cell_has_its_interval_and_its_worst_run(planted: Callable[..., Path], cortexc: Run) -> None:
    """The interval is that of Clopper and Pearson, and the command of the worst run repeats it."""
    path = planted(SPEED, 'expect always (minimum distance from ego to truck) > 8 m as "room"', time=2.0)
    found = cortexc("coverage", path, "--budget", 300, "--json").document
    assert found["failure"] == "a broken `expect`"
    covered = [cell for cell in found["cells"] if cell["state"] == "covered"]
    assert sum(cell["runs"] for cell in covered) == found["draws"] == 300
    for cell in covered:
        assert cell["interval"] == pytest.approx(clopper_pearson(cell["failures"], cell["runs"]))
    worst = max(covered, key=lambda cell: cell["failures"])["worst"]
    words = shlex.split(worst["replay"])
    again = cortexc(*words[1:], "--json").document
    assert again["objectives"][0]["broken"]
    joint = cortexc("coverage", path, "--budget", 300, "--json", "--joint").document
    for one, other in zip(covered, (c for c in joint["cells"] if c["state"] == "covered"), strict=True):
        expected = clopper_pearson(one["failures"], one["runs"], 1.0 - 0.05 / len(covered))
        assert other["interval"] == pytest.approx(expected)


def test_require_decides_the_exit_code(planted: Callable[..., Path], cortexc: Run) -> None:
    """Only possible cells count."""
    assert cortexc("coverage", planted(SPEED), "--budget", 300, "--require", "100%").code == Exit.FINE
    path = planted(IMPACT)
    assert cortexc("coverage", path, "--budget", 50, "--require", "5%").code == Exit.BROKEN_LIMIT
    assert cortexc("coverage", path, "--budget", 50).code == Exit.FINE


def test_the_files_of_out_are_those_of_the_document(planted: Callable[..., Path], cortexc: Run, tmp_path: Path) -> None:
    path = planted(SPEED, GAP)
    found = cortexc("coverage", path, "--budget", 100, "--json", "--out", tmp_path / "new" / "out").document
    with (tmp_path / "new" / "out" / "cells.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["state"] for row in rows] == [cell["state"] for cell in found["cells"]]
    assert (tmp_path / "new" / "out" / "coverage.json").exists()


def test_results_depend_neither_on_jobs_nor_on_a_second_run(planted: Callable[..., Path], cortexc: Run) -> None:
    path = planted(SPEED, GAP, IMPACT, time=2.0)
    one, two = (cortexc("coverage", path, "--budget", 300, "--json", "--jobs", jobs).document for jobs in (1, 2))
    assert {**one, "seconds": 0.0} == {**two, "seconds": 0.0}


@pytest.mark.parametrize(
    ("lines", "options", "said"),
    [
        ((), (), "has no `domain` lines"),
        ((SPEED,), ("--ways", 2), "--ways is 2, but the file has 1 `domain` lines"),
        ((SPEED,), ("--ways", 4), "--ways"),
        ((SPEED,), ("--budget", 0), "--budget"),
        ((SPEED,), ("--require", "120%"), "--require"),
        (
            (
                'domain "fine" SPEED in 0.001 m/s steps from 0 m/s to 50 m/s',
                'domain "gap" GAP in 1 m steps from 20 m to 40 m',
            ),
            (),
            "1,000,000 cells, more than 100,000",
        ),
    ],
)
def test_bad_input(
    lines: tuple[str, ...], options: tuple[Any, ...], said: str, planted: Callable[..., Path], cortexc: Run
) -> None:
    """Each mistake is named, with exit code 2."""
    found = cortexc("coverage", planted(*lines), *options)
    assert found.code == Exit.USAGE
    assert said in found.err
    if "more than" in said:
        assert "`fine` of 50,000 cells" in found.err


def test_a_file_without_scenes_has_no_coverage(planted: Callable[..., Path], cortexc: Run) -> None:
    assert cortexc("coverage", planted("require SPEED > 13 m/s", SPEED)).code == Exit.NO_SCENE


@pytest.mark.parametrize("width", [60, 80, 120])
def test_the_view_fits(width: int, planted: Callable[..., Path], cortexc: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """No line but a command is wider than the terminal, and each state and the treatment of multiplicity are named."""
    monkeypatch.setenv("COLUMNS", str(width))
    found = cortexc("coverage", planted(SPEED, GAP, IMPACT, time=2.0), "--budget", 100)
    for line in found.out.splitlines():
        assert len(line.rstrip()) <= width or "cortexc" in line
    for word in ("covered", "excluded", "impossible", "blocked", "--joint"):
        assert word in found.out


def test_planted_rare_cells(planted: Callable[..., Path], cortexc: Run, tmp_path: Path) -> None:
    """Cells of probability 1e-4 that independent runs miss are reached by the search, with their probability."""
    cells = ", ".join(f"({a} m/s, {a + 0.0007:.4f} m/s)" for a in (6, 7, 9, 11))
    path = planted(f'domain "narrow" ego.speed in [{cells}]')
    missed = cortexc("coverage", path, "--budget", 100, "--json").document
    assert set(states(missed).values()) == {"untried"}
    found = cortexc("coverage", path, "--budget", 100, "--rare", 1000, "--json").document
    assert set(states(found).values()) == {"rare"}
    for cell in found["cells"]:
        low, high = (float(end) for end in cell["name"].removeprefix("narrow ").removesuffix(" m/s").split(" to "))
        assert low - 1e-3 <= cell["params"]["SPEED"]["value"] <= high + 1e-3
        assert (cell["probability"] is None) == ("no probability: " in cell["reason"])
        if cell["probability"] is not None:
            assert 1e-5 < cell["probability"] < 1e-3
            assert cell["interval"][0] <= cell["probability"] <= cell["interval"][1]
    assert found["share"] == 1.0
    cases = tmp_path / "cases"
    cortexc("coverage", path, "--budget", 100, "--rare", 1000, "--out", cases)
    assert sorted(each.name for each in cases.glob("*.scn")) == [f"rare-{number}.scn" for number in range(1, 5)]
    kept = cortexc("coverage", cases / "rare-2.scn", "--json").document
    assert [cell["state"] for cell in kept["cells"]].index("covered") == 1
    assert cortexc("coverage", path, "--rare", 3).code == Exit.USAGE

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


def test_the_instant_of_first_sight(planted: Callable[..., Path], cortexc: Run) -> None:
    """A truck beyond the view of the ego is first seen when it comes into it; one within it is seen at the start."""
    seen = 'domain "seen" SPEED * simulation().currentTime / (10 m/s) at first  sight in [(0, 0.001), (0.001, 100)]'
    path = planted(GAP, seen, time=2.0)
    path.write_text(path.read_text().replace("with speed SPEED,", "with speed SPEED, with visibleDistance 25 m,"))
    found = {
        cell["name"]: cell["state"] for cell in cortexc("coverage", path, "--budget", 200, "--json").document["cells"]
    }
    assert found["gap 20 to 30 m, seen 0 to 0.001"] == "covered"
    assert found["gap 30 to 40 m, seen 0.001 to 100"] == "covered"
    assert found["gap 30 to 40 m, seen 0 to 0.001"] in ("untried", "excluded")
    path.write_text(path.read_text().replace("visibleDistance 25 m", "visibleDistance 1 m"))
    never = cortexc("coverage", path, "--ways", 1, "--budget", 50, "--json").document["cells"]
    assert {cell["state"] for cell in never if cell["name"].startswith("seen")} == {"blocked"}


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


RARE = [5.3 + 0.3 * i for i in range(20)]
"""Lower ends of cells [m/s] with a share of 0.7e-4 of SPEED; half of all values of SPEED and GAP make a scene."""
WIDTH = 0.0007
NARROW = f'domain "narrow" ego.speed in [{", ".join(f"({a:.4f} m/s, {a + WIDTH:.4f} m/s)" for a in RARE)}]'


def test_eighty_planted_cells(planted: Callable[..., Path], cortexc: Run) -> None:
    """20 impossible, 20 excluded, 20 blocked and 20 rare cells: all have their state, no other cell has such a one."""
    path = planted(SPEED, NARROW, IMPACT)
    found = cortexc("coverage", path, "--ways", 1, "--budget", 100, "--rare", 1000, "--json").document
    got = [(cell["domains"], cell["state"]) for cell in found["cells"]]
    expected = [([0], state) for state in STATES] + [([1], "rare")] * 20 + [([2], "blocked")] * 20
    assert got == expected
    for cell, low in zip(found["cells"][len(STATES) :], RARE, strict=False):
        share = 0.1 * WIDTH / 0.5 * (1.0 if low < 8.0 else 0.5)
        assert cell["interval"][0] <= share <= cell["interval"][1]
        assert low <= cell["params"]["SPEED"]["value"] <= low + WIDTH + 1e-9


def test_planted_rare_cells(planted: Callable[..., Path], cortexc: Run, tmp_path: Path) -> None:
    """Cells that independent runs miss are reached by the search, and are kept as files."""
    cells = ", ".join(f"({a} m/s, {a + WIDTH:.4f} m/s)" for a in (6, 7, 9, 11))
    path = planted(f'domain "narrow" ego.speed in [{cells}]')
    missed = cortexc("coverage", path, "--budget", 100, "--json").document
    assert set(states(missed).values()) == {"untried"}
    cases = tmp_path / "cases"
    found = cortexc("coverage", path, "--budget", 100, "--rare", 1000, "--out", cases, "--json").document
    assert set(states(found).values()) == {"rare"}
    assert found["share"] == 1.0
    assert sorted(each.name for each in cases.glob("*.scn")) == [f"rare-{number}.scn" for number in range(1, 5)]
    kept = cortexc("coverage", cases / "rare-2.scn", "--json").document
    assert [cell["state"] for cell in kept["cells"]].index("covered") == 1


def test_rare_cells_in_imported_files(planted: Callable[..., Path], cortexc: Run, tmp_path: Path) -> None:
    """A domain of an imported file means what it means there, also if the file that imports it has names of its own."""
    domain = f'domain "near" BASE - top in [(0 m/s, {WIDTH} m/s)]'
    (tmp_path / "speeds.scn").write_text(f"top = 9 m/s\nparam BASE = Range(5, 15) m/s\n{domain}\n")
    path = planted("from speeds import BASE", "top = 40 m/s")
    found = cortexc("coverage", path, "--budget", 100, "--rare", 1000, "--json", "--out", tmp_path / "out").document
    (cell,) = found["cells"]
    assert cell["state"] == "rare"
    assert 9.0 <= cell["params"]["BASE"]["value"] <= 9.0 + WIDTH + 1e-9
    kept = cortexc("coverage", tmp_path / "out" / "rare-1.scn", "--json").document
    assert states(kept) == {cell["name"]: "covered"}


@pytest.mark.parametrize("method", ["independent", "tway"])
def test_nothing_is_written_before_the_options_are_checked(
    method: str, planted: Callable[..., Path], cortexc: Run, tmp_path: Path
) -> None:
    found = cortexc("coverage", planted(SPEED), "--rare", 3, "--method", method, "--out", tmp_path / "new")
    assert found.code == Exit.USAGE
    assert "give at least 1,000 runs" in found.err
    assert not (tmp_path / "new").exists()


# -- covering arrays ---------------------------------------------------------------------------------------------------

SLOTS = 'domain "slot" ego.speed in 1 m/s steps from 5 m/s to 12 m/s'
KINDS = 'domain "kind" KIND in ["calm", "quick", "odd"]'
KIND = 'param KIND = Uniform("calm", "quick", "odd")'
SHIFT = "param SHIFT = Range(0, 1)"
SHIFTS = 'domain "shift" SHIFT in [(0, 0.001), (0.001, 0.5), (0.5, 1)]'


@pytest.mark.parametrize("ways", [2, 3])
def test_a_covering_array_covers_each_possible_combination(
    ways: int, planted: Callable[..., Path], cortexc: Run
) -> None:
    """Each combination of cells at the start that is not proved empty is covered, by few scenes."""
    path = planted(KIND, SHIFT, SLOTS, GAP, KINDS, SHIFTS)
    one, two = (
        cortexc("coverage", path, "--method", "tway", "--ways", ways, "--json", "--jobs", jobs).document
        for jobs in (1, 2)
    )
    assert {**one, "seconds": 0.0} == {**two, "seconds": 0.0}
    counts = {state: count for state, count in one["counts"].items() if count}
    assert set(counts) == {"covered", "excluded"}
    assert one["share"] == 1.0
    pairs = 7 * 2 - 4  # `apart` excludes the larger gaps of four of the slots
    assert one["draws"] <= (7 * 3 * 1.2 if ways == 2 else 7 * 3 * 3 * 1.2)
    assert sum(cell["domains"] == [0, 1] and cell["state"] == "covered" for cell in one["cells"]) in (0, pairs)
    for cell in one["cells"]:
        assert cell.get("interval") is None
        assert cell.get("probability_at_most") is None


def test_the_scenes_of_a_covering_array_are_kept(planted: Callable[..., Path], cortexc: Run, tmp_path: Path) -> None:
    """As files, one for each run, which lie in the cells of their row; the worst run of a cell is one of them."""
    path, out = planted(SHIFT, SLOTS, GAP, SHIFTS, IMPACT, time=4.0), tmp_path / "out"
    found = cortexc("coverage", path, "--method", "tway", "--out", out, "--json").document
    files = sorted(out.glob("tway-*.scn"))
    assert len(files) == found["draws"]
    worst = next(cell for cell in found["cells"] if cell["state"] == "covered" and cell["failures"])
    words = shlex.split(worst["worst"]["replay"])
    assert Path(words[1]) in files
    kept = cortexc("coverage", words[1], "--json").document
    assert states(kept)[worst["name"]] == "covered"
    assert cortexc(*words[1:], "--json").document["collided"]


def test_a_covering_array_stops_at_its_budget(planted: Callable[..., Path], cortexc: Run) -> None:
    found = cortexc("coverage", planted(SLOTS, GAP), "--method", "tway", "--budget", 3, "--json").document
    assert found["draws"] == 3
    assert found["counts"]["covered"] == 3
    assert found["counts"]["untried"]
    assert any("cut off by the budget" in remark for remark in found["remarks"])


def test_rare_cells_beside_a_covering_array(planted: Callable[..., Path], cortexc: Run) -> None:
    """Probabilities come from independent runs, which are made for them."""
    found = cortexc("coverage", planted(SLOTS, GAP), "--method", "tway", "--budget", 3, "--rare", 1000, "--json")
    assert found.code == 0, found.err
    assert found.document["counts"]["rare"]


def test_a_covering_array_needs_scenes_that_can_be_chosen(
    planted: Callable[..., Path], cortexc: Run, tmp_path: Path
) -> None:
    late = cortexc("coverage", planted(IMPACT), "--method", "tway")
    assert late.code == Exit.USAGE
    assert "needs a domain at the start" in late.err
    cortexc("coverage", planted(SLOTS), "--method", "tway", "--budget", 1, "--out", tmp_path / "out")
    kept = cortexc("coverage", tmp_path / "out" / "tway-1.scn", "--method", "tway")
    assert kept.code == Exit.USAGE
    assert "one scene only" in kept.err

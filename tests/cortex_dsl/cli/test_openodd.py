"""OpenODD: coverage is counted as `openodd` counts it, and attributes of an ODD become domains of a file."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cortex_dsl.console.terminal import Exit
from cortex_dsl.interchange.openodd import SEPARATOR, coverage_document
from cortex_dsl.report.findings.coverage_report import (
    CellResult,
    CoverageReport,
    DomainInfo,
    DomainTotal,
    State,
)
from engine.gates.coverage import OUTSIDE, cells_in, counted, places_of
from engine.tables import Floats, Ints

openodd: Any = pytest.importorskip("openodd", reason="openodd-py is not installed")

Run = Callable[..., Any]

# -- export ------------------------------------------------------------------------------------------------------------


def random_domain(draws: np.random.Generator, number: int) -> tuple[DomainInfo, Floats, Ints, DomainTotal, Any]:
    """Return a domain, values, their cells and totals, and the item of `openodd` for the same buckets."""
    numeric = bool(draws.integers(2))
    edges = np.unique(np.round(draws.uniform(-50, 50, int(draws.integers(2, 8))), int(draws.integers(0, 3))))
    if len(edges) < 2:
        edges = np.array([edges[0], edges[0] + 1.0])
    inside = edges[draws.integers(len(edges), size=20)]
    values = np.concatenate([draws.uniform(-60, 60, 40), inside])
    draws.shuffle(values)
    if numeric:
        low, high = edges[:-1], edges[1:]
        item = openodd.CoverItem(f"d{number}", None, buckets=edges.tolist(), event=openodd.SamplingEvent.END)
    else:
        low = high = edges
        values = edges[draws.integers(len(edges), size=len(values))]
        item = openodd.CoverItem(f"d{number}", None, values=edges.tolist(), event=openodd.SamplingEvent.END)
    ends = tuple(zip(low.tolist(), high.tolist(), strict=True))
    cells = tuple(item.labels) if not numeric else tuple(f"{a} to {b}" for a, b in ends)
    info = DomainInfo(item.name, "end", "", "", "", cells, ends)
    closed = (low == high) | ~np.isin(high, low)
    places = places_of(values, low, high, closed)
    outside = values[places == OUTSIDE]
    runs = np.bincount(places[places >= 0], minlength=len(ends))
    total = DomainTotal(tuple(runs.tolist()), int((outside < low.min()).sum()), int((outside > high.max()).sum()))
    return info, values, places, total, item


def test_counts_of_a_thousand_random_domains_are_those_of_openodd() -> None:
    """Runs of each domain, and of pairs: our file, merged by `openodd`, has the counts of its own buckets."""
    draws = np.random.default_rng(7)
    for _ in range(500):
        one, two = random_domain(draws, 1), random_domain(draws, 2)
        theirs: dict[str, dict[str, int]] = {"d1": {}, "d2": {}, "d1 x d2": {}}
        for left, right in zip(one[1], two[1], strict=True):
            labels = [each[4].bucket_of(value) for each, value in ((one, left), (two, right))]
            for name, label in zip(("d1", "d2"), labels, strict=True):
                theirs[name][label] = theirs[name].get(label, 0) + 1
            key = SEPARATOR.join(labels)
            theirs["d1 x d2"][key] = theirs["d1 x d2"].get(key, 0) + 1
        both = np.stack([one[2], two[2]], axis=1)
        found = counted(both, np.zeros(len(both), dtype=bool), np.zeros(len(both)))
        sizes = [len(each[0].cells) for each in (one, two)]
        cells = [
            CellResult((0, 1), places, State.COVERED, found[places].runs)
            if places in found
            else CellResult((0, 1), places, State.UNTRIED)
            for places in cells_in(sizes, (0, 1))
        ]
        report = CoverageReport(
            "a.scn", "", 0, "", False, 2, len(both), 0, 0, "", (one[0], two[0]), tuple(cells), totals=(one[3], two[3])
        )
        document = json.loads(json.dumps(coverage_document(report)))
        entries = {entry.name: entry for entry in openodd.merge_coverage([document]).entries}
        for name, counts in theirs.items():
            entry = entries[name]
            assert {label: count for label, count in entry.hits.items() if count} == {
                label: count for label, count in counts.items() if label in entry.hits
            }
            if name != "d1 x d2":
                assert entry.out_of_range == {k: v for k, v in counts.items() if k not in entry.hits}
                assert entry.samples == len(both)
                assert list(entry.buckets) == list((one if name == "d1" else two)[4].labels)


# -- reading -----------------------------------------------------------------------------------------------------------

SCENE = """\
map intersection()
way = intersection.incomingLanes[0].maneuvers[0]
param SPEED = Range(20, 60) km/h
param WEATHER = Uniform("dry", "wet")
param GAP = Range(20, 40) m
ego = new Car before intersection by 45 m along way, with speed SPEED,
    with behavior FollowTrajectoryBehavior(SPEED, way)
truck = new Truck ahead of ego by GAP
domain "end speed" ego.speed at end in [(0 m/s, 50 m/s)]
{lines}
terminate after 1 s
"""
ODD = """\
TAXONOMY:
  dynamic:
    ego_speed: float velocity
    end_speed: float velocity
  environment:
    weather: [dry, wet]
    fog: [none, heavy]
ODD:
  urban:
    INCLUDE_AND:
      ego_speed: "[0 .. 40] km/h"
      weather: [dry]
"""
BINDING = """\
openodd: [odd.yaml]
name: urban
probes:
  dynamic.ego_speed: {probe: speed, unit: km/h, buckets: [20, 30, 40, 60]}
  dynamic.end_speed: {probe: speed, unit: m/s, buckets: [0, 10, 20]}
  environment.weather: {measure: weather, values: [dry, wet]}
"""


@pytest.fixture
def files(tmp_path: Path) -> Callable[..., tuple[Path, Path]]:
    """Write a scenario and an ODD with its binding."""

    def write(binding: str = BINDING, lines: str = "") -> tuple[Path, Path]:
        scenario, bound = tmp_path / "scene.scn", tmp_path / "binding.yaml"
        scenario.write_text(SCENE.format(lines=lines))
        (tmp_path / "odd.yaml").write_text(ODD)
        bound.write_text(binding)
        return scenario, bound

    return write


def test_attributes_of_an_odd_are_domains(
    files: Callable[..., tuple[Path, Path]], cortexc: Run, tmp_path: Path
) -> None:
    """Those with a counterpart in the table, in a param or in a domain; `openodd` reads the result."""
    scenario, binding = files()
    out = tmp_path / "out"
    found = cortexc(
        "coverage", scenario, "--domain", binding, "--ways", 1, "--budget", 300, "--json", "--out", out
    ).document
    assert [(each["name"], each["value"], each["instant"]) for each in found["domains"]] == [
        ("dynamic.ego_speed", "ego.speed", "start"),
        ("dynamic.end_speed", "ego.speed", "end"),
        ("environment.weather", "WEATHER", "start"),
    ]
    assert found["domains"][0]["cells"] == ["20 to 30 km/h", "30 to 40 km/h", "40 to 60 km/h"]
    assert any("`environment.fog` of the ODD has no counterpart" in remark for remark in found["remarks"])
    verdicts = found["operational_design_domain"]
    assert verdicts["unknown"] == 0
    assert sum(verdicts.values()) == found["draws"] == 300
    assert 40 < verdicts["inside"] < 110  # half of the speeds, half of the weather
    entries = {entry.name: entry for entry in openodd.load_and_merge([out]).entries}
    for number, domain in enumerate(found["domains"]):
        entry = entries[f"odd.{domain['name']}"]
        runs = [cell.get("runs", 0) for cell in found["cells"] if cell["domains"] == [number]]
        assert list(entry.hits.values()) == runs
    assert list(entries["odd.environment.weather"].outside) == ["wet"]


def test_a_run_without_a_value_is_unknown(files: Callable[..., tuple[Path, Path]], cortexc: Run) -> None:
    """Without weather in the file, a low speed leaves the verdict open, and a high one is outside all the same."""
    scenario, binding = files(BINDING)
    scenario.write_text(scenario.read_text().replace("WEATHER", "OTHER"))
    found = cortexc("coverage", scenario, "--domain", binding, "--ways", 1, "--budget", 100, "--json").document
    assert found["operational_design_domain"]["inside"] == 0
    assert found["operational_design_domain"]["unknown"] > 20
    assert found["operational_design_domain"]["outside"] > 20


@pytest.mark.parametrize(
    ("binding", "said"),
    [
        ("openodd: [none.yaml]\n", "none.yaml"),
        ("openodd: [odd.yaml]\nprobes: {dynamic.ego_speed: {buckets: [3, 1]}}\n", "binding.yaml"),
        ("not yaml: [", "binding.yaml"),
        (
            "openodd: [odd.yaml]\nprobes: {environment.fog: {probe: f}}\n",
            "`environment.fog` of the ODD has no counterpart",
        ),
    ],
)
def test_bad_odds(binding: str, said: str, files: Callable[..., tuple[Path, Path]], cortexc: Run) -> None:
    scenario, bound = files(binding)
    found = cortexc("coverage", scenario, "--domain", bound)
    assert found.code == Exit.USAGE
    assert said in found.err
    assert cortexc("coverage", scenario, "--domain", bound.parent / "nothing.yaml").code == Exit.USAGE

"""What leaves comes back: runs in which others strike one another before the ego's end, in each format that is read."""

from pathlib import Path

import pytest

from benchmarks.validation.items import Item
from benchmarks.validation.material import WANTED, written
from benchmarks.validation.round_trip import round_trip
from cortex_dsl import load
from cortex_dsl.interchange.cases import ExportCase, case_of_scene
from engine.interchange.mcap.write import write_mcap
from engine.interchange.sources import read_recording
from engine.interchange.tables.columns import SLIDES
from engine.interchange.tables.write import write_csv
from engine.vocabulary import State

AGREEMENT = Path(__file__).parents[2] / "agreement"
STRUCK = {"column": (1, 2), "pile": (0, 1), "library": (8, 28), "walls": (1, 2)}
"""Seeds of runs in which another slides while the ego's are scored."""
KINDS = ("replay", "csv", "parquet")


@pytest.fixture(scope="module", params=STRUCK)
def cases(request: pytest.FixtureRequest) -> list[ExportCase]:
    file = AGREEMENT / f"{request.param}.scn"
    scenario = load(file)
    return [case_of_scene(scenario, scenario.scene_of_seed(seed), file, seed, "") for seed in STRUCK[request.param]]


def test_somebody_slides(cases: list[ExportCase]) -> None:
    """So the laws below speak of it."""
    assert all(case.replay.slides.any() for case in cases)


def test_who_is_struck_comes_back_as_it_was(cases: list[ExportCase], tmp_path: Path) -> None:
    """Metrics to 1e-6 and the risk, in every version and table."""
    items: list[Item] = list(written(cases, tmp_path, KINDS))
    assert len(items) == len(cases) * sum(way.kind in KINDS for way in WANTED)
    assert {item.file.name: found for item in items if (found := round_trip(item))} == {}


def test_mcap_keeps_who_slides(cases: list[ExportCase], tmp_path: Path) -> None:
    """At the very samples."""
    for case in cases:
        ((name, content),) = write_mcap(case.replay, "case").files.items()
        (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
        read = read_recording(tmp_path / name).recording
        assert [actor.name for actor in read.actors] == [actor.name for actor in case.replay.actors]
        assert read.states[..., State.PRESENT].tolist() == case.replay.states[..., State.PRESENT].tolist()


def test_a_table_in_which_nobody_slides_has_no_column_for_it() -> None:
    """So the files of other runs are as they were."""
    file = AGREEMENT / "guards.scn"
    scenario = load(file)
    case = case_of_scene(scenario, scenario.scene_of_seed(0), file, 0, "")
    (text,) = write_csv(case.replay, "case").files.values()
    assert not case.replay.slides.any()
    assert SLIDES not in str(text).partition("\n")[0].split(",")

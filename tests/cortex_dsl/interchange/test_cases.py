"""A case that leaves says where it comes from, in words that bring it back."""

import re
from pathlib import Path

import numpy as np
import pytest

from cortex_dsl import compile_text, load
from cortex_dsl.interchange.cases import ExportCase, case_of_scene
from cortex_dsl.version import VERSION
from engine.streams import format_key
from engine.vocabulary import State

LEFT_TURN = Path(__file__).parents[3] / "examples" / "left_turn.scn"


def test_facts_bring_it_back(worst: ExportCase) -> None:
    """File, seed, stream key, digest, risk with its parts, the commands, the version."""
    facts = worst.recording.provenance.facts
    assert worst.run is not None
    assert facts["scenario"].endswith("left_turn.scn")
    assert facts["seed"] == "1"
    assert facts["stream"] == format_key(worst.scenes.keys[0])
    assert facts["digest"] == worst.scenario.program.digest
    assert re.fullmatch(r"\d+ of 22 \(C 10, MD 4, D_MS \d, TTC_MS \d; profile paper\)", facts["risk"])
    assert facts["command"] == f"cortexc replay {worst.run.folder.name} --case 1"
    assert facts["search"].startswith("cortexc ")
    assert facts["version"] == f"cortexc {VERSION}"


def test_genome_has_units_and_every_digit(worst: ExportCase) -> None:
    """Each param as the file writes it; the number reads back to the gene."""
    genome = worst.recording.provenance.genome
    assert tuple(genome) == worst.scenario.program.space.names
    number, unit = genome["EGO_SPEED"].split()
    assert unit == "km/h"
    assert float(number) == worst.scenes.genomes[0][1]


def test_params_that_are_held_fixed_are_reported() -> None:
    """They decide the case as much as the others."""
    scenario = load(LEFT_TURN, EGO_SPEED="50 km/h")
    case = case_of_scene(scenario, scenario.sample(1, seed=3), LEFT_TURN, 3, "cortexc x")
    assert case.recording.provenance.genome["EGO_SPEED"] == "50 km/h"


def test_names_fit_files() -> None:
    """A scenario may be called anything; a case of its seed has that in its name."""
    scenario = compile_text("ego = new Car on road\nterminate after 1 s\n", f"a/ß <b>{'x' * 200}.scn")
    case = case_of_scene(scenario, scenario.sample(1), Path("a.scn"), 7, "")
    assert re.fullmatch(r"[A-Za-z0-9_.-]{1,90}", case.recording.name)
    assert case.recording.name.endswith("-seed7")


def test_no_clock_decides_a_file(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same case gives the same date, whenever it is exported; a build may name one."""
    scenario = load(LEFT_TURN)
    scenes = scenario.sample(1, seed=3)
    dates = []
    for epoch in ("", "soon", "86400"):
        monkeypatch.setenv("SOURCE_DATE_EPOCH", epoch)
        dates.append(case_of_scene(scenario, scenes, LEFT_TURN, 3, "").recording.provenance.date)
    assert dates == ["1970-01-01T00:00:00", "1970-01-01T00:00:00", "1970-01-02T00:00:00"]


def test_the_road_is_everybodys(worst: ExportCase) -> None:
    """What stands in a file that all cases share is true of all."""
    shared = worst.road_provenance
    assert set(shared.facts) == {"scenario", "version"}
    assert not shared.genome


def test_the_recording_is_the_run(worst: ExportCase) -> None:
    """Through contact, with its instant."""
    run = worst.scenario.watch(worst.scenes)
    assert worst.recording.contact is not None
    assert worst.recording.contact.time == run.outcomes.end_time[0]
    assert np.array_equal(worst.recording.states[0, :, State.X], run.trajectory.states[0, :, State.X])


def test_a_run_without_a_score_says_so() -> None:
    """A rule that a run breaks leaves it without risk; its motion can still be exported."""
    text = "ego = new Car at (1.75 m, -30 m), facing 90 deg, with speed 9 m/s\n"
    text += "require always (distance from ego to (1.75 m, 0 m)) > 10 m\n"
    scenario = compile_text(text)
    case = case_of_scene(scenario, scenario.sample(1), Path("a.scn"), 0, "")
    assert case.recording.provenance.facts["risk"] == "none, the run was aborted"

"""Solutions are valid, named as commonroad-io reads them, and hold the ego at every step."""

import math
from dataclasses import replace
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pytest

from engine.interchange import Recording
from engine.interchange.commonroad import write_commonroad
from engine.vocabulary import ActorKind, State
from tests.engine.interchange.commonroad.recordings import actor, recording
from tests.schemas import findings


def solution(made: Recording) -> Element:
    text = str(write_commonroad(made, "case").files["case.solution.xml"])
    assert not findings("commonroad solution", "", text)
    return ElementTree.fromstring(text)


def column(root: Element, tag: str) -> list[float]:
    return [float(each.text or "") for each in root.iter(tag)]


def test_the_ego_at_every_step() -> None:
    """Centre, heading, speed of the rear axle and steering angle, from step 0 on; for the scenario's one problem."""
    made = recording()
    made.states[:, 0, State.STEER] = 0.125
    root = solution(made)
    for tag, state in (("x", State.X), ("y", State.Y), ("velocity", State.SPEED), ("steeringAngle", State.STEER)):
        assert column(root, tag) == made.states[:, 0, state].tolist()
    assert column(root, "time") == [0.0, 1.0, 2.0, 3.0]
    (trajectory,) = root
    scenario = ElementTree.fromstring(str(write_commonroad(made, "case").files["case.cr.xml"]))
    (problem,) = scenario.findall("planningProblem")
    assert trajectory.attrib["planningProblem"] == problem.attrib["id"]
    assert root.attrib["benchmark_id"] == f"KS2:JB1:{scenario.attrib['benchmarkID']}:2020a"


@pytest.mark.parametrize(("kind", "vehicle"), [(ActorKind.CAR, 2), (ActorKind.TRUCK, 4), (ActorKind.BICYCLE, 1)])
def test_the_vehicle_is_the_nearest_in_size(kind: ActorKind, vehicle: int) -> None:
    """And a remark says so unless it is of the same size."""
    made = replace(recording(), actors=(actor("ego", kind),))
    export = write_commonroad(made, "case")
    assert f'"KS{vehicle}:' in str(export.files["case.solution.xml"])
    assert any(f"vehicle {vehicle}" in remark for remark in export.remarks) == (kind is not ActorKind.CAR)


def test_headings_run_on_within_two_turns() -> None:
    """commonroad-io takes no others: they start near zero, and are wrapped only where a spin leaves two turns."""
    made = recording(samples=12)
    made.states[:, 0, State.HEADING] = 30.0 + 0.7 * np.arange(12)
    found = column(solution(made), "orientation")
    assert max(map(abs, found)) < math.tau
    turns = (np.array(found) - made.states[:, 0, State.HEADING]) / math.tau
    assert turns == pytest.approx(np.round(turns))
    assert np.round(turns).tolist() == [-5.0] * 11 + [-6.0]

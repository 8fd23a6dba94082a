"""Scripts of Scenic 2 in the spelling of Scenic 3, and the errors that name the command for it."""

from pathlib import Path

import pytest

from cortex_dsl import compile_text
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.source import Source
from cortex_dsl.syntax import parse
from cortex_dsl.syntax.scenic2 import COMMAND, in_scenic_3

OLD = """map intersection()
model scenic.domains.driving.model
class Taxi(Car):
    width: 2
Town = 'Town05'
behavior Go:
    x = None
    take SetThrottleAction(0.5)
monitor Lights:
    wait
spot = OrientedPoint on road  # ego = Car at spot
ego = Taxi at spot, with behavior Go(), with name "Car at spot"
others = [Taxi ahead of ego by 9, new Car behind ego by 8]
last = Car
Pedestrian left of ego by 3,
    with regionContainedIn None
name = Town
"""
NEW = """map intersection()
model scenic.domains.driving.model
class Taxi(Car):
    width: 2
Town = 'Town05'
behavior Go():
    x = None
    take SetThrottleAction(0.5)
monitor Lights():
    wait
spot = new OrientedPoint on road  # ego = Car at spot
ego = new Taxi at spot, with behavior Go(), with name "Car at spot"
others = [new Taxi ahead of ego by 9, new Car behind ego by 8]
last = new Car
new Pedestrian left of ego by 3,
    with regionContainedIn None
name = Town
require monitor Lights()
"""
GOOD = sorted((Path(__file__).parents[1] / "semantics" / "golden" / "good").glob("*.scn"))


def test_a_script_is_rewritten() -> None:
    """Objects, brackets and monitors; comments, texts, classes and other values stay."""
    assert in_scenic_3(OLD) == NEW
    parse(Source("new.scn", NEW))


def test_a_rewritten_script_stays() -> None:
    """Nothing is left to do."""
    assert in_scenic_3(NEW) == NEW


@pytest.mark.parametrize("path", GOOD, ids=lambda path: path.stem)
def test_programs_of_today_stay(path: Path) -> None:
    """Nothing in them is of Scenic 2."""
    assert in_scenic_3(path.read_text()) == path.read_text()


def test_errors_name_the_command_once() -> None:
    """In a file with several such errors, which are one then, and in no file with one."""
    with pytest.raises(CompileError) as caught:
        compile_text(OLD, name="old.scn")
    (only,) = caught.value.diagnostics
    assert f"{COMMAND} old.scn" in only.cure
    assert only.reason.endswith("also in lines 9, 11, 12, 13, 15.")
    with pytest.raises(CompileError) as one:
        compile_text("ego = Car on road\n", name="old.scn")
    assert COMMAND not in one.value.diagnostics[0].cure

"""What a notebook shows of the values that Python hands out, and of a file that does not compile."""

import pickle
from pathlib import Path

import numpy as np
import pytest

from cortex_dsl.api.runs import open_run
from cortex_dsl.api.scenario import Scenario, compile_text, load
from cortex_dsl.diagnostics import CompileError
from engine.scenes import Scenes
from engine.search.assessment import take

LEFT_TURN = Path(__file__).parents[3] / "examples" / "left_turn.scn"
WRONG = "param UNUSED = Range(1, 2) km/h\nego = new Car with speeed 3 m/s\n"


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return load(LEFT_TURN)


def test_scenes_show_params_and_a_picture(scenario: Scenario) -> None:
    """Names with units, the first rows, how many more there are, and the first valid scene from above."""
    html = scenario.sample(25, seed=1)._repr_html_()
    assert "EGO_SPEED [km/h]" in html
    assert "25 scenes of left_turn" in html
    assert "and 15 more" in html
    assert "data:image/svg+xml;base64," in html


def test_outcomes_runs_and_tables_show_themselves(scenario: Scenario) -> None:
    """Outcomes count their collisions, a run tells its story, a table its columns."""
    scenes = scenario.sample(25, seed=1)
    outcomes = scenario.simulate(scenes)
    assert f"{int((outcomes.collided & (outcomes.verdict == 0)).sum())} collision" in outcomes._repr_html_()
    run = scenario.watch(scenes, int(scenes.valid.argmax()))
    assert "starts at" in run._repr_html_()
    table = scenario.table(outcomes)
    assert "MD" in table._repr_html_() or "min_distance" in table._repr_html_()
    assert "25 rows" in table._repr_html_()


def test_searches_show_themselves_in_memory_and_on_disk(scenario: Scenario, tmp_path: Path) -> None:
    """The worst cases stand in a table with their params."""
    campaign = scenario.search("random", generations=2, population=20, out=tmp_path / "run")
    for shown in (campaign, open_run(tmp_path / "run")):
        html = shown._repr_html_()
        assert "least distance [m]" in html
        assert "EGO_SPEED" in html
    assert str(tmp_path / "run") in open_run(tmp_path / "run")._repr_html_()


def test_what_is_displayed_is_the_engines_own(scenario: Scenario) -> None:
    """It is of the engine's type, comes back from a pickle with its display, and its parts are plain."""
    scenes = scenario.sample(5, seed=1)
    assert isinstance(scenes, Scenes)
    assert repr(scenes).startswith("Scenes(5")
    back = pickle.loads(pickle.dumps(scenes))
    assert back._repr_html_() == scenes._repr_html_()
    part = take(scenes, slice(0, 2))
    assert np.array_equal(part.genomes, scenes.genomes[:2])
    assert part._repr_html_().startswith("<pre>Scenes(2")


def test_a_compile_error_points_at_its_place() -> None:
    """As text, as lines for IPython and as HTML: the source line with a caret, errors before notes."""
    with pytest.raises(CompileError) as caught:
        compile_text(WRONG, "mine.scn")
    error = caught.value
    text = str(error)
    assert "ego = new Car with speeed 3 m/s" in text
    assert "^" in text
    severities = [line.split(": ")[1].split("[")[0] for line in text.splitlines() if line.startswith("mine.scn:")]
    assert severities == sorted(severities, key=lambda severity: severity != "error")
    assert severities[0] == "error"
    assert error._render_traceback_() == text.strip("\n").splitlines()
    assert "speeed" in error._repr_html_()
    assert "<pre" in error._repr_html_()

"""What `--sample` says beside its tables."""

import pytest

from cortex_dsl import compile_text
from cortex_dsl.console.terminal import Terminal
from cortex_dsl.report.findings.tally import Tally
from cortex_dsl.report.terminal.render import rendered
from cortex_dsl.report.views.samples import sample_view

START = "map intersection()\n"
PARAM = "param V = Range(10, 60) km/h\n"
EGO = "ego = new Car on road, with speed {speed}\n"


@pytest.fixture(autouse=True)
def _wide(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "100")


def shown(text: str, capsys: pytest.CaptureFixture[str]) -> str:
    scenario = compile_text(text)
    tally = Tally().plus(scenario.sample(100, seed=1))
    Terminal(colour=False).out.print(rendered(sample_view(scenario.program, tally, 1.0, "seed 1"), 100))
    return capsys.readouterr().out


def test_params_are_kept(capsys: pytest.CaptureFixture[str]) -> None:
    """A scene's attempts share its params, and those that are hopeless are counted."""
    out = shown(START + PARAM + EGO.format(speed="V") + "require V > 35 km/h\n", capsys)
    assert "params are drawn once for each scene; each attempt draws all the rest again" in out
    assert " of 100 draws of the params can have no scene" in out


def test_without_params_there_is_nothing_to_keep(capsys: pytest.CaptureFixture[str]) -> None:
    """Nor are any hopeless."""
    out = shown(START + EGO.format(speed="3 m/s"), capsys)
    assert "params" not in out

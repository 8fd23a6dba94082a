"""`cortexc measure` and `cortexc import`: recorded cases, scored."""

import json
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import engine.interchange.openscenario.read
from cortex_dsl import load
from cortex_dsl.console.terminal import Exit
from engine.interchange import InterchangeError, Recording
from engine.interchange.recording import recorded_run
from engine.interchange.tables import write_csv, write_parquet

Cortexc = Callable[..., SimpleNamespace]
ROAD = SimpleNamespace(file="road.xodr", roads={}, summary=lambda: "3 roads, 1 junction")
HEAD_ON = "time,id,x,y,heading,speed,length,width,type\n" + "".join(
    f"{k / 10},ego,{k},0,0,10,4.5,1.8,car\n{k / 10},lorry,{60 - k},0,3.14159,10,8,2.5,truck\n" for k in range(40)
)


@pytest.fixture(scope="module")
def recording() -> Recording:
    """The scene that `cortexc examples/left_turn.scn` shows: a collision."""
    scenario = load(Path(__file__).parents[3] / "examples" / "left_turn.scn")
    for seed in range(40):
        scenes = scenario.sample(1, seed=seed)
        if scenes.valid[0] and (run := scenario.watch(scenes)).outcomes.collided[0]:
            return recorded_run(scenario.program, scenes, run, step=scenario.config.simulation.time_step)
    raise AssertionError("no collision in forty scenes")


@pytest.fixture
def head_on(tmp_path: Path) -> Path:
    path = tmp_path / "head_on.csv"
    path.write_text(HEAD_ON)
    return path


def test_a_table_is_shown_as_a_run_is(cortexc: Cortexc, head_on: Path) -> None:
    """Headline, drawing, story, metrics, risk, definitions, and the command again."""
    result = cortexc("measure", head_on)
    assert result.code == Exit.FINE
    assert result.err == ""
    gap = 60.0 - 4.5 / 2 - 8.0 / 2
    for words in (
        f"contact: ego and lorry  after {gap / 20:.2f} s  risk ",
        "2 actors, 40 samples over 3.90 s, measured every 0.1 s",
        "starts at 36.0 km/h",
        "closing fastest on lorry: 72.0 km/h",
        "least distance between outlines",
        "profile paper",
        "Definitions",
        "other tools use centres",
        f"cortexc measure {head_on}",
    ):
        assert words in " ".join(result.out.split()) or words in result.out, words
    assert "oscillation" not in result.out


def test_the_document_holds_what_the_view_shows(cortexc: Cortexc, head_on: Path) -> None:
    """One JSON document on stdout."""
    found = cortexc("measure", head_on, "--json").document
    assert found["schema"] == "cortexc/measure"
    assert found["collided"] is True
    assert found["contact"] == ["ego", "lorry"]
    assert found["pairs"][0]["max_closing_speed"] == pytest.approx(20.0)
    assert found["risk"]["parts"]["C"] == 10
    assert found["end"] == {"reason": "collision", "time": pytest.approx(2.6875, abs=1e-4)}
    assert found["actors"][1]["kind"] == "truck"
    assert {metric["name"] for metric in found["metrics"]} >= {"MD", "TTC", "PET"}
    assert found["reproduce"] == f"cortexc measure {head_on}"


@pytest.mark.parametrize("write", [write_csv, write_parquet])
def test_an_exported_run_has_its_score_again(
    cortexc: Cortexc, recording: Recording, tmp_path: Path, write: Callable
) -> None:
    """Through a file and the command line."""
    from engine.interchange.measuring import measure

    ((name, content),) = write(recording, "case").files.items()
    (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    found, own = cortexc("measure", tmp_path / name, "--json").document, measure(recording)
    assert found["risk"]["score"] == own.risk.score[0]
    assert found["end"]["time"] == pytest.approx(own.outcomes.end_time[0], abs=1e-6)
    assert found["pairs"][0]["ttc_at_ms"] == pytest.approx(own.outcomes.ttc_at_ms[0, 0], abs=1e-6)


def test_options_reach_the_measure(cortexc: Cortexc, head_on: Path) -> None:
    """--ego, --step and --profile, and the command that repeats them."""
    found = cortexc(
        "measure", head_on, "--ego", "lorry", "--step", "0.05", "--profile", "literature", "--json"
    ).document
    assert found["actors"][0]["name"] == "lorry"
    assert found["step"] == 0.05
    assert found["risk"]["profile"] == "literature"
    assert found["reproduce"].endswith("--ego lorry --step 0.05 --profile literature")


def test_one_actor_has_metrics_of_none_and_no_risk(cortexc: Cortexc, tmp_path: Path) -> None:
    """Nothing to come near to."""
    (tmp_path / "one.csv").write_text("time,id,x,y\n0,a,0,0\n0.1,a,1,0\n")
    result = cortexc("measure", tmp_path / "one.csv")
    assert result.code == Exit.FINE
    assert "no contact: a is alone, there is no other actor to measure against" in result.out
    assert "risk" not in result.out
    assert cortexc("measure", tmp_path / "one.csv", "--json").document["risk"]["score"] is None


def test_several_others_stand_in_a_table(cortexc: Cortexc, tmp_path: Path) -> None:
    """The deciding pair in full, all pairs in short."""
    rows = [f"{k / 10},{name},{x + k * v},{y}" for k in range(20) for name, x, y, v in CROWD]
    (tmp_path / "crowd.csv").write_text("\n".join(["time,id,x,y", *rows]))
    out = cortexc("measure", tmp_path / "crowd.csv").out
    assert "ego and each other" in out
    assert all(name in out for name in ("MD m", "near", "far", "beside"))


CROWD = (("ego", 0, 0, 1.0), ("near", 40, 0, 0.0), ("far", 90, 0, 0.0), ("beside", 0, 8, 1.0))


@pytest.mark.parametrize("columns", [60, 80, 120])
def test_the_view_keeps_within_its_width(
    cortexc: Cortexc, head_on: Path, monkeypatch: pytest.MonkeyPatch, columns: int
) -> None:
    """At all widths, in plain letters too."""
    monkeypatch.setenv("COLUMNS", str(columns))
    for line in cortexc("measure", head_on).out.splitlines():
        assert len(line) <= min(columns, 100) or str(head_on) in line


def test_it_is_turned_into_other_formats(cortexc: Cortexc, head_on: Path, tmp_path: Path) -> None:
    """Beside the file or in --out; nothing else is written over, and what the format cannot carry is reported."""
    out = tmp_path / "out"
    result = cortexc("measure", head_on, "--to", "csv,parquet", "--out", out)
    assert result.code == Exit.FINE
    assert sorted(path.name for path in out.iterdir()) == ["head_on.csv", "head_on.parquet"]
    assert "pedals" in result.out
    again = cortexc("measure", out / "head_on.csv", "--json").document
    assert again["pairs"][0]["ttc_at_ms"] == pytest.approx(
        cortexc("measure", head_on, "--json").document["pairs"][0]["ttc_at_ms"], abs=1e-6
    )
    refused = cortexc("measure", head_on, "--to", "csv")
    assert refused.code == Exit.USAGE
    assert "holds something else" in refused.said
    assert "--force" in refused.said
    assert head_on.read_text() == HEAD_ON
    assert cortexc("measure", head_on, "--to", "csv", "--out", out, "--force").code == Exit.FINE


@pytest.mark.parametrize("name", ["csv", "parquet", "xosc"])
def test_what_was_written_measures_the_same(cortexc: Cortexc, head_on: Path, tmp_path: Path, name: str) -> None:
    """All pairs to 1e-6, and the same risk; MCAP is for viewers only."""
    own = cortexc("measure", head_on, "--to", f"{name},mcap", "--out", tmp_path / "out", "--json").document
    assert [Path(path).name for path in own["written"]] == [f"head_on.{name}", "head_on.mcap"]
    again = cortexc("measure", own["written"][0], "--json").document
    assert again["risk"] == own["risk"]
    for key in ("min_distance", "max_closing_speed", "distance_at_ms", "ttc_at_ms"):
        assert again["pairs"][0][key] == pytest.approx(own["pairs"][0][key], abs=1e-6), key


def test_places_that_cannot_be_written_are_reported(cortexc: Cortexc, head_on: Path) -> None:
    """A file where a folder should be."""
    result = cortexc("measure", head_on, "--to", "csv", "--out", head_on / "deeper")
    assert result.code == Exit.USAGE
    assert "cannot write" in result.said


def test_a_missing_package_is_reported_with_its_extra(
    cortexc: Cortexc, head_on: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """And nothing is written."""
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    monkeypatch.setitem(__import__("sys").modules, "pyarrow.parquet", None)
    result = cortexc("measure", head_on, "--to", "parquet", "--out", tmp_path / "out")
    assert result.code == Exit.DIAGNOSTICS
    assert "[export]" in result.said
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        ((), Exit.USAGE, "measure what?"),
        (("none.csv",), Exit.USAGE, "there is no file"),
        (("head_om.csv",), Exit.USAGE, "head_on.csv"),
        (("left_turn.scn",), Exit.USAGE, "`cortexc left_turn.scn` runs a scenario"),
        (("road.xodr",), Exit.USAGE, "name the .xosc"),
        (("notes.odt",), Exit.USAGE, ".parquet"),
        (("head_on.csv", "--profile", "papre"), Exit.USAGE, "did you mean `paper`?"),
        (("head_on.csv", "--to", "parkett"), Exit.USAGE, "did you mean `parquet`?"),
        (("head_on.csv", "--step", "0"), Exit.USAGE, "seconds"),
        (("head_on.csv", "--to", "commonroad"), Exit.USAGE, "a road made by `map`; a recording can become xosc, csv"),
        (("head_on.csv", "--to", "scenic"), Exit.USAGE, "scenic needs the scenario"),
        (("head_on.csv", "--out", "x"), Exit.USAGE, "without --to"),
        (("head_on.csv", "--osc", "1.0"), Exit.USAGE, "without --to xosc"),
        (("head_on.csv", "--to", "csv", "--osc", "1.0"), Exit.USAGE, "without --to xosc"),
        (("head_on.csv", "--force"), Exit.USAGE, "without --to"),
        (("head_on.csv", "--near", "20"), Exit.USAGE, "without --all"),
        (("head_on.csv", "--all", "--ego", "ego"), Exit.USAGE, "which has no ego"),
        (("head_on.csv", "--all", "--near", "0"), Exit.USAGE, "between 1 and 1000 m"),
        (("head_on.csv", "--rate", "0"), Exit.USAGE, "a second"),
        (("head_on.csv", "--all", "--page", "new", "--table", "new"), Exit.USAGE, "are both `new`"),
        (("head_on.csv", "--all", "--page", "head_on.csv"), Exit.USAGE, "head_on.csv"),
        (("head_on.csv", "--ego", "lory"), Exit.DIAGNOSTICS, "did you mean `lorry`?"),
        (("head_on.csv", "--step", "0.0001", "--ego", "ego"), Exit.FINE, ""),
        (("bad.csv",), Exit.DIAGNOSTICS, "bad.csv, line 2, column `x`"),
    ],
)
def test_mistakes_are_reported_with_a_cure(
    cortexc: Cortexc,
    head_on: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[str, ...],
    code: Exit,
    words: str,
) -> None:
    """Which exit, on stderr, with help; under --json one document too."""
    monkeypatch.chdir(head_on.parent)
    Path("bad.csv").write_text("time,id,x,y\n0,a,one,0\n")
    result = cortexc("measure", *arguments)
    assert (result.code, words in result.said) == (code, True)
    if code is not Exit.FINE:
        assert "help:" in result.said
        assert result.out == ""
        document = cortexc("measure", *arguments, "--json").document
        assert document["schema"] == "cortexc/error"
        assert document["exit_code"] == code


# -- import -----------------------------------------------------------------------------------------------------------


def test_import_shows_the_road_and_the_remarks(
    cortexc: Cortexc, recording: Recording, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """What the reader says is shown, and its recording measured."""
    asked = []

    def read(path: Path, *, ego: str | None, step: float | None) -> SimpleNamespace:
        asked.append((path.name, ego, step))
        return SimpleNamespace(recording=recording, road=ROAD, remarks=("its traffic lights are not taken over",))

    monkeypatch.setattr(engine.interchange.openscenario.read, "read_openscenario", read)
    (tmp_path / "case.xosc").write_text("<OpenSCENARIO/>")
    result = cortexc("import", tmp_path / "case.xosc", "--ego", "ego", "--step", "0.05")
    assert result.code == Exit.FINE
    assert asked == [("case.xosc", "ego", 0.05)]
    for words in ("contact: ego and adversary", "3 roads, 1 junction", "traffic lights are not taken over", "Road"):
        assert words in result.out
    found = cortexc("measure", tmp_path / "case.xosc", "--json").document
    assert found["road"] == {"file": "road.xodr", "summary": "3 roads, 1 junction"}
    assert found["remarks"] == ["its traffic lights are not taken over"]


def test_an_import_keeps_its_road_and_its_params(cortexc: Cortexc, tmp_path: Path) -> None:
    """Written again as another version, with the road beside it, it is the same case: genome, road, numbers."""
    scenario = Path(__file__).parents[3] / "examples" / "left_turn.scn"
    assert cortexc("export", scenario, "--seed", "3", "--to", "xosc", "--out", tmp_path / "one").code == Exit.FINE
    first = tmp_path / "one" / "left_turn-seed3.xosc"
    once = cortexc("import", first, "--to", "xosc", "--osc", "1.0", "--out", tmp_path / "two", "--json").document
    again = tmp_path / "two" / "left_turn-seed3.xosc"
    assert 'revMinor="0"' in again.read_text()
    assert (tmp_path / "two" / "left_turn.xodr").read_bytes() == (tmp_path / "one" / "left_turn.xodr").read_bytes()
    assert not any("road is named" in remark for remark in once["remarks"])
    twice = cortexc("import", again, "--json").document
    assert set(once["provenance"]["genome"]) >= {"EGO_SPEED", "ADV_SPEED"}
    for key in ("road", "end", "risk", "collided"):
        assert twice[key] == once[key]
    assert twice["provenance"]["genome"] == once["provenance"]["genome"]
    shown = cortexc("import", first).out
    assert "Its params" in shown
    assert once["provenance"]["genome"]["EGO_SPEED"] in shown


def test_what_the_reader_refuses_is_reported(cortexc: Cortexc, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Message, place and cure."""

    def read(path: Path, **_: object) -> None:
        raise InterchangeError("there is no road `7`", "did you mean `1`?", f"{path.name}, line 12")

    monkeypatch.setattr(engine.interchange.openscenario.read, "read_openscenario", read)
    (tmp_path / "case.xosc").write_text("<OpenSCENARIO/>")
    result = cortexc("import", tmp_path / "case.xosc")
    assert result.code == Exit.DIAGNOSTICS
    assert "case.xosc, line 12: there is no road `7`" in result.said
    assert "did you mean `1`?" in result.said


def test_import_leaves_tables_to_measure(cortexc: Cortexc, head_on: Path) -> None:
    """And says so."""
    result = cortexc("import", head_on)
    assert result.code == Exit.USAGE
    assert f"`cortexc measure {head_on}`" in result.said


@pytest.mark.parametrize("command", ["measure", "import"])
def test_every_option_has_help(cortexc: Cortexc, command: str) -> None:
    """And the page names the columns of a table where one is read."""
    page = cortexc(command, "--help").out
    for option in ("--ego", "--step", "--profile", "--to", "--osc", "--out", "--force", "--json"):
        assert option in page
    assert ("omega-prime" in page) == (command == "measure")
    assert f"cortexc {command} " in cortexc("--help-all").out


def test_control_characters_of_a_stranger_do_not_reach_the_terminal(cortexc: Cortexc, tmp_path: Path) -> None:
    """Names are shown as they can be."""
    (tmp_path / "odd.csv").write_text("time,id,x,y,yaw\n0,\x1b[31mred,0,0,0\n0,b,40,0,0\n")
    assert "\x1b[31m" not in cortexc("measure", tmp_path / "odd.csv").out
    assert np.isfinite(cortexc("measure", tmp_path / "odd.csv", "--json").document["pairs"][0]["min_distance"])


def test_every_pair_of_a_recording(cortexc: Cortexc, tmp_path: Path, recording: Recording) -> None:
    """Ours, too: a contact between two steps is found as by `measure`; text, JSON, table and page say the same."""
    path = tmp_path / "case.csv"
    path.write_text(str(write_csv(recording, "case").files["case.csv"]))
    result = cortexc("measure", path, "--all", "--table", tmp_path / "t.csv", "--page", tmp_path / "p.html", "--json")
    assert result.code == Exit.FINE, result.err
    document = json.loads(result.out)
    assert document["schema"] == "cortexc/ranking"
    alone = json.loads(cortexc("measure", path, "--json").out)
    worst = document["windows"][0]
    assert worst["contact"]
    assert worst["risk"] == alone["risk"]["score"]
    assert worst["metrics"]["min_distance_time"] == pytest.approx(alone["end"]["time"], abs=1e-9)
    assert worst["ttc"] == 0.0
    line = (tmp_path / "t.csv").read_text().splitlines()[1].split(",")
    assert line[0] == "1"
    assert line[7:9] == ["1", str(worst["risk"])]
    assert "<svg" in (tmp_path / "p.html").read_text()
    assert "contact" in cortexc("measure", path, "--all").out
    again = cortexc("measure", path, "--all", "--page", path, "--table", tmp_path / "new.csv")
    assert again.code == Exit.USAGE
    assert not (tmp_path / "new.csv").exists()
    assert path.read_text().startswith("total_nanos")

"""`cortexc export`: files for other tools, none of them half written, and what cannot be done reported with a cure."""

import errno
import json
import os
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from cortex_dsl.console.terminal import Exit
from cortex_dsl.interchange.formats import FORMATS
from tests.cortex_dsl.cli.conftest import Result

Command = Callable[..., Result]


@pytest.fixture(scope="module")
def run(ga_run: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a search, into which files are exported."""
    return shutil.copytree(ga_run, tmp_path_factory.mktemp("export") / "run")


def test_one_case_with_its_road(cortexc: Command, run: Path, tmp_path: Path) -> None:
    """The worst one, unless another is named; all that a reader needs lies in one folder."""
    result = cortexc("export", run, "--to", "xosc", "--out", tmp_path)
    assert result.code == Exit.FINE
    assert sorted(path.name for path in tmp_path.iterdir()) == ["left_turn-case01.xosc", "left_turn.xodr"]
    assert "esmini" in result.out
    assert cortexc("export", run, "--case", "3", "--to", "xosc", "--out", tmp_path).code == Exit.FINE
    assert (tmp_path / "left_turn-case03.xosc").exists()


def test_files_go_into_the_run(cortexc: Command, run: Path) -> None:
    """Unless another folder is named; the journal itself names the run, too."""
    assert cortexc("export", run / "journal.sqlite", "--to", "scn").code == Exit.FINE
    assert (run / "exports" / "left_turn-case01.scn").exists()


def test_the_worst_cases_share_a_road(cortexc: Command, run: Path, tmp_path: Path) -> None:
    """As many files a format as cases, and each remark once."""
    result = cortexc("export", run, "--top", "3", "--to", "xosc,csv,xodr", "--out", tmp_path)
    names = [path.name for path in tmp_path.iterdir()]
    assert len(names) == 7
    assert names.count("left_turn.xodr") == 1
    assert result.out.count("omega-prime's columns hold neither") == 1


def test_the_scene_of_a_file(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """That which `cortexc FILE --seed N` shows; params may be held fixed."""
    words = ["--seed", "4", "-p", "EGO_BRAKE=0.5", "--to", "csv", "--json", "--out", tmp_path]
    document = cortexc("export", left_turn, *words).document
    (case,) = document["cases"]
    assert case["genome"]["EGO_BRAKE"] == "0.5"
    assert case["facts"]["command"].endswith("-p EGO_BRAKE=0.5 --seed 4")
    shown = cortexc(left_turn, "--seed", "4", "-p", "EGO_BRAKE=0.5", "--json").document
    assert case["facts"]["risk"].startswith(f"{shown['risk']['score']} of 22")


def test_a_concrete_file_has_its_own_stream(cortexc: Command, run: Path, tmp_path: Path) -> None:
    """A found case, exported from its copy, is the case."""
    cortexc("export", run, "--to", "csv", "--out", tmp_path)
    assert cortexc("export", run / "worst" / "01.scn", "--to", "csv", "--out", tmp_path).code == Exit.FINE
    assert (tmp_path / "01.csv").read_bytes() == (tmp_path / "left_turn-case01.csv").read_bytes()


def test_check_finds_nothing(cortexc: Command, run: Path, tmp_path: Path) -> None:
    """What every format that we read holds is what was run."""
    result = cortexc("export", run, "--to", "xosc,xodr,commonroad,csv,scenic,scn", "--check", "--out", tmp_path)
    assert result.code == Exit.FINE
    assert "checked: no finding" in result.out
    assert "motion at every sample, metrics and risk" in result.out.partition("checked: no finding")[2]


def test_a_check_says_what_it_did_not_look_at(cortexc: Command, run: Path, tmp_path: Path) -> None:
    """No finding is no more than what was held against the run; without a check, nothing was."""
    words = ("export", run, "--to", "xosc,mcap", "--mode", "maneuver", "--out", tmp_path)
    result = cortexc(*words, "--check")
    assert "motion is not checked" in " ".join(result.out.split())
    checked = cortexc(*words, "--check", "--json").document["checked"]
    assert list(checked) == ["xosc", "mcap"]
    assert "not checked" in checked["xosc"]
    assert cortexc(*words, "--json").document["checked"] == {}


def test_versions_and_modes_are_those_of_the_engine() -> None:
    """The command names them before it imports the engine."""
    from cortex_dsl.cli import export
    from cortex_dsl.interchange.formats import CHECKED_BY_MODE
    from engine.interchange.contract import MODES, OSC_VERSIONS

    assert (export.OSC_VERSIONS, export.MODES) == (OSC_VERSIONS, MODES)
    assert set(CHECKED_BY_MODE) == set(MODES)


def test_findings_are_shown(cortexc: Command, run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With their place and cure, and by the exit code."""
    from engine.interchange.contract import Finding

    finding = Finding("a.csv, ego", "it is elsewhere", "bring it back")
    row = replace(FORMATS["csv"], load_checker=lambda: lambda *_: iter([finding, finding]))
    monkeypatch.setitem(FORMATS, "csv", row)
    result = cortexc("export", run, "--to", "csv", "--check", "--out", tmp_path)
    assert result.code == Exit.DIAGNOSTICS
    assert "a.csv, ego: it is elsewhere" in result.out
    assert "help: bring it back" in result.out
    assert "1 finding" in result.out
    document = cortexc("export", run, "--to", "csv", "--check", "--json", "--out", tmp_path).document
    assert document["findings"] == [{"place": "a.csv, ego", "reason": "it is elsewhere", "cure": "bring it back"}]


def test_nothing_is_overwritten(cortexc: Command, run: Path, tmp_path: Path) -> None:
    """By something else; the same again is fine, and --force means it."""
    words = ("export", run, "--to", "scn", "--out", tmp_path)
    assert cortexc(*words).code == Exit.FINE
    assert "as it was" in cortexc(*words).out
    file = tmp_path / "left_turn-case01.scn"
    file.write_text("mine")
    result = cortexc(*words)
    assert result.code == Exit.USAGE
    assert "holds something else" in result.said
    assert "--force" in result.said
    assert file.read_text() == "mine"
    assert cortexc(*words, "--force").code == Exit.FINE
    assert file.read_text() != "mine"


def test_one_document(cortexc: Command, run: Path, tmp_path: Path) -> None:
    """Under --json: files with their formats and sizes, where each case comes from, what is not carried."""
    document = cortexc(
        "export", run, "--top", "2", "--to", "xosc", "--osc", "1.0", "--json", "--out", tmp_path
    ).document
    assert document["schema"] == "cortexc/export"
    assert document["osc"] == "1.0"
    assert [case["rank"] for case in document["cases"]] == [1, 2]
    assert document["findings"] is None
    for file in document["files"]:
        assert Path(file["path"]).stat().st_size == file["bytes"]
        assert file["new"]


@pytest.mark.parametrize("columns", [60, 80, 120])
def test_commands_are_never_broken(
    cortexc: Command, run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, columns: int
) -> None:
    """They are there to be copied, however narrow the terminal; everything else keeps to its width."""
    monkeypatch.setenv("COLUMNS", str(columns))
    folder = tmp_path / ("long" * 20)
    out = cortexc("export", run, "--to", "xosc,csv", "--out", folder).out
    assert f"--osc {folder / 'left_turn-case01.xosc'}\n" in out
    assert all(len(line.rstrip()) <= columns for line in out.splitlines() if str(folder) not in line)


def test_the_list_of_formats(cortexc: Command) -> None:
    """With who reads them; the help has it too."""
    listed, page = cortexc("export", "--to", "list").out, cortexc("export", "--help").out
    for name, entry in FORMATS.items():
        assert name in listed
        assert entry.readers in listed
        assert entry.readers in page


WRONG = {
    "no target": (["{run}"], "export to what?", "--to xosc"),
    "no source": (["--to", "xosc"], "export what?", "cortexc export"),
    "misspelt format": (["{run}", "--to", "xsoc"], "there is no format `xsoc`", "did you mean `xosc`?"),
    "unknown format": (["{run}", "--to", "mp4"], "there is no format `mp4`", "commonroad"),
    "case": (["{run}", "--case", "999", "--to", "csv"], "has no case 999", "1 is the worst"),
    "case 0": (["{run}", "--case", "0", "--to", "csv"], "must be at least 1", "lists every option"),
    "both": (
        ["{run}", "--case", "1", "--top", "2", "--to", "csv"],
        "--case and --top ask for different things",
        "give one of them",
    ),
    "run": (["{run}x", "--to", "csv"], "there is no folder", "did you mean"),
    "file": (["gone.scn", "--to", "csv"], "there is no file `gone.scn`", ""),
    "case of a file": (
        ["{scn}", "--case", "1", "--to", "csv"],
        "--case has no effect on a scenario, which has no cases",
        "leave --case out",
    ),
    "seed of a run": (["{run}", "--seed", "1", "--to", "csv"], "--seed has no effect on a run", "--case K"),
    "osc without xosc": (["{run}", "--to", "csv", "--osc", "1.0"], "--osc has no effect", "add xosc"),
    "osc": (["{run}", "--to", "xosc", "--osc", "2.0"], "invalid choice", "lists every option"),
    "recording": (["case.csv", "--to", "xosc"], "is a recording already", "cortexc measure"),
    "nul": (["{run}", "--to", "csv", "--out", "a\0b"], "cannot be the name", "--out"),
    "long name": (["{run}", "--to", "csv", "--out", "x" * 300], "file name too long", "--out"),
    "out is a file": (["{run}", "--to", "csv", "--out", "{scn}"], "cannot write", "is a file"),
    "out below a file": (["{run}", "--to", "csv", "--out", "{scn}/sub"], "cannot write", "is a file"),
}


@pytest.mark.parametrize("slip", WRONG)
def test_slips_have_a_cure(cortexc: Command, run: Path, left_turn: Path, slip: str) -> None:
    """One sentence, and what to do."""
    words, message, cure = WRONG[slip]
    result = cortexc("export", *(word.replace("{run}", str(run)).replace("{scn}", str(left_turn)) for word in words))
    assert result.code == Exit.USAGE
    assert message in result.said
    assert cure in result.said
    assert result.out == ""


def test_a_folder_in_a_files_place(cortexc: Command, run: Path, tmp_path: Path) -> None:
    (tmp_path / "left_turn-case01.csv").mkdir()
    result = cortexc("export", run, "--to", "csv", "--out", tmp_path)
    assert result.code == Exit.USAGE
    assert "take that folder away" in result.said


def test_a_full_disk(cortexc: Command, run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is reported, and leaves nothing behind."""

    def full(_handle: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    result = cortexc("export", run, "--to", "xosc", "--out", tmp_path / "new")
    assert result.code == Exit.USAGE
    assert "the disk is full" in result.said
    assert "free some space" in result.said
    assert list(tmp_path.iterdir()) == []


def test_a_file_with_errors(cortexc: Command, tmp_path: Path) -> None:
    """They are shown as by `cortexc FILE`."""
    file = tmp_path / "wrong.scn"
    file.write_text("ego = new Carr on road\n")
    result = cortexc("export", file, "--to", "csv", "--out", tmp_path)
    assert result.code == Exit.DIAGNOSTICS
    assert "did you mean `Car`?" in result.said


def test_json_of_a_file_with_errors_is_a_document(cortexc: Command, tmp_path: Path) -> None:
    """That of `cortexc FILE --json`; the command that shows a scene again has no --json for that."""
    file = tmp_path / "wrong.scn"
    file.write_text("ego = new Carr on road\n")
    result = cortexc("export", file, "--to", "csv", "--json", "--out", tmp_path)
    assert result.code == Exit.DIAGNOSTICS
    assert result.document["schema"] == "cortexc/diagnostics"
    assert result.document["errors"] == 1
    file.write_text("ego = new Car on road\nterminate after 1 s\n")
    (case,) = cortexc("export", file, "--to", "csv", "--json", "--out", tmp_path).document["cases"]
    assert case["facts"]["command"] == f"cortexc {file.name} --seed 0"


def test_the_list_as_a_document(cortexc: Command) -> None:
    listed = cortexc("export", "--to", "list", "--json").document
    assert listed["schema"] == "cortexc/formats"
    assert [each["name"] for each in listed["formats"]] == list(FORMATS)
    assert listed["formats"][0]["suffixes"] == [".xosc", ".xodr"]


def test_a_file_that_begins_as_an_option_does(
    cortexc: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`./` before it is what makes it a file, in the command that repeats it, too."""
    monkeypatch.chdir(tmp_path)
    Path("-x.scn").write_text("ego = new Car on road\nterminate after 1 s\n")
    (case,) = cortexc("export", "./-x.scn", "--to", "csv", "--json").document["cases"]
    assert case["facts"]["command"] == "cortexc ./-x.scn --seed 0"
    (table,) = Path("exports").iterdir()
    Path("-y.csv").write_bytes(table.read_bytes())
    assert cortexc("measure", "./-y.csv", "--json").document["reproduce"] == "cortexc measure ./-y.csv"


def test_what_stands_in_the_way_is_reported_and_replaced(cortexc: Command, run: Path, tmp_path: Path) -> None:
    """A pipe does not hang, a link that leads nowhere is no missing file; --force replaces both."""
    os.mkfifo(tmp_path / "left_turn-case01.scn")
    (tmp_path / "left_turn-case01.csv").symlink_to("nowhere")
    words = ("export", run, "--to", "csv,scn", "--out", tmp_path)
    result = cortexc(*words)
    assert result.code == Exit.USAGE
    assert "and 1 more holds something else" in result.said
    assert cortexc(*words, "--force").code == Exit.FINE
    assert all(path.is_file() and not path.is_symlink() for path in tmp_path.iterdir())


def test_a_file_without_a_scene(cortexc: Command, tmp_path: Path) -> None:
    file = tmp_path / "never.scn"
    file.write_text("ego = new Car on road\nrequire ego.position.x > 1000 m\n")
    result = cortexc("export", file, "--to", "csv", "--out", tmp_path / "out")
    assert result.code == Exit.NO_SCENE
    assert "no valid scene" in result.said
    assert not (tmp_path / "out").exists()


def test_a_folder_of_runs(cortexc: Command, run: Path, tmp_path: Path) -> None:
    """One of them has to be named."""
    shutil.copytree(run, tmp_path / "runs" / "one")
    result = cortexc("export", tmp_path / "runs", "--to", "csv")
    assert result.code == Exit.USAGE
    assert "name one of them" in result.said


def test_json_of_a_slip_is_a_document(cortexc: Command, run: Path) -> None:
    """Whatever happens there is exactly one."""
    result = cortexc("export", run, "--to", "mp4", "--json")
    assert result.code == Exit.USAGE
    assert json.loads(result.out)


def test_what_a_format_cannot_carry(
    cortexc: Command, run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The case and the format are named, and nothing of the format is written."""
    from engine.errors import InterchangeError

    def refused(*_: object) -> None:
        raise InterchangeError("a lorry that flies", "keep it on the ground")

    monkeypatch.setattr("engine.interchange.tables.write_csv", refused)
    result = cortexc("export", run, "--to", "scn,csv", "--out", tmp_path / "out")
    assert result.code == Exit.USAGE
    assert "left_turn-case01 as csv: a lorry that flies" in result.said
    assert "keep it on the ground" in result.said
    assert {path.suffix for path in (tmp_path / "out").iterdir()} == {".scn"}


def test_formats_that_can_are_written_beside_one_that_cannot(cortexc: Command, tmp_path: Path) -> None:
    """The one is reported with its cure, with the exit code of what cannot be done; alone it leaves nothing."""
    file = tmp_path / "left.scn"
    file.write_text("map intersection(left_hand=True)\nego = new Car in road\nterminate after 1 s\n", encoding="utf-8")
    result = cortexc("export", file, "--to", "xosc,scenic,csv,scn", "--check", "--out", tmp_path / "out")
    assert result.code == Exit.USAGE
    assert "right-hand traffic" in result.said
    assert "leave scenic out" in result.said
    assert {path.suffix for path in (tmp_path / "out").iterdir()} == {".xosc", ".xodr", ".csv", ".scn"}
    assert "checked: no finding" in result.out
    document = cortexc("export", file, "--to", "scenic,csv", "--out", tmp_path / "two", "--json").document
    assert [refused["format"] for refused in document["refused"]] == ["scenic"]
    assert cortexc("export", file, "--to", "scenic", "--out", tmp_path / "one").code == Exit.USAGE
    assert not (tmp_path / "one").exists()


def test_a_player_is_named(cortexc: Command, run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A check by a player wants a player; without one nothing is written."""
    monkeypatch.delenv("CORTEXC_ESMINI", raising=False)
    words = ("export", run, "--to", "xosc", "--out", tmp_path / "files")
    for flags, message in (
        (("--check", "--player", "esmini"), "esmini is not known here"),
        (("--player", "esmini"), "--player has no effect without --check"),
        (("--esmini", tmp_path), "--esmini has no effect without --player esmini"),
    ):
        result = cortexc(*words, *flags)
        assert result.code == Exit.USAGE
        assert message in result.said
    assert not (tmp_path / "files").exists()


def test_a_certificate_lies_beside_what_was_played(cortexc: Command, run: Path, tmp_path: Path) -> None:
    """What is no esmini is a finding, and the certificate says so; files are written all the same."""
    (tmp_path / "libesminiLib.so").write_text("nothing", encoding="utf-8")
    words = ("export", run, "--to", "xosc", "--out", tmp_path / "files", "--check", "--player", "esmini")
    result = cortexc(*words, "--esmini", tmp_path, "--json")
    assert result.code == Exit.DIAGNOSTICS
    (certificate,) = result.document["certificates"]
    assert "not a library of esmini" in certificate["problem"]
    (beside,) = (tmp_path / "files").glob("*.fidelity.json")
    assert json.loads(beside.read_text(encoding="utf-8")) == certificate
    assert "not a library of esmini" in result.document["findings"][0]["reason"]


def test_an_export_for_carla_names_scenario_runner(cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """With the rate of its samples; other files are opened as usual."""
    said = cortexc("export", left_turn, "--seed", 4, "--for", "carla", "--to", "xosc,csv", "--out", tmp_path).out
    words = " ".join(said.split())
    assert "python scenario_runner.py --sync --frameRate 20 --openscenario" in words
    assert "esmini --window" not in words
    assert "cortexc measure" in words

"""What is handed on names files without the folders of the computer on which it was made."""

import json
import shutil
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from engine.search.store import located, seen_from, without_folders

Command = Callable[..., Any]
pytestmark = pytest.mark.usefixtures("small_design")
SMALL = ("--ga", "--generations", 2, "--population", 20, "--seed", 5, "--jobs", 1)
ROADS = Path(__file__).parents[3] / "examples" / "roads"


@pytest.mark.parametrize("form", ["{}/a.scn", "--out={}/a.scn", "-p=FILE={}/a.scn"])
def test_words_of_a_command_line(form: str) -> None:
    """An absolute path is its file's name, in whatever option it stands; anything else is as it was typed."""
    assert without_folders(form.format("/home/somebody")) == form.format("@").replace("@/", "")
    assert without_folders(form.format("here")) == form.format("here")


def test_names_as_seen_from_a_run(tmp_path: Path) -> None:
    """Relative to its folder, from which they are found again; without a common folder only the name is left."""
    run, file = tmp_path / "runs" / "first", tmp_path / "a.scn"
    run.mkdir(parents=True)
    file.write_text("")
    assert seen_from(run, str(file)) == "../../a.scn"
    assert located(run, "../../a.scn") == str(file)
    assert seen_from(run, "/nowhere/a.scn") == "a.scn"
    assert seen_from(run, "examples/a.scn") == located(run, "examples/a.scn") == "examples/a.scn"


def prepared(home: Path, left_turn: Path, cortexc: Command, *, of_a_map: bool) -> Path:
    """Return a copy of the scenario in a new folder; its roads may be those of a file beside it."""
    home.mkdir()
    file = Path(shutil.copy(left_turn, home))
    if of_a_map:
        assert cortexc("export", file, "--to", "xodr", "--out", home).code == 0
        text = file.read_text().split("\n")
        file.write_text(
            "\n".join('map opendrive("left_turn.xodr")' if line.startswith("map ") else line for line in text)
        )
    return file


def files_of(home: Path) -> list[Path]:
    return [path for path in home.rglob("*") if path.is_file()]


def naming_folder(home: Path) -> list[str]:
    """Return the files that contain the path of their folder; archives are unpacked."""

    def content(path: Path) -> bytes:
        if path.suffix != ".npz":
            return path.read_bytes()
        with zipfile.ZipFile(path) as archive:  # numpy keeps texts in UTF-32
            return b"".join(map(archive.read, archive.namelist())).replace(b"\0", b"")

    return [str(path.relative_to(home)) for path in files_of(home) if str(home).encode() in content(path)]


@pytest.mark.parametrize("of_a_map", [False, True])
def test_no_file_of_a_study_names_the_folder(of_a_map: bool, cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """Two scenarios with the same file name, by absolute paths; the study goes on, and tells of an edited file."""
    home = tmp_path / "some folder"
    home.mkdir()
    scenarios = [prepared(home / name, left_turn, cortexc, of_a_map=of_a_map) for name in ("one", "other")]
    scenarios[0].write_text(scenarios[0].read_text() + "from beside import LIMIT\nterminate after LIMIT\n")
    (home / "beside.scn").write_text("LIMIT = 3 s\n")
    scenarios[0].write_text(scenarios[0].read_text().replace("from beside", 'from "../beside.scn"'))
    study = home / "study"
    size = ("--generations", 2, "--population", 6, "--methods", "random", "--jobs", 1)
    assert cortexc("study", *scenarios, "--runs", 2, *size, "--out", study).code == 0
    assert cortexc("report", study).code == 0
    assert cortexc("verify", study).code == 0
    assert len(files_of(study)) >= 8
    assert naming_folder(study) == []
    assert {row["name"] for row in json.loads((study / "summary.json").read_text())["scenarios"]} == {
        "one/left_turn.scn",
        "other/left_turn.scn",
    }
    scenarios[1].write_text(scenarios[1].read_text() + "\n")
    (home / "beside.scn").write_text("LIMIT = 4 s\n")
    notes = cortexc("resume", study, "--json").document["notes"]
    assert [note.partition(" ")[0] for note in notes] == ["`../other/left_turn.scn`", "`../beside.scn`"]


@pytest.mark.parametrize("of_a_map", [False, True])
def test_no_file_names_the_folder(of_a_map: bool, cortexc: Command, left_turn: Path, tmp_path: Path) -> None:
    """Search, report and every export of a run and of a file, all named by absolute paths; and the run goes on."""
    home = tmp_path / "some folder"
    file = prepared(home, left_turn, cortexc, of_a_map=of_a_map)
    run = home / "run"
    assert cortexc(file, *SMALL, "--out", run).code == 0
    assert cortexc("resume", run, "--generations", 3).code == 0
    assert cortexc("verify", run, "--sample", 2).code == 0
    assert cortexc("report", run, "--cases", 1).code == 0
    formats = "xosc,xodr,commonroad,csv,parquet,mcap,scn" + ("" if of_a_map else ",scenic")
    assert cortexc("export", run, "--to", formats, "--out", home / "of_run").code == 0
    assert cortexc("export", file, "--seed", 4, "--to", formats, "--out", home / "of_file").code == 0
    assert len(files_of(home)) > 30
    assert naming_folder(home) == []

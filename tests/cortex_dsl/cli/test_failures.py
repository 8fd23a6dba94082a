"""What the command does when something goes wrong: a slip, a path, a bug of ours, a reader that leaves."""

import errno
import json
import os
from pathlib import Path

import pytest

import cortex_dsl.cli.command_table
from cortex_dsl.cli import main
from cortex_dsl.console.terminal import Terminal, UsageError
from cortex_dsl.console.user_files import read_source, write_output


def test_missing_file_suggests_the_nearest(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A misspelt path ends with 2 and names the file that was meant."""
    (tmp_path / "left_turn.scn").write_text("")
    assert main([str(tmp_path / "left_trun.scn"), "--check"]) == 2
    assert "did you mean" in (error := capsys.readouterr().err)
    assert "left_turn.scn" in error


@pytest.mark.parametrize(
    ("name", "cure"),
    [
        ("town.xodr", 'map opendrive("{}")'),
        ("case.XOSC", "cortexc import {}"),
        ("drive.csv", "cortexc measure {}"),
        ("drive.mcap", "cortexc measure {}"),
    ],
)
def test_other_files_are_told_by_their_names(
    name: str, cure: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A map or recording is no scenario with a mistake in its first line: the message says what takes it."""
    path = tmp_path / name
    path.write_text("<OpenDRIVE/>")
    assert main([str(path), "--check"]) == 2
    assert cure.replace("{}", str(path)) in " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"\x7fELF\x00\x00", "not a text file"),
        (b"x = 1\ny = \xff\xfe", "not UTF-8"),
        (b"#" * (5 * 1024 * 1024), "larger than"),
        (b"", "no statements"),
    ],
)
def test_unreadable_contents(content: bytes, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What is no text is refused before the parser sees it, as a diagnostic."""
    path = tmp_path / "a.scn"
    path.write_bytes(content)
    assert main([str(path), "--check"]) == 1
    assert message in capsys.readouterr().err


def test_folder_instead_of_a_file(tmp_path: Path) -> None:
    """A folder is refused with a file in it as advice."""
    (tmp_path / "a.scn").write_text("")
    with pytest.raises(UsageError, match="is a folder") as caught:
        read_source(tmp_path)
    assert "a.scn" in caught.value.cure


def broken(*_: object) -> int:
    raise ValueError("the cat walked over the keyboard")


def test_our_bug(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """A bug of ours ends with 70, one line, and a file to send; never with a traceback."""
    monkeypatch.setattr(cortex_dsl.cli.command_table, "execute", broken)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.delenv("CORTEXC_DEBUG", raising=False)
    assert main(["a.scn"]) == 70
    error = capsys.readouterr().err
    assert "the cat walked over the keyboard" in error
    assert "please report" in error
    assert "Traceback" not in error
    (details,) = tmp_path.glob("cortexc-bug-*.txt")
    assert "Traceback" in details.read_text()


def test_our_bug_with_nowhere_to_write(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Where no file can be written, by nobody, the line itself says where it happened."""
    (tmp_path / "file").touch()
    monkeypatch.delenv("CORTEXC_DEBUG", raising=False)
    monkeypatch.setattr(cortex_dsl.cli.command_table, "execute", broken)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "file" / "folder"))
    assert main(["a.scn"]) == 70
    assert "broken in line" in capsys.readouterr().err


def test_debug_shows_the_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    """CORTEXC_DEBUG=1 lets the exception through, for a developer."""
    monkeypatch.setattr(cortex_dsl.cli.command_table, "execute", broken)
    monkeypatch.setenv("CORTEXC_DEBUG", "1")
    with pytest.raises(ValueError, match="the cat"):
        main(["a.scn"])


def test_interrupted(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Ctrl-C anywhere ends with 130 and a word."""

    def interrupted(*_: object) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr(cortex_dsl.cli.command_table, "execute", interrupted)
    assert main(["a.scn"]) == 130
    assert "interrupted" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "code"),
    [(["a.scn", "--json", "--populaton", "3"], 2), (["--json"], 2), (["nowhere/a.scn", "--json"], 2)],
)
def test_json_documents_a_slip(arguments: list[str], code: int, capsys: pytest.CaptureFixture[str]) -> None:
    """Under --json stdout holds one document even where the command could not start."""
    assert main(arguments) == code
    captured = capsys.readouterr()
    document = json.loads(captured.out)
    assert (document["schema"], document["exit_code"]) == ("cortexc/error", code)
    assert f"cortexc: {document['message']}" in captured.err


def test_json_documents_an_interrupt(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Ctrl-C before there was a result leaves a document too."""

    def interrupted(*_: object) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr(cortex_dsl.cli.command_table, "execute", interrupted)
    assert main(["a.scn", "--json"]) == 130
    assert json.loads(capsys.readouterr().out)["exit_code"] == 130


def test_json_writes_one_document_only(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """A failure after the result was written adds no second document."""

    def late(_: object, terminal: Terminal) -> int:
        terminal.write("{}")
        raise UsageError("the disk is full")

    monkeypatch.setattr(cortex_dsl.cli.command_table, "execute", late)
    assert main(["a.scn", "--json"]) == 2
    assert json.loads(capsys.readouterr().out) == {}


def test_what_cannot_be_written_leaves_what_was_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a full disk an older page stays whole, and no half of a new one is left."""

    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, "no space left on device")

    old, new = tmp_path / "old.html", tmp_path / "new.html"
    old.write_text("before")
    monkeypatch.setattr("engine.atomic.os.fsync", full)
    for page in (old, new):
        with pytest.raises(UsageError, match="the disk is full"):
            write_output(page, "after")
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"old.html": "before"}
    write_output(Path(os.devnull), "after")


@pytest.mark.parametrize("methods", [("--ga",), ("--ga", "--random")])
def test_a_search_without_a_scene_names_what_leaves_the_road(
    methods: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As runs and samples do, in the report and in the document."""
    (path := tmp_path / "off.scn").write_text(
        "map road()\nparam GAP = Range(2, 4) m\nspot = new OrientedPoint in network.lanes[0].centerline\n"
        "ego = new Car at spot\nbus = new Bus right of spot by GAP\n"
    )
    words = [str(path), *methods, "--generations", "1", "--population", "4", "--jobs", "1", "--max-attempts", "50"]
    assert main([*words, "--out", str(tmp_path / "run")]) == 3
    shown = " ".join(capsys.readouterr().out.split())
    assert shown.count("off the road: `bus` in 100.0 % of the rejected attempts") == len(methods)
    assert "`with regionContainedIn None`" in shown
    assert main([*words, "--out", str(tmp_path / "other"), "--json"]) == 3
    searches = json.loads(capsys.readouterr().out)["searches"]
    assert [each["blame"]["off_road"][0] for each in searches] == [{"object": "bus", "share": 1.0}] * len(methods)

"""`cortexc fmt`: what is written, what is only reported, and how it ends."""

import io
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

UGLY = "x=1 # y\nbehavior B( ):\n  wait\n"
FINE = "x = 1  # y\n\nbehavior B():\n    wait\n"

Command = Callable[..., Any]


@pytest.fixture
def ugly(tmp_path: Path) -> Path:
    path = tmp_path / "ugly.scn"
    path.write_text(UGLY)
    return path


def test_a_file_is_written(cortexc: Command, ugly: Path) -> None:
    """The file is in the one layout, keeps its mode, and the second time there is nothing to do."""
    ugly.chmod(0o640)
    result = cortexc("fmt", ugly)
    assert (result.code, ugly.read_text()) == (0, FINE)
    assert "formatted" in result.out
    assert ugly.stat().st_mode & 0o777 == 0o640
    assert list(ugly.parent.iterdir()) == [ugly]
    assert "1 file fine already" in cortexc("fmt", ugly).out


def test_check_names_what_would_change(cortexc: Command, ugly: Path) -> None:
    """Nothing is written, and the exit code says whether something would be."""
    (ugly.parent / "fine.scn").write_text(FINE)
    result = cortexc("fmt", ugly.parent, "--check")
    assert result.code == 1
    assert f"would change {ugly}" in result.out
    assert "fine.scn" not in result.out
    assert ugly.read_text() == UGLY
    assert cortexc("fmt", ugly.parent / "fine.scn", "--check").code == 0


def test_diff_shows_the_lines(cortexc: Command, ugly: Path) -> None:
    """A unified diff; it alone is no error."""
    result = cortexc("fmt", ugly, "--diff")
    assert result.code == 0
    assert "-  wait\n+x = 1  # y\n" in result.out
    assert ugly.read_text() == UGLY
    assert cortexc("fmt", ugly, "--diff", "--check").code == 1


def test_folders_are_searched(cortexc: Command, ugly: Path) -> None:
    """All scenarios below a folder, hidden folders left out; other files only if they are named."""
    for name in ("deep/down/a.scn", ".hidden/b.scn", "c.txt"):
        (ugly.parent / name).parent.mkdir(parents=True, exist_ok=True)
        (ugly.parent / name).write_text(UGLY)
    assert "2 files formatted" in cortexc("fmt", ugly.parent).out
    assert (ugly.parent / "deep/down/a.scn").read_text() == FINE
    assert (ugly.parent / ".hidden/b.scn").read_text() == UGLY
    assert (ugly.parent / "c.txt").read_text() == UGLY
    assert cortexc("fmt", ugly.parent / "c.txt").code == 0
    assert (ugly.parent / "c.txt").read_text() == FINE


def test_a_broken_file_does_not_stop_the_others(cortexc: Command, ugly: Path) -> None:
    """Its errors are shown, it stays as it is, and the rest is formatted."""
    broken = ugly.parent / "broken.scn"
    broken.write_text("x = (1\n")
    result = cortexc("fmt", ugly.parent)
    assert result.code == 1
    assert "SCN102" in result.said
    assert broken.read_text() == "x = (1\n"
    assert ugly.read_text() == FINE


def test_line_breaks_and_mark_of_a_file_stay(cortexc: Command, tmp_path: Path) -> None:
    """Bytes that are the editor's business."""
    path = tmp_path / "windows.scn"
    path.write_bytes(b"\xef\xbb\xbfx=1\r\ny  = 2")
    assert cortexc("fmt", path).code == 0
    assert path.read_bytes() == b"\xef\xbb\xbfx = 1\r\ny = 2\r\n"


@pytest.mark.parametrize("content", [b"", b"# only\n", b"\xff", b"\0"])
def test_files_without_statements_are_no_reason_to_stop(cortexc: Command, tmp_path: Path, content: bytes) -> None:
    """A file of comments is formatted; one that is no text is refused as everywhere."""
    path = tmp_path / "odd.scn"
    path.write_bytes(content)
    result = cortexc("fmt", path)
    assert result.code == (1 if content in (b"\xff", b"\0") else 0)
    assert path.read_bytes() == content


@pytest.mark.parametrize("arguments", [(), ("-", "a.scn"), ("nowhere.scn",), ("--chek", "."), ("nowhere\0.scn",)])
def test_wrong_calls(cortexc: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str]) -> None:
    """A mistake on the command line is answered with a cure."""
    monkeypatch.chdir(tmp_path)
    result = cortexc("fmt", *arguments)
    assert result.code == 2
    assert result.err.startswith("cortexc: ")


def test_an_empty_folder_is_a_slip(cortexc: Command, tmp_path: Path) -> None:
    """Nothing to do is not the same as all fine."""
    assert cortexc("fmt", tmp_path).code == 2


def test_what_cannot_be_written_is_left_as_it_was(
    cortexc: Command, ugly: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A full disk or a missing right: exit 2, the old content, and no file beside it."""

    def refuse(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "replace", refuse)
    result = cortexc("fmt", ugly)
    assert result.code == 2
    assert "permission denied" in result.said
    assert list(ugly.parent.iterdir()) == [ugly]
    monkeypatch.setattr(os, "access", lambda *_: False)
    assert cortexc("fmt", ugly).code == 2
    assert ugly.read_text() == UGLY


@pytest.mark.parametrize(
    ("text", "arguments", "code", "out"),
    [
        (UGLY, (), 0, FINE),
        (UGLY, ("--check",), 1, "would change <stdin>\n"),
        (FINE, ("--check",), 0, ""),
        ("x = (", (), 1, ""),
    ],
)
def test_stdin(
    cortexc: Command, monkeypatch: pytest.MonkeyPatch, text: str, arguments: tuple[str], code: int, out: str
) -> None:
    """`-` reads stdin and writes stdout: the text, or nothing where it has errors."""
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
    written = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(written, encoding="utf-8"))
    result = cortexc("fmt", "-", *arguments)
    sys.stdout.flush()
    assert (result.code, written.getvalue().decode()) == (code, out)


def test_help(cortexc: Command) -> None:
    """The command explains itself."""
    assert "--check" in cortexc("fmt", "--help").out


def test_no_number_is_computed(left_turn: Path) -> None:
    """Formatting loads neither numba nor scipy nor pymunk."""
    code = (
        "import sys; from cortex_dsl.cli import main; main(['fmt', '--check', sys.argv[1]]); "
        "print({'numba', 'scipy', 'pymunk'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code, left_turn], capture_output=True, text=True, check=True)
    assert done.stdout.endswith("set()\n")


def test_the_examples_are_laid_out(cortexc: Command) -> None:
    """What newcomers copy from is in the one layout."""
    assert cortexc("fmt", "--check", Path(__file__).parents[3] / "examples").code == 0


def test_a_script_of_scenic_2_is_rewritten(cortexc: Command, tmp_path: Path) -> None:
    """With `--from scenic2` only, and the second time there is nothing to do."""
    path = tmp_path / "old.scn"
    path.write_text("monitor Lights:\n    wait\n\nego = Car on road\n")
    assert cortexc("fmt", path).code == 1
    assert cortexc("fmt", path, "--from", "scenic2").code == 0
    assert path.read_text() == "monitor Lights():\n    wait\n\nego = new Car on road\nrequire monitor Lights()\n"
    assert "1 file fine already" in cortexc("fmt", path, "--from", "scenic2").out

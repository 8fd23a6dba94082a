"""Files: what is refused, and how."""

from pathlib import Path

import pytest

from cortex_dsl.diagnostics import CompileError
from cortex_dsl.report.findings.snippet import render_text
from cortex_dsl.syntax.errors import MAX_BYTES
from cortex_dsl.syntax.reading import decode, read_source

REFUSED = {
    "SCN130": [b"", b"  \n\n", b"# only a comment", b"\xef\xbb\xbf\n"],
    "SCN131": [b"x = \0 3", "x = 3".encode("utf-16"), b"\x7fELF\0\0"],
    "SCN132": [b"x = 3\ny = '\xff'", b"gr\xf6\xdfe = 3"],
    "SCN133": [b"x = 1\n" * MAX_BYTES],
    "SCN134": [b"x = 1\ry = 2\r", b"x = 1\n\ry = 2\n"],
}


@pytest.mark.parametrize(("code", "content"), [(code, each) for code, several in REFUSED.items() for each in several])
def test_refused_content(code: str, content: bytes) -> None:
    """Content that is no scenario is a diagnostic with a cure, which can be drawn."""
    with pytest.raises(CompileError) as caught:
        decode("some.scn", content)
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == code
    assert diagnostic.cure
    assert render_text(caught.value.source, [diagnostic]).startswith("some.scn:")


def test_place_of_a_wrong_byte() -> None:
    """What is not UTF-8 is shown in its line."""
    with pytest.raises(CompileError) as caught:
        decode("some.scn", b"x = 3\ny = '\xff'\n")
    error = caught.value
    assert error.source.position(error.diagnostics[0].label.span.start).line == 2


def test_a_file_is_read_without_its_byte_order_mark(tmp_path: Path) -> None:
    """The text is that of the file; line breaks stay as they are, so that places are right."""
    path = tmp_path / "a.scn"
    path.write_bytes(b"\xef\xbb\xbfx = 3\r\ny = 4\r\n")
    source = read_source(path)
    assert source.name == str(path)
    assert source.text == "x = 3\r\ny = 4\r\n"


def test_what_the_system_refuses_is_left_to_the_command(tmp_path: Path) -> None:
    """A missing file and a folder are not the content's fault."""
    with pytest.raises(FileNotFoundError):
        read_source(tmp_path / "none.scn")
    with pytest.raises(OSError, match="directory"):
        read_source(tmp_path)


def test_line_ends_that_are_fine() -> None:
    """Those of Unix and Windows, mixed, and what tools make of them by accident."""
    for text in (b"x = 1\r\ny = 2\n", b"x = 1\r\r\ny = 2\r\r\n", b"x = 1\r\n\r"):
        assert decode("some.scn", text).text == text.decode()


def test_place_of_a_lone_carriage_return() -> None:
    """The end of the first line that it was meant to end, shown alone."""
    with pytest.raises(CompileError) as caught:
        decode("some.scn", b"x = 1\ry = 2\r")
    text = render_text(caught.value.source, caught.value.diagnostics)
    assert text.startswith("some.scn:1:6: error[SCN134]")
    assert "1 | x = 1\n" in text

"""From a path to a `Source`: the contents of the file are checked here, its existence is checked by the caller."""

import re
from pathlib import Path
from typing import NoReturn

from cortex_dsl.diagnostics import CompileError, Diagnostic
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import errors
from cortex_dsl.syntax.errors import MAX_BYTES

_LONE_RETURN = re.compile(r"\r(?!\r*\n|\r*\Z)")
"""A carriage return before other text; several before a line feed are an accident of tools, and do no harm."""
_NOTHING = re.compile(r"(?:\s|\ufeff|#[^\n]*(?:\n|\Z))*\Z")


def read_source(path: str | Path) -> Source:
    """Return the text of a file under the requested name.

    Raises:
        CompileError: the content is no text in UTF-8, is empty, or is too large.
        OSError: there is no such file, it is a directory, or it may not be read.
    """
    with Path(path).open("rb") as file:
        content = file.read(MAX_BYTES + 1)
    return decode(str(path), content)


def decode(name: str, content: bytes) -> Source:
    """The text that a file's bytes are.

    Raises:
        CompileError: as `read_source`.
    """
    source = decode_text(name, content)
    if _NOTHING.match(source.text):
        _refuse(
            source,
            errors.EMPTY_FILE.at(
                Span(0, 0),
                "this file has no statements",
                reason=errors.EMPTY_FILE.reason,
                cure="begin with `map intersection(ways=4)` and `ego = new Car at …`",
            ),
        )
    return source


def decode_text(name: str, content: bytes) -> Source:
    """The text that a file's bytes are, which need hold no statement.

    Raises:
        CompileError: it is no text in UTF-8, or too large.
    """
    check_size(name, len(content))
    if b"\0" in content:
        _refuse(
            Source(name, ""),
            errors.BINARY_FILE.at(
                Span(0, 0),
                "this is not a text file",
                reason=f"byte {content.index(0)} is zero",
                cure="give a `.scn` file; if this is one, save it as UTF-8 (not UTF-16)",
            ),
        )
    try:
        source = Source(name, content.decode("utf-8-sig"))
    except UnicodeDecodeError as bad:
        _refuse(*_wrong_encoding(name, content, bad))
    if (lone := _LONE_RETURN.search(source.text)) is not None:
        _refuse(*_old_line_ends(source, lone.start()))
    return source


def check_size(name: str, size: int) -> None:
    """Raise CompileError for a text of more bytes or characters than a scenario ever has."""
    if size > MAX_BYTES:
        _refuse(
            Source(name, ""),
            errors.LARGE_FILE.at(
                Span(0, 0),
                f"this file is larger than {MAX_BYTES >> 10} KiB",
                reason=errors.LARGE_FILE.reason,
                cure="check whether it is a scenario at all, or split it",
            ),
        )


def _wrong_encoding(name: str, content: bytes, bad: UnicodeDecodeError) -> tuple[Source, Diagnostic]:
    """Return the text with a replacement character for each bad byte, and the diagnostic for the first of those."""
    source = Source(name, content.decode("utf-8", errors="replace"))
    start = len(content[: bad.start].decode("utf-8"))
    return source, errors.WRONG_ENCODING.at(
        Span(start, start + 1),
        "this file is not UTF-8",
        f"byte 0x{content[bad.start]:02x}",
        reason=errors.WRONG_ENCODING.reason,
        cure="save it as UTF-8",
    )


def _old_line_ends(source: Source, start: int) -> tuple[Source, Diagnostic]:
    """Return the text with line feeds for lone carriage returns, and the diagnostic for the first of those."""
    shown, count = Source(source.name, _LONE_RETURN.sub("\n", source.text)), len(_LONE_RETURN.findall(source.text))
    return shown, errors.LONE_RETURN.at(
        Span(start, start),
        "a carriage return alone does not end a line",
        "the text after it would continue this line",
        reason=f"the file has {count} of them" if count > 1 else "it is the only one in the file",
        cure="save the file with the line ends of Unix (LF) or Windows (CRLF)",
    )


def _refuse(source: Source, diagnostic: Diagnostic) -> NoReturn:
    raise CompileError(source, [diagnostic])

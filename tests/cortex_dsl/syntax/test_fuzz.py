"""Whatever is read, the answer is a tree or diagnostics, and soon."""

import time
from collections.abc import Callable

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cortex_dsl.diagnostics import CompileError
from cortex_dsl.report.findings.snippet import as_json, render_text
from cortex_dsl.source import Source
from cortex_dsl.syntax import parse
from cortex_dsl.syntax.reading import decode
from tests.laws import examples

PIECES = [
    "behavior", "param", "map", "model", "simulation", "require", "require[", "terminate", "when", "after", "do",
    "for", "until", "take", "wait", "abort", "try", "interrupt", "if", "elif", "else", "while", "new", "Car",
    "with", "at", "in", "on", "offset", "by", "along", "ahead", "behind", "of", "left", "following", "facing",
    "toward", "away", "from", "to", "before", "after", "distance", "minimum", "relative", "heading", "can", "see",
    "intersects", "deg", "lambda", "not", "is", "and", "or", "as", "True", "None", "true", "class", "import",
    "monitor", "record", "always", "eventually", "next", "implies", "scenario", "setup", "compose", "precondition",
    "invariant", "choose", "shuffle", "mutate", "override", "signals", "initial", "final", "steps",
    "seconds", "m", "km/h", "m/s^2", "min", "kmh", "x", "y", "f", "5",
    "3.5", "1e5", "1e999", '"s"', "'", '"', '"""', "(", ")", "[", "]", "{", "}", ",", ":", ";", ".", "=", "==",
    "+=", "<", "+", "-", "*", "**", "/", "//", "%", "@", "!", "&&", "#", "\\", "\n", "\n", "\n    ", "\n        ",
    "\n\t", "\r\n", "\f", "\0", "\ufeff", "°", "é", "😀", "\u202e", "\x1b[31m",
]  # fmt: skip

quickly = settings(examples(150), suppress_health_check=list(HealthCheck))  # pyright: ignore[reportArgumentType]


def complaint(read: Callable[[], object]) -> CompileError | None:
    """What is said against it; any other exception is a bug."""
    try:
        read()
    except CompileError as error:
        return error
    return None


def survives(read: Callable[[], object]) -> None:
    """Read, and draw what was found."""
    if (error := complaint(read)) is None:
        return
    assert error.diagnostics
    for diagnostic in error.diagnostics:
        span = diagnostic.label.span
        assert 0 <= span.start <= span.end <= len(error.source.text)
        assert diagnostic.message
    assert "\x1b" not in render_text(error.source, error.diagnostics, width=60)
    as_json(error.source, error.diagnostics)


@quickly
@given(st.lists(st.sampled_from(PIECES), max_size=30))
def test_soup_of_tokens(pieces: list[str]) -> None:
    """Words of the language in any order."""
    survives(lambda: parse(Source("soup", " ".join(pieces))))


@quickly
@given(st.lists(st.sampled_from(PIECES), max_size=30))
def test_soup_without_spaces(pieces: list[str]) -> None:
    """The same, glued together."""
    survives(lambda: parse(Source("soup", "".join(pieces))))


@quickly
@given(st.binary(max_size=80))
def test_random_bytes(content: bytes) -> None:
    """Bytes that need be no text."""
    survives(lambda: parse(decode("bytes", content)))


LARGE = {
    "parentheses": "x = " + "(" * 10_000 + "1",
    "mixed brackets": "([{" * 5_000,
    "closing brackets": ")" * 10_000,
    "calls": "x = " + "f(" * 10_000,
    "minus signs": "x = " + "-" * 10_000 + "1",
    "nots": "x = " + "not " * 10_000 + "y",
    "attributes": "x = a" + ".b" * 10_000,
    "sum": "x = 1" + " + 1" * 10_000,
    "conditionals": "x = " + "1 if a else " * 5_000 + "1",
    "lambdas": "x = " + "lambda: " * 5_000 + "1",
    "powers": "x = 2" + " ** 2" * 5_000,
    "blocks": "".join(" " * n + "if x:\n" for n in range(1_000)),
    "elifs": "if x:\n    pass\n" + "elif x:\n    pass\n" * 1_000,
    "commas and comments": "x = [1,\n" + ", # # # # # # # # # # # # # # # # # # # #\n" * 200,
    "quotes": "'\"" * 10_000,
    "backslashes": "\\" * 10_000,
    "one long line": "x = [" + "1, " * 20_000 + "1]",
    "one long name": "x" * 200_000,
    "one long number": "x = " + "1" * 100_000,
    "one long comment": "x = 1 #" + " #" * 100_000,
    "spaces": "x" + " " * 200_000 + "= 1",
    "blank lines": "\n" * 200_000 + "x = (",
    "errors": "x = $\n" * 20_000,
    "nested errors": "behavior B():\n" + "    x = = 3\n" * 5_000,
    "unclosed triple": '"""' + '"" ' * 50_000,
    "unclosed per line": "f(\nrequire x\n" * 3_000,
}


@pytest.mark.parametrize("name", LARGE)
def test_large_input_is_answered_soon(name: str) -> None:
    """Length and depth cost time in proportion, and never the stack."""
    started = time.process_time()
    survives(lambda: parse(Source(name, LARGE[name])))
    assert time.process_time() - started < 5.0

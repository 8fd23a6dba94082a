"""The catalogue of codes: each means one thing and has a page, whose examples the compiler itself judges."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from cortex_dsl.api.codes import Entry, entries, find, near
from cortex_dsl.diagnostics import CompileError, Severity
from cortex_dsl.syntax.reading import decode
from tests.cortex_dsl.once import judged, judging_once

HERE = Path(__file__).parents[1]
ALL = entries()
PAGES = [entry for entry in ALL if entry.page is not None]
COMPILED = [entry for entry in PAGES if entry.page and not entry.page.shown]
READ = [entry for entry in PAGES if entry.page and "is read" in entry.page.shown and entry.page.wrong]
ADVISED = {entry.code for entry in COMPILED if entry.page and entry.page.options[0]}
"""Codes about the command line."""


@pytest.fixture(autouse=True)
def _once() -> Iterator[None]:
    with judging_once():
        yield


def by_code(entry: Entry) -> str:
    return entry.code


def said(text: str, option: str) -> dict[str, Severity]:
    return {diagnostic.code: diagnostic.severity for diagnostic in judged("example.scn", text, option)[1]}


def test_codes_are_unique() -> None:
    """A code means one thing."""
    codes = [entry.code for entry in ALL]
    assert len(codes) == len(set(codes))


@pytest.mark.parametrize("entry", ALL, ids=by_code)
def test_every_code_has_a_page(entry: Entry) -> None:
    """A title, a reason, and an example with its cure, or when it is said instead."""
    assert entry.page is not None, f"{entry.code} has no page"
    assert entry.page.title
    assert entry.page.title[0] in "`=" or entry.page.title[0].islower() or entry.page.title.startswith("UTF")
    assert entry.page.why.endswith(".")
    assert entry.page.shown or (entry.page.wrong and entry.page.right)


@pytest.mark.parametrize("entry", COMPILED, ids=by_code)
def test_the_wrong_example_raises_its_code(entry: Entry) -> None:
    """With the severity that the catalogue says."""
    assert entry.page
    assert said(entry.page.wrong, entry.page.options[0]).get(entry.code) is entry.severity


@pytest.mark.parametrize("entry", COMPILED, ids=by_code)
def test_the_right_example_compiles_without_its_code(entry: Entry) -> None:
    """The cure is one: nothing else is wrong with it, except that syntax examples need not be whole scenarios."""
    assert entry.page
    codes = said(entry.page.right, entry.page.options[1])
    assert entry.code not in codes
    wrong = [code for code, severity in codes.items() if severity is Severity.ERROR]
    if entry.code.startswith("SCN1"):
        wrong = [code for code in wrong if code.startswith("SCN1")]
    assert not wrong


@pytest.mark.parametrize("entry", READ, ids=by_code)
def test_what_is_said_while_a_file_is_read(entry: Entry) -> None:
    """The bytes of the wrong example are refused with the code, those of the right one are read."""
    assert entry.page
    with pytest.raises(CompileError) as refused:
        decode("example.scn", entry.page.wrong.encode("latin-1"))
    assert [diagnostic.code for diagnostic in refused.value.diagnostics] == [entry.code]
    decode("example.scn", entry.page.right.encode("latin-1"))


def test_every_code_has_a_transcript() -> None:
    """What each code looks like stands in a golden file; those about options and bytes have tests of their own."""
    texts = "".join(path.read_text(encoding="utf-8") for path in HERE.glob("*/golden/**/*.txt"))
    shown = {entry.code for entry in PAGES if entry.page and entry.page.shown}
    assert {entry.code for entry in ALL if f"[{entry.code}]" not in texts} <= shown | ADVISED


@pytest.mark.parametrize("text", ["SCN203", "scn203", "203", " Scn203 "])
def test_a_code_is_found_as_people_write_it(text: str) -> None:
    """In small letters and without its letters."""
    entry = find(text)
    assert entry is not None
    assert entry.code == "SCN203"


def test_near_codes() -> None:
    """A number that is no code is answered with the next ones, a word with a title like it."""
    assert find("SCN299") is None
    assert near("SCN299")[0].code == "SCN301"
    assert [entry.code for entry in near("unknown atribute")] == ["SCN203"]
    assert near("?") == []

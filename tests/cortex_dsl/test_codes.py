"""Codes of diagnostics: each means one thing and has a folder, whose examples the compiler itself judges.

`UPDATE_GOLDEN=1 pytest tests/cortex_dsl/test_codes.py` writes `said.txt`, to be read before it is kept.
"""

from pathlib import Path

import pytest

import cortex_dsl.codes
from cortex_dsl.codes import Entry, entries, find, judged, near
from cortex_dsl.diagnostics import CompileError, Diagnostic, Severity
from cortex_dsl.report.findings.snippet import render_text
from cortex_dsl.source import Source
from cortex_dsl.syntax.errors import CODES, MAX_ERRORS, TOO_MANY, Code
from cortex_dsl.syntax.reading import decode
from tests.golden import matches

HOME = Path(cortex_dsl.codes.__file__).parent
FILES = {"page.md", "wrong.scn", "right.scn", "said.txt"}
ALL = entries()
WITH_EXAMPLE = [entry for entry in ALL if entry.page.wrong]
COMPILED = [entry for entry in WITH_EXAMPLE if entry.page.shown in ("", "while the file is read")]
"""Codes that the compilation of `wrong.scn` raises; tests/cortex_dsl/cli/test_explain.py runs all other examples."""


def by_code(entry: Entry) -> str:
    return entry.code


def compiled(entry: Entry, file: str, option: str) -> tuple[Source, tuple[Diagnostic, ...]]:
    """Return what the compiler says about the bytes of an example, and the source that it refers to."""
    try:
        text = decode(file, (HOME / entry.code / file).read_bytes()).text
    except CompileError as error:
        return error.source, error.diagnostics
    return judged(file, text, option)


def test_codes_are_unique() -> None:
    """A code means one thing."""
    codes = [entry.code for entry in ALL]
    assert len(codes) == len(set(codes))


def test_every_code_has_a_folder_and_every_folder_a_code() -> None:
    """A row without a folder has no page, and a folder without a row is never shown."""
    folders = {path.name for path in HOME.iterdir() if path.is_dir() and path.name != "__pycache__"}
    assert folders == {entry.code for entry in ALL}


@pytest.mark.parametrize("entry", ALL, ids=by_code)
def test_every_code_has_a_page(entry: Entry) -> None:
    """A title, a reason, and an example with its cure and its output, or the occasion of the message instead."""
    assert entry.page.title
    assert entry.page.title[0] in "`=" or entry.page.title[0].islower() or entry.page.title.startswith("UTF")
    assert entry.page.why.endswith(".")
    assert entry.page.shown or (entry.page.wrong and entry.page.right)
    held = {path.name for path in (HOME / entry.code).iterdir()}
    assert held == (FILES if entry.page.wrong else {"page.md"})


@pytest.mark.parametrize("entry", COMPILED, ids=by_code)
def test_the_wrong_example_raises_its_code(entry: Entry) -> None:
    """Its output is the one beside it; it has the code with the severity of its row, and no error of another code."""
    source, diagnostics = compiled(entry, "wrong.scn", entry.page.options[0])
    matches(render_text(source, diagnostics), HOME / entry.code / "said.txt")
    assert {d.severity for d in diagnostics if d.code == entry.code} == {entry.severity}
    others = [d.code for d in diagnostics if d.severity is Severity.ERROR and d.code != entry.code]
    assert len(others) == (MAX_ERRORS if entry.code == TOO_MANY.code else 0)


@pytest.mark.parametrize("entry", COMPILED, ids=by_code)
def test_the_right_example_compiles_without_its_code(entry: Entry) -> None:
    """The cure is one: nothing else is wrong with it, except that syntax examples need not be whole scenarios."""
    _, diagnostics = compiled(entry, "right.scn", entry.page.options[1])
    assert entry.code not in [d.code for d in diagnostics]
    wrong = [d.code for d in diagnostics if d.severity is Severity.ERROR]
    if entry.code.startswith("SCN1"):
        wrong = [code for code in wrong if code.startswith("SCN1")]
    assert not wrong


@pytest.mark.parametrize("code", [code for code in CODES if code.reason], ids=lambda code: code.code)
def test_the_reason_of_a_syntax_error_is_the_text_of_its_page(code: Code) -> None:
    """A message gives the same reason as the page."""
    found = find(code.code)
    assert found is not None
    assert found.page.why == code.reason


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

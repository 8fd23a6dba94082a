"""Golden programs: `golden/good` must compile in silence, `golden/bad` must be answered exactly as written beside it.

The first program of each code is in its folder in `cortex_dsl/codes` (tests/cortex_dsl/test_codes.py); here are more.

A new case is two files: `SCN999_name.scn` and `SCN999_name.txt` (write the latter with UPDATE_GOLDEN=1, and
read it before you keep it).
"""

from pathlib import Path

import pytest

from cortex_dsl.diagnostics import CompileError, Severity
from cortex_dsl.report.findings.snippet import render_text
from cortex_dsl.semantics.elaboration import elaborate
from cortex_dsl.semantics.errors import declared
from cortex_dsl.semantics.model import state
from cortex_dsl.source import Source
from cortex_dsl.syntax import parse
from tests.golden import matches

GOLDEN = Path(__file__).parent / "golden"
BAD = sorted((GOLDEN / "bad").glob("*.scn"))
GOOD = sorted((GOLDEN / "good").glob("*.scn"))
PROBLEMS = list(declared().values())


@pytest.fixture(autouse=True)
def _little_patience(monkeypatch: pytest.MonkeyPatch) -> None:
    """Files that would take too long are refused sooner here."""
    monkeypatch.setattr(state, "EVALUATION_LIMIT", 20_000)
    monkeypatch.setattr(state, "BODY_LIMIT", 200)


def transcript(path: Path) -> tuple[str, set[str], bool]:
    """What is said about a file, with which codes, and whether it compiles."""
    source = Source(path.name, path.read_text())
    try:
        _, diagnostics = elaborate(parse(source), source)
        compiled = True
    except CompileError as error:
        diagnostics, compiled = error.diagnostics, False
    return render_text(source, diagnostics), {d.code for d in diagnostics}, compiled


@pytest.mark.parametrize("path", BAD, ids=lambda path: path.stem)
def test_bad_program_is_answered(path: Path) -> None:
    """The transcript is the one beside the program, and holds the code that names the file."""
    text, codes, compiled = transcript(path)
    matches(text, path.with_suffix(".txt"))
    code = path.stem.split("_")[0]
    assert code in codes
    declared = next(problem for problem in PROBLEMS if problem.code == code)
    assert compiled == (declared.severity is not Severity.ERROR)


@pytest.mark.parametrize("path", GOOD, ids=lambda path: path.stem)
def test_good_program_compiles_in_silence(path: Path) -> None:
    """Nothing is said about a good program."""
    text, _, compiled = transcript(path)
    assert compiled, text
    assert text.strip() == ""

"""One space of offsets over all files; the main file is where it always was."""

from hypothesis import given
from hypothesis import strategies as st

from cortex_dsl.diagnostics import Diagnostic, Label
from cortex_dsl.report.findings.snippet import as_json, render_text
from cortex_dsl.source import Source, Span

TEXTS = st.text(alphabet="ab \n", max_size=12)


@given(TEXTS, st.lists(TEXTS, max_size=3))
def test_every_offset_belongs_to_one_file(main: str, others: list[str]) -> None:
    """A place in an imported file has the line and column that it has in that file alone."""
    source = Source("main", main)
    for number, text in enumerate(others):
        source = source.with_import(f"file{number}", text)
    for file, text in zip(source.files, [main, *others], strict=True):
        alone = Source(file.name, text)
        for offset in range(len(text) + 1):
            assert source.file(file.start + offset) == file
            assert source.position(file.start + offset) == alone.position(offset)
            row = source.row(file.start + offset)
            assert source.line(row) == alone.line(row - file.first_line + 1)
        assert source.slice(Span(file.start, file.end)) == text


def test_a_diagnostic_shows_every_file_it_points_into() -> None:
    """The file of the first label leads; the other is named above its lines."""
    source = Source("main.scn", "import cars\nx = y\n").with_import("cars.scn", "# first\ny = 3\n")
    start = source.imported[0].start + 8
    diagnostic = Diagnostic("SCN999", "wrong", Label(Span(start, start + 1), "here"), secondary=(Label(Span(12, 13)),))
    lines = render_text(source, [diagnostic], 60).splitlines()
    assert lines == [
        "cars.scn:2:1: error[SCN999]: wrong",
        "  |",
        "2 | y = 3",
        "  | ^ here",
        "  : main.scn",
        "2 | x = y",
        "  | -",
    ]
    (document,) = as_json(source, [diagnostic])
    assert (document["file"], document["start"]) == ("cars.scn", {"line": 2, "column": 1, "offset": 8})
    assert document["secondary"][0]["file"] == "main.scn"

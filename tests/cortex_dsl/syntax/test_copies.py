"""`format_copy` gives what `format_source` gives, and parses only the first of texts of one shape."""

from pathlib import Path

import pytest

from cortex_dsl.diagnostics import CompileError
from cortex_dsl.source import Source
from cortex_dsl.syntax import formatting
from cortex_dsl.syntax.formatting import format_copy, format_source

EXAMPLES = sorted((Path(__file__).parents[3] / "examples").glob("*.scn"))
LONG = "1.2345678901234567e-05"
WRAPPED = """
# case {n}
map intersection()   # with  "quotes {n}
param  A = Range(0, {x}) m
param LONGER=   {x}  # {n}
lane = Uniform(network.lanes[{n}],
    network.lanes[1])
ego = new Car at ({x} m, {x} m), facing {x} rad, with mass {x} t, with speed {x} m/s
simulation(time_step=0.05 s, stream="{n}.ga.{n}")
x1 = f"{{A}} {n}"
"""


@pytest.fixture(autouse=True)
def _nothing_known() -> None:
    formatting._places.cache_clear()


def numbered(number: str, n: int = 1) -> Source:
    return Source("copy.scn", WRAPPED.format(x=number, n=n))


def test_lines_of_a_copy_end_where_they_should() -> None:
    """Numbers decide how wide a line is, and so where it ends; what was read before them does not."""
    texts = [numbered(number) for number in ("1.0", LONG, "250", LONG, "1e9", "3")]
    formatted = [format_copy(text) for text in texts]
    assert formatted == [format_source(text) for text in texts]
    assert len(formatted[0].splitlines()) < len(formatted[1].splitlines())


def test_only_the_first_of_a_shape_is_parsed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Texts that differ in numbers, comments and short texts have one shape; a word or a line makes another."""
    parsed: list[Source] = []
    parse = formatting.parse

    def counted(source: Source) -> object:
        parsed.append(source)
        return parse(source)

    monkeypatch.setattr(formatting, "parse", counted)
    first = numbered("1.0")
    for number in ("1.0", "2.5", "77", LONG):
        source = numbered(number)
        assert format_copy(source) == format_source(source)
    for number in ("-1.0", "-.5", "-3e5"):
        place = f"({number} m, {number} m), facing {number} rad"
        source = Source("copy.scn", first.text.replace("(1.0 m, 1.0 m), facing 1.0 rad", place))
        assert "-" in source.text
        assert format_copy(source) == format_source(source)
    assert len(parsed) == 1
    renamed = first.text.replace("# case 1", "# case 12 of another search").replace("1.ga.1", "12.random.0")
    others = [
        first.text.replace("case 1\n", "case 1\n# two\n"),
        first.text.replace("A", "B"),
        first.text.replace("1.0 t", "x - 1.0 t"),
    ]
    others.append(numbered("1.0", 2).text)  # the text with values is another: its layout is read with it
    for text, count in ((renamed, 1), *((text, number + 2) for number, text in enumerate(others))):
        source = Source("other.scn", text)
        assert format_copy(source) == format_source(source)
        assert len(parsed) == count


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_every_example_with_other_numbers_and_line_breaks(path: Path) -> None:
    """As it is, with numbers that are longer, and then with the line breaks of another system."""
    text = path.read_text(encoding="utf-8")
    longer = text.replace("0 ", "000000000 ")
    for each in (text, longer, longer.replace("\n", "\r\n")):
        source = Source("a.scn", each)
        assert format_copy(source) == format_source(source)


def test_what_does_not_parse_is_refused() -> None:
    """A number that is too large is no number of the same shape, and a broken text has no layout."""
    assert format_copy(Source("a.scn", "x = 1e9\n")) == "x = 1e9\n"
    for text in ("x = 1e999\n", "x = (1e9\n"):
        with pytest.raises(CompileError):
            format_copy(Source("a.scn", text))

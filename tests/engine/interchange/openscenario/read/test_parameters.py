"""`$name` and `${arithmetic}` are put in as the standard says."""

import math
from pathlib import Path

import pytest

from engine.interchange import InterchangeError
from engine.interchange.openscenario.read.parameters import resolved
from engine.xml import Node
from tests.engine.interchange.openscenario.read.files import follow, polyline, read, refused, scenario, vehicle

NODE = Node("Vertex", {}, "case.xosc", 7)
SCOPE = {"a": "2", "b": "-3.5", "word": "Ego"}


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("${1 + 2 * 3}", 7.0),
        ("${$a * $b}", -7.0),
        ("${-($a - $b) / 2}", -2.75),
        ("${pow($a, 3) + sqrt(16)}", 12.0),
        ("${round(2.6) + floor(2.6) + ceil(2.4)}", 8.0),
        ("${7 % 4}", 3.0),
        ("${pi}", math.pi),
        ("${max($a, 3) - min(1, $b) + abs($b) + sign($b)}", 9.0),
        ("${ 1.5e1 }", 15.0),
    ],
)
def test_expressions_are_arithmetic(text: str, value: float) -> None:
    """Numbers, parameters, operators and a few functions."""
    assert float(resolved(text, SCOPE, NODE)) == pytest.approx(value)


def test_a_parameter_stands_for_its_text() -> None:
    """Also where that is a name; what only looks like one stays."""
    assert resolved("$word", SCOPE, NODE) == "Ego"
    assert resolved("5 $", SCOPE, NODE) == "5 $"
    assert resolved("$", SCOPE, NODE) == "$"


@pytest.mark.parametrize(
    "text",
    [
        "${__import__('os')}",
        "${().__class__}",
        "${9 ** 9 ** 9}",
        "${1 / 0}",
        "${pow(10, 400)}",
        "${" + "(" * 300 + ")" * 300 + "}",
        "${" + "1+" * 6000 + "1}",
        "${[1] * 9}",
        "${'a'}",
        "${True}",
        "${1e999}",
        "${sqrt(-1)}",
        "${unknown}",
        "${pow(1)}",
        "${}",
        "${\x00}",
        "${1;2}",
    ],
)
def test_other_expressions_are_refused(text: str) -> None:
    """Code, endless powers, and what has no finite value: always with the place."""
    with pytest.raises(InterchangeError, match="cannot be evaluated") as caught:
        resolved(text, SCOPE, NODE)
    assert caught.value.place == "case.xosc, line 7"


def test_unknown_parameters_are_named() -> None:
    """With the one that was meant; and a word is no number."""
    with pytest.raises(InterchangeError, match=r"`\$wrod`.*did you mean `word`"):
        resolved("$wrod", SCOPE, NODE)
    with pytest.raises(InterchangeError, match="no number"):
        resolved("${$word + 1}", SCOPE, NODE)


def test_scopes_nest_and_declarations_build_on_those_before(tmp_path: Path) -> None:
    """A file's parameters hold everywhere, those of an element within it."""
    declared = "".join(
        f'<ParameterDeclaration name="{name}" parameterType="double" value="{value}"/>'
        for name, value in (("x0", "4"), ("x1", "${$x0 * 2}"), ("who", "Ego"))
    )
    place = '<Position><WorldPosition x="${$x1 + 1}" y="$y" h="0"/></Position>'
    inner = '<ParameterDeclarations><ParameterDeclaration name="y" parameterType="double" value="3"/>'
    action = follow(polyline((0.0, place), (0.1, place.replace("$x1", "$x0"))))
    action = action.replace("<Shape>", inner + "</ParameterDeclarations><Shape>")
    text = scenario([vehicle("Ego", center=0.0)], [("$who", action)], parameters=declared)
    assert read(tmp_path, text).recording.states[:, 0, :2].tolist() == [[9.0, 3.0], [5.0, 3.0]]
    outside = text.replace("<StopTrigger></StopTrigger>", '<StopTrigger name="$y"></StopTrigger>')
    assert "no parameter `$y`" in refused(tmp_path, outside).message


def test_what_other_writers_do_is_understood(tmp_path: Path) -> None:
    """A parameter that is declared with its dollar; a controller, which nobody reads, with one that is not declared."""
    declared = '<ParameterDeclaration name="$x" parameterType="double" value="4"/>'
    action = follow(polyline((0.0, '<Position><WorldPosition x="$x" y="1" h="0"/></Position>')))
    controller = '<ObjectController><CatalogReference catalogName="c" entryName="$Unknown"/></ObjectController>'
    driven = vehicle("Ego", center=0.0).replace("</ScenarioObject>", controller + "</ScenarioObject>")
    text = scenario([driven], [("Ego", action)], parameters=declared)
    assert read(tmp_path, text).recording.states[:, 0, :2].tolist() == [[4.0, 1.0]]


def test_two_catalogs_of_one_name_are_one(tmp_path: Path) -> None:
    """In two folders, each with entries of its own; of one that both have, the former's counts."""
    body = vehicle("x").split(">", 1)[1].removesuffix("</ScenarioObject>")
    for folder, cars in (("one", {"sedan": "4.5"}), ("two", {"sedan": "9", "van": "6"})):
        (tmp_path / folder).mkdir()
        entries = "".join(
            body.replace('name="x"', f'name="{name}"').replace('length="4.5"', f'length="{size}"')
            for name, size in cars.items()
        )
        head = '<FileHeader revMajor="1" revMinor="2"/>'
        catalog = f'<OpenSCENARIO>{head}<Catalog name="Cars">{entries}</Catalog></OpenSCENARIO>'
        (tmp_path / folder / "cars.xosc").write_text(catalog)
    refer = '<ScenarioObject name="{0}"><CatalogReference catalogName="Cars" entryName="{1}"/></ScenarioObject>'
    action = follow(polyline((0.0, '<Position><WorldPosition x="1" y="1" h="0"/></Position>')))
    text = scenario(
        [refer.format("Ego", "sedan"), refer.format("Other", "van")],
        [("Ego", action), ("Other", action.replace('x="1"', 'x="40"'))],
        catalogs='<VehicleCatalog><Directory path="one"/></VehicleCatalog><Extra><Directory path="two"/></Extra>',
    )
    assert [actor.length for actor in read(tmp_path, text).recording.actors] == [4.5, 6.0]

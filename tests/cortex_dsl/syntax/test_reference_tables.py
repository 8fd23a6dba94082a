"""The tables of the reference are made from those of the program: `UPDATE_GOLDEN=1 pytest` on this file writes them.

Where the program has no sentence about a thing, the last cell is the author's, and is kept; an empty one is an error.
"""

import math
import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path

import pytest

from cortex_dsl.semantics.acting.statements import SETTINGS
from cortex_dsl.semantics.evaluation import alignments, attributes, lanes, regions, relations, signals, streets
from cortex_dsl.semantics.evaluation.driving import OF_OBJECTS
from cortex_dsl.semantics.evaluation.maps import MAP_ARGUMENTS
from cortex_dsl.semantics.model.state import DEFAULT_ALL_RED, DEFAULT_GREEN, DEFAULT_YELLOW
from cortex_dsl.semantics.names.attribute_docs import ATTRIBUTE_DOCS
from cortex_dsl.semantics.names.builtins import BUILTINS, Builtin, Kind, Parameter
from cortex_dsl.semantics.names.properties import ENVIRONMENT, FLAGS, IGNORED, PROPERTIES, Domain, Property
from cortex_dsl.semantics.quantities.units import ANGLE, dimension_name, si_word
from cortex_dsl.syntax import words
from docs.builder.site import LANGUAGE
from engine.config import SimulationConfig
from engine.judged import NAMED_RESULTS
from engine.maps import LoneRoad, RoadSpec, Roundabout, Street
from engine.road.lone_road import FLATTEST, LONGEST, MOST_BENT, SHORTEST
from engine.road.network import SurfaceKind
from engine.road.roundabout import ARMS, CORNERS, RADII
from engine.road.specification import LENGTHS, MAX_INTERSECTIONS, MAX_LANES, SPEED_LIMITS, STREET_LENGTHS

PAGES = [Path(__file__).parents[3] / "docs" / name for name in LANGUAGE]
TABLE = re.compile(r"<!-- table: (?P<name>\w+) -->\n(?P<rows>.*?)<!-- end -->", re.DOTALL)
INFINITY = float("inf")
Rows = Iterable[tuple[str, ...]]

# -- cells ------------------------------------------------------------------------------------------------------------


def plain(doc: str) -> str:
    """A docstring of one sentence in a cell."""
    return doc.removesuffix(".")


def limits(low: float, high: float, unit: str = "", *, above: bool = False) -> str:
    """What a number may be."""
    if low == -INFINITY and high == INFINITY:
        return "any"
    first = f"{low:,.7g}" + (f" {unit}" if unit and high == INFINITY else "")
    if high == INFINITY:
        return f"above {first}" if above else f"from {first}"
    return f"{'above ' if above else ''}{first} to {high:,.7g} {unit}".rstrip()


def holding(name: str) -> Path:
    """Return the page with the table of that name."""
    (page,) = (page for page in PAGES if f"<!-- table: {name} -->" in page.read_text(encoding="utf-8"))
    return page


def kept(name: str) -> dict[str, str]:
    """The last cells of a table on the page, by the first."""
    text = holding(name).read_text(encoding="utf-8")
    match = next(match for match in TABLE.finditer(text) if match["name"] == name)
    rows = [[cell.strip() for cell in re.split(r"(?<!\\)\|", row)[1:-1]] for row in match["rows"].splitlines()]
    return {row[0]: row[-1] for row in rows}


# -- what is built in -------------------------------------------------------------------------------------------------


def of_kind(kind: Kind, holds: Callable[[Builtin], bool] = lambda _: True) -> Rows:
    return [(f"`{row.signature}`", plain(row.doc)) for row in BUILTINS.values() if row.kind is kind and holds(row)]


def of_lights(row: Builtin) -> bool:
    return "TrafficLight" in row.name


def of_run(row: Builtin) -> bool:
    return not of_lights(row) and row.name.startswith(("withinDistance", "timeTo"))


def arguments() -> Rows:
    """Of library behaviours: what each may be; a name means the same in all."""
    found: dict[str, list[Parameter]] = {}
    for row in BUILTINS.values():
        if row.kind is Kind.BEHAVIOUR:
            for parameter in row.parameters:
                found.setdefault(parameter.name, []).append(parameter)
    words, rows = kept("arguments"), dict[str, str]()
    for name, parameters in found.items():
        cell = ", ".join(f"`{each}`" for each in sorted({name, *(a for p in parameters for a in p.aliases)}))
        rows[cell] = " or ".join(dict.fromkeys(map(allowed, parameters)))
    return [(cell, ranges, words.get(cell, "")) for cell, ranges in sorted(rows.items())]


def allowed(parameter: Parameter) -> str:
    return "" if parameter.dimension is None else limits(parameter.low, parameter.high, si_word(parameter.dimension))


# -- the road, the lights, the run ------------------------------------------------------------------------------------


LIMIT = {"speed_limit": limits(*SPEED_LIMITS, "m/s")}


STREET = {each.name: each.default for each in fields(Street)}


def own_arguments(kind: str) -> Sequence[str]:
    """Return the arguments of a kind of map that only some kinds have."""
    return [name for name in MAP_ARGUMENTS[kind] if name not in STREET]


def street_arguments() -> Rows:
    words = kept("map_street")
    ranges = {
        "parked": "0 to 1",
        "crossings": "`True` or `False`; on a road, a list of places",
        "bike_lane_behind_parking": "`True` or `False`",
    }
    for name, value in STREET.items():
        unit = " m" if name in STREET_LENGTHS else ""
        default = "none" if value is None else f"{value:g}{unit}" if isinstance(value, float) else f"{value}"
        may_be = limits(*STREET_LENGTHS[name], "m") if name in STREET_LENGTHS else ranges[name]
        yield f"`{name}`", default, may_be, words.get(f"`{name}`", "")


def map_arguments() -> Rows:
    words, spec = kept("map"), RoadSpec()
    whole = {"ways": "3 or 4", "lanes": f"1 to {MAX_LANES}", "left_hand": "`True` or `False`", **LIMIT}
    for name in own_arguments("intersection"):
        value = getattr(spec, name)
        default = "none" if value is None else f"{value:g} m" if name in LENGTHS else f"{value}"
        grid = f"1 to {MAX_INTERSECTIONS}, in all"
        yield f"`{name}`", default, range_of(name) or whole.get(name, grid), words.get(f"`{name}`", "")


def road_arguments() -> Rows:
    words, spec = kept("map_road"), LoneRoad()
    ranges = {
        "lanes": f"1 to {MAX_LANES}",
        "length": limits(SHORTEST, LONGEST, "m"),
        "curve": f"length, up to {FLATTEST:,.0f} m",
        "bend": f"angle, up to {math.degrees(MOST_BENT):g} deg",
        **LIMIT,
    }
    for name in own_arguments("road"):
        value = getattr(spec, name)
        default = "none" if value is None else f"{value:g} m" if name in ("length", "lane_width") else f"{value}"
        words_for = words.get(f"`{name}`", "")
        yield f"`{name}`", default, ranges.get(name) or range_of(name) or "`True` or `False`", words_for


def roundabout_arguments() -> Rows:
    words, spec = kept("map_roundabout"), Roundabout()
    ranges = {
        "arms": f"{ARMS[0]} to {ARMS[-1]}",
        "lanes": f"1 to {MAX_LANES}",
        "radius": limits(*RADII, "m"),
        "corner_radius": limits(*CORNERS, "m"),
        "left_hand": "`True` or `False`",
        **LIMIT,
    }
    for name in own_arguments("roundabout"):
        value = getattr(spec, name)
        default = "none" if value is None else f"{value:g} m" if isinstance(value, float) else f"{value}"
        yield f"`{name}`", default, ranges.get(name) or range_of(name), words.get(f"`{name}`", "")


def range_of(name: str) -> str:
    return limits(*LENGTHS[name], "m") if name in LENGTHS else ""


def signal_arguments() -> Rows:
    words = kept("signals")
    defaults = {"green": DEFAULT_GREEN, "yellow": DEFAULT_YELLOW, "all_red": DEFAULT_ALL_RED, "offset": 0.0}
    assert tuple(defaults) == signals.ARGUMENTS
    return [(f"`{name}`", f"{value:g} s", words.get(f"`{name}`", "")) for name, value in defaults.items()]


def settings() -> Rows:
    words, config = kept("simulation"), SimulationConfig()
    for name in SETTINGS:
        value = getattr(config, name, None)
        unit = "" if name == "max_attempts" else " s"
        yield f"`{name}`", "" if value is None else f"{value:g}{unit}", words.get(f"`{name}`", "")


# -- attributes and properties ----------------------------------------------------------------------------------------


def attribute_rows(kinds: Mapping[str, Iterable[str]]) -> Rows:
    """Each attribute once, with everything that has it."""
    having: dict[str, list[str]] = {}
    for kind, names in kinds.items():
        for name in names:
            if not name.startswith("_"):
                having.setdefault(name, []).append(kind)
    return [(f"`{name}`", ", ".join(kinds), plain(ATTRIBUTE_DOCS[name])) for name, kinds in having.items()]


def road_attributes() -> Rows:
    return attribute_rows(
        {
            "network": attributes._NETWORK,
            "intersection": attributes._INTERSECTION,
            "maneuver": attributes._MANEUVER,
            "lane": attributes._LANE,
            "lane section": (*lanes.OF_SECTION, *lanes.OF_SECTION_BESIDE),
            "lane group": (*lanes.OF_GROUP, *streets.OF_GROUP),
            "road": (*lanes.OF_ROAD, *streets.OF_ROAD, "crossingAt"),
            "sidewalk": streets.OF_SURFACE[SurfaceKind.SIDEWALK],
            "crossing": streets.OF_SURFACE[SurfaceKind.CROSSING],
            "kerb, shoulder, bicycle lane": streets.OF_SURFACE[SurfaceKind.CURB],
            "path": alignments.OF_PATH,
            "centre line": lanes.OF_CENTERLINE,
            "traffic light": attributes._SIGNAL,
            "sign": attributes._SIGN,
        }
    )


def object_attributes() -> Rows:
    every = (*attributes._STATES, *attributes._OF_PLACE, *attributes._OF_POINT, *OF_OBJECTS)
    objects = [name for name in every if name != "speed"]
    objects += [*relations.EDGES, *attributes._OF_ACTOR]
    regions_ = regions.attribute_names
    places = (*attributes._POSE, "z", "visibleRegion")
    return attribute_rows({"place": places, "object": (*attributes._POSE, *objects), "own region": regions_})


def properties() -> Rows:
    for prop in PROPERTIES.values():
        yield f"`{prop.name}`", property_range(prop), plain(prop.doc)
    for name, doc in FLAGS.items():
        yield f"`{name}`", "", plain(doc)
    for name, reason in IGNORED.items():
        yield f"`{name}`", "", f"Nothing: {reason}"


def environment() -> Rows:
    for each in ENVIRONMENT.values():
        yield f"`{each.name}`", domain_range(each), plain(each.doc)


def property_range(prop: Property) -> str:
    return "`True` or `False`" if prop.truth else domain_range(prop)


def domain_range(prop: Domain) -> str:
    angle = prop.dimension == ANGLE
    low, high = (math.degrees(end) if angle else end for end in (prop.low, prop.high))
    unit = "deg" if angle else si_word(prop.dimension)
    kind = dimension_name(prop.dimension).removeprefix("a pure ").removeprefix("an ").removeprefix("a ")
    return f"{kind}, {limits(low, high, unit, above=prop.above)}"


def results() -> Rows:
    for row in NAMED_RESULTS:
        yield f"`{row.name}`", row.unit, plain(row.sentence)


# -- what is not there ------------------------------------------------------------------------------------------------


def missing() -> Rows:
    tables = {
        "statement": words.LATER_STATEMENTS,
        "operator": words.LATER_OPERATORS,
        "specifier": words.LATER_SPECIFIERS,
    }
    for kind, later in tables.items():
        cured = {word: text for word, text in later.items() if word in words.INSTEAD}
        rest = [text for word, text in later.items() if word not in cured]
        yield from ((text, kind, plain(words.INSTEAD[word])) for word, text in cured.items())
        yield ", ".join(rest), kind, ""


TABLES: dict[str, tuple[tuple[str, ...], Callable[[], Rows]]] = {
    "functions": (
        ("function", "gives"),
        lambda: of_kind(Kind.FUNCTION, lambda row: not of_lights(row) and not of_run(row)),
    ),
    "constants": (("constant", "is"), lambda: of_kind(Kind.CONSTANT)),
    "distributions": (("distribution", "draws"), lambda: of_kind(Kind.DISTRIBUTION)),
    "map": (("argument", "default", "may be", "meaning"), map_arguments),
    "map_roundabout": (("argument", "default", "may be", "meaning"), roundabout_arguments),
    "map_road": (("argument", "default", "may be", "meaning"), road_arguments),
    "map_street": (("argument", "default", "may be", "makes"), street_arguments),
    "attributes": (("attribute", "of", "is"), road_attributes),
    "environment": (("argument", "may be", "meaning"), environment),
    "properties": (("property", "may be", "sets"), properties),
    "asking": (("attribute", "of", "is"), object_attributes),
    "actions": (("action", "does"), lambda: of_kind(Kind.ACTION)),
    "behaviours": (("behavior", "does"), lambda: of_kind(Kind.BEHAVIOUR)),
    "arguments": (("argument", "may be", "meaning"), arguments),
    "conditions": (("condition or measure", "gives"), lambda: of_kind(Kind.FUNCTION, of_run)),
    "signals": (("argument", "default", "meaning"), signal_arguments),
    "lights": (("function", "does"), lambda: of_kind(Kind.FUNCTION, of_lights)),
    "simulation": (("argument", "default", "meaning"), settings),
    "results": (("result", "unit", "is"), results),
    "later": (("construct", "a kind of", "instead"), missing),
}


def written(name: str) -> str:
    """A table in Markdown."""
    head, rows = TABLES[name]
    lines = [re.sub(r"\|  (?=\|)", "| ", f"| {' | '.join(cells)} |") for cells in (head, *rows())]
    lines.insert(1, "|---" * len(head) + "|")
    return "\n".join(lines) + "\n"


def anew(match: re.Match[str], name: str) -> str:
    rows = written(name) if match["name"] == name else match["rows"]
    return f"<!-- table: {match['name']} -->\n{rows}<!-- end -->"


@pytest.mark.parametrize("name", TABLES)
def test_table(name: str) -> None:
    """Nothing is missing, nothing is stale, and nothing is left unsaid."""
    page = holding(name)
    text = page.read_text(encoding="utf-8")
    if os.environ.get("UPDATE_GOLDEN"):
        page.write_text(TABLE.sub(lambda match: anew(match, name), text), encoding="utf-8")
        return
    (shown,) = [match["rows"] for match in TABLE.finditer(text) if match["name"] == name]
    assert shown == written(name)
    if name != "later":
        assert not re.search(r"\| \|$", shown, re.MULTILINE), "a meaning is missing"


def test_every_attribute_has_a_row() -> None:
    """The tables by kind are all the tables there are."""
    rows = {row[0].strip("`") for row in (*road_attributes(), *object_attributes())}
    assert rows == attributes.attribute_names() - {"speed"}

"""What a file becomes: genes, actors, requirements, rules, settings."""

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from cortex_dsl import ir
from cortex_dsl.semantics.printing import format_ir
from cortex_dsl.semantics.quantities.bounds import closed_value
from engine.maps import RoadSpec
from engine.opcodes import Op
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind, Column, Distribution, GeneKind

Compiled = Callable[..., ir.Scenario]
Said = Callable[..., list[str]]
EXAMPLES = Path(__file__).parents[3] / "examples"


def actor(scenario: ir.Scenario, name: str) -> ir.Actor:
    return next(a for a in scenario.variants[0].actors if a.name == name)


def column(scenario: ir.Scenario, name: str, which: Column) -> float:
    """A constant column of an actor, evaluated."""
    value = closed_value(actor(scenario, name).columns[which])
    assert value is not None
    return value


# -- the worked example -----------------------------------------------------------------------------------------------


def test_worked_example(alone: Compiled) -> None:
    """Four approaches, seven genes, two draws each, and the ends of a run in the order of the file."""
    scenario = alone((EXAMPLES / "left_turn.scn").read_text())
    assert [v.probability for v in scenario.variants] == [0.25] * 4
    assert [g.name for g in scenario.genes][:2] == ["EGO_INIT_DIST", "EGO_SPEED"]
    assert {v.draw_count for v in scenario.variants} == {2}
    assert [a.name for a in scenario.variants[0].actors] == ["ego", "adversary"]
    assert all(a.route >= 0 for v in scenario.variants for a in v.actors)
    assert [r.condition is None for r in scenario.variants[0].rules] == [False, True]
    assert scenario.settings.max_time == 20.0
    assert scenario.description.startswith("A: the ego")


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.scn")), ids=lambda path: path.stem)
def test_listing_shows_every_variant(path: Path, alone: Compiled) -> None:
    """The readable print of the IR holds all actors and requirements."""
    scenario = alone(path.read_text())
    text = format_ir(scenario)
    assert text.count("\nvariant ") == len(scenario.variants)
    assert all(repr(r.name) in text for r in scenario.variants[0].requirements)
    assert "interrupt when" in text


# -- genes ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "unit", "scale", "low", "high"),
    [
        ("Range(5, 80) km/h", "km/h", 1 / 3.6, 5.0, 80.0),
        ("Range(5 km/h, 80 km/h)", "km/h", 1 / 3.6, 5.0, 80.0),
        ("Range(5 m/s, 72 km/h)", "m/s", 1.0, 5.0, 20.0),
        ("Range(-5, 5) deg", "deg", math.pi / 180, -5.0, 5.0),
        ("Range(0, 1)", "", 1.0, 0.0, 1.0),
        ("VerifaiRange(7, 10)", "", 1.0, 7.0, 10.0),
        ("Range(0, 2 * 3) m", "m", 1.0, 0.0, 6.0),
    ],
)
def test_gene_keeps_the_unit_of_the_file(
    text: str, unit: str, scale: float, low: float, high: float, compiled: Compiled
) -> None:
    """Genomes are stored in the file's own unit and converted once."""
    gene = compiled(f"param P = {text}\nrequire P == P\n").genes[0]
    assert (gene.name, gene.unit, gene.scale, gene.low, gene.high) == ("P", unit, scale, low, high)
    assert (gene.kind, gene.distribution) == (GeneKind.CONTINUOUS, Distribution.UNIFORM)


def test_truncated_normal_gene(compiled: Compiled) -> None:
    """Its shape is in the file's unit too."""
    gene = compiled("param P = TruncatedNormal(50, 10, 30, 80) km/h\nrequire P > 1\n").genes[0]
    assert (gene.distribution, gene.mean, gene.deviation) == (Distribution.TRUNCATED_NORMAL, 50.0, 10.0)
    assert (gene.low, gene.high, gene.unit) == (30.0, 80.0, "km/h")


def test_params_by_both_names_are_one_gene(compiled: Compiled) -> None:
    """`NAME` and `globalParameters.NAME` are the same expression."""
    scenario = compiled("param P = Range(0, 1) m\nrequire P < globalParameters.P\n")
    condition = scenario.variants[0].requirements[0].condition
    assert isinstance(condition, ir.Apply)
    assert condition.arguments[0] is condition.arguments[1]


def test_unsearched_params_are_no_genes(compiled: Compiled) -> None:
    """Constants, text and expressions over distributions."""
    scenario = compiled("param A = 3 m, B = 'x', C = Range(0, 1) + 1\nrequire C < A\n")
    assert scenario.genes == ()


# -- places -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("specifier", "x", "y"),
    [
        ("ahead of base by 2 m", 10 + 2 + 4.508, 5),
        ("behind base by 2 m", 10 - 2 - 4.508, 5),
        ("left of base by 2 m", 10, 5 + 2 + 1.61),
        ("right of base by 2 m", 10, 5 - 2 - 1.61),
        ("ahead of base", 10 + 1e-4 + 4.508, 5),
        ("at base offset by (1, 3)", 13, 4),
        ("at base offset along 90 deg by (0, 3)", 10, 8),
        ("at (1, 2)", 1, 2),
        ("at 1 @ 2", 1, 2),
        ("at base", 10, 5),
    ],
)
def test_places(specifier: str, x: float, y: float, compiled: Compiled) -> None:
    """Beside an object means between the outlines; local offsets are (right, ahead)."""
    scenario = compiled(f"base = new Car at (10, 5), facing 0 deg\nother = new Car {specifier}\n")
    assert column(scenario, "other", Column.X) == pytest.approx(x)
    assert column(scenario, "other", Column.Y) == pytest.approx(y)


@pytest.mark.parametrize(
    ("specifier", "heading"),
    [
        ("at spot", 0.5),
        ("at spot, facing 90 deg", math.pi / 2),
        ("at (0, 0), facing toward (0, 5)", math.pi / 2),
        ("at (0, 0), facing away from (0, 5)", -math.pi / 2),
        ("ahead of spot by 3 m", 0.5),
        ("at (0, 0), facing spot", 0.5),
    ],
)
def test_headings(specifier: str, heading: float, compiled: Compiled) -> None:
    """An oriented place gives its heading, unless `facing` says otherwise."""
    scenario = compiled(f"spot = new OrientedPoint at (3, 4), facing 0.5 rad\nother = new Car {specifier}\n")
    assert column(scenario, "other", Column.HEADING) == pytest.approx(heading)


def test_vehicle_on_a_bare_point_follows_the_road(compiled: Compiled) -> None:
    """Its heading is the road's there; a pedestrian's is not."""
    scenario = compiled("a = new Car at (1, 2)\nb = new Pedestrian at (1, 2)\n")
    heading = actor(scenario, "a").columns[Column.HEADING]
    assert isinstance(heading, ir.Apply)
    assert heading.op == Op.ROAD_HEADING
    assert column(scenario, "b", Column.HEADING) == 0.0


def test_before_is_an_arc_length(compiled: Compiled) -> None:
    """`before intersection by d` lies d ahead of the stop line; a searched d that may be too long must fit."""
    fixed = compiled("other = new Car before intersection by 12 m along lane.maneuvers[0]\n")
    x = actor(fixed, "other").columns[Column.X]
    assert isinstance(x, ir.Item)
    assert isinstance(x.bundle, ir.Apply)
    assert closed_value(x.bundle.arguments[1]) == 38.0
    for longest, count in ((20, 0), (80, 1)):
        searched = compiled(f"param D = Range(5, {longest}) m\nother = new Car before intersection by D along [lane]\n")
        assert len(searched.variants[0].requirements) == count


def test_after_is_an_arc_length_beyond(compiled: Compiled) -> None:
    """`after intersection by d` lies d behind the line where the way leaves; what follows the lane heads with it."""
    way = "m = lane.maneuvers[0]\nway = [m.startLane, m.connectingLane, m.endLane]\n"
    fixed = compiled(way + "other = new Car after intersection by 12 m along way\n")
    x = actor(fixed, "other").columns[Column.X]
    assert isinstance(x, ir.Item)
    assert isinstance(x.bundle, ir.Apply)
    through = fixed.network.lanes[0].maneuvers[0].connecting_lane.length
    assert closed_value(x.bundle.arguments[1]) == pytest.approx(50.0 + through + 12.0, abs=1e-9)
    whole = compiled("other = new Car after intersection by 12 m along lane.maneuvers[0]\n")
    y = actor(whole, "other").columns[Column.X]
    assert isinstance(y, ir.Item)
    assert isinstance(y.bundle, ir.Apply)
    assert closed_value(y.bundle.arguments[1]) == closed_value(x.bundle.arguments[1])
    for longest, count in ((20, 0), (80, 1)):
        searched = compiled(
            f"param D = Range(5, {longest}) m\n{way}other = new Car after intersection by D along way\n"
        )
        assert len(searched.variants[0].requirements) == count


def test_draws_are_recorded_for_copies(compiled: Compiled) -> None:
    """A specifier that draws is a pose, or a point where the heading is given or absent."""
    scenario = compiled(
        "a = new Car on road\nb = new Car in lane, facing 1\n"
        "c = new Point in lane.centerline\nd = new OrientedPoint in road\n"
    )
    assert [site.kind for site in scenario.variants[0].draw_sites] == ["pose", "pose", "point", "point", "pose"]
    assert [len(site.values) for site in scenario.variants[0].draw_sites] == [3, 3, 2, 2, 3]


# -- objects ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [kind.name.capitalize() for kind in ActorKind])
def test_defaults_are_those_of_the_model(name: str, compiled: Compiled) -> None:
    """Every kind has the numbers of its row."""
    scenario = compiled(f"other = new {name} at (0, 0)\n")
    model = MODELS[actor(scenario, "other").kind]
    for which in (Column.LENGTH, Column.WIDTH, Column.WHEELBASE, Column.REAR_TO_CENTER, Column.MASS, Column.MAX_STEER):
        assert column(scenario, "other", which) == getattr(model, which.name.lower())
    assert column(scenario, "other", Column.SPEED) == 0.0


def test_length_scales_the_axles(compiled: Compiled) -> None:
    """A car twice as long has its axles twice as far apart, unless the file says otherwise."""
    scenario = compiled(
        "a = new Car at (0, 0), with length 9.016\nb = new Car at (0, 0), with length 9, with wheelbase 4\n"
    )
    assert column(scenario, "a", Column.WHEELBASE) == pytest.approx(2 * 2.579)
    assert column(scenario, "a", Column.REAR_TO_CENTER) == pytest.approx(2 * 1.423)
    assert column(scenario, "b", Column.WHEELBASE) == 4.0


def test_ego_is_actor_zero(alone: Compiled) -> None:
    """Wherever it stands in the file; the others keep their order."""
    scenario = alone("map intersection()\na = new Car at (0, 0)\nego = new Car ahead of a by 5\nb = new Car behind a\n")
    assert [each.name for each in scenario.variants[0].actors] == ["ego", "a", "b"]


def test_objects_without_variable_have_names(compiled: Compiled) -> None:
    """By kind and number, or by the list that holds them; always unique."""
    scenario = compiled(
        "new Truck at (0, 0)\ncars = [new Car at (i, 0) for i in range(2)]\nx = new Car at (0, 0), with name 'cars'\n"
    )
    assert [a.name for a in scenario.variants[0].actors] == ["ego", "truck2", "cars", "cars2", "cars3"]


def test_built_in_requirements_can_be_lifted(compiled: Compiled) -> None:
    """Pedestrians and obstacles may start off the road; others say so."""
    scenario = compiled(
        "a = new Car at (0, 0), with regionContainedIn None, with allowCollisions True\n"
        "b = new Pedestrian at (0, 0)\nc = new Car at (0, 0), with blueprint 'x', with color 'red'\n"
    )
    assert [x.inside_road for x in scenario.variants[0].actors] == [True, False, False, True]
    assert [x.overlap_group for x in scenario.variants[0].actors] == [1, 0, 1, 1]


# -- requirements, rules, settings ------------------------------------------------------------------------------------


def test_requirements_have_names(compiled: Compiled) -> None:
    """What the author called them, or their text on one line."""
    text = "x = Range(0, 1)\nrequire x < 0.5 as 'small'\nrequire[0.25] (x\n    > 0.1)\n"
    first, second = compiled(text).variants[0].requirements
    assert (first.name, first.line, first.probability) == ("small", 5, 1.0)
    assert (second.line, second.probability) == (6, 0.25)
    assert second.name.replace("(", "").replace(")", "") == "x > 0.1"


def test_scene_and_run_are_apart(compiled: Compiled) -> None:
    """`require` looks at the start, `terminate when` at the running simulation."""
    scenario = compiled("require ego.position.x < 3\nterminate when ego.position.x > 3\n")
    variant = scenario.variants[0]
    assert isinstance(variant.requirements[0].condition, ir.Apply)
    assert variant.requirements[0].condition.arguments[0] is variant.actors[0].columns[Column.X]
    condition = variant.rules[0].condition
    assert isinstance(condition, ir.Apply)
    state = condition.arguments[1]
    assert isinstance(state, ir.Apply)
    assert (state.op, state.immediates) == (Op.STATE, (0, 0))


def test_settings(compiled: Compiled) -> None:
    """`simulation(...)` and `terminate after`; steps become a time."""
    settings = compiled(
        "simulation(time_step=20 ms, max_attempts=100, stream='1.ga.0.2.3.0')\nterminate after 50 steps\n"
    ).settings
    assert (settings.time_step, settings.max_attempts, settings.stream) == (0.02, 100, "1.ga.0.2.3.0")
    assert settings.max_time == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("text", "spec"),
    [
        ("map intersection(ways=3, lanes=2, left_hand=True)", RoadSpec(ways=3, lanes=2, left_hand=True)),
        ("map intersection(approach=0.1 km, rows=2, block=150)", RoadSpec(approach=100.0, rows=2, block=150.0)),
    ],
)
def test_map(text: str, spec: RoadSpec, alone: Compiled) -> None:
    """Arguments of the map, with their units."""
    assert alone(f"{text}\nego = new Car at (0, 0)\n").road == spec


def test_default_map_is_what_the_file_asks_for(alone: Compiled) -> None:
    """Scenic's scripts filter by `is3Way`."""
    text = "param map = localPath('x.xodr')\ni = Uniform(*filter(lambda i: i.is3Way, network.intersections))\n"
    assert alone(text + "ego = new Car in i.incomingLanes[0].centerline\n").road == RoadSpec(ways=3)


# -- several errors ---------------------------------------------------------------------------------------------------


def test_one_mistake_is_said_once(said: Said) -> None:
    """What hangs on a mistake is not complained about; what does not, is."""
    codes = said(
        "a = 3 m + 2 s\nb = a + 1\nc = b * a\nother = new Car at (a, b)\nrequire (distance to other) < c\nd = 1 / 0\n"
    )
    assert codes == ["SCN302", "SCN401"]


def test_several_mistakes_in_one_object(said: Said) -> None:
    """Every property is looked at."""
    assert said("x = new Car at (0, 0), with sped 1, with width -1, with speed 3 kg\n") == [
        "SCN204",
        "SCN402",
        "SCN301",
    ]


def test_same_mistake_of_many_variants_is_said_once(said: Said) -> None:
    """Errors and warnings do not multiply."""
    text = "l = Uniform(*intersection.incomingLanes)\nother = new Car in l.centerline, facing 90\nl.maneuvers\n"
    assert said(text) == ["SCN320", "SCN440"]


def test_deep_sharing_is_no_trouble(compiled: Compiled) -> None:
    """Doubling a value a hundred times takes no time: shared parts are looked at once."""
    lines = "".join("x = x + x\n" for _ in range(100))
    assert compiled(f"x = Range(0, 1)\n{lines}require x < 1e40\n").variants


def test_geometry_of_the_road_is_known_at_compile_time(compiled: Compiled) -> None:
    """Lanes may be filtered by where they are."""
    text = "near = [l for l in network.lanes if (distance from (0, 20) to l.centerline) < 3 m and l.length > 20 m]\n"
    scenario = compiled(text + "other = new Car in near[0].centerline\nrequire len(near) == 2\n")
    assert isinstance(scenario.variants[0].requirements[0].condition, ir.Literal)


def test_choice_by_what_is_drawn_is_refused(said: Said) -> None:
    """Between objects only what is known at compile time can decide."""
    assert said("x = 'a' if Range(0, 1) > 0.5 else 'b'\n") == ["SCN506"]

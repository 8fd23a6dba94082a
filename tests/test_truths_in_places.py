"""Conditions where objects are placed: every operator in every place of every specifier compiles or has a code.

Operators and specifiers are those of the grammar, by the names that its alternatives have there; a new one fails here
until it has a row.
"""

import re
from contextlib import suppress
from itertools import product
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import cortex_dsl as cx
from cortex_dsl.diagnostics import CompileError
from tests.laws import examples

GRAMMAR = (Path(__file__).parent.parent / "grammar" / "cortex.lark").read_text(encoding="utf-8")
FILE = """
map intersection()
ego = new Car at (-30, -1.75), facing 0 deg, with visibleDistance 100 m
sign = new Obstacle at (-10, -1.75)
mover = new Car at (-30, -30), facing 0 deg, with speed 8 m/s, with behavior ConstantSpeedBehavior(8 m/s),
    with regionContainedIn None
spot = new OrientedPoint at (-20, 8), facing 0 deg
way = [intersection.maneuvers[0].startLane]
thing = new {kind} {specifier}
"""
TRUTHS = {
    "can_see": ("ego can see sign", "ego can see spot", "spot can see sign", "sign can see ego"),
    "intersects": ("ego intersects sign", "ego intersects road"),
    "compare": ("ego.x < 3 m", "ego in road", "sign not in road", "ego is sign", "1 <= Range(0, 2) < 2"),
    "and_": ("ego can see sign and ego in road",),
    "or_": ("ego can see sign or ego in road",),
    "unary": ("not (ego can see sign)",),
    "conditional": ("(ego can see sign if ego in road else False)",),
    "temporal": ("(always ego can see sign)",),
    "implies": ("(ego can see sign implies ego in road)",),
    "until": ("(ego can see sign until ego in road)",),
}
"""Conditions by the alternative of the grammar that they are about."""
SPECIFIERS = {
    "at": ("at ({m}, 20 m)", "at ({s})"),
    "in_region": ("in ({r})", "on ({r})"),
    "offset_by_specifier": ("offset by (5 m, {m})",),
    "offset_along_specifier": ("offset along ({a}) by (5 m, 20 m)", "offset along 10 deg by (5 m, {m})"),
    "beside": ("ahead of ego by {m}", "left of spot by {m}", "behind ({s}) by 3 m", "right of ({o})"),
    "following": ("following roadDirection for {m}", "following roadDirection from ({s}) for 3 m"),
    "before": ("before intersection by {m} along way", "before intersection by 5 m along ({w})"),
    "after": ("after intersection by {m} along [intersection.maneuvers[0].endLane]",),
    "beyond": ("beyond sign by {m}", "beyond sign by 20 m from ({s})"),
    "meeting": (
        "meeting mover at {n} after {d} by {m}, facing 90 deg, with speed 1 m/s",
        "meeting ({v}) at 0.5 after 4 s, facing 90 deg, with speed 1 m/s",
    ),
    "in_sight": ("visible", "visible from ({s})", "not visible from ({o})"),
    "contained_in": ("contained in ({r})",),
    "apparently_facing": ("at (9, 20), apparently facing {a} from ({s})", "at (9, 20), apparently facing {a}"),
    "facing": ("at (9, 20), facing {a}",),
    "facing_toward": ("at (9, 20), facing toward ({s})",),
    "facing_away": ("at (9, 20), facing away from ({s})",),
    "with_": (
        *(f"at (9, 20), with {name} {{m}}" for name in ("length", "width", "wheelbase", "visibleDistance")),
        "at (9, 20), with viewAngle {a}",
        "at (9, 20), with occluding {t}",
        "at (9, 20), with fixed {t}",
        "at (9, 20), with allowCollisions {t}",
        "at (9, 20), with requireVisible {t}",
        "at (9, 20), with mine {t}",
        "at (9, 20), with regionContainedIn ({r})",
    ),
}
"""Specifiers by the alternative of the grammar, with places for a length, an angle, a truth and other values."""
CASES = [
    (truth, specifier)
    for truths, specifiers in product(TRUTHS.values(), SPECIFIERS.values())
    for truth, specifier in product(truths, specifiers)
]


def aliases(rule: str) -> set[str]:
    """Names of the alternatives of a rule."""
    body = re.search(rf"^\??{rule}: .*?(?=^\S|\Z)", GRAMMAR, re.MULTILINE | re.DOTALL)
    assert body is not None
    return set(re.findall(r"-> (\w+)", body[0]))


def file(truth: str, specifier: str) -> str:
    values = {
        "m": f"(6 m if {truth} else 8 m)",
        "a": f"(10 deg if {truth} else 20 deg)",
        "t": f"({truth})",
        "s": f"(5, 20) if {truth} else (5, 25)",
        "n": f"(0.2 if {truth} else 0.6)",
        "d": f"(3 s if {truth} else 4 s)",
        "v": f"mover if {truth} else ego",
        "o": f"spot if {truth} else ego",
        "r": f"CircularRegion((5, 20), 9 m) if {truth} else CircularRegion((5, 30), 9 m)",
        "w": f"way if {truth} else [intersection.maneuvers[1].startLane]",
    }
    kind = "Pedestrian" if specifier.startswith("meeting") else "Obstacle"  # which moves
    return FILE.format(kind=kind, specifier=specifier.format(**values))


def test_every_operator_and_specifier_of_the_grammar_has_a_row() -> None:
    """Or the law would not know of it."""
    operators = {alias for rule in ("disjunction", "conjunction", "inversion", "comparison", "relation", "expression")
                 for alias in aliases(rule)}  # fmt: skip
    assert operators | {"implies", "until"} - {"lambda_"} == set(TRUTHS) | {"lambda_"}
    assert aliases("specifier") == set(SPECIFIERS)


@given(st.sampled_from(CASES))
@examples(300)
def test_a_condition_in_a_place_compiles_or_has_a_code(case: tuple[str, str]) -> None:
    """No other exception reaches a user; what compiles can be drawn."""
    with suppress(CompileError):  # which has a code
        cx.compile_text(file(*case)).sample(2, seed=1)


HIDDEN = """
ego = new Car at (-40, -1.75), facing 0 deg, with visibleDistance 100 m
sign = new Obstacle at (-10, -1.75)
{before}
{assigned}
thing = new Obstacle at (-40 + ({value} if {look} else 80), 20)
{after}
"""
WALL = "wall = new Obstacle at (-20, -1.75), with width 6 m, with length 1 m"


@pytest.mark.parametrize("assigned", [False, True])
@pytest.mark.parametrize("place", ["", "before", "after"])
def test_earlier_objects_hide(place: str, assigned: bool) -> None:
    """The one that is placed by what is seen, and all later ones, are not there yet; a name changes nothing."""
    look = "ego can see sign"
    parts = {"before": "", "after": "", "assigned": "", "look": look, "value": "60"}
    if assigned:
        parts |= {"assigned": f"seen = {look}", "look": "seen"}
    if place:
        parts[place] = WALL
    scenario = cx.compile_text(HIDDEN.format(**parts))
    scenes = scenario.sample(1, seed=1)
    assert scenes.valid[0]
    assert scenario.table(scenes)["thing.x [m]"][0] == (40.0 if place == "before" else 20.0)


def test_an_object_hides_what_places_a_later_one() -> None:
    """Also where it was itself placed by a look; and a requirement of the scene is about all objects."""
    text = HIDDEN.format(before="", assigned="", look="ego can see sign", value="20", after="")
    text = text.replace(", 20)", ", -1.75), with width 6 m")
    scenario = cx.compile_text(f"{text}last = new Obstacle at ((50 if ego can see sign else 60), 20)\n")
    scenes = scenario.sample(1, seed=1)
    assert scenario.table(scenes)["thing.x [m]"][0] == -20.0
    assert scenario.table(scenes)["last.x [m]"][0] == 60.0
    assert not cx.compile_text(f"{text}require ego can see sign\n").sample(1, seed=1).valid[0]

"""Classes of one's own: defaults are evaluated anew for every object, in any order, and checked as `with` is."""

from collections.abc import Callable

import pytest

from cortex_dsl import ir
from engine.vocabulary import ActorKind, Column
from tests.cortex_dsl.semantics.conftest import EGO, HEADER, findings

Compiled = Callable[..., ir.Scenario]
Said = Callable[[str], list[str]]

TAXI = """
class Taxi(Car):
    width: 1.7 m
    gap: Range(3, 9) m
    speed: self.gap / 1 s
"""


def test_every_object_draws_its_own_defaults(compiled: Compiled) -> None:
    """Two objects of a class share nothing but the text of their defaults."""
    (variant,) = compiled(TAXI + "a = new Taxi at (3 m, 2 m)\nb = new Taxi at (30 m, 2 m)\n").variants
    first, second = (actor.columns[Column.SPEED] for actor in variant.actors[1:])
    assert first is not second
    assert [site.span for site in variant.draw_sites].count(variant.draw_sites[-1].span) == 2


def test_with_beats_class_beats_base(compiled: Compiled) -> None:
    """The nearest word counts: `with`, then the class, then what it is made of, then the kind."""
    text = TAXI + "class Old(Taxi):\n    width: 1.6 m\n\na = new Old at (9 m, 2 m), with gap 4\nrequire a.gap < 5 m\n"
    (variant,) = compiled(text).variants
    actor = variant.actors[1]
    numbers = [actor.columns[column] for column in (Column.WIDTH, Column.SPEED)]
    assert [each.value for each in numbers if isinstance(each, ir.Literal)] == [1.6, 4.0]
    assert actor.kind == ActorKind.CAR


def test_class_without_base_is_a_thing(compiled: Compiled) -> None:
    (variant,) = compiled(
        "class Box:\n    load: 3 kg\n\nbox = new Box at (9 m, 2 m)\nrequire box.load > 1 kg\n"
    ).variants
    assert variant.actors[1].kind == ActorKind.OBSTACLE


def test_class_may_say_where_its_objects_are(compiled: Compiled) -> None:
    """`position` and `heading` have defaults too; other properties may look at them."""
    text = "class Post:\n    position: (9 m, 2 m)\n    heading: 30 deg\n    length: self.x / 9\n\npost = new Post\n"
    (variant,) = compiled(text).variants
    columns = variant.actors[1].columns
    known = [columns[each] for each in (Column.X, Column.Y, Column.LENGTH)]
    assert [each.value for each in known if isinstance(each, ir.Literal)] == [9.0, 2.0, 1.0]


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("class T(Car):\n    width: -2 m\n\nb = new T at (9, 2)\n", "SCN402"),
        ("class T(Car):\n    width: 2 kg\n\nb = new T at (9, 2)\n", "SCN301"),
        ("class T(Car):\n    width: 2 m\n    width: 3 m\n", "SCN410"),
        ("class T(Card):\n    width: 2 m\n", "SCN207"),
        ("class T(Point):\n    gap: 2 m\n", "SCN427"),
        ("class T(Car):\n    throttle: 0.2\n", "SCN430"),
        ("class T(Car):\n    gap: 2 m\n\nb = new T at (9, 2), with gop 3\n", "SCN204"),
        ("b = new T at (9, 2)\nclass T(Car):\n    gap: 2 m\n", "SCN207"),
        ("class T(Car):\n    gap: self.gop\n\nb = new T at (9, 2)\n", "SCN203"),
    ],
)
def test_mistakes_in_classes_are_reported(said: Said, text: str, code: str) -> None:
    assert code in said(text)


def test_unknown_class_names_the_own_ones(answered: Callable[..., list[tuple[str, str]]]) -> None:
    found = answered("b = new Taxo at (9, 2)\n", TAXI)
    assert ("SCN207", "did you mean `Taxi`?") in found


@pytest.mark.parametrize(
    ("made", "named"), [("Truck", "a Truck"), ("Obstacle", "an Obstacle"), ("Owl", "an Owl"), ("Taxi", "a Taxi")]
)
def test_a_message_names_a_class_with_its_article(made: str, named: str) -> None:
    text = f"{TAXI}class Owl(Car):\n    width: 1.6 m\n\nnew {made} at (9 m, 2 m), with colr 3\n"
    assert f"{named} has no property `colr`" in [found.message for found in findings(HEADER + EGO + text)]
